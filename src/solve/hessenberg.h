/* hessenberg: the least-squares problem of GMRES: QR of a growing Hessenberg matrix by Givens rotations. */
#ifndef PD_HESSENBERG_H
#define PD_HESSENBERG_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Offset of column j, which has j + 2 entries, in the packed matrix; also the size of the j columns before it. */
static inline int64_t pdi_hessenberg_column_offset(int64_t j) { return j * (j + 3) / 2; }
/* Apply the Givens rotations cs, sn [j] to the new column h [j + 2], number j, in place, and append one, cs[j] and
 * sn[j], that makes it upper triangular: h[j] becomes at least 0 and h[j + 1] = 0. It is the identity where both are 0.
 * The new one is also applied to the right-hand side g: it changes g[j], and sets g[j + 1], whose absolute value is
 * then the residual norm. */
PDI_FN void pdi_hessenberg_rotate(int j, double *h, double *cs, double *sn, double *g);
/* Solve the upper triangular system of the first `count` columns of the packed matrix, with the right-hand side g
 * [count], for y [count]. An unknown whose pivot is at most 1e-13 of the largest one in size, as of a singular
 * operator, gets 0. */
PDI_FN void pdi_hessenberg_back_substitute(int count, const double *hess, const double *g, double *y);
#endif

#endif
