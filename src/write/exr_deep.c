/* stp_image to a deep scanline EXR (docs/exr.md). */
#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/deep.h"
#include "write/exr_deep_pack.h"
#include "write/exr_header.h"

/* One layer a pixel, where something is. */
static enum stp_result layers_of_planes(const struct stp_env *env, const struct stp_image *image,
                                        const char *path, struct stp_deep **deep)
{
    static const char *const names[] = { "R", "G", "B", "A", "Z" };
    const float *plane[5];
    struct deep_list list = { 0 };
    size_t pixels = (size_t)image->width * image->height;
    for (int i = 0; i < 5; i++) {
        const struct stp_channel *channel = stp_image_find(image, names[i]);
        if (!channel || channel->type != STP_CHANNEL_FLOAT)
            return log_error(env, STP_ERROR_ARGUMENT, "%s: the picture has no channel %s", path,
                             names[i]);
        plane[i] = channel->data.f;
    }
    enum stp_result result = STP_OK;
    for (size_t i = 0; i < pixels && result == STP_OK; i++)
        if (isfinite(plane[4][i]))
            result =
                deep_add(&list, (uint32_t)i,
                         &(struct stp_deep_layer){
                             plane[4][i], { plane[0][i], plane[1][i], plane[2][i] }, plane[3][i] });
    result = result == STP_OK ? deep_build(env, &list, 1, pixels, deep)
                              : log_no_memory(env, list.room * sizeof *list.entry, "layers");
    deep_list_release(&list);
    return result;
}

/* The most layers that a pixel has; a line's bytes must be what readers can count. */
static enum stp_result measure(const struct stp_env *env, const struct stp_image *image,
                               const struct stp_deep *deep, bool half, const char *path, int *most)
{
    *most = 0;
    for (uint32_t y = 0; y < image->height; y++) {
        const size_t *first = deep->first + (size_t)y * image->width;
        size_t layers = first[image->width] - first[0];
        if (layers > INT32_MAX / exr_deep_bytes(half))
            return log_error(env, STP_ERROR_ARGUMENT,
                             "%s: line %u has %zu layers, more than a deep EXR holds", path, y,
                             layers);
        for (uint32_t x = 0; x < image->width; x++)
            if (first[x + 1] - first[x] > (size_t)*most)
                *most = (int)(first[x + 1] - first[x]);
    }
    return STP_OK;
}

static exr_result_t set_channels(exr_context_t context, bool half)
{
    static const char *const names[] = { "A", "B", "G", "R", "Z", "ZBack" };
    exr_result_t result = EXR_ERR_SUCCESS;
    for (int i = 0; i < 6 && result == EXR_ERR_SUCCESS; i++)
        result =
            exr_add_channel(context, 0, names[i], half && i < 4 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                            EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return result;
}

struct deep_part {
    struct exr_deep picture;
    int most; /* layers of a pixel */
};

static exr_result_t write_part(const struct stp_env *env, exr_context_t context,
                               const struct stp_image *image, const struct stp_exr_params *params,
                               const void *user)
{
    const struct deep_part *part = user;
    exr_result_t result =
        exr_begin_part(context, image, EXR_STORAGE_DEEP_SCANLINE,
                       part->picture.zip ? EXR_COMPRESSION_ZIPS : EXR_COMPRESSION_NONE);
    if (result == EXR_ERR_SUCCESS)
        result = exr_set_version(context, 0, 1);
    if (result == EXR_ERR_SUCCESS)
        result = exr_attr_set_int(context, 0, "maxSamplesPerPixel", part->most);
    if (result == EXR_ERR_SUCCESS)
        result = set_channels(context, part->picture.half);
    if (result == EXR_ERR_SUCCESS)
        result = exr_set_attributes(context, image, params);
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(context);
    if (result == EXR_ERR_SUCCESS)
        result = exr_pack_deep(env, context, &part->picture);
    return result;
}

enum stp_result stp_image_write_deep_exr(const struct stp_env *env, const struct stp_image *image,
                                         const char *path, const struct stp_exr_params *params)
{
    const struct stp_channel *red = stp_image_find(image, "R");
    struct stp_deep *made = NULL;
    struct deep_part part = { .picture = { .deep = image->deep,
                                           .width = image->width,
                                           .height = image->height,
                                           .half = red && red->half } };
    part.picture.zip = !params || params->compression != STP_COMPRESSION_NONE;
    enum stp_result result = exr_check_size(env, image, path);
    if (result == STP_OK && !image->deep)
        result = layers_of_planes(env, image, path, &made);
    if (made)
        part.picture.deep = made;
    if (result == STP_OK)
        result = measure(env, image, part.picture.deep, part.picture.half, path, &part.most);
    if (result == STP_OK)
        result = exr_write_file(env, image, path, params, write_part, &part);
    deep_destroy(&made);
    return result;
}
