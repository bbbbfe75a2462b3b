/* fault: an allocator for the hook of a context that fails at a chosen call, counts live blocks and compares the sizes
 * it is given; and the sweep over all calls of a piece of work. */
#ifndef FAULT_H
#define FAULT_H
#include "core/base.h"
#include "test.h"
#include <stdlib.h>

typedef struct fault {
    long calls;    /* that asked for memory */
    long fail_at;  /* number of the call that fails, from 1; 0: none */
    int for_good;  /* and all behind it */
    long live;     /* blocks */
    long wrong;    /* blocks whose size was given wrong */
    size_t bytes, peak; /* [byte] in live blocks */
} fault;

static inline void *fault_realloc(void *user, void *ptr, size_t old_size, size_t new_size)
{
    enum { HEAD = 32 };
    fault *f = (fault *)user;
    unsigned char *block = ptr ? (unsigned char *)ptr - HEAD : NULL;
    size_t was = 0;
    if (block) memcpy(&was, block, sizeof was);
    f->wrong += was != old_size;
    if (new_size == 0) {
        f->live -= block != NULL;
        f->bytes -= was;
        free(block);
        return NULL;
    }
    f->calls++;
    if (f->fail_at && (f->calls == f->fail_at || (f->for_good && f->calls > f->fail_at))) return NULL;
    f->live += block == NULL;
    f->bytes += new_size - was;
    if (f->bytes > f->peak) f->peak = f->bytes;
    block = (unsigned char *)realloc(block, new_size + HEAD);
    if (!block) abort();
    memcpy(block, &new_size, sizeof new_size);
    if (new_size > was) memset(block + HEAD + was, 0xa5, new_size - was); /* whoever counts on zeros is found out */
    return block + HEAD;
}

/* A context of one thread on that allocator. */
static inline void fault_context(fault *f, long fail_at, int for_good, pd_ctx *ctx)
{
    memset(f, 0, sizeof *f);
    f->fail_at = fail_at;
    f->for_good = for_good;
    pd_ctx_init(ctx);
    ctx->threads = 1;
    ctx->alloc.fn = fault_realloc;
    ctx->alloc.user = f;
}

/* A piece of work that frees all it made, whether it failed or not. */
typedef pd_status (*fault_work)(pd_ctx *ctx, void *user);

/* Does the work once with call n failing; 1 when it is answered as it should be. */
static inline int fault_once(const char *what, fault_work work, void *user, long n, int for_good)
{
    fault f;
    pd_ctx ctx;
    fault_context(&f, n, for_good, &ctx);
    pd_status status = work(&ctx, user);
    int said = status == PD_ERR_MEMORY && ctx.status == PD_ERR_MEMORY && strstr(ctx.message, "be allocated") != NULL;
    int clean = f.live == 0 && f.wrong == 0 && ctx.in_use == 0;
    if (!CHECK(said)) NOTE("%s: call %ld failed: status %d: %s", what, n, (int)status, ctx.message);
    if (!CHECK(clean)) NOTE("%s: call %ld failed: %ld blocks left, %ld sizes wrong", what, n, f.live, f.wrong);
    return said && clean;
}

/* Call n fails, for n = 1 to `dense` and behind it every `stride`th one, up to the last call; each alone, and every
 * seventh also with all calls behind it. Returns the number of calls that the work makes, 0: it does not succeed. */
static inline long fault_sweep(const char *what, fault_work work, void *user, long dense, long stride)
{
    fault f;
    pd_ctx ctx;
    fault_context(&f, 0, 0, &ctx);
    if (!CHECK_OK(&ctx, work(&ctx, user))) return 0;
    CHECK(f.live == 0 && f.wrong == 0 && ctx.in_use == 0);
    CHECK_INT(ctx.peak, f.peak);
    for (long n = 1; n <= f.calls; n += n < dense ? 1 : stride) {
        fault_once(what, work, user, n, 0);
        if (n % 7 == 0) fault_once(what, work, user, n, 1);
    }
    return f.calls;
}

#endif
