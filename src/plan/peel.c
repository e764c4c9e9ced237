/* Depth peeling (ZP 2, 6.2), the baseline: the two-pass method once a layer. The passes are the
 * same for every layer and are repeated; what is left of the ray lies in the picture itself. */
#include "plan/plan.h"

/* Before the first layer: nothing is peeled, nothing is composited. */
void plan_peel_begin(struct stp_plan *plan)
{
    plan_resource(plan, "peeled", PLAN_NEAREST, PLAN_TRANSIENT,
                  (uint64_t)plan->tile_width * plan->tile_height * 4);
    plan_fill(plan, PLAN_NEAREST, 0xff800000u, "nothing peeled");
}

static struct plan_pass *draw(struct stp_plan *plan, const char *name, enum plan_shader fragment,
                              enum plan_raster raster)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DRAW, name);
    pass->vertex = PLAN_SHADER_RASTER_VERTEX;
    pass->shader = fragment;
    pass->raster = raster;
    pass->layer_count = 1;
    pass->splat_count = (uint32_t)plan->facts.splats;
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OPACITIES);
    plan_reads(plan, pass, PLAN_MATERIALS);
    return pass;
}

void plan_peel(struct stp_plan *plan)
{
    bool colors = plan->constant[PLAN_HAS_COLOR] || plan->constant[PLAN_OPACITY] == 2;
    plan_image(plan, "nearest", PLAN_IMAGE_ID, PLAN_RG32UI, 1);
    plan_image(plan, "depth", PLAN_IMAGE_DEPTH, PLAN_D32F, 1);
    plan_image(plan, "sum", PLAN_IMAGE_SUM, PLAN_RGBA32F, 1);
    plan_image(plan, "depth sum", PLAN_IMAGE_SUM_DEPTH, PLAN_RG32F, 1);
    if (colors)
        plan_image(plan, "color sum", PLAN_IMAGE_SUM_COLOR, PLAN_RGBA32F, 1);
    struct plan_pass *pass =
        draw(plan, "visibility", PLAN_SHADER_PEEL_DEPTH_FRAGMENT, PLAN_RASTER_WINNER);
    plan_reads(plan, pass, PLAN_NEAREST);
    plan_attaches(plan, pass, PLAN_IMAGE_ID);
    plan_attaches(plan, pass, PLAN_IMAGE_DEPTH);
    pass = draw(plan, "blend", PLAN_SHADER_PEEL_SUM_FRAGMENT, PLAN_RASTER_BLEND);
    plan_reads(plan, pass, PLAN_IMAGE_ID);
    plan_attaches(plan, pass, PLAN_IMAGE_SUM);
    plan_attaches(plan, pass, PLAN_IMAGE_SUM_DEPTH);
    plan_attaches(plan, pass, PLAN_IMAGE_SUM_COLOR);
    pass = plan_pass(plan, PLAN_DISPATCH, "peel");
    pass->shader = colors ? PLAN_SHADER_PEEL_RESOLVE_COLOR : PLAN_SHADER_PEEL_RESOLVE;
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OPACITIES);
    plan_reads(plan, pass, PLAN_MATERIALS);
    for (enum plan_slot slot = PLAN_IMAGE_ID; slot <= PLAN_IMAGE_SUM_COLOR; slot++)
        if (slot != PLAN_IMAGE_DEPTH)
            plan_reads(plan, pass, slot);
    plan_updates(plan, pass, PLAN_NEAREST);
    for (enum plan_slot slot = PLAN_OUT_COLOR; slot <= PLAN_OUT_ID; slot++)
        plan_updates(plan, pass, slot);
}
