/* The survey against fragments counted one by one, by the reference's own hits. */
#include "../pass/ellipses.h"
#include "plans.h"

#include "base/memory.h"
#include "plan/survey.h"
#include "reference/disc.h"

struct counted {
    double fragments, drawn;
    bool hit[64 * 64]; /* blocks */
};

static void count_disc(const struct view *view, size_t id, struct counted *counted)
{
    struct disc disc;
    struct fragment fragment;
    bool any = false;
    if (!disc_setup(view, id, &disc))
        return;
    for (uint32_t y = 0; y < view->height; y++)
        for (uint32_t x = 0; x < view->width; x++) {
            struct ray ray = eye_ray(&view->eye, x + 0.5, y + 0.5);
            if (!disc_hit(&disc, &view->eye, &ray, x + 0.5, y + 0.5, &fragment))
                continue;
            counted->fragments++;
            counted->hit[y / 8 * ((view->width + 7) / 8) + x / 8] = any = true;
        }
    counted->drawn += any;
}

static struct survey survey_of(const struct stp_scene *scene, const struct stp_camera *camera,
                               const struct stp_render_params *params, unsigned threads)
{
    struct survey survey;
    struct stp_env env = { .threads = threads };
    assert_int_equal(survey_make(&env, scene, camera, params, &survey), STP_OK);
    return survey;
}

/* Every block with a fragment is touched; the sums are about right, and too high rather than too
 * low. */
static void compare(const struct stp_scene *scene, const struct stp_camera *camera,
                    const struct stp_render_params *params, double tolerance)
{
    struct view view = reference_view(scene, camera, params);
    struct counted *counted = calloc(1, sizeof *counted);
    for (size_t i = 0; i < scene->splats.count; i++)
        count_disc(&view, i, counted);
    struct survey s = survey_of(scene, camera, params, 2);
    for (uint32_t b = 0; b < s.across * s.down; b++)
        assert_true(!counted->hit[b] || s.mass[b] > 0);
    assert_true(s.drawn >= counted->drawn);
    assert_true(fabs(s.fragments - counted->fragments) <= tolerance * counted->fragments);
    assert_true(s.small_box + s.large_box >= 0.95 * counted->fragments);
    assert_true(s.touched <= s.across * s.down * 64.0);
    survey_release(&s);
    free(counted);
}

static void test_against_hits(void **state)
{
    for (uint32_t seed = 1; seed <= 6; seed++) {
        struct stp_scene *scene = scene_random(seed, 300, 0.1);
        struct stp_camera camera = hard_view(0, 123, 77), flat = flat_camera(123, 77, 30);
        struct stp_render_params params = { .min_splat = -1 };
        compare(scene, &camera, &params, 0.04);
        params.min_splat = 3;
        compare(scene, &camera, &params, 0.04);
        params.cull = STP_CULL_BACK;
        compare(scene, &camera, &params, 0.04);
        look_at(&flat, v3(2, 3, 4), v3(0, 0, 0));
        params.max_error = 1;
        compare(scene, &flat, &params, 0.04);
        stp_scene_destroy(&scene);
    }
}

/* Splats that span the picture: no block that they touch is missed, and each adds its share to all
 * of them. */
static void test_huge(void **state)
{
    struct stp_scene *scene = scene_make(100, 1, 0.1);
    struct stp_render_params params = { .min_splat = -1, .max_error = 1 };
    struct stp_camera camera = plain_camera(256, 256, 256);
    uint32_t seed = 9;
    for (int i = 0; i < 100; i++)
        scene_add(scene, v3(0.1 * uniform(&seed), 0.1 * uniform(&seed), -1), v3(0, 0, 1),
                  i ? 0.2 : 0.48);
    scene_finish(scene);
    compare(scene, &camera, &params, 0.04);
    stp_scene_destroy(&scene);
}

/* Ellipses of up to 30 : 1, with fields that may face the eye where their normals do not. */
static void test_ellipses(void **state)
{
    for (uint32_t seed = 1; seed <= 4; seed++) {
        struct stp_scene *scene = random_scene(seed, 300, false);
        struct stp_camera camera = hard_view(0, 123, 77), flat = flat_camera(123, 77, 30);
        struct stp_render_params params = { .min_splat = -1 };
        compare(scene, &camera, &params, 0.04);
        params.cull = STP_CULL_BACK;
        compare(scene, &camera, &params, 0.04);
        look_at(&flat, v3(2, 3, 4), v3(0, 0, 0));
        compare(scene, &flat, &params, 0.04);
        stp_scene_destroy(&scene);
    }
}

static void same(const struct survey *a, const struct survey *b)
{
    const size_t sums = offsetof(struct survey, mass);
    assert_memory_equal(a, b, sums);
    assert_memory_equal(a->mass, b->mass, (size_t)a->across * a->down * sizeof *a->mass);
}

static void test_threads(void **state)
{
    struct stp_scene *scene = scene_random(3, 4000, 0.1);
    struct stp_camera camera = plain_camera(200, 100, 120);
    struct stp_render_params params = { .min_splat = -1 };
    struct survey one = survey_of(scene, &camera, &params, 1);
    for (unsigned threads = 2; threads < 6; threads++) {
        struct survey many = survey_of(scene, &camera, &params, threads);
        same(&one, &many);
        survey_release(&many);
    }
    survey_release(&one);
    stp_scene_destroy(&scene);
}

/* A sheet of n x n discs that fills the picture. */
static struct stp_scene *sheet(unsigned n)
{
    struct stp_scene *scene = scene_make((size_t)n * n, 1, 0.1);
    for (unsigned i = 0; i < n * n; i++)
        scene_add(scene, v3((i % n + 0.5) / n - 0.5, (i / n + 0.5) / n - 0.5, -1), v3(0, 0, 1),
                  1.2 / n);
    scene_finish(scene);
    return scene;
}

/* Of more splats than are looked at one by one, some stand for all. */
static void test_sample(void **state)
{
    struct stp_scene *scene = sheet(600);
    struct stp_camera camera = plain_camera(256, 256, 256);
    struct stp_render_params params = { .min_splat = -1 };
    struct survey s = survey_of(scene, &camera, &params, 2);
    double area = M_PI * 1.2 * 1.2 * 256 * 256;
    assert_true(fabs(s.drawn / (600 * 600) - 1) < 0.02);
    assert_true(fabs(s.fragments / area - 1) < 0.05);
    assert_true(s.touched == s.pixels);
    assert_true(s.overflow == 0 && s.large == 0);
    survey_release(&s);
    params.max_error = 1; /* then all are looked at */
    s = survey_of(scene, &camera, &params, 2);
    assert_true(s.drawn == 600 * 600);
    survey_release(&s);
    stp_scene_destroy(&scene);
}

static void test_depth(void **state)
{
    struct stp_scene *scene = scene_make(100, 1, 0.1);
    for (int i = 0; i < 100; i++)
        scene_add(scene, v3(0, 0, -1), v3(0, 0, 1), 0.5);
    scene_finish(scene);
    struct stp_camera camera = plain_camera(64, 64, 64);
    struct stp_render_params params = { .min_splat = -1 };
    struct survey s = survey_of(scene, &camera, &params, 1);
    assert_true(s.large == 100);
    assert_true(s.overflow > 0.7 * 64 * 64); /* of a disc that spans the picture */
    assert_true(s.deep > 80 * M_PI * 32 * 32);
    survey_release(&s);
    stp_scene_destroy(&scene);
}

/* The eye among the splats, behind them, and beside them. */
static void test_boundary(void **state)
{
    struct stp_scene *scene = scene_make(4, 1, 0.1);
    struct stp_render_params params = { .min_splat = -1 };
    struct stp_camera camera = plain_camera(64, 48, 50);
    scene_add(scene, v3(0, 0, 0), v3(0, 1, 1), 1);    /* around the eye */
    scene_add(scene, v3(0, 0, 5), v3(0, 0, 1), 1);    /* behind */
    scene_add(scene, v3(900, 0, -5), v3(0, 0, 1), 1); /* beside */
    scene_add(scene, v3(0, 0, -1e4), v3(0, 0, 1), 1); /* below a pixel */
    scene_finish(scene);
    struct survey s = survey_of(scene, &camera, &params, 1);
    assert_true(s.drawn == 1);
    assert_true(isfinite(s.fragments) && isfinite(s.large_box));
    assert_true(s.large_box >= 64 * 48 / 2);
    survey_release(&s);
    stp_scene_destroy(&scene);
}

/* Discs that the near plane cuts: all that shows is counted, and what is beside the view is not. */
static void test_cut(void **state)
{
    struct stp_scene *scene = scene_make(200, 1, 0.1);
    struct stp_camera camera = plain_camera(123, 77, 100);
    struct stp_render_params params = { .min_splat = -1 };
    uint32_t seed = 7;
    for (int i = 0; i < 200; i++) {
        double r[7];
        for (int k = 0; k < 7; k++)
            r[k] = uniform(&seed);
        scene_add(scene, v3(r[0] - 0.5, r[1] - 0.5, 0.2 * r[2] - 0.1 - camera.near_depth),
                  v3(r[3] - 0.5, r[4] - 0.5, r[5] - 0.5), 0.1 + 0.3 * r[6]);
    }
    scene_finish(scene);
    compare(scene, &camera, &params, 1);
    stp_scene_destroy(&scene);

    scene = scene_make(1, 1, 0.1);
    scene_add(scene, v3(2, 0, -camera.near_depth), v3(0.1, 1, 0.2), 1);
    scene_finish(scene);
    struct survey s = survey_of(scene, &camera, &params, 1);
    assert_true(s.drawn == 0 && s.touched == 0);
    survey_release(&s);
    stp_scene_destroy(&scene);
}

static void ignore(void *user, enum stp_log_level level, const char *line)
{
}

static void test_no_memory(void **state)
{
    struct stp_scene *scene = scene_random(1, 50, 0.1);
    struct stp_camera camera = plain_camera(64, 48, 50);
    struct stp_render_params params = { 0 };
    struct stp_env env = { .threads = 1, .log = ignore };
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        struct survey survey = { 0 };
        mem_fail_at(n);
        result = survey_make(&env, scene, &camera, &params, &survey);
        mem_fail_at(0);
        assert_true(result == STP_OK || (result == STP_ERROR_MEMORY && !survey.mass));
        survey_release(&survey);
    }
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_hits), cmocka_unit_test(test_huge),
        cmocka_unit_test(test_ellipses),     cmocka_unit_test(test_threads),
        cmocka_unit_test(test_sample),       cmocka_unit_test(test_depth),
        cmocka_unit_test(test_boundary),     cmocka_unit_test(test_cut),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
