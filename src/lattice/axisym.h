/* axisym: the weights of bonds on an axisymmetric lattice, whose nodes are rings around the axis r = 0.
 *
 * Axis 0 is z, the last axis is r, sums over volume count the circumference of a node. A bond between the rings i and
 * j has one conductance c_ij = c_ji, so what it moves leaves the one and enters the other: a(n) times the mean radius
 * far from the axis. Near it, where the bonds that would cross it are missing, the conductances closest to that in the
 * sense of relative entropy which keep the Laplacian and the divergence exact on all quadratics of (z, r): positive for
 * every horizon ratio and spacing (theory: section 3.5, eq. 3.7 to 3.10).
 */
#ifndef PD_AXISYM_H
#define PD_AXISYM_H
#include "lattice/grid.h"

typedef struct pd_axisym {
    int rows, count; /* rows of the padded lattice along r; bonds of a family */
    double *lap;     /* [rows][count] [1/m2] of the Laplacian: c_ij / r_i; 0 across the axis */
    double *flux;    /* [rows][count] [-] factor of g(n) in the fluxes of bonds; 0 across the axis */
    double *hoop;    /* [rows] [1/m2] of the radial component of a vector: lap u_r - hoop u_r is exact on r */
} pd_axisym;

#ifdef PDI_INTERNAL
/* Empty on a planar grid. PD_ERR_GEOMETRY: no conductances exist (never seen). */
PDI_FN pd_status pdi_axisym_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_axisym *ring);
PDI_FN void pdi_axisym_free(pd_ctx *ctx, pd_axisym *ring);
#endif

#endif
