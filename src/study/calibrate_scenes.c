#include "study/calibrate.h"

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"

/* What a fit has to tell apart: splats that are many or large, pictures that are full or empty, few
 * layers or many, a few fragments a pixel or more than slots. Two of each colour are as large as
 * pictures are in use, with as many fragments: what is cheap while it lies in a cache is not there.
 */
const struct calibrate_scene calibrate_scenes[] = {
    { 8000, 272, 4, 0.9, 1, 0.4, false, 0 },     { 8000, 272, 4, 0.9, 1, 0.8, false, 0 },
    { 120000, 400, 1.5, 0.9, 1, 0.4, false, 0 }, { 40000, 416, 2.5, 0.5, 1, 0.4, false, 0 },
    { 700, 400, 20, 0.9, 1, 0.4, false, 0 },     { 1800, 400, 12, 0.9, 1, 0.8, false, 0 },
    { 100, 264, 70, 0.9, 1, 0.4, false, 0 },     { 6000, 1024, 8, 0.3, 1, 0.8, false, 0 },
    { 9000, 768, 6.5, 0.9, 1, 0.4, false, 0 },   { 12000, 176, 5, 0.9, 4, 0.4, false, 0 },
    { 4000, 96, 10, 0.7, 3, 0.4, false, 0 },     { 12000, 1024, 13, 0.9, 1, 0.4, false, 0 },
    { 22000, 640, 12, 0.9, 2, 0.4, false, 0 },   { 8000, 272, 4, 0.9, 1, 0.4, true, 0 },
    { 120000, 400, 1.5, 0.9, 1, 0.4, true, 0 },  { 40000, 416, 2.5, 0.5, 1, 0.4, true, 0 },
    { 700, 400, 20, 0.9, 1, 0.4, true, 0 },      { 1800, 400, 12, 0.9, 1, 0.8, true, 0 },
    { 100, 264, 70, 0.9, 1, 0.4, true, 0 },      { 6000, 1024, 8, 0.3, 1, 0.8, true, 0 },
    { 9000, 768, 6.5, 0.9, 1, 0.4, true, 0 },    { 12000, 176, 5, 0.9, 4, 0.4, true, 0 },
    { 4000, 96, 10, 0.7, 3, 0.4, true, 0 },      { 12000, 1024, 13, 0.9, 1, 0.4, true, 0 },
    { 22000, 640, 12, 0.9, 2, 0.4, true, 0 },    { 8000, 272, 4, 0.9, 1, 0, false, 0.4 },
    { 50000, 264, 1.5, 0.9, 1, 0, false, 0.4 },  { 500, 336, 20, 0.9, 2, 0, false, 0.4 },
    { 80, 208, 60, 0.9, 1, 0, false, 0.4 },      { 6000, 768, 3, 0.3, 2, 0, false, 0.4 },
    { 5000, 400, 6, 0.9, 2, 0, false, 0.4 },     { 8000, 184, 5, 0.9, 4, 0, false, 0.4 },
    { 2500, 88, 10, 0.7, 3, 0, false, 0.4 },     { 50000, 264, 1.5, 0.9, 1, 0, true, 0.4 },
    { 500, 336, 20, 0.9, 2, 0, true, 0.4 },      { 80, 208, 60, 0.9, 1, 0, true, 0.4 },
    { 6000, 768, 3, 0.3, 2, 0, true, 0.4 },      { 5000, 400, 6, 0.9, 2, 0, true, 0.4 },
    { 8000, 184, 5, 0.9, 4, 0, true, 0.4 },      { 2500, 88, 10, 0.7, 3, 0, true, 0.4 },
};
const unsigned calibrate_scene_count = sizeof calibrate_scenes / sizeof *calibrate_scenes;

#define DISTANCE 10.0
#define FOCAL    2.0 /* over half the picture's side */

/* Evenly over the sphere: the golden angle. */
static struct vec3 direction(unsigned i, unsigned count)
{
    double z = 1 - (2.0 * i + 1) / count, r = sqrt(1 - z * z), turn = 2.399963229728653 * i;
    return v3(r * cos(turn), r * sin(turn), z);
}

struct arrays {
    double (*position)[3];
    float (*normal)[3], *radius, (*color)[3];
};

static void fill(const struct calibrate_scene *what, double sphere, const struct arrays *a)
{
    unsigned each = what->splats / what->shells;
    double pixel = DISTANCE / (FOCAL * what->size / 2);
    for (unsigned i = 0; i < each * what->shells; i++) {
        struct vec3 n = direction(i % each, each);
        struct vec3 p = v3_scale(n, sphere * (1 - 0.15 * (i / each)));
        v3_store(p, a->position[i]);
        v3_storef(n, a->normal[i]);
        memcpy(a->color[i], (float[3]){ 0.5f, 0.7f, (float)(i % 7) / 7 }, sizeof *a->color);
        a->radius[i] = (float)(what->radius * pixel);
    }
}

static enum stp_result add_points(const struct stp_env *env, const struct calibrate_scene *what,
                                  double sphere, struct stp_scene *scene)
{
    size_t n = what->splats;
    struct arrays a = { mem_alloc(n, sizeof *a.position), mem_alloc(n, sizeof *a.normal),
                        mem_alloc(n, sizeof *a.radius), mem_alloc(n, sizeof *a.color) };
    enum stp_result result = STP_OK;
    if (!a.position || !a.normal || !a.radius || !a.color)
        result = log_no_memory(env, n * sizeof *a.position, "a scene to calibrate with");
    if (result == STP_OK) {
        fill(what, sphere, &a);
        struct stp_points points = { .count = what->splats / what->shells * what->shells,
                                     .position = (const double(*)[3])a.position,
                                     .normal = (const float(*)[3])a.normal,
                                     .radius = a.radius,
                                     .color = what->color ? (const float(*)[3])a.color : NULL };
        struct stp_object_params object = { .opacity = (float)what->opacity };
        result = stp_scene_add_points(env, scene, &points, &object);
    }
    mem_free(a.position);
    mem_free(a.normal);
    mem_free(a.radius);
    mem_free(a.color);
    return result;
}

/* A few counts for all scenes: shaders are compiled for a count of groups. */
static unsigned groups_of(double overlap)
{
    return overlap < 0.6 ? 4 : 9;
}

enum stp_result calibrate_scene_make(const struct stp_env *env, const struct calibrate_scene *what,
                                     struct stp_scene **scene, struct stp_camera *camera)
{
    struct stp_scene *made = NULL;
    struct stp_group_params group = { .overlap = what->overlap,
                                      .max_groups = groups_of(what->overlap) };
    struct stp_prepare_params prepare = { .two_sided = STP_OFF };
    double half = what->size / 2.0, sphere = what->fill * DISTANCE / FOCAL;
    enum stp_result result = stp_scene_create(env, &made);
    if (result == STP_OK)
        result = add_points(env, what, sphere, made);
    if (result == STP_OK)
        result = stp_scene_prepare(env, made, &prepare);
    if (result == STP_OK && what->overlap > 0)
        result = stp_scene_group(env, made, &group);
    if (result != STP_OK) {
        stp_scene_destroy(&made);
        return result;
    }
    *camera = (struct stp_camera){ .fx = FOCAL * half,
                                   .fy = FOCAL * half,
                                   .cx = half,
                                   .cy = half,
                                   .width = what->size,
                                   .height = what->size,
                                   .near_depth = 0.1,
                                   .far_depth = INFINITY };
    for (int i = 0; i < 4; i++)
        camera->world_to_camera[5 * i] = 1;
    camera->world_to_camera[11] = -DISTANCE;
    *scene = made;
    return STP_OK;
}
