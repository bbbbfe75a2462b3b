/* time_loop: time loop over coupled processes (physics): step control, retries, conservation check, checkpoint,
 * observer.
 *
 * Processes are in the order of a step (theory: chapter 13). Quasi-steady processes are solved at a time whenever
 * another one asks for it, and at the end of the step. The first time-dependent process decides the length of a step;
 * those behind it follow to its end, in as many steps of their own as they need. When metal nodes become fluid, the
 * bond data and all processes are updated. The caller's observer sees every step; no files here.
 */
#ifndef PD_TIME_LOOP_H
#define PD_TIME_LOOP_H
#include "lattice/bond.h"
#include "solve/physics.h"

#define PD_TIME_LOOP_MAX_PROCESSES 8 /* most processes of a run */
#define PD_TIME_LOOP_MAX_ELEMENTS 8  /* most elements with a ledger */

/* Mass balance of an element [unit of the element, per m depth in planar 2D, per m2 in 1D].
 * imbalance = solid + dissolved + carried_residual + out - in - start. */
typedef struct pd_mass_balance {
    double start;       /* [unit] solid and dissolved at the start */
    double solid_start; /* [unit] solid at the start */
    double solid;       /* [unit] now */
    double volume_start; /* [m3] (m2 in planar 2D, m in 1D) of the solid at the start */
    double volume;      /* [m3] now */
    double dissolved;   /* [unit] now in the fluid */
    double carried_residual; /* [unit] residual of the last linear solve and debris: added in the next step */
    double out, in;     /* [unit] through outlets and inlets since the start */
    double imbalance;   /* [unit] */
    /* [-] |imbalance| over the largest of the initial solid (start without solid), in and out */
    double relative_imbalance;
} pd_mass_balance;

typedef struct pd_time_loop_desc {
    double fraction;        /* [-] largest share of a node's content lost in one step; 0: 0.1 */
    double rtol;            /* [-] error in time of the metal lost in a step, over all that is lost; 0: fraction/25 */
    double max_step;        /* [s] 0: none */
    double (*next_event)(void *user, double t, double end); /* see pd_step; NULL: nothing depends on time */
    void *next_event_user;
    double ledger_tolerance; /* [-] 0: 1e-10: a larger relative imbalance is PD_ERR_BALANCE */
} pd_time_loop_desc;

typedef struct pd_time_loop {
    pd_time_loop_desc desc; /* defaults filled in */
    pd_grid *grid;
    pd_bonds *bonds;     /* NULL: no process needs their rows */
    pd_physics process[PD_TIME_LOOP_MAX_PROCESSES];
    int count;           /* of processes */
    pd_element element[PD_TIME_LOOP_MAX_ELEMENTS];
    pd_mass_balance ledger[PD_TIME_LOOP_MAX_ELEMENTS];
    int elements;
    double own_imbalance; /* [-] largest relative imbalance of processes with balances of their own */
    double time;         /* [s] */
    double dt;           /* [s] of the last step; mean where a process counts its own */
    pd_attempt current;  /* the process and time that are computed at the moment, for progress messages */
    int started;
    int64_t steps;       /* or those that a process counts */
    int64_t unsolved;    /* steps, and the start, in which a process missed its tolerance */
    int has_missed;      /* 1: a process missed it since the last step ended */
    int64_t solid_nodes_start;
    uint8_t *new_fluid; /* [nodes of the grid] bit n: the node has become fluid since the last step of process n, which
                         * has no values there yet; borrowed, all 0 at first. NULL: not used */
    int has_new_fluid;  /* 0: no bit is set */
} pd_time_loop;

/* Called after the start (step 0) and after every step; a non-zero return stops the run. */
typedef int (*pd_observer_fn)(void *user, const pd_time_loop *couple);

#define pd_time_loop_build PD_NAME(pd_time_loop_build)
#define pd_time_loop_add_process PD_NAME(pd_time_loop_add_process)
#define pd_time_loop_start PD_NAME(pd_time_loop_start)
#define pd_time_loop_step PD_NAME(pd_time_loop_step)
#define pd_time_loop_run PD_NAME(pd_time_loop_run)
#define pd_time_loop_volume_loss PD_NAME(pd_time_loop_volume_loss)
#define pd_time_loop_imbalance PD_NAME(pd_time_loop_imbalance)
#define pd_time_loop_store PD_NAME(pd_time_loop_store)

/* Resets `couple` and sets the description, 0 replaced by defaults; time is 0, and there are no processes. Grid and
 * bonds are borrowed; nothing is allocated, so there is no free. PD_ERR_ARGUMENT: fraction or rtol outside of 0 .. 1,
 * max_step or ledger_tolerance negative, or NaN. */
PD_API pd_status pd_time_loop_build(pd_ctx *ctx, const pd_time_loop_desc *desc, pd_grid *grid, pd_bonds *bonds,
                                    pd_time_loop *couple);
/* Append a process; its elements join the ledgers by name, new names get a ledger of their own. PD_ERR_SIZE: there are
 * more than 8 processes or 8 elements, and nothing is appended. */
PD_API pd_status pd_time_loop_add_process(pd_ctx *ctx, pd_time_loop *couple, pd_physics process);
/* Starts all processes at couple->time in their order, those without a `start` left out, and sets the initial amounts
 * of the ledgers; sets `started`. A process that misses its tolerance counts in `unsolved`, and PD_OK is returned.
 * Errors: those of the processes; PD_ERR_BALANCE. After an error of a process couple->current names it. */
PD_API pd_status pd_time_loop_start(pd_ctx *ctx, pd_time_loop *couple);
/* One step that does not pass t_limit [s]; updates time, dt, steps and ledgers. PD_ERR_ARGUMENT: t_limit is not after
 * time. PD_ERR_BALANCE: amounts are not conserved. After an error within the step, time and steps stay, but processes
 * may have moved. PD_NOT_CONVERGED: the step is done, but a process missed its tolerance, which counts in `unsolved`;
 * what transport and species miss is owed to the next step. */
PD_API pd_status pd_time_loop_step(pd_ctx *ctx, pd_time_loop *couple, double t_limit);
/* Start unless that is done, then steps up to t_end [s], none where time is t_end already; observer may be NULL. Steps
 * end exactly on multiples of `every` [s] (0: only on t_end). An observer that returns non-zero stops the run without
 * an error. PD_NOT_CONVERGED: done, with such steps; `unsolved` counts them. PD_ERR_ARGUMENT: t_end before time,
 * `every` negative. PD_ERR_STATE: steps are so short that the end is more than 1e10 of them away. */
PD_API pd_status pd_time_loop_run(pd_ctx *ctx, pd_time_loop *couple, double t_end, double every,
                                  pd_observer_fn observer, void *user);
/* Share [-] of the initial volume of the solid that is gone, all elements taken together, as of the last ledgers; 0:
 * there was none. */
PD_API double pd_time_loop_volume_loss(const pd_time_loop *couple);
/* Largest relative imbalance [-], not negative, of all ledgers and of processes with balances of their own, as of the
 * last check. */
PD_API double pd_time_loop_imbalance(const pd_time_loop *couple);
/* Writes a checkpoint of all processes, or restores it into processes that were built alike and have made no step; the
 * run then continues with the same bits. Results of the last step (fluxes of transport and metal) are available after
 * the next one. Errors: those of the archive; PD_ERR_ARGUMENT: another lattice or other processes; PD_ERR_GEOMETRY:
 * other kinds of nodes than by dissolution. After an error on reading only free is allowed. */
PD_API pd_status pd_time_loop_store(pd_ctx *ctx, pd_time_loop *couple, pd_archive *archive);

#endif
