/* limiter: the gradient of a concentration, and the share of its antidiffusive fluxes that a node may keep.
 *
 * factor = 1 - rho^4 with the ratio rho of the sum of all weighted steps along the bonds to that of their sizes
 * (theory: eq. 6.15): 1 where the field is nearly linear, 0 where the node is a maximum or minimum of its family.
 * Wall values count by linear extension. Both change continuously with the field, so Newton's method applies.
 */
#ifndef PD_LIMITER_H
#define PD_LIMITER_H
#include "lattice/open_boundary.h"
#include "transport/diffusion.h"

/* The first three are borrowed. */
typedef struct pd_limiter {
    const pd_bonds *bonds;
    const pd_open_boundary *boundary;
    const pd_diffusion *diffusion;
    double *slope; /* [PD_DIM][total] [mol/m4] gradient, images included; lent for a step */
    double *factor; /* [total] [-] images included; ghosts of inlets 1; lent, too */
} pd_limiter;

#ifdef PDI_INTERNAL
/* Arrays of a pd_limiter. */
PDI_FN void pdi_limiter_list(pdi_array_visitor *owner, void *object);
/* 1: the gradient of node i needs the moments of its open bonds: some of the others see no held value. */
PDI_FN int pdi_limiter_cut(const pd_limiter *limiter, int32_t i);
/* c [total] with its images and inlets; steps along bonds far below `least` [mol/m3] count as none. */
PDI_FN void pdi_limiter_update(const pd_ctx *ctx, pd_limiter *limiter, const double *c, double least);
/* Derivatives of `factor` and `slope` for that c along x [total], with its images and zero at inlets. At a kink one of
 * both sides counts, or their mean, for all x: they are linear in x. */
PDI_FN void pdi_limiter_derive(const pd_ctx *ctx, const pd_limiter *limiter, const double *c, const double *x,
                               double least, double *factor_by, double *slope_by);
#endif

#endif
