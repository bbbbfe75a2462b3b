/* sdirk: see sdirk.h */
#include "solve/sdirk.h"
#include <math.h>

#define PDI_SDIRK_SAFETY 0.9 /* [-] safety factor on the step that the error estimate allows */

PDI_FN double pdi_sdirk_limit_step(double planned, double max_step, double left, int *last)
{
    double dt = max_step > 0.0 ? pd_min(planned, max_step) : planned;
    *last = dt >= left * (1.0 - 1e-9);
    if (*last) return left;
    return dt > 0.5 * left ? 0.5 * left : dt;
}

PDI_FN double pdi_sdirk_step_factor(double error_ratio, double max_growth)
{
    return pd_min(max_growth, PDI_SDIRK_SAFETY / sqrt(pd_max(error_ratio, 1e-6)));
}

PDI_FN double pdi_sdirk_update_plan(double planned, double dt, double factor)
{
    double next = dt * factor;
    return factor < 1.0 ? pd_min(planned, next) : pd_max(planned, next);
}

#undef PDI_SDIRK_SAFETY
