/* Points that are culled by clusters before they are projected: the same bits as without, since
 * only clusters go of which every point would. */
#include "group_device.h"

#define CLUSTERS 60

static struct vec3 random_direction(uint32_t *seed)
{
    struct vec3 d = v3(uniform(seed) - 0.5, uniform(seed) - 0.5, uniform(seed) - 0.5 + 1e-9);
    return v3_unit(d);
}

/* Patches about the unit sphere, at any distance: flat, bent, spread over a half space or more, of
 * one place, some with a point that has no normal. The last patch is not whole. */
static struct stp_scene *patches(uint32_t seed, struct vec3 middle)
{
    struct stp_scene *scene = scene_make(CLUSTERS * STP_CLUSTER, 1, 0.05);
    for (size_t c = 0; c < CLUSTERS; c++) {
        struct vec3 normal = random_direction(&seed), at = v3_scale(normal, 0.8 + uniform(&seed));
        double size = c % 7 == 0 ? 0 : 0.3 * uniform(&seed),
               bend = pow(10, 1.5 - 5 * uniform(&seed));
        size_t count = c + 1 < CLUSTERS ? STP_CLUSTER : 17;
        for (size_t i = 0; i < count; i++) {
            struct vec3 p = v3_add(at, v3_scale(random_direction(&seed), size * uniform(&seed)));
            struct vec3 n = v3_add(normal, v3_scale(random_direction(&seed), bend));
            bool unknown = c % 11 == 3 && i == 5;
            scene_add(scene, v3_add(middle, p), unknown ? v3(0, 0, 0) : n, 0.03);
        }
    }
    scene_finish(scene);
    return scene;
}

/* From outside, from among the patches, close to some: much of the scene is beyond every edge. */
static struct stp_camera random_view(uint32_t *seed, struct vec3 middle, bool flat)
{
    double focal = 40 + 400 * uniform(seed);
    struct stp_camera camera = flat ? flat_camera(96, 72, focal) : plain_camera(96, 72, focal);
    struct vec3 eye = v3_scale(random_direction(seed), 0.4 + 3 * uniform(seed));
    struct vec3 target = v3_scale(random_direction(seed), uniform(seed));
    look_at(&camera, v3_add(middle, eye), v3_add(middle, target));
    camera.near_depth = 0.01 + uniform(seed);
    camera.far_depth = camera.near_depth + 0.2 + 4 * uniform(seed);
    return camera;
}

static void expect_as_without(const struct stp_scene *scene, const struct stp_camera *camera,
                              const struct stp_render_params *params)
{
    struct stp_image *image[2];
    struct stp_plan *plan = NULL;
    for (int culled = 0; culled < 2; culled++) {
        assert_int_equal(device_plan(&device, scene, camera, params, &plan), STP_OK);
        assert_int_equal(plan->constant[PLAN_CULL_CLUSTERS], 1);
        plan->constant[PLAN_CULL_CLUSTERS] = culled;
        image[culled] = device_render_plan(&device, scene, plan);
        stp_plan_destroy(&plan);
    }
    expect_same_bits(image[1], image[0], "clusters");
    stp_image_destroy(&image[0]);
    stp_image_destroy(&image[1]);
}

static void same_bits(void **state)
{
    static const struct vec3 middles[] = { { 0, 0, 0 }, { 4e5, -6e6, 120 } };
    uint32_t seed = 17;
    for (unsigned i = 0; i < 16; i++) {
        struct vec3 middle = middles[i % 2];
        struct stp_scene *scene = patches(i + 1, middle);
        struct stp_camera camera = random_view(&seed, middle, i % 4 > 1);
        struct stp_render_params p = { .method = STP_METHOD_PYRAMID,
                                       .cull = i % 8 == 7 ? STP_CULL_NONE : STP_CULL_BACK,
                                       .aovs = 127,
                                       .samples = i % 5 == 4 ? 4 : 1 };
        if (i % 6 == 5)
            p.mask_features = STP_FEATURE_FLOAT64 | STP_FEATURE_INT64_ATOMICS;
        expect_as_without(scene, &camera, &p);
        stp_scene_destroy(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(same_bits) };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
