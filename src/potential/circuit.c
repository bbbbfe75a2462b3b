/* circuit: see circuit.h */
#include "potential/circuit.h"
#include "core/par.h"
#include "core/disjoint_sets.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Given currents add up to zero when they do within this share. */
#define PDI_CIRCUIT_BALANCED 1e-12

PDI_FN const char *pdi_circuit_electrode(const pd_potential *p, int electrode, char *name)
{
    if (p->desc.name) snprintf(name, PDI_CIRCUIT_NAME, "electrode %s", p->desc.name[electrode]);
    else snprintf(name, PDI_CIRCUIT_NAME, "electrode %d", electrode);
    return name;
}

PDI_FN const char *pdi_circuit_name(const pd_potential *p, int circuit, char *name)
{
    char one[PDI_CIRCUIT_NAME];
    int found = 0;
    name[0] = '\0';
    for (int e = 0; e < p->desc.electrodes; e++) {
        if (pdi_potential_circuit(p, e) != circuit) continue;
        pd_append(name, PDI_CIRCUIT_NAME, "%s%s", found++ ? " and " : "", pdi_circuit_electrode(p, e, one));
    }
    if (!found) snprintf(name, PDI_CIRCUIT_NAME, "circuit %d", circuit);
    return name;
}

PDI_FN int pdi_circuit_side(const pd_grid *grid, int32_t ghost)
{
    int i[PD_DIM];
    pd_grid_index(grid, ghost, i);
    for (int d = 0; d < PD_DIM; d++) {
        if (i[d] < 0 && pd_grid_is_inlet_or_outlet(grid->side[2 * d])) return 2 * d;
        if (i[d] >= grid->n[d] && pd_grid_is_inlet_or_outlet(grid->side[2 * d + 1])) return 2 * d + 1;
    }
    return 0;
}

static int pdi_circuit_holds(const pd_potential *p, int32_t node)
{
    if (p->diffusion.wall_rate && p->diffusion.wall_rate[node] > 0.0) return 1;
    for (int k = 0; k < p->bonds->stencil->count && p->boundary.count; k++) {
        int32_t far = node + p->bonds->paths.shift[k];
        if (!pdi_flux_open(&p->flux, node, k) || p->grid->kind[far] != PD_INLET) continue;
        if (p->desc.held[pdi_circuit_side(p->grid, far)]) return 1;
    }
    return 0;
}

/* Pockets of the electrolyte, and those of them that held sides touch. */
static void pdi_circuit_pockets(pd_potential *p)
{
    const pd_bonds *bonds = p->bonds;
    int32_t total = p->grid->total, ends = total + p->desc.circuits + 1;
    for (int32_t i = 0; i < ends; i++) p->part[i] = i;
    for (int32_t i = 0; i < total; i++) {
        if (p->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < bonds->stencil->count; k++) {
            int32_t far = i + bonds->paths.shift[k];
            if (!pdi_flux_open(&p->flux, i, k)) continue;
            if (p->grid->kind[far] == PD_IMAGE) far = pd_grid_find_source(p->grid, far, NULL);
            if (p->grid->kind[far] == PD_FLUID) pdi_disjoint_sets_merge(p->part, i, far);
        }
    }
    for (int32_t i = 0; i < total; i++)
        p->pocket[i] = p->grid->kind[i] == PD_FLUID ? pdi_disjoint_sets_find_root(p->part, i) : -1;
    for (int32_t i = 0; i < total; i++) p->fixed[i] = 0;
    for (int32_t i = 0; i < total; i++)
        if (p->pocket[i] >= 0 && pdi_circuit_holds(p, i)) p->fixed[p->pocket[i]] = 1;
}

/* Contacts of pockets where no current can pass go behind the others. */
static pd_status pdi_circuit_idle(pd_ctx *ctx, pd_potential *p, const double *low, const double *high)
{
    pd_contacts *all = &p->contacts;
    pd_contact *idle = NULL;
    int32_t kept = 0, count = 0, whole = all->count;
    for (int32_t c = 0; c < whole; c++) {
        int32_t root = p->pocket[all->list[c].node];
        count += !p->fixed[root] && !(low[root] < 0.0 && high[root] > 0.0);
    }
    if (!count) return PD_OK;
    PD_TRY(PD_NEW(ctx, "potential", count, idle));
    for (int32_t c = 0; c < whole; c++) {
        int32_t root = p->pocket[all->list[c].node];
        if (p->fixed[root] || (low[root] < 0.0 && high[root] > 0.0)) all->list[kept++] = all->list[c];
        else idle[all->idle++] = all->list[c];
    }
    memcpy(all->list + kept, idle, (size_t)count * sizeof *idle);
    all->count = kept;
    PD_DELETE(ctx, count, idle);
    return PD_OK;
}

/* The currents that the metal of each pocket can carry have to lie on both sides of zero where nothing else closes the
 * circuit. low, high [total]: of each pocket. */
static pd_status pdi_circuit_ranges(pd_ctx *ctx, pd_potential *p, double *low, double *high)
{
    char text[PDI_GRID_POSITION_LENGTH], name[PDI_CIRCUIT_NAME];
    for (int32_t c = 0; c < p->contacts.count; c++) {
        const pd_contact *contact = &p->contacts.list[c];
        int32_t root = p->pocket[contact->node];
        double least, most;
        pdi_electrode_range(&p->desc.electrode[contact->electrode], &least, &most);
        low[root] = least < 0.0 && !(low[root] < -DBL_MAX) ? low[root] + least * contact->area : low[root];
        high[root] = most > 0.0 && !(high[root] > DBL_MAX) ? high[root] + most * contact->area : high[root];
        if (least > 0.0) low[root] += least * contact->area;
        if (most < 0.0) high[root] += most * contact->area;
    }
    for (int32_t c = 0; c < p->contacts.count; c++) {
        int32_t root = p->pocket[p->contacts.list[c].node];
        if (p->fixed[root] || (low[root] < 0.0 && high[root] > 0.0)) continue;
        if (p->desc.idle) continue;
        return pd_fail(ctx, PD_ERR_STATE, "potential",
                       "the metal around the electrolyte at %s m (%s) cannot carry a "
                       "current %s: there is no solution; expected %s reaction of one of the electrodes there, or a "
                       "side that holds a potential",
                       pdi_grid_format_position(p->grid, p->contacts.list[c].node, text),
                       pdi_circuit_electrode(p, p->contacts.list[c].electrode, name),
                       low[root] < 0.0 ? "out of itself" : "into itself",
                       low[root] < 0.0 ? "an anodic" : "a cathodic");
    }
    return pdi_circuit_idle(ctx, p, low, high);
}

/* Circuits join what they touch; given potentials are all joined to ground. */
static void pdi_circuit_parts(pd_potential *p)
{
    int32_t total = p->grid->total, ground = total + p->desc.circuits;
    for (int32_t c = 0; c < p->contacts.count; c++)
        pdi_disjoint_sets_merge(p->part, p->contacts.list[c].node,
                                total + pdi_potential_circuit(p, p->contacts.list[c].electrode));
    for (int n = 0; n < p->desc.circuits; n++)
        if (p->desc.circuit[n].control == PD_CIRCUIT_POTENTIAL) pdi_disjoint_sets_merge(p->part, total + n, ground);
    for (int32_t i = 0; i < total; i++)
        if (p->fixed[i]) pdi_disjoint_sets_merge(p->part, i, ground);
    for (int32_t i = 0; i <= ground; i++) p->part[i] = pdi_disjoint_sets_find_root(p->part, i);
    for (int32_t i = 0; i <= ground; i++) p->wet[i] = 0;
    for (int32_t i = total; i <= ground; i++) p->wet[p->part[i]] = 1;
    p->floating = 0;
    for (int n = 0; n < p->desc.circuits; n++) {
        int32_t part = p->part[total + n];
        int first = part != p->part[ground];
        for (int before = 0; before < n; before++) first = first && p->part[total + before] != part;
        p->place[n] = p->desc.circuit[n].control == PD_CIRCUIT_POTENTIAL || first ? -1 : p->floating++;
    }
}

PDI_FN void pdi_circuit_raise(pd_potential *p)
{
    double *sum = p->step, *weight = p->along;
    for (int32_t i = 0; i < p->grid->total; i++) sum[i] = weight[i] = 0.0;
    for (int32_t i = 0; i < p->grid->total; i++) {
        if (p->pocket[i] < 0) continue;
        double around = pd_grid_circumference(p->grid, i);
        sum[p->pocket[i]] += around * p->phi[i];
        weight[p->pocket[i]] += around;
    }
    for (int32_t i = 0; i < p->grid->total; i++) {
        if (p->pocket[i] != i) continue;
        sum[i] = p->fixed[i] ? 0.0 : sum[i] / weight[i];
        p->level[i] += sum[i];
    }
    for (int32_t i = 0; i < p->grid->total; i++)
        if (p->pocket[i] >= 0) p->phi[i] -= sum[p->pocket[i]];
}

PDI_FN void pdi_circuit_level(pd_potential *p)
{
    int32_t total = p->grid->total, ground = p->part[total + p->desc.circuits];
    for (int n = 0; n < p->desc.circuits; n++) {
        int32_t part = p->part[total + n];
        int first = part != ground;
        pdi_compensated_sum sum = {0.0, 0.0}, weight = {0.0, 0.0};
        for (int before = 0; before < n; before++) first = first && p->part[total + before] != part;
        for (int32_t i = 0; i < total && first; i++) {
            if (p->grid->kind[i] != PD_FLUID || p->part[i] != part) continue;
            pdi_compensated_sum_add(&sum, p->phi[i] * pd_grid_circumference(p->grid, i));
            pdi_compensated_sum_add(&weight, pd_grid_circumference(p->grid, i));
        }
        if (!first || !(pdi_compensated_sum_total(&weight) > 0.0)) continue;
        double mean = pdi_compensated_sum_total(&sum) / pdi_compensated_sum_total(&weight);
        for (int32_t i = 0; i < total; i++)
            if (p->grid->kind[i] == PD_FLUID && p->part[i] == part) p->phi[i] -= mean;
        for (int m = 0; m < p->desc.circuits; m++)
            if (p->part[total + m] == part) p->metal[m] -= mean;
    }
    for (int32_t i = 0; i < total; i++)
        if (p->grid->kind[i] == PD_FLUID && !p->wet[p->part[i]]) p->phi[i] = 0.0;
}

/* Of a total current. */
static const char *pdi_circuit_unit(const pd_potential *p)
{
    return p->grid->circumference || PD_DIM == 3 ? "A" : PD_DIM == 2 ? "A/m" : "A/m2";
}

/* The curves of a circuit can carry its current. */
static pd_status pdi_circuit_carries(pd_ctx *ctx, const pd_potential *p, int n)
{
    double low = 0.0, high = 0.0, wanted = p->desc.circuit[n].value, volume = p->bonds->stencil->volume;
    char name[PDI_CIRCUIT_NAME];
    int touched = 0;
    for (int32_t k = 0; k < p->contacts.count; k++) {
        const pd_contact *c = &p->contacts.list[k];
        double least, most, area = pdi_potential_area(p, c) * volume;
        if (pdi_potential_circuit(p, c->electrode) != n) continue;
        pdi_electrode_range(&p->desc.electrode[c->electrode], &least, &most);
        low += area * least;
        high += area * most;
        touched = 1;
    }
    if (low < wanted && wanted < high) return PD_OK;
    if (!touched && !(fabs(wanted) > 0.0)) return PD_OK;
    pdi_circuit_name(p, n, name);
    if (!touched)
        return pd_fail(ctx, PD_ERR_STATE, "potential", "%s is to give %g %s, and no metal of it touches fluid where a "
                       "current can pass: there is no solution; expected `until` before its metal is used up, or a "
                       "current of 0", name, wanted, pdi_circuit_unit(p));
    return pd_fail(ctx, PD_ERR_STATE, "potential", "%s is to give %g %s, and its curves carry between %g and %g %s: "
                   "there is no solution; expected a current between them, a larger limit, or, for both directions, "
                   "both branches (butler_volmer)", name, wanted, pdi_circuit_unit(p), low, high,
                   pdi_circuit_unit(p));
}

/* Where no potential is given, currents add up to zero. */
static pd_status pdi_circuit_balanced(pd_ctx *ctx, const pd_potential *p, int n)
{
    int32_t total = p->grid->total, part = p->part[total + n];
    double sum = 0.0, size = 0.0;
    char name[PDI_CIRCUIT_NAME];
    if (part == p->part[total + p->desc.circuits]) return PD_OK;
    for (int m = 0; m < p->desc.circuits; m++) {
        if (p->part[total + m] != part) continue;
        sum += p->desc.circuit[m].value;
        size += fabs(p->desc.circuit[m].value);
    }
    if (fabs(sum) <= PDI_CIRCUIT_BALANCED * size) return PD_OK;
    return pd_fail(ctx, PD_ERR_STATE, "potential", "the given currents of all that %s hangs together with add up to "
                   "%g %s: there is no solution; expected a sum of zero, or a given potential of one of them or a "
                   "side",
                   pdi_circuit_name(p, n, name), sum, pdi_circuit_unit(p));
}

PDI_FN pd_status pdi_circuit_find(pd_ctx *ctx, pd_potential *p)
{
    double *range = NULL;
    int64_t size = 2 * (int64_t)p->grid->total;
    pdi_circuit_pockets(p);
    if (p->desc.apart) {
        pdi_circuit_parts(p);
        return PD_OK;
    }
    PD_TRY(PD_NEW(ctx, "potential", size, range));
    pd_status status = pdi_circuit_ranges(ctx, p, range, range + p->grid->total);
    PD_DELETE(ctx, size, range);
    if (status >= 0) pdi_circuit_parts(p);
    return status;
}

PDI_FN pd_status pdi_circuit_check(pd_ctx *ctx, const pd_potential *p)
{
    for (int n = 0; n < p->desc.circuits; n++) {
        if (p->desc.circuit[n].control == PD_CIRCUIT_CURRENT) PD_TRY(pdi_circuit_carries(ctx, p, n));
        PD_TRY(pdi_circuit_balanced(ctx, p, n));
    }
    return PD_OK;
}
