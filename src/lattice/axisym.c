/* axisym: see axisym.h
 *
 * Radii are in cells here: row i from the axis has rho_i = i + 1/2, a bond the mean rho = (rho_i + rho_j)/2.
 */
#include "lattice/axisym.h"
#include "core/owner.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Largest number of Newton steps for the conductances near the axis. */
#define PDI_AXISYM_STEPS 60
/* [-] Residual of the moment conditions (3.7) that is rounding: the iteration ends. */
#define PDI_AXISYM_TOLERANCE 4e-16
/* [-] Residual of the moment conditions that has to be reached. */
#define PDI_AXISYM_EXACT 1e-12
/* [-] A pivot below this fraction of the largest one is zero: the conditions near the axis depend on each other, since
 * the total radial flux follows from them twice. */
#define PDI_AXISYM_PIVOT 1e-9

/* The fit of one set of weights w(n): multipliers of the two conditions at each of the rows next to the axis. */
typedef struct pdi_axisym_fit {
    const pd_stencil *stencil;
    const double *weight;      /* [count] */
    double scale[PD_DIM];      /* of the weights: sum scale_a w n_a^2 = 1 over a full family */
    double excess;             /* [cells2] kappa of eq. 3.8 */
    double beyond, wire;       /* [cells], [cells2] bonds of at least this mean radius have the kappa of eq. 3.8b */
    double first;              /* [cells] radius of the first row of the box; 0.5: at the axis */
    int32_t rows;              /* rows from the axis on with fitted conductances; 0: the axis is not within reach */
    double *axial, *radial;    /* [rows] Lagrange multipliers lambda and mu of eq. 3.9 */
    double *matrix, *lack, *x; /* [2 rows][2 rows], [2 rows], [2 rows] Jacobian, residual and Newton step */
    int *row_of, *column_of;   /* [2 rows] permutations of the pivoting */
} pdi_axisym_fit;

/* Axial (radial 0) or radial (radial 1) offset of bond k [cells]. */
static int pdi_axisym_offset(const pd_stencil *s, int k, int radial)
{
    return s->offset[k * PD_DIM + (radial ? PD_DIM - 1 : 0)];
}

/* Conductance of bond k of row i over its planar weight, in cells: the mean radius times the exponential of eq. 3.9
 * in fitted rows, else less kappa over it (eq. 3.8); 0 across the axis. */
static double pdi_axisym_conductance(const pdi_axisym_fit *fit, int i, int k)
{
    int axial = pdi_axisym_offset(fit->stencil, k, 0), j = i + pdi_axisym_offset(fit->stencil, k, 1);
    double from = fit->first + i, to = fit->first + j, rho = 0.5 * (from + to);
    if (!(from > 0.0) || !(to > 0.0)) return 0.0;
    int fitted = i >= 0 && j >= 0 && i < fit->rows && j < fit->rows; /* ghosts inside of a hollow box are not */
    if (!fitted && axial) return rho;
    if (!fitted) return rho - (rho >= fit->beyond ? fit->wire : fit->excess) / rho;
    double square = (double)axial * axial;
    return rho * exp(square * (fit->axial[i] + fit->axial[j]) +
                     (to * to - from * from) * (fit->radial[i] - fit->radial[j]));
}

/* Solves for the Newton step by Gauss elimination with complete pivoting. Conditions that depend on each other leave
 * zero pivots: the corresponding unknowns are 0. */
static void pdi_axisym_solve(pdi_axisym_fit *fit)
{
    int n = 2 * fit->rows, rank = 0;
    double largest = 0.0, *a = fit->matrix, *b = fit->lack;
    for (int k = 0; k < n; k++) fit->row_of[k] = fit->column_of[k] = k;
    for (; rank < n; rank++) {
        int row = rank, column = rank;
        for (int r = rank; r < n; r++)
            for (int c = rank; c < n; c++)
                if (fabs(a[fit->row_of[r] * n + fit->column_of[c]]) >
                    fabs(a[fit->row_of[row] * n + fit->column_of[column]])) {
                    row = r;
                    column = c;
                }
        double pivot = a[fit->row_of[row] * n + fit->column_of[column]];
        largest = pdi_max(largest, fabs(pivot));
        if (!(fabs(pivot) > PDI_AXISYM_PIVOT * largest)) break;
        int swap = fit->row_of[rank];
        fit->row_of[rank] = fit->row_of[row];
        fit->row_of[row] = swap;
        swap = fit->column_of[rank];
        fit->column_of[rank] = fit->column_of[column];
        fit->column_of[column] = swap;
        for (int r = rank + 1; r < n; r++) {
            double factor = a[fit->row_of[r] * n + fit->column_of[rank]] / pivot;
            for (int c = rank; c < n; c++)
                a[fit->row_of[r] * n + fit->column_of[c]] -= factor * a[fit->row_of[rank] * n + fit->column_of[c]];
            b[fit->row_of[r]] -= factor * b[fit->row_of[rank]];
        }
    }
    for (int k = 0; k < n; k++) fit->x[k] = 0.0;
    for (int k = rank - 1; k >= 0; k--) {
        double sum = b[fit->row_of[k]];
        for (int c = k + 1; c < rank; c++) sum -= a[fit->row_of[k] * n + fit->column_of[c]] * fit->x[fit->column_of[c]];
        fit->x[fit->column_of[k]] = sum / a[fit->row_of[k] * n + fit->column_of[k]];
    }
}

/* Computes the relative residuals of the moment conditions (3.7) at all fitted rows and their Jacobian by the
 * multipliers. Returns the largest residual [-]. */
static double pdi_axisym_conditions(pdi_axisym_fit *fit)
{
    const pd_stencil *s = fit->stencil;
    int n = 2 * fit->rows;
    double largest = 0.0;
    for (int k = 0; k < n * n; k++) fit->matrix[k] = 0.0;
    for (int i = 0; i < fit->rows; i++) {
        double rho = fit->first + i, *lack = fit->lack + 2 * i;
        lack[0] = lack[1] = 1.0;
        for (int k = 0; k < s->count; k++) {
            int j = i + pdi_axisym_offset(s, k, 1);
            double c = fit->weight[k] * pdi_axisym_conductance(fit, i, k), to = fit->first + j, part[2];
            double square = (double)pdi_axisym_offset(s, k, 0) * pdi_axisym_offset(s, k, 0), step = to * to - rho * rho;
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
        largest = pdi_max(largest, pdi_max(fabs(lack[0]), fabs(lack[1])));
    }
    return largest;
}

/* Newton's method for the multipliers. PD_ERR_GEOMETRY: not converged. */
static pd_status pdi_axisym_newton(pd_ctx *ctx, pdi_axisym_fit *fit)
{
    double best = HUGE_VAL;
    for (int step = 0; step < PDI_AXISYM_STEPS; step++) {
        double error = pdi_axisym_conditions(fit);
        if (error <= PDI_AXISYM_TOLERANCE || (error <= PDI_AXISYM_EXACT && !(error < 0.5 * best))) return PD_OK;
        best = pdi_min(best, error);
        pdi_axisym_solve(fit);
        for (int i = 0; i < fit->rows; i++) {
            fit->axial[i] += fit->x[2 * i];
            fit->radial[i] += fit->x[2 * i + 1];
        }
    }
    return pdi_fail(ctx, PD_ERR_GEOMETRY, "ring", "the weights at the axis miss their conditions by %g", best);
}

/* Number of rows to fit: all that lack bonds across the axis, and so many that kappa is at most half of R^2 on all
 * other bonds. */
static int pdi_axisym_rows(const pdi_axisym_fit *fit)
{
    int reach = fit->stencil->reach, rows = reach;
    if (fit->first > 0.5) return 0;
    for (;; rows++) {
        double innermost = rows + 0.5 - 0.5 * reach;
        if (innermost * innermost >= 2.0 * fit->excess) return rows;
    }
}

/* Number of rows at the axis, or at the inner side of a hollow box, without fluid. */
static int pdi_axisym_dry(const pd_grid *grid)
{
    int innermost = grid->n[PD_DIM - 1];
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID) continue;
        pdi_grid_index(grid, node, i);
        innermost = i[PD_DIM - 1] < innermost ? i[PD_DIM - 1] : innermost;
    }
    return innermost;
}

/* Mean radius [cells] from which conductances use the kappa of eq. 3.8b: that of the innermost bond of the innermost
 * row with fluid. HUGE_VAL (nowhere) when bonds of such rows reach fitted ones or would lose more than half of their
 * conductance. */
static double pdi_axisym_beyond(const pdi_axisym_fit *fit, const pd_grid *grid)
{
    int empty = pdi_axisym_dry(grid);
    double beyond = fit->first + empty - 0.5 * fit->stencil->reach;
    if (empty < fit->rows + fit->stencil->reach || !(beyond > 0.0) || beyond * beyond < 2.0 * fit->wire)
        return HUGE_VAL;
    return beyond;
}

/* Describes the arrays of the fit to the array registry. */
static void pdi_axisym_fit_list(pdi_owner *owner, void *object)
{
    pdi_axisym_fit *fit = (pdi_axisym_fit *)object;
    int64_t n = 2 * (int64_t)fit->rows;
    PDI_ARRAY(owner, fit, axial, fit->rows, "1");
    PDI_ARRAY(owner, fit, radial, fit->rows, "1");
    PDI_ARRAY(owner, fit, matrix, n * n, "1");
    PDI_ARRAY(owner, fit, lack, n, "1");
    PDI_ARRAY(owner, fit, x, n, "1");
    PDI_ARRAY(owner, fit, row_of, n, "1");
    PDI_ARRAY(owner, fit, column_of, n, "1");
}

/* Fits the conductances to the planar weights weight [count] and stores table [rows][count] = unit [count] (NULL: 1)
 * times c_ij over the radius of the row. */
static pd_status pdi_axisym_table(pd_ctx *ctx, pdi_axisym_fit *fit, const pd_grid *grid, const double *weight,
                                const double *unit, double *table)
{
    const pd_stencil *s = fit->stencil;
    double moment[2] = {0.0, 0.0}, curl = 0.0, bend = 0.0, straight = 0.0;
    fit->weight = weight;
    for (int k = 0; k < s->count; k++) {
        double axial = pdi_axisym_offset(s, k, 0), radial = pdi_axisym_offset(s, k, 1), square = radial * radial;
        moment[0] += weight[k] * axial * axial;
        moment[1] += weight[k] * square;
        curl += weight[k] * square * (square - 1.0) / 12.0;
        bend += weight[k] * square * square / 12.0;
        if (!(fabs(axial) > 0.0)) straight += weight[k] * square;
    }
    fit->scale[0] = 1.0 / moment[0];
    fit->scale[PD_DIM - 1] = 1.0 / moment[1];
    fit->excess = curl > 0.0 ? curl / straight : 0.0;
    fit->wire = bend / straight;
    PDI_TRY(pdi_owner_renew(ctx, pdi_axisym_fit_list, fit, &fit->rows, pdi_axisym_rows(fit)));
    fit->beyond = unit ? pdi_axisym_beyond(fit, grid) : HUGE_VAL;
    PDI_TRY(pdi_axisym_newton(ctx, fit));
    for (int row = 0; row < grid->np[PD_DIM - 1]; row++)
        for (int k = 0; k < s->count; k++) {
            double rho = fit->first + (row - grid->ghost), c = pdi_axisym_conductance(fit, row - grid->ghost, k);
            table[(int64_t)row * s->count + k] = rho > 0.0 ? (unit ? unit[k] : 1.0) * c / rho : 0.0;
        }
    return PD_OK;
}

/* Computes hoop: sum of lap times the radial offset, over the radius (eq. 3.10). */
static void pdi_axisym_hoop(const pd_stencil *s, const pdi_axisym_fit *fit, const pd_grid *grid, pd_axisym *axisym)
{
    for (int row = 0; row < axisym->rows; row++) {
        double rho = fit->first + (row - grid->ghost), sum = 0.0;
        for (int k = 0; k < s->count; k++)
            sum += axisym->lap[(int64_t)row * s->count + k] * pdi_axisym_offset(s, k, 1);
        axisym->hoop[row] = rho > 0.0 ? sum / rho : 0.0;
    }
}

/* Describes the arrays of pd_axisym to the array registry. */
static void pdi_axisym_list(pdi_owner *owner, void *object)
{
    pd_axisym *ring = (pd_axisym *)object;
    PDI_ARRAY(owner, ring, lap, (int64_t)ring->rows * ring->count, "1/m2");
    PDI_ARRAY(owner, ring, flux, (int64_t)ring->rows * ring->count, "1");
    PDI_ARRAY(owner, ring, hoop, ring->rows, "1/m2");
}

/* Allocates and computes all weights: lap, flux, hoop. */
static pd_status pdi_axisym_fill(pd_ctx *ctx, const pd_stencil *s, const pd_grid *grid, pdi_axisym_fit *fit,
                                 pd_axisym *axisym)
{
    PDI_TRY(pdi_owner_build(ctx, pdi_axisym_list, axisym));
    PDI_TRY(pdi_axisym_table(ctx, fit, grid, s->lap, s->lap, axisym->lap));
    PDI_TRY(pdi_axisym_table(ctx, fit, grid, s->base, NULL, axisym->flux));
    pdi_axisym_hoop(s, fit, grid, axisym);
    return PD_OK;
}

/* Inner part of pdi_axisym_build: what it leaves behind on failure is freed by the caller. */
static pd_status pdi_axisym_make(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_axisym *axisym)
{
    pdi_axisym_fit fit;
    memset(axisym, 0, sizeof *axisym);
    memset(&fit, 0, sizeof fit);
    if (PD_DIM != 2 || !grid->circumference) return PD_OK;
    axisym->rows = grid->np[PD_DIM - 1];
    axisym->count = stencil->count;
    fit.stencil = stencil;
    fit.first = grid->circumference[grid->ghost] / (2.0 * PDI_PI * grid->h[PD_DIM - 1]);
    if (fit.first < 1.0) fit.first = 0.5; /* at the axis, but for rounding */
    pd_status status = pdi_axisym_fill(ctx, stencil, grid, &fit, axisym);
    pdi_owner_free(ctx, pdi_axisym_fit_list, &fit);
    return status;
}

PDI_FN pd_status pdi_axisym_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_axisym *axisym)
{
    pd_status status = pdi_axisym_make(ctx, stencil, grid, axisym);
    if (status < 0) pdi_axisym_free(ctx, axisym);
    return status;
}

PDI_FN void pdi_axisym_free(pd_ctx *ctx, pd_axisym *axisym)
{
    pdi_owner_free(ctx, pdi_axisym_list, axisym);
    memset(axisym, 0, sizeof *axisym);
}
