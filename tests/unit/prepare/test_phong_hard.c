/* Samples that leave a fit open, or that a careless one would mix up. */
#include "fitted.h"

#include "base/memory.h"

static struct samples make(size_t count)
{
    return (struct samples){ count, calloc(count, sizeof(double[3])),
                             calloc(count, sizeof(float[3])) };
}

static void set(struct samples *s, size_t i, double x, double y, double z, double nx, double ny,
                double nz)
{
    double p[3] = { x, y, z }, n[3] = { nx, ny, nz };
    for (int axis = 0; axis < 3; axis++) {
        s->position[i][axis] = p[axis];
        s->normal[i][axis] = (float)n[axis];
    }
}

static void is_sound(const struct splats *s)
{
    for (size_t i = 0; i < s->count; i++) {
        struct at_splat at = locate(s, i, s->position[i]);
        assert_true(s->radius[i] > 0 && isfinite(s->radius[i]) && at.covered);
        assert_true(isfinite(at.normal[0]) && isfinite(at.normal[1]) && isfinite(at.normal[2]));
    }
}

/* One, two and three samples on a line, whose normals lean along it. */
static void few_samples(void **state)
{
    for (size_t count = 1; count <= 3; count++)
        for (double tolerance = 0; tolerance < 2; tolerance += 0.5) {
            struct samples s = make(count);
            struct stp_fit fit;
            for (size_t i = 0; i < count; i++)
                set(&s, i, (double)i, 0, 0, 0.3 * (double)i, 0, 1);
            struct stp_scene *scene = fitted(&s, tolerance, &fit);
            is_sound(&scene->splats);
            covers_all(&scene->splats, &s, tolerance, false);
            assert_int_equal(fit.splats, tolerance == 0 ? count : 1);
            stp_scene_destroy(&scene);
            samples_release(&s);
        }
}

/* Each sample three times: as few splats as of one each, and a heap of one place is one splat. */
static void duplicates(void **state)
{
    struct samples once = sample_surface(on_sphere, 1000, 4), thrice = make(3000), heap = make(500);
    struct stp_fit a, b, c;
    for (size_t i = 0; i < 3000; i++) {
        memcpy(thrice.position[i], once.position[i % 1000], sizeof once.position[0]);
        memcpy(thrice.normal[i], once.normal[i % 1000], sizeof once.normal[0]);
    }
    for (size_t i = 0; i < 500; i++)
        set(&heap, i, 1, 2, 3, 0, 1, 0);
    struct stp_scene *scene = fitted(&once, 0.01, &a);
    stp_scene_destroy(&scene);
    scene = fitted(&thrice, 0.01, &b);
    covers_all(&scene->splats, &thrice, 0.01, false);
    assert_int_equal(a.splats, b.splats);
    stp_scene_destroy(&scene);
    scene = fitted(&heap, 0.01, &c);
    is_sound(&scene->splats);
    assert_int_equal(c.splats, 1);
    stp_scene_destroy(&scene);
    samples_release(&once);
    samples_release(&thrice);
    samples_release(&heap);
}

/* Ruffled sheets with up to five samples a place, whose normals lean any way by up to 80 degrees:
 * a place is several sites, and a patch about one of them may hold another without it. */
static void crowded_places(void **state)
{
    struct samples s = make(240);
    struct stp_fit fit;
    uint64_t dice = 7;
    for (int round = 0; round < 60; round++) {
        for (size_t i = 0; i < s.count; i++) {
            double away = 6.28318 * random_unit(&dice), lean = 1.4 * random_unit(&dice);
            set(&s, i, 10 * random_unit(&dice), 10 * random_unit(&dice), 0.1 * random_unit(&dice),
                cos(away) * sin(lean), sin(away) * sin(lean), cos(lean));
            if (i > 0 && random_unit(&dice) < 0.5)
                memcpy(s.position[i], s.position[i - 1], sizeof s.position[0]);
        }
        double tolerance = 1e-4 * pow(10, 0.5 * (round % 9));
        struct stp_scene *scene = fitted(&s, tolerance, &fit);
        is_sound(&scene->splats);
        covers_all(&scene->splats, &s, tolerance, true);
        stp_scene_destroy(&scene);
    }
    samples_release(&s);
}

/* Two sheets that look away from each other, nearer than the samples of one: no splat holds both,
 * for the normal of each splat is that of its sheet. */
static void thin_sheets(void **state)
{
    for (double apart = 0; apart < 0.1; apart += 0.005) {
        struct samples s = make(2000);
        uint64_t seed = 5;
        for (size_t i = 0; i < 1000; i++) {
            double x = random_unit(&seed), y = random_unit(&seed);
            set(&s, 2 * i, x, y, 0, 0, 0, 1);
            if (apart > 0) {
                x = random_unit(&seed);
                y = random_unit(&seed);
            }
            set(&s, 2 * i + 1, x, y, -apart, 0, 0, -1);
        }
        struct stp_fit fit;
        struct stp_scene *scene = fitted(&s, 0.2, &fit);
        assert_true(fit.signs || apart < 0.02);
        covers_all(&scene->splats, &s, 0.2, !fit.signs);
        for (size_t i = 0; i < scene->splats.count && fit.signs; i++) {
            assert_true(fabsf(scene->splats.normal[i][2]) > 0.999f);
            double z = scene->splats.position[i][2];
            assert_float_equal(z, scene->splats.normal[i][2] > 0 ? 0 : -apart, 1e-6);
        }
        stp_scene_destroy(&scene);
        samples_release(&s);
    }
}

/* A flat square: splats reach over its border by a few spacings at most. */
static void open_border(void **state)
{
    struct samples s = sample_surface(on_plane, 4000, 15);
    struct stp_scene *scene = fitted(&s, 0.01, NULL);
    const struct splats *p = &scene->splats;
    double over = 0;
    for (size_t i = 0; i < p->count; i++)
        for (int axis = 0; axis < 3; axis += 2) {
            double r = (double)p->radius[i];
            over = fmax(over, fmax(p->position[i][axis] + r - 1, r - p->position[i][axis]));
        }
    assert_true(over < 0.35);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

/* Bumps within the tolerance, with sides of 85 degrees: fields stay finite, and within a right
 * angle of the samples' normals where they cover them. */
static void steep_normals(void **state)
{
    struct samples s = make(2500);
    for (size_t i = 0; i < 2500; i++) {
        double x = (double)(i % 50) / 50, y = (double)(i / 50) / 50;
        double tilt = 85 * PI / 180 * sin(40 * x) * cos(31 * y);
        set(&s, i, x, y, 0.001 * sin(90 * x * y), sin(tilt), 0, cos(tilt));
    }
    for (double tolerance = 0.0005; tolerance < 1; tolerance *= 20) {
        struct stp_scene *scene = fitted(&s, tolerance, NULL);
        is_sound(&scene->splats);
        covers_all(&scene->splats, &s, tolerance, true);
        stp_scene_destroy(&scene);
    }
    samples_release(&s);
}

/* A unit cube, each face a grid of so many samples a side, which start half a step from the edges.
 */
static struct samples cube(size_t side)
{
    struct samples s = make(6 * side * side);
    size_t at = 0;
    for (int face = 0; face < 6; face++)
        for (size_t i = 0; i < side * side; i++) {
            double p[3], n[3] = { 0 }, step = 1 / (double)side;
            double a = ((double)(i % side) + 0.5) * step, b = ((double)(i / side) + 0.5) * step;
            p[face / 2] = face % 2;
            p[(face / 2 + 1) % 3] = a;
            p[(face / 2 + 2) % 3] = b;
            n[face / 2] = face % 2 ? 1 : -1;
            set(&s, at++, p[0], p[1], p[2], n[0], n[1], n[2]);
        }
    return s;
}

static double out_of_cube(const double p[3])
{
    double most = 0;
    for (int axis = 0; axis < 3; axis++)
        most = fmax(most, fmax(p[axis] - 1, -p[axis]));
    return most;
}

/* How far a splat sticks out of the solid anywhere, in its kept part. */
static double sticks_out(const struct splats *s, size_t i, double (*out_of)(const double p[3]))
{
    double most = 0;
    for (int k = 0; k < 3600; k++) {
        const struct stp_phong_splat *p = &s->phong[i];
        double r = sqrt((k % 10 + 0.99) / 10), angle = 2 * PI * k / 3600, q[3];
        double u[3], n[3], c = r * cos(angle) * (double)p->radius[0],
                           d = r * sin(angle) * (double)p->radius[1];
        for (int axis = 0; axis < 3; axis++) {
            u[axis] = (double)p->u[axis];
            n[axis] = (double)s->normal[i][axis];
        }
        double v[3] = { n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2],
                        n[0] * u[1] - n[1] * u[0] };
        for (int axis = 0; axis < 3; axis++)
            q[axis] = s->position[i][axis] + c * u[axis] + d * v[axis];
        if (!locate(s, i, q).covered)
            continue;
        most = fmax(most, out_of(q));
    }
    return most;
}

/* Clipped at the edges, splats end where the faces meet, and each keeps its face's normal. */
static void cube_keeps_its_edges(void **state)
{
    struct samples s = cube(30);
    struct stp_points points = { .count = s.count,
                                 .position = (const double(*)[3])s.position,
                                 .normal = (const float(*)[3])s.normal };
    double out[2] = { 0, 0 };
    for (int smooth = 0; smooth < 2; smooth++) {
        struct stp_fit_params params = { .tolerance = 0.01, .smooth = smooth == 1 };
        struct stp_fit fit;
        struct stp_scene *scene = scene_of(NULL, &points);
        assert_int_equal(stp_scene_fit(NULL, scene, &params, &fit), STP_OK);
        covers_all(&scene->splats, &s, 0.01, false);
        assert_true(smooth ? fit.clipped == 0 : fit.clipped > 6);
        for (size_t i = 0; i < scene->splats.count; i++) {
            out[smooth] = fmax(out[smooth], sticks_out(&scene->splats, i, out_of_cube));
            struct at_splat at = locate(&scene->splats, i, scene->splats.position[i]);
            double most = fmax(fmax(fabs(at.normal[0]), fabs(at.normal[1])), fabs(at.normal[2]));
            assert_true(smooth || most > cos(1 * PI / 180));
        }
        stp_scene_destroy(&scene);
    }
    assert_true(out[1] > 0.1);
    assert_true(out[0] < 1e-6);
    samples_release(&s);
}

static double out_of_cylinder(const double p[3])
{
    return fmax(p[2] - 1, hypot(p[0], p[1]) - 1);
}

/* The wall and the lid of a cylinder: what covers the lid ends at a bent edge, which lines follow
 * piece by piece. */
static void lid_keeps_its_bent_edge(void **state)
{
    const size_t count = 9000;
    struct samples s = make(count);
    struct stp_fit fit;
    uint64_t dice = 11;
    for (size_t i = 0; i < count; i++) {
        double r = i % 3 ? 1 : sqrt(random_unit(&dice)), angle = 2 * PI * random_unit(&dice);
        double x = cos(angle), y = sin(angle);
        if (i % 3)
            set(&s, i, x, y, random_unit(&dice), x, y, 0);
        else
            set(&s, i, r * x, r * y, 1, 0, 0, 1);
    }
    struct stp_scene *scene = fitted(&s, 0.002, &fit);
    double most = 0;
    covers_all(&scene->splats, &s, 0.002, false);
    for (size_t i = 0; i < scene->splats.count; i++)
        if (fabs((double)scene->splats.normal[i][2]) > 0.9)
            most = fmax(most, sticks_out(&scene->splats, i, out_of_cylinder));
    assert_true(fit.clipped > 10);
    assert_true(most < 0.02); /* half the distance to a sample's 6th neighbour */
    stp_scene_destroy(&scene);
    samples_release(&s);
}

/* A smooth, strongly bent surface has no sharp features. */
static void torus_is_not_sharp(void **state)
{
    struct samples s = sample_surface(on_torus, 3000, 9);
    struct stp_fit fit;
    struct stp_scene *scene = fitted(&s, 0.02, &fit);
    assert_int_equal(fit.clipped, 0);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

/* Two halves of two colours: each splat has one of them, whatever the tolerance of distance. */
static void colors_do_not_mix(void **state)
{
    struct samples s = sample_surface(on_plane, 2000, 25);
    float(*color)[3] = calloc(s.count, sizeof *color);
    for (size_t i = 0; i < s.count; i++)
        for (int c = 0; c < 3; c++)
            color[i][c] = s.position[i][0] < 0.5 ? 0.2f : 0.8f;
    struct stp_points points = { .count = s.count,
                                 .position = (const double(*)[3])s.position,
                                 .normal = (const float(*)[3])s.normal,
                                 .color = (const float(*)[3])color };
    for (int loose = 0; loose < 2; loose++) {
        struct stp_fit_params params = { .tolerance = 1, .color = loose ? 1 : 0 };
        struct stp_scene *scene = scene_of(NULL, &points);
        size_t mixed = 0;
        assert_int_equal(stp_scene_fit(NULL, scene, &params, NULL), STP_OK);
        for (size_t i = 0; i < scene->splats.count; i++) {
            float c = scene->splats.color[i][1];
            mixed += fabsf(c - 0.2f) > 1e-6f && fabsf(c - 0.8f) > 1e-6f;
        }
        assert_true(loose ? mixed > 0 : mixed == 0);
        stp_scene_destroy(&scene);
    }
    free(color);
    samples_release(&s);
}

/* Every allocation of a fit at edges and corners fails in turn, and some of a search for a count:
 * the scene stays as it was, and one line says so. */
static void edges_survive_every_failure(void **state)
{
    const struct stp_fit_params params[] = { { .tolerance = 0.05 }, { .count = 100 } };
    struct samples s = cube(6);
    struct stp_points points = { .count = s.count,
                                 .position = (const double(*)[3])s.position,
                                 .normal = (const float(*)[3])s.normal };
    for (int way = 0; way < 2; way++) {
        char line[256];
        struct stp_env env = { .threads = 1, .log = silent, .user = line };
        struct stp_scene *scene = scene_of(NULL, &points);
        struct stp_fit fit = { 0 };
        enum stp_result result = STP_ERROR_MEMORY;
        unsigned long n = 1;
        for (; result != STP_OK; n += way == 0 ? 1 : 97) { /* the search: every 97th */
            line[0] = 0;
            mem_fail_at(n);
            result = stp_scene_fit(&env, scene, &params[way], &fit);
            mem_fail_at(0);
            if (result == STP_OK)
                break;
            assert_int_equal(result, STP_ERROR_MEMORY);
            assert_true(strlen(line) > 0);
            assert_int_equal(scene->splats.count, s.count);
            assert_null(scene->splats.phong);
            assert_int_equal(fit.splats, 0);
        }
        assert_true(n > 100);
        assert_true(fit.clipped > 6);
        stp_scene_destroy(&scene);
    }
    samples_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_samples),
        cmocka_unit_test(duplicates),
        cmocka_unit_test(crowded_places),
        cmocka_unit_test(thin_sheets),
        cmocka_unit_test(open_border),
        cmocka_unit_test(steep_normals),
        cmocka_unit_test(cube_keeps_its_edges),
        cmocka_unit_test(torus_is_not_sharp),
        cmocka_unit_test(colors_do_not_mix),
        cmocka_unit_test(lid_keeps_its_bent_edge),
        cmocka_unit_test(edges_survive_every_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
