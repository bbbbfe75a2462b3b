/* conductance: conductances of the bonds of rows, found anew where nodes have turned.
 *
 * They hold from one change of the geometry to the next. Rows stand by number, so that sweeps read on in memory; when
 * rows come and go the others move, and only bonds with an end whose numbers are new are found again.
 */
#ifndef PD_CONDUCTANCE_H
#define PD_CONDUCTANCE_H
#include "transport/diffusion.h"

/* The first three are given before it is built. Fluid at rest has one diffusivity, so there a bond keeps in single
 * precision what it conducts otherwise than one between whole families. */
typedef struct pd_conductance {
    const pd_bonds *bonds;
    const pd_diffusion *diffusion;
    int rests;               /* 1: fluid at rest with one diffusivity, without inlets and outlets */
    double *bond;            /* [capacity/32][count][32] [1/s]; NULL at rest */
    float *more;             /* [capacity/32][count][32] [-] at rest: D a(n) times 1 + this is the conductance of an
                              * open bond. Closed ones: -1 where fluid is at the far end, else 0 */
    uint32_t *other;         /* [words][capacity] at rest: bit k of a row: bond k has another number than 0 there */
    double *shut;            /* [capacity] [1/s] at rest: what closed bonds to metal and walls would conduct */
    int32_t *node;           /* [capacity] nodes of the `rows` rows that they were last found for, `plain` of them
                              * plain */
    int32_t *from;           /* [capacity] where a row stood before; -1: nowhere. Work */
    int32_t rows, plain, capacity;
    uint32_t version;        /* of the bonds; 0: nothing is known */
} pd_conductance;

#ifdef PDI_INTERNAL
/* Rows whose conductances stand together. */
#define PDI_CONDUCTANCE_PAGE 32

/* Where bond k of a row stands; those of the next rows follow up to the end of its page. */
static inline int64_t pdi_conductance_place(const pd_conductance *c, int32_t row, int k)
{
    int64_t page = row / PDI_CONDUCTANCE_PAGE;
    return (page * c->bonds->stencil->count + k) * PDI_CONDUCTANCE_PAGE + row % PDI_CONDUCTANCE_PAGE;
}
/* [1/s] of bond k of a row. */
static inline double pdi_conductance_value(const pd_conductance *c, int32_t row, int k)
{
    if (!c->rests) return c->bond[pdi_conductance_place(c, row, k)];
    if (!pdi_bond_is_open(c->bonds, row, k)) return 0.0;
    return c->diffusion->desc.diffusivity * c->bonds->stencil->laplacian_weight[k] *
           (1.0 + (double)c->more[pdi_conductance_place(c, row, k)]);
}
/* [1/s] of bond k of `count` nodes, not at rest: rows from `row`, or nodes with whole families (-1). `space`: room for
 * what does not stand together. */
static inline const double *pdi_conductance_of(const pd_conductance *c, int32_t i, int32_t row, int k, int count,
                                               double *PD_RESTRICT space)
{
    if (row >= 0 && row % PDI_CONDUCTANCE_PAGE + count <= PDI_CONDUCTANCE_PAGE)
        return c->bond + pdi_conductance_place(c, row, k);
    for (int b = 0; b < count && row >= 0; b++) space[b] = c->bond[pdi_conductance_place(c, row + b, k)];
    if (row >= 0) return space;
    if (c->diffusion->field) {
        pdi_diffusion_bond(c->diffusion, i, k, count, 0, space);
        return space;
    }
    double whole = c->diffusion->desc.diffusivity * pdi_bond_get_laplacian_weights(c->bonds, i)[k];
    for (int b = 0; b < count; b++) space[b] = whole;
    return space;
}
/* What bond k of node i conducts, that would conduct `bond` in the fluid: more to the side of the box behind which an
 * inlet ghost lies, and beside the ends of inlets (eq. 6.5, 6.6). */
PDI_FN double pdi_conductance_beside(const pd_bonds *bonds, int32_t i, int k, double bond);
PDI_FN void pdi_conductance_list(pdi_array_visitor *owner, void *object);
/* Room for the rows of the bonds. */
PDI_FN pd_status pdi_conductance_fit(pd_ctx *ctx, pd_conductance *c);
/* After pdi_diffusion_update. */
PDI_FN void pdi_conductance_update(const pd_ctx *ctx, pd_conductance *c);
#endif

#endif
