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

/* Estimate the peak memory of a run of the setup, into all of *footprint; numbers of nodes come from some thousand
 * sample points of the shapes. Of output and mechanical equilibrium, which do not take place at the same time, the
 * larger counts. Nothing is allocated or refused. */
PD_API void pd_memory_estimate_compute(const pd_setup *setup, pd_memory_estimate *footprint);
/* Check the estimate before a run. dry: 1: a run that writes nothing, so that output does not count. PD_ERR_SIZE: the
 * lattice has more nodes than an int32 counts. PD_ERR_LIMIT: without the fixed share, it exceeds ctx->alloc.limit (0:
 * no limit) by more than its error of 20 %. */
PD_API pd_status pd_memory_estimate_check_limit(pd_ctx *ctx, const pd_setup *setup, int dry);

#endif
