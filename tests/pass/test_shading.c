/* Colours, materials, lights, unknown normals, eye dome and backgrounds against the reference. */
#include "group_device.h"

#include "base/memory.h"

static struct stp_scene *sheet(unsigned objects)
{
    return scene_sheet(objects, 9);
}

enum { FLAT = 1, GROUPS = 2 };

static void render_sheet(struct stp_scene *scene, const struct stp_render_params *params, int more,
                         const char *what)
{
    scene_finish(scene);
    if (more & GROUPS)
        scene_own_groups(scene);
    for (int flat = 0; flat <= (more & FLAT); flat++) {
        struct stp_camera camera = flat ? flat_camera(33, 33, 15) : plain_camera(33, 33, 30);
        expect_everywhere(&device, scene, &camera, params, what);
    }
    stp_scene_destroy(&scene);
}

static void test_plain(void **state)
{
    struct stp_render_params p = { .kernel = STP_KERNEL_GAUSS };
    render_sheet(sheet(1), &p, FLAT, "no colours");
}

/* The largest half, its fraction, and black, side by side. */
static void test_hdr_colors(void **state)
{
    struct stp_render_params p = { .min_splat = -1 };
    struct stp_scene *scene = sheet(1);
    for (size_t i = 0; i < SCENE_SHEET_SPLATS; i++) {
        float c = i % 3 == 0 ? 65504 : i % 3 == 1 ? 1e-4f : 0;
        scene_paint(scene, i, c, 65504 - c, c / 2);
    }
    render_sheet(scene, &p, 0, "colours up to 65504");
}

static void test_objects(void **state)
{
    struct stp_render_params p = { .min_splat = -1, .local_viewer = true };
    struct stp_scene *scene = sheet(3);
    scene->objects[0].epsilon = 0.02;
    scene->objects[2].epsilon = 0.5;
    scene->objects[1].material = (struct stp_material){ .ambient = .3f,
                                                        .diffuse = .2f,
                                                        .specular = .9f,
                                                        .shininess = 7.5f,
                                                        .albedo = { .1f, .9f, .4f } };
    scene->objects[2].material =
        (struct stp_material){ .diffuse = 1, .shininess = 1, .albedo = { 1, 0, 0 } };
    for (size_t i = 0; i < SCENE_SHEET_SPLATS; i++) { /* as prepare does where albedos differ */
        const float *c = scene->objects[i % 3].material.albedo;
        scene_paint(scene, i, c[0], c[1], c[2]);
    }
    render_sheet(scene, &p, GROUPS, "three objects");
}

/* One sheet hides another of its object, in one group, beside an object of a huge epsilon: slabs
 * and quantised depths have to tell the sheets apart. */
static void test_unlike_epsilons(void **state)
{
    const struct stp_render_params all[] = {
        { .method = STP_METHOD_EXACT },
        { .method = STP_METHOD_EXACT, .payload = STP_PAYLOAD_ID },
        { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE },
        { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER },
        { .method = STP_METHOD_DEFERRED, .voronoi = STP_VORONOI_SLAB },
        { .method = STP_METHOD_DEFERRED, .voronoi = STP_VORONOI_EXACT },
        { .method = STP_METHOD_DEFERRED, .path = STP_PATH_RASTER },
    };
    struct stp_camera camera = plain_camera(44, 40, 40);
    struct stp_scene *scene = scene_make(3, 2, 0.01);
    scene->objects[0].epsilon = 1e4;
    scene_add(scene, v3(-0.1, 0.3, -2.5), v3(0, 0.1, 1), 0.4);
    for (int i = 0; i < 2; i++)
        scene_assign(scene,
                     scene_add(scene, v3(-0.2 * i, 0, -2 - 0.1 * i), v3(0.1, 0.05 * i, 1), 0.4), 1);
    scene_finish(scene);
    scene->splats.group = mem_zalloc(3, 1);
    scene->facts.grouping = (struct stp_grouping){ .groups = 1, .overlap = 1 };
    for (unsigned i = 0; i < sizeof all / sizeof *all; i++)
        expect_reference(&device, scene, &camera, &all[i], &packed_tolerance, "unlike epsilons");
    stp_scene_destroy(&scene);
}

static void test_lights(void **state)
{
    for (int local = 0; local < 2; local++) {
        struct stp_render_params p = { .min_splat = -1, .local_viewer = local };
        struct stp_scene *scene = sheet(1);
        const struct stp_light lights[] = {
            { .direction = { 3, 2, 1 }, .color = { 1, 0.5f, 0 } },
            { .positional = true, .position = { 0.2, 0.5, -1 }, .color = { 0, 0.5f, 2 } },
            { .positional = true, .position = { 3, 0, -4 }, .color = { 1, 1, 1 } },
            { .at_eye = true, .color = { 0.25f, 0.25f, 0.25f } },
        };
        assert_int_equal(stp_scene_set_lights(NULL, scene, lights, 4), STP_OK);
        render_sheet(scene, &p, FLAT, "four lights");
    }
}

/* Discs without a normal face the eye. */
static void test_unknown_normals(void **state)
{
    struct stp_render_params p = { .min_splat = -1 };
    struct stp_scene *scene = sheet(1);
    for (size_t i = 0; i < SCENE_SHEET_SPLATS; i += 2)
        memset(scene->splats.normal[i], 0, sizeof scene->splats.normal[i]);
    scene->facts.two_sided = true;
    render_sheet(scene, &p, FLAT, "half the normals unknown");
}

/* Shaded by depth; at 1040 rows the neighbours are two pixels away. */
static void test_eye_dome(void **state)
{
    static const uint32_t heights[] = { 30, 1040 };
    static const float background[] = { 0.5f, 0.25f, 1, 0.5f };
    for (int i = 0; i < 4; i++) {
        struct stp_render_params p = { .min_splat = 1.5, .background = i % 2 ? background : NULL };
        struct stp_scene *scene = sheet(1);
        uint32_t height = heights[i / 2];
        struct stp_camera camera =
            i == 1 ? flat_camera(30, height, height / 2.2) : plain_camera(30, height, height);
        for (size_t at = 0; at < SCENE_SHEET_SPLATS; at++) {
            memset(scene->splats.normal[at], 0, sizeof scene->splats.normal[at]);
            scene_paint(scene, at, 0.2f, at / 10.f, 0.7f);
        }
        scene->facts.eye_dome = scene->facts.two_sided = true;
        scene_finish(scene);
        expect_everywhere(&device, scene, &camera, &p, "eye dome");
        stp_scene_destroy(&scene);
    }
}

static void test_background(void **state)
{
    static const float background[] = { 0.5f, 2, 0.125f, 0.75f };
    struct stp_render_params p = { .min_splat = -1, .background = background };
    struct stp_scene *scene = scene_make(2, 1, 0.1);
    scene_add(scene, v3(0.2, 0.1, -2), v3(0.2, 0, 1), 0.1);
    scene_add(scene, v3(-0.5, 0.3, -2), v3(0.2, 0, 1), 0.2);
    render_sheet(scene, &p, GROUPS, "background");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plain),           cmocka_unit_test(test_hdr_colors),
        cmocka_unit_test(test_objects),         cmocka_unit_test(test_lights),
        cmocka_unit_test(test_unknown_normals), cmocka_unit_test(test_eye_dome),
        cmocka_unit_test(test_background),      cmocka_unit_test(test_unlike_epsilons),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
