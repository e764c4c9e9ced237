/* Clusters of points, for the device to cull (glsl/lib/clusters.glsl). */
#include <math.h>

#include "base/thread.h"
#include "base/vec.h"
#include "record/record.h"

#define OPEN_CONE 2    /* no direction is behind it */
#define SLACK     2e-4 /* of the sine: normals and axes are packed in 32 bits, the device rounds */

struct cluster {
    float center[3], radius; /* of a ball about the centres, relative to the origin */
    uint32_t axis;           /* octahedral; of a cone about the normals */
    float sine;
    float reach; /* the largest of the discs' radii */
    uint32_t pad;
};

struct clusters {
    const struct splats *splats;
    size_t first, count; /* points */
    struct cluster *out;
};

static struct vec3 place_of(const struct splats *s, size_t i)
{
    return v3_sub(v3_load(s->position[i]), v3_load(s->origin));
}

static void enclose(const struct splats *s, size_t first, size_t end, struct cluster *out)
{
    struct vec3 low = place_of(s, first), high = low, center;
    double radius = 0;
    for (size_t i = first; i < end; i++) {
        struct vec3 p = place_of(s, i);
        low = v3(fmin(low.x, p.x), fmin(low.y, p.y), fmin(low.z, p.z));
        high = v3(fmax(high.x, p.x), fmax(high.y, p.y), fmax(high.z, p.z));
    }
    center = v3_scale(v3_add(low, high), 0.5);
    for (size_t i = first; i < end; i++)
        radius = fmax(radius, v3_length(v3_sub(place_of(s, i), center)));
    v3_storef(center, out->center);
    out->radius = (float)radius;
}

static void bundle(const struct splats *s, size_t first, size_t end, struct cluster *out)
{
    struct vec3 sum = { 0 };
    double least = 1;
    for (size_t i = first; i < end; i++)
        sum = v3_add(sum, v3_loadf(s->normal[i]));
    struct vec3 axis = v3_unit(sum);
    for (size_t i = first; i < end; i++)
        least = fmin(least, v3_dot(axis, v3_loadf(s->normal[i])));
    const float direction[3] = { (float)axis.x, (float)axis.y, (float)axis.z };
    out->axis = record_octahedral(direction);
    out->sine = least > SLACK ? (float)(sqrt(1 - least * least) + SLACK) : OPEN_CONE;
}

static float largest_radius(const struct splats *s, size_t first, size_t end)
{
    float largest = 0;
    for (size_t i = first; i < end; i++)
        largest = fmaxf(largest, s->radius[i]);
    return largest;
}

static void make_clusters(void *context, size_t begin, size_t end, unsigned)
{
    const struct clusters *c = context;
    for (size_t i = begin; i < end; i++) {
        size_t first = i * STP_CLUSTER, last = first + STP_CLUSTER;
        last = c->first + (last < c->count ? last : c->count);
        enclose(c->splats, c->first + first, last, &c->out[i]);
        bundle(c->splats, c->first + first, last, &c->out[i]);
        c->out[i].reach = largest_radius(c->splats, c->first + first, last);
        c->out[i].pad = 0;
    }
}

enum stp_result record_upload_clusters(const struct stp_env *env, struct record_frame *frame,
                                       const struct splats *splats, size_t first, size_t count,
                                       struct gpu_buffer *buffer)
{
    size_t clusters = (count + STP_CLUSTER - 1) / STP_CLUSTER;
    struct clusters c = { splats, first, count, NULL };
    c.out = gpu_fill_begin(env, buffer, clusters, sizeof *c.out, "clusters of points");
    if (!c.out)
        return STP_ERROR_MEMORY;
    parallel_for(env, clusters, 1024, make_clusters, &c);
    return gpu_fill_end(env, frame->context, buffer, c.out, clusters * sizeof *c.out);
}
