/* Voxels of any scalar type, byte order and orientation to floats along the world's axes. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "load/volume.h"

#define MOST_VOXELS  ((uint64_t)1 << 32) /* indices of voxels have 32 bits */
#define MOST_SPACING 1e12

void grid_release(struct grid *grid)
{
    mem_free(grid->value);
    *grid = (struct grid){ 0 };
}

size_t grid_count(const struct grid *grid)
{
    return (size_t)grid->dims[0] * grid->dims[1] * grid->dims[2];
}

void grid_measure(struct grid *grid)
{
    size_t count = grid_count(grid);
    double low = INFINITY, high = -INFINITY;
    grid->not_finite = 0;
    for (size_t i = 0; i < count; i++) {
        double v = (double)grid->value[i];
        if (!isfinite(v)) {
            grid->not_finite++;
            continue;
        }
        low = v < low ? v : low;
        high = v > high ? v : high;
    }
    bool any = low <= high;
    grid->low = any ? low : 0;
    grid->high = any ? high : 0;
}

enum stp_result voxels_check(const struct stp_env *env, const char *path, const struct voxels *v)
{
    uint64_t count = 1;
    for (int i = 0; i < 3; i++) {
        if (v->dims[i] == 0 || v->dims[i] > UINT32_MAX)
            return log_error(env, STP_ERROR_FORMAT, "%s: %llu x %llu x %llu is no size of a volume",
                             path, (unsigned long long)v->dims[0], (unsigned long long)v->dims[1],
                             (unsigned long long)v->dims[2]);
        if (!(v->spacing[i] > 0 && v->spacing[i] < MOST_SPACING) ||
            (v->has_origin && !isfinite(v->origin[i])))
            return log_error(env, STP_ERROR_FORMAT,
                             "%s: a spacing of %g or an origin of %g is no place for a voxel", path,
                             v->spacing[i], v->origin[i]);
        /* Each factor is below 2^32 and the product before it too: no overflow. */
        count = count < MOST_VOXELS ? count * v->dims[i] : count;
    }
    if (count >= MOST_VOXELS)
        return log_error(env, STP_ERROR_FORMAT, "%s: %llu x %llu x %llu: at most 2^32 - 1 voxels",
                         path, (unsigned long long)v->dims[0], (unsigned long long)v->dims[1],
                         (unsigned long long)v->dims[2]);
    if (!isfinite(v->slope) || !isfinite(v->intercept))
        return log_error(env, STP_ERROR_FORMAT, "%s: a slope of %g, %g scales no values", path,
                         v->slope, v->intercept);
    return STP_OK;
}

static double voxel_value(const unsigned char *p, enum record_type type, bool big_endian)
{
    uint64_t bits = 0;
    size_t size = record_type_size(type);
    for (size_t i = 0; i < size; i++)
        bits |= (uint64_t)p[big_endian ? size - 1 - i : i] << (8 * i);
    float f;
    double d;
    switch (type) {
    case RECORD_INT8:
        return (int8_t)bits;
    case RECORD_INT16:
        return (int16_t)bits;
    case RECORD_INT32:
        return (int32_t)bits;
    case RECORD_INT64:
        return (double)(int64_t)bits;
    case RECORD_FLOAT32: {
        uint32_t low = (uint32_t)bits;
        memcpy(&f, &low, sizeof f);
        return (double)f;
    }
    case RECORD_FLOAT64:
        memcpy(&d, &bits, sizeof d);
        return d;
    default:
        return (double)bits;
    }
}

/* World axis w runs along file axis `file[w]`, backwards where `back[w]`. */
struct orientation {
    int file[3];
    bool back[3];
};

/* The permutation that keeps most of the directions' lengths along the axes. */
static struct orientation orient(const double direction[3][3])
{
    static const int orders[6][3] = { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 },
                                      { 1, 2, 0 }, { 2, 0, 1 }, { 2, 1, 0 } };
    struct orientation best = { .file = { 0, 1, 2 } };
    double most = 0;
    for (int o = 0; o < 6; o++) {
        double kept = 0;
        for (int w = 0; w < 3; w++)
            kept += fabs(direction[orders[o][w]][w]);
        if (!(kept > most * (1 + 1e-9)))
            continue;
        most = kept;
        for (int w = 0; w < 3; w++) {
            best.file[w] = orders[o][w];
            best.back[w] = direction[orders[o][w]][w] < 0;
        }
    }
    return best;
}

struct conversion {
    const unsigned char *data;
    const struct voxels *voxels;
    struct grid *grid;
    int64_t first, step[3]; /* voxels of the file along the world's axes */
};

static void convert_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct conversion *c = context;
    const struct voxels *v = c->voxels;
    const struct grid *grid = c->grid;
    size_t size = record_type_size(v->type);
    bool scaled = v->slope != 0 && (v->slope != 1 || v->intercept != 0);
    for (size_t row = begin; row < end; row++) {
        float *out = grid->value + row * grid->dims[0];
        int64_t at = c->first + (int64_t)(row % grid->dims[1]) * c->step[1] +
                     (int64_t)(row / grid->dims[1]) * c->step[2];
        for (uint32_t i = 0; i < grid->dims[0]; i++, at += c->step[0]) {
            double value = voxel_value(c->data + (size_t)at * size, v->type, v->big_endian);
            out[i] = (float)(scaled ? value * v->slope + v->intercept : value);
        }
    }
}

static void lay_out(struct conversion *c, struct grid *grid)
{
    const struct voxels *v = c->voxels;
    const int64_t stride[3] = { 1, (int64_t)v->dims[0], (int64_t)(v->dims[0] * v->dims[1]) };
    struct orientation o = orient(v->direction);
    for (int w = 0; w < 3; w++) {
        int f = o.file[w];
        grid->dims[w] = (uint32_t)v->dims[f];
        grid->spacing[w] = v->spacing[f];
        double back = (double)(v->dims[f] - 1) * v->spacing[f];
        double start = v->has_origin ? v->origin[w] : 0.5 * v->spacing[f];
        grid->origin[w] = o.back[w] && v->has_origin ? start - back : start;
        c->step[w] = o.back[w] ? -stride[f] : stride[f];
        c->first += o.back[w] ? (int64_t)(v->dims[f] - 1) * stride[f] : 0;
    }
}

enum stp_result grid_from_voxels(const struct stp_env *env, const char *path,
                                 const struct file_bytes *bytes, size_t offset,
                                 const struct voxels *voxels, struct grid *grid)
{
    enum stp_result result = voxels_check(env, path, voxels);
    if (result != STP_OK)
        return result;
    size_t count = (size_t)(voxels->dims[0] * voxels->dims[1] * voxels->dims[2]);
    size_t wanted = count * record_type_size(voxels->type);
    if (offset > bytes->size || wanted > bytes->size - offset)
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: byte %zu: %zu bytes of voxels are claimed, the file ends after %zu",
                         path, offset, wanted, bytes->size > offset ? bytes->size - offset : 0);
    struct grid made = { .up = voxels->up };
    struct conversion conversion = { bytes->data + offset, voxels, &made, 0, { 0 } };
    lay_out(&conversion, &made);
    memcpy(made.format, voxels->format, sizeof made.format);
    made.value = mem_alloc(count, sizeof *made.value);
    if (!made.value)
        return log_no_memory(env, count * sizeof *made.value, path);
    parallel_for(env, (size_t)made.dims[1] * made.dims[2], 64, convert_rows, &conversion);
    grid_measure(&made);
    *grid = made;
    return STP_OK;
}

size_t voxels_end(const struct voxels *v, size_t begin, double skip)
{
    size_t voxels = (size_t)(v->dims[0] * v->dims[1] * v->dims[2]) * record_type_size(v->type);
    if (!(skip >= 0 && skip < 0x1p40))
        return FILE_ALL;
    return begin + (size_t)skip + voxels;
}

enum stp_result grid_from_bytes(const struct stp_env *env, const char *path,
                                const struct voxel_bytes *from, const struct voxels *v,
                                struct grid *grid)
{
    size_t wanted = (size_t)(v->dims[0] * v->dims[1] * v->dims[2]) * record_type_size(v->type);
    const struct file_bytes *bytes = from->bytes;
    struct file_bytes unpacked = { 0 };
    size_t begin = from->begin;
    if (from->packed) {
        const struct file_use use = { .most = voxels_end(v, 0, from->skip) };
        enum stp_result result =
            file_inflate(env, path, bytes->data + begin, bytes->size - begin, &use, &unpacked);
        if (result != STP_OK)
            return result;
        bytes = &unpacked;
        begin = 0;
    }
    if (from->skip == -1 && wanted <= bytes->size)
        begin = bytes->size - wanted;
    else if (from->skip > 0)
        begin =
            from->skip < (double)(bytes->size - begin) ? begin + (size_t)from->skip : bytes->size;
    enum stp_result result = grid_from_voxels(env, path, bytes, begin, v, grid);
    file_release(&unpacked);
    return result;
}
