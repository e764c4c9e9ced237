#include "clouds.h"

#include "base/memory.h"
#include "prepare/order.h"

#define COUNT 20000

/* Clusters, repeats, an outlier, signed zeros: whatever makes cells full. */
static void fill(struct splats *s, size_t at, uint32_t i)
{
    uint64_t seed = i % 16000;
    double scale = i % 5 == 0 ? 1e-9 : 1;
    for (int axis = 0; axis < 3; axis++) {
        s->position[at][axis] = floor(random_unit(&seed) * 40) * scale;
        s->normal[at][axis] = (float)(int)(random_bits(&seed) % 3) - 1;
        s->color[at][axis] = (float)(random_bits(&seed) % 2);
    }
    if (i % 7 == 0)
        s->position[at][1] = i % 2 ? 0.0 : -0.0;
    if (i == 1234)
        s->position[at][0] = 1e12;
    s->radius[at] = (float)(random_bits(&seed) % 4) + 1;
    s->object[at] = (uint16_t)(random_bits(&seed) % 3);
    s->input[at] = i;
}

static struct splats make(void)
{
    struct splats s = { .count = COUNT };
    s.position = mem_alloc(COUNT, sizeof *s.position);
    s.normal = mem_alloc(COUNT, sizeof *s.normal);
    s.radius = mem_alloc(COUNT, sizeof *s.radius);
    s.color = mem_alloc(COUNT, sizeof *s.color);
    s.object = mem_alloc(COUNT, sizeof *s.object);
    s.input = mem_alloc(COUNT, sizeof *s.input);
    for (size_t i = 0; i < COUNT; i++)
        fill(&s, i, (uint32_t)i);
    return s;
}

static void shuffle(struct splats *s, uint64_t seed)
{
    for (size_t i = s->count - 1; i > 0; i--) {
        size_t j = random_bits(&seed) % (i + 1);
        uint32_t keep = s->input[i];
        s->input[i] = s->input[j];
        s->input[j] = keep;
    }
    for (size_t i = 0; i < s->count; i++)
        fill(s, i, s->input[i]);
}

static void assert_same_splats(const struct splats *a, const struct splats *b)
{
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->position, b->position, a->count * sizeof *a->position);
    assert_memory_equal(a->normal, b->normal, a->count * sizeof *a->normal);
    assert_memory_equal(a->radius, b->radius, a->count * sizeof *a->radius);
    assert_memory_equal(a->color, b->color, a->count * sizeof *a->color);
    assert_memory_equal(a->object, b->object, a->count * sizeof *a->object);
}

static bool equals(const struct splats *s, size_t i, size_t j)
{
    return memcmp(s->position[i], s->position[j], 24) == 0 &&
           memcmp(s->normal[i], s->normal[j], 12) == 0 &&
           memcmp(s->color[i], s->color[j], 12) == 0 && s->radius[i] == s->radius[j] &&
           s->object[i] == s->object[j];
}

static void same_for_any_order_and_threads(void **state)
{
    struct splats first = make();
    size_t duplicates, equal = 0;
    assert_int_equal(order_splats(&(struct stp_env){ .threads = 1 }, &first, &duplicates), STP_OK);
    for (size_t i = 1; i < COUNT; i++)
        equal += equals(&first, i - 1, i);
    assert_int_equal(duplicates, equal);
    assert_true(duplicates > 1000);
    for (unsigned round = 1; round < 5; round++) {
        struct splats again = make();
        size_t same;
        shuffle(&again, round);
        assert_int_equal(order_splats(&(struct stp_env){ .threads = round }, &again, &same),
                         STP_OK);
        assert_same_splats(&first, &again);
        assert_memory_equal(first.input, again.input, COUNT * sizeof *first.input);
        assert_int_equal(same, duplicates);
        splats_release(&again);
    }
    splats_release(&first);
}

static void every_splat_is_kept(void **state)
{
    struct splats s = make(), plain = make();
    static unsigned char seen[COUNT];
    memset(seen, 0, sizeof seen);
    assert_int_equal(order_splats(NULL, &s, NULL), STP_OK);
    for (size_t i = 0; i < COUNT; i++) {
        size_t from = s.input[i];
        assert_false(seen[from]++);
        assert_memory_equal(s.position[i], plain.position[from], 24);
        assert_memory_equal(s.color[i], plain.color[from], 12);
    }
    splats_release(&s);
    splats_release(&plain);
}

/* Octants of the bounds come one after the other: that is what Morton order means. */
static void octants_are_runs(void **state)
{
    struct splats s = { .count = 4096, .position = mem_alloc(4096, sizeof *s.position) };
    uint64_t seed = 3;
    for (size_t i = 0; i < s.count; i++)
        for (int axis = 0; axis < 3; axis++)
            s.position[i][axis] = i == 0 ? 0 : i == 1 ? 1 : random_unit(&seed);
    assert_int_equal(order_splats(NULL, &s, NULL), STP_OK);
    int last = 0;
    for (size_t i = 0; i < s.count; i++) {
        int octant = (s.position[i][0] >= 0.5) * 4 + (s.position[i][1] >= 0.5) * 2 +
                     (s.position[i][2] >= 0.5);
        assert_true(octant >= last);
        last = octant;
    }
    splats_release(&s);
}

/* The outlier takes all the bits of the first code: the cluster must be ordered all the same. */
static void outlier_keeps_locality(void **state)
{
    struct splats s = { .count = 5000, .position = mem_alloc(5000, sizeof *s.position) };
    uint64_t seed = 3;
    double walked = 0;
    for (size_t i = 0; i < s.count; i++)
        for (int axis = 0; axis < 3; axis++)
            s.position[i][axis] = i == 77 ? 1e15 : random_unit(&seed);
    assert_int_equal(order_splats(NULL, &s, NULL), STP_OK);
    for (size_t i = 1; i + 1 < s.count; i++)
        walked += fabs(s.position[i][0] - s.position[i - 1][0]);
    assert_true(walked / 5000 < 0.1); /* a random order walks 1/3 a step */
    splats_release(&s);
}

static void survives_no_memory(void **state)
{
    struct stp_env env = { .log = silent, .threads = 2 };
    for (unsigned long n = 1;; n++) {
        struct splats s = make();
        mem_fail_at(n);
        enum stp_result result = order_splats(&env, &s, NULL);
        bool reached = mem_count() >= n;
        mem_fail_at(0);
        splats_release(&s);
        assert_int_equal(result, reached ? STP_ERROR_MEMORY : STP_OK);
        if (!reached)
            return;
        if (n > 60) /* the recursion allocates the same few things again and again */
            n += 211;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_for_any_order_and_threads),
        cmocka_unit_test(every_splat_is_kept),
        cmocka_unit_test(octants_are_runs),
        cmocka_unit_test(outlier_keeps_locality),
        cmocka_unit_test(survives_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
