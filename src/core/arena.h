/* arena: memory that solvers share which never work at the same time.
 *
 * What a solver needs for the time of a solve alone, bases, vectors and preconditioners, would else lie idle while the
 * others work. A module names these arrays in a list of their own (owner.h). The list is not built: an arena lends its
 * arrays for a solve and takes them back at the end of it, the last one first. Each solver asks for its room when it is
 * built, and the largest one counts, so that a step allocates nothing.
 *
 *   pdi_arena_fit(ctx, arena, pdi_arena_bytes(pdi_steady_work_list, steady));      in the build
 *   PDI_TRY(pdi_arena_lend(ctx, arena, pdi_steady_work_list, steady));             in the solve
 *   ...
 *   status = pdi_arena_return(ctx, arena, pdi_steady_work_list, steady, status);
 *
 * Two that work at the same time after all find no room, or return in the wrong order: PD_ERR_INTERNAL.
 */
#ifndef PD_ARENA_H
#define PD_ARENA_H
#include "core/owner.h"

/* Multigrids that leave their coarse levels to others. */
#define PD_ARENA_IDLE 16

/* Zero-initialise. It must not be moved while something is built that uses it. */
typedef struct pd_arena {
    unsigned char *block; /* [size and an alignment] */
    size_t size;          /* [byte] that can be lent */
    size_t used;          /* [byte] of them, from the front on */
    void *idle[PD_ARENA_IDLE]; /* multigrids that do not work now: the next one to work takes the memory of the coarse
                                * levels of the last of them (multigrid.h). Borrowed */
    int idles;
} pd_arena;

#define pd_arena_free PD_NAME(pd_arena_free)

/* No solve comes after that. */
PD_API void pd_arena_free(pd_ctx *ctx, pd_arena *arena);

#ifdef PDI_INTERNAL
/* [byte] that lending the arrays of a list takes; nothing has to be built. */
PDI_FN PDI_ONCE size_t pdi_arena_bytes(pdi_list_fn list, void *object);
/* Room for so many bytes, or what there is if that is more. PD_ERR_INTERNAL: something is lent. */
PDI_FN PDI_ONCE pd_status pdi_arena_fit(pd_ctx *ctx, pd_arena *arena, size_t bytes);
/* 1: there is room for the arrays of a list. */
PDI_FN PDI_ONCE int pdi_arena_has(const pd_arena *arena, pdi_list_fn list, void *object);
/* Point the arrays of a list into the arena: zeros, but for those of PDI_RAW. PD_ERR_INTERNAL: there is no room. */
PDI_FN PDI_ONCE pd_status pdi_arena_lend(pd_ctx *ctx, pd_arena *arena, pdi_list_fn list, void *object);
/* Take them back: their pointers become NULL. Returns `status`, or when that is no error PD_ERR_INTERNAL: they are not
 * what was lent last. */
PDI_FN PDI_ONCE pd_status pdi_arena_return(pd_ctx *ctx, pd_arena *arena, pdi_list_fn list, void *object,
                                           pd_status status);
#endif

#endif
