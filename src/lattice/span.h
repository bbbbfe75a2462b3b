/* span: of each lattice line along axis 0, the run of nodes that holds fluid or may come to hold it.
 *
 * Vectors of unknowns that are kept in number take the runs only, one behind the other: neither ghosts nor walls
 * outside of a tube.
 */
#ifndef PD_SPAN_H
#define PD_SPAN_H
#include "lattice/grid.h"

typedef struct pd_spans {
    int32_t count, capacity;
    int32_t *first, *start, *length; /* [count] first node, place of it among `nodes`, nodes */
    int32_t nodes;                   /* of all */
    int32_t total;                   /* of the grid */
} pd_spans;

#ifdef PDI_INTERNAL
/* Solid nodes belong to them: they dissolve. */
PDI_FN pd_status pdi_spans_build(pd_ctx *ctx, const pd_grid *grid, pd_spans *spans);
PDI_FN void pdi_spans_free(pd_ctx *ctx, pd_spans *spans);
/* Take packed [components][nodes] from full [components][total], and bring it back, with zeros between. */
PDI_FN void pdi_spans_pack(const pd_ctx *ctx, const pd_spans *spans, int components, const double *full,
                           double *packed);
PDI_FN void pdi_spans_unpack(const pd_ctx *ctx, const pd_spans *spans, int components, const double *packed,
                             double *full);
#endif

#endif
