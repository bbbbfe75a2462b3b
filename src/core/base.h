/* base: status codes, the one error function, the context of a caller, and memory allocation.
 *
 * Contract of every pd_status function: 0 done; negative: the call failed and ctx->message says what, where and how to
 * mend; positive: nothing changed, retry as the text says.
 *
 * Contract of every build and read: on failure the call keeps no memory and the object is all zero (but for a member
 * that names what was refused, such as pd_model.line), whatever it held before. Freeing it is allowed and not needed.
 * An object is freed once or more often; a zeroed one that was never built may be freed, too.
 */
#ifndef PD_BASE_H
#define PD_BASE_H
#include "core/config.h"
#include "core/thread_contention.h"

#define PD_STATUS_TABLE(X) \
    X(PD_OK, 0)             /* done */ \
    X(PD_RETRY, 1)          /* nothing changed: retry with a smaller step */ \
    X(PD_NOT_CONVERGED, 2)  /* the iteration limit was reached before the tolerance */ \
    X(PD_ERR_ARGUMENT, -1)  /* an argument is out of range */ \
    X(PD_ERR_MEMORY, -2)    /* out of memory */ \
    X(PD_ERR_LIMIT, -3)     /* the memory limit of the context would be exceeded */ \
    X(PD_ERR_SIZE, -4)      /* a size overflows its type */ \
    X(PD_ERR_FILE, -5)      /* a file cannot be read or written */ \
    X(PD_ERR_PARSE, -6)     /* text does not follow the format */ \
    X(PD_ERR_GEOMETRY, -7)  /* the geometry is not admissible */ \
    X(PD_ERR_STATE, -8)     /* the state left the admissible range */ \
    X(PD_ERR_DIVERGED, -9)  /* a solver diverged */ \
    X(PD_ERR_BALANCE, -10)  /* the mass ledger does not close */ \
    X(PD_ERR_INTERNAL, -11) /* pdcorr broke a promise of its own */ \
    X(PD_CANCELLED, -12)    /* the poll function of the context asked to stop */

typedef enum pd_status {
#define PDI_X(name, value) name = value,
    PD_STATUS_TABLE(PDI_X)
#undef PDI_X
    PD_STATUS_FORCE_SIGNED = -1000
} pd_status;

/* Memory hook: like realloc with both sizes. new_size 0 frees. NULL fn: the C library's realloc and free. */
typedef struct pd_allocator {
    void *(*fn)(void *user, void *ptr, size_t old_size, size_t new_size);
    void *user;
    size_t limit; /* [byte] 0: none */
} pd_allocator;

#define PD_MESSAGE_SIZE 640 /* [byte] of a message with its end */
#define PD_PATH_SIZE 1024   /* [byte] of a path with its end */

/* Cancellation callback. Called between iterations of everything that may take a second, on the thread of the caller,
 * with what is being done, such as "flow: GMRES", and a count. Not 0: the call ends with PD_CANCELLED. Has to be
 * quick. */
typedef int (*pd_cancel_fn)(void *user, const char *doing, int64_t count);

#define PD_CTX_PHYSICS 4 /* most physics that a program brings along */

/* One context a thread of the caller; pdcorr keeps no other state. */
typedef struct pd_ctx {
    pd_allocator alloc;
    int threads;   /* 0: all that OpenMP offers */
    size_t in_use; /* [byte] allocated now */
    size_t peak;   /* [byte] most so far */
    pd_cancel_fn cancel; /* NULL: no cancellation */
    void *cancel_user;
    const struct pd_physics_type *physics[PD_CTX_PHYSICS]; /* of the program, by pd_physics_type_register */
    int physics_count;
    pd_thread_contention contention; /* detects that the threads are slowed by other programs */
    pd_status status;
    char message[PD_MESSAGE_SIZE];
} pd_ctx;

#define pd_ctx_init PD_NAME(pd_ctx_init)
#define pd_status_name PD_NAME(pd_status_name)
#define pd_fail PD_NAME(pd_fail)
#define pd_check_cancel PD_NAME(pd_check_cancel)
#define pd_append PD_NAME(pd_append)
#define pd_alloc PD_NAME(pd_alloc)
#define pd_resize PD_NAME(pd_resize)
#define pd_free PD_NAME(pd_free)

/* Set ctx to zero: C library memory, no limit, all threads, no cancellation, no physics of the program. */
PD_API void pd_ctx_init(pd_ctx *ctx);
/* Name of a status, such as "PD_ERR_FILE". Any int is accepted: one that is no status gets one common name. */
PD_API const char *pd_status_name(pd_status status);

/* Report an error: sets ctx->status and ctx->message ("where: ...", cut off where it is too long) and returns status.
 * Every failure passes here. An earlier error is overwritten. */
PD_API pd_status pd_fail(pd_ctx *ctx, pd_status status, const char *where, const char *format, ...)
    PD_PRINTF_LIKE(4, 5);
/* Append formatted text to a string in a buffer of `size` bytes. What does not fit is cut off; a full buffer stays as
 * it is. */
PD_API void pd_append(char *text, size_t size, const char *format, ...) PD_PRINTF_LIKE(3, 4);
/* 1: out of memory, or cancelled by the caller. A retry with another step, guess or file cannot help. */
static inline int pd_is_fatal(pd_status status)
{
    return status == PD_ERR_MEMORY || status == PD_ERR_LIMIT || status == PD_CANCELLED;
}
/* Ask the cancellation callback, if there is one, with what is being done and a count. PD_CANCELLED: it does not return
 * 0. A step then leaves the state at its start, or at the end of the last step that it is made of. */
PD_API pd_status pd_check_cancel(pd_ctx *ctx, const char *doing, int64_t count);
/* Memory through the allocator of the context. slot: address of a pointer of any type, read and written as bytes.
 * `where` begins the message of a failure. pd_alloc: slot gets count * size zeroed bytes (count 0: one element, so that
 * NULL always means failure), whatever it held; on failure it is NULL. Errors as of pd_resize. */
PD_API pd_status pd_alloc(pd_ctx *ctx, const char *where, size_t count, size_t size, void *slot);
/* Grow or shrink an array; NULL: allocate. The content is kept, a new tail is zero; new_count 0 counts as 1. Updates
 * in_use and peak. On failure the old block stays. PD_ERR_SIZE: the bytes exceed half the address space. PD_ERR_LIMIT:
 * in_use would exceed the limit. PD_ERR_MEMORY: refused. */
PD_API pd_status pd_resize(pd_ctx *ctx, const char *where, size_t old_count, size_t new_count, size_t size, void *slot);
/* Free an array of `count` elements, the count of its allocation, by which in_use falls. The pointer becomes NULL; NULL
 * is allowed and does nothing. */
PD_API void pd_free(pd_ctx *ctx, size_t count, size_t size, void *slot);

/* Typed forms of pd_alloc, pd_resize and pd_free: PD_NEW(ctx, "grid", n, grid->kind) allocates n zeroed elements of
 * *grid->kind. */
#define PD_NEW(ctx, where, count, lvalue) pd_alloc((ctx), (where), (size_t)(count), sizeof *(lvalue), &(lvalue))
#define PD_GROW(ctx, where, old_count, new_count, lvalue) \
    pd_resize((ctx), (where), (size_t)(old_count), (size_t)(new_count), sizeof *(lvalue), &(lvalue))
#define PD_DELETE(ctx, count, lvalue) pd_free((ctx), (size_t)(count), sizeof *(lvalue), &(lvalue))
/* Return from the calling function when a call fails (negative status). */
#define PD_TRY(call) \
    do { \
        pd_status pd_try_status = (call); \
        if (pd_try_status < 0) return pd_try_status; \
    } while (0)

/* Checks of internal invariants in debug builds; never used on input. */
#ifdef PD_DEBUG
#include <assert.h>
#define PD_ASSERT(condition) assert(condition)
#else
#define PD_ASSERT(condition) ((void)0)
#endif

#ifdef PDI_INTERNAL
#include <float.h>
/* 1: step underflow: a step dt [s], with `remaining` [s] to go from `time` [s], is below the rounding error of one of
 * them, so that such steps never reach the end. 0: it is not, or dt reaches the end. */
static inline int pdi_is_step_underflow(double time, double remaining, double dt)
{
    double size = time < 0.0 ? -time : time;
    if (remaining > size) size = remaining;
    return dt < remaining && !(dt > DBL_EPSILON * size);
}
#endif

#endif
