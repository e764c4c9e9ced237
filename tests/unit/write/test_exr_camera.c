/* The P channels, read from the file and sent through the file's worldToNDC, land on their own
 * pixel; perspective and orthographic, off-centre, with an origin six million units away. */
#include "helpers.h"

#include <openexr.h>

#include "base/vec.h"

enum { WIDTH = 61, HEIGHT = 43 };

static struct stp_camera make_camera(bool orthographic)
{
    /* A rotation about a skew axis, by Rodrigues' formula, and an eye near the origin below. */
    struct vec3 axis = v3_unit(v3(0.3, -0.8, 0.5)), eye = v3(6e6 + 3, -5e6 + 2, 412);
    double angle = 1.1, c = cos(angle), s = sin(angle), k = 1 - c;
    double r[9] = { c + axis.x * axis.x * k,          axis.x * axis.y * k - axis.z * s,
                    axis.x * axis.z * k + axis.y * s, axis.y * axis.x * k + axis.z * s,
                    c + axis.y * axis.y * k,          axis.y * axis.z * k - axis.x * s,
                    axis.z * axis.x * k - axis.y * s, axis.z * axis.y * k + axis.x * s,
                    c + axis.z * axis.z * k };
    struct stp_camera camera = { .orthographic = orthographic,
                                 .fx = orthographic ? 9 : 70,
                                 .fy = orthographic ? 8 : 75,
                                 .cx = 22.25,
                                 .cy = 30.75,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .near_depth = 0.5,
                                 .far_depth = orthographic ? 80 : INFINITY };
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            camera.world_to_camera[4 * i + j] = r[3 * i + j];
        camera.world_to_camera[4 * i + 3] = -v3_dot(v3_load(r + 3 * i), eye);
    }
    camera.world_to_camera[15] = 1;
    return camera;
}

/* The world position at `depth` on the ray of the pixel (docs/numerics.md). */
static struct vec3 unproject(const struct stp_camera *c, int x, int y, double depth)
{
    double lens = c->orthographic ? 1 : depth;
    struct vec3 p = v3((x + 0.5 - c->cx) / c->fx * lens, -(y + 0.5 - c->cy) / c->fy * lens, -depth);
    const double *m = c->world_to_camera;
    p = v3_sub(p, v3(m[3], m[7], m[11]));
    return v3(m[0] * p.x + m[4] * p.y + m[8] * p.z, m[1] * p.x + m[5] * p.y + m[9] * p.z,
              m[2] * p.x + m[6] * p.y + m[10] * p.z);
}

static void write_positions(const struct stp_camera *camera, const char *path)
{
    const char *names[] = { "P.X", "P.Y", "P.Z" };
    struct stp_image *image = NULL;
    float *plane[3];
    uint32_t seed = 8;
    assert_int_equal(stp_image_create(NULL, WIDTH, HEIGHT, &image), STP_OK);
    for (int c = 0; c < 3; c++)
        plane[c] = add_plane(image, names[c], STP_CHANNEL_FLOAT)->data.f;
    image->has_camera = true;
    image->camera = *camera;
    memcpy(image->origin, (double[]){ 6e6, -5e6, 400 }, sizeof image->origin);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double depth = 1 + next_random(&seed) / 4294967296.0 * 30;
        struct vec3 p =
            v3_sub(unproject(camera, i % WIDTH, i / WIDTH, depth), v3_load(image->origin));
        plane[0][i] = (float)p.x;
        plane[1][i] = (float)p.y;
        plane[2][i] = (float)p.z;
    }
    assert_int_equal(stp_image_write_exr(NULL, image, path, NULL), STP_OK);
    stp_image_destroy(&image);
}

struct attributes {
    exr_attr_m44f_t to_camera, to_ndc;
    exr_attr_v3d_t origin;
    exr_attr_v2f_t center;
    float width, aspect;
};

static struct attributes read_attributes(const char *path)
{
    struct attributes a;
    exr_context_t context = NULL;
    assert_int_equal(exr_start_read(&context, path, NULL), EXR_ERR_SUCCESS);
    assert_int_equal(exr_attr_get_m44f(context, 0, "worldToCamera", &a.to_camera), 0);
    assert_int_equal(exr_attr_get_m44f(context, 0, "worldToNDC", &a.to_ndc), 0);
    assert_int_equal(exr_attr_get_v3d(context, 0, "stipple:origin", &a.origin), 0);
    assert_int_equal(exr_get_screen_window_center(context, 0, &a.center), 0);
    assert_int_equal(exr_get_screen_window_width(context, 0, &a.width), 0);
    assert_int_equal(exr_get_pixel_aspect_ratio(context, 0, &a.aspect), 0);
    exr_finish(&context);
    return a;
}

/* p M for a row vector, divided by w. */
static struct vec3 transform(const exr_attr_m44f_t *m, const float p[3])
{
    double out[4];
    for (int j = 0; j < 4; j++)
        out[j] = (double)p[0] * m->m[j] + (double)p[1] * m->m[4 + j] + (double)p[2] * m->m[8 + j] +
                 m->m[12 + j];
    return v3(out[0] / out[3], out[1] / out[3], out[2] / out[3]);
}

static void check(const char *folder, bool orthographic)
{
    char path[PATH_MAX];
    struct stp_camera camera = make_camera(orthographic);
    struct stp_image *image = NULL;
    in_scratch(folder, "p.exr", path);
    write_positions(&camera, path);
    struct attributes a = read_attributes(path);
    assert_int_equal(stp_image_read_exr(NULL, path, &image), STP_OK);
    assert_true(image->origin[0] == 6e6 && image->origin[1] == -5e6 && image->origin[2] == 400);
    assert_true(a.origin.x == 6e6 && a.origin.y == -5e6 && a.origin.z == 400);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        float p[3];
        for (int c = 0; c < 3; c++)
            p[c] = image->channels[c].data.f[i];
        struct vec3 ndc = transform(&a.to_ndc, p), view = transform(&a.to_camera, p);
        assert_true(fabs(ndc.x * WIDTH - (i % WIDTH + 0.5)) < 1e-3);
        assert_true(fabs(ndc.y * HEIGHT - (i / WIDTH + 0.5)) < 1e-3);
        assert_true(ndc.z > 0 && ndc.z < 1 && view.z > 0.99 && view.z < 31.01);
        /* The screen window of the header says the same. */
        double depth = orthographic ? 1 : view.z;
        double across = (view.x / depth - a.center.x) / a.width + 0.5;
        double height = a.width * HEIGHT / WIDTH / a.aspect;
        double down = 0.5 - (view.y / depth - a.center.y) / height;
        assert_true(fabs(across * WIDTH - (i % WIDTH + 0.5)) < 1e-3);
        assert_true(fabs(down * HEIGHT - (i / WIDTH + 0.5)) < 1e-3);
    }
    stp_image_destroy(&image);
}

static void test_perspective(void **state)
{
    check(*state, false);
}

static void test_orthographic(void **state)
{
    check(*state, true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_perspective),
        cmocka_unit_test(test_orthographic),
    };
    return cmocka_run_group_tests(tests, enter_scratch, leave_scratch);
}
