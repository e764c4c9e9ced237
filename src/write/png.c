/* 8-bit sRGB previews: straight alpha from premultiplied linear. */
#include <errno.h>
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stipple/image.h>
#include <string.h>

#include "base/file.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"

/* threshold[i]: the least linear value that rounds to i + 1. */
struct preview {
    const float *red, *green, *blue, *alpha; /* alpha NULL: opaque */
    uint32_t width;
    double gain;
    double threshold[255];
    unsigned char *pixels;
};

static double srgb_to_linear(double s)
{
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

/* How many thresholds are <= value: exact rounding of the sRGB value. NaN gives 0. */
static unsigned char encode(const double threshold[255], double value)
{
    unsigned code = 0;
    for (unsigned step = 128; step; step /= 2)
        if (value >= threshold[code + step - 1])
            code += step;
    return (unsigned char)code;
}

static void convert_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct preview *p = context;
    for (size_t i = begin * p->width; i < end * p->width; i++) {
        double alpha = p->alpha ? p->alpha[i] : 1;
        double scale = alpha > 0 ? p->gain / alpha : 0;
        unsigned char *out = p->pixels + 4 * i;
        out[0] = encode(p->threshold, p->red[i] * scale);
        out[1] = encode(p->threshold, p->green[i] * scale);
        out[2] = encode(p->threshold, p->blue[i] * scale);
        out[3] = alpha >= 1 ? 255 : alpha > 0 ? (unsigned char)(alpha * 255 + 0.5) : 0;
    }
}

static const float *plane(const struct stp_image *image, const char *name)
{
    for (unsigned i = 0; i < image->channel_count; i++)
        if (strcmp(image->channels[i].name, name) == 0 &&
            image->channels[i].type == STP_CHANNEL_FLOAT)
            return image->channels[i].data.f;
    return NULL;
}

static enum stp_result convert(const struct stp_env *env, const struct stp_image *image,
                               const char *path, double stops, unsigned char **pixels)
{
    struct preview p = { .red = plane(image, "R"),
                         .green = plane(image, "G"),
                         .blue = plane(image, "B"),
                         .alpha = plane(image, "A"),
                         .width = image->width,
                         .gain = exp2(stops) };
    if (!p.red || !p.green || !p.blue || image->height == 0 || image->width == 0)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: the picture has no R G B", path);
    for (int i = 0; i < 255; i++)
        p.threshold[i] = srgb_to_linear((i + 0.5) / 255);
    p.pixels = mem_alloc((size_t)image->width * image->height, 4);
    if (!p.pixels)
        return log_no_memory(env, 4 * (size_t)image->width * image->height, path);
    parallel_for(env, image->height, 16, convert_rows, &p);
    *pixels = p.pixels;
    return STP_OK;
}

/* What libpng's callbacks share; lives in the frame that calls setjmp. */
struct writer {
    jmp_buf failed;
    char message[128];
};

static void on_error(png_structp png, png_const_charp message)
{
    struct writer *writer = png_get_error_ptr(png);
    snprintf(writer->message, sizeof writer->message, "%s", message);
    longjmp(writer->failed, 1);
}
static void on_warning(png_structp, png_const_charp)
{
}
static png_voidp allocate(png_structp, png_alloc_size_t bytes)
{
    return mem_alloc(bytes, 1);
}
static void release(png_structp, png_voidp pointer)
{
    mem_free(pointer);
}

static void write_rows(png_structp png, png_infop info, FILE *stream, const unsigned char *pixels,
                       uint32_t width, uint32_t height)
{
    png_init_io(png, stream);
    png_set_compression_level(png, 4);
    png_set_IHDR(png, info, width, height, 8, PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    for (uint32_t y = 0; y < height; y++)
        png_write_row(png, pixels + 4 * (size_t)y * width);
    png_write_end(png, info);
}

/* False: writer->message says why. */
static bool write_stream(struct writer *writer, FILE *stream, const unsigned char *pixels,
                         uint32_t width, uint32_t height)
{
    png_infop volatile info = NULL;
    png_structp volatile png = NULL;
    bool volatile done = false;
    if (setjmp(writer->failed) == 0) {
        png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, writer, on_error, on_warning, NULL,
                                        allocate, release);
        if (png)
            info = png_create_info_struct(png);
        if (info) {
            write_rows(png, info, stream, pixels, width, height);
            done = true;
        } else {
            snprintf(writer->message, sizeof writer->message, "out of memory");
        }
    }
    png_structp doomed = png;
    png_infop doomed_info = info;
    png_destroy_write_struct(&doomed, &doomed_info);
    return done;
}

enum stp_result stp_image_write_png(const struct stp_env *env, const struct stp_image *image,
                                    const char *path, double stops)
{
    struct file_output out = { 0 };
    unsigned char *pixels = NULL;
    enum stp_result result = convert(env, image, path, stops, &pixels);
    if (result == STP_OK)
        result = file_begin(env, path, &out);
    if (result == STP_OK) {
        struct writer writer = { .message = "" };
        errno = 0;
        if (write_stream(&writer, out.stream, pixels, image->width, image->height)) {
            result = file_commit(env, &out);
        } else {
            result = log_error(env, ferror(out.stream) ? STP_ERROR_IO : STP_ERROR_MEMORY,
                               "%s: cannot write: %s", path,
                               ferror(out.stream) ? strerror(errno) : writer.message);
            file_abandon(&out);
        }
    }
    mem_free(pixels);
    return result;
}
