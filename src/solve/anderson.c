/* anderson: see anderson.h */
#include "solve/anderson.h"
#include <math.h>
#include <string.h>

/* [-] A difference of residuals is linearly dependent when orthogonalisation leaves less than this fraction of it. */
#define PDI_ANDERSON_DEPENDENT 1e-6
/* [-] A difference of residuals below this fraction of the residual is rounding. */
#define PDI_ANDERSON_ROUNDING 1e-12

PDI_FN void pdi_anderson_list(pdi_array_visitor *owner, void *object)
{
    pd_anderson *anderson = (pd_anderson *)object;
    PDI_ARRAY(owner, anderson, x, anderson->n, "");
    PDI_ARRAY(owner, anderson, step, anderson->n, "");
    PDI_ARRAY(owner, anderson, best, anderson->n, "");
    PDI_ARRAY(owner, anderson, shortest, anderson->n, "");
    PDI_ARRAY(owner, anderson, turn, anderson->n * PD_ANDERSON_HISTORY, "1");
    PDI_ARRAY(owner, anderson, way, anderson->n * PD_ANDERSON_HISTORY, "1");
}

/* Dot product x.y, in fixed order. */
static double pdi_anderson_dot(const pd_anderson *a, const double *x, const double *y)
{
    double sum = 0.0;
    for (int64_t k = 0; k < a->n; k++) sum += x[k] * y[k];
    return sum;
}

/* Add the differences of residual and iterate since the previous iterate to the history, by modified Gram-Schmidt. A
 * linearly dependent residual difference contradicts the linear model: the history is cleared first. */
static void pdi_anderson_add_difference(pd_anderson *a, const double *x, const double *step)
{
    if (a->count == PD_ANDERSON_HISTORY) a->count = 0;
    for (;;) {
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
        if (left > PDI_ANDERSON_DEPENDENT * whole && whole > PDI_ANDERSON_ROUNDING * a->size) {
            for (int64_t k = 0; k < a->n; k++) {
                turn[k] /= left;
                way[k] /= left;
            }
            a->count++;
            return;
        }
        if (!a->count) return;
        a->count = 0;
    }
}

/* Store x and its residual, of norm `size`, as the previous iterate. */
static void pdi_anderson_set_previous(pd_anderson *a, const double *x, const double *step, double size)
{
    memcpy(a->x, x, (size_t)a->n * sizeof *x);
    memcpy(a->step, step, (size_t)a->n * sizeof *step);
    a->size = size;
    a->known = 1;
}

/* Track the best iterate. Returns 1 on divergence, after residuals that grew twice in a row: x and step are then
 * replaced by the best iterate and its residual. */
static int pdi_anderson_is_diverging(pd_anderson *a, double *x, double *step, double size)
{
    if (!a->known || size <= a->least) {
        memcpy(a->best, x, (size_t)a->n * sizeof *x);
        memcpy(a->shortest, step, (size_t)a->n * sizeof *step);
        a->least = size;
        a->grown = 0;
        return 0;
    }
    a->grown = size > a->size ? a->grown + 1 : 0;
    if (a->grown < 2) return 0;
    memcpy(x, a->best, (size_t)a->n * sizeof *x);
    memcpy(step, a->shortest, (size_t)a->n * sizeof *step);
    a->grown = 0;
    return 1;
}

PDI_FN void pdi_anderson_reset(pd_anderson *a)
{
    a->count = a->known = 0;
    a->part = 1.0;
}

PDI_FN void pdi_anderson_update(pd_anderson *a, double *x, double *step)
{
    double size = sqrt(pdi_anderson_dot(a, step, step));
    if (!a->known) pdi_anderson_reset(a);
    if (pdi_anderson_is_diverging(a, x, step, size)) {
        size = a->least;
        a->part *= 0.5;
        a->count = 0;
    } else if (a->known) {
        pdi_anderson_add_difference(a, x, step);
    }
    pdi_anderson_set_previous(a, x, step, size);
    for (int j = 0; j < a->count; j++) {
        double part = pdi_anderson_dot(a, a->turn + j * a->n, step);
        for (int64_t k = 0; k < a->n; k++) {
            step[k] -= part * a->turn[j * a->n + k];
            x[k] -= part * a->way[j * a->n + k];
        }
    }
    for (int64_t k = 0; k < a->n; k++) x[k] += a->part * step[k];
}

#undef PDI_ANDERSON_DEPENDENT
#undef PDI_ANDERSON_ROUNDING
