/* What `fast` keeps of each image's nearest fragment: normal and rho^2 in a word, or its splat's
 * id. Both give the same picture: the same bits of colour and opacity, and depth and normal within
 * what the word rounds. With a floor on the screen, with enlarged discs, with either kernel. */
#include "group_device.h"

/* A wavy ball, four discs at a place; radii differ by up to two, for floors to catch some of them.
 */
static struct stp_scene *ball(size_t count, double factor)
{
    struct stp_scene *scene = scene_make(count, 1, 0.1);
    uint32_t seed = 9;
    for (size_t i = 0; i < count; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)count, r = sqrt(1 - z * z);
        seed = seed * 1664525u + 1013904223u;
        double a = seed * 0x1p-32 * 2 * M_PI, wide = 1 + (double)(i % 5) / 4;
        struct vec3 n = v3(r * cos(a), r * sin(a), z);
        scene_add(scene, v3_add(n, v3(0, 0, -4)), n, 2.6 * wide / sqrt((double)count));
        scene_fade(scene, i, 0.4f);
    }
    scene_finish(scene);
    scene->facts.uniform_opacity = true;
    assert_int_equal(stp_scene_cover(&device.env, scene, NULL), STP_OK);
    for (unsigned k = 0; k < scene->facts.cover.groups; k++)
        scene->facts.cover.factor[k] = factor;
    return scene;
}

static struct stp_image *picture(const struct stp_scene *scene, struct stp_render_params p,
                                 enum stp_payload payload, bool *packed)
{
    struct stp_camera camera = plain_camera(96, 96, 170);
    struct stp_plan *plan = NULL;
    p.transparency = STP_TRANSPARENCY_FAST;
    p.payload = payload;
    assert_int_equal(device_plan(&device, scene, &camera, &p, &plan), STP_OK);
    *packed = plan->constant[PLAN_PACKED] != 0;
    struct stp_image *image = device_render_plan(&device, scene, plan);
    stp_plan_destroy(&plan);
    return image;
}

static const float *plane(const struct stp_image *image, const char *name)
{
    return stp_image_find(image, name)->data.f;
}

struct difference {
    size_t covered;
    double normal;  /* degrees, in the mean */
    double depth;   /* in epsilons, in the mean */
    double deepest; /* the most */
};

static struct difference difference_of(const struct stp_image *a, const struct stp_image *b)
{
    static const char *const same[] = { "R", "G", "B", "A" };
    size_t pixels = (size_t)a->width * a->height;
    const float *depth[] = { plane(a, "Z"), plane(b, "Z") }, *alpha = plane(a, "A");
    struct difference d = { 0 };
    for (unsigned c = 0; c < 4; c++)
        assert_memory_equal(plane(a, same[c]), plane(b, same[c]), pixels * sizeof(float));
    for (size_t i = 0; i < pixels; i++) {
        struct vec3 n[2];
        if (!(alpha[i] > 0))
            continue;
        n[0] = v3(plane(a, "N.X")[i], plane(a, "N.Y")[i], plane(a, "N.Z")[i]);
        n[1] = v3(plane(b, "N.X")[i], plane(b, "N.Y")[i], plane(b, "N.Z")[i]);
        double sine = v3_length(v3_cross(n[0], n[1]));
        assert_true(v3_dot(n[0], n[1]) > 0);
        d.covered++;
        d.normal += asin(fmin(sine, 1)) * 180 / M_PI;
        double depths = fabs((double)depth[0][i] - depth[1][i]) / 0.1;
        d.depth += depths;
        d.deepest = fmax(d.deepest, depths);
    }
    d.normal /= (double)d.covered;
    d.depth /= (double)d.covered;
    return d;
}

/* A normal's 12 bits a coordinate are off by 0.03 degrees at most, and rho^2 by 1/508, which turns
 * the mean of normals that are ten degrees apart by as much. Depths are kept as they are: a
 * fragment's share is off by 1/508 of the depths' range, an epsilon; at rims, where all weights are
 * as small as what rho^2 rounds, by up to half of it. */
static void expect_alike(unsigned i)
{
    bool enlarged = i & 1, floored = i & 2, gauss = i & 4, of_words, of_ids;
    struct stp_scene *scene = ball(1200, enlarged ? 1.3 : 1);
    struct stp_render_params p = { .min_splat = floored ? 10 : -1,
                                   .kernel = gauss ? STP_KERNEL_GAUSS : STP_KERNEL_PARABOLA };
    struct stp_image *words = picture(scene, p, STP_PAYLOAD_AUTO, &of_words);
    struct stp_image *ids = picture(scene, p, STP_PAYLOAD_ID, &of_ids);
    struct difference d = difference_of(words, ids);
    if (getenv("STP_TEST_VERDICTS"))
        print_message("%s%s%s: %zu pixels, words %d, normal %.4f degrees, depth %.5f epsilons, at "
                      "most %.3f\n",
                      enlarged ? "enlarged " : "", floored ? "floored " : "", gauss ? "gauss" : "",
                      d.covered, of_words, d.normal, d.depth, d.deepest);
    assert_false(of_ids);
    assert_true(of_words == (!enlarged || (!floored && !gauss)));
    assert_true(d.covered > 1500);
    assert_true(d.normal <= 0.05);
    assert_true(d.depth <= 1.0 / 508 && d.deepest <= 0.5);
    assert_true((d.normal > 0) == of_words);
    stp_image_destroy(&words);
    stp_image_destroy(&ids);
    stp_scene_destroy(&scene);
}

static void words_as_ids(void **state)
{
    for (unsigned i = 0; i < 8; i++)
        expect_alike(i);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(words_as_ids) };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
