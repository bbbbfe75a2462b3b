/* amount: how much the fluid holds, and what passes a plane across it. */
#ifndef PD_AMOUNT_H
#define PD_AMOUNT_H
#include "transport/transport.h"

#define pd_transport_stock PD_NAME(pd_transport_stock)
#define pd_transport_carried PD_NAME(pd_transport_carried)

/* Dissolved amount [mol, per m in planar 2D] in fluid nodes. */
PD_API double pd_transport_stock(pd_ctx *ctx, const pd_transport *transport);
/* Amount [mol] in carry: owed by the last solve, delivered by the next step. */
PD_API double pd_transport_carried(pd_ctx *ctx, const pd_transport *transport);

#ifdef PDI_INTERNAL
/* Flux [mol/s, per m in planar 2D] towards + of all bonds that cross the plane between cells index - 1 and index of
 * `axis` (index 1 .. n-1) at the end of the last step, antidiffusive fluxes included: what the scheme conserves (eq.
 * 6.1, 6.15). Along a periodic axis up to the tolerance of the limiter. */
PDI_FN double pdi_amount_section(pd_ctx *ctx, pd_transport *transport, int axis, int index);
#endif

#endif
