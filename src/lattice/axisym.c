/* axisym: see axisym.h
 *
 * Radii are in cells here: row i from the axis has rho_i = i + 1/2, a bond the mean rho = (rho_i + rho_j)/2.
 */
#include "lattice/axisym.h"
#include "core/array_registry.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Largest number of Newton steps for the conductances near the axis. */
#define PDI_AXISYM_MAX_STEPS 60
/* [-] Residual of the moment conditions (1.6) that is rounding: the iteration ends. */
#define PDI_AXISYM_TOLERANCE 4e-16
/* [-] Residual of the moment conditions that has to be reached. */
#define PDI_AXISYM_REQUIRED 1e-12
/* [-] A pivot below this fraction of the largest one is zero: the conditions near the axis depend on each other, since
 * the total radial flux follows from them twice. */
#define PDI_AXISYM_MIN_PIVOT 1e-9

/* The fit of one set of weights w(n): multipliers of the two conditions at each of the rows next to the axis. */
typedef struct pdi_axisym_fit {
    const pd_stencil *stencil;
    const double *weight;      /* [count] */
    double scale[PD_DIM];      /* of the weights: sum scale_a w n_a^2 = 1 over a full family */
    double kappa;              /* [cells2] kappa of eq. 1.7 */
    /* [cells], [cells2] bonds of at least this mean radius have the kappa of eq. 1.9 */
    double radius_far, kappa_far;
    double first_radius;       /* [cells] radius of the first row of the box; 0.5: at the axis */
    int32_t rows;              /* rows from the axis on with fitted conductances; 0: the axis is not within reach */
    double *lambda, *mu;       /* [rows] Lagrange multipliers lambda and mu of eq. 1.8 */
    double *matrix, *residual, *x; /* [2 rows][2 rows], [2 rows], [2 rows] Jacobian, residual and Newton step */
    int *row_pivot, *column_pivot; /* [2 rows] permutations of the pivoting */
} pdi_axisym_fit;

/* Axial (radial 0) or radial (radial 1) offset of bond k [cells]. */
static int pdi_axisym_get_offset(const pd_stencil *s, int k, int radial)
{
    return s->offset[k * PD_DIM + (radial ? PD_DIM - 1 : 0)];
}

/* Conductance [cells] of bond k of row i (0: first row of the box, < 0: ghosts) over its planar weight: the mean radius
 * times the exponential of eq. 1.8 when both ends are in the rows 0 .. fit->rows-1. Else the mean radius, for purely
 * radial bonds less kappa over it (eq. 1.7; kappa_far where the mean radius is at least radius_far). 0: an end lies at
 * r <= 0. */
static double pdi_axisym_compute_conductance(const pdi_axisym_fit *fit, int i, int k)
{
    int axial = pdi_axisym_get_offset(fit->stencil, k, 0), j = i + pdi_axisym_get_offset(fit->stencil, k, 1);
    double from = fit->first_radius + i, to = fit->first_radius + j, rho = 0.5 * (from + to);
    if (!(from > 0.0) || !(to > 0.0)) return 0.0;
    int fitted = i >= 0 && j >= 0 && i < fit->rows && j < fit->rows; /* ghosts inside of a hollow box are not */
    if (!fitted && axial) return rho;
    if (!fitted) return rho - (rho >= fit->radius_far ? fit->kappa_far : fit->kappa) / rho;
    double square = (double)axial * axial;
    return rho * exp(square * (fit->lambda[i] + fit->lambda[j]) + (to * to - from * from) * (fit->mu[i] - fit->mu[j]));
}

/* Solves matrix x = residual of the fit by Gauss elimination with complete pivoting; matrix, residual and the pivots
 * are overwritten. Elimination ends at a pivot of at most PDI_AXISYM_MIN_PIVOT times the largest one (conditions that
 * depend on each other): the remaining unknowns are 0. */
static void pdi_axisym_solve_newton_step(pdi_axisym_fit *fit)
{
    int n = 2 * fit->rows, rank = 0;
    double largest = 0.0, *a = fit->matrix, *b = fit->residual;
    for (int k = 0; k < n; k++) fit->row_pivot[k] = fit->column_pivot[k] = k;
    for (; rank < n; rank++) {
        int row = rank, column = rank;
        for (int r = rank; r < n; r++)
            for (int c = rank; c < n; c++)
                if (fabs(a[fit->row_pivot[r] * n + fit->column_pivot[c]]) >
                    fabs(a[fit->row_pivot[row] * n + fit->column_pivot[column]])) {
                    row = r;
                    column = c;
                }
        double pivot = a[fit->row_pivot[row] * n + fit->column_pivot[column]];
        largest = pd_max(largest, fabs(pivot));
        if (!(fabs(pivot) > PDI_AXISYM_MIN_PIVOT * largest)) break;
        int swap = fit->row_pivot[rank];
        fit->row_pivot[rank] = fit->row_pivot[row];
        fit->row_pivot[row] = swap;
        swap = fit->column_pivot[rank];
        fit->column_pivot[rank] = fit->column_pivot[column];
        fit->column_pivot[column] = swap;
        for (int r = rank + 1; r < n; r++) {
            double factor = a[fit->row_pivot[r] * n + fit->column_pivot[rank]] / pivot;
            for (int c = rank; c < n; c++)
                a[fit->row_pivot[r] * n + fit->column_pivot[c]] -=
                    factor * a[fit->row_pivot[rank] * n + fit->column_pivot[c]];
            b[fit->row_pivot[r]] -= factor * b[fit->row_pivot[rank]];
        }
    }
    for (int k = 0; k < n; k++) fit->x[k] = 0.0;
    for (int k = rank - 1; k >= 0; k--) {
        double sum = b[fit->row_pivot[k]];
        for (int c = k + 1; c < rank; c++)
            sum -= a[fit->row_pivot[k] * n + fit->column_pivot[c]] * fit->x[fit->column_pivot[c]];
        fit->x[fit->column_pivot[k]] = sum / a[fit->row_pivot[k] * n + fit->column_pivot[k]];
    }
}

/* Sets residual [2 rows] = 1 - moments over their wanted values (1.6; axial, radial condition of each fitted row) and
 * matrix = derivatives of these moments by lambda and mu of each row. Bonds to rows that are not fitted count in the
 * moments and have no derivative. Returns the largest |residual| [-]; 0: no rows. */
static double pdi_axisym_assemble_conditions(pdi_axisym_fit *fit)
{
    const pd_stencil *s = fit->stencil;
    int n = 2 * fit->rows;
    double largest = 0.0;
    for (int k = 0; k < n * n; k++) fit->matrix[k] = 0.0;
    for (int i = 0; i < fit->rows; i++) {
        double rho = fit->first_radius + i, *lack = fit->residual + 2 * i;
        lack[0] = lack[1] = 1.0;
        for (int k = 0; k < s->count; k++) {
            int j = i + pdi_axisym_get_offset(s, k, 1);
            double c = fit->weight[k] * pdi_axisym_compute_conductance(fit, i, k), to = fit->first_radius + j, part[2];
            double square = (double)pdi_axisym_get_offset(s, k, 0) * pdi_axisym_get_offset(s, k, 0),
                   step = to * to - rho * rho;
            part[0] = fit->scale[0] * c * square / rho;
            part[1] = fit->scale[PD_DIM - 1] * c * step / (2.0 * rho);
            for (int e = 0; e < 2; e++) {
                double *row = fit->matrix + (int64_t)(2 * i + e) * n;
                lack[e] -= part[e];
                if (j < 0 || j >= fit->rows) continue;
                row[2 * i] += part[e] * square;
                row[2 * j] += part[e] * square;
                row[2 * i + 1] += part[e] * step;
                row[2 * j + 1] -= part[e] * step;
            }
        }
        largest = pd_max(largest, pd_max(fabs(lack[0]), fabs(lack[1])));
    }
    return largest;
}

/* Newton's method for lambda and mu of the fit, from the values that they have. Ends when the largest residual is at
 * most PDI_AXISYM_TOLERANCE, or at most PDI_AXISYM_REQUIRED and not below half of the best one before. PD_ERR_GEOMETRY:
 * not so within PDI_AXISYM_MAX_STEPS steps. Without fitted rows PD_OK at once. */
static pd_status pdi_axisym_solve_multipliers(pd_ctx *ctx, pdi_axisym_fit *fit)
{
    double best = HUGE_VAL;
    for (int step = 0; step < PDI_AXISYM_MAX_STEPS; step++) {
        double error = pdi_axisym_assemble_conditions(fit);
        if (error <= PDI_AXISYM_TOLERANCE || (error <= PDI_AXISYM_REQUIRED && !(error < 0.5 * best))) return PD_OK;
        best = pd_min(best, error);
        pdi_axisym_solve_newton_step(fit);
        for (int i = 0; i < fit->rows; i++) {
            fit->lambda[i] += fit->x[2 * i];
            fit->mu[i] += fit->x[2 * i + 1];
        }
    }
    return pd_fail(ctx, PD_ERR_GEOMETRY, "axisym", "the weights at the axis miss their conditions by %g", best);
}

/* Number of rows to fit, from the axis on: at least the reach of the stencil (these lack bonds across the axis), and so
 * many that kappa is at most half of the squared mean radius on all bonds of other rows. 0: the box does not begin at
 * the axis. */
static int pdi_axisym_count_fitted_rows(const pdi_axisym_fit *fit)
{
    int reach = fit->stencil->reach, rows = reach;
    if (fit->first_radius > 0.5) return 0;
    for (;; rows++) {
        double innermost = rows + 0.5 - 0.5 * reach;
        if (innermost * innermost >= 2.0 * fit->kappa) return rows;
    }
}

/* Number of rows of the box without fluid in front of the first row with fluid, counted from the inner side; all rows
 * when there is no fluid. */
static int pdi_axisym_count_rows_without_fluid(const pd_grid *grid)
{
    int innermost = grid->n[PD_DIM - 1];
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID) continue;
        pd_grid_index(grid, node, i);
        innermost = i[PD_DIM - 1] < innermost ? i[PD_DIM - 1] : innermost;
    }
    return innermost;
}

/* Mean radius [cells] from which conductances use the kappa of eq. 1.9: that of the innermost bond of the innermost
 * row with fluid. HUGE_VAL (nowhere): bonds of such rows reach fitted ones, that radius is not positive, or its square
 * is below 2 kappa_far (such bonds would lose more than half of their conductance). */
static double pdi_axisym_find_far_radius(const pdi_axisym_fit *fit, const pd_grid *grid)
{
    int empty = pdi_axisym_count_rows_without_fluid(grid);
    double beyond = fit->first_radius + empty - 0.5 * fit->stencil->reach;
    if (empty < fit->rows + fit->stencil->reach || !(beyond > 0.0) || beyond * beyond < 2.0 * fit->kappa_far)
        return HUGE_VAL;
    return beyond;
}

/* Describes the arrays of the fit to the array registry. */
static void pdi_axisym_list_fit_arrays(pdi_array_visitor *owner, void *object)
{
    pdi_axisym_fit *fit = (pdi_axisym_fit *)object;
    int64_t n = 2 * (int64_t)fit->rows;
    PDI_ARRAY(owner, fit, lambda, fit->rows, "1");
    PDI_ARRAY(owner, fit, mu, fit->rows, "1");
    PDI_ARRAY(owner, fit, matrix, n * n, "1");
    PDI_ARRAY(owner, fit, residual, n, "1");
    PDI_ARRAY(owner, fit, x, n, "1");
    PDI_ARRAY(owner, fit, row_pivot, n, "1");
    PDI_ARRAY(owner, fit, column_pivot, n, "1");
}

/* Fits the conductances to the planar weights weight [count] and stores table [rows, ghosts included][count] = unit
 * [count] (NULL: 1) times c_ij over the radius of the row, both in cells; 0 in rows at r <= 0 and for bonds across the
 * axis. With unit NULL no bond has the kappa of eq. 1.9. Overwrites all members of the fit but stencil and
 * first_radius; the caller frees its arrays. PD_ERR_GEOMETRY: the fit does not converge. */
static pd_status pdi_axisym_compute_table(pd_ctx *ctx, pdi_axisym_fit *fit, const pd_grid *grid, const double *weight,
                                          const double *unit, double *table)
{
    const pd_stencil *s = fit->stencil;
    double moment[2] = {0.0, 0.0}, curl = 0.0, bend = 0.0, straight = 0.0;
    fit->weight = weight;
    for (int k = 0; k < s->count; k++) {
        double axial = pdi_axisym_get_offset(s, k, 0), radial = pdi_axisym_get_offset(s, k, 1),
               square = radial * radial;
        moment[0] += weight[k] * axial * axial;
        moment[1] += weight[k] * square;
        curl += weight[k] * square * (square - 1.0) / 12.0;
        bend += weight[k] * square * square / 12.0;
        if (!(fabs(axial) > 0.0)) straight += weight[k] * square;
    }
    fit->scale[0] = 1.0 / moment[0];
    fit->scale[PD_DIM - 1] = 1.0 / moment[1];
    fit->kappa = curl > 0.0 ? curl / straight : 0.0;
    fit->kappa_far = bend / straight;
    PD_TRY(pdi_array_registry_rebuild(ctx, pdi_axisym_list_fit_arrays, fit, &fit->rows,
                                      pdi_axisym_count_fitted_rows(fit)));
    fit->radius_far = unit ? pdi_axisym_find_far_radius(fit, grid) : HUGE_VAL;
    PD_TRY(pdi_axisym_solve_multipliers(ctx, fit));
    for (int row = 0; row < grid->padded[PD_DIM - 1]; row++)
        for (int k = 0; k < s->count; k++) {
            double rho = fit->first_radius + (row - grid->ghost),
                   c = pdi_axisym_compute_conductance(fit, row - grid->ghost, k);
            table[(int64_t)row * s->count + k] = rho > 0.0 ? (unit ? unit[k] : 1.0) * c / rho : 0.0;
        }
    return PD_OK;
}

/* Sets axisym->hoop: sum of laplacian_weight times the radial offset, over the radius (eq. 1.10); 0 in rows at r <= 0.
 */
static void pdi_axisym_compute_hoop(const pd_stencil *s, const pdi_axisym_fit *fit, const pd_grid *grid,
                                    pd_axisym *axisym)
{
    for (int row = 0; row < axisym->rows; row++) {
        double rho = fit->first_radius + (row - grid->ghost), sum = 0.0;
        for (int k = 0; k < s->count; k++)
            sum += axisym->laplacian_weight[(int64_t)row * s->count + k] * pdi_axisym_get_offset(s, k, 1);
        axisym->hoop[row] = rho > 0.0 ? sum / rho : 0.0;
    }
}

/* Describes the arrays of pd_axisym to the array registry. */
static void pdi_axisym_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_axisym *ring = (pd_axisym *)object;
    PDI_ARRAY(owner, ring, laplacian_weight, (int64_t)ring->rows * ring->count, "1/m2");
    PDI_ARRAY(owner, ring, flux_factor, (int64_t)ring->rows * ring->count, "1");
    PDI_ARRAY(owner, ring, hoop, ring->rows, "1/m2");
}

/* Allocates and computes laplacian_weight, flux_factor and hoop. The caller frees the arrays of `fit` and, on failure,
 * those of `axisym`. */
static pd_status pdi_axisym_compute_weights(pd_ctx *ctx, const pd_stencil *s, const pd_grid *grid, pdi_axisym_fit *fit,
                                            pd_axisym *axisym)
{
    PD_TRY(pdi_array_registry_build(ctx, pdi_axisym_list_arrays, axisym));
    PD_TRY(
        pdi_axisym_compute_table(ctx, fit, grid, s->laplacian_weight, s->laplacian_weight, axisym->laplacian_weight));
    PD_TRY(pdi_axisym_compute_table(ctx, fit, grid, s->base_weight, NULL, axisym->flux_factor));
    pdi_axisym_compute_hoop(s, fit, grid, axisym);
    return PD_OK;
}

/* Does the work of pdi_axisym_build; on failure the caller frees what `axisym` holds. All of `axisym` is zero, with
 * PD_OK, on a planar grid. A first row less than one cell from the axis counts as the row at the axis. */
static pd_status pdi_axisym_build_inner(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_axisym *axisym)
{
    pdi_axisym_fit fit;
    memset(axisym, 0, sizeof *axisym);
    memset(&fit, 0, sizeof fit);
    if (PD_DIM != 2 || !grid->circumference) return PD_OK;
    axisym->rows = grid->padded[PD_DIM - 1];
    axisym->count = stencil->count;
    fit.stencil = stencil;
    fit.first_radius = grid->circumference[grid->ghost] / (2.0 * PD_PI * grid->h[PD_DIM - 1]);
    if (fit.first_radius < 1.0) fit.first_radius = 0.5; /* at the axis, but for rounding */
    pd_status status = pdi_axisym_compute_weights(ctx, stencil, grid, &fit, axisym);
    pdi_array_registry_free(ctx, pdi_axisym_list_fit_arrays, &fit);
    return status;
}

PDI_FN pd_status pdi_axisym_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_axisym *axisym)
{
    pd_status status = pdi_axisym_build_inner(ctx, stencil, grid, axisym);
    if (status < 0) pdi_axisym_free(ctx, axisym);
    return status;
}

PDI_FN void pdi_axisym_free(pd_ctx *ctx, pd_axisym *axisym)
{
    pdi_array_registry_free(ctx, pdi_axisym_list_arrays, axisym);
    memset(axisym, 0, sizeof *axisym);
}
