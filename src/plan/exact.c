/* Every fragment in one geometry pass, resolved exactly. A pixel with more fragments than slots is
 * summed again by the two-pass code, over the very memory of its slots and from only the splats
 * that touch its block; those passes are dispatched indirectly and do nothing when no pixel
 * overflowed. */
#include "plan/plan.h"

static void repair(struct stp_plan *plan)
{
    bool atomic64 = plan->constant[PLAN_ATOMIC64] != 0;
    const enum plan_slot touched[] = { PLAN_KEYS, PLAN_COUNTS, PLAN_SLOTS };
    struct plan_pass *arm = plan_pass(plan, PLAN_DISPATCH, "arm repair");
    arm->shader = PLAN_SHADER_EXACT_ARM;
    arm->groups = 1;
    plan_updates(plan, arm, PLAN_WORK);
    struct plan_pass *clear = plan_pass(plan, PLAN_DISPATCH_INDIRECT, "repair clear");
    clear->shader = PLAN_SHADER_EXACT_CLEAR;
    clear->offset = STP_WORK_REPAIR_BLOCKS * 4;
    plan_reads(plan, clear, PLAN_WORK);
    plan_reads(plan, clear, PLAN_COUNTS);
    plan_updates(plan, clear, PLAN_KEYS);
    struct plan_pass *collect = plan_pass(plan, PLAN_DISPATCH_INDIRECT, "repair collect");
    collect->shader = PLAN_SHADER_EXACT_COLLECT;
    collect->offset = STP_WORK_COLLECT * 4;
    plan_reads(plan, collect, PLAN_SPLATS);
    plan_updates(plan, collect, PLAN_WORK);
    plan_writes(plan, collect, PLAN_LARGE);
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

void plan_exact(struct stp_plan *plan)
{
    uint64_t pixels = plan_pixels(plan);
    plan_resource(plan, "slots", PLAN_KEYS, PLAN_TRANSIENT, pixels * STP_SLOTS * 8);
    plan_resource(plan, "counts", PLAN_COUNTS, PLAN_TRANSIENT, pixels * 4);
    if (plan->constant[PLAN_KEY_IDS])
        plan_resource(plan, "slot ids", PLAN_SLOT_IDS, PLAN_TRANSIENT, pixels * STP_SLOTS * 4);
    plan_fill(plan, PLAN_COUNTS, 0, "clear counts");
    const enum plan_slot touched[] = { PLAN_KEYS, PLAN_SLOT_IDS, PLAN_COUNTS, PLAN_SLOTS };
    plan_splat(plan, "slots", PLAN_SHADER_EXACT_SLOTS, PLAN_SHADER_EXACT_SLOTS_LARGE, false,
               touched);
    plan_blocks(plan);
    if (plan->transparency == STP_TRANSPARENCY_EXACT) {
        plan_resolve(plan, "layers", PLAN_SHADER_EXACT_LAYERS, false, touched);
        return;
    }
    plan_resolve(plan, "resolve", PLAN_SHADER_EXACT_RESOLVE, false, touched);
    repair(plan);
}
