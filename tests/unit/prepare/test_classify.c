/* Voxels to kernels: which, what they look like, and what a new transfer function changes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/memory.h"
#include "prepare/volume.h"

enum { NX = 7, NY = 5, NZ = 6 };

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

/* value(i, j, k) = 3 i + 2 j - k, but NaN at one. */
static struct stp_scene *ramp_scene(const struct stp_volume_params *params)
{
    static float value[NX * NY * NZ];
    struct stp_scene *scene = NULL;
    struct stp_volume volume = {
        .dims = { NX, NY, NZ }, .spacing = { 1, 2, 0.5 }, .origin = { 10, 20, 30 }, .value = value
    };
    for (int n = 0; n < NX * NY * NZ; n++)
        value[n] = n == 107 ? NAN : (float)(3 * (n % NX) + 2 * (n / NX % NY) - n / NX / NY);
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_set_volume(NULL, scene, &volume, params), STP_OK);
    return scene;
}

static void as_the_transfer_function_says(void **state)
{
    struct stp_volume_params params = { .transfer_function = "bone" };
    struct stp_scene *scene = ramp_scene(&params);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    const struct volume *v = scene->volume;
    size_t at = 0, kept = 0;
    struct transfer_function bone;
    assert_true(transfer_preset("bone", &bone));
    for (uint32_t n = 0; n < NX * NY * NZ; n++) {
        double u = ((double)v->grid.value[n] - v->grid.low) / (v->grid.high - v->grid.low);
        struct transfer_point p = transfer_at(&bone, u);
        if (!(p.opacity > 0))
            continue;
        kept++;
        assert_true(at < v->kernels.count && v->kernels.voxel[at] == n);
        double tau = -log1p(-(double)p.opacity) / 0.5;
        assert_true(fabs((double)v->kernels.tau[at] - tau) <= 1e-6 * tau);
        assert_memory_equal(v->kernels.color[at], p.color, sizeof p.color);
        at++;
    }
    assert_int_equal(kept, v->kernels.count);
    assert_int_equal(scene->facts.splats, kept);
    assert_true(scene->facts.not_finite > 0);
    assert_true(kept > 10 && kept < NX * NY * NZ);
    stp_scene_destroy(&scene);
}

/* The gradient of a linear ramp is the same everywhere, at borders and beside NaN too. */
static void normals_are_against_the_gradient(void **state)
{
    struct stp_volume_params params = { .transfer_function = "grey" };
    struct stp_scene *scene = ramp_scene(&params);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    double g[3] = { 3, 1, -2 }, length = sqrt(14);
    for (size_t i = 0; i < scene->volume->kernels.count; i++)
        for (int a = 0; a < 3; a++)
            assert_true(fabs((double)scene->volume->kernels.normal[i][a] + g[a] / length) < 1e-6);
    stp_scene_destroy(&scene);
}

static void opacity_one_has_a_finite_depth(void **state)
{
    float one = 1;
    struct stp_scene *scene = NULL;
    struct stp_volume volume = { .dims = { 1, 1, 1 }, .spacing = { 2, 2, 2 }, .value = &one };
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_set_volume(NULL, scene, &volume, NULL), STP_OK);
    scene->volume->automatic = false;
    scene->volume->transfer =
        (struct transfer_function){ .count = 1, .point = { { 0, { 1 }, 1 } } };
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    assert_true(fabs((double)scene->volume->kernels.tau[0] - 24 * log(2) / 2) < 1e-5);
    assert_true(scene->volume->kernels.normal[0][0] == 0);
    stp_scene_destroy(&scene);
}

static void a_clip_box_and_a_new_function(void **state)
{
    const double box[6] = { 11, 0, 0, 13, 100, 100 };
    struct stp_volume_params params = { .transfer_function = "grey", .unshaded = true };
    struct stp_prepare_params prepare = { .clip_box = box };
    struct stp_env quiet = { .log = swallow };
    struct stp_scene *scene = ramp_scene(&params);
    assert_int_equal(stp_scene_prepare(NULL, scene, &prepare), STP_OK);
    assert_true(scene->facts.bounds[0] >= 11 && scene->facts.bounds[3] <= 13);
    assert_true(scene->facts.clipped > 0 && !scene->volume->kernels.normal);
    size_t before = scene->facts.splats;
    params = (struct stp_volume_params){ .transfer_function = "hot" };
    assert_int_equal(stp_scene_set_transfer_function(NULL, scene, &params), STP_OK);
    assert_non_null(scene->volume->kernels.normal);
    assert_true(scene->facts.bounds[3] <= 13);
    assert_string_equal(scene->facts.volume.transfer_function, "hot");
    params.transfer_function = "/no/such/file";
    assert_int_equal(stp_scene_set_transfer_function(&quiet, scene, &params), STP_ERROR_IO);
    assert_string_equal(scene->volume->transfer.name, "hot");
    assert_true(before > 0 && scene->volume->kernels.count == scene->facts.splats);
    stp_scene_destroy(&scene);
}

/* Two populations: the threshold falls between them, so air is left out and tissue is not. */
static void automatic_separates_two_materials(void **state)
{
    enum { N = 12 };
    static float value[N * N * N];
    struct stp_scene *scene = NULL;
    size_t inside = 0;
    for (int n = 0; n < N * N * N; n++) {
        int i = n % N - 6, j = n / N % N - 6, k = n / N / N - 6;
        bool in = i * i + j * j + k * k < 16;
        inside += in;
        value[n] = (float)((in ? 900 : -1000) + (n * 7919) % 61);
    }
    struct stp_volume volume = { .dims = { N, N, N }, .spacing = { 1, 1, 1 }, .value = value };
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_set_volume(NULL, scene, &volume, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    assert_int_equal(scene->facts.splats, inside);
    assert_string_equal(scene->facts.volume.transfer_function, "auto");
    stp_scene_destroy(&scene);
}

static void nothing_left_is_said(void **state)
{
    const double box[6] = { -9, -9, -9, -8, -8, -8 };
    struct stp_prepare_params prepare = { .clip_box = box };
    struct stp_env quiet = { .log = swallow };
    struct stp_scene *scene = ramp_scene(NULL);
    assert_int_equal(stp_scene_prepare(&quiet, scene, &prepare), STP_ERROR_NO_POINTS);
    assert_false(scene->prepared);
    stp_scene_destroy(&scene);
}

static void threads_change_nothing_and_allocations_may_fail(void **state)
{
    struct stp_env one = { .threads = 1, .log = swallow }, many = { .threads = 5 };
    struct stp_scene *a = ramp_scene(NULL), *b = ramp_scene(NULL);
    assert_int_equal(stp_scene_prepare(&many, b, NULL), STP_OK);
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        mem_fail_at(n);
        result = stp_scene_prepare(&one, a, NULL);
        mem_fail_at(0);
        assert_true(result == STP_OK || (result == STP_ERROR_MEMORY && !a->prepared));
        assert_true(n < 50);
    }
    const struct kernels *x = &a->volume->kernels, *y = &b->volume->kernels;
    assert_int_equal(x->count, y->count);
    assert_memory_equal(x->voxel, y->voxel, x->count * sizeof *x->voxel);
    assert_memory_equal(x->color, y->color, x->count * sizeof *x->color);
    assert_memory_equal(x->tau, y->tau, x->count * sizeof *x->tau);
    assert_memory_equal(x->normal, y->normal, x->count * sizeof *x->normal);
    stp_scene_destroy(&a);
    stp_scene_destroy(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_the_transfer_function_says),
        cmocka_unit_test(normals_are_against_the_gradient),
        cmocka_unit_test(opacity_one_has_a_finite_depth),
        cmocka_unit_test(a_clip_box_and_a_new_function),
        cmocka_unit_test(automatic_separates_two_materials),
        cmocka_unit_test(nothing_left_is_said),
        cmocka_unit_test(threads_change_nothing_and_allocations_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
