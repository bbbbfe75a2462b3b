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
    PDI_ARRAY(owner, anderson, previous_x, anderson->n, "");
    PDI_ARRAY(owner, anderson, previous_residual, anderson->n, "");
    PDI_ARRAY(owner, anderson, best_x, anderson->n, "");
    PDI_ARRAY(owner, anderson, best_residual, anderson->n, "");
    PDI_ARRAY(owner, anderson, residual_differences, anderson->n * PD_ANDERSON_HISTORY, "1");
    PDI_ARRAY(owner, anderson, iterate_differences, anderson->n * PD_ANDERSON_HISTORY, "1");
}

/* Dot product x.y, in fixed order. */
static double pdi_anderson_dot(const pd_anderson *a, const double *x, const double *y)
{
    double sum = 0.0;
    for (int64_t k = 0; k < a->n; k++) sum += x[k] * y[k];
    return sum;
}

/* Add the differences of residual and iterate since the previous iterate to the history, by modified Gram-Schmidt. A
 * full history is cleared first. It is cleared, too, and begins anew with this difference, where orthogonalisation
 * leaves at most 1e-6 of the residual difference: linear dependence contradicts the linear model. A residual difference
 * of at most 1e-12 of the previous residual is rounding: the history is cleared, and nothing is added. */
static void pdi_anderson_add_difference(pd_anderson *a, const double *x, const double *step)
{
    if (a->count == PD_ANDERSON_HISTORY) a->count = 0;
    for (;;) {
        double *turn = a->residual_differences + a->count * a->n, *way = a->iterate_differences + a->count * a->n;
        for (int64_t k = 0; k < a->n; k++) {
            turn[k] = step[k] - a->previous_residual[k];
            way[k] = x[k] - a->previous_x[k];
        }
        double whole = sqrt(pdi_anderson_dot(a, turn, turn));
        for (int j = 0; j < a->count; j++) {
            double part = pdi_anderson_dot(a, a->residual_differences + j * a->n, turn);
            for (int64_t k = 0; k < a->n; k++) {
                turn[k] -= part * a->residual_differences[j * a->n + k];
                way[k] -= part * a->iterate_differences[j * a->n + k];
            }
        }
        double left = sqrt(pdi_anderson_dot(a, turn, turn));
        if (left > PDI_ANDERSON_DEPENDENT * whole && whole > PDI_ANDERSON_ROUNDING * a->previous_norm) {
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
    memcpy(a->previous_x, x, (size_t)a->n * sizeof *x);
    memcpy(a->previous_residual, step, (size_t)a->n * sizeof *step);
    a->previous_norm = size;
    a->has_previous = 1;
}

/* Store x and step as the best iterate where `size`, the norm of step, is at most the least norm, or there is no
 * previous iterate. Else count a growth where `size` is above the previous norm, or set the count to 0. Returns 1 at
 * the second growth in a row: x and step then are replaced by the best iterate and its residual; else 0. */
static int pdi_anderson_is_diverging(pd_anderson *a, double *x, double *step, double size)
{
    if (!a->has_previous || size <= a->least_norm) {
        memcpy(a->best_x, x, (size_t)a->n * sizeof *x);
        memcpy(a->best_residual, step, (size_t)a->n * sizeof *step);
        a->least_norm = size;
        a->growth_count = 0;
        return 0;
    }
    a->growth_count = size > a->previous_norm ? a->growth_count + 1 : 0;
    if (a->growth_count < 2) return 0;
    memcpy(x, a->best_x, (size_t)a->n * sizeof *x);
    memcpy(step, a->best_residual, (size_t)a->n * sizeof *step);
    a->growth_count = 0;
    return 1;
}

PDI_FN void pdi_anderson_reset(pd_anderson *a)
{
    a->count = a->has_previous = 0;
    a->mixing = 1.0;
}

PDI_FN void pdi_anderson_update(pd_anderson *a, double *x, double *step)
{
    double size = sqrt(pdi_anderson_dot(a, step, step));
    if (!a->has_previous) pdi_anderson_reset(a);
    if (pdi_anderson_is_diverging(a, x, step, size)) {
        size = a->least_norm;
        a->mixing *= 0.5;
        a->count = 0;
    } else if (a->has_previous) {
        pdi_anderson_add_difference(a, x, step);
    }
    pdi_anderson_set_previous(a, x, step, size);
    for (int j = 0; j < a->count; j++) {
        double part = pdi_anderson_dot(a, a->residual_differences + j * a->n, step);
        for (int64_t k = 0; k < a->n; k++) {
            step[k] -= part * a->residual_differences[j * a->n + k];
            x[k] -= part * a->iterate_differences[j * a->n + k];
        }
    }
    for (int64_t k = 0; k < a->n; k++) x[k] += a->mixing * step[k];
}

#undef PDI_ANDERSON_DEPENDENT
#undef PDI_ANDERSON_ROUNDING
