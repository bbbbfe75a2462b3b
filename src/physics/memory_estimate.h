/* memory_estimate: estimate of the memory of a run from its setup alone, before anything is built.
 *
 * Sizes of arrays times numbers of nodes, which are counted in a sample of the geometry.
 * tests/run/test_memory_estimate.c compares it with measured peaks.
 */
#ifndef PD_MEMORY_ESTIMATE_H
#define PD_MEMORY_ESTIMATE_H
#include "physics/physics_list.h"

#define pd_memory_estimate_compute PD_NAME(pd_memory_estimate_compute)
#define pd_memory_estimate_check_limit PD_NAME(pd_memory_estimate_check_limit)

/* Estimate the peak memory of a run of the setup; numbers of nodes come from some thousand sample points of the shapes.
 */
PD_API void pd_memory_estimate_compute(const pd_setup *setup, pd_memory_estimate *footprint);
/* Check the estimate before a run. dry: a run that writes nothing. PD_ERR_LIMIT: it exceeds ctx->alloc.limit by more
 * than its error; PD_ERR_SIZE: the lattice has more nodes than an int32 counts. */
PD_API pd_status pd_memory_estimate_check_limit(pd_ctx *ctx, const pd_setup *setup, int dry);

#endif
