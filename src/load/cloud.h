/* What a point file held, in the file's order: what every reader fills. */
#ifndef STP_LOAD_CLOUD_H
#define STP_LOAD_CLOUD_H

#include <stipple/scene.h>

/* A scalar that --color-by can name (intensity, class, any other property of a PLY). */
struct cloud_field {
    char name[32];
    float *value;
};

/* What a prepared file says of an object. */
struct cloud_object {
    double epsilon; /* 0: not known */
    bool estimated; /* its normals were */
};

struct cloud {
    size_t count;
    double (*position)[3];
    float (*normal)[3];            /* NULL: the file has none */
    float *radius;                 /* NULL: none */
    float (*color)[3];             /* NULL: none; linear */
    float *opacity;                /* NULL: none */
    struct stp_phong_splat *phong; /* NULL: none; else there are normals */
    unsigned object_count;         /* 0: the file says nothing of objects */
    struct cloud_object *objects;  /* object_count of them */
    uint16_t *object;              /* of each point; NULL: all are of the first */
    unsigned field_count;
    struct cloud_field *fields; /* only the one that color_by asks for, unless asked for all */
    enum stp_up up;             /* what the format says; STP_UP_Y where it says nothing */
    char format[32];            /* "PLY binary little-endian", "OBJ", ...; ", gzip" appended */
};

void cloud_release(struct cloud *cloud);
/* One radius for all, where the file has none; 0: nothing is done. */
enum stp_result cloud_give_radius(const struct stp_env *env, float radius, struct cloud *cloud);
/* The clouds of a cloud's objects, object_count of them, in its order; points keep theirs, fields
 * are left out. cloud->object is not NULL. To be freed with mem_free after cloud_release of each.
 */
enum stp_result cloud_split(const struct stp_env *env, const struct cloud *cloud,
                            struct cloud **parts);

#endif
