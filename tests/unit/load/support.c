#include "support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

void put_bytes(struct buffer *buffer, const void *data, size_t size)
{
    if (buffer->size + size > buffer->capacity) {
        buffer->capacity = (buffer->size + size) * 2;
        buffer->data = realloc(buffer->data, buffer->capacity);
        assert_non_null(buffer->data);
    }
    if (size)
        memcpy(buffer->data + buffer->size, data, size);
    buffer->size += size;
}

void put_text(struct buffer *buffer, const char *format, ...)
{
    char text[4096];
    va_list args;
    va_start(args, format);
    int length = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    assert_in_range(length, 0, sizeof text - 1);
    put_bytes(buffer, text, (size_t)length);
}

void put_reversed(struct buffer *buffer, const void *data, size_t size)
{
    const unsigned char *bytes = data;
    for (size_t i = size; i-- > 0;)
        put_bytes(buffer, bytes + i, 1);
}

void drop(struct buffer *buffer)
{
    free(buffer->data);
    *buffer = (struct buffer){ 0 };
}

static void note(void *user, enum stp_log_level level, const char *line)
{
    struct lines *lines = user;
    if (level == STP_LOG_ERROR) {
        lines->errors++;
        snprintf(lines->error, sizeof lines->error, "%s", line);
    } else if (level == STP_LOG_WARNING) {
        lines->warnings++;
        snprintf(lines->warning, sizeof lines->warning, "%s", line);
    }
}

enum stp_result read_buffer(const struct buffer *buffer, const struct load_options *options,
                            unsigned threads, struct cloud *cloud, struct lines *lines)
{
    unsigned char *copy = malloc(buffer->size ? buffer->size : 1);
    assert_non_null(copy);
    if (buffer->size)
        memcpy(copy, buffer->data, buffer->size);
    struct file_bytes bytes = { .data = copy, .size = buffer->size };
    *lines = (struct lines){ 0 };
    struct stp_env env = { .threads = threads, .log = note, .user = lines };
    memset(cloud, 0xa5, sizeof *cloud);
    struct cloud before;
    memcpy(&before, cloud, sizeof before);
    enum stp_result result = load_from_bytes(&env, "in", &bytes, options, cloud);
    free(copy);
    if (result != STP_OK) {
        assert_memory_equal(cloud, &before, sizeof before);
        assert_int_equal(lines->errors, 1);
        if (result != STP_ERROR_MEMORY)
            assert_ptr_equal(strstr(lines->error, "in: "), lines->error);
        assert_null(strchr(lines->error, '\n'));
        *cloud = (struct cloud){ 0 };
    } else {
        assert_int_equal(lines->errors, 0);
    }
    return result;
}

enum stp_result read_file(const struct stp_env *env, const char *path, struct cloud *cloud)
{
    struct file_bytes bytes;
    enum stp_result result = file_read(env, path, &bytes);
    if (result != STP_OK)
        return result;
    result = load_from_bytes(env, path, &bytes, NULL, cloud);
    file_release(&bytes);
    return result;
}

struct cloud read_text(const char *text)
{
    struct buffer buffer = { 0 };
    struct lines lines;
    struct cloud cloud;
    put_bytes(&buffer, text, strlen(text));
    enum stp_result result = read_buffer(&buffer, NULL, 1, &cloud, &lines);
    drop(&buffer);
    if (result != STP_OK)
        print_error("%s\n", lines.error);
    assert_int_equal(result, STP_OK);
    return cloud;
}

void refuse_buffer(const struct buffer *buffer, enum stp_result expected, const char *words)
{
    struct lines lines;
    struct cloud cloud;
    enum stp_result result = read_buffer(buffer, NULL, 2, &cloud, &lines);
    if (result != expected || !strstr(lines.error, words))
        print_error("got %d \"%s\", expected %d \"%s\"\n", result, lines.error, expected, words);
    cloud_release(&cloud);
    assert_int_equal(result, expected);
    assert_non_null(strstr(lines.error, words));
}

void refuse_text(const char *text, enum stp_result expected, const char *words)
{
    struct buffer buffer = { 0 };
    put_bytes(&buffer, text, strlen(text));
    refuse_buffer(&buffer, expected, words);
    drop(&buffer);
}

uint64_t next_random(uint64_t *state)
{
    uint64_t x = *state;
    x ^= x << 13;
    x ^= x >> 7;
    x ^= x << 17;
    return *state = x;
}

static bool same_array(const void *a, const void *b, size_t size)
{
    return (!a && !b) || (a && b && memcmp(a, b, size) == 0);
}

bool same_cloud(const struct cloud *a, const struct cloud *b)
{
    size_t n = a->count;
    if (n != b->count || a->field_count != b->field_count || strcmp(a->format, b->format) != 0)
        return false;
    for (unsigned i = 0; i < a->field_count; i++)
        if (strcmp(a->fields[i].name, b->fields[i].name) != 0 ||
            !same_array(a->fields[i].value, b->fields[i].value, n * sizeof(float)))
            return false;
    return same_array(a->position, b->position, n * sizeof *a->position) &&
           same_array(a->normal, b->normal, n * sizeof *a->normal) &&
           same_array(a->radius, b->radius, n * sizeof *a->radius) &&
           same_array(a->color, b->color, n * sizeof *a->color) &&
           same_array(a->opacity, b->opacity, n * sizeof *a->opacity);
}

void fail_each_allocation(const struct buffer *b, const char *color_by)
{
    struct load_options options = { .color_by = color_by };
    struct lines lines;
    struct cloud whole, cloud;
    unsigned refused = 0;
    mem_fail_at(0);
    assert_int_equal(read_buffer(b, &options, 1, &whole, &lines), STP_OK);
    unsigned long allocations = mem_count();
    for (unsigned long n = 1; n <= allocations; n++) {
        mem_fail_at(n);
        enum stp_result result = read_buffer(b, &options, 1, &cloud, &lines);
        mem_fail_at(0);
        if (result == STP_OK)
            assert_true(same_cloud(&cloud, &whole)); /* it coped without */
        else
            assert_int_equal(result, STP_ERROR_MEMORY);
        refused += result != STP_OK;
        cloud_release(&cloud);
    }
    assert_in_range(refused, 1, allocations);
    cloud_release(&whole);
}
