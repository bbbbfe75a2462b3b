/* physics: the interface between one physics and the time loop: a table of callbacks, and the step control with
 * retries.
 *
 * A process is the solver of the equations of one physics. It is quasi-steady (`solve_at`) or it advances by time steps
 * (`attempt`). The time loop of time_loop.h runs a list of processes; the `_run` function of a physics runs one alone.
 * The loop of step limits, attempts and retries is in this module only. Each callback may be NULL unless noted.
 */
#ifndef PD_PHYSICS_H
#define PD_PHYSICS_H
#include "core/archive.h"

/* Solve the quasi-steady processes at time t [s]. */
typedef pd_status (*pd_solve_at_fn)(pd_ctx *ctx, void *user, double t);

/* Progress information: the step that is being attempted. */
typedef struct pd_attempt {
    const char *name; /* of the process; NULL: none is in a step */
    double time;      /* [s] start of its step */
    double dt;        /* [s] step size; 0: the process is quasi-steady, or is being initialised */
    double error;     /* [-] error over tolerance of the previous attempt; HUGE_VAL: it did not converge */
    int rejected;     /* rejected attempts of this step */
    int64_t accepted_steps; /* substeps accepted since the last step of the run */
} pd_attempt;

/* One time step of a process, and what it needs to know of the run. */
typedef struct pd_step {
    double time;      /* [s] start of the step */
    double latest_end; /* [s] latest end of the step */
    double dt;        /* [s] step size of the next attempt */
    double end;       /* [s] end of the attempt: latest_end, or time + dt */
    double error;     /* [-] error of the attempt over its tolerance, for `accept` and `reject` of the process */
    int rejected;     /* rejected attempts of this step */
    int ends_substeps; /* 1: set by `accept`: the processes after this one have to step before it steps again */
    /* [-] of the run: largest fraction of the metal of a node that dissolves in a step */
    double max_dissolved_fraction;
    double rtol;      /* [-] of the run: relative time discretisation error of the amount dissolved */
    double max_step;  /* [s] of the run; 0: no limit */
    double dissolved; /* [unit of its elements] solid dissolved by the process since the start of the run */
    pd_solve_at_fn solve_at; /* to be called before equations at a time are solved; NULL: nothing is quasi-steady */
    void *solve_at_user;
    double (*time_limit)(void *user, double t, double end); /* latest end [s] of a step from t that resolves the
                                                             * time-dependent inputs; NULL: there are none */
    void *time_limit_user;
    pd_attempt *progress;           /* receives progress information; NULL: not wanted */
    const int32_t *converted_nodes; /* [converted_count] set by `accept`: the solid nodes that became fluid */
    int32_t converted_count;
} pd_step;

/* A conserved quantity. Processes that name the same element share one mass balance. */
typedef struct pd_element {
    const char *name, *unit;
} pd_element;

/* Amounts of one element in the mass balance [unit of the element; per m depth in planar 2D, per m2 in 1D]. */
typedef struct pd_amounts {
    double solid;     /* [unit] in metal */
    double volume;    /* [m3] (m2 in planar 2D, m in 1D) of that metal */
    double dissolved; /* [unit] in fluid */
    /* [unit] undelivered: residual of the last linear solve, or debris; the next step delivers it */
    double undelivered;
    double out, in;   /* [unit] outflow and inflow through the sides since the start */
} pd_amounts;

/* The callbacks of one physics. */
typedef struct pd_physics {
    const char *name; /* for polls, messages and checkpoints */
    void *self;
    const double *time; /* [s] its present time; NULL: it cannot run alone */
    const pd_element *element; /* [elements] */
    int elements;
    int has_substeps; /* 1: it takes substeps within a step of the run */
    /* Latest end [s] of an attempt from t to `end` that resolves the time dependence of its own rate laws, all else
     * being as it is at t (tried = 0: before the attempt) or at `end` (1: after it). NULL: nothing depends on time */
    double (*time_limit)(void *user, double t, double end, int tried);
    void *time_limit_user;
    const int64_t *steps; /* count of its substeps; NULL: not counted */
    /* Called once at the initial time t [s], before the first mass balance. */
    pd_status (*start)(pd_ctx *ctx, void *self, double t);
    /* Quasi-steady processes: solve at time t [s]. */
    pd_solve_at_fn solve_at;
    /* Lower step->dt to the largest step of the run that suits the process. Called when the first process takes several
     * substeps in a step of the run; a process that takes a single step limits it by `limit`. */
    pd_status (*max_run_step)(pd_ctx *ctx, void *self, pd_step *step);
    /* Begin a step: lower step->dt to the largest admissible step; latest_end may be lowered, too. */
    pd_status (*limit)(pd_ctx *ctx, void *self, pd_step *step);
    /* Compute a step of step->dt from step->time. PD_RETRY: its error is too large, `reject` follows. */
    pd_status (*attempt)(pd_ctx *ctx, void *self, pd_step *step);
    /* Accept the attempt as the step. */
    pd_status (*accept)(pd_ctx *ctx, void *self, pd_step *step);
    /* Restore the state at the start of the step and reduce step->dt. Fails when no smaller step helps. Never NULL
     * where `attempt` may return PD_RETRY. */
    pd_status (*reject)(pd_ctx *ctx, void *self, pd_step *step);
    /* Report step underflow with a message of this physics: step->dt is below the rounding error of time. Returns an
     * error. NULL: a general message. */
    pd_status (*report_underflow)(pd_ctx *ctx, void *self, const pd_step *step);
    /* End of a step of the run at t [s]. Quasi-steady processes: after the mass balance; others: when they reach t. */
    pd_status (*finish)(pd_ctx *ctx, void *self, double t);
    /* Solid nodes [count] became fluid; the bonds have been updated. */
    pd_status (*nodes_converted)(pd_ctx *ctx, void *self, const int32_t *converted, int32_t count);
    /* Write the state to a checkpoint, or read it. */
    pd_status (*checkpoint)(pd_ctx *ctx, void *self, pd_archive *archive);
    /* Add the present amounts of element k of this process to the mass balance. */
    void (*add_amounts)(pd_ctx *ctx, void *self, int k, pd_amounts *amounts);
    /* Largest relative error [-] of the balances that the process keeps itself. */
    double (*imbalance)(pd_ctx *ctx, void *self);
} pd_physics;

#define pd_physics_run PD_NAME(pd_physics_run)

/* Run a process alone up to t_end [s], then call its `finish`. PD_NOT_CONVERGED: a step returned it; the run goes on to
 * t_end. PD_ERR_ARGUMENT: t_end is before its time or NaN, or the process has no time. PD_ERR_STATE: step underflow, or
 * t_end is not reached in 1e10 steps. Others: of the process; the run ends there. */
PD_API pd_status pd_physics_run(pd_ctx *ctx, pd_physics process, double t_end);

#ifdef PDI_INTERNAL
/* Progress of a run: steps since the time `from`. Initialise with the initial time and 0 steps. */
typedef struct pdi_physics_progress {
    double since; /* [s] */
    int steps;
} pdi_physics_progress;
/* Count one accepted step; with every 1000th one, at the end `time` [s] of the step, check the progress and start to
 * count anew. PD_ERR_STATE: with steps like the last 1000 on average, `end` [s] is not reached in 1e10 steps. */
PDI_FN pd_status pdi_physics_check_progress(pd_ctx *ctx, const char *name, pdi_physics_progress *pace, double time,
                                            double end);
/* Size [s] of equal steps that divide the time `left` [s]: the fewest of at most dt [s] each, but for 1e-12 of it. */
PDI_FN double pdi_physics_equal_steps(double left, double dt);
/* A max_run_step callback: lowers step->dt to step->max_step, the limit of the run, if there is one. self is not
 * used. */
PDI_FN pd_status pdi_physics_limit_max_step(pd_ctx *ctx, void *self, pd_step *step);
/* Take one accepted step from step->time to step->end, at most to step->latest_end. Attempts are repeated with smaller
 * steps where `attempt` returns PD_RETRY, or the time limit of the process after it is before the end. Sets dt, end,
 * rejected and what `accept` sets of step. PD_ERR_STATE: step underflow or 1000 attempts; other errors and
 * PD_NOT_CONVERGED, with which the step counts as accepted, are those of the process. */
PDI_FN pd_status pdi_physics_step(pd_ctx *ctx, const pd_physics *process, pd_step *step);
#endif

#endif
