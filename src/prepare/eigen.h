/* Eigenvectors of a symmetric 3x3 matrix. */
#ifndef STP_PREPARE_EIGEN_H
#define STP_PREPARE_EIGEN_H

/* a = xx, xy, xz, yy, yz, zz. Values ascending; vector[i] is the unit eigenvector of value[i].
 * Cyclic Jacobi: right for repeated and zero values too. */
void eigen_symmetric(const double a[6], double value[3], double vector[3][3]);

#endif
