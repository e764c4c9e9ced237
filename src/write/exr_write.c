/* stp_image to a flat scanline EXR (docs/exr.md). */
#include <errno.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "base/memory.h"
#include "write/exr_camera.h"
#include "write/exr_pack.h"

/* zlib's level: 6 takes a third longer for 0.7 % less (docs/exr.md has the table). */
#define ZIP_LEVEL 2

static enum stp_result check_image(const struct stp_env *env, const struct stp_image *image,
                                   const char *path)
{
    if (image->width == 0 || image->height == 0 || image->channel_count == 0)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: the picture has no pixels", path);
    if (image->width > INT32_MAX / 64 || image->height > INT32_MAX / 64)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: a picture of %u x %u is too large for EXR",
                         path, image->width, image->height);
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

static exr_result_t set_windows(exr_context_t context, const struct stp_image *image,
                                enum stp_compression compression)
{
    const exr_attr_box2i_t window = { .max.x = (int)image->width - 1,
                                      .max.y = (int)image->height - 1 };
    struct exr_screen screen = { .width = 1, .pixel_aspect = 1 };
    if (image->has_camera)
        screen = exr_screen_window(&image->camera);
    /* Square to rounding is square, so that no viewer resamples. */
    if (fabs(screen.pixel_aspect - 1) < 1e-6)
        screen.pixel_aspect = 1;
    const exr_attr_v2f_t center = { .x = (float)screen.center[0], .y = (float)screen.center[1] };
    return exr_initialize_required_attr(context, 0, &window, &window, (float)screen.pixel_aspect,
                                        &center, (float)screen.width, EXR_LINEORDER_INCREASING_Y,
                                        core_compression(compression));
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

static exr_result_t set_matrix(exr_context_t context, const char *name, const double m[16])
{
    exr_attr_m44f_t matrix;
    for (int i = 0; i < 16; i++)
        matrix.m[i] = (float)m[i] + 0.0f; /* no negative zeros in what people read */
    return exr_attr_set_m44f(context, 0, name, &matrix);
}

static exr_result_t set_camera(exr_context_t context, const struct stp_image *image)
{
    double m[16];
    const exr_attr_v3d_t origin = { .x = image->origin[0],
                                    .y = image->origin[1],
                                    .z = image->origin[2] };
    exr_result_t result = exr_attr_set_v3d(context, 0, "stipple:origin", &origin);
    if (result != EXR_ERR_SUCCESS)
        return result;
    exr_world_to_camera(&image->camera, image->origin, m);
    result = set_matrix(context, "worldToCamera", m);
    if (result != EXR_ERR_SUCCESS)
        return result;
    exr_world_to_ndc(&image->camera, image->origin, m);
    return set_matrix(context, "worldToNDC", m);
}

static exr_result_t set_texts(exr_context_t context, const struct stp_image *image,
                              const struct stp_exr_params *params)
{
    /* Rec.709 primaries and D65: linear colours. */
    const exr_attr_chromaticities_t rec709 = { 0.64f, 0.33f, 0.30f,   0.60f,
                                               0.15f, 0.06f, 0.3127f, 0.3290f };
    exr_result_t result = exr_attr_set_chromaticities(context, 0, "chromaticities", &rec709);
    if (result == EXR_ERR_SUCCESS)
        result = exr_attr_set_int(context, 0, "stipple:twoSided", image->two_sided);
    if (result == EXR_ERR_SUCCESS)
        result = exr_attr_set_string(context, 0, "software",
                                     params->software ? params->software : "stipple " STP_VERSION);
    if (result == EXR_ERR_SUCCESS && params->comment)
        result = exr_attr_set_string(context, 0, "comments", params->comment);
    return result;
}

static exr_result_t write_part(const struct stp_env *env, exr_context_t context,
                               const struct stp_image *image, const struct stp_exr_params *params)
{
    int part;
    exr_result_t result = exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result = set_windows(context, image, params->compression);
    if (result == EXR_ERR_SUCCESS)
        result = exr_set_zip_compression_level(context, 0, ZIP_LEVEL);
    if (result == EXR_ERR_SUCCESS)
        result = set_channels(context, image);
    if (result == EXR_ERR_SUCCESS)
        result = set_texts(context, image, params);
    if (result == EXR_ERR_SUCCESS && image->has_camera)
        result = set_camera(context, image);
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(context);
    if (result == EXR_ERR_SUCCESS)
        result = exr_pack_image(env, context, image);
    return result;
}

static exr_result_t write_stream(const struct stp_env *env, struct exr_io *io,
                                 const struct stp_image *image, const struct stp_exr_params *params)
{
    exr_context_t context = NULL;
    exr_context_initializer_t init = exr_io_initializer(io);
    exr_result_t result = exr_start_write(&context, io->path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (result != EXR_ERR_SUCCESS)
        return result;
    result = write_part(env, context, image, params);
    /* Writes the table of chunks. */
    exr_result_t finished = exr_finish(&context);
    return result == EXR_ERR_SUCCESS ? finished : result;
}

enum stp_result stp_image_write_exr(const struct stp_env *env, const struct stp_image *image,
                                    const char *path, const struct stp_exr_params *params)
{
    const struct stp_exr_params defaults = { 0 };
    struct file_output out = { 0 };
    enum stp_result result = check_image(env, image, path);
    if (result == STP_OK)
        result = file_begin(env, path, &out);
    if (result != STP_OK)
        return result;
    struct exr_io io = { .path = path, .descriptor = fileno(out.stream) };
    exr_result_t code = write_stream(env, &io, image, params ? params : &defaults);
    if (code == EXR_ERR_SUCCESS && !io.error)
        return file_commit(env, &out);
    result = exr_io_failed(env, &io, code, "write");
    file_abandon(&out);
    return result;
}
