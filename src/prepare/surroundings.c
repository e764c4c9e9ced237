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

static bool same_place(const struct neighbour_tree *t, uint32_t a, uint32_t b)
{
    return t->position[a][0] == t->position[b][0] && t->position[a][1] == t->position[b][1] &&
           t->position[a][2] == t->position[b][2];
}

static bool is_repeated(const struct neighbour_tree *t, const struct neighbours *n, unsigned j)
{
    for (unsigned k = j; k-- > 0 && n->distance[k] == n->distance[j];)
        if (same_place(t, n->id[k], n->id[j]))
            return true;
    return false;
}

/* Counts the points of one place once. *found: whether the rank was reached. */
static double distance_of_rank(const struct neighbour_tree *t, const struct neighbours *n,
                               unsigned rank, bool *found)
{
    double last = 0;
    unsigned places = 0;
    for (unsigned j = 0; j < n->count && places < rank; j++)
        if (n->distance[j] > 0 && !is_repeated(t, n, j)) {
            last = n->distance[j];
            places++;
        }
    *found = places == rank;
    return sqrt(last);
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

void surrounding_of(const struct neighbour_tree *tree, size_t i, struct surrounding *s)
{
    struct neighbours n;
    struct plane plane;
    bool found;
    unsigned rank = rank_of_spacing(tree->count), k = SURROUND_NEAREST;
    neighbours_of(tree, i, k, &n);
    for (unsigned j = 0; j < SURROUND_GRAPH; j++)
        s->neighbour[j] = j < n.count ? n.id[j] : NO_NEIGHBOUR;
    fit_plane(tree, i, &n, &plane);
    s->spacing = distance_of_rank(tree, &n, rank, &found);
    bool line = on_a_line(&plane);
    double direction[3];
    memcpy(direction, plane.vector[2], sizeof direction);
    while ((!found || on_a_line(&plane)) && k < MAX_NEAREST && n.count == k) {
        k = k < MAX_NEAREST / 2 ? MAX_NEAREST / 2 : MAX_NEAREST;
        neighbours_of(tree, i, k, &n);
        fit_plane(tree, i, &n, &plane);
        s->spacing = distance_of_rank(tree, &n, rank, &found);
    }
    if (line && !on_a_line(&plane))
        s->spacing = fmax(s->spacing, distance_off_line(tree, i, &n, direction));
    bool flat = plane.value[1] > NO_PLANE * plane.value[2];
    for (int axis = 0; axis < 3; axis++)
        s->normal[axis] = flat ? plane.vector[0][axis] : 0;
}

struct find {
    const struct neighbour_tree *tree;
    struct surroundings *all;
};

static void find_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct find *f = context;
    for (size_t i = begin; i < end; i++) {
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
    struct find find = { tree, &found };
    parallel_for(env, tree->count, 1024, find_range, &find);
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
