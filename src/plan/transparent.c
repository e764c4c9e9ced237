/* Zhang & Pajarola 2006, Algorithms 2 and 3: the groups that each cover the surface (4.2), blended
 * back to front into K images; for Algorithm 3 the nearest layer apart. By the rasteriser, whose
 * blending follows the order of the splats. */
#include "plan/plan.h"

#include <stdio.h>

static struct plan_pass *draw_group(struct stp_plan *plan, const char *name, uint32_t k)
{
    char full[40];
    snprintf(full, sizeof full, "%s %u", name, k);
    struct plan_pass *pass = plan_pass(plan, PLAN_DRAW, full);
    pass->layer = k;
    pass->layer_count = 1;
    pass->scale = (float)plan->facts.cover.factor[k];
    pass->shift = (float)k / (float)plan->facts.cover.groups;
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OPACITIES);
    plan_reads(plan, pass, PLAN_MATERIALS);
    plan_reads(plan, pass, PLAN_OBJECT_OPTICS);
    plan_reads(plan, pass, PLAN_ENVIRONMENT);
    plan_reads(plan, pass, PLAN_ORDER);
    return pass;
}

/* Algorithm 2, geometry pass: back to front, one fragment of a slab (ZP Eq. 6). */
static void blend_groups(struct stp_plan *plan, const char *name, enum plan_shader fragment)
{
    for (uint32_t k = 0; k < plan->facts.cover.groups; k++) {
        struct plan_pass *pass = draw_group(plan, name, k);
        pass->vertex = PLAN_SHADER_TRANSPARENT_VERTEX;
        pass->shader = fragment;
        pass->raster = PLAN_RASTER_OVER;
        pass->first_splat = plan->cover_first[k];
        pass->splat_count = plan->cover_first[k + 1] - plan->cover_first[k];
        if (fragment == PLAN_SHADER_TRANSPARENT_BLEND_FRAGMENT)
            plan_attaches(plan, pass, PLAN_IMAGE_ID);
        else
            plan_reads(plan, pass, PLAN_NEAREST);
        plan_attaches(plan, pass, PLAN_IMAGE_DEPTH);
        plan_attaches(plan, pass, PLAN_IMAGE_SUM);
    }
}

/* Algorithm 1's geometry pass over the groups before they were extended. */
static void nearest_layers(struct stp_plan *plan)
{
    for (uint32_t k = 0; k < plan->facts.cover.groups; k++) {
        struct plan_pass *pass = draw_group(plan, "nearest", k);
        pass->vertex = PLAN_SHADER_RASTER_VERTEX_ORDERED;
        pass->shader = PLAN_SHADER_DEFERRED_FRAGMENT;
        pass->raster = PLAN_RASTER_WINNER;
        pass->first_splat = (uint32_t)plan->facts.cover.members + plan->group_first[k];
        pass->splat_count = plan->group_first[k + 1] - plan->group_first[k];
        plan_attaches(plan, pass, PLAN_IMAGE_ID);
        plan_attaches(plan, pass, PLAN_IMAGE_DEPTH);
    }
}

/* Also where the first layer of each pixel ends: the least depth of all groups, plus epsilon. */
static void mask(struct stp_plan *plan)
{
    plan_touched(plan, "mask", PLAN_SHADER_TOUCHED_MASK);
    struct plan_pass *pass = &plan->pass[plan->pass_count - 1];
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_MATERIALS);
    plan_writes(plan, pass, PLAN_NEAREST);
}

static void resources(struct stp_plan *plan, bool nearest)
{
    uint32_t groups = plan->facts.cover.groups;
    uint64_t homes = nearest ? plan->group_first[groups] : 0;
    plan_resource(plan, "order", PLAN_ORDER, PLAN_SCENE,
                  ((uint64_t)plan->facts.cover.members + homes) * 4);
    plan_image(plan, "nearest", PLAN_IMAGE_ID, PLAN_RG32UI, groups);
    /* A layer a group: draws that share nothing overlap. nearest gains nothing by it. */
    plan_image(plan, "slab", PLAN_IMAGE_DEPTH, PLAN_D32F, nearest ? 1 : groups);
    plan_image(plan, "blended", PLAN_IMAGE_SUM, PLAN_RGBA32F, groups);
    if (nearest)
        plan_resource(plan, "mask", PLAN_NEAREST, PLAN_TRANSIENT,
                      (uint64_t)plan->tile_width * plan->tile_height * 4);
}

static bool is_enlarged(const struct stp_facts *facts)
{
    for (unsigned k = 0; k < facts->cover.groups; k++)
        if (facts->cover.factor[k] > 1)
            return true;
    return false;
}

/* Only fast: the first layer of nearest is interpolated as well as can be. Glass asks for
 * materials, weights are wanted as they are. What is packed is rho^2 on the enlarged disc, which
 * gives that of the disc itself unless a floor holds one of the two, and up to 1, where a Gauss
 * kernel has not ended. */
bool plan_packs_winners(const struct stp_plan *plan)
{
    bool exact = !is_enlarged(&plan->facts) ||
                 (!(plan->frame.floor_size > 0) && plan->params.kernel != STP_KERNEL_GAUSS);
    return exact && plan->transparency == STP_TRANSPARENCY_FAST &&
           !(plan->constant[PLAN_OPTICS] & STP_OPTICS_GLASS) &&
           !(plan->params.aovs & STP_AOV_WEIGHT);
}

void plan_transparent(struct stp_plan *plan)
{
    const enum plan_slot images[] = { PLAN_IMAGE_ID, PLAN_IMAGE_SUM, PLAN_SLOTS };
    bool nearest = plan->transparency == STP_TRANSPARENCY_NEAREST;
    resources(plan, nearest);
    if (nearest) {
        nearest_layers(plan);
        mask(plan);
        blend_groups(plan, "others", PLAN_SHADER_TRANSPARENT_OTHERS_FRAGMENT);
    } else {
        blend_groups(plan, "blend", PLAN_SHADER_TRANSPARENT_BLEND_FRAGMENT);
        plan_touched(plan, "touched", PLAN_SHADER_TOUCHED);
    }
    plan_blocks(plan);
    plan_resolve(plan, "composite",
                 nearest ? PLAN_SHADER_TRANSPARENT_COMPOSITE_NEAREST
                         : PLAN_SHADER_TRANSPARENT_COMPOSITE,
                 false, images);
}
