/* axisym: see axisym.h
 *
 * Radii are in cells here: node i of the rows at the axis has rho_i = i + 1/2, a bond the mean rho = (rho_i + rho_j)/2.
 */
#include "lattice/axisym.h"
#include "core/owner.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Most steps of Newton's method for the conductances near the axis. */
#define PDI_AXISYM_STEPS 60
/* An error of the conditions that is rounding. */
#define PDI_AXISYM_TOLERANCE 4e-16
/* The error of the conditions that has to be reached. */
#define PDI_AXISYM_EXACT 1e-12
/* Share of the largest pivot below which one counts as none: total fluxes near the axis are known twice. */
#define PDI_AXISYM_PIVOT 1e-9
/* The fit of one set of weights w(n): multipliers of the two conditions at each of the rows next to the axis. */
typedef struct pdi_axisym_fit {
    const pd_stencil *stencil;
    const double *weight;      /* [count] */
    double scale[PD_DIM];      /* of the weights: sum scale_a w n_a^2 = 1 over a family */
    double excess;             /* kappa of eq. 3.8 */
    double beyond, wire;       /* bonds at this mean radius in cells and beyond have the kappa `wire` of eq. 3.8b */
    double first;              /* radius of the first row of the box in cells; 0.5: at the axis */
    int32_t rows;              /* fitted, from the axis on; 0: the axis is not in reach */
    double *axial, *radial;    /* [rows] multipliers of eq. 3.9, 3.10 */
    double *matrix, *lack, *x; /* [2 rows][2 rows], [2 rows], [2 rows] of the Newton step */
    int *row_of, *column_of;   /* [2 rows] pivots */
} pdi_axisym_fit;

static int pdi_axisym_offset(const pd_stencil *s, int k, int radial)
{
    return s->offset[k * PD_DIM + (radial ? PD_DIM - 1 : 0)];
}

/* Conductance of bond k of row i over its weight, in cells: rho f; 0 across the axis. */
static double pdi_axisym_conductance(const pdi_axisym_fit *f, int i, int k)
{
    int axial = pdi_axisym_offset(f->stencil, k, 0), j = i + pdi_axisym_offset(f->stencil, k, 1);
    double from = f->first + i, to = f->first + j, rho = 0.5 * (from + to);
    if (!(from > 0.0) || !(to > 0.0)) return 0.0;
    int fitted = i >= 0 && j >= 0 && i < f->rows && j < f->rows; /* ghosts inside of a hollow box are not */
    if (!fitted && axial) return rho;
    if (!fitted) return rho - (rho >= f->beyond ? f->wire : f->excess) / rho;
    double square = (double)axial * axial;
    return rho * exp(square * (f->axial[i] + f->axial[j]) + (to * to - from * from) * (f->radial[i] - f->radial[j]));
}

/* Gauss elimination with complete pivoting; what is left below the smallest pivot is consistent, its unknowns 0. */
static void pdi_axisym_solve(pdi_axisym_fit *f)
{
    int n = 2 * f->rows, rank = 0;
    double largest = 0.0, *a = f->matrix, *b = f->lack;
    for (int k = 0; k < n; k++) f->row_of[k] = f->column_of[k] = k;
    for (; rank < n; rank++) {
        int row = rank, column = rank;
        for (int r = rank; r < n; r++)
            for (int c = rank; c < n; c++)
                if (fabs(a[f->row_of[r] * n + f->column_of[c]]) > fabs(a[f->row_of[row] * n + f->column_of[column]])) {
                    row = r;
                    column = c;
                }
        double pivot = a[f->row_of[row] * n + f->column_of[column]];
        largest = pdi_max(largest, fabs(pivot));
        if (!(fabs(pivot) > PDI_AXISYM_PIVOT * largest)) break;
        int keep = f->row_of[rank];
        f->row_of[rank] = f->row_of[row];
        f->row_of[row] = keep;
        keep = f->column_of[rank];
        f->column_of[rank] = f->column_of[column];
        f->column_of[column] = keep;
        for (int r = rank + 1; r < n; r++) {
            double factor = a[f->row_of[r] * n + f->column_of[rank]] / pivot;
            for (int c = rank; c < n; c++)
                a[f->row_of[r] * n + f->column_of[c]] -= factor * a[f->row_of[rank] * n + f->column_of[c]];
            b[f->row_of[r]] -= factor * b[f->row_of[rank]];
        }
    }
    for (int k = 0; k < n; k++) f->x[k] = 0.0;
    for (int k = rank - 1; k >= 0; k--) {
        double sum = b[f->row_of[k]];
        for (int c = k + 1; c < rank; c++) sum -= a[f->row_of[k] * n + f->column_of[c]] * f->x[f->column_of[c]];
        f->x[f->column_of[k]] = sum / a[f->row_of[k] * n + f->column_of[k]];
    }
}

/* What the conditions lack, relative, and its derivatives by the multipliers; the largest. */
static double pdi_axisym_conditions(pdi_axisym_fit *f)
{
    const pd_stencil *s = f->stencil;
    int n = 2 * f->rows;
    double worst = 0.0;
    for (int k = 0; k < n * n; k++) f->matrix[k] = 0.0;
    for (int i = 0; i < f->rows; i++) {
        double rho = f->first + i, *lack = f->lack + 2 * i;
        lack[0] = lack[1] = 1.0;
        for (int k = 0; k < s->count; k++) {
            int j = i + pdi_axisym_offset(s, k, 1);
            double c = f->weight[k] * pdi_axisym_conductance(f, i, k), to = f->first + j, part[2];
            double square = (double)pdi_axisym_offset(s, k, 0) * pdi_axisym_offset(s, k, 0), step = to * to - rho * rho;
            part[0] = f->scale[0] * c * square / rho;
            part[1] = f->scale[PD_DIM - 1] * c * step / (2.0 * rho);
            for (int e = 0; e < 2; e++) {
                double *row = f->matrix + (int64_t)(2 * i + e) * n;
                lack[e] -= part[e];
                if (j < 0 || j >= f->rows) continue;
                row[2 * i] += part[e] * square;
                row[2 * j] += part[e] * square;
                row[2 * i + 1] += part[e] * step;
                row[2 * j + 1] -= part[e] * step;
            }
        }
        worst = pdi_max(worst, pdi_max(fabs(lack[0]), fabs(lack[1])));
    }
    return worst;
}

static pd_status pdi_axisym_newton(pd_ctx *ctx, pdi_axisym_fit *f)
{
    double best = HUGE_VAL;
    for (int step = 0; step < PDI_AXISYM_STEPS; step++) {
        double error = pdi_axisym_conditions(f);
        if (error <= PDI_AXISYM_TOLERANCE || (error <= PDI_AXISYM_EXACT && !(error < 0.5 * best))) return PD_OK;
        best = pdi_min(best, error);
        pdi_axisym_solve(f);
        for (int i = 0; i < f->rows; i++) {
            f->axial[i] += f->x[2 * i];
            f->radial[i] += f->x[2 * i + 1];
        }
    }
    return pdi_fail(ctx, PD_ERR_GEOMETRY, "ring", "the weights at the axis miss their conditions by %g", best);
}

/* Rows to fit: all that miss bonds, and so many that kappa is at most half of R^2 on all other bonds. */
static int pdi_axisym_rows(const pdi_axisym_fit *f)
{
    int reach = f->stencil->reach, rows = reach;
    if (f->first > 0.5) return 0;
    for (;; rows++) {
        double least = rows + 0.5 - 0.5 * reach;
        if (least * least >= 2.0 * f->excess) return rows;
    }
}

/* Rows next to the axis, or to the hollow, that hold no fluid. */
static int pdi_axisym_dry(const pd_grid *grid)
{
    int least = grid->n[PD_DIM - 1];
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID) continue;
        pdi_grid_index(grid, node, i);
        least = i[PD_DIM - 1] < least ? i[PD_DIM - 1] : least;
    }
    return least;
}

/* Mean radius of the innermost bond of the innermost row with fluid, when no bond of such rows reaches the fitted ones
 * and all such bonds keep half of their conductance; else infinite. */
static double pdi_axisym_beyond(const pdi_axisym_fit *f, const pd_grid *grid)
{
    int dry = pdi_axisym_dry(grid);
    double beyond = f->first + dry - 0.5 * f->stencil->reach;
    if (dry < f->rows + f->stencil->reach || !(beyond > 0.0) || beyond * beyond < 2.0 * f->wire) return HUGE_VAL;
    return beyond;
}

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

/* Fit the conductances of `weight` and put c_ij over the radius, times `unit`, into table[rows][count]. */
static pd_status pdi_axisym_table(pd_ctx *ctx, pdi_axisym_fit *f, const pd_grid *grid, const double *weight,
                                const double *unit, double *table)
{
    const pd_stencil *s = f->stencil;
    double moment[2] = {0.0, 0.0}, curl = 0.0, bend = 0.0, straight = 0.0;
    f->weight = weight;
    for (int k = 0; k < s->count; k++) {
        double axial = pdi_axisym_offset(s, k, 0), radial = pdi_axisym_offset(s, k, 1), square = radial * radial;
        moment[0] += weight[k] * axial * axial;
        moment[1] += weight[k] * square;
        curl += weight[k] * square * (square - 1.0) / 12.0;
        bend += weight[k] * square * square / 12.0;
        if (!(fabs(axial) > 0.0)) straight += weight[k] * square;
    }
    f->scale[0] = 1.0 / moment[0];
    f->scale[PD_DIM - 1] = 1.0 / moment[1];
    f->excess = curl > 0.0 ? curl / straight : 0.0;
    f->wire = bend / straight;
    PDI_TRY(pdi_owner_renew(ctx, pdi_axisym_fit_list, f, &f->rows, pdi_axisym_rows(f)));
    f->beyond = unit ? pdi_axisym_beyond(f, grid) : HUGE_VAL;
    PDI_TRY(pdi_axisym_newton(ctx, f));
    for (int row = 0; row < grid->np[PD_DIM - 1]; row++)
        for (int k = 0; k < s->count; k++) {
            double rho = f->first + (row - grid->ghost), c = pdi_axisym_conductance(f, row - grid->ghost, k);
            table[(int64_t)row * s->count + k] = rho > 0.0 ? (unit ? unit[k] : 1.0) * c / rho : 0.0;
        }
    return PD_OK;
}

static void pdi_axisym_hoop(const pd_stencil *s, const pdi_axisym_fit *f, const pd_grid *grid, pd_axisym *ring)
{
    for (int row = 0; row < ring->rows; row++) {
        double rho = f->first + (row - grid->ghost), sum = 0.0;
        for (int k = 0; k < s->count; k++)
            sum += ring->lap[(int64_t)row * s->count + k] * pdi_axisym_offset(s, k, 1);
        ring->hoop[row] = rho > 0.0 ? sum / rho : 0.0;
    }
}

static void pdi_axisym_list(pdi_owner *owner, void *object)
{
    pd_axisym *ring = (pd_axisym *)object;
    PDI_ARRAY(owner, ring, lap, (int64_t)ring->rows * ring->count, "1/m2");
    PDI_ARRAY(owner, ring, flux, (int64_t)ring->rows * ring->count, "1");
    PDI_ARRAY(owner, ring, hoop, ring->rows, "1/m2");
}

static pd_status pdi_axisym_fill(pd_ctx *ctx, const pd_stencil *s, const pd_grid *grid, pdi_axisym_fit *f,
                                 pd_axisym *ring)
{
    PDI_TRY(pdi_owner_build(ctx, pdi_axisym_list, ring));
    PDI_TRY(pdi_axisym_table(ctx, f, grid, s->lap, s->lap, ring->lap));
    PDI_TRY(pdi_axisym_table(ctx, f, grid, s->base, NULL, ring->flux));
    pdi_axisym_hoop(s, f, grid, ring);
    return PD_OK;
}

static pd_status pdi_axisym_make(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_axisym *ring)
{
    pdi_axisym_fit f;
    memset(ring, 0, sizeof *ring);
    memset(&f, 0, sizeof f);
    if (PD_DIM != 2 || !grid->circumference) return PD_OK;
    ring->rows = grid->np[PD_DIM - 1];
    ring->count = stencil->count;
    f.stencil = stencil;
    f.first = grid->circumference[grid->ghost] / (2.0 * PDI_PI * grid->h[PD_DIM - 1]);
    if (f.first < 1.0) f.first = 0.5; /* at the axis, but for rounding */
    pd_status status = pdi_axisym_fill(ctx, stencil, grid, &f, ring);
    pdi_owner_free(ctx, pdi_axisym_fit_list, &f);
    return status;
}

PDI_FN pd_status pdi_axisym_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_axisym *ring)
{
    pd_status status = pdi_axisym_make(ctx, stencil, grid, ring);
    if (status < 0) pdi_axisym_free(ctx, ring);
    return status;
}

PDI_FN void pdi_axisym_free(pd_ctx *ctx, pd_axisym *ring)
{
    pdi_owner_free(ctx, pdi_axisym_list, ring);
    memset(ring, 0, sizeof *ring);
}
