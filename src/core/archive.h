/* archive: the interface of checkpoints: two callbacks that write the state of objects, or read it back. One function
 * of a module serves both directions. The callbacks hide whether a file or memory holds the data.
 */
#ifndef PD_ARCHIVE_H
#define PD_ARCHIVE_H
#include "core/base.h"

typedef struct pd_archive {
    /* Writing: save `count` elements of `size` bytes from data. Reading: load them into data. Items come in the order
     * in which they were written. */
    pd_status (*transfer)(pd_ctx *ctx, void *user, const char *name, void *data, size_t size, int64_t count);
    /* Writing: save a number. Reading: compare it with the saved one; PD_ERR_ARGUMENT: they differ. */
    pd_status (*verify)(pd_ctx *ctx, void *user, const char *name, double value);
    void *user;
    int is_reading;   /* 1: a checkpoint is loaded; 0: one is written */
    const char *name; /* for messages */
} pd_archive;

/* PD_ARCHIVE_ARRAY(ctx, archive, "flow.p", flow->p, n): save or load n elements of *flow->p under a name. */
#define PD_ARCHIVE_ARRAY(ctx, archive, item_name, array, count) \
    (archive)->transfer((ctx), (archive)->user, (item_name), (array), sizeof *(array), (int64_t)(count))
/* PD_ARCHIVE_VERIFY(ctx, archive, "cells", 3): save a number, or check that the checkpoint holds the same one. */
#define PD_ARCHIVE_VERIFY(ctx, archive, item_name, value) \
    (archive)->verify((ctx), (archive)->user, (item_name), (double)(value))

#endif
