/* A saved scene, loaded and prepared, is the scene that was saved: its objects, what was found of
 * each, and every splat, bit for bit. */
#include <stdio.h>
#include <unistd.h>

#include "base/memory.h"
#include "fitted.h"

static const char path[] = "test_saved_objects.ply";

struct part {
    surface_fn surface;
    double epsilon, shift;
    bool normals, color;
};

static void add(struct stp_scene *scene, const struct part *part, uint64_t seed)
{
    struct samples s = sample_surface(part->surface, 1500, seed);
    float(*color)[3] = calloc(s.count, sizeof *color);
    for (size_t i = 0; i < s.count; i++) {
        s.position[i][0] += part->shift;
        color[i][seed % 3] = (float)random_unit(&seed);
    }
    const struct stp_points points = { .count = s.count,
                                       .position = (const double(*)[3])s.position,
                                       .normal = part->normals ? (const float(*)[3])s.normal : NULL,
                                       .color = part->color ? (const float(*)[3])color : NULL };
    const struct stp_object_params object = { .epsilon = part->epsilon };
    assert_int_equal(stp_scene_add_points(NULL, scene, &points, &object), STP_OK);
    free(color);
    samples_release(&s);
}

static struct stp_scene *scene_with(const struct part *parts, unsigned count)
{
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    for (unsigned i = 0; i < count; i++)
        add(scene, &parts[i], i + 1);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    return scene;
}

static struct stp_scene *loaded(const struct stp_load_params *params)
{
    struct stp_scene *scene;
    assert_int_equal(stp_scene_load(NULL, path, params, &scene), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    return scene;
}

static void same(const void *a, const void *b, size_t size)
{
    assert_true(!a == !b);
    if (a)
        assert_memory_equal(a, b, size);
}

static void same_scene(const struct stp_scene *a, const struct stp_scene *b)
{
    const struct splats *s = &a->splats, *t = &b->splats;
    assert_int_equal(s->count, t->count);
    same(s->position, t->position, s->count * sizeof *s->position);
    same(s->normal, t->normal, s->count * sizeof *s->normal);
    same(s->radius, t->radius, s->count * sizeof *s->radius);
    same(s->color, t->color, s->count * sizeof *s->color);
    same(s->object, t->object, s->count * sizeof *s->object);
    for (size_t i = 0; s->phong && i < s->count; i++)
        assert_true(phong_equal(&s->phong[i], &t->phong[i]));
    assert_int_equal(a->object_count, b->object_count);
    for (unsigned i = 0; i < a->object_count; i++) {
        assert_true(a->objects[i].epsilon == b->objects[i].epsilon);
        assert_int_equal(a->objects[i].estimated, b->objects[i].estimated);
    }
    assert_int_equal(a->facts.two_sided, b->facts.two_sided);
    assert_int_equal(a->facts.normals, b->facts.normals);
    assert_memory_equal(a->core, b->core, sizeof a->core);
}

static void round_trip(struct stp_scene *scene)
{
    assert_int_equal(stp_scene_save(NULL, scene, path), STP_OK);
    struct stp_scene *again = loaded(NULL);
    same_scene(scene, again);
    stp_scene_destroy(&again);
    unlink(path);
}

/* The epsilon of a fit is no median radius. */
static void fits(void **state)
{
    struct samples s = sample_surface(on_torus, 20000, 1);
    struct stp_fit fit;
    struct stp_scene *scene = fitted(&s, 0.01, &fit);
    assert_true(scene->objects[0].epsilon < 0.6 * (double)scene->facts.radius_median);
    round_trip(scene);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

static void several_objects(void **state)
{
    static const struct part parts[] = { { on_sphere, 0, 0, true, false },
                                         { on_torus, 0.123456789, 0.5, true, true },
                                         { on_sphere, 0, 1, false, false } };
    for (unsigned count = 1; count <= 3; count++) {
        struct stp_scene *scene = scene_with(parts + 3 - count, count);
        assert_true(scene->facts.two_sided && scene->objects[count - 1].estimated);
        assert_true(count == 1 || !scene->objects[0].estimated);
        round_trip(scene);
        stp_scene_destroy(&scene);
    }
}

/* Objects of which nothing is left keep their number. */
static void empty_objects(void **state)
{
    static const struct part parts[] = { { on_sphere, 0, 9, true, false },
                                         { on_sphere, 0, 0, true, false },
                                         { on_sphere, 0.5, 9, true, false } };
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    for (unsigned i = 0; i < 3; i++)
        add(scene, &parts[i], i + 1);
    const struct stp_prepare_params params = { .clip_box =
                                                   (const double[]){ -2, -2, -2, 2, 2, 2 } };
    assert_int_equal(stp_scene_prepare(NULL, scene, &params), STP_OK);
    assert_int_equal(scene->splats.object[0], 1);
    round_trip(scene);
    stp_scene_destroy(&scene);
}

/* What the caller says of epsilon holds, and a scene's transform scales what the file says. */
static void who_says_epsilon(void **state)
{
    static const char json[] = "test_saved_objects.json";
    static const struct part parts[] = { { on_sphere, 0.25, 0, true, false },
                                         { on_torus, 0.125, 0, true, false } };
    struct stp_scene *scene = scene_with(parts, 2), *again;
    assert_int_equal(stp_scene_save(NULL, scene, path), STP_OK);
    stp_scene_destroy(&scene);
    again = loaded(&(struct stp_load_params){ .epsilon = 7 });
    assert_true(again->objects[0].epsilon == 7 && again->objects[1].epsilon == 7);
    stp_scene_destroy(&again);
    FILE *out = fopen(json, "w");
    assert_non_null(out);
    fprintf(out, "{\"points\":[{\"file\":\"%s\",\"transform\":[2,0,0,1,0,2,0,1,0,0,2,1,0,0,0,1]}]}",
            path);
    assert_int_equal(fclose(out), 0);
    assert_int_equal(stp_scene_load(NULL, json, NULL, &again), STP_OK);
    assert_int_equal(again->object_count, 2);
    assert_true(again->objects[0].epsilon == 0.5 && again->objects[1].epsilon == 0.25);
    stp_scene_destroy(&again);
    unlink(json);
    unlink(path);
}

/* A cloud that stays in its file has the same epsilon; several objects are read whole. */
static void streams(void **state)
{
    static const struct part parts[] = { { on_sphere, 0.25, 0, false, false },
                                         { on_torus, 0.125, 0, true, false } };
    for (unsigned count = 1; count <= 2; count++) {
        char line[4096] = "";
        const struct stp_env env = { .log = silent, .user = line };
        struct stp_scene *scene = scene_with(parts, count), *again;
        assert_int_equal(stp_scene_save(NULL, scene, path), STP_OK);
        const struct stp_load_params params = { .stream_above = 100 };
        assert_int_equal(stp_scene_load(&env, path, &params, &again), STP_OK);
        assert_int_equal(stp_scene_prepare(&env, again, NULL), STP_OK);
        assert_int_equal(again->stream != NULL, count == 1);
        assert_int_equal(strstr(line, "it holds several objects") != NULL, count == 2);
        assert_int_equal(again->object_count, count);
        assert_true(again->objects[0].epsilon == 0.25);
        assert_int_equal(again->facts.two_sided, scene->facts.two_sided);
        assert_int_equal(again->facts.normals, scene->facts.normals);
        stp_scene_destroy(&scene);
        stp_scene_destroy(&again);
    }
    unlink(path);
}

static void no_memory(void **state)
{
    static const struct part parts[] = { { on_sphere, 0.25, 0, true, true },
                                         { on_torus, 0.125, 0, true, false } };
    struct stp_scene *scene = scene_with(parts, 2), *again = NULL;
    assert_int_equal(stp_scene_save(NULL, scene, path), STP_OK);
    const struct stp_env env = { .log = silent, .threads = 1 };
    unsigned long n = 1;
    for (bool reached = true; reached; n++) {
        mem_fail_at(n);
        enum stp_result result = stp_scene_load(&env, path, NULL, &again);
        reached = mem_count() >= n;
        mem_fail_at(0);
        if (result == STP_OK)
            stp_scene_destroy(&again);
        else
            assert_int_equal(result, STP_ERROR_MEMORY);
        assert_null(again);
    }
    assert_true(n > 15);
    stp_scene_destroy(&scene);
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fits),          cmocka_unit_test(several_objects),
        cmocka_unit_test(empty_objects), cmocka_unit_test(who_says_epsilon),
        cmocka_unit_test(streams),       cmocka_unit_test(no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
