/* Rendering on a context of our own: devices, pictures, times. */
#ifndef STIPPLE_RENDER_H
#define STIPPLE_RENDER_H

#include <stipple/image.h>
#include <stipple/plan.h>

#ifdef __cplusplus
extern "C" {
#endif

struct stp_context;

struct stp_context_params {
    const char *device;     /* substring of the device's name; NULL: GPUs first */
    bool validate;          /* validation and synchronisation validation; a message is an error */
    unsigned mask_features; /* enum stp_feature, or-ed */
};

/* Thread-safe against other contexts; one context is for one thread at a time. */
STP_API enum stp_result stp_context_create(const struct stp_env *env,
                                           const struct stp_context_params *params,
                                           struct stp_context **context);
STP_API const struct stp_limits *stp_context_limits(const struct stp_context *context);
/* How many messages the validation layers have sent so far. */
STP_API unsigned stp_context_messages(const struct stp_context *context);
STP_API void stp_context_destroy(struct stp_context **context);

struct stp_calibrate_params {
    bool again;       /* measure, though there is a calibration in the cache */
    bool only_cached; /* take what the cache has, measure nothing */
};
/* Finds the prices that stp_choose decides by, and puts them into the context's limits: from the
 * cache ($XDG_CACHE_HOME/stipple, else ~/.cache/stipple; a file for a device, driver and version of
 * this library), else by timing synthetic scenes, which takes about a minute, and then fills the
 * cache. Without it a device has the built-in prices of Mesa's software device. A cache that is
 * damaged or cannot be written costs a warning, no more. */
STP_API enum stp_result stp_calibrate(const struct stp_env *env, struct stp_context *context,
                                      const struct stp_calibrate_params *params);

#define STP_MAX_PASSES 72
struct stp_pass_time {
    char name[48];
    double milliseconds; /* median over the frames, summed over tiles and samples */
};
struct stp_render_stats {
    double upload_ms, first_frame_ms, read_back_ms;
    unsigned frames;
    double frame_ms_min, frame_ms_median, frame_ms_max; /* warm, record to fence, all tiles */
    unsigned pass_count;
    struct stp_pass_time pass[STP_MAX_PASSES];
    /* Splats that are not culled and whose bounds meet the picture, a few too many rather than too
     * few. 0: not counted (several processes), or no splats in memory (streams, volumes, frames).
     */
    uint64_t splats_drawn;
    uint64_t bytes_scene, bytes_transient, bytes_peak;
};

/* Renders the plan: uploads, records, submits, waits, reads back. repeat frames are timed after
 * the first (0: none). context may be NULL for the reference method only. stats may be NULL. *image
 * is the caller's: stp_image_destroy. The plan must have been made for the context's limits, and of
 * this scene as it now is: STP_ERROR_ARGUMENT where the scene was fitted, shared, or got another
 * transfer function or environment since; was grouped again, and the plan is of method deferred; or
 * was covered again, and the plan composites fast or nearest. Lights are the plan's. */
STP_API enum stp_result stp_render(const struct stp_env *env, struct stp_context *context,
                                   const struct stp_scene *scene, const struct stp_plan *plan,
                                   unsigned repeat, struct stp_image **image,
                                   struct stp_render_stats *stats);

struct stp_device_info {
    struct stp_limits limits;
    bool usable;
    char lacks[512]; /* names of what is missing, required and optional; "" when nothing */
    char api_version[32];
};
/* Fills in up to `capacity` devices; *count gets how many there are, be it more. Capacity 0, with
 * which devices may be NULL, asks for the count alone. */
STP_API enum stp_result stp_devices(const struct stp_env *env, struct stp_device_info *devices,
                                    unsigned capacity, unsigned *count);

#ifdef __cplusplus
}
#endif
#endif
