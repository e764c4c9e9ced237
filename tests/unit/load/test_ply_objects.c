/* Objects of a prepared PLY: what its comments say, and whose a vertex is. */
#include <string.h>

#include "base/memory.h"
#include "support.h"

#define START "ply\nformat ascii 1.0\ncomment stipple prepared 1\n"
#define XYZ   "property float x\nproperty float y\nproperty float z\n"
#define ONE   "element vertex 1\n" XYZ "end_header\n1 2 3\n"

/* As they are written, with every digit. */
static void test_one(void **state)
{
    struct cloud cloud =
        read_text(START "comment stipple object 0 epsilon 0.10000000000000001\n" ONE);
    assert_int_equal(cloud.object_count, 1);
    assert_true(cloud.objects[0].epsilon == 0.1 && !cloud.objects[0].estimated);
    assert_null(cloud.object);
    cloud_release(&cloud);
    cloud = read_text(START "comment stipple object 0 epsilon 5e-324 normals estimated\n" ONE);
    assert_true(cloud.objects[0].epsilon == 5e-324 && cloud.objects[0].estimated);
    cloud_release(&cloud);
}

/* Other people's comments, and other files, mean nothing. */
static void test_none(void **state)
{
    static const char *const cases[] = {
        START ONE,
        START "comment stipple objects 0 epsilon 1\ncomment object 0 epsilon 1\n" ONE,
        "ply\nformat ascii 1.0\ncomment stipple object 0 epsilon 1\n" ONE,
        "ply\nformat ascii 1.0\ncomment stipple object damaged\n" ONE,
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct cloud cloud = read_text(cases[i]);
        assert_int_equal(cloud.object_count, 0);
        assert_null(cloud.objects);
        cloud_release(&cloud);
    }
}

static const char several[] =
    START "comment stipple object 0 epsilon 1\ncomment stipple object 1 epsilon 0\n"
          "comment stipple object 2 epsilon 3 normals estimated\nelement vertex 5\n" XYZ
          "property float nx\nproperty float ny\nproperty float nz\nproperty float radius\n"
          "property float red\nproperty float green\nproperty float blue\n"
          "property float opacity\nproperty ushort object\nend_header\n"
          "0 0 0 1 0 0 .5 1 2 3 .1 2\n1 0 0 0 1 0 .6 4 5 6 .2 0\n2 0 0 0 0 1 .7 7 8 9 .3 2\n"
          "3 0 0 0 1 0 .8 1 1 1 .4 2\n4 0 0 0 1 0 .9 2 2 2 .5 0\n";

/* Each part holds its own points in their order, and every array of them. */
static void test_split(void **state)
{
    static const size_t count[] = { 2, 0, 3 };
    static const double first[] = { 1, 0, 0 };
    struct cloud whole = read_text(several), *parts;
    assert_int_equal(whole.object_count, 3);
    assert_memory_equal(whole.object, ((uint16_t[]){ 2, 0, 2, 2, 0 }), 10);
    assert_int_equal(cloud_split(NULL, &whole, &parts), STP_OK);
    size_t next[3] = { 0 };
    for (unsigned i = 0; i < 3; i++) {
        assert_int_equal(parts[i].count, count[i]);
        assert_int_equal(parts[i].object_count, 1);
        assert_memory_equal(parts[i].objects, &whole.objects[i], sizeof *whole.objects);
        assert_true(count[i] == 0 || parts[i].position[0][0] == first[i]);
    }
    for (size_t i = 0; i < whole.count; i++) {
        struct cloud *part = &parts[whole.object[i]];
        size_t at = next[whole.object[i]]++;
        assert_memory_equal(part->position[at], whole.position[i], sizeof *whole.position);
        assert_memory_equal(part->normal[at], whole.normal[i], sizeof *whole.normal);
        assert_memory_equal(part->color[at], whole.color[i], sizeof *whole.color);
        assert_true(part->radius[at] == whole.radius[i] && part->opacity[at] == whole.opacity[i]);
    }
    for (unsigned i = 0; i < 3; i++)
        cloud_release(&parts[i]);
    mem_free(parts);
    cloud_release(&whole);
}

static void test_damaged(void **state)
{
    static const char *const lines[] = {
        "comment stipple object\n",
        "comment stipple object 0\n",
        "comment stipple object 0 epsilon\n",
        "comment stipple object 0 epsilon 1x\n",
        "comment stipple object 0 epsilon -1\n",
        "comment stipple object 0 epsilon nan\n",
        "comment stipple object 0 epsilon inf\n",
        "comment stipple object 0 epsilon 1e999\n",
        "comment stipple object 0 epsilon 1 normals\n",
        "comment stipple object 0 epsilon 1 normals guessed\n",
        "comment stipple object 0 epsilom 1\n",
        "comment stipple object 1 epsilon 1\n",
        "comment stipple object x epsilon 1\n",
        "comment stipple object nan epsilon 1\n",
        "comment stipple object 0 epsilon 1\ncomment stipple object 0 epsilon 1\n",
    };
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        struct buffer b = { 0 };
        put_text(&b, START "%s" ONE, lines[i]);
        refuse_buffer(&b, STP_ERROR_FORMAT, "the header says of object");
        drop(&b);
    }
}

/* Vertices of objects that the header does not know, or of none. */
static void test_damaged_vertices(void **state)
{
    static const char two[] =
        START "comment stipple object 0 epsilon 1\ncomment stipple object 1 epsilon 1\n";
    static const char *const objects[] = { "2", "-1", "0.5", "nan", "1e9" };
    for (size_t i = 0; i < sizeof objects / sizeof *objects; i++) {
        struct buffer b = { 0 };
        put_text(
            &b, "%selement vertex 2\n" XYZ "property float object\nend_header\n0 0 0 1\n0 0 0 %s\n",
            two, objects[i]);
        refuse_buffer(&b, STP_ERROR_FORMAT, "vertex 1 is of object");
        drop(&b);
    }
    struct buffer b = { 0 };
    put_text(&b, "%s" ONE, two);
    refuse_buffer(&b, STP_ERROR_FORMAT, "lacks the property \"object\"");
    drop(&b);
}

/* As many as a scene may hold: the header is long, and read; one more is refused. */
static void test_most(void **state)
{
    for (unsigned count = 65535; count <= 65536; count++) {
        struct buffer b = { 0 };
        struct lines lines;
        struct cloud cloud;
        put_text(&b, START);
        for (unsigned i = 0; i < count; i++)
            put_text(&b, "comment stipple object %u epsilon %.17g normals estimated\n", i,
                     1e-3 * (i + 1) / 3);
        put_text(&b, "element vertex 1\n" XYZ "property uint object\nend_header\n0 0 0 65534\n");
        enum stp_result result = read_buffer(&b, NULL, 1, &cloud, &lines);
        assert_int_equal(result, count == 65535 ? STP_OK : STP_ERROR_FORMAT);
        if (result == STP_OK)
            assert_true(cloud.object[0] == 65534 &&
                        cloud.objects[65534].epsilon == 1e-3 * 65535 / 3);
        cloud_release(&cloud);
        drop(&b);
    }
}

static void test_memory(void **state)
{
    struct buffer b = { 0 };
    put_text(&b, "%s", several);
    fail_each_allocation(&b, NULL);
    drop(&b);
    struct cloud whole = read_text(several), *parts = NULL;
    unsigned long n = 1;
    for (;; n++) {
        mem_fail_at(n);
        enum stp_result result = cloud_split(NULL, &whole, &parts);
        bool reached = mem_count() >= n;
        mem_fail_at(0);
        assert_int_equal(result, reached ? STP_ERROR_MEMORY : STP_OK);
        if (!reached)
            break;
        assert_null(parts);
    }
    assert_true(n > 10);
    for (unsigned i = 0; i < 3; i++)
        cloud_release(&parts[i]);
    mem_free(parts);
    cloud_release(&whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one),     cmocka_unit_test(test_none),
        cmocka_unit_test(test_split),   cmocka_unit_test(test_most),
        cmocka_unit_test(test_damaged), cmocka_unit_test(test_damaged_vertices),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
