/* The view and the facts, composed in double, to what shaders read in float. */
#include "plan/plan.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "scene/samples.h"
#include "scene/scene.h"

static void transform(struct stp_plan *plan)
{
    struct stp_frame_constants *f = &plan->frame;
    const struct stp_camera *camera = &plan->camera;
    const double *m = camera->world_to_camera;
    struct vec3 t = m4_point(m, v3_load(plan->facts.origin));
    for (int i = 0; i < 3; i++) {
        f->rotation[i] = (float)m[i];
        f->rotation[3 + i] = (float)-m[4 + i];
        f->rotation[6 + i] = (float)-m[8 + i];
        f->rotation64[i] = m[i];
        f->rotation64[3 + i] = -m[4 + i];
        f->rotation64[6 + i] = -m[8 + i];
    }
    f->translation64[0] = t.x;
    f->translation64[1] = -t.y;
    f->translation64[2] = -t.z;
    for (int i = 0; i < 3; i++) {
        double back = -(m[i] * t.x + m[4 + i] * t.y + m[8 + i] * t.z);
        f->eye64[i] = camera->orthographic ? -m[8 + i] : back;
        f->eye[i] = (float)f->eye64[i];
    }
    f->focal64[0] = camera->fx;
    f->focal64[1] = camera->fy;
    f->center64[0] = camera->cx;
    f->center64[1] = camera->cy;
    f->translation[0] = (float)t.x;
    f->translation[1] = (float)-t.y;
    f->translation[2] = (float)-t.z;
    f->focal[0] = (float)camera->fx;
    f->focal[1] = (float)camera->fy;
    f->inv_focal[0] = (float)(1 / camera->fx);
    f->inv_focal[1] = (float)(1 / camera->fy);
    f->center[0] = (float)camera->cx;
    f->center[1] = (float)camera->cy;
    f->near_depth = (float)camera->near_depth;
    f->far_depth = (float)camera->far_depth;
    f->width = camera->width;
    f->height = camera->height;
}

/* Eye depths of the bounds of the splats' centres. */
static void center_depths(const struct stp_plan *plan, double *low, double *high)
{
    const double *b = plan->facts.bounds;
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < 8; i++) {
        struct vec3 corner = v3(b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]);
        double depth = -m4_point(plan->camera.world_to_camera, corner).z;
        *low = fmin(*low, depth);
        *high = fmax(*high, depth);
    }
}

/* Of the scene within near and far: the d_min and d_max of ZP Eq. 6. */
static void depth_range(const struct stp_plan *plan, double *low, double *high)
{
    center_depths(plan, low, high);
    *low = fmax(*low - plan->facts.radius_max, plan->camera.near_depth);
    *high = fmin(*high + plan->facts.radius_max, plan->camera.far_depth);
    if (!(*high > *low))
        *high = *low + plan->frame.epsilon;
}

/* May near or far cut a splat? Groups that cover the surface have radii up to twice as large; one
 * radius more, and a thousandth of the depth, is what is left to roundings. */
static bool may_cut(const struct stp_plan *plan)
{
    double low, high;
    center_depths(plan, &low, &high);
    double reach = 3 * (double)plan->facts.radius_max + 1e-3 * fmax(fabs(low), fabs(high));
    return !(low - reach > plan->camera.near_depth && high + reach < plan->camera.far_depth);
}

/* Depth in STP_DEPTH_BITS, with epsilon exactly 2^m steps: epsilon tests and slabs are integer. */
static void quantisation(struct stp_plan *plan)
{
    struct stp_frame_constants *f = &plan->frame;
    double low, high, epsilon = f->epsilon;
    depth_range(plan, &low, &high);
    double nearest = low;
    low -= 0.25 * epsilon; /* rounding never reaches below step 0 */
    double bits = floor(STP_DEPTH_BITS - log2((high - low) / epsilon + 2));
    f->depth_bits = bits > 16 ? 16 : bits >= 1 ? (uint32_t)bits : 1; /* not a number: 1 */
    double scale = ldexp(1, (int)f->depth_bits) / epsilon;
    f->depth_low = (float)low;
    f->depth_scale = (float)scale;
    f->depth_step = (float)(1 / scale);
    f->slab_scale = (float)(1 / epsilon);
    f->raster_near = (float)(plan->camera.orthographic ? high + epsilon : nearest);
    f->raster_scale = (float)(1 / (high - low + 2 * epsilon));
    f->raster_slab = (float)(1 / (ceil((high - low) / epsilon) + 3));
    struct vec3 size = v3_sub(v3_load(plan->facts.bounds + 3), v3_load(plan->facts.bounds));
    double diagonal = v3_length(size);
    f->eye_dome_scale = diagonal > 0 ? (float)(16 / diagonal) : 0;
}

static void light(const struct stp_plan *plan, const struct stp_light *in,
                  struct stp_light_gpu *out)
{
    const double *m = plan->camera.world_to_camera;
    bool positional = in->positional && !in->at_eye;
    struct vec3 p = in->at_eye   ? v3(0, 0, 1)
                    : positional ? m4_point(m, v3_load(in->position))
                                 : v3_unit(m4_direction(m, v3_load(in->direction)));
    out->position[0] = (float)p.x;
    out->position[1] = (float)-p.y;
    out->position[2] = (float)-p.z;
    out->positional = positional;
    memcpy(out->color, in->color, sizeof out->color);
}

static void place_lights(struct stp_plan *plan)
{
    for (unsigned i = 0; i < plan->light_count; i++)
        light(plan, &plan->lights[i], &plan->frame.lights[i]);
}

static bool is_head_light(const struct stp_light *light)
{
    return light->at_eye && light->color[0] == 1 && light->color[1] == 1 && light->color[2] == 1;
}

/* The shininess as a count of squarings when all objects share a power of two; else 32. */
static uint32_t squarings(const struct stp_scene *scene)
{
    int exponent;
    float shininess = scene->objects[0].material.shininess;
    for (unsigned i = 1; i < scene->object_count; i++)
        if (scene->objects[i].material.shininess != shininess)
            return 32;
    return frexpf(shininess, &exponent) == 0.5f && exponent >= 1 && exponent <= 17
               ? (uint32_t)exponent - 1
               : 32;
}

static void constants(struct stp_plan *plan, const struct stp_scene *scene)
{
    uint32_t *c = plan->constant;
    const struct stp_render_params *p = &plan->params;
    c[PLAN_GAUSS] = p->kernel == STP_KERNEL_GAUSS;
    c[PLAN_TWO_SIDED] = plan->facts.two_sided;
    c[PLAN_CULL_BACK] = p->cull == STP_CULL_BACK;
    c[PLAN_FLOOR] = plan->frame.floor_size > 0;
    c[PLAN_CUTS] = may_cut(plan);
    c[PLAN_ORTHOGRAPHIC] = plan->camera.orthographic;
    c[PLAN_HAS_COLOR] = plan->facts.has_color;
    c[PLAN_HAS_OBJECTS] = plan->facts.objects > 1;
    c[PLAN_HAS_UNKNOWN] = plan->facts.no_normal > 0;
    /* A scene that is shaded by depth has unlit materials (plan_material) and needs no lights. */
    bool lit = !plan->facts.eye_dome;
    c[PLAN_HEAD_LIGHT] = !lit || (scene->light_count == 1 && is_head_light(&scene->lights[0]));
    c[PLAN_LOCAL_VIEWER] = lit && p->local_viewer;
    c[PLAN_BACKGROUND] = p->background != NULL || p->environment_behind;
    c[PLAN_SAMPLE_GRID] = sample_grid(p->samples);
    /* Of several samples, P is at the nearest, and a background hides from alpha how many hit. */
    unsigned ids = STP_AOV_ID | STP_AOV_FRAGMENTS;
    if (c[PLAN_SAMPLE_GRID] > 1)
        ids |= STP_AOV_POSITION | STP_AOV_COVERAGE;
    c[PLAN_AOVS] = ((p->aovs & (STP_AOV_ALBEDO | STP_AOV_WEIGHT)) != 0 ? PLAN_AOVS_ALBEDO : 0u) |
                   ((p->aovs & ids) != 0 ? PLAN_AOVS_ID : 0u);
    if (plan->facts.transparent && (p->aovs & STP_AOV_LAYERS))
        c[PLAN_AOVS] |= PLAN_AOVS_ID | PLAN_AOVS_LAYERS;
    c[PLAN_SQUARINGS] = squarings(scene);
    bool one = plan->facts.uniform_opacity && plan->facts.objects == 1;
    c[PLAN_OPACITY] = !plan->facts.transparent ? 0 : one ? 1 : 2;
    c[PLAN_MIXED] = plan->facts.mixed;
    c[PLAN_SHADE] = p->shade;
    c[PLAN_PHONG] = plan->facts.clip_lines ? 2 : plan->facts.phong > 0;
    plan->frame.opacity = plan->facts.opacity_min;
}

struct stp_material_gpu plan_material(const struct stp_plan *plan,
                                      const struct scene_object *object)
{
    const struct stp_material *m = &object->material;
    bool lit = !plan->facts.eye_dome;
    double epsilon = plan->params.epsilon;
    return (struct stp_material_gpu){
        .ambient = lit ? m->ambient : 1, /* eye dome: albedo times what depth says */
        .diffuse = lit ? m->diffuse : 0,
        .specular = lit ? m->specular : 0,
        .shininess = m->shininess,
        .albedo = { m->albedo[0], m->albedo[1], m->albedo[2] },
        .epsilon = (float)(epsilon > 0 ? epsilon : object->epsilon),
    };
}

/* The least of the objects': slabs, and steps of depth, must not be wider than any epsilon. An
 * object of which no splat is left has none. */
static double least_epsilon(const struct stp_scene *scene)
{
    double least = INFINITY;
    for (unsigned i = 0; i < scene->object_count; i++)
        if (scene->objects[i].epsilon > 0)
            least = fmin(least, scene->objects[i].epsilon);
    return least;
}

void plan_frame_constants(struct stp_plan *plan, const struct stp_scene *scene)
{
    struct stp_frame_constants *f = &plan->frame;
    const struct stp_render_params *p = &plan->params;
    *f = (struct stp_frame_constants){ 0 };
    transform(plan);
    f->epsilon = (float)(p->epsilon > 0 ? p->epsilon : least_epsilon(scene));
    f->floor_size = p->min_splat < 0   ? 0
                    : p->min_splat > 0 ? (float)p->min_splat
                                       : (float)STP_DEFAULT_MIN_SPLAT;
    f->splat_count = (uint32_t)plan_splats(plan);
    /* All splats may lie in one pixel: their sum stays below 2^63. */
    int exponent = 0, overlap = 0;
    frexp((double)plan->facts.splats, &overlap);
    int bits = overlap > 22 ? 62 - overlap : 40;
    double most =
        p->shade == STP_SHADE_SPLAT ? plan_most_light(plan, scene) : (double)plan->facts.color_max;
    frexp(fmax(most, 1), &exponent);
    f->sum_scale = ldexpf(1, bits);
    f->color_scale = ldexpf(1, bits - exponent);
    plan->light_count = f->light_count = scene->light_count;
    memcpy(plan->lights, scene->lights, sizeof plan->lights);
    place_lights(plan);
    f->material = plan_material(plan, &scene->objects[0]);
    if (p->background) {
        float alpha = p->background[3];
        for (int i = 0; i < 3; i++)
            f->background[i] = p->background[i] * alpha;
        f->background[3] = alpha;
    }
    quantisation(plan);
    constants(plan, scene);
    plan_environment(plan, scene);
}

void plan_move(struct stp_plan *plan, const struct stp_camera *camera)
{
    plan->camera = *camera;
    transform(plan);
    place_lights(plan);
    quantisation(plan);
    plan_turn_environment(plan);
    plan_place_tiles(plan);
}

uint32_t plan_least_depth_bits(const struct stp_plan *plan)
{
    struct vec3 size = v3_sub(v3_load(plan->facts.bounds + 3), v3_load(plan->facts.bounds));
    double epsilon = plan->frame.epsilon;
    double range = v3_length(size) + 2 * plan->facts.radius_max + 0.25 * epsilon;
    double bits = floor(STP_DEPTH_BITS - log2(range / epsilon + 2));
    return bits > 16 ? 16 : bits < 1 ? 1 : (uint32_t)bits;
}
