/* Least-significant-digit radix sort: per digit, a histogram a block, one prefix sum over
 * (digit, block), and a stable scatter. */
#include "prepare/radix.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#define BINS      256
#define MIN_BLOCK 16384

struct pairs {
    uint64_t *key;
    uint32_t *value;
};

struct sort {
    struct pairs from, to;
    size_t count, block;
    unsigned shift;
    uint32_t (*bins)[BINS]; /* a block: counts, then where the next pair of a digit goes */
    uint64_t *varying;      /* a block: the bits in which some key differs from the first */
};

static void find_varying(void *context, size_t begin, size_t end, unsigned)
{
    struct sort *s = context;
    uint64_t first = s->from.key[0], bits = 0;
    for (size_t i = begin; i < end; i++)
        bits |= s->from.key[i] ^ first;
    s->varying[begin / s->block] = bits;
}

static void count_digits(void *context, size_t begin, size_t end, unsigned)
{
    struct sort *s = context;
    uint32_t *bins = s->bins[begin / s->block];
    memset(bins, 0, sizeof s->bins[0]);
    for (size_t i = begin; i < end; i++)
        bins[s->from.key[i] >> s->shift & (BINS - 1)]++;
}

static void scatter(void *context, size_t begin, size_t end, unsigned)
{
    struct sort *s = context;
    uint32_t *next = s->bins[begin / s->block];
    for (size_t i = begin; i < end; i++) {
        uint64_t key = s->from.key[i];
        uint32_t at = next[key >> s->shift & (BINS - 1)]++;
        s->to.key[at] = key;
        s->to.value[at] = s->from.value[i];
    }
}

static void prefix_sums(struct sort *s, size_t blocks)
{
    uint32_t sum = 0;
    for (unsigned digit = 0; digit < BINS; digit++)
        for (size_t block = 0; block < blocks; block++) {
            uint32_t count = s->bins[block][digit];
            s->bins[block][digit] = sum;
            sum += count;
        }
}

static void sort_digits(const struct stp_env *env, struct sort *s, size_t blocks)
{
    uint64_t varying = 0;
    parallel_for(env, s->count, s->block, find_varying, s);
    for (size_t block = 0; block < blocks; block++)
        varying |= s->varying[block];
    for (s->shift = 0; s->shift < 64; s->shift += 8) {
        if ((varying >> s->shift & (BINS - 1)) == 0)
            continue;
        parallel_for(env, s->count, s->block, count_digits, s);
        prefix_sums(s, blocks);
        parallel_for(env, s->count, s->block, scatter, s);
        struct pairs swap = s->from;
        s->from = s->to;
        s->to = swap;
    }
}

enum stp_result radix_sort(const struct stp_env *env, size_t count, uint64_t *key, uint32_t *value)
{
    if (count < 2)
        return STP_OK;
    size_t threads = thread_count(env), block = (count + threads - 1) / threads;
    if (block < MIN_BLOCK)
        block = MIN_BLOCK;
    size_t blocks = (count + block - 1) / block;
    struct pairs spare = { mem_alloc(count, sizeof *key), mem_alloc(count, sizeof *value) };
    struct sort s = { { key, value },
                      spare,
                      count,
                      block,
                      0,
                      mem_alloc(blocks, sizeof *s.bins),
                      mem_alloc(blocks, sizeof *s.varying) };
    bool ready = spare.key && spare.value && s.bins && s.varying;
    if (ready)
        sort_digits(env, &s, blocks);
    if (ready && s.from.key != key) {
        memcpy(key, s.from.key, count * sizeof *key);
        memcpy(value, s.from.value, count * sizeof *value);
    }
    mem_free(spare.key);
    mem_free(spare.value);
    mem_free(s.bins);
    mem_free(s.varying);
    return ready ? STP_OK : log_no_memory(env, count * 12, "the radix sort");
}
