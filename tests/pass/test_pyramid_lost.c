/* Discs of points that lost their pixels: they cover what no other disc covers, with their own
 * attributes, wherever they reach; the same bits in tiles, chunks and without 64-bit atomics. */
#include "winners.h"
#include "group_device.h"

static struct vec3 random_vector(uint32_t *seed)
{
    return v3(2 * uniform(seed) - 1, 2 * uniform(seed) - 1, 2 * uniform(seed) - 1);
}

/* Tufts of discs of very different radii at any angle: most points share their pixels. */
static struct stp_scene *foliage(uint32_t seed, int count, unsigned objects)
{
    struct stp_scene *scene = scene_make((size_t)count, objects, 0.02);
    for (int i = 0; i < count; i++) {
        uint32_t tuft = 1 + (uint32_t)i % 80;
        struct vec3 at = random_vector(&tuft), off = v3_scale(random_vector(&seed), 0.02);
        at = v3_add(v3(at.x, 0.8 * at.y, -3 + 0.5 * at.z), off);
        double radius = 0.003 * pow(30, uniform(&seed));
        size_t id = scene_add(scene, at, random_vector(&seed), radius);
        scene_paint(scene, id, (float)uniform(&seed), (float)uniform(&seed), 0.5f);
        if (objects > 1)
            scene_assign(scene, id, (unsigned)i % objects);
    }
    scene_finish(scene);
    return scene;
}

/* Pixels that a disc covers and that are empty; and those that no disc covers which won a pixel. */
struct holes {
    size_t covered, holes, lost;
};

static struct holes count_holes(const struct stp_scene *scene, const struct stp_camera *camera,
                                const struct stp_render_params *p, const struct stp_image *image)
{
    struct winners won = winners_find(scene, camera, p), all = winners_of_all(scene, camera, p);
    struct holes h = { 0 };
    for (uint32_t y = 0; y < camera->height; y++)
        for (uint32_t x = 0; x < camera->width; x++) {
            size_t i = (size_t)y * camera->width + x;
            bool covered = isfinite(all.depth[i]);
            h.covered += covered;
            h.holes += covered && !isfinite(value(image, "Z", x, y));
            h.lost += covered && !isfinite(won.depth[i]);
        }
    winners_release(&won);
    winners_release(&all);
    return h;
}

static void no_holes(void **state)
{
    for (unsigned i = 0; i < 8; i++) {
        struct stp_camera camera =
            i & 1 ? flat_camera(200, 150, 60) : plain_camera(200, 150, 100 + 50 * i);
        struct stp_scene *scene = foliage(i + 1, 4000, 1);
        struct stp_render_params p = { .method = STP_METHOD_PYRAMID,
                                       .min_splat = -1,
                                       .cull = i & 2 ? STP_CULL_BACK : STP_CULL_NONE,
                                       .mask_features = i & 4 ? STP_FEATURE_INT64_ATOMICS : 0 };
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        struct holes h = count_holes(scene, &camera, &p, image);
        if (getenv("STP_TEST_VERDICTS"))
            print_message("%u: %zu covered, %zu by lost discs alone, %zu holes\n", i, h.covered,
                          h.lost, h.holes);
        assert_true(h.lost > 20);
        assert_int_equal(h.holes, 0);
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

static struct stp_image *render_in(const struct stp_scene *scene, const struct stp_camera *camera,
                                   const struct stp_render_params *p, uint64_t heap)
{
    struct stp_limits limits = *stp_context_limits(device.context);
    struct stp_plan *plan = NULL;
    limits.heap_bytes = heap ? heap : limits.heap_bytes;
    assert_int_equal(stp_plan_create(&device.env, scene, camera, p, &limits, &plan), STP_OK);
    assert_true(plan->rim_far);
    assert_int_equal(plan->chunk_count > 1, heap != 0);
    assert_true(plan->tile_count > 1 || !p->memory_limit);
    struct stp_image *image = device_render_plan(&device, scene, plan);
    stp_plan_destroy(&plan);
    return image;
}

#define SMALL_HEAP (3 << 20) /* three chunks of points, of 42 bytes; tiles */

static void same_bits(void **state)
{
    static const struct {
        const char *what;
        uint64_t heap, tile;
        unsigned samples, mask;
    } cases[] = { { "chunks", SMALL_HEAP, 0, 1, 0 },
                  { "chunks, 32 bits", SMALL_HEAP, 0, 1, STP_FEATURE_INT64_ATOMICS },
                  { "chunks, 4 samples", SMALL_HEAP, 0, 4, 0 },
                  { "tiles", 0, 1500000, 1, 0 },
                  { "tiles, 4 samples", 0, 1500000, 4, 0 },
                  { "32 bits", 0, 0, 1, STP_FEATURE_INT64_ATOMICS },
                  { "32 bits, 4 samples", 0, 0, 4, STP_FEATURE_INT64_ATOMICS } };
    struct stp_camera camera = plain_camera(200, 150, 160);
    struct stp_scene *scene = foliage(9, 40000, 3);
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct stp_render_params p = {
            .method = STP_METHOD_PYRAMID, .min_splat = -1, .aovs = 127, .samples = cases[i].samples
        };
        struct stp_image *whole = render_in(scene, &camera, &p, 0);
        p.memory_limit = cases[i].tile;
        p.mask_features = cases[i].mask;
        struct stp_image *image = render_in(scene, &camera, &p, cases[i].heap);
        expect_same_bits(image, whole, cases[i].what);
        stp_image_destroy(&image);
        stp_image_destroy(&whole);
    }
    stp_scene_destroy(&scene);
}

/* A large disc whose only pixel goes to a tiny one before it: nothing else reaches the blocks that
 * it covers, or tells that any disc reaches far. */
static void alone(void **state)
{
    struct vec3 n = v3_unit(v3(0.3, 0.2, 1));
    struct stp_scene *scene = scene_make(2, 2, 0.1);
    size_t tiny = scene_add(scene, v3(0.001, 0.001, -1.9), v3(0, 0, 1), 1e-4);
    size_t large = scene_add(scene, v3(0.001, 0.001, -2), n, 0.6);
    scene_paint(scene, tiny, 0, 1, 0);
    scene_paint(scene, large, 1, 0, 0.25f);
    scene_assign(scene, large, 1);
    scene_finish(scene);
    for (unsigned samples = 1; samples <= 4; samples *= 4) {
        struct stp_camera camera = plain_camera(160, 120, 150);
        struct stp_render_params p = { .method = STP_METHOD_PYRAMID,
                                       .min_splat = -1,
                                       .aovs = STP_AOV_ID | STP_AOV_ALBEDO,
                                       .samples = samples };
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        struct winners all = winners_of_all(scene, &camera, &p);
        size_t covered = 0;
        for (uint32_t y = 0; y < 120; y++)
            for (uint32_t x = 0; x < 160; x++) {
                double z = all.depth[y * 160 + x], away = hypot(x - 80.0, y - 60.0);
                if (!isfinite(z) || away < 3 || value(image, "A", x, y) < 1)
                    continue;
                covered++;
                assert_float_equal(value(image, "Z", x, y), z, 2e-3 * samples);
                assert_float_equal(value(image, "N.X", x, y), n.x, 1e-3);
                assert_float_equal(value(image, "albedo.R", x, y), 1, 1e-3);
                assert_float_equal(value(image, "albedo.B", x, y), 0.25, 1e-3);
                assert_int_equal(stp_image_find(image, "id")->data.u[y * 160 + x], 1000 + large);
            }
        assert_true(covered > 5000); /* of an ellipse of 45 by 42 pixels */
        winners_release(&all);
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(no_holes), cmocka_unit_test(same_bits),
                                        cmocka_unit_test(alone) };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
