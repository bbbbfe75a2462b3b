/* compare_measured: a run against the measured points of its scene: what it computes at their times, differences,
 * plots.
 *
 *   measured_wire.csv   points, what was computed there, differences; at the end
 *   measured_wire.png   points and the curve of their figure; those of the volume loss stand in volume_loss.png
 *
 * Steps end on the times of the points, so nothing is interpolated. A point counts that lies behind the start: there
 * the run has nothing to compute.
 */
#ifndef PD_COMPARE_MEASURED_H
#define PD_COMPARE_MEASURED_H
#include "io/output_folder.h"
#include "run/scalar_outputs.h"

/* One set of measured points, and the computed values. */
typedef struct pd_measured_set {
    const pd_setup_measured *record;
    double *computed;     /* [points] [unit of the column in SI]; NaN: not reached, or not behind the start */
    double *time, *value; /* [rows] [s] SI: the output after every step */
    int64_t rows, time_capacity, value_capacity;
} pd_measured_set;

/* All measured sets of a setup. */
typedef struct pd_measured_comparison {
    pd_model *model;
    const pd_monitors *monitors;
    const double *monitor_weight;                /* [-] of each monitor in the figures of its section; NULL: 1 */
    int keeps_curves;                            /* 1: outputs are kept after every step, for plots */
    int error_line;                              /* line of the scene that an error is about */
    pd_scalar_outputs figures;                   /* work */
    pd_measured_set list[PD_SETUP_MEASURED_MAX]; /* setup->records of them */
} pd_measured_comparison;

/* How a run and its points differ. */
typedef struct pd_measured_error {
    int points, within_spread;  /* points that count; those of them whose difference is at most their spread */
    double rms, max_difference; /* [unit of the column] */
    double max_difference_time; /* [s] time of the largest difference */
} pd_measured_error;

#ifdef PDI_APP_INTERNAL
/* Zero and build the comparison; model and monitors, which are built, and share, the weight [-] of each monitor (NULL:
 * 1), are borrowed. curves 1: keep outputs after every step. Without measured sets it stays empty. On failure compare
 * is zero but for error_line. PD_ERR_ARGUMENT: a figure that the run does not watch, or of another dimension than the
 * points. */
PDI_FN pd_status pdi_compare_measured_build(pd_ctx *ctx, pd_model *model, const pd_monitors *monitors,
                                            const double *share, int curves, pd_measured_comparison *compare);
/* Free the comparison and zero it. A zeroed one is allowed. */
PDI_FN void pdi_compare_measured_free(pd_ctx *ctx, pd_measured_comparison *compare);
/* Smallest time [s] of a measured point that is positive, behind `time` [s] by more than 1e-9 of it, and below t_end
 * [s]; t_end where there is none. */
PDI_FN double pdi_compare_measured_find_next_time(const pd_measured_comparison *compare, double time, double t_end);
/* 1: pdi_compare_measured_step needs the scalar outputs at `time` [s]: curves are kept, or a point lies at this time
 * within 1e-9 of it. 0 without measured points, and before the build. */
PDI_FN int pdi_compare_measured_needs_output(const pd_measured_comparison *compare, double time);
/* Record the present outputs, which the monitors hold, at the measured points of this time, and, if curves are kept, as
 * a new row of each curve. Points of other times keep their values. Nothing without measured sets. */
PDI_FN pd_status pdi_compare_measured_step(pd_ctx *ctx, pd_measured_comparison *compare);
/* Root mean square and largest absolute difference of computed and measured values of one set, in the unit of its
 * column, not weighted by the spread; within_spread counts differences <= spread, 0 without spread. Points whose
 * computed value is NaN do not count; without others rms, largest difference and its time are NaN. At equal differences
 * the first time counts. */
PDI_FN void pdi_compare_measured_compute_error(const pd_measured_set *compared, pd_measured_error *result);
/* Write a table for each set and a plot where it has a curve of two rows or more and is not of the volume loss; enter
 * them in the list of the folder. PD_ERR_FILE. */
PDI_FN pd_status pdi_compare_measured_write(pd_ctx *ctx, const pd_measured_comparison *compare,
                                            pd_output_folder *folder);
/* Print a line "result case=... measured=wire of=volume_loss unit=% points=9 rms=... largest=..." for each section;
 * values that are NaN are left out, blanks of the unit become *. print NULL, or no section: nothing. */
PDI_FN void pdi_compare_measured_print(const pd_measured_comparison *compare, pd_print_fn print, void *user);

/* Store the computed values and curves in a checkpoint, or load them, growing the curves. PD_ERR_ARGUMENT: the
 * checkpoint has another number of points. */
PDI_FN pd_status pdi_compare_measured_store(pd_ctx *ctx, pd_measured_comparison *compare, pd_archive *archive);
#endif

#endif
