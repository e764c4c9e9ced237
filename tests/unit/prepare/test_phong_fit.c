/* Points to few elliptical splats: that they cover what they must, and carry the surface's normals.
 */
#include "fitted.h"

#include "base/memory.h"

/* A cone of 45 degrees without its tip, even in area. */
static void on_cone(double u, double v, double p[3], double n[3])
{
    double r = sqrt(0.04 + 0.96 * u), side = sqrt(0.5);
    p[0] = r * cos(2 * PI * v);
    p[1] = r * sin(2 * PI * v);
    p[2] = 1 - r;
    n[0] = side * cos(2 * PI * v);
    n[1] = side * sin(2 * PI * v);
    n[2] = side;
}

static void covers_every_sample(void **state)
{
    const surface_fn surface[] = { on_sphere, on_torus, on_plane, on_sheets, on_cone };
    const double tolerance[] = { 1e-4, 3e-3, 5e-2, 10 };
    for (unsigned i = 0; i < 5; i++) {
        struct samples s = sample_surface(surface[i], 3000, 11 + i);
        for (unsigned k = 0; k < 4; k++) {
            struct stp_fit fit;
            struct stp_scene *scene = fitted(&s, tolerance[k], &fit);
            covers_all(&scene->splats, &s, tolerance[k], false);
            assert_true(fit.deviation <= tolerance[k]);
            assert_int_equal(fit.splats, scene->splats.count);
            assert_int_equal(stp_scene_facts(scene)->splats, scene->splats.count);
            assert_true(fit.splats < 3000 && (k == 0 || fit.splats < 800));
            stp_scene_destroy(&scene);
        }
        samples_release(&s);
    }
}

/* Points anywhere in a cube, with normals anywhere: nothing to fit, and nothing may be lost. */
static void covers_noise(void **state)
{
    struct samples s = sample_surface(on_sphere, 1500, 3);
    uint64_t seed = 8;
    for (size_t i = 0; i < s.count; i++)
        for (int axis = 0; axis < 3; axis++)
            s.position[i][axis] = random_unit(&seed);
    for (double tolerance = 1e-3; tolerance < 5; tolerance *= 10) {
        struct stp_scene *scene = fitted(&s, tolerance, NULL);
        covers_all(&scene->splats, &s, tolerance, true);
        for (size_t i = 0; i < scene->splats.count; i++)
            for (int k = 0; k < 4; k++)
                assert_true(isfinite(scene->splats.phong[i].field[k]));
        stp_scene_destroy(&scene);
    }
    samples_release(&s);
}

static void tolerance_of_nothing_and_all(void **state)
{
    struct samples s = sample_surface(on_sphere, 2000, 5);
    struct stp_fit fit;
    struct stp_scene *scene = fitted(&s, 0, &fit);
    assert_int_equal(fit.splats, 2000);
    assert_int_equal(fit.single, 2000);
    assert_true(fit.deviation == 0);
    covers_all(&scene->splats, &s, 0, false);
    stp_scene_destroy(&scene);
    scene = fitted(&s, 4, &fit); /* the sphere's size is 2: one splat a side would do */
    assert_true(fit.splats >= 2 && fit.splats <= 24);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

/* The surface between the samples is covered too: random points of a torus, which are no samples.
 */
static void leaves_no_gaps(void **state)
{
    struct samples s = sample_surface(on_torus, 6000, 21),
                   probes = sample_surface(on_torus, 4000, 77);
    for (double tolerance = 1e-3; tolerance < 0.05; tolerance *= 5) {
        struct stp_scene *scene = fitted(&s, tolerance, NULL);
        size_t holes = 0;
        for (size_t i = 0; i < probes.count; i++) {
            bool found = false;
            for (size_t j = 0; j < scene->splats.count && !found; j++) {
                struct at_splat at = locate(&scene->splats, j, probes.position[i]);
                found =
                    at.covered && fabs(at.height) <= tolerance + 0.005; /* sagitta of a spacing */
            }
            holes += !found;
        }
        assert_true(holes <= 24); /* 0.6 %: 4.6 samples a splat at first */
        stp_scene_destroy(&scene);
    }
    samples_release(&s);
    samples_release(&probes);
}

/* Mean angle, in degrees, between the samples' normals and the mean of the fields of the splats
 * that cover them. */
static double normal_error(const struct splats *splats, const struct samples *s)
{
    double sum = 0, count = 0;
    for (size_t i = 0; i < s->count; i++) {
        double mean[3] = { 0 },
               n[3] = { (double)s->normal[i][0], (double)s->normal[i][1], (double)s->normal[i][2] };
        for (size_t j = 0; j < splats->count; j++) {
            struct at_splat at = locate(splats, j, s->position[i]);
            double weight = 1 - at.s * at.s - at.t * at.t;
            bool shown = at.covered && fabs(at.height) <= 0.05 && dot3(at.normal, n) > 0;
            for (int k = 0; shown && k < 3; k++)
                mean[k] += weight * at.normal[k];
        }
        double length = sqrt(dot3(mean, mean));
        if (!(length > 0))
            continue;
        sum += acos(fmin(dot3(mean, n) / length, 1)) * 180 / PI;
        count += 1;
    }
    return sum / count;
}

/* Linear fields against analytic normals: a flat splat of the same fit errs many times more. */
static void fields_follow_the_surface(void **state)
{
    const surface_fn surface[] = { on_sphere, on_torus, on_cone };
    const double most[] = { 0.02, 0.4, 0.3 }; /* degrees */
    for (int i = 0; i < 3; i++) {
        struct samples s = sample_surface(surface[i], 4000, 31);
        struct stp_points points = { .count = s.count,
                                     .position = (const double(*)[3])s.position,
                                     .normal = (const float(*)[3])s.normal };
        double error[2];
        for (int flat = 0; flat < 2; flat++) {
            struct stp_fit_params params = { .tolerance = 0.004, .flat = flat == 1 };
            struct stp_scene *scene = scene_of(NULL, &points);
            assert_int_equal(stp_scene_fit(NULL, scene, &params, NULL), STP_OK);
            error[flat] = normal_error(&scene->splats, &s);
            stp_scene_destroy(&scene);
        }
        assert_true(error[0] < most[i]);
        assert_true(error[1] > 5 * error[0]);
        samples_release(&s);
    }
}

/* Normals of random sign: the splats are turned outward, all of them, and cover as before. */
static void signs_do_not_matter(void **state)
{
    struct samples s = sample_surface(on_torus, 4000, 41);
    uint64_t seed = 2;
    for (size_t i = 0; i < s.count; i++)
        for (int axis = 0, turn = random_unit(&seed) < 0.5; turn && axis < 3; axis++)
            s.normal[i][axis] = -s.normal[i][axis];
    struct stp_fit fit;
    struct stp_scene *scene = fitted(&s, 0.01, &fit);
    assert_false(fit.signs);
    assert_true(fit.splats < 500);
    covers_all(&scene->splats, &s, 0.01, true);
    for (size_t i = 0; i < scene->splats.count; i++) {
        const double *p = scene->splats.position[i];
        double ring = hypot(p[0], p[1]),
               out[3] = { p[0] * (1 - 1 / ring), p[1] * (1 - 1 / ring), p[2] };
        double n[3] = { (double)scene->splats.normal[i][0], (double)scene->splats.normal[i][1],
                        (double)scene->splats.normal[i][2] };
        struct at_splat at = locate(&scene->splats, i, p);
        assert_true(dot3(n, out) > 0 && dot3(at.normal, out) > 0);
    }
    stp_scene_destroy(&scene);
    samples_release(&s);
}

static void same_splats(const struct splats *a, const struct splats *b)
{
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->position, b->position, a->count * sizeof *a->position);
    assert_memory_equal(a->normal, b->normal, a->count * sizeof *a->normal);
    assert_memory_equal(a->radius, b->radius, a->count * sizeof *a->radius);
    for (size_t i = 0; i < a->count; i++)
        assert_memory_equal(&a->phong[i], &b->phong[i], offsetof(struct stp_phong_splat, reflex));
}

static void order_and_threads_do_not_show(void **state)
{
    struct samples s = sample_surface(on_torus, 3000, 51),
                   mixed = sample_surface(on_torus, 3000, 51);
    uint64_t seed = 6;
    for (size_t i = s.count; i-- > 1;) {
        size_t j = random_bits(&seed) % (i + 1);
        for (int axis = 0; axis < 3; axis++) {
            double p = mixed.position[i][axis];
            float n = mixed.normal[i][axis];
            mixed.position[i][axis] = mixed.position[j][axis];
            mixed.normal[i][axis] = mixed.normal[j][axis];
            mixed.position[j][axis] = p;
            mixed.normal[j][axis] = n;
        }
    }
    const struct samples *from[] = { &s, &s, &mixed };
    const unsigned threads[] = { 1, 7, 3 };
    struct stp_scene *scene[3];
    for (int i = 0; i < 3; i++) {
        struct stp_env env = { .threads = threads[i] };
        struct stp_points points = { .count = s.count,
                                     .position = (const double(*)[3])from[i]->position,
                                     .normal = (const float(*)[3])from[i]->normal };
        struct stp_fit_params params = { .tolerance = 2e-3 };
        scene[i] = scene_of(&env, &points);
        assert_int_equal(stp_scene_fit(&env, scene[i], &params, NULL), STP_OK);
        same_splats(&scene[0]->splats, &scene[i]->splats);
    }
    for (int i = 0; i < 3; i++)
        stp_scene_destroy(&scene[i]);
    samples_release(&s);
    samples_release(&mixed);
}

static void count_is_not_exceeded(void **state)
{
    struct samples s = sample_surface(on_torus, 5000, 61);
    struct stp_points points = { .count = s.count,
                                 .position = (const double(*)[3])s.position,
                                 .normal = (const float(*)[3])s.normal };
    const size_t count[] = { 40, 200, 1000, 4000, 5000, 9000 };
    for (int i = 0; i < 6; i++) {
        struct stp_fit_params params = { .count = count[i] };
        struct stp_fit fit;
        struct stp_scene *scene = scene_of(NULL, &points);
        assert_int_equal(stp_scene_fit(NULL, scene, &params, &fit), STP_OK);
        assert_true(fit.splats <= count[i]);
        assert_true((double)fit.splats >= 0.9 * fmin((double)count[i], 5000));
        covers_all(&scene->splats, &s, fit.tolerance, false);
        stp_scene_destroy(&scene);
    }
    samples_release(&s);
}

struct bar {
    unsigned calls;
    double last;
};

static void on_progress(void *user, const char *stage, double fraction)
{
    struct bar *bar = user;
    if (strcmp(stage, "fit") != 0)
        return;
    assert_true(fraction >= bar->last && fraction <= 1);
    bar->last = fraction;
    bar->calls++;
}

/* However many tolerances a count takes, its progress never falls back, and ends at 1. */
static void progress_only_grows(void **state)
{
    struct samples s = sample_surface(on_torus, 5000, 67);
    struct stp_points points = { .count = s.count,
                                 .position = (const double(*)[3])s.position,
                                 .normal = (const float(*)[3])s.normal };
    const struct stp_fit_params params[] = { { .count = 100 },
                                             { .count = 999 },
                                             { .tolerance = 0.01 } };
    for (int i = 0; i < 3; i++) {
        struct bar bar = { 0 };
        struct stp_env env = { .progress = on_progress, .user = &bar };
        struct stp_scene *scene = scene_of(NULL, &points);
        assert_int_equal(stp_scene_fit(&env, scene, &params[i], NULL), STP_OK);
        assert_true(bar.calls > 5 && bar.last == 1);
        stp_scene_destroy(&scene);
    }
    samples_release(&s);
}

static void refuses(void **state)
{
    char line[256] = "";
    struct stp_env env = { .log = silent, .user = line };
    struct samples s = sample_surface(on_sphere, 400, 1);
    struct stp_points points = { .count = s.count, .position = (const double(*)[3])s.position };
    struct stp_fit_params good = { .tolerance = 0.01 }, bad[] = { { .tolerance = -1 },
                                                                  { .tolerance = NAN },
                                                                  { .tolerance = INFINITY },
                                                                  { .count = 1, .color = NAN },
                                                                  { .count = 1 } };
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(&env, &scene), STP_OK);
    assert_int_equal(stp_scene_fit(&env, scene, &good, NULL), STP_ERROR_ARGUMENT);
    stp_scene_destroy(&scene);
    scene = scene_of(&env, &points);
    for (unsigned i = 0; i < sizeof bad / sizeof *bad; i++) {
        line[0] = 0;
        assert_int_equal(stp_scene_fit(&env, scene, &bad[i], NULL), STP_ERROR_ARGUMENT);
        assert_true(strlen(line) > 0);
        assert_int_equal(scene->splats.count, 400);
    }
    assert_int_equal(stp_scene_fit(&env, scene, &good, NULL), STP_OK);
    assert_int_equal(stp_scene_fit(&env, scene, &good, NULL), STP_ERROR_ARGUMENT);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

/* Every allocation fails in turn: the scene stays as it was, and one line says so. */
static void survives_every_failure(void **state)
{
    struct samples s = sample_surface(on_torus, 300, 71);
    uint64_t seed = 2;
    for (size_t i = 0; i < s.count; i++)
        for (int axis = 0, turn = random_unit(&seed) < 0.5; turn && axis < 3; axis++)
            s.normal[i][axis] = -s.normal[i][axis];
    char line[256];
    struct stp_env env = { .threads = 1, .log = silent, .user = line };
    struct stp_points points = { .count = s.count,
                                 .position = (const double(*)[3])s.position,
                                 .normal = (const float(*)[3])s.normal };
    struct stp_fit_params params = { .tolerance = 0.1 };
    struct stp_scene *scene = scene_of(NULL, &points);
    enum stp_result result = STP_ERROR_MEMORY;
    unsigned long n = 1;
    for (; result != STP_OK; n++) {
        line[0] = 0;
        mem_fail_at(n);
        result = stp_scene_fit(&env, scene, &params, NULL);
        mem_fail_at(0);
        if (result == STP_OK)
            break;
        assert_int_equal(result, STP_ERROR_MEMORY);
        assert_true(strlen(line) > 0);
        assert_int_equal(scene->splats.count, 300);
        assert_null(scene->splats.phong);
    }
    assert_true(n > 50);
    assert_non_null(scene->splats.phong);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(covers_every_sample),           cmocka_unit_test(covers_noise),
        cmocka_unit_test(tolerance_of_nothing_and_all),  cmocka_unit_test(leaves_no_gaps),
        cmocka_unit_test(fields_follow_the_surface),     cmocka_unit_test(signs_do_not_matter),
        cmocka_unit_test(order_and_threads_do_not_show), cmocka_unit_test(count_is_not_exceeded),
        cmocka_unit_test(progress_only_grows),           cmocka_unit_test(refuses),
        cmocka_unit_test(survives_every_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
