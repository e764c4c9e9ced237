#include "fuzz.h"

/* As the table of readers asks it: last, and not about what is known to be something else. */
static bool probe(const struct file_bytes *bytes)
{
    struct known_format known;
    return xyz_probe(bytes) && !known_format_find(bytes, &known);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_reader(probe, xyz_read, data, size);
    return 0;
}
