/* vec: small vectors and matrices of PD_DIM components, small Cholesky factors, physical constants. */
#ifndef PD_VEC_H
#define PD_VEC_H
#include "core/config.h"

#define PD_PI 3.14159265358979323846
/* Faraday's constant [C/mol] and the gas constant [J/mol/K], exact (CODATA 2018). */
#define PD_FARADAY 96485.33212331001
#define PD_GAS_CONSTANT 8.31446261815324

#ifdef PDI_INTERNAL
/* Components of a symmetric tensor. */
#if PD_DIM == 1
#define PDI_SYM_COMPONENTS 1
#elif PD_DIM == 2
#define PDI_SYM_COMPONENTS 3
#else
#define PDI_SYM_COMPONENTS 6
#endif

/* Dot product and Euclidean norm of vectors [PD_DIM]. */
PDI_FN double pdi_vec_dot(const double *a, const double *b);
PDI_FN double pdi_vec_norm(const double *a);
/* Smallest component, as of the grid spacings. */
PDI_FN double pdi_vec_min(const double *a);
/* Solve the dense PD_DIM x PD_DIM system a x = b (row-major, partial pivoting); x may be b. Returns the smallest
 * |pivot| over max |a|, at most 1; 0: singular (a pivot is exactly 0, or NaN), x then untouched. */
PDI_FN double pdi_vec_solve(const double *a, const double *b, double *x);
/* Inverse of a PD_DIM x PD_DIM matrix (row-major). Returns the reciprocal condition number by largest elements, 1 /
 * (max |a_ij| max |inverse_ij|); 0: singular (a pivot is exactly 0, or NaN), inverse then untouched. */
PDI_FN double pdi_vec_invert(const double *a, double *inverse);
/* Cholesky factorisation A = L L^T in place: n rows, `stride` apart; the lower triangle of A goes in and L comes out,
 * the upper one is left alone. 1: done. 0: the pivot of a row k, before its root, is not above least[k] (not positive
 * definite); a is then partly overwritten. */
PDI_FN int pdi_vec_cholesky(int n, int stride, const double *least, double *a);
/* The same with a test that does not depend on the order of the rows: 0 also when the pivot of a row k would not be
 * above least[k] if row k came last; a then holds L. n at most PDI_VEC_MAX_ROWS. */
#define PDI_VEC_MAX_ROWS 16
PDI_FN int pdi_vec_cholesky_any_order(int n, int stride, const double *least, double *a);
/* Solve A x = b with such a factor by forward and back substitution; x [n]: b goes in, the solution comes out. */
PDI_FN void pdi_vec_cholesky_solve(int n, int stride, const double *a, double *x);
#endif

#endif
