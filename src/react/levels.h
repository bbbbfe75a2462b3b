/* levels: potentials of metals among ions that migrate, from the currents of their circuits (theory: 9.5).
 *
 * A circuit has a given potential, or the one at which its metal gives its given current, 0 where it corrodes freely.
 * That follows from the state of the nodes, at each residual of a step: the sum of the currents rises with it.
 */
#ifndef PD_LEVELS_H
#define PD_LEVELS_H
#include "react/etch.h"

#ifdef PDI_INTERNAL
/* Potentials of circuits, and the speeds and flows of all places. Where a circuit has none, they are NaN and
 * etch->lost says which it is. */
PDI_FN void pdi_levels_solve(const pd_ctx *ctx, pd_etch *etch);
/* Potentials [V] from `from` to `to` at which a circuit is tried: in steps of `fine` where the drop to the fluid beside
 * its metal may be one from low to high, else of `coarse`. */
typedef struct pdi_levels_trials {
    double from, to, low, high, fine, coarse;
} pdi_levels_trials;
/* Potentials of a circuit at which its metal gives its current, by those trials: how many, the first `most` of them
 * into root. Its potential, speeds and flows are lost. */
PDI_FN int pdi_levels_roots(const pd_ctx *ctx, pd_etch *etch, int circuit, const pdi_levels_trials *trials,
                            double *root, int most);
/* After derivatives: how the currents of circuits follow their potentials. */
PDI_FN void pdi_levels_derive(pd_etch *etch);
/* Changes of speeds and flows [count] get those by the potentials of circuits that float. */
PDI_FN void pdi_levels_follow(const pd_etch *etch, double *speed, double *flow);
/* 1: a potential is given to metal that is there. */
PDI_FN int pdi_levels_tie(const pd_etch *etch);
/* Whether a current can leave the box: reactive->migration.tied. */
PDI_FN void pdi_levels_ties(pd_reactive *reactive);
/* Circuits that are there whose potential follows from their currents. */
PDI_FN int pdi_levels_free(const pd_etch *etch);
/* [mol/s] charge that a speed [m/s] and a flow [mol/m2/s] bring at a place. */
PDI_FN double pdi_levels_place(const pd_etch *etch, int32_t place, double speed, double flow);
/* [mol/s] charge that leaves the metal of a circuit, and *size, the sum of its sizes. */
PDI_FN double pdi_levels_charge(const pd_etch *etch, int circuit, double *size);
/* Where no current can leave, sources and circuits give none but for rounding in a step of dt [s]: else
 * PD_ERR_ARGUMENT. */
PDI_FN pd_status pdi_levels_sources(pd_ctx *ctx, pd_reactive *reactive, double dt);
#endif

#endif
