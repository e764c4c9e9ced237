#include "prepare/bounds.h"

#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#define BLOCK 16384

struct bounds_job {
    const double (*position)[3];
    const uint32_t *order;
    struct bounds *box; /* a worker */
};

static void grow(struct bounds *box, const double *low, const double *high)
{
    for (int axis = 0; axis < 3; axis++) {
        if (low[axis] < box->low[axis])
            box->low[axis] = low[axis];
        if (high[axis] > box->high[axis])
            box->high[axis] = high[axis];
    }
}

static void grow_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct bounds_job *job = context;
    struct bounds box = job->box[worker];
    for (size_t i = begin; i < end; i++) {
        const double *p = job->position[job->order ? job->order[i] : i];
        grow(&box, p, p);
    }
    job->box[worker] = box;
}

enum stp_result bounds_of(const struct stp_env *env, const double (*position)[3],
                          const uint32_t *order, size_t count, struct bounds *bounds)
{
    struct bounds empty = { { INFINITY, INFINITY, INFINITY }, { -INFINITY, -INFINITY, -INFINITY } };
    unsigned threads = thread_count(env);
    struct bounds_job job = { position, order, mem_alloc(threads, sizeof *job.box) };
    if (!job.box)
        return log_no_memory(env, threads * sizeof *job.box, "bounds");
    for (unsigned worker = 0; worker < threads; worker++)
        job.box[worker] = empty;
    parallel_for(env, count, BLOCK, grow_range, &job);
    *bounds = empty;
    for (unsigned worker = 0; worker < threads; worker++)
        grow(bounds, job.box[worker].low, job.box[worker].high);
    mem_free(job.box);
    return STP_OK;
}

double bounds_extent(const struct bounds *b)
{
    return fmax(b->high[0] - b->low[0], fmax(b->high[1] - b->low[1], b->high[2] - b->low[2]));
}

double bounds_diagonal(const struct bounds *b)
{
    double x = b->high[0] - b->low[0], y = b->high[1] - b->low[1], z = b->high[2] - b->low[2];
    return sqrt(x * x + y * y + z * z);
}

struct sum_job {
    block_sum_fn fn;
    const void *context;
    double (*sum)[SUM_WIDTH]; /* a block */
};

static void sum_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct sum_job *job = context;
    job->fn(job->context, begin, end, job->sum[begin / BLOCK]);
}

enum stp_result block_sum(const struct stp_env *env, size_t count, unsigned width, block_sum_fn fn,
                          const void *context, double *sum)
{
    size_t blocks = (count + BLOCK - 1) / BLOCK;
    struct sum_job job = { fn, context, mem_zalloc(blocks, sizeof *job.sum) };
    if (!job.sum)
        return log_no_memory(env, blocks * sizeof *job.sum, "sums");
    parallel_for(env, count, BLOCK, sum_range, &job);
    for (unsigned i = 0; i < width; i++) {
        sum[i] = 0;
        for (size_t block = 0; block < blocks; block++)
            sum[i] += job.sum[block][i];
    }
    mem_free(job.sum);
    return STP_OK;
}

static double middle(double a, double b, double c)
{
    return fmax(fmin(a, b), fmin(fmax(a, b), c));
}

/* Quickselect in three parts, so that many equal values cost nothing. */
double select_rank(double *v, size_t count, size_t rank)
{
    size_t low = 0, high = count;
    for (;;) {
        double pivot = middle(v[low], v[low + (high - low) / 2], v[high - 1]);
        size_t less = low, at = low, more = high;
        while (at < more) {
            double value = v[at];
            if (value < pivot) {
                v[at++] = v[less];
                v[less++] = value;
            } else if (value > pivot) {
                v[at] = v[--more];
                v[more] = value;
            } else {
                at++;
            }
        }
        if (rank < less)
            high = less;
        else if (rank >= more)
            low = more;
        else
            return pivot;
    }
}
