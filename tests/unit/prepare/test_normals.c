#include "clouds.h"

#include "scene/scene.h"

static struct stp_scene *prepared(const struct stp_points *points, const struct stp_env *env)
{
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(env, scene, points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(env, scene, NULL), STP_OK);
    return scene;
}

static double dot(const float a[3], const float b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

struct agreement {
    size_t same_side;
    double mean_degrees, worst_degrees;
};

static struct agreement agreement(const struct splats *s, const struct samples *truth)
{
    struct agreement a = { 0 };
    for (size_t i = 0; i < s->count; i++) {
        double d = dot(s->normal[i], truth->normal[s->input[i]]);
        double angle = acos(fmin(fabs(d), 1)) * 180 / PI;
        assert_true(fabs(dot(s->normal[i], s->normal[i]) - 1) < 1e-6);
        a.same_side += d > 0;
        a.mean_degrees += angle / (double)s->count;
        a.worst_degrees = fmax(a.worst_degrees, angle);
    }
    return a;
}

static struct agreement estimate(surface_fn surface, size_t count)
{
    struct samples truth = sample_surface(surface, count, 42);
    struct stp_points points = { .count = count, .position = (const double(*)[3])truth.position };
    struct stp_scene *scene = prepared(&points, NULL);
    const struct stp_facts *facts = stp_scene_facts(scene);
    struct agreement a = agreement(&scene->splats, &truth);
    assert_int_equal(facts->normals, STP_NORMALS_ESTIMATED);
    assert_true(facts->two_sided);
    assert_false(facts->eye_dome);
    assert_int_equal(facts->no_normal, 0);
    assert_int_equal(facts->bad_normals, 0);
    stp_scene_destroy(&scene);
    samples_release(&truth);
    return a;
}

static void sphere(void **state)
{
    struct agreement a = estimate(on_sphere, 20000);
    assert_int_equal(a.same_side, 20000);
    assert_true(a.mean_degrees < 1);
    assert_true(a.worst_degrees < 6);
}

static void torus(void **state)
{
    struct agreement a = estimate(on_torus, 20000);
    assert_int_equal(a.same_side, 20000);
    assert_true(a.mean_degrees < 2);
    assert_true(a.worst_degrees < 12);
}

/* Open and flat: every normal looks up. */
static void plane(void **state)
{
    struct agreement a = estimate(on_plane, 5000);
    assert_int_equal(a.same_side, 5000);
    assert_true(a.worst_degrees < 1e-3);
}

static void two_sheets(void **state)
{
    struct agreement a = estimate(on_sheets, 10000);
    assert_int_equal(a.same_side, 10000);
    assert_true(a.worst_degrees < 1e-3);
}

/* A tenth of the normals is damaged in every way there is. */
static void bad_ones_are_mended(void **state)
{
    const float junk[5] = { 0, NAN, INFINITY, -INFINITY, 1e-38f };
    struct samples truth = sample_surface(on_sphere, 5000, 1);
    struct samples given = sample_surface(on_sphere, 5000, 1);
    for (size_t i = 0; i < given.count; i++)
        for (int axis = 0; axis < 3; axis++)
            given.normal[i][axis] = i % 10 == 0 ? junk[i / 10 % 5] : 7 * truth.normal[i][axis];
    struct stp_points points = { .count = given.count,
                                 .position = (const double(*)[3])given.position,
                                 .normal = (const float(*)[3])given.normal };
    struct stp_scene *scene = prepared(&points, NULL);
    const struct stp_facts *facts = stp_scene_facts(scene);
    struct agreement a = agreement(&scene->splats, &truth);
    assert_int_equal(facts->normals, STP_NORMALS_GIVEN);
    assert_int_equal(facts->bad_normals, 500);
    assert_false(facts->two_sided);
    assert_true(facts->outwardness > 0.99);
    assert_int_equal(a.same_side, 5000);
    assert_true(a.worst_degrees < 6);
    stp_scene_destroy(&scene);
    samples_release(&truth);
    samples_release(&given);
}

/* A cap on any side without any: its rim tells the side, and the planes the rest. At the rim the
 * only known one may be the eighth neighbour, three spacings (2.87 degrees each) away. */
static void whole_patches_are_mended(void **state)
{
    for (int side = 0; side < 6; side++) {
        struct samples truth = sample_surface(on_sphere, 5000, 3);
        struct samples given = sample_surface(on_sphere, 5000, 3);
        for (size_t i = 0; i < given.count; i++)
            if (given.position[i][side / 2] * (side % 2 ? -1 : 1) > 0.6)
                memset(given.normal[i], 0, sizeof given.normal[i]);
        struct stp_points points = { .count = given.count,
                                     .position = (const double(*)[3])given.position,
                                     .normal = (const float(*)[3])given.normal };
        struct stp_scene *scene = prepared(&points, NULL);
        struct agreement a = agreement(&scene->splats, &truth);
        assert_true(stp_scene_facts(scene)->bad_normals > 900);
        assert_int_equal(a.same_side, 5000);
        assert_true(a.worst_degrees < 8.6);
        stp_scene_destroy(&scene);
        samples_release(&truth);
        samples_release(&given);
    }
}

/* Coincident splats, one of them with a good normal: the others take it. */
static void mended_from_their_own_place(void **state)
{
    double p[30][3];
    float n[30][3] = { { 0 } };
    for (int i = 0; i < 30; i++) {
        p[i][0] = i / 3 % 5;
        p[i][1] = i / 15;
        p[i][2] = 0;
        n[i][2] = i % 3 == 2 ? 0 : 1;
        n[i][0] = i % 3 == 2 || i / 3 != 4 ? 0 : 1;
    }
    struct stp_points points = { .count = 30,
                                 .position = (const double(*)[3])p,
                                 .normal = (const float(*)[3])n };
    struct stp_scene *scene = prepared(&points, NULL);
    assert_int_equal(stp_scene_facts(scene)->bad_normals, 10);
    for (size_t i = 0; i < 30; i++) {
        uint32_t from = scene->splats.input[i];
        assert_true(fabs((double)scene->splats.normal[i][0] - (from / 3 == 4 ? sqrt(0.5) : 0)) <
                    1e-6);
    }
    stp_scene_destroy(&scene);
}

/* More than half bad: all are estimated. */
static void mostly_bad_means_estimated(void **state)
{
    struct samples given = sample_surface(on_sphere, 1000, 1);
    for (size_t i = 0; i < 501; i++)
        memset(given.normal[i], 0, sizeof given.normal[i]);
    struct stp_points points = { .count = given.count,
                                 .position = (const double(*)[3])given.position,
                                 .normal = (const float(*)[3])given.normal };
    struct stp_scene *scene = prepared(&points, NULL);
    assert_int_equal(stp_scene_facts(scene)->normals, STP_NORMALS_ESTIMATED);
    assert_int_equal(stp_scene_facts(scene)->bad_normals, 501);
    stp_scene_destroy(&scene);
    samples_release(&given);
}

static void inward_normals_are_two_sided(void **state)
{
    struct samples given = sample_surface(on_sphere, 1000, 1);
    for (size_t i = 0; i < given.count; i++)
        for (int axis = 0; axis < 3; axis++)
            given.normal[i][axis] *= -1;
    struct stp_points points = { .count = given.count,
                                 .position = (const double(*)[3])given.position,
                                 .normal = (const float(*)[3])given.normal };
    struct stp_scene *scene = prepared(&points, NULL);
    assert_true(stp_scene_facts(scene)->outwardness < -0.99);
    assert_true(stp_scene_facts(scene)->two_sided);
    assert_true(dot(scene->splats.normal[0], given.normal[scene->splats.input[0]]) > 0.999999);
    stp_scene_destroy(&scene);
    samples_release(&given);
}

/* A line has no plane: the discs face the eye, and the scene is shaded by depth. */
static void collinear_points_have_none(void **state)
{
    static double line[300][3];
    for (int i = 0; i < 300; i++)
        line[i][0] = line[i][1] = line[i][2] = 0.25 * i;
    struct stp_points points = { .count = 300, .position = (const double(*)[3])line };
    struct stp_scene *scene = prepared(&points, NULL);
    const struct stp_facts *facts = stp_scene_facts(scene);
    assert_int_equal(facts->no_normal, 300);
    assert_int_equal(facts->normals, STP_NORMALS_NONE);
    assert_true(facts->eye_dome && facts->two_sided);
    for (size_t i = 0; i < 300; i++)
        assert_true(scene->splats.normal[i][0] == 0 && !signbit(scene->splats.normal[i][0]));
    stp_scene_destroy(&scene);
}

/* Millimetres at six million metres. */
static void far_from_the_origin(void **state)
{
    struct samples truth = sample_surface(on_sphere, 5000, 3);
    for (size_t i = 0; i < truth.count; i++)
        for (int axis = 0; axis < 3; axis++)
            truth.position[i][axis] = truth.position[i][axis] * 0.25 + 6e6;
    struct stp_points points = { .count = truth.count,
                                 .position = (const double(*)[3])truth.position };
    struct stp_scene *scene = prepared(&points, NULL);
    struct agreement a = agreement(&scene->splats, &truth);
    assert_int_equal(a.same_side, 5000);
    assert_true(a.worst_degrees < 10);
    for (int axis = 0; axis < 3; axis++)
        assert_true(fabs(scene->splats.origin[axis] - 6e6) <= 0.5);
    stp_scene_destroy(&scene);
    samples_release(&truth);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere),
        cmocka_unit_test(torus),
        cmocka_unit_test(plane),
        cmocka_unit_test(two_sheets),
        cmocka_unit_test(bad_ones_are_mended),
        cmocka_unit_test(whole_patches_are_mended),
        cmocka_unit_test(mended_from_their_own_place),
        cmocka_unit_test(mostly_bad_means_estimated),
        cmocka_unit_test(inward_normals_are_two_sided),
        cmocka_unit_test(collinear_points_have_none),
        cmocka_unit_test(far_from_the_origin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
