/* What a view makes of ellipsoids: their weights and colours by the angles to their sources. */
#include <math.h>

#include "base/vec.h"
#include "prepare/range.h"
#include "scene/range.h"

struct range_view range_view_of(const struct stp_camera *camera)
{
    const double *m = camera->world_to_camera;
    struct range_view view = { .orthographic = camera->orthographic };
    for (int a = 0; a < 3; a++)
        view.eye[a] =
            camera->orthographic ? -m[8 + a] : -(m[a] * m[3] + m[4 + a] * m[7] + m[8 + a] * m[11]);
    return view;
}

/* The squared chord between the rays to the kernel: of the eye, and of a frame. */
static double chord2(const struct volume *volume, struct vec3 sight, struct vec3 place,
                     unsigned frame)
{
    struct vec3 source = v3_unit(v3_sub(place, range_eye(&volume->range.frame[frame])));
    struct vec3 d = v3_sub(sight, source);
    return v3_dot(d, d);
}

static struct vec3 sight_of(const struct range_view *view, struct vec3 place)
{
    return view->orthographic ? v3_load(view->eye) : v3_unit(v3_sub(place, v3_load(view->eye)));
}

double range_tau(const struct volume *volume, const struct range_view *view, size_t i)
{
    const struct kernels *k = &volume->kernels;
    struct vec3 place = v3_load(k->place[i]), sight = sight_of(view, place);
    double own = 0, sum = 0;
    for (size_t n = k->source_first[i]; n < k->source_first[i + 1]; n++) {
        double c2 = chord2(volume, sight, place, k->source[n].frame);
        double w = (double)k->source[n].weight / (1 + c2 / (RANGE_ANGLE * RANGE_ANGLE));
        own = n == k->source_first[i] ? w : own;
        sum += w;
    }
    return (double)k->tau[i] * (own / sum);
}

void range_color(const struct volume *volume, const struct range_view *view, size_t i,
                 double color[3])
{
    const struct kernels *k = &volume->kernels;
    struct vec3 place = v3_load(k->place[i]), sight = sight_of(view, place), sum = v3(0, 0, 0);
    double weights = 0;
    for (size_t n = k->source_first[i]; k->source_color && n < k->source_first[i + 1]; n++) {
        double c2 = chord2(volume, sight, place, k->source[n].frame);
        double falls = 1 / (1 + c2 / (RANGE_COLOR_ANGLE * RANGE_COLOR_ANGLE));
        double w = (double)k->source[n].weight * falls * falls;
        sum = v3_add(sum, v3_scale(v3_loadf(k->source_color[n]), w));
        weights += w;
    }
    sum = k->source_color ? v3_scale(sum, 1 / weights) : v3_loadf(k->color[i]);
    v3_store(sum, color);
}
