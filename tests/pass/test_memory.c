/* A hundred renders in one process leave nothing behind: neither device memory nor the host's. */
#include "device.h"

#include "fault/ways.h"
#include "gpu/gpu.h"

#include <unistd.h>

static size_t resident(void)
{
    unsigned long all = 0, pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%lu %lu", &all, &pages), 2);
    fclose(file);
    return pages * (size_t)sysconf(_SC_PAGESIZE);
}

static void render_each(struct device *device, const struct stp_scene *scene, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        struct stp_camera camera = hard_view(0, 256, 256);
        struct stp_image *image = device_render(device, scene, &camera, &ways[i % WAYS].params);
        stp_image_destroy(&image);
        assert_int_equal(device->context->allocated, 0);
    }
}

/* A leak of one picture, or of a plan's transients, a frame would be 50 MB or more. */
static void test_a_hundred_renders(void **state)
{
    struct device device = { 0 };
    struct stp_context_params params = { 0 }; /* validation keeps records of its own */
    struct stp_scene *scene = scene_random(61, 6, 0.1);
    assert_int_equal(stp_context_create(NULL, &params, &device.context), STP_OK);
    scene_own_groups(scene);
    render_each(&device, scene, 2 * WAYS);
    size_t before = resident();
    render_each(&device, scene, 100);
    size_t after = resident();
    if (after > before + (24 << 20))
        fail_msg("%zu MiB before, %zu MiB after", before >> 20, after >> 20);
    stp_scene_destroy(&scene);
    stp_context_destroy(&device.context);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_a_hundred_renders) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
