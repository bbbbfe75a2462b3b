/* flow: see flow.h
 *
 * Design: the sweep over nodes with whole families works on blocks of PDI_FLOW_BLOCK neighbours along axis 0, bond
 * by bond, so that the inner loops are plain vectors with shared weights. Nodes that own a row go one by one. Both
 * paths evaluate the same sums.
 */
#include "flow.h"
#include "op.h"
#include "par.h"
#include <math.h>
#include <string.h>

#define PDI_FLOW_BLOCK 8

PDI_FN void pdi_flow_outlet_velocity(const pd_flow *flow, double *u)
{
    int32_t total = flow->grid->total;
    for (int32_t o = 0; o < flow->outlets; o++)
        for (int d = 0; d < PD_DIM; d++) {
            double value = u[(int64_t)d * total + flow->outlet_mirror[o]];
            u[(int64_t)d * total + flow->outlet[o]] = d == flow->outlet_axis[o] ? value : -value;
        }
}

PDI_FN void pdi_flow_outlet_pressure(const pd_flow *flow, double p_out, double *p)
{
    for (int32_t o = 0; o < flow->outlets; o++) p[flow->outlet[o]] = 2.0 * p_out - p[flow->outlet_mirror[o]];
}

/* Work of a sweep in scalar operations, to decide on threads. */
static int64_t pdi_flow_work(const pd_flow *flow) { return flow->grid->fluid_count * flow->bonds->stencil->count * 4; }

PDI_FN void pdi_flow_gradient(const pd_ctx *ctx, const pd_flow *flow, const double *p, double *grad)
{
    int32_t total = flow->grid->total;
    pd_op_gradient(ctx, flow->bonds, p, grad);
    for (int32_t o = 0; o < flow->outlets; o++)
        for (int d = 0; d < PD_DIM; d++) {
            double value = grad[(int64_t)d * total + flow->outlet_mirror[o]];
            grad[(int64_t)d * total + flow->outlet[o]] = d == flow->outlet_axis[o] ? value : -value;
        }
}

/* conv += 1/2 sum_j g.(w_i + w_j) u_j for a block: the skew-symmetric convective term (eq. 4.3). */
static void pdi_flow_convect_block(const double *g, const double *w, const double *u, int32_t i, int32_t j,
                                   int32_t total, int count, double conv[PD_DIM][PDI_FLOW_BLOCK])
{
    double flux[PDI_FLOW_BLOCK];
    for (int b = 0; b < count; b++) flux[b] = 0.5 * g[0] * (w[i + b] + w[j + b]);
    for (int d = 1; d < PD_DIM; d++)
        for (int b = 0; b < count; b++)
            flux[b] += 0.5 * g[d] * (w[(int64_t)d * total + i + b] + w[(int64_t)d * total + j + b]);
    for (int d = 0; d < PD_DIM; d++)
        for (int b = 0; b < count; b++) conv[d][b] += flux[b] * u[(int64_t)d * total + j + b];
}

/* One block of `count` consecutive nodes from i with whole families. Inlined twice, with count a constant for full
 * blocks. */
static inline void pdi_flow_block(const pd_flow *flow, const pdi_flow_terms *t, int32_t i, int count, double *ru,
                                  double *rc)
{
    const pd_stencil *s = flow->bonds->stencil;
    int32_t total = flow->grid->total;
    double conv[PD_DIM][PDI_FLOW_BLOCK], lap[PD_DIM][PDI_FLOW_BLOCK], div[PDI_FLOW_BLOCK], tie[PDI_FLOW_BLOCK];
    double centre[PD_DIM][PDI_FLOW_BLOCK];
    memset(conv, 0, sizeof conv);
    memset(lap, 0, sizeof lap);
    memset(div, 0, sizeof div);
    memset(tie, 0, sizeof tie);
    for (int d = 0; d < PD_DIM; d++)
        for (int b = 0; b < count; b++) centre[d][b] = t->viscous[(int64_t)d * total + i + b];
    for (int k = 0; k < s->count; k++) {
        int32_t j = i + flow->bonds->shift[k];
        const double *g = s->grad + k * PD_DIM, *xi = s->xi + k * PD_DIM;
        double a = s->lap[k];
        if (t->w) pdi_flow_convect_block(g, t->w, t->u, i, j, total, count, conv);
        if (t->w2) pdi_flow_convect_block(g, t->w2, t->u2, i, j, total, count, conv);
        for (int b = 0; b < count; b++) tie[b] += a * (t->p[j + b] - t->p[i + b]);
        for (int d = 0; d < PD_DIM; d++) {
            double half = 0.5 * a * xi[d];
            for (int b = 0; b < count; b++) {
                lap[d][b] += a * (t->viscous[(int64_t)d * total + j + b] - centre[d][b]);
                div[b] += g[d] * t->mass[(int64_t)d * total + j + b];
                tie[b] -= half * t->grad[(int64_t)d * total + j + b];
            }
        }
    }
    for (int b = 0; b < count; b++) rc[i + b] = div[b] - flow->tau * tie[b];
    for (int d = 0; d < PD_DIM; d++)
        for (int b = 0; b < count; b++) {
            double drive = t->grad[(int64_t)d * total + i + b] - (t->force ? t->force[d] : 0.0);
            ru[(int64_t)d * total + i + b] = conv[d][b] + drive - flow->nu * lap[d][b];
        }
}

static void pdi_flow_run(const pd_flow *flow, const pdi_flow_terms *t, int32_t first, int32_t length, double *ru,
                         double *rc)
{
    int32_t at = 0;
    for (; at + PDI_FLOW_BLOCK <= length; at += PDI_FLOW_BLOCK)
        pdi_flow_block(flow, t, first + at, PDI_FLOW_BLOCK, ru, rc);
    if (at < length) pdi_flow_block(flow, t, first + at, (int)(length - at), ru, rc);
}

/* Half the volume flux through a bond: 1/2 g.(w_i + w_j). */
static double pdi_flow_half_flux(const double *g, const double *w, int32_t i, int32_t j, int32_t total)
{
    double flux = 0.0;
    for (int d = 0; d < PD_DIM; d++) flux += 0.5 * g[d] * (w[(int64_t)d * total + i] + w[(int64_t)d * total + j]);
    return flux;
}

/* One node with a cut family. The wall enters the Laplacian through wall_lap, and the curvature of the velocity at the
 * wall, known from the momentum balance there (nu u'' = G - f), through wall_curv (eq. 3.3, 3.4). */
static void pdi_flow_row(const pd_flow *flow, const pdi_flow_terms *t, int32_t r, double *ru, double *rc)
{
    const pd_bonds *bonds = flow->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t i = bonds->node[r], total = flow->grid->total;
    double conv[PD_DIM], lap[PD_DIM], div = 0.0, tie = 0.0;
    memset(conv, 0, sizeof conv);
    for (int d = 0; d < PD_DIM; d++) lap[d] = -bonds->wall_lap[r] * t->viscous[(int64_t)d * total + i];
    for (int o = 0; o < bonds->open[r]; o++) {
        int k = bonds->bond[(int64_t)r * s->count + o];
        int32_t j = i + bonds->shift[k];
        const double *g = s->grad + k * PD_DIM, *xi = s->xi + k * PD_DIM;
        double a = s->lap[k];
        double flux = t->w ? pdi_flow_half_flux(g, t->w, i, j, total) : 0.0;
        double flux2 = t->w2 ? pdi_flow_half_flux(g, t->w2, i, j, total) : 0.0;
        div += 2.0 * pdi_flow_half_flux(g, t->mass, i, j, total);
        for (int d = 0; d < PD_DIM; d++) {
            int64_t row = (int64_t)d * total;
            lap[d] += a * (t->viscous[row + j] - t->viscous[row + i]);
            if (t->w) conv[d] += flux * t->u[row + j];
            if (t->w2) conv[d] += flux2 * t->u2[row + j];
        }
        if (flow->grid->kind[j] == PD_INLET) continue;
        tie += a * (t->p[j] - t->p[i]);
        for (int d = 0; d < PD_DIM; d++)
            tie -= 0.5 * a * xi[d] * (t->grad[(int64_t)d * total + i] + t->grad[(int64_t)d * total + j]);
    }
    rc[i] = div - flow->tau * tie;
    for (int d = 0; d < PD_DIM; d++) {
        double drive = t->grad[(int64_t)d * total + i] - (t->force ? t->force[d] : 0.0);
        ru[(int64_t)d * total + i] = conv[d] + (1.0 - bonds->wall_curv[r]) * drive - flow->nu * lap[d];
    }
}

PDI_FN void pdi_flow_terms_apply(const pd_ctx *ctx, const pd_flow *flow, const pdi_flow_terms *t, double *ru,
                                 double *rc)
{
    const pd_bonds *bonds = flow->bonds;
    int nt = pdi_par_threads(ctx, pdi_flow_work(flow));
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t run = 0; run < bonds->runs; run++)
        pdi_flow_run(flow, t, bonds->run_first[run], bonds->run_length[run], ru, rc);
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++) pdi_flow_row(flow, t, r, ru, rc);
}

void pd_flow_residual(pd_ctx *ctx, pd_flow *flow, double *ru, double *rc)
{
    pdi_flow_terms t;
    memset(&t, 0, sizeof t);
    pdi_flow_outlet_velocity(flow, flow->u);
    pdi_flow_outlet_pressure(flow, flow->p_out, flow->p);
    pdi_flow_gradient(ctx, flow, flow->p, flow->grad);
    t.w = t.u = t.viscous = t.mass = flow->u;
    t.p = flow->p;
    t.grad = flow->grad;
    t.force = flow->force;
    pdi_flow_terms_apply(ctx, flow, &t, ru, rc);
    flow->evaluations++;
}

PDI_FN double pdi_flow_bond_flux(const pd_flow *flow, int32_t i, int k)
{
    const pd_stencil *s = flow->bonds->stencil;
    int32_t total = flow->grid->total, j = i + flow->bonds->shift[k];
    double flux = 2.0 * pdi_flow_half_flux(s->grad + k * PD_DIM, flow->u, i, j, total);
    if (flow->grid->kind[i] == PD_INLET || flow->grid->kind[j] == PD_INLET) return flux;
    double tie = flow->p[j] - flow->p[i];
    for (int d = 0; d < PD_DIM; d++)
        tie -= 0.5 * s->xi[k * PD_DIM + d] * (flow->grad[(int64_t)d * total + i] + flow->grad[(int64_t)d * total + j]);
    return flux - flow->tau * s->lap[k] * tie;
}

/* Bonds that start before the plane and end behind it; each pair of nodes counts once. */
double pd_flow_section(pd_ctx *ctx, pd_flow *flow, int axis, int index)
{
    const pd_stencil *s = flow->bonds->stencil;
    const pd_grid *grid = flow->grid;
    double sum = 0.0;
    pdi_flow_outlet_velocity(flow, flow->u);
    pdi_flow_outlet_pressure(flow, flow->p_out, flow->p);
    pdi_flow_gradient(ctx, flow, flow->p, flow->grad);
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID && grid->kind[node] != PD_INLET) continue;
        pdi_grid_index(grid, node, i);
        if (i[axis] >= index || i[axis] < index - s->reach) continue;
        for (int k = 0; k < s->count; k++) {
            if (i[axis] + s->offset[k * PD_DIM + axis] < index) continue;
            /* bonds that would leave the arrays start behind a side ghost */
            int inside = 1;
            for (int d = 0; d < PD_DIM; d++) {
                int far = i[d] + s->offset[k * PD_DIM + d];
                inside = inside && far >= -grid->ghost && far < grid->n[d] + grid->ghost;
            }
            if (!inside) continue;
            uint8_t far_kind = grid->kind[node + flow->bonds->shift[k]];
            if (grid->kind[node] == PD_INLET && far_kind != PD_FLUID) continue;
            if (!pdi_grid_open(far_kind) || pdi_bond_closed_group(flow->bonds, node, k) >= 0) continue;
            sum += pdi_flow_bond_flux(flow, node, k) * s->volume;
        }
    }
    return sum;
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
        if (i[axis] == index) sum += flow->u[(int64_t)axis * grid->total + node] * face;
    }
    return sum;
}

/* Outlet ghosts and inlet values follow the kinds of the ghosts. */
static pd_status pdi_flow_ghosts(pd_ctx *ctx, pd_flow *flow)
{
    const pd_grid *grid = flow->grid;
    int32_t count = 0;
    for (int32_t node = 0; node < grid->total; node++) count += grid->kind[node] == PD_OUTLET;
    if (count > flow->outlet_capacity) {
        PDI_DELETE(ctx, flow->outlet_capacity, flow->outlet);
        PDI_DELETE(ctx, flow->outlet_capacity, flow->outlet_mirror);
        PDI_DELETE(ctx, flow->outlet_capacity, flow->outlet_axis);
        flow->outlet_capacity = count;
        PDI_TRY(PDI_NEW(ctx, "flow", count, flow->outlet));
        PDI_TRY(PDI_NEW(ctx, "flow", count, flow->outlet_mirror));
        PDI_TRY(PDI_NEW(ctx, "flow", count, flow->outlet_axis));
    }
    flow->outlets = 0;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        double x[PD_DIM], u[PD_DIM];
        if (grid->kind[node] == PD_OUTLET) {
            pdi_grid_index(grid, node, i);
            int axis = 0;
            for (int d = 0; d < PD_DIM; d++)
                if (i[d] < 0 || i[d] >= grid->n[d]) axis = d;
            flow->outlet[flow->outlets] = node;
            flow->outlet_axis[flow->outlets] = (uint8_t)axis;
            flow->outlet_mirror[flow->outlets++] = pdi_grid_mirror(grid, node);
        }
        if (grid->kind[node] != PD_INLET || !flow->inlet) continue;
        pd_grid_position(grid, node, x);
        flow->inlet(flow->inlet_user, x, u);
        for (int d = 0; d < PD_DIM; d++) {
            if (!(fabs(u[d]) < 1e100))
                return pdi_fail(ctx, PD_ERR_ARGUMENT, "flow", "the inlet velocity at (%g, ...) m is %g m/s", x[0],
                                u[d]);
            flow->u[(int64_t)d * grid->total + node] = u[d];
        }
    }
    return PD_OK;
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
    double rate = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        flow->force[d] = desc->force[d];
        rate += flow->nu / (grid->h[d] * grid->h[d]) + 0.5 * desc->speed / grid->h[d];
    }
    flow->tau = 1.0 / rate;
    PDI_TRY(PDI_NEW(ctx, "flow", (int64_t)PD_DIM * grid->total, flow->u));
    PDI_TRY(PDI_NEW(ctx, "flow", grid->total, flow->p));
    PDI_TRY(PDI_NEW(ctx, "flow", (int64_t)PD_DIM * grid->total, flow->grad));
    for (int32_t node = 0; node < grid->total; node++)
        if (grid->kind[node] == PD_FLUID) flow->p[node] = flow->p_out;
    return pdi_flow_ghosts(ctx, flow);
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
    return pdi_flow_ghosts(ctx, flow);
}

void pd_flow_free(pd_ctx *ctx, pd_flow *flow)
{
    int32_t total = flow->grid ? flow->grid->total : 0;
    PDI_DELETE(ctx, (int64_t)PD_DIM * total, flow->u);
    PDI_DELETE(ctx, total, flow->p);
    PDI_DELETE(ctx, (int64_t)PD_DIM * total, flow->grad);
    PDI_DELETE(ctx, flow->outlet_capacity, flow->outlet);
    PDI_DELETE(ctx, flow->outlet_capacity, flow->outlet_mirror);
    PDI_DELETE(ctx, flow->outlet_capacity, flow->outlet_axis);
    memset(flow, 0, sizeof *flow);
}
