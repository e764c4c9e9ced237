/* What a point file held, in the file's order: what every reader fills. */
#ifndef STP_LOAD_CLOUD_H
#define STP_LOAD_CLOUD_H

#include <stipple/scene.h>

/* A scalar that --color-by can name (intensity, class, any other property of a PLY). */
struct cloud_field {
    char name[32];
    float *value;
};

struct cloud {
    size_t count;
    double (*position)[3];
    float (*normal)[3];            /* NULL: the file has none */
    float *radius;                 /* NULL: none */
    float (*color)[3];             /* NULL: none; linear */
    float *opacity;                /* NULL: none */
    struct stp_phong_splat *phong; /* NULL: none; else there are normals */
    unsigned field_count;
    struct cloud_field *fields; /* only the one that color_by asks for, unless asked for all */
    enum stp_up up;             /* what the format says; STP_UP_Y where it says nothing */
    char format[32];            /* "PLY binary little-endian", "OBJ", ...; ", gzip" appended */
};

void cloud_release(struct cloud *cloud);
/* One radius for all, where the file has none; 0: nothing is done. */
enum stp_result cloud_give_radius(const struct stp_env *env, float radius, struct cloud *cloud);

#endif
