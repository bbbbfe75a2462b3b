/* schur_precond: see schur_precond.h */
#include "flow/schur_precond.h"
#include "core/par.h"
#include <math.h>

/* Factor on the convective part of 1/tau in the viscosity for smooth residuals, c of eq. 3.29. */
#define PDI_SCHUR_PRECOND_CONVECTIVE_FACTOR 0.3

#define PDI_SCHUR_PRECOND_EVEN 1.0   /* ratio of a scalar on both sides of a closed face */
#define PDI_SCHUR_PRECOND_ODD (-1.0) /* ratio of a vector on both sides of a closed face */

/* Arguments of a sweep: reads `input`, writes `output`. */
typedef struct pdi_schur_precond_sweep_args {
    const pd_flow *flow;
    const double *input;
    double *output;
} pdi_schur_precond_sweep_args;

/* ---- mobility ---- */

/* Adds the wall drag [1/s] of `count` fluid nodes in a line from `first`. Between two walls flow is a parabola, so
 * 1/drag = (distance to one wall)(distance to the other)/(2 nu); the other end of a line with one wall is a mirror.
 * below, above: 1 where a wall ends the line. Nothing without walls. */
static void pdi_schur_precond_add_wall_drag(const pd_flow *flow, int axis, int32_t first, int count, int below,
                                            int above, double *drag)
{
    const pd_grid *grid = flow->grid;
    double rate = 2.0 * flow->nu / (grid->h[axis] * grid->h[axis]), width = (below && above ? 1.0 : 2.0) * count;
    for (int k = 0; k < count && (below || above); k++) {
        double distance = below ? k + 0.5 : count - k - 0.5;
        drag[first + k * grid->stride[axis]] += rate / (distance * (width - distance));
    }
}

/* Adds the wall drag [1/s] along the grid line of `axis` that begins at `node`, for each stretch of fluid nodes in it.
 * A closed node at its end is a wall; any other, inlets and outlets too, a mirror. */
static void pdi_schur_precond_add_line_drag(const pd_flow *flow, int axis, int32_t node, double *drag)
{
    const pd_grid *grid = flow->grid;
    int32_t stride = grid->stride[axis];
    for (int i = 0; i < grid->n[axis]; i++) {
        int first = i;
        while (i < grid->n[axis] && grid->kind[node + i * stride] == PD_FLUID) i++;
        if (i == first) continue;
        pdi_schur_precond_add_wall_drag(flow, axis, node + first * stride, i - first,
                                        !pdi_grid_is_open(grid->kind[node + (first - 1) * stride]),
                                        !pdi_grid_is_open(grid->kind[node + i * stride]), drag);
    }
}

PDI_FN void pdi_schur_precond_compute_mobility(const pd_ctx *ctx, const pd_flow *flow, double shift, double *mobility)
{
    const pd_grid *grid = flow->grid;
    int nt = pd_par_threads(ctx, grid->total * 8);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < grid->total; i++) mobility[i] = shift;
    for (int axis = 0; axis < PD_DIM; axis++) {
        int32_t lines = 1;
        for (int d = 0; d < PD_DIM; d++) lines *= d == axis ? 1 : grid->n[d];
        PD_PARALLEL_FOR(nt)
        for (int32_t line = 0; line < lines; line++) {
            int i[PD_DIM];
            int32_t rest = line;
            for (int d = 0; d < PD_DIM; d++) {
                int n = d == axis ? 1 : grid->n[d];
                i[d] = (int)(rest % n);
                rest /= n;
            }
            pdi_schur_precond_add_line_drag(flow, axis, pd_grid_node(grid, i), mobility);
        }
    }
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < grid->total; i++)
        mobility[i] = grid->kind[i] == PD_FLUID && mobility[i] > 0.0 ? 1.0 / mobility[i] : 0.0;
}

/* ---- commutator ---- */

/* f at the lower or upper neighbour of node i along axis d; where that is closed or an inlet, `closed` times f of the
 * node. */
static double pdi_schur_precond_get_neighbour(const pd_grid *grid, const double *f, int32_t i, int d, int up,
                                              double closed)
{
    int32_t j = up ? i + grid->stride[d] : i - grid->stride[d];
    uint8_t kind = grid->kind[j];
    return pdi_grid_is_open(kind) && kind != PD_INLET ? f[j] : closed * f[i];
}

/* Central difference f(upper) - f(lower) at node i along axis d; closed: ratio of f behind a closed face. */
static double pdi_schur_precond_compute_difference(const pd_grid *grid, const double *f, int32_t i, int d,
                                                   double closed)
{
    return pdi_schur_precond_get_neighbour(grid, f, i, d, 1, closed) -
           pdi_schur_precond_get_neighbour(grid, f, i, d, 0, closed);
}

/* Sweep callback: output [PD_DIM][total] = gradient of the scalar `input` by central differences. Ghosts of input are
 * given. */
static void pdi_schur_precond_compute_gradient(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pdi_schur_precond_sweep_args *s = (const pdi_schur_precond_sweep_args *)user;
    const pd_grid *grid = s->flow->grid;
    for (int d = 0; d < PD_DIM; d++) {
        double half = 0.5 / grid->h[d], *to = s->output + (int64_t)d * grid->total + i;
        const double *up = s->input + i + grid->stride[d], *down = s->input + i - grid->stride[d];
        for (int32_t b = 0; b < count && row < 0; b++) to[b] = half * (up[b] - down[b]);
        for (int32_t b = 0; b < count && row >= 0; b++)
            to[b] = half * pdi_schur_precond_compute_difference(grid, s->input, i + b, d, PDI_SCHUR_PRECOND_EVEN);
    }
}

/* Sweep callback: output [PD_DIM][total] = u.grad of the vector `input`, by central differences with the velocity of
 * the flow. Ghosts of input are given. */
static void pdi_schur_precond_apply_convection(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pdi_schur_precond_sweep_args *s = (const pdi_schur_precond_sweep_args *)user;
    const pd_grid *grid = s->flow->grid;
    for (int e = 0; e < PD_DIM; e++) {
        const double *from = s->input + (int64_t)e * grid->total;
        double *to = s->output + (int64_t)e * grid->total + i;
        for (int32_t b = 0; b < count; b++) to[b] = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            double half = 0.5 / grid->h[d];
            const double *u = s->flow->u + (int64_t)d * grid->total + i;
            const double *up = from + i + grid->stride[d], *down = from + i - grid->stride[d];
            for (int32_t b = 0; b < count && row < 0; b++) to[b] += half * u[b] * (up[b] - down[b]);
            for (int32_t b = 0; b < count && row >= 0; b++)
                to[b] +=
                    half * u[b] * pdi_schur_precond_compute_difference(grid, from, i + b, d, PDI_SCHUR_PRECOND_ODD);
        }
    }
}

/* Sweep callback: output [total] = -div of the vector `input`, by central differences. Ghosts of input are given. */
static void pdi_schur_precond_apply_divergence(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pdi_schur_precond_sweep_args *s = (const pdi_schur_precond_sweep_args *)user;
    const pd_grid *grid = s->flow->grid;
    double *to = s->output + i;
    for (int32_t b = 0; b < count; b++) to[b] = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double half = 0.5 / grid->h[d];
        const double *from = s->input + (int64_t)d * grid->total;
        const double *up = from + i + grid->stride[d], *down = from + i - grid->stride[d];
        for (int32_t b = 0; b < count && row < 0; b++) to[b] -= half * (up[b] - down[b]);
        for (int32_t b = 0; b < count && row >= 0; b++)
            to[b] -= half * pdi_schur_precond_compute_difference(grid, from, i + b, d, PDI_SCHUR_PRECOND_ODD);
    }
}

/* Applies a sweep callback to all fluid nodes. */
static void pdi_schur_precond_apply_sweep(const pd_ctx *ctx, const pd_flow *flow, pdi_node_loop_range_fn run,
                                          const double *from, double *to)
{
    pdi_schur_precond_sweep_args s;
    s.flow = flow;
    s.input = from;
    s.output = to;
    pdi_node_loop_by_ranges(ctx, flow->bonds, (int64_t)flow->grid->fluid_count * 2 * PD_DIM * PD_DIM, 0, run, &s);
}

/* ---- short waves ---- */

/* Sweep callback: output = B input, a checkerboard filter: 0 of a uniform field, 1 of one that alternates along all
 * axes. Ghosts of input are given. */
static void pdi_schur_precond_apply_checkerboard_filter(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pdi_schur_precond_sweep_args *s = (const pdi_schur_precond_sweep_args *)user;
    const pd_grid *grid = s->flow->grid;
    const double *from = s->input + i;
    double *to = s->output + i, sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += 4.0 / (grid->h[d] * grid->h[d]);
    for (int32_t b = 0; b < count; b++) to[b] = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double share = 1.0 / (sum * grid->h[d] * grid->h[d]);
        const double *up = from + grid->stride[d], *down = from - grid->stride[d];
        for (int32_t b = 0; b < count && row < 0; b++) to[b] += share * (2.0 * from[b] - (up[b] + down[b]));
        for (int32_t b = 0; b < count && row >= 0; b++)
            to[b] += share * (2.0 * from[b] -
                              (pdi_schur_precond_get_neighbour(grid, s->input, i + b, d, 1, PDI_SCHUR_PRECOND_EVEN) +
                               pdi_schur_precond_get_neighbour(grid, s->input, i + b, d, 0, PDI_SCHUR_PRECOND_EVEN)));
    }
}

/* Symbol of -lap of the family at the checkerboard mode [1/m2]. */
static double pdi_schur_precond_compute_checkerboard_symbol(const pd_stencil *stencil)
{
    double sum = 0.0;
    for (int k = 0; k < stencil->count; k++) {
        int parity = 0;
        for (int d = 0; d < PD_DIM; d++) parity += stencil->offset[k * PD_DIM + d];
        if (parity % 2) sum += 2.0 * stencil->laplacian_weight[k];
    }
    return sum;
}

/* Viscosity for smooth residuals [m2/s]: nu, and 0.3 times the convective part of `rate` over the sum of the Laplacian
 * weights. rate [1/s]: 1/tau (eq. 3.8); its convective part is what exceeds the sum of nu/h^2 over axes, at least 0. */
static double pdi_schur_precond_compute_smooth_viscosity(const pd_flow *flow, double rate)
{
    for (int d = 0; d < PD_DIM; d++) rate -= flow->nu / (flow->grid->h[d] * flow->grid->h[d]);
    return flow->nu + PDI_SCHUR_PRECOND_CONVECTIVE_FACTOR * pd_max(rate, 0.0) / flow->bonds->stencil->lap_sum;
}

/* dp += q + viscosity r: the smooth part of r by the friction, the checkerboard part by the pressure flux (eq. 3.29).
 * Overwrites grad and convective of precond. */
static void pdi_schur_precond_add_viscous_part(const pd_ctx *ctx, const pd_flow *flow, const pdi_schur_precond *precond,
                                               const double *r, const double *q, double *dp)
{
    const pd_grid *grid = flow->grid;
    const double *alternate = precond->grad;
    /* one over the weight of the pressure flux; the shift of a stage, which is part of it, is in q */
    double rate = 1.0 / pdi_flow_get_pressure_flux_weight(flow) - (flow->stage_weight > 0.0 ? precond->shift : 0.0);
    double smooth = pdi_schur_precond_compute_smooth_viscosity(flow, rate);
    double more = rate / pdi_schur_precond_compute_checkerboard_symbol(flow->bonds->stencil) - smooth;
    int nt = pd_par_threads(ctx, grid->total * 4);
    (void)nt;
    pdi_par_copy(ctx, grid->total, r, precond->convective);
    pdi_ghosts_set_pressure(&flow->bonds->ghosts, 0.0, precond->convective);
    pdi_schur_precond_apply_sweep(ctx, flow, pdi_schur_precond_apply_checkerboard_filter, precond->convective,
                                  precond->grad);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) dp[i] += smooth * r[i] + more * alternate[i] + q[i];
}

/* dp = -lap^-1 of the divergence of u.grad(grad q): least-squares commutator for convection. q gets its ghosts. */
static void pdi_schur_precond_solve_commutator(pd_ctx *ctx, const pd_flow *flow, const pdi_schur_precond *precond,
                                               double *q, double *dp)
{
    const pd_ghosts *ghosts = &flow->bonds->ghosts;
    pdi_ghosts_set_pressure(ghosts, 0.0, q);
    pdi_schur_precond_apply_sweep(ctx, flow, pdi_schur_precond_compute_gradient, q, precond->grad);
    pd_ghosts_set_vector(ghosts, precond->grad);
    pdi_schur_precond_apply_sweep(ctx, flow, pdi_schur_precond_apply_convection, precond->grad, precond->convective);
    pd_ghosts_set_vector(ghosts, precond->convective);
    pdi_schur_precond_apply_sweep(ctx, flow, pdi_schur_precond_apply_divergence, precond->convective, precond->grad);
    pdi_multigrid_cycle(ctx, precond->poisson, precond->grad, dp);
}

PDI_FN void pdi_schur_precond_apply(pd_ctx *ctx, const pd_flow *flow, const pdi_schur_precond *precond, const double *r,
                                    double *q, double *dp)
{
    pdi_schur_precond_solve_commutator(ctx, flow, precond, q, dp);
    pdi_multigrid_cycle(ctx, precond->darcy, r, q);
    pdi_schur_precond_add_viscous_part(ctx, flow, precond, r, q, dp);
}
