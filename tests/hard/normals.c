/* Normals that are missing, damaged or turned inwards, on a sphere whose own are known. */
#include "hard.h"

static void look(const struct hard_options *o, struct hard_scene *s,
                 const struct hard_points *cloud)
{
    s->scene = points_scene(cloud, 0, 2);
    s->camera = hard_look(o, v3(0, 0, 0), 4.6, 30);
    s->params = (struct stp_render_params){ .min_splat = -1, .aovs = STP_AOV_POSITION };
    s->truth[0] = s->scene->facts.radius_max;
    s->truth[1] = 1;
}

/* A disc of radius r turns by r from the middle of one to the middle of the next: the average stays
 * within that of the sphere's normal, turned to the eye, where the ray is not grazing. An estimated
 * normal adds its own: the plane of 12 neighbours within h turns by h / sqrt 3 at most (Cauchy and
 * Schwarz, whichever side they lie on), 1.05 discs of the spacing here; the average of given ones
 * by the distance of the eighth, where that is the only one: 1.5 discs. */
static double check_normals(const struct hard_scene *s, const struct stp_image *image)
{
    struct vec3 eye = eye_of_camera(&s->camera);
    double worst = 0;
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t px = i % image->width, py = i / image->width;
        if (!isfinite(value(image, "Z", px, py)))
            continue;
        struct vec3 p = v3(value(image, "P.X", px, py) + image->origin[0],
                           value(image, "P.Y", px, py) + image->origin[1],
                           value(image, "P.Z", px, py) + image->origin[2]);
        struct vec3 n = v3(value(image, "N.X", px, py), value(image, "N.Y", px, py),
                           value(image, "N.Z", px, py));
        struct vec3 out = v3_unit(p), view = v3_unit(v3_sub(eye, p));
        double facing = v3_dot(out, view);
        if (fabs(facing) < 0.35)
            continue;
        worst = fmax(worst, v3_length(v3_sub(n, facing < 0 ? v3_scale(out, -1) : out)));
    }
    return worst / (s->truth[1] * s->truth[0]);
}

static void damaged(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    uint32_t seed = o->seed + 5;
    size_t bad = 0;
    for (size_t i = 0; i < cloud.count; i++) {
        float scale = (float)pow(10, 6 * hard_random(&seed) - 3), *n = cloud.normal[i];
        for (int k = 0; k < 3; k++)
            n[k] *= scale;
        if (i % 8 == 0)
            n[i % 3] = NAN;
        if (i % 8 == 3)
            n[i % 3] = INFINITY;
        if (i % 8 == 6)
            n[0] = n[1] = n[2] = 0;
        bad += i % 8 == 0 || i % 8 == 3 || i % 8 == 6;
    }
    look(o, s, &cloud);
    s->truth[1] = 2.5;
    assert_int_equal(s->scene->facts.bad_normals, bad);
    points_release(&cloud);
}

static void turn_inwards(struct hard_points *cloud)
{
    for (size_t i = 0; i < cloud->count; i++)
        for (int k = 0; k < 3; k++)
            cloud->normal[i][k] = -cloud->normal[i][k];
}

static void inward_closed(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    turn_inwards(&cloud);
    look(o, s, &cloud);
    points_release(&cloud);
}

/* The half of the sphere that is farther from the eye, and a rim: a bowl, seen from within. */
static void bowl(const struct hard_options *o, struct hard_scene *s, bool inwards)
{
    struct hard_points ball = points_ball(o, v3(0, 0, 0), 0), cloud = points_make(ball.count);
    struct vec3 axis = hard_towards_eye(o);
    for (size_t i = 0; i < ball.count; i++) {
        struct vec3 p = v3_load(ball.position[i]);
        if (v3_dot(p, axis) < 0.2)
            points_add(&cloud, p, p, ball.radius[i]);
    }
    if (inwards)
        turn_inwards(&cloud);
    look(o, s, &cloud);
    points_release(&ball);
    points_release(&cloud);
}

static void inward_open(const struct hard_options *o, struct hard_scene *s)
{
    bowl(o, s, true);
}

static void none(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_ball(o, v3(0, 0, 0), 0);
    cloud.no_normals = true;
    cloud.colored = false;
    look(o, s, &cloud);
    s->truth[1] = 2.05;
    points_release(&cloud);
}

static const struct hard_case cases[] = {
    { "NaN, Inf, zero and unnormalised normals",
      "Lengths do not matter; what is no direction is estimated from its neighbours and counted: "
      "the "
      "sphere's normals to two discs and a half",
      damaged, check_normals, 45, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Inward normals, closed surface", "Turned to the eye: the sphere's normals to a disc",
      inward_closed, check_normals, 45, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "Inward normals, open surface", "Turned to the eye, whichever side it sees", inward_open,
      check_normals, 45, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
    { "No normals", "Estimated and oriented: the sphere's normals to two discs", none,
      check_normals, 45, 0, 0, 0, NULL, HARD_PYRAMID_SURFACE },
};
const struct hard_family hard_normals = { "normals", cases, sizeof cases / sizeof *cases };
