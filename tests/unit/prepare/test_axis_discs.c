/* Lists of surface splats: where their fragments are, and which lists draw them, by the reference's
 * code at every pixel. */
#include "fixture.h"

#include "base/memory.h"
#include "prepare/axis_blocks.h"
#include "prepare/axis_region.h"

enum { W = 37, H = 29, SPLATS = 160 };

struct surface_scene {
    struct fixture *f;
    struct stp_phong_splat *phong; /* NULL: all are discs */
};

/* Discs, some of them ellipses with fields and clip lines, some transparent. */
static struct surface_scene make(uint32_t seed, bool bent)
{
    struct surface_scene s = { .f = fixture_create(0.05) };
    fill_randomly(s.f, seed, SPLATS);
    if (bent) {
        s.phong = calloc(SPLATS, sizeof *s.phong);
        assert_non_null(s.phong);
        s.f->scene.splats.phong = s.phong;
    }
    for (size_t i = 0; bent && i < SPLATS; i++) {
        struct stp_phong_splat *p = &s.phong[i];
        struct vec3 n = v3_loadf(s.f->normal[i]), any = random_point(&seed, 1);
        struct vec3 u = v3_unit(v3_cross(n, any));
        p->u[0] = (float)u.x;
        p->u[1] = (float)u.y;
        p->u[2] = (float)u.z;
        p->radius[i % 2] = s.f->radius[i];
        p->radius[1 - i % 2] = s.f->radius[i] * (float)pow(10, -1.5 * uniform(&seed));
        p->clips = (uint8_t)(3 * uniform(&seed));
        p->reflex = p->clips == 2 && uniform(&seed) < 0.5;
        for (int k = 0; k < p->clips; k++) {
            p->clip[k][0] = (float)(2 * uniform(&seed) - 1);
            p->clip[k][1] = (float)(2 * uniform(&seed) - 1);
            p->clip[k][2] = (float)(0.5 * uniform(&seed));
        }
        for (int k = 0; k < 4; k++)
            p->field[k] = (float)(uniform(&seed) - 0.5);
        if (i % 4 == 0)
            fade(s.f, i, i % 8 ? (float)uniform(&seed) : 0);
    }
    s.f->scene.facts.two_sided = seed % 2;
    return s;
}

static void destroy(struct surface_scene *s)
{
    free(s->phong);
    free(s->f);
}

/* Of a picture's views, half with the floor, half with back faces left out. */
static struct stp_render_params params_of(int v)
{
    return (struct stp_render_params){ .min_splat = v % 2 ? 2 + v : -1,
                                       .cull = v / 2 % 2 ? STP_CULL_BACK : STP_CULL_NONE };
}

static bool reference_hit(const struct view *view, const struct disc *disc, size_t id, uint32_t x,
                          uint32_t y)
{
    struct fragment fragment;
    struct ray ray = eye_ray(&view->eye, x + 0.5, y + 0.5);
    const float *opacity = view->scene->splats.opacity;
    return disc_hit(disc, &view->eye, &ray, x + 0.5, y + 0.5, &fragment) &&
           (opacity ? (double)opacity[id] : 1) * exp(-2 * fragment.rho2) >= 1e-4;
}

/* Every pixel, and the rectangle holds all that hit. */
static void same_fragments(void **state)
{
    size_t hits = 0, floored = 0;
    for (int v = 0; v < VIEWS; v++) {
        struct surface_scene s = make(100 + (uint32_t)v, v % 3 > 0);
        struct stp_camera camera = hard_view(v, W, H);
        struct stp_render_params params = params_of(v);
        struct view view = reference_view(&s.f->scene, &camera, &params);
        struct axis_view axis = axis_view(&s.f->scene, &camera);
        axis.disc_look = (struct axis_look){ view.cull_back, view.min_splat };
        for (uint32_t id = 0; id < SPLATS; id++) {
            struct disc disc;
            struct axis_kernel kernel;
            struct axis_rectangle r;
            bool theirs = disc_setup(&view, id, &disc);
            bool seen = axis_kernel(&axis, id, &kernel) && axis_pixels(&kernel, &r);
            floored += seen && kernel.disc.floored;
            for (uint32_t p = 0; p < W * H; p++) {
                uint32_t x = p % W, y = p / W;
                bool hit = theirs && reference_hit(&view, &disc, id, x, y);
                assert_true(!hit || (seen && x >= r.x0 && x <= r.x1 && y >= r.y0 && y <= r.y1));
                if (seen)
                    assert_int_equal(hit, axis_hits(&kernel, 0, x + 0.5, y + 0.5));
                hits += hit;
            }
        }
        destroy(&s);
    }
    assert_true(hits > 5000 && floored > 50);
}

/* The weight of a walk by Eq. 1, from the pixel's ray in the world. */
static double weight_of(const struct view *view, uint32_t x, uint32_t y, unsigned walk, double h)
{
    struct ray ray = eye_ray(&view->eye, x + 0.5, y + 0.5);
    struct vec3 v = eye_direction_to_world(&view->eye, ray.along);
    const double c[3] = { v.x, v.y, v.z };
    double most = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    return fmax((walk % 2 ? -c[walk / 2] : c[walk / 2]) / most - h, 0);
}

static bool weighs(const struct view *view, size_t id, unsigned walk, double h)
{
    struct disc disc;
    if (!disc_setup(view, id, &disc))
        return false;
    for (uint32_t p = 0; p < W * H; p++)
        if (weight_of(view, p % W, p / W, walk, h) > 0 &&
            reference_hit(view, &disc, id, p % W, p / W))
            return true;
    return false;
}

/* A splat is in a list exactly where that has a weight on a fragment of its; lists are in order
 * along their axis, of equal places the first splat last. */
static void expect_lists(const struct surface_scene *s, int v, double h)
{
    struct stp_camera camera = hard_view(v, W, H);
    struct stp_render_params params = params_of(v);
    struct view view = reference_view(&s->f->scene, &camera, &params);
    struct axis_lists lists = { .merge = STP_AXIS_BLEND,
                                .h = h,
                                .look = { view.cull_back, view.min_splat } };
    bool listed[SPLATS][AXIS_WALKS] = { { false } };
    assert_int_equal(axis_lists_update(NULL, &s->f->scene, &camera, &lists), STP_OK);
    for (unsigned w = 0; w < lists.walk_count; w++) {
        const struct axis_walk *walk = &lists.walk[w];
        const uint32_t *order = lists.order + walk->first;
        for (uint32_t i = 0; i < walk->count; i++) {
            assert_false(listed[order[i]][axis_walk_bit(walk)]);
            listed[order[i]][axis_walk_bit(walk)] = true;
            if (i == 0)
                continue;
            double a = s->f->position[order[i - 1]][walk->axis];
            double b = s->f->position[order[i]][walk->axis];
            assert_true(walk->backwards ? a <= b : a >= b);
        }
    }
    for (size_t id = 0; id < SPLATS; id++)
        for (unsigned walk = 0; walk < AXIS_WALKS; walk++)
            assert_int_equal(listed[id][walk], weighs(&view, id, walk, h));
    axis_lists_release(&lists);
}

static void exactly_what_weighs(void **state)
{
    for (int v = 0; v < VIEWS; v++) {
        struct surface_scene s = make(300 + (uint32_t)v, v % 2);
        expect_lists(&s, v, v % 3 == 0 ? 0 : v % 3 == 1 ? 0.85 : 0.99);
        destroy(&s);
    }
}

static void swallow(void *user, enum stp_log_level level, const char *line)
{
}

static void threads_and_allocations(void **state)
{
    struct surface_scene s = make(7, false);
    struct stp_camera camera = hard_view(0, W, H);
    struct stp_env one = { .threads = 1, .log = swallow }, many = { .threads = 4 };
    for (int merge = STP_AXIS_BLEND; merge <= STP_AXIS_SORT; merge++) {
        struct axis_lists a, b = { .merge = (enum stp_axis_merge)merge, .h = 0.5 };
        assert_int_equal(axis_lists_update(&many, &s.f->scene, &camera, &b), STP_OK);
        enum stp_result result = STP_ERROR_MEMORY;
        for (unsigned long n = 1; result != STP_OK; n++) {
            a = (struct axis_lists){ .merge = (enum stp_axis_merge)merge, .h = 0.5 };
            mem_fail_at(n);
            result = axis_lists_update(&one, &s.f->scene, &camera, &a);
            mem_fail_at(0);
            assert_true(result == STP_OK || (result == STP_ERROR_MEMORY && !a.order));
            assert_true(n < 60);
        }
        assert_true(a.count == b.count && a.count > 0);
        assert_memory_equal(a.order, b.order, a.count * sizeof *a.order);
        axis_lists_release(&a);
        axis_lists_release(&b);
    }
    destroy(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_fragments),
        cmocka_unit_test(exactly_what_weighs),
        cmocka_unit_test(threads_and_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
