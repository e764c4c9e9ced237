/* A plan's resources and passes, and how methods append them. */
#ifndef STP_PLAN_STEPS_H
#define STP_PLAN_STEPS_H

#include <stipple/plan.h>

#include "plan/shaders.h"

#define PLAN_MAX_RESOURCES 32
#define PLAN_MAX_PASSES    80 /* STP_MAX_GROUPS layers, and what comes before and after */
#define PLAN_MAX_ACCESSES  20
#define PLAN_NONE          255

/* What a buffer or image is for: a resource's address goes into the frame block by this. */
enum plan_slot {
    PLAN_SPLATS,
    PLAN_COLORS,
    PLAN_OPACITIES,
    PLAN_ELLIPSES,
    PLAN_CLIPS,
    PLAN_MATERIALS,
    PLAN_OBJECT_OPTICS,
    PLAN_ENVIRONMENT,
    PLAN_LIGHTS,
    PLAN_ORDER,
    PLAN_WORK,
    PLAN_OBJECTS,
    PLAN_RIM,
    PLAN_LARGE,
    PLAN_BINNED_LISTS,
    PLAN_KEYS,
    PLAN_SLOT_IDS,
    PLAN_TRAITS,
    PLAN_COUNTS,
    PLAN_NEAREST,
    PLAN_SUMS,
    PLAN_PROJECTED,
    PLAN_AXIS_SUMS,
    PLAN_HOST_WORDS,
    PLAN_LIMITS,
    PLAN_OUT_COLOR,
    PLAN_OUT_NORMAL,
    PLAN_OUT_DEPTH,
    PLAN_OUT_ALBEDO,
    PLAN_OUT_ID,
    PLAN_DEEP_LAYERS,
    PLAN_DEEP_COUNTS,
    PLAN_BUFFER_SLOTS, /* the frame block's addresses, in order, end here */
    PLAN_IMAGE_ID = PLAN_BUFFER_SLOTS,
    PLAN_IMAGE_DEPTH,
    PLAN_IMAGE_SUM,
    PLAN_IMAGE_SUM_DEPTH,
    PLAN_IMAGE_SUM_COLOR,
    PLAN_IMAGE_PYRAMID,
    PLAN_IMAGE_ATTRIBUTES,
    PLAN_TEXEL_POINTS,
    PLAN_TEXEL_RADII,
    PLAN_IMAGE_AXIS_COLOR,
    PLAN_IMAGE_AXIS_DEPTH,
    PLAN_TEXEL_KEYS, /* the words of PLAN_KEYS again, where its format is of texels */
    PLAN_TEXEL_SLOT_IDS,
    PLAN_TEXEL_PROJECTED, /* and those of PLAN_PROJECTED and PLAN_ORDER */
    PLAN_TEXEL_ORDER,
    PLAN_TEXEL_CLUSTERS,
    PLAN_TEXEL_TRAITS, /* and of PLAN_TRAITS */
    PLAN_SLOTS
};

/* The descriptor binding of what has no address; 0 is the frame block. */
#define PLAN_BINDING(slot) (1 + (slot)-PLAN_BUFFER_SLOTS)

enum plan_lifetime { PLAN_SCENE, PLAN_TRANSIENT, PLAN_OUTPUT };

enum plan_format {
    PLAN_BUFFER,
    PLAN_RG32UI,
    PLAN_RG32F,
    PLAN_RGBA32F,
    PLAN_D32F,
    PLAN_RGBA32UI,
    PLAN_TEXELS_RGBA32UI, /* a buffer that is fetched as texels */
    PLAN_TEXELS_R32F,
    PLAN_TEXELS_RG32UI,
    PLAN_TEXELS_R32UI,
};

/* Texels of a buffer that STP_FEATURE_TEXEL_BUFFERS promises; what a plan may use is its limits'.
 */
#define PLAN_MANY_TEXELS ((uint64_t)1 << 27)

struct plan_resource {
    char name[24];
    enum plan_slot slot;
    enum plan_lifetime lifetime;
    enum plan_format format;
    uint32_t width, height, layers; /* images */
    uint64_t bytes;
};

enum plan_kind {
    PLAN_FILL,      /* fill `target` with the word `value`; an image's first component, others 0 */
    PLAN_ARGUMENTS, /* reset the work buffer's arguments and flags */
    PLAN_DISPATCH,
    PLAN_DISPATCH_INDIRECT, /* three words at `offset` of the work buffer */
    PLAN_DRAW,              /* three vertices a splat */
    PLAN_EXCHANGE,          /* between processes, by the host */
    PLAN_COPY_DEPTH,        /* of a host's image, the tile's part */
};

enum plan_access_kind {
    PLAN_READ = 1,
    PLAN_WRITE = 2,
    PLAN_ATTACHMENT = 4, /* with WRITE: rendered to; with READ and WRITE: blended or tested */
};

struct plan_access {
    uint8_t resource;
    uint8_t kind; /* enum plan_access_kind, or-ed */
};

enum plan_raster {
    PLAN_RASTER_WINNER, /* depth test and write, ids out */
    PLAN_RASTER_BLEND,  /* additive, no depth */
    /* Premultiplied, over what is there; ids are replaced. Depth test and write, where the pass has
     * a depth image. */
    PLAN_RASTER_OVER,
};

enum plan_exchange {
    PLAN_EXCHANGE_NEAREST, /* the least key of each pixel to all, its splat to the root */
    PLAN_EXCHANGE_SUMS,    /* the sum of the sums to the root */
};

struct plan_pass {
    char name[40];
    enum plan_kind kind;
    enum plan_shader shader, vertex;
    enum plan_raster raster;
    uint8_t target;                    /* FILL: resource */
    uint32_t value;                    /* FILL */
    uint32_t offset;                   /* DISPATCH_INDIRECT: bytes into the work buffer */
    enum plan_exchange exchange;       /* EXCHANGE */
    uint32_t groups;                   /* DISPATCH: workgroups; 0: one a block of the tile */
    uint32_t level;                    /* pyramid: the level that is written */
    bool of_grid;                      /* DISPATCH: one a block of that level of the tile's grid */
    bool of_points;                    /* DISPATCH: one a run of the points on the device */
    bool repair;                       /* specialised with PLAN_REPAIR on */
    uint32_t layer, layer_count;       /* DRAW: of the attachments; axis: the walk */
    uint32_t part;                     /* axis: of a walk's lists */
    uint32_t first_splat, splat_count; /* DRAW */
    float scale;                       /* DRAW: of radii; 0: 1 */
    float shift;                       /* DRAW: of slabs, in slabs */
    uint8_t access_count;
    struct plan_access access[PLAN_MAX_ACCESSES];
};

/* plan/steps.c: what the methods' files share. */
uint8_t plan_resource(struct stp_plan *plan, const char *name, enum plan_slot slot,
                      enum plan_lifetime lifetime, uint64_t bytes);
uint8_t plan_image(struct stp_plan *plan, const char *name, enum plan_slot slot,
                   enum plan_format format, uint32_t layers);
struct plan_pass *plan_pass(struct stp_plan *plan, enum plan_kind kind, const char *name);
/* PLAN_SPLATS: all that a splat is, where it is more than a disc; PLAN_MATERIALS: and the light. */
void plan_reads(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
void plan_writes(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
void plan_updates(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
void plan_attaches(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
uint8_t plan_find(const struct stp_plan *plan, enum plan_slot slot); /* PLAN_NONE: absent */
uint64_t plan_pixels(const struct stp_plan *plan);                   /* of a tile, whole blocks */
void plan_fill(struct stp_plan *plan, enum plan_slot slot, uint32_t value, const char *name);
/* A pass that draws splats; updates `updated` (ends with PLAN_SLOTS). */
struct plan_pass *plan_splat_pass(struct stp_plan *plan, enum plan_kind kind, const char *name,
                                  const enum plan_slot *updated);
/* One pass over the splats: small, then large ones; updates `updated` (ends with PLAN_SLOTS). */
void plan_splat(struct stp_plan *plan, const char *name, enum plan_shader small_shader,
                enum plan_shader large_shader, bool repair, const enum plan_slot *updated);
/* binned.c: of two-pass, whether large splats are drawn block by block; what that takes; the pass
 * that bins them, once since the arguments were reset; after plan_splat, the pass that draws them.
 */
bool plan_bins(const struct stp_plan *plan);
void plan_bin_resources(struct stp_plan *plan);
void plan_bin(struct stp_plan *plan);
void plan_binned(struct stp_plan *plan, const char *name, enum plan_shader shader,
                 const enum plan_slot *updated);
void plan_blocks(struct stp_plan *plan);
/* What has drawn to images instead: finds the blocks that were touched, of which plan_blocks then
 * makes the list. */
void plan_touched(struct stp_plan *plan, const char *name, enum plan_shader shader);
/* An output that is written, or, where frames add to each other, added to. */
void plan_outputs(const struct stp_plan *plan, struct plan_pass *pass, enum plan_slot slot);
/* A resolving pass over the touched blocks; reads `read` (ends with PLAN_SLOTS), writes the
 * outputs. */
void plan_resolve(struct stp_plan *plan, const char *name, enum plan_shader shader, bool repair,
                  const enum plan_slot *read);

/* Splats on this device: all, or this process's share. */
uint64_t plan_splats(const struct stp_plan *plan);
/* Behind them, for several processes: stand-ins for the nearest splats that others hold. The root
 * has one a pixel, with all that resolving asks of a splat; the others one an object, since summing
 * asks only whose epsilon counts. */
uint64_t plan_ghosts(const struct stp_plan *plan);
/* Whether this process resolves and gets the picture. */
bool plan_is_root(const struct stp_plan *plan);
void plan_exchange(struct stp_plan *plan, enum plan_exchange exchange, const char *name);

#endif
