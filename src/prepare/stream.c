#include "prepare/stream.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/collect.h"
#include "prepare/facts.h"
#include "prepare/normals.h"
#include "prepare/order.h"
#include "prepare/prepare.h"
#include "prepare/radii.h"

#define CHUNK_POINTS ((size_t)1 << 23)

/* What the passes over the file find, one after the other. */
struct measuring {
    struct scene_stream *stream;
    struct stp_facts facts;
    struct bounds box;
    size_t *bins; /* of radii: upper halves, then lower ones */
    uint32_t upper;
    size_t rank;
    struct stream_cells cells;
    double centroid[3], flux[2], core[6];
    double *sample[3]; /* of positions */
    size_t sampled;
    const char *lack; /* what only neighbours tell; NULL */
};

static const double *clip_box(const struct scene_stream *stream)
{
    return stream->clipped ? stream->clip_box : NULL;
}

/* A block's points as splats; counts go into *facts. */
static enum stp_result collect_block(const struct stp_env *env, const struct scene_stream *stream,
                                     struct cloud *cloud, struct splats *splats,
                                     struct stp_facts *facts)
{
    *splats = (struct splats){ 0 };
    enum stp_result result = collect_cloud(env, cloud, clip_box(stream), splats, facts);
    cloud_release(cloud);
    if (result != STP_OK)
        splats_release(splats);
    return result;
}

/* First pass: bounds, counts, and whether all is there. */
static void grow(struct bounds *all, const struct bounds *box)
{
    for (int axis = 0; axis < 3; axis++) {
        all->low[axis] = fmin(all->low[axis], box->low[axis]);
        all->high[axis] = fmax(all->high[axis], box->high[axis]);
    }
}

static void measure_values(struct measuring *m, const struct splats *s)
{
    struct stp_facts *f = &m->facts;
    for (size_t i = 0; i < s->count; i++) {
        f->radius_min = fminf(f->radius_min, s->radius[i]);
        f->radius_max = fmaxf(f->radius_max, s->radius[i]);
    }
    for (size_t i = 0; s->color && i < s->count; i++)
        for (int c = 0; c < 3; c++) {
            f->color_min = fminf(f->color_min, s->color[i][c]);
            f->color_max = fmaxf(f->color_max, s->color[i][c]);
        }
    f->splats += s->count;
    f->has_color = s->color != NULL;
}

static enum stp_result measure(const struct stp_env *env, struct measuring *m,
                               const struct splats *s)
{
    struct bounds box;
    if (s->count == 0)
        return STP_OK;
    if (normals_unknown(s) > 0)
        m->lack = "some points have no usable normal";
    if (radii_unknown(s->radius, s->count) > 0)
        m->lack = "some points have no usable radius";
    enum stp_result result = bounds_of(env, s->position, NULL, s->count, &box);
    if (result != STP_OK)
        return result;
    grow(&m->box, &box);
    measure_values(m, s);
    radii_tally(s->radius, s->count, m->bins, NULL);
    return STP_OK;
}

static enum stp_result measure_block(const struct stp_env *env, void *context, size_t,
                                     struct cloud *cloud)
{
    struct measuring *m = context;
    struct splats s;
    enum stp_result result = collect_block(env, m->stream, cloud, &s, &m->facts);
    if (result == STP_OK)
        result = measure(env, m, &s);
    splats_release(&s);
    return result;
}

static void begin_measuring(struct measuring *m)
{
    m->facts.splats = 0;
    m->facts.radius_min = INFINITY;
    m->facts.radius_max = m->facts.color_min = m->facts.color_max = 0;
    m->facts.opacity_min = 1;
    m->facts.uniform_opacity = true;
    for (int axis = 0; axis < 3; axis++) {
        m->box.low[axis] = INFINITY;
        m->box.high[axis] = -INFINITY;
    }
}

/* Second and third pass: the median radius, cells, and the rows' chunks. */
static enum stp_result count_block(const struct stp_env *env, void *context, size_t,
                                   struct cloud *cloud)
{
    struct measuring *m = context;
    struct stp_facts unused = { 0 };
    struct splats s;
    enum stp_result result = collect_block(env, m->stream, cloud, &s, &unused);
    if (result != STP_OK)
        return result;
    radii_tally(s.radius, s.count, m->bins, &m->upper);
    stream_cells_add(&m->cells, &s);
    splats_release(&s);
    return STP_OK;
}

static enum stp_result assign_block(const struct stp_env *env, void *context, size_t first,
                                    struct cloud *cloud)
{
    struct measuring *m = context;
    struct stp_facts unused = { 0 };
    struct splats s;
    enum stp_result result = collect_block(env, m->stream, cloud, &s, &unused);
    if (result != STP_OK)
        return result;
    stream_assign(m->stream, &m->cells, first, &s);
    splats_release(&s);
    return STP_OK;
}

static void find_median(struct measuring *m)
{
    uint32_t bits = m->upper << 16 | radii_bin_of_rank(m->bins, &m->rank);
    memcpy(&m->facts.radius_median, &bits, sizeof bits);
    if (radii_are_suspect(&m->facts.radius_max, 1, m->facts.radius_median))
        m->lack = "some radii are so large that their neighbours must be asked";
}

static enum stp_result cut(const struct stp_env *env, struct measuring *m)
{
    size_t rows = m->stream->file.count;
    size_t most = m->stream->chunk_points ? m->stream->chunk_points : CHUNK_POINTS;
    m->rank = (m->facts.splats - 1) / 2;
    m->upper = radii_bin_of_rank(m->bins, &m->rank);
    memset(m->bins, 0, RADII_BINS * sizeof *m->bins);
    enum stp_result result = stream_cells_make(env, &m->box, &m->cells);
    if (result == STP_OK)
        result = stream_walk(env, m->stream, "prepare", 0.2, 0.4, count_block, m);
    if (result != STP_OK)
        return result;
    find_median(m);
    if (m->lack)
        return STP_OK;
    m->stream->chunk_of = mem_alloc(rows, 1);
    if (!m->stream->chunk_of)
        return log_no_memory(env, rows, "the chunks of points");
    memset(m->stream->chunk_of, STREAM_DROPPED, rows);
    stream_cut(m->stream, &m->cells, most);
    stream_centroid(&m->cells, m->centroid);
    return stream_walk(env, m->stream, "prepare", 0.4, 0.6, assign_block, m);
}

/* Fourth pass, chunk by chunk: what depends on the order. */
enum stp_result stream_splats(const struct stp_env *env, const struct stp_scene *scene,
                              uint32_t chunk, struct splats *splats, size_t *duplicates)
{
    struct stp_facts unused = { 0 };
    struct cloud cloud = { 0 };
    struct splats made = { 0 };
    struct bounds box;
    uint32_t *row;
    memcpy(box.low, scene->facts.bounds, sizeof box.low);
    memcpy(box.high, scene->facts.bounds + 3, sizeof box.high);
    enum stp_result result = stream_read(env, scene->stream, chunk, &cloud, &row);
    if (result != STP_OK)
        return result;
    result = collect_block(env, scene->stream, &cloud, &made, &unused);
    made.input = result == STP_OK ? row : NULL;
    if (result != STP_OK)
        mem_free(row);
    if (result == STP_OK)
        result = order_splats_within(env, &made, &box, duplicates);
    if (result != STP_OK) {
        splats_release(&made);
        return result;
    }
    memcpy(made.origin, scene->splats.origin, sizeof made.origin);
    *splats = made;
    return STP_OK;
}

static enum stp_result measure_chunk(const struct stp_env *env, const struct stp_scene *scene,
                                     struct measuring *m, uint32_t chunk)
{
    struct splats s;
    double flux[2];
    size_t duplicates = 0, step = facts_core_step(m->facts.splats);
    enum stp_result result = stream_splats(env, scene, chunk, &s, &duplicates);
    if (result != STP_OK)
        return result;
    m->facts.duplicates += duplicates;
    size_t first = m->stream->chunk[chunk];
    for (size_t i = (step - first % step) % step; i < s.count; i += step, m->sampled++)
        for (int axis = 0; axis < 3; axis++)
            m->sample[axis][m->sampled] = s.position[i][axis];
    result = facts_flux(env, &s, m->centroid, flux);
    m->flux[0] += result == STP_OK ? flux[0] : 0;
    m->flux[1] += result == STP_OK ? flux[1] : 0;
    splats_release(&s);
    return result;
}

static enum stp_result measure_chunks(const struct stp_env *env, const struct stp_scene *scene,
                                      struct measuring *m)
{
    size_t step = facts_core_step(m->facts.splats), n = (m->facts.splats + step - 1) / step;
    double *value = mem_alloc(3 * n, sizeof *value);
    if (!value)
        return log_no_memory(env, 3 * n * sizeof *value, "percentiles");
    for (int axis = 0; axis < 3; axis++)
        m->sample[axis] = value + (size_t)axis * n;
    enum stp_result result = STP_OK;
    for (uint32_t i = 0; i < m->stream->chunk_count && result == STP_OK; i++) {
        result = measure_chunk(env, scene, m, i);
        log_progress(env, "prepare", 0.6 + 0.4 * (i + 1.0) / m->stream->chunk_count);
    }
    if (result == STP_OK)
        facts_core(m->sample, n, &m->box, m->core);
    m->facts.outwardness = m->flux[1] > 0 ? m->flux[0] / m->flux[1] : 0;
    mem_free(value);
    return result;
}

static enum stp_result check_stream(const struct stp_scene *scene, struct measuring *m)
{
    if (scene->objects[0].opacity != 1)
        m->lack = "it is transparent";
    return STP_OK;
}

static enum stp_result pass_over(const struct stp_env *env, struct stp_scene *scene,
                                 struct measuring *m)
{
    enum stp_result result = check_stream(scene, m);
    if (result == STP_OK && !m->lack)
        result = stream_walk(env, m->stream, "prepare", 0, 0.2, measure_block, m);
    if (result != STP_OK || m->lack)
        return result;
    if (m->facts.splats == 0)
        return facts_no_points(env, &m->facts);
    result = cut(env, m);
    if (result != STP_OK || m->lack)
        return result;
    memcpy(scene->facts.bounds, m->box.low, sizeof m->box.low);
    memcpy(scene->facts.bounds + 3, m->box.high, sizeof m->box.high);
    return measure_chunks(env, scene, m);
}

static void keep(struct stp_scene *scene, const struct stp_prepare_params *params,
                 struct measuring *m)
{
    memcpy(m->facts.bounds, scene->facts.bounds, sizeof m->facts.bounds);
    facts_origin(m->core, scene->splats.origin);
    memcpy(m->facts.origin, scene->splats.origin, sizeof m->facts.origin);
    memcpy(scene->core, m->core, sizeof m->core);
    prepare_decide(scene, params, scene->objects[0].estimated ? m->facts.splats : 0, &m->facts);
    if (scene->objects[0].epsilon == 0)
        scene->objects[0].epsilon = (double)m->facts.radius_median;
    scene->facts = m->facts;
    scene->prepared = true;
}

enum stp_result prepare_stream(const struct stp_env *env, struct stp_scene *scene,
                               const struct stp_prepare_params *params, bool *whole)
{
    struct measuring m = { .stream = scene->stream, .facts = scene->facts };
    m.stream->clipped = params->clip_box != NULL;
    if (m.stream->clipped)
        memcpy(m.stream->clip_box, params->clip_box, sizeof m.stream->clip_box);
    m.bins = mem_zalloc(RADII_BINS, sizeof *m.bins);
    begin_measuring(&m);
    enum stp_result result = m.bins ? pass_over(env, scene, &m)
                                    : log_no_memory(env, RADII_BINS * sizeof *m.bins, "radii");
    mem_free(m.bins);
    stream_cells_release(&m.cells);
    *whole = result == STP_OK && m.lack;
    if (*whole)
        log_warning(env, "read whole: %s", m.lack);
    else if (result == STP_OK)
        keep(scene, params, &m);
    return result;
}
