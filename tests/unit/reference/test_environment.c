/* The reference's environment against rays worked out here: a sphere whose true normal is known. */
#include "fixture.h"

#include "../../pass/surroundings.h"

#define PI   3.14159265358979323846
#define BALL 4000

static const struct vec3 ahead = { 0, 0, -5 };
static float ball_opacity[BALL];

/* Map coordinates of world (up y): right +x, up +y, centre -z. */
static struct vec3 sky_of(struct vec3 d)
{
    return smooth_sky(v3(d.x, d.y, -d.z));
}

/* Facts that a prepared scene has, for a fixture that is filled by hand. */
static void surround_fixture(struct fixture *f, const struct stp_environment_params *params)
{
    f->scene.facts.up = STP_UP_Y;
    surround(&f->scene, 512, 256, smooth_sky, params);
}

/* A sphere of radius 1, unlit: only what it mirrors and lets through is seen. */
static struct fixture *ball(struct vec3 centre, float opacity, const struct stp_optics *optics)
{
    struct fixture *f = fixture_create(0.02);
    f->objects[0].material = (struct stp_material){ .shininess = 1 };
    for (int i = 0; i < BALL; i++) {
        double z = 1 - (2 * i + 1) / (double)BALL, angle = i * 2.39996322972865332;
        struct vec3 n = v3(sqrt(1 - z * z) * cos(angle), sqrt(1 - z * z) * sin(angle), z);
        add_splat(f, v3_add(n, centre), n, 0.06);
        ball_opacity[i] = opacity;
    }
    f->scene.splats.opacity = opacity < 1 ? ball_opacity : NULL;
    f->scene.facts.transparent = opacity < 1;
    set_optics(&f->scene, 0, optics);
    surround_fixture(f, NULL);
    return f;
}

static void release_ball(struct fixture *f)
{
    environment_release(&f->scene.environment);
    free(f);
}

/* The true sphere's nearest hit on the ray of a pixel; false: it misses, or nearly. */
static bool sphere_hit(const struct stp_camera *c, struct vec3 centre, uint32_t x, uint32_t y,
                       struct vec3 *d, struct vec3 *n)
{
    *d = v3_unit(v3((x + 0.5 - c->cx) / c->fx, -(y + 0.5 - c->cy) / c->fy, -1));
    double along = v3_dot(*d, centre), d2 = v3_dot(centre, centre) - along * along;
    bool inside = v3_length(centre) < 1;
    if (d2 > 0.96 * 0.96)
        return false;
    double t = along + (inside ? sqrt(1 - d2) : -sqrt(1 - d2));
    *n = v3_unit(v3_sub(v3_scale(*d, t), centre));
    return true;
}

/* Fresnel's equations as a textbook writes them, by angles. */
static double fresnel(double n, double cosine)
{
    double i = acos(cosine), t = asin(fmin(1, sin(i) / n));
    if (sin(i) >= n)
        return 1;
    if (i < 1e-9)
        return (n - 1) * (n - 1) / ((n + 1) * (n + 1));
    double s = sin(i - t) / sin(i + t), p = tan(i - t) / tan(i + t);
    return (s * s + p * p) / 2;
}

static double worst_of(const struct stp_image *image, const struct stp_camera *camera,
                       const struct stp_optics *o)
{
    static const char *const names[] = { "R", "G", "B" };
    double worst = 0;
    for (uint32_t y = 0; y < camera->height; y++)
        for (uint32_t x = 0; x < camera->width; x++) {
            struct vec3 d, n;
            if (!sphere_hit(camera, ahead, x, y, &d, &n))
                continue;
            double cosine = -v3_dot(d, n);
            struct vec3 sky = sky_of(v3_add(d, v3_scale(n, 2 * cosine)));
            const double light[3] = { sky.x, sky.y, sky.z };
            for (int k = 0; k < 3; k++) {
                double r = (double)o->reflectance[k], critical = (double)o->ior[k];
                /* There the slope is infinite: a splat's normal is not true enough. */
                if (fabs(sqrt(1 - cosine * cosine) - critical) < 0.02)
                    continue;
                double f =
                    r > 0 ? r + (1 - r) * pow(1 - cosine, 5) : fresnel((double)o->ior[k], cosine);
                double seen = (double)value(image, names[k], x, y);
                worst = fmax(worst, fabs(seen - f * light[k]));
            }
        }
    return worst;
}

/* Splats are flat and overlap, so that their normals are off by a few thousandths of a radian. */
static void test_sphere(void **state)
{
    const struct stp_optics optics[] = { { .ior = { 1.5f, 1.33f, 2.4f } },
                                         { .ior = { 0.7f, 0.9f, 1.0001f } },
                                         { .reflectance = { 1, 0.5f, 0.04f } } };
    struct stp_camera camera = plain_camera(48, 48, 96);
    struct stp_render_params params = exact_params();
    params.cull = STP_CULL_BACK;
    for (int i = 0; i < 3; i++) {
        struct fixture *f = ball(ahead, 1, &optics[i]);
        struct stp_image *image = render(f, &camera, &params);
        double worst = worst_of(image, &camera, &optics[i]);
        if (!(worst < 0.03))
            fail_msg("optics %d: off by %g", i, worst);
        stp_image_destroy(&image);
        release_ball(f);
    }
}

/* ZP Eq. 12 by angles, one channel's index; `inside`: the eye is within the ball. */
static struct vec3 refract(struct vec3 d, struct vec3 n, double eta, double layers, bool inside)
{
    struct vec3 facing = inside ? v3_scale(n, -1) : n;
    double incidence = acos(fmin(1, -v3_dot(d, facing)));
    double sine = pow(eta, layers) * sin(incidence), angle = sine >= 1 ? PI / 2 : asin(sine);
    struct vec3 side = v3_unit(v3_add(d, v3_scale(facing, cos(incidence))));
    return v3_add(v3_scale(facing, -cos(angle)), v3_scale(side, sin(angle)));
}

struct glass_case {
    struct stp_optics optics;
    float opacity;
    bool single, inside;
};

/* What a pixel of the ball has to show in channel k. */
static double glass(const struct glass_case *c, struct vec3 d, struct vec3 n, double layers, int k,
                    bool *critical)
{
    double cosine = fabs(v3_dot(d, n)), ior = (double)c->optics.ior[k];
    double index = c->inside ? 1 / ior : ior, f = fresnel(index, cosine);
    struct vec3 sky = sky_of(v3_sub(d, v3_scale(n, 2 * v3_dot(d, n))));
    double bent = c->single ? 1 : layers, sine = sqrt(1 - cosine * cosine);
    struct vec3 seen = sky_of(refract(d, n, 1 / index, bent, c->inside));
    double absorbed = exp(-(double)c->optics.absorption[k] * (double)c->optics.thickness * bent);
    double through = pow(1 - (double)c->opacity, layers) * absorbed;
    const double mirrored[3] = { sky.x, sky.y, sky.z }, passed[3] = { seen.x, seen.y, seen.z };
    /* Where an angle reaches 90 degrees its slope is infinite, and a splat's normal not true
     * enough. */
    *critical = fabs(sine - index) < 0.03 || fabs(sine * pow(1 / index, bent) - 1) < 0.1;
    return f * mirrored[k] + (1 - f) * through * passed[k];
}

static void check_glass(const struct glass_case *c)
{
    static const char *const names[] = { "R", "G", "B" };
    struct vec3 centre = c->inside ? v3(0.4, 0.1, -0.2) : ahead;
    struct stp_camera camera = plain_camera(48, 48, c->inside ? 20 : 96);
    struct stp_render_params params = exact_params();
    struct fixture *f = ball(centre, c->opacity, &c->optics);
    params.layers = c->single ? STP_LAYERS_SINGLE : STP_LAYERS_MULTI;
    struct stp_image *image = render(f, &camera, &params);
    unsigned compared = 0;
    for (uint32_t y = 0; y < 48; y++)
        for (uint32_t x = 0; x < 48; x++) {
            struct vec3 d, n;
            if (!sphere_hit(&camera, centre, x, y, &d, &n))
                continue;
            double layers = (double)value(image, "layers", x, y);
            assert_true(value(image, "A", x, y) == 1);
            for (int k = 0; k < 3; k++) {
                bool critical;
                double truth = glass(c, d, n, layers, k, &critical);
                double seen = (double)value(image, names[k], x, y);
                compared += !critical;
                if (!critical && !(fabs(seen - truth) < 0.03))
                    fail_msg("ior %g, %s: %g is not %g at %u %u, %g layers",
                             (double)c->optics.ior[k], c->single ? "single" : "multi", seen, truth,
                             x, y, layers);
                assert_true(seen >= 0 && seen < 3);
            }
        }
    assert_true(compared > 900);
    stp_image_destroy(&image);
    release_ball(f);
}

/* Front and back are two layers; dispersion, absorption, from inside, total reflection. */
static void test_glass(void **state)
{
    const struct glass_case cases[] = {
        { { .ior = { 1.5f, 1.5f, 1.5f }, .thickness = 1 }, 0.3f, false, false },
        { { .ior = { 1.5f, 1.5f, 1.5f }, .thickness = 1 }, 0.3f, true, false },
        { { .ior = { 1.2f, 1.5f, 2.4f }, .absorption = { 0.1f, 1, 3 }, .thickness = 0.5f },
          1e-6f,
          false,
          false },
        { { .ior = { 1.2f, 1.5f, 2.4f }, .absorption = { 0.1f, 1, 3 }, .thickness = 0.5f },
          0.1f,
          true,
          false },
        { { .ior = { 0.75f, 0.9f, 1 }, .thickness = 1 }, 0.2f, false, false },
        { { .ior = { 1.5f, 1.33f, 1.1f }, .thickness = 1 }, 0.2f, false, true },
    };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++)
        check_glass(&cases[i]);
}

/* What is behind: every direction, turned and scaled. */
static void test_behind(void **state)
{
    const struct stp_environment_params around = { .rotation = 0.5 * PI, .intensity = 2 };
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(31, 21, 7);
    struct stp_render_params params = { .environment_behind = true };
    add_splat(f, v3(0, 0, 50), v3(0, 0, 1), 0.1);
    surround_fixture(f, &around);
    struct stp_image *image = render(f, &camera, &params);
    for (uint32_t y = 0; y < 21; y++)
        for (uint32_t x = 0; x < 31; x++) {
            struct vec3 d = v3_unit(v3((x + 0.5 - 15.5) / 7, -(y + 0.5 - 10.5) / 7, -1));
            /* Turned left by a quarter: what was on the right is ahead. */
            struct vec3 sky = sky_of(v3(-d.z, d.y, d.x));
            assert_float_equal(value(image, "R", x, y), 2 * sky.x, 1e-3);
            assert_float_equal(value(image, "G", x, y), 2 * sky.y, 1e-3);
            assert_float_equal(value(image, "B", x, y), 2 * sky.z, 1e-3);
            assert_true(value(image, "A", x, y) == 1 && isinf(value(image, "Z", x, y)));
        }
    stp_image_destroy(&image);
    environment_release(&f->scene.environment);
    free(f);
}

/* No environment: optics mean nothing, and asking for it behind is refused. */
static void test_none(void **state)
{
    struct fixture *f = ball(ahead, 1, &(struct stp_optics){ .reflectance = { 1, 1, 1 } });
    struct stp_camera camera = plain_camera(8, 8, 16);
    struct stp_render_params params = exact_params();
    struct stp_image *image = NULL;
    environment_release(&f->scene.environment);
    image = render(f, &camera, &params);
    assert_true(value(image, "R", 4, 4) == 0 && value(image, "A", 4, 4) == 1);
    stp_image_destroy(&image);
    params.environment_behind = true;
    struct stp_env env = { .threads = 1 };
    assert_int_equal(reference_render(&env, &f->scene, &camera, &params, &image),
                     STP_ERROR_ARGUMENT);
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_glass),
        cmocka_unit_test(test_behind),
        cmocka_unit_test(test_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
