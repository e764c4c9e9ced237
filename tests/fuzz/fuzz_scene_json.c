/* Scene .json files, all but the loading of the point files that they name. */
#include <math.h>

#include "base/memory.h"
#include "fuzz.h"
#include "scene/range.h"
#include "scene/scene_json.h"

static void check_entry(const struct scene_entry *entry)
{
    fuzz_check(entry->file && *entry->file, "an entry names a file");
    fuzz_check(isfinite(entry->params.epsilon) && entry->params.epsilon >= 0, "epsilon is bounded");
    float opacity = entry->params.opacity; /* -1: the file says 0 */
    fuzz_check((opacity >= 0 && opacity <= 1) || opacity == -1, "opacity is within 0..1");
    for (int i = 0; i < 16 && entry->transformed; i++)
        fuzz_check(isfinite(entry->transform[i]), "a transform is finite");
    fuzz_check(!entry->transformed || (isfinite(entry->scale) && entry->scale > 0),
               "a transform scales by a positive number");
}

static enum stp_result read_entries(const struct json_at *root, const cJSON *json, int count)
{
    const struct stp_load_params params = { 0 };
    enum stp_result result = STP_OK;
    for (int i = 0; i < count && result == STP_OK; i++) {
        struct scene_entry entry;
        result = scene_json_entry(root, json, i, &params, &entry);
        if (result == STP_OK)
            check_entry(&entry);
        mem_free(entry.file);
    }
    return result;
}

/* Its pictures are not found. */
static enum stp_result read_range(const struct json_at *root, const cJSON *json)
{
    const struct stp_load_params params = { 0 };
    struct range range = { 0 };
    enum stp_range_splats splats = STP_RANGE_AUTO;
    if (!json_has(json, "range"))
        return STP_OK;
    enum stp_result result = range_from_json(root, json, &params, &range, &splats);
    fuzz_check(result != STP_OK && range.count == 0, "no frame without its files");
    return result;
}

static enum stp_result read_scene(const struct stp_env *env, const cJSON *json)
{
    /* In a folder that is not there: a camera_file of a relative path is not found. */
    struct json_at root = json_root(env, "/nowhere/scene.json");
    struct stp_scene *scene = NULL;
    enum stp_up up;
    int entries = 0;
    enum stp_result result = stp_scene_create(env, &scene);
    if (result == STP_OK)
        result = scene_json_begin(&root, json, &up, &entries);
    if (result == STP_OK)
        result = scene_json_lights(&root, json, scene);
    if (result == STP_OK)
        result = scene_json_camera(&root, json, scene);
    if (result == STP_OK) {
        fuzz_check(scene->light_count >= 1 && scene->light_count <= STP_MAX_LIGHTS,
                   "1 to 8 lights");
        result = read_entries(&root, json, entries);
    }
    if (result == STP_OK)
        result = read_range(&root, json);
    stp_scene_destroy(&scene);
    return result;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_log log;
    cJSON *json = NULL;
    char path[32];
    int file = fuzz_file_open(data, size, path);
    fuzz_begin(&log);
    enum stp_result result = json_read(&log.env, path, &json);
    if (result == STP_OK)
        result = read_scene(&log.env, json);
    fuzz_end(&log, result);
    cJSON_Delete(json);
    fuzz_file_close(file);
    return 0;
}
