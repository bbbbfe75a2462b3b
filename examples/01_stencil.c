/* 01: calibrated bond weights and the patch test.
 *
 * Prints what the continuum coefficients make of x^2 on a lattice, and the errors of the calibrated operators on
 * polynomials (theory: chapter 1). Runs in 1D, 2D and 3D:
 *   cc -std=c99 -O2 -I. -DPD_DIM=3 examples/01_stencil.c -o 01_stencil -lm
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

static pd_ctx ctx;

static void must(pd_status status)
{
    if (status == PD_OK) return;
    fprintf(stderr, "%s: %s\n", pd_status_name(status), ctx.message);
    exit(1);
}

/* Second moment of the Laplacian weights along one axis over 2: the factor by which x^2 comes out wrong. */
static double second_moment(double m, double ratio, pd_weights weights, int axis, int *bonds)
{
    pd_stencil_desc desc;
    pd_stencil s;
    double sum = 0.0;
    memset(&desc, 0, sizeof desc);
    desc.m = m;
    desc.weights = weights;
    for (int d = 0; d < PD_DIM; d++) desc.h[d] = d ? 1e-6 / ratio : 1e-6;
    must(pd_stencil_build(&ctx, &desc, &s));
    for (int k = 0; k < s.count; k++)
        sum += 0.5 * s.laplacian_weight[k] * s.xi[k * PD_DIM + axis] * s.xi[k * PD_DIM + axis];
    *bonds = s.count;
    pd_stencil_free(&ctx, &s);
    return sum;
}

static void print_moments(void)
{
    static const double ratios[] = {1.0, 25.0};
    int bonds, last = PD_DIM - 1;
    printf("Laplacian of x^2 over its true value\n"
           "  m  bonds  hx/hy   printed x  printed %c   calibrated x - 1  calibrated %c - 1\n",
           "xyz"[last], "xyz"[last]);
    for (int r = 0; r < (PD_DIM > 1 ? 2 : 1); r++)
        for (int m = 2; m <= 4; m++) {
            double x = second_moment(m, ratios[r], PD_WEIGHTS_PUBLISHED, 0, &bonds);
            double y = second_moment(m, ratios[r], PD_WEIGHTS_PUBLISHED, last, &bonds);
            double cx = second_moment(m, ratios[r], PD_WEIGHTS_CALIBRATED, 0, &bonds) - 1.0;
            double cy = second_moment(m, ratios[r], PD_WEIGHTS_CALIBRATED, last, &bonds) - 1.0;
            printf("  %d  %5d  %5g   %9.5f  %9.5f   %16.1e  %16.1e\n", m, bonds, ratios[r], x, y, cx, cy);
        }
}

/* Polynomials with their gradients and Laplacians; x and y = the last axis, in units of one cell. */
static double poly(int k, double x, double y, double *gx, double *lap)
{
    switch (k) {
    case 0: *gx = 1.0; *lap = 0.0; return 1.0 + x - 2.0 * y;
    case 1: *gx = 2.0 * x; *lap = 2.0; return x * x;
    case 2: *gx = y; *lap = PD_DIM > 1 ? 0.0 : 2.0; return PD_DIM > 1 ? x * y : x * x;
    case 3: *gx = 3.0 * x * x; *lap = 6.0 * x; return x * x * x;
    default: *gx = 4.0 * x * x * x; *lap = 12.0 * x * x; return x * x * x * x;
    }
}

int main(void)
{
    static const char *const names[] = {"1 + x - 2y", "x^2", "x y", "x^3", "x^4"};
    pd_lattice_desc desc;
    pd_lattice lattice;
    double *f, *lap, *grad;
    pd_ctx_init(&ctx);
    print_moments();

    /* a box of 16 cells of size 1; nodes at least four cells away from the sides have whole families */
    memset(&desc, 0, sizeof desc);
    for (int d = 0; d < PD_DIM; d++) {
        desc.stencil.h[d] = 1.0;
        desc.grid.lo[d] = -8.0;
        desc.grid.hi[d] = 8.0;
    }
    must(pd_lattice_build(&ctx, &desc, &lattice));
    must(pd_lattice_add_field(&ctx, &lattice, 1, &f));
    must(pd_lattice_add_field(&ctx, &lattice, 1, &lap));
    must(pd_lattice_add_field(&ctx, &lattice, PD_DIM, &grad));
    const pd_grid *grid = &lattice.grid;

    printf("\npatch test, m = %g: largest error at nodes with whole families\n"
           "  field         d/dx       Laplacian\n", lattice.stencil.m);
    for (int k = PD_DIM > 1 ? 0 : 1; k < 5; k++) {
        double worst_gradient = 0.0, worst_laplacian = 0.0, gx, l, x[PD_DIM];
        for (int32_t i = 0; i < grid->total; i++) {
            pd_grid_position(grid, i, x);
            f[i] = poly(k, x[0], x[PD_DIM - 1], &gx, &l);
        }
        pd_op_gradient(&ctx, &lattice.bonds, f, grad);
        pd_op_laplacian(&ctx, &lattice.bonds, f, lap);
        for (int32_t i = 0; i < grid->total; i++) {
            if (grid->kind[i] != PD_FLUID || lattice.bonds.row_of_node[i] >= 0) continue;
            pd_grid_position(grid, i, x);
            poly(k, x[0], x[PD_DIM - 1], &gx, &l);
            worst_gradient = fmax(worst_gradient, fabs(grad[i] - gx));
            worst_laplacian = fmax(worst_laplacian, fabs(lap[i] - l));
        }
        printf("  %-12s  %8.1e   %8.1e\n", names[k], worst_gradient, worst_laplacian);
    }
    pd_lattice_free(&ctx, &lattice);
    return 0;
}
