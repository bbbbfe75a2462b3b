/* etch: see etch.h */
#include "react/etch.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Least diffusivity of a species in the film, over the mean one. */
#define PDI_ETCH_LEAST 1e-6
/* Share of a piece of metal to which steps end where it is used up. */
#define PDI_ETCH_MET 1e-9
/* Share of a time by which that of a stage lies before it: some roundings. */
#define PDI_ETCH_BEFORE 1e-15

void pd_etch_open(pd_etch *s)
{
    for (int32_t p = 0; p < s->count; p++) s->slot[s->node[p]] = -1;
    s->count = s->pieces = 0;
}

void pd_etch_put(pd_etch *s, int32_t node, double weight, double thick)
{
    if (s->slot[node] < 0) s->slot[node] = s->count;
    s->node[s->count] = node;
    s->weight[s->count] = weight;
    if (s->metal) s->metal[s->count] = 0;
    s->ahead[s->count] = s->passed[s->count] = 0.0;
    s->piece[s->count] = -1;
    if (s->open) s->open[s->count] = 0;
    if (s->electrode) {
        s->electrode[s->count] = -1;
        s->area[s->count] = s->way[s->count] = s->gave[s->count] = 0.0;
        s->drive[s->count] = s->flow_drive[s->count] = 0.0f; /* what was found before is of other places */
        if (s->share) s->share[s->count] = 1.0;
    }
    s->rise[s->count] = s->surface ? s->desc.solid / s->reactive->diffusion.desc.diffusivity : 0.0;
    s->thick[s->count++] = thick;
}

PDI_FN void pdi_etch_polarise(pd_etch *s, int metal, int electrode, double area, double way)
{
    int32_t p = s->count - 1;
    double d = s->reactive->diffusion.desc.diffusivity;
    if (s->metal) s->metal[p] = (uint8_t)metal;
    s->electrode[p] = electrode;
    s->area[p] = area;
    s->way[p] = d > 0.0 ? way / d : 0.0;
}

PDI_FN int32_t pdi_etch_law(const pd_etch *s, int metal, int32_t i)
{
    for (int32_t p = s->slot[i]; p >= 0 && p < s->count && s->node[p] == i; p++)
        if (s->weight[p] > 0.0 && pdi_etch_which(s, p) == metal) return p;
    return -1;
}

PDI_FN void pdi_etch_begin(pd_etch *s)
{
    int64_t total = s->reactive->grid->total;
    for (int32_t p = 0; p < s->count; p++) s->ahead[p] = 0.0;
    for (int e = 0; e < 2 * s->desc.electrodes.count; e++) s->charge_ahead[e] = 0.0;
    s->odd = 0;
    for (int k = 0; k < s->reactive->components.count && s->sweep; k++)
        for (int32_t p = 0; p < s->count; p++) s->sweep[k * total + p] = 0.0;
}

/* What a law does at an instant begins with it: a step that ends there has none of it. */
PDI_FN pd_status pdi_etch_stage(pd_ctx *ctx, pd_etch *s, double share)
{
    if (s && s->span > 0.0) s->time = (s->from + share * s->span) * (1.0 - PDI_ETCH_BEFORE);
    return s && s->stage ? s->stage(ctx, s->stager, share) : PD_OK;
}

/* Electrons of electrodes in dt [s] at the present speeds: of the laws of their metal and of their curves. */
static void pdi_etch_electrons(pd_etch *s, double dt)
{
    const pd_reactive *r = s->reactive;
    double cells = dt * r->bonds->stencil->volume;
    for (int32_t p = 0; p < s->count && s->electrode; p++) {
        double electrons = 0.0, around = cells * pd_grid_circumference(r->grid, s->node[p]);
        int e = s->electrode[p];
        if (e < 0) continue;
        const double *part = s->part + e * r->components.solutes;
        for (int n = 0; n < r->components.solutes; n++) electrons += r->components.charge[n] * part[n];
        double law = s->weight[p] > 0.0 ? pdi_etch_of(s, p)->charge * s->weight[p] * *pdi_etch_speed(s, p) : 0.0;
        double curve = electrons * s->area[p] * s->flow[p];
        s->charge_ahead[2 * e] += around * (law + curve);
        s->charge_ahead[2 * e + 1] += around * (pd_max(law, 0.0) + pd_max(curve, 0.0));
    }
}

PDI_FN void pdi_etch_pass(pd_etch *s, double dt)
{
    pd_reactive *r = s->reactive;
    pdi_etch_electrons(s, dt);
    for (int m = 0; m < s->kinds; m++) {
        pdi_compensated_sum sum = {0.0, 0.0};
        for (int32_t p = 0; p < s->count; p++) {
            double v = *pdi_etch_speed(s, p);
            if (!(s->weight[p] > 0.0) || pdi_etch_which(s, p) != m) continue;
            s->ahead[p] += dt * v;
            for (int64_t k = 0, at = p; k < r->components.count && s->sweep; k++, at += r->grid->total)
                s->sweep[at] += dt * s->weight[p] * v / s->desc.solid * s->surface[at];
            pdi_compensated_sum_add(&sum, pd_grid_circumference(r->grid, s->node[p]) * s->weight[p] * v);
        }
        double given = dt * r->bonds->stencil->volume * pdi_compensated_sum_total(&sum);
        for (int n = 0; n < r->components.solutes; n++) r->in[n] += given * s->kind[m].shed[n];
    }
    for (int e = 0; e < s->desc.electrodes.count; e++) {
        pdi_compensated_sum flows = {0.0, 0.0};
        for (int32_t p = 0; p < s->count; p++)
            if (s->electrode[p] == e)
                pdi_compensated_sum_add(&flows, pd_grid_circumference(r->grid, s->node[p]) * s->area[p] * s->flow[p]);
        double amount = dt * r->bonds->stencil->volume * pdi_compensated_sum_total(&flows);
        for (int n = 0; n < r->components.solutes; n++) {
            double gain = amount * s->part[e * r->components.solutes + n];
            r->in[n] += pd_max(gain, 0.0);
            r->out[n] += pd_max(-gain, 0.0);
        }
    }
}

PDI_FN void pdi_etch_yield(pd_etch *s)
{
    for (int32_t p = 0; p < s->count; p++)
        s->split[p] = s->weight[p] * pd_max(-pdi_etch_of(s, p)->charge * (double)s->drive[p], 0.0) +
                      (s->electrode ? s->area[p] * pd_max(-(double)s->flow_drive[p], 0.0) : 0.0);
}

PDI_FN void pdi_etch_note(pd_etch *s)
{
    for (int32_t p = 0; p < s->count && s->gave; p++)
        s->gave[p] = s->weight[p] > 0.0 ? s->weight[p] * *pdi_etch_speed(s, p) : 0.0;
}

/* What fills the volume that metal has left follows the surface: it goes to the node or comes from there, with the next
 * step. A share of it, so that steps of any length are stable, and at most half of what the node has. */
static void pdi_etch_even(pd_etch *s, int32_t p)
{
    pd_reactive *r = s->reactive;
    int64_t total = r->grid->total;
    int32_t i = s->node[p];
    double part = 1.0 / (1.0 + fabs(s->swept[i])), excess[PD_SPECIES_MAX];
    for (int k = 0; k < r->components.count; k++) {
        double terms = 0.0;
        for (int n = 0; n < r->components.solutes; n++)
            terms += fabs(r->components.stoichiometry[k][n]) * r->c[n * total + i];
        excess[k] = s->swept[(1 + k) * total + i] - s->swept[i] * s->surface[k * total + p];
        if (-excess[k] * part > 0.5 * terms) part = -0.5 * terms / excess[k];
    }
    for (int k = 0; k < r->components.count; k++) {
        s->swept[(1 + k) * total + i] -= part * excess[k];
        r->carry[k * total + i] += part * excess[k];
    }
}

PDI_FN double pdi_etch_lasts(pd_etch *s, int *used)
{
    int64_t total = s->reactive->grid->total;
    double share = 1.0, *before = s->has + total, *now = s->has + 2 * total;
    *used = 0;
    for (int32_t k = 0; k < s->pieces; k++) before[k] = now[k] = 0.0;
    for (int32_t p = 0; p < s->count && s->pieces; p++) {
        double weight = pd_grid_circumference(s->reactive->grid, s->node[p]) * s->weight[p];
        if (s->piece[p] < 0 || !(s->weight[p] > 0.0)) continue;
        before[s->piece[p]] += weight * s->passed[p];
        now[s->piece[p]] += weight * s->ahead[p];
    }
    for (int32_t k = 0; k < s->pieces; k++) {
        double has = s->has[k];
        if (!(has > 0.0) || !(before[k] + now[k] >= has)) continue;
        if (before[k] + now[k] <= has * (1.0 + PDI_ETCH_MET)) *used = 1;
        else share = pd_min(share, pd_max(has * (1.0 + 0.5 * PDI_ETCH_MET) - before[k], 0.0) / now[k]);
    }
    return share;
}

/* Electrons that curves take of late, by electrode; of no step without any. */
static void pdi_etch_cathodes(pd_etch *s)
{
    int some = 0;
    for (int32_t p = 0; p < s->count && !some; p++) some = s->electrode[p] >= 0 && s->flow[p] < 0.0;
    for (int e = 0; some && e < s->desc.electrodes.count; e++) {
        pdi_compensated_sum sum = {0.0, 0.0};
        for (int32_t p = 0; p < s->count; p++)
            if (s->electrode[p] == e && s->flow[p] < 0.0)
                pdi_compensated_sum_add(&sum, -s->flow[p] * s->area[p] *
                                                  pd_grid_circumference(s->reactive->grid, s->node[p]));
        s->cathode[e] = s->reactive->bonds->stencil->volume * pdi_compensated_sum_total(&sum);
    }
}

PDI_FN void pdi_etch_bounds(const pd_reactive *r, int n, pdi_bounds *bounds)
{
    int64_t total = r->grid->total;
    pdi_bounds source = {0.0, 0.0};
    pdi_bounds_take_all(r->grid, PD_FLUID, r->source + n * total, &source);
    for (int m = 0; r->surface && m < r->surface->kinds; m++) pdi_bounds_take(r->surface->kind[m].shed[n], &source);
    if (source.low < 0.0) bounds->low = -HUGE_VAL;
    if (source.high > 0.0) bounds->high = HUGE_VAL;
}

PDI_FN void pdi_etch_whole(const pd_etch *s, double *shed)
{
    const pd_components *of = &s->reactive->components;
    int electrodes = s->electrode ? s->desc.electrodes.count : 0;
    double charge = 0.0, all = 0.0;
    for (int n = 0; n < of->solutes; n++) charge += of->charge[n] * shed[n];
    for (int e = 0; e < electrodes; e++) all += s->cathode[e];
    for (int e = 0; e < electrodes && all > 0.0; e++)
        for (int n = 0; n < of->solutes; n++)
            shed[n] -= charge * s->cathode[e] / all * s->part[e * of->solutes + n];
}

PDI_FN void pdi_etch_accept(pd_etch *s)
{
    int64_t total = s->reactive->grid->total;
    if (s->electrode) pdi_etch_cathodes(s);
    for (int32_t p = 0; p < s->count; p++) s->passed[p] += s->ahead[p];
    for (int e = 0; e < 2 * s->desc.electrodes.count; e++) s->charge[e] += s->charge_ahead[e];
    for (int32_t p = 0; p < s->count && s->swept; p++) {
        if (!(s->weight[p] > 0.0)) continue;
        s->swept[s->node[p]] += s->ahead[p] * s->weight[p] / s->desc.solid;
        for (int k = 0; k < s->reactive->components.count; k++)
            s->swept[(1 + k) * total + s->node[p]] += s->sweep[k * total + p];
        pdi_etch_even(s, p);
    }
    pdi_etch_note(s);
    pdi_etch_begin(s);
}

/* ---- cells that turn ---- */

/* Far end of bond k of fluid node i, which is metal, or fluid that the bond is open to. -1: it is neither. */
static int32_t pdi_etch_far(const pd_etch *s, int32_t i, int k)
{
    const pd_bond_paths *paths = &s->reactive->bonds->paths;
    int32_t far = pd_grid_find_source(paths->grid, i + paths->shift[k], NULL);
    if (far < 0 || far == i) return -1;
    if (paths->grid->kind[far] == PD_SOLID) return far;
    return paths->grid->kind[far] == PD_FLUID && pdi_bond_path_find_closed_group(paths, i, k) < 0 ? far : -1;
}

/* What metal left beside the cell of node i goes to cells that have turned, `split` of which is 1, in the share that
 * they are of its bonds to metal and to them. */
static void pdi_etch_hand(pd_etch *s, int32_t i)
{
    const pd_reactive *r = s->reactive;
    const pd_stencil *of = r->bonds->stencil;
    int64_t total = r->grid->total;
    double metal = 0.0, turned = 0.0, part[1 + PD_SPECIES_MAX];
    for (int k = 0; k < of->count; k++) {
        int32_t j = pdi_etch_far(s, i, k);
        if (j >= 0 && r->grid->kind[j] == PD_SOLID) metal += of->laplacian_weight[k];
        else if (j >= 0) turned += of->laplacian_weight[k] * s->split[j];
    }
    if (!(turned > 0.0)) return;
    for (int n = 0; n <= r->components.count; n++) {
        part[n] = s->swept[n * total + i] / (metal + turned);
        s->swept[n * total + i] = metal * part[n];
    }
    for (int k = 0; k < of->count; k++) {
        int32_t j = pdi_etch_far(s, i, k);
        if (j < 0 || r->grid->kind[j] != PD_FLUID) continue;
        double around = pd_grid_circumference(r->grid, i) / pd_grid_circumference(r->grid, j);
        double share = around * of->laplacian_weight[k] * s->split[j];
        for (int n = 0; n <= r->components.count; n++) s->swept[n * total + j] += share * part[n];
    }
}

/* Totals at the middle of a cell that has turned: between those of the fluid beside it and of its surface, which was
 * behind. 0: there is no fluid. */
static int pdi_etch_between(const pd_etch *s, int32_t j, double *sum)
{
    const pd_reactive *r = s->reactive;
    const pd_stencil *of = r->bonds->stencil;
    int64_t total = r->grid->total;
    double all = 0.0, c[PD_SPECIES_MAX], own[PD_SPECIES_MAX];
    memset(sum, 0, PD_SPECIES_MAX * sizeof *sum);
    for (int beside = 1; beside >= 0 && !(all > 0.0); beside--)
        for (int k = 0; k < of->count; k++) {
            int32_t i = pdi_etch_far(s, j, k), p = i < 0 ? -1 : pdi_etch_law(s, 0, i);
            if (i < 0 || r->grid->kind[i] != PD_FLUID || s->split[i] > 0.0 || (beside && p < 0)) continue;
            double film = p < 0 ? 0.0 : s->thick[p] * r->diffusion.desc.diffusivity / s->desc.solid;
            double way = pdi_vec_norm(of->xi + k * PD_DIM), share = film > way ? way / film : 1.0;
            pd_reactive_get(r, r->c, i, c);
            pdi_components_compute_totals(&r->components, c, own);
            all += of->laplacian_weight[k];
            for (int n = 0; n < r->components.count; n++)
                sum[n] +=
                    of->laplacian_weight[k] * (p < 0 ? own[n] : own[n] + share * (s->surface[n * total + p] - own[n]));
        }
    for (int n = 0; n < r->components.count; n++) sum[n] /= all > 0.0 ? all : 1.0;
    return all > 0.0;
}

/* A cell that has turned begins with what fills it, at those totals; `split` grows by the share that it lacks. */
static void pdi_etch_fill(pd_etch *s, int32_t j, const double *sum)
{
    pd_reactive *r = s->reactive;
    int64_t total = r->grid->total;
    double c[PD_SPECIES_MAX], holds[PD_SPECIES_MAX], part = pd_min(pd_max(1.0 + s->swept[j], 0.0), 1.0);
    memset(c, 0, sizeof c);
    if (!sum || pdi_components_solve(&r->components, sum, c) != PD_OK) part = 0.0;
    s->split[j] += 1.0 - part;
    s->swept[j] -= part;
    pdi_migration_neutralise(&r->migration, c);
    for (int n = 0; n < r->components.solutes; n++) {
        c[n] *= part;
        r->c[n * total + j] += c[n];
    }
    pdi_components_compute_totals(&r->components, c, holds);
    for (int k = 0; k < r->components.count; k++) s->swept[(1 + k) * total + j] -= holds[k];
}

/* Where no metal is left nothing is beside the cells: the next step has it. */
static void pdi_etch_leave(pd_etch *s, int32_t i)
{
    pd_reactive *r = s->reactive;
    int64_t total = r->grid->total;
    for (int k = 0; k < r->bonds->stencil->count; k++) {
        int32_t j = pdi_etch_far(s, i, k);
        if (j >= 0 && r->grid->kind[j] == PD_SOLID) return;
    }
    s->swept[i] = 0.0;
    for (int k = 0; k < r->components.count; k++) {
        r->carry[k * total + i] += s->swept[(1 + k) * total + i];
        s->swept[(1 + k) * total + i] = 0.0;
    }
}

PDI_FN void pdi_etch_turn(pd_etch *s, const int32_t *turned, int32_t count)
{
    const pd_reactive *r = s->reactive;
    int32_t total = (int32_t)r->grid->total;
    for (int32_t i = 0; i < total; i++) s->split[i] = 0.0;
    for (int32_t n = 0; n < count; n++) s->split[turned[n]] = 1.0;
    for (int32_t i = 0; i < total; i++)
        if (r->grid->kind[i] == PD_FLUID && !(s->split[i] > 0.0) && fabs(s->swept[i]) > 0.0) pdi_etch_hand(s, i);
    for (int32_t n = 0; n < count; n++) {
        double sum[PD_SPECIES_MAX];
        pdi_etch_fill(s, turned[n], pdi_etch_between(s, turned[n], sum) ? sum : NULL);
    }
    for (int32_t n = 0; n < count; n++) s->split[turned[n]] -= 1.0;
    for (int32_t i = 0; i < total; i++)
        if (r->grid->kind[i] == PD_FLUID && fabs(s->swept[i]) > 0.0) pdi_etch_leave(s, i);
}

/* ---- the object ---- */

PDI_COLD_BEGIN
PDI_FN void pdi_etch_list(pdi_array_visitor *owner, void *object)
{
    pd_etch *etch = (pd_etch *)object;
    if (!etch->reactive) return;
    int64_t total = etch->reactive->grid->total;
    PDI_ARRAY(owner, etch, kind, etch->kinds, "");
    if (etch->kinds > 1) PDI_ARRAY(owner, etch, metal, total, "1");
    PDI_ARRAY(owner, etch, node, total, "1");
    PDI_ARRAY(owner, etch, slot, total, "1");
    PDI_ARRAY(owner, etch, weight, total, "mol/m4");
    PDI_ARRAY(owner, etch, thick, total, "mol s/m4");
    PDI_ARRAY(owner, etch, rise, total, "mol s/m5");
    PDI_ARRAY_STATE(owner, etch, speed, etch->kinds * total, "m/s");
    PDI_ARRAY(owner, etch, ahead, total, "m");
    PDI_ARRAY(owner, etch, passed, total, "m");
    PDI_ARRAY(owner, etch, split, total, "m/s");
    PDI_ARRAY(owner, etch, piece, total, "1");
    PDI_ARRAY(owner, etch, has, 3 * total, "mol/m3");
    PDI_ARRAY(owner, etch, by, etch->reactive->components.count * total, "m4/mol/s");
    const pd_etch_electrodes *of = &etch->desc.electrodes;
    if (etch->reactive->migration.on) {
        PDI_ARRAY(owner, etch, drive, total, "m/s");
        PDI_ARRAY(owner, etch, open, total, "1");
        PDI_ARRAY(owner, etch, ways, total, "1");
        PDI_ARRAY(owner, etch, way_of, total + of->circuits + 1, "1");
        PDI_ARRAY(owner, etch, joined, total + of->circuits + 1, "1");
    }
    if (etch->desc.solid > 0.0 && etch->reactive->migration.on) {
        PDI_ARRAY(owner, etch, surface, etch->reactive->components.count * total, "mol/m3");
        PDI_ARRAY(owner, etch, sweep, etch->reactive->components.count * total, "mol/m3");
        PDI_ARRAY_STATE(owner, etch, swept, (1 + etch->reactive->components.count) * total, "mol/m3");
    }
    if (!of->count) return;
    PDI_ARRAY(owner, etch, part, of->count * etch->reactive->components.solutes, "1");
    PDI_ARRAY(owner, etch, part_gain, of->count * etch->reactive->components.count, "1");
    PDI_ARRAY(owner, etch, electrode, total, "1");
    PDI_ARRAY(owner, etch, area, total, "1/m");
    PDI_ARRAY(owner, etch, way, total, "s/m");
    if (of->shares) PDI_ARRAY(owner, etch, share, total, "1");
    PDI_ARRAY_STATE(owner, etch, flow, total, "mol/m2/s");
    PDI_ARRAY(owner, etch, gave, total, "mol/m3/s");
    PDI_ARRAY(owner, etch, flow_by, etch->reactive->components.count * total, "m/s");
    PDI_ARRAY(owner, etch, flow_drive, total, "mol/m2/s");
    PDI_ARRAY(owner, etch, side, 2 * total, "1");
    PDI_ARRAY_STATE(owner, etch, level, of->circuits, "V");
    PDI_ARRAY_STATE(owner, etch, conduct, of->circuits, "mol/s/V");
    PDI_ARRAY(owner, etch, charge_of, of->circuits, "mol/s");
    PDI_ARRAY_STATE(owner, etch, charge, 2 * of->count, "mol");
    PDI_ARRAY(owner, etch, charge_ahead, 2 * of->count, "mol");
    PDI_ARRAY_STATE(owner, etch, cathode, of->count, "mol/s");
    PDI_SCALAR_STATE(owner, etch, extra, "mol/s");
}

/* The system of concentrations times their diffusivities: ln c' = ln K + ln d + sum m (ln c'_master - ln d_master). */
PDI_FN void pdi_etch_film(const pd_reactive *r, pd_components *film, double *scale)
{
    const pd_components *of = &r->components;
    *film = *of;
    film->debye_hueckel = 0.0;
    for (int n = 0; n < of->solutes; n++) scale[n] = pd_max(r->ratio[n], PDI_ETCH_LEAST);
    for (int n = 0; n < of->solutes; n++) {
        film->ln_k[n] += log(scale[n]);
        for (int k = 0; k < of->equilibrium_components; k++)
            film->ln_k[n] -= of->stoichiometry[k][n] * log(scale[of->component_solute[k]]);
    }
}

PDI_FN void pdi_etch_activities(const pd_components *of, const pd_components *film, double davies, pd_components *now)
{
    for (int n = 0; n < of->solutes; n++) {
        now->ln_k[n] = film->ln_k[n] - of->charge[n] * of->charge[n] * davies;
        for (int k = 0; k < of->equilibrium_components; k++) {
            int z = of->charge[of->component_solute[k]];
            now->ln_k[n] += of->stoichiometry[k][n] * z * z * davies;
        }
    }
    for (int k = 0; k < of->equilibrium_components; k++) now->ln_k[of->component_solute[k]] = 0.0;
}

/* What electrodes bring, of solutes and of totals. */
static void pdi_etch_parts(pd_etch *s)
{
    const pd_reactive *r = s->reactive;
    const pd_etch_electrodes *of = &s->desc.electrodes;
    for (int e = 0; e < of->count; e++) {
        double *part = s->part + e * r->components.solutes;
        for (int i = 0; i < r->desc.count; i++)
            if (r->components.solute_of_species[i] >= 0)
                part[r->components.solute_of_species[i]] = of->part[e * r->desc.count + i];
        pdi_components_compute_totals(&r->components, part, s->part_gain + e * r->components.count);
    }
    for (int n = 0; n < of->circuits && of->count; n++)
        if (of->circuit[n].holds) s->level[n] = of->circuit[n].value;
    s->desc.electrodes.part = NULL;
}

/* What metals bring, of solutes and of totals. */
static void pdi_etch_kinds(pd_etch *s)
{
    const pd_reactive *r = s->reactive;
    pd_etch_metal first;
    first.law = s->desc.law;
    first.user = s->desc.user;
    first.shed = s->desc.shed;
    first.reads = s->desc.reads;
    first.reads_ph = s->desc.reads_ph;
    for (int m = 0; m < s->kinds; m++) {
        pdi_etch_kind *kind = &s->kind[m];
        kind->law = m ? s->desc.more[m - 1] : first;
        for (int i = 0; i < r->desc.count && kind->law.shed; i++)
            if (r->components.solute_of_species[i] >= 0)
                kind->shed[r->components.solute_of_species[i]] = kind->law.shed[i];
        pdi_components_compute_totals(&r->components, kind->shed, kind->gain);
        for (int n = 0; n < r->components.solutes; n++)
            kind->charge += r->components.charge[n] * kind->shed[n];
        kind->law.shed = NULL;
    }
    s->desc.shed = NULL;
    s->desc.more = NULL;
}

pd_status pd_etch_build(pd_ctx *ctx, pd_reactive *r, const pd_etch_desc *desc, pd_etch *s)
{
    memset(s, 0, sizeof *s);
    if (!desc->law && !desc->more_count && !desc->electrodes.count)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "etch", "there is no law");
    if (desc->electrodes.count && !r->migration.on)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "etch", "electrodes without migration, expected it");
    if (desc->more_count < 0 || desc->more_count > UINT8_MAX || (desc->more_count && !desc->more) ||
        (desc->more_count && (!desc->electrodes.count || desc->solid > 0.0)))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "etch", "%d metals beside the first one, expected 0 to %d and their "
                       "list, with electrodes, and none that fills what it leaves", desc->more_count, UINT8_MAX);
    s->desc = *desc;
    s->reactive = r;
    s->kinds = desc->more_count + 1;
    pdi_etch_film(r, &s->film, s->scale);
    pd_status status = pdi_array_registry_build(ctx, pdi_etch_list, s);
    if (status < 0) {
        pd_etch_free(ctx, s);
        return status;
    }
    for (int32_t i = 0; i < r->grid->total; i++) s->slot[i] = -1;
    pdi_etch_kinds(s);
    pdi_etch_parts(s);
    r->surface = s;
    r->swept = s->swept ? s->swept + r->grid->total : NULL;
    r->linear = 0;
    return PD_OK;
}

void pd_etch_free(pd_ctx *ctx, pd_etch *s)
{
    if (s->reactive) {
        s->reactive->surface = NULL;
        s->reactive->swept = NULL;
    }
    pdi_array_registry_free(ctx, pdi_etch_list, s);
    memset(s, 0, sizeof *s);
}
PDI_COLD_END
