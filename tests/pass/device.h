/* What the tests of the passes share: one validated context a program, hand-filled scenes, and the
 * judgement of a picture against the reference. */
#ifndef TEST_PASS_DEVICE_H
#define TEST_PASS_DEVICE_H

#include "fixture.h"
#include "plan/plan.h"
#include <stipple/compare.h>
#include <stipple/render.h>

struct device {
    struct stp_env env;
    struct stp_context *context;
    unsigned lines; /* errors and warnings logged */
    char last[1024];
};

/* Validation and synchronisation validation on; fails the test where there is no device. */
void device_open(struct device *device, unsigned mask_features);
/* Fails on any validation message since it was opened. */
void device_close(struct device *device);

enum stp_result device_plan(struct device *device, const struct stp_scene *scene,
                            const struct stp_camera *camera, const struct stp_render_params *params,
                            struct stp_plan **plan);
/* Plans and renders; must succeed without a line in the log. */
struct stp_image *device_render(struct device *device, const struct stp_scene *scene,
                                const struct stp_camera *camera,
                                const struct stp_render_params *params);
struct stp_image *device_render_plan(struct device *device, const struct stp_scene *scene,
                                     const struct stp_plan *plan);

/* scenes.c: prepared scenes that are filled by hand. No splats yet; `objects` objects of one
 * material and epsilon. Destroy with stp_scene_destroy. */
struct stp_scene *scene_make(size_t capacity, unsigned objects, double epsilon);
/* A zero normal is unknown. Returns the splat's canonical id. */
size_t scene_add(struct stp_scene *scene, struct vec3 p, struct vec3 n, double radius);
void scene_paint(struct stp_scene *scene, size_t i, float r, float g, float b);
/* Others stay opaque. */
void scene_fade(struct stp_scene *scene, size_t i, float opacity);
/* Others stay discs. */
void scene_bend(struct stp_scene *scene, size_t i, const struct stp_phong_splat *phong);
void scene_assign(struct stp_scene *scene, size_t i, unsigned object);
/* A bumpy sheet of overlapping discs that faces the eye of plain_camera, its objects in turns. */
#define SCENE_SHEET_SPLATS 9
struct stp_scene *scene_sheet(unsigned objects, uint32_t seed);
/* Call after the last splat: bounds, counts, radii and the origin. */
void scene_finish(struct stp_scene *scene);
/* Each splat a group of its own (64 at most): deferred splatting is exact then. */
void scene_own_groups(struct stp_scene *scene);
/* Splats as fill_randomly makes them, in `scene`; finished. */
struct stp_scene *scene_random(uint32_t seed, size_t count, double epsilon);

/* judge.c */
struct tolerance {
    double color;   /* of the larger of 1 and the channel */
    double normal;  /* of a component */
    double depth;   /* in epsilons */
    double psnr;    /* over pixels that are not fragile */
    double fragile; /* most share of covered pixels that may be fragile */
};
/* Packed payloads; `exact` with ids; two-pass, and deferred with ids. */
extern const struct tolerance packed_tolerance, exact_tolerance, float_tolerance;
/* Layers: the end of an epsilon decides of each whether a fragment is its own layer. */
extern const struct tolerance layers_tolerance;

/* In the world. */
struct vec3 eye_of_camera(const struct stp_camera *camera);

struct verdict {
    size_t covered, fragile, off;
    bool noisy; /* more over the picture than its tolerance and condition */
    double psnr, worst_color, worst_normal, worst_depth;
    double squares, condition; /* of the errors, and of those that the condition allows */
};

/* Renders the reference as asked, and with what float32 rounds moved as far as it may be: the
 * picture by some dozen roundings of a place in it, every splat's depth up or down by
 * itself, epsilon and near plane. What the reference itself changes by that is the pixel's
 * condition, and is allowed beside the tolerance; where it is beyond 1 % the pixel is fragile and
 * left out, for an outline, the end of an epsilon or a cut passes so close to its centre that
 * float32 may fall on either side. */
/* Those renderings; they serve every plan of one scene and view that quantises depth alike. */
#define TRUTH_VARIANTS 8
struct truth {
    struct stp_image *image, *variant[TRUTH_VARIANTS];
};
void truth_make(const struct stp_scene *scene, const struct stp_plan *plan, struct truth *truth);
void truth_destroy(struct truth *truth);
struct verdict judge_against(const struct truth *truth, double epsilon,
                             const struct stp_image *image, const struct tolerance *tolerance);
struct verdict judge(const struct stp_scene *scene, const struct stp_plan *plan,
                     const struct stp_image *image, const struct tolerance *tolerance);
/* Plans, renders, judges, and fails with `what` in the message. */
void expect_reference(struct device *device, const struct stp_scene *scene,
                      const struct stp_camera *camera, const struct stp_render_params *params,
                      const struct tolerance *tolerance, const char *what);
/* The same for exact (packed and ids), two-pass (compute and raster) and, where each splat is a
 * group of its own, deferred in all four ways. */
void expect_everywhere(struct device *device, const struct stp_scene *scene,
                       const struct stp_camera *camera, const struct stp_render_params *params,
                       const char *what);
/* Every plane but id has the same bits. */
void expect_same_bits(const struct stp_image *a, const struct stp_image *b, const char *what);

#endif
