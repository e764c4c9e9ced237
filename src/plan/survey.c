#include "plan/survey.h"

#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "shared/frame.h"

#define MOST_SPLATS 131072 /* of larger scenes this many are looked at, about; all with a bound */
#define RANGE       128    /* groups of neighbours that a thread takes at once */
#define UNIT        64.0   /* sums are integers in 64ths, so that their order is nothing */
#define KEPT        8      /* fragments a pixel that exact_resolve keeps in registers */

struct count {
    const struct spot_view *view;
    size_t stride;
    uint32_t across;
    uint64_t drawn, small_box, large, large_box, fragments;
    uint64_t *mass;
    uint64_t *edge; /* (across + 1) x (down + 1): how much more, or less (modulo 2^64), the blocks
                       right of and below each corner have; their sums are the mass */
};

static void add(uint64_t *sum, uint64_t value)
{
    __atomic_fetch_add(sum, value, __ATOMIC_RELAXED);
}

/* A spot's fragments, evenly over the blocks that it touches. */
static void spread(struct count *count, const struct spot *spot)
{
    uint32_t bx = spot->x0 / SURVEY_BLOCK, by = spot->y0 / SURVEY_BLOCK;
    uint32_t w = spot->x1 / SURVEY_BLOCK - bx + 1, h = spot->y1 / SURVEY_BLOCK - by + 1;
    double each = spot->fragments * (double)count->stride * UNIT / ((double)w * h);
    uint64_t value = (uint64_t)ceil(each);
    if (w == 1 && h == 1) {
        add(&count->mass[(size_t)by * count->across + bx], value);
        return;
    }
    uint64_t *above = &count->edge[by * ((size_t)count->across + 1) + bx];
    uint64_t *below = above + h * ((size_t)count->across + 1);
    add(&above[0], value);
    add(&above[w], -value);
    add(&below[0], -value);
    add(&below[w], value);
}

/* Sums of a range, before they join the others'. */
struct part {
    uint64_t drawn, small_box, large, large_box, fragments;
};

/* Returns the pixels of its bounds when a thread draws the splat alone. */
static uint64_t count_splat(struct count *count, size_t i, struct part *part)
{
    struct spot spot;
    if (!spot_find(count->view, i, &spot))
        return 0;
    uint64_t box = (uint64_t)(spot.x1 - spot.x0 + 1) * (spot.y1 - spot.y0 + 1);
    part->drawn++;
    part->fragments += (uint64_t)(spot.fragments * UNIT);
    spread(count, &spot);
    if (!spot.large)
        return box;
    part->large++;
    part->large_box += box;
    return 0;
}

/* Indices of groups of SURVEY_LANES neighbours. */
static void count_range(void *context, size_t begin, size_t end, unsigned)
{
    struct count *count = context;
    struct part part = { 0 };
    size_t n = count->view->scene->splats.count;
    for (size_t g = begin; g < end; g++) {
        size_t first = g * count->stride * SURVEY_LANES;
        uint64_t most = 0;
        for (size_t i = first; i < first + SURVEY_LANES && i < n; i++) {
            uint64_t box = count_splat(count, i, &part);
            most = box > most ? box : most;
        }
        part.small_box += most * SURVEY_LANES;
    }
    add(&count->drawn, part.drawn);
    add(&count->small_box, part.small_box);
    add(&count->large, part.large);
    add(&count->large_box, part.large_box);
    add(&count->fragments, part.fragments);
}

/* The edges' sums join the masses. */
static void sum_edges(const struct count *count, const struct survey *survey)
{
    size_t row = (size_t)survey->across + 1;
    for (uint32_t y = 0; y < survey->down; y++) {
        uint64_t *edge = &count->edge[y * row], along = 0;
        const uint64_t *above = y ? edge - row : NULL;
        for (uint32_t x = 0; x < survey->across; x++) {
            along += edge[x];
            edge[x] = along + (above ? above[x] : 0);
            count->mass[(size_t)y * survey->across + x] += edge[x];
        }
    }
}

static void sum_up(const struct count *count, struct survey *survey)
{
    double stride = (double)count->stride, area = SURVEY_BLOCK * SURVEY_BLOCK;
    survey->drawn = (double)count->drawn * stride;
    survey->small_box = (double)count->small_box * stride;
    survey->large = (double)count->large * stride;
    survey->large_box = (double)count->large_box * stride;
    survey->fragments = (double)count->fragments * stride / UNIT;
    for (size_t b = 0; b < (size_t)survey->across * survey->down; b++) {
        double mass = (double)count->mass[b] / UNIT, depth = mass / area;
        survey->mass[b] = (float)mass;
        survey->touched += mass > 0 ? area : 0;
        survey->deep += depth > KEPT ? mass - KEPT * area : 0;
        survey->overflow += depth > STP_SLOTS ? area : 0;
    }
}

enum stp_result survey_make(const struct stp_env *env, const struct stp_scene *scene,
                            const struct stp_camera *camera, const struct stp_render_params *params,
                            struct survey *survey)
{
    struct spot_view view = spot_view_of(scene, camera, params);
    size_t n = scene->splats.count;
    size_t stride = params->max_error > 0 ? 1 : (n + MOST_SPLATS - 1) / MOST_SPLATS;
    struct survey made = { .splats = (double)n,
                           .pixels = (double)camera->width * camera->height,
                           .across = (camera->width + SURVEY_BLOCK - 1) / SURVEY_BLOCK,
                           .down = (camera->height + SURVEY_BLOCK - 1) / SURVEY_BLOCK };
    size_t blocks = (size_t)made.across * made.down;
    struct count count = { .view = &view, .stride = stride ? stride : 1, .across = made.across };
    count.mass = mem_zalloc(blocks, sizeof *count.mass);
    count.edge = mem_zalloc(blocks + made.across + made.down + 1, sizeof *count.edge);
    made.mass = mem_zalloc(blocks, sizeof *made.mass);
    if (!count.mass || !count.edge || !made.mass) {
        mem_free(count.mass);
        mem_free(count.edge);
        mem_free(made.mass);
        return log_no_memory(env, blocks * sizeof *made.mass, "the survey's blocks");
    }
    size_t step = count.stride * SURVEY_LANES;
    parallel_for(env, (n + step - 1) / step, RANGE, count_range, &count);
    sum_edges(&count, &made);
    sum_up(&count, &made);
    mem_free(count.mass);
    mem_free(count.edge);
    *survey = made;
    return STP_OK;
}

void survey_release(struct survey *survey)
{
    mem_free(survey->mass);
    *survey = (struct survey){ 0 };
}
