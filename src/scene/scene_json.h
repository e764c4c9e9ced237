/* The scene .json: point files, materials, lights and a camera (docs/scene.md). */
#ifndef STP_SCENE_SCENE_JSON_H
#define STP_SCENE_SCENE_JSON_H

#include "base/json.h"
#include "scene/scene.h"

/* One entry of "points". What the caller's params say wins over what the file says. */
struct scene_entry {
    char *file; /* owned; the scene file's folder is prepended to a relative path */
    struct stp_load_params params; /* color_by may point into the JSON, material below */
    struct stp_material material;
    struct stp_optics optics;
    bool transformed;
    double transform[16]; /* rotation, uniform scale and translation */
    double scale;
};

/* Entry `index`; entry->file is freed by the caller. */
enum stp_result scene_json_entry(const struct json_at *root, const cJSON *json, int index,
                                 const struct stp_load_params *params, struct scene_entry *entry);
/* The folder of the scene file, then `file`; or `file` alone when it is absolute. NULL: no memory.
 */
char *scene_json_path(const char *scene_path, const char *file);
/* Lights and camera, if the file has them. */
enum stp_result scene_json_lights(const struct json_at *root, const cJSON *json,
                                  struct stp_scene *scene);
enum stp_result scene_json_camera(const struct json_at *root, const cJSON *json,
                                  struct stp_scene *scene);
/* Checks the keys of the whole, reads "up", and counts the entries of "points". */
enum stp_result scene_json_begin(const struct json_at *root, const cJSON *json, enum stp_up *up,
                                 int *entries);

#endif
