/* Pictures of range images: which format it is, and PGM and PPM. */
#include <string.h>

#include "base/log.h"
#include "load/range.h"

#define PNM_MOST 65535

struct pnm {
    const unsigned char *data;
    size_t size, at;
    uint32_t width, height, maximum;
};

static bool is_space(unsigned char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

/* A whole number of the header, past blanks and comments; the byte after it is a blank. */
static bool header_number(struct pnm *file, uint32_t *value)
{
    uint64_t read = 0;
    size_t digits = 0;
    while (file->at < file->size && (is_space(file->data[file->at]) || file->data[file->at] == '#'))
        if (file->data[file->at++] == '#')
            while (file->at < file->size && file->data[file->at] != '\n')
                file->at++;
    for (; file->at < file->size && digits < 9; file->at++, digits++) {
        unsigned char c = file->data[file->at];
        if (c < '0' || c > '9')
            break;
        read = read * 10 + (c - '0');
    }
    *value = (uint32_t)read;
    return digits > 0 && file->at < file->size && is_space(file->data[file->at]);
}

static void take_samples(const struct pnm *file, size_t count, float *value)
{
    const unsigned char *from = file->data + file->at;
    if (file->maximum < 256)
        for (size_t i = 0; i < count; i++)
            value[i] = from[i];
    else
        for (size_t i = 0; i < count; i++)
            value[i] = (float)(from[2 * i] << 8 | from[2 * i + 1]);
}

static enum stp_result read_pnm(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, struct range_image *image)
{
    struct pnm file = { .data = bytes->data, .size = bytes->size, .at = 2 };
    struct range_image read = { 0 };
    if (!header_number(&file, &file.width) || !header_number(&file, &file.height) ||
        !header_number(&file, &file.maximum) || file.maximum < 1 || file.maximum > PNM_MOST)
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: byte %zu: width, height and a maximum of 1 to 65535 are needed", path,
                         file.at);
    file.at++;
    unsigned channels = bytes->data[1] == '6' ? 3 : 1;
    uint64_t count = (uint64_t)file.width * file.height * channels;
    uint64_t needed = count * (file.maximum < 256 ? 1 : 2);
    if (needed > bytes->size - file.at)
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: byte %zu: %u x %u pixels take %llu bytes, the file has %zu", path,
                         file.at, file.width, file.height, (unsigned long long)needed,
                         bytes->size - file.at);
    enum stp_result result = range_allocate(env, path, file.width, file.height, channels, &read);
    if (result != STP_OK)
        return result;
    read.maximum = file.maximum;
    take_samples(&file, count, read.value);
    *image = read;
    return STP_OK;
}

static bool starts(const struct file_bytes *bytes, const char *magic, size_t length)
{
    return bytes->size >= length && memcmp(bytes->data, magic, length) == 0;
}

enum stp_result range_image_from_bytes(const struct stp_env *env, const char *path,
                                       const struct file_bytes *bytes, enum range_plane plane,
                                       struct range_image *image)
{
    struct range_image read = { 0 };
    enum stp_result result;
    if (starts(bytes, "\x89PNG\r\n\x1a\n", 8))
        result = range_read_png(env, path, bytes, &read);
    else if (starts(bytes, "\x76\x2f\x31\x01", 4))
        result = range_read_exr(env, path, bytes, plane, &read);
    else if (starts(bytes, "P5", 2) || starts(bytes, "P6", 2))
        result = read_pnm(env, path, bytes, &read);
    else
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: byte 0: not a picture that is read (PNG, binary PGM or PPM, EXR): "
                         "convert it to PNG",
                         path);
    if (result == STP_OK && plane == RANGE_DEPTH && read.channels != 1) {
        range_image_release(&read);
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: a depth has one channel, this picture has colours", path);
    }
    if (result == STP_OK)
        *image = read;
    return result;
}

enum stp_result range_image_read(const struct stp_env *env, const char *path,
                                 enum range_plane plane, struct range_image *image)
{
    struct file_bytes bytes;
    enum stp_result result = file_read(env, path, &bytes);
    if (result != STP_OK)
        return result;
    result = range_image_from_bytes(env, path, &bytes, plane, image);
    file_release(&bytes);
    return result;
}
