#include "reference/planes.h"

#include <string.h>

struct wanted {
    const char *name;
    unsigned aov; /* 0: always there */
    float **plane;
};

static enum stp_result add_planes(const struct stp_env *env, struct stp_image *image, unsigned aovs,
                                  struct planes *p)
{
    struct wanted wanted[] = {
        { "R", 0, &p->color[0] },
        { "G", 0, &p->color[1] },
        { "B", 0, &p->color[2] },
        { "A", 0, &p->color[3] },
        { "Z", 0, &p->z },
        { "N.X", 0, &p->normal[0] },
        { "N.Y", 0, &p->normal[1] },
        { "N.Z", 0, &p->normal[2] },
        { "albedo.R", STP_AOV_ALBEDO, &p->albedo[0] },
        { "albedo.G", STP_AOV_ALBEDO, &p->albedo[1] },
        { "albedo.B", STP_AOV_ALBEDO, &p->albedo[2] },
        { "P.X", STP_AOV_POSITION, &p->position[0] },
        { "P.Y", STP_AOV_POSITION, &p->position[1] },
        { "P.Z", STP_AOV_POSITION, &p->position[2] },
        { "weight", STP_AOV_WEIGHT, &p->weight },
        { "fragments", STP_AOV_FRAGMENTS, &p->fragments },
        { "coverage", STP_AOV_COVERAGE, &p->coverage },
        { "layers", STP_AOV_LAYERS, &p->layers },
    };
    struct stp_channel *channel;
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        if (wanted[i].aov && !(aovs & wanted[i].aov))
            continue;
        enum stp_result result =
            stp_image_add(env, image, wanted[i].name, STP_CHANNEL_FLOAT, &channel);
        if (result != STP_OK)
            return result;
        *wanted[i].plane = channel->data.f;
    }
    if (!(aovs & STP_AOV_ID))
        return STP_OK;
    enum stp_result result = stp_image_add(env, image, "id", STP_CHANNEL_UINT, &channel);
    if (result == STP_OK)
        p->id = channel->data.u;
    return result;
}

enum stp_result planes_create(const struct stp_env *env, const struct stp_scene *scene,
                              const struct stp_camera *camera, unsigned aovs,
                              struct stp_image **image, struct planes *planes)
{
    struct stp_image *made;
    struct planes filled = { 0 };
    enum stp_result result = stp_image_create(env, camera->width, camera->height, &made);
    if (result != STP_OK)
        return result;
    result = add_planes(env, made, aovs, &filled);
    if (result != STP_OK) {
        stp_image_destroy(&made);
        return result;
    }
    made->has_camera = true;
    made->camera = *camera;
    made->two_sided = scene->facts.two_sided;
    memcpy(made->origin, scene->splats.origin, sizeof made->origin);
    *planes = filled;
    *image = made;
    return STP_OK;
}

static void write3(float *const plane[3], size_t at, struct vec3 v)
{
    if (!plane[0])
        return;
    plane[0][at] = (float)v.x;
    plane[1][at] = (float)v.y;
    plane[2][at] = (float)v.z;
}

static void write1(float *plane, size_t at, double value)
{
    if (plane)
        plane[at] = (float)value;
}

/* Planes start at 0, which is right for an empty pixel but for these two. */
static void write_empty(const struct planes *planes, size_t at)
{
    planes->z[at] = INFINITY;
    if (planes->id)
        planes->id[at] = UINT32_MAX;
}

void planes_write(const struct planes *planes, const struct view *view, size_t at,
                  const struct pixel *pixel)
{
    const struct surface *s = &pixel->nearest;
    double samples = (double)view->grid * view->grid;
    if (pixel->hits == 0) {
        write_empty(planes, at);
        return;
    }
    write3(planes->color, at, v3_scale(pixel->color, 1 / samples));
    write1(planes->color[3], at, pixel->alpha / samples);
    write1(planes->z, at, s->depth);
    write3(planes->normal, at, eye_direction_to_world(&view->eye, s->normal));
    write3(planes->albedo, at, s->albedo);
    write3(planes->position, at, eye_point_to_world(&view->eye, s->point));
    write1(planes->weight, at, s->weight);
    write1(planes->fragments, at, s->count);
    write1(planes->coverage, at, pixel->hits / samples);
    write1(planes->layers, at, s->layers);
    if (planes->id)
        planes->id[at] = view->scene->splats.input[s->id];
}
