#include "prepare/axis_lists.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/axis_region.h"
#include "prepare/radix.h"

#define GRAIN 8192

void axis_lists_release(struct axis_lists *lists)
{
    mem_free(lists->order);
    *lists = (struct axis_lists){ 0 };
}

static double component(struct vec3 v, unsigned axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static unsigned dominant(struct vec3 v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

double axis_weight(const struct axis_lists *lists, const struct axis_walk *walk, struct vec3 v)
{
    double most = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    double own = component(v, walk->axis) * (walk->backwards ? -1 : 1) / most;
    if (lists->merge == STP_AXIS_SINGLE || lists->merge == STP_AXIS_SORT)
        return 1;
    if (lists->merge == STP_AXIS_CLIP)
        return dominant(v) == walk->axis && own > 0 ? 1 : 0;
    return own > lists->h ? (own - lists->h) / (1 - lists->h) : 0;
}

struct sifting {
    const struct stp_scene *scene;
    struct axis_view view;
    struct axis_region region[AXIS_WALKS];
    bool open[AXIS_WALKS]; /* some ray of the view has a weight */
    uint8_t *mask;         /* of each kernel: the walks that draw it */
    bool everywhere;       /* one list, whatever the rays */
};

/* Has the kernel a fragment in the region? The middle of its pixels first: mostly that is one. */
static bool draws(const struct axis_kernel *kernel, const struct axis_region *region,
                  const struct axis_rectangle *r, double tau)
{
    const struct axis_view *view = kernel->view;
    const double *centre = kernel->centre;
    double x = (double)((r->x0 + r->x1) / 2) + 0.5, y = (double)((r->y0 + r->y1) / 2) + 0.5;
    if (region && !axis_region_reaches(region, r))
        return false;
    bool found = (!region || axis_region_holds(region, x, y)) && axis_hits(view, centre, tau, x, y);
    for (int64_t py = r->y0; !found && py <= r->y1; py++)
        for (int64_t px = r->x0; !found && px <= r->x1; px++)
            found = (!region || axis_region_holds(region, (double)px + 0.5, (double)py + 0.5)) &&
                    axis_hits(view, centre, tau, (double)px + 0.5, (double)py + 0.5);
    return found;
}

static void sift_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct sifting *s = context;
    for (size_t i = begin; i < end; i++) {
        struct axis_rectangle r;
        struct axis_kernel kernel;
        unsigned mask = 0;
        axis_kernel(&s->view, (uint32_t)i, &kernel);
        bool seen = axis_pixels(kernel.view, kernel.centre, &r);
        double tau = seen ? axis_tau(&s->view, (uint32_t)i) : 0;
        for (unsigned w = 0; seen && w < AXIS_WALKS; w++)
            if (s->open[w] && draws(&kernel, s->everywhere ? NULL : &s->region[w], &r, tau))
                mask |= 1u << w;
        s->mask[i] = (uint8_t)mask;
    }
}

/* Walk w of all six: axis w / 2, backwards where odd. */
static struct axis_walk walk_of(unsigned w)
{
    return (struct axis_walk){ .axis = (uint8_t)(w / 2), .backwards = w % 2 != 0 };
}

/* The walks whose region has a pixel; of the single list, the axis nearest to the view's. */
static void open_walks(const struct stp_camera *camera, const struct axis_lists *lists,
                       struct sifting *s)
{
    const struct axis_rectangle picture = { 0, (int64_t)camera->width - 1, 0,
                                            (int64_t)camera->height - 1 };
    struct axis_rays rays = axis_rays(camera);
    if (s->everywhere) {
        const double *m = camera->world_to_camera;
        struct vec3 forward = v3(-m[8], -m[9], -m[10]);
        unsigned axis = dominant(forward);
        s->open[2 * axis + (component(forward, axis) < 0)] = true;
        return;
    }
    for (unsigned w = 0; w < AXIS_WALKS; w++) {
        struct axis_walk walk = walk_of(w);
        s->region[w] = axis_region(&rays, lists, &walk);
        s->open[w] = axis_region_reaches(&s->region[w], &picture);
    }
}

/* Far to near along the axis: a counting sort over the sheets; within a sheet from the last kernel
 * to the first, since of equal ones the first is the nearer. */
static void fill_walk(const struct sifting *s, unsigned w, const struct axis_walk *walk,
                      size_t *place, uint32_t *order)
{
    const struct volume *volume = s->scene->volume;
    uint32_t sheets = volume->grid.dims[walk->axis], at[3];
    memset(place, 0, sheets * sizeof *place);
    for (size_t i = 0; i < volume->kernels.count; i++)
        if (s->mask[i] >> w & 1) {
            voxel_place(&volume->grid, volume->kernels.voxel[i], at);
            place[at[walk->axis]]++;
        }
    size_t next = walk->first;
    for (uint32_t n = 0; n < sheets; n++) {
        uint32_t sheet = walk->backwards ? n : sheets - 1 - n;
        size_t count = place[sheet];
        place[sheet] = next;
        next += count;
    }
    for (size_t i = volume->kernels.count; i-- > 0;)
        if (s->mask[i] >> w & 1) {
            voxel_place(&volume->grid, volume->kernels.voxel[i], at);
            order[place[at[walk->axis]]++] = (uint32_t)i;
        }
}

/* Bits of a double that order as the numbers do, from the greatest to the least. */
static uint64_t descending_key(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    bits = bits >> 63 ? ~bits : bits | (uint64_t)1 << 63;
    return ~bits;
}

/* Distance from the eye; of an axis's walk, the way along its rays. */
static double order_of(const struct sifting *s, const struct axis_walk *walk, uint32_t kernel,
                       enum stp_axis_merge merge)
{
    double world[3];
    axis_centre(&s->view, kernel, world);
    if (merge != STP_AXIS_SORT)
        return walk->backwards ? -world[walk->axis] : world[walk->axis];
    struct vec3 c = m4_point(s->view.camera->world_to_camera, v3_load(world));
    return s->view.camera->orthographic ? -c.z : v3_dot(c, c);
}

/* Far to near, where there are no sheets; of equal ones the first is the nearer. */
static enum stp_result fill_sorted(const struct stp_env *env, const struct sifting *s, unsigned w,
                                   const struct axis_walk *walk, enum stp_axis_merge merge,
                                   uint32_t *all)
{
    const struct kernels *k = &s->scene->volume->kernels;
    uint32_t *order = all + walk->first;
    uint64_t *key = mem_alloc(walk->count, sizeof *key);
    uint32_t n = 0;
    if (!key)
        return log_no_memory(env, walk->count * sizeof *key, "distances");
    for (size_t i = k->count; i-- > 0;)
        if (s->mask[i] >> w & 1) {
            key[n] = descending_key(order_of(s, walk, (uint32_t)i, merge));
            order[n++] = (uint32_t)i;
        }
    enum stp_result result = radix_sort(env, n, key, order);
    mem_free(key);
    return result;
}

static void count_walks(const struct sifting *s, struct axis_lists *lists,
                        unsigned source[AXIS_WALKS])
{
    size_t count[AXIS_WALKS] = { 0 }, kernels = s->scene->volume->kernels.count;
    for (size_t i = 0; i < kernels; i++) {
        lists->visible += s->mask[i] != 0;
        for (unsigned w = 0; w < AXIS_WALKS; w++)
            count[w] += s->mask[i] >> w & 1;
    }
    for (unsigned w = 0; w < AXIS_WALKS; w++) {
        if (count[w] == 0)
            continue;
        struct axis_walk walk = walk_of(w);
        walk.first = (uint32_t)lists->count;
        walk.count = (uint32_t)count[w];
        source[lists->walk_count] = w;
        lists->walk[lists->walk_count++] = walk;
        lists->count += count[w];
    }
}

static enum stp_result fill_walks(const struct stp_env *env, const struct sifting *s,
                                  const unsigned *source, struct axis_lists *lists)
{
    const uint32_t *dims = s->scene->volume->grid.dims; /* of ellipsoids 0 */
    uint32_t longest = dims[0] > dims[1] ? dims[0] : dims[1];
    longest = longest > dims[2] ? longest : dims[2];
    lists->order = mem_alloc(lists->count, sizeof *lists->order);
    size_t *place = mem_alloc(longest, sizeof *place);
    enum stp_result result = STP_OK;
    if (!lists->order || !place)
        result = log_no_memory(env, lists->count * sizeof *lists->order, "the axis lists");
    for (unsigned n = 0; result == STP_OK && n < lists->walk_count; n++) {
        if (lists->merge == STP_AXIS_SORT || s->view.is_ellipsoid)
            result = fill_sorted(env, s, source[n], &lists->walk[n], lists->merge, lists->order);
        else
            fill_walk(s, source[n], &lists->walk[n], place, lists->order);
    }
    mem_free(place);
    return result;
}

enum stp_result axis_lists_build(const struct stp_env *env, const struct stp_scene *scene,
                                 const struct stp_camera *camera, enum stp_axis_merge merge,
                                 double h, struct axis_lists *lists)
{
    struct axis_lists made = { .merge = merge, .h = h };
    struct sifting sifting = { .scene = scene,
                               .view = axis_view(scene, camera),
                               .everywhere = merge == STP_AXIS_SINGLE || merge == STP_AXIS_SORT };
    unsigned source[AXIS_WALKS];
    size_t count = scene->volume->kernels.count;
    sifting.mask = mem_alloc(count, 1);
    if (!sifting.mask)
        return log_no_memory(env, count, "the kernels' walks");
    open_walks(camera, &made, &sifting);
    parallel_for(env, count, GRAIN, sift_range, &sifting);
    count_walks(&sifting, &made, source);
    enum stp_result result = STP_OK;
    if (made.count >= UINT32_MAX / 3)
        result = log_error(env, STP_ERROR_ARGUMENT, "%zu splats in the axis lists: at most %u",
                           made.count, UINT32_MAX / 3);
    else if (made.count)
        result = fill_walks(env, &sifting, source, &made);
    mem_free(sifting.mask);
    if (result == STP_OK)
        *lists = made;
    else
        axis_lists_release(&made);
    return result;
}
