/* The minimum enclosing ellipse and the linear normal field, each against what is known of it. */
#include "clouds.h"

#include "prepare/phong_ellipse.h"
#include "prepare/phong_field.h"

static double area(const double radius[2])
{
    return PI * radius[0] * radius[1];
}

/* The area of the ellipse with this middle and ratio that holds all points. */
static double holding_area(const double (*p)[2], size_t count, const double v[3])
{
    double most = 0, ratio = exp(v[2]);
    for (size_t k = 0; k < count; k++) {
        double s = (p[k][0] - v[0]) / ratio, t = (p[k][1] - v[1]) * ratio;
        most = fmax(most, s * s + t * t);
    }
    return PI * most;
}

/* The area is a convex problem's optimum: where no small step of middle or ratio lessens it, it is
 * the least. */
static void is_least(const double (*p)[2], size_t count, const double c[2], const double r[2],
                     uint64_t seed)
{
    double found = area(r), scale = fmax(r[0], r[1]), extent[3] = { r[0], r[1], 1 };
    for (size_t k = 0; k < count; k++) {
        double s = (p[k][0] - c[0]) / r[0], t = (p[k][1] - c[1]) / r[1];
        assert_true(s * s + t * t <= 1);
    }
    assert_true(scale > 0);
    for (int i = 0; i < 4000; i++) {
        double step = pow(10, -5 * random_unit(&seed));
        double v[3] = { c[0], c[1], 0.5 * log(r[0] / r[1]) };
        for (int j = 0; j < 3; j++)
            v[j] += step * extent[j] * (2 * random_unit(&seed) - 1);
        assert_true(holding_area(p, count, v) >= found * (1 - 2 * ELLIPSE_TOLERANCE));
    }
}

static void random_points(void **state)
{
    uint64_t seed = 1;
    for (int round = 0; round < 60; round++) {
        double p[200][2], c[2], r[2], stretch = exp(12 * random_unit(&seed) - 6);
        size_t count = 2 + random_bits(&seed) % 199;
        for (size_t k = 0; k < count; k++) {
            p[k][0] = 1e3 + stretch * random_unit(&seed);
            p[k][1] = random_unit(&seed) * (round % 2 ? random_unit(&seed) : 1);
        }
        ellipse_enclose((const double(*)[2])p, count, 1e-9, c, r);
        is_least((const double(*)[2])p, count, c, r, seed);
    }
}

/* Many points that all touch. */
static void points_on_an_ellipse(void **state)
{
    enum { COUNT = 5000 };
    static double p[COUNT][2];
    double c[2], r[2];
    for (int k = 0; k < COUNT; k++) {
        p[k][0] = 3 + 5 * cos(2 * PI * k / COUNT);
        p[k][1] = -2 + 0.25 * sin(2 * PI * k / COUNT);
    }
    ellipse_enclose((const double(*)[2])p, COUNT, 1e-9, c, r);
    assert_float_equal(c[0], 3, 1e-3);
    assert_float_equal(c[1], -2, 1e-4);
    assert_true(area(r) <= PI * 5 * 0.25 * (1 + ELLIPSE_TOLERANCE));
    is_least((const double(*)[2])p, COUNT, c, r, 9);
}

static void known_ellipses(void **state)
{
    double corners[4][2] = { { -3, -1 }, { 3, -1 }, { 3, 1 }, { -3, 1 } }, c[2], r[2];
    ellipse_enclose((const double(*)[2])corners, 4, 1e-9, c, r);
    assert_float_equal(r[0], 3 * sqrt(2), 1e-5);
    assert_float_equal(r[1], sqrt(2), 1e-5);
    double two[2][2] = { { 0, 0 }, { 4, 2 } }; /* a diagonal: the rectangle's, too */
    ellipse_enclose((const double(*)[2])two, 2, 1e-9, c, r);
    assert_float_equal(r[0], 2 * sqrt(2), 1e-5);
    assert_float_equal(r[1], sqrt(2), 1e-5);
    assert_float_equal(c[0], 2, 1e-5);
}

/* One point, coincident points, and points on a line along an axis have no least ellipse but for
 * the floor. */
static void flat_sets(void **state)
{
    double p[20][2], c[2], r[2];
    for (int k = 0; k < 20; k++) {
        p[k][0] = 7 + k;
        p[k][1] = 5;
    }
    ellipse_enclose((const double(*)[2])p, 1, 0.5, c, r);
    assert_true(r[0] >= 0.5 && r[0] < 0.501 && r[1] >= 0.5 && r[1] < 0.501);
    assert_float_equal(c[0], 7, 1e-6);
    ellipse_enclose((const double(*)[2])p, 20, 0.125, c, r);
    assert_true(r[0] >= 9.5 && r[0] < 9.51 && r[1] >= 0.125 && r[1] < 0.126);
    for (int k = 0; k < 20; k++)
        p[k][0] = -1e6;
    ellipse_enclose((const double(*)[2])p, 20, 1e-3, c, r);
    assert_float_equal(c[0], -1e6, 1e-6);
    assert_true(r[0] < 2e-3 && r[1] < 2e-3);
}

/* Eq. 3 and 4. */
static void recovers_a_linear_field(void **state)
{
    uint64_t seed = 3;
    for (int round = 0; round < 100; round++) {
        struct field_sample p[50];
        double f[4], truth[4];
        size_t count = 3 + random_bits(&seed) % 48;
        for (int i = 0; i < 4; i++)
            truth[i] = 2 * random_unit(&seed) - 1;
        for (size_t k = 0; k < count; k++) {
            double s = k == 0 ? -0.7 : k == 1 ? 0.7 : 2 * random_unit(&seed) - 1;
            double t = k == 0 ? 0.6 : k == 2 ? -0.6 : 2 * random_unit(&seed) - 1;
            p[k] = (struct field_sample){ s, t, truth[0] + truth[1] * s, truth[2] + truth[3] * t,
                                          0.1 + random_unit(&seed) };
        }
        field_fit(p, count, false, f);
        for (int i = 0; i < 4; i++)
            assert_float_equal(f[i], truth[i], 1e-9);
    }
}

/* The residual is at right angles to what the field can do: the normal equations, from the samples.
 */
static void is_the_least_squares_field(void **state)
{
    uint64_t seed = 5;
    struct field_sample p[30];
    double f[4], sum[4] = { 0 };
    for (int k = 0; k < 30; k++)
        p[k] = (struct field_sample){ 2 * random_unit(&seed) - 1, 2 * random_unit(&seed) - 1,
                                      random_unit(&seed), random_unit(&seed), 1 };
    field_fit(p, 30, false, f);
    for (int k = 0; k < 30; k++) {
        double x = p[k].x - f[0] - f[1] * p[k].s, y = p[k].y - f[2] - f[3] * p[k].t;
        sum[0] += x;
        sum[1] += x * p[k].s;
        sum[2] += y;
        sum[3] += y * p[k].t;
    }
    for (int i = 0; i < 4; i++)
        assert_float_equal(sum[i], 0, 1e-12);
}

/* One sample: of all (mean, slope) with mean + slope u = z, the one of least norm is z (1, u) /
 * (1 + u^2). Samples of one u: the same with the mean of z. */
static void takes_the_least_norm(void **state)
{
    struct field_sample p[3] = { { 0.5, -0.25, 0.3, 0.7, 1 }, { 0.5, 0.25, 0.5, 0.9, 1 } };
    double f[4];
    field_fit(p, 1, false, f);
    assert_float_equal(f[0], 0.3 / 1.25, 1e-12);
    assert_float_equal(f[1], 0.5 * 0.3 / 1.25, 1e-12);
    assert_float_equal(f[2], 0.7 / 1.0625, 1e-12);
    assert_float_equal(f[3], -0.25 * 0.7 / 1.0625, 1e-12);
    field_fit(p, 2, false, f);
    assert_float_equal(f[0], 0.4 / 1.25, 1e-12);
    assert_float_equal(f[1], 0.5 * 0.4 / 1.25, 1e-12);
    assert_float_equal(f[2], 0.8, 1e-12);
    assert_float_equal(f[3], 0.4, 1e-12);
    field_fit(p, 2, true, f);
    assert_float_equal(f[0], 0.4, 1e-12);
    assert_true(f[1] == 0 && f[3] == 0);
    field_fit(p, 0, false, f);
    for (int i = 0; i < 4; i++)
        assert_true(f[i] == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_points),           cmocka_unit_test(points_on_an_ellipse),
        cmocka_unit_test(known_ellipses),          cmocka_unit_test(flat_sets),
        cmocka_unit_test(recovers_a_linear_field), cmocka_unit_test(is_the_least_squares_field),
        cmocka_unit_test(takes_the_least_norm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
