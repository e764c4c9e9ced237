#include "clouds.h"

#include "prepare/bounds.h"
#include "prepare/radii.h"
#include "scene/scene.h"

static struct stp_scene *prepared(size_t count, const void *position, const void *normal,
                                  const float *radius)
{
    struct stp_points points = {
        .count = count, .position = position, .normal = normal, .radius = radius
    };
    struct stp_scene *scene;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    assert_int_equal(stp_scene_add_points(NULL, scene, &points, NULL), STP_OK);
    assert_int_equal(stp_scene_prepare(NULL, scene, NULL), STP_OK);
    return scene;
}

static bool is_covered(const struct splats *s, const double p[3])
{
    for (size_t i = 0; i < s->count; i++) {
        double x = s->position[i][0] - p[0], y = s->position[i][1] - p[1],
               z = s->position[i][2] - p[2], r = (double)s->radius[i];
        if (x * x + y * y + z * z <= r * r)
            return true;
    }
    return false;
}

/* Poisson-random points: no hole among 20000 probes, away from the border of the square. */
static void closes_a_plane(void **state)
{
    struct samples s = sample_surface(on_plane, 1500, 8);
    struct stp_scene *scene = prepared(s.count, s.position, NULL, NULL);
    uint64_t seed = 4;
    size_t holes = 0;
    for (int i = 0; i < 20000; i++) {
        double p[3] = { 0.05 + 0.9 * random_unit(&seed), 0.25, 0.05 + 0.9 * random_unit(&seed) };
        holes += !is_covered(&scene->splats, p);
    }
    assert_true(holes <= 1);
    assert_int_equal(stp_scene_facts(scene)->bad_radii, 0);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

/* Discs in the tangent planes, seen along rays from the middle. */
static void closes_a_sphere(void **state)
{
    struct samples s = sample_surface(on_sphere, 1500, 8);
    struct stp_scene *scene = prepared(s.count, s.position, NULL, NULL);
    const struct splats *p = &scene->splats;
    uint64_t seed = 6;
    size_t holes = 0;
    for (int i = 0; i < 10000; i++) {
        double d[3], n[3];
        bool covered = false;
        on_sphere(random_unit(&seed), random_unit(&seed), d, n);
        for (size_t j = 0; j < p->count && !covered; j++) {
            double nd = 0, np = 0, distance = 0, r = (double)p->radius[j];
            for (int axis = 0; axis < 3; axis++) {
                nd += (double)p->normal[j][axis] * d[axis];
                np += (double)p->normal[j][axis] * p->position[j][axis];
            }
            for (int axis = 0; axis < 3; axis++)
                distance += (d[axis] * np / nd - p->position[j][axis]) *
                            (d[axis] * np / nd - p->position[j][axis]);
            covered = nd > 0 && distance <= r * r;
        }
        holes += !covered;
    }
    assert_true(holes <= 1);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

/* Each point twice: the spacing is that of places, not of points. */
static void duplicates_do_not_shrink(void **state)
{
    struct samples s = sample_surface(on_plane, 1000, 8);
    double(*twice)[3] = calloc(2000, sizeof *twice);
    memcpy(twice, s.position, 1000 * sizeof *twice);
    memcpy(twice + 1000, s.position, 1000 * sizeof *twice);
    struct stp_scene *once = prepared(1000, s.position, NULL, NULL);
    struct stp_scene *both = prepared(2000, twice, NULL, NULL);
    for (size_t i = 0; i < 1000; i++)
        assert_true(both->splats.radius[2 * i] == once->splats.radius[i]);
    assert_int_equal(stp_scene_facts(both)->duplicates, 1000);
    stp_scene_destroy(&once);
    stp_scene_destroy(&both);
    free(twice);
    samples_release(&s);
}

static void outliers_are_no_plates(void **state)
{
    struct samples s = sample_surface(on_sphere, 3000, 8);
    s.position[7][0] = 1000;
    s.position[8][1] = 1001;
    struct stp_scene *scene = prepared(s.count, s.position, NULL, NULL);
    const struct stp_facts *facts = stp_scene_facts(scene);
    assert_int_equal(facts->outliers, 2);
    assert_true(facts->radius_max < 8 * facts->radius_median);
    assert_true(scene->core[3] < 10 && scene->core[4] < 10);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

static void given_ones_stay(void **state)
{
    struct samples s = sample_surface(on_sphere, 2000, 8);
    float radius[2000];
    uint64_t seed = 77;
    for (size_t i = 0; i < 2000; i++) /* 570 : 1, as in real meshes */
        radius[i] = (float)(0.001 * pow(570, random_unit(&seed)));
    struct stp_scene *scene = prepared(2000, s.position, s.normal, radius);
    for (size_t i = 0; i < 2000; i++) {
        uint32_t from = scene->splats.input[i];
        assert_memory_equal(&scene->splats.radius[i], &radius[from], sizeof(float));
        assert_memory_equal(scene->splats.position[i], s.position[from], sizeof(double[3]));
    }
    assert_int_equal(stp_scene_facts(scene)->bad_radii, 0);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

static void bad_ones_are_replaced(void **state)
{
    const float bad[6] = { 0, -1, NAN, INFINITY, 1e-30f, 50 /* monstrous */ };
    struct samples s = sample_surface(on_sphere, 2000, 8);
    float radius[2000];
    for (size_t i = 0; i < 2000; i++)
        radius[i] = i < 6 ? bad[i] : 0.05f;
    struct stp_scene *scene = prepared(2000, s.position, s.normal, radius);
    const struct stp_facts *facts = stp_scene_facts(scene);
    assert_int_equal(facts->bad_radii, 6);
    assert_int_equal(facts->normals, STP_NORMALS_GIVEN);
    for (size_t i = 0; i < 2000; i++) {
        float r = scene->splats.radius[i];
        assert_true(scene->splats.input[i] < 6 ? r > 0.02f && r < 0.3f : r == 0.05f);
    }
    stp_scene_destroy(&scene);
    samples_release(&s);
}

/* As large as a monster, but its surroundings are as sparse. */
static void large_among_sparse_stays(void **state)
{
    static double p[1025][3];
    static float n[1025][3], radius[1025];
    for (size_t i = 0; i < 1025; i++) {
        bool sparse = i >= 1000;
        size_t j = sparse ? i - 1000 : i;
        p[i][0] = sparse ? 100 + 10.0 * (double)(j % 5) : 0.1 * (double)(j % 32);
        p[i][2] = sparse ? 10.0 * (double)(j / 5) : 0.1 * (double)(j / 32);
        n[i][1] = 1;
        radius[i] = sparse ? 15 : 0.15f;
    }
    struct stp_scene *scene = prepared(1025, p, n, radius);
    assert_int_equal(stp_scene_facts(scene)->bad_radii, 0);
    assert_true(stp_scene_facts(scene)->radius_max == 15);
    stp_scene_destroy(&scene);
}

static void tiny_clouds(void **state)
{
    double p[6][3] = { { 1, 2, 3 }, { 2, 2, 3 },   { 1, 3, 3 },
                       { 2, 3, 3 }, { 1.5, 4, 3 }, { 1, 5, 3 } };
    for (size_t count = 1; count <= 6; count++) {
        struct stp_scene *scene = prepared(count, p, NULL, NULL);
        const struct stp_facts *facts = stp_scene_facts(scene);
        assert_true(facts->radius_min > 0.3f && facts->radius_max <= 2.3f);
        assert_true(scene->objects[0].epsilon > 0);
        assert_int_equal(facts->splats, count);
        stp_scene_destroy(&scene);
    }
}

static void coincident_points(void **state)
{
    static double p[200000][3];
    for (size_t i = 0; i < 200000; i++)
        p[i][0] = p[i][1] = p[i][2] = 6e6;
    struct stp_scene *scene = prepared(200000, p, NULL, NULL);
    const struct stp_facts *facts = stp_scene_facts(scene);
    assert_int_equal(facts->duplicates, 199999);
    assert_int_equal(facts->no_normal, 200000);
    assert_true(facts->radius_min > 0 && facts->radius_max < 100);
    assert_true(isfinite(facts->outwardness));
    stp_scene_destroy(&scene);
}

/* Heaps of 200 at each of 1000 places: spacing and normals are those of the places. */
static void heaps(void **state)
{
    struct samples s = sample_surface(on_sphere, 1000, 8);
    double(*heaped)[3] = calloc(200000, sizeof *heaped);
    for (size_t i = 0; i < 200000; i++)
        memcpy(heaped[i], s.position[i % 1000], sizeof heaped[i]);
    struct stp_scene *once = prepared(1000, s.position, NULL, NULL);
    struct stp_scene *many = prepared(200000, heaped, NULL, NULL);
    for (size_t i = 0; i < 200000; i++) {
        assert_true(many->splats.radius[i] == once->splats.radius[i / 200]);
        assert_memory_equal(many->splats.normal[i], once->splats.normal[i / 200], 12);
    }
    assert_int_equal(stp_scene_facts(many)->no_normal, 0);
    stp_scene_destroy(&once);
    stp_scene_destroy(&many);
    free(heaped);
    samples_release(&s);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static void selection(void **state)
{
    uint64_t seed = 2;
    for (size_t count = 1; count < 200; count++) {
        double v[200], sorted[200];
        size_t rank = random_bits(&seed) % count;
        for (size_t i = 0; i < count; i++)
            sorted[i] = v[i] = (double)(random_bits(&seed) % (count / 3 + 1));
        qsort(sorted, count, sizeof *sorted, ascending);
        assert_true(select_rank(v, count, rank) == sorted[rank]);
    }
}

static void median_of_good_ones(void **state)
{
    const float bad[5] = { NAN, 0, -3, INFINITY, 1e-30f };
    uint64_t seed = 2;
    for (size_t count = 0; count < 200; count++) {
        double sorted[200];
        float radius[200], median = -1;
        size_t good = 0;
        for (size_t i = 0; i < count; i++) {
            radius[i] = (float)exp(20 * random_unit(&seed) - 10);
            if (i % 3 == 0)
                radius[i] = bad[i / 3 % 5];
            else
                sorted[good++] = (double)radius[i];
        }
        qsort(sorted, good, sizeof *sorted, ascending);
        assert_int_equal(radii_median(NULL, radius, count, &median), STP_OK);
        assert_true((double)median == (good > 0 ? sorted[(good - 1) / 2] : 0));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closes_a_plane),
        cmocka_unit_test(closes_a_sphere),
        cmocka_unit_test(duplicates_do_not_shrink),
        cmocka_unit_test(outliers_are_no_plates),
        cmocka_unit_test(given_ones_stay),
        cmocka_unit_test(bad_ones_are_replaced),
        cmocka_unit_test(large_among_sparse_stays),
        cmocka_unit_test(tiny_clouds),
        cmocka_unit_test(coincident_points),
        cmocka_unit_test(heaps),
        cmocka_unit_test(selection),
        cmocka_unit_test(median_of_good_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
