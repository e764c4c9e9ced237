/* stp_compare: every metric of docs/accuracy.md. Sums run over pixels in order on one thread, so
 * that they never depend on the number of threads. */
#include "report/metrics.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

#define DEFAULT_PIXELS_PER_DEGREE 67

/* Planes that only one picture has are NULL in both. */
struct pair {
    size_t pixels;
    struct color_pair color;
    const float *alpha[2], *depth[2], *normal[2][3];
    double epsilon;  /* unit of depth errors */
    double *scratch; /* one value a pixel */
};

static const float *plane(const struct stp_image *image, const char *name)
{
    const struct stp_channel *channel = stp_image_find(image, name);
    return channel && channel->type == STP_CHANNEL_FLOAT ? channel->data.f : NULL;
}

static bool both(const struct stp_image *image, const struct stp_image *reference, const char *name,
                 const float **a, const float **b)
{
    *a = plane(image, name);
    *b = plane(reference, name);
    if (!*a || !*b)
        *a = *b = NULL;
    return *a;
}

static enum stp_result take_color(const struct stp_env *env, const struct stp_image *image,
                                  const struct stp_image *reference, struct color_pair *color)
{
    static const char *const name[3] = { "R", "G", "B" };
    color->width = image->width;
    color->height = image->height;
    for (int i = 0; i < 3; i++)
        if (!both(image, reference, name[i], &color->image[i], &color->reference[i]))
            return log_error(env, STP_ERROR_FORMAT, "%s: no float channel %s",
                             plane(image, name[i]) ? "reference" : "picture", name[i]);
    return STP_OK;
}

static void take_others(const struct stp_image *image, const struct stp_image *reference,
                        struct pair *pair)
{
    static const char *const name[3] = { "N.X", "N.Y", "N.Z" };
    both(image, reference, "A", &pair->alpha[0], &pair->alpha[1]);
    both(image, reference, "Z", &pair->depth[0], &pair->depth[1]);
    bool has = true;
    for (int i = 0; i < 3; i++)
        has = both(image, reference, name[i], &pair->normal[0][i], &pair->normal[1][i]) && has;
    if (!has)
        pair->normal[0][0] = NULL;
}

/* Without alpha in both, everything counts as covered. */
static bool covered(const struct pair *pair, size_t i)
{
    return !pair->alpha[0] || pair->alpha[0][i] > 0 || pair->alpha[1][i] > 0;
}

static double difference(const struct color_pair *color, int channel, size_t i)
{
    return fabs((double)color->image[channel][i] - color->reference[channel][i]);
}

static struct stp_color_error compare_color(const struct pair *pair, bool only_covered)
{
    struct stp_color_error e = { 0 };
    struct samples worst = { pair->scratch, 0 };
    double absolute = 0, square = 0;
    uint64_t over1 = 0, over8 = 0;
    for (size_t i = 0; i < pair->pixels; i++) {
        double max = 0;
        if (only_covered && !covered(pair, i))
            continue;
        for (int c = 0; c < 3; c++) {
            double d = difference(&pair->color, c, i);
            absolute += d;
            square += d * d;
            max = fmax(max, d);
        }
        over1 += max > 1.0 / 255;
        over8 += max > 8.0 / 255;
        worst.value[worst.count++] = max;
    }
    double n = worst.count ? (double)worst.count : 1, mean_square = square / (3 * n);
    e.pixels = worst.count;
    e.mean_absolute = absolute / (3 * n);
    e.rmse = sqrt(mean_square);
    e.psnr = mean_square > 0 ? -10 * log10(mean_square) : INFINITY;
    e.p999 = samples_permille(&worst, 999);
    e.maximum = samples_max(&worst);
    e.over_1_255 = (double)over1 / n;
    e.over_8_255 = (double)over8 / n;
    return e;
}

/* One is covered and the other is not, or one has a depth and the other has none. */
static void compare_coverage(const struct pair *pair, struct stp_comparison *c)
{
    for (size_t i = 0; i < pair->pixels; i++) {
        bool differs = false;
        if (pair->alpha[0]) {
            double d = fabs((double)pair->alpha[0][i] - pair->alpha[1][i]);
            c->alpha_max = fmax(c->alpha_max, d);
            differs = (pair->alpha[0][i] > 0) != (pair->alpha[1][i] > 0);
        }
        if (pair->depth[0])
            differs |= isinf(pair->depth[0][i]) != isinf(pair->depth[1][i]);
        c->coverage_differs += differs;
    }
}

static void compare_depth(const struct pair *pair, struct stp_comparison *c)
{
    struct samples error = { pair->scratch, 0 };
    for (size_t i = 0; pair->depth[0] && i < pair->pixels; i++) {
        double a = pair->depth[0][i], b = pair->depth[1][i];
        if (isfinite(a) && isfinite(b))
            error.value[error.count++] = fabs(a - b) / pair->epsilon;
    }
    c->depth_mean = samples_mean(&error);
    c->depth_p999 = samples_permille(&error, 999);
    c->depth_max = samples_max(&error);
}

/* Degrees; the arc tangent keeps its digits at small angles, where the arc cosine has none. */
static double angle(const double a[3], const double b[3])
{
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2],
           z = a[0] * b[1] - a[1] * b[0];
    double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    return atan2(sqrt(x * x + y * y + z * z), dot) * (180 / M_PI);
}

static void compare_normals(const struct pair *pair, struct stp_comparison *c)
{
    struct samples error = { pair->scratch, 0 };
    for (size_t i = 0; pair->normal[0][0] && i < pair->pixels; i++) {
        double n[2][3];
        for (int k = 0; k < 6; k++)
            n[k / 3][k % 3] = pair->normal[k / 3][k % 3][i];
        if ((n[0][0] != 0 || n[0][1] != 0 || n[0][2] != 0) &&
            (n[1][0] != 0 || n[1][1] != 0 || n[1][2] != 0))
            error.value[error.count++] = angle(n[0], n[1]);
    }
    c->normal_mean = samples_mean(&error);
    c->normal_p99 = samples_permille(&error, 990);
    c->normal_max = samples_max(&error);
}

static enum stp_result compare_pair(const struct stp_env *env, struct pair *pair,
                                    const struct stp_compare_params *params,
                                    struct stp_comparison *comparison)
{
    struct stp_comparison c = { 0 };
    double degree = params->pixels_per_degree;
    pair->scratch = mem_alloc(pair->pixels, sizeof *pair->scratch);
    if (!pair->scratch)
        return log_no_memory(env, pair->pixels * sizeof *pair->scratch, "comparing pictures");
    c.covered = compare_color(pair, true);
    c.all = compare_color(pair, false);
    compare_coverage(pair, &c);
    compare_depth(pair, &c);
    compare_normals(pair, &c);
    mem_free(pair->scratch);
    enum stp_result result = flip_mean(env, &pair->color, params->exposure,
                                       degree > 0 ? degree : DEFAULT_PIXELS_PER_DEGREE, &c.flip);
    if (result == STP_OK)
        *comparison = c;
    return result;
}

static enum stp_result check(const struct stp_env *env, const struct stp_image *image,
                             const struct stp_image *reference,
                             const struct stp_compare_params *params)
{
    if (image->width != reference->width || image->height != reference->height)
        return log_error(env, STP_ERROR_ARGUMENT, "the picture is %ux%u, the reference %ux%u",
                         image->width, image->height, reference->width, reference->height);
    if (!(params->epsilon >= 0 && isfinite(params->epsilon)) || !isfinite(params->exposure) ||
        (params->pixels_per_degree != 0 &&
         !(params->pixels_per_degree >= 1 && params->pixels_per_degree <= 1000)))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "epsilon %g, exposure %g or pixels per degree %g is out of range",
                         params->epsilon, params->exposure, params->pixels_per_degree);
    return STP_OK;
}

static enum stp_result check_plane(const struct stp_env *env, const struct pair *pair,
                                   const float *value, const char *which, const char *name)
{
    bool depth = strcmp(name, "Z") == 0;
    size_t width = pair->color.width;
    for (size_t i = 0; value && i < pair->pixels; i++)
        if (!isfinite(value[i]) && !(depth && value[i] == INFINITY))
            return log_error(env, STP_ERROR_FORMAT, "%s: channel %s is %f at pixel (%zu, %zu)",
                             which, name, (double)value[i], i % width, i / width);
    return STP_OK;
}

/* Of what is compared, every value counts. */
static enum stp_result check_planes(const struct stp_env *env, const struct pair *pair)
{
    static const char *const which[2] = { "picture", "reference" };
    const bool normals = pair->normal[0][0];
    enum stp_result result = STP_OK;
    for (int k = 0; k < 2; k++) {
        const float *const *color = k ? pair->color.reference : pair->color.image;
        const struct {
            const char *name;
            const float *value;
        } planes[] = {
            { "R", color[0] },
            { "G", color[1] },
            { "B", color[2] },
            { "A", pair->alpha[k] },
            { "Z", pair->depth[k] },
            { "N.X", normals ? pair->normal[k][0] : NULL },
            { "N.Y", normals ? pair->normal[k][1] : NULL },
            { "N.Z", normals ? pair->normal[k][2] : NULL },
        };
        for (size_t i = 0; i < sizeof planes / sizeof *planes && result == STP_OK; i++)
            result = check_plane(env, pair, planes[i].value, which[k], planes[i].name);
    }
    return result;
}

enum stp_result stp_compare(const struct stp_env *env, const struct stp_image *image,
                            const struct stp_image *reference,
                            const struct stp_compare_params *params,
                            struct stp_comparison *comparison)
{
    struct stp_compare_params defaults = { 0 };
    struct pair pair = { 0 };
    params = params ? params : &defaults;
    enum stp_result result = check(env, image, reference, params);
    if (result == STP_OK)
        result = take_color(env, image, reference, &pair.color);
    if (result != STP_OK)
        return result;
    take_others(image, reference, &pair);
    pair.pixels = (size_t)image->width * image->height;
    pair.epsilon = params->epsilon > 0 ? params->epsilon : 1;
    result = check_planes(env, &pair);
    return result == STP_OK ? compare_pair(env, &pair, params, comparison) : result;
}
