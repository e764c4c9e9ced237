/* Depth and colour from PNG, 8 or 16 bits. */
#include <png.h>
#include <setjmp.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/range.h"

struct reading {
    const struct stp_env *env;
    const char *path;
    const struct file_bytes *bytes;
    size_t at;
    png_bytep row;
    struct range_image image;
    enum stp_result result; /* of what is not libpng's own failure */
    char message[96];
    jmp_buf out;
};

static void on_error(png_structp png, png_const_charp message)
{
    struct reading *r = png_get_error_ptr(png);
    strncpy(r->message, message, sizeof r->message - 1);
    longjmp(r->out, 1);
}

static void on_warning(png_structp, png_const_charp)
{
}

static void take_bytes(png_structp png, png_bytep to, png_size_t count)
{
    struct reading *r = png_get_io_ptr(png);
    if (count > r->bytes->size - r->at)
        png_error(png, "it ends too early");
    memcpy(to, r->bytes->data + r->at, count);
    r->at += count;
}

/* Palettes to colours, 1 to 4 bits to 8, no alpha; 16 bits in the machine's order. */
static void set_up(png_structp png, png_infop info)
{
    png_set_expand(png);
    png_set_strip_alpha(png);
    if (png_get_bit_depth(png, info) == 16)
        png_set_swap(png);
    png_read_update_info(png, info);
}

static void take_row(struct reading *r, png_uint_32 y)
{
    size_t count = (size_t)r->image.width * r->image.channels;
    float *to = r->image.value + y * count;
    const uint16_t *wide = (const uint16_t *)(const void *)r->row;
    for (size_t i = 0; i < count; i++)
        to[i] = r->image.maximum > 255 ? wide[i] : r->row[i];
}

/* Interlaced files are few and would need the whole picture twice: refused. */
static void read_all(struct reading *r, png_structp png, png_infop info)
{
    png_read_info(png, info);
    if (png_get_interlace_type(png, info) != PNG_INTERLACE_NONE)
        png_error(png, "it is interlaced; write it without");
    set_up(png, info);
    r->result =
        range_allocate(r->env, r->path, png_get_image_width(png, info),
                       png_get_image_height(png, info), png_get_channels(png, info), &r->image);
    if (r->result != STP_OK)
        return;
    r->image.maximum = png_get_bit_depth(png, info) == 16 ? 65535 : 255;
    r->row = mem_alloc(png_get_rowbytes(png, info), 1);
    if (!r->row) {
        r->result = log_no_memory(r->env, png_get_rowbytes(png, info), r->path);
        return;
    }
    for (png_uint_32 y = 0; y < r->image.height; y++) {
        png_read_row(png, r->row, NULL);
        take_row(r, y);
    }
    png_read_end(png, NULL); /* and what it says of the whole */
}

enum stp_result range_read_png(const struct stp_env *env, const char *path,
                               const struct file_bytes *bytes, struct range_image *image)
{
    struct reading r = { .env = env, .path = path, .bytes = bytes };
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &r, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info) {
        png_destroy_read_struct(&png, NULL, NULL);
        return log_no_memory(env, 1024, path);
    }
    png_set_user_limits(png, RANGE_MOST_SIDE, RANGE_MOST_SIDE);
    png_set_read_fn(png, &r, take_bytes);
    if (setjmp(r.out) == 0)
        read_all(&r, png, info);
    else
        r.result =
            log_error(env, STP_ERROR_FORMAT, "%s: byte %zu: damaged: %s", path, r.at, r.message);
    png_destroy_read_struct(&png, &info, NULL);
    mem_free(r.row);
    if (r.result == STP_OK)
        *image = r.image;
    else
        range_image_release(&r.image);
    return r.result;
}
