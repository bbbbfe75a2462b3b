/* monitor: scalar outputs of a run over time (planes, forces, mass transfer, totals, electrodes, ...), profiles and
 * plots.
 *
 * plane_up.csv, force_pin.csv, transfer_pin.csv, total_all.csv     one row a step line_centre_000012_t6.1s.csv,
 * line_centre_C_000012_t6.1s.png     at output times, as are the local values of a transfer
 *
 * Names of columns hold their units, "flow [m2/s]". Sherwood number: Sh = flux L / (area (C_surface - C_fluid) D); with
 * the bulk concentration, area (C_surface - C_fluid) is summed over the layers.
 */
#ifndef PD_MONITOR_H
#define PD_MONITOR_H
#include "io/output_folder.h"
#include "io/csv.h"
#include "physics/model.h"
#include "physics/summary.h"

#define PD_MONITOR_MAX_OUTPUTS 80 /* largest number of outputs of a monitor: of boxes, all species and balances */
#define PD_MONITOR_MAX_OUTPUTS_NO_SPECIES 24 /* the same without species */

/* A scalar output. */
typedef struct pd_monitor_output {
    char key[24], unit[16];
    double value; /* [unit] */
} pd_monitor_output;

/* A monitor: one section of the scene and its outputs. */
typedef struct pd_monitor {
    const pd_setup_monitor *desc;
    pd_csv table;
    int count;              /* number of outputs */
    int capacity;           /* capacity of figure[] */
    pd_monitor_output *output; /* [room] */
    int64_t flow_solves;       /* force: number of flow solves at the last update */
    int columns, rows;      /* of the profile */
    double *profile;        /* [rows][columns] [unit of the column] */
    double *flux, *area, *fluid; /* [rows] [mol/s] [m^(d-1)] [mol/m3] transfer: of the layers */
} pd_monitor;

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
/* State of an electrode now (potential, currents, charge), from the potential solver or, with migrating ions, from the
 * species solver. */
PDI_FN void pdi_monitor_get_electrode(const pd_model *model, int electrode, pd_cell_electrode *e);
/* Close all tables; those not open are allowed. PD_ERR_FILE: rows could not be written; the tables behind stay open
 * until pdi_monitors_free. */
PDI_FN pd_status pdi_monitors_close(pd_ctx *ctx, pd_monitors *monitors);
/* Close the tables, free all memory and zero monitors. Zeroed ones are allowed. A table that fails to close is no
 * error, and the message of ctx stays. */
PDI_FN void pdi_monitors_free(pd_ctx *ctx, pd_monitors *monitors);
#endif

#endif
