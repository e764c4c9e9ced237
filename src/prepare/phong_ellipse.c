/* With a = 1 / rx, b = 1 / ry, p = a cx, q = b cy: minimise -ln a - ln b where
 * (a x - p)^2 + (b y - q)^2 <= 1 for each point: convex in (a, b, p, q). An interior-point method
 * solves it for a working set: at the centre of the barrier for mu the area is within a factor of
 * exp(m mu) of the least, m the points of the set (Boyd & Vandenberghe, Convex Optimization, 11.2).
 * The farthest points outside join the set until there are none: each time the least area grows,
 * so that no set comes twice. */
#include "prepare/phong_ellipse.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define DIRECTIONS 8  /* the working set starts with the extreme points in them, both ways */
#define WORKING    64 /* most points of it */
#define NEWTON     50

/* Slacks are differences of numbers about 1: multiples of 2^-53. */
#define LEAST_PRODUCT 1e-280

struct working_set {
    size_t count;
    double point[WORKING][2]; /* scaled: the bounding box is [-1, 1]^2 */
    size_t id[WORKING];
    double floor[2]; /* least semi-axes, scaled */
};

/* theta = a, b, p, q. The slack of a point, and its two components. */
static double slack_of(const double theta[4], const double point[2], double *e, double *h)
{
    *e = theta[0] * point[0] - theta[2];
    *h = theta[1] * point[1] - theta[3];
    return 1 - *e * *e - *h * *h;
}

/* -ln a - ln b - mu sum ln slack; INFINITY outside. A logarithm of several slacks' product costs
 * less, and none is so small that it could underflow. */
static double barrier(const struct working_set *w, const double theta[4], double mu)
{
    double e, h, sum, product = 1;
    if (!(theta[0] > 0 && theta[1] > 0))
        return INFINITY;
    sum = -log(theta[0]) - log(theta[1]);
    for (int i = 0; i < 2; i++) {
        double slack = 1 - theta[i] * w->floor[i];
        if (!(slack > 0))
            return INFINITY;
        sum -= mu * log(slack);
    }
    for (size_t k = 0; k < w->count; k++) {
        double slack = slack_of(theta, w->point[k], &e, &h);
        if (!(slack > 0))
            return INFINITY;
        product *= slack;
        if (product < LEAST_PRODUCT) {
            sum -= mu * log(product);
            product = 1;
        }
    }
    return sum - mu * log(product);
}

/* Gradient and Hessian. */
static void derive(const struct working_set *w, const double theta[4], double mu, double g[4],
                   double hessian[4][4])
{
    memset(g, 0, 4 * sizeof *g);
    memset(hessian, 0, 4 * sizeof *hessian);
    for (int i = 0; i < 2; i++) {
        double pull = w->floor[i] / (1 - theta[i] * w->floor[i]);
        g[i] = -1 / theta[i] + mu * pull;
        hessian[i][i] = 1 / (theta[i] * theta[i]) + mu * pull * pull;
    }
    for (size_t k = 0; k < w->count; k++) {
        double e, h, x = w->point[k][0], y = w->point[k][1];
        double slack = slack_of(theta, w->point[k], &e, &h), scale = 2 * mu / slack;
        double d[4] = { 2 * e * x / slack, 2 * h * y / slack, -2 * e / slack, -2 * h / slack };
        for (int i = 0; i < 4; i++) {
            g[i] += mu * d[i];
            for (int j = 0; j < 4; j++)
                hessian[i][j] += mu * d[i] * d[j];
        }
        hessian[0][0] += scale * x * x;
        hessian[0][2] -= scale * x;
        hessian[2][0] -= scale * x;
        hessian[2][2] += scale;
        hessian[1][1] += scale * y * y;
        hessian[1][3] -= scale * y;
        hessian[3][1] -= scale * y;
        hessian[3][3] += scale;
    }
}

/* x of m x = b by Cholesky's factors in place; false: m is not positive definite. */
static bool solve(double m[4][4], const double b[4], double x[4])
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j <= i; j++) {
            double sum = m[i][j];
            for (int k = 0; k < j; k++)
                sum -= m[i][k] * m[j][k];
            if (i == j && !(sum > 0))
                return false;
            m[i][j] = i == j ? sqrt(sum) : sum / m[j][j];
        }
    for (int i = 0; i < 4; i++) {
        x[i] = b[i];
        for (int k = 0; k < i; k++)
            x[i] -= m[i][k] * x[k];
        x[i] /= m[i][i];
    }
    for (int i = 3; i >= 0; i--) {
        for (int k = i + 1; k < 4; k++)
            x[i] -= m[k][i] * x[k];
        x[i] /= m[i][i];
    }
    return true;
}

/* Damped Newton steps to the centre of the barrier. */
static void centre_barrier(const struct working_set *w, double theta[4], double mu)
{
    double now = barrier(w, theta, mu), then;
    for (int round = 0; round < NEWTON; round++) {
        double g[4], hessian[4][4], step[4], next[4], slope = 0, length = 1;
        derive(w, theta, mu, g, hessian);
        if (!solve(hessian, g, step))
            return;
        for (int i = 0; i < 4; i++)
            slope += g[i] * step[i];
        if (slope <= 1e-4 * mu)
            return;
        do {
            for (int i = 0; i < 4; i++)
                next[i] = theta[i] - length * step[i];
            length *= 0.5;
            then = barrier(w, next, mu);
        } while (length > 1e-12 && !(then <= now - 0.2 * length * slope));
        if (length <= 1e-12)
            return;
        now = then;
        memcpy(theta, next, sizeof next);
    }
}

static void solve_set(const struct working_set *w, double theta[4])
{
    double least = 0.2 * ELLIPSE_TOLERANCE / (double)(w->count + 2);
    theta[0] = fmin(0.5, 0.5 / w->floor[0]); /* holds the box [-1, 1]^2 strictly */
    theta[1] = fmin(0.5, 0.5 / w->floor[1]);
    theta[2] = theta[3] = 0;
    for (double mu = 0.1;; mu *= 0.02) {
        mu = fmax(mu, least);
        centre_barrier(w, theta, mu);
        if (mu == least)
            return;
    }
}

struct box {
    double middle[2], half[2];
};

static struct box box_of(const double (*point)[2], size_t count, double floor)
{
    struct box b;
    for (int i = 0; i < 2; i++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k < count; k++) {
            low = fmin(low, point[k][i]);
            high = fmax(high, point[k][i]);
        }
        b.middle[i] = 0.5 * (low + high);
        b.half[i] = fmax(0.5 * (high - low), 0.5 * floor);
    }
    return b;
}

static void add_point(struct working_set *w, const struct box *b, const double (*point)[2],
                      size_t id)
{
    for (size_t k = 0; k < w->count; k++)
        if (w->id[k] == id)
            return;
    w->id[w->count] = id;
    for (int i = 0; i < 2; i++)
        w->point[w->count][i] = (point[id][i] - b->middle[i]) / b->half[i];
    w->count++;
}

static void add_extremes(struct working_set *w, const struct box *b, const double (*point)[2],
                         size_t count)
{
    for (int d = 0; d < DIRECTIONS; d++) {
        double x = cos(3.14159265358979 * d / DIRECTIONS) / b->half[0];
        double y = sin(3.14159265358979 * d / DIRECTIONS) / b->half[1];
        double least = INFINITY, most = -INFINITY;
        size_t first = 0, last = 0;
        for (size_t k = 0; k < count; k++) {
            double along = x * point[k][0] + y * point[k][1];
            if (along < least) {
                least = along;
                first = k;
            }
            if (along > most) {
                most = along;
                last = k;
            }
        }
        add_point(w, b, point, first);
        add_point(w, b, point, last);
    }
}

/* The point that is farthest out; returns s^2 + t^2 of it. */
static double farthest(const double (*point)[2], size_t count, const double center[2],
                       const double radius[2], size_t *id)
{
    double most = -1;
    *id = 0;
    for (size_t k = 0; k < count; k++) {
        double s = (point[k][0] - center[0]) / radius[0], t = (point[k][1] - center[1]) / radius[1];
        if (s * s + t * t > most) {
            most = s * s + t * t;
            *id = k;
        }
    }
    return most;
}

void ellipse_enclose(const double (*point)[2], size_t count, double floor, double center[2],
                     double radius[2])
{
    struct box box = box_of(point, count, floor);
    struct working_set w = { .floor = { floor / box.half[0], floor / box.half[1] } };
    double theta[4], out;
    add_extremes(&w, &box, point, count);
    for (;;) {
        size_t id;
        solve_set(&w, theta);
        for (int i = 0; i < 2; i++) {
            radius[i] = box.half[i] / theta[i];
            center[i] = box.middle[i] + theta[i + 2] * radius[i];
        }
        out = farthest(point, count, center, radius, &id);
        if (out <= 1 + 0.2 * ELLIPSE_TOLERANCE || w.count == WORKING)
            break;
        size_t before = w.count;
        add_point(&w, &box, point, id);
        if (w.count == before)
            break; /* it is in the set already: rounding */
    }
    while (out > 1) { /* by rounding, or the little that is allowed */
        size_t id;
        double grow = sqrt(out) * (1 + 1e-15);
        radius[0] *= grow;
        radius[1] *= grow;
        out = farthest(point, count, center, radius, &id);
    }
}
