/* Volumes by the reference against march.h: every pixel's alpha, its own order, and the medium that
 * the Gaussians stand for. */
#include "march.h"

enum { W = 26, H = 20 };

#define FLOATS 2e-7

/* most: of what the picture may differ besides its floats. */
static void close_sums(const struct stp_image *image, uint32_t x, uint32_t y, const double sum[5],
                       const double most[4])
{
    static const char *const names[] = { "R", "G", "B" };
    for (int n = 0; n < 3; n++)
        close_to((double)value(image, names[n], x, y), sum[n], most[n] + FLOATS);
    close_to((double)value(image, "A", x, y), sum[3], FLOATS);
    if (sum[3] >= 1e-3)
        close_to((double)value(image, "Z", x, y), sum[4] / sum[3], most[3] / sum[3] + 1e-4);
}

/* In its own order a pixel is the same but for floats: colours and opacities of kernels, and the
 * picture, are floats. The medium has the same alpha; its colours mix what overlaps, as no order of
 * whole kernels can: march_exchanges says by how much. */
static void every_pixel(void **state)
{
    static struct march m;
    static struct march_ray ray;
    for (int v = 0; v < MARCH_VIEWS; v++) {
        struct stp_camera camera = march_view(&m, v, W, H);
        struct stp_scene *scene = march_scene(&m);
        struct stp_render_params params = exact_params();
        struct stp_image *image = render_volume(scene, &camera, &params);
        size_t covered = 0;
        for (uint32_t y = 0; y < H; y++)
            for (uint32_t x = 0; x < W; x++) {
                double through[5], sorted[5], most[4];
                march_pixel(&m, &camera, x, y, &ray);
                march_through(ray.found, ray.count, ray.depth, through);
                march_sorted(ray.found, ray.count, ray.depth, sorted);
                march_exchanges(ray.found, ray.count, ray.depth, most);
                close_sums(image, x, y, sorted, (double[4]){ 0 });
                close_sums(image, x, y, through, most);
                covered += sorted[3] >= 1e-3;
            }
        assert_true(covered > W * H / 4);
        stp_image_destroy(&image);
        stp_scene_destroy(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
