#include "prepare/radii.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/bounds.h"

#define MONSTER_OF_MEDIAN  64.0
#define MONSTER_OF_SPACING 8.0
#define PLATE_OF_LOCAL     4.0
#define PLATE_OF_ALL       16.0
#define SMALLEST           1e-18f /* its square is still a normal float32 */
#define LARGEST            1e18f
#define GRAIN              4096

bool radius_is_good(float radius)
{
    return radius >= SMALLEST && radius <= LARGEST;
}

#define HALF_BINS RADII_BINS

/* The bits of positive floats order as they do: first the upper half, then the lower. */
void radii_tally(const float *radius, size_t count, size_t *bins, const uint32_t *upper)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        if (!radius_is_good(radius[i]))
            continue;
        memcpy(&bits, &radius[i], sizeof bits);
        if (!upper)
            bins[bits >> 16]++;
        else if (bits >> 16 == *upper)
            bins[bits & (HALF_BINS - 1)]++;
    }
}

/* The bin that holds the rank, which becomes a rank within it. */
uint32_t radii_bin_of_rank(const size_t *bins, size_t *rank)
{
    uint32_t bin = 0;
    for (; *rank >= bins[bin]; bin++)
        *rank -= bins[bin];
    return bin;
}

enum stp_result radii_median(const struct stp_env *env, const float *radius, size_t count,
                             float *median)
{
    size_t *bins = mem_zalloc(HALF_BINS, sizeof *bins), good = 0;
    if (!bins)
        return log_no_memory(env, HALF_BINS * sizeof *bins, "the median radius");
    radii_tally(radius, count, bins, NULL);
    for (uint32_t bin = 0; bin < HALF_BINS; bin++)
        good += bins[bin];
    *median = 0;
    if (good > 0) {
        size_t rank = (good - 1) / 2;
        uint32_t upper = radii_bin_of_rank(bins, &rank);
        memset(bins, 0, HALF_BINS * sizeof *bins);
        radii_tally(radius, count, bins, &upper);
        uint32_t bits = upper << 16 | radii_bin_of_rank(bins, &rank);
        memcpy(median, &bits, sizeof bits);
    }
    mem_free(bins);
    return STP_OK;
}

size_t radii_unknown(const float *radius, size_t count)
{
    size_t unknown = 0;
    for (size_t i = 0; i < count; i++)
        unknown += !(radius[i] > 0);
    return unknown;
}

static bool is_suspect(float radius, float median)
{
    return median > 0 && (double)radius > MONSTER_OF_MEDIAN * (double)median;
}

bool radii_are_suspect(const float *radius, size_t count, float median)
{
    for (size_t i = 0; i < count; i++)
        if (is_suspect(radius[i], median))
            return true;
    return false;
}

struct radii {
    size_t count;
    const struct places *places;
    const struct neighbour_tree *tree;
    const struct surroundings *all;
    float *radius;
    float median; /* of the radii, or of the spacings */
    size_t *per_worker;
};

static void monster_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct radii *r = context;
    for (size_t i = begin; i < end; i++) {
        struct surrounding around;
        if (!is_suspect(r->radius[i], r->median))
            continue;
        surrounding_of(r->tree, place_of(r->places, i), &around);
        if ((double)r->radius[i] > MONSTER_OF_SPACING * around.spacing) {
            r->radius[i] = 0;
            r->per_worker[worker]++;
        }
    }
}

/* Counts are integers: their sum does not depend on who counted what. */
static enum stp_result count_over(const struct stp_env *env, struct radii *r, range_fn fn,
                                  size_t *count)
{
    unsigned threads = thread_count(env);
    r->per_worker = mem_zalloc(threads, sizeof *r->per_worker);
    if (!r->per_worker)
        return log_no_memory(env, threads * sizeof *r->per_worker, "counters");
    parallel_for(env, r->count, GRAIN, fn, r);
    *count = 0;
    for (unsigned worker = 0; worker < threads; worker++)
        *count += r->per_worker[worker];
    mem_free(r->per_worker);
    return STP_OK;
}

enum stp_result radii_blank_monsters(const struct stp_env *env, const struct places *places,
                                     const struct neighbour_tree *tree, float *radius,
                                     size_t splats, float median, size_t *count)
{
    struct radii r = {
        .count = splats, .places = places, .tree = tree, .radius = radius, .median = median
    };
    return count_over(env, &r, monster_range, count);
}

/* Lower median of the neighbours' spacings that are not 0; 0: there is none. */
static double local_median(const struct surroundings *all, size_t i)
{
    double spacing[SURROUND_GRAPH];
    size_t n = 0;
    for (unsigned k = 0; k < SURROUND_GRAPH; k++) {
        uint32_t j = all->neighbour[i][k];
        if (j != NO_NEIGHBOUR && all->spacing[j] > 0)
            spacing[n++] = (double)all->spacing[j];
    }
    return n > 0 ? select_rank(spacing, n, (n - 1) / 2) : 0;
}

static void fill_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct radii *r = context;
    for (size_t i = begin; i < end; i++) {
        size_t place = place_of(r->places, i);
        double spacing = (double)r->all->spacing[place], local, bound;
        if (r->radius[i] > 0)
            continue;
        local = local_median(r->all, place);
        bound =
            fmin(local > 0 ? PLATE_OF_LOCAL * local : INFINITY, PLATE_OF_ALL * (double)r->median);
        if (!radius_is_good((float)spacing))
            spacing = local > 0 ? local : (double)r->median;
        else if (spacing > bound)
            r->per_worker[worker]++;
        r->radius[i] = (float)fmin(fmax(fmin(spacing, bound), (double)SMALLEST), (double)LARGEST);
    }
}

static double largest_coordinate(const struct places *places)
{
    double most = 0;
    for (size_t i = 0; i < places->count; i++)
        for (int axis = 0; axis < 3; axis++)
            most = fmax(most, fabs(places->position[i][axis]));
    return most;
}

enum stp_result radii_fill(const struct stp_env *env, const struct places *places,
                           const struct surroundings *all, float *radius, size_t splats,
                           size_t *outliers)
{
    struct radii r = { .count = splats, .places = places, .all = all, .radius = radius };
    enum stp_result result = radii_median(env, all->spacing, places->count, &r.median);
    if (result != STP_OK)
        return result;
    if (r.median == 0)
        r.median = (float)fmax(1, 1e-6 * largest_coordinate(places));
    return count_over(env, &r, fill_range, outliers);
}
