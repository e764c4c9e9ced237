#include "load/table.h"

#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"

struct role_name {
    const char *name;
    enum role role;
};

static const struct role_name role_names[] = {
    { "x", ROLE_X },
    { "y", ROLE_Y },
    { "z", ROLE_Z },
    { "nx", ROLE_NX },
    { "ny", ROLE_NY },
    { "nz", ROLE_NZ },
    { "normal_x", ROLE_NX },
    { "normal_y", ROLE_NY },
    { "normal_z", ROLE_NZ },
    { "normalx", ROLE_NX },
    { "normaly", ROLE_NY },
    { "normalz", ROLE_NZ },
    { "red", ROLE_RED },
    { "green", ROLE_GREEN },
    { "blue", ROLE_BLUE },
    { "r", ROLE_RED },
    { "g", ROLE_GREEN },
    { "b", ROLE_BLUE },
    { "diffuse_red", ROLE_RED },
    { "diffuse_green", ROLE_GREEN },
    { "diffuse_blue", ROLE_BLUE },
    { "alpha", ROLE_OPACITY },
    { "opacity", ROLE_OPACITY },
    { "a", ROLE_OPACITY },
    { "diffuse_alpha", ROLE_OPACITY },
    { "radius", ROLE_RADIUS },
    { "psz", ROLE_RADIUS },
    { "point_size", ROLE_RADIUS },
    { "pointsize", ROLE_RADIUS },
};

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

static int find_role(const struct table *table, enum role role)
{
    for (unsigned i = 0; i < table->count; i++)
        if (table->column[i].role == role && !table->column[i].list)
            return (int)i;
    return -1;
}

bool table_has(const struct table *table, enum role role)
{
    return find_role(table, role) >= 0;
}

void table_name_roles(struct table *table)
{
    for (unsigned i = 0; i < table->count; i++) {
        struct column *column = &table->column[i];
        for (size_t n = 0; n < COUNT_OF(role_names) && !column->list; n++)
            if (slice_matches(column->name, role_names[n].name) &&
                !table_has(table, role_names[n].role))
                column->role = role_names[n].role;
    }
}

static void drop_role(struct table *table, enum role role)
{
    int column = find_role(table, role);
    if (column >= 0)
        table->column[column].role = ROLE_NONE;
}

/* Two thirds of a normal or of a colour are of no use. */
static void drop_incomplete(struct table *table, enum role first)
{
    for (enum role role = first; role < first + 3; role++)
        if (!table_has(table, role))
            for (enum role other = first; other < first + 3; other++)
                drop_role(table, other);
}

/* The name, or the name after the "scalar_" that CloudCompare puts before it. */
static bool is_named(struct slice column, const char *name)
{
    static const char prefix[] = "scalar_";
    size_t length = sizeof prefix - 1;
    if (slice_matches(column, name))
        return true;
    return column.length > length && slice_matches((struct slice){ column.text, length }, prefix) &&
           slice_matches((struct slice){ column.text + length, column.length - length }, name);
}

static int find_name(const struct table *table, const char *name)
{
    for (unsigned i = 0; i < table->count; i++)
        if (!table->column[i].list && slice_is(table->column[i].name, name))
            return (int)i;
    for (unsigned i = 0; i < table->count; i++)
        if (!table->column[i].list && is_named(table->column[i].name, name))
            return (int)i;
    return -1;
}

static const char *const class_names[] = { "class", "classification", "label" };

static bool is_class_name(struct slice name)
{
    for (size_t i = 0; i < COUNT_OF(class_names); i++)
        if (is_named(name, class_names[i]))
            return true;
    return false;
}

static int find_field(const struct table *table, const char *name)
{
    int field = find_name(table, name);
    bool is_class = is_class_name((struct slice){ name, strlen(name) });
    for (size_t i = 0; i < COUNT_OF(class_names) && is_class && field < 0; i++)
        field = find_name(table, class_names[i]);
    return field;
}

static enum stp_result unknown_field(const struct stp_env *env, const char *path, const char *name,
                                     const struct table *table)
{
    char list[512] = "";
    size_t used = 0;
    for (unsigned i = 0; i < table->count && used + 40 < sizeof list; i++) {
        char text[32];
        if (table->column[i].list)
            continue;
        slice_copy(table->column[i].name, text, sizeof text);
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", used ? ", " : "", text);
    }
    return log_error(env, STP_ERROR_ARGUMENT,
                     "%s: no field \"%s\" to colour by; fields: %s (and rgb, normal, height)", path,
                     name, used ? list : "none");
}

static enum stp_result plan_color(const struct stp_env *env, const char *path, const char *name,
                                  struct table *table)
{
    table->field = -1;
    table->source = COLOR_FILE;
    if (!name || !*name || strcmp(name, "rgb") == 0)
        return STP_OK;
    table->source = COLOR_LATER;
    if (strcmp(name, "normal") == 0 || strcmp(name, "height") == 0)
        return STP_OK;
    table->field = find_field(table, name);
    if (table->field < 0)
        return unknown_field(env, path, name, table);
    table->source = is_class_name(table->column[table->field].name) ? COLOR_CLASS : COLOR_RAMP;
    return STP_OK;
}

enum stp_result table_plan(const struct stp_env *env, const char *path,
                           const struct load_options *options, struct table *table)
{
    drop_incomplete(table, ROLE_NX);
    drop_incomplete(table, ROLE_RED);
    enum stp_result result = plan_color(env, path, options->color_by, table);
    if (result == STP_OK && table->source != COLOR_FILE)
        for (enum role role = ROLE_RED; role <= ROLE_BLUE; role++)
            drop_role(table, role);
    return result;
}

static bool allocate_field(struct table *table, size_t count, struct cloud *cloud)
{
    cloud->fields = mem_zalloc(1, sizeof *cloud->fields);
    if (!cloud->fields)
        return false;
    cloud->field_count = 1;
    cloud->fields->value = mem_alloc(count, sizeof(float));
    cloud->color = mem_alloc(count, sizeof *cloud->color);
    struct column *column = &table->column[table->field];
    slice_copy(column->name, cloud->fields->name, sizeof cloud->fields->name);
    column->slot[1] = (struct slot){ (char *)cloud->fields->value, sizeof(float), false };
    return cloud->fields->value && cloud->color;
}

static bool allocate_arrays(struct table *table, size_t count, struct cloud *cloud)
{
    bool ok = (cloud->position = mem_alloc(count, sizeof *cloud->position)) != NULL;
    if (ok && table_has(table, ROLE_NX))
        ok = (cloud->normal = mem_alloc(count, sizeof *cloud->normal)) != NULL;
    if (ok && table_has(table, ROLE_RED))
        ok = (cloud->color = mem_alloc(count, sizeof *cloud->color)) != NULL;
    if (ok && table_has(table, ROLE_OPACITY))
        ok = (cloud->opacity = mem_alloc(count, sizeof *cloud->opacity)) != NULL;
    if (ok && table_has(table, ROLE_RADIUS))
        ok = (cloud->radius = mem_alloc(count, sizeof *cloud->radius)) != NULL;
    if (ok && table->field >= 0)
        ok = allocate_field(table, count, cloud);
    return ok;
}

static struct slot role_slot(const struct cloud *cloud, enum role role)
{
    if (role >= ROLE_X && role <= ROLE_Z)
        return (struct slot){ (char *)(cloud->position[0] + (role - ROLE_X)),
                              sizeof *cloud->position, true };
    if (role >= ROLE_NX && role <= ROLE_NZ)
        return (struct slot){ (char *)(cloud->normal[0] + (role - ROLE_NX)), sizeof *cloud->normal,
                              false };
    if (role >= ROLE_RED && role <= ROLE_BLUE)
        return (struct slot){ (char *)(cloud->color[0] + (role - ROLE_RED)), sizeof *cloud->color,
                              false };
    if (role == ROLE_OPACITY)
        return (struct slot){ (char *)cloud->opacity, sizeof(float), false };
    if (role == ROLE_RADIUS)
        return (struct slot){ (char *)cloud->radius, sizeof(float), false };
    return (struct slot){ 0 };
}

enum stp_result table_allocate(const struct stp_env *env, const char *path, size_t count,
                               struct table *table, struct cloud *cloud)
{
    if (!allocate_arrays(table, count, cloud)) {
        cloud_release(cloud);
        return log_error(env, STP_ERROR_MEMORY, "%s: out of memory for %zu points", path, count);
    }
    cloud->count = count;
    for (unsigned i = 0; i < table->count; i++)
        table->column[i].slot[0] = role_slot(cloud, table->column[i].role);
    /* A planar file: everything lies at z = 0. */
    if (!table_has(table, ROLE_Z))
        for (size_t i = 0; i < count; i++)
            cloud->position[i][2] = 0;
    return STP_OK;
}

enum stp_result table_finish(const struct stp_env *env, const char *path,
                             const struct load_options *options, const struct table *table,
                             struct cloud *cloud)
{
    int red = find_role(table, ROLE_RED), opacity = find_role(table, ROLE_OPACITY);
    cloud->up = STP_UP_Y;
    if (opacity >= 0 &&
        opacity_decode(env, path, cloud->opacity, cloud->count, table->column[opacity].scale)) {
        mem_free(cloud->opacity);
        cloud->opacity = NULL;
    }
    if (table->source == COLOR_CLASS)
        color_classes(env, cloud->fields->value, cloud->count, cloud->color);
    else if (table->source == COLOR_RAMP)
        return color_ramp(env, cloud->fields->value, cloud->count, cloud->color);
    else if (red >= 0)
        color_decode(env, path, cloud->color, cloud->count, table->column[red].scale,
                     options->transfer);
    return STP_OK;
}
