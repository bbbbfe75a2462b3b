/* monitor_outputs: see monitor_outputs.h */
#include "run/monitor_outputs.h"
#include "flow/force.h"
#include "core/vec.h"
#include "couple/integral_diagnostics.h"
#include "solid/crack.h"
#include "physics/reaction_force.h"
#include "physics/sample.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Relative tolerance by which two numbers count as equal. */
#define PDI_MONITOR_OUTPUTS_TOLERANCE 1e-9

/* Units of amounts per depth, by dimension. */
static const char *const pdi_monitor_outputs_unit_area[] = {"-", "m", "m2"};
static const char *const pdi_monitor_outputs_unit_volume[] = {"m", "m2", "m3"};
static const char *const pdi_monitor_outputs_unit_flow[] = {"m/s", "m2/s", "m3/s"};
static const char *const pdi_monitor_outputs_unit_amount[] = {"mol/m2", "mol/m", "mol"};
static const char *const pdi_monitor_outputs_unit_species[] = {"mol/m2/s", "mol/m/s", "mol/s"};
static const char *const pdi_monitor_outputs_unit_force[] = {"N/m2", "N/m", "N"};
static const char *const pdi_monitor_outputs_unit_current[] = {"A/m2", "A/m", "A"};
static const char *const pdi_monitor_outputs_unit_charge[] = {"C/m2", "C/m", "C"};
static const char *const pdi_monitor_outputs_unit_energy[] = {"J/m2", "J/m", "J"};
static const char *const pdi_monitor_outputs_unit_momentum[] = {"kg/m/s", "kg/s", "kg m/s"};

/* Index into the tables of units: PD_DIM - 1, or 2 with axisymmetry, where amounts are over the whole circumference. */
static int pdi_monitor_outputs_get_unit_index(const pd_setup *setup) { return setup->axisymmetric ? 2 : PD_DIM - 1; }

PDI_FN const char *pdi_monitor_outputs_get_area_unit(const pd_setup *setup)
{
    return pdi_monitor_outputs_unit_area[pdi_monitor_outputs_get_unit_index(setup)];
}

/* Append an output to m->output and count it. Key and unit are copied and cut to their arrays. The array does not grow:
 * the count must be below m->capacity. */
static void pdi_monitor_outputs_add_output(pd_monitor *m, const char *key, const char *unit, double value)
{
    pd_monitor_output *f = &m->output[m->count++];
    PD_ASSERT(m->count <= m->capacity);
    snprintf(f->key, sizeof f->key, "%s", key);
    snprintf(f->unit, sizeof f->unit, "%s", unit);
    f->value = value;
}

/* Append PD_DIM outputs, scale times value[d]. The key of axis d is letter, x, y or z, then rest: "fx_friction". */
static void pdi_monitor_outputs_add_vector_output(pd_monitor *m, char letter, const char *rest, const char *unit,
                                                  const double *value, double scale)
{
    char key[24];
    for (int d = 0; d < PD_DIM; d++) {
        snprintf(key, sizeof key, "%c%c%s", letter, "xyz"[d], rest);
        pdi_monitor_outputs_add_output(m, key, unit, scale * value[d]);
    }
}

/* Append the outputs of a plane: area; with flow, volume flow, mean speed and mean pressure; with transport, mean
 * concentration and species flux; with both, C_bulk, the mean weighted by the flow. Flows are signed, positive towards
 * +, and over the whole plane (per m in planar 2D, per m2 in 1D). Means are NaN where no face lies between two fluid
 * cells, C_bulk also at rest. */
static void pdi_monitor_outputs_compute_plane(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup *u = model->setup;
    pd_diagnostics_plane_result r;
    pd_diagnostics_plane(ctx, &model->bonds, u->has_flow ? &model->flow : NULL,
                         u->has_transport ? &model->transport : NULL, m->desc->axis, m->desc->index, &r);
    pdi_monitor_outputs_add_output(m, "area", pdi_monitor_outputs_get_area_unit(u), r.area);
    if (u->has_flow) {
        pdi_monitor_outputs_add_output(m, "flow", pdi_monitor_outputs_unit_flow[pdi_monitor_outputs_get_unit_index(u)],
                                       r.flow);
        pdi_monitor_outputs_add_output(m, "speed", "m/s", r.speed);
        pdi_monitor_outputs_add_output(m, "p", "Pa", r.pressure);
    }
    if (u->has_transport) pdi_monitor_outputs_add_output(m, "C_mean", "mol/m3", r.mean_concentration);
    if (u->has_transport && u->has_flow) pdi_monitor_outputs_add_output(m, "C_bulk", "mol/m3", r.mixed_concentration);
    if (u->has_transport)
        pdi_monitor_outputs_add_output(
            m, "species", pdi_monitor_outputs_unit_species[pdi_monitor_outputs_get_unit_index(u)], r.species_flux);
}

/* Force [PD_DIM] on what the box d->lo .. d->hi holds, by the momentum balance of steady flow. PD_ERR_GEOMETRY: a
 * closed node or the edge of the lattice lies within two cells of a side; the message is rewritten and names balance =
 * no. Other statuses are returned as they are. */
static pd_status pdi_monitor_outputs_compute_control_volume_force(pd_ctx *ctx, pd_model *model,
                                                                  const pd_setup_monitor *d, double *force)
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
static pd_status pdi_monitor_outputs_compute_force(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    const char *unit = pdi_monitor_outputs_unit_force[pdi_monitor_outputs_get_unit_index(model->setup)];
    double force[PD_DIM], friction[PD_DIM], pressure[PD_DIM], around[PD_DIM];
    double scale = d->speed > 0.0 ? 2.0 / (model->flow.rho * d->speed * d->speed * d->area) : 0.0;
    pd_model_statistics effort;
    pd_model_get_statistics(model, &effort);
    if (m->flow_solves == effort.flow_solves) return PD_OK;
    m->flow_solves = effort.flow_solves;
    m->count = 0;
    pd_force_surface(ctx, &model->flow, d->shape ? d->shape - 1 : PD_FORCE_ALL, d->lo, d->hi, force, friction,
                     pressure);
    pdi_monitor_outputs_add_vector_output(m, 'f', "", unit, force, 1.0);
    pdi_monitor_outputs_add_vector_output(m, 'f', "_friction", unit, friction, 1.0);
    pdi_monitor_outputs_add_vector_output(m, 'f', "_pressure", unit, pressure, 1.0);
    if (d->momentum_balance) PD_TRY(pdi_monitor_outputs_compute_control_volume_force(ctx, model, d, around));
    if (d->momentum_balance) pdi_monitor_outputs_add_vector_output(m, 'f', "_balance", unit, around, 1.0);
    if (d->speed > 0.0) pdi_monitor_outputs_add_vector_output(m, 'c', "", "-", force, scale);
    if (d->speed > 0.0 && d->momentum_balance)
        pdi_monitor_outputs_add_vector_output(m, 'c', "_balance", "-", around, scale);
    return PD_OK;
}

/* Set m->fluid[rows] [mol/m3], the reference concentration of each layer: the given one, or for `bulk` the mixing-cup
 * mean sum u c/sum u over all fluid nodes of the layer, also those outside the box. u is the signed velocity along the
 * axis, times the circumference with axisymmetry. Not finite where sum u is 0. Overwrites m->profile as work. */
static void pdi_monitor_outputs_compute_layer_concentration(const pd_model *model, pd_monitor *m)
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
static void pdi_monitor_outputs_compute_mass_transfer(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    double flux = 0.0, area = 0.0, excess = 0.0;
    pd_diagnostics_surface_flux(ctx, &model->paths, &model->transport,
                                model->setup->has_dissolve ? &model->dissolve : NULL, d->lo, d->hi, d->axis, m->flux,
                                m->area);
    pdi_monitor_outputs_compute_layer_concentration(model, m);
    for (int k = 0; k < m->rows; k++) {
        flux += m->flux[k];
        area += m->area[k];
        if (m->area[k] > 0.0) excess += m->area[k] * (d->surface_c - m->fluid[k]);
    }
    if (d->area > 0.0) {
        excess *= d->area / area;
        area = d->area;
    }
    pdi_monitor_outputs_add_output(
        m, "flux", pdi_monitor_outputs_unit_species[pdi_monitor_outputs_get_unit_index(model->setup)], flux);
    pdi_monitor_outputs_add_output(m, "area", pdi_monitor_outputs_get_area_unit(model->setup), area);
    pdi_monitor_outputs_add_output(m, "density", "mol/m2/s", flux / area);
    if (!(d->length > 0.0)) return;
    pdi_monitor_outputs_add_output(m, "Sh", "-", flux * d->length / (excess * d->diffusivity));
    pdi_monitor_outputs_add_output(m, "layer", "m", excess * d->diffusivity / flux);
}

/* [mol] Integral of a concentration field [mol/m3] over the fluid in the box of the monitor; per m in planar 2D, per m2
 * in 1D. */
static double pdi_monitor_outputs_integrate_concentration(pd_ctx *ctx, pd_model *model, const pd_monitor *m,
                                                          const double *field)
{
    pd_diagnostics_box_result r;
    pd_diagnostics_box(ctx, &model->stencil, &model->grid, NULL, field, NULL, m->desc->lo, m->desc->hi, &r);
    return r.dissolved;
}

/* Add to sum[rows] [mol] of the balance rows what the cells of the box do not show: amounts that the last step left to
 * the next one, and, where it is kept, solution beside the cells where metal has gone. Each amount of a component
 * counts by its part in the row. */
static void pdi_monitor_outputs_add_carried_amounts(pd_ctx *ctx, pd_model *model, const pd_monitor *m, double *sum)
{
    const pd_reactive *reactive = &model->reactive;
    for (int k = 0; k < reactive->components.count; k++) {
        double amount = pdi_monitor_outputs_integrate_concentration(ctx, model, m,
                                                                    reactive->carry + (int64_t)k * model->grid.total);
        if (reactive->swept)
            amount += pdi_monitor_outputs_integrate_concentration(ctx, model, m,
                                                                  reactive->swept + (int64_t)k * model->grid.total);
        for (int row = 0; row < reactive->rows; row++)
            sum[row] += reactive->part[row][reactive->components.component_solute[k]] * amount;
    }
}

/* Append the amount [mol] in the fluid of the box of each species that has a field (no solvent, no solid that is no
 * mineral), then sum_NAME of each balance row, an element or the charge, with the amounts that carry over to the next
 * step. */
static void pdi_monitor_outputs_compute_species(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const char *unit = pdi_monitor_outputs_unit_amount[pdi_monitor_outputs_get_unit_index(model->setup)];
    const pd_electrolyte *e = &model->setup->electrolyte;
    const pd_reactive *reactive = &model->reactive;
    double sum[PD_REACTIVE_ROWS];
    char key[PD_REACTIVE_NAME + 8];
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < e->count; k++) {
        const double *c = pd_reactive_field(&model->reactive, k);
        if (!c) continue;
        double amount = pdi_monitor_outputs_integrate_concentration(ctx, model, m, c);
        pdi_monitor_outputs_add_output(m, e->species[k].name, unit, amount);
        for (int row = 0; row < reactive->rows; row++) sum[row] += pd_reactive_part(reactive, row, k) * amount;
    }
    pdi_monitor_outputs_add_carried_amounts(ctx, model, m, sum);
    for (int row = 0; row < reactive->rows; row++) {
        snprintf(key, sizeof key, "sum_%s", reactive->name[row]);
        pdi_monitor_outputs_add_output(m, key, unit, sum[row]);
    }
}

/* Set the smallest and largest concentration in r from the fluid nodes of the box whose concentration is defined, i.e.
 * without nodes just converted to fluid. Both are NaN if there are none. */
static void pdi_monitor_outputs_compute_extremes(const pd_model *model, const pd_setup_monitor *desc,
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
static void pdi_monitor_outputs_compute_total(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_setup *u = model->setup;
    pd_diagnostics_box_result r;
    const double *c = model->transport.c;
    pd_diagnostics_box(ctx, &model->stencil, &model->grid, u->has_flow ? &model->flow : NULL, c,
                       u->has_dissolve ? c : NULL, m->desc->lo, m->desc->hi, &r);
    if (c && model->just_converted) pdi_monitor_outputs_compute_extremes(model, m->desc, &r);
    pdi_monitor_outputs_add_output(m, "volume", pdi_monitor_outputs_unit_volume[pdi_monitor_outputs_get_unit_index(u)],
                                   r.volume);
    if (u->has_flow) {
        pdi_monitor_outputs_add_output(
            m, "energy", pdi_monitor_outputs_unit_energy[pdi_monitor_outputs_get_unit_index(u)], r.energy);
        pdi_monitor_outputs_add_vector_output(
            m, 'm', "", pdi_monitor_outputs_unit_momentum[pdi_monitor_outputs_get_unit_index(u)], r.momentum, 1.0);
    }
    if (c) {
        pdi_monitor_outputs_add_output(
            m, "dissolved", pdi_monitor_outputs_unit_amount[pdi_monitor_outputs_get_unit_index(u)], r.dissolved);
        pdi_monitor_outputs_add_output(m, "C_min", "mol/m3", r.min_concentration);
        pdi_monitor_outputs_add_output(m, "C_max", "mol/m3", r.max_concentration);
    }
    if (u->has_dissolve)
        pdi_monitor_outputs_add_output(m, "solid",
                                       pdi_monitor_outputs_unit_amount[pdi_monitor_outputs_get_unit_index(u)], r.solid);
    if (u->has_chemistry) pdi_monitor_outputs_compute_species(ctx, model, m);
}

/* Append the largest norm of the displacement, the largest overlap of crack faces or components now (where it is
 * checked), and, where the material has stresses, the largest von Mises stress, the largest hydrostatic stress (signed,
 * tension positive) and with plasticity the largest plastic strain. Points without metal left do not count; without
 * points all are 0. */
static void pdi_monitor_outputs_compute_solid_extremes(const pd_solid_coupling *s, pd_monitor *m)
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
    pdi_monitor_outputs_add_output(m, "u_max", "m", u);
    if (s->overlap.bins)
        pdi_monitor_outputs_add_output(m, "overlap", "m",
                                       pd_max(s->overlap.crack_overlap, s->overlap.component_overlap));
    if (!s->solid.stress) return;
    pdi_monitor_outputs_add_output(m, "mises_max", "Pa", mises);
    pdi_monitor_outputs_add_output(m, "sigma_h_max", "Pa", pressure > -HUGE_VAL ? pressure : 0.0);
    if (s->solid.plastic_strain) pdi_monitor_outputs_add_output(m, "eps_p_max", "-", slip);
}

/* Append the energies of a body in motion: work, kinetic, elastic. Energy released by broken bonds and their number
 * follow only where a critical stretch is given. */
static void pdi_monitor_outputs_compute_dynamic_energies(pd_ctx *ctx, const pd_solid_coupling *s, pd_monitor *m)
{
    const char *unit = pdi_monitor_outputs_unit_energy[PD_DIM - 1];
    pdi_monitor_outputs_add_output(m, "work", unit, s->dynamic_solver.work);
    pdi_monitor_outputs_add_output(m, "kinetic", unit, pd_verlet_kinetic(&s->dynamic_solver));
    pdi_monitor_outputs_add_output(m, "stored", unit, s->solid.energy(ctx, s->solid.self, s->dynamic_solver.u));
    if (!(s->bond_based.critical > 0.0)) return;
    pdi_monitor_outputs_add_output(m, "released", unit, s->bond_based.released);
    pdi_monitor_outputs_add_output(m, "broken", "-", (double)s->dynamic_solver.broken);
}

/* Append the outputs of the mechanics of the metal: extremes, then energies. A body in motion has those of the time
 * integration and no more. In quasi-static equilibrium: work, elastic, plastic where the material dissipates, "taken"
 * by dissolution where metal dissolves; released energy, broken bonds and the load factor of the next break with a
 * failure criterion; time of separation [s], number of components, iterations. */
static void pdi_monitor_outputs_compute_solid(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    const pd_solid_coupling *s = &model->solid;
    const pd_quasi_static *q = &s->static_solver;
    const char *unit = pdi_monitor_outputs_unit_energy[PD_DIM - 1];
    pdi_monitor_outputs_compute_solid_extremes(s, m);
    if (pd_solid_coupling_is_dynamic(s)) {
        pdi_monitor_outputs_compute_dynamic_energies(ctx, s, m);
        return;
    }
    pdi_monitor_outputs_add_output(m, "work", unit, q->work);
    pdi_monitor_outputs_add_output(m, "stored", unit, q->stored);
    if (q->solid.dissipated) pdi_monitor_outputs_add_output(m, "flow", unit, q->solid.dissipated(q->solid.self));
    if (q->criterion.critical > 0.0) pdi_monitor_outputs_add_output(m, "released", unit, q->released);
    if (s->dissolve) pdi_monitor_outputs_add_output(m, "taken", unit, q->dissolved_energy);
    if (q->criterion.critical > 0.0) {
        pd_first_failure first;
        pd_bond_failure_find_first(ctx, &model->solid.static_solver.criterion, q->u, &first);
        pdi_monitor_outputs_add_output(m, "broken", "-", (double)q->broken);
        pdi_monitor_outputs_add_output(m, "next_break", "-", first.factor);
    }
    pdi_monitor_outputs_add_output(m, "parted", "s", q->separation_time);
    pdi_monitor_outputs_add_output(m, "parts", "-", (double)q->components);
    pdi_monitor_outputs_add_output(m, "iterations", "-", (double)q->iterations);
}

/* Append the tip position, in 2D the crack length (length of the cut plus the signed advance of the tip along
 * `direction` beyond the last corner), and J on the inner and outer contour where they are asked for. J is NaN where
 * pd_crack_j gives PD_ERR_GEOMETRY or no result; its other errors, and those of the search for the tip, are
 * returned. */
static pd_status pdi_monitor_outputs_compute_crack(pd_ctx *ctx, pd_model *model, pd_monitor *m)
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
        pdi_monitor_outputs_add_output(m, key, "m", desc.tip[d]);
    }
    if (PD_DIM == 2) pdi_monitor_outputs_add_output(m, "length", "m", length + along / sqrt(size));
    for (int k = 0; k < cut->j_domains; k++) {
        double j = 0.0;
        desc.inner = cut->radius[k];
        desc.outer = cut->radius[k + 1];
        status = pd_crack_j(ctx, &s->solid, &desc, pd_solid_coupling_displacements(s), &j);
        if (status < 0 && status != PD_ERR_GEOMETRY) return status;
        pdi_monitor_outputs_add_output(m, k ? "J_outer" : "J_inner", "J/m2", status == PD_OK ? j : (double)NAN);
    }
    return PD_OK;
}

/* Charge number of the metal of an electrode on a single metal whose rate law depends on the current density alone and
 * follows Faraday's law at 1 A/m2 within 1e-9. 0: any other electrode, no dissolution, or migrating ions. */
static double pdi_monitor_outputs_find_charge_number(const pd_model *model, int electrode)
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
        if (fabs(speed / pd_material_speed(&metal->material, 1.0) - 1.0) < PDI_MONITOR_OUTPUTS_TOLERANCE)
            return metal->material.charge;
    }
    return 0.0;
}

PDI_FN void pdi_monitor_outputs_get_electrode(const pd_model *model, int electrode, pd_cell_electrode *e)
{
    if (model->dissolution_laws.species_electrodes.setup)
        pd_species_electrodes_get_electrode(&model->dissolution_laws.species_electrodes, electrode, e);
    else pd_cell_electrode_of(&model->cell, electrode, e);
}

/* Append potential, net and anodic current, area, mean (0 without area), least and largest current density, and charge
 * since the start. With a tabulated curve: range of E - phi met so far and time [s] at which it first left the table,
 * NaN if not. "faraday", lost metal over that of the charge passed by Faraday's law, only where that law must hold; NaN
 * while the charge passed is at most 1e-9 of that of the whole metal. */
static void pdi_monitor_outputs_compute_electrode(const pd_model *model, pd_monitor *m)
{
    const char *unit = pdi_monitor_outputs_unit_current[pdi_monitor_outputs_get_unit_index(model->setup)];
    pd_cell_electrode e;
    pdi_monitor_outputs_get_electrode(model, m->desc->index, &e);
    pdi_monitor_outputs_add_output(m, "E", "V", e.potential);
    pdi_monitor_outputs_add_output(m, "current", unit, e.current);
    pdi_monitor_outputs_add_output(m, "anodic", unit, e.anodic);
    pdi_monitor_outputs_add_output(m, "area", pdi_monitor_outputs_get_area_unit(model->setup), e.area);
    pdi_monitor_outputs_add_output(m, "density", "A/m2", e.area > 0.0 ? e.current / e.area : 0.0);
    pdi_monitor_outputs_add_output(m, "least", "A/m2", e.least);
    pdi_monitor_outputs_add_output(m, "most", "A/m2", e.most);
    if (pd_cell_table(&model->cell, m->desc->index)) {
        int some = e.met.least <= e.met.most;
        pdi_monitor_outputs_add_output(m, "E_least", "V", some ? e.met.least : (double)NAN);
        pdi_monitor_outputs_add_output(m, "E_most", "V", some ? e.met.most : (double)NAN);
        pdi_monitor_outputs_add_output(m, "range_left", "s", e.met.left < HUGE_VAL ? e.met.left : (double)NAN);
    }
    pdi_monitor_outputs_add_output(
        m, "charge", pdi_monitor_outputs_unit_charge[pdi_monitor_outputs_get_unit_index(model->setup)], e.charge);
    double charge = pdi_monitor_outputs_find_charge_number(model, m->desc->index);
    if (!(charge > 0.0)) return;
    charge *= PD_FARADAY;
    int known =
        e.passed > PDI_MONITOR_OUTPUTS_TOLERANCE * charge * model->cell.stock[m->desc->index]; /* less is rounding */
    pdi_monitor_outputs_add_output(m, "faraday", "-", known ? charge * e.lost / e.passed : (double)NAN);
}

/* Append mean, smallest and largest value of a surface state, in its unit or "-", and the area that carries it. */
static void pdi_monitor_outputs_compute_surface_state(const pd_model *model, pd_monitor *m)
{
    const char *unit = model->setup->state[m->desc->index].unit;
    pd_surface_state_statistics f;
    pd_surface_states_compute_statistics(model->surface_states, m->desc->index, &f);
    if (!unit[0]) unit = "-";
    pdi_monitor_outputs_add_output(m, "mean", unit, f.mean);
    pdi_monitor_outputs_add_output(m, "least", unit, f.min);
    pdi_monitor_outputs_add_output(m, "most", unit, f.max);
    pdi_monitor_outputs_add_output(m, "area", pdi_monitor_outputs_get_area_unit(model->setup), f.area);
}

PDI_FN pd_status pdi_monitor_outputs_compute(pd_ctx *ctx, pd_model *model, pd_monitor *m)
{
    if (m->desc->kind == PD_MONITOR_FORCE) return pdi_monitor_outputs_compute_force(ctx, model, m);
    m->count = 0;
    if (m->desc->kind == PD_MONITOR_PLANE) pdi_monitor_outputs_compute_plane(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_TRANSFER) pdi_monitor_outputs_compute_mass_transfer(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_TOTAL) pdi_monitor_outputs_compute_total(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_SOLID) pdi_monitor_outputs_compute_solid(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_ELECTRODE) pdi_monitor_outputs_compute_electrode(model, m);
    if (m->desc->kind == PD_MONITOR_SURFACE_STATE) pdi_monitor_outputs_compute_surface_state(model, m);
    if (m->desc->kind == PD_MONITOR_PRECRACK) return pdi_monitor_outputs_compute_crack(ctx, model, m);
    if (m->desc->kind == PD_MONITOR_MECHANICAL_BC) {
        double force[PD_DIM];
        PD_TRY(pd_reaction_force_compute(ctx, &model->mechanical_bc, m->desc->index, model->time_loop.time, force));
        pdi_monitor_outputs_add_vector_output(m, 'f', "", pdi_monitor_outputs_unit_force[PD_DIM - 1], force, 1.0);
    }
    return PD_OK;
}

#undef PDI_MONITOR_OUTPUTS_TOLERANCE
