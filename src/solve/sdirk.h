/* sdirk: the two-stage, second-order, L-stable SDIRK method in time: its constant, and the step size control that its
 * embedded error estimate asks for (Alexander 1977; Hairer and Wanner 1996, IV.8).
 *
 * A process keeps the step that it plans. Its callbacks `limit`, `accept` and `reject` call the functions of the same
 * name.
 */
#ifndef PD_SDIRK_H
#define PD_SDIRK_H
#include "solve/physics.h"

#ifdef PDI_INTERNAL
#define PDI_SDIRK_GAMMA 0.29289321881345254 /* diagonal coefficient, 1 - 1/sqrt(2) (Alexander 1977) */
/* Step [s] to take: `planned`, at most max_step (0: no limit) and the time `left`; near the end two equal steps rather
 * than a long and a tiny one. */
PDI_FN double pdi_sdirk_limit_step(double planned, double max_step, double left);
/* Step [s] to plan after an accepted step dt with error_ratio = error over tolerance. A step that was shortened at the
 * end does not lower the plan unless its error asks for it. */
PDI_FN double pdi_sdirk_update_plan(double planned, double dt, double error_ratio);
/* Sets step->dt to the planned step [s], at most max_step (0: no limit) and the time to step->latest_end. */
PDI_FN void pdi_sdirk_limit(double planned, double max_step, pd_step *step);
/* Plans the next step *planned [s] by step->error of the accepted step of step->dt. */
PDI_FN void pdi_sdirk_accept(double *planned, const pd_step *step);
/* Plans a shorter step *planned [s] than the rejected step->dt by step->error, infinite where it had no solution, and
 * sets step->dt as pdi_sdirk_limit does. */
PDI_FN void pdi_sdirk_reject(double *planned, double max_step, pd_step *step);
#endif

#endif
