/* 02: diffusion in a closed box.
 *
 * A cosine decays as exp(-D (pi/L)^2 t); nothing leaves. Implicit steps against that solution, on three grids and with
 * three step lengths (theory: chapter 6).
 *   cc -std=c99 -O2 -I. examples/02_diffusion.c -o 02_diffusion -lm
 */
#ifndef PD_DIM
#define PD_DIM 2
#endif
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EDGE 100e-6      /* [m] of the box */
#define DIFFUSIVITY 1e-9 /* [m2/s] */
#define MEAN 10.0        /* [mol/m3] */
#define SWING 4.0        /* [mol/m3] */

static pd_ctx ctx;

static void must(pd_status status)
{
    if (status == PD_OK) return;
    fprintf(stderr, "%s: %s\n", pd_status_name(status), ctx.message);
    exit(1);
}

/* Amplitude of the cosine, relative to SWING: its projection on the nodes. */
static double amplitude(const pd_grid *grid, const double *c)
{
    double above = 0.0, below = 0.0;
    for (int32_t i = 0; i < grid->total; i++) {
        double x[PD_DIM];
        if (grid->kind[i] != PD_FLUID) continue;
        pd_grid_position(grid, i, x);
        double mode = cos(3.14159265358979323846 * x[0] / EDGE);
        above += mode * (c[i] - MEAN);
        below += mode * mode * SWING;
    }
    return above / below;
}

/* Relative error of the amplitude after one decay time, and the relative drift of the amount. */
static double decay(int cells, int steps, double *drift)
{
    pd_lattice_desc desc; /* no shapes; all sides are walls by default */
    pd_transport_desc td;
    pd_transport_result result;
    pd_lattice lattice;
    pd_transport transport;
    double pi = 3.14159265358979323846, tau = EDGE * EDGE / (DIFFUSIVITY * pi * pi);
    memset(&desc, 0, sizeof desc);
    memset(&td, 0, sizeof td);
    for (int d = 0; d < PD_DIM; d++) {
        desc.stencil.h[d] = EDGE / cells;
        desc.grid.hi[d] = EDGE;
    }
    td.diffusivity = DIFFUSIVITY;
    must(pd_lattice_build(&ctx, &desc, &lattice));
    must(pd_transport_build(&ctx, &lattice.grid, &lattice.bonds, NULL, &td, &transport));
    for (int32_t i = 0; i < lattice.grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&lattice.grid, i, x);
        if (lattice.grid.kind[i] == PD_FLUID) transport.c[i] = MEAN + SWING * cos(pi * x[0] / EDGE);
    }
    double start = pd_transport_stock(&ctx, &transport), first = amplitude(&lattice.grid, transport.c);
    for (int k = 0; k < steps; k++) must(pd_transport_implicit(&ctx, &transport, tau / steps, &result));
    double now = pd_transport_stock(&ctx, &transport) + pd_transport_carried(&ctx, &transport);
    *drift = fabs(now - start) / start;
    double error = amplitude(&lattice.grid, transport.c) / (first * exp(-1.0)) - 1.0;
    pd_transport_free(&ctx, &transport);
    pd_lattice_free(&ctx, &lattice);
    return error;
}

int main(void)
{
    static const int cells[] = {10, 20, 40, 40, 40, 40}, steps[] = {400, 400, 400, 10, 20, 40};
    pd_ctx_init(&ctx);
    printf("decay of a cosine over one decay time\n  cells  steps   error        amount lost\n");
    for (int k = 0; k < 6; k++) {
        double drift, error = decay(cells[k], steps[k], &drift);
        printf("  %5d  %5d   %10.3e   %8.1e\n", cells[k], steps[k], error, drift);
    }
    return 0;
}
