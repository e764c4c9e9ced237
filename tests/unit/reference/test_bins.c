/* No fragment lies outside a splat's bound, and no tile lacks a splat: against every ray. */
#include "fixture.h"

#include "base/memory.h"
#include "reference/bins.h"

static struct view view_of(struct fixture *f, const struct stp_camera *camera, double min_splat)
{
    struct view view = { .scene = &f->scene,
                         .width = camera->width,
                         .height = camera->height,
                         .two_sided = true,
                         .min_splat = min_splat,
                         .grid = 1 };
    eye_init(&view.eye, camera, f->scene.splats.origin);
    return view;
}

static bool tile_has(const struct bins *bins, double px, double py, uint32_t id)
{
    size_t tile = (size_t)(py / TILE) * bins->across + (size_t)(px / TILE);
    for (size_t k = bins->first[tile]; k < bins->first[tile + 1]; k++)
        if (bins->splat[k] == id)
            return true;
    return false;
}

/* Every pixel's centre and its left top corner. */
static size_t try_rays(const struct view *view, const struct bins *bins, const struct disc *disc,
                       uint32_t id)
{
    size_t hits = 0;
    for (uint32_t j = 0; j < 2 * view->height; j++)
        for (uint32_t i = 0; i < 2 * view->width; i++) {
            double px = i / 2.0, py = j / 2.0;
            struct ray ray = eye_ray(&view->eye, px, py);
            struct fragment fragment;
            if (!disc_hit(disc, &view->eye, &ray, px, py, &fragment))
                continue;
            assert_true(px >= disc->x_min && px <= disc->x_max);
            assert_true(py >= disc->y_min && py <= disc->y_max);
            assert_true(fragment.rho2 >= 0 && fragment.depth >= view->eye.near_depth);
            assert_true(tile_has(bins, px, py, id));
            hits++;
        }
    return hits;
}

/* Without disc_setup's verdict: it may drop a splat only if no ray meets it. */
static void try_dropped(const struct view *view, uint32_t id)
{
    struct view wide = *view;
    struct disc disc;
    wide.eye.near_depth = 1e-300;
    wide.eye.far_depth = INFINITY;
    if (view->eye.orthographic)
        wide.eye.near_depth = -1e300;
    if (!disc_setup(&wide, id, &disc) || disc.is_floored)
        return;
    for (uint32_t j = 0; j < view->height; j++)
        for (uint32_t i = 0; i < view->width; i++) {
            struct ray ray = eye_ray(&view->eye, i + 0.5, j + 0.5);
            struct fragment fragment;
            assert_false(disc_hit(&disc, &view->eye, &ray, i + 0.5, j + 0.5, &fragment));
        }
}

static void try_view(struct fixture *f, int index, double min_splat)
{
    struct stp_camera camera = hard_view(index, 75, 70);
    struct view view = view_of(f, &camera, min_splat);
    struct bins bins;
    size_t hits = 0;
    assert_int_equal(bins_build(NULL, &view, &bins), STP_OK);
    for (uint32_t id = 0; id < f->scene.splats.count; id++) {
        struct disc disc;
        if (disc_setup(&view, id, &disc))
            hits += try_rays(&view, &bins, &disc, id);
        else
            try_dropped(&view, id);
    }
    assert_true(hits > 1000);
    bins_release(&bins);
}

static void bounds_hold_in_every_view(void **state)
{
    struct fixture *f = fixture_create(0.1);
    fill_randomly(f, 4242, 250);
    add_splat(f, v3(0, 0, 0), v3(0, 1, 0), 50); /* across everything */
    add_splat(f, v3(0, 0, 0.3), v3(1, 0, 0), 0.5);
    for (int view = 0; view < VIEWS; view++) {
        try_view(f, view, 0);
        try_view(f, view, 5);
    }
    free(f);
}

static void lists_do_not_depend_on_threads(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = hard_view(2, 200, 130);
    struct view view = view_of(f, &camera, 2);
    struct bins one, many;
    fill_randomly(f, 5, 2000);
    assert_int_equal(bins_build(&(struct stp_env){ .threads = 1 }, &view, &one), STP_OK);
    assert_int_equal(bins_build(&(struct stp_env){ .threads = 5 }, &view, &many), STP_OK);
    size_t tiles = (size_t)one.across * one.down;
    assert_int_equal(tiles, 7 * 5);
    assert_memory_equal(one.first, many.first, (tiles + 1) * sizeof *one.first);
    assert_memory_equal(one.splat, many.splat, one.first[tiles] * sizeof *one.splat);
    for (size_t tile = 0; tile < tiles; tile++)
        for (size_t k = one.first[tile] + 1; k < one.first[tile + 1]; k++)
            assert_true(one.splat[k - 1] < one.splat[k]);
    bins_release(&one);
    bins_release(&many);
    free(f);
}

static void cells_at_their_borders(void **state)
{
    uint32_t a, b;
    assert_true(cells_touched(-5, 100, 1, 3, 9, &a, &b) && a == 3 && b == 8);
    assert_true(cells_touched(4, 4, 1, 3, 9, &a, &b) && a == 4 && b == 4);
    assert_true(cells_touched(31.999, 32, 32, 0, 4, &a, &b) && a == 0 && b == 1);
    assert_false(cells_touched(-5, -0.1, 1, 0, 9, &a, &b));
    assert_false(cells_touched(9, 20, 1, 3, 9, &a, &b));
    assert_true(cells_touched(NAN, NAN, 1, 3, 9, &a, &b) && a == 3 && b == 8); /* no bound */
    assert_true(cells_touched(-INFINITY, INFINITY, 32, 0, 4, &a, &b) && a == 0 && b == 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_hold_in_every_view),
        cmocka_unit_test(lists_do_not_depend_on_threads),
        cmocka_unit_test(cells_at_their_borders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
