/* JSON that is built without asking after every key whether there was memory for it. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>

#include "cli.h"

/* Takes `item`, which is NULL when it could not be had, into `parent`. */
static cJSON *put(struct json_out *out, cJSON *parent, const char *key, cJSON *item)
{
    bool added =
        item && parent &&
        (key ? cJSON_AddItemToObject(parent, key, item) : cJSON_AddItemToArray(parent, item));
    if (added)
        return item;
    cJSON_Delete(item);
    out->failed = true;
    return NULL;
}

cJSON *json_begin(struct json_out *out, cJSON *root)
{
    out->failed |= !root;
    return root;
}

cJSON *json_object(struct json_out *out, cJSON *parent, const char *key)
{
    return put(out, parent, key, cJSON_CreateObject());
}

cJSON *json_array(struct json_out *out, cJSON *parent, const char *key)
{
    return put(out, parent, key, cJSON_CreateArray());
}

void json_number(struct json_out *out, cJSON *parent, const char *key, double value)
{
    put(out, parent, key, isfinite(value) ? cJSON_CreateNumber(value) : cJSON_CreateNull());
}

void json_numbers(struct json_out *out, cJSON *parent, const char *key, const double *values,
                  int count)
{
    put(out, parent, key, cJSON_CreateDoubleArray(values, count));
}

void json_text(struct json_out *out, cJSON *parent, const char *key, const char *value)
{
    put(out, parent, key, cJSON_CreateString(value));
}

void json_bool(struct json_out *out, cJSON *parent, const char *key, bool value)
{
    put(out, parent, key, cJSON_CreateBool(value));
}

int json_print(struct console *console, struct json_out *out, const cJSON *root)
{
    char *text = out->failed ? NULL : cJSON_Print(root);
    if (text)
        puts(text);
    else
        console_error(console, "out of memory");
    free(text);
    return text ? EXIT_DONE : EXIT_FAILED;
}
