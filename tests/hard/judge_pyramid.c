#include "hard.h"

/* How the pyramid's picture compares with the reference's. */
struct found {
    size_t covered; /* by the reference */
    size_t lost;    /* pixels that hold a point's centre and are empty */
    size_t empty;   /* covered by the reference, not by the pyramid */
    size_t wider;   /* covered by the pyramid alone, not beside what the reference covers */
    size_t behind;  /* farther than epsilon from where one surface faces the eye */
    double db;      /* of colours, where both cover */
    double twin;    /* dB; INFINITY: the same bits */
};

struct pyramid_judging {
    const struct hard_options *o;
    struct device *device;
    const struct hard_case *c;
    char slug[HARD_SLUG];
    struct hard_scene s;
    struct stp_image *image, *truth;
    double epsilon;
};

static struct stp_render_params pyramid_params(const struct hard_scene *s)
{
    struct stp_render_params p = s->params;
    p.method = STP_METHOD_PYRAMID;
    return p;
}

static bool covers(const struct stp_image *image, int64_t x, int64_t y)
{
    return x >= 0 && y >= 0 && x < image->width && y < image->height &&
           isfinite(value(image, "Z", (uint32_t)x, (uint32_t)y));
}

/* A point whose centre is surely in view, surely in one pixel, and does not turn its edge. */
static bool in_view(const struct stp_camera *camera, const struct eye *eye, struct vec3 p,
                    struct vec3 n, bool culled, uint32_t pixel[2])
{
    double over = eye->orthographic ? 1 : -p.z;
    double x = camera->cx + camera->fx * p.x / over, y = camera->cy - camera->fy * p.y / over;
    double facing = -v3_dot(n, v3_unit(eye_view(eye, p)));
    if (!(-p.z > camera->near_depth * (1 + 1e-6) && -p.z < camera->far_depth * (1 - 1e-6)) ||
        fabs(x - round(x)) < 1e-3 || fabs(y - round(y)) < 1e-3 || !(x > 0 && x < camera->width) ||
        !(y > 0 && y < camera->height) || (culled ? facing : fabs(facing)) < 1e-3)
        return false;
    pixel[0] = (uint32_t)x;
    pixel[1] = (uint32_t)y;
    return true;
}

static size_t count_lost(const struct pyramid_judging *j)
{
    const struct splats *splats = &j->s.scene->splats;
    struct eye eye;
    size_t lost = 0;
    eye_init(&eye, &j->s.camera, splats->origin);
    for (size_t i = 0; i < splats->count; i++) {
        struct vec3 n = eye_direction(&eye, v3_loadf(splats->normal[i]));
        struct vec3 p = eye_point(&eye, splats->position[i]);
        uint32_t pixel[2];
        if (v3_length(n) < 0.5) /* unknown: faces the eye */
            n = v3_scale(v3_unit(eye_view(&eye, p)), -1);
        if (in_view(&j->s.camera, &eye, p, n, j->s.params.cull == STP_CULL_BACK, pixel))
            lost += !covers(j->image, pixel[0], pixel[1]);
    }
    return lost;
}

static bool beside(const struct pyramid_judging *j, int64_t px, int64_t py)
{
    for (int64_t y = py - 1; y <= py + 1; y++)
        for (int64_t x = px - 1; x <= px + 1; x++)
            if (covers(j->truth, x, y))
                return true;
    return false;
}

/* The reference's surface goes on without a step around the pixel, and is not seen at a slant. */
static bool smooth(const struct pyramid_judging *j, uint32_t x, uint32_t y)
{
    const struct stp_image *t = j->truth;
    struct eye eye;
    eye_init(&eye, &j->s.camera, j->s.scene->splats.origin);
    struct ray ray = eye_ray(&eye, x + 0.5, y + 0.5);
    struct vec3 n = v3(value(t, "N.X", x, y), value(t, "N.Y", x, y), value(t, "N.Z", x, y));
    double z = value(t, "Z", x, y);
    for (int k = 0; k < 9; k++) {
        int64_t sx = (int64_t)x + k % 3 - 1, sy = (int64_t)y + k / 3 - 1;
        if (sx < 0 || sy < 0 || sx >= t->width || sy >= t->height)
            continue;
        if (!(fabs(value(t, "Z", (uint32_t)sx, (uint32_t)sy) - z) <= 2 * j->epsilon))
            return false;
    }
    return fabs(v3_dot(n, v3_unit(eye_direction_to_world(&eye, ray.along)))) > 0.35;
}

static struct found compare(const struct pyramid_judging *j)
{
    struct found f = { .lost = count_lost(j), .twin = INFINITY };
    double squares = 0;
    size_t both = 0;
    for (uint32_t y = 0; y < j->image->height; y++)
        for (uint32_t x = 0; x < j->image->width; x++) {
            bool there = covers(j->image, x, y), right = covers(j->truth, x, y);
            f.covered += right;
            f.empty += right && !there;
            f.wider += there && !right && !beside(j, x, y);
            if (!there || !right)
                continue;
            double behind = fabs((double)value(j->image, "Z", x, y) - value(j->truth, "Z", x, y));
            f.behind += behind > j->epsilon && smooth(j, x, y);
            for (int k = 0; k < 3; k++) {
                const char *const name = (const char *[]){ "R", "G", "B" }[k];
                double right_value = value(j->truth, name, x, y);
                double d = value(j->image, name, x, y) - right_value;
                squares += d * d / pow(fmax(1, right_value), 2) / 3;
            }
            both++;
        }
    f.db = squares > 0 ? -10 * log10(squares / (double)both) : INFINITY;
    return f;
}

/* Of unit normals where something is, nothing nearer than the near plane. */
static bool sound(const struct pyramid_judging *j)
{
    const struct stp_image *image = j->image;
    bool right = hard_sound(image);
    for (uint32_t i = 0; i < image->width * image->height; i++) {
        uint32_t x = i % image->width, y = i / image->width;
        struct vec3 n =
            v3(value(image, "N.X", x, y), value(image, "N.Y", x, y), value(image, "N.Z", x, y));
        if (covers(image, x, y))
            right = right && fabs(v3_length(n) - 1) < 1e-3 &&
                    value(image, "Z", x, y) >= j->s.camera.near_depth * (1 - 1e-6);
    }
    return right;
}

static double compare_twin(struct pyramid_judging *j)
{
    struct stp_render_params p = pyramid_params(&j->s);
    struct stp_image *twin = device_render(j->device, j->s.twin, &j->s.twin_camera, &p);
    double db = INFINITY;
    if (j->c->twin == INFINITY)
        expect_same_bits(j->image, twin, j->c->name);
    else
        db = hard_psnr(j->image, twin);
    stp_image_destroy(&twin);
    return db;
}

static void print_row(const struct pyramid_judging *j, const char *family, const struct found *f)
{
    FILE *file = j->o->table ? fopen(j->o->table, "a") : NULL;
    bool surface = j->c->pyramid == HARD_PYRAMID_SURFACE;
    if (!file)
        return;
    fprintf(file, "| %s: %s | %s | ![](images/hard/%s.png) | %zu | %zu | %zu | %zu |", family,
            j->c->name, surface ? "surface" : "points", j->slug, f->covered, f->lost, f->empty,
            f->wider);
    fprintf(file, " %zu |", f->behind);
    fprintf(file, f->db > 200 ? " same |" : " %.0f |", f->db);
    if (j->s.twin && isinf(f->twin))
        fprintf(file, " the same bits |\n");
    else
        fprintf(file, j->s.twin ? " %.0f dB |\n" : " |\n", f->twin);
    fclose(file);
}

static void expect_refused(struct pyramid_judging *j)
{
    struct stp_render_params p = pyramid_params(&j->s);
    struct stp_plan *plan = NULL;
    unsigned lines = j->device->lines;
    assert_int_not_equal(device_plan(j->device, j->s.scene, &j->s.camera, &p, &plan), STP_OK);
    assert_null(plan);
    assert_int_equal(j->device->lines, lines + 1);
    assert_non_null(strstr(j->device->last, "pyramid"));
}

static void render_and_judge(struct pyramid_judging *j, const char *family)
{
    struct stp_render_params p = pyramid_params(&j->s);
    bool surface = j->c->pyramid == HARD_PYRAMID_SURFACE;
    j->epsilon = j->s.scene->objects[0].epsilon;
    j->image = device_render(j->device, j->s.scene, &j->s.camera, &p);
    j->truth = hard_reference(j->s.scene, &j->s.camera, &p);
    struct found f = compare(j);
    size_t few = 1 + f.covered / 2000; /* 1.5 pixels of rounding of an outline decide those */
    bool right = sound(j) && f.lost == 0;
    if (surface)
        right = right && f.empty <= few && f.wider == 0 && f.behind <= few;
    if (j->s.twin)
        f.twin = compare_twin(j);
    if (f.twin < j->c->twin)
        right = false;
    if (!right || getenv("STP_TEST_VERDICTS"))
        print_message(
            "%s, %s by pyramid: %s: %zu covered, %zu lost, %zu empty, %zu wider, %zu behind"
            ", %.1f dB; twin %.1f dB\n",
            family, j->c->name, right ? "right" : "WRONG", f.covered, f.lost, f.empty, f.wider,
            f.behind, f.db, f.twin);
    print_row(j, family, &f);
    hard_keep(j->o, &j->s, j->slug, j->image, 0);
    stp_image_destroy(&j->image);
    stp_image_destroy(&j->truth);
    assert_true(right);
}

void hard_judge_pyramid(const struct hard_options *o, struct device *device, const char *family,
                        const struct hard_case *c)
{
    struct pyramid_judging j = { .o = o, .device = device, .c = c };
    char pyramid[32];
    snprintf(pyramid, sizeof pyramid, "pyramid_%s", family);
    hard_slug(pyramid, c, j.slug);
    c->make(o, &j.s);
    if (j.s.scene->facts.transparent)
        expect_refused(&j);
    else
        render_and_judge(&j, family);
    stp_scene_destroy(&j.s.scene);
    stp_scene_destroy(&j.s.twin);
}
