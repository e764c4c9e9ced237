/* Ellipses from points to prepared splats, to a file and back. */
#include "clouds.h"

#include <stdio.h>
#include <unistd.h>

#include "base/memory.h"
#include "scene/phong.h"
#include "scene/scene.h"

#define COUNT 300

struct ellipses {
    double position[COUNT][3];
    float normal[COUNT][3];
    struct stp_phong_splat phong[COUNT];
};

static void random_direction(uint64_t *seed, double d[3])
{
    on_sphere(random_unit(seed), random_unit(seed), d, d);
}

/* Every fourth lies on one point with one normal, so that only the ellipses order them. */
static void make_ellipses(struct ellipses *e, uint64_t seed)
{
    for (size_t i = 0; i < COUNT; i++) {
        struct stp_phong_splat *p = &e->phong[i];
        double n[3] = { 0, 0, 1 }, a[3], d[3] = { 0 };
        for (int k = 0; k < 3 && i % 4; k++)
            d[k] = random_unit(&seed);
        if (i % 4)
            random_direction(&seed, n);
        random_direction(&seed, a);
        double along = a[0] * n[0] + a[1] * n[1] + a[2] * n[2], length = sqrt(1 - along * along);
        *p = (struct stp_phong_splat){ 0 };
        for (int k = 0; k < 3; k++) {
            e->position[i][k] = d[k];
            e->normal[i][k] = (float)n[k];
            p->u[k] = (float)((a[k] - along * n[k]) / length);
        }
        for (int k = 0; k < 2; k++)
            p->radius[k] = (float)exp(3 * random_unit(&seed) - 4);
        for (int k = 0; k < 4; k++)
            p->field[k] = (float)(random_unit(&seed) - 0.5);
        p->clips = (uint8_t)(random_bits(&seed) % 3);
        p->reflex = p->clips == 2 && random_bits(&seed) % 2;
        for (int k = 0; k < p->clips; k++)
            for (int c = 0; c < 3; c++)
                p->clip[k][c] = (float)(random_unit(&seed) - 0.5);
    }
}

static struct stp_points points_of(const struct ellipses *e)
{
    return (struct stp_points){
        .count = COUNT, .position = e->position, .normal = e->normal, .phong = e->phong
    };
}

static struct stp_scene *prepared(const struct stp_points *points)
{
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    return scene;
}

static void same_splats(const struct stp_scene *a, const struct stp_scene *b, bool inputs)
{
    const struct splats *s = &a->splats, *t = &b->splats;
    assert_int_equal(s->count, t->count);
    assert_memory_equal(s->position, t->position, s->count * sizeof *s->position);
    assert_memory_equal(s->normal, t->normal, s->count * sizeof *s->normal);
    assert_memory_equal(s->radius, t->radius, s->count * sizeof *s->radius);
    for (size_t i = 0; i < s->count; i++) {
        assert_true(phong_equal(&s->phong[i], &t->phong[i]));
        assert_memory_equal(s->phong[i].u, t->phong[i].u, 60);
    }
    if (inputs)
        assert_memory_equal(s->input, t->input, s->count * sizeof *s->input);
}

/* Each splat is what was given, bit for bit: directions were unit and square already. */
static void kept_as_given(void **state)
{
    struct ellipses e;
    make_ellipses(&e, 1);
    struct stp_points points = points_of(&e);
    struct stp_scene *scene = prepared(&points);
    const struct splats *s = &scene->splats;
    size_t clipped = 0;
    for (size_t i = 0; i < COUNT; i++) {
        const struct stp_phong_splat *p = &s->phong[i], *given = &e.phong[s->input[i]];
        assert_true(phong_equal(p, given));
        assert_true(s->radius[i] == fmaxf(given->radius[0], given->radius[1]));
        clipped += given->clips > 0;
    }
    assert_int_equal(scene->facts.phong, COUNT);
    assert_int_equal(scene->facts.clip_lines, clipped);
    assert_int_equal(scene->facts.bad_phong, 0);
    assert_true(scene->facts.radius_max <= (float)exp(-1));
    stp_scene_destroy(&scene);
}

static void order_of_points_is_of_no_matter(void **state)
{
    struct ellipses e, shuffled;
    uint64_t seed = 5;
    make_ellipses(&e, 2);
    shuffled = e;
    for (size_t i = COUNT; i-- > 1;) {
        size_t j = random_bits(&seed) % (i + 1);
#define SWAP(member)                                                                               \
    do {                                                                                           \
        char temporary[sizeof shuffled.member[0]];                                                 \
        memcpy(temporary, &shuffled.member[i], sizeof temporary);                                  \
        memcpy(&shuffled.member[i], &shuffled.member[j], sizeof temporary);                        \
        memcpy(&shuffled.member[j], temporary, sizeof temporary);                                  \
    } while (0)
        SWAP(position);
        SWAP(normal);
        SWAP(phong);
    }
    struct stp_points one = points_of(&e), other = points_of(&shuffled);
    struct stp_scene *a = prepared(&one), *b = prepared(&other);
    same_splats(a, b, false);
    stp_scene_destroy(&a);
    stp_scene_destroy(&b);
}

static struct stp_scene *loaded(const struct stp_env *env, const char *path)
{
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_load(env, path, NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_prepare(env, scene, NULL), STP_OK);
    return scene;
}

static void file_reads_back(void **state)
{
    const char path[] = "test_phong_splats.ply";
    struct ellipses e;
    for (int clips = 0; clips < 2; clips++) {
        make_ellipses(&e, 3);
        for (size_t i = 0; i < COUNT && !clips; i++) {
            memset(e.phong[i].clip, 0, sizeof e.phong[i].clip);
            e.phong[i].clips = e.phong[i].reflex = 0;
        }
        struct stp_points points = points_of(&e);
        struct stp_scene *scene = prepared(&points), *again;
        assert_int_equal(stp_scene_save(NULL, scene, path), STP_OK);
        again = loaded(NULL, path);
        same_splats(scene, again, false);
        assert_int_equal(again->facts.clip_lines, scene->facts.clip_lines);
        stp_scene_destroy(&scene);
        stp_scene_destroy(&again);
    }
    unlink(path);
}

/* What cannot be an ellipse is the disc of its radius, or of one from the spacing. */
static void bad_ones_are_discs(void **state)
{
    struct ellipses e;
    float radius[COUNT];
    make_ellipses(&e, 4);
    for (size_t i = 0; i < COUNT; i++)
        radius[i] = 0.25f;
    e.phong[1].u[1] = NAN;
    memcpy(e.phong[2].u, e.normal[2], sizeof e.phong[2].u);
    e.phong[3].radius[1] = 0;
    e.phong[5].field[3] = INFINITY;
    e.phong[6].clips = 3;
    e.phong[7].clips = 1;
    e.phong[7].clip[0][2] = NAN;
    e.normal[9][0] = e.normal[9][1] = e.normal[9][2] = 0;
    memset(e.phong[10].u, 0, sizeof e.phong[10].u); /* asked for: not a fault */
    struct stp_points points = points_of(&e);
    points.radius = radius;
    struct stp_scene *scene = prepared(&points);
    assert_int_equal(scene->facts.bad_phong, 7);
    assert_int_equal(scene->facts.phong, COUNT - 8);
    for (size_t i = 0; i < COUNT; i++) {
        const struct stp_phong_splat *p = &scene->splats.phong[i];
        const float *n = scene->splats.normal[i];
        double length = 0, along = 0;
        for (int k = 0; k < 3; k++) {
            length += (double)p->u[k] * (double)p->u[k];
            along += (double)p->u[k] * (double)n[k];
        }
        assert_true(fabs(length - 1) < 1e-6 && fabs(along) < 1e-6);
        if (phong_is_plain(p))
            assert_true(p->radius[0] == 0.25f && scene->splats.radius[i] == 0.25f);
    }
    stp_scene_destroy(&scene);
}

/* Skew and long tangents are made what they stand for. */
static void tangents_are_straightened(void **state)
{
    struct stp_phong_splat p = { .u = { 3, 0, 4 }, .radius = { 1, 2 }, .clips = 1, .reflex = 1 };
    const float n[3] = { 0, 0, 1 };
    p.clip[1][0] = 7;
    assert_true(phong_clean(&p, n));
    assert_true(p.u[0] == 1 && p.u[1] == 0 && p.u[2] == 0);
    assert_true(p.clip[1][0] == 0 && p.reflex == 0);
    const double turn[16] = { 0, -2, 0, 5, 2, 0, 0, 6, 0, 0, 2, 7, 0, 0, 0, 1 };
    phong_transform(&p, turn, 2);
    assert_true(p.u[0] == 0 && p.u[1] == 1 && p.u[2] == 0);
    assert_true(p.radius[0] == 2 && p.radius[1] == 4);
}

/* Of any size that a float holds: the same directions and the same lines, of squares that float32
 * holds; and once is enough. */
static void extremes_are_scaled(void **state)
{
    static const float sizes[] = { 1e-40f, 1e-20f, 1, 1e14f, 1e20f, 3e38f };
    const float n[3] = { 0, 0, 1 };
    for (unsigned i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        float z = sizes[i];
        const struct stp_phong_splat given = { .u = { 1, 0, 0 },
                                               .radius = { 1, 2 },
                                               .field = { z, -z / 2, z / 8, 0 },
                                               .clip = { { z, z / 4, -z / 16 } },
                                               .clips = 1 };
        struct stp_phong_splat p = given, again;
        assert_true(phong_clean(&p, n));
        for (int k = 0; k < 4; k++)
            assert_true(isfinite(p.field[k] * p.field[k]) &&
                        p.field[k] / p.field[0] == given.field[k] / given.field[0]);
        for (int k = 0; k < 3; k++)
            assert_true(p.clip[0][k] / p.clip[0][0] == given.clip[0][k] / given.clip[0][0] &&
                        isnormal(p.clip[0][k]) && isfinite(p.clip[0][k] * p.clip[0][k]));
        assert_true(z > 1e15f || memcmp(p.field, given.field, sizeof p.field) == 0);
        assert_true(!(z > 1e-15f && z < 1e15f) || memcmp(&p, &given, sizeof p) == 0);
        again = p;
        assert_true(phong_clean(&again, n) && memcmp(&again, &p, sizeof p) == 0);
    }
}

/* Against the most over many points of the disc: never below, and hardly above. */
static void support_is_the_most(void **state)
{
    struct ellipses e;
    uint64_t seed = 11;
    make_ellipses(&e, 10);
    for (size_t i = 0; i < COUNT; i++) {
        const struct stp_phong_splat *p = &e.phong[i];
        double a = 2 * random_unit(&seed) - 1, b = 2 * random_unit(&seed) - 1, most = -INFINITY;
        for (int k = 0; k < 40000; k++) {
            double r = sqrt(k / 39999.0), s = r * cos(2.399963 * k), t = r * sin(2.399963 * k);
            unsigned kept = 0;
            for (int l = 0; l < p->clips; l++)
                kept += p->clip[l][0] * s + p->clip[l][1] * t + p->clip[l][2] >= 0;
            if (p->reflex ? kept > 0 : kept == p->clips)
                most = fmax(most, a * s + b * t);
        }
        double support = phong_support(p, a, b);
        assert_true(support >= most - 1e-9);
        assert_true(isinf(most) || support <= most + 0.05 || (p->clips == 2 && !p->reflex));
    }
}

static void discs_need_no_array(void **state)
{
    struct ellipses e;
    make_ellipses(&e, 6);
    for (size_t i = 0; i < COUNT; i++)
        e.phong[i] = phong_of_disc(e.normal[i], 0.1f);
    struct stp_points points = points_of(&e);
    struct stp_scene *scene = prepared(&points);
    assert_null(scene->splats.phong);
    assert_int_equal(scene->facts.phong, 0);
    assert_true(scene->splats.radius[7] == 0.1f);
    stp_scene_destroy(&scene);
}

static void discs_beside_ellipses(void **state)
{
    struct ellipses e;
    struct stp_scene *scene;
    float radius[COUNT];
    make_ellipses(&e, 7);
    for (size_t i = 0; i < COUNT; i++)
        radius[i] = 0.125f;
    struct stp_points points = points_of(&e), discs = points;
    discs.phong = NULL;
    discs.radius = radius;
    stp_scene_create(NULL, &scene);
    assert_int_equal(stp_scene_add_points(NULL, scene, &points, NULL), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, &discs, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    assert_int_equal(scene->facts.phong, COUNT);
    for (size_t i = 0; i < scene->splats.count; i++) {
        const struct stp_phong_splat *p = &scene->splats.phong[i];
        bool disc = scene->splats.object[i] == 1;
        assert_int_equal(phong_is_plain(p), disc);
        if (disc)
            assert_true(p->radius[0] == 0.125f);
        else
            assert_true(phong_equal(p, &e.phong[scene->splats.input[i]]));
    }
    stp_scene_destroy(&scene);
}

static void normals_are_needed(void **state)
{
    char line[512] = "";
    struct stp_env env = { .log = silent, .user = line };
    struct ellipses e;
    struct stp_scene *scene;
    make_ellipses(&e, 8);
    struct stp_points points = points_of(&e);
    points.normal = NULL;
    stp_scene_create(NULL, &scene);
    assert_int_equal(stp_scene_add_points(&env, scene, &points, NULL), STP_ERROR_ARGUMENT);
    assert_non_null(strstr(line, "normals"));
    stp_scene_destroy(&scene);
}

static void refused(const char *properties, unsigned numbers, const char *words)
{
    const char path[] = "test_phong_refused.ply";
    char line[512] = "";
    struct stp_env env = { .log = silent, .user = line };
    struct stp_scene *scene = NULL;
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "ply\nformat ascii 1.0\ncomment stipple prepared 1\nelement vertex 1\n"
                  "property double x\nproperty double y\nproperty double z\n");
    for (const char *at = properties; *at; at += strcspn(at, " "), at += *at == ' ')
        fprintf(file, "property float %.*s\n", (int)strcspn(at, " "), at);
    fprintf(file, "end_header\n0 0 0");
    for (unsigned i = 0; i < numbers; i++)
        fprintf(file, " 1");
    fprintf(file, "\n");
    fclose(file);
    assert_int_equal(stp_scene_load(&env, path, NULL, &scene), STP_ERROR_FORMAT);
    assert_non_null(strstr(line, words));
    unlink(path);
}

#define ELLIPSE "tangent_x tangent_y tangent_z radius_u radius_v field_0 field_1 field_2 field_3"
static void half_a_file_is_refused(void **state)
{
    refused("nx ny nz tangent_x tangent_y tangent_z radius_u radius_v field_0 field_1 field_2", 11,
            "lacks the property \"field_3\"");
    refused("nx ny nz " ELLIPSE " clip_count clip_reflex", 14, "lacks the property \"clip_0_a\"");
    refused("nx ny nz clip_0_a", 4, "lacks the property \"tangent_x\"");
    refused(ELLIPSE, 9, "lacks the property \"nx\"");
    refused("nx ny nz " ELLIPSE " field_4", 13, "unknown property \"field_4\"");
}

/* Every allocation on the way fails in turn. */
static enum stp_result whole_way(const struct stp_points *points, const char *path)
{
    struct stp_env env = { .log = silent };
    struct stp_scene *scene = NULL, *again = NULL;
    enum stp_result result = stp_scene_create(&env, &scene);
    if (result == STP_OK)
        result = stp_scene_add_points(&env, scene, points, NULL);
    if (result == STP_OK)
        result = stp_scene_add_points(&env, scene, points, NULL);
    if (result == STP_OK)
        result = stp_scene_prepare(&env, scene, NULL);
    if (result == STP_OK)
        result = stp_scene_save(&env, scene, path);
    if (result == STP_OK)
        result = stp_scene_load(&env, path, NULL, &again);
    stp_scene_destroy(&scene);
    stp_scene_destroy(&again);
    return result;
}

static void memory_runs_out(void **state)
{
    const char path[] = "test_phong_memory.ply";
    struct ellipses e;
    make_ellipses(&e, 9);
    struct stp_points points = points_of(&e);
    unsigned long n = 1;
    for (unsigned long reached = 1; reached; n++) {
        mem_fail_at(n);
        enum stp_result result = whole_way(&points, path);
        reached = mem_count() >= n;
        mem_fail_at(0);
        assert_int_equal(result, reached ? STP_ERROR_MEMORY : STP_OK);
    }
    assert_true(n > 30);
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kept_as_given),
        cmocka_unit_test(order_of_points_is_of_no_matter),
        cmocka_unit_test(file_reads_back),
        cmocka_unit_test(bad_ones_are_discs),
        cmocka_unit_test(tangents_are_straightened),
        cmocka_unit_test(extremes_are_scaled),
        cmocka_unit_test(support_is_the_most),
        cmocka_unit_test(discs_need_no_array),
        cmocka_unit_test(discs_beside_ellipses),
        cmocka_unit_test(normals_are_needed),
        cmocka_unit_test(half_a_file_is_refused),
        cmocka_unit_test(memory_runs_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
