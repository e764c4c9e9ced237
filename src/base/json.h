/* JSON files with errors that say where: line and byte of what does not parse, the key of what has
 * the wrong type. Over cJSON; a key that is absent leaves its output untouched. */
#ifndef STP_BASE_JSON_H
#define STP_BASE_JSON_H

#include <cJSON.h>
#include <stipple/result.h>

/* Parses a whole file; release with cJSON_Delete. A character NUL, in a string or not, is an error.
 */
enum stp_result json_read(const struct stp_env *env, const char *path, cJSON **root);

/* Where an object stands, for messages: "camera.json: [3].intrinsics". */
struct json_at {
    const struct stp_env *env;
    const char *path;
    char where[96]; /* "" at the root, else it ends in '.' */
};
struct json_at json_root(const struct stp_env *env, const char *path);
/* The place of at's key, and of its element when index >= 0. */
struct json_at json_below(const struct json_at *at, const char *key, int index);

/* "path: WHERE.key: what"; returns STP_ERROR_FORMAT. */
enum stp_result json_error(const struct json_at *at, const char *key, const char *what);

/* Each fails only on a wrong type or a value that is not finite. */
enum stp_result json_get_number(const struct json_at *at, const cJSON *object, const char *key,
                                double *value);
enum stp_result json_get_float(const struct json_at *at, const cJSON *object, const char *key,
                               float *value);
enum stp_result json_get_string(const struct json_at *at, const cJSON *object, const char *key,
                                const char **value); /* lives as long as the object */
enum stp_result json_get_bool(const struct json_at *at, const cJSON *object, const char *key,
                              bool *value);
/* Exactly `count` numbers; nested rows count as flat. */
enum stp_result json_get_numbers(const struct json_at *at, const cJSON *object, const char *key,
                                 unsigned count, double *values);
bool json_has(const cJSON *object, const char *key);

/* Fails when it is no object; warns of every key that is not in the space-separated list, and of
 * one that comes again: the first counts. */
enum stp_result json_check_object(const struct json_at *at, const cJSON *object, const char *known);

/* The shortest of 15, 16 or 17 digits that reads back as `value`, whatever the locale. */
#define JSON_NUMBER_SIZE 32
const char *json_number_text(double value, char text[JSON_NUMBER_SIZE]);

#endif
