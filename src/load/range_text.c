/* Intrinsics and poses as text. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "load/range.h"
#include "load/text.h"

struct lines {
    const struct stp_env *env;
    const char *path;
    const char *begin, *at, *end;
    struct text_style style;
};

static struct lines lines_of(const struct stp_env *env, const char *path,
                             const struct file_bytes *bytes)
{
    const char *begin = (const char *)bytes->data;
    struct lines lines = { env, path, begin, begin, begin + bytes->size, { .comments = true } };
    lines.style.eol = bytes->size ? text_eol(lines.begin, lines.end) : '\n';
    return lines;
}

/* To the next line that says something; false: there is none. */
static bool next_line(struct lines *lines)
{
    lines->at = text_next_row(&lines->style, lines->at, lines->end);
    return lines->at < lines->end;
}

static enum stp_result line_error(const struct lines *lines, const char *what)
{
    return log_error(lines->env, STP_ERROR_FORMAT, "%s: byte %zu: %s", lines->path,
                     (size_t)(lines->at - lines->begin), what);
}

/* Exactly `count` numbers up to the end of the line, which is stepped over. */
static bool take_numbers(struct lines *lines, unsigned count, double *value)
{
    const char *at = lines->at;
    for (unsigned i = 0; i < count; i++) {
        at = text_skip_space(&lines->style, at, lines->end);
        if (!number_read(&at, lines->end, &value[i]))
            return false;
    }
    at = text_skip_space(&lines->style, at, lines->end);
    if (at < lines->end && *at != lines->style.eol && *at != '#')
        return false;
    lines->at = text_next_line(&lines->style, at, lines->end);
    return true;
}

static bool is_positive(double value)
{
    return value > 0 && value < INFINITY;
}

enum stp_result range_intrinsics_from_bytes(const struct stp_env *env, const char *path,
                                            const struct file_bytes *bytes,
                                            struct range_camera *camera, struct range_units *units)
{
    static const char *const keys[] = { "fx", "fy", "cx", "cy", "depth_scale" };
    double value[5] = { 0, 0, NAN, NAN, 1 };
    struct lines lines = lines_of(env, path, bytes);
    while (next_line(&lines)) {
        const char *after = lines.at;
        struct slice key = text_token(&lines.style, &after, lines.end);
        unsigned i = 0;
        while (i < 5 && !slice_is(key, keys[i]))
            i++;
        if (i == 5)
            return line_error(&lines, "one of fx fy cx cy depth_scale is needed, and a number");
        const char *line = lines.at;
        lines.at = after;
        if (!take_numbers(&lines, 1, &value[i])) {
            lines.at = line;
            return line_error(&lines, "a number is needed after the key");
        }
    }
    if (!is_positive(value[0]) || !is_positive(value[1]) || !is_positive(value[4]))
        return log_error(env, STP_ERROR_FORMAT, "%s: fx, fy and depth_scale must be positive",
                         path);
    if (!isfinite(value[2]) || !isfinite(value[3]))
        return log_error(env, STP_ERROR_FORMAT, "%s: cx and cy are needed", path);
    camera->fx = value[0];
    camera->fy = value[1];
    camera->cx = value[2] + 0.5;
    camera->cy = value[3] + 0.5;
    units->depth_scale = value[4];
    return STP_OK;
}

bool range_pose(const double p[7], double m[16])
{
    double x = p[3], y = p[4], z = p[5], w = p[6];
    double n = sqrt(x * x + y * y + z * z + w * w);
    for (int i = 0; i < 7; i++)
        if (!isfinite(p[i]))
            return false;
    if (!(n > 0.5 && n < 2)) /* rounded, not something else */
        return false;
    x /= n;
    y /= n;
    z /= n;
    w /= n;
    const double rows[16] = { 1 - 2 * (y * y + z * z),
                              2 * (x * y - z * w),
                              2 * (x * z + y * w),
                              p[0],
                              2 * (x * y + z * w),
                              1 - 2 * (x * x + z * z),
                              2 * (y * z - x * w),
                              p[1],
                              2 * (x * z - y * w),
                              2 * (y * z + x * w),
                              1 - 2 * (x * x + y * y),
                              p[2],
                              0,
                              0,
                              0,
                              1 };
    memcpy(m, rows, sizeof rows);
    return true;
}

enum stp_result range_poses_from_bytes(const struct stp_env *env, const char *path,
                                       const struct file_bytes *bytes, double (**poses)[16],
                                       unsigned *count)
{
    struct lines lines = lines_of(env, path, bytes);
    double(*made)[16] = mem_alloc(RANGE_MOST_FRAMES, sizeof *made), seven[7];
    enum stp_result result = made ? STP_OK : log_no_memory(env, RANGE_MOST_FRAMES * 128, path);
    unsigned n = 0;
    while (result == STP_OK && next_line(&lines)) {
        const char *line = lines.at;
        if (n == RANGE_MOST_FRAMES)
            result = line_error(&lines, "more than 1024 poses");
        else if (!take_numbers(&lines, 7, seven))
            result = line_error(&lines, "seven numbers are needed: tx ty tz qx qy qz qw");
        else if (!range_pose(seven, made[n++])) {
            lines.at = line;
            result = line_error(&lines, "no pose: numbers are not finite, or the quaternion's "
                                        "length is not 1");
        }
    }
    if (result == STP_OK && n == 0)
        result = log_error(env, STP_ERROR_FORMAT, "%s: no poses in it", path);
    if (result != STP_OK) {
        mem_free(made);
        return result;
    }
    *poses = made;
    *count = n;
    return STP_OK;
}
