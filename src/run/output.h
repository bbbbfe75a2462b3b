/* output: the files of a run: fields, pictures, diagnostics, probes, the curve of the volume loss.
 *
 *   corr_000012_t6.1s.vti, simulation.pvd   fields for ParaView; open_in_paraview.py
 *   C_000012_t6.1s.png                      pictures
 *   diagnostics.csv, probes.csv             one row a step
 *   volume_loss.png                         at the end, `live`: with each picture
 *   latest_C.png                            `live`: the last picture
 *
 * Everything is written aside and renamed; the tables grow row by row.
 */
#ifndef PD_OUTPUT_H
#define PD_OUTPUT_H
#include "io/output_folder.h"
#include "io/vti.h"
#include "io/csv.h"
#include "run/pictures.h"
#include "physics/step_diagnostics.h"

/* The output files of a run. */
typedef struct pd_output {
    pd_model *model;
    pd_output_folder *folder;
    pd_pvd pvd;
    pd_csv diagnostics, probes;
    int frame;                /* of the next fields */
    double last_frame_time;   /* [s] time of the last fields, -1: none */
    double *scalar[PD_FIELD_COUNT]; /* [total] [unit of the field]; NULL: not wanted or no copy needed */
    uint8_t *phase;           /* [total] */
    int32_t *grain;           /* [total] -1: not in the metal */
    double *displaced;        /* [PD_DIM][total] [m] */
    pd_output_pictures images;
    double *time, *loss;      /* [rows] [h] and [-] */
    int64_t rows, time_room, loss_room;
    int curve[2];             /* 1: volume_loss.png, .svg stands in the list of the folder */
} pd_output;

#ifdef PDI_APP_INTERNAL
/* Zero out, create diagnostics.csv, probes.csv (with probes), the file of frames and, with fields, the ParaView script,
 * and prepare pictures. model and folder, which is open, are borrowed. On failure pdi_output_free. PD_ERR_FILE. */
PDI_FN pd_status pdi_output_open(pd_ctx *ctx, pd_model *model, pd_output_folder *folder, pd_output *out);
/* Store the lengths of the files and the loss curve in a checkpoint. */
PDI_FN pd_status pdi_output_save(pd_ctx *ctx, pd_output *out, pd_archive *archive);
/* In place of pdi_output_open: continue the files at the lengths that the checkpoint holds; what was written later is
 * cut off. PD_ERR_FILE: a table is missing or shorter. */
PDI_FN pd_status pdi_output_resume(pd_ctx *ctx, pd_model *model, pd_output_folder *folder, pd_archive *archive,
                                   pd_output *out);
/* Write a row of the diagnostics table and, with probes, of the probe table, sampled now; append the volume loss to the
 * curve, also without dissolution. */
PDI_FN pd_status pdi_output_write_rows(pd_ctx *ctx, pd_output *out, const pd_step_diagnostics *o);
/* Write fields and pictures now and count the frame; nothing if the last ones are of this time or a later one. On
 * failure the frame does not count. With updates_latest the loss curve is drawn, too. */
PDI_FN pd_status pdi_output_write_frame(pd_ctx *ctx, pd_output *out);
/* Draw the loss curve and close the tables. over: 1: the run is complete, and its pictures get a common range before.
 * PD_CANCELLED: interrupted meanwhile; after a failure the tables may still be open, until pdi_output_free. */
PDI_FN pd_status pdi_output_close(pd_ctx *ctx, pd_output *out, int over);
/* Close the tables, free all memory and zero out. A zeroed one is allowed. */
PDI_FN void pdi_output_free(pd_ctx *ctx, pd_output *out);
#endif

#endif
