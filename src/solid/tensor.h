/* tensor: vectors and tensors of mechanics in loops over bonds.
 *
 * Tensors are row-major, PD_DIM x PD_DIM.
 */
#ifndef PD_TENSOR_H
#define PD_TENSOR_H
#include "core/vec.h"

#ifdef PDI_INTERNAL
enum { PDI_TENSOR = PD_DIM * PD_DIM };

/* Scalar product of two vectors. */
static inline double pdi_tensor_dot(const double *a, const double *b)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += a[d] * b[d];
    return sum;
}

/* a : b. */
static inline double pdi_tensor_double_dot(const double *a, const double *b)
{
    double sum = 0.0;
    for (int k = 0; k < PDI_TENSOR; k++) sum += a[k] * b[k];
    return sum;
}

/* y = A x; y is not x. */
static inline void pdi_tensor_multiply_vector(const double *a, const double *x, double *y)
{
    for (int p = 0; p < PD_DIM; p++) {
        y[p] = 0.0;
        for (int q = 0; q < PD_DIM; q++) y[p] += a[p * PD_DIM + q] * x[q];
    }
}

/* c = a b; c is neither a nor b. */
static inline void pdi_tensor_multiply(const double *a, const double *b, double *c)
{
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q < PD_DIM; q++) {
            double sum = 0.0;
            for (int k = 0; k < PD_DIM; k++) sum += a[p * PD_DIM + k] * b[k * PD_DIM + q];
            c[p * PD_DIM + q] = sum;
        }
}

/* c = a b^T; c is neither a nor b. */
static inline void pdi_tensor_multiply_transposed_b(const double *a, const double *b, double *c)
{
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q < PD_DIM; q++) {
            double sum = 0.0;
            for (int k = 0; k < PD_DIM; k++) sum += a[p * PD_DIM + k] * b[q * PD_DIM + k];
            c[p * PD_DIM + q] = sum;
        }
}

/* c = a^T b; c is neither a nor b. */
static inline void pdi_tensor_multiply_transposed_a(const double *a, const double *b, double *c)
{
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q < PD_DIM; q++) {
            double sum = 0.0;
            for (int k = 0; k < PD_DIM; k++) sum += a[k * PD_DIM + p] * b[k * PD_DIM + q];
            c[p * PD_DIM + q] = sum;
        }
}

/* c = det(a) a^-T, also of a singular tensor. Returns det(a). */
static inline double pdi_tensor_compute_cofactor(const double *a, double *c)
{
    if (PD_DIM == 1) c[0] = 1.0;
    if (PD_DIM == 2)
        for (int k = 0; k < PDI_TENSOR; k++) c[k] = (k == 0 || k == 3 ? 1.0 : -1.0) * a[PDI_TENSOR - 1 - k];
    if (PD_DIM == 3)
        for (int k = 0; k < PDI_TENSOR; k++) {
            int p = (k / PD_DIM + 1) % PD_DIM, r = (p + 1) % PD_DIM, q = (k + 1) % PD_DIM, s = (q + 1) % PD_DIM;
            c[k] = a[p * PD_DIM + q] * a[r * PD_DIM + s] - a[p * PD_DIM + s] * a[r * PD_DIM + q];
        }
    return pdi_tensor_dot(a, c);
}
#endif

#endif
