#include "prepare/phong_orient.h"

#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/orient.h"
#include "prepare/phong_holders.h"

static int by_id(const void *a, const void *b)
{
    uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
    return (p > q) - (p < q);
}

#define SEEN 4096 /* holders looked at, of a patch */

struct row {
    size_t count;
    uint32_t patch[SEEN];
};

static void add_holders(const struct holders *h, uint32_t site, uint32_t self, struct row *row)
{
    for (size_t i = h->begin[site]; i < h->begin[site + 1] && row->count < SEEN; i++)
        if (h->patch[i] != self)
            row->patch[row->count++] = h->patch[i];
}

/* The SURROUND_GRAPH patches that come most often, most often first. */
static void most_frequent(struct row *row, uint32_t neighbour[SURROUND_GRAPH])
{
    size_t often[SURROUND_GRAPH] = { 0 };
    qsort(row->patch, row->count, sizeof *row->patch, by_id);
    for (unsigned k = 0; k < SURROUND_GRAPH; k++)
        neighbour[k] = NO_NEIGHBOUR;
    for (size_t i = 0, end; i < row->count; i = end) {
        for (end = i; end < row->count && row->patch[end] == row->patch[i]; end++)
            ;
        unsigned at = SURROUND_GRAPH;
        for (; at > 0 && often[at - 1] < end - i; at--)
            if (at < SURROUND_GRAPH) {
                often[at] = often[at - 1];
                neighbour[at] = neighbour[at - 1];
            }
        if (at < SURROUND_GRAPH) {
            often[at] = end - i;
            neighbour[at] = row->patch[i];
        }
    }
}

static void find_neighbours(const struct fit_cloud *cloud, const struct patch_set *set,
                            const struct holders *h, struct row *row, struct surroundings *all)
{
    for (size_t i = 0; i < set->count; i++) {
        const struct patch *p = &set->patch[i];
        row->count = 0;
        for (uint32_t k = 0; k < p->count; k++) {
            add_holders(h, p->member[k], (uint32_t)i, row);
            for (unsigned n = 0; n < SITE_NEAR; n++)
                if (cloud->near[p->member[k]][n] != NO_SITE)
                    add_holders(h, cloud->near[p->member[k]][n], (uint32_t)i, row);
        }
        most_frequent(row, all->neighbour[i]);
    }
}

/* The other side: u stays, so v and t change sign. */
static void turn(struct stp_phong_splat *phong)
{
    phong->field[0] = -phong->field[0];
    phong->field[1] = -phong->field[1];
    phong->field[3] = -phong->field[3];
    for (unsigned i = 0; i < phong->clips; i++)
        phong->clip[i][1] = -phong->clip[i][1];
}

static void take_sides(const struct surroundings *all, struct splats *splats)
{
    for (size_t i = 0; i < splats->count; i++) {
        if (memcmp(all->normal[i], splats->normal[i], sizeof splats->normal[i]) == 0)
            continue;
        memcpy(splats->normal[i], all->normal[i], sizeof splats->normal[i]);
        turn(&splats->phong[i]);
    }
}

enum stp_result splats_orient(const struct stp_env *env, const struct fit_cloud *cloud,
                              const struct patch_set *set, struct vec3 up, struct splats *splats)
{
    size_t count = splats->count;
    struct places places = { .count = count, .position = (const double(*)[3])splats->position };
    struct surroundings all = { mem_alloc(count, sizeof *all.normal),
                                mem_alloc(count, sizeof *all.spacing),
                                mem_alloc(count, sizeof *all.neighbour) };
    struct row *row = mem_alloc(1, sizeof *row);
    struct holders h = { 0 };
    enum stp_result result = STP_OK;
    if (!all.normal || !all.spacing || !all.neighbour || !row)
        result = log_no_memory(env, count * sizeof *all.neighbour, "the sides of splats");
    if (result == STP_OK)
        result = holders_find(env, cloud, set, &h);
    if (result == STP_OK) {
        memset(all.neighbour, 0xff, count * sizeof *all.neighbour);
        memcpy(all.normal, splats->normal, count * sizeof *all.normal);
        memcpy(all.spacing, splats->radius, count * sizeof *all.spacing);
        find_neighbours(cloud, set, &h, row, &all);
        result = orient_normals(env, &places, &all, up);
    }
    if (result == STP_OK)
        take_sides(&all, splats);
    holders_release(&h);
    mem_free(row);
    surroundings_release(&all);
    return result;
}
