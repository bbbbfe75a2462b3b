/* base: see base.h */
#include "core/base.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void pd_ctx_init(pd_ctx *ctx) { memset(ctx, 0, sizeof *ctx); }

const char *pd_status_name(pd_status status)
{
    switch ((int)status) {
#define PDI_X(name, value) \
    case value: return #name;
        PD_STATUS_TABLE(PDI_X)
#undef PDI_X
    default: return "PD_UNKNOWN";
    }
}

pd_status pd_fail(pd_ctx *ctx, pd_status status, const char *where, const char *format, ...)
{
    int used = snprintf(ctx->message, sizeof ctx->message, "%s: ", where);
    if (used < 0 || (size_t)used >= sizeof ctx->message) used = 0;
    va_list args;
    va_start(args, format);
    vsnprintf(ctx->message + used, sizeof ctx->message - (size_t)used, format, args);
    va_end(args);
    ctx->status = status;
    return status;
}

void pd_append(char *text, size_t size, const char *format, ...)
{
    size_t used = strlen(text);
    va_list args;
    if (used + 1 >= size) return;
    va_start(args, format);
    vsnprintf(text + used, size - used, format, args);
    va_end(args);
}

/* realloc of the context, or of the C library; new_size [byte] 0 frees, and the result has no meaning. Leaves
 * in_use. */
static void *pdi_base_realloc(pd_ctx *ctx, void *ptr, size_t old_size, size_t new_size)
{
    if (ctx->alloc.fn) return ctx->alloc.fn(ctx->alloc.user, ptr, old_size, new_size);
    if (new_size == 0) {
        free(ptr);
        return NULL;
    }
    return realloc(ptr, new_size);
}

/* The pointer stored at `slot`, read as bytes. */
static void *pdi_base_load_pointer(const void *slot)
{
    void *ptr;
    memcpy(&ptr, slot, sizeof ptr);
    return ptr;
}

pd_status pd_resize(pd_ctx *ctx, const char *where, size_t old_count, size_t new_count, size_t size,
                            void *slot)
{
    void *old = pdi_base_load_pointer(slot);
    size_t old_bytes = old ? (old_count ? old_count : 1) * size : 0;
    if (new_count == 0) new_count = 1;
    if (new_count > (size_t)-1 / 2 / size)
        return pd_fail(ctx, PD_ERR_SIZE, where, "%.0f elements of %.0f bytes overflow the address space",
                       (double)new_count, (double)size);
    size_t new_bytes = new_count * size;
    size_t limit = ctx->alloc.limit;
    if (limit && new_bytes > old_bytes && ctx->in_use + (new_bytes - old_bytes) > limit)
        return pd_fail(ctx, PD_ERR_LIMIT, where, "needs %.4g MB more, %.4g MB are in use, the limit is %.4g MB",
                       (double)(new_bytes - old_bytes) * 1e-6, (double)ctx->in_use * 1e-6, (double)limit * 1e-6);
    void *fresh = pdi_base_realloc(ctx, old, old_bytes, new_bytes);
    if (!fresh)
        return pd_fail(ctx, PD_ERR_MEMORY, where, "%.4g MB could not be allocated (%.4g MB are in use)",
                       (double)new_bytes * 1e-6, (double)ctx->in_use * 1e-6);
    if (new_bytes > old_bytes) memset((char *)fresh + old_bytes, 0, new_bytes - old_bytes);
    memcpy(slot, &fresh, sizeof fresh);
    ctx->in_use = ctx->in_use + new_bytes - old_bytes;
    if (ctx->in_use > ctx->peak) ctx->peak = ctx->in_use;
    return PD_OK;
}

pd_status pd_check_cancel(pd_ctx *ctx, const char *doing, int64_t count)
{
    if (!ctx->cancel || !ctx->cancel(ctx->cancel_user, doing, count)) return PD_OK;
    return pd_fail(ctx, PD_CANCELLED, doing, "stopped by the caller");
}

pd_status pd_alloc(pd_ctx *ctx, const char *where, size_t count, size_t size, void *slot)
{
    void *none = NULL;
    memcpy(slot, &none, sizeof none);
    return pd_resize(ctx, where, 0, count, size, slot);
}

void pd_free(pd_ctx *ctx, size_t count, size_t size, void *slot)
{
    void *ptr = pdi_base_load_pointer(slot);
    if (!ptr) return;
    size_t bytes = (count ? count : 1) * size;
    pdi_base_realloc(ctx, ptr, bytes, 0);
    ctx->in_use -= bytes;
    ptr = NULL;
    memcpy(slot, &ptr, sizeof ptr);
}
