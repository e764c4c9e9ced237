/* Devices that lack something. */
#include "hard.h"

#include <unistd.h>

static struct stp_scene *small_ball(const struct hard_options *o)
{
    struct hard_options few = *o;
    few.points = 400;
    struct hard_points cloud = points_ball(&few, v3(0, 0, 0), 0.15);
    struct stp_scene *scene = points_scene(&cloud, 0, 2);
    hard_group(scene);
    points_release(&cloud);
    return scene;
}

static const struct tolerance *bound(const struct stp_plan *plan)
{
    return plan->payload == STP_PAYLOAD_PACKED ? &packed_tolerance
           : plan->method == STP_METHOD_EXACT  ? &exact_tolerance
                                               : &float_tolerance;
}

/* Renders by a way, or finds it refused by the missing feature's name. Returns whether it rendered.
 */
static bool try_way(struct device *device, const struct stp_scene *scene,
                    const struct stp_camera *camera, const struct hard_way *way, unsigned masked,
                    const char *missing)
{
    struct stp_render_params p = { .min_splat = -1, .mask_features = masked };
    struct stp_plan *plan = NULL;
    p = hard_way_params(way, &p);
    enum stp_result result = device_plan(device, scene, camera, &p, &plan);
    if (result != STP_OK) {
        assert_int_equal(result, STP_ERROR_FEATURE);
        if (!strstr(device->last, missing))
            fail_msg("%s is refused by \"%s\", which does not name %s", way->name, device->last,
                     missing);
        return false;
    }
    struct stp_image *image = device_render_plan(device, scene, plan);
    struct verdict v = judge(scene, plan, image, bound(plan));
    bool grouped = plan->method == STP_METHOD_DEFERRED;
    if (grouped ? v.psnr < 45 : v.off > 0 || v.noisy)
        fail_msg("%s without %s: %zu off, %.1f dB", way->name, missing, v.off, v.psnr);
    stp_image_destroy(&image);
    stp_plan_destroy(&plan);
    return true;
}

/* A device opened without the feature: validation speaks if a shader still uses it. */
static void without(const struct hard_options *o, unsigned feature, const char *missing,
                    unsigned least)
{
    struct device device;
    struct stp_scene *scene = small_ball(o);
    struct stp_camera camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    unsigned rendered = 0;
    device_open(&device, feature);
    for (unsigned w = 0; w < HARD_WAYS; w++)
        if (hard_ways[w].method != STP_METHOD_REFERENCE)
            rendered += try_way(&device, scene, &camera, &hard_ways[w], feature, missing);
    if (rendered < least)
        fail_msg("only %u ways without %s", rendered, missing);
    /* And what a user gets who names no method. */
    struct hard_way by_default = { .name = "auto" };
    assert_true(try_way(&device, scene, &camera, &by_default, feature, missing));
    device_close(&device);
    stp_scene_destroy(&scene);
}

static void without_atomics(const struct hard_options *o, struct device *device)
{
    without(o, STP_FEATURE_INT64_ATOMICS, "shaderBufferInt64Atomics", 5);
}

static void without_layer(const struct hard_options *o, struct device *device)
{
    without(o, STP_FEATURE_VERTEX_LAYER, "shaderOutputLayer", 6);
}

static void without_formats(const struct hard_options *o, struct device *device)
{
    without(o, STP_FEATURE_STORAGE_FORMATS, "shaderStorageImageExtendedFormats", 4);
}

static void no_device(const struct hard_options *o, struct device *device)
{
    struct stp_context_params params = { .device = "no such device" };
    struct stp_context *context = NULL;
    unsigned lines = device->lines;
    assert_int_equal(stp_context_create(&device->env, &params, &context), STP_ERROR_NO_DEVICE);
    assert_null(context);
    assert_int_equal(device->lines, lines + 1);
}

static void below_one_tile(const struct hard_options *o, struct device *device)
{
    struct stp_scene *scene = small_ball(o);
    struct stp_camera camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    for (unsigned w = 0; w < HARD_WAYS; w++) {
        struct stp_plan *plan = NULL;
        struct stp_render_params p = { .memory_limit = 1000 };
        unsigned lines = device->lines;
        p = hard_way_params(&hard_ways[w], &p);
        if (p.method == STP_METHOD_REFERENCE)
            continue;
        assert_int_equal(device_plan(device, scene, &camera, &p, &plan), STP_ERROR_DEVICE_MEMORY);
        assert_null(plan);
        assert_int_equal(device->lines, lines + 1);
    }
    stp_scene_destroy(&scene);
}

/* Half of what the splats take: whoever names no method gets the reference's picture, whoever names
 * one learns what is missing. */
static void scene_too_large(const struct hard_options *o, struct device *device)
{
    struct stp_scene *scene = small_ball(o);
    struct stp_camera camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    struct stp_limits small = *stp_context_limits(device->context);
    struct stp_render_params p = { .min_splat = -1 };
    struct stp_plan *plan = NULL;
    struct stp_image *image = NULL, *truth = hard_reference(scene, &camera, &p);
    small.heap_bytes = scene->splats.count * 16;
    assert_int_equal(stp_plan_create(&device->env, scene, &camera, &p, &small, &plan), STP_OK);
    assert_non_null(strstr(plan->why, "more than the device"));
    assert_int_equal(stp_render(&device->env, device->context, scene, plan, 0, &image, NULL),
                     STP_OK);
    expect_same_bits(image, truth, "a scene that the device cannot hold");
    stp_image_destroy(&image);
    stp_image_destroy(&truth);
    stp_plan_destroy(&plan);
    unsigned lines = device->lines;
    p.method = STP_METHOD_EXACT;
    assert_int_equal(stp_plan_create(&device->env, scene, &camera, &p, &small, &plan),
                     STP_ERROR_DEVICE_MEMORY);
    assert_int_equal(device->lines, lines + 1);
    assert_non_null(strstr(device->last, "the scene takes"));
    stp_scene_destroy(&scene);
}

static void damaged_file(const struct hard_options *o, struct device *device)
{
    static const char text[] = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n"
                               "property float x\nproperty float y\nproperty float z\n"
                               "end_header\n0123456789";
    char path[] = "/tmp/stipple-damaged-XXXXXX";
    struct stp_scene *scene = NULL;
    int file = mkstemp(path);
    unsigned lines = device->lines;
    assert_true(file >= 0);
    assert_int_equal(write(file, text, sizeof text - 1), sizeof text - 1);
    close(file);
    assert_int_equal(stp_scene_load(&device->env, path, NULL, &scene), STP_ERROR_FORMAT);
    unlink(path);
    assert_null(scene);
    assert_int_equal(device->lines, lines + 1);
    assert_non_null(strstr(device->last, path));
}

static const struct hard_case cases[] = {
    { "No 64-bit atomics",
      "Five ways of six are as good as with them, `auto` among them; deferred by compute is "
      "refused "
      "by the feature's name",
      NULL, NULL, 0, 0, 0, 0, without_atomics, HARD_PYRAMID_POINTS },
    { "No gl_Layer from the vertex shader", "Every way is as good: a pass a layer", NULL, NULL, 0,
      0, 0, 0, without_layer, HARD_PYRAMID_POINTS },
    { "No storage-image formats",
      "The four compute ways are as good, `auto` among them; the two raster ones are refused by "
      "the "
      "feature's name",
      NULL, NULL, 0, 0, 0, 0, without_formats, HARD_PYRAMID_POINTS },
    { "Device memory smaller than the scene",
      "`auto` gives the reference's bits, from the CPU; a method asked for by name is refused with "
      "the bytes that are missing",
      NULL, NULL, 0, 0, 0, 0, scene_too_large, HARD_PYRAMID_POINTS },
    { "No device", "STP_ERROR_NO_DEVICE and one line", NULL, NULL, 0, 0, 0, 0, no_device,
      HARD_PYRAMID_POINTS },
    { "Memory below one tile", "STP_ERROR_DEVICE_MEMORY and one line, before anything is allocated",
      NULL, NULL, 0, 0, 0, 0, below_one_tile, HARD_PYRAMID_POINTS },
    { "A damaged file", "STP_ERROR_FORMAT and one line that names the file", NULL, NULL, 0, 0, 0, 0,
      damaged_file, HARD_PYRAMID_POINTS },
};
const struct hard_family hard_devices = { "devices", cases, sizeof cases / sizeof *cases };
