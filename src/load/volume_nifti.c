/* NIfTI-1 in one file (.nii, .nii.gz). The header's affine only chooses and turns axes: an oblique
 * volume is kept straight. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "load/volume.h"

#define HEADER 348

struct nifti {
    const struct stp_env *env;
    const char *path;
    const unsigned char *data;
    bool big_endian;
};

static uint32_t word(const struct nifti *file, size_t at, unsigned size)
{
    uint32_t bits = 0;
    for (unsigned i = 0; i < size; i++)
        bits |= (uint32_t)file->data[at + (file->big_endian ? size - 1 - i : i)] << (8 * i);
    return bits;
}

static int16_t short_at(const struct nifti *file, size_t at)
{
    return (int16_t)word(file, at, 2);
}

static double float_at(const struct nifti *file, size_t at)
{
    uint32_t bits = word(file, at, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

bool nifti_probe(const struct file_bytes *bytes)
{
    return bytes->size >= HEADER &&
           (memcmp(bytes->data + 344, "n+1", 4) == 0 || memcmp(bytes->data + 344, "ni1", 4) == 0);
}

static enum record_type type_of(int code)
{
    static const struct {
        int code;
        enum record_type type;
    } types[] = { { 2, RECORD_UINT8 },    { 4, RECORD_INT16 },    { 8, RECORD_INT32 },
                  { 16, RECORD_FLOAT32 }, { 64, RECORD_FLOAT64 }, { 256, RECORD_INT8 },
                  { 512, RECORD_UINT16 }, { 768, RECORD_UINT32 }, { 1024, RECORD_INT64 },
                  { 1280, RECORD_UINT64 } };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i].code == code)
            return types[i].type;
    return RECORD_NONE;
}

/* The rotation of the quaternion (NIfTI's method 2); its third axis times qfac. */
static void of_quaternion(const struct nifti *file, struct voxels *v)
{
    double b = float_at(file, 256), c = float_at(file, 260), d = float_at(file, 264);
    double a = sqrt(fmax(0, 1 - b * b - c * c - d * d));
    double q = float_at(file, 76) < 0 ? -1 : 1;
    const double column[3][3] = {
        { a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c) },
        { 2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b) },
        { 2 * (b * d + a * c) * q, 2 * (c * d - a * b) * q, (a * a + d * d - c * c - b * b) * q },
    };
    memcpy(v->direction, column, sizeof column);
    for (int i = 0; i < 3; i++)
        v->origin[i] = float_at(file, 268 + 4 * (size_t)i);
    v->has_origin = true;
}

/* Its columns are the axes' steps: pixdim has no say in it (NIfTI's method 3). */
static void of_affine(const struct nifti *file, struct voxels *v)
{
    for (int axis = 0; axis < 3; axis++) {
        double step[3], length = 0;
        for (int world = 0; world < 3; world++) {
            step[world] = float_at(file, 280 + 16 * (size_t)world + 4 * (size_t)axis);
            length = hypot(length, step[world]);
        }
        v->spacing[axis] = length;
        for (int world = 0; world < 3; world++)
            v->direction[axis][world] = length > 0 ? step[world] / length : 0;
    }
    for (int world = 0; world < 3; world++)
        v->origin[world] = float_at(file, 292 + 16 * (size_t)world);
    v->has_origin = true;
}

static enum stp_result read_dims(const struct nifti *file, struct voxels *v)
{
    int rank = short_at(file, 40);
    for (int i = 0; i < 3; i++) {
        int length = short_at(file, 42 + 2 * (size_t)i);
        v->dims[i] = length > 0 ? (uint64_t)length : 0;
        v->spacing[i] = fabs(float_at(file, 80 + 4 * (size_t)i));
        if (v->spacing[i] == 0)
            v->spacing[i] = 1;
    }
    if (rank < 3 || rank > 7)
        return log_error(file->env, STP_ERROR_FORMAT,
                         "%s: byte 40: %d dimensions; a volume has three", file->path, rank);
    if (rank > 3 && short_at(file, 48) > 1)
        log_warning(file->env, "%s: %d volumes one after the other: the first is read", file->path,
                    short_at(file, 48));
    return STP_OK;
}

/* Of what the reader will refuse by its header, nothing more. */
size_t nifti_stated(const struct file_bytes *head)
{
    const struct stp_env quiet = { .log = log_nothing };
    struct nifti file = { &quiet, "", head->data, false };
    struct voxels v = { 0 };
    file.big_endian = word(&file, 0, 4) != HEADER;
    v.type = type_of(short_at(&file, 70));
    double offset = float_at(&file, 108);
    if (v.type == RECORD_NONE || read_dims(&file, &v) != STP_OK ||
        voxels_check(&quiet, "", &v) != STP_OK || !(offset >= HEADER && offset < 0x1p40))
        return 0;
    return voxels_end(&v, (size_t)offset, 0);
}

enum stp_result nifti_read(const struct stp_env *env, const char *path,
                           const struct file_bytes *bytes, struct grid *grid)
{
    struct nifti file = { env, path, bytes->data, false };
    struct voxels v = { .up = STP_UP_Z, .format = "NIfTI-1" };
    file.big_endian = word(&file, 0, 4) != HEADER;
    if (word(&file, 0, 4) != HEADER)
        return log_error(env, STP_ERROR_FORMAT, "%s: byte 0: a NIfTI-1 header is %d bytes long",
                         path, HEADER);
    if (bytes->data[345] == 'i')
        return log_error(env, STP_ERROR_FORMAT,
                         "%s: the voxels of this NIfTI are in an .img beside it: join them into "
                         "one .nii",
                         path);
    v.big_endian = file.big_endian;
    v.type = type_of(short_at(&file, 70));
    if (v.type == RECORD_NONE)
        return log_error(env, STP_ERROR_FORMAT, "%s: byte 70: voxels of datatype %d are no scalars",
                         path, short_at(&file, 70));
    enum stp_result result = read_dims(&file, &v);
    if (result != STP_OK)
        return result;
    v.slope = float_at(&file, 112);
    v.intercept = float_at(&file, 116);
    if (isnan(v.slope)) /* how some write that there is none */
        v.slope = v.intercept = 0;
    if (short_at(&file, 254) > 0)
        of_affine(&file, &v);
    else if (short_at(&file, 252) > 0)
        of_quaternion(&file, &v);
    double offset = float_at(&file, 108);
    bool sane = offset >= HEADER && offset <= (double)bytes->size;
    return sane ? grid_from_voxels(env, path, bytes, (size_t)offset, &v, grid)
                : log_error(env, STP_ERROR_FORMAT,
                            "%s: byte 108: voxels cannot begin at byte %g of %zu", path, offset,
                            bytes->size);
}
