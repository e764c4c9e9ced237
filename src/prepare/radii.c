#include "prepare/radii.h"

#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/bounds.h"

#define MONSTER_OF_MEDIAN  64.0
#define MONSTER_OF_SPACING 8.0
#define PLATE_OF_LOCAL     4.0
#define PLATE_OF_ALL       32.0
#define SMALLEST           1e-18f /* its square is still a normal float32 */
#define LARGEST            1e18f
#define GRAIN              4096

bool radius_is_good(float radius)
{
    return radius >= SMALLEST && radius <= LARGEST;
}

enum stp_result radii_median(const struct stp_env *env, const float *radius, size_t count,
                             float *median)
{
    double *good = mem_alloc(count, sizeof *good);
    size_t n = 0;
    if (!good)
        return log_no_memory(env, count * sizeof *good, "the median radius");
    for (size_t i = 0; i < count; i++)
        if (radius_is_good(radius[i]))
            good[n++] = (double)radius[i];
    *median = n > 0 ? (float)select_rank(good, n, (n - 1) / 2) : 0;
    mem_free(good);
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
    const struct neighbour_tree *tree;
    const struct surroundings *all;
    float *radius;
    float median;    /* of the radii, or of the spacings */
    float otherwise; /* where there is no spacing at all */
    size_t *per_worker;
};

static void monster_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct radii *r = context;
    for (size_t i = begin; i < end; i++) {
        struct surrounding around;
        if (!is_suspect(r->radius[i], r->median))
            continue;
        surrounding_of(r->tree, i, &around);
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
    parallel_for(env, r->tree->count, GRAIN, fn, r);
    *count = 0;
    for (unsigned worker = 0; worker < threads; worker++)
        *count += r->per_worker[worker];
    mem_free(r->per_worker);
    return STP_OK;
}

enum stp_result radii_blank_monsters(const struct stp_env *env, const struct neighbour_tree *tree,
                                     float *radius, float median, size_t *count)
{
    struct radii r = { .tree = tree, .radius = radius, .median = median };
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
        double spacing = (double)r->all->spacing[i], local, bound;
        if (r->radius[i] > 0)
            continue;
        local = local_median(r->all, i);
        bound =
            fmin(local > 0 ? PLATE_OF_LOCAL * local : INFINITY, PLATE_OF_ALL * (double)r->median);
        if (!radius_is_good((float)spacing))
            spacing = local > 0 ? local : (double)r->otherwise;
        else if (spacing > bound)
            r->per_worker[worker]++;
        r->radius[i] = (float)fmin(fmax(fmin(spacing, bound), (double)SMALLEST), (double)LARGEST);
    }
}

static double largest_coordinate(const struct neighbour_tree *tree)
{
    double most = 0;
    for (size_t i = 0; i < tree->count; i++)
        for (int axis = 0; axis < 3; axis++)
            most = fmax(most, fabs(tree->position[i][axis]));
    return most;
}

enum stp_result radii_fill(const struct stp_env *env, const struct neighbour_tree *tree,
                           const struct surroundings *all, float *radius, size_t *outliers)
{
    struct radii r = { .tree = tree, .all = all, .radius = radius };
    enum stp_result result = radii_median(env, all->spacing, tree->count, &r.median);
    if (result != STP_OK)
        return result;
    if (r.median == 0)
        r.median = (float)fmax(1, 1e-6 * largest_coordinate(tree));
    r.otherwise = r.median;
    return count_over(env, &r, fill_range, outliers);
}
