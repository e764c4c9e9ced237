#include "fuzz.h"

#include <math.h>
#include <stipple/view.h>

static void check_camera(const struct stp_camera *camera)
{
    for (int i = 0; i < 16; i++)
        fuzz_check(isfinite(camera->world_to_camera[i]), "a camera's matrix is finite");
    fuzz_check(isfinite(camera->fx) && isfinite(camera->fy), "a camera's focal lengths are finite");
    fuzz_check(isfinite(camera->cx) && isfinite(camera->cy), "a camera's centre is finite");
    fuzz_check(camera->fx > 0 && camera->fy > 0, "a camera's focal lengths are positive");
    fuzz_check(camera->width && camera->height, "a camera has a size");
    fuzz_check(camera->near_depth < camera->far_depth, "near is nearer than far");
}

/* The size given is the input's own, or another one by its length. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_log log;
    struct stp_camera camera;
    uint32_t count = 0, side = size % 2 ? 640 : 0;
    char path[32];
    int file = fuzz_file_open(data, size, path);
    fuzz_begin(&log);
    enum stp_result result =
        stp_camera_load(&log.env, path, size % 3 == 2, side, side / 2, &camera, &count);
    fuzz_end(&log, result);
    if (result == STP_OK) {
        fuzz_check(count > size % 3 / 2, "a camera path has the camera that was read");
        check_camera(&camera);
    }
    fuzz_file_close(file);
    return 0;
}
