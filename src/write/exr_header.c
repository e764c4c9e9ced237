#include "write/exr_header.h"

#include <math.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "write/exr_camera.h"

enum stp_result exr_check_size(const struct stp_env *env, const struct stp_image *image,
                               const char *path)
{
    if (image->width == 0 || image->height == 0 || image->channel_count == 0)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: the picture has no pixels", path);
    if (image->width > INT32_MAX / 64 || image->height > INT32_MAX / 64)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: a picture of %u x %u is too large for EXR",
                         path, image->width, image->height);
    return STP_OK;
}

static exr_result_t set_windows(exr_context_t context, const struct stp_image *image,
                                exr_compression_t compression)
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
                                        compression);
}

exr_result_t exr_begin_part(exr_context_t context, const struct stp_image *image,
                            exr_storage_t storage, exr_compression_t compression)
{
    int part;
    exr_result_t result = exr_add_part(context, NULL, storage, &part);
    return result == EXR_ERR_SUCCESS ? set_windows(context, image, compression) : result;
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

exr_result_t exr_set_attributes(exr_context_t context, const struct stp_image *image,
                                const struct stp_exr_params *params)
{
    exr_result_t result = set_texts(context, image, params);
    return result == EXR_ERR_SUCCESS && image->has_camera ? set_camera(context, image) : result;
}

static exr_result_t write_stream(const struct stp_env *env, struct exr_io *io,
                                 const struct stp_image *image, const struct stp_exr_params *params,
                                 exr_part_fn write, const void *user)
{
    exr_context_t context = NULL;
    exr_context_initializer_t init = exr_io_initializer(io);
    exr_result_t result = exr_start_write(&context, io->path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (result != EXR_ERR_SUCCESS)
        return result;
    result = write(env, context, image, params, user);
    /* Writes the table of chunks. */
    exr_result_t finished = exr_finish(&context);
    return result == EXR_ERR_SUCCESS ? finished : result;
}

enum stp_result exr_write_file(const struct stp_env *env, const struct stp_image *image,
                               const char *path, const struct stp_exr_params *params,
                               exr_part_fn write, const void *user)
{
    const struct stp_exr_params defaults = { 0 };
    struct file_output out = { 0 };
    enum stp_result result = file_begin(env, path, &out);
    if (result != STP_OK)
        return result;
    struct exr_io io = { .path = path, .descriptor = fileno(out.stream) };
    exr_result_t code = write_stream(env, &io, image, params ? params : &defaults, write, user);
    if (code == EXR_ERR_SUCCESS && !io.error)
        return file_commit(env, &out);
    result = exr_io_failed(env, &io, code, "write");
    file_abandon(&out);
    return result;
}
