/* dissolve: a step of a dissolving surface, by a surface rate or by bonds. Solid nodes lose metal through the bonds
 * that join them to fluid. Law and transport are solved together for the end of the step. Amounts are moved, never
 * dropped; metal that a step would use up gives what it has (eq. 10.11).
 *
 * Surface rate. A bond of offset n from solid node j moves  V f_j c(n) Cs  [mol/m3/s] into the fluid, with V the mean
 * of V(c_i), the recession speed of the law behind the film between the surface and node i (law.h), over the nodes
 * whose bonds the metal cuts there (eq. 10.3), f_j the grain factor and c(n) the interface area that the bond stands
 * for: a flat front recedes at V for every h, m and direction (theory: eq. 10.1 to 10.8). The set of solid nodes would
 * lead the metal by about one cell, and a curved front be too fast: so a node joins the fluid when as much is left as
 * the node set leads on average, and its solid neighbours take over the rest (their content may exceed Cs: the surface
 * stands out of the cell). The share `threshold` of the content stays in the node as dissolved metal.
 *
 * Bonds. A bond moves V(c_i) b(n) (Cs - Csat) [mol/m3/s] to the node at its far end (theory: eq. 11.1). Fluid at Csat
 * takes what transport carries away and no more, the salt layer (11.8). A node that is down to Csat turns fluid.
 */
#ifndef PD_DISSOLVE_H
#define PD_DISSOLVE_H
#include "metal/metal.h"
#include "solve/physics.h"

#define pd_dissolve_build PD_NAME(pd_dissolve_build)
#define pd_dissolve_process PD_NAME(pd_dissolve_process)
#define pd_dissolve_free PD_NAME(pd_dissolve_free)
#define pd_dissolve_prepare PD_NAME(pd_dissolve_prepare)

/* Fills the solid nodes of transport->c with Cs. The stencil, borrowed, is that of the bonds of the metal; its horizon
 * may differ from that of the transport. PD_ERR_ARGUMENT: solid not positive, threshold out of range; a surface rate
 * with a horizon shorter than that of the transport; bonds that reach farther than the ghosts of the grid. */
PD_API pd_status pd_dissolve_build(pd_ctx *ctx, pd_grid *grid, const pd_stencil *stencil, pd_transport *transport,
                                   const pd_dissolve_desc *desc, pd_dissolve *dissolve);
/* Transport together with the metal, one implicit system, as a process. A step is as long as no solid node loses more
 * than a set fraction and the error in time of what is lost allows. What a law knows of time holds at the middle of the
 * step, which is of second order. */
PD_API pd_physics pd_dissolve_process(pd_dissolve *dissolve);
PD_API void pd_dissolve_free(pd_ctx *ctx, pd_dissolve *dissolve);
/* Begin a step: who lies beside metal, and the law there, at the present concentrations and at dissolve->time; sets
 * transport->source and ->absorb. PD_ERR_STATE: the law returned NaN, infinity or 1e100 m/s and more (the message names
 * node, place and concentration). */
PD_API pd_status pd_dissolve_prepare(pd_ctx *ctx, pd_dissolve *dissolve);

#ifdef PDI_INTERNAL
/* The same with the means of laws over dt [s] from t on. PD_RETRY: they need a shorter time. */
PDI_FN pd_status pdi_dissolve_mean(pd_ctx *ctx, pd_dissolve *dissolve, double t, double dt);
/* Largest loss rate [1/s] of any node as a fraction of what a node loses before it turns fluid. */
PDI_FN double pdi_dissolve_fastest(pd_ctx *ctx, pd_dissolve *dissolve);
/* pd_transport_implicit of dt [s] together with the law at its end. Where a piece of metal would give more than it has,
 * the step is taken again with what it has (theory: eq. 10.11). PD_RETRY, nothing changed: a node would lose more than
 * `most`, the error is above `rtol`, or law and transport found no common solution; prepare again and take retry_dt. */
PDI_FN pd_status pdi_dissolve_transport(pd_ctx *ctx, pd_dissolve *dissolve, double dt, pd_transport_result *result);
/* Damage [-] of a node: of metal the share of its mechanical bonds that are broken, or the share of Cs - Csat that it
 * has lost when bonds do not break at random; 1 in fluid, 0 elsewhere. */
PDI_FN double pdi_dissolve_damage(const pd_dissolve *dissolve, int32_t node);
/* Its arrays, but for those of the fluid beside metal (reach.h). */
PDI_FN void pdi_dissolve_list(pdi_array_visitor *owner, void *dissolve);
#endif

#endif
