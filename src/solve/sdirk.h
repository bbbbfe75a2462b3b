/* sdirk: the two-stage, second-order, L-stable SDIRK method in time: its constant, and step size control by an embedded
 * error estimate (Alexander 1977; Hairer and Wanner 1996, IV.8).
 */
#ifndef PD_SDIRK_H
#define PD_SDIRK_H
#include "core/base.h"

#ifdef PDI_INTERNAL
#define PDI_SDIRK_GAMMA 0.29289321881345254 /* diagonal coefficient, 1 - 1/sqrt(2) (Alexander 1977) */
/* Step [s] to take: `planned`, at most max_step (0: no limit) and the time `left`; near the end two equal steps rather
 * than a long and a tiny one. *last: 1 when the step reaches the end. */
PDI_FN double pdi_sdirk_limit_step(double planned, double max_step, double left, int *last);
/* Factor for the next step from error_ratio = error over tolerance, at most max_growth. */
PDI_FN double pdi_sdirk_step_factor(double error_ratio, double max_growth);
/* Step [s] to plan after an accepted step dt: a step that was shortened at the end does not lower the plan unless its
 * error asks for it (factor < 1). */
PDI_FN double pdi_sdirk_update_plan(double planned, double dt, double factor);
#endif

#endif
