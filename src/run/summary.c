/* summary: see summary.h */
#include "run/summary.h"
#include "core/vec.h"
#include "run/memory_estimate.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* The model and where its description is printed. */
typedef struct pdi_summary {
    const pd_model *model;
    pd_print_fn print;
    void *user;
} pdi_summary;

/* Print a formatted line. */
PD_PRINTF_LIKE(2, 3)
static void pdi_summary_print_line(const pdi_summary *s, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    s->print(s->user, PD_PRINT_SUMMARY, text);
}

/* Print a line such as "flow what it is" with unknowns and memory of the part. */
static void pdi_summary_print_part(const pdi_summary *s, pd_part part, const char *name, const char *what)
{
    const pd_model *m = s->model;
    char unknowns[48] = "";
    if (m->unknowns[part]) snprintf(unknowns, sizeof unknowns, "%.0f unknowns, ", (double)m->unknowns[part]);
    pdi_summary_print_line(s, "  %-12s%s; %s%.3g MB", name, what, unknowns, (double)m->bytes[part] * 1e-6);
}

static void pdi_summary_print_grid(const pdi_summary *s)
{
    const pd_model *m = s->model;
    char size[96] = "", spacing[3 * PD_UNITS_TEXT] = "", text[PD_UNITS_TEXT], metal[64] = "";
    int axes = 1;
    for (int d = 1; d < PD_DIM; d++)
        if (fabs(m->grid.h[d] - m->grid.h[0]) > 1e-12 * m->grid.h[0]) axes = PD_DIM;
    for (int d = 0; d < PD_DIM; d++) {
        size_t used = strlen(size), length = strlen(spacing);
        snprintf(size + used, sizeof size - used, "%s%d", d ? " x " : "", m->grid.n[d]);
        if (d >= axes) continue;
        pdi_setup_format_value(m->grid.h[d], "m", text);
        snprintf(spacing + length, sizeof spacing - length, "%s%s", d ? " x " : "", text);
    }
    if (m->setup->has_dissolve && m->interface_stencil.count != m->stencil.count)
        snprintf(metal, sizeof metal, "; metal m = %g (%d bonds)", m->interface_stencil.m, m->interface_stencil.count);
    pdi_summary_print_line(s, "%s: %dD%s, %s nodes at %s, m = %g (%d bonds a node)%s", m->setup->name, PD_DIM,
                           m->setup->axisymmetric ? " axisymmetric" : "", size, spacing, m->stencil.m, m->stencil.count,
                           metal);
    snprintf(size, sizeof size, "%.0f fluid, %.0f solid, %.0f wall", (double)m->grid.fluid_count,
             (double)m->grid.solid_count, (double)(pdi_grid_count_kind(&m->grid, PD_WALL)));
    pdi_summary_print_part(s, PD_PART_GRID, "lattice", size);
}

static void pdi_summary_print_flow(const pdi_summary *s)
{
    const pd_model *m = s->model;
    char text[384], speed[PD_UNITS_TEXT], length[PD_UNITS_TEXT];
    if (!m->setup->has_flow) return;
    pdi_setup_format_value(m->flow.reference_speed, "m/s", speed);
    pdi_setup_format_value(m->flow.reference_length, "m", length);
    char how[112];
    const char *order = m->flow.order == 4 ? ", order 4" : "";
    if (m->setup->flow_time == PD_FLOW_IMPLICIT)
        snprintf(how, sizeof how, "incompressible flow in time, implicit, step error %g%s",
                 m->implicit.desc.rtol, order);
    else if (m->setup->flow_time == PD_FLOW_EXPLICIT)
        snprintf(how, sizeof how, "weakly compressible flow in time, explicit, c0 = %g m/s", m->setup->sound_speed);
    else if (m->setup->flow_time == PD_FLOW_PRESCRIBED) snprintf(how, sizeof how, "given flow");
    else snprintf(how, sizeof how, "steady Navier-Stokes to residual %g%s", m->setup->steady_tolerance, order);
    snprintf(text, sizeof text, "%s, U = %s, L = %s, Re = %.4g", how, speed, length,
             m->flow.reference_speed * m->flow.reference_length / m->flow.nu);
    pdi_summary_print_part(s, PD_PART_FLOW, "flow", text);
}

static void pdi_summary_print_gas(const pdi_summary *s)
{
    const pd_setup *u = s->model->setup;
    char text[192], until[PD_UNITS_TEXT];
    if (!u->has_gas) return;
    pdi_setup_format_value(u->end_time, "s", until);
    snprintf(text, sizeof text, "ideal gas with gamma = %g, %s order, explicit, until %s", u->gas_gamma,
             u->gas_order == PD_GAS_SECOND ? "second" : "first", until);
    pdi_summary_print_part(s, PD_PART_GAS, "gas", text);
}

static void pdi_summary_print_transport(const pdi_summary *s)
{
    const pd_setup *u = s->model->setup;
    char text[384], value[2 * PD_UNITS_TEXT + 32], inside[PD_UNITS_TEXT], until[PD_UNITS_TEXT];
    if (!u->has_transport) return;
    pdi_setup_format_value(u->diffusivity, "m2/s", value);
    pdi_setup_format_value(u->medium_diffusivity, "m2/s", inside);
    if (u->medium >= 0) snprintf(value + strlen(value), sizeof value - strlen(value), " and %s in the medium", inside);
    pdi_setup_format_value(u->end_time, "s", until);
    snprintf(text, sizeof text, u->steady_transport ? "%s, D = %s, steady" : "%s, D = %s, implicit, until %s",
             !u->has_flow                          ? "diffusion"
             : u->advection == PD_ADVECTION_UPWIND ? "upwind advection and diffusion"
                                                   : "limited advection and diffusion",
             value, until);
    pdi_summary_print_part(s, PD_PART_TRANSPORT, "transport", text);
}

/* Print the species released or consumed by dissolution of metal m, per formula unit. */
static void pdi_summary_print_released_species(const pdi_summary *s, int m)
{
    const pd_setup *u = s->model->setup;
    const pd_setup_metal *metal = &u->metal[m];
    char text[384];
    if (pdi_setup_find_species_rate_metal(u) < 0 ? m > 0 : !pdi_setup_has_species_rate(metal)) return;
    snprintf(text, sizeof text,
             "one of %s:", pdi_setup_count_species_rate_metals(u) > 1 ? metal->material.name : "metal");
    for (int k = 0; k < u->electrolyte.count; k++)
        if (fabs(metal->species_released[k]) > 0.0)
            pdi_append(text, sizeof text, " %+g %s", metal->species_released[k], u->electrolyte.species[k].name);
    if (fabs(metal->gas_released) > 0.0) pdi_append(text, sizeof text, " %+g %s", metal->gas_released, u->gas);
    pdi_summary_print_line(s, "  %-12s%s", "", text);
}

static void pdi_summary_print_chemistry(const pdi_summary *s)
{
    const pd_setup *u = s->model->setup;
    const pd_components *c = &s->model->reactive.components;
    char text[384], until[PD_UNITS_TEXT];
    if (!u->has_chemistry) return;
    pdi_setup_format_value(u->end_time, "s", until);
    snprintf(text, sizeof text, "%d solutes of %d components, %d reactions (%d with a rate), %s, %.5g K, %s%s",
             c->solutes, c->count, u->electrolyte.reactions, c->kinetics,
             u->electrolyte.activity == PD_ACTIVITY_DAVIES ? "Davies" : "ideal", u->electrolyte.temperature,
             u->steady_transport ? "steady" : "implicit, until ", u->steady_transport ? "" : until);
    pdi_summary_print_part(s, PD_PART_CHEMISTRY, "chemistry", text);
    snprintf(text, sizeof text, "states of surfaces:");
    for (int k = 0; k < u->states; k++) pdi_append(text, sizeof text, "%s %s", k ? "," : "", u->state[k].label);
    if (u->states) pdi_summary_print_line(s, "  %-12s%s", "", text);
    for (int m = 0; m < u->metals && u->has_surface_reaction; m++) pdi_summary_print_released_species(s, m);
}

static void pdi_summary_print_potential(const pdi_summary *s)
{
    const pd_setup *u = s->model->setup;
    const pd_electrode_map *e = &s->model->electrodes;
    char text[384], value[PD_UNITS_TEXT] = "that of the species";
    if (!u->has_potential) return;
    if (u->potential.conductivity > 0.0) pdi_setup_format_value(u->potential.conductivity, "S/m", value);
    snprintf(text, sizeof text, "%d electrode%s in %d circuit%s, conductivity %s", u->potential.electrodes,
             u->potential.electrodes > 1 ? "s" : "", e->circuits, e->circuits > 1 ? "s" : "", value);
    pdi_summary_print_part(s, PD_PART_POTENTIAL, "potential", text);
}

/* Describe the dissolution rate of metal m, as "surface rate 1 um/h at C = 0 (8.766 mm/year, 3.8 A/m2 with z = 2), Cs =
 * 71508 mol/m3". */
static void pdi_summary_format_rate(const pd_setup *setup, int m, char *text, size_t size)
{
    const pd_setup_metal *metal = &setup->metal[m];
    char speed[PD_UNITS_TEXT];
    double v = pdi_setup_compute_rate_at_zero(metal), z = metal->material.charge;
    pdi_setup_format_value(v, "m/s", speed);
    if (pdi_setup_has_species_rate(metal) || pdi_setup_has_electric_rate(metal)) {
        snprintf(text, size, "%s%ssurface rate by %s, z = %g, Cs = %.6g mol/m3",
                 setup->metals > 1 ? metal->material.name : "", setup->metals > 1 ? ": " : "",
                 pdi_setup_has_species_rate(metal) ? "a law in the species at the surface" : "the potential", z,
                 metal->solid_c);
        return;
    }
    snprintf(text, size, "%s%ssurface rate %s at C = 0%s (%.4g mm/year, %.4g A/m2 with z = %g), Cs = %.6g mol/m3",
             setup->metals > 1 ? metal->material.name : "", setup->metals > 1 ? ": " : "", speed,
             metal->rate.variables_used > 1 ? ", t = 0 and the origin" : "", v * 1e3 * 31557600.0,
             v * metal->solid_c * z * PDI_FARADAY, z, metal->solid_c);
}

static void pdi_summary_print_dissolution(const pdi_summary *s)
{
    const pd_setup *u = s->model->setup;
    char text[384];
    if (!u->has_dissolve || u->has_corrode) return;
    pdi_summary_format_rate(u, 0, text, sizeof text);
    pdi_summary_print_part(s, PD_PART_DISSOLVE, "dissolution", text);
    for (int m = 1; m < u->metals; m++) {
        pdi_summary_format_rate(u, m, text, sizeof text);
        pdi_summary_print_line(s, "  %-12s%s", "", text);
    }
    if (u->saturation > 0.0) pdi_summary_print_line(s, "  %-12sCsat = %.6g mol/m3", "", u->saturation);
}

static void pdi_summary_print_corrosion(const pdi_summary *s)
{
    static const char *const kernels[] = {"area", "inverse square", "inverse"};
    const pd_setup *u = s->model->setup;
    char text[384];
    if (!u->has_corrode) return;
    snprintf(text, sizeof text, "bond-based, %s control", u->activation ? "activation" : "diffusion");
    pdi_summary_print_part(s, PD_PART_DISSOLVE, "corrosion", text);
    for (int m = 0; m < u->metals; m++) {
        pdi_summary_format_rate(u, m, text, sizeof text);
        pdi_summary_print_line(s, "  %-12s%s, Csat = %.6g mol/m3", "", text, u->saturation);
    }
    pdi_summary_print_line(s, "  %-12s%s weights, %s%s", "", kernels[u->kernel],
                           u->weights == PD_WEIGHTS_PUBLISHED ? "printed" : "calibrated",
                           u->drive == PD_DRIVE_DIFFERENCE ? ", loss in proportion to the difference" : "");
    if (u->stochastic) pdi_summary_print_line(s, "  %-12smechanical bonds break at random, seed %d", "", u->seed);
}

static void pdi_summary_print_grains(const pdi_summary *s)
{
    const pd_model *m = s->model;
    char text[384], mean[PD_UNITS_TEXT], width[PD_UNITS_TEXT];
    if (!m->setup->has_grains) return;
    pdi_setup_format_value(m->grain_stats.mean, "m", mean);
    pdi_setup_format_value(m->grain.boundary_width, "m", width);
    double share = m->grain_stats.boundary_fraction;
    snprintf(text, sizeof text,
             "%d in the solid, mean %s, boundaries %s wide: %.3g %% of the solid, mean rate factor %.5g",
             (int)m->grain_stats.count, mean, width, 100.0 * share, 1.0 + (m->setup->gb_factor - 1.0) * share);
    pdi_summary_print_part(s, PD_PART_GRAIN, "grains", text);
}

/* Print the failure criteria of bonds. */
static void pdi_summary_print_fracture(const pdi_summary *s)
{
    const pd_setup_mechanics *b = &s->model->setup->metal_body;
    char strength[PD_UNITS_TEXT];
    pdi_setup_format_value(b->strength, "Pa", strength);
    if (b->stretch > 0.0) pdi_summary_print_line(s, "  %-12sbonds break at a stretch of %g", "", b->stretch);
    if (b->strength > 0.0) pdi_summary_print_line(s, "  %-12sbonds break at a principal stress of %s", "", strength);
    if (b->toughness > 0.0) pdi_summary_print_line(s, "  %-12scracks take %g J/m2", "", b->toughness);
}

static void pdi_summary_print_solid(const pdi_summary *s)
{
    static const char *const materials[] = {"small strains", "springs", "ordinary", "neo-Hookean", "Hencky"};
    const pd_model *m = s->model;
    const pd_setup_mechanics *b = &m->setup->metal_body;
    char text[384], young[PD_UNITS_TEXT], yield[PD_UNITS_TEXT];
    if (!m->setup->has_solid) return;
    pdi_setup_format_value(b->young, "Pa", young);
    pdi_setup_format_value(b->yield, "Pa", yield);
    snprintf(text, sizeof text, "%s, E = %s, nu = %g%s, m = %g, %.0f bonds", materials[b->material], young, b->poisson,
             PD_DIM != 2                   ? ""
             : b->plane == PD_PLANE_STRESS ? ", plane stress"
                                           : ", plane strain",
             b->m, 0.5 * (double)m->solid.body.bonds);
    pdi_summary_print_part(s, PD_PART_SOLID, "solid", text);
    if (b->yield > 0.0) pdi_summary_print_line(s, "  %-12sflows at %s", "", yield);
    pdi_summary_print_fracture(s);
    if (b->density > 0.0)
        pdi_summary_print_line(s, "  %-12smoves, %g kg/m3, steps of %g s", "", b->density,
                               m->solid.dynamic_solver.max_step);
}

/* Print a note where metal has too few cells across for bending. */
static void pdi_summary_print_thin_metal(const pdi_summary *s)
{
    static const char *const across[] = {"6 m", "2 m + 2", "4 m", "6 m", "6 m"};
    const pd_setup_mechanics *b = &s->model->setup->metal_body;
    char text[320];
    if (!(s->model->thin_fraction > 0.0)) return;
    snprintf(text, sizeof text,
             "solid: %.3g %% of the metal is in parts thinner than %d cells, %s: where they are "
             "bent they are more than 5 %% off; expected a smaller h, or a smaller m",
             100.0 * s->model->thin_fraction, s->model->min_cells_across,
             b->yield > 0.0 ? "5 m + 6 of metal that flows" : across[b->material]);
    s->print(s->user, PD_PRINT_NOTE, text);
}

/* Print the list of monitors, as "plane up, plane down, force pin". */
static void pdi_summary_print_monitors(const pdi_summary *s)
{
    const pd_setup *u = s->model->setup;
    char text[384] = "";
    for (int k = 0; k < u->monitors; k++) {
        size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s%s %s", k ? ", " : "",
                 pdi_setup_monitor_section_name(u->monitor[k].kind), u->monitor[k].name);
    }
    if (u->monitors) pdi_summary_print_line(s, "  %-12s%s", "watched", text);
}

/* Print the physics that is not modelled. */
static void pdi_summary_print_absent(const pdi_summary *s)
{
    const pd_setup *u = s->model->setup;
    char text[256] = "  not modelled: ";
    const char *const names[] = {"flow", "transport", "dissolution", "grains", "inertia of the flow in time", "gas",
                                 "mechanics", "chemistry", "potential"};
    const int has[] = {
        u->has_flow, u->has_transport, u->has_dissolve,  u->has_grains,   u->flow_time != PD_FLOW_STEADY || u->has_gas,
        u->has_gas,  u->has_solid,     u->has_chemistry, u->has_potential};
    int absent = 0;
    for (int k = 0; k < (int)(sizeof has / sizeof has[0]); k++) {
        size_t used = strlen(text);
        if (!has[k]) snprintf(text + used, sizeof text - used, "%s%s", absent++ ? ", " : "", names[k]);
    }
    if (absent) pdi_summary_print_line(s, "%s", text);
}

PDI_FN void pdi_summary_print(const pd_model *model, pd_print_fn print, void *user)
{
    pdi_summary s;
    pd_memory_estimate footprint;
    size_t bytes = 0;
    if (!print) return;
    s.model = model;
    s.print = print;
    s.user = user;
    pdi_summary_print_grid(&s);
    pdi_summary_print_flow(&s);
    pdi_summary_print_gas(&s);
    pdi_summary_print_transport(&s);
    pdi_summary_print_chemistry(&s);
    pdi_summary_print_potential(&s);
    pdi_summary_print_dissolution(&s);
    pdi_summary_print_corrosion(&s);
    pdi_summary_print_grains(&s);
    pdi_summary_print_solid(&s);
    pdi_summary_print_monitors(&s);
    pdi_summary_print_absent(&s);
    for (int k = 0; k < PD_PART_COUNT; k++) bytes += model->bytes[k];
    pd_memory_estimate_compute(model->setup, &footprint);
    pdi_summary_print_line(
        &s, "  %-12s%.3g MB, %.0f bytes a node; about %.3g MB with files and pictures", "in all", (double)bytes * 1e-6,
        (double)bytes / (double)(model->grid.fluid_count + model->grid.solid_count), footprint.total_bytes * 1e-6);
    for (int k = 0; k < model->setup->notes; k++) print(user, PD_PRINT_NOTE, model->setup->note[k]);
    pdi_summary_print_thin_metal(&s);
}
