#include "plan/fit.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>

#define MOST_TERMS 16
#define SWEEPS     20000
#define STILL      1e-12 /* relative change of a sweep */

/* The normal equations, every term scaled to a length of 1. */
struct normal {
    double a[MOST_TERMS][MOST_TERMS], b[MOST_TERMS], scale[MOST_TERMS];
};

static void build(size_t rows, unsigned terms, const double *amount, const double *measured,
                  struct normal *n)
{
    *n = (struct normal){ 0 };
    for (size_t i = 0; i < rows; i++)
        for (unsigned t = 0; t < terms; t++) {
            double x = amount[i * terms + t];
            n->b[t] += x;
            for (unsigned u = 0; u < terms; u++)
                n->a[t][u] += x * amount[i * terms + u] / measured[i];
        }
    for (unsigned t = 0; t < terms; t++)
        n->scale[t] = n->a[t][t] > 0 ? 1 / sqrt(n->a[t][t]) : 0;
    for (unsigned t = 0; t < terms; t++) {
        n->b[t] *= n->scale[t];
        for (unsigned u = 0; u < terms; u++)
            n->a[t][u] *= n->scale[t] * n->scale[u];
    }
}

/* What known prices are multiplied by to suit the rows; x0: the known ones, scaled. */
static double suit(const struct normal *n, unsigned terms, const double *x0)
{
    double along = 0, square = 0;
    for (unsigned t = 0; t < terms; t++) {
        along += n->b[t] * x0[t];
        for (unsigned u = 0; u < terms; u++)
            square += x0[t] * n->a[t][u] * x0[u];
    }
    return square > 0 ? fmax(0, along / square) : 0;
}

/* Every term's own entry is 1 once scaled, so trust is one number for all of them. */
static double add_trust(struct normal *n, unsigned terms, const double *known)
{
    double x0[MOST_TERMS];
    for (unsigned t = 0; t < terms; t++)
        x0[t] = n->scale[t] > 0 ? known[t] / n->scale[t] : 0;
    double s = suit(n, terms, x0);
    for (unsigned t = 0; t < terms; t++) {
        n->a[t][t] += FIT_TRUST;
        n->b[t] += FIT_TRUST * s * x0[t];
    }
    return s;
}

/* Coordinate descent: the problem is convex, so cutting at 0 as it goes finds the minimum. */
static void descend(const struct normal *n, unsigned terms, double *x)
{
    bool moves = true;
    for (int sweep = 0; sweep < SWEEPS && moves; sweep++) {
        moves = false;
        for (unsigned t = 0; t < terms; t++) {
            if (n->scale[t] == 0)
                continue;
            double slope = n->b[t];
            for (unsigned u = 0; u < terms; u++)
                slope -= n->a[t][u] * x[u];
            double next = fmax(0, x[t] + slope / n->a[t][t]);
            moves = moves || fabs(next - x[t]) > STILL * (fabs(next) + STILL);
            x[t] = next;
        }
    }
}

void fit_prices(size_t rows, unsigned terms, const double *amount, const double *measured,
                const double *known, double *price)
{
    struct normal n;
    double x[MOST_TERMS] = { 0 };
    assert(terms <= MOST_TERMS);
    build(rows, terms, amount, measured, &n);
    double s = known ? add_trust(&n, terms, known) : 0;
    descend(&n, terms, x);
    for (unsigned t = 0; t < terms; t++)
        price[t] = n.scale[t] > 0 ? x[t] * n.scale[t] : known ? s * known[t] : 0;
}
