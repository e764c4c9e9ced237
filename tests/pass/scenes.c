#include "device.h"

#include "base/memory.h"
#include "scene/phong.h"

static void *must(void *pointer)
{
    assert_non_null(pointer);
    return pointer;
}

struct stp_scene *scene_make(size_t capacity, unsigned objects, double epsilon)
{
    struct stp_scene *scene = NULL;
    assert_int_equal(stp_scene_create(NULL, &scene), STP_OK);
    scene->objects = must(mem_zalloc(objects, sizeof *scene->objects));
    scene->object_count = objects;
    for (unsigned i = 0; i < objects; i++)
        scene->objects[i] = (struct scene_object){ .material = SCENE_DEFAULT_MATERIAL,
                                                   .epsilon = epsilon,
                                                   .opacity = 1 };
    struct splats *s = &scene->splats;
    s->position = must(mem_zalloc(capacity, sizeof *s->position));
    s->normal = must(mem_zalloc(capacity, sizeof *s->normal));
    s->radius = must(mem_zalloc(capacity, sizeof *s->radius));
    s->input = must(mem_zalloc(capacity, sizeof *s->input));
    s->color = must(mem_zalloc(capacity, sizeof *s->color));
    s->object = must(mem_zalloc(capacity, sizeof *s->object));
    s->opacity = must(mem_zalloc(capacity, sizeof *s->opacity));
    s->phong = must(mem_zalloc(capacity, sizeof *s->phong));
    for (size_t i = 0; i < capacity; i++)
        s->opacity[i] = 1;
    return scene;
}

size_t scene_add(struct stp_scene *scene, struct vec3 p, struct vec3 n, double radius)
{
    struct splats *s = &scene->splats;
    size_t i = s->count++;
    n = v3_unit(n);
    memcpy(s->position[i], (double[3]){ p.x, p.y, p.z }, sizeof s->position[i]);
    memcpy(s->normal[i], (float[3]){ (float)n.x, (float)n.y, (float)n.z }, sizeof s->normal[i]);
    s->radius[i] = (float)radius;
    s->input[i] = (uint32_t)(1000 + i);
    return i;
}

void scene_paint(struct stp_scene *scene, size_t i, float r, float g, float b)
{
    scene->facts.has_color = true;
    memcpy(scene->splats.color[i], (float[3]){ r, g, b }, sizeof scene->splats.color[i]);
}

void scene_fade(struct stp_scene *scene, size_t i, float opacity)
{
    scene->splats.opacity[i] = opacity;
    scene->facts.transparent |= opacity < 1;
}

void scene_bend(struct stp_scene *scene, size_t i, const struct stp_phong_splat *phong)
{
    scene->splats.phong[i] = *phong;
    scene->splats.radius[i] = fmaxf(phong->radius[0], phong->radius[1]);
    scene->facts.phong++;
    scene->facts.clip_lines += phong->clips > 0;
}

void scene_assign(struct stp_scene *scene, size_t i, unsigned object)
{
    scene->splats.object[i] = (uint16_t)object;
}

static void grow(struct stp_facts *f, const struct splats *s, size_t i)
{
    for (int k = 0; k < 3; k++) {
        f->bounds[k] = fmin(f->bounds[k], s->position[i][k]);
        f->bounds[3 + k] = fmax(f->bounds[3 + k], s->position[i][k]);
        f->color_min = f->has_color ? fminf(f->color_min, s->color[i][k]) : 0;
        f->color_max = f->has_color ? fmaxf(f->color_max, s->color[i][k]) : 0;
    }
    f->radius_min = fminf(f->radius_min, s->radius[i]);
    f->radius_max = fmaxf(f->radius_max, s->radius[i]);
    f->no_normal += s->normal[i][0] == 0 && s->normal[i][1] == 0 && s->normal[i][2] == 0;
}

static void find_opacities(struct stp_facts *f, const struct splats *s)
{
    f->opacity_min = 1;
    f->uniform_opacity = true;
    for (size_t i = 0; f->transparent && i < s->count; i++) {
        f->opacity_min = fminf(f->opacity_min, s->opacity[i]);
        f->uniform_opacity &= s->opacity[i] == s->opacity[0];
        f->mixed |= s->opacity[i] == 1;
    }
}

/* What a scene lacks is absent, as stp_scene_prepare leaves it. */
static void drop_unused(struct stp_scene *scene)
{
    if (!scene->facts.has_color) {
        mem_free(scene->splats.color);
        scene->splats.color = NULL;
    }
    if (!scene->facts.transparent) {
        mem_free(scene->splats.opacity);
        scene->splats.opacity = NULL;
    }
    if (!scene->facts.phong) {
        mem_free(scene->splats.phong);
        scene->splats.phong = NULL;
    }
    if (scene->object_count == 1) {
        mem_free(scene->splats.object);
        scene->splats.object = NULL;
    }
}

void scene_finish(struct stp_scene *scene)
{
    struct stp_facts *f = &scene->facts;
    struct splats *s = &scene->splats;
    drop_unused(scene);
    for (size_t i = 0; s->phong && i < s->count; i++)
        if (phong_is_disc(&s->phong[i]))
            s->phong[i] = phong_of_disc(s->normal[i], s->radius[i]);
    f->points = f->splats = s->count;
    f->radius_min = INFINITY;
    f->radius_max = 0;
    for (int k = 0; k < 3; k++) {
        f->bounds[k] = INFINITY;
        f->bounds[3 + k] = -INFINITY;
    }
    for (size_t i = 0; i < s->count; i++)
        grow(f, s, i);
    f->radius_median = s->radius[s->count / 2];
    find_opacities(f, s);
    for (int k = 0; k < 3; k++)
        s->origin[k] = f->origin[k] = 0.5 * (f->bounds[k] + f->bounds[3 + k]);
    /* Positions are what float32 holds relative to the origin: the rest is no renderer's error. */
    for (size_t i = 0; i < s->count; i++)
        for (int k = 0; k < 3; k++)
            s->position[i][k] = s->origin[k] + (float)(s->position[i][k] - s->origin[k]);
    f->objects = scene->object_count;
    f->lights = scene->light_count;
    scene->prepared = true;
}

void scene_own_groups(struct stp_scene *scene)
{
    struct splats *s = &scene->splats;
    assert_true(s->count <= STP_MAX_GROUPS);
    s->group = must(mem_zalloc(s->count, 1));
    for (size_t i = 0; i < s->count; i++)
        s->group[i] = (uint8_t)i;
    scene->facts.grouping = (struct stp_grouping){ .groups = (unsigned)s->count, .overlap = 1 };
}

struct stp_scene *scene_random(uint32_t seed, size_t count, double epsilon)
{
    struct fixture *f = fixture_create(epsilon);
    struct stp_scene *scene = scene_make(count, 1, epsilon);
    fill_randomly(f, seed, count);
    for (size_t i = 0; i < count; i++) {
        const float *n = f->normal[i], *c = f->color[i];
        size_t at = scene_add(scene, v3_load(f->position[i]), v3(n[0], n[1], n[2]), f->radius[i]);
        scene_paint(scene, at, c[0], c[1], c[2]);
    }
    free(f);
    scene_finish(scene);
    return scene;
}

struct stp_scene *scene_sheet(unsigned objects, uint32_t seed)
{
    struct stp_scene *scene = scene_make(SCENE_SHEET_SPLATS, objects, 0.1);
    for (unsigned i = 0; i < SCENE_SHEET_SPLATS; i++) {
        double x = i % 3 * 0.5 - 0.5, y = i / 3 * 0.5 - 0.5;
        struct vec3 p = v3(x, y, -2 + 0.1 * uniform(&seed));
        size_t at = scene_add(scene, p, v3_add(v3(0, 0, 1), random_point(&seed, 0.6)), 0.45);
        if (objects > 1)
            scene_assign(scene, at, i % objects);
    }
    return scene;
}
