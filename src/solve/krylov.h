/* krylov: iterative solvers for linear systems A x = b, GMRES and CG, with matrix-free callbacks.
 *
 * All vectors have desc.n entries and every sum runs over all of them. Work vectors start as zeros, so entries that
 * the callbacks never write (ghosts, solid nodes) stay zero when they are zero in b and x.
 */
#ifndef PD_KRYLOV_H
#define PD_KRYLOV_H
#include "solve/krylov_basis.h"

typedef struct pd_krylov_result {
    int iterations;
    int applies, precond_applies; /* calls of the operator, of the preconditioner */
    double residual0, residual; /* [unit of b] true |b - A x| of the initial guess and of the returned
                                 * x (skip_true_residual: that of the recurrence) */
    int converged;
} pd_krylov_result;

#define pd_krylov_solve PD_NAME(pd_krylov_solve)

/* Solve A x = b, preconditioned from the right (CG: symmetrically; precond NULL: none). x: guess in, solution out;
 * result may be NULL. PD_NOT_CONVERGED: iteration limit, or a restart leaves more than 0.999 of the residual.
 * PD_ERR_DIVERGED: a callback returned NaN or infinity, or CG met an indefinite operator or preconditioner, or a
 * singular direction (work vector 1). x is the best iterate then. PD_ERR_ARGUMENT: b or the guess is not finite, apply
 * is NULL, first and end are no range in n. b = 0 gives x = 0. Allocates growth up to max_vectors only. Saad 2003
 * (GMRES alg. 9.5, 9.6; CG alg. 9.1), Notay 2000 (flexible CG). */
PD_API pd_status pd_krylov_solve(pd_ctx *ctx, pd_krylov *krylov, pd_apply_fn apply, pd_apply_fn precond, void *user,
                                 const double *b, double *x, pd_krylov_result *result);

#ifdef PDI_INTERNAL
/* [-] Largest and smallest forcing term (relative tolerance of the linear solves in Newton's method). */
#define PDI_KRYLOV_FORCING_MAX 0.1
#define PDI_KRYLOV_FORCING_MIN 1e-3
/* Forcing term of the next linear solve in Newton's method: 0.9 left^2 within these bounds, `left` being the ratio of
 * the last two residual norms (Eisenstat and Walker 1996, choice 2). */
static inline double pdi_krylov_forcing(double left)
{
    return pd_min(PDI_KRYLOV_FORCING_MAX, pd_max(PDI_KRYLOV_FORCING_MIN, 0.9 * left * left));
}
/* Forcing term 0.9 left within these bounds, for strongly nonlinear equations where the square is too optimistic (after
 * their choice 1). */
static inline double pdi_krylov_forcing_linear(double left)
{
    return pd_min(PDI_KRYLOV_FORCING_MAX, pd_max(PDI_KRYLOV_FORCING_MIN, 0.9 * left));
}
/* Smallest meaningful norm [unit of b], sqrt(DBL_MIN / DBL_EPSILON), about 1e-146: below it squares underflow. A
 * residual of at most this counts as zero. */
PDI_FN double pdi_krylov_min_norm(void);
#endif

#endif
