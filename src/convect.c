/* convect: see convect.h
 *
 * Design: the volume fluxes of the bonds hold during a step, so they are stored, once for both ends: bond k of node i
 * is bond count-1-k of its far end. Sweeps go bond by bond over up to PDI_LANES nodes along axis 0. Closed bonds carry
 * and conduct zero.
 */
#include "convect.h"
#include "par.h"
#include <math.h>
#include <string.h>

/* Share of xi.G in the antidiffusive fluxes: damps what alternates from node to node, which a central flux does not
 * see. */
#define PDI_CONVECT_LEAN 0.3

/* Where F of bond k of the nodes from i stands, and the factor that it is to be taken with. */
static double *pdi_convect_slot(const pd_convect *t, int32_t i, int k, double *factor)
{
    const pd_bonds *bonds = t->bonds;
    int64_t total = bonds->grid->total;
    int count = bonds->stencil->count, back = count - 1 - k;
    int32_t j = i + bonds->shift[k];
    *factor = 1.0;
    if (k < count / 2) return t->flux + k * total + i;
    *factor = -pdi_grid_circumference(bonds->grid, j) / pdi_grid_circumference(bonds->grid, i);
    return t->flux + back * total + j;
}

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

/* ---- what holds during a step ---- */

/* Volume fluxes of bond k of `count` nodes from i (as pdi_flow_bond_flux), tied by the pressure. */
static void pdi_convect_volume(const pd_flow *f, int32_t i, int k, int count, double *PD_RESTRICT flux)
{
    const pd_stencil *st = f->bonds->stencil;
    int64_t total = f->grid->total, shift = f->bonds->shift[k];
    const double *p = f->p + i, *u = f->carrier + i, *grad = f->grad + i, *g = st->grad + k * PD_DIM;
    double tie = f->tau * pdi_bond_lap(f->bonds, i)[k], share = pdi_bond_flux(f->bonds, i, k);
    for (int b = 0; b < count; b++) {
        double pressure = p[b + shift] - p[b], sum = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            sum += share * g[d] * (u[d * total + b] + u[d * total + b + shift]);
            pressure -= 0.5 * st->xi[k * PD_DIM + d] * (grad[d * total + b] + grad[d * total + b + shift]);
        }
        flux[b] = sum - tie * pressure;
    }
}

/* Fluxes of bond k of the nodes i .. i+count-1: nodes of the first half of a family keep them; of the others those that
 * end on ghosts, which have none of their own. */
static void pdi_convect_store(const pd_convect *t, int32_t i, int32_t row, int k, int count)
{
    const pd_bonds *bonds = t->bonds;
    int32_t shift = bonds->shift[k];
    int own = k < bonds->stencil->count / 2, ghosts = 0;
    double flux[PDI_LANES], gate[PDI_LANES], factor, *slot = pdi_convect_slot(t, i, k, &factor);
    for (int b = 0; b < count && !own; b++) ghosts += bonds->grid->kind[i + b + shift] != PD_FLUID;
    if (!own && !ghosts) return;
    pdi_lanes open = row < 0 ? PDI_LANES_ALL : pdi_bond_open_lanes(bonds, row, k, count, gate);
    pdi_convect_volume(t->flow, i, k, count, flux);
    for (int b = 0; b < count; b++) {
        uint8_t kind = bonds->grid->kind[i + b + shift];
        int shut = open == PDI_LANES_NONE || (open == PDI_LANES_SOME && !(gate[b] > 0.0));
        if (!own && kind == PD_FLUID) continue;
        if (kind == PD_INLET) flux[b] = pdi_flow_bond_flux(t->flow, i + b, k);
        slot[b] = shut ? 0.0 : flux[b] / factor;
    }
}

static void pdi_convect_refresh_run(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pd_convect *t = (const pd_convect *)user;
    int count;
    for (int32_t at = 0; at < length; at += count) {
        count = pdi_bond_piece(length, &at);
        int32_t r = row < 0 ? row : row + at;
        for (int k = 0; k < t->bonds->stencil->count; k++) {
            double *conduct = r < 0 ? NULL : t->conduct + (int64_t)k * t->capacity + r;
            if (t->flow) pdi_convect_store(t, i + at, r, k, count);
            if (!conduct) continue;
            pdi_diffusion_bond(t->diffusion, i + at, k, count, 1, conduct);
            for (int b = 0; b < count; b++)
                if (!pdi_bond_open(t->bonds, r + b, k)) conduct[b] = 0.0;
        }
    }
}

PDI_FN pd_status pdi_convect_refresh(pd_ctx *ctx, const pd_convect *convect)
{
    const pd_bonds *bonds = convect->bonds;
    if (bonds->rows > convect->capacity)
        return pdi_fail(ctx, PD_ERR_STATE, "convect",
                        "%d rows, expected at most %d: call pd_transport_update after pd_bonds_update", bonds->rows,
                        convect->capacity);
    pdi_bond_sweep(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count * 8, pdi_convect_refresh_run, convect);
    return PD_OK;
}

/* ---- sweeps ---- */

/* What a sweep does with its nodes: y = A c, or the limited antidiffusive fluxes y. */
typedef struct pdi_convect_sweep pdi_convect_sweep;
typedef void (*pdi_convect_lanes_fn)(const pdi_convect_sweep *s, int32_t i, int32_t row, int count, int ends);

struct pdi_convect_sweep {
    const pd_convect *t;
    const double *c;
    double *y;
    pdi_convect_lanes_fn lanes;
};

/* One bond of `count` nodes. */
typedef struct pdi_convect_lanes {
    int count;
    const double *c, *far;  /* at its ends [mol/m3] */
    const double *flux;     /* F over factor [1/s]; NULL: fluid at rest */
    double factor;
    const double *bond;     /* conductances [1/s] */
    double space[PDI_LANES]; /* for `bond` of whole families */
    double edge[PDI_LANES];  /* for `far`, beside outlets: they take c of the node, and only move with the flow */
} pdi_convect_lanes;

/* Bond k of the nodes i .. i+count-1, which are the rows from `row` (-1: whole families). */
static void pdi_convect_bond_lanes(const pdi_convect_sweep *s, int32_t i, int32_t row, int k, int ends,
                                   pdi_convect_lanes *l)
{
    const pd_convect *t = s->t;
    int32_t shift = t->bonds->shift[k];
    l->c = s->c + i;
    l->far = l->c + shift;
    l->bond = row < 0 ? l->space : t->conduct + (int64_t)k * t->capacity + row;
    if (row < 0) pdi_diffusion_bond(t->diffusion, i, k, l->count, 0, l->space);
    l->flux = t->flow ? pdi_convect_slot(t, i, k, &l->factor) : NULL;
    for (int b = 0; b < l->count && ends; b++)
        l->edge[b] = t->bonds->grid->kind[i + b + shift] == PD_OUTLET ? l->c[b] : l->far[b];
    if (ends) l->far = l->edge;
}

/* sum += what leaves the nodes through the bond (eq. 5.1): conductances are at least |F|/2. */
static void pdi_convect_leave(const pdi_convect_lanes *l, double *PD_RESTRICT sum)
{
    const double *c = l->c, *far = l->far, *flux = l->flux, *bond = l->bond;
    double part = 0.5 * l->factor;
    int count = l->count;
    if (!flux) {
        for (int b = 0; b < count; b++) sum[b] -= bond[b] * (far[b] - c[b]);
        return;
    }
    for (int b = 0; b < count; b++) {
        double half = part * flux[b], size = fabs(half), least = bond[b];
        sum[b] += half * (c[b] + far[b]) - (size > least ? size : least) * (far[b] - c[b]);
    }
}

static void pdi_convect_apply_lanes(const pdi_convect_sweep *s, int32_t i, int32_t row, int count, int ends)
{
    const pd_convect *t = s->t;
    const double *c = s->c + i;
    double sum[PDI_LANES], rate = t->rate;
    pdi_convect_lanes l;
    l.count = count;
    for (int b = 0; b < count; b++) sum[b] = (rate + t->absorb[i + b]) * c[b];
    for (int b = 0; b < count && t->diffusion->hold; b++) sum[b] += t->diffusion->hold[i + b] * c[b];
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        pdi_convect_bond_lanes(s, i, row, k, ends, &l);
        pdi_convect_leave(&l, sum);
    }
    memcpy(s->y + i, sum, (size_t)count * sizeof(double));
}

/* sum -= alpha d s: the step s of the field along bond k, leant towards xi.G of the upwind end, within 0 and 2 s; alpha
 * of that end, and d what upwinding adds to the conductance (eq. 5.4). An inlet (lean[b] = 0) has no gradient. */
static void pdi_convect_return(const pd_limiter *limiter, int32_t i, int k, const pdi_convect_lanes *l,
                               const double *PD_RESTRICT lean, double *PD_RESTRICT sum)
{
    const double *bond = l->bond, *c = l->c, *far = l->far, *flux = l->flux;
    const double *slope = limiter->slope + i, *keep = limiter->keep + i;
    int64_t total = limiter->bonds->grid->total, shift = limiter->bonds->shift[k];
    double xi[PD_DIM], factor = l->factor;
    int count = l->count;
    for (int d = 0; d < PD_DIM; d++) xi[d] = limiter->bonds->stencil->xi[k * PD_DIM + d];
    for (int b = 0; b < count; b++) {
        double f = factor * flux[b], step = far[b] - c[b], near_x = 0.0, far_x = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            near_x += xi[d] * slope[d * total + b];
            far_x += xi[d] * slope[d * total + b + shift];
        }
        double near_keep = keep[b], far_keep = keep[b + shift];
        double x = f > 0.0 ? near_x : far_x, alpha = f > 0.0 ? near_keep : far_keep;
        double mixed = (1.0 - lean[b]) * step + lean[b] * x, twice = 2.0 * step;
        double low = twice < 0.0 ? twice : 0.0, high = twice > 0.0 ? twice : 0.0;
        double excess = 0.5 * fabs(f) - bond[b];
        mixed = mixed > low ? mixed : low;
        mixed = mixed < high ? mixed : high;
        sum[b] -= alpha * (excess > 0.0 ? excess : 0.0) * mixed;
    }
}

/* How far the steps of bond k lean: not at all where they come from an inlet. */
static void pdi_convect_leans(const pd_convect *t, int32_t i, int k, const pdi_convect_lanes *l, double *lean)
{
    const uint8_t *kind = t->bonds->grid->kind + i + t->bonds->shift[k];
    for (int b = 0; b < l->count; b++)
        lean[b] = kind[b] == PD_INLET && l->factor * l->flux[b] <= 0.0 ? 0.0 : PDI_CONVECT_LEAN;
}

static void pdi_convect_anti_lanes(const pdi_convect_sweep *s, int32_t i, int32_t row, int count, int ends)
{
    double sum[PDI_LANES], lean[PDI_LANES];
    pdi_convect_lanes l;
    memset(sum, 0, sizeof sum);
    l.count = count;
    for (int b = 0; b < count; b++) lean[b] = PDI_CONVECT_LEAN;
    for (int k = 0; k < s->t->bonds->stencil->count; k++) {
        pdi_convect_bond_lanes(s, i, row, k, ends, &l);
        if (ends) pdi_convect_leans(s->t, i, k, &l, lean);
        pdi_convect_return(s->t->limiter, i, k, &l, lean, sum);
    }
    memcpy(s->y + i, sum, (size_t)count * sizeof(double));
}

static void pdi_convect_run(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pdi_convect_sweep *s = (const pdi_convect_sweep *)user;
    int count;
    for (int32_t at = 0; at < length; at += count) {
        count = pdi_bond_piece(length, &at);
        s->lanes(s, i + at, row < 0 ? row : row + at, count, pdi_limiter_ports(s->t->bonds, i + at, count));
    }
}

static void pdi_convect_sweep_all(const pd_ctx *ctx, const pd_convect *convect, pdi_convect_lanes_fn lanes,
                                  const double *c, double *y)
{
    const pd_bonds *bonds = convect->bonds;
    pdi_convect_sweep s;
    s.t = convect;
    s.c = c;
    s.y = y;
    s.lanes = lanes;
    pdi_bond_sweep(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count * 2, pdi_convect_run, &s);
}

PDI_FN void pdi_convect_apply(const pd_ctx *ctx, const pd_convect *convect, const double *c, double *y)
{
    pdi_convect_sweep_all(ctx, convect, pdi_convect_apply_lanes, c, y);
}

PDI_FN void pdi_convect_anti(const pd_ctx *ctx, const pd_convect *convect, const double *c, double *y)
{
    pdi_convect_sweep_all(ctx, convect, pdi_convect_anti_lanes, c, y);
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
    double lean, gain = 0.0;
    if (t->bonds->grid->kind[i] != PD_FLUID) {
        double over = pdi_grid_circumference(t->bonds->grid, j) / pdi_grid_circumference(t->bonds->grid, i);
        return -over * pdi_convect_section_anti(section, j, t->bonds->stencil->count - 1 - k);
    }
    s.t = t;
    s.c = section->c;
    l.count = 1;
    pdi_convect_bond_lanes(&s, i, t->bonds->row[i], k, pdi_limiter_ports(t->bonds, i, 1), &l);
    pdi_convect_leans(t, i, k, &l, &lean);
    pdi_convect_return(t->limiter, i, k, &l, &lean, &gain);
    return gain;
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

PDI_FN pd_status pdi_convect_fit(pd_ctx *ctx, pd_convect *convect)
{
    int64_t count = convect->bonds->stencil->count;
    int32_t rows = convect->bonds->capacity;
    if (rows == convect->capacity) return PD_OK;
    PDI_DELETE(ctx, count * convect->capacity, convect->conduct);
    convect->capacity = 0;
    PDI_TRY(PDI_NEW(ctx, "convect", count * rows, convect->conduct));
    convect->capacity = rows;
    return PD_OK;
}

PDI_FN pd_status pdi_convect_build(pd_ctx *ctx, pd_convect *convect)
{
    const pd_bonds *bonds = convect->bonds;
    if (convect->flow)
        PDI_TRY(PDI_NEW(ctx, "convect", bonds->stencil->count / 2 * (int64_t)bonds->grid->total, convect->flux));
    return pdi_convect_fit(ctx, convect);
}

PDI_FN void pdi_convect_free(pd_ctx *ctx, pd_convect *convect)
{
    const pd_bonds *bonds = convect->bonds;
    if (!bonds) return;
    PDI_DELETE(ctx, bonds->stencil->count / 2 * (int64_t)bonds->grid->total, convect->flux);
    PDI_DELETE(ctx, (int64_t)bonds->stencil->count * convect->capacity, convect->conduct);
    convect->capacity = 0;
}
