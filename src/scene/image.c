/* Pictures in memory; files of them are write/'s. Nothing is logged here: these functions have no
 * env, and their callers that have one say what the plane was for. */
#include <stipple/image.h>

#include <string.h>

#include "base/memory.h"
#include "scene/deep.h"

enum stp_result stp_image_create(uint32_t width, uint32_t height, struct stp_image **image)
{
    if (width == 0 || height == 0)
        return STP_ERROR_ARGUMENT;
    struct stp_image *made = mem_zalloc(1, sizeof *made);
    if (!made)
        return STP_ERROR_MEMORY;
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

enum stp_result stp_image_add(struct stp_image *image, const char *name, enum stp_channel_type type,
                              struct stp_channel **channel)
{
    if (!can_name(image, name))
        return STP_ERROR_ARGUMENT;
    size_t pixels = (size_t)image->width * image->height;
    float *plane = mem_zalloc(pixels, sizeof *plane); /* a uint plane is as large */
    struct stp_channel *channels =
        mem_realloc(image->channels, image->channel_count + 1, sizeof *channels);
    if (channels)
        image->channels = channels;
    if (!plane || !channels) {
        mem_free(plane);
        return STP_ERROR_MEMORY;
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
