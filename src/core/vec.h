/* vec: small vectors and matrices. The only place that branches on PD_DIM. */
#ifndef PD_VEC_H
#define PD_VEC_H
#include "core/config.h"

#ifdef PDI_INTERNAL
#define PDI_PI 3.14159265358979323846
/* Faraday's constant [C/mol] and the gas constant [J/mol/K], exact (CODATA 2018). */
#define PDI_FARADAY 96485.33212331001
#define PDI_GAS 8.31446261815324

#if PD_DIM == 1
#define PDI_SYM 1
#elif PD_DIM == 2
#define PDI_SYM 3
#else
#define PDI_SYM 6
#endif

PDI_FN double pdi_vec_dot(const double *a, const double *b);
PDI_FN double pdi_vec_norm(const double *a);
/* The least of the parts: of spacings the same whichever axis is the first. */
PDI_FN double pdi_vec_least(const double *a);
/* Solve the dense PD_DIM x PD_DIM system a x = b (row-major, pivoted). Returns the smallest pivot ratio; 0: singular,
 * x then untouched. */
PDI_FN double pdi_vec_solve(const double *a, const double *b, double *x);
/* Row-major inverse. Returns 1 over the largest element of a times the largest one of the inverse, whichever axis is
 * the first; 0: singular, inverse then untouched. */
PDI_FN double pdi_vec_invert(const double *a, double *inverse);
/* Cholesky's factor L of a symmetric matrix of n rows, `stride` apart: the lower triangle goes in and L comes out. 0:
 * pivot k is not above least[k]. */
PDI_FN int pdi_vec_factor(int n, int stride, const double *least, double *a);
/* The same. 0 also where pivot k is not above least[k] when row k is the last one: the order of the rows does not
 * matter. n at most PDI_VEC_ROWS. */
#define PDI_VEC_ROWS 16
PDI_FN int pdi_vec_factor_any(int n, int stride, const double *least, double *a);
/* x = (L L^T)^-1 x with such a factor. */
PDI_FN void pdi_vec_substitute(int n, int stride, const double *a, double *x);
#endif

#endif
