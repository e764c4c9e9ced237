#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_reader(pcd_probe, pcd_read, data, size);
    return 0;
}
