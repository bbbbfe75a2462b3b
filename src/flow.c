/* flow: see flow.h
 *
 * Design: sweeps work on blocks of neighbours along axis 0, bond by bond; their own values and their sums stay in
 * registers. All terms of a bond are taken in one pass. Rows blank out their closed bonds.
 */
#include "flow.h"
#include "op.h"
#include "par.h"
#include <math.h>
#include <string.h>

/* Work of a sweep in scalar operations, to decide on threads. */
static int64_t pdi_flow_work(const pd_flow *flow) { return flow->grid->fluid_count * flow->bonds->stencil->count * 4; }

PDI_FN void pdi_flow_gradient(const pd_ctx *ctx, const pd_flow *flow, const double *p, double *grad)
{
    pd_op_gradient(ctx, flow->bonds, p, grad);
    pd_ghosts_vector(&flow->bonds->ghosts, grad);
}

/* carrier = K v at `node` with the tensor of row r, mirrored along the axes of `odd`. */
static void pdi_flow_carry(const pd_flow *flow, int32_t r, int32_t node, int odd, const double *v, double *carrier)
{
    const double *k = flow->bonds->carrier + (int64_t)r * PD_DIM * PD_DIM;
    int64_t total = flow->grid->total;
    for (int a = 0; a < PD_DIM; a++) {
        double sum = 0.0;
        for (int b = 0; b < PD_DIM; b++) {
            double part = k[a * PD_DIM + b] * v[b * total + node];
            sum += ((odd >> a ^ odd >> b) & 1) ? -part : part;
        }
        carrier[a * total + node] = sum;
    }
}

PDI_FN void pdi_flow_carrier(const pd_ctx *ctx, const pd_flow *flow, const double *v, double *carrier)
{
    const pd_bonds *bonds = flow->bonds;
    const pd_ghosts *ghosts = &bonds->ghosts;
    int64_t total = flow->grid->total;
    int nt = pdi_par_threads(ctx, (int64_t)bonds->rows * PD_DIM * PD_DIM);
    (void)nt;
    pdi_par_copy(ctx, PD_DIM * total, v, carrier);
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++) pdi_flow_carry(flow, r, bonds->node[r], 0, v, carrier);
    /* inlet ghosts lie behind the same walls as the node that they mirror */
    for (int32_t g = ghosts->count; g < ghosts->listed; g++) {
        int32_t r = bonds->row[ghosts->source[g]];
        if (r >= 0) pdi_flow_carry(flow, r, ghosts->node[g], ghosts->odd[g], v, carrier);
    }
    pd_ghosts_vector(ghosts, carrier);
}

void pd_flow_prepare(pd_ctx *ctx, pd_flow *flow)
{
    pd_ghosts_vector(&flow->bonds->ghosts, flow->u);
    pd_ghosts_pressure(&flow->bonds->ghosts, flow->p_out, flow->p);
    pdi_flow_gradient(ctx, flow, flow->p, flow->grad);
    pdi_flow_carrier(ctx, flow, flow->u, flow->carrier);
}

/* Nodes of a block: one vector, or two short ones, so that all that belongs to its nodes stays in registers. */
#define PDI_FLOW_BLOCK PDI_VECTOR

/* Twice the sums of a block. The convective term is the skew-symmetric sum of 1/2 g.(w_i + w_j) v_j (eq. 4.3). That of
 * the velocity under the Laplacian is taken as v_i + (v_j - v_i), so that both terms share the difference. */
typedef struct pdi_flow_sums {
    double momentum[PD_DIM][PDI_FLOW_BLOCK]; /* convective and viscous terms but for v_i times the fluxes */
    double flux[PDI_FLOW_BLOCK];             /* of `mass` */
    double tie[PDI_FLOW_BLOCK];              /* fourth-order pressure difference (eq. 4.4) */
} pdi_flow_sums;

/* What a block of nodes i .. i+count-1 reads again for each of its bonds. */
typedef struct pdi_flow_own {
    double mass[PD_DIM][PDI_FLOW_BLOCK], u[PD_DIM][PDI_FLOW_BLOCK], grad[PD_DIM][PDI_FLOW_BLOCK], p[PDI_FLOW_BLOCK];
    double open[PDI_FLOW_BLOCK]; /* 1 or 0: the bond in hand is open or closed */
} pdi_flow_own;

PDI_INLINE void pdi_flow_own_load(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int count,
                                  pdi_flow_own *PD_RESTRICT own)
{
    for (int d = 0; d < PD_DIM; d++) {
        int64_t at = (int64_t)d * flow->grid->total + i;
        for (int b = 0; b < count; b++) own->mass[d][b] = t->mass[at + b];
        for (int b = 0; b < count; b++) own->u[d][b] = t->u[at + b];
        for (int b = 0; b < count; b++) own->grad[d][b] = t->grad[at + b];
    }
    for (int b = 0; b < count; b++) own->p[b] = t->p[i + b];
}

/* Add bond k of the nodes i .. i+count-1. open: 1 or 0 for each of them, NULL: 1. tied: 1, or 0 when the bond carries
 * no pressure. Inlined with constants for `count` and `open`. */
PDI_INLINE void pdi_flow_bond(const pd_flow *flow, const pdi_flow_terms *t, const pdi_flow_own *PD_RESTRICT own,
                              int32_t i, int k, int count, const double *PD_RESTRICT open, double tied,
                              pdi_flow_sums *PD_RESTRICT sums)
{
    const pd_stencil *s = flow->bonds->stencil;
    int64_t total = flow->grid->total, far = (int64_t)i + flow->bonds->shift[k];
    const double *mass = t->mass + far, *u = t->u + far, *p = t->p + far, *grad = t->grad + far;
    const double *g = s->grad + k * PD_DIM, *xi = s->xi + k * PD_DIM, *a = pdi_bond_lap(flow->bonds, i) + k;
    double twice_nu = 2.0 * flow->nu, share = pdi_bond_flux(flow->bonds, i, k);
    for (int b = 0; b < count; b++) {
        double flux = 0.0, tie = 2.0 * (p[b] - own->p[b]), gain;
        for (int d = 0; d < PD_DIM; d++) {
            flux += g[d] * (own->mass[d][b] + mass[d * total + b]);
            tie -= xi[d] * (own->grad[d][b] + grad[d * total + b]);
        }
        if (PD_DIM == 2) flux *= share; /* the circumference half way against that at the node; planar: 1 */
        gain = flux - twice_nu * *a;
        tie *= *a;
        if (open) {
            flux *= open[b];
            tie *= tied * open[b];
            gain *= open[b];
        }
        sums->flux[b] += flux;
        sums->tie[b] += tie;
        for (int d = 0; d < PD_DIM; d++) sums->momentum[d][b] += gain * (u[d * total + b] - own->u[d][b]);
    }
}

/* All bonds of nodes with whole families. Inlined with a constant for `count`. */
PDI_INLINE void pdi_flow_whole(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int count,
                               pdi_flow_own *PD_RESTRICT own, pdi_flow_sums *PD_RESTRICT sums)
{
    pdi_flow_own_load(flow, t, i, count, own);
    for (int k = 0; k < flow->bonds->stencil->count; k++)
        pdi_flow_bond(flow, t, own, i, k, count, NULL, 1.0, sums);
}

/* The bonds that the rows from r have open, likewise. Bonds to inlets carry no pressure. */
PDI_INLINE void pdi_flow_cut(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int32_t r, int count,
                             pdi_flow_own *PD_RESTRICT own, pdi_flow_sums *PD_RESTRICT sums)
{
    const pd_bonds *bonds = flow->bonds;
    pdi_bond_gate gate = {NULL, 0, 0, 0};
    pdi_flow_own_load(flow, t, i, count, own);
    for (int k = 0; k < bonds->stencil->count; k++) {
        pdi_lanes lanes = pdi_bond_gate_open(bonds, r, k, count, &gate, own->open);
        if (lanes == PDI_LANES_NONE) continue;
        double tied = r >= bonds->plain && flow->grid->kind[i + bonds->shift[k]] == PD_INLET ? 0.0 : 1.0;
        for (int b = 0; b < count && lanes == PDI_LANES_ALL; b++) own->open[b] = 1.0;
        pdi_flow_bond(flow, t, own, i, k, count, own->open, tied, sums);
    }
}

/* `count` consecutive nodes from i: the rows from `row`, or nodes with whole families (-1). The wall enters the
 * Laplacian through wall_lap, and the curvature of the velocity at the wall, known from the momentum balance there
 * (nu u'' = G - f), through wall_curv (eq. 3.3, 3.4). The radial component of a vector turns with the circumference:
 * lap u_r - u_r/r^2 (eq. 3.10). */
static void pdi_flow_block(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int32_t row, int count, double *ru,
                           double *rc)
{
    const pd_bonds *bonds = flow->bonds;
    const double *hoop = bonds->ring.hoop;
    int64_t total = flow->grid->total;
    enum { whole = PDI_FLOW_BLOCK };
    pdi_flow_own own;
    pdi_flow_sums sums;
    memset(&sums, 0, sizeof sums);
    if (count == whole && row < 0) pdi_flow_whole(flow, t, i, whole, &own, &sums);
    else if (count == whole) pdi_flow_cut(flow, t, i, row, whole, &own, &sums);
    else if (row < 0) pdi_flow_whole(flow, t, i, count, &own, &sums);
    else pdi_flow_cut(flow, t, i, row, count, &own, &sums);
    for (int b = 0; b < count; b++) rc[i + b] = sums.flux[b] - 0.5 * flow->tau * sums.tie[b];
    for (int d = 0; d < PD_DIM; d++) {
        double force = t->force ? t->force[d] : 0.0;
        double turn = hoop && d == PD_DIM - 1 ? hoop[i / flow->grid->stride[d]] : 0.0;
        for (int b = 0; b < count; b++) {
            int64_t at = d * total + i + b;
            double bend = 0.0, lap = turn;
            if (row >= 0) {
                lap += bonds->wall_lap[row + b];
                bend = bonds->wall_curv[row + b];
            }
            ru[at] = 0.5 * sums.momentum[d][b] + (0.5 * sums.flux[b] + flow->nu * lap) * t->u[at] +
                     (1.0 - bend) * (t->grad[at] - force);
            if (t->drive && row >= 0) ru[at] -= flow->nu * t->drive[at];
        }
    }
}

/* The operands of a sweep. */
typedef struct pdi_flow_sweep {
    const pd_flow *flow;
    const pdi_flow_terms *terms;
    double *ru, *rc; /* [m/s2] [1/s] */
} pdi_flow_sweep;

static void pdi_flow_run(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pdi_flow_sweep *s = (const pdi_flow_sweep *)user;
    pdi_flow_block(s->flow, s->terms, i, row, count, s->ru, s->rc);
}

PDI_FN void pdi_flow_terms_apply(const pd_ctx *ctx, const pd_flow *flow, const pdi_flow_terms *t, double *ru,
                                 double *rc)
{
    pdi_flow_sweep s;
    s.flow = flow;
    s.terms = t;
    s.ru = ru;
    s.rc = rc;
    pdi_bond_sweep(ctx, flow->bonds, pdi_flow_work(flow), PDI_FLOW_BLOCK, pdi_flow_run, &s);
}

/* Half the volume flux through a bond: 1/2 g.(w_i + w_j). */
static double pdi_flow_half_flux(const double *g, const double *w, int32_t i, int32_t j, int32_t total)
{
    double flux = 0.0;
    for (int d = 0; d < PD_DIM; d++) flux += 0.5 * g[d] * (w[(int64_t)d * total + i] + w[(int64_t)d * total + j]);
    return flux;
}

void pd_flow_residual(pd_ctx *ctx, pd_flow *flow, double *ru, double *rc)
{
    pdi_flow_terms t;
    memset(&t, 0, sizeof t);
    pd_flow_prepare(ctx, flow);
    t.mass = flow->carrier;
    t.u = flow->u;
    t.p = flow->p;
    t.grad = flow->grad;
    t.force = flow->force;
    t.drive = flow->drive;
    pdi_flow_terms_apply(ctx, flow, &t, ru, rc);
    flow->evaluations++;
}

PDI_FN double pdi_flow_bond_flux(const pd_flow *flow, int32_t i, int k)
{
    const pd_stencil *s = flow->bonds->stencil;
    int32_t total = flow->grid->total, j = i + flow->bonds->shift[k];
    double share = pdi_bond_flux(flow->bonds, i, k);
    double flux = 2.0 * share * pdi_flow_half_flux(s->grad + k * PD_DIM, flow->carrier, i, j, total);
    if (flow->potential) flux -= pdi_bond_lap(flow->bonds, i)[k] * (flow->potential[j] - flow->potential[i]);
    if (flow->grid->kind[i] == PD_INLET || flow->grid->kind[j] == PD_INLET) return flux;
    double tie = flow->p[j] - flow->p[i];
    for (int d = 0; d < PD_DIM; d++)
        tie -= 0.5 * s->xi[k * PD_DIM + d] * (flow->grad[(int64_t)d * total + i] + flow->grad[(int64_t)d * total + j]);
    return flux - flow->tau * pdi_bond_lap(flow->bonds, i)[k] * tie;
}

static double pdi_flow_section_bond(const void *user, int32_t i, int k)
{
    return pdi_flow_bond_flux((const pd_flow *)user, i, k);
}

double pd_flow_section(pd_ctx *ctx, pd_flow *flow, int axis, int index)
{
    pd_flow_prepare(ctx, flow);
    return pdi_bond_section(flow->bonds, axis, index, pdi_flow_section_bond, flow) * flow->bonds->stencil->volume;
}

PDI_FN double pdi_flow_entering(pd_ctx *ctx, pd_flow *flow, double *given)
{
    const pd_bonds *bonds = flow->bonds;
    const pd_grid *grid = flow->grid;
    const pd_stencil *s = bonds->stencil;
    double taken = 0.0, size = 0.0;
    *given = 0.0;
    pd_flow_prepare(ctx, flow);
    for (int32_t i = 0; i < grid->total; i++) {
        int32_t row = bonds->row[i];
        if (grid->kind[i] != PD_FLUID) continue;
        double volume = s->volume * pdi_grid_circumference(grid, i);
        for (int k = 0; k < s->count; k++) {
            int32_t j = i + bonds->shift[k];
            if (grid->kind[j] != PD_INLET || (row >= 0 && !pdi_bond_open(bonds, row, k))) continue;
            double share = 2.0 * pdi_bond_flux(bonds, i, k) * volume;
            double part = share * pdi_flow_half_flux(s->grad + k * PD_DIM, flow->carrier, j, j, grid->total);
            *given -= part;
            size += fabs(part);
            taken -= volume * pdi_flow_bond_flux(flow, i, k);
        }
    }
    /* inlets that feed each other */
    if (fabs(*given) < 1e-6 * size) *given = 0.0;
    return taken;
}

/* 1: an open bond of fluid node i ends on a node of the kind `port`. */
static int pdi_flow_beside(const pd_flow *flow, int32_t i, uint8_t port)
{
    const pd_bonds *bonds = flow->bonds;
    int32_t row = bonds->row[i];
    for (int k = 0; k < bonds->stencil->count; k++)
        if (flow->grid->kind[i + bonds->shift[k]] == port && (row < 0 || pdi_bond_open(bonds, row, k))) return 1;
    return 0;
}

/* Mark the fluid that the open bonds of i reach; how many nodes are new. */
static int64_t pdi_flow_spread(const pd_flow *flow, int32_t i, uint8_t *mark)
{
    const pd_bonds *bonds = flow->bonds;
    int64_t found = 0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        int32_t j = i + bonds->shift[k];
        if (bonds->row[i] >= 0 && !pdi_bond_open(bonds, bonds->row[i], k)) continue;
        if (flow->grid->kind[j] == PD_IMAGE) j = pdi_grid_image(flow->grid, j, NULL);
        if (flow->grid->kind[j] != PD_FLUID || mark[j]) continue;
        mark[j] = 1;
        found++;
    }
    return found;
}

PDI_FN pd_status pdi_flow_blocked(pd_ctx *ctx, const pd_flow *flow, int32_t *node)
{
    int32_t total = flow->grid->total;
    const uint8_t *kind = flow->grid->kind;
    uint8_t *mark = NULL;
    *node = -1;
    PDI_TRY(PDI_NEW(ctx, "flow", total, mark));
    for (int32_t i = 0; i < total; i++) mark[i] = kind[i] == PD_FLUID && pdi_flow_beside(flow, i, PD_OUTLET);
    for (int64_t found = 1, back = 0; found > 0; back = !back) {
        found = 0;
        for (int32_t n = 0; n < total; n++) {
            int32_t i = back ? total - 1 - n : n;
            if (mark[i]) found += pdi_flow_spread(flow, i, mark);
        }
    }
    for (int32_t i = 0; i < total && *node < 0; i++)
        if (kind[i] == PD_FLUID && !mark[i] && pdi_flow_beside(flow, i, PD_INLET)) *node = i;
    PDI_DELETE(ctx, total, mark);
    return PD_OK;
}

double pd_flow_section_nodes(pd_ctx *ctx, const pd_flow *flow, int axis, int index)
{
    const pd_grid *grid = flow->grid;
    double sum = 0.0, face = flow->bonds->stencil->volume / grid->h[axis];
    (void)ctx;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID) continue;
        pdi_grid_index(grid, node, i);
        if (i[axis] != index) continue;
        sum += flow->u[(int64_t)axis * grid->total + node] * face * pdi_grid_circumference(grid, node);
    }
    return sum;
}

/* Inlet values follow the kinds of the ghosts; behind periodic and mirror sides they are images too. */
static pd_status pdi_flow_inlets(pd_ctx *ctx, pd_flow *flow)
{
    const pd_grid *grid = flow->grid;
    for (int32_t node = 0; node < grid->total && flow->inlet; node++) {
        int i[PD_DIM];
        double x[PD_DIM], u[PD_DIM];
        if (grid->kind[node] != PD_INLET) continue;
        pdi_grid_index(grid, node, i);
        int flip = pdi_grid_fold(grid, i);
        pd_grid_position(grid, pd_grid_node(grid, i), x);
        flow->inlet(flow->inlet_user, x, u);
        for (int d = 0; d < PD_DIM; d++) {
            if (!(fabs(u[d]) < 1e100))
                return pdi_fail(ctx, PD_ERR_ARGUMENT, "flow", "the inlet velocity at (%g, ...) m is %g m/s", x[0],
                                u[d]);
            flow->u[(int64_t)d * grid->total + node] = flip >> d & 1 ? -u[d] : u[d];
        }
    }
    return PD_OK;
}

/* What moving walls do to the rows. */
static void pdi_flow_drive(pd_flow *flow)
{
    const pd_bonds *bonds = flow->bonds;
    double drive[PD_DIM];
    for (int32_t r = 0; r < bonds->rows && flow->wall; r++) {
        pdi_bond_drive(bonds, r, flow->wall, flow->wall_user, drive);
        for (int d = 0; d < PD_DIM; d++) flow->drive[(int64_t)d * flow->grid->total + bonds->node[r]] = drive[d];
    }
}

pd_status pd_flow_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow_desc *desc,
                        pd_flow *flow)
{
    memset(flow, 0, sizeof *flow);
    if (!(desc->rho > 0.0) || !(desc->mu > 0.0) || !(desc->speed > 0.0) || !(desc->length > 0.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "flow",
                        "rho = %g kg/m3, mu = %g Pa s, speed = %g m/s, length = %g m: all must be positive", desc->rho,
                        desc->mu, desc->speed, desc->length);
    flow->grid = grid;
    flow->bonds = bonds;
    flow->rho = desc->rho;
    flow->nu = desc->mu / desc->rho;
    flow->p_out = desc->p_out / desc->rho;
    flow->speed = desc->speed;
    flow->length = desc->length;
    flow->inlet = desc->inlet;
    flow->inlet_user = desc->inlet_user;
    flow->wall = desc->wall;
    flow->wall_user = desc->wall_user;
    double rate = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        flow->force[d] = desc->force[d];
        rate += flow->nu / (grid->h[d] * grid->h[d]) + 0.5 * desc->speed / grid->h[d];
    }
    flow->tau = 1.0 / rate;
    PDI_TRY(PDI_NEW(ctx, "flow", (int64_t)PD_DIM * grid->total, flow->u));
    PDI_TRY(PDI_NEW(ctx, "flow", grid->total, flow->p));
    PDI_TRY(PDI_NEW(ctx, "flow", (int64_t)PD_DIM * grid->total, flow->grad));
    PDI_TRY(PDI_NEW(ctx, "flow", (int64_t)PD_DIM * grid->total, flow->carrier));
    if (flow->wall) PDI_TRY(PDI_NEW(ctx, "flow", (int64_t)PD_DIM * grid->total, flow->drive));
    pdi_flow_drive(flow);
    for (int32_t node = 0; node < grid->total; node++)
        if (grid->kind[node] == PD_FLUID) flow->p[node] = flow->p_out;
    return pdi_flow_inlets(ctx, flow);
}

pd_status pd_flow_update(pd_ctx *ctx, const int32_t *changed, int32_t count, pd_flow *flow)
{
    const pd_bonds *bonds = flow->bonds;
    for (int32_t c = 0; c < count; c++) {
        double sum = 0.0;
        int found = 0;
        for (int k = 0; k < bonds->stencil->count; k++) {
            int32_t j = changed[c] + bonds->shift[k];
            if (flow->grid->kind[j] != PD_FLUID || pdi_bond_closed_group(bonds, changed[c], k) >= 0) continue;
            sum += flow->p[j];
            found++;
        }
        flow->p[changed[c]] = found ? sum / found : flow->p_out;
        for (int d = 0; d < PD_DIM; d++) flow->u[(int64_t)d * flow->grid->total + changed[c]] = 0.0;
    }
    pdi_flow_drive(flow);
    return pdi_flow_inlets(ctx, flow);
}

PDI_FN pd_status pdi_flow_store(pd_ctx *ctx, pd_flow *flow, pd_store *store)
{
    int32_t total = flow->grid->total;
    PDI_TRY(PDI_STORE(ctx, store, "flow.u", flow->u, (int64_t)PD_DIM * total));
    PDI_TRY(PDI_STORE(ctx, store, "flow.p", flow->p, total));
    PDI_TRY(PDI_STORE(ctx, store, "flow.evaluations", &flow->evaluations, 1));
    if (store->reading) pd_flow_prepare(ctx, flow);
    return PD_OK;
}

void pd_flow_free(pd_ctx *ctx, pd_flow *flow)
{
    int32_t total = flow->grid ? flow->grid->total : 0;
    PDI_DELETE(ctx, (int64_t)PD_DIM * total, flow->u);
    PDI_DELETE(ctx, total, flow->p);
    PDI_DELETE(ctx, (int64_t)PD_DIM * total, flow->grad);
    PDI_DELETE(ctx, (int64_t)PD_DIM * total, flow->carrier);
    PDI_DELETE(ctx, (int64_t)PD_DIM * total, flow->drive);
    memset(flow, 0, sizeof *flow);
}
