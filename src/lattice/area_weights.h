/* area_weights: weights of lattice bonds that measure the area of a solid-fluid interface (Cauchy-Crofton on a
 * lattice).
 *
 * The area of a sharp interface between solid and fluid nodes is a weighted count of the bonds that cross it. A plane
 * of unit normal N is crossed by |xi.N| / V ordered bonds (solid to fluid) of offset xi per unit area, so that
 *     sum over fluid neighbours of c(n)  [1/m]  =  interface area of a solid node over its cell volume
 * measures every plane exactly when  f(N) = 1/2 sum_n c(n) |xi.N| = 1  for all N  (theory: eq. 10.5). A finite family
 * has finitely many bond directions and f is the width of a polytope, never exactly 1: the weights minimise its
 * largest error over all directions.
 */
#ifndef PD_AREA_WEIGHTS_H
#define PD_AREA_WEIGHTS_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Weights area[count] = c(n) >= 0 [1/m] of the bonds xi[count][PD_DIM] [m] of a family of ratio m, partial volumes
 * beta[count] and spacings h [PD_DIM] [m]; bond count-1-k is opposite to k. Equal by symmetry; 0 for beta <= 0 and
 * multiples of shorter bonds. f is 1 along the axes, max |f - 1| (*anisotropy [-], sampled) minimal, short bonds
 * preferred. PD_ERR_ARGUMENT: h <= 0 or not finite, below 2 PD_DIM bonds, not the family of m and h, an axis not
 * measured. PD_ERR_INTERNAL: the fit fails. Source: Boykov and Kolmogorov 2003; the fit is original to this code. */
PDI_FN pd_status pdi_area_weights_compute(pd_ctx *ctx, int count, const double *xi, const double *beta, double m,
                                          const double *h, double *area, double *anisotropy);
/* Area that the weights area[count] [1/m] of the bonds xi[count][PD_DIM] [m] measure per unit area of a plane with the
 * unit vector `normal`: f(N) of the file comment [-], 1 where that plane is measured exactly. */
PDI_FN double pdi_area_weights_measure_plane(int count, const double *xi, const double *area, const double *normal);
#endif

#endif
