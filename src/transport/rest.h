/* rest: the operator of transport in fluid at rest, by lines of nodes where families are whole.
 */
#ifndef PD_REST_H
#define PD_REST_H
#include "transport/conductance.h"

#ifdef PDI_INTERNAL
typedef struct pdi_rest {
    const pd_conductance *conductance; /* that `rests` */
    double rate;                       /* [1/s] */
    const double *absorb, *hold;       /* [total] [1/s]; hold: may be NULL */
    const double *plain;               /* [total] what a node has; x may be less a constant */
    int exact;                         /* 1: sums over all nodes are those of `rate`, `absorb` and `hold` but for
                                        * rounding of what bonds carry; 0: of what nodes hold, and faster */
} pdi_rest;
/* y [total] = (rate + absorb + hold) plain + what leaves each fluid node through its bonds [1/s times x]. x [total] has
 * its images, and unless `exact` 0 in metal and walls. There are no inlets and outlets. */
PDI_FN void pdi_rest_apply(const pd_ctx *ctx, const pdi_rest *rest, const double *x, double *y);
#endif

#endif
