/* species_electrodes: see species_electrodes.h */
#include "physics/species_electrodes.h"
#include "core/vec.h"
#include "react/layer.h"
#include "react/levels.h"
#include <math.h>
#include <string.h>

/* Bit of pH in the mask of what a curve depends on, as of pd_etch_electrodes. */
#define PDI_SPECIES_ELECTRODES_READS_PH ((uint32_t)1 << 31)
/* [cells] Search radius for the nearest electrode of a metal. */
#define PDI_SPECIES_ELECTRODES_SEARCH_RADIUS 6
/* Sampling of laws and curves for decreasing parts: number of intervals, and potentials from -4 V to 4 V; a relative
 * decrease below the last number is rounding. */
#define PDI_SPECIES_ELECTRODES_SCAN_POINTS 1600
#define PDI_SPECIES_ELECTRODES_SCAN_RANGE 4.0
#define PDI_SPECIES_ELECTRODES_MONOTONE_TOLERANCE 1e-12
/* [V] Search for further potentials of a circuit: distance from the present one, and steps where a law decreases and
 * elsewhere. */
#define PDI_SPECIES_ELECTRODES_ROOT_SEARCH_RANGE 2.0
#define PDI_SPECIES_ELECTRODES_ROOT_FINE_STEP 0.005
#define PDI_SPECIES_ELECTRODES_ROOT_COARSE_STEP 0.1

/* Current density [A/m2] of an electrode from metal to fluid at the potential drop [V]: the bare fraction `share` times
 * its polarisation curve, through a film resistance if that is above 0, or times its expression in drop, pH and
 * species. 0: the electrode has no curve. A pd_etch_curve_fn. */
static double pdi_species_electrodes_compute_curve(void *user, int electrode, double share, const double *c, double ph,
                                                   double drop, double t)
{
    const pd_species_electrodes *p = (const pd_species_electrodes *)user;
    const pd_setup_electrode *e = &p->setup->potential.electrode[electrode];
    const pd_components *s = &p->etch->reactive->components;
    double vars[PD_EXPR_VARS], u = drop, slope;
    (void)t;
    if (e->has_no_curve) return 0.0;
    if (!e->has_species_curve && !(e->film_resistance > 0.0))
        return share * pd_electrode_current(&p->cell->curve[electrode], drop, NULL);
    if (!e->has_species_curve) return pdi_electrode_through(&p->cell->curve[electrode], share, drop, 0.0, &u, &slope);
    vars[0] = drop;
    vars[1] = ph;
    for (int k = 0; k < e->species_count; k++) vars[2 + k] = c[s->solute_of_species[e->species_index[k]]];
    return share * pd_expr_eval(&e->species_curve, vars);
}

/* Prescribed potential or current of a circuit at time t [s], as of pdi_electrode_map_get_circuit_value. */
static double pdi_species_electrodes_get_circuit_value(void *user, int circuit, double t)
{
    const pd_species_electrodes *p = (const pd_species_electrodes *)user;
    return pdi_electrode_map_get_circuit_value(p->map, circuit, t);
}

/* Sample an expression over its variable number `of`, a potential, with the other vars fixed, and extend the range
 * p->decreasing_from .. decreasing_to where it decreases; has_decreasing_range is 1 then. Values below `least` are
 * clamped to it. */
static void pdi_species_electrodes_find_decrease(const pd_expr *law, int of, double *vars, double least,
                                                 pd_species_electrodes *p)
{
    double last = -HUGE_VAL, stride = 2.0 * PDI_SPECIES_ELECTRODES_SCAN_RANGE / PDI_SPECIES_ELECTRODES_SCAN_POINTS;
    for (int k = 0; k <= PDI_SPECIES_ELECTRODES_SCAN_POINTS; k++) {
        vars[of] = stride * k - PDI_SPECIES_ELECTRODES_SCAN_RANGE;
        double i = pd_max(pd_expr_eval(law, vars), least);
        if (i < last - PDI_SPECIES_ELECTRODES_MONOTONE_TOLERANCE * fabs(last)) {
            p->decreasing_from =
                p->has_decreasing_range ? pd_min(p->decreasing_from, vars[of] - stride) : vars[of] - stride;
            p->decreasing_to = p->has_decreasing_range ? pd_max(p->decreasing_to, vars[of]) : vars[of];
            p->has_decreasing_range = 1;
        }
        last = i;
    }
}

/* The n-th (0 to 2) of three sample values of a surface state: its bounds and the middle, or, without bounds, numbers
 * of different magnitude. */
static double pdi_species_electrodes_get_sample_state(const pd_setup_surface_state *state, int n)
{
    static const double any[] = {1e-3, 1.0, 1e3};
    if (!(state->high - state->low < HUGE_VAL)) return pd_min(pd_max(any[n], state->low), state->high);
    return state->low + 0.5 * n * (state->high - state->low);
}

/* Extend the range of potentials in which a rate law or polarisation curve decreases, in p, by samples of
 * concentrations, pH, states and places from -4 V to 4 V. Only laws that read E and curves by an expression are
 * sampled; negative dissolution rates count as 0. Without a decrease has_decreasing_range stays as it is. */
static void pdi_species_electrodes_find_decreasing_range(pd_species_electrodes *p)
{
    const pd_setup *u = p->setup;
    static const double concentration[] = {1e-3, 1.0, 1e3}, ph[] = {2.0, 7.0, 12.0};
    double vars[PD_EXPR_VARS];
    for (int trial = 0; trial < 9; trial++) { /* states beside each concentration */
        int n = trial % 3;
        for (int k = 0; k < PD_EXPR_VARS; k++) vars[k] = concentration[n];
        for (int m = 0; m < u->metals && u->has_dissolve; m++) {
            const pd_setup_metal *metal = &u->metal[m];
            if (!(metal->rate.variables_used >> PD_SETUP_RATE_POTENTIAL & 1u)) continue;
            for (int d = 0; d < PD_DIM; d++) vars[2 + d] = u->lo[d] + 0.5 * n * (u->hi[d] - u->lo[d]);
            vars[PD_SETUP_RATE_PH] = ph[n];
            for (int k = 0; k < u->states; k++)
                vars[PD_SETUP_RATE_PH + 1 + metal->species_count + k] =
                    pdi_species_electrodes_get_sample_state(&u->state[k], trial / 3);
            pdi_species_electrodes_find_decrease(&metal->rate, PD_SETUP_RATE_POTENTIAL, vars, 0.0, p);
        }
        for (int k = 0; k < PD_EXPR_VARS; k++) vars[k] = concentration[n];
        vars[1] = ph[n];
        for (int e = 0; e < u->potential.electrodes && trial < 3; e++)
            if (u->potential.electrode[e].has_species_curve)
                pdi_species_electrodes_find_decrease(&u->potential.electrode[e].species_curve, 0, vars, -HUGE_VAL, p);
    }
}

PDI_FN pd_status pdi_species_electrodes_build(pd_ctx *ctx, const pd_setup *setup, pd_electrode_map *map, pd_cell *cell,
                                              const pd_reactive *reactive, pd_etch *etch, pd_species_electrodes *p,
                                              pd_etch_electrodes *electrodes)
{
    int count = setup->potential.electrodes, species = setup->electrolyte.count;
    memset(p, 0, sizeof *p);
    memset(electrodes, 0, sizeof *electrodes);
    p->setup = setup;
    p->map = map;
    p->cell = cell;
    p->etch = etch;
    PD_TRY(PD_NEW(ctx, "polarise", (int64_t)count * species, p->stoichiometry));
    for (int e = 0; e < count; e++) {
        const pd_setup_electrode *of = &setup->potential.electrode[e];
        for (int k = 0; k < species && of->has_reaction; k++)
            p->stoichiometry[e * species + k] = of->species_released[k];
        if (of->has_species_curve && (of->species_curve.variables_used >> 1 & 1u))
            p->depends_on[e] |= PDI_SPECIES_ELECTRODES_READS_PH;
        for (int k = 0; k < of->species_count && of->has_species_curve; k++)
            if (of->species_curve.variables_used >> (2 + k) & 1u)
                p->depends_on[e] |= (uint32_t)1 << reactive->components.solute_of_species[of->species_index[k]];
    }
    for (int n = 0; n < map->circuits; n++) p->circuit[n].holds = map->circuit[n].control == PD_CIRCUIT_POTENTIAL;
    electrodes->count = count;
    electrodes->curve = pdi_species_electrodes_compute_curve;
    electrodes->given = pdi_species_electrodes_get_circuit_value;
    electrodes->user = p;
    electrodes->part = p->stoichiometry;
    electrodes->reads = p->depends_on;
    electrodes->member = map->circuit_of_electrode;
    electrodes->circuit = p->circuit;
    electrodes->circuits = map->circuits;
    for (int e = 0; e < count; e++) electrodes->shares |= setup->potential.electrode[e].has_current_factor;
    pdi_species_electrodes_find_decreasing_range(p);
    return PD_OK;
}

/* Error message for a circuit with `found` potentials, root [4] [V] the first of them; names its first electrode.
 * Returns PD_ERR_STATE. */
static pd_status pdi_species_electrodes_reject_multiple_roots(pd_ctx *ctx, const pd_species_electrodes *p, int circuit,
                                                              int found, const double *root)
{
    const pd_setup_potential *of = &p->setup->potential;
    char text[160];
    int e = 0, shown = found < 4 ? found : 4;
    while (p->map->circuit_of_electrode[e] != circuit) e++;
    text[0] = '\0';
    for (int k = 0; k < shown; k++)
        pd_append(text, sizeof text, "%s%.3g V", k == 0 ? "" : k + 1 < shown ? ", " : " and ", root[k]);
    return pd_fail(ctx, PD_ERR_STATE, "potential", "at t = %g s the metal of [electrode %s] gives its total current "
                   "at %d potentials, %s: its law or curve falls as E rises, and its past decides which of them it "
                   "has; expected a law that rises or stays there, or a given potential of the electrode",
                   p->etch->time, of->electrode[e].name, found, text);
}

PDI_FN pd_status pdi_species_electrodes_check_unique_potential(pd_ctx *ctx, pd_species_electrodes *p)
{
    pd_etch *s = p->etch;
    int64_t total = s->reactive->grid->total;
    double root[4];
    int found = 0, circuit = 0;
    memcpy(p->saved_rates, s->speed, (size_t)(s->kinds * total) * sizeof *p->saved_rates);
    memcpy(p->saved_rates + s->kinds * total, s->flow, (size_t)total * sizeof *p->saved_rates);
    for (int n = 0; n < s->desc.electrodes.circuits && found < 2; n++) {
        double level = s->level[n];
        circuit = n;
        if (s->desc.electrodes.circuit[n].holds) continue;
        pdi_levels_trials trials = {level - PDI_SPECIES_ELECTRODES_ROOT_SEARCH_RANGE,
                                    level + PDI_SPECIES_ELECTRODES_ROOT_SEARCH_RANGE,
                                    p->decreasing_from,
                                    p->decreasing_to,
                                    PDI_SPECIES_ELECTRODES_ROOT_FINE_STEP,
                                    PDI_SPECIES_ELECTRODES_ROOT_COARSE_STEP};
        found = pdi_levels_roots(ctx, s, n, &trials, root, 4);
        s->level[n] = level;
    }
    memcpy(s->speed, p->saved_rates, (size_t)(s->kinds * total) * sizeof *p->saved_rates);
    memcpy(s->flow, p->saved_rates + s->kinds * total, (size_t)total * sizeof *p->saved_rates);
    return found < 2 ? PD_OK : pdi_species_electrodes_reject_multiple_roots(ctx, p, circuit, found, root);
}

PDI_FN void pdi_species_electrodes_free(pd_ctx *ctx, pd_species_electrodes *p)
{
    PD_DELETE(ctx, p->saved_count, p->saved_rates);
    if (p->setup)
        PD_DELETE(ctx, (int64_t)p->setup->potential.electrodes * p->setup->electrolyte.count, p->stoichiometry);
    memset(p, 0, sizeof *p);
}

PDI_FN int32_t pdi_species_electrodes_find_node_contacts(const pd_species_electrodes *p, int32_t first, int kind,
                                                         int32_t *own)
{
    const pd_contacts *c = &p->cell->potential.contacts;
    int32_t end = first;
    *own = -1;
    for (; end < c->count && c->list[end].node == c->list[first].node; end++) {
        if (kind < 0 || !(p->cell->kinds[c->list[end].electrode] >> kind & 1u)) continue;
        if (*own < 0 || c->list[end].area > c->list[*own].area) *own = end;
    }
    return end;
}

PDI_FN int pdi_species_electrodes_find_nearest_electrode(const pd_species_electrodes *p, const pd_dissolve *dissolve,
                                                         int32_t node, int kind)
{
    const pd_grid *grid = dissolve->grid;
    double nearest = HUGE_VAL, from[PD_DIM], x[PD_DIM];
    int found = 0, cells;
    pd_grid_position(grid, node, from);
    for (int k = 0; k < pdi_grid_count_cube(PDI_SPECIES_ELECTRODES_SEARCH_RADIUS); k++) {
        double far = 0.0;
        int32_t i = pdi_grid_find_cube_node(grid, node, PDI_SPECIES_ELECTRODES_SEARCH_RADIUS, k, &cells);
        if (i < 0 || grid->kind[i] != PD_SOLID || pdi_metal_of(dissolve, i) != kind) continue;
        pd_grid_position(grid, i, x);
        for (int d = 0; d < PD_DIM; d++) far += (x[d] - from[d]) * (x[d] - from[d]);
        if (!(far < nearest)) continue;
        nearest = far;
        found = p->cell->metal[i];
    }
    return found;
}

/* [A] (per m in planar 2D) Current of site k, positive out of the metal: dissolution by the rate law and the
 * polarisation curve. *size: sum of the absolute values of both; *anodic: sum of what is positive of both. The site has
 * an electrode. */
static double pdi_species_electrodes_compute_site_current(const pd_etch *s, int32_t k, double *size, double *anodic)
{
    const pd_reactive *r = s->reactive;
    double charge = 0.0, volume = r->bonds->stencil->volume * pd_grid_circumference(r->grid, s->node[k]);
    for (int n = 0; n < r->components.solutes; n++)
        charge += r->components.charge[n] * s->part[s->electrode[k] * r->components.solutes + n];
    double law = PD_FARADAY * volume * pdi_etch_of(s, k)->charge * s->gave[k];
    double curve = PD_FARADAY * volume * charge * s->area[k] * s->flow[k];
    *size = fabs(law) + fabs(curve);
    *anodic = pd_max(law, 0.0) + pd_max(curve, 0.0);
    return law + curve;
}

/* 1: fluid touches the electrode. */
static int pdi_species_electrodes_is_wetted(const pd_etch *s, int electrode)
{
    for (int32_t k = 0; k < s->count; k++)
        if (s->electrode[k] == electrode) return 1;
    return 0;
}

PDI_FN int pdi_species_electrodes_has_unwetted(const pd_species_electrodes *p)
{
    for (int e = 0; e < p->setup->potential.electrodes; e++)
        if (!pdi_species_electrodes_is_wetted(p->etch, e)) return 1;
    return 0;
}

/* Extend the range *met of potentials at which the tabulated curve of an electrode was evaluated, by those at its sites
 * now. Sites without area or bare fraction, or without a solution at the surface, are left out; an electrode without a
 * table leaves *met. */
static void pdi_species_electrodes_extend_surface_range(const pd_species_electrodes *p, int electrode,
                                                        pd_cell_range *met)
{
    const pd_electrode_term *table = pd_cell_table(p->cell, electrode);
    const pd_etch *s = p->etch;
    double c[PD_SPECIES_MAX], psi, slope;
    for (int32_t k = 0; table && k < s->count; k++) {
        double share = s->share ? s->share[k] : 1.0;
        if (s->electrode[k] != electrode || !(s->area[k] > 0.0) || !(share > 0.0)) continue;
        if (!pdi_layer_surface(s, k, c, &psi)) continue;
        double drop = s->level[s->desc.electrodes.member[electrode]] - psi * s->reactive->migration.volt, u = drop;
        if (p->cell->curve[electrode].desc.film > 0.0)
            pdi_electrode_through(&p->cell->curve[electrode], share, drop, 0.0, &u, &slope);
        pdi_cell_meet(table, u, s->time, met);
    }
}

PDI_FN void pdi_species_electrodes_update_surface_range(pd_species_electrodes *p)
{
    for (int e = 0; e < p->setup->potential.electrodes; e++)
        pdi_species_electrodes_extend_surface_range(p, e, &p->cell->met[e]);
}

/* [V] Potential of a circuit. NaN: it is not prescribed, and either fluid touches none of its metal or it carries no
 * current. */
static double pdi_species_electrodes_get_potential(const pd_species_electrodes *p, int circuit)
{
    const pd_etch *s = p->etch;
    int known = s->desc.electrodes.circuit[circuit].holds, idle = (int)(s->idle >> circuit & 1u);
    for (int32_t k = 0; k < s->count && !known && !idle; k++) known = pdi_etch_circuit(s, k) == circuit;
    return known ? s->level[circuit] : (double)NAN;
}

void pd_species_electrodes_get_electrode(const pd_species_electrodes *p, int electrode, pd_cell_electrode *now)
{
    const pd_etch *s = p->etch;
    int touched = 0;
    memset(now, 0, sizeof *now);
    now->potential = pdi_species_electrodes_get_potential(p, s->desc.electrodes.member[electrode]);
    for (int32_t k = 0; k < s->count; k++) {
        if (s->electrode[k] != electrode) continue;
        double volume = s->reactive->bonds->stencil->volume * pd_grid_circumference(s->reactive->grid, s->node[k]);
        double area = volume * s->area[k], size, anodic,
               current = pdi_species_electrodes_compute_site_current(s, k, &size, &anodic);
        now->touches = s->idle >> s->desc.electrodes.member[electrode] & 1u ? PD_CELL_IDLE : PD_CELL_WORKS;
        now->area += area;
        now->current += current;
        now->anodic += anodic;
        if (!(area > 0.0)) continue;
        now->least = touched ? pd_min(now->least, current / area) : current / area;
        now->most = touched ? pd_max(now->most, current / area) : current / area;
        touched = 1;
    }
    now->met = p->cell->met[electrode];
    pdi_species_electrodes_extend_surface_range(p, electrode, &now->met);
    now->charge = PD_FARADAY * s->charge[2 * electrode];
    now->passed = PD_FARADAY * s->charge[2 * electrode + 1];
}

PDI_FN double pdi_species_electrodes_compute_current_density(const pd_species_electrodes *p, int32_t node)
{
    const pd_etch *s = p->etch;
    double area = 0.0, current = 0.0, size, anodic;
    for (int32_t k = s->slot[node]; k >= 0 && k < s->count && s->node[k] == node; k++) {
        area += s->reactive->bonds->stencil->volume * pd_grid_circumference(s->reactive->grid, node) * s->area[k];
        current += pdi_species_electrodes_compute_site_current(s, k, &size, &anodic);
    }
    return area > 0.0 ? current / area : (double)NAN;
}

double pd_species_electrodes_compute_total_current(const pd_species_electrodes *p, double *off)
{
    const pd_etch *s = p->etch;
    double anodic = 0.0, extra = PD_FARADAY * s->extra;
    *off = 0.0;
    for (int n = 0; n < s->desc.electrodes.circuits; n++) {
        double sum = 0.0, wanted = s->desc.electrodes.circuit[n].value + extra;
        double size = PD_FARADAY * fabs(s->conduct[n]) * PDI_POTENTIAL_SMALL; /* less is none */
        for (int32_t k = 0; k < s->count; k++) {
            if (pdi_etch_circuit(s, k) != n) continue;
            double each, leaves;
            sum += pdi_species_electrodes_compute_site_current(s, k, &each, &leaves);
            size += each;
            anodic += leaves;
        }
        if (s->desc.electrodes.circuit[n].holds || !(size > 0.0)) continue;
        *off = pd_max(*off, fabs(sum - wanted) / size);
        extra = 0.0;
    }
    return anodic;
}

PDI_FN pd_status pdi_species_electrodes_check_solved(pd_ctx *ctx, const pd_species_electrodes *p)
{
    const pd_etch *s = p->etch;
    const pd_setup_potential *of = &p->setup->potential;
    int named = 0;
    if (!s->lost) return PD_OK;
    while (s->desc.electrodes.member[named] != s->lost - 1) named++; /* each circuit has one */
    for (int e = of->electrodes - 1; e >= 0; e--)
        if (s->desc.electrodes.member[e] == s->lost - 1 && pdi_species_electrodes_is_wetted(s, e)) named = e;
    return pd_fail(ctx, PD_ERR_STATE, "potential",
                   "at t = %g s no potential was found that gives the metal "
                   "of %s a total current of %g A: its curve and its law do not carry that, or carry it at two "
                   "potentials around a peak, or they take up more of a species than reaches the metal; expected "
                   "anodic and cathodic reactions, and a curve that falls to 0 with the species that it takes up",
                   s->time, of->electrode[named].name, s->desc.electrodes.circuit[s->lost - 1].value);
}

#undef PDI_SPECIES_ELECTRODES_READS_PH
#undef PDI_SPECIES_ELECTRODES_SEARCH_RADIUS
#undef PDI_SPECIES_ELECTRODES_SCAN_POINTS
#undef PDI_SPECIES_ELECTRODES_SCAN_RANGE
#undef PDI_SPECIES_ELECTRODES_MONOTONE_TOLERANCE
#undef PDI_SPECIES_ELECTRODES_ROOT_SEARCH_RANGE
#undef PDI_SPECIES_ELECTRODES_ROOT_FINE_STEP
#undef PDI_SPECIES_ELECTRODES_ROOT_COARSE_STEP
