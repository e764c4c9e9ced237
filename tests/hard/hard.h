/* The hard cases: scenes that break renderers, generated from a seed, each with a stated outcome
 * that every method and path has to give, the reference included (docs/hard-cases.md). */
#ifndef TEST_HARD_HARD_H
#define TEST_HARD_HARD_H

#include "device.h"
#include <stipple/fit.h>

/* What the scenes are made from. Every case holds for every choice. */
struct hard_options {
    uint32_t seed;          /* not 0 */
    uint32_t width, height; /* of pictures whose size is not the case */
    double turn, rise;      /* radians: from where scenes are looked at, where that is free */
    size_t points;          /* of surfaces */
    bool varied;            /* any of these */
    const char *family;     /* NULL: all */
    const char *only;       /* part of a case's name; NULL: all */
    const char *table;      /* file: Markdown rows are appended; NULL: none */
    const char *pictures;   /* folder: a PNG a case; NULL: none */
    const char *write;      /* folder: a PLY, a camera and EXRs a case; NULL: none */
};

/* What the pyramid, an approximation, makes of a case of points: docs/hard-cases.md argues it. */
enum hard_pyramid {
    HARD_PYRAMID_POINTS = 0, /* no point in view is lost */
    HARD_PYRAMID_SURFACE,    /* and discs join to a surface: no holes, its depth within epsilon */
};

/* What is rendered. The case owns it until hard_scene_release. */
struct hard_scene {
    struct stp_scene *scene;
    struct stp_camera camera;
    struct stp_render_params params; /* method, path and payload are the ways' */
    /* Where the outcome is "the same picture as": NULL, or the other scene. */
    struct stp_scene *twin;
    struct stp_camera twin_camera;
    double truth[8]; /* what the case's check wants to remember */
};

struct hard_case {
    const char *name;
    const char *outcome; /* and why a right renderer gives it: one line of the table */
    void (*make)(const struct hard_options *o, struct hard_scene *s);
    /* A truth that no renderer shares: the error over its own bound, right when at most 1. */
    double (*check)(const struct hard_scene *s, const struct stp_image *image);
    double grouped; /* dB: least PSNR of `deferred` where its groups are of many, c = 1; of scenes
                       that are varied HARD_GROUPED, or none where this is less */
    double twin;   /* dB: least PSNR of N and of relative Z against the twin; INFINITY: same bits */
    double packed; /* dB: least PSNR by packed keys, where the case strains their 12-bit weights; 0:
                      bounded pixel by pixel as all else */
    double fragile; /* most share of covered pixels on the edge of rounding; 0: 0.03 */
    /* Or all by itself: fails through cmocka. */
    void (*run)(const struct hard_options *o, struct device *device);
    enum hard_pyramid pyramid;
};

struct hard_family {
    const char *name;
    const struct hard_case *cases;
    unsigned count;
};
extern const struct hard_family hard_samples, hard_breaks, hard_coordinates, hard_views,
    hard_splats, hard_normals, hard_crowds, hard_sheets, hard_colors, hard_pictures, hard_bits,
    hard_devices, hard_layers, hard_axis, hard_axis_surface, hard_ellipses, hard_phong, hard_fits,
    hard_fits_flat;

/* points.c: points before they are prepared. */
struct hard_points {
    size_t count, capacity;
    double (*position)[3];
    float (*normal)[3], *radius, (*color)[3], *opacity;
    struct stp_phong_splat *phong;
    bool no_normals, no_radii, colored, faded, bent;
};
struct hard_points points_make(size_t capacity);
void points_release(struct hard_points *cloud);
/* Of no colour: grey. Returns the point's index. */
size_t points_add(struct hard_points *cloud, struct vec3 p, struct vec3 n, double radius);
void points_paint(struct hard_points *cloud, size_t i, struct vec3 color);
void points_fade(struct hard_points *cloud, size_t i, double opacity); /* others are opaque */
/* To an ellipse whose u is at `angle`; for the caller to add a field and lines. Others are discs.
 */
struct stp_phong_splat *points_bend(struct hard_points *cloud, size_t i, double angle,
                                    double radius_u, double radius_v);
void points_move(struct hard_points *cloud, struct vec3 by);
/* To positions that float32 holds: a plane through the eye is one then for every renderer. */
void points_round(struct hard_points *cloud);
void points_shuffle(struct hard_points *cloud, uint32_t seed);
/* A closed bumpy ball of radius about 1 round `centre`: discs that overlap, outward normals,
 * colours that vary smoothly. bumps 0: a sphere. */
struct hard_points points_ball(const struct hard_options *o, struct vec3 centre, double bumps);
/* Through stp_scene_prepare, as a user's points go. epsilon 0: the median radius. */
struct stp_scene *points_scene(const struct hard_points *cloud, double epsilon, unsigned threads);
enum stp_result points_try(const struct stp_env *env, const struct hard_points *cloud,
                           double epsilon, struct stp_scene **scene);

/* points.c: looking at `target` from o->turn, o->rise, `distance` away. fov_y in degrees; 0:
 * orthographic, `distance` being what the picture is high. */
struct stp_camera hard_look(const struct hard_options *o, struct vec3 target, double distance,
                            double fov_y);
/* What the cloud is, rounded and with an epsilon of 0.02, as the camera sees it; releases it. */
void hard_show(struct hard_scene *s, struct hard_points *cloud, struct stp_camera camera,
               double min_splat);
/* A ball about 0, as it is, from all sides; releases it. */
void hard_show_ball(const struct hard_options *o, struct hard_scene *s, struct hard_points *cloud);
struct vec3 hard_towards_eye(const struct hard_options *o);
double hard_random(uint32_t *seed); /* [0, 1) */
struct vec3 hard_color(uint32_t *seed);
/* The normal of a plane that holds the ray from 0 to p. */
struct vec3 hard_edge_on(struct vec3 p, uint32_t *seed);
/* sheets.c: 30 red discs face on and 30 green ones `gap` of epsilon behind them; depths are sums of
 * powers of two, so that "at epsilon" is exact in every arithmetic. */
#define HARD_SHEETS_EPSILON 0.125
struct hard_points hard_sheets_make(double gap);
struct stp_camera hard_sheets_camera(const struct hard_options *o);

/* ways.c */
struct hard_way {
    const char *name;
    enum stp_method method;
    enum stp_path path;
    enum stp_payload payload;
    enum stp_transparency transparency;
};
#define HARD_WAYS 7
extern const struct hard_way hard_ways[HARD_WAYS];
/* Of transparent scenes; the first ones know glass and ellipses. */
#define HARD_LAYER_WAYS 6
#define HARD_EXACT_WAYS 3
extern const struct hard_way hard_layer_ways[HARD_LAYER_WAYS];
/* Those that draw what the scene is. */
const struct hard_way *hard_ways_of(const struct stp_scene *scene, unsigned *count);
/* Its error is what the paper says: of the bounds only soundness, and the case's `grouped`. */
bool hard_approximates(const struct hard_way *way);
struct stp_render_params hard_way_params(const struct hard_way *way,
                                         const struct stp_render_params *params);
/* Groups for `deferred`: one a splat where there are at most 64, which is exact; else c = 1. */
void hard_group(struct stp_scene *scene);
struct stp_image *hard_reference(const struct stp_scene *scene, const struct stp_camera *camera,
                                 const struct stp_render_params *params);
/* The largest of all covered pixels. */
typedef double (*hard_pixel_fn)(const struct hard_scene *s, const struct stp_image *image,
                                uint32_t px, uint32_t py);
double hard_worst(const struct hard_scene *s, const struct stp_image *image, hard_pixel_fn pixel);
/* The lesser PSNR of the normals' components and of depth over its own median; over pixels that
 * both cover. */
double hard_psnr(const struct stp_image *image, const struct stp_image *truth);

/* dB that `deferred` has on any surface at c = 1. One group's splats hide one another where front
 * and back lie within epsilon: over epsilon^2 / 4 of a ball's picture, half of a channel off at
 * most. */
#define HARD_GROUPED 30
/* dB asked of fits: of `deferred`; of packed keys, where rims alone have weights that their 12 bits
 * know to a per cent. */
#define HARD_FIT_GROUPED 40
#define HARD_FIT_PACKED  70
/* fitted.c: the scene's points are fitted, and the fit is held to what it promises of every one. */
struct stp_fit hard_fit(struct hard_scene *s, const struct hard_points *cloud, double epsilon,
                        double tolerance);
void hard_look_at_fit(const struct hard_options *o, struct hard_scene *s, struct vec3 target,
                      double distance);
/* A pixel's ray and what it shows, in the world. */
struct hard_seen {
    struct vec3 start, along; /* along: per unit of depth */
    struct vec3 point, normal;
    bool covered;
};
struct hard_seen hard_see(const struct hard_scene *s, const struct stp_image *image, uint32_t k);
double hard_angle(struct vec3 a, struct vec3 b);

/* keep.c */
#define HARD_SLUG 96
void hard_slug(const char *family, const struct hard_case *c, char slug[HARD_SLUG]);
/* What the options ask for: a PNG of way 0, EXRs of all. */
void hard_keep(const struct hard_options *o, const struct hard_scene *s, const char *slug,
               const struct stp_image *image, unsigned way);
bool hard_sound(const struct stp_image *image);

/* judge_case.c: renders a case every way, judges it, and fails with every verdict that is wrong. */
void hard_judge(const struct hard_options *o, struct device *device, const char *family,
                const struct hard_case *c);
/* axis.c: views that axis lists find hard. From `eye`, in pictures of odd sizes, and, as the
 * twin's, from a millionth of a radian aside; by perspective or not. From afar, with an h, negative
 * for 0. 170 degrees from inside. With a near plane among what is there. Orthographic. */
void hard_axis_from(const struct hard_options *o, struct hard_scene *s, struct vec3 eye, bool flat);
void hard_axis_look(const struct hard_options *o, struct hard_scene *s, double h);
void hard_axis_wide(const struct hard_options *o, struct hard_scene *s);
void hard_axis_inside(const struct hard_options *o, struct hard_scene *s);
void hard_axis_flat(const struct hard_options *o, struct hard_scene *s);
/* judge_axis.c: a volume or a surface by every merge, by compute and by the rasteriser. */
void hard_judge_axis(const struct hard_options *o, struct device *device, const char *family,
                     const struct hard_case *c);
/* judge_pyramid.c: any case of points; transparent ones have to be refused. */
void hard_judge_pyramid(const struct hard_options *o, struct device *device, const char *family,
                        const struct hard_case *c);
/* Of cases that run by themselves: a row of words. */
void hard_say(const struct hard_options *o, const char *family, const struct hard_case *c);

#endif
