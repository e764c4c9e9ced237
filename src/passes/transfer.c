#include "passes/passes.h"

static uint32_t blocks(uint32_t pixels)
{
    return (pixels + STP_BLOCK - 1) / STP_BLOCK;
}

/* Words of the work buffer that start as 0: flags of blocks, a pyramid's open pixels. */
static uint32_t word_count(const struct stp_plan *plan, const struct plan_tile *tile)
{
    if (plan->method != STP_METHOD_PYRAMID)
        return blocks(tile->width) * blocks(tile->height);
    struct plan_grid grid = plan_tile_grid(plan, tile);
    return plan_level_blocks(&grid, 0) * STP_WORK_BLOCK_RESET;
}

/* Indirect arguments start as one row of no workgroups, flags as untouched, lists as empty. */
static void reset_arguments(struct stp_context *context, VkCommandBuffer commands,
                            uint32_t word_count, bool bins, const struct gpu_buffer *work)
{
    uint32_t words[STP_WORK_FLAGS] = { 0 };
    const uint32_t arguments[] = { STP_WORK_LARGE,    STP_WORK_BLOCKS,        STP_WORK_REPAIR,
                                   STP_WORK_REPAIR_L, STP_WORK_REPAIR_BLOCKS, STP_WORK_COLLECT,
                                   STP_WORK_OPEN };
    for (unsigned i = 0; i < sizeof arguments / sizeof *arguments; i++)
        words[arguments[i] + 1] = words[arguments[i] + 2] = 1;
    context->vk.vkCmdUpdateBuffer(commands, work->handle, 0, sizeof words, words);
    VkDeviceSize flags = (VkDeviceSize)word_count * 4;
    context->vk.vkCmdFillBuffer(commands, work->handle, STP_WORK_FLAGS * 4, flags, 0);
    if (bins)
        context->vk.vkCmdFillBuffer(commands, work->handle, STP_WORK_FLAGS * 4 + 2 * flags, flags,
                                    0);
}

/* The first component of each texel takes the word, the others are 0. */
static void clear_image(struct stp_context *context, VkCommandBuffer commands,
                        const struct gpu_image *image, uint32_t word)
{
    VkClearColorValue value = { .uint32 = { word, 0, 0, 0 } };
    VkImageSubresourceRange all = { image->aspect, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS };
    context->vk.vkCmdClearColorImage(commands, image->handle, VK_IMAGE_LAYOUT_GENERAL, &value, 1,
                                     &all);
}

void pass_record_transfer(struct stp_context *context, VkCommandBuffer commands,
                          const struct stp_plan *plan, const struct plan_pass *pass,
                          const struct plan_tile *tile, const struct pass_resources *resources)
{
    if (pass->kind == PLAN_ARGUMENTS) {
        uint8_t work = pass->access[0].resource;
        reset_arguments(context, commands, word_count(plan, tile), plan->constant[PLAN_BINS] != 0,
                        &resources->buffer[work]);
        return;
    }
    if (pass_is_image(plan->resource[pass->target].format)) {
        clear_image(context, commands, &resources->image[pass->target], pass->value);
        return;
    }
    VkDeviceSize bytes = plan->resource[pass->target].bytes / 4 * 4;
    context->vk.vkCmdFillBuffer(commands, resources->buffer[pass->target].handle, 0, bytes,
                                pass->value);
}
