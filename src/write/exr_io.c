#include "write/exr_io.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"

static void *allocate(size_t bytes)
{
    return mem_alloc(bytes, 1);
}

/* The core calls this with its lock held, so that not even the user data can be asked for. */
static void drop_message(exr_const_context_t, exr_result_t, const char *)
{
}

static int64_t size_of(exr_const_context_t, void *user)
{
    const struct exr_io *io = user;
    return io->bytes ? (int64_t)io->bytes->size : -1;
}

static int64_t read_at(exr_const_context_t, void *user, void *buffer, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t)
{
    const struct exr_io *io = user;
    if (offset >= io->bytes->size)
        return 0;
    uint64_t left = io->bytes->size - offset;
    if (size > left)
        size = left;
    memcpy(buffer, io->bytes->data + offset, size);
    return (int64_t)size;
}

static int64_t write_at(exr_const_context_t, void *user, const void *buffer, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t)
{
    struct exr_io *io = user;
    uint64_t done = 0;
    while (done < size) {
        ssize_t written = pwrite(io->descriptor, (const char *)buffer + done, size - done,
                                 (off_t)(offset + done));
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0) {
            if (!io->error)
                io->error = written < 0 ? errno : ENOSPC;
            return -1;
        }
        done += (uint64_t)written;
    }
    return (int64_t)size;
}

exr_context_initializer_t exr_io_initializer(struct exr_io *io)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = drop_message;
    /* Reading, the core takes an allocation that fails for a damaged header, so that counting
     * them would show nothing: it keeps to malloc. */
    init.alloc_fn = io->bytes ? NULL : allocate;
    init.free_fn = io->bytes ? NULL : mem_free;
    init.user_data = io;
    init.size_fn = size_of;
    init.read_fn = io->bytes ? read_at : NULL;
    init.write_fn = io->bytes ? NULL : write_at;
    return init;
}

enum stp_result exr_io_failed(const struct stp_env *env, const struct exr_io *io, exr_result_t code,
                              const char *verb)
{
    if (io->error)
        return log_error(env, STP_ERROR_IO, "%s: cannot %s: %s", io->path, verb,
                         strerror(io->error));
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return log_error(env, STP_ERROR_MEMORY, "%s: cannot %s: out of memory", io->path, verb);
    return log_error(env, io->bytes ? STP_ERROR_FORMAT : STP_ERROR_IO, "%s: cannot %s: %s",
                     io->path, verb, exr_get_default_error_message(code));
}
