/* arena: scratch memory that solvers share which never run at the same time.
 *
 * Krylov bases, work vectors and preconditioners are needed during a solve only. A module describes these arrays in a
 * list function of their own (array_registry.h), which is not allocated: the arena lends the arrays for a solve, as a
 * stack, and takes them back at its end. Each solver reserves its size when it is built, and the largest one counts, so
 * that a time step allocates nothing.
 *
 *   pdi_arena_reserve(ctx, arena, pdi_arena_count_bytes(pdi_steady_list_work, steady));      in the build
 *   PD_TRY(pdi_arena_acquire(ctx, arena, pdi_steady_list_work, steady));             in the solve
 *   ...
 *   status = pdi_arena_release(ctx, arena, pdi_steady_list_work, steady, status);
 *
 * Two solvers that run at the same time find no room, or return in the wrong order: PD_ERR_INTERNAL.
 */
#ifndef PD_ARENA_H
#define PD_ARENA_H
#include "core/array_registry.h"

/* Most multigrids that can leave the memory of their coarse levels to others. */
#define PD_ARENA_MAX_UNUSED 16

/* Zero-initialise. Its address must not change while objects that use it exist. */
typedef struct pd_arena {
    unsigned char *block; /* [size and an alignment] */
    size_t size;          /* [byte] capacity */
    size_t used;          /* [byte] that are lent, from the front on */
    void *unused[PD_ARENA_MAX_UNUSED]; /* stack of multigrids that are not in use: the next one in use takes over the
                                        * memory of the coarse levels of the last of them (multigrid.h). Borrowed */
    int unused_count;                  /* multigrids on that stack */
} pd_arena;

#define pd_arena_free PD_NAME(pd_arena_free)

/* Free the block and set the arena to zero. Nothing may be lent, and no solve may follow. */
PD_API void pd_arena_free(pd_ctx *ctx, pd_arena *arena);

#ifdef PDI_INTERNAL
/* Size [byte] that the arrays of a list take when they are lent, each rounded up to a cache line. The object need not
 * be built. */
PDI_FN PDI_NOINLINE size_t pdi_arena_count_bytes(pdi_array_list_fn list, void *object);
/* Reserve a capacity of at least `bytes`; it never shrinks, and nothing happens where it suffices. The block may move.
 * PD_ERR_INTERNAL: something is lent. On any failure the old block stays. */
PDI_FN PDI_NOINLINE pd_status pdi_arena_reserve(pd_ctx *ctx, pd_arena *arena, size_t bytes);
/* 1: the free part is large enough for the arrays of a list. 0: it is not, or nothing was reserved. */
PDI_FN PDI_NOINLINE int pdi_arena_fits(const pd_arena *arena, pdi_array_list_fn list, void *object);
/* Point the arrays of a list into the arena, behind what is lent already. They are zeroed, except those of kind
 * PDI_ARRAY_KIND_UNINIT. The list must have no scalars. PD_ERR_INTERNAL: there is no room, and no pointer changes. */
PDI_FN PDI_NOINLINE pd_status pdi_arena_acquire(pd_ctx *ctx, pd_arena *arena, pdi_array_list_fn list, void *object);
/* Take the arrays back and set their pointers to NULL. Returns `status`. Where the arrays are not those that were lent
 * last, nothing counts as lent any more, and PD_ERR_INTERNAL replaces a status that is no error. */
PDI_FN PDI_NOINLINE pd_status pdi_arena_release(pd_ctx *ctx, pd_arena *arena, pdi_array_list_fn list, void *object,
                                                pd_status status);
#endif

#endif
