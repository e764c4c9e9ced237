#include "prepare/phong_field.h"

#include <math.h>

/* Of the larger eigenvalue: below, it counts as 0. A slope between samples so near each other would
 * be the noise of their normals, drawn out over the whole ellipse. */
#define RANK 0.02

/* Eq. 3: (n, sum u; sum u, sum u^2) (mean, slope) = (sum z, sum z u), by the pseudo-inverse of the
 * matrix: through its eigenvalues, of which it inverts those that are not 0. */
static void solve_system(double n, double u, double uu, double z, double zu, double solution[2])
{
    double half = 0.5 * (n - uu), root = hypot(half, u), mean = 0.5 * (n + uu);
    double value[2] = { mean + root, mean - root };
    double angle = 0.5 * atan2(2 * u, n - uu);
    double vector[2][2] = { { cos(angle), sin(angle) }, { -sin(angle), cos(angle) } };
    solution[0] = solution[1] = 0;
    value[1] = value[0] > 0 ? (n * uu - u * u) / value[0] : 0; /* less rounding than mean - root */
    for (int i = 0; i < 2; i++) {
        if (!(value[i] > RANK * value[0]))
            continue;
        double along = (vector[i][0] * z + vector[i][1] * zu) / value[i];
        solution[0] += along * vector[i][0];
        solution[1] += along * vector[i][1];
    }
}

void field_fit(const struct field_sample *sample, size_t count, bool flat, double field[4])
{
    double s = 0, ss = 0, t = 0, tt = 0, x = 0, xs = 0, y = 0, yt = 0, n = 0;
    for (size_t k = 0; k < count; k++) {
        const struct field_sample *p = &sample[k];
        double w = p->weight;
        n += w;
        s += w * p->s;
        ss += w * p->s * p->s;
        t += w * p->t;
        tt += w * p->t * p->t;
        x += w * p->x;
        xs += w * p->x * p->s;
        y += w * p->y;
        yt += w * p->y * p->t;
    }
    if (flat)
        s = ss = t = tt = xs = yt = 0;
    solve_system(n, s, ss, x, xs, field);
    solve_system(n, t, tt, y, yt, field + 2);
}
