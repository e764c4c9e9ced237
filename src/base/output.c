/* Files that are written beside their place and renamed. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "base/memory.h"

#define WILD  6   /* characters of a temporary's name that are filled in */
#define TRIES 256 /* names that are taken before it gives up */
#define LINKS 40  /* symbolic links in a row, as many as Linux follows */

static enum stp_result write_error(const struct stp_env *env, const char *path, int error)
{
    return log_error(env, STP_ERROR_IO, "%s: cannot write: %s", path,
                     error ? strerror(error) : "an earlier write failed");
}

/* One of 36^6 names: the process, the thread's stack, the moment and the try decide which. */
static void fill_name(char *wild, unsigned attempt)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789";
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    uint64_t bits = (uint64_t)now.tv_nsec ^ (uint64_t)now.tv_sec << 30 ^ (uint64_t)getpid() << 40 ^
                    (uint64_t)(uintptr_t)&now ^ attempt;
    for (int i = 0; i < WILD; i++) {
        bits = bits * 6364136223846793005u + 1442695040888963407u;
        wild[i] = letters[(bits >> 33) % 36];
    }
}

/* `path` ends in the WILD characters. The file has at most the rights of `mode`, by the process's
 * mask: that belongs to every thread, so it is neither asked nor touched. -1: errno says why. */
static int open_new(char *path, mode_t mode)
{
    char *wild = path + strlen(path) - WILD;
    for (unsigned i = 0; i < TRIES; i++) {
        fill_name(wild, i);
        int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (fd >= 0 || errno != EEXIST)
            return fd;
    }
    return -1;
}

/* Where the name in a path begins. */
static size_t name_at(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash + 1 - path) : 0;
}

/* What `path` names after all symbolic links, whether or not it is there yet. The folder's own
 * links are left to the system. 0, or why not. */
static int follow(const char *path, char target[PATH_MAX])
{
    char link[PATH_MAX];
    if (strlen(path) >= PATH_MAX)
        return ENAMETOOLONG;
    strcpy(target, path);
    for (unsigned i = 0; i <= LINKS; i++) {
        ssize_t length = readlink(target, link, sizeof link);
        if (length < 0) /* no link, or nothing at all: what opens it says what is wrong */
            return 0;
        size_t folder = link[0] == '/' ? 0 : name_at(target);
        if (folder + (size_t)length >= PATH_MAX)
            return ENAMETOOLONG;
        memcpy(target + folder, link, (size_t)length);
        target[folder + (size_t)length] = 0;
    }
    return ELOOP;
}

/* The name beside the target that the writing goes to: the longest names are cut, at a whole
 * character of UTF-8. */
static void name_temporary(const char *target, char *temporary)
{
    size_t name = name_at(target), length = strlen(target + name);
    if (length > NAME_MAX - WILD - 1) {
        length = NAME_MAX - WILD - 1;
        while (length > 0 && ((unsigned char)target[name + length] & 0xc0) == 0x80)
            length--;
    }
    memcpy(temporary, target, name + length);
    strcpy(temporary + name + length, ".XXXXXX");
}

/* Opens the temporary. What is replaced leaves its rights to it: at no moment has it more. */
static enum stp_result open_temporary(const struct stp_env *env, const char *path,
                                      struct file_output *out)
{
    struct stat st;
    bool replaces = stat(out->target, &st) == 0;
    if (replaces && !S_ISREG(st.st_mode))
        return log_error(env, STP_ERROR_IO, "%s: cannot write: it is no regular file", path);
    name_temporary(out->target, out->temporary);
    int fd = open_new(out->temporary, replaces ? st.st_mode & 0666 : 0666);
    if (fd < 0) {
        out->temporary[0] = 0;
        return write_error(env, path, errno);
    }
    if (replaces && fchmod(fd, st.st_mode & 0777) != 0)
        log_warning(env, "%s: its permissions are not kept: %s", path, strerror(errno));
    out->stream = fdopen(fd, "wb");
    if (out->stream)
        return STP_OK;
    enum stp_result result = write_error(env, path, errno);
    close(fd);
    return result;
}

enum stp_result file_begin(const struct stp_env *env, const char *path, struct file_output *out)
{
    struct file_output begun = { 0 };
    char target[PATH_MAX];
    int error = follow(path, target);
    if (error)
        return write_error(env, path, error);
    size_t length = strlen(path) + 1, room = strlen(target) + WILD + 2;
    begun.path = mem_alloc(length, 1);
    begun.target = mem_alloc(room, 1);
    begun.temporary = mem_zalloc(room, 1); /* "": there is nothing to remove yet */
    if (!begun.path || !begun.target || !begun.temporary) {
        file_abandon(&begun);
        return log_no_memory(env, length + 2 * room, path);
    }
    strcpy(begun.path, path);
    strcpy(begun.target, target);
    enum stp_result result = open_temporary(env, path, &begun);
    if (result == STP_OK)
        *out = begun;
    else
        file_abandon(&begun);
    return result;
}

/* On the disk before it takes the old one's place: a crash leaves one of the two whole. A file
 * system that cannot be asked is not. */
static bool sync_file(int fd)
{
    while (fsync(fd) != 0)
        if (errno == EINVAL || errno == ENOTSUP || errno == ENOSYS)
            return true;
        else if (errno != EINTR)
            return false;
    return true;
}

/* 0, or the errno of what failed; *whole says whether anything did. A write that failed earlier has
 * taken its errno along. */
static int finish(struct file_output *out, bool *whole)
{
    bool earlier = ferror(out->stream) != 0;
    bool flushed = fflush(out->stream) == 0;
    int error = flushed ? 0 : errno;
    if (flushed && !earlier && !sync_file(fileno(out->stream))) {
        error = errno;
        flushed = false;
    }
    bool closed = fclose(out->stream) == 0;
    if (!closed && !error)
        error = errno;
    out->stream = NULL;
    *whole = flushed && !earlier && closed;
    return error;
}

enum stp_result file_commit(const struct stp_env *env, struct file_output *out)
{
    bool whole;
    int error = finish(out, &whole);
    if (whole && rename(out->temporary, out->target) == 0) {
        out->temporary[0] = 0;
        file_abandon(out);
        return STP_OK;
    }
    enum stp_result result = write_error(env, out->path, whole ? errno : error);
    file_abandon(out);
    return result;
}

void file_abandon(struct file_output *out)
{
    int error = errno;
    if (out->stream)
        fclose(out->stream);
    if (out->temporary && out->temporary[0])
        unlink(out->temporary);
    mem_free(out->path);
    mem_free(out->target);
    mem_free(out->temporary);
    *out = (struct file_output){ 0 };
    errno = error;
}

enum stp_result stp_text_save(const struct stp_env *env, const char *path, const char *text)
{
    struct file_output out;
    enum stp_result result = file_begin(env, path, &out);
    if (result != STP_OK)
        return result;
    fprintf(out.stream, "%s\n", text);
    return file_commit(env, &out);
}
