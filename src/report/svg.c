/* report.svg: milliseconds against error on log axes; the front is drawn, what it beats is pale. */
#include "report/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report/labels.h"
#include "report/plot.h"

#define WIDTH  960
#define HEIGHT 600
#define LEFT   92
#define RIGHT  932
#define TOP    118
#define BOTTOM 536
#define LETTER 6.3 /* mean width of a letter of the labels */
#define LABELS 24
#define EIGHTH (1.0 / 255)

struct plot {
    FILE *out;
    const struct report *report;
    struct axis x, y;
    const char *kind[REPORT_MAX_KINDS];
    unsigned kind_count;
};

/* Told apart by those who see colours differently, too (Okabe and Ito). */
static const char *kind_color(const struct plot *plot, const char *kind)
{
    static const char *const colors[REPORT_MAX_KINDS] = { "#007a57", "#c44e00", "#0064a8",
                                                          "#a0447f", "#8a6d00", "#2b8cbe",
                                                          "#555555", "#000000" };
    unsigned i = 0;
    while (i + 1 < plot->kind_count && strcmp(plot->kind[i], kind) != 0)
        i++;
    return colors[i];
}

static void find_range(struct plot *plot)
{
    double fast = INFINITY, slow = 0, least = INFINITY, most = 0;
    for (unsigned i = 0; i < plot->report->row_count; i++) {
        const struct report_row *row = &plot->report->row[i];
        if (row->is_reference)
            continue;
        fast = fmin(fast, fmax(row->ms.quartile1, 1e-6)); /* the bars are inside too */
        slow = fmax(slow, row->ms.quartile3);
        least = fmin(least, report_error(row));
        most = fmax(most, report_error(row));
    }
    if (!(slow > 0))
        fast = slow = 1, least = most = 1e-3;
    double room = fmax(pow(slow / fast, 0.08), 1.15);
    plot->x = (struct axis){ fast / room, slow * room, LEFT, RIGHT };
    double low = pow(10, floor(log10(least * 0.8))), high = pow(10, ceil(log10(most * 2)));
    plot->y = (struct axis){ low, high, BOTTOM, TOP };
}

static void power_of_ten(FILE *out, double value)
{
    static const char *const digits[] = { "⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹" };
    int power = (int)lround(log10(value));
    fprintf(out, "10%s", power < 0 ? "⁻" : "");
    for (int p = abs(power), scale = p >= 10 ? 10 : 1; scale; scale /= 10)
        fputs(digits[p / scale % 10], out);
}

static void draw_axes(const struct plot *plot)
{
    FILE *out = plot->out;
    double ticks[AXIS_MAX_TICKS];
    unsigned count = axis_ticks(&plot->x, ticks);
    fprintf(out, "<g class=\"axis\">\n");
    for (unsigned i = 0; i < count; i++) {
        double x = axis_at(&plot->x, ticks[i]);
        fprintf(out, "<path d=\"M%.1f %dV%d\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%g",
                x, TOP, BOTTOM, x, BOTTOM + 18, ticks[i]);
        fputs("</text>\n", out);
    }
    count = axis_decades(&plot->y, ticks);
    for (unsigned i = 0; i < count; i++) {
        double y = axis_at(&plot->y, ticks[i]);
        fprintf(out, "<path d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">",
                LEFT, y, RIGHT, LEFT - 8, y + 4);
        power_of_ten(out, ticks[i]);
        fputs("</text>\n", out);
    }
    fprintf(out,
            "</g>\n<text class=\"title\" x=\"%d\" y=\"%d\" text-anchor=\"middle\">milliseconds a "
            "frame (left is faster)</text>\n",
            (LEFT + RIGHT) / 2, BOTTOM + 42);
    fprintf(out,
            "<text class=\"title\" transform=\"translate(26 %d) rotate(-90)\" "
            "text-anchor=\"middle\">mean absolute error (down is better)</text>\n",
            (TOP + BOTTOM) / 2);
}

/* What the eye can know: a step of an 8-bit picture. */
static void draw_eighth(const struct plot *plot)
{
    if (EIGHTH <= plot->y.low || EIGHTH >= plot->y.high)
        return;
    double y = axis_at(&plot->y, EIGHTH);
    fprintf(plot->out,
            "<path d=\"M%d %.1fH%d\" stroke=\"#888\" stroke-dasharray=\"2 4\"/>"
            "<text class=\"note\" x=\"%d\" y=\"%.1f\" text-anchor=\"end\">1/255</text>\n",
            LEFT, y, RIGHT, RIGHT - 4, y - 4);
}

static void marker(FILE *out, const char *path, double x, double y, double r,
                   const char *attributes)
{
    if (strcmp(path, "raster") == 0)
        fprintf(out, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" %s", x - r * 0.9,
                y - r * 0.9, r * 1.8, r * 1.8, attributes);
    else
        fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" %s", x, y, r, attributes);
}

static double legend_item(const struct plot *plot, double x, const char *path, const char *color,
                          const char *word)
{
    char attributes[64];
    snprintf(attributes, sizeof attributes, "fill=\"%s\"/>", color);
    marker(plot->out, path, x, 91, 6, attributes);
    fprintf(plot->out, "<text class=\"label\" x=\"%.1f\" y=\"95\">%s</text>\n", x + 12, word);
    return x + 36 + 7 * (double)strlen(word);
}

static void draw_legend(const struct plot *plot)
{
    double x = LEFT + 6;
    for (unsigned i = 0; i < plot->kind_count; i++)
        x = legend_item(plot, x, "compute", kind_color(plot, plot->kind[i]), plot->kind[i]);
    x = legend_item(plot, x + 18, "compute", "#999", "compute");
    x = legend_item(plot, x, "raster", "#999", "raster");
    fprintf(plot->out,
            "<path class=\"front\" d=\"M%.1f 91h26\"/><text class=\"label\" x=\"%.1f\" y=\"95\">"
            "front: nothing is both faster and better</text>\n",
            x + 12, x + 46);
}

static void draw_heading(const struct plot *plot)
{
    const struct report *r = plot->report;
    fprintf(plot->out, "<text class=\"heading\" x=\"%d\" y=\"34\">Speed against error: ", LEFT);
    svg_text(plot->out, r->title);
    fprintf(plot->out, "</text>\n<text class=\"note\" x=\"%d\" y=\"58\">%zu %s, %u x %u pixels, ",
            LEFT, r->splats, report_splats(r), r->width, r->height);
    svg_text(plot->out, r->device);
    fputs(".", plot->out);
    for (unsigned i = 0; i < r->row_count; i++)
        if (r->row[i].is_reference)
            fprintf(plot->out, " The reference takes %.0f ms on the CPU.", r->row[i].ms.median);
    fputs("</text>\n", plot->out);
}

static double px(const struct plot *plot, const struct report_row *row)
{
    return axis_at(&plot->x, fmax(row->ms.median, 1e-6));
}
static double py(const struct plot *plot, const struct report_row *row)
{
    return axis_at(&plot->y, report_error(row));
}

static void draw_point(const struct plot *plot, const struct report_row *row, bool strong)
{
    char name[REPORT_NAME_SIZE], number[2][REPORT_NUMBER_SIZE], attributes[128];
    double x = px(plot, row), y = py(plot, row);
    const char *color = kind_color(plot, report_kind(row));
    if (strong)
        fprintf(plot->out, "<path d=\"M%.1f %.1fH%.1f\" stroke=\"%s\" stroke-opacity=\"0.6\"/>",
                axis_at(&plot->x, fmax(row->ms.quartile1, 1e-6)), y,
                axis_at(&plot->x, fmax(row->ms.quartile3, 1e-6)), color);
    snprintf(attributes, sizeof attributes,
             strong ? "fill=\"%s\" stroke=\"#fff\" stroke-width=\"1.5\">"
                    : "fill=\"%s\" fill-opacity=\"0.28\">",
             color);
    marker(plot->out, row->path, x, y, strong ? 6.5 : 5, attributes);
    fprintf(plot->out, "<title>%s: %s ms, error %s</title></%s>\n", report_row_name(row, name),
            report_number(row->ms.median, number[0]),
            report_number(row->error.covered.mean_absolute, number[1]),
            strcmp(row->path, "raster") == 0 ? "rect" : "circle");
}

/* Down from the top, then from each to the next: at any time the least error to be had. */
static unsigned front_line(const struct plot *plot, double line[][2])
{
    const struct report_row *front[REPORT_MAX_ROWS];
    unsigned points = 0, count = report_front(plot->report, front);
    if (!count)
        return 0;
    double y = TOP;
    for (unsigned i = 0; i < count; i++) {
        double x = px(plot, front[i]);
        line[points][0] = x, line[points++][1] = y;
        y = py(plot, front[i]);
        line[points][0] = x, line[points++][1] = y;
    }
    line[points][0] = RIGHT, line[points++][1] = y;
    return points;
}

static void draw_line(const struct plot *plot, double line[][2], unsigned count)
{
    if (!count)
        return;
    fputs("<path class=\"front\" d=\"", plot->out);
    for (unsigned i = 0; i < count; i++)
        fprintf(plot->out, "%c%.1f %.1f", i ? 'L' : 'M', line[i][0], line[i][1]);
    fputs("\"/>\n", plot->out);
}

/* The front, and the fastest of every other method and path. */
static bool is_named(const struct report *report, const struct report_row *row)
{
    if (!report_contends(row))
        return false;
    if (row->on_front)
        return true;
    for (unsigned i = 0; i < report->row_count; i++) {
        const struct report_row *other = &report->row[i];
        if (strcmp(report_kind(other), report_kind(row)) == 0 &&
            strcmp(other->path, row->path) == 0 && report_contends(other) &&
            (other->on_front || other->ms.median < row->ms.median ||
             (other->ms.median == row->ms.median && other < row)))
            return false;
    }
    return true;
}

static void label_text(const struct report_row *row, char text[REPORT_NAME_SIZE])
{
    char number[REPORT_NUMBER_SIZE];
    int n = row->overlap_asked > 0 ? snprintf(text, REPORT_NAME_SIZE, "c %.3g", row->overlap_asked)
                                   : snprintf(text, REPORT_NAME_SIZE, "%s", report_kind(row));
    if (row->peel_layers)
        n += snprintf(text + n, REPORT_NAME_SIZE - (size_t)n, " %u", row->peel_layers);
    if (row->merge && strcmp(row->merge, "blend") == 0)
        n += snprintf(text + n, REPORT_NAME_SIZE - (size_t)n, " h %.3g", row->axis_h);
    if (*row->voronoi && strcmp(row->voronoi, "off") != 0)
        n += snprintf(text + n, REPORT_NAME_SIZE - (size_t)n, " %s", row->voronoi);
    if (*row->payload)
        n += snprintf(text + n, REPORT_NAME_SIZE - (size_t)n, " %s", row->payload);
    if (row->epsilon_scale != 1)
        n += snprintf(text + n, REPORT_NAME_SIZE - (size_t)n, " ε×%.3g", row->epsilon_scale);
    snprintf(text + n, REPORT_NAME_SIZE - (size_t)n, ", %s ms",
             report_number(row->ms.median, number));
}

static void draw_label(const struct plot *plot, const struct report_row *row,
                       const struct label *label)
{
    char text[REPORT_NAME_SIZE];
    const struct box *b = &label->box;
    double x = fmin(fmax(label->x, b->left), b->right), y = fmin(fmax(label->y, b->top), b->bottom);
    if (hypot(x - label->x, y - label->y) > 14)
        fprintf(plot->out, "<path class=\"leader\" d=\"M%.1f %.1fL%.1f %.1f\"/>", label->x,
                label->y, x, y);
    label_text(row, text);
    fprintf(plot->out,
            "<text class=\"label name\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" "
            "style=\"fill:%s\">",
            (b->left + b->right) / 2, b->bottom - 3.5, kind_color(plot, report_kind(row)));
    svg_text(plot->out, text);
    fputs("</text>\n", plot->out);
}

static void draw_labels(const struct plot *plot, const double (*line)[2], unsigned line_count)
{
    const struct report_row *named[LABELS];
    struct label labels[LABELS];
    struct box markers[2 * REPORT_MAX_ROWS + 1];
    char text[REPORT_NAME_SIZE];
    unsigned count = 0, marker_count = 0;
    double eighth = axis_at(&plot->y, EIGHTH);
    markers[marker_count++] = (struct box){ LEFT, eighth - 2, RIGHT, eighth + 2 };
    for (unsigned i = 0; i < plot->report->row_count; i++) {
        const struct report_row *row = &plot->report->row[i];
        if (row->is_reference)
            continue;
        double x = px(plot, row), y = py(plot, row);
        markers[marker_count++] = (struct box){ x - 6, y - 6, x + 6, y + 6 };
        if (count == LABELS || !is_named(plot->report, row))
            continue;
        label_text(row, text);
        labels[count] = (struct label){
            .x = x, .y = y, .width = LETTER * (double)strlen(text) + 4, .height = 15
        };
        named[count++] = row;
        markers[marker_count++] =
            (struct box){ axis_at(&plot->x, fmax(row->ms.quartile1, 1e-6)), y - 3,
                          axis_at(&plot->x, fmax(row->ms.quartile3, 1e-6)), y + 3 };
    }
    struct label_scene scene = {
        { LEFT + 4, TOP + 4, RIGHT - 4, BOTTOM - 4 }, markers, marker_count, line, line_count
    };
    labels_place(labels, count, &scene);
    for (unsigned i = 0; i < count; i++)
        draw_label(plot, named[i], &labels[i]);
}

static void begin(FILE *out)
{
    fprintf(out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
            "height=\"%d\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n<style>\n"
            ".heading{font-size:20px;font-weight:bold;fill:#222}\n"
            ".title{font-size:13px;fill:#333}\n.note{font-size:12px;fill:#666}\n"
            ".label{font-size:12px;fill:#333}\n"
            ".name{paint-order:stroke;stroke:#fff;stroke-width:3px;stroke-linejoin:round}\n"
            ".axis path{stroke:#e4e4e4}\n.axis text{font-size:12px;fill:#555}\n"
            ".front{fill:none;stroke:#222;stroke-width:1.6}\n"
            ".leader{stroke:#999;stroke-width:0.8}\n</style>\n"
            "<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/>\n",
            WIDTH, HEIGHT, WIDTH, HEIGHT, WIDTH, HEIGHT);
}

void report_svg(FILE *out, const struct report *report)
{
    struct plot plot = { .out = out, .report = report };
    double line[2 * REPORT_MAX_ROWS + 2][2];
    plot.kind_count = report_kinds(report, plot.kind);
    find_range(&plot);
    begin(out);
    draw_heading(&plot);
    draw_legend(&plot);
    draw_axes(&plot);
    draw_eighth(&plot);
    fprintf(out, "<path d=\"M%d %dV%dH%d\" fill=\"none\" stroke=\"#555\"/>\n", LEFT, TOP, BOTTOM,
            RIGHT);
    unsigned count = front_line(&plot, line);
    for (unsigned i = 0; i < report->row_count; i++)
        if (!report->row[i].is_reference && !is_named(report, &report->row[i]))
            draw_point(&plot, &report->row[i], false);
    draw_line(&plot, line, count);
    for (unsigned i = 0; i < report->row_count; i++)
        if (is_named(report, &report->row[i]))
            draw_point(&plot, &report->row[i], true);
    draw_labels(&plot, line, count);
    fputs("</svg>\n", out);
}
