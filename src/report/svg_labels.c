#include "report/labels.h"

#include <math.h>

#define DIRECTIONS 16
#define RINGS      9
#define TURN       6.283185307179586

double box_overlap(const struct box *a, const struct box *b)
{
    double w = fmin(a->right, b->right) - fmax(a->left, b->left);
    double h = fmin(a->bottom, b->bottom) - fmax(a->top, b->top);
    return w > 0 && h > 0 ? w * h : 0;
}

static struct box grown(const struct box *box, double by)
{
    return (struct box){ box->left - by, box->top - by, box->right + by, box->bottom + by };
}

/* A place on a ring around the point: the label touches the ring from outside. */
static struct box candidate(const struct label *label, unsigned direction, unsigned ring)
{
    double angle = TURN * direction / DIRECTIONS, reach = 11 + 11.0 * ring;
    double x = label->x + reach * cos(angle), y = label->y + reach * sin(angle);
    double left = x - label->width * (0.5 - 0.5 * cos(angle));
    double top = y - label->height * (0.5 - 0.5 * sin(angle));
    return (struct box){ left, top, left + label->width, top + label->height };
}

static double outside(const struct box *box, const struct box *area)
{
    return fmax(0, area->left - box->left) + fmax(0, box->right - area->right) +
           fmax(0, area->top - box->top) + fmax(0, box->bottom - area->bottom);
}

/* The line's length inside the box, to a pixel. */
static double crossed(const struct label_scene *scene, const struct box *box)
{
    double length = 0;
    for (unsigned i = 0; i + 1 < scene->line_count; i++) {
        const double *a = scene->line[i], *b = scene->line[i + 1];
        unsigned steps = 1 + (unsigned)(hypot(b[0] - a[0], b[1] - a[1]) / 2);
        for (unsigned k = 0; k < steps; k++) {
            double t = (k + 0.5) / steps, x = a[0] + t * (b[0] - a[0]),
                   y = a[1] + t * (b[1] - a[1]);
            length += x > box->left && x < box->right && y > box->top && y < box->bottom ? 2 : 0;
        }
    }
    return length;
}

static double cost(const struct label *labels, unsigned placed, unsigned count, unsigned ring,
                   const struct box *box, const struct label_scene *scene)
{
    struct box wide = grown(box, 3);
    double sum = 14.0 * ring + 1e4 * outside(box, &scene->area) + 8 * crossed(scene, &wide);
    for (unsigned i = 0; i < placed; i++)
        sum += 100 * box_overlap(&wide, &labels[i].box);
    for (unsigned i = 0; i < scene->marker_count; i++)
        sum += 3 * box_overlap(&wide, &scene->markers[i]);
    /* A neighbour's point in between would seem to be the one that is named. */
    for (unsigned i = 0; i < count; i++)
        if (i != placed && labels[i].x > wide.left - 8 && labels[i].x < wide.right + 8 &&
            labels[i].y > wide.top - 8 && labels[i].y < wide.bottom + 8)
            sum += 150;
    return sum;
}

void labels_place(struct label *labels, unsigned count, const struct label_scene *scene)
{
    for (unsigned i = 0; i < count; i++) {
        double least = INFINITY;
        for (unsigned ring = 0; ring < RINGS; ring++) {
            for (unsigned direction = 0; direction < DIRECTIONS; direction++) {
                struct box box = candidate(&labels[i], direction, ring);
                double price = cost(labels, i, count, ring, &box, scene);
                if (price < least) {
                    least = price;
                    labels[i].box = box;
                }
            }
        }
    }
}
