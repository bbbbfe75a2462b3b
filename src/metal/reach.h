/* reach: bonds of exposed metal to fluid that takes it, in bond-based corrosion.
 *
 * They last from step to step. Where nodes have turned they are found again, and so is what metal gives there: a node
 * that turns costs what its surroundings do, not what the surface does.
 */
#ifndef PD_REACH_H
#define PD_REACH_H
#include "metal/entry.h"
#include "metal/metal.h"

#ifdef PDI_INTERNAL
/* Beside the marks of content.h, of fluid and metal: what is in the reach of the node has turned in the last step. */
enum { PDI_REACH_TOUCHED = 16 };

/* Where a walk over the bonds of an exposed node stands. */
typedef struct pdi_reach {
    const uint32_t *word;
    uint32_t bits; /* of the word, those to come */
    int base;      /* bond of its lowest bit */
    int bond;      /* the one found last */
    int words;     /* to come */
} pdi_reach;

static inline pdi_reach pdi_reach_of(const pd_dissolve *d, int32_t j)
{
    pdi_reach r;
    r.words = d->paths.words - 1;
    r.word = d->reach + (int64_t)d->slot[j] * d->paths.words;
    r.bits = *r.word;
    r.base = r.bond = 0;
    return r;
}

/* 1: r->bond is the next one. 0: there is none. */
static inline int pdi_reach_next(pdi_reach *r)
{
    while (!r->bits) {
        if (!r->words) return 0;
        r->words--;
        r->bits = *++r->word;
        r->base += 32;
    }
#if defined(__GNUC__)
    r->bond = r->base + __builtin_ctz(r->bits);
#else
    for (r->bond = r->base; !(r->bits >> (r->bond - r->base) & 1u);) r->bond++;
#endif
    r->bits &= r->bits - 1;
    return 1;
}

/* The far end of bond k of metal node j where it is fluid that takes metal; -1: it is not. */
PDI_FN int32_t pdi_reach_taker(const pd_dissolve *dissolve, int32_t j, int k);
/* Bonds and the fluid beside metal, as nodes and contents are now. Fluid that is as it was keeps what enters. */
PDI_FN pd_status pdi_reach_update(pd_ctx *ctx, pd_dissolve *dissolve);
/* Node i among the fluid beside metal, where it is put if it is not there. Where there is no room: a place that counts
 * for nothing, and beside_lacks. */
PDI_FN pdi_beside *pdi_reach_join(pd_dissolve *dissolve, int32_t i);
PDI_FN void pdi_reach_list(pdi_array_visitor *owner, void *dissolve);
/* Room for so many nodes beside metal, if there is less. All of them are forgotten. */
PDI_FN pd_status pdi_reach_make_room(pd_ctx *ctx, pd_dissolve *dissolve, int32_t count);
/* The same for more than there is room for, by a quarter. */
PDI_FN pd_status pdi_reach_make_more(pd_ctx *ctx, pd_dissolve *dissolve);
PDI_FN void pdi_reach_beside_list(pdi_array_visitor *owner, void *object);
#endif

#endif
