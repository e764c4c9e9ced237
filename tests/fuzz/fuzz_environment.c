#include "fuzz.h"

#include <math.h>

#include "load/environment.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_log log;
    struct environment_map map = { 0 };
    char path[32];
    int file = fuzz_file_open(data, size, path);
    fuzz_begin(&log);
    enum stp_result result = environment_read(&log.env, path, &map);
    fuzz_end(&log, result);
    fuzz_check((result == STP_OK) == (map.texel != NULL), "a map, or a failure");
    for (size_t i = 0; i < (size_t)map.width * map.height; i++)
        for (int k = 0; k < 3; k++)
            fuzz_check(map.texel[i][k] >= 0 && map.texel[i][k] <= ENVIRONMENT_MOST_VALUE,
                       "texels are light");
    environment_map_release(&map);
    fuzz_file_close(file);
    return 0;
}
