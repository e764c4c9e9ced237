#include <string.h>

#include "base/log.h"
#include "base/thread.h"
#include "load/ply.h"

#define GRAIN 8192 /* vertices a thread converts at a time: their bytes stay in its cache */

/* One column of consecutive records. */
struct run {
    const unsigned char *in;
    size_t stride, first, count;
    struct slot slot;
    bool swap;
};

static inline uint8_t bits8(const unsigned char *p, bool)
{
    return *p;
}
static inline uint16_t bits16(const unsigned char *p, bool swap)
{
    uint16_t bits;
    memcpy(&bits, p, sizeof bits);
    return swap ? __builtin_bswap16(bits) : bits;
}
static inline uint32_t bits32(const unsigned char *p, bool swap)
{
    uint32_t bits;
    memcpy(&bits, p, sizeof bits);
    return swap ? __builtin_bswap32(bits) : bits;
}
static inline uint64_t bits64(const unsigned char *p, bool swap)
{
    uint64_t bits;
    memcpy(&bits, p, sizeof bits);
    return swap ? __builtin_bswap64(bits) : bits;
}
static inline float read_float(const unsigned char *p, bool swap)
{
    uint32_t bits = bits32(p, swap);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
static inline double read_double(const unsigned char *p, bool swap)
{
    uint64_t bits = bits64(p, swap);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* A loop per type: the branches on swap and on the slot leave the loop. */
#define DEFINE_CONVERT(name, value)                                                                \
    static void convert_##name(const struct run *run)                                              \
    {                                                                                              \
        const unsigned char *p = run->in;                                                          \
        char *out = run->slot.base + run->first * run->slot.stride;                                \
        const size_t stride = run->stride, step = run->slot.stride;                                \
        const bool swap = run->swap;                                                               \
        if (run->slot.wide)                                                                        \
            for (size_t i = 0; i < run->count; i++, p += stride, out += step)                      \
                *(double *)(void *)out = (double)(value);                                          \
        else                                                                                       \
            for (size_t i = 0; i < run->count; i++, p += stride, out += step)                      \
                *(float *)(void *)out = (float)(value);                                            \
    }

DEFINE_CONVERT(int8, (int8_t)bits8(p, swap))
DEFINE_CONVERT(uint8, bits8(p, swap))
DEFINE_CONVERT(int16, (int16_t)bits16(p, swap))
DEFINE_CONVERT(uint16, bits16(p, swap))
DEFINE_CONVERT(int32, (int32_t)bits32(p, swap))
DEFINE_CONVERT(uint32, bits32(p, swap))
DEFINE_CONVERT(float32, read_float(p, swap))
DEFINE_CONVERT(float64, read_double(p, swap))

typedef void (*convert_fn)(const struct run *run);

static convert_fn convert_of(enum ply_type type)
{
    static const convert_fn convert[] = { NULL,           convert_int8,    convert_uint8,
                                          convert_int16,  convert_uint16,  convert_int32,
                                          convert_uint32, convert_float32, convert_float64 };
    return convert[type];
}

/* Little-endian hosts are the only ones supported; the build says so. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "a little-endian host");

struct body {
    const unsigned char *records;
    const struct ply_property *property;
    const struct table *table;
    size_t stride;
    bool swap;
};

static void convert_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct body *body = context;
    size_t offset = 0;
    for (unsigned i = 0; i < body->table->count; i++) {
        for (int s = 0; s < 2; s++) {
            struct run run = { body->records + begin * body->stride + offset,
                               body->stride,
                               begin,
                               end - begin,
                               body->table->column[i].slot[s],
                               body->swap };
            if (run.slot.base)
                convert_of(body->property[i].type)(&run);
        }
        offset += ply_type_size(body->property[i].type);
    }
}

struct walk {
    const struct stp_env *env;
    const char *path;
    const struct file_bytes *bytes;
    const struct ply_header *header;
    const struct ply_element *element;
    size_t at, row;
};

static enum stp_result walk_error(const struct walk *walk, const char *what)
{
    char name[32];
    slice_copy(walk->element->name, name, sizeof name);
    return log_error(walk->env, STP_ERROR_FORMAT,
                     "%s: byte %zu: %s in element \"%s\", %zu of %llu: the file is cut short or "
                     "damaged",
                     walk->path, walk->at, what, name, walk->row,
                     (unsigned long long)walk->element->count);
}

static double read_integer(const unsigned char *p, enum ply_type type, bool swap)
{
    double value = 0;
    struct run run = { p, 0, 0, 1, { (char *)&value, 0, true }, swap };
    convert_of(type)(&run);
    return value;
}

static enum stp_result walk_list(struct walk *walk, const struct ply_property *property, bool swap)
{
    size_t length_size = ply_type_size(property->length), left = walk->bytes->size - walk->at;
    if (length_size > left)
        return walk_error(walk, "the file ends");
    double length = read_integer(walk->bytes->data + walk->at, property->length, swap);
    if (length < 0)
        return walk_error(walk, "a list of negative length");
    left -= length_size;
    if (length > (double)(left / ply_type_size(property->type)))
        return walk_error(walk, "a list that is longer than the file");
    walk->at += length_size + (size_t)length * ply_type_size(property->type);
    return STP_OK;
}

static enum stp_result walk_scalar(struct walk *walk, const struct ply_property *property,
                                   const struct column *column, bool swap)
{
    size_t size = ply_type_size(property->type);
    if (size > walk->bytes->size - walk->at)
        return walk_error(walk, "the file ends");
    for (int s = 0; column && s < 2; s++) {
        struct run run = {
            walk->bytes->data + walk->at, size, walk->row, 1, column->slot[s], swap
        };
        if (run.slot.base)
            convert_of(property->type)(&run);
    }
    walk->at += size;
    return STP_OK;
}

/* Records of varying length, one property after the other. Each has at least one byte, so that the
 * file's length bounds the walk whatever the header claims. */
static enum stp_result walk_records(struct walk *walk, const struct table *table)
{
    const struct ply_property *property = walk->header->property + walk->element->first;
    bool swap = walk->header->encoding == PLY_BIG;
    for (; walk->row < walk->element->count; walk->row++)
        for (unsigned i = 0; i < walk->element->properties; i++) {
            enum stp_result result =
                property[i].length
                    ? walk_list(walk, &property[i], swap)
                    : walk_scalar(walk, &property[i], table ? &table->column[i] : NULL, swap);
            if (result != STP_OK)
                return result;
        }
    return STP_OK;
}

enum stp_result ply_binary_skip(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, const struct ply_header *header,
                                const struct ply_element *element, size_t *offset)
{
    struct walk walk = { env, path, bytes, header, element, *offset, 0 };
    bool has_list;
    size_t size = ply_element_size(header, element, &has_list);
    if (size == 0)
        return STP_OK;
    if (has_list) {
        enum stp_result result = walk_records(&walk, NULL);
        if (result == STP_OK)
            *offset = walk.at;
        return result;
    }
    if (element->count > (bytes->size - *offset) / size) {
        walk.row = (bytes->size - *offset) / size;
        walk.at = bytes->size;
        return walk_error(&walk, "the file ends");
    }
    *offset += element->count * size;
    return STP_OK;
}

enum stp_result ply_binary_read(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, const struct ply_header *header,
                                const struct ply_element *element, size_t offset,
                                const struct table *table)
{
    bool has_list;
    size_t size = ply_element_size(header, element, &has_list);
    if (has_list) {
        struct walk walk = { env, path, bytes, header, element, offset, 0 };
        return walk_records(&walk, table);
    }
    struct body body = { bytes->data + offset, header->property + element->first, table, size,
                         header->encoding == PLY_BIG };
    parallel_for(env, element->count, GRAIN, convert_range, &body);
    return STP_OK;
}
