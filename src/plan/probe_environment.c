/* Rough light of the environment: the probe, as the device, looks it up in levels. */
#include "base/thread.h"
#include "plan/probe.h"
#include "reference/environment.h"
#include "scene/optics.h"

#define DIRECTIONS 48
#define CONFIDENCE 3

struct directions {
    struct view summed, leveled;
    double roughness;
    double off[DIRECTIONS];
};

/* Evenly over the sphere, along a spiral. */
static struct vec3 direction(size_t i)
{
    double z = 1 - (2 * (double)i + 1) / DIRECTIONS, across = sqrt(1 - z * z);
    double turn = M_PI * (3 - sqrt(5)) * (double)i;
    return v3(across * cos(turn), across * sin(turn), z);
}

static void compare(void *context, size_t begin, size_t end, unsigned)
{
    struct directions *d = context;
    for (size_t i = begin; i < end; i++) {
        struct vec3 a = environment_light(&d->summed, direction(i), d->roughness);
        struct vec3 b = environment_light(&d->leveled, direction(i), d->roughness);
        d->off[i] = (fabs(a.x - b.x) + fabs(a.y - b.y) + fabs(a.z - b.z)) / 3;
    }
}

/* The mean, and as many standard errors as an estimate of it may be off. */
static double mean_of(const double off[DIRECTIONS])
{
    double sum = 0, squares = 0;
    for (int i = 0; i < DIRECTIONS; i++) {
        sum += off[i];
        squares += off[i] * off[i];
    }
    double mean = sum / DIRECTIONS, variance = fmax(squares / DIRECTIONS - mean * mean, 0);
    return mean + CONFIDENCE * sqrt(variance / DIRECTIONS);
}

double probe_levels_error(const struct stp_env *env, const struct view *view)
{
    const struct stp_scene *scene = view->scene;
    struct directions d = { .summed = *view, .leveled = *view };
    double most = 0;
    d.summed.leveled = false;
    d.leveled.leveled = true;
    for (unsigned i = 0; i < scene->object_count && scene->environment.map.width; i++) {
        const struct stp_optics *o = &scene->objects[i].optics;
        bool again = d.roughness == (double)o->roughness;
        if (!optics_matter(o) || again || !(o->roughness > 0))
            continue;
        d.roughness = (double)o->roughness;
        parallel_for(env, DIRECTIONS, 1, compare, &d);
        most = fmax(most, mean_of(d.off));
    }
    return most;
}
