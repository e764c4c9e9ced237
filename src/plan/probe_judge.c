/* A probe's pixels, resolved as Eq. 1 says and as a method would. */
#include "plan/offer.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/prepare.h"

#define CELL_PIXELS (PROBE_CELL * PROBE_CELL)

/* Fragments of the fullest pixel. */
static size_t most_fragments(const struct probe *probe)
{
    size_t most = 1;
    for (size_t i = 0; i < probe->pixels; i++)
        if (probe->first[i + 1] - probe->first[i] > most)
            most = probe->first[i + 1] - probe->first[i];
    return most;
}

static size_t local_index(const struct probe *probe, uint32_t id)
{
    size_t low = 0, high = probe->splats;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (probe->splat[middle] <= id)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* What a judgement needs beside the probe. */
struct judging {
    const struct probe *probe;
    const struct stp_plan *plan;
    probe_keep_fn keep;
    const uint8_t *group;
    bool local;
    unsigned most_layers;
    double slack;
    struct probe_fragment *scratch;
};

static double difference(const double a[3], const double b[3])
{
    return (fabs(a[0] - b[0]) + fabs(a[1] - b[1]) + fabs(a[2] - b[2])) / 3;
}

static double pixel_error(const struct judging *j, size_t pixel)
{
    const struct probe *probe = j->probe;
    size_t first = probe->first[pixel], count = probe->first[pixel + 1] - first;
    memcpy(j->scratch, &probe->fragment[first], count * sizeof *j->scratch);
    for (size_t i = 0; j->group && i < count; i++) {
        uint32_t id = j->scratch[i].splat;
        j->scratch[i].group = j->group[j->local ? local_index(probe, id) : id];
    }
    j->keep(j->plan, j->scratch, count);
    const struct probe_pixel of = { j->scratch, count, j->most_layers, j->slack };
    double color[3];
    probe_resolve(probe, pixel, &of, color);
    return difference(color, &probe->truth[3 * pixel]);
}

/* The mean of a ratio: errors over covered pixels, both summed by cell. */
static void summarise(const double *sum, const unsigned *covered, unsigned cells,
                      struct probe_error *error)
{
    double total = 0, squares = 0;
    *error = (struct probe_error){ 0 };
    for (unsigned c = 0; c < cells; c++) {
        total += sum[c];
        error->pixels += covered[c];
    }
    if (!error->pixels)
        return;
    error->mean = total / (double)error->pixels;
    for (unsigned c = 0; c < cells; c++) {
        double off = sum[c] - error->mean * covered[c];
        squares += off * off;
    }
    error->spread = sqrt(squares) / (double)error->pixels;
}

enum stp_result probe_judge(const struct stp_env *env, const struct probe *probe,
                            const struct stp_plan *plan, probe_keep_fn keep, const uint8_t *group,
                            bool local, struct probe_error *error)
{
    size_t most = most_fragments(probe), cells = probe->cells ? probe->cells : 1;
    bool peels = plan->transparency == STP_TRANSPARENCY_PEEL, steps = plan->constant[PLAN_PACKED];
    struct judging j = { probe, plan, keep, group, local, UINT32_MAX, 0, NULL };
    if (peels)
        j.most_layers = plan_repeats(plan);
    if (steps && probe->view.transparent)
        j.slack = 0.25 / (double)plan->frame.depth_scale;
    double *sum = mem_zalloc(cells, sizeof *sum);
    unsigned *covered = mem_zalloc(cells, sizeof *covered);
    j.scratch = mem_alloc(most, sizeof *j.scratch);
    bool made = sum && covered && j.scratch;
    for (size_t i = 0; made && i < probe->pixels; i++) {
        if (probe->first[i + 1] == probe->first[i])
            continue;
        sum[i / CELL_PIXELS] += pixel_error(&j, i);
        covered[i / CELL_PIXELS]++;
    }
    if (made)
        summarise(sum, covered, probe->cells, error);
    mem_free(sum);
    mem_free(covered);
    mem_free(j.scratch);
    return made ? STP_OK : log_no_memory(env, most * sizeof *j.scratch, "judging a probe");
}

enum stp_result probe_compare(const struct stp_env *env, const struct probe *probe,
                              const struct probe_color *color, struct probe_error *error)
{
    size_t cells = probe->cells ? probe->cells : 1;
    double *sum = mem_zalloc(cells, sizeof *sum);
    unsigned *covered = mem_zalloc(cells, sizeof *covered);
    bool made = sum && covered;
    for (size_t i = 0; made && i < probe->pixels; i++) {
        if (probe->first[i + 1] == probe->first[i] && !color[i].covered)
            continue;
        sum[i / CELL_PIXELS] += difference(color[i].color, &probe->truth[3 * i]);
        covered[i / CELL_PIXELS]++;
    }
    if (made)
        summarise(sum, covered, probe->cells, error);
    mem_free(sum);
    mem_free(covered);
    return made ? STP_OK : log_no_memory(env, cells * sizeof *sum, "judging a probe");
}

static enum stp_result judge_drawn(const struct stp_env *env, const struct probe *probe,
                                   const struct stp_plan *plan, plan_draw_fn draw,
                                   struct probe_error *error)
{
    struct probe_color *color = mem_zalloc(probe->pixels ? probe->pixels : 1, sizeof *color);
    if (!color)
        return log_no_memory(env, probe->pixels * sizeof *color, "drawing a probe");
    enum stp_result result = draw(env, probe, plan, color);
    if (result == STP_OK)
        result = probe_compare(env, probe, color, error);
    mem_free(color);
    return result;
}

enum stp_result plan_judge(const struct stp_env *env, const struct probe *probe,
                           const struct stp_plan *plan, const uint8_t *group, bool local,
                           struct probe_error *error)
{
    const struct plan_offer *offer = plan_offer_of(plan);
    return offer->draw ? judge_drawn(env, probe, plan, offer->draw, error)
                       : probe_judge(env, probe, plan, offer->keep, group, local, error);
}

/* The probe's splats as a scene of their own; arrays are the caller's to release. */
static bool copy_splats(const struct probe *probe, struct splats *out)
{
    const struct splats *in = &probe->view.scene->splats;
    size_t n = probe->splats;
    *out = (struct splats){ .count = n };
    out->position = mem_alloc(n, sizeof *out->position);
    out->normal = mem_alloc(n, sizeof *out->normal);
    out->radius = mem_alloc(n, sizeof *out->radius);
    out->color = in->color ? mem_alloc(n, sizeof *out->color) : NULL;
    out->object = in->object ? mem_alloc(n, sizeof *out->object) : NULL;
    out->phong = in->phong ? mem_alloc(n, sizeof *out->phong) : NULL;
    if (!out->position || !out->normal || !out->radius || (in->color && !out->color) ||
        (in->object && !out->object) || (in->phong && !out->phong))
        return false;
    for (size_t i = 0; i < n; i++) {
        uint32_t id = probe->splat[i];
        memcpy(out->position[i], in->position[id], sizeof *out->position);
        memcpy(out->normal[i], in->normal[id], sizeof *out->normal);
        out->radius[i] = in->radius[id];
        if (in->color)
            memcpy(out->color[i], in->color[id], sizeof *out->color);
        if (in->object)
            out->object[i] = in->object[id];
        if (in->phong)
            out->phong[i] = in->phong[id];
    }
    return true;
}

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

enum stp_result probe_group(const struct stp_env *env, const struct probe *probe,
                            const struct stp_group_params *params, uint8_t **group,
                            struct stp_grouping *facts)
{
    /* What a part of the scene warns of, the scene will warn of when it is grouped. */
    const struct stp_env quiet = { .threads = env ? env->threads : 0, .log = swallow };
    struct stp_scene part = { .prepared = true };
    enum stp_result result =
        copy_splats(probe, &part.splats) ? group_scene(&quiet, &part, params) : STP_ERROR_MEMORY;
    if (result == STP_OK) {
        *group = part.splats.group;
        *facts = part.facts.grouping;
        part.splats.group = NULL;
    } else if (result == STP_ERROR_MEMORY)
        log_no_memory(env, probe->splats * sizeof *part.splats.position, "grouping a probe");
    splats_release(&part.splats);
    return result;
}
