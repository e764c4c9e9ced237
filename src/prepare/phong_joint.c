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

struct worker {
    uint32_t *stamp, tick; /* of sites, NULL: not made yet */
    uint32_t *list;
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
    struct shown *shown;       /* a splat */
    _Atomic int64_t (*sum)[4]; /* a site: of weights, and of weighted normals */
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
    w->capacity = list && sample ? capacity : w->capacity;
    return list && sample;
}

/* --- which sites a splat shows -------------------------------------------------------------------
 */

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

/* --- a round -------------------------------------------------------------------------------------
 */

/* The splat's normal there, on the side of the site's own, and its weight in the mean. */
static struct vec3 shown_normal(const struct joint *j, const struct face *f, const struct site *s,
                                struct on_face *at, double *weight)
{
    *at = face_place(f, v3_load(s->p));
    *weight = fmax(1 - at->s * at->s - at->t * at->t, 1e-6);
    struct vec3 n = face_normal(f, *at);
    return !j->cloud->signs && v3_dot(n, v3_loadf(s->n)) < 0 ? v3_scale(n, -1) : n;
}

static void add_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct joint *j = context;
    for (size_t i = begin; i < end; i++) {
        struct face f = face_of(j->splats, i, j->cloud->origin);
        for (uint32_t k = 0; k < j->shown[i].count; k++) {
            uint32_t site = j->shown[i].site[k];
            struct on_face at;
            double weight;
            struct vec3 n = shown_normal(j, &f, &j->cloud->site[site], &at, &weight);
            double term[4] = { weight, weight * n.x, weight * n.y, weight * n.z };
            for (int c = 0; c < 4; c++)
                atomic_fetch_add_explicit(&j->sum[site][c], (int64_t)(ONE * term[c]),
                                          memory_order_relaxed);
        }
    }
}

/* What the splat should show at a site: what it shows, and what the mean lacks. False: that leans
 * too far for a field. */
static bool wanted_at(const struct joint *j, const struct face *f, uint32_t site,
                      struct field_sample *out)
{
    const struct site *s = &j->cloud->site[site];
    const _Atomic int64_t *sum = j->sum[site];
    struct on_face at;
    double weight;
    struct vec3 shown = shown_normal(j, f, s, &at, &weight);
    struct vec3 mean = v3_unit(v3((double)sum[1], (double)sum[2], (double)sum[3]));
    struct vec3 wanted = v3_add(shown, v3_sub(v3_loadf(s->n), mean));
    double z = v3_dot(wanted, f->n);
    if (z < 0 && !j->cloud->signs) {
        wanted = v3_scale(wanted, -1);
        z = -z;
    }
    z /= v3_length(wanted);
    wanted = v3_unit(wanted);
    *out = (struct field_sample){ at.s, at.t, v3_dot(wanted, f->u) / z, v3_dot(wanted, f->v) / z,
                                  ONE * weight / (double)sum[0] * z * z * z * z };
    return z > ASIDE;
}

static void refit_range(void *context, size_t begin, size_t end, unsigned worker)
{
    const struct joint *j = context;
    for (size_t i = begin; i < end; i++) {
        struct worker *w = &j->worker[worker];
        struct face f = face_of(j->splats, i, j->cloud->origin);
        size_t count = 0;
        double field[4];
        if (j->set->patch[i].count < 2 || !make_room(w, j->shown[i].count)) {
            w->out_of_memory |= j->set->patch[i].count >= 2;
            continue;
        }
        for (uint32_t k = 0; k < j->shown[i].count; k++)
            count += wanted_at(j, &f, j->shown[i].site[k], &w->sample[count]);
        if (count == 0)
            continue;
        field_fit(w->sample, count, j->flat, field);
        for (int c = 0; c < 4; c++)
            j->splats->phong[i].field[c] = (float)field[c];
    }
}

/* --- all -----------------------------------------------------------------------------------------
 */

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
    }
    mem_free(j->shown);
    mem_free(j->sum);
    mem_free(j->worker);
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
                       .worker = mem_zalloc(workers, sizeof *j.worker) };
    bool failed = !j.shown || !j.sum || !j.worker;
    if (!failed) {
        parallel_for(env, set->count, GRAIN, show_range, &j);
        failed = any_failed(&j, workers);
    }
    for (int round = 0; round < ROUNDS && !failed; round++) {
        memset(j.sum, 0, cloud->count * sizeof *j.sum);
        parallel_for(env, set->count, GRAIN, add_range, &j);
        parallel_for(env, set->count, GRAIN, refit_range, &j);
        failed = any_failed(&j, workers);
    }
    release(&j, workers);
    return failed ? log_no_memory(env, cloud->count * sizeof *j.sum, "the fields of splats")
                  : STP_OK;
}
