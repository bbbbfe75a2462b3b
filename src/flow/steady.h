/* steady: equations of steady flow on the peridynamic residual, and the linear steps of Newton's method.
 *
 * Each linear step solves the exact linearisation by GMRES, preconditioned by a block factorization: one multigrid
 * cycle for each component of the velocity before the pressure and one after it, three for the pressure, with a
 * least-squares commutator and the drag of the walls for the Schur complement (theory: section 3.12; Elman, Silvester
 * and Wathen 2014, ch. 9).
 */
#ifndef PD_STEADY_H
#define PD_STEADY_H
#include "solve/krylov.h"
#include "solve/compact_operator.h"
#include "flow/jacobian.h"
#include "flow/schur_precond.h"

typedef struct pd_steady_desc {
    double tolerance;   /* [-] of both residuals, against the scales of the flow (eq. 3.25, 3.26); 0: 1e-6 */
    int max_newton;     /* 0: as many as make progress */
    int max_krylov;     /* of one Newton step; 0: 300 */
    int restart;        /* GMRES; 0: 20 */
    pd_arena *arena;    /* scratch memory of a solve, which other solvers may use at other times. Borrowed; NULL: one
                         * of its own */
} pd_steady_desc;

typedef struct pd_steady {
    pd_steady_desc desc;
    pd_flow *flow;
    pd_arena own_arena;                 /* scratch memory, where desc has none */
    int nesting;                        /* nesting of solves that share the scratch arrays, marked `lent` below */
    pd_compact_operator compact;        /* nearest-neighbour coefficients, while multigrids are set up */
    pd_multigrid mg_u, mg_p, mg_darcy;  /* for the velocity block, the Laplacian and div(mobility grad); lent */
    int solves_stages;                  /* 1: ready for stages of steps in time */
    /* 1: fluid alone fills a closed box: corrections are projected (eq. 3.28) */
    int is_fluid_box;
    uint32_t poisson_version;           /* version of the bonds that mg_p is set up for; 0: none */
    pd_krylov krylov;                   /* GMRES of Newton steps */
    pd_krylov potential_krylov;         /* GMRES of the divergence-free correction (eq. 3.34) */
    pd_jacobian jacobian;
    double *residual;                   /* [PD_DIM+1][total] [-] scaled momentum and continuity residuals; lent */
    /* [PD_DIM+1][total] Newton step: velocity [m/s], pressure [m2/s2]; lent */
    double *newton_step;
    double *advecting;                  /* [PD_DIM][total] [m/s] of the linearised velocity, work; lent, or of second
                                         * order that of the flow, which is made anew after the solve */
    /* [total] [m2/s] correction potential q (eq. 3.34), after a solve */
    double *divergence_potential;
    int32_t worst_node; /* the node with the largest residual of the last solve */
    /* [m^d/s] largest difference of fluxes through sections, after a solve */
    double section_difference;
    int prepared;                       /* 1: the preconditioner is set up for `shift` in the present solve */
    double pseudo_rate;                 /* [1/s] 1 over the pseudo time step */
    double stage_rate;                  /* [1/s] rate (u - target) joins the momentum residual; 0: steady */
    const double *stage_target;         /* [PD_DIM][total] [m/s] u* of a stage in time */
    double momentum_weight;             /* [-] of momentum against continuity in norms (eq. 3.31) */
    double reference_norm;              /* [-] largest initial residual norm of all solves */
} pd_steady;

typedef struct pd_steady_result {
    double momentum;    /* [-] max |momentum residual| over U^2/L + nu U/L^2 with the reference speed and length */
    double continuity;  /* [-] max |continuity residual| L/U, with the same U and L */
    double residual_over_tolerance; /* [-] larger residual against the scales of the flow, over the tolerance */
    int newton, krylov; /* steps and iterations of this solve */
    int64_t evaluations;
    int converged;
} pd_steady_result;

/* Prepares the solver for a flow, which is borrowed. From here on its inlets hold their velocity on the side, and an
 * automatic order is decided; both stay after an error and after pd_steady_free. PD_ERR_ARGUMENT: a tolerance or limit
 * is negative, the tolerance is not below 1, restart is above 1000, the lattice has no fourth order that the flow asks
 * for, or an inlet velocity is not finite. After an error steady is freed. */
#define pd_steady_build PD_NAME(pd_steady_build)
#define pd_steady_free PD_NAME(pd_steady_free)

PD_API pd_status pd_steady_build(pd_ctx *ctx, pd_flow *flow, const pd_steady_desc *desc, pd_steady *steady);
PD_API void pd_steady_free(pd_ctx *ctx, pd_steady *steady);

#ifdef PDI_INTERNAL
/* Default restart of GMRES: it keeps one basis vector more. */
#define PDI_STEADY_RESTART 20
/* After implicit stages: solves for the potential that takes the remaining divergence off the bond fluxes (eq. 3.34),
 * where bond fluxes alone are not free of it (uses_axis_divergence; eq. 3.5). Elsewhere clears it: the potential is
 * set to 0, and that of the flow becomes NULL. A missed tolerance is no error. */
PDI_FN pd_status pdi_steady_update_divergence_potential(pd_ctx *ctx, pd_steady *steady);
/* Lists the arrays of a pd_steady that last between solves, beside those of its solvers. */
PDI_FN void pdi_steady_list(pdi_array_visitor *owner, void *object);
/* Sets defaults (max_krylov 0: 300, restart 0: 20) and sizes of the linear solvers, without arrays: enough to count
 * memory. PD_ERR_ARGUMENT: a setting or size that a linear solver refuses, such as a restart above 1000. */
PDI_FN pd_status pdi_steady_plan(pd_ctx *ctx, pd_steady *steady);
/* Scratch memory [byte] of one solve. */
PDI_FN size_t pdi_steady_count_work_bytes(pd_steady *steady);
/* The arena that lends the scratch memory: that of desc, or its own. */
PDI_FN pd_arena *pdi_steady_get_arena(pd_steady *steady);
/* Takes the scratch memory of a solve until pdi_steady_end_solves; calls may nest, and stages within share a
 * preconditioner. The outermost call takes it, and marks preconditioner and multigrid of the Laplacian as not set up.
 * After an error nothing is taken, and pdi_steady_end_solves must not be called. */
PDI_FN pd_status pdi_steady_begin_solves(pd_ctx *ctx, pd_steady *steady);
/* Gives it back, at the outermost of nested calls: sets worst_node, and after any status but PD_OK updates the derived
 * fields of the flow, which were work. Returns `status`, or the error of a corrupted arena. */
PDI_FN pd_status pdi_steady_end_solves(pd_ctx *ctx, pd_steady *steady, pd_status status);
/* Writes or reads what solves carry on beside the flow: the potential and the reference norm. After reading the flow
 * takes the potential, and its surface patches and derived fields are updated. */
PDI_FN pd_status pdi_steady_store(pd_ctx *ctx, pd_steady *steady, pd_archive *archive);
/* Prepares for stages in time: GMRES of Newton steps gets a basis of single precision, and the arena room for a solve
 * and `more` [byte] of the time integrator. Nothing when called again, whatever `more` is. */
PDI_FN pd_status pdi_steady_build_stages(pd_ctx *ctx, pd_steady *steady, size_t more);
/* Scale of the momentum residual [m/s2]: U^2/L + nu U/L^2 (eq. 3.25), in a stage in time at least U rate. Then an error
 * of the velocity counts as its size over U in both residuals. */
PDI_FN double pdi_steady_get_momentum_scale(const pd_steady *s);
/* Scale of the continuity residual, U/L [1/s] (eq. 3.26). */
PDI_FN double pdi_steady_get_continuity_scale(const pd_flow *flow);
/* Sets up the preconditioner for the pseudo time rate shift [1/s], which becomes pseudo_rate. Overwrites s->advecting.
 * `prepared` becomes 1, or 0 after an error. PD_ERR_DIVERGED: coefficients exceed single precision. */
PDI_FN pd_status pdi_steady_update_precond(pd_ctx *ctx, pd_steady *s, double shift);
/* Assembles the scaled residual [-] of the present state, with the term of a stage, into s->residual; returns its
 * Euclidean norm over all nodes, with momentum_weight on momentum. Sets momentum, continuity and
 * residual_over_tolerance of result (largest entries). Updates the derived fields, and counts one evaluation. */
PDI_FN double pdi_steady_assemble_residual(pd_ctx *ctx, pd_steady *s, pd_steady_result *result);
/* Sets momentum_weight, the weight of the momentum residual in norms that keeps both off-diagonal blocks of the
 * preconditioned matrix of one size (eq. 3.31), from the largest speed and the largest mobility; 1 where no node has a
 * mobility. Overwrites newton_step and advecting. */
PDI_FN void pdi_steady_compute_momentum_weight(pd_ctx *ctx, pd_steady *s);
/* Adds factor times the Newton step to velocity and pressure of the flow. Its derived fields are not updated. */
PDI_FN void pdi_steady_update_state(const pd_ctx *ctx, pd_steady *s, double factor);
/* Solves for a Newton step about the frozen state, into s->newton_step (0 at ghosts), with the preconditioner that is
 * set up. The residual is in s->residual, which is overwritten. forcing: relative linear tolerance. *effort: Krylov
 * iterations, or max_krylov + 1 when the tolerance was missed, which is no error. Adds to result->krylov and
 * result->newton. */
PDI_FN pd_status pdi_steady_solve_newton_step(pd_ctx *ctx, pd_steady *s, double forcing, pd_steady_result *result,
                                              int *effort);
/* Solves lap q = Rc for the divergence that the tolerance has left, so that the fluxes given to transport are free of
 * divergence to rounding (eq. 3.34); the flow takes q as divergence_potential. s->residual is that of the present
 * state, and is overwritten. Sets section_difference from the norm of what is left. A missed tolerance is no error: a
 * second solve without preconditioner follows it. Updates the derived fields. */
PDI_FN pd_status pdi_steady_solve_divergence_potential(pd_ctx *ctx, pd_steady *s);
#endif

#endif
