/* OBJ vertices, colours, and normals where they belong to vertices. */
#include <math.h>
#include <string.h>

#include "support.h"

static void test_vertices(void **state)
{
    static const char *const texts[] = {
        "v 1 2 3\nv 4 5 6\n",
        "# c\nmtllib a.mtl\no thing\nv 1 2 3\r\nvt 0 0\nv 4 5 6 # last\nf 1 2 1\n",
        "v 1 2 3 1.0\nv 4 5 6 0.5\n", /* a weight */
        "g\n\n  v   1 2\t3\nv 4 5 6",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct cloud c = read_text(texts[i]);
        assert_int_equal(c.count, 2);
        assert_string_equal(c.format, "OBJ");
        assert_true(!c.normal && !c.color);
        for (int k = 0; k < 6; k++)
            assert_true(c.position[k / 3][k % 3] == k + 1);
        cloud_release(&c);
    }
}

static void test_colors(void **state)
{
    struct cloud c = read_text("v 1 2 3 0.25 0.5 1\nv 4 5 6 0 0 0\n");
    assert_true(c.color[0][0] == 0.25f && c.color[0][2] == 1);
    cloud_release(&c);
    c = read_text("v 1 2 3 1 0.25 0.5 1\n"); /* the weight first */
    assert_true(c.color[0][0] == 0.25f && c.color[0][2] == 1);
    cloud_release(&c);
    c = read_text("v 1 2 3 255 0 51\n");
    assert_true(c.color[0][0] == 1 && c.color[0][1] == 0);
    cloud_release(&c);
    c = read_text("v 1 2 3 0.25 0.5 1\nv 4 5 6\n"); /* some have none */
    assert_null(c.color);
    cloud_release(&c);
}

static void test_paired_normals(void **state)
{
    struct cloud c = read_text("v 1 2 3\nvn 0 0 2\nv 4 5 6\nvn 1 0 0\n");
    assert_true(c.normal[0][2] == 2 && c.normal[1][0] == 1);
    cloud_release(&c);
    c = read_text("v 1 2 3\nvn 0 0 2\nv 4 5 6\n"); /* whose is it? */
    assert_null(c.normal);
    cloud_release(&c);
}

static void test_normals_through_faces(void **state)
{
    struct cloud c = read_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nvn 0 0 1\nvn 0 3 0\n"
                               "f 1//1 2//1 3//1\nf 1/7/2 -3//-1 3\n");
    float slant = (float)(1 / sqrt(10.0));
    assert_true(fabsf(c.normal[0][2] - slant) < 1e-7f);
    assert_true(fabsf(c.normal[0][1] - 3 * slant) < 1e-7f);
    assert_true(fabsf(c.normal[1][1] - 3 * slant) < 1e-7f);
    assert_true(c.normal[2][2] == 1 && c.normal[2][1] == 0);
    assert_true(c.normal[3][0] == 0 && c.normal[3][1] == 0 && c.normal[3][2] == 0);
    cloud_release(&c);
}

/* Indices that name nothing are passed over. */
static void test_hostile_faces(void **state)
{
    struct cloud c = read_text("v 0 0 0\nvn 0 0 1\nf 1//1 5//1 1//9 -7//-9 0//0 1//\n"
                               "f 99999999999999999999999//99999999999999999999999 / // -\nf\n");
    assert_true(c.normal[0][2] == 1);
    cloud_release(&c);
}

static void test_errors(void **state)
{
    refuse_text("v 1 2\n", STP_ERROR_FORMAT, "a vertex (v) without three numbers");
    refuse_text("v 1 2 3\nv 1 2 x\n", STP_ERROR_FORMAT, "byte 9: a vertex (v)");
    refuse_text("v 1 2 3\nvn 0 1\n", STP_ERROR_FORMAT, "a normal (vn) without three numbers");
    struct cloud c = read_text("# empty\no nothing\n");
    assert_int_equal(c.count, 0);
    cloud_release(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_vertices),       cmocka_unit_test(test_colors),
        cmocka_unit_test(test_paired_normals), cmocka_unit_test(test_normals_through_faces),
        cmocka_unit_test(test_hostile_faces),  cmocka_unit_test(test_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
