/* Weights and colours at the ends of what formats hold. */
#include "hard.h"

#include <unistd.h>

/* Discs of 8000 pixels whose rims cross the picture: a pixel inside a rim weighs 2.5e-4, and what
 * is within a quarter of one less than the smallest normal half. */
static void rims(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(12);
    double focal = o->height, r = 8000 / focal;
    for (int i = 0; i < 12; i++) {
        double turn = i * M_PI / 6 + 0.2;
        struct vec3 u = v3(cos(turn), sin(turn), 0);
        struct vec3 p = v3_sub(v3_scale(u, (0.02 + 0.01 * i) - r), v3(0, 0, 1 + 1e-3 * i));
        size_t at = points_add(&cloud, p, v3(0, 0, 1), r);
        points_paint(&cloud, at, v3(i % 2, i % 3 / 2.0, 1 - i / 12.0));
    }
    s->scene = points_scene(&cloud, 1, 2);
    s->camera = plain_camera(o->width, o->height, focal);
    s->params = (struct stp_render_params){ .min_splat = -1, .aovs = STP_AOV_ALBEDO };
    points_release(&cloud);
}

/* All normals are the same and colours lie in [0, 1]: an average of them does too, whatever the
 * weights. 1e-4: rounding. */
static double off_rim(const struct hard_scene *s, const struct stp_image *image, uint32_t px,
                      uint32_t py)
{
    double r = value(image, "albedo.R", px, py), g = value(image, "albedo.G", px, py);
    double out = fmax(fmax(-r, r - 1), fmax(-g, g - 1));
    return fmax(out, fabs(value(image, "N.Z", px, py) - 1)) / 1e-4;
}

static double check_rims(const struct hard_scene *s, const struct stp_image *image)
{
    return hard_worst(s, image, off_rim);
}

static void bright(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0.15);
    uint32_t seed = o->seed;
    for (size_t i = 0; i < cloud.count; i++) {
        double scale = i % 3 == 0 ? 65504 : i % 3 == 1 ? 1e6 : 1;
        points_paint(&cloud, i, v3(scale, scale * hard_random(&seed), 0.25));
    }
    hard_show_ball(o, s, &cloud);
}

/* Written as halves and read back: what is above 65504 is 65504, what is below as halves round. */
static double check_half(const struct hard_scene *s, const struct stp_image *image)
{
    char path[] = "/tmp/stipple-half-XXXXXX";
    struct stp_image *back = NULL;
    struct stp_channel *r = stp_image_find(image, "R");
    double worst = 0;
    int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    r->half = true;
    assert_int_equal(stp_image_write_exr(NULL, image, path, NULL), STP_OK);
    r->half = false;
    assert_int_equal(stp_image_read_exr(NULL, path, &back), STP_OK);
    unlink(path);
    const float *half = stp_image_find(back, "R")->data.f;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++) {
        double right = fmin(r->data.f[i], 65504);
        worst = fmax(worst, fabs(half[i] - right) / fmax(right * 0x1p-11, 0x1p-25));
    }
    stp_image_destroy(&back);
    return worst;
}

static const struct hard_case cases[] = {
    { "Weights that underflow in half",
      "Averages stay within what is averaged, to rounding; by packed keys, whose weights are 12 "
      "bits, "
      "a weight of 1e-2 is known to 1 % and the picture to 40 dB",
      rims, check_rims, 0, 0, 40, 0.5, NULL, HARD_PYRAMID_POINTS },
    { "Colours to 65504 and above",
      "To rounding; by packed keys a weight's 2^-13 of a neighbour 10^6 times as bright remains: "
      "60 "
      "dB. Written as half they are clamped to 65504, never Inf",
      bright, check_half, 25, 0, 60, 0, NULL, HARD_PYRAMID_SURFACE },
};
const struct hard_family hard_colors = { "colors", cases, sizeof cases / sizeof *cases };
