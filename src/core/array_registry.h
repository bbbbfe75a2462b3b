/* array_registry: registry of the arrays of an object: one list function describes them all.
 *
 * The list function of a module names each array with its length, its unit and whether checkpoints store it. To
 * allocate, free, count or checkpoint the object, a visitor is called for each entry, so each length is written once:
 *
 *   static void pdi_flow_list(pdi_array_visitor *owner, void *object)
 *   {
 *       pd_flow *flow = (pd_flow *)object;
 *       int64_t total = flow->grid ? flow->grid->total : 0;
 *       PDI_ARRAY_STATE(owner, flow, u, PD_DIM * total, "m/s");
 *       PDI_ARRAY(owner, flow, grad, PD_DIM * total, "m/s2");
 *       if (flow->wall) PDI_ARRAY(owner, flow, drive, PD_DIM * total, "1/m/s");
 *       PDI_SCALAR_STATE(owner, flow, tau, "s");
 *   }
 *
 * A list function depends on members that do not change between build and free, and reads no array. It accepts an
 * object of zeros. Arrays that are allocated at another time than the others have a list function of their own. An
 * object that is not built, but has the members that the list reads, can be counted.
 */
#ifndef PD_ARRAY_REGISTRY_H
#define PD_ARRAY_REGISTRY_H
#include "core/archive.h"

#ifdef PDI_INTERNAL
typedef enum pdi_array_kind {
    PDI_ARRAY_KIND_WORK, /* work array, or derived from the state: not in checkpoints */
    /* uninitialised work array, written before it is read: an arena lends it without zeroing */
    PDI_ARRAY_KIND_UNINIT,
    PDI_ARRAY_KIND_STATE,   /* state array: checkpoints store it */
    PDI_ARRAY_KIND_GROWING, /* growing array: allocated by the module; the length is the allocated capacity */
    PDI_ARRAY_KIND_SCALAR   /* scalar state: checkpoints store it */
} pdi_array_kind;

/* One entry of a list: an array, or a scalar of the state. */
typedef struct pdi_array_entry {
    const char *name; /* "flow.u" */
    const char *unit; /* "m/s"; "1": dimensionless, or indices; "": mixed units */
    void *address;    /* address of the pointer to the array, or of the scalar */
    size_t element_size; /* [byte] of an element */
    int64_t count;    /* elements */
    pdi_array_kind kind;
} pdi_array_entry;

/* Visitor of a list: a callback and what it needs. */
typedef struct pdi_array_visitor {
    void (*visit)(struct pdi_array_visitor *owner, const pdi_array_entry *entry); /* called for each entry */
    pd_ctx *ctx;
    pd_archive *archive; /* of pdi_array_registry_store */
    int64_t bytes;       /* [byte] total so far */
    pd_status status; /* the first failure */
} pdi_array_visitor;

/* List function of a module: calls pdi_array_registry_add for each array of the object. */
typedef void (*pdi_array_list_fn)(pdi_array_visitor *owner, void *object);

/* Allocate all arrays of the list, zeroed, whatever their pointers held; growing arrays and scalars are left alone. On
 * failure (errors of pd_alloc) no array is left allocated, growing ones included, and all pointers are NULL. */
PDI_FN PDI_NOINLINE pd_status pdi_array_registry_build(pd_ctx *ctx, pdi_array_list_fn list, void *object);
/* Free all arrays of the list, growing ones included. Their pointers become NULL; NULL is allowed. The list has to give
 * the lengths of the allocation. */
PDI_FN PDI_NOINLINE void pdi_array_registry_free(pd_ctx *ctx, pdi_array_list_fn list, void *object);
/* Free all arrays of a list whose lengths depend on *capacity, a member of the object, set it to `count`, and allocate
 * them again, zeroed. Growing arrays are only freed. On failure *capacity is 0, and no array is left. */
PDI_FN PDI_NOINLINE pd_status pdi_array_registry_rebuild(pd_ctx *ctx, pdi_array_list_fn list, void *object,
                                                         int32_t *capacity, int32_t count);
/* Size [byte] of all arrays, growing ones included; one without elements counts as one element. Scalars do not count.
 * The object need not be built. */
PDI_FN PDI_NOINLINE int64_t pdi_array_registry_count_bytes(pdi_array_list_fn list, void *object);
/* Write all state arrays and scalars to a checkpoint, or read them back, in the order of the list. Other arrays are
 * skipped. Ends at the first failure, which is returned. */
PDI_FN PDI_NOINLINE pd_status pdi_array_registry_store(pd_ctx *ctx, pdi_array_list_fn list, void *object,
                                                       pd_archive *archive);

/* Pass one entry to the visitor; called by list functions. size [byte]: of an element. address: of the pointer to the
 * array, or of the scalar. */
PDI_FN PDI_NOINLINE void pdi_array_registry_add(pdi_array_visitor *owner, pdi_array_kind kind, const char *name,
                                                const char *unit, int64_t count, size_t size, void *address);
/* PDI_ARRAY(owner, flow, u, n, "m/s") describes the array "flow.u" of n elements of *flow->u. */
#define PDI_ARRAY_ENTRY(owner, kind, object, member, count, unit) \
    pdi_array_registry_add((owner), (kind), #object "." #member, (unit), (int64_t)(count), sizeof *(object)->member, \
                           &(object)->member)
#define PDI_ARRAY(owner, object, member, count, unit) \
    PDI_ARRAY_ENTRY(owner, PDI_ARRAY_KIND_WORK, object, member, count, unit)
#define PDI_ARRAY_UNINIT(owner, object, member, count, unit) \
    PDI_ARRAY_ENTRY(owner, PDI_ARRAY_KIND_UNINIT, object, member, count, unit)
#define PDI_ARRAY_STATE(owner, object, member, count, unit) \
    PDI_ARRAY_ENTRY(owner, PDI_ARRAY_KIND_STATE, object, member, count, unit)
#define PDI_ARRAY_GROWING(owner, object, member, count, unit) \
    PDI_ARRAY_ENTRY(owner, PDI_ARRAY_KIND_GROWING, object, member, count, unit)
#define PDI_SCALAR_STATE(owner, object, member, unit) \
    pdi_array_registry_add((owner), PDI_ARRAY_KIND_SCALAR, #object "." #member, (unit), 1, sizeof(object)->member, \
                           &(object)->member)
#endif

#endif
