/* transport: steps of advection and diffusion of a dissolved species on fluid nodes, conservative and bounded.
 *
 * dc/dt + sum_j F_ij (c_i + c_j)/2 - sum_j (D a + d)(c_j - c_i) = source - absorb c - sum_j alpha d s_ij  over open
 * bonds, with F_ij the volume flux of the flow and d = max(|F|/2 - D a, 0) the diffusion that makes the left side an
 * M-matrix (upwinding). The right side gives it back as antidiffusive fluxes along the steps s_ij of the field, where
 * the limiter alpha allows it (theory: eq. 6.1 to 6.15). Implicit steps are solved by Newton's method.
 * Bonds to solid and wall carry nothing. Every sum over bonds conserves to rounding, converged or not.
 */
#ifndef PD_TRANSPORT_H
#define PD_TRANSPORT_H
#include "solve/physics.h"
#include "solve/krylov.h"
#include "transport/bounds.h"
#include "transport/factor.h"
#include "transport/inverse.h"

typedef enum pd_advection {
    PD_ADVECTION_LIMITED = 0, /* second order where smooth */
    PD_ADVECTION_UPWIND = 1   /* first order everywhere */
} pd_advection;

typedef struct pd_transport_desc {
    double diffusivity;     /* [m2/s] */
    pd_point_fn field, level, held; /* see pd_diffusion_desc; NULL: constant diffusivity, no flux into walls */
    double inlet;           /* [mol/m3] concentration of the inflow */
    pd_point_fn entering;   /* the same at places of the sides of the box; NULL: `inlet` everywhere */
    void *user;             /* of these four */
    int walls_only;         /* 1: `held` is not asked on solids, which hold nothing */
    double *clock;          /* [s] where held and entering read the time: it is written there before they are asked.
                             * NULL: they do not depend on time. Borrowed */
    double initial;         /* [mol/m3] */
    pd_advection advection;
    double tolerance;       /* [-] of the linear solves, relative to the right-hand side; 0: 1e-11 */
    int max_limiter;        /* Newton steps on the limited equations in one implicit step; 0: 30 */
    double limiter_tolerance; /* [-] relative change of the field by a whole one of them at which they stop; 0: 1e-10 */
    int given;              /* 1: the field is the caller's, as under activation control: nothing is built to solve for
                             * it, steps are refused, fluxes are 0 */
    pd_arena *arena;        /* lends what a step needs for its time, and may lend it to others at other times. Borrowed;
                             * NULL: one of its own */
} pd_transport_desc;

typedef struct pd_transport {
    pd_transport_desc desc; /* defaults filled in */
    const pd_grid *grid;
    const pd_bonds *bonds;
    const pd_flow *flow;    /* NULL: fluid at rest */
    pd_diffusion diffusion; /* conductances of the bonds */
    pd_open_boundary boundary;
    pd_limiter limiter;     /* with a flow */
    pd_flux flux;        /* fluxes of the bonds, from all of these */
    pd_arena own;           /* without one from the desc */
    int held;               /* steps, one within the other, for which is lent what has `lent` below, here and in the
                             * parts */
    int lean;               /* 1: the outermost of them solves nothing, and no solver is lent */
    double *c;              /* [total] [mol/m3]; solid nodes: what is left of the solid */
    double *old;            /* [total] [mol/m3] start of the step; lent */
    double *source;         /* [total] [mol/m3/s] given by the caller before a step */
    double *absorb;         /* [total] [1/s] given, too; source - absorb c enters the fluid */
    double time;            /* [s] of the values that are held and enter */
    double passed[2];       /* [mol/m3] least and largest of those since the step began, bounds of the field too */
    double seen[2];         /* [mol/m3] least and largest value that explicit steps have begun with */
    double ceiling;         /* [mol/m3] given, too: what sources lift the fluid to at most; HUGE_VAL: anything */
    double *carry;          /* [total] [mol/m3] what the last solve left undone; the next step delivers it */
    double *anti;           /* [total] [mol/m3/s] limited antidiffusive fluxes in force; NULL: none are limited */
    double *rest;           /* [total] [mol/m3] what c of a steady field leaves to rounding: what flows through a good
                             * conductor beside a poor one is below that. NULL: one diffusivity; 0 after steps */
    double size;            /* [mol/m3] of the field, the largest since the start of the step */
    double most;            /* [mol/m3] that the bounds of the step allow it to have */
    int upwinding;          /* 1: a node is upwinded */
    int sweeping;           /* pairs of sweeps over the bonds behind each multigrid cycle: where it has failed in this
                             * step, they are what converges for an M-matrix */
    uint8_t *upwinded;      /* [total] node lost its antidiffusive fluxes in this step, to keep the bounds */
    double *rhs;            /* [total] [mol/m3/s] work; in the linear solves of Newton's method [-] derivatives of what
                             * the nodes keep; lent. NULL: no fluxes are limited */
    double *work;           /* [2][total] [mol/m3/s] residual, [mol/m3] correction; lent */
    double *probe;          /* [PD_DIM][total] [mol/m4] derivatives of the gradients along a direction, work; lent.
                             * NULL: no fluxes are limited */
    double *repeated;       /* [total] [mol/m3] operand with its images, and work of the preconditioner; lent. NULL: no
                             * periodic or mirror side */
    int32_t worst;          /* of a steady field: the node whose balance lacks most */
    int32_t *pinned;        /* [pinned_count] nodes that hold their concentration in a stage: what they take or give is
                             * the residual there. Borrowed */
    int32_t pinned_count;
    int rough;              /* 1: a stage may end above its tolerance, once it has gained what the last one did */
    double first;           /* [mol/m3/s] residual that the last stage of the step began with; 0: there was none */
    double dt;              /* [s] of the step in work; 0: none */
    pd_inverse inverse;
    pd_factor factors;      /* of Newton's method */
    pd_krylov krylov;
    double outflow;         /* [mol/s] (per m in planar 2D) through outlets and into held walls at the end of the last
                             * step */
    double inflow;          /* [mol/s] (per m in planar 2D) through inlets and from held walls */
} pd_transport;

typedef struct pd_transport_result {
    int krylov;     /* iterations */
    int limiter;    /* Newton steps on the limited equations */
    int bounded;    /* rounds in which nodes were upwinded to keep the bounds */
    double residual; /* [-] last relative residual of the linear solve */
    double change;  /* [-] relative change of the field by the last of these steps */
    double defect;  /* [-] steady fields: what the balances of the nodes lack in all, over what passes the domain */
} pd_transport_result;

#define pd_transport_build PD_NAME(pd_transport_build)
#define pd_transport_update PD_NAME(pd_transport_update)
#define pd_transport_implicit PD_NAME(pd_transport_implicit)
#define pd_transport_free PD_NAME(pd_transport_free)

/* flow may be NULL; after setting the fields of a flow by hand call pdi_flow_update_derived_fields. PD_ERR_ARGUMENT:
 * diffusivity or concentrations negative or not finite, a given field with a flow. */
PD_API pd_status pd_transport_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                                    const pd_transport_desc *desc, pd_transport *transport);
/* After pd_bonds_update: inlet ghosts and conductances follow. Fluid values stay (a dissolved node keeps its
 * content). */
PD_API pd_status pd_transport_update(pd_ctx *ctx, pd_transport *transport);
#ifdef PDI_INTERNAL
/* Values that are held and enter become those of time [s]; nothing happens without a clock. */
PDI_FN pd_status pdi_transport_at(pd_ctx *ctx, pd_transport *t, double time);
#endif
/* One backward Euler step of dt [s] (any length: dt >> all time scales gives the steady state). PD_NOT_CONVERGED: the
 * linear solver stopped above its tolerance; what is missing is in carry. */
PD_API pd_status pd_transport_implicit(pd_ctx *ctx, pd_transport *transport, double dt, pd_transport_result *result);
PD_API void pd_transport_free(pd_ctx *ctx, pd_transport *transport);

#ifdef PDI_INTERNAL
/* 1: it has antidiffusive fluxes, which are limited. */
static inline int pdi_transport_limits(const pd_transport *t)
{
    return t->flow && t->desc.advection == PD_ADVECTION_LIMITED;
}
/* [mol/m3/s] that they give to node i. */
static inline double pdi_transport_gain(const pd_transport *t, int32_t i) { return t->anti ? t->anti[i] : 0.0; }
/* Right-hand side of a step: old/dt + source + carry/dt + anti at fluid node i. */
static inline double pdi_transport_right(const pd_transport *t, int32_t i)
{
    double sum = (t->old[i] + t->carry[i]) / t->dt + t->source[i] + pdi_transport_gain(t, i);
    return t->diffusion.wall_source ? sum + pdi_diffusion_given(&t->diffusion, i) : sum;
}
/* 1: fluid at rest with one diffusivity, whose bonds need not be asked one by one. */
static inline int pdi_transport_rests(const pd_transport *t)
{
    return !t->flow && !t->desc.field && !t->grid->circumference && !pdi_open_boundary_has_any(t->grid);
}
/* 1: sweeps need a copy of what they are applied to. */
static inline int pdi_transport_repeats(const pd_transport *t)
{
    int images = 0;
    for (int s = 0; s < 2 * PD_DIM; s++) images = images || t->grid->side[s] >= PD_SIDE_PERIODIC;
    return images || pdi_transport_rests(t);
}
/* Entries of it: cycles of the multigrid have their fields there, too. */
static inline int64_t pdi_transport_repeated(const pd_transport *t)
{
    int64_t total = t->grid->total,
            fields = t->lean ? 0 : (int64_t)(pdi_multigrid_field_floats(&t->inverse.mg) + 1) / 2;
    return fields > total ? fields : total;
}
/* Arrays of a pd_transport that the build makes, beside those of its parts. */
PDI_FN void pdi_transport_list(pdi_array_visitor *owner, void *object);
/* Its solvers, from desc, grid, bonds and flow, without arrays; and then the [byte] that a step needs for its time. */
PDI_FN pd_status pdi_transport_plan(pd_ctx *ctx, pd_transport *transport);
PDI_FN size_t pdi_transport_room(pd_transport *transport);
/* Hold what a step needs from here on until the release. Returns `status`, or an error. */
PDI_FN pd_status pdi_transport_hold(pd_ctx *ctx, pd_transport *transport);
PDI_FN pd_status pdi_transport_release(pd_ctx *ctx, pd_transport *transport, pd_status status);
/* (c - old - carry)/dt + F(c) = 0 for given old and carry (eq. 6.10), from the present c; outflow and inflow are those
 * at the end. All is held. bounded: values outside of the bounds of old and inflow lose their antidiffusive fluxes.
 * carry stays. */
PDI_FN pd_status pdi_transport_stage(pd_ctx *ctx, pd_transport *transport, double dt, int bounded,
                                     pd_transport_result *result);
/* work: that of the field that a step of dt [s] begins with, before its first stage: what nodes gain. */
PDI_FN pd_status pdi_transport_first(pd_ctx *ctx, pd_transport *transport, double dt);
/* A step of one stage, or of several from the same start with other sources: begin, stages, end with the status of the
 * last one, always after a begin. A negative one and PD_RETRY put c back. */
PDI_FN pd_status pdi_transport_begin(pd_ctx *ctx, pd_transport *transport, double dt);
PDI_FN pd_status pdi_transport_end(pd_ctx *ctx, pd_transport *transport, double dt, pd_status status);
/* out [total] [mol/m3/s]: residual of the last stage, what it left undone. */
PDI_FN void pdi_transport_residual(const pd_ctx *ctx, const pd_transport *transport, double *out);
/* out [total] [mol/m3/s]: limited antidiffusive fluxes of the field c (eq. 6.15), whose images are filled here. */
PDI_FN void pdi_transport_anti(const pd_ctx *ctx, pd_transport *transport, double *c, double *out);
/* Rounds of upwinding the nodes that leave their bounds before the whole step is upwinded. */
#define PDI_TRANSPORT_ROUNDS 20
/* PD_ERR_ARGUMENT: the field is given. Begin a step with no node upwinded, 1: fluxes are limited. y [total] [mol/m3/s]:
 * net outflow of nodes. Upwind the nodes that leave their bounds by more than a share `slack`: how many are new. */
PDI_FN pd_status pdi_transport_solves(pd_ctx *ctx, const pd_transport *transport);
PDI_FN int pdi_transport_start(pd_transport *transport);
PDI_FN void pdi_transport_operator(const pd_ctx *ctx, const pd_transport *transport, const double *c, double *y);
PDI_FN int64_t pdi_transport_mark(pd_transport *transport, double slack);
/* Bounds that a step must keep: those of the field at its start and of the inflow; a source lifts the upper one. Both
 * move out by a share `slack` of the field. */
PDI_FN void pdi_transport_bounds(const pd_transport *transport, const double *start, double slack, pdi_bounds *bounds);
/* The bounds of a step begin with what is held and enters at its start. */
static inline void pdi_transport_open(pd_transport *t)
{
    t->passed[0] = HUGE_VAL;
    t->passed[1] = -HUGE_VAL;
}
/* What steps carry on beside the flow, which comes first; sources are those of the next step. */
PDI_FN pd_status pdi_transport_store(pd_ctx *ctx, pd_transport *transport, pd_archive *archive);
/* For the steady field. Limited antidiffusive fluxes of the present field into t->anti (0: none are limited); outflow
 * and inflow of it. */
PDI_FN int pdi_transport_fresh(pd_ctx *ctx, pd_transport *transport);
PDI_FN void pdi_transport_boundary(const pd_ctx *ctx, pd_transport *transport);
/* Correction [total] [mol/m3] for the residual in t->work, to a share of it, with the operator of the last stage. It
 * stands behind the residual. */
PDI_FN pd_status pdi_transport_refine(pd_ctx *ctx, pd_transport *transport, double share, pd_transport_result *result);
/* The element of all that is dissolved. */
static inline const pd_element *pdi_transport_element(void)
{
    static const pd_element metal = {"metal", "mol"};
    return &metal;
}
/* 1 when c lies within the bounds of `start` and the inflow. */
PDI_FN int pdi_transport_within(const pd_transport *transport, const double *start);
#endif

#endif
