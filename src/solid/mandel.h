/* mandel: symmetric tensors as vectors in Mandel notation, and symmetric matrices between them.
 *
 * A tensor is its diagonal and then what lies off it times the root of 2, so that a.b = A:B. A matrix is its lower
 * triangle, row by row.
 */
#ifndef PD_MANDEL_H
#define PD_MANDEL_H
#include "core/vec.h"

#ifdef PDI_INTERNAL
/* Entries of a symmetric matrix between such vectors. */
#define PDI_MANDEL_MATRIX_SIZE (PDI_SYM_COMPONENTS * (PDI_SYM_COMPONENTS + 1) / 2)
#define PDI_MANDEL_SQRT2 1.41421356237309504880

/* Index in the vector of the tensor entry in row p and column q <= p. */
PDI_INLINE int pdi_mandel_index(int p, int q) { return p == q ? p : PD_DIM + p * (p - 1) / 2 + q; }

/* v = x x^T as a Mandel vector [PDI_SYM_COMPONENTS]. */
static inline void pdi_mandel_dyad(const double *x, double *v)
{
    int k = PD_DIM;
    for (int p = 0; p < PD_DIM; p++) {
        v[p] = x[p] * x[p];
        for (int q = 0; q < p; q++) v[k++] = PDI_MANDEL_SQRT2 * x[p] * x[q];
    }
}

/* a : b of two Mandel vectors. */
static inline double pdi_mandel_dot(const double *a, const double *b)
{
    double sum = 0.0;
    for (int k = 0; k < PDI_SYM_COMPONENTS; k++) sum += a[k] * b[k];
    return sum;
}

/* Trace of a Mandel vector. */
static inline double pdi_mandel_trace(const double *a)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += a[d];
    return sum;
}

/* y = L x of a symmetric matrix L [PDI_MANDEL_MATRIX_SIZE], stored as its lower triangle row by row; y is not x. */
static inline void pdi_mandel_multiply(const double *matrix, const double *x, double *y)
{
    for (int a = 0; a < PDI_SYM_COMPONENTS; a++) {
        y[a] = *matrix++ * x[0];
        for (int b = 1; b <= a; b++) y[a] += *matrix++ * x[b];
        for (int b = 0; b < a; b++) y[b] += matrix[b - a - 1] * x[a];
    }
}
#endif

#endif
