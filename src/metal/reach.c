/* reach: see reach.h */
#include "metal/reach.h"
#include "core/par.h"
#include <string.h>

/* Nodes beside metal that there is room for at least. */
#define PDI_REACH_LEAST 32

PDI_FN int32_t pdi_reach_taker(const pd_dissolve *d, int32_t j, int k)
{
    int32_t far = pdi_entry_far(&d->paths, j, k);
    if (d->grid->kind[far] != PD_FLUID || pdi_metal_passive(d, far)) return -1;
    return pdi_entry_free(&d->paths, j, k) ? far : -1;
}

PDI_FN void pdi_reach_list(pdi_array_visitor *owner, void *object)
{
    pd_dissolve *dissolve = (pd_dissolve *)object;
    int64_t words = dissolve->paths.words;
    PDI_ARRAY(owner, dissolve, reach, words * dissolve->reach_rows, "1");
}

PDI_FN pdi_beside *pdi_reach_join(pd_dissolve *d, int32_t i)
{
    if (d->slot[i] < 0) {
        pdi_beside *beside = &d->beside[d->beside_count];
        if (d->beside_count == d->beside_capacity) d->beside_lacks = 1;
        else d->slot[i] = d->beside_count++;
        memset(beside, 0, sizeof *beside);
        memset(pdi_metal_portion(d, beside), 0, (size_t)d->kinds * sizeof(pdi_metal_beside));
        beside->node = i;
        beside->fresh = 1;
        return beside;
    }
    return &d->beside[d->slot[i]];
}

PDI_FN void pdi_reach_beside_list(pdi_array_visitor *owner, void *object)
{
    pd_dissolve *dissolve = (pd_dissolve *)object;
    int64_t count = (int64_t)dissolve->beside_capacity + 1;
    PDI_ARRAY(owner, dissolve, beside, count, "");
    PDI_ARRAY(owner, dissolve, portion, count * dissolve->kinds, "");
    PDI_ARRAY(owner, dissolve, pinned, count, "1");
}

/* No node is beside metal. */
static void pdi_reach_forget(pd_dissolve *d)
{
    for (int32_t i = 0; i < d->grid->total; i++) d->slot[i] = -1;
    d->beside_count = d->beside_lacks = d->reach_used = d->lasts = 0;
    d->transport->pinned_count = 0;
}

PDI_FN pd_status pdi_reach_make_room(pd_ctx *ctx, pd_dissolve *d, int32_t count)
{
    if (d->beside && count <= d->beside_capacity) return PD_OK;
    pdi_reach_forget(d);
    pd_status status = pdi_array_registry_rebuild(ctx, pdi_reach_beside_list, d, &d->beside_capacity, count);
    d->transport->pinned = d->pinned;
    return status;
}

PDI_FN pd_status pdi_reach_make_more(pd_ctx *ctx, pd_dissolve *d)
{
    int64_t more = (int64_t)d->beside_capacity + d->beside_capacity / 4 + PDI_REACH_LEAST;
    return pdi_reach_make_room(ctx, d, (int32_t)(more < d->grid->total ? more : d->grid->total));
}

/* Forget all rows and all fluid beside metal, and make room for the metal that is exposed now. */
static pd_status pdi_reach_restart(pd_ctx *ctx, pd_dissolve *d)
{
    int64_t room = d->front_count + (int64_t)d->front_count / 4 + 1;
    pdi_reach_forget(d);
    if (room <= d->reach_rows) return PD_OK;
    return pdi_array_registry_rebuild(ctx, pdi_reach_list, d, &d->reach_rows,
                                      (int32_t)(room < INT32_MAX ? room : INT32_MAX));
}

/* Rows for exposed nodes that have none. 0: there are too few. */
static int pdi_reach_rows(pd_dissolve *d)
{
    for (int32_t f = 0; f < d->front_count; f++) {
        int32_t j = d->front[f];
        if (d->slot[j] >= 0) continue;
        if (d->reach_used == d->reach_rows) return 0;
        d->slot[j] = d->reach_used++;
    }
    return 1;
}

/* The row of exposed node j. Its rate is not known. */
static void pdi_reach_row(const pd_dissolve *d, int32_t j)
{
    int words = d->paths.words;
    uint32_t *row = d->reach + (int64_t)d->slot[j] * words;
    for (int w = 0; w < words; w++) row[w] = 0;
    for (int k = 0; k < d->paths.stencil->count; k++)
        if (pdi_reach_taker(d, j, k) >= 0) row[k >> 5] |= (uint32_t)1 << (k & 31);
    d->rate[j] = -1.0;
}

/* Fluid at the ends of the bonds of node j is beside metal. */
static void pdi_reach_join_all(pd_dissolve *d, int32_t j)
{
    pdi_reach reach = pdi_reach_of(d, j);
    while (pdi_reach_next(&reach)) pdi_reach_join(d, pdi_entry_far(&d->paths, j, reach.bond));
}

/* What enters at a node beside metal, by its own bonds: c(n) at both ends of a bond is the same number but for their
 * circumferences, and behind sides of rings. */
static void pdi_reach_gather(const pd_dissolve *d, pdi_beside *beside)
{
    int32_t i = beside->node;
    pdi_metal_beside *portion = pdi_metal_portion(d, beside);
    beside->enters = beside->touch = 0.0;
    for (int m = 0; m < d->kinds; m++) portion[m].enters = portion[m].stock = 0.0;
    if (pdi_metal_passive(d, i)) return;
    for (int k = 0; k < d->paths.stencil->count; k++) {
        int32_t j = pdi_entry_far(&d->paths, i, k);
        if (d->grid->kind[j] != PD_SOLID || !pdi_entry_free(&d->paths, i, k)) continue;
        double weight = pdi_metal_supply(d, j) * pdi_metal_gives(d, j) * pdi_metal_area_beside(d, i, k, j);
        pdi_metal_beside *own = &portion[pdi_metal_of(d, j)];
        beside->enters += weight;
        own->enters += weight;
        own->stock += weight * d->transport->c[j];
    }
}

/* What pieces of metal that did not last gave to a node is no more. A node that metal has left has no line. */
static void pdi_reach_again(const pd_dissolve *d, pdi_beside *beside)
{
    beside->given = 0.0;
    beside->weight = beside->enters;
    if (!(beside->enters > 0.0)) memset(&beside->point, 0, sizeof beside->point);
    for (int m = 0; m < d->kinds; m++) {
        pdi_metal_beside *portion = &pdi_metal_portion(d, beside)[m];
        portion->mean = portion->speed = portion->used = portion->used_stock = portion->paid = 0.0;
        portion->weight = portion->enters;
    }
}

/* Rows of exposed nodes, of all or of touched ones, and the fluid that they lead to, as far as there is room. */
static pd_status pdi_reach_find(pd_ctx *ctx, pd_dissolve *d, int all)
{
    int nt = pd_par_threads(ctx, (int64_t)d->front_count * d->paths.stencil->count);
    (void)nt;
    if (all) PD_TRY(pdi_reach_restart(ctx, d));
    if (all) pdi_reach_rows(d);
    PD_PARALLEL_FOR(nt)
    for (int32_t f = 0; f < d->front_count; f++)
        if (all || (d->mark[d->front[f]] & PDI_REACH_TOUCHED)) pdi_reach_row(d, d->front[f]);
    for (int32_t f = 0; f < d->front_count; f++)
        if (all || (d->mark[d->front[f]] & PDI_REACH_TOUCHED)) pdi_reach_join_all(d, d->front[f]);
    return PD_OK;
}

PDI_FN pd_status pdi_reach_update(pd_ctx *ctx, pd_dissolve *d)
{
    int nt = pd_par_threads(ctx, (int64_t)d->front_count * d->paths.stencil->count);
    int all = !d->reached, contents = d->desc.drive == PD_DRIVE_DIFFERENCE;
    (void)nt;
    d->reached = 0; /* unless all goes well */
    if (!all && d->lags) all = !pdi_reach_rows(d);
    PD_TRY(pdi_reach_find(ctx, d, all));
    while (d->beside_lacks) {
        all = 1;
        PD_TRY(pdi_reach_make_more(ctx, d));
        PD_TRY(pdi_reach_find(ctx, d, all));
    }
    PD_PARALLEL_FOR(nt)
    for (int32_t n = 0; n < d->beside_count; n++) {
        pdi_beside *beside = &d->beside[n];
        int touched = all || contents || (d->mark[beside->node] & PDI_REACH_TOUCHED);
        if (touched) pdi_reach_gather(d, beside);
        if (touched || d->gone_count) pdi_reach_again(d, beside);
    }
    d->reached = 1;
    return PD_OK;
}

#undef PDI_REACH_LEAST
