/* mineral_step: one backward Euler step of all minerals of a volume, with the equilibrium of its solutes: amounts that
 * fill, empty or share the volume are found by active sets and Newton's method (theory: 7.7).
 */
#ifndef PD_MINERAL_STEP_H
#define PD_MINERAL_STEP_H
#include "chemistry/mineral.h"

#ifdef PDI_INTERNAL
/* Backward Euler step of all minerals of a volume (eq. 7.16): concentrations conc [solutes] and amounts n [count]. On
 * entry conc is a first guess; total [components] are dissolved beside the amounts n, which are the first guess unless
 * start->guess is. Minerals that fill the volume share it in proportion to their growth without that limit.
 * PD_NOT_CONVERGED: both are unchanged. */
PDI_FN pd_status pdi_mineral_step_solve(const pd_components *c, const pd_minerals *m, const pd_mineral_start *start,
                                        const double *total, double *conc, double *n);
/* derivatives [count][components] [-] of the amounts n by the totals, dissolved and in minerals together, at the
 * solution (conc, n) of a step; 0 for minerals that are absent, full or do not react. */
PDI_FN void pdi_mineral_step_compute_derivatives(const pd_components *c, const pd_minerals *m,
                                                 const pd_mineral_start *start, const double *conc, const double *n,
                                                 double *derivatives);
/* change [count] [mol/m3] that the rate laws ask for at fixed totals becomes the change of n with the feedback of
 * Omega: (W + L)^-1 L change (theory 7.7). It stays for minerals that are absent, full or do not react. */
PDI_FN void pdi_mineral_step_solve_linear_response(const pd_components *c, const pd_minerals *m,
                                                   const pd_mineral_start *start, const double *conc, const double *n,
                                                   double *change);
#endif

#endif
