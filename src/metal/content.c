/* content: see content.h */
#include "metal/content.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Content above the threshold that counts as none, as a fraction of Cs: rounding of the losses. */
#define PDI_CONTENT_EMPTY 1e-12
/* Nodes of a piece that may be used up within a step. */
#define PDI_CONTENT_SMALL 64

/* Content at which a node turns fluid, over the mean lead. It is fitted to discs (decisions: Dissolution). */
#define PDI_CONTENT_LEAD_SHARE 0.6

/* [cells] A place that near to the middle between two nodes lies there. */
#define PDI_CONTENT_TIE 1e-9

/* A solid neighbour that loses at most this share of what a node loses lies behind it. */
#define PDI_CONTENT_SHELTERED 0.6

/* Who can take over from a node that leaves. */
typedef enum pdi_content_receiver {
    PDI_CONTENT_BEHIND, /* solid that the fluid reaches clearly less than the node itself: the next layer */
    PDI_CONTENT_SOLID,  /* any solid */
    PDI_CONTENT_FLUID   /* fluid, through the next transport step */
} pdi_content_receiver;

/* A piece of metal: nodes that can hand over to each other, directly or through others. */
typedef struct pdi_content_piece {
    int32_t *node;
    int32_t count;
    double has, gives; /* [mol/m3 of a cell] above the threshold; in the step */
} pdi_content_piece;

/* Mean lead of the node set in cells: along an axis layer l loses the share a_l = sum over n_axis >= l of c(n) h, and
 * has on average lost its own share half and those of the layers below whole: sum_l (l - 1/2) a_l = sum c(n) h n^2 / 2
 * over n_axis > 0. */
PDI_FN double pdi_content_lead(const pd_stencil *s)
{
    double sum = 0.0;
    for (int k = 0; k < s->count; k++)
        for (int d = 0; d < PD_DIM; d++) {
            double n = (double)s->offset[k * PD_DIM + d];
            sum += 0.25 * s->area_weight[k] * s->h[d] * n * n / PD_DIM;
        }
    return PDI_CONTENT_LEAD_SHARE * sum;
}

PDI_FN void pdi_content_collect(pd_dissolve *d)
{
    d->front_count = 0;
    for (int32_t j = 0; j < d->grid->total; j++)
        if (d->exposed[j]) d->front[d->front_count++] = j;
}

PDI_FN int pdi_content_is_exposed(const pd_dissolve *d, int32_t j)
{
    if (d->grid->kind[j] != PD_SOLID) return 0;
    for (int k = 0; k < d->paths.stencil->count; k++)
        if (d->grid->kind[pdi_entry_far(&d->paths, j, k)] == PD_FLUID) return 1;
    return 0;
}

/* Share of the far end of bond k of node j in what j hands over; 0: it gets nothing. */
static double pdi_content_share(const pd_dissolve *d, int32_t j, int k, pdi_content_receiver receiver)
{
    int32_t i = pdi_entry_far(&d->paths, j, k);
    uint8_t wanted = receiver == PDI_CONTENT_FLUID ? PD_FLUID : PD_SOLID;
    if (i == j || d->grid->kind[i] != wanted || !pdi_entry_free(&d->paths, j, k)) return 0.0;
    if (receiver == PDI_CONTENT_FLUID) return d->weight[k];
    if (receiver == PDI_CONTENT_BEHIND && d->rate[i] > PDI_CONTENT_SHELTERED * d->rate[j]) return 0.0;
    return d->weight[k] * pdi_metal_factor(d, i);
}

/* Take j into the piece. */
static void pdi_content_see(pd_dissolve *d, int32_t j, pdi_content_piece *p)
{
    d->mark[j] |= PDI_CONTENT_SEEN;
    p->node[p->count++] = j;
}

/* Take the far ends of the bonds of node i into the piece, as far as they are metal that dissolves, or were when the
 * step began. */
static void pdi_content_spread(pd_dissolve *d, int32_t i, pdi_content_piece *p)
{
    for (int k = 0; k < d->paths.stencil->count; k++) {
        int32_t j = pdi_entry_far(&d->paths, i, k);
        if (d->grid->kind[j] != PD_SOLID && !(d->mark[j] & PDI_CONTENT_TURNED)) continue;
        if (pdi_metal_of(d, j) != pdi_metal_of(d, i)) continue;
        double weight = d->weight[k] * pdi_metal_factor(d, j);
        if (j == i || (d->mark[j] & PDI_CONTENT_SEEN) || !(weight > 0.0)) continue;
        if (pdi_entry_free(&d->paths, i, k)) pdi_content_see(d, j, p);
    }
}

static void pdi_content_begin(pd_dissolve *d, int32_t j, pdi_content_piece *p)
{
    p->node = d->piece + d->gone_count;
    p->count = 0;
    p->has = p->gives = 0.0;
    pdi_content_see(d, j, p);
}

static void pdi_content_label(pd_dissolve *d, const pdi_content_piece *p, int label)
{
    for (int32_t n = 0; n < p->count; n++)
        d->mark[p->node[n]] = (uint8_t)((d->mark[p->node[n]] & ~PDI_CONTENT_SEEN) | label);
}

/* 1: the piece of node j has more than it gives in the step. The search ends early when the piece has more than all
 * metal gives. */
static int pdi_content_lasts(pd_dissolve *d, int32_t j, double dt, double all, pdi_content_piece *p)
{
    double take = dt * pdi_metal_supply(d, j);
    pdi_content_begin(d, j, p);
    for (int32_t n = 0; n < p->count; n++) {
        int32_t i = p->node[n];
        double around = pd_grid_circumference(d->grid, i);
        p->has += (d->transport->c[i] - pdi_metal_end(d, i)) * around;
        if (d->exposed[i]) p->gives += take * d->rate[i] * around;
        if (p->has > all || (d->mark[i] & PDI_CONTENT_LASTS)) return 1;
        pdi_content_spread(d, i, p);
    }
    return p->has > p->gives;
}

/* What the piece gives by its law at the present concentrations, scaled to what it has. */
static void pdi_content_give(pd_dissolve *d, const pdi_content_piece *p)
{
    pdi_entry entry;
    double share = p->has / p->gives;
    for (int32_t n = 0; n < p->count; n++) {
        int32_t j = p->node[n];
        for (int k = 0; k < d->paths.stencil->count && d->exposed[j]; k++) {
            pdi_interface_find(d, j, k, &entry);
            for (int e = 0; e < entry.count; e++) {
                int32_t i = entry.node[e];
                double weight = pdi_interface_weight(d, j, i, k, &entry);
                if (d->slot[i] < 0 || !(weight > 0.0)) continue;
                pdi_metal_beside *portion = &pdi_metal_portion(d, &d->beside[d->slot[i]])[pdi_metal_of(d, j)];
                portion->paid += share * pdi_metal_drive(d, j, i) * weight;
                portion->used += weight;
                portion->used_stock += weight * d->transport->c[j];
            }
        }
    }
}

/* What all metal gives in the step [mol/m3 of a cell]. */
static double pdi_content_all(const pd_dissolve *d, double dt)
{
    double all = 0.0;
    for (int32_t f = 0; f < d->front_count; f++) {
        int32_t j = d->front[f];
        all += pd_max(dt * pdi_metal_supply(d, j) * d->rate[j], 0.0) * pd_grid_circumference(d->grid, j);
    }
    return all;
}

PDI_FN int pdi_content_spare(pd_dissolve *d, double dt)
{
    double all = -1.0;
    int found = 0;
    for (int32_t j = 0; j < d->grid->total; j++) d->mark[j] &= (uint8_t)~PDI_CONTENT_LASTS;
    for (int32_t f = 0; f < d->front_count; f++) {
        int32_t j = d->front[f];
        pdi_content_piece piece;
        if (d->mark[j] & (PDI_CONTENT_LASTS | PDI_CONTENT_GONE)) continue;
        if (pdi_metal_left(d, j) > dt * d->rate[j]) continue;
        if (all < 0.0) all = pdi_content_all(d, dt);
        int lasts = pdi_content_lasts(d, j, dt, all, &piece);
        pdi_content_label(d, &piece, lasts ? PDI_CONTENT_LASTS : PDI_CONTENT_GONE);
        if (lasts) continue;
        pdi_content_give(d, &piece);
        d->gone_count += piece.count;
        found++;
    }
    if (found) pdi_interface_spare(d);
    for (int32_t n = 0; n < d->beside_count * d->kinds; n++)
        d->portion[n].used = d->portion[n].used_stock = d->portion[n].paid = 0.0;
    return found;
}

/* What a piece gives to, by the present lists. */
static void pdi_content_reached(const pd_dissolve *d, const pdi_content_piece *p, int32_t piece, pdi_content_put_fn put,
                                void *user)
{
    pdi_entry entry;
    for (int32_t n = 0; n < p->count; n++) {
        int32_t j = p->node[n];
        for (int k = 0; k < d->paths.stencil->count && d->exposed[j]; k++) {
            pdi_interface_find(d, j, k, &entry);
            for (int e = 0; e < entry.count; e++) {
                double weight = pdi_interface_weight(d, j, entry.node[e], k, &entry);
                if (d->slot[entry.node[e]] < 0 || !(weight > 0.0)) continue;
                put(user, piece, p->has, pdi_metal_of(d, j), entry.node[e], weight);
            }
        }
    }
}

PDI_FN int pdi_content_small(pd_dissolve *d, pdi_content_put_fn put, void *user)
{
    int32_t piece = 0;
    int others = 0;
    for (int32_t j = 0; j < d->grid->total; j++) d->mark[j] &= (uint8_t)~PDI_CONTENT_LASTS;
    for (int32_t f = 0; f < d->front_count; f++) {
        pdi_content_piece p;
        int large = 0;
        if (d->mark[d->front[f]] & PDI_CONTENT_LASTS) continue;
        pdi_content_begin(d, d->front[f], &p);
        for (int32_t n = 0; n < p.count && !large; n++) {
            int32_t i = p.node[n];
            large = p.count > PDI_CONTENT_SMALL || (d->mark[i] & PDI_CONTENT_LASTS);
            p.has += (d->transport->c[i] - pdi_metal_end(d, i)) * pd_grid_circumference(d->grid, i);
            if (!large) pdi_content_spread(d, i, &p);
        }
        pdi_content_label(d, &p, PDI_CONTENT_LASTS);
        if (!large) pdi_content_reached(d, &p, piece++, put, user);
        others = others || large;
    }
    return others;
}

/* Move `rest` to the nearest solid nodes that j hangs together with, over nodes that have turned fluid in this step. 0:
 * there are none. */
static int pdi_content_pass_on(pd_dissolve *d, int32_t j, double rest)
{
    pdi_content_piece p;
    int32_t begin = 0, end = 1, found = 0;
    pdi_content_begin(d, j, &p);
    while (begin < end && !found) {
        for (int32_t n = begin; n < end; n++) pdi_content_spread(d, p.node[n], &p);
        begin = end;
        end = p.count;
        for (int32_t n = begin; n < end; n++) found += d->grid->kind[p.node[n]] == PD_SOLID;
    }
    for (int32_t n = begin; n < end; n++)
        if (d->grid->kind[p.node[n]] == PD_SOLID)
            d->transport->c[p.node[n]] += rest / found * pdi_metal_over(d, j, p.node[n]);
    pdi_content_label(d, &p, 0);
    return found > 0;
}

/* 1: bond k of node j leads to the same metal. */
static int pdi_content_same(const pd_dissolve *d, int32_t j, int k)
{
    return pdi_metal_of(d, pdi_entry_far(&d->paths, j, k)) == pdi_metal_of(d, j);
}

/* From the fluid into the metal at node j, of any length. */
static void pdi_content_inward(const pd_dissolve *d, int32_t j, double *normal)
{
    const pd_stencil *s = d->paths.stencil;
    for (int a = 0; a < PD_DIM; a++) normal[a] = 0.0;
    for (int k = 0; k < s->count; k++) {
        uint8_t kind = d->grid->kind[pdi_entry_far(&d->paths, j, k)];
        double sign = kind == PD_SOLID ? 1.0 : kind == PD_FLUID ? -1.0 : 0.0;
        for (int a = 0; a < PD_DIM; a++) normal[a] += sign * d->weight[k] * s->xi[k * PD_DIM + a];
    }
}

/* The bond along which node j hands over the share of bond k: k itself, unless k leads to another metal. Then the share
 * goes as deep into the metal of j, straight behind j. As much would have come from the other metal, so a flat front
 * over two metals stays flat. -1: none. */
static int pdi_content_path(const pd_dissolve *d, int32_t j, int k, const double *inward, pdi_content_receiver receiver)
{
    const pd_stencil *s = d->paths.stencil;
    const double *xi = s->xi + k * PD_DIM;
    double length = pdi_vec_dot(inward, inward), along = 0.0;
    int32_t n[PD_DIM];
    if (receiver == PDI_CONTENT_FLUID || pdi_content_same(d, j, k)) return k;
    if (length > 0.0) along = pdi_vec_dot(xi, inward) / length;
    for (int a = 0; a < PD_DIM; a++) {
        double cells = along * inward[a] / s->h[a]; /* the middle between two goes to the nearer one on both sides */
        n[a] = (int32_t)floor(fabs(cells) + 0.5 - PDI_CONTENT_TIE) * (cells < 0.0 ? -1 : 1);
    }
    for (int b = 0; b < s->count; b++) {
        int equal = 1;
        for (int a = 0; a < PD_DIM; a++) equal = equal && s->offset[b * PD_DIM + a] == n[a];
        if (equal) return pdi_content_same(d, j, b) && pdi_content_share(d, j, b, receiver) > 0.0 ? b : -1;
    }
    return -1;
}

/* Move `rest` from node j to the layer behind it, the present front. `rest` is what j still holds; it is negative when
 * j has given too much. Without such a layer it goes to any solid neighbour, else to the metal that j hangs together
 * with. Without any metal it is rounding, and goes to the fluid around. */
static pd_status pdi_content_hand_over(pd_ctx *ctx, pd_dissolve *d, int32_t j, double rest)
{
    int count = d->paths.stencil->count;
    double inward[PD_DIM] = {0.0};
    if (d->kinds > 1) pdi_content_inward(d, j, inward);
    for (int order = PDI_CONTENT_BEHIND; order <= PDI_CONTENT_FLUID; order++) {
        pdi_content_receiver receiver = (pdi_content_receiver)order;
        double sum = 0.0;
        if (receiver == PDI_CONTENT_FLUID && pdi_content_pass_on(d, j, rest)) return PD_OK;
        for (int k = 0; k < count; k++)
            if (pdi_content_path(d, j, k, inward, receiver) >= 0) sum += pdi_content_share(d, j, k, receiver);
        if (!(sum > 0.0)) continue;
        double *target = receiver == PDI_CONTENT_FLUID ? d->transport->carry : d->transport->c;
        for (int k = 0; k < count; k++) {
            int path = pdi_content_path(d, j, k, inward, receiver);
            double share = pdi_content_share(d, j, k, receiver) / sum;
            if (path < 0 || !(share > 0.0)) continue;
            int32_t i = pdi_entry_far(&d->paths, j, path);
            target[i] += rest * share * pdi_metal_over(d, j, i);
            if (receiver == PDI_CONTENT_FLUID && d->shed)
                pdi_metal_shed(d, pdi_metal_of(d, j))[i] += rest * share * pdi_metal_over(d, j, i);
        }
        return PD_OK;
    }
    return pd_fail(ctx, PD_ERR_INTERNAL, "dissolve", "node %d dissolved without any neighbour", (int)j);
}

static void pdi_content_note(pd_dissolve *d, int32_t j)
{
    d->mark[j] |= PDI_CONTENT_TURNED;
    d->changed[d->changed_count++] = j;
}

/* Node j has turned fluid. Nodes within one bond may be exposed now, and what reaches them has to be found anew. */
static void pdi_content_expose(pd_dissolve *d, int32_t j)
{
    d->exposed[j] = 0;
    d->slot[j] = -1;
    d->lags = 1;
    d->mark[j] |= PDI_REACH_TOUCHED;
    for (int k = 0; k < d->paths.stencil->count; k++) {
        int32_t i = pdi_entry_far(&d->paths, j, k);
        d->mark[i] |= PDI_REACH_TOUCHED;
        if (d->grid->kind[i] == PD_SOLID) d->exposed[i] = 1;
    }
}

/* 1 when node j has to leave the solid: down to the lead with a layer behind it that stays, or empty. Without a rate
 * nothing tells which layer is behind, and metal at rest stays as it is. */
static int pdi_content_spent(const pd_dissolve *d, int32_t j)
{
    double left = pdi_metal_left(d, j);
    if (left <= PDI_CONTENT_EMPTY) return 1;
    if (!(d->rate[j] > 0.0)) return 0;
    for (int k = 0; k < d->paths.stencil->count && left <= d->lead; k++)
        if (pdi_content_same(d, j, k) && pdi_content_share(d, j, k, PDI_CONTENT_BEHIND) > 0.0 &&
            pdi_metal_left(d, pdi_entry_far(&d->paths, j, k)) > d->lead)
            return 1;
    return 0;
}

/* Spent nodes leave the solid. All of a round leave together, so a flat layer leaves as one. What they hand over may be
 * negative and empty other nodes, which leave in the next round. */
static pd_status pdi_content_turn_spent(pd_ctx *ctx, pd_dissolve *d)
{
    double *c = d->transport->c;
    for (int32_t first = 0;;) {
        for (int32_t f = 0; f < d->front_count; f++) {
            int32_t j = d->front[f];
            if (!(d->mark[j] & PDI_CONTENT_TURNED) && pdi_content_spent(d, j)) pdi_content_note(d, j);
        }
        if (first == d->changed_count) return PD_OK;
        for (int32_t n = first; n < d->changed_count; n++) pdi_grid_set_fluid(d->grid, d->changed[n]);
        for (; first < d->changed_count; first++) {
            int32_t j = d->changed[first];
            double rest = c[j] - pdi_metal_end(d, j);
            c[j] = pdi_metal_end(d, j);
            if (fabs(rest) > 0.0) PD_TRY(pdi_content_hand_over(ctx, d, j, rest));
        }
    }
}

/* ---- bonds: a node turns at the end of the step that is closest to its own end ---- */

/* The far end of bond k of node i when it is another solid node of the same metal, which has not turned, and no wall
 * lies in between. -1: it is not. */
static int32_t pdi_content_behind(const pd_dissolve *d, int32_t i, int k)
{
    int32_t at = pdi_entry_far(&d->paths, i, k);
    if (at == i || d->grid->kind[at] != PD_SOLID || (d->mark[at] & PDI_CONTENT_TURNED)) return -1;
    if (pdi_metal_of(d, at) != pdi_metal_of(d, i)) return -1;
    return pdi_entry_free(&d->paths, i, k) ? at : -1;
}

/* What node i holds at least as it turns [mol/m3]. Above saturation nothing dissolves into it, so the metal behind
 * gives nothing of what a step takes below its random end. Under activation control it does. */
static double pdi_content_least(const pd_dissolve *d, int32_t i)
{
    return d->desc.activation ? pdi_metal_end(d, i) : d->kind[pdi_metal_of(d, i)].end;
}

/* Node i is below what it holds at least. It takes what it lacks from the metal in its reach, in proportion to the
 * weights. No metal gives more than it has above its end. What is still lacking is shared again, until it is covered or
 * no metal has any. Metal that is drained turns, too. */
static void pdi_content_take(pd_dissolve *d, int32_t i)
{
    double *c = d->transport->c, lacks = pdi_content_least(d, i) - c[i];
    int again = 1;
    while (lacks > 0.0 && again) {
        double sum = 0.0, given = 0.0, share = lacks;
        again = 0;
        for (int k = 0; k < d->paths.stencil->count; k++) {
            int32_t at = pdi_content_behind(d, i, k);
            if (at >= 0 && c[at] > pdi_metal_end(d, at)) sum += d->weight[k];
        }
        for (int k = 0; k < d->paths.stencil->count && sum > 0.0; k++) {
            int32_t at = pdi_content_behind(d, i, k);
            if (at < 0 || !(c[at] > pdi_metal_end(d, at))) continue;
            double has = (c[at] - pdi_metal_end(d, at)) * pdi_metal_over(d, at, i), part = share * (d->weight[k] / sum);
            if (part >= has) {
                part = has;
                c[at] = pdi_metal_end(d, at);
                pdi_content_note(d, at);
                again = 1;
            } else c[at] -= part * pdi_metal_over(d, i, at);
            given += part;
        }
        c[i] += given;
        lacks = again ? lacks - given : 0.0;
    }
}

/* 1: metal that fluid reaches, that has room below Cs, and that does not turn in the next step. Hand-over within a
 * layer would roughen the front. */
static int pdi_content_receives(const pd_dissolve *d, int32_t at, double dt)
{
    const double *c = d->transport->c;
    double take = dt * pdi_metal_supply(d, at);
    return d->exposed[at] && c[at] < pdi_metal_solid(d, at) && c[at] - pdi_metal_end(d, at) > take * d->rate[at];
}

/* Node i passes what it has above its end to such metal, in proportion to the weights. No node gets more than whole
 * metal has. What is left is shared again, and stays when no node has room. */
static void pdi_content_give_up(pd_dissolve *d, int32_t i, double dt)
{
    double *c = d->transport->c, end = pdi_metal_end(d, i), left = c[i] - end;
    int full = 1;
    while (left > 0.0 && full) {
        double sum = 0.0, given = 0.0;
        full = 0;
        for (int k = 0; k < d->paths.stencil->count; k++) {
            int32_t at = pdi_content_behind(d, i, k);
            if (at >= 0 && pdi_content_receives(d, at, dt)) sum += d->weight[k];
        }
        if (!(sum > 0.0)) break;
        for (int k = 0; k < d->paths.stencil->count; k++) {
            int32_t at = pdi_content_behind(d, i, k);
            if (at < 0 || !pdi_content_receives(d, at, dt)) continue;
            double solid = pdi_metal_solid(d, at), room = (solid - c[at]) * pdi_metal_over(d, at, i);
            double part = left * (d->weight[k] / sum);
            if (part >= room) {
                part = room;
                c[at] = solid;
                full = 1;
            } else c[at] += part * pdi_metal_over(d, i, at);
            given += part;
        }
        left = full ? left - given : 0.0;
    }
    c[i] = end + pd_max(left, 0.0);
}

/* 1: a node that turns keeps what it holds above saturation: random breaking ends above it. */
static int pdi_content_keeps(const pd_dissolve *d, int32_t i)
{
    return pdi_metal_end(d, i) > pdi_content_least(d, i);
}

static pd_status pdi_content_saturate(pd_ctx *ctx, pd_dissolve *d, double dt)
{
    double *c = d->transport->c;
    int32_t candidates = 0;
    for (int32_t f = 0; f < d->front_count; f++) {
        int32_t i = d->front[f];
        if (d->mark[i] & PDI_CONTENT_TURNED) continue;
        double take = dt * pdi_metal_supply(d, i);
        if (c[i] - 0.5 * take * d->rate[i] <= pdi_metal_end(d, i)) d->piece[candidates++] = i;
    }
    for (int32_t n = 0; n < candidates; n++) {
        int32_t i = d->piece[n];
        if (c[i] > pdi_metal_end(d, i) && !pdi_content_keeps(d, i)) pdi_content_give_up(d, i, dt);
    }
    for (int32_t n = 0; n < candidates; n++) {
        int32_t i = d->piece[n];
        if (c[i] <= pdi_metal_end(d, i) || pdi_content_keeps(d, i)) pdi_content_note(d, i);
    }
    for (int32_t n = 0; n < d->changed_count; n++) pdi_content_take(d, d->changed[n]); /* the list may grow */
    for (int32_t n = 0; n < d->changed_count; n++) pdi_grid_set_fluid(d->grid, d->changed[n]);
    for (int32_t n = 0; n < d->changed_count; n++) {
        int32_t i = d->changed[n];
        double least = pdi_content_least(d, i), rest = c[i] - least;
        if (rest > 0.0 && pdi_content_keeps(d, i)) continue;
        c[i] = least;
        if (fabs(rest) > 0.0) PD_TRY(pdi_content_hand_over(ctx, d, i, rest));
    }
    return PD_OK;
}

/* Activation control: what a node that turns holds above the fluid is gone. */
static void pdi_content_rinse(const pd_ctx *ctx, pd_dissolve *d, double dt)
{
    pdi_compensated_sum gone = {0.0, 0.0};
    double *c = d->transport->c, *gain = d->transport->source;
    for (int32_t k = 0; k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        gain[beside->node] = beside->weight * pdi_interface_line(d, beside) + beside->given;
    }
    pdi_compensated_sum_add(&gone, dt * pdi_grid_sum_field(ctx, d->grid, PD_FLUID, NULL, 0, gain));
    for (int32_t n = 0; n < d->changed_count; n++) {
        int32_t i = d->changed[n];
        pdi_compensated_sum_add(&gone, (c[i] - d->desc.bulk) * pd_grid_circumference(d->grid, i));
        c[i] = d->desc.bulk;
    }
    d->rinsed = pdi_compensated_sum_total(&gone) * d->paths.stencil->volume;
}

PDI_FN void pdi_content_turned(pd_dissolve *d, const int32_t *turned, int32_t count)
{
    for (int32_t n = 0; n < count; n++) pdi_content_expose(d, turned[n]);
    pdi_content_collect(d);
}

PDI_FN pd_status pdi_content_finish(pd_ctx *ctx, pd_dissolve *d, double dt)
{
    double *c = d->transport->c;
    d->changed_count = 0;
    /* the place of the surface follows from the contents, so all rates come first */
    for (int32_t f = 0; f < d->front_count; f++)
        c[d->front[f]] -= dt * pdi_metal_supply(d, d->front[f]) * d->rate[d->front[f]];
    for (int32_t n = 0; n < d->gone_count; n++) {
        c[d->piece[n]] = pdi_metal_end(d, d->piece[n]);
        pdi_content_note(d, d->piece[n]);
    }
    if (pdi_metal_bonds(d)) PD_TRY(pdi_content_saturate(ctx, d, dt));
    else PD_TRY(pdi_content_turn_spent(ctx, d));
    if (d->desc.activation) pdi_content_rinse(ctx, d, dt);
    if (d->changed_count) pdi_content_turned(d, d->changed, d->changed_count);
    return PD_OK;
}

PDI_FN double pdi_content_stock(const pd_ctx *ctx, const pd_dissolve *d, double *volume)
{
    double stock = 0.0;
    *volume = 0.0;
    for (int m = 0; m < d->kinds; m++) {
        double amount = pdi_grid_sum_field(ctx, d->grid, PD_SOLID, d->desc.metal, m, d->transport->c);
        stock += amount * d->paths.stencil->volume;
        *volume += amount / d->kind[m].solid * d->paths.stencil->volume;
    }
    return stock;
}
