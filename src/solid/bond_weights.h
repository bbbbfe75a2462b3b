/* bond_weights: the weight w of each bond of a body (influence function, cell fraction, surface correction).
 *
 * On a lattice the weights of a complete family are stored once, by position in the stencil. A point has a list of its
 * own where a weight differs, as by the surface correction; so has each point of other bodies. Weights do not
 * know which bonds are broken: the body does.
 */
#ifndef PD_BOND_WEIGHTS_H
#define PD_BOND_WEIGHTS_H
#include "solid/body.h"

typedef struct pd_bond_weights {
    const pd_body *body;
    float *stencil_weight; /* [kinds] [-] of a lattice: w of a complete family by position in the stencil */
    const int64_t *begin; /* [count] begin of the list of a point in own, -1: it has none; NULL: no point has one */
    int64_t listed;
    int64_t *list;        /* [listed] that of a lattice; that of others is the row of the body */
    int64_t capacity;
    float *point_weight; /* [room] [-] w of all bonds of the points that have lists */
} pd_bond_weights;

#ifdef PDI_INTERNAL
/* Weight [-] of the current bond of point i; has to return the same bits at both ends. */
typedef double (*pdi_bond_weights_fn)(const void *self, int32_t i, const pd_bond_iterator *bond);

/* Describes the arrays of weights. */
PDI_FN void pdi_bond_weights_list(pdi_array_visitor *owner, void *weights);
/* Prepares an object without weights; the body is borrowed, and what stood in `weights` is overwritten, not freed. On a
 * lattice allocates stencil_weight. pdi_bond_weights_compute has to follow. After an error the object is empty. */
PDI_FN pd_status pdi_bond_weights_build(pd_ctx *ctx, const pd_body *body, pd_bond_weights *weights);
/* Computes the weights of all bonds, broken ones too, with a function and stores them in single precision; replaces
 * earlier ones. On a lattice stencil_weight holds those of a point deep in the bulk, and a point gets a list of its own
 * where any of its weights differs from them in single precision. Off a lattice all points have lists. */
PDI_FN pd_status pdi_bond_weights_compute(pd_ctx *ctx, pd_bond_weights *weights, pdi_bond_weights_fn weigh,
                                          const void *self);
/* Weights from the influence function and the cell fraction alone, without correction. */
PDI_FN pd_status pdi_bond_weights_compute_influence(pd_ctx *ctx, pd_bond_weights *weights, pd_influence influence);
PDI_FN void pdi_bond_weights_free(pd_ctx *ctx, pd_bond_weights *weights);

/* Weight [-] of the current bond of point i, broken or not. */
static inline float pdi_bond_weights_get(const pd_bond_weights *w, int32_t i, const pd_bond_iterator *bond)
{
    if (w->begin && w->begin[i] >= 0) return w->point_weight[w->begin[i] + bond->number];
    return w->stencil_weight[bond->stencil_position];
}
/* Weight [-] of the current bond of point i; 0: it is broken. */
static inline double pdi_bond_weights_get_intact(const pd_bond_weights *w, int32_t i, const pd_bond_iterator *bond)
{
    return pd_body_bond_is_broken(bond) ? 0.0 : (double)pdi_bond_weights_get(w, i, bond);
}
#endif

#endif
