/* hessenberg: the least squares of GMRES: a Hessenberg matrix that grows by columns, made triangular by rotations. */
#ifndef PD_HESSENBERG_H
#define PD_HESSENBERG_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Column j, j + 2 entries long, begins behind the columns before it. */
static inline int64_t pdi_hessenberg_column(int64_t j) { return j * (j + 3) / 2; }
/* Rotate column h, the j-th one, to upper triangular form, and with it the right-hand side g. cs, sn: rotations so far,
 * which get one more. */
PDI_FN void pdi_hessenberg_rotate(int j, double *h, double *cs, double *sn, double *g);
/* y of `count` columns by back substitution. A singular operator leaves a pivot of rounding size; its direction is left
 * out. */
PDI_FN void pdi_hessenberg_back(int count, const double *hess, const double *g, double *y);
#endif

#endif
