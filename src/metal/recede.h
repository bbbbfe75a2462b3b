/* recede: implicit steps of bond-based corrosion (corrode.h) under diffusion control, as long as the front allows.
 *
 * Fluid concentrations at the end of a step dt satisfy
 *
 *     (C_i' - C_i)/dt = sum_fluid D a(n) (C_j' - C_i') + theta_i G_i(C_i'),                     (theory: eq. 6.11)
 *     C_i' <= Csat,  0 <= theta_i <= 1,  and theta_i = 1 where C_i' < Csat,
 *
 * where G_i is what the law lets the metal in reach give to node i. The salt layer is part of the equations: at Csat a
 * node takes what diffusion carries away and no more, so nothing switches from step to step. Newton's method on the
 * law and an active set for theta; linear systems by CG with a multigrid cycle. Metal loses bond by bond what the fluid
 * gains. A node turns at the end of the step that is closest to its end, so that the front is neither late nor early on
 * average: metal behind it takes what it still has or makes up for what it lost too much.
 * Sources: Hintermueller, Ito and Kunisch 2002 (primal-dual active set); Jafarzadeh, Zhao, Shakouri and Bobaru 2021,
 * eq. 9 (implicit transport, explicit change of phase).
 */
#ifndef PD_RECEDE_H
#define PD_RECEDE_H
#include "solve/krylov.h"
#include "solve/multigrid.h"
#include "solve/compact.h"
#include "metal/law.h"
#include "metal/march.h"

/* Zero-initialise. */
typedef struct pd_recede_desc {
    double share;     /* [-] a run chooses steps in which no node loses more of Cs - Csat; 0: 0.2 */
    double rtol;      /* [-] and whose error in time is below this share of Csat, root mean square over the fluid; 0:
                       * 1e-3 */
    double tolerance; /* [-] of the equations, in Csat; 0: 1e-9 */
    int max_newton;   /* 0: 40 */
} pd_recede_desc;

typedef struct pd_recede {
    pd_recede_desc desc; /* defaults filled in */
    pd_corrode *corrode;
    pd_compact compact;
    pd_multigrid mg;
    pd_krylov krylov;
    double dt;         /* [s] of the step at hand */
    double *start;     /* [total] [mol/m3] at its begin */
    double *moved;     /* [total] [mol/m3] change of fluid nodes in the last step */
    double *balance;   /* [total] [mol/m3/s] residual */
    double *delta;     /* [total] [mol/m3] correction */
    double *field;     /* [total] [mol/m3] operand with its ghosts */
    double *drain;     /* [total] [1/s] -dG/dC; negative where metal dissolves the faster, the more is dissolved */
    double *full;      /* [total] [mol/m3] of nodes beside metal: Csat, where the law ends before, or the jump that the
                        * node is pinned to */
    double *asked_c;   /* [total] [mol/m3] where the last round has looked at the law; below 0: nowhere */
    double *asked_need; /* [total] [mol/m3/s] what was needed there */
    double *dry;       /* [total] [1/m2] sum of a(n) over bonds to metal and walls */
    double *reach;     /* [total] [1/m] sum of b(n) to metal */
    double *stock;     /* [total] [mol/m4] the same times what the metal there has, with drive by difference */
    uint8_t *state;    /* [total] whether a node beside metal follows the law, holds Csat or a jump, or takes nothing
                        */
    double last_dt;    /* [s] of the step before; 0: none */
    int32_t turned;    /* nodes that turned in it: fields bend there, which is no error in time */
    double next_dt;    /* [s] that the error in time proposes for the next one */
    double front_dt;   /* [s] that the front does */
    double retry_dt;   /* [s] of the next attempt after PD_RETRY */
    int64_t newton, iterations; /* in all: corrections, and CG iterations */
    int64_t rejected;  /* steps tried again with a shorter dt */
} pd_recede;

#define pd_recede_build PD_NAME(pd_recede_build)
#define pd_recede_step PD_NAME(pd_recede_step)
#define pd_recede_next PD_NAME(pd_recede_next)
#define pd_recede_run PD_NAME(pd_recede_run)
#define pd_recede_process PD_NAME(pd_recede_process)
#define pd_recede_free PD_NAME(pd_recede_free)

/* The corrosion is borrowed. PD_ERR_ARGUMENT: activation control (there is nothing to solve for), a tolerance out of
 * range. */
PD_API pd_status pd_recede_build(pd_ctx *ctx, pd_corrode *corrode, const pd_recede_desc *desc, pd_recede *recede);
/* One step of dt [s]. PD_RETRY, nothing changed: a node would lose far more than its share, debris more than it
 * has, or the equations found no solution: take a shorter one. PD_ERR_STATE: the law gives no finite speed. */
PD_API pd_status pd_recede_step(pd_ctx *ctx, pd_recede *recede, double dt);
/* One step that does not pass t_end [s], as long as share and rtol allow. PD_ERR_DIVERGED: none is short enough.
 * PD_ERR_ARGUMENT: t_end has passed. */
PD_API pd_status pd_recede_next(pd_ctx *ctx, pd_recede *recede, double t_end);
/* Such steps up to t_end [s]. */
PD_API pd_status pd_recede_run(pd_ctx *ctx, pd_recede *recede, double t_end);
/* The corrosion as a part of a run, for pd_couple_add: by such steps. */
PD_API pd_process pd_recede_process(pd_recede *recede);
PD_API void pd_recede_free(pd_ctx *ctx, pd_recede *recede);

#endif
