/* Where the labels of a plot go: beside their points, over nothing that must be seen. */
#ifndef STP_REPORT_LABELS_H
#define STP_REPORT_LABELS_H

struct box {
    double left, top, right, bottom;
};

struct label {
    double x, y;          /* the point that it names */
    double width, height; /* of the text */
    struct box box;       /* labels_place: where it went */
};

struct label_scene {
    struct box area;           /* labels stay inside */
    const struct box *markers; /* not to be covered */
    unsigned marker_count;
    const double (*line)[2]; /* a polyline, better not crossed */
    unsigned line_count;
};

/* One after another, each at the cheapest of the places around its point. */
void labels_place(struct label *labels, unsigned count, const struct label_scene *scene);
/* Area that two boxes share. */
double box_overlap(const struct box *a, const struct box *b);

#endif
