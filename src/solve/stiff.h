/* stiff: a few ordinary differential equations, stiff or not, from one time to another with a controlled error.
 *
 * Linearly implicit steps of Euler, extrapolated to order 5 (Deuflhard 1985; Hairer and Wanner 1996, IV.9). A value
 * that reaches a bound stays there as long as its rate points outwards: the step ends where the bound is met. Rates are
 * asked within bounds only. Nothing is allocated and nothing is global, so threads may solve side by side.
 */
#ifndef PD_STIFF_H
#define PD_STIFF_H
#include "core/base.h"

#define PD_STIFF_MOST 8 /* equations */

/* Rates [count] [unit of y per s] of y [count] at time t [s]. */
typedef void (*pd_stiff_fn)(void *user, double t, const double *y, double *rate);

typedef struct pd_stiff {
    int count;
    pd_stiff_fn rate;
    void *user;
    const double *low, *high; /* [count] [unit of y] bounds; infinite: none */
    const double *size;       /* [count] [unit of y] errors count against that, or against a larger value */
    double tolerance;         /* [-] of a step */
} pd_stiff;

typedef enum pd_stiff_end {
    PD_STIFF_DONE = 0,
    PD_STIFF_NOT_FINITE, /* a rate is not */
    PD_STIFF_STUCK       /* the error does not fall with the step, as where a rate jumps back and forth */
} pd_stiff_end;

#ifdef PDI_INTERNAL
/* y [count] at `from` [s] becomes that at `to`. *which: the equation that is not finite, else unchanged. */
PDI_FN pd_stiff_end pdi_stiff_solve(const pd_stiff *stiff, double from, double to, double *y, int *which);
#endif

#endif
