#include "ellipses.h"
#include "hard.h"

static void *must(void *pointer)
{
    assert_non_null(pointer);
    return pointer;
}

double hard_random(uint32_t *seed)
{
    return uniform(seed);
}

struct vec3 hard_color(uint32_t *seed)
{
    double r = hard_random(seed), g = hard_random(seed), b = hard_random(seed);
    return v3(r, g, b);
}

struct hard_points points_make(size_t capacity)
{
    size_t n = capacity + 1;
    return (struct hard_points){ .capacity = capacity,
                                 .position = must(calloc(n, sizeof(double[3]))),
                                 .normal = must(calloc(n, sizeof(float[3]))),
                                 .radius = must(calloc(n, sizeof(float))),
                                 .color = must(calloc(n, sizeof(float[3]))),
                                 .opacity = must(calloc(n, sizeof(float))),
                                 .phong = must(calloc(n, sizeof(struct stp_phong_splat))) };
}

void points_release(struct hard_points *cloud)
{
    free(cloud->position);
    free(cloud->normal);
    free(cloud->radius);
    free(cloud->color);
    free(cloud->opacity);
    free(cloud->phong);
    *cloud = (struct hard_points){ 0 };
}

size_t points_add(struct hard_points *cloud, struct vec3 p, struct vec3 n, double radius)
{
    size_t i = cloud->count++;
    assert_true(i < cloud->capacity);
    memcpy(cloud->position[i], (double[3]){ p.x, p.y, p.z }, sizeof cloud->position[i]);
    store(n, cloud->normal[i]);
    cloud->radius[i] = (float)radius;
    cloud->opacity[i] = 1;
    store(v3(0.5, 0.5, 0.5), cloud->color[i]);
    return i;
}

void points_round(struct hard_points *cloud)
{
    for (size_t i = 0; i < cloud->count; i++)
        for (int k = 0; k < 3; k++)
            cloud->position[i][k] = (float)cloud->position[i][k];
}

void points_fade(struct hard_points *cloud, size_t i, double opacity)
{
    cloud->opacity[i] = (float)opacity;
    cloud->faded = true;
}

void points_paint(struct hard_points *cloud, size_t i, struct vec3 color)
{
    store(color, cloud->color[i]);
    cloud->colored = true;
}

struct stp_phong_splat *points_bend(struct hard_points *cloud, size_t i, double angle,
                                    double radius_u, double radius_v)
{
    cloud->phong[i] = ellipse_across(cloud->normal[i], angle, radius_u, radius_v);
    cloud->bent = true;
    return &cloud->phong[i];
}

void points_move(struct hard_points *cloud, struct vec3 by)
{
    for (size_t i = 0; i < cloud->count; i++) {
        cloud->position[i][0] += by.x;
        cloud->position[i][1] += by.y;
        cloud->position[i][2] += by.z;
    }
}

static void swap_bytes(void *a, void *b, size_t size)
{
    char t[64];
    assert_true(size <= sizeof t);
    memcpy(t, a, size);
    memcpy(a, b, size);
    memcpy(b, t, size);
}

void points_shuffle(struct hard_points *cloud, uint32_t seed)
{
    for (size_t i = cloud->count; i > 1; i--) {
        size_t j = (size_t)(hard_random(&seed) * (double)i);
        swap_bytes(cloud->position[i - 1], cloud->position[j], sizeof cloud->position[j]);
        swap_bytes(cloud->normal[i - 1], cloud->normal[j], sizeof cloud->normal[j]);
        swap_bytes(&cloud->radius[i - 1], &cloud->radius[j], sizeof cloud->radius[j]);
        swap_bytes(cloud->color[i - 1], cloud->color[j], sizeof cloud->color[j]);
        swap_bytes(&cloud->opacity[i - 1], &cloud->opacity[j], sizeof cloud->opacity[j]);
        swap_bytes(&cloud->phong[i - 1], &cloud->phong[j], sizeof cloud->phong[j]);
    }
}

/* Radius in direction u; its gradient by differences. */
static double ball_radius(struct vec3 u, double bumps)
{
    return 1 + bumps * sin(5 * u.x) * sin(4 * u.y + 1) * cos(3 * u.z);
}

static struct vec3 ball_normal(struct vec3 u, double bumps)
{
    const double h = 1e-5;
    struct vec3 a = v3_unit(v3_cross(u, fabs(u.x) < 0.7 ? v3(1, 0, 0) : v3(0, 1, 0)));
    struct vec3 b = v3_cross(u, a), d[2] = { a, b }, t[2];
    for (int i = 0; i < 2; i++) {
        struct vec3 p = v3_unit(v3_add(u, v3_scale(d[i], h)));
        struct vec3 m = v3_unit(v3_sub(u, v3_scale(d[i], h)));
        t[i] = v3_sub(v3_scale(p, ball_radius(p, bumps)), v3_scale(m, ball_radius(m, bumps)));
    }
    struct vec3 n = v3_unit(v3_cross(t[0], t[1]));
    return v3_dot(n, u) < 0 ? v3_scale(n, -1) : n;
}

struct hard_points points_ball(const struct hard_options *o, struct vec3 centre, double bumps)
{
    struct hard_points cloud = points_make(o->points);
    uint32_t seed = o->seed;
    double spin = 6.28 * hard_random(&seed), spacing = sqrt(4 * M_PI / (double)o->points);
    for (size_t i = 0; i < o->points; i++) {
        double z = 1 - (2 * (double)i + 1) / (double)o->points, ring = sqrt(1 - z * z);
        double turn = (double)i * 2.39996322972865332 + spin;
        struct vec3 u = v3(ring * cos(turn), z, ring * sin(turn));
        struct vec3 p = v3_add(centre, v3_scale(u, ball_radius(u, bumps)));
        size_t at = points_add(&cloud, p, ball_normal(u, bumps),
                               spacing * (0.9 + 0.2 * hard_random(&seed)));
        points_paint(&cloud, at, v3(0.5 + 0.4 * u.x, 0.5 + 0.4 * u.y, 0.5 + 0.4 * u.z));
    }
    return cloud;
}

enum stp_result points_try(const struct stp_env *env, const struct hard_points *cloud,
                           double epsilon, struct stp_scene **scene)
{
    struct stp_points points = { .count = cloud->count,
                                 .position = (const double(*)[3])cloud->position,
                                 .normal =
                                     cloud->no_normals ? NULL : (const float(*)[3])cloud->normal,
                                 .radius = cloud->no_radii ? NULL : cloud->radius,
                                 .color = cloud->colored ? (const float(*)[3])cloud->color : NULL,
                                 .opacity = cloud->faded ? cloud->opacity : NULL,
                                 .phong = cloud->bent ? cloud->phong : NULL };
    struct stp_object_params object = { .epsilon = epsilon };
    struct stp_scene *made = NULL;
    assert_int_equal(stp_scene_create(env, &made), STP_OK);
    enum stp_result result = stp_scene_add_points(env, made, &points, &object);
    if (result == STP_OK)
        result = stp_scene_prepare(env, made, NULL);
    if (result == STP_OK)
        *scene = made;
    else
        stp_scene_destroy(&made);
    return result;
}

struct stp_scene *points_scene(const struct hard_points *cloud, double epsilon, unsigned threads)
{
    struct stp_env env = { .threads = threads };
    struct stp_scene *scene = NULL;
    assert_int_equal(points_try(&env, cloud, epsilon, &scene), STP_OK);
    return scene;
}

struct vec3 hard_edge_on(struct vec3 p, uint32_t *seed)
{
    return v3_unit(v3_cross(v3_unit(v3_cross(p, random_point(seed, 1))), p));
}

struct vec3 hard_towards_eye(const struct hard_options *o)
{
    return v3(cos(o->rise) * sin(o->turn), sin(o->rise), cos(o->rise) * cos(o->turn));
}

struct stp_camera hard_look(const struct hard_options *o, struct vec3 target, double distance,
                            double fov_y)
{
    bool flat = fov_y == 0;
    double focal = flat ? o->height / distance : o->height / 2.0 / tan(fov_y * M_PI / 360);
    struct stp_camera camera = plain_camera(o->width, o->height, focal);
    camera.orthographic = flat;
    camera.near_depth = 1e-4 * distance;
    look_at(&camera, v3_add(target, v3_scale(hard_towards_eye(o), distance)), target);
    return camera;
}

void hard_show(struct hard_scene *s, struct hard_points *cloud, struct stp_camera camera,
               double min_splat)
{
    points_round(cloud);
    s->scene = points_scene(cloud, 0.02, 2);
    s->camera = camera;
    s->params = (struct stp_render_params){ .min_splat = min_splat };
    points_release(cloud);
}

void hard_show_ball(const struct hard_options *o, struct hard_scene *s, struct hard_points *cloud)
{
    s->scene = points_scene(cloud, 0, 2);
    s->camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .min_splat = -1 };
    points_release(cloud);
}
