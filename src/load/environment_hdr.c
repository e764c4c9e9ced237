/* Radiance pictures (.hdr, .pic): a text header, a resolution line, RGBE scanlines that are flat,
 * or run-length coded in the old or the new way. */
#include "load/environment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

#define MOST_LINE 4096

struct hdr {
    const struct stp_env *env;
    const char *path;
    const unsigned char *data;
    size_t size, at;
    double exposure, gamma; /* what the values were multiplied by, and raised to 1/gamma */
    /* Scanlines run along one axis and follow each other along the other. */
    uint32_t lines, length;
    bool by_column, line_reversed, reversed;
};

static enum stp_result damaged(const struct hdr *h, const char *what)
{
    return log_error(h->env, STP_ERROR_FORMAT, "%s: %s (byte %zu)", h->path, what, h->at);
}

bool environment_is_hdr(const struct file_bytes *bytes)
{
    return bytes->size > 2 && memcmp(bytes->data, "#?", 2) == 0;
}

/* The next line without its end, in `line`; false at the end of the data or when it is too long. */
static bool next_line(struct hdr *h, char line[MOST_LINE])
{
    size_t length = 0;
    while (h->at < h->size && h->data[h->at] != '\n' && length < MOST_LINE - 1)
        line[length++] = (char)h->data[h->at++];
    if (h->at == h->size || h->data[h->at] != '\n')
        return false;
    h->at++;
    if (length && line[length - 1] == '\r')
        length--;
    line[length] = 0;
    return true;
}

/* The number after `key`; false when the line is another's. */
static bool keyed(const char *line, const char *key, double *value)
{
    size_t length = strlen(key);
    if (strncmp(line, key, length) != 0)
        return false;
    *value = strtod(line + length, NULL);
    return true;
}

static enum stp_result header_line(struct hdr *h, const char *line)
{
    double value;
    if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
        return damaged(h, strcmp(line + 7, "32-bit_rle_xyze") == 0
                              ? "XYZE colours are not read; convert it to RGBE (ra_xyze -r)"
                              : "a FORMAT that is not 32-bit_rle_rgbe");
    bool exposure = keyed(line, "EXPOSURE=", &value);
    if (exposure || keyed(line, "GAMMA=", &value)) {
        if (!(value > 0 && value <= 1e30))
            return damaged(h, "EXPOSURE or GAMMA is no positive number");
        if (exposure)
            h->exposure *= value;
        else
            h->gamma = value;
    }
    return STP_OK;
}

/* "-Y 512 +X 1024" and its seven turns and mirrors. */
static enum stp_result resolution(struct hdr *h, const char *line)
{
    char sign[2], axis[2], *end = (char *)line;
    unsigned long side[2];
    for (int i = 0; i < 2; i++) {
        end += strspn(end, " ");
        sign[i] = end[0];
        axis[i] = sign[i] ? end[1] : 0;
        if ((sign[i] != '+' && sign[i] != '-') || (axis[i] != 'X' && axis[i] != 'Y') ||
            end[2] != ' ')
            return damaged(h, "no resolution line such as -Y 512 +X 1024");
        side[i] = strtoul(end + 3, &end, 10);
    }
    if (axis[0] == axis[1] || side[0] < 1 || side[1] < 1 || side[0] > ENVIRONMENT_MOST_SIDE ||
        side[1] > ENVIRONMENT_MOST_SIDE)
        return damaged(h, "its resolution line names one axis twice, or sides not in 1 .. 16384");
    h->lines = (uint32_t)side[0];
    h->length = (uint32_t)side[1];
    h->by_column = axis[0] == 'X';
    /* Y grows upwards, rows go down. */
    h->line_reversed = sign[0] == (h->by_column ? '-' : '+');
    h->reversed = sign[1] == (h->by_column ? '+' : '-');
    /* The shortest scanline is one pixel of four bytes. */
    if (h->lines > (h->size - h->at) / 4)
        return damaged(h, "its data are shorter than its resolution line says");
    return STP_OK;
}

static enum stp_result header(struct hdr *h)
{
    char *line = mem_alloc(MOST_LINE, 1);
    enum stp_result result = STP_OK;
    if (!line)
        return log_no_memory(h->env, MOST_LINE, h->path);
    do {
        if (!next_line(h, line))
            result = damaged(h, "its header does not end");
        else
            result = header_line(h, line);
    } while (result == STP_OK && line[0]);
    if (result == STP_OK)
        result = next_line(h, line) ? resolution(h, line) : damaged(h, "no resolution line");
    mem_free(line);
    return result;
}

/* One byte plane of a scanline: runs (count + 128, value) and literals (count, values). */
static enum stp_result new_plane(struct hdr *h, unsigned char *out)
{
    for (uint32_t x = 0; x < h->length;) {
        if (h->size - h->at < 2)
            return damaged(h, "its data end within a scanline");
        unsigned code = h->data[h->at++], run = code > 128 ? code - 128 : code;
        if (run == 0 || run > h->length - x || (code <= 128 && run > h->size - h->at))
            return damaged(h, "a run that does not fit its scanline");
        for (unsigned i = 0; i < run; i++)
            out[4 * (x + i)] = h->data[code > 128 ? h->at : h->at + i];
        h->at += code > 128 ? 1 : run;
        x += run;
    }
    return STP_OK;
}

/* Flat pixels; 1 1 1 n repeats the last one n times, and what follows at once counts in 256s. */
static enum stp_result old_scanline(struct hdr *h, unsigned char *out)
{
    unsigned shift = 0;
    for (uint32_t x = 0; x < h->length;) {
        const unsigned char *p = h->data + h->at;
        if (h->size - h->at < 4)
            return damaged(h, "its data end within a scanline");
        h->at += 4;
        if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
            memcpy(out + 4 * x++, p, 4);
            shift = 0;
            continue;
        }
        uint64_t run = shift < 24 ? (uint64_t)p[3] << shift : UINT64_MAX;
        if (x == 0 || run > h->length - x)
            return damaged(h, "a run that does not fit its scanline");
        for (; run > 0; run--, x++)
            memcpy(out + 4 * x, out + 4 * (x - 1), 4);
        shift += 8;
    }
    return STP_OK;
}

static enum stp_result scanline(struct hdr *h, unsigned char *out)
{
    const unsigned char *p = h->data + h->at;
    if (h->length < 8 || h->length > 32767 || h->size - h->at < 4 || p[0] != 2 || p[1] != 2 ||
        (p[2] << 8 | p[3]) != (int)h->length)
        return old_scanline(h, out);
    h->at += 4;
    enum stp_result result = STP_OK;
    for (int plane = 0; plane < 4 && result == STP_OK; plane++)
        result = new_plane(h, out + plane);
    return result;
}

static void decode(const struct hdr *h, const unsigned char *rgbe, float texel[3])
{
    double scale = rgbe[3] ? ldexp(1, rgbe[3] - 136) : 0;
    for (int k = 0; k < 3; k++) {
        double v = rgbe[k] * scale;
        texel[k] = (float)((h->gamma == 1 ? v : pow(v, h->gamma)) / h->exposure);
    }
}

static enum stp_result pixels(struct hdr *h, unsigned char *line, struct environment_map *map)
{
    for (uint32_t i = 0; i < h->lines; i++) {
        uint32_t along = h->line_reversed ? h->lines - 1 - i : i;
        enum stp_result result = scanline(h, line);
        if (result != STP_OK)
            return result;
        for (uint32_t k = 0; k < h->length; k++) {
            uint32_t across = h->reversed ? h->length - 1 - k : k;
            size_t x = h->by_column ? along : across, y = h->by_column ? across : along;
            decode(h, line + 4 * k, map->texel[y * map->width + x]);
        }
    }
    return STP_OK;
}

enum stp_result environment_read_hdr(const struct stp_env *env, const char *path,
                                     const struct file_bytes *bytes, struct environment_map *map)
{
    struct hdr h = { .env = env,
                     .path = path,
                     .data = bytes->data,
                     .size = bytes->size,
                     .exposure = 1,
                     .gamma = 1 };
    struct environment_map read = { 0 };
    enum stp_result result = header(&h);
    if (result != STP_OK)
        return result;
    result = environment_allocate(env, path, h.by_column ? h.lines : h.length,
                                  h.by_column ? h.length : h.lines, &read);
    if (result != STP_OK)
        return result;
    unsigned char *line = mem_alloc(h.length, 4);
    result = line ? pixels(&h, line, &read) : log_no_memory(env, (size_t)h.length * 4, path);
    mem_free(line);
    if (result == STP_OK)
        *map = read;
    else
        environment_map_release(&read);
    return result;
}
