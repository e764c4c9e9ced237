/* Scenes: points in, splats out. Units are the scene's own; colours are linear Rec.709. */
#ifndef STIPPLE_SCENE_H
#define STIPPLE_SCENE_H

#include <stipple/environment.h>
#include <stipple/range.h>
#include <stipple/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

struct stp_scene;

enum stp_up { STP_UP_AUTO = 0, STP_UP_X, STP_UP_Y, STP_UP_Z, STP_UP_NEG_Y };
enum stp_toggle { STP_AUTO = 0, STP_ON, STP_OFF };
enum stp_transfer { STP_TRANSFER_AUTO = 0, STP_TRANSFER_SRGB, STP_TRANSFER_LINEAR };
enum stp_relax {
    STP_RELAX_DEFAULT = 0, /* opposed */
    STP_RELAX_NONE = 1,
    STP_RELAX_COPLANAR = 2, /* ZP 4.1 (1), of one colour */
    STP_RELAX_OPPOSED = 4,  /* ZP 4.1 (2) */
};

/* I = albedo (ambient + diffuse max(0, n.l)) + specular max(0, n.h)^shininess, summed over the
 * lights. A NULL material means 0.1, 0.7, 0.2, 32 and albedo 0.8. */
struct stp_material {
    float ambient, diffuse, specular, shininess;
    float albedo[3]; /* of points that carry no colour */
    float opacity; /* (0, 1], multiplied with the points' and the object's. As theirs, 0 is not set
                      and means 1, and a negative one means 0: nothing is seen */
};

struct stp_light {
    bool at_eye;         /* directional along the view axis; the default light is this one */
    bool positional;     /* position is a point; else direction is towards the light */
    double position[3];  /* world */
    double direction[3]; /* world, towards the light; need not be unit */
    float color[3];      /* linear; 1 is the default head light */
};

/* BSK 3: an elliptical splat and its linear normal field. With c the position and n the normal of
 * the point, v = n x u, the splat is drawn at c + s radius[0] u + t radius[1] v where s^2 + t^2 <=
 * 1 and its clip lines keep it (Eq. 1), and is lit by the direction of N = n + (field[0] + field[1]
 * s) u + (field[2] + field[3] t) v (Eq. 2). */
struct stp_phong_splat {
    float u[3];      /* unit, at right angles to the normal; (0, 0, 0): a disc of the point's radius
                        and normal, the rest is of no matter */
    float radius[2]; /* semi-axes along u and v, > 0 */
    float field[4];
    float clip[2][3]; /* a s + b t + c >= 0 is kept */
    uint8_t clips;    /* lines: 0, 1, 2 */
    uint8_t reflex; /* of two lines: 0 both must keep it (a convex edge), 1 either (a reflex one) */
};

/* Points handed over in memory. Arrays are borrowed for the call only. */
struct stp_points {
    size_t count;
    const double (*position)[3];
    const float (*normal)[3];            /* NULL: estimated */
    const float *radius;                 /* NULL: from local spacing; 0 or NaN: that one is */
    const float (*color)[3];             /* NULL: the material's albedo; linear */
    const float *opacity;                /* NULL: 1; NaN: 1; clamped to [0, 1]; 0: not drawn */
    const struct stp_phong_splat *phong; /* NULL: discs; else with normals, and radius gives way to
                                            the larger of the splat's own two */
};

/* One object of a scene. */
struct stp_object_params {
    const struct stp_material *material; /* NULL: the default */
    double epsilon;                      /* eye depth, scene units; 0: the median radius */
    float opacity; /* 0: 1; negative: 0. Multiplies the points' own and the material's */
    const struct stp_optics *optics; /* NULL: the default */
};

struct stp_load_params {
    enum stp_up up;             /* what is up; AUTO asks the file's format */
    enum stp_transfer transfer; /* AUTO: integer colours are sRGB, float colours linear */
    const char *color_by;       /* NULL or "rgb", "normal", "height", "intensity", "class",
                                   or the name of a scalar property; of range images also
                                   "views" */
    const struct stp_material *material;
    double epsilon;
    float
        opacity; /* as in stp_object_params; in the place of what a scene .json says of an object */
    const struct stp_optics *optics; /* what it sets wins over a scene .json */
    float radius;                    /* of points that bring none; 0: from local spacing */
    /* A binary PLY of more points than this, with normals and radii and nothing that takes a look
     * at other points, stays in its file: the scene takes a byte a point, and only method pyramid
     * draws it. What cannot stay there is read whole, with a warning. 0: everything is. Not in a
     * scene .json. */
    size_t stream_above;
    size_t stream_chunk;             /* points that are then held at once; 0: 8388608 */
    struct stp_volume_params volume; /* of a volume */
    struct stp_range_params range;   /* of range images */
};

/* Reads a point file (PLY, LAS, PCD, text, OFF, OBJ), a volume (NIfTI, NRRD, MetaImage, INRIMAGE,
 * raw; docs/volumes.md), gzip of any, a scene .json (docs/scene.md), or a folder of range images
 * (docs/range.md).
 * The format is found from the content, not from the name. */
STP_API enum stp_result stp_scene_load(const struct stp_env *env, const char *path,
                                       const struct stp_load_params *params,
                                       struct stp_scene **scene);

/* An empty scene; add points with stp_scene_add_points. */
STP_API enum stp_result stp_scene_create(const struct stp_env *env, struct stp_scene **scene);
STP_API enum stp_result stp_scene_add_points(const struct stp_env *env, struct stp_scene *scene,
                                             const struct stp_points *points,
                                             const struct stp_object_params *object);
/* A scene holds points, or one volume. params may be NULL. */
STP_API enum stp_result stp_scene_set_volume(const struct stp_env *env, struct stp_scene *scene,
                                             const struct stp_volume *volume,
                                             const struct stp_volume_params *params);
/* Another transfer function (params->transfer_function, params->unshaded) for the scene's volume.
 * Of a prepared scene the voxels are classified again; nothing is read again. On failure the scene
 * is as it was. */
STP_API enum stp_result stp_scene_set_transfer_function(const struct stp_env *env,
                                                        struct stp_scene *scene,
                                                        const struct stp_volume_params *params);
/* At most STP_MAX_LIGHTS; count 0 restores the head light. */
#define STP_MAX_LIGHTS 8
STP_API enum stp_result stp_scene_set_lights(const struct stp_env *env, struct stp_scene *scene,
                                             const struct stp_light *lights, unsigned count);

struct stp_prepare_params {
    enum stp_toggle two_sided; /* AUTO: on where normals are estimated, inward, or the surface is
                                  open (facts.outwardness below 0.1) */
    const double *clip_box;    /* NULL, or x0 y0 z0 x1 y1 z1: points outside are left out */
};

/* Points to splats: drops what is not finite, estimates and orients missing normals, finds
 * missing radii, and puts the splats in canonical order (Morton, then every attribute), so that
 * nothing after it depends on the order of the file. Frees the points. Call once. */
STP_API enum stp_result stp_scene_prepare(const struct stp_env *env, struct stp_scene *scene,
                                          const struct stp_prepare_params *params);

struct stp_group_params {
    double overlap;      /* c of ZP 4.1 (3), (0, 1]; 0: STP_DEFAULT_OVERLAP */
    unsigned relax;      /* enum stp_relax, or-ed; 0: opposed */
    unsigned max_groups; /* 0: STP_MAX_GROUPS; when the colouring needs more, c is lowered */
};
#define STP_DEFAULT_OVERLAP 0.85
#define STP_MAX_GROUPS      64

struct stp_grouping {
    unsigned groups; /* K; 0: not grouped */
    double overlap;  /* the c that was used */
    unsigned relax;
    unsigned max_degree; /* of the overlap graph, ZP Eq. 5 relaxed */
    double avg_degree;
    size_t crowded;      /* splats too crowded for max_groups at any c: they share a group with
                            others that they overlap */
    double milliseconds; /* graph and colouring */
};

/* ZP 4.1: overlap graph and Largest-First colouring. Needed by the deferred method only. After
 * stp_scene_prepare; may be called again with other parameters. Every prepared scene can be
 * grouped: what cannot be done at the asked c is done at a lower one, with a warning. */
STP_API enum stp_result stp_scene_group(const struct stp_env *env, struct stp_scene *scene,
                                        const struct stp_group_params *params);

/* ZP 4.2: how a group comes to cover the surface. */
enum stp_extend {
    STP_EXTEND_AUTO = 0,  /* BOTH up to 4 groups, larger radii beyond */
    STP_EXTEND_DUPLICATE, /* splats join further groups */
    STP_EXTEND_ENLARGE,   /* ZP Eq. 9: one factor a group, at most 2 */
    STP_EXTEND_BOTH,      /* duplicates up to 45 %, then radii by up to 1.2; more duplicates where
                             that is not enough */
};

struct stp_cover_params {
    unsigned groups; /* K; 0: STP_DEFAULT_COVER_GROUPS; at most STP_MAX_GROUPS */
    double coverage; /* of the surface, each group; 0: STP_DEFAULT_COVERAGE; at most 1 */
    enum stp_extend extend;
};
#define STP_DEFAULT_COVER_GROUPS 3
#define STP_DEFAULT_COVERAGE     0.98

/* Of the groups for transparency. Shares are of the area that all discs cover together. */
struct stp_cover {
    unsigned groups;                 /* K; 0: none were made */
    enum stp_extend extend;          /* never AUTO */
    size_t members;                  /* summed over the groups */
    double duplicates;               /* memberships beyond one a splat, over the splats */
    double before[STP_MAX_GROUPS];   /* share that each group covered at first */
    double coverage[STP_MAX_GROUPS]; /* and covers now */
    double factor[STP_MAX_GROUPS];   /* of its radii */
    double error;                    /* standard error of the shares, at most */
    double milliseconds;
};

/* ZP 4.2: K groups that each cover the surface, for the transparencies `fast` and `nearest`. Apart
 * from stp_scene_group and what it made. After stp_scene_prepare; may be called again. */
STP_API enum stp_result stp_scene_cover(const struct stp_env *env, struct stp_scene *scene,
                                        const struct stp_cover_params *params);

enum stp_normals { STP_NORMALS_GIVEN = 0, STP_NORMALS_ESTIMATED, STP_NORMALS_NONE };

/* What is known of a scene: input to plans, printed by `stipple info`. */
struct stp_facts {
    size_t points;      /* read */
    size_t splats;      /* kept */
    size_t not_finite;  /* dropped: a coordinate was NaN, infinite or beyond 1e18 */
    size_t clipped;     /* dropped: outside the clip box */
    size_t duplicates;  /* kept, but equal to another in every attribute */
    size_t bad_normals; /* zero or not finite, estimated instead */
    size_t bad_radii;   /* zero, negative, not finite or monstrous, set from the spacing */
    size_t outliers;    /* far from everything; their radius was bounded */
    size_t bad_phong;   /* ellipses that are not finite, flat or skew: drawn as discs instead */
    size_t no_normal;   /* splats that face the eye: no normal could be estimated */
    enum stp_normals normals;
    bool has_color, two_sided;
    bool transparent;     /* some splat's opacity is below 1 */
    bool mixed;           /* and some splat's is 1: opaque things among transparent ones */
    bool uniform_opacity; /* the splats of each object share one opacity */
    float opacity_min;    /* 1 where nothing is transparent */
    bool eye_dome;        /* shade by depth: normals are mostly unknown */
    double outwardness;   /* sum r^2 n.(p - centroid) / sum r^2 |p - centroid|, [-1, 1] */
    double bounds[6];     /* of the centres: min x y z, max x y z; absolute */
    double origin[3];     /* positions on the device are relative to it */
    double float_step;    /* all coordinates are float32, whose steps are so large at the largest of
                             them; 0: they are finer, or stay in their file */
    float radius_min, radius_median, radius_max;
    size_t phong;      /* splats that are ellipses, have a normal field or clip lines */
    size_t clip_lines; /* of them, those with clip lines */
    float color_min;   /* smallest colour component, and at most 0 */
    float color_max;   /* largest colour component; 0 without colours */
    unsigned objects, lights;
    bool positional_lights;
    unsigned environment_levels; /* sharp, then one for each roughness; 0: no environment */
    uint64_t environment_texels; /* of all levels, polar rows included */
    bool reflects, disperses;    /* some surface meets the environment; its channels apart */
    bool absorbs;                /* some surface has an absorption */
    bool mirrors;                /* some surface has a reflectance */
    bool between_levels;         /* more roughnesses than levels: two are mixed */
    enum stp_up up;              /* resolved */
    struct stp_grouping grouping;
    struct stp_cover cover;
    struct stp_volume_facts volume;
    struct stp_range_facts range;
    char format[32]; /* of the (first) file, "" when made in memory */
};

/* Valid until the scene is changed or destroyed. Before prepare only points and format are set. */
STP_API const struct stp_facts *stp_scene_facts(const struct stp_scene *scene);

/* The prepared splats as a PLY that reads back bit for bit (docs/formats.md). */
STP_API enum stp_result stp_scene_save(const struct stp_env *env, const struct stp_scene *scene,
                                       const char *path);

STP_API void stp_scene_destroy(struct stp_scene **scene);

#ifdef __cplusplus
}
#endif
#endif
