/* The classical 2+1 pass (ZP 3.1, BSK 4): nearest depth, sums within epsilon of it, normalise. Of a
 * transparent scene it is depth peeling (ZP 2, 6.2), the baseline: the same passes are repeated
 * once a layer, what is left of the ray lies in the picture itself, and PLAN_NEAREST holds where
 * each pixel's peeled layers end; where some splats are opaque, a pass of them alone goes first and
 * leaves in PLAN_LIMITS where they end the rays. What a scene lacks is not accessed: without it
 * none of this is there. */
#include "plan/offer.h"

/* glsl/lib/sums.glsl */
uint32_t plan_sum_words(const struct stp_plan *plan)
{
    const uint32_t *c = plan->constant;
    if (c[PLAN_OPACITY] == 2)
        return STP_SUM_WORDS + 1;
    bool all =
        c[PLAN_HAS_COLOR] || c[PLAN_SHADE] == STP_SHADE_SPLAT || (c[PLAN_AOVS] & PLAN_AOVS_ID);
    return all ? STP_SUM_WORDS : STP_SUM_WORDS_PLAIN;
}

/* Of ellipses the pixels whose sums vanish go by themselves, if there are any. */
static void resolve(struct stp_plan *plan)
{
    static const enum plan_slot summed[] = { PLAN_SUMS, PLAN_SLOTS };
    bool apart = plan->constant[PLAN_PHONG] && plan->params.shade != STP_SHADE_FLAT;
    plan_resolve(plan, "resolve",
                 apart ? PLAN_SHADER_TWOPASS_RESOLVE_SURE : PLAN_SHADER_TWOPASS_RESOLVE, false,
                 summed);
    plan_updates(plan, &plan->pass[plan->pass_count - 1], PLAN_NEAREST);
    if (!apart)
        return;
    plan_resolve(plan, "resolve vanished", PLAN_SHADER_TWOPASS_RESOLVE_VANISHED, false, summed);
    plan->pass[plan->pass_count - 1].offset = STP_WORK_LOOK * 4;
}

static void compute(struct stp_plan *plan)
{
    bool atomic64 = plan->constant[PLAN_ATOMIC64] != 0;
    const enum plan_slot sums[] = { PLAN_SUMS, PLAN_NEAREST, PLAN_SLOTS };
    plan_resource(plan, "sums", PLAN_SUMS, PLAN_TRANSIENT,
                  plan_pixels(plan) * plan_sum_words(plan) * 8);
    struct plan_pass *clear = plan_pass(plan, PLAN_DISPATCH, "clear sums");
    clear->shader = PLAN_SHADER_TWOPASS_CLEAR;
    plan_writes(plan, clear, PLAN_SUMS);
    if (atomic64) {
        plan_splat(plan, "depth", PLAN_SHADER_TWOPASS_DEPTH, PLAN_SHADER_TWOPASS_DEPTH_LARGE, false,
                   sums);
        plan_binned(plan, "depth binned", PLAN_SHADER_TWOPASS_DEPTH_BINNED, sums);
    } else {
        plan_splat(plan, "depth", PLAN_SHADER_TWOPASS_DEPTH32, PLAN_SHADER_TWOPASS_DEPTH32_LARGE,
                   false, sums);
        plan_binned(plan, "depth binned", PLAN_SHADER_TWOPASS_DEPTH_BINNED, sums);
        plan_splat(plan, "nearest id", PLAN_SHADER_TWOPASS_ID32, PLAN_SHADER_TWOPASS_ID32_LARGE,
                   false, sums);
    }
    plan_exchange(plan, PLAN_EXCHANGE_NEAREST, "exchange nearest");
    if (plan->params.shade != STP_SHADE_FLAT) { /* else the nearest is all there is */
        plan_splat(plan, "sum", atomic64 ? PLAN_SHADER_TWOPASS_SUM : PLAN_SHADER_TWOPASS_SUM32,
                   atomic64 ? PLAN_SHADER_TWOPASS_SUM_LARGE : PLAN_SHADER_TWOPASS_SUM32_LARGE,
                   false, sums);
        plan_binned(plan, "sum binned", PLAN_SHADER_TWOPASS_SUM_BINNED, sums);
    }
    plan_exchange(plan, PLAN_EXCHANGE_SUMS, "exchange sums");
    if (!plan_is_root(plan))
        return;
    plan_blocks(plan);
    resolve(plan);
}

static struct plan_pass *draw(struct stp_plan *plan, const char *name, enum plan_shader fragment,
                              enum plan_raster raster)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DRAW, name);
    pass->vertex = plan_raster_shader(plan, PLAN_SHADER_RASTER_VERTEX);
    pass->shader = plan_raster_shader(plan, fragment);
    pass->raster = raster;
    pass->layer_count = 1;
    pass->splat_count = (uint32_t)plan->facts.splats;
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OPACITIES);
    plan_reads(plan, pass, PLAN_MATERIALS);
    plan_reads(plan, pass, PLAN_NEAREST);
    return pass;
}

static struct plan_pass *draw_visibility(struct stp_plan *plan, const char *name)
{
    struct plan_pass *pass =
        draw(plan, name, PLAN_SHADER_TWOPASS_DEPTH_FRAGMENT, PLAN_RASTER_WINNER);
    plan_attaches(plan, pass, PLAN_IMAGE_ID);
    plan_attaches(plan, pass, PLAN_IMAGE_DEPTH);
    return pass;
}

static void visibility_images(struct stp_plan *plan)
{
    if (plan_find(plan, PLAN_IMAGE_ID) != PLAN_NONE) /* what is opaque was drawn to them */
        return;
    plan_image(plan, "nearest", PLAN_IMAGE_ID, PLAN_RG32UI, 1);
    plan_image(plan, "depth test", PLAN_IMAGE_DEPTH, PLAN_D32F, 1);
}

static void raster(struct stp_plan *plan)
{
    visibility_images(plan);
    plan_image(plan, "sum", PLAN_IMAGE_SUM, PLAN_RGBA32F, 1);
    plan_image(plan, "depth sum", PLAN_IMAGE_SUM_DEPTH, PLAN_RG32F, 1);
    bool colors = plan->constant[PLAN_HAS_COLOR] || plan->constant[PLAN_OPACITY] == 2 ||
                  plan->params.shade == STP_SHADE_SPLAT;
    if (colors)
        plan_image(plan, "color sum", PLAN_IMAGE_SUM_COLOR, PLAN_RGBA32F, 1);
    struct plan_pass *pass = draw_visibility(plan, "visibility");
    plan_reads(plan, pass, PLAN_LIMITS);
    pass = draw(plan, "blend", PLAN_SHADER_TWOPASS_SUM_FRAGMENT, PLAN_RASTER_BLEND);
    plan_reads(plan, pass, PLAN_LIMITS);
    plan_reads(plan, pass, PLAN_IMAGE_ID);
    plan_attaches(plan, pass, PLAN_IMAGE_SUM);
    plan_attaches(plan, pass, PLAN_IMAGE_SUM_DEPTH);
    plan_attaches(plan, pass, PLAN_IMAGE_SUM_COLOR);
    plan_touched(plan, "touched", PLAN_SHADER_TOUCHED);
    plan_blocks(plan);
    plan_resolve(
        plan, "normalise",
        colors ? PLAN_SHADER_TWOPASS_RESOLVE_IMAGE_COLOR : PLAN_SHADER_TWOPASS_RESOLVE_IMAGE, false,
        (enum plan_slot[]){ PLAN_IMAGE_ID, PLAN_IMAGE_SUM, PLAN_IMAGE_SUM_DEPTH,
                            PLAN_IMAGE_SUM_COLOR, PLAN_SLOTS });
    plan_updates(plan, &plan->pass[plan->pass_count - 1], PLAN_NEAREST);
}

/* Where the nearest opaque fragment ends each pixel's ray, by either path. */
static void find_opaque(struct stp_plan *plan)
{
    static const enum plan_slot found[] = { PLAN_LIMITS, PLAN_SLOTS };
    plan_resource(plan, "opaque", PLAN_LIMITS, PLAN_TRANSIENT, plan_pixels(plan) * 4);
    if (plan->path == STP_PATH_COMPUTE) {
        plan_fill(plan, PLAN_LIMITS, 0x7f800000u, "nothing opaque");
        plan_writes(plan, plan_pass(plan, PLAN_ARGUMENTS, "reset arguments"), PLAN_WORK);
        plan_splat(plan, "opaque", PLAN_SHADER_PEEL_OPAQUE, PLAN_SHADER_PEEL_OPAQUE_LARGE, false,
                   found);
        return;
    }
    visibility_images(plan);
    struct plan_pass *pass = draw_visibility(plan, "opaque");
    pass->vertex = PLAN_SHADER_PEEL_OPAQUE_VERTEX;
    pass = plan_pass(plan, PLAN_DISPATCH, "opaque ends");
    pass->shader = PLAN_SHADER_PEEL_LIMITS;
    plan_reads(plan, pass, PLAN_IMAGE_ID);
    plan_writes(plan, pass, PLAN_LIMITS);
}

void plan_peel_begin(struct stp_plan *plan)
{
    plan_resource(plan, "peeled", PLAN_NEAREST, PLAN_TRANSIENT, plan_pixels(plan) * 4);
    plan_fill(plan, PLAN_NEAREST, 0xff800000u, "nothing peeled");
    if (plan->constant[PLAN_MIXED])
        find_opaque(plan);
}

void plan_twopass(struct stp_plan *plan)
{
    if (plan->path == STP_PATH_COMPUTE)
        compute(plan);
    else
        raster(plan);
}

static unsigned candidates(struct plan_candidate candidate[PLAN_MAX_OFFERED])
{
    candidate[0] = (struct plan_candidate){ .method = STP_METHOD_TWO_PASS,
                                            .path = STP_PATH_COMPUTE,
                                            .voronoi = STP_VORONOI_OFF };
    candidate[1] = candidate[0];
    candidate[1].path = STP_PATH_RASTER;
    return 2;
}

static enum plan_cost cost(const struct stp_plan *plan, const struct survey *survey,
                           double amount[PLAN_TERMS])
{
    plan_common_amounts(plan, survey, amount);
    bool colored = plan->constant[PLAN_HAS_COLOR] != 0;
    if (plan->path == STP_PATH_RASTER)
        return colored ? PLAN_COST_TWO_PASS_RASTER_COLOR : PLAN_COST_TWO_PASS_RASTER;
    return colored ? PLAN_COST_TWO_PASS_COLOR : PLAN_COST_TWO_PASS;
}

/* Sums of 40 bits and more: nothing is lost that a picture shows. */
static void keep(const struct stp_plan *, struct probe_fragment *, size_t)
{
}

const struct plan_offer plan_twopass_offer = {
    .method = STP_METHOD_TWO_PASS, .candidates = candidates, .cost = cost, .keep = keep
};
