/* Levels of an environment against the lobe summed directly, and what scenes make of them. */
#include "clouds.h"

#include "base/memory.h"
#include "prepare/environment.h"

static void count_errors(void *user, enum stp_log_level level, const char *line)
{
    (void)line;
    *(unsigned *)user += level == STP_LOG_ERROR;
}

/* Smooth, with one small sun; deterministic. */
static struct environment_map make_map(uint32_t width, uint32_t height)
{
    struct environment_map map = { width, height, calloc((size_t)width * height, 12) };
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            float *t = map.texel[(size_t)y * width + x];
            double u = 2 * PI * (x + 0.5) / width, v = PI * (y + 0.5) / height;
            t[0] = (float)(1 + cos(u) * sin(v));
            t[1] = (float)(1 + 0.5 * cos(3 * u) * sin(v) * sin(v));
            t[2] = x == width / 3 && y == height / 3 ? 1e4f : 0.25f;
        }
    return map;
}

static void direction(double u, double v, double d[3])
{
    d[0] = cos(2 * PI * u) * sin(PI * v);
    d[1] = sin(2 * PI * u) * sin(PI * v);
    d[2] = cos(PI * v);
}

/* The definition in docs/glass.md, by dot products of directions. */
static void lobe(const struct environment_map *map, double u, double v, double r, double out[3])
{
    double texel = fmax(PI / map->height, 2 * PI / map->width), total = 0, d[3], t[3];
    double kappa = 1 / (2 * r * r * r * r + texel * texel / 4);
    direction(u, v, d);
    memset(out, 0, 3 * sizeof *out);
    for (uint32_t y = 0; y < map->height; y++)
        for (uint32_t x = 0; x < map->width; x++) {
            direction((x + 0.5) / map->width, (y + 0.5) / map->height, t);
            double angle = cos(PI * y / map->height) - cos(PI * (y + 1) / map->height);
            double w = angle * exp(kappa * (d[0] * t[0] + d[1] * t[1] + d[2] * t[2] - 1));
            total += w;
            for (int k = 0; k < 3; k++)
                out[k] += w * (double)map->texel[(size_t)y * map->width + x][k];
        }
    for (int k = 0; k < 3; k++)
        out[k] /= total;
}

/* Level of one roughness, filled; free texel with mem_free. */
static struct environment_level fill(const struct environment_map *map, float roughness,
                                     unsigned threads, float (**texel)[3])
{
    struct stp_env env = { .threads = threads };
    struct environment_level level = { roughness, map->width, map->height, 0 };
    if (roughness > 0)
        environment_level_size(map, roughness, &level.width, &level.height);
    *texel = mem_alloc((size_t)level.width * (level.height + 2), sizeof **texel);
    assert_int_equal(environment_fill(&env, map, &level, 1, *texel), STP_OK);
    return level;
}

/* Some 600 texels of a level; errors relative to the channel's largest value. */
static void check_level(const struct environment_map *map, float roughness, double tolerance)
{
    float(*texel)[3];
    struct environment_level level = fill(map, roughness, 2, &texel);
    double worst[3] = { 0 }, largest[3] = { 0 };
    size_t step = (size_t)level.width * level.height / 600 + 9;
    for (size_t i = 0; i < (size_t)level.width * level.height; i += step) {
        double truth[3];
        lobe(map, (double)(i % level.width) / level.width + 0.5 / level.width,
             (double)(i / level.width) / level.height + 0.5 / level.height, (double)roughness,
             truth);
        for (int k = 0; k < 3; k++)
            worst[k] = fmax(worst[k], fabs((double)texel[level.width + i][k] - truth[k]));
    }
    for (size_t i = 0; i < (size_t)level.width * level.height; i++)
        for (int k = 0; k < 3; k++)
            largest[k] = fmax(largest[k], (double)texel[level.width + i][k]);
    for (int k = 0; k < 3; k++)
        if (!(worst[k] <= tolerance * largest[k]))
            fail_msg("%u x %u, roughness %g, channel %d: off by %g of %g", map->width, map->height,
                     (double)roughness, k, worst[k], largest[k]);
    mem_free(texel);
}

static void test_levels(void **state)
{
    static const uint32_t sizes[][2] = { { 64, 32 }, { 128, 64 }, { 31, 9 }, { 10, 40 }, { 1, 1 } };
    static const float roughness[] = { 0.02f, 0.2f, 0.4f, 0.7f, 1 };
    for (unsigned i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct environment_map map = make_map(sizes[i][0], sizes[i][1]);
        for (unsigned k = 0; k < sizeof roughness / sizeof *roughness; k++)
            check_level(&map, roughness[k], 0.01);
        free(map.texel);
    }
}

/* Nothing is lost or won: an even map stays even, poles included. */
static void test_even(void **state)
{
    for (int i = 0; i < 4; i++) {
        float(*texel)[3];
        struct environment_map map = make_map(40, 20);
        for (int t = 0; t < 40 * 20 * 3; t++)
            (&map.texel[0][0])[t] = 7;
        struct environment_level level = fill(&map, (float)i * 0.33f, 1, &texel);
        for (size_t t = 0; t < (size_t)level.width * (level.height + 2) * 3; t++)
            assert_float_equal((&texel[0][0])[t], 7, 1e-4);
        mem_free(texel);
        free(map.texel);
    }
}

/* The rougher, the more even: what differs from the mean shrinks. */
static void test_monotone(void **state)
{
    struct environment_map map = make_map(64, 32);
    double before = INFINITY;
    for (int i = 0; i <= 10; i++) {
        float(*texel)[3];
        struct environment_level level = fill(&map, (float)i / 10, 2, &texel);
        double sum = 0, squares = 0, area = 0;
        for (uint32_t y = 0; y < level.height; y++)
            for (uint32_t x = 0; x < level.width; x++) {
                double a = sin(PI * (y + 0.5) / level.height);
                double v = (double)texel[(size_t)(y + 1) * level.width + x][2];
                area += a;
                sum += a * v;
                squares += a * v * v;
            }
        double variance = squares / area - sum * sum / (area * area);
        assert_true(variance < before);
        before = variance;
        mem_free(texel);
    }
    free(map.texel);
}

/* The pole rows hold their neighbour's mean; the sharp level is the map. */
static void test_poles(void **state)
{
    float(*texel)[3];
    struct environment_map map = make_map(16, 8);
    struct environment_level level = fill(&map, 0, 1, &texel);
    assert_true(level.width == 16 && level.height == 8);
    assert_memory_equal(texel + 16, map.texel, 16 * 8 * 12);
    for (int pole = 0; pole < 2; pole++)
        for (int k = 0; k < 3; k++) {
            double sum = 0;
            for (int x = 0; x < 16; x++)
                sum += (double)map.texel[(pole ? 7 * 16 : 0) + x][k];
            for (int x = 0; x < 16; x++)
                assert_float_equal(texel[(pole ? 9 * 16 : 0) + x][k], sum / 16, 1e-3);
        }
    mem_free(texel);
    free(map.texel);
}

static void test_threads(void **state)
{
    float(*one)[3], (*many)[3];
    struct environment_map map = make_map(64, 32);
    struct environment_level level = fill(&map, 0.25f, 1, &one);
    fill(&map, 0.25f, 7, &many);
    assert_memory_equal(one, many, (size_t)level.width * (level.height + 2) * 12);
    mem_free(one);
    mem_free(many);
    free(map.texel);
}

/* A scene of objects with these roughnesses. */
static struct stp_scene *make_scene(const float *roughness, unsigned count)
{
    struct stp_scene *scene = NULL;
    const double position[3][3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
    const float normal[3][3] = { { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } };
    const struct stp_points points = { .count = 3, .position = position, .normal = normal };
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    for (unsigned i = 0; i < count; i++) {
        const struct stp_optics optics = { .roughness = roughness[i] };
        const struct stp_object_params object = { .optics = &optics };
        assert_int_equal(stp_scene_add_points(NULL, scene, &points, &object), STP_OK);
    }
    return scene;
}

/* One level a roughness, shared; before prepare or after, the same bits. */
static void test_scenes(void **state)
{
    static const float roughness[] = { 0.5f, 0, 0.25f, 0.5f, -1 };
    struct environment_map map = make_map(20, 10);
    const struct stp_environment_params params = { .intensity = 3 };
    struct stp_scene *scene[2];
    for (int after = 0; after < 2; after++) {
        scene[after] = make_scene(roughness, 5);
        if (after)
            assert_int_equal(stp_scene_prepare(NULL, scene[after], NULL), STP_OK);
        assert_int_equal(stp_scene_set_environment(NULL, scene[after], 20, 10,
                                                   (const float(*)[3])map.texel, &params),
                         STP_OK);
        if (!after)
            assert_int_equal(stp_scene_prepare(NULL, scene[after], NULL), STP_OK);
        const struct scene_environment *e = &scene[after]->environment;
        const struct stp_facts *f = stp_scene_facts(scene[after]);
        assert_int_equal(e->level_count, 3);
        assert_true(f->environment_levels == 3 && f->environment_texels == e->texel_count);
        assert_true(f->reflects && !f->disperses && !f->mirrors && !f->between_levels);
        assert_true(environment_level_at(e, 0) == 0 && environment_level_at(e, 0.25f) == 1 &&
                    environment_level_at(e, 0.5f) == 2);
        assert_true(e->texel[20][0] == 3 * map.texel[0][0]);
    }
    const struct scene_environment *a = &scene[0]->environment, *b = &scene[1]->environment;
    assert_memory_equal(a->texel, b->texel, a->texel_count * 12);
    assert_int_equal(stp_scene_set_environment(NULL, scene[1], 0, 0, NULL, NULL), STP_OK);
    assert_true(scene[1]->facts.environment_levels == 0 && !scene[1]->facts.reflects);
    stp_scene_destroy(&scene[0]);
    stp_scene_destroy(&scene[1]);
    free(map.texel);
}

/* More roughnesses than levels: evenly spaced ones, and each material between two of them. */
static void test_many_roughnesses(void **state)
{
    float roughness[40];
    struct environment_map map = make_map(8, 4);
    for (int i = 0; i < 40; i++)
        roughness[i] = 0.2f + 0.02f * (float)i;
    struct stp_scene *scene = make_scene(roughness, 40);
    assert_int_equal(
        stp_scene_set_environment(NULL, scene, 8, 4, (const float(*)[3])map.texel, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    const struct scene_environment *e = &scene->environment;
    assert_true(e->level_count == ENVIRONMENT_LEVELS && scene->facts.between_levels);
    assert_true(e->level[1].roughness == roughness[0] &&
                fabsf(e->level[ENVIRONMENT_LEVELS - 1].roughness - roughness[39]) < 1e-6f);
    for (int i = 0; i < 40; i++) {
        float at = environment_level_at(e, roughness[i]), whole = floorf(at);
        unsigned k = (unsigned)whole;
        float low = e->level[k].roughness;
        float high = k + 1 < e->level_count ? e->level[k + 1].roughness : low;
        assert_float_equal(low + (high - low) * (at - whole), roughness[i], 1e-5);
    }
    stp_scene_destroy(&scene);
    free(map.texel);
}

static void test_refused(void **state)
{
    static const float none[1] = { 0 };
    const struct stp_optics bad[] = { { .ior = { 0.01f } },      { .ior = { -1 } },
                                      { .ior = { NAN } },        { .reflectance = { 0, 2 } },
                                      { .roughness = 1.5f },     { .absorption = { INFINITY } },
                                      { .thickness = -INFINITY } };
    unsigned errors = 0;
    struct stp_env env = { .log = count_errors, .user = &errors };
    struct stp_scene *scene = make_scene(none, 1);
    const float texel[1][3] = { { 1, 1, 1 } };
    const struct stp_environment_params turned = { .rotation = NAN }, dark = { .intensity = -1 };
    assert_int_equal(stp_scene_set_environment(&env, scene, 1, 1, texel, &turned),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_set_environment(&env, scene, 1, 1, texel, &dark),
                     STP_ERROR_ARGUMENT);
    assert_int_equal(stp_scene_set_environment(&env, scene, 20000, 1, texel, NULL),
                     STP_ERROR_FORMAT);
    assert_int_equal(stp_scene_load_environment(&env, scene, "/nowhere.exr", NULL), STP_ERROR_IO);
    assert_int_equal(errors, 4);
    const double position[1][3] = { { 0, 0, 0 } };
    const struct stp_points points = { .count = 1, .position = position };
    for (unsigned i = 0; i < sizeof bad / sizeof *bad; i++) {
        const struct stp_object_params object = { .optics = &bad[i] };
        assert_int_equal(stp_scene_add_points(&env, scene, &points, &object), STP_ERROR_ARGUMENT);
        assert_int_equal(errors, 5 + i);
    }
    stp_scene_destroy(&scene);
}

/* Each allocation fails in turn: one line, and the scene has what it had. */
static void test_memory(void **state)
{
    static const float roughness[] = { 0, 0.5f };
    struct environment_map map = make_map(64, 64), old = make_map(4, 2);
    struct stp_scene *scene = make_scene(roughness, 2);
    assert_int_equal(
        stp_scene_set_environment(NULL, scene, 4, 2, (const float(*)[3])old.texel, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    for (unsigned long n = 1;; n++) {
        unsigned errors = 0;
        struct stp_env env = { .log = count_errors, .user = &errors };
        mem_fail_at(n);
        enum stp_result result =
            stp_scene_set_environment(&env, scene, 64, 64, (const float(*)[3])map.texel, NULL);
        mem_fail_at(0);
        if (result == STP_OK) {
            assert_true(n > 4);
            break;
        }
        assert_true(result == STP_ERROR_MEMORY && errors == 1);
        assert_true(scene->environment.map.width == 4 && scene->facts.environment_levels == 2);
    }
    assert_int_equal(scene->environment.map.width, 64);
    stp_scene_destroy(&scene);
    free(map.texel);
    free(old.texel);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels),           cmocka_unit_test(test_even),
        cmocka_unit_test(test_monotone),         cmocka_unit_test(test_poles),
        cmocka_unit_test(test_threads),          cmocka_unit_test(test_scenes),
        cmocka_unit_test(test_many_roughnesses), cmocka_unit_test(test_refused),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
