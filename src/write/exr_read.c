/* Flat EXR files to stp_image: scanline or tiled, float, half or uint. */
#include "write/exr_read.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

#define MAX_SIDE 65536
/* No lossless compression of EXR shrinks by more (zlib: 1032). */
#define MAX_RATIO 2048
/* Planes of a display window that the data do not fill may be as large whatever the file's size: a
 * small part of a picture of 8192 x 4096 in eight channels. */
#define MAX_EMPTY ((double)(1 << 30))

static enum stp_result refuse(const struct stp_env *env, const struct exr_source *s,
                              const char *what)
{
    return log_error(env, STP_ERROR_FORMAT, "%s: %s", s->io->path, what);
}

/* Of several parts the first is read, which is said. */
static void warn_of_parts(const struct stp_env *env, const struct exr_source *s)
{
    int parts = 1;
    const char *name = NULL;
    if (exr_get_count(s->context, &parts) != EXR_ERR_SUCCESS || parts < 2)
        return;
    if (exr_get_name(s->context, 0, &name) != EXR_ERR_SUCCESS || !name)
        name = "";
    log_warning(env, "%s: of its %d parts only the first is read: \"%s\"", s->io->path, parts,
                name);
}

static enum stp_result check_kind(const struct stp_env *env, struct exr_source *s)
{
    exr_storage_t storage;
    exr_compression_t compression;
    exr_result_t code = exr_get_storage(s->context, 0, &storage);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_compression(s->context, 0, &compression);
    if (code != EXR_ERR_SUCCESS)
        return exr_io_failed(env, s->io, code, "read");
    if (storage == EXR_STORAGE_DEEP_SCANLINE || storage == EXR_STORAGE_DEEP_TILED)
        return refuse(env, s, "a deep EXR; only flat pictures are read (flatten it first)");
    if (compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB)
        return refuse(env, s,
                      "DWAA/DWAB is not decoded yet by OpenEXR's C core; convert it to zip "
                      "(oiiotool in.exr --compression zip -o out.exr)");
    s->tiled = storage == EXR_STORAGE_TILED;
    return STP_OK;
}

static enum stp_result find_chunks(const struct stp_env *env, struct exr_source *s)
{
    int64_t width = (int64_t)s->data.max.x - s->data.min.x + 1;
    int64_t height = (int64_t)s->data.max.y - s->data.min.y + 1;
    exr_result_t code;
    if (s->tiled)
        code = exr_get_tile_sizes(s->context, 0, 0, 0, &s->chunk_width, &s->chunk_height);
    else
        code = exr_get_scanlines_per_chunk(s->context, 0, &s->chunk_height);
    if (code != EXR_ERR_SUCCESS)
        return exr_io_failed(env, s->io, code, "read");
    if (!s->tiled || s->chunk_width > width)
        s->chunk_width = (int32_t)width;
    if (s->chunk_height > height)
        s->chunk_height = (int32_t)height;
    if (s->chunk_width < 1 || s->chunk_height < 1)
        return refuse(env, s, "damaged: its chunks have no size");
    s->columns = (int32_t)((width + s->chunk_width - 1) / s->chunk_width);
    s->rows = (int32_t)((height + s->chunk_height - 1) / s->chunk_height);
    return STP_OK;
}

static bool sane(const exr_attr_box2i_t *box)
{
    int64_t width = (int64_t)box->max.x - box->min.x + 1;
    int64_t height = (int64_t)box->max.y - box->min.y + 1;
    return width > 0 && height > 0 && width <= MAX_SIDE && height <= MAX_SIDE;
}

static enum stp_result check_windows(const struct stp_env *env, struct exr_source *s)
{
    exr_result_t code = exr_get_data_window(s->context, 0, &s->data);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_display_window(s->context, 0, &s->display);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_channels(s->context, 0, &s->list);
    if (code != EXR_ERR_SUCCESS)
        return exr_io_failed(env, s->io, code, "read");
    if (!sane(&s->data) || !sane(&s->display))
        return refuse(env, s, "its windows are empty, or larger than 65536 pixels");
    if (s->list->num_channels < 1)
        return refuse(env, s, "it has no channels");
    enum stp_result result = find_chunks(env, s);
    if (result != STP_OK)
        return result;
    double bytes =
        (double)s->columns * s->rows * s->chunk_width * s->chunk_height * s->list->num_channels * 2;
    /* Whole chunks may count the picture up to four times. */
    if (bytes > (double)s->io->bytes->size * MAX_RATIO * 4)
        return refuse(env, s, "damaged: its windows are too large for the size of the file");
    double shown = ((double)s->display.max.x - s->display.min.x + 1) *
                   ((double)s->display.max.y - s->display.min.y + 1) * s->list->num_channels * 4;
    if (shown > MAX_EMPTY && shown > (double)s->io->bytes->size * MAX_RATIO * 4)
        return refuse(env, s, "its display window is too large for the size of the file");
    return STP_OK;
}

static enum stp_result check_channels(const struct stp_env *env, const struct exr_source *s)
{
    for (int i = 0; i < s->list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &s->list->entries[i];
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return log_error(env, STP_ERROR_FORMAT,
                             "%s: channel %s is subsampled (%d x %d), which is not read",
                             s->io->path, entry->name.str, entry->x_sampling, entry->y_sampling);
    }
    return STP_OK;
}

static enum stp_result add_planes(const struct stp_env *env, const struct exr_source *s,
                                  struct stp_image *image)
{
    for (int i = 0; i < s->list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &s->list->entries[i];
        struct stp_channel *channel;
        if (strlen(entry->name.str) >= sizeof channel->name) {
            log_warning(env, "%s: channel %s is left out: its name is too long", s->io->path,
                        entry->name.str);
            continue;
        }
        enum stp_channel_type type =
            entry->pixel_type == EXR_PIXEL_UINT ? STP_CHANNEL_UINT : STP_CHANNEL_FLOAT;
        enum stp_result result = stp_image_add(env, image, entry->name.str, type, &channel);
        if (result != STP_OK)
            return result;
        channel->half = entry->pixel_type == EXR_PIXEL_HALF;
        /* Outside the data window nothing is: depth is infinite there. */
        if (strcmp(channel->name, "Z") == 0 && type == STP_CHANNEL_FLOAT)
            for (size_t p = 0; p < (size_t)image->width * image->height; p++)
                channel->data.f[p] = INFINITY;
    }
    return STP_OK;
}

static void read_attributes(const struct exr_source *s, struct stp_image *image)
{
    exr_attr_v3d_t origin;
    int32_t two_sided;
    const exr_attribute_t *attribute;
    if (exr_get_attribute_by_name(s->context, 0, "stipple:origin", &attribute) == EXR_ERR_SUCCESS &&
        exr_attr_get_v3d(s->context, 0, "stipple:origin", &origin) == EXR_ERR_SUCCESS) {
        image->origin[0] = origin.x;
        image->origin[1] = origin.y;
        image->origin[2] = origin.z;
    }
    if (exr_get_attribute_by_name(s->context, 0, "stipple:twoSided", &attribute) ==
            EXR_ERR_SUCCESS &&
        exr_attr_get_int(s->context, 0, "stipple:twoSided", &two_sided) == EXR_ERR_SUCCESS)
        image->two_sided = two_sided != 0;
}

static enum stp_result fill_image(const struct stp_env *env, struct exr_source *s,
                                  struct stp_image *image)
{
    enum stp_result result = add_planes(env, s, image);
    if (result != STP_OK)
        return result;
    s->plane = mem_alloc((size_t)s->list->num_channels, sizeof *s->plane);
    if (!s->plane)
        return log_no_memory(env, (size_t)s->list->num_channels * sizeof *s->plane, s->io->path);
    for (int i = 0; i < s->list->num_channels; i++)
        s->plane[i] = stp_image_find(image, s->list->entries[i].name.str);
    read_attributes(s, image);
    result = exr_unpack_image(env, s, image);
    mem_free(s->plane);
    return result;
}

static enum stp_result read_part(const struct stp_env *env, struct exr_source *s,
                                 struct stp_image **image)
{
    struct stp_image *read = NULL;
    warn_of_parts(env, s);
    enum stp_result result = check_kind(env, s);
    if (result == STP_OK)
        result = check_windows(env, s);
    if (result == STP_OK)
        result = check_channels(env, s);
    if (result != STP_OK)
        return result;
    result = stp_image_create(env, (uint32_t)(s->display.max.x - s->display.min.x + 1),
                              (uint32_t)(s->display.max.y - s->display.min.y + 1), &read);
    if (result != STP_OK)
        return result;
    result = fill_image(env, s, read);
    if (result == STP_OK)
        *image = read;
    else
        stp_image_destroy(&read);
    return result;
}

enum stp_result stp_image_read_exr(const struct stp_env *env, const char *path,
                                   struct stp_image **image)
{
    struct file_bytes bytes = { 0 };
    enum stp_result result = file_read(env, path, &bytes);
    if (result != STP_OK)
        return result;
    struct exr_io io = { .path = path, .bytes = &bytes };
    struct exr_source source = { .io = &io };
    exr_context_initializer_t init = exr_io_initializer(&io);
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_result_t code = exr_start_read(&source.context, path, &init);
    if (code == EXR_ERR_SUCCESS) {
        result = read_part(env, &source, image);
        exr_finish(&source.context);
    } else {
        result = exr_io_failed(env, &io, code, "read");
    }
    file_release(&bytes);
    return result;
}
