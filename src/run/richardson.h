/* richardson: the error of a run by Richardson's extrapolation, from runs on lattices of two and four times the
 * spacing.
 *
 * With the figures f1, f2, f4 at h, 2 h, 4 h the observed order is p = log2((f4 - f2)/(f2 - f1)), and f1 is off by
 * |f2 - f1|/(2^p - 1). Where there is no lattice at 4 h, or p lies outside 0.5 .. 3 (the differences are not yet those
 * of a power of h), p is the order of the method: 2 for flow and transport, 1 where dissolution or upwinding decides.
 * The larger of the differences |f2 - f1| and |f4 - f2|/2^p counts then. Tolerances and steps between outputs are those
 * of the run, so their errors show only as far as they change with h.
 */
#ifndef PD_RICHARDSON_H
#define PD_RICHARDSON_H
#include "run/run.h"
#include "run/coarsen_setup.h"

/* A scalar output with its observed order and error. */
typedef struct pd_richardson_output {
    pd_scalar_output figure; /* of the run */
    double coarser[2]; /* [unit of the figure] at 2 h and 4 h; NaN: none */
    double order;      /* [-] */
    int is_formal_order; /* 1: the formal order of the method, not the observed one */
    double error;      /* [-] of the figure, over its size; NaN: unknown */
    int is_minor;      /* below a tenth of the largest figure of its sort (same unit, same first letter), so that its
                        * relative error says little */
} pd_richardson_output;

/* The error estimate of a run. */
typedef struct pd_richardson {
    const pd_setup *setup;
    int coarser_runs;            /* runs it rests on, 1 or 2 */
    char missing_reason[PD_MESSAGE_SIZE]; /* why there is no second one; "": there is */
    pd_richardson_output *list;    /* [count] */
    int count;
    int order;                   /* of the flow of the run, which coarser runs keep; 0: theirs */
    int worst_output;            /* index of the largest error of those that are not minor; -1: none */
    double wall_time;            /* [s] that they took */
} pd_richardson;

#define pd_richardson_run PD_NAME(pd_richardson_run)
#define pd_richardson_print PD_NAME(pd_richardson_print)
#define pd_richardson_suggest_spacing PD_NAME(pd_richardson_suggest_spacing)
#define pd_richardson_free PD_NAME(pd_richardson_free)

/* Run the coarser lattices of a run that gave `figures`, which are copied; desc says when to stop. *estimate is zeroed
 * first. With desc->check_only they are only built: errors are NaN then, and coarser_runs and missing_reason count.
 * setup is borrowed. Errors of pdi_coarsen_setup_build and pd_run at 2 h: the estimate is freed, the run stands; those
 * at 4 h only if fatal. PD_CANCELLED: stopped. */
PD_API pd_status pd_richardson_run(pd_ctx *ctx, const pd_setup *setup, const pd_run_desc *desc,
                                   const pd_scalar_outputs *figures, pd_richardson *estimate);
/* Print a line "result case=... estimate=richardson ..." for each section with figures and then one for the scene, and
 * a note if there is no second coarser run. Values that are NaN or infinite are left out. print NULL: nothing. */
PD_API void pd_richardson_print(const pd_richardson *estimate, pd_print_fn print, void *user);
/* The largest h[PD_DIM] [m] that divides the boxes of the run and of the coarser ones, and at which no figure but minor
 * ones should be off by more than `accuracy` [-], as far as the orders hold; h of the run when that is so already. */
PD_API void pd_richardson_suggest_spacing(const pd_richardson *estimate, double accuracy, double *h);
/* Free the outputs of the estimate and zero it. A zeroed one is allowed. */
PD_API void pd_richardson_free(pd_ctx *ctx, pd_richardson *estimate);

#endif
