/* strain: symmetric tensors as vectors, and symmetric matrices between them.
 *
 * A tensor is its diagonal and then what lies off it times the root of 2, so that a.b = A:B. A matrix is its lower
 * triangle, row by row.
 */
#ifndef PD_STRAIN_H
#define PD_STRAIN_H
#include "core/vec.h"

#ifdef PDI_INTERNAL
#define PDI_STRAIN_PACK (PDI_SYM * (PDI_SYM + 1) / 2)
#define PDI_STRAIN_ROOT2 1.41421356237309504880

/* Where a tensor has its entry of row p and column q <= p. */
PDI_INLINE int pdi_strain_place(int p, int q) { return p == q ? p : PD_DIM + p * (p - 1) / 2 + q; }

/* x x^T. */
static inline void pdi_strain_dyad(const double *x, double *v)
{
    int k = PD_DIM;
    for (int p = 0; p < PD_DIM; p++) {
        v[p] = x[p] * x[p];
        for (int q = 0; q < p; q++) v[k++] = PDI_STRAIN_ROOT2 * x[p] * x[q];
    }
}

static inline double pdi_strain_dot(const double *a, const double *b)
{
    double sum = 0.0;
    for (int k = 0; k < PDI_SYM; k++) sum += a[k] * b[k];
    return sum;
}

static inline double pdi_strain_trace(const double *a)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += a[d];
    return sum;
}

/* y = L x. */
static inline void pdi_strain_times(const double *law, const double *x, double *y)
{
    for (int a = 0; a < PDI_SYM; a++) {
        y[a] = *law++ * x[0];
        for (int b = 1; b <= a; b++) y[a] += *law++ * x[b];
        for (int b = 0; b < a; b++) y[b] += law[b - a - 1] * x[a];
    }
}
#endif

#endif
