/* Pipelines: one a pass, but passes that are compiled alike share theirs; frames of plans that are
 * compiled alike may share them all. */
#include "record/record.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

struct record_bindings record_find_bindings(const struct stp_plan *plan)
{
    struct record_bindings b = { 0 };
    for (uint32_t slot = PLAN_BUFFER_SLOTS; slot < PLAN_SLOTS; slot++) {
        uint8_t found = plan_find(plan, slot);
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

static VkResult make_layouts(struct stp_context *c, struct record_pipelines *p,
                             const struct record_bindings *b, bool hosted)
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
    uint32_t bytes = PASS_PUSH_HOST + (hosted ? (uint32_t)sizeof(struct pass_host_push) : 0);
    VkPushConstantRange push = { PASS_PUSH_STAGES, 0, bytes };
    VkPipelineLayoutCreateInfo layout = { .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &p->set_layout,
                                          .pushConstantRangeCount = 1,
                                          .pPushConstantRanges = &push };
    return c->vk.vkCreatePipelineLayout(c->device, &layout, NULL, &p->layout);
}

/* Formats of what a draw renders to, in order. */
static bool same_targets(const struct stp_plan *a, const struct plan_pass *p,
                         const struct stp_plan *b, const struct plan_pass *q)
{
    if (p->access_count != q->access_count)
        return false;
    bool same = true;
    for (unsigned i = 0; same && i < p->access_count; i++) {
        bool target = p->access[i].kind & PLAN_ATTACHMENT;
        same = target == ((q->access[i].kind & PLAN_ATTACHMENT) != 0) &&
               (!target || a->resource[p->access[i].resource].format ==
                               b->resource[q->access[i].resource].format);
    }
    return same;
}

/* Whether one pipeline does for both, where the plans' constants are the same. */
static bool same_pass(const struct stp_plan *a, const struct plan_pass *p, const struct stp_plan *b,
                      const struct plan_pass *q)
{
    bool walks = a->method == STP_METHOD_AXIS; /* which specialise by walk and part */
    return p->kind == q->kind && p->shader == q->shader && p->vertex == q->vertex &&
           p->raster == q->raster && p->repair == q->repair &&
           (!walks || (p->layer == q->layer && p->part == q->part)) &&
           (p->kind != PLAN_DRAW || same_targets(a, p, b, q));
}

bool record_pipelines_serve(const struct stp_plan *made_for, const struct stp_plan *plan)
{
    struct record_bindings a = record_find_bindings(made_for), b = record_find_bindings(plan);
    bool same = made_for->method == plan->method && made_for->pass_count == plan->pass_count &&
                memcmp(made_for->constant, plan->constant, sizeof plan->constant) == 0 &&
                a.count == b.count &&
                memcmp(a.binding, b.binding, a.count * sizeof *a.binding) == 0 &&
                memcmp(a.type, b.type, a.count * sizeof *a.type) == 0;
    for (uint32_t i = 0; same && i < plan->pass_count; i++)
        same = same_pass(made_for, &made_for->pass[i], plan, &plan->pass[i]);
    return same;
}

/* The first pass that is compiled as this one is. */
static uint32_t first_alike(const struct stp_plan *plan, uint32_t pass)
{
    uint32_t i = 0;
    while (i < pass && !same_pass(plan, &plan->pass[i], plan, &plan->pass[pass]))
        i++;
    return i;
}

struct making {
    struct record_frame *frame;
    enum stp_result result[PLAN_MAX_PASSES];
};

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

/* Compiling is most of a cold start, and drivers do it well side by side. Workers stay silent:
 * what fails is tried again by the caller's thread, which may log. */
static void make_range(void *context, size_t begin, size_t end, unsigned worker)
{
    struct making *m = context;
    const struct stp_env silent = { .log = swallow };
    for (size_t i = begin; i < end; i++)
        if (first_alike(m->frame->plan, (uint32_t)i) == i)
            m->result[i] =
                pass_pipeline(&silent, m->frame->context, m->frame->plan, &m->frame->plan->pass[i],
                              &m->frame->resources, &m->frame->pipelines->pipeline[i]);
}

static enum stp_result compile(const struct stp_env *env, struct record_frame *frame)
{
    struct making making = { .frame = frame };
    /* Validation layers speak on the thread that calls them, and only the caller's may log. */
    struct stp_env alone = { .threads = 1 };
    parallel_for(frame->context->instance.validate ? &alone : env, frame->plan->pass_count, 1,
                 make_range, &making);
    for (uint32_t i = 0; i < frame->plan->pass_count; i++) {
        uint32_t alike = first_alike(frame->plan, i);
        frame->pipelines->pipeline[i] = frame->pipelines->pipeline[alike];
        enum stp_result result = alike < i ? STP_OK : making.result[i];
        if (result != STP_OK)
            result = pass_pipeline(env, frame->context, frame->plan, &frame->plan->pass[i],
                                   &frame->resources, &frame->pipelines->pipeline[i]);
        if (result != STP_OK)
            return result;
    }
    return STP_OK;
}

static enum stp_result make_pipelines(const struct stp_env *env, struct record_frame *frame,
                                      const struct record_host *host)
{
    struct record_bindings bindings = record_find_bindings(frame->plan);
    struct record_pipelines *p = mem_zalloc(1, sizeof *p);
    if (!p)
        return log_no_memory(env, sizeof *p, "pipelines");
    p->users = 1;
    frame->pipelines = p;
    VkResult status = make_layouts(frame->context, p, &bindings, host != NULL);
    if (status != VK_SUCCESS)
        return gpu_error(env, status, "making pipeline layouts");
    frame->resources.layout = p->layout;
    enum stp_result result = compile(env, frame);
    if (result == STP_OK && host)
        result =
            pass_host_pipeline(env, frame->context, frame->plan, &host->pass, p->layout, &p->host);
    return result;
}

enum stp_result record_pipelines_use(const struct stp_env *env, struct record_frame *frame,
                                     struct record_pipelines *shared,
                                     const struct record_host *host)
{
    if (!shared)
        return make_pipelines(env, frame, host);
    shared->users++;
    frame->pipelines = shared;
    frame->resources.layout = shared->layout;
    return STP_OK;
}

struct record_pipelines *record_pipelines_hold(struct record_frame *frame)
{
    frame->pipelines->users++;
    return frame->pipelines;
}

static bool is_first(const struct record_pipelines *p, uint32_t pass)
{
    uint32_t i = 0;
    while (i < pass && p->pipeline[i] != p->pipeline[pass])
        i++;
    return i == pass;
}

void record_pipelines_leave(struct stp_context *c, struct record_pipelines *p)
{
    if (!p || --p->users > 0)
        return;
    for (uint32_t i = 0; i < PLAN_MAX_PASSES; i++)
        if (p->pipeline[i] && is_first(p, i))
            c->vk.vkDestroyPipeline(c->device, p->pipeline[i], NULL);
    if (p->host)
        c->vk.vkDestroyPipeline(c->device, p->host, NULL);
    if (p->layout)
        c->vk.vkDestroyPipelineLayout(c->device, p->layout, NULL);
    if (p->set_layout)
        c->vk.vkDestroyDescriptorSetLayout(c->device, p->set_layout, NULL);
    mem_free(p);
}
