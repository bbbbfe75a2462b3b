/* couple: one dissolution run: steady flow, implicit transport, dissolution steps with error control, the ledger.
 *
 * The fluid is quasi-steady at every instant of the dissolution (acoustics ns, advection ms, diffusion s, dissolution
 * h): each step solves the flow where the geometry has changed, then transport and surface loss over a step in which no
 * solid node loses more than a set fraction (theory: section 7). Where inlets, walls or forces follow a clock, the flow
 * of a step is that of its end, and of transport alone that of each stage. The caller's observer sees every step; no
 * files here.
 */
#ifndef PD_COUPLE_H
#define PD_COUPLE_H
#include "flow/implicit.h"
#include "flow/unsteady.h"
#include "transport/settle.h"
#include "transport/advance.h"
#include "metal/dissolve.h"

/* Amounts [mol, per m depth in planar 2D, per m2 in 1D]. imbalance = solid + dissolved + carry + out - in - start. */
typedef struct pd_ledger {
    double start;     /* [mol] solid and dissolved at the start */
    double solid;     /* [mol] now */
    double dissolved; /* [mol] now in the fluid */
    double carry;     /* [mol] what the last linear solve left undone or debris owes; delivered by the next step */
    double out, in;   /* [mol] through outlets and inlets since the start */
    double imbalance; /* [mol] */
    double relative;  /* [-] |imbalance| over the initial solid (over start without solid) */
} pd_ledger;

typedef struct pd_couple_desc {
    double fraction;        /* [-] largest share of a node's content lost in one step; 0: 0.1 */
    double rtol;            /* [-] error in time of the metal lost in a step, over all that is lost; 0: fraction/25 */
    double max_step;        /* [s] 0: none */
    double ledger_tolerance; /* [-] 0: 1e-10: a larger relative imbalance is PD_ERR_LEDGER */
} pd_couple_desc;

typedef struct pd_couple {
    pd_couple_desc desc;
    pd_grid *grid;
    pd_bonds *bonds;
    pd_flow *flow;           /* NULL: no flow */
    pd_steady *steady;       /* NULL without flow, or with flow in time */
    pd_implicit *implicit;   /* set one of these after the build for flow in time; the steps of the coupling are then */
    pd_unsteady *unsteady;   /* those of the implicit flow, or of max_step (without: to the next output) */
    pd_transport *transport; /* NULL: flow alone */
    pd_dissolve *dissolve;   /* NULL: no dissolution */
    int settle;              /* set after the build: the field of transport starts steady */
    int rowless;             /* set after the build: no flow, and nobody asks for the rows of the bonds; with a given
                              * field of transport they stay as they are */
    pd_advance *advance;     /* set after the build: transport without dissolution in its error-controlled steps */
    double time;             /* [s] */
    double dt;               /* [s] of the last step */
    int started;
    int64_t steps;
    int64_t flow_solves;
    int64_t unsolved;        /* steps in which the linear solver of transport missed its tolerance */
    int64_t krylov_flow, krylov_transport;
    int64_t flow_evaluations;
    int flow_stale;          /* the geometry, or what stands outside, has changed since the last flow solve */
    double flow_moved;       /* [-] by how much what stands outside has, see pd_flow_at */
    pd_steady_result steady_result;       /* of the last flow solve */
    pd_transport_result transport_result; /* of the last step */
    pd_ledger ledger;
    double solid_start;      /* [mol] */
    int64_t solid_nodes_start;
} pd_couple;

/* Called after the start (step 0) and after every step; a non-zero return stops the run. */
typedef int (*pd_observer_fn)(void *user, const pd_couple *couple);

#define pd_couple_build PD_NAME(pd_couple_build)
#define pd_couple_start PD_NAME(pd_couple_start)
#define pd_couple_step PD_NAME(pd_couple_step)
#define pd_couple_run PD_NAME(pd_couple_run)
#define pd_couple_volume_loss PD_NAME(pd_couple_volume_loss)
#define pd_couple_store PD_NAME(pd_couple_store)

/* All objects are borrowed and may be NULL as noted above; nothing is allocated, so there is no free. */
PD_API pd_status pd_couple_build(pd_ctx *ctx, const pd_couple_desc *desc, pd_grid *grid, pd_bonds *bonds, pd_flow *flow,
                                 pd_steady *steady, pd_transport *transport, pd_dissolve *dissolve, pd_couple *couple);
/* First flow solve and the opening balance. PD_ERR_ARGUMENT: no solver for the flow, or dissolution with flow in
 * time. */
PD_API pd_status pd_couple_start(pd_ctx *ctx, pd_couple *couple);
/* One step that does not pass t_limit [s]. With nothing left to dissolve the step goes straight to t_limit.
 * PD_NOT_CONVERGED: the step is done, but the linear solver of transport missed its tolerance; what is missing is owed
 * to the next step. */
PD_API pd_status pd_couple_step(pd_ctx *ctx, pd_couple *couple, double t_limit);
/* Start unless that is done, then steps up to t_end [s]; observer may be NULL. Steps end exactly on multiples of
 * `every` [s] (0: only on t_end). PD_NOT_CONVERGED: done, with such steps; `unsolved` counts them. */
PD_API pd_status pd_couple_run(pd_ctx *ctx, pd_couple *couple, double t_end, double every, pd_observer_fn observer,
                               void *user);
/* Share [-] of the initial solid amount that is gone. */
PD_API double pd_couple_volume_loss(const pd_couple *couple);
/* Write what the steps of all parts carry on, or read it into parts that were built alike and have made no step, to go
 * on with the same bits. Figures of the last step (fluxes of transport and metal) are known again after the next one.
 * Errors of pd_store_bytes and pd_store_check, PD_ERR_GEOMETRY: metal stands elsewhere; after them only free. */
PD_API pd_status pd_couple_store(pd_ctx *ctx, pd_couple *couple, pd_archive *archive);

#endif
