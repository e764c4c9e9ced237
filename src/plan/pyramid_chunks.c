/* Points that the device cannot hold at once: projecting them has no order, so they pass through
 * its buffers one chunk after another, each projected and gathered before the next. */
#include "plan/plan.h"

#include <stdio.h>
#include <string.h>

uint64_t plan_chunk_points(const struct stp_plan *plan)
{
    uint64_t most = 0;
    for (uint32_t i = 0; i < plan->chunk_count; i++) {
        uint64_t points = plan->chunk[i + 1] - plan->chunk[i];
        most = points > most ? points : most;
    }
    return plan->chunk_count ? most : plan->facts.splats;
}

static uint64_t bytes_of_points(const struct stp_plan *plan)
{
    return 16 + 4 + (plan_has_clusters(plan) ? 1 : 0) + (plan->rim_far ? 5 : 0) +
           (plan->facts.has_color ? 12 : 0) + (plan->facts.objects > 1 ? 4 : 0);
}

/* A quarter of the device's memory leaves room for the picture. */
static uint64_t points_at_once(const struct stp_plan *plan)
{
    uint64_t by_heap = plan->limits.heap_bytes / 4 / bytes_of_points(plan);
    uint64_t by_buffer = plan->limits.max_allocation / 16;
    uint64_t most = by_heap < by_buffer ? by_heap : by_buffer;
    most = most < plan->limits.max_texels ? most : plan->limits.max_texels;
    return most / STP_POINT_RUN * STP_POINT_RUN;
}

static bool all_at_once(const struct stp_plan *plan)
{
    uint64_t n = plan->facts.splats;
    return n * bytes_of_points(plan) <= plan->limits.heap_bytes / 2 &&
           n <= plan->limits.max_texels && n * 16 <= plan->limits.max_allocation;
}

/* Parts of at most `most` points; false: too many. */
static bool append(struct stp_plan *plan, uint64_t first, uint64_t end, uint64_t most)
{
    uint64_t parts = (end - first + most - 1) / most;
    if (plan->chunk_count + parts > PLAN_MAX_CHUNKS)
        return false;
    for (uint64_t i = 0; i < parts; i++) {
        uint64_t at = first + i * most;
        plan->chunk[plan->chunk_count++] = (uint32_t)at;
    }
    plan->chunk[plan->chunk_count] = (uint32_t)end;
    return true;
}

bool plan_pyramid_chunks(struct stp_plan *plan)
{
    uint64_t most = points_at_once(plan);
    bool all = true;
    plan->chunk_count = 0;
    if (!plan->stream_count && all_at_once(plan))
        return true;
    if (most == 0)
        return false;
    if (!plan->stream_count)
        all = append(plan, 0, plan->facts.splats, most);
    for (uint32_t i = 0; i < plan->stream_count && all; i++)
        all = append(plan, plan->stream[i], plan->stream[i + 1], most);
    size_t length = strlen(plan->why);
    snprintf(plan->why + length, sizeof plan->why - length,
             " The points pass through the device's memory in %u chunk%s%s.", plan->chunk_count,
             plan->chunk_count == 1 ? "" : "s", plan->stream_count ? ", from their file" : "");
    return all;
}
