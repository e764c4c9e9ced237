/* Automatic framing. A camera of fixed orientation holds a sphere when the sphere is inside four
 * planes through the eye; each plane's offset is a maximum over the splats, and the nearest eye
 * follows from the four in closed form. */
#include <math.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "scene/axes.h"
#include "scene/phong.h"
#include "scene/scene.h"

#define MARGIN     0.95 /* of half the picture */
#define NEAR_SHARE 1e-4 /* of the depth of the nearest splat */
#define DEGREES_30 0.52359877559829882
#define GRAIN      16384

/* Along the camera's axes, from the middle of the core. */
struct extremes {
    double side[4]; /* right left top bottom: the most that a plane must be moved out */
    double front;   /* the largest z + radius */
    double back;    /* the least z - radius */
};

struct framing {
    const struct stp_env *env;
    const struct stp_scene *scene;
    struct vec3 x, y, z, middle;
    double slope[2], length[2]; /* of the margin planes, and of their normals; 0, 1: orthographic */
    struct extremes *worker;
    const double (*position)[3]; /* of the splats, or of a block of them */
    const float *radius;
    const uint8_t *dropped; /* STREAM_DROPPED: not there; NULL: all are */
};

static bool is_in_core(const struct stp_scene *scene, const double p[3])
{
    for (int axis = 0; axis < 3; axis++)
        if (p[axis] < scene->core[axis] || p[axis] > scene->core[axis + 3])
            return false;
    return true;
}

static void add_sphere(const struct framing *f, struct extremes *e, struct vec3 d, double r)
{
    double x = v3_dot(f->x, d), y = v3_dot(f->y, d), z = v3_dot(f->z, d);
    double out_x = f->slope[0] * z + r * f->length[0], out_y = f->slope[1] * z + r * f->length[1];
    e->side[0] = fmax(e->side[0], out_x + x);
    e->side[1] = fmax(e->side[1], out_x - x);
    e->side[2] = fmax(e->side[2], out_y + y);
    e->side[3] = fmax(e->side[3], out_y - y);
    e->front = fmax(e->front, z + r);
    e->back = fmin(e->back, z - r);
}

/* How far an ellipse goes along w, from its centre. */
static double reach(const struct stp_phong_splat *p, struct vec3 n, struct vec3 w)
{
    struct vec3 u = v3_loadf(p->u), v = v3_cross(n, u);
    return fmax(0, phong_support(p, p->radius[0] * v3_dot(w, u), p->radius[1] * v3_dot(w, v)));
}

static void add_ellipse(const struct framing *f, struct extremes *e, struct vec3 d, size_t i)
{
    const struct stp_phong_splat *p = &f->scene->splats.phong[i];
    struct vec3 n = v3_loadf(f->scene->splats.normal[i]);
    for (int k = 0; k < 4; k++) {
        struct vec3 side = v3_scale(k < 2 ? f->x : f->y, k % 2 ? -1 : 1);
        struct vec3 w = v3_add(side, v3_scale(f->z, f->slope[k / 2]));
        e->side[k] = fmax(e->side[k], v3_dot(w, d) + reach(p, n, w));
    }
    double z = v3_dot(f->z, d);
    e->front = fmax(e->front, z + reach(p, n, f->z));
    e->back = fmin(e->back, z - reach(p, n, v3_scale(f->z, -1)));
}

static void extremes_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct framing *f = context;
    struct extremes e = f->worker[worker];
    const bool ellipses = !f->scene->stream && f->scene->splats.phong;
    for (size_t i = begin; i < end; i++)
        if (is_in_core(f->scene, f->position[i]) &&
            !(f->dropped && f->dropped[i] == STREAM_DROPPED)) {
            struct vec3 d = v3_sub(v3_load(f->position[i]), f->middle);
            if (ellipses && !phong_is_disc(&f->scene->splats.phong[i]))
                add_ellipse(f, &e, d, i);
            else
                add_sphere(f, &e, d, (double)f->radius[i]);
        }
    f->worker[worker] = e;
}

/* Of a cloud that stays in its file. */
static enum stp_result extremes_block(const struct stp_env *env, void *context, size_t first,
                                      struct cloud *cloud)
{
    struct framing *f = context;
    f->position = cloud->position;
    f->radius = cloud->radius;
    f->dropped = f->scene->stream->chunk_of + first;
    parallel_for(env, cloud->count, GRAIN, extremes_range, f);
    cloud_release(cloud);
    return STP_OK;
}

static enum stp_result visit(struct framing *f)
{
    const struct splats *s = &f->scene->splats;
    if (f->scene->stream)
        return stream_walk(f->env, f->scene->stream, NULL, 0, 1, extremes_block, f);
    f->position = s->position;
    f->radius = s->radius;
    parallel_for(f->env, s->count, GRAIN, extremes_range, f);
    return STP_OK;
}

/* A volume is its box: outliers do not exist, and kernels are many. */
static void box_extremes(const struct framing *f, struct extremes *e)
{
    const double *b = f->scene->core;
    for (int i = 0; i < 8; i++) {
        struct vec3 corner = v3(b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]);
        add_sphere(f, e, v3_sub(corner, f->middle), 0);
    }
}

/* Maxima do not depend on who found them. */
static enum stp_result find_extremes(struct framing *f, struct extremes *all)
{
    struct extremes none = { { -INFINITY, -INFINITY, -INFINITY, -INFINITY }, -INFINITY, INFINITY };
    unsigned threads = thread_count(f->env);
    *all = none;
    if (f->scene->volume) {
        box_extremes(f, all);
        return STP_OK;
    }
    f->worker = mem_alloc(threads, sizeof *f->worker);
    if (!f->worker)
        return log_no_memory(f->env, threads * sizeof *f->worker, "framing");
    for (unsigned i = 0; i < threads; i++)
        f->worker[i] = none;
    enum stp_result result = visit(f);
    for (unsigned i = 0; i < threads; i++) {
        for (int side = 0; side < 4; side++)
            all->side[side] = fmax(all->side[side], f->worker[i].side[side]);
        all->front = fmax(all->front, f->worker[i].front);
        all->back = fmin(all->back, f->worker[i].back);
    }
    mem_free(f->worker);
    return result;
}

static void aim(struct framing *f, const struct stp_frame_params *p)
{
    const double *core = f->scene->core;
    struct scene_axes a = scene_axes(p->up == STP_UP_AUTO ? f->scene->facts.up : p->up);
    double ca = cos(p->azimuth), sa = sin(p->azimuth);
    double ce = cos(p->elevation), se = sin(p->elevation);
    struct vec3 level = v3_add(v3_scale(a.viewer, ca), v3_scale(a.right, sa));
    f->x = v3_sub(v3_scale(a.right, ca), v3_scale(a.viewer, sa));
    f->z = v3_add(v3_scale(level, ce), v3_scale(a.up, se));
    f->y = v3_cross(f->z, f->x);
    f->middle = v3(0.5 * core[0] + 0.5 * core[3], 0.5 * core[1] + 0.5 * core[4],
                   0.5 * core[2] + 0.5 * core[5]);
}

static void place(const struct framing *f, struct vec3 eye, struct stp_camera *camera)
{
    struct vec3 at =
        v3_add(f->middle,
               v3_add(v3_scale(f->x, eye.x), v3_add(v3_scale(f->y, eye.y), v3_scale(f->z, eye.z))));
    const struct vec3 row[3] = { f->x, f->y, f->z };
    double *m = camera->world_to_camera;
    for (int i = 0; i < 3; i++) {
        m[4 * i] = row[i].x;
        m[4 * i + 1] = row[i].y;
        m[4 * i + 2] = row[i].z;
        m[4 * i + 3] = -v3_dot(row[i], at);
        m[12 + i] = 0;
    }
    m[15] = 1;
}

/* The pair of planes that binds sets the distance; the other is centred. */
static double perspective(const struct framing *f, const struct extremes *e, struct vec3 *eye)
{
    double distance_x = (e->side[0] + e->side[1]) / (2 * f->slope[0]);
    double distance_y = (e->side[2] + e->side[3]) / (2 * f->slope[1]);
    eye->z = fmax(distance_x, distance_y);
    return eye->z - e->front;
}

/* Returns the depth of the nearest splat. */
static double orthographic(const struct extremes *e, struct vec3 *eye, struct stp_camera *camera)
{
    double wide = e->side[0] + e->side[1], high = e->side[2] + e->side[3];
    double room = fmax(fmax(wide, high), e->front - e->back);
    camera->fx = camera->fy = MARGIN * fmin(camera->width / wide, camera->height / high);
    eye->z = e->front + room;
    return room;
}

static enum stp_result check(const struct stp_env *env, const struct stp_scene *scene,
                             const struct stp_frame_params *p)
{
    if (!scene->prepared)
        return log_error(env, STP_ERROR_ARGUMENT, "the scene must be prepared to be framed");
    if (scene->share.count)
        return log_error(env, STP_ERROR_ARGUMENT, "frame the scene before it is shared");
    if (!isfinite(p->azimuth) || !isfinite(p->elevation))
        return log_error(env, STP_ERROR_ARGUMENT, "the view's azimuth or elevation is not finite");
    if (!(p->fov_y >= 0 && p->fov_y < 3.1415))
        return log_error(env, STP_ERROR_ARGUMENT,
                         "a field of view of %g radians: it must be above 0 and below pi",
                         p->fov_y);
    return STP_OK;
}

enum stp_result stp_camera_frame(const struct stp_env *env, const struct stp_scene *scene,
                                 const struct stp_frame_params *params, struct stp_camera *camera)
{
    static const struct stp_frame_params defaults = { .azimuth = STP_ISO_AZIMUTH,
                                                      .elevation = STP_ISO_ELEVATION };
    const struct stp_frame_params *p = params ? params : &defaults;
    enum stp_result result = check(env, scene, p);
    if (result != STP_OK)
        return result;
    struct stp_camera c = { .orthographic = p->orthographic,
                            .width = p->width ? p->width : 1280,
                            .height = p->height ? p->height : 720,
                            .far_depth = INFINITY };
    struct framing f = { .env = env, .scene = scene, .length = { 1, 1 } };
    double tangent = tan(0.5 * (p->fov_y > 0 ? p->fov_y : DEGREES_30));
    for (int i = 0; i < 2 && !c.orthographic; i++) {
        f.slope[i] = MARGIN * tangent * (i == 0 ? (double)c.width / c.height : 1);
        f.length[i] = sqrt(1 + f.slope[i] * f.slope[i]);
    }
    struct extremes e = { 0 };
    aim(&f, p);
    result = find_extremes(&f, &e);
    if (result != STP_OK)
        return result;
    struct vec3 eye = v3((e.side[0] - e.side[1]) / 2, (e.side[2] - e.side[3]) / 2, 0);
    c.fx = c.fy = 0.5 * c.height / tangent;
    double nearest = c.orthographic ? orthographic(&e, &eye, &c) : perspective(&f, &e, &eye);
    c.cx = 0.5 * c.width;
    c.cy = 0.5 * c.height;
    c.near_depth = NEAR_SHARE * (nearest > 0 ? nearest : eye.z - e.back);
    place(&f, eye, &c);
    *camera = c;
    return STP_OK;
}
