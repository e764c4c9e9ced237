/* stp_scene_load: a point file, or a scene .json of several. */
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"
#include "load/readers.h"
#include "scene/camera_json.h"
#include "scene/environment.h"
#include "scene/phong.h"
#include "scene/range.h"
#include "scene/scene_json.h"

/* True when the first byte that is no space is '{' (gzip or not); no point format starts so.
 * Reads a few bytes only. What cannot be opened is left to the reader's message. */
static bool looks_like_json(const char *path)
{
    struct stat st;
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return false;
    gzFile file = fstat(fd, &st) == 0 && S_ISREG(st.st_mode) ? gzdopen(fd, "rb") : NULL;
    if (!file) {
        close(fd);
        return false;
    }
    int c, skipped = 0;
    do
        c = gzgetc(file);
    while (
        (c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == 0xef || c == 0xbb || c == 0xbf) &&
        skipped++ < 4096);
    gzclose(file);
    return c == '{';
}

static void transform_cloud(struct cloud *cloud, const double m[16], double scale)
{
    for (size_t i = 0; i < cloud->count; i++) {
        struct vec3 p = m4_point(m, v3_load(cloud->position[i]));
        v3_store(p, cloud->position[i]);
        if (cloud->radius)
            cloud->radius[i] = (float)(cloud->radius[i] * scale);
        if (!cloud->normal)
            continue;
        struct vec3 n = v3_scale(m4_direction(m, v3_loadf(cloud->normal[i])), 1 / scale);
        v3_storef(n, cloud->normal[i]);
        if (cloud->phong)
            phong_transform(&cloud->phong[i], m, scale);
    }
    for (unsigned i = 0; i < cloud->object_count; i++)
        cloud->objects[i].epsilon *= scale;
}

/* What the bytes are: a volume where a header says so, where the caller gives dims, or where no
 * reader of points takes them and a description stands beside the file. */
static enum stp_result find_volume(const struct stp_env *env, const char *path,
                                   const struct file_bytes *bytes,
                                   const struct stp_volume_params *params, struct raw_volume *raw,
                                   bool *is_volume)
{
    enum stp_result result = STP_OK;
    *is_volume = volume_reader_find(bytes) != NULL;
    if (!*is_volume && (params->dims[0] || !load_recognises(bytes)))
        result = raw_volume_find(env, path, params, raw);
    *is_volume = *is_volume || raw->known;
    return result;
}

static enum stp_result add_volume(const struct stp_env *env, struct stp_scene *scene,
                                  const char *path, const struct file_bytes *bytes,
                                  const struct raw_volume *raw,
                                  const struct stp_load_params *params)
{
    struct grid grid = { 0 };
    enum stp_result result = volume_from_bytes(env, path, bytes, raw, &params->volume, &grid);
    if (result != STP_OK)
        return result;
    if (params->up != STP_UP_AUTO)
        grid.up = params->up;
    result = scene_add_volume(env, scene, &grid, &params->volume, params->material);
    grid_release(&grid);
    return result;
}

/* A file's points into the scene. entry NULL: no transform. */
/* What prepare makes colours of; the rest is the reader's. */
static enum color_source color_source(const char *color_by)
{
    if (color_by && strcmp(color_by, "height") == 0)
        return COLOR_BY_HEIGHT;
    if (color_by && strcmp(color_by, "normal") == 0)
        return COLOR_BY_NORMAL;
    return COLOR_OF_CLOUD;
}

static struct load_options options_of(const struct stp_load_params *params)
{
    return (struct load_options){ .transfer = params->transfer, .color_by = params->color_by };
}

static struct stp_object_params object_of(const struct stp_load_params *params)
{
    return (struct stp_object_params){ .material = params->material,
                                       .epsilon = params->epsilon,
                                       .opacity = params->opacity,
                                       .optics = params->optics };
}

/* What the file says of the object stands where the caller says nothing. */
static enum stp_result add_object(const struct stp_env *env, struct stp_scene *scene,
                                  const struct stp_load_params *params,
                                  const struct cloud_object *said, struct cloud *cloud)
{
    struct stp_object_params object = object_of(params);
    bool estimated = said && said->estimated;
    if (said && object.epsilon == 0)
        object.epsilon = said->epsilon;
    enum stp_result result = scene_add_cloud(env, scene, cloud, &object);
    if (result != STP_OK)
        return result;
    scene->objects[scene->object_count - 1].estimated = estimated;
    scene->objects[scene->object_count - 1].color_source = color_source(params->color_by);
    return STP_OK;
}

/* The objects of a file: most hold one, and say nothing of it. */
static enum stp_result add_objects(const struct stp_env *env, struct stp_scene *scene,
                                   const struct stp_load_params *params, struct cloud *cloud)
{
    struct cloud *parts;
    if (!cloud->object)
        return add_object(env, scene, params, cloud->objects, cloud);
    unsigned count = cloud->object_count;
    enum stp_result result = cloud_split(env, cloud, &parts);
    if (result != STP_OK)
        return result;
    cloud_release(cloud);
    for (unsigned i = 0; i < count && result == STP_OK; i++)
        result = add_object(env, scene, params, parts[i].objects, &parts[i]);
    for (unsigned i = 0; i < count; i++)
        cloud_release(&parts[i]);
    mem_free(parts);
    return result;
}

static enum stp_result add_points(const struct stp_env *env, struct stp_scene *scene,
                                  const char *path, const struct file_bytes *bytes,
                                  const struct stp_load_params *params,
                                  const struct scene_entry *entry)
{
    const struct load_options options = options_of(params);
    struct cloud cloud = { 0 };
    enum stp_result result = load_from_bytes(env, path, bytes, &options, &cloud);
    if (result != STP_OK)
        return result;
    if (entry && entry->transformed)
        transform_cloud(&cloud, entry->transform, entry->scale);
    if (params->up != STP_UP_AUTO)
        cloud.up = params->up;
    result = cloud_give_radius(env, params->radius, &cloud);
    if (result == STP_OK)
        result = add_objects(env, scene, params, &cloud);
    cloud_release(&cloud);
    return result;
}

/* The object of a cloud that stays in its file. */
static enum stp_result add_stream(const struct stp_env *env, struct stp_scene *scene,
                                  const struct stp_load_params *params, struct ply_stream *file)
{
    struct cloud none = { .up = params->up ? params->up : STP_UP_Y };
    struct scene_stream *stream = mem_zalloc(1, sizeof *stream);
    if (!stream)
        return log_no_memory(env, sizeof *stream, file->path);
    memcpy(none.format, file->format, sizeof none.format);
    enum stp_result result = add_object(env, scene, params, &file->object, &none);
    if (result != STP_OK) {
        mem_free(stream);
        return result;
    }
    *stream = (struct scene_stream){ .file = *file,
                                     .radius = params->radius,
                                     .chunk_points = params->stream_chunk };
    *file = (struct ply_stream){ 0 };
    scene->stream = stream;
    scene->facts.points = stream->file.count;
    return STP_OK;
}

/* *added: the cloud can stay in its file, is large enough, and *bytes is the scene's. */
static enum stp_result try_stream(const struct stp_env *env, struct stp_scene *scene,
                                  const char *path, struct file_bytes *bytes,
                                  const struct stp_load_params *params, bool *added)
{
    const struct load_options options = options_of(params);
    struct ply_stream file = { 0 };
    const char *why;
    enum stp_result result =
        ply_stream_open(env, path, bytes, &options, params->radius > 0, &file, &why);
    if (result == STP_OK && why && bytes->size / 12 > params->stream_above)
        log_warning(env, "%s: read whole: %s", path, why);
    *added = result == STP_OK && file.count > params->stream_above;
    if (*added) {
        result = add_stream(env, scene, params, &file);
    } else if (file.count) {
        *bytes = file.bytes;
        file.bytes = (struct file_bytes){ 0 };
    }
    ply_stream_close(&file);
    return result;
}

/* One point file, or a volume, into the scene. */
static enum stp_result add_file(const struct stp_env *env, struct stp_scene *scene,
                                const char *path, const struct stp_load_params *params,
                                const struct scene_entry *entry)
{
    struct file_bytes bytes;
    struct raw_volume raw = { 0 };
    const struct file_use use = { .most = FILE_ALL, .stated = volume_stated };
    bool is_volume, streams = false;
    log_progress(env, "load", 0);
    enum stp_result result = file_read_for(env, path, &use, &bytes);
    if (result != STP_OK)
        return result;
    result = find_volume(env, path, &bytes, &params->volume, &raw, &is_volume);
    if (result == STP_OK && params->stream_above && !entry && !is_volume)
        result = try_stream(env, scene, path, &bytes, params, &streams);
    if (result == STP_OK && !streams)
        result = is_volume ? add_volume(env, scene, path, &bytes, &raw, params)
                           : add_points(env, scene, path, &bytes, params, entry);
    file_release(&bytes);
    if (result == STP_OK)
        log_progress(env, "load", 1);
    return result;
}

static enum stp_result add_entries(const struct json_at *root, const cJSON *json,
                                   const struct stp_load_params *params, int entries,
                                   struct stp_scene *scene)
{
    enum stp_result result = STP_OK;
    for (int i = 0; i < entries && result == STP_OK; i++) {
        struct scene_entry entry;
        result = scene_json_entry(root, json, i, params, &entry);
        if (result == STP_OK)
            result = add_file(root->env, scene, entry.file, &entry.params, &entry);
        mem_free(entry.file);
    }
    return result;
}

static enum stp_result add_json_volume(const struct json_at *root, const cJSON *json,
                                       const struct stp_load_params *params,
                                       struct stp_scene *scene)
{
    struct volume_entry entry;
    if (!json_has(json, "volume"))
        return STP_OK;
    enum stp_result result = volume_json_entry(root, json, params, &entry);
    if (result == STP_OK)
        result = add_file(root->env, scene, entry.file, &entry.params, NULL);
    if (result == STP_OK && !scene->volume)
        result = json_error(root, "volume", "the file holds points, no volume");
    if (result == STP_OK && entry.has_function) {
        scene->volume->transfer = entry.function;
        scene->volume->automatic = false;
    }
    volume_entry_release(&entry);
    return result;
}

static enum stp_result add_json_range(const struct json_at *root, const cJSON *json,
                                      const struct stp_load_params *params, struct stp_scene *scene)
{
    struct range range;
    enum stp_range_splats splats;
    if (!json_has(json, "range"))
        return STP_OK;
    enum stp_result result = range_from_json(root, json, params, &range, &splats);
    if (result != STP_OK)
        return result;
    result = range_show(root->env, scene, &range, splats, params);
    range_release(&range);
    return result;
}

static enum stp_result add_folder(const struct stp_env *env, struct stp_scene *scene,
                                  const char *path, const struct stp_load_params *params)
{
    struct range range;
    enum stp_result result = range_from_folder(env, path, params, &range);
    if (result != STP_OK)
        return result;
    result = range_show(env, scene, &range, params->range.splats, params);
    range_release(&range);
    return result;
}

/* Lights and camera first: their mistakes show before minutes of loading. */
static enum stp_result load_json(const struct stp_env *env, const char *path,
                                 const struct stp_load_params *params, struct stp_scene *scene)
{
    cJSON *json = NULL;
    enum stp_up up;
    int entries;
    enum stp_result result = json_read(env, path, &json);
    if (result != STP_OK)
        return result;
    struct json_at root = json_root(env, path);
    result = scene_json_begin(&root, json, &up, &entries);
    if (result == STP_OK)
        result = scene_json_lights(&root, json, scene);
    if (result == STP_OK)
        result = scene_json_camera(&root, json, scene);
    if (result == STP_OK)
        result = environment_from_json(&root, json, &scene->environment);
    if (result == STP_OK) {
        struct stp_load_params resolved = *params;
        if (resolved.up == STP_UP_AUTO)
            resolved.up = up;
        result = add_entries(&root, json, &resolved, entries, scene);
        if (result == STP_OK)
            result = add_json_volume(&root, json, &resolved, scene);
        if (result == STP_OK)
            result = add_json_range(&root, json, &resolved, scene);
    }
    cJSON_Delete(json);
    return result;
}

enum stp_result stp_scene_load(const struct stp_env *env, const char *path,
                               const struct stp_load_params *params, struct stp_scene **scene)
{
    const struct stp_load_params defaults = { 0 };
    struct stp_scene *loaded = NULL;
    enum stp_result result = stp_scene_create(env, &loaded);
    if (result != STP_OK)
        return result;
    if (!params)
        params = &defaults;
    result = looks_like_json(path)   ? load_json(env, path, params, loaded)
             : range_is_folder(path) ? add_folder(env, loaded, path, params)
                                     : add_file(env, loaded, path, params, NULL);
    if (result == STP_OK)
        *scene = loaded;
    else
        stp_scene_destroy(&loaded);
    return result;
}

bool stp_scene_camera(const struct stp_scene *scene, uint32_t width, uint32_t height,
                      struct stp_camera *camera)
{
    if (!scene->has_camera)
        return false;
    *camera = scene->camera;
    if (width || height)
        camera_resize(camera, scene->camera_intrinsics, width, height);
    return true;
}
