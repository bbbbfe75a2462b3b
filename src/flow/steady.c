/* steady: see steady.h */
#include "flow/steady.h"
#include "core/par.h"
#include "lattice/op.h"
#include <math.h>
#include <string.h>

#define PDI_STEADY_MIN_BASIS 10 /* GMRES basis vectors that a solve starts with room for */

#define PDI_STEADY_POTENTIAL_RTOL 3e-11 /* [-] relative tolerance of the potential (eq. 3.34), close to rounding */
#define PDI_STEADY_POTENTIAL_RESTART 24 /* GMRES basis vectors for that potential */
#define PDI_STEADY_POTENTIAL_MAX_ITERATIONS 600 /* most iterations for it: rounding may prevent the tolerance */
#define PDI_STEADY_POTENTIAL_ATOL 1e-19         /* [-] divergence over U/L that counts as zero */

/* User data of the solver callbacks. */
typedef struct pdi_steady_solver_data {
    pd_ctx *ctx;
    pd_steady *steady;
} pdi_steady_solver_data;

/* Length of the vectors of the solver: PD_DIM + 1 values for every node of the lattice, ghosts included. */
static int64_t pdi_steady_count_unknowns(const pd_flow *flow) { return (int64_t)(PD_DIM + 1) * flow->grid->total; }

PDI_FN double pdi_steady_get_momentum_scale(const pd_steady *s)
{
    return pd_max(pdi_flow_get_momentum_scale(s->flow, s->flow->velocity_scale, s->flow->length_scale),
                  s->flow->velocity_scale * s->stage_rate);
}
PDI_FN double pdi_steady_get_continuity_scale(const pd_flow *flow) { return flow->velocity_scale / flow->length_scale; }

/* Multiplies x [PD_DIM+1][total] in place: velocity or momentum rows by `momentum`, the row of pressure or continuity
 * by `continuity`; ghosts, too. */
static void pdi_steady_apply_scales(const pd_ctx *ctx, const pd_flow *flow, double momentum, double continuity,
                                    double *x)
{
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    int nt = pd_par_threads(ctx, pdi_steady_count_unknowns(flow));
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < split + total; i++) x[i] *= i < split ? momentum : continuity;
}

/* du = F^-1 r: one multigrid cycle for each component of the velocity block F (eq. 3.27). */
static void pdi_steady_apply_velocity_inverse(pd_ctx *ctx, pd_steady *s, const double *r, double *du)
{
    int64_t total = s->flow->grid->total;
    for (int d = 0; d < PD_DIM; d++) pdi_multigrid_cycle(ctx, &s->mg_u, r + d * total, du + d * total);
}

/* 1: the block factorisation takes F^-1 before the pressure, too. 0: with a mirror side, where the cycle does not know
 * that the component across is held, or with stretched cells, where its rounding is too rough. */
static int pdi_steady_is_fully_factorised(const pd_grid *grid)
{
    if (pdi_compact_operator_is_stretched(grid->h)) return 0;
    for (int k = 0; k < 2 * PD_DIM; k++)
        if (grid->side[k] == PD_SIDE_MIRROR) return 0;
    return 1;
}

/* rc -= div du, with the pointwise divergence beside smooth surfaces. Fills the ghosts of du; div [total] and
 * s->advecting: work. */
static void pdi_steady_add_divergence(pd_ctx *ctx, pd_steady *s, double *du, double *div, double *rc)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total;
    pdi_flow_update_velocity_ghosts(flow, 0, du);
    pdi_flow_compute_advecting_velocity(ctx, flow, du, NULL, s->advecting);
    pdi_par_zero(ctx, total, div);
    pd_op_divergence(ctx, flow->bonds, s->advecting, div);
    pdi_flow_add_divergence_correction(ctx, flow, du, s->advecting, 0, 1.0, div);
    pdi_par_axpy(ctx, total, -1.0, div, rc);
}

/* y = M^-1 y, in place, by the block factorisation (eq. 3.27; in closed boxes 3.28): a scaled residual [-] becomes a
 * step [m/s], [m2/s2]. flow->pressure_grad = the gradient of its pressure. r: work, as s->advecting. */
static void pdi_steady_apply_precond(pd_ctx *ctx, pd_steady *s, double *y, double *r)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    const pd_ghosts *ghosts = &flow->bonds->ghosts;
    double *dp = y + split, *q = s->is_fluid_box ? r : y;
    pdi_schur_precond precond;
    precond.poisson = &s->mg_p;
    precond.darcy = &s->mg_darcy;
    precond.shift = s->pseudo_rate;
    precond.grad = s->advecting; /* both are written later */
    precond.convective = flow->pressure_grad;
    pdi_par_copy(ctx, split + total, y, r);
    pdi_steady_apply_scales(ctx, flow, pdi_steady_get_momentum_scale(s) / s->momentum_weight,
                            pdi_steady_get_continuity_scale(flow), r);
    if (pdi_steady_is_fully_factorised(flow->grid)) {
        pdi_steady_apply_velocity_inverse(ctx, s, r, y);
        pdi_steady_add_divergence(ctx, s, y, dp, r + split);
    }
    pdi_multigrid_cycle(ctx, &s->mg_p, r + split, q);
    if (s->is_fluid_box) { /* du - G q */
        pdi_ghosts_set_pressure(ghosts, 0.0, q);
        pdi_flow_compute_pressure_gradient(ctx, flow, q, flow->pressure_grad);
        pdi_par_axpy(ctx, split, -1.0, flow->pressure_grad, y);
        pdi_ghosts_set_zero(ghosts, PD_DIM, y);
    }
    pdi_schur_precond_apply(ctx, flow, &precond, r + split, q, dp);
    pdi_ghosts_set_pressure(ghosts, 0.0, dp);
    pdi_flow_compute_pressure_gradient(ctx, flow, dp, flow->pressure_grad);
    if (s->is_fluid_box) return;
    pdi_par_axpy(ctx, split, -1.0, flow->pressure_grad, r);
    pdi_ghosts_set_zero(ghosts, PD_DIM, r); /* no part of the equations */
    pdi_steady_apply_velocity_inverse(ctx, s, r, y);
}

/* y = J (du, dp), scaled [-], for du with dp behind it, whose pressure gradient is in flow->pressure_grad: (conv(du, u)
 * + conv(u, du) + G dp - nu lap du + shift du, div du - pressure flux). Fills the ghosts of du; s->advecting becomes
 * that of du. Counts one evaluation. */
static void pdi_steady_apply_jacobian(pd_ctx *ctx, pd_steady *s, double *du, double *y)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    pdi_jacobian_increment step;
    pdi_flow_update_velocity_ghosts(flow, 0, du);
    if (flow->fourth_order.bonds)
        pdi_fourth_order_compute_second_differences(ctx, &flow->fourth_order, NULL, NULL, du,
                                                    flow->fourth_order.second_increment);
    pdi_flow_compute_advecting_velocity(ctx, flow, du, flow->fourth_order.second_increment, s->advecting);
    step.advecting = s->advecting;
    step.u = du;
    step.p = du + split;
    step.grad = flow->pressure_grad;
    pdi_jacobian_apply(ctx, &s->jacobian, &step, y, y + split);
    pdi_flow_add_fitted_wall(ctx, flow, du, du + split, flow->pressure_grad, 0, y);
    pdi_flow_add_divergence_correction(ctx, flow, du, s->advecting, 0, 1.0, y + split);
    pdi_flow_add_fourth_order(ctx, flow, du, s->advecting, flow->pressure_grad, y);
    pdi_isotropic_stencil_add_row_corrections(ctx, &flow->isotropic_stencil, flow->isotropic_blending * flow->nu, du,
                                              y);
    if (s->pseudo_rate > 0.0) pdi_par_axpy(ctx, split, s->pseudo_rate, du, y);
    pdi_ghosts_set_zero(&flow->bonds->ghosts, PD_DIM, y);
    pdi_steady_apply_scales(ctx, flow, s->momentum_weight / pdi_steady_get_momentum_scale(s),
                            1.0 / pdi_steady_get_continuity_scale(flow), y);
    flow->evaluations++;
}

/* Operator of GMRES, preconditioned from the right: y = J M^-1 x, where x becomes M^-1 x. */
static void pdi_steady_apply_preconditioned_jacobian(void *user, const double *x, double *y)
{
    pdi_steady_solver_data *u = (pdi_steady_solver_data *)user;
    double *step = (double *)x; /* the solver is lean */
    pdi_steady_apply_precond(u->ctx, u->steady, step, y);
    pdi_steady_apply_jacobian(u->ctx, u->steady, step, y);
}

/* Sets up multigrid mg for a pressure Laplacian with the coefficients media; NULL: 1. The arrays of s->compact must be
 * lent, and are overwritten. */
static pd_status pdi_steady_build_pressure_multigrid(pd_ctx *ctx, pd_steady *s, const pd_bond_diffusivity *media,
                                                     pd_multigrid *mg)
{
    const pdi_compact_operator_bc pressure = {0, 0, 1, NULL}; /* outlets hold it */
    pdi_compact_operator_convection resting;
    pd_compact_operator *c = &s->compact;
    resting.numerical_diffusivity = resting.u = NULL;
    pdi_compact_operator_assemble(ctx, 1.0, media, &resting, 0.0, &pressure, c);
    return pdi_multigrid_setup(ctx, mg, c->active, (const float *const *)c->conductance, NULL, c->dirichlet, c->mass);
}

/* Sets up the multigrid of the pressure Laplacian, once for each geometry. */
static pd_status pdi_steady_update_poisson_multigrid(pd_ctx *ctx, pd_steady *s)
{
    if (s->poisson_version == s->flow->bonds->version) return PD_OK;
    PD_TRY(pdi_steady_build_pressure_multigrid(ctx, s, NULL, &s->mg_p));
    s->poisson_version = s->flow->bonds->version;
    return PD_OK;
}

/* Sets up all multigrids one after the other for s->pseudo_rate: mobility, velocity block, Laplacian (unless done for
 * this geometry). Overwrites s->compact and s->advecting. PD_ERR_ARGUMENT: a coefficient is not finite in single
 * precision. */
static pd_status pdi_steady_build_multigrids(pd_ctx *ctx, pd_steady *s)
{
    const pdi_compact_operator_bc velocity = {1, 1, 0, s->flow->bonds}; /* outlets alone let it free */
    pdi_compact_operator_convection moving;
    moving.u = s->flow->u;
    moving.numerical_diffusivity = NULL;
    pd_compact_operator *c = &s->compact;
    pd_bond_diffusivity seep;
    memset(&seep, 0, sizeof seep);
    seep.node_value = s->advecting;
    pdi_schur_precond_compute_mobility(ctx, s->flow, s->pseudo_rate, seep.node_value);
    pd_ghosts_set_scalar(&s->flow->bonds->ghosts, seep.node_value);
    PD_TRY(pdi_steady_build_pressure_multigrid(ctx, s, &seep, &s->mg_darcy));
    pdi_compact_operator_assemble(ctx, s->flow->nu, NULL, &moving, s->pseudo_rate, &velocity, c);
    PD_TRY(pdi_multigrid_setup(ctx, &s->mg_u, c->active, (const float *const *)c->conductance,
                               (const float *const *)c->flux, c->dirichlet, c->mass));
    return pdi_steady_update_poisson_multigrid(ctx, s);
}

/* Sets up all multigrids; an overflow of single precision becomes PD_ERR_DIVERGED with a message. */
static pd_status pdi_steady_try_build_multigrids(pd_ctx *ctx, pd_steady *s)
{
    pd_status status = pdi_steady_build_multigrids(ctx, s);
    if (status != PD_ERR_ARGUMENT) return status; /* the coefficients are of single precision */
    return pd_fail(ctx, PD_ERR_DIVERGED, "flow", "mu/rho = %g m2/s, h = %g m and speeds give rates beyond the range "
                   "of numbers of the solver: expected those of a fluid", s->flow->nu, s->flow->grid->h[0]);
}

/* Lists the coefficient arrays of the nearest-neighbour operator. */
static void pdi_steady_list_coefficients(pdi_array_visitor *owner, void *object)
{
    pdi_compact_operator_list(owner, object);
    pdi_compact_operator_face_list(owner, object);
}

/* Runs `fill` while the arena lends the coefficient arrays. */
static pd_status pdi_steady_apply_with_coefficients(pd_ctx *ctx, pd_steady *s,
                                                    pd_status (*fill)(pd_ctx *ctx, pd_steady *s))
{
    pd_arena *arena = pdi_steady_get_arena(s);
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_steady_list_coefficients, &s->compact));
    return pdi_arena_release(ctx, arena, pdi_steady_list_coefficients, &s->compact, fill(ctx, s));
}

PDI_FN pd_status pdi_steady_update_precond(pd_ctx *ctx, pd_steady *s, double shift)
{
    s->pseudo_rate = shift;
    s->prepared = 0;
    PD_TRY(pdi_steady_apply_with_coefficients(ctx, s, pdi_steady_try_build_multigrids));
    s->prepared = 1;
    return PD_OK;
}

/* Sets momentum, continuity and residual_over_tolerance of *result: largest scaled residuals in s->residual, over the
 * tolerance, and with the reference scales for reports. */
static void pdi_steady_compute_residual_norms(const pd_ctx *ctx, const pd_steady *s, pd_steady_result *result)
{
    const pd_flow *flow = s->flow;
    double speed = flow->reference_speed, length = flow->reference_length;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    double momentum = pdi_par_max_abs(ctx, split, s->residual);
    double continuity = pdi_par_max_abs(ctx, total, s->residual + split);
    result->residual_over_tolerance = pd_max(momentum, continuity) / s->desc.tolerance;
    result->momentum = momentum * (pdi_steady_get_momentum_scale(s) / pdi_flow_get_momentum_scale(flow, speed, length));
    result->continuity = continuity * (pdi_steady_get_continuity_scale(flow) / (speed / length));
}

PDI_FN double pdi_steady_assemble_residual(pd_ctx *ctx, pd_steady *s, pd_steady_result *result)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    double *r = s->residual;
    pdi_flow_assemble_residual(ctx, flow, r, r + split);
    if (s->stage_rate > 0.0) {
        pdi_par_axpy(ctx, split, s->stage_rate, flow->u, r);
        pdi_par_axpy(ctx, split, -s->stage_rate, s->stage_target, r);
        pdi_ghosts_set_zero(&flow->bonds->ghosts, PD_DIM, r); /* inlets hold a velocity, and have no equation */
    }
    pdi_steady_apply_scales(ctx, flow, 1.0 / pdi_steady_get_momentum_scale(s),
                            1.0 / pdi_steady_get_continuity_scale(flow), r);
    pdi_steady_compute_residual_norms(ctx, s, result);
    double continuity = pdi_par_dot(ctx, total, r + split, r + split);
    /* not hypot: see krylov.c */
    return sqrt(s->momentum_weight * s->momentum_weight * pdi_par_dot(ctx, split, r, r) + continuity);
}

/* Largest size of a velocity component at fluid nodes and of prescribed inlet velocities [m/s]; other ghosts may be out
 * of date. Overwrites the velocity part of s->newton_step. */
static double pdi_steady_compute_max_speed(const pd_ctx *ctx, const pd_steady *s)
{
    const pd_flow *flow = s->flow;
    const uint8_t *kind = flow->grid->kind;
    int64_t total = flow->grid->total, held = flow->inlet_velocity ? (int64_t)PD_DIM * flow->inlet_ghosts : 0;
    int nt = pd_par_threads(ctx, PD_DIM * total);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < total; i++)
        for (int d = 0; d < PD_DIM; d++)
            s->newton_step[d * total + i] = kind[i] == PD_FLUID ? flow->u[d * total + i] : 0.0;
    return pd_max(pdi_par_max_abs(ctx, PD_DIM * total, s->newton_step),
                  pdi_par_max_abs(ctx, held, flow->inlet_velocity));
}

PDI_FN void pdi_steady_compute_momentum_weight(pd_ctx *ctx, pd_steady *s)
{
    const pd_flow *flow = s->flow;
    const pd_grid *grid = flow->grid;
    double speed = pdi_steady_compute_max_speed(ctx, s), far = 0.0, near = HUGE_VAL;
    pdi_schur_precond_compute_mobility(ctx, flow, s->stage_rate, s->advecting);
    double mobility = pdi_par_max_abs(ctx, grid->total, s->advecting);
    for (int d = 0; d < PD_DIM; d++) {
        far = pd_max(far, grid->n[d] * grid->h[d]);
        near = pd_min(near, grid->h[d]);
    }
    s->momentum_weight = 1.0;
    if (!(mobility > 0.0)) return;
    double slow = sqrt((flow->nu / near + far / mobility) / (0.5 * sqrt(mobility / flow->nu)));
    s->momentum_weight = pdi_steady_get_momentum_scale(s) / pdi_steady_get_continuity_scale(flow) / (speed + slow);
}

PDI_FN void pdi_steady_update_state(const pd_ctx *ctx, pd_steady *s, double factor)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    pdi_par_axpy(ctx, split, factor, s->newton_step, flow->u);
    pdi_par_axpy(ctx, total, factor, s->newton_step + split, flow->p);
}

PDI_COLD_BEGIN
PDI_FN void pdi_steady_list(pdi_array_visitor *owner, void *object)
{
    pd_steady *steady = (pd_steady *)object;
    int64_t total = steady->flow ? steady->flow->grid->total : 0;
    PDI_ARRAY_STATE(owner, steady, divergence_potential, total, "m2/s");
    PDI_SCALAR_STATE(owner, steady, reference_norm, "1");
}

/* Lists the scratch arrays of one solve. */
static void pdi_steady_list_work(pdi_array_visitor *owner, void *object)
{
    pd_steady *steady = (pd_steady *)object;
    int64_t total = steady->flow->grid->total;
    PDI_ARRAY(owner, steady, residual, (PD_DIM + 1) * total, "1");
    PDI_ARRAY(owner, steady, newton_step, (PD_DIM + 1) * total, "");
    if (steady->flow->order == 4) PDI_ARRAY(owner, steady, advecting, PD_DIM * total, "m/s");
    pdi_jacobian_list_work(owner, &steady->jacobian);
    pdi_multigrid_list(owner, &steady->mg_u);
    pdi_multigrid_list(owner, &steady->mg_p);
    pdi_multigrid_list(owner, &steady->mg_darcy);
}

PDI_FN pd_arena *pdi_steady_get_arena(pd_steady *s) { return s->desc.arena ? s->desc.arena : &s->own_arena; }

/* Sets *kd to the options of GMRES for Newton steps. Basis in single precision for stages in time and on stretched
 * cells, else in 16 bit integers. The basis may grow up to max_krylov vectors, in multiples of restart. */
static void pdi_steady_init_newton_krylov(pd_steady *s, pd_krylov_desc *kd)
{
    memset(kd, 0, sizeof *kd);
    kd->equations = "flow";
    kd->n = pdi_steady_count_unknowns(s->flow);
    kd->spans = &s->flow->bonds->active_ranges;
    kd->components = PD_DIM + 1;
    kd->restart = s->desc.restart;
    kd->max_vectors = s->desc.max_krylov / s->desc.restart * s->desc.restart;
    kd->arena = pdi_steady_get_arena(s);
    kd->max_iterations = s->desc.max_krylov;
    kd->initial_vectors = PDI_STEADY_MIN_BASIS;
    kd->zero_guess = kd->low_memory = kd->skip_true_residual = 1; /* Newton's residual shows what it has come to */
    /* stages ask for four digits, steps for three; on stretched spacings the solver needs all that it can get */
    kd->basis_precision =
        s->solves_stages || pdi_compact_operator_is_stretched(s->flow->grid->h) ? PD_KRYLOV_SINGLE : PD_KRYLOV_INT16;
}

/* Options of GMRES for the potential. */
static void pdi_steady_init_potential_krylov(const pd_steady *s, pd_krylov_desc *kd)
{
    memset(kd, 0, sizeof *kd);
    kd->equations = "flow";
    kd->n = s->flow->grid->total;
    kd->spans = &s->flow->bonds->active_ranges;
    kd->components = 1;
    kd->restart = PDI_STEADY_POTENTIAL_RESTART;
    kd->max_iterations = PDI_STEADY_POTENTIAL_MAX_ITERATIONS;
    kd->rtol = PDI_STEADY_POTENTIAL_RTOL;
    kd->zero_guess = kd->low_memory = 1;
    kd->basis_precision = PD_KRYLOV_SINGLE;
}

/* Options of the multigrids. */
static void pdi_steady_init_multigrid(pd_steady *s, pd_multigrid_desc *md)
{
    pdi_compact_operator_multigrid_desc(s->flow->grid, md);
    md->arena = pdi_steady_get_arena(s);
}

PDI_FN pd_status pdi_steady_plan(pd_ctx *ctx, pd_steady *s)
{
    pd_krylov_desc kd;
    pd_multigrid_desc md;
    if (!s->desc.max_krylov) s->desc.max_krylov = 300;
    if (!s->desc.restart) s->desc.restart = PDI_STEADY_RESTART;
    pdi_steady_init_newton_krylov(s, &kd);
    pdi_steady_init_multigrid(s, &md);
    pdi_compact_operator_init(s->flow->grid, 1, &s->compact);
    md.caller_fields = 1;
    PD_TRY(pdi_multigrid_init(ctx, &md, &s->mg_u));
    md.symmetric = 1;
    md.caller_fields = 0;
    md.host = &s->mg_u;
    PD_TRY(pdi_multigrid_init(ctx, &md, &s->mg_p));
    PD_TRY(pdi_multigrid_init(ctx, &md, &s->mg_darcy));
    s->jacobian.flow = s->flow;
    PD_TRY(pdi_krylov_init(ctx, &kd, &s->krylov));
    pdi_steady_init_potential_krylov(s, &kd);
    return pdi_krylov_init(ctx, &kd, &s->potential_krylov);
}

PDI_FN size_t pdi_steady_count_work_bytes(pd_steady *s)
{
    size_t setup = pdi_arena_count_bytes(pdi_steady_list_coefficients, &s->compact) +
                   pdi_arena_count_bytes(pdi_multigrid_setup_list, &s->mg_u);
    size_t linear = pdi_arena_count_bytes(pdi_krylov_list, &s->krylov),
           even = pdi_arena_count_bytes(pdi_krylov_list, &s->potential_krylov);
    if (linear < even) linear = even;
    return pdi_arena_count_bytes(pdi_steady_list_work, s) + (setup > linear ? setup : linear);
}

/* Decides on the order of a flow of PD_FLOW_ORDER_AUTO, 4 or 2 (eq. 3.24); 4 takes its isotropic weights away. It
 * stays, whatever the flow becomes. */
static void pdi_steady_set_order(pd_flow *flow)
{
    if (flow->order != PD_FLOW_ORDER_AUTO) return;
    flow->order =
        pdi_fourth_order_is_efficient(flow->bonds, flow->velocity_scale / flow->nu, flow->length_scale) ? 4 : 2;
    if (flow->order == 2) return;
    memset(&flow->isotropic_stencil, 0, sizeof flow->isotropic_stencil);
    flow->isotropic_blending = 0.0;
}

/* Inner part of the build: checks desc, sets tolerance (0: 1e-6), holds inlets on the side, decides on the order,
 * builds the corrections of fourth order where the flow has none, prepares the solvers, reserves scratch memory. The
 * caller frees after an error; what is changed in the flow stays. */
static pd_status pdi_steady_try_build(pd_ctx *ctx, pd_flow *flow, const pd_steady_desc *desc, pd_steady *s)
{
    memset(s, 0, sizeof *s);
    s->flow = flow;
    s->desc = *desc;
    if (!(desc->tolerance >= 0.0) || desc->tolerance >= 1.0 || desc->max_newton < 0 || desc->max_krylov < 0 ||
        desc->restart < 0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "steady", "tolerance %g, max_newton %d, max_krylov %d, restart %d",
                       desc->tolerance, desc->max_newton, desc->max_krylov, desc->restart);
    if (!(s->desc.tolerance > 0.0)) s->desc.tolerance = 1e-6;
    pd_krylov_desc kd;
    PD_TRY(pdi_flow_set_inlets_on_side(ctx, flow));
    pdi_steady_set_order(flow);
    s->is_fluid_box = pdi_fourth_order_is_fluid_box(flow->grid) && pdi_steady_is_fully_factorised(flow->grid);
    if (flow->order == 4 && !flow->fourth_order.bonds)
        PD_TRY(pdi_fourth_order_build(ctx, flow->bonds, &flow->fourth_order));
    PD_TRY(pdi_steady_plan(ctx, s));
    pdi_steady_init_newton_krylov(s, &kd);
    PD_TRY(pdi_krylov_build_unallocated(ctx, &kd, &s->krylov));
    pdi_steady_init_potential_krylov(s, &kd);
    PD_TRY(pdi_krylov_build_unallocated(ctx, &kd, &s->potential_krylov));
    PD_TRY(pdi_jacobian_build(ctx, flow, &s->jacobian));
    PD_TRY(pdi_array_registry_build(ctx, pdi_steady_list, s));
    return pdi_arena_reserve(ctx, pdi_steady_get_arena(s), pdi_steady_count_work_bytes(s));
}

pd_status pd_steady_build(pd_ctx *ctx, pd_flow *flow, const pd_steady_desc *desc, pd_steady *s)
{
    pd_status status = pdi_steady_try_build(ctx, flow, desc, s);
    if (status < 0) pd_steady_free(ctx, s);
    return status;
}
PDI_COLD_END

PDI_FN pd_status pdi_steady_build_stages(pd_ctx *ctx, pd_steady *s, size_t more)
{
    pd_krylov_desc kd;
    if (s->solves_stages) return PD_OK;
    s->solves_stages = 1;
    pdi_steady_init_newton_krylov(s, &kd);
    pd_krylov_free(ctx, &s->krylov);
    PD_TRY(pdi_krylov_build_unallocated(ctx, &kd, &s->krylov));
    return pdi_arena_reserve(ctx, pdi_steady_get_arena(s), pdi_steady_count_work_bytes(s) + more);
}

/* ---- scratch memory ---- */
PDI_FN pd_status pdi_steady_begin_solves(pd_ctx *ctx, pd_steady *s)
{
    if (!s->nesting) {
        PD_TRY(pdi_arena_acquire(ctx, pdi_steady_get_arena(s), pdi_steady_list_work, s));
        if (s->flow->order != 4) s->advecting = s->flow->advecting;
        s->mg_u.fields = s->jacobian.packed_increment; /* cycles and products take turns */
        s->poisson_version = 0;
        s->prepared = 0;
        pdi_multigrid_set_pointers(&s->mg_u);
        pdi_multigrid_set_pointers(&s->mg_p);
        pdi_multigrid_set_pointers(&s->mg_darcy);
    }
    s->nesting++;
    return PD_OK;
}

/* The node with the largest entry of s->residual by size, momentum or continuity; the first of equal ones. 0 when no
 * entry is a number. */
static int32_t pdi_steady_find_worst_node(const pd_steady *s)
{
    int32_t total = s->flow->grid->total, worst = 0;
    double most = -1.0;
    for (int64_t i = 0; i < pdi_steady_count_unknowns(s->flow); i++) {
        if (!(fabs(s->residual[i]) > most)) continue;
        most = fabs(s->residual[i]);
        worst = (int32_t)(i % total);
    }
    return worst;
}

PDI_FN pd_status pdi_steady_end_solves(pd_ctx *ctx, pd_steady *s, pd_status status)
{
    if (--s->nesting) return status;
    s->worst_node = pdi_steady_find_worst_node(s);
    pdi_multigrid_clear_pointers(&s->mg_darcy);
    pdi_multigrid_clear_pointers(&s->mg_p);
    pdi_multigrid_clear_pointers(&s->mg_u);
    if (s->flow->order != 4) s->advecting = NULL;
    s->mg_u.fields = NULL;
    if (status != PD_OK)
        pdi_flow_update_derived_fields(ctx, s->flow); /* its advecting velocity and gradient were work */
    return pdi_arena_release(ctx, pdi_steady_get_arena(s), pdi_steady_list_work, s, status);
}

/* Solves a linear system with the right-hand side s->residual into s->newton_step, both from component `first` on.
 * precond NULL: none, or it is part of `apply`. Borrows the basis from the arena. A positive status: not converged,
 * newton_step has the last iterate. */
static pd_status pdi_steady_solve_linear(pd_ctx *ctx, pd_steady *s, pd_krylov *krylov, int first, pd_apply_fn apply,
                                         pd_apply_fn precond, pd_krylov_result *linear)
{
    int64_t at = (int64_t)first * s->flow->grid->total;
    pd_arena *arena = pdi_steady_get_arena(s);
    pdi_steady_solver_data user;
    user.ctx = ctx;
    user.steady = s;
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_krylov_list, krylov));
    pd_status status =
        pd_krylov_solve(ctx, krylov, apply, precond, &user, s->residual + at, s->newton_step + at, linear);
    return pdi_arena_release(ctx, arena, pdi_krylov_list, krylov, status);
}

PDI_FN pd_status pdi_steady_solve_newton_step(pd_ctx *ctx, pd_steady *s, double forcing, pd_steady_result *result,
                                              int *effort)
{
    pd_krylov_result linear;
    pdi_steady_apply_scales(ctx, s->flow, -s->momentum_weight, -1.0, s->residual);
    s->krylov.desc.rtol = forcing;
    PD_TRY(pdi_steady_solve_linear(ctx, s, &s->krylov, 0, pdi_steady_apply_preconditioned_jacobian, NULL, &linear));
    pdi_steady_apply_precond(ctx, s, s->newton_step, s->residual);
    pdi_ghosts_set_zero(&s->flow->bonds->ghosts, PD_DIM, s->newton_step); /* the preconditioner leaves its work there */
    *effort = linear.converged ? linear.iterations : s->desc.max_krylov + 1;
    result->krylov += linear.iterations;
    result->newton++;
    return PD_OK;
}

/* ---- divergence-free correction of bond fluxes ---- */
/* y = lap x. Fills the ghosts of x. */
static void pdi_steady_apply_laplacian(void *user, const double *x, double *y)
{
    pdi_steady_solver_data *u = (pdi_steady_solver_data *)user;
    const pd_flow *flow = u->steady->flow;
    pdi_ghosts_set_potential(&flow->bonds->ghosts, (double *)x); /* the solver is lean */
    pd_op_laplacian(u->ctx, flow->bonds, x, y);
}

/* y = one multigrid cycle for the Laplacian. */
static void pdi_steady_apply_poisson_cycle(void *user, const double *x, double *y)
{
    pdi_steady_solver_data *u = (pdi_steady_solver_data *)user;
    pdi_multigrid_cycle(u->ctx, &u->steady->mg_p, x, y);
}

/* Largest cell volume [m^d; axisymmetric: m3, of the outermost ring]. */
static double pdi_steady_compute_max_volume(const pd_flow *flow)
{
    const pd_grid *grid = flow->grid;
    double around = 1.0;
    if (grid->circumference) around = grid->circumference[grid->n[PD_DIM - 1] + grid->ghost - 1];
    return around * flow->bonds->stencil->volume;
}

PDI_FN pd_status pdi_steady_solve_divergence_potential(pd_ctx *ctx, pd_steady *s)
{
    pd_krylov_result linear;
    pd_krylov *k = &s->potential_krylov;
    pd_flow *flow = s->flow;
    int32_t total = flow->grid->total;
    int64_t split = (int64_t)PD_DIM * total;
    pdi_par_axpy(ctx, total, pdi_steady_get_continuity_scale(flow) - 1.0, s->residual + split, s->residual + split);
    pdi_flow_add_divergence_correction(ctx, flow, flow->u, flow->advecting, 1, -1.0, s->residual + split);
    PD_TRY(pdi_steady_apply_with_coefficients(ctx, s, pdi_steady_update_poisson_multigrid));
    k->desc.atol = PDI_STEADY_POTENTIAL_ATOL * pdi_steady_get_continuity_scale(flow);
    pd_status status =
        pdi_steady_solve_linear(ctx, s, k, PD_DIM, pdi_steady_apply_laplacian, pdi_steady_apply_poisson_cycle, &linear);
    /* compact pockets that long bonds join to the rest spoil the cycle */
    if (status > 0) status = pdi_steady_solve_linear(ctx, s, k, PD_DIM, pdi_steady_apply_laplacian, NULL, &linear);
    if (status < 0) return status;
    pdi_flow_update_derived_fields(ctx, flow); /* its advecting velocity was work */
    s->section_difference =
        linear.residual * sqrt((double)flow->grid->fluid_count) * pdi_steady_compute_max_volume(flow);
    pdi_par_copy(ctx, total, s->newton_step + split, s->divergence_potential);
    pdi_ghosts_set_potential(&flow->bonds->ghosts, s->divergence_potential);
    flow->divergence_potential = s->divergence_potential;
    return PD_OK;
}

PDI_FN pd_status pdi_steady_update_divergence_potential(pd_ctx *ctx, pd_steady *s)
{
    pd_steady_result result;
    if (!s->flow->uses_axis_divergence) { /* no smooth surfaces are left: an old potential would be wrong */
        if (s->flow->divergence_potential) pdi_par_zero(ctx, s->flow->grid->total, s->divergence_potential);
        s->flow->divergence_potential = NULL;
        return PD_OK;
    }
    memset(&result, 0, sizeof result);
    PD_TRY(pdi_steady_begin_solves(ctx, s));
    pdi_steady_assemble_residual(ctx, s, &result);
    return pdi_steady_end_solves(ctx, s, pdi_steady_solve_divergence_potential(ctx, s));
}

PDI_COLD_BEGIN
PDI_FN pd_status pdi_steady_store(pd_ctx *ctx, pd_steady *s, pd_archive *archive)
{
    if (archive->is_reading) s->flow->divergence_potential = s->divergence_potential;
    PD_TRY(pdi_array_registry_store(ctx, pdi_steady_list, s, archive));
    if (!archive->is_reading) return PD_OK;
    PD_TRY(pdi_flow_find_surface_patches(ctx, s->flow));
    pdi_flow_update_derived_fields(ctx, s->flow);
    return PD_OK;
}

void pd_steady_free(pd_ctx *ctx, pd_steady *s)
{
    pdi_multigrid_free(ctx, &s->mg_u);
    pdi_multigrid_free(ctx, &s->mg_p);
    pdi_multigrid_free(ctx, &s->mg_darcy);
    pd_krylov_free(ctx, &s->krylov);
    pd_krylov_free(ctx, &s->potential_krylov);
    pdi_jacobian_free(ctx, &s->jacobian);
    pdi_array_registry_free(ctx, pdi_steady_list, s);
    pd_arena_free(ctx, &s->own_arena);
    if (s->flow) s->flow->divergence_potential = NULL;
    memset(s, 0, sizeof *s);
}
PDI_COLD_END
