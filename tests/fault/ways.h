/* Every way to a picture: a method that is added gets a line a path here, and is then tested for
 * failing calls, failing allocations and growth. */
#ifndef TEST_FAULT_WAYS_H
#define TEST_FAULT_WAYS_H

#include <stipple/plan.h>

static const struct way {
    const char *name;
    struct stp_render_params params;
} ways[] = {
    { "exact", { .method = STP_METHOD_EXACT, .path = STP_PATH_COMPUTE } },
    { "exact with ids",
      { .method = STP_METHOD_EXACT, .path = STP_PATH_COMPUTE, .payload = STP_PAYLOAD_ID } },
    { "two-pass by compute", { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_COMPUTE } },
    { "two-pass by raster", { .method = STP_METHOD_TWO_PASS, .path = STP_PATH_RASTER } },
    { "deferred by compute", { .method = STP_METHOD_DEFERRED, .path = STP_PATH_COMPUTE } },
    { "deferred by raster", { .method = STP_METHOD_DEFERRED, .path = STP_PATH_RASTER } },
    { "pyramid", { .method = STP_METHOD_PYRAMID, .cull = STP_CULL_BACK } },
    { "axis by compute", { .method = STP_METHOD_AXIS, .path = STP_PATH_COMPUTE } },
    { "axis by raster", { .method = STP_METHOD_AXIS, .path = STP_PATH_RASTER } },
    { "reference", { .method = STP_METHOD_REFERENCE } },
};
#define WAYS (sizeof ways / sizeof *ways)

#endif
