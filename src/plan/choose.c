#include "plan/plan.h"

#include <math.h>
#include <stdio.h>

#include "base/log.h"

#define LEAST_DEPTH_BITS 8           /* packed keys: epsilon is at least 2^8 quantised steps */
#define MOST_SHARED      0x7f000000u /* keys hold 31 bits of id */

bool plan_of_medium(const struct stp_facts *facts)
{
    return facts->volume.dims[0] || facts->range.frames;
}

static enum stp_method resolve_method(const struct stp_facts *facts,
                                      const struct stp_render_params *params,
                                      const struct stp_limits *limits)
{
    enum stp_transparency transparency = plan_resolve_transparency(facts, params, limits);
    if (transparency != STP_TRANSPARENCY_AUTO)
        return plan_transparency_method(transparency);
    bool lists = params->method == STP_METHOD_AUTO ? plan_of_medium(facts)
                                                   : params->method == STP_METHOD_AXIS;
    if (lists && params->axis_merge == STP_AXIS_REFERENCE)
        return STP_METHOD_REFERENCE;
    if (params->method != STP_METHOD_AUTO)
        return params->method;
    if (params->shade != STP_SHADE_PIXEL)
        return STP_METHOD_TWO_PASS;
    return plan_of_medium(facts) ? STP_METHOD_AXIS : STP_METHOD_EXACT;
}

bool stp_plan_needs_groups(const struct stp_facts *facts, const struct stp_render_params *params,
                           const struct stp_limits *limits)
{
    params = plan_params(params);
    return !plan_of_medium(facts) && !facts->transparent &&
           resolve_method(facts, params, limits) == STP_METHOD_DEFERRED;
}

/* Blocks in compute but where the rasteriser is asked for: measured (docs/results/axis.md). */
static enum stp_result choose_axis(const struct stp_env *env, struct stp_plan *plan)
{
    const unsigned needed = STP_FEATURE_FLOAT32_BLEND | STP_FEATURE_STORAGE_FORMATS;
    const unsigned aovs = STP_AOV_POSITION | STP_AOV_COVERAGE | STP_AOV_LAYERS;
    enum stp_path path = plan->params.path;
    if (path == STP_PATH_AUTO)
        path = STP_PATH_COMPUTE;
    if (plan_samples(plan) > 1)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method axis has one sample a pixel, at its centre; for %u use --method "
                         "reference",
                         plan_samples(plan));
    if (plan->params.aovs & ~aovs)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method axis has the aovs P, coverage and layers; for others use --method "
                         "reference");
    if (path == STP_PATH_RASTER && (plan->limits.features & needed) != needed)
        return log_error(env, STP_ERROR_FEATURE,
                         "axis --path raster needs blending into float32 images and "
                         "shaderStorageImageExtendedFormats, which the device lacks; use --path "
                         "compute");
    if (plan->params.axis_merge == STP_AXIS_AUTO)
        plan->params.axis_merge = plan->params.method == STP_METHOD_AUTO && plan->params.axis_h == 0
                                      ? STP_AXIS_SORT
                                      : STP_AXIS_BLEND;
    plan->path = path;
    return STP_OK;
}

static enum stp_result choose_path(const struct stp_env *env, struct stp_plan *plan)
{
    unsigned features = plan->limits.features;
    bool atomics = (features & STP_FEATURE_INT64_ATOMICS) != 0;
    bool formats = (features & STP_FEATURE_STORAGE_FORMATS) != 0;
    enum stp_path path = plan->params.path;
    unsigned samples = plan_samples(plan);
    if (plan->method == STP_METHOD_AXIS)
        return choose_axis(env, plan);
    if (path == STP_PATH_RASTER && samples > 1)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "--path raster has one sample a pixel, at its centre, not %u; use --path "
                         "compute",
                         samples);
    if (path == STP_PATH_AUTO) {
        bool peel = plan->transparency == STP_TRANSPARENCY_PEEL;
        bool raster = plan_covers(plan) || (peel && !atomics) ||
                      (plan->method == STP_METHOD_DEFERRED && !atomics && formats && samples == 1);
        path = raster ? STP_PATH_RASTER : STP_PATH_COMPUTE;
    }
    if (path == STP_PATH_RASTER && plan->method == STP_METHOD_EXACT)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method exact has no raster path; ask for compute, or for two-pass");
    if (path == STP_PATH_RASTER && plan->method == STP_METHOD_PYRAMID)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "method pyramid has no raster path; ask for compute");
    if (path == STP_PATH_RASTER && !formats)
        return log_error(env, STP_ERROR_FEATURE,
                         "--path raster needs shaderStorageImageExtendedFormats, which the device "
                         "lacks; use --path compute");
    if (path == STP_PATH_COMPUTE && plan->method == STP_METHOD_DEFERRED && !atomics)
        return log_error(env, STP_ERROR_FEATURE,
                         "deferred --path compute%s needs shaderBufferInt64Atomics, which the "
                         "device lacks; use %s--method exact",
                         samples > 1 ? ", which several samples take," : "",
                         samples > 1 || !formats ? "" : "--path raster or ");
    if (path == STP_PATH_RASTER &&
        (plan->method == STP_METHOD_TWO_PASS || plan->transparency != STP_TRANSPARENCY_AUTO) &&
        !(features & STP_FEATURE_FLOAT32_BLEND))
        return log_error(env, STP_ERROR_FEATURE,
                         "--path raster needs blending into float32 images, which the "
                         "device lacks; use --path compute");
    plan->path = path;
    return STP_OK;
}

static enum stp_result choose_voronoi(const struct stp_env *env, struct stp_plan *plan)
{
    enum stp_voronoi voronoi = plan->params.voronoi;
    if (plan->method != STP_METHOD_DEFERRED) {
        plan->voronoi = STP_VORONOI_OFF;
        return STP_OK;
    }
    /* At c = 1 the seams of the slabs are most of the error that is left (docs/results). */
    if (voronoi == STP_VORONOI_DEFAULT)
        voronoi = plan->facts.grouping.overlap < 1 || plan->path == STP_PATH_RASTER
                      ? STP_VORONOI_SLAB
                      : STP_VORONOI_EXACT;
    if (voronoi == STP_VORONOI_EXACT && plan->path == STP_PATH_RASTER)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "--voronoi exact needs the compute path; the rasteriser offers slab");
    double slabs = (double)plan->frame.depth_scale * ldexp(1, -(int)plan->frame.depth_bits);
    if (voronoi == STP_VORONOI_SLAB && !(slabs > 0))
        voronoi = STP_VORONOI_OFF;
    plan->voronoi = voronoi;
    return STP_OK;
}

/* Traits hold colours of 0 to 1, and splats with normal fields have none (glsl/lib/terms.glsl). */
static bool codes_colors(const struct stp_facts *facts)
{
    return facts->has_color && facts->color_min >= 0 && facts->color_max <= 1 && !facts->phong;
}

/* Packed keys need a depth range that 24 bits hold, and, deferred, nothing that asks for ids. What
 * `fast` packs has its depth as a float beside it. */
static void choose_payload(struct stp_plan *plan, double range_over_epsilon)
{
    bool wants_ids = plan->facts.has_color || plan->constant[PLAN_OPACITY] == 2 ||
                     plan->facts.objects > 1 || (plan->params.aovs & STP_AOV_ID) != 0;
    bool fits = plan->frame.depth_bits >= LEAST_DEPTH_BITS &&
                (!wants_ids || plan_splats(plan) <= STP_TRAITS_IDS);
    bool opaque = plan->transparency == STP_TRANSPARENCY_AUTO;
    bool packable = fits && plan->voronoi != STP_VORONOI_EXACT &&
                    (plan->method == STP_METHOD_EXACT ||
                     (plan->method == STP_METHOD_DEFERRED && opaque && !wants_ids));
    packable = packable || (!wants_ids && plan_packs_winners(plan));
    bool packed = packable && plan->params.payload != STP_PAYLOAD_ID;
    plan->payload = packed ? STP_PAYLOAD_PACKED : STP_PAYLOAD_ID;
    if (!packed && plan->voronoi == STP_VORONOI_SLAB && range_over_epsilon > STP_SLAB_MOST)
        plan->voronoi = STP_VORONOI_OFF;
    plan->constant[PLAN_PACKED] = packed;
    bool slots = packed && plan->method == STP_METHOD_EXACT;
    plan->constant[PLAN_KEY_IDS] = slots && wants_ids;
    plan->constant[PLAN_COLOR_CODES] = slots && !opaque && codes_colors(&plan->facts);
}

static void explain_axis(struct stp_plan *plan, const char *asked)
{
    static const char *const orders[] = {
        [STP_AXIS_BLEND] = "lists along the axes, blended by what each pixel's ray says",
        [STP_AXIS_CLIP] = "lists along the axes, of which each pixel takes its ray's",
        [STP_AXIS_SINGLE] = "one list, along the axis nearest to the view's",
        [STP_AXIS_SORT] = "one list, sorted by distance from the eye",
    };
    const char *measured =
        plan->params.method != STP_METHOD_AUTO || plan->params.axis_merge != STP_AXIS_SORT ? ""
        : plan->facts.range.frames
            ? "; measured, that is as near to the exact order as axis lists from where a frame was "
              "taken, 7 dB nearer from aside, and one list for up to three"
            : "; measured, that is 7 dB and more nearer to the exact order than axis lists, and "
              "takes less time than blending three of them";
    snprintf(plan->why, sizeof plan->why, "axis is %s: %s, in strict order by %s%s.", asked,
             orders[plan->params.axis_merge],
             plan->path == STP_PATH_RASTER ? "the rasteriser" : "blocks of pixels in compute",
             measured);
}

static void explain_exact(struct stp_plan *plan, const char *asked)
{
    bool best = plan->transparency != STP_TRANSPARENCY_AUTO &&
                plan->params.transparency == STP_TRANSPARENCY_AUTO;
    bool chosen = plan->params.payload == STP_PAYLOAD_ID, bound = plan->params.prediction.bound > 0;
    const char *slots =
        plan->payload != STP_PAYLOAD_PACKED
            ? chosen
                  ? bound ? "slots carry ids, which round nothing" : "slots carry ids, as asked for"
                  : "slots carry ids, since the depth range over epsilon exceeds "
                    "packed depth"
        : plan->constant[PLAN_KEY_IDS]
            ? plan->constant[PLAN_PHONG]
                  ? "slots are packed, with ids beside for what they cannot hold"
                  : "slots are packed into 8 bytes, with ids in place of normals"
            : "slots are packed into 8 bytes";
    snprintf(plan->why, sizeof plan->why,
             "%s is %s: it needs no groups, keeps every fragment of one geometry pass and matches "
             "the reference%s; %s.",
             stp_method_name(plan->method), asked,
             best ? ", in less time than fast, nearest and peel take, which do not" : "", slots);
}

static void explain(struct stp_plan *plan)
{
    const char *method = stp_method_name(plan->method);
    const struct stp_prediction *p = &plan->params.prediction;
    char predicted[128];
    snprintf(predicted, sizeof predicted,
             "the cheapest within an error of %.3g (predicted: %.3g ms, error at most %.2g)",
             p->bound, p->milliseconds, p->error);
    const char *asked = p->bound > 0 && p->error <= p->bound     ? predicted
                        : p->bound > 0                           ? "the most exact that there is"
                        : plan->params.method == STP_METHOD_AUTO ? "chosen"
                                                                 : "asked for";
    char *why = plan->why;
    size_t size = sizeof plan->why;
    if (plan_covers(plan) || plan->transparency == STP_TRANSPARENCY_PEEL) {
        plan_explain_layers(plan, p->bound > 0 ? asked : "asked for");
        return;
    }
    switch (plan->method) {
    case STP_METHOD_EXACT:
        explain_exact(plan, asked);
        break;
    case STP_METHOD_DEFERRED:
        snprintf(why, size,
                 "%s is %s: %u group%s at overlap %.3g, one geometry pass by %s, %s keys, Voronoi "
                 "%s.",
                 method, asked, plan->facts.grouping.groups,
                 plan->facts.grouping.groups == 1 ? "" : "s", plan->facts.grouping.overlap,
                 stp_path_name(plan->path), plan->payload == STP_PAYLOAD_PACKED ? "packed" : "id",
                 plan->voronoi == STP_VORONOI_OFF    ? "off"
                 : plan->voronoi == STP_VORONOI_SLAB ? "slab"
                                                     : "exact");
        break;
    case STP_METHOD_PYRAMID:
        snprintf(why, size,
                 "%s is %s: one pixel a point, %u levels, since the largest splat is at most 2^%u "
                 "pixels across.",
                 method, asked, plan->levels, plan->levels - 1);
        break;
    case STP_METHOD_AXIS:
        explain_axis(plan, asked);
        break;
    case STP_METHOD_TWO_PASS:
        snprintf(why, size, "%s is %s: two geometry passes by %s, the classical baseline.", method,
                 asked, stp_path_name(plan->path));
        break;
    default:
        snprintf(why, size, "%s is %s: float64 on the CPU, no device.", method, asked);
    }
}

void plan_leave_device(struct stp_plan *plan)
{
    plan->method = STP_METHOD_REFERENCE;
    plan->path = STP_PATH_AUTO;
    plan->payload = STP_PAYLOAD_AUTO;
    plan->voronoi = STP_VORONOI_DEFAULT;
    snprintf(plan->why, sizeof plan->why,
             "reference is chosen: %zu splats are more than the device's %llu bytes hold; float64 "
             "on the CPU.",
             plan->facts.splats, (unsigned long long)plan->limits.heap_bytes);
}

/* Sort-last: minima and sums in fixed point are what several processes can compose to the same
 * bits, and only two-pass by compute is made of nothing else. */
static enum stp_result choose_share(const struct stp_env *env, struct stp_plan *plan)
{
    struct stp_render_params *p = &plan->params;
    if (!plan->share.count)
        return STP_OK;
    if (p->method == STP_METHOD_AUTO)
        p->method = STP_METHOD_TWO_PASS;
    if (p->method != STP_METHOD_TWO_PASS || p->path == STP_PATH_RASTER)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "several processes make one picture by --method two-pass --path compute "
                         "only; for other methods split frames (--split frames)");
    if (plan->facts.transparent)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "several processes make one picture of opaque scenes only; this one is "
                         "transparent: split frames (--split frames)");
    if (plan->facts.splats > MOST_SHARED)
        return log_error(env, STP_ERROR_ARGUMENT, "%zu splats in all: at most %u",
                         plan->facts.splats, MOST_SHARED);
    p->path = STP_PATH_COMPUTE;
    return STP_OK;
}

/* What the method cannot draw, or not yet. */
static enum stp_result check_method(const struct stp_env *env, const struct stp_plan *plan)
{
    if (plan_of_medium(&plan->facts) && plan->method != STP_METHOD_AXIS)
        return log_error(env, STP_ERROR_ARGUMENT,
                         plan->facts.range.frames
                             ? "method %s draws discs; range images take axis or reference, or "
                               "--range-splats discs"
                             : "method %s draws surfaces; a volume takes axis or reference",
                         stp_method_name(plan->method));
    if (!plan_covers(plan) && plan->method == STP_METHOD_DEFERRED &&
        plan->facts.grouping.groups == 0)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "the deferred method needs stp_scene_group before its plan");
    return plan_check_phong(env, plan);
}

static void choose_constants(struct stp_plan *plan)
{
    uint32_t *c = plan->constant;
    bool cover = plan_covers(plan);
    c[PLAN_GROUPS] = cover                                 ? plan->facts.cover.groups
                     : plan->method == STP_METHOD_DEFERRED ? plan->facts.grouping.groups
                                                           : 1;
    c[PLAN_VORONOI] = plan->voronoi == STP_VORONOI_SLAB    ? 1
                      : plan->voronoi == STP_VORONOI_EXACT ? 2
                                                           : 0;
    c[PLAN_BINS] = plan_bins(plan);
    c[PLAN_ATOMIC64] = (plan->limits.features & STP_FEATURE_INT64_ATOMICS) != 0;
    c[PLAN_FLOAT64] = (plan->limits.features & STP_FEATURE_FLOAT64) != 0;
    /* Measured: on a CPU device a pass a layer beats one layered pass. */
    c[PLAN_LAYERED] = !cover && plan->path == STP_PATH_RASTER &&
                      plan->method == STP_METHOD_DEFERRED &&
                      (plan->limits.features & STP_FEATURE_VERTEX_LAYER) != 0 &&
                      plan->limits.processor == STP_PROCESSOR_GPU &&
                      plan->facts.grouping.groups <= plan->limits.max_image_layers;
}

enum stp_result plan_choose(const struct stp_env *env, struct stp_plan *plan)
{
    enum stp_result result = choose_share(env, plan);
    if (result == STP_OK)
        result = plan_choose_transparency(env, plan);
    if (result == STP_OK)
        result = plan_deep_check(env, plan);
    if (result != STP_OK)
        return result;
    plan->method = resolve_method(&plan->facts, &plan->params, &plan->limits);
    result = plan_check_axis_surface(env, plan);
    if (result == STP_OK)
        result = plan_check_shade(env, plan);
    if (result == STP_OK)
        result = plan_light_cube(env, plan);
    if (result != STP_OK)
        return result;
    if (plan->method == STP_METHOD_REFERENCE) {
        explain(plan);
        return STP_OK;
    }
    result = check_method(env, plan);
    if (result == STP_OK)
        result = choose_path(env, plan);
    if (result == STP_OK)
        result = choose_voronoi(env, plan);
    if (result != STP_OK)
        return result;
    choose_payload(plan, ldexp(1, STP_DEPTH_BITS - (int)plan->frame.depth_bits));
    choose_constants(plan);
    if (plan->method == STP_METHOD_PYRAMID)
        plan_pyramid_view(plan);
    explain(plan);
    return STP_OK;
}
