/* electrode_map: see electrode_map.h */
#include "physics/electrode_map.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Electrode of a solid node: the last one whose shape holds it, or, of one without a shape, whose material is that of
 * the node; -1: none. user: a pd_electrode_map. */
static int pdi_electrode_map_find_electrode(void *user, int32_t node)
{
    const pd_electrode_map *m = (const pd_electrode_map *)user;
    const pd_setup_potential *p = &m->setup->potential;
    double x[PD_DIM];
    pd_grid_position(m->grid, node, x);
    for (int k = p->electrodes; k-- > 0;) {
        const pd_setup_electrode *e = &p->electrode[k];
        if (e->shape < 0 ? e->metal == (m->metal ? m->metal[node] : 0)
                         : pdi_shape_contains(m->setup->shape, e->shape, m->grid->h, x))
            return k;
    }
    return -1;
}

PDI_FN double pdi_electrode_map_get_circuit_value(void *user, int circuit, double t)
{
    const pd_electrode_map *m = (const pd_electrode_map *)user;
    double x[PD_DIM];
    memset(x, 0, sizeof x);
    if (m->prescribed_electrode[circuit] < 0) return 0.0;
    return pdi_setup_eval_expr(&m->setup->potential.electrode[m->prescribed_electrode[circuit]].fixed_value, x, t);
}

PDI_FN int pdi_electrode_map_is_time_dependent(const pd_setup *setup)
{
    int timed = 0;
    for (int k = 0; k < setup->potential.electrodes; k++) {
        const pd_setup_electrode *e = &setup->potential.electrode[k];
        timed |= ((e->has_fixed_potential || e->has_fixed_current) && pd_setup_is_time_dependent(&e->fixed_value)) ||
                 (e->has_current_factor && pd_setup_is_time_dependent(&e->current_factor));
    }
    return timed;
}

/* Conductivity field [total] [S/m] of the electrolyte at fluid nodes, kappa = F^2/(R T) sum z^2 D c (theory: eq. 12.6);
 * negative concentrations count as 0. Other nodes get 0. user: a pd_electrode_map. */
static void pdi_electrode_map_compute_conductivity(void *user, double *field)
{
    const pd_electrode_map *m = (const pd_electrode_map *)user;
    const pd_electrolyte *e = &m->setup->electrolyte;
    double factor = PD_FARADAY * PD_FARADAY / (PD_GAS_CONSTANT * e->temperature);
    for (int32_t i = 0; i < m->grid->total; i++) field[i] = 0.0;
    for (int k = 0; k < e->count; k++) {
        const pd_species *s = &e->species[k];
        int place = m->reactive->components.solute_of_species[k];
        if (place < 0 || !s->charge) continue;
        double share = factor * s->charge * s->charge * s->diffusivity;
        const double *c = m->reactive->c + (int64_t)place * m->grid->total;
        for (int32_t i = 0; i < m->grid->total; i++)
            if (m->grid->kind[i] == PD_FLUID) field[i] += share * pd_max(c[i], 0.0);
    }
}

/* Set the factors of the curves of contact [count] from surface states at time t [s]; the `share` callback of
 * pd_cell_desc. */
static pd_status pdi_electrode_map_update_contact_factors(pd_ctx *ctx, void *user, pd_contact *contact, int32_t count,
                                                          double t)
{
    return pdi_surface_states_update_contact_factors(ctx, ((const pd_electrode_map *)user)->surfaces, contact, count,
                                                     t);
}

PDI_FN void pdi_electrode_map_add_faradaic_source(void *user, double *source)
{
    const pd_electrode_map *m = (const pd_electrode_map *)user;
    const pd_potential *p = &m->cell->potential;
    int64_t total = m->grid->total;
    for (int32_t k = 0; k < p->contacts.count; k++) {
        const pd_contact *contact = &p->contacts.list[k];
        const pd_setup_electrode *e = &m->setup->potential.electrode[contact->electrode];
        double electrons = contact->area * p->current[k] / PD_FARADAY;
        for (int n = 0; n < m->setup->electrolyte.count && e->has_reaction; n++) {
            int place = m->species->components.solute_of_species[n];
            if (place >= 0) source[place * total + contact->node] += e->species_released[n] * electrons;
        }
    }
}

PDI_FN pd_status pdi_electrode_map_report_depleted_species(pd_ctx *ctx, void *user, int32_t node, int solute, double t)
{
    const pd_electrode_map *m = (const pd_electrode_map *)user;
    const pd_potential *p = &m->cell->potential;
    const pd_electrolyte *of = &m->setup->electrolyte;
    const char *name = "";
    double most = 0.0;
    int species = 0, into = 0;
    char place[PDI_GRID_POSITION_LENGTH];
    while (species + 1 < of->count && m->species->components.solute_of_species[species] != solute) species++;
    for (int32_t k = 0; k < p->contacts.count; k++) {
        const pd_contact *c = &p->contacts.list[k];
        const pd_setup_electrode *e = &m->setup->potential.electrode[c->electrode];
        double takes =
            c->node == node && e->has_reaction ? -e->species_released[species] * c->area * p->current[k] : 0.0;
        if (!(takes > most)) continue;
        most = takes;
        name = e->name;
        into = p->current[k] < 0.0;
    }
    return pd_fail(ctx, PD_ERR_STATE, "potential",
                   "at t = %g s electrode %s takes up more of %s beside %s m than is "
                   "there: its current flows %s the metal, by which its reaction uses %s up; expected a curve or a "
                   "potential by which it flows the other way, or fluid that holds %s",
                   t, name, of->species[species].name, pdi_grid_format_position(m->grid, node, place),
                   into ? "into" : "out of", of->species[species].name, of->species[species].name);
}

/* Merge the circuits of electrodes a and b in wire [count]: members of a circuit share the lowest index. */
static void pdi_electrode_map_merge_circuits(int *wire, int count, int a, int b)
{
    int low = wire[a] < wire[b] ? wire[a] : wire[b], high = wire[a] < wire[b] ? wire[b] : wire[a];
    for (int k = 0; k < count; k++)
        if (wire[k] == high) wire[k] = low;
}

/* Check that all solid nodes belong to electrodes and all electrodes have nodes, and merge in wire [electrodes] the
 * circuits of electrodes with adjacent nodes, also across periodic sides. PD_ERR_GEOMETRY: metal without an electrode,
 * or an electrode without metal, whose line becomes m->error_line. */
static pd_status pdi_electrode_map_find_electrodes(pd_ctx *ctx, pd_electrode_map *m, int *wire)
{
    const pd_setup_potential *p = &m->setup->potential;
    int64_t nodes[PD_SETUP_ELECTRODES];
    char text[PDI_GRID_POSITION_LENGTH];
    memset(nodes, 0, sizeof nodes);
    for (int32_t i = 0; i < m->grid->total; i++) {
        if (m->grid->kind[i] != PD_SOLID || pd_grid_find_source(m->grid, i, NULL) != i) continue;
        int e = pdi_electrode_map_find_electrode(m, i);
        if (e < 0)
            return pd_fail(ctx, PD_ERR_GEOMETRY, "potential",
                           "the metal at %s m belongs to no electrode, expected an "
                           "[electrode NAME] with its shape or material, or kind = wall for what insulates",
                           pdi_grid_format_position(m->grid, i, text));
        nodes[e]++;
        for (int d = 0; d < PD_DIM; d++) {
            int32_t near = pd_grid_find_source(m->grid, i + m->grid->stride[d], NULL);
            if (m->grid->kind[near] == PD_SOLID && pdi_electrode_map_find_electrode(m, near) >= 0)
                pdi_electrode_map_merge_circuits(wire, p->electrodes, e, pdi_electrode_map_find_electrode(m, near));
        }
    }
    for (int k = 0; k < p->electrodes; k++) {
        if (nodes[k]) continue;
        m->error_line = p->electrode[k].line;
        return pd_fail(ctx, PD_ERR_GEOMETRY, "potential", "the electrode %s has no metal on the lattice, expected a "
                       "shape that is larger than the spacing, and that no later electrode covers",
                       p->electrode[k].name);
    }
    return PD_OK;
}

/* Number the circuits by wire [electrodes], and set the prescribed electrode of each (-1: none) with its kind and its
 * value at time 0. PD_ERR_ARGUMENT: two electrodes of a circuit have a prescribed potential or current; m->error_line
 * is that of the second. */
static pd_status pdi_electrode_map_build_circuits(pd_ctx *ctx, pd_electrode_map *m, const int *wire)
{
    const pd_setup_potential *p = &m->setup->potential;
    for (int k = 0; k < p->electrodes; k++) {
        if (wire[k] == k) m->prescribed_electrode[m->circuits] = -1;
        m->circuit_of_electrode[k] = wire[k] == k ? m->circuits++ : m->circuit_of_electrode[wire[k]];
    }
    for (int k = 0; k < p->electrodes; k++) {
        const pd_setup_electrode *e = &p->electrode[k];
        int *given = &m->prescribed_electrode[m->circuit_of_electrode[k]];
        if (!e->has_fixed_potential && !e->has_fixed_current) continue;
        m->error_line = e->line;
        if (*given >= 0)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "potential", "the electrodes %s and %s are connected or touch, and "
                           "both have a given potential or current, expected one of them", p->electrode[*given].name,
                           e->name);
        *given = k;
        m->circuit[m->circuit_of_electrode[k]].control =
            e->has_fixed_potential ? PD_CIRCUIT_POTENTIAL : PD_CIRCUIT_CURRENT;
        m->circuit[m->circuit_of_electrode[k]].value =
            pdi_electrode_map_get_circuit_value(m, m->circuit_of_electrode[k], 0.0);
    }
    return PD_OK;
}

/* Fill in the descriptor of the potential solver and build it. An electrode that is primary, has no curve, or an
 * expression in species gets no polarisation terms here. The conductivity is that of the setup, or from the species. */
static pd_status pdi_electrode_map_build_cell(pd_ctx *ctx, pd_electrode_map *m, const pd_bonds *bonds,
                                              const pd_stencil *across, const pd_dissolve *dissolve, pd_cell *cell)
{
    const pd_setup_potential *p = &m->setup->potential;
    pd_electrode_desc curve[PD_SETUP_ELECTRODES];
    pd_cell_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(curve, 0, sizeof curve);
    for (int k = 0; k < p->electrodes; k++) {
        const pd_setup_electrode *e = &p->electrode[k];
        curve[k].term = &e->term;
        curve[k].count = !e->primary && !e->has_no_curve && !e->has_species_curve;
        curve[k].equilibrium = e->term.equilibrium;
        curve[k].film = e->film_resistance;
        m->name[k] = e->name;
    }
    for (int k = 0; k < m->setup->metals; k++)
        desc.reads |= (m->setup->metal[k].rate.variables_used >> PD_SETUP_RATE_POTENTIAL & 1u) << k;
    desc.name = m->name;
    desc.electrode = curve;
    desc.circuit = m->circuit;
    desc.which = pdi_electrode_map_find_electrode;
    desc.timed = pdi_electrode_map_is_time_dependent(m->setup);
    desc.given = pdi_electrode_map_get_circuit_value;
    desc.user = m;
    desc.potential.conductivity = p->conductivity;
    desc.apart = m->setup->has_migration;
    if (m->reactive) desc.conduct = pdi_electrode_map_compute_conductivity;
    if (m->surfaces) desc.share = pdi_electrode_map_update_contact_factors;
    if (m->reactive) desc.potential.conductivity = 1.0; /* of no node of the fluid */
    desc.potential.electrodes = p->electrodes;
    desc.potential.circuits = m->circuits;
    desc.potential.member = m->circuit_of_electrode;
    desc.potential.wide = across;
    desc.potential.tolerance = p->tolerance;
    memcpy(desc.potential.held, p->has_fixed_potential, sizeof p->has_fixed_potential);
    memcpy(desc.potential.hold, p->fixed_potential, sizeof p->fixed_potential);
    m->error_line = m->setup->line[PD_PART_POTENTIAL];
    return pd_cell_build(ctx, m->grid, bonds, dissolve, &desc, cell);
}

PDI_FN pd_status pdi_electrode_map_build(pd_ctx *ctx, const pd_setup *setup, const pd_bonds *bonds,
                                         const pd_stencil *across, const uint8_t *metal, const pd_reactive *reactive,
                                         const pd_dissolve *dissolve, const pd_surface_states *surfaces,
                                         pd_electrode_map *m, pd_cell *cell)
{
    int wire[PD_SETUP_ELECTRODES];
    memset(m, 0, sizeof *m);
    m->setup = setup;
    m->grid = bonds->grid;
    m->metal = metal;
    m->reactive = reactive;
    m->surfaces = surfaces;
    m->error_line = setup->line[PD_PART_POTENTIAL];
    for (int k = 0; k < setup->potential.electrodes; k++) wire[k] = setup->potential.electrode[k].circuit;
    PD_TRY(pdi_electrode_map_find_electrodes(ctx, m, wire));
    PD_TRY(pdi_electrode_map_build_circuits(ctx, m, wire));
    return pdi_electrode_map_build_cell(ctx, m, bonds, across, dissolve, cell);
}

PDI_FN int pdi_electrode_map_is_solved_per_species_step(const pd_setup *setup)
{
    int covers = setup->shielding_thickness > 0.0 && setup->minerals && pdi_electrode_map_is_time_dependent(setup);
    int alters = !(setup->potential.conductivity > 0.0) || setup->states > 0 || covers;
    return setup->has_potential && setup->has_chemistry && !setup->has_migration && alters;
}

PDI_FN int pdi_electrode_map_is_read_by_laws(const pd_setup *u)
{
    int sees = 0;
    for (int k = 0; k < u->metals; k++)
        sees |= u->has_potential && !u->has_migration && pdi_setup_has_electric_rate(&u->metal[k]);
    return sees;
}

PDI_FN int pdi_electrode_map_is_solved_by_species(const pd_setup *setup)
{
    int timed = setup->has_potential && !setup->has_migration && pdi_electrode_map_is_time_dependent(setup);
    return pdi_electrode_map_is_solved_per_species_step(setup) || (timed && !pdi_electrode_map_is_read_by_laws(setup));
}
