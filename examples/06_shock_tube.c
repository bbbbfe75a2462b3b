/* 06: Sod's shock tube.
 *
 * A membrane between gas at 1 and at 0.1 breaks: a rarefaction runs to the left, a contact and a shock to the right.
 * Ideal gas on bonds (theory: chapter 4) against the exact solution of the Riemann problem, on four grids; the last
 * one is drawn into out/.
 *   cc -std=c99 -O2 -I. examples/06_shock_tube.c -o 06_shock_tube -lm
 */
#define PD_DIM 1
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr_app.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GAMMA 1.4
#define END 0.2 /* [s] */
#define MOST 800

static const double RHO[2] = {1.0, 0.125}, P[2] = {1.0, 0.1}; /* [kg/m3], [Pa] left and right of x = 1/2 m */

static pd_ctx ctx;

static void must(pd_status status)
{
    if (status == PD_OK) return;
    fprintf(stderr, "%s: %s\n", pd_status_name(status), ctx.message);
    exit(1);
}

static void membrane(void *user, const double *x, double *rho, double *v, double *p)
{
    int right = x[0] > 0.5;
    (void)user;
    *rho = RHO[right];
    v[0] = 0.0;
    *p = P[right];
}

/* Velocity behind the rarefaction on the left and behind the shock on the right, for a pressure p between them. */
static double behind_rarefaction(double p)
{
    return 2.0 * sqrt(GAMMA * P[0] / RHO[0]) / (GAMMA - 1.0) * (1.0 - pow(p / P[0], 0.5 * (GAMMA - 1.0) / GAMMA));
}

static double behind_shock(double p)
{
    return (p - P[1]) * sqrt(2.0 / (RHO[1] * ((GAMMA + 1.0) * p + (GAMMA - 1.0) * P[1])));
}

/* Exact density on the ray x - 1/2 = speed * time. */
static double exact(double speed)
{
    static double p;
    double low = P[1], high = P[0], z = (GAMMA - 1.0) / (GAMMA + 1.0), c = sqrt(GAMMA * P[0] / RHO[0]);
    for (int k = 0; k < 60 && p <= 0.0; k++) {
        double middle = 0.5 * (low + high);
        if (behind_rarefaction(middle) > behind_shock(middle)) low = middle;
        else high = middle;
        if (k == 59) p = middle;
    }
    double u = behind_shock(p), tail = u - c * pow(p / P[0], 0.5 * (GAMMA - 1.0) / GAMMA), ratio = p / P[1];
    double shock = sqrt(GAMMA * P[1] / RHO[1] * 0.5 * ((GAMMA + 1.0) * ratio + GAMMA - 1.0) / GAMMA);
    if (speed < -c) return RHO[0];
    if (speed < tail) return RHO[0] * pow((2.0 - (GAMMA - 1.0) * speed / c) / (GAMMA + 1.0), 2.0 / (GAMMA - 1.0));
    if (speed < u) return RHO[0] * pow(p / P[0], 1.0 / GAMMA);
    return speed < shock ? RHO[1] * (ratio + z) / (z * ratio + 1.0) : RHO[1];
}

/* Places, densities and exact densities of a run with `cells` nodes. Returns the mean error of the density [kg/m3]. */
static double solve(int cells, double m, double *x, double *rho, double *right)
{
    pd_stencil_desc sd;
    pd_grid_desc gd;
    pd_gas_desc ad;
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_gas gas;
    double error = 0.0;
    int count = 0;
    memset(&sd, 0, sizeof sd);
    memset(&gd, 0, sizeof gd);
    memset(&ad, 0, sizeof ad);
    sd.m = m;
    sd.h[0] = 1.0 / cells;
    gd.hi[0] = 1.0;
    gd.side[0] = gd.side[1] = PD_SIDE_MIRROR;
    ad.gamma = GAMMA;
    ad.initial = membrane;
    must(pd_stencil_build(&ctx, &sd, &stencil));
    must(pd_grid_build(&ctx, &stencil, &gd, &grid));
    must(pd_bonds_build(&ctx, &stencil, &grid, 0, &bonds));
    must(pd_gas_build(&ctx, &grid, &bonds, &ad, &gas));
    must(pd_physics_run(&ctx, pd_gas_process(&gas), END));
    for (int32_t i = 0; i < grid.total; i++) {
        if (grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&grid, i, &x[count]);
        rho[count] = gas.primitive[i];
        right[count] = exact((x[count] - 0.5) / END);
        error += fabs(rho[count] - right[count]) / cells;
        count++;
    }
    printf("  %5d  %3g   %10.3e   %5d\n", cells, m, error, (int)gas.steps);
    pd_gas_free(&ctx, &gas);
    pd_bonds_free(&ctx, &bonds);
    pd_grid_free(&ctx, &grid);
    pd_stencil_free(&ctx, &stencil);
    return error;
}

int main(void)
{
    static double x[MOST], rho[MOST], right[MOST];
    double error = 0.0;
    pd_plot plot;
    pd_ctx_init(&ctx);
    printf("shock tube, t = %g s\n  nodes    m   error of rho   steps\n", END);
    for (int m = 1; m <= 3; m += 2)
        for (int cells = MOST / 8; cells <= MOST; cells *= 2) error = solve(cells, m, x, rho, right);
    memset(&plot, 0, sizeof plot);
    plot.title = "Sod's shock tube, m = 3";
    plot.x_label = "x [m]";
    plot.y_label = "density [kg/m3]";
    plot.count = 2;
    plot.series[0].name = "exact";
    plot.series[1].name = "nodes";
    plot.series[0].y = right;
    plot.series[1].y = rho;
    plot.series[1].stroke = PD_SERIES_STYLE_DASHED;
    for (int k = 0; k < 2; k++) {
        plot.series[k].x = x;
        plot.series[k].count = MOST;
    }
    must(pd_file_make_directory(&ctx, "out"));
    must(pd_plot_write(&ctx, "out/06_shock_tube.png", &plot));
    printf("drawn: out/06_shock_tube.png\n");
    return error < 5e-3 ? 0 : 1;
}
