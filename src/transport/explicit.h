/* explicit: forward Euler steps of transport, and how long they may be (theory: eq. 6.10). */
#ifndef PD_EXPLICIT_H
#define PD_EXPLICIT_H
#include "transport/transport.h"

#define pd_transport_explicit PD_NAME(pd_transport_explicit)
#define pd_transport_limit PD_NAME(pd_transport_limit)

/* One forward Euler step. PD_RETRY, nothing changed: dt exceeds pd_transport_limit. */
PD_API pd_status pd_transport_explicit(pd_ctx *ctx, pd_transport *transport, double dt);
/* Largest explicit step [s] that keeps every node within its neighbours. */
PD_API double pd_transport_limit(pd_ctx *ctx, const pd_transport *transport);

#ifdef PDI_INTERNAL
/* Rate [1/s] at which node i exchanges its content: one over its explicit limit. Limited antidiffusive fluxes may need
 * as much room as upwinding itself. */
PDI_FN double pdi_explicit_rate(const pd_transport *transport, int32_t i);
#endif

#endif
