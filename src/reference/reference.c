#include "reference/reference.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "reference/gaussians.h"
#include "scene/samples.h"
#include "reference/tile.h"
#include "reference/volume.h"
#include "scene/camera.h"

struct job {
    const struct stp_env *env;
    const struct view *view;
    const struct bins *bins;
    const struct planes *planes;
    struct scratch *scratch; /* one a thread */
};

/* Method axis on a surface, in the exact order. */
static bool of_gaussians(const struct stp_scene *scene, const struct stp_render_params *params)
{
    return !scene->volume && params->axis_merge == STP_AXIS_REFERENCE &&
           (params->method == STP_METHOD_AXIS || params->method == STP_METHOD_REFERENCE);
}

static enum stp_result check(const struct stp_env *env, const struct stp_scene *scene,
                             const struct stp_camera *camera,
                             const struct stp_render_params *params)
{
    if (!scene->prepared)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the scene must be prepared before it is rendered");
    if (scene->splats.count == 0 && !scene->volume)
        return log_error(env, STP_ERROR_NO_POINTS, "the scene has no splats to render");
    if (params->samples > STP_MAX_SAMPLES)
        return log_error(env, STP_ERROR_ARGUMENT, "%u samples a pixel: at most %u", params->samples,
                         STP_MAX_SAMPLES);
    if (!(params->epsilon >= 0) || isnan(params->min_splat))
        return log_error(env, STP_ERROR_ARGUMENT, "epsilon %g or min-splat %g is out of range",
                         params->epsilon, params->min_splat);
    if (params->deep && (params->samples > 1 || scene->volume || of_gaussians(scene, params)))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "no deep picture of a volume, of Gaussians in order, nor of several "
                         "samples a pixel");
    if (params->shade != STP_SHADE_PIXEL &&
        (scene->facts.transparent || scene->environment.map.width))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "--shade splat and flat draw opaque scenes without an environment");
    if (params->environment_behind && !scene->environment.map.width)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the scene has no environment to stand behind it");
    return camera_check(env, camera);
}

struct view reference_view(const struct stp_scene *scene, const struct stp_camera *camera,
                           const struct stp_render_params *params)
{
    struct view view = { .scene = scene,
                         .width = camera->width,
                         .height = camera->height,
                         .kernel = params->kernel,
                         .shade = params->shade,
                         .single_layer = params->layers == STP_LAYERS_SINGLE,
                         .cull_back = params->cull == STP_CULL_BACK,
                         .two_sided = scene->facts.two_sided,
                         .local_viewer = params->local_viewer,
                         .gaussians = of_gaussians(scene, params),
                         .transparent = scene->facts.transparent,
                         .deep = params->deep && scene->facts.transparent,
                         .epsilon = params->epsilon,
                         .grid = sample_grid(params->samples) };
    view.min_splat = params->min_splat == 0 ? STP_DEFAULT_MIN_SPLAT : fmax(0, params->min_splat);
    eye_init(&view.eye, camera, scene->splats.origin);
    return view;
}

static void render_tiles(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct job *job = context;
    size_t tiles = (size_t)job->bins->across * job->bins->down;
    for (size_t tile = begin; tile < end; tile++)
        tile_render(job->view, job->bins, tile, &job->scratch[worker], job->planes);
    if (worker == 0) /* the caller's own thread */
        log_progress(job->env, "reference", (double)end / (double)tiles);
}

/* The layers that the threads have kept become the picture's. */
static enum stp_result finish_deep(const struct stp_env *env, const struct view *view,
                                   const struct scratch *scratch, unsigned threads,
                                   struct stp_image *image)
{
    bool failed = false;
    struct deep_list *lists = mem_alloc(threads, sizeof *lists);
    for (unsigned i = 0; i < threads; i++)
        failed = failed || scratch[i].no_memory;
    for (unsigned i = 0; lists && i < threads; i++)
        lists[i] = scratch[i].deep;
    enum stp_result result =
        !lists || failed
            ? log_no_memory(env, threads * sizeof *lists, "the layers of a deep picture")
            : deep_build(env, lists, threads, (size_t)view->width * view->height, &image->deep);
    mem_free(lists);
    return result;
}

static enum stp_result render(const struct stp_env *env, const struct view *view,
                              const struct planes *planes, const struct stp_render_params *params,
                              struct stp_image *image)
{
    unsigned threads = thread_count(env);
    struct bins bins;
    struct scratch *scratch = mem_zalloc(threads, sizeof *scratch);
    if (!scratch)
        return log_no_memory(env, threads * sizeof *scratch, "the reference's tiles");
    enum stp_result result = bins_build(env, view, &bins);
    if (result == STP_OK) {
        struct job job = { env, view, &bins, planes, scratch };
        parallel_for(env, (size_t)bins.across * bins.down, 1, render_tiles, &job);
        planes_finish(env, planes, view, params);
        bins_release(&bins);
    }
    if (result == STP_OK && view->deep)
        result = finish_deep(env, view, scratch, threads, image);
    for (unsigned i = 0; i < threads; i++) {
        if (result == STP_OK && view->gaussians && scratch[i].no_memory)
            result = log_no_memory(env, 2 * scratch[i].gaussians.capacity * sizeof(struct gaussian),
                                   "the fragments of a tile");
        gaussians_release(&scratch[i].gaussians);
        deep_list_release(&scratch[i].deep);
    }
    mem_free(scratch);
    return result;
}

enum stp_result reference_render(const struct stp_env *env, const struct stp_scene *scene,
                                 const struct stp_camera *camera,
                                 const struct stp_render_params *params, struct stp_image **image)
{
    struct stp_image *made = NULL;
    struct planes planes;
    enum stp_result result = check(env, scene, camera, params);
    if (result == STP_OK)
        result = planes_create(env, scene, camera, params->aovs, &made, &planes);
    if (result != STP_OK)
        return result;
    struct view view = reference_view(scene, camera, params);
    result = scene->volume ? medium_render(env, &view, &planes, params, LEAST_ALPHA)
                           : render(env, &view, &planes, params, made);
    if (result == STP_OK)
        *image = made;
    else
        stp_image_destroy(&made);
    return result;
}
