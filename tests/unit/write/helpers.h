/* What the tests of write/ share: a scratch folder, pictures. */
#ifndef TEST_WRITE_HELPERS_H
#define TEST_WRITE_HELPERS_H

#include <dirent.h>
#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <stipple/image.h>

#include "../log_book.h"

static inline void make_scratch(char folder[64])
{
    strcpy(folder, "/tmp/stipple-test-XXXXXX");
    assert_non_null(mkdtemp(folder));
}

static inline char *in_scratch(const char *folder, const char *name, char path[PATH_MAX])
{
    snprintf(path, PATH_MAX, "%s/%s", folder, name);
    return path;
}

static inline unsigned files_in(const char *folder)
{
    unsigned count = 0;
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));)
        count += entry->d_name[0] != '.';
    closedir(dir);
    return count;
}

static inline void remove_scratch(const char *folder)
{
    char path[PATH_MAX];
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));)
        if (entry->d_name[0] != '.')
            unlink(in_scratch(folder, entry->d_name, path));
    closedir(dir);
    assert_int_equal(rmdir(folder), 0);
}

/* Of a group of tests: its folder is the state. */
static inline int enter_scratch(void **state)
{
    static char folder[64];
    make_scratch(folder);
    *state = folder;
    return 0;
}

static inline int leave_scratch(void **state)
{
    remove_scratch(*state);
    return 0;
}

/* The whole file; free() it. */
static inline unsigned char *slurp(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    unsigned char *data = malloc(*size + 1);
    assert_int_equal(fread(data, 1, *size, file), *size);
    data[*size] = 0;
    fclose(file);
    return data;
}

static inline void spill(const char *path, const void *data, size_t size)
{
    unlink(path); /* some file systems flush what is truncated */
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* Runs a command line in `folder`; its stdout and stderr come back (free() them), and it must
 * succeed: a tool that is missing fails the test. */
static inline char *run_tool(const char *folder, const char *command)
{
    char line[2 * PATH_MAX], out[PATH_MAX];
    snprintf(line, sizeof line, "cd %s && (%s) >tool.txt 2>&1 </dev/null", folder, command);
    int status = system(line);
    size_t size;
    char *text = (char *)slurp(in_scratch(folder, "tool.txt", out), &size);
    unlink(out);
    if (status != 0)
        fail_msg("%s: %s", command, text);
    return text;
}

/* The next line that holds `wanted`, from there; NULL: none. Cuts the text into lines on its way:
 * what searches or scans a string looks for its end first. */
static inline char *find_line(char **text, const char *wanted)
{
    for (char *line; (line = strsep(text, "\n"));) {
        char *found = strstr(line, wanted);
        if (found)
            return found;
    }
    return NULL;
}

static inline uint32_t next_random(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

static inline struct stp_channel *add_plane(struct stp_image *image, const char *name,
                                            enum stp_channel_type type)
{
    struct stp_channel *channel = NULL;
    assert_int_equal(stp_image_add(NULL, image, name, type, &channel), STP_OK);
    return channel;
}

#endif
