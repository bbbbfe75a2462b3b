/* arena: see arena.h */
#include "core/arena.h"
#include <string.h>

/* [byte] Alignment of the arrays: a cache line. */
#define PDI_ARENA_LINE ((size_t)64)

/* Size [byte] of one array, rounded up to the alignment. */
static size_t pdi_arena_size(const pdi_owned *entry)
{
    size_t bytes = (size_t)(entry->count ? entry->count : 1) * entry->size;
    return (bytes + PDI_ARENA_LINE - 1) / PDI_ARENA_LINE * PDI_ARENA_LINE;
}

/* Callback of the list: adds the size of one array. */
static void pdi_arena_take_bytes(pdi_owner *owner, const pdi_owned *entry)
{
    owner->bytes += (int64_t)pdi_arena_size(entry);
}

PDI_FN size_t pdi_arena_bytes(pdi_list_fn list, void *object)
{
    pdi_owner owner;
    memset(&owner, 0, sizeof owner);
    owner.take = pdi_arena_take_bytes;
    list(&owner, object);
    return (size_t)owner.bytes;
}

PDI_FN pd_status pdi_arena_fit(pd_ctx *ctx, pd_arena *arena, size_t bytes)
{
    if (arena->used)
        return pdi_fail(ctx, PD_ERR_INTERNAL, "arena", "room is asked for while %.4g MB are lent",
                        (double)arena->used * 1e-6);
    if (arena->block && bytes <= arena->size) return PD_OK;
    PDI_TRY(PDI_GROW(ctx, "arena", arena->size + PDI_ARENA_LINE, bytes + PDI_ARENA_LINE, arena->block));
    arena->size = bytes;
    return PD_OK;
}

void pd_arena_free(pd_ctx *ctx, pd_arena *arena)
{
    PDI_DELETE(ctx, arena->size + PDI_ARENA_LINE, arena->block);
    memset(arena, 0, sizeof *arena);
}

/* The first aligned byte of the block. */
static unsigned char *pdi_arena_front(const pd_arena *arena)
{
    return arena->block + (PDI_ARENA_LINE - (size_t)((uintptr_t)arena->block % PDI_ARENA_LINE)) % PDI_ARENA_LINE;
}

/* One pass over a list that lends or returns its arrays. owner.bytes is the offset [byte] of the next array. */
typedef struct pdi_arena_walk {
    pdi_owner owner; /* has to be the first member: callbacks cast its address */
    const pd_arena *arena;
    int wrong; /* 1: an array is not at the address at which it was lent */
} pdi_arena_walk;

/* Callback of the list: sets the pointer of one array to the next free place. */
static void pdi_arena_take_lend(pdi_owner *owner, const pdi_owned *entry)
{
    const pdi_arena_walk *walk = (const pdi_arena_walk *)(void *)owner;
    void *at = pdi_arena_front(walk->arena) + owner->bytes;
    size_t size = pdi_arena_size(entry);
    if (entry->kind != PDI_OWNED_RAW) memset(at, 0, size);
    memcpy(entry->at, &at, sizeof at);
    owner->bytes += (int64_t)size;
}

/* Callback of the list: checks the address of one array and sets its pointer to NULL. */
static void pdi_arena_take_return(pdi_owner *owner, const pdi_owned *entry)
{
    pdi_arena_walk *walk = (pdi_arena_walk *)(void *)owner;
    void *wanted = pdi_arena_front(walk->arena) + owner->bytes, *at, *none = NULL;
    size_t size = pdi_arena_size(entry);
    memcpy(&at, entry->at, sizeof at);
    walk->wrong = walk->wrong || at != wanted;
#ifdef PD_DEBUG
    if (at == wanted) memset(at, 0xff, size); /* NaN: later reads show up */
#endif
    memcpy(entry->at, &none, sizeof none);
    owner->bytes += (int64_t)size;
}

/* Run a callback over a list, offsets from `from` [byte] on. Returns 1 when an address was wrong. */
static int pdi_arena_go(const pd_arena *arena, void (*take)(pdi_owner *, const pdi_owned *), pdi_list_fn list,
                        void *object, size_t from)
{
    pdi_arena_walk walk;
    memset(&walk, 0, sizeof walk);
    walk.owner.take = take;
    walk.owner.bytes = (int64_t)from;
    walk.arena = arena;
    list(&walk.owner, object);
    return walk.wrong;
}

PDI_FN int pdi_arena_has(const pd_arena *arena, pdi_list_fn list, void *object)
{
    return arena->block && pdi_arena_bytes(list, object) <= arena->size - arena->used;
}

PDI_FN pd_status pdi_arena_lend(pd_ctx *ctx, pd_arena *arena, pdi_list_fn list, void *object)
{
    size_t bytes = pdi_arena_bytes(list, object);
    if (!pdi_arena_has(arena, list, object))
        return pdi_fail(ctx, PD_ERR_INTERNAL, "arena", "%.4g MB are asked for, %.4g of %.4g MB are lent: two solvers "
                        "work at the same time", (double)bytes * 1e-6, (double)arena->used * 1e-6,
                        (double)arena->size * 1e-6);
    pdi_arena_go(arena, pdi_arena_take_lend, list, object, arena->used);
    arena->used += bytes;
    return PD_OK;
}

PDI_FN pd_status pdi_arena_return(pd_ctx *ctx, pd_arena *arena, pdi_list_fn list, void *object, pd_status status)
{
    size_t bytes = pdi_arena_bytes(list, object);
    int wrong = bytes > arena->used;
    if (!wrong) wrong = pdi_arena_go(arena, pdi_arena_take_return, list, object, arena->used - bytes);
    arena->used = wrong ? 0 : arena->used - bytes;
    if (!wrong || status < 0) return status;
    return pdi_fail(ctx, PD_ERR_INTERNAL, "arena", "what is returned is not what was lent last: two solvers work at "
                    "the same time");
}

#undef PDI_ARENA_LINE
