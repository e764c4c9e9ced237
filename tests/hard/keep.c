#include "hard.h"

#include <ctype.h>

void hard_slug(const char *family, const struct hard_case *c, char slug[HARD_SLUG])
{
    int length = snprintf(slug, HARD_SLUG, "%s_%s", family, c->name);
    for (int i = 0; i < length && i < HARD_SLUG - 1; i++)
        if (!isalnum((unsigned char)slug[i]))
            slug[i] = '_';
}

void hard_keep(const struct hard_options *o, const struct hard_scene *s, const char *slug,
               const struct stp_image *image, unsigned way)
{
    char path[512];
    if (o->pictures && way == 0) {
        snprintf(path, sizeof path, "%s/%s.png", o->pictures, slug);
        assert_int_equal(stp_image_write_png(NULL, image, path, 0), STP_OK);
    }
    if (!o->write)
        return;
    snprintf(path, sizeof path, "%s/%s.%u.exr", o->write, slug, way);
    assert_int_equal(stp_image_write_exr(NULL, image, path, NULL), STP_OK);
    if (way > 0)
        return;
    snprintf(path, sizeof path, "%s/%s.ply", o->write, slug);
    if (!s->scene->volume)
        assert_int_equal(stp_scene_save(NULL, s->scene, path), STP_OK);
    snprintf(path, sizeof path, "%s/%s.json", o->write, slug);
    assert_int_equal(stp_camera_save(NULL, path, &s->camera), STP_OK);
}

/* No NaN, no Inf but in Z, no alpha or light below 0, no alpha above 1. */
bool hard_sound(const struct stp_image *image)
{
    bool right = true;
    for (unsigned c = 0; c < image->channel_count; c++) {
        const struct stp_channel *channel = &image->channels[c];
        bool light = strchr("RGBA", channel->name[0]) && channel->name[1] == 0;
        for (size_t i = 0; i < (size_t)image->width * image->height; i++) {
            float v = channel->data.f[i];
            if (channel->type != STP_CHANNEL_FLOAT || strcmp(channel->name, "Z") == 0)
                right = right && (channel->type != STP_CHANNEL_FLOAT || !isnan(v));
            else
                right = right && isfinite(v) && (!light || v >= 0) &&
                        (strcmp(channel->name, "A") != 0 || v <= 1);
        }
    }
    return right;
}
