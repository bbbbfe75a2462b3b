/* flow: see flow.h. Sweeps take blocks of neighbours along axis 0, bond by bond; rows blank out their closed bonds. */
#include "flow/flow.h"
#include "core/disjoint_sets.h"
#include "core/par.h"
#include "lattice/op.h"
#include "flow/inflow.h"
#include "flow/flow_scales.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PDI_FLOW_OUTSIDE_OFFSET 1e-6 /* [cells] offset that puts a point on an inlet outside of the box */

PDI_FN void pdi_flow_compute_pressure_gradient(const pd_ctx *ctx, const pd_flow *flow, const double *p, double *grad)
{
    pd_op_gradient(ctx, flow->bonds, p, grad);
    if (flow->uses_axis_divergence) pdi_reconstruct_set_gradient(ctx, &flow->wall_fit, p, grad);
    if (flow->fourth_order.bonds) pdi_fourth_order_compute_pressure_gradient(ctx, &flow->fourth_order, p, grad);
    pd_ghosts_set_vector(&flow->bonds->ghosts, grad);
}

/* v [PD_DIM][total]: v = K v at `node` alone, in place, with the tensor K of row r (eq. 3.4), mirrored along the axes
 * whose bits are set in `odd`. */
static void pdi_flow_apply_advection_tensor(const pd_flow *flow, int32_t r, int32_t node, int odd, double *v)
{
    const double *k = flow->bonds->flux_correction + (int64_t)r * PD_DIM * PD_DIM;
    int64_t total = flow->grid->total;
    double old[PD_DIM];
    for (int b = 0; b < PD_DIM; b++) old[b] = v[b * total + node];
    for (int a = 0; a < PD_DIM; a++) {
        double sum = 0.0;
        for (int b = 0; b < PD_DIM; b++) {
            double part = k[a * PD_DIM + b] * old[b];
            sum += ((odd >> a ^ odd >> b) & 1) ? -part : part;
        }
        v[a * total + node] = sum;
    }
}

/* 1: row r takes the pointwise divergence (3.5): uses_axis_divergence, and the row is beside a smooth surface. */
static int pdi_flow_has_axis_divergence(const pd_flow *flow, int32_t r)
{
    return flow->uses_axis_divergence && flow->bonds->near_smooth_surface[r];
}

PDI_FN void pdi_flow_compute_advecting_velocity(const pd_ctx *ctx, const pd_flow *flow, const double *v,
                                                const double *second, double *advecting)
{
    const pd_bonds *bonds = flow->bonds;
    const pd_ghosts *ghosts = &bonds->ghosts;
    int64_t total = flow->grid->total;
    int nt = pd_par_threads(ctx, (int64_t)bonds->rows * PD_DIM * PD_DIM);
    (void)nt;
    pdi_par_copy(ctx, PD_DIM * total, v, advecting);
    if (second) pdi_fourth_order_compute_advecting_velocity(ctx, &flow->fourth_order, v, second, advecting);
    if (flow->inlets_on_side) pdi_inflow_set_doubled_velocity(bonds, advecting);
    if (flow->uses_axis_divergence && !second)
        pdi_isotropic_stencil_add_velocity_correction(ctx, &flow->isotropic_stencil, v, advecting);
    PD_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++)
        if (!pdi_flow_has_axis_divergence(flow, r))
            pdi_flow_apply_advection_tensor(flow, r, bonds->node[r], 0, advecting);
    /* inlet ghosts lie behind the same walls as the node that they mirror */
    for (int32_t g = ghosts->outlets_end; g < ghosts->inlets_end && !flow->inlets_on_side; g++) {
        int32_t r = bonds->row_of_node[ghosts->source[g]];
        if (r >= 0 && !pdi_flow_has_axis_divergence(flow, r))
            pdi_flow_apply_advection_tensor(flow, r, ghosts->node[g], ghosts->sign_flips[g], advecting);
    }
    if (flow->inlets_on_side)
        pdi_inflow_set_advecting_velocity(bonds, flow->has_tangential_weight, flow->inlet_speed_ratio,
                                          flow->uses_axis_divergence, advecting);
    pd_ghosts_set_vector(ghosts, advecting);
}

/* ---- divergence beside smooth surfaces ---- */
/* Pointwise divergence (3.5) at row r less the sum of its bond fluxes [1/s]. is_state 0: walls count as at rest. */
static double pdi_flow_compute_divergence_excess(const pd_flow *flow, const double *u, const double *advecting,
                                                 int32_t r, int is_state)
{
    const pd_bonds *bonds = flow->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[r];
    int64_t total = flow->grid->total;
    pdi_isotropic_stencil_place place = {bonds, r, is_state ? flow->wall : NULL, flow->wall_user};
    double excess = 0.0;
    for (int d = 0; d < PD_DIM; d++) excess += pdi_isotropic_stencil_compute_derivative(&place, d, u);
    for (int k = 0; k < s->count; k++) {
        if (!pdi_bond_is_open(bonds, r, k)) continue;
        const double *v = advecting + node, *far = v + bonds->paths.shift[k];
        for (int d = 0; d < PD_DIM; d++) excess -= s->gradient_weight[k * PD_DIM + d] * (v[d * total] + far[d * total]);
    }
    return excess;
}

PDI_FN void pdi_flow_add_divergence_correction(const pd_ctx *ctx, const pd_flow *flow, const double *u,
                                               const double *advecting, int is_state, double sign, double *rc)
{
    const pd_bonds *bonds = flow->bonds;
    if (!flow->uses_axis_divergence) return;
    int nt = pd_par_threads(ctx, (int64_t)bonds->rows * bonds->stencil->count * PD_DIM);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++)
        flow->divergence_excess[r] =
            flow->patch[r] < 0 ? 0.0 : pdi_flow_compute_divergence_excess(flow, u, advecting, r, is_state);
    /* nothing passes the surface of a body in the sum */
    for (int32_t r = 0; r < 2 * bonds->rows; r++) flow->patch_sums[r] = 0.0;
    for (int32_t r = 0; r < bonds->rows; r++) {
        if (flow->patch[r] < 0) continue;
        flow->patch_sums[2 * flow->patch[r]] += flow->divergence_excess[r];
        flow->patch_sums[2 * flow->patch[r] + 1] += 1.0;
    }
    for (int32_t r = 0; r < bonds->rows; r++) {
        if (flow->patch[r] < 0) continue;
        const double *leak = flow->patch_sums + 2 * flow->patch[r];
        rc[bonds->node[r]] += sign * (flow->divergence_excess[r] - leak[0] / leak[1]);
    }
}

PDI_FN void pdi_flow_add_fitted_wall(const pd_ctx *ctx, const pd_flow *flow, const double *u, const double *p,
                                     const double *grad, int is_state, double *ru)
{
    const pd_bonds *bonds = flow->bonds;
    if (!flow->uses_axis_divergence) return;
    int nt = pd_par_threads(ctx, (int64_t)flow->wall_fit.count * bonds->stencil->count * PD_DIM);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t q = 0; q < flow->wall_fit.count; q++) {
        int32_t r = flow->wall_fit.row[q], node = bonds->node[r];
        double wall[PD_DIM], pressure_part[PD_DIM],
            share = flow->isotropic_stencil.bonds ? flow->isotropic_blending : 0.0;
        if (!pdi_flow_has_fitted_wall(flow, r)) continue;
        pdi_reconstruct_apply_wall_laplacian(&flow->wall_fit, r, u, wall);
        pdi_reconstruct_compute_viscous_error(&flow->wall_fit, r, p, pressure_part);
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = (int64_t)d * flow->grid->total + node;
            double force = is_state ? pdi_flow_get_body_force(flow, d, node) : 0.0;
            wall[d] += bonds->wall_laplacian[r] * u[at];
            if (share > 0.0)
                wall[d] +=
                    share * pdi_isotropic_stencil_compute_row_correction(&flow->isotropic_stencil, r, u + at - node);
            ru[at] += bonds->wall_curvature[r] * (grad[at] - force) - flow->nu * wall[d] + pressure_part[d];
        }
    }
}

PDI_COLD_BEGIN
/* Merges the patch of row r with those of the rows at the far ends of its open bonds (disjoint sets). Ghosts count as
 * the node that they stand for. Far ends that are no row, or a row in no patch, are skipped. */
static void pdi_flow_merge_patches(pd_flow *flow, int32_t r)
{
    const pd_bonds *bonds = flow->bonds;
    int32_t *patch = flow->patch;
    for (int k = 0; k < bonds->stencil->count; k++) {
        int32_t j = bonds->node[r] + bonds->paths.shift[k];
        if (!pdi_bond_is_open(bonds, r, k) || !pdi_grid_is_open(flow->grid->kind[j])) continue;
        int32_t other = bonds->row_of_node[pd_grid_find_source(flow->grid, j, NULL)];
        if (other < 0 || patch[other] < 0) continue;
        pdi_disjoint_sets_merge(patch, r, other);
    }
}

/* Lists the arrays over rows: patch, divergence_excess, patch_sums. */
static void pdi_flow_list_row_arrays(pdi_array_visitor *owner, void *object)
{
    pd_flow *flow = (pd_flow *)object;
    PDI_ARRAY(owner, flow, patch, flow->row_capacity, "1");
    PDI_ARRAY(owner, flow, divergence_excess, flow->row_capacity, "1/s");
    PDI_ARRAY(owner, flow, patch_sums, 2 * (int64_t)flow->row_capacity, "1/s");
}

PDI_FN pd_status pdi_flow_find_surface_patches(pd_ctx *ctx, pd_flow *flow)
{
    const pd_bonds *bonds = flow->bonds;
    if (flow->fourth_order.bonds) pdi_fourth_order_mark_regular_nodes(&flow->fourth_order);
    int smooth = 0;
    for (int32_t r = 0; r < bonds->rows; r++) smooth = smooth || bonds->near_smooth_surface[r];
    flow->uses_axis_divergence = smooth && !flow->grid->circumference;
    flow->patch_version = 0;
    if (!smooth) return PD_OK;
    const double *excess = flow->isotropic_stencil.bonds ? flow->isotropic_stencil.weight_excess : NULL;
    if (flow->uses_axis_divergence)
        PD_TRY(pdi_reconstruct_update(ctx, bonds, excess, flow->isotropic_blending, &flow->wall_fit));
    if (flow->row_capacity < bonds->capacity)
        PD_TRY(pdi_array_registry_rebuild(ctx, pdi_flow_list_row_arrays, flow, &flow->row_capacity, bonds->capacity));
    for (int32_t r = 0; r < bonds->rows; r++) flow->patch[r] = bonds->near_smooth_surface[r] ? r : -1;
    for (int32_t r = 0; r < bonds->rows; r++)
        if (flow->patch[r] >= 0) pdi_flow_merge_patches(flow, r);
    for (int32_t r = 0; r < bonds->rows; r++)
        if (flow->patch[r] >= 0) flow->patch[r] = pdi_disjoint_sets_find_root(flow->patch, r);
    flow->patch_version = bonds->version;
    return PD_OK;
}
PDI_COLD_END

PDI_FN void pdi_flow_update_velocity_ghosts(const pd_flow *flow, int is_state, double *v)
{
    pd_ghosts_set_vector(&flow->bonds->ghosts, v);
    if (flow->inlets_on_side && flow->inlet_velocity)
        pdi_ghosts_set_inlet_velocity(&flow->bonds->ghosts, is_state ? flow->inlet_velocity : NULL, v);
}

PDI_FN void pdi_flow_update_derived_fields(pd_ctx *ctx, pd_flow *flow)
{
    pdi_flow_update_velocity_ghosts(flow, 1, flow->u);
    pdi_ghosts_set_pressure(&flow->bonds->ghosts, flow->p_out, flow->p);
    pdi_flow_compute_pressure_gradient(ctx, flow, flow->p, flow->pressure_grad);
    if (flow->fourth_order.bonds)
        pdi_fourth_order_compute_second_differences(ctx, &flow->fourth_order, flow->wall, flow->wall_user, flow->u,
                                                    flow->fourth_order.second);
    pdi_flow_compute_advecting_velocity(ctx, flow, flow->u, flow->fourth_order.second, flow->advecting);
}

#define PDI_FLOW_BLOCK PDI_VECTOR_LENGTH /* nodes of a block: their values and sums stay in registers */

/* Twice the sums of a block. Convection is the skew-symmetric 1/2 g.(w_i + w_j) v_j (eq. 3.3), whose v_j is taken as
 * v_i + (v_j - v_i), so that convection and friction share the difference. */
typedef struct pdi_flow_block_sums {
    double momentum[PD_DIM][PDI_FLOW_BLOCK]; /* convective and viscous terms but for v_i times the fluxes */
    double flux[PDI_FLOW_BLOCK];             /* of `mass` */
    double stabiliser[PDI_FLOW_BLOCK];              /* fourth-order pressure difference (eq. 3.7) */
} pdi_flow_block_sums;

/* Values of a block of nodes i .. i+count-1, which every bond reads again. */
typedef struct pdi_flow_block_values {
    double advecting[PD_DIM][PDI_FLOW_BLOCK], u[PD_DIM][PDI_FLOW_BLOCK], grad[PD_DIM][PDI_FLOW_BLOCK],
        p[PDI_FLOW_BLOCK];
    double open[PDI_FLOW_BLOCK]; /* 1 or 0: the bond in hand is open or closed */
} pdi_flow_block_values;

/* Copies the values of `count` nodes from i. */
PDI_INLINE void pdi_flow_copy_block(const pd_flow *flow, const pdi_flow_operands *t, int32_t i, int count,
                                    pdi_flow_block_values *PD_RESTRICT own)
{
    for (int d = 0; d < PD_DIM; d++) {
        int64_t at = (int64_t)d * flow->grid->total + i;
        for (int b = 0; b < count; b++) own->advecting[d][b] = t->advecting[at + b];
        for (int b = 0; b < count; b++) own->u[d][b] = t->u[at + b];
        for (int b = 0; b < count; b++) own->grad[d][b] = t->grad[at + b];
    }
    for (int b = 0; b < count; b++) own->p[b] = t->p[i + b];
}

/* Adds bond k of nodes i .. i+count-1 to *sums: its volume flux, a times the pressure stabilisation, and (flux - 2 nu
 * a) times the velocity difference, with a the Laplacian weight (for friction with its isotropic part). open: 1 or 0
 * for each node, NULL: all open, with pressure flux. pressure 0: no pressure flux, 1: with it. */
PDI_INLINE void pdi_flow_add_bond(const pd_flow *flow, const pdi_flow_operands *t,
                                  const pdi_flow_block_values *PD_RESTRICT own, int32_t i, int k, int count,
                                  const double *PD_RESTRICT open, double pressure,
                                  pdi_flow_block_sums *PD_RESTRICT sums)
{
    const pd_stencil *s = flow->bonds->stencil;
    int64_t total = flow->grid->total, far = (int64_t)i + flow->bonds->paths.shift[k];
    const double *mass = t->advecting + far, *u = t->u + far, *p = t->p + far, *grad = t->grad + far;
    const double *g = s->gradient_weight + k * PD_DIM, *xi = s->xi + k * PD_DIM;
    const double *a = pdi_bond_get_laplacian_weights(flow->bonds, i) + k;
    double twice_nu = 2.0 * flow->nu, share = pdi_bond_get_flux_factor(flow->bonds, i, k);
    for (int b = 0; b < count; b++) {
        double flux = pdi_flow_compute_convective_flux(g, &own->advecting[0][b], PDI_FLOW_BLOCK, mass + b, total);
        double stabiliser =
            pdi_flow_compute_stabilisation(xi, p[b] - own->p[b], &own->grad[0][b], PDI_FLOW_BLOCK, grad + b, total);
        if (PD_DIM == 2) flux *= share; /* the circumference half way against that at the node; planar: 1 */
        double gain = flux - twice_nu * (flow->isotropic_stencil.bonds
                                             ? *a + flow->isotropic_blending * flow->isotropic_stencil.weight_excess[k]
                                             : *a);
        stabiliser *= *a;
        if (open) {
            flux *= open[b];
            stabiliser *= pressure * open[b];
            gain *= open[b];
        }
        sums->flux[b] += flux;
        sums->stabiliser[b] += stabiliser;
        for (int d = 0; d < PD_DIM; d++) sums->momentum[d][b] += gain * (u[d * total + b] - own->u[d][b]);
    }
}

/* Adds all bonds of nodes with full families. Inlined with a constant for `count`. */
PDI_INLINE void pdi_flow_add_full_family(const pd_flow *flow, const pdi_flow_operands *t, int32_t i, int count,
                                         pdi_flow_block_values *PD_RESTRICT own, pdi_flow_block_sums *PD_RESTRICT sums)
{
    pdi_flow_copy_block(flow, t, i, count, own);
    for (int k = 0; k < flow->bonds->stencil->count; k++) pdi_flow_add_bond(flow, t, own, i, k, count, NULL, 1.0, sums);
}

/* Adds the open bonds of the rows from r; r = -1: full families. Bonds to inlets carry no pressure flux. */
PDI_INLINE_HOT void pdi_flow_add_open_bonds(const pd_flow *flow, const pdi_flow_operands *t, int32_t i, int32_t r,
                                            int count, pdi_flow_block_values *PD_RESTRICT own,
                                            pdi_flow_block_sums *PD_RESTRICT sums)
{
    const pd_bonds *bonds = flow->bonds;
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    pdi_flow_copy_block(flow, t, i, count, own);
    for (int k = 0; k < bonds->stencil->count; k++) {
        pdi_bond_openness which = pdi_bond_find_nodes_open(bonds, r, k, count, &gate, own->open);
        if (which == PDI_BOND_OPEN_NONE) continue;
        double pressure =
            r >= bonds->rows_without_inlet && flow->grid->kind[i + bonds->paths.shift[k]] == PD_INLET ? 0.0 : 1.0;
        for (int b = 0; b < count && which == PDI_BOND_OPEN_ALL; b++) own->open[b] = 1.0;
        pdi_flow_add_bond(flow, t, own, i, k, count, own->open, pressure, sums);
    }
}

/* Not inlined: for blocks shorter than a vector. */
PDI_NO_VECTORISE void pdi_flow_add_short_block(const pd_flow *flow, const pdi_flow_operands *t, int32_t i, int32_t row,
                                               int count, pdi_flow_block_values *own, pdi_flow_block_sums *sums)
{
    pdi_flow_add_open_bonds(flow, t, i, row, count, own, sums);
}

/* Sets residuals ru, rc of `count` nodes from i: rows from `row`, or full families (-1). Wall friction enters by
 * wall_laplacian and wall_motion, curvature at the wall, nu u'' = G - f, by the factor 1 - wall_curvature on pressure
 * gradient and force (eq. 2.3, 2.4). Axisymmetric: the radial component also has nu u_r/r^2 (1.10). */
static void pdi_flow_assemble_block(const pd_flow *flow, const pdi_flow_operands *t, int32_t i, int32_t row, int count,
                                    double *ru, double *rc)
{
    const pd_bonds *bonds = flow->bonds;
    const double *hoop = bonds->axisym.hoop;
    int64_t total = flow->grid->total;
    enum { whole = PDI_FLOW_BLOCK };
    pdi_flow_block_values own;
    pdi_flow_block_sums sums;
    memset(&sums, 0, sizeof sums);
    if (count == whole && row < 0) pdi_flow_add_full_family(flow, t, i, whole, &own, &sums);
    else if (count == whole) pdi_flow_add_open_bonds(flow, t, i, row, whole, &own, &sums);
    else pdi_flow_add_short_block(flow, t, i, row, count, &own, &sums);
    double weight = pdi_flow_get_pressure_flux_weight(flow);
    for (int b = 0; b < count; b++) rc[i + b] = sums.flux[b] - 0.5 * weight * sums.stabiliser[b];
    for (int d = 0; d < PD_DIM; d++) {
        double force = t->force ? t->force[d] : 0.0;
        double turn = hoop && d == PD_DIM - 1 ? hoop[i / flow->grid->stride[d]] : 0.0;
        for (int b = 0; b < count; b++) {
            int64_t at = d * total + i + b;
            double bend = 0.0, lap = turn;
            if (row >= 0) {
                lap += bonds->wall_laplacian[row + b];
                bend = bonds->wall_curvature[row + b];
            }
            ru[at] = 0.5 * sums.momentum[d][b] + (0.5 * sums.flux[b] + flow->nu * lap) * t->u[at] +
                     (1.0 - bend) * (t->grad[at] - force);
            if (t->wall_motion && row >= 0) ru[at] -= flow->nu * t->wall_motion[at];
        }
    }
}

typedef struct pdi_flow_sweep_args {
    const pd_flow *flow;
    const pdi_flow_operands *terms;
    double *ru, *rc; /* [m/s2] [1/s] */
} pdi_flow_sweep_args;

/* Sweep callback: a range of nodes. */
static void pdi_flow_assemble_range(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pdi_flow_sweep_args *s = (const pdi_flow_sweep_args *)user;
    pdi_flow_assemble_block(s->flow, s->terms, i, row, count, s->ru, s->rc);
}

PDI_FN void pdi_flow_assemble_bond_sums(const pd_ctx *ctx, const pd_flow *flow, const pdi_flow_operands *t, double *ru,
                                        double *rc)
{
    pdi_flow_sweep_args s;
    s.flow = flow;
    s.terms = t;
    s.ru = ru;
    s.rc = rc;
    int64_t work = flow->grid->fluid_count * flow->bonds->stencil->count * 4;
    pdi_node_loop_by_ranges(ctx, flow->bonds, work, PDI_FLOW_BLOCK, pdi_flow_assemble_range, &s);
    pdi_isotropic_stencil_add_row_corrections(ctx, &flow->isotropic_stencil, flow->isotropic_blending * flow->nu, t->u,
                                              ru);
}

PDI_FN void pdi_flow_add_body_force(const pd_ctx *ctx, const pd_flow *flow, double *ru)
{
    const pd_bonds *bonds = flow->bonds;
    int64_t total = flow->grid->total;
    int nt = pd_par_threads(ctx, total * PD_DIM);
    (void)nt;
    if (!flow->body_force) return;
    PD_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < total; i++) {
        if (flow->grid->kind[i] != PD_FLUID) continue;
        double bend = bonds->row_of_node[i] >= 0 ? bonds->wall_curvature[bonds->row_of_node[i]] : 0.0;
        for (int d = 0; d < PD_DIM; d++) ru[d * total + i] -= (1.0 - bend) * flow->body_force[d * total + i];
    }
}

PDI_FN void pdi_flow_add_fourth_order(const pd_ctx *ctx, const pd_flow *flow, const double *u, const double *advecting,
                                      const double *grad, double *ru)
{
    const pd_fourth_order *sharp = &flow->fourth_order;
    pdi_fourth_order_field state, step;
    pdi_fourth_order_wall_terms drive;
    memset(&drive, 0, sizeof drive);
    if (!sharp->bonds) return;
    drive.grad = grad;
    state.advecting = flow->advecting;
    state.v = flow->u;
    state.second = sharp->second;
    if (u == flow->u) {
        drive.force = flow->force;
        drive.body = flow->body_force;
        drive.wall_motion = flow->wall_motion;
        pdi_fourth_order_add_momentum(ctx, sharp, &state, &state, flow->nu, ru);
        pdi_fourth_order_add_wall_friction(ctx, sharp, &state, &drive, flow->nu, ru);
        return;
    }
    step.advecting = advecting;
    step.v = u;
    step.second = sharp->second_increment;
    pdi_fourth_order_add_momentum(ctx, sharp, &state, &step, flow->nu, ru);
    pdi_fourth_order_add_momentum(ctx, sharp, &step, &state, 0.0, ru);
    pdi_fourth_order_add_wall_friction(ctx, sharp, &step, &drive, flow->nu, ru);
}

PDI_FN void pdi_flow_assemble_residual(pd_ctx *ctx, pd_flow *flow, double *ru, double *rc)
{
    pdi_flow_operands t;
    memset(&t, 0, sizeof t);
    pdi_flow_update_derived_fields(ctx, flow);
    t.advecting = flow->advecting;
    t.u = flow->u;
    t.p = flow->p;
    t.grad = flow->pressure_grad;
    t.force = flow->force;
    t.wall_motion = flow->wall_motion;
    pdi_flow_assemble_bond_sums(ctx, flow, &t, ru, rc);
    if (flow->pressure_impulse) pdi_par_axpy(ctx, flow->grid->total, 1.0, flow->pressure_impulse_flux, rc);
    pdi_flow_add_body_force(ctx, flow, ru);
    pdi_flow_add_fitted_wall(ctx, flow, flow->u, flow->p, flow->pressure_grad, 1, ru);
    pdi_flow_add_divergence_correction(ctx, flow, flow->u, flow->advecting, 1, 1.0, rc);
    pdi_flow_add_fourth_order(ctx, flow, flow->u, flow->advecting, flow->pressure_grad, ru);
    flow->evaluations++;
}

PDI_FN double pdi_flow_compute_bond_flux(const pd_flow *flow, int32_t i, int k)
{
    const pd_stencil *s = flow->bonds->stencil;
    int32_t total = flow->grid->total, j = i + flow->bonds->paths.shift[k];
    double share = pdi_bond_get_flux_factor(flow->bonds, i, k), a = pdi_bond_get_laplacian_weights(flow->bonds, i)[k];
    const double *w = flow->advecting, *g = s->gradient_weight + k * PD_DIM;
    double flux = share * pdi_flow_compute_convective_flux(g, w + i, total, w + j, total);
    if (flow->divergence_potential) flux -= a * (flow->divergence_potential[j] - flow->divergence_potential[i]);
    if (flow->grid->kind[i] == PD_INLET || flow->grid->kind[j] == PD_INLET) return flux;
    const double *p = flow->pressure_impulse ? flow->pressure_impulse : flow->p,
                 *grad = flow->pressure_impulse ? flow->pressure_impulse_grad : flow->pressure_grad;
    double stabiliser =
        pdi_flow_compute_stabilisation(s->xi + k * PD_DIM, p[j] - p[i], grad + i, total, grad + j, total);
    return flux - (flow->pressure_impulse ? 1.0 : flow->stabilisation) * a * (0.5 * stabiliser);
}

/* Callback: flux of a bond. */
static double pdi_flow_compute_section_bond(const void *user, int32_t i, int k)
{
    return pdi_flow_compute_bond_flux((const pd_flow *)user, i, k);
}

double pd_flow_integrate_section(pd_ctx *ctx, pd_flow *flow, int axis, int index)
{
    pdi_flow_update_derived_fields(ctx, flow);
    return pdi_node_loop_sum_plane_flux(flow->bonds, axis, index, pdi_flow_compute_section_bond, flow) *
           flow->bonds->stencil->volume;
}

PDI_COLD_BEGIN
/* Lists the arrays over inlet ghosts: inlet_velocity, has_tangential_weight, inlet_speed_ratio. */
static void pdi_flow_list_inlet_arrays(pdi_array_visitor *owner, void *object)
{
    pd_flow *flow = (pd_flow *)object;
    PDI_ARRAY(owner, flow, inlet_velocity, PD_DIM * (int64_t)flow->inlet_ghosts, "m/s");
    PDI_ARRAY(owner, flow, has_tangential_weight, flow->inlet_ghosts, "1");
    PDI_ARRAY(owner, flow, inlet_speed_ratio, flow->inlet_ghosts, "1");
}

/* Reallocates the arrays over inlet ghosts, zeroed, when their number has changed: solid behind an inlet may dissolve.
 * Nothing without an inlet callback. */
static pd_status pdi_flow_build_inlet_arrays(pd_ctx *ctx, pd_flow *flow)
{
    const pd_ghosts *ghosts = &flow->bonds->ghosts;
    int32_t inlets = ghosts->inlets_end - ghosts->outlets_end;
    if (!flow->inlet || inlets == flow->inlet_ghosts) return PD_OK;
    return pdi_array_registry_rebuild(ctx, pdi_flow_list_inlet_arrays, flow, &flow->inlet_ghosts, inlets);
}

/* Evaluates the inlet velocity at all inlet ghosts, images included, into inlet_velocity and u. With inlets_on_side at
 * points just outside of the side, and its ratios (eq. 3.11); else at the ghosts. *change: raised to the largest change
 * of a component [m/s]. PD_ERR_ARGUMENT: a component is not below 1e100 in size. Nothing without a callback. */
static pd_status pdi_flow_update_inlets(pd_ctx *ctx, pd_flow *flow, double *change)
{
    const pd_grid *grid = flow->grid;
    const pd_ghosts *ghosts = &flow->bonds->ghosts;
    PD_TRY(pdi_flow_build_inlet_arrays(ctx, flow));
    if (flow->inlets_on_side)
        pdi_inflow_compute_ratios(flow->bonds, flow->developed_sides, flow->has_tangential_weight,
                                  flow->inlet_speed_ratio);
    for (int32_t k = 0; k < flow->inlet_ghosts; k++) {
        int i[PD_DIM];
        double x[PD_DIM], u[PD_DIM];
        int32_t node = ghosts->node[ghosts->outlets_end + k];
        pd_grid_index(grid, node, i);
        int flip = pdi_grid_fold_index(grid, i);
        pd_grid_position(grid, pd_grid_node(grid, i), x);
        for (int d = 0; d < PD_DIM && flow->inlets_on_side; d++) {
            if (i[d] < 0) x[d] = grid->lo[d] - PDI_FLOW_OUTSIDE_OFFSET * grid->h[d];
            if (i[d] >= grid->n[d]) x[d] = grid->hi[d] + PDI_FLOW_OUTSIDE_OFFSET * grid->h[d];
        }
        flow->inlet(flow->inlet_user, x, u);
        for (int d = 0; d < PD_DIM; d++) {
            if (!(fabs(u[d]) < 1e100))
                return pd_fail(ctx, PD_ERR_ARGUMENT, "flow", "the inlet velocity at (%g, ...) m is %g m/s", *x, u[d]);
            double *value = &flow->inlet_velocity[d * flow->inlet_ghosts + k], fresh = flip >> d & 1 ? -u[d] : u[d];
            *change = pd_max(*change, fabs(fresh - *value));
            *value = flow->u[(int64_t)d * grid->total + node] = fresh;
        }
    }
    return PD_OK;
}

PDI_FN pd_status pdi_flow_set_inlets_on_side(pd_ctx *ctx, pd_flow *flow)
{
    double moved = 0.0;
    flow->inlets_on_side = flow->inlet != NULL;
    return pdi_flow_update_inlets(ctx, flow, &moved);
}

/* User data of pdi_flow_get_wall_velocity: the velocity callback and the largest component so far. */
typedef struct pdi_flow_wall_data {
    const pd_flow *flow;
    double max_speed; /* [m/s] */
} pdi_flow_wall_data;

/* Velocity u of the wall at x; records the largest component. */
static void pdi_flow_get_wall_velocity(void *user, const double *x, double *u)
{
    pdi_flow_wall_data *walls = (pdi_flow_wall_data *)user;
    walls->flow->wall(walls->flow->wall_user, x, u);
    for (int d = 0; d < PD_DIM; d++) walls->max_speed = pd_max(walls->max_speed, fabs(u[d]));
}

/* motion [PD_DIM] [1/m/s] = wall terms of row r beside moving walls (eq. 2.3), with their acceleration over nu as the
 * mean over time +- half_step [s] (eq. 3.46); no acceleration without a clock or with half_step 0. Raises
 * walls->max_speed by the velocities at the present time. The clock is set back to flow->time. */
static void pdi_flow_compute_wall_motion(pd_flow *flow, int32_t r, double half_step, pdi_flow_wall_data *walls,
                                         double *motion)
{
    const pd_bonds *bonds = flow->bonds;
    double curved[2][PD_DIM];
    pdi_bond_sum_wall_velocity(bonds, r, pdi_flow_get_wall_velocity, walls, motion, NULL);
    if (!flow->clock || !(half_step > 0.0)) return;
    for (int k = 0; k < 2; k++) {
        double unread[PD_DIM];
        *flow->clock = flow->time + (k ? half_step : -half_step);
        pdi_bond_sum_wall_velocity(bonds, r, flow->wall, flow->wall_user, unread, curved[k]);
    }
    *flow->clock = flow->time;
    for (int d = 0; d < PD_DIM; d++) motion[d] += (curved[1][d] - curved[0][d]) / (2.0 * half_step * flow->nu);
}

/* Sets from U the weight tau of the pressure flux, 1/tau = sum over axes of nu/h^2 + U/(2h) (eq. 3.8), and the blending
 * of the isotropic friction (eq. 3.17). Weakly compressible flow keeps its tau. */
static void pdi_flow_update_stabilisation(pd_flow *flow)
{
    double rate = 0.0;
    for (int d = 0; d < PD_DIM; d++)
        rate += (flow->nu / flow->grid->h[d] + 0.5 * flow->velocity_scale) / flow->grid->h[d];
    if (!flow->is_weakly_compressible) flow->stabilisation = 1.0 / rate;
    flow->isotropic_blending =
        pdi_isotropic_stencil_compute_blending(&flow->isotropic_stencil, flow->velocity_scale / flow->nu);
}

/* Sets length_scale L and velocity_scale U (eq. 3.9). U is the largest of the inlet speed, the wall speed `walls`
 * [m/s] and the speed that the largest force component along periodic axes drives. Where all are 0: the speed that the
 * largest force component along any axis drives; where that is 0, too: nu/L. */
static void pdi_flow_estimate_scales(pd_flow *flow, double walls)
{
    double force = 0.0, around = 0.0;
    flow->length_scale = pdi_flow_scales_compute_length(flow->grid);
    for (int d = 0; d < PD_DIM; d++) {
        double largest = fabs(flow->force[d]);
        for (int32_t node = 0; node < flow->grid->total && flow->body_force; node++)
            if (flow->grid->kind[node] == PD_FLUID)
                largest = pd_max(largest, fabs(pdi_flow_get_body_force(flow, d, node)));
        force = pd_max(force, largest);
        if (flow->grid->side[2 * d] == PD_SIDE_PERIODIC) around = pd_max(around, largest);
    }
    flow->velocity_scale = pd_max(pd_max(pdi_flow_scales_compute_inlet_speed(flow->grid, flow->u), walls),
                                  pdi_flow_scales_compute_forced_speed(flow->nu, flow->length_scale, around));
    if (!(flow->velocity_scale > 0.0))
        flow->velocity_scale = pdi_flow_scales_compute_forced_speed(flow->nu, flow->length_scale, force);
    if (!(flow->velocity_scale > 0.0)) flow->velocity_scale = flow->nu / flow->length_scale; /* nothing moves */
}

PDI_FN void pdi_flow_update_speed_scale(pd_flow *flow)
{
    const pd_grid *grid = flow->grid;
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_FLUID) continue;
        for (int64_t d = 0; d < PD_DIM; d++)
            flow->velocity_scale = pd_max(flow->velocity_scale, fabs(flow->u[d * grid->total + i]));
    }
    pdi_flow_update_stabilisation(flow);
}

/* Updates wall_motion at all rows. *max_speed: largest velocity component of walls [m/s], 0 without a wall callback.
 * *change: raised to the largest change of wall_motion over wall_laplacian [m/s]. PD_ERR_ARGUMENT: a wall term is not
 * below 1e100 in size; earlier rows are updated. */
static pd_status pdi_flow_update_wall_motion(pd_ctx *ctx, pd_flow *flow, double half_step, double *change,
                                             double *max_speed)
{
    const pd_bonds *bonds = flow->bonds;
    double motion[PD_DIM], largest = 0.0;
    pdi_flow_wall_data walls;
    walls.flow = flow;
    walls.max_speed = 0.0;
    for (int32_t r = 0; r < bonds->rows && flow->wall; r++) {
        pdi_flow_compute_wall_motion(flow, r, half_step, &walls, motion);
        for (int d = 0; d < PD_DIM; d++) {
            double *value = &flow->wall_motion[(int64_t)d * flow->grid->total + bonds->node[r]];
            if (!(fabs(motion[d]) < 1e100)) {
                char place[PDI_GRID_POSITION_LENGTH];
                return pd_fail(ctx, PD_ERR_ARGUMENT, "flow", "the velocity of the wall beside %s m is no finite one",
                               pdi_grid_format_position(flow->grid, bonds->node[r], place));
            }
            if (bonds->wall_laplacian[r] > 0.0)
                largest = pd_max(largest, fabs(motion[d] - *value) / bonds->wall_laplacian[r]);
            *value = motion[d];
        }
    }
    *change = pd_max(*change, largest);
    *max_speed = walls.max_speed;
    return PD_OK;
}

/* Evaluates body_force at fluid nodes and metal (it may dissolve). *change: raised to the largest change of a component
 * [m/s2]. PD_ERR_ARGUMENT: a component is not below 1e100 in size. Nothing without a body force callback. */
static pd_status pdi_flow_update_body_force(pd_ctx *ctx, pd_flow *flow, double *change)
{
    const pd_grid *grid = flow->grid;
    for (int32_t node = 0; node < grid->total && flow->body_force; node++) {
        double x[PD_DIM], f[PD_DIM];
        if (grid->kind[node] != PD_FLUID && grid->kind[node] != PD_SOLID) continue;
        pd_grid_position(grid, node, x);
        flow->body_force_fn(flow->body_force_user, x, f);
        for (int d = 0; d < PD_DIM; d++) {
            double *value = &flow->body_force[(int64_t)d * grid->total + node];
            if (!(fabs(f[d]) < 1e100))
                return pd_fail(ctx, PD_ERR_ARGUMENT, "flow", "the body force at (%g, ...) m is %g m/s2", x[0], f[d]);
            *change = pd_max(*change, fabs(f[d] - *value));
            *value = f[d];
        }
    }
    return PD_OK;
}

/* Sets flow->time, the clock, all boundary data and the body force to time t [s]. half_step [s]: half of the interval
 * over which accelerations of walls are means; 0: none. *change [-]: the larger of velocity change over U and force
 * change over the momentum scale; NULL: not wanted. *walls: largest wall speed [m/s]. U and tau stay. PD_ERR_ARGUMENT:
 * a value is not finite; *change is not set. */
static pd_status pdi_flow_update_boundary_data(pd_ctx *ctx, pd_flow *flow, double t, double half_step, double *change,
                                               double *walls)
{
    double velocity = 0.0, force = 0.0;
    flow->time = t;
    if (flow->clock) *flow->clock = t;
    PD_TRY(pdi_flow_update_inlets(ctx, flow, &velocity));
    PD_TRY(pdi_flow_update_wall_motion(ctx, flow, half_step, &velocity, walls));
    PD_TRY(pdi_flow_update_body_force(ctx, flow, &force));
    if (change)
        *change = pd_max(velocity / flow->velocity_scale,
                          force / pdi_flow_get_momentum_scale(flow, flow->velocity_scale, flow->length_scale));
    return PD_OK;
}

PDI_FN pd_status pdi_flow_set_time(pd_ctx *ctx, pd_flow *flow, double t, double half_step, double *change)
{
    double walls;
    if (change) *change = 0.0;
    if (!flow->clock) return PD_OK;
    PD_TRY(pdi_flow_update_boundary_data(ctx, flow, t, half_step, change, &walls));
    double speed = pd_max(pdi_flow_scales_compute_inlet_speed(flow->grid, flow->u), walls);
    if (!(speed > flow->velocity_scale)) return PD_OK;
    flow->velocity_scale = speed; /* the problem has become a faster one */
    pdi_flow_update_stabilisation(flow);
    return PD_OK;
}

PDI_FN void pdi_flow_list(pdi_array_visitor *owner, void *object)
{
    pd_flow *flow = (pd_flow *)object;
    int64_t total = flow->grid ? flow->grid->total : 0;
    PDI_ARRAY_STATE(owner, flow, u, PD_DIM * total, "m/s");
    PDI_ARRAY_STATE(owner, flow, p, total, "m2/s2");
    PDI_ARRAY(owner, flow, pressure_grad, PD_DIM * total, "m/s2");
    PDI_ARRAY(owner, flow, advecting, PD_DIM * total, "m/s");
    if (flow->wall) PDI_ARRAY(owner, flow, wall_motion, PD_DIM * total, "1/m/s");
    if (flow->body_force_fn) PDI_ARRAY(owner, flow, body_force, PD_DIM * total, "m/s2");
    PDI_SCALAR_STATE(owner, flow, evaluations, "1");
    PDI_SCALAR_STATE(owner, flow, velocity_scale, "m/s");
    PDI_SCALAR_STATE(owner, flow, stabilisation, "s");
    PDI_SCALAR_STATE(owner, flow, isotropic_blending, "1");
    if (flow->clock) PDI_SCALAR_STATE(owner, flow, time, "s");
}

/* PD_ERR_ARGUMENT: a value of desc is out of its range or not finite, or the order is unknown. */
static pd_status pdi_flow_check_desc(pd_ctx *ctx, const pd_flow_desc *desc)
{
    double nu = desc->mu / desc->rho, p = desc->p_out / desc->rho, speed = desc->report_speed, l = desc->report_length;
    if (!(desc->rho > 0.0) || !(desc->rho < HUGE_VAL) || !(desc->mu > 0.0) || !(desc->mu < HUGE_VAL) ||
        !(fabs(desc->p_out) < HUGE_VAL) || !(speed >= 0.0) || !(speed < 1e100) || !(l >= 0.0) || !(l < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "flow",
                       "rho = %g kg/m3, mu = %g Pa s, p_out = %g Pa, speed = %g m/s, length = %g m: expected finite "
                       "values, of which the first two are positive and the last two not negative",
                       desc->rho, desc->mu, desc->p_out, speed, l);
    if (!(nu > 0.0) || !(nu < 1e100) || !(fabs(p) < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "flow",
                       "mu/rho = %g m2/s, p_out/rho = %g m2/s2: expected values below 1e100, the first one above 0", nu,
                       p);
    for (int d = 0; d < PD_DIM; d++)
        if (!(fabs(desc->force[d]) < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "flow", "force = %g m/s2, expected a finite one", desc->force[d]);
    if (desc->order == 0 || desc->order == 2 || desc->order == 4 || desc->order == PD_FLOW_ORDER_AUTO) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "flow", "order = %d, expected 2 or 4", desc->order);
}

/* Inner part of the build: checks desc, fills the fields, allocates, sets p = p_out at fluid nodes, boundary data of
 * time 0, scales and tau. Isotropic friction weights unless order 4. The caller frees after an error. */
static pd_status pdi_flow_try_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow_desc *desc,
                                    pd_flow *flow)
{
    memset(flow, 0, sizeof *flow);
    PD_TRY(pdi_flow_check_desc(ctx, desc));
    if (bonds->options & PD_BONDS_NO_FLOW)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "flow", "the bonds are those of fluid at rest (PD_BONDS_NO_FLOW)");
    flow->grid = grid;
    flow->bonds = bonds;
    flow->rho = desc->rho;
    flow->nu = desc->mu / desc->rho;
    flow->p_out = desc->p_out / desc->rho;
    flow->inlet = desc->inlet;
    flow->inlet_user = desc->inlet_user;
    flow->developed_sides = desc->developed_sides;
    flow->wall = desc->wall;
    flow->wall_user = desc->wall_user;
    flow->body_force_fn = desc->body;
    flow->body_force_user = desc->body_user;
    flow->clock = desc->clock;
    flow->order = desc->order;
    if (flow->order != 4) pdi_isotropic_stencil_build(bonds, &flow->isotropic_stencil);
    for (int d = 0; d < PD_DIM; d++) flow->force[d] = desc->force[d];
    PD_TRY(pdi_array_registry_build(ctx, pdi_flow_list, flow));
    for (int32_t node = 0; node < grid->total; node++)
        if (grid->kind[node] == PD_FLUID) flow->p[node] = flow->p_out;
    double walls;
    PD_TRY(pdi_flow_update_boundary_data(ctx, flow, 0.0, 0.0, NULL, &walls));
    pdi_flow_estimate_scales(flow, walls);
    pdi_flow_update_stabilisation(flow);
    flow->reference_speed = desc->report_speed > 0.0 ? desc->report_speed : flow->velocity_scale;
    flow->reference_length = desc->report_length > 0.0 ? desc->report_length : flow->length_scale;
    return PD_OK;
}

pd_status pd_flow_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow_desc *desc,
                        pd_flow *flow)
{
    pd_status status = pdi_flow_try_build(ctx, grid, bonds, desc, flow);
    if (status < 0) pd_flow_free(ctx, flow);
    return status;
}
PDI_COLD_END

/* Average kinematic pressure of the fluid nodes that node i has open bonds to, without those where it is NaN; NaN:
 * there are none. */
static double pdi_flow_average_neighbour_pressure(const pd_flow *flow, int32_t i)
{
    const pd_bonds *bonds = flow->bonds;
    double sum = 0.0;
    int found = 0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        int32_t j = i + bonds->paths.shift[k];
        if (flow->grid->kind[j] != PD_FLUID || isnan(flow->p[j]) ||
            pdi_bond_path_find_closed_group(&bonds->paths, i, k) >= 0)
            continue;
        sum += flow->p[j];
        found++;
    }
    return found ? sum / found : NAN;
}

pd_status pd_flow_update(pd_ctx *ctx, const int32_t *changed, int32_t count, pd_flow *flow)
{
    double *average = flow->u; /* at nodes without a pressure, until all of their layer have one */
    for (int32_t c = 0; c < count; c++) flow->p[changed[c]] = NAN;
    for (int32_t found = count; found;) { /* layer by layer from what was fluid before */
        for (int32_t c = 0; c < count; c++)
            if (isnan(flow->p[changed[c]])) average[changed[c]] = pdi_flow_average_neighbour_pressure(flow, changed[c]);
        found = 0;
        for (int32_t c = 0; c < count; c++) {
            int32_t i = changed[c];
            if (!isnan(flow->p[i]) || isnan(average[i])) continue;
            flow->p[i] = average[i];
            found++;
        }
    }
    for (int32_t c = 0; c < count; c++) {
        if (isnan(flow->p[changed[c]])) flow->p[changed[c]] = flow->p_out;
        for (int d = 0; d < PD_DIM; d++) flow->u[(int64_t)d * flow->grid->total + changed[c]] = 0.0;
    }
    double walls;
    return pdi_flow_update_boundary_data(ctx, flow, flow->time, 0.0, NULL, &walls);
}

PDI_COLD_BEGIN
PDI_FN pd_status pdi_flow_store(pd_ctx *ctx, pd_flow *flow, pd_archive *archive)
{
    PD_TRY(pdi_array_registry_store(ctx, pdi_flow_list, flow, archive));
    if (archive->is_reading) PD_TRY(pdi_flow_set_time(ctx, flow, flow->time, 0.0, NULL));
    if (archive->is_reading) pdi_flow_update_derived_fields(ctx, flow);
    return PD_OK;
}

void pd_flow_free(pd_ctx *ctx, pd_flow *flow)
{
    pdi_array_registry_free(ctx, pdi_flow_list, flow);
    pdi_array_registry_free(ctx, pdi_flow_list_inlet_arrays, flow);
    pdi_array_registry_free(ctx, pdi_flow_list_row_arrays, flow);
    pdi_reconstruct_free(ctx, &flow->wall_fit);
    pdi_fourth_order_free(ctx, &flow->fourth_order);
    memset(flow, 0, sizeof *flow);
}
PDI_COLD_END
