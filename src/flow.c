/* flow: see flow.h
 *
 * Design: sweeps work on blocks of neighbours along axis 0, bond by bond, whose sums stay in registers. All terms of a
 * bond are taken in one pass. Rows blank out their closed bonds.
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

/* Nodes of a block. In 3D the arrays are too many for registers, and longer pieces of them are faster to read. */
#define PDI_FLOW_BLOCK (PD_DIM == 3 ? PDI_LANES : PDI_BLOCK)

/* The sums of a block. */
typedef struct pdi_flow_sums {
    double conv[PD_DIM][PDI_FLOW_BLOCK]; /* sum 1/2 g.(w_i + w_j) v_j: the skew-symmetric convective term (eq. 4.3) */
    double lap[PD_DIM][PDI_FLOW_BLOCK];
    double half_div[PDI_FLOW_BLOCK];
    double tie[PDI_FLOW_BLOCK]; /* fourth-order pressure difference (eq. 4.4) */
} pdi_flow_sums;

/* Add bond k of the nodes i .. i+count-1. open: 1 or 0 for each of them, NULL: 1. tied: 1, or 0 when the bond carries
 * no pressure. Inlined with constants for `cut` and `linear`. */
static inline void pdi_flow_bond_lanes(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int k, int count,
                                       int cut, const double *PD_RESTRICT open, double tied, int linear,
                                       pdi_flow_sums *PD_RESTRICT sums)
{
    const pd_stencil *s = flow->bonds->stencil;
    int64_t total = flow->grid->total, shift = flow->bonds->shift[k];
    const double *mass = t->mass + i, *carried = t->carried + i + shift, *viscous = t->viscous + i;
    const double *frozen = linear ? t->frozen + i : NULL, *p = t->p + i, *grad = t->grad + i;
    double half[PD_DIM], arm[PD_DIM], a = pdi_bond_lap(flow->bonds, i)[k], share = pdi_bond_flux(flow->bonds, i, k);
    for (int d = 0; d < PD_DIM; d++) {
        half[d] = 0.5 * share * s->grad[k * PD_DIM + d];
        arm[d] = 0.5 * s->xi[k * PD_DIM + d];
    }
    for (int b = 0; b < count; b++) {
        double flux = 0.0, flux2 = 0.0, tie = p[b + shift] - p[b], weight = cut ? open[b] * a : a;
        for (int d = 0; d < PD_DIM; d++) {
            flux += half[d] * (mass[d * total + b] + mass[d * total + b + shift]);
            if (linear) flux2 += half[d] * (frozen[d * total + b] + frozen[d * total + b + shift]);
            tie -= arm[d] * (grad[d * total + b] + grad[d * total + b + shift]);
        }
        if (cut) {
            flux *= open[b];
            flux2 *= open[b];
        }
        sums->half_div[b] += flux;
        sums->tie[b] += tied * weight * tie;
        for (int d = 0; d < PD_DIM; d++) {
            double far = viscous[d * total + b + shift];
            sums->conv[d][b] += flux * carried[d * total + b];
            if (linear) sums->conv[d][b] += flux2 * far;
            sums->lap[d][b] += weight * (far - viscous[d * total + b]);
        }
    }
}

static void pdi_flow_bond(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int k, int count, const double *open,
                          double tied, pdi_flow_sums *sums)
{
    if (t->frozen && open) pdi_flow_bond_lanes(flow, t, i, k, count, 1, open, tied, 1, sums);
    else if (t->frozen) pdi_flow_bond_lanes(flow, t, i, k, count, 0, NULL, tied, 1, sums);
    else if (open) pdi_flow_bond_lanes(flow, t, i, k, count, 1, open, tied, 0, sums);
    else pdi_flow_bond_lanes(flow, t, i, k, count, 0, NULL, tied, 0, sums);
}

/* The radial component of a vector turns with the circumference: lap u_r - u_r/r^2 (eq. 3.10). */
static void pdi_flow_hoop(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int count, pdi_flow_sums *sums)
{
    const pd_grid *grid = flow->grid;
    const double *hoop = flow->bonds->ring.hoop;
    int r = PD_DIM - 1;
    for (int b = 0; b < count && hoop; b++)
        sums->lap[r][b] -= hoop[i / grid->stride[r]] * t->viscous[(int64_t)r * grid->total + i + b];
}

/* All bonds of nodes with whole families. Inlined with constants for whole blocks and for `linear`. */
static inline void pdi_flow_bonds(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int count, int linear,
                                  pdi_flow_sums *PD_RESTRICT sums)
{
    for (int k = 0; k < flow->bonds->stencil->count; k++)
        pdi_flow_bond_lanes(flow, t, i, k, count, 0, NULL, 1.0, linear, sums);
}

/* Nodes with whole families from node i. */
static void pdi_flow_whole(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int count, double *ru, double *rc)
{
    int64_t total = flow->grid->total;
    pdi_flow_sums sums;
    memset(&sums, 0, sizeof sums);
    if (count == PDI_FLOW_BLOCK && t->frozen) pdi_flow_bonds(flow, t, i, PDI_FLOW_BLOCK, 1, &sums);
    else if (count == PDI_FLOW_BLOCK) pdi_flow_bonds(flow, t, i, PDI_FLOW_BLOCK, 0, &sums);
    else pdi_flow_bonds(flow, t, i, count, t->frozen != NULL, &sums);
    pdi_flow_hoop(flow, t, i, count, &sums);
    for (int b = 0; b < count; b++) rc[i + b] = 2.0 * sums.half_div[b] - flow->tau * sums.tie[b];
    for (int d = 0; d < PD_DIM; d++) {
        double force = t->force ? t->force[d] : 0.0;
        for (int b = 0; b < count; b++)
            ru[d * total + i + b] =
                sums.conv[d][b] + (t->grad[d * total + i + b] - force) - flow->nu * sums.lap[d][b];
    }
}

/* Rows from row r, their nodes being consecutive. The wall enters the Laplacian through wall_lap, and the curvature of
 * the velocity at the wall, known from the momentum balance there (nu u'' = G - f), through wall_curv (eq. 3.3, 3.4).
 * Bonds to inlets carry no pressure. */
static void pdi_flow_cut(const pd_flow *flow, const pdi_flow_terms *t, int32_t r, int count, double *ru, double *rc)
{
    const pd_bonds *bonds = flow->bonds;
    int32_t i = bonds->node[r];
    int64_t total = flow->grid->total;
    pdi_flow_sums sums;
    double open[PDI_FLOW_BLOCK];
    memset(&sums, 0, sizeof sums);
    for (int d = 0; d < PD_DIM; d++)
        for (int b = 0; b < count; b++) {
            sums.lap[d][b] = -bonds->wall_lap[r + b] * t->viscous[d * total + i + b];
            if (t->drive) sums.lap[d][b] += t->drive[d * total + i + b];
        }
    for (int k = 0; k < bonds->stencil->count; k++) {
        pdi_lanes lanes = pdi_bond_open_lanes(bonds, r, k, count, open);
        if (lanes == PDI_LANES_NONE) continue;
        double tied = r >= bonds->plain && flow->grid->kind[i + bonds->shift[k]] == PD_INLET ? 0.0 : 1.0;
        if (lanes == PDI_LANES_ALL) pdi_flow_bond(flow, t, i, k, count, NULL, tied, &sums);
        else pdi_flow_bond(flow, t, i, k, count, open, tied, &sums);
    }
    pdi_flow_hoop(flow, t, i, count, &sums);
    for (int b = 0; b < count; b++) rc[i + b] = 2.0 * sums.half_div[b] - flow->tau * sums.tie[b];
    for (int d = 0; d < PD_DIM; d++) {
        double force = t->force ? t->force[d] : 0.0;
        for (int b = 0; b < count; b++)
            ru[d * total + i + b] = sums.conv[d][b] +
                                    (1.0 - bonds->wall_curv[r + b]) * (t->grad[d * total + i + b] - force) -
                                    flow->nu * sums.lap[d][b];
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
    if (row < 0) pdi_flow_whole(s->flow, s->terms, i, count, s->ru, s->rc);
    else pdi_flow_cut(s->flow, s->terms, row, count, s->ru, s->rc);
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
    t.carried = t.viscous = flow->u;
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
