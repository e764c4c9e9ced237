/* The passes of a plan, one after another; what they wait for: hazards.h. */
#include "record/hazards.h"
#include "record/record.h"

static void barrier(struct record_frame *frame, VkCommandBuffer commands,
                    const VkMemoryBarrier2 *memory)
{
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .memoryBarrierCount = 1,
                              .pMemoryBarriers = memory };
    frame->context->vk.vkCmdPipelineBarrier2(commands, &info);
}

static void synchronise(struct record_frame *frame, VkCommandBuffer commands,
                        const struct plan_pass *pass, struct hazards *hazards, bool skip)
{
    VkMemoryBarrier2 memory = { .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2 };
    hazards_add(hazards, frame->plan, pass, &memory);
    if (memory.srcStageMask && !skip)
        barrier(frame, commands, &memory);
}

VkMemoryBarrier2 record_everything(void)
{
    return (VkMemoryBarrier2){ .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                               .srcStageMask = RECORD_STAGES,
                               .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                               .dstStageMask = RECORD_STAGES,
                               .dstAccessMask =
                                   VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT };
}

/* Images are in the general layout throughout: they are attachments once and storage once, and a
 * transition between would cost more than it could gain. keep: what is in them. */
static void begin(struct record_frame *frame, VkCommandBuffer commands, bool keep)
{
    VkImageMemoryBarrier2 images[PLAN_MAX_RESOURCES];
    uint32_t count = 0;
    for (uint32_t i = 0; i < frame->plan->resource_count; i++) {
        struct gpu_image *image = &frame->resources.image[i];
        if (!image->handle)
            continue;
        images[count++] = (VkImageMemoryBarrier2){
            .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
            .srcStageMask = RECORD_STAGES,
            .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
            .dstStageMask = RECORD_STAGES,
            .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
            .oldLayout = keep ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_UNDEFINED,
            .newLayout = VK_IMAGE_LAYOUT_GENERAL,
            .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
            .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
            .image = image->handle,
            .subresourceRange = { image->aspect, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS }
        };
    }
    VkMemoryBarrier2 memory = record_everything();
    VkDependencyInfo info = { .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .memoryBarrierCount = 1,
                              .pMemoryBarriers = &memory,
                              .imageMemoryBarrierCount = count,
                              .pImageMemoryBarriers = images };
    frame->context->vk.vkCmdPipelineBarrier2(commands, &info);
}

static void write_constants(struct record_frame *frame, VkCommandBuffer commands,
                            const struct plan_tile *tile)
{
    struct stp_frame_constants constants = pass_constants(frame->plan, &frame->resources, tile);
    constants.deep_first = frame->deep ? frame->deep->first : 0;
    frame->context->vk.vkCmdUpdateBuffer(commands, frame->resources.constants.handle, 0,
                                         sizeof constants, &constants);
    VkMemoryBarrier2 memory = { .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                                .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                .dstStageMask = VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
                                                VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT |
                                                VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                .dstAccessMask = VK_ACCESS_2_UNIFORM_READ_BIT };
    barrier(frame, commands, &memory);
}

static void bind(struct record_frame *frame, VkCommandBuffer commands)
{
    const VkPipelineBindPoint points[] = { VK_PIPELINE_BIND_POINT_COMPUTE,
                                           VK_PIPELINE_BIND_POINT_GRAPHICS };
    for (int i = 0; i < 2; i++)
        frame->context->vk.vkCmdBindDescriptorSets(commands, points[i], frame->resources.layout, 0,
                                                   1, &frame->resources.set, 0, NULL);
}

static void stamp(struct record_frame *frame, VkCommandBuffer commands, uint32_t query)
{
    VkMemoryBarrier2 all = record_everything();
    barrier(frame, commands, &all);
    frame->context->vk.vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                            frame->queries, query);
}

static bool is_deep(enum plan_slot slot)
{
    return slot == PLAN_DEEP_LAYERS || slot == PLAN_DEEP_COUNTS;
}

/* What was written to where the host reads it: of outputs that it does not see, layers after every
 * part, the others in the end. */
static void finish(struct record_frame *frame, VkCommandBuffer commands, bool last)
{
    const struct stp_plan *plan = frame->plan;
    bool copies = false;
    VkMemoryBarrier2 memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = RECORD_STAGES,
        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT
    };
    barrier(frame, commands, &memory);
    for (uint32_t i = 0; i < plan->resource_count; i++) {
        if (!frame->read_back[i].handle || !(last || is_deep(plan->resource[i].slot)))
            continue;
        VkBufferCopy copy = { .size = plan->resource[i].bytes };
        frame->context->vk.vkCmdCopyBuffer(commands, frame->resources.buffer[i].handle,
                                           frame->read_back[i].handle, 1, &copy);
        copies = true;
    }
    if (copies)
        barrier(frame, commands, &memory);
}

static void copy_remaining(struct record_frame *frame, VkCommandBuffer commands)
{
    uint8_t work = plan_find(frame->plan, PLAN_WORK);
    VkMemoryBarrier2 memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT
    };
    VkBufferCopy copy = { .srcOffset = STP_WORK_REMAINING * 4, .size = 4 };
    barrier(frame, commands, &memory);
    frame->context->vk.vkCmdCopyBuffer(commands, frame->resources.buffer[work].handle,
                                       frame->remaining.handle, 1, &copy);
    barrier(frame, commands, &memory);
}

static void push_sample(struct record_frame *frame, VkCommandBuffer commands, uint32_t sample)
{
    frame->context->vk.vkCmdPushConstants(commands, frame->resources.layout, PASS_PUSH_STAGES,
                                          PASS_PUSH_SAMPLE, sizeof sample, &sample);
}

static uint32_t exchanges(const struct stp_plan *plan)
{
    uint32_t count = 0;
    for (uint32_t i = plan->repeat_first; i < plan->repeat_end; i++)
        count += plan->pass[i].kind == PLAN_EXCHANGE;
    return count;
}

/* The index of the n-th exchange; with n their number, the end of the repeated passes. */
static uint32_t find_exchange(const struct stp_plan *plan, uint32_t n)
{
    for (uint32_t i = plan->repeat_first; i < plan->repeat_end; i++)
        if (plan->pass[i].kind == PLAN_EXCHANGE && n-- == 0)
            return i;
    return plan->repeat_end;
}

/* A part between exchanges: passes one after another, of one sample. */
static struct record_steps steps_between(const struct stp_plan *plan, uint32_t part, uint32_t count)
{
    uint32_t sample = part / (count + 1), place = part % (count + 1);
    uint32_t end = find_exchange(plan, place);
    bool last = sample + 1 == plan_samples(plan) && place == count;
    struct record_steps steps = { .plan = plan,
                                  .first_sample = sample,
                                  .exchange = place < count ? end : RECORD_NO_PASS,
                                  .last = last };
    if (place > 0)
        steps.first_pass = find_exchange(plan, place - 1) + 1;
    else
        steps.first_pass = sample == 0 ? 0 : plan->repeat_first;
    steps.before = (last ? plan->pass_count : end) - steps.first_pass;
    steps.count = steps.before;
    return steps;
}

/* Of a sample: one a chunk, and where passes take the chunks again, one more for each but the last,
 * which is still there and goes on with them. */
static uint32_t chunk_parts(const struct stp_plan *plan)
{
    return plan->again_end ? 2 * plan->chunk_count - 1 : plan->chunk_count;
}

/* Where the passes of a chunk's part end, which is not the last of its sample. */
static uint32_t chunk_part_end(const struct stp_plan *plan, uint32_t turn)
{
    return turn + 1 < plan->chunk_count ? plan->chunk_end : plan->again_end;
}

/* A part of one chunk: the first begins its sample, the last goes on to the picture. Again, chunks
 * come from the last to the first. */
static struct record_steps steps_of_chunk(const struct stp_plan *plan, uint32_t part)
{
    uint32_t parts = chunk_parts(plan), sample = part / parts, turn = part % parts;
    uint32_t chunks = plan->chunk_count, chunk = turn < chunks ? turn : 2 * (chunks - 1) - turn;
    bool last = turn + 1 == parts, ends = last && sample + 1 == plan_samples(plan);
    uint32_t first = turn >= chunks ? plan->again_first
                     : turn > 0     ? plan->chunk_first
                     : sample > 0   ? plan->repeat_first
                                    : 0;
    uint32_t end = ends ? plan->pass_count : last ? plan->repeat_end : chunk_part_end(plan, turn);
    return (struct record_steps){ .plan = plan,
                                  .count = end - first,
                                  .before = end - first,
                                  .first_sample = sample,
                                  .first_pass = first,
                                  .chunk = chunk,
                                  .keeps = turn > 0,
                                  .exchange = RECORD_NO_PASS,
                                  .last = ends };
}

uint32_t record_parts(const struct stp_plan *plan)
{
    if (plan->chunk_count)
        return plan_samples(plan) * chunk_parts(plan);
    if (plan->loop_first)
        return 2 * plan_samples(plan) + 1;
    uint32_t count = exchanges(plan);
    if (count)
        return plan_samples(plan) * (count + 1);
    return (plan_repeats(plan) + RECORD_SAMPLES - 1) / RECORD_SAMPLES;
}

static struct record_steps looping_steps(const struct stp_plan *plan, uint32_t part)
{
    struct record_steps steps = { .plan = plan,
                                  .first_sample = part / 2,
                                  .exchange = RECORD_NO_PASS };
    steps.last = part == 2 * plan_samples(plan);
    steps.loops = part % 2 == 1;
    steps.before = part == 0 ? plan->repeat_first : 0;
    steps.first = steps.loops ? plan->loop_first : plan->repeat_first;
    steps.length = (steps.loops ? plan->repeat_end : plan->loop_first) - steps.first;
    steps.repeated = steps.last ? 0 : steps.length * (steps.loops ? RECORD_TURNS : 1);
    steps.count = steps.before + steps.repeated;
    if (steps.last)
        steps.count += plan->pass_count - plan->repeat_end;
    return steps;
}

struct record_steps record_steps(const struct stp_plan *plan, uint32_t part)
{
    if (plan->chunk_count)
        return steps_of_chunk(plan, part);
    if (plan->loop_first)
        return looping_steps(plan, part);
    uint32_t count = exchanges(plan);
    if (count)
        return steps_between(plan, part, count);
    uint32_t first = part * RECORD_SAMPLES, left = plan_repeats(plan) - first;
    struct record_steps steps = { .plan = plan, .first_sample = first, .exchange = RECORD_NO_PASS };
    uint32_t samples = left < RECORD_SAMPLES ? left : RECORD_SAMPLES;
    steps.before = first == 0 ? plan->repeat_first : 0;
    steps.first = plan->repeat_first;
    steps.length = plan->repeat_end - plan->repeat_first;
    steps.repeated = samples * steps.length;
    steps.count = steps.before + steps.repeated;
    steps.last = samples == left;
    if (steps.last)
        steps.count += plan->pass_count - plan->repeat_end;
    return steps;
}

uint32_t record_step(const struct record_steps *steps, uint32_t i, uint32_t *sample)
{
    *sample = steps->first_sample;
    if (i < steps->before)
        return steps->first_pass + i;
    i -= steps->before;
    if (i >= steps->repeated)
        return steps->plan->repeat_end + i - steps->repeated;
    *sample += steps->loops ? 0 : i / steps->length;
    return steps->first + i % steps->length;
}

static struct pass_points points_of(const struct stp_plan *plan, uint32_t chunk)
{
    if (!plan->chunk_count)
        return (struct pass_points){ 0, (uint32_t)plan->facts.splats };
    return (struct pass_points){ plan->chunk[chunk], plan->chunk[chunk + 1] - plan->chunk[chunk] };
}

void record_walk(struct record_frame *frame, VkCommandBuffer commands, const struct plan_tile *tile,
                 uint32_t part, bool timed, uint32_t skip_barrier)
{
    const struct stp_plan *plan = frame->plan;
    struct record_steps steps = record_steps(plan, part);
    struct hazards hazards = { 0 };
    uint32_t sample, pushed = UINT32_MAX;
    timed = timed && frame->queries;
    if (timed)
        frame->context->vk.vkCmdResetQueryPool(commands, frame->queries, 0, steps.count + 1);
    begin(frame, commands, steps.keeps);
    frame->resources.points = points_of(plan, steps.chunk);
    write_constants(frame, commands, tile);
    bind(frame, commands);
    if (timed)
        stamp(frame, commands, 0);
    for (uint32_t i = 0; i < steps.count; i++) {
        uint32_t pass = record_step(&steps, i, &sample);
        if (sample != pushed)
            push_sample(frame, commands, sample);
        pushed = sample;
        synchronise(frame, commands, &plan->pass[pass], &hazards, pass == skip_barrier);
        pass_record(frame->context, commands, plan, &plan->pass[pass], tile, &frame->resources,
                    frame->pipelines->pipeline[pass]);
        if (timed)
            stamp(frame, commands, i + 1);
    }
    if (plan->loop_first && !frame->pipelines->host)
        copy_remaining(frame, commands);
    bool read = steps.last || steps.exchange != RECORD_NO_PASS || plan->constant[PLAN_DEEP];
    if (read && !frame->pipelines->host)
        finish(frame, commands, steps.last);
}
