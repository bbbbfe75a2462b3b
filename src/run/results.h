/* results: what a run says at its end of what its monitors have seen: lines of figures, and notes on those that its
 * lattice, its curves or its metal do not allow to trust.
 */
#ifndef PD_RESULTS_H
#define PD_RESULTS_H
#include "run/monitor.h"

#ifdef PDI_INTERNAL
/* A line "result case=... monitor=..." with the last figures of each table, and a note where the lattice does not hold
 * what they measure. */
PDI_FN void pdi_results_print(const pd_monitors *monitors, pd_print_fn print, void *user);
#endif

#endif
