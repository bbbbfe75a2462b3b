/* anderson: see anderson.h */
#include "solve/anderson.h"
#include <math.h>
#include <string.h>

/* A change of steps that the kept ones leave so little of has no direction of its own. */
#define PDI_ANDERSON_NEW 1e-6

PDI_FN void pdi_anderson_list(pdi_owner *owner, void *object)
{
    pd_anderson *anderson = (pd_anderson *)object;
    PDI_ARRAY(owner, anderson, x, anderson->n, "");
    PDI_ARRAY(owner, anderson, step, anderson->n, "");
    PDI_ARRAY(owner, anderson, turn, anderson->n * PD_ANDERSON_KEPT, "1");
    PDI_ARRAY(owner, anderson, way, anderson->n * PD_ANDERSON_KEPT, "1");
}

static double pdi_anderson_dot(const pd_anderson *a, const double *x, const double *y)
{
    double sum = 0.0;
    for (int64_t k = 0; k < a->n; k++) sum += x[k] * y[k];
    return sum;
}

/* Keeps the change from the last place to this one. */
static void pdi_anderson_keep(pd_anderson *a, const double *x, const double *step)
{
    if (a->count == PD_ANDERSON_KEPT) a->count = 0;
    double *turn = a->turn + a->count * a->n, *way = a->way + a->count * a->n;
    for (int64_t k = 0; k < a->n; k++) {
        turn[k] = step[k] - a->step[k];
        way[k] = x[k] - a->x[k];
    }
    double whole = sqrt(pdi_anderson_dot(a, turn, turn));
    for (int j = 0; j < a->count; j++) {
        double part = pdi_anderson_dot(a, a->turn + j * a->n, turn);
        for (int64_t k = 0; k < a->n; k++) {
            turn[k] -= part * a->turn[j * a->n + k];
            way[k] -= part * a->way[j * a->n + k];
        }
    }
    double left = sqrt(pdi_anderson_dot(a, turn, turn));
    if (!(left > PDI_ANDERSON_NEW * whole)) return;
    for (int64_t k = 0; k < a->n; k++) {
        turn[k] /= left;
        way[k] /= left;
    }
    a->count++;
}

PDI_FN void pdi_anderson_next(pd_anderson *a, double *x, double *step)
{
    if (a->known) pdi_anderson_keep(a, x, step);
    memcpy(a->x, x, (size_t)a->n * sizeof *x);
    memcpy(a->step, step, (size_t)a->n * sizeof *step);
    a->known = 1;
    for (int j = 0; j < a->count; j++) {
        double part = pdi_anderson_dot(a, a->turn + j * a->n, step);
        for (int64_t k = 0; k < a->n; k++) {
            step[k] -= part * a->turn[j * a->n + k];
            x[k] -= part * a->way[j * a->n + k];
        }
    }
    for (int64_t k = 0; k < a->n; k++) x[k] += step[k];
}

#undef PDI_ANDERSON_NEW
