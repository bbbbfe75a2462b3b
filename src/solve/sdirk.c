/* sdirk: see sdirk.h */
#include "solve/sdirk.h"
#include <math.h>

#define PDI_SDIRK_SAFETY 0.9 /* share of the step that the error estimate allows */

PDI_FN double pdi_sdirk_clip(double planned, double largest, double left, int *last)
{
    double dt = largest > 0.0 ? pdi_min(planned, largest) : planned;
    *last = dt >= left * (1.0 - 1e-9);
    if (*last) return left;
    return dt > 0.5 * left ? 0.5 * left : dt;
}

PDI_FN double pdi_sdirk_factor(double share, double growth)
{
    return pdi_min(growth, PDI_SDIRK_SAFETY / sqrt(pdi_max(share, 1e-6)));
}

PDI_FN double pdi_sdirk_plan(double planned, double dt, double factor)
{
    double next = dt * factor;
    return factor < 1.0 ? pdi_min(planned, next) : pdi_max(planned, next);
}

#undef PDI_SDIRK_SAFETY
