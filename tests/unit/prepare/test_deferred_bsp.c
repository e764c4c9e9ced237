/* Back-to-front order: of points on one ray the farther comes first, whatever the eye. */
#include "base/memory.h"
#include "overlap_clouds.h"
#include "prepare/deferred_bsp.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#define RAYS  200
#define STEPS 15

static void silent(void *user, enum stp_log_level level, const char *line)
{
    unsigned *lines = user;
    assert_non_null(line);
    ++*lines;
}

/* Group k holds `size[k]` ids, counted on from group to group. */
static struct cover_groups grouped(const struct splats *s, const size_t *size, unsigned groups)
{
    struct cover_groups g = { .groups = groups };
    uint32_t *member = malloc((s->count + 1) * sizeof *member);
    for (unsigned k = 0; k < groups; k++)
        g.first[k + 1] = g.first[k] + (uint32_t)size[k];
    for (uint32_t i = 0; i < s->count; i++)
        member[i] = i;
    assert_int_equal(bsp_build(&(struct stp_env){ .threads = 2 }, s, &g, member), STP_OK);
    free(member);
    return g;
}

static uint32_t *ordered(const struct cover_groups *g, const double eye[3], unsigned threads)
{
    uint32_t *out = malloc((g->first[g->groups] + 1) * sizeof *out);
    bsp_order(&(struct stp_env){ .threads = threads }, g, eye, out);
    return out;
}

/* Every id of a group once, and none of another's. */
static void check_permutation(const struct cover_groups *g, const uint32_t *out)
{
    uint8_t *seen = calloc(g->first[g->groups] + 1, 1);
    for (unsigned k = 0; k < g->groups; k++)
        for (uint32_t i = g->first[k]; i < g->first[k + 1]; i++) {
            assert_true(out[i] >= g->first[k] && out[i] < g->first[k + 1]);
            assert_int_equal(seen[out[i]]++, 0);
        }
    free(seen);
}

/* Id i lies at step i % STEPS of ray i / STEPS: exact multiples, so that they are on one line. */
static struct splats rays(const double eye[3], bool parallel, uint64_t seed)
{
    struct dice d = { seed };
    struct splats s = cloud_make((size_t)RAYS * STEPS);
    double along[3] = { 0.25, -0.5, 0.75 };
    for (size_t r = 0; r < RAYS; r++) {
        double from[3], step[3];
        for (int a = 0; a < 3; a++) {
            double u = floor(uniform(&d) * 64 - 32) / 64;
            step[a] = parallel ? along[a] : u;
            from[a] = parallel ? 8 * u : eye[a];
        }
        if (r % 5 == 0)
            step[r % 3] = 0;
        if (step[0] == 0 && step[1] == 0)
            step[r % 2] = 1;
        for (size_t t = 0; t < STEPS; t++)
            for (int a = 0; a < 3; a++)
                s.position[r * STEPS + t][a] =
                    from[a] + (parallel ? along[a] : step[a]) * (double)(t + 1);
    }
    return s;
}

static void check_rays(const struct cover_groups *g, const uint32_t *out)
{
    int last[RAYS];
    for (int r = 0; r < RAYS; r++)
        last[r] = STEPS;
    for (uint32_t i = 0; i < g->first[g->groups]; i++) {
        int ray = (int)(out[i] / STEPS), step = (int)(out[i] % STEPS);
        assert_true(step < last[ray]);
        last[ray] = step;
    }
}

static void farther_first(void **state)
{
    const double eyes[][3] = { { 0, 0, 0 }, { 3, -2, 5 }, { -1, 0.5, 0 } };
    const size_t all = (size_t)RAYS * STEPS;
    for (unsigned e = 0; e < 3; e++) {
        struct splats s = rays(eyes[e], false, 5 + e);
        struct cover_groups g = grouped(&s, &all, 1);
        uint32_t *out = ordered(&g, eyes[e], 2);
        check_permutation(&g, out);
        check_rays(&g, out);
        free(out);
        cover_groups_release(&g);
        cloud_free(&s);
    }
}

static void farther_first_orthographic(void **state)
{
    const double eye[3] = { -INFINITY, INFINITY, -INFINITY }; /* looks along 0.25 -0.5 0.75 */
    const size_t all = (size_t)RAYS * STEPS;
    struct splats s = rays(NULL, true, 9);
    struct cover_groups g = grouped(&s, &all, 1);
    uint32_t *out = ordered(&g, eye, 2);
    check_permutation(&g, out);
    check_rays(&g, out);
    free(out);
    cover_groups_release(&g);
    cloud_free(&s);
}

static void groups_and_threads(void **state)
{
    const size_t sizes[] = { 0, 1, 2, 7000, 0, 3 };
    const double eye[3] = { 1, 2, 3 };
    for (enum cloud_kind kind = 0; kind < CLOUD_KINDS; kind++) {
        struct splats s = cloud_random(kind, 7006, 3 + (uint64_t)kind);
        struct cover_groups g = grouped(&s, sizes, 6);
        uint32_t *one = ordered(&g, eye, 1), *three = ordered(&g, eye, 3);
        check_permutation(&g, one);
        assert_memory_equal(one, three, 7006 * sizeof *one);
        free(one);
        free(three);
        cover_groups_release(&g);
        cloud_free(&s);
    }
}

static void every_allocation_may_fail(void **state)
{
    struct splats s = cloud_random(CLOUD_UNIFORM, 50, 1);
    uint32_t member[50] = { 0 };
    struct cover_groups g = { .groups = 1, .first = { 0, 50 } };
    unsigned lines = 0;
    struct stp_env env = { .log = silent, .user = &lines };
    for (unsigned long n = 1; n <= 2; n++) {
        mem_fail_at(n);
        assert_int_equal(bsp_build(&env, &s, &g, member), STP_ERROR_MEMORY);
        mem_fail_at(0);
        assert_null(g.node);
        assert_int_equal(lines, n);
    }
    cloud_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(farther_first),
        cmocka_unit_test(farther_first_orthographic),
        cmocka_unit_test(groups_and_threads),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
