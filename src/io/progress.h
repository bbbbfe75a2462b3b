/* progress: one line of text with the share done and the time left. The library prints nothing; a driver shows the
 * line, on a terminal only. */
#ifndef PD_PROGRESS_H
#define PD_PROGRESS_H
#include "core/config.h"

#ifdef PDI_INTERNAL
/* line[size] = "dissolve [####........]  36.1 %  2 min 05 s, 3 min 41 s left". fraction in 0..1 (clamped;
 * NaN counts as 0), elapsed [s]. The time left assumes that work goes on at the mean rate; below 0.1 % or 1 s no
 * figure is given. Always ended by 0, cut when size is too small. */
PDI_FN void pdi_progress_line(double fraction, double elapsed, const char *label, char *line, size_t size);
/* text[size] = "0.25 s", "12.3 s", "2 min 05 s", "3 h 07 min", "12 d 4 h" of a time in seconds. */
PDI_FN void pdi_progress_duration(double seconds, char *text, size_t size);
#endif

#endif
