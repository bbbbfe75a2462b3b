/* transport_physics: see transport_physics.h */
#include "physics/transport_physics.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Linear tolerance with bond-based corrosion and no flow: residuals carry over to the next step, of error 1e-3. */
#define PDI_TRANSPORT_PHYSICS_CORROSION_TOLERANCE 1e-9
/* Tolerance of the iterations on limited fluxes, over rtol of the time step. */
#define PDI_TRANSPORT_PHYSICS_LIMITER_TOLERANCE 0.0025
/* Additional Krylov vectors that transport without flow allocates during a run. */
#define PDI_TRANSPORT_PHYSICS_KRYLOV_VECTORS 3.0

/* Set field [total] [mol/m3] to the initial concentration at fluid nodes; other nodes stay. PD_ERR_STATE: it is
 * negative, NaN, or at least 1e100; nodes before it are set. */
static pd_status pdi_transport_physics_set_initial_concentration(pd_ctx *ctx, const pd_model *m, double *field)
{
    for (int32_t node = 0; node < m->grid.total; node++) {
        double x[PD_DIM];
        if (m->grid.kind[node] != PD_FLUID) continue;
        pd_grid_position(&m->grid, node, x);
        double c = pdi_setup_eval_expr(&m->setup->initial_c, x, 0.0);
        if (!(c >= 0.0) || !(c < 1e100))
            return pd_fail(ctx, PD_ERR_STATE, "model",
                           "initial gives C = %g mol/m3 at x = %g m, expected a finite value of at least 0", c, x[0]);
        field[node] = c;
    }
    return PD_OK;
}

/* Signed distance [m] of x from the surface of the medium (porous body), negative within it. user: the pd_inlet. */
static double pdi_transport_physics_compute_interface_distance(void *user, const double *x)
{
    const pd_inlet *inlet = (const pd_inlet *)user;
    return pdi_grid_signed_distance(inlet->grid, inlet->setup->medium, x);
}

/* Diffusivity [m2/s] at x, in or outside of the medium. user: the pd_inlet. */
static double pdi_transport_physics_get_diffusivity(void *user, const double *x)
{
    const pd_setup *u = ((const pd_inlet *)user)->setup;
    return pdi_transport_physics_compute_interface_distance(user, x) <= pd_shape_surface_tolerance(u->h, x)
               ? u->medium_diffusivity
               : u->diffusivity;
}

/* Builds the transport of the dissolved substance, with media, boundary values and initial concentration; its time
 * integrator only where no metal dissolves. The limiter tolerance is that of the setup, else 0 in steady transport,
 * else 0.0025 rtol. PD_ERR_STATE: the initial concentration is refused. */
static pd_status pdi_transport_physics_build(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_transport_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.diffusivity = u->diffusivity;
    desc.inlet = u->inlet_c;
    desc.advection = u->advection;
    desc.limiter_tolerance = u->limiter_tolerance > 0.0 ? u->limiter_tolerance
                             : u->steady_transport      ? 0.0
                                                        : PDI_TRANSPORT_PHYSICS_LIMITER_TOLERANCE * u->rtol;
    desc.given = u->has_corrode && u->activation && !u->has_flow;
    if (u->has_corrode && !u->has_flow) desc.tolerance = PDI_TRANSPORT_PHYSICS_CORROSION_TOLERANCE;
    if (u->medium >= 0) desc.field = pdi_transport_physics_get_diffusivity;
    if (u->medium >= 0) desc.level = pdi_transport_physics_compute_interface_distance;
    if (pdi_wall_bc_has_concentration(u)) desc.held = pdi_wall_bc_get_concentration;
    desc.walls_only = 1;
    if (u->flow_time == PD_FLOW_PRESCRIBED || u->has_inlet_c_by_side) desc.entering = pdi_inlet_get_concentration;
    desc.user = &m->inlet;
    desc.arena = &m->arena;
    if (m->inlet.is_time_dependent) desc.clock = &m->inlet.time;
    PD_TRY(pd_transport_build(ctx, &m->grid, &m->bonds, u->has_flow ? &m->flow : NULL, &desc, &m->transport));
    m->unknowns[PD_PART_TRANSPORT] = m->grid.fluid_count;
    if (!u->has_dissolve) {
        pd_two_stage_desc two_stage;
        memset(&two_stage, 0, sizeof two_stage);
        two_stage.rtol = u->rtol;
        two_stage.largest = u->max_step;
        PD_TRY(pd_two_stage_build(ctx, &m->transport, &two_stage, &m->transport_integrator));
        m->transport_integrator.settle = u->steady_transport;
    }
    return pdi_transport_physics_set_initial_concentration(ctx, m, m->transport.c);
}

/* Set the memory of transport, with that of its time integrator where no metal dissolves; add its multigrid levels and,
 * without flow, Krylov vectors to the runtime. Bond-based corrosion under activation control without flow has arrays of
 * concentrations alone. */
static void pdi_transport_physics_estimate(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_TRANSPORT];
    int medium = setup->medium >= 0;
    pd_transport t;
    pd_two_stage two_stage;
    memset(&t, 0, sizeof t);
    memset(&two_stage, 0, sizeof two_stage);
    t.grid = &plan->grid;
    t.bonds = t.flux.bonds = t.limiter.bonds = t.diffusion.bonds = &plan->bonds;
    t.desc.advection = setup->advection;
    if (setup->has_flow) t.flow = t.flux.flow = &plan->flow;
    if (medium) t.desc.field = t.diffusion.media.surface_distance = pdi_memory_plan_get_placeholder;
    t.desc.given = setup->has_corrode && setup->activation && !setup->has_flow;
    if (t.desc.given) {
        *bytes = pdi_memory_plan_count_array_bytes(plan, pdi_transport_list, &t);
        return;
    }
    if (pdi_wall_bc_has_concentration(setup)) t.diffusion.desc.held = pdi_memory_plan_get_placeholder;
    t.diffusion.desc.smooth = !pdi_transport_limits(&t);
    t.diffusion.media.grid = &plan->grid;
    t.diffusion.media.stencil = &plan->stencil;
    t.diffusion.media.rows = (int32_t)(b->near_medium / plan->node_scale);
    t.flux.conductance.bonds = &plan->bonds;
    t.flux.conductance.capacity = plan->bonds.capacity;
    t.flux.conductance.rests = pdi_transport_rests(&t);
    two_stage.transport = &t;
    pdi_transport_plan(&plan->ctx, &t);
    *bytes = pdi_memory_plan_count_array_bytes(plan, pdi_transport_list, &t);
    *bytes += pdi_memory_plan_add_scratch(plan, pdi_transport_room(&t));
    if (!setup->has_flow)
        b->runtime_bytes += PDI_TRANSPORT_PHYSICS_KRYLOV_VECTORS * 2.0 * (medium ? 8.0 : 4.0) * plan->node_scale *
                            (double)t.krylov.length;
    t.diffusion.capacity = plan->bonds.capacity;
    t.diffusion.metals = plan->grid.solid_count > 0;
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_diffusion_list, &t.diffusion);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_diffusion_place_list, &t.diffusion);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_conductance_list, &t.flux.conductance);
    if (medium)
        *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_bond_diffusivity_list_node_arrays, &t.diffusion.media);
    if (medium)
        *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_bond_diffusivity_list_row_arrays, &t.diffusion.media);
    if (!setup->has_dissolve) *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_two_stage_list, &two_stage);
    pdi_memory_plan_add_shared_levels(plan, pdi_memory_plan_count_level_bytes(plan, &t.inverse.mg), b);
}

/* Prints diffusivity, scheme and boundary values. */
static void pdi_transport_physics_print_summary(const pdi_summary_text *s)
{
    const pd_setup *u = s->model->setup;
    char text[384], value[2 * PD_UNITS_TEXT + 32], inside[PD_UNITS_TEXT], until[PD_UNITS_TEXT];
    pd_setup_format_value(u->diffusivity, "m2/s", value);
    pd_setup_format_value(u->medium_diffusivity, "m2/s", inside);
    if (u->medium >= 0) snprintf(value + strlen(value), sizeof value - strlen(value), " and %s in the medium", inside);
    pd_setup_format_value(u->end_time, "s", until);
    snprintf(text, sizeof text, u->steady_transport ? "%s, D = %s, steady" : "%s, D = %s, implicit, until %s",
             !u->has_flow                          ? "diffusion"
             : u->advection == PD_ADVECTION_UPWIND ? "upwind advection and diffusion"
                                                   : "limited advection and diffusion",
             value, until);
    pdi_summary_text_print_part(s, PD_PART_TRANSPORT, "transport", text);
}

static int pdi_transport_physics_is_present(const pd_setup *setup) { return setup->has_transport; }

/* Adds transport to the time loop where no metal dissolves: dissolving metal steps the concentration itself. */
static pd_status pdi_transport_physics_add_processes(pd_ctx *ctx, pd_model *m)
{
    if (m->setup->has_dissolve) return PD_OK;
    return pd_time_loop_add_process(ctx, &m->time_loop, pd_two_stage_process(&m->transport_integrator));
}

static void pdi_transport_physics_free(pd_ctx *ctx, pd_model *m)
{
    pd_two_stage_free(ctx, &m->transport_integrator);
    pd_transport_free(ctx, &m->transport);
}

/* Adds the Krylov iterations of transport to the statistics of the run and sets its residuals; nothing with dissolving
 * metal. */
static void pdi_transport_physics_add_statistics(const pd_model *m, pd_model_statistics *e)
{
    const pd_transport_result *r = &m->transport_integrator.result;
    if (m->setup->has_dissolve) return;
    e->transport_krylov += m->transport_integrator.krylov;
    e->limiter_iterations = r->limiter;
    e->steady_change = r->change;
    e->mass_defect = r->defect;
}

/* Copies the concentration to ghosts from their sources, also behind outlets, where there is no gradient (eq. 6.1);
 * inlets hold their own values. */
static void pdi_transport_physics_prepare_samples(pd_ctx *ctx, pd_model *m, pd_fields fields)
{
    const pd_ghosts *g = &m->bonds.ghosts;
    double *c = m->transport.c;
    (void)ctx;
    (void)fields;
    for (int32_t k = 0; k < g->outlets_end; k++) c[g->node[k]] = c[g->source[k]];
}

/* Value of a field of the transport at node i: C [mol/m3] or D [m2/s]; 0 at nodes that are not fluid. */
static double pdi_transport_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    const double *diffusivity = m->transport.diffusion.field;
    if (m->grid.kind[i] != PD_FLUID) return 0.0;
    if (field == PD_FIELD_C) return m->transport.c[i];
    return diffusivity ? diffusivity[i] : m->setup->diffusivity;
}

static const double *pdi_transport_physics_get_values(const pd_model *m, pd_field field, int component)
{
    (void)component;
    return field == PD_FIELD_C ? m->transport.c : NULL;
}

PDI_FN void pdi_transport_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row = pdi_physics_row_add(list, "transport", PD_PART_TRANSPORT, pdi_transport_physics_is_present);
    row->stage = PDI_PHYSICS_STAGE_METAL;
    row->build = pdi_transport_physics_build;
    row->add_processes = pdi_transport_physics_add_processes;
    row->free = pdi_transport_physics_free;
    row->add_statistics = pdi_transport_physics_add_statistics;
    row->prepare_samples = pdi_transport_physics_prepare_samples;
    row->estimate = pdi_transport_physics_estimate;
    row->print_summary = pdi_transport_physics_print_summary;
    pdi_physics_row_add_fields(row, PD_FIELD_C, PD_FIELD_C, pdi_transport_physics_sample,
                               pdi_transport_physics_get_values);
    pdi_physics_row_add_fields(row, PD_FIELD_D, PD_FIELD_D, pdi_transport_physics_sample,
                               pdi_transport_physics_get_values);
}

#undef PDI_TRANSPORT_PHYSICS_CORROSION_TOLERANCE
#undef PDI_TRANSPORT_PHYSICS_LIMITER_TOLERANCE
#undef PDI_TRANSPORT_PHYSICS_KRYLOV_VECTORS
