/* process: a physics that moves in time, as the driver of a run sees it.
 *
 * A process owns the equations of some fields. It is quasi-steady (`at`) or it moves by steps (`attempt`). A list of
 * processes is what couple.h runs, and one process alone is what the `_run` function of a physics runs: the loop of
 * limits, attempts, retries and times is here and nowhere else. Each function may be NULL unless noted.
 */
#ifndef PD_PROCESS_H
#define PD_PROCESS_H
#include "core/archive.h"

/* Bring the quasi-steady processes to time t [s]. */
typedef pd_status (*pd_at_fn)(pd_ctx *ctx, void *user, double t);

/* What is being tried, for those who wait. */
typedef struct pd_attempt {
    const char *name; /* of the process; NULL: none has a step at hand */
    double time;      /* [s] where its step begins */
    double dt;        /* [s] of the attempt; 0: it is quasi-steady, or starts */
    double error;     /* [-] of the attempt before this one, over what is allowed; HUGE_VAL: it had no solution */
    int trial;        /* attempts before this one */
    int64_t steps;    /* that have been accepted since the last step of the run */
} pd_attempt;

/* A step at hand. */
typedef struct pd_step {
    double time;      /* [s] where it begins */
    double limit;     /* [s] where it ends at the latest */
    double dt;        /* [s] of the next attempt */
    double end;       /* [s] where the attempt ends: limit, or time + dt */
    double error;     /* [-] how good the attempt is, as its process counts it, for its `accept` and `reject` */
    int trial;        /* attempts before this one */
    int ends;         /* 1: from `accept`: those behind the process have to move before it does again */
    double fraction;  /* [-] of the run: largest share of a node's content that a step takes */
    double rtol;      /* [-] of the run: error in time of what is lost, over all that is lost */
    double max_step;  /* [s] of the run; 0: none */
    double lost;      /* [unit of its elements] solid of the process lost since the start of the run */
    pd_at_fn at;      /* call before equations at a time are solved; NULL: nothing is quasi-steady */
    void *at_user;
    double (*until)(void *user, double t, double end); /* where a step from t ends at the latest, so that it sees what
                                                        * depends on time; NULL: nothing does */
    void *until_user;
    pd_attempt *now;       /* gets what is being tried; NULL: nobody asks */
    const int32_t *turned; /* [turned_count] from `accept`: the nodes of metal that have turned fluid */
    int32_t turned_count;
} pd_step;

/* What is conserved. Processes that name the same element share a ledger. */
typedef struct pd_element {
    const char *name, *unit;
} pd_element;

/* Amounts of one element that enter the ledger [unit of the element; per m depth in planar 2D, per m2 in 1D]. */
typedef struct pd_amounts {
    double solid;     /* [unit] in metal */
    double volume;    /* [m3] (m2 in planar 2D, m in 1D) of that */
    double dissolved; /* [unit] in fluid */
    double carry;     /* [unit] what the last linear solve left undone or debris owes; delivered by the next step */
    double out, in;   /* [unit] through the sides since the start */
} pd_amounts;

typedef struct pd_process {
    const char *name; /* for polls, messages and checkpoints */
    void *self;
    const double *time; /* [s] where it stands; NULL: it runs with others only */
    const pd_element *element; /* [elements] */
    int elements;
    int inner;            /* 1: a step of the run takes it through steps of its own */
    /* Where an attempt from t ends at the latest, so that it sees what its own laws do in time, with all else as it is:
     * `tried` 0: at t, before the attempt; 1: at `end`, after it. NULL: nothing depends on time */
    double (*until)(void *user, double t, double end, int tried);
    void *until_user;
    const int64_t *steps; /* its own ones; NULL: not counted */
    /* Once, before the opening balance, at time t [s]. */
    pd_status (*start)(pd_ctx *ctx, void *self, double t);
    /* Quasi-steady processes: become those of time t [s]. */
    pd_at_fn at;
    /* Lower step->dt to the longest step of the run that suits the process. Called when the first process takes several
     * steps of its own in a step of the run; a process that takes a single step says what it may be by `limit`. */
    pd_status (*longest)(pd_ctx *ctx, void *self, pd_step *step);
    /* Begin a step and lower step->dt to what it may be; step->limit may come nearer, too. */
    pd_status (*limit)(pd_ctx *ctx, void *self, pd_step *step);
    /* Take a step of step->dt from step->time. PD_RETRY: it is not good enough, `reject` follows. */
    pd_status (*attempt)(pd_ctx *ctx, void *self, pd_step *step);
    /* The attempt is the step. */
    pd_status (*accept)(pd_ctx *ctx, void *self, pd_step *step);
    /* Go back to the start of the step, and make step->dt shorter. It fails when no shorter step helps. Never NULL
     * where `attempt` may return PD_RETRY. */
    pd_status (*reject)(pd_ctx *ctx, void *self, pd_step *step);
    /* Fails with a message: steps of step->dt are lost in the rounding of time. NULL: there is a message that fits
     * all. */
    pd_status (*stuck)(pd_ctx *ctx, void *self, const pd_step *step);
    /* A step of the run ends at t [s]. Quasi-steady processes: after the balance; others: when they have reached it. */
    pd_status (*finish)(pd_ctx *ctx, void *self, double t);
    /* Nodes of metal have turned fluid; the rows of bonds know it. */
    pd_status (*changed)(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count);
    /* Write all that steps carry on, or read it. */
    pd_status (*store)(pd_ctx *ctx, void *self, pd_archive *archive);
    /* Add the present amounts of element k of this process. */
    void (*balance)(pd_ctx *ctx, void *self, int k, pd_amounts *amounts);
    /* Worst relative imbalance [-] of what the process keeps a balance of by itself. */
    double (*imbalance)(pd_ctx *ctx, void *self);
} pd_process;

#define pd_process_run PD_NAME(pd_process_run)

/* Steps of a process alone up to t_end [s]. PD_NOT_CONVERGED: one of them said so. PD_ERR_ARGUMENT: t_end is past, or
 * the process has no time. */
PD_API pd_status pd_process_run(pd_ctx *ctx, pd_process process, double t_end);

#ifdef PDI_INTERNAL
/* Steps and the time [s] since which they count. Zero but for the time at first. */
typedef struct pdi_pace {
    double from;
    int steps;
} pdi_pace;
/* After each step that stands, at its end: PD_ERR_STATE: at this pace `end` [s] is not reached in 1e10 steps. */
PDI_FN pd_status pdi_process_pace(pd_ctx *ctx, const char *name, pdi_pace *pace, double time, double end);
/* Equal steps of at most dt [s] over `left` [s]: the length of one. */
PDI_FN double pdi_process_even(double left, double dt);
/* A `longest`: max_step of the run. */
PDI_FN pd_status pdi_process_longest(pd_ctx *ctx, void *self, pd_step *step);
/* One accepted step from step->time that ends at step->end, by step->limit at the latest. Errors and PD_NOT_CONVERGED
 * are those of the process. */
PDI_FN pd_status pdi_process_step(pd_ctx *ctx, const pd_process *process, pd_step *step);
#endif

#endif
