#include "clouds.h"

#include "base/memory.h"
#include "scene/scene.h"

#define COUNT 6000

static void assert_same(const struct stp_scene *a, const struct stp_scene *b)
{
    const struct splats *s = &a->splats, *t = &b->splats;
    assert_int_equal(s->count, t->count);
    assert_memory_equal(s->position, t->position, s->count * sizeof *s->position);
    assert_memory_equal(s->normal, t->normal, s->count * sizeof *s->normal);
    assert_memory_equal(s->radius, t->radius, s->count * sizeof *s->radius);
    assert_int_equal(s->color != NULL, t->color != NULL);
    if (s->color)
        assert_memory_equal(s->color, t->color, s->count * sizeof *s->color);
    assert_true(a->facts.outwardness == b->facts.outwardness);
    assert_memory_equal(a->core, b->core, sizeof a->core);
    assert_memory_equal(s->origin, t->origin, sizeof s->origin);
    assert_true(a->objects[0].epsilon == b->objects[0].epsilon);
}

/* A noisy torus with repeats, holes in the data and an outlier. */
struct input {
    double position[COUNT][3];
    float normal[COUNT][3], radius[COUNT], color[COUNT][3];
};

static struct input *make_input(const uint32_t *order)
{
    struct input *in = calloc(1, sizeof *in);
    for (size_t i = 0; i < COUNT; i++) {
        uint64_t seed = order ? order[i] : i;
        double n[3], u = random_unit(&seed), v = random_unit(&seed);
        uint64_t kind = random_bits(&seed) % 100;
        if (kind == 0)
            u = v = 0.5;
        on_torus(u, v, in->position[i], n);
        for (int axis = 0; axis < 3; axis++) {
            in->position[i][axis] += kind == 0 ? 0 : 0.01 * random_unit(&seed);
            in->normal[i][axis] = kind == 1 ? NAN : (float)n[axis];
            in->color[i][axis] = kind == 0 ? 0.5f : (float)random_unit(&seed);
        }
        in->radius[i] = kind == 2 ? 0 : 0.05f;
        if (kind == 3)
            in->position[i][2] = i % 2 ? NAN : INFINITY;
    }
    return in;
}

static struct stp_scene *prepare(const struct input *in, bool normals, bool radii, unsigned threads)
{
    struct stp_env env = { .threads = threads };
    struct stp_points points = { .count = COUNT,
                                 .position = (const double(*)[3])in->position,
                                 .normal = normals ? (const float(*)[3])in->normal : NULL,
                                 .radius = radii ? in->radius : NULL,
                                 .color = (const float(*)[3])in->color };
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(&env, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(&env, scene, &points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(&env, scene, NULL), STP_OK);
    return scene;
}

static void same_for_shuffled_input_and_any_threads(void **state)
{
    uint32_t order[COUNT];
    uint64_t seed = 12;
    for (uint32_t i = 0; i < COUNT; i++)
        order[i] = i;
    for (size_t i = COUNT - 1; i > 0; i--) {
        size_t j = random_bits(&seed) % (i + 1);
        uint32_t keep = order[i];
        order[i] = order[j];
        order[j] = keep;
    }
    struct input *plain = make_input(NULL), *mixed = make_input(order);
    for (int what = 0; what < 4; what++) {
        struct stp_scene *one = prepare(plain, what & 1, what & 2, 1);
        struct stp_scene *many = prepare(plain, what & 1, what & 2, 5);
        struct stp_scene *other = prepare(mixed, what & 1, what & 2, 2);
        assert_same(one, many);
        assert_same(one, other);
        assert_memory_equal(one->splats.input, many->splats.input, one->splats.count * 4);
        stp_scene_destroy(&one);
        stp_scene_destroy(&many);
        stp_scene_destroy(&other);
    }
    free(plain);
    free(mixed);
}

static void counts_and_facts(void **state)
{
    struct input *in = make_input(NULL);
    struct stp_scene *scene = prepare(in, true, true, 2);
    const struct stp_facts *f = stp_scene_facts(scene);
    size_t lost = 0, normals = 0, radii = 0;
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < COUNT; i++) {
        bool kept = isfinite(in->position[i][2]);
        lost += !kept;
        normals += kept && isnan(in->normal[i][0]);
        radii += kept && in->radius[i] == 0;
        low = kept ? fmin(low, in->position[i][0]) : low;
        high = kept ? fmax(high, in->position[i][0]) : high;
    }
    assert_true(lost > 10 && normals > 10 && radii > 10);
    assert_int_equal(f->points, COUNT);
    assert_int_equal(f->not_finite, lost);
    assert_int_equal(f->splats, COUNT - lost);
    assert_int_equal(f->bad_normals, normals);
    assert_int_equal(f->bad_radii, radii);
    assert_true(f->bounds[0] == low && f->bounds[3] == high);
    assert_true(f->has_color && !f->transparent);
    assert_true(f->radius_median == 0.05f && f->color_max <= 1 && f->color_max > 0.99f);
    assert_true(f->outwardness > 0.2 && !f->two_sided);
    assert_int_equal(f->objects, 1);
    assert_int_equal(f->lights, 1);
    assert_int_equal(f->up, STP_UP_Y);
    assert_true(scene->prepared);
    assert_null(scene->objects[0].cloud.position);
    stp_scene_destroy(&scene);
    free(in);
}

static void clip_box(void **state)
{
    struct input *in = make_input(NULL);
    const double box[6] = { 0, -10, -10, 10, 10, 10 }, bad[6] = { 1, 0, 0, 0, 1, 1 };
    struct stp_env env = { .log = silent };
    struct stp_points points = { .count = COUNT, .position = (const double(*)[3])in->position };
    struct stp_prepare_params params = { STP_OFF, bad };
    struct stp_scene *scene;
    stp_scene_create(&env, &scene);
    stp_scene_add_points(&env, scene, &points, NULL);
    assert_int_equal(stp_scene_prepare(&env, scene, &params), STP_ERROR_ARGUMENT);
    params.clip_box = box;
    assert_int_equal(stp_scene_prepare(&env, scene, &params), STP_OK);
    const struct stp_facts *f = stp_scene_facts(scene);
    assert_int_equal(f->clipped + f->not_finite + f->splats, COUNT);
    assert_true(f->clipped > COUNT / 3 && f->bounds[0] >= 0);
    assert_false(f->two_sided);
    for (size_t i = 0; i < f->splats; i++)
        assert_memory_equal(scene->splats.position[i], in->position[scene->splats.input[i]], 24);
    assert_int_equal(stp_scene_prepare(&env, scene, &params), STP_ERROR_ARGUMENT);
    stp_scene_destroy(&scene);
    free(in);
}

static void several_objects(void **state)
{
    struct samples a = sample_surface(on_sphere, 1000, 1), b = sample_surface(on_torus, 500, 2);
    for (size_t i = 0; i < b.count; i++)
        b.position[i][0] += 5;
    float color[500][3], radius[500];
    for (size_t i = 0; i < 500; i++) {
        color[i][0] = color[i][1] = color[i][2] = 0.125f;
        radius[i] = 0.25f;
    }
    struct stp_material red = { .ambient = 0.1f, .diffuse = 0.7f, .albedo = { 1, 0, 0 } };
    struct stp_object_params first = { .material = &red, .epsilon = 0.5, .opacity = 0.5f };
    struct stp_points points = { .count = 1000, .position = (const double(*)[3])a.position };
    struct stp_points others = { .count = 500,
                                 .position = (const double(*)[3])b.position,
                                 .normal = (const float(*)[3])b.normal,
                                 .radius = radius,
                                 .color = (const float(*)[3])color };
    struct stp_scene *scene;
    stp_scene_create(NULL, &scene);
    assert_int_equal(stp_scene_add_points(NULL, scene, &points, &first), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, &others, NULL), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, &(struct stp_points){ 0 }, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    const struct splats *s = &scene->splats;
    assert_int_equal(s->count, 1500);
    for (size_t i = 0; i < s->count; i++) {
        bool second = s->input[i] >= 1000;
        const double *from = second ? b.position[s->input[i] - 1000] : a.position[s->input[i]];
        assert_int_equal(s->object[i], second);
        assert_memory_equal(s->position[i], from, sizeof(double[3]));
        assert_true(s->color[i][0] == (second ? 0.125f : 1) &&
                    s->color[i][1] == (second ? 0.125f : 0));
        assert_true(s->opacity[i] == (second ? 1 : 0.5f));
        assert_true(!second || s->radius[i] == 0.25f);
    }
    assert_true(scene->objects[0].epsilon == 0.5 && scene->objects[1].epsilon == 0.25);
    assert_true(scene->objects[0].material.specular == 0 &&
                scene->objects[0].material.shininess == 0);
    assert_true(scene->facts.transparent);
    assert_true(scene->facts.mixed && scene->facts.uniform_opacity);
    assert_int_equal(scene->facts.objects, 3);
    assert_int_equal(scene->facts.normals, STP_NORMALS_ESTIMATED);
    stp_scene_destroy(&scene);
    samples_release(&a);
    samples_release(&b);
}

static void colors_made(void **state)
{
    struct samples a = sample_surface(on_sphere, 2000, 1);
    for (int source = COLOR_BY_HEIGHT; source <= COLOR_BY_NORMAL; source++) {
        struct stp_points points = { .count = 2000,
                                     .position = (const double(*)[3])a.position,
                                     .normal = (const float(*)[3])a.normal };
        struct stp_scene *scene;
        stp_scene_create(NULL, &scene);
        stp_scene_add_points(NULL, scene, &points, NULL);
        scene->objects[0].color_source = (enum color_source)source;
        assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
        const struct splats *s = &scene->splats;
        for (size_t i = 0; i < s->count; i++) {
            float y = (float)s->position[i][1];
            if (source == COLOR_BY_NORMAL)
                assert_true(fabsf(s->color[i][1] - (0.5f * y + 0.5f)) < 1e-6f);
            else /* green rises with height */
                assert_true(y < 0.5f || (s->color[i][1] > 0.4f && s->color[i][1] < 0.8f));
        }
        assert_true(scene->facts.has_color);
        stp_scene_destroy(&scene);
    }
    samples_release(&a);
}

/* The points' own, times the material's, times the object's; negative is none, 0 is not set. */
static void opacities_multiply(void **state)
{
    static const struct {
        float material, object, first; /* of the first point, whose own is 0.5 */
        bool mixed, uniform;
    } cases[] = { { 0, 0, 0.5f, true, false },      { 0.5f, 0, 0.25f, false, false },
                  { 0, 0.5f, 0.25f, false, false }, { 0.5f, 0.5f, 0.125f, false, false },
                  { -1, 0.5f, 0, false, true },     { 0, -1, 0, false, true } };
    double p[2][3] = { { 0 }, { 1 } };
    float opacity[2] = { 0.5f, 1 };
    struct stp_points points = { .count = 2, .position = (const double(*)[3])p };
    for (size_t k = 0; k < 2 * sizeof cases / sizeof *cases; k++) {
        bool own = k % 2;
        struct stp_material material = { .opacity = cases[k / 2].material };
        struct stp_object_params object = { .material = &material, .opacity = cases[k / 2].object };
        struct stp_scene *scene;
        points.opacity = own ? opacity : NULL;
        stp_scene_create(NULL, &scene);
        assert_int_equal(stp_scene_add_points(NULL, scene, &points, &object), STP_OK);
        assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
        const struct stp_facts *f = &scene->facts;
        float expected = own ? cases[k / 2].first : 2 * cases[k / 2].first;
        assert_true(f->transparent == (expected < 1) && f->opacity_min == expected);
        assert_true(f->uniform_opacity == (!own || cases[k / 2].uniform));
        assert_true(f->mixed == (own && cases[k / 2].mixed));
        assert_true((scene->splats.opacity != NULL) == f->transparent);
        for (size_t i = 0; f->transparent && i < 2; i++)
            assert_true(scene->splats.opacity[i] ==
                        (own && scene->splats.input[i] == 1 ? 2 * expected : expected));
        stp_scene_destroy(&scene);
    }
}

/* Coincident points that differ in opacity alone: the same order from any order of the file. */
static void opacity_orders(void **state)
{
    double p[64][3] = { { 0 } };
    float normal[64][3], radius[64], opacity[64];
    float sorted[2][64];
    for (int turn = 0; turn < 2; turn++) {
        for (int i = 0; i < 64; i++) {
            int from = turn ? (i * 37 + 11) % 64 : i;
            p[i][0] = from % 2;
            memcpy(normal[i], (float[3]){ 0, 0, 1 }, sizeof normal[i]);
            radius[i] = 1;
            opacity[i] = (float)from / 64;
        }
        struct stp_points points = { .count = 64,
                                     .position = (const double(*)[3])p,
                                     .normal = (const float(*)[3])normal,
                                     .radius = radius,
                                     .opacity = opacity };
        struct stp_object_params half = { .opacity = 0.5f };
        struct stp_scene *scene;
        stp_scene_create(NULL, &scene);
        stp_scene_add_points(NULL, scene, &points, &half);
        assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
        assert_int_equal(scene->facts.duplicates, 0);
        memcpy(sorted[turn], scene->splats.opacity, sizeof sorted[turn]);
        stp_scene_destroy(&scene);
    }
    assert_memory_equal(sorted[0], sorted[1], sizeof sorted[0]);
    for (int i = 1; i < 32; i++)
        assert_true(sorted[0][i] > sorted[0][i - 1]);
}

/* Attributes that are no numbers, and opacities that are all 1. */
static void attributes_are_cleaned(void **state)
{
    double p[4][3] = { { 0 }, { 1 }, { 0, 1 }, { 1, 1 } };
    float color[4][3] = { { NAN, INFINITY, -INFINITY }, { 1e6f, -1, 0 }, { 0 }, { 0 } };
    float opacity[4] = { NAN, 2, 1, 1 };
    struct stp_points points = { .count = 4,
                                 .position = (const double(*)[3])p,
                                 .color = (const float(*)[3])color,
                                 .opacity = opacity };
    struct stp_scene *scene;
    stp_scene_create(NULL, &scene);
    stp_scene_add_points(NULL, scene, &points, NULL);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    assert_true(!scene->facts.transparent);
    assert_null(scene->splats.opacity);
    for (size_t i = 0; i < 4; i++) {
        const float *c = scene->splats.color[i];
        if (scene->splats.input[i] == 0)
            assert_true(c[0] == 0 && c[1] == 65504 && c[2] == 0);
        if (scene->splats.input[i] == 1)
            assert_true(c[0] == 1e6f && c[1] == -1);
    }
    stp_scene_destroy(&scene);
}

static void no_points(void **state)
{
    char line[512] = "";
    struct stp_env env = { .log = silent, .user = line };
    double p[2][3] = { { NAN, 0, 0 }, { 1e300, 0, 0 } };
    struct stp_points points = { .count = 2, .position = (const double(*)[3])p };
    struct stp_scene *scene;
    stp_scene_create(&env, &scene);
    assert_int_equal(stp_scene_prepare(&env, scene, NULL), STP_ERROR_NO_POINTS);
    stp_scene_add_points(&env, scene, &points, NULL);
    assert_int_equal(stp_scene_prepare(&env, scene, NULL), STP_ERROR_NO_POINTS);
    assert_non_null(strstr(line, "none of 2 has finite coordinates"));
    assert_false(scene->prepared);
    stp_scene_destroy(&scene);
}

/* Everything that can be missing is, in two objects, so that every allocation is met. */
static bool try_with_failure(unsigned long n, const struct input *in)
{
    struct stp_env env = { .log = silent, .threads = 2 };
    struct stp_points points = { .count = 500, .position = (const double(*)[3])in->position };
    struct stp_points others = { .count = 500,
                                 .position = (const double(*)[3])in->position + 500,
                                 .normal = (const float(*)[3])in->normal + 500,
                                 .radius = in->radius + 500 };
    struct stp_object_params object = { .opacity = 0.5f };
    struct stp_scene *scene = NULL;
    mem_fail_at(n);
    enum stp_result result = stp_scene_create(&env, &scene);
    if (result == STP_OK)
        result = stp_scene_add_points(&env, scene, &points, NULL);
    if (result == STP_OK)
        result = stp_scene_add_points(&env, scene, &others, &object);
    if (result == STP_OK) {
        scene->objects[0].color_source = COLOR_BY_HEIGHT;
        result = stp_scene_prepare(&env, scene, NULL);
    }
    bool reached = mem_count() >= n;
    mem_fail_at(0);
    assert_int_equal(result, reached ? STP_ERROR_MEMORY : STP_OK);
    stp_scene_destroy(&scene);
    return reached;
}

static void survives_no_memory(void **state)
{
    struct input *in = make_input(NULL);
    unsigned long n = 1;
    while (try_with_failure(n, in))
        n++;
    assert_true(n > 60);
    free(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_for_shuffled_input_and_any_threads),
        cmocka_unit_test(counts_and_facts),
        cmocka_unit_test(clip_box),
        cmocka_unit_test(several_objects),
        cmocka_unit_test(colors_made),
        cmocka_unit_test(opacities_multiply),
        cmocka_unit_test(opacity_orders),
        cmocka_unit_test(attributes_are_cleaned),
        cmocka_unit_test(no_points),
        cmocka_unit_test(survives_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
