/* owner: the arrays of an object in one list.
 *
 * One function of a module names each array with its length, its unit and whether checkpoints keep it. The object is
 * built, freed, counted and kept by walks through that list, so each length stands once:
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
 * A list depends on members that stay from the build to the free, and reads no array. It takes an object of zeros.
 * Arrays that are made at another time than the others have a list of their own. An object that is not built, but has
 * the members that the list reads, can be counted.
 */
#ifndef PD_OWNER_H
#define PD_OWNER_H
#include "core/archive.h"

#ifdef PDI_INTERNAL
typedef enum pdi_owned_kind {
    PDI_OWNED_ARRAY, /* work, and what follows from the state */
    PDI_OWNED_RAW,   /* an array that is written before it is read: an arena lends it without zeros */
    PDI_OWNED_STATE, /* an array that steps carry on: checkpoints keep it */
    PDI_OWNED_ROOM,  /* an array that grows: the module makes it, and the length is that of the allocation */
    PDI_OWNED_VALUE  /* a number that steps carry on */
} pdi_owned_kind;

typedef struct pdi_owned {
    const char *name; /* "flow.u" */
    const char *unit; /* "m/s"; "1": none, and indices; "": several */
    void *at;         /* the address of the pointer, or of the number */
    size_t size;      /* [byte] of an element */
    int64_t count;
    pdi_owned_kind kind;
} pdi_owned;

/* A walk through a list. */
typedef struct pdi_owner {
    void (*take)(struct pdi_owner *owner, const pdi_owned *entry); /* gets each entry in turn */
    pd_ctx *ctx;
    pd_archive *archive;
    int64_t bytes;
    pd_status status; /* the first failure */
} pdi_owner;

typedef void (*pdi_list_fn)(pdi_owner *owner, void *object);

/* Make all arrays of the list, whatever their pointers hold, filled with zeros. On failure none is left. */
PDI_FN PDI_ONCE pd_status pdi_owner_build(pd_ctx *ctx, pdi_list_fn list, void *object);
/* Free them. Pointers become NULL; those that are NULL stay so. */
PDI_FN PDI_ONCE void pdi_owner_free(pd_ctx *ctx, pdi_list_fn list, void *object);
/* Free arrays that go by *capacity, and make them with another one. On failure it is 0. */
PDI_FN PDI_ONCE pd_status pdi_owner_renew(pd_ctx *ctx, pdi_list_fn list, void *object, int32_t *capacity,
                                          int32_t count);
/* [byte] of all arrays; nothing has to be built. */
PDI_FN PDI_ONCE int64_t pdi_owner_bytes(pdi_list_fn list, void *object);
/* Move states and values out of the object, or back into it, in the order of the list. */
PDI_FN PDI_ONCE pd_status pdi_owner_store(pd_ctx *ctx, pdi_list_fn list, void *object, pd_archive *archive);

/* Name one entry to the walk. */
PDI_FN PDI_ONCE void pdi_owner_add(pdi_owner *owner, pdi_owned_kind kind, const char *name, const char *unit,
                                   int64_t count, size_t size, void *at);
/* PDI_ARRAY(owner, flow, u, n, "m/s") names "flow.u", n elements of *flow->u. */
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
