/* Whole opaque pictures against brute.h: its fragments, summed. */
#include "brute.h"

struct expected {
    size_t fragments, id;
    double depth, weight;
    struct vec3 normal, albedo, point;
};

static struct expected expect(const struct brute *b, uint32_t i, uint32_t j)
{
    static struct hit hit[MOST];
    struct expected e = { 0 };
    struct vec3 from, along;
    size_t count = brute_hits(b, i, j, &from, &along, hit);
    for (; e.fragments < count; e.fragments++) {
        const struct hit *h = &hit[e.fragments];
        if (h->depth > hit[0].depth + b->fixture->objects[0].epsilon)
            break;
        double w = b->params.kernel == STP_KERNEL_GAUSS ? exp(-2 * h->rho2) : 1 - h->rho2;
        e.weight += w;
        e.depth += w * h->depth;
        e.normal = v3_add(e.normal, v3_scale(h->normal, w));
        e.albedo = v3_add(e.albedo, v3_scale(v3_loadf(b->fixture->color[h->id]), w));
    }
    e.id = count ? hit[0].id : 0;
    e.depth /= e.weight;
    e.normal = v3_unit(e.normal);
    e.albedo = v3_scale(e.albedo, 1 / e.weight);
    e.point = v3_add(from, v3_scale(along, e.depth));
    return e;
}

static void compare3(const struct stp_image *image, const char *const name[3], uint32_t i,
                     uint32_t j, struct vec3 v, double tolerance)
{
    close_to(value(image, name[0], i, j), v.x, tolerance);
    close_to(value(image, name[1], i, j), v.y, tolerance);
    close_to(value(image, name[2], i, j), v.z, tolerance);
}

static void compare_pixel(const struct brute *b, const struct stp_image *image, uint32_t i,
                          uint32_t j)
{
    static const char *const color[3] = { "R", "G", "B" }, *const n[3] = { "N.X", "N.Y", "N.Z" },
                             *const p[3] = { "P.X", "P.Y", "P.Z" },
                             *const albedo[3] = { "albedo.R", "albedo.G", "albedo.B" };
    struct expected e = expect(b, i, j);
    assert_true(value(image, "A", i, j) == (e.fragments > 0));
    assert_true(value(image, "fragments", i, j) == (float)e.fragments);
    if (e.fragments == 0) {
        assert_true(value(image, "Z", i, j) == INFINITY);
        assert_true(id_at(image, i, j) == UINT32_MAX);
        compare3(image, color, i, j, v3(0, 0, 0), 0);
        compare3(image, n, i, j, v3(0, 0, 0), 0);
        return;
    }
    double facing = fmax(0, v3_dot(e.normal, b->back)), shine = 0.2 * pow(facing, 32);
    struct vec3 lit = v3_add(v3_scale(e.albedo, 0.1 + 0.7 * facing), v3(shine, shine, shine));
    assert_int_equal(id_at(image, i, j), 1000 + e.id);
    close_to(value(image, "Z", i, j), e.depth, 2e-7 * fabs(e.depth) + 1e-8);
    close_to(value(image, "weight", i, j), e.weight, 1e-6 * (1 + e.weight));
    compare3(image, n, i, j, e.normal, 1e-6);
    compare3(image, albedo, i, j, e.albedo, 1e-6);
    compare3(image, p, i, j, e.point, 1e-6 * (1 + fabs(e.depth)));
    compare3(image, color, i, j, lit, 1e-5);
}

static size_t compare_view(struct fixture *f, int view, const struct stp_render_params *params)
{
    struct stp_camera camera = hard_view(view, 71, 45);
    struct brute b = brute_of(f, &camera, params);
    struct stp_image *image = render(f, &camera, params);
    size_t covered = 0;
    for (uint32_t j = 0; j < camera.height; j++)
        for (uint32_t i = 0; i < camera.width; i++) {
            compare_pixel(&b, image, i, j);
            covered += value(image, "A", i, j) > 0;
        }
    stp_image_destroy(&image);
    return covered;
}

static void every_view(bool two_sided, enum stp_cull cull, enum stp_kernel kernel)
{
    struct fixture *f = fixture_create(0.07);
    struct stp_render_params params = exact_params();
    params.cull = cull;
    params.kernel = kernel;
    f->scene.facts.two_sided = two_sided;
    fill_randomly(f, 77 + two_sided, 400);
    for (int view = 0; view < VIEWS; view++)
        assert_true(compare_view(f, view, &params) > 200);
    free(f);
}

static void one_sided(void **state)
{
    every_view(false, STP_CULL_NONE, STP_KERNEL_PARABOLA);
}

static void two_sided(void **state)
{
    every_view(true, STP_CULL_NONE, STP_KERNEL_GAUSS);
}

static void back_faces_culled(void **state)
{
    every_view(true, STP_CULL_BACK, STP_KERNEL_PARABOLA);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_sided),
        cmocka_unit_test(two_sided),
        cmocka_unit_test(back_faces_culled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
