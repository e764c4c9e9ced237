/* One parser for each kind of option value. All reject what they do not understand whole. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "cli.h"

#define RADIANS (3.14159265358979323846 / 180)

const struct value_name aov_names[] = {
    { "albedo", STP_AOV_ALBEDO },     { "P", STP_AOV_POSITION },
    { "weight", STP_AOV_WEIGHT },     { "fragments", STP_AOV_FRAGMENTS },
    { "coverage", STP_AOV_COVERAGE }, { "id", STP_AOV_ID },
    { "layers", STP_AOV_LAYERS },     { NULL, 0 },
};
const struct value_name relax_names[] = {
    { "coplanar", STP_RELAX_COPLANAR },
    { "opposed", STP_RELAX_OPPOSED },
    { "none", STP_RELAX_NONE },
    { NULL, 0 },
};

bool value_flag(const struct option_spec *spec, const char *text, void *target)
{
    (void)spec, (void)text;
    *(bool *)target = true;
    return true;
}

bool value_text(const struct option_spec *spec, const char *text, void *target)
{
    (void)spec;
    if (!*text)
        return false;
    *(const char **)target = text;
    return true;
}

/* The argument's own text, FILE.exr say, has the ending that the name needs. */
bool value_path(const struct option_spec *spec, const char *text, void *target)
{
    const char *ending = strchr(spec->argument, '.');
    size_t length = strlen(text), tail = strlen(ending);
    if (length <= tail || strcasecmp(text + length - tail, ending) != 0)
        return false;
    *(const char **)target = text;
    return true;
}

/* A finite decimal number; *end gets what follows. */
static bool read_real(const char *text, const char **end, double *value)
{
    char *stop;
    if (isspace((unsigned char)*text) || strpbrk(text, "xXnN"))
        return false;
    *value = strtod(text, &stop);
    *end = stop;
    return stop != text && isfinite(*value);
}

/* `least` to `most` numbers with commas between; returns how many, 0 when wrong. */
static unsigned read_reals(const char *text, unsigned least, unsigned most, double *values)
{
    for (unsigned n = 0; n < most;) {
        if (!read_real(text, &text, &values[n++]))
            return 0;
        if (!*text)
            return n >= least ? n : 0;
        if (*text++ != ',')
            return 0;
    }
    return 0;
}

bool value_real(const struct option_spec *spec, const char *text, void *target)
{
    double value;
    if (read_reals(text, 1, 1, &value) != 1 || !(value >= spec->low && value <= spec->high))
        return false;
    *(double *)target = value;
    return true;
}

bool value_degrees(const struct option_spec *spec, const char *text, void *target)
{
    double degrees;
    if (!value_real(spec, text, &degrees))
        return false;
    *(double *)target = degrees * RADIANS;
    return true;
}

/* Digits only: strtoull alone would take signs and spaces. */
static bool read_whole(const char *text, const char **end, uint64_t *value)
{
    char *stop;
    if (!isdigit((unsigned char)*text))
        return false;
    errno = 0;
    *value = strtoull(text, &stop, 10);
    *end = stop;
    return errno == 0;
}

bool value_count(const struct option_spec *spec, const char *text, void *target)
{
    uint64_t value;
    if (!read_whole(text, &text, &value) || *text)
        return false;
    if ((double)value < spec->low || (double)value > spec->high)
        return false;
    *(unsigned *)target = (unsigned)value;
    return true;
}

bool value_bytes(const struct option_spec *spec, const char *text, void *target)
{
    (void)spec;
    uint64_t value;
    if (!read_whole(text, &text, &value) || value == 0)
        return false;
    unsigned shift = *text == 'K' ? 10 : *text == 'M' ? 20 : *text == 'G' ? 30 : 0;
    if (text[shift ? 1 : 0] || value > UINT64_MAX >> shift)
        return false;
    *(uint64_t *)target = value << shift;
    return true;
}

/* The argument's own text lists the values in the order of the enum. */
bool value_choice(const struct option_spec *spec, const char *text, void *target)
{
    size_t length = strlen(text);
    unsigned index = 0;
    for (const char *at = spec->argument; *at; index++) {
        size_t word = strcspn(at, "|");
        if (word == length && strncmp(at, text, length) == 0) {
            *(unsigned *)target = index;
            return true;
        }
        at += word + (at[word] == '|');
    }
    return false;
}

static unsigned name_bit(const struct value_name *names, const char *text, size_t length)
{
    for (; names->name; names++)
        if (strlen(names->name) == length && strncmp(names->name, text, length) == 0)
            return names->bit;
    return 0;
}

/* Names with commas between, or-ed to what is there already: the option may be repeated. */
bool value_names(const struct option_spec *spec, const char *text, void *target)
{
    unsigned bits = 0;
    for (;;) {
        size_t word = strcspn(text, ",");
        unsigned bit = name_bit(spec->names, text, word);
        if (!bit)
            return false;
        bits |= bit;
        if (!text[word])
            break;
        text += word + 1;
    }
    if (spec->names == relax_names && (bits & STP_RELAX_NONE) && bits != STP_RELAX_NONE)
        return false;
    *(unsigned *)target |= bits;
    return true;
}

/* The library knows the names of the features: bit by bit until it has no more. */
static unsigned feature_bit(const char *text, size_t length)
{
    for (unsigned bit = 1; stp_feature_name((enum stp_feature)bit); bit *= 2) {
        const char *name = stp_feature_name((enum stp_feature)bit);
        if (strlen(name) == length && strncmp(name, text, length) == 0)
            return bit;
    }
    return 0;
}

bool value_features(const struct option_spec *spec, const char *text, void *target)
{
    (void)spec;
    unsigned bits = 0;
    for (;; text++) {
        size_t word = strcspn(text, ",");
        unsigned bit = feature_bit(text, word);
        if (!bit)
            return false;
        bits |= bit;
        text += word;
        if (!*text)
            break;
    }
    *(unsigned *)target |= bits;
    return true;
}

bool value_size(const struct option_spec *spec, const char *text, void *target)
{
    struct settings *settings = target;
    uint64_t width, height;
    if (!read_whole(text, &text, &width) || *text++ != 'x' || !read_whole(text, &text, &height) ||
        *text)
        return false;
    if (width < 1 || height < 1 || (double)width > spec->high || (double)height > spec->high)
        return false;
    settings->frame.width = (uint32_t)width;
    settings->frame.height = (uint32_t)height;
    return true;
}

/* Azimuth carries the viewer round the scene, from its front towards the +90 that is `right`. */
bool value_view(const struct option_spec *spec, const char *text, void *target)
{
    static const struct {
        const char *name;
        double azimuth, elevation;
    } views[] = {
        { "front", 0, 0 },  { "back", 180, 0 }, { "left", -90, 0 },
        { "right", 90, 0 }, { "top", 0, 90 },   { "bottom", 0, -90 },
    };
    (void)spec;
    struct stp_frame_params *frame = &((struct settings *)target)->frame;
    double angles[2];
    if (strcmp(text, "iso") == 0) {
        frame->azimuth = STP_ISO_AZIMUTH;
        frame->elevation = STP_ISO_ELEVATION;
        return true;
    }
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        if (strcmp(text, views[i].name) == 0) {
            frame->azimuth = views[i].azimuth * RADIANS;
            frame->elevation = views[i].elevation * RADIANS;
            return true;
        }
    }
    if (read_reals(text, 2, 2, angles) != 2 || fabs(angles[0]) > 360 || fabs(angles[1]) > 90)
        return false;
    frame->azimuth = angles[0] * RADIANS;
    frame->elevation = angles[1] * RADIANS;
    return true;
}

bool value_clip_box(const struct option_spec *spec, const char *text, void *target)
{
    (void)spec;
    struct settings *settings = target;
    double box[6];
    if (read_reals(text, 6, 6, box) != 6)
        return false;
    for (int axis = 0; axis < 3; axis++)
        if (box[axis] > box[axis + 3])
            return false;
    memcpy(settings->clip_box, box, sizeof box);
    settings->prepare.clip_box = settings->clip_box;
    return true;
}

bool value_volume_dims(const struct option_spec *spec, const char *text, void *target)
{
    struct settings *settings = target;
    uint64_t dims[3];
    for (int i = 0; i < 3; i++)
        if (!read_whole(text, &text, &dims[i]) || dims[i] < 1 || (double)dims[i] > spec->high ||
            *text++ != (i < 2 ? ',' : 0))
            return false;
    for (int i = 0; i < 3; i++)
        settings->load.volume.dims[i] = (uint32_t)dims[i];
    return true;
}

bool value_volume_spacing(const struct option_spec *spec, const char *text, void *target)
{
    (void)spec;
    struct settings *settings = target;
    double spacing[3];
    if (read_reals(text, 3, 3, spacing) != 3)
        return false;
    for (int i = 0; i < 3; i++)
        if (!(spacing[i] > 0))
            return false;
    memcpy(settings->load.volume.spacing, spacing, sizeof spacing);
    return true;
}

bool value_background(const struct option_spec *spec, const char *text, void *target)
{
    (void)spec;
    struct settings *settings = target;
    double rgba[4] = { 0, 0, 0, 1 };
    settings->render.environment_behind = strcmp(text, "environment") == 0;
    if (strcmp(text, "none") == 0 || settings->render.environment_behind) {
        settings->render.background = NULL;
        return true;
    }
    if (!read_reals(text, 3, 4, rgba) || rgba[3] < 0 || rgba[3] > 1)
        return false;
    for (int i = 0; i < 4; i++)
        settings->background[i] = (float)rgba[i];
    settings->render.background = settings->background;
    return true;
}

bool value_frames(const struct option_spec *spec, const char *text, void *target)
{
    struct settings *settings = target;
    uint64_t first, last;
    if (!read_whole(text, &text, &first) || *text++ != ':' || !read_whole(text, &text, &last) ||
        *text)
        return false;
    if (first > last || (double)last > spec->high)
        return false;
    settings->first_frame = (uint32_t)first;
    settings->last_frame = (uint32_t)last;
    return true;
}

/* The library's zero is its default; the command's zero is off. */
bool value_intensity(const struct option_spec *spec, const char *text, void *target)
{
    double value;
    if (!value_real(spec, text, &value) || !((float)value > 0))
        return false;
    *(float *)target = (float)value;
    return true;
}

/* One number for all channels, or three, where the field has three. The library's zero is its
 * default; the command's zero is 0. */
bool value_optics(const struct option_spec *spec, const char *text, void *target)
{
    double value[3];
    bool channels = strchr(spec->argument, '|') != NULL;
    unsigned n = read_reals(text, 1, channels ? 3 : 1, value);
    if (n != 1 && n != 3)
        return false;
    for (unsigned i = 0; i < n; i++)
        if (!(value[i] >= spec->low && value[i] <= spec->high))
            return false;
    for (unsigned i = 0; i < (channels ? 3 : 1); i++) {
        float v = (float)value[n == 3 ? i : 0];
        ((float *)target)[i] = v > 0 ? v : -1;
    }
    return true;
}

bool value_opacity(const struct option_spec *spec, const char *text, void *target)
{
    double opacity;
    if (!value_real(spec, text, &opacity))
        return false;
    ((struct settings *)target)->load.opacity = (float)opacity > 0 ? (float)opacity : -1;
    return true;
}

/* 0 is none; where it is not given, it is 0 too. */
bool value_or_none(const struct option_spec *spec, const char *text, void *target)
{
    double value;
    if (!value_real(spec, text, &value))
        return false;
    *(double *)target = value > 0 ? value : -1;
    return true;
}

bool value_axis_h(const struct option_spec *spec, const char *text, void *target)
{
    double h;
    return value_real(spec, text, &h) && h < 1 && value_or_none(spec, text, target);
}

bool value_min_splat(const struct option_spec *spec, const char *text, void *target)
{
    double pixels;
    if (!value_real(spec, text, &pixels))
        return false;
    ((struct settings *)target)->render.min_splat = pixels > 0 ? pixels : -1;
    return true;
}
