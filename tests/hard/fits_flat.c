/* Fits of what is flat: thin sheets, open borders, steep normals, corners of three planes. */
#include "hard.h"

/* A frame of flat scenes: w is 31 degrees off the eye's direction, so that none is edge-on. */
struct tilted_frame {
    struct vec3 u, v, w;
};

static struct tilted_frame tilted(const struct hard_options *o)
{
    struct vec3 eye = hard_towards_eye(o), across = v3_unit(v3_cross(v3(0.1, 1, 0.05), eye));
    struct vec3 w = v3_unit(v3_add(eye, v3_scale(across, 0.6)));
    struct vec3 u = v3_unit(v3_cross(w, v3_cross(eye, across)));
    return (struct tilted_frame){ u, v3_cross(w, u), w };
}

static struct vec3 place(const struct tilted_frame *f, double x, double y, double z)
{
    return v3_add(v3_scale(f->u, x), v3_add(v3_scale(f->v, y), v3_scale(f->w, z)));
}

/* Samples of a unit square about 0, at a height. */
static void add_square(struct hard_points *cloud, const struct tilted_frame *f, size_t count,
                       double z, double side, uint32_t *seed)
{
    for (size_t i = 0; i < count; i++) {
        double x = hard_random(seed) - 0.5, y = hard_random(seed) - 0.5;
        struct vec3 p = place(f, x, y, z);
        points_add(cloud, p, v3_scale(f->w, side), 1.5 / sqrt((double)count));
    }
}

static void remember_frame(struct hard_scene *s, const struct tilted_frame *f)
{
    const double w[6] = { f->w.x, f->w.y, f->w.z, f->u.x, f->u.y, f->u.z };
    memcpy(s->truth, w, sizeof w);
}

/* Where a ray meets the square's plane, in its frame. */
static struct vec3 in_square(const struct hard_scene *s, const struct hard_seen *seen)
{
    struct vec3 w = v3_load(s->truth), u = v3_load(s->truth + 3), v = v3_cross(w, u);
    double depth = -v3_dot(seen->start, w) / v3_dot(seen->along, w);
    struct vec3 p = v3_add(seen->start, v3_scale(seen->along, depth));
    return v3(v3_dot(p, u), v3_dot(p, v), depth);
}

/* What a pixel shows, and where its ray meets the square; false: beside it, or by its border. */
static bool see_square(const struct hard_scene *s, const struct stp_image *image, uint32_t pixel,
                       struct hard_seen *seen, struct vec3 *place)
{
    *seen = hard_see(s, image, pixel);
    *place = in_square(s, seen);
    return fmax(fabs(place->x), fabs(place->y)) <= 0.45;
}

/* A fiftieth apart, a tenth of the tolerance; backs culled. */
static void thin(const struct hard_options *o, struct hard_scene *s)
{
    const size_t count = 1000;
    struct hard_points cloud = points_make(2 * count);
    struct tilted_frame f = tilted(o);
    uint32_t seed = o->seed;
    add_square(&cloud, &f, count, 0, 1, &seed);
    add_square(&cloud, &f, count, -0.02, -1, &seed);
    assert_true(hard_fit(s, &cloud, 0, 0.2).signs);
    hard_look_at_fit(o, s, v3(0, 0, 0), 2.6);
    s->params.cull = STP_CULL_BACK;
    remember_frame(s, &f);
    points_release(&cloud);
}

/* The square is covered, and what is seen of it within `off` of its plane and `turned` of its
 * normal. */
static double check_square(const struct hard_scene *s, const struct stp_image *image, double off,
                           double turned)
{
    struct vec3 w = v3_load(s->truth);
    double worst = 0;
    for (uint32_t k = 0; k < image->width * image->height; k++) {
        struct hard_seen seen;
        struct vec3 p;
        if (!see_square(s, image, k, &seen, &p))
            continue;
        worst = fmax(worst, seen.covered ? hard_angle(seen.normal, w) / turned : INFINITY);
        worst = fmax(worst, fabs(v3_dot(seen.point, w)) / off);
    }
    return worst;
}

/* The front alone, to rounding. */
static double check_thin(const struct hard_scene *s, const struct stp_image *image)
{
    return check_square(s, image, 1e-3, 1e-3);
}

static void open_border(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(o->points);
    struct tilted_frame f = tilted(o);
    uint32_t seed = o->seed;
    add_square(&cloud, &f, o->points, 0, 1, &seed);
    hard_fit(s, &cloud, 0, 0.01);
    hard_look_at_fit(o, s, v3(0, 0, 0), 3.4);
    remember_frame(s, &f);
    s->truth[6] = 1 / sqrt((double)o->points);
    points_release(&cloud);
}

/* How far a least ellipse of given axes may reach past the side of a unit square that holds its
 * points. Where it is least, contacts p with weights of sum 1 exist whose mean is its centre and
 * whose second moments along the axes are a^2 / 2 and b^2 / 2 (Kuhn-Tucker; least in 1/a, 1/b and
 * the centre over them, which is convex). Let t be a contact's way from the centre towards the
 * side, e the way along it, T and E their second moments: turning the axes, the ellipse reaches R
 * past its centre with R^2 <= T + (C sqrt T + S sqrt E)^2, C^2 + S^2 = 1, so R^2 <= 2 T + E. The
 * side is at h
 * >= 0 from the centre and t in [h - 1, h], so T <= h (1 - h); E <= 1/4. R - h is then at most (3
 * sqrt 2 - 2) / 4, for h = (2 - sqrt 2) / 4. */
#define PAST_SIDE ((3 * M_SQRT2 - 2) / 4)

/* The ellipse is made larger by half a distance to the 6th neighbour and a little, that is a
 * spacing; as much again for samples at random. The square itself is covered, at its own depth. */
static double check_border(const struct hard_scene *s, const struct stp_image *image)
{
    double most = 0.5 + PAST_SIDE + 2 * s->truth[6], worst = 0;
    for (uint32_t k = 0; k < image->width * image->height; k++) {
        struct hard_seen seen = hard_see(s, image, k);
        struct vec3 p = in_square(s, &seen);
        double out = fmax(fabs(p.x), fabs(p.y));
        if (out < 0.5 - 3 * s->truth[6])
            worst = fmax(worst, seen.covered ? fabs(v3_dot(seen.point, v3_load(s->truth))) / 1e-3
                                             : INFINITY);
        if (seen.covered)
            worst = fmax(worst, (out - 0.5) / (most - 0.5));
    }
    return worst;
}

#define STEEP_RADIUS    0.03
#define STEEP_TOLERANCE 0.01
#define STEEP_BUMPS     0.001

/* x, y: from the square's corner. */
static double steep_tilt(double x, double y, double seed)
{
    return 85 * M_PI / 180 * sin(4 * x + seed) * cos(3 * y);
}

/* Bumps within the tolerance, whose sides stand at 85 degrees. */
static void steep(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(2500);
    struct tilted_frame f = tilted(o);
    for (int i = 0; i < 2500; i++) {
        double x = i % 50 / 50.0, y = i / 50 / 50.0, tilt = steep_tilt(x, y, o->seed);
        struct vec3 p = place(&f, x - 0.5, y - 0.5, STEEP_BUMPS * sin(90 * x * y));
        points_add(&cloud, p, place(&f, sin(tilt), 0, cos(tilt)), STEEP_RADIUS);
    }
    hard_fit(s, &cloud, 0, STEEP_TOLERANCE);
    hard_look_at_fit(o, s, v3(0, 0, 0), 2.6);
    remember_frame(s, &f);
    s->truth[6] = o->seed;
    points_release(&cloud);
}

/* No sample is tilted past 60 degrees from which a splat could be seen at this place: a splat that
 * stands up reaches two radii, and is seen 31 degrees aslant. */
static bool is_flat(const struct hard_scene *s, struct vec3 p)
{
    double reach = 2 * STEEP_RADIUS * (1 + tan(31 * M_PI / 180)), most = 0;
    for (int k = 0; k < 441; k++) {
        double x = p.x + 0.5 + reach * (k % 21 / 10.0 - 1),
               y = p.y + 0.5 + reach * (k / 21 / 10.0 - 1);
        most = fmax(most, fabs(steep_tilt(x, y, s->truth[6])));
    }
    return most <= M_PI / 3;
}

/* Where the normals are within 60 degrees of the plane that the samples lie in, that plane is
 * theirs (patch_plane): it is seen, to the tolerance and the bumps, and no normal is past the right
 * angle, which no linear field reaches. Where they are not, the samples contradict their
 * neighbours' plane, and are taken by their word, as unfitted ones are: splats stand up, by their
 * radius and at most as much again, and may be seen edge-on or from behind. */
static double check_steep(const struct hard_scene *s, const struct stp_image *image)
{
    double off = STEEP_TOLERANCE + 2 * STEEP_BUMPS, worst = 0;
    struct vec3 w = v3_load(s->truth);
    unsigned flat = 0;
    for (uint32_t k = 0; k < image->width * image->height; k++) {
        struct hard_seen seen;
        struct vec3 p;
        if (!see_square(s, image, k, &seen, &p))
            continue;
        bool plain = is_flat(s, p);
        flat += plain;
        if (!seen.covered && plain)
            return INFINITY;
        if (!seen.covered)
            continue;
        worst = fmax(worst, fabs(v3_dot(seen.point, w)) / (off + (plain ? 0 : 2 * STEEP_RADIUS)));
        worst = fmax(worst, plain ? hard_angle(seen.normal, w) / (M_PI / 2) : 0);
    }
    return flat ? worst : INFINITY;
}

#define SIDE 24 /* samples along an edge of the cube */

static void corners(const struct hard_options *o, struct hard_scene *s)
{
    struct hard_points cloud = points_make(6 * SIDE * SIDE);
    for (int i = 0; i < 6 * SIDE * SIDE; i++) {
        int face = i / (SIDE * SIDE), at = i % (SIDE * SIDE), axis = face / 2;
        double side = face % 2 ? 1 : -1, p[3], n[3] = { 0 };
        p[axis] = 0.5 * side;
        p[(axis + 1) % 3] = (at % SIDE + 0.5) / SIDE - 0.5;
        p[(axis + 2) % 3] = (at / SIDE + 0.5) / SIDE - 0.5;
        n[axis] = side;
        points_add(&cloud, v3_load(p), v3_load(n), 1.2 / SIDE);
    }
    assert_true(hard_fit(s, &cloud, 0, 0.005).clipped > 6);
    hard_look_at_fit(o, s, v3(0, 0, 0), 3.4);
    points_release(&cloud);
}

/* The nearest that a ray comes to an edge of the cube. */
static double from_edges(const struct hard_seen *seen)
{
    double least = INFINITY, along[3] = { seen->along.x, seen->along.y, seen->along.z };
    double start[3] = { seen->start.x, seen->start.y, seen->start.z };
    for (int edge = 0; edge < 12; edge++) {
        int axis = edge / 4, a = (axis + 1) % 3, b = (axis + 2) % 3;
        double p = edge & 1 ? 0.5 : -0.5, q = edge & 2 ? 0.5 : -0.5;
        /* The foot on the edge's line, held to the edge; then the ray's foot from there. */
        double da = along[a], db = along[b], ea = p - start[a], eb = q - start[b];
        double t = (ea * da + eb * db) / (da * da + db * db);
        double foot[3] = { 0 }, d[3], dot = 0, square = 0, dd = 0;
        foot[a] = p;
        foot[b] = q;
        foot[axis] = fmin(fmax(start[axis] + t * along[axis], -0.5), 0.5);
        for (int k = 0; k < 3; k++) {
            d[k] = foot[k] - start[k];
            dot += d[k] * along[k];
            square += along[k] * along[k];
            dd += d[k] * d[k];
        }
        least = fmin(least, sqrt(fmax(0, dd - dot * dot / square)));
    }
    return least;
}

/* Where the ray enters the cube: depth along it, and the face's normal; false: it does not. */
static bool enters(const struct hard_seen *seen, double *depth, struct vec3 *normal)
{
    const double start[3] = { seen->start.x, seen->start.y, seen->start.z };
    const double along[3] = { seen->along.x, seen->along.y, seen->along.z };
    double in = -INFINITY, out = INFINITY;
    for (int k = 0; k < 3; k++) {
        double side = along[k] > 0 ? -1 : 1, t = (0.5 * side - start[k]) / along[k];
        if (t > in) {
            in = t;
            *normal = v3(k == 0 ? side : 0, k == 1 ? side : 0, k == 2 ? side : 0);
        }
        out = fmin(out, (-0.5 * side - start[k]) / along[k]);
    }
    *depth = in;
    return in < out;
}

/* Two spacings and a half from the edges (a splat has two lines, and may reach over a third edge by
 * two): each face's own plane and normal, to rounding, and nothing beyond the cube. */
static double check_corners(const struct hard_scene *s, const struct stp_image *image)
{
    double worst = 0;
    for (uint32_t k = 0; k < image->width * image->height; k++) {
        struct hard_seen seen = hard_see(s, image, k);
        struct vec3 normal;
        double depth;
        if (from_edges(&seen) < 2.5 / SIDE)
            continue;
        bool inside = enters(&seen, &depth, &normal);
        if (inside != seen.covered)
            return INFINITY;
        struct vec3 off = v3_sub(seen.point, v3_add(seen.start, v3_scale(seen.along, depth)));
        if (inside)
            worst = fmax(worst, fmax(hard_angle(seen.normal, normal), v3_length(off)) / 1e-3);
    }
    return worst;
}

static const struct hard_case cases[] = {
    { "Thin sheets, a tenth of the tolerance apart",
      "The front's own plane and normal, to rounding: no splat holds samples of both sides", thin,
      check_thin, HARD_FIT_GROUPED, 0, 0, 0, NULL, 0 },
    { "An open border",
      "The square is covered, in its plane; nothing is drawn farther off than a least ellipse of "
      "any "
      "axes may reach past a side (0.561 of it), and two spacings",
      open_border, check_border, HARD_FIT_GROUPED, 0, 0, 0, NULL, 0 },
    { "Normals of 85 degrees in a flat fit",
      "Where normals stay within 60 degrees of the plane: the plane to the tolerance, and no "
      "normal "
      "past a right angle from it. Elsewhere samples contradict it and stand up: within two radii",
      steep, check_steep, HARD_FIT_GROUPED, 0, HARD_FIT_PACKED, 0, NULL, 0 },
    { "Corners of three planes",
      "Each face's plane and normal, to rounding, from 2.5 samples off its edges; nothing sticks "
      "out "
      "farther",
      corners, check_corners, HARD_FIT_GROUPED, 0, 0, 0, NULL, 0 },
};
const struct hard_family hard_fits_flat = { "fits_flat", cases, sizeof cases / sizeof *cases };
