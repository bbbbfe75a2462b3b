/* active_range: see active_range.h */
#include "lattice/active_range.h"
#include "core/array_registry.h"
#include "core/par.h"
#include <string.h>

/* 1: the node is fluid or solid. */
static int pdi_active_range_is_active(const pd_grid *grid, int32_t node)
{
    return grid->kind[node] == PD_FLUID || grid->kind[node] == PD_SOLID;
}

/* Sets count and packed_length of s; list 1: also first, packed_start and length, which have room. Each grid line along
 * axis 0 has one range, from its first active node to its last one, or none; inactive nodes between them count. */
static void pdi_active_range_find(const pd_grid *grid, pd_active_ranges *s, int list)
{
    int32_t line = grid->padded[0];
    s->count = s->packed_length = 0;
    for (int32_t node = 0; node < grid->total; node += line) {
        int32_t low = 0, high = line;
        while (low < high && !pdi_active_range_is_active(grid, node + low)) low++;
        while (low < high && !pdi_active_range_is_active(grid, node + high - 1)) high--;
        if (low == high) continue;
        if (list) {
            s->first[s->count] = node + low;
            s->packed_start[s->count] = s->packed_length;
            s->length[s->count] = high - low;
        }
        s->count++;
        s->packed_length += high - low;
    }
}

/* Describes the arrays of the ranges to the array registry. */
static void pdi_active_range_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_active_ranges *spans = (pd_active_ranges *)object;
    PDI_ARRAY(owner, spans, first, spans->capacity, "1");
    PDI_ARRAY(owner, spans, packed_start, spans->capacity, "1");
    PDI_ARRAY(owner, spans, length, spans->capacity, "1");
}

PDI_FN pd_status pdi_active_range_build(pd_ctx *ctx, const pd_grid *grid, pd_active_ranges *s)
{
    memset(s, 0, sizeof *s);
    s->total = grid->total;
    pdi_active_range_find(grid, s, 0);
    s->capacity = s->count;
    PD_TRY(pdi_array_registry_build(ctx, pdi_active_range_list_arrays, s));
    pdi_active_range_find(grid, s, 1);
    return PD_OK;
}

PDI_FN void pdi_active_range_free(pd_ctx *ctx, pd_active_ranges *s)
{
    pdi_array_registry_free(ctx, pdi_active_range_list_arrays, s);
    memset(s, 0, sizeof *s);
}

/* Sets to zero, in one component full [total], the nodes from the end of range k to the begin of the next one, or to
 * the end of the array behind the last range; for k = 0 also the nodes in front of the first range. */
static void pdi_active_range_set_gaps_zero(const pd_active_ranges *s, int32_t k, double *full)
{
    int32_t behind = s->first[k] + s->length[k], next = k + 1 < s->count ? s->first[k + 1] : s->total;
    memset(full + behind, 0, (size_t)(next - behind) * sizeof *full);
    if (k == 0) memset(full, 0, (size_t)s->first[0] * sizeof *full);
}

/* Body of one thread: copies range by range from full [components][total] to packed [components][packed_length] vectors
 * (pack 1), or back (pack 0), where nodes outside of the ranges become zero. */
static void pdi_active_range_copy_ranges(const pd_active_ranges *s, int components, const double *from, double *to,
                                         int pack)
{
    PDI_FOR_NOWAIT
    for (int32_t k = 0; k < components * s->count; k++) {
        int32_t span = k % s->count;
        int64_t c = k / s->count, full = c * s->total + s->first[span],
                packed = c * s->packed_length + s->packed_start[span];
        memcpy(to + (pack ? packed : full), from + (pack ? full : packed), (size_t)s->length[span] * sizeof *to);
        if (!pack) pdi_active_range_set_gaps_zero(s, span, to + c * s->total);
    }
}

/* Copies from full to packed vectors (pack 1) or back (pack 0) with threads, as pdi_active_range_copy_ranges does. */
static void pdi_active_range_copy(const pd_ctx *ctx, const pd_active_ranges *s, int components, const double *from,
                                  double *to, int pack)
{
    int nt = pd_par_threads(ctx, (int64_t)components * s->packed_length);
    PDI_PARALLEL_CALL(nt, pdi_active_range_copy_ranges(s, components, from, to, pack));
}

PDI_FN void pdi_active_range_pack(const pd_ctx *ctx, const pd_active_ranges *s, int components, const double *full,
                                  double *packed)
{
    pdi_active_range_copy(ctx, s, components, full, packed, 1);
}

PDI_FN void pdi_active_range_unpack(const pd_ctx *ctx, const pd_active_ranges *s, int components, const double *packed,
                                    double *full)
{
    if (s->count == 0) memset(full, 0, (size_t)components * (size_t)s->total * sizeof *full);
    else pdi_active_range_copy(ctx, s, components, packed, full, 0);
}
