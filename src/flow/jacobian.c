/* jacobian: see jacobian.h
 *
 * The terms are those of the residual (flow.c): 1/2 sum g.(w_i + w_j) v_j with one of advecting velocity w and
 * velocity v from the state and the other one from the step, the Laplacian, and the pressure stabilisation. Sums of a
 * block stay in registers; where families are whole, opposite bonds go together.
 */
#include "flow/jacobian.h"
#include "core/par.h"
#include "lattice/op.h"
#include <math.h>
#include <string.h>

#define PDI_JACOBIAN_BLOCK PDI_VECTOR_LENGTH  /* nodes of a block */
#define PDI_JACOBIAN_WEIGHTS (2 * PD_DIM + 2) /* floats of a bond: gradient, offset, Laplacian, friction */

/* Values of a block of nodes, which every bond reads again. */
typedef struct pdi_jacobian_block_values {
    float state_advecting[PD_DIM][PDI_JACOBIAN_BLOCK]; /* advecting velocity of the state */
    float advecting[PD_DIM][PDI_JACOBIAN_BLOCK], u[PD_DIM][PDI_JACOBIAN_BLOCK], grad[PD_DIM][PDI_JACOBIAN_BLOCK];
    float p[PDI_JACOBIAN_BLOCK];
} pdi_jacobian_block_values;

/* Twice the sums of a block; that of momentum less u_i times the fluxes of the state. */
typedef struct pdi_jacobian_block_sums {
    float momentum[PD_DIM][PDI_JACOBIAN_BLOCK], flux[PDI_JACOBIAN_BLOCK], stabiliser[PDI_JACOBIAN_BLOCK];
} pdi_jacobian_block_sums;

/* Pointers into the packed arrays, from a node on. */
typedef struct pdi_jacobian_arrays {
    const float *state_advecting, *state_u; /* advecting and node velocity of the state */
    const float *advecting, *u, *grad, *p; /* of the step */
    int64_t total;
} pdi_jacobian_arrays;

/* Pointers to the values of `node` and those behind it. */
PDI_INLINE pdi_jacobian_arrays pdi_jacobian_get_arrays(const pd_jacobian *q, int64_t node)
{
    pdi_jacobian_arrays v;
    v.total = q->flow->grid->total;
    v.state_advecting = q->packed_state + node;
    v.state_u = v.state_advecting + PD_DIM * v.total;
    v.advecting = q->packed_increment + node;
    v.u = v.advecting + PD_DIM * v.total;
    v.grad = v.u + PD_DIM * v.total;
    v.p = v.grad + PD_DIM * v.total;
    return v;
}

/* Copies the values of `count` nodes. */
PDI_INLINE void pdi_jacobian_copy_block(const pdi_jacobian_arrays *at, int count,
                                        pdi_jacobian_block_values *PD_RESTRICT own)
{
    for (int d = 0; d < PD_DIM; d++) {
        for (int b = 0; b < count; b++) own->state_advecting[d][b] = at->state_advecting[d * at->total + b];
        for (int b = 0; b < count; b++) own->advecting[d][b] = at->advecting[d * at->total + b];
        for (int b = 0; b < count; b++) own->u[d][b] = at->u[d * at->total + b];
        for (int b = 0; b < count; b++) own->grad[d][b] = at->grad[d * at->total + b];
    }
    for (int b = 0; b < count; b++) own->p[b] = at->p[b];
}

/* Adds a bond and the opposite one, whose far ends are `far` and `back`, for full families. weight: those of the bond;
 * friction: 2 nu a, scaled. Inlined with a constant for `count`. */
PDI_INLINE void pdi_jacobian_add_bond_pair(const pdi_jacobian_block_values *PD_RESTRICT own, const float *weight,
                                           float friction, const pdi_jacobian_arrays *far,
                                           const pdi_jacobian_arrays *back, int count,
                                           pdi_jacobian_block_sums *PD_RESTRICT sums)
{
    const float *g = weight, *xi = weight + PD_DIM;
    int64_t total = far->total;
    for (int b = 0; b < count; b++) {
        float here = pdi_flow_dot_single(g, &own->advecting[0][b], PDI_JACOBIAN_BLOCK);
        float there = pdi_flow_dot_single(g, far->advecting + b, total);
        float behind = pdi_flow_dot_single(g, back->advecting + b, total);
        float here0 = pdi_flow_dot_single(g, &own->state_advecting[0][b], PDI_JACOBIAN_BLOCK);
        float gain = here0 + pdi_flow_dot_single(g, far->state_advecting + b, total) - friction;
        float loss = here0 + pdi_flow_dot_single(g, back->state_advecting + b, total) + friction;
        float out = here + there, in = here + behind;
        float stabiliser = 2.0f * ((far->p[b] - own->p[b]) + (back->p[b] - own->p[b]));
        for (int d = 0; d < PD_DIM; d++) stabiliser -= xi[d] * (far->grad[d * total + b] - back->grad[d * total + b]);
        sums->flux[b] += there - behind;
        sums->stabiliser[b] += weight[2 * PD_DIM] * stabiliser;
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = d * total + b;
            sums->momentum[d][b] += (gain * (far->u[at] - own->u[d][b]) - loss * (back->u[at] - own->u[d][b])) +
                                    (out * far->state_u[at] - in * back->state_u[at]);
        }
    }
}

/* Adds a single bond. share: factor of an axisymmetric face; open: 1 or 0 for each node; pressure 0: no pressure
 * flux. */
PDI_INLINE void pdi_jacobian_add_bond(const pdi_jacobian_block_values *PD_RESTRICT own, const float *weight, float lap,
                                      float friction, float share, const float *PD_RESTRICT open, float pressure,
                                      const pdi_jacobian_arrays *far, int count,
                                      pdi_jacobian_block_sums *PD_RESTRICT sums)
{
    const float *g = weight, *xi = weight + PD_DIM;
    int64_t total = far->total;
    for (int b = 0; b < count; b++) {
        float part = share * open[b];
        float flux = part * (pdi_flow_dot_single(g, &own->advecting[0][b], PDI_JACOBIAN_BLOCK) +
                             pdi_flow_dot_single(g, far->advecting + b, total));
        float gain = part * (pdi_flow_dot_single(g, &own->state_advecting[0][b], PDI_JACOBIAN_BLOCK) +
                             pdi_flow_dot_single(g, far->state_advecting + b, total)) -
                     open[b] * friction;
        float stabiliser = pdi_flow_compute_stabilisation_single(xi, far->p[b] - own->p[b], &own->grad[0][b],
                                                                 PDI_JACOBIAN_BLOCK, far->grad + b, total);
        sums->flux[b] += flux;
        sums->stabiliser[b] += pressure * open[b] * (lap * stabiliser);
        for (int d = 0; d < PD_DIM; d++)
            sums->momentum[d][b] += gain * (far->u[d * total + b] - own->u[d][b]) + flux * far->state_u[d * total + b];
    }
}

/* Adds all bonds of `count` nodes from i: of full families (row -1), or the open ones of the rows from `row`. Bonds to
 * inlets carry no pressure flux. Full families of planar lattices go in pairs of opposite bonds; axisymmetric ones have
 * the Laplacian weights of the node also for friction. Inlined with a constant for `count`. */
PDI_INLINE_HOT void pdi_jacobian_add_bonds(const pd_jacobian *q, int32_t i, int32_t row, int count,
                                           pdi_jacobian_block_sums *PD_RESTRICT sums)
{
    const pd_flow *flow = q->flow;
    const pd_bonds *bonds = flow->bonds;
    const pd_stencil *s = bonds->stencil;
    pdi_jacobian_arrays at = pdi_jacobian_get_arrays(q, i);
    pdi_jacobian_block_values own;
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    float open[PDI_JACOBIAN_BLOCK], twice_nu = (float)(2.0 * flow->nu / (q->speed * q->length));
    const double *lap = bonds->axisym.laplacian_weight ? pdi_bond_get_laplacian_weights(bonds, i) : NULL;
    pdi_jacobian_copy_block(&at, count, &own);
    for (int b = 0; b < count; b++) open[b] = 1.0f;
    if (row < 0 && !lap) {
        for (int k = 0; k < s->count / 2; k++) {
            const float *weight = q->bond_weights + k * PDI_JACOBIAN_WEIGHTS;
            pdi_jacobian_arrays far = pdi_jacobian_get_arrays(q, (int64_t)i + bonds->paths.shift[k]);
            pdi_jacobian_arrays back = pdi_jacobian_get_arrays(q, (int64_t)i - bonds->paths.shift[k]);
            pdi_jacobian_add_bond_pair(&own, weight, twice_nu * weight[2 * PD_DIM + 1], &far, &back, count, sums);
        }
        return;
    }
    for (int k = 0; k < s->count; k++) {
        const float *weight = q->bond_weights + k * PDI_JACOBIAN_WEIGHTS;
        float pressure = 1.0f, a = lap ? (float)(lap[k] * q->length * q->length) : weight[2 * PD_DIM];
        float rub = lap ? a : weight[2 * PD_DIM + 1];
        if (row >= 0) {
            if (pdi_bond_find_rows_open(bonds, row, k, count, &gate) == PDI_BOND_OPEN_NONE) continue;
            for (int b = 0; b < count; b++) open[b] = (float)pdi_bond_get_open_factor(&gate, k, b);
            if (row >= bonds->rows_without_inlet && flow->grid->kind[i + bonds->paths.shift[k]] == PD_INLET)
                pressure = 0.0f;
        }
        pdi_jacobian_arrays far = pdi_jacobian_get_arrays(q, (int64_t)i + bonds->paths.shift[k]);
        pdi_jacobian_add_bond(&own, weight, a, twice_nu * rub,
                              lap ? (float)pdi_bond_get_flux_factor(bonds, i, k) : 1.0f, open, pressure, &far, count,
                              sums);
    }
}

/* Not inlined: for blocks shorter than a vector. */
PDI_NO_VECTORISE void pdi_jacobian_add_short_block(const pd_jacobian *q, int32_t i, int32_t row, int count,
                                                   pdi_jacobian_block_sums *sums)
{
    pdi_jacobian_add_bonds(q, i, row, count, sums);
}

/* Arguments of the sweep over all nodes. */
typedef struct pdi_jacobian_sweep_args {
    const pd_jacobian *jacobian;
    const pdi_jacobian_increment *step;
    double *yu, *yc; /* [m/s2] [1/s] */
} pdi_jacobian_sweep_args;

/* Sweep callback: product for `count` nodes from i, with the linear wall and hoop terms (eq. 2.3, 2.4, 1.10). */
static void pdi_jacobian_apply_range(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pdi_jacobian_sweep_args *w = (const pdi_jacobian_sweep_args *)user;
    const pd_jacobian *q = w->jacobian;
    const pd_flow *flow = q->flow;
    const pd_bonds *bonds = flow->bonds;
    const double *hoop = bonds->axisym.hoop;
    double rate = q->speed / q->length;
    enum { whole = PDI_JACOBIAN_BLOCK };
    pdi_jacobian_block_sums sums;
    memset(&sums, 0, sizeof sums);
    if (count == whole) pdi_jacobian_add_bonds(q, i, row, whole, &sums);
    else pdi_jacobian_add_short_block(q, i, row, count, &sums);
    double weight = 0.5 * pdi_flow_get_pressure_flux_weight(flow) * rate * rate;
    for (int b = 0; b < count; b++)
        w->yc[i + b] = rate * (double)sums.flux[b] - weight * (double)sums.stabiliser[b];
    for (int d = 0; d < PD_DIM; d++) {
        double turn = hoop && d == PD_DIM - 1 ? hoop[i / flow->grid->stride[d]] : 0.0;
        for (int b = 0; b < count; b++) {
            int64_t at = (int64_t)d * flow->grid->total + i + b;
            double bend = row >= 0 ? bonds->wall_curvature[row + b] : 0.0;
            double lap = row >= 0 ? turn + bonds->wall_laplacian[row + b] : turn;
            w->yu[at] = 0.5 * q->speed * rate * (double)sums.momentum[d][b] +
                        (0.5 * q->divergence[i + b] + flow->nu * lap) * w->step->u[at] +
                        (1.0 - bend) * w->step->grad[at];
        }
    }
}

/* out [count] = factor x, in single precision. */
static void pdi_jacobian_copy_scaled(const pd_ctx *ctx, const double *x, double factor, int64_t count, float *out)
{
    int nt = pd_par_threads(ctx, count);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < count; i++) out[i] = (float)(x[i] * factor);
}

/* Updates the friction weights of full families, whose isotropic part depends on the speed of the flow (eq. 3.17). */
static void pdi_jacobian_update_friction_weights(pd_jacobian *q)
{
    const pd_flow *flow = q->flow;
    const pd_stencil *s = flow->bonds->stencil;
    for (int k = 0; k < s->count; k++) {
        double rub = s->laplacian_weight[k];
        if (flow->isotropic_stencil.bonds) rub += flow->isotropic_blending * flow->isotropic_stencil.weight_excess[k];
        q->bond_weights[k * PDI_JACOBIAN_WEIGHTS + 2 * PD_DIM + 1] = (float)(rub * q->length * q->length);
    }
}

PDI_FN void pdi_jacobian_set_state(const pd_ctx *ctx, pd_jacobian *q)
{
    const pd_flow *flow = q->flow;
    int64_t split = PD_DIM * (int64_t)flow->grid->total;
    pdi_jacobian_copy_scaled(ctx, flow->advecting, 1.0 / q->speed, split, q->packed_state);
    pdi_jacobian_copy_scaled(ctx, flow->u, 1.0 / q->speed, split, q->packed_state + split);
    pd_op_divergence(ctx, flow->bonds, flow->advecting, q->divergence);
    pdi_jacobian_update_friction_weights(q);
}

PDI_FN void pdi_jacobian_apply(const pd_ctx *ctx, const pd_jacobian *q, const pdi_jacobian_increment *step, double *yu,
                               double *yc)
{
    const pd_flow *flow = q->flow;
    int64_t total = flow->grid->total, split = PD_DIM * total;
    double speed = q->speed;
    pdi_jacobian_sweep_args w;
    pdi_jacobian_copy_scaled(ctx, step->advecting, 1.0 / speed, split, q->packed_increment);
    pdi_jacobian_copy_scaled(ctx, step->u, 1.0 / speed, split, q->packed_increment + split);
    pdi_jacobian_copy_scaled(ctx, step->grad, q->length / (speed * speed), split, q->packed_increment + 2 * split);
    pdi_jacobian_copy_scaled(ctx, step->p, 1.0 / (speed * speed), total, q->packed_increment + 3 * split);
    w.jacobian = q;
    w.step = step;
    w.yu = yu;
    w.yc = yc;
    pdi_node_loop_by_ranges(ctx, flow->bonds, flow->grid->fluid_count * flow->bonds->stencil->count * 4,
                            PDI_JACOBIAN_BLOCK, pdi_jacobian_apply_range, &w);
}

PDI_COLD_BEGIN
/* The next power of two above x, twice x where x is one itself: scaling by it is exact. x 0 gives 1. */
static double pdi_jacobian_compute_unit(double x)
{
    int exponent;
    frexp(x, &exponent);
    return ldexp(1.0, exponent);
}

PDI_FN void pdi_jacobian_list(pdi_array_visitor *owner, void *object)
{
    pd_jacobian *jacobian = (pd_jacobian *)object;
    if (!jacobian->flow) return;
    int64_t count = jacobian->flow->bonds->stencil->count;
    PDI_ARRAY(owner, jacobian, bond_weights, count * PDI_JACOBIAN_WEIGHTS, "1");
}

PDI_FN void pdi_jacobian_list_work(pdi_array_visitor *owner, void *object)
{
    pd_jacobian *jacobian = (pd_jacobian *)object;
    int64_t total = jacobian->flow ? jacobian->flow->grid->total : 0;
    PDI_ARRAY_UNINIT(owner, jacobian, packed_state, 2 * PD_DIM * total, "1");
    PDI_ARRAY_UNINIT(owner, jacobian, packed_increment, (3 * PD_DIM + 1) * total, "1");
    PDI_ARRAY(owner, jacobian, divergence, total, "1/s");
}

PDI_FN pd_status pdi_jacobian_build(pd_ctx *ctx, const pd_flow *flow, pd_jacobian *q)
{
    const pd_stencil *s = flow->bonds->stencil;
    double longest = 0.0;
    memset(q, 0, sizeof *q);
    q->flow = flow;
    for (int d = 0; d < PD_DIM; d++) longest = pd_max(longest, flow->grid->h[d]);
    q->speed = pdi_jacobian_compute_unit(flow->velocity_scale);
    q->length = pdi_jacobian_compute_unit(longest);
    PD_TRY(pdi_array_registry_build(ctx, pdi_jacobian_list, q));
    for (int k = 0; k < s->count; k++) {
        float *weight = q->bond_weights + k * PDI_JACOBIAN_WEIGHTS;
        for (int d = 0; d < PD_DIM; d++) {
            weight[d] = (float)(s->gradient_weight[k * PD_DIM + d] * q->length);
            weight[PD_DIM + d] = (float)(s->xi[k * PD_DIM + d] / q->length);
        }
        weight[2 * PD_DIM] = (float)(s->laplacian_weight[k] * q->length * q->length);
    }
    pdi_jacobian_update_friction_weights(q);
    return PD_OK;
}

PDI_FN void pdi_jacobian_free(pd_ctx *ctx, pd_jacobian *q)
{
    pdi_array_registry_free(ctx, pdi_jacobian_list, q);
    memset(q, 0, sizeof *q);
}
PDI_COLD_END
