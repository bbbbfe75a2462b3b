/* attack: see attack.h */
#include "run/attack.h"
#include "react/layer.h"
#include "react/levels.h"
#include "metal/interface.h"
#include <math.h>
#include <string.h>

/* Share of saturation by which fluid is below it and counts as saturated. */
#define PDI_ATTACK_SALT 1e-6
/* Share of the ions of a neighbour below which a node has just turned fluid. */
#define PDI_ATTACK_FRESH 0.1

/* The law at the surface beside a node. */
static double pdi_attack_law(void *user, int32_t node, const double *c, double ph, double phi, double t)
{
    const pd_attack *a = (const pd_attack *)user;
    const pd_setup_metal *metal = &a->setup->metal[a->kind];
    double vars[PD_EXPR_VARS];
    vars[0] = 0.0;
    vars[1] = t;
    pd_grid_position(a->dissolve->grid, node, vars + 2);
    vars[PDI_SETUP_GRAIN] = a->grain ? a->grain[node] : -1;
    vars[PDI_SETUP_CURRENT] = vars[PDI_SETUP_SURFACE] = 0.0;
    if (a->cell && !a->polarise.setup)
        pdi_cell_beside(a->cell, node, 0, &vars[PDI_SETUP_CURRENT], &vars[PDI_SETUP_SURFACE]);
    if (a->polarise.setup) {
        vars[PDI_SETUP_SURFACE] = -phi;
    } else if (metal->polarised) {
        double x[PD_DIM];
        memset(x, 0, sizeof x);
        vars[PDI_SETUP_SURFACE] = pdi_setup_eval(&metal->potential, x, t) - phi;
    }
    vars[PDI_SETUP_PH] = ph;
    for (int k = 0; k < metal->species; k++)
        vars[PDI_SETUP_PH + 1 + k] = c[a->etch.reactive->components.place[metal->of[k]]];
    if (a->surfaces) pdi_surfaces_values(a->surfaces, node, vars + PDI_SETUP_PH + 1 + metal->species);
    return metal->rate_scale * pdi_expr_eval(&metal->rate, vars);
}

/* Factors of curves by the states as they are. */
static pd_status pdi_attack_shares(pd_ctx *ctx, pd_attack *a)
{
    pd_etch *s = &a->etch;
    for (int32_t p = 0; p < s->count && s->share; p++)
        if (s->electrode[p] >= 0)
            PDI_TRY(pdi_surfaces_factor(ctx, a->states, s->electrode[p], s->node[p], s->time, &s->share[p]));
    return PD_OK;
}

/* Law and curves are those of time t [s], and of the states as they are. */
static pd_status pdi_attack_coated(pd_ctx *ctx, void *user, double t)
{
    pd_attack *a = (pd_attack *)user;
    a->etch.time = t;
    return pdi_attack_shares(ctx, a);
}

PDI_FN pd_status pdi_attack_build(pd_ctx *ctx, const pd_setup *setup, pd_reactive *reactive, pd_dissolve *dissolve,
                                  const pd_course *course, const pd_cell *cell, pd_electrode_map *map,
                                  pd_surfaces *surfaces, pd_attack *a)
{
    int kind = pdi_setup_attacked(setup);
    const pd_setup_metal *metal = &setup->metal[kind > 0 ? kind : 0];
    pd_etch_desc desc;
    memset(a, 0, sizeof *a);
    memset(&desc, 0, sizeof desc);
    a->kind = kind;
    if (kind >= 0) desc.law = pdi_attack_law;
    desc.user = a;
    desc.shed = setup->sheds ? setup->shed : NULL;
    desc.reads_ph = (int)(metal->rate.uses >> PDI_SETUP_PH & 1u);
    desc.reads_phi = metal->polarised && (metal->rate.uses >> PDI_SETUP_SURFACE & 1u);
    for (int k = 0; k < metal->species && kind >= 0; k++)
        if (metal->rate.uses >> (PDI_SETUP_PH + 1 + k) & 1u)
            desc.reads |= (uint32_t)1 << reactive->components.place[metal->of[k]];
    a->setup = setup;
    a->dissolve = dissolve;
    a->course = course;
    if (kind >= 0 && metal->rate.uses >> (PDI_SETUP_PH + 1 + metal->species)) a->surfaces = surfaces;
    if (surfaces && setup->migrates) {
        a->states = surfaces;
        surfaces->find = pdi_attack_coated;
        surfaces->finder = a;
    }
    a->cell = pdi_setup_electric(metal) || pdi_setup_polarises(setup) ? cell : NULL;
    if (pdi_setup_polarises(setup)) {
        desc.reads_phi = 1;
        PDI_TRY(pdi_polarise_build(ctx, setup, map, cell, reactive, &a->etch, &a->polarise, &desc.electrodes));
    }
    if (kind >= 0 && dissolve && dissolve->kinds == 1 && !pdi_metal_bonds(dissolve) && !(dissolve->kind[0].end > 0.0))
        desc.solid = dissolve->kind[0].solid;
    PDI_TRY(pd_etch_build(ctx, reactive, &desc, &a->etch));
    if (kind >= 0 && (metal->rate.uses >> PDI_SETUP_GRAIN & 1u))
        return PDI_NEW(ctx, "attack", dissolve->grid->total, a->grain);
    return PD_OK;
}

PDI_FN void pdi_attack_free(pd_ctx *ctx, pd_attack *a)
{
    if (a->dissolve) PDI_DELETE(ctx, a->dissolve->grid->total, a->grain);
    pd_etch_free(ctx, &a->etch);
    pdi_polarise_free(ctx, &a->polarise);
    memset(a, 0, sizeof *a);
}

PDI_FN double pdi_attack_rate(void *user, const pd_rate_at *at)
{
    const pd_attack *a = (const pd_attack *)user;
    return a->etch.speed[at->node];
}

/* Weight of the metal that the law is of. */
static double pdi_attack_weight(const pd_attack *a, const pdi_beside *beside)
{
    const pd_dissolve *d = a->dissolve;
    return d->kinds > 1 ? pdi_metal_portion(d, beside)[a->kind].weight : beside->weight;
}

/* Amounts of concentration that a unit of speed makes across the film, over its diffusivity [mol s/m4]. */
static double pdi_attack_thick(const pd_attack *a, const pdi_beside *beside)
{
    const pd_dissolve *d = a->dissolve;
    double diffusivity = a->etch.reactive->diffusion.desc.diffusivity;
    if (pdi_metal_bonds(d) || !(diffusivity > 0.0)) return 0.0;
    return d->kind[0].supply * (beside->flux / beside->weight) * (beside->film / beside->weight) / diffusivity;
}

static pd_status pdi_attack_lawful(pd_ctx *ctx, const pd_attack *a, int32_t node)
{
    char place[PDI_GRID_PLACE];
    double v = a->etch.speed[node];
    if (v < 1e100) return PD_OK;
    return pdi_fail(ctx, PD_ERR_STATE, "dissolve", "the rate law in pH, species or E gives %g m/s at t = %g s (node %d "
                    "at %s m, pH %.4g), expected a speed below 1e100 m/s", v, a->etch.time, (int)node,
                    pdi_grid_place(a->dissolve->grid, node, place), pd_reactive_ph(a->etch.reactive, node));
}

/* 1: a salt layer is there. What it lets pass the metal says, and species have it a step later. */
static int pdi_attack_salt(const pd_dissolve *d, int32_t node)
{
    return pdi_metal_bonds(d) && d->transport->c[node] >= d->desc.saturation * (1.0 - PDI_ATTACK_SALT);
}

/* A node that has turned fluid within the step of the run: what the species have got from the metal before it was the
 * speed there, as the mean over its bonds to those nodes. 0: it has none to them. */
static int pdi_attack_before(const pd_attack *a, int32_t i, double *speed)
{
    const pd_paths *paths = &a->etch.reactive->bonds->paths;
    double sum = 0.0, all = 0.0;
    for (int placed = 1; placed >= 0 && !(all > 0.0); placed--)
        for (int k = 0; k < paths->stencil->count; k++) {
            int32_t j = pdi_entry_far(paths, i, k);
            if (j < 0 || j == i || paths->grid->kind[j] != PD_FLUID) continue;
            if (pdi_path_closed_group(paths, i, k) >= 0) continue;
            if ((pdi_etch_law(&a->etch, j) >= 0) != placed || (!placed && !(a->etch.speed[j] > 0.0))) continue;
            sum += paths->stencil->lap[k] * a->etch.speed[j];
            all += paths->stencil->lap[k];
        }
    if (all > 0.0) *speed = sum / all;
    return all > 0.0;
}

/* Speeds beside metal: of places they are found; where there is none the law holds for the species as they are now, or,
 * when the species have moved, what they have got beside that. */
static pd_status pdi_attack_speeds(pd_ctx *ctx, pd_attack *a)
{
    const pd_dissolve *d = a->dissolve;
    pd_etch *s = &a->etch;
    for (int32_t k = 0; k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        int32_t i = beside->node;
        if (!(beside->weight > 0.0)) continue;
        int behind = a->course->time > d->time && !pdi_attack_salt(d, i);
        if (s->slot[i] < 0 && !(behind && pdi_attack_before(a, i, &s->speed[i])))
            s->speed[i] = pdi_layer_at(s, i, -1, pdi_attack_thick(a, beside), s->speed[i]);
        PDI_TRY(pdi_attack_lawful(ctx, a, i));
    }
    return PD_OK;
}

static double pdi_attack_ions(const pd_attack *a, int32_t node)
{
    const pd_components *s = &a->etch.reactive->components;
    double sum = 0.0;
    for (int n = 0; n < s->solutes; n++)
        sum += fabs((double)s->charge[n]) * a->etch.reactive->c[(int64_t)n * a->dissolve->grid->total + node];
    return sum;
}

/* A node that has just turned fluid has next to no ions that could carry a current: what its neighbours have bounds the
 * step. */
static void pdi_attack_fresh(pd_attack *a, const pdi_beside *beside)
{
    const pd_grid *grid = a->dissolve->grid;
    double own = pdi_attack_ions(a, beside->node), *speed = &a->etch.speed[beside->node];
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int32_t next = beside->node + (side % 2 ? 1 : -1) * (int32_t)grid->stride[side / 2];
        if (grid->kind[next] != PD_FLUID || !(own < PDI_ATTACK_FRESH * pdi_attack_ions(a, next))) continue;
        double there = pdi_layer_at(&a->etch, next, a->etch.slot[beside->node], pdi_attack_thick(a, beside), *speed);
        *speed = pdi_max(*speed, there);
    }
}

/* The same places within a step of the run, of metal that minerals cover otherwise. */
static void pdi_attack_again(pd_attack *a)
{
    const pd_dissolve *d = a->dissolve;
    pd_etch *s = &a->etch;
    for (int32_t p = 0; p < s->count && s->electrode; p++) {
        if (!(s->weight[p] > 0.0) || d->slot[s->node[p]] < 0) continue;
        const pdi_beside *beside = &d->beside[d->slot[s->node[p]]];
        if (beside->weight > 0.0) s->weight[p] = pdi_attack_weight(a, beside);
    }
    if (s->electrode) return;
    for (int32_t p = 0; p < s->count; p++) s->weight[p] = 0.0;
    for (int32_t k = 0; k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        int32_t p = s->slot[beside->node];
        if (p < 0 || !(beside->weight > 0.0)) continue;
        s->weight[p] = beside->weight;
        s->thick[p] = pdi_attack_thick(a, beside);
    }
}

/* A place for each electrode beside a node; the law is that of the metal with the largest area there. */
static pd_status pdi_attack_electrodes(pd_ctx *ctx, pd_attack *a)
{
    const pd_dissolve *d = a->dissolve;
    const pd_contacts *c = &a->cell->potential.contacts;
    pd_etch *s = &a->etch;
    for (int32_t k = 0, end; k < c->count; k = end) {
        int32_t own, i = c->list[k].node;
        const pdi_beside *beside = d && d->slot[i] >= 0 ? &d->beside[d->slot[i]] : NULL;
        end = pdi_polarise_node(&a->polarise, k, a->kind, &own);
        for (int32_t at = k; at < end; at++) {
            int goes = at == own && beside && pdi_attack_weight(a, beside) > 0.0;
            if (s->count == s->reactive->grid->total)
                return pdi_fail(ctx, PD_ERR_SIZE, "potential", "more contacts of electrodes than nodes");
            pd_etch_put(s, i, goes ? pdi_attack_weight(a, beside) : 0.0, goes ? pdi_attack_thick(a, beside) : 0.0);
            pdi_etch_polarise(s, c->list[at].electrode, c->list[at].area, c->list[at].way);
        }
    }
    for (int32_t k = 0; d && k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        if (s->slot[beside->node] >= 0 || !(pdi_attack_weight(a, beside) > 0.0)) continue;
        if (s->count == s->reactive->grid->total)
            return pdi_fail(ctx, PD_ERR_SIZE, "potential", "more contacts of electrodes than nodes");
        pd_etch_put(s, beside->node, pdi_attack_weight(a, beside), pdi_attack_thick(a, beside));
        pdi_etch_polarise(s, pdi_polarise_near(&a->polarise, d, beside->node, a->kind), 0.0, 0.0);
    }
    return PD_OK;
}

/* The law for the species as they are now. */
static pd_status pdi_attack_now(pd_ctx *ctx, pd_attack *a)
{
    const pd_dissolve *d = a->dissolve;
    pd_etch *s = &a->etch;
    pd_etch_open(s);
    if (s->electrode) PDI_TRY(pdi_attack_electrodes(ctx, a));
    for (int32_t k = 0; d && k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        pdi_law law;
        if (!(beside->weight > 0.0)) continue;
        if (a->grain) {
            pdi_interface_law(d, beside, &law);
            a->grain[beside->node] = law.at.grain;
        }
        if (!s->electrode && !pdi_attack_salt(d, beside->node))
            pd_etch_put(s, beside->node, beside->weight, pdi_attack_thick(a, beside));
    }
    PDI_TRY(pdi_attack_shares(ctx, a));
    s->odd = 0;
    pdi_levels_solve(ctx, s);
    pdi_etch_note(s);
    if (s->lost && s->odd) {
        s->speed[s->node[s->odd - 1]] = (double)NAN;
        return pdi_attack_lawful(ctx, a, s->node[s->odd - 1]);
    }
    if (s->electrode) PDI_TRY(pdi_polarise_found(ctx, &a->polarise));
    for (int32_t k = 0; d && k < d->beside_count && s->desc.reads_phi; k++)
        if (d->beside[k].weight > 0.0) pdi_attack_fresh(a, &d->beside[k]);
    return d ? pdi_attack_speeds(ctx, a) : PD_OK;
}

PDI_FN pd_status pdi_attack_open(pd_ctx *ctx, void *user, double t)
{
    pd_attack *a = (pd_attack *)user;
    pd_etch *s = &a->etch;
    if (!s->electrode) return PD_OK;
    s->time = t;
    if (!a->dissolve) return pdi_attack_now(ctx, a);
    a->dissolve->time = t;
    PDI_TRY(pdi_dissolve_prepare(ctx, a->dissolve));
    return PD_OK;
}

PDI_FN pd_status pdi_attack_found(pd_ctx *ctx, void *user, double t)
{
    pd_attack *a = (pd_attack *)user;
    pd_etch *s = &a->etch;
    s->time = t;
    if (a->course->begun) {
        pdi_attack_again(a);
        return PD_OK;
    }
    if (!(a->course->time > t)) return pdi_attack_now(ctx, a);
    for (int32_t p = 0; p < s->count; p++) /* what the species have got in the step of the run */
        s->speed[s->node[p]] = s->passed[p] / (a->course->time - a->begin);
    return pdi_attack_speeds(ctx, a);
}

PDI_FN pd_status pdi_attack_find(pd_ctx *ctx, void *user, double t)
{
    pd_attack *a = (pd_attack *)user;
    if (!a->course->begun) a->begin = t;
    if (!a->dissolve) {
        a->etch.time = t;
        return a->course->begun ? PD_OK : pdi_attack_now(ctx, a);
    }
    a->dissolve->time = t;
    return pdi_dissolve_prepare(ctx, a->dissolve);
}
