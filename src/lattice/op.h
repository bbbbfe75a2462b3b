/* op: the peridynamic (nonlocal) operators on scalar and vector fields: gradient, divergence, Laplacian, diffusion.
 *
 * Fields have a value at each node, ghosts included. Results are written at fluid nodes and nowhere else. Far ends of
 * open bonds are fluid nodes, images, and the ghosts of inlets and outlets, whose values the caller sets beforehand; a
 * bond blocked by solid or wall takes no part. Nodes with full families use the shared stencil, the others go bond by
 * bond; both evaluate the same sums (theory: section 1 and eq. 2.9; Zhao and Bobaru 2022; Tian and Du 2014).
 *
 *   operator    full family          truncated family                       over a closed domain
 *   gradient    exact on quadratics  exact on linear fields                 not conservative
 *   divergence  exact on quadratics  no flux through blocked bonds          sum V div u = 0
 *   laplacian   exact on cubics      no flux through blocked bonds          sum V lap f = 0, self-adjoint
 *   diffuse     lap times D          no flux through blocked bonds          sum V out = 0, self-adjoint
 *
 * On an axisymmetric grid they are those of a scalar and of a vector without swirl in (z, r): V includes the
 * circumference, and families at the axis are full (theory: section 1.6).
 */
#ifndef PD_OP_H
#define PD_OP_H
#include "lattice/node_loop.h"

#define pd_op_gradient PD_NAME(pd_op_gradient)
#define pd_op_divergence PD_NAME(pd_op_divergence)
#define pd_op_laplacian PD_NAME(pd_op_laplacian)
#define pd_op_diffusion PD_NAME(pd_op_diffusion)

/* Gradient: grad [PD_DIM][total] = sum g (f_j - f_i) of f [total], corrected by the moments of the open bonds at
 * truncated families (eq. 1.4, 2.9). Linear fields are exact at every node whose open bonds span space; in directions
 * that they do not span, the gradient along the surface normal is zero (eq. 2.10). Not conservative. Bonds to inlet
 * ghosts are left out: these have no scalar value. */
PD_API void pd_op_gradient(const pd_ctx *ctx, const pd_bonds *bonds, const double *f, double *grad);
/* Divergence: div [total] = sum of the bond fluxes g.(u_i + u_j) of u [PD_DIM][total] (eq. 3.2). Conservative: the flux
 * of a bond is opposite at its ends, so the sum over fluid nodes is the flux through inlets and outlets. Consistent at
 * full families; at truncated ones as far as u vanishes at the surface. */
PD_API void pd_op_divergence(const pd_ctx *ctx, const pd_bonds *bonds, const double *u, double *div);
/* Laplacian: lap [total] = sum a (f_j - f_i) of f [total] (eq. 1.3). Conservative, self-adjoint, negative
 * semi-definite, and its weights are positive (maximum principle). Consistent at full families; at truncated ones
 * with zero flux through the surface (Neumann condition). */
PD_API void pd_op_laplacian(const pd_ctx *ctx, const pd_bonds *bonds, const double *f, double *lap);
/* Diffusion div(D grad f): out [total] = sum D_ij a (f_j - f_i) with D_ij the harmonic mean of diffusivity [total]
 * [m2/s] at both ends (eq. 6.2; 0 where both are). Conservative, self-adjoint, negative semi-definite; consistent where
 * D is smooth and the family full; for bonds of one cell a jump of D halfway between layers is resistances in series.
 * Images take D of their source, as in csr.h. PD_ERR_ARGUMENT: D of a fluid node, or of an inlet or outlet ghost, is
 * negative or not below 1e300; nothing is written then. */
PD_API pd_status pd_op_diffusion(pd_ctx *ctx, const pd_bonds *bonds, const double *diffusivity, const double *f,
                                 double *out);

#endif
