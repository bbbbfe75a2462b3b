/* dissolution_laws: see dissolution_laws.h */
#include "physics/dissolution_laws.h"
#include "react/layer.h"
#include "react/levels.h"
#include "react/loops.h"
#include "metal/content.h"
#include "metal/interface.h"
#include <math.h>
#include <string.h>

/* Relative tolerance on the saturation concentration within which fluid counts as saturated (salt layer). */
#define PDI_DISSOLUTION_LAWS_SATURATION_TOLERANCE 1e-6
/* A node with less than this fraction of the ionic charge of a neighbour has just been converted to fluid. */
#define PDI_DISSOLUTION_LAWS_NEW_FLUID_FRACTION 0.1
/* A surface site belongs to the metal component that gives more than this fraction of its weight. */
#define PDI_DISSOLUTION_LAWS_COMPONENT_FRACTION 0.5

PDI_FN void pdi_dissolution_laws_set_variables(const pd_dissolution_law *law, int32_t node, const double *c, double ph,
                                               double phi, double t, double *vars)
{
    const pd_dissolution_laws *a = law->laws;
    const pd_setup_metal *metal = &a->setup->metal[law->setup_metal];
    vars[0] = 0.0;
    vars[1] = t;
    pd_grid_position(a->dissolve->grid, node, vars + 2);
    vars[PD_SETUP_RATE_GRAIN] = a->grain ? a->grain[node] : -1;
    vars[PD_SETUP_RATE_CURRENT] = vars[PD_SETUP_RATE_POTENTIAL] = 0.0;
    if (a->cell && !a->species_electrodes.setup)
        pdi_cell_beside(a->cell, node, 0, &vars[PD_SETUP_RATE_CURRENT], &vars[PD_SETUP_RATE_POTENTIAL]);
    if (a->species_electrodes.setup) {
        vars[PD_SETUP_RATE_POTENTIAL] = -phi;
    } else if (metal->has_potential) {
        double x[PD_DIM];
        memset(x, 0, sizeof x);
        vars[PD_SETUP_RATE_POTENTIAL] = pdi_setup_eval_expr(&metal->potential, x, t) - phi;
    }
    memset(vars + PD_SETUP_RATE_FIELD, 0, PD_PHYSICS_TYPE_FIELDS * sizeof *vars);
    if (a->set_registered && pd_setup_reads_registered_field(metal))
        a->set_registered(a->set_registered_user, node, vars);
    vars[PD_SETUP_RATE_PH] = ph;
    for (int k = 0; k < metal->species_count; k++)
        vars[PD_SETUP_RATE_PH + 1 + k] =
            c[a->surface_solver.reactive->components.solute_of_species[metal->species_index[k]]];
    if (law->surfaces)
        pdi_surface_states_get_states(law->surfaces, node, vars + PD_SETUP_RATE_PH + 1 + metal->species_count);
}

/* Dissolution speed [m/s] of a metal by its rate expression at the surface beside a node, times rate_scale. A
 * pd_etch_fn. */
static double pdi_dissolution_laws_compute_rate(void *user, int32_t node, const double *c, double ph, double phi,
                                                double t)
{
    const pd_dissolution_law *law = (const pd_dissolution_law *)user;
    const pd_setup_metal *metal = &law->laws->setup->metal[law->setup_metal];
    double vars[PD_EXPR_VARS];
    pdi_dissolution_laws_set_variables(law, node, c, ph, phi, t, vars);
    return metal->rate_scale * pd_expr_eval(&metal->rate, vars);
}

/* Update the factors of polarisation curves (surface_solver.share) at all sites with an electrode from the surface
 * states as they are now. PD_ERR_STATE: one is negative or not finite. */
static pd_status pdi_dissolution_laws_update_electrode_factors(pd_ctx *ctx, pd_dissolution_laws *a)
{
    pd_etch *s = &a->surface_solver;
    for (int32_t p = 0; p < s->count && s->share; p++)
        if (s->electrode[p] >= 0)
            PD_TRY(pdi_surface_states_compute_curve_factor(ctx, a->states, s->electrode[p], s->node[p], s->time,
                                                           &s->share[p]));
    return PD_OK;
}

/* Bring rate laws and curve factors to time t [s] and to the present surface states; nothing is solved. The `solve`
 * callback of pd_surface_states; user: a pd_dissolution_laws. */
static pd_status pdi_dissolution_laws_set_time(pd_ctx *ctx, void *user, double t)
{
    pd_dissolution_laws *a = (pd_dissolution_laws *)user;
    a->surface_solver.time = t;
    return pdi_dissolution_laws_update_electrode_factors(ctx, a);
}

/* Fill in a->law[m] and return the descriptor of metal m of the surface solver, `kind` of the setup: its law, the
 * species that it releases (NULL without a surface reaction) and the solutes it depends on. A metal without a law in
 * the species gets no law, and law[m] is set all the same. Surface states are kept only where the law reads one. */
static pd_etch_metal pdi_dissolution_laws_set_metal_desc(pd_dissolution_laws *a, int m, int kind,
                                                         const pd_reactive *reactive, const pd_surface_states *surfaces)
{
    const pd_setup_metal *of = &a->setup->metal[kind];
    pd_etch_metal metal;
    memset(&metal, 0, sizeof metal);
    a->law[m].laws = a;
    a->law[m].setup_metal = kind;
    a->law[m].surface_metal = m;
    if (a->setup->has_surface_reaction) metal.shed = of->species_released;
    if (!pd_setup_has_species_rate(of)) return metal;
    if (of->rate.variables_used >> (PD_SETUP_RATE_PH + 1 + of->species_count)) a->law[m].surfaces = surfaces;
    metal.law = pdi_dissolution_laws_compute_rate;
    metal.user = &a->law[m];
    metal.reads_ph = (int)(of->rate.variables_used >> PD_SETUP_RATE_PH & 1u);
    for (int k = 0; k < of->species_count; k++)
        if (of->rate.variables_used >> (PD_SETUP_RATE_PH + 1 + k) & 1u)
            metal.reads |= (uint32_t)1 << reactive->components.solute_of_species[of->species_index[k]];
    return metal;
}

/* Set a->law_count, a->law[], the descriptors metal[] of all metals with a law (the only one, or all metals of the
 * setup) and the fields of desc that follow from them; desc->more points into metal[]. */
static void pdi_dissolution_laws_set_metals_desc(pd_dissolution_laws *a, const pd_reactive *reactive,
                                                 const pd_surface_states *surfaces, pd_etch_metal *metal,
                                                 pd_etch_desc *desc)
{
    int kind = pd_setup_find_species_rate_metal(a->setup);
    a->law_count = kind < 0 ? 0 : pd_setup_count_species_rate_metals(a->setup);
    for (int m = 0; m < a->law_count; m++) {
        const pd_setup_metal *of = &a->setup->metal[a->law_count > 1 ? m : kind];
        metal[m] = pdi_dissolution_laws_set_metal_desc(a, m, a->law_count > 1 ? m : kind, reactive, surfaces);
        desc->reads_phi |= of->has_potential && (of->rate.variables_used >> PD_SETUP_RATE_POTENTIAL & 1u);
    }
    if (!a->law_count) return;
    desc->law = metal->law;
    desc->user = metal->user;
    desc->shed = metal->shed;
    desc->reads = metal->reads;
    desc->reads_ph = metal->reads_ph;
    desc->more = metal + 1;
    desc->more_count = a->law_count - 1;
}

/* Does a rate law depend on the grain of the metal? 1 or 0. */
static int pdi_dissolution_laws_reads_grain(const pd_dissolution_laws *a)
{
    for (int m = 0; m < a->law_count; m++)
        if (a->setup->metal[a->law[m].setup_metal].rate.variables_used >> PD_SETUP_RATE_GRAIN & 1u) return 1;
    return 0;
}

PDI_FN pd_status pdi_dissolution_laws_build(pd_ctx *ctx, const pd_setup *setup, pd_reactive *reactive,
                                            pd_dissolve *dissolve, const pd_course *course, pd_cell *cell,
                                            pd_electrode_map *map, pd_surface_states *surfaces, pd_dissolution_laws *a)
{
    pd_etch_metal metal[PD_SETUP_METALS];
    pd_etch_desc desc;
    memset(a, 0, sizeof *a);
    memset(&desc, 0, sizeof desc);
    a->setup = setup;
    a->dissolve = dissolve;
    a->species_integrator = course;
    pdi_dissolution_laws_set_metals_desc(a, reactive, surfaces, metal, &desc);
    if (surfaces && setup->has_migration) {
        a->states = surfaces;
        surfaces->solve = pdi_dissolution_laws_set_time;
        surfaces->solve_user = a;
    }
    a->cell = pdi_setup_has_electric_rate(&setup->metal[a->law->setup_metal]) || pd_setup_has_ion_electrodes(setup)
                  ? cell
                  : NULL;
    if (pd_setup_has_ion_electrodes(setup)) {
        desc.reads_phi = 1;
        PD_TRY(pdi_species_electrodes_build(ctx, setup, map, cell, reactive, &a->surface_solver,
                                            &a->species_electrodes, &desc.electrodes));
    }
    if (a->law_count && dissolve && dissolve->kinds == 1 && !pdi_metal_bonds(dissolve) &&
        !(dissolve->kind[0].end > 0.0))
        desc.solid = dissolve->kind[0].solid;
    PD_TRY(pd_etch_build(ctx, reactive, &desc, &a->surface_solver));
    if (a->species_electrodes.has_decreasing_range) {
        a->species_electrodes.saved_count = (a->surface_solver.kinds + 1) * (int64_t)reactive->grid->total;
        PD_TRY(PD_NEW(ctx, "attack", a->species_electrodes.saved_count, a->species_electrodes.saved_rates));
    }
    return pdi_dissolution_laws_reads_grain(a) ? PD_NEW(ctx, "attack", dissolve->grid->total, a->grain) : PD_OK;
}

PDI_FN void pdi_dissolution_laws_free(pd_ctx *ctx, pd_dissolution_laws *a)
{
    if (a->dissolve) PD_DELETE(ctx, a->dissolve->grid->total, a->grain);
    pd_etch_free(ctx, &a->surface_solver);
    pdi_species_electrodes_free(ctx, &a->species_electrodes);
    memset(a, 0, sizeof *a);
}

/* Pointer to the dissolution speed [m/s] of metal m at a node. */
static double *pdi_dissolution_laws_get_speed_pointer(pd_dissolution_laws *a, int m, int32_t node)
{
    return &a->surface_solver.speed[m * a->dissolve->grid->total + node];
}

PDI_FN double pdi_dissolution_laws_get_speed(void *user, const pd_rate_at *at)
{
    const pd_dissolution_law *law = (const pd_dissolution_law *)user;
    return *pdi_dissolution_laws_get_speed_pointer(law->laws, law->surface_metal, at->node);
}

/* [mol/m4] Interface weight of metal m at a fluid node beside metal: amount that dissolves per volume and unit of
 * speed; 0: the metal has no law in the species. */
static double pdi_dissolution_laws_compute_weight(const pd_dissolution_laws *a, int m, const pdi_beside *beside)
{
    const pd_dissolve *d = a->dissolve;
    if (!a->surface_solver.kind[m].law.law) return 0.0;
    return d->kinds > 1 ? pdi_metal_portion(d, beside)[a->law[m].setup_metal].weight : beside->weight;
}

/* [mol2/m7] Sum over the metals at a node of interface weight times dissolvable content. */
static double pdi_dissolution_laws_compute_supply(const pd_dissolve *d, const pdi_beside *beside)
{
    double sum = 0.0;
    for (int k = 0; k < d->kinds; k++) sum += pdi_metal_portion(d, beside)[k].weight * d->kind[k].supply;
    return sum;
}

/* [mol s/m5] Concentration rise across a diffusion film per unit of speed of metal m and of film length: dissolvable
 * content over diffusivity, times the mean rate factor of the metals there; of several metals with a law, the share of
 * metal m. 0 for bond-based corrosion, and without a diffusivity. The weight at the node is above 0. */
static double pdi_dissolution_laws_compute_film_factor(const pd_dissolution_laws *a, int m, const pdi_beside *beside)
{
    const pd_dissolve *d = a->dissolve;
    double diffusivity = a->surface_solver.reactive->diffusion.desc.diffusivity;
    if (pdi_metal_bonds(d) || !(diffusivity > 0.0)) return 0.0;
    double supply = d->kind[0].supply * (beside->flux / beside->weight);
    double all = a->law_count > 1 ? pdi_dissolution_laws_compute_supply(d, beside) : 0.0;
    if (all > 0.0) supply *= d->kind[a->law[m].setup_metal].supply * (beside->weight / all);
    return supply / diffusivity;
}

/* [mol s/m4] Concentration rise per unit of speed of metal m across the film at a node as it is now. */
static double pdi_dissolution_laws_compute_film_resistance(const pd_dissolution_laws *a, int m,
                                                           const pdi_beside *beside)
{
    return pdi_dissolution_laws_compute_film_factor(a, m, beside) * (beside->film / beside->weight);
}

/* Set the film resistance (`thick` [mol s/m4]) and its growth per length of receded metal (`rise` [mol s/m5]) of site p
 * of metal m; metal recedes by its speed times the mean rate factor there. */
static void pdi_dissolution_laws_set_film_length(pd_dissolution_laws *a, int32_t p, int m, const pdi_beside *beside)
{
    const pd_dissolve *d = a->dissolve;
    double all = pdi_dissolution_laws_compute_supply(d, beside),
           rise = pdi_dissolution_laws_compute_film_factor(a, m, beside);
    a->surface_solver.thick[p] = rise * (beside->film / beside->weight);
    a->surface_solver.rise[p] = all > 0.0 ? rise * (beside->flux * d->kind[0].supply / all) : 0.0;
}

/* Check that the speed of metal m at a node is below 1e100 m/s; negative ones pass. PD_ERR_STATE: it is not, or NaN;
 * the message names time, place and pH. */
static pd_status pdi_dissolution_laws_check_speed(pd_ctx *ctx, const pd_dissolution_laws *a, int m, int32_t node)
{
    char place[PDI_GRID_POSITION_LENGTH];
    double v = a->surface_solver.speed[m * a->dissolve->grid->total + node];
    if (v < 1e100) return PD_OK;
    return pd_fail(ctx, PD_ERR_STATE, "dissolve",
                   "the rate law in pH, species or E gives %g m/s at t = %g s (node %d "
                   "at %s m, pH %.4g), expected a speed below 1e100 m/s",
                   v, a->surface_solver.time, (int)node, pdi_grid_format_position(a->dissolve->grid, node, place),
                   pd_reactive_ph(a->surface_solver.reactive, node));
}

/* Is the fluid of a node saturated (salt layer)? 1: bond-based corrosion, and c is at least the saturation
 * concentration less 1e-6 of it; the metal model then decides on the flux, and the species get it a step later. 0 for
 * other metal. */
static int pdi_dissolution_laws_is_saturated(const pd_dissolve *d, int32_t node)
{
    return pdi_metal_bonds(d) &&
           d->transport->c[node] >= d->desc.saturation * (1.0 - PDI_DISSOLUTION_LAWS_SATURATION_TOLERANCE);
}

/* Speed [m/s] of metal m at node i that has been converted to fluid within the step of the run: mean over its open
 * bonds, by Laplacian weights, of the speeds at fluid nodes, first those with sites. Returns 1: *speed is set; 0: there
 * are none, and it stays. */
static int pdi_dissolution_laws_find_previous_speed(const pd_dissolution_laws *a, int m, int32_t i, double *speed)
{
    const pd_bond_paths *paths = &a->surface_solver.reactive->bonds->paths;
    const double *of = a->surface_solver.speed + m * paths->grid->total;
    double sum = 0.0, all = 0.0;
    for (int placed = 1; placed >= 0 && !(all > 0.0); placed--)
        for (int k = 0; k < paths->stencil->count; k++) {
            int32_t j = pdi_entry_far(paths, i, k);
            if (j < 0 || j == i || paths->grid->kind[j] != PD_FLUID) continue;
            if (pdi_bond_path_find_closed_group(paths, i, k) >= 0) continue;
            if ((pdi_etch_law(&a->surface_solver, m, j) >= 0) != placed || (!placed && !(of[j] > 0.0))) continue;
            sum += paths->stencil->laplacian_weight[k] * of[j];
            all += paths->stencil->laplacian_weight[k];
        }
    if (all > 0.0) *speed = sum / all;
    return all > 0.0;
}

/* Set and check the dissolution speed of metal m at a fluid node beside it; without a weight of that metal does
 * nothing. A node with a site keeps that of its site. Else, where the species are ahead of the dissolution in time and
 * the node is not saturated, it is the mean of neighbouring nodes; where that fails, the film equation with present
 * concentrations. PD_ERR_STATE: the speed is not a number below 1e100 m/s. */
static pd_status pdi_dissolution_laws_update_speed(pd_ctx *ctx, pd_dissolution_laws *a, int m, const pdi_beside *beside)
{
    const pd_dissolve *d = a->dissolve;
    int32_t i = beside->node;
    double *speed = pdi_dissolution_laws_get_speed_pointer(a, m, i);
    if (!(pdi_dissolution_laws_compute_weight(a, m, beside) > 0.0)) return PD_OK;
    int behind = a->species_integrator->time > d->time && !pdi_dissolution_laws_is_saturated(d, i);
    if (pdi_etch_law(&a->surface_solver, m, i) < 0 &&
        !(behind && pdi_dissolution_laws_find_previous_speed(a, m, i, speed)))
        *speed = pdi_layer_at(&a->surface_solver, m, i, -1, pdi_dissolution_laws_compute_film_resistance(a, m, beside),
                              *speed);
    return pdi_dissolution_laws_check_speed(ctx, a, m, i);
}

/* Update and check the dissolution speeds at all fluid nodes beside metal. */
static pd_status pdi_dissolution_laws_update_all_speeds(pd_ctx *ctx, pd_dissolution_laws *a)
{
    const pd_dissolve *d = a->dissolve;
    for (int32_t k = 0; k < d->beside_count; k++)
        for (int m = 0; m < a->law_count; m++) PD_TRY(pdi_dissolution_laws_update_speed(ctx, a, m, &d->beside[k]));
    return PD_OK;
}

/* [mol/m3] Ionic charge concentration of a node: sum of |z| c over solutes. */
static double pdi_dissolution_laws_compute_ionic_charge(const pd_dissolution_laws *a, int32_t node)
{
    const pd_components *s = &a->surface_solver.reactive->components;
    double sum = 0.0;
    for (int n = 0; n < s->solutes; n++)
        sum += fabs((double)s->charge[n]) * a->surface_solver.reactive->c[(int64_t)n * a->dissolve->grid->total + node];
    return sum;
}

/* Raise the speed of metal m at a node just converted to fluid to the largest that its law gives with the
 * concentrations of an adjacent fluid node that has more than 10 times its ionic charge: the node has next to no ions
 * to carry a current, and the speed bounds the time step. Does nothing without a weight of the metal or such a
 * neighbour. */
static void pdi_dissolution_laws_limit_new_fluid(pd_dissolution_laws *a, int m, const pdi_beside *beside)
{
    const pd_grid *grid = a->dissolve->grid;
    double own = pdi_dissolution_laws_compute_ionic_charge(a, beside->node),
           *speed = pdi_dissolution_laws_get_speed_pointer(a, m, beside->node);
    int32_t place = pdi_etch_law(&a->surface_solver, m, beside->node);
    if (!(pdi_dissolution_laws_compute_weight(a, m, beside) > 0.0)) return;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int32_t next = beside->node + (side % 2 ? 1 : -1) * (int32_t)grid->stride[side / 2];
        if (grid->kind[next] != PD_FLUID ||
            !(own < PDI_DISSOLUTION_LAWS_NEW_FLUID_FRACTION * pdi_dissolution_laws_compute_ionic_charge(a, next)))
            continue;
        double there = pdi_layer_at(&a->surface_solver, m, next, place,
                                    pdi_dissolution_laws_compute_film_resistance(a, m, beside), *speed);
        *speed = pd_max(*speed, there);
    }
}

/* Update the weights of existing sites within a step of the run, as the coverage of metal by minerals has changed. With
 * electrodes: of sites with a law whose node still has metal beside it. Without them: also the film resistances, and
 * the weight is 0 where no metal is left beside a site. */
static void pdi_dissolution_laws_update_weights(pd_dissolution_laws *a)
{
    const pd_dissolve *d = a->dissolve;
    pd_etch *s = &a->surface_solver;
    for (int32_t p = 0; p < s->count && s->electrode; p++) {
        if (!(s->weight[p] > 0.0) || d->slot[s->node[p]] < 0) continue;
        const pdi_beside *beside = &d->beside[d->slot[s->node[p]]];
        if (beside->weight > 0.0) s->weight[p] = pdi_dissolution_laws_compute_weight(a, pdi_etch_which(s, p), beside);
    }
    if (s->electrode) return;
    for (int32_t p = 0; p < s->count; p++) s->weight[p] = 0.0;
    for (int32_t k = 0; k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        int32_t p = s->slot[beside->node];
        if (p < 0 || !(beside->weight > 0.0)) continue;
        s->weight[p] = beside->weight;
        pdi_dissolution_laws_set_film_length(a, p, 0, beside);
    }
}

/* Add a surface site at a node: contact n of the potential solver with its electrode (-1: the nearest electrode of the
 * metal, without an area), and the law of metal m with its weight and the thickness of its film (-1: no law).
 * PD_ERR_SIZE: no room. */
static pd_status pdi_dissolution_laws_add_site(pd_ctx *ctx, pd_dissolution_laws *a, int32_t node, int32_t n, int m,
                                               const pdi_beside *beside)
{
    const pd_contacts *c = &a->cell->potential.contacts;
    pd_etch *s = &a->surface_solver;
    if (s->count == s->reactive->grid->total)
        return pd_fail(ctx, PD_ERR_SIZE, "potential", "more contacts of electrodes than nodes");
    pd_etch_put(s, node, m < 0 ? 0.0 : pdi_dissolution_laws_compute_weight(a, m, beside), 0.0);
    if (m >= 0) pdi_dissolution_laws_set_film_length(a, s->count - 1, m, beside);
    if (n >= 0) pdi_etch_polarise(s, m < 0 ? 0 : m, c->list[n].electrode, c->list[n].area, c->list[n].way);
    else
        pdi_etch_polarise(s, m,
                          pdi_species_electrodes_find_nearest_electrode(&a->species_electrodes, a->dissolve, node,
                                                                        a->law[m].setup_metal),
                          0.0, 0.0);
    return PD_OK;
}

/* Add a site for each metal at a node whose law has none there yet, on the nearest electrode of that metal. beside
 * NULL: the node has no metal, and nothing is done. */
static pd_status pdi_dissolution_laws_add_other_metals(pd_ctx *ctx, pd_dissolution_laws *a, const pdi_beside *beside)
{
    for (int m = 0; m < a->law_count && beside; m++)
        if (pdi_dissolution_laws_compute_weight(a, m, beside) > 0.0 &&
            pdi_etch_law(&a->surface_solver, m, beside->node) < 0)
            PD_TRY(pdi_dissolution_laws_add_site(ctx, a, beside->node, -1, m, beside));
    return PD_OK;
}

/* Add the sites with electrodes: one for each electrode beside a node, then one for each metal there with a law that
 * has no electrode, also at nodes without any. The law of a metal goes to its electrode with the largest area there;
 * other electrodes get a site without a law. PD_ERR_SIZE: more sites than nodes. */
static pd_status pdi_dissolution_laws_add_electrode_sites(pd_ctx *ctx, pd_dissolution_laws *a)
{
    const pd_dissolve *d = a->dissolve;
    const pd_contacts *c = &a->cell->potential.contacts;
    for (int32_t k = 0, end; k < c->count; k = end) {
        int32_t own[PD_SETUP_METALS], i = c->list[k].node;
        const pdi_beside *beside = d && d->slot[i] >= 0 ? &d->beside[d->slot[i]] : NULL;
        end = pdi_species_electrodes_find_node_contacts(&a->species_electrodes, k, -1, own);
        for (int m = 0; m < a->law_count; m++) {
            pdi_species_electrodes_find_node_contacts(&a->species_electrodes, k, a->law[m].setup_metal, &own[m]);
            if (!beside || !(pdi_dissolution_laws_compute_weight(a, m, beside) > 0.0)) own[m] = -1;
        }
        for (int32_t at = k; at < end; at++) {
            int law = -1;
            for (int m = a->law_count; m-- > 0;)
                if (own[m] == at) law = m;
            PD_TRY(pdi_dissolution_laws_add_site(ctx, a, i, at, law, beside));
        }
        PD_TRY(pdi_dissolution_laws_add_other_metals(ctx, a, beside));
    }
    for (int32_t k = 0; d && k < d->beside_count; k++)
        if (a->surface_solver.slot[d->beside[k].node] < 0)
            PD_TRY(pdi_dissolution_laws_add_other_metals(ctx, a, &d->beside[k]));
    return PD_OK;
}

/* Rebuild the surface sites and a->grain, and solve rate laws, polarisation curves and circuit potentials for the
 * present concentrations, into the surface solver. Then updates the dissolution speeds of all nodes. Saturated nodes
 * get no site without electrodes. PD_ERR_STATE: no solution, a law that is no number, or several potentials of a
 * circuit, for which it looks after 0, 1, 2, 4, ... steps where a law decreases with E. */
static pd_status pdi_dissolution_laws_solve_surface(pd_ctx *ctx, pd_dissolution_laws *a)
{
    const pd_dissolve *d = a->dissolve;
    pd_etch *s = &a->surface_solver;
    pd_etch_open(s);
    if (s->electrode) PD_TRY(pdi_dissolution_laws_add_electrode_sites(ctx, a));
    for (int32_t k = 0; d && k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        pdi_law law;
        if (!(beside->weight > 0.0)) continue;
        if (a->grain) {
            pdi_interface_law(d, beside, &law);
            a->grain[beside->node] = law.at.grain;
        }
        if (s->electrode || pdi_dissolution_laws_is_saturated(d, beside->node)) continue;
        pd_etch_put(s, beside->node, beside->weight, 0.0);
        pdi_dissolution_laws_set_film_length(a, s->count - 1, 0, beside);
    }
    PD_TRY(pdi_dissolution_laws_update_electrode_factors(ctx, a));
    s->odd = 0;
    s->alone =
        s->electrode && a->species_integrator->steps > 0 && pdi_species_electrodes_has_unwetted(&a->species_electrodes);
    pdi_loops_find(s->reactive);
    pdi_levels_solve(ctx, s);
    pdi_etch_note(s);
    if (s->lost && s->odd) {
        *pdi_etch_speed(s, s->odd - 1) = (double)NAN;
        return pdi_dissolution_laws_check_speed(ctx, a, pdi_etch_which(s, s->odd - 1), s->node[s->odd - 1]);
    }
    if (s->electrode) PD_TRY(pdi_species_electrodes_check_solved(ctx, &a->species_electrodes));
    if (s->electrode) pdi_species_electrodes_update_surface_range(&a->species_electrodes);
    /* at the start, and after 1, 2, 4, ... steps */
    if (a->species_electrodes.has_decreasing_range &&
        (a->species_integrator->steps & (a->species_integrator->steps - 1)) == 0)
        PD_TRY(pdi_species_electrodes_check_unique_potential(ctx, &a->species_electrodes));
    for (int32_t k = 0; d && k < d->beside_count && s->desc.reads_phi; k++)
        for (int m = 0; m < a->law_count; m++) pdi_dissolution_laws_limit_new_fluid(a, m, &d->beside[k]);
    return d ? pdi_dissolution_laws_update_all_speeds(ctx, a) : PD_OK;
}

/* Callback of pdi_content_small: metal component `piece` (content `has`) gives metal to a node with a weight [mol/m4].
 * Accumulates the weight of the component at the site, in `split`; several components there make it -HUGE_VAL. user: a
 * pd_dissolution_laws. */
static void pdi_dissolution_laws_add_component_weight(void *user, int32_t piece, double has, int metal, int32_t node,
                                                      double weight)
{
    pd_dissolution_laws *a = (pd_dissolution_laws *)user;
    pd_etch *s = &a->surface_solver;
    int m = 0;
    while (m + 1 < a->law_count && a->dissolve->kinds > 1 && a->law[m].setup_metal != metal) m++;
    int32_t p = pdi_etch_law(s, m, node);
    if (p < 0 || (a->dissolve->kinds > 1 && a->law[m].setup_metal != metal)) return;
    s->pieces = piece + 1;
    s->has[piece] = has;
    if (s->piece[p] < 0) s->piece[p] = piece;
    s->split[p] += s->piece[p] == piece ? weight : -HUGE_VAL;
}

/* The only metal component among the sites of metal m; -1: there are several, or none. */
static int32_t pdi_dissolution_laws_find_only_component(const pd_etch *s, int m)
{
    int32_t only = -1;
    for (int32_t p = 0; p < s->count; p++) {
        if (s->piece[p] < 0 || pdi_etch_which(s, p) != m) continue;
        if (only >= 0 && s->piece[p] != only) return -1;
        only = s->piece[p];
    }
    return only;
}

/* Assign each site, in `piece`, to the small metal component that dissolves there and may be consumed within a step;
 * -1: none. It is the one that gives more than half of the weight of the site; if all metal is in such components, one
 * that is alone among the sites of a metal takes all of them. Edges and neighbouring metals make weights differ by a
 * few percent; sums agree. */
static void pdi_dissolution_laws_find_components(pd_dissolution_laws *a)
{
    pd_etch *s = &a->surface_solver;
    for (int32_t p = 0; p < s->count; p++) s->split[p] = 0.0;
    int others = pdi_content_small(a->dissolve, pdi_dissolution_laws_add_component_weight, a);
    for (int32_t p = 0; p < s->count; p++)
        if (!(s->split[p] > PDI_DISSOLUTION_LAWS_COMPONENT_FRACTION * s->weight[p])) s->piece[p] = -1;
    for (int m = 0; m < s->kinds && !others; m++) {
        int32_t only = pdi_dissolution_laws_find_only_component(s, m);
        for (int32_t p = 0; p < s->count; p++)
            if (s->weight[p] > 0.0 && pdi_etch_which(s, p) == m) s->piece[p] = only >= 0 ? only : s->piece[p];
    }
}

PDI_FN pd_status pdi_dissolution_laws_solve_initial(pd_ctx *ctx, void *user, double t)
{
    pd_dissolution_laws *a = (pd_dissolution_laws *)user;
    pd_etch *s = &a->surface_solver;
    if (!s->electrode) return PD_OK;
    s->time = t;
    if (!a->dissolve) return pdi_dissolution_laws_solve_surface(ctx, a);
    a->dissolve->time = t;
    PD_TRY(pd_dissolve_prepare(ctx, a->dissolve));
    return PD_OK;
}

PDI_FN pd_status pdi_dissolution_laws_update_speeds(pd_ctx *ctx, void *user, double t)
{
    pd_dissolution_laws *a = (pd_dissolution_laws *)user;
    pd_etch *s = &a->surface_solver;
    s->time = t;
    if (a->species_integrator->begun) {
        pdi_dissolution_laws_update_weights(a);
        return PD_OK;
    }
    if (!(a->species_integrator->time > t)) return pdi_dissolution_laws_solve_surface(ctx, a);
    for (int32_t p = 0; p < s->count; p++)
        for (int m = 0; m < a->law_count; m++) *pdi_dissolution_laws_get_speed_pointer(a, m, s->node[p]) = 0.0;
    for (int32_t p = 0; p < s->count; p++) /* what the species have got in the step of the run */
        if (s->passed[p] > 0.0) *pdi_etch_speed(s, p) = s->passed[p] / (a->species_integrator->time - a->step_start);
    return pdi_dissolution_laws_update_all_speeds(ctx, a);
}

PDI_FN pd_status pdi_dissolution_laws_update_interface(pd_ctx *ctx, void *user, double t)
{
    pd_dissolution_laws *a = (pd_dissolution_laws *)user;
    if (!a->species_integrator->begun) a->step_start = t;
    if (!a->dissolve) {
        a->surface_solver.time = t;
        return a->species_integrator->begun ? PD_OK : pdi_dissolution_laws_solve_surface(ctx, a);
    }
    a->dissolve->time = t;
    PD_TRY(pd_dissolve_prepare(ctx, a->dissolve));
    if (!a->species_integrator->begun && a->law_count && a->species_integrator->desc.fed &&
        !pdi_metal_bonds(a->dissolve))
        pdi_dissolution_laws_find_components(a);
    return PD_OK;
}
