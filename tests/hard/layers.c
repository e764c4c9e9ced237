/* Transparent layers: many, faint, unequal, from inside, at epsilon, too bright for half, of glass.
 * Depths, opacities and colours are such that what must come out is a formula. */
#include "ellipses.h"
#include "hard.h"
#include "surroundings.h"

#define EPSILON HARD_SHEETS_EPSILON

/* Discs face on, each as wide to the eye as the last: every pixel of the spot meets all of them. */
static void add_sheets(struct hard_points *cloud, size_t count, double first, double gap,
                       double opacity)
{
    for (size_t i = 0; i < count; i++) {
        double z = first + gap * (double)i;
        points_fade(cloud, points_add(cloud, v3(0, 0, -z), v3(0, 0, 1), 0.3 * z), opacity);
    }
}

static void show(const struct hard_options *o, struct hard_scene *s, struct hard_points *cloud,
                 uint32_t width, uint32_t height)
{
    s->scene = points_scene(cloud, EPSILON, 2);
    s->camera = plain_camera(width, height, 1.2 * height);
    s->params =
        (struct stp_render_params){ .min_splat = -1, .peel_layers = 400, .aovs = STP_AOV_LAYERS };
    points_release(cloud);
}

static void three_hundred(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(300);
    add_sheets(&cloud, 300, 4, 1.5 * EPSILON, 0.01);
    show(o, s, &cloud, 24, 18);
    s->truth[0] = 300;
    s->truth[1] = -expm1(300 * log1p(-(double)0.01f));
}

static void faint(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(8);
    add_sheets(&cloud, 4, 4, 1, 0);
    add_sheets(&cloud, 4, 4.5, 1, 1e-6);
    show(o, s, &cloud, o->width, o->height);
    s->truth[0] = 4;
    s->truth[1] = -expm1(4 * log1p(-(double)1e-6f));
}

static void before_a_wall(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(8);
    add_sheets(&cloud, 1, 4, 1, 0);
    add_sheets(&cloud, 3, 5, 1, 1e-6);
    add_sheets(&cloud, 1, 8, 1, 1);
    add_sheets(&cloud, 3, 9, 1, 0.5);
    show(o, s, &cloud, o->width, o->height);
    s->truth[0] = 4;
    s->truth[1] = 1;
}

/* Face on, under the head light, every layer is 0.8 * 0.8 + 0.2. The bound is what weights of 12
 * bits leave of a mean, 2^-12, and half a step of float32 beside 1. */
static double check_stack(const struct hard_scene *s, const struct stp_image *image)
{
    const struct stp_channel *layers = stp_image_find(image, "layers");
    double alpha = s->truth[1], bound = alpha * 2.5e-4 + 0x1p-25, worst = 0;
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t px = i % image->width, py = i / image->width;
        if (layers->data.f[i] == 0)
            continue;
        worst = fmax(worst, fabs(layers->data.f[i] - s->truth[0]) * 2);
        worst = fmax(worst, fabs(value(image, "A", px, py) - alpha) / bound);
        worst = fmax(worst, fabs(value(image, "R", px, py) - 0.84 * alpha) / bound);
    }
    return worst;
}

/* Two layers of 0.3 and 0.6, or one of their mean. */
static void two(const struct hard_options *o, struct hard_scene *s, double gap)
{
    struct hard_points cloud = hard_sheets_make(gap);
    for (size_t i = 0; i < cloud.count; i++)
        points_fade(&cloud, i, i < 30 ? 0.3 : 0.6);
    show(o, s, &cloud, o->width, o->height);
    s->camera = hard_sheets_camera(o);
    bool one = gap <= 1;
    s->truth[0] = one ? 1 : 2;
    s->truth[1] = one ? 0.45 : 1 - 0.7 * 0.4;
    s->truth[2] = one ? 0.45 * 0.6 : 0.3 * 0.2 + 0.7 * 0.6 * 1;
}

static void closer(const struct hard_options *o, struct hard_scene *s)
{
    two(o, s, 0.5);
}

static void at_epsilon(const struct hard_options *o, struct hard_scene *s)
{
    two(o, s, 1);
}

static void farther(const struct hard_options *o, struct hard_scene *s)
{
    two(o, s, 2);
}

/* As above, with green apart: 0.2 of light is the same in every channel. */
static double check_two(const struct hard_scene *s, const struct stp_image *image)
{
    const struct stp_channel *layers = stp_image_find(image, "layers");
    double worst = 0;
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t px = i % image->width, py = i / image->width;
        if (layers->data.f[i] == 0)
            continue;
        worst = fmax(worst, fabs(layers->data.f[i] - s->truth[0]) * 2);
        worst = fmax(worst, fabs(value(image, "A", px, py) - s->truth[1]) / 2.5e-4);
        worst = fmax(worst, fabs(value(image, "G", px, py) - s->truth[2]) / 2.5e-4);
    }
    return worst;
}

/* A ball whose opacities are anything, a tenth of them 1: opaque splats stand within its layers. */
static void varying(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    uint32_t seed = o->seed;
    for (size_t i = 0; i < cloud.count; i++) {
        double u = hard_random(&seed);
        points_fade(&cloud, i, u < 0.1 ? 0 : u < 0.2 ? 1e-6 : u < 0.9 ? u : 1);
    }
    s->scene = points_scene(&cloud, 0, 2);
    s->camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .min_splat = -1, .peel_layers = 400 };
    points_release(&cloud);
}

/* Ellipses with fields and lines, of any opacity. */
static void ellipses(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(60);
    uint32_t seed = o->seed;
    for (int i = 0; i < 60; i++) {
        double large = 0.6 * pow(10, -hard_random(&seed));
        size_t at = points_add(&cloud, random_point(&seed, 1), v3_unit(random_point(&seed, 1)), 1);
        struct stp_phong_splat *e =
            points_bend(&cloud, at, 7 * hard_random(&seed), large, large * hard_random(&seed));
        random_field(&seed, 0.8, e);
        random_clips(&seed, e);
        points_fade(&cloud, at, hard_random(&seed));
    }
    show(o, s, &cloud, o->width, o->height);
    s->camera = hard_look(o, v3(0, 0, 0), 5, 30);
}

/* The eye at the centre of a ball of 0.4: one layer wherever it looks. */
static void from_inside(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    for (size_t i = 0; i < cloud.count; i++)
        points_fade(&cloud, i, 0.4);
    s->scene = points_scene(&cloud, 0, 2);
    s->camera = hard_look(o, v3(0, 0, 0), 0.01, 100);
    s->camera.near_depth = 1e-3;
    s->params =
        (struct stp_render_params){ .min_splat = -1, .peel_layers = 8, .aovs = STP_AOV_LAYERS };
    points_release(&cloud);
}

static double check_inside(const struct hard_scene *s, const struct stp_image *image)
{
    double worst = 0;
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t px = i % image->width, py = i / image->width;
        worst = fmax(worst, fabs(value(image, "layers", px, py) - 1) * 2);
        worst = fmax(worst, fabs(value(image, "A", px, py) - 0.4) / 2.5e-4);
    }
    return worst;
}

/* Eight layers of 60000, and in each of them discs whose weights and opacities sum beyond 65504. */
static void bright(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(8 + 2000);
    for (size_t i = 0; i < 8 + 2000; i++) {
        double z = i < 8 ? 4 + (double)i : 12;
        size_t at = points_add(&cloud, v3(0, 0, -z), v3(0, 0, 1), (i < 8 ? 0.3 : 0.1) * z);
        points_paint(&cloud, at, v3(6e4, 6e4, 6e4));
        points_fade(&cloud, at, 0.9);
    }
    show(o, s, &cloud, 16, 12);
    s->truth[0] = 9;
}

/* Composited light never exceeds the brightest layer's; alpha is a product of 0.1. */
static double check_bright(const struct hard_scene *s, const struct stp_image *image)
{
    double worst = 0, most = 0.8 * 6e4 + 0.2;
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t px = i % image->width, py = i / image->width;
        double layers = value(image, "layers", px, py), alpha = 1 - pow(0.1, layers);
        if (layers == 0)
            continue;
        worst = fmax(worst, layers == 8 || layers == 9 ? 0 : 2);
        worst = fmax(worst, fabs(value(image, "A", px, py) - alpha) / 2.5e-4);
        worst = fmax(worst, fabs(value(image, "R", px, py) / most - alpha) / 2.5e-4);
    }
    return worst;
}

/* A ball of clear glass before a sky of 0.2 and more: at its outline refraction grazes. */
static void glass_ball(const struct hard_options *o, struct hard_scene *s, float ior, bool inside)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    const struct stp_optics optics = { .ior = { ior, 1.02f * ior, 1.04f * ior } };
    for (size_t i = 0; i < cloud.count; i++)
        points_fade(&cloud, i, 1e-6);
    s->scene = points_scene(&cloud, 0, 2);
    s->scene->facts.two_sided = false;
    set_optics(s->scene, 0, &optics);
    surround(s->scene, 64, 32, smooth_sky, NULL);
    s->camera = hard_look(o, v3(0, 0, 0), inside ? 0.3 : 4.6, inside ? 100 : 30);
    s->camera.near_depth = 1e-3;
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(&cloud);
}

static void grazing(const struct hard_options *o, struct hard_scene *s)
{
    glass_ball(o, s, 1.5f, false);
}

static void total_reflection(const struct hard_options *o, struct hard_scene *s)
{
    glass_ball(o, s, 0.6f, false);
}

static void within_glass(const struct hard_options *o, struct hard_scene *s)
{
    glass_ball(o, s, 1.5f, true);
}

/* Fresnel shares what is mirrored and what is bent: their sum is between the least and the most of
 * the sky, and nothing of it is lost. The layers themselves hide 1e-6. */
static double off_sky(const struct hard_scene *s, const struct stp_image *image, uint32_t px,
                      uint32_t py)
{
    static const char *const names[] = { "R", "G", "B" };
    static const double least[] = { 0.3, 0.8, 0.1 }, most[] = { 1.7, 1.3, 1.3 };
    double worst = value(image, "A", px, py) == 1 ? 0 : 2;
    for (int c = 0; c < 3; c++) {
        double v = value(image, names[c], px, py);
        worst = fmax(worst, fmax(least[c] / v, v / most[c]) - 1e-3);
    }
    return worst;
}

static double check_sky(const struct hard_scene *s, const struct stp_image *image)
{
    return hard_worst(s, image, off_sky);
}

/* What a ball of varying opacity is without a background comes back from it over two others. */
static void solve_back(const struct hard_options *o, struct device *device)
{
    static const float behind[2][4] = { { 1e4f, 1e4f, 1e4f, 1 }, { 0, 0, 0, 1 } };
    static const enum stp_transparency ways[] = { STP_TRANSPARENCY_EXACT,
                                                  STP_TRANSPARENCY_REFERENCE,
                                                  STP_TRANSPARENCY_PEEL };
    struct hard_scene s = { 0 };
    varying(o, &s);
    for (int w = 0; w < 3; w++) {
        struct stp_image *image[3] = { 0 };
        s.params.transparency = ways[w];
        for (int k = 0; k < 3; k++) {
            s.params.background = k < 2 ? behind[k] : NULL;
            image[k] = w == 1 ? hard_reference(s.scene, &s.camera, &s.params)
                              : device_render(device, s.scene, &s.camera, &s.params);
        }
        for (uint32_t i = 0; i < o->width * o->height; i++) {
            uint32_t px = i % o->width, py = i / o->width;
            double bare = value(image[2], "R", px, py), alpha = value(image[2], "A", px, py);
            double bright = value(image[0], "R", px, py), dark = value(image[1], "R", px, py);
            close_to(1 - (bright - dark) / 1e4, alpha, 1e-6);
            close_to(dark, bare, 1e-7);
            assert_true(value(image[0], "A", px, py) == 1);
        }
        for (int k = 0; k < 3; k++)
            stp_image_destroy(&image[k]);
    }
    stp_scene_destroy(&s.scene);
}

static const struct hard_case cases[] = {
    { "300 layers",
      "The closed form 1 - 0.99^300, and 300 layers counted: rays of more fragments than are kept "
      "are summed a layer at a time",
      three_hundred, check_stack, 0, 0, 0, 1, NULL, HARD_PYRAMID_POINTS },
    { "Opacities of 0 and 1e-6",
      "Four layers of 4e-6 together, known to 2.5e-4 of that; opacity 0 is not there", faint,
      check_stack, 0, 0, 0, 1, NULL, HARD_PYRAMID_POINTS },
    { "Opacities of 0, 1e-6 and 1",
      "Alpha is 1 exactly; what is behind the opaque layer does not count", before_a_wall,
      check_stack, 0, 0, 0, 1, NULL, HARD_PYRAMID_POINTS },
    { "Varying opacity", "To rounding of the reference, layer by layer", varying, NULL, 0, 0, 0, 0,
      NULL, HARD_PYRAMID_POINTS },
    { "Transparent ellipses", "To rounding: lines cut layers as they cut surfaces", ellipses, NULL,
      0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "A closed surface seen from inside", "One layer of 0.4 in every pixel, none lost",
      from_inside, check_inside, 0, 0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Transparent sheets half of epsilon apart",
      "One layer of the mean opacity: epsilon says that they are one surface", closer, check_two, 0,
      0, 0, 0, NULL, HARD_PYRAMID_POINTS },
    { "Transparent sheets at epsilon", "One layer: depth <= d + epsilon includes its end",
      at_epsilon, check_two, 0, 0, 0, 1, NULL, HARD_PYRAMID_POINTS },
    { "Transparent sheets two epsilon apart", "Two layers, composited", farther, check_two, 0, 0, 0,
      0, NULL, HARD_PYRAMID_POINTS },
    { "Layers too bright for half",
      "Light of 4.8e4 times alpha, from sums of 2e3 weights times 6e4: no Inf", bright,
      check_bright, 0, 0, 0, 1, NULL, HARD_PYRAMID_POINTS },
    { "Grazing refraction",
      "Between the least and the most of the sky, alpha 1: Fresnel loses nothing, no black rim",
      grazing, check_sky, 0, 0, 0, 0.1, NULL, HARD_PYRAMID_POINTS },
    { "Total reflection",
      "As above: beyond the critical angle all is mirrored, before it t is continuous; no black "
      "ring. There the "
      "mirrored share has an infinite slope: normals of 28 bits leave 70 dB",
      total_reflection, check_sky, 0, 0, 70, 0.1, NULL, HARD_PYRAMID_POINTS },
    { "Glass from inside", "As above, leaving the glass", within_glass, check_sky, 0, 0, 0, 0.1,
      NULL, HARD_PYRAMID_POINTS },
    { "Premultiplied over any background",
      "Composited over 1e4 and over black, alpha solves back to 1e-6 and colour to 1e-7, by exact, "
      "peeling and the reference",
      NULL, NULL, 0, 0, 0, 0, solve_back, HARD_PYRAMID_POINTS },
};
const struct hard_family hard_layers = { "layers", cases, sizeof cases / sizeof *cases };
