/* The types of numbers in binary files. */
#ifndef STP_LOAD_RECORD_TYPE_H
#define STP_LOAD_RECORD_TYPE_H

#include <stddef.h>

enum record_type {
    RECORD_NONE = 0, /* there is no number */
    RECORD_INT8,
    RECORD_UINT8,
    RECORD_INT16,
    RECORD_UINT16,
    RECORD_INT32,
    RECORD_UINT32,
    RECORD_INT64,
    RECORD_UINT64,
    RECORD_FLOAT32,
    RECORD_FLOAT64,
};

size_t record_type_size(enum record_type type); /* bytes */

#endif
