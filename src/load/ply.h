/* Inside the PLY reader: the header, and the binary body. */
#ifndef STP_LOAD_PLY_H
#define STP_LOAD_PLY_H

#include "load/readers.h"
#include "load/table.h"

enum ply_type {
    PLY_NONE = 0,
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT32,
    PLY_FLOAT64,
};

enum ply_encoding { PLY_ASCII = 0, PLY_LITTLE, PLY_BIG };

struct ply_property {
    struct slice name;
    enum ply_type type;
    enum ply_type length; /* of a list's length; PLY_NONE: a scalar */
};

struct ply_element {
    struct slice name;
    uint64_t count;
    unsigned first, properties; /* in ply_header.property */
};

/* Bounds on what a header may declare: far beyond real files, far below what could hurt. */
#define PLY_MAX_HEADER     ((size_t)8 << 20) /* a comment for each of 65535 objects */
#define PLY_MAX_ELEMENTS   64
#define PLY_MAX_PROPERTIES 1024

struct ply_header {
    enum ply_encoding encoding;
    char eol;
    bool prepared; /* written by stp_scene_save */
    size_t body;   /* offset of the first byte after the header */
    unsigned object_count;
    struct cloud_object *objects; /* owned; what a prepared file's comments say of them */
    unsigned element_count, property_count;
    struct ply_element element[PLY_MAX_ELEMENTS];
    struct ply_property *property; /* PLY_MAX_PROPERTIES; names point into the file */
};

enum stp_result ply_header_read(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, struct ply_header *header);
void ply_header_release(struct ply_header *header);

/* ply.c: what a vertex's properties are, into table->column; the element, or NULL. */
const struct ply_element *ply_find_element(const struct ply_header *header, const char *name);
bool ply_is_gaussian(const struct ply_header *header, const struct ply_element *vertex);
void ply_fill_columns(const struct ply_header *header, const struct ply_element *vertex,
                      struct table *table);

/* Bytes of a scalar; 0 for PLY_NONE. */
size_t ply_type_size(enum ply_type type);

/* Bytes of one instance, lists taken as empty; *has_list tells that there may be more. */
size_t ply_element_size(const struct ply_header *header, const struct ply_element *element,
                        bool *has_list);

/* Steps over `count` instances of an element at *offset. Names element and byte on failure. */
enum stp_result ply_binary_skip(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, const struct ply_header *header,
                                const struct ply_element *element, size_t *offset);

/* The columns of all instances of `element`, at `offset`. Without lists, the caller has checked
 * that all of them lie within the file. */
enum stp_result ply_binary_read(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, const struct ply_header *header,
                                const struct ply_element *element, size_t offset,
                                const struct table *table);

/* Ellipses of a prepared file. After table_plan: how many of their properties there are, 0 for
 * none; what is unknown or missing is refused. After table_allocate: where they are read to. Then:
 * what is made of them. */
#define PLY_PHONG_VALUES 17
enum stp_result ply_phong_plan(const struct stp_env *env, const char *path,
                               const struct table *table, unsigned *values);
void ply_phong_slots(struct table *table, unsigned values, float (*raw)[PLY_PHONG_VALUES]);
enum stp_result ply_phong_finish(const struct stp_env *env, const char *path, unsigned values,
                                 const float (*raw)[PLY_PHONG_VALUES], struct cloud *cloud);

/* Objects of a prepared file. From the header: the words after "comment stipple object". After
 * table_plan: the column that tells whose a vertex is, where there are several; -1: there are not.
 * Then: what was read from it. What is damaged is refused. */
enum stp_result ply_objects_note(const struct stp_env *env, const char *path,
                                 const struct slice *token, unsigned tokens,
                                 struct ply_header *header);
enum stp_result ply_objects_plan(const struct stp_env *env, const char *path,
                                 const struct ply_header *header, const struct table *table,
                                 int *column);
enum stp_result ply_objects_finish(const struct stp_env *env, const char *path,
                                   const struct ply_header *header, const float *raw,
                                   struct cloud *cloud);

#endif
