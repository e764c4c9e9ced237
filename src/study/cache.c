/* Where calibrations are kept: $XDG_CACHE_HOME/stipple, or ~/.cache/stipple. */
#include "study/calibrate.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/log.h"
#include "base/memory.h"
#include "plan/profile.h"

#define HASH_START 0xcbf29ce484222325u

/* FNV-1a, of a string with its end. */
static uint64_t hash(uint64_t h, const char *text)
{
    do
        h = (h ^ (unsigned char)*text) * 0x100000001b3u;
    while (*text++);
    return h;
}

/* What the prices are for: of another device, or without those of a new kind, they are of no use.
 */
static uint64_t key_of(const struct stp_limits *limits)
{
    uint64_t h = hash(hash(HASH_START, limits->device), limits->driver);
    h = hash(h, stp_version());
    for (unsigned kind = 0; kind < PLAN_COSTS; kind++)
        h = hash(h, plan_cost_name((enum plan_cost)kind));
    return h;
}

enum stp_result calibrate_cache_path(const struct stp_env *env, const struct stp_limits *limits,
                                     char **path)
{
    /* The standard says that a relative path is to be ignored. */
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    bool own = cache && cache[0] == '/';
    const char *base = own ? cache : home, *middle = own ? "" : "/.cache";
    if (!base || base[0] != '/')
        return STP_OK;
    size_t size = strlen(base) + 64;
    char *made = mem_alloc(size, 1);
    if (!made)
        return log_no_memory(env, size, "the cache's name");
    snprintf(made, size, "%s%s/stipple/calibration-%016llx.json", base, middle,
             (unsigned long long)key_of(limits));
    *path = made;
    return STP_OK;
}

/* Of the reader's own lines one is kept, for the warning. */
static void keep_line(void *user, enum stp_log_level, const char *line)
{
    char *kept = user;
    if (!kept[0])
        snprintf(kept, 512, "%s", line);
}

static bool text_is(const cJSON *root, const char *key, const char *value)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(root, key);
    return cJSON_IsString(item) && strcmp(item->valuestring, value) == 0;
}

static bool of_device(const cJSON *root, const struct stp_limits *limits)
{
    return text_is(root, "version", stp_version()) && text_is(root, "device", limits->device) &&
           text_is(root, "driver", limits->driver);
}

enum stp_result calibrate_cache_read(const struct stp_env *env, const char *path,
                                     const struct stp_limits *limits,
                                     struct stp_calibration *calibration, bool *found)
{
    char line[512] = "";
    const struct stp_env kept = { .log = keep_line, .user = line };
    struct stp_calibration read = { 0 };
    cJSON *root = NULL;
    struct stat st;
    *found = false;
    if (stat(path, &st) != 0)
        return STP_OK;
    enum stp_result result = json_read(&kept, path, &root);
    if (result == STP_OK) {
        struct json_at at = json_root(&kept, path);
        result = calibration_from_json(&at, root, &read);
    }
    bool right = result == STP_OK && read.measured && of_device(root, limits);
    cJSON_Delete(root);
    if (result == STP_ERROR_MEMORY)
        return log_error(env, result, "%s", line);
    if (right)
        *calibration = read;
    else
        log_warning(env, "%s; the device's calibration is not used",
                    line[0] ? line : "the cached profile is damaged, or of another device");
    *found = right;
    return STP_OK;
}

static bool make_folders(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        bool there = mkdir(path, 0777) == 0 || errno == EEXIST;
        *slash = '/';
        if (!there)
            return false;
    }
    return true;
}

/* The profile with the version in front. Numbers keep their bits: nothing is parsed and printed. */
static void write_profile(FILE *out, const char *profile)
{
    fprintf(out, "{\n\t\"version\":\t\"%s\",%s\n", stp_version(), profile + 1);
}

void calibrate_cache_write(const struct stp_env *env, const char *path,
                           const struct stp_limits *limits)
{
    char line[512] = "", *folders = strdup(path), *text = stp_limits_print(limits);
    const struct stp_env kept = { .log = keep_line, .user = line };
    struct file_output out = { 0 };
    enum stp_result result = folders && text ? STP_OK : STP_ERROR_MEMORY;
    if (result == STP_OK && !make_folders(folders))
        result = log_error(&kept, STP_ERROR_IO, "%s: %s", folders, strerror(errno));
    if (result == STP_OK)
        result = file_begin(&kept, path, &out);
    if (result == STP_OK) {
        write_profile(out.stream, text);
        result = file_commit(&kept, &out);
    }
    if (result != STP_OK)
        log_warning(env, "the calibration could not be kept: %s",
                    line[0] ? line : stp_result_text(result));
    free(folders);
    free(text);
}
