/* settle: the steady field of transport.
 *
 * Steps of a length beyond all times of the domain, then corrections for what the balances of the nodes lack. What all
 * of them lack together, over what passes the domain, is the most by which fluxes through two planes differ, and that
 * decides. Beside a good conductor a poor one rules the flux, which is then below the rounding of the field: what
 * rounding takes is kept beside it (theory: 6.15).
 */
#ifndef PD_SETTLE_H
#define PD_SETTLE_H
#include "transport/transport.h"

#define pd_transport_steady PD_NAME(pd_transport_steady)

/* PD_NOT_CONVERGED: after 60 steps the balances still lack result->defect of what passes, which is more than 1e-6. The
 * field is bounded and conservative, but not steady. PD_ERR_ARGUMENT: nothing moves. */
PD_API pd_status pd_transport_steady(pd_ctx *ctx, pd_transport *transport, pd_transport_result *result);

#ifdef PDI_INTERNAL
/* The largest defect of a steady field. */
#define PDI_SETTLE_DEFECT 1e-6
#endif

#endif
