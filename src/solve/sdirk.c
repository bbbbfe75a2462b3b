/* sdirk: see sdirk.h */
#include "solve/sdirk.h"
#include <math.h>

#define PDI_SDIRK_SAFETY 0.9     /* [-] safety factor on the step that the error estimate allows */
#define PDI_SDIRK_MAX_GROWTH 4.0 /* [-] a step is at most this many times the one before */
#define PDI_SDIRK_MIN_SHRINK 0.1 /* [-] a repeated step is at least this part of the one that failed */

PDI_FN double pdi_sdirk_limit_step(double planned, double max_step, double left)
{
    double dt = max_step > 0.0 ? pd_min(planned, max_step) : planned;
    if (dt >= left * (1.0 - 1e-9)) return left;
    return dt > 0.5 * left ? 0.5 * left : dt;
}

/* Factor from this step to the next one, at most PDI_SDIRK_MAX_GROWTH, by error over tolerance: errors of a step are of
 * second order in it. */
static double pdi_sdirk_step_factor(double error_ratio)
{
    return pd_min(PDI_SDIRK_MAX_GROWTH, PDI_SDIRK_SAFETY / sqrt(pd_max(error_ratio, 1e-6)));
}

PDI_FN double pdi_sdirk_update_plan(double planned, double dt, double error_ratio)
{
    double factor = pdi_sdirk_step_factor(error_ratio), next = dt * factor;
    return factor < 1.0 ? pd_min(planned, next) : pd_max(planned, next);
}

PDI_FN void pdi_sdirk_limit(double planned, double max_step, pd_step *s)
{
    s->dt = pdi_sdirk_limit_step(planned, max_step, s->latest_end - s->time);
}

PDI_FN void pdi_sdirk_accept(double *planned, const pd_step *s)
{
    *planned = pdi_sdirk_update_plan(*planned, s->dt, s->error);
}

PDI_FN void pdi_sdirk_reject(double *planned, double max_step, pd_step *s)
{
    *planned = s->dt * pd_max(PDI_SDIRK_MIN_SHRINK, pdi_sdirk_step_factor(s->error));
    pdi_sdirk_limit(*planned, max_step, s);
}

#undef PDI_SDIRK_SAFETY
#undef PDI_SDIRK_MAX_GROWTH
#undef PDI_SDIRK_MIN_SHRINK
