/* factor: see factor.h
 *
 * Rows stand in the order of elimination: columns along the stream, and their nodes one after the other. In each row
 * five entries of a column stand side by side.
 */
#include "transport/factor.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Vectors of a basis that are left at least. */
#define PDI_FACTOR_VECTORS 9
/* A pivot below this share of the diagonal is none. */
#define PDI_FACTOR_PIVOT 1e-3
/* Up to this cell Peclet number u h/D a multigrid alone takes fewer iterations. */
#define PDI_FACTOR_STREAM 8.0
/* Lattices with fewer columns are eliminated from one end. */
#define PDI_FACTOR_SHORT 64

/* Columns of the lattice from one end of the stream on, in the order of elimination. */
typedef struct pdi_factor_order {
    int32_t origin, along, across; /* node of the first row; from column to column, and within one */
    int columns, rows;             /* nodes */
    int line;                      /* entries of x from column to column, with their rim */
    int end, half;                 /* columns of this end; of the upper one */
    float *entry, *near;           /* of this end */
    double *x;                     /* its first column */
    int plain;                     /* 1: whole families conduct all the same */
    int at[8];                     /* where the bonds end among the lines of four of `near` */
} pdi_factor_order;

/* What a row is made of: five entries from [2] on in each line, the one of the node at [2][4]. What falls beside them
 * is left out. */
typedef float pdi_factor_row[5][12];

static int pdi_factor_fits(const pd_factor *f)
{
    return PD_DIM == 2 && f->flux->flux && f->flux->bonds->stencil->reach == 1 && f->flux->bonds->stencil->count == 8;
}

/* end: 0: the upper one, downstream; 1: the lower one, upstream, up to where the other one ends. */
static pdi_factor_order pdi_factor_sort(const pd_factor *f, int end)
{
    const pd_grid *grid = f->flux->bonds->grid;
    const pd_stencil *s = f->flux->bonds->stencil;
    pdi_factor_order o;
    int i[3] = {0, 0, 0}, other = 1 - f->axis, back = f->down != end;
    if (back) i[f->axis] = grid->n[f->axis] - 1;
    o.origin = pd_grid_node(grid, i);
    o.along = back ? -grid->stride[f->axis] : grid->stride[f->axis];
    o.across = grid->stride[other % PD_DIM];
    o.columns = grid->n[f->axis];
    o.rows = grid->n[other % PD_DIM];
    int both = o.columns >= PDI_FACTOR_SHORT && o.columns >= o.rows; /* else the room of the second end tells */
    o.half = both ? o.columns / 2 : o.columns;
    o.end = end ? o.columns - o.half : o.half;
    o.line = end ? -(o.rows + 4) : o.rows + 4;
    o.entry = f->entry ? f->entry + (end ? 25 * (int64_t)o.half * o.rows : 0) : NULL;
    o.near = f->near ? f->near + (end ? 3 * (int64_t)(o.rows + 2) * PDI_FACTOR_NEAR : 0) : NULL;
    o.x = f->x ? f->x + (int64_t)(end ? o.columns + 1 : 2) * (o.rows + 4) + 2 : NULL;
    o.plain = !grid->circumference && !f->flux->diffusion->field;
    for (int k = 0; k < 8 && k < s->count; k++) {
        int a = s->offset[k * PD_DIM + f->axis], b = s->offset[k * PD_DIM + other % PD_DIM];
        o.at[k] = ((back ? -a : a) + 1) * 4 + b + 1;
    }
    return o;
}

/* 1: some cell has a stream that needs factors. What limiters give back of the conductance of upwind fluxes is at most
 * the share 1 - 2 D/(u h) of it, and the multigrid is one of upwind fluxes. */
static int pdi_factor_streams(const pd_factor *f)
{
    const pd_grid *grid = f->flux->bonds->grid;
    const pd_diffusion *diffusion = f->flux->diffusion;
    for (int d = 0; d < PD_DIM; d++)
        for (int32_t i = 0; i < grid->total; i++) {
            double conducts = diffusion->field ? diffusion->field[i] : diffusion->desc.diffusivity;
            double u = fabs(f->flux->flow->u[(int64_t)d * grid->total + i]);
            if (grid->kind[i] == PD_FLUID && !(u * grid->h[d] <= PDI_FACTOR_STREAM * conducts)) return 1;
        }
    return 0;
}

/* The axis with the strongest mean stream comes first, downstream. */
static void pdi_factor_turn(pd_factor *f)
{
    const pd_flow *flow = f->flux->flow;
    double most = -1.0;
    for (int d = 0; d < PD_DIM; d++) {
        double sum = 0.0;
        for (int32_t i = 0; i < flow->grid->total; i++)
            if (flow->grid->kind[i] == PD_FLUID) sum += flow->u[(int64_t)d * flow->grid->total + i];
        if (!(fabs(sum) > most)) continue;
        most = fabs(sum);
        f->axis = d;
        f->down = sum < 0.0;
    }
}

PDI_COLD_BEGIN
static void pdi_factor_list(pdi_array_visitor *owner, void *object)
{
    pd_factor *factor = (pd_factor *)object;
    pdi_factor_order o = pdi_factor_sort(factor, 0);
    PDI_ARRAY_UNINIT(owner, factor, entry, 25 * (int64_t)o.columns * o.rows, "1/s");
    PDI_ARRAY(owner, factor, x, (int64_t)(o.columns + 4) * o.line, "mol/m3");
    PDI_ARRAY(owner, factor, near, (o.half < o.columns ? 6 : 3) * (int64_t)(o.rows + 2) * PDI_FACTOR_NEAR, "");
}

PDI_FN void pdi_factor_lend(pd_ctx *ctx, pd_arena *arena, pd_krylov *krylov, pd_factor *f)
{
    f->good = 0;
    if (!pdi_factor_fits(f) || !pdi_factor_streams(f)) return;
    pdi_factor_turn(f);
    pdi_krylov_lend_basis(ctx, krylov, arena, pdi_factor_list, f, PDI_FACTOR_VECTORS);
}

PDI_FN pd_status pdi_factor_return(pd_ctx *ctx, pd_arena *arena, pd_status status, pd_krylov *krylov, pd_factor *f)
{
    return f->entry ? pdi_krylov_restore_basis(ctx, krylov, arena, pdi_factor_list, f, status) : status;
}
PDI_COLD_END

/* Derivatives of alpha of fluid node i (eq. 6.15), into the first three lines of `near`. */
static void pdi_factor_alpha(const pd_factor *f, const pdi_factor_order *o, const double *c, double least, int32_t i,
                             const int *open, float *near)
{
    const pd_bonds *bonds = f->flux->bonds;
    const pd_diffusion *d = f->flux->diffusion;
    const double *lap = bonds->stencil->laplacian_weight;
    double bend = 0.0, size = 0.0, step[8], floor_size = least * bonds->stencil->lap_sum, own = 0.0;
    for (int k = 0; k < 8; k++) {
        step[k] = open[k] ? lap[k] * (c[i + bonds->paths.shift[k]] - c[i]) : 0.0;
        bend += step[k];
        size += fabs(step[k]);
    }
    if (d->wall_rate && d->wall_rate[i] > 0.0) {
        double wall = pdi_diffusion_gain(d, i, c[i], 0.0) / (d->field ? d->field[i] : d->desc.diffusivity);
        bend += wall;
        size += fabs(wall);
    }
    double below = size + floor_size;
    if (f->upwinded[i] || !(below > 0.0)) return;
    double ratio = (fabs(bend) + floor_size) / below, slope = -4.0 * ratio * ratio * ratio / below;
    double side = bend > 0.0 ? 1.0 : bend < 0.0 ? -1.0 : 0.0;
    for (int k = 0; k < 8; k++) {
        double sign = step[k] > 0.0 ? 1.0 : step[k] < 0.0 ? -1.0 : 0.0;
        double by = open[k] ? slope * lap[k] * (side - ratio * sign) : 0.0;
        near[o->at[k]] = (float)by;
        own -= by;
    }
    near[5] = (float)own;
}

/* The gradient of the node (eq. 2.9), behind it. */
static void pdi_factor_gradient(const pd_factor *f, const pdi_factor_order *o, int32_t i, const int *open, float *near)
{
    const pd_bonds *bonds = f->flux->bonds;
    const pd_diffusion *diffusion = f->flux->diffusion;
    const double *grad = bonds->stencil->gradient_weight, *moment = NULL, *held = NULL;
    int32_t place = diffusion->place[i];
    if (pdi_limiter_cut(f->flux->limiter, i))
        moment = bonds->inverse_moment + (int64_t)bonds->row_of_node[i] * PD_DIM * PD_DIM;
    else if (place >= 0) held = diffusion->wall_grad_rate + (int64_t)place * PD_DIM;
    for (int d = 0; d < 2; d++) {
        double own = held ? -held[d % PD_DIM] : 0.0;
        float *to = near + 12 * (d + 1);
        for (int k = 0; k < 8; k++) {
            const double *g = grad + k * PD_DIM;
            double part = moment ? 0.0 : g[d % PD_DIM];
            for (int e = 0; e < PD_DIM && moment; e++) part += moment[d * PD_DIM + e] * bonds->full_moment[e] * g[e];
            if (!open[k]) continue;
            to[o->at[k]] = (float)part;
            own -= part;
        }
        to[5] = (float)own;
    }
}

/* Both for the nodes of a column; others have none. */
static void pdi_factor_column(const pd_factor *f, const pdi_factor_order *o, const double *c, double least, int column)
{
    const pd_bonds *bonds = f->flux->bonds;
    float *near = o->near + (int64_t)(column % 3) * (o->rows + 2) * PDI_FACTOR_NEAR;
    memset(near, 0, (size_t)(o->rows + 2) * PDI_FACTOR_NEAR * sizeof *near);
    for (int row = 0; row < o->rows && column < o->columns; row++) {
        int32_t i = o->origin + column * o->along + row * o->across;
        int open[8];
        near += PDI_FACTOR_NEAR;
        if (bonds->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < 8; k++)
            open[k] = pdi_flux_open(f->flux, i, k) && bonds->grid->kind[i + bonds->paths.shift[k]] != PD_OUTLET;
        pdi_factor_alpha(f, o, c, least, i, open, near);
        pdi_factor_gradient(f, o, i, open, near);
    }
}

/* Add what a node has in `near`, whose middle stands at entry [a][b]. */
static inline void pdi_factor_spread(const float *near, float alpha, const float *along, int a, int b,
                                     pdi_factor_row row)
{
    for (int line = 0; line < 3; line++) {
        const float *n = near + 4 * line;
        float *to = row[a + line] + 2 + b;
        for (int k = 0; k < 4; k++) to[k] += alpha * n[k] + along[0] * n[12 + k] + along[1] * n[24 + k];
    }
}

/* The bond k of node i: what leaves by it, less what the limited fluxes give back. */
static void pdi_factor_bond(const pd_factor *f, const pdi_factor_order *o, const double *c, int32_t i, int k,
                            const float *near, float *own, pdi_factor_row row)
{
    const pd_flux *t = f->flux;
    const pd_bonds *bonds = t->bonds;
    const double *xi = bonds->stencil->xi + k * PD_DIM;
    int32_t j = i + bonds->paths.shift[k];
    int64_t total = bonds->grid->total;
    int a = o->at[k] / 4 - 1, b = o->at[k] % 4 - 1;
    uint8_t kind = bonds->grid->kind[j];
    double flux, bond, x[2] = {0.0, 0.0};
    if (o->plain && bonds->row_of_node[i] < 0) {
        flux = k < 4 ? t->flux[k * total + i] : -t->flux[(7 - k) * total + j];
        bond = t->diffusion->desc.diffusivity * bonds->stencil->laplacian_weight[k];
    } else pdi_flux_one(t, i, k, &flux, &bond);
    if (kind == PD_OUTLET) {
        row[2][4] += (float)flux;
        return;
    }
    int32_t end[2];
    end[0] = flux > 0.0 ? i : j;
    end[1] = flux > 0.0 ? j : i;
    for (int e = 0; e < 2; e++)
        for (int d = 0; d < PD_DIM; d++) x[e] += xi[d] * t->limiter->slope[d * total + end[e]];
    pdi_bend_terms of, by;
    of.step = c[j] - c[i];
    of.bend = pdi_bend_of(of.step, x[0], x[1]);
    of.alpha = t->limiter->factor[end[0]];
    pdi_bend_flux(flux, bond, kind == PD_INLET ? 0.0 : 1.0, &of, &by);
    double half = 0.5 * flux, size = fabs(half), most = size > bond ? size : bond;
    double step = by.step - PDI_BEND_LEAN * by.bend;
    row[2][4] += (float)(half + most - step);
    if (kind != PD_FLUID) return;
    row[2 + a][4 + b] += (float)(half - most + step);
    double up = by.bend * (0.5 * PDI_BEND_LEAN + PDI_BEND_SHARE);
    double down = by.bend * (0.5 * PDI_BEND_LEAN - PDI_BEND_SHARE);
    double here = flux > 0.0 ? up : down, there = flux > 0.0 ? down : up;
    float along[2] = {0.0f, 0.0f};
    for (int d = 0; d < PD_DIM && d < 2; d++) {
        own[1 + d] += (float)(here * xi[d]);
        along[d] = (float)(there * xi[d]);
    }
    own[0] += flux > 0.0 ? (float)by.alpha : 0.0f;
    pdi_factor_spread(near, flux > 0.0 ? 0.0f : (float)by.alpha, along, 1 + a, 1 + b, row);
}

/* The equation of a fluid node. */
static void pdi_factor_assemble(const pd_factor *f, const pdi_factor_order *o, const double *c, double rate, int column,
                                int at, pdi_factor_row row)
{
    const pd_flux *t = f->flux;
    int32_t i = o->origin + column * o->along + at * o->across;
    double own_rate = rate + t->absorb[i] + (t->diffusion->wall_rate ? t->diffusion->wall_rate[i] : 0.0);
    float own[3] = {0.0f, 0.0f, 0.0f};
    memset(row, 0, sizeof(pdi_factor_row));
    row[2][4] = (float)own_rate;
    for (int k = 0; k < 8; k++) {
        if (!pdi_flux_open(t, i, k)) continue;
        int a = o->at[k] / 4 - 1, b = o->at[k] % 4 - 1;
        const float *near = o->near + ((int64_t)((column + 3 + a) % 3) * (o->rows + 2) + at + 1 + b) * PDI_FACTOR_NEAR;
        pdi_factor_bond(f, o, c, i, k, near, own, row);
    }
    const float *near = o->near + ((int64_t)(column % 3) * (o->rows + 2) + at + 1) * PDI_FACTOR_NEAR;
    pdi_factor_spread(near, own[0], own + 1, 1, 1, row);
}

/* What joins it with nodes that are not fluid is left out: those of a whole square are. */
static void pdi_factor_cut(const pd_factor *f, const pdi_factor_order *o, int column, int at, pdi_factor_row row)
{
    const uint8_t *kind = f->flux->bonds->grid->kind;
    int32_t i = o->origin + column * o->along + at * o->across;
    int whole = column >= 2 && column + 2 < o->columns && at >= 2 && at + 2 < o->rows;
    for (int a = -2; a <= 2; a++)
        for (int b = -2; b <= 2; b++) {
            int inside = whole || (column + a >= 0 && column + a < o->columns && at + b >= 0 && at + b < o->rows);
            if (!inside || kind[i + a * o->along + b * o->across] != PD_FLUID) row[a + 2][b + 4] = 0.0f;
        }
}

/* One of the rows before, whose node stands a columns and b nodes from that of `row`, is eliminated from it. other:
 * its entries; its order runs with that of the row (turn 1) or against it (-1); lines: columns behind it that it
 * has. */
PDI_INLINE void pdi_factor_before(const float *other, int a, int b, int turn, int lines, pdi_factor_row row)
{
    float factor = row[a + 2][b + 4];
    if (!(factor < 0.0f) && !(factor > 0.0f)) return;
    factor *= other[12];
    row[a + 2][b + 4] = factor;
    for (int q = 3; q < 5; q++) row[a + 2][b + 2 + q] -= factor * other[10 + q];
    for (int line = 1; line <= lines; line++)
        for (int q = 0; q < 5; q++) row[a + 2 + turn * line][b + 2 + q] -= factor * other[10 + 5 * line + q];
}

/* Those of a column; other: of the node in the line of the row. */
PDI_INLINE void pdi_factor_before_all(const float *other, int a, int turn, int lines, pdi_factor_row row)
{
    pdi_factor_before(other - 50, a, -2, turn, lines, row);
    pdi_factor_before(other - 25, a, -1, turn, lines, row);
    if (a == 0) return;
    pdi_factor_before(other, a, 0, turn, lines, row);
    pdi_factor_before(other + 25, a, 1, turn, lines, row);
    pdi_factor_before(other + 50, a, 2, turn, lines, row);
}

/* Columns behind `column` that are eliminated after it, of the two beside it: the lower end meets the upper one, which
 * comes before it. */
static int pdi_factor_behind(const pdi_factor_order *o, int column)
{
    int left = o->line < 0 ? o->end - 1 - column : 2;
    return left < 2 ? left : 2;
}

/* Eliminate what comes before it from a row, into its entries. Returns 1 when its pivot is one. */
static int pdi_factor_eliminate(const pdi_factor_order *o, int column, pdi_factor_row row, float *entry)
{
    float size = fabsf(row[2][4]);
    int64_t side = 25 * (int64_t)o->rows;
    int lines = pdi_factor_behind(o, column);
    if (lines == 2) {
        pdi_factor_before_all(entry - 2 * side, -2, 1, 2, row);
        pdi_factor_before_all(entry - side, -1, 1, 2, row);
        pdi_factor_before_all(entry, 0, 1, 2, row);
    } else {
        /* the columns of the upper end, whose last ones lie in front of the first ones of this one */
        const float *upper = o->entry + (entry - o->entry) % side;
        if (!lines) pdi_factor_before_all(upper - 2 * side, 2, -1, 2, row);
        pdi_factor_before_all(upper - side, lines + 1, -1, 2, row);
        pdi_factor_before_all(entry - 2 * side, -2, 1, 2, row);
        pdi_factor_before_all(entry - side, -1, 1, lines + 1, row);
        pdi_factor_before_all(entry, 0, 1, lines, row);
    }
    for (int a = 0; a < 5; a++)
        for (int b = 0; b < 5; b++) entry[5 * a + b] = row[a][b + 2];
    int good = fabsf(entry[12]) > (float)PDI_FACTOR_PIVOT * size && fabsf(entry[12]) < HUGE_VALF;
    entry[12] = good ? 1.0f / entry[12] : 0.0f;
    return good;
}

/* The columns from `first` up to `behind` of an end: 1 when all pivots are. */
static int pdi_factor_columns(const pd_factor *f, const pdi_factor_order *o, const double *c, double rate, double least,
                              int first, int behind)
{
    pdi_factor_row sums;
    if (!first && behind > 0) {
        memset(o->near, 0, 3 * (size_t)(o->rows + 2) * PDI_FACTOR_NEAR * sizeof *o->near);
        pdi_factor_column(f, o, c, least, 0);
    }
    for (int column = first; column < behind; column++) {
        pdi_factor_column(f, o, c, least, column + 1);
        for (int row = 0; row < o->rows; row++) {
            float *entry = o->entry + 25 * ((int64_t)column * o->rows + row);
            if (f->flux->bonds->grid->kind[o->origin + column * o->along + row * o->across] != PD_FLUID) {
                memset(entry, 0, 25 * sizeof *entry);
                continue;
            }
            pdi_factor_assemble(f, o, c, rate, column, row, sums);
            pdi_factor_cut(f, o, column, row, sums);
            if (!pdi_factor_eliminate(o, column, sums, entry)) return 0;
        }
    }
    return 1;
}

/* Columns of the lower end that have none of the upper one beside them. */
static int pdi_factor_apart(const pdi_factor_order *o) { return o->end > 2 ? o->end - 2 : 0; }

PDI_FN void pdi_factor_make(const pd_ctx *ctx, pd_factor *f, const double *c, double rate, double least)
{
    f->good = 0;
    if (PD_DIM != 2 || !f->entry) return;
    pdi_factor_order o[2];
    pdi_par_timing timing;
    int good[2];
    for (int end = 0; end < 2; end++) o[end] = pdi_factor_sort(f, end);
    int nt = pdi_par_begin_timing(ctx, (int64_t)o[0].columns * o[0].rows * 500, 1,
                                  (uint64_t)(uintptr_t)pdi_factor_columns, &timing);
    (void)nt;
    PD_PARALLEL_FOR(nt < 2 ? nt : 2)
    for (int end = 0; end < 2; end++)
        good[end] = pdi_factor_columns(f, o + end, c, rate, least, 0, end ? pdi_factor_apart(o + 1) : o->end);
    pdi_par_end_timing(ctx, &timing);
    f->good = good[0] && good[1];
    if (f->good) f->good = pdi_factor_columns(f, o + 1, c, rate, least, pdi_factor_apart(o + 1), o[1].end);
}

/* L y = x in the columns from `first` up to `behind` of an end. */
static void pdi_factor_forward(const pd_factor *f, const pdi_factor_order *o, const double *x, int first, int behind)
{
    const uint8_t *kind = f->flux->bonds->grid->kind;
    for (int column = first; column < behind; column++) {
        double *to = o->x + (int64_t)column * o->line;
        const float *e = o->entry + 25 * (int64_t)column * o->rows;
        int lines = pdi_factor_behind(o, column);
        for (int row = 0; row < o->rows; row++, e += 25, to++) {
            int32_t i = o->origin + column * o->along + row * o->across;
            double sum = kind[i] == PD_FLUID ? x[i] : 0.0;
            for (int k = 0; k < 5; k++) sum -= (double)e[k] * to[k - 2 - 2 * o->line];
            for (int k = 0; k < 5; k++) sum -= (double)e[5 + k] * to[k - 2 - o->line];
            for (int a = lines + 1; a < 3; a++)
                for (int k = 0; k < 5; k++) sum -= (double)e[10 + 5 * a + k] * to[k - 2 + a * o->line];
            *to = sum - (double)e[10] * to[-2] - (double)e[11] * to[-1];
        }
    }
}

/* U y = that, from behind. */
static void pdi_factor_backward(const pd_factor *f, const pdi_factor_order *o, int first, int behind, double *y)
{
    const uint8_t *kind = f->flux->bonds->grid->kind;
    for (int column = behind - 1; column >= first; column--) {
        double *to = o->x + (int64_t)column * o->line + o->rows - 1;
        const float *e = o->entry + 25 * ((int64_t)column * o->rows + o->rows - 1);
        int lines = pdi_factor_behind(o, column);
        for (int row = o->rows - 1; row >= 0; row--, e -= 25, to--) {
            double sum = *to;
            int32_t i = o->origin + column * o->along + row * o->across;
            for (int a = lines; a > 0; a--)
                for (int k = 0; k < 5; k++) sum -= (double)e[10 + 5 * a + k] * to[k - 2 + a * o->line];
            *to = (sum - (double)e[14] * to[2] - (double)e[13] * to[1]) * (double)e[12];
            if (kind[i] == PD_FLUID) y[i] = *to;
        }
    }
}

PDI_FN void pdi_factor_solve(const pd_ctx *ctx, const pd_factor *f, const double *x, double *y)
{
    pdi_factor_order o[2];
    pdi_par_timing timing;
    if (PD_DIM != 2) return;
    for (int end = 0; end < 2; end++) o[end] = pdi_factor_sort(f, end);
    int apart = pdi_factor_apart(o + 1);
    int nt = pdi_par_begin_timing(ctx, (int64_t)o[0].columns * o[0].rows * 50, 1,
                                  (uint64_t)(uintptr_t)pdi_factor_forward, &timing);
    (void)nt;
    PD_PARALLEL_FOR(nt < 2 ? nt : 2)
    for (int end = 0; end < 2; end++) pdi_factor_forward(f, o + end, x, 0, end ? apart : o->end);
    pdi_factor_forward(f, o + 1, x, apart, o[1].end);
    pdi_factor_backward(f, o + 1, apart, o[1].end, y);
    PD_PARALLEL_FOR(nt < 2 ? nt : 2)
    for (int end = 0; end < 2; end++) pdi_factor_backward(f, o + end, 0, end ? apart : o->end, y);
    pdi_par_end_timing(ctx, &timing);
}

#undef PDI_FACTOR_VECTORS
#undef PDI_FACTOR_PIVOT
#undef PDI_FACTOR_STREAM
#undef PDI_FACTOR_SHORT
