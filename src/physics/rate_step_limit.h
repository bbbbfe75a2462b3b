/* rate_step_limit: time step limit of the species from surface rate laws that depend explicitly on time.
 *
 * The SDIRK2 stages of a step evaluate such a law at two times. The step may be as long as that quadrature rule gives
 * the integral of the law over the step within the tolerance, at each surface site, with species and states of its
 * start or end held fixed. The reference integral is adaptive Gauss quadrature with bounds by interval arithmetic, so
 * that no peak or jump between the abscissae is missed (theory: 10.12).
 */
#ifndef PD_RATE_STEP_LIMIT_H
#define PD_RATE_STEP_LIMIT_H
#include "physics/dissolution_laws.h"
#include "physics/surface_states.h"

/* Laws that limit the step. All is borrowed. Empty: no law depends on time. */
typedef struct pd_rate_step_limit {
    const pd_setup *setup;
    const pd_dissolution_laws *attack; /* dissolution rate laws in species; NULL: none depends on time */
    const pd_surface_states *surfaces; /* rates of surface states, factors of curves; NULL: none depends on time */
} pd_rate_step_limit;

#ifdef PDI_INTERNAL
/* Set which laws of the setup limit the step; resets `timed`. attack is kept if a law in the species depends on time,
 * surfaces if a rate of a state or a factor of a curve does; else they become NULL. attack, surfaces: NULL where there
 * are none. */
PDI_FN void pdi_rate_step_limit_build(const pd_setup *setup, const pd_dissolution_laws *attack,
                                      const pd_surface_states *surfaces, pd_rate_step_limit *timed);
/* Latest end [s], at most `end`, of a step of the species from t that is to end at `end` [s]. tried: 1: after an
 * attempt, with the state of its end, in one pass over all laws, as another attempt follows; 0: in passes until none
 * shortens the step. The `time_limit` callback of pd_physics; user: a pd_rate_step_limit. */
PDI_FN double pdi_rate_step_limit_compute(void *user, double t, double end, int tried);
#endif

#endif
