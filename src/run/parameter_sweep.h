/* parameter_sweep: parameter study: one run of a scene for every combination of a few values, a folder each, one table
 * and plot.
 *
 *   const char *axes[] = {"mean=0.01, 0.05, 0.2 m/s", "h = 10 um, 20 um"};
 *   pd_parameter_sweep_build(&ctx, &desc, &sweep);    every run's scene is read here, so a bad value fails before any
 * run for (k = 0; k < sweep.runs; k++) pd_parameter_sweep_run(&ctx, &sweep, k, &run_desc);
 *   pd_parameter_sweep_write(&ctx, &sweep, &count);
 *   pd_parameter_sweep_free(&ctx, &sweep);
 *
 * Runs know nothing of each other, and leave what the table needs in their folders: they may be made by several
 * processes side by side.
 */
#ifndef PD_PARAMETER_SWEEP_H
#define PD_PARAMETER_SWEEP_H
#include "run/run.h"

#define PD_PARAMETER_SWEEP_MAX_AXES 8       /* most axes */
#define PD_PARAMETER_SWEEP_MAX_RUNS 4096    /* most runs */
#define PD_PARAMETER_SWEEP_VALUE_BYTES 128  /* [byte] "key=value" of an axis */
#define PD_PARAMETER_SWEEP_MAX_OVERRIDES 64 /* most overrides beside the axes */

/* Zero-initialise. All of it is borrowed as long as the sweep lives. */
typedef struct pd_parameter_sweep_desc {
    const char *scene;              /* path */
    const char *const *overrides;   /* [count] of all runs */
    int count;
    const char *const *axes;        /* [axis_count] "key=value, value, ..."; the last unit counts for numbers without */
    int axis_count;
    const char *folder;             /* of the table; runs are below it. NULL: that of the scene */
} pd_parameter_sweep_desc;

/* A swept parameter and its values. */
typedef struct pd_parameter_sweep_axis {
    char name[PD_PARAMETER_SWEEP_VALUE_BYTES]; /* the key, with the unit in brackets when all values share one */
    char *text;                                /* [count][PD_PARAMETER_SWEEP_VALUE_BYTES] "key=value" */
    int count;
    int unit_bytes; /* [byte] length of the unit at the end of values, which the table leaves out */
} pd_parameter_sweep_axis;

/* A parameter study. */
typedef struct pd_parameter_sweep {
    pd_parameter_sweep_desc desc;
    pd_parameter_sweep_axis axis[PD_PARAMETER_SWEEP_MAX_AXES]; /* the last one changes fastest */
    int axes, runs;
    char name[PD_SETUP_NAME];
    char folder[PD_PATH_SIZE];
    int has_dissolution; /* 1: metal dissolves, so that there are loss curves */
} pd_parameter_sweep;

/* How many runs ended how. */
typedef struct pd_parameter_sweep_count {
    int done, failed, stopped;
} pd_parameter_sweep_count;

#define pd_parameter_sweep_build PD_NAME(pd_parameter_sweep_build)
#define pd_parameter_sweep_label PD_NAME(pd_parameter_sweep_label)
#define pd_parameter_sweep_run PD_NAME(pd_parameter_sweep_run)
#define pd_parameter_sweep_write PD_NAME(pd_parameter_sweep_write)
#define pd_parameter_sweep_free PD_NAME(pd_parameter_sweep_free)

/* Parse the axes, read every scene to check it, then delete the result files of a former sweep; desc is borrowed. On
 * failure sweep is zero. PD_ERR_ARGUMENT: an axis without key or value, twice the same key, too many axes, values,
 * overrides or runs. PD_ERR_FILE: the folder of a run is a link. Errors of pd_scene_read for the first scene that is
 * refused. */
PD_API pd_status pd_parameter_sweep_build(pd_ctx *ctx, const pd_parameter_sweep_desc *desc, pd_parameter_sweep *sweep);
/* Write "run003 mean=0.2 m/s h=10 um" of run `index` into text[size]. */
PD_API void pd_parameter_sweep_label(const pd_parameter_sweep *sweep, int index, char *text, size_t size);
/* Make run `index`, 0 .. runs - 1, in its folder run001, run002, ..., which is created; `desc` as for pd_run, but for
 * the folder. Leaves how it ended in the result file there, "failed" from the start on until it has ended. Returns its
 * status, PD_RETRY when it was stopped: a run that fails is no failure of the sweep. PD_ERR_FILE: the folder is a link,
 * or cannot be written. */
PD_API pd_status pd_parameter_sweep_run(pd_ctx *ctx, const pd_parameter_sweep *sweep, int index,
                                        const pd_run_desc *desc);
/* Write sweep.csv, a row for each run with its values and all figures of its result line, and, if metal dissolves,
 * sweep.png, volume loss over time. *count: how they ended; a run that was not begun, or whose result file cannot be
 * read, counts as stopped. PD_ERR_FILE. */
PD_API pd_status pd_parameter_sweep_write(pd_ctx *ctx, const pd_parameter_sweep *sweep,
                                          pd_parameter_sweep_count *count);
/* Free the texts of the axes and zero the sweep; files stay. A zeroed one is allowed. */
PD_API void pd_parameter_sweep_free(pd_ctx *ctx, pd_parameter_sweep *sweep);

#endif
