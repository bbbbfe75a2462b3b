/* dissolve: see dissolve.h */
#include "metal/dissolve.h"
#include "core/vec.h"
#include "core/par.h"
#include "metal/entry.h"
#include <math.h>
#include <string.h>

/* Content above the threshold that counts as none, as a fraction of Cs: rounding of the losses. */
#define PDI_DISSOLVE_EMPTY 1e-12

/* Share of the mean lead that is taken off. The whole of it, right for layers of a flat front, is too much where steps
 * run over a curved one: 0.6 is fitted to discs of 8 and 16 cells (within 1.5 % of the speed until half is gone). */
#define PDI_DISSOLVE_LEAD_SHARE 0.6

/* Rounds in which law and transport have to agree, on a share of the fastest speed or of the field. */
#define PDI_DISSOLVE_ROUNDS 100
#define PDI_DISSOLVE_NEAR 1e-8
#define PDI_DISSOLVE_CLOSE 1e-10
/* Steps by the error in time: the share of the longest one that is taken, how much longer or shorter the next one may
 * be, and the loss of a node over the tolerance that is faint. */
#define PDI_DISSOLVE_SAFE 0.9
#define PDI_DISSOLVE_LONGER 10.0
#define PDI_DISSOLVE_FAINT 1e-3

/* A solid neighbour that loses at most this share of what a node loses lies behind it. */
#define PDI_DISSOLVE_SHELTERED 0.6

/* A fluid node within a horizon of metal. Bonds of metal enter the fluid at the first layer of nodes. What they give
 * goes to all nodes whose bonds the metal cuts, to each what its cut bonds would carry (theory: eq. 6.2c). */
typedef struct pdi_shore {
    int32_t node;
    /* where metal enters */
    double enters;         /* [mol/m4] sum f c(n) Cs over the solid bonds that enter here and follow the law */
    double hollow, factor; /* [mol/m4] sums of that times the film in cells, and times f */
    double normal[PD_DIM]; /* from the metal */
    double links;          /* sum of what the bonds through here count */
    double mean;           /* [m/s] speed of the metal */
    double used, paid;     /* [mol/m4], [mol/m3/s] of pieces of metal that do not last the step: weight, and what it
                            * gives */
    /* where it arrives */
    double weight;         /* [mol/m4] share of `enters` */
    double given;          /* [mol/m3/s] what pieces of metal give that do not last the step (eq. 6.6b) */
    double film;           /* [mol/m3] sum of weight times the film */
    double flux;           /* [mol/m4] sum of weight times f */
    double before;         /* [m/s] speed at the start of the step */
    pdi_law_point point;
} pdi_shore;

PDI_FN size_t pdi_dissolve_shore_size(void) { return sizeof(pdi_shore); }

static double pdi_dissolve_factor(const pd_dissolve *d, int32_t solid)
{
    return d->desc.factor ? d->desc.factor[solid] : 1.0;
}

/* What an intact node loses before it turns fluid [mol/m3]. */
static double pdi_dissolve_span(const pd_dissolve *d) { return d->desc.solid * (1.0 - d->desc.threshold); }

/* Interface area c(n) [1/m] of bond k of node j; a ring moves what a bond crosses at its mean radius. */
static double pdi_dissolve_area(const pd_dissolve *d, int32_t j, int k)
{
    const pd_stencil *s = d->bonds->stencil;
    double middle = pdi_grid_around(d->grid, j, 0.5 * s->xi[k * PD_DIM + PD_DIM - 1]);
    return s->area[k] * (middle / pdi_grid_circumference(d->grid, j));
}

/* Volume of node j over that of node i. */
static double pdi_dissolve_over(const pd_dissolve *d, int32_t j, int32_t i)
{
    return pdi_grid_circumference(d->grid, j) / pdi_grid_circumference(d->grid, i);
}

/* Content of node j above what stays in it, as a share of the span. */
static double pdi_dissolve_left(const pd_dissolve *d, int32_t j)
{
    return (d->transport->c[j] - d->desc.threshold * d->desc.solid) / pdi_dissolve_span(d);
}

/* Speed that the law gives at a node, on its line. */
static double pdi_dissolve_line(const pd_dissolve *d, const pdi_shore *shore)
{
    return shore->point.speed + shore->point.slope * d->transport->c[shore->node];
}

PDI_FN double pdi_dissolve_speed(const pd_dissolve *d, int32_t i)
{
    return d->slot[i] < 0 ? 0.0 : d->shore[d->slot[i]].mean;
}

static double pdi_dissolve_diffusivity(const pd_dissolve *d, int32_t i)
{
    const pd_diffusion *diffusion = &d->transport->diffusion;
    return diffusion->field ? diffusion->field[i] : diffusion->desc.diffusivity;
}

/* R of the film of a node beside metal [mol s/m4]: what crosses it is the mean flux of the metal there. */
static double pdi_dissolve_resist(const pd_dissolve *d, const pdi_shore *shore)
{
    double diffusivity = pdi_dissolve_diffusivity(d, shore->node);
    double flux = pdi_dissolve_span(d) * (shore->flux / shore->weight), film = shore->film / shore->weight;
    return diffusivity > 0.0 ? flux * film / diffusivity : HUGE_VAL;
}

/* What bond k of solid node j gives to fluid node i where it enters, per speed of the law [mol/m4]. */
static double pdi_dissolve_weight(const pd_dissolve *d, int32_t j, int32_t i, int k, const pdi_entry *entry)
{
    return pdi_dissolve_span(d) * pdi_dissolve_factor(d, j) * (pdi_dissolve_area(d, j, k) / entry->count) *
           pdi_dissolve_over(d, j, i);
}

/* Rate [1/s] at which solid node j loses its span: f sum c(n) v over its bonds to fluid. */
static double pdi_dissolve_rate(const pd_dissolve *d, int32_t j)
{
    const pd_stencil *s = d->bonds->stencil;
    pdi_entry entry;
    double sum = 0.0;
    for (int k = 0; k < s->count; k++) {
        pdi_entry_find(d->bonds, j, k, &entry);
        for (int e = 0; e < entry.count; e++) {
            int32_t i = entry.node[e];
            sum += pdi_dissolve_area(d, j, k) / entry.count * pdi_dissolve_speed(d, i);
        }
    }
    return sum * pdi_dissolve_factor(d, j);
}

/* Mean lead of the node set in cells: along an axis layer l loses the share a_l = sum over n_axis >= l of c(n) h, and
 * has on average lost its own share half and those of the layers below whole: sum_l (l - 1/2) a_l = sum c(n) h n^2 / 2
 * over n_axis > 0. */
static double pdi_dissolve_lead(const pd_stencil *s)
{
    double sum = 0.0;
    for (int k = 0; k < s->count; k++)
        for (int d = 0; d < PD_DIM; d++) {
            double n = (double)s->offset[k * PD_DIM + d];
            sum += 0.25 * s->area[k] * s->h[d] * n * n / PD_DIM;
        }
    return PDI_DISSOLVE_LEAD_SHARE * sum;
}

static void pdi_dissolve_collect(pd_dissolve *d)
{
    d->front_count = 0;
    for (int32_t j = 0; j < d->grid->total; j++)
        if (d->exposed[j]) d->front[d->front_count++] = j;
}

static int pdi_dissolve_is_exposed(const pd_dissolve *d, int32_t j)
{
    if (d->grid->kind[j] != PD_SOLID) return 0;
    for (int k = 0; k < d->bonds->stencil->count; k++)
        if (d->grid->kind[pdi_entry_far(d->bonds, j, k)] == PD_FLUID) return 1;
    return 0;
}

static pd_status pdi_dissolve_make(pd_ctx *ctx, pd_grid *grid, const pd_bonds *bonds, pd_transport *transport,
                                   const pd_dissolve_desc *desc, pd_dissolve *d)
{
    memset(d, 0, sizeof *d);
    if (!(desc->solid > 0.0) || !(desc->solid < 1e100) || !(desc->threshold >= 0.0) || !(desc->threshold < 1.0) ||
        !desc->rate)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "dissolve",
                        "Cs = %g mol/m3 must be positive, the threshold %g lie in [0, 1), a rate law be given",
                        desc->solid, desc->threshold);
    d->desc = *desc;
    d->grid = grid;
    d->bonds = bonds;
    d->transport = transport;
    d->capacity = (int32_t)grid->solid_count;
    PDI_TRY(PDI_NEW(ctx, "dissolve", d->capacity, d->front));
    PDI_TRY(PDI_NEW(ctx, "dissolve", d->capacity, d->changed));
    PDI_TRY(PDI_NEW(ctx, "dissolve", d->capacity, d->piece));
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->mark));
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->exposed));
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->rate));
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->slot));
    d->shore_capacity = pdi_entry_around(bonds, d->mark);
    PDI_TRY(PDI_NEW(ctx, "dissolve", d->shore_capacity, d->shore));
    d->from = HUGE_VAL;
    d->next_dt = HUGE_VAL;
    for (int32_t j = 0; j < grid->total; j++) {
        if (grid->kind[j] == PD_SOLID) transport->c[j] = desc->solid;
        d->exposed[j] = (uint8_t)pdi_dissolve_is_exposed(d, j);
        d->slot[j] = -1;
    }
    d->lead = pdi_dissolve_lead(bonds->stencil);
    for (int k = 0; k < bonds->stencil->count; k++) d->spread += bonds->stencil->lap[k];
    pdi_dissolve_collect(d);
    return PD_OK;
}

pd_status pd_dissolve_build(pd_ctx *ctx, pd_grid *grid, const pd_bonds *bonds, pd_transport *transport,
                            const pd_dissolve_desc *desc, pd_dissolve *d)
{
    pd_status status = pdi_dissolve_make(ctx, grid, bonds, transport, desc, d);
    if (status < 0) pd_dissolve_free(ctx, d);
    return status;
}

/* The law beside node i. */
static void pdi_dissolve_law(const pd_dissolve *d, int32_t i, pdi_law *law)
{
    law->rate = d->desc.rate;
    law->user = d->desc.rate_user;
    law->top = d->desc.solid;
    law->at.t = d->time;
    pd_grid_position(d->grid, i, law->at.x);
}

static pd_status pdi_dissolve_unlawful(pd_ctx *ctx, const pd_dissolve *d, pdi_law *law, int32_t i)
{
    char place[PDI_GRID_PLACE];
    double c = law->at.c;
    return pdi_fail(ctx, PD_ERR_STATE, "dissolve",
                    "the rate law gives %g m/s at c = %g mol/m3, t = %g s (node %d at %s m), expected a speed below "
                    "1e100 m/s", pdi_law_rate(law, c), c, d->time, (int)i, pdi_grid_place(d->grid, i, place));
}

/* The first line of the law at a node beside metal. */
static pd_status pdi_dissolve_begin_law(pd_ctx *ctx, pd_dissolve *d, pdi_shore *shore)
{
    pdi_law law;
    double c = fmax(d->transport->c[shore->node], 0.0);
    pdi_dissolve_law(d, shore->node, &law);
    if (d->desc.uniform && !(c >= d->from && c < d->end)) {
        d->from = c;
        d->end = pdi_law_end(&law, c, law.top);
    }
    if (!pdi_law_begin(&law, pdi_dissolve_resist(d, shore), d->from, d->end, c, &shore->point))
        return pdi_dissolve_unlawful(ctx, d, &law, shore->node);
    shore->before = pdi_dissolve_line(d, shore);
    return PD_OK;
}

PDI_FN void pdi_dissolve_course(const pd_dissolve *d, double t, double dt, double *error, double *taken)
{
    *error = *taken = 0.0;
    for (int32_t n = 0; n < d->shore_count; n++) {
        const pdi_shore *shore = &d->shore[n];
        pdi_law law;
        double v[3], share = dt * shore->enters / pdi_dissolve_span(d);
        pdi_dissolve_law(d, shore->node, &law);
        for (int k = 0; k < 3; k++) {
            law.at.t = t + 0.5 * k * dt;
            v[k] = fmax(pdi_law_rate(&law, fmax(d->transport->c[shore->node], 0.0)), 0.0);
        }
        *error = fmax(*error, share * fabs(v[0] - 2.0 * v[1] + v[2]) / 6.0);
        if (v[0] < v[1] || v[0] > v[1] || v[1] < v[2] || v[1] > v[2]) *taken = fmax(*taken, share * fmax(v[1], v[2]));
    }
}

/* What the lines make of the equations of transport. */
static void pdi_dissolve_sources(pd_dissolve *d)
{
    pd_transport *t = d->transport;
    t->ceiling = 0.0; /* where the lines end */
    for (int32_t k = 0; k < d->shore_count; k++) {
        const pdi_shore *shore = &d->shore[k];
        double source = shore->weight * shore->point.speed, absorb = -shore->weight * shore->point.slope;
        t->source[shore->node] = source + shore->given;
        t->absorb[shore->node] = absorb;
        if (source > 0.0) t->ceiling = fmax(t->ceiling, absorb > 0.0 ? source / absorb : HUGE_VAL);
    }
}

/* Node i among the fluid beside metal. */
static pdi_shore *pdi_dissolve_join(pd_dissolve *d, int32_t i)
{
    if (d->slot[i] < 0) {
        d->slot[i] = d->shore_count++;
        memset(&d->shore[d->slot[i]], 0, sizeof(pdi_shore));
        d->shore[d->slot[i]].node = i;
    }
    return &d->shore[d->slot[i]];
}

/* Where the metal of node j enters the fluid. The surface stands in the last metal cell on the way, as deep as that has
 * lost metal. */
static void pdi_dissolve_gather(pd_dissolve *d, int32_t j)
{
    const pd_stencil *s = d->bonds->stencil;
    double way[PD_DIM];
    pdi_entry entry;
    for (int k = 0; k < s->count; k++) {
        pdi_entry_find(d->bonds, j, k, &entry);
        for (int e = 0; e < entry.count; e++) {
            double weight = pdi_dissolve_weight(d, j, entry.node[e], k, &entry);
            if (!(weight > 0.0)) continue;
            pdi_shore *shore = pdi_dissolve_join(d, entry.node[e]);
            shore->enters += weight;
            shore->hollow += weight * fmax(1.5 - pdi_dissolve_left(d, entry.last), 0.0);
            shore->factor += weight * pdi_dissolve_factor(d, j);
            pdi_entry_mirror(&entry, e, s->xi + k * PD_DIM, way);
            for (int a = 0; a < PD_DIM; a++) shore->normal[a] += s->area[k] / entry.count * way[a];
        }
    }
}

/* A share of what enters at one node and arrives at another one, `beyond` [m] it as seen from the metal. */
typedef void (*pdi_dissolve_link_fn)(pd_dissolve *d, pdi_shore *from, pdi_shore *to, double share, double beyond);

/* All of them. A bond that the metal cuts carries a(n) times its way along the normal in a linear field. */
static void pdi_dissolve_link(pd_dissolve *d, pdi_dissolve_link_fn link)
{
    const pd_stencil *s = d->bonds->stencil;
    pdi_entry entry;
    for (int32_t f = 0; f < d->front_count; f++)
        for (int k = 0; k < s->count; k++) {
            pdi_entry_find(d->bonds, d->front[f], k, &entry);
            for (int e = 0; e < entry.count && entry.open; e++) {
                if (d->slot[entry.node[e]] < 0) continue;
                pdi_shore *from = &d->shore[d->slot[entry.node[e]]];
                double normal[PD_DIM];
                pdi_entry_mirror(&entry, e, from->normal, normal);
                double share = s->lap[k] * pdi_vec_dot(s->xi + k * PD_DIM, normal) / entry.count;
                if (!(from->enters > 0.0) || !(share > 0.0)) continue;
                double beyond = fmax(pdi_entry_beyond(d->bonds, k, &entry, e, normal), 0.0);
                link(d, from, pdi_dissolve_join(d, entry.far), share, beyond);
            }
        }
    for (int32_t n = 0; n < d->shore_count; n++) { /* metal on all sides */
        pdi_shore *shore = &d->shore[n];
        if (shore->enters > 0.0 && !(shore->links > 0.0)) link(d, shore, shore, 0.0, 0.0);
    }
}

static double pdi_dissolve_part(const pdi_shore *from, double share)
{
    return from->links > 0.0 ? share / from->links : 1.0;
}

static void pdi_dissolve_count(pd_dissolve *d, pdi_shore *from, pdi_shore *to, double share, double beyond)
{
    (void)d, (void)to, (void)beyond;
    from->links += share;
}

static void pdi_dissolve_arrive(pd_dissolve *d, pdi_shore *from, pdi_shore *to, double share, double beyond)
{
    double over = pdi_dissolve_part(from, share) * pdi_dissolve_over(d, from->node, to->node), cell = 0.0;
    for (int a = 0; a < PD_DIM; a++) cell = fmax(cell, fabs(from->normal[a]) * d->bonds->stencil->h[a]);
    to->weight += over * from->enters;
    to->film += over * (from->hollow * cell + from->enters * beyond);
    to->flux += over * from->factor;
}

static void pdi_dissolve_average(pd_dissolve *d, pdi_shore *from, pdi_shore *to, double share, double beyond)
{
    (void)beyond;
    from->mean += pdi_dissolve_part(from, share) * pdi_dissolve_line(d, to);
}

/* The speed of the metal is the mean of what the law gives where it arrives. */
static void pdi_dissolve_means(pd_dissolve *d)
{
    for (int32_t n = 0; n < d->shore_count; n++) d->shore[n].mean = 0.0;
    pdi_dissolve_link(d, pdi_dissolve_average);
}

/* What of it belongs to pieces of metal that do not last the step is given once for all. */
static void pdi_dissolve_pay(pd_dissolve *d, pdi_shore *from, pdi_shore *to, double share, double beyond)
{
    double over = pdi_dissolve_part(from, share) * pdi_dissolve_over(d, from->node, to->node);
    (void)beyond;
    to->given += over * from->paid * pdi_dissolve_line(d, to);
    to->weight = fmax(to->weight - over * from->used, 0.0);
}

static void pdi_dissolve_land(pd_dissolve *d)
{
    for (int32_t f = 0; f < d->front_count; f++) pdi_dissolve_gather(d, d->front[f]);
    for (int32_t n = 0; n < d->shore_count; n++) {
        double *normal = d->shore[n].normal, length = pdi_vec_norm(normal);
        for (int a = 0; a < PD_DIM && length > 0.0; a++) normal[a] /= length;
    }
    pdi_dissolve_link(d, pdi_dissolve_count);
    pdi_dissolve_link(d, pdi_dissolve_arrive);
}

pd_status pd_dissolve_prepare(pd_ctx *ctx, pd_dissolve *d)
{
    pd_transport *t = d->transport;
    d->rated = d->gone_count = 0;
    memset(d->mark, 0, (size_t)d->grid->total);
    for (int32_t i = 0; i < d->grid->total; i++) t->source[i] = t->absorb[i] = 0.0;
    for (int32_t k = 0; k < d->shore_count; k++) d->slot[d->shore[k].node] = -1;
    d->shore_count = 0;
    pdi_dissolve_land(d);
    for (int32_t k = 0; k < d->shore_count; k++)
        if (d->shore[k].weight > 0.0) PDI_TRY(pdi_dissolve_begin_law(ctx, d, &d->shore[k]));
    pdi_dissolve_means(d);
    pdi_dissolve_sources(d);
    return PD_OK;
}

double pd_dissolve_fastest(pd_ctx *ctx, const pd_dissolve *d)
{
    double fastest = 0.0;
    (void)ctx;
    for (int32_t f = 0; f < d->front_count; f++) fastest = fmax(fastest, pdi_dissolve_rate(d, d->front[f]));
    return fastest;
}

/* Who can take over from a node that leaves. */
typedef enum pdi_dissolve_heir {
    PDI_DISSOLVE_BEHIND, /* solid that the fluid reaches clearly less than the node itself: the next layer */
    PDI_DISSOLVE_SOLID,  /* any solid */
    PDI_DISSOLVE_FLUID   /* fluid, through the next transport step */
} pdi_dissolve_heir;

/* Weight of the far end of bond k of node j as an heir; 0: it is none. */
static double pdi_dissolve_share(const pd_dissolve *d, int32_t j, int k, pdi_dissolve_heir heir)
{
    int32_t i = pdi_entry_far(d->bonds, j, k);
    uint8_t wanted = heir == PDI_DISSOLVE_FLUID ? PD_FLUID : PD_SOLID;
    if (i == j || d->grid->kind[i] != wanted || !pdi_entry_free(d->bonds, j, k)) return 0.0;
    if (heir == PDI_DISSOLVE_FLUID) return d->bonds->stencil->area[k];
    if (heir == PDI_DISSOLVE_BEHIND && d->rate[i] > PDI_DISSOLVE_SHELTERED * d->rate[j]) return 0.0;
    return d->bonds->stencil->area[k] * pdi_dissolve_factor(d, i);
}

/* ---- pieces of metal that a step uses up ---- */

/* Marks of solid nodes within a step. */
enum {
    PDI_DISSOLVE_SEEN = 1,   /* by the search at hand */
    PDI_DISSOLVE_LASTS = 2,  /* its piece has more than it gives */
    PDI_DISSOLVE_GONE = 4,   /* its piece gives all that it has */
    PDI_DISSOLVE_TURNED = 8  /* fluid from this step on */
};

/* A piece of metal: nodes that can hand over to each other, directly or through others. */
typedef struct pdi_dissolve_piece {
    int32_t *node;
    int32_t count;
    double has, gives; /* [mol/m3 of a cell] above the threshold; in the step */
} pdi_dissolve_piece;

/* Take j into the piece. */
static void pdi_dissolve_see(pd_dissolve *d, int32_t j, pdi_dissolve_piece *p)
{
    d->mark[j] |= PDI_DISSOLVE_SEEN;
    p->node[p->count++] = j;
}

/* Take the far ends of the bonds of node i into the piece, as far as they are metal that dissolves, or were when the
 * step began. */
static void pdi_dissolve_spread(pd_dissolve *d, int32_t i, pdi_dissolve_piece *p)
{
    for (int k = 0; k < d->bonds->stencil->count; k++) {
        int32_t j = pdi_entry_far(d->bonds, i, k);
        if (d->grid->kind[j] != PD_SOLID && !(d->mark[j] & PDI_DISSOLVE_TURNED)) continue;
        double weight = d->bonds->stencil->area[k] * pdi_dissolve_factor(d, j);
        if (j == i || (d->mark[j] & PDI_DISSOLVE_SEEN) || !(weight > 0.0)) continue;
        if (pdi_entry_free(d->bonds, i, k)) pdi_dissolve_see(d, j, p);
    }
}

static void pdi_dissolve_begin(pd_dissolve *d, int32_t j, pdi_dissolve_piece *p)
{
    p->node = d->piece + d->gone_count;
    p->count = 0;
    p->has = p->gives = 0.0;
    pdi_dissolve_see(d, j, p);
}

static void pdi_dissolve_label(pd_dissolve *d, const pdi_dissolve_piece *p, int label)
{
    for (int32_t n = 0; n < p->count; n++)
        d->mark[p->node[n]] = (uint8_t)((d->mark[p->node[n]] & ~PDI_DISSOLVE_SEEN) | label);
}

/* 1: the piece of node j has more than it gives in the step, which is as soon known as it has more than all metal
 * gives. */
static int pdi_dissolve_lasts(pd_dissolve *d, int32_t j, double dt, double all, pdi_dissolve_piece *p)
{
    double floor_content = d->desc.threshold * d->desc.solid, take = dt * pdi_dissolve_span(d);
    pdi_dissolve_begin(d, j, p);
    for (int32_t n = 0; n < p->count; n++) {
        int32_t i = p->node[n];
        double around = pdi_grid_circumference(d->grid, i);
        p->has += (d->transport->c[i] - floor_content) * around;
        if (d->exposed[i]) p->gives += take * d->rate[i] * around;
        if (p->has > all || (d->mark[i] & PDI_DISSOLVE_LASTS)) return 1;
        pdi_dissolve_spread(d, i, p);
    }
    return p->has > p->gives;
}

/* What the piece gives by its law at the present concentrations, scaled to what it has. */
static void pdi_dissolve_give(pd_dissolve *d, const pdi_dissolve_piece *p)
{
    pdi_entry entry;
    double share = p->has / p->gives;
    for (int32_t n = 0; n < p->count; n++) {
        int32_t j = p->node[n];
        for (int k = 0; k < d->bonds->stencil->count && d->exposed[j]; k++) {
            pdi_entry_find(d->bonds, j, k, &entry);
            for (int e = 0; e < entry.count; e++) {
                int32_t i = entry.node[e];
                double weight = pdi_dissolve_weight(d, j, i, k, &entry);
                if (d->slot[i] < 0 || !(weight > 0.0)) continue;
                d->shore[d->slot[i]].paid += share * weight;
                d->shore[d->slot[i]].used += weight;
            }
        }
    }
}

/* Pieces that would give more than they have: their sources become what they have. How many there are. */
static int pdi_dissolve_spare(pd_dissolve *d, double dt)
{
    double take = dt * pdi_dissolve_span(d), all = 0.0;
    int found = 0;
    for (int32_t j = 0; j < d->grid->total; j++) {
        d->mark[j] &= (uint8_t)~PDI_DISSOLVE_LASTS;
        if (d->exposed[j]) all += fmax(take * d->rate[j], 0.0) * pdi_grid_circumference(d->grid, j);
    }
    for (int32_t f = 0; f < d->front_count; f++) {
        int32_t j = d->front[f];
        pdi_dissolve_piece piece;
        if (d->mark[j] & (PDI_DISSOLVE_LASTS | PDI_DISSOLVE_GONE)) continue;
        if (pdi_dissolve_left(d, j) > dt * d->rate[j]) continue;
        int lasts = pdi_dissolve_lasts(d, j, dt, all, &piece);
        pdi_dissolve_label(d, &piece, lasts ? PDI_DISSOLVE_LASTS : PDI_DISSOLVE_GONE);
        if (lasts) continue;
        pdi_dissolve_give(d, &piece);
        d->gone_count += piece.count;
        found++;
    }
    if (found) pdi_dissolve_link(d, pdi_dissolve_pay);
    for (int32_t n = 0; n < d->shore_count; n++) d->shore[n].used = d->shore[n].paid = 0.0;
    return found;
}

static void pdi_dissolve_rates(const pd_ctx *ctx, pd_dissolve *d)
{
    pdi_dissolve_means(d);
    int nt = pdi_par_threads(ctx, (int64_t)d->front_count * d->bonds->stencil->count * 4);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t f = 0; f < d->front_count; f++) {
        int32_t j = d->front[f];
        if (!(d->mark[j] & PDI_DISSOLVE_GONE)) d->rate[j] = pdi_dissolve_rate(d, j);
    }
    d->rated = 1;
}

/* *met: 1 when the lines ask at the present field what the law gives. Otherwise there are new lines. */
static pd_status pdi_dissolve_meet(pd_ctx *ctx, pd_dissolve *d, int *met)
{
    const pd_transport *t = d->transport;
    double fastest = 0.0;
    *met = 1;
    for (int32_t k = 0; k < d->shore_count; k++) fastest = fmax(fastest, d->shore[k].point.largest);
    for (int32_t k = 0; k < d->shore_count; k++) {
        pdi_shore *shore = &d->shore[k];
        pdi_law law;
        if (!(shore->weight > 0.0)) continue;
        pdi_dissolve_law(d, shore->node, &law);
        int found = pdi_law_meet(&law, t->c[shore->node], PDI_DISSOLVE_NEAR * fastest, PDI_DISSOLVE_CLOSE * t->size,
                                 &shore->point);
        if (found < 0) return pdi_dissolve_unlawful(ctx, d, &law, shore->node);
        *met &= found;
    }
    return PD_OK;
}

/* 1: no node that lasts loses more than it may. */
static int pdi_dissolve_moderate(pd_dissolve *d, double lost, double dt)
{
    if (!(d->most > 0.0) || lost <= d->most) return 1;
    d->retry_dt = 0.5 * dt * d->most / lost;
    return 0;
}

/* 1: the metal lost is right in time. A step takes the speed at its end; half of the range of speeds on the way is its
 * error, which goes with the square of the step. What is faint against a cell is right. */
static int pdi_dissolve_accurate(pd_dissolve *d, double lost, double dt)
{
    const pd_transport *t = d->transport;
    pdi_sum gone = {0.0, 0.0}, error = {0.0, 0.0};
    for (int32_t k = 0; k < d->shore_count && d->rtol > 0.0; k++) {
        pdi_shore *shore = &d->shore[k];
        pdi_law law;
        pdi_dissolve_law(d, shore->node, &law);
        double speed = pdi_dissolve_line(d, shore);
        double amount = dt * shore->weight * pdi_grid_circumference(d->grid, shore->node);
        double slowest = pdi_law_slowest(&law, &shore->point, t->old[shore->node], t->c[shore->node]);
        double fast = fmax(speed, shore->before), slow = fmin(fmin(speed, shore->before), slowest);
        pdi_sum_add(&gone, amount * speed);
        pdi_sum_add(&error, 0.5 * amount * (fast - slow));
    }
    double volume = d->bonds->stencil->volume, off = pdi_sum_total(&error) * volume;
    double right = d->rtol * (d->lost + pdi_sum_total(&gone) * volume);
    double factor = off > 0.0 ? PDI_DISSOLVE_SAFE * sqrt(right / off) : HUGE_VAL;
    int faint = lost <= PDI_DISSOLVE_FAINT * d->rtol;
    d->next_dt = dt * (faint ? PDI_DISSOLVE_LONGER : factor);
    if (!(d->rtol > 0.0) || factor > PDI_DISSOLVE_LONGER) d->next_dt = HUGE_VAL;
    if (!(d->rtol > 0.0) || off <= right || faint) return 1;
    d->retry_dt = dt * fmax(factor, 1.0 / PDI_DISSOLVE_LONGER);
    return 0;
}

/* 1: the step stands. */
static int pdi_dissolve_stands(pd_dissolve *d, double dt)
{
    double lost = 0.0;
    for (int32_t f = 0; f < d->front_count; f++)
        if (!(d->mark[d->front[f]] & PDI_DISSOLVE_GONE)) lost = fmax(lost, dt * d->rate[d->front[f]]);
    return pdi_dissolve_moderate(d, lost, dt) && pdi_dissolve_accurate(d, lost, dt);
}

/* Law and transport of a step together. */
static pd_status pdi_dissolve_solve(pd_ctx *ctx, pd_dissolve *d, double dt, pd_transport_result *result)
{
    pd_transport *t = d->transport;
    int krylov = 0, met;
    for (d->rounds = 1; d->rounds <= PDI_DISSOLVE_ROUNDS; d->rounds++) {
        pdi_dissolve_sources(d);
        pd_status status = pdi_transport_stage(ctx, t, dt, 1, result);
        result->krylov = krylov += result->krylov;
        if (status < 0) return status;
        PDI_TRY(pdi_dissolve_meet(ctx, d, &met));
        if (!met) continue;
        pdi_dissolve_rates(ctx, d);
        /* less metal leaves less in the fluid, so others give more: each round finds new pieces, or is the last one */
        if (pdi_dissolve_spare(d, dt)) continue;
        return pdi_dissolve_stands(d, dt) ? status : PD_RETRY;
    }
    d->retry_dt = 0.5 * dt;
    return PD_RETRY;
}

/* The speeds that were found stand for the lines: what metal loses and fluid gains is the same number. Where a line is
 * steeper than all that the fluid does, its concentration tells the speed to few digits, and the balance of the node
 * tells it. */
static void pdi_dissolve_settle_speeds(const pd_ctx *ctx, pd_dissolve *d, double dt)
{
    const pd_transport *t = d->transport;
    pdi_transport_residual(ctx, t, t->work);
    for (int32_t k = 0; k < d->shore_count; k++) {
        const pdi_shore *shore = &d->shore[k];
        pdi_law_point *p = &d->shore[k].point;
        double own = 1.0 / dt + pdi_dissolve_diffusivity(d, shore->node) * d->spread;
        double speed = pdi_dissolve_line(d, shore);
        if (-p->slope * shore->weight > own) speed = fmax(speed - t->work[shore->node] / shore->weight, 0.0);
        p->speed = speed;
        p->slope = 0.0;
    }
    pdi_dissolve_sources(d);
    pdi_dissolve_rates(ctx, d);
}

pd_status pd_dissolve_transport(pd_ctx *ctx, pd_dissolve *d, double dt, pd_transport_result *result)
{
    PDI_TRY(pdi_transport_begin(ctx, d->transport, dt));
    pd_status status = pdi_dissolve_solve(ctx, d, dt, result);
    if (status >= 0 && status != PD_RETRY) pdi_dissolve_settle_speeds(ctx, d, dt);
    return pdi_transport_end(ctx, d->transport, dt, status);
}

/* ---- after the transport step ---- */

/* Move `rest` to the solid nodes nearest to j on paths through its piece, whose other nodes leave as well. 0: there is
 * none. */
static int pdi_dissolve_pass_on(pd_dissolve *d, int32_t j, double rest)
{
    pdi_dissolve_piece p;
    int32_t begin = 0, end = 1, found = 0;
    pdi_dissolve_begin(d, j, &p);
    while (begin < end && !found) {
        for (int32_t n = begin; n < end; n++) pdi_dissolve_spread(d, p.node[n], &p);
        begin = end;
        end = p.count;
        for (int32_t n = begin; n < end; n++) found += d->grid->kind[p.node[n]] == PD_SOLID;
    }
    for (int32_t n = begin; n < end; n++)
        if (d->grid->kind[p.node[n]] == PD_SOLID)
            d->transport->c[p.node[n]] += rest / found * pdi_dissolve_over(d, j, p.node[n]);
    pdi_dissolve_label(d, &p, 0);
    return found > 0;
}

/* Move `rest` (what node j still holds, or owes when negative) to the layer behind it, the present front; without one
 * to any solid neighbour, or to the metal that it hangs together with. Where there is none, it is rounding, and goes to
 * the fluid around. */
static pd_status pdi_dissolve_hand_over(pd_ctx *ctx, pd_dissolve *d, int32_t j, double rest)
{
    int count = d->bonds->stencil->count;
    for (int heir = PDI_DISSOLVE_BEHIND; heir <= PDI_DISSOLVE_FLUID; heir++) {
        double sum = 0.0;
        if (heir == PDI_DISSOLVE_FLUID && pdi_dissolve_pass_on(d, j, rest)) return PD_OK;
        for (int k = 0; k < count; k++) sum += pdi_dissolve_share(d, j, k, (pdi_dissolve_heir)heir);
        if (!(sum > 0.0)) continue;
        double *target = heir == PDI_DISSOLVE_FLUID ? d->transport->carry : d->transport->c;
        for (int k = 0; k < count; k++) {
            int32_t i = pdi_entry_far(d->bonds, j, k);
            double share = pdi_dissolve_share(d, j, k, (pdi_dissolve_heir)heir) / sum;
            if (share > 0.0) target[i] += rest * share * pdi_dissolve_over(d, j, i);
        }
        return PD_OK;
    }
    return pdi_fail(ctx, PD_ERR_INTERNAL, "dissolve", "node %d dissolved without any neighbour", (int)j);
}

static void pdi_dissolve_note(pd_dissolve *d, int32_t j)
{
    d->mark[j] |= PDI_DISSOLVE_TURNED;
    d->changed[d->changed_count++] = j;
}

/* Nodes within one bond of `j` may have become exposed. */
static void pdi_dissolve_expose(pd_dissolve *d, int32_t j)
{
    d->exposed[j] = 0;
    for (int k = 0; k < d->bonds->stencil->count; k++) {
        int32_t i = pdi_entry_far(d->bonds, j, k);
        if (d->grid->kind[i] == PD_SOLID) d->exposed[i] = 1;
    }
}

/* 1 when node j has to leave the solid: down to the lead with a layer behind it that stays, or empty. */
static int pdi_dissolve_spent(const pd_dissolve *d, int32_t j)
{
    double left = pdi_dissolve_left(d, j);
    if (left <= PDI_DISSOLVE_EMPTY) return 1;
    for (int k = 0; k < d->bonds->stencil->count && left <= d->lead; k++)
        if (pdi_dissolve_share(d, j, k, PDI_DISSOLVE_BEHIND) > 0.0 &&
            pdi_dissolve_left(d, pdi_entry_far(d->bonds, j, k)) > d->lead)
            return 1;
    return 0;
}

/* Spent nodes leave the solid, all of a round together, so that a flat layer leaves as one; what they hand over may
 * overdraw others, which leave in the next round. */
static pd_status pdi_dissolve_settle(pd_ctx *ctx, pd_dissolve *d)
{
    double *c = d->transport->c, floor_content = d->desc.threshold * d->desc.solid;
    for (int32_t first = 0;;) {
        for (int32_t f = 0; f < d->front_count; f++) {
            int32_t j = d->front[f];
            if (!(d->mark[j] & PDI_DISSOLVE_TURNED) && pdi_dissolve_spent(d, j)) pdi_dissolve_note(d, j);
        }
        if (first == d->changed_count) return PD_OK;
        for (int32_t n = first; n < d->changed_count; n++) pdi_grid_dissolve(d->grid, d->changed[n]);
        for (; first < d->changed_count; first++) {
            int32_t j = d->changed[first];
            double rest = c[j] - floor_content;
            c[j] = floor_content;
            if (fabs(rest) > 0.0) PDI_TRY(pdi_dissolve_hand_over(ctx, d, j, rest));
        }
    }
}

PDI_FN void pdi_dissolve_turned(pd_dissolve *d, const int32_t *turned, int32_t count)
{
    for (int32_t n = 0; n < count; n++) pdi_dissolve_expose(d, turned[n]);
    pdi_dissolve_collect(d);
}

pd_status pd_dissolve_finish(pd_ctx *ctx, pd_dissolve *d, double dt)
{
    double take = dt * pdi_dissolve_span(d), floor_content = d->desc.threshold * d->desc.solid, *c = d->transport->c;
    if (!d->rated) pdi_dissolve_rates(ctx, d);
    d->rated = d->changed_count = 0;
    /* the contents tell where the surface stands, so all rates come first */
    for (int32_t f = 0; f < d->front_count; f++) c[d->front[f]] -= take * d->rate[d->front[f]];
    for (int32_t n = 0; n < d->gone_count; n++) {
        c[d->piece[n]] = floor_content;
        pdi_dissolve_note(d, d->piece[n]);
    }
    PDI_TRY(pdi_dissolve_settle(ctx, d));
    if (d->changed_count) pdi_dissolve_turned(d, d->changed, d->changed_count);
    return PD_OK;
}

double pd_dissolve_stock(pd_ctx *ctx, const pd_dissolve *d)
{
    pdi_sum sum = {0.0, 0.0};
    (void)ctx;
    for (int32_t j = 0; j < d->grid->total; j++)
        if (d->grid->kind[j] == PD_SOLID) pdi_sum_add(&sum, d->transport->c[j] * pdi_grid_circumference(d->grid, j));
    return pdi_sum_total(&sum) * d->bonds->stencil->volume;
}

void pd_dissolve_free(pd_ctx *ctx, pd_dissolve *d)
{
    int32_t total = d->grid ? d->grid->total : 0;
    PDI_DELETE(ctx, total, d->exposed);
    PDI_DELETE(ctx, total, d->rate);
    PDI_DELETE(ctx, total, d->slot);
    PDI_DELETE(ctx, d->shore_capacity, d->shore);
    PDI_DELETE(ctx, total, d->mark);
    PDI_DELETE(ctx, d->capacity, d->front);
    PDI_DELETE(ctx, d->capacity, d->changed);
    PDI_DELETE(ctx, d->capacity, d->piece);
    memset(d, 0, sizeof *d);
}
