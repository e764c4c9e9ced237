/* Ellipses, normal fields and clip lines: against Cramer's rule in the world, point by point, and
 * against analytic surfaces. */
#include "fixture.h"

#define SPLATS 40

struct ellipses {
    struct fixture *fixture;
    struct stp_phong_splat phong[MOST];
};

static struct ellipses *ellipses_create(double epsilon)
{
    struct ellipses *e = calloc(1, sizeof *e);
    assert_non_null(e);
    e->fixture = fixture_create(epsilon);
    e->fixture->scene.splats.phong = e->phong;
    return e;
}

static void ellipses_destroy(struct ellipses *e)
{
    free(e->fixture);
    free(e);
}

/* u is the direction nearest to `along`. */
static size_t add_ellipse(struct ellipses *e, struct vec3 p, struct vec3 n, struct vec3 along,
                          double radius_u, double radius_v)
{
    size_t i = add_splat(e->fixture, p, n, fmax(radius_u, radius_v));
    n = v3_unit(v3_loadf(e->fixture->normal[i]));
    struct vec3 u = v3_unit(v3_sub(along, v3_scale(n, v3_dot(along, n))));
    e->phong[i] = (struct stp_phong_splat){ .u = { (float)u.x, (float)u.y, (float)u.z },
                                            .radius = { (float)radius_u, (float)radius_v } };
    paint(e->fixture, i, 0.8f, 0.8f, 0.8f);
    return i;
}

static void fill(struct ellipses *e, uint32_t seed)
{
    for (size_t i = 0; i < SPLATS; i++) {
        struct vec3 p = random_point(&seed, 1), n = random_point(&seed, 1);
        double radius = 0.8 * uniform(&seed);
        size_t at = add_ellipse(e, p, n, random_point(&seed, 1), radius, radius * uniform(&seed));
        struct stp_phong_splat *s = &e->phong[at];
        for (int k = 0; k < 4; k++)
            s->field[k] = (float)(2 * uniform(&seed) - 1);
        s->clips = (uint8_t)(3 * uniform(&seed));
        s->reflex = s->clips == 2 && uniform(&seed) < 0.5;
        for (int k = 0; k < 6; k++)
            s->clip[k / 3][k % 3] = (float)(uniform(&seed) - 0.5);
    }
}

/* An evaluation in the world. */
struct place {
    double depth, s, t;
};

static double determinant(struct vec3 a, struct vec3 b, struct vec3 c)
{
    return v3_dot(a, v3_cross(b, c));
}

/* from + depth along = p + s ru u + t rv v */
static struct place solve(const struct ellipses *e, size_t i, struct vec3 from, struct vec3 along)
{
    const struct stp_phong_splat *s = &e->phong[i];
    struct vec3 n = v3_unit(v3_loadf(e->fixture->normal[i])), u = v3_unit(v3_loadf(s->u));
    struct vec3 a = v3_scale(u, s->radius[0]), b = v3_scale(v3_cross(n, u), s->radius[1]);
    struct vec3 right = v3_sub(from, v3_load(e->fixture->position[i]));
    struct vec3 back = v3_scale(along, -1);
    double d = determinant(a, b, back);
    return (struct place){ determinant(a, b, right) / d, determinant(right, b, back) / d,
                           determinant(a, right, back) / d };
}

static bool kept(const struct stp_phong_splat *s, const struct place *at)
{
    bool keeps[2];
    for (int k = 0; k < 2; k++)
        keeps[k] = s->clip[k][0] * at->s + s->clip[k][1] * at->t + s->clip[k][2] >= 0;
    switch (s->clips) {
    case 0:
        return true;
    case 1:
        return keeps[0];
    default:
        return s->reflex ? keeps[0] || keeps[1] : keeps[0] && keeps[1];
    }
}

static struct vec3 field(const struct ellipses *e, size_t i, double s, double t)
{
    const struct stp_phong_splat *p = &e->phong[i];
    struct vec3 n = v3_unit(v3_loadf(e->fixture->normal[i])), u = v3_unit(v3_loadf(p->u));
    n = v3_add(n, v3_scale(u, p->field[0] + p->field[1] * s));
    return v3_unit(v3_add(n, v3_scale(v3_cross(v3_unit(v3_loadf(e->fixture->normal[i])), u),
                                      p->field[2] + p->field[3] * t)));
}

static void world_ray(const struct stp_camera *c, uint32_t i, uint32_t j, struct vec3 *from,
                      struct vec3 *along)
{
    const double *m = c->world_to_camera;
    struct vec3 right = v3(m[0], m[1], m[2]), up = v3(m[4], m[5], m[6]),
                back = v3(m[8], m[9], m[10]);
    struct vec3 eye = v3_scale(
        v3_add(v3_add(v3_scale(right, m[3]), v3_scale(up, m[7])), v3_scale(back, m[11])), -1);
    double x = (i + 0.5 - c->cx) / c->fx, y = (c->cy - j - 0.5) / c->fy;
    struct vec3 side = v3_add(v3_scale(right, x), v3_scale(up, y)), ahead = v3_scale(back, -1);
    *from = c->orthographic ? v3_add(eye, side) : eye;
    *along = c->orthographic ? ahead : v3_add(ahead, side);
}

/* The nearest fragment's normal and weight; INFINITY: none. Nothing is culled. */
static struct place nearest(const struct ellipses *e, const struct stp_camera *camera, uint32_t i,
                            uint32_t j, size_t *id)
{
    struct place best = { .depth = INFINITY };
    struct vec3 from, along;
    world_ray(camera, i, j, &from, &along);
    for (size_t k = 0; k < e->fixture->scene.splats.count; k++) {
        struct place at = solve(e, k, from, along);
        bool inside = at.s * at.s + at.t * at.t <= 1 && kept(&e->phong[k], &at);
        if (inside && at.depth >= camera->near_depth && at.depth <= camera->far_depth &&
            at.depth < best.depth) {
            best = at;
            *id = k;
        }
    }
    return best;
}

static size_t compare_view(struct ellipses *e, int view)
{
    struct stp_camera camera = hard_view(view, 71, 45);
    struct stp_render_params params = exact_params();
    struct stp_image *image = render(e->fixture, &camera, &params);
    size_t covered = 0, id = 0;
    for (uint32_t j = 0; j < camera.height; j++)
        for (uint32_t i = 0; i < camera.width; i++) {
            struct place at = nearest(e, &camera, i, j, &id);
            assert_true(isfinite(at.depth) == (value(image, "A", i, j) == 1));
            if (!isfinite(at.depth))
                continue;
            struct vec3 n = field(e, id, at.s, at.t);
            covered++;
            assert_int_equal(id_at(image, i, j), 1000 + id);
            close_to(value(image, "Z", i, j), at.depth, 1e-6 * (1 + fabs(at.depth)));
            close_to(value(image, "weight", i, j), 1 - at.s * at.s - at.t * at.t, 3e-6);
            close_to(value(image, "N.X", i, j), n.x, 3e-6);
            close_to(value(image, "N.Y", i, j), n.y, 3e-6);
            close_to(value(image, "N.Z", i, j), n.z, 3e-6);
        }
    stp_image_destroy(&image);
    return covered;
}

/* Epsilon so small that only the nearest counts: its place and normal are the pixel's. u is at
 * right angles to n to float32 only, and two ways to span the plane differ by as much. */
static void test_views(void **state)
{
    for (int view = 0; view < VIEWS; view++) {
        struct ellipses *e = ellipses_create(1e-30);
        fill(e, 17 + (uint32_t)view);
        size_t covered = compare_view(e, view);
        assert_true(covered > 40 || view == 4 || view == 7);
        ellipses_destroy(e);
    }
}

/* Never culled while some normal of the field faces the eye; always when none comes near it. */
static void test_culling(void **state)
{
    size_t kept_back = 0, dropped = 0;
    for (int view = 0; view < VIEWS; view += 2) {
        struct ellipses *e = ellipses_create(0.01);
        struct stp_camera camera = hard_view(view, 31, 31);
        struct stp_render_params params = { .min_splat = -1, .cull = STP_CULL_BACK };
        fill(e, 5 + (uint32_t)view);
        struct view v = reference_view(&e->fixture->scene, &camera, &params);
        v.eye.near_depth = 1e-9;
        v.eye.far_depth = INFINITY;
        for (size_t i = 0; i < SPLATS; i++) {
            struct disc disc;
            struct vec3 from, along, p = v3_load(e->fixture->position[i]);
            double most = -INFINITY;
            world_ray(&camera, 0, 0, &from, &along);
            for (int k = 0; k < 4000; k++) {
                double r = sqrt(k / 4000.0), a = 2.399963 * k, s = r * cos(a), t = r * sin(a);
                const struct stp_phong_splat *ph = &e->phong[i];
                struct vec3 u = v3_loadf(ph->u), n = v3_loadf(e->fixture->normal[i]);
                struct vec3 q = v3_add(v3_scale(u, s * ph->radius[0]),
                                       v3_scale(v3_cross(n, u), t * ph->radius[1]));
                struct vec3 to_eye =
                    camera.orthographic ? v3_scale(along, -1) : v3_sub(from, v3_add(p, q));
                most = fmax(most, v3_dot(field(e, i, s, t), to_eye));
            }
            bool behind =
                camera.orthographic ? false : eye_point(&v.eye, e->fixture->position[i]).z > -1;
            bool drawn = disc_setup(&v, i, &disc);
            if (most > 1e-3 && !behind) {
                assert_true(drawn);
                kept_back +=
                    v3_dot(v3_loadf(e->fixture->normal[i]),
                           camera.orthographic ? v3_scale(along, -1) : v3_sub(from, p)) < 0;
            }
            dropped += !drawn && !behind;
        }
        ellipses_destroy(e);
    }
    assert_true(kept_back > 5 && dropped > 5);
}

/* Mean angle between the picture's normals and `truth` at their points. */
static double mean_angle(struct ellipses *e, struct vec3 (*truth)(struct vec3 p))
{
    struct stp_camera camera = plain_camera(160, 120, 170);
    look_at(&camera, v3(1.5, 2.5, 3.5), v3(0, 0, 0));
    struct stp_render_params params = exact_params();
    params.cull = STP_CULL_BACK;
    struct stp_image *image = render(e->fixture, &camera, &params);
    double sum = 0;
    size_t count = 0;
    for (uint32_t j = 0; j < 120; j++)
        for (uint32_t i = 0; i < 160; i++) {
            if (value(image, "A", i, j) == 0)
                continue;
            struct vec3 n =
                v3(value(image, "N.X", i, j), value(image, "N.Y", i, j), value(image, "N.Z", i, j));
            struct vec3 p =
                v3(value(image, "P.X", i, j), value(image, "P.Y", i, j), value(image, "P.Z", i, j));
            struct vec3 m = truth(p);
            sum += atan2(v3_length(v3_cross(n, m)), v3_dot(n, m));
            count++;
        }
    stp_image_destroy(&image);
    assert_true(count > 3000);
    return sum / (double)count;
}

/* Where curvatures are k_u, k_v along the principal directions, N turns by k r from the centre to
 * the end of an axis. */
static void curve(struct ellipses *e, size_t i, double k_u, double k_v, bool with_field)
{
    struct stp_phong_splat *s = &e->phong[i];
    s->field[1] = with_field ? (float)(k_u * s->radius[0]) : 0;
    s->field[3] = with_field ? (float)(k_v * s->radius[1]) : 0;
}

static struct vec3 sphere_normal(struct vec3 p)
{
    return v3_unit(p);
}

/* Tangent planes of a sphere, with the field r: the normal anywhere is that of the radius there. */
static void test_sphere(void **state)
{
    struct ellipses *e = ellipses_create(1e-30);
    uint32_t seed = 3;
    for (int i = 0; i < 300; i++) {
        double z = 1 - (2 * i + 1) / 300.0, ring = sqrt(1 - z * z), a = 2.399963 * i;
        struct vec3 n = v3(ring * cos(a), ring * sin(a), z);
        curve(e, add_ellipse(e, n, n, random_point(&seed, 1), 0.2, 0.15), 1, 1, true);
    }
    assert_true(mean_angle(e, sphere_normal) < 1e-6);
    ellipses_destroy(e);
}

static struct vec3 torus_normal(struct vec3 p)
{
    double ring = hypot(p.x, p.y), x = (ring - 1) / ring;
    return v3_unit(v3(p.x * x, p.y * x, p.z));
}

static struct ellipses *torus(int steps, bool with_field)
{
    struct ellipses *e = ellipses_create(1e-30);
    for (int i = 0; i < 2 * steps; i++)
        for (int j = 0; j < steps; j++) {
            double a = M_PI * (i + 0.5 * (j % 2)) / steps, b = 2 * M_PI * j / steps;
            struct vec3 n = v3(cos(b) * cos(a), cos(b) * sin(a), sin(b));
            struct vec3 p = v3_add(v3(cos(a), sin(a), 0), v3_scale(n, 0.4));
            struct vec3 along = v3(-sin(a), cos(a), 0);
            double big = 1 + 0.4 * cos(b), r = 2.9 / steps;
            size_t at = add_ellipse(e, p, n, along, r * big, r * 0.8);
            curve(e, at, cos(b) / big, 1 / 0.4, with_field);
        }
    return e;
}

#define SLOPE 0.5 /* of the cone: radius 1 - z / 2 */
static struct vec3 cone_normal(struct vec3 p)
{
    double ring = hypot(p.x, p.y);
    return v3_unit(v3(p.x / ring, p.y / ring, SLOPE));
}

static struct ellipses *cone(int steps, bool with_field)
{
    struct ellipses *e = ellipses_create(1e-30);
    for (int i = 0; i < 3 * steps; i++)
        for (int j = 0; j < steps; j++) {
            double a = 2 * M_PI * (i + 0.5 * (j % 2)) / (3 * steps), z = (j + 0.5) / steps;
            double ring = 1 - SLOPE * z;
            struct vec3 p = v3(ring * cos(a), ring * sin(a), z), n = cone_normal(p);
            size_t at =
                add_ellipse(e, p, n, v3(-sin(a), cos(a), 0), 1.7 / steps * ring, 0.8 / steps);
            curve(e, at, 1 / (ring * sqrt(1 + SLOPE * SLOPE)), 0, with_field);
        }
    return e;
}

/* Half the size: a quarter of the error, where constant normals keep a half. */
static void test_second_order(void **state)
{
    struct ellipses *(*const surface[2])(int, bool) = { torus, cone };
    struct vec3 (*const truth[2])(struct vec3) = { torus_normal, cone_normal };
    for (int k = 0; k < 2; k++) {
        double angle[2][2];
        for (int fine = 0; fine < 2; fine++)
            for (int with_field = 0; with_field < 2; with_field++) {
                struct ellipses *e = surface[k](fine ? 28 : 14, with_field);
                angle[fine][with_field] = mean_angle(e, truth[k]);
                ellipses_destroy(e);
            }
        assert_true(angle[0][1] < 0.2 * angle[0][0]);
        assert_true(angle[1][1] < 0.32 * angle[0][1]);
        assert_true(angle[1][0] > 0.4 * angle[0][0]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_views),
        cmocka_unit_test(test_culling),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_second_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
