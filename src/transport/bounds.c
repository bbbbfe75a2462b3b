/* bounds: see bounds.h */
#include "transport/bounds.h"
#include <math.h>

PDI_FN void pdi_bounds_take(double value, pdi_bounds *b)
{
    if (value < b->low) b->low = value;
    if (value > b->high) b->high = value;
}

PDI_FN void pdi_bounds_widen(const pd_grid *grid, const double *c, double share, pdi_bounds *b)
{
    double size = 0.0;
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID && fabs(c[i]) > size) size = fabs(c[i]);
    b->low -= share * size;
    b->high += share * size;
}

PDI_FN int pdi_bounds_keep(const pd_grid *grid, const double *c, const double *more, const pdi_bounds *b)
{
    for (int32_t i = 0; i < grid->total; i++) {
        double value = more ? c[i] + more[i] : c[i];
        if (grid->kind[i] == PD_FLUID && (value < b->low || value > b->high)) return 0;
    }
    return 1;
}

/* Mark node i, or the one that it repeats; 1 when it is new. */
static int pdi_bounds_mark_one(const pd_grid *grid, int32_t i, uint8_t *marked)
{
    if (grid->kind[i] == PD_IMAGE) i = pdi_grid_image(grid, i, NULL);
    int fresh = !marked[i];
    marked[i] = 1;
    return fresh;
}

PDI_FN int64_t pdi_bounds_mark(const pd_bonds *bonds, const double *c, const pdi_bounds *b, uint8_t *marked)
{
    const pd_grid *grid = bonds->grid;
    int64_t found = 0;
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_FLUID || (c[i] >= b->low && c[i] <= b->high)) continue;
        if (pdi_bounds_mark_one(grid, i, marked)) found++;
        else
            for (int k = 0; k < bonds->stencil->count; k++)
                found += pdi_bounds_mark_one(grid, i + bonds->paths.shift[k], marked);
    }
    return found;
}
