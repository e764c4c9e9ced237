/* A folder of range images: intrinsics.txt, pose.txt, depth/N.* and color/N.*. */
#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "scene/range.h"

#define PATH_SPARE 64

struct folder {
    const struct stp_env *env;
    const char *path;
    char *name; /* of a file in it */
    size_t size;
};

bool range_is_folder(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 && S_ISDIR(st.st_mode);
}

enum stp_result range_load_intrinsics(const struct stp_env *env, const char *path,
                                      struct range_camera *camera, struct range_units *units)
{
    struct file_bytes bytes;
    enum stp_result result = file_read(env, path, &bytes);
    if (result != STP_OK)
        return result;
    result = range_intrinsics_from_bytes(env, path, &bytes, camera, units);
    file_release(&bytes);
    return result;
}

enum stp_result range_load_poses(const struct stp_env *env, const char *path, double (**poses)[16],
                                 unsigned *count)
{
    struct file_bytes bytes;
    enum stp_result result = file_read(env, path, &bytes);
    if (result != STP_OK)
        return result;
    result = range_poses_from_bytes(env, path, &bytes, poses, count);
    file_release(&bytes);
    return result;
}

static const char *in_folder(struct folder *folder, const char *file)
{
    snprintf(folder->name, folder->size, "%s/%s", folder->path, file);
    return folder->name;
}

static const char *const endings[] = { "png", "pgm", "ppm", "exr" };
#define ENDINGS (sizeof endings / sizeof *endings)

/* KIND/N with the first ending that exists, owned by the caller; NULL: there is none. */
static enum stp_result find_picture(const struct folder *folder, const char *kind, unsigned number,
                                    char **found)
{
    char *name = mem_alloc(folder->size, 1);
    *found = NULL;
    if (!name)
        return log_no_memory(folder->env, folder->size, folder->path);
    for (unsigned i = 0; i < ENDINGS; i++) {
        struct stat st;
        snprintf(name, folder->size, "%s/%s/%u.%s", folder->path, kind, number, endings[i]);
        if (stat(name, &st) == 0) {
            *found = name;
            return STP_OK;
        }
    }
    mem_free(name);
    return STP_OK;
}

static enum stp_result read_frame(const struct folder *folder, unsigned number,
                                  const struct range_units *units, enum stp_transfer transfer,
                                  struct range_frame *frame)
{
    char *depth = NULL, *color = NULL;
    enum stp_result result = find_picture(folder, "depth", number, &depth);
    if (result == STP_OK)
        result = find_picture(folder, "color", number, &color);
    if (result == STP_OK && depth && color)
        result = range_frame_read(folder->env, depth, color, units, transfer, frame);
    else if (result == STP_OK)
        result = log_error(folder->env, STP_ERROR_FORMAT,
                           "%s: pose.txt has a pose %u, but there is no %s/%u.png, .pgm, .ppm or "
                           ".exr",
                           folder->path, number, depth ? "color" : "depth", number);
    mem_free(depth);
    mem_free(color);
    return result;
}

/* The number of a picture's name as find_picture writes it; -1: another file. */
static long picture_number(const char *name)
{
    char *end;
    if (!isdigit((unsigned char)name[0]) || (name[0] == '0' && name[1] != '.') || strlen(name) > 13)
        return -1;
    long number = strtol(name, &end, 10);
    for (unsigned i = 0; i < ENDINGS; i++)
        if (*end == '.' && strcmp(end + 1, endings[i]) == 0)
            return number;
    return -1;
}

/* Depths that no pose is for. */
static void warn_of_surplus(struct folder *folder, unsigned end)
{
    long least = 0;
    unsigned count = 0;
    snprintf(folder->name, folder->size, "%s/depth", folder->path);
    DIR *directory = opendir(folder->name);
    if (!directory)
        return;
    for (const struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        long number = picture_number(entry->d_name);
        if (number < (long)end)
            continue;
        least = count++ == 0 || number < least ? number : least;
    }
    closedir(directory);
    if (count)
        log_warning(folder->env,
                    "%s: pose.txt has no pose for %u picture%s of depth, from depth/%ld on: left "
                    "out",
                    folder->path, count, count == 1 ? "" : "s", least);
}

/* 0 where either picture 0 is there, so that one that is lost does not pass its pose on to the
 * next. */
static enum stp_result find_first(const struct folder *folder, unsigned *first)
{
    char *depth = NULL, *color = NULL;
    enum stp_result result = find_picture(folder, "depth", 0, &depth);
    if (result == STP_OK)
        result = find_picture(folder, "color", 0, &color);
    *first = depth || color ? 0 : 1;
    mem_free(depth);
    mem_free(color);
    return result;
}

static enum stp_result read_frames(struct folder *folder, const struct range_frame *like,
                                   const struct range_units *units, double (*pose)[16],
                                   const struct stp_load_params *params, struct range *range)
{
    unsigned first, count = range->count;
    enum stp_result result = find_first(folder, &first);
    if (result != STP_OK)
        return result;
    range->frame = mem_zalloc(count, sizeof *range->frame);
    if (!range->frame) {
        range->count = 0;
        return log_no_memory(folder->env, count * sizeof *range->frame, folder->path);
    }
    for (unsigned i = 0; i < count && result == STP_OK; i++) {
        range->frame[i] = *like;
        memcpy(range->frame[i].camera.to_world, pose[i], sizeof pose[i]);
        result = read_frame(folder, first + i, units, params->transfer, &range->frame[i]);
        log_progress(folder->env, "load", (double)(i + 1) / count);
    }
    if (result == STP_OK)
        warn_of_surplus(folder, first + count);
    return result;
}

/* Any folder may be given for a scene: what one has to be is said where this one is another. */
static enum stp_result check_kind(struct folder *folder)
{
    if (access(in_folder(folder, "intrinsics.txt"), F_OK) == 0 || errno != ENOENT)
        return STP_OK;
    return log_error(folder->env, STP_ERROR_FORMAT,
                     "%s: a folder is read as range images, and this one has no intrinsics.txt",
                     folder->path);
}

enum stp_result range_from_folder(const struct stp_env *env, const char *path,
                                  const struct stp_load_params *params, struct range *range)
{
    struct folder folder = { .env = env, .path = path, .size = strlen(path) + PATH_SPARE };
    struct range made = { .uncertainty = params->range.uncertainty == 0
                                             ? 1
                                             : fmax(params->range.uncertainty, 0) };
    struct range_frame like = { .sensor = { .sigma = RANGE_KINECT_SIGMA } };
    struct range_units units = { .depth_scale = 1 };
    double(*pose)[16] = NULL;
    folder.name = mem_alloc(folder.size, 1);
    if (!folder.name)
        return log_no_memory(env, folder.size, path);
    enum stp_result result = check_kind(&folder);
    if (result == STP_OK)
        result =
            range_load_intrinsics(env, in_folder(&folder, "intrinsics.txt"), &like.camera, &units);
    if (result == STP_OK)
        result = range_load_poses(env, in_folder(&folder, "pose.txt"), &pose, &made.count);
    if (result == STP_OK)
        result = read_frames(&folder, &like, &units, pose, params, &made);
    mem_free(pose);
    mem_free(folder.name);
    if (result == STP_OK)
        *range = made;
    else if (made.frame)
        range_release(&made);
    return result;
}
