/* fit: parameters of a scene fitted to measured points by bounded nonlinear least squares over runs.
 *
 *   const char *range[] = {"dissolve.rate_scale=0.5..2", "transport.D=1e-10..1e-8 m2/s"};
 *   pd_fit_desc desc = {0};            desc.scene = "wire.scene";  desc.range = range;  desc.ranges = 2;
 *   pd_fit_run(&ctx, &desc, &fit);     fit.override: what a run at the result takes, "dissolve.rate_scale=1.07"
 *
 * The lattice at 4 h is fitted first, then those at 2 h and h from where it ended. Points weigh by their spread.
 */
#ifndef PD_FIT_H
#define PD_FIT_H
#include "solve/least_squares.h"
#include "run/run.h"

#define PD_FIT_TEXT 160 /* [byte] of a key or a unit */

typedef struct pd_fit_desc {
    const char *scene;
    const char *const *overrides; /* [count] of all runs */
    int count;
    const char *const *range;     /* [ranges] "KEY=LOW..HIGH UNIT" */
    int ranges;
    /* "wire.csv  start = 0.7 h", see read_measured.h; NULL: the points of the scene */
    const char *measured;
    int skips_coarser;            /* 1: no coarser ones */
    pd_print_fn print;            /* a line for each step; NULL: silent */
    void *print_user;
    int (*stop)(void *user);      /* as for pd_run */
    void *stop_user;
} pd_fit_desc;

/* A parameter of the scene and its bounds. */
typedef struct pd_fit_parameter {
    char key[PD_FIT_TEXT];        /* as in an override */
    char unit[PD_UNITS_TEXT];     /* of the values; "": none */
    double low, high;             /* [unit] */
} pd_fit_parameter;

/* The result of a fit. */
typedef struct pd_fit {
    char name[PD_SETUP_NAME];     /* of the case */
    pd_fit_parameter parameter[PD_LEAST_SQUARES_PARAMETERS];
    int parameters;
    pd_least_squares_result result;                              /* on the lattice of the scene */
    char override[PD_LEAST_SQUARES_PARAMETERS][2 * PD_FIT_TEXT]; /* "KEY=VALUE UNIT" of the result */
    int points;                   /* that count */
    char output[2 * PD_SETUP_NAME], unit[PD_UNITS_TEXT]; /* of the first section of points */
    int measured_sets;
    double rms;                   /* [unit] one section; [-] several: of differences over spreads */
    int has_spread;               /* the points have a spread */
    double h;                     /* [m] along x */
    int evaluations;              /* on all lattices */
    int bad_input;                /* the failure lies in what was asked for */
} pd_fit;

#define pd_fit_run PD_NAME(pd_fit_run)
#define pd_fit_format_result PD_NAME(pd_fit_format_result)
#define pd_fit_read_setup PD_NAME(pd_fit_read_setup)

/* Fit the parameters; *fit is zeroed first. PD_ERR_ARGUMENT, PD_ERR_PARSE: a range, a key that the scene does not have,
 * points without spread beside others, fewer points than parameters, a parameter without effect; fit->bad_input is 1
 * then. A run that fails at a trial value ends the fit with its status and the value; one at 4 h or 2 h is only noted.
 * PD_CANCELLED: stopped, whatever the lattice. PD_NOT_CONVERGED as for pd_least_squares_solve; the result is filled. */
PD_API pd_status pd_fit_run(pd_ctx *ctx, const pd_fit_desc *desc, pd_fit *fit);
/* Write "result case=... fit=volume_loss points=9 rms=... KEY=1.07 KEY.error=0.02 ..." into text[size], cut off there;
 * size 0: nothing. fit=several with several sets. Values that are NaN or infinite are left out. */
PD_API void pd_fit_format_result(const pd_fit *fit, char *text, size_t size);
/* Read the setup of the runs with the overrides of desc and `count` more, which come last, and with its points, for
 * pd_setup_free; on failure it is freed. PD_ERR_ARGUMENT: it has no points, or there are more than 128 overrides (setup
 * is not touched then). Errors of pd_scene_read. */
PD_API pd_status pd_fit_read_setup(pd_ctx *ctx, const pd_fit_desc *desc, const char *const *more, int count,
                                   pd_setup *setup);

#endif
