/* conductance: conductances of the bonds of rows, found anew where nodes have turned.
 *
 * They hold from one change of the geometry to the next. Rows stand by number, so that sweeps read on in memory; when
 * rows come and go the others move, and only bonds with an end whose numbers are new are found again.
 */
#ifndef PD_CONDUCTANCE_H
#define PD_CONDUCTANCE_H
#include "transport/diffusion.h"

/* The first three are given before it is built. */
typedef struct pd_conductance {
    const pd_bonds *bonds;
    const pd_diffusion *diffusion;
    int rests;               /* 1: fluid at rest with one diffusivity, whose bonds need not be asked one by one */
    double *bond;            /* [capacity/64][count][64] [1/s] */
    double *shut;            /* [capacity] [1/s] conductance of what the closed bonds of a row would carry, when they
                              * end on metal and walls and the others are whole; -1: it is another row. NULL: not at
                              * rest */
    int32_t *node;           /* [capacity] nodes of the `rows` rows that they were last found for, `plain` of them
                              * plain */
    int32_t *from;           /* [capacity] where a row stood before; -1: nowhere. Work */
    int32_t rows, plain, capacity;
    uint32_t version;        /* of the bonds; 0: nothing is known */
} pd_conductance;

#ifdef PDI_INTERNAL
/* Rows whose conductances stand together. */
#define PDI_CONDUCTANCE_PAGE 64

/* Where the conductance of bond k of a row stands; those of the next rows follow up to the end of its page. */
static inline double *pdi_conductance_place(const pd_conductance *c, int32_t row, int k)
{
    int64_t page = row / PDI_CONDUCTANCE_PAGE;
    return c->bond + (page * c->bonds->stencil->count + k) * PDI_CONDUCTANCE_PAGE + row % PDI_CONDUCTANCE_PAGE;
}
/* Those of bond k of `count` nodes: rows from `row`, or nodes with whole families (-1). `space`: room for what does not
 * stand together. */
static inline const double *pdi_conductance_of(const pd_conductance *c, int32_t i, int32_t row, int k, int count,
                                               double *PD_RESTRICT space)
{
    if (row >= 0 && row % PDI_CONDUCTANCE_PAGE + count <= PDI_CONDUCTANCE_PAGE)
        return pdi_conductance_place(c, row, k);
    for (int b = 0; b < count && row >= 0; b++) space[b] = *pdi_conductance_place(c, row + b, k);
    if (row >= 0) return space;
    if (c->diffusion->field) {
        pdi_diffusion_bond(c->diffusion, i, k, count, 0, space);
        return space;
    }
    double whole = c->diffusion->desc.diffusivity * pdi_bond_lap(c->bonds, i)[k];
    for (int b = 0; b < count; b++) space[b] = whole;
    return space;
}
/* Fraction at which bond k of node i crosses the side of the box behind which its inlet ghost lies: there the inflow
 * has its value, and the ghost has it at any depth. */
PDI_FN double pdi_conductance_entry(const pd_bonds *bonds, int32_t i, int k);
PDI_FN void pdi_conductance_list(pdi_owner *owner, void *object);
/* Room for the rows of the bonds. */
PDI_FN pd_status pdi_conductance_fit(pd_ctx *ctx, pd_conductance *c);
/* After pdi_diffusion_update. */
PDI_FN void pdi_conductance_update(const pd_ctx *ctx, pd_conductance *c);
#endif

#endif
