/* bend: see bend.h */
#include "transport/bend.h"

/* Sizes and rates below this, and sizes above 1 over it: their products are numbers of single precision. */
#define PDI_BEND_MOST 1e15

PDI_COLD_BEGIN
static void pdi_bend_list(pdi_owner *owner, void *object)
{
    pd_bend *bend = (pd_bend *)object;
    int64_t total = bend->bonds->grid->total;
    PDI_RAW(owner, bend, kept, 3 * (bend->bonds->stencil->count / 2) * total, "1/s");
}

/* [4 byte] entries of the basis that take the same room. */
static int64_t pdi_bend_entries(pd_bend *bend)
{
    return (int64_t)(pdi_arena_bytes(pdi_bend_list, bend) / sizeof *bend->kept);
}

PDI_FN void pdi_bend_lend(pd_ctx *ctx, pd_arena *arena, double size, double rate, pd_krylov *krylov, pd_bend *bend)
{
    int64_t entries = pdi_bend_entries(bend), least = (krylov->desc.restart + 1) * krylov->stride;
    int fits = krylov->desc.compressed == PD_KRYLOV_SINGLE && !krylov->desc.flexible;
    if (!(rate < PDI_BEND_MOST) || !(size < PDI_BEND_MOST) || !(size * PDI_BEND_MOST > 1.0)) return;
    if (!fits || krylov->built - entries < least || !pdi_arena_has(arena, pdi_krylov_list, krylov)) return;
    if (pdi_arena_lend(ctx, arena, pdi_bend_list, bend) < 0) return;
    krylov->built -= entries;
    pdi_krylov_pair(krylov, 0);
}

PDI_FN pd_status pdi_bend_return(pd_ctx *ctx, pd_arena *arena, pd_status status, pd_krylov *krylov, pd_bend *bend)
{
    if (!bend->kept) return status;
    krylov->built += pdi_bend_entries(bend);
    return pdi_arena_return(ctx, arena, pdi_bend_list, bend, status);
}
PDI_COLD_END

#undef PDI_BEND_MOST
