/* equilibrium: displacements of a body at rest under loads and held points.
 *
 * Newton's method with conjugate gradients: forces are the derivative of an energy, so their derivative is symmetric. A
 * linear material takes one step. Where what is held follows what is free, the derivative is not symmetric, and GMRES
 * takes the place of conjugate gradients. The preconditioner adds a coarse picture of the body to the block of each
 * point, so finer cells take no more iterations. A piece that nothing holds may move as a whole; then the loads have to
 * balance, and of all displacements those without a mean motion are found.
 */
#ifndef PD_EQUILIBRIUM_H
#define PD_EQUILIBRIUM_H
#include "solid/rigid.h"
#include "solid/scaffold.h"
#include "solid/solid.h"
#include "solve/krylov.h"

/* Default of rtol. */
#define PD_EQUILIBRIUM_RTOL 1e-10

/* A displacement that is held and follows one that is free: u[at] = given + part u[leader]. */
typedef struct pd_interpolated {
    int64_t at, leader; /* components of [count][PD_DIM]; one that follows several has a row for each */
    double part;        /* [-] */
    int face;           /* 1: it lies less than a spacing from the place that is given */
} pd_interpolated;

/* All of them. */
typedef struct pd_interpolation {
    int64_t count;
    pd_interpolated *row; /* [count] */
} pd_interpolation;

typedef struct pd_equilibrium_desc {
    const uint8_t *held;   /* [count][PD_DIM] 1: this displacement stays as it is, or is interpolated; NULL: all are
                            * free. Borrowed */
    const pd_interpolation *interpolation; /* of what is held; NULL: it stays. Borrowed */
    double rtol;           /* [-] of the forces of free points, over the loads and the forces on what is held in
                            * balance; 0: PD_EQUILIBRIUM_RTOL. Rounding of the displacements counts as balance */
    int max_iterations;    /* 0: 10000 */
    double *swing;         /* [count][PD_DIM] [-] with PD_ERR_DIVERGED, of a linear material: a motion that bonds do
                            * not resist and along which the loads work; 0: none was found. NULL: unwanted. Borrowed */
} pd_equilibrium_desc;

typedef struct pd_equilibrium_result {
    int iterations;  /* of conjugate gradients, or of GMRES */
    int steps;       /* of Newton's method */
    double residual; /* [-] as of rtol */
} pd_equilibrium_result;

#define pd_equilibrium_solve PD_NAME(pd_equilibrium_solve)

/* u [count][PD_DIM] [m]: values of what is held, as they belong to the guess where they are interpolated, and a guess
 * of the rest; the displacements. load [count][PD_DIM] [N/m3], in the directions of the body as it was; NULL: none.
 * PD_NOT_CONVERGED: a linear material, u is the best of all.
 * PD_RETRY: Newton's method found no balance: a shorter step from a state in balance may. PD_ERR_STATE: a load or
 * displacement is not finite, a piece that is not held along an axis has loads along it that do not balance, or the
 * guess is no state of the material. PD_ERR_DIVERGED: loads turn the body, or a part of it about a hinge. */
PD_API pd_status pd_equilibrium_solve(pd_ctx *ctx, const pd_solid *solid, const pd_equilibrium_desc *desc,
                                      const double *load, double *u, pd_equilibrium_result *result);

#ifdef PDI_INTERNAL
/* A solve of displacements. */
typedef struct pdi_equilibrium {
    pd_ctx *ctx;
    const pd_solid *solid;
    const pd_equilibrium_desc *desc;
    const double *load;
    int64_t n;     /* components of all points */
    double size;   /* [N] of the problem, which residuals are over */
    double digits; /* [N] that are rounding at the guess, which what is added to it does not undo */
    double pull;   /* [N] norm of the forces of bonds on what is held, as of the last rest */
    double *diagonal; /* [n] [N/m] of the blocks */
    double *block; /* [count][PD_DIM^2] [m/N] inverse blocks */
    double *rest;  /* [n] [N] */
    double *step;  /* [n] [m] */
    double *whole; /* [n] [m] a direction, with what is interpolated; empty where nothing is */
    double *trial; /* [n] [m] of materials that are not linear */
    double *lambda, *mu;  /* [count] [Pa] where the moduli are known */
    pd_scaffold scaffold; /* where the moduli are known */
    int moves;            /* 1: a piece may move as a whole */
    pd_krylov krylov;
} pdi_equilibrium;

/* 1: what is held follows what is free. */
static inline int pdi_equilibrium_follows(const pdi_equilibrium *q)
{
    return q->desc->interpolation && q->desc->interpolation->count > 0;
}
static inline int pdi_equilibrium_held(const pdi_equilibrium *q, int64_t k)
{
    return q->desc->held && q->desc->held[k];
}
PDI_FN void pdi_equilibrium_list(pdi_owner *owner, void *equilibrium);
/* The solver of the linear steps, without its size and limits. */
PDI_FN pd_krylov_desc pdi_equilibrium_krylov(int follows);
/* Memory, what can be refused, what is not in balance at u and its norm, the norm [N] to be met. */
PDI_FN pd_status pdi_equilibrium_begin(pdi_equilibrium *equilibrium, const double *u, double *norm, double *target);
/* What is not in balance at u, into rest [N], and its norm. PD_RETRY: as of the material. */
PDI_FN pd_status pdi_equilibrium_rest(pdi_equilibrium *equilibrium, const double *u, double *norm);
/* Inverse blocks and their diagonals, at the last u. Components that are held are left out. */
PDI_FN void pdi_equilibrium_blocks(const pdi_equilibrium *equilibrium);
/* y [m] = the inverse blocks times x [N], and the coarse picture where there is one. */
PDI_FN void pdi_equilibrium_precondition(void *equilibrium, const double *x, double *y);
/* 1: loads turn a piece that does not resist: strains are small, so it does not turn to where they balance. */
PDI_FN int pdi_equilibrium_turns(const pd_solid *solid, const uint8_t *held, const double *load, const pd_rigid *rigid);
/* 1: something holds a piece of points along an axis, or its loads along it balance. *sum: them [N]; may be NULL. */
PDI_FN int pdi_equilibrium_bears(const pd_body *body, const uint8_t *held, const double *load, int axis,
                                 const int32_t *piece, int32_t count, double *sum);
#endif

#endif
