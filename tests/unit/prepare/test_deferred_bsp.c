/* Back-to-front order: of points on one ray the farther comes first, whatever the eye. */
#include "base/memory.h"
#include "base/vec.h"
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

static uint32_t *ordered(const struct cover_groups *g, const double eye[4], unsigned threads)
{
    uint32_t *out = malloc((g->first[g->groups] + 1) * sizeof *out);
    assert_int_equal(bsp_order(&(struct stp_env){ .threads = threads }, g, eye, out), STP_OK);
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
    const double eyes[][4] = { { 0, 0, 0, 1 }, { 3, -2, 5, 1 }, { -1, 0.5, 0, 1 } };
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
    const double eye[4] = { -0.25, 0.5, -0.75, 0 };
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

/* Two sheets of SHEET x SHEET overlapping discs of radius 1, two radii apart along n; the far one's
 * ids come first, or the near one's. */
#define SHEET 16
static struct splats two_sheets(struct vec3 n, bool far_first, struct dice *d)
{
    struct splats s = cloud_make((size_t)2 * SHEET * SHEET);
    struct vec3 u = v3_unit(v3_cross(n, fabs(n.x) < 0.7 ? v3(1, 0, 0) : v3(0, 1, 0)));
    struct vec3 v = v3_cross(n, u);
    for (size_t i = 0; i < s.count; i++) {
        double x = (double)(i % SHEET) - 0.5 * SHEET + 0.3 * uniform(d);
        double y = (double)(i / SHEET % SHEET) - 0.5 * SHEET + 0.3 * uniform(d);
        bool far = (i < s.count / 2) == far_first;
        struct vec3 p =
            v3_add(v3_add(v3_scale(u, x), v3_scale(v, y)), v3_scale(n, far ? -2.0 : 0.0));
        memcpy(s.position[i], (double[3]){ p.x, p.y, p.z }, sizeof s.position[i]);
        memcpy(s.normal[i], (float[3]){ (float)n.x, (float)n.y, (float)n.z }, sizeof s.normal[i]);
    }
    return s;
}

/* Of the pairs of a far and a near disc that overlap as seen along n, the share that is the wrong
 * way round. */
static double wrong_pairs(const struct splats *s, struct vec3 n, bool far_first,
                          const uint32_t *out)
{
    size_t half = s->count / 2, wrong = 0, pairs = 0;
    uint32_t *place = malloc(s->count * sizeof *place);
    for (uint32_t i = 0; i < s->count; i++)
        place[out[i]] = i;
    for (size_t i = 0; i < half; i++)
        for (size_t j = half; j < s->count; j++) {
            struct vec3 v =
                v3(s->position[i][0] - s->position[j][0], s->position[i][1] - s->position[j][1],
                   s->position[i][2] - s->position[j][2]);
            if (v3_dot(v, v) - v3_dot(v, n) * v3_dot(v, n) > 2 * 2)
                continue;
            pairs++;
            wrong += (place[i] < place[j]) != far_first;
        }
    free(place);
    return (double)wrong / (double)pairs;
}

/* Sheets closer than their discs are wide, seen face on: planes along the sheets part them, however
 * they stand. Across them, every other disc at a plane is the wrong way round. */
static void parts_sheets(void **state)
{
    struct dice d = { 77 };
    double worst = 0, sum = 0;
    for (int k = 0; k < 40; k++) {
        float m[3];
        random_normal(&d, m);
        struct vec3 n = k < 3 ? v3(k == 0, k == 1, k == 2) : v3_unit(v3(m[0], m[1], m[2]));
        struct splats s = two_sheets(n, k % 2, &d);
        struct cover_groups g = grouped(&s, &s.count, 1);
        double far = k % 4 < 2 ? 0 : 1, eye[4] = { 50 * n.x, 50 * n.y, 50 * n.z, far };
        uint32_t *out = ordered(&g, eye, 2);
        double wrong = wrong_pairs(&s, n, k % 2, out);
        check_permutation(&g, out);
        assert_true(k >= 3 || wrong == 0);
        worst = fmax(worst, wrong);
        sum += wrong / 40;
        free(out);
        cover_groups_release(&g);
        cloud_free(&s);
    }
    if (worst > 0.1 || sum > 0.02)
        fail_msg("%.3f of the pairs at worst, %.3f in the mean", worst, sum);
}

/* A ball of radius 1 within a shell of radius 2, of discs of radius BALL_DISC each. */
#define BALL      4000
#define BALL_DISC 0.1
static struct splats ball_in_shell(void)
{
    struct splats s = cloud_make(BALL);
    for (size_t i = 0; i < BALL; i++) {
        double z = 1 - (2 * (double)i + 1) / BALL, turn = (double)i * M_PI * (3 - sqrt(5));
        double at = i % 2 ? 1 : 2, r = sqrt(1 - z * z), n[3] = { r * cos(turn), r * sin(turn), z };
        for (int a = 0; a < 3; a++) {
            s.position[i][a] = at * n[a];
            s.normal[i][a] = (float)n[a];
        }
        s.radius[i] = BALL_DISC;
    }
    return s;
}

/* Symmetric, so that the first planes go through the middle, and seen along them. A disc that a
 * plane cuts must not come before those behind it on the other side: of discs that overlap as seen
 * along z, sheets apart, the farther comes first. */
static void planes_seen_edge_on(void **state)
{
    const double eyes[][4] = { { 0, 0, 1, 0 }, { 0, 0, -3, 0 }, { 0, 0, 1e6, 1 } };
    struct splats s = ball_in_shell();
    struct cover_groups g = grouped(&s, &s.count, 1);
    for (unsigned e = 0; e < 3; e++) {
        uint32_t *out = ordered(&g, eyes[e], 2), place[BALL];
        double sign = eyes[e][2] > 0 ? 1 : -1;
        size_t pairs = 0;
        check_permutation(&g, out);
        for (uint32_t i = 0; i < BALL; i++)
            place[out[i]] = i;
        for (size_t i = 0; i < BALL; i++)
            for (size_t j = 0; j < i; j++) {
                const double *p = s.position[i], *q = s.position[j];
                double gap = sign * (p[2] - q[2]);
                if (hypot(p[0] - q[0], p[1] - q[1]) > 2 * BALL_DISC || fabs(gap) < 4 * BALL_DISC)
                    continue;
                pairs++;
                assert_true((gap > 0) == (place[i] > place[j]));
            }
        assert_true(pairs > 10000);
        free(out);
    }
    cover_groups_release(&g);
    cloud_free(&s);
}

static void groups_and_threads(void **state)
{
    const size_t sizes[] = { 0, 1, 2, 7000, 0, 3 };
    const double eye[4] = { 1, 2, 3, 1 };
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

static void every_allocation_of_a_walk_may_fail(void **state)
{
    struct splats s = ball_in_shell();
    struct cover_groups g = grouped(&s, &s.count, 1);
    uint32_t out[BALL];
    unsigned lines = 0;
    struct stp_env env = { .log = silent, .user = &lines };
    unsigned long n = 1;
    for (;; n++) {
        mem_fail_at(n);
        enum stp_result result = bsp_order(&env, &g, (double[4]){ 0, 0, 1, 0 }, out);
        mem_fail_at(0);
        if (result == STP_OK)
            break;
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_int_equal(lines, n);
    }
    assert_true(n > 2);
    check_permutation(&g, out);
    cover_groups_release(&g);
    cloud_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(farther_first),
        cmocka_unit_test(farther_first_orthographic),
        cmocka_unit_test(parts_sheets),
        cmocka_unit_test(groups_and_threads),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(every_allocation_of_a_walk_may_fail),
        cmocka_unit_test(planes_seen_edge_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
