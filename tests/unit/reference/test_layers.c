/* Transparent pictures against brute.h, whose sorted fragments are cut into layers here, and
 * against formulas. */
#include "brute.h"

struct layer {
    size_t first, end; /* of the sorted fragments */
    double alpha, depth, weight;
    struct vec3 color, normal;
};

static double alpha_of(const struct brute *b, const struct hit *hit)
{
    return b->fixture->opacity[hit->id];
}

/* The fragments that count: none of opacity 0; behind the first opaque one only opaque ones. */
static size_t keep(const struct brute *b, struct hit *hit, size_t count)
{
    size_t kept = 0;
    double wall = INFINITY;
    for (size_t i = count; i-- > 0;)
        if (alpha_of(b, &hit[i]) == 1)
            wall = hit[i].depth;
    for (size_t i = 0; i < count; i++) {
        double alpha = alpha_of(b, &hit[i]);
        if (alpha > 0 && (alpha < 1) == (hit[i].depth < wall))
            hit[kept++] = hit[i];
    }
    return kept;
}

static struct layer cut(const struct brute *b, const struct hit *hit, size_t count, size_t first)
{
    struct layer l = { .first = first, .end = first };
    bool opaque = alpha_of(b, &hit[first]) == 1;
    struct vec3 albedo = v3(0, 0, 0);
    for (; l.end < count && hit[l.end].depth <= hit[first].depth + b->fixture->objects[0].epsilon &&
           (alpha_of(b, &hit[l.end]) == 1) == opaque;
         l.end++) {
        const struct hit *h = &hit[l.end];
        double w = b->params.kernel == STP_KERNEL_GAUSS ? exp(-2 * h->rho2) : 1 - h->rho2;
        l.weight += w;
        l.alpha += w * alpha_of(b, h);
        l.depth += w * h->depth;
        l.normal = v3_add(l.normal, v3_scale(h->normal, w));
        albedo = v3_add(albedo, v3_scale(v3_loadf(b->fixture->color[h->id]), w));
    }
    l.alpha /= l.weight;
    l.depth /= l.weight;
    l.normal = v3_unit(l.normal);
    double facing = fmax(0, v3_dot(l.normal, b->back)), shine = 0.2 * pow(facing, 32);
    l.color = v3_add(v3_scale(albedo, (0.1 + 0.7 * facing) / l.weight), v3(shine, shine, shine));
    return l;
}

/* Back to front, as one composites by hand. Returns how many layers there are. */
static size_t expect(const struct brute *b, uint32_t i, uint32_t j, struct vec3 *color,
                     double *alpha, struct layer *nearest, size_t *id)
{
    static struct hit hit[MOST];
    static struct layer layer[MOST];
    struct vec3 from, along;
    size_t layers = 0, count = keep(b, hit, brute_hits(b, i, j, &from, &along, hit));
    for (size_t first = 0; first < count; first = layer[layers++].end) {
        layer[layers] = cut(b, hit, count, first);
        if (alpha_of(b, &hit[first]) == 1)
            count = layer[layers].end; /* nothing behind */
    }
    *color = v3(0, 0, 0);
    *alpha = 0;
    for (size_t k = layers; k-- > 0;) {
        *color =
            v3_add(v3_scale(layer[k].color, layer[k].alpha), v3_scale(*color, 1 - layer[k].alpha));
        *alpha = layer[k].alpha + *alpha * (1 - layer[k].alpha);
    }
    *nearest = layer[0];
    *id = hit[0].id;
    return layers;
}

static void compare_pixel(const struct brute *b, const struct stp_image *image, uint32_t i,
                          uint32_t j)
{
    struct vec3 color;
    struct layer nearest;
    double alpha;
    size_t id, layers = expect(b, i, j, &color, &alpha, &nearest, &id);
    assert_true(value(image, "layers", i, j) == (float)layers);
    close_to(value(image, "A", i, j), alpha, 1e-7);
    close_to(value(image, "R", i, j), color.x, 1e-5);
    close_to(value(image, "G", i, j), color.y, 1e-5);
    close_to(value(image, "B", i, j), color.z, 1e-5);
    assert_true(value(image, "coverage", i, j) == (layers > 0));
    if (layers == 0) {
        assert_true(value(image, "Z", i, j) == INFINITY && id_at(image, i, j) == UINT32_MAX);
        return;
    }
    assert_int_equal(id_at(image, i, j), 1000 + id);
    assert_true(value(image, "fragments", i, j) == (float)(nearest.end - nearest.first));
    close_to(value(image, "Z", i, j), nearest.depth, 2e-7 * fabs(nearest.depth) + 1e-8);
    close_to(value(image, "N.X", i, j), nearest.normal.x, 1e-6);
    close_to(value(image, "weight", i, j), nearest.weight, 1e-6 * (1 + nearest.weight));
}

/* Returns the most layers that a pixel has. */
static float compare_view(struct fixture *f, int view, const struct stp_render_params *params)
{
    struct stp_camera camera = hard_view(view, 71, 45);
    struct brute b = brute_of(f, &camera, params);
    struct stp_image *image = render(f, &camera, params);
    float most = 0;
    for (uint32_t j = 0; j < camera.height; j++)
        for (uint32_t i = 0; i < camera.width; i++) {
            compare_pixel(&b, image, i, j);
            most = fmaxf(most, value(image, "layers", i, j));
        }
    stp_image_destroy(&image);
    return most;
}

/* opacity: of splat i. */
static void every_view(float (*opacity)(size_t i), enum stp_kernel kernel)
{
    struct fixture *f = fixture_create(0.07);
    struct stp_render_params params = exact_params();
    params.kernel = kernel;
    f->scene.facts.two_sided = true;
    fill_randomly(f, 79, 600);
    for (size_t i = 0; i < 600; i++)
        fade(f, i, opacity(i));
    for (int view = 0; view < VIEWS; view++)
        assert_true(compare_view(f, view, &params) >= 4);
    free(f);
}

static float one_opacity(size_t i)
{
    return 0.3f;
}

static float varying(size_t i)
{
    return (float)(1 + i * 37 % 100) / 101;
}

static float hard(size_t i)
{
    static const float values[] = { 0, 1e-6f, 1, 0.999999f, 0.6f, 0.3f, 0.3f, 0.3f };
    return values[i * 13 % 8];
}

static void one(void **state)
{
    every_view(one_opacity, STP_KERNEL_PARABOLA);
}

static void many(void **state)
{
    every_view(varying, STP_KERNEL_GAUSS);
}

static void hard_values(void **state)
{
    every_view(hard, STP_KERNEL_PARABOLA);
}

/* Opacities that are all 1 give an opaque picture, to the bit. */
static void opaque(void **state)
{
    struct fixture *f = fixture_create(0.07);
    struct stp_render_params params = exact_params();
    struct stp_camera camera = hard_view(0, 71, 45);
    fill_randomly(f, 80, 600);
    params.samples = 4;
    struct stp_image *plain = render(f, &camera, &params);
    fade(f, 0, 1);
    struct stp_image *layered = render(f, &camera, &params);
    for (unsigned c = 0; c < plain->channel_count; c++)
        assert_memory_equal(plain->channels[c].data.u, layered->channels[c].data.u,
                            71 * 45 * sizeof(float));
    stp_image_destroy(&plain);
    stp_image_destroy(&layered);
    free(f);
}

/* A sheet across the whole of a one-pixel picture: seen head on, of albedo (r, g, b). */
static size_t add_sheet(struct fixture *f, double z, float opacity, float r, float g, float b)
{
    size_t i = add_splat(f, v3(0, 0, -z), v3(0, 0, 1), 100);
    paint(f, i, r, g, b);
    fade(f, i, opacity);
    return i;
}

static struct stp_image *pixel_of(struct fixture *f, const float *background)
{
    struct stp_camera camera = flat_camera(1, 1, 1);
    struct stp_render_params params = exact_params();
    params.background = background;
    return render(f, &camera, &params);
}

/* Red of 0.3 before blue of 0.6: one layer while they are within epsilon, else two. */
static void two_sheets(void **state)
{
    static const double distance[] = { 0.5, 0.99, 1.01, 2 };
    for (int k = 0; k < 4; k++) {
        struct fixture *f = fixture_create(0.1);
        add_sheet(f, 5, 0.3f, 1, 0, 0);
        add_sheet(f, 5 + 0.1 * distance[k], 0.6f, 0, 0, 1);
        struct stp_image *image = pixel_of(f, NULL);
        bool merged = distance[k] < 1;
        double alpha = merged ? 0.45 : 1 - 0.7 * 0.4;
        assert_true(value(image, "layers", 0, 0) == (merged ? 1 : 2));
        close_to(value(image, "A", 0, 0), alpha, 1e-6);
        double red = merged ? 0.45 * (0.4 + 0.2) : 0.3 * (0.8 + 0.2) + 0.7 * 0.6 * 0.2;
        double blue = merged ? 0.45 * (0.4 + 0.2) : 0.3 * 0.2 + 0.7 * 0.6 * (0.8 + 0.2);
        close_to(value(image, "R", 0, 0), red, 1e-6);
        close_to(value(image, "B", 0, 0), blue, 1e-6);
        close_to(value(image, "Z", 0, 0), 5 + (merged ? 0.05 * distance[k] : 0), 1e-6);
        stp_image_destroy(&image);
        free(f);
    }
}

static void many_layers(void **state)
{
    struct fixture *f = fixture_create(0.1);
    for (int k = 0; k < 300; k++)
        add_sheet(f, 5 + k * 0.11, 0.01f, 1, 1, 1);
    struct stp_image *image = pixel_of(f, NULL);
    double alpha = 1 - pow(1 - (double)0.01f, 300);
    assert_true(value(image, "layers", 0, 0) == 300);
    close_to(value(image, "A", 0, 0), alpha, 1e-7);
    close_to(value(image, "R", 0, 0), alpha, 1e-6); /* each is lit to 0.8 + 0.2 */
    stp_image_destroy(&image);
    free(f);
}

/* Something opaque ends the ray, also within epsilon of a sheet before or behind it. */
static void opaque_among(void **state)
{
    for (double z = 3.95; z < 8; z += 1 / 64.0) {
        struct fixture *f = fixture_create(0.1);
        add_sheet(f, 4, 0.3f, 1, 0, 0);
        add_sheet(f, 6, 0.3f, 1, 0, 0);
        add_sheet(f, z, 1, 0, 1, 0);
        struct stp_image *image = pixel_of(f, NULL);
        int before = z <= 4 ? 0 : z <= 6 ? 1 : 2;
        double through = pow(1 - (double)0.3f, before);
        assert_true(value(image, "A", 0, 0) == 1);
        assert_true(value(image, "layers", 0, 0) == 1 + before);
        close_to(value(image, "G", 0, 0), 0.8 * through + 0.2, 1e-6);
        close_to(value(image, "R", 0, 0), 0.8 * (1 - through) + 0.2, 1e-6);
        stp_image_destroy(&image);
        free(f);
    }
}

/* Premultiplied: two backgrounds, and what was there comes back; also of radiances of 1e4. */
static void over_backgrounds(void **state)
{
    static const float backgrounds[3][4] = { { 0, 0, 0, 1 }, { 1e4f, 1, 0.5f, 1 }, { 1, 2, 3, 0 } };
    struct fixture *f = fixture_create(0.1);
    struct stp_image *on[3];
    add_sheet(f, 4, 0.25f, 1, 0.5f, 0);
    add_sheet(f, 5, 0.5f, 0, 0.25f, 2);
    struct stp_image *bare = pixel_of(f, NULL);
    for (int k = 0; k < 3; k++)
        on[k] = pixel_of(f, backgrounds[k]);
    double alpha = 1 - (value(on[1], "R", 0, 0) - value(on[0], "R", 0, 0)) / 1e4;
    close_to(value(bare, "A", 0, 0), alpha, 1e-6);
    for (const char *c = "RGB"; *c; c++) {
        char name[2] = { *c };
        assert_true(value(on[0], name, 0, 0) == value(bare, name, 0, 0));
        assert_true(value(on[2], name, 0, 0) == value(bare, name, 0, 0));
    }
    assert_true(value(on[0], "A", 0, 0) == 1 && value(on[2], "A", 0, 0) == value(bare, "A", 0, 0));
    stp_image_destroy(&bare);
    for (int k = 0; k < 3; k++)
        stp_image_destroy(&on[k]);
    free(f);
}

static void nothing_to_see(void **state)
{
    struct fixture *f = fixture_create(0.1);
    add_sheet(f, 4, 0, 1, 1, 1);
    struct stp_image *image = pixel_of(f, NULL);
    assert_true(value(image, "A", 0, 0) == 0 && value(image, "layers", 0, 0) == 0);
    assert_true(value(image, "Z", 0, 0) == INFINITY && id_at(image, 0, 0) == UINT32_MAX);
    stp_image_destroy(&image);
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one),
        cmocka_unit_test(many),
        cmocka_unit_test(hard_values),
        cmocka_unit_test(opaque),
        cmocka_unit_test(two_sheets),
        cmocka_unit_test(many_layers),
        cmocka_unit_test(opaque_among),
        cmocka_unit_test(over_backgrounds),
        cmocka_unit_test(nothing_to_see),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
