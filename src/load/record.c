#include "load/record.h"

#include <math.h>
#include <string.h>

#include "base/thread.h"

#define GRAIN 8192 /* rows a thread converts at a time: their bytes stay in its cache */

size_t record_type_size(enum record_type type)
{
    static const unsigned char sizes[] = { 0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8 };
    return sizes[type];
}

static float little_float(const unsigned char *p)
{
    uint32_t bits = little32(p);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

double little_double(const unsigned char *p)
{
    uint64_t bits = little64(p);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double number_at(const unsigned char *p, enum record_type type)
{
    switch (type) {
    case RECORD_INT8:
        return (int8_t)*p;
    case RECORD_UINT8:
        return *p;
    case RECORD_INT16:
        return (int16_t)little16(p);
    case RECORD_UINT16:
        return little16(p);
    case RECORD_INT32:
        return (int32_t)little32(p);
    case RECORD_UINT32:
        return little32(p);
    case RECORD_INT64:
        return (double)(int64_t)little64(p);
    case RECORD_UINT64:
        return (double)little64(p);
    case RECORD_FLOAT32:
        return little_float(p);
    case RECORD_FLOAT64:
        return little_double(p);
    case RECORD_NONE:
        break;
    }
    return 0;
}

/* Parts are of unsigned numbers of up to 32 bits, which a double holds exactly. */
static double part_of(double number, const struct record_column *column)
{
    return (double)((uint32_t)number >> column->shift & ((1u << column->bits) - 1));
}

double record_value(const struct record_column *column, size_t row)
{
    double value = number_at(column->first + row * column->stride, column->type);
    if (column->bits)
        value = part_of(value, column);
    if (column->has_missing && value == column->missing)
        return NAN;
    return column->scale != 0 ? value * column->scale + column->offset : value;
}

struct body {
    const struct record_column *columns;
    const struct table *table;
};

static void read_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct body *body = context;
    for (unsigned c = 0; c < body->table->count; c++) {
        const struct record_column *column = &body->columns[c];
        const struct slot *slot = body->table->column[c].slot;
        if (column->type == RECORD_NONE || (!slot[0].base && !slot[1].base))
            continue;
        for (size_t row = begin; row < end; row++) {
            double value = record_value(column, row);
            slot_store(&slot[0], row, value);
            slot_store(&slot[1], row, value);
        }
    }
}

void records_read(const struct stp_env *env, const struct record_column *columns,
                  const struct table *table, size_t count)
{
    struct body body = { columns, table };
    parallel_for(env, count, GRAIN, read_range, &body);
}
