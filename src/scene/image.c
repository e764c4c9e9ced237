/* Pictures in memory; files of them are write/'s. */
#include <stipple/image.h>

#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/deep.h"

enum stp_result stp_image_create(const struct stp_env *env, uint32_t width, uint32_t height,
                                 struct stp_image **image)
{
    if (width == 0 || height == 0)
        return log_error(env, STP_ERROR_ARGUMENT, "a picture of %u x %u has no pixels", width,
                         height);
    struct stp_image *made = mem_zalloc(1, sizeof *made);
    if (!made)
        return log_no_memory(env, sizeof *made, "a picture");
    made->width = width;
    made->height = height;
    *image = made;
    return STP_OK;
}

static bool can_name(const struct stp_image *image, const char *name)
{
    size_t room = sizeof image->channels->name;
    return name[0] != '\0' && strnlen(name, room) < room && !stp_image_find(image, name);
}

enum stp_result stp_image_add(const struct stp_env *env, struct stp_image *image, const char *name,
                              enum stp_channel_type type, struct stp_channel **channel)
{
    if (!can_name(image, name))
        return log_error(
            env, STP_ERROR_ARGUMENT,
            "a plane called \"%.40s\": the name must be new to the picture, of 1 to %zu bytes",
            name, sizeof image->channels->name - 1);
    size_t pixels = (size_t)image->width * image->height;
    float *plane = mem_zalloc(pixels, sizeof *plane); /* a uint plane is as large */
    struct stp_channel *channels =
        mem_realloc(image->channels, image->channel_count + 1, sizeof *channels);
    if (channels)
        image->channels = channels;
    if (!plane || !channels) {
        mem_free(plane);
        return log_error(env, STP_ERROR_MEMORY, "out of memory: plane %s of a picture of %u x %u",
                         name, image->width, image->height);
    }
    struct stp_channel *made = &channels[image->channel_count++];
    *made = (struct stp_channel){ .type = type, .data.f = plane };
    strcpy(made->name, name);
    *channel = made;
    return STP_OK;
}

struct stp_channel *stp_image_find(const struct stp_image *image, const char *name)
{
    for (unsigned i = 0; i < image->channel_count; i++)
        if (strcmp(image->channels[i].name, name) == 0)
            return &image->channels[i];
    return NULL;
}

void stp_image_destroy(struct stp_image **image)
{
    if (!image || !*image)
        return;
    for (unsigned i = 0; i < (*image)->channel_count; i++)
        mem_free((*image)->channels[i].data.f);
    mem_free((*image)->channels);
    deep_destroy(&(*image)->deep);
    mem_free(*image);
    *image = NULL;
}
