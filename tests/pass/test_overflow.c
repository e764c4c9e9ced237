/* More fragments a pixel than `exact` has slots for: the repair passes, against the reference. */
#include "group_device.h"

static void expect_exact(const struct stp_scene *scene, const struct stp_camera *camera,
                         const char *what)
{
    struct stp_render_params p = { .method = STP_METHOD_EXACT, .min_splat = -1 };
    expect_reference(&device, scene, camera, &p, &packed_tolerance, what);
    p.payload = STP_PAYLOAD_ID;
    expect_reference(&device, scene, camera, &p, &exact_tolerance, what);
}

/* A pile of `count` discs, and lone ones beside it that do not overflow. */
static struct stp_scene *pile(size_t count, double spread, bool painted, double radius)
{
    uint32_t seed = 77;
    struct stp_scene *scene = scene_make(count + 2, 1, 0.1);
    for (size_t i = 0; i < count; i++) {
        struct vec3 tilt = v3_scale(random_point(&seed, 1), spread > 0 ? 0.3 : 0);
        size_t at = scene_add(scene, v3(0.2, 0.1, -2 - spread * uniform(&seed)),
                              v3_add(v3(0, 0, 1), tilt), radius);
        if (painted)
            scene_paint(scene, at, (float)uniform(&seed), (float)uniform(&seed), 0.25f);
    }
    scene_add(scene, v3(-0.5, -0.4, -2), v3(0.2, 0, 1), 0.2);
    scene_add(scene, v3(-0.4, -0.4, -2.05), v3(0, 0.2, 1), 0.2);
    scene_finish(scene);
    return scene;
}

static void test_piles(void **state)
{
    static const size_t counts[] = { STP_SLOTS - 1, STP_SLOTS, STP_SLOTS + 1, 300, 10000 };
    static const double spreads[] = { 0, 0.05, 1 }; /* of an epsilon of 0.1 */
    for (unsigned c = 0; c < sizeof counts / sizeof *counts; c++)
        for (unsigned s = 0; s < (counts[c] > 1000 ? 2 : 3); s++) {
            char what[64];
            struct stp_camera camera = plain_camera(24, 20, 24);
            struct stp_scene *scene = pile(counts[c], spreads[s], c % 2, 0.2);
            snprintf(what, sizeof what, "%zu discs within %g", counts[c], spreads[s]);
            expect_exact(scene, &camera, what);
            stp_scene_destroy(&scene);
        }
}

/* Large splats are repaired by their own passes. */
static void test_large_piles(void **state)
{
    for (int painted = 0; painted < 2; painted++) {
        struct stp_camera camera = plain_camera(45, 41, 40);
        struct stp_scene *scene = pile(STP_SLOTS + 20, 0.3, painted, 3);
        expect_exact(scene, &camera, "large discs");
        stp_scene_destroy(&scene);
    }
}

/* Overflow in some pixels of many, in all views: most of the cloud is in the way of something. */
static void test_crowded_cloud(void **state)
{
    struct stp_scene *scene = scene_random(21, 1500, 0.1);
    for (int view = 0; view < VIEWS; view++) {
        struct stp_camera camera = hard_view(view, 40, 31);
        expect_exact(scene, &camera, "crowded cloud");
    }
    stp_scene_destroy(&scene);
}

/* Slots, counts and repair of one frame leave nothing to the next. */
static void test_again(void **state)
{
    struct stp_camera camera = plain_camera(24, 20, 24);
    struct stp_scene *full = pile(100, 0.05, true, 0.2), *sparse = pile(3, 0.05, true, 0.2);
    struct stp_render_params p = { .method = STP_METHOD_EXACT };
    struct stp_image *first = device_render(&device, sparse, &camera, &p);
    struct stp_image *between = device_render(&device, full, &camera, &p);
    struct stp_image *last = device_render(&device, sparse, &camera, &p);
    expect_same_bits(last, first, "after an overflow");
    stp_image_destroy(&first);
    stp_image_destroy(&between);
    stp_image_destroy(&last);
    stp_scene_destroy(&full);
    stp_scene_destroy(&sparse);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_piles),
        cmocka_unit_test(test_large_piles),
        cmocka_unit_test(test_crowded_cloud),
        cmocka_unit_test(test_again),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
