/* Inside the LAS reader: the header block and the extra bytes (ASPRS LAS 1.2 to 1.4 R15). */
#ifndef STP_LOAD_LAS_H
#define STP_LOAD_LAS_H

#include "load/readers.h"
#include "load/record.h"

struct las_header {
    unsigned minor;      /* of version 1 */
    unsigned format;     /* of points, 0 to 10 */
    size_t record, size; /* bytes from one point to the next, and of the format alone */
    size_t points;       /* offset of the first point */
    uint64_t count;
    double scale[3], offset[3];
    uint32_t vlrs, evlrs;
    size_t vlr_begin;
    uint64_t evlr_begin;
};

enum stp_result las_header_read(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, struct las_header *header);

/* Offsets within a point; 0: the format has none. */
struct las_format {
    unsigned char size, gps_time, color, infrared;
};
const struct las_format *las_format_of(unsigned format);

/* One number that the writer added to every point. */
struct las_extra {
    struct slice name;
    struct record_column column; /* first and stride are the caller's to set */
    size_t at, bytes;            /* within a point */
};

/* Descriptions of 192 bytes, `count` of them at `records`; count 0: the file has none. Warns of
 * records that leave the file, and looks no further. */
struct las_extras {
    const unsigned char *records;
    size_t count;
};
struct las_extras las_extras_find(const struct stp_env *env, const char *path,
                                  const struct file_bytes *bytes, const struct las_header *header);

/* Description `index`, at offset *at within the point, which it steps on (to SIZE_MAX after a type
 * that is not known). False: it is no number
 * (undocumented bytes, or the arrays that 1.4 did away with), or has no name. */
bool las_extra_read(const struct las_extras *extras, size_t index, size_t *at,
                    struct las_extra *extra);

#endif
