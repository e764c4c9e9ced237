#include "load/color.h"

#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

struct summary {
    double max;
    size_t above_one, finite;
    bool whole;
};

static struct summary summarise(const float *value, size_t count)
{
    struct summary s = { .whole = true };
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(value[i]))
            continue;
        s.finite++;
        s.max = value[i] > s.max ? value[i] : s.max;
        s.above_one += value[i] > 1;
        s.whole = s.whole && value[i] == truncf(value[i]);
    }
    return s;
}

static double integer_divisor(double max)
{
    return max <= 255 ? 255 : max <= 65535 ? 65535 : 4294967295.0;
}

/* Floats that were never divided by 255. Radiances above 1 exist too, so the values must be large,
 * within 255, and either whole or mostly above 1. */
static bool is_plainly_255(const struct summary *s)
{
    return s->max >= 16 && s->max <= 255 && (s->whole || s->above_one * 2 > s->finite);
}

/* What a component means: value / divisor, and whether it was an integer. */
struct encoding {
    double divisor;
    bool integer;
    bool guessed; /* a float column taken as 0..255 */
};

static struct encoding find_encoding(const float *value, size_t count, enum scale scale)
{
    if (scale == SCALE_LINEAR)
        return (struct encoding){ .divisor = 1 };
    if (scale == SCALE_BYTE)
        return (struct encoding){ .divisor = 255, .integer = true };
    struct summary s = summarise(value, count);
    if (scale == SCALE_UINT8 && s.whole)
        return (struct encoding){ .divisor = 255, .integer = true };
    if (scale == SCALE_INTEGER && s.whole)
        return (struct encoding){ .divisor = integer_divisor(s.max), .integer = true };
    if (scale == SCALE_TEXT && s.whole && s.max > 1 && s.max <= 65535)
        return (struct encoding){ .divisor = integer_divisor(s.max), .integer = true };
    if (is_plainly_255(&s))
        return (struct encoding){ .divisor = 255, .guessed = true };
    return (struct encoding){ .divisor = 1 };
}

double color_from_srgb(double encoded)
{
    double v = fabs(encoded);
    double linear = v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
    return copysign(linear, encoded);
}

struct decode {
    float *value;
    const float *table; /* linear value of 0..divisor; NULL: computed */
    double divisor;
    bool srgb, integer;
};

/* An integer in 0..divisor: signed columns hold the upper half as negative numbers, and text may
 * hold anything. */
static double integer_of(float value, double divisor)
{
    double unsigned_value = value < 0 ? value + divisor + 1 : value;
    if (unsigned_value >= 0 && unsigned_value <= divisor)
        return unsigned_value;
    return unsigned_value > 0 ? divisor : 0;
}

static void decode_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct decode *decode = context;
    for (size_t i = begin; i < end; i++) {
        double value = decode->value[i];
        if (decode->integer)
            value = integer_of(decode->value[i], decode->divisor);
        value /= decode->divisor;
        decode->value[i] = (float)(decode->srgb ? color_from_srgb(value) : value);
    }
}

static void look_up_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct decode *decode = context;
    for (size_t i = begin; i < end; i++)
        decode->value[i] = decode->table[(unsigned)integer_of(decode->value[i], decode->divisor)];
}

/* Only where it is read more often than it costs. */
static float *decode_table(const struct decode *decode, size_t count)
{
    if (!decode->integer || decode->divisor > 65535 || count < decode->divisor)
        return NULL;
    size_t size = (size_t)decode->divisor + 1;
    float *table = mem_alloc(size, sizeof *table);
    for (size_t i = 0; table && i < size; i++) {
        double value = (double)i / decode->divisor;
        table[i] = (float)(decode->srgb ? color_from_srgb(value) : value);
    }
    return table;
}

static void decode_all(const struct stp_env *env, struct decode *decode, size_t count)
{
    /* Without memory for the table every value is computed: slower, the same bits. */
    float *table = decode_table(decode, count);
    decode->table = table;
    parallel_for(env, count, 1 << 16, table ? look_up_range : decode_range, decode);
    mem_free(table);
}

void color_decode(const struct stp_env *env, const char *path, float (*color)[3], size_t count,
                  enum scale scale, enum stp_transfer transfer)
{
    if (scale == SCALE_LINEAR)
        return;
    bool as_is = transfer == STP_TRANSFER_LINEAR && scale == SCALE_FLOAT;
    struct encoding e = { .divisor = 1 };
    if (!as_is)
        e = find_encoding(color[0], count * 3, scale);
    if (e.guessed)
        log_warning(env,
                    "%s: float colours reach beyond 1 and look like 0..255: read as sRGB of 8 bits "
                    "(transfer linear takes them as they are)",
                    path);
    bool srgb = transfer == STP_TRANSFER_SRGB ||
                (transfer == STP_TRANSFER_AUTO && (e.integer || e.guessed));
    struct decode decode = { color[0], NULL, e.divisor, srgb, e.integer };
    if (srgb || e.divisor != 1)
        decode_all(env, &decode, count * 3);
}

bool opacity_decode(const struct stp_env *env, const char *path, float *opacity, size_t count,
                    enum scale scale)
{
    if (scale == SCALE_LINEAR)
        return false;
    struct encoding e = find_encoding(opacity, count, scale);
    bool unset = e.integer;
    for (size_t i = 0; i < count && unset; i++)
        unset = opacity[i] == 0;
    if (unset) {
        log_warning(env, "%s: every integer alpha is 0: taken as not set, the points are opaque",
                    path);
        return true;
    }
    struct decode decode = { opacity, NULL, e.divisor, false, e.integer };
    if (e.divisor != 1)
        decode_all(env, &decode, count);
    return false;
}
