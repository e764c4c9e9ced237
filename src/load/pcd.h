/* Inside the PCD reader: the header (Point Cloud Library, file versions 0.5 to 0.7). */
#ifndef STP_LOAD_PCD_H
#define STP_LOAD_PCD_H

#include "load/readers.h"
#include "load/record.h"

enum pcd_encoding { PCD_ASCII = 0, PCD_BINARY, PCD_COMPRESSED };

struct pcd_field {
    struct slice name;
    enum record_type type;
    size_t size, count; /* bytes of a number; numbers */
    bool is_padding;    /* named "_" */
    bool packed;        /* rgb or rgba: four bytes of one number, blue first */
};

/* Far beyond real files, far below what could hurt. */
#define PCD_MAX_HEADER  ((size_t)1 << 16)
#define PCD_MAX_FIELDS  256
#define PCD_MAX_NUMBERS 4096 /* of a point: fields times their counts */

struct pcd_header {
    enum pcd_encoding encoding;
    uint64_t count, height;
    size_t body;              /* offset of the first byte after the header */
    unsigned numbers, fields; /* numbers: of a point */
    size_t record, dense;     /* bytes of a point; and without its padding */
    struct pcd_field field[PCD_MAX_FIELDS];
};

enum stp_result pcd_header_read(const struct stp_env *env, const char *path,
                                const struct file_bytes *bytes, struct pcd_header *header);

#endif
