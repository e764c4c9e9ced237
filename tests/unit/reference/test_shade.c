/* Lights, materials, objects, eye dome and background, by their formulas. */
#include "fixture.h"

static struct vec3 rgb(const struct stp_image *image, uint32_t x, uint32_t y)
{
    return v3(value(image, "R", x, y), value(image, "G", x, y), value(image, "B", x, y));
}

static void near_to(struct vec3 actual, struct vec3 expected, double tolerance)
{
    close_to(actual.x, expected.x, tolerance);
    close_to(actual.y, expected.y, tolerance);
    close_to(actual.z, expected.z, tolerance);
}

/* All in the world, by the formula. */
static struct vec3 lit(struct vec3 albedo, struct vec3 n, struct vec3 l, struct vec3 v,
                       struct vec3 color)
{
    struct vec3 h = v3_unit(v3_add(v3_unit(l), v3_unit(v)));
    double diffuse = 0.1 + 0.7 * fmax(0, v3_dot(n, v3_unit(l)));
    double shine = 0.2 * pow(fmax(0, v3_dot(n, h)), 32);
    return v3((albedo.x * diffuse + shine) * color.x, (albedo.y * diffuse + shine) * color.y,
              (albedo.z * diffuse + shine) * color.z);
}

struct shot {
    struct fixture *fixture;
    struct stp_camera camera;
    struct stp_render_params params;
    struct vec3 point, normal, eye, axis; /* of the centre pixel; axis: towards the viewer */
};

/* A tilted coloured disc in the middle of a turned camera's picture. */
static struct shot shot_of(bool orthographic)
{
    struct shot s = { .fixture = fixture_create(0.5), .params = exact_params() };
    s.eye = v3(4, 3, 7);
    s.point = v3(0.5, -0.25, 0.75);
    s.camera = orthographic ? flat_camera(3, 3, 1) : plain_camera(3, 3, 10);
    look_at(&s.camera, s.eye, s.point);
    s.axis = v3_unit(v3_sub(s.eye, s.point));
    size_t i = add_splat(s.fixture, s.point, v3_add(s.axis, v3(0.2, 0.1, -0.1)), 0.5);
    paint(s.fixture, i, 0.5f, 0.25f, 0.75f);
    s.normal = v3_loadf(s.fixture->normal[i]);
    return s;
}

static void expect_light(struct shot *s, const struct stp_light *light, struct vec3 l,
                         struct vec3 v)
{
    s->fixture->scene.lights[0] = *light;
    struct stp_image *image = render(s->fixture, &s->camera, &s->params);
    struct vec3 expected = lit(v3(0.5, 0.25, 0.75), s->normal, l, v, v3_loadf(light->color));
    near_to(rgb(image, 1, 1), expected, 1e-6);
    stp_image_destroy(&image);
}

static void every_kind_of_light(void **state)
{
    const struct stp_light head = { .at_eye = true, .color = { 1, 0.5f, 2 } };
    const struct stp_light sun = { .direction = { 2, 5, 3 }, .color = { 1, 1, 0.25f } };
    const struct stp_light lamp = { .positional = true,
                                    .position = { 2, 2, 3 },
                                    .color = { 3, 1, 1 } };
    const struct stp_light behind = { .direction = { -4, -3, -7 }, .color = { 1, 1, 1 } };
    for (int k = 0; k < 4; k++) {
        struct shot s = shot_of(k & 1);
        s.params.local_viewer = k & 2;
        struct vec3 v = s.axis; /* the centre pixel's own line of sight is the axis */
        expect_light(&s, &head, s.axis, v);
        expect_light(&s, &sun, v3(2, 5, 3), v);
        expect_light(&s, &lamp, v3_sub(v3(2, 2, 3), s.point), v);
        expect_light(&s, &behind, v3(-4, -3, -7), v);
        free(s.fixture);
    }
}

/* Off the axis the viewer's direction differs, and a lamp's depends on where the pixel is. */
static void local_viewer_off_the_axis(void **state)
{
    struct shot s = shot_of(false);
    struct stp_light lamp = { .positional = true, .position = { 1, 2, 3 }, .color = { 1, 1, 1 } };
    s.fixture->radius[0] = 3;
    s.fixture->scene.lights[0] = lamp;
    for (int local = 0; local < 2; local++) {
        s.params.local_viewer = local;
        struct stp_image *image = render(s.fixture, &s.camera, &s.params);
        struct vec3 p =
            v3(value(image, "P.X", 2, 0), value(image, "P.Y", 2, 0), value(image, "P.Z", 2, 0));
        struct vec3 v = local ? v3_sub(s.eye, p) : s.axis;
        close_to(v3_dot(v3_sub(p, s.point), s.normal), 0, 1e-6); /* on the disc's plane */
        near_to(rgb(image, 2, 0),
                lit(v3(0.5, 0.25, 0.75), s.normal, v3_sub(v3(1, 2, 3), p), v, v3(1, 1, 1)), 2e-6);
        stp_image_destroy(&image);
    }
    free(s.fixture);
}

static void lights_add_up(void **state)
{
    struct shot s = shot_of(false);
    struct vec3 sum = v3(0, 0, 0);
    s.fixture->scene.light_count = 3;
    for (int i = 0; i < 3; i++) {
        struct stp_light light = { .direction = { i - 1, 1, 1 }, .color = { 1, (float)i, 0.5f } };
        s.fixture->scene.lights[i] = light;
        sum = v3_add(sum, lit(v3(0.5, 0.25, 0.75), s.normal, v3(i - 1, 1, 1), s.axis,
                              v3_loadf(light.color)));
    }
    struct stp_image *image = render(s.fixture, &s.camera, &s.params);
    near_to(rgb(image, 1, 1), sum, 1e-6);
    stp_image_destroy(&image);
    free(s.fixture);
}

/* The nearest splat's object names epsilon and material; albedo is each splat's own object's. */
static void several_objects(void **state)
{
    for (int nearer = 0; nearer < 2; nearer++) {
        struct fixture *f = fixture_create(0.1);
        struct stp_camera camera = flat_camera(1, 1, 1);
        struct stp_render_params params = exact_params();
        f->objects[1] = (struct scene_object){ .material = { .ambient = .5f,
                                                             .diffuse = .25f,
                                                             .shininess = 1,
                                                             .albedo = { .2f, .4f, .6f } },
                                               .epsilon = 1 };
        f->scene.splats.object = f->object;
        add_splat(f, v3(0, 0, -10), v3(0, 0, 1), 5);
        add_splat(f, v3(0, 0, -10.5), v3(0, 0, 1), 5);
        f->object[0] = (uint16_t)nearer;
        f->object[1] = (uint16_t)!nearer;
        struct stp_image *image = render(f, &camera, &params);
        struct vec3 expected = nearer ? v3(0.5 * 0.75, 0.6 * 0.75, 0.7 * 0.75) : v3(.84, .84, .84);
        assert_true(value(image, "fragments", 0, 0) == (nearer ? 2 : 1));
        near_to(rgb(image, 0, 0), expected, 1e-6);
        stp_image_destroy(&image);
        params.epsilon = 0.6; /* wins over the objects' own */
        image = render(f, &camera, &params);
        assert_true(value(image, "fragments", 0, 0) == 2);
        stp_image_destroy(&image);
        free(f);
    }
}

/* A step from depth 10 (left) to 12 (right): three of eight neighbours rise by log2 1.2. */
static void eye_dome(bool orthographic, uint32_t height)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera =
        orthographic ? flat_camera(15, height, 1) : plain_camera(15, height, 1);
    struct stp_render_params params = exact_params();
    uint32_t step = height < 1024 ? 1 : height / 512, y = height / 2;
    double rim = 1e7, edge = orthographic ? 0.5 : 5; /* pixel 8 is the first beyond the step */
    f->scene.facts.eye_dome = true;
    memcpy(f->scene.facts.bounds, (double[6]){ 0, 0, 0, 3, 4, 12 }, sizeof f->scene.facts.bounds);
    paint(f, add_splat(f, v3(edge - rim, 0, -10), v3(0, 0, 1), rim), 0.5f, 0.5f, 0.5f);
    paint(f, add_splat(f, v3(0, 0, -12), v3(0, 0, 1), rim), 0.25f, 0.5f, 0.75f);
    struct stp_image *image = render(f, &camera, &params);
    double rise = orthographic ? 2.0 / 13 * 16 : log2(1.2);
    double shade = exp(-8 * 3 * rise / 8);
    near_to(rgb(image, 7, y), v3(0.5, 0.5, 0.5), 1e-6); /* nothing is before it */
    near_to(rgb(image, 7 + step, y), v3_scale(v3(0.25, 0.5, 0.75), shade), 1e-6);
    near_to(rgb(image, 8 + step, y), v3(0.25, 0.5, 0.75), 1e-6);
    near_to(rgb(image, 7 + step, 0), v3_scale(v3(0.25, 0.5, 0.75), exp(-8 * 2 * rise / 8)), 1e-6);
    stp_image_destroy(&image);
    free(f);
}

static void eye_domes(void **state)
{
    eye_dome(false, 15);
    eye_dome(true, 15);
    eye_dome(true, 2048); /* neighbours are four pixels away */
}

static void background(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = flat_camera(8, 4, 1);
    struct stp_render_params params = exact_params();
    params.background = (const float[4]){ 0.25f, 0.5f, 4, 0.5f };
    params.samples = 4;
    add_splat(f, v3(-1e7 + 0.5, 0, -10), v3(0, 0, 1), 1e7); /* half of pixel 4 */
    struct stp_image *image = render(f, &camera, &params);
    double i = 0.8 * 0.8 + 0.2;
    near_to(rgb(image, 3, 1), v3(i, i, i), 1e-6);
    near_to(rgb(image, 4, 1), v3(i / 2 + 0.0625, i / 2 + 0.125, i / 2 + 1), 1e-6);
    near_to(rgb(image, 5, 1), v3(0.125, 0.25, 2), 1e-6);
    close_to(value(image, "A", 3, 1), 1, 0);
    close_to(value(image, "A", 4, 1), 0.75, 1e-7);
    close_to(value(image, "A", 5, 1), 0.5, 0);
    assert_true(value(image, "coverage", 4, 1) == 0.5f);
    assert_true(value(image, "Z", 5, 1) == INFINITY && value(image, "layers", 5, 1) == 0);
    stp_image_destroy(&image);
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_of_light), cmocka_unit_test(local_viewer_off_the_axis),
        cmocka_unit_test(lights_add_up),       cmocka_unit_test(several_objects),
        cmocka_unit_test(eye_domes),           cmocka_unit_test(background),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
