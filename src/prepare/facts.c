#include "prepare/facts.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"
#include "prepare/bounds.h"
#include "prepare/radii.h"
#include "scene/phong.h"

#define CORE_SAMPLES 65536

size_t facts_core_step(size_t count)
{
    return count / CORE_SAMPLES + 1;
}

void facts_core(double *sample[3], size_t n, const struct bounds *all, double core[6])
{
    struct bounds box;
    size_t trim = (n - 1) / 100;
    for (int axis = 0; axis < 3; axis++) {
        box.low[axis] = select_rank(sample[axis], n, trim);
        box.high[axis] = select_rank(sample[axis], n, n - 1 - trim);
    }
    double margin = bounds_diagonal(&box);
    for (int axis = 0; axis < 3; axis++) {
        core[axis] = margin > 0 ? fmax(box.low[axis] - margin, all->low[axis]) : all->low[axis];
        core[axis + 3] =
            margin > 0 ? fmin(box.high[axis] + margin, all->high[axis]) : all->high[axis];
    }
}

static enum stp_result find_core(const struct stp_env *env, const struct splats *s,
                                 const struct bounds *all, double core[6])
{
    size_t step = facts_core_step(s->count), n = (s->count + step - 1) / step;
    double *value = mem_alloc(3 * n, sizeof *value);
    double *sample[3] = { value, value + n, value + 2 * n };
    if (!value)
        return log_no_memory(env, 3 * n * sizeof *value, "percentiles");
    for (int axis = 0; axis < 3; axis++)
        for (size_t i = 0; i < n; i++)
            sample[axis][i] = s->position[i * step][axis];
    facts_core(sample, n, all, core);
    mem_free(value);
    return STP_OK;
}

void facts_origin(const double core[6], double origin[3])
{
    double largest = 0, extent = 0;
    for (int axis = 0; axis < 3; axis++) {
        largest = fmax(largest, fmax(fabs(core[axis]), fabs(core[axis + 3])));
        extent = fmax(extent, core[axis + 3] - core[axis]);
    }
    double unit = extent > 0 ? exp2(floor(log2(extent))) : 0;
    for (int axis = 0; axis < 3; axis++) {
        double middle = 0.5 * core[axis] + 0.5 * core[axis + 3];
        origin[axis] = unit > 0 ? rint(middle / unit) * unit : middle;
        if (largest <= 4 * extent)
            origin[axis] = 0;
    }
}

static void sum_positions(const void *context, size_t begin, size_t end, double *sum)
{
    const struct splats *s = context;
    for (size_t i = begin; i < end; i++)
        for (int axis = 0; axis < 3; axis++)
            sum[axis] += s->position[i][axis] - s->origin[axis];
}

struct flux {
    const struct splats *splats;
    struct vec3 centroid;
};

static void sum_flux(const void *context, size_t begin, size_t end, double *sum)
{
    const struct flux *f = context;
    for (size_t i = begin; i < end; i++) {
        struct vec3 d = v3_sub(v3_load(f->splats->position[i]), f->centroid);
        double area = (double)f->splats->radius[i] * (double)f->splats->radius[i];
        sum[0] += area * v3_dot(v3_loadf(f->splats->normal[i]), d);
        sum[1] += area * v3_length(d);
    }
}

enum stp_result facts_flux(const struct stp_env *env, const struct splats *s,
                           const double centroid[3], double flux[2])
{
    struct flux f = { s, v3_load(centroid) };
    return block_sum(env, s->count, 2, sum_flux, &f, flux);
}

static enum stp_result find_outwardness(const struct stp_env *env, const struct splats *s,
                                        double *outwardness)
{
    double sum[3], flux[2];
    enum stp_result result = block_sum(env, s->count, 3, sum_positions, s, sum);
    if (result != STP_OK)
        return result;
    struct vec3 centre = v3_add(v3_load(s->origin), v3_scale(v3_load(sum), 1 / (double)s->count));
    result = facts_flux(env, s, (double[]){ centre.x, centre.y, centre.z }, flux);
    if (result == STP_OK)
        *outwardness = flux[1] > 0 ? flux[0] / flux[1] : 0;
    return result;
}

/* A coordinate in double that is no float32 by chance is one in 2^29. */
static double float_step(const struct splats *s)
{
    float largest = 0;
    for (size_t i = 0; i < s->count; i++)
        for (int axis = 0; axis < 3; axis++) {
            float rounded = (float)s->position[i][axis];
            if ((double)rounded != s->position[i][axis])
                return 0;
            largest = fmaxf(largest, fabsf(rounded));
        }
    return (double)nextafterf(largest, INFINITY) - (double)largest;
}

static void scan_radii_and_colors(const struct splats *s, struct stp_facts *facts)
{
    facts->radius_min = INFINITY;
    facts->radius_max = 0;
    for (size_t i = 0; i < s->count; i++) {
        facts->radius_min = fminf(facts->radius_min, s->radius[i]);
        facts->radius_max = fmaxf(facts->radius_max, s->radius[i]);
    }
    facts->color_min = facts->color_max = 0;
    for (size_t i = 0; s->color && i < s->count; i++)
        for (int c = 0; c < 3; c++) {
            facts->color_min = fminf(facts->color_min, s->color[i][c]);
            facts->color_max = fmaxf(facts->color_max, s->color[i][c]);
        }
}

static void count_phong(const struct splats *s, struct stp_facts *facts)
{
    facts->phong = facts->clip_lines = 0;
    for (size_t i = 0; s->phong && i < s->count; i++) {
        facts->phong += !phong_is_plain(&s->phong[i]);
        facts->clip_lines += s->phong[i].clips > 0;
    }
}

/* first: an object's, NaN until a splat of it was seen. */
static void scan_opacities(const struct splats *s, float *first, struct stp_facts *facts)
{
    bool opaque = false;
    facts->opacity_min = 1;
    facts->uniform_opacity = true;
    for (size_t i = 0; s->opacity && i < s->count; i++) {
        float opacity = s->opacity[i], *known = &first[s->object ? s->object[i] : 0];
        if (isnan(*known))
            *known = opacity;
        facts->uniform_opacity &= opacity == *known;
        facts->opacity_min = fminf(facts->opacity_min, opacity);
        opaque |= opacity == 1;
    }
    facts->transparent = facts->opacity_min < 1;
    facts->mixed = facts->transparent && opaque;
}

static enum stp_result find_opacities(const struct stp_env *env, const struct splats *s,
                                      struct stp_facts *facts)
{
    float *first = mem_alloc(facts->objects, sizeof *first);
    if (!first)
        return log_no_memory(env, facts->objects * sizeof *first, "the objects' opacities");
    for (unsigned i = 0; i < facts->objects; i++)
        first[i] = NAN;
    scan_opacities(s, first, facts);
    mem_free(first);
    return STP_OK;
}

enum stp_result facts_measure(const struct stp_env *env, struct splats *s, struct stp_facts *facts,
                              double core[6])
{
    struct bounds box;
    enum stp_result result = bounds_of(env, s->position, NULL, s->count, &box);
    if (result == STP_OK)
        result = find_core(env, s, &box, core);
    if (result != STP_OK)
        return result;
    facts_origin(core, s->origin);
    memcpy(facts->origin, s->origin, sizeof facts->origin);
    memcpy(facts->bounds, box.low, sizeof box.low);
    memcpy(facts->bounds + 3, box.high, sizeof box.high);
    facts->splats = s->count;
    facts->has_color = s->color != NULL;
    facts->float_step = float_step(s);
    scan_radii_and_colors(s, facts);
    count_phong(s, facts);
    result = find_opacities(env, s, facts);
    if (result != STP_OK)
        return result;
    result = radii_median(env, s->radius, s->count, &facts->radius_median);
    return result == STP_OK ? find_outwardness(env, s, &facts->outwardness) : result;
}

enum stp_result facts_no_points(const struct stp_env *env, const struct stp_facts *f)
{
    const enum stp_result result = STP_ERROR_NO_POINTS;
    if (f->points == 0)
        return log_error(env, result, "no points to draw: there are none");
    if (f->not_finite == f->points)
        return log_error(env, result,
                         "no points to draw: none of %zu has finite coordinates within 1e18",
                         f->points);
    if (f->clipped == f->points)
        return log_error(env, result, "no points to draw: all %zu lie outside the clip box",
                         f->points);
    return log_error(
        env, result,
        "no points to draw: of %zu, %zu have no finite coordinates within 1e18 and %zu lie outside "
        "the clip box",
        f->points, f->not_finite, f->clipped);
}
