/* A frame's picture to its files. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static bool is_half_channel(const char *name)
{
    return (strlen(name) == 1 && strchr("RGBA", *name)) || strncmp(name, "N.", 2) == 0 ||
           strncmp(name, "albedo.", 7) == 0;
}

static void mark_half(struct stp_image *image)
{
    for (unsigned i = 0; i < image->channel_count; i++)
        image->channels[i].half = is_half_channel(image->channels[i].name);
}

/* One kind of file; the parameters say what is written into it. */
struct kind {
    const char *path; /* as on the command line; NULL: not wanted */
    enum stp_result (*write)(struct console *console, const struct settings *settings,
                             const struct stp_image *image, const char *path,
                             const struct stp_exr_params *params);
};

static enum stp_result write_flat(struct console *console, const struct settings *,
                                  const struct stp_image *image, const char *path,
                                  const struct stp_exr_params *params)
{
    return stp_image_write_exr(&console->env, image, path, params);
}

static enum stp_result write_deep(struct console *console, const struct settings *,
                                  const struct stp_image *image, const char *path,
                                  const struct stp_exr_params *params)
{
    return stp_image_write_deep_exr(&console->env, image, path, params);
}

static enum stp_result write_preview(struct console *console, const struct settings *settings,
                                     const struct stp_image *image, const char *path,
                                     const struct stp_exr_params *)
{
    return stp_image_write_png(&console->env, image, path, settings->exposure);
}

/* `path` itself, or the frame's path from the pattern. */
static enum stp_result write_kind(struct console *console, const struct settings *settings,
                                  const struct stp_image *image, const struct kind *kind,
                                  uint32_t index, const struct stp_exr_params *params)
{
    char *path =
        option_given(settings, "frames") ? pattern_expand(kind->path, index) : strdup(kind->path);
    if (!path) {
        console_error(console, "out of memory");
        return STP_ERROR_MEMORY;
    }
    signals_hold();
    enum stp_result result = kind->write(console, settings, image, path, params);
    signals_release();
    free(path);
    return result;
}

int write_pictures(struct console *console, const struct settings *settings,
                   const struct stp_plan *plan, struct stp_image *image, uint32_t index)
{
    const struct kind kinds[] = { { settings->output, write_flat },
                                  { settings->deep, write_deep },
                                  { settings->preview, write_preview } };
    struct stp_plan_summary summary;
    struct stp_exr_params params = settings->exr;
    stp_plan_summarize(plan, &summary);
    params.comment = summary.why;
    if (settings->half)
        mark_half(image);
    enum stp_result result = STP_OK;
    for (unsigned i = 0; i < sizeof kinds / sizeof *kinds && result == STP_OK; i++)
        if (kinds[i].path)
            result = write_kind(console, settings, image, &kinds[i], index, &params);
    return result == STP_OK ? EXIT_DONE : EXIT_FAILED;
}
