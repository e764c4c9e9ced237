/* Eye-dome shading (docs/numerics.md, "Eye dome") and the background, over finished depths. */
#include "reference/planes.h"

#include "base/thread.h"

struct finish {
    const struct planes *planes;
    const struct view *view;
    const float *background;
    double diagonal; /* of the scene: the unit of orthographic depth differences */
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

static void finish_pixel(const struct finish *finish, uint32_t x, uint32_t y)
{
    float *const *color = finish->planes->color;
    const float *background = finish->background;
    size_t at = (size_t)y * finish->view->width + x;
    double shade = finish->view->scene->facts.eye_dome ? dome(finish, x, y) : 1;
    double behind = background ? (1.0 - color[3][at]) * background[3] : 0;
    for (int i = 0; i < 3; i++)
        color[i][at] = (float)(color[i][at] * shade + (background ? behind * background[i] : 0));
    color[3][at] = (float)(color[3][at] + behind);
}

static void finish_rows(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct finish *finish = context;
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < finish->view->width; x++)
            finish_pixel(finish, x, (uint32_t)y);
}

void planes_finish(const struct stp_env *env, const struct planes *planes, const struct view *view,
                   const float *background)
{
    const struct stp_facts *facts = &view->scene->facts;
    const double *b = facts->bounds;
    if (!facts->eye_dome && !background)
        return;
    struct finish finish = { .planes = planes,
                             .view = view,
                             .background = background,
                             .diagonal = v3_length(v3(b[3] - b[0], b[4] - b[1], b[5] - b[2])) };
    parallel_for(env, view->height, 16, finish_rows, &finish);
}
