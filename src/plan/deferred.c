/* Zhang & Pajarola 2006, Algorithm 1: one geometry pass into K depth-images, then Fig. 5. */
#include "plan/plan.h"

#include <stdio.h>

static void keys(struct stp_plan *plan)
{
    uint64_t images = plan_pixels(plan) * plan->facts.grouping.groups;
    plan_resource(plan, "keys", PLAN_KEYS, PLAN_TRANSIENT, images * 8);
    plan_fill(plan, PLAN_KEYS, 0xffffffffu, "clear keys");
    if (plan->voronoi == STP_VORONOI_EXACT) {
        plan_resource(plan, "nearest", PLAN_NEAREST, PLAN_TRANSIENT, images * 4);
        plan_fill(plan, PLAN_NEAREST, 0x7f800000u, "clear nearest");
        plan_splat(plan, "nearest", PLAN_SHADER_DEFERRED_NEAREST,
                   PLAN_SHADER_DEFERRED_NEAREST_LARGE, false,
                   (enum plan_slot[]){ PLAN_NEAREST, PLAN_SLOTS });
        /* The second pass finds its large splats and blocks anew. */
        struct plan_pass *pass = plan_pass(plan, PLAN_ARGUMENTS, "reset arguments");
        plan_writes(plan, pass, PLAN_WORK);
    }
    plan_splat(plan, "keys", PLAN_SHADER_DEFERRED_KEYS, PLAN_SHADER_DEFERRED_KEYS_LARGE, false,
               (enum plan_slot[]){ PLAN_KEYS, PLAN_NEAREST, PLAN_SLOTS });
    plan_blocks(plan);
    plan_resolve(plan, "composite", PLAN_SHADER_DEFERRED_COMPOSITE, false,
                 (enum plan_slot[]){ PLAN_KEYS, PLAN_SLOTS });
}

/* The layers of one layered target: one pass where the vertex shader may choose the layer. */
static void layers(struct stp_plan *plan)
{
    uint32_t groups = plan->facts.grouping.groups;
    plan_image(plan, "winners", PLAN_IMAGE_ID, PLAN_RG32UI, groups);
    plan_image(plan, "depth", PLAN_IMAGE_DEPTH, PLAN_D32F, groups);
    bool layered = plan->constant[PLAN_LAYERED] != 0;
    if (!layered)
        plan_resource(plan, "order", PLAN_ORDER, PLAN_SCENE, (uint64_t)plan->facts.splats * 4);
    for (uint32_t k = 0; k < (layered ? 1 : groups); k++) {
        char name[40];
        snprintf(name, sizeof name, layered ? "layers" : "layer %u", k);
        struct plan_pass *pass = plan_pass(plan, PLAN_DRAW, name);
        pass->vertex =
            layered ? PLAN_SHADER_RASTER_VERTEX_LAYERS : PLAN_SHADER_RASTER_VERTEX_ORDERED;
        pass->shader = plan->constant[PLAN_PACKED] ? PLAN_SHADER_DEFERRED_FRAGMENT_PACKED
                                                   : PLAN_SHADER_DEFERRED_FRAGMENT;
        pass->raster = PLAN_RASTER_WINNER;
        pass->layer = k;
        pass->layer_count = layered ? groups : 1;
        pass->first_splat = layered ? 0 : plan->group_first[k];
        pass->splat_count =
            layered ? (uint32_t)plan->facts.splats : plan->group_first[k + 1] - pass->first_splat;
        plan_reads(plan, pass, PLAN_SPLATS);
        plan_reads(plan, pass, PLAN_ORDER);
        plan_attaches(plan, pass, PLAN_IMAGE_ID);
        plan_attaches(plan, pass, PLAN_IMAGE_DEPTH);
    }
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "composite");
    pass->shader = PLAN_SHADER_DEFERRED_COMPOSITE_IMAGE;
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_MATERIALS);
    plan_reads(plan, pass, PLAN_OBJECT_OPTICS);
    plan_reads(plan, pass, PLAN_ENVIRONMENT);
    plan_reads(plan, pass, PLAN_IMAGE_ID);
    for (enum plan_slot slot = PLAN_OUT_COLOR; slot <= PLAN_OUT_ID; slot++)
        plan_writes(plan, pass, slot);
}

void plan_deferred(struct stp_plan *plan)
{
    if (plan->path == STP_PATH_COMPUTE)
        keys(plan);
    else
        layers(plan);
}
