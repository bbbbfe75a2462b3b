/* force: see force.h */
#include "force.h"
#include "par.h"
#include "vec.h"
#include <math.h>
#include <string.h>

/* Around an axis radial forces cancel. */
static void pdi_force_cancel(const pd_grid *grid, double *force)
{
    if (grid->circumference) force[PD_DIM - 1] = 0.0;
}

/* What row r presses on its closed faces between lo and hi, over rho: V sum_closed 2 g P at the surface, P continued
 * with its gradient (eq. 4.27). */
static void pdi_force_press(const pd_flow *flow, int32_t r, const double *lo, const double *hi, double *press)
{
    const pd_bonds *bonds = flow->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[r];
    double at[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) press[d] = 0.0;
    for (int k = 0; k < s->count; k++) {
        if (pdi_bond_open(bonds, r, k)) continue;
        double t = pdi_bond_meet(bonds, r, k, at), p = flow->p[node];
        pdi_grid_fold_position(flow->grid, at); /* behind a periodic side the surface goes on */
        if (!pdi_grid_between(flow->grid, lo, hi, at)) continue;
        for (int d = 0; d < PD_DIM; d++)
            p += t * s->xi[k * PD_DIM + d] * flow->grad[(int64_t)d * flow->grid->total + node];
        double volume = s->volume * pdi_grid_around(flow->grid, node, 0.5 * s->xi[k * PD_DIM + PD_DIM - 1]);
        for (int d = 0; d < PD_DIM; d++) press[d] += 2.0 * volume * s->grad[k * PD_DIM + d] * p;
    }
}

/* Friction of row r over rho: V (nu (W u - drive) - Q (G P - f)), which its momentum residual holds (eq. 4.27). */
static void pdi_force_rub(const pd_flow *flow, int32_t r, double *rub)
{
    const pd_bonds *bonds = flow->bonds;
    int64_t total = flow->grid->total;
    int32_t node = bonds->node[r];
    for (int d = 0; d < PD_DIM; d++) {
        int64_t at = (int64_t)d * total + node;
        double drive = flow->drive ? flow->drive[at] : 0.0;
        rub[d] = bonds->stencil->volume * pdi_grid_circumference(flow->grid, node) *
                 (flow->nu * (bonds->wall_lap[r] * flow->u[at] - drive) -
                  bonds->wall_curv[r] * (flow->grad[at] - flow->force[d]));
    }
}

void pd_force_surface(pd_ctx *ctx, pd_flow *flow, const double *lo, const double *hi, double *force, double *friction,
                      double *pressure)
{
    const pd_bonds *bonds = flow->bonds;
    pdi_sum sum[2 * PD_DIM];
    memset(sum, 0, sizeof sum);
    pd_flow_prepare(ctx, flow);
    for (int32_t r = 0; r < bonds->rows; r++) {
        double x[PD_DIM], rub[PD_DIM], press[PD_DIM];
        pd_grid_position(flow->grid, bonds->node[r], x);
        int inside = pdi_grid_between(flow->grid, lo, hi, x);
        pdi_force_rub(flow, r, rub);
        pdi_force_press(flow, r, lo, hi, press);
        for (int d = 0; d < PD_DIM; d++) {
            if (inside) pdi_sum_add(&sum[d], flow->rho * rub[d]);
            pdi_sum_add(&sum[PD_DIM + d], flow->rho * press[d]);
        }
    }
    for (int d = 0; d < PD_DIM; d++) {
        double f = pdi_sum_total(&sum[d]), p = pdi_sum_total(&sum[PD_DIM + d]);
        force[d] = f + p;
        if (friction) friction[d] = f;
        if (pressure) pressure[d] = p;
    }
    pdi_force_cancel(flow->grid, force);
    if (friction) pdi_force_cancel(flow->grid, friction);
    if (pressure) pdi_force_cancel(flow->grid, pressure);
}

/* Field f on the face between node - stride and node, and its derivative across it times the spacing: cubics. */
static double pdi_force_mid(const double *f, int32_t node, int32_t stride)
{
    return (9.0 * (f[node] + f[node - stride]) - (f[node + stride] + f[node - 2 * stride])) / 16.0;
}

static double pdi_force_slope(const double *f, int32_t node, int32_t stride)
{
    return (27.0 * (f[node] - f[node - stride]) - (f[node + stride] - f[node - 2 * stride])) / 24.0;
}

/* Momentum that passes the face before `node` towards + of `axis`, over its area: u u_n + P n - nu du/dn. */
static void pdi_force_pass(const pd_flow *flow, int32_t node, int axis, double *pass)
{
    const pd_grid *grid = flow->grid;
    int32_t stride = grid->stride[axis];
    double speed = pdi_force_mid(flow->u + (int64_t)axis * grid->total, node, stride);
    for (int d = 0; d < PD_DIM; d++) {
        const double *u = flow->u + (int64_t)d * grid->total;
        pass[d] = speed * pdi_force_mid(u, node, stride) - flow->nu * pdi_force_slope(u, node, stride) / grid->h[axis];
    }
    pass[axis] += pdi_force_mid(flow->p, node, stride);
}

/* 1 when the low side of axis d is the axis of rings, which nothing passes. */
static int pdi_force_axis(const pd_grid *grid, int d)
{
    return grid->circumference && d == PD_DIM - 1 && grid->side[2 * d] == PD_SIDE_MIRROR;
}

/* First and last cells of the box. */
static pd_status pdi_force_cells(pd_ctx *ctx, const pd_grid *grid, const double *lo, const double *hi, int *first,
                                 int *last)
{
    for (int d = 0; d < PD_DIM; d++) {
        double low = floor((lo[d] - grid->lo[d]) / grid->h[d] + 0.5);
        double high = floor((hi[d] - grid->lo[d]) / grid->h[d] + 0.5);
        int axis = pdi_force_axis(grid, d);
        if (axis) low = 0.0;
        if ((!axis && !(low >= 2.0)) || !(high <= grid->n[d] - 2.0) || !(high > low))
            return pdi_fail(ctx, PD_ERR_GEOMETRY, "force",
                            "cells %g .. %g of axis %d: a box of fluid two cells inside of %d is expected", low, high,
                            d, grid->n[d]);
        first[d] = (int)low;
        last[d] = (int)high - 1;
    }
    return PD_OK;
}

/* Adds what leaves through both sides of `axis`. */
static pd_status pdi_force_sides(pd_ctx *ctx, const pd_flow *flow, const int *first, const int *last, int axis,
                                 pdi_sum *sum)
{
    const pd_grid *grid = flow->grid;
    double face = flow->bonds->stencil->volume / grid->h[axis];
    int32_t stride = grid->stride[axis];
    for (int side = pdi_force_axis(grid, axis) ? 1 : 0; side < 2; side++) {
        int i[PD_DIM], more = 1;
        memcpy(i, first, sizeof i);
        i[axis] = side ? last[axis] + 1 : first[axis];
        while (more) {
            double pass[PD_DIM];
            int32_t node = pd_grid_node(grid, i);
            for (int k = -2; k < 2; k++)
                if (grid->kind[node + k * stride] != PD_FLUID)
                    return pdi_fail(ctx, PD_ERR_GEOMETRY, "force",
                                    "a side of the box, axis %d, comes within two cells of a closed node", axis);
            double area = face * pdi_grid_around(grid, node, axis == PD_DIM - 1 ? -0.5 * grid->h[axis] : 0.0);
            pdi_force_pass(flow, node, axis, pass);
            for (int d = 0; d < PD_DIM; d++) pdi_sum_add(&sum[d], (side ? -1.0 : 1.0) * flow->rho * area * pass[d]);
            more = 0;
            for (int d = 0; d < PD_DIM && !more; d++) {
                if (d == axis) continue;
                more = i[d] < last[d];
                i[d] = more ? i[d] + 1 : first[d];
            }
        }
    }
    return PD_OK;
}

pd_status pd_force_balance(pd_ctx *ctx, pd_flow *flow, const double *lo, const double *hi, double *force)
{
    const pd_grid *grid = flow->grid;
    pdi_sum sum[PD_DIM];
    int first[PD_DIM], last[PD_DIM];
    double fluid = 0.0;
    memset(sum, 0, sizeof sum);
    memset(first, 0, sizeof first);
    memset(last, 0, sizeof last);
    for (int d = 0; d < PD_DIM; d++) force[d] = 0.0;
    PDI_TRY(pdi_force_cells(ctx, grid, lo, hi, first, last));
    pd_flow_prepare(ctx, flow);
    for (int axis = 0; axis < PD_DIM; axis++) PDI_TRY(pdi_force_sides(ctx, flow, first, last, axis, sum));
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM], inside = grid->kind[node] == PD_FLUID;
        pdi_grid_index(grid, node, i);
        for (int d = 0; d < PD_DIM; d++) inside = inside && i[d] >= first[d] && i[d] <= last[d];
        if (inside) fluid += pdi_grid_circumference(grid, node);
    }
    for (int d = 0; d < PD_DIM; d++)
        force[d] = pdi_sum_total(&sum[d]) + flow->rho * flow->force[d] * fluid * flow->bonds->stencil->volume;
    pdi_force_cancel(grid, force);
    return PD_OK;
}
