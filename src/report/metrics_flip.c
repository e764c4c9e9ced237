/* LDR-FLIP: P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson, K. Astrom, M. Fairchild,
 * "FLIP: A Difference Evaluator for Alternating Images", HPG 2020. Symbols are the paper's. All
 * of its filters are sums of products of one-dimensional ones, and are run as such. */
#include "report/metrics.h"

#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

#define MAX_RADIUS 160 /* pixels; holds every filter at 1000 pixels per degree */
#define PLANES     (2 + 3 + 2 * 5)

/* Linear Rec.709 to XYZ. The white is its image of (1, 1, 1), so that greys are exactly grey. */
static const double xyz_of_rgb[3][3] = { { 0.4124564, 0.3575761, 0.1804375 },
                                         { 0.2126729, 0.7151522, 0.0721750 },
                                         { 0.0193339, 0.1191920, 0.9503041 } };
static const double rgb_of_xyz[3][3] = { { 3.2404542, -1.5371385, -0.4985314 },
                                         { -0.9692660, 1.8760108, 0.0415560 },
                                         { 0.0556434, -0.2040259, 1.0572252 } };

struct kernel {
    int radius;
    double weight[2 * MAX_RADIUS + 1];
};

/* One picture on its way: opponent colours Y Cx Cz, the same filtered, and features of Y. */
struct seen {
    float *opponent[3], *color[3], *edge, *point;
};

struct flip {
    const struct stp_env *env;
    uint32_t width, height;
    double scale, pixels_per_degree;
    float *planes; /* all below are in here */
    struct seen seen[2];
    float *temporary[2];
    double *row; /* sums of rows */
};

static void transform(const double m[3][3], const double in[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * in[0] + m[i][1] * in[1] + m[i][2] * in[2];
}

static double white(int i)
{
    return xyz_of_rgb[i][0] + xyz_of_rgb[i][1] + xyz_of_rgb[i][2];
}

static void opponent_of_rgb(const double rgb[3], double out[3])
{
    double xyz[3];
    transform(xyz_of_rgb, rgb, xyz);
    double x = xyz[0] / white(0), y = xyz[1] / white(1), z = xyz[2] / white(2);
    out[0] = 116 * y - 16;
    out[1] = 500 * (x - y);
    out[2] = 200 * (y - z);
}

static void rgb_of_opponent(const double opponent[3], double rgb[3])
{
    double y = (opponent[0] + 16) / 116;
    double xyz[3] = { (y + opponent[1] / 500) * white(0), y * white(1),
                      (y - opponent[2] / 200) * white(2) };
    transform(rgb_of_xyz, xyz, rgb);
    for (int i = 0; i < 3; i++)
        rgb[i] = fmin(fmax(rgb[i], 0), 1);
}

static double lab_curve(double t)
{
    return t > 216.0 / 24389 ? cbrt(t) : t * (841.0 / 108) + 4.0 / 29;
}

/* CIE L*a*b*, its chroma scaled by lightness (Hunt). */
static void hunt_of_rgb(const double rgb[3], double out[3])
{
    double xyz[3];
    transform(xyz_of_rgb, rgb, xyz);
    double x = lab_curve(xyz[0] / white(0)), y = lab_curve(xyz[1] / white(1)),
           z = lab_curve(xyz[2] / white(2));
    out[0] = 116 * y - 16;
    out[1] = 0.01 * out[0] * 500 * (x - y);
    out[2] = 0.01 * out[0] * 200 * (y - z);
}

static double hyab(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

/* The largest colour difference there is: green against blue. */
static double largest_difference(void)
{
    static const double green[3] = { 0, 1, 0 }, blue[3] = { 0, 0, 1 };
    double a[3], b[3];
    hunt_of_rgb(green, a);
    hunt_of_rgb(blue, b);
    return pow(hyab(a, b), 0.7);
}

/* Colour error in [0, 1]: most of the range to small errors. */
static double redistribute(double difference, double largest)
{
    double e = pow(difference, 0.7), knee = 0.4 * largest;
    if (e < knee)
        return 0.95 / knee * e;
    return 0.95 + (e - knee) / (largest - knee) * 0.05;
}

static struct kernel gaussian(double variance, int radius)
{
    struct kernel k = { .radius = radius };
    double sum = 0;
    for (int i = -radius; i <= radius; i++)
        sum += k.weight[i + radius] = exp(-(double)i * i / (2 * variance));
    for (int i = 0; i <= 2 * radius; i++)
        k.weight[i] /= sum;
    return k;
}

/* First or second derivative of a Gaussian; its positive weights sum to 1, its negative to -1. */
static struct kernel derivative(double variance, int radius, int order)
{
    struct kernel k = { .radius = radius };
    double sum[2] = { 0, 0 };
    for (int i = -radius; i <= radius; i++) {
        double x = i, g = exp(-x * x / (2 * variance));
        double w = order == 1 ? -x * g : (x * x / variance - 1) * g;
        k.weight[i + radius] = w;
        sum[w > 0] += fabs(w);
    }
    for (int i = 0; i <= 2 * radius; i++)
        k.weight[i] /= sum[k.weight[i] > 0];
    return k;
}

struct convolution {
    const struct kernel *kernel;
    const float *source;
    float *target;
    uint32_t width, height;
    bool vertical;
};

static uint32_t clamped(int64_t i, uint32_t size)
{
    return i < 0 ? 0 : i >= size ? size - 1 : (uint32_t)i;
}

static void convolve_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct convolution *c = context;
    int radius = c->kernel->radius;
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < c->width; x++) {
            double sum = 0;
            for (int i = -radius; i <= radius; i++) {
                size_t row = c->vertical ? clamped((int64_t)y + i, c->height) : y;
                size_t column = c->vertical ? x : clamped((int64_t)x + i, c->width);
                sum += c->kernel->weight[i + radius] * c->source[row * c->width + column];
            }
            c->target[y * c->width + x] = (float)sum;
        }
}

/* target = source * across * down; beyond the border the border repeats. */
static void convolve(const struct flip *flip, const struct kernel *across,
                     const struct kernel *down, const float *source, float *target)
{
    struct convolution c = { across, source, flip->temporary[0], flip->width, flip->height, false };
    parallel_for(flip->env, flip->height, 16, convolve_rows, &c);
    c = (struct convolution){ down, c.target, target, flip->width, flip->height, true };
    parallel_for(flip->env, flip->height, 16, convolve_rows, &c);
}

static void blend(const struct flip *flip, double part, float *a, const float *b)
{
    for (size_t i = 0; i < (size_t)flip->width * flip->height; i++)
        a[i] = (float)(part * a[i] + (1 - part) * b[i]);
}

/* Contrast sensitivity: Gaussians of exp(-pi^2 x^2 / b), x in degrees. */
static void filter_colors(const struct flip *flip, struct seen *seen)
{
    static const double b[4] = { 0.0047, 0.0053, 0.04, 0.025 }; /* Y, Cx, and two of Cz */
    static const double amount[2] = { 34.1, 13.5 };
    struct kernel g[4];
    double share[2], ppd = flip->pixels_per_degree;
    int radius = (int)ceil(3 * sqrt(b[2] / 2) / M_PI * ppd);
    for (int i = 0; i < 4; i++)
        g[i] = gaussian(b[i] * ppd * ppd / (2 * M_PI * M_PI), radius);
    for (int i = 0; i < 2; i++) { /* weights before g was normalised; its peak was 1 */
        double peak = g[2 + i].weight[radius];
        share[i] = amount[i] * sqrt(M_PI / b[2 + i]) / (peak * peak);
    }
    for (int i = 0; i < 3; i++)
        convolve(flip, &g[i], &g[i], seen->opponent[i], seen->color[i]);
    convolve(flip, &g[3], &g[3], seen->opponent[2], flip->temporary[1]);
    blend(flip, share[0] / (share[0] + share[1]), seen->color[2], flip->temporary[1]);
}

static void magnitude(const struct flip *flip, float *a, const float *b)
{
    for (size_t i = 0; i < (size_t)flip->width * flip->height; i++)
        a[i] = (float)hypot(a[i], b[i]);
}

/* Edges and points of the achromatic channel, which is left scaled to [0, 1]. */
static void detect_features(const struct flip *flip, struct seen *seen)
{
    double sigma = 0.5 * 0.082 * flip->pixels_per_degree;
    int radius = (int)ceil(3 * sigma);
    float *luminance = seen->opponent[0];
    struct kernel g = gaussian(sigma * sigma, radius);
    for (size_t i = 0; i < (size_t)flip->width * flip->height; i++)
        luminance[i] = (luminance[i] + 16) / 116;
    for (int order = 1; order <= 2; order++) {
        struct kernel d = derivative(sigma * sigma, radius, order);
        float *feature = order == 1 ? seen->edge : seen->point;
        convolve(flip, &d, &g, luminance, feature);
        convolve(flip, &g, &d, luminance, flip->temporary[1]);
        magnitude(flip, feature, flip->temporary[1]);
    }
}

static void load(const struct flip *flip, const float *const rgb[3], struct seen *seen)
{
    for (size_t i = 0; i < (size_t)flip->width * flip->height; i++) {
        double in[3], out[3];
        for (int k = 0; k < 3; k++)
            in[k] = fmin(fmax(rgb[k][i] * flip->scale, 0), 1);
        opponent_of_rgb(in, out);
        for (int k = 0; k < 3; k++)
            seen->opponent[k][i] = (float)out[k];
    }
}

static void adjusted(const struct seen *seen, size_t i, double out[3])
{
    double opponent[3] = { seen->color[0][i], seen->color[1][i], seen->color[2][i] }, rgb[3];
    rgb_of_opponent(opponent, rgb);
    hunt_of_rgb(rgb, out);
}

static double flip_pixel(const struct flip *flip, size_t i, double largest)
{
    const struct seen *a = &flip->seen[0], *b = &flip->seen[1];
    double color[2][3];
    adjusted(a, i, color[0]);
    adjusted(b, i, color[1]);
    double colors = redistribute(hyab(color[0], color[1]), largest);
    double edge = fabs((double)a->edge[i] - b->edge[i]);
    double point = fabs((double)a->point[i] - b->point[i]);
    double features = fmin(1, sqrt(fmax(edge, point) / M_SQRT2));
    return pow(colors, 1 - features);
}

static void sum_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct flip *flip = context;
    double largest = largest_difference();
    for (size_t y = begin; y < end; y++) {
        flip->row[y] = 0;
        for (uint32_t x = 0; x < flip->width; x++)
            flip->row[y] += flip_pixel(flip, y * flip->width + x, largest);
    }
}

/* Opponent colours and features are shared: only what the last step reads is kept twice. */
static void lay_out(struct flip *flip)
{
    size_t pixels = (size_t)flip->width * flip->height;
    float *next = flip->planes;
    for (int i = 0; i < 2; i++, next += pixels)
        flip->temporary[i] = next;
    for (int i = 0; i < 3; i++, next += pixels)
        flip->seen[0].opponent[i] = flip->seen[1].opponent[i] = next;
    for (int s = 0; s < 2; s++) {
        for (int i = 0; i < 3; i++, next += pixels)
            flip->seen[s].color[i] = next;
        flip->seen[s].edge = next;
        flip->seen[s].point = next + pixels;
        next += 2 * pixels;
    }
}
static double run(struct flip *flip, const struct color_pair *pair)
{
    double sum = 0;
    lay_out(flip);
    for (int s = 0; s < 2; s++) {
        load(flip, s == 0 ? pair->image : pair->reference, &flip->seen[s]);
        filter_colors(flip, &flip->seen[s]);
        detect_features(flip, &flip->seen[s]);
    }
    parallel_for(flip->env, flip->height, 16, sum_rows, flip);
    for (uint32_t y = 0; y < flip->height; y++)
        sum += flip->row[y];
    return sum / ((double)flip->width * flip->height);
}

enum stp_result flip_mean(const struct stp_env *env, const struct color_pair *pair, double exposure,
                          double pixels_per_degree, double *mean)
{
    size_t pixels = (size_t)pair->width * pair->height;
    struct flip flip = { .env = env,
                         .width = pair->width,
                         .height = pair->height,
                         .scale = exp2(exposure),
                         .pixels_per_degree = pixels_per_degree };
    flip.planes = mem_alloc(pixels, PLANES * sizeof *flip.planes);
    flip.row = mem_alloc(pair->height, sizeof *flip.row);
    bool whole = flip.planes && flip.row;
    if (whole)
        *mean = run(&flip, pair);
    mem_free(flip.planes);
    mem_free(flip.row);
    return whole ? STP_OK : log_no_memory(env, pixels * PLANES * sizeof(float), "FLIP");
}
