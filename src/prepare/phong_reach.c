#include "prepare/phong_reach.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

#define CONE  0.26 /* cosine, 75 degrees: beyond it the linear field is of no use */
#define FAR   4.0  /* tolerances from the plane: in the way whatever plane is fitted */
#define SEED  (-1.0)
#define CROWD 48 /* sites in a bucket */

enum stp_result reach_open(struct reach *r, const struct fit_cloud *cloud,
                           const struct fit_limits *limits)
{
    *r = (struct reach){ .cloud = cloud,
                         .limits = limits,
                         .stamp = mem_zalloc(cloud->count, sizeof *r->stamp) };
    return r->stamp ? STP_OK : STP_ERROR_MEMORY;
}

void reach_release(struct reach *r)
{
    mem_free(r->stamp);
    mem_free(r->list);
    mem_free(r->sorted);
    mem_free(r->bucket);
    *r = (struct reach){ 0 };
}

static bool make_room(struct reach *r, size_t count)
{
    if (count < r->capacity)
        return true;
    size_t capacity = r->capacity ? 2 * r->capacity : 256;
    struct reached *list = mem_realloc(r->list, capacity, sizeof *list);
    r->list = list ? list : r->list;
    struct reached *sorted = mem_realloc(r->sorted, capacity, sizeof *sorted);
    r->sorted = sorted ? sorted : r->sorted;
    uint32_t *bucket = mem_realloc(r->bucket, capacity, sizeof *bucket);
    r->bucket = bucket ? bucket : r->bucket;
    if (!list || !sorted || !bucket)
        return false;
    r->capacity = capacity;
    return true;
}

static bool same_color(const struct reach *r, uint32_t a, uint32_t b)
{
    const struct splats *s = r->cloud->samples;
    const float *p, *q;
    size_t i = r->cloud->first[a], j = r->cloud->first[b];
    if (s->opacity && s->opacity[i] != s->opacity[j])
        return false;
    if (!s->color || isinf(r->limits->color))
        return true;
    p = s->color[i];
    q = s->color[j];
    for (int c = 0; c < 3; c++)
        if (fabs((double)p[c] - (double)q[c]) > r->limits->color)
            return false;
    return true;
}

/* Does the ellipse reach site i, and on the frame's side? Sets *blocked to the metric of a site
 * that is so far off the plane that no patch can hold it. */
static bool is_reached(const struct reach *r, const struct ellipse *e, uint32_t seed, uint32_t i,
                       double *metric, double *blocked)
{
    const struct site *site = &r->cloud->site[i];
    struct vec3 d = v3_sub(v3_load(site->p), e->frame.c);
    double s = v3_dot(d, e->frame.u) / e->radius[0], t = v3_dot(d, e->frame.v) / e->radius[1];
    *metric = s * s + t * t;
    if (*metric > 1)
        return false;
    if (v3_dot(site_normal(r->cloud, i, e->frame.n), e->frame.n) < CONE)
        return false;
    if (fabs(v3_dot(d, e->frame.n)) > FAR * r->limits->tolerance || !same_color(r, seed, i)) {
        *blocked = fmin(*blocked, *metric);
        return false;
    }
    return true;
}

size_t reach_collect(struct reach *r, const struct ellipse *e, uint32_t seed, size_t most,
                     double *blocked)
{
    size_t count = 1;
    r->tick++;
    r->stamp[seed] = r->tick;
    *blocked = INFINITY;
    if (!make_room(r, 1))
        return 0;
    r->list[0] = (struct reached){ SEED, seed };
    for (size_t head = 0; head < count && count < most; head++) {
        const uint32_t *near = r->cloud->near[r->list[head].site];
        for (unsigned k = 0; k < SITE_NEAR; k++) {
            double metric;
            if (near[k] == NO_SITE || r->stamp[near[k]] == r->tick)
                continue;
            r->stamp[near[k]] = r->tick;
            if (!is_reached(r, e, seed, near[k], &metric, blocked))
                continue;
            if (!make_room(r, count + 1))
                return 0;
            r->list[count++] = (struct reached){ metric, near[k] };
        }
    }
    return count;
}

static bool is_after(struct reached a, struct reached b)
{
    return a.metric != b.metric ? a.metric > b.metric : a.site > b.site;
}

static int by_metric(const void *a, const void *b)
{
    const struct reached *p = a, *q = b;
    return is_after(*p, *q) - is_after(*q, *p);
}

static void insert_all(struct reached *list, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        struct reached moved = list[i];
        size_t at = i;
        for (; at > 0 && is_after(list[at - 1], moved); at--)
            list[at] = list[at - 1];
        list[at] = moved;
    }
}

static size_t bucket_of(double metric, double scale, size_t count)
{
    double at = metric * scale;
    return !(at > 0) ? 0 : at >= (double)count ? count - 1 : (size_t)at;
}

/* Metrics of even samples are even from 0 to the farthest: as many buckets as sites put nearly
 * every site in its place, and insertion does the rest. Where some bucket is crowded all are sorted
 * by comparison. */
void reached_sort(struct reached *list, size_t count, struct reached *room, uint32_t *bucket)
{
    double farthest = 0;
    uint32_t crowd = 0, begin = 0;
    for (size_t i = 0; i < count; i++)
        farthest = fmax(farthest, list[i].metric);
    double scale = farthest > 0 ? (double)count / farthest : 0;
    memset(bucket, 0, count * sizeof *bucket);
    for (size_t i = 0; i < count; i++) {
        uint32_t size = ++bucket[bucket_of(list[i].metric, scale, count)];
        crowd = size > crowd ? size : crowd;
    }
    if (crowd > CROWD) {
        qsort(list, count, sizeof *list, by_metric);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        uint32_t size = bucket[i];
        bucket[i] = begin;
        begin += size;
    }
    for (size_t i = 0; i < count; i++)
        room[bucket[bucket_of(list[i].metric, scale, count)]++] = list[i];
    memcpy(list, room, count * sizeof *list);
    insert_all(list, count);
}

size_t reach_sort(struct reach *r, size_t count, double below)
{
    size_t kept = 0;
    for (size_t k = 0; k < count; k++)
        if (r->list[k].metric < below)
            r->list[kept++] = r->list[k];
    reached_sort(r->list, kept, r->sorted, r->bucket);
    return kept;
}
