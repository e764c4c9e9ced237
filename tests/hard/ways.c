#include "hard.h"

const struct hard_way hard_ways[HARD_WAYS] = {
    { "exact", STP_METHOD_EXACT, STP_PATH_COMPUTE, STP_PAYLOAD_AUTO, STP_TRANSPARENCY_AUTO },
    { "exact, ids", STP_METHOD_EXACT, STP_PATH_COMPUTE, STP_PAYLOAD_ID, STP_TRANSPARENCY_AUTO },
    { "two-pass compute", STP_METHOD_TWO_PASS, STP_PATH_COMPUTE, STP_PAYLOAD_AUTO,
      STP_TRANSPARENCY_AUTO },
    { "two-pass raster", STP_METHOD_TWO_PASS, STP_PATH_RASTER, STP_PAYLOAD_AUTO,
      STP_TRANSPARENCY_AUTO },
    { "deferred compute", STP_METHOD_DEFERRED, STP_PATH_COMPUTE, STP_PAYLOAD_AUTO,
      STP_TRANSPARENCY_AUTO },
    { "deferred raster", STP_METHOD_DEFERRED, STP_PATH_RASTER, STP_PAYLOAD_AUTO,
      STP_TRANSPARENCY_AUTO },
    { "reference", STP_METHOD_REFERENCE, STP_PATH_AUTO, STP_PAYLOAD_AUTO, STP_TRANSPARENCY_AUTO },
};

const struct hard_way hard_layer_ways[HARD_LAYER_WAYS] = {
    { "exact", STP_METHOD_EXACT, STP_PATH_COMPUTE, STP_PAYLOAD_AUTO, STP_TRANSPARENCY_EXACT },
    { "exact, ids", STP_METHOD_EXACT, STP_PATH_COMPUTE, STP_PAYLOAD_ID, STP_TRANSPARENCY_EXACT },
    { "reference", STP_METHOD_REFERENCE, STP_PATH_AUTO, STP_PAYLOAD_AUTO,
      STP_TRANSPARENCY_REFERENCE },
    { "peel", STP_METHOD_TWO_PASS, STP_PATH_RASTER, STP_PAYLOAD_AUTO, STP_TRANSPARENCY_PEEL },
    { "nearest", STP_METHOD_DEFERRED, STP_PATH_RASTER, STP_PAYLOAD_AUTO, STP_TRANSPARENCY_NEAREST },
    { "fast", STP_METHOD_DEFERRED, STP_PATH_RASTER, STP_PAYLOAD_AUTO, STP_TRANSPARENCY_FAST },
};

const struct hard_way *hard_ways_of(const struct stp_scene *scene, unsigned *count)
{
    bool exactly = scene->environment.map.width > 0 || scene->facts.phong > 0;
    *count = !scene->facts.transparent ? HARD_WAYS : exactly ? HARD_EXACT_WAYS : HARD_LAYER_WAYS;
    return scene->facts.transparent ? hard_layer_ways : hard_ways;
}

bool hard_approximates(const struct hard_way *way)
{
    return way->transparency == STP_TRANSPARENCY_FAST ||
           way->transparency == STP_TRANSPARENCY_NEAREST;
}

struct stp_render_params hard_way_params(const struct hard_way *way,
                                         const struct stp_render_params *params)
{
    struct stp_render_params p = *params;
    p.method = way->method;
    p.path = way->path;
    p.payload = way->payload;
    p.transparency = way->transparency;
    if (hard_approximates(way))
        p.aovs &= ~(unsigned)STP_AOV_LAYERS; /* they do not count them */
    return p;
}

void hard_group(struct stp_scene *scene)
{
    struct stp_group_params groups = { .overlap = 1, .relax = STP_RELAX_NONE };
    struct stp_env quiet = { .threads = 2 };
    if (scene->facts.transparent)
        assert_int_equal(stp_scene_cover(&quiet, scene, NULL), STP_OK);
    else if (scene->facts.splats <= STP_MAX_GROUPS)
        scene_own_groups(scene);
    else
        assert_int_equal(stp_scene_group(&quiet, scene, &groups), STP_OK);
}

struct stp_image *hard_reference(const struct stp_scene *scene, const struct stp_camera *camera,
                                 const struct stp_render_params *params)
{
    struct stp_env env = { .threads = 2 };
    struct stp_image *image = NULL;
    assert_int_equal(reference_render(&env, scene, camera, params, &image), STP_OK);
    return image;
}

static const float *plane(const struct stp_image *image, const char *name)
{
    struct stp_channel *channel = stp_image_find(image, name);
    assert_non_null(channel);
    return channel->data.f;
}

static double decibels(double squares, size_t values)
{
    return squares > 0 ? -10 * log10(squares / (double)values) : INFINITY;
}

double hard_worst(const struct hard_scene *s, const struct stp_image *image, hard_pixel_fn pixel)
{
    double worst = 0;
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t px = i % image->width, py = i / image->width;
        if (!isfinite(value(image, "Z", px, py)))
            continue;
        worst = fmax(worst, pixel(s, image, px, py));
    }
    return worst;
}

double hard_psnr(const struct stp_image *image, const struct stp_image *truth)
{
    static const char *const names[] = { "N.X", "N.Y", "N.Z" };
    const float *z = plane(image, "Z"), *right = plane(truth, "Z");
    size_t count = (size_t)truth->width * truth->height, both = 0;
    double normal = 0, depth = 0;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(z[i]) || !isfinite(right[i]))
            continue;
        double relative = ((double)z[i] - right[i]) / right[i];
        depth += relative * relative;
        for (int k = 0; k < 3; k++) {
            double d = (double)plane(image, names[k])[i] - plane(truth, names[k])[i];
            normal += d * d;
        }
        both++;
    }
    assert_true(both > 0);
    return fmin(decibels(normal, 3 * both), decibels(depth, both));
}
