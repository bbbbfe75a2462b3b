/* axisym: bond weights on an axisymmetric lattice in (z, r), whose nodes are rings around the axis r = 0.
 *
 * Axis 0 is z, the last axis is r, sums over volume count the circumference of a node. A bond between the rings i and
 * j has one conductance c_ij = c_ji, so bond fluxes are conservative: a(n) times the mean radius far from the axis.
 * Near the axis, where the bonds that would cross it are missing, c_ij are the conductances of minimal relative entropy
 * to that which keep the Laplacian and the divergence exact on all quadratics of (z, r): positive for every horizon
 * ratio and spacing (theory: section 1.6, eq. 1.6 to 1.10).
 */
#ifndef PD_AXISYM_H
#define PD_AXISYM_H
#include "lattice/grid.h"

typedef struct pd_axisym {
    int rows, count; /* rows of nodes along r, ghosts included; bonds of a family */
    double *laplacian_weight; /* [rows][count] [1/m2] of the Laplacian: c_ij / r_i; 0 across the axis */
    double *flux_factor;      /* [rows][count] [-] factor on g(n) in the divergence; 0 across the axis */
    double *hoop;    /* [rows] [1/m2] the 1/r^2 of the vector Laplacian: lap u_r - hoop u_r is exact for u_r = r */
} pd_axisym;

#ifdef PDI_INTERNAL
/* Allocates and computes the weights of all rows along r, 0 in rows at r <= 0; a planar grid has none (all pointers
 * NULL). `axisym` is overwritten, and keeps no pointer to stencil or grid; all zero after a failure. PD_ERR_GEOMETRY:
 * the fit of the conductances does not converge. */
PDI_FN pd_status pdi_axisym_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_axisym *axisym);
PDI_FN void pdi_axisym_free(pd_ctx *ctx, pd_axisym *axisym);
#endif

#endif
