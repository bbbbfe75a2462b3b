/* sdirk: what all users of the two-stage, second-order, L-stable SDIRK method share: its constant, and the choice of
 * steps by an embedded error estimate (Alexander 1977; Hairer and Wanner 1996, IV.8).
 */
#ifndef PD_SDIRK_H
#define PD_SDIRK_H
#include "core/base.h"

#ifdef PDI_INTERNAL
#define PDI_SDIRK_GAMMA 0.29289321881345254 /* 1 - 1/sqrt(2) */
/* The step [s] to take when `planned` is wanted, `largest` (0: none) allowed and `left` remains: two equal steps to the
 * end rather than a long and a tiny one. *last: it reaches the end. */
PDI_FN double pdi_sdirk_clip(double planned, double largest, double left, int *last);
/* Factor for the next step from the error over its tolerance, at most `growth`. */
PDI_FN double pdi_sdirk_factor(double share, double growth);
/* The plan after an accepted step dt: one that was cut short at the end says little about longer ones. */
PDI_FN double pdi_sdirk_plan(double planned, double dt, double factor);
#endif

#endif
