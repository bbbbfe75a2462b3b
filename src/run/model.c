/* model: see model.h */
#include "run/model.h"
#include "scene/fields.h"
#include "lattice/thickness.h"
#include "run/developed_flow.h"
#include "scene/interval.h"
#include <math.h>
#include <string.h>

/* Linear tolerance with bond-based corrosion and no flow: residuals carry over to the next step, of error 1e-3. */
#define PDI_MODEL_CORROSION_TOLERANCE 1e-9

/* Stencil of the peridynamic family with horizon m cells on the spacing of the setup. */
static pd_status pdi_model_build_stencil(pd_ctx *ctx, const pd_setup *setup, double m, pd_stencil *stencil)
{
    pd_stencil_desc family;
    memset(&family, 0, sizeof family);
    family.m = m;
    if (setup->has_corrode) family.weights = setup->weights;
    for (int d = 0; d < PD_DIM; d++) family.h[d] = setup->h[d];
    return pd_stencil_build(ctx, &family, stencil);
}

/* Tolerance of the iterations on limited fluxes, over rtol of the time step. */
#define PDI_MODEL_LIMITER_TOLERANCE 0.0025

PDI_FN pd_status pdi_model_build_grid(pd_ctx *ctx, const pd_setup *setup, int *line, pd_stencil *stencil, pd_grid *grid)
{
    pd_grid_desc box;
    memset(&box, 0, sizeof box);
    box.ghost = pdi_setup_count_ghost_layers(setup);
    for (int d = 0; d < PD_DIM; d++) {
        box.lo[d] = setup->lo[d];
        box.hi[d] = setup->hi[d];
    }
    for (int s = 0; s < 2 * PD_DIM; s++) box.side[s] = setup->side[s].kind;
    box.shapes = setup->shapes ? setup->shape : NULL;
    box.axisymmetric = setup->axisymmetric;
    if (setup->solid >= 0) box.solid = &setup->shape[setup->solid];
    if (setup->wall >= 0) box.wall = &setup->shape[setup->wall];
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (setup->side[s].is_open) box.is_inlet = pdi_inlet_is_inflow;
    box.is_inlet_user = (void *)setup; /* only read */
    PDI_TRY(pdi_model_build_stencil(ctx, setup, setup->fluid_m, stencil));
    if (setup->shape_line) *line = setup->shape_line; /* what the lattice refuses are shapes */
    return pd_grid_build(ctx, stencil, &box, grid);
}

/* Grid, bonds, bonds across surfaces and inlets. */
static pd_status pdi_model_build_lattice(pd_ctx *ctx, pd_model *m)
{
    PDI_TRY(pdi_model_build_grid(ctx, m->setup, &m->error_line, &m->stencil, &m->grid));
    PDI_TRY(pd_bonds_build(ctx, &m->stencil, &m->grid, pdi_setup_get_bond_options(m->setup), &m->bonds));
    if (pdi_setup_has_surface_area(m->setup)) {
        PDI_TRY(pdi_model_build_stencil(ctx, m->setup, m->setup->metal_m, &m->interface_stencil));
        PDI_TRY(pdi_bond_path_build(ctx, &m->interface_stencil, &m->grid, &m->paths));
    }
    pd_status status = pdi_inlet_build(ctx, m->setup, &m->grid, &m->inlet);
    m->error_line = m->setup->side[m->inlet.error_side].line;
    return status;
}

/* Initial velocity, and the time integrator of an unsteady flow. PD_ERR_STATE: a velocity is not finite. */
static pd_status pdi_model_build_unsteady_flow(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_implicit_desc implicit;
    pd_weakly_compressible_desc explicit_;
    memset(&implicit, 0, sizeof implicit);
    memset(&explicit_, 0, sizeof explicit_);
    for (int32_t node = 0; node < m->grid.total; node++) {
        double x[PD_DIM];
        if (m->grid.kind[node] != PD_FLUID && m->grid.kind[node] != PD_INLET) continue;
        if (m->grid.kind[node] == PD_INLET && u->flow_time != PD_FLOW_PRESCRIBED) continue;
        pd_grid_position(&m->grid, node, x);
        pdi_grid_fold_position_images(&m->grid, x);
        for (int d = 0; d < PD_DIM; d++) {
            double v = pdi_setup_eval_expr(&u->initial_velocity[d], x, 0.0);
            if (!(fabs(v) < 1e100))
                return pdi_fail(ctx, PD_ERR_STATE, "model", "the velocity at the start is %g m/s at x = %g m", v, x[0]);
            m->flow.u[(int64_t)d * m->grid.total + node] = v;
        }
    }
    implicit.rtol = u->flow_rtol;
    explicit_.eos = u->linear_eos ? PD_EOS_LINEAR : PD_EOS_TAIT;
    explicit_.sound_speed = u->sound_speed;
    pdi_flow_update_derived_fields(ctx, &m->flow);
    if (u->flow_time == PD_FLOW_PRESCRIBED) return PD_OK;
    if (u->flow_time == PD_FLOW_IMPLICIT) return pd_implicit_build(ctx, &m->flow, &m->steady, &implicit, &m->implicit);
    return pd_weakly_compressible_build(ctx, &m->flow, &explicit_, &m->unsteady);
}

static pd_status pdi_model_build_flow(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_flow_desc flow;
    pd_steady_desc steady;
    memset(&flow, 0, sizeof flow);
    memset(&steady, 0, sizeof steady);
    flow.rho = u->rho;
    flow.mu = u->mu;
    for (int d = 0; d < PD_DIM; d++) flow.force[d] = u->force[d];
    if (u->has_body_force_expr) flow.body = pdi_inlet_compute_body_force;
    flow.body_user = &m->inlet;
    if (m->inlet.is_time_dependent) flow.clock = &m->inlet.time;
    flow.p_out = u->p_out;
    flow.report_speed = u->speed;
    flow.report_length = u->length;
    flow.order = u->flow_order;
    if (!u->flow_order && u->flow_time == PD_FLOW_STEADY) flow.order = PD_FLOW_ORDER_AUTO;
    for (int s = 2 * PD_DIM - 1; s >= 0; s--) { /* what users know the inlet by */
        if (u->side[s].kind != PD_SIDE_INLET) continue;
        if (u->side[s].profile == PD_PROFILE_PARABOLA) flow.developed_sides |= 1 << s;
        if (!(u->speed > 0.0) && fabs(m->inlet.mean[s]) > 0.0) flow.report_speed = fabs(m->inlet.mean[s]);
        if (!(u->length > 0.0)) flow.report_length = m->inlet.width[s];
    }
    if (m->inlet.inlets) flow.inlet = pdi_inlet_get_velocity;
    flow.inlet_user = &m->inlet;
    if (pdi_wall_bc_has_motion(u)) flow.wall = pdi_wall_bc_get_velocity;
    flow.wall_user = &m->inlet;
    steady.tolerance = u->steady_tolerance;
    steady.arena = &m->arena;
    PDI_TRY(pd_flow_build(ctx, &m->grid, &m->bonds, &flow, &m->flow));
    if (u->flow_time == PD_FLOW_STEADY || u->flow_time == PD_FLOW_IMPLICIT)
        PDI_TRY(pd_steady_build(ctx, &m->flow, &steady, &m->steady));
    m->error_line = u->side[m->inlet.error_side].line;
    PDI_TRY(pdi_developed_flow_compute_profiles(ctx, &m->inlet, &m->flow));
    if (u->flow_time != PD_FLOW_STEADY) PDI_TRY(pdi_model_build_unsteady_flow(ctx, m));
    if (u->flow_time != PD_FLOW_PRESCRIBED) m->unknowns[PD_PART_FLOW] = (PD_DIM + 1) * m->grid.fluid_count;
    return PD_OK;
}

/* Density rho [kg/m3], velocity v [m/s] and pressure p [Pa] of the gas at x [m], at the start and behind inlets. */
static void pdi_model_get_initial_gas(void *user, const double *x, double *rho, double *v, double *p)
{
    const pd_setup *u = (const pd_setup *)user;
    *rho = pdi_setup_eval_expr(&u->gas_rho, x, 0.0);
    *p = pdi_setup_eval_expr(&u->gas_p, x, 0.0);
    for (int d = 0; d < PD_DIM; d++) v[d] = pdi_setup_eval_expr(&u->initial_velocity[d], x, 0.0);
}

static pd_status pdi_model_build_gas(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_gas_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.gamma = u->gas_gamma;
    desc.spatial_order = u->gas_order;
    desc.cfl = u->gas_cfl;
    desc.initial = pdi_model_get_initial_gas;
    desc.initial_user = (void *)u; /* only read */
    m->unknowns[PD_PART_GAS] = PD_GAS_FIELDS * m->grid.fluid_count;
    PDI_TRY(pd_gas_build(ctx, &m->grid, &m->bonds, &desc, &m->gas));
    double limit;
    return pd_gas_limit(ctx, &m->gas, &limit); /* the state at the start shows */
}

/* Initial concentration field [total] [mol/m3] of fluid nodes. PD_ERR_STATE: negative or not finite. */
static pd_status pdi_model_set_initial_concentration(pd_ctx *ctx, const pd_model *m, double *field)
{
    for (int32_t node = 0; node < m->grid.total; node++) {
        double x[PD_DIM];
        if (m->grid.kind[node] != PD_FLUID) continue;
        pd_grid_position(&m->grid, node, x);
        double c = pdi_setup_eval_expr(&m->setup->initial_c, x, 0.0);
        if (!(c >= 0.0) || !(c < 1e100))
            return pdi_fail(ctx, PD_ERR_STATE, "model",
                            "initial gives C = %g mol/m3 at x = %g m, expected a finite value of at least 0", c, x[0]);
        field[node] = c;
    }
    return PD_OK;
}

/* Signed distance [m] of x from the surface of the medium (porous body). user: the pd_inlet. */
static double pdi_model_compute_interface_distance(void *user, const double *x)
{
    const pd_inlet *inlet = (const pd_inlet *)user;
    return pdi_grid_signed_distance(inlet->grid, inlet->setup->medium, x);
}

/* Diffusivity [m2/s] at x, in or outside of the medium. user: the pd_inlet. */
static double pdi_model_get_diffusivity(void *user, const double *x)
{
    const pd_setup *u = ((const pd_inlet *)user)->setup;
    return pdi_model_compute_interface_distance(user, x) <= pdi_shape_tolerance(u->h, x) ? u->medium_diffusivity
                                                                                         : u->diffusivity;
}

static pd_status pdi_model_build_transport(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_transport_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.diffusivity = u->diffusivity;
    desc.inlet = u->inlet_c;
    desc.advection = u->advection;
    desc.limiter_tolerance = u->limiter_tolerance > 0.0 ? u->limiter_tolerance
                             : u->steady_transport      ? 0.0
                                                        : PDI_MODEL_LIMITER_TOLERANCE * u->rtol;
    desc.given = u->has_corrode && u->activation && !u->has_flow;
    if (u->has_corrode && !u->has_flow) desc.tolerance = PDI_MODEL_CORROSION_TOLERANCE;
    if (u->medium >= 0) desc.field = pdi_model_get_diffusivity;
    if (u->medium >= 0) desc.level = pdi_model_compute_interface_distance;
    if (pdi_wall_bc_has_concentration(u)) desc.held = pdi_wall_bc_get_concentration;
    desc.walls_only = 1;
    if (u->flow_time == PD_FLOW_PRESCRIBED || u->has_inlet_c_by_side) desc.entering = pdi_inlet_get_concentration;
    desc.user = &m->inlet;
    desc.arena = &m->arena;
    if (m->inlet.is_time_dependent) desc.clock = &m->inlet.time;
    PDI_TRY(pd_transport_build(ctx, &m->grid, &m->bonds, u->has_flow ? &m->flow : NULL, &desc, &m->transport));
    m->unknowns[PD_PART_TRANSPORT] = m->grid.fluid_count;
    if (!u->has_dissolve) {
        pd_two_stage_desc two_stage;
        memset(&two_stage, 0, sizeof two_stage);
        two_stage.rtol = u->rtol;
        two_stage.largest = u->max_step;
        PDI_TRY(pd_two_stage_build(ctx, &m->transport, &two_stage, &m->transport_integrator));
        m->transport_integrator.settle = u->steady_transport;
    }
    return pdi_model_set_initial_concentration(ctx, m, m->transport.c);
}

/* Set the composition of fluid within the shape `solution`, in equilibrium, and restart the reactive solver. */
static pd_status pdi_model_set_initial_solution(pd_ctx *ctx, const pd_electrolyte *e, pd_model *m)
{
    const pd_setup *u = m->setup;
    double inside[PD_SPECIES_MAX], x[PD_DIM];
    pd_electrolyte_state state;
    memcpy(inside, e->shape_initial, sizeof inside);
    PDI_TRY(pd_electrolyte_solve(ctx, e, inside, &state));
    for (int32_t i = 0; i < m->grid.total; i++) {
        if (m->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&m->grid, i, x);
        if (!pdi_shape_contains(u->shape, u->solution, u->h, x)) continue;
        for (int k = 0; k < e->count; k++)
            if (pd_reactive_field(&m->reactive, k)) pd_reactive_field(&m->reactive, k)[i] = inside[k];
    }
    return pd_reactive_begin(ctx, &m->reactive);
}

/* Reactive transport: initial and inlet compositions in chemical equilibrium, without mineral reactions. */
static pd_status pdi_model_build_species(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_electrolyte e = u->electrolyte;
    double initial[PD_SPECIES_MAX], inlet[PD_SPECIES_MAX];
    pd_electrolyte_state state;
    pd_reactive_desc desc;
    pdi_setup_get_reactive_desc(u, &desc);
    memcpy(initial, e.initial, sizeof initial);
    memcpy(inlet, e.inlet, sizeof inlet);
    e.reactions = pdi_mineral_copy_solid_free_reactions(e.species, e.count, e.reaction, e.reactions, e.reaction);
    PDI_TRY(pd_electrolyte_solve(ctx, &e, initial, &state));
    PDI_TRY(pd_electrolyte_solve(ctx, &e, inlet, &state));
    desc.initial = initial;
    desc.inlet = inlet;
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (u->side[s].has_fixed_species) desc.held = pdi_wall_bc_is_dirichlet_species;
    desc.wall = desc.held ? inlet : NULL;
    desc.user = &m->inlet;
    desc.arena = &m->arena;
    PDI_TRY(pd_reactive_build(ctx, &m->grid, &m->bonds, u->has_flow ? &m->flow : NULL, &desc, &m->reactive));
    m->unknowns[PD_PART_CHEMISTRY] = m->reactive.components.count * m->grid.fluid_count;
    return u->solution < 0 ? PD_OK : pdi_model_set_initial_solution(ctx, &e, m);
}

/* Dissolution sources [mol/m3/s] for the next step of the species, whose middle is at t [s]. PD_RETRY: shorten it. */
static pd_status pdi_model_update_metal_source(pd_ctx *ctx, void *user, double t)
{
    pd_model *m = (pd_model *)user;
    const pd_transport *transport = &m->transport;
    double dt = m->species_integrator.step;
    m->dissolve.time = t;
    pd_status status = pdi_dissolve_mean(ctx, &m->dissolve, t - 0.5 * dt, dt);
    for (int32_t i = 0; i < m->grid.total && status == PD_OK; i++) {
        double rate = transport->source[i] - transport->absorb[i] * transport->c[i];
        m->species_integrator.ahead[i] = m->grid.kind[i] == PD_FLUID ? rate : 0.0;
    }
    return status;
}

/* Surface states; potential solver and rate laws, which depend on them, are built later. */
static pd_status pdi_model_build_surface_states(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    m->error_line = u->state[0].line;
    PDI_TRY(PDI_NEW(ctx, "model", 1, m->surface_states));
    return pdi_surface_states_build(ctx, u, &m->reactive, &m->bonds, &m->interface_stencil,
                                    u->has_potential ? &m->cell : NULL,
                                    pdi_setup_find_species_rate_metal(u) >= 0 || pdi_setup_has_ion_electrodes(u)
                                        ? &m->dissolution_laws.surface_solver
                                        : NULL,
                                    m->surface_states);
}

/* 1: currents are solved before each species step: conductivity, surface states or mineral coverage depend on them. */
static int pdi_model_needs_currents_per_step(const pd_setup *setup)
{
    int covers = setup->shielding_thickness > 0.0 && setup->minerals && pdi_electrode_map_is_time_dependent(setup);
    int alters = !(setup->potential.conductivity > 0.0) || setup->states > 0 || covers;
    return setup->has_potential && setup->has_chemistry && !setup->has_migration && alters;
}

/* 1: rate laws of metal depend on currents or potentials of the potential solver. */
static int pdi_model_laws_read_potential(const pd_setup *u)
{
    int sees = 0;
    for (int k = 0; k < u->metals; k++)
        sees |= u->has_potential && !u->has_migration && pdi_setup_has_electric_rate(&u->metal[k]);
    return sees;
}

/* 1: the species solve currents in each of their own steps; else they use those of the metal's step. */
static int pdi_model_species_solve_currents(const pd_setup *setup)
{
    int timed = setup->has_potential && !setup->has_migration && pdi_electrode_map_is_time_dependent(setup);
    return pdi_model_needs_currents_per_step(setup) || (timed && !pdi_model_laws_read_potential(setup));
}

/* Solve the potential at time t [s]. user: the pd_cell. */
static pd_status pdi_model_solve_currents(pd_ctx *ctx, void *user, double t)
{
    return pdi_cell_bring(ctx, (pd_cell *)user, t);
}

/* Time integrator of the species with its couplings: rate laws, electrodes, states, released metal, coverage. */
static pd_status pdi_model_build_species_integrator(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_course_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.rtol = u->rtol;
    desc.largest = u->max_step;
    desc.settle = u->steady_transport;
    desc.fed = u->has_surface_reaction ? m->dissolve.shed : NULL;
    desc.shed =
        u->metal[pdi_setup_find_species_rate_metal(u) > 0 ? pdi_setup_find_species_rate_metal(u) : 0].species_released;
    desc.coat = m->surface_states ? &m->surface_states->state_solver : NULL;
    desc.species = u->electrolyte.species;
    desc.species_count = u->electrolyte.count;
    if (pdi_setup_find_species_rate_metal(u) >= 0 || pdi_setup_has_ion_electrodes(u)) {
        PDI_TRY(pdi_dissolution_laws_build(ctx, u, &m->reactive, u->has_dissolve ? &m->dissolve : NULL,
                                           &m->species_integrator, &m->cell, &m->electrodes, m->surface_states,
                                           &m->dissolution_laws));
        desc.surface = &m->dissolution_laws.surface_solver;
        desc.find = pdi_dissolution_laws_update_interface;
        desc.open = pdi_dissolution_laws_solve_initial;
        desc.user = &m->dissolution_laws;
    }
    if (u->potential.has_reaction && !u->has_migration) {
        desc.feed = pdi_electrode_map_add_faradaic_source;
        desc.feeder = &m->electrodes;
        desc.drained = pdi_electrode_map_report_depleted_species;
    }
    if (pdi_model_species_solve_currents(u)) {
        desc.bring = pdi_model_solve_currents;
        desc.bringer = &m->cell;
    }
    if (m->coverage_factor && !desc.surface) {
        desc.find = pdi_model_update_metal_source;
        desc.user = m;
    }
    desc.cover = m->coverage_factor ? u->shielding_thickness : 0.0;
    desc.bare = m->coverage_factor;
    desc.layers = PD_DIM * m->interface_stencil.reach;
    desc.whole = u->metal_body.has_rate_factor ? m->solid.rate_factor : m->boundary_factor;
    desc.reached = m->coverage_factor ? &m->dissolve.reached : NULL;
    return pd_course_build(ctx, &m->reactive, &desc, &m->species_integrator);
}

/* Grain-boundary rate factor of nodes, 1 + (gb_factor - 1) * boundary fraction. fraction [total]: output. */
static pd_status pdi_model_build_boundary_factor(pd_ctx *ctx, pd_model *m, float *fraction)
{
    PDI_TRY(pd_grain_fraction(ctx, &m->interface_stencil, &m->grid, &m->grain, fraction));
    PDI_TRY(pdi_grain_measure(ctx, &m->grid, &m->grain, fraction, &m->grain_stats));
    if (!m->setup->has_dissolve || !(fabs(m->setup->gb_factor - 1.0) > 0.0)) return PD_OK;
    PDI_TRY(PDI_NEW(ctx, "model", m->grid.total, m->boundary_factor));
    double more = m->setup->gb_factor - 1.0;
    for (int32_t i = 0; i < m->grid.total; i++) m->boundary_factor[i] = 1.0 + more * (double)fraction[i];
    return PD_OK;
}

static pd_status pdi_model_build_grains(pd_ctx *ctx, pd_model *m)
{
    float *fraction = NULL;
    PDI_TRY(pd_grain_build(ctx, &m->grid, &m->setup->grain, &m->grain));
    PDI_TRY(PDI_NEW(ctx, "model", m->grid.total, fraction));
    pd_status status = pdi_model_build_boundary_factor(ctx, m, fraction);
    PDI_DELETE(ctx, m->grid.total, fraction);
    return status;
}

/* Set the variables vars [PD_EXPR_VARS] of a rate-law expression at a node. */
static void pdi_model_set_law_variables(const pd_model_law *law, const pd_rate_at *at, double *vars)
{
    memset(vars, 0, PD_EXPR_VARS * sizeof *vars);
    vars[0] = at->c;
    vars[1] = at->t;
    memcpy(vars + 2, at->x, sizeof at->x);
    vars[PDI_SETUP_RATE_GRAIN] = at->grain;
    vars[PDI_SETUP_RATE_CURRENT] = vars[PDI_SETUP_RATE_POTENTIAL] = 0.0;
    if (law->cell && pdi_setup_has_electric_rate(law->metal))
        pdi_cell_beside(law->cell, at->node, law->kind, &vars[PDI_SETUP_RATE_CURRENT], &vars[PDI_SETUP_RATE_POTENTIAL]);
}

/* Dissolution speed [m/s] by the rate expression of a metal. A pd_rate_fn; user: a pd_model_law. */
static double pdi_model_compute_rate(void *user, const pd_rate_at *at)
{
    const pd_model_law *law = (const pd_model_law *)user;
    double vars[PD_EXPR_VARS];
    pdi_model_set_law_variables(law, at, vars);
    return law->metal->rate_scale * pdi_expr_eval(&law->metal->rate, vars);
}

/* Bounds *least, *most [m/s] of the speed over concentrations from .. to [mol/m3], by interval arithmetic. */
static void pdi_model_compute_rate_bounds(void *user, const pd_rate_at *at, double from, double to, double *least,
                                          double *most)
{
    const pd_model_law *law = (const pd_model_law *)user;
    double vars[PD_EXPR_VARS];
    pdi_model_set_law_variables(law, at, vars);
    pdi_interval range = pdi_interval_eval_expr(&law->metal->rate, vars, 1, from, to);
    *least = law->metal->rate_scale * range.low;
    *most = law->metal->rate_scale * range.high;
}

/* Mark nodes in front of a passive film. */
static pd_status pdi_model_mark_passive(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    if (u->passive < 0) return PD_OK;
    PDI_TRY(PDI_NEW(ctx, "model", m->grid.total, m->passive));
    for (int32_t i = 0; i < m->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&m->grid, i, x);
        m->passive[i] = (uint8_t)pdi_shape_contains(u->shape, u->passive, u->h, x);
    }
    return PD_OK;
}

/* Index of the metal of each solid node; later shapes override. */
static pd_status pdi_model_mark_metals(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    PDI_TRY(PDI_NEW(ctx, "model", m->grid.total, m->metal));
    for (int32_t i = 0; i < m->grid.total; i++) {
        double x[PD_DIM];
        if (m->grid.kind[i] != PD_SOLID) continue;
        pd_grid_position(&m->grid, i, x);
        for (int k = 1; k < u->metals; k++)
            if (pdi_shape_contains(u->shape, u->metal[k].shape, u->h, x)) m->metal[i] = (uint8_t)k;
    }
    return PD_OK;
}

/* Descriptor of a metal for the dissolution solver: solid concentration and rate law. */
static pd_metal pdi_model_set_metal_desc(const pd_model_law *law)
{
    const pd_setup_metal *metal = law->metal;
    pd_metal is;
    memset(&is, 0, sizeof is); /* no breaks: the bounds know them */
    is.solid = metal->solid_c;
    is.rate = pdi_model_compute_rate;
    is.rate_user = (void *)law; /* only read */
    is.uniform = metal->rate.variables_used >> 1 == 0;
    is.timeless = !(metal->rate.variables_used >> 1 & 1u);
    is.bounds = pdi_model_compute_rate_bounds;
    return is;
}

/* Additional descriptor fields of bond-based corrosion. */
static pd_status pdi_model_set_corrosion_desc(pd_ctx *ctx, pd_model *m, pd_dissolve_desc *desc)
{
    const pd_setup *u = m->setup;
    PDI_TRY(pdi_model_mark_passive(ctx, m));
    desc->model = PD_METAL_BONDS;
    desc->saturation = u->saturation;
    desc->rtol = u->rtol;
    desc->activation = u->activation;
    desc->bulk = u->bulk_c;
    desc->drive = u->drive;
    desc->kernel = u->kernel;
    desc->weights = u->weights;
    desc->stochastic = u->stochastic;
    desc->seed = (uint64_t)u->seed;
    desc->repassivation = u->repassivation;
    desc->passive = m->passive;
    return PD_OK;
}

/* 1: rate laws depend on the current density and on no other factor, so that Faraday's law can hold exactly. */
static int pdi_model_is_faradaic(const pd_setup *setup, const pd_dissolve_desc *desc)
{
    int sees = 0;
    for (int k = 0; k < setup->metals; k++)
        sees |= (int)(setup->metal[k].rate.variables_used >> PDI_SETUP_RATE_CURRENT & 1u);
    return sees && setup->has_potential && !setup->has_migration && !desc->factor && desc->drive == PD_DRIVE_CONSTANT;
}

/* Bring currents to time t [s] for the rate laws; with Faraday's law, match lost metal and charge. user: pd_model. */
static pd_status pdi_model_update_currents(pd_ctx *ctx, void *user, double t)
{
    pd_model *m = (pd_model *)user;
    if (!m->cell.grid) return PD_OK;
    if (m->cell.desc.timed && !pdi_model_needs_currents_per_step(m->setup)) PDI_TRY(pdi_cell_bring(ctx, &m->cell, t));
    if (pdi_model_is_faradaic(m->setup, &m->dissolve.desc)) pdi_cell_match(&m->cell);
    return PD_OK;
}

static pd_status pdi_model_build_dissolution(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_metal metal[PD_SETUP_METALS];
    pd_dissolve_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(metal, 0, sizeof metal);
    for (int k = 0; k < u->metals; k++) {
        m->law[k].metal = &u->metal[k];
        m->law[k].kind = k;
        m->law[k].cell = u->has_potential ? &m->cell : NULL;
        metal[k] = pdi_model_set_metal_desc(&m->law[k]);
    }
    desc.more = metal + 1;
    desc.more_count = u->metals - 1;
    desc.metal = m->metal;
    for (int k = 0; k < u->metals; k++)
        if (u->metal[k].rate.variables_used >> PDI_SETUP_RATE_GRAIN & 1u) desc.grain = m->grain.id;
    desc.factor = m->setup->metal_body.has_rate_factor ? m->solid.rate_factor : m->boundary_factor;
    if (u->shielding_thickness > 0.0 && u->minerals) {
        PDI_TRY(PDI_NEW(ctx, "model", m->grid.total, m->coverage_factor));
        for (int32_t i = 0; i < m->grid.total; i++) m->coverage_factor[i] = desc.factor ? desc.factor[i] : 1.0;
        desc.factor = m->coverage_factor;
        desc.lags = 1;
    }
    if (m->setup->has_corrode) PDI_TRY(pdi_model_set_corrosion_desc(ctx, m, &desc));
    else desc.threshold = m->setup->threshold;
    desc.sheds = u->has_surface_reaction ? 1 + (pdi_setup_count_species_rate_metals(u) > 1) : 0;
    for (int k = 0; k < u->metals; k++) {
        if (!pdi_setup_has_species_rate(&u->metal[k])) continue;
        metal[k].rate = pdi_dissolution_laws_get_speed;
        metal[k].rate_user = &m->dissolution_laws.law[pdi_setup_count_species_rate_metals(u) > 1 ? k : 0];
        metal[k].uniform = 0;
        metal[k].timeless = 1; /* it is found once a step */
        metal[k].bounds = NULL;
    }
    desc.solid = metal[0].solid;
    desc.rate = metal[0].rate;
    desc.rate_user = metal[0].rate_user;
    desc.uniform = metal[0].uniform;
    desc.timeless = metal[0].timeless;
    desc.bounds = metal[0].bounds;
    desc.follows = pdi_model_laws_read_potential(u);
    desc.driven = desc.follows && pdi_electrode_map_is_time_dependent(u);
    desc.anew = desc.follows && !pdi_model_needs_currents_per_step(u);
    if (desc.follows) {
        desc.found = pdi_model_update_currents;
        desc.found_user = m;
    }
    if (pdi_setup_find_species_rate_metal(u) >= 0 || pdi_setup_has_ion_electrodes(u)) {
        desc.found = pdi_dissolution_laws_update_speeds;
        desc.found_user = &m->dissolution_laws;
        desc.lags = 1;
    }
    m->unknowns[PD_PART_DISSOLVE] = m->grid.solid_count;
    return pd_dissolve_build(ctx, &m->grid, &m->interface_stencil, &m->transport, &desc, &m->dissolve);
}

static pd_status pdi_model_build_cell(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    int given = u->potential.conductivity > 0.0;
    m->unknowns[PD_PART_POTENTIAL] = m->grid.fluid_count;
    pd_status status =
        pdi_electrode_map_build(ctx, u, &m->bonds, &m->interface_stencil, m->metal, given ? NULL : &m->reactive,
                                u->has_dissolve ? &m->dissolve : NULL, m->surface_states, &m->electrodes, &m->cell);
    m->electrodes.cell = &m->cell;
    m->electrodes.species = &m->reactive;
    m->error_line = m->electrodes.error_line;
    return status;
}

/* Failure criterion of bonds (principal stress, energy or stretch) of all materials but springs. */
static pd_bond_failure_desc pdi_model_set_fracture_desc(const pd_setup_mechanics *b)
{
    pd_bond_failure_desc breaks;
    memset(&breaks, 0, sizeof breaks);
    breaks.critical = b->stretch;
    if (b->strength > 0.0) {
        breaks.kind = PD_BOND_FAILURE_PRINCIPAL;
        breaks.critical = b->strength;
    } else if (b->toughness > 0.0 && b->material != PD_SOLID_COUPLING_BOND_BASED) {
        breaks.kind = PD_BOND_FAILURE_ENERGY;
        breaks.fracture = b->toughness;
    }
    return breaks;
}

/* Cells across for 5 % error in bending, measured: plastic moments of bars are 4 % off with 12, 16, 24 cells for m = 1,
 * 2, 3; elastic curvatures at nu = 0.3 5 % off with 6, 12, 17, with the ordinary material 5, 8, 11. */
static int pdi_model_get_min_cells_across(const pd_setup_mechanics *b)
{
    if (b->yield > 0.0) return (int)ceil(5.0 * b->m + 6.0);
    if (b->material == PD_SOLID_COUPLING_BOND_BASED) return (int)ceil(2.0 * b->m + 2.0);
    return (int)ceil((b->material == PD_SOLID_COUPLING_ORDINARY_STATE ? 4.0 : 6.0) * b->m);
}

static pd_status pdi_model_build_solid(pd_ctx *ctx, pd_model *m)
{
    const pd_setup_mechanics *b = &m->setup->metal_body;
    pd_solid_coupling_precrack cuts[PD_SETUP_PRECRACKS];
    pd_solid_coupling_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.horizon_ratio = b->m;
    desc.elastic.young = b->young;
    desc.elastic.poisson = b->poisson;
    desc.elastic.plane = b->plane;
    desc.elastic.influence = b->influence;
    desc.elastic.yield = b->yield;
    desc.elastic.hardening = b->hardening;
    desc.material = b->material;
    desc.bond_failure = pdi_model_set_fracture_desc(b);
    if (b->material == PD_SOLID_COUPLING_BOND_BASED) desc.fracture = b->toughness;
    desc.density = b->density;
    desc.loads_in_time = b->is_time_dependent;
    desc.rtol = b->rtol;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int own = m->setup->side[side].kind != PD_SIDE_MIRROR;
        for (int k = 0; k < b->mechanical_bcs; k++) own |= b->mechanical_bc[k].side == side;
        if (!own) desc.mirrors |= 1 << side;
    }
    desc.load = pdi_mechanical_bc_apply;
    desc.user = &m->mechanical_bc;
    if (b->has_rate_factor) desc.rate_factor = pdi_mechanical_bc_compute_rate_factor;
    desc.pace_user = (void *)m->setup; /* only read */
    desc.base_rate_factor = m->boundary_factor;
    for (int k = 0; k < b->precracks; k++) {
        cuts[k].name = b->precrack[k].name;
        cuts[k].corners = b->precrack[k].corners;
        cuts[k].corner = b->precrack[k].corner;
    }
    desc.cuts = cuts;
    desc.cut_count = b->precracks;
    m->unknowns[PD_PART_SOLID] = (int64_t)PD_DIM * m->grid.solid_count;
    if (PD_DIM > 1) {
        m->min_cells_across = pdi_model_get_min_cells_across(b);
        PDI_TRY(pdi_thickness_compute_thin_fraction(ctx, &m->grid, m->min_cells_across, &m->thin_fraction));
    }
    PDI_TRY(pd_solid_coupling_build(ctx, &m->grid, &desc, &m->solid));
    return pdi_mechanical_bc_build(ctx, m->setup, &m->solid, &m->mechanical_bc);
}

PDI_FN const double *pdi_model_velocity(const pd_model *m)
{
    return m->gas.primitive ? m->gas.primitive + m->grid.total : m->flow.u;
}

/* Build all parts that the setup has, in order, and count their memory. */
static pd_status pdi_model_build_parts(pd_ctx *ctx, pd_model *m)
{
    typedef pd_status (*build_fn)(pd_ctx *, pd_model *);
    const pd_setup *u = m->setup;
    const pd_part part[] = {PD_PART_GRID, PD_PART_FLOW, PD_PART_GAS, PD_PART_TRANSPORT, PD_PART_GRAIN,
                            PD_PART_SOLID, PD_PART_CHEMISTRY, PD_PART_DISSOLVE, PD_PART_DISSOLVE,
                            PD_PART_CHEMISTRY, PD_PART_POTENTIAL, PD_PART_CHEMISTRY};
    const build_fn build[] = {pdi_model_build_lattice, pdi_model_build_flow, pdi_model_build_gas,
                              pdi_model_build_transport, pdi_model_build_grains, pdi_model_build_solid,
                              pdi_model_build_species, pdi_model_mark_metals, pdi_model_build_dissolution,
                              pdi_model_build_surface_states, pdi_model_build_cell, pdi_model_build_species_integrator};
    const int wanted[] = {1, u->has_flow, u->has_gas, u->has_transport, u->has_grains, u->has_solid, u->has_chemistry,
                          u->metals > 1, u->has_dissolve, u->states > 0, u->has_potential, u->has_chemistry};
    for (size_t k = 0; k < sizeof part / sizeof part[0]; k++) {
        size_t before = ctx->in_use;
        if (!wanted[k]) continue;
        m->error_line = u->line[part[k]];
        PDI_TRY(build[k](ctx, m));
        m->bytes[part[k]] += ctx->in_use - before;
    }
    return PD_OK;
}

PDI_FN void pdi_model_get_statistics(const pd_model *m, pdi_model_statistics *e)
{
    const pd_setup *u = m->setup;
    int moves = u->has_flow && (u->flow_time == PD_FLOW_IMPLICIT || u->flow_time == PD_FLOW_EXPLICIT);
    const pd_transport_result *r = u->has_dissolve ? &m->dissolve.result : &m->transport_integrator.result;
    e->flow_solves = moves ? m->time_loop.steps : m->quasi.solves;
    e->flow_evaluations = moves ? m->flow.evaluations : m->quasi.evaluations;
    e->flow_krylov = m->quasi.krylov;
    e->transport_krylov = u->has_dissolve ? m->dissolve.krylov : m->transport_integrator.krylov;
    e->transport_krylov += m->species_integrator.krylov;
    e->limiter_iterations = r->limiter;
    e->momentum = m->quasi.result.momentum;
    e->continuity = m->quasi.result.continuity;
    e->steady_change = r->change;
    e->mass_defect = r->defect;
}

/* The species as a process, with the step limit of time-dependent surface laws. */
static pd_physics pdi_model_species_process(pd_model *m)
{
    pd_physics course = pd_course_process(&m->species_integrator);
    course.has_substeps |= pdi_model_needs_currents_per_step(m->setup) && m->setup->has_dissolve;
    pdi_rate_step_limit_build(m->setup, m->dissolution_laws.setup ? &m->dissolution_laws : NULL, m->surface_states,
                              &m->rate_step_limit);
    if (!course.attempt || (!m->rate_step_limit.attack && !m->rate_step_limit.surfaces)) return course;
    course.time_limit = pdi_rate_step_limit_compute;
    course.time_limit_user = &m->rate_step_limit;
    return course;
}

/* Add all solvers to the time loop, in the order of a step. */
static pd_status pdi_model_add_processes(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_time_loop *c = &m->time_loop;
    if (u->has_flow && u->flow_time == PD_FLOW_STEADY)
        PDI_TRY(pd_time_loop_add_process(ctx, c, pd_quasi_steady_process(&m->flow, &m->steady, &m->quasi)));
    if (u->has_flow && u->flow_time == PD_FLOW_IMPLICIT)
        PDI_TRY(pd_time_loop_add_process(ctx, c, pd_implicit_process(&m->implicit)));
    if (u->has_flow && u->flow_time == PD_FLOW_EXPLICIT)
        PDI_TRY(pd_time_loop_add_process(ctx, c, pd_weakly_compressible_process(&m->unsteady)));
    if (u->has_gas) PDI_TRY(pd_time_loop_add_process(ctx, c, pd_gas_process(&m->gas)));
    pd_dissolve *dissolve = u->has_dissolve ? &m->dissolve : NULL;
    if (u->has_solid) PDI_TRY(pd_time_loop_add_process(ctx, c, pd_solid_coupling_process(&m->solid, dissolve)));
    int first =
        m->dissolution_laws.setup || m->coverage_factor || (pdi_model_needs_currents_per_step(u) && u->has_dissolve);
    if (first) PDI_TRY(pd_time_loop_add_process(ctx, c, pdi_model_species_process(m)));
    if (u->has_dissolve) PDI_TRY(pd_time_loop_add_process(ctx, c, pd_dissolve_process(&m->dissolve)));
    else if (u->has_transport)
        PDI_TRY(pd_time_loop_add_process(ctx, c, pd_two_stage_process(&m->transport_integrator)));
    if (u->has_chemistry && !first) PDI_TRY(pd_time_loop_add_process(ctx, c, pdi_model_species_process(m)));
    if (u->has_potential) PDI_TRY(pd_time_loop_add_process(ctx, c, pd_cell_process(&m->cell)));
    return PD_OK;
}

/* 1: bonds have to be updated after metal has dissolved: something reads them. */
static int pdi_model_needs_bond_updates(const pd_setup *u)
{
    return !u->has_corrode || !u->activation || u->has_flow || u->has_chemistry || u->has_potential ||
           u->probes || u->monitors;
}

PDI_FN int pdi_model_is_undefined(const pd_model *m, pd_field field, int32_t i)
{
    int dissolved = field == PD_FIELD_PH || field == PD_FIELD_SATURATION_INDEX ||
                    field == PD_FIELD_DIFFUSION_POTENTIAL || pdi_fields_species_index(m->setup, field) >= 0;
    if (field == PD_FIELD_C) dissolved = !m->setup->has_corrode;
    return m->just_converted && m->just_converted[i] && dissolved && m->grid.kind[i] == PD_FLUID;
}

PDI_FN pd_status pdi_model_build(pd_ctx *ctx, const pd_setup *setup, pd_model *m)
{
    pd_time_loop_desc desc;
    memset(m, 0, sizeof *m);
    memset(&desc, 0, sizeof desc);
    m->setup = setup;
    desc.fraction = setup->max_node_fraction;
    desc.max_step = setup->max_step;
    pd_status status = pdi_model_build_parts(ctx, m);
    if (status == PD_OK) status = pdi_input_step_limit_build(ctx, setup, &m->input_step_limit);
    if (m->input_step_limit.count) desc.next_event = pdi_input_step_limit_compute;
    desc.next_event_user = &m->input_step_limit;
    pd_bonds *bonds = pdi_model_needs_bond_updates(setup) ? &m->bonds : NULL;
    if (status == PD_OK) status = pd_time_loop_build(ctx, &desc, &m->grid, bonds, &m->time_loop);
    if (status == PD_OK && setup->has_dissolve && (!setup->has_corrode || setup->has_chemistry))
        status = PDI_NEW(ctx, "model", m->grid.total, m->just_converted);
    m->time_loop.new_fluid = m->just_converted;
    if (status == PD_OK) status = pdi_model_add_processes(ctx, m);
    int line = m->error_line;
    if (status < 0) pdi_model_free(ctx, m);
    m->error_line = line;
    return status;
}

PDI_FN void pdi_model_free(pd_ctx *ctx, pd_model *m)
{
    pd_cell_free(ctx, &m->cell);
    PDI_DELETE(ctx, m->grid.total, m->passive);
    PDI_DELETE(ctx, m->grid.total, m->metal);
    pd_course_free(ctx, &m->species_integrator);
    pdi_dissolution_laws_free(ctx, &m->dissolution_laws);
    if (m->surface_states) pdi_surface_states_free(ctx, m->surface_states);
    PDI_DELETE(ctx, 1, m->surface_states);
    pd_dissolve_free(ctx, &m->dissolve);
    pd_reactive_free(ctx, &m->reactive);
    pd_solid_coupling_free(ctx, &m->solid);
    pdi_mechanical_bc_free(ctx, &m->mechanical_bc);
    PDI_DELETE(ctx, m->grid.total, m->boundary_factor);
    PDI_DELETE(ctx, m->grid.total, m->coverage_factor);
    PDI_DELETE(ctx, m->grid.total, m->just_converted);
    pdi_input_step_limit_free(ctx, &m->input_step_limit);
    pd_grain_free(ctx, &m->grain);
    pd_two_stage_free(ctx, &m->transport_integrator);
    pd_transport_free(ctx, &m->transport);
    pd_gas_free(ctx, &m->gas);
    pd_implicit_free(ctx, &m->implicit);
    pd_weakly_compressible_free(ctx, &m->unsteady);
    pd_steady_free(ctx, &m->steady);
    pd_flow_free(ctx, &m->flow);
    pd_arena_free(ctx, &m->arena);
    pdi_inlet_free(ctx, &m->inlet);
    pdi_bond_path_free(ctx, &m->paths);
    pd_stencil_free(ctx, &m->interface_stencil);
    pd_bonds_free(ctx, &m->bonds);
    pd_grid_free(ctx, &m->grid);
    pd_stencil_free(ctx, &m->stencil);
    memset(m, 0, sizeof *m);
}

#undef PDI_MODEL_CORROSION_TOLERANCE
#undef PDI_MODEL_LIMITER_TOLERANCE
