/* read_measured: reads the [measured NAME] sections of a scene: points of a watched figure, which a run is compared
 * with.
 *
 *   [measured wire]  file = wire.csv  time = time_h in h  value = loss_pct in %  spread = spread_pct in %
 *                    of = volume_loss | plane.NAME.flow | force.NAME.fx | ... | probe.NAME.C  start = 0 h
 *
 * Without `time` and `value` they are the first two columns, in the units of their headings ("time [h]"), and a column
 * whose heading begins with "spread" is the spread. start: the time of the file at which the run begins.
 */
#ifndef PD_READ_MEASURED_H
#define PD_READ_MEASURED_H
#include "io/plot.h"
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Read all [measured NAME] sections, after the end time of the run is known, and append them to setup->measured;
 * pd_setup_free_measured frees their arrays. folder: of the scene. Whether the run has the figure is checked when the
 * model is built. PD_ERR_PARSE, PD_ERR_ARGUMENT with the lines of the scene and of the data file: also where no point
 * of a section lies in the run. */
PDI_FN pd_status pdi_read_measured_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup);
/* Replace all measured sections of the setup by one of a command-line text, as it would follow "file =": "wire.csv
 * start = 0.7 h". Its line is 0. `where` is the location at the start of messages. PD_ERR_ARGUMENT: a text that is too
 * long or has a newline; the old sections stay. After any other error they are gone. */
PDI_FN pd_status pdi_read_measured_replace(pd_ctx *ctx, const char *where, const char *text, pd_setup *setup);
/* 1: the time of a data point lies in the run, 0 < t <= until [s], with a relative tolerance of 1e-9 at the end; such
 * points enter the comparison. */
PDI_FN int pdi_read_measured_is_in_run(const pd_setup_measured *record, int point, double until);
/* Make the plot series of the data points with 0 <= t <= last [s]: markers with error bars, of length 0 without a
 * spread, in units of x_unit [s] and y_unit [SI]. work [3 points]: memory that the series refers to. series->count may
 * be 0. */
PDI_FN void pdi_read_measured_build_series(const pd_setup_measured *record, double x_unit, double y_unit, double last,
                                           double *work, pd_series *series);
#endif

#endif
