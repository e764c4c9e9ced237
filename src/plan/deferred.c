/* Zhang & Pajarola 2006, Algorithm 1: one geometry pass into K depth-images, then Fig. 5. */
#include "plan/offer.h"

#include <math.h>
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
               (enum plan_slot[]){ PLAN_KEYS, PLAN_SLOTS });
    plan_reads(plan, &plan->pass[plan->pass_count - 2], PLAN_NEAREST);
    plan_reads(plan, &plan->pass[plan->pass_count - 1], PLAN_NEAREST);
    plan_blocks(plan);
    plan_resolve(plan, "composite", PLAN_SHADER_DEFERRED_COMPOSITE, false,
                 (enum plan_slot[]){ PLAN_KEYS, PLAN_SLOTS });
}

/* The layers of one layered target: one pass where the vertex shader may choose the layer. */
static void layers(struct stp_plan *plan)
{
    uint32_t groups = plan->facts.grouping.groups;
    plan_image(plan, "winners", PLAN_IMAGE_ID, PLAN_RG32UI, groups);
    plan_image(plan, "depth test", PLAN_IMAGE_DEPTH, PLAN_D32F, groups);
    bool layered = plan->constant[PLAN_LAYERED] != 0;
    if (!layered)
        plan_resource(plan, "order", PLAN_ORDER, PLAN_SCENE, (uint64_t)plan->facts.splats * 4);
    for (uint32_t k = 0; k < (layered ? 1 : groups); k++) {
        char name[40];
        snprintf(name, sizeof name, layered ? "layers" : "layer %u", k);
        struct plan_pass *pass = plan_pass(plan, PLAN_DRAW, name);
        pass->vertex = plan_raster_shader(plan, layered ? PLAN_SHADER_RASTER_VERTEX_LAYERS
                                                        : PLAN_SHADER_RASTER_VERTEX_ORDERED);
        pass->shader = plan_raster_shader(plan, plan->constant[PLAN_PACKED]
                                                    ? PLAN_SHADER_DEFERRED_FRAGMENT_PACKED
                                                    : PLAN_SHADER_DEFERRED_FRAGMENT);
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
    plan_touched(plan, "touched", PLAN_SHADER_TOUCHED);
    plan_blocks(plan);
    plan_resolve(plan, "composite", PLAN_SHADER_DEFERRED_COMPOSITE_IMAGE, false,
                 (enum plan_slot[]){ PLAN_IMAGE_ID, PLAN_SLOTS });
}

void plan_deferred(struct stp_plan *plan)
{
    if (plan->path == STP_PATH_COMPUTE)
        keys(plan);
    else
        layers(plan);
}

static unsigned candidates(struct plan_candidate candidate[PLAN_MAX_OFFERED])
{
    static const double overlaps[] = { 0.4, 0.6, 0.8, 1 };
    static const enum stp_path paths[] = { STP_PATH_COMPUTE, STP_PATH_RASTER };
    unsigned n = 0;
    for (unsigned c = 0; c < sizeof overlaps / sizeof *overlaps; c++) {
        for (unsigned p = 0; p < 2; p++)
            candidate[n++] = (struct plan_candidate){ .method = STP_METHOD_DEFERRED,
                                                      .path = paths[p],
                                                      .voronoi = STP_VORONOI_SLAB,
                                                      .overlap = overlaps[c] };
        candidate[n++] = (struct plan_candidate){ .method = STP_METHOD_DEFERRED,
                                                  .path = STP_PATH_COMPUTE,
                                                  .payload = STP_PAYLOAD_ID,
                                                  .voronoi = STP_VORONOI_EXACT,
                                                  .overlap = overlaps[c] };
    }
    return n;
}

/* Every layer is cleared, by the rasteriser also looked through for what was touched, and
 * composited there; its separate draws cost a pass each. */
static enum plan_cost cost(const struct stp_plan *plan, const struct survey *survey,
                           double amount[PLAN_TERMS])
{
    double groups = plan->facts.grouping.groups;
    bool packed = plan->constant[PLAN_PACKED] != 0;
    plan_common_amounts(plan, survey, amount);
    amount[PLAN_TERM_DEEP] = groups * survey->pixels;
    amount[PLAN_TERM_OVERFLOW] = groups * survey->touched;
    if (plan->path == STP_PATH_RASTER) {
        amount[PLAN_TERM_FRAME] *= plan->constant[PLAN_LAYERED] ? 1 : groups;
        return packed ? PLAN_COST_DEFERRED_RASTER : PLAN_COST_DEFERRED_RASTER_ID;
    }
    if (plan->voronoi == STP_VORONOI_EXACT)
        return PLAN_COST_DEFERRED_EXACT;
    return packed ? PLAN_COST_DEFERRED_PACKED : PLAN_COST_DEFERRED_ID;
}

/* Of two fragments of one group, does the first win? As key_words and key_id order them. */
static bool wins(const struct stp_plan *plan, const struct probe_fragment *a,
                 const struct probe_fragment *b)
{
    if (plan->voronoi == STP_VORONOI_EXACT)
        return a->rho2 < b->rho2;
    if (plan->voronoi == STP_VORONOI_SLAB) {
        double low = plan->frame.depth_low, scale = plan->frame.slab_scale;
        double x = floor((a->depth - low) * scale), y = floor((b->depth - low) * scale);
        double u = a->rho2, v = b->rho2;
        if (!plan->constant[PLAN_PACKED]) {
            u = round(sqrt(u) * 16383);
            v = round(sqrt(v) * 16383);
        }
        if (x != y || u != v)
            return x != y ? x < y : u < v;
    }
    return a->depth < b->depth;
}

/* Of cells where groups that hardly overlap lose fragments: 0.04 to 0.2 in the mean over nine
 * models at c = 1, a cell in 20 to 1000. */
#define RARE 0.2

/* One fragment a group. Exact Voronoi looks only within epsilon of the group's nearest. */
static void keep(const struct stp_plan *plan, struct probe_fragment *fragment, size_t count)
{
    double last[STP_MAX_GROUPS];
    struct probe_fragment *best[STP_MAX_GROUPS] = { 0 };
    for (unsigned k = 0; k < STP_MAX_GROUPS; k++)
        last[k] = INFINITY;
    for (size_t i = 0; i < count; i++) {
        struct probe_fragment *f = &fragment[i];
        if (plan->constant[PLAN_PACKED])
            plan_quantise_packed(plan, f);
        if (plan->voronoi == STP_VORONOI_EXACT)
            last[f->group] = fmin(last[f->group], f->depth + plan->frame.epsilon);
    }
    for (size_t i = 0; i < count; i++) {
        struct probe_fragment *f = &fragment[i];
        struct probe_fragment **at = &best[f->group];
        f->kept = false;
        if (f->depth > last[f->group] || (*at && !wins(plan, f, *at)))
            continue;
        if (*at)
            (*at)->kept = false;
        f->kept = true;
        *at = f;
    }
}

const struct plan_offer plan_deferred_offer = { .method = STP_METHOD_DEFERRED,
                                                .candidates = candidates,
                                                .cost = cost,
                                                .keep = keep,
                                                .rare = RARE };
