#include "clouds.h"

#include "base/memory.h"
#include "prepare/radix.h"

struct pair {
    uint64_t key;
    uint32_t value;
};

static int by_key_then_value(const void *a, const void *b)
{
    const struct pair *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return x->value < y->value ? -1 : x->value > y->value;
}

/* value = index, so a stable sort is the sort by (key, value). */
static void check(size_t count, uint64_t mask, unsigned threads)
{
    struct stp_env env = { .threads = threads };
    uint64_t seed = count * 31 + mask, *key = calloc(count + 1, sizeof *key);
    uint32_t *value = calloc(count + 1, sizeof *value);
    struct pair *expected = calloc(count + 1, sizeof *expected);
    for (size_t i = 0; i < count; i++) {
        key[i] = random_bits(&seed) & mask;
        value[i] = (uint32_t)i;
        expected[i] = (struct pair){ key[i], value[i] };
    }
    qsort(expected, count, sizeof *expected, by_key_then_value);
    assert_int_equal(radix_sort(&env, count, key, value), STP_OK);
    for (size_t i = 0; i < count; i++) {
        assert_true(key[i] == expected[i].key);
        assert_int_equal(value[i], expected[i].value);
    }
    free(key);
    free(value);
    free(expected);
}

static void sorts_like_qsort(void **state)
{
    const size_t counts[] = { 0, 1, 2, 3, 255, 16383, 16384, 16385, 100000 };
    const uint64_t masks[] = { 0, 1, 0xff00, 0xf0f0f0f0f0f0f0f0u, UINT64_MAX };
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (size_t m = 0; m < sizeof masks / sizeof *masks; m++)
            for (unsigned threads = 1; threads <= 5; threads += 2)
                check(counts[c], masks[m], threads);
}

static void failure_leaves_the_input(void **state)
{
    struct stp_env env = { .threads = 2, .log = silent };
    for (unsigned long n = 1;; n++) {
        uint64_t key[3] = { 3, 1, 2 };
        uint32_t value[3] = { 0, 1, 2 };
        mem_fail_at(n);
        enum stp_result result = radix_sort(&env, 3, key, value);
        bool reached = mem_count() >= n;
        mem_fail_at(0);
        if (!reached) {
            assert_int_equal(result, STP_OK);
            assert_true(key[0] == 1 && key[1] == 2 && key[2] == 3);
            assert_true(value[0] == 1 && value[1] == 2 && value[2] == 0);
            return;
        }
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_true(key[0] == 3 && key[1] == 1 && key[2] == 2 && value[0] == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sorts_like_qsort),
        cmocka_unit_test(failure_leaves_the_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
