/* Numbers of fixed binary records to the columns of a table: LAS and PCD. */
#ifndef STP_LOAD_RECORD_H
#define STP_LOAD_RECORD_H

#include "load/record_type.h"
#include "load/table.h"

/* Where a column's numbers stand, little-endian, and what they mean. */
struct record_column {
    const unsigned char *first; /* of row 0 */
    size_t stride;
    enum record_type type;
    unsigned shift, bits; /* of a part of an integer; bits 0: all of it */
    double scale, offset; /* value * scale + offset; scale 0: the value as it stands */
    bool has_missing;
    double missing; /* the stored value that says that there is none: NaN */
};

/* The value of one row. */
double record_value(const struct record_column *column, size_t row);

/* Rows 0 to count of every column that has a slot; column i of the table is `columns[i]`. The
 * caller has checked that they lie within the file. */
void records_read(const struct stp_env *env, const struct record_column *columns,
                  const struct table *table, size_t count);

static inline uint16_t little16(const unsigned char *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}
static inline uint32_t little32(const unsigned char *p)
{
    return little16(p) | (uint32_t)little16(p + 2) << 16;
}
static inline uint64_t little64(const unsigned char *p)
{
    return little32(p) | (uint64_t)little32(p + 4) << 32;
}
double little_double(const unsigned char *p);

#endif
