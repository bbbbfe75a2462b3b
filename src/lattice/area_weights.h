/* area_weights: weights of lattice bonds that measure the area of a solid-fluid interface (Cauchy-Crofton on a
 * lattice).
 *
 * The area of a sharp interface between solid and fluid nodes is a weighted count of the bonds that cross it. A plane
 * of unit normal N is crossed by |xi.N| / V ordered bonds (solid to fluid) of offset xi per unit area, so that
 *     sum over fluid neighbours of c(n)  [1/m]  =  interface area of a solid node over its cell volume
 * measures every plane exactly when  f(N) = 1/2 sum_n c(n) |xi.N| = 1  for all N  (theory: eq. 6.3). A finite family
 * has finitely many bond directions and f is the width of a polytope, never exactly 1: the weights minimise its
 * largest error over all directions.
 */
#ifndef PD_AREA_WEIGHTS_H
#define PD_AREA_WEIGHTS_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Computes the weights area[count] = c(n) >= 0 [1/m] of the bonds xi[count][PD_DIM] [m] of a full family of horizon
 * ratio m with partial volumes beta[count], on spacings h [PD_DIM] [m]; bond count-1-k must be the opposite of bond k.
 * Weights are equal on bonds that a symmetry of the lattice exchanges, and 0 on bonds whose offset is a multiple of a
 * shorter one. f is exact along the axes, max |f - 1| minimal, and short bonds are preferred among equally good ones.
 * *anisotropy: max |f - 1| [-] over sampled directions. PD_ERR_ARGUMENT: the family is not that of m and h, or lacks
 * bonds. PD_ERR_INTERNAL: the fit fails. Source: Boykov and Kolmogorov 2003; the fit is original to this code. */
PDI_FN pd_status pdi_area_weights_compute(pd_ctx *ctx, int count, const double *xi, const double *beta, double m,
                                          const double *h, double *area, double *anisotropy);
/* Area that the weights area[count] [1/m] of the bonds xi[count][PD_DIM] [m] measure per unit area of a plane with the
 * unit vector `normal`: f(N) of the file comment [-], 1 where that plane is measured exactly. */
PDI_FN double pdi_area_weights_measure_plane(int count, const double *xi, const double *area, const double *normal);
#endif

#endif
