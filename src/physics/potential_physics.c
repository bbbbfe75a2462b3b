/* potential_physics: see potential_physics.h */
#include "physics/potential_physics.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Builds the electrodes and the potential of the fluid, with the conductivity of the setup, or, if that is 0, of the
 * species. error_line becomes that of the electrode at fault, or of the section. Errors: those of
 * pdi_electrode_map_build. */
static pd_status pdi_potential_physics_build(pd_ctx *ctx, pd_model *m)
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

/* Placeholder for the conductivity callback. */
static void pdi_potential_physics_set_placeholder(void *user, double *field)
{
    (void)user;
    (void)field;
}

/* Set the memory of the potential solver in b->bytes, and add its multigrid levels to the runtime bytes. Contacts are
 * estimated as the faces of a cube of all metal, at most one for each fluid node. */
static void pdi_potential_physics_estimate(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    const pd_setup_potential *e = &setup->potential;
    double *bytes = &b->bytes[PD_PART_POTENTIAL];
    pd_dissolve dissolve;
    pd_cell cell;
    size_t room = 0;
    memset(&cell, 0, sizeof cell);
    memset(&dissolve, 0, sizeof dissolve);
    pd_potential *p = &cell.potential;
    cell.grid = p->grid = &plan->grid;
    if (setup->has_dissolve) cell.dissolve = &dissolve;
    if (!(e->conductivity > 0.0)) cell.desc.conduct = pdi_potential_physics_set_placeholder;
    cell.desc.potential.electrodes = e->electrodes;
    for (int k = 0; k < e->electrodes; k++) p->desc.circuits += e->electrode[k].circuit == k;
    for (int k = 0; k < e->electrodes; k++)
        p->floating += e->electrode[k].circuit == k && !e->electrode[k].has_fixed_potential;
    cell.desc.potential.circuits = p->desc.circuits;
    p->bonds = p->flux.bonds = p->diffusion.bonds = &plan->bonds;
    p->flux.conductance.bonds = &plan->bonds;
    p->flux.conductance.capacity = p->diffusion.capacity = plan->bonds.capacity;
    p->flux.diffusion = &p->diffusion;
    p->diffusion.metals = plan->grid.solid_count > 0;
    p->diffusion.desc.smooth = 1;
    /* a contact for each fluid node beside metal, which has at least the surface of a cube */
    double shell = pd_min(2.0 * PD_DIM * pow(b->solid, (PD_DIM - 1.0) / PD_DIM), b->fluid);
    p->contacts.count = (int32_t)(shell / plan->node_scale);
    *bytes = pdi_memory_plan_count_array_bytes(plan, pdi_cell_list, &cell) +
             pdi_memory_plan_count_array_bytes(plan, pdi_distribution_list, p);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_distribution_contact_list, p) +
              shell * (double)sizeof *p->contacts.list;
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_diffusion_list, &p->diffusion);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_diffusion_place_list, &p->diffusion);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_conductance_list, &p->flux.conductance);
    p->diffusion.media.grid = &plan->grid;
    p->diffusion.media.stencil = &plan->stencil;
    if (cell.desc.conduct)
        *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_bond_diffusivity_list_node_arrays, &p->diffusion.media);
    if (pdi_distribution_plan(&plan->ctx, p, &room) >= 0) *bytes += plan->node_scale * (double)room;
    b->runtime_bytes += pdi_memory_plan_count_level_bytes(plan, &p->inverse.mg);
}

/* Prints conductivity and electrodes. */
static void pdi_potential_physics_print_summary(const pdi_summary_text *s)
{
    const pd_setup *u = s->model->setup;
    const pd_electrode_map *e = &s->model->electrodes;
    char text[384], value[PD_UNITS_TEXT] = "that of the species";
    if (u->potential.conductivity > 0.0) pd_setup_format_value(u->potential.conductivity, "S/m", value);
    snprintf(text, sizeof text, "%d electrode%s in %d circuit%s, conductivity %s", u->potential.electrodes,
             u->potential.electrodes > 1 ? "s" : "", e->circuits, e->circuits > 1 ? "s" : "", value);
    pdi_summary_text_print_part(s, PD_PART_POTENTIAL, "potential", text);
}

static int pdi_potential_physics_is_present(const pd_setup *setup) { return setup->has_potential; }

static pd_status pdi_potential_physics_add_processes(pd_ctx *ctx, pd_model *m)
{
    return pd_time_loop_add_process(ctx, &m->time_loop, pd_cell_process(&m->cell));
}

static void pdi_potential_physics_free(pd_ctx *ctx, pd_model *m) { pd_cell_free(ctx, &m->cell); }

/* Value at a fluid node: potential [V], norm of the current density [A/m2] in the fluid, or current density [A/m2] from
 * metal to fluid, mean over the metal beside it. At other nodes NaN, the norm 0. With ions that migrate potential and
 * current from metal are those of the species. */
static double pdi_potential_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    const pd_species_electrodes *species = &m->dissolution_laws.species_electrodes;
    int fluid = m->grid.kind[i] == PD_FLUID;
    double j[PD_DIM];
    if (field == PD_FIELD_CURRENT_FLUID) {
        if (fluid) pdi_cell_current(&m->cell, i, j);
        return fluid ? pdi_vec_norm(j) : 0.0;
    }
    if (!fluid) return (double)NAN;
    if (field == PD_FIELD_PHI)
        return species->setup ? pd_reactive_potential(&m->reactive, i) : m->cell.potential.phi[i];
    return species->setup ? pdi_species_electrodes_compute_current_density(species, i) : pdi_cell_density(&m->cell, i);
}

/* Array [total] [V] of the potential; NULL: values at nodes are to be taken, of currents and of ions that migrate. */
static const double *pdi_potential_physics_get_values(const pd_model *m, pd_field field, int component)
{
    (void)component;
    return field == PD_FIELD_PHI && !m->dissolution_laws.species_electrodes.setup ? m->cell.potential.phi : NULL;
}

PDI_FN void pdi_potential_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row = pdi_physics_row_add(list, "potential", PD_PART_POTENTIAL, pdi_potential_physics_is_present);
    row->stage = PDI_PHYSICS_STAGE_CURRENTS;
    row->build = pdi_potential_physics_build;
    row->add_processes = pdi_potential_physics_add_processes;
    row->free = pdi_potential_physics_free;
    row->reads_bonds = pdi_physics_row_always;
    row->estimate = pdi_potential_physics_estimate;
    row->print_summary = pdi_potential_physics_print_summary;
    pdi_physics_row_add_fields(row, PD_FIELD_PHI, PD_FIELD_CURRENT_METAL, pdi_potential_physics_sample,
                               pdi_potential_physics_get_values);
}
