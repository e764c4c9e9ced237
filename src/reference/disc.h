/* One splat as the camera sees it: exact ray hits, and a bound of the picture that it can touch. */
#ifndef STP_REFERENCE_DISC_H
#define STP_REFERENCE_DISC_H

#include <stipple/plan.h>

#include "reference/eye.h"
#include "scene/scene.h"

/* What a picture is made from; nothing in it changes while it is made. */
struct view {
    const struct stp_scene *scene;
    struct eye eye;
    uint32_t width, height;
    enum stp_kernel kernel;
    enum stp_shade shade;
    bool single_layer; /* --layers single */
    bool cull_back, two_sided, local_viewer;
    bool gaussians;   /* splats are composited one by one (gaussians.c) */
    bool transparent; /* pixels are layers (layers.c) */
    bool deep;        /* which are kept one by one */
    bool leveled;     /* rough light is that of the scene's levels, not summed over the map */
    double min_splat; /* pixels; 0: off */
    double epsilon;   /* 0: each object's own */
    unsigned grid;    /* grid x grid samples a pixel */
};

/* The affine ellipse that stands for a disc below the screen-space floor:
 * rho^2 = a dx^2 + 2 b dx dy + c dy^2 around (px, py), depth z + zx dx + zy dy. */
struct floored {
    double px, py, a, b, c, zx, zy;
    double s[2], t[2]; /* of an ellipse: s = s[0] dx + s[1] dy, t alike */
};

/* BSK Eq. 1 and 2, in the camera frame, as given: nothing is turned. */
struct ellipse {
    struct vec3 normal, u, v;
    double radius[2], field[4];
    double turned; /* -1 where the disc's normal is the other way round */
    unsigned clips;
    bool reflex;
    double clip[2][3];
};

/* Camera frame; the normal is unit, and turned to the eye when the surface is two-sided. */
struct disc {
    struct vec3 centre, normal;
    double radius; /* of an ellipse, the larger */
    bool is_ellipse;
    struct ellipse ellipse;
    bool is_floored;
    struct floored floored;
    double x_min, x_max, y_min, y_max; /* picture positions; no fragment lies outside */
};

struct fragment {
    double depth, rho2; /* eye depth; squared distance from the centre in radii, <= 1 */
    double s, t;        /* of an ellipse: in its own axes */
};

/* False when splat `id` cannot have a fragment in any picture of this view: culled, of opacity 0,
 * wholly nearer than near, or beyond far. */
bool disc_setup(const struct view *view, size_t id, struct disc *disc);

/* The disc's fragment on the ray through (px, py), if it has one. */
bool disc_hit(const struct disc *disc, const struct eye *eye, const struct ray *ray, double px,
              double py, struct fragment *fragment);

/* ellipse.c: splat `id` where it is more than a disc. */
bool ellipse_setup(const struct view *view, size_t id, struct disc *disc);
/* Whether its field may face the eye from anywhere on it. towards: from the centre to the eye. */
bool ellipse_faces(const struct ellipse *ellipse, struct vec3 towards, bool orthographic);
void ellipse_place(const struct ellipse *ellipse, struct vec3 from_centre,
                   struct fragment *fragment);
bool ellipse_keeps(const struct ellipse *ellipse, const struct fragment *fragment);
/* The disc's normal where the fragment is, turned as the disc is. */
struct vec3 fragment_normal(const struct disc *disc, const struct fragment *fragment);

/* floor.c: whether the disc's projection is thinner than `least` pixels, and what is drawn then. */
bool floor_ellipse(const struct eye *eye, const struct disc *disc, double least,
                   struct floored *floored, double *reach);

#endif
