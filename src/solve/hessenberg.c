/* hessenberg: see hessenberg.h */
#include "solve/hessenberg.h"
#include <math.h>

/* [-] Pivots below this fraction of the largest count as zero: rounding of a singular operator. */
#define PDI_HESSENBERG_MIN_PIVOT 1e-13

PDI_FN void pdi_hessenberg_rotate(int j, double *h, double *cs, double *sn, double *g)
{
    for (int i = 0; i < j; i++) {
        /* two sums: a sum beside a difference gcc 12 fuses even with -ffp-contract=off */
        double t = cs[i] * h[i] + sn[i] * h[i + 1], back = -sn[i];
        h[i + 1] = cs[i] * h[i + 1] + back * h[i];
        h[i] = t;
    }
    double radius = sqrt(h[j] * h[j] + h[j + 1] * h[j + 1]); /* not hypot, whose last bit C libraries differ in */
    cs[j] = radius > 0.0 ? h[j] / radius : 1.0;
    sn[j] = radius > 0.0 ? h[j + 1] / radius : 0.0;
    h[j] = radius;
    h[j + 1] = 0.0;
    g[j + 1] = -sn[j] * g[j];
    g[j] *= cs[j];
}

PDI_FN void pdi_hessenberg_back_substitute(int count, const double *hess, const double *g, double *y)
{
    double largest = 0.0;
    for (int j = 0; j < count; j++) largest = pd_max(largest, fabs(hess[pdi_hessenberg_column_offset(j) + j]));
    for (int i = count - 1; i >= 0; i--) {
        double sum = g[i];
        for (int j = i + 1; j < count; j++) sum -= hess[pdi_hessenberg_column_offset(j) + i] * y[j];
        double pivot = hess[pdi_hessenberg_column_offset(i) + i];
        y[i] = fabs(pivot) > PDI_HESSENBERG_MIN_PIVOT * largest ? sum / pivot : 0.0;
    }
}
