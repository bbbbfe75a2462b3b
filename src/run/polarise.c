/* polarise: see polarise.h */
#include "run/polarise.h"
#include "react/levels.h"
#include <math.h>
#include <string.h>

#define PDI_POLARISE_FARADAY 96485.33212 /* [C/mol] */
/* Bit of what curves read: pH. */
#define PDI_POLARISE_PH ((uint32_t)1 << 31)
/* [cells] Metal is looked for this far from a fluid node. */
#define PDI_POLARISE_AROUND 6

static double pdi_polarise_curve(void *user, int electrode, double share, const double *c, double ph, double drop,
                                 double t)
{
    const pd_polarise *p = (const pd_polarise *)user;
    const pd_setup_electrode *e = &p->setup->potential.electrode[electrode];
    const pd_components *s = &p->etch->reactive->components;
    double vars[PD_EXPR_VARS], u = drop, slope;
    (void)t;
    if (e->bare) return 0.0;
    if (!e->reads && !(e->film > 0.0)) return share * pd_electrode_current(&p->cell->curve[electrode], drop, NULL);
    if (!e->reads) return pdi_electrode_through(&p->cell->curve[electrode], share, drop, 0.0, &u, &slope);
    vars[0] = drop;
    vars[1] = ph;
    for (int k = 0; k < e->species; k++) vars[2 + k] = c[s->place[e->of[k]]];
    return share * pdi_expr_eval(&e->law, vars);
}

static double pdi_polarise_given(void *user, int circuit, double t)
{
    const pd_polarise *p = (const pd_polarise *)user;
    return pdi_electrodes_given(p->map, circuit, t);
}

PDI_FN pd_status pdi_polarise_build(pd_ctx *ctx, const pd_setup *setup, pd_electrode_map *map, const pd_cell *cell,
                                    const pd_reactive *reactive, pd_etch *etch, pd_polarise *p,
                                    pd_etch_electrodes *electrodes)
{
    int count = setup->potential.electrodes, species = setup->electrolyte.count;
    memset(p, 0, sizeof *p);
    memset(electrodes, 0, sizeof *electrodes);
    p->setup = setup;
    p->map = map;
    p->cell = cell;
    p->etch = etch;
    PDI_TRY(PDI_NEW(ctx, "polarise", (int64_t)count * species, p->part));
    for (int e = 0; e < count; e++) {
        const pd_setup_electrode *of = &setup->potential.electrode[e];
        for (int k = 0; k < species && of->reacts; k++) p->part[e * species + k] = of->shed[k];
        if (of->reads && (of->law.uses >> 1 & 1u)) p->reads[e] |= PDI_POLARISE_PH;
        for (int k = 0; k < of->species && of->reads; k++)
            if (of->law.uses >> (2 + k) & 1u) p->reads[e] |= (uint32_t)1 << reactive->components.place[of->of[k]];
    }
    for (int n = 0; n < map->circuits; n++) p->circuit[n].holds = map->circuit[n].control == PD_CIRCUIT_POTENTIAL;
    electrodes->count = count;
    electrodes->curve = pdi_polarise_curve;
    electrodes->given = pdi_polarise_given;
    electrodes->user = p;
    electrodes->part = p->part;
    electrodes->reads = p->reads;
    electrodes->member = map->member;
    electrodes->circuit = p->circuit;
    electrodes->circuits = map->circuits;
    for (int e = 0; e < count; e++) electrodes->shares |= setup->potential.electrode[e].shares;
    return PD_OK;
}

PDI_FN void pdi_polarise_free(pd_ctx *ctx, pd_polarise *p)
{
    if (p->setup)
        PDI_DELETE(ctx, (int64_t)p->setup->potential.electrodes * p->setup->electrolyte.count, p->part);
    memset(p, 0, sizeof *p);
}

PDI_FN int32_t pdi_polarise_node(const pd_polarise *p, int32_t first, int kind, int32_t *own)
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

PDI_FN int pdi_polarise_near(const pd_polarise *p, const pd_dissolve *dissolve, int32_t node, int kind)
{
    const pd_grid *grid = dissolve->grid;
    double nearest = HUGE_VAL, from[PD_DIM], x[PD_DIM];
    int found = 0, cells;
    pd_grid_position(grid, node, from);
    for (int k = 0; k < pdi_grid_cube(PDI_POLARISE_AROUND); k++) {
        double far = 0.0;
        int32_t i = pdi_grid_near(grid, node, PDI_POLARISE_AROUND, k, &cells);
        if (i < 0 || grid->kind[i] != PD_SOLID || pdi_metal_of(dissolve, i) != kind) continue;
        pd_grid_position(grid, i, x);
        for (int d = 0; d < PD_DIM; d++) far += (x[d] - from[d]) * (x[d] - from[d]);
        if (!(far < nearest)) continue;
        nearest = far;
        found = p->cell->metal[i];
    }
    return found;
}

/* [A] (per m in planar 2D) of a place, by law and curve; *size: of both, *anodic: of what leaves the metal. */
static double pdi_polarise_place(const pd_etch *s, int32_t k, double *size, double *anodic)
{
    const pd_reactive *r = s->reactive;
    double charge = 0.0, volume = r->bonds->stencil->volume * pdi_grid_circumference(r->grid, s->node[k]);
    for (int n = 0; n < r->components.solutes; n++)
        charge += r->components.charge[n] * s->part[s->electrode[k] * r->components.solutes + n];
    double law = PDI_POLARISE_FARADAY * volume * pdi_etch_of(s, k)->charge * s->gave[k];
    double curve = PDI_POLARISE_FARADAY * volume * charge * s->area[k] * s->flow[k];
    *size = fabs(law) + fabs(curve);
    *anodic = pdi_max(law, 0.0) + pdi_max(curve, 0.0);
    return law + curve;
}

PDI_FN void pdi_polarise_electrode(const pd_polarise *p, int electrode, pd_cell_electrode *now)
{
    const pd_etch *s = p->etch;
    int touched = 0;
    memset(now, 0, sizeof *now);
    now->potential = s->level[s->desc.electrodes.member[electrode]];
    for (int32_t k = 0; k < s->count; k++) {
        if (s->electrode[k] != electrode) continue;
        double volume = s->reactive->bonds->stencil->volume * pdi_grid_circumference(s->reactive->grid, s->node[k]);
        double area = volume * s->area[k], size, anodic, current = pdi_polarise_place(s, k, &size, &anodic);
        now->area += area;
        now->current += current;
        now->anodic += anodic;
        if (!(area > 0.0)) continue;
        now->least = touched ? pdi_min(now->least, current / area) : current / area;
        now->most = touched ? pdi_max(now->most, current / area) : current / area;
        touched = 1;
    }
    now->charge = PDI_POLARISE_FARADAY * s->charge[2 * electrode];
    now->passed = PDI_POLARISE_FARADAY * s->charge[2 * electrode + 1];
}

PDI_FN double pdi_polarise_density(const pd_polarise *p, int32_t node)
{
    const pd_etch *s = p->etch;
    double area = 0.0, current = 0.0, size, anodic;
    for (int32_t k = s->slot[node]; k >= 0 && k < s->count && s->node[k] == node; k++) {
        area += s->reactive->bonds->stencil->volume * pdi_grid_circumference(s->reactive->grid, node) * s->area[k];
        current += pdi_polarise_place(s, k, &size, &anodic);
    }
    return area > 0.0 ? current / area : (double)NAN;
}

PDI_FN double pdi_polarise_current(const pd_polarise *p, double *off)
{
    const pd_etch *s = p->etch;
    double anodic = 0.0, extra = PDI_POLARISE_FARADAY * s->extra;
    *off = 0.0;
    for (int n = 0; n < s->desc.electrodes.circuits; n++) {
        double sum = 0.0, size = 0.0, wanted = s->desc.electrodes.circuit[n].value + extra;
        for (int32_t k = 0; k < s->count; k++) {
            if (pdi_etch_circuit(s, k) != n) continue;
            double each, leaves;
            sum += pdi_polarise_place(s, k, &each, &leaves);
            size += each;
            anodic += leaves;
        }
        if (s->desc.electrodes.circuit[n].holds || !(size > 0.0)) continue;
        *off = pdi_max(*off, fabs(sum - wanted) / size);
        extra = 0.0;
    }
    return anodic;
}

PDI_FN pd_status pdi_polarise_found(pd_ctx *ctx, const pd_polarise *p)
{
    const pd_etch *s = p->etch;
    const pd_setup_potential *of = &p->setup->potential;
    if (!s->lost) return PD_OK;
    for (int e = 0; e < of->electrodes; e++) {
        if (s->desc.electrodes.member[e] != s->lost - 1) continue;
        return pdi_fail(ctx, PD_ERR_STATE, "potential", "at t = %g s no potential gives the metal of %s a total "
                        "current of %g A: its curve and its law do not carry that, or they take up more of a species "
                        "than reaches the metal; expected anodic and cathodic reactions, and a curve that falls to 0 "
                        "with the species that it takes up", s->time, of->electrode[e].name,
                        s->desc.electrodes.circuit[s->lost - 1].value);
    }
    return PD_ERR_STATE;
}
