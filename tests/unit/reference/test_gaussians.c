/* Surfaces as Gaussians in every ray's own order, against brute.h, and against known answers. */
#include "brute.h"

#include "base/memory.h"

static struct stp_render_params gaussian_params(void)
{
    struct stp_render_params params = exact_params();
    params.method = STP_METHOD_AXIS;
    params.axis_merge = STP_AXIS_REFERENCE;
    return params;
}

struct expected {
    size_t count, id;
    double alpha, depth;
    struct vec3 color;
};

/* The head light on one splat. */
static struct vec3 light_on(const struct brute *b, const struct hit *h)
{
    double facing = fmax(0, v3_dot(h->normal, b->back)), shine = 0.2 * pow(facing, 32);
    struct vec3 albedo = v3_loadf(b->fixture->color[h->id]);
    return v3_add(v3_scale(albedo, 0.1 + 0.7 * facing), v3(shine, shine, shine));
}

/* Back to front: the other way round than the reference. */
static struct expected expect(const struct brute *b, uint32_t i, uint32_t j)
{
    static struct hit hit[MOST];
    const struct splats *s = &b->fixture->scene.splats;
    struct vec3 from, along;
    struct expected e = { 0 };
    double most = 0, through[MOST + 1] = { 1 };
    size_t count = brute_hits(b, i, j, &from, &along, hit), kept = 0;
    for (size_t n = 0; n < count; n++) {
        double a = exp(-2 * hit[n].rho2) * (s->opacity ? (double)s->opacity[hit[n].id] : 1);
        if (a < 1e-4)
            continue;
        through[kept + 1] = through[kept] * (1 - a);
        hit[kept] = hit[n];
        hit[kept++].rho2 = a; /* from here on its alpha */
    }
    for (size_t n = kept; n-- > 0;) {
        double a = hit[n].rho2, w = through[n] * a;
        e.color = v3_add(v3_scale(e.color, 1 - a), v3_scale(light_on(b, &hit[n]), a));
        e.depth = (1 - a) * e.depth + a * hit[n].depth;
        e.id = w >= most ? hit[n].id : e.id;
        most = fmax(most, w);
    }
    e.count = kept;
    e.alpha = 1 - through[kept];
    e.depth /= e.alpha;
    double scale = b->fixture->scene.facts.transparent ? 1 : fmin(1, 2 * e.alpha) / e.alpha;
    e.color = v3_scale(e.color, scale);
    e.alpha *= scale;
    return e;
}

static size_t compare_view(struct fixture *f, int view, const struct stp_render_params *params)
{
    struct stp_camera camera = hard_view(view, 61, 37);
    struct brute b = brute_of(f, &camera, params);
    struct stp_image *image = render(f, &camera, params);
    size_t covered = 0;
    for (uint32_t j = 0; j < camera.height; j++)
        for (uint32_t i = 0; i < camera.width; i++) {
            struct expected e = expect(&b, i, j);
            assert_int_equal(value(image, "fragments", i, j), e.count);
            assert_true(value(image, "N.X", i, j) == 0 && value(image, "N.Z", i, j) == 0);
            if (e.count == 0) {
                assert_true(value(image, "A", i, j) == 0 && isinf(value(image, "Z", i, j)));
                continue;
            }
            close_to((double)value(image, "R", i, j), e.color.x, 1e-6);
            close_to((double)value(image, "B", i, j), e.color.z, 1e-6);
            close_to((double)value(image, "A", i, j), e.alpha, 1e-6);
            close_to((double)value(image, "Z", i, j), e.depth, 1e-6 * fabs(e.depth) + 1e-8);
            assert_int_equal(id_at(image, i, j), 1000 + e.id);
            covered++;
        }
    stp_image_destroy(&image);
    return covered;
}

static void random_splats_in_every_view(void **state)
{
    struct stp_render_params params = gaussian_params();
    for (int v = 0; v < VIEWS; v++) {
        struct fixture *f = fixture_create(0.05);
        fill_randomly(f, 900 + (uint32_t)v, 400);
        f->scene.facts.two_sided = v % 2;
        params.cull = v % 4 == 2 ? STP_CULL_BACK : STP_CULL_NONE;
        uint32_t seed = 77;
        for (size_t i = 0; v % 3 == 0 && i < 400; i++)
            fade(f, i, i % 5 ? (float)uniform(&seed) : i % 2 ? 1 : 5e-5f);
        assert_true(compare_view(f, v, &params) > 20);
        free(f);
    }
}

/* One disc, straight on: its opacity in the middle, and e^-2 of it at its edge, where a surface is
 * half covered at the most. */
static void one_disc(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(81, 81, 100);
    struct stp_render_params params = gaussian_params();
    add_splat(f, v3(0, 0, -10), v3(0, 0, 1), 3.95);
    struct stp_image *image = render(f, &camera, &params);
    assert_true(value(image, "A", 40, 40) == 1);
    double rho2 = pow(39 / 39.5, 2);
    close_to((double)value(image, "A", 79, 40), 2 * exp(-2 * rho2), 1e-6);
    assert_true(value(image, "A", 80, 40) == 0);
    stp_image_destroy(&image);
    fade(f, 0, 0.25f);
    image = render(f, &camera, &params);
    close_to((double)value(image, "A", 40, 40), 0.25, 1e-7); /* not divided */
    close_to((double)value(image, "A", 79, 40), 0.25 * exp(-2 * rho2), 1e-6);
    stp_image_destroy(&image);
    free(f);
}

/* Two discs that cross: each is in front on its side of the line. */
static void every_ray_has_its_order(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(41, 41, 100);
    struct stp_render_params params = gaussian_params();
    for (int side = 0; side < 2; side++) {
        size_t i = add_splat(f, v3(0, 0, -10), v3(side ? 0.5 : -0.5, 0, 1), 5);
        paint(f, i, side == 0, side == 1, 0);
    }
    struct stp_image *image = render(f, &camera, &params);
    assert_true(value(image, "R", 25, 20) < 0.3f * value(image, "G", 25, 20) ||
                value(image, "G", 25, 20) < 0.3f * value(image, "R", 25, 20));
    bool right = value(image, "R", 25, 20) > value(image, "G", 25, 20);
    bool left = value(image, "R", 15, 20) > value(image, "G", 15, 20);
    assert_true(right != left);
    stp_image_destroy(&image);
    free(f);
}

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

/* The same bits on one thread and many; every allocation may fail; deep pictures are refused. */
static void threads_and_allocations(void **state)
{
    struct fixture *f = fixture_create(0.05);
    struct stp_camera camera = hard_view(0, 70, 50);
    struct stp_render_params params = gaussian_params();
    fill_randomly(f, 31, 300);
    struct stp_image *many = render(f, &camera, &params), *image = NULL;
    struct stp_env env = { .threads = 1, .log = swallow };
    enum stp_result result = STP_ERROR_MEMORY;
    for (unsigned long n = 1; result != STP_OK; n++) {
        mem_fail_at(n);
        result = reference_render(&env, &f->scene, &camera, &params, &image);
        mem_fail_at(0);
        assert_true(result == STP_OK || (result == STP_ERROR_MEMORY && !image));
        assert_true(n < 200);
    }
    for (uint32_t i = 0; i < 70 * 50; i++)
        assert_true(value(image, "G", i % 70, i / 70) == value(many, "G", i % 70, i / 70));
    stp_image_destroy(&image);
    stp_image_destroy(&many);
    params.deep = true;
    assert_int_equal(reference_render(&env, &f->scene, &camera, &params, &image),
                     STP_ERROR_ARGUMENT);
    free(f);
}

/* Several samples are the mean of their pictures. */
static void samples(void **state)
{
    struct fixture *f = fixture_create(0.1);
    struct stp_camera camera = plain_camera(21, 21, 20);
    struct stp_render_params params = gaussian_params();
    add_splat(f, v3(0, 0, -10), v3(0, 0, 1), 4.3);
    params.samples = 64;
    struct stp_image *image = render(f, &camera, &params);
    for (uint32_t x = 10; x < 18; x++) {
        double sum = 0; /* the mean over the pixel's square, by the midpoint rule */
        for (int n = 0; n < 1024; n++) {
            double u = x - 10.5 + (n % 32 + 0.5) / 32, v = -0.5 + (n / 32 + 0.5) / 32;
            double rho2 = (u * u + v * v) * 0.25 / (4.3 * 4.3), a = exp(-2 * rho2);
            sum += rho2 <= 1 ? fmin(1, 2 * a) / 1024 : 0;
        }
        close_to((double)value(image, "A", x, 10), sum, 0.03);
    }
    stp_image_destroy(&image);
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_splats_in_every_view),
        cmocka_unit_test(one_disc),
        cmocka_unit_test(every_ray_has_its_order),
        cmocka_unit_test(threads_and_allocations),
        cmocka_unit_test(samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
