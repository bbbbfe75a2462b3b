/* monitor: monitors of a run: their outputs in one table each, a row a step, and their profiles at output times.
 *
 * plane_up.csv, force_pin.csv, transfer_pin.csv, total_all.csv
 *
 * Names of columns hold their units, "flow [m2/s]".
 */
#ifndef PD_MONITOR_H
#define PD_MONITOR_H
#include "io/output_folder.h"
#include "run/monitor_outputs.h"
#include "physics/summary.h"

typedef struct pd_monitors {
    pd_model *model;
    pd_output_folder *folder;              /* borrowed */
    int error_line;                        /* line of the scene that an error is about */
    pd_monitor monitor[PD_SETUP_MONITORS]; /* setup->monitors of them */
} pd_monitors;

#ifdef PDI_APP_INTERNAL
/* Zero monitors, build all of the setup and compute their outputs once; model is borrowed. On failure all are freed,
 * and error_line says where the scene asks for what failed. PD_ERR_GEOMETRY: a probe deep in a wall, a box around a
 * body that comes too close to other walls. */
PDI_FN pd_status pdi_monitors_build(pd_ctx *ctx, pd_model *model, pd_monitors *monitors);
/* Create the tables in an open folder, which is borrowed. A monitor without outputs, as a line, has none.
 * PD_ERR_FILE. */
PDI_FN pd_status pdi_monitors_open(pd_ctx *ctx, pd_monitors *monitors, pd_output_folder *folder);
/* Flush the tables and store their lengths in a checkpoint; the tables have to be open. */
PDI_FN pd_status pdi_monitors_save(pd_ctx *ctx, pd_monitors *monitors, pd_archive *archive);
/* In place of pdi_monitors_open: cut the tables to the lengths that the checkpoint holds and open them to append.
 * PD_ERR_FILE: one is missing or shorter. */
PDI_FN pd_status pdi_monitors_resume(pd_ctx *ctx, pd_monitors *monitors, pd_output_folder *folder, pd_archive *archive);
/* Compute all outputs now and write a row to each table that is open; without open tables only compute. Nothing without
 * monitors. Fills the ghosts of concentrations; before the first step the sources of dissolution are computed, too. At
 * the first error the remaining monitors keep their old outputs. */
PDI_FN pd_status pdi_monitors_step(pd_ctx *ctx, pd_monitors *monitors);
/* Write profiles and plots of lines, and of transfers along an axis, at output time number `frame`, after
 * pdi_monitors_step. Monitors of fewer than two rows are skipped: a transfer without axis or with one layer. */
PDI_FN pd_status pdi_monitors_write_frame(pd_ctx *ctx, pd_monitors *monitors, int frame);
/* Close all tables; those not open are allowed. PD_ERR_FILE: rows could not be written; the tables behind stay open
 * until pdi_monitors_free. */
PDI_FN pd_status pdi_monitors_close(pd_ctx *ctx, pd_monitors *monitors);
/* Close the tables, free all memory and zero monitors. Zeroed ones are allowed. A table that fails to close is no
 * error, and the message of ctx stays. */
PDI_FN void pdi_monitors_free(pd_ctx *ctx, pd_monitors *monitors);
#endif

#endif
