#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_reader(obj_probe, obj_read, data, size);
    return 0;
}
