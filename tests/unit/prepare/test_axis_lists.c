/* The lists of a view: which splats, how often, in which order. Counted and checked by the
 * reference's code, pixel by pixel. */
#include "volumes.h"
#include "base/memory.h"
#include "prepare/axis_blocks.h"
#include "walks.h"

enum { N = 7, W = 28, H = 20 };

static struct stp_scene *random_scene(uint32_t seed, const double spacing[3])
{
    float values[N * N * N];
    struct stp_volume volume = { .dims = { N, N, N }, .value = values };
    for (int a = 0; a < 3; a++) {
        volume.spacing[a] = spacing[a];
        volume.origin[a] = -0.5 * (N - 1) * spacing[a];
    }
    for (int i = 0; i < N * N * N; i++)
        values[i] = uniform(&seed) < 0.4 ? NAN : (float)uniform(&seed);
    struct transfer_function f = { .count = 2,
                                   .point = { { 0, { 1, 0, 0 }, 1e-4f }, { 1, { 0, 1, 0 }, 1 } } };
    return volume_scene(&volume, &f);
}

/* The views of the reference's fixture, then views exactly on borders of two and three axes. */
#define MORE_VIEWS 4
static struct stp_camera view_of_index(int index)
{
    static const struct vec3 eyes[MORE_VIEWS] = {
        { 0, 0, 3 }, { 2, 0, 2 }, { 2, 2, 2 }, { 0, 3, 0.3 }
    };
    if (index < VIEWS)
        return hard_view(index, W, H);
    struct stp_camera c = plain_camera(W, H, 1.2 * H);
    look_at(&c, eyes[index - VIEWS], v3(0, 0, 0));
    return c;
}

static struct view view_of_pixels(const struct stp_scene *scene, const struct stp_camera *camera)
{
    struct view view = { .scene = scene, .width = W, .height = H, .grid = 1 };
    eye_init(&view.eye, camera, scene->splats.origin);
    return view;
}

/* HM 5.2 from the matrix alone. */
static double share(const struct stp_camera *c, int x, int y, int axis, bool backwards)
{
    const double *m = c->world_to_camera;
    double dx = (x + 0.5 - c->cx) / c->fx, dy = -(y + 0.5 - c->cy) / c->fy, v[3], most = 0;
    for (int a = 0; a < 3; a++) {
        v[a] = (c->orthographic ? 0 : m[a] * dx + m[4 + a] * dy) - m[8 + a];
        most = fmax(most, fabs(v[a]));
    }
    return (backwards ? -v[axis] : v[axis]) / most;
}

/* Splats with a fragment of weight above 0, of all six walks. */
static void count_by_pixels(const struct stp_scene *scene, const struct stp_camera *camera,
                            double h, size_t count[6])
{
    struct view view = view_of_pixels(scene, camera);
    struct medium medium;
    assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
    memset(count, 0, 6 * sizeof *count);
    for (uint32_t k = 0; k < scene->volume->kernels.count; k++) {
        struct vec3 centre = medium_centre(&medium, k);
        unsigned walks = 0;
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++) {
                struct ray ray = eye_ray(&view.eye, x + 0.5, y + 0.5);
                struct medium_fragment f;
                if (!medium_hit(&medium, centre, (double)scene->volume->kernels.tau[k], &ray, &f))
                    continue;
                for (unsigned w = 0; w < 6; w++)
                    walks |= (unsigned)(share(camera, x, y, (int)w / 2, w % 2) > h) << w;
            }
        for (unsigned w = 0; w < 6; w++)
            count[w] += walks >> w & 1;
    }
    medium_release(&medium);
}

static void counts_are_those_of_the_pixels(void **state)
{
    static const double hs[] = { 0, 0.85, 0.95, 0.99 };
    const double even[3] = { 0.25, 0.25, 0.25 }, flat[3] = { 0.05, 0.05, 0.5 };
    size_t walks_seen = 0;
    for (int v = 0; v < 2 * (VIEWS + MORE_VIEWS); v++) {
        struct stp_scene *scene = random_scene(9 + (uint32_t)v, v % 2 ? flat : even);
        struct stp_camera camera = view_of_index(v / 2);
        for (int i = 0; i < 4; i++) {
            size_t count[6], total = 0;
            struct axis_lists lists;
            count_by_pixels(scene, &camera, hs[i], count);
            assert_int_equal(lists_of_view(NULL, scene, &camera, STP_AXIS_BLEND, hs[i], &lists),
                             STP_OK);
            for (unsigned w = 0; w < lists.walk_count; w++) {
                const struct axis_walk *walk = &lists.walk[w];
                assert_int_equal(walk->count, count[2 * walk->axis + walk->backwards]);
                assert_int_equal(walk->first, total);
                total += walk->count;
            }
            for (int w = 0; w < 6; w++)
                total -= count[w];
            assert_int_equal(total, 0); /* nothing that has a weight is left out */
            walks_seen |= (size_t)1 << lists.walk_count;
            axis_lists_release(&lists);
        }
        stp_scene_destroy(&scene);
    }
    assert_true((walks_seen & 0x42) == 0x42); /* views of one walk, and of all six */
}

/* Sheets from far to near; in a sheet the later kernel first; no kernel twice. */
static void lists_are_in_order(void **state)
{
    struct stp_scene *scene = random_scene(3, (double[]){ 0.25, 0.25, 0.25 });
    for (int v = 0; v < VIEWS + MORE_VIEWS; v++)
        for (int merge = STP_AXIS_BLEND; merge <= STP_AXIS_SORT; merge++) {
            struct stp_camera camera = view_of_index(v);
            struct axis_lists lists;
            assert_int_equal(
                lists_of_view(NULL, scene, &camera, (enum stp_axis_merge)merge, 0.85, &lists),
                STP_OK);
            assert_true(lists.walk_count <= (merge >= STP_AXIS_SINGLE ? 1 : 6));
            for (unsigned w = 0; w < lists.walk_count; w++) {
                const struct axis_walk *walk = &lists.walk[w];
                const uint32_t *order = lists.order + walk->first;
                for (uint32_t i = 1; i < walk->count; i++) {
                    uint32_t a[3], b[3];
                    voxel_place(&scene->volume->grid, scene->volume->kernels.voxel[order[i - 1]],
                                a);
                    voxel_place(&scene->volume->grid, scene->volume->kernels.voxel[order[i]], b);
                    if (merge == STP_AXIS_SORT) {
                        double far[2];
                        for (int n = 0; n < 2; n++) {
                            const struct grid *g = &scene->volume->grid;
                            const uint32_t *at = n ? b : a;
                            struct vec3 p = m4_point(camera.world_to_camera,
                                                     v3(g->origin[0] + at[0] * g->spacing[0],
                                                        g->origin[1] + at[1] * g->spacing[1],
                                                        g->origin[2] + at[2] * g->spacing[2]));
                            far[n] = camera.orthographic ? -p.z : v3_dot(p, p);
                        }
                        assert_true(far[0] > far[1] ||
                                    (far[0] == far[1] && order[i - 1] > order[i]));
                        continue;
                    }
                    uint32_t p = a[walk->axis], q = b[walk->axis];
                    assert_true(walk->backwards ? p <= q : p >= q);
                    assert_true(p != q || order[i - 1] > order[i]);
                }
            }
            axis_lists_release(&lists);
        }
    stp_scene_destroy(&scene);
}

/* A narrow view along an axis: one list, and not an entry of another. */
static void one_axis_one_list(void **state)
{
    struct stp_scene *scene = random_scene(4, (double[]){ 0.25, 0.25, 0.25 });
    struct stp_camera camera = plain_camera(W, H, 4 * H);
    look_at(&camera, v3(0, 0, 30), v3(0, 0, 0));
    /* look_at leans by no more than the picture's half angle: every ray's others are below 0.85. */
    for (int merge = STP_AXIS_BLEND; merge <= STP_AXIS_SORT; merge++) {
        struct axis_lists lists;
        assert_int_equal(
            lists_of_view(NULL, scene, &camera, (enum stp_axis_merge)merge, 0.85, &lists), STP_OK);
        assert_int_equal(lists.walk_count, 1);
        assert_true(lists.walk[0].axis == 2 && lists.walk[0].backwards);
        assert_int_equal(lists.count, lists.visible);
        assert_true(!lists.sheets[0].first && !lists.sheets[1].first);
        assert_true((lists.sheets[2].first != NULL) == (merge != STP_AXIS_SORT));
        assert_null(lists.sheets[2].kernel);
        axis_lists_release(&lists);
    }
    stp_scene_destroy(&scene);
}

/* Every fragment with a weight is of a splat that its block lists, once and in the list's order. */
static void expect_block(const struct medium *medium, const struct stp_camera *camera,
                         const struct axis_lists *lists, const struct axis_blocks *blocks,
                         unsigned w, uint32_t b)
{
    const struct axis_walk *walk = &lists->walk[w];
    size_t list = w * (size_t)blocks->across * blocks->down + b, at = blocks->first[list];
    assert_true(blocks->first[list + 1] - at <= blocks->longest);
    for (uint32_t i = walk->first; i < walk->first + walk->count; i++) {
        uint32_t k = lists->order[i];
        bool listed = at < blocks->first[list + 1] && blocks->entry[at] == k;
        at += listed;
        for (int p = 0; !listed && p < AXIS_BLOCK_WIDTH * AXIS_BLOCK_HEIGHT; p++) {
            int x = (int)(b % blocks->across) * AXIS_BLOCK_WIDTH + p % AXIS_BLOCK_WIDTH;
            int y = (int)(b / blocks->across) * AXIS_BLOCK_HEIGHT + p / AXIS_BLOCK_WIDTH;
            struct ray ray = eye_ray(&medium->view->eye, x + 0.5, y + 0.5);
            struct medium_fragment f;
            assert_false(x < W && y < H &&
                         share(camera, x, y, walk->axis, walk->backwards) > lists->h &&
                         medium_hit(medium, medium_centre(medium, k),
                                    (double)medium->volume->kernels.tau[k], &ray, &f));
        }
    }
    assert_int_equal(at, blocks->first[list + 1]);
}

static void expect_fullest(const struct axis_blocks *blocks, unsigned walks)
{
    size_t count = (size_t)blocks->across * blocks->down, most = 0;
    for (size_t b = 0; b < count; b++) {
        size_t sum = 0;
        for (unsigned w = 0; w < walks; w++)
            sum += blocks->first[w * count + b + 1] - blocks->first[w * count + b];
        most = sum > most ? sum : most;
    }
    assert_int_equal(blocks->fullest, most);
}

/* The lists and blocks of one view after another, in the same memory. */
static void blocks_hold_every_fragment(void **state)
{
    struct stp_scene *scene = random_scene(40, (double[]){ 0.25, 0.2, 0.3 });
    struct axis_lists lists = { .merge = STP_AXIS_BLEND, .h = 0.5 };
    struct axis_blocks blocks = { 0 };
    for (int v = 0; v < VIEWS + MORE_VIEWS; v++) {
        struct stp_camera camera = view_of_index(v);
        struct view view = view_of_pixels(scene, &camera);
        struct medium medium;
        assert_int_equal(medium_init(NULL, &view, &medium), STP_OK);
        assert_int_equal(axis_lists_update(NULL, scene, &camera, &lists), STP_OK);
        assert_int_equal(axis_blocks_update(NULL, &lists, &blocks), STP_OK);
        for (unsigned w = 0; w < lists.walk_count; w++)
            for (uint32_t b = 0; b < blocks.across * blocks.down; b++)
                expect_block(&medium, &camera, &lists, &blocks, w, b);
        expect_fullest(&blocks, lists.walk_count);
        medium_release(&medium);
    }
    axis_blocks_release(&blocks);
    axis_lists_release(&lists);
    stp_scene_destroy(&scene);
}

/* A former view leaves nothing behind. */
static void updated_as_built(void **state)
{
    struct stp_scene *scene = random_scene(41, (double[]){ 0.05, 0.05, 0.5 });
    for (int merge = STP_AXIS_BLEND; merge <= STP_AXIS_SORT; merge++) {
        struct axis_lists moved = { .merge = (enum stp_axis_merge)merge, .h = 0.7 };
        struct axis_blocks at = { 0 };
        for (int v = VIEWS + MORE_VIEWS - 1; v >= 0; v--) {
            struct stp_camera camera = view_of_index(v);
            camera.width -= (uint32_t)(v % 3);
            struct axis_lists fresh;
            struct axis_blocks own = { 0 };
            assert_int_equal(axis_lists_update(NULL, scene, &camera, &moved), STP_OK);
            assert_int_equal(axis_blocks_update(NULL, &moved, &at), STP_OK);
            assert_int_equal(lists_of_view(NULL, scene, &camera, moved.merge, 0.7, &fresh), STP_OK);
            assert_int_equal(axis_blocks_update(NULL, &fresh, &own), STP_OK);
            assert_int_equal(moved.count, fresh.count);
            assert_int_equal(moved.visible, fresh.visible);
            assert_int_equal(at.count, own.count);
            if (fresh.count) {
                assert_memory_equal(moved.order, fresh.order, fresh.count * sizeof *fresh.order);
                assert_memory_equal(at.entry, own.entry, own.count * sizeof *own.entry);
            }
            axis_blocks_release(&own);
            axis_lists_release(&fresh);
        }
        axis_blocks_release(&at);
        axis_lists_release(&moved);
    }
    stp_scene_destroy(&scene);
}

static void one_voxel_and_none(void **state)
{
    struct stp_scene *scene = block_scene((uint32_t[]){ 1, 1, 1 }, (double[]){ 1, 1, 1 }, 0.5);
    struct stp_camera camera = plain_camera(W, H, H);
    struct axis_lists lists;
    look_at(&camera, v3(0, 0, 5), v3(0, 0, 0));
    assert_int_equal(lists_of_view(NULL, scene, &camera, STP_AXIS_BLEND, 0.85, &lists), STP_OK);
    assert_true(lists.walk_count == 1 && lists.count == 1 && lists.order[0] == 0);
    axis_lists_release(&lists);
    look_at(&camera, v3(0, 0, 5), v3(0, 0, 10)); /* behind the eye */
    assert_int_equal(lists_of_view(NULL, scene, &camera, STP_AXIS_BLEND, 0.85, &lists), STP_OK);
    assert_true(lists.walk_count == 0 && lists.count == 0 && !lists.order);
    axis_lists_release(&lists);
    stp_scene_destroy(&scene);
}

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

static void threads_and_allocations(void **state)
{
    struct stp_scene *scene = random_scene(8, (double[]){ 0.25, 0.25, 0.25 });
    struct stp_camera camera = view_of_index(2);
    for (int merge = STP_AXIS_BLEND; merge <= STP_AXIS_SORT; merge += STP_AXIS_SORT) {
        struct stp_env one = { .threads = 1, .log = swallow }, many = { .threads = 4 };
        struct axis_lists a = { 0 }, b;
        enum stp_axis_merge m = (enum stp_axis_merge)merge;
        assert_int_equal(lists_of_view(&many, scene, &camera, m, 0.5, &b), STP_OK);
        enum stp_result result = STP_ERROR_MEMORY;
        for (unsigned long n = 1; result != STP_OK; n++) {
            mem_fail_at(n);
            result = lists_of_view(&one, scene, &camera, m, 0.5, &a);
            mem_fail_at(0);
            assert_true(result == STP_OK || (result == STP_ERROR_MEMORY && !a.order));
            assert_true(n < 50);
        }
        assert_int_equal(a.count, b.count);
        assert_memory_equal(a.order, b.order, a.count * sizeof *a.order);
        struct axis_blocks x = { 0 }, y = { 0 };
        assert_int_equal(axis_blocks_update(&many, &b, &y), STP_OK);
        result = STP_ERROR_MEMORY;
        for (unsigned long n = 1; result != STP_OK; n++) {
            mem_fail_at(n);
            result = axis_blocks_update(&one, &a, &x);
            mem_fail_at(0);
            assert_true(result == STP_OK || (result == STP_ERROR_MEMORY && !x.first));
            assert_true(n < 50);
        }
        assert_int_equal(x.count, y.count);
        assert_memory_equal(x.entry, y.entry, x.count * sizeof *x.entry);
        axis_blocks_release(&x);
        axis_blocks_release(&y);
        axis_lists_release(&a);
        axis_lists_release(&b);
    }
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_are_those_of_the_pixels),
        cmocka_unit_test(lists_are_in_order),
        cmocka_unit_test(one_axis_one_list),
        cmocka_unit_test(blocks_hold_every_fragment),
        cmocka_unit_test(updated_as_built),
        cmocka_unit_test(one_voxel_and_none),
        cmocka_unit_test(threads_and_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
