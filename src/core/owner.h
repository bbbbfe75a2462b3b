/* owner: registry of the arrays of an object: one list function describes them all.
 *
 * The list function of a module names each array with its length, its unit and whether checkpoints store it. To
 * allocate, free, count or checkpoint the object, a visitor is called for each entry, so each length is written once:
 *
 *   static void pdi_flow_list(pdi_owner *owner, void *object)
 *   {
 *       pd_flow *flow = (pd_flow *)object;
 *       int64_t total = flow->grid ? flow->grid->total : 0;
 *       PDI_STATE(owner, flow, u, PD_DIM * total, "m/s");
 *       PDI_ARRAY(owner, flow, grad, PD_DIM * total, "m/s2");
 *       if (flow->wall) PDI_ARRAY(owner, flow, drive, PD_DIM * total, "1/m/s");
 *       PDI_VALUE(owner, flow, tau, "s");
 *   }
 *
 * A list function depends on members that do not change between build and free, and reads no array. It accepts an
 * object of zeros. Arrays that are allocated at another time than the others have a list function of their own. An
 * object that is not built, but has the members that the list reads, can be counted.
 */
#ifndef PD_OWNER_H
#define PD_OWNER_H
#include "core/archive.h"

#ifdef PDI_INTERNAL
typedef enum pdi_owned_kind {
    PDI_OWNED_ARRAY, /* work array, or derived from the state: not in checkpoints */
    PDI_OWNED_RAW,   /* uninitialised work array, written before it is read: an arena lends it without zeroing */
    PDI_OWNED_STATE, /* state array: checkpoints store it */
    PDI_OWNED_ROOM,  /* growing array: allocated by the module; the length is the allocated capacity */
    PDI_OWNED_VALUE  /* scalar state: checkpoints store it */
} pdi_owned_kind;

/* One entry of a list: an array, or a scalar of the state. */
typedef struct pdi_owned {
    const char *name; /* "flow.u" */
    const char *unit; /* "m/s"; "1": dimensionless, or indices; "": mixed units */
    void *at;         /* address of the pointer to the array, or of the scalar */
    size_t size;      /* [byte] of an element */
    int64_t count;    /* elements */
    pdi_owned_kind kind;
} pdi_owned;

/* Visitor of a list: a callback and what it needs. */
typedef struct pdi_owner {
    void (*take)(struct pdi_owner *owner, const pdi_owned *entry); /* called for each entry */
    pd_ctx *ctx;
    pd_archive *archive; /* of pdi_owner_store */
    int64_t bytes;       /* [byte] total so far */
    pd_status status; /* the first failure */
} pdi_owner;

/* List function of a module: calls pdi_owner_add for each array of the object. */
typedef void (*pdi_list_fn)(pdi_owner *owner, void *object);

/* Allocate all arrays of the list, zeroed, whatever their pointers held. On failure none is left allocated. */
PDI_FN PDI_ONCE pd_status pdi_owner_build(pd_ctx *ctx, pdi_list_fn list, void *object);
/* Free all arrays of the list. Their pointers become NULL; NULL is allowed. */
PDI_FN PDI_ONCE void pdi_owner_free(pd_ctx *ctx, pdi_list_fn list, void *object);
/* Reallocate arrays whose lengths depend on *capacity with the capacity `count`; the content is lost. On failure
 * *capacity is 0. */
PDI_FN PDI_ONCE pd_status pdi_owner_renew(pd_ctx *ctx, pdi_list_fn list, void *object, int32_t *capacity,
                                          int32_t count);
/* Size [byte] of all arrays. The object need not be built. */
PDI_FN PDI_ONCE int64_t pdi_owner_bytes(pdi_list_fn list, void *object);
/* Write all state arrays and scalars to a checkpoint, or read them back, in the order of the list. */
PDI_FN PDI_ONCE pd_status pdi_owner_store(pd_ctx *ctx, pdi_list_fn list, void *object, pd_archive *archive);

/* Pass one entry to the visitor; called by list functions. */
PDI_FN PDI_ONCE void pdi_owner_add(pdi_owner *owner, pdi_owned_kind kind, const char *name, const char *unit,
                                   int64_t count, size_t size, void *address);
/* PDI_ARRAY(owner, flow, u, n, "m/s") describes the array "flow.u" of n elements of *flow->u. */
#define PDI_OWN(owner, kind, object, member, count, unit) \
    pdi_owner_add((owner), (kind), #object "." #member, (unit), (int64_t)(count), sizeof *(object)->member, \
                  &(object)->member)
#define PDI_ARRAY(owner, object, member, count, unit) \
    PDI_OWN(owner, PDI_OWNED_ARRAY, object, member, count, unit)
#define PDI_RAW(owner, object, member, count, unit) PDI_OWN(owner, PDI_OWNED_RAW, object, member, count, unit)
#define PDI_STATE(owner, object, member, count, unit) \
    PDI_OWN(owner, PDI_OWNED_STATE, object, member, count, unit)
#define PDI_ROOM(owner, object, member, count, unit) PDI_OWN(owner, PDI_OWNED_ROOM, object, member, count, unit)
#define PDI_VALUE(owner, object, member, unit) \
    pdi_owner_add((owner), PDI_OWNED_VALUE, #object "." #member, (unit), 1, sizeof (object)->member, &(object)->member)
#endif

#endif
