#include "fuzz.h"

#include <stipple/image.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_log log;
    struct stp_image *image = NULL;
    char path[32];
    int file = fuzz_file_open(data, size, path);
    fuzz_begin(&log);
    enum stp_result result = stp_image_read_exr(&log.env, path, &image);
    fuzz_end(&log, result);
    fuzz_check((result == STP_OK) == (image != NULL), "an image, or a failure");
    for (unsigned i = 0; image && i < image->channel_count; i++) {
        const volatile uint32_t *values = image->channels[i].data.u;
        for (size_t p = 0; p < (size_t)image->width * image->height; p++)
            (void)values[p];
    }
    stp_image_destroy(&image);
    fuzz_file_close(file);
    return 0;
}
