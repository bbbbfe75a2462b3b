/* bond_weights: see bond_weights.h */
#include "solid/bond_weights.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

PDI_FN void pdi_bond_weights_list(pdi_array_visitor *owner, void *object)
{
    pd_bond_weights *weights = (pd_bond_weights *)object;
    int lattice = weights->body && weights->body->lattice;
    PDI_ARRAY(owner, weights, stencil_weight, lattice ? weights->body->stencil_bonds : 0, "1");
    PDI_ARRAY_GROWING(owner, weights, list, weights->listed, "1");
    PDI_ARRAY_GROWING(owner, weights, point_weight, weights->capacity, "1");
}

PDI_FN pd_status pdi_bond_weights_build(pd_ctx *ctx, const pd_body *body, pd_bond_weights *w)
{
    memset(w, 0, sizeof *w);
    w->body = body;
    pd_status status = pdi_array_registry_build(ctx, pdi_bond_weights_list, w);
    if (status < 0) memset(w, 0, sizeof *w);
    return status;
}

PDI_FN void pdi_bond_weights_free(pd_ctx *ctx, pd_bond_weights *w)
{
    pdi_array_registry_free(ctx, pdi_bond_weights_list, w);
    memset(w, 0, sizeof *w);
}

/* Sets stencil weights that are still unset (HUGE_VAL) from the bonds of point i. Returns how many it set. */
static int32_t pdi_bond_weights_set_stencil_weights(const pd_bond_weights *w, pdi_bond_weights_fn weigh,
                                                    const void *self, int32_t i)
{
    int32_t found = 0;
    for (pd_bond_iterator f = pd_body_bonds_begin(w->body, i); pd_body_bonds_next(&f);) {
        if (w->stencil_weight[f.stencil_position] < (float)HUGE_VAL) continue;
        w->stencil_weight[f.stencil_position] = (float)weigh(self, i, &f);
        found++;
    }
    return found;
}

/* Sum of the family sizes of point i and of its neighbours: largest for a point deep in the bulk. */
static int64_t pdi_bond_weights_count_nearby_bonds(const pd_body *body, int32_t i)
{
    int64_t bonds = body->first_bond[i + 1] - body->first_bond[i];
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
        bonds += body->first_bond[f.neighbour + 1] - body->first_bond[f.neighbour];
    return bonds;
}

/* Stencil weights from the point with the largest sum of its own family size and those of its neighbours, since a
 * surface correction depends on both ends of a bond; of ties the first. Positions that it lacks are set from other
 * points, in their order. */
static void pdi_bond_weights_init_stencil_weights(const pd_bond_weights *w, pdi_bond_weights_fn weigh, const void *self)
{
    const pd_body *body = w->body;
    int32_t inside = 0, known;
    int64_t most = -1;
    for (int32_t k = 0; k < body->stencil_bonds; k++) w->stencil_weight[k] = (float)HUGE_VAL;
    for (int32_t i = 0; i < body->count; i++) {
        int64_t around = pdi_bond_weights_count_nearby_bonds(body, i);
        if (around > most) inside = i;
        most = around > most ? around : most;
    }
    known = pdi_bond_weights_set_stencil_weights(w, weigh, self, inside);
    for (int32_t i = 0; i < body->count && known < body->stencil_bonds; i++)
        known += pdi_bond_weights_set_stencil_weights(w, weigh, self, i);
}

/* 1: a bond of point i has another weight, in single precision, than the stencil has. */
static int pdi_bond_weights_has_own(const pd_bond_weights *w, pdi_bond_weights_fn weigh, const void *self, int32_t i)
{
    for (pd_bond_iterator f = pd_body_bonds_begin(w->body, i); pd_body_bonds_next(&f);) {
        float weight = (float)weigh(self, i, &f), whole = w->stencil_weight[f.stencil_position];
        if (weight < whole || weight > whole) return 1;
    }
    return 0;
}

/* Lattice: begin of the list of each point that needs one, -1: none, into w->list. Returns the length of all lists. */
static int64_t pdi_bond_weights_mark_own(const pd_ctx *ctx, const pd_bond_weights *w, pdi_bond_weights_fn weigh,
                                         const void *self)
{
    const pd_body *body = w->body;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    int64_t all = 0;
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) w->list[i] = pdi_bond_weights_has_own(w, weigh, self, i) ? 0 : -1;
    for (int32_t i = 0; i < body->count; i++) {
        if (w->list[i] < 0) continue;
        w->list[i] = all;
        all += body->first_bond[i + 1] - body->first_bond[i];
    }
    return all;
}

/* Resizes `list` to `listed` points and point_weight to `room` weights; 0 frees the array. */
static pd_status pdi_bond_weights_resize(pd_ctx *ctx, pd_bond_weights *w, int64_t listed, int64_t room)
{
    if (!listed) PD_DELETE(ctx, w->listed, w->list);
    else if (w->listed != listed) PD_TRY(PD_GROW(ctx, "bond_weights", w->listed, listed, w->list));
    w->listed = listed;
    if (!room) PD_DELETE(ctx, w->capacity, w->point_weight);
    else if (w->capacity != room) PD_TRY(PD_GROW(ctx, "bond_weights", w->capacity, room, w->point_weight));
    w->capacity = room;
    return PD_OK;
}

PDI_FN pd_status pdi_bond_weights_compute(pd_ctx *ctx, pd_bond_weights *w, pdi_bond_weights_fn weigh, const void *self)
{
    const pd_body *body = w->body;
    int64_t room = body->bonds;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    (void)nt;
    w->begin = NULL;
    if (body->lattice) {
        PD_TRY(pdi_bond_weights_resize(ctx, w, body->count, w->capacity));
        pdi_bond_weights_init_stencil_weights(w, weigh, self);
        room = pdi_bond_weights_mark_own(ctx, w, weigh, self);
    }
    PD_TRY(pdi_bond_weights_resize(ctx, w, body->lattice && room ? body->count : 0, room));
    if (!room) return PD_OK;
    w->begin = body->lattice ? w->list : body->first_bond;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        if (w->begin[i] < 0) continue;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
            w->point_weight[w->begin[i] + f.number] = (float)weigh(self, i, &f);
    }
    return PD_OK;
}

/* ---- by length ---- */

/* Context of the weight by the influence function. */
typedef struct pdi_bond_weights_influence_params {
    const pd_body *body;
    pd_influence influence;
} pdi_bond_weights_influence_params;

/* The pdi_bond_weights_fn of the influence function and cell fraction; self: pdi_bond_weights_influence_params. */
static double pdi_bond_weights_compute_by_length(const void *self, int32_t i, const pd_bond_iterator *bond)
{
    const pdi_bond_weights_influence_params *by = (const pdi_bond_weights_influence_params *)self;
    double xi[PD_DIM];
    pdi_body_bond_vector(by->body, i, bond, xi);
    return pdi_body_compute_bond_weight(by->body, by->influence, xi);
}

PDI_FN pd_status pdi_bond_weights_compute_influence(pd_ctx *ctx, pd_bond_weights *w, pd_influence influence)
{
    pdi_bond_weights_influence_params by;
    by.body = w->body;
    by.influence = influence;
    return pdi_bond_weights_compute(ctx, w, pdi_bond_weights_compute_by_length, &by);
}
