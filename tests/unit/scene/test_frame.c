#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "../log_book.h"
#include "base/vec.h"
#include "scene/scene.h"

/* An uneven heap of 400 points with radii; scene i has another shape and place. */
static struct stp_scene *make_scene(unsigned shape, double offset)
{
    static double p[400][3];
    static float n[400][3], radius[400];
    for (size_t i = 0; i < 400; i++) {
        double t = (double)i;
        p[i][0] = offset + cos(t) * (1 + shape);
        p[i][1] = offset + sin(1.7 * t) * 0.3;
        p[i][2] = offset + cos(2.3 * t + 1) * (shape == 2 ? 0 : 2);
        n[i][1] = 1;
        radius[i] = 0.01f + 0.1f * (float)fabs(sin(t));
    }
    struct stp_points points = { .count = 400,
                                 .position = (const double(*)[3])p,
                                 .normal = (const float(*)[3])n,
                                 .radius = radius };
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, &points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    return scene;
}

static void assert_rigid(const double m[16])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double d =
                m[4 * i] * m[4 * j] + m[4 * i + 1] * m[4 * j + 1] + m[4 * i + 2] * m[4 * j + 2];
            assert_true(fabs(d - (i == j)) < 1e-12);
        }
    struct vec3 c = v3_cross(v3(m[0], m[1], m[2]), v3(m[4], m[5], m[6]));
    assert_true(v3_dot(c, v3(m[8], m[9], m[10])) > 0.999999);
    assert_true(m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1);
}

/* The silhouette of a sphere along one axis of the picture, in pixels from the middle: the two
 * tangents from the eye. */
static void silhouette(const struct stp_camera *c, int axis, struct vec3 p, double r, double out[2])
{
    double side = axis ? p.y : p.x, f = axis ? c->fy : c->fx, depth = -p.z;
    if (c->orthographic) {
        out[0] = f * (side - r);
        out[1] = f * (side + r);
        return;
    }
    double distance = sqrt(side * side + depth * depth), middle = atan2(side, depth);
    double half = asin(r / distance);
    out[0] = f * tan(middle - half);
    out[1] = f * tan(middle + half);
}

/* Every sphere within 95 % of the picture; the tighter direction filled on both sides. */
static void check_fit(const struct stp_scene *scene, const struct stp_camera *c)
{
    double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY }, nearest = INFINITY;
    const struct splats *s = &scene->splats;
    for (size_t i = 0; i < s->count; i++) {
        struct vec3 p = m4_point(c->world_to_camera, v3_load(s->position[i]));
        nearest = fmin(nearest, -p.z - (double)s->radius[i]);
        for (int axis = 0; axis < 2; axis++) {
            double out[2], half = 0.5 * (axis ? c->height : c->width);
            silhouette(c, axis, p, (double)s->radius[i], out);
            low[axis] = fmin(low[axis], out[0] / half);
            high[axis] = fmax(high[axis], out[1] / half);
        }
    }
    double fill[2] = { fmin(-low[0], high[0]), fmin(-low[1], high[1]) };
    for (int axis = 0; axis < 2; axis++)
        assert_true(low[axis] > -0.95 - 1e-6 && high[axis] < 0.95 + 1e-6);
    assert_true(fmax(fill[0], fill[1]) > 0.95 - 1e-6);
    assert_true(nearest > 0 && c->near_depth > 0 && c->near_depth <= 1.001e-4 * nearest);
    assert_true(isinf(c->far_depth));
}

static void fits_from_everywhere(void **state)
{
    const double fov[4] = { 0, 0.02, 1.5, 2.9 };
    const uint32_t size[4][2] = { { 0, 0 }, { 1, 1 }, { 1, 999 }, { 1920, 1080 } };
    for (unsigned shape = 0; shape < 3; shape++) {
        struct stp_scene *scene = make_scene(shape, shape == 1 ? 6e5 : 0);
        for (int view = 0; view < 160; view++) {
            struct stp_frame_params p = { .azimuth = view * 0.7,
                                          .elevation = sin(view) * 1.5707963,
                                          .up = (enum stp_up)(view % 5),
                                          .fov_y = fov[view % 4],
                                          .orthographic = view % 3 == 0,
                                          .width = size[view / 4 % 4][0],
                                          .height = size[view / 4 % 4][1] };
            struct stp_camera c;
            assert_int_equal(stp_camera_frame(NULL, scene, &p, &c), STP_OK);
            assert_rigid(c.world_to_camera);
            assert_true(c.cx == 0.5 * c.width && c.cy == 0.5 * c.height && c.fx == c.fy);
            check_fit(scene, &c);
        }
        stp_scene_destroy(&scene);
    }
}

/* Where the camera sits, and what is up in the picture. */
static void conventions(void **state)
{
    static const struct {
        enum stp_up up;
        double azimuth, elevation;
        struct vec3 backward, upward;
    } view[] = {
        { STP_UP_Y, 0, 0, { 0, 0, 1 }, { 0, 1, 0 } },
        { STP_UP_AUTO, 0, 0, { 0, 0, 1 }, { 0, 1, 0 } },
        { STP_UP_Y, 1.5707963267948966, 0, { 1, 0, 0 }, { 0, 1, 0 } },
        { STP_UP_Y, 0, 1.5707963267948966, { 0, 1, 0 }, { 0, 0, -1 } },
        { STP_UP_Z, 0, 0, { 0, -1, 0 }, { 0, 0, 1 } },
        { STP_UP_Z, 1.5707963267948966, 0, { 1, 0, 0 }, { 0, 0, 1 } },
        { STP_UP_X, 0, 0, { 0, 0, -1 }, { 1, 0, 0 } },
        { STP_UP_NEG_Y, 0, 0, { 0, 0, -1 }, { 0, -1, 0 } },
    };
    struct stp_scene *scene = make_scene(0, 0);
    for (size_t i = 0; i < sizeof view / sizeof *view; i++) {
        struct stp_frame_params p = { .azimuth = view[i].azimuth,
                                      .elevation = view[i].elevation,
                                      .up = view[i].up };
        struct stp_camera c;
        assert_int_equal(stp_camera_frame(NULL, scene, &p, &c), STP_OK);
        struct vec3 b = m4_direction(c.world_to_camera, view[i].backward);
        struct vec3 u = m4_direction(c.world_to_camera, view[i].upward);
        assert_true(fabs(b.z - 1) < 1e-12 && fabs(u.y - 1) < 1e-12);
    }
    stp_scene_destroy(&scene);
}

static void points_without_extent(void **state)
{
    double p[3][3] = { { 5, 6, 7 }, { 5, 6, 7 }, { 5, 6, 7 } };
    for (size_t count = 1; count <= 3; count++)
        for (int orthographic = 0; orthographic < 2; orthographic++) {
            struct stp_points points = { .count = count, .position = (const double(*)[3])p };
            struct stp_frame_params params = { .orthographic = orthographic };
            struct stp_scene *scene;
            struct stp_camera c;
            stp_scene_create(NULL, &scene);
            stp_scene_add_points(NULL, scene, &points, NULL);
            assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
            assert_int_equal(stp_camera_frame(NULL, scene, &params, &c), STP_OK);
            for (int i = 0; i < 16; i++)
                assert_true(isfinite(c.world_to_camera[i]));
            check_fit(scene, &c);
            stp_scene_destroy(&scene);
        }
}

static void outliers_do_not_count(void **state)
{
    static double p[1000][3];
    static float radius[1000];
    for (int i = 0; i < 1000; i++) {
        p[i][0] = i == 500 ? 1000 : cos(i);
        p[i][1] = sin(3 * i);
        radius[i] = 0.1f;
    }
    struct stp_points points = { .count = 1000,
                                 .position = (const double(*)[3])p,
                                 .radius = radius };
    struct stp_scene *scene;
    struct stp_camera c;
    stp_scene_create(NULL, &scene);
    stp_scene_add_points(NULL, scene, &points, NULL);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    assert_int_equal(stp_camera_frame(NULL, scene, NULL, &c), STP_OK);
    struct vec3 eye = m4_point(c.world_to_camera, v3(0, 0, 0));
    assert_true(v3_length(eye) < 10);
    stp_scene_destroy(&scene);
}

static void bad_arguments(void **state)
{
    const struct stp_frame_params bad[] = { { .fov_y = -1 },
                                            { .fov_y = 3.2 },
                                            { .fov_y = NAN },
                                            { .azimuth = NAN },
                                            { .elevation = INFINITY } };
    struct stp_scene *scene = make_scene(0, 0), *empty;
    struct stp_camera c, before;
    memset(&c, 7, sizeof c);
    before = c;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(stp_camera_frame(NULL, scene, &bad[i], &c), STP_ERROR_ARGUMENT);
    stp_scene_create(NULL, &empty);
    assert_int_equal(stp_camera_frame(NULL, empty, NULL, &c), STP_ERROR_ARGUMENT);
    assert_memory_equal(&c, &before, sizeof c);
    stp_scene_destroy(&scene);
    stp_scene_destroy(&empty);
}

/* Lines go to the caller's log, and its threads change nothing. */
static void heeds_its_env(void **state)
{
    struct log_book book;
    struct stp_env one = logged_env(&book, 1), many = { .threads = 5 };
    struct stp_scene *scene = make_scene(0, 0);
    struct stp_camera a, b;
    const struct stp_light dark = { .direction = { 0 } };
    memset(&a, 0, sizeof a);
    memset(&b, 0, sizeof b);
    assert_int_equal(stp_camera_frame(&one, scene, NULL, &a), STP_OK);
    assert_int_equal(stp_camera_frame(&many, scene, NULL, &b), STP_OK);
    assert_memory_equal(&a, &b, sizeof a);
    assert_int_equal(stp_camera_frame(&one, scene, &(struct stp_frame_params){ .fov_y = -1 }, &a),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(book.errors, 1);
    assert_int_equal(stp_scene_set_lights(&one, scene, &dark, 1), STP_ERROR_ARGUMENT);
    assert_int_equal(book.errors, 2);
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heeds_its_env),         cmocka_unit_test(fits_from_everywhere),
        cmocka_unit_test(conventions),           cmocka_unit_test(points_without_extent),
        cmocka_unit_test(outliers_do_not_count), cmocka_unit_test(bad_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
