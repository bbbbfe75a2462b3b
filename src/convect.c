/* convect: see convect.h
 *
 * Design: bond fluxes are evaluated from the flow on the fly, bond by bond for up to PDI_LANES neighbours along axis 0.
 * A gate shuts the bonds that take no part.
 */
#include "convect.h"
#include "par.h"
#include <math.h>
#include <string.h>

/* Share of xi.G in the antidiffusive fluxes: damps what alternates from node to node, which a central flux does not
 * see. */
#define PDI_CONVECT_LEAN 0.3

PDI_FN void pdi_convect_bond(const pd_convect *t, int32_t i, int k, double *flux, double *bond, double *upwind)
{
    pdi_diffusion_bond(t->diffusion, i, k, 1, t->bonds->row[i] >= 0, bond);
    *flux = t->flow ? pdi_flow_bond_flux(t->flow, i, k) : 0.0;
    *upwind = fmax(0.5 * fabs(*flux) - *bond, 0.0);
}

PDI_FN double pdi_convect_bond_flux(const pd_convect *t, const double *c, int32_t i, int k)
{
    double flux, bond, upwind;
    int32_t j = i + t->bonds->shift[k];
    pdi_convect_bond(t, i, k, &flux, &bond, &upwind);
    if (t->bonds->grid->kind[j] == PD_OUTLET) return flux * c[i];
    return 0.5 * flux * (c[i] + c[j]) - (bond + upwind) * (c[j] - c[i]);
}

PDI_FN int pdi_convect_open(const pd_convect *t, int32_t i, int k)
{
    int32_t r = t->bonds->row[i];
    return r < 0 || pdi_bond_open(t->bonds, r, k);
}

/* What a sweep does with its nodes: y = A c, or the limited antidiffusive fluxes y. */
typedef enum pdi_convect_task {
    PDI_CONVECT_APPLY,
    PDI_CONVECT_ANTI
} pdi_convect_task;

typedef struct pdi_convect_sweep {
    pdi_convect_task task;
    const pd_convect *t;
    const double *c;
    double *y;
} pdi_convect_sweep;

/* One bond of the nodes i .. i+count-1: what the tasks need of it. */
typedef struct pdi_convect_lanes {
    int count;
    int gated;          /* 0: all gates are open */
    const double *far;  /* c at the far ends [mol/m3] */
    double gate[PDI_LANES];   /* 1.0: takes part, 0.0: does not */
    double bond[PDI_LANES];   /* conductance [1/s] */
    double flux[PDI_LANES];   /* F [1/s] */
    double upwind[PDI_LANES]; /* diffusion that upwinding adds to `bond` [1/s] */
    double edge[PDI_LANES];   /* holds far values beside outlets */
} pdi_convect_lanes;

/* Volume fluxes of bond k (as pdi_flow_bond_flux). tied: 0 where the bond carries no pressure; NULL: everywhere 1. */
static void pdi_convect_flux(const pd_convect *t, int32_t i, int k, const double *tied, pdi_convect_lanes *l)
{
    const pd_stencil *st = t->bonds->stencil;
    const pd_flow *f = t->flow;
    int64_t total = t->bonds->grid->total, shift = t->bonds->shift[k];
    const double *p = f->p + i, *u = f->carrier + i, *grad = f->grad + i, *g = st->grad + k * PD_DIM;
    double tie = f->tau * pdi_bond_lap(t->bonds, i)[k], share = pdi_bond_flux(t->bonds, i, k), arm[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) arm[d] = 0.5 * st->xi[k * PD_DIM + d];
    for (int b = 0; b < l->count; b++) {
        double pressure = p[b + shift] - p[b], flux = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            flux += share * g[d] * (u[d * total + b] + u[d * total + b + shift]);
            pressure -= arm[d] * (grad[d * total + b] + grad[d * total + b + shift]);
        }
        flux -= (tied ? tied[b] : 1.0) * tie * pressure;
        double excess = 0.5 * fabs(flux) - l->bond[b];
        l->flux[b] = flux;
        l->upwind[b] = excess > 0.0 ? excess : 0.0;
    }
}

/* Beside inlets and outlets: an outlet takes c of the node, and only moves with the flow. */
static void pdi_convect_ends(const pdi_convect_sweep *s, int32_t i, int k, double *tied, pdi_convect_lanes *l)
{
    int32_t shift = s->t->bonds->shift[k];
    for (int b = 0; b < l->count; b++) {
        uint8_t kind = s->t->bonds->grid->kind[i + b + shift];
        tied[b] = kind == PD_INLET ? 0.0 : 1.0;
        l->edge[b] = kind == PD_OUTLET ? s->c[i + b] : l->far[b];
        if (!l->gated) l->gate[b] = 1.0;
        if (kind == PD_OUTLET && s->task == PDI_CONVECT_ANTI) l->gate[b] = 0.0;
    }
    l->far = l->edge;
    l->gated = 1;
}

/* Bond k of the nodes i .. i+count-1, which are the rows from `row` (-1: whole families); 0 when it is shut for all. */
static int pdi_convect_bond_lanes(const pdi_convect_sweep *s, int32_t i, int32_t row, int k, int ends,
                                  pdi_convect_lanes *l)
{
    const pd_convect *t = s->t;
    double tied[PDI_LANES];
    pdi_lanes open = row < 0 ? PDI_LANES_ALL : pdi_bond_open_lanes(t->bonds, row, k, l->count, l->gate);
    if (open == PDI_LANES_NONE) return 0;
    l->gated = open == PDI_LANES_SOME;
    pdi_diffusion_bond(t->diffusion, i, k, l->count, row >= 0, l->bond);
    l->far = s->c + i + t->bonds->shift[k];
    if (ends) pdi_convect_ends(s, i, k, tied, l);
    if (t->flow) pdi_convect_flux(t, i, k, ends ? tied : NULL, l);
    return 1;
}

static void pdi_convect_apply_lanes(const pdi_convect_sweep *s, int32_t i, int32_t row, int count, int ends)
{
    const pd_convect *t = s->t;
    const double *c = s->c + i;
    double sum[PDI_LANES], rate = t->rate;
    pdi_convect_lanes l;
    memset(&l, 0, sizeof l);
    l.count = count;
    for (int b = 0; b < count; b++) sum[b] = (rate + t->absorb[i + b]) * c[b];
    for (int b = 0; b < count && t->diffusion->hold; b++) sum[b] += t->diffusion->hold[i + b] * c[b];
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        if (!pdi_convect_bond_lanes(s, i, row, k, ends, &l)) continue;
        for (int b = 0; b < count; b++) {
            double flux = 0.5 * l.flux[b] * (c[b] + l.far[b]) - (l.bond[b] + l.upwind[b]) * (l.far[b] - c[b]);
            sum[b] += l.gated ? l.gate[b] * flux : flux;
        }
    }
    memcpy(s->y + i, sum, (size_t)count * sizeof(double));
}

/* Of bond k: the step D of the field along it, leant towards xi.G of the upwind end, within 0 and 2 D (eq. 5.4). An
 * inlet has no gradient. */
static void pdi_convect_lean(const pdi_convect_sweep *s, int32_t i, int k, int ends, const pdi_convect_lanes *l,
                             double *lean)
{
    const pd_convect *t = s->t;
    int64_t total = t->bonds->grid->total;
    int32_t shift = t->bonds->shift[k];
    const double *c = s->c + i, *slope = t->limiter->slope + i, *xi = t->bonds->stencil->xi + k * PD_DIM;
    for (int b = 0; b < l->count; b++) {
        double step = l->far[b] - c[b], near_x = 0.0, far_x = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            near_x += xi[d] * slope[d * total + b];
            far_x += xi[d] * slope[d * total + b + shift];
        }
        double x = l->flux[b] > 0.0 ? near_x : far_x;
        double mixed = (1.0 - PDI_CONVECT_LEAN) * step + PDI_CONVECT_LEAN * x, twice = 2.0 * step;
        double low = twice < 0.0 ? twice : 0.0, high = twice > 0.0 ? twice : 0.0;
        mixed = mixed > low ? mixed : low;
        lean[b] = mixed < high ? mixed : high;
    }
    for (int b = 0; b < l->count && ends; b++)
        if (l->flux[b] <= 0.0 && t->bonds->grid->kind[i + b + shift] == PD_INLET) lean[b] = l->far[b] - c[b];
}

/* y_i = - sum alpha d s with s of pdi_convect_lean and alpha of the upwind end of the bond (eq. 5.4). */
static void pdi_convect_anti_lanes(const pdi_convect_sweep *s, int32_t i, int32_t row, int count, int ends)
{
    const pd_convect *t = s->t;
    const double *keep = t->limiter->keep + i;
    double sum[PDI_LANES], lean[PDI_LANES];
    pdi_convect_lanes l;
    memset(sum, 0, sizeof sum);
    memset(&l, 0, sizeof l);
    l.count = count;
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        int32_t shift = t->bonds->shift[k];
        if (!pdi_convect_bond_lanes(s, i, row, k, ends, &l)) continue;
        pdi_convect_lean(s, i, k, ends, &l, lean);
        for (int b = 0; b < count; b++) {
            double flux = (l.flux[b] > 0.0 ? keep[b] : keep[b + shift]) * l.upwind[b] * lean[b];
            sum[b] -= l.gated ? l.gate[b] * flux : flux;
        }
    }
    memcpy(s->y + i, sum, (size_t)count * sizeof(double));
}

static void pdi_convect_run(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pdi_convect_sweep *s = (const pdi_convect_sweep *)user;
    int count;
    for (int32_t at = 0; at < length; at += count) {
        count = pdi_bond_piece(length, &at);
        int32_t r = row < 0 ? row : row + at;
        int ends = pdi_limiter_ports(s->t->bonds, i + at, count);
        if (s->task == PDI_CONVECT_APPLY) pdi_convect_apply_lanes(s, i + at, r, count, ends);
        else pdi_convect_anti_lanes(s, i + at, r, count, ends);
    }
}

static void pdi_convect_sweep_all(const pd_ctx *ctx, const pd_convect *convect, pdi_convect_task task, const double *c,
                                  double *y)
{
    const pd_bonds *bonds = convect->bonds;
    pdi_convect_sweep s;
    s.task = task;
    s.t = convect;
    s.c = c;
    s.y = y;
    pdi_bond_sweep(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count * 8, pdi_convect_run, &s);
}

PDI_FN void pdi_convect_apply(const pd_ctx *ctx, const pd_convect *convect, const double *c, double *y)
{
    pdi_convect_sweep_all(ctx, convect, PDI_CONVECT_APPLY, c, y);
}

PDI_FN void pdi_convect_anti(const pd_ctx *ctx, const pd_convect *convect, const double *c, double *y)
{
    pdi_convect_sweep_all(ctx, convect, PDI_CONVECT_ANTI, c, y);
}

/* What the bonds through a plane are asked for. */
typedef struct pdi_convect_section {
    const pd_convect *convect;
    const double *c;    /* [mol/m3] */
    const double *anti; /* [mol/m3/s] what the nodes gain by antidiffusion */
} pdi_convect_section;

/* Upwinded flux [mol/m3/s] of bond k of node i. One of both ends is fluid, the flux is told from there. */
static double pdi_convect_section_bond(const void *user, int32_t i, int k)
{
    const pdi_convect_section *section = (const pdi_convect_section *)user;
    const pd_convect *t = section->convect;
    int32_t j = i + t->bonds->shift[k];
    if (t->bonds->grid->kind[i] == PD_FLUID) return pdi_convect_bond_flux(t, section->c, i, k);
    double over = pdi_grid_circumference(t->bonds->grid, j) / pdi_grid_circumference(t->bonds->grid, i);
    return -over * pdi_convect_bond_flux(t, section->c, j, t->bonds->stencil->count - 1 - k);
}

/* What node i gains by the antidiffusive flux of bond k (eq. 5.4), likewise. */
static double pdi_convect_section_anti(const void *user, int32_t i, int k)
{
    const pdi_convect_section *section = (const pdi_convect_section *)user;
    const pd_convect *t = section->convect;
    int32_t j = i + t->bonds->shift[k];
    pdi_convect_sweep s;
    pdi_convect_lanes l;
    double lean;
    if (t->bonds->grid->kind[i] != PD_FLUID) {
        double over = pdi_grid_circumference(t->bonds->grid, j) / pdi_grid_circumference(t->bonds->grid, i);
        return -over * pdi_convect_section_anti(section, j, t->bonds->stencil->count - 1 - k);
    }
    memset(&s, 0, sizeof s);
    memset(&l, 0, sizeof l);
    s.t = t;
    s.c = section->c;
    s.task = PDI_CONVECT_ANTI;
    l.count = 1;
    int ports = pdi_limiter_ports(t->bonds, i, 1);
    if (!pdi_convect_bond_lanes(&s, i, t->bonds->row[i], k, ports, &l)) return 0.0;
    pdi_convect_lean(&s, i, k, ports, &l, &lean);
    return -(l.gated ? l.gate[0] : 1.0) * t->limiter->keep[l.flux[0] > 0.0 ? i : j] * l.upwind[0] * lean;
}

/* What passes the plane by antidiffusion is all that the nodes on one side of it gain, since the fluxes between them
 * cancel, unless inlets feed both sides or the axis is periodic: then bond by bond, up to what the limiter still
 * moves. */
static double pdi_convect_section_gain(const pdi_convect_section *section, int axis, int index)
{
    const pd_convect *t = section->convect;
    pdi_sum sum[2] = {{0.0, 0.0}, {0.0, 0.0}};
    int fed[2] = {0, 0};
    if (t->bonds->grid->side[2 * axis] == PD_SIDE_PERIODIC) fed[0] = fed[1] = 1;
    for (int32_t node = 0; node < t->bonds->grid->total; node++) {
        int i[PD_DIM];
        pdi_grid_index(t->bonds->grid, node, i);
        int behind = i[axis] >= index;
        if (t->bonds->grid->kind[node] == PD_INLET) fed[behind] = 1;
        if (t->bonds->grid->kind[node] != PD_FLUID) continue;
        pdi_sum_add(&sum[behind], section->anti[node] * pdi_grid_circumference(t->bonds->grid, node));
    }
    if (!fed[0]) return pdi_sum_total(&sum[0]);
    if (!fed[1]) return -pdi_sum_total(&sum[1]);
    return pdi_bond_section(t->bonds, axis, index, pdi_convect_section_anti, section);
}

PDI_FN double pdi_convect_through(const pd_convect *convect, const double *c, const double *anti, int axis, int index)
{
    pdi_convect_section section;
    section.convect = convect;
    section.c = c;
    section.anti = anti;
    double low = pdi_bond_section(convect->bonds, axis, index, pdi_convect_section_bond, &section);
    double gain = anti ? pdi_convect_section_gain(&section, axis, index) : 0.0;
    return (low - gain) * convect->bonds->stencil->volume;
}
