/* dynamic_relaxation: static equilibrium by adaptive dynamic relaxation, a fallback for Newton's method.
 *
 * Adaptive dynamic relaxation (Underwood 1983; Kilic and Madenci 2010): a fictitious motion in explicit steps of length
 * 1. The mass of a point is a matrix, its block of the stiffness times a factor, so that the highest frequency is
 * below that of the longest stable step; a step that shows a higher one raises the factor. Damping is critical for the
 * frequency of the present motion. Needs forces only, and as many steps as the ratio of frequencies: some times more
 * than conjugate gradients.
 */
#ifndef PD_DYNAMIC_RELAXATION_H
#define PD_DYNAMIC_RELAXATION_H
#include "solid/equilibrium.h"

#define pd_dynamic_relaxation_solve PD_NAME(pd_dynamic_relaxation_solve)

/* As pd_equilibrium_solve: arguments, residual, what is refused; max_iterations 0: 100000. result: iterations are steps
 * of the motion, steps are how often it began anew with more mass. PD_NOT_CONVERGED: the limit was reached, u is the
 * last state. PD_RETRY: displacements became no state of the material with any mass. PD_ERR_DIVERGED: the body moves
 * without end: loads turn it, or it has no stiffness against them. */
PD_API pd_status pd_dynamic_relaxation_solve(pd_ctx *ctx, const pd_material_interface *solid,
                                             const pd_equilibrium_desc *desc, const double *load, double *u,
                                             pd_equilibrium_result *result);

#endif
