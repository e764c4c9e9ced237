/* Plans: what a picture of this scene needs, as a value. No GPU is touched. */
#ifndef STIPPLE_PLAN_H
#define STIPPLE_PLAN_H

#include <stipple/scene.h>
#include <stipple/view.h>

#ifdef __cplusplus
extern "C" {
#endif

enum stp_method {
    STP_METHOD_AUTO = 0,
    STP_METHOD_DEFERRED,  /* ZP Algorithm 1: K groups, one geometry pass */
    STP_METHOD_TWO_PASS,  /* the classical 2+1 pass */
    STP_METHOD_EXACT,     /* every fragment kept in one geometry pass, resolved exactly */
    STP_METHOD_REFERENCE, /* float64 on the CPU */
    STP_METHOD_PYRAMID,   /* MKC: one pixel a point, then pull and push */
    STP_METHOD_AXIS, /* HM: volumes, range images and surfaces' Gaussians by sorted axis lists */
};
/* How the layers of a transparent scene are composited; a scene that is opaque ignores it. */
enum stp_transparency {
    STP_TRANSPARENCY_AUTO = 0, /* what the method says, else exact */
    STP_TRANSPARENCY_FAST,     /* ZP Algorithm 2; method deferred */
    STP_TRANSPARENCY_NEAREST,  /* ZP Algorithm 3; method deferred */
    STP_TRANSPARENCY_PEEL,     /* depth peeling; method two-pass */
    STP_TRANSPARENCY_EXACT,    /* every fragment kept, cut into layers; method exact */
    STP_TRANSPARENCY_REFERENCE /* float64 on the CPU; method reference */
};
/* How far the eye's ray is bent and absorbed where transparent surfaces meet an environment. */
enum stp_layers {
    STP_LAYERS_MULTI = 0, /* by all layers, ZP Eq. 11 and 12 */
    STP_LAYERS_SINGLE,    /* by the nearest alone */
};
/* Which list serves a pixel (HM 3 and 5). */
enum stp_axis_merge {
    STP_AXIS_AUTO =
        0,          /* of method axis: blend; of method auto: sort, but blend where an h is given */
    STP_AXIS_BLEND, /* those that are nearly dominant on its ray, by Eq. 1 */
    STP_AXIS_CLIP,  /* the one of its ray's dominant axis */
    STP_AXIS_SINGLE,    /* Westover: one for the picture, of the view's axis */
    STP_AXIS_SORT,      /* one, sorted by distance from the eye */
    STP_AXIS_REFERENCE, /* every ray's own order, float64 on the CPU */
};
enum stp_path { STP_PATH_AUTO = 0, STP_PATH_RASTER, STP_PATH_COMPUTE };
enum stp_payload { STP_PAYLOAD_AUTO = 0, STP_PAYLOAD_ID, STP_PAYLOAD_PACKED };
enum stp_voronoi {
    STP_VORONOI_DEFAULT = 0, /* slab where c < 1; exact at c = 1 where the path is compute */
    STP_VORONOI_OFF,
    STP_VORONOI_SLAB,  /* ZP Eq. 10 */
    STP_VORONOI_EXACT, /* the smallest rho^2 within epsilon of the group's nearest; two passes */
};
enum stp_kernel {
    STP_KERNEL_PARABOLA = 0, /* 1 - rho^2 */
    STP_KERNEL_GAUSS,        /* exp(-2 rho^2), both for rho^2 <= 1 */
};
/* Where the light is computed; the latter two are baselines of method two-pass (BSK 6). */
enum stp_shade {
    STP_SHADE_PIXEL = 0, /* normals are averaged, and each pixel is shaded once */
    STP_SHADE_SPLAT, /* each splat's fragment is shaded, then colours are averaged: as BSK blends */
    STP_SHADE_FLAT,  /* the nearest splat alone, by its one normal; compute only */
};
enum stp_cull { STP_CULL_NONE = 0, STP_CULL_BACK };

#define STP_DEFAULT_PEEL_LAYERS 8
#define STP_DEFAULT_MIN_SPLAT   1.5  /* pixels */
#define STP_DEFAULT_AXIS_H      0.85 /* HM 5.2 */
#define STP_MAX_SAMPLES         65536

/* Extra channels beside R G B A Z N.X N.Y N.Z, or-ed. */
enum stp_aov {
    STP_AOV_ALBEDO = 1,    /* albedo.R albedo.G albedo.B, before light */
    STP_AOV_POSITION = 2,  /* P.X P.Y P.Z, relative to the origin */
    STP_AOV_WEIGHT = 4,    /* the sum of weights */
    STP_AOV_FRAGMENTS = 8, /* how many fragments were averaged */
    STP_AOV_COVERAGE = 16, /* share of the samples that hit */
    STP_AOV_ID = 32,       /* input index of the nearest splat, uint; 0xffffffff: none */
    STP_AOV_LAYERS = 64,   /* layers composited: 1 where covered, for opaque scenes */
};

/* Optional device features; --mask-feature behaves as if the device lacked one. */
enum stp_feature {
    STP_FEATURE_INT64_ATOMICS = 1,    /* shaderBufferInt64Atomics */
    STP_FEATURE_VERTEX_LAYER = 2,     /* gl_Layer from the vertex shader */
    STP_FEATURE_FLOAT32_BLEND = 4,    /* blending into R32G32B32A32_SFLOAT */
    STP_FEATURE_INT64 = 8,            /* shaderInt64 */
    STP_FEATURE_FLOAT64 = 16,         /* shaderFloat64: centres are projected in double */
    STP_FEATURE_STORAGE_FORMATS = 32, /* shaderStorageImageExtendedFormats: raster paths */
    STP_FEATURE_SHARED_MEMORY = 64,   /* device memory that the host may write: nothing is staged */
    STP_FEATURE_INDEPENDENT_BLEND = 128, /* independentBlend: transparency fast and nearest */
    STP_FEATURE_TEXEL_BUFFERS = 256,     /* of 2^27 texels: slots of exact, lists
                                            of axis, keys of pyramid */
    STP_FEATURE_SUBGROUP_SHUFFLE = 512,  /* of 8 threads: blocks of axis */
};
/* "int64-atomics", ...: in profiles and for --mask-feature. NULL: no such feature. */
STP_API const char *stp_feature_name(enum stp_feature feature);

/* What is expected of a frame; all 0: nothing was predicted. */
struct stp_prediction {
    double bound;        /* of the error: what was asked for */
    double milliseconds; /* of a warm frame, record to fence */
    double error;        /* mean absolute error of linear RGB over covered pixels, at most */
};

struct stp_render_params {
    enum stp_method method;
    enum stp_transparency transparency;
    unsigned peel_layers; /* peel: the most layers; 0: STP_DEFAULT_PEEL_LAYERS */
    enum stp_layers layers;
    enum stp_path path;
    enum stp_payload payload; /* deferred, exact, fast: what a key, slot or winner carries */
    enum stp_voronoi voronoi;
    enum stp_kernel kernel;
    enum stp_shade shade;
    enum stp_toggle light_cube; /* lighting looked up over normals (BSK 4.1): ON needs directional
                                   lights, no local viewer and one shininess; AUTO: off, since it is
                                   nowhere measured faster (docs/phong.md) */
    enum stp_cull cull;
    double epsilon;   /* 0: each object's own */
    double min_splat; /* least diameter of a projected splat, pixels; 0: STP_DEFAULT_MIN_SPLAT;
                         negative: off */
    unsigned samples; /* stratified samples a pixel, at most STP_MAX_SAMPLES, rounded up to a
                         square; 0: 1; raster paths have no more than 1 */
    unsigned aovs;    /* enum stp_aov, or-ed */
    bool deep;        /* the picture keeps its layers one by one: stp_image.deep */
    enum stp_axis_merge axis_merge;
    double axis_h;           /* axis, blend: [0, 1), lists whose axis has more than this share of
                                the dominant one are merged; 0: STP_DEFAULT_AXIS_H;
                                negative: 0 */
    const float *background; /* NULL: none (alpha 0), or linear RGBA composited behind */
    bool environment_behind; /* the scene's environment in the place of that background */
    bool local_viewer;       /* half vectors from the point, not the axis */
    unsigned mask_features;  /* enum stp_feature, or-ed */
    uint64_t memory_limit;   /* bytes of transients and outputs; 0: the device's */
    double max_error;        /* stp_choose: the most mean absolute error of linear RGB over covered
                                pixels, against the reference; 0: STP_DEFAULT_MAX_ERROR */
    struct stp_prediction prediction; /* of stp_choose, for the plan's sentence */
};
#define STP_DEFAULT_MAX_ERROR 1e-4

/* Prices of what a frame is made of, in nanoseconds: a kind of method a row (docs/auto.md). A row
 * of zeros: nothing is known of that kind. */
#define STP_COST_KINDS 32
#define STP_COST_TERMS 12
struct stp_calibration {
    bool measured; /* on the device itself; false: built in */
    double ns[STP_COST_KINDS][STP_COST_TERMS];
};

enum stp_processor { STP_PROCESSOR_CPU = 1, STP_PROCESSOR_GPU = 2 };

/* What a device can do: hand-filled in tests, read from a profile or from a device. */
struct stp_limits {
    char device[256], driver[256];
    unsigned features;       /* enum stp_feature, or-ed */
    uint64_t heap_bytes;     /* of the largest device-local heap */
    uint64_t max_allocation; /* of one buffer */
    uint32_t max_image_size, max_image_layers;
    uint32_t max_workgroups; /* along x */
    uint32_t max_texels;     /* of a buffer that is fetched as texels */
    uint32_t processor;      /* enum stp_processor */
    struct stp_calibration calibration;
};
/* Mesa 22.3 lavapipe on two cores: what plans are made for when there is no device. */
STP_API void stp_limits_lavapipe(struct stp_limits *limits);
/* A profile that `stipple devices --json` wrote. */
STP_API enum stp_result stp_limits_load(const struct stp_env *env, const char *path,
                                        struct stp_limits *limits);
/* The profile as JSON, calibration and all. Free with free(). NULL: out of memory. */
STP_API char *stp_limits_print(const struct stp_limits *limits);

struct stp_plan;

/* What stp_choose looked at, the cheapest first. */
enum stp_verdict {
    STP_VERDICT_COSTLY = 0, /* meets the bound, or was not judged: another was cheaper, or
                              hardly dearer and needs no groups */
    STP_VERDICT_CHOSEN,
    STP_VERDICT_INEXACT, /* its error is beyond the bound */
};
struct stp_considered {
    enum stp_method method;
    enum stp_path path;
    enum stp_payload payload;
    enum stp_voronoi voronoi;
    double overlap;                     /* 0: needs no groups */
    unsigned groups;                    /* that the price was made for */
    enum stp_transparency transparency; /* AUTO: of an opaque scene */
    unsigned peel_layers;               /* 0: nothing is peeled */
    double milliseconds;                /* predicted */
    double error;                       /* estimated, at most; NaN: not judged */
    enum stp_verdict verdict;
};
#define STP_MAX_CONSIDERED 64
struct stp_choice {
    struct stp_render_params params; /* as asked, with method, path, payload, voronoi and
                                        prediction filled in: what to plan with */
    bool met;                        /* false: nothing meets the bound, this is the most exact */
    unsigned count;
    struct stp_considered considered[STP_MAX_CONSIDERED];
};

/* Decides what params leave open (STP_*_AUTO, and the overlap where group->overlap is 0): the way
 * to render this view that a model of cost, calibrated on the device, predicts to be the fastest of
 * those whose error is within params->max_error. The error is measured: a sample of the picture's
 * pixels is resolved on the CPU as each method would. Where max_error is 0, methods that need
 * groups are left out unless asked for: finding groups costs more than a picture. The scene is
 * grouped as the choice wants, and may be regrouped. Deterministic for one profile. Where nothing
 * applies the params come back as they were, and stp_plan_create says why. */
STP_API enum stp_result stp_choose(const struct stp_env *env, struct stp_scene *scene,
                                   const struct stp_camera *camera,
                                   const struct stp_group_params *group,
                                   const struct stp_render_params *params,
                                   const struct stp_limits *limits, struct stp_choice *choice);

/* Whether stp_choose predicts anything: not of volumes and range images, not of layers composited
 * fast or nearest, nor of any layers while max_error is 0. Then a bound is not looked at, one
 * warning says so, and no device need be calibrated. */
STP_API bool stp_choose_estimates(const struct stp_facts *facts,
                                  const struct stp_render_params *params);

/* scene: prepared; and grouped when the method is deferred. */
STP_API enum stp_result stp_plan_create(const struct stp_env *env, const struct stp_scene *scene,
                                        const struct stp_camera *camera,
                                        const struct stp_render_params *params,
                                        const struct stp_limits *limits, struct stp_plan **plan);
/* True when stp_plan_create would want stp_scene_group first, under these params and limits. */
STP_API bool stp_plan_needs_groups(const struct stp_facts *facts,
                                   const struct stp_render_params *params,
                                   const struct stp_limits *limits);

/* The same of stp_scene_cover. */
STP_API bool stp_plan_needs_cover(const struct stp_facts *facts,
                                  const struct stp_render_params *params,
                                  const struct stp_limits *limits);

struct stp_plan_summary {
    enum stp_method method;             /* never AUTO */
    enum stp_transparency transparency; /* AUTO: nothing is transparent */
    enum stp_path path;
    enum stp_payload payload;
    enum stp_voronoi voronoi;
    const char *why; /* one sentence */
    uint64_t scene_bytes, transient_bytes, output_bytes;
    uint32_t tiles; /* pictures are rendered in this many tiles */
    uint32_t passes, resources;
};
STP_API void stp_plan_summarize(const struct stp_plan *plan, struct stp_plan_summary *summary);
/* The plan in words: images, buffers, passes, bytes. Free with free(). NULL: out of memory. */
STP_API char *stp_plan_print(const struct stp_plan *plan);
STP_API void stp_plan_destroy(struct stp_plan **plan);

/* As the command writes them; NULL: no such value. */
STP_API const char *stp_method_name(enum stp_method method);
STP_API const char *stp_transparency_name(enum stp_transparency transparency);
STP_API const char *stp_path_name(enum stp_path path);

#ifdef __cplusplus
}
#endif
#endif
