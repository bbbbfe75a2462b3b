/* advance: steps in time of species that flow, diffuse and react (theory: 8).
 */
#ifndef PD_ADVANCE_H
#define PD_ADVANCE_H
#include "react/reactive.h"

typedef struct pd_reactive_result {
    int newton, krylov;
    int parts;       /* shorter steps that led to the solution; 0: it was found at once */
    double residual; /* [-] over the tolerance */
    double error;    /* [-] of two stages in the totals, over the largest of each, also where they have left bounds; 0:
                      * they were not taken, or not solved */
    int euler;       /* 1: a step of order 2 was taken by backward Euler, since it would have left bounds, or its second
                      * stage begun with less than nothing */
} pd_reactive_result;

#define pd_reactive_step PD_NAME(pd_reactive_step)

/* One step of dt [s], of any length: by backward Euler, or the two stages of two_stage.h. Beyond all time scales it
 * gives the steady state. PD_RETRY: no solution was found, and nothing has changed; a shorter step may do. */
PD_API pd_status pd_reactive_step(pd_ctx *ctx, pd_reactive *reactive, double dt, pd_reactive_result *result);

#endif
