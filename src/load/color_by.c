/* Scalars to colours, in Oklab (Ottosson 2020), which is linear in what the eye calls even steps.
 */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "load/color.h"

#define CHROMA 0.1 /* the largest that keeps ramp and palette inside Rec.709 */
#define GREY   0.2f

/* Lightness, chroma, hue in degrees to linear Rec.709. */
static void from_oklch(double lightness, double chroma, double hue, float color[3])
{
    double a = chroma * cos(hue * M_PI / 180), b = chroma * sin(hue * M_PI / 180);
    double l = lightness + 0.3963377774 * a + 0.2158037573 * b;
    double m = lightness - 0.1055613458 * a - 0.0638541728 * b;
    double s = lightness - 0.0894841775 * a - 1.2914855480 * b;
    l = l * l * l, m = m * m * m, s = s * s * s;
    color[0] = (float)(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s);
    color[1] = (float)(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s);
    color[2] = (float)(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s);
    for (int c = 0; c < 3; c++)
        color[c] = fminf(fmaxf(color[c], 0), 1);
}

static void grey(float color[3])
{
    color[0] = color[1] = color[2] = GREY;
}

void color_ramp_at(double t, float color[3])
{
    from_oklch(0.35 + 0.5 * t, CHROMA, 300 - 195 * t, color);
}

/* Floats as integers that sort alike. */
static uint32_t sortable(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

static float unsortable(uint32_t key)
{
    uint32_t bits = key & 0x80000000u ? key & 0x7fffffffu : ~key;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* The bin that holds the rank, which becomes the rank within it. */
static uint32_t find_bin(const size_t *tally, size_t *rank)
{
    uint32_t bin = 0;
    while (*rank >= tally[bin])
        *rank -= tally[bin++];
    return bin;
}

/* Two passes of a radix select: the upper half of the key, then the lower half. */
static float select_rank(const float *value, size_t count, size_t rank, size_t *tally)
{
    memset(tally, 0, 65536 * sizeof *tally);
    for (size_t i = 0; i < count; i++)
        if (isfinite(value[i]))
            tally[sortable(value[i]) >> 16]++;
    uint32_t upper = find_bin(tally, &rank);
    memset(tally, 0, 65536 * sizeof *tally);
    for (size_t i = 0; i < count; i++)
        if (isfinite(value[i]) && sortable(value[i]) >> 16 == upper)
            tally[sortable(value[i]) & 0xffff]++;
    return unsortable(upper << 16 | find_bin(tally, &rank));
}

bool color_percentiles(const float *value, size_t count, size_t *tally, float bounds[2])
{
    size_t finite = 0;
    for (size_t i = 0; i < count; i++)
        finite += isfinite(value[i]) != 0;
    if (finite == 0)
        return false;
    size_t low = (size_t)((double)(finite - 1) * 0.01 + 0.5);
    bounds[0] = select_rank(value, count, low, tally);
    bounds[1] = select_rank(value, count, finite - 1 - low, tally);
    return true;
}

struct paint {
    const float *value;
    float (*color)[3];
    double low, high;
};

static void ramp_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct paint *p = context;
    for (size_t i = begin; i < end; i++) {
        double t = p->high > p->low ? (p->value[i] - p->low) / (p->high - p->low) : 0.5;
        if (isfinite(p->value[i]))
            color_ramp_at(t < 0 ? 0 : t > 1 ? 1 : t, p->color[i]);
        else
            grey(p->color[i]);
    }
}

static void class_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct paint *p = context;
    for (size_t i = begin; i < end; i++)
        color_class_at(p->value[i], p->color[i]);
}

void color_classes(const struct stp_env *env, const float *value, size_t count, float (*color)[3])
{
    struct paint paint = { .value = value, .color = color };
    parallel_for(env, count, 1 << 14, class_range, &paint);
}

/* The golden angle keeps hues of neighbouring classes far apart; three lightnesses tell apart those
 * whose hues come near. */
void color_class_at(double value, float color[3])
{
    if (!(value >= 0 && value < 1e9)) {
        grey(color);
        return;
    }
    unsigned index = (unsigned)(value + 0.5);
    from_oklch(0.6 + 0.1 * (index % 3), CHROMA, fmod(30 + 137.50776405 * index, 360), color);
}

enum stp_result color_ramp(const struct stp_env *env, const float *value, size_t count,
                           float (*color)[3])
{
    size_t *tally = mem_alloc(65536, sizeof *tally);
    if (!tally)
        return log_no_memory(env, 65536 * sizeof *tally, "a histogram");
    float bounds[2] = { 0, 0 };
    color_percentiles(value, count, tally, bounds);
    mem_free(tally);
    struct paint paint = { value, color, bounds[0], bounds[1] };
    parallel_for(env, count, 1 << 14, ramp_range, &paint);
    return STP_OK;
}
