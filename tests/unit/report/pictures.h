/* Small pictures for the tests of the metrics. */
#ifndef TEST_PICTURES_H
#define TEST_PICTURES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <math.h>
#include <cmocka.h>

#include <stipple/compare.h>

static inline float *add_plane(struct stp_image *image, const char *name)
{
    struct stp_channel *channel;
    assert_int_equal(stp_image_add(NULL, image, name, STP_CHANNEL_FLOAT, &channel), STP_OK);
    return channel->data.f;
}

static inline float *plane_of(struct stp_image *image, const char *name)
{
    struct stp_channel *channel = stp_image_find(image, name);
    assert_non_null(channel);
    return channel->data.f;
}

/* R G B A Z N.X N.Y N.Z of one grey, opaque, at depth 1, facing +Z. */
static inline struct stp_image *grey_picture(uint32_t width, uint32_t height, float grey)
{
    static const char *const name[8] = { "R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z" };
    const float value[8] = { grey, grey, grey, 1, 1, 0, 0, 1 };
    struct stp_image *image;
    assert_int_equal(stp_image_create(NULL, width, height, &image), STP_OK);
    for (int c = 0; c < 8; c++) {
        float *plane = add_plane(image, name[c]);
        for (size_t i = 0; i < (size_t)width * height; i++)
            plane[i] = value[c];
    }
    return image;
}

static inline void set_color(struct stp_image *image, size_t i, float r, float g, float b)
{
    plane_of(image, "R")[i] = r;
    plane_of(image, "G")[i] = g;
    plane_of(image, "B")[i] = b;
}

static inline void set_empty(struct stp_image *image, size_t i)
{
    set_color(image, i, 0, 0, 0);
    plane_of(image, "A")[i] = 0;
    plane_of(image, "Z")[i] = INFINITY;
    plane_of(image, "N.Z")[i] = 0;
}

struct last_line {
    unsigned count;
    char text[1024];
};

static inline void keep_line(void *user, enum stp_log_level level, const char *line)
{
    struct last_line *last = user;
    last->count++;
    snprintf(last->text, sizeof last->text, "%s", line);
}

static inline uint32_t next_random(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

static inline float uniform(uint32_t *state)
{
    return (float)(next_random(state) >> 8) / 16777216.0f;
}

#endif
