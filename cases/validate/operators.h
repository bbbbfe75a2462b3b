/* operators: cases about the bond weights and the peridynamic operators. */
#ifndef VAL_OPERATORS_H
#define VAL_OPERATORS_H

/* ---- patch: gradient, divergence and Laplacian of all monomials of degree 1 and 2 ---- */

/* Monomial x_a (b < 0) or x_a x_b at x; its gradient into g; returns the value. */
static double patch_monomial(int a, int b, const double *x, double *g)
{
    for (int d = 0; d < PD_DIM; d++) g[d] = 0.0;
    g[a] = b < 0 ? 1.0 : x[b];
    if (b < 0) return x[a];
    g[b] += x[a];
    return x[a] * x[b];
}

/* Errors of one monomial over all nodes with whole families: of the gradient relative to its largest length, of the
 * Laplacian relative to the size of the second derivatives (for a linear field: of the slope over the box), and of the
 * divergence of the field that has the monomial as component `axis`, for every axis. */
static void patch_errors(val_job *job, int a, int b, double *err)
{
    val_lab *lab = job->lab;
    double *f = lab->field[0], *grad = lab->field[1], *lap = lab->field[2], x[PD_DIM], g[PD_DIM];
    const pd_grid *grid = &lab->grid;
    double off[3] = {0.0, 0.0, 0.0}, largest = 0.0, extent = 0.0, exact = a == b ? 2.0 : 0.0;
    for (int32_t i = 0; i < grid->total; i++) {
        pd_grid_position(grid, i, x);
        f[i] = patch_monomial(a, b, x, g);
    }
    pd_op_gradient(job->ctx, &lab->bonds, f, grad);
    pd_op_laplacian(job->ctx, &lab->bonds, f, lap);
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_FLUID || lab->bonds.row_of_node[i] >= 0) continue;
        pd_grid_position(grid, i, x);
        patch_monomial(a, b, x, g);
        largest = fmax(largest, pdi_vec_norm(g));
        for (int d = 0; d < PD_DIM; d++)
            off[0] = fmax(off[0], fabs(grad[(int64_t)d * grid->total + i] - g[d]));
        off[2] = fmax(off[2], fabs(lap[i] - exact));
    }
    for (int axis = 0; axis < PD_DIM; axis++) {
        double *u = lab->field[3];
        extent = fmax(extent, grid->hi[axis] - grid->lo[axis]);
        for (int64_t k = 0; k < (int64_t)PD_DIM * grid->total; k++) u[k] = 0.0;
        for (int32_t i = 0; i < grid->total; i++) u[(int64_t)axis * grid->total + i] = f[i];
        pd_op_divergence(job->ctx, &lab->bonds, u, lap);
        for (int32_t i = 0; i < grid->total; i++) {
            if (grid->kind[i] != PD_FLUID || lab->bonds.row_of_node[i] >= 0) continue;
            pd_grid_position(grid, i, x);
            patch_monomial(a, b, x, g);
            off[1] = fmax(off[1], fabs(lap[i] - g[axis]));
        }
    }
    err[0] = fmax(err[0], off[0] / largest);
    err[1] = fmax(err[1], off[1] / largest);
    err[2] = fmax(err[2], off[2] / (b < 0 ? 1.0 / extent : a == b ? 2.0 : 1.0));
}

/* Spacings: p cells along x, sqrt(p) along y of three axes, 1 along the last one. A cell is a power of two, so that
 * positions and their products are exact and what is left is the rounding of weights and sums. */
static pd_status patch_run(val_job *job)
{
    val_lab *lab = job->lab;
    double m = job->level.m, cell = 1.0 / 1048576.0; /* [m] */
    int half = (int)ceil(m + 0.5) + 2;
    lab_box(lab, cell, m, -half * cell, half * cell);
    if (PD_DIM > 1) lab->stencil_desc.h[0] = job->level.p * cell;
    if (PD_DIM > 2) lab->stencil_desc.h[1] = sqrt(job->level.p) * cell;
    for (int d = 0; d < PD_DIM; d++) {
        lab->grid_desc.lo[d] = -half * lab->stencil_desc.h[d];
        lab->grid_desc.hi[d] = half * lab->stencil_desc.h[d];
    }
    PD_TRY(lab_build(job->ctx, lab, VAL_LATTICE));
    PD_TRY(lab_fields(job->ctx, lab, 4, PD_DIM));
    job->out->h = lab->grid.h[0];
    for (int a = 0; a < PD_DIM; a++)
        for (int b = -1; b <= a; b++) patch_errors(job, a, b, job->out->err);
    return PD_OK;
}

#define PATCH_MEASURES \
    {{"err_gradient", "gradient"}, {"err_divergence", "divergence"}, {"err_laplacian", "Laplacian"}}, 3
#define PATCH_GOALS {{0, 1e-12, 0.0, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL}}, 3
#define PATCH_LEVELS(ratio) \
    {{2, 2.0, ratio}, {3, 3.0, ratio}, {4, 4.0, ratio}, {5, 5.0, ratio}, {6, 6.0, ratio}}, 5, PD_DIM == 3 ? 2 : 5

static const val_part patch_equal = {
    "1", "equal spacings", "m", VAL_BY_M, "m", 0.0, PATCH_MEASURES, PATCH_GOALS, PATCH_LEVELS(1.0), patch_run, NULL};
#if PD_DIM > 1
static const val_part patch_10 = {"10", "spacings 10 to 1", "m", VAL_BY_M, "m", 0.0, PATCH_MEASURES, PATCH_GOALS,
                                  PATCH_LEVELS(10.0), patch_run, NULL};
static const val_part patch_100 = {"100", "spacings 100 to 1", "m", VAL_BY_M, "m", 0.0, PATCH_MEASURES, PATCH_GOALS,
                                   PATCH_LEVELS(100.0), patch_run, NULL};
static const val_part *const patch_parts[] = {&patch_equal, &patch_10, &patch_100};
#else
static const val_part *const patch_parts[] = {&patch_equal};
#endif

static const val_case patch_case = {
    "patch", "Patch test of the operators",
    "Gradient, divergence and Laplacian of all monomials of first and second degree at nodes with whole families.",
    "Uncalibrated horizon sums (about 3 % low in 2D at m = 3), wrong powers of h, weights that follow only one of the "
    "spacings.",
    "closed form",
    patch_parts, (int)(sizeof patch_parts / sizeof patch_parts[0])};

#endif
