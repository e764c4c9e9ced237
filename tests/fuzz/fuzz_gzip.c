#include "base/file.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_log log;
    struct file_bytes bytes = { 0 };
    char path[32];
    int file = fuzz_file_open(data, size, path);
    fuzz_begin(&log);
    enum stp_result result = file_read(&log.env, path, &bytes);
    fuzz_end(&log, result);
    if (result != STP_OK)
        fuzz_check(!bytes.data && !bytes.size, "a failure leaves the bytes alone");
    else if (bytes.inflated)
        fuzz_check(bytes.size <= size * 1040, "no more bytes than deflate can pack");
    else
        fuzz_check(bytes.size == size, "a file that is not packed is as it was");
    file_release(&bytes);
    fuzz_file_close(file);
    return 0;
}
