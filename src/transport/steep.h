/* steep: antidiffusive fluxes of sixth order, which keep summits and steep fronts, for explicit steps with families of
 * the nodes next to a node (theory: eq. 6.17 to 6.19).
 *
 * A node knows the value at the middle of each of its bonds, from five nodes in a line. The mean of both ends counts,
 * within the limits of the upwind one, so that monotone profiles stay monotone. What the bonds then bring is scaled
 * where a node would leave bounds that the upwinded step keeps.
 */
#ifndef PD_STEEP_H
#define PD_STEEP_H
#include "transport/bounds.h"
#include "transport/flux.h"

#ifdef PDI_INTERNAL
typedef struct pdi_steep {
    const pd_flux *flux;
    double dt;                /* [s] */
    pdi_bounds bounds;        /* [mol/m3] of the field at the end of the step */
    const double *c, *plain;  /* [total] [mol/m3] the field with its images and inlets; that of the upwinded step */
    double *bend;             /* [total] [mol/m3] work: second differences along a line */
    double *value;            /* [count][total] [mol/m3] values at the middle of bonds, less that of the node; lent */
    double *ahead, *behind;   /* [total] [mol/m3] work: values of a line */
    double *gain, *loss;      /* [total] work: what comes in and leaves [mol/m3/s], then the shares that may [-] */
} pdi_steep;

/* 1: families are those of nodes that share a face or an edge of their cells with a node. */
PDI_FN int pdi_steep_may(const pd_flux *flux);
/* Arrays of a pdi_steep that are lent for a step. */
PDI_FN void pdi_steep_list(pdi_array_visitor *owner, void *object);
/* y [total] [mol/m3/s]: what each fluid node gains. */
PDI_FN void pdi_steep_anti(const pd_ctx *ctx, const pdi_steep *steep, double *y);
#endif

#endif
