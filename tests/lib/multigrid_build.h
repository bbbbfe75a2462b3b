/* A multigrid that has its arrays for itself, for tests and benchmarks; after solve/multigrid.h or pdcorr.h. */
#ifndef MULTIGRID_BUILD_H
#define MULTIGRID_BUILD_H

/* Allocate the finest level. PD_ERR_ARGUMENT: n or stride not positive. PD_ERR_SIZE: more than 2^31 - 1 cells. */
static pd_status multigrid_build(pd_ctx *ctx, const pd_multigrid_desc *desc, pd_multigrid *mg)
{
    pd_status status = pdi_multigrid_init(ctx, desc, mg);
    if (status == PD_OK && !desc->arena) status = pdi_array_registry_build(ctx, pdi_multigrid_setup_list, mg);
    if (status == PD_OK && !desc->arena) status = pdi_array_registry_build(ctx, pdi_multigrid_list, mg);
    if (status < 0) pdi_multigrid_free(ctx, mg);
    if (status == PD_OK && !desc->arena) pdi_multigrid_set_pointers(mg);
    return status;
}

#endif
