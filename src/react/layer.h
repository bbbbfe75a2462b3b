/* layer: the surface of metal behind the layer of fluid over it: what is there, what law and curve give, and how that
 * follows the fluid (theory: eq. 8.2, 9.1, 9.4).
 */
#ifndef PD_LAYER_H
#define PD_LAYER_H
#include "react/etch.h"

#ifdef PDI_INTERNAL
/* Speed [m/s] at a fluid node for the present concentrations, behind a film of `thick` [mol s/m4], of the metal of
 * `place` (-1: of that without electrodes). NaN: the law is not finite. */
PDI_FN double pdi_layer_at(const pd_etch *etch, int metal, int32_t node, int32_t place, double thick, double guess);
/* What is at the surface of a place with its speed and flow as they are: c [solutes] [mol/m3], and *psi, F phi/(R T).
 * 0: none was found. */
PDI_FN int pdi_layer_surface(const pd_etch *etch, int32_t place, double *c, double *psi);
/* What the law of a place reads at its surface, with its speed and flow as they are: c [solutes] [mol/m3], pH and phi
 * [V] of pd_etch_fn. 0: no surface was found. */
PDI_FN int pdi_layer_reads(const pd_etch *etch, int32_t place, double *c, double *ph, double *phi);
/* Speed [m/s] and flow [mol/m2/s] of a place for what its node holds, at the drop [V] from metal to fluid. */
PDI_FN void pdi_layer_bare(const pd_etch *etch, int32_t place, double drop, double *speed, double *flow);
/* The speeds of all places (of a circuit; -1: of all), for potentials of metal as they are; `derive`: and how they
 * follow the totals. */
PDI_FN void pdi_layer_solve(const pd_ctx *ctx, pd_etch *etch, int circuit, int derive);
#endif

#endif
