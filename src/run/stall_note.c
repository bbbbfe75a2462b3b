/* stall_note: see stall_note.h */
#include "run/stall_note.h"
#include "io/progress.h"
#include "setup/setup.h"
#include <math.h>

/* Append what the active solver attempts: its step from a time, or with a step of 0 the time alone; its steps accepted
 * so far, the number of the attempt after rejected ones, and why the last was: no solution (error infinite or NaN), or
 * an error above 1. */
static void pdi_stall_note_append_attempt(const pd_attempt *now, char *line, size_t size)
{
    char time[PD_UNITS_TEXT], dt[PD_UNITS_TEXT];
    pd_setup_format_value(now->time, "s", time);
    pd_setup_format_value(now->dt, "s", dt);
    if (!(now->dt > 0.0)) {
        pd_append(line, size, ": %s is solved at t = %s", now->name, time);
        return;
    }
    pd_append(line, size, ": %s tries a step of %s from t = %s", now->name, dt, time);
    if (now->accepted_steps)
        pd_append(line, size, ", after %.0f step%s of its own", (double)now->accepted_steps,
                  now->accepted_steps > 1 ? "s" : "");
    if (!now->rejected) return;
    pd_append(line, size, ", attempt %d", now->rejected + 1);
    if (!(now->error < HUGE_VAL)) pd_append(line, size, "; the one before found no solution");
    else if (now->error > 1.0)
        pd_append(line, size, "; the error of the one before was %.3g of what is allowed", now->error);
}

PDI_FN void pdi_stall_note_format(const pd_time_loop *c, double waited, const char *doing, int64_t count, char *line,
                                  size_t size)
{
    char spent[32], time[PD_UNITS_TEXT];
    line[0] = '\0';
    pdi_progress_format_duration(waited, spent, sizeof spent);
    pd_setup_format_value(c->time, "s", time);
    if (c->started) pd_append(line, size, "no step for %s, at t = %s", spent, time);
    else pd_append(line, size, "the start takes %s so far", spent);
    if (c->current.name) pdi_stall_note_append_attempt(&c->current, line, size);
    pd_append(line, size, " (%.40s %.0f)", doing, (double)count);
}
