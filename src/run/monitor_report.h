/* monitor_report: result lines of all monitors at the end of a run, and notes on outputs that are doubtful (too few
 * cells in a boundary layer, numerical diffusion, extrapolated curves or activities).
 */
#ifndef PD_MONITOR_REPORT_H
#define PD_MONITOR_REPORT_H
#include "run/monitor.h"

#ifdef PDI_APP_INTERNAL
/* Print notes on numerical diffusion and ionic strength of the model, then for each monitor that has outputs a line
 * "result case=... plane=up time=... flow=..." with the last ones, and its notes. Outputs that are NaN or infinite are
 * left out. print NULL: nothing. */
PDI_FN void pdi_monitor_report_print(const pd_monitors *monitors, pd_print_fn print, void *user);
#endif

#endif
