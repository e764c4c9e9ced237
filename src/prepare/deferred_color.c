/* ZP 4.1: Largest-First colouring. */
#include "prepare/prepare.h"

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#define NO_COLOR UINT8_MAX

static size_t degree(const struct overlap_graph *graph, size_t i)
{
    return overlap_row(graph, i).degree;
}

/* Counting sort: degree descending, then id ascending. `start` has max_degree + 2 zeros. */
static void sort_by_degree(const struct overlap_graph *graph, size_t *start, uint32_t *order)
{
    unsigned most = graph->max_degree;
    for (size_t i = 0; i < graph->count; i++)
        start[most - degree(graph, i) + 1]++;
    for (unsigned d = 1; d <= most; d++)
        start[d] += start[d - 1];
    for (size_t i = 0; i < graph->count; i++)
        order[start[most - degree(graph, i)]++] = (uint32_t)i;
}

/* The colour that fewest of the coloured neighbours hold. */
static uint8_t least_held(const struct overlap_graph *graph, const uint8_t *color, uint32_t i,
                          unsigned max_colors)
{
    const struct overlap_row row = overlap_row(graph, i);
    size_t held[STP_MAX_GROUPS] = { 0 };
    uint8_t best = 0;
    for (size_t e = 0; e < row.degree; e++)
        if (color[row.neighbour[e]] != NO_COLOR)
            held[color[row.neighbour[e]]]++;
    for (uint8_t c = 1; c < max_colors; c++)
        if (held[c] < held[best])
            best = c;
    return best;
}

static uint64_t taken(const struct overlap_graph *graph, const uint8_t *color, uint32_t i)
{
    const struct overlap_row row = overlap_row(graph, i);
    uint64_t used = 0;
    for (size_t e = 0; e < row.degree; e++) {
        uint8_t c = color[row.neighbour[e]];
        used |= (uint64_t)(c != NO_COLOR) << (c & 63);
    }
    return used;
}

static void color_in_order(const struct overlap_graph *graph, const uint32_t *order,
                           unsigned max_colors, uint8_t *color, unsigned *count, size_t *conflicts)
{
    const uint64_t all = max_colors < 64 ? ((uint64_t)1 << max_colors) - 1 : UINT64_MAX;
    *count = 0;
    *conflicts = 0;
    for (size_t i = 0; i < graph->count; i++)
        color[i] = NO_COLOR;
    for (size_t k = 0; k < graph->count; k++) {
        uint32_t i = order[k];
        uint64_t free = ~taken(graph, color, i) & all;
        *conflicts += !free;
        color[i] = free ? (uint8_t)__builtin_ctzll(free) : least_held(graph, color, i, max_colors);
        *count = color[i] >= *count ? color[i] + 1u : *count;
    }
}

enum stp_result largest_first_color(const struct stp_env *env, const struct overlap_graph *graph,
                                    unsigned max_colors, uint8_t *color, unsigned *color_count,
                                    size_t *conflicts)
{
    size_t *start = mem_zalloc((size_t)graph->max_degree + 2, sizeof *start);
    uint32_t *order = mem_alloc(graph->count, sizeof *order);
    enum stp_result result = STP_OK;
    if (start && order) {
        sort_by_degree(graph, start, order);
        color_in_order(graph, order, max_colors, color, color_count, conflicts);
    } else {
        result = log_no_memory(env, graph->count * sizeof *order, "the colouring");
    }
    mem_free(start);
    mem_free(order);
    return result;
}
