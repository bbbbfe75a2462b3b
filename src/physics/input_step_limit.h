/* input_step_limit: time step limit from boundary values and loads of a scene that depend on time, so that no peak,
 * pulse or jump is stepped over.
 *
 * A step samples such a value at its start, middle and end. Bounds by interval arithmetic say whether the value leaves
 * the range between start and end, or jumps. Where it does, the step ends there.
 */
#ifndef PD_INPUT_STEP_LIMIT_H
#define PD_INPUT_STEP_LIMIT_H
#include "core/array_registry.h"
#include "setup/interval.h"
#include "setup/setup.h"

/* A time-dependent expression at one sample place. */
typedef struct pd_input_value {
    const pd_expr *expr;
    double x[PD_DIM]; /* [m] */
    int at_midpoint;  /* 1: the solver takes the value at the midpoint of a step */
    /* [V] with `middle`: change by which the current grows e-fold; HUGE_VAL: it is linear */
    double efolding_voltage;
} pd_input_value;

/* All time-dependent inputs; zero: there are none. */
typedef struct pd_input_step_limit {
    pd_input_value *value; /* [capacity] */
    int32_t count, capacity;
    double end_time; /* [s] end time of the run */
    double rtol; /* [-] */
} pd_input_step_limit;

#ifdef PDI_INTERNAL
/* List the time-dependent expressions of a setup, which is borrowed, at sample places: boundary values of sides and
 * walls, inflow, body forces, potentials and currents, prescribed displacements and loads. count 0: there are none, and
 * nothing is allocated. After an error vary is 0. */
PDI_FN pd_status pdi_input_step_limit_build(pd_ctx *ctx, const pd_setup *setup, pd_input_step_limit *vary);
/* Latest end [s] of a step from t that is to end at `end` [s], at most `end` and above t: the first change that its
 * ends do not show, and the midpoint error, of all values, in repeated passes. Where no end above t is found, that of
 * the pass before. The next_event callback of pd_time_loop; user: a pd_input_step_limit. */
PDI_FN double pdi_input_step_limit_compute(void *user, double t, double end);
PDI_FN void pdi_input_step_limit_free(pd_ctx *ctx, pd_input_step_limit *vary);
#endif

#endif
