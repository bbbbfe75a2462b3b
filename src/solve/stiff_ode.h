/* stiff_ode: integrator of a small system of stiff ordinary differential equations dy/dt = f(t, y) with bounds on y and
 * error control.
 *
 * Linearly implicit Euler steps, extrapolated to order 5 (Deuflhard 1985; Hairer and Wanner 1996, IV.9). A component
 * that reaches a bound stays there as long as its rate points outwards; the step ends where the bound is reached. Rates
 * are evaluated within the bounds only. Nothing is allocated or global: thread-safe.
 */
#ifndef PD_STIFF_ODE_H
#define PD_STIFF_ODE_H
#include "core/base.h"

#define PD_STIFF_ODE_MAX_EQUATIONS 8 /* most equations */

/* The right-hand side f: rates [count] [unit of y per s] of y [count] at time t [s]. */
typedef void (*pd_stiff_ode_rate_fn)(void *user, double t, const double *y, double *rate);

/* The system of equations. */
typedef struct pd_stiff_ode {
    int count; /* equations */
    pd_stiff_ode_rate_fn rate;
    void *user;
    const double *low, *high; /* [count] [unit of y] bounds; infinite: none */
    const double *typical;    /* [count] [unit of y] typical values: errors are relative to the larger of size and
                               * |y| */
    double tolerance;         /* [-] relative error allowed in a step */
} pd_stiff_ode;

typedef enum pd_stiff_ode_status {
    PD_STIFF_ODE_DONE = 0,
    PD_STIFF_ODE_NOT_FINITE, /* a rate is NaN or infinite */
    PD_STIFF_ODE_UNDERFLOW   /* step underflow or too many steps, as where a rate jumps back and forth */
} pd_stiff_ode_status;

#ifdef PDI_INTERNAL
/* Integrate y, in place, from time `from` to `to` [s]; DONE and no change for to <= from. y has room for
 * PD_STIFF_ODE_MAX_EQUATIONS values, all of which are read and `count` of which are used. NOT_FINITE: a rate is not
 * below 1e100 in size, at the last good y or in any step from there; *which: index of its equation, else unchanged.
 * UNDERFLOW: a step of at most 1e-13 of the interval, or 5000 steps. On failure y is that of the last good step. */
PDI_FN pd_stiff_ode_status pdi_stiff_ode_solve(const pd_stiff_ode *stiff, double from, double to, double *y,
                                               int *which);
#endif

#endif
