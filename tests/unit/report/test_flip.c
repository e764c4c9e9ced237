/* FLIP: known properties, and a direct two-dimensional evaluation of the published formulas. */
#include "pictures.h"

static double flip_of(struct stp_image *a, struct stp_image *b, double exposure, double degree,
                      unsigned threads)
{
    struct stp_env env = { .threads = threads };
    struct stp_compare_params params = { .exposure = exposure, .pixels_per_degree = degree };
    struct stp_comparison c;
    assert_int_equal(stp_compare(&env, a, b, &params, &c), STP_OK);
    return c.flip;
}

static double flip_grey(float a, float b, double exposure)
{
    struct stp_image *p = grey_picture(40, 30, a), *q = grey_picture(40, 30, b);
    double flip = flip_of(p, q, exposure, 0, 1);
    assert_true(flip_of(q, p, exposure, 0, 1) == flip);
    stp_image_destroy(&p);
    stp_image_destroy(&q);
    return flip;
}

/* L* differs by 100, largest HyAB (green, blue) is 203.3: 0.95 + 0.05 (25.12 - k) / (41.27 - k)
 * with k = 0.4 x 41.27. */
static void black_against_white(void **state)
{
    assert_true(fabs(flip_grey(0, 1, 0) - 0.9674) < 2e-4);
}

static void larger_differences_are_larger(void **state)
{
    double last = 0;
    for (int i = 1; i <= 10; i++) {
        double flip = flip_grey(0, 0.1f * (float)i, 0);
        assert_true(flip > last && flip <= 1);
        last = flip;
    }
}

static void exposure_comes_before_the_clamp(void **state)
{
    assert_true(flip_grey(0.25f, 0.5f, 1) == flip_grey(0.5f, 1, 0));
    assert_true(flip_grey(2, 3, 0) == 0); /* both clamp to white */
    assert_true(flip_grey(2, 3, -2) == flip_grey(0.5f, 0.75f, 0));
    assert_true(flip_grey(-1, 0, 0) == 0);
}

static struct stp_image *noise_picture(uint32_t width, uint32_t height, uint32_t seed)
{
    struct stp_image *image = grey_picture(width, height, 0);
    for (size_t i = 0; i < (size_t)width * height; i++) {
        float r = uniform(&seed), g = uniform(&seed);
        set_color(image, i, r, g, i % width < width / 2 ? uniform(&seed) : 0.1f);
    }
    return image;
}

static void threads_do_not_matter(void **state)
{
    struct stp_image *a = noise_picture(61, 57, 1), *b = noise_picture(61, 57, 2);
    double one = flip_of(a, b, 0, 0, 1);
    assert_true(one > 0 && one < 1);
    for (unsigned threads = 2; threads <= 5; threads++)
        assert_true(flip_of(a, b, 0, 0, threads) == one);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* The direct evaluation: whole kernels, one pixel at a time. */
#define W 22
#define H 17

struct direct {
    double y[H][W], cx[H][W], cz[H][W];
};

static const double white[3] = { 0.9504700, 1.0000001, 1.0888300 };

static void xyz_of(double r, double g, double b, double *x, double *y, double *z)
{
    *x = (0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / white[0];
    *y = (0.2126729 * r + 0.7151522 * g + 0.0721750 * b) / white[1];
    *z = (0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / white[2];
}

static void direct_load(struct stp_image *image, struct direct *d)
{
    for (int j = 0; j < H; j++)
        for (int i = 0; i < W; i++) {
            double x, y, z;
            int at = j * W + i;
            xyz_of(plane_of(image, "R")[at], plane_of(image, "G")[at], plane_of(image, "B")[at], &x,
                   &y, &z);
            d->y[j][i] = 116 * y - 16;
            d->cx[j][i] = 500 * (x - y);
            d->cz[j][i] = 200 * (y - z);
        }
}

static double at(const double plane[H][W], int j, int i)
{
    j = j < 0 ? 0 : j >= H ? H - 1 : j;
    i = i < 0 ? 0 : i >= W ? W - 1 : i;
    return plane[j][i];
}

static double sensitivity(const double plane[H][W], int j, int i, double ppd, double a1, double b1,
                          double a2, double b2)
{
    int radius = (int)ceil(3 * sqrt(0.04 / (2 * M_PI * M_PI)) * ppd);
    double sum = 0, total = 0;
    for (int v = -radius; v <= radius; v++)
        for (int u = -radius; u <= radius; u++) {
            double d2 = (u * u + v * v) / (ppd * ppd);
            double w = a1 * sqrt(M_PI / b1) * exp(-M_PI * M_PI * d2 / b1) +
                       a2 * sqrt(M_PI / b2) * exp(-M_PI * M_PI * d2 / b2);
            sum += w * at(plane, j + v, i + u);
            total += w;
        }
    return sum / total;
}

/* Detector of order 1 or 2 along x (or y), over (Y + 16) / 116. */
static double detector(const double plane[H][W], int j, int i, double ppd, int order, bool along_y)
{
    double s = 0.5 * 0.082 * ppd, positive = 0, negative = 0, plus = 0, minus = 0;
    int radius = (int)ceil(3 * s);
    for (int v = -radius; v <= radius; v++)
        for (int u = -radius; u <= radius; u++) {
            double x = along_y ? v : u, g = exp(-(u * u + v * v) / (2 * s * s));
            double w = order == 1 ? -x * g : (x * x / (s * s) - 1) * g;
            double value = (at(plane, j + v, i + u) + 16) / 116;
            if (w > 0) {
                positive += w * value;
                plus += w;
            } else {
                negative += w * value;
                minus -= w;
            }
        }
    return positive / plus + negative / minus;
}

static double curve(double t)
{
    return t > pow(6.0 / 29, 3) ? cbrt(t) : t / (3 * pow(6.0 / 29, 2)) + 4.0 / 29;
}

static void hunt(double r, double g, double b, double out[3])
{
    double x, y, z;
    xyz_of(r, g, b, &x, &y, &z);
    out[0] = 116 * curve(y) - 16;
    out[1] = 0.01 * out[0] * 500 * (curve(x) - curve(y));
    out[2] = 0.01 * out[0] * 200 * (curve(y) - curve(z));
}

static double clamp01(double v)
{
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

static void direct_color(const struct direct *d, int j, int i, double ppd, double out[3])
{
    double y = (sensitivity(d->y, j, i, ppd, 1, 0.0047, 0, 1e-5) + 16) / 116;
    double x = (y + sensitivity(d->cx, j, i, ppd, 1, 0.0053, 0, 1e-5) / 500) * white[0];
    double z = (y - sensitivity(d->cz, j, i, ppd, 34.1, 0.04, 13.5, 0.025) / 200) * white[2];
    y *= white[1];
    hunt(clamp01(3.2404542 * x - 1.5371385 * y - 0.4985314 * z),
         clamp01(-0.9692660 * x + 1.8760108 * y + 0.0415560 * z),
         clamp01(0.0556434 * x - 0.2040259 * y + 1.0572252 * z), out);
}

static double hyab(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

static double direct_pixel(const struct direct *a, const struct direct *b, int j, int i, double ppd)
{
    double p[3], q[3], green[3], blue[3], feature = 0;
    direct_color(a, j, i, ppd, p);
    direct_color(b, j, i, ppd, q);
    hunt(0, 1, 0, green);
    hunt(0, 0, 1, blue);
    double largest = pow(hyab(green, blue), 0.7), e = pow(hyab(p, q), 0.7), knee = 0.4 * largest;
    e = e < knee ? e * 0.95 / knee : 0.95 + 0.05 * (e - knee) / (largest - knee);
    for (int order = 1; order <= 2; order++) {
        double fa =
            hypot(detector(a->y, j, i, ppd, order, false), detector(a->y, j, i, ppd, order, true));
        double fb =
            hypot(detector(b->y, j, i, ppd, order, false), detector(b->y, j, i, ppd, order, true));
        feature = fmax(feature, fabs(fa - fb));
    }
    return pow(e, 1 - sqrt(feature / sqrt(2)));
}

static void agrees_with_direct_evaluation(void **state)
{
    static const double degrees[3] = { 67, 25, 8 };
    static struct direct p, q;
    struct stp_image *a = noise_picture(W, H, 3), *b = noise_picture(W, H, 4);
    for (int i = W * 5; i < W * 9; i++) /* a bar, so that features are strong */
        set_color(b, (size_t)i, 1, 1, 1);
    direct_load(a, &p);
    direct_load(b, &q);
    for (int k = 0; k < 3; k++) {
        double sum = 0;
        for (int j = 0; j < H; j++)
            for (int i = 0; i < W; i++)
                sum += direct_pixel(&p, &q, j, i, degrees[k]);
        assert_true(fabs(flip_of(a, b, 0, degrees[k], 2) - sum / (W * H)) < 2e-6);
    }
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(black_against_white),
        cmocka_unit_test(larger_differences_are_larger),
        cmocka_unit_test(exposure_comes_before_the_clamp),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(agrees_with_direct_evaluation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
