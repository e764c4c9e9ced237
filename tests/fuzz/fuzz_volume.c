/* Volumes with headers, and raw ones of 4 x 4 x 4. */
#include "fuzz.h"
#include "load/volume.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct file_bytes bytes = { .data = data, .size = size };
    const struct raw_volume raw = {
        .known = true,
        .voxels = { .dims = { 4, 4, 4 }, .spacing = { 1, 1, 1 }, .type = RECORD_UINT8 }
    };
    struct grid grid = { 0 };
    struct fuzz_log log;
    fuzz_begin(&log);
    enum stp_result result = volume_from_bytes(&log.env, "input", &bytes, &raw, NULL, &grid);
    fuzz_end(&log, result);
    if (result != STP_OK)
        fuzz_check(!grid.value, "a failure leaves the grid alone");
    else
        fuzz_check(grid_count(&grid) > 0 && grid.low <= grid.high, "a grid has voxels");
    grid_release(&grid);
    return 0;
}
