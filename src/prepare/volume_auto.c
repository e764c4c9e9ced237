/* A transfer function from the histogram alone. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/volume.h"

#define BINS 1024

static double bin_centre(const struct grid *grid, double bin)
{
    return grid->low + (bin + 0.5) / BINS * (grid->high - grid->low);
}

static uint64_t count_values(const struct grid *grid, uint64_t *bins)
{
    size_t count = grid_count(grid);
    double scale = BINS / (grid->high - grid->low);
    uint64_t total = 0;
    for (size_t i = 0; i < count; i++) {
        double v = (double)grid->value[i];
        if (!isfinite(v))
            continue;
        int bin = (int)((v - grid->low) * scale);
        bins[bin < BINS ? bin : BINS - 1]++;
        total++;
    }
    return total;
}

/* Otsu: the cut that leaves the least variance within its two sides. */
static int otsu(const uint64_t *bins, uint64_t total)
{
    double sum = 0, below = 0, weight = 0, most = -1;
    int best = 0;
    for (int i = 0; i < BINS; i++)
        sum += (double)bins[i] * i;
    for (int i = 0; i + 1 < BINS; i++) {
        weight += (double)bins[i];
        below += (double)bins[i] * i;
        double other = (double)total - weight;
        if (weight == 0 || other == 0)
            continue;
        double apart = below / weight - (sum - below) / other;
        double between = weight * other * apart * apart;
        if (between > most) {
            most = between;
            best = i;
        }
    }
    return best;
}

static int percentile(const uint64_t *bins, uint64_t total, double share)
{
    double wanted = share * (double)total, seen = 0;
    for (int i = 0; i < BINS; i++) {
        seen += (double)bins[i];
        if (seen >= wanted)
            return i;
    }
    return BINS - 1;
}

enum stp_result transfer_automatic(const struct stp_env *env, const struct grid *grid,
                                   struct transfer_function *function)
{
    static const struct transfer_point ramp[] = {
        { 0, { 0.75f, 0.35f, 0.2f }, 0 },
        { 0.15, { 0.8f, 0.45f, 0.28f }, 0.04f },
        { 0.5, { 0.9f, 0.75f, 0.55f }, 0.25f },
        { 1, { 0.95f, 0.93f, 0.88f }, 0.8f },
    };
    struct transfer_function made = { .name = "auto" };
    if (!(grid->high > grid->low)) {
        made.count = 1;
        made.point[0] = (struct transfer_point){ grid->low, { 0.8f, 0.8f, 0.8f }, 0.1f };
        *function = made;
        return STP_OK;
    }
    uint64_t *bins = mem_zalloc(BINS, sizeof *bins);
    if (!bins)
        return log_no_memory(env, BINS * sizeof *bins, "a histogram");
    uint64_t total = count_values(grid, bins);
    int cut = otsu(bins, total), top = percentile(bins, total, 0.999);
    mem_free(bins);
    double from = bin_centre(grid, cut), to = bin_centre(grid, top > cut + 8 ? top : cut + 8);
    made.count = sizeof ramp / sizeof *ramp;
    for (unsigned i = 0; i < made.count; i++) {
        made.point[i] = ramp[i];
        made.point[i].value = from + ramp[i].value * (to - from);
    }
    *function = made;
    return STP_OK;
}
