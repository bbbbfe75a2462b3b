/* 03: steady flow between plates.
 *
 * From rest to plane Poiseuille flow, u = 3/2 U (1 - (y/H)^2), dp/dx = -3 mu U / H^2: an exact solution of the discrete
 * equations (theory: section 3.9), so the error is that of the solver, on any grid.
 *   cc -std=c99 -O2 -I. examples/03_poiseuille.c -o 03_poiseuille -lm
 */
#define PD_DIM 2
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HALF 150e-6 /* [m] H, half the distance of the plates */
#define MEAN 0.01   /* [m/s] U */
#define RHO 1000.0  /* [kg/m3] */
#define MU 1e-3     /* [Pa s] */

static pd_ctx ctx;

static void must(pd_status status)
{
    if (status == PD_OK) return;
    fprintf(stderr, "%s: %s\n", pd_status_name(status), ctx.message);
    exit(1);
}

static void parabola(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = 1.5 * MEAN * (1.0 - x[1] * x[1] / (HALF * HALF));
    u[1] = 0.0;
}

/* Relative errors (L2 of the velocity, drop of pressure) with `across` cells between the plates. */
static void solve(int across)
{
    pd_stencil_desc sd;
    pd_grid_desc gd;
    pd_flow_desc fd;
    pd_steady_desc dd;
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_flow flow;
    pd_steady steady;
    pd_steady_result result;
    double slope = -3.0 * MU * MEAN / (HALF * HALF), error = 0.0, size = 0.0, worst = 0.0;
    memset(&sd, 0, sizeof sd);
    memset(&gd, 0, sizeof gd);
    memset(&fd, 0, sizeof fd);
    memset(&dd, 0, sizeof dd);
    sd.h[0] = sd.h[1] = 2.0 * HALF / across;
    gd.hi[0] = 4.0 * HALF;
    gd.lo[1] = -HALF;
    gd.hi[1] = HALF;
    gd.side[0] = PD_SIDE_INLET; /* x-; y- and y+ stay walls */
    gd.side[1] = PD_SIDE_OUTLET;
    fd.rho = RHO;
    fd.mu = MU;
    fd.report_speed = MEAN;
    fd.report_length = 2.0 * HALF;
    fd.inlet = parabola;
    fd.developed_sides = 1; /* side x- */
    dd.tolerance = 1e-10;
    must(pd_stencil_build(&ctx, &sd, &stencil));
    must(pd_grid_build(&ctx, &stencil, &gd, &grid));
    must(pd_bonds_build(&ctx, &stencil, &grid, 0, &bonds));
    must(pd_flow_build(&ctx, &grid, &bonds, &fd, &flow));
    must(pd_steady_build(&ctx, &flow, &dd, &steady));
    must(pd_steady_solve(&ctx, &steady, &result));
    for (int32_t i = 0; i < grid.total; i++) {
        double x[PD_DIM], u[PD_DIM];
        if (grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&grid, i, x);
        parabola(NULL, x, u);
        for (int d = 0; d < PD_DIM; d++) {
            double off = flow.u[(int64_t)d * grid.total + i] - u[d];
            error += off * off;
            size += u[d] * u[d];
        }
        worst = fmax(worst, fabs(RHO * flow.p[i] - slope * (x[0] - gd.hi[0])));
    }
    double in = pd_flow_integrate_section(&ctx, &flow, 0, 1),
           out = pd_flow_integrate_section(&ctx, &flow, 0, grid.n[0] - 1);
    printf("  %6d  %8.1e   %8.1e   %8.1e   %6d   %8.0f\n", across, sqrt(error / size),
           worst / fabs(slope * (gd.hi[0] - gd.lo[0])), fabs(out / in - 1.0), result.newton,
           (double)result.evaluations);
    pd_steady_free(&ctx, &steady);
    pd_flow_free(&ctx, &flow);
    pd_bonds_free(&ctx, &bonds);
    pd_grid_free(&ctx, &grid);
    pd_stencil_free(&ctx, &stencil);
}

int main(void)
{
    pd_ctx_init(&ctx);
    printf("flow between plates, Re = %g\n  across   velocity   pressure   flux        Newton   evaluations\n",
           MEAN * 2.0 * HALF * RHO / MU);
    for (int across = 8; across <= 32; across *= 2) solve(across);
    return 0;
}
