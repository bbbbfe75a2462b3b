/* progress: text of a progress bar with the fraction done and the time left. The library prints nothing; a driver
 * shows the line on a terminal. */
#ifndef PD_PROGRESS_H
#define PD_PROGRESS_H
#include "core/config.h"

#ifdef PDI_APP_INTERNAL
/* Format a progress bar: line[size] = "dissolve [####........] 36.1 % 2 min 05 s, 3 min 41 s left". fraction: 0..1,
 * clamped (NaN is 0); elapsed [s]. The time left assumes the mean rate so far; it is left out at a fraction of 1 or
 * below 0.1 %, or before 1 s. Always terminated by 0, cut off when size is too small. */
PDI_FN void pdi_progress_format_line(double fraction, double elapsed, const char *label, char *line, size_t size);
/* Format a time [s]: text[size] = "0.25 s", "12.3 s", "2 min 05 s", "3 h 07 min" or "12 d 4 h"; "?": it is negative,
 * NaN, or 3e11 and more. */
PDI_FN void pdi_progress_format_duration(double seconds, char *text, size_t size);
#endif

#endif
