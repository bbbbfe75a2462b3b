/* archive: the state of objects, written out or read back. One function of a module lists what steps carry on, for both
 * ways. What is behind the callbacks, a file or memory, is no matter of a physics.
 */
#ifndef PD_ARCHIVE_H
#define PD_ARCHIVE_H
#include "core/base.h"

typedef struct pd_archive {
    /* Take `count` elements of `size` bytes out of data, or put them there, in the order in which they were taken. */
    pd_status (*item)(pd_ctx *ctx, void *user, const char *name, void *data, size_t size, int64_t count);
    /* Keep a number, or see that it is the same. PD_ERR_ARGUMENT: it is another one. */
    pd_status (*check)(pd_ctx *ctx, void *user, const char *name, double value);
    void *user;
    int reading;      /* 1: data are put back */
    const char *name; /* for messages */
} pd_archive;

#ifdef PDI_INTERNAL
/* PDI_KEEP(ctx, archive, "flow.p", flow->p, n) moves n elements of *flow->p. */
#define PDI_KEEP(ctx, archive, item_name, array, count) \
    (archive)->item((ctx), (archive)->user, (item_name), (array), sizeof *(array), (int64_t)(count))
/* PDI_SAME(ctx, archive, "cells", 3) keeps a number or compares it. */
#define PDI_SAME(ctx, archive, item_name, value) \
    (archive)->check((ctx), (archive)->user, (item_name), (double)(value))
#endif

#endif
