/* inverse: the preconditioner of transport, near the inverse of its operator.
 *
 * It is a multigrid cycle on the compact operator and, at rest, what wide families answer to short waves (theory: eq.
 * 6.22).
 */
#ifndef PD_INVERSE_H
#define PD_INVERSE_H
#include "solve/compact_operator.h"
#include "transport/flux.h"

typedef struct pd_inverse {
    const pd_flux *flux;    /* the operator, its diffusivities and what absorbs. Borrowed */
    double rate;            /* [1/s] of the term in time */
    double excess;          /* [m2] tau D of eq. 6.22; 0 with a flow */
    double spread;          /* [-] share of the spreading of upwind fluxes that the operator keeps */
    int fresh;              /* 1: it is that of this step */
    pd_compact_operator compact;
    pd_multigrid mg;
} pd_inverse;

#ifdef PDI_INTERNAL
/* Without arrays: flux and its bonds and flow are given. desc: of pdi_compact_operator_multigrid_desc, with an arena.
 */
PDI_FN pd_status pdi_inverse_plan(pd_ctx *ctx, const pd_multigrid_desc *desc, pd_inverse *inverse);
/* Arrays that are lent for a step, and the [byte] that a setup needs beside. */
PDI_FN void pdi_inverse_list(pdi_array_visitor *owner, void *object);
PDI_FN size_t pdi_inverse_room(pd_inverse *inverse);
PDI_FN void pdi_inverse_free(pd_ctx *ctx, pd_inverse *inverse);
/* For steps with the term `rate` [1/s] in time, where `pinned_count` nodes hold their concentration. */
PDI_FN pd_status pdi_inverse_setup(pd_ctx *ctx, pd_inverse *inverse, double rate, const int32_t *pinned,
                                   int32_t pinned_count);
/* y [total] = near A^-1 x, at fluid nodes. */
PDI_FN void pdi_inverse_apply(pd_ctx *ctx, pd_inverse *inverse, const double *x, double *y);
#endif

#endif
