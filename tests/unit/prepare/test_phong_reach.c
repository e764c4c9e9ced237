/* Sites in the order of their metric: against the C library's sort, on even and on crowded ones. */
#include "clouds.h"

#include "prepare/phong_reach.h"

static int plainly(const void *a, const void *b)
{
    const struct reached *p = a, *q = b;
    if (p->metric < q->metric || (p->metric == q->metric && p->site < q->site))
        return -1;
    return p->metric > q->metric || p->site > q->site;
}

typedef double (*metric_fn)(uint64_t *dice, size_t i, size_t count);

static double even(uint64_t *dice, size_t i, size_t count)
{
    return i == 0 ? -1 : random_unit(dice);
}
/* All but one in a millionth of the range. */
static double one_far(uint64_t *dice, size_t i, size_t count)
{
    return i + 1 == count ? 1 : 1e-6 * random_unit(dice);
}
static double few_values(uint64_t *dice, size_t i, size_t count)
{
    return (double)(random_bits(dice) % 3) / 2;
}
static double all_at_once(uint64_t *dice, size_t i, size_t count)
{
    return 0;
}
static double only_the_seed(uint64_t *dice, size_t i, size_t count)
{
    return i < count / 2 ? -1 : 0;
}

static void sorts(void **state)
{
    const metric_fn metric[] = { even, one_far, few_values, all_at_once, only_the_seed };
    const size_t counts[] = { 1, 2, 3, 17, 255, 4000 };
    uint64_t dice = 3;
    for (unsigned m = 0; m < 5; m++)
        for (unsigned c = 0; c < 6; c++) {
            size_t count = counts[c];
            struct reached *list = calloc(count, sizeof *list), *room = calloc(count, sizeof *room),
                           *wanted = calloc(count, sizeof *wanted);
            uint32_t *bucket = calloc(count, sizeof *bucket);
            for (size_t i = 0; i < count; i++)
                list[i] = wanted[i] =
                    (struct reached){ metric[m](&dice, i, count), (uint32_t)(i * 7919 % 4001) };
            qsort(wanted, count, sizeof *wanted, plainly);
            reached_sort(list, count, room, bucket);
            for (size_t i = 0; i < count; i++) {
                assert_true(list[i].metric == wanted[i].metric);
                assert_int_equal(list[i].site, wanted[i].site);
            }
            free(list);
            free(room);
            free(wanted);
            free(bucket);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(sorts) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
