/* Rows of text to columns. Blocks of regular lines are parsed in parallel; when any line is not
 * regular, the tolerant serial reader starts again and either copes or says where it could not. */
#include <stdatomic.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "load/table.h"

#define BLOCK_BYTES ((size_t)1 << 18)

/* Lines belong to the block in which they start. */
struct blocks {
    const struct row_source *source;
    const struct table *table;
    size_t count, rows;
    size_t *first; /* row of each block; count + 1 */
    atomic_bool irregular;
};

static const char *block_start(const struct row_source *source, size_t block)
{
    size_t size = (size_t)(source->end - source->body);
    if (block == 0)
        return source->body;
    if (block * BLOCK_BYTES >= size)
        return source->end;
    return text_next_line(&source->style, source->body + block * BLOCK_BYTES - 1, source->end);
}

static size_t count_lines(const struct text_style *style, const char *at, const char *end)
{
    size_t rows = 0;
    while ((at = text_next_row(style, at, end)) < end) {
        rows++;
        at = text_next_line(style, at, end);
    }
    return rows;
}

static void count_range(void *context, size_t begin, size_t end, unsigned)
{
    struct blocks *blocks = context;
    for (size_t i = begin; i < end; i++)
        blocks->first[i + 1] = count_lines(&blocks->source->style, block_start(blocks->source, i),
                                           block_start(blocks->source, i + 1));
}

static bool cut_blocks(const struct stp_env *env, struct blocks *blocks)
{
    const struct row_source *source = blocks->source;
    blocks->count = (size_t)(source->end - source->body) / BLOCK_BYTES + 1;
    blocks->first = mem_alloc(blocks->count + 1, sizeof *blocks->first);
    if (!blocks->first)
        return false;
    blocks->first[0] = 0;
    parallel_for(env, blocks->count, 1, count_range, blocks);
    for (size_t i = 0; i < blocks->count; i++)
        blocks->first[i + 1] += blocks->first[i];
    return true;
}

size_t table_count_rows(const struct stp_env *env, const struct row_source *source)
{
    struct blocks blocks = { .source = source };
    if (!cut_blocks(env, &blocks))
        return count_lines(&source->style, source->body, source->end);
    size_t rows = blocks.first[blocks.count];
    mem_free(blocks.first);
    return rows;
}

/* Nothing but space, or a comment, is left of the line. */
static bool is_line_done(const struct text_style *style, const char *at, const char *end)
{
    return at == end || *at == style->eol || (style->comments && *at == '#');
}

/* One number that a separator or the line's end follows; NULL if there is none. */
static const char *read_number(const struct text_style *style, const char *at, const char *end,
                               double *value)
{
    at = text_skip_space(style, at, end);
    if (!number_read(&at, end, value))
        return NULL;
    return at == end || *at == style->eol || text_is_space(style, *at) ? at : NULL;
}

static void store(const struct column *column, size_t row, double value)
{
    slot_store(&column->slot[0], row, value);
    slot_store(&column->slot[1], row, value);
}

/* A line that holds the table's numbers and no more; the next line, or NULL when it does not. */
static const char *read_regular(const struct blocks *blocks, const char *at, const char *end,
                                size_t row)
{
    const struct text_style *style = &blocks->source->style;
    const struct table *table = blocks->table;
    for (unsigned i = 0; i < table->count; i++) {
        double value;
        at = read_number(style, at, end, &value);
        if (!at)
            return NULL;
        store(&table->column[i], row, value);
    }
    at = text_skip_space(style, at, end);
    return blocks->source->open || is_line_done(style, at, end) ? text_next_line(style, at, end)
                                                                : NULL;
}

static void read_range(void *context, size_t begin, size_t end, unsigned)
{
    struct blocks *blocks = context;
    const struct text_style *style = &blocks->source->style;
    for (size_t i = begin; i < end && !atomic_load(&blocks->irregular); i++) {
        const char *at = block_start(blocks->source, i);
        const char *stop = block_start(blocks->source, i + 1);
        for (size_t row = blocks->first[i]; row < blocks->first[i + 1] && row < blocks->rows;
             row++) {
            at = read_regular(blocks, text_next_row(style, at, stop), stop, row);
            if (!at) {
                atomic_store(&blocks->irregular, true);
                return;
            }
        }
    }
}

static bool read_in_parallel(const struct stp_env *env, const struct row_source *source,
                             const struct table *table, size_t count)
{
    struct blocks blocks = { .source = source, .table = table, .rows = count };
    for (unsigned i = 0; i < table->count; i++)
        if (table->column[i].list)
            return false;
    if (!cut_blocks(env, &blocks))
        return false;
    bool enough = blocks.first[blocks.count] >= count;
    if (enough)
        parallel_for(env, blocks.count, 1, read_range, &blocks);
    mem_free(blocks.first);
    return enough && !atomic_load(&blocks.irregular);
}

struct walk {
    const struct stp_env *env;
    const char *path;
    const struct row_source *source;
    const char *at;
    size_t row, count;
};

static enum stp_result walk_error(const struct walk *walk, const char *what)
{
    return log_error(walk->env, STP_ERROR_FORMAT, "%s: byte %zu: %s in %s %zu of %zu", walk->path,
                     (size_t)(walk->at - walk->source->begin), what, walk->source->element,
                     walk->row, walk->count);
}

static bool at_line_end(struct walk *walk)
{
    const struct row_source *source = walk->source;
    walk->at = text_skip_space(&source->style, walk->at, source->end);
    return is_line_done(&source->style, walk->at, source->end);
}

static enum stp_result walk_number(struct walk *walk, double *value)
{
    const struct row_source *source = walk->source;
    if (at_line_end(walk)) {
        if (!source->ragged && walk->at < source->end)
            return walk_error(walk, "a number is missing");
        walk->at = text_next_row(&source->style, walk->at, source->end);
    }
    if (walk->at == source->end)
        return walk_error(walk, "the file ends");
    const char *next = read_number(&source->style, walk->at, source->end, value);
    if (!next)
        return walk_error(walk, "not a number");
    walk->at = next;
    return STP_OK;
}

/* A list that the line ends before is empty: exporters have declared lists and left them out. */
static enum stp_result walk_list(struct walk *walk)
{
    double length = 0, value;
    if (walk->source->ragged && at_line_end(walk))
        return STP_OK;
    enum stp_result result = walk_number(walk, &length);
    if (result == STP_OK && !(length >= 0 && length <= (double)UINT32_MAX))
        return walk_error(walk, "a list of impossible length");
    for (size_t i = 0; result == STP_OK && i < (size_t)length; i++)
        result = walk_number(walk, &value);
    return result;
}

static enum stp_result walk_row(struct walk *walk, const struct table *table)
{
    enum stp_result result = STP_OK;
    walk->at = text_next_row(&walk->source->style, walk->at, walk->source->end);
    for (unsigned i = 0; i < table->count && result == STP_OK; i++) {
        double value = 0;
        if (table->column[i].list)
            result = walk_list(walk);
        else
            result = walk_number(walk, &value);
        if (result == STP_OK)
            store(&table->column[i], walk->row, value);
    }
    return result;
}

enum stp_result table_read_rows(const struct stp_env *env, const char *path,
                                const struct row_source *source, const struct table *table,
                                size_t count)
{
    if (read_in_parallel(env, source, table, count))
        return STP_OK;
    struct walk walk = { env, path, source, source->body, 0, count };
    size_t longer = 0;
    for (; walk.row < count; walk.row++) {
        enum stp_result result = walk_row(&walk, table);
        if (result != STP_OK)
            return result;
        longer += !at_line_end(&walk);
        walk.at = text_next_line(&source->style, walk.at, source->end);
    }
    if (longer && !source->open)
        log_warning(env,
                    "%s: %zu of %zu lines hold more numbers than declared; the rest is left out",
                    path, longer, count);
    return STP_OK;
}
