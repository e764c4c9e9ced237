#include "prepare/phong_sides.h"

#include <math.h>
#include <string.h>

#include "prepare/eigen.h"

#define SETTLE 6 /* rounds of k-planes */

/* Is j there already? `met` has a bit for each remainder of those that are. */
static bool is_gathered(const struct ball *b, const uint64_t met[4], uint32_t j)
{
    if (!(met[j % 256 / 64] >> j % 64 & 1))
        return false;
    for (unsigned m = 0; m < b->count; m++)
        if (b->site[m] == j)
            return true;
    return false;
}

void ball_gather(const struct fit_cloud *cloud, uint32_t i, struct ball *b)
{
    struct vec3 middle = v3_load(cloud->site[i].p);
    double sum = 0;
    uint64_t met[4] = { 0 };
    met[i % 256 / 64] |= (uint64_t)1 << i % 64;
    b->count = 1;
    b->site[0] = i;
    b->p[0] = v3(0, 0, 0);
    for (unsigned head = 0; head < b->count && b->count < BALL_MOST; head++)
        for (unsigned k = 0; k < SITE_NEAR && b->count < BALL_MOST; k++) {
            uint32_t j = cloud->near[b->site[head]][k];
            if (j == NO_SITE || is_gathered(b, met, j))
                continue;
            met[j % 256 / 64] |= (uint64_t)1 << j % 64;
            b->p[b->count] = v3_sub(v3_load(cloud->site[j].p), middle);
            sum += v3_dot(b->p[b->count], b->p[b->count]);
            b->site[b->count++] = j;
        }
    b->radius = sqrt(sum / b->count);
}

bool side_fit(const struct ball *b, unsigned side, struct fit_plane *plane, double *deviation)
{
    struct vec3 sum = v3(0, 0, 0);
    double s[6] = { 0 }, value[3], vector[3][3], n = 0;
    for (unsigned k = 0; k < b->count; k++) {
        struct vec3 p = b->p[k];
        if (side != MOST_SIDES && b->side[k] != side)
            continue;
        n += 1;
        sum = v3_add(sum, p);
        s[0] += p.x * p.x;
        s[1] += p.x * p.y;
        s[2] += p.x * p.z;
        s[3] += p.y * p.y;
        s[4] += p.y * p.z;
        s[5] += p.z * p.z;
    }
    if (n < SIDE_FEWEST)
        return false;
    struct vec3 m = v3_scale(sum, 1 / n);
    double mean[6] = { m.x * m.x, m.x * m.y, m.x * m.z, m.y * m.y, m.y * m.z, m.z * m.z };
    for (int i = 0; i < 6; i++)
        s[i] = s[i] / n - mean[i];
    eigen_symmetric(s, value, vector);
    plane->n = v3_load(vector[0]);
    plane->d = -v3_dot(plane->n, m);
    *deviation = sqrt(fmax(value[0], 0));
    return value[1] > 1e-4 * value[2];
}

/* Every site to the nearest plane; returns whether any changed. */
static bool assign(struct ball *b, const struct sides *s)
{
    bool changed = false;
    for (unsigned k = 0; k < b->count; k++) {
        unsigned best = 0;
        for (unsigned i = 1; i < s->count; i++)
            if (off_plane(&s->plane[i], b->p[k]) < off_plane(&s->plane[best], b->p[k]))
                best = i;
        changed |= b->side[k] != best;
        b->side[k] = (unsigned char)best;
    }
    return changed;
}

static bool settle(struct ball *b, struct sides *s)
{
    memset(b->side, 0xff, sizeof b->side);
    for (int round = 0; round < SETTLE && assign(b, s); round++)
        for (unsigned i = 0; i < s->count; i++)
            if (!side_fit(b, i, &s->plane[i], &s->deviation[i]))
                return false;
    double sum = 0;
    for (unsigned k = 0; k < b->count; k++) {
        double off = off_plane(&s->plane[b->side[k]], b->p[k]);
        sum += off * off;
    }
    s->all = sqrt(sum / b->count);
    return true;
}

unsigned ball_most_unlike(const struct fit_cloud *cloud, const struct ball *b,
                          const struct vec3 *normal, unsigned count)
{
    unsigned best = 0;
    double least = INFINITY;
    for (unsigned k = 0; k < b->count; k++) {
        struct vec3 n = v3_loadf(cloud->site[b->site[k]].n);
        double most = -1;
        for (unsigned i = 0; i < count; i++) {
            double dot = v3_dot(n, normal[i]);
            most = fmax(most, cloud->signs ? dot : fabs(dot));
        }
        if (most < least) {
            least = most;
            best = k;
        }
    }
    return best;
}

bool sides_split(const struct fit_cloud *cloud, struct ball *b, unsigned count, struct sides *s)
{
    struct vec3 normal[MOST_SIDES] = { v3_loadf(cloud->site[b->site[0]].n) };
    s->count = count;
    for (unsigned i = 0; i < count; i++) {
        unsigned k = ball_most_unlike(cloud, b, normal, i > 0 ? i : 1);
        normal[i] = v3_loadf(cloud->site[b->site[k]].n);
        s->plane[i] = (struct fit_plane){ normal[i], -v3_dot(normal[i], b->p[k]) };
    }
    return settle(b, s);
}
