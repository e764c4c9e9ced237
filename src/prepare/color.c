#include "prepare/color.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "prepare/bounds.h"
#include "scene/axes.h"

bool scene_wants_color(const struct stp_scene *scene)
{
    for (unsigned i = 0; i < scene->object_count; i++) {
        const struct scene_object *o = &scene->objects[i];
        if (o->cloud.color || o->color_source != COLOR_OF_CLOUD ||
            memcmp(o->material.albedo, scene->objects[0].material.albedo,
                   sizeof o->material.albedo) != 0)
            return true;
    }
    return false;
}

/* Dark violet, blue, green, yellow: lightness rises evenly, so the ramp reads in grey too. Linear.
 */
static void ramp(double t, float color[3])
{
    static const double stop[5][3] = { { 0.065, 0.002, 0.095 },
                                       { 0.042, 0.085, 0.258 },
                                       { 0.017, 0.285, 0.262 },
                                       { 0.112, 0.584, 0.120 },
                                       { 0.980, 0.798, 0.022 } };
    double at = fmin(fmax(t, 0), 1) * 4;
    int low = at < 4 ? (int)at : 3;
    for (int c = 0; c < 3; c++)
        color[c] = (float)(stop[low][c] + (at - low) * (stop[low + 1][c] - stop[low][c]));
}

static enum stp_result color_by_height(const struct stp_env *env, enum stp_up up, struct splats *s)
{
    struct vec3 axis = scene_axes(up).up;
    double *height = mem_alloc(s->count, sizeof *height);
    if (!height)
        return log_no_memory(env, s->count * sizeof *height, "heights");
    for (size_t i = 0; i < s->count; i++)
        height[i] = v3_dot(axis, v3_load(s->position[i]));
    size_t trim = (s->count - 1) / 100;
    double low = select_rank(height, s->count, trim);
    double high = select_rank(height, s->count, s->count - 1 - trim);
    mem_free(height);
    double scale = high > low ? 1 / (high - low) : 0;
    for (size_t i = 0; i < s->count; i++)
        ramp((v3_dot(axis, v3_load(s->position[i])) - low) * scale, s->color[i]);
    return STP_OK;
}

static void color_by_normal(struct splats *s)
{
    for (size_t i = 0; i < s->count; i++)
        for (int c = 0; c < 3; c++)
            s->color[i][c] = 0.5f * s->normal[i][c] + 0.5f;
}

enum stp_result color_object(const struct stp_env *env, const struct scene_object *object,
                             enum stp_up up, struct splats *s)
{
    if (s->color && object->color_source == COLOR_OF_CLOUD)
        return STP_OK;
    if (!s->color)
        s->color = mem_alloc(s->count, sizeof *s->color);
    if (!s->color)
        return log_no_memory(env, s->count * sizeof *s->color, "colours");
    if (object->color_source == COLOR_BY_HEIGHT)
        return color_by_height(env, up, s);
    if (object->color_source == COLOR_BY_NORMAL)
        color_by_normal(s);
    else
        for (size_t i = 0; i < s->count; i++)
            memcpy(s->color[i], object->material.albedo, sizeof s->color[i]);
    return STP_OK;
}

enum stp_result opacity_object(const struct stp_env *env, const struct scene_object *object,
                               struct splats *s)
{
    if (object->opacity == 1)
        return STP_OK;
    bool given = s->opacity != NULL;
    if (!given)
        s->opacity = mem_alloc(s->count, sizeof *s->opacity);
    if (!s->opacity)
        return log_no_memory(env, s->count * sizeof *s->opacity, "opacities");
    for (size_t i = 0; i < s->count; i++)
        s->opacity[i] = given ? s->opacity[i] * object->opacity : object->opacity;
    return STP_OK;
}
