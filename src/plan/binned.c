/* Large splats of the two-pass method, block by block: a pass bins those that a first pass over the
 * splats has found (bin.comp), and after it every pass over the splats has a variant that goes
 * through the blocks' lists. What is left over takes a workgroup each. None of it where the device
 * fetches no texels: records are fetched so; nor where a layer is peeled at a time, each with other
 * splats; nor where the view shows no splat so large. A camera that the plan is moved to may: then
 * a workgroup each draws them. */
#include "plan/plan.h"

#include <math.h>

static uint64_t least(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static unsigned record_vectors(const struct stp_plan *plan)
{
    static const unsigned vectors[] = { STP_BIN_DISC, STP_BIN_ELLIPSE, STP_BIN_CLIPPED };
    return vectors[plan->constant[PLAN_PHONG]];
}

/* Whether some splat's bounds may hold more than STP_BIN_AREA pixels: if the largest were
 * nearest, in a corner of the picture. */
static bool may_be_large(const struct stp_plan *plan)
{
    const struct stp_camera *c = &plan->camera;
    double x = fmax(c->cx, c->width - c->cx) / c->fx, y = fmax(c->cy, c->height - c->cy) / c->fy;
    double stretch = c->orthographic ? 1 : (1 + x * x + y * y) / (double)plan->frame.raster_near;
    double half = fmax(c->fx, c->fy) * plan->facts.radius_max * stretch;
    half = fmax(half, (double)plan->frame.floor_size / 2);
    return !(pow(2 * half + 1, 2) <= STP_BIN_AREA);
}

bool plan_bins(const struct stp_plan *plan)
{
    return plan->method == STP_METHOD_TWO_PASS && plan->path == STP_PATH_COMPUTE &&
           plan->transparency != STP_TRANSPARENCY_PEEL && may_be_large(plan) &&
           (plan->limits.features & STP_FEATURE_TEXEL_BUFFERS) != 0;
}

void plan_bin_resources(struct stp_plan *plan)
{
    uint64_t n = plan_splats(plan), blocks = plan_pixels(plan) / STP_GROUP;
    if (!plan->constant[PLAN_BINS])
        return;
    plan_resource(plan, "bins", PLAN_BINNED_LISTS, PLAN_TRANSIENT,
                  (n + 2 * blocks * least(n, STP_BIN_ENTRIES)) * 4);
    uint8_t records = plan_resource(plan, "records", PLAN_PROJECTED, PLAN_TRANSIENT,
                                    least(n, STP_BIN_SPLATS) * record_vectors(plan) * 16);
    plan->resource[records].format = PLAN_TEXELS_RGBA32UI;
}

/* Whether the large splats that were found since the arguments were reset are binned. */
static bool is_done(const struct stp_plan *plan)
{
    for (uint32_t i = plan->pass_count; i-- > 0 && plan->pass[i].kind != PLAN_ARGUMENTS;)
        if (plan->pass[i].shader == PLAN_SHADER_BIN)
            return true;
    return false;
}

void plan_bin(struct stp_plan *plan)
{
    if (!plan->constant[PLAN_BINS] || is_done(plan))
        return;
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, "bin");
    pass->shader = PLAN_SHADER_BIN;
    pass->offset = STP_WORK_LARGE * 4;
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_LARGE);
    plan_updates(plan, pass, PLAN_WORK);
    plan_writes(plan, pass, PLAN_BINNED_LISTS);
    plan_writes(plan, pass, PLAN_PROJECTED);
}

void plan_binned(struct stp_plan *plan, const char *name, enum plan_shader shader,
                 const enum plan_slot *updated)
{
    if (!plan->constant[PLAN_BINS])
        return;
    struct plan_pass *pass = plan_splat_pass(plan, PLAN_DISPATCH_INDIRECT, name, updated);
    pass->shader = shader;
    pass->offset = STP_WORK_BINNED * 4;
    plan_reads(plan, pass, PLAN_BINNED_LISTS);
    plan_reads(plan, pass, PLAN_PROJECTED);
}
