// The camera matrices against glm, which shares nothing with us.
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>

extern "C" {
#include <cmocka.h>
#include "write/exr_camera.h"
}

static const glm::dvec3 eye(3, -2, 7), target(-1, 0.5, -2), up(0.1, 1, 0.2);

// Right-handed view, then +Z forward.
static glm::dmat4 left_handed_view(const glm::dvec3 &origin)
{
    return glm::scale(glm::dmat4(1), glm::dvec3(1, 1, -1)) * glm::lookAtRH(eye, target, up) *
           glm::translate(glm::dmat4(1), origin);
}

// Clip space to x and y in [0, 1] with y down.
static glm::dmat4 to_unit_square()
{
    return glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(0.5, 0.5, 0)),
                      glm::dvec3(0.5, -0.5, 1));
}

static stp_camera make_camera(bool orthographic, double far_depth)
{
    stp_camera camera = {};
    const glm::dmat4 view = glm::lookAtRH(eye, target, up);
    for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++)
            camera.world_to_camera[4 * row + column] = view[column][row];
    camera.orthographic = orthographic;
    camera.fx = orthographic ? 30 : 400;
    camera.fy = orthographic ? 32 : 410;
    camera.cx = 300;
    camera.cy = 250;
    camera.width = 640;
    camera.height = 480;
    camera.near_depth = 0.25;
    camera.far_depth = far_depth;
    return camera;
}

// glm's columns are our rows: both store the transpose of the other's matrix the same way.
static void check_matrix(const double m[16], const glm::dmat4 &expected)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            assert_true(std::fabs(m[4 * i + j] - expected[i][j]) < 1e-12);
}

static void test_view(void **)
{
    const double origin[3] = { 10, 20, -30 };
    double m[16];
    const stp_camera camera = make_camera(false, 100);
    exr_world_to_camera(&camera, origin, m);
    check_matrix(m, left_handed_view(glm::dvec3(10, 20, -30)));
}

static void test_perspective(void **)
{
    const double origin[3] = { 1, 2, 3 };
    double m[16];
    const stp_camera c = make_camera(false, 100);
    const double n = c.near_depth;
    const glm::dmat4 projection =
        glm::frustumRH_ZO(-c.cx / c.fx * n, (c.width - c.cx) / c.fx * n,
                          -(c.height - c.cy) / c.fy * n, c.cy / c.fy * n, n, c.far_depth);
    // The right-handed form: this glm's frustumLH has the wrong sign off-centre.
    const glm::dmat4 view =
        glm::lookAtRH(eye, target, up) * glm::translate(glm::dmat4(1), glm::dvec3(1, 2, 3));
    exr_world_to_ndc(&c, origin, m);
    check_matrix(m, to_unit_square() * projection * view);
}

static void test_infinite(void **)
{
    const double origin[3] = { 0, 0, 0 };
    double m[16];
    stp_camera c = make_camera(false, std::numeric_limits<double>::infinity());
    c.fx = c.fy = 410;
    c.cx = 320;
    c.cy = 240;
    glm::dmat4 projection =
        glm::infinitePerspectiveLH(2 * std::atan(240 / 410.0), 640 / 480.0, c.near_depth);
    // This glm keeps depth in [-1, 1] there.
    projection =
        glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(0, 0, 0.5)), glm::dvec3(1, 1, 0.5)) *
        projection;
    exr_world_to_ndc(&c, origin, m);
    check_matrix(m, to_unit_square() * projection * left_handed_view(glm::dvec3(0)));
}

static void test_orthographic(void **)
{
    const double origin[3] = { 1, 2, 3 };
    double m[16];
    const stp_camera c = make_camera(true, 100);
    const glm::dmat4 projection =
        glm::orthoLH_ZO(-c.cx / c.fx, (c.width - c.cx) / c.fx, -(c.height - c.cy) / c.fy,
                        c.cy / c.fy, c.near_depth, c.far_depth);
    exr_world_to_ndc(&c, origin, m);
    check_matrix(m, to_unit_square() * projection * left_handed_view(glm::dvec3(1, 2, 3)));
}

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_view),
        cmocka_unit_test(test_perspective),
        cmocka_unit_test(test_infinite),
        cmocka_unit_test(test_orthographic),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
