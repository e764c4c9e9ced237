#include "plan/plan.h"

#include <assert.h>
#include <stdio.h>

uint8_t plan_resource(struct stp_plan *plan, const char *name, enum plan_slot slot,
                      enum plan_lifetime lifetime, uint64_t bytes)
{
    assert(plan->resource_count < PLAN_MAX_RESOURCES);
    struct plan_resource *r = &plan->resource[plan->resource_count];
    *r = (struct plan_resource){ .slot = slot, .lifetime = lifetime, .bytes = bytes };
    snprintf(r->name, sizeof r->name, "%s", name);
    return (uint8_t)plan->resource_count++;
}

static unsigned texel_bytes(enum plan_format format)
{
    switch (format) {
    case PLAN_D32F:
        return 4;
    case PLAN_RG32UI:
    case PLAN_RG32F:
        return 8;
    case PLAN_RGBA32F:
    case PLAN_RGBA32UI:
        return 16;
    case PLAN_TEXELS_RGBA32UI:
    case PLAN_TEXELS_R32F:
    case PLAN_TEXELS_RG32UI:
    case PLAN_TEXELS_R32UI:
    case PLAN_BUFFER:
        break;
    }
    return 0;
}

uint8_t plan_image(struct stp_plan *plan, const char *name, enum plan_slot slot,
                   enum plan_format format, uint32_t layers)
{
    uint64_t bytes = (uint64_t)plan->tile_width * plan->tile_height * layers * texel_bytes(format);
    uint8_t at = plan_resource(plan, name, slot, PLAN_TRANSIENT, bytes);
    struct plan_resource *r = &plan->resource[at];
    r->format = format;
    r->width = plan->tile_width;
    r->height = plan->tile_height;
    r->layers = layers;
    return at;
}

struct plan_pass *plan_pass(struct stp_plan *plan, enum plan_kind kind, const char *name)
{
    assert(plan->pass_count < PLAN_MAX_PASSES);
    struct plan_pass *pass = &plan->pass[plan->pass_count++];
    *pass = (struct plan_pass){ .kind = kind, .target = PLAN_NONE };
    snprintf(pass->name, sizeof pass->name, "%s", name);
    return pass;
}

uint8_t plan_find(const struct stp_plan *plan, enum plan_slot slot)
{
    for (uint32_t i = 0; i < plan->resource_count; i++)
        if (plan->resource[i].slot == slot)
            return (uint8_t)i;
    return PLAN_NONE;
}

/* A slot that this plan does not have is not accessed: shaders skip it by a constant. Of several
 * accesses to one, one is kept that is of all their kinds. */
static void access(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot,
                   unsigned kind)
{
    uint8_t resource = plan_find(plan, slot);
    if (resource == PLAN_NONE)
        return;
    for (unsigned i = 0; i < pass->access_count; i++)
        if (pass->access[i].resource == resource) {
            pass->access[i].kind |= (uint8_t)kind;
            return;
        }
    assert(pass->access_count < PLAN_MAX_ACCESSES);
    pass->access[pass->access_count++] = (struct plan_access){ resource, (uint8_t)kind };
}

void plan_reads(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot)
{
    access(plan, pass, slot, PLAN_READ);
    if (slot == PLAN_MATERIALS) /* what shades */
        access(plan, pass, PLAN_LIGHTS, PLAN_READ);
    if (slot != PLAN_SPLATS)
        return;
    access(plan, pass, PLAN_ELLIPSES, PLAN_READ);
    access(plan, pass, PLAN_CLIPS, PLAN_READ);
}

void plan_writes(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot)
{
    access(plan, pass, slot, PLAN_WRITE);
}

void plan_updates(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot)
{
    access(plan, pass, slot, PLAN_READ | PLAN_WRITE);
}

void plan_attaches(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot)
{
    access(plan, pass, slot, PLAN_READ | PLAN_WRITE | PLAN_ATTACHMENT);
}

static uint32_t blocks(uint32_t pixels)
{
    return (pixels + STP_BLOCK - 1) / STP_BLOCK;
}

uint32_t plan_samples(const struct stp_plan *plan)
{
    return plan->constant[PLAN_SAMPLE_GRID] * plan->constant[PLAN_SAMPLE_GRID];
}

uint32_t plan_repeats(const struct stp_plan *plan)
{
    uint32_t layers = plan->params.peel_layers;
    if (plan->transparency != STP_TRANSPARENCY_PEEL)
        return plan_samples(plan);
    return layers ? layers : STP_DEFAULT_PEEL_LAYERS;
}

uint32_t plan_id_words(const struct stp_plan *plan)
{
    return (plan_samples(plan) > 1 ? STP_ID_WORDS : 2) +
           ((plan->constant[PLAN_AOVS] & PLAN_AOVS_LAYERS) != 0);
}

uint64_t plan_pixels(const struct stp_plan *plan)
{
    return (uint64_t)blocks(plan->tile_width) * blocks(plan->tile_height) * STP_BLOCK * STP_BLOCK;
}

uint64_t plan_splats(const struct stp_plan *plan)
{
    return plan->share.count ? plan->share.splats : plan->facts.splats;
}

bool plan_is_root(const struct stp_plan *plan)
{
    return plan->share.rank == 0;
}

uint64_t plan_ghosts(const struct stp_plan *plan)
{
    if (!plan->share.count)
        return 0;
    return plan_is_root(plan) ? plan_pixels(plan) : plan->facts.objects;
}

void plan_exchange(struct stp_plan *plan, enum plan_exchange exchange, const char *name)
{
    if (!plan->share.count)
        return;
    struct plan_pass *pass = plan_pass(plan, PLAN_EXCHANGE, name);
    pass->exchange = exchange;
    plan_updates(plan, pass, PLAN_SUMS);
    if (exchange == PLAN_EXCHANGE_NEAREST) {
        plan_writes(plan, pass, PLAN_SPLATS);
        plan_writes(plan, pass, PLAN_COLORS);
    } else {
        plan_writes(plan, pass, PLAN_WORK);
    }
}

void plan_fill(struct stp_plan *plan, enum plan_slot slot, uint32_t value, const char *name)
{
    uint8_t resource = plan_find(plan, slot);
    if (resource == PLAN_NONE)
        return;
    struct plan_pass *pass = plan_pass(plan, PLAN_FILL, name);
    pass->target = resource;
    pass->value = value;
    plan_writes(plan, pass, slot);
}

static void splat_reads(const struct stp_plan *plan, struct plan_pass *pass)
{
    plan_reads(plan, pass, PLAN_SPLATS);
    plan_reads(plan, pass, PLAN_COLORS);
    plan_reads(plan, pass, PLAN_OPACITIES);
    plan_reads(plan, pass, PLAN_MATERIALS);
}

static void updates_all(const struct stp_plan *plan, struct plan_pass *pass,
                        const enum plan_slot *updated)
{
    for (; *updated != PLAN_SLOTS; updated++)
        plan_updates(plan, pass, *updated);
}

struct plan_pass *plan_splat_pass(struct stp_plan *plan, enum plan_kind kind, const char *name,
                                  const enum plan_slot *updated)
{
    struct plan_pass *pass = plan_pass(plan, kind, name);
    splat_reads(plan, pass);
    plan_reads(plan, pass, PLAN_LIMITS);
    plan_updates(plan, pass, PLAN_WORK);
    updates_all(plan, pass, updated);
    return pass;
}

void plan_splat(struct stp_plan *plan, const char *name, enum plan_shader small_shader,
                enum plan_shader large_shader, bool repair, const enum plan_slot *updated)
{
    char large_name[40];
    snprintf(large_name, sizeof large_name, "%s large", name);
    struct plan_pass *pass =
        plan_splat_pass(plan, repair ? PLAN_DISPATCH_INDIRECT : PLAN_DISPATCH, name, updated);
    pass->shader = small_shader;
    pass->repair = repair;
    pass->offset = STP_WORK_REPAIR * 4;
    pass->groups = (uint32_t)((plan_splats(plan) + STP_GROUP - 1) / STP_GROUP);
    plan_updates(plan, pass, PLAN_LARGE);
    if (!repair)
        plan_bin(plan);
    pass = plan_splat_pass(plan, PLAN_DISPATCH_INDIRECT, large_name, updated);
    pass->shader = large_shader;
    pass->repair = repair;
    uint32_t left = plan->constant[PLAN_BINS] ? STP_WORK_REST : STP_WORK_LARGE;
    pass->offset = (repair ? STP_WORK_REPAIR_L : left) * 4;
    plan_reads(plan, pass, PLAN_LARGE);
    plan_reads(plan, pass, PLAN_BINNED_LISTS);
}

void plan_blocks(struct stp_plan *plan)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, "blocks");
    pass->shader = PLAN_SHADER_BLOCKS;
    pass->groups = (uint32_t)((plan_pixels(plan) / STP_GROUP + STP_GROUP - 1) / STP_GROUP);
    plan_updates(plan, pass, PLAN_WORK);
}

void plan_touched(struct stp_plan *plan, const char *name, enum plan_shader shader)
{
    plan_writes(plan, plan_pass(plan, PLAN_ARGUMENTS, "reset arguments"), PLAN_WORK);
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH, name);
    pass->shader = shader;
    plan_reads(plan, pass, PLAN_IMAGE_ID);
    plan_updates(plan, pass, PLAN_WORK);
}

void plan_outputs(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot)
{
    if (plan_samples(plan) > 1 || plan->transparency == STP_TRANSPARENCY_PEEL)
        plan_updates(plan, pass, slot);
    else
        plan_writes(plan, pass, slot);
}

void plan_resolve(struct stp_plan *plan, const char *name, enum plan_shader shader, bool repair,
                  const enum plan_slot *read)
{
    struct plan_pass *pass = plan_pass(plan, PLAN_DISPATCH_INDIRECT, name);
    pass->shader = shader;
    pass->repair = repair;
    pass->offset = STP_WORK_BLOCKS * 4;
    splat_reads(plan, pass);
    plan_reads(plan, pass, PLAN_OBJECT_OPTICS);
    plan_reads(plan, pass, PLAN_ENVIRONMENT);
    plan_updates(plan, pass, PLAN_WORK);
    for (; *read != PLAN_SLOTS; read++)
        plan_reads(plan, pass, *read);
    for (enum plan_slot slot = PLAN_OUT_COLOR; slot <= PLAN_OUT_ID; slot++)
        plan_outputs(plan, pass, slot);
}
