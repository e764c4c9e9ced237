/* HM 5: every walk into its own pair of images, by the rasteriser and in the order of its list;
 * then one pass that merges them by what each pixel's ray says. */
#include "plan/plan.h"

#include <math.h>
#include <stdio.h>

#include "base/log.h"
#include "base/vec.h"
#include "scene/scene.h"
#include "scene/volume.h"

#define DEFAULT_H 0.85 /* HM 5.2 */

/* Of a kernel, in the frame of the shaders: x right, y down, z forward. */
static void set_shape(struct stp_plan *plan, const struct volume *volume)
{
    struct stp_axis_gpu *axis = &plan->frame.axis;
    double precision[6] = { 0 }, half[3] = { 0 };
    for (int a = 0; a < 3; a++) {
        double s = KERNEL_SIGMA * volume->grid.spacing[a], w = 1 / (s * s);
        const double *m = plan->camera.world_to_camera;
        const double d[3] = { m[a], -m[4 + a], -m[8 + a] };
        for (int i = 0, at = 0; i < 3; i++) {
            half[i] += s * s * d[i] * d[i];
            for (int j = i; j < 3; j++)
                precision[at++] += w * d[i] * d[j];
        }
    }
    for (int i = 0; i < 6; i++)
        axis->shape[i] = (float)precision[i];
    for (int i = 0; i < 3; i++)
        axis->extent[i] = (float)(KERNEL_REACH * sqrt(half[i]));
    axis->scale = (float)(kernel_amplitude() * sqrt(2 * M_PI));
    axis->reach2 = (float)(KERNEL_REACH * KERNEL_REACH);
    axis->least_alpha = (float)LEAST_ALPHA;
}

/* Does near or far cut any kernel? Else shaders have no code for it. */
static bool is_cut(const struct stp_plan *plan, const struct stp_scene *scene)
{
    const double *b = scene->core;
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 8; i++) {
        struct vec3 corner = v3(b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]);
        double depth = -m4_point(plan->camera.world_to_camera, corner).z;
        low = fmin(low, depth);
        high = fmax(high, depth);
    }
    /* The tails beyond the reach: half as much again leaves a share of 1 - 3e-6. */
    double more = 0.5 * (double)plan->frame.axis.extent[2];
    return low - more < plan->camera.near_depth || high + more > plan->camera.far_depth;
}

enum stp_result plan_axis_prepare(const struct stp_env *env, struct stp_plan *plan,
                                  const struct stp_scene *scene)
{
    double h = plan->params.axis_h == 0 ? DEFAULT_H : fmax(plan->params.axis_h, 0);
    if (!(h < 1))
        return log_error(env, STP_ERROR_ARGUMENT, "axis h %g: it must be below 1", h);
    enum stp_result result =
        axis_lists_build(env, scene, &plan->camera, plan->params.axis_merge, h, &plan->axis);
    if (result != STP_OK)
        return result;
    struct stp_axis_gpu *axis = &plan->frame.axis;
    set_shape(plan, scene->volume);
    axis->h = (float)h;
    axis->merge = (uint32_t)plan->params.axis_merge;
    for (unsigned i = 0; i < plan->axis.walk_count; i++)
        axis->walk[i] = plan->axis.walk[i].axis | (plan->axis.walk[i].backwards ? 4u : 0u);
    plan->constant[PLAN_AXIS_WALKS] = plan->axis.walk_count;
    plan->constant[PLAN_AXIS_CUT] = is_cut(plan, scene);
    plan->constant[PLAN_UNLIT] = scene->volume->unshaded;
    return STP_OK;
}

static void draw_walk(struct stp_plan *plan, unsigned index)
{
    static const char *const names[] = { "+x", "-x", "+y", "-y", "+z", "-z" };
    const struct axis_walk *walk = &plan->axis.walk[index];
    char name[40];
    snprintf(name, sizeof name, "walk %s",
             plan->axis.merge == STP_AXIS_SORT ? "by distance"
                                               : names[2 * walk->axis + walk->backwards]);
    struct plan_pass *pass = plan_pass(plan, PLAN_DRAW, name);
    pass->vertex = PLAN_SHADER_AXIS_VERTEX;
    pass->shader = PLAN_SHADER_AXIS_FRAGMENT;
    pass->raster = PLAN_RASTER_OVER;
    pass->layer = index;
    pass->layer_count = 1;
    pass->first_splat = walk->first;
    pass->splat_count = walk->count;
    plan_reads(plan, pass, PLAN_PROJECTED);
    plan_attaches(plan, pass, PLAN_IMAGE_AXIS_COLOR);
    plan_attaches(plan, pass, PLAN_IMAGE_AXIS_DEPTH);
}

void plan_axis(struct stp_plan *plan)
{
    uint32_t walks = plan->axis.walk_count;
    if (walks) {
        plan_resource(plan, "projected", PLAN_PROJECTED, PLAN_TRANSIENT, plan->axis.count * 32);
        plan_image(plan, "walk color", PLAN_IMAGE_AXIS_COLOR, PLAN_RGBA32F, walks);
        plan_image(plan, "walk depth", PLAN_IMAGE_AXIS_DEPTH, PLAN_RG32F, walks);
        struct plan_pass *project = plan_pass(plan, PLAN_DISPATCH, "project");
        project->shader = PLAN_SHADER_AXIS_PROJECT;
        project->groups = (uint32_t)((plan->axis.count + STP_GROUP - 1) / STP_GROUP);
        plan_reads(plan, project, PLAN_SPLATS);
        plan_reads(plan, project, PLAN_MATERIALS);
        plan_writes(plan, project, PLAN_PROJECTED);
    }
    for (unsigned i = 0; i < walks; i++)
        draw_walk(plan, i);
    struct plan_pass *merge = plan_pass(plan, PLAN_DISPATCH, "merge");
    merge->shader = walks ? PLAN_SHADER_AXIS_MERGE : PLAN_SHADER_AXIS_EMPTY;
    plan_reads(plan, merge, PLAN_IMAGE_AXIS_COLOR);
    plan_reads(plan, merge, PLAN_IMAGE_AXIS_DEPTH);
    for (enum plan_slot slot = PLAN_OUT_COLOR; slot <= PLAN_OUT_DEPTH; slot++)
        plan_writes(plan, merge, slot);
}
