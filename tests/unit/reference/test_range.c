/* Ellipsoids of range images by the reference: against quadrature, brute force and what is known.
 */
#include "ranges.h"

#include "reference/range.h"

enum { W = 40, H = 30 };

static struct view view_of_scene(const struct stp_scene *scene, const struct stp_camera *camera)
{
    struct view view = {
        .scene = scene, .width = camera->width, .height = camera->height, .grid = 1
    };
    eye_init(&view.eye, camera, scene->splats.origin);
    return view;
}

/* m^2 of a world place by Gauss's elimination on the axes. */
static double mahalanobis(const float axes[3][3], struct vec3 d)
{
    double m[3][4] = { { 0 } }, sum = 0;
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            m[r][c] = (double)axes[c][r];
        m[r][3] = r == 0 ? d.x : r == 1 ? d.y : d.z;
    }
    for (int c = 0; c < 3; c++) {
        int pivot = c;
        for (int r = c + 1; r < 3; r++)
            pivot = fabs(m[r][c]) > fabs(m[pivot][c]) ? r : pivot;
        for (int k = 0; k < 4; k++) {
            double t = m[c][k];
            m[c][k] = m[pivot][k];
            m[pivot][k] = t;
        }
        for (int r = 0; r < 3; r++)
            for (int k = 3; r != c && k >= c; k--)
                m[r][k] -= m[c][k] * (m[r][c] / m[c][c]);
    }
    for (int r = 0; r < 3; r++)
        sum += m[r][3] / m[r][r] * (m[r][3] / m[r][r]);
    return sum;
}

/* Simpson's rule from the definition. */
static double quadrature(const struct medium *medium, uint32_t kernel, const struct ray *ray,
                         double from, double to)
{
    const struct kernels *k = &medium->volume->kernels;
    const int steps = 4000;
    double h = (to - from) / steps, sum = 0;
    for (int i = 0; i <= steps; i++) {
        struct vec3 p = eye_point_to_world(&medium->view->eye, ray_at(ray, from + i * h));
        double weight = i == 0 || i == steps ? 1 : i % 2 ? 4 : 2;
        sum +=
            weight * exp(-0.5 * mahalanobis(k->axes[kernel], v3_sub(p, v3_load(k->place[kernel]))));
    }
    return sum * h / 3 * v3_length(ray->along);
}

static void line_integrals_match_quadrature(void **state)
{
    struct range range = random_range(9, 3, 6, 0.15);
    struct stp_scene *scene = range_scene(&range);
    uint32_t seed = 77;
    size_t hits = 0;
    for (int v = 0; v < VIEWS; v++) {
        struct stp_camera camera = hard_view(v, W, H);
        struct view view = view_of_scene(scene, &camera);
        struct medium medium;
        assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
        medium.least_alpha = 0;
        for (int i = 0; i < 500; i++) {
            uint32_t k = (uint32_t)(uniform(&seed) * (double)scene->volume->kernels.count);
            struct vec3 c = medium_centre(&medium, k);
            double px = W * uniform(&seed), py = H * uniform(&seed), bounds[4];
            struct ray ray = eye_ray(&view.eye, px, py);
            struct medium_fragment f;
            double tau = 3 * uniform(&seed);
            if (!ellipsoid_hit(&medium, k, c, tau, &ray, &f))
                continue;
            hits++;
            double from = fmax(view.eye.near_depth, f.depth - 5);
            double integral =
                quadrature(&medium, k, &ray, from, fmin(view.eye.far_depth, f.depth + 5));
            close_to(f.alpha, -expm1(-tau * integral), 2e-6);
            assert_true(medium_bounds(&medium, k, c, bounds));
            assert_true(bounds[0] <= px && px <= bounds[1] && bounds[2] <= py && py <= bounds[3]);
        }
        medium_release(&medium);
    }
    assert_true(hits > 100);
    stp_scene_destroy(&scene);
}

static int nearer(const void *a, const void *b)
{
    const struct medium_fragment *x = a, *y = b;
    if (x->depth != y->depth)
        return x->depth < y->depth ? -1 : 1;
    return (x->kernel > y->kernel) - (x->kernel < y->kernel);
}

/* Every kernel on the ray, sorted, composited, divided by what covers half of it. */
static void expect_pixel(const struct medium *medium, const struct stp_image *image, uint32_t x,
                         uint32_t y)
{
    static struct medium_fragment list[512];
    size_t count = 0;
    double left = 1, sum[4] = { 0 };
    struct ray ray = eye_ray(&medium->view->eye, x + 0.5, y + 0.5);
    for (uint32_t k = 0; k < medium->volume->kernels.count; k++) {
        list[count].kernel = k;
        count +=
            ellipsoid_hit(medium, k, medium_centre(medium, k), medium->tau[k], &ray, &list[count]);
        assert_true(count < 512);
    }
    qsort(list, count, sizeof *list, nearer);
    for (size_t i = 0; i < count; i++) {
        double w = left * list[i].alpha;
        for (int n = 0; n < 3; n++)
            sum[n] += w * medium->shaded[list[i].kernel][n];
        sum[3] += w;
        left -= w;
    }
    double scale = sum[3] >= 0.5 ? 1 / sum[3] : 2;
    static const char *const names[] = { "R", "G", "B", "A" };
    for (int n = 0; n < 4; n++)
        close_to((double)value(image, names[n], x, y), sum[n] * scale, 1e-6);
}

static void pixels_match_brute_force(void **state)
{
    for (int v = 0; v < VIEWS; v++) {
        struct range range = random_range(3 + (uint32_t)v, 2, 8, v % 2 ? 0.02 : 0.2);
        range.by_views = v % 2;
        struct stp_scene *scene = range_scene(&range);
        struct stp_camera camera = hard_view(v, W, H);
        struct stp_render_params params = { .method = STP_METHOD_REFERENCE };
        struct stp_image *image = render_volume(scene, &camera, &params);
        struct view view = view_of_scene(scene, &camera);
        struct medium medium;
        assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
        for (uint32_t y = 1; y < H; y += 5)
            for (uint32_t x = 1; x < W; x += 5)
                expect_pixel(&medium, image, x, y);
        medium_release(&medium);
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* Seen from where it was measured, a wall is opaque, flat, and has its own colours. */
static void a_wall_from_its_own_view(void **state)
{
    static const double sigmas[] = { 1e-9, 0.01, 0.3 };
    for (int i = 0; i < 3; i++) {
        struct range range = wall_range(W, H, 35, 2, sigmas[i]);
        struct stp_scene *scene = range_scene(&range);
        struct stp_camera camera = plain_camera(W, H, 35);
        struct stp_render_params params = { .method = STP_METHOD_REFERENCE };
        struct stp_image *image = render_volume(scene, &camera, &params);
        for (uint32_t y = 3; y < H - 3; y++)
            for (uint32_t x = 3; x < W - 3; x++) {
                close_to((double)value(image, "A", x, y), 1, 1e-6);
                close_to((double)value(image, "R", x, y), 0.25, 1e-6);
                close_to((double)value(image, "B", x, y), (double)x / W, 0.006);
                /* Ellipsoids beside the ray are densest a little nearer, where they are closer to
                 * it. */
                close_to((double)value(image, "Z", x, y), 2, 1e-4 + 2 * sigmas[i] * sigmas[i]);
            }
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

/* The optical depth of a surface is that of the definition, from its own view, however uncertain.
 */
static void the_optical_depth_of_a_surface(void **state)
{
    struct range range = wall_range(W, H, 35, 2, 0.05);
    struct stp_scene *scene = range_scene(&range);
    struct stp_camera camera = plain_camera(W, H, 35);
    struct view view = view_of_scene(scene, &camera);
    struct medium medium;
    double sum = 0;
    assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
    medium.least_alpha = 0;
    struct ray ray = eye_ray(&view.eye, 17.3, 14.8);
    for (uint32_t k = 0; k < scene->volume->kernels.count; k++) {
        struct medium_fragment f;
        if (ellipsoid_hit(&medium, k, medium_centre(&medium, k), medium.tau[k], &ray, &f))
            sum -= log1p(-f.alpha);
    }
    close_to(sum / RANGE_DEPTH_OF_SURFACE, 1, 0.02);
    medium_release(&medium);
    stp_scene_destroy(&scene);
}

/* A long ellipsoid, 10^6 : 1, along its own ray and across: finite, and as the definition has it.
 */
static void a_million_to_one(void **state)
{
    struct range range = wall_range(1, 1, 5.5e6, 1, 0.1); /* 0.55 pixels are 1e-7 */
    struct stp_scene *scene = range_scene(&range);
    struct stp_camera camera = plain_camera(33, 33, 2.2e7);
    struct stp_render_params params = { .method = STP_METHOD_REFERENCE };
    camera.near_depth = 0.01;
    struct stp_image *image = render_volume(scene, &camera, &params);
    close_to((double)value(image, "R", 16, 16), 0.25, 1e-6);
    close_to((double)value(image, "A", 16, 16), 1, 1e-6);
    close_to((double)value(image, "A", 1, 1), 0, 1e-6);
    stp_image_destroy(&image);
    look_at(&camera, v3(2, 0, -1), v3(0, 0, -1)); /* thin, and opaque nowhere */
    camera.fx = camera.fy = 20;
    image = render_volume(scene, &camera, &params);
    for (uint32_t i = 0; i < 33; i++)
        assert_true(value(image, "A", i, 16) >= 0 && value(image, "A", i, 16) <= 1);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

/* The eye within an ellipsoid, and one that is all behind it. */
static void at_the_eye_plane(void **state)
{
    struct range range = wall_range(1, 1, 2, 1, 0.6);
    struct stp_scene *scene = range_scene(&range);
    struct stp_render_params params = { .method = STP_METHOD_REFERENCE };
    struct stp_camera camera = plain_camera(9, 9, 5);
    look_at(&camera, v3(0, 0, -1), v3(0, 0, -2));
    struct stp_image *image = render_volume(scene, &camera, &params);
    assert_true(value(image, "A", 4, 4) > 0.3f && isfinite(value(image, "Z", 4, 4)));
    close_to((double)value(image, "Z", 4, 4), camera.near_depth,
             1e-6); /* densest where it begins */
    stp_image_destroy(&image);
    look_at(&camera, v3(0, 0, -8), v3(0, 0, -9));
    image = render_volume(scene, &camera, &params);
    assert_true(value(image, "A", 4, 4) == 0 && isinf(value(image, "Z", 4, 4)));
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(line_integrals_match_quadrature),
        cmocka_unit_test(pixels_match_brute_force),
        cmocka_unit_test(a_wall_from_its_own_view),
        cmocka_unit_test(the_optical_depth_of_a_surface),
        cmocka_unit_test(a_million_to_one),
        cmocka_unit_test(at_the_eye_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
