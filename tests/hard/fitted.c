#include "hard.h"

struct stp_fit hard_fit(struct hard_scene *s, const struct hard_points *cloud, double epsilon,
                        double tolerance)
{
    const struct stp_fit_params params = { .tolerance = tolerance };
    struct stp_env env = { .threads = 2 };
    struct stp_fit made;
    s->scene = points_scene(cloud, epsilon, 2);
    assert_int_equal(stp_scene_fit(&env, s->scene, &params, &made), STP_OK);
    assert_true(made.deviation <= tolerance);
    return made;
}

void hard_look_at_fit(const struct hard_options *o, struct hard_scene *s, struct vec3 target,
                      double distance)
{
    s->camera = hard_look(o, target, distance, 30);
    s->params = (struct stp_render_params){ .min_splat = -1 };
}

struct hard_seen hard_see(const struct hard_scene *s, const struct stp_image *image, uint32_t k)
{
    uint32_t px = k % image->width, py = k / image->width;
    struct eye eye;
    eye_init(&eye, &s->camera, (double[3]){ 0, 0, 0 });
    struct ray ray = eye_ray(&eye, px + 0.5, py + 0.5);
    double z = value(image, "Z", px, py);
    struct hard_seen seen = { .start = eye_point_to_world(&eye, ray.start),
                              .along = eye_direction_to_world(&eye, ray.along),
                              .covered = isfinite(z) };
    seen.point = v3_add(seen.start, v3_scale(seen.along, z));
    seen.normal =
        v3(value(image, "N.X", px, py), value(image, "N.Y", px, py), value(image, "N.Z", px, py));
    return seen;
}

double hard_angle(struct vec3 a, struct vec3 b)
{
    return atan2(v3_length(v3_cross(a, b)), v3_dot(a, b));
}
