/* Largest-First colouring against the algorithm as the paper words it. */
#include "base/memory.h"
#include "overlap_clouds.h"
#include "prepare/prepare.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

/* A graph from an adjacency matrix; small enough for one pool. */
static struct overlap_graph graph_of(const bool *joined, size_t n)
{
    struct overlap_graph g = { .count = n, .nodes = n };
    uint32_t e = 0;
    assert_true(n <= OVERLAP_POOL);
    g.end = mem_alloc(n, sizeof *g.end);
    g.pool = mem_alloc(1, sizeof *g.pool);
    g.pool[0] = n ? mem_alloc(n * n, sizeof **g.pool) : NULL;
    for (size_t i = 0; i < n; i++) {
        uint32_t first = e;
        for (size_t j = 0; j < n; j++)
            if (i != j && joined[i * n + j])
                g.pool[0][e++] = (uint32_t)j;
        g.end[i] = e;
        if (e - first > g.max_degree)
            g.max_degree = e - first;
    }
    g.edges = e / 2;
    return g;
}

static unsigned degree_of(const bool *joined, size_t n, size_t i)
{
    unsigned degree = 0;
    for (size_t j = 0; j < n; j++)
        degree += i != j && joined[i * n + j];
    return degree;
}

/* The uncoloured node of the largest degree, the first of those. */
static size_t next_node(const bool *joined, size_t n, const int *color)
{
    size_t best = n;
    unsigned most = 0;
    for (size_t i = 0; i < n; i++)
        if (color[i] < 0 && (best == n || degree_of(joined, n, i) > most)) {
            best = i;
            most = degree_of(joined, n, i);
        }
    return best;
}

static int smallest_free(const bool *joined, size_t n, const int *color, size_t i, int max,
                         size_t *conflicts)
{
    size_t held[STP_MAX_GROUPS] = { 0 };
    int best = 0;
    for (size_t j = 0; j < n; j++)
        if (i != j && joined[i * n + j] && color[j] >= 0)
            held[color[j]]++;
    for (int c = 1; c < max; c++)
        if (held[c] < held[best])
            best = c;
    *conflicts += held[best] > 0;
    return best; /* a colour that nobody holds is held least, and the lowest wins */
}

static void check_matrix(const bool *joined, size_t n, unsigned max)
{
    struct overlap_graph g = graph_of(joined, n);
    uint8_t *color = malloc(n + 1);
    int *expected = malloc((n + 1) * sizeof *expected);
    unsigned count = 99, needed = 0;
    size_t conflicts = 99, expected_conflicts = 0;
    assert_int_equal(largest_first_color(NULL, &g, max, color, &count, &conflicts), STP_OK);
    for (size_t i = 0; i < n; i++)
        expected[i] = -1;
    for (size_t k = 0; k < n; k++) {
        size_t i = next_node(joined, n, expected);
        expected[i] = smallest_free(joined, n, expected, i, (int)max, &expected_conflicts);
        needed = (unsigned)expected[i] >= needed ? (unsigned)expected[i] + 1 : needed;
    }
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(color[i], expected[i]);
        for (size_t j = 0; conflicts == 0 && j < n; j++)
            assert_true(i == j || !joined[i * n + j] || color[i] != color[j]);
    }
    assert_int_equal(count, needed);
    assert_int_equal(conflicts, expected_conflicts);
    assert_true(n == 0 || conflicts || count <= g.max_degree + 1);
    overlap_graph_release(&g);
    free(color);
    free(expected);
}

static void join(bool *joined, size_t n, size_t i, size_t j)
{
    joined[i * n + j] = joined[j * n + i] = i != j;
}

static void random_graphs(void **state)
{
    struct dice d = { 4711 };
    for (unsigned round = 0; round < 60; round++) {
        size_t n = 1 + roll(&d) % 160;
        double density = uniform(&d) * uniform(&d);
        bool *joined = calloc(n * n, 1);
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < i; j++)
                if (uniform(&d) < density)
                    join(joined, n, i, j);
        check_matrix(joined, n, STP_MAX_GROUPS);
        check_matrix(joined, n, 1 + roll(&d) % 8);
        free(joined);
    }
}

static void complete(size_t n, unsigned expected, size_t expected_conflicts)
{
    bool *joined = calloc(n * n, sizeof *joined);
    for (size_t i = 0; i < n * n; i++)
        joined[i] = true;
    struct overlap_graph g = graph_of(joined, n);
    uint8_t *color = malloc(n);
    unsigned count;
    size_t conflicts;
    assert_int_equal(largest_first_color(NULL, &g, STP_MAX_GROUPS, color, &count, &conflicts), 0);
    assert_int_equal(count, expected);
    assert_int_equal(conflicts, expected_conflicts);
    check_matrix(joined, n, STP_MAX_GROUPS);
    overlap_graph_release(&g);
    free(color);
    free(joined);
}

static void complete_graphs(void **state)
{
    complete(2, 2, 0);
    complete(63, 63, 0);
    complete(64, 64, 0);
    complete(65, 64, 1);
    complete(150, 64, 86);
}

static void stars_paths_and_nothing(void **state)
{
    enum { N = 50 };
    bool *joined = calloc(N * N, 1);
    check_matrix(joined, N, STP_MAX_GROUPS);
    check_matrix(joined, 0, STP_MAX_GROUPS);
    check_matrix(joined, 1, STP_MAX_GROUPS);
    for (size_t i = 0; i + 1 < N; i++)
        join(joined, N, i, i + 1);
    check_matrix(joined, N, STP_MAX_GROUPS);
    for (size_t i = 0; i < N; i++)
        join(joined, N, 17, i);
    check_matrix(joined, N, STP_MAX_GROUPS);
    free(joined);
}

/* On a real overlap graph, larger than the matrices above. */
static void no_edge_within_a_colour(void **state)
{
    struct splats s = cloud_random(CLOUD_RADII, 20000, 2);
    struct overlap_params p = { 0.8, STP_RELAX_OPPOSED, NULL, 0 };
    struct overlap_graph g = { 0 };
    uint8_t *color = malloc(s.count);
    unsigned count;
    size_t conflicts;
    assert_int_equal(overlap_graph_build(NULL, &s, &p, &g, NULL), STP_OK);
    assert_int_equal(largest_first_color(NULL, &g, STP_MAX_GROUPS, color, &count, &conflicts), 0);
    assert_int_equal(conflicts, 0);
    assert_in_range(count, 3, g.max_degree + 1);
    for (size_t i = 0; i < s.count; i++) {
        struct overlap_row row = overlap_row(&g, i);
        for (size_t e = 0; e < row.degree; e++)
            assert_int_not_equal(color[i], color[row.neighbour[e]]);
    }
    overlap_graph_release(&g);
    free(color);
    cloud_free(&s);
}

static void count_lines(void *user, enum stp_log_level level, const char *line)
{
    assert_non_null(line);
    ++*(unsigned *)user;
}

static void every_allocation_may_fail(void **state)
{
    bool joined[4] = { false, true, true, false };
    struct overlap_graph g = graph_of(joined, 2);
    unsigned lines = 0, count = 77, n = 0;
    struct stp_env env = { .log = count_lines, .user = &lines };
    size_t conflicts = 78;
    uint8_t color[2] = { 9, 9 };
    enum stp_result result = STP_ERROR_MEMORY;
    while (result != STP_OK) {
        mem_fail_at(++n);
        result = largest_first_color(&env, &g, 64, color, &count, &conflicts);
        mem_fail_at(0);
        assert_int_equal(lines, result == STP_OK ? n - 1 : n);
        if (result != STP_OK) {
            assert_int_equal(result, STP_ERROR_MEMORY);
            assert_true(count == 77 && conflicts == 78 && color[0] == 9);
        }
    }
    assert_int_equal(n, 3);
    overlap_graph_release(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_graphs),
        cmocka_unit_test(complete_graphs),
        cmocka_unit_test(stars_paths_and_nothing),
        cmocka_unit_test(no_edge_within_a_colour),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
