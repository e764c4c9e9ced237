#include "passes/passes.h"

#include <stddef.h>

/* The order of the addresses is the order of enum plan_slot. */
#define SLOT_OFFSET(member, slot)                                                                  \
    _Static_assert(offsetof(struct stp_frame_constants, member) == 8 * (slot), #member)
SLOT_OFFSET(splats, PLAN_SPLATS);
SLOT_OFFSET(colors, PLAN_COLORS);
SLOT_OFFSET(opacities, PLAN_OPACITIES);
SLOT_OFFSET(ellipses, PLAN_ELLIPSES);
SLOT_OFFSET(clips, PLAN_CLIPS);
SLOT_OFFSET(materials, PLAN_MATERIALS);
SLOT_OFFSET(optics, PLAN_OBJECT_OPTICS);
SLOT_OFFSET(environment, PLAN_ENVIRONMENT);
SLOT_OFFSET(light_cube, PLAN_LIGHTS);
SLOT_OFFSET(order, PLAN_ORDER);
SLOT_OFFSET(work, PLAN_WORK);
SLOT_OFFSET(objects, PLAN_OBJECTS);
SLOT_OFFSET(rim, PLAN_RIM);
SLOT_OFFSET(large, PLAN_LARGE);
SLOT_OFFSET(bins, PLAN_BINNED_LISTS);
SLOT_OFFSET(keys, PLAN_KEYS);
SLOT_OFFSET(key_ids, PLAN_SLOT_IDS);
SLOT_OFFSET(traits, PLAN_TRAITS);
SLOT_OFFSET(counts, PLAN_COUNTS);
SLOT_OFFSET(nearest, PLAN_NEAREST);
SLOT_OFFSET(sums, PLAN_SUMS);
SLOT_OFFSET(projected, PLAN_PROJECTED);
SLOT_OFFSET(axis_sums, PLAN_AXIS_SUMS);
SLOT_OFFSET(host_words, PLAN_HOST_WORDS);
SLOT_OFFSET(limits, PLAN_LIMITS);
SLOT_OFFSET(out_color, PLAN_OUT_COLOR);
SLOT_OFFSET(out_normal, PLAN_OUT_NORMAL);
SLOT_OFFSET(out_depth, PLAN_OUT_DEPTH);
SLOT_OFFSET(out_albedo, PLAN_OUT_ALBEDO);
SLOT_OFFSET(out_id, PLAN_OUT_ID);
SLOT_OFFSET(deep_layers, PLAN_DEEP_LAYERS);
SLOT_OFFSET(deep_counts, PLAN_DEEP_COUNTS);
/* Scalar layout: nothing is padded before the lights. */
_Static_assert(offsetof(struct stp_frame_constants, rotation64) == 8 * PLAN_BUFFER_SLOTS &&
                   offsetof(struct stp_frame_constants, rotation) ==
                       offsetof(struct stp_frame_constants, rotation64) + 19 * sizeof(double),
               "rotation");
_Static_assert(offsetof(struct stp_frame_constants, lights) ==
                   offsetof(struct stp_frame_constants, pyramid_color) + 4,
               "lights");
#define BINDING(binding, slot) _Static_assert((binding) == PLAN_BINDING(slot), #slot)
BINDING(STP_BINDING_PYRAMID, PLAN_IMAGE_PYRAMID);
BINDING(STP_BINDING_ATTRIBUTES, PLAN_IMAGE_ATTRIBUTES);
BINDING(STP_BINDING_POINTS, PLAN_TEXEL_POINTS);
BINDING(STP_BINDING_RADII, PLAN_TEXEL_RADII);
BINDING(STP_BINDING_AXIS_COLOR, PLAN_IMAGE_AXIS_COLOR);
BINDING(STP_BINDING_AXIS_DEPTH, PLAN_IMAGE_AXIS_DEPTH);
BINDING(STP_BINDING_SLOTS, PLAN_TEXEL_KEYS);
BINDING(STP_BINDING_SLOT_IDS, PLAN_TEXEL_SLOT_IDS);
BINDING(STP_BINDING_PROJECTED, PLAN_TEXEL_PROJECTED);
BINDING(STP_BINDING_ORDER, PLAN_TEXEL_ORDER);
BINDING(STP_BINDING_CLUSTERS, PLAN_TEXEL_CLUSTERS);
BINDING(STP_BINDING_TRAITS, PLAN_TEXEL_TRAITS);
_Static_assert(STP_AXIS_MERGE_CLIP - STP_AXIS_MERGE_BLEND == STP_AXIS_CLIP - STP_AXIS_BLEND,
               "merges");
_Static_assert(offsetof(struct stp_frame_constants, axis) ==
                   offsetof(struct stp_frame_constants, lights) +
                       STP_LIGHTS * sizeof(struct stp_light_gpu) + sizeof(struct stp_material_gpu),
               "axis");
_Static_assert(sizeof(struct stp_frame_constants) % 4 == 0 &&
                   sizeof(struct stp_frame_constants) < 65536,
               "vkCmdUpdateBuffer");

#define WIDEST_GUARD 4

float pass_guard(const struct stp_plan *plan, const struct plan_tile *tile)
{
    uint32_t most = plan->limits.max_image_size, guard = 1;
    while (guard < WIDEST_GUARD && tile->width <= most / guard / 2 &&
           tile->height <= most / guard / 2)
        guard *= 2;
    return (float)guard;
}

struct stp_frame_constants pass_constants(const struct stp_plan *plan,
                                          const struct pass_resources *resources,
                                          const struct plan_tile *tile)
{
    struct stp_frame_constants constants = plan->frame;
    uint64_t *address = (uint64_t *)&constants;
    for (uint32_t i = 0; i < plan->resource_count; i++)
        if (plan->resource[i].slot < PLAN_BUFFER_SLOTS)
            address[plan->resource[i].slot] = resources->buffer[i].address;
    constants.known_count = (uint32_t)(plan_splats(plan) + plan_ghosts(plan));
    constants.tile_x = tile->x;
    constants.tile_y = tile->y;
    constants.tile_width = tile->width;
    constants.tile_height = tile->height;
    constants.guard = 1 / pass_guard(plan, tile);
    constants.blocks_x = (tile->width + STP_BLOCK - 1) / STP_BLOCK;
    constants.blocks_y = (tile->height + STP_BLOCK - 1) / STP_BLOCK;
    if (plan->method == STP_METHOD_PYRAMID) {
        struct plan_grid grid = plan_tile_grid(plan, tile);
        constants.grid_x = grid.x;
        constants.grid_y = grid.y;
        constants.grid_width = grid.width;
        constants.grid_height = grid.height;
    }
    return constants;
}
