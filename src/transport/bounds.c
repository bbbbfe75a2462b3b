/* bounds: see bounds.h */
#include "transport/bounds.h"
#include <math.h>

PDI_FN void pdi_bounds_take(double value, pdi_bounds *b)
{
    if (value < b->low) b->low = value;
    if (value > b->high) b->high = value;
}

PDI_FN void pdi_bounds_take_all(const pd_grid *grid, uint8_t kind, const double *x, pdi_bounds *b)
{
    enum { lanes = 8, block = 64 };
    double low[lanes], high[lanes], of[block];
    int32_t i = 0;
    for (; i < grid->total && b->low > b->high; i++)
        if (grid->kind[i] == kind) pdi_bounds_take(x[i], b);
    double none = b->low; /* moves neither of both */
    for (int l = 0; l < lanes; l++) {
        low[l] = b->low;
        high[l] = b->high;
    }
    for (; i + block <= grid->total; i += block) {
        for (int k = 0; k < block; k++) of[k] = grid->kind[i + k] == kind ? x[i + k] : none;
        for (int k = 0; k < block; k += lanes)
            for (int l = 0; l < lanes; l++) {
                low[l] = of[k + l] < low[l] ? of[k + l] : low[l];
                high[l] = of[k + l] > high[l] ? of[k + l] : high[l];
            }
    }
    for (; i < grid->total; i++)
        if (grid->kind[i] == kind) pdi_bounds_take(x[i], b);
    for (int l = 0; l < lanes; l++) {
        pdi_bounds_take(low[l], b);
        pdi_bounds_take(high[l], b);
    }
}

PDI_FN void pdi_bounds_take_inlets(const pd_ghosts *ghosts, const double *x, pdi_bounds *b)
{
    for (int32_t k = ghosts->outlets_end; k < ghosts->inlets_end; k++) pdi_bounds_take(x[ghosts->node[k]], b);
}

PDI_FN void pdi_bounds_widen(const pd_grid *grid, const double *c, double share, pdi_bounds *b)
{
    pdi_bounds of = {0.0, 0.0};
    pdi_bounds_take_all(grid, PD_FLUID, c, &of);
    double size = of.high > -of.low ? of.high : -of.low;
    b->low -= share * size;
    b->high += share * size;
}

PDI_FN int pdi_bounds_keep(const pd_grid *grid, const double *c, const double *more, const pdi_bounds *b)
{
    if (!more) {
        pdi_bounds of = {HUGE_VAL, -HUGE_VAL};
        pdi_bounds_take_all(grid, PD_FLUID, c, &of);
        return of.low >= b->low && of.high <= b->high;
    }
    for (int32_t i = 0; i < grid->total; i++) {
        double value = c[i] + more[i];
        if (grid->kind[i] == PD_FLUID && (value < b->low || value > b->high)) return 0;
    }
    return 1;
}

/* Mark node i, or the one that it repeats; 1 when it is new. */
static int pdi_bounds_mark_one(const pd_grid *grid, int32_t i, uint8_t *marked)
{
    if (grid->kind[i] == PD_IMAGE) i = pd_grid_find_source(grid, i, NULL);
    int fresh = !marked[i];
    marked[i] = 1;
    return fresh;
}

PDI_FN int64_t pdi_bounds_mark(const pd_bonds *bonds, const double *c, const pdi_bounds *b, uint8_t *marked)
{
    const pd_grid *grid = bonds->grid;
    int64_t found = 0;
    double low = b->low, high = b->high;
    int32_t outside = 0;
    for (int32_t i = 0; i < grid->total; i++)
        outside += (grid->kind[i] == PD_FLUID) & !((c[i] >= low) & (c[i] <= high));
    for (int32_t i = 0; i < grid->total && outside; i++) {
        if (grid->kind[i] != PD_FLUID || (c[i] >= b->low && c[i] <= b->high)) continue;
        if (pdi_bounds_mark_one(grid, i, marked)) found++;
        else
            for (int k = 0; k < bonds->stencil->count; k++)
                found += pdi_bounds_mark_one(grid, i + bonds->paths.shift[k], marked);
    }
    return found;
}
