/* species_physics: see species_physics.h */
#include "physics/species_physics.h"
#include "setup/fields.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Set the composition of fluid nodes within the shape `solution`, in equilibrium of electrolyte e, and restart the
 * reactive solver. Errors: those of pd_electrolyte_solve and pd_reactive_begin. */
static pd_status pdi_species_physics_set_initial_solution(pd_ctx *ctx, const pd_electrolyte *e, pd_model *m)
{
    const pd_setup *u = m->setup;
    double inside[PD_SPECIES_MAX], x[PD_DIM];
    pd_electrolyte_state state;
    memcpy(inside, e->shape_initial, sizeof inside);
    PD_TRY(pd_electrolyte_solve(ctx, e, inside, &state));
    for (int32_t i = 0; i < m->grid.total; i++) {
        if (m->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&m->grid, i, x);
        if (!pdi_shape_contains(u->shape, u->solution, u->h, x)) continue;
        for (int k = 0; k < e->count; k++)
            if (pd_reactive_field(&m->reactive, k)) pd_reactive_field(&m->reactive, k)[i] = inside[k];
    }
    return pd_reactive_begin(ctx, &m->reactive);
}

/* Allocate and build the surface states; potential solver and rate laws, to which they point, are built later. */
static pd_status pdi_species_physics_build_surface_states(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    m->error_line = u->state[0].line;
    PD_TRY(PD_NEW(ctx, "model", 1, m->surface_states));
    return pdi_surface_states_build(ctx, u, &m->reactive, &m->bonds, &m->interface_stencil,
                                    u->has_potential ? &m->cell : NULL,
                                    pd_setup_find_species_rate_metal(u) >= 0 || pd_setup_has_ion_electrodes(u)
                                        ? &m->dissolution_laws.surface_solver
                                        : NULL,
                                    m->surface_states);
}

/* Builds reactive transport: initial and inlet compositions in chemical equilibrium without mineral reactions, the
 * solution inside shapes, states of surfaces, and the number of unknowns. PD_ERR_ARGUMENT, PD_ERR_DIVERGED: a
 * composition has no equilibrium. */
static pd_status pdi_species_physics_build(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_electrolyte e = u->electrolyte;
    double initial[PD_SPECIES_MAX], inlet[PD_SPECIES_MAX];
    pd_electrolyte_state state;
    pd_reactive_desc desc;
    pd_setup_get_reactive_desc(u, &desc);
    memcpy(initial, e.initial, sizeof initial);
    memcpy(inlet, e.inlet, sizeof inlet);
    e.reactions = pdi_mineral_copy_solid_free_reactions(e.species, e.count, e.reaction, e.reactions, e.reaction);
    PD_TRY(pd_electrolyte_solve(ctx, &e, initial, &state));
    PD_TRY(pd_electrolyte_solve(ctx, &e, inlet, &state));
    desc.initial = initial;
    desc.inlet = inlet;
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (u->side[s].has_fixed_species) desc.held = pdi_wall_bc_is_dirichlet_species;
    desc.wall = desc.held ? inlet : NULL;
    desc.user = &m->inlet;
    desc.arena = &m->arena;
    PD_TRY(pd_reactive_build(ctx, &m->grid, &m->bonds, u->has_flow ? &m->flow : NULL, &desc, &m->reactive));
    m->unknowns[PD_PART_CHEMISTRY] = m->reactive.components.count * m->grid.fluid_count;
    if (u->solution >= 0) PD_TRY(pdi_species_physics_set_initial_solution(ctx, &e, m));
    return u->states ? pdi_species_physics_build_surface_states(ctx, m) : PD_OK;
}

/* Set species_integrator.ahead [total] [mol/m3/s], the dissolution sources less what metal takes up at present
 * concentrations, for the next step of the species, whose middle is at t [s]; 0 at nodes that are not fluid. Sets the
 * time of the dissolution to t. PD_RETRY: shorten the step; `ahead` stays. A `find` callback of pd_course; user: the
 * pd_model. */
static pd_status pdi_species_physics_update_metal_source(pd_ctx *ctx, void *user, double t)
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

/* Solve the potential at time t [s]. The `bring` callback of pd_course; user: the pd_cell. */
static pd_status pdi_species_physics_solve_currents(pd_ctx *ctx, void *user, double t)
{
    return pdi_cell_bring(ctx, (pd_cell *)user, t);
}

/* Build the rate laws in the species, if a metal has one or electrodes stand among migrating ions, and the time
 * integrator of the species with its couplings: rate laws, electrode reactions, currents, states, released metal, and
 * coverage of metal by minerals. */
static pd_status pdi_species_physics_build_integrator(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_course_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.rtol = u->rtol;
    desc.largest = u->max_step;
    desc.settle = u->steady_transport;
    desc.fed = u->has_surface_reaction ? m->dissolve.shed : NULL;
    desc.shed =
        u->metal[pd_setup_find_species_rate_metal(u) > 0 ? pd_setup_find_species_rate_metal(u) : 0].species_released;
    desc.coat = m->surface_states ? &m->surface_states->state_solver : NULL;
    desc.species = u->electrolyte.species;
    desc.species_count = u->electrolyte.count;
    if (pd_setup_find_species_rate_metal(u) >= 0 || pd_setup_has_ion_electrodes(u)) {
        PD_TRY(pdi_dissolution_laws_build(ctx, u, &m->reactive, u->has_dissolve ? &m->dissolve : NULL,
                                          &m->species_integrator, &m->cell, &m->electrodes, m->surface_states,
                                          &m->dissolution_laws));
        m->dissolution_laws.set_registered = pdi_model_set_registered_variables;
        m->dissolution_laws.set_registered_user = m;
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
    if (pdi_electrode_map_is_solved_by_species(u)) {
        desc.bring = pdi_species_physics_solve_currents;
        desc.bringer = &m->cell;
    }
    if (m->coverage_factor && !desc.surface) {
        desc.find = pdi_species_physics_update_metal_source;
        desc.user = m;
    }
    desc.cover = m->coverage_factor ? u->shielding_thickness : 0.0;
    desc.bare = m->coverage_factor;
    desc.layers = PD_DIM * m->interface_stencil.reach;
    desc.whole = u->metal_body.has_rate_factor ? m->solid.rate_factor : m->boundary_factor;
    desc.reached = m->coverage_factor ? &m->dissolve.reached : NULL;
    return pd_course_build(ctx, &m->reactive, &desc, &m->species_integrator);
}

/* The species as a process. Also sets m->rate_step_limit, which limits its steps where surface laws depend on time; not
 * in steady transport. It may take several steps in one of the run where currents are solved in each and metal
 * dissolves. */
static pd_physics pdi_species_physics_get_process(pd_model *m)
{
    pd_physics course = pd_course_process(&m->species_integrator);
    course.has_substeps |= pdi_electrode_map_is_solved_per_species_step(m->setup) && m->setup->has_dissolve;
    pdi_rate_step_limit_build(m->setup, m->dissolution_laws.setup ? &m->dissolution_laws : NULL, m->surface_states,
                              &m->rate_step_limit);
    if (!course.attempt || (!m->rate_step_limit.attack && !m->rate_step_limit.surfaces)) return course;
    course.time_limit = pdi_rate_step_limit_compute;
    course.time_limit_user = &m->rate_step_limit;
    return course;
}

/* [byte] Memory of surface states; 0: the setup has none. */
static double pdi_species_physics_estimate_surface_states(const pd_setup *setup, pdi_memory_plan *plan, pd_reactive *r)
{
    pd_coat coat;
    memset(&coat, 0, sizeof coat);
    if (!setup->states) return 0.0;
    coat.reactive = r;
    pdi_surface_states_set_desc(setup, r, &coat.desc);
    pdi_coat_columns(&coat);
    return pdi_memory_plan_count_array_bytes(plan, pdi_coat_list, &coat);
}

/* Set the memory of the species: reactive transport, surface solver, time integrator, surface states; add that of
 * mineral coverage to the dissolution, and multigrid levels to the runtime. Leaves it at 0 where the chemistry is
 * refused, which the build of the model reports. */
static void pdi_species_physics_estimate(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_CHEMISTRY];
    pd_reactive_filter filter[PD_REACTION_MAX + PD_MINERAL_MAX];
    pd_krylov_desc kd;
    pd_reactive r;
    pd_course course;
    pd_etch etch;
    pd_coat coat;
    double mark = 0.0;
    memset(&r, 0, sizeof r);
    memset(&course, 0, sizeof course);
    memset(filter, 0, sizeof filter);
    pd_setup_get_reactive_desc(setup, &r.desc);
    if (pd_reactive_system(&plan->ctx, &r.desc, &r) < 0) return; /* the model says why */
    r.grid = &plan->grid;
    r.bonds = r.flux.bonds = r.diffusion.bonds = &plan->bonds;
    if (setup->has_flow) r.flow = r.flux.flow = &plan->flow;
    r.flux.conductance.bonds = &plan->bonds;
    r.flux.conductance.capacity = plan->bonds.capacity;
    r.flux.conductance.rests = !setup->has_flow;
    r.migration.on = setup->has_migration;
    r.migration.flux = &r.flux;
    r.filter = filter;
    pdi_reactive_slots(&r);
    pdi_reactive_plan(&plan->ctx, &r, &kd);
    *bytes = pdi_memory_plan_count_array_bytes(plan, pdi_reactive_list, &r);
    *bytes += pdi_memory_plan_add_scratch(plan, pdi_reactive_room(&r));
    for (int side = 0; side < 2 * PD_DIM; side++)
        if (setup->side[side].has_fixed_species) r.diffusion.desc.held = pdi_memory_plan_get_placeholder;
    r.diffusion.desc.smooth = 1;
    r.diffusion.capacity = plan->bonds.capacity;
    r.diffusion.metals = plan->grid.solid_count > 0;
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_diffusion_list, &r.diffusion);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_diffusion_place_list, &r.diffusion);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_conductance_list, &r.flux.conductance);
    course.reactive = &r;
    course.desc.settle = setup->steady_transport;
    memset(&etch, 0, sizeof etch);
    if (pd_setup_find_species_rate_metal(setup) >= 0 || pd_setup_has_ion_electrodes(setup)) {
        etch.reactive = &r;
        etch.kinds = pd_setup_count_species_rate_metals(setup);
        etch.desc.solid = pd_setup_find_species_rate_metal(setup) >= 0 && setup->metals == 1 ? 1.0 : 0.0;
        if (pd_setup_has_ion_electrodes(setup)) {
            etch.desc.electrodes.count = setup->potential.electrodes;
            etch.desc.electrodes.circuits = setup->potential.electrodes;
            for (int e = 0; e < setup->potential.electrodes; e++)
                etch.desc.electrodes.shares |= setup->potential.electrode[e].has_current_factor;
        }
        course.desc.surface = &etch;
        *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_etch_list, &etch);
    }
    course.desc.fed = setup->has_surface_reaction ? &mark : NULL;
    if (setup->shielding_thickness > 0.0 && setup->minerals && setup->has_dissolve) {
        course.desc.bare = &mark;
        b->bytes[PD_PART_DISSOLVE] += (double)plan->grid.total * sizeof(double);
    }
    *bytes += pdi_species_physics_estimate_surface_states(setup, plan, &r);
    if (setup->states) course.desc.coat = &coat;
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_course_list, &course);
    pdi_memory_plan_add_shared_levels(plan, (1.0 + r.filters) * pdi_memory_plan_count_level_bytes(plan, &r.inverse.mg),
                                      b);
}

/* Print the species and gas released (+) or consumed (-) by dissolution of metal m, per formula unit. Where no metal
 * has a law in the species, of the first one alone, else of those that have one. */
static void pdi_species_physics_print_released(const pdi_summary_text *s, int m)
{
    const pd_setup *u = s->model->setup;
    const pd_setup_metal *metal = &u->metal[m];
    char text[384];
    if (pd_setup_find_species_rate_metal(u) < 0 ? m > 0 : !pd_setup_has_species_rate(metal)) return;
    snprintf(text, sizeof text,
             "one of %s:", pd_setup_count_species_rate_metals(u) > 1 ? metal->material.name : "metal");
    for (int k = 0; k < u->electrolyte.count; k++)
        if (fabs(metal->species_released[k]) > 0.0)
            pd_append(text, sizeof text, " %+g %s", metal->species_released[k], u->electrolyte.species[k].name);
    if (fabs(metal->gas_released) > 0.0) pd_append(text, sizeof text, " %+g %s", metal->gas_released, u->gas);
    pdi_summary_text_print_line(s, "  %-12s%s", "", text);
}

/* Prints electrolyte, pH and minerals. */
static void pdi_species_physics_print_summary(const pdi_summary_text *s)
{
    const pd_setup *u = s->model->setup;
    const pd_components *c = &s->model->reactive.components;
    char text[384], until[PD_UNITS_TEXT];
    pd_setup_format_value(u->end_time, "s", until);
    snprintf(text, sizeof text, "%d solutes of %d components, %d reactions (%d with a rate), %s, %.5g K, %s%s",
             c->solutes, c->count, u->electrolyte.reactions, c->kinetics,
             u->electrolyte.activity == PD_ACTIVITY_DAVIES ? "Davies" : "ideal", u->electrolyte.temperature,
             u->steady_transport ? "steady" : "implicit, until ", u->steady_transport ? "" : until);
    pdi_summary_text_print_part(s, PD_PART_CHEMISTRY, "chemistry", text);
    snprintf(text, sizeof text, "states of surfaces:");
    for (int k = 0; k < u->states; k++) pd_append(text, sizeof text, "%s %s", k ? "," : "", u->state[k].label);
    if (u->states) pdi_summary_text_print_line(s, "  %-12s%s", "", text);
    for (int m = 0; m < u->metals && u->has_surface_reaction; m++) pdi_species_physics_print_released(s, m);
}

/* Array [total] [mol/m3] of the concentration of a species, or the amount of a mineral; NULL: it is no field of one. */
static const double *pdi_species_physics_get_field(const pd_model *m, pd_field field)
{
    int species = pd_fields_species_index(m->setup, field);
    int n = species < 0 ? -1 : m->reactive.components.solute_of_species[species];
    for (int s = 0; s < m->reactive.minerals.count; s++)
        if (species >= 0 && m->reactive.minerals.mineral[s].species == species)
            return m->reactive.solid + (int64_t)s * m->grid.total;
    return n < 0 ? NULL : m->reactive.c + (int64_t)n * m->grid.total;
}

static int pdi_species_physics_is_present(const pd_setup *setup) { return setup->has_chemistry; }

/* The stage of the species: before the metal where laws or films of the metal depend on them, else after it. */
static pdi_physics_stage pdi_species_physics_get_stage(const pd_model *m)
{
    int leads = m->dissolution_laws.setup || m->coverage_factor ||
                (pdi_electrode_map_is_solved_per_species_step(m->setup) && m->setup->has_dissolve);
    return leads ? PDI_PHYSICS_STAGE_SURFACE : PDI_PHYSICS_STAGE_SPECIES;
}

static pd_status pdi_species_physics_add_processes(pd_ctx *ctx, pd_model *m)
{
    return pd_time_loop_add_process(ctx, &m->time_loop, pdi_species_physics_get_process(m));
}

/* Frees what pdi_species_physics_build made. */
static void pdi_species_physics_free(pd_ctx *ctx, pd_model *m)
{
    pd_course_free(ctx, &m->species_integrator);
    pdi_dissolution_laws_free(ctx, &m->dissolution_laws);
    if (m->surface_states) pdi_surface_states_free(ctx, m->surface_states);
    PD_DELETE(ctx, 1, m->surface_states);
    pd_reactive_free(ctx, &m->reactive);
}

static void pdi_species_physics_add_statistics(const pd_model *m, pd_model_statistics *e)
{
    e->transport_krylov += m->species_integrator.krylov;
}

/* Fills the ghosts of all concentrations before nodes are sampled. */
static void pdi_species_physics_prepare_samples(pd_ctx *ctx, pd_model *m, pd_fields fields)
{
    (void)ctx;
    (void)fields;
    for (int n = 0; n < m->reactive.components.solutes; n++)
        pd_ghosts_set_scalar(&m->bonds.ghosts, m->reactive.c + (int64_t)n * m->grid.total);
}

/* 1: a field of the species, minerals or states; behind these follow the fields of the physics of the program. */
static int pdi_species_physics_has_field(const pd_setup *setup, pd_field field)
{
    return (int)field < pd_fields_first_registered(setup);
}

static const double *pdi_species_physics_get_values(const pd_model *m, pd_field field, int component)
{
    (void)component;
    return pdi_species_physics_get_field(m, field);
}

/* Value at a node of a field of the species, of minerals or of a state of surfaces. At nodes that are not fluid 0 for
 * concentrations and amounts, NaN for pH, saturation index, potential and states; a state is NaN where the surface does
 * not carry it, too. */
static double pdi_species_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    const double *species = pdi_species_physics_get_field(m, field);
    int fluid = m->grid.kind[i] == PD_FLUID, state = pd_fields_state_index(m->setup, field);
    if (field == PD_FIELD_MINERAL_FRACTION) return fluid ? pd_reactive_film(&m->reactive, i) : 0.0;
    if (species) return fluid ? species[i] : 0.0;
    if (!fluid) return (double)NAN;
    if (state >= 0) return pdi_surface_states_get_state(m->surface_states, state, i);
    if (field == PD_FIELD_PH) return pd_reactive_ph(&m->reactive, i);
    if (field == PD_FIELD_SATURATION_INDEX) return pd_reactive_saturation(&m->reactive, -1, i);
    return pd_reactive_potential(&m->reactive, i);
}

PDI_FN void pdi_species_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row = pdi_physics_row_add(list, "chemistry", PD_PART_CHEMISTRY, pdi_species_physics_is_present);
    row->get_stage = pdi_species_physics_get_stage;
    row->build = pdi_species_physics_build;
    row->connect = pdi_species_physics_build_integrator;
    row->add_processes = pdi_species_physics_add_processes;
    row->free = pdi_species_physics_free;
    row->reads_bonds = pdi_physics_row_always;
    row->add_statistics = pdi_species_physics_add_statistics;
    row->prepare_samples = pdi_species_physics_prepare_samples;
    row->estimate = pdi_species_physics_estimate;
    row->print_summary = pdi_species_physics_print_summary;
    pdi_physics_row_add_fields(row, PD_FIELD_PH, PD_FIELD_COUNT, pdi_species_physics_sample,
                               pdi_species_physics_get_values);
    row->sampler[0].has = pdi_species_physics_has_field;
}
