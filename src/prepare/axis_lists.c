#include "prepare/axis_lists.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/axis_region.h"
#include "prepare/radix.h"

void axis_lists_release(struct axis_lists *lists)
{
    mem_free(lists->order);
    mem_free(lists->mask);
    mem_free(lists->span);
    mem_free(lists->open);
    for (int a = 0; a < 3; a++) {
        mem_free(lists->sheets[a].first);
        mem_free(lists->sheets[a].kernel);
    }
    *lists = (struct axis_lists){ 0 };
}

unsigned axis_dominant(struct vec3 v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

/* Ellipsoids and discs lie anywhere: sorted along the axis, once for all views. */
static enum stp_result sort_scattered(const struct stp_env *env, size_t count,
                                      const double (*place)[3], unsigned axis,
                                      struct axis_sheets *sheets)
{
    uint32_t *first = mem_zalloc(2, sizeof *first);
    uint32_t *kernel = mem_alloc(count, sizeof *kernel);
    uint64_t *key = mem_alloc(count, sizeof *key);
    enum stp_result result = STP_OK;
    if (!first || !kernel || !key)
        result = log_no_memory(env, count * 12, "the order along an axis");
    for (size_t i = 0; result == STP_OK && i < count; i++) {
        key[i] = radix_ascending(place[i][axis]);
        kernel[i] = (uint32_t)i;
    }
    if (result == STP_OK)
        result = radix_sort(env, count, key, kernel);
    mem_free(key);
    if (result != STP_OK) {
        mem_free(first);
        mem_free(kernel);
        return result;
    }
    first[1] = (uint32_t)count;
    *sheets = (struct axis_sheets){ first, kernel };
    return STP_OK;
}

/* A counting sort, but across z, where kernels are in the order of their sheets already. */
static enum stp_result sort_voxels(const struct stp_env *env, const struct volume *volume,
                                   unsigned axis, struct axis_sheets *sheets)
{
    const struct kernels *k = &volume->kernels;
    uint32_t at[3], sum = 0, count = volume->grid.dims[axis];
    uint32_t *first = mem_zalloc((size_t)count + 1, sizeof *first);
    uint32_t *kernel = axis < 2 ? mem_alloc(k->count, sizeof *kernel) : NULL;
    if (!first || (axis < 2 && !kernel)) {
        mem_free(first);
        mem_free(kernel);
        return log_no_memory(env, (k->count + count) * sizeof *kernel, "an axis's sheets");
    }
    for (size_t i = 0; i < k->count; i++) {
        voxel_place(&volume->grid, k->voxel[i], at);
        first[at[axis]]++;
    }
    for (uint32_t n = 0; n < count; n++) {
        uint32_t own = first[n];
        first[n] = sum;
        sum += own;
    }
    for (size_t i = 0; kernel && i < k->count; i++) {
        voxel_place(&volume->grid, k->voxel[i], at);
        kernel[first[at[axis]]++] = (uint32_t)i;
    }
    if (kernel) /* each has come to where the next begins */
        memmove(first + 1, first, count * sizeof *first);
    first[0] = 0;
    first[count] = sum;
    *sheets = (struct axis_sheets){ first, kernel };
    return STP_OK;
}

static enum stp_result make_sheets(const struct stp_env *env, const struct stp_scene *scene,
                                   unsigned axis, struct axis_sheets *sheets)
{
    if (sheets->first)
        return STP_OK;
    switch (axis_shape(scene)) {
    case AXIS_VOXELS:
        return sort_voxels(env, scene->volume, axis, sheets);
    case AXIS_ELLIPSOIDS:
        return sort_scattered(env, scene->volume->kernels.count,
                              (const double(*)[3])scene->volume->kernels.place, axis, sheets);
    case AXIS_DISCS:
        break;
    }
    return sort_scattered(env, scene->splats.count, (const double(*)[3])scene->splats.position,
                          axis, sheets);
}

struct filling {
    const struct stp_scene *scene;
    const struct axis_lists *lists;
};

/* The same of ellipsoids and discs; of equal ones the order is that of every view. */
static void fill_scattered(const struct filling *f, const struct axis_walk *walk)
{
    const struct axis_lists *lists = f->lists;
    const uint32_t *kernel = lists->sheets[walk->axis].kernel;
    size_t count = axis_kernels(f->scene);
    uint32_t *out = lists->order + walk->first;
    for (size_t n = 0; n < count; n++) {
        uint32_t k = kernel[walk->backwards ? n : count - 1 - n];
        if (lists->mask[k] >> axis_walk_bit(walk) & 1)
            *out++ = k;
    }
}

/* Far to near along the axis; within a sheet from the last kernel to the first, since of equal ones
 * the first is the nearer. */
static void fill_walk(const struct filling *f, const struct axis_walk *walk)
{
    const struct axis_lists *lists = f->lists;
    const struct axis_sheets *sheets = &lists->sheets[walk->axis];
    uint32_t count = f->scene->volume->grid.dims[walk->axis], *out = lists->order + walk->first;
    unsigned bit = axis_walk_bit(walk);
    for (uint32_t n = 0; n < count; n++) {
        uint32_t sheet = walk->backwards ? n : count - 1 - n;
        for (uint32_t i = sheets->first[sheet + 1]; i-- > sheets->first[sheet];) {
            uint32_t k = sheets->kernel ? sheets->kernel[i] : i;
            if (lists->mask[k] >> bit & 1)
                *out++ = k;
        }
    }
}

static void fill_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct filling *f = context;
    for (size_t w = begin; w < end; w++)
        if (axis_shape(f->scene) == AXIS_VOXELS)
            fill_walk(f, &f->lists->walk[w]);
        else
            fill_scattered(f, &f->lists->walk[w]);
}

struct keying {
    struct axis_view view;
    const uint32_t *order;
    uint64_t *key;
};

static void key_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct keying *k = context;
    const struct stp_camera *camera = k->view.camera;
    for (size_t i = begin; i < end; i++) {
        double world[3];
        axis_centre(&k->view, k->order[i], world);
        struct vec3 c = m4_point(camera->world_to_camera, v3_load(world));
        k->key[i] = ~radix_ascending(camera->orthographic ? -c.z : v3_dot(c, c));
    }
}

/* By distance from the eye, far to near; of equal ones the first is the nearer. */
static enum stp_result fill_sorted(const struct stp_env *env, const struct stp_scene *scene,
                                   const struct stp_camera *camera, struct axis_lists *lists)
{
    struct keying k = { axis_view(scene, camera), lists->order,
                        mem_alloc(lists->count, sizeof *k.key) };
    uint32_t n = 0;
    if (!k.key)
        return log_no_memory(env, lists->count * sizeof *k.key, "distances");
    for (size_t i = axis_kernels(scene); i-- > 0;)
        if (lists->mask[i])
            lists->order[n++] = (uint32_t)i;
    parallel_for(env, lists->count, 16384, key_range, &k);
    enum stp_result result = radix_sort(env, n, k.key, lists->order);
    mem_free(k.key);
    return result;
}

static void count_walks(struct axis_lists *lists)
{
    size_t count[AXIS_WALKS] = { 0 };
    lists->visible = lists->count = lists->walk_count = 0;
    for (unsigned m = 1; m < 1 << AXIS_WALKS; m++) {
        lists->visible += lists->masks[m];
        for (unsigned w = 0; w < AXIS_WALKS; w++)
            count[w] += m >> w & 1 ? lists->masks[m] : 0;
    }
    for (unsigned w = 0; w < AXIS_WALKS; w++) {
        if (count[w] == 0)
            continue;
        lists->walk[lists->walk_count++] = (struct axis_walk){ .axis = (uint8_t)(w / 2),
                                                               .backwards = w % 2 != 0,
                                                               .first = (uint32_t)lists->count,
                                                               .count = (uint32_t)count[w] };
        lists->count += count[w];
    }
}

static enum stp_result make_room(const struct stp_env *env, struct axis_lists *lists)
{
    if (lists->count >= UINT32_MAX / 3)
        return log_error(env, STP_ERROR_ARGUMENT, "%zu splats in the axis lists: at most %u",
                         lists->count, UINT32_MAX / 3);
    if (lists->count <= lists->room)
        return STP_OK;
    mem_free(lists->order);
    lists->order = mem_alloc(lists->count, sizeof *lists->order);
    lists->room = lists->order ? lists->count : 0;
    return lists->order ? STP_OK
                        : log_no_memory(env, lists->count * sizeof *lists->order, "the axis lists");
}

static enum stp_result fill_walks(const struct stp_env *env, const struct stp_scene *scene,
                                  const struct stp_camera *camera, struct axis_lists *lists)
{
    struct filling filling = { scene, lists };
    enum stp_result result = make_room(env, lists);
    if (result == STP_OK && lists->merge == STP_AXIS_SORT)
        return lists->count ? fill_sorted(env, scene, camera, lists) : STP_OK;
    for (unsigned w = 0; result == STP_OK && w < lists->walk_count; w++) {
        unsigned axis = lists->walk[w].axis;
        result = make_sheets(env, scene, axis, &lists->sheets[axis]);
    }
    if (result == STP_OK)
        parallel_for(env, lists->walk_count, 1, fill_range, &filling);
    return result;
}

enum stp_result axis_lists_update(const struct stp_env *env, const struct stp_scene *scene,
                                  const struct stp_camera *camera, struct axis_lists *lists)
{
    enum stp_result result = axis_sift(env, scene, camera, lists);
    if (result == STP_OK) {
        count_walks(lists);
        result = fill_walks(env, scene, camera, lists);
    }
    if (result != STP_OK)
        axis_lists_release(lists);
    return result;
}
