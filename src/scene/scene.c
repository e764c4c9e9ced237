#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "scene/optics.h"

#define MAX_OBJECTS 65535 /* splats.object has 16 bits */

static const struct stp_material default_material = SCENE_DEFAULT_MATERIAL;
static const struct stp_light head_light = { .at_eye = true, .color = { 1, 1, 1 } };

void environment_release(struct scene_environment *environment)
{
    environment_map_release(&environment->map);
    mem_free(environment->texel);
    *environment = (struct scene_environment){ 0 };
}

void cover_groups_release(struct cover_groups *groups)
{
    mem_free(groups->node);
    mem_free(groups->home);
    *groups = (struct cover_groups){ 0 };
}

void splats_release(struct splats *splats)
{
    mem_free(splats->position);
    mem_free(splats->normal);
    mem_free(splats->radius);
    mem_free(splats->color);
    mem_free(splats->opacity);
    mem_free(splats->phong);
    mem_free(splats->object);
    mem_free(splats->input);
    mem_free(splats->group);
    *splats = (struct splats){ 0 };
}

/* From the moment and the place: of two scenes at one place one is gone before the other comes. */
static uint64_t identify(const struct stp_scene *scene)
{
    double now = clock_ms();
    uint64_t moment;
    memcpy(&moment, &now, sizeof moment);
    return moment ^ (uint64_t)(uintptr_t)scene * 0x9e3779b97f4a7c15u;
}

uint32_t scene_change(struct stp_scene *scene)
{
    return ++scene->changes;
}

enum stp_result stp_scene_create(const struct stp_env *env, struct stp_scene **scene)
{
    struct stp_scene *made = mem_zalloc(1, sizeof *made);
    if (!made)
        return log_no_memory(env, sizeof *made, "a scene");
    made->lights[0] = head_light;
    made->light_count = 1;
    made->facts.up = STP_UP_Y;
    made->facts.lights = 1;
    made->version.scene = identify(made);
    *scene = made;
    return STP_OK;
}

void stp_scene_destroy(struct stp_scene **scene)
{
    if (!scene || !*scene)
        return;
    for (unsigned i = 0; i < (*scene)->object_count; i++)
        cloud_release(&(*scene)->objects[i].cloud);
    mem_free((*scene)->objects);
    splats_release(&(*scene)->splats);
    environment_release(&(*scene)->environment);
    cover_groups_release(&(*scene)->cover);
    volume_release(&(*scene)->volume);
    stream_release(&(*scene)->stream);
    mem_free(*scene);
    *scene = NULL;
}

const struct stp_facts *stp_scene_facts(const struct stp_scene *scene)
{
    return &scene->facts;
}

enum stp_result scene_check_whole(const struct stp_env *env, const struct stp_scene *scene,
                                  const char *what)
{
    if (!scene->stream)
        return STP_OK;
    return log_error(env, STP_ERROR_ARGUMENT,
                     "%s takes all points in memory, and this cloud stays in its file, where only "
                     "method pyramid draws it: --stream off reads it whole",
                     what);
}

static bool all_finite(const float *value, unsigned count)
{
    for (unsigned i = 0; i < count; i++)
        if (!isfinite(value[i]))
            return false;
    return true;
}

static enum stp_result check_object(const struct stp_env *env, const struct stp_scene *scene,
                                    size_t count, const struct stp_object_params *object)
{
    static const char what[] = "points cannot be added";
    if (scene->prepared)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: the scene is prepared already", what);
    if (scene->volume || scene->stream)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: the scene holds %s", what,
                         scene->volume ? "a volume" : "a cloud that stays in its file");
    if (scene->object_count == MAX_OBJECTS)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: a scene holds %u objects at most", what,
                         MAX_OBJECTS);
    if (count >= UINT32_MAX - scene->facts.points)
        return log_error(env, STP_ERROR_ARGUMENT, "%s: a scene holds %u points at most", what,
                         UINT32_MAX - 1);
    if (!object)
        return STP_OK;
    if (!(object->epsilon >= 0 && object->epsilon < INFINITY))
        return log_error(env, STP_ERROR_ARGUMENT, "%s: epsilon is %g; it must be 0 or more", what,
                         object->epsilon);
    if (!(object->opacity <= 1))
        return log_error(env, STP_ERROR_ARGUMENT, "%s: opacity is %g; it must be in [0, 1]", what,
                         (double)object->opacity);
    const struct stp_material *m = object->material;
    if (m && !(m->opacity <= 1))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "%s: the material's opacity is %g; it must be in [0, 1]", what,
                         (double)m->opacity);
    if (m && (!all_finite(m->albedo, 3) ||
              !all_finite((float[]){ m->ambient, m->diffuse, m->specular, m->shininess }, 4)))
        return log_error(env, STP_ERROR_ARGUMENT, "%s: the material is not finite", what);
    return optics_check(env, object->optics);
}

/* What 0 (not set) and negative (none) mean. */
static float opacity_of(float given)
{
    return given == 0 ? 1 : given < 0 ? 0 : given;
}

enum stp_result scene_add_cloud(const struct stp_env *env, struct stp_scene *scene,
                                struct cloud *cloud, const struct stp_object_params *object)
{
    enum stp_result result = check_object(env, scene, cloud->count, object);
    if (result != STP_OK)
        return result;
    size_t wanted = (size_t)scene->object_count + 1;
    struct scene_object *objects = mem_realloc(scene->objects, wanted, sizeof *objects);
    if (!objects)
        return log_no_memory(env, wanted * sizeof *objects, "objects");
    scene->objects = objects;
    if (scene->object_count == 0) {
        scene->facts.up = cloud->up == STP_UP_AUTO ? STP_UP_Y : cloud->up;
        memcpy(scene->facts.format, cloud->format, sizeof scene->facts.format);
    }
    scene->facts.points += cloud->count;
    scene->facts.objects = scene->object_count + 1;
    objects[scene->object_count++] = (struct scene_object){
        .cloud = *cloud,
        .material = object && object->material ? *object->material : default_material,
        .epsilon = object ? object->epsilon : 0,
        .opacity = 1,
        .optics = optics_resolve(object ? object->optics : NULL),
    };
    if (object)
        objects[scene->object_count - 1].opacity =
            opacity_of(object->opacity) *
            (object->material ? opacity_of(object->material->opacity) : 1);
    *cloud = (struct cloud){ 0 };
    return STP_OK;
}

/* NULL stays NULL; false: out of memory. */
static bool copy_array(const void *from, size_t count, size_t size, void **to)
{
    if (!from)
        return true;
    *to = mem_alloc(count, size);
    if (*to && count > 0)
        memcpy(*to, from, count * size);
    return *to != NULL;
}

enum stp_result stp_scene_add_points(const struct stp_env *env, struct stp_scene *scene,
                                     const struct stp_points *points,
                                     const struct stp_object_params *object)
{
    struct cloud cloud = { .count = points->count, .up = STP_UP_Y };
    if (points->count > 0 && !points->position)
        return log_error(env, STP_ERROR_ARGUMENT, "points cannot be added: no positions");
    if (points->phong && !points->normal)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "points cannot be added: ellipses lie across normals, and there are none");
    bool copied =
        copy_array(points->position, cloud.count, sizeof(double[3]), (void **)&cloud.position) &&
        copy_array(points->normal, cloud.count, sizeof(float[3]), (void **)&cloud.normal) &&
        copy_array(points->radius, cloud.count, sizeof(float), (void **)&cloud.radius) &&
        copy_array(points->color, cloud.count, sizeof(float[3]), (void **)&cloud.color) &&
        copy_array(points->opacity, cloud.count, sizeof(float), (void **)&cloud.opacity) &&
        copy_array(points->phong, cloud.count, sizeof *cloud.phong, (void **)&cloud.phong);
    enum stp_result result = copied ? scene_add_cloud(env, scene, &cloud, object)
                                    : log_no_memory(env, points->count * 24, "points");
    cloud_release(&cloud);
    return result;
}

static bool light_is_usable(const struct stp_light *light)
{
    const double *v = light->positional ? light->position : light->direction;
    bool finite = isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
    bool somewhere = light->positional || v[0] != 0 || v[1] != 0 || v[2] != 0;
    return all_finite(light->color, 3) && (light->at_eye || (finite && somewhere));
}

enum stp_result stp_scene_set_lights(const struct stp_env *env, struct stp_scene *scene,
                                     const struct stp_light *lights, unsigned count)
{
    if (count > STP_MAX_LIGHTS || (count > 0 && !lights))
        return log_error(env, STP_ERROR_ARGUMENT, "%u lights: a scene takes %u at most", count,
                         STP_MAX_LIGHTS);
    for (unsigned i = 0; i < count; i++)
        if (!light_is_usable(&lights[i]))
            return log_error(env, STP_ERROR_ARGUMENT,
                             "light %u: not finite, or its direction is zero", i);
    scene->lights[0] = head_light;
    for (unsigned i = 0; i < count; i++)
        scene->lights[i] = lights[i];
    scene->light_count = count > 0 ? count : 1;
    scene->facts.lights = scene->light_count;
    scene->facts.positional_lights = false;
    for (unsigned i = 0; i < count; i++)
        scene->facts.positional_lights |= lights[i].positional && !lights[i].at_eye;
    return STP_OK;
}
