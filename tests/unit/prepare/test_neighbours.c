#include "clouds.h"

#include "base/memory.h"
#include "prepare/eigen.h"
#include "prepare/neighbours.h"
#include "prepare/surroundings.h"

struct candidate {
    double distance;
    uint32_t id;
};

static int nearer(const void *a, const void *b)
{
    const struct candidate *x = a, *y = b;
    if (x->distance != y->distance)
        return x->distance < y->distance ? -1 : 1;
    return x->id < y->id ? -1 : x->id > y->id;
}

static void brute_force(const double (*p)[3], size_t count, size_t i, struct candidate *all)
{
    size_t n = 0;
    for (size_t j = 0; j < count; j++) {
        double x = p[j][0] - p[i][0], y = p[j][1] - p[i][1], z = p[j][2] - p[i][2];
        if (j != i)
            all[n++] = (struct candidate){ x * x + y * y + z * z, (uint32_t)j };
    }
    qsort(all, n, sizeof *all, nearer);
}

static void check(const double (*p)[3], size_t count, unsigned k, size_t step)
{
    struct neighbour_tree tree;
    struct neighbours found;
    struct candidate *all = calloc(count, sizeof *all);
    assert_int_equal(neighbour_tree_build(NULL, p, count, &tree), STP_OK);
    for (size_t i = 0; i < count; i += step) {
        brute_force(p, count, i, all);
        neighbours_of(&tree, i, k, &found);
        assert_int_equal(found.count, count - 1 < k ? count - 1 : k);
        for (unsigned j = 0; j < found.count; j++) {
            assert_int_equal(found.id[j], all[j].id);
            assert_true(found.distance[j] == all[j].distance);
        }
    }
    neighbour_tree_release(&tree);
    free(all);
}

static void random_points(void **state)
{
    uint64_t seed = 5;
    static double p[3000][3];
    for (size_t i = 0; i < 3000; i++)
        for (int axis = 0; axis < 3; axis++)
            p[i][axis] = 6e6 + random_unit(&seed);
    check((const double(*)[3])p, 3000, 12, 7);
    check((const double(*)[3])p, 3000, 64, 97);
    for (size_t count = 1; count < 80; count++)
        check((const double(*)[3])p, count, 8, 1);
}

/* Every distance is tied many times over: ids decide. */
static void grid_points(void **state)
{
    static double p[12 * 12 * 12][3];
    for (int i = 0; i < 12 * 12 * 12; i++) {
        p[i][0] = i % 12;
        p[i][1] = i / 12 % 12;
        p[i][2] = i / 144;
    }
    check((const double(*)[3])p, 12 * 12 * 12, 12, 5);
}

static void coincident_and_far_points(void **state)
{
    static double p[700][3];
    for (int i = 0; i < 700; i++)
        p[i][0] = i == 699 ? 1e17 : i < 350 ? 1 : -1;
    check((const double(*)[3])p, 700, 16, 3);
}

static void build_survives_no_memory(void **state)
{
    static double p[1000][3];
    struct stp_env env = { .log = silent };
    for (unsigned long n = 1;; n++) {
        struct neighbour_tree tree;
        mem_fail_at(n);
        enum stp_result result = neighbour_tree_build(&env, (const double(*)[3])p, 1000, &tree);
        mem_fail_at(0);
        if (result == STP_OK) {
            neighbour_tree_release(&tree);
            assert_true(n > 2);
            return;
        }
        assert_int_equal(result, STP_ERROR_MEMORY);
    }
}

/* A v = lambda v, and orthonormal vectors, for random matrices of every rank. */
static void eigenvectors(void **state)
{
    uint64_t seed = 9;
    for (int round = 0; round < 2000; round++) {
        double a[6] = { 0 }, value[3], v[3][3];
        for (int rank = 0; rank < round % 4; rank++) {
            double x = random_unit(&seed) - 0.5, y = random_unit(&seed) - 0.5,
                   z = random_unit(&seed) - 0.5;
            double outer[6] = { x * x, x * y, x * z, y * y, y * z, z * z };
            for (int i = 0; i < 6; i++)
                a[i] += outer[i];
        }
        eigen_symmetric(a, value, v);
        double m[3][3] = { { a[0], a[1], a[2] }, { a[1], a[3], a[4] }, { a[2], a[4], a[5] } };
        assert_true(value[0] <= value[1] && value[1] <= value[2]);
        for (int i = 0; i < 3; i++)
            for (int r = 0; r < 3; r++) {
                double av = m[r][0] * v[i][0] + m[r][1] * v[i][1] + m[r][2] * v[i][2];
                double dot = v[i][0] * v[r][0] + v[i][1] * v[r][1] + v[i][2] * v[r][2];
                assert_true(fabs(av - value[i] * v[i][r]) < 1e-14);
                assert_true(fabs(dot - (i == r)) < 1e-14);
            }
    }
}

/* A scanner's lines: 0.1 along, 1 across. The spacing must reach the next line. */
static void scan_lines(void **state)
{
    static double p[40 * 400][3];
    struct neighbour_tree tree;
    struct surrounding s;
    for (int i = 0; i < 40 * 400; i++) {
        p[i][0] = 0.1 * (i % 400);
        p[i][1] = i / 400;
    }
    assert_int_equal(neighbour_tree_build(NULL, (const double(*)[3])p, 40 * 400, &tree), STP_OK);
    surrounding_of(&tree, 20 * 400 + 200, &s);
    assert_true(s.spacing >= 1 && s.spacing < 1.3);
    assert_true(fabs(s.normal[2]) > 0.999999);
    neighbour_tree_release(&tree);
}

/* A wire of 60 points high above the ground: its discs do not reach down. */
static void wire(void **state)
{
    static double p[60 + 900][3];
    struct neighbour_tree tree;
    struct surrounding s;
    for (int i = 0; i < 60 + 900; i++) {
        p[i][0] = i < 60 ? 0.1 * i : (i - 60) % 30;
        p[i][1] = i < 60 ? 0 : (i - 60) / 30;
        p[i][2] = i < 60 ? 10 : 0;
    }
    assert_int_equal(neighbour_tree_build(NULL, (const double(*)[3])p, 60 + 900, &tree), STP_OK);
    surrounding_of(&tree, 30, &s);
    assert_true(s.spacing < 0.5);
    neighbour_tree_release(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_points),
        cmocka_unit_test(grid_points),
        cmocka_unit_test(coincident_and_far_points),
        cmocka_unit_test(build_survives_no_memory),
        cmocka_unit_test(eigenvectors),
        cmocka_unit_test(scan_lines),
        cmocka_unit_test(wire),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
