/* equilibrium: static equilibrium: displacements of a body under loads and displacement boundary conditions.
 *
 * Newton's method with conjugate gradients: forces are the derivative of an energy, so their derivative is symmetric. A
 * linear material takes one step. Where prescribed displacements are interpolated from free ones, the operator is not
 * symmetric, and GMRES replaces conjugate gradients. The preconditioner is additive: the diagonal block of each point
 * plus a coarse finite-element correction, so finer cells take no more iterations. A component without supports may
 * move as a rigid body; then its loads have to balance, and the solution without mean rigid motion is found.
 */
#ifndef PD_EQUILIBRIUM_H
#define PD_EQUILIBRIUM_H
#include "solid/rigid_modes.h"
#include "solid/coarse_fe_precond.h"
#include "solid/material_interface.h"
#include "solve/krylov.h"

/* Default of rtol. */
#define PD_EQUILIBRIUM_RTOL 1e-10

/* A prescribed displacement that is interpolated from a free one (multi-point constraint): u[at] = given + part
 * u[leader]. */
typedef struct pd_constraint_row {
    int64_t follower, leader; /* indices into [count][PD_DIM]; one with several leaders has a row for each */
    double coefficient;       /* [-] coefficient */
    int near_boundary;        /* 1: the point lies less than a spacing from where the displacement is prescribed */
} pd_constraint_row;

/* All of them. */
typedef struct pd_multipoint_constraint {
    int64_t count;
    pd_constraint_row *row; /* [count] */
} pd_multipoint_constraint;

typedef struct pd_equilibrium_desc {
    const uint8_t *prescribed; /* [count][PD_DIM] 1: this displacement is prescribed (Dirichlet) or interpolated; NULL:
                                * all are free. Borrowed */
    const pd_multipoint_constraint *interpolation; /* of prescribed displacements; NULL: none. Borrowed */
    double rtol;           /* [-] residual over the norm of loads and reactions; 0: PD_EQUILIBRIUM_RTOL. Residuals that
                            * are rounding of the displacements are accepted */
    int max_iterations;    /* 0: 10000 */
    double *mechanism;     /* [count][PD_DIM] [-] with PD_ERR_DIVERGED, of a linear material: a mechanism, that is a
                            * motion without stiffness along which the loads do work; 0: none was found. NULL:
                            * unwanted. Borrowed */
} pd_equilibrium_desc;

typedef struct pd_equilibrium_result {
    int iterations;  /* of conjugate gradients, or of GMRES */
    int steps;       /* of Newton's method */
    double residual; /* [-] as of rtol */
} pd_equilibrium_result;

#define pd_equilibrium_solve PD_NAME(pd_equilibrium_solve)

/* Solves for static equilibrium. u [count][PD_DIM] [m]: in: prescribed displacements (interpolated ones as they belong
 * to the guess) and a guess of the others; out: displacements. load [count][PD_DIM] [N/m3]: dead loads; NULL: none.
 * PD_NOT_CONVERGED: a linear material, u is the best iterate. PD_RETRY: Newton's method did not converge: a shorter
 * load step may. PD_ERR_STATE: a load or displacement is not finite, a component without support along an axis has
 * loads along it that do not balance, or the guess is no state of the material. PD_ERR_DIVERGED: loads rotate the
 * body, or a part of it about a hinge. */
PD_API pd_status pd_equilibrium_solve(pd_ctx *ctx, const pd_material_interface *solid, const pd_equilibrium_desc *desc,
                                      const double *load, double *u, pd_equilibrium_result *result);

#ifdef PDI_INTERNAL
/* State of a solve. */
typedef struct pdi_equilibrium {
    pd_ctx *ctx;
    const pd_material_interface *solid;
    const pd_equilibrium_desc *desc;
    const double *load;
    int64_t n;     /* components of all points */
    double scale;  /* [N] force scale of the problem: residuals are relative to it */
    double rounding;      /* [N] rounding of forces at the initial guess */
    double reaction_norm; /* [N] norm of the reaction forces at prescribed displacements, of the last residual */
    double *diagonal; /* [n] [N/m] of the blocks */
    double *block; /* [count][PD_DIM^2] [m/N] inverse diagonal blocks */
    double *residual; /* [n] [N] residual: internal plus external forces on free components */
    double *step;  /* [n] [m] increment of displacements */
    double *full_direction; /* [n] [m] a direction with its interpolated components; empty without interpolation */
    double *start_u;        /* [n] [m] displacements before a Newton step, of nonlinear materials */
    double *lambda, *mu;  /* [count] [Pa] where the moduli are known */
    pd_coarse_fe_precond coarse; /* where the moduli are known */
    int has_rigid_motions; /* 1: a component has rigid motions */
    pd_krylov krylov;
} pdi_equilibrium;

/* 1: prescribed displacements are interpolated from free ones. */
static inline int pdi_equilibrium_has_interpolation(const pdi_equilibrium *q)
{
    return q->desc->interpolation && q->desc->interpolation->count > 0;
}
/* 1: component k is prescribed. */
static inline int pdi_equilibrium_is_held(const pdi_equilibrium *q, int64_t k)
{
    return q->desc->prescribed && q->desc->prescribed[k];
}
/* Describes the arrays of a solve. */
PDI_FN void pdi_equilibrium_list(pdi_array_visitor *owner, void *equilibrium);
/* Options of the Krylov solver of linear steps, without size and limits: GMRES with interpolation, otherwise conjugate
 * gradients. */
PDI_FN pd_krylov_desc pdi_equilibrium_krylov_options(int interpolated);
/* Checks loads and guess, allocates, and computes blocks, scale and residual at u, and with loads has_rigid_motions.
 * *norm, *target [N]: norm of the residual and its goal. ctx, solid, desc, load and n are set before; the caller frees,
 * after an error too. Errors: as of pd_equilibrium_solve. */
PDI_FN pd_status pdi_equilibrium_begin(pdi_equilibrium *equilibrium, const double *u, double *norm, double *target);
/* Sets residual [N] at u: V (force + load) on free components, 0 on prescribed ones; *norm and reaction_norm: Euclidean
 * norms of it and of V force on prescribed components. A later tangent is that of u. PD_RETRY and errors: as of the
 * force of the material; residual is then of no use. */
PDI_FN pd_status pdi_equilibrium_compute_residual(pdi_equilibrium *equilibrium, const double *u, double *norm);
/* Sets diagonal, and block, the inverse diagonal blocks, at the u of the last residual. Prescribed components are
 * decoupled: their off-diagonal entries count as zero. The inverse is zero where a block is singular, as for a point
 * without bonds. */
PDI_FN void pdi_equilibrium_compute_blocks(const pdi_equilibrium *equilibrium);
/* Preconditioner, a Krylov callback: y [m] = inverse blocks times x [N]; where there is a coarse finite-element
 * correction 0.6 of that plus the correction. 0 at prescribed components. y is overwritten. */
PDI_FN void pdi_equilibrium_apply_precond(void *solve, const double *x, double *y);
/* 1: the loads do work along a free rigid motion of a component, as pdi_rigid_modes_relative_work exceeds 1e-9: small
 * displacements reach no equilibrium. 0 also without free motions, or where the material has no moduli. held: NULL:
 * none. */
PDI_FN int pdi_equilibrium_has_unbalanced_moment(const pd_material_interface *solid, const uint8_t *held,
                                                 const double *load, const pd_rigid_modes *rigid);
/* 1: a point of a component of the body (piece [count]) is prescribed along an axis, or the sum of its loads V load
 * along it is at most 1e-9 of the sum of their absolute values, as without loads; 0: neither. *sum [N]: the signed sum,
 * not set where a point is prescribed; may be NULL, as held may. */
PDI_FN int pdi_equilibrium_is_balanced(const pd_body *body, const uint8_t *held, const double *load, int axis,
                                       const int32_t *piece, int32_t count, double *sum);
#endif

#endif
