/* Range images: a frame from its files, in scene units and linear colours. */
#include "load/range.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/color.h"

void range_image_release(struct range_image *image)
{
    mem_free(image->value);
    *image = (struct range_image){ 0 };
}

void range_release(struct range *range)
{
    for (unsigned i = 0; i < range->count; i++) {
        mem_free(range->frame[i].depth);
        mem_free(range->frame[i].color);
    }
    mem_free(range->frame);
    *range = (struct range){ 0 };
}

enum stp_result range_allocate(const struct stp_env *env, const char *path, uint64_t width,
                               uint64_t height, unsigned channels, struct range_image *image)
{
    if (width < 1 || height < 1 || width > RANGE_MOST_SIDE || height > RANGE_MOST_SIDE ||
        width * height > RANGE_MOST_PIXELS)
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: a frame of %llu x %llu; 1 x 1 to 16384 x 16384 is read", path,
                         (unsigned long long)width, (unsigned long long)height);
    image->value = mem_alloc(width * height, channels * sizeof *image->value);
    if (!image->value)
        return log_no_memory(env, width * height * channels * sizeof *image->value, path);
    image->width = (uint32_t)width;
    image->height = (uint32_t)height;
    image->channels = channels;
    return STP_OK;
}

double range_deviation(const struct range_frame *frame, double depth)
{
    const struct range_sensor *s = &frame->sensor;
    switch (s->kind) {
    case RANGE_STEREO:
        return s->sigma_disparity * depth * depth / (frame->camera.fx * s->baseline);
    case RANGE_CONSTANT:
        return s->sigma;
    case RANGE_STRUCTURED_LIGHT:
        break;
    }
    return s->sigma * depth * depth;
}

static bool in_margin(const struct range_units *units, const struct range_frame *frame, size_t i)
{
    double x = (double)(i % frame->width) + 0.5, y = (double)(i / frame->width) + 0.5;
    return x < units->margin || y < units->margin || x > frame->width - units->margin ||
           y > frame->height - units->margin;
}

/* 0 is no reading, in every kind of file; of a disparity so is one at infinity. */
static void to_depths(const struct range_units *units, struct range_frame *frame, float *value)
{
    double scale = units->depth_scale > 0 ? units->depth_scale : 1;
    for (size_t i = 0; i < (size_t)frame->width * frame->height; i++) {
        double v = (double)value[i] / scale, depth = v;
        if (units->baseline > 0 && v != 0)
            depth = frame->camera.fx * units->baseline / (v + units->disparity_offset);
        if (!(depth >= 0 && depth < 1e18)) {
            frame->not_finite++;
            depth = 0;
        }
        value[i] = in_margin(units, frame, i) ? 0 : (float)depth;
    }
    frame->depth = value;
}

/* What every number of an integer file means; NULL: out of memory. */
static float *color_table(uint32_t maximum, bool srgb)
{
    float *table = mem_alloc((size_t)maximum + 1, sizeof *table);
    for (size_t i = 0; table && i <= maximum; i++) {
        double v = (double)i / maximum;
        table[i] = (float)(srgb ? color_from_srgb(v) : v);
    }
    return table;
}

static float color_of(const float *table, uint32_t maximum, bool srgb, float value)
{
    if (table)
        return table[value < (float)maximum ? (uint32_t)value : maximum];
    double c = srgb ? color_from_srgb((double)value) : (double)value;
    return c >= 0 && c < 1e18 ? (float)c : 0; /* what is negative or not finite is black */
}

static bool to_colors(const struct range_image *image, enum stp_transfer transfer,
                      struct range_frame *frame)
{
    size_t count = (size_t)image->width * image->height;
    bool integer = image->maximum > 0;
    bool srgb = transfer == STP_TRANSFER_SRGB || (transfer == STP_TRANSFER_AUTO && integer);
    float *table = integer ? color_table(image->maximum, srgb) : NULL;
    if (integer && !table)
        return false;
    frame->color = mem_alloc(count, sizeof *frame->color);
    for (size_t i = 0; frame->color && i < count; i++)
        for (unsigned k = 0; k < 3; k++) {
            float v = image->value[i * image->channels + (image->channels == 3 ? k : 0)];
            frame->color[i][k] = color_of(table, image->maximum, srgb, v);
        }
    mem_free(table);
    return frame->color != NULL;
}

enum stp_result range_frame_read(const struct stp_env *env, const char *depth, const char *color,
                                 const struct range_units *units, enum stp_transfer transfer,
                                 struct range_frame *frame)
{
    struct range_image deep = { 0 }, colored = { 0 };
    enum stp_result result = range_image_read(env, depth, RANGE_DEPTH, &deep);
    if (result == STP_OK)
        result = range_image_read(env, color, RANGE_COLOR, &colored);
    if (result == STP_OK && (deep.width != colored.width || deep.height != colored.height))
        result = log_error(env, STP_ERROR_FORMAT,
                           "%s: %u x %u, but its colours, %s, are %u x %u: both must have one size",
                           depth, deep.width, deep.height, color, colored.width, colored.height);
    if (result == STP_OK) {
        frame->width = deep.width;
        frame->height = deep.height;
        if (to_colors(&colored, transfer, frame)) {
            to_depths(units, frame, deep.value);
            deep.value = NULL;
        } else {
            result = log_no_memory(env, (size_t)deep.width * deep.height * 12, color);
        }
    }
    range_image_release(&deep);
    range_image_release(&colored);
    return result;
}
