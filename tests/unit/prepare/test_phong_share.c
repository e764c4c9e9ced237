/* Sites in the nearest of the patches that hold them: against a search through all patches, on
 * surfaces without edges and with them. */
#include "fitted.h"

#include "base/memory.h"
#include "prepare/phong_crease.h"
#include "prepare/phong_share.h"

#define TOLERANCE 0.02

/* A cover of samples, and a copy of what it was before its patches shared. */
struct shared {
    struct stp_scene *scene;
    struct fit_cloud cloud;
    struct patch_set set, before;
};

static struct patch_set copy_of(const struct patch_set *set)
{
    struct patch_set copy = { .count = set->count,
                              .patch = calloc(set->count, sizeof *copy.patch) };
    for (size_t i = 0; i < set->count; i++) {
        copy.patch[i] = set->patch[i];
        copy.patch[i].member = malloc(set->patch[i].count * sizeof(uint32_t));
        memcpy(copy.patch[i].member, set->patch[i].member, set->patch[i].count * sizeof(uint32_t));
    }
    return copy;
}

static struct shared cover_of(const struct samples *s, bool creases)
{
    struct fit_limits limits = { .tolerance = TOLERANCE, .color = INFINITY, .ended = 1 };
    struct stp_points points = points_of(s);
    struct shared made = { .scene = scene_of(NULL, &points) };
    assert_int_equal(fit_cloud_build(NULL, &made.scene->splats, true, &made.cloud), STP_OK);
    if (creases)
        assert_int_equal(creases_find(NULL, &made.cloud), STP_OK);
    assert_int_equal(patches_cover(NULL, &made.cloud, &limits, &made.set), STP_OK);
    made.before = copy_of(&made.set);
    return made;
}

static void shared_release(struct shared *s)
{
    for (size_t i = 0; i < s->before.count; i++)
        free(s->before.patch[i].member);
    free(s->before.patch);
    patch_set_release(&s->set);
    fit_cloud_release(&s->cloud);
    stp_scene_destroy(&s->scene);
}

static bool holds(const struct patch *p, uint32_t site)
{
    for (uint32_t k = 0; k < p->count; k++)
        if (p->member[k] == site)
            return true;
    return false;
}

static void in_frame(const struct shared *s, const struct patch *p, uint32_t site, double xyz[3])
{
    const struct patch_frame *f = &p->frame;
    const double *at = s->cloud.site[site].p;
    double d[3] = { at[0] - f->c.x, at[1] - f->c.y, at[2] - f->c.z };
    xyz[0] = d[0] * f->u.x + d[1] * f->u.y + d[2] * f->u.z;
    xyz[1] = d[0] * f->v.x + d[1] * f->v.y + d[2] * f->v.z;
    xyz[2] = d[0] * f->n.x + d[1] * f->n.y + d[2] * f->n.z;
}

/* Squared distance from the middle, in an ellipse of the members' spread and a circle's area. */
static double distance(const struct shared *s, const struct patch *p, uint32_t site)
{
    double xx = 0, yy = 0, d[3];
    for (uint32_t k = 0; k < p->count; k++) {
        in_frame(s, p, p->member[k], d);
        xx += d[0] * d[0];
        yy += d[1] * d[1];
    }
    double ratio = fmin(fmax(sqrt(xx / yy), 1.0 / 3), 3);
    in_frame(s, p, site, d);
    return d[0] * d[0] / ratio + d[1] * d[1] * ratio;
}

/* Of what held a site before, those hold it still that are within 1.5 times the least squared
 * distance, and no others. */
static void shared_rightly(const struct shared *s, uint32_t site)
{
    double least = INFINITY;
    for (size_t k = 0; k < s->set.count; k++)
        if (holds(&s->before.patch[k], site))
            least = fmin(least, distance(s, &s->before.patch[k], site));
    for (size_t k = 0; k < s->set.count; k++) {
        if (!holds(&s->before.patch[k], site)) {
            assert_false(holds(&s->set.patch[k], site));
            continue;
        }
        double d = distance(s, &s->before.patch[k], site);
        if (fabs(d - 1.5 * least) > 1e-6 * d)
            assert_int_equal(holds(&s->set.patch[k], site), d < 1.5 * least);
    }
}

static void nearest_holders_keep_it(void **state)
{
    const surface_fn surface[] = { on_torus, on_sphere };
    for (int i = 0; i < 2; i++) {
        struct samples samples = sample_surface(surface[i], 3000, 21);
        struct shared s = cover_of(&samples, false);
        size_t held = 0, left = 0;
        assert_int_equal(patches_share(NULL, &s.cloud, TOLERANCE, &s.set), STP_OK);
        assert_int_equal(s.set.count, s.before.count);
        for (size_t k = 0; k < s.set.count; k++) {
            held += s.before.patch[k].count;
            left += s.set.patch[k].count;
        }
        assert_true(left * 5 < held * 4);
        for (uint32_t site = 0; site < s.cloud.count; site++)
            shared_rightly(&s, site);
        shared_release(&s);
        samples_release(&samples);
    }
}

/* Planes keep to the tolerance of what is left, and the seed is a member. */
static void planes_keep_to_the_tolerance(void **state)
{
    struct samples samples = sample_surface(on_torus, 3000, 22);
    struct shared s = cover_of(&samples, false);
    assert_int_equal(patches_share(NULL, &s.cloud, TOLERANCE, &s.set), STP_OK);
    size_t moved = 0;
    for (size_t i = 0; i < s.set.count; i++) {
        const struct patch *p = &s.set.patch[i];
        double d[3];
        assert_true(holds(p, p->seed));
        moved += memcmp(&p->frame, &s.before.patch[i].frame, sizeof p->frame) != 0;
        for (uint32_t k = 0; k < p->count; k++) {
            in_frame(&s, p, p->member[k], d);
            assert_true(fabs(d[2]) <= TOLERANCE * (1 + 1e-12));
        }
    }
    assert_true(moved > s.set.count / 2);
    shared_release(&s);
    samples_release(&samples);
}

/* Two faces of a ridge: what lies at it keeps all that it held, and elsewhere there is sharing. */
static void on_ridge(double u, double v, double p[3], double n[3])
{
    double side = u < 0.5 ? -1 : 1, x = 2 * fabs(u - 0.5);
    memcpy(p, (double[3]){ side * x, -x, v }, 3 * sizeof *p);
    memcpy(n, (double[3]){ side * sqrt(0.5), sqrt(0.5), 0 }, 3 * sizeof *n);
}

static void patches_at_edges_keep_all(void **state)
{
    struct samples samples = sample_surface(on_ridge, 3000, 23);
    for (size_t i = 0; i < samples.count; i++) /* bent, so that there are several patches */
        samples.position[i][1] += 0.15 * cos(4 * samples.position[i][2]);
    struct shared s = cover_of(&samples, true);
    size_t edges = 0, fewer = 0;
    assert_non_null(s.cloud.crease);
    assert_int_equal(patches_share(NULL, &s.cloud, TOLERANCE, &s.set), STP_OK);
    for (size_t i = 0; i < s.set.count; i++) {
        const struct patch *p = &s.set.patch[i], *q = &s.before.patch[i];
        bool at_edge = false;
        for (uint32_t k = 0; k < q->count; k++)
            at_edge |= s.cloud.crease_of[q->member[k]] != NO_SITE;
        edges += at_edge;
        fewer += p->count < q->count;
        if (at_edge)
            assert_true(p->count == q->count &&
                        memcmp(p->member, q->member, p->count * sizeof *p->member) == 0);
    }
    assert_true(edges > 0 && fewer > 0);
    for (uint32_t site = 0; site < s.cloud.count; site++) {
        bool held = false;
        for (size_t i = 0; i < s.set.count && !held; i++)
            held = holds(&s.set.patch[i], site);
        assert_true(held);
    }
    shared_release(&s);
    samples_release(&samples);
}

/* The area of all ellipses over that of the torus; before patches shared it was 2.4. */
static void splats_overlap_little(void **state)
{
    struct samples s = sample_surface(on_torus, 6000, 24);
    struct stp_scene *scene = fitted(&s, TOLERANCE, NULL);
    double area = 0;
    for (size_t i = 0; i < scene->splats.count; i++)
        area += PI * (double)scene->splats.phong[i].radius[0] *
                (double)scene->splats.phong[i].radius[1];
    assert_true(area / (4 * PI * PI * 0.4) < 2.2);
    covers_all(&scene->splats, &s, TOLERANCE, false);
    stp_scene_destroy(&scene);
    samples_release(&s);
}

static void no_memory_leaves_the_set(void **state)
{
    char line[256] = "";
    struct stp_env env = { .log = silent, .user = line };
    struct samples samples = sample_surface(on_sphere, 500, 25);
    struct shared s = cover_of(&samples, false);
    mem_fail_at(1);
    enum stp_result result = patches_share(&env, &s.cloud, TOLERANCE, &s.set);
    mem_fail_at(0);
    assert_int_equal(result, STP_ERROR_MEMORY);
    assert_true(strlen(line) > 0);
    assert_int_equal(s.set.count, s.before.count);
    for (size_t i = 0; i < s.set.count; i++)
        assert_int_equal(s.set.patch[i].count, s.before.patch[i].count);
    shared_release(&s);
    samples_release(&samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_holders_keep_it),   cmocka_unit_test(planes_keep_to_the_tolerance),
        cmocka_unit_test(patches_at_edges_keep_all), cmocka_unit_test(splats_overlap_little),
        cmocka_unit_test(no_memory_leaves_the_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
