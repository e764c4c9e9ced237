/* The screen-space floor: by hand, and against finite differences of the exact hit. */
#include "fixture.h"

static struct stp_image *floored(struct fixture *f, const struct stp_camera *camera, double least)
{
    struct stp_render_params params = exact_params();
    params.min_splat = least;
    return render(f, camera, &params);
}

/* A point-like splat at a pixel's centre is a disc of diameter F around it. */
static void small_splats(void **state)
{
    static const struct {
        double least;
        size_t pixels; /* within F / 2 of a centre */
    } expected[4] = { { -1, 1 }, { 1.5, 1 }, { 2.5, 5 }, { 3, 9 } };
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = plain_camera(9, 9, 10);
    add_splat(f, v3(0, 0, -10), v3(0, 0, 1), 1e-4);
    for (int k = 0; k < 4; k++) {
        struct stp_image *image = floored(f, &camera, expected[k].least);
        size_t covered = 0;
        for (uint32_t i = 0; i < 81; i++)
            covered += value(image, "A", i % 9, i / 9) > 0;
        assert_int_equal(covered, expected[k].pixels);
        if (expected[k].least == 2.5)
            close_to(value(image, "weight", 5, 4), 1 - 1 / (1.25 * 1.25), 1e-6);
        stp_image_destroy(&image);
    }
    f->position[0][0] = 0.5; /* between two pixels: lost without the floor; 0 is 1.5 */
    for (int k = 0; k < 2; k++) {
        struct stp_image *image = floored(f, &camera, k == 0 ? -1 : 0);
        assert_true(value(image, "A", 4, 4) == (float)k && value(image, "A", 5, 4) == (float)k);
        if (k == 1)
            close_to(value(image, "weight", 4, 4), 1 - 0.25 / 0.5625, 1e-6);
        stp_image_destroy(&image);
    }
    free(f);
}

/* An upright line, 2 r fx = 20.5 pixels by F, at the centre's depth. */
static void edge_on(void **state)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = flat_camera(31, 31, 10);
    add_splat(f, v3(0, 0, -7), v3(1, 0, 0), 1.025);
    struct stp_image *image = floored(f, &camera, 2.2);
    for (uint32_t j = 0; j < 31; j++)
        for (uint32_t i = 0; i < 31; i++) {
            double x = (i - 15.0) / 1.1, y = (j - 15.0) / 10.25, rho2 = x * x + y * y;
            assert_true(value(image, "A", i, j) == (rho2 <= 1));
            if (rho2 <= 1) {
                close_to(value(image, "Z", i, j), 7, 0);
                close_to(value(image, "weight", i, j), 1 - rho2, 1e-6);
            }
        }
    stp_image_destroy(&image);
    free(f);
}

/* A disc of 3 px by nearly 0 tilted in depth: its first-order depth, kept within the radius. */
static void depth_is_clamped(void **state)
{
    struct fixture *f = fixture_create(100);
    struct stp_camera camera = flat_camera(9, 9, 1);
    double a = 1e-3; /* n.z */
    add_splat(f, v3(0, 0, -50), v3(sqrt(1 - a * a), 0, a), 3);
    struct stp_image *image = floored(f, &camera, 5);
    close_to(value(image, "Z", 4, 4), 50, 1e-5);
    close_to(value(image, "Z", 5, 4), 53, 1e-5); /* 1000 behind, by the plane */
    close_to(value(image, "Z", 3, 4), 47, 1e-5);
    stp_image_destroy(&image);
    free(f);
}

static void near_splats_are_not_floored(void **state)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = plain_camera(9, 9, 10);
    camera.near_depth = 2;
    add_splat(f, v3(0, 0, -1.999), v3(0, 0, 1), 1e-4);
    add_splat(f, v3(0, 0, 3), v3(0, 0, 1), 1e-4);
    struct stp_image *image = floored(f, &camera, 30);
    for (uint32_t i = 0; i < 81; i++)
        assert_true(value(image, "A", i % 9, i / 9) == 0);
    stp_image_destroy(&image);
    f->position[0][2] = -2; /* at near */
    image = floored(f, &camera, 30);
    assert_true(value(image, "A", 0, 0) == 1);
    stp_image_destroy(&image);
    free(f);
}

/* Where the exact disc is met, in the camera frame, `dx`, `dy` pixels from the centre. */
static struct vec3 met(const struct eye *eye, const struct disc *disc, double px, double py)
{
    struct ray ray = eye_ray(eye, px, py);
    double t =
        v3_dot(disc->normal, v3_sub(disc->centre, ray.start)) / v3_dot(disc->normal, ray.along);
    return ray_at(&ray, t);
}

/* E' from central differences, then its eigenvalues cut: rho^2 and depth as docs/numerics.md. */
static void check_affine(const struct eye *eye, const struct disc *disc, double least)
{
    const double h = 1e-4;
    double px = eye->cx + eye->fx * disc->centre.x / (eye->orthographic ? 1 : -disc->centre.z);
    double py = eye->cy - eye->fy * disc->centre.y / (eye->orthographic ? 1 : -disc->centre.z);
    struct vec3 x = v3_scale(v3_sub(met(eye, disc, px + h, py), met(eye, disc, px - h, py)),
                             1 / (2 * h * disc->radius));
    struct vec3 y = v3_scale(v3_sub(met(eye, disc, px, py + h), met(eye, disc, px, py - h)),
                             1 / (2 * h * disc->radius));
    double a = v3_dot(x, x), b = v3_dot(x, y), c = v3_dot(y, y), bound = 4 / (least * least);
    double middle = (a + c) / 2, spread = hypot((a - c) / 2, b);
    double large = middle + spread, small = middle - spread;
    assert_int_equal(disc->is_floored, 2 / sqrt(large) < least);
    if (!disc->is_floored || spread < 1e-3 * middle)
        return;
    /* E' = f + g E, of eigenvalues min(bound, .) */
    double g = (bound - fmin(small, bound)) / (large - small), f = bound - g * large;
    const struct floored *q = &disc->floored;
    double tolerance = 1e-5 * bound;
    close_to(q->px, px, 1e-9);
    close_to(q->py, py, 1e-9);
    close_to(q->a, f + g * a, tolerance);
    close_to(q->b, g * b, tolerance);
    close_to(q->c, f + g * c, tolerance);
    double scale = disc->radius * hypot(x.z, y.z);
    close_to(q->zx, -x.z * disc->radius, 1e-5 * scale);
    close_to(q->zy, -y.z * disc->radius, 1e-5 * scale);
}

static void ellipse_against_differences(void **state)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera cameras[2] = { plain_camera(64, 64, 50), flat_camera(64, 64, 6) };
    uint32_t seed = 99;
    size_t cut = 0, whole = 0;
    cameras[0].fy = 70;
    for (int i = 0; i < 400; i++) {
        struct vec3 p = v3_add(random_point(&seed, 4), v3(0, 0, -8)), n = random_point(&seed, 1);
        if (fabs(v3_dot(v3_unit(n), v3_unit(p))) < 0.05 || fabs(v3_unit(n).z) < 0.05)
            continue; /* too steep for differences */
        add_splat(f, p, n, 0.3 + uniform(&seed) / 3);
    }
    for (int k = 0; k < 2; k++) {
        struct view view = { .scene = &f->scene, .width = 64, .height = 64, .min_splat = 4 };
        eye_init(&view.eye, &cameras[k], f->scene.splats.origin);
        for (size_t id = 0; id < f->scene.splats.count; id++) {
            struct disc disc;
            assert_true(disc_setup(&view, id, &disc));
            check_affine(&view.eye, &disc, 4);
            disc.is_floored ? cut++ : whole++;
        }
    }
    assert_true(cut > 50 && whole > 50);
    free(f);
}

/* The limit at the edge is the ellipse nearly there, off the axis too. */
static void ellipse_is_continuous_at_the_edge(void **state)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = plain_camera(64, 64, 50);
    struct vec3 p = v3(3, 2, -6), side = v3_unit(v3_cross(p, v3(0.3, 1, 0.2)));
    struct disc disc[2];
    for (int k = 0; k < 2; k++) {
        struct view view = { .scene = &f->scene, .width = 64, .height = 64, .min_splat = 2 };
        eye_init(&view.eye, &camera, f->scene.splats.origin);
        struct vec3 n = v3_add(side, v3_scale(v3_unit(p), k == 0 ? 0 : -1e-5));
        add_splat(f, p, n, 1);
        assert_true(disc_setup(&view, (size_t)k, &disc[k]) && disc[k].is_floored);
    }
    close_to(disc[0].floored.a, disc[1].floored.a, 1e-4);
    close_to(disc[0].floored.b, disc[1].floored.b, 1e-4);
    close_to(disc[0].floored.c, disc[1].floored.c, 1e-4);
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_splats),
        cmocka_unit_test(edge_on),
        cmocka_unit_test(depth_is_clamped),
        cmocka_unit_test(near_splats_are_not_floored),
        cmocka_unit_test(ellipse_against_differences),
        cmocka_unit_test(ellipse_is_continuous_at_the_edge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
