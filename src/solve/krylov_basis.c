/* krylov_basis: see krylov_basis.h */
#include "solve/krylov_basis.h"
#include "core/par.h"
#include "solve/hessenberg.h"
#include <math.h>
#include <string.h>

/* Entries of `dense`: rotations, right-hand side, coefficients, and last the Hessenberg matrix, which may grow. */
static int64_t pdi_krylov_basis_dense_size(const pd_krylov_desc *desc, int columns)
{
    int64_t most = desc->max_vectors + 1;
    return desc->method == PD_KRYLOV_GMRES ? 4 * most + pdi_hessenberg_column_offset(columns) : 0;
}

PDI_FN int pdi_krylov_iterate_size(const pd_krylov_desc *desc)
{
    return desc->basis_precision == PD_KRYLOV_INT16 ? 4 : desc->basis_precision == PD_KRYLOV_SINGLE ? 2 : 1;
}

PDI_FN int64_t pdi_krylov_integer_size(int64_t length) { return (length + 3) / 4 * 2; }
static int64_t pdi_krylov_basis_scale_size(int64_t length) { return (length / (2 * PDI_PAR_QUANTISED_BLOCK) + 1) * 2; }

PDI_COLD_BEGIN
PDI_FN void pdi_krylov_list(pdi_array_visitor *owner, void *object)
{
    pd_krylov *krylov = (pd_krylov *)object;
    PDI_ARRAY(owner, krylov, work, krylov->desc.n * krylov->vectors, "1");
    if (krylov->basis_entries && krylov->desc.basis_precision)
        PDI_ARRAY_UNINIT(owner, krylov, compressed_basis, krylov->basis_entries, "1");
    if (krylov->basis_entries && !krylov->desc.basis_precision)
        PDI_ARRAY_UNINIT(owner, krylov, basis, krylov->basis_entries, "1");
}

/* List function: the dense work array of GMRES. */
static void pdi_krylov_basis_dense_list(pdi_array_visitor *owner, void *object)
{
    pd_krylov *krylov = (pd_krylov *)object;
    PDI_ARRAY(owner, krylov, dense, pdi_krylov_basis_dense_size(&krylov->desc, krylov->columns), "1");
}

/* Columns of a chunk by which the basis grows: PD_KRYLOV_MAX_CHUNKS chunks reach max_vectors. 0: it does not grow. */
static int pdi_krylov_basis_chunk_columns(const pd_krylov *krylov)
{
    int more = krylov->desc.max_vectors - krylov->base_columns;
    return more > 0 ? (more + PD_KRYLOV_MAX_CHUNKS - 1) / PD_KRYLOV_MAX_CHUNKS : 0;
}

/* Compute stride, base_columns, chunk_columns and, where it is 0, basis_entries for the storage format in desc. */
static void pdi_krylov_basis_set_layout(pd_krylov *krylov)
{
    const pd_krylov_desc *d = &krylov->desc;
    int64_t length = krylov->length;
    krylov->stride = length;
    if (d->basis_precision == PD_KRYLOV_INT16)
        krylov->stride = pdi_krylov_integer_size(length) + pdi_krylov_basis_scale_size(length);
    if (!krylov->basis_entries) krylov->basis_entries = krylov->stride * krylov->basis_vectors;
    /* 0: no node at all */
    int64_t vectors = krylov->stride ? krylov->basis_entries / krylov->stride : krylov->basis_vectors;
    int64_t columns = (vectors - 1) / (d->flexible ? 2 : 1);
    krylov->base_columns = (int)(columns < d->max_vectors ? columns : d->max_vectors);
    krylov->chunk_columns = pdi_krylov_basis_chunk_columns(krylov);
}

PDI_FN void pdi_krylov_set_flexible(pd_krylov *krylov, int flexible)
{
    krylov->desc.flexible = flexible;
    pdi_krylov_basis_set_layout(krylov);
}

PDI_FN pd_status pdi_krylov_check_range(pd_ctx *ctx, const pd_krylov_desc *d)
{
    int64_t end = d->end ? d->end : d->n;
    if (d->first >= 0 && d->first < end && end <= d->n && (d->end || !d->first)) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov",
                   "first = %.0f, end = %.0f of %.0f entries, expected 0 <= first < end <= n (both 0: all)",
                   (double)d->first, (double)d->end, (double)d->n);
}

PDI_FN pd_status pdi_krylov_init(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov)
{
    memset(krylov, 0, sizeof *krylov);
    krylov->desc = *desc;
    pd_krylov_desc *d = &krylov->desc;
    if (d->restart == 0) d->restart = 30;
    if (d->max_vectors < d->restart) d->max_vectors = d->restart;
    if (d->max_iterations == 0) d->max_iterations = 200;
    if (d->rtol == 0.0) d->rtol = 1e-8;
    if (d->n < 1) return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "n = %.0f, needs at least 1", (double)d->n);
    if (d->spans && (d->components < 1 || d->n != (int64_t)d->components * d->spans->total))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "n = %.0f, expected %d times %d", (double)d->n, d->components,
                       (int)d->spans->total);
    PD_TRY(pdi_krylov_check_range(ctx, d));
    krylov->length = d->spans ? (int64_t)d->components * d->spans->packed_length : d->n;
    if (d->restart < 1 || d->restart > 1000 || d->initial_vectors < 0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "restart = %d, needs 1 .. 1000 (0: 30); least = %d", d->restart,
                       d->initial_vectors);
    if (d->low_memory && (d->method != PD_KRYLOV_GMRES || d->flexible || !d->zero_guess))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "lean without GMRES and zero_guess, or flexible");
    krylov->base_columns = d->initial_vectors && d->initial_vectors < d->restart ? d->initial_vectors : d->restart;
    if (d->low_memory && krylov->base_columns < 2 * pdi_krylov_iterate_size(d) + 1)
        krylov->base_columns = 2 * pdi_krylov_iterate_size(d) + 1;
    if (d->max_iterations < 1)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "max_iterations = %d, needs at least 1 (0: 200)",
                       d->max_iterations);
    if (!(d->rtol > 0.0 && d->rtol < 1.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "rtol = %g, needs 0 < rtol < 1 (0: 1e-8)", d->rtol);
    if (!(d->atol >= 0.0 && d->atol <= DBL_MAX))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "atol = %g, needs to be finite and >= 0", d->atol);
    switch (d->method) {
    case PD_KRYLOV_GMRES:
        krylov->vectors = d->low_memory ? 1 : 2;
        krylov->basis_vectors = d->flexible ? 2 * krylov->base_columns + 1 : krylov->base_columns + 1;
        pdi_krylov_basis_set_layout(krylov);
        krylov->columns = krylov->built_columns = d->restart > krylov->base_columns ? d->restart : krylov->base_columns;
        break;
    case PD_KRYLOV_CG: krylov->vectors = 5; break;
    default: return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "method %d is unknown", (int)d->method);
    }
    int most = krylov->vectors + krylov->basis_vectors;
    if (d->n > INT64_MAX / most)
        return pd_fail(ctx, PD_ERR_SIZE, "krylov", "%d vectors of %.0f entries overflow", most, (double)d->n);
    return PD_OK;
}

PDI_FN pd_status pdi_krylov_build_unallocated(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov)
{
    pd_status status = pdi_krylov_init(ctx, desc, krylov);
    if (status == PD_OK) status = pdi_array_registry_build(ctx, pdi_krylov_basis_dense_list, krylov);
    if (status < 0) memset(krylov, 0, sizeof *krylov);
    return status;
}

pd_status pd_krylov_build(pd_ctx *ctx, const pd_krylov_desc *desc, pd_krylov *krylov)
{
    pd_status status = pdi_krylov_build_unallocated(ctx, desc, krylov);
    if (status == PD_OK) status = pdi_array_registry_build(ctx, pdi_krylov_list, krylov);
    if (status < 0) pd_krylov_free(ctx, krylov);
    return status;
}
PDI_COLD_END

/* Entries of one chunk: chunk_columns vectors and, when flexible, as many preconditioned ones. */
static int64_t pdi_krylov_basis_chunk_size(const pd_krylov *krylov)
{
    return krylov->stride * krylov->chunk_columns * (krylov->desc.flexible ? 2 : 1);
}

/* Size [byte] of an entry of the stored basis: of a float where the basis is compressed, else of a double. */
static size_t pdi_krylov_basis_entry_bytes(const pd_krylov *krylov)
{
    return krylov->desc.basis_precision ? sizeof *krylov->compressed_basis : sizeof *krylov->basis;
}

/* Make room for exactly `columns` columns of the Hessenberg matrix, in `dense`, which may move; what fits is kept. */
static pd_status pdi_krylov_basis_resize_hessenberg(pd_ctx *ctx, pd_krylov *krylov, int columns)
{
    PD_TRY(PD_GROW(ctx, "krylov", pdi_krylov_basis_dense_size(&krylov->desc, krylov->columns),
                   pdi_krylov_basis_dense_size(&krylov->desc, columns), krylov->dense));
    krylov->columns = columns;
    return PD_OK;
}

PDI_FN void pdi_krylov_free_growth(pd_ctx *ctx, pd_krylov *krylov)
{
    if (!krylov->chunk_count && krylov->columns <= krylov->built_columns) return;
    while (krylov->chunk_count)
        pd_free(ctx, (size_t)pdi_krylov_basis_chunk_size(krylov), pdi_krylov_basis_entry_bytes(krylov),
                &krylov->chunk[--krylov->chunk_count]);
    if (krylov->columns <= krylov->built_columns ||
        pdi_krylov_basis_resize_hessenberg(ctx, krylov, krylov->built_columns) == PD_OK)
        return;
    ctx->status = PD_OK; /* what is too large does no harm */
    ctx->message[0] = '\0';
}

PDI_FN int pdi_krylov_capacity(const pd_krylov *krylov)
{
    int columns = krylov->base_columns - krylov->iterate_vectors + krylov->chunk_count * krylov->chunk_columns;
    if (columns > krylov->columns) columns = krylov->columns;
    return columns < krylov->desc.max_vectors ? columns : krylov->desc.max_vectors;
}

/* List function: the next chunk. */
static void pdi_krylov_basis_chunk_list(pdi_array_visitor *owner, void *object)
{
    pd_krylov *krylov = (pd_krylov *)object;
    pdi_array_registry_add(owner, PDI_ARRAY_KIND_UNINIT, "krylov.more", "1", pdi_krylov_basis_chunk_size(krylov),
                           pdi_krylov_basis_entry_bytes(krylov), &krylov->chunk[krylov->chunk_count]);
}

/* Get memory for one more chunk: from the arena, or else allocated. chunk_count stays. */
static pd_status pdi_krylov_basis_add_chunk(pd_ctx *ctx, pd_krylov *krylov)
{
    pd_arena *arena = krylov->desc.arena;
    krylov->chunk_is_lent[krylov->chunk_count] = arena && pdi_arena_fits(arena, pdi_krylov_basis_chunk_list, krylov);
    if (krylov->chunk_is_lent[krylov->chunk_count])
        return pdi_arena_acquire(ctx, arena, pdi_krylov_basis_chunk_list, krylov);
    return pdi_array_registry_build(ctx, pdi_krylov_basis_chunk_list, krylov);
}

PDI_FN int pdi_krylov_grow_basis(pd_ctx *ctx, pd_krylov *krylov)
{
    int columns = krylov->base_columns + krylov->chunk_count * krylov->chunk_columns; /* without a shift */
    int chunk = krylov->columns >= columns; /* the basis limits, not the matrix */
    if (pdi_krylov_capacity(krylov) == krylov->desc.max_vectors) return 0;
    if (chunk && (!krylov->chunk_columns || krylov->chunk_count == PD_KRYLOV_MAX_CHUNKS)) return 0;
    if (chunk) columns += krylov->chunk_columns;
    pd_status status = krylov->columns < columns ? pdi_krylov_basis_resize_hessenberg(ctx, krylov, columns) : PD_OK;
    if (status == PD_OK && chunk) status = pdi_krylov_basis_add_chunk(ctx, krylov);
    if (status == PD_OK) {
        krylov->chunk_count += chunk;
        return 1;
    }
    if (krylov->desc.fixed_restart) return status;
    ctx->status = PD_OK; /* continue without growth */
    ctx->message[0] = '\0';
    return 0;
}

PDI_FN pd_status pdi_krylov_release_chunks(pd_ctx *ctx, pd_krylov *krylov, pd_status status)
{
    int kept = 0, chunks = krylov->chunk_count;
    while (krylov->chunk_count--)
        if (krylov->chunk_is_lent[krylov->chunk_count])
            status = pdi_arena_release(ctx, krylov->desc.arena, pdi_krylov_basis_chunk_list, krylov, status);
    for (int k = 0; k < chunks; k++) {
        void *chunk = krylov->chunk[k];
        krylov->chunk[k] = NULL;
        if (krylov->chunk_is_lent[k]) krylov->chunk_is_lent[k] = 0;
        else krylov->chunk[kept++] = chunk;
    }
    krylov->chunk_count = kept;
    return status;
}

/* Number of floats in the memory of the arrays of a list. */
static int64_t pdi_krylov_basis_count_floats(pdi_array_list_fn list, void *object)
{
    return (int64_t)(pdi_arena_count_bytes(list, object) / sizeof(float));
}

PDI_FN int pdi_krylov_lend_basis(pd_ctx *ctx, pd_krylov *krylov, pd_arena *arena, pdi_array_list_fn list, void *object,
                                 int least)
{
    int64_t entries = pdi_krylov_basis_count_floats(list, object);
    if (krylov->desc.basis_precision != PD_KRYLOV_SINGLE || krylov->desc.flexible) return 0;
    if (krylov->basis_entries - entries < least * krylov->stride || !pdi_arena_fits(arena, pdi_krylov_list, krylov))
        return 0;
    if (pdi_arena_acquire(ctx, arena, list, object) < 0) return 0;
    krylov->basis_entries -= entries;
    pdi_krylov_set_flexible(krylov, 0);
    return 1;
}

PDI_FN pd_status pdi_krylov_restore_basis(pd_ctx *ctx, pd_krylov *krylov, pd_arena *arena, pdi_array_list_fn list,
                                          void *object, pd_status status)
{
    krylov->basis_entries += pdi_krylov_basis_count_floats(list, object);
    return pdi_arena_release(ctx, arena, list, object, status);
}

void pd_krylov_free(pd_ctx *ctx, pd_krylov *krylov)
{
    pdi_krylov_free_growth(ctx, krylov);
    pdi_array_registry_free(ctx, pdi_krylov_list, krylov);
    pdi_array_registry_free(ctx, pdi_krylov_basis_dense_list, krylov);
    memset(krylov, 0, sizeof *krylov);
}

PDI_FN int pdi_krylov_precond_first(const pd_krylov *k) { return k->desc.max_vectors + 1; }

/* Offset of basis vector i in its chunk; *chunk -1: the basis as built, k->chunk_count: there is no such vector. */
static int64_t pdi_krylov_basis_find_vector(const pd_krylov *k, int i, int *chunk)
{
    int base = k->base_columns - k->iterate_vectors, grow = k->chunk_columns,
        flexible = i >= pdi_krylov_precond_first(k);
    int at = flexible ? i - pdi_krylov_precond_first(k) : i - 1;
    *chunk = at < base ? -1 : grow ? (at - base) / grow : k->chunk_count;
    if (flexible && !k->desc.flexible) *chunk = k->chunk_count;
    if (*chunk >= k->chunk_count) return 0; /* there is none */
    if (*chunk < 0) return k->stride * (flexible ? base + 1 + at : k->iterate_vectors + i);
    return k->stride * ((at - base) % grow + (flexible ? grow : 0));
}

PDI_FN double *pdi_krylov_get_double(const pd_krylov *k, int i)
{
    int chunk;
    int64_t at = pdi_krylov_basis_find_vector(k, i, &chunk);
    if (k->desc.basis_precision || chunk >= k->chunk_count) return NULL;
    return chunk < 0 ? k->basis + at : (double *)k->chunk[chunk] + at;
}

PDI_FN float *pdi_krylov_get_single(const pd_krylov *k, int i)
{
    int chunk;
    int64_t at = pdi_krylov_basis_find_vector(k, i, &chunk);
    if (!k->desc.basis_precision || chunk >= k->chunk_count) return NULL;
    return chunk < 0 ? k->compressed_basis + at : (float *)k->chunk[chunk] + at;
}
