/* Range images: the first byte says whether the rest is a depth, a picture, both of a frame,
 * intrinsics or poses. */
#include <math.h>

#include "base/memory.h"
#include "fuzz.h"
#include "load/range.h"

static enum stp_result read_image(const struct stp_env *env, const struct file_bytes *bytes,
                                  enum range_plane plane)
{
    struct range_image image = { 0 };
    enum stp_result result = range_image_from_bytes(env, "input", bytes, plane, &image);
    fuzz_check((result == STP_OK) == (image.value != NULL), "a failure leaves the image alone");
    if (result == STP_OK)
        fuzz_check(image.width > 0 && image.height > 0 &&
                       (image.channels == 1 || (image.channels == 3 && plane == RANGE_COLOR)),
                   "an image has pixels");
    range_image_release(&image);
    return result;
}

static void check_frame(const struct range_frame *frame)
{
    size_t count = (size_t)frame->width * frame->height, bad = 0;
    for (size_t i = 0; i < count; i++) {
        bad += !(frame->depth[i] >= 0 && isfinite(frame->depth[i]));
        for (int k = 0; k < 3; k++)
            bad += !(frame->color[i][k] >= 0 && isfinite(frame->color[i][k]));
    }
    fuzz_check(bad == 0 && frame->not_finite <= count, "depths and colours are usable");
}

/* A byte of options, two of how long the depth's file is, its file, the colour's. */
static enum stp_result read_frame(const struct stp_env *env, const struct file_bytes *bytes)
{
    if (bytes->size < 3)
        return STP_OK;
    unsigned options = bytes->data[0], left = (unsigned)bytes->size - 3;
    unsigned split = (bytes->data[1] | (unsigned)bytes->data[2] << 8) % (left + 1);
    const unsigned char *depth = bytes->data + 3;
    struct range_frame frame = { .camera = { .fx = 500, .fy = 500 } };
    struct range_units units = { .depth_scale = options & 8 ? 1000 : 1,
                                 .baseline = options & 16 ? 0.1 : 0,
                                 .disparity_offset = options & 32 ? -3 : 0,
                                 .margin = options & 64 ? 1.5 : 0 };
    char depth_path[32], color_path[32];
    int depth_file = fuzz_file_open(depth, split, depth_path);
    int color_file = fuzz_file_open(depth + split, left - split, color_path);
    enum stp_result result = range_frame_read(env, depth_path, color_path, &units,
                                              (enum stp_transfer)(options % 3), &frame);
    fuzz_check((result == STP_OK) == (frame.depth && frame.color) && !frame.depth == !frame.color,
               "a failure leaves no pictures");
    if (result == STP_OK)
        check_frame(&frame);
    mem_free(frame.depth);
    mem_free(frame.color);
    fuzz_file_close(depth_file);
    fuzz_file_close(color_file);
    return result;
}

static enum stp_result read_intrinsics(const struct stp_env *env, const struct file_bytes *bytes)
{
    struct range_camera camera = { 0 };
    struct range_units units = { 0 };
    enum stp_result result = range_intrinsics_from_bytes(env, "input", bytes, &camera, &units);
    fuzz_check(result != STP_OK || (camera.fx > 0 && camera.fy > 0 && units.depth_scale > 0 &&
                                    isfinite(camera.cx) && isfinite(camera.cy)),
               "intrinsics are usable");
    return result;
}

static enum stp_result read_poses(const struct stp_env *env, const struct file_bytes *bytes)
{
    double(*pose)[16] = NULL;
    unsigned count = 0;
    enum stp_result result = range_poses_from_bytes(env, "input", bytes, &pose, &count);
    fuzz_check((result == STP_OK) == (count > 0) && !pose == !count, "a failure leaves no poses");
    for (unsigned i = 0; i < count; i++)
        for (int k = 0; k < 16; k++)
            fuzz_check(isfinite(pose[i][k]), "a pose is finite");
    mem_free(pose);
    return result;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_log log;
    if (size == 0)
        return 0;
    const struct file_bytes bytes = { .data = data + 1, .size = size - 1 };
    fuzz_begin(&log);
    enum stp_result result = data[0] == 'd'   ? read_image(&log.env, &bytes, RANGE_DEPTH)
                             : data[0] == 'c' ? read_image(&log.env, &bytes, RANGE_COLOR)
                             : data[0] == 'f' ? read_frame(&log.env, &bytes)
                             : data[0] == 'i' ? read_intrinsics(&log.env, &bytes)
                                              : read_poses(&log.env, &bytes);
    fuzz_end(&log, result);
    return 0;
}
