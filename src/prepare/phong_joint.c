/* With A the matrix that takes all fields to the means at the sites, its entries the weights'
 * shares, and n the sites' normals, |A x - n| is to be least. A splat's own matrix of Eq. 3 and 4,
 * each site weighted with its share, is a block of D, and x += D^-1 A^T (n - A x) is one round:
 * every field is fitted to what its splat shows plus what the mean lacks. As the shares of a site
 * add up to 1, |A x|^2 <= x^T D x (Jensen), so that no round makes the error larger. */
#include "prepare/phong_joint.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/thread.h"
#include "prepare/phong_face.h"
#include "prepare/phong_field.h"

#define ROUNDS 4
#define GRAIN  64
#define ONE    0x1p32 /* a weight of 1: sums of integers do not depend on their order */
#define ASIDE  0.1    /* cosine, 84 degrees: a normal tells no more of the field */

struct shown {
    uint32_t count;
    uint32_t *site; /* owned */
};

/* Where a site is on a splat, and its weight there. */
struct seen {
    struct on_face at;
    double weight;
};

struct worker {
    uint32_t *stamp, tick; /* of sites, NULL: not made yet */
    uint32_t *list;
    struct seen *seen;
    struct field_sample *sample;
    size_t capacity;
    bool out_of_memory;
};

struct joint {
    const struct fit_cloud *cloud;
    const struct patch_set *set;
    struct splats *splats;
    double depth;
    bool flat;
    struct shown *shown;        /* a splat */
    _Atomic int64_t (*sum)[4];  /* a site: of weights, and of weighted normals */
    _Atomic int64_t (*next)[4]; /* those of the next round; NULL: it is the last */
    struct worker *worker;
};

static bool make_room(struct worker *w, size_t count)
{
    if (count <= w->capacity)
        return true;
    size_t capacity = 2 * count;
    uint32_t *list = mem_realloc(w->list, capacity, sizeof *list);
    w->list = list ? list : w->list;
    struct field_sample *sample = mem_realloc(w->sample, capacity, sizeof *sample);
    w->sample = sample ? sample : w->sample;
    struct seen *seen = mem_realloc(w->seen, capacity, sizeof *seen);
    w->seen = seen ? seen : w->seen;
    bool made = list && sample && seen;
    w->capacity = made ? capacity : w->capacity;
    return made;
}

static bool is_shown(const struct joint *j, const struct face *f, uint32_t i)
{
    const struct site *site = &j->cloud->site[i];
    struct on_face at = face_place(f, v3_load(site->p));
    double dot = v3_dot(v3_loadf(site->n), f->n);
    return at.s * at.s + at.t * at.t < 1 && fabs(at.height) <= j->depth && face_keeps(f, at) &&
           (j->cloud->signs ? dot : fabs(dot)) > ASIDE;
}

static bool look_at(const struct joint *j, struct worker *w, const struct face *f, uint32_t site,
                    uint32_t *count)
{
    if (w->stamp[site] == w->tick)
        return true;
    w->stamp[site] = w->tick;
    if (!is_shown(j, f, site))
        return true;
    if (!make_room(w, *count + 1))
        return false;
    w->list[(*count)++] = site;
    return true;
}

/* The members, and what chains of neighbours within the ellipse join to them. */
static bool find_shown(const struct joint *j, struct worker *w, size_t splat)
{
    const struct patch *p = &j->set->patch[splat];
    struct face f = face_of(j->splats, splat, j->cloud->origin);
    uint32_t count = 0;
    w->tick++;
    for (uint32_t k = 0; k < p->count; k++)
        if (!look_at(j, w, &f, p->member[k], &count))
            return false;
    for (uint32_t head = 0; head < count; head++)
        for (unsigned k = 0; k < SITE_NEAR; k++) {
            uint32_t near = j->cloud->near[w->list[head]][k];
            if (near != NO_SITE && !look_at(j, w, &f, near, &count))
                return false;
        }
    struct shown *shown = &j->shown[splat];
    shown->site = mem_alloc(count, sizeof *shown->site);
    if (!shown->site)
        return false;
    memcpy(shown->site, w->list, count * sizeof *shown->site);
    shown->count = count;
    return true;
}

static void show_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct joint *j = context;
    struct worker *w = &j->worker[worker];
    if (!w->stamp && !w->out_of_memory) {
        w->stamp = mem_zalloc(j->cloud->count, sizeof *w->stamp);
        w->out_of_memory = !w->stamp || !make_room(w, 256);
    }
    for (size_t i = begin; i < end && !w->out_of_memory; i++)
        w->out_of_memory = !find_shown(j, w, i);
}

static struct seen see(const struct joint *j, const struct face *f, uint32_t site)
{
    struct on_face at = face_place(f, v3_load(j->cloud->site[site].p));
    return (struct seen){ at, fmax(1 - at.s * at.s - at.t * at.t, 1e-6) };
}

/* The splat's normal there, on the side of the site's own. */
static struct vec3 shown_normal(const struct joint *j, const struct face *f, uint32_t site,
                                struct on_face at)
{
    struct vec3 n = face_normal(f, at);
    return !j->cloud->signs && v3_dot(n, v3_loadf(j->cloud->site[site].n)) < 0 ? v3_scale(n, -1)
                                                                               : n;
}

static void add_normal(const struct joint *j, const struct face *f, uint32_t site,
                       const struct seen *seen)
{
    struct vec3 n = v3_scale(shown_normal(j, f, site, seen->at), seen->weight);
    double term[4] = { seen->weight, n.x, n.y, n.z };
    for (int c = 0; c < 4; c++)
        atomic_fetch_add_explicit(&j->next[site][c], (int64_t)(ONE * term[c]),
                                  memory_order_relaxed);
}

/* The sums of what the splats show at first. */
static void add_range(void *context, size_t begin, size_t end, unsigned)
{
    const struct joint *j = context;
    for (size_t i = begin; i < end; i++) {
        struct face f = face_of(j->splats, i, j->cloud->origin);
        for (uint32_t k = 0; k < j->shown[i].count; k++) {
            struct seen seen = see(j, &f, j->shown[i].site[k]);
            add_normal(j, &f, j->shown[i].site[k], &seen);
        }
    }
}

/* What the splat should show at a site: what it shows, and what the mean lacks. False: that leans
 * too far for a field. */
static bool wanted_at(const struct joint *j, const struct face *f, uint32_t site,
                      const struct seen *seen, struct field_sample *out)
{
    const _Atomic int64_t *sum = j->sum[site];
    struct vec3 shown = shown_normal(j, f, site, seen->at);
    struct vec3 mean = v3_unit(v3((double)sum[1], (double)sum[2], (double)sum[3]));
    struct vec3 wanted = v3_add(shown, v3_sub(v3_loadf(j->cloud->site[site].n), mean));
    double z = v3_dot(wanted, f->n);
    if (z < 0 && !j->cloud->signs) {
        wanted = v3_scale(wanted, -1);
        z = -z;
    }
    double cosine = z / v3_length(wanted), share = ONE * seen->weight / (double)sum[0];
    *out = (struct field_sample){ seen->at.s, seen->at.t, v3_dot(wanted, f->u) / z,
                                  v3_dot(wanted, f->v) / z,
                                  share * cosine * cosine * cosine * cosine };
    return cosine > ASIDE;
}

/* Fits the splat's field anew, and adds what it shows then to the next sums. */
static void refit(const struct joint *j, struct worker *w, size_t splat)
{
    const struct shown *shown = &j->shown[splat];
    struct stp_phong_splat *phong = &j->splats->phong[splat];
    struct face f = face_of(j->splats, splat, j->cloud->origin);
    size_t count = 0;
    double field[4];
    for (uint32_t k = 0; k < shown->count; k++) {
        w->seen[k] = see(j, &f, shown->site[k]);
        count += wanted_at(j, &f, shown->site[k], &w->seen[k], &w->sample[count]);
    }
    if (count > 0 && j->set->patch[splat].count > 1) {
        field_fit(w->sample, count, j->flat, field);
        for (int c = 0; c < 4; c++)
            phong->field[c] = f.phong.field[c] = (float)field[c];
    }
    for (uint32_t k = 0; j->next && k < shown->count; k++)
        add_normal(j, &f, shown->site[k], &w->seen[k]);
}

static void refit_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct joint *j = context;
    struct worker *w = &j->worker[worker];
    for (size_t i = begin; i < end && !w->out_of_memory; i++) {
        w->out_of_memory = !make_room(w, j->shown[i].count);
        if (!w->out_of_memory)
            refit(j, w, i);
    }
}

static bool any_failed(const struct joint *j, unsigned workers)
{
    bool failed = false;
    for (unsigned i = 0; i < workers; i++)
        failed |= j->worker[i].out_of_memory;
    return failed;
}

static void release(struct joint *j, unsigned workers)
{
    for (size_t i = 0; j->shown && i < j->set->count; i++)
        mem_free(j->shown[i].site);
    for (unsigned i = 0; j->worker && i < workers; i++) {
        mem_free(j->worker[i].stamp);
        mem_free(j->worker[i].list);
        mem_free(j->worker[i].sample);
        mem_free(j->worker[i].seen);
    }
    mem_free(j->shown);
    mem_free(j->sum);
    mem_free(j->next);
    mem_free(j->worker);
}

/* The next sums become those that count. */
static void turn_over(struct joint *j, bool last)
{
    _Atomic int64_t(*old)[4] = j->sum;
    j->sum = j->next;
    j->next = last ? NULL : old;
    if (last)
        mem_free(old);
    else
        memset(old, 0, j->cloud->count * sizeof *old);
}

enum stp_result fields_fit_together(const struct stp_env *env, const struct fit_cloud *cloud,
                                    const struct patch_set *set, double depth, bool flat,
                                    struct splats *splats)
{
    unsigned workers = thread_count(env);
    struct joint j = { .cloud = cloud,
                       .set = set,
                       .splats = splats,
                       .depth = depth,
                       .flat = flat,
                       .shown = mem_zalloc(set->count, sizeof *j.shown),
                       .sum = mem_alloc(cloud->count, sizeof *j.sum),
                       .next = mem_zalloc(cloud->count, sizeof *j.next),
                       .worker = mem_zalloc(workers, sizeof *j.worker) };
    bool failed = !j.shown || !j.sum || !j.next || !j.worker;
    if (!failed) {
        parallel_for(env, set->count, GRAIN, show_range, &j);
        failed = any_failed(&j, workers);
    }
    if (!failed)
        parallel_for(env, set->count, GRAIN, add_range, &j);
    for (int round = 1; round <= ROUNDS && !failed; round++) {
        turn_over(&j, round == ROUNDS);
        parallel_for(env, set->count, GRAIN, refit_range, &j);
        failed = any_failed(&j, workers);
    }
    release(&j, workers);
    return failed ? log_no_memory(env, cloud->count * sizeof *j.sum, "the fields of splats")
                  : STP_OK;
}
