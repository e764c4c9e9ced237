#include "base/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/log.h"

static enum stp_result syntax_error(const struct stp_env *env, const char *path, const char *what,
                                    const struct file_bytes *bytes, size_t offset)
{
    size_t line = 1, start = 0;
    for (size_t i = 0; i < offset; i++)
        if (bytes->data[i] == '\n') {
            line++;
            start = i + 1;
        }
    return log_error(env, STP_ERROR_FORMAT, "%s: %s at byte %zu (line %zu, column %zu)", path, what,
                     offset, line, offset - start + 1);
}

static bool is_space(unsigned char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* The place of a character NUL, as it is or escaped, in text that parses: there it ends a string as
 * we see it, and a path would name another file. The text's size: there is none. */
static size_t find_nul(const struct file_bytes *bytes)
{
    for (size_t i = 0; i < bytes->size; i++) {
        if (bytes->data[i] == 0)
            return i;
        if (bytes->data[i] != '\\' || i + 1 == bytes->size)
            continue;
        if (bytes->size - i >= 6 && memcmp(bytes->data + i, "\\u0000", 6) == 0)
            return i;
        i++; /* what is escaped begins nothing */
    }
    return bytes->size;
}

enum stp_result json_read(const struct stp_env *env, const char *path, cJSON **root)
{
    struct file_bytes bytes = { 0 };
    enum stp_result result = file_read(env, path, &bytes);
    if (result != STP_OK)
        return result;
    const char *text = (const char *)bytes.data, *end = text;
    cJSON *parsed = bytes.size ? cJSON_ParseWithLengthOpts(text, bytes.size, &end, false) : NULL;
    size_t offset = end ? (size_t)(end - text) : 0;
    if (parsed)
        while (offset < bytes.size && is_space(bytes.data[offset]))
            offset++;
    size_t nul = find_nul(&bytes);
    if (!parsed || offset < bytes.size || nul < bytes.size) {
        bool whole = parsed && offset == bytes.size;
        cJSON_Delete(parsed);
        result = syntax_error(env, path, whole ? "a character NUL" : "broken JSON", &bytes,
                              whole ? nul : offset);
    } else {
        *root = parsed;
    }
    file_release(&bytes);
    return result;
}

struct json_at json_root(const struct stp_env *env, const char *path)
{
    return (struct json_at){ .env = env, .path = path };
}

struct json_at json_below(const struct json_at *at, const char *key, int index)
{
    struct json_at below = { .env = at->env, .path = at->path };
    if (index < 0)
        snprintf(below.where, sizeof below.where, "%.40s%.48s.", at->where, key);
    else
        snprintf(below.where, sizeof below.where, "%.40s%.32s[%d].", at->where, key, index);
    return below;
}

enum stp_result json_error(const struct json_at *at, const char *key, const char *what)
{
    return log_error(at->env, STP_ERROR_FORMAT, "%s: %s%s: %s", at->path, at->where, key, what);
}

static const cJSON *member(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

bool json_has(const cJSON *object, const char *key)
{
    return member(object, key) != NULL;
}

enum stp_result json_get_number(const struct json_at *at, const cJSON *object, const char *key,
                                double *value)
{
    const cJSON *item = member(object, key);
    if (!item)
        return STP_OK;
    if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble))
        return json_error(at, key, "a finite number is needed");
    *value = item->valuedouble;
    return STP_OK;
}

enum stp_result json_get_float(const struct json_at *at, const cJSON *object, const char *key,
                               float *value)
{
    double number = *value;
    enum stp_result result = json_get_number(at, object, key, &number);
    if (result == STP_OK && !isfinite((float)number))
        return json_error(at, key, "the number is too large");
    if (result == STP_OK)
        *value = (float)number;
    return result;
}

enum stp_result json_get_string(const struct json_at *at, const cJSON *object, const char *key,
                                const char **value)
{
    const cJSON *item = member(object, key);
    if (!item)
        return STP_OK;
    if (!cJSON_IsString(item) || !item->valuestring)
        return json_error(at, key, "a string is needed");
    *value = item->valuestring;
    return STP_OK;
}

enum stp_result json_get_bool(const struct json_at *at, const cJSON *object, const char *key,
                              bool *value)
{
    const cJSON *item = member(object, key);
    if (!item)
        return STP_OK;
    if (!cJSON_IsBool(item))
        return json_error(at, key, "true or false is needed");
    *value = cJSON_IsTrue(item);
    return STP_OK;
}

/* Appends the numbers of a nested array; false on anything else, or more than `count`. */
static bool flatten(const cJSON *array, unsigned count, double *values, unsigned *used)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, array)
    {
        if (cJSON_IsArray(item)) {
            if (!flatten(item, count, values, used))
                return false;
        } else if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble) || *used == count) {
            return false;
        } else {
            values[(*used)++] = item->valuedouble;
        }
    }
    return true;
}

enum stp_result json_get_numbers(const struct json_at *at, const cJSON *object, const char *key,
                                 unsigned count, double *values)
{
    const cJSON *item = member(object, key);
    double read[16];
    unsigned used = 0;
    if (!item)
        return STP_OK;
    if (!cJSON_IsArray(item) || !flatten(item, count, read, &used) || used != count) {
        char what[48];
        snprintf(what, sizeof what, "an array of %u finite numbers is needed", count);
        return json_error(at, key, what);
    }
    memcpy(values, read, count * sizeof *values);
    return STP_OK;
}

static bool listed(const char *known, const char *key)
{
    size_t length = strlen(key);
    for (const char *word = known; (word = strstr(word, key)) != NULL && length; word += length)
        if ((word == known || word[-1] == ' ') && (word[length] == ' ' || word[length] == 0))
            return true;
    return false;
}

enum stp_result json_check_object(const struct json_at *at, const cJSON *object, const char *known)
{
    const cJSON *item;
    if (!cJSON_IsObject(object))
        return json_error(at, "", "an object is needed");
    cJSON_ArrayForEach(item, object)
    {
        if (!listed(known, item->string))
            log_warning(at->env, "%s: %s%s: unknown key, ignored (known: %s)", at->path, at->where,
                        item->string, known);
        else if (member(object, item->string) != item)
            log_warning(at->env, "%s: %s%s: the key comes again; the first counts", at->path,
                        at->where, item->string);
    }
    return STP_OK;
}

const char *json_number_text(double value, char text[JSON_NUMBER_SIZE])
{
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, JSON_NUMBER_SIZE, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    for (char *c = text; *c; c++)
        if (*c == ',')
            *c = '.';
    return text;
}
