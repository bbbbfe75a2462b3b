/* newton: Newton's method for nonlinear equations R(x) = 0, with inexact linear steps and a line search.
 *
 * The equations keep the state x, the residual R and the step. This module decides how far a linear step is solved
 * (forcing terms: Eisenstat and Walker 1996), how much of it is taken (line search) and when the iteration ends. It
 * ends on residuals, never on changes per step.
 */
#ifndef PD_NEWTON_H
#define PD_NEWTON_H
#include "core/base.h"

#define pd_newton_solve PD_NAME(pd_newton_solve)

/* How the length of a step is chosen. */
typedef enum pd_newton_search {
    /* Steps are taken whole; the iteration ends where the norm of the residual does not fall. */
    PD_NEWTON_FULL_STEP = 0,
    /* A step is halved where the norm grows by more than max_growth, until the norm falls; else it is taken back, and
     * solve_step has to find a shorter one. */
    PD_NEWTON_BY_NORM,
    /* A step is shortened until the residual does no more work along it, or little against it (Crisfield 1991, ch.
     * 9.2): for forces that have a potential, whose norm is no measure where they have kinks. */
    PD_NEWTON_BY_WORK
} pd_newton_search;

typedef struct pd_newton_desc {
    pd_newton_search search;
    int max_steps;        /* 0: no limit; then max_stalled is one */
    int max_trials;       /* shorter lengths that are tried, with PD_NEWTON_BY_WORK lengths of any kind */
    double max_growth;    /* [-] PD_NEWTON_BY_NORM: norm over the one before that is accepted */
    int max_stalled;      /* steps in which the norm has to be halved, or the iteration ends; 0: no limit */
    int is_nearly_linear; /* 1: each linear step aims at the tolerance; 0: at what the last step has come to */
    double first_ratio;   /* [-] reduction of the norm that the first linear step is chosen by */
    double final_forcing; /* [-] part of the tolerance that a linear step aims at */
    double min_forcing, max_forcing; /* [-] bounds of the tolerance of a linear step */
} pd_newton_desc;

/* How far an iteration has come. */
typedef struct pd_newton_progress {
    int steps;       /* linear steps */
    double norm;     /* [unit of the norm] of the residual */
    double previous; /* [unit of the norm] before the last step */
    double excess;   /* [-] residual over its tolerance: at most 1 where it has converged */
    double forcing;  /* [-] relative tolerance of the next linear step, or of the last one */
    double length;   /* [-] part of the last step that was taken; 0: it was taken back */
    double best;     /* [unit of the norm] norm that counts as progress when it is halved */
    int stalled;     /* steps since it was */
} pd_newton_progress;

/* The equations: each callback gets `self`. */
typedef struct pd_newton_equations {
    void *self;
    const char *name; /* for polls: "flow: Newton" */
    /* Residual at the present state: its norm, and its excess over the tolerance. PD_RETRY: the state has none. */
    pd_status (*residual)(pd_ctx *ctx, void *self, double *norm, double *excess);
    /* Linearises the equations at the present state, and solves for the step with the relative tolerance
     * progress->forcing. Leaves the state. A status other than PD_OK ends the iteration. */
    pd_status (*solve_step)(pd_ctx *ctx, void *self, const pd_newton_progress *progress);
    /* Sets the state to that before the step plus `length` times the step. */
    void (*move)(pd_ctx *ctx, void *self, double length);
    /* Work of the residual along the step: derivative of the energy with the opposite sign. PD_NEWTON_BY_WORK. */
    double (*work)(void *self);
} pd_newton_equations;

/* Iterates from the present state until the excess is at most 1, at once where it is; *progress tells how far.
 * PD_NOT_CONVERGED: max_steps, more than max_stalled steps without half the norm, a norm that is not finite, or with
 * PD_NEWTON_FULL_STEP one that does not fall. PD_RETRY: with PD_NEWTON_BY_WORK no length of a step is accepted, and the
 * state is that before the step; or a state has no residual. PD_ERR_ARGUMENT: no limit of steps, or max_forcing is not
 * positive. Others: of the callbacks; PD_CANCELLED. */
PD_API pd_status pd_newton_solve(pd_ctx *ctx, const pd_newton_equations *equations, const pd_newton_desc *desc,
                                 pd_newton_progress *progress);

#endif
