#include "fuzz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

void fuzz_check(bool holds, const char *what)
{
    if (holds)
        return;
    fprintf(stderr, "broken promise: %s\n", what);
    abort();
}

static void note(void *user, enum stp_log_level level, const char *line)
{
    struct fuzz_log *log = user;
    log->errors += level == STP_LOG_ERROR;
    fuzz_check(strchr(line, '\n') == NULL, "a log line is one line");
    fuzz_check(*line, "a log line says something");
}

void fuzz_begin(struct fuzz_log *log)
{
    *log = (struct fuzz_log){ .env = { .threads = 1, .log = note, .user = log } };
}

void fuzz_end(const struct fuzz_log *log, enum stp_result result)
{
    fuzz_check(log->errors == (result != STP_OK), "one line for a failure, none for a success");
}

int fuzz_file_open(const uint8_t *data, size_t size, char path[32])
{
    int file = memfd_create("fuzz", MFD_CLOEXEC);
    fuzz_check(file >= 0, "a file in memory");
    for (size_t done = 0; done < size;) {
        ssize_t wrote = write(file, data + done, size - done);
        fuzz_check(wrote > 0, "the file in memory takes the input");
        done += (size_t)wrote;
    }
    snprintf(path, 32, "/proc/self/fd/%d", file);
    return file;
}

void fuzz_file_close(int file)
{
    close(file);
}

/* Reads every byte that the cloud says it has. */
static void touch(const void *array, size_t size)
{
    const volatile unsigned char *bytes = array;
    for (size_t i = 0; array && i < size; i += 4)
        (void)bytes[i];
}

static void check_cloud(const struct cloud *cloud, size_t size)
{
    /* The tightest packing is LZF's: three bytes unpack to at most 264, of two numbers a point. */
    fuzz_check(cloud->count <= size * 88, "no more points than the bytes can hold");
    fuzz_check(memchr(cloud->format, 0, sizeof cloud->format) != NULL, "the format's name ends");
    fuzz_check(!cloud->count || cloud->position, "points have positions");
    touch(cloud->position, cloud->count * sizeof *cloud->position);
    touch(cloud->normal, cloud->count * sizeof *cloud->normal);
    touch(cloud->color, cloud->count * sizeof *cloud->color);
    touch(cloud->opacity, cloud->count * sizeof *cloud->opacity);
    touch(cloud->radius, cloud->count * sizeof *cloud->radius);
    for (unsigned i = 0; i < cloud->field_count; i++)
        touch(cloud->fields[i].value, cloud->count * sizeof(float));
}

static void read_once(reader_fn read, const struct file_bytes *bytes,
                      const struct load_options *options)
{
    struct fuzz_log log;
    struct cloud cloud, before;
    memset(&cloud, 0xa5, sizeof cloud);
    memcpy(&before, &cloud, sizeof cloud);
    fuzz_begin(&log);
    enum stp_result result = read(&log.env, "input", bytes, options, &cloud);
    fuzz_end(&log, result);
    if (result == STP_OK) {
        check_cloud(&cloud, bytes->size);
        cloud_release(&cloud);
    } else {
        fuzz_check(memcmp(&cloud, &before, sizeof cloud) == 0, "a failure leaves the cloud alone");
    }
}

void fuzz_reader(bool (*probe)(const struct file_bytes *bytes), reader_fn read, const uint8_t *data,
                 size_t size)
{
    static const char *const names[] = { "intensity", "class", "x", "height", "normal", "nothing" };
    const struct file_bytes bytes = { .data = data, .size = size };
    if (!probe(&bytes))
        return;
    /* The input's length chooses the options: any file is a seed as it stands. */
    struct load_options options = { .transfer = (enum stp_transfer)(size % 3) };
    if (size % 2)
        options.color_by = names[size / 2 % (sizeof names / sizeof *names)];
    read_once(read, &bytes, &options);
}
