/* A probe's pixels, resolved as Eq. 1 says and as a method would. */
#include "plan/offer.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/prepare.h"

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
    float color_steps;
    size_t most;                    /* fragments of a pixel */
    struct probe_fragment *scratch; /* so many for each thread */
    struct probe_tally *tally;      /* one a cell */
};

static double difference(const double a[3], const double b[3])
{
    return (fabs(a[0] - b[0]) + fabs(a[1] - b[1]) + fabs(a[2] - b[2])) / 3;
}

/* As the method draws the pixel, in exact or in perturbed arithmetic. False: nothing is left. */
static bool draw_pixel(const struct judging *j, size_t pixel, bool perturbed,
                       struct probe_fragment *scratch, double color[3])
{
    const struct probe *probe = j->probe;
    size_t first = probe->first[pixel], count = probe->first[pixel + 1] - first;
    memcpy(scratch, &probe->fragment[first], count * sizeof *scratch);
    for (size_t i = 0; j->group && i < count; i++) {
        uint32_t id = scratch[i].splat;
        scratch[i].group = j->group[j->local ? local_index(probe, id) : id];
    }
    if (perturbed)
        count = probe_perturb(probe, scratch, count);
    if (count)
        j->keep(j->plan, scratch, count);
    const struct probe_pixel of = { scratch, count, j->most_layers, j->slack, j->color_steps };
    return probe_resolve(probe, pixel, &of, color) > 0;
}

/* A pixel that perturbation uncovers stands for one, as far off its outline, that it would cover.
 */
static void judge_pixel(const struct judging *j, size_t pixel, struct probe_fragment *scratch,
                        struct probe_tally *cell)
{
    const double *truth = &j->probe->truth[3 * pixel];
    double color[3], other[3], times = j->probe->amplify;
    draw_pixel(j, pixel, false, scratch, color);
    bool covered = draw_pixel(j, pixel, true, scratch, other);
    double error = difference(color, truth);
    double growth = (difference(other, truth) - error) * (covered ? 1 : 2);
    cell->e += error;
    cell->n++;
    cell->growth += growth / times;
    cell->growth2 += growth * growth / times;
    cell->tossed += times;
    for (int k = 0; k < 3; k++)
        cell->bright[k] = fmax(cell->bright[k], fmax(truth[k], color[k]));
}

static void judge_cells(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct judging *j = context;
    struct probe_fragment *scratch = j->scratch + j->most * worker;
    for (size_t i = begin * PROBE_CELL_PIXELS; i < end * PROBE_CELL_PIXELS; i++)
        if (j->probe->first[i + 1] > j->probe->first[i])
            judge_pixel(j, i, scratch, &j->tally[i / PROBE_CELL_PIXELS]);
}

static void compare_cell(const struct probe *probe, size_t cell, const struct probe_color *color,
                         struct probe_tally *tally)
{
    for (size_t i = cell * PROBE_CELL_PIXELS; i < (cell + 1) * PROBE_CELL_PIXELS; i++) {
        if (probe->first[i + 1] == probe->first[i] && !color[i].covered)
            continue;
        tally->e += difference(color[i].color, &probe->truth[3 * i]);
        tally->n++;
    }
}

/* The mean of a ratio: errors over covered pixels, both summed by cell. Cells that are taken from a
 * finite number of them tell the more the fewer are left. */
static void conclude(const struct probe_tally *t, struct probe_error *error)
{
    *error = (struct probe_error){ .tally = *t };
    if (!(t->n > 0))
        return;
    error->pixels = (size_t)t->n;
    error->mean = t->e / t->n;
    double squares = t->ee - 2 * error->mean * t->en + error->mean * error->mean * t->nn;
    double left = t->all_cells > t->cells ? 1 - t->cells / t->all_cells : 0;
    error->spread = sqrt(fmax(squares, 0) * left) / t->n;
    error->rounding = probe_rounding(t);
    error->flips = probe_flips(t);
}

static void add(struct probe_tally *sum, const struct probe_tally *t)
{
    sum->cells += t->cells;
    sum->e += t->e;
    sum->n += t->n;
    sum->ee += t->ee;
    sum->en += t->en;
    sum->nn += t->nn;
    sum->most = fmax(sum->most, t->most);
    sum->growth += t->growth;
    sum->growth2 += t->growth2;
    sum->tossed += t->tossed;
    for (int k = 0; k < 3; k++)
        sum->bright[k] = fmax(sum->bright[k], t->bright[k]);
}

/* In the order of the cells, whichever thread did them. */
static void summarise(const struct probe *probe, struct probe_tally *cell,
                      struct probe_error *error)
{
    struct probe_tally sum = { .all_cells = probe->all_cells };
    for (unsigned c = 0; c < probe->cells; c++) {
        struct probe_tally *t = &cell[c];
        t->cells = 1;
        t->ee = t->e * t->e;
        t->en = t->e * t->n;
        t->nn = t->n * t->n;
        t->most = t->e;
        add(&sum, t);
    }
    conclude(&sum, error);
}

void probe_error_join(struct probe_error *error, const struct probe_error *part)
{
    struct probe_tally both = error->tally;
    add(&both, &part->tally);
    conclude(&both, error);
}

enum stp_result probe_judge(const struct stp_env *env, const struct probe *probe,
                            const struct stp_plan *plan, probe_keep_fn keep, const uint8_t *group,
                            bool local, struct probe_error *error)
{
    size_t cells = probe->cells ? probe->cells : 1, threads = thread_count(env);
    bool peels = plan->transparency == STP_TRANSPARENCY_PEEL, steps = plan->constant[PLAN_PACKED];
    struct judging j = { .probe = probe,
                         .plan = plan,
                         .keep = keep,
                         .group = group,
                         .local = local,
                         .most_layers = UINT32_MAX,
                         .most = most_fragments(probe) };
    if (peels)
        j.most_layers = plan_repeats(plan);
    if (steps)
        j.slack = 0.25 / (double)plan->frame.depth_scale;
    if (plan->constant[PLAN_COLOR_CODES])
        j.color_steps = STP_COLOR_STEPS;
    j.tally = mem_zalloc(cells, sizeof *j.tally);
    j.scratch = mem_alloc(j.most * threads, sizeof *j.scratch);
    bool made = j.tally && j.scratch;
    if (made) {
        parallel_for(env, probe->cells, 16, judge_cells, &j);
        summarise(probe, j.tally, error);
    }
    mem_free(j.tally);
    mem_free(j.scratch);
    return made ? STP_OK
                : log_no_memory(env, j.most * threads * sizeof *j.scratch, "judging a probe");
}

/* Of a picture drawn by other means, over the pixels that it or the truth covers; color: one a
 * pixel. */
static enum stp_result compare(const struct stp_env *env, const struct probe *probe,
                               const struct probe_color *color, struct probe_error *error)
{
    size_t cells = probe->cells ? probe->cells : 1;
    struct probe_tally *tally = mem_zalloc(cells, sizeof *tally);
    if (!tally)
        return log_no_memory(env, cells * sizeof *tally, "judging a probe");
    for (unsigned c = 0; c < probe->cells; c++)
        compare_cell(probe, c, color, &tally[c]);
    summarise(probe, tally, error);
    mem_free(tally);
    return STP_OK;
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
        result = compare(env, probe, color, error);
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

enum stp_result probe_group(const struct stp_env *env, const struct probe *probe,
                            const struct stp_group_params *params, uint8_t **group,
                            struct stp_grouping *facts)
{
    /* What a part of the scene warns of, the scene will warn of when it is grouped. */
    const struct stp_env quiet = { .threads = env ? env->threads : 0, .log = log_nothing };
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
