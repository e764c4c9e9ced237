/* Media by the reference, against Beer-Lambert, quadrature and brute force. */
#include "base/memory.h"
#include "volumes.h"

static double mean_alpha(const struct stp_image *image)
{
    double sum = 0;
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++)
            sum += (double)value(image, "A", x, y);
    return sum / image->width / image->height;
}

/* A slab seen under an angle from its normal, orthographic, the picture far inside it. */
static void slab_obeys_beer_lambert(const uint32_t dims[3], const double spacing[3], double opacity)
{
    struct stp_scene *scene = block_scene(dims, spacing, opacity);
    struct stp_render_params params = exact_params();
    double finest = fmin(spacing[0], fmin(spacing[1], spacing[2]));
    double tau = -log(1 - opacity) / finest, thick = dims[2] * spacing[2];
    for (int angle = 0; angle <= 60; angle += 30) {
        struct stp_camera camera = flat_camera(24, 24, 6 / finest);
        double a = angle * M_PI / 180;
        look_at(&camera, v3(500 * finest * sin(a), 0, 500 * finest * cos(a)), v3(0, 0, 0));
        camera.near_depth = 1e-3 * finest;
        struct stp_image *image = render_volume(scene, &camera, &params);
        double depth = -log(1 - mean_alpha(image)), expected = tau * thick / cos(a);
        close_to(depth / expected, 1, 0.004);
        for (uint32_t x = 0; x < 24; x++) { /* the ripple of the lattice of kernels */
            double alpha = (double)value(image, "A", x, x);
            close_to(-log(1 - alpha) / expected, 1, 0.02);
            close_to((double)value(image, "G", x, x), 0.5 * alpha, 1e-6);
        }
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

static void slabs(void **state)
{
    const double even[3] = { 1, 1, 1 }, flat[3] = { 1, 1, 10 }, small[3] = { 1e-3, 1e-3, 1e-3 };
    slab_obeys_beer_lambert((uint32_t[]){ 48, 32, 10 }, even, 0.1);
    slab_obeys_beer_lambert((uint32_t[]){ 160, 24, 3 }, flat, 0.05);
    slab_obeys_beer_lambert((uint32_t[]){ 48, 32, 10 }, small, 0.1);
}

/* Density along the ray by Simpson's rule, from the definition of the kernel. */
static double quadrature(const struct medium *medium, struct vec3 centre, const struct ray *ray,
                         double from, double to)
{
    const double *s = medium->volume->grid.spacing;
    const int steps = 20000;
    double h = (to - from) / steps, sum = 0;
    struct vec3 middle = eye_point_to_world(&medium->view->eye, centre);
    for (int i = 0; i <= steps; i++) {
        struct vec3 p = eye_point_to_world(&medium->view->eye, ray_at(ray, from + i * h));
        struct vec3 d = v3_sub(p, middle);
        double x = d.x / s[0] / KERNEL_SIGMA, y = d.y / s[1] / KERNEL_SIGMA,
               z = d.z / s[2] / KERNEL_SIGMA;
        double weight = i == 0 || i == steps ? 1 : i % 2 ? 4 : 2;
        sum += weight * exp(-0.5 * (x * x + y * y + z * z));
    }
    return sum * h / 3 * medium->amplitude * v3_length(ray->along);
}

static struct view view_of_scene(const struct stp_scene *scene, const struct stp_camera *camera)
{
    struct view view = {
        .scene = scene, .width = camera->width, .height = camera->height, .grid = 1
    };
    eye_init(&view.eye, camera, scene->splats.origin);
    return view;
}

/* All views of the fixture: inside, wide, sliced, orthographic; spacings up to 1 : 10. */
static void line_integrals_match_quadrature(void **state)
{
    struct stp_scene *scene =
        block_scene((uint32_t[]){ 5, 4, 3 }, (double[]){ 0.2, 0.05, 0.5 }, 0.7);
    uint32_t seed = 77;
    unsigned hits = 0;
    for (int v = 0; v < VIEWS; v++) {
        struct stp_camera camera = hard_view(v, 40, 30);
        struct view view = view_of_scene(scene, &camera);
        struct medium medium;
        assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
        medium.least_alpha = 0;
        for (int i = 0; i < 400; i++) {
            uint32_t k = (uint32_t)(uniform(&seed) * (double)scene->volume->kernels.count);
            struct vec3 c = medium_centre(&medium, k);
            double px = 40 * uniform(&seed), py = 30 * uniform(&seed), bounds[4];
            struct ray ray = eye_ray(&view.eye, px, py);
            struct medium_fragment f;
            double tau = 3 * uniform(&seed);
            if (!medium_hit(&medium, c, tau, &ray, &f))
                continue;
            hits++;
            double near = view.eye.near_depth, far = fmin(view.eye.far_depth, f.depth + 8);
            double integral = quadrature(&medium, c, &ray, fmax(near, f.depth - 8), far);
            close_to(f.alpha, -expm1(-tau * integral), 2e-6);
            assert_true(medium_bounds(&medium, k, c, bounds));
            assert_true(bounds[0] <= px && px <= bounds[1] && bounds[2] <= py && py <= bounds[3]);
        }
        medium_release(&medium);
    }
    assert_true(hits > 100);
    stp_scene_destroy(&scene);
}

struct hit {
    double depth, alpha;
    size_t kernel;
};

static int by_depth_then_kernel(const void *a, const void *b)
{
    const struct hit *x = a, *y = b;
    if (x->depth != y->depth)
        return x->depth < y->depth ? -1 : 1;
    return (x->kernel > y->kernel) - (x->kernel < y->kernel);
}

/* Random values and colours: a pixel is what all kernels, sorted, make of it. */
static void pixels_match_brute_force(void **state)
{
    enum { N = 6 };
    float values[N * N * N];
    uint32_t seed = 5;
    for (int i = 0; i < N * N * N; i++)
        values[i] = uniform(&seed) < 0.3 ? NAN : (float)uniform(&seed);
    struct stp_volume volume = { .dims = { N, N, N },
                                 .spacing = { 0.3, 0.3, 0.3 },
                                 .origin = { -0.75, -0.75, -0.75 },
                                 .value = values };
    struct transfer_function function = {
        .count = 3,
        .point = { { 0, { 1, 0, 0 }, 0.1f }, { 0.5, { 0, 1, 0 }, 0.9f }, { 1, { 0, 0, 1 }, 1 } }
    };
    struct stp_scene *scene = volume_scene(&volume, &function);
    struct stp_render_params params = exact_params();
    for (int v = 0; v < VIEWS; v++) {
        struct stp_camera camera = hard_view(v, 33, 17);
        struct view view = view_of_scene(scene, &camera);
        struct medium medium;
        struct stp_image *image = render_volume(scene, &camera, &params);
        assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
        for (uint32_t y = 0; y < 17; y += 4)
            for (uint32_t x = 0; x < 33; x += 4) {
                struct ray ray = eye_ray(&view.eye, x + 0.5, y + 0.5);
                struct hit hits[N * N * N];
                size_t count = 0;
                for (uint32_t k = 0; k < scene->volume->kernels.count; k++) {
                    struct medium_fragment f;
                    if (medium_hit(&medium, medium_centre(&medium, k),
                                   (double)scene->volume->kernels.tau[k], &ray, &f))
                        hits[count++] = (struct hit){ f.depth, f.alpha, k };
                }
                qsort(hits, count, sizeof *hits, by_depth_then_kernel);
                double rgba[4] = { 0 }; /* back to front, unlike the reference */
                for (size_t i = count; i-- > 0;)
                    for (int c = 0; c < 4; c++) {
                        double own =
                            c < 3 ? (double)scene->volume->kernels.color[hits[i].kernel][c] : 1;
                        rgba[c] = hits[i].alpha * own + (1 - hits[i].alpha) * rgba[c];
                    }
                close_to((double)value(image, "R", x, y), rgba[0], 1e-6);
                close_to((double)value(image, "B", x, y), rgba[2], 1e-6);
                close_to((double)value(image, "A", x, y), rgba[3], 1e-6);
                assert_true((double)value(image, "fragments", x, y) == (double)count);
            }
        medium_release(&medium);
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

/* The ray-marched field as a second opinion: where colours change slowly, compositing kernels one
 * by one and integrating emission and absorption of their sum agree. */
static void marching_agrees(void **state)
{
    enum { N = 24 };
    static float values[N * N * N];
    for (int i = 0; i < N * N * N; i++)
        values[i] = (float)(i / (N * N)) / N; /* along z */
    struct stp_volume volume = { .dims = { N, N, N },
                                 .spacing = { 1, 1, 1 },
                                 .origin = { -11.5, -11.5, -11.5 },
                                 .value = values };
    struct transfer_function function = {
        .count = 2, .point = { { 0, { 1, 0, 0.5f }, 0.02f }, { 1, { 0, 1, 0.5f }, 0.2f } }
    };
    struct stp_scene *scene = volume_scene(&volume, &function);
    struct stp_camera camera = flat_camera(9, 9, 2);
    struct stp_render_params params = exact_params();
    look_at(&camera, v3(20, 12, 60), v3(0, 0, 0));
    camera.near_depth = 1;
    struct stp_image *image = render_volume(scene, &camera, &params);
    struct view view = view_of_scene(scene, &camera);
    struct ray ray = eye_ray(&view.eye, 4.5, 4.5);
    double left = 1, rgb[3] = { 0 }, step = 0.01;
    for (double t = 20; t < 110; t += step) {
        struct vec3 p = eye_point_to_world(&view.eye, ray_at(&ray, t));
        if (fabs(p.x) > 12 || fabs(p.y) > 12 || fabs(p.z) > 12)
            continue;
        double v = fmin(fmax((p.z + 11.5) / N, 0), (N - 1.0) / N);
        struct transfer_point looks = transfer_at(&function, v);
        double absorbed = left * -expm1(log1p(-(double)looks.opacity) * step);
        for (int c = 0; c < 3; c++)
            rgb[c] += absorbed * (double)looks.color[c];
        left -= absorbed;
    }
    close_to((double)value(image, "A", 4, 4), 1 - left, 0.01);
    close_to((double)value(image, "R", 4, 4), rgb[0], 0.01);
    close_to((double)value(image, "G", 4, 4), rgb[1], 0.01);
    stp_image_destroy(&image);
    stp_scene_destroy(&scene);
}

/* One voxel in front of the eye, around it, and behind it. */
static void one_voxel(void **state)
{
    struct stp_render_params params = exact_params();
    struct stp_scene *scene = block_scene((uint32_t[]){ 1, 1, 1 }, (double[]){ 1, 1, 1 }, 1);
    struct stp_camera camera = plain_camera(9, 9, 4);
    double expected[3];
    for (int where = 0; where < 3; where++) {
        look_at(&camera, v3(0.001, 0, 10 - 10.0 * where), v3(0.001, 0, -100));
        struct stp_image *image = render_volume(scene, &camera, &params);
        for (size_t i = 0; i < 81; i++)
            assert_true(isfinite(stp_image_find(image, "A")->data.f[i]));
        expected[where] = (double)value(image, "A", 4, 4);
        stp_image_destroy(&image);
    }
    double depth = 24 * log(2) / (2 * M_PI * KERNEL_SIGMA * KERNEL_SIGMA) / -expm1(-4.5);
    close_to(expected[0], -expm1(-depth), 1e-3);
    close_to(expected[1], -expm1(-depth / 2), 1e-2); /* the half in front of the eye */
    assert_true(expected[2] == 0);
    stp_scene_destroy(&scene);
}

static void needles_and_plates_are_finite(void **state)
{
    struct stp_render_params params = exact_params();
    struct stp_scene *scene = block_scene((uint32_t[]){ 3, 3, 3 }, (double[]){ 1, 1e-6, 1 }, 0.5);
    for (int v = 0; v < VIEWS; v++) {
        struct stp_camera camera = hard_view(v, 16, 16);
        struct stp_image *image = render_volume(scene, &camera, &params);
        for (size_t i = 0; i < 256; i++) {
            double alpha = (double)stp_image_find(image, "A")->data.f[i];
            assert_true(alpha >= 0 && alpha <= 1);
        }
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

/* Dropping opacities below 1e-4 takes (1e-4 / p - exp(-4.5)) / (1 - exp(-4.5)) of the depth of a
 * kernel whose greatest opacity is p: 2.7 % of a medium of 0.005 a voxel (docs/axis.md). */
static void dropping_costs_little(void **state)
{
    struct stp_scene *scene = block_scene((uint32_t[]){ 16, 16, 16 }, (double[]){ 1, 1, 1 }, 0.005);
    struct stp_camera camera = plain_camera(16, 16, 12);
    look_at(&camera, v3(20, 15, 25), v3(0, 0, 0));
    struct view view = view_of_scene(scene, &camera);
    struct stp_image *image[2];
    for (int i = 0; i < 2; i++) {
        struct planes planes;
        assert_int_equal(planes_create(NULL, scene, &camera, 0, &image[i], &planes), STP_OK);
        assert_int_equal(medium_render(NULL, &view, &planes, &(struct stp_render_params){ 0 },
                                       i == 0 ? 0 : LEAST_ALPHA),
                         STP_OK);
    }
    double most = 0, lost;
    for (uint32_t i = 0; i < 256; i++)
        most = fmax(most, fabs((double)value(image[0], "A", i % 16, i / 16) -
                               (double)value(image[1], "A", i % 16, i / 16)));
    lost = 1 - log1p(-mean_alpha(image[1])) / log1p(-mean_alpha(image[0]));
    close_to(lost, 0.027, 0.005);
    assert_true(most < 1.0 / 255);
    stp_image_destroy(&image[0]);
    stp_image_destroy(&image[1]);
    stp_scene_destroy(&scene);
}

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

static void allocations_fail_in_turn(void **state)
{
    struct stp_scene *scene = block_scene((uint32_t[]){ 3, 3, 3 }, (double[]){ 1, 1, 1 }, 0.5);
    struct stp_camera camera = plain_camera(20, 20, 20);
    struct stp_render_params params = exact_params();
    struct stp_env env = { .threads = 1, .log = swallow };
    look_at(&camera, v3(0, 0, 9), v3(0, 0, 0));
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        struct stp_image *image = NULL;
        mem_fail_at(n);
        result = reference_render(&env, scene, &camera, &params, &image);
        mem_fail_at(0);
        assert_true((result == STP_OK) == (image != NULL));
        assert_true(result == STP_OK || result == STP_ERROR_MEMORY);
        stp_image_destroy(&image);
        assert_true(n < 200);
    }
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slabs),
        cmocka_unit_test(line_integrals_match_quadrature),
        cmocka_unit_test(pixels_match_brute_force),
        cmocka_unit_test(marching_agrees),
        cmocka_unit_test(one_voxel),
        cmocka_unit_test(needles_and_plates_are_finite),
        cmocka_unit_test(dropping_costs_little),
        cmocka_unit_test(allocations_fail_in_turn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
