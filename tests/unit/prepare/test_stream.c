/* A cloud that stays in its file is, chunk by chunk, the scene that reading it whole gives. */
#include "clouds.h"

#include <stipple/fit.h>

#include <stdio.h>
#include <unistd.h>
#include <zlib.h>

#include "base/memory.h"
#include "prepare/prepare.h"
#include "prepare/stream.h"

#define MOST 40000

struct file {
    char path[80];
    size_t count;
};

enum {
    BIG = 1,
    COLORS = 2,
    FLOAT_COLORS = 4,
    NO_NORMALS = 8,
    NO_RADII = 16,
    OPACITY = 32,
    TEXT = 64,
    BAD_NORMAL = 128,
    BAD_RADIUS = 256,
    MONSTER = 512,
    SHUFFLED = 1024,
    HEAP = 2048, /* most points in one place, and one far away */
};

struct row {
    float value[7];
    unsigned char color[3];
};

/* A bumpy sphere; every 50th point is the one before it again, a few are not finite. */
static struct row row_of(size_t i, unsigned what)
{
    size_t base = i % 50 == 49 ? i - 1 : i;
    uint64_t state = base * 77 + 5;
    double p[3], n[3], bump = 1 + 0.1 * random_unit(&state);
    struct row row;
    on_sphere(random_unit(&state), random_unit(&state), p, n);
    for (int axis = 0; axis < 3; axis++) {
        row.value[axis] = (float)(p[axis] * bump) * (what & HEAP ? 1e-6f : 1) + 3;
        row.value[3 + axis] = (float)n[axis];
        row.color[axis] = (unsigned char)(base * (size_t)(axis + 3));
    }
    row.value[6] = 0.01f + 0.005f * (float)random_unit(&state);
    if (i % 1000 == 7)
        row.value[i % 3] = i % 2 ? NAN : INFINITY;
    if (what & HEAP && i == 11)
        row.value[1] = 1e5f;
    if (what & BAD_NORMAL && i == 20)
        row.value[3] = row.value[4] = row.value[5] = 0;
    if (what & BAD_RADIUS && i == 21)
        row.value[6] = -1;
    if (what & MONSTER && i == 22)
        row.value[6] = 50;
    return row;
}

static void put_float(FILE *out, float value, unsigned what)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    if (what & TEXT) {
        fprintf(out, "%.9g ", (double)value);
        return;
    }
    bits = what & BIG ? __builtin_bswap32(bits) : bits;
    fwrite(&bits, sizeof bits, 1, out);
}

static void put_row(FILE *out, const struct row *row, unsigned what)
{
    for (int k = 0; k < 7; k++)
        if (!(k >= 3 && k < 6 && what & NO_NORMALS) && !(k == 6 && what & NO_RADII))
            put_float(out, row->value[k], what);
    if (what & COLORS)
        fwrite(row->color, 1, 3, out);
    for (int c = 0; what & FLOAT_COLORS && c < 3; c++)
        put_float(out, (float)row->color[c] / 255, what);
    if (what & OPACITY)
        put_float(out, 1, what);
    if (what & TEXT)
        fputc('\n', out);
}

static void put_header(FILE *out, size_t count, unsigned what)
{
    static const char *const names[] = { "x", "y", "z", "nx", "ny", "nz", "radius" };
    static const char *const colors[] = { "red", "green", "blue" };
    fprintf(out, "ply\nformat %s 1.0\nelement extra 2\nproperty int a\nelement vertex %zu\n",
            what & TEXT  ? "ascii"
            : what & BIG ? "binary_big_endian"
                         : "binary_little_endian",
            count);
    for (int k = 0; k < 7; k++)
        if (!(k >= 3 && k < 6 && what & NO_NORMALS) && !(k == 6 && what & NO_RADII))
            fprintf(out, "property float %s\n", names[k]);
    for (int c = 0; what & (COLORS | FLOAT_COLORS) && c < 3; c++)
        fprintf(out, "property %s %s\n", what & COLORS ? "uchar" : "float", colors[c]);
    fprintf(out, "%send_header\n%s", what & OPACITY ? "property float opacity\n" : "",
            what & TEXT ? "1\n2\n" : "12345678");
}

static struct file write_file(size_t count, unsigned what)
{
    struct file file = { "/tmp/stipple_stream_XXXXXX", count };
    int fd = mkstemp(file.path);
    assert_true(fd >= 0);
    FILE *out = fdopen(fd, "wb");
    put_header(out, count, what);
    for (size_t i = 0; i < count; i++) {
        struct row row = row_of(what & SHUFFLED ? i * 7919 % count : i, what);
        put_row(out, &row, what);
    }
    assert_int_equal(fclose(out), 0);
    return file;
}

struct heard {
    unsigned warnings, errors;
    char last[400];
};

static void hear(void *user, enum stp_log_level level, const char *line)
{
    struct heard *heard = user;
    heard->warnings += level == STP_LOG_WARNING;
    heard->errors += level == STP_LOG_ERROR;
    snprintf(heard->last, sizeof heard->last, "%s", line);
}

static struct stp_scene *scene_of(const struct file *file, size_t chunk, const double *box,
                                  unsigned threads, struct heard *heard)
{
    const struct stp_env env = { .threads = threads, .log = hear, .user = heard };
    struct stp_load_params load = { .stream_above = chunk ? 1 : 0, .stream_chunk = chunk };
    struct stp_prepare_params prepare = { .clip_box = box };
    struct stp_scene *scene = NULL;
    *heard = (struct heard){ 0 };
    assert_int_equal(stp_scene_load(&env, file->path, &load, &scene), STP_OK);
    assert_int_equal(stp_scene_prepare(&env, scene, &prepare), STP_OK);
    return scene;
}

static void expect_facts(const struct stp_scene *stream, const struct stp_scene *whole)
{
    struct stp_facts a = stream->facts, b = whole->facts;
    assert_true(fabs(a.outwardness - b.outwardness) < 1e-6);
    assert_int_equal(a.points, b.points);
    assert_int_equal(a.splats, b.splats);
    assert_int_equal(a.not_finite, b.not_finite);
    assert_int_equal(a.clipped, b.clipped);
    assert_int_equal(a.duplicates, b.duplicates);
    assert_int_equal(a.has_color, b.has_color);
    assert_int_equal(a.two_sided, b.two_sided);
    assert_int_equal(a.normals, b.normals);
    assert_int_equal(a.transparent, b.transparent);
    assert_int_equal(a.objects, b.objects);
    assert_memory_equal(a.bounds, b.bounds, sizeof a.bounds);
    assert_memory_equal(a.origin, b.origin, sizeof a.origin);
    assert_memory_equal(stream->core, whole->core, sizeof stream->core);
    assert_true(a.radius_min == b.radius_min && a.radius_max == b.radius_max);
    assert_true(a.radius_median == b.radius_median && a.color_max == b.color_max);
    assert_true(a.opacity_min == b.opacity_min && a.uniform_opacity == b.uniform_opacity);
    assert_string_equal(a.format, b.format);
    assert_true(stream->objects[0].epsilon == whole->objects[0].epsilon);
}

/* All chunks, one after the other, are the splats. inputs: those too. */
static void expect_chunks(const struct stp_scene *stream, const struct splats *s, unsigned threads,
                          bool inputs)
{
    const struct stp_env env = { .threads = threads };
    assert_int_equal(stream->stream->chunk[0], 0);
    assert_int_equal(stream->stream->chunk[stream->stream->chunk_count], s->count);
    for (uint32_t c = 0; c < stream->stream->chunk_count; c++) {
        struct splats part;
        size_t first = stream->stream->chunk[c];
        assert_int_equal(stream_splats(&env, stream, c, &part, NULL), STP_OK);
        assert_int_equal(first + part.count, stream->stream->chunk[c + 1]);
        assert_memory_equal(part.origin, s->origin, sizeof part.origin);
        assert_memory_equal(part.position, s->position[first], part.count * 24);
        assert_memory_equal(part.normal, s->normal[first], part.count * 12);
        assert_memory_equal(part.radius, &s->radius[first], part.count * 4);
        if (s->color)
            assert_memory_equal(part.color, s->color[first], part.count * 12);
        if (inputs)
            assert_memory_equal(part.input, &s->input[first], part.count * 4);
        splats_release(&part);
    }
}

static void expect_same(size_t count, unsigned what, const double *box, size_t chunk,
                        uint32_t least_chunks)
{
    struct file file = write_file(count, what), other = write_file(count, what | SHUFFLED);
    struct heard heard;
    struct stp_scene *whole = scene_of(&file, 0, box, 2, &heard);
    for (unsigned threads = 1; threads <= 3; threads += 2) {
        struct stp_scene *stream = scene_of(&file, chunk, box, threads, &heard);
        assert_int_equal(heard.warnings, 0);
        assert_non_null(stream->stream);
        assert_true(stream->stream->chunk_count >= least_chunks);
        expect_facts(stream, whole);
        expect_chunks(stream, &whole->splats, threads, true);
        struct stp_camera a, b;
        assert_int_equal(stp_camera_frame(NULL, stream, NULL, &a), STP_OK);
        assert_int_equal(stp_camera_frame(NULL, whole, NULL, &b), STP_OK);
        assert_memory_equal(a.world_to_camera, b.world_to_camera, sizeof a.world_to_camera);
        assert_true(a.near_depth == b.near_depth);
        stp_scene_destroy(&stream);
    }
    struct stp_scene *shuffled = scene_of(&other, chunk, box, 2, &heard);
    expect_facts(shuffled, whole);
    expect_chunks(shuffled, &whole->splats, 2, false);
    stp_scene_destroy(&shuffled);
    stp_scene_destroy(&whole);
    unlink(file.path);
    unlink(other.path);
}

static void test_same_as_whole(void **state)
{
    const double box[6] = { 2.2, 2.1, 2, 3.9, 4, 3.5 };
    expect_same(MOST, 0, NULL, 2000, 10);
    expect_same(MOST, COLORS, NULL, 1 << 20, 1);
    expect_same(20000, BIG | COLORS, box, 900, 10);
    expect_same(20000, HEAP, NULL, 3000, 1); /* one cell holds nearly all */
    expect_same(2, 0, NULL, 1, 1);
}

/* What cannot stay in its file is read whole, and the line says why. */
static void test_read_whole(void **state)
{
    static const struct {
        unsigned what;
        const char *why;
    } cases[] = { { NO_NORMALS, "no normals" },
                  { NO_RADII, "no radii" },
                  { TEXT, "text" },
                  { OPACITY, "opacities" },
                  { FLOAT_COLORS, "colours" },
                  { BAD_NORMAL, "no usable normal" },
                  { BAD_RADIUS, "usable radius" },
                  { MONSTER, "so large" } };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct file file = write_file(3000, cases[i].what);
        struct heard heard;
        struct stp_scene *whole = scene_of(&file, 0, NULL, 1, &heard);
        struct stp_scene *stream = scene_of(&file, 100, NULL, 1, &heard);
        assert_null(stream->stream);
        if (heard.warnings != 1 || !strstr(heard.last, cases[i].why))
            fail_msg("%s: %u warnings: %s", cases[i].why, heard.warnings, heard.last);
        assert_int_equal(stream->splats.count, whole->splats.count);
        assert_memory_equal(stream->splats.position, whole->splats.position,
                            whole->splats.count * 24);
        assert_memory_equal(stream->splats.radius, whole->splats.radius, whole->splats.count * 4);
        stp_scene_destroy(&stream);
        stp_scene_destroy(&whole);
        unlink(file.path);
    }
}

static void test_compressed_and_small(void **state)
{
    struct file file = write_file(500, 0);
    struct heard heard;
    struct stp_load_params load = { .stream_above = 500 };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_load(NULL, file.path, &load, &scene), STP_OK);
    assert_null(scene->stream); /* not more than that */
    stp_scene_destroy(&scene);
    char buffer[64];
    struct file zipped = { .count = 500 };
    snprintf(zipped.path, sizeof zipped.path, "%.70s.gz", file.path);
    gzFile out = gzopen(zipped.path, "wb");
    FILE *in = fopen(file.path, "rb");
    for (size_t n; (n = fread(buffer, 1, sizeof buffer, in)) > 0;)
        gzwrite(out, buffer, (unsigned)n);
    fclose(in);
    gzclose(out);
    scene = scene_of(&zipped, 100, NULL, 1, &heard);
    assert_null(scene->stream);
    assert_non_null(strstr(heard.last, "compressed"));
    stp_scene_destroy(&scene);
    unlink(zipped.path);
    unlink(file.path);
}

/* One radius for all that have none lets the cloud stay in its file. */
static void test_one_radius(void **state)
{
    struct file file = write_file(3000, NO_RADII);
    struct stp_load_params load = { .stream_above = 1, .stream_chunk = 500, .radius = 0.0625f };
    struct stp_scene *scene = NULL, *whole = NULL;
    assert_int_equal(stp_scene_load(NULL, file.path, &load, &scene), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    load.stream_above = 0;
    assert_int_equal(stp_scene_load(NULL, file.path, &load, &whole), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, whole, NULL), STP_OK);
    assert_non_null(scene->stream);
    assert_true(scene->facts.radius_min == 0.0625f && scene->facts.radius_max == 0.0625f);
    expect_facts(scene, whole);
    expect_chunks(scene, &whole->splats, 1, true);
    stp_scene_destroy(&scene);
    stp_scene_destroy(&whole);
    unlink(file.path);
}

/* What wants all points in memory says so, and does nothing. */
static void test_refused(void **state)
{
    struct file file = write_file(3000, 0);
    struct heard heard;
    struct stp_scene *scene = scene_of(&file, 500, NULL, 1, &heard);
    const struct stp_env env = { .log = hear, .user = &heard };
    const struct stp_points point = { .count = 1, .position = (const double[1][3]){ { 0 } } };
    assert_int_equal(stp_scene_group(&env, scene, NULL), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(heard.last, "--stream off"));
    assert_int_equal(stp_scene_cover(&env, scene, NULL), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_save(&env, scene, "/tmp/never"), STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_fit(&env, scene, &(struct stp_fit_params){ .tolerance = 0.1 }, NULL),
                     STP_ERROR_ARGUMENT);
    assert_non_null(strstr(heard.last, "fitting takes all points in memory"));
    assert_int_equal(stp_scene_add_points(&env, scene, &point, NULL), STP_ERROR_ARGUMENT);
    assert_int_equal(heard.errors, 5);
    stp_scene_destroy(&scene);
    unlink(file.path);
}

static void test_no_points(void **state)
{
    const double nowhere[6] = { 50, 50, 50, 51, 51, 51 };
    struct file file = write_file(3000, 0);
    struct stp_load_params load = { .stream_above = 1 };
    struct stp_prepare_params prepare = { .clip_box = nowhere };
    struct heard heard = { 0 };
    const struct stp_env env = { .log = hear, .user = &heard };
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_load(&env, file.path, &load, &scene), STP_OK);
    assert_int_equal(stp_scene_prepare(&env, scene, &prepare), STP_ERROR_NO_POINTS);
    assert_int_equal(heard.errors, 1);
    stp_scene_destroy(&scene);
    unlink(file.path);
}

/* Loading, preparing, framing and one chunk, with every allocation failing in turn. */
static enum stp_result run(const struct file *file, const struct stp_env *env)
{
    struct stp_load_params load = { .stream_above = 1, .stream_chunk = 500 };
    struct stp_scene *scene = NULL;
    struct stp_camera camera;
    struct splats part;
    enum stp_result result = stp_scene_load(env, file->path, &load, &scene);
    if (result == STP_OK)
        result = stp_scene_prepare(env, scene, NULL);
    if (result == STP_OK)
        result = stp_camera_frame(NULL, scene, NULL, &camera);
    if (result == STP_OK)
        assert_non_null(scene->stream);
    if (result == STP_OK)
        result = stream_splats(env, scene, 0, &part, NULL);
    if (result == STP_OK)
        splats_release(&part);
    stp_scene_destroy(&scene);
    return result;
}

static void test_allocations(void **state)
{
    struct file file = write_file(1500, COLORS);
    struct heard heard = { 0 };
    const struct stp_env env = { .threads = 1, .log = hear, .user = &heard };
    mem_fail_at(0);
    assert_int_equal(run(&file, &env), STP_OK);
    unsigned long count = mem_count();
    assert_true(count > 40);
    unsigned spared = 0; /* decoding bytes does without a table */
    for (unsigned long n = 1; n <= count; n++) {
        mem_fail_at(n);
        heard = (struct heard){ 0 };
        enum stp_result result = run(&file, &env);
        spared += result == STP_OK;
        if (result != STP_OK && (result != STP_ERROR_MEMORY || heard.errors > 1))
            fail_msg("allocation %lu of %lu: result %d, %u errors, %s", n, count, result,
                     heard.errors, heard.last);
    }
    assert_true(spared <= 8);
    mem_fail_at(0);
    unlink(file.path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_as_whole),
        cmocka_unit_test(test_read_whole),
        cmocka_unit_test(test_compressed_and_small),
        cmocka_unit_test(test_one_radius),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_no_points),
        cmocka_unit_test(test_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
