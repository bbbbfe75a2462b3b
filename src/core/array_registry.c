/* array_registry: see array_registry.h */
#include "core/array_registry.h"
#include <string.h>

PDI_FN void pdi_array_registry_add(pdi_array_visitor *owner, pdi_array_kind kind, const char *name, const char *unit,
                                   int64_t count, size_t size, void *address)
{
    pdi_array_entry entry;
    entry.name = name;
    entry.unit = unit;
    entry.address = address;
    entry.element_size = size;
    entry.count = count;
    entry.kind = kind;
    owner->visit(owner, &entry);
}

/* Call the visitor for every entry of a list, with its byte count and status reset to 0 and PD_OK. */
static void pdi_array_registry_visit(pdi_array_visitor *owner, pdi_array_list_fn list, void *object)
{
    owner->bytes = 0;
    owner->status = PD_OK;
    list(owner, object);
}

/* ---- build and free ---- */

/* Visitor: frees one array, and sets its pointer to NULL. Skips scalars. */
static void pdi_array_registry_visit_free(pdi_array_visitor *owner, const pdi_array_entry *entry)
{
    if (entry->kind != PDI_ARRAY_KIND_SCALAR)
        pd_free(owner->ctx, (size_t)entry->count, entry->element_size, entry->address);
}

/* Visitor: allocates one array, zeroed. After an earlier failure it only sets the pointer to NULL. Skips scalars and
 * growing arrays. */
static void pdi_array_registry_visit_build(pdi_array_visitor *owner, const pdi_array_entry *entry)
{
    void *none = NULL;
    if (entry->kind == PDI_ARRAY_KIND_SCALAR || entry->kind == PDI_ARRAY_KIND_GROWING) return;
    memcpy(entry->address, &none, sizeof none); /* also after a failure, so that freeing is safe */
    if (owner->status == PD_OK)
        owner->status = pd_alloc(owner->ctx, entry->name, (size_t)entry->count, entry->element_size, entry->address);
}

PDI_FN void pdi_array_registry_free(pd_ctx *ctx, pdi_array_list_fn list, void *object)
{
    pdi_array_visitor owner;
    memset(&owner, 0, sizeof owner);
    owner.ctx = ctx;
    owner.visit = pdi_array_registry_visit_free;
    pdi_array_registry_visit(&owner, list, object);
}

PDI_FN pd_status pdi_array_registry_build(pd_ctx *ctx, pdi_array_list_fn list, void *object)
{
    pdi_array_visitor owner;
    memset(&owner, 0, sizeof owner);
    owner.ctx = ctx;
    owner.visit = pdi_array_registry_visit_build;
    pdi_array_registry_visit(&owner, list, object);
    if (owner.status < 0) pdi_array_registry_free(ctx, list, object);
    return owner.status;
}

PDI_FN pd_status pdi_array_registry_rebuild(pd_ctx *ctx, pdi_array_list_fn list, void *object, int32_t *capacity,
                                            int32_t count)
{
    pdi_array_registry_free(ctx, list, object);
    *capacity = count;
    pd_status status = pdi_array_registry_build(ctx, list, object);
    if (status < 0) *capacity = 0;
    return status;
}

/* ---- bytes ---- */

/* Visitor: adds the size of one array. */
static void pdi_array_registry_visit_bytes(pdi_array_visitor *owner, const pdi_array_entry *entry)
{
    if (entry->kind != PDI_ARRAY_KIND_SCALAR)
        owner->bytes += (entry->count ? entry->count : 1) * (int64_t)entry->element_size;
}

PDI_FN int64_t pdi_array_registry_count_bytes(pdi_array_list_fn list, void *object)
{
    pdi_array_visitor owner;
    memset(&owner, 0, sizeof owner);
    owner.visit = pdi_array_registry_visit_bytes;
    pdi_array_registry_visit(&owner, list, object);
    return owner.bytes;
}

/* ---- checkpoints ---- */

/* Visitor: writes or reads one state array or scalar. Skips other kinds, and all entries after a failure. */
static void pdi_array_registry_visit_store(pdi_array_visitor *owner, const pdi_array_entry *entry)
{
    void *data = entry->address;
    if (owner->status < 0 || (entry->kind != PDI_ARRAY_KIND_STATE && entry->kind != PDI_ARRAY_KIND_SCALAR)) return;
    if (entry->kind == PDI_ARRAY_KIND_STATE) memcpy(&data, entry->address, sizeof data);
    owner->status = owner->archive->transfer(owner->ctx, owner->archive->user, entry->name, data, entry->element_size,
                                             entry->count);
}

PDI_FN pd_status pdi_array_registry_store(pd_ctx *ctx, pdi_array_list_fn list, void *object, pd_archive *archive)
{
    pdi_array_visitor owner;
    memset(&owner, 0, sizeof owner);
    owner.ctx = ctx;
    owner.archive = archive;
    owner.visit = pdi_array_registry_visit_store;
    pdi_array_registry_visit(&owner, list, object);
    return owner.status;
}
