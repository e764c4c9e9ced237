#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "base/log.h"
#include "base/memory.h"

static enum stp_result io_error(const struct stp_env *env, const char *path, const char *verb)
{
    return log_error(env, STP_ERROR_IO, "%s: cannot %s: %s", path, verb, strerror(errno));
}

static enum stp_result map_file(const struct stp_env *env, const char *path, int fd,
                                struct file_bytes *bytes)
{
    struct stat st;
    if (fstat(fd, &st) != 0)
        return io_error(env, path, "stat");
    if (S_ISFIFO(st.st_mode) || S_ISSOCK(st.st_mode) || S_ISCHR(st.st_mode))
        return log_error(env, STP_ERROR_IO,
                         "%s: a pipe, a socket or a device; only files are read: write it to one "
                         "first",
                         path);
    if (!S_ISREG(st.st_mode))
        return log_error(env, STP_ERROR_IO, "%s: not a regular file", path);
    *bytes = (struct file_bytes){ .size = (size_t)st.st_size };
    if (bytes->size == 0)
        return STP_OK;
    void *data = mmap(NULL, bytes->size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        return io_error(env, path, "map");
    bytes->data = data;
    bytes->mapped = true;
    return STP_OK;
}

/* Half of the machine's memory: a gzip bomb stops there, a real scan does not. */
static size_t inflate_bound(void)
{
    long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (size_t)pages / 2 * (size_t)size : (size_t)1 << 32;
}

/* What is being inflated: `used` bytes of `capacity` so far, at most `most`. */
struct inflating {
    const struct stp_env *env;
    const char *path;
    struct file_bytes in;
    struct file_use use;
    unsigned char *data;
    size_t capacity, used, most;
};

static enum stp_result grow(struct inflating *f)
{
    if (f->used < f->capacity)
        return STP_OK;
    size_t wanted = f->capacity < f->most / 2 ? f->capacity * 2 : f->most;
    if (wanted > inflate_bound())
        return log_error(f->env, STP_ERROR_MEMORY, "%s: inflates to more than %zu bytes", f->path,
                         inflate_bound());
    unsigned char *grown = mem_realloc(f->data, wanted, 1);
    if (!grown)
        return log_no_memory(f->env, wanted, f->path);
    f->data = grown;
    f->capacity = wanted;
    return STP_OK;
}

static size_t with_slack(size_t most)
{
    return most < FILE_ALL - FILE_SLACK ? most + FILE_SLACK : FILE_ALL;
}

/* Asks, once there is a head, how much is of use. */
static void ask(struct inflating *f)
{
    if (!f->use.stated || f->used < FILE_HEAD)
        return;
    const struct file_bytes head = { .data = f->data, .size = f->used };
    f->most = with_slack(f->use.stated(&head));
    f->use.stated = NULL;
}

/* All members of a gzip file, one after the other. */
static enum stp_result inflate_members(struct inflating *f, z_stream *z)
{
    size_t consumed = 0;
    int status = Z_OK;
    while (status != Z_STREAM_END && f->used < f->most) {
        enum stp_result result = grow(f);
        if (result != STP_OK)
            return result;
        size_t room = f->capacity - f->used, left = f->in.size - consumed;
        z->next_in = (unsigned char *)f->in.data + consumed;
        z->avail_in = left > 1u << 30 ? 1u << 30 : (unsigned)left;
        z->next_out = f->data + f->used;
        z->avail_out = room > 1u << 30 ? 1u << 30 : (unsigned)room;
        status = inflate(z, Z_NO_FLUSH);
        consumed = (size_t)(z->next_in - f->in.data);
        f->used = (size_t)(z->next_out - f->data);
        if (status == Z_STREAM_END && f->in.size - consumed >= 18 && f->in.data[consumed] == 0x1f &&
            f->in.data[consumed + 1] == 0x8b)
            status = inflateReset(z);
        else if (status != Z_OK && status != Z_STREAM_END)
            return log_error(f->env, STP_ERROR_FORMAT, "%s: damaged gzip data at byte %zu", f->path,
                             consumed);
        ask(f);
    }
    return STP_OK;
}

enum stp_result file_inflate(const struct stp_env *env, const char *path, const unsigned char *data,
                             size_t size, const struct file_use *use, struct file_bytes *bytes)
{
    struct inflating f = { .env = env, .path = path, .in = { .data = data, .size = size } };
    z_stream z = { 0 };
    f.use = *use;
    f.most = with_slack(use->most);
    f.capacity = size * 4 + FILE_HEAD < f.most ? size * 4 + FILE_HEAD : f.most;
    f.data = mem_alloc(f.capacity, 1);
    if (!f.data)
        return log_no_memory(env, f.capacity, path);
    if (inflateInit2(&z, 15 + 32) != Z_OK) { /* zlib's header or gzip's */
        mem_free(f.data);
        return log_no_memory(env, sizeof z, "zlib");
    }
    enum stp_result result = inflate_members(&f, &z);
    inflateEnd(&z);
    if (result == STP_OK)
        *bytes = (struct file_bytes){ .data = f.data, .size = f.used, .inflated = true };
    else
        mem_free(f.data);
    return result;
}

static enum stp_result inflate_file(const struct stp_env *env, const char *path,
                                    const struct file_use *use, struct file_bytes *bytes)
{
    struct file_bytes inflated;
    enum stp_result result = file_inflate(env, path, bytes->data, bytes->size, use, &inflated);
    if (result != STP_OK)
        return result;
    file_release(bytes);
    *bytes = inflated;
    return STP_OK;
}

enum stp_result file_read_for(const struct stp_env *env, const char *path,
                              const struct file_use *use, struct file_bytes *bytes)
{
    struct file_bytes read = { 0 };
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return io_error(env, path, "open");
    enum stp_result result = map_file(env, path, fd, &read);
    close(fd);
    if (result == STP_OK && read.size >= 18 && read.data[0] == 0x1f && read.data[1] == 0x8b)
        result = inflate_file(env, path, use, &read);
    if (result == STP_OK)
        *bytes = read;
    else
        file_release(&read);
    return result;
}

enum stp_result file_read(const struct stp_env *env, const char *path, struct file_bytes *bytes)
{
    const struct file_use all = { .most = FILE_ALL };
    return file_read_for(env, path, &all, bytes);
}

void file_release(struct file_bytes *bytes)
{
    if (bytes->mapped)
        munmap((void *)bytes->data, bytes->size);
    else if (bytes->inflated)
        mem_free((void *)bytes->data);
    *bytes = (struct file_bytes){ 0 };
}
