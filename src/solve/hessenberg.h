/* hessenberg: the least-squares problem of GMRES: QR of a growing Hessenberg matrix by Givens rotations. */
#ifndef PD_HESSENBERG_H
#define PD_HESSENBERG_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Offset of column j, which has j + 2 entries, in the packed matrix. */
static inline int64_t pdi_hessenberg_column_offset(int64_t j) { return j * (j + 3) / 2; }
/* Apply the Givens rotations cs, sn [j] to the new column h (number j), and add one that makes it upper triangular; it
 * is applied to the right-hand side g [j + 2], too. |g[j + 1]| is then the residual norm. */
PDI_FN void pdi_hessenberg_rotate(int j, double *h, double *cs, double *sn, double *g);
/* Solve the triangular system of `count` columns for y [count] by back substitution. A pivot of rounding size, as of a
 * singular operator, gives y = 0. */
PDI_FN void pdi_hessenberg_back_substitute(int count, const double *hess, const double *g, double *y);
#endif

#endif
