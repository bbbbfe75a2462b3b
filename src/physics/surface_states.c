/* surface_states: see surface_states.h */
#include "physics/surface_states.h"
#include "core/vec.h"
#include "react/layer.h"
#include "react/levels.h"
#include <math.h>
#include <string.h>

/* The metal-fluid contacts that carry states: those of the electrodes, or of all metal. */
static const pd_contacts *pdi_surface_states_get_contacts(const pd_surface_states *s)
{
    return s->cell ? &s->cell->potential.contacts : &s->contacts;
}

/* Bit mask of the states that an electrode carries; without electrodes: all states. */
static uint32_t pdi_surface_states_get_electrode_states(const pd_surface_states *s, int electrode)
{
    uint32_t bits = 0;
    for (int k = 0; k < s->setup->states; k++)
        if (!s->cell || s->setup->state[k].electrodes >> electrode & 1u) bits |= (uint32_t)1 << k;
    return bits;
}

/* Add to on [total] the bits of the states that each fluid node carries. anew: contacts have changed; without
 * electrodes they are found again, with them the potential solver has them already. The `where` callback of
 * pd_coat_desc. */
static pd_status pdi_surface_states_mark_nodes(pd_ctx *ctx, void *user, int anew, uint32_t *on)
{
    pd_surface_states *s = (pd_surface_states *)user;
    if (!s->cell && anew) {
        pdi_contact_metal metal;
        memset(&metal, 0, sizeof metal);
        metal.wide = s->interface_stencil;
        PD_TRY(pdi_contact_find(ctx, s->bonds, &metal, &s->contacts));
    }
    const pd_contacts *c = pdi_surface_states_get_contacts(s);
    for (int32_t k = 0; k < c->count; k++)
        on[c->list[k].node] |= pdi_surface_states_get_electrode_states(s, c->list[k].electrode);
    return PD_OK;
}

/* Initial value of a state at a node, by its expression. The `initial` callback of pd_coat_desc. */
static double pdi_surface_states_get_initial(void *user, int state, int32_t node)
{
    const pd_surface_states *s = (const pd_surface_states *)user;
    double x[PD_DIM];
    pd_grid_position(s->bonds->grid, node, x);
    return pdi_setup_eval_expr(&s->setup->state[state].initial, x, 0.0);
}

/* Current density around[0] [A/m2] and electrode potential around[1] [V] at a node: area-weighted means over its
 * contacts that carry states; 0: it has none. The `around` callback of pd_coat_desc. */
static void pdi_surface_states_average_electrode(void *user, int32_t node, double *around)
{
    const pd_surface_states *s = (const pd_surface_states *)user;
    const pd_potential *p = &s->cell->potential;
    double area = 0.0;
    around[0] = around[1] = 0.0;
    for (int32_t k = s->cell->first[node]; k >= 0 && k < p->contacts.count && p->contacts.list[k].node == node; k++) {
        const pd_contact *c = &p->contacts.list[k];
        if (!pdi_surface_states_get_electrode_states(s, c->electrode)) continue;
        area += c->area;
        around[0] += c->area * p->current[k];
        around[1] += c->area * p->surface[k];
    }
    for (int k = 0; k < 2 && area > 0.0; k++) around[k] /= area;
}

PDI_FN void pdi_surface_states_set_variables(const pd_surface_states *s, int k, const pd_coat_at *at, const double *y,
                                             double *vars)
{
    const pd_setup_surface_state *state = &s->setup->state[k];
    int next = PD_SETUP_RATE_PH + 1;
    memset(vars, 0, PD_EXPR_VARS * sizeof *vars);
    vars[1] = at->time;
    pd_grid_position(s->bonds->grid, at->node, vars + 2);
    vars[PD_SETUP_RATE_CURRENT] = at->around[0];
    vars[PD_SETUP_RATE_POTENTIAL] = at->around[1];
    vars[PD_SETUP_RATE_PH] = at->ph;
    for (int n = 0; n < state->species_count; n++)
        vars[next++] = at->c[s->state_solver.reactive->components.solute_of_species[state->species_index[n]]];
    for (int n = 0; n < s->setup->states; n++) vars[next++] = y[n];
}

/* Rates of all states at a place: rate [states] [unit of each per s] for the states y. The `rate` callback of
 * pd_coat_desc. */
static void pdi_surface_states_compute_rates(void *user, const pd_coat_at *at, const double *y, double *rate)
{
    const pd_surface_states *s = (const pd_surface_states *)user;
    double vars[PD_EXPR_VARS];
    for (int k = 0; k < s->setup->states; k++) {
        pdi_surface_states_set_variables(s, k, at, y, vars);
        rate[k] = pd_expr_eval(&s->setup->state[k].rate, vars);
    }
}

/* Add to flows [components] [mol/m3] the concentration difference between surface and node by what dissolves at the
 * node and, where reactions release species, by currents of its electrodes that carry states: a diffusion film of half
 * a cell. The `film` callback of pd_coat_desc. */
static void pdi_surface_states_add_film_flux(void *user, int32_t node, double *flows)
{
    const pd_surface_states *s = (const pd_surface_states *)user;
    const pd_reactive *r = s->state_solver.reactive;
    int count = r->components.count;
    int32_t place = s->surface_solver ? s->surface_solver->slot[node] : -1;
    if (place >= 0)
        for (int k = 0; k < count; k++)
            flows[k] +=
                s->surface_solver->kind->gain[k] * s->surface_solver->thick[place] * s->surface_solver->speed[node];
    if (!s->has_faradaic_source) return;
    const pd_potential *p = &s->cell->potential;
    for (int32_t n = s->cell->first[node]; n >= 0 && n < p->contacts.count && p->contacts.list[n].node == node; n++) {
        const pd_contact *c = &p->contacts.list[n];
        double electrons = p->current[n] / PD_FARADAY * c->way / r->diffusion.desc.diffusivity;
        if (!pdi_surface_states_get_electrode_states(s, c->electrode)) continue;
        for (int k = 0; k < count; k++) flows[k] += s->components_per_electron[c->electrode][k] * electrons;
    }
}

/* With migrating ions: area-weighted means over the sites of a node of the concentrations c [solutes] [mol/m3], current
 * density around[0] [A/m2] and electrode potential around[1] [V] at the surface. Sites without area or state are left
 * out; without any, c of the node and 0. Returns 1; 0: the surface of a site has no solution, and c is not set. The
 * `surface` callback of pd_coat_desc. */
static int pdi_surface_states_average_ion_surface(void *user, int32_t node, double *c, double *around)
{
    const pd_surface_states *s = (const pd_surface_states *)user;
    const pd_etch *etch = s->surface_solver;
    const pd_reactive *r = s->state_solver.reactive;
    int count = r->components.solutes;
    double at[PD_SPECIES_MAX], sum[PD_SPECIES_MAX], psi, whole = 0.0;
    double volume = r->bonds->stencil->volume * pd_grid_circumference(r->grid, node);
    memset(sum, 0, sizeof sum);
    around[0] = around[1] = 0.0;
    for (int32_t p = etch->slot[node]; p >= 0 && p < etch->count && etch->node[p] == node; p++) {
        int e = etch->electrode ? etch->electrode[p] : -1;
        double area = e < 0 ? 1.0 : etch->area[p], speed = etch->weight[p] > 0.0 ? *pdi_etch_speed(etch, p) : 0.0;
        if (!(area > 0.0) || !pdi_surface_states_get_electrode_states(s, e)) continue;
        if (!pdi_layer_surface(etch, p, at, &psi)) return 0;
        whole += area;
        for (int n = 0; n < count; n++) sum[n] += area * at[n];
        if (e < 0) continue;
        around[0] += PD_FARADAY * pdi_levels_place(etch, p, speed, etch->flow[p]) / volume;
        around[1] += area * (etch->level[etch->desc.electrodes.member[e]] - psi * r->migration.volt);
    }
    pd_reactive_get(r, r->c, node, c);
    for (int n = 0; n < count && whole > 0.0; n++) c[n] = sum[n] / whole;
    for (int k = 0; k < 2 && whole > 0.0; k++) around[k] /= whole;
    return 1;
}

/* With migrating ions: solve rate laws and circuit potentials at time t [s]. The `solve` callback of pd_coat_desc. */
static pd_status pdi_surface_states_solve_species_potential(pd_ctx *ctx, void *user, double t)
{
    const pd_surface_states *s = (const pd_surface_states *)user;
    return s->solve(ctx, s->solve_user, t);
}

/* Without migrating ions: solve the potential at time t [s]. The `solve` callback of pd_coat_desc. */
static pd_status pdi_surface_states_solve_currents(pd_ctx *ctx, void *user, double t)
{
    return pdi_cell_bring(ctx, ((pd_surface_states *)user)->cell, t);
}

PDI_FN void pdi_surface_states_set_desc(const pd_setup *setup, const pd_reactive *reactive, pd_coat_desc *desc)
{
    desc->count = setup->states;
    desc->stages =
        setup->has_migration && (pd_setup_find_species_rate_metal(setup) >= 0 || pd_setup_has_ion_electrodes(setup));
    for (int k = 0; k < setup->states; k++) {
        const pd_setup_surface_state *state = &setup->state[k];
        desc->reads_ph |= (int)(state->rate.variables_used >> PD_SETUP_RATE_PH & 1u);
        for (int n = 0; n < state->species_count; n++)
            if (state->rate.variables_used >> (PD_SETUP_RATE_PH + 1 + n) & 1u)
                desc->reads |= (uint32_t)1 << reactive->components.solute_of_species[state->species_index[n]];
        if (pd_setup_has_ion_electrodes(setup))
            desc->reads_around |= state->rate.variables_used >> PD_SETUP_RATE_CURRENT & 3u;
    }
}

PDI_FN pd_status pdi_surface_states_build(pd_ctx *ctx, const pd_setup *setup, pd_reactive *reactive,
                                          const pd_bonds *bonds, const pd_stencil *across, pd_cell *cell,
                                          const pd_etch *etch, pd_surface_states *s)
{
    pd_coat_desc desc;
    memset(s, 0, sizeof *s);
    memset(&desc, 0, sizeof desc);
    s->setup = setup;
    s->bonds = bonds;
    s->interface_stencil = across;
    s->cell = cell;
    s->surface_solver = etch;
    for (int k = 0; k < setup->states; k++) {
        const pd_setup_surface_state *state = &setup->state[k];
        desc.name[k] = state->name;
        desc.low[k] = state->low;
        desc.high[k] = state->high;
        s->affects_potential |= (state->rate.variables_used >> PD_SETUP_RATE_CURRENT & 3u) != 0;
    }
    for (int e = 0; e < setup->potential.electrodes; e++) {
        const pd_setup_electrode *is = &setup->potential.electrode[e];
        double shed[PD_SPECIES_MAX];
        memset(shed, 0, sizeof shed);
        for (int n = 0; n < setup->electrolyte.count && is->has_reaction; n++)
            if (reactive->components.solute_of_species[n] >= 0)
                shed[reactive->components.solute_of_species[n]] = is->species_released[n];
        pdi_components_compute_totals(&reactive->components, shed, s->components_per_electron[e]);
        s->has_faradaic_source |= is->has_reaction;
        s->affects_potential |= is->has_current_factor;
    }
    pdi_surface_states_set_desc(setup, reactive, &desc);
    desc.rtol = setup->rtol > 0.0 ? setup->rtol : 1e-3;
    desc.where = pdi_surface_states_mark_nodes;
    desc.initial = pdi_surface_states_get_initial;
    desc.rate = pdi_surface_states_compute_rates;
    if (desc.stages) {
        desc.surface = pdi_surface_states_average_ion_surface;
        desc.solve = pdi_surface_states_solve_species_potential;
    } else {
        if (s->cell) desc.around = pdi_surface_states_average_electrode;
        if (s->cell && s->affects_potential) desc.solve = pdi_surface_states_solve_currents;
        if (s->has_faradaic_source || s->surface_solver) desc.film = pdi_surface_states_add_film_flux;
    }
    desc.user = s;
    return pdi_coat_build(ctx, reactive, &desc, &s->state_solver);
}

PDI_FN void pdi_surface_states_free(pd_ctx *ctx, pd_surface_states *s)
{
    pdi_coat_free(ctx, &s->state_solver);
    pdi_contact_free(ctx, &s->contacts);
    memset(s, 0, sizeof *s);
}

/* ---- what reads states ---- */

PDI_FN void pdi_surface_states_get_states(const pd_surface_states *s, int32_t node, double *value)
{
    for (int k = 0; k < s->setup->states; k++) value[k] = pdi_coat_value(&s->state_solver, k, node);
}

PDI_FN double pdi_surface_states_get_state(const pd_surface_states *s, int k, int32_t node)
{
    if (!(s->state_solver.on[node] >> k & 1u)) return (double)NAN;
    return s->state_solver.value[k * (int64_t)s->bonds->grid->total + node];
}

void pd_surface_states_compute_statistics(const pd_surface_states *s, int k, pd_surface_state_statistics *f)
{
    const pd_contacts *c = pdi_surface_states_get_contacts(s);
    const pd_grid *grid = s->bonds->grid;
    double sum = 0.0;
    f->min = f->max = (double)NAN;
    f->area = 0.0;
    for (int32_t n = 0; n < c->count; n++) {
        const pd_contact *at = &c->list[n];
        double y = pdi_surface_states_get_state(s, k, at->node);
        double area = at->area * s->bonds->stencil->volume * pd_grid_circumference(grid, at->node);
        if (!(pdi_surface_states_get_electrode_states(s, at->electrode) >> k & 1u) || !(y == y)) continue;
        f->area += area;
        sum += area * y;
        f->min = f->min <= y ? f->min : y;
        f->max = f->max >= y ? f->max : y;
    }
    f->mean = sum / f->area;
}

PDI_FN pd_status pdi_surface_states_compute_curve_factor(pd_ctx *ctx, const pd_surface_states *s, int electrode,
                                                         int32_t node, double t, double *share)
{
    const pd_setup_electrode *e = &s->setup->potential.electrode[electrode];
    double vars[PD_EXPR_VARS];
    char place[PDI_GRID_POSITION_LENGTH];
    if (!e->has_current_factor) return PD_OK;
    pd_grid_position(s->bonds->grid, node, vars);
    vars[PD_DIM] = t;
    pdi_surface_states_get_states(s, node, vars + PD_SETUP_POSITION_VARS);
    *share = pd_expr_eval(&e->current_factor, vars);
    if (*share >= 0.0 && *share < 1e100) return PD_OK;
    return pd_fail(ctx, PD_ERR_STATE, "electrode",
                   "the factor of %s is %g at %s m and t = %g s, expected a finite "
                   "number of at least 0",
                   e->name, *share, pdi_grid_format_position(s->bonds->grid, node, place), t);
}

PDI_FN pd_status pdi_surface_states_update_contact_factors(pd_ctx *ctx, const pd_surface_states *s, pd_contact *contact,
                                                           int32_t count, double t)
{
    for (int32_t n = 0; n < count; n++)
        PD_TRY(pdi_surface_states_compute_curve_factor(ctx, s, contact[n].electrode, contact[n].node, t,
                                                       &contact[n].share));
    return PD_OK;
}
