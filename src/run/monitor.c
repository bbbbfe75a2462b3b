/* monitor: see monitor.h */
#include "run/monitor.h"
#include "setup/fields.h"
#include "flow/force.h"
#include "core/vec.h"
#include "couple/integral_diagnostics.h"
#include "solid/crack.h"
#include "io/plot.h"
#include "physics/reaction_force.h"
#include "physics/step_diagnostics.h"
#include "physics/sample.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Relative tolerance by which two numbers count as equal. */
#define PDI_MONITOR_TOLERANCE 1e-9

/* Units of amounts per depth, by dimension. */
static const char *const pdi_monitor_unit_area[] = {"-", "m", "m2"};
static const char *const pdi_monitor_unit_volume[] = {"m", "m2", "m3"};
static const char *const pdi_monitor_unit_flow[] = {"m/s", "m2/s", "m3/s"};
static const char *const pdi_monitor_unit_amount[] = {"mol/m2", "mol/m", "mol"};
static const char *const pdi_monitor_unit_species[] = {"mol/m2/s", "mol/m/s", "mol/s"};
static const char *const pdi_monitor_unit_force[] = {"N/m2", "N/m", "N"};
static const char *const pdi_monitor_unit_current[] = {"A/m2", "A/m", "A"};
static const char *const pdi_monitor_unit_charge[] = {"C/m2", "C/m", "C"};
static const char *const pdi_monitor_unit_energy[] = {"J/m2", "J/m", "J"};
static const char *const pdi_monitor_unit_momentum[] = {"kg/m/s", "kg/s", "kg m/s"};

/* Index into the tables of units: PD_DIM - 1, or 2 with axisymmetry, where amounts are over the whole circumference. */
static int pdi_monitor_get_unit_index(const pd_setup *setup) { return setup->axisymmetric ? 2 : PD_DIM - 1; }

/* ---- figures ---- */

/* Append an output to m->output and count it. Key and unit are copied and cut to their arrays. The array does not grow:
 * the count must be below m->capacity. */
static void pdi_monitor_add_output(pd_monitor *m, const char *key, const char *unit, double value)
{
    pd_monitor_output *f = &m->output[m->count++];
    PD_ASSERT(m->count <= m->capacity);
    snprintf(f->key, sizeof f->key, "%s", key);
    snprintf(f->unit, sizeof f->unit, "%s", unit);
    f->value = value;
}

/* Append PD_DIM outputs, scale times value[d]. The key of axis d is letter, x, y or z, then rest: "fx_friction". */
static void pdi_monitor_add_vector_output(pd_monitor *m, char letter, const char *rest, const char *unit,
                                          const double *value, double scale)
{
    char key[24];
    for (int d = 0; d < PD_DIM; d++) {
        snprintf(key, sizeof key, "%c%c%s", letter, "xyz"[d], rest);
        pdi_monitor_add_output(m, key, unit, scale * value[d]);
    }
}

/* Append the outputs of a plane: area; with flow, volume flow, mean speed and mean pressure; with transport, mean
 * concentration and species flux; with both, C_bulk, the mean weighted by the flow. Flows are signed, positive towards
 * +, and over the whole plane (per m in planar 2D, per m2 in 1D). Means are NaN where no face lies between two fluid
 * cells, C_bulk also at rest. */
static void pdi_monitor_compute_plane(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup *u = model->setup;
    pd_diagnostics_plane_result r;
    pd_diagnostics_plane(ctx, &model->bonds, u->has_flow ? &model->flow : NULL,
                         u->has_transport ? &model->transport : NULL, m->desc->axis, m->desc->index, &r);
    pdi_monitor_add_output(m, "area", pdi_monitor_unit_area[pdi_monitor_get_unit_index(u)], r.area);
    if (u->has_flow) {
        pdi_monitor_add_output(m, "flow", pdi_monitor_unit_flow[pdi_monitor_get_unit_index(u)], r.flow);
        pdi_monitor_add_output(m, "speed", "m/s", r.speed);
        pdi_monitor_add_output(m, "p", "Pa", r.pressure);
    }
    if (u->has_transport) pdi_monitor_add_output(m, "C_mean", "mol/m3", r.mean_concentration);
    if (u->has_transport && u->has_flow) pdi_monitor_add_output(m, "C_bulk", "mol/m3", r.mixed_concentration);
    if (u->has_transport)
        pdi_monitor_add_output(m, "species", pdi_monitor_unit_species[pdi_monitor_get_unit_index(u)], r.species_flux);
}

/* Force [PD_DIM] on what the box d->lo .. d->hi holds, by the momentum balance of steady flow. PD_ERR_GEOMETRY: a
 * closed node or the edge of the lattice lies within two cells of a side; the message is rewritten and names balance =
 * no. Other statuses are returned as they are. */
static pd_status pdi_monitor_compute_control_volume_force(pd_ctx *ctx, pd_model *model, const pd_setup_monitor *d,
                                                          double *force)
{
    char message[PD_MESSAGE_SIZE];
    pd_status status = pd_force_momentum_balance(ctx, &model->flow, d->lo, d->hi, force);
    if (status != PD_ERR_GEOMETRY) return status;
    memcpy(message, ctx->message, sizeof message);
    const char *what = strchr(message, ' ');
    return pd_fail(ctx, status, "force", "%.500s; balance = no leaves it out", what ? what + 1 : message);
}

/* Replace the outputs of a force: on the surface of one shape or of all bodies in the box, its friction and pressure
 * parts, with momentum_balance that of the balance, and with a reference speed > 0 coefficients 2 F/(rho U^2 A).
 * Nothing changes if no flow solve was made since the last call. PD_ERR_GEOMETRY: the box of the balance comes too
 * close to walls; the outputs are incomplete then. */
static pd_status pdi_monitor_compute_force(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    const char *unit = pdi_monitor_unit_force[pdi_monitor_get_unit_index(model->setup)];
    double force[PD_DIM], friction[PD_DIM], pressure[PD_DIM], around[PD_DIM];
    double scale = d->speed > 0.0 ? 2.0 / (model->flow.rho * d->speed * d->speed * d->area) : 0.0;
    pd_model_statistics effort;
    pd_model_get_statistics(model, &effort);
    if (m->flow_solves == effort.flow_solves) return PD_OK;
    m->flow_solves = effort.flow_solves;
    m->count = 0;
    pd_force_surface(ctx, &model->flow, d->shape ? d->shape - 1 : PD_FORCE_ALL, d->lo, d->hi, force, friction,
                     pressure);
    pdi_monitor_add_vector_output(m, 'f', "", unit, force, 1.0);
    pdi_monitor_add_vector_output(m, 'f', "_friction", unit, friction, 1.0);
    pdi_monitor_add_vector_output(m, 'f', "_pressure", unit, pressure, 1.0);
    if (d->momentum_balance) PD_TRY(pdi_monitor_compute_control_volume_force(ctx, model, d, around));
    if (d->momentum_balance) pdi_monitor_add_vector_output(m, 'f', "_balance", unit, around, 1.0);
    if (d->speed > 0.0) pdi_monitor_add_vector_output(m, 'c', "", "-", force, scale);
    if (d->speed > 0.0 && d->momentum_balance) pdi_monitor_add_vector_output(m, 'c', "_balance", "-", around, scale);
    return PD_OK;
}

/* Set m->fluid[rows] [mol/m3], the reference concentration of each layer: the given one, or for `bulk` the mixing-cup
 * mean sum u c/sum u over all fluid nodes of the layer, also those outside the box. u is the signed velocity along the
 * axis, times the circumference with axisymmetry. Not finite where sum u is 0. Overwrites m->profile as work. */
static void pdi_monitor_compute_layer_concentration(const pd_model *model, pd_monitor *m)
{
    const pd_grid *grid = &model->grid;
    const pd_setup_monitor *d = m->desc;
    for (int k = 0; k < m->rows; k++) m->fluid[k] = d->fluid_c;
    if (d->reference != PD_REFERENCE_FLUID_BULK) return;
    const double *u = model->flow.u + (int64_t)d->axis * grid->total;
    double *stream = m->profile; /* filled later */
    for (int k = 0; k < m->rows; k++) m->fluid[k] = stream[k] = 0.0;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID) continue;
        pd_grid_index(grid, node, i);
        double flow = u[node] * pd_grid_circumference(grid, node);
        m->fluid[i[d->axis]] += flow * model->transport.c[node];
        stream[i[d->axis]] += flow;
    }
    for (int k = 0; k < m->rows; k++) m->fluid[k] /= stream[k];
}

/* Append flux [mol/s] from walls and metal in the box into the fluid (per m in planar 2D, per m2 in 1D), area and
 * flux/area; with a reference length L > 0 also Sh = flux L/(excess D) and layer = excess D/flux, where excess sums
 * area (C_surface - C_fluid) over the layers that have area. A given area replaces the measured one and scales excess.
 * NaN or infinite where a divisor is 0. Fills m->flux, m->area and m->fluid by layers. */
static void pdi_monitor_compute_mass_transfer(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    double flux = 0.0, area = 0.0, excess = 0.0;
    pd_diagnostics_surface_flux(ctx, &model->paths, &model->transport,
                                model->setup->has_dissolve ? &model->dissolve : NULL, d->lo, d->hi, d->axis, m->flux,
                                m->area);
    pdi_monitor_compute_layer_concentration(model, m);
    for (int k = 0; k < m->rows; k++) {
        flux += m->flux[k];
        area += m->area[k];
        if (m->area[k] > 0.0) excess += m->area[k] * (d->surface_c - m->fluid[k]);
    }
    if (d->area > 0.0) {
        excess *= d->area / area;
        area = d->area;
    }
    pdi_monitor_add_output(m, "flux", pdi_monitor_unit_species[pdi_monitor_get_unit_index(model->setup)], flux);
    pdi_monitor_add_output(m, "area", pdi_monitor_unit_area[pdi_monitor_get_unit_index(model->setup)], area);
    pdi_monitor_add_output(m, "density", "mol/m2/s", flux / area);
    if (!(d->length > 0.0)) return;
    pdi_monitor_add_output(m, "Sh", "-", flux * d->length / (excess * d->diffusivity));
    pdi_monitor_add_output(m, "layer", "m", excess * d->diffusivity / flux);
}

/* [mol] Integral of a concentration field [mol/m3] over the fluid in the box of the monitor; per m in planar 2D, per m2
 * in 1D. */
static double pdi_monitor_integrate_concentration(pd_ctx *ctx, pd_model *model, const pd_monitor *m,
                                                  const double *field)
{
    pd_diagnostics_box_result r;
    pd_diagnostics_box(ctx, &model->stencil, &model->grid, NULL, field, NULL, m->desc->lo, m->desc->hi, &r);
    return r.dissolved;
}

/* Add to sum[rows] [mol] of the balance rows what the cells of the box do not show: amounts that the last step left to
 * the next one, and, where it is kept, solution beside the cells where metal has gone. Each amount of a component
 * counts by its part in the row. */
static void pdi_monitor_add_carried_amounts(pd_ctx *ctx, pd_model *model, const pd_monitor *m, double *sum)
{
    const pd_reactive *reactive = &model->reactive;
    for (int k = 0; k < reactive->components.count; k++) {
        double amount =
            pdi_monitor_integrate_concentration(ctx, model, m, reactive->carry + (int64_t)k * model->grid.total);
        if (reactive->swept)
            amount +=
                pdi_monitor_integrate_concentration(ctx, model, m, reactive->swept + (int64_t)k * model->grid.total);
        for (int row = 0; row < reactive->rows; row++)
            sum[row] += reactive->part[row][reactive->components.component_solute[k]] * amount;
    }
}

/* Append the amount [mol] in the fluid of the box of each species that has a field (no solvent, no solid that is no
 * mineral), then sum_NAME of each balance row, an element or the charge, with the amounts that carry over to the next
 * step. */
static void pdi_monitor_compute_species(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const char *unit = pdi_monitor_unit_amount[pdi_monitor_get_unit_index(model->setup)];
    const pd_electrolyte *e = &model->setup->electrolyte;
    const pd_reactive *reactive = &model->reactive;
    double sum[PD_REACTIVE_ROWS];
    char key[PD_REACTIVE_NAME + 8];
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < e->count; k++) {
        const double *c = pd_reactive_field(&model->reactive, k);
        if (!c) continue;
        double amount = pdi_monitor_integrate_concentration(ctx, model, m, c);
        pdi_monitor_add_output(m, e->species[k].name, unit, amount);
        for (int row = 0; row < reactive->rows; row++) sum[row] += pd_reactive_part(reactive, row, k) * amount;
    }
    pdi_monitor_add_carried_amounts(ctx, model, m, sum);
    for (int row = 0; row < reactive->rows; row++) {
        snprintf(key, sizeof key, "sum_%s", reactive->name[row]);
        pdi_monitor_add_output(m, key, unit, sum[row]);
    }
}

/* Set the smallest and largest concentration in r from the fluid nodes of the box whose concentration is defined, i.e.
 * without nodes just converted to fluid. Both are NaN if there are none. */
static void pdi_monitor_compute_extremes(const pd_model *model, const pd_setup_monitor *desc,
                                         pd_diagnostics_box_result *r)
{
    double x[PD_DIM];
    r->min_concentration = r->max_concentration = (double)NAN;
    for (int32_t i = 0; i < model->grid.total; i++) {
        if (model->grid.kind[i] != PD_FLUID || pd_model_is_undefined(model, PD_FIELD_C, i)) continue;
        pd_grid_position(&model->grid, i, x);
        if (!pd_grid_is_between(&model->grid, desc->lo, desc->hi, x)) continue;
        r->min_concentration = pd_min(r->min_concentration, model->transport.c[i]);
        r->max_concentration = pd_max(r->max_concentration, model->transport.c[i]);
    }
}

/* Append the outputs of a box: volume of fluid; with flow, kinetic energy and momentum by axes; with transport,
 * dissolved amount and extremes of C in the fluid, without nodes just converted; with dissolution, the amount left in
 * the metal; with chemistry, the species. Amounts are totals of the box (per m in planar 2D, per m2 in 1D). */
static void pdi_monitor_compute_total(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup *u = model->setup;
    pd_diagnostics_box_result r;
    const double *c = model->transport.c;
    pd_diagnostics_box(ctx, &model->stencil, &model->grid, u->has_flow ? &model->flow : NULL, c,
                       u->has_dissolve ? c : NULL, m->desc->lo, m->desc->hi, &r);
    if (c && model->just_converted) pdi_monitor_compute_extremes(model, m->desc, &r);
    pdi_monitor_add_output(m, "volume", pdi_monitor_unit_volume[pdi_monitor_get_unit_index(u)], r.volume);
    if (u->has_flow) {
        pdi_monitor_add_output(m, "energy", pdi_monitor_unit_energy[pdi_monitor_get_unit_index(u)], r.energy);
        pdi_monitor_add_vector_output(m, 'm', "", pdi_monitor_unit_momentum[pdi_monitor_get_unit_index(u)], r.momentum,
                                      1.0);
    }
    if (c) {
        pdi_monitor_add_output(m, "dissolved", pdi_monitor_unit_amount[pdi_monitor_get_unit_index(u)], r.dissolved);
        pdi_monitor_add_output(m, "C_min", "mol/m3", r.min_concentration);
        pdi_monitor_add_output(m, "C_max", "mol/m3", r.max_concentration);
    }
    if (u->has_dissolve)
        pdi_monitor_add_output(m, "solid", pdi_monitor_unit_amount[pdi_monitor_get_unit_index(u)], r.solid);
    if (u->has_chemistry) pdi_monitor_compute_species(ctx, model, m);
}

/* Append the largest norm of the displacement, the largest overlap of crack faces or components now (where it is
 * checked), and, where the material has stresses, the largest von Mises stress, the largest hydrostatic stress (signed,
 * tension positive) and with plasticity the largest plastic strain. Points without metal left do not count; without
 * points all are 0. */
static void pdi_monitor_compute_solid_extremes(const pd_solid_coupling *s, pd_monitor *m)
{
    const double *at = pd_solid_coupling_displacements(s);
    double u = 0.0, mises = 0.0, pressure = -HUGE_VAL, slip = 0.0;
    for (int32_t i = 0; i < s->count; i++) {
        double square = 0.0;
        if (!(s->stiffness_factor[i] > 0.0)) continue;
        for (int d = 0; d < PD_DIM; d++) square += at[(int64_t)i * PD_DIM + d] * at[(int64_t)i * PD_DIM + d];
        u = pd_max(u, sqrt(square));
        mises = pd_max(mises, s->mises[i]);
        pressure = pd_max(pressure, s->pressure[i]);
        if (s->solid.plastic_strain) slip = pd_max(slip, s->plastic_strain[i]);
    }
    pdi_monitor_add_output(m, "u_max", "m", u);
    if (s->overlap.bins)
        pdi_monitor_add_output(m, "overlap", "m", pd_max(s->overlap.crack_overlap, s->overlap.component_overlap));
    if (!s->solid.stress) return;
    pdi_monitor_add_output(m, "mises_max", "Pa", mises);
    pdi_monitor_add_output(m, "sigma_h_max", "Pa", pressure > -HUGE_VAL ? pressure : 0.0);
    if (s->solid.plastic_strain) pdi_monitor_add_output(m, "eps_p_max", "-", slip);
}

/* Append the energies of a body in motion: work, kinetic, elastic. Energy released by broken bonds and their number
 * follow only where a critical stretch is given. */
static void pdi_monitor_compute_dynamic_energies(pd_ctx *ctx, const pd_solid_coupling *s, pd_monitor *m)
{
    const char *unit = pdi_monitor_unit_energy[PD_DIM - 1];
    pdi_monitor_add_output(m, "work", unit, s->dynamic_solver.work);
    pdi_monitor_add_output(m, "kinetic", unit, pd_verlet_kinetic(&s->dynamic_solver));
    pdi_monitor_add_output(m, "stored", unit, s->solid.energy(ctx, s->solid.self, s->dynamic_solver.u));
    if (!(s->bond_based.critical > 0.0)) return;
    pdi_monitor_add_output(m, "released", unit, s->bond_based.released);
    pdi_monitor_add_output(m, "broken", "-", (double)s->dynamic_solver.broken);
}

/* Append the outputs of the mechanics of the metal: extremes, then energies. A body in motion has those of the time
 * integration and no more. In quasi-static equilibrium: work, elastic, plastic where the material dissipates, "taken"
 * by dissolution where metal dissolves; released energy, broken bonds and the load factor of the next break with a
 * failure criterion; time of separation [s], number of components, iterations. */
static void pdi_monitor_compute_solid(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_solid_coupling *s = &model->solid;
    const pd_quasi_static *q = &s->static_solver;
    const char *unit = pdi_monitor_unit_energy[PD_DIM - 1];
    pdi_monitor_compute_solid_extremes(s, m);
    if (pd_solid_coupling_is_dynamic(s)) {
        pdi_monitor_compute_dynamic_energies(ctx, s, m);
        return;
    }
    pdi_monitor_add_output(m, "work", unit, q->work);
    pdi_monitor_add_output(m, "stored", unit, q->stored);
    if (q->solid.dissipated) pdi_monitor_add_output(m, "flow", unit, q->solid.dissipated(q->solid.self));
    if (q->criterion.critical > 0.0) pdi_monitor_add_output(m, "released", unit, q->released);
    if (s->dissolve) pdi_monitor_add_output(m, "taken", unit, q->dissolved_energy);
    if (q->criterion.critical > 0.0) {
        pd_first_failure first;
        pd_bond_failure_find_first(ctx, &model->solid.static_solver.criterion, q->u, &first);
        pdi_monitor_add_output(m, "broken", "-", (double)q->broken);
        pdi_monitor_add_output(m, "next_break", "-", first.factor);
    }
    pdi_monitor_add_output(m, "parted", "s", q->separation_time);
    pdi_monitor_add_output(m, "parts", "-", (double)q->components);
    pdi_monitor_add_output(m, "iterations", "-", (double)q->iterations);
}

/* Append the tip position, in 2D the crack length (length of the cut plus the signed advance of the tip along
 * `direction` beyond the last corner), and J on the inner and outer contour where they are asked for. J is NaN where
 * pd_crack_j gives PD_ERR_GEOMETRY or no result; its other errors, and those of the search for the tip, are
 * returned. */
static pd_status pdi_monitor_compute_crack(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup_precrack *cut = &model->setup->metal_body.precrack[m->desc->index];
    const pd_solid_coupling *s = &model->solid;
    const double *last = cut->corner + (cut->corners - 1) * PD_DIM;
    double length = 0.0, along = 0.0, size = 0.0;
    pd_crack_desc desc;
    memset(&desc, 0, sizeof desc);
    memcpy(desc.tip, last, sizeof desc.tip);
    memcpy(desc.direction, cut->direction, sizeof desc.direction);
    pd_status status =
        pd_crack_find_tip(ctx, &s->body, cut->corners, cut->corner, s->stiffness_factor, cut->direction, desc.tip);
    if (status < 0) return status;
    for (int k = 1; k < cut->corners && PD_DIM == 2; k++) {
        double square = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            double step = cut->corner[k * PD_DIM + d] - cut->corner[(k - 1) * PD_DIM + d];
            square += step * step;
        }
        length += sqrt(square);
    }
    for (int d = 0; d < PD_DIM; d++) {
        along += cut->direction[d] * (desc.tip[d] - last[d]);
        size += cut->direction[d] * cut->direction[d];
    }
    for (int d = 0; d < PD_DIM; d++) {
        char key[] = {"xyz"[d], '\0'};
        pdi_monitor_add_output(m, key, "m", desc.tip[d]);
    }
    if (PD_DIM == 2) pdi_monitor_add_output(m, "length", "m", length + along / sqrt(size));
    for (int k = 0; k < cut->j_domains; k++) {
        double j = 0.0;
        desc.inner = cut->radius[k];
        desc.outer = cut->radius[k + 1];
        status = pd_crack_j(ctx, &s->solid, &desc, pd_solid_coupling_displacements(s), &j);
        if (status < 0 && status != PD_ERR_GEOMETRY) return status;
        pdi_monitor_add_output(m, k ? "J_outer" : "J_inner", "J/m2", status == PD_OK ? j : (double)NAN);
    }
    return PD_OK;
}

/* Charge number of the metal of an electrode on a single metal whose rate law depends on the current density alone and
 * follows Faraday's law at 1 A/m2 within 1e-9. 0: any other electrode, no dissolution, or migrating ions. */
static double pdi_monitor_find_charge_number(const pd_model *model, int electrode)
{
    const pd_setup *u = model->setup;
    uint32_t kinds = model->cell.kinds[electrode];
    double vars[PD_EXPR_VARS];
    if (!u->has_dissolve || u->has_migration) return 0.0;
    for (int k = 0; k < u->metals; k++) {
        const pd_setup_metal *metal = &u->metal[k];
        if (kinds != (uint32_t)1 << k || metal->rate.variables_used != (uint32_t)1 << PD_SETUP_RATE_CURRENT) continue;
        memset(vars, 0, sizeof vars);
        vars[PD_SETUP_RATE_CURRENT] = 1.0;
        double speed = metal->rate_scale * pd_expr_eval(&metal->rate, vars);
        if (fabs(speed / pd_material_speed(&metal->material, 1.0) - 1.0) < PDI_MONITOR_TOLERANCE)
            return metal->material.charge;
    }
    return 0.0;
}

PDI_FN void pdi_monitor_get_electrode(const pd_model *model, int electrode, pd_cell_electrode *e)
{
    if (model->dissolution_laws.species_electrodes.setup)
        pd_species_electrodes_get_electrode(&model->dissolution_laws.species_electrodes, electrode, e);
    else pd_cell_electrode_of(&model->cell, electrode, e);
}

/* Append potential, net and anodic current, area, mean (0 without area), least and largest current density, and charge
 * since the start. With a tabulated curve: range of E - phi met so far and time [s] at which it first left the table,
 * NaN if not. "faraday", lost metal over that of the charge passed by Faraday's law, only where that law must hold; NaN
 * while the charge passed is at most 1e-9 of that of the whole metal. */
static void pdi_monitor_compute_electrode(const pd_model *model, pd_monitor *m)
{
    const char *unit = pdi_monitor_unit_current[pdi_monitor_get_unit_index(model->setup)];
    pd_cell_electrode e;
    pdi_monitor_get_electrode(model, m->desc->index, &e);
    pdi_monitor_add_output(m, "E", "V", e.potential);
    pdi_monitor_add_output(m, "current", unit, e.current);
    pdi_monitor_add_output(m, "anodic", unit, e.anodic);
    pdi_monitor_add_output(m, "area", pdi_monitor_unit_area[pdi_monitor_get_unit_index(model->setup)], e.area);
    pdi_monitor_add_output(m, "density", "A/m2", e.area > 0.0 ? e.current / e.area : 0.0);
    pdi_monitor_add_output(m, "least", "A/m2", e.least);
    pdi_monitor_add_output(m, "most", "A/m2", e.most);
    if (pd_cell_table(&model->cell, m->desc->index)) {
        int some = e.met.least <= e.met.most;
        pdi_monitor_add_output(m, "E_least", "V", some ? e.met.least : (double)NAN);
        pdi_monitor_add_output(m, "E_most", "V", some ? e.met.most : (double)NAN);
        pdi_monitor_add_output(m, "range_left", "s", e.met.left < HUGE_VAL ? e.met.left : (double)NAN);
    }
    pdi_monitor_add_output(m, "charge", pdi_monitor_unit_charge[pdi_monitor_get_unit_index(model->setup)], e.charge);
    double charge = pdi_monitor_find_charge_number(model, m->desc->index);
    if (!(charge > 0.0)) return;
    charge *= PD_FARADAY;
    int known = e.passed > PDI_MONITOR_TOLERANCE * charge * model->cell.stock[m->desc->index]; /* less is rounding */
    pdi_monitor_add_output(m, "faraday", "-", known ? charge * e.lost / e.passed : (double)NAN);
}

/* Append mean, smallest and largest value of a surface state, in its unit or "-", and the area that carries it. */
static void pdi_monitor_compute_surface_state(const pd_model *model, pd_monitor *m)
{
    const char *unit = model->setup->state[m->desc->index].unit;
    pd_surface_state_statistics f;
    pd_surface_states_compute_statistics(model->surface_states, m->desc->index, &f);
    if (!unit[0]) unit = "-";
    pdi_monitor_add_output(m, "mean", unit, f.mean);
    pdi_monitor_add_output(m, "least", unit, f.min);
    pdi_monitor_add_output(m, "most", unit, f.max);
    pdi_monitor_add_output(m, "area", pdi_monitor_unit_area[pdi_monitor_get_unit_index(model->setup)], f.area);
}

/* Replace the outputs of a monitor by those of now. A line has none; a force keeps its outputs until the next flow
 * solve; a mechanical boundary condition has its reaction force by axes. Errors of force, crack and reaction force; the
 * outputs are incomplete then. */
static pd_status pdi_monitor_compute_outputs(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    if (m->desc->kind == PD_MONITOR_FORCE) return pdi_monitor_compute_force(ctx, model, m);
    m->count = 0;
    if (m->desc->kind == PD_MONITOR_PLANE) pdi_monitor_compute_plane(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_TRANSFER) pdi_monitor_compute_mass_transfer(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_TOTAL) pdi_monitor_compute_total(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_SOLID) pdi_monitor_compute_solid(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_ELECTRODE) pdi_monitor_compute_electrode(model, m);
    if (m->desc->kind == PD_MONITOR_SURFACE_STATE) pdi_monitor_compute_surface_state(model, m);
    if (m->desc->kind == PD_MONITOR_PRECRACK) return pdi_monitor_compute_crack(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_MECHANICAL_BC) {
        double force[PD_DIM];
        PD_TRY(pd_reaction_force_compute(ctx, &model->mechanical_bc, m->desc->index, model->time_loop.time, force));
        pdi_monitor_add_vector_output(m, 'f', "", pdi_monitor_unit_force[PD_DIM - 1], force, 1.0);
    }
    return PD_OK;
}

/* ---- profiles ---- */

/* Copy the name of a column into names[column]; returns the next column. */
static int pdi_monitor_set_column_name(char names[][PD_SETUP_NAME], int column, const char *name)
{
    snprintf(names[column], PD_SETUP_NAME, "%s", name);
    return column + 1;
}

/* Names of the columns of a line: arc length, position, the requested fields (v by components), with units, "-" for
 * none. first[PD_FIELD_COUNT]: column of each field; of one that is not requested, of the next one. Returns the number
 * of columns. */
static int pdi_monitor_name_line_columns(const pd_setup *setup, const pd_monitor *m, char names[][PD_SETUP_NAME],
                                         int *first)
{
    char name[PD_SETUP_NAME];
    int count = pdi_monitor_set_column_name(names, 0, "s [m]");
    for (int d = 0; d < PD_DIM; d++) {
        snprintf(name, sizeof name, "%c [m]", "xyz"[d]);
        count = pdi_monitor_set_column_name(names, count, name);
    }
    for (int f = 0; f < PD_FIELD_COUNT; f++) {
        first[f] = count;
        if (!((m->desc->fields >> f) & 1u)) continue;
        for (int d = 0; d < pd_fields_count_components((pd_field)f); d++) {
            char unit[PD_UNITS_TEXT];
            pd_fields_get_unit(setup, (pd_field)f, unit);
            snprintf(name, sizeof name, "%.36s%s [%.22s]", pd_fields_get_name(setup, (pd_field)f),
                     pd_fields_get_axis((pd_field)f, d), unit[0] ? unit : "-");
            count = pdi_monitor_set_column_name(names, count, name);
        }
    }
    return count;
}

/* Names of the columns of the profile of a mass transfer: position, area, flux density, and with a reference length
 * C_fluid and Sh. Returns their number, 3 or 5. */
static int pdi_monitor_name_transfer_columns(const pd_setup *setup, const pd_monitor *m, char names[][PD_SETUP_NAME])
{
    char name[PD_SETUP_NAME];
    int count;
    snprintf(name, sizeof name, "%c [m]", "xyz"[m->desc->axis]);
    count = pdi_monitor_set_column_name(names, 0, name);
    snprintf(name, sizeof name, "area [%s]", pdi_monitor_unit_area[pdi_monitor_get_unit_index(setup)]);
    count = pdi_monitor_set_column_name(names, count, name);
    count = pdi_monitor_set_column_name(names, count, "density [mol/m2/s]");
    if (!(m->desc->length > 0.0)) return count;
    count = pdi_monitor_set_column_name(names, count, "C_fluid [mol/m3]");
    return pdi_monitor_set_column_name(names, count, "Sh [-]");
}

/* Sample the requested fields at m->rows points (2 or more), evenly spaced from d->lo to d->hi with both ends, into
 * profile[rows][columns]: arc length from lo, position, fields by components, NaN where a field has no value. Call
 * pd_sample_prepare before. */
static void pdi_monitor_compute_line(const pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    for (int k = 0; k < m->rows; k++) {
        double *row = m->profile + (int64_t)k * m->columns, *x = row + 1, share = k / (m->rows - 1.0), square = 0.0;
        int column = 1 + PD_DIM;
        for (int a = 0; a < PD_DIM; a++) {
            x[a] = (1.0 - share) * d->lo[a] + share * d->hi[a];
            square += (x[a] - d->lo[a]) * (x[a] - d->lo[a]);
        }
        row[0] = sqrt(square);
        for (int f = 0; f < PD_FIELD_COUNT; f++)
            for (int c = 0; c < pd_fields_count_components((pd_field)f) && ((d->fields >> f) & 1u); c++)
                row[column++] = pd_sample_get_point(model, (pd_field)f, c, x);
    }
}

/* Fill profile[rows][columns] of a mass transfer from m->flux, m->area and m->fluid: cell centre along the axis, area,
 * flux density (NaN without area); with a reference length also C_fluid and the local Sherwood number with the
 * difference C_surface - C_fluid of the layer. */
static void pdi_monitor_compute_transfer_profile(const pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    for (int k = 0; k < m->rows; k++) {
        double *row = m->profile + (int64_t)k * m->columns;
        row[0] = model->grid.lo[d->axis] + (k + 0.5) * model->grid.h[d->axis];
        row[1] = m->area[k];
        row[2] = m->area[k] > 0.0 ? m->flux[k] / m->area[k] : (double)NAN;
        if (!(d->length > 0.0)) continue;
        row[3] = m->fluid[k];
        row[4] = row[2] * d->length / ((d->surface_c - m->fluid[k]) * d->diffusivity);
    }
}

/* Plot `count` columns of the profile from `first` on over column 0, drawn in um if its last value is below 2 mm, in mm
 * below 2 m, else in m. axis: name of column 0; label: of the values. Series are named x, y, z if there are several.
 * PD_OK and no file where no value is finite. */
static pd_status pdi_monitor_draw_profile(pd_ctx *ctx, const pd_monitors *all, const pd_monitor *m, int first,
                                          int count, const char *axis, const char *label, const char *path)
{
    char title[PD_SETUP_NAME + 2 * PD_UNITS_TEXT], stamp[PD_UNITS_TEXT], x_label[16];
    static const char *const names[] = {"x", "y", "z"};
    double *work = NULL, last = m->profile[(int64_t)(m->rows - 1) * m->columns];
    double unit = last < 2e-3 ? 1e6 : last < 2.0 ? 1e3 : 1.0;
    int64_t size = (int64_t)(count + 1) * m->rows, shown = 0;
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    PD_TRY(PD_NEW(ctx, "monitor", size, work));
    for (int k = 0; k < m->rows; k++) {
        const double *row = m->profile + (int64_t)k * m->columns;
        work[k] = unit * row[0];
        for (int c = 0; c < count; c++) {
            work[(int64_t)(c + 1) * m->rows + k] = row[first + c];
            shown += fabs(row[first + c]) < HUGE_VAL;
        }
    }
    pd_setup_format_value(all->model->time_loop.time, "s", stamp);
    snprintf(title, sizeof title, "%.60s: %.40s, t = %s", all->model->setup->name, m->desc->name, stamp);
    snprintf(x_label, sizeof x_label, "%s [%s]", axis, unit > 1e4 ? "um" : unit > 10.0 ? "mm" : "m");
    plot.title = title;
    plot.x_label = x_label;
    plot.y_label = label;
    plot.count = count;
    for (int c = 0; c < count; c++) {
        plot.series[c].name = count > 1 ? names[c] : NULL;
        plot.series[c].x = work;
        plot.series[c].y = work + (int64_t)(c + 1) * m->rows;
        plot.series[c].count = m->rows;
    }
    pd_status status = shown ? pd_plot_write(ctx, path, &plot) : PD_OK;
    PD_DELETE(ctx, size, work);
    return status;
}

/* ---- files ---- */

/* Path "FOLDER/line_NAME_C_000012_t6.1s.png" into path[PD_PATH_SIZE], added to the list of the folder; field "":
 * without it. */
static pd_status pdi_monitor_format_path(pd_ctx *ctx, const pd_monitors *all, const pd_monitor *m, const char *field,
                                         int frame, const char *extension, char *path)
{
    char prefix[2 * PD_SETUP_NAME], name[PD_PATH_SIZE];
    snprintf(prefix, sizeof prefix, "%s_%s%s%s", pd_setup_monitor_section_name(m->desc->kind), m->desc->name,
             field[0] ? "_" : "", field);
    PD_TRY(pdi_file_format_frame_name(ctx, prefix, frame, all->model->time_loop.time, extension, name));
    return pdi_output_folder_add_file(ctx, all->folder, name, path);
}

/* Plot each field of m->desc->images over a line, one file a field. first[f]: column of field f. */
static pd_status pdi_monitor_draw_line(pd_ctx *ctx, const pd_monitors *all, const pd_monitor *m, const int *first,
                                       int frame)
{
    char path[PD_PATH_SIZE];
    for (int f = 0; f < PD_FIELD_COUNT; f++) {
        if (!((m->desc->images >> f) & 1u)) continue;
        const char *name = pd_fields_get_name(all->model->setup, (pd_field)f);
        PD_TRY(pdi_monitor_format_path(ctx, all, m, name, frame, "png", path));
        PD_TRY(pdi_monitor_draw_profile(ctx, all, m, first[f], pd_fields_count_components((pd_field)f), "s",
                                        pd_fields_get_label(all->model->setup, (pd_field)f), path));
    }
    return PD_OK;
}

/* Fill the profile of a line or mass transfer, write it as a table, and plot it: each image field of a line; of a
 * transfer Sh with a reference length, else the flux density. A line samples the fields now; a transfer uses m->flux,
 * m->area and m->fluid of the last step. */
static pd_status pdi_monitor_write_profile(pd_ctx *ctx, const pd_monitors *all, pd_monitor *m, int frame)
{
    char names[1 + PD_DIM + PD_FIELD_COUNT + PD_DIM][PD_SETUP_NAME], path[PD_PATH_SIZE];
    const char *list[1 + PD_DIM + PD_FIELD_COUNT + PD_DIM];
    const pd_setup_monitor *d = m->desc;
    int first[PD_FIELD_COUNT], line = d->kind == PD_MONITOR_LINE;
    const pd_setup *u = all->model->setup;
    int count =
        line ? pdi_monitor_name_line_columns(u, m, names, first) : pdi_monitor_name_transfer_columns(u, m, names);
    for (int k = 0; k < count; k++) list[k] = names[k];
    if (line) pd_sample_prepare(ctx, all->model, d->fields);
    if (line) pdi_monitor_compute_line(all->model, m);
    else pdi_monitor_compute_transfer_profile(all->model, m);
    PD_TRY(pdi_monitor_format_path(ctx, all, m, "", frame, "csv", path));
    PD_TRY(pdi_csv_write_table(ctx, path, list, count, m->profile, m->rows));
    if (line) return pdi_monitor_draw_line(ctx, all, m, first, frame);
    int sherwood = d->length > 0.0;
    PD_TRY(pdi_monitor_format_path(ctx, all, m, sherwood ? "Sh" : "density", frame, "png", path));
    return pdi_monitor_draw_profile(ctx, all, m, sherwood ? 4 : 2, 1,
                                    d->axis == 0   ? "x"
                                    : d->axis == 1 ? "y"
                                                   : "z",
                                    sherwood ? "Sh [-]" : "density [mol/m2/s]", path);
}

/* File name of the table, such as "plane_up.csv". */
static void pdi_monitor_format_table_name(const pd_monitor *m, char name[2 * PD_SETUP_NAME])
{
    snprintf(name, 2 * PD_SETUP_NAME, "%s_%s.csv", pd_setup_monitor_section_name(m->desc->kind), m->desc->name);
}

/* Enter the table of a monitor in the list of the folder, create it with the column time and one for each present
 * output, and open it. Errors of pd_csv_create. */
static pd_status pdi_monitor_begin_table(pd_ctx *ctx, const pd_monitors *all, pd_monitor *m)
{
    char names[PD_MONITOR_MAX_OUTPUTS + 1][64], name[2 * PD_SETUP_NAME], path[PD_PATH_SIZE];
    const char *list[PD_MONITOR_MAX_OUTPUTS + 1];
    snprintf(names[0], sizeof names[0], "time [s]");
    for (int k = 0; k < m->count; k++)
        snprintf(names[k + 1], sizeof names[0], "%s [%s]", m->output[k].key, m->output[k].unit);
    for (int k = 0; k <= m->count; k++) list[k] = names[k];
    pdi_monitor_format_table_name(m, name);
    PD_TRY(pdi_output_folder_add_file(ctx, all->folder, name, path));
    return pd_csv_create(ctx, path, list, m->count + 1, &m->table);
}

/* ---- life ---- */

/* Allocate m->output (more with chemistry), and for a line or transfer the profile; set rows and columns. A transfer
 * also gets its layers: one for each cell along its axis, or one without an axis. rows is 0 for all other kinds. On
 * failure the caller frees. */
static pd_status pdi_monitor_allocate(pd_ctx *ctx, const pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    m->capacity = model->setup->has_chemistry ? PD_MONITOR_MAX_OUTPUTS : PD_MONITOR_MAX_OUTPUTS_NO_SPECIES;
    PD_TRY(PD_NEW(ctx, "monitor", m->capacity, m->output));
    m->rows = d->kind == PD_MONITOR_LINE ? d->points : 0;
    m->columns = 1 + PD_DIM;
    for (int f = 0; f < PD_FIELD_COUNT; f++)
        if ((d->fields >> f) & 1u) m->columns += pd_fields_count_components((pd_field)f);
    if (d->kind == PD_MONITOR_TRANSFER) {
        m->rows = d->axis < 0 ? 1 : model->grid.n[d->axis];
        m->columns = d->length > 0.0 ? 5 : 3;
        PD_TRY(PD_NEW(ctx, "monitor", m->rows, m->flux));
        PD_TRY(PD_NEW(ctx, "monitor", m->rows, m->area));
        PD_TRY(PD_NEW(ctx, "monitor", m->rows, m->fluid));
    }
    return m->rows ? PD_NEW(ctx, "monitor", (int64_t)m->rows * m->columns, m->profile) : PD_OK;
}

/* Set the message for a probe within a wall; with its depth where the distance to the wall shape is known (smooth
 * shapes). Returns PD_ERR_GEOMETRY. */
static pd_status pdi_monitor_reject_probe(pd_ctx *ctx, const pd_model *model, const pd_setup_probe *probe)
{
    const pd_setup *u = model->setup;
    char deep[PD_UNITS_TEXT];
    if (u->wall < 0 || !pd_shape_is_smooth(u->shape, u->wall))
        return pd_fail(ctx, PD_ERR_GEOMETRY, "probe",
                       "'%s' stands in the wall, expected a place in the fluid or metal, or on a surface: move it",
                       probe->name);
    pd_setup_format_value(fabs(pd_shape_distance(u->shape, u->wall, probe->position)), "m", deep);
    return pd_fail(ctx, PD_ERR_GEOMETRY, "probe",
                   "'%s' stands in the wall, %s behind its surface, expected a place in the fluid or metal, or on a "
                   "surface: move it by that much", probe->name, deep);
}

/* Zero all, refuse probes deep in a wall (PD_ERR_GEOMETRY), then allocate each monitor and compute its outputs once, so
 * that they can be refused before the run. Forces are due again at the first step. all->error_line is the line of the
 * section in work; the caller frees on failure. */
static pd_status pdi_monitor_build_inner(pd_ctx *ctx, pd_model *model, pd_monitors *all)
{
    const pd_setup *u = model->setup;
    memset(all, 0, sizeof *all);
    all->model = model;
    for (int k = 0; k < u->probes; k++) {
        all->error_line = u->probe[k].line;
        if (!pd_sample_is_inside(model, u->probe[k].position))
            return pdi_monitor_reject_probe(ctx, model, &u->probe[k]);
    }
    for (int k = 0; k < u->monitors; k++) {
        pd_monitor *m = &all->monitor[k];
        m->desc = &u->monitor[k];
        m->flow_solves = -1;
        all->error_line = m->desc->line;
        PD_TRY(pdi_monitor_allocate(ctx, model, m));
        PD_TRY(pdi_monitor_compute_outputs(ctx, model, m));
        m->flow_solves = -1;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_build(pd_ctx *ctx, pd_model *model, pd_monitors *all)
{
    pd_status status = pdi_monitor_build_inner(ctx, model, all);
    int line = all->error_line;
    if (status < 0) pdi_monitors_free(ctx, all);
    all->error_line = line;
    return status;
}

PDI_FN pd_status pdi_monitors_save(pd_ctx *ctx, pd_monitors *all, pd_archive *archive)
{
    for (int k = 0; k < all->model->setup->monitors; k++)
        if (all->monitor[k].count) PD_TRY(pdi_csv_store(ctx, archive, NULL, 0, &all->monitor[k].table));
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_resume(pd_ctx *ctx, pd_monitors *all, pd_output_folder *folder, pd_archive *archive)
{
    char name[2 * PD_SETUP_NAME], path[PD_PATH_SIZE];
    all->folder = folder;
    for (int k = 0; k < all->model->setup->monitors; k++) {
        pd_monitor *m = &all->monitor[k];
        if (m->count == 0) continue;
        pdi_monitor_format_table_name(m, name);
        PD_TRY(pd_file_join(ctx, folder->path, name, path));
        PD_TRY(pdi_csv_store(ctx, archive, path, m->count + 1, &m->table));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_open(pd_ctx *ctx, pd_monitors *all, pd_output_folder *folder)
{
    all->folder = folder;
    for (int k = 0; k < all->model->setup->monitors; k++)
        if (all->monitor[k].count) PD_TRY(pdi_monitor_begin_table(ctx, all, &all->monitor[k]));
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_step(pd_ctx *ctx, pd_monitors *all)
{
    double row[PD_MONITOR_MAX_OUTPUTS + 1];
    int count = all->model->setup->monitors;
    if (count == 0) return PD_OK;
    pd_sample_prepare(ctx, all->model, 0);
    /* sources belong to a step: before the first one they are those that it starts with */
    if (all->model->setup->has_dissolve && all->model->time_loop.steps == 0)
        PD_TRY(pd_dissolve_prepare(ctx, &all->model->dissolve));
    for (int k = 0; k < count; k++) {
        pd_monitor *m = &all->monitor[k];
        PD_TRY(pdi_monitor_compute_outputs(ctx, all->model, m));
        if (m->count == 0 || !m->table.file.stream) continue;
        row[0] = all->model->time_loop.time;
        for (int f = 0; f < m->count; f++) row[f + 1] = m->output[f].value;
        PD_TRY(pd_csv_write_row(ctx, &m->table, row));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_write_frame(pd_ctx *ctx, pd_monitors *all, int frame)
{
    for (int k = 0; k < all->model->setup->monitors; k++) {
        pd_monitor *m = &all->monitor[k];
        if (m->rows > 1) PD_TRY(pdi_monitor_write_profile(ctx, all, m, frame));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_close(pd_ctx *ctx, pd_monitors *all)
{
    for (int k = 0; k < all->model->setup->monitors; k++) PD_TRY(pd_csv_close(ctx, &all->monitor[k].table));
    return PD_OK;
}

PDI_FN void pdi_monitors_free(pd_ctx *ctx, pd_monitors *all)
{
    pd_ctx quiet = *ctx; /* a failure to close must not hide an earlier message */
    for (int k = 0; k < PD_SETUP_MONITORS; k++) {
        pd_monitor *m = &all->monitor[k];
        pd_csv_close(&quiet, &m->table);
        PD_DELETE(ctx, m->capacity, m->output);
        PD_DELETE(ctx, (int64_t)m->rows * m->columns, m->profile);
        PD_DELETE(ctx, m->rows, m->flux);
        PD_DELETE(ctx, m->rows, m->area);
        PD_DELETE(ctx, m->rows, m->fluid);
    }
    memset(all, 0, sizeof *all);
}

#undef PDI_MONITOR_TOLERANCE
