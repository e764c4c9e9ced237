#include "device.h"

/* Measured over the random clouds of these tests, with a margin of 4 or more. Packed: normals of 28
 * bits, rho^2 of 12, depths of 24. Exact with ids: weights in 4095ths. Sums in fixed point or
 * float: what float32 leaves of a position in the picture. */
const struct tolerance packed_tolerance = {
    .color = 4e-3, .normal = 1e-2, .depth = 4e-3, .psnr = 70, .fragile = 0.03
};
const struct tolerance exact_tolerance = {
    .color = 4e-3, .normal = 1e-2, .depth = 4e-3, .psnr = 75, .fragile = 0.03
};
const struct tolerance float_tolerance = {
    .color = 1e-4, .normal = 2e-4, .depth = 1e-3, .psnr = 110, .fragile = 0.03
};

const struct tolerance layers_tolerance = {
    .color = 3e-3, .normal = 1e-2, .depth = 4e-3, .psnr = 80, .fragile = 0.03
};

#define VARIANTS TRUTH_VARIANTS
#define SHIFT    3e-4 /* pixels: some dozen roundings of a place in a picture of 400 */
#define DEPTHS   4    /* roundings of an eye depth that tell: of its centre, of what is added */
/* Epsilons: keys of few bits put depths in another order, but leave them where they are. */
#define MOVED 1e-3
#define JUMP  0.01 /* what moving the picture by so little changes only where it is not smooth */

struct pixel {
    double color[3], normal[3], alpha, z;
};

static struct pixel pixel_at(const struct stp_image *image, size_t at)
{
    static const char *const names[] = { "R", "G", "B", "N.X", "N.Y", "N.Z", "A", "Z" };
    double value[8];
    for (int i = 0; i < 8; i++)
        value[i] = stp_image_find(image, names[i])->data.f[at];
    return (struct pixel){
        { value[0], value[1], value[2] }, { value[3], value[4], value[5] }, value[6], value[7]
    };
}

/* Largest differences of colour, normal and depth; infinite where only one is covered. */
struct distance {
    double color, normal, depth, square;
};

static struct distance distance(const struct pixel *a, const struct pixel *b, double epsilon)
{
    struct distance d = { 0 };
    if (isfinite(a->z) != isfinite(b->z))
        return (struct distance){ INFINITY, INFINITY, INFINITY, INFINITY };
    for (int k = 0; k < 3; k++) {
        double scale = fmax(1, fabs(b->color[k])), e = (a->color[k] - b->color[k]) / scale;
        d.color = fmax(d.color, fabs(e));
        d.square += e * e / 3;
        d.normal = fmax(d.normal, fabs(a->normal[k] - b->normal[k]));
    }
    d.color = fmax(d.color, fabs(a->alpha - b->alpha));
    if (isfinite(a->z))
        d.depth = fabs(a->z - b->z) / fmax(epsilon, 1e-3 * fabs(b->z));
    return d;
}

/* Of epsilon, relative. Quantised depths are off by half a step, and epsilon is 2^depth_bits. */
static double rounding_of(const struct stp_plan *plan)
{
    bool packed = plan->payload == STP_PAYLOAD_PACKED;
    return 1e-5 + (packed ? ldexp(1, 1 - (int)plan->frame.depth_bits) : 0);
}

/* From -2 to 2: each splat is rounded by itself; what coincides is rounded alike. With shares of
 * all sizes two splats change places in some variant, also where they go the same way. */
static double share(const double position[3], int turn)
{
    uint64_t bits[3], mixed = 0x9e3779b97f4a7c15u * (unsigned)(turn + 1);
    memcpy(bits, position, sizeof bits);
    for (int k = 0; k < 3; k++)
        mixed = (mixed ^ bits[k] ^ bits[k] >> 31) * 0x9e3779b97f4a7c15u;
    return ldexp((double)(mixed >> 11), -51) - 2;
}

struct vec3 eye_of_camera(const struct stp_camera *camera)
{
    const double *m = camera->world_to_camera;
    return v3(-(m[0] * m[3] + m[4] * m[7] + m[8] * m[11]),
              -(m[1] * m[3] + m[5] * m[7] + m[9] * m[11]),
              -(m[2] * m[3] + m[6] * m[7] + m[10] * m[11]));
}

/* All radii alike, so that what cancels still does; each splat's depth by itself, by `step` at most
 * and what float32 rounds of it, so that it is seen where it was, and edge-on if it was. */
static void disturb_splats(struct splats *s, const struct stp_camera *camera, int variant,
                           double step)
{
    struct vec3 eye = eye_of_camera(camera), axis = v3_load(camera->world_to_camera + 8);
    float times = variant & 1 ? 1 - 1e-5f : 1 + 1e-5f;
    for (size_t i = 0; i < s->count; i++) {
        struct vec3 p = v3_load(s->position[i]), ray = v3_sub(p, eye);
        double by = (variant & 1 ? -1 : 1) * share(s->position[i], variant / 2),
               depth = fabs(v3_dot(ray, axis)), farthest = depth + (double)s->radius[i];
        struct vec3 move = camera->orthographic
                               ? v3_scale(axis, by * (step + DEPTHS * 0x1p-24 * depth))
                               : v3_scale(ray, by * (step / farthest + DEPTHS * 0x1p-24));
        v3_store(v3_add(p, move), s->position[i]);
        s->radius[i] *= times;
        for (int k = 0; s->phong && k < 2; k++)
            s->phong[i].radius[k] *= times;
    }
}

/* Moves what rounding may move; variants by two are of opposite signs. step: of depths, in
 * epsilons.
 */
static void disturb(struct stp_scene *scene, struct stp_camera *camera,
                    struct stp_render_params *params, int variant, double step, double epsilon)
{
    double sign = variant & 1 ? -1 : 1;
    double *center = variant & 2 ? &camera->cy : &camera->cx;
    *center += sign * SHIFT;
    camera->near_depth += fabs(camera->near_depth) * sign * 1e-6;
    camera->far_depth *= 1 - sign * 1e-6;
    params->epsilon *= 1 + sign * step;
    for (unsigned i = 0; i < scene->object_count; i++)
        scene->objects[i].epsilon *= 1 + sign * step;
    disturb_splats(&scene->splats, camera, variant, fmin(step, MOVED) * epsilon);
}

/* variant < 0: as it is. */
static struct stp_image *reference_of(const struct stp_scene *scene, const struct stp_plan *plan,
                                      int variant, double step)
{
    struct stp_env env = { .threads = 2 };
    struct stp_scene copy = *scene;
    struct stp_camera camera = plan->camera;
    struct stp_render_params params = plan->params;
    struct stp_image *image = NULL;
    struct scene_object objects[8];
    double(*position)[3] = malloc(scene->splats.count * sizeof *position);
    float *radius = malloc(scene->splats.count * sizeof *radius);
    struct stp_phong_splat *phong = malloc(scene->splats.count * sizeof *phong);
    assert_true(position && radius && phong && scene->object_count <= 8);
    memcpy(objects, scene->objects, scene->object_count * sizeof *objects);
    memcpy(position, scene->splats.position, scene->splats.count * sizeof *position);
    memcpy(radius, scene->splats.radius, scene->splats.count * sizeof *radius);
    copy.objects = objects;
    copy.splats.position = position;
    copy.splats.radius = radius;
    if (copy.splats.phong)
        copy.splats.phong = memcpy(phong, copy.splats.phong, copy.splats.count * sizeof *phong);
    if (variant >= 0)
        disturb(&copy, &camera, &params, variant, step, plan->frame.epsilon);
    assert_int_equal(reference_render(&env, &copy, &camera, &params, &image), STP_OK);
    free(position);
    free(radius);
    free(phong);
    return image;
}

/* How far the truth itself goes by what rounding may move. */
static struct distance condition(struct stp_image *const variant[VARIANTS],
                                 const struct pixel *truth, size_t at, double epsilon)
{
    struct distance most = { 0 };
    for (int v = 0; v < VARIANTS; v++) {
        struct pixel moved = pixel_at(variant[v], at);
        struct distance d = distance(&moved, truth, epsilon);
        most.color = fmax(most.color, d.color);
        most.normal = fmax(most.normal, d.normal);
        most.depth = fmax(most.depth, d.depth);
        most.square = fmax(most.square, d.square);
    }
    return most;
}

static bool fragile(const struct distance *d)
{
    return d->color > JUMP || d->normal > JUMP || d->depth > 10 * JUMP;
}

static void judge_pixel(struct verdict *verdict, const struct pixel *seen,
                        const struct pixel *truth, const struct distance *may,
                        const struct tolerance *t, double epsilon)
{
    struct distance d = distance(seen, truth, epsilon);
    verdict->off += d.color > t->color + may->color || d.normal > t->normal + may->normal ||
                    d.depth > t->depth + may->depth;
    verdict->worst_color = fmax(verdict->worst_color, d.color);
    verdict->worst_normal = fmax(verdict->worst_normal, d.normal);
    verdict->worst_depth = fmax(verdict->worst_depth, d.depth);
    verdict->squares += d.square;
    verdict->condition += may->square;
}

void truth_make(const struct stp_scene *scene, const struct stp_plan *plan, struct truth *truth)
{
    double step = rounding_of(plan);
    truth->image = reference_of(scene, plan, -1, step);
    for (int v = 0; v < VARIANTS; v++)
        truth->variant[v] = reference_of(scene, plan, v, step);
}

void truth_destroy(struct truth *truth)
{
    stp_image_destroy(&truth->image);
    for (int v = 0; v < VARIANTS; v++)
        stp_image_destroy(&truth->variant[v]);
}

struct verdict judge_against(const struct truth *truth, double epsilon,
                             const struct stp_image *image, const struct tolerance *tolerance)
{
    struct verdict verdict = { 0 };
    for (size_t at = 0; at < (size_t)image->width * image->height; at++) {
        struct pixel seen = pixel_at(image, at), right = pixel_at(truth->image, at);
        bool covered = isfinite(seen.z) || isfinite(right.z);
        struct distance may = condition(truth->variant, &right, at, epsilon);
        verdict.covered += covered;
        if (fragile(&may))
            verdict.fragile++;
        else
            judge_pixel(&verdict, &seen, &right, &may, tolerance, epsilon);
    }
    double covered = fmax(1, (double)verdict.covered);
    verdict.psnr = verdict.squares > 0 ? -10 * log10(verdict.squares / covered) : INFINITY;
    verdict.noisy = verdict.squares > pow(10, -tolerance->psnr / 10) * covered + verdict.condition;
    return verdict;
}

struct verdict judge(const struct stp_scene *scene, const struct stp_plan *plan,
                     const struct stp_image *image, const struct tolerance *tolerance)
{
    struct truth truth;
    truth_make(scene, plan, &truth);
    struct verdict verdict = judge_against(&truth, plan->frame.epsilon, image, tolerance);
    truth_destroy(&truth);
    return verdict;
}

/* The truths of one scene and view, made when the first way asks for them. */
struct truths {
    struct truth truth[2];
    double rounding[2];
};

static const struct truth *truth_for(struct truths *t, const struct stp_scene *scene,
                                     const struct stp_plan *plan)
{
    unsigned i = 0;
    while (i < 2 && t->truth[i].image && t->rounding[i] != rounding_of(plan))
        i++;
    assert_true(i < 2); /* depths as they are, and packed alike */
    if (!t->truth[i].image) {
        t->rounding[i] = rounding_of(plan);
        truth_make(scene, plan, &t->truth[i]);
    }
    return &t->truth[i];
}

static void truths_destroy(struct truths *t)
{
    for (int i = 0; i < 2; i++)
        truth_destroy(&t->truth[i]);
}

static void expect_truth(struct device *device, const struct stp_scene *scene,
                         const struct stp_camera *camera, const struct stp_render_params *params,
                         const struct tolerance *tolerance, const char *what, struct truths *truths)
{
    struct stp_plan *plan = NULL;
    if (device_plan(device, scene, camera, params, &plan) != STP_OK)
        fail_msg("%s: no plan: %s", what, device->last);
    struct stp_image *image = device_render_plan(device, scene, plan);
    struct verdict v =
        judge_against(truth_for(truths, scene, plan), plan->frame.epsilon, image, tolerance);
    bool good =
        v.off == 0 && !v.noisy && (double)v.fragile <= tolerance->fragile * (double)v.covered + 8;
    if (!good || getenv("STP_TEST_VERDICTS"))
        print_message("%s: %s by %s, %s: %zu covered, %zu fragile, %zu off, %.1f dB; worst colour "
                      "%.3g, normal %.3g, depth %.3g\n",
                      what, stp_method_name(plan->method), stp_path_name(plan->path),
                      plan->payload == STP_PAYLOAD_PACKED ? "packed" : "ids", v.covered, v.fragile,
                      v.off, v.psnr, v.worst_color, v.worst_normal, v.worst_depth);
    stp_image_destroy(&image);
    stp_plan_destroy(&plan);
    assert_true(good);
}

void expect_reference(struct device *device, const struct stp_scene *scene,
                      const struct stp_camera *camera, const struct stp_render_params *params,
                      const struct tolerance *tolerance, const char *what)
{
    struct truths truths = { 0 };
    expect_truth(device, scene, camera, params, tolerance, what, &truths);
    truths_destroy(&truths);
}

void expect_everywhere(struct device *device, const struct stp_scene *scene,
                       const struct stp_camera *camera, const struct stp_render_params *params,
                       const char *what)
{
    static const struct {
        enum stp_method method;
        enum stp_path path;
        enum stp_payload payload;
        const struct tolerance *tolerance;
    } way[] = {
        { STP_METHOD_EXACT, STP_PATH_AUTO, STP_PAYLOAD_AUTO, &packed_tolerance },
        { STP_METHOD_EXACT, STP_PATH_COMPUTE, STP_PAYLOAD_ID, &exact_tolerance },
        { STP_METHOD_TWO_PASS, STP_PATH_COMPUTE, STP_PAYLOAD_AUTO, &float_tolerance },
        { STP_METHOD_TWO_PASS, STP_PATH_RASTER, STP_PAYLOAD_AUTO, &float_tolerance },
        { STP_METHOD_DEFERRED, STP_PATH_COMPUTE, STP_PAYLOAD_ID, &float_tolerance },
        { STP_METHOD_DEFERRED, STP_PATH_COMPUTE, STP_PAYLOAD_PACKED, &packed_tolerance },
        { STP_METHOD_DEFERRED, STP_PATH_RASTER, STP_PAYLOAD_ID, &float_tolerance },
        { STP_METHOD_DEFERRED, STP_PATH_RASTER, STP_PAYLOAD_PACKED, &packed_tolerance },
    };
    struct truths truths = { 0 };
    for (unsigned i = 0; i < sizeof way / sizeof *way; i++) {
        struct stp_render_params p = *params;
        if (way[i].method == STP_METHOD_DEFERRED && scene->facts.grouping.groups == 0)
            continue;
        p.method = way[i].method;
        p.path = way[i].path;
        p.payload = way[i].payload;
        expect_truth(device, scene, camera, &p, way[i].tolerance, what, &truths);
    }
    truths_destroy(&truths);
}

void expect_same_bits(const struct stp_image *a, const struct stp_image *b, const char *what)
{
    assert_int_equal(a->channel_count, b->channel_count);
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    size_t count = (size_t)a->width * a->height;
    for (unsigned i = 0; i < a->channel_count; i++) {
        const struct stp_channel *c = &a->channels[i];
        const struct stp_channel *d = stp_image_find(b, c->name);
        assert_non_null(d);
        if (strcmp(c->name, "id") == 0)
            continue;
        for (size_t at = 0; at < count; at++)
            if (c->data.u[at] != d->data.u[at])
                fail_msg("%s: %s differs at pixel %zu, %zu: %.9g and %.9g", what, c->name,
                         at % a->width, at / a->width, c->data.f[at], d->data.f[at]);
    }
}
