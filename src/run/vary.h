/* vary: values of a scene that depend on time, and how far a step may go without passing over what they do.
 *
 * A step sees such a value at its beginning, its middle and its end. Bounds by interval arithmetic say whether the
 * value leaves the range between both ends on the way, or jumps. Where it does, the step ends there.
 */
#ifndef PD_VARY_H
#define PD_VARY_H
#include "core/owner.h"
#include "scene/range.h"
#include "scene/setup.h"

/* A value at a place. */
typedef struct pd_vary_value {
    const pd_expr *expr;
    double x[PD_DIM]; /* [m] */
    int middle;       /* 1: steps go by the value of their middle */
    double fold;      /* [V] with `middle`: change by which what it drives grows e-fold; HUGE_VAL: that follows it */
} pd_vary_value;

/* All of them; zero: nothing depends on time. */
typedef struct pd_vary {
    pd_vary_value *value; /* [capacity] */
    int32_t count, capacity;
    double last; /* [s] end of the run */
    double rtol; /* [-] */
} pd_vary;

#ifdef PDI_INTERNAL
/* The values of a setup, which is borrowed: what sides and walls hold and let in, streams, forces, potentials, what
 * moves and loads bodies. */
PDI_FN pd_status pdi_vary_build(pd_ctx *ctx, const pd_setup *setup, pd_vary *vary);
/* Where a step from t that is to end at `end` [s] ends at the latest. user: a pd_vary. */
PDI_FN double pdi_vary_until(void *user, double t, double end);
PDI_FN void pdi_vary_free(pd_ctx *ctx, pd_vary *vary);
#endif

#endif
