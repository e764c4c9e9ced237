/* Which walks draw which kernels: those with a weight on a pixel where the kernel has a fragment.
 */
#include "prepare/axis_lists.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/axis_region.h"

#define GRAIN     8192
#define ALL_WALKS ((1u << AXIS_WALKS) - 1)

struct sifting {
    struct axis_view view;
    struct axis_lists *lists;
    struct axis_region region[AXIS_WALKS];
    unsigned walks;                       /* with a weight somewhere in the picture */
    bool everywhere;                      /* one list, whatever the rays */
    uint8_t *whole;                       /* of each block: the walks with a weight on all of it */
    atomic_size_t masks[1 << AXIS_WALKS]; /* kernels of each mask */
};

/* A region is convex: it holds a block when it holds its corners. */
static bool holds_block(const struct axis_region *region, const struct axis_rectangle *r)
{
    double x0 = (double)r->x0 + 0.5, x1 = (double)r->x1 + 0.5;
    double y0 = (double)r->y0 + 0.5, y1 = (double)r->y1 + 0.5;
    return axis_region_holds(region, x0, y0) && axis_region_holds(region, x1, y0) &&
           axis_region_holds(region, x0, y1) && axis_region_holds(region, x1, y1);
}

static void open_range(void *context, size_t begin, size_t end, unsigned)
{
    struct sifting *s = context;
    for (size_t i = begin; i < end; i++) {
        int64_t x = (int64_t)(i % s->lists->blocks_x) * AXIS_BLOCK_WIDTH;
        int64_t y = (int64_t)(i / s->lists->blocks_x) * AXIS_BLOCK_HEIGHT;
        const struct axis_rectangle r = { x, x + AXIS_BLOCK_WIDTH - 1, y,
                                          y + AXIS_BLOCK_HEIGHT - 1 };
        unsigned open = s->everywhere ? s->walks : 0, whole = open;
        for (unsigned w = 0; !s->everywhere && w < AXIS_WALKS; w++) {
            if (!(s->walks >> w & 1) || !axis_region_reaches(&s->region[w], &r))
                continue;
            open |= 1u << w;
            whole |= (unsigned)holds_block(&s->region[w], &r) << w;
        }
        s->lists->open[i] = (uint8_t)open;
        s->whole[i] = (uint8_t)whole;
    }
}

/* The n-th of [first, last], from the middle out. */
static double middle_out(int64_t first, int64_t last, int64_t n)
{
    int64_t middle = first + (last - first) / 2, away = (n + 1) / 2;
    return (double)(n % 2 ? middle + away : middle - away);
}

/* Has the kernel a fragment in the region? Its fragments lie around the middle, a corner has none.
 */
static bool draws(const struct sifting *s, unsigned w, const struct axis_rectangle *r,
                  const struct axis_kernel *kernel, double tau)
{
    if (!s->everywhere && !axis_region_reaches(&s->region[w], r))
        return false;
    for (int64_t j = 0; j <= r->y1 - r->y0; j++) {
        double y = middle_out(r->y0, r->y1, j) + 0.5;
        for (int64_t i = 0; i <= r->x1 - r->x0; i++) {
            double x = middle_out(r->x0, r->x1, i) + 0.5;
            if ((s->everywhere || axis_region_holds(&s->region[w], x, y)) &&
                axis_hits(kernel, tau, x, y))
                return true;
        }
    }
    return false;
}

static void find_blocks(const struct sifting *s, const struct axis_rectangle *r, unsigned *open,
                        unsigned *whole)
{
    *open = 0;
    *whole = ALL_WALKS;
    for (int64_t y = r->y0 / AXIS_BLOCK_HEIGHT; y <= r->y1 / AXIS_BLOCK_HEIGHT; y++)
        for (int64_t x = r->x0 / AXIS_BLOCK_WIDTH; x <= r->x1 / AXIS_BLOCK_WIDTH; x++) {
            size_t block = (size_t)y * s->lists->blocks_x + (size_t)x;
            *open |= s->lists->open[block];
            *whole &= s->whole[block];
        }
}

/* A fragment on the middle pixel, as most have, answers for every walk that has all the blocks, or
 * that pixel; the rest is asked pixel by pixel. */
static unsigned walks_of(const struct sifting *s, const struct axis_rectangle *r,
                         const struct axis_kernel *kernel, double tau)
{
    double x = (double)((r->x0 + r->x1) / 2) + 0.5, y = (double)((r->y0 + r->y1) / 2) + 0.5;
    unsigned open, whole, drawn = 0;
    find_blocks(s, r, &open, &whole);
    bool middle = open && axis_hits(kernel, tau, x, y);
    if (middle)
        drawn = whole;
    for (unsigned w = 0, rest = open & ~drawn; rest >> w; w++)
        if (rest >> w & 1)
            drawn |= (unsigned)((middle && axis_region_holds(&s->region[w], x, y)) ||
                                draws(s, w, r, kernel, tau))
                     << w;
    return drawn;
}

/* The kernel's walks; where there are any, its pixels. */
static unsigned sift(const struct sifting *s, size_t i, struct axis_span *span)
{
    struct axis_rectangle r;
    struct axis_kernel kernel;
    if (!axis_kernel(&s->view, (uint32_t)i, &kernel) || !axis_pixels(&kernel, &r))
        return 0;
    *span = (struct axis_span){ (uint16_t)r.x0, (uint16_t)r.x1, (uint16_t)r.y0, (uint16_t)r.y1 };
    return walks_of(s, &r, &kernel, axis_tau(&s->view, (uint32_t)i));
}

static void sift_range(void *context, size_t begin, size_t end, unsigned)
{
    struct sifting *s = context;
    size_t masks[1 << AXIS_WALKS] = { 0 };
    for (size_t i = begin; i < end; i++) {
        unsigned mask = sift(s, i, &s->lists->span[i]);
        s->lists->mask[i] = (uint8_t)mask;
        masks[mask]++;
    }
    for (unsigned m = 0; m < 1 << AXIS_WALKS; m++)
        if (masks[m])
            atomic_fetch_add(&s->masks[m], masks[m]);
}

/* The walks whose region has a pixel; of the single list, the axis nearest to the view's. */
static void find_walks(const struct stp_camera *camera, struct sifting *s)
{
    const struct axis_rectangle picture = { 0, (int64_t)camera->width - 1, 0,
                                            (int64_t)camera->height - 1 };
    struct axis_rays rays = axis_rays(camera);
    if (s->everywhere) {
        const double *m = camera->world_to_camera;
        struct vec3 forward = v3(-m[8], -m[9], -m[10]);
        const double v[3] = { forward.x, forward.y, forward.z };
        unsigned axis = axis_dominant(forward);
        s->walks = 1u << (2 * axis + (v[axis] < 0));
        return;
    }
    for (unsigned w = 0; w < AXIS_WALKS; w++) {
        struct axis_walk walk = { .axis = (uint8_t)(w / 2), .backwards = w % 2 != 0 };
        s->region[w] = axis_region(&rays, s->lists, &walk);
        s->walks |= (unsigned)axis_region_reaches(&s->region[w], &picture) << w;
    }
}

static enum stp_result make_room(const struct stp_env *env, struct axis_lists *lists, size_t count,
                                 const struct stp_camera *camera)
{
    const uint32_t side = 8; /* whole blocks of the picture's layout, which are square */
    uint32_t x = (camera->width + side - 1) / side * side / AXIS_BLOCK_WIDTH;
    uint32_t y = (camera->height + side - 1) / side * side / AXIS_BLOCK_HEIGHT;
    if (!lists->mask)
        lists->mask = mem_alloc(count, sizeof *lists->mask);
    if (!lists->span)
        lists->span = mem_alloc(count, sizeof *lists->span);
    if (x != lists->blocks_x || y != lists->blocks_y) {
        mem_free(lists->open);
        lists->open = mem_alloc((size_t)x * y, sizeof *lists->open);
        lists->blocks_x = x;
        lists->blocks_y = y;
    }
    if (lists->mask && lists->span && lists->open)
        return STP_OK;
    return log_no_memory(env, count * (sizeof *lists->mask + sizeof *lists->span),
                         "the kernels' walks");
}

enum stp_result axis_sift(const struct stp_env *env, const struct stp_scene *scene,
                          const struct stp_camera *camera, struct axis_lists *lists)
{
    size_t count = axis_kernels(scene);
    enum stp_result result = make_room(env, lists, count, camera);
    if (result != STP_OK)
        return result;
    size_t blocks = (size_t)lists->blocks_x * lists->blocks_y;
    struct sifting s = { .view = axis_view(scene, camera),
                         .lists = lists,
                         .everywhere =
                             lists->merge == STP_AXIS_SINGLE || lists->merge == STP_AXIS_SORT,
                         .whole = mem_alloc(blocks, 1) };
    if (!s.whole)
        return log_no_memory(env, blocks, "the walks of blocks");
    s.view.disc_look = lists->look;
    find_walks(camera, &s);
    parallel_for(env, blocks, 1024, open_range, &s);
    parallel_for(env, count, GRAIN, sift_range, &s);
    for (unsigned m = 0; m < 1 << AXIS_WALKS; m++)
        lists->masks[m] = s.masks[m];
    mem_free(s.whole);
    return STP_OK;
}
