/* Which pixels are probed, and all their fragments. */
#include "plan/probe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/mix.h"
#include "base/thread.h"
#include "reference/reference.h"

#define BLOCK_CELLS (PROBE_ACROSS * PROBE_ACROSS)
#define MANY_CELLS  1024 /* a box of more is taken to hold one of the probe */

/* While a probe is made. */
struct making {
    const struct stp_env *env;
    struct probe *probe;
    const struct survey *survey;
    struct spot_view spots;
    uint32_t *cell_of;      /* of each place where one may be, row by row */
    uint8_t *near_cell;     /* of each splat */
    size_t capacity, count; /* fragments */
};

static unsigned common_divisor(unsigned a, unsigned b)
{
    return b ? common_divisor(b, a % b) : a;
}

/* How far apart in a run the cells of successive parts lie: evenly, however many parts are taken
 * (the golden section), and none twice. */
static unsigned stride_of(unsigned parts)
{
    unsigned stride = (unsigned)(0.618 * parts) + 1;
    while (common_divisor(stride, parts) != 1)
        stride++;
    return stride;
}

static size_t place_of(const struct making *m, const uint32_t corner[2])
{
    return (size_t)(corner[1] / PROBE_CELL) * m->survey->across * PROBE_ACROSS +
           corner[0] / PROBE_CELL;
}

/* As many as are asked for, or as the fragments leave memory for. */
static unsigned cells_of(const struct survey *survey, size_t places,
                         const struct probe_sample *sample)
{
    double most = sample->fragments > 0 ? sample->fragments : PROBE_FRAGMENTS;
    double each = places ? survey->fragments / (double)places : 0;
    double fit = fmax(each > 0 ? most / each : INFINITY, PROBE_LEAST_CELLS);
    return fit < sample->cells ? (unsigned)fit : sample->cells;
}

/* Stratified: the places of the touched blocks, block by block, fall into runs of one place for
 * each part. Which is whose differs from run to run. The touched blocks are listed in `cell_of`,
 * before that becomes the map. */
static void place_cells(struct making *m, const struct probe_sample *sample)
{
    const struct survey *s = m->survey;
    struct probe *p = m->probe;
    size_t blocks = (size_t)s->across * s->down, touched = 0;
    for (size_t b = 0; b < blocks; b++)
        if (s->mass[b] > 0)
            m->cell_of[touched++] = (uint32_t)b;
    size_t places = touched * BLOCK_CELLS;
    unsigned cells = cells_of(s, places, sample);
    unsigned parts = places ? (unsigned)((places + cells - 1) / cells) : 1;
    uint64_t turn = (uint64_t)sample->part * stride_of(parts);
    for (size_t run = 0; run * parts < places; run++) {
        size_t at = run * parts + (turn + mix_bits((uint32_t)run + 1)) % parts;
        if (at >= places) /* the last run is short */
            continue;
        uint32_t b = m->cell_of[at / BLOCK_CELLS], k = at % BLOCK_CELLS;
        p->corner[p->cells][0] = b % s->across * SURVEY_BLOCK + k % PROBE_ACROSS * PROBE_CELL;
        p->corner[p->cells++][1] = b / s->across * SURVEY_BLOCK + k / PROBE_ACROSS * PROBE_CELL;
    }
    for (size_t i = 0; i < blocks * BLOCK_CELLS; i++)
        m->cell_of[i] = PROBE_NO_CELL;
    for (unsigned c = 0; c < p->cells; c++)
        m->cell_of[place_of(m, p->corner[c])] = c;
    p->parts = parts;
    p->amplify = probe_amplify(sample, parts);
    p->all_cells = (double)places;
    p->pixels = (size_t)p->cells * PROBE_CELL_PIXELS;
}

/* Calls for every cell that the pixels [x0, x1] x [y0, y1] may touch. */
typedef void (*cell_fn)(void *context, uint32_t cell);
static void each_cell(const struct making *m, const uint32_t box[4], cell_fn fn, void *context)
{
    for (uint32_t y = box[1] / PROBE_CELL; y <= box[3] / PROBE_CELL; y++)
        for (uint32_t x = box[0] / PROBE_CELL; x <= box[2] / PROBE_CELL; x++) {
            uint32_t cell = m->cell_of[(size_t)y * m->survey->across * PROBE_ACROSS + x];
            if (cell != PROBE_NO_CELL)
                fn(context, cell);
        }
}

static void mark(void *context, uint32_t)
{
    *(uint8_t *)context = 1;
}

/* A coarse sieve: a pixel's margin, and large boxes pass. */
static void sieve(void *context, size_t begin, size_t end, unsigned)
{
    struct making *m = context;
    for (size_t i = begin; i < end; i++) {
        struct spot s;
        m->near_cell[i] = 0;
        if (!spot_find(&m->spots, i, &s))
            continue;
        uint32_t box[4] = { s.x0 ? s.x0 - 1 : 0, s.y0 ? s.y0 - 1 : 0,
                            s.x1 + 1 < m->spots.width ? s.x1 + 1 : s.x1,
                            s.y1 + 1 < m->spots.height ? s.y1 + 1 : s.y1 };
        uint64_t places =
            (uint64_t)((box[2] - box[0]) / PROBE_CELL + 1) * ((box[3] - box[1]) / PROBE_CELL + 1);
        if (places > MANY_CELLS)
            m->near_cell[i] = 1;
        else
            each_cell(m, box, mark, &m->near_cell[i]);
    }
}

static enum stp_result collect_splats(struct making *m)
{
    struct probe *p = m->probe;
    size_t n = m->spots.scene->splats.count;
    parallel_for(m->env, n, 4096, sieve, m);
    for (size_t i = 0; i < n; i++)
        p->splats += m->near_cell[i];
    p->splat = mem_alloc(p->splats ? p->splats : 1, sizeof *p->splat);
    if (!p->splat)
        return log_no_memory(m->env, p->splats * sizeof *p->splat, "the probe's splats");
    size_t at = 0;
    for (size_t i = 0; i < n; i++)
        if (m->near_cell[i])
            p->splat[at++] = (uint32_t)i;
    return STP_OK;
}

static enum stp_result place_rays(struct making *m)
{
    struct probe *p = m->probe;
    p->ray = mem_alloc(p->pixels ? p->pixels : 1, sizeof *p->ray);
    if (!p->ray)
        return log_no_memory(m->env, p->pixels * sizeof *p->ray, "the probe's rays");
    for (size_t i = 0; i < p->pixels; i++) {
        const uint32_t *corner = m->probe->corner[i / PROBE_CELL_PIXELS];
        size_t k = i % PROBE_CELL_PIXELS;
        p->ray[i] = eye_ray(&p->view.eye, corner[0] + (double)(k % PROBE_CELL) + 0.5,
                            corner[1] + (double)(k / PROBE_CELL) + 0.5);
    }
    return STP_OK;
}

static enum stp_result push(struct making *m, const struct probe_fragment *fragment)
{
    if (m->count == m->capacity) {
        size_t more = m->capacity ? m->capacity * 2 : 65536;
        void *grown = mem_realloc(m->probe->fragment, more, sizeof *fragment);
        if (!grown)
            return log_no_memory(m->env, more * sizeof *fragment, "the probe's fragments");
        m->probe->fragment = grown;
        m->capacity = more;
    }
    m->probe->fragment[m->count++] = *fragment;
    return STP_OK;
}

/* One disc over the cells that its box touches. */
struct drawing {
    struct making *m;
    struct disc disc;
    uint32_t id;
    enum stp_result result;
};

static void draw(void *context, uint32_t cell)
{
    struct drawing *d = context;
    struct probe *p = d->m->probe;
    const uint32_t *corner = p->corner[cell];
    struct fragment hit;
    for (uint32_t k = 0; k < PROBE_CELL_PIXELS && d->result == STP_OK; k++) {
        uint32_t x = corner[0] + k % PROBE_CELL, y = corner[1] + k / PROBE_CELL;
        size_t pixel = (size_t)cell * PROBE_CELL_PIXELS + k;
        if (x >= p->view.width || y >= p->view.height ||
            !disc_hit(&d->disc, &p->view.eye, &p->ray[pixel], x + 0.5, y + 0.5, &hit))
            continue;
        double gauss = exp(-2 * hit.rho2);
        struct probe_fragment f = {
            .depth = hit.depth,
            .rho2 = hit.rho2,
            .weight = p->view.kernel == STP_KERNEL_GAUSS ? gauss : 1 - hit.rho2,
            .normal = fragment_normal(&d->disc, &hit),
            .splat = d->id,
            .pixel = (uint32_t)pixel,
            .kept = true,
        };
        d->result = push(d->m, &f);
    }
}

static enum stp_result collect_fragments(struct making *m)
{
    struct probe *p = m->probe;
    struct drawing d = { .m = m, .result = STP_OK };
    for (size_t i = 0; i < p->splats && d.result == STP_OK; i++) {
        uint32_t box[4];
        d.id = p->splat[i];
        if (disc_setup(&p->view, d.id, &d.disc) &&
            cells_touched(d.disc.x_min, d.disc.x_max, 1, 0, p->view.width, &box[0], &box[2]) &&
            cells_touched(d.disc.y_min, d.disc.y_max, 1, 0, p->view.height, &box[1], &box[3]))
            each_cell(m, box, draw, &d);
    }
    return d.result;
}

/* By pixel; within one they stay in the order of the splats. */
static enum stp_result sort_fragments(struct making *m)
{
    struct probe *p = m->probe;
    p->first = mem_zalloc(p->pixels + 2, sizeof *p->first);
    struct probe_fragment *sorted = mem_alloc(m->count ? m->count : 1, sizeof *sorted);
    if (!p->first || !sorted) {
        mem_free(sorted);
        return log_no_memory(m->env, m->count * sizeof *sorted, "the probe's fragments");
    }
    for (size_t i = 0; i < m->count; i++)
        p->first[p->fragment[i].pixel + 2]++;
    for (size_t i = 2; i < p->pixels + 2; i++)
        p->first[i] += p->first[i - 1];
    for (size_t i = 0; i < m->count; i++)
        sorted[p->first[p->fragment[i].pixel + 1]++] = p->fragment[i];
    mem_free(p->fragment);
    p->fragment = sorted;
    return STP_OK;
}

static enum stp_result fill(struct making *m)
{
    enum stp_result result = collect_splats(m);
    if (result == STP_OK)
        result = place_rays(m);
    if (result == STP_OK)
        result = collect_fragments(m);
    return result == STP_OK ? sort_fragments(m) : result;
}

enum stp_result probe_make(const struct stp_env *env, const struct stp_scene *scene,
                           const struct stp_camera *camera, const struct stp_render_params *params,
                           const struct survey *survey, const struct probe_sample *sample,
                           struct probe *probe)
{
    struct probe made = { .view = reference_view(scene, camera, params) };
    made.view.leveled = true;
    struct making m = { .env = env, .probe = &made, .survey = survey };
    size_t blocks = (size_t)survey->across * survey->down;
    enum stp_result result = STP_OK;
    made.view.grid = 1;
    made.environment_behind = params->environment_behind;
    if (params->background)
        memcpy(made.background, params->background, sizeof made.background);
    m.spots = spot_view_of(scene, camera, params);
    m.cell_of = mem_alloc(blocks * BLOCK_CELLS, sizeof *m.cell_of);
    made.corner = mem_alloc(sample->cells, sizeof *made.corner);
    m.near_cell = mem_alloc(scene->splats.count, 1);
    if (!m.cell_of || !made.corner || !m.near_cell)
        result = log_no_memory(env, scene->splats.count + blocks * BLOCK_CELLS * sizeof *m.cell_of,
                               "a probe");
    if (result == STP_OK) {
        place_cells(&m, sample);
        result = fill(&m);
    }
    mem_free(m.cell_of);
    mem_free(m.near_cell);
    if (result == STP_OK)
        result = probe_truth(env, &made);
    if (result == STP_OK)
        *probe = made;
    else
        probe_release(&made);
    return result;
}

void probe_release(struct probe *probe)
{
    mem_free(probe->corner);
    mem_free(probe->ray);
    mem_free(probe->first);
    mem_free(probe->fragment);
    mem_free(probe->truth);
    mem_free(probe->splat);
    *probe = (struct probe){ 0 };
}
