/* archive_file: checkpoint file: an archive of named arrays with lengths and checksums, in a file or in memory.
 *
 *   pd_archive_file_create(&ctx, "state", &store)  or  pd_archive_file_open(&ctx, "state", &store)
 *   pd_time_loop_store(&ctx, &couple, &store.archive)
 *   pd_archive_file_close(&ctx, &store)
 *
 * File header, in the byte order of the machine: "PDSTORE\n", 4 bytes that show this order, format, dimension, 4 bytes
 * 0, version of pdcorr [32], 4 bytes 0, CRC-32 of these. Item: name [32], count [8], bytes of an element [4], CRC-32
 * of these; elements, their CRC-32. The last item is named "end", counts the items before it, and has no elements.
 */
#ifndef PD_ARCHIVE_FILE_H
#define PD_ARCHIVE_FILE_H
#include "core/archive.h"
#include "io/file.h"

#define PD_ARCHIVE_FILE_FORMAT 3u    /* version of the file format */
#define PD_ARCHIVE_FILE_NAME_SIZE 48 /* [byte] of a name with its end */

/* A checkpoint file that is written or read. Zero-initialise; do not move it while it is open. */
typedef struct pd_archive_file {
    pd_archive archive; /* the interface that objects write to and read from */
    pd_file file;
    uint64_t item_count;     /* number of items so far */
    int in_memory;           /* 1: the file is written to memory, not to disk */
    uint8_t *memory;         /* [capacity] bytes of the file in memory */
    size_t length, capacity; /* [byte] */
} pd_archive_file;

#define pd_archive_file_create PD_NAME(pd_archive_file_create)
#define pd_archive_file_open PD_NAME(pd_archive_file_open)
#define pd_archive_file_close PD_NAME(pd_archive_file_close)

/* Zero the store and begin to write a checkpoint to a temporary file; a file of this name stays until it is closed.
 * PD_ERR_FILE. On failure nothing is open, and no temporary file stays. */
PD_API pd_status pd_archive_file_create(pd_ctx *ctx, const char *path, pd_archive_file *store);
/* Zero the store and open a checkpoint to read. All checksums of the file are verified first. PD_ERR_FILE: it cannot be
 * read, is none, cut off or damaged, or has bytes behind its end. PD_ERR_ARGUMENT: another format, version of pdcorr,
 * dimension or byte order. It is closed on failure. Reading an item later fails with PD_ERR_ARGUMENT when the next item
 * of the file has another name, count or element size. */
PD_API pd_status pd_archive_file_open(pd_ctx *ctx, const char *path, pd_archive_file *store);
/* After writing: write the end item and give the file its final name; a checkpoint in memory stays there. After
 * reading: check that everything was read, else PD_ERR_ARGUMENT. PD_ERR_FILE. It is closed on failure, too; a temporary
 * file is deleted then. */
PD_API pd_status pd_archive_file_close(pd_ctx *ctx, pd_archive_file *store);

#ifdef PDI_APP_INTERNAL
/* Close the file, and delete the temporary one; a checkpoint in memory stays. A closed or zeroed store is allowed. */
PDI_FN void pdi_archive_file_abandon(pd_archive_file *store);

/* Begin to write a checkpoint in memory, over the one held there, whose buffer is used again; closing ends it and keeps
 * it. The store is zeroed before the first time. */
PDI_FN pd_status pdi_archive_file_begin_in_memory(pd_ctx *ctx, pd_archive_file *store);
/* Write the checkpoint held in memory, which has been closed, to the file `path` by way of a temporary one. Sets the
 * checksums of its items in memory first; it stays in memory. PD_ERR_FILE: an older file of that name stays, and the
 * temporary one is deleted. */
PDI_FN pd_status pdi_archive_file_write_memory(pd_ctx *ctx, pd_archive_file *store, const char *path);
/* Free the checkpoint held in memory and zero the store. A zeroed store is allowed. */
PDI_FN void pdi_archive_file_free_memory(pd_ctx *ctx, pd_archive_file *store);
#endif

#endif
