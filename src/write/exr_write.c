/* stp_image to a flat scanline EXR (docs/exr.md). */
#include <string.h>

#include "base/log.h"
#include "write/exr_header.h"
#include "write/exr_pack.h"

static enum stp_result check_image(const struct stp_env *env, const struct stp_image *image,
                                   const char *path)
{
    enum stp_result result = exr_check_size(env, image, path);
    if (result != STP_OK)
        return result;
    for (unsigned i = 0; i < image->channel_count; i++)
        for (unsigned j = 0; j < i; j++)
            if (strcmp(image->channels[i].name, image->channels[j].name) == 0)
                return log_error(env, STP_ERROR_ARGUMENT, "%s: two channels are named %s", path,
                                 image->channels[i].name);
    return STP_OK;
}

static exr_compression_t core_compression(enum stp_compression compression)
{
    switch (compression) {
    case STP_COMPRESSION_NONE:
        return EXR_COMPRESSION_NONE;
    case STP_COMPRESSION_ZIPS:
        return EXR_COMPRESSION_ZIPS;
    case STP_COMPRESSION_PIZ:
        return EXR_COMPRESSION_PIZ;
    case STP_COMPRESSION_ZIP:
        break;
    }
    return EXR_COMPRESSION_ZIP;
}

static exr_result_t set_channels(exr_context_t context, const struct stp_image *image)
{
    exr_result_t result = EXR_ERR_SUCCESS;
    for (unsigned i = 0; i < image->channel_count && result == EXR_ERR_SUCCESS; i++) {
        const struct stp_channel *channel = &image->channels[i];
        exr_pixel_type_t type = channel->type == STP_CHANNEL_UINT ? EXR_PIXEL_UINT
                                : channel->half                   ? EXR_PIXEL_HALF
                                                                  : EXR_PIXEL_FLOAT;
        result =
            exr_add_channel(context, 0, channel->name, type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    return result;
}

static exr_result_t write_part(const struct stp_env *env, exr_context_t context,
                               const struct stp_image *image, const struct stp_exr_params *params,
                               const void *)
{
    exr_result_t result =
        exr_begin_part(context, image, EXR_STORAGE_SCANLINE, core_compression(params->compression));
    if (result == EXR_ERR_SUCCESS)
        result = exr_set_zip_compression_level(context, 0, EXR_ZIP_LEVEL);
    if (result == EXR_ERR_SUCCESS)
        result = set_channels(context, image);
    if (result == EXR_ERR_SUCCESS)
        result = exr_set_attributes(context, image, params);
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(context);
    if (result == EXR_ERR_SUCCESS)
        result = exr_pack_image(env, context, image);
    return result;
}

enum stp_result stp_image_write_exr(const struct stp_env *env, const struct stp_image *image,
                                    const char *path, const struct stp_exr_params *params)
{
    enum stp_result result = check_image(env, image, path);
    return result == STP_OK ? exr_write_file(env, image, path, params, write_part, NULL) : result;
}
