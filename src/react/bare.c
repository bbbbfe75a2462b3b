/* bare: see bare.h */
#include "react/bare.h"
#include <math.h>

/* [m] Thickness of minerals in the cells beside a metal node, as a layer over its faces; -1: none are beside it. */
static double pdi_bare_beside(const pd_reactive *r, int32_t j)
{
    const pd_grid *grid = r->grid;
    double thick = 0.0;
    int faces = 0;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int64_t i = j + (side % 2 ? 1 : -1) * (int64_t)grid->stride[side / 2];
        if (i < 0 || i >= grid->total || grid->kind[i] != PD_FLUID) continue;
        thick += pd_reactive_film(r, (int32_t)i) * grid->h[side / 2];
        faces++;
    }
    return faces ? thick / faces : -1.0;
}

/* [m] What lies on metal next to one below it; `thick` holds it where it is known, -1: none is. */
static double pdi_bare_above(const pd_grid *grid, const double *thick, int32_t j)
{
    double sum = 0.0;
    int faces = 0;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int64_t i = j + (side % 2 ? 1 : -1) * (int64_t)grid->stride[side / 2];
        if (i < 0 || i >= grid->total || grid->kind[i] != PD_SOLID || !(thick[i] >= 0.0)) continue;
        sum += thick[i];
        faces++;
    }
    return faces ? sum / faces : -1.0;
}

/* One layer of metal more gets the thickness of what lies above it. Those of this call are kept as -2 - thickness. */
static void pdi_bare_deeper(const pd_grid *grid, double *thick)
{
    for (int32_t j = 0; j < grid->total; j++) {
        double above = grid->kind[j] == PD_SOLID && thick[j] < 0.0 ? pdi_bare_above(grid, thick, j) : -1.0;
        if (above >= 0.0) thick[j] = -2.0 - above;
    }
    for (int32_t j = 0; j < grid->total; j++)
        if (thick[j] <= -2.0) thick[j] = -2.0 - thick[j];
}

PDI_FN void pdi_bare_shares(const pd_reactive *r, double cover, int layers, double *share)
{
    const pd_grid *grid = r->grid;
    for (int32_t j = 0; j < grid->total; j++) share[j] = grid->kind[j] == PD_SOLID ? pdi_bare_beside(r, j) : -1.0;
    for (int layer = 0; layer < layers; layer++) pdi_bare_deeper(grid, share);
    for (int32_t j = 0; j < grid->total; j++) share[j] = share[j] < 0.0 ? -1.0 : exp(-share[j] / cover);
}
