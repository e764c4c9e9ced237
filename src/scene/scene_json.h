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
/* The folder of the scene file, then `file`; or `file` alone when it is absolute. Owned by the
 * caller; NULL: out of memory. */
char *scene_json_join(const char *scene_path, const char *file);

/* The object of "volume". */
struct volume_entry {
    char *file, *function_file;    /* owned */
    struct stp_load_params params; /* may point to function_file, into the JSON and to material */
    struct stp_material material;
    bool has_function;
    struct transfer_function function; /* one that stands in the scene file itself */
};
enum stp_result volume_json_entry(const struct json_at *root, const cJSON *json,
                                  const struct stp_load_params *params, struct volume_entry *entry);
void volume_entry_release(struct volume_entry *entry);
/* The object of "material". */
enum stp_result scene_json_material(const struct json_at *at, const cJSON *item,
                                    struct stp_material *material);

/* Lights and camera, if the file has them. */
enum stp_result scene_json_lights(const struct json_at *root, const cJSON *json,
                                  struct stp_scene *scene);
enum stp_result scene_json_camera(const struct json_at *root, const cJSON *json,
                                  struct stp_scene *scene);
/* Checks the keys of the whole, reads "up", and counts the entries of "points". */
enum stp_result scene_json_begin(const struct json_at *root, const cJSON *json, enum stp_up *up,
                                 int *entries);

#endif
