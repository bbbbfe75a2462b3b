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
/* Step [s] to take: `planned`, at most max_step (0: no limit). Where that reaches the time `left`, but for 1e-9 of it,
 * the step is `left`; where it is more than half of `left`, it is half: two equal steps rather than a long and a tiny
 * one. */
PDI_FN double pdi_sdirk_limit_step(double planned, double max_step, double left);
/* Step [s] to plan after an accepted step dt with error_ratio = error over tolerance: dt times 0.9 / sqrt(error_ratio),
 * at most 4. A step that was shortened at the end does not lower the plan: with a factor below 1 it is the smaller of
 * planned and that step, else the larger. */
PDI_FN double pdi_sdirk_update_plan(double planned, double dt, double error_ratio);
/* Sets step->dt to the planned step [s], at most max_step (0: no limit) and the time to step->latest_end. */
PDI_FN void pdi_sdirk_limit(double planned, double max_step, pd_step *step);
/* Plans the next step *planned [s] by step->error of the accepted step of step->dt. */
PDI_FN void pdi_sdirk_accept(double *planned, const pd_step *step);
/* Plans the step *planned [s] after the rejected step->dt by step->error, infinite where it had no solution: step->dt
 * times the factor of pdi_sdirk_update_plan, at least 0.1. It is shorter for an error above 0.81 only. Sets step->dt as
 * pdi_sdirk_limit does. */
PDI_FN void pdi_sdirk_reject(double *planned, double max_step, pd_step *step);
#endif

#endif
