/* owner: see owner.h */
#include "core/owner.h"
#include <string.h>

PDI_FN void pdi_owner_add(pdi_owner *owner, pdi_owned_kind kind, const char *name, const char *unit, int64_t count,
                          size_t size, void *address)
{
    pdi_owned entry;
    entry.name = name;
    entry.unit = unit;
    entry.at = address;
    entry.size = size;
    entry.count = count;
    entry.kind = kind;
    owner->take(owner, &entry);
}

/* Call the visitor for every entry of a list. */
static void pdi_owner_walk(pdi_owner *owner, pdi_list_fn list, void *object)
{
    owner->bytes = 0;
    owner->status = PD_OK;
    list(owner, object);
}

/* ---- build and free ---- */

/* Visitor: frees one array. */
static void pdi_owner_take_free(pdi_owner *owner, const pdi_owned *entry)
{
    if (entry->kind != PDI_OWNED_VALUE) pdi_free(owner->ctx, (size_t)entry->count, entry->size, entry->at);
}

/* Visitor: allocates one array, zeroed, unless an earlier allocation failed. */
static void pdi_owner_take_build(pdi_owner *owner, const pdi_owned *entry)
{
    void *none = NULL;
    if (entry->kind == PDI_OWNED_VALUE || entry->kind == PDI_OWNED_ROOM) return;
    memcpy(entry->at, &none, sizeof none); /* also after a failure, so that freeing is safe */
    if (owner->status == PD_OK)
        owner->status = pdi_alloc(owner->ctx, entry->name, (size_t)entry->count, entry->size, entry->at);
}

PDI_FN void pdi_owner_free(pd_ctx *ctx, pdi_list_fn list, void *object)
{
    pdi_owner owner;
    memset(&owner, 0, sizeof owner);
    owner.ctx = ctx;
    owner.take = pdi_owner_take_free;
    pdi_owner_walk(&owner, list, object);
}

PDI_FN pd_status pdi_owner_build(pd_ctx *ctx, pdi_list_fn list, void *object)
{
    pdi_owner owner;
    memset(&owner, 0, sizeof owner);
    owner.ctx = ctx;
    owner.take = pdi_owner_take_build;
    pdi_owner_walk(&owner, list, object);
    if (owner.status < 0) pdi_owner_free(ctx, list, object);
    return owner.status;
}

PDI_FN pd_status pdi_owner_renew(pd_ctx *ctx, pdi_list_fn list, void *object, int32_t *capacity, int32_t count)
{
    pdi_owner_free(ctx, list, object);
    *capacity = count;
    pd_status status = pdi_owner_build(ctx, list, object);
    if (status < 0) *capacity = 0;
    return status;
}

/* ---- bytes ---- */

/* Visitor: adds the size of one array. */
static void pdi_owner_take_bytes(pdi_owner *owner, const pdi_owned *entry)
{
    if (entry->kind != PDI_OWNED_VALUE) owner->bytes += (entry->count ? entry->count : 1) * (int64_t)entry->size;
}

PDI_FN int64_t pdi_owner_bytes(pdi_list_fn list, void *object)
{
    pdi_owner owner;
    memset(&owner, 0, sizeof owner);
    owner.take = pdi_owner_take_bytes;
    pdi_owner_walk(&owner, list, object);
    return owner.bytes;
}

/* ---- checkpoints ---- */

/* Visitor: writes or reads one state array or scalar. */
static void pdi_owner_take_store(pdi_owner *owner, const pdi_owned *entry)
{
    void *data = entry->at;
    if (owner->status < 0 || (entry->kind != PDI_OWNED_STATE && entry->kind != PDI_OWNED_VALUE)) return;
    if (entry->kind == PDI_OWNED_STATE) memcpy(&data, entry->at, sizeof data);
    owner->status = owner->archive->item(owner->ctx, owner->archive->user, entry->name, data, entry->size,
                                         entry->count);
}

PDI_FN pd_status pdi_owner_store(pd_ctx *ctx, pdi_list_fn list, void *object, pd_archive *archive)
{
    pdi_owner owner;
    memset(&owner, 0, sizeof owner);
    owner.ctx = ctx;
    owner.archive = archive;
    owner.take = pdi_owner_take_store;
    pdi_owner_walk(&owner, list, object);
    return owner.status;
}
