/* bond_weights: how much each bond of a body counts.
 *
 * On a lattice the weights of a whole family stand once, by the kinds of its bonds. A point has a list of its own where
 * a bond counts otherwise, as at surfaces that factors make up for; so has each point of other bodies. Weights do not
 * know which bonds are broken: the body does.
 */
#ifndef PD_BOND_WEIGHTS_H
#define PD_BOND_WEIGHTS_H
#include "solid/body.h"

typedef struct pd_bond_weights {
    const pd_body *body;
    float *whole;         /* [kinds] [-] of a lattice: w by kinds of bonds */
    const int64_t *begin; /* [count] begin of the list of a point in own, -1: it has none; NULL: no point has one */
    int64_t listed;
    int64_t *list;        /* [listed] that of a lattice; that of others is the row of the body */
    int64_t room;
    float *own;           /* [room] [-] w of all bonds of the points that have lists */
} pd_bond_weights;

#ifdef PDI_INTERNAL
/* Weight of a bond of point i, both ends with the same bits. */
typedef double (*pdi_bond_weights_fn)(const void *self, int32_t i, const pd_walk *bond);

PDI_FN void pdi_bond_weights_list(pdi_owner *owner, void *weights);
/* The body is borrowed. pdi_bond_weights_find has to follow. */
PDI_FN pd_status pdi_bond_weights_build(pd_ctx *ctx, const pd_body *body, pd_bond_weights *weights);
/* Take weights from a function, in single precision. */
PDI_FN pd_status pdi_bond_weights_find(pd_ctx *ctx, pd_bond_weights *weights, pdi_bond_weights_fn weigh,
                                       const void *self);
/* Those that the body gives to its bonds by their length. */
PDI_FN pd_status pdi_bond_weights_plain(pd_ctx *ctx, pd_bond_weights *weights, pd_influence influence);
PDI_FN void pdi_bond_weights_free(pd_ctx *ctx, pd_bond_weights *weights);

/* Weight of a bond of point i, broken or not. */
static inline float pdi_bond_weights_of(const pd_bond_weights *w, int32_t i, const pd_walk *bond)
{
    if (w->begin && w->begin[i] >= 0) return w->own[w->begin[i] + bond->n];
    return w->whole[bond->kind];
}
/* The same; 0: it is broken. */
static inline double pdi_bond_weights_intact(const pd_bond_weights *w, int32_t i, const pd_walk *bond)
{
    return pdi_walk_broken(bond) ? 0.0 : (double)pdi_bond_weights_of(w, i, bond);
}
#endif

#endif
