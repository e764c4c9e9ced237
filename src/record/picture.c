#include "record/record.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/vec.h"
#include "scene/samples.h"
#include "scene/scene.h"

static enum stp_result add_planes(const struct stp_env *env, struct stp_image *image,
                                  const char *const *names)
{
    for (; *names; names++) {
        struct stp_channel *channel;
        bool id = strcmp(*names, "id") == 0;
        enum stp_result result =
            stp_image_add(env, image, *names, id ? STP_CHANNEL_UINT : STP_CHANNEL_FLOAT, &channel);
        if (result != STP_OK)
            return result;
    }
    return STP_OK;
}

static enum stp_result add_aovs(const struct stp_env *env, struct stp_image *image, unsigned aovs)
{
    static const struct {
        unsigned aov;
        const char *names[4];
    } table[] = {
        { STP_AOV_ALBEDO, { "albedo.R", "albedo.G", "albedo.B" } },
        { STP_AOV_POSITION, { "P.X", "P.Y", "P.Z" } },
        { STP_AOV_WEIGHT, { "weight" } },
        { STP_AOV_FRAGMENTS, { "fragments" } },
        { STP_AOV_COVERAGE, { "coverage" } },
        { STP_AOV_ID, { "id" } },
        { STP_AOV_LAYERS, { "layers" } },
    };
    enum stp_result result = STP_OK;
    for (unsigned i = 0; result == STP_OK && i < sizeof table / sizeof *table; i++)
        if (aovs & table[i].aov)
            result = add_planes(env, image, table[i].names);
    return result;
}

enum stp_result record_picture(const struct stp_env *env, const struct stp_plan *plan,
                               struct stp_image **image)
{
    static const char *const planes[] = { "R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z", NULL };
    struct stp_image *made = NULL;
    enum stp_result result = stp_image_create(env, plan->camera.width, plan->camera.height, &made);
    if (result == STP_OK)
        result = add_planes(env, made, planes);
    if (result == STP_OK)
        result = add_aovs(env, made, plan->params.aovs);
    if (result != STP_OK) {
        stp_image_destroy(&made);
        return result;
    }
    made->has_camera = true;
    made->camera = plan->camera;
    memcpy(made->origin, plan->facts.origin, sizeof made->origin);
    made->two_sided = plan->facts.two_sided;
    *image = made;
    return STP_OK;
}

/* The planes of a picture and a tile's outputs, found once. */
struct copying {
    const struct record_frame *frame;
    const struct stp_plan *plan;
    const struct stp_scene *scene;
    const float *color, *normal, *depth, *albedo;
    const uint32_t *id;
    size_t id_words; /* a pixel */
    unsigned grid;   /* samples a side */
    float *rgba[4], *n[3], *z, *alb[3], *p[3], *weight, *fragments, *coverage, *layers;
    uint32_t *ids;
};

const void *record_output(const struct record_frame *frame, enum plan_slot slot)
{
    uint8_t i = plan_find(frame->plan, slot);
    if (i == PLAN_NONE)
        return NULL;
    return frame->read_back[i].handle ? frame->read_back[i].mapped
                                      : frame->resources.buffer[i].mapped;
}

static float *plane(const struct stp_image *image, const char *name)
{
    struct stp_channel *channel = stp_image_find(image, name);
    return channel ? channel->data.f : NULL;
}

static void find_planes(struct copying *c, const struct stp_image *image)
{
    static const char *const rgba[] = { "R", "G", "B", "A" };
    static const char *const normal[] = { "N.X", "N.Y", "N.Z" };
    static const char *const albedo[] = { "albedo.R", "albedo.G", "albedo.B" };
    static const char *const position[] = { "P.X", "P.Y", "P.Z" };
    for (int i = 0; i < 4; i++)
        c->rgba[i] = plane(image, rgba[i]);
    for (int i = 0; i < 3; i++) {
        c->n[i] = plane(image, normal[i]);
        c->alb[i] = plane(image, albedo[i]);
        c->p[i] = plane(image, position[i]);
    }
    c->z = plane(image, "Z");
    c->weight = plane(image, "weight");
    c->fragments = plane(image, "fragments");
    c->coverage = plane(image, "coverage");
    c->layers = plane(image, "layers");
    struct stp_channel *ids = stp_image_find(image, "id");
    c->ids = ids ? ids->data.u : NULL;
}

/* The point at depth z on the ray of the pixel's sample, relative to the origin; in double. */
static void position_of(const struct copying *c, uint32_t x, uint32_t y, uint32_t sample, double z,
                        size_t at)
{
    const struct stp_camera *camera = &c->plan->camera;
    double px, py;
    sample_position(c->grid, x, y, sample, &px, &py);
    double dx = (px - camera->cx) / camera->fx, dy = -(py - camera->cy) / camera->fy;
    double scale = camera->orthographic ? 1 : z;
    const double *m = camera->world_to_camera;
    struct vec3 e =
        v3_sub(v3(dx * scale, dy * scale, -z), m4_point(m, v3_load(c->plan->facts.origin)));
    bool hit = isfinite(z);
    for (int k = 0; k < 3; k++)
        c->p[k][at] = hit ? (float)(m[k] * e.x + m[4 + k] * e.y + m[8 + k] * e.z) : 0;
}

static uint32_t input_of(const struct copying *c, uint32_t id, uint32_t sample)
{
    return id < c->scene->splats.count ? c->scene->splats.input[id]
                                       : record_ghost_input(c->frame, id, sample);
}

static void copy_pixel(const struct copying *c, size_t from, size_t at, uint32_t x, uint32_t y)
{
    bool hit = isfinite(c->depth[from]), many = c->grid > 1;
    const uint32_t *id = c->id ? c->id + c->id_words * from : NULL; /* frame.h says of what */
    for (int k = 0; k < 4; k++)
        c->rgba[k][at] = c->color[4 * from + (size_t)k];
    for (int k = 0; k < 3; k++) {
        c->n[k][at] = c->normal[3 * from + (size_t)k];
        if (c->alb[k])
            c->alb[k][at] = c->albedo[4 * from + (size_t)k];
    }
    c->z[at] = c->depth[from];
    if (c->p[0])
        position_of(c, x, y, many ? id[2] : 0, c->depth[from], at);
    if (c->weight)
        c->weight[at] = c->albedo[4 * from + 3];
    if (c->fragments)
        c->fragments[at] = hit ? (float)id[1] : 0;
    if (c->coverage)
        c->coverage[at] = hit && many ? (float)((double)id[3] / plan_samples(c->plan)) : hit;
    if (c->layers)
        c->layers[at] = hit && c->plan->facts.transparent ? (float)id[c->id_words - 1] : hit;
    if (c->ids)
        c->ids[at] = hit ? input_of(c, id[0], many ? id[2] : 0) : STP_NO_ID;
}

enum stp_result record_invalidate(const struct stp_env *env, struct record_frame *frame)
{
    struct stp_context *c = frame->context;
    for (uint32_t i = 0; i < frame->plan->resource_count; i++) {
        struct gpu_buffer *b =
            frame->read_back[i].handle ? &frame->read_back[i] : &frame->resources.buffer[i];
        if (frame->plan->resource[i].lifetime != PLAN_OUTPUT || b->coherent)
            continue;
        VkMappedMemoryRange range = { .sType = VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE,
                                      .memory = b->memory.where.memory,
                                      .size = VK_WHOLE_SIZE };
        VkResult status = c->vk.vkInvalidateMappedMemoryRanges(c->device, 1, &range);
        if (status != VK_SUCCESS)
            return gpu_error(env, status, "vkInvalidateMappedMemoryRanges");
    }
    return STP_OK;
}

enum stp_result record_read_back(const struct stp_env *env, struct record_frame *frame,
                                 const struct stp_scene *scene, const struct plan_tile *tile,
                                 struct stp_image *image)
{
    struct copying c = { .frame = frame,
                         .plan = frame->plan,
                         .scene = scene,
                         .color = record_output(frame, PLAN_OUT_COLOR),
                         .normal = record_output(frame, PLAN_OUT_NORMAL),
                         .depth = record_output(frame, PLAN_OUT_DEPTH),
                         .albedo = record_output(frame, PLAN_OUT_ALBEDO),
                         .id = record_output(frame, PLAN_OUT_ID),
                         .grid = frame->plan->constant[PLAN_SAMPLE_GRID] };
    c.id_words = plan_id_words(frame->plan);
    enum stp_result result = record_invalidate(env, frame);
    if (result != STP_OK)
        return result;
    find_planes(&c, image);
    for (uint32_t y = tile->keep[1]; y < tile->keep[3]; y++)
        for (uint32_t x = tile->keep[0]; x < tile->keep[2]; x++)
            copy_pixel(&c, (size_t)(y - tile->y) * tile->width + (x - tile->x),
                       (size_t)y * image->width + x, x, y);
    return STP_OK;
}
