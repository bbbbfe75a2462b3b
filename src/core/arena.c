/* arena: see arena.h */
#include "core/arena.h"
#include <string.h>

/* [byte] Alignment of the arrays: a cache line. */
#define PDI_ARENA_ALIGNMENT ((size_t)64)

/* Size [byte] of one array, rounded up to the alignment. An array without elements takes the room of one. */
static size_t pdi_arena_align_size(const pdi_array_entry *entry)
{
    size_t bytes = (size_t)(entry->count ? entry->count : 1) * entry->element_size;
    return (bytes + PDI_ARENA_ALIGNMENT - 1) / PDI_ARENA_ALIGNMENT * PDI_ARENA_ALIGNMENT;
}

/* Callback of the list: adds the aligned size of one array to owner->bytes. */
static void pdi_arena_visit_bytes(pdi_array_visitor *owner, const pdi_array_entry *entry)
{
    owner->bytes += (int64_t)pdi_arena_align_size(entry);
}

PDI_FN size_t pdi_arena_count_bytes(pdi_array_list_fn list, void *object)
{
    pdi_array_visitor owner;
    memset(&owner, 0, sizeof owner);
    owner.visit = pdi_arena_visit_bytes;
    list(&owner, object);
    return (size_t)owner.bytes;
}

PDI_FN pd_status pdi_arena_reserve(pd_ctx *ctx, pd_arena *arena, size_t bytes)
{
    if (arena->used)
        return pd_fail(ctx, PD_ERR_INTERNAL, "arena", "room is asked for while %.4g MB are lent",
                       (double)arena->used * 1e-6);
    if (arena->block && bytes <= arena->size) return PD_OK;
    PD_TRY(PD_GROW(ctx, "arena", arena->size + PDI_ARENA_ALIGNMENT, bytes + PDI_ARENA_ALIGNMENT, arena->block));
    arena->size = bytes;
    return PD_OK;
}

void pd_arena_free(pd_ctx *ctx, pd_arena *arena)
{
    PD_DELETE(ctx, arena->size + PDI_ARENA_ALIGNMENT, arena->block);
    memset(arena, 0, sizeof *arena);
}

/* The first aligned byte of the block. */
static unsigned char *pdi_arena_get_begin(const pd_arena *arena)
{
    return arena->block +
           (PDI_ARENA_ALIGNMENT - (size_t)((uintptr_t)arena->block % PDI_ARENA_ALIGNMENT)) % PDI_ARENA_ALIGNMENT;
}

/* One pass over a list that lends or returns its arrays. owner.bytes is the offset [byte] of the next array. */
typedef struct pdi_arena_visitor {
    pdi_array_visitor visitor; /* has to be the first member: callbacks cast its address */
    const pd_arena *arena;
    int mismatch; /* 1: an array is not at the address at which it was lent */
} pdi_arena_visitor;

/* Callback of the list: sets the pointer of one array to the place at the offset owner->bytes, which it moves on.
 * Zeroes the array except where its kind is PDI_ARRAY_KIND_UNINIT. */
static void pdi_arena_visit_acquire(pdi_array_visitor *owner, const pdi_array_entry *entry)
{
    const pdi_arena_visitor *walk = (const pdi_arena_visitor *)(void *)owner;
    void *at = pdi_arena_get_begin(walk->arena) + owner->bytes;
    size_t size = pdi_arena_align_size(entry);
    if (entry->kind != PDI_ARRAY_KIND_UNINIT) memset(at, 0, size);
    memcpy(entry->address, &at, sizeof at);
    owner->bytes += (int64_t)size;
}

/* Callback of the list: sets `mismatch` where one array is not at the address at which it was lent, and its pointer to
 * NULL. With PD_DEBUG it fills the array with NaN first. */
static void pdi_arena_visit_release(pdi_array_visitor *owner, const pdi_array_entry *entry)
{
    pdi_arena_visitor *walk = (pdi_arena_visitor *)(void *)owner;
    void *wanted = pdi_arena_get_begin(walk->arena) + owner->bytes, *at, *none = NULL;
    size_t size = pdi_arena_align_size(entry);
    memcpy(&at, entry->address, sizeof at);
    walk->mismatch = walk->mismatch || at != wanted;
#ifdef PD_DEBUG
    if (at == wanted) memset(at, 0xff, size); /* NaN: later reads show up */
#endif
    memcpy(entry->address, &none, sizeof none);
    owner->bytes += (int64_t)size;
}

/* Run a callback over a list; the first array lies at the offset `from` [byte] from the first aligned byte. Returns 1
 * when an array that is taken back is not where it was lent, else 0. */
static int pdi_arena_visit_arrays(const pd_arena *arena, void (*take)(pdi_array_visitor *, const pdi_array_entry *),
                                  pdi_array_list_fn list, void *object, size_t from)
{
    pdi_arena_visitor walk;
    memset(&walk, 0, sizeof walk);
    walk.visitor.visit = take;
    walk.visitor.bytes = (int64_t)from;
    walk.arena = arena;
    list(&walk.visitor, object);
    return walk.mismatch;
}

PDI_FN int pdi_arena_fits(const pd_arena *arena, pdi_array_list_fn list, void *object)
{
    return arena->block && pdi_arena_count_bytes(list, object) <= arena->size - arena->used;
}

PDI_FN pd_status pdi_arena_acquire(pd_ctx *ctx, pd_arena *arena, pdi_array_list_fn list, void *object)
{
    size_t bytes = pdi_arena_count_bytes(list, object);
    if (!pdi_arena_fits(arena, list, object))
        return pd_fail(ctx, PD_ERR_INTERNAL, "arena", "%.4g MB are asked for, %.4g of %.4g MB are lent: two solvers "
                       "work at the same time", (double)bytes * 1e-6, (double)arena->used * 1e-6,
                       (double)arena->size * 1e-6);
    pdi_arena_visit_arrays(arena, pdi_arena_visit_acquire, list, object, arena->used);
    arena->used += bytes;
    return PD_OK;
}

PDI_FN pd_status pdi_arena_release(pd_ctx *ctx, pd_arena *arena, pdi_array_list_fn list, void *object, pd_status status)
{
    size_t bytes = pdi_arena_count_bytes(list, object);
    int wrong = bytes > arena->used;
    if (!wrong) wrong = pdi_arena_visit_arrays(arena, pdi_arena_visit_release, list, object, arena->used - bytes);
    arena->used = wrong ? 0 : arena->used - bytes;
    if (!wrong || status < 0) return status;
    return pd_fail(ctx, PD_ERR_INTERNAL, "arena", "what is returned is not what was lent last: two solvers work at "
                   "the same time");
}

#undef PDI_ARENA_ALIGNMENT
