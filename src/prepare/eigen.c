#include "prepare/eigen.h"

#include <math.h>

/* Rotates rows and columns p and q so that a[p][q] becomes 0. */
static void rotate(double a[3][3], double v[3][3], int p, int q)
{
    double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    double t = copysign(1.0, theta) / (fabs(theta) + sqrt(theta * theta + 1));
    double c = 1 / sqrt(t * t + 1), s = t * c;
    int r = 3 - p - q;
    double apq = a[p][q], arp = a[r][p], arq = a[r][q];
    a[p][p] -= t * apq;
    a[q][q] += t * apq;
    a[p][q] = a[q][p] = 0;
    a[r][p] = a[p][r] = c * arp - s * arq;
    a[r][q] = a[q][r] = s * arp + c * arq;
    for (int i = 0; i < 3; i++) {
        double vp = v[p][i], vq = v[q][i];
        v[p][i] = c * vp - s * vq;
        v[q][i] = s * vp + c * vq;
    }
}

static void swap_if_greater(double value[3], double vector[3][3], int i, int j)
{
    if (value[i] <= value[j])
        return;
    double keep = value[i];
    value[i] = value[j];
    value[j] = keep;
    for (int k = 0; k < 3; k++) {
        keep = vector[i][k];
        vector[i][k] = vector[j][k];
        vector[j][k] = keep;
    }
}

void eigen_symmetric(const double s[6], double value[3], double vector[3][3])
{
    double a[3][3] = { { s[0], s[1], s[2] }, { s[1], s[3], s[4] }, { s[2], s[4], s[5] } };
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            vector[i][j] = i == j;
    double small = 1e-17 * (fabs(s[0]) + fabs(s[3]) + fabs(s[5]));
    for (int sweep = 0; sweep < 12; sweep++) {
        if (fabs(a[0][1]) + fabs(a[0][2]) + fabs(a[1][2]) <= small)
            break;
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++)
                if (a[p][q] != 0)
                    rotate(a, vector, p, q);
    }
    for (int i = 0; i < 3; i++)
        value[i] = a[i][i];
    swap_if_greater(value, vector, 0, 1);
    swap_if_greater(value, vector, 1, 2);
    swap_if_greater(value, vector, 0, 1);
}
