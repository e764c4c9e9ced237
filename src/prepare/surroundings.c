#include "prepare/surroundings.h"

#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "base/vec.h"
#include "prepare/eigen.h"

/* Middle over largest variance: below ON_A_LINE more neighbours are asked; below NO_PLANE there is
 * no plane. */
#define ON_A_LINE    0.01
#define NO_PLANE     1e-6
#define SPACING_RANK 8
/* Farther than that many spacings from the rest, a line of points is a wire, not a scan line. */
#define WIRE  4.0
#define SLICE ((size_t)1 << 18) /* between two reports of progress */

struct plane {
    double value[3], vector[3][3];
};

/* Of the neighbours and the point itself, relative to it: large coordinates lose nothing. */
static void fit_plane(const struct neighbour_tree *t, size_t i, const struct neighbours *n,
                      struct plane *plane)
{
    struct vec3 p = v3_load(t->position[i]), sum = v3(0, 0, 0);
    double s[6] = { 0 }, scale = n->count > 0 ? sqrt(n->distance[n->count - 1]) : 0;
    scale = scale > 0 ? 1 / scale : 0;
    for (unsigned j = 0; j < n->count; j++) {
        struct vec3 d = v3_scale(v3_sub(v3_load(t->position[n->id[j]]), p), scale);
        sum = v3_add(sum, d);
        s[0] += d.x * d.x;
        s[1] += d.x * d.y;
        s[2] += d.x * d.z;
        s[3] += d.y * d.y;
        s[4] += d.y * d.z;
        s[5] += d.z * d.z;
    }
    double inverse = 1.0 / (n->count + 1);
    double covariance[6] = { s[0] - sum.x * sum.x * inverse, s[1] - sum.x * sum.y * inverse,
                             s[2] - sum.x * sum.z * inverse, s[3] - sum.y * sum.y * inverse,
                             s[4] - sum.y * sum.z * inverse, s[5] - sum.z * sum.z * inverse };
    eigen_symmetric(covariance, plane->value, plane->vector);
}

/* To the nearest neighbour seen at more than 30 degrees from the line; 0: none. */
static double distance_off_line(const struct neighbour_tree *t, size_t i,
                                const struct neighbours *n, const double line[3])
{
    for (unsigned j = 0; j < n->count; j++) {
        struct vec3 d = v3_sub(v3_load(t->position[n->id[j]]), v3_load(t->position[i]));
        double along = v3_dot(d, v3_load(line));
        if (n->distance[j] > 0 && along * along < 0.75 * n->distance[j])
            return sqrt(n->distance[j]);
    }
    return 0;
}

static unsigned rank_of_spacing(size_t count)
{
    return count / 2 >= SPACING_RANK ? SPACING_RANK : count > 3 ? (unsigned)count / 2 : 1;
}

static bool on_a_line(const struct plane *plane)
{
    return !(plane->value[1] > ON_A_LINE * plane->value[2]);
}

/* Where there are fewer than rank: to the last. */
static double distance_of_rank(const struct neighbours *n, unsigned rank)
{
    unsigned at = n->count < rank ? n->count : rank;
    return at > 0 ? sqrt(n->distance[at - 1]) : 0;
}

void surrounding_of(const struct neighbour_tree *tree, size_t i, struct surrounding *s)
{
    struct neighbours n;
    struct plane plane;
    unsigned k = SURROUND_NEAREST;
    neighbours_of(tree, i, k, &n);
    for (unsigned j = 0; j < SURROUND_GRAPH; j++)
        s->neighbour[j] = j < n.count ? n.id[j] : NO_NEIGHBOUR;
    s->spacing = distance_of_rank(&n, rank_of_spacing(tree->count));
    fit_plane(tree, i, &n, &plane);
    bool line = on_a_line(&plane);
    double direction[3];
    memcpy(direction, plane.vector[2], sizeof direction);
    while (on_a_line(&plane) && k < MAX_NEAREST && n.count == k) {
        k = k < MAX_NEAREST / 2 ? MAX_NEAREST / 2 : MAX_NEAREST;
        neighbours_of(tree, i, k, &n);
        fit_plane(tree, i, &n, &plane);
    }
    if (line && !on_a_line(&plane)) {
        double off = distance_off_line(tree, i, &n, direction);
        s->spacing = off <= WIRE * s->spacing ? fmax(s->spacing, off) : s->spacing;
    }
    bool flat = plane.value[1] > NO_PLANE * plane.value[2];
    for (int axis = 0; axis < 3; axis++)
        s->normal[axis] = flat ? plane.vector[0][axis] : 0;
}

struct find {
    const struct neighbour_tree *tree;
    struct surroundings *all;
    size_t first;
};

static void find_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct find *f = context;
    for (size_t i = f->first + begin; i < f->first + end; i++) {
        struct surrounding s;
        surrounding_of(f->tree, i, &s);
        f->all->spacing[i] = (float)s.spacing;
        memcpy(f->all->neighbour[i], s.neighbour, sizeof s.neighbour);
        for (int axis = 0; f->all->normal && axis < 3; axis++)
            f->all->normal[i][axis] = (float)s.normal[axis];
    }
}

enum stp_result surroundings_find(const struct stp_env *env, const struct neighbour_tree *tree,
                                  bool want_normal, struct surroundings *all)
{
    struct surroundings found = { .spacing = mem_alloc(tree->count, sizeof(float)),
                                  .neighbour = mem_alloc(tree->count, sizeof *found.neighbour) };
    if (want_normal)
        found.normal = mem_alloc(tree->count, sizeof *found.normal);
    if (!found.spacing || !found.neighbour || (want_normal && !found.normal)) {
        surroundings_release(&found);
        return log_no_memory(env, tree->count * sizeof *found.neighbour, "neighbours");
    }
    for (size_t first = 0; first < tree->count; first += SLICE) {
        size_t left = tree->count - first;
        struct find find = { tree, &found, first };
        parallel_for(env, left < SLICE ? left : SLICE, 1024, find_range, &find);
        log_progress(env, "neighbours",
                     1 - (double)(left < SLICE ? 0 : left - SLICE) / (double)tree->count);
    }
    *all = found;
    return STP_OK;
}

void surroundings_release(struct surroundings *all)
{
    mem_free(all->normal);
    mem_free(all->spacing);
    mem_free(all->neighbour);
    *all = (struct surroundings){ 0 };
}
