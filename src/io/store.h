/* store: an archive in a file or in memory: named items with lengths and checksums.
 *
 *   pd_store_create(&ctx, "state", &store)  or  pd_store_open(&ctx, "state", &store)
 *   pd_couple_store(&ctx, &couple, &store.archive)
 *   pd_store_close(&ctx, &store)
 *
 * Head, in the byte order of the machine: "PDSTORE\n", 4 bytes that show this order, format, dimension, 4 bytes 0,
 * version of pdcorr [32], 4 bytes 0, CRC-32 of these. Item: name [32], count [8], bytes of an element [4], CRC-32 of
 * these; elements, their CRC-32. The last item is named "end", counts the items before it, and has no elements.
 */
#ifndef PD_STORE_H
#define PD_STORE_H
#include "core/archive.h"
#include "io/file.h"

#define PD_STORE_FORMAT 2u /* of the file */
#define PD_STORE_NAME 32 /* [byte] of a name with its end */

/* Zero-initialise. */
typedef struct pd_store {
    pd_archive archive; /* of this store, which stays where it is while it is open */
    pd_file file;
    uint64_t items; /* so far */
    int kept;       /* pdi_store_keep: the bytes of the file are kept in memory */
    uint8_t *image;
    size_t length, capacity; /* [byte] */
} pd_store;

#define pd_store_create PD_NAME(pd_store_create)
#define pd_store_open PD_NAME(pd_store_open)
#define pd_store_close PD_NAME(pd_store_close)

/* Begin a file aside; one under this name stays until pd_store_close. PD_ERR_FILE. */
PD_API pd_status pd_store_create(pd_ctx *ctx, const char *path, pd_store *store);
/* Open a file that is whole: all checksums are looked at before anything is handed out. PD_ERR_FILE: it cannot be read,
 * is cut off or damaged. PD_ERR_ARGUMENT: of another format, version, dimension or byte order; an item then is one when
 * what comes next in the file has another name or length. */
PD_API pd_status pd_store_open(pd_ctx *ctx, const char *path, pd_store *store);
/* Put the file in place, or see that all of it was read. Closed on failure, too. */
PD_API pd_status pd_store_close(pd_ctx *ctx, pd_store *store);

#ifdef PDI_INTERNAL
/* Close, and remove what was written aside. Allowed on a closed or zeroed store. */
PDI_FN void pdi_store_abandon(pd_store *store);

/* Begin a file in memory, in place of one that is kept there. pd_store_close ends it and keeps it. */
PDI_FN pd_status pdi_store_keep(pd_ctx *ctx, pd_store *store);
/* Put what is kept under that name. PD_ERR_FILE. */
PDI_FN pd_status pdi_store_release(pd_ctx *ctx, pd_store *store, const char *path);
PDI_FN void pdi_store_drop(pd_ctx *ctx, pd_store *store);
#endif

#endif
