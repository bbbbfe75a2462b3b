/* interface: see interface.h */
#include "metal/interface.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* A normal that is shorter than this share of what it is summed of has cancelled, and what a bond carries along a
 * normal that it stands across is none: both would be rounding. */
#define PDI_INTERFACE_NONE 1e-9

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
    double flux = d->kind[0].supply * (beside->flux / beside->weight), film = beside->film / beside->weight;
    return diffusivity > 0.0 ? flux * film / diffusivity : HUGE_VAL;
}

PDI_FN void pdi_interface_find(const pd_dissolve *d, int32_t j, int k, pdi_entry *entry)
{
    if (!pdi_metal_bonds(d)) {
        pdi_entry_find(&d->paths, j, k, entry);
        return;
    }
    entry->open = 0;
    entry->far = entry->node[0] = pdi_reach_taker(d, j, k);
    entry->count = entry->far >= 0;
    entry->last[0] = j;
    entry->lasts = 1;
}

PDI_FN double pdi_interface_speed(const pd_dissolve *d, int32_t i, int metal)
{
    return d->slot[i] < 0 ? 0.0 : pdi_metal_portion(d, &d->beside[d->slot[i]])[metal].mean;
}

/* 1: metal entered at node i in the last step, and some of it is left. */
static int pdi_interface_enters(const pd_dissolve *d, int32_t i)
{
    if (d->slot[i] < 0 || !(d->beside[d->slot[i]].enters > 0.0)) return 0;
    for (int k = 0; k < d->paths.stencil->count; k++)
        if (d->grid->kind[pdi_entry_far(&d->paths, i, k)] == PD_SOLID) return 1;
    return 0;
}

PDI_FN double pdi_interface_fastest(const pd_dissolve *d, int32_t i)
{
    double fastest = 0.0;
    if (!pdi_interface_enters(d, i)) return (double)NAN;
    for (int m = 0; m < d->kinds; m++) fastest = pd_max(fastest, pdi_interface_speed(d, i, m));
    return fastest;
}

PDI_FN double pdi_interface_weight(const pd_dissolve *d, int32_t j, int32_t i, int k, const pdi_entry *entry)
{
    return pdi_metal_supply(d, j) * pdi_metal_gives(d, j) * (pdi_metal_area(d, j, k) / entry->count) *
           pdi_metal_over(d, j, i);
}

/* The loss of exposed node f, in bonds. */
static double pdi_interface_bond_rate(const pd_dissolve *d, int32_t f)
{
    int32_t j = d->front[f];
    int metal = pdi_metal_of(d, j);
    double sum = 0.0;
    pdi_reach reach = pdi_reach_of(d, j);
    while (pdi_reach_next(&reach)) {
        int32_t i = pdi_entry_far(&d->paths, j, reach.bond);
        sum += pdi_metal_area(d, j, reach.bond) * pdi_metal_drive(d, j, i) * pdi_interface_speed(d, i, metal);
    }
    return sum * pdi_metal_gives(d, j);
}

/* f sum c(n) v over the bonds to fluid. */
PDI_FN double pdi_interface_rate(const pd_dissolve *d, int32_t f)
{
    pdi_entry entry;
    int32_t j = d->front[f];
    double sum = 0.0;
    if (pdi_metal_bonds(d)) return pdi_interface_bond_rate(d, f);
    for (int k = 0; k < d->paths.stencil->count; k++) {
        pdi_interface_find(d, j, k, &entry);
        for (int e = 0; e < entry.count; e++)
            sum += pdi_metal_area(d, j, k) / entry.count * pdi_interface_speed(d, entry.node[e], pdi_metal_of(d, j));
    }
    return sum * pdi_metal_gives(d, j);
}

PDI_FN double pdi_interface_pace(const pd_dissolve *d, int32_t f)
{
    double fastest = 0.0;
    if (d->desc.drive == PD_DRIVE_CONSTANT) return pdi_interface_rate(d, f);
    int32_t j = d->front[f];
    pdi_reach reach = pdi_reach_of(d, j);
    while (pdi_reach_next(&reach)) {
        int32_t i = pdi_entry_far(&d->paths, j, reach.bond);
        fastest = pd_max(fastest, pdi_interface_speed(d, i, pdi_metal_of(d, j)));
    }
    return d->kernel.total * fastest * pdi_metal_factor(d, j);
}

/* What the metal of node j gives by bond k at node e of its entry. */
static void pdi_interface_enter(pd_dissolve *d, int32_t j, int k, const pdi_entry *entry, int e)
{
    const pd_stencil *s = d->paths.stencil;
    double way[PD_DIM], weight = pdi_interface_weight(d, j, entry->node[e], k, entry);
    if (!(weight > 0.0)) return;
    pdi_beside *beside = pdi_reach_join(d, entry->node[e]);
    pdi_metal_beside *portion = &pdi_metal_portion(d, beside)[pdi_metal_of(d, j)];
    beside->enters += weight;
    portion->enters += weight;
    for (int n = 0; n < entry->lasts; n++)
        beside->hollow += weight * pd_max(1.5 - pdi_metal_left(d, entry->last[n]), 0.0) / entry->lasts;
    beside->factor += weight * (pdi_metal_factor(d, j) * (pdi_metal_supply(d, j) / d->kind[0].supply));
    pdi_entry_mirror(entry, e, s->xi + k * PD_DIM, way);
    for (int a = 0; a < PD_DIM; a++) beside->normal[a] += s->area_weight[k] / entry->count * way[a];
}

/* Where the metal of exposed node f enters the fluid. The surface stands in the last metal cell on the way, as deep as
 * that has lost metal. */
static void pdi_interface_gather(pd_dissolve *d, int32_t f)
{
    pdi_entry entry;
    int32_t j = d->front[f];
    for (int k = 0; k < d->paths.stencil->count; k++) {
        pdi_interface_find(d, j, k, &entry);
        for (int e = 0; e < entry.count; e++) pdi_interface_enter(d, j, k, &entry, e);
    }
}

/* A share of what enters at one node and arrives at another one, `beyond` [m] it as seen from the metal. */
typedef void (*pdi_interface_link_fn)(pd_dissolve *d, pdi_beside *from, pdi_beside *to, double share, double beyond);

/* All of them. A bond of the fluid that the metal cuts carries a(n) times its way along the normal in a linear
 * field. */
PDI_NOINLINE static void pdi_interface_link(pd_dissolve *d, pdi_interface_link_fn link)
{
    const pd_bond_paths *paths = &d->transport->bonds->paths;
    const pd_stencil *s = paths->stencil;
    pdi_entry entry;
    for (int32_t f = 0; f < d->front_count; f++)
        for (int k = 0; k < s->count; k++) {
            pdi_entry_find(paths, d->front[f], k, &entry);
            for (int e = 0; e < entry.count && entry.open; e++) {
                if (d->slot[entry.node[e]] < 0) continue;
                pdi_beside *from = &d->beside[d->slot[entry.node[e]]];
                double normal[PD_DIM];
                pdi_entry_mirror(&entry, e, from->normal, normal);
                double share = s->laplacian_weight[k] * pdi_vec_dot(s->xi + k * PD_DIM, normal) / entry.count;
                double least = PDI_INTERFACE_NONE * s->laplacian_weight[k] * pdi_vec_norm(s->xi + k * PD_DIM);
                if (!(from->enters > 0.0) || !(share > least)) continue;
                double beyond = pd_max(pdi_entry_beyond(paths, k, &entry, e, normal), 0.0);
                link(d, from, pdi_reach_join(d, entry.far), share, beyond);
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
    for (int a = 0; a < PD_DIM; a++) cell = pd_max(cell, fabs(from->normal[a]) * d->paths.stencil->h[a]);
    to->weight += over * from->enters;
    for (int m = 0; m < d->kinds; m++)
        pdi_metal_portion(d, to)[m].weight += over * pdi_metal_portion(d, from)[m].enters;
    to->film += over * (from->hollow * cell + from->enters * beyond);
    to->flux += over * from->factor;
}

static void pdi_interface_average(pd_dissolve *d, pdi_beside *from, pdi_beside *to, double share, double beyond)
{
    (void)beyond;
    for (int m = 0; m < d->kinds; m++)
        pdi_metal_portion(d, from)[m].mean += pdi_interface_part(from, share) * pdi_metal_portion(d, to)[m].speed;
}

/* Factor of the law, whole - part c, of a drive by difference. */
static void pdi_interface_drive(const pd_dissolve *d, const pdi_metal_beside *portion, double *whole, double *part)
{
    const pdi_metal_kind *kind = &d->kind[(portion - d->portion) % d->kinds];
    *whole = 1.0;
    *part = 0.0;
    if (d->desc.drive != PD_DRIVE_DIFFERENCE) return;
    *part = kind->ratio / kind->supply;
    *whole = *part * portion->stock / portion->weight;
}

/* Grain of the metal node within a bond that is nearest to fluid node i; of several at one distance, the first by bond.
 */
static int32_t pdi_interface_grain(const pd_dissolve *d, int32_t i)
{
    const pd_stencil *s = d->paths.stencil;
    int32_t grain = -1;
    double nearest = HUGE_VAL;
    for (int k = 0; k < s->count && d->desc.grain; k++) {
        double way = pdi_vec_norm(s->xi + k * PD_DIM);
        if (!(way < nearest)) continue;
        int32_t j = pdi_entry_far(&d->paths, i, k);
        if (j < 0 || d->grid->kind[j] != PD_SOLID) continue;
        nearest = way;
        grain = d->desc.grain[j];
    }
    return grain;
}

PDI_FN void pdi_interface_law(const pd_dissolve *d, const pdi_beside *beside, pdi_law *law)
{
    const pdi_metal_beside *portion = pdi_metal_portion(d, beside);
    law->metals = 0;
    law->touch = 0.0;
    law->top = law->limit = d->desc.saturation;
    if (!pdi_metal_bonds(d)) {
        law->top = 0.0;
        law->limit = HUGE_VAL;
    }
    int arrives = beside->weight > 0.0;
    for (int m = 0; m < d->kinds; m++) {
        pdi_law_metal *own = &law->metal[law->metals];
        double weight = arrives ? portion[m].weight : portion[m].enters;
        if (!(weight > 0.0)) continue;
        own->rate = d->kind[m].law.rate;
        own->user = d->kind[m].law.rate_user;
        own->bounds = d->kind[m].law.bounds;
        own->breaks = d->kind[m].law.breaks;
        own->break_count = d->kind[m].law.break_count;
        own->share = weight / (arrives ? beside->weight : beside->enters);
        pdi_interface_drive(d, &portion[m], &own->whole, &own->part);
        if (!pdi_metal_bonds(d)) law->top = pd_max(law->top, d->kind[m].solid);
        law->metals++;
    }
    if (!law->metals) law->top = d->kind[0].solid; /* a law of nothing */
    law->touch = beside->touch;
    law->at.t = d->time;
    law->moment = d->moment;
    law->part = d->part;
    law->moments = d->moments;
    law->at.grain = pdi_interface_grain(d, beside->node);
    law->at.node = beside->node;
    pd_grid_position(d->grid, beside->node, law->at.x);
}

/* Share of a concentration around that at the surface, where the metals share what is between the sides of a jump. */
#define PDI_INTERFACE_AROUND 1e-7
#define PDI_INTERFACE_DROP 1e-6

/* What the line says of all metals together is what each one gives at the concentration at the surface, or between both
 * sides of a jump. */
static void pdi_interface_share(const pd_dissolve *d, const pdi_beside *beside)
{
    pdi_metal_beside *portion = pdi_metal_portion(d, beside);
    double line = pdi_interface_line(d, beside), sum = 0.0;
    double before[PDI_LAW_METALS], behind[PDI_LAW_METALS], above = 0.0, below = 0.0;
    pdi_law law;
    portion->speed = line;
    if (d->kinds == 1) return;
    double resist = pdi_interface_resist(d, beside);
    pdi_interface_law(d, beside, &law);
    double c = pd_max(d->transport->c[beside->node], 0.0);
    double s = resist < HUGE_VAL ? pd_min(c + resist * pd_max(line, 0.0), law.top) : law.top;
    for (int k = 0; k < law.metals && law.metals > 1; k++) {
        before[k] = pd_max(pdi_law_own(&law, k, s * (1.0 - PDI_INTERFACE_AROUND)), 0.0);
        behind[k] = pd_max(pdi_law_own(&law, k, s * (1.0 + PDI_INTERFACE_AROUND)), 0.0);
        above += law.metal[k].share * before[k];
        below += law.metal[k].share * behind[k];
    }
    double high = pd_max(above, below), theta = 0.5;
    if (fabs(above - below) > PDI_INTERFACE_DROP * high)
        theta = pd_min(pd_max((line - below) / (above - below), 0.0), 1.0);
    for (int k = 0; k < law.metals && law.metals > 1; k++) {
        before[k] = theta * before[k] + (1.0 - theta) * behind[k];
        sum += law.metal[k].share * before[k];
    }
    for (int m = 0, k = 0; m < d->kinds; m++) {
        portion[m].speed = 0.0;
        if (!(portion[m].weight > 0.0)) continue;
        portion[m].speed = law.metals > 1 && sum > 0.0 ? before[k] * (line / sum) : line;
        k++;
    }
}

/* The speed of the metal is the mean of what the law gives where it arrives. */
PDI_FN void pdi_interface_means(pd_dissolve *d)
{
    for (int32_t n = 0; n < d->beside_count; n++) {
        const pdi_beside *beside = &d->beside[n];
        if (beside->weight > 0.0) pdi_interface_share(d, beside);
        for (int m = 0; m < d->kinds; m++) {
            pdi_metal_beside *portion = &pdi_metal_portion(d, beside)[m];
            double whole, part;
            portion->mean = 0.0;
            if (!pdi_metal_bonds(d) || !(portion->weight > 0.0)) continue;
            /* the line is that of the law times the mean drive of the bonds */
            pdi_interface_drive(d, portion, &whole, &part);
            double drive = whole - part * d->transport->c[beside->node];
            portion->mean = drive > 0.0 ? portion->speed / drive : 0.0;
        }
    }
    if (!pdi_metal_bonds(d)) pdi_interface_link(d, pdi_interface_average);
}

/* What of it belongs to pieces of metal that do not last the step is given once for all: `stock` is that of a metal. */
static void pdi_interface_pay(pd_dissolve *d, pdi_beside *from, pdi_beside *to, double share, double beyond)
{
    double over = pdi_interface_part(from, share) * pdi_metal_over(d, from->node, to->node);
    (void)beyond;
    to->weight = 0.0;
    for (int m = 0; m < d->kinds; m++) {
        const pdi_metal_beside *gives = &pdi_metal_portion(d, from)[m];
        pdi_metal_beside *portion = &pdi_metal_portion(d, to)[m];
        to->given += over * gives->paid * portion->speed;
        portion->stock += over * gives->paid * portion->speed;
        portion->weight = pd_max(portion->weight - over * gives->used, 0.0);
        to->weight += portion->weight;
    }
}

static void pdi_interface_anew(pd_dissolve *d)
{
    const pd_stencil *s = d->paths.stencil;
    double whole = 0.0;
    for (int k = 0; k < s->count; k++) whole += s->area_weight[k] * pdi_vec_norm(s->xi + k * PD_DIM);
    for (int32_t k = 0; k < d->beside_count; k++) d->slot[d->beside[k].node] = -1;
    d->beside_count = d->lasts = 0;
    for (int32_t f = 0; f < d->front_count; f++) pdi_interface_gather(d, f);
    for (int32_t n = 0; n < d->beside_count; n++) {
        double *normal = d->beside[n].normal, length = pdi_vec_norm(normal);
        int cancels = !(length > PDI_INTERFACE_NONE * whole);
        for (int a = 0; a < PD_DIM; a++) normal[a] = cancels ? 0.0 : normal[a] / length;
    }
}

PDI_FN pd_status pdi_interface_land(pd_ctx *ctx, pd_dissolve *d)
{
    PD_TRY(pdi_reach_make_room(ctx, d, 1)); /* there is none after memory has been refused */
    if (pdi_metal_bonds(d)) return pdi_reach_update(ctx, d);
    for (;;) {
        pdi_interface_anew(d);
        pdi_interface_link(d, pdi_interface_count);
        pdi_interface_link(d, pdi_interface_arrive);
        if (!d->beside_lacks) return PD_OK;
        PD_TRY(pdi_reach_make_more(ctx, d));
    }
}

PDI_FN int pdi_interface_lasts(const pd_dissolve *d)
{
    if (!d->lasts) return 0;
    for (int32_t n = 0; n < d->beside_count; n++)
        for (int m = 0; m < d->kinds; m++) {
            const pdi_metal_beside *portion = &pdi_metal_portion(d, &d->beside[n])[m];
            if (d->beside[n].fresh || !(portion->enters > 0.0)) continue;
            if (portion->mean < portion->rated || portion->mean > portion->rated) return 0;
        }
    return 1;
}

PDI_FN int pdi_interface_stays(const pd_dissolve *d)
{
    return d->desc.activation && d->uniform && d->reached && !d->lags && d->lasts && d->gone_count == 0;
}

PDI_FN void pdi_interface_rated(pd_dissolve *d)
{
    d->lags = 0;
    d->lasts = pdi_metal_bonds(d) && d->desc.drive == PD_DRIVE_CONSTANT && d->gone_count == 0;
    for (int32_t n = 0; n < d->beside_count && d->lasts; n++) {
        d->beside[n].fresh = 0;
        for (int m = 0; m < d->kinds; m++) {
            pdi_metal_beside *portion = &pdi_metal_portion(d, &d->beside[n])[m];
            portion->rated = portion->mean;
        }
    }
}

PDI_FN void pdi_interface_spare(pd_dissolve *d)
{
    for (int32_t n = 0; n < d->beside_count && pdi_metal_bonds(d); n++) {
        pdi_beside *beside = &d->beside[n];
        beside->weight = 0.0;
        for (int m = 0; m < d->kinds; m++) {
            pdi_metal_beside *portion = &pdi_metal_portion(d, beside)[m];
            beside->given += portion->paid * portion->mean;
            portion->weight = pd_max(portion->weight - portion->used, 0.0);
            portion->stock = pd_max(portion->stock - portion->used_stock, 0.0);
            beside->weight += portion->weight;
        }
    }
    if (!pdi_metal_bonds(d)) pdi_interface_link(d, pdi_interface_pay);
}

#undef PDI_INTERFACE_NONE
#undef PDI_INTERFACE_AROUND
#undef PDI_INTERFACE_DROP
