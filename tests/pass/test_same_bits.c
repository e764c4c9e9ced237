/* The same picture, bit for bit, from shuffled points, any number of threads, repeated frames and
 * any tiles. */
#include "device.h"

#include <sys/wait.h>
#include <unistd.h>

#define WIDTH  77
#define HEIGHT 59
#define POINTS 900

static const struct {
    enum stp_method method;
    enum stp_path path;
    enum stp_payload payload;
    enum stp_voronoi voronoi;
    const char *name;
} ways[] = {
    { STP_METHOD_EXACT, STP_PATH_AUTO, STP_PAYLOAD_PACKED, STP_VORONOI_OFF, "exact packed" },
    { STP_METHOD_EXACT, STP_PATH_AUTO, STP_PAYLOAD_ID, STP_VORONOI_OFF, "exact ids" },
    { STP_METHOD_TWO_PASS, STP_PATH_COMPUTE, 0, 0, "two-pass compute" },
    { STP_METHOD_TWO_PASS, STP_PATH_RASTER, 0, 0, "two-pass raster" },
    { STP_METHOD_DEFERRED, STP_PATH_COMPUTE, STP_PAYLOAD_ID, STP_VORONOI_SLAB, "keys, slabs" },
    { STP_METHOD_DEFERRED, STP_PATH_COMPUTE, STP_PAYLOAD_PACKED, STP_VORONOI_OFF, "keys" },
    { STP_METHOD_DEFERRED, STP_PATH_COMPUTE, STP_PAYLOAD_ID, STP_VORONOI_EXACT, "keys, exact" },
    { STP_METHOD_DEFERRED, STP_PATH_RASTER, STP_PAYLOAD_ID, STP_VORONOI_SLAB, "layers, slabs" },
    { STP_METHOD_AXIS, STP_PATH_COMPUTE, 0, 0, "axis compute" },
    { STP_METHOD_AXIS, STP_PATH_RASTER, 0, 0, "axis raster" },
};
#define WAYS       (sizeof ways / sizeof *ways)
#define TILED_WAYS (WAYS - 2) /* for those of axis see test_axis_surface.c */

static struct stp_render_params way(unsigned i, unsigned aovs)
{
    return (struct stp_render_params){ .method = ways[i].method,
                                       .path = ways[i].path,
                                       .payload = ways[i].payload,
                                       .voronoi = ways[i].voronoi,
                                       .aovs = ways[i].method == STP_METHOD_AXIS
                                                   ? aovs & STP_AOV_POSITION
                                                   : aovs };
}

/* Points of a closed bumpy surface with a cluster that overflows the slots of `exact`; in the
 * order that `stride`, prime to their number, gives. */
static struct stp_scene *surface(const struct stp_env *env, unsigned stride, bool normals,
                                 bool colors)
{
    static double position[POINTS][3];
    static float color[POINTS][3], normal[POINTS][3];
    struct stp_scene *scene = NULL;
    for (unsigned i = 0; i < POINTS; i++) {
        unsigned at = i * stride % POINTS;
        uint32_t seed = 1 + i;
        double z = 1 - (2 * i + 1.0) / POINTS, ring = sqrt(1 - z * z), turn = i * 2.399963;
        double r = i % 10 ? 1 + 0.05 * sin(5 * turn) : 0.9 + 0.001 * uniform(&seed);
        struct vec3 p = i % 10 ? v3(ring * cos(turn), ring * sin(turn), z)
                               : v3(0.3 + 1e-3 * uniform(&seed), 0.4, 0.9);
        memcpy(position[at], (double[3]){ r * p.x, r * p.y, r * p.z }, sizeof *position);
        memcpy(normal[at], (float[3]){ (float)p.x, (float)p.y, (float)p.z }, sizeof *normal);
        for (int k = 0; k < 3; k++)
            color[at][k] = (float)uniform(&seed);
    }
    struct stp_points points = { .count = POINTS,
                                 .position = position,
                                 .normal = normals ? normal : NULL,
                                 .color = colors ? color : NULL };
    struct stp_group_params groups = { .overlap = 0.5 };
    struct stp_prepare_params prepare = { 0 };
    struct stp_object_params object = { 0 };
    assert_int_equal(stp_scene_create(env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(env, scene, &points, &object), STP_OK);
    assert_int_equal(stp_scene_prepare(env, scene, &prepare), STP_OK);
    assert_int_equal(stp_scene_group(env, scene, &groups), STP_OK);
    return scene;
}

static struct stp_camera framed(const struct stp_scene *scene)
{
    struct stp_camera camera;
    struct stp_frame_params params = {
        .azimuth = 0.4, .elevation = 0.3, .width = WIDTH, .height = HEIGHT
    };
    assert_int_equal(stp_camera_frame(NULL, scene, &params, &camera), STP_OK);
    return camera;
}

/* Coloured with given normals, so that ids matter; then plain with estimated ones. */
static void test_order_of_points(void **state)
{
    struct device device;
    device_open(&device, 0);
    for (int plain = 0; plain < 2; plain++) {
        struct stp_scene *a = surface(&device.env, 1, !plain, !plain);
        struct stp_scene *b = surface(&device.env, 7, !plain, !plain);
        struct stp_camera camera = framed(a);
        for (unsigned i = 0; i < WAYS; i++) {
            struct stp_render_params p = way(i, plain ? 0 : 127);
            struct stp_image *first = device_render(&device, a, &camera, &p);
            struct stp_image *again = device_render(&device, a, &camera, &p);
            struct stp_image *shuffled = device_render(&device, b, &camera, &p);
            expect_same_bits(again, first, ways[i].name);
            expect_same_bits(shuffled, first, ways[i].name);
            stp_image_destroy(&first);
            stp_image_destroy(&again);
            stp_image_destroy(&shuffled);
        }
        stp_scene_destroy(&a);
        stp_scene_destroy(&b);
    }
    device_close(&device);
}

static struct stp_image *render_under(struct device *device, const struct stp_scene *scene,
                                      const struct stp_camera *camera,
                                      const struct stp_render_params *params, uint32_t most)
{
    struct stp_limits limits = *stp_context_limits(device->context);
    struct stp_plan *plan = NULL;
    limits.max_image_size = most;
    assert_int_equal(stp_plan_create(&device->env, scene, camera, params, &limits, &plan), STP_OK);
    struct stp_image *image = device_render_plan(device, scene, plan);
    stp_plan_destroy(&plan);
    return image;
}

/* Across the picture's border, under viewports that are as large as the picture, twice and four
 * times. */
static void test_border(void **state)
{
    struct device device;
    device_open(&device, 0);
    struct stp_scene *scene = surface(&device.env, 1, true, true);
    struct stp_camera camera = framed(scene);
    camera.fx *= 2.5;
    camera.fy *= 2.5;
    for (unsigned i = 0; i < WAYS; i++) {
        struct stp_render_params p = way(i, 127);
        if (p.path != STP_PATH_RASTER)
            continue;
        struct stp_image *narrow = render_under(&device, scene, &camera, &p, WIDTH);
        for (uint32_t guard = 2; guard <= 8; guard *= 2) {
            struct stp_image *wide = render_under(&device, scene, &camera, &p, guard * WIDTH);
            expect_same_bits(wide, narrow, ways[i].name);
            stp_image_destroy(&wide);
        }
        stp_image_destroy(&narrow);
    }
    stp_scene_destroy(&scene);
    device_close(&device);
}

static void test_tiles(void **state)
{
    static const uint64_t limits[] = { 2 << 20, 300 << 10, 60 << 10 };
    struct device device;
    device_open(&device, 0);
    struct stp_scene *scene = surface(&device.env, 1, true, true);
    struct stp_camera camera = framed(scene);
    for (unsigned i = 0; i < TILED_WAYS; i++) {
        struct stp_render_params p = way(i, 127);
        struct stp_image *whole = device_render(&device, scene, &camera, &p);
        unsigned most = 0;
        for (unsigned l = 0; l < 3; l++) {
            struct stp_plan *plan = NULL;
            p.memory_limit = limits[l];
            enum stp_result result = device_plan(&device, scene, &camera, &p, &plan);
            if (result == STP_ERROR_DEVICE_MEMORY)
                continue; /* 64 pixels of some ways take more than the least of the limits */
            assert_int_equal(result, STP_OK);
            struct stp_image *tiled = device_render_plan(&device, scene, plan);
            most = plan->tile_count > most ? plan->tile_count : most;
            expect_same_bits(tiled, whole, ways[i].name);
            stp_image_destroy(&tiled);
            stp_plan_destroy(&plan);
        }
        assert_true(most > 4);
        stp_image_destroy(&whole);
    }
    stp_scene_destroy(&scene);
    device_close(&device);
}

/* Eye dome reads neighbours: tiles have margins, of two pixels where the picture is tall. */
static void test_tiles_of_eye_dome(void **state)
{
    static const float background[] = { 0.2f, 0.4f, 0.6f, 1 };
    struct device device;
    device_open(&device, 0);
    struct stp_scene *scene = surface(&device.env, 1, true, true);
    scene->facts.eye_dome = true;
    for (int tall = 0; tall < 2; tall++)
        for (int flat = 0; flat < 2; flat++) {
            struct stp_camera camera = framed(scene);
            struct stp_render_params p = { .background = background };
            camera.orthographic = flat;
            camera.fx = flat ? 25 : camera.fx;
            camera.fy = flat ? 25 : camera.fy;
            camera.height = tall ? 1100 : camera.height;
            struct stp_image *whole = device_render(&device, scene, &camera, &p);
            p.memory_limit = tall ? 3 << 20 : 300 << 10;
            struct stp_plan *plan = NULL;
            assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
            assert_true(plan->tile_count > 3);
            struct stp_image *tiled = device_render_plan(&device, scene, plan);
            expect_same_bits(tiled, whole, "eye dome");
            stp_image_destroy(&whole);
            stp_image_destroy(&tiled);
            stp_plan_destroy(&plan);
        }
    stp_scene_destroy(&scene);
    device_close(&device);
}

static uint64_t fold(uint64_t hash, const struct stp_image *image)
{
    for (unsigned c = 0; c < image->channel_count; c++)
        for (size_t i = 0; i < (size_t)image->width * image->height; i++)
            hash = (hash ^ image->channels[c].data.u[i]) * 0x100000001b3u;
    return hash;
}

/* One number of every way's picture, made from the points up by so many threads. */
static uint64_t pictures(unsigned threads)
{
    struct device device;
    uint64_t hash = 0xcbf29ce484222325u;
    device_open(&device, 0);
    device.env.threads = threads;
    struct stp_scene *scene = surface(&device.env, 1, true, true);
    struct stp_camera camera = framed(scene);
    for (unsigned i = 0; i < WAYS; i++) {
        struct stp_render_params p = way(i, 127);
        struct stp_image *image = device_render(&device, scene, &camera, &p);
        hash = fold(hash, image);
        stp_image_destroy(&image);
    }
    stp_scene_destroy(&scene);
    device_close(&device);
    return hash;
}

/* The driver reads its number of threads when it is loaded: a process each. */
static uint64_t pictures_of_child(const char *driver_threads, unsigned threads)
{
    int ends[2];
    uint64_t hash = 0;
    assert_int_equal(pipe(ends), 0);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (driver_threads)
            setenv("LP_NUM_THREADS", driver_threads, 1);
        hash = pictures(threads);
        _exit(write(ends[1], &hash, sizeof hash) != sizeof hash);
    }
    int status = 1;
    close(ends[1]);
    assert_int_equal(read(ends[0], &hash, sizeof hash), sizeof hash);
    close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    return hash;
}

static void test_threads(void **state)
{
    uint64_t one = pictures_of_child("1", 1), all = pictures_of_child(NULL, 2);
    assert_true(pictures_of_child("4", 4) == one);
    assert_true(all == one);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_threads), /* before this process loads a driver */
        cmocka_unit_test(test_order_of_points), cmocka_unit_test(test_border),
        cmocka_unit_test(test_tiles),           cmocka_unit_test(test_tiles_of_eye_dome),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
