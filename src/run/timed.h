/* timed: laws at surfaces that depend on time beside species or states, and how far a step of the species may go.
 *
 * A step takes such laws at its stages. It may end where the rule of the stages gives the integral of the law over the
 * step, at each place, with species and states as they are at its start and as they are at its end. The integral is
 * summed over pieces. Bounds by interval arithmetic leave no room for what the instants of a piece do not show (theory:
 * 6.1).
 */
#ifndef PD_TIMED_H
#define PD_TIMED_H
#include "run/attack.h"
#include "run/surfaces.h"

/* All is borrowed. Empty: no law depends on time so. */
typedef struct pd_timed {
    const pd_setup *setup;
    const pd_attack *attack;     /* laws of metal; NULL: none in species depends on time */
    const pd_surfaces *surfaces; /* rates of states, factors of electrodes; NULL: none depends on time */
} pd_timed;

#ifdef PDI_INTERNAL
/* attack, surfaces: NULL where there are none. */
PDI_FN void pdi_timed_build(const pd_setup *setup, const pd_attack *attack, const pd_surfaces *surfaces,
                            pd_timed *timed);
/* The `until` of the process of the species. user: a pd_timed. */
PDI_FN double pdi_timed_until(void *user, double t, double end, int tried);
#endif

#endif
