/* A file as a table: what its columns mean, where their numbers go, and what is made of them
 * afterwards. Every reader but OBJ's normals goes through here. */
#ifndef STP_LOAD_TABLE_H
#define STP_LOAD_TABLE_H

#include "load/color.h"
#include "load/load.h"
#include "load/text.h"

enum role {
    ROLE_NONE = 0,
    ROLE_X,
    ROLE_Y,
    ROLE_Z,
    ROLE_NX,
    ROLE_NY,
    ROLE_NZ,
    ROLE_RED,
    ROLE_GREEN,
    ROLE_BLUE,
    ROLE_OPACITY,
    ROLE_RADIUS,
};

/* Where a column's value of row i goes: base + i * stride, a double when wide, else a float. */
struct slot {
    char *base; /* NULL: nowhere */
    size_t stride;
    bool wide;
};

static inline void slot_store(const struct slot *slot, size_t row, double value)
{
    if (!slot->base)
        return;
    if (slot->wide)
        *(double *)(void *)(slot->base + row * slot->stride) = value;
    else
        *(float *)(void *)(slot->base + row * slot->stride) = (float)value;
}

struct column {
    struct slice name;
    enum role role;
    enum scale scale;    /* of colours and opacity */
    bool list;           /* a length, then so many numbers; stepped over */
    struct slot slot[2]; /* by role; and as the field that color_by names */
};

enum color_source { COLOR_FILE = 0, COLOR_LATER, COLOR_RAMP, COLOR_CLASS };

struct table {
    struct column *column; /* owned by the reader */
    unsigned count;
    enum color_source source;
    int field; /* the column that color_by names; -1: none */
};

/* Roles from the names in use (docs/formats.md); the first column of a name wins. */
void table_name_roles(struct table *table);

/* Drops roles of incomplete groups, and finds color_by. STP_ERROR_ARGUMENT when no column has the
 * name; the line lists those there are. */
enum stp_result table_plan(const struct stp_env *env, const char *path,
                           const struct load_options *options, struct table *table);

bool table_has(const struct table *table, enum role role);

/* Arrays for what the table holds, and the slots that lead into them. Releases on failure. */
enum stp_result table_allocate(const struct stp_env *env, const char *path, size_t count,
                               struct table *table, struct cloud *cloud);

/* Raw colours and opacity to linear ones; color_by to colours. */
enum stp_result table_finish(const struct stp_env *env, const char *path,
                             const struct load_options *options, const struct table *table,
                             struct cloud *cloud);

/* Reads `count` rows of numbers, one a line, in parallel where all lines are regular. */
struct row_source {
    const char *begin; /* of the file: offsets in messages are from here */
    const char *body, *end;
    struct text_style style;
    const char *element; /* what a row is called in messages */
    bool ragged;         /* a row may go on in the next line, and lists may be missing */
    bool open;           /* more numbers at the end of a line are expected, and left out */
};
enum stp_result table_read_rows(const struct stp_env *env, const char *path,
                                const struct row_source *source, const struct table *table,
                                size_t count);

/* Rows (not blank, not comment) in the source. */
size_t table_count_rows(const struct stp_env *env, const struct row_source *source);

#endif
