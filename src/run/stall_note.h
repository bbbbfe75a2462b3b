/* stall_note: note on a run that has made no step for long: which solver is active, at what time, and its present
 * attempt.
 */
#ifndef PD_STALL_NOTE_H
#define PD_STALL_NOTE_H
#include "couple/time_loop.h"

#ifdef PDI_APP_INTERNAL
/* Write "no step for 10.0 s, at t = 3 s: species in time tries a step of 2 ms from t = 3 s, attempt 7; the error of the
 * one before was 12 of what is allowed (GMRES 40)" into line[size]; before the start is done "the start takes 10.0 s so
 * far". waited [s]; doing, count: as the poll function gets them. */
PDI_FN void pdi_stall_note_format(const pd_time_loop *couple, double waited, const char *doing, int64_t count,
                                  char *line, size_t size);
#endif

#endif
