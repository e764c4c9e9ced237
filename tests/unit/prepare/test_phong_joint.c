/* Fields of all splats together: what their mean shows follows the surface better than fields that
 * are fitted splat by splat. */
#include "fitted.h"

#define TOLERANCE 0.02

/* How far off its plane a splat still shows a point. */
#define AWAY (3 * TOLERANCE)

/* Root of the mean squared angle, degrees, between the fields' mean and the normals of points. */
static double mean_error(const struct splats *splats, const struct samples *s)
{
    double sum = 0, count = 0;
    for (size_t i = 0; i < s->count; i++) {
        double angle = angle_of_mean(splats, s, i, AWAY);
        sum += isnan(angle) ? 0 : angle * angle;
        count += !isnan(angle);
    }
    return sqrt(sum / count);
}

/* The least-squares line z = solution[0] + solution[1] x. */
static void fit_line(const double (*row)[3], size_t count, double solution[2])
{
    double m[5] = { 0 };
    for (size_t i = 0; i < count; i++) {
        double w = row[i][2], x = row[i][0], z = row[i][1];
        m[0] += w;
        m[1] += w * x;
        m[2] += w * x * x;
        m[3] += w * z;
        m[4] += w * x * z;
    }
    double det = m[0] * m[2] - m[1] * m[1];
    solution[1] = (m[0] * m[4] - m[1] * m[3]) / det;
    solution[0] = (m[3] - solution[1] * m[1]) / m[0];
}

/* Eq. 3 and 4 of one splat, over all samples that it shows. */
static void fit_alone(struct splats *splats, size_t i, const struct samples *s)
{
    double(*row[2])[3] = { calloc(s->count, sizeof *row[0]), calloc(s->count, sizeof *row[1]) };
    double u[3], n[3], solution[2];
    size_t count = 0;
    for (int k = 0; k < 3; k++) {
        u[k] = (double)splats->phong[i].u[k];
        n[k] = (double)splats->normal[i][k];
    }
    double v[3] = { n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2],
                    n[0] * u[1] - n[1] * u[0] };
    for (size_t k = 0; k < s->count; k++) {
        struct at_splat at = locate(splats, i, s->position[k]);
        double m[3] = { (double)s->normal[k][0], (double)s->normal[k][1], (double)s->normal[k][2] };
        double z = dot3(m, n);
        if (!shows(&at, m, AWAY) || z < 0.1)
            continue;
        double weight = z * z * z * z;
        memcpy(row[0][count], (double[3]){ at.s, dot3(m, u) / z, weight }, sizeof row[0][0]);
        memcpy(row[1][count++], (double[3]){ at.t, dot3(m, v) / z, weight }, sizeof row[1][0]);
    }
    for (int k = 0; k < 2 && count > 5; k++) {
        fit_line((const double(*)[3])row[k], count, solution);
        splats->phong[i].field[2 * k] = (float)solution[0];
        splats->phong[i].field[2 * k + 1] = (float)solution[1];
    }
    free(row[0]);
    free(row[1]);
}

static void mean_follows_the_surface(void **state)
{
    const surface_fn surface[] = { on_torus, on_sphere };
    for (int i = 0; i < 2; i++) {
        struct samples s = sample_surface(surface[i], 5000, 13),
                       probes = sample_surface(surface[i], 2000, 14);
        struct stp_scene *scene = fitted(&s, TOLERANCE, NULL);
        double together[2] = { mean_error(&scene->splats, &s),
                               mean_error(&scene->splats, &probes) };
        for (size_t k = 0; k < scene->splats.count; k++)
            fit_alone(&scene->splats, k, &s);
        assert_true(together[0] < 0.8 * mean_error(&scene->splats, &s));
        assert_true(together[1] < 0.8 * mean_error(&scene->splats, &probes));
        stp_scene_destroy(&scene);
        samples_release(&s);
        samples_release(&probes);
    }
}

/* `alone` leaves every field as its own members have it: the same splats, a worse mean. */
static void alone_is_worse(void **state)
{
    struct samples s = sample_surface(on_torus, 5000, 15);
    double error[2][2];
    size_t count[2][2];
    for (int flat = 0; flat < 2; flat++)
        for (int alone = 0; alone < 2; alone++) {
            struct stp_fit_params params = { .tolerance = TOLERANCE,
                                             .flat = flat == 1,
                                             .alone = alone == 1 };
            struct stp_scene *scene = fitted_by(NULL, &s, &params, NULL);
            count[flat][alone] = scene->splats.count;
            error[flat][alone] = mean_error(&scene->splats, &s);
            for (size_t i = 0; flat && i < scene->splats.count; i++)
                assert_true(scene->splats.phong[i].field[1] == 0 &&
                            scene->splats.phong[i].field[3] == 0);
            stp_scene_destroy(&scene);
        }
    assert_int_equal(count[0][0], count[0][1]);
    assert_int_equal(count[0][0], count[1][1]);
    assert_true(error[0][0] < 0.9 * error[0][1] && error[0][0] < 1.05);
    assert_true(error[1][0] < 0.95 * error[1][1]);
    assert_true(error[0][1] < error[1][0]);
    samples_release(&s);
}

/* A lone splat has nobody to share with: its field is that of Eq. 3 and 4. */
static void alone_it_is_the_paper(void **state)
{
    struct samples s = { 20, calloc(20, sizeof(double[3])), calloc(20, sizeof(float[3])) };
    uint64_t dice = 5;
    for (size_t i = 0; i < s.count; i++) {
        double r = 0.5 * sqrt(random_unit(&dice)), angle = 2 * PI * random_unit(&dice);
        double x = r * cos(angle), y = r * sin(angle);
        double n[3] = { 0.3 * x * x * x - 0.1 * x, 0.05 - 0.15 * y, 1 };
        memcpy(s.position[i], (double[3]){ x, y, 0 }, sizeof s.position[i]);
        for (int k = 0; k < 3; k++)
            s.normal[i][k] = (float)(n[k] / sqrt(dot3(n, n)));
    }
    struct stp_scene *scene = fitted(&s, TOLERANCE, NULL);
    assert_int_equal(scene->splats.count, 1);
    struct stp_phong_splat found = scene->splats.phong[0];
    fit_alone(&scene->splats, 0, &s);
    for (int k = 0; k < 4; k++)
        assert_float_equal(found.field[k], scene->splats.phong[0].field[k], 1e-5);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mean_follows_the_surface),
        cmocka_unit_test(alone_is_worse),
        cmocka_unit_test(alone_it_is_the_paper),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
