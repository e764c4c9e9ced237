#include "scene/range.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

static double depth_at(const struct range_frame *frame, int64_t u, int64_t v)
{
    if (u < 0 || v < 0 || u >= frame->width || v >= frame->height)
        return 0;
    return (double)frame->depth[(size_t)v * frame->width + (size_t)u];
}

/* How depth changes a pixel: the line through the reading that fits two neighbours on either side
 * best, those beyond an edge apart. */
static double slope(const struct range_frame *frame, uint32_t u, uint32_t v, int du, int dv,
                    double most)
{
    double z0 = depth_at(frame, u, v), sum = 0, weight = 0;
    for (int k = -2; k <= 2; k++) {
        double z = depth_at(frame, (int64_t)u + k * du, (int64_t)v + k * dv);
        if (z > 0 && fabs(z - z0) <= most * (k < 0 ? -k : k)) {
            sum += k * (z - z0);
            weight += k * k;
        }
    }
    return weight > 0 ? sum / weight : 0;
}

bool range_pixel(const struct range *range, unsigned index, uint32_t u, uint32_t v,
                 struct range_pixel *pixel)
{
    const struct range_frame *frame = &range->frame[index];
    const struct range_camera *c = &frame->camera;
    double z = depth_at(frame, u, v), wide = z / c->fx, high = z / c->fy;
    if (!(z > 0))
        return false;
    struct vec3 ray = v3((u + 0.5 - c->cx) / c->fx, (v + 0.5 - c->cy) / c->fy, 1);
    double zu = slope(frame, u, v, 1, 0, RANGE_MOST_SLOPE * wide);
    double zv = slope(frame, u, v, 0, 1, RANGE_MOST_SLOPE * high);
    double model = range->uncertainty * range_deviation(frame, z);
    double least = RANGE_LEAST_DEPTH * fmin(wide, high);
    pixel->depth = z;
    pixel->deviation = fmax(model, least);
    pixel->place = m4_point(c->to_world, v3_scale(ray, z));
    pixel->across = m4_direction(c->to_world, v3_add(v3(wide, 0, 0), v3_scale(ray, zu)));
    pixel->down = m4_direction(c->to_world, v3_add(v3(0, high, 0), v3_scale(ray, zv)));
    pixel->along = m4_direction(c->to_world, v3_scale(ray, pixel->deviation));
    return true;
}

struct vec3 range_eye(const struct range_frame *frame)
{
    const double *m = frame->camera.to_world;
    return v3(m[3], m[7], m[11]);
}

bool range_project(const struct range_frame *frame, struct vec3 world, double at[2], double *depth)
{
    const struct range_camera *c = &frame->camera;
    const double *m = c->to_world;
    struct vec3 d = v3_sub(world, range_eye(frame));
    double x = m[0] * d.x + m[4] * d.y + m[8] * d.z, y = m[1] * d.x + m[5] * d.y + m[9] * d.z;
    double z = m[2] * d.x + m[6] * d.y + m[10] * d.z;
    at[0] = c->fx * x / z + c->cx;
    at[1] = c->fy * y / z + c->cy;
    *depth = z;
    return z > 0 && at[0] >= 0 && at[1] >= 0 && at[0] < frame->width && at[1] < frame->height;
}

static enum stp_result attach(const struct stp_env *env, struct stp_scene *scene,
                              struct volume *volume)
{
    struct cloud nothing = { .up = STP_UP_NEG_Y, .format = "range images" };
    enum stp_result result = scene_add_cloud(env, scene, &nothing, NULL);
    if (result != STP_OK)
        return result;
    for (unsigned i = 0; i < volume->range.count; i++)
        scene->facts.points += (size_t)volume->range.frame[i].width * volume->range.frame[i].height;
    scene->facts.range.frames = volume->range.count;
    scene->facts.range.by_views = volume->range.by_views;
    scene->volume = volume;
    return STP_OK;
}

enum stp_result scene_add_range(const struct stp_env *env, struct stp_scene *scene,
                                struct range *range)
{
    if (scene->object_count > 0)
        return log_error(env, STP_ERROR_ARGUMENT,
                         "a scene holds range images, or points: this one holds something already");
    struct volume *volume = mem_zalloc(1, sizeof *volume);
    if (!volume)
        return log_no_memory(env, sizeof *volume, "range images");
    volume->range = *range;
    volume->unshaded = true;
    enum stp_result result = attach(env, scene, volume);
    if (result != STP_OK) {
        mem_free(volume);
        return result;
    }
    *range = (struct range){ 0 };
    return STP_OK;
}

/* A disc covers the cell of its pixel on the surface. */
static void set_disc(struct cloud *cloud, size_t i, const struct range_pixel *p,
                     const float color[3])
{
    struct vec3 n = v3_unit(v3_cross(p->down, p->across)); /* against the ray */
    double wide = fmax(v3_length(p->across), v3_length(p->down));
    const double place[3] = { p->place.x, p->place.y, p->place.z };
    memcpy(cloud->position[i], place, sizeof place);
    v3_storef(n, cloud->normal[i]);
    cloud->radius[i] = (float)(wide * sqrt(0.5));
    memcpy(cloud->color[i], color, 3 * sizeof *color);
}

static void fill_discs(const struct range *range, struct cloud *cloud)
{
    struct range_pixel pixel;
    cloud->count = 0;
    for (unsigned f = 0; f < range->count; f++)
        for (uint32_t v = 0; v < range->frame[f].height; v++)
            for (uint32_t u = 0; u < range->frame[f].width; u++)
                if (range_pixel(range, f, u, v, &pixel))
                    set_disc(cloud, cloud->count++, &pixel,
                             range->frame[f].color[(size_t)v * range->frame[f].width + u]);
}

static enum stp_result add_discs(const struct stp_env *env, struct stp_scene *scene,
                                 const struct range *range, const struct stp_load_params *params)
{
    struct cloud cloud = { .up = STP_UP_NEG_Y, .format = "range images, discs" };
    const struct stp_material plain = { .ambient = 1, .albedo = { 0.8f, 0.8f, 0.8f } };
    struct stp_object_params object = { .material = params->material ? params->material : &plain,
                                        .epsilon = params->epsilon,
                                        .opacity = params->opacity,
                                        .optics = params->optics };
    size_t count = 0;
    for (unsigned f = 0; f < range->count; f++)
        for (size_t i = 0; i < (size_t)range->frame[f].width * range->frame[f].height; i++)
            count += range->frame[f].depth[i] > 0;
    cloud.position = mem_alloc(count, sizeof *cloud.position);
    cloud.normal = mem_alloc(count, sizeof *cloud.normal);
    cloud.radius = mem_alloc(count, sizeof *cloud.radius);
    cloud.color = mem_alloc(count, sizeof *cloud.color);
    enum stp_result result = STP_OK;
    if (!cloud.position || !cloud.normal || !cloud.radius || !cloud.color)
        result = log_no_memory(env, count * 52, "discs");
    else
        fill_discs(range, &cloud);
    if (result == STP_OK)
        result = scene_add_cloud(env, scene, &cloud, &object);
    cloud_release(&cloud);
    return result;
}

/* As the first frame saw it, in our own frame: y up, z backwards. */
static void first_camera(struct stp_scene *scene, const struct range_frame *frame)
{
    const struct range_camera *c = &frame->camera;
    struct vec3 eye = range_eye(frame);
    struct stp_camera made = { .fx = c->fx,
                               .fy = c->fy,
                               .cx = c->cx,
                               .cy = c->cy,
                               .width = frame->width,
                               .height = frame->height,
                               .near_depth = STP_DEFAULT_NEAR,
                               .far_depth = INFINITY };
    for (int i = 0; i < 3; i++) {
        double *row = made.world_to_camera + 4 * i, sign = i == 0 ? 1 : -1;
        for (int k = 0; k < 3; k++)
            row[k] = sign * c->to_world[4 * k + i];
        row[3] = -v3_dot(v3_load(row), eye);
    }
    made.world_to_camera[15] = 1;
    scene->camera = made;
    scene->has_camera = scene->camera_intrinsics = true;
}

enum stp_result range_show(const struct stp_env *env, struct stp_scene *scene, struct range *range,
                           enum stp_range_splats splats, const struct stp_load_params *params)
{
    const char *by = params->color_by;
    bool discs = splats == STP_RANGE_DISCS;
    if (by && strcmp(by, "rgb") != 0 && (discs || strcmp(by, "views") != 0))
        return log_error(env, STP_ERROR_ARGUMENT,
                         discs ? "range images as discs are coloured by rgb, not by %s"
                               : "range images are coloured by rgb or views, not by %s",
                         by);
    range->by_views = by && strcmp(by, "views") == 0;
    if (!scene->has_camera)
        first_camera(scene, &range->frame[0]);
    enum stp_result result =
        discs ? add_discs(env, scene, range, params) : scene_add_range(env, scene, range);
    if (result == STP_OK && params->up != STP_UP_AUTO)
        scene->facts.up = params->up;
    return result;
}
