/* I = sum over lights of color (albedo (ambient + diffuse max(0, n.l)) + specular max(0, n.h)^s).
 */
#include "reference/surface.h"
#include "scene/optics.h"

static struct vec3 towards_light(const struct eye *eye, const struct stp_light *light,
                                 struct vec3 point)
{
    if (light->at_eye)
        return v3(0, 0, 1);
    if (light->positional)
        return v3_unit(v3_sub(eye_point(eye, light->position), point));
    return v3_unit(eye_direction(eye, v3_load(light->direction)));
}

static struct vec3 towards_viewer(const struct view *view, struct vec3 point)
{
    if (!view->local_viewer || view->eye.orthographic)
        return v3(0, 0, 1);
    return v3_unit(v3_scale(point, -1));
}

static struct vec3 shade_one(const struct view *view, const struct surface *surface,
                             const struct stp_material *material, const struct stp_light *light)
{
    struct vec3 l = towards_light(&view->eye, light, surface->point);
    struct vec3 h = v3_unit(v3_add(l, towards_viewer(view, surface->point)));
    double lit = material->ambient + material->diffuse * fmax(0, v3_dot(surface->normal, l));
    double shine =
        material->specular * pow(fmax(0, v3_dot(surface->normal, h)), material->shininess);
    struct vec3 i = v3_add(v3_scale(surface->albedo, lit), v3(shine, shine, shine));
    return v3(i.x * light->color[0], i.y * light->color[1], i.z * light->color[2]);
}

struct vec3 surface_shade(const struct view *view, const struct surface *surface)
{
    const struct stp_scene *scene = view->scene;
    const uint16_t *object = scene->splats.object;
    const struct scene_object *of = &scene->objects[object ? object[surface->id] : 0];
    struct vec3 sum = v3(0, 0, 0);
    if (scene->facts.eye_dome) /* shaded by depth, once the picture's depths are known */
        return surface->albedo;
    for (unsigned i = 0; i < scene->light_count; i++)
        sum = v3_add(sum, shade_one(view, surface, &of->material, &scene->lights[i]));
    /* Of what lets light through only the nearest layer mirrors: surface_glass. */
    bool mirrors =
        scene->environment.map.width && optics_matter(&of->optics) && surface->opacity == 1;
    return mirrors ? surface_mirror(view, surface, &of->optics, sum) : sum;
}
