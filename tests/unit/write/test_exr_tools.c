/* Our files in other people's tools, and theirs in our reader. A tool that is missing fails. */
#include "helpers.h"

static const enum stp_compression compressions[] = { STP_COMPRESSION_NONE, STP_COMPRESSION_ZIPS,
                                                     STP_COMPRESSION_ZIP, STP_COMPRESSION_PIZ };

/* 53 x 37; values that half holds exactly, so that every type compares bit for bit. */
static struct stp_image *make_image(void)
{
    const char *names[] = { "R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z" };
    struct stp_image *image = NULL;
    uint32_t seed = 11;
    assert_int_equal(stp_image_create(NULL, 53, 37, &image), STP_OK);
    for (int c = 0; c < 8; c++) {
        struct stp_channel *channel = add_plane(image, names[c], STP_CHANNEL_FLOAT);
        for (int i = 0; i < 53 * 37; i++)
            channel->data.f[i] = (float)(next_random(&seed) % 2048) / 64 - (float)c;
    }
    image->has_camera = true;
    image->camera =
        (struct stp_camera){ .world_to_camera = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -5, 0, 0, 0, 1 },
                             .fx = 40,
                             .fy = 40,
                             .cx = 26.5,
                             .cy = 18.5,
                             .width = 53,
                             .height = 37,
                             .near_depth = 1,
                             .far_depth = INFINITY };
    image->origin[0] = 500000.125;
    return image;
}

static void write_as(const struct stp_image *image, const char *folder, const char *name,
                     enum stp_compression compression)
{
    char path[PATH_MAX];
    struct stp_exr_params params = { .compression = compression, .comment = "one sentence" };
    assert_int_equal(stp_image_write_exr(NULL, image, in_scratch(folder, name, path), &params),
                     STP_OK);
}

static struct stp_image *read_name(const char *folder, const char *name)
{
    char path[PATH_MAX];
    struct stp_image *image = NULL;
    assert_int_equal(stp_image_read_exr(NULL, in_scratch(folder, name, path), &image), STP_OK);
    return image;
}

static void check_planes(const struct stp_image *a, const struct stp_image *b)
{
    assert_int_equal(b->width, a->width);
    assert_int_equal(b->height, a->height);
    for (unsigned c = 0; c < a->channel_count; c++) {
        const struct stp_channel *found = stp_image_find(b, a->channels[c].name);
        assert_non_null(found);
        assert_memory_equal(found->data.f, a->channels[c].data.f, 4 * (size_t)a->width * a->height);
    }
}

static void must_contain(char *text, const char *wanted)
{
    if (!strstr(text, wanted))
        fail_msg("no \"%s\" in: %s", wanted, text ? text : "");
}

static void test_header(void **state)
{
    static const char *const lines[] = {
        "A, 32-bit floating-point",
        "N.Z, 16-bit floating-point",
        "id, 32-bit unsigned integer",
        "chromaticities (type chromaticities)",
        "comments (type string): \"one sentence\"",
        "compression (type compression): zip",
        "dataWindow (type box2i): (0 0) - (52 36)",
        "displayWindow (type box2i): (0 0) - (52 36)",
        "lineOrder (type lineOrder): increasing y",
        "pixelAspectRatio (type float): 1\n",
        "screenWindowWidth (type float): 1.325",
        "software (type string): \"stipple ",
        "stipple:origin (type v3d)",
        "stipple:twoSided (type int): 1",
        "worldToCamera (type m44f)",
        "worldToNDC (type m44f)",
        "(type string): \"scanlineimage\"",
    };
    struct stp_image *image = make_image();
    image->two_sided = true;
    stp_image_find(image, "N.Z")->half = true;
    add_plane(image, "id", STP_CHANNEL_UINT);
    write_as(image, *state, "h.exr", STP_COMPRESSION_ZIP);
    char *text = run_tool(*state, "exrheader h.exr");
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
        must_contain(text, lines[i]);
    assert_null(strstr(text, "rror"));
    assert_null(strstr(text, "nknown"));
    free(text);
    text = run_tool(*state, "iinfo -v h.exr");
    must_contain(text, "53 x   37");
    must_contain(
        text, "channel list: R (float), G (float), B (float), A (float), Z (float), id (uint), ");
    must_contain(text, "worldToCamera: 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 500000, 0, 5, 1");
    free(text);
    stp_image_destroy(&image);
}

/* The values themselves, as OpenImageIO prints them. */
static void test_values(void **state)
{
    struct stp_image *image = make_image();
    for (int c = 0; c < 4; c++) {
        write_as(image, *state, "v.exr", compressions[c]);
        char *text = run_tool(*state, "oiiotool --dumpdata v.exr"), *at = text;
        for (int i = 0; i < 53 * 37; i++) {
            char expected[256];
            int used = snprintf(expected, sizeof expected, "Pixel (%d, %d):", i % 53, i / 53);
            for (int plane = 0; plane < 8; plane++)
                used += snprintf(expected + used, sizeof expected - (size_t)used, " %.9f",
                                 (double)image->channels[plane].data.f[i]);
            if (!find_line(&at, expected))
                fail_msg("no \"%s\"", expected);
        }
        free(text);
    }
    stp_image_destroy(&image);
}

/* OpenImageIO rewrites our file in every way we claim to read. */
static void test_their_files(void **state)
{
    static const char command[] =
        "oiiotool a.exr --compression none -o 0.exr --compression rle -o 1.exr "
        "--compression zips -o 2.exr --compression zip -o 3.exr --compression piz -o 4.exr "
        "--tile 16 16 --compression zip -o 5.exr --tile 64 64 --compression none -o 6.exr "
        "-d half --tile 7 5 --compression rle -o 7.exr --scanline --compression zip -o 8.exr "
        "--compression piz -o 9.exr --compression pxr24 -o 10.exr";
    struct stp_image *image = make_image();
    write_as(image, *state, "a.exr", STP_COMPRESSION_ZIP);
    free(run_tool(*state, command));
    for (int i = 0; i <= 10; i++) {
        char name[16];
        snprintf(name, sizeof name, "%d.exr", i);
        struct stp_image *read = read_name(*state, name);
        check_planes(image, read);
        assert_int_equal(read->channels[0].half, i >= 7);
        stp_image_destroy(&read);
    }
    stp_image_destroy(&image);
}

/* And sees no difference between our compressions. */
static void test_idiff(void **state)
{
    struct stp_image *image = make_image();
    write_as(image, *state, "none.exr", STP_COMPRESSION_NONE);
    write_as(image, *state, "zips.exr", STP_COMPRESSION_ZIPS);
    write_as(image, *state, "piz.exr", STP_COMPRESSION_PIZ);
    free(run_tool(*state, "idiff -fail 0 -warn 0 none.exr zips.exr && "
                          "idiff -fail 0 -warn 0 none.exr piz.exr"));
    stp_image_destroy(&image);
}

/* A data window that sticks out on the left and leaves room on the right; the first of two parts.
 */
static void test_windows(void **state)
{
    struct stp_image *image = make_image();
    write_as(image, *state, "a.exr", STP_COMPRESSION_ZIP);
    free(run_tool(*state,
                  "oiiotool a.exr --origin -3+5 --fullsize 60x40+0+0 -o b.exr "
                  "--tile 16 16 -o c.exr && oiiotool b.exr b.exr --mulc 2 --siappend -o d.exr"));
    const char *names[] = { "b.exr", "c.exr", "d.exr" };
    for (int n = 0; n < 3; n++) {
        struct stp_image *read = read_name(*state, names[n]);
        assert_int_equal(read->width, 60);
        assert_int_equal(read->height, 40);
        for (int y = 0; y < 40; y++)
            for (int x = 0; x < 60; x++) {
                int from_x = x + 3, from_y = y - 5;
                bool inside = from_x < 53 && from_y >= 0 && from_y < 37;
                size_t from = inside ? (size_t)(from_y * 53 + from_x) : 0;
                float red = inside ? image->channels[0].data.f[from] : 0;
                float depth = inside ? image->channels[4].data.f[from] : INFINITY;
                assert_true(stp_image_find(read, "R")->data.f[y * 60 + x] == red);
                assert_true(stp_image_find(read, "Z")->data.f[y * 60 + x] == depth);
            }
        stp_image_destroy(&read);
    }
    stp_image_destroy(&image);
}

/* Of two parts the first is read, and a line says which that is; of one there is none. */
static void test_parts(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 1);
    struct stp_image *image = make_image(), *read = NULL;
    write_as(image, *state, "a.exr", STP_COMPRESSION_ZIP);
    free(run_tool(*state, "oiiotool a.exr --attrib oiio:subimagename beauty a.exr --mulc 2 "
                          "--attrib oiio:subimagename depth --siappend -o parts.exr"));
    assert_int_equal(stp_image_read_exr(&env, in_scratch(*state, "a.exr", path), &read), STP_OK);
    assert_int_equal(book.warnings, 0);
    stp_image_destroy(&read);
    assert_int_equal(stp_image_read_exr(&env, in_scratch(*state, "parts.exr", path), &read),
                     STP_OK);
    assert_int_equal(book.warnings, 1);
    must_contain(book.warning, "of its 2 parts only the first is read: \"beauty\"");
    check_planes(image, read);
    stp_image_destroy(&read);
    stp_image_destroy(&image);
}

/* Real shapes that are not read: the line names them. */
static void test_refused(void **state)
{
    char path[PATH_MAX];
    struct log_book book;
    struct stp_env env = logged_env(&book, 1);
    struct stp_image *image = make_image(), *read = NULL;
    write_as(image, *state, "a.exr", STP_COMPRESSION_ZIP);
    free(run_tool(*state, "oiiotool a.exr --compression dwaa -o dwaa.exr --compression dwab "
                          "-o dwab.exr --compression zips --deepen -o deep.exr"));
    const char *names[] = { "dwaa.exr", "dwab.exr", "deep.exr" };
    for (int n = 0; n < 3; n++) {
        in_scratch(*state, names[n], path);
        assert_int_equal(stp_image_read_exr(&env, path, &read), STP_ERROR_FORMAT);
        assert_int_equal(book.errors, n + 1);
        must_contain(book.error,
                     n < 2 ? "DWAA/DWAB is not decoded yet by OpenEXR's C core" : "a deep EXR");
        assert_null(read);
    }
    stp_image_destroy(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_header),      cmocka_unit_test(test_values),
        cmocka_unit_test(test_their_files), cmocka_unit_test(test_idiff),
        cmocka_unit_test(test_windows),     cmocka_unit_test(test_refused),
        cmocka_unit_test(test_parts),
    };
    return cmocka_run_group_tests(tests, enter_scratch, leave_scratch);
}
