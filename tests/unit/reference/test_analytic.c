/* Closed forms: surfaces whose depth, normal and weights are known without any splat code. */
#include "fixture.h"

/* A disc across the whole of a wide or narrow view is at one depth everywhere. */
static void facing_plane(double degrees)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(41, 31, 15.5 / tan(degrees * M_PI / 360));
    struct stp_render_params params = exact_params();
    double radius = 40;
    add_splat(f, v3(0, 0, -2), v3(0, 0, 1), radius);
    struct stp_image *image = render(f, &camera, &params);
    for (uint32_t j = 0; j < 31; j++)
        for (uint32_t i = 0; i < 41; i++) {
            double x = 2 * (i + 0.5 - 20.5) / camera.fx, y = 2 * (15.5 - j - 0.5) / camera.fy;
            double rho2 = (x * x + y * y) / (radius * radius);
            assert_true(value(image, "A", i, j) == (rho2 <= 1));
            if (rho2 > 1)
                continue;
            close_to(value(image, "Z", i, j), 2, 1e-6);
            close_to(value(image, "weight", i, j), 1 - rho2, 1e-6);
            close_to(value(image, "P.X", i, j), x, 1e-5);
            close_to(value(image, "P.Y", i, j), y, 1e-5);
            close_to(value(image, "R", i, j), 0.8 * 0.8 + 0.2, 1e-6);
        }
    stp_image_destroy(&image);
    free(f);
}

static void facing_planes(void **state)
{
    facing_plane(1);
    facing_plane(60);
    facing_plane(170);
}

/* The floor under the eye, from behind it to before it: depth = 1 / slope below the horizon. */
static void floor_across_the_eye_plane(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(64, 48, 24);
    struct stp_render_params params = exact_params();
    camera.near_depth = 1.5;
    add_splat(f, v3(0, -1, 0), v3(0, 1, 0), 10);
    struct stp_image *image = render(f, &camera, &params);
    size_t covered = 0;
    for (uint32_t j = 0; j < 48; j++)
        for (uint32_t i = 0; i < 64; i++) {
            double slope = (j + 0.5 - 24) / 24, z = 1 / slope, x = z * (i + 0.5 - 32) / 24;
            bool hit = slope > 0 && z >= 1.5 && x * x + z * z <= 100;
            assert_true(value(image, "A", i, j) == hit);
            close_to(value(image, "N.Y", i, j), hit, 0);
            if (hit)
                close_to(value(image, "Z", i, j), z, 1e-6 * z);
            covered += hit;
        }
    assert_true(covered > 500);
    stp_image_destroy(&image);
    free(f);
}

/* A tilted disc in perspective: depth along its plane, far half smaller than the near half. */
static void foreshortening(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(101, 101, 100);
    struct stp_render_params params = exact_params();
    double s = sin(M_PI / 3), c = cos(M_PI / 3);
    add_splat(f, v3(0, 0, -10), v3(s, 0, c), 4);
    struct vec3 n = v3_loadf(f->normal[0]);
    struct stp_image *image = render(f, &camera, &params);
    double left = 0, right = 0;
    for (uint32_t j = 0; j < 101; j++)
        for (uint32_t i = 0; i < 101; i++) {
            if (value(image, "A", i, j) == 0)
                continue;
            double x = (i + 0.5 - 50.5) / 100;
            close_to(value(image, "Z", i, j), 10 * n.z / (n.z - n.x * x), 2e-6);
            left += i < 50 ? 1 : i == 50 ? 0.5 : 0;
            right += i > 50 ? 1 : i == 50 ? 0.5 : 0;
        }
    /* Halves of the ellipse of half axes 4 c and 4, each in perspective (3 % for pixels). The
     * right half recedes behind n.x > 0: x = 4 c u, depth = 10 + 4 s u. */
    double expected[2] = { 0, 0 };
    for (int k = 0; k < 20000; k++) {
        double u = (k + 0.5) / 10000 - 1, depth = 10 + 4 * s * u;
        double u2 = 4 * c * u * 100 / depth, half = 4 * sqrt(1 - u * u) * 100 / depth;
        double du = 1e-4 * 4 * c * 100 * 10 / (depth * depth);
        expected[u2 > 0] += 2 * half * du;
    }
    close_to(left / expected[0], 1, 0.03);
    close_to(right / expected[1], 1, 0.03);
    assert_true(left > 1.5 * right);
    stp_image_destroy(&image);
    free(f);
}

#define SPHERE_SPLATS 4000
#define SPHERE        2.0

static double add_sphere(struct fixture *f)
{
    double radius = 3 * SPHERE * sqrt(4 / (double)SPHERE_SPLATS);
    for (int i = 0; i < SPHERE_SPLATS; i++) { /* a golden spiral */
        double y = 1 - (2 * i + 1.0) / SPHERE_SPLATS, a = i * M_PI * (3 - sqrt(5));
        struct vec3 n = v3(sqrt(1 - y * y) * cos(a), y, sqrt(1 - y * y) * sin(a));
        add_splat(f, v3_scale(n, SPHERE), n, radius);
    }
    return radius;
}

/* Tangent discs lie in the shell from S to sqrt(S^2 + r^2). On a ray at distance b from the centre
 * the first hit's depth is thus early by at most D = sqrt(S^2 + r^2 - b^2) - sqrt(S^2 - b^2), and
 * each normal is off by at most atan(r / S) + asin(D / S); so are their weighted means. */
static void check_sphere_pixel(const struct stp_image *image, const struct stp_camera *camera,
                               struct vec3 eye, double radius, uint32_t i, uint32_t j)
{
    const double *m = camera->world_to_camera;
    double x = (i + 0.5 - camera->cx) / camera->fx, y = (camera->cy - j - 0.5) / camera->fy;
    struct vec3 along =
        v3(m[0] * x + m[4] * y - m[8], m[1] * x + m[5] * y - m[9], m[2] * x + m[6] * y - m[10]);
    double length = v3_length(along), closest = -v3_dot(eye, along) / length;
    double b2 = v3_dot(eye, eye) - closest * closest;
    if (b2 > 0.81 * SPHERE * SPHERE)
        return;
    double shell = sqrt(SPHERE * SPHERE + radius * radius - b2), first = sqrt(SPHERE * SPHERE - b2);
    double depth = (closest - first) / length, early = (shell - first) / length;
    struct vec3 truth = v3_unit(v3_add(eye, v3_scale(along, depth)));
    struct vec3 n =
        v3(value(image, "N.X", i, j), value(image, "N.Y", i, j), value(image, "N.Z", i, j));
    double z = value(image, "Z", i, j);
    assert_true(value(image, "A", i, j) == 1);
    assert_true(z <= depth + 1e-6 && z >= depth - early - 1e-6);
    double bound = atan(radius / SPHERE) + asin((shell - first) / SPHERE);
    assert_true(acos(fmin(1, v3_dot(n, truth))) <= bound + 1e-6);
    assert_true(acos(fmin(1, v3_dot(n, truth))) <= 0.03); /* and far better in fact */
}

static void sphere_of_splats(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(80, 80, 100);
    struct stp_render_params params = exact_params();
    struct vec3 eye = v3(3, 2, 5);
    double radius = add_sphere(f);
    look_at(&camera, eye, v3(0, 0, 0));
    struct stp_image *image = render(f, &camera, &params);
    for (uint32_t j = 0; j < 80; j++)
        for (uint32_t i = 0; i < 80; i++)
            check_sphere_pixel(image, &camera, eye, radius, i, j);
    stp_image_destroy(&image);
    free(f);
}

/* Red at depth 10, green `gap` behind it, epsilon 0.5. */
static void sheets(double gap, bool both)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = flat_camera(3, 3, 1);
    struct stp_render_params params = exact_params();
    paint(f, add_splat(f, v3(0, 0, -10 - gap), v3(0, 0, 1), 8), 0, 1, 0);
    paint(f, add_splat(f, v3(0, 0, -10), v3(0, 0, 1), 8), 1, 0, 0);
    struct stp_image *image = render(f, &camera, &params);
    double share = both ? 0.5 : 0; /* equal weights: the rays are parallel */
    close_to(value(image, "albedo.R", 0, 1), 1 - share, 1e-6);
    close_to(value(image, "albedo.G", 0, 1), share, 1e-6);
    close_to(value(image, "Z", 0, 1), 10 + share * gap, 1e-6);
    assert_true(value(image, "fragments", 0, 1) == (both ? 2 : 1));
    assert_int_equal(id_at(image, 0, 1), 1001);
    stp_image_destroy(&image);
    free(f);
}

static void two_sheets(void **state)
{
    sheets(0.25, true);
    sheets(0.5, true); /* at epsilon: within */
    sheets(nextafter(10.5, 11) - 10, false);
    sheets(3, false);
}

/* A pixel at distance 5 from one centre and 2 from another, radii 10 and 4: rho^2 = 1/4 both
 * times; then radii 10 and 8: 1/4 and 1/16. */
static void weights_by_hand(void **state)
{
    static const double rho2[2] = { 0.25, 0.0625 };
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = flat_camera(1, 1, 1);
    struct stp_render_params params = exact_params();
    paint(f, add_splat(f, v3(3, 4, -10), v3(0, 0, 1), 10), 1, 0, 0);
    paint(f, add_splat(f, v3(0, -2, -10.25), v3(0, 0, 1), 8), 0, 1, 0);
    for (int kernel = 0; kernel < 2; kernel++) {
        params.kernel = (enum stp_kernel)kernel;
        struct stp_image *image = render(f, &camera, &params);
        double w[2];
        for (int i = 0; i < 2; i++)
            w[i] = kernel ? exp(-2 * rho2[i]) : 1 - rho2[i];
        close_to(value(image, "weight", 0, 0), w[0] + w[1], 1e-6);
        close_to(value(image, "albedo.R", 0, 0), w[0] / (w[0] + w[1]), 1e-6);
        close_to(value(image, "Z", 0, 0), 10 + 0.25 * w[1] / (w[0] + w[1]), 1e-6);
        stp_image_destroy(&image);
    }
    free(f);
}

/* On the rim the parabola weighs nothing: the nearest fragment stands, whole. */
static void weights_that_vanish(void **state)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = flat_camera(1, 1, 1);
    struct stp_render_params params = exact_params();
    paint(f, add_splat(f, v3(3, 4, -10), v3(0, 0, 1), 5), 1, 0, 0);
    paint(f, add_splat(f, v3(4, -3, -10.25), v3(0, 0, 1), 5), 0, 1, 0);
    struct stp_image *image = render(f, &camera, &params);
    assert_true(value(image, "A", 0, 0) == 1 && value(image, "weight", 0, 0) == 0);
    assert_true(value(image, "fragments", 0, 0) == 2 && value(image, "Z", 0, 0) == 10);
    assert_true(value(image, "albedo.R", 0, 0) == 1 && value(image, "albedo.G", 0, 0) == 0);
    assert_true(value(image, "N.Z", 0, 0) == 1);
    stp_image_destroy(&image);
    free(f);
}

/* Opposite normals cancel; the tie in depth goes to the lower id. Depth is still averaged. */
static void normals_that_cancel(void **state)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = flat_camera(1, 1, 1);
    struct stp_render_params params = exact_params();
    paint(f, add_splat(f, v3(0, 0, -10), v3(0, 0, -1), 5), 1, 0, 0);
    paint(f, add_splat(f, v3(0, 0, -10), v3(0, 0, 1), 5), 0, 1, 0);
    struct stp_image *image = render(f, &camera, &params);
    assert_int_equal(id_at(image, 0, 0), 1000);
    assert_true(value(image, "N.Z", 0, 0) == -1 && value(image, "albedo.R", 0, 0) == 1);
    close_to(value(image, "weight", 0, 0), 2, 1e-6);
    close_to(value(image, "R", 0, 0), 0.1, 1e-6); /* faces away: ambient only */
    stp_image_destroy(&image);
    f->scene.facts.two_sided = true;
    image = render(f, &camera, &params);
    assert_true(value(image, "N.Z", 0, 0) == 1);
    close_to(value(image, "albedo.R", 0, 0), 0.5, 1e-6);
    stp_image_destroy(&image);
    free(f);
}

static float alpha_of(struct fixture *f, const struct stp_camera *camera, enum stp_cull cull)
{
    struct stp_render_params params = exact_params();
    params.cull = cull;
    struct stp_image *image = render(f, camera, &params);
    float alpha = value(image, "A", 0, 0);
    stp_image_destroy(&image);
    f->scene.splats.count = 0;
    return alpha;
}

static void what_is_never_drawn(void **state)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = plain_camera(1, 1, 1), flat = flat_camera(1, 1, 1);
    camera.near_depth = flat.near_depth = 1;
    camera.far_depth = flat.far_depth = 20;
    add_splat(f, v3(0, 0, 5), v3(0, 0, 1), 3); /* behind the eye */
    assert_true(alpha_of(f, &camera, STP_CULL_NONE) == 0);
    add_splat(f, v3(0, 0, -5), v3(1, 0, 0), 3); /* edge-on */
    assert_true(alpha_of(f, &camera, STP_CULL_NONE) == 0);
    add_splat(f, v3(0, 0, -5), v3(0, 1, 0), 3);
    assert_true(alpha_of(f, &flat, STP_CULL_NONE) == 0);
    add_splat(f, v3(0, 0, -0.999), v3(0, 0, 1), 3); /* nearer than near */
    assert_true(alpha_of(f, &camera, STP_CULL_NONE) == 0);
    add_splat(f, v3(0, 0, -20.001), v3(0, 0, 1), 3); /* beyond far */
    assert_true(alpha_of(f, &camera, STP_CULL_NONE) == 0);
    add_splat(f, v3(0, 0, -5), v3(0, 0, -1), 3); /* faces away */
    assert_true(alpha_of(f, &camera, STP_CULL_BACK) == 0);
    add_splat(f, v3(0, 0, -5), v3(0, 0, -1), 3);
    assert_true(alpha_of(f, &flat, STP_CULL_BACK) == 0);
    add_splat(f, v3(0, 0, -5), v3(0, 0, -1), 3);
    assert_true(alpha_of(f, &flat, STP_CULL_NONE) == 1);
    add_splat(f, v3(0, 0, -1), v3(0, 0, 1), 3); /* at near and at far: drawn */
    assert_true(alpha_of(f, &camera, STP_CULL_BACK) == 1);
    add_splat(f, v3(0, 0, -20), v3(0, 0, 1), 3);
    assert_true(alpha_of(f, &camera, STP_CULL_BACK) == 1);
    add_splat(f, v3(0.5, 0, -5), v3(0, 0, 0), 3); /* no normal: faces the eye */
    assert_true(alpha_of(f, &camera, STP_CULL_BACK) == 1);
    free(f);
}

/* A splat without a normal is square to its own line of sight. */
static void splats_that_face_the_eye(void **state)
{
    struct fixture *f = fixture_create(0.5);
    struct stp_camera camera = plain_camera(21, 21, 10);
    struct stp_render_params params = exact_params();
    struct vec3 p = v3(2, 0.8, -4);
    add_splat(f, p, v3(0, 0, 0), 0.5);
    struct stp_image *image = render(f, &camera, &params);
    struct vec3 n = v3_unit(v3_scale(p, -1));
    uint32_t i = 15, j = 8; /* 10.5 + 10 * 2 / 4, 10.5 - 8 / 4 */
    close_to(value(image, "N.X", i, j), n.x, 1e-6);
    close_to(value(image, "N.Y", i, j), n.y, 1e-6);
    close_to(value(image, "N.Z", i, j), n.z, 1e-6);
    close_to(value(image, "Z", i, j), 4, 1e-6);
    stp_image_destroy(&image);
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facing_planes),       cmocka_unit_test(floor_across_the_eye_plane),
        cmocka_unit_test(foreshortening),      cmocka_unit_test(sphere_of_splats),
        cmocka_unit_test(two_sheets),          cmocka_unit_test(weights_by_hand),
        cmocka_unit_test(weights_that_vanish), cmocka_unit_test(normals_that_cancel),
        cmocka_unit_test(what_is_never_drawn), cmocka_unit_test(splats_that_face_the_eye),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
