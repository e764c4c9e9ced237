/* Eye-dome shading (docs/numerics.md, "Eye dome") and the background, over finished depths. */
#include "reference/planes.h"

#include "base/thread.h"
#include "reference/environment.h"

struct finish {
    const struct planes *planes;
    const struct view *view;
    const float *background; /* NULL: the environment's, or none */
    bool environment;        /* is behind */
    double diagonal;         /* of the scene: the unit of orthographic depth differences */
};

/* How far the neighbour rises above the pixel; 0 where it is empty or farther. */
static double rise(const struct finish *finish, double z, int64_t x, int64_t y)
{
    const struct view *view = finish->view;
    if (x < 0 || y < 0 || x >= view->width || y >= view->height)
        return 0;
    double other = finish->planes->z[(size_t)y * view->width + (size_t)x];
    if (!isfinite(other))
        return 0;
    if (!view->eye.orthographic)
        return fmax(0, log2(z) - log2(other));
    return finish->diagonal > 0 ? fmax(0, (z - other) / finish->diagonal * 16) : 0;
}

static double dome(const struct finish *finish, uint32_t x, uint32_t y)
{
    const struct view *view = finish->view;
    int64_t step = view->height / 512 > 1 ? view->height / 512 : 1;
    double z = finish->planes->z[(size_t)y * view->width + x], sum = 0;
    if (!isfinite(z))
        return 1;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++)
            if (dx != 0 || dy != 0)
                sum += rise(finish, z, x + dx * step, y + dy * step);
    return exp(-8 * (sum / 8));
}

/* What is behind a pixel, straight; *alpha 0: nothing is. */
static struct vec3 behind(const struct finish *finish, uint32_t x, uint32_t y, double *alpha)
{
    const struct eye *eye = &finish->view->eye;
    *alpha = finish->environment ? 1 : finish->background ? (double)finish->background[3] : 0;
    if (finish->environment)
        return environment_light(finish->view, v3_unit(eye_ray(eye, x + 0.5, y + 0.5).along), 0);
    return finish->background ? v3_loadf(finish->background) : v3(0, 0, 0);
}

static void finish_pixel(const struct finish *finish, uint32_t x, uint32_t y)
{
    float *const *color = finish->planes->color;
    size_t at = (size_t)y * finish->view->width + x;
    double shade = finish->view->scene->facts.eye_dome ? dome(finish, x, y) : 1, alpha;
    struct vec3 back = behind(finish, x, y, &alpha);
    const double light[3] = { back.x, back.y, back.z };
    double left = (1.0 - (double)color[3][at]) * alpha;
    for (int i = 0; i < 3; i++)
        color[i][at] = (float)((double)color[i][at] * shade + left * light[i]);
    color[3][at] = (float)((double)color[3][at] + left);
}

static void finish_rows(void *context, size_t begin, size_t end, unsigned)
{
    const struct finish *finish = context;
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < finish->view->width; x++)
            finish_pixel(finish, x, (uint32_t)y);
}

void planes_finish(const struct stp_env *env, const struct planes *planes, const struct view *view,
                   const struct stp_render_params *params)
{
    const struct stp_facts *facts = &view->scene->facts;
    const double *b = facts->bounds;
    if (!facts->eye_dome && !params->background && !params->environment_behind)
        return;
    struct finish finish = { .planes = planes,
                             .view = view,
                             .background = params->background,
                             .environment = params->environment_behind,
                             .diagonal = v3_length(v3(b[3] - b[0], b[4] - b[1], b[5] - b[2])) };
    parallel_for(env, view->height, 16, finish_rows, &finish);
}
