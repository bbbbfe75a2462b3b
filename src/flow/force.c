/* force: see force.h */
#include "flow/force.h"
#include "core/vec.h"
#include "core/par.h"
#include "lattice/quadratic.h"
#include "lattice/surface.h"
#include <math.h>
#include <string.h>

/* Around an axis radial forces cancel. */
static void pdi_force_cancel(const pd_grid *grid, double *force)
{
    if (grid->circumference) force[PD_DIM - 1] = 0.0;
}

/* The wanted force: on surfaces between lo and hi, of one shape, of the sides or of all. Sums: friction, pressure. */
typedef struct pdi_force_query {
    const pd_flow *flow;
    const double *lo, *hi;
    int shape;
    pdi_sum sum[2 * PD_DIM];
} pdi_force_query;

/* 1 when the closed cell at the end of a bond belongs to the shape that is asked for. */
static int pdi_force_owned(const pdi_force_query *q, const pdi_bond_end *end)
{
    double x[PD_DIM];
    if (q->shape == PD_FORCE_ALL) return 1;
    if (end->side || q->shape == PD_FORCE_SIDES) return end->side && q->shape == PD_FORCE_SIDES;
    pd_grid_position(q->flow->grid, end->cell, x);
    return pdi_grid_level(q->flow->grid, q->shape, x) <= pdi_shape_tie(q->flow->grid->h, x);
}

/* 1 when this holds and the bond meets the surface between lo and hi. Behind a periodic side the surface goes on. */
static int pdi_force_asked(const pdi_force_query *q, const pdi_bond_end *end)
{
    double at[PD_DIM];
    memcpy(at, end->at, sizeof at);
    pdi_grid_fold_position(q->flow->grid, at);
    return pdi_grid_between(q->flow->grid, q->lo, q->hi, at) && pdi_force_owned(q, end);
}

/* The surface as a row sees it, by the area of its closed bonds. */
typedef struct pdi_force_face {
    double asked, owned;               /* shares of what is asked for, and of its shape at any place */
    double foot[PD_DIM], into[PD_DIM]; /* [m] mean place; unit vector into the wall */
} pdi_force_face;

static void pdi_force_see(const pdi_force_query *q, int32_t r, pdi_force_face *face)
{
    const pd_bonds *bonds = q->flow->bonds;
    double all = 0.0;
    memset(face, 0, sizeof *face);
    for (int k = 0; k < bonds->stencil->count; k++) {
        const double *g = bonds->stencil->grad + k * PD_DIM;
        pdi_bond_end end;
        if (pdi_bond_open(bonds, r, k)) continue;
        double size = pdi_vec_norm(g);
        pdi_bond_find_end(bonds, r, k, &end);
        all += size;
        if (pdi_force_owned(q, &end)) face->owned += size;
        if (pdi_force_asked(q, &end)) face->asked += size;
        for (int d = 0; d < PD_DIM; d++) {
            face->foot[d] += size * end.at[d];
            face->into[d] += g[d];
        }
    }
    double length = pdi_vec_norm(face->into);
    if (!(all > 0.0)) return;
    face->asked /= all;
    face->owned /= all;
    for (int d = 0; d < PD_DIM; d++) {
        face->foot[d] /= all;
        face->into[d] = length > 0.0 ? face->into[d] / length : 0.0;
    }
}

/* What row r presses on its closed faces, over rho: V sum_closed 2 g P at the surface, P continued with its gradient
 * (eq. 4.27). */
static void pdi_force_press(const pdi_force_query *q, int32_t r, double *press)
{
    const pd_flow *flow = q->flow;
    const pd_bonds *bonds = flow->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[r];
    for (int d = 0; d < PD_DIM; d++) press[d] = 0.0;
    for (int k = 0; k < s->count; k++) {
        pdi_bond_end end;
        if (pdi_bond_open(bonds, r, k)) continue;
        pdi_bond_find_end(bonds, r, k, &end);
        if (!pdi_force_asked(q, &end)) continue;
        double p = flow->p[node];
        for (int d = 0; d < PD_DIM; d++)
            p += end.t * s->xi[k * PD_DIM + d] * flow->grad[(int64_t)d * flow->grid->total + node];
        double volume = s->volume * pdi_grid_around(flow->grid, node, 0.5 * s->xi[k * PD_DIM + PD_DIM - 1]);
        for (int d = 0; d < PD_DIM; d++) press[d] += 2.0 * volume * s->grad[k * PD_DIM + d] * p;
    }
}

/* Friction of row r over rho: V (nu (W u - motion) - Q (G P - f)), or - V nu times (3.4b), as its momentum residual
 * holds it (eq. 4.27). Of one shape: the parts of its bonds, or its share of them. */
static void pdi_force_rub(const pdi_force_query *q, int32_t r, double *rub)
{
    const pd_flow *flow = q->flow;
    const pd_bonds *bonds = flow->bonds;
    int64_t total = flow->grid->total;
    int32_t node = bonds->node[r];
    double lap = 0.0, curv = 0.0, motion[PD_DIM], miss[PD_DIM];
    double volume = bonds->stencil->volume * pdi_grid_circumference(flow->grid, node);
    int bends = pdi_flow_bends(flow, r);
    if (bends || (flow->sharp.bonds && pdi_sharp_rub(&flow->sharp, r, flow->u, flow->sharp.bend, rub))) {
        pdi_force_face face;
        pdi_force_see(q, r, &face);
        if (bends) pdi_reconstruct_bend(&flow->slopes, r, flow->u, rub);
        if (bends) pdi_reconstruct_miss(&flow->slopes, r, flow->p, miss);
        for (int d = 0; d < PD_DIM; d++)
            rub[d] = volume * face.owned * ((bends ? miss[d] : 0.0) - flow->nu * rub[d]);
        return;
    }
    for (int d = 0; d < PD_DIM; d++)
        motion[d] = flow->wall_motion && q->shape == PD_FORCE_ALL ? flow->wall_motion[d * total + node] : 0.0;
    if (q->shape == PD_FORCE_ALL) {
        lap = bonds->wall_lap[r];
        curv = bonds->wall_curv[r];
    }
    for (int k = 0; k < bonds->stencil->count && q->shape != PD_FORCE_ALL; k++) {
        pdi_bond_end end;
        double u[PD_DIM];
        if (pdi_bond_open(bonds, r, k)) continue;
        pdi_bond_find_end(bonds, r, k, &end);
        if (!pdi_force_owned(q, &end)) continue;
        lap += end.lap;
        curv += end.curv;
        if (!flow->wall) continue;
        flow->wall(flow->wall_user, end.x, u);
        for (int d = 0; d < PD_DIM; d++) motion[d] += end.lap * u[d];
    }
    for (int d = 0; d < PD_DIM; d++) {
        int64_t at = (int64_t)d * total + node;
        rub[d] = volume * (flow->nu * (lap * flow->u[at] - motion[d]) -
                           curv * (flow->grad[at] - pdi_flow_force(flow, d, node)));
    }
}

/* ---- what the pressure of the discrete equations does to a smooth surface ---- */

/* What all closed bonds of a row press, without regard to what is asked for. */
static void pdi_force_press_all(const pd_flow *flow, int32_t r, double *press)
{
    pdi_force_query all;
    double lo[PD_DIM], hi[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        lo[d] = -HUGE_VAL;
        hi[d] = HUGE_VAL;
    }
    all.flow = flow;
    all.lo = lo;
    all.hi = hi;
    all.shape = PD_FORCE_ALL;
    pdi_force_press(&all, r, press);
}

/* X = P (B - 1)^T g over the bond k of row r, with the mean P of both ends: what eq. 4.2b adds to the momentum that the
 * bond hands on. P itself, for the rest of it. */
static double pdi_force_hand(const pd_flow *flow, int32_t r, int k, double *x)
{
    const pd_bonds *bonds = flow->bonds;
    const double *b = bonds->advecting + (int64_t)r * PD_DIM * PD_DIM, *g = bonds->stencil->grad + k * PD_DIM;
    int32_t node = bonds->node[r];
    double p = 0.5 * (flow->p[node] + flow->p[node + bonds->paths.shift[k]]);
    for (int d = 0; d < PD_DIM; d++) {
        x[d] = -p * g[d];
        for (int e = 0; e < PD_DIM; e++) x[d] += p * g[e] * b[e * PD_DIM + d];
    }
    return p;
}

/* Row r beside a smooth surface takes what of G P no bond hands on, G P - sum_open (2 P g + X), and not what the faces
 * of (4.27) add up to; X goes to the place on the surface below the far end. The sum over a body is what passes a box
 * around it. */
static void pdi_force_take(pdi_force_query *q, int32_t r)
{
    const pd_flow *flow = q->flow;
    const pd_bonds *bonds = flow->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[r];
    double take[PD_DIM], press[PD_DIM], hand[PD_DIM], at[PD_DIM];
    pdi_force_face face;
    pdi_force_see(q, r, &face);
    if (!(face.owned > 0.0)) return;
    pdi_force_press_all(flow, r, press);
    for (int d = 0; d < PD_DIM; d++) take[d] = flow->grad[(int64_t)d * flow->grid->total + node];
    for (int k = 0; k < s->count; k++) {
        if (!pdi_bond_open(bonds, r, k) || flow->grid->kind[node + bonds->paths.shift[k]] == PD_INLET) continue;
        double p = pdi_force_hand(flow, r, k, hand);
        double deep = pdi_vec_dot(s->xi + k * PD_DIM, face.into);
        for (int d = 0; d < PD_DIM; d++) at[d] = face.foot[d] + s->xi[k * PD_DIM + d] - deep * face.into[d];
        pdi_grid_fold_position(flow->grid, at);
        double share = pdi_grid_between(flow->grid, q->lo, q->hi, at) ? face.owned : 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            take[d] -= 2.0 * p * s->grad[k * PD_DIM + d] + hand[d];
            pdi_sum_add(&q->sum[PD_DIM + d], flow->rho * s->volume * share * hand[d]);
        }
    }
    for (int d = 0; d < PD_DIM; d++)
        pdi_sum_add(&q->sum[PD_DIM + d], flow->rho * face.asked * (s->volume * take[d] - press[d]));
}

/* ---- cells that a smooth surface cuts ---- */

#define PDI_FORCE_PIECES 8 /* of a cell, along each axis */

/* Share of the cell around x that lies outside of `shape`. */
static double pdi_force_outside(const pd_grid *grid, int shape, const double *x)
{
    double at[PD_DIM], sum = 0.0, size = 0.0;
    int i[PD_DIM], count = 1, more = 1;
    memset(i, 0, sizeof i);
    for (int d = 0; d < PD_DIM; d++) {
        count *= PDI_FORCE_PIECES;
        size += grid->h[d] / (PD_DIM * PDI_FORCE_PIECES);
    }
    while (more) {
        for (int d = 0; d < PD_DIM; d++) at[d] = x[d] + ((i[d] + 0.5) / PDI_FORCE_PIECES - 0.5) * grid->h[d];
        sum += pdi_min(pdi_max(0.5 + pdi_grid_level(grid, shape, at) / size, 0.0), 1.0);
        more = 0;
        for (int d = 0; d < PD_DIM && !more; d++) {
            more = i[d] + 1 < PDI_FORCE_PIECES;
            i[d] = more ? i[d] + 1 : 0;
        }
    }
    return sum / count;
}

#undef PDI_FORCE_PIECES

/* Fluid at `node`, in cells, that its kind does not count or counts too much, since a smooth surface of `shape` cuts
 * the cell. Metal that has receded from it has cells for a surface. */
static double pdi_force_cut(const pd_grid *grid, int shape, int32_t node)
{
    double x[PD_DIM], reach = 0.0;
    int fluid = grid->kind[node] == PD_FLUID;
    if (shape < 0 || grid->circumference || !pdi_shape_exact(grid->shapes, shape)) return 0.0;
    for (int d = 0; d < PD_DIM; d++) reach += grid->h[d];
    pd_grid_position(grid, node, x);
    double distance = pdi_grid_level(grid, shape, x);
    if (fabs(distance) > reach || fluid != (distance > pdi_shape_tie(grid->h, x))) return 0.0;
    return pdi_force_outside(grid, shape, x) - (double)fluid;
}

/* The same by all shapes, or by one that is asked for. */
static double pdi_force_excess(const pd_grid *grid, int shape, int32_t node)
{
    if (shape != PD_FORCE_ALL) return pdi_force_cut(grid, shape, node);
    return pdi_force_cut(grid, grid->wall, node) + pdi_force_cut(grid, grid->solid, node);
}

/* The body force pulls at cells; what of it belongs to the body, or to the fluid, is pressure. */
static void pdi_force_weigh(pdi_force_query *q)
{
    const pd_flow *flow = q->flow;
    const pd_grid *grid = flow->grid;
    double pull = 0.0;
    for (int d = 0; d < PD_DIM; d++) pull += fabs(flow->force[d]);
    for (int32_t node = 0; node < grid->total && pull > 0.0; node++) {
        double x[PD_DIM];
        int i[PD_DIM];
        pdi_grid_index(grid, node, i);
        pd_grid_position(grid, node, x);
        if (!pdi_grid_inside(grid, i) || !pdi_grid_between(grid, q->lo, q->hi, x)) continue;
        double excess = flow->bonds->stencil->volume * pdi_force_excess(grid, q->shape, node);
        for (int d = 0; d < PD_DIM; d++)
            pdi_sum_add(&q->sum[PD_DIM + d], flow->rho * flow->force[d] * excess);
    }
}

void pd_force_surface(pd_ctx *ctx, pd_flow *flow, int shape, const double *lo, const double *hi, double *force,
                      double *friction, double *pressure)
{
    pdi_force_query q;
    memset(&q, 0, sizeof q);
    q.flow = flow;
    q.lo = lo;
    q.hi = hi;
    q.shape = shape;
    pdi_flow_prepare(ctx, flow);
    for (int32_t r = 0; r < flow->bonds->rows; r++) {
        double x[PD_DIM], rub[PD_DIM], press[PD_DIM];
        pd_grid_position(flow->grid, flow->bonds->node[r], x);
        int inside = pdi_grid_between(flow->grid, lo, hi, x);
        if (inside) pdi_force_rub(&q, r, rub);
        pdi_force_press(&q, r, press);
        for (int d = 0; d < PD_DIM; d++) {
            if (inside) pdi_sum_add(&q.sum[d], flow->rho * rub[d]);
            pdi_sum_add(&q.sum[PD_DIM + d], flow->rho * press[d]);
        }
        if (flow->bonds->smooth[r] && !flow->grid->circumference) pdi_force_take(&q, r);
    }
    pdi_force_weigh(&q);
    for (int d = 0; d < PD_DIM; d++) {
        double f = pdi_sum_total(&q.sum[d]), p = pdi_sum_total(&q.sum[PD_DIM + d]);
        force[d] = f + p;
        if (friction) friction[d] = f;
        if (pressure) pressure[d] = p;
    }
    pdi_force_cancel(flow->grid, force);
    if (friction) pdi_force_cancel(flow->grid, friction);
    if (pressure) pdi_force_cancel(flow->grid, pressure);
}

/* ---- pressure at a place ---- */

/* Nodes that count lie within this squared distance [cells] of the one that sees them. */
#define PDI_FORCE_NEAR 5
#define PDI_FORCE_SEEN 57
/* [cells] Furthest surface whose slope counts. */
#define PDI_FORCE_BESIDE 1.5
#define PDI_FORCE_TERMS (PD_DIM + 1)
/* Normal velocities whose moments, over their own, have a pivot below this are not told apart. */
#define PDI_FORCE_DEPENDS 1e-4
/* [cells] Step of differences of a distance; a place that is nearer to a surface lies on it. */
#define PDI_FORCE_STEP 1e-3

typedef struct pdi_force_sight {
    const pd_bonds *bonds;
    int count;
    int32_t node[PDI_FORCE_SEEN];
    int step[PDI_FORCE_SEEN][PD_DIM]; /* from the first one */
    double place[PD_DIM], normal[PD_DIM]; /* the surface beside what is asked for */
    int32_t closed;
} pdi_force_sight;

static void pdi_force_add(pdi_force_sight *sight, int32_t node, const int *step)
{
    int square = 0;
    for (int d = 0; d < PD_DIM; d++) square += step[d] * step[d];
    if (square > PDI_FORCE_NEAR || sight->count == PDI_FORCE_SEEN) return;
    for (int q = 0; q < sight->count; q++)
        if (sight->node[q] == node) return;
    sight->node[sight->count] = node;
    memcpy(sight->step[sight->count++], step, sizeof sight->step[0]);
}

/* The node, those that its bonds to the cells around it lead to, and those that the bonds of these lead to. */
static void pdi_force_look(pdi_force_sight *sight, int32_t node)
{
    const pd_bonds *bonds = sight->bonds;
    const pd_stencil *s = bonds->stencil;
    int start = 0, none[PD_DIM];
    memset(none, 0, sizeof none);
    sight->count = 0;
    pdi_force_add(sight, node, none);
    for (int pass = 0; pass < 2; pass++) {
        int end = sight->count;
        for (int q = start; q < end; q++) {
            int32_t row = bonds->row[sight->node[q]];
            if (bonds->grid->kind[sight->node[q]] != PD_FLUID) continue;
            for (int k = 0; k < s->count; k++) {
                int32_t far = sight->node[q] + bonds->paths.shift[k];
                int step[PD_DIM], most = 0;
                for (int d = 0; d < PD_DIM; d++) {
                    int n = s->offset[k * PD_DIM + d];
                    step[d] = sight->step[q][d] + n;
                    most = n > most ? n : -n > most ? -n : most;
                }
                if (most > 1 || bonds->grid->kind[far] == PD_INLET || (row >= 0 && !pdi_bond_open(bonds, row, k)))
                    continue;
                pdi_force_add(sight, far, step);
            }
        }
        start = end;
    }
}

/* Distance [m] of x from the surface, and the normal of that. 0: it is not known. */
static int pdi_force_rise(const pdi_force_sight *sight, const double *x, double *distance, double *normal)
{
    const pd_bonds *bonds = sight->bonds;
    int i[PD_DIM];
    double at[PD_DIM];
    pdi_grid_index(bonds->grid, sight->closed, i);
    memcpy(normal, sight->normal, sizeof sight->normal);
    for (int d = 0; d < PD_DIM; d++) at[d] = x[d] - sight->place[d];
    *distance = pdi_vec_dot(at, normal);
    if (!pdi_grid_inside(bonds->grid, i)) return 1;
    double level = pdi_bond_smooth(bonds, sight->closed, sight->place);
    if (!(fabs(level) < PDI_FORCE_STEP * pdi_vec_least(bonds->grid->h))) return 0;
    return pdi_surface_rise(bonds, sight->closed, x, PDI_FORCE_STEP, distance, normal);
}

/* Slope of the pressure along the normal: what friction of the normal velocity, which begins with the square of the
 * distance, and the body force leave (eq. 3.11b). 0: it is not known. */
static int pdi_force_lean(const pdi_force_sight *sight, const pd_flow *flow, double *slope)
{
    enum { terms = PDI_FORCE_TERMS };
    const pd_grid *grid = flow->grid;
    double moment[PDI_FORCE_TERMS * PDI_FORCE_TERMS], right[PDI_FORCE_TERMS], least[PDI_FORCE_TERMS];
    double unit[PDI_FORCE_TERMS], h = grid->h[0];
    int last = 0;
    memset(moment, 0, sizeof moment);
    memset(right, 0, sizeof right);
    for (int d = 1; d < PD_DIM; d++)
        if (fabs(sight->normal[d]) > fabs(sight->normal[last])) last = d;
    for (int q = 0; q < sight->count; q++) {
        double x[PD_DIM], normal[PD_DIM], d, speed = 0.0, square = 0.0, term[PDI_FORCE_TERMS];
        pd_grid_position(grid, sight->node[q], x);
        if (!pdi_force_rise(sight, x, &d, normal)) return 0;
        d /= h;
        term[0] = d * d;
        term[1] = d * d * d;
        for (int a = 0, at = 2; a < PD_DIM; a++) {
            double way = (x[a] - sight->place[a]) / h;
            square += way * way;
            speed += normal[a] * flow->u[(int64_t)a * grid->total + sight->node[q]];
            if (a != last) term[at++] = d * d * (way - d * sight->normal[a]);
        }
        if (!(square > 0.0)) return 0;
        for (int a = 0; a < terms; a++) {
            right[a] += term[a] * speed / (square * square);
            for (int b = 0; b < terms; b++) moment[a * terms + b] += term[a] * term[b] / (square * square);
        }
    }
    for (int a = 0; a < terms; a++) {
        if (!(moment[a * terms + a] > 0.0)) return 0;
        least[a] = PDI_FORCE_DEPENDS;
        unit[a] = 1.0 / sqrt(moment[a * terms + a]);
    }
    for (int a = 0; a < terms; a++) {
        right[a] *= unit[a];
        for (int b = 0; b < terms; b++) moment[a * terms + b] *= unit[a] * unit[b];
    }
    if (!pdi_vec_factor_any(terms, terms, least, moment)) return 0;
    pdi_vec_substitute(terms, terms, moment, right);
    *slope = flow->nu * 2.0 * right[0] * unit[0] / (h * h);
    double push[PD_DIM];
    memset(push, 0, sizeof push);
    if (flow->push) flow->push(flow->push_user, sight->place, push);
    for (int d = 0; d < PD_DIM; d++) *slope += sight->normal[d] * (flow->force[d] + push[d]);
    return 1;
}

PDI_FN double pdi_force_pressure(const pd_bonds *bonds, const pd_flow *flow, const double *p, int32_t node,
                                 const double *x)
{
    pdi_force_sight sight;
    pdi_quadratic fit;
    double at[PD_DIM], slope, square = 0.0, moves = 0.0;
    sight.bonds = bonds;
    pdi_force_look(&sight, node);
    pdi_quadratic_start(&fit, x, bonds->grid->h);
    for (int q = 0; q < sight.count; q++) {
        pd_grid_position(bonds->grid, sight.node[q], at);
        pdi_quadratic_value(&fit, at, p[sight.node[q]]);
    }
    if (!flow || !pdi_surface_meet(bonds, node, x, sight.place, sight.normal, &sight.closed))
        return pdi_quadratic_solve(&fit);
    for (int d = 0; d < PD_DIM; d++) {
        double way = (sight.place[d] - x[d]) / bonds->grid->h[d];
        square += way * way;
        at[d] = 0.0;
    }
    if (flow->wall) flow->wall(flow->wall_user, sight.place, at);
    for (int d = 0; d < PD_DIM; d++) moves = pdi_max(moves, fabs(at[d]));
    if (square < PDI_FORCE_BESIDE * PDI_FORCE_BESIDE && !(moves > 0.0) && pdi_force_lean(&sight, flow, &slope))
        pdi_quadratic_slope(&fit, sight.place, sight.normal, slope);
    return pdi_quadratic_solve(&fit);
}

#undef PDI_FORCE_NEAR
#undef PDI_FORCE_SEEN
#undef PDI_FORCE_BESIDE
#undef PDI_FORCE_TERMS
#undef PDI_FORCE_DEPENDS
#undef PDI_FORCE_STEP

/* ---- around the body ---- */

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
    pdi_flow_prepare(ctx, flow);
    for (int axis = 0; axis < PD_DIM; axis++) PDI_TRY(pdi_force_sides(ctx, flow, first, last, axis, sum));
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM], within = 1;
        pdi_grid_index(grid, node, i);
        for (int d = 0; d < PD_DIM; d++) within = within && i[d] >= first[d] && i[d] <= last[d];
        if (within) fluid += pdi_force_excess(grid, PD_FORCE_ALL, node);
        if (!within || grid->kind[node] != PD_FLUID) continue;
        fluid += pdi_grid_circumference(grid, node);
        for (int d = 0; d < PD_DIM && flow->body; d++)
            pdi_sum_add(&sum[d], flow->rho * flow->body[(int64_t)d * grid->total + node] *
                                     pdi_grid_circumference(grid, node) * flow->bonds->stencil->volume);
    }
    for (int d = 0; d < PD_DIM; d++)
        force[d] = pdi_sum_total(&sum[d]) + flow->rho * flow->force[d] * fluid * flow->bonds->stencil->volume;
    pdi_force_cancel(grid, force);
    return PD_OK;
}
