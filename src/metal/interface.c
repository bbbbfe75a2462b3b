/* interface: see interface.h */
#include "metal/interface.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

PDI_FN double pdi_interface_line(const pd_dissolve *d, const pdi_beside *beside)
{
    return beside->point.speed + beside->point.slope * d->transport->c[beside->node];
}

PDI_FN double pdi_interface_diffusivity(const pd_dissolve *d, int32_t i)
{
    const pd_diffusion *diffusion = &d->transport->diffusion;
    return diffusion->field ? diffusion->field[i] : diffusion->desc.diffusivity;
}

/* What crosses the film is the mean flux of the metal there. With bonds there is no film. */
PDI_FN double pdi_interface_resist(const pd_dissolve *d, const pdi_beside *beside)
{
    double diffusivity = pdi_interface_diffusivity(d, beside->node);
    if (pdi_metal_bonds(d)) return 0.0;
    double flux = pdi_metal_span(d) * (beside->flux / beside->weight), film = beside->film / beside->weight;
    return diffusivity > 0.0 ? flux * film / diffusivity : HUGE_VAL;
}

PDI_FN void pdi_interface_find(const pd_dissolve *d, int32_t j, int k, pdi_entry *entry)
{
    if (!pdi_metal_bonds(d)) {
        pdi_entry_find(d->bonds, j, k, entry);
        return;
    }
    entry->count = entry->open = 0;
    entry->far = entry->node[0] = pdi_entry_far(d->bonds, j, k);
    entry->last = j;
    if (d->grid->kind[entry->far] != PD_FLUID || pdi_metal_passive(d, entry->far)) return;
    entry->count = pdi_entry_free(d->bonds, j, k);
}

PDI_FN double pdi_interface_speed(const pd_dissolve *d, int32_t i)
{
    return d->slot[i] < 0 ? 0.0 : d->beside[d->slot[i]].mean;
}

PDI_FN double pdi_interface_weight(const pd_dissolve *d, int32_t j, int32_t i, int k, const pdi_entry *entry)
{
    return pdi_metal_span(d) * pdi_metal_factor(d, j) * (pdi_metal_area(d, j, k) / entry->count) *
           pdi_metal_over(d, j, i);
}

/* f sum c(n) v over the bonds to fluid. */
PDI_FN double pdi_interface_rate(const pd_dissolve *d, int32_t j)
{
    const pd_stencil *s = d->bonds->stencil;
    pdi_entry entry;
    double sum = 0.0;
    for (int k = 0; k < s->count; k++) {
        pdi_interface_find(d, j, k, &entry);
        for (int e = 0; e < entry.count; e++) {
            int32_t i = entry.node[e];
            sum += pdi_metal_area(d, j, k) / entry.count * pdi_metal_drive(d, j, i) * pdi_interface_speed(d, i);
        }
    }
    return sum * pdi_metal_factor(d, j);
}


PDI_FN double pdi_interface_pace(const pd_dissolve *d, int32_t j)
{
    pdi_entry entry;
    double fastest = 0.0;
    if (d->desc.drive == PD_DRIVE_CONSTANT) return pdi_interface_rate(d, j);
    for (int k = 0; k < d->bonds->stencil->count; k++) {
        pdi_interface_find(d, j, k, &entry);
        for (int e = 0; e < entry.count; e++) fastest = fmax(fastest, pdi_interface_speed(d, entry.node[e]));
    }
    return d->kernel.total * fastest * pdi_metal_factor(d, j);
}

/* Node i among the fluid beside metal. */
static pdi_beside *pdi_interface_join(pd_dissolve *d, int32_t i)
{
    if (d->slot[i] < 0) {
        d->slot[i] = d->beside_count++;
        memset(&d->beside[d->slot[i]], 0, sizeof(pdi_beside));
        d->beside[d->slot[i]].node = i;
    }
    return &d->beside[d->slot[i]];
}

/* Where the metal of node j enters the fluid. The surface stands in the last metal cell on the way, as deep as that has
 * lost metal. */
static void pdi_interface_gather(pd_dissolve *d, int32_t j)
{
    const pd_stencil *s = d->bonds->stencil;
    double way[PD_DIM];
    pdi_entry entry;
    for (int k = 0; k < s->count; k++) {
        pdi_interface_find(d, j, k, &entry);
        for (int e = 0; e < entry.count; e++) {
            double weight = pdi_interface_weight(d, j, entry.node[e], k, &entry);
            if (!(weight > 0.0)) continue;
            pdi_beside *beside = pdi_interface_join(d, entry.node[e]);
            beside->enters += weight;
            beside->stock += weight * d->transport->c[j];
            if (pdi_metal_bonds(d)) continue;
            beside->hollow += weight * fmax(1.5 - pdi_metal_left(d, entry.last), 0.0);
            beside->factor += weight * pdi_metal_factor(d, j);
            pdi_entry_mirror(&entry, e, s->xi + k * PD_DIM, way);
            for (int a = 0; a < PD_DIM; a++) beside->normal[a] += s->area[k] / entry.count * way[a];
        }
    }
}

/* A share of what enters at one node and arrives at another one, `beyond` [m] it as seen from the metal. */
typedef void (*pdi_interface_link_fn)(pd_dissolve *d, pdi_beside *from, pdi_beside *to, double share, double beyond);

/* All of them. A bond that the metal cuts carries a(n) times its way along the normal in a linear field. */
static void pdi_interface_link(pd_dissolve *d, pdi_interface_link_fn link)
{
    const pd_stencil *s = d->bonds->stencil;
    pdi_entry entry;
    for (int32_t f = 0; f < d->front_count; f++)
        for (int k = 0; k < s->count; k++) {
            pdi_entry_find(d->bonds, d->front[f], k, &entry);
            for (int e = 0; e < entry.count && entry.open; e++) {
                if (d->slot[entry.node[e]] < 0) continue;
                pdi_beside *from = &d->beside[d->slot[entry.node[e]]];
                double normal[PD_DIM];
                pdi_entry_mirror(&entry, e, from->normal, normal);
                double share = s->lap[k] * pdi_vec_dot(s->xi + k * PD_DIM, normal) / entry.count;
                if (!(from->enters > 0.0) || !(share > 0.0)) continue;
                double beyond = fmax(pdi_entry_beyond(d->bonds, k, &entry, e, normal), 0.0);
                link(d, from, pdi_interface_join(d, entry.far), share, beyond);
            }
        }
    for (int32_t n = 0; n < d->beside_count; n++) { /* metal on all sides */
        pdi_beside *beside = &d->beside[n];
        if (beside->enters > 0.0 && !(beside->links > 0.0)) link(d, beside, beside, 0.0, 0.0);
    }
}

static double pdi_interface_part(const pdi_beside *from, double share)
{
    return from->links > 0.0 ? share / from->links : 1.0;
}

static void pdi_interface_count(pd_dissolve *d, pdi_beside *from, pdi_beside *to, double share, double beyond)
{
    (void)d, (void)to, (void)beyond;
    from->links += share;
}

static void pdi_interface_arrive(pd_dissolve *d, pdi_beside *from, pdi_beside *to, double share, double beyond)
{
    double over = pdi_interface_part(from, share) * pdi_metal_over(d, from->node, to->node), cell = 0.0;
    for (int a = 0; a < PD_DIM; a++) cell = fmax(cell, fabs(from->normal[a]) * d->bonds->stencil->h[a]);
    to->weight += over * from->enters;
    to->film += over * (from->hollow * cell + from->enters * beyond);
    to->flux += over * from->factor;
}

static void pdi_interface_average(pd_dissolve *d, pdi_beside *from, pdi_beside *to, double share, double beyond)
{
    (void)beyond;
    from->mean += pdi_interface_part(from, share) * pdi_interface_line(d, to);
}

/* The speed of the metal is the mean of what the law gives where it arrives. */
PDI_FN void pdi_interface_means(pd_dissolve *d)
{
    for (int32_t n = 0; n < d->beside_count; n++) {
        pdi_beside *beside = &d->beside[n];
        beside->mean = 0.0;
        if (!pdi_metal_bonds(d)) continue;
        /* the line is that of the law times the mean drive of the bonds */
        double line = pdi_interface_line(d, beside), driven = 1.0;
        if (d->desc.drive == PD_DRIVE_DIFFERENCE)
            driven = log(d->desc.solid / d->desc.saturation) / pdi_metal_span(d) *
                     (beside->stock / beside->weight - d->transport->c[beside->node]);
        beside->mean = driven > 0.0 ? line / driven : 0.0;
    }
    if (!pdi_metal_bonds(d)) pdi_interface_link(d, pdi_interface_average);
}

/* What of it belongs to pieces of metal that do not last the step is given once for all. */
static void pdi_interface_pay(pd_dissolve *d, pdi_beside *from, pdi_beside *to, double share, double beyond)
{
    double over = pdi_interface_part(from, share) * pdi_metal_over(d, from->node, to->node);
    (void)beyond;
    to->given += over * from->paid * pdi_interface_line(d, to);
    to->weight = fmax(to->weight - over * from->used, 0.0);
}

PDI_FN void pdi_interface_land(pd_dissolve *d)
{
    for (int32_t k = 0; k < d->beside_count; k++) d->slot[d->beside[k].node] = -1;
    d->beside_count = 0;
    for (int32_t f = 0; f < d->front_count; f++) pdi_interface_gather(d, d->front[f]);
    for (int32_t n = 0; n < d->beside_count; n++) {
        double *normal = d->beside[n].normal, length = pdi_vec_norm(normal);
        for (int a = 0; a < PD_DIM && length > 0.0; a++) normal[a] /= length;
        if (pdi_metal_bonds(d)) d->beside[n].weight = d->beside[n].enters;
    }
    if (pdi_metal_bonds(d)) return;
    pdi_interface_link(d, pdi_interface_count);
    pdi_interface_link(d, pdi_interface_arrive);
}

PDI_FN void pdi_interface_spare(pd_dissolve *d)
{
    for (int32_t n = 0; n < d->beside_count && pdi_metal_bonds(d); n++) {
        pdi_beside *beside = &d->beside[n];
        beside->given += beside->paid * beside->mean;
        beside->weight = fmax(beside->weight - beside->used, 0.0);
        beside->stock = fmax(beside->stock - beside->used_stock, 0.0);
    }
    if (!pdi_metal_bonds(d)) pdi_interface_link(d, pdi_interface_pay);
}
