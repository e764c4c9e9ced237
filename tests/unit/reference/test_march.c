/* Volumes by the reference against march.h: every pixel's alpha, its own order, and the medium that
 * the Gaussians stand for. */
#include "march.h"

enum { W = 26, H = 20 };

static void close_sums(const struct stp_image *image, uint32_t x, uint32_t y, const double sum[5],
                       double color, double alpha)
{
    static const char *const names[] = { "R", "G", "B" };
    for (int n = 0; n < 3; n++)
        close_to((double)value(image, names[n], x, y), sum[n], color);
    close_to((double)value(image, "A", x, y), sum[3], alpha);
}

/* In its own order a pixel is the same but for floats: colours and opacities of kernels, and the
 * picture, are floats. The medium has the same alpha; its colours mix what overlaps, as no order of
 * whole kernels can. */
static void every_pixel(void **state)
{
    static struct march m;
    for (int v = 0; v < MARCH_VIEWS; v++) {
        struct stp_camera camera = march_view(&m, v, W, H);
        struct stp_scene *scene = march_scene(&m);
        struct stp_render_params params = exact_params();
        struct stp_image *image = render_volume(scene, &camera, &params);
        size_t covered = 0;
        for (uint32_t y = 0; y < H; y++)
            for (uint32_t x = 0; x < W; x++) {
                double through[5], sorted[5];
                march_pixel(&m, &camera, x, y, through, sorted);
                close_sums(image, x, y, sorted, 2e-7, 2e-7);
                close_sums(image, x, y, through, 0.006, 2e-7);
                if (sorted[3] < 1e-3)
                    continue;
                covered++;
                close_to((double)value(image, "Z", x, y), sorted[4] / sorted[3], 1e-4);
                close_to((double)value(image, "Z", x, y), through[4] / through[3],
                         v < MARCH_VIEWS / 2 ? 0.1 : 0.5);
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
