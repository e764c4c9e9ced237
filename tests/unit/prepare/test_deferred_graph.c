/* The overlap graph against every pair tested one by one. */
#include "base/memory.h"
#include "overlap_clouds.h"
#include "prepare/prepare.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

static void silent(void *user, enum stp_log_level level, const char *line)
{
    unsigned *lines = user;
    assert_non_null(line);
    if (lines)
        ++*lines;
}

static double angle_between(const float a[3], const float b[3])
{
    double ab = 0, aa = 0, bb = 0;
    for (int k = 0; k < 3; k++) {
        ab += (double)a[k] * b[k];
        aa += (double)a[k] * a[k];
        bb += (double)b[k] * b[k];
    }
    return aa > 0 && bb > 0 ? acos(fmin(1, fmax(-1, ab / sqrt(aa * bb)))) * 180 / M_PI : 90;
}

static bool expect_coplanar(const struct splats *s, size_t i, size_t j)
{
    double limit = COPLANAR_OFFSET * fmin(s->radius[i], s->radius[j]), h[2] = { 0, 0 };
    if (angle_between(s->normal[i], s->normal[j]) > COPLANAR_DEGREES)
        return false;
    for (int k = 0; k < 3; k++) {
        h[0] += s->normal[i][k] * (s->position[i][k] - s->position[j][k]);
        h[1] += s->normal[j][k] * (s->position[i][k] - s->position[j][k]);
        if (fabsf(s->color[i][k] - s->color[j][k]) > COPLANAR_COLOR)
            return false;
    }
    return fabs(h[0]) <= limit && fabs(h[1]) <= limit && s->object[i] == s->object[j] &&
           fabsf(s->opacity[i] - s->opacity[j]) <= COPLANAR_COLOR;
}

static bool expect_edge(const struct splats *s, const struct overlap_params *p, size_t i, size_t j)
{
    if (i == j || (p->skip && (p->skip[i] || p->skip[j])))
        return false;
    double d2 = 0, t = p->overlap * ((double)s->radius[i] + s->radius[j]);
    for (int k = 0; k < 3; k++) {
        double d = s->position[i][k] - s->position[j][k];
        d2 += d * d;
    }
    if (!(d2 < t * t))
        return false;
    if ((p->relax & STP_RELAX_OPPOSED) && angle_between(s->normal[i], s->normal[j]) > 90)
        return false;
    return !(p->relax & STP_RELAX_COPLANAR) || !expect_coplanar(s, i, j);
}

static void check_graph(const struct splats *s, const struct overlap_params *p,
                        const struct overlap_graph *g)
{
    size_t edges = 0, max = 0, nodes = 0;
    assert_int_equal(g->count, s->count);
    for (size_t i = 0; i < s->count; i++) {
        struct overlap_row row = overlap_row(g, i);
        size_t e = 0;
        bool skipped = p->skip && p->skip[i];
        for (size_t j = 0; j < s->count && !skipped; j++)
            if (expect_edge(s, p, i, j)) {
                assert_true(e < row.degree);
                assert_int_equal(row.neighbour[e++], j);
            }
        assert_int_equal(row.degree, e);
        edges += e;
        max = e > max ? e : max;
        nodes += !skipped;
    }
    assert_int_equal(g->edges, edges / 2);
    assert_int_equal(g->max_degree, max);
    assert_int_equal(g->nodes, nodes);
}

static void build_and_check(const struct splats *s, const struct overlap_params *p)
{
    struct overlap_graph g = { 0 };
    assert_int_equal(overlap_graph_build(NULL, s, p, &g, NULL), STP_OK);
    check_graph(s, p, &g);
    overlap_graph_release(&g);
    assert_null(g.end);
}

static void equals_every_pair(void **state)
{
    const double overlaps[] = { 1, 0.5, 0.1 };
    const unsigned relax[] = { STP_RELAX_NONE, STP_RELAX_OPPOSED, STP_RELAX_COPLANAR,
                               STP_RELAX_OPPOSED | STP_RELAX_COPLANAR };
    for (enum cloud_kind kind = 0; kind < CLOUD_KINDS; kind++) {
        struct splats s = cloud_random(kind, 260, kind + 1);
        for (size_t c = 0; c < 3; c++)
            for (size_t r = 0; r < 4; r++)
                build_and_check(&s, &(struct overlap_params){ overlaps[c], relax[r], NULL, 0 });
        cloud_free(&s);
    }
}

/* Block and tree boundaries, and a splat that covers all the others. */
static void every_small_count(void **state)
{
    for (size_t n = 0; n < 150; n++) {
        struct splats s = cloud_random(n % CLOUD_KINDS, n, n + 1);
        if (n > 3)
            s.radius[n / 2] = 1e4f;
        build_and_check(&s, &(struct overlap_params){ 1, STP_RELAX_NONE, NULL, 0 });
        cloud_free(&s);
    }
}

static void skipped_splats_have_no_edges(void **state)
{
    struct splats s = cloud_random(CLOUD_UNIFORM, 900, 3);
    struct dice d = { 99 };
    uint8_t *skip = calloc(s.count, 1);
    for (size_t i = 0; i < s.count; i++)
        skip[i] = roll(&d) % 3 == 0 || (i > 200 && i < 400);
    build_and_check(&s, &(struct overlap_params){ 1, STP_RELAX_OPPOSED, skip, 0 });
    memset(skip, 1, s.count);
    build_and_check(&s, &(struct overlap_params){ 1, STP_RELAX_OPPOSED, skip, 0 });
    free(skip);
    cloud_free(&s);
}

/* Left-out splats shift blocks across the ends of pools. */
static void skipped_across_pools(void **state)
{
    struct splats s = cloud_random(CLOUD_CLUSTERS, 2 * OVERLAP_POOL + 100, 3);
    uint8_t *skip = calloc(s.count, 1);
    for (size_t i = 0; i < s.count; i++)
        skip[i] = i % 7 != 0 && i != OVERLAP_POOL && i != OVERLAP_POOL - 1;
    build_and_check(&s, &(struct overlap_params){ 1, STP_RELAX_NONE, skip, 0 });
    free(skip);
    cloud_free(&s);
}

/* Enough splats that several pools are joined. */
static void threads_make_no_difference(void **state)
{
    struct splats s = cloud_random(CLOUD_RADII, 2 * OVERLAP_POOL + 500, 5);
    struct overlap_params p = { 0.7, STP_RELAX_OPPOSED, NULL, 0 };
    struct overlap_graph one = { 0 }, many = { 0 };
    assert_int_equal(overlap_graph_build(&(struct stp_env){ .threads = 1 }, &s, &p, &one, NULL), 0);
    assert_int_equal(overlap_graph_build(&(struct stp_env){ .threads = 5 }, &s, &p, &many, NULL),
                     0);
    assert_int_equal(one.edges, many.edges);
    for (size_t i = 0; i < s.count; i++) {
        struct overlap_row a = overlap_row(&one, i), b = overlap_row(&many, i);
        assert_int_equal(a.degree, b.degree);
        if (a.degree)
            assert_memory_equal(a.neighbour, b.neighbour, a.degree * sizeof *a.neighbour);
    }
    assert_int_equal(one.max_degree, many.max_degree);
    overlap_graph_release(&one);
    overlap_graph_release(&many);
    cloud_free(&s);
}

static struct splats two(double distance)
{
    struct splats s = cloud_make(2);
    s.position[1][0] = distance;
    s.normal[0][2] = s.normal[1][2] = 1;
    return s;
}

static bool joined(const struct splats *s, double overlap, unsigned relax)
{
    struct overlap_params p = { overlap, relax, NULL, 0 };
    struct overlap_graph g = { 0 };
    assert_int_equal(overlap_graph_build(NULL, s, &p, &g, NULL), STP_OK);
    size_t edges = g.edges;
    overlap_graph_release(&g);
    assert_in_range(edges, 0, 1);
    return edges == 1;
}

static void the_limit_is_open(void **state)
{
    struct splats s = two(2);
    assert_false(joined(&s, 1, STP_RELAX_NONE));
    s.position[1][0] = nextafter(2, 0);
    assert_true(joined(&s, 1, STP_RELAX_NONE));
    s.position[1][0] = 1;
    assert_false(joined(&s, 0.5, STP_RELAX_NONE));
    assert_true(joined(&s, nextafter(0.5, 1), STP_RELAX_NONE));
    cloud_free(&s);
}

static void opposed_by_sign(void **state)
{
    struct splats s = two(1);
    memcpy(s.normal[1], (float[3]){ 1, 0, 0 }, sizeof s.normal[1]);
    assert_true(joined(&s, 1, STP_RELAX_OPPOSED)); /* at right angles */
    memcpy(s.normal[1], (float[3]){ 1, 0, -1e-6f }, sizeof s.normal[1]);
    assert_false(joined(&s, 1, STP_RELAX_OPPOSED));
    assert_true(joined(&s, 1, STP_RELAX_NONE));
    assert_true(joined(&s, 1, STP_RELAX_COPLANAR));
    memset(s.normal[1], 0, sizeof s.normal[1]);
    assert_true(joined(&s, 1, STP_RELAX_OPPOSED | STP_RELAX_COPLANAR));
    memset(s.normal[0], 0, sizeof s.normal[0]);
    assert_true(joined(&s, 1, STP_RELAX_OPPOSED | STP_RELAX_COPLANAR));
    cloud_free(&s);
}

static void tilt(struct splats *s, double degrees)
{
    s->normal[1][1] = (float)sin(degrees * M_PI / 180); /* across: the offset stays 0 */
    s->normal[1][2] = (float)cos(degrees * M_PI / 180);
}

static void coplanar_by_tolerance(void **state)
{
    struct splats s = two(1);
    s.radius[1] = 0.5f;
    assert_false(joined(&s, 1, STP_RELAX_COPLANAR));
    tilt(&s, 0.99 * COPLANAR_DEGREES);
    assert_false(joined(&s, 1, STP_RELAX_COPLANAR));
    tilt(&s, 1.01 * COPLANAR_DEGREES);
    assert_true(joined(&s, 1, STP_RELAX_COPLANAR));
    tilt(&s, 0);
    s.position[1][2] = 0.99 * COPLANAR_OFFSET * 0.5;
    assert_false(joined(&s, 1, STP_RELAX_COPLANAR));
    s.position[1][2] = 1.01 * COPLANAR_OFFSET * 0.5;
    assert_true(joined(&s, 1, STP_RELAX_COPLANAR));
    s.position[1][2] = 0;
    assert_true(joined(&s, 1, STP_RELAX_NONE));
    cloud_free(&s);
}

static void coplanar_of_one_colour(void **state)
{
    struct splats s = two(1);
    s.color[1][2] = (float)(1.01 * COPLANAR_COLOR);
    assert_true(joined(&s, 1, STP_RELAX_COPLANAR));
    s.color[1][2] = (float)(0.99 * COPLANAR_COLOR);
    assert_false(joined(&s, 1, STP_RELAX_COPLANAR));
    s.opacity[1] = 0.5f;
    assert_true(joined(&s, 1, STP_RELAX_COPLANAR));
    s.opacity[1] = 1;
    s.object[1] = 1;
    assert_true(joined(&s, 1, STP_RELAX_COPLANAR));
    free(s.object);
    free(s.color);
    free(s.opacity);
    s.object = NULL;
    s.color = NULL;
    s.opacity = NULL;
    assert_false(joined(&s, 1, STP_RELAX_COPLANAR));
    cloud_free(&s);
}

static void overload_is_told(void **state)
{
    struct splats s = cloud_random(CLOUD_COINCIDENT, 300, 1);
    struct overlap_params p = { 1, STP_RELAX_NONE, NULL, 300 * 299 / 2 };
    struct overlap_graph g = { 0 };
    bool overload = true;
    assert_int_equal(overlap_graph_build(NULL, &s, &p, &g, &overload), STP_OK);
    assert_false(overload);
    assert_int_equal(g.edges, 300 * 299 / 2);
    overlap_graph_release(&g);
    p.max_edges--;
    g.count = 12345;
    assert_int_equal(overlap_graph_build(NULL, &s, &p, &g, &overload), STP_OK);
    assert_true(overload);
    assert_int_equal(g.count, 12345);
    cloud_free(&s);
}

/* A whole heap without one edge is still out of proportion to search. */
static void search_is_bounded(void **state)
{
    struct splats s = cloud_random(CLOUD_COINCIDENT, 60000, 1);
    for (size_t i = 0; i < s.count; i++) {
        memset(s.normal[i], 0, sizeof s.normal[i]);
        s.normal[i][2] = 1;
    }
    struct overlap_params p = { 1, STP_RELAX_COPLANAR, NULL, 1000000 };
    struct overlap_graph g = { 0 };
    bool overload = false;
    assert_int_equal(overlap_graph_build(NULL, &s, &p, &g, &overload), STP_OK);
    assert_true(overload);
    cloud_free(&s);
}

static void every_allocation_may_fail(void **state)
{
    struct splats s = cloud_random(CLOUD_UNIFORM, OVERLAP_POOL + 500, 8);
    struct overlap_params p = { 1, STP_RELAX_OPPOSED, NULL, 0 };
    unsigned lines = 0;
    struct stp_env env = { .threads = 2, .log = silent, .user = &lines };
    struct overlap_graph g = { .count = 7 };
    mem_fail_at(0);
    assert_int_equal(overlap_graph_build(&env, &s, &p, &g, NULL), STP_OK);
    unsigned long allocations = mem_count(), refused = 0;
    overlap_graph_release(&g);
    for (unsigned long n = 1; n <= allocations; n++) {
        g.count = 7;
        lines = 0;
        mem_fail_at(n);
        enum stp_result result = overlap_graph_build(&env, &s, &p, &g, NULL);
        mem_fail_at(0);
        assert_int_equal(lines, result == STP_OK ? 0 : 1);
        if (result == STP_OK) { /* giving memory back may fail unseen */
            overlap_graph_release(&g);
            continue;
        }
        refused++;
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_int_equal(g.count, 7);
        assert_null(g.end);
    }
    assert_true(refused >= 8);
    cloud_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equals_every_pair),
        cmocka_unit_test(every_small_count),
        cmocka_unit_test(skipped_splats_have_no_edges),
        cmocka_unit_test(skipped_across_pools),
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(the_limit_is_open),
        cmocka_unit_test(opposed_by_sign),
        cmocka_unit_test(coplanar_by_tolerance),
        cmocka_unit_test(coplanar_of_one_colour),
        cmocka_unit_test(overload_is_told),
        cmocka_unit_test(search_is_bounded),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
