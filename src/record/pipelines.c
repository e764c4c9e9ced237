/* The pipelines of a plan. Compiling them is most of a cold start, so passes that are alike share
 * one, and the context keeps those of the last plans for the next that is alike. */
#include "record/record.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

/* All that pipelines and their layouts depend on; words only, so that bytes can be compared. */
struct key {
    uint32_t constant[PLAN_CONSTANTS];
    uint32_t hosted, color_format, depth_format, reversed, read_only, replace;
    uint32_t binding[PLAN_SLOTS], type[PLAN_SLOTS];
    uint32_t pass[PLAN_MAX_PASSES][PASS_KEY_WORDS];
};

struct keyed {
    struct record_pipelines pipelines; /* first */
    struct key key;
    uint8_t maker[PLAN_MAX_PASSES]; /* the first pass that is alike; its pipeline is all theirs */
};

/* A buffer with an address, where it is fetched as texels too. */
static uint8_t find_texels(const struct stp_plan *plan, enum plan_slot slot)
{
    uint8_t found = plan_find(plan, slot);
    bool fetched = found != PLAN_NONE && pass_is_texels(plan->resource[found].format);
    return fetched ? found : PLAN_NONE;
}

/* Slots have an address, and may be fetched as texels besides. Where they have no ids or traits the
 * slots themselves stand at those bindings, and points where they have no clusters: shaders name
 * it, but fetch nothing. */
static uint8_t find_bound(const struct stp_plan *plan, uint32_t slot)
{
    switch (slot) {
    case PLAN_TEXEL_KEYS:
        return find_texels(plan, PLAN_KEYS);
    case PLAN_TEXEL_SLOT_IDS:
    case PLAN_TEXEL_TRAITS: {
        uint8_t own = find_texels(plan, slot == PLAN_TEXEL_TRAITS ? PLAN_TRAITS : PLAN_SLOT_IDS);
        return own != PLAN_NONE ? own : find_texels(plan, PLAN_KEYS);
    }
    case PLAN_TEXEL_PROJECTED:
        return find_texels(plan, PLAN_PROJECTED);
    case PLAN_TEXEL_ORDER:
        return find_texels(plan, PLAN_ORDER);
    case PLAN_TEXEL_CLUSTERS: {
        uint8_t clusters = plan_find(plan, PLAN_TEXEL_CLUSTERS);
        return clusters != PLAN_NONE ? clusters : plan_find(plan, PLAN_TEXEL_POINTS);
    }
    default:
        return plan_find(plan, slot);
    }
}

struct record_bindings record_bindings(const struct stp_plan *plan)
{
    struct record_bindings b = { 0 };
    for (uint32_t slot = PLAN_BUFFER_SLOTS; slot < PLAN_SLOTS; slot++) {
        uint8_t found = find_bound(plan, slot);
        if (found == PLAN_NONE || slot == PLAN_IMAGE_DEPTH)
            continue;
        b.resource[b.count] = found;
        b.type[b.count] = pass_is_texels(plan->resource[found].format)
                              ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER
                              : VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
        b.binding[b.count++] = PLAN_BINDING(slot);
    }
    return b;
}

static void fill_key(const struct stp_plan *plan, const struct pass_host *host,
                     const struct record_bindings *bindings, struct key *key)
{
    memcpy(key->constant, plan->constant, sizeof key->constant);
    if (host) {
        key->hosted = 1;
        key->color_format = host->color_format;
        key->depth_format = host->depth_format;
        key->reversed = host->depth_reversed;
        key->read_only = host->depth_read_only;
        key->replace = host->replace;
    }
    for (uint32_t i = 0; i < bindings->count; i++) {
        key->binding[i] = bindings->binding[i];
        key->type[i] = bindings->type[i];
    }
    for (uint32_t i = 0; i < plan->pass_count; i++)
        pass_key(plan, &plan->pass[i], key->pass[i]);
}

static VkResult make_layouts(struct stp_context *c, const struct record_bindings *b, bool hosted,
                             struct record_pipelines *p)
{
    VkDescriptorSetLayoutBinding bindings[1 + PLAN_SLOTS] = {
        { 0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, PASS_PUSH_STAGES, NULL }
    };
    for (uint32_t i = 0; i < b->count; i++)
        bindings[1 + i] =
            (VkDescriptorSetLayoutBinding){ b->binding[i], b->type[i], 1, PASS_PUSH_STAGES, NULL };
    VkDescriptorSetLayoutCreateInfo set = { .sType =
                                                VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                            .bindingCount = 1 + b->count,
                                            .pBindings = bindings };
    VkResult result = c->vk.vkCreateDescriptorSetLayout(c->device, &set, NULL, &p->set_layout);
    if (result != VK_SUCCESS)
        return result;
    uint32_t bytes = (uint32_t)(PASS_PUSH_HOST + (hosted ? sizeof(struct stp_push_host) : 0));
    VkPushConstantRange push = { PASS_PUSH_STAGES, 0, bytes };
    VkPipelineLayoutCreateInfo layout = { .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &p->set_layout,
                                          .pushConstantRangeCount = 1,
                                          .pPushConstantRanges = &push };
    return c->vk.vkCreatePipelineLayout(c->device, &layout, NULL, &p->layout);
}

struct making {
    struct stp_context *context;
    const struct stp_plan *plan;
    struct keyed *made;
    enum stp_result result[PLAN_MAX_PASSES];
};

static enum stp_result make_one(const struct stp_env *env, const struct making *m, size_t pass)
{
    struct record_pipelines *p = &m->made->pipelines;
    return pass_pipeline(env, m->context, m->plan, &m->plan->pass[pass], p->layout,
                         &p->pipeline[pass]);
}

/* Drivers compile well side by side. Workers stay silent: what fails is tried again by the
 * caller's thread, which may log. */
static void make_range(void *context, size_t begin, size_t end, unsigned)
{
    struct making *m = context;
    const struct stp_env silent = { .log = log_nothing };
    for (size_t i = begin; i < end; i++)
        if (m->made->maker[i] == i)
            m->result[i] = make_one(&silent, m, i);
}

static void find_makers(struct keyed *k, uint32_t pass_count)
{
    for (uint32_t i = 0; i < pass_count; i++) {
        uint32_t first = 0;
        while (memcmp(k->key.pass[first], k->key.pass[i], sizeof k->key.pass[i]) != 0)
            first++;
        k->maker[i] = (uint8_t)first;
    }
}

static enum stp_result compile(const struct stp_env *env, struct stp_context *context,
                               const struct stp_plan *plan, struct keyed *k)
{
    struct making making = { .context = context, .plan = plan, .made = k };
    struct record_pipelines *p = &k->pipelines;
    /* Validation layers speak on the thread that calls them, and only the caller's may log. */
    struct stp_env alone = { .threads = 1 };
    find_makers(k, plan->pass_count);
    parallel_for(context->instance.validate ? &alone : env, plan->pass_count, 1, make_range,
                 &making);
    enum stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < plan->pass_count; i++) {
        if (making.result[i] != STP_OK)
            result = make_one(env, &making, i);
        p->pipeline[i] = p->pipeline[k->maker[i]];
    }
    return result;
}

static void destroy(struct stp_context *c, struct gpu_kept *kept)
{
    struct keyed *k = (struct keyed *)kept;
    struct record_pipelines *p = &k->pipelines;
    for (uint32_t i = 0; i < PLAN_MAX_PASSES; i++)
        if (p->pipeline[i] && k->maker[i] == i)
            c->vk.vkDestroyPipeline(c->device, p->pipeline[i], NULL);
    if (p->host)
        c->vk.vkDestroyPipeline(c->device, p->host, NULL);
    if (p->layout)
        c->vk.vkDestroyPipelineLayout(c->device, p->layout, NULL);
    if (p->set_layout)
        c->vk.vkDestroyDescriptorSetLayout(c->device, p->set_layout, NULL);
    mem_free(k);
}

static enum stp_result make(const struct stp_env *env, struct stp_context *context,
                            const struct stp_plan *plan, const struct pass_host *host,
                            const struct record_bindings *bindings, struct keyed *k)
{
    struct record_pipelines *p = &k->pipelines;
    VkResult status = make_layouts(context, bindings, host != NULL, p);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "making pipeline layouts");
    enum stp_result result = compile(env, context, plan, k);
    return result == STP_OK && host
               ? pass_host_pipeline(env, context, plan, host, p->layout, &p->host)
               : result;
}

/* NULL: no kept ones are alike. */
static struct record_pipelines *find(struct stp_context *context, const struct key *key)
{
    for (struct gpu_kept *kept = context->kept; kept; kept = kept->next)
        if (memcmp(&((struct keyed *)kept)->key, key, sizeof *key) == 0)
            return (struct record_pipelines *)kept;
    return NULL;
}

enum stp_result record_pipelines_take(const struct stp_env *env, struct stp_context *context,
                                      const struct stp_plan *plan, const struct pass_host *host,
                                      struct record_pipelines **pipelines)
{
    struct record_bindings bindings = record_bindings(plan);
    struct keyed *k = mem_zalloc(1, sizeof *k);
    if (!k)
        return log_no_memory(env, sizeof *k, "pipelines");
    k->pipelines.kept.destroy = destroy;
    fill_key(plan, host, &bindings, &k->key);
    struct record_pipelines *found = find(context, &k->key);
    if (found) {
        mem_free(k);
        gpu_use_kept(context, &found->kept);
        *pipelines = found;
        return STP_OK;
    }
    enum stp_result result = make(env, context, plan, host, &bindings, k);
    if (result != STP_OK) {
        destroy(context, &k->pipelines.kept);
        return result;
    }
    gpu_keep(context, &k->pipelines.kept);
    *pipelines = &k->pipelines;
    return STP_OK;
}
