/* footprint: the memory of a run, from its setup alone: nothing is built for it.
 *
 * Sizes of arrays times numbers of nodes, which are counted in a sample of the geometry. tests/run/test_footprint.c
 * compares it with measured peaks.
 */
#ifndef PD_FOOTPRINT_H
#define PD_FOOTPRINT_H
#include "scene/setup.h"

/* The estimate may be off by this share. */
#define PD_FOOTPRINT_ERROR 0.2

typedef struct pd_footprint {
    double nodes;                 /* [-] of the padded lattice */
    double cells;                 /* [-] of the box */
    double fluid, solid, cut;     /* [-] nodes; cut: fluid ones whose family is not whole */
    double near;                  /* [-] nodes within one bond of the surface of a medium */
    double bonds;                 /* [-] of a whole family */
    double bytes[PD_PART_COUNT];  /* [byte] */
    double working;               /* [byte] coarse levels, which appear in a run */
    double files;                 /* [byte] fields of files, and the largest picture */
    double balance;               /* [byte] while metal comes to rest, when no file is written */
    double all;                   /* [byte] */
} pd_footprint;

#define pd_footprint_estimate PD_NAME(pd_footprint_estimate)

/* What a run of the setup takes at most; shapes are sampled at some thousand points. */
PD_API void pd_footprint_estimate(const pd_setup *setup, pd_footprint *footprint);

#ifdef PDI_INTERNAL
/* dry: a run that writes nothing. PD_ERR_LIMIT when the estimate passes ctx->alloc.limit by more than its error;
 * PD_ERR_SIZE when the lattice has more nodes than an int32 counts. */
PDI_FN pd_status pdi_footprint_check(pd_ctx *ctx, const pd_setup *setup, int dry);
#endif

#endif
