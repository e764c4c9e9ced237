/* Every fragment in one geometry pass, resolved exactly. Of a pixel with more fragments than slots
 * only the splats that touch its block are drawn again. Opaque, it is summed by the two-pass code,
 * over the very memory of its slots. Where there are layers its fragments go to a list behind all
 * slots, as far as there is room; else they are summed once a layer. Those passes are dispatched
 * indirectly and do nothing when no pixel overflowed. */
#include "plan/offer.h"

#include <math.h>

static struct plan_pass *repair_blocks(struct stp_plan *plan, const char *name,
                                       enum plan_shader shader)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, name);
    pass->shader = shader;
    pass->offset = STP_WORK_REPAIR_BLOCKS * 4;
    return pass;
}

static void one_group(struct stp_plan *plan, const char *name, enum plan_shader shader)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, name);
    pass->shader = shader;
    pass->groups = 1;
    plan_updates(plan, pass, PLAN_WORK);
}

/* The splats that a repair draws: those that touch a block with an overflowed pixel. */
static void collect(struct stp_plan *plan)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, "repair collect");
    pass->shader = PLAN_SHADER_EXACT_COLLECT;
    pass->offset = STP_WORK_COLLECT * 4;
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_updates(plan, pass, PLAN_WORK);
    plan_writes(plan, pass, PLAN_LARGE);
}

static void arm(struct stp_plan *plan, bool layers)
{
    one_group(plan, "arm repair", PLAN_SHADER_EXACT_ARM);
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, "repair blocks");
    pass->shader = PLAN_SHADER_EXACT_BLOCKS;
    pass->offset = STP_WORK_SEEK * 4;
    plan_updates(plan, pass, PLAN_WORK);
    if (layers) {
        plan_reads(plan, pass, PLAN_COUNTS);
        one_group(plan, "place lists", PLAN_SHADER_EXACT_PLACE);
    }
    pass = repair_blocks(plan, "repair clear",
                         layers ? PLAN_SHADER_MEND_CLEAR : PLAN_SHADER_EXACT_CLEAR);
    if (layers)
        plan_updates(plan, pass, PLAN_WORK);
    else
        plan_reads(plan, pass, PLAN_WORK);
    plan_reads(plan, pass, PLAN_COUNTS);
    plan_updates(plan, pass, PLAN_KEYS);
}

static void repair(struct stp_plan *plan)
{
    bool atomic64 = plan->constant[PLAN_ATOMIC64] != 0;
    const enum plan_slot touched[] = { PLAN_KEYS, PLAN_COUNTS, PLAN_SLOTS };
    arm(plan, false);
    collect(plan);
    if (atomic64) {
        plan_splat(plan, "repair depth", PLAN_SHADER_TWOPASS_DEPTH_LISTED,
                   PLAN_SHADER_TWOPASS_DEPTH_LARGE, true, touched);
    } else {
        plan_splat(plan, "repair depth", PLAN_SHADER_TWOPASS_DEPTH32_LISTED,
                   PLAN_SHADER_TWOPASS_DEPTH32_LARGE, true, touched);
        plan_splat(plan, "repair id", PLAN_SHADER_TWOPASS_ID32_LISTED,
                   PLAN_SHADER_TWOPASS_ID32_LARGE, true, touched);
    }
    plan_splat(plan, "repair sum",
               atomic64 ? PLAN_SHADER_TWOPASS_SUM_LISTED : PLAN_SHADER_TWOPASS_SUM32_LISTED,
               atomic64 ? PLAN_SHADER_TWOPASS_SUM_LARGE : PLAN_SHADER_TWOPASS_SUM32_LARGE, true,
               touched);
    plan_resolve(plan, "repair resolve", PLAN_SHADER_TWOPASS_RESOLVE, true, touched);
    plan->pass[plan->pass_count - 1].offset = STP_WORK_REPAIR_BLOCKS * 4;
}

static void mend_pixels(struct stp_plan *plan, const char *name, enum plan_shader shader)
{
    struct plan_pass *pass = repair_blocks(plan, name, shader);
    plan_updates(plan, pass, PLAN_WORK);
    plan_reads(plan, pass, PLAN_COUNTS);
    plan_updates(plan, pass, PLAN_KEYS);
}

/* Layers of the pixels whose fragments overflowed their slots, from lists. */
static void lists(struct stp_plan *plan, bool fetched)
{
    const enum plan_slot touched[] = { PLAN_KEYS, PLAN_SLOT_IDS, PLAN_COUNTS, PLAN_SLOTS };
    plan_splat(plan, "list slots", PLAN_SHADER_EXACT_LISTS, PLAN_SHADER_EXACT_LISTS_LARGE, true,
               touched);
    plan_resolve(plan, "list layers", PLAN_SHADER_EXACT_LIST_LAYERS + fetched, true, touched);
    plan->pass[plan->pass_count - 1].offset = STP_WORK_REPAIR_BLOCKS * 4;
    plan_deep_write(plan);
}

/* Layers of those that found no room for lists: a turn of the loop a layer. */
static void mend(struct stp_plan *plan)
{
    const enum plan_slot touched[] = { PLAN_KEYS, PLAN_COUNTS, PLAN_SLOTS };
    one_group(plan, "arm mending", PLAN_SHADER_MEND_TURN);
    plan_splat(plan, "mend find", PLAN_SHADER_MEND_FIND, PLAN_SHADER_MEND_FIND_LARGE, true,
               touched);
    mend_pixels(plan, "mend first", PLAN_SHADER_MEND_FIRST);
    plan->loop_first = plan->pass_count;
    one_group(plan, "mend turn", PLAN_SHADER_MEND_TURN);
    plan_splat(plan, "mend sum", PLAN_SHADER_MEND_SUM, PLAN_SHADER_MEND_SUM_LARGE, true, touched);
    plan_resolve(plan, "mend layer", PLAN_SHADER_MEND_LAYER, true, touched);
    plan->pass[plan->pass_count - 1].offset = STP_WORK_REPAIR_BLOCKS * 4;
    plan_deep_write(plan);
}

void plan_exact(struct stp_plan *plan)
{
    bool layers = plan->transparency == STP_TRANSPARENCY_EXACT;
    uint64_t pixels = plan_pixels(plan),
             most = pixels * (STP_SLOTS + (layers ? STP_LIST_SLOTS : 0));
    bool fetched = (plan->limits.features & STP_FEATURE_TEXEL_BUFFERS) != 0;
    uint8_t slots = plan_resource(plan, "slots", PLAN_KEYS, PLAN_TRANSIENT, most * 8);
    plan->resource[slots].format = fetched ? PLAN_TEXELS_RG32UI : PLAN_BUFFER;
    plan_resource(plan, "counts", PLAN_COUNTS, PLAN_TRANSIENT, pixels * 4);
    if (plan->constant[PLAN_KEY_IDS]) {
        slots = plan_resource(plan, "slot ids", PLAN_SLOT_IDS, PLAN_TRANSIENT, most * 4);
        plan->resource[slots].format = fetched ? PLAN_TEXELS_R32UI : PLAN_BUFFER;
    }
    plan_fill(plan, PLAN_COUNTS, 0, "clear counts");
    plan_deep_begin(plan);
    const enum plan_slot touched[] = { PLAN_KEYS, PLAN_SLOT_IDS, PLAN_COUNTS, PLAN_SLOTS };
    plan_splat(plan, "slots", PLAN_SHADER_EXACT_SLOTS, PLAN_SHADER_EXACT_SLOTS_LARGE, false,
               touched);
    plan_blocks(plan);
    if (layers) {
        plan_resolve(plan, "layers", PLAN_SHADER_EXACT_LAYERS + fetched, false, touched);
        plan_deep_write(plan);
        arm(plan, true);
        collect(plan);
        lists(plan, fetched);
        mend(plan);
        return;
    }
    plan_resolve(plan, "resolve", PLAN_SHADER_EXACT_RESOLVE + fetched, false, touched);
    repair(plan);
}

static unsigned candidates(struct plan_candidate candidate[PLAN_MAX_OFFERED])
{
    candidate[0] = (struct plan_candidate){ .method = STP_METHOD_EXACT,
                                            .path = STP_PATH_COMPUTE,
                                            .payload = STP_PAYLOAD_PACKED,
                                            .voronoi = STP_VORONOI_OFF };
    candidate[1] = candidate[0];
    candidate[1].payload = STP_PAYLOAD_ID;
    return 2;
}

/* A pixel's first fragments are resolved from registers, those beyond from memory; where the slots
 * overflow, the two-pass code sums everything there again. */
static enum plan_cost cost(const struct stp_plan *plan, const struct survey *survey,
                           double amount[PLAN_TERMS])
{
    plan_common_amounts(plan, survey, amount);
    amount[PLAN_TERM_DEEP] = survey->deep;
    amount[PLAN_TERM_OVERFLOW] = survey->overflow;
    if (!plan->constant[PLAN_PACKED])
        return plan->constant[PLAN_HAS_COLOR] ? PLAN_COST_EXACT_ID_COLOR : PLAN_COST_EXACT_ID;
    return plan->constant[PLAN_KEY_IDS] ? PLAN_COST_EXACT_PACKED_IDS : PLAN_COST_EXACT_PACKED;
}

/* Every fragment; what is summed are integers. */
static void keep(const struct stp_plan *plan, struct probe_fragment *fragment, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (plan->constant[PLAN_PACKED])
            plan_quantise_packed(plan, &fragment[i]);
        fragment[i].weight = round(fragment[i].weight * STP_WEIGHT_UNIT) / STP_WEIGHT_UNIT;
    }
}

const struct plan_offer plan_exact_offer = {
    .method = STP_METHOD_EXACT, .candidates = candidates, .cost = cost, .keep = keep
};
