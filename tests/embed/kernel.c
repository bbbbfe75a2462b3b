/* The Laplacian of x^2 on a periodic strip, with all of the header private to this file: 2 in whole families. */
#define PDCORR_STATIC
#include "pdcorr.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(void)
{
    pd_ctx ctx;
    pd_stencil_desc sd;
    pd_grid_desc gd;
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    memset(&sd, 0, sizeof sd);
    memset(&gd, 0, sizeof gd);
    pd_ctx_init(&ctx);
    for (int d = 0; d < PD_DIM; d++) {
        sd.h[d] = 1.0;
        gd.hi[d] = 16.0;
        if (d) gd.side[2 * d] = gd.side[2 * d + 1] = PD_SIDE_PERIODIC;
    }
    if (pd_stencil_build(&ctx, &sd, &stencil) < 0 || pd_grid_build(&ctx, &stencil, &gd, &grid) < 0 ||
        pd_bonds_build(&ctx, &stencil, &grid, 0, &bonds) < 0)
        return 1;
    double *f = (double *)calloc((size_t)grid.total, sizeof *f);
    double *lap = (double *)calloc((size_t)grid.total, sizeof *lap);
    if (!f || !lap) return 1;
    for (int32_t i = 0; i < grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&grid, i, x);
        f[i] = x[0] * x[0];
    }
    pd_op_laplacian(&ctx, &bonds, f, lap);
    double worst = 0.0;
    for (int32_t i = 0; i < grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&grid, i, x);
        if (grid.kind[i] == PD_FLUID && x[0] > 4.0 && x[0] < 12.0) worst = fmax(worst, fabs(lap[i] - 2.0));
    }
    printf("%s\n", worst < 1e-12 ? "exact" : "wrong");
    free(f);
    free(lap);
    pd_bonds_free(&ctx, &bonds);
    pd_grid_free(&ctx, &grid);
    pd_stencil_free(&ctx, &stencil);
    return 0;
}
