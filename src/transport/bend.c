/* bend: see bend.h */
#include "transport/bend.h"

/* Sizes and rates below this, and sizes above 1 over it: their products are numbers of single precision. */
#define PDI_BEND_MOST 1e15

PDI_COLD_BEGIN
static void pdi_bend_list(pdi_array_visitor *owner, void *object)
{
    pd_bend *bend = (pd_bend *)object;
    int64_t total = bend->bonds->grid->total;
    PDI_ARRAY_UNINIT(owner, bend, kept, 3 * (bend->bonds->stencil->count / 2) * total, "1/s");
}

PDI_FN void pdi_bend_lend(pd_ctx *ctx, pd_arena *arena, double size, double rate, pd_krylov *krylov, pd_bend *bend)
{
    if (!(rate < PDI_BEND_MOST) || !(size < PDI_BEND_MOST) || !(size * PDI_BEND_MOST > 1.0)) return;
    pdi_krylov_lend_basis(ctx, krylov, arena, pdi_bend_list, bend, krylov->desc.restart + 1);
}

PDI_FN pd_status pdi_bend_return(pd_ctx *ctx, pd_arena *arena, pd_status status, pd_krylov *krylov, pd_bend *bend)
{
    return bend->kept ? pdi_krylov_restore_basis(ctx, krylov, arena, pdi_bend_list, bend, status) : status;
}
PDI_COLD_END

#undef PDI_BEND_MOST
