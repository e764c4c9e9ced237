/* Transfer functions. */
#include <math.h>

#include "fuzz.h"
#include "scene/volume.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[32];
    struct fuzz_log log;
    struct transfer_function function = { 0 };
    int file = fuzz_file_open(data, size, path);
    fuzz_begin(&log);
    enum stp_result result = transfer_load(&log.env, path, &function);
    fuzz_end(&log, result);
    if (result != STP_OK)
        fuzz_check(function.count == 0, "a failure leaves the function alone");
    for (unsigned i = 0; i < function.count; i++) {
        struct transfer_point at = transfer_at(&function, function.point[i].value);
        fuzz_check(at.opacity >= 0 && at.opacity <= 1 && isfinite(at.color[0]), "opacity");
    }
    fuzz_file_close(file);
    return 0;
}
