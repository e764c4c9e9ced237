/* Volumes with headers and without: made in code, read back, damaged, refused. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "base/memory.h"
#include "load/volume.h"
#include "support.h"

#define NX 3
#define NY 4
#define NZ 2

static double voxel(int i, int j, int k)
{
    return i + 10 * j + 100 * k;
}

struct seen {
    struct stp_env env;
    char error[1100];
    unsigned errors, warnings;
};

static void see(void *user, enum stp_log_level level, const char *line)
{
    struct seen *seen = user;
    seen->errors += level == STP_LOG_ERROR;
    seen->warnings += level == STP_LOG_WARNING;
    if (level == STP_LOG_ERROR)
        snprintf(seen->error, sizeof seen->error, "%s", line);
}

static enum stp_result read_volume(const struct buffer *b, struct seen *seen, struct grid *grid)
{
    struct file_bytes bytes = { .data = malloc(b->size ? b->size : 1), .size = b->size };
    memcpy((void *)bytes.data, b->data, b->size);
    *seen = (struct seen){ .env = { .log = see, .threads = 2 } };
    seen->env.user = seen;
    enum stp_result result = volume_from_bytes(&seen->env, "test", &bytes, NULL, NULL, grid);
    assert_int_equal(seen->errors, result != STP_OK);
    free((void *)bytes.data);
    return result;
}

static void put_voxels(struct buffer *b, const char *type, bool big)
{
    for (int k = 0; k < NZ; k++)
        for (int j = 0; j < NY; j++)
            for (int i = 0; i < NX; i++) {
                float f = (float)voxel(i, j, k);
                int16_t s = (int16_t)voxel(i, j, k);
                uint8_t u = (uint8_t)voxel(i, j, k);
                const void *from = *type == 'f' ? (void *)&f : *type == 's' ? (void *)&s : &u;
                size_t size = *type == 'f' ? 4 : *type == 's' ? 2 : 1;
                big ? put_reversed(b, from, size) : put_bytes(b, from, size);
            }
}

static void expect_plain(const struct grid *grid, double slope)
{
    assert_int_equal(grid->dims[0], NX);
    assert_int_equal(grid->dims[1], NY);
    assert_int_equal(grid->dims[2], NZ);
    for (int k = 0; k < NZ; k++)
        for (int j = 0; j < NY; j++)
            for (int i = 0; i < NX; i++)
                assert_true((double)grid->value[(k * NY + j) * NX + i] == slope * voxel(i, j, k));
    assert_true(grid->low == 0 && grid->high == slope * voxel(NX - 1, NY - 1, NZ - 1));
}

static void put_at(unsigned char *header, size_t at, const void *value, size_t size, bool big)
{
    for (size_t i = 0; i < size; i++)
        header[at + i] = ((const unsigned char *)value)[big ? size - 1 - i : i];
}

/* srow: the affine's first three rows, or NULL. */
static struct buffer make_nifti(int16_t type, bool big, const float *srow, float slope)
{
    unsigned char header[352] = { 0 };
    int32_t length = 348;
    const int16_t dim[4] = { 3, NX, NY, NZ };
    const float pixdim[4] = { 1, 2, 3, 4 }, offset = 352;
    int16_t one = 1;
    put_at(header, 0, &length, 4, big);
    for (size_t i = 0; i < 4; i++) {
        put_at(header, 40 + 2 * i, &dim[i], 2, big);
        put_at(header, 76 + 4 * i, &pixdim[i], 4, big);
    }
    put_at(header, 70, &type, 2, big);
    put_at(header, 108, &offset, 4, big);
    put_at(header, 112, &slope, 4, big);
    if (srow)
        put_at(header, 254, &one, 2, big);
    for (size_t i = 0; srow && i < 12; i++)
        put_at(header, 280 + 4 * i, &srow[i], 4, big);
    memcpy(header + 344, "n+1", 4);
    struct buffer b = { 0 };
    put_bytes(&b, header, sizeof header);
    return b;
}

static void nifti_of_types_and_byte_orders(void **state)
{
    static const struct {
        int16_t code;
        const char *type;
    } types[] = { { 2, "u" }, { 4, "s" }, { 16, "f" } };
    for (int t = 0; t < 3; t++)
        for (int big = 0; big < 2; big++) {
            struct buffer b = make_nifti(types[t].code, big, NULL, 0.5f);
            put_voxels(&b, types[t].type, big);
            struct seen seen;
            struct grid grid;
            assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
            expect_plain(&grid, 0.5);
            assert_true(grid.spacing[0] == 2 && grid.spacing[2] == 4);
            assert_int_equal(grid.up, STP_UP_Z);
            grid_release(&grid);
            drop(&b);
        }
}

/* File x runs along world -z, file y along x, file z along y. */
static void nifti_is_turned_to_the_world(void **state)
{
    const float srow[12] = { 0, 3, 0, 10, 0, 0, 4, 20, -2, 0, 0, 30 };
    struct buffer b = make_nifti(16, false, srow, 0);
    put_voxels(&b, "f", false);
    struct seen seen;
    struct grid grid;
    assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
    assert_int_equal(grid.dims[0], NY);
    assert_int_equal(grid.dims[1], NZ);
    assert_int_equal(grid.dims[2], NX);
    for (int i = 0; i < NX; i++)
        for (int j = 0; j < NY; j++)
            for (int k = 0; k < NZ; k++) {
                /* Where the affine puts voxel (i, j, k), the grid must hold its value. */
                double w[3] = { 3.0 * j + 10, 4.0 * k + 20, -2.0 * i + 30 };
                int at[3];
                for (int a = 0; a < 3; a++)
                    at[a] = (int)lround((w[a] - grid.origin[a]) / grid.spacing[a]);
                assert_true((double)grid.value[(at[2] * NZ + at[1]) * NY + at[0]] ==
                            voxel(i, j, k));
            }
    grid_release(&grid);
    drop(&b);
}

/* The affine's columns are the steps, whatever pixdim says; NaN is how some write no slope. */
static void nifti_of_an_affine_that_pixdim_contradicts(void **state)
{
    const float srow[12] = { 0, 3, 0, 10, 0, 0, 4, 20, -2, 0, 0, 30 }, wrong = 9;
    struct buffer b = make_nifti(16, false, srow, NAN);
    for (size_t i = 1; i < 4; i++)
        put_at(b.data, 76 + 4 * i, &wrong, 4, false);
    put_voxels(&b, "f", false);
    struct seen seen;
    struct grid grid;
    assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
    assert_true(grid.spacing[0] == 3 && grid.spacing[1] == 4 && grid.spacing[2] == 2);
    assert_true(grid.high == voxel(NX - 1, NY - 1, NZ - 1) && grid.low == 0);
    grid_release(&grid);
    drop(&b);
}

/* A left-handed space must not make a mirror image: its x runs against the world's. With directions
 * and without, before them and after. */
static void nrrd_of_left_handed_spaces(void **state)
{
    static const char *const fields[] = {
        ("space: left-anterior-superior\nspace directions: (2,0,0) (0,1,0) (0,0,1)\n"
         "space origin: (5,6,7)\n"),
        "space directions: (2,0,0) (0,1,0) (0,0,1)\nspace origin: (5,6,7)\nspace: LAS\n",
        "space: 3D-left-handed\nspacings: 2 1 1\n",
        "space: RAS\nspace directions: (2,0,0) (0,1,0) (0,0,1)\nspace origin: (5,6,7)\n",
    };
    for (int n = 0; n < 4; n++) {
        struct buffer b = { 0 };
        struct seen seen;
        struct grid grid;
        put_text(&b,
                 "NRRD0004\ntype: int16_t\ndimension: 3\nsizes: %d %d %d\n%s"
                 "endian: little\nencoding: RAW\n\n",
                 NX, NY, NZ, fields[n]);
        put_voxels(&b, "s", false);
        assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
        assert_int_equal(seen.warnings, 0);
        for (int i = 0; i < NX; i++)
            assert_true((double)grid.value[i] == voxel(n < 3 ? NX - 1 - i : i, 0, 0));
        assert_true(grid.spacing[0] == 2);
        if (n != 2) /* voxel 0 lies at x = 5 of the file's space */
            assert_true(grid.origin[0] == (n < 3 ? -5 - 2.0 * (NX - 1) : 5));
        grid_release(&grid);
        drop(&b);
    }
}

static void what_is_not_read_is_warned_of(void **state)
{
    struct buffer b = { 0 };
    struct seen seen;
    struct grid grid;
    put_text(&b,
             "NRRD0001\ntype: short\ndimension: 3\nsizes: %d %d %d\naxis mins: 0 0 0\n"
             "axis maxs: 3 8 4\nendian: little\nencoding: raw\n\n",
             NX, NY, NZ);
    put_voxels(&b, "s", false);
    assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
    assert_int_equal(seen.warnings, 1);
    grid_release(&grid);
    drop(&b);
}

static void put_gzip(struct buffer *b, const struct buffer *body)
{
    size_t room = body->size + 512;
    unsigned char *out = malloc(room);
    assert_non_null(out);
    z_stream z = { .next_in = body->data,
                   .avail_in = (unsigned)body->size,
                   .next_out = out,
                   .avail_out = (unsigned)room };
    assert_int_equal(deflateInit2(&z, 9, Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY), Z_OK);
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    put_bytes(b, out, room - z.avail_out);
    deflateEnd(&z);
    free(out);
}

static void nrrd_raw_and_gzip(void **state)
{
    for (int packed = 0; packed < 2; packed++) {
        struct buffer b = { 0 }, body = { 0 };
        put_text(&b,
                 "NRRD0004\n# made by a test\ntype: short\ndimension: 3\nsizes: %d %d %d\n"
                 "spacings: 1 2 0.5\nendian: big\nencoding: %s\n\n",
                 NX, NY, NZ, packed ? "gzip" : "raw");
        put_voxels(&body, "s", true);
        if (packed)
            put_gzip(&b, &body);
        else
            put_bytes(&b, body.data, body.size);
        struct seen seen;
        struct grid grid;
        assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
        expect_plain(&grid, 1);
        assert_true(grid.spacing[1] == 2 && grid.origin[1] == 1);
        grid_release(&grid);
        drop(&b);
        drop(&body);
    }
}

static void metaimage_and_inrimage(void **state)
{
    struct buffer b = { 0 };
    struct seen seen;
    struct grid grid;
    put_text(&b,
             "Comment = made by a test\nObjectType = Image\nNDims = 3\nBinaryData = True\n"
             "DimSize = %d %d %d\nElementSpacing = 1 1 3\n"
             "ElementType = MET_FLOAT\nElementByteOrderMSB = False\nElementDataFile = LOCAL\n",
             NX, NY, NZ);
    put_voxels(&b, "f", false);
    assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
    expect_plain(&grid, 1);
    assert_true(grid.spacing[2] == 3);
    grid_release(&grid);
    drop(&b);
    b = (struct buffer){ 0 };
    put_text(&b,
             "#INRIMAGE-4#{\nXDIM=%d\nYDIM=%d\nZDIM=%d\nVDIM=1\nTYPE=unsigned fixed\n"
             "PIXSIZE=8 bits\nCPU=decm\nVX=2\nVY=2\nVZ=5\n",
             NX, NY, NZ);
    while (b.size < 252)
        put_text(&b, "\n");
    put_text(&b, "##}\n");
    put_voxels(&b, "u", false);
    assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
    expect_plain(&grid, 1);
    assert_true(grid.spacing[2] == 5);
    grid_release(&grid);
    drop(&b);
}

static void refuse(struct buffer b, const char *words)
{
    struct seen seen;
    struct grid grid = { .low = 7 };
    assert_int_equal(read_volume(&b, &seen, &grid), STP_ERROR_FORMAT);
    if (!strstr(seen.error, words))
        fail_msg("'%s' does not say '%s'", seen.error, words);
    assert_true(grid.low == 7 && !grid.value);
    drop(&b);
}

static struct buffer text_of(const char *text)
{
    struct buffer b = { 0 };
    put_text(&b, "%s", text);
    return b;
}

static void what_is_wrong_is_said(void **state)
{
    struct buffer b = make_nifti(2, false, NULL, 0);
    refuse(b, "claimed");
    refuse(make_nifti(128, false, NULL, 0), "datatype 128");
    refuse(text_of("NRRD0004\ntype: float\ndimension: 4\nsizes: 1 1 1 1\n\n...."), "dimensions");
    refuse(text_of("NRRD0004\ntype: block\ndimension: 3\nsizes: 1 1 1\n\n...."), "block");
    refuse(text_of("NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 1\nencoding: bzip2\n\n...."),
           "bzip2");
    refuse(text_of("NRRD0004\ntype: float\ndimension: 3\nsizes: 70000 70000 70000\n\n...."),
           "2^32");
    refuse(text_of("NRRD0004\ntype: float\ndimension: 3\nsizes: 0 1 1\n\n...."), "no size");
    refuse(text_of("NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1\n\n...."), "sizes");
    refuse(text_of("NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 1\nspacings: 1 0 1\n\n...."),
           "spacing");
    refuse(text_of("NDims = 2\nDimSize = 4 4\nElementDataFile = LOCAL\n"), "dimensions");
    refuse(text_of("NDims = 3\nDimSize = 1 1 1\nElementType = MET_UCHAR\n"), "ElementDataFile");
    refuse(text_of("NDims = 3\nBinaryData = False\nDimSize = 1 1 1\nElementType = MET_UCHAR\n"
                   "ElementDataFile = LOCAL\n7\n"),
           "BinaryData");
    refuse(text_of("not a volume at all"), "not a volume");
}

static void each_allocation_fails_in_turn(void **state)
{
    struct buffer b = make_nifti(4, false, NULL, 0);
    put_voxels(&b, "s", false);
    struct seen seen;
    struct grid grid = { 0 };
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        mem_fail_at(n);
        result = read_volume(&b, &seen, &grid);
        mem_fail_at(0);
        assert_true(result == STP_OK || (result == STP_ERROR_MEMORY && !grid.value));
        assert_true(n < 100);
    }
    expect_plain(&grid, 1);
    grid_release(&grid);
    drop(&b);
}

/* A folder with a raw file and descriptions beside it. */
static void put(const char *folder, const char *name, const char *text)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void raw_files_are_described_beside(void **state)
{
    char folder[] = "/tmp/stipple-raw-XXXXXX", path[256], line[300];
    assert_non_null(mkdtemp(folder));
    struct raw_volume raw;
    struct stp_volume_params params = { 0 };
    struct seen seen = { .env = { .log = see } };
    seen.env.user = &seen;
    snprintf(path, sizeof path, "%s/head.raw", folder);
    assert_int_equal(raw_volume_find(&seen.env, path, &params, &raw), STP_OK);
    assert_false(raw.known);
    put(folder, "volumes.json",
        "{\"other.raw\": {\"dims\": [9,9,9], \"dtype\": \"uint8\"},"
        "\"head.raw\": {\"dims\": [2,3,4], \"dtype\": \"int16 big-endian\","
        "\"spacing\": [1,2,3], \"note\": \"n\"}}");
    assert_int_equal(raw_volume_find(&seen.env, path, &params, &raw), STP_OK);
    assert_true(raw.known && raw.voxels.dims[1] == 3 && raw.voxels.type == RECORD_INT16);
    assert_true(raw.voxels.big_endian && raw.voxels.spacing[2] == 3);
    put(folder, "head.json", "{\"dims\": [5,5,5], \"dtype\": \"float32\", \"up\": \"z\"}");
    assert_int_equal(raw_volume_find(&seen.env, path, &params, &raw), STP_OK);
    assert_true(raw.voxels.dims[0] == 5 && raw.voxels.type == RECORD_FLOAT32);
    assert_int_equal(raw.voxels.up, STP_UP_Z);
    params = (struct stp_volume_params){ .dims = { 7, 1, 1 }, .type = STP_VOXEL_U16 };
    assert_int_equal(raw_volume_find(&seen.env, path, &params, &raw), STP_OK);
    assert_true(raw.voxels.dims[0] == 7 && raw.voxels.type == RECORD_UINT16);
    assert_int_equal(seen.errors, 0);
    params = (struct stp_volume_params){ 0 };
    put(folder, "head.json", "{\"dims\": [5,5.5,5], \"dtype\": \"float32\"}");
    assert_int_equal(raw_volume_find(&seen.env, path, &params, &raw), STP_ERROR_FORMAT);
    assert_non_null(strstr(seen.error, "dims"));
    snprintf(line, sizeof line, "rm -r %s", folder);
    assert_int_equal(system(line), 0);
}

#define SURPLUS ((size_t)1 << 24)

static void put_surplus(struct buffer *b)
{
    unsigned char *zeros = calloc(SURPLUS, 1);
    assert_non_null(zeros);
    put_bytes(b, zeros, SURPLUS);
    free(zeros);
}

static void put_nrrd(struct buffer *b, const char *encoding, const char *more)
{
    put_text(b,
             "NRRD0004\ntype: short\ndimension: 3\nsizes: %d %d %d\nendian: little\nencoding: "
             "%s\n%s\n",
             NX, NY, NZ, encoding, more);
}

/* What is inflated beyond what the header states is not looked at: here it is cut off, which a
 * reader that goes to the end takes for damage. */
static void gzip_in_a_file_ends_with_its_voxels(void **state)
{
    struct buffer b = { 0 }, body = { 0 };
    struct seen seen;
    struct grid grid;
    put_voxels(&body, "s", false);
    put_surplus(&body);
    put_nrrd(&b, "gzip", "");
    put_gzip(&b, &body);
    b.size -= 1000;
    assert_int_equal(read_volume(&b, &seen, &grid), STP_OK);
    expect_plain(&grid, 1);
    grid_release(&grid);
    drop(&b);
    body.size -= SURPLUS;
    put_nrrd(&b, "gzip", "");
    put_gzip(&b, &body);
    b.data[b.size - 6] ^= 1; /* what is honest is checked to its end */
    refuse(b, "damaged gzip");
    b = (struct buffer){ 0 };
    put_nrrd(&b, "gzip", "byte skip: -1\n");
    put_gzip(&b, &body);
    refuse(b, "encoding raw only");
    drop(&body);
}

static void put_buffer(const char *path, const struct buffer *b)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(b->data, 1, b->size, file), b->size);
    assert_int_equal(fclose(file), 0);
}

/* As the scene reads it: no more of it is inflated than its header states, and some slack. */
static void expect_short(const char *path, const struct buffer *body, bool refused)
{
    const struct file_use use = { .most = FILE_ALL, .stated = volume_stated };
    struct seen seen = { .env = { .log = see } };
    struct buffer b = { 0 };
    struct file_bytes bytes;
    struct grid grid = { 0 };
    seen.env.user = &seen;
    put_gzip(&b, body);
    b.size -= 1000;
    put_buffer(path, &b);
    assert_int_equal(file_read_for(&seen.env, path, &use, &bytes), STP_OK);
    assert_true(bytes.size < body->size - SURPLUS + FILE_SLACK + 4 * b.size + FILE_HEAD);
    assert_int_equal(volume_from_bytes(&seen.env, path, &bytes, NULL, NULL, &grid),
                     refused ? STP_ERROR_FORMAT : STP_OK);
    if (!refused)
        expect_plain(&grid, 1);
    grid_release(&grid);
    file_release(&bytes);
    drop(&b);
}

static void whole_files_in_gzip_end_with_their_voxels(void **state)
{
    char folder[] = "/tmp/stipple-gzip-XXXXXX", path[256], detached[256];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/v", folder);
    snprintf(detached, sizeof detached, "%s/v.raw.gz", folder);
    for (int kind = 0; kind < 4; kind++) {
        struct buffer b = { 0 };
        if (kind == 0)
            b = make_nifti(4, false, NULL, 0);
        else if (kind == 1)
            b = make_nifti(128, false, NULL, 0); /* no scalars */
        else
            put_nrrd(&b, kind == 2 ? "raw" : "bzip2", "");
        put_voxels(&b, "s", false);
        put_surplus(&b);
        expect_short(path, &b, kind % 2);
        drop(&b);
    }
    struct buffer body = { 0 }, packed = { 0 }, b = { 0 };
    put_voxels(&body, "s", false);
    put_surplus(&body);
    put_gzip(&packed, &body);
    packed.size -= 1000;
    put_buffer(detached, &packed);
    put_nrrd(&b, "gzip", "data file: v.raw.gz\n");
    const struct file_bytes bytes = { .data = b.data, .size = b.size };
    struct grid grid = { 0 };
    assert_int_equal(volume_from_bytes(NULL, path, &bytes, NULL, NULL, &grid), STP_OK);
    expect_plain(&grid, 1);
    grid_release(&grid);
    drop(&b);
    drop(&body);
    drop(&packed);
    unlink(path);
    unlink(detached);
    assert_int_equal(rmdir(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nifti_of_types_and_byte_orders),
        cmocka_unit_test(nifti_is_turned_to_the_world),
        cmocka_unit_test(nifti_of_an_affine_that_pixdim_contradicts),
        cmocka_unit_test(nrrd_of_left_handed_spaces),
        cmocka_unit_test(what_is_not_read_is_warned_of),
        cmocka_unit_test(nrrd_raw_and_gzip),
        cmocka_unit_test(metaimage_and_inrimage),
        cmocka_unit_test(what_is_wrong_is_said),
        cmocka_unit_test(gzip_in_a_file_ends_with_its_voxels),
        cmocka_unit_test(whole_files_in_gzip_end_with_their_voxels),
        cmocka_unit_test(each_allocation_fails_in_turn),
        cmocka_unit_test(raw_files_are_described_beside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
