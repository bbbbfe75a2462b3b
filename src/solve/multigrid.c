/* multigrid: see multigrid.h
 *
 * V(2,2) cycle with piecewise constant transfers (restriction sums, prolongation copies). Galerkin coarse operators
 * would be twice too stiff along a halved axis for these transfers, so conductances are rediscretised; this beats
 * linear interpolation at equal cost. Two smoothers:
 *   symmetric: red-black Gauss-Seidel, red first from zero; the sweeps after the coarse correction run backwards, which
 *     keeps the cycle symmetric. After a black half sweep the residual is zero on black cells, and prolongation to
 *     black cells would be overwritten, so both are done for red cells only.
 *   with flow: from x = b / diag (a third fewer iterations than from zero) each line along axis 0 is swept forwards
 *     and backwards, lines ascending before the coarse correction and descending after it: upwind information crosses
 * the box
 *     in any direction within one cycle, where red-black sweeps carry it a few cells (rotating flow, cell Peclet 1000,
 *     128^2 cells: 19 instead of 80 GMRES iterations). Cells whose diagonal flow or mass dominates, so that these
 *     sweeps solve for them, are excluded from coarser levels (pin in a stream: the same iterations in 0.6 of the
 * time).
 */
#include "solve/multigrid.h"
#include "core/par.h"
#include "solve/coarsen.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* [-] Upper limit of scaled masses and walls: they act as infinite, and single precision does not overflow. */
#define PDI_MULTIGRID_MAX_MASS 1e30
/* Least operations of a loop over a level that pay for all threads: a barrier takes 0.3 us, the time of 600. */
#define PDI_MULTIGRID_MIN_WORK 4000
/* A cycle takes as long as this many loops over the finest level. */
#define PDI_MULTIGRID_CYCLE_LOOPS 4

/* ---- memory ---- */

/* Number of floats of level 0 for the coefficients with their pads, inverse_diagonal and row_sum. */
static size_t pdi_multigrid_count_coefficients(const pd_multigrid *mg)
{
    size_t padded = mg->desc.symmetric ? PD_DIM : 2 * PD_DIM, cells = (size_t)mg->level[0].cells;
    return padded * (cells + 2 * (size_t)mg->pad) + (pdi_coarsen_floats_per_cell(mg->desc.high_contrast) - 2) * cells;
}
PDI_FN size_t pdi_multigrid_field_floats(const pd_multigrid *mg)
{
    return 3 * (size_t)mg->level[0].cells + 2 * (size_t)mg->pad;
}

/* Number of doubles of level 0 for coarse_correction with its pads; 0 without contrast. */
static size_t pdi_multigrid_count_sums(const pd_multigrid *mg)
{
    return mg->desc.high_contrast ? (size_t)mg->level[0].cells + 2 * (size_t)mg->pad : 0;
}

PDI_COLD_BEGIN
PDI_FN void pdi_multigrid_list(pdi_array_visitor *owner, void *object)
{
    pd_multigrid *mg = (pd_multigrid *)object;
    pd_smoother_level *fine = &mg->level[0];
    int wraps = 0;
    for (int d = 0; d < PD_DIM; d++) wraps = wraps || fine->periodic[d];
    PDI_ARRAY_UNINIT(owner, mg, coefficients, pdi_multigrid_count_coefficients(mg), "1");
    if (!mg->desc.host && !mg->desc.caller_fields)
        PDI_ARRAY_UNINIT(owner, mg, fields, pdi_multigrid_field_floats(mg), "1");
    if (mg->desc.high_contrast) PDI_ARRAY(owner, mg, sums, pdi_multigrid_count_sums(mg), "1");
    PDI_ARRAY(owner, fine, parent, fine->cells, "1");
    PDI_ARRAY(owner, fine, begin, fine->n[0] ? 2 * (fine->cells / fine->n[0]) : 0, "1");
    if (wraps) PDI_ARRAY(owner, fine, has_periodic_neighbour, fine->cells, "1");
}

PDI_FN void pdi_multigrid_setup_list(pdi_array_visitor *owner, void *object)
{
    pd_multigrid *mg = (pd_multigrid *)object;
    PDI_ARRAY(owner, mg, setup_work, mg->level[0].cells + 3, "1");
}

/* Mark the cells of level 0 that have periodic neighbours. */
static void pdi_multigrid_mark_periodic(pd_smoother_level *fine)
{
    for (int d = 0; d < PD_DIM; d++) {
        int32_t stride = pdi_smoother_stride(fine->n, d), along = stride * fine->n[d];
        for (int32_t c = 0; fine->periodic[d] && c < fine->cells; c += along) {
            memset(fine->has_periodic_neighbour + c, 1, (size_t)stride);
            memset(fine->has_periodic_neighbour + c + along - stride, 1, (size_t)stride);
        }
    }
}

PDI_FN pd_status pdi_multigrid_init(pd_ctx *ctx, const pd_multigrid_desc *desc, pd_multigrid *mg)
{
    memset(mg, 0, sizeof *mg);
    mg->desc = *desc;
    pd_smoother_level *fine = &mg->level[0];
    int64_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) {
        if (desc->n[d] < 1 || desc->stride[d] < 1 || desc->first < 0)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "axis %d: n = %d, stride = %d, first = %d", d,
                           desc->n[d], (int)desc->stride[d], (int)desc->first);
        cells *= desc->n[d];
        if (cells > INT32_MAX / (2 * PD_DIM))
            return pd_fail(ctx, PD_ERR_SIZE, "multigrid", "the box has more than %d cells", INT32_MAX / (2 * PD_DIM));
        fine->n[d] = desc->n[d];
        fine->last_width[d] = 1.0f;
    }
    fine->cells = (int32_t)cells;
    fine->symmetric_storage = desc->symmetric;
    for (int d = 0; d < PD_DIM; d++)
        fine->periodic[d] = pdi_coarsen_is_periodic(desc->symmetric, fine->n[d], desc->periodic[d]);
    mg->pad = pdi_smoother_stride(fine->n, PD_DIM - 1);
    if (desc->host) desc->host->is_host = 1;
    return PD_OK;
}

/* Zero the pads before and after an array of level 0, or (all = 1) the whole array. values: its entry of cell 0. */
static void pdi_multigrid_zero_pads(const pd_multigrid *mg, float *values, int all)
{
    int64_t cells = mg->level[0].cells, pad = mg->pad;
    memset(values - pad, 0, (size_t)(all ? cells + 2 * pad : pad) * sizeof *values);
    if (!all) memset(values + cells, 0, (size_t)pad * sizeof *values);
}

/* Remove a multigrid from the stack of unused ones of its arena. */
static void pdi_multigrid_remove_unused(pd_multigrid *mg)
{
    pd_arena *arena = mg->desc.arena;
    int kept = 0;
    if (!arena) return;
    for (int k = 0; k < arena->unused_count; k++)
        if (arena->unused[k] != mg) arena->unused[kept++] = arena->unused[k];
    arena->unused_count = kept;
}

/* Take over the memory of the coarse levels of the multigrid that was used last, if this one has none, and take both
 * off the stack of unused ones. */
static void pdi_multigrid_take_over_levels(pd_multigrid *mg)
{
    pd_arena *arena = mg->desc.arena;
    int own = mg->level[1].cell_capacity > 0;
    pdi_multigrid_remove_unused(mg);
    if (own || !arena || !arena->unused_count) return;
    pd_multigrid *other = (pd_multigrid *)arena->unused[--arena->unused_count];
    for (int l = 1; l < PD_MULTIGRID_LEVELS; l++) {
        mg->level[l] = other->level[l];
        memset(&other->level[l], 0, sizeof other->level[l]);
    }
}

/* Put a multigrid on the stack of unused ones of its arena, if it has coarse levels and the stack has room. */
static void pdi_multigrid_add_unused(pd_multigrid *mg)
{
    pd_arena *arena = mg->desc.arena;
    if (arena && mg->level[1].cell_capacity && arena->unused_count < PD_ARENA_MAX_UNUSED)
        arena->unused[arena->unused_count++] = mg;
}

PDI_FN void pdi_multigrid_set_pointers(pd_multigrid *mg)
{
    const pd_multigrid_desc *desc = &mg->desc;
    pdi_multigrid_take_over_levels(mg);
    pd_smoother_level *fine = &mg->level[0];
    int64_t cells = fine->cells;
    float *next = mg->coefficients + mg->pad;
    int64_t length = cells + 2 * (int64_t)mg->pad;
    for (int d = 0; d < PD_DIM; d++, next += length) fine->hi[d] = next;
    for (int d = 0; d < PD_DIM; d++) {
        fine->lo[d] = desc->symmetric ? fine->hi[d] - pdi_smoother_stride(fine->n, d) : next;
        if (!desc->symmetric) next += length;
    }
    fine->x = (desc->host ? desc->host->fields : mg->fields) + mg->pad;
    pdi_multigrid_zero_pads(mg, fine->x, 0);
    for (int d = 0; d < PD_DIM; d++) pdi_multigrid_zero_pads(mg, fine->hi[d], 0);
    for (int d = 0; d < PD_DIM && !desc->symmetric; d++) pdi_multigrid_zero_pads(mg, fine->lo[d], 1);
    fine->b = fine->x + cells + mg->pad;
    fine->r = fine->b + cells;
    fine->inverse_diagonal = next - mg->pad;
    if (desc->high_contrast) {
        fine->row_sum = fine->inverse_diagonal + cells;
        fine->coarse_correction = mg->sums + mg->pad;
    }
    pdi_multigrid_mark_periodic(fine);
    fine->end = fine->begin + cells / fine->n[0];
}

PDI_FN void pdi_multigrid_clear_pointers(pd_multigrid *mg)
{
    pd_smoother_level *fine = &mg->level[0];
    mg->levels = 0;
    fine->x = fine->b = fine->r = fine->inverse_diagonal = fine->row_sum = NULL;
    fine->coarse_correction = NULL;
    fine->end = NULL;
    for (int d = 0; d < PD_DIM; d++) fine->lo[d] = fine->hi[d] = NULL;
    pdi_multigrid_add_unused(mg);
}

PDI_FN void pdi_multigrid_free(pd_ctx *ctx, pd_multigrid *mg)
{
    pdi_multigrid_remove_unused(mg);
    pdi_array_registry_free(ctx, pdi_multigrid_list, mg);
    pdi_array_registry_free(ctx, pdi_multigrid_setup_list, mg);
    for (int l = 1; l < PD_MULTIGRID_LEVELS; l++) pdi_coarsen_free(ctx, &mg->level[l]);
    memset(mg, 0, sizeof *mg);
}
PDI_COLD_END

/* ---- setup: the finest level ---- */

/* 1: a valid coefficient: finite and, unless sign_free, not negative. */
static int pdi_multigrid_is_valid(float value, int sign_free)
{
    return fabsf(value) <= FLT_MAX && (sign_free || !(value < 0.0f));
}

/* Check all coefficients of a field (NULL: none), also of inactive cells, and raise *largest to the largest absolute
 * value. PD_ERR_ARGUMENT: one is not finite or, unless sign_free, negative. */
PDI_NOINLINE static pd_status pdi_multigrid_check_field(pd_ctx *ctx, const pd_multigrid *mg, const float *field,
                                                        int sign_free, const char *name, float *largest)
{
    float part[PDI_SMOOTHER_PARTS];
    int32_t cells = field ? mg->level[0].cells : 0, bad = 0;
    int nt = pd_par_threads(ctx, cells);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int q = 0; q < PDI_SMOOTHER_PARTS; q++) {
        part[q] = 0.0f;
        for (int32_t c = pdi_smoother_part_begin(cells, q); c < pdi_smoother_part_begin(cells, q + 1); c++) {
            float size = pdi_multigrid_is_valid(field[c], sign_free) ? fabsf(field[c]) : HUGE_VALF;
            part[q] = size > part[q] ? size : part[q];
        }
    }
    for (int q = 0; q < PDI_SMOOTHER_PARTS; q++) *largest = fmaxf(*largest, part[q]);
    if (*largest <= FLT_MAX) return PD_OK;
    while (pdi_multigrid_is_valid(field[bad], sign_free)) bad++;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "%s is %g at cell %d, needs to be finite%s", name,
                   (double)field[bad], (int)bad, sign_free ? "" : " and >= 0");
}

/* Power of two that scales `largest` to about 1, as far as the range of double allows; 1 for zero, NaN and infinity. */
static double pdi_multigrid_power_of_two(double largest)
{
    int exponent = 0;
    if (largest > 0.0 && largest <= DBL_MAX) frexp(largest, &exponent);
    return ldexp(1.0, exponent > -DBL_MAX_EXP ? -exponent : DBL_MAX_EXP - 1);
}

/* Compute the upwind coefficients hi and lo of level 0, scaled, for the faces normal to axis d. flux NULL: no flow.
 * They are 0 at the box side unless the axis is periodic, and beside inactive cells. */
static void pdi_multigrid_compute_faces(const pd_ctx *ctx, pd_multigrid *mg, int d, const uint8_t *active,
                                        const float *conduct, const float *flux)
{
    pd_smoother_level *fine = &mg->level[0];
    int32_t stride = pdi_smoother_stride(fine->n, d), n = fine->n[d];
    double scale = mg->scale; /* may exceed the range of float */
    float *hi = fine->hi[d], *lo = fine->lo[d];
    int nt = pd_par_threads(ctx, 16 * (int64_t)fine->cells);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t c = 0; c < fine->cells; c++) {
        int inside = c / stride % n < n - 1;
        int32_t above = inside ? c + stride : fine->periodic[d] ? c - (n - 1) * stride : -1;
        int open = above >= 0 && active[c] && active[above];
        float g = open ? (float)(scale * (double)conduct[c]) : 0.0f;
        float f = open && flux ? (float)(scale * (double)flux[c]) : 0.0f;
        hi[c] = g + (f < 0.0f ? -f : 0.0f);
        /* with symmetric storage both are the same element; a periodic one is found through the neighbour */
        if (inside || (above >= 0 && !fine->symmetric_storage)) lo[above] = g + (f > 0.0f ? f : 0.0f);
    }
}

/* Net outflow of cell c of level 0 through its open faces, scaled; outwards positive. It is computed from the flows: in
 * the coefficients they are lost to rounding beside strong conductances. */
static double pdi_multigrid_net_outflow(const pd_multigrid *mg, int32_t c, const float *const *flux)
{
    const pd_smoother_level *fine = &mg->level[0];
    pdi_coarsen_link link;
    double net = 0.0;
    PDI_COARSEN_FOR_LINKS(fine, c, k, link)
    {
        double f = (double)flux[link.axis][link.upper ? c : link.cell];
        net += link.upper ? f : -f;
    }
    return mg->scale * net;
}

/* A wall or a mass in scaled units, at most PDI_MULTIGRID_MAX_MASS. */
static float pdi_multigrid_scale_mass(const pd_multigrid *mg, float given)
{
    return (float)pd_min(mg->scale * (double)given, PDI_MULTIGRID_MAX_MASS);
}

/* Compute inverse_diagonal and, with contrast, row_sum of level 0; r becomes 0. The diagonal is mass, wall and the
 * coefficients of the cell in the rows of its neighbours; where it is 0, as of inactive cells, so is its inverse. The
 * row sum is mass, wall and net outflow. During setup x holds the wall and b the mass of each cell. flux, wall and mass
 * may be NULL. */
static void pdi_multigrid_compute_diagonal(const pd_ctx *ctx, pd_multigrid *mg, const uint8_t *active,
                                           const float *const *flux, const float *wall, const float *mass)
{
    pd_smoother_level *fine = &mg->level[0];
    int nt = pd_par_threads(ctx, 6 * (int64_t)fine->cells);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t c = 0; c < fine->cells; c++) {
        fine->x[c] = wall && active[c] ? pdi_multigrid_scale_mass(mg, wall[c]) : 0.0f;
        fine->b[c] = mass && active[c] ? pdi_multigrid_scale_mass(mg, mass[c]) : 0.0f;
        float diag = fine->x[c] + fine->b[c];
        pdi_coarsen_link link;
        if (active[c]) PDI_COARSEN_FOR_LINKS(fine, c, k, link) diag += link.reverse;
        fine->inverse_diagonal[c] = diag > 0.0f ? 1.0f / diag : 0.0f;
        fine->r[c] = 0.0f;
        double net = flux && fine->row_sum ? pdi_multigrid_net_outflow(mg, c, flux) : 0.0;
        if (fine->row_sum) fine->row_sum[c] = (float)((double)fine->x[c] + (double)fine->b[c] + net);
    }
}

/* Find begin and end, the first active cell of each row of level 0 and one past the last; equal where there is none. */
static void pdi_multigrid_find_row_ends(pd_smoother_level *fine)
{
    int32_t n = fine->n[0];
    for (int32_t r = 0; r < fine->cells / n; r++) {
        int32_t begin = r * n, end = begin + n;
        while (begin < end && !(fine->inverse_diagonal[begin] > 0.0f)) begin++;
        while (begin < end && !(fine->inverse_diagonal[end - 1] > 0.0f)) end--;
        fine->begin[r] = begin;
        fine->end[r] = end;
    }
}

/* Options of the coarsening. */
static pdi_coarsen_options pdi_multigrid_coarsen_options(const pd_multigrid *mg)
{
    pdi_coarsen_options options;
    options.symmetric = mg->desc.symmetric;
    options.contrast = mg->desc.high_contrast;
    options.keep_all = mg->desc.symmetric;
    options.mark = mg->setup_work;
    options.fine_lines = mg->level[0].cells / mg->level[0].n[0];
    return options;
}

/* Build all coarser levels until no axis is to be halved, and count them in mg->levels. PD_ERR_INTERNAL: more than
 * PD_MULTIGRID_LEVELS. PD_CANCELLED, and errors of allocation. */
static pd_status pdi_multigrid_build_levels(pd_ctx *ctx, const pdi_coarsen_options *options, pd_multigrid *mg)
{
    mg->levels = 1;
    for (int l = 0; pdi_coarsen_choose_axes(ctx, options, &mg->level[l]); l++) {
        if (l + 1 == PD_MULTIGRID_LEVELS)
            return pd_fail(ctx, PD_ERR_INTERNAL, "multigrid", "more than %d levels", PD_MULTIGRID_LEVELS);
        PD_TRY(pd_check_cancel(ctx, "multigrid", l));
        PD_TRY(pdi_coarsen_build_level(ctx, options, &mg->level[l], &mg->level[l + 1]));
        mg->levels = l + 2;
    }
    return PD_OK;
}

/* Build all coarser levels. With flow the first call builds them with all cells before, without exclusions, so that
 * later setups allocate nothing. Reads setup_work. */
static pd_status pdi_multigrid_reserve_levels(pd_ctx *ctx, pd_multigrid *mg)
{
    pdi_coarsen_options options = pdi_multigrid_coarsen_options(mg), all = options;
    all.keep_all = 1;
    /* a later setup may need memory for all cells, and time steps allocate nothing */
    if (!options.keep_all && !mg->has_full_capacity) PD_TRY(pdi_multigrid_build_levels(ctx, &all, mg));
    mg->has_full_capacity = 1;
    return pdi_multigrid_build_levels(ctx, &options, mg);
}

/* pdi_multigrid_reserve_levels with the work array lent by the arena, where there is one. PD_ERR_INTERNAL: the arena
 * has no room. */
static pd_status pdi_multigrid_setup_levels(pd_ctx *ctx, pd_multigrid *mg)
{
    pd_arena *arena = mg->desc.arena;
    if (!arena) return pdi_multigrid_reserve_levels(ctx, mg);
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_multigrid_setup_list, mg));
    return pdi_arena_release(ctx, arena, pdi_multigrid_setup_list, mg, pdi_multigrid_reserve_levels(ctx, mg));
}

PDI_FN pd_status pdi_multigrid_setup(pd_ctx *ctx, pd_multigrid *mg, const uint8_t *active,
                                     const float *const conduct[PD_DIM], const float *const flux[PD_DIM],
                                     const float *wall, const float *mass)
{
    float largest = 0.0f;
    mg->levels = 0;
    if (!mg->level[0].parent) return pd_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "setup before a successful build");
    if (flux && mg->desc.symmetric)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "flux given, but the desc says symmetric");
    for (int d = 0; d < PD_DIM; d++) {
        PD_TRY(pdi_multigrid_check_field(ctx, mg, conduct[d], 0, "conduct", &largest));
        if (flux) PD_TRY(pdi_multigrid_check_field(ctx, mg, flux[d], 1, "flux", &largest));
    }
    PD_TRY(pdi_multigrid_check_field(ctx, mg, wall, 0, "wall", &largest));
    PD_TRY(pdi_multigrid_check_field(ctx, mg, mass, 0, "mass", &largest));
    mg->scale = pdi_multigrid_power_of_two((double)largest);
    pdi_multigrid_zero_pads(mg, mg->level[0].x, 0);
    for (int d = 0; d < PD_DIM; d++) pdi_multigrid_compute_faces(ctx, mg, d, active, conduct[d], flux ? flux[d] : NULL);
    pdi_multigrid_compute_diagonal(ctx, mg, active, flux, wall, mass);
    pdi_multigrid_find_row_ends(&mg->level[0]);
    pd_status status = pdi_multigrid_setup_levels(ctx, mg);
    if (status < 0) mg->levels = 0;
    return status;
}

PDI_FN pd_status pdi_multigrid_update_mass(pd_ctx *ctx, pd_multigrid *mg, const uint8_t *active, const float *wall,
                                           const float *mass)
{
    float largest = 0.0f;
    if (mg->levels == 0 || !mg->desc.symmetric)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "other masses %s",
                       mg->levels ? "with flow" : "before a successful setup");
    PD_TRY(pdi_multigrid_check_field(ctx, mg, wall, 0, "wall", &largest));
    PD_TRY(pdi_multigrid_check_field(ctx, mg, mass, 0, "mass", &largest));
    pdi_multigrid_compute_diagonal(ctx, mg, active, NULL, wall, mass);
    pdi_multigrid_find_row_ends(&mg->level[0]);
    pdi_coarsen_options options = pdi_multigrid_coarsen_options(mg);
    for (int l = 0; l + 1 < mg->levels; l++) pdi_coarsen_compute_diagonals(&options, &mg->level[l], &mg->level[l + 1]);
    return PD_OK;
}

/* ---- cycle: x of a level from its b ---- */

/* All threads of a team have to call the following functions, which end with a barrier unless they say otherwise. */

/* Restriction: b of the next level = sum of r over the fine cells. */
static void pdi_multigrid_restrict(pdi_par_team team, const pd_smoother_level *level)
{
    const pd_smoother_level *coarse = level + 1;
    for (int32_t p = pdi_par_range_begin(team, coarse->cells); p < pdi_par_range_end(team, coarse->cells); p++) {
        float sum = 0.0f;
        for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) sum += level->r[coarse->child[j]];
        coarse->b[p] = sum;
    }
    pdi_par_barrier(team);
}

/* Apply an operation to one colour, to all cells; sweep all lines. Each with a barrier. */
static void pdi_multigrid_apply_colour(pdi_par_team team, const pd_smoother_level *level, pdi_smoother_op op,
                                       int colour)
{
    pdi_smoother_apply_colour(team, level, op, colour);
    pdi_par_barrier(team);
}

static void pdi_multigrid_apply_all(pdi_par_team team, const pd_smoother_level *level, pdi_smoother_op op)
{
    pdi_smoother_apply_range(team, level, op, 0, level->cells);
    pdi_par_barrier(team);
}

static void pdi_multigrid_sweep_lines(pdi_par_team team, const pd_smoother_level *level, int descending)
{
    pdi_smoother_sweep_lines(team, level, descending);
    pdi_par_barrier(team);
}

/* Pre-smoothing, residual and restriction of a level. Symmetric: red from zero, then black, red, black by Gauss-Seidel,
 * and the residual of red cells only. With flow: Jacobi from zero, one ascending line sweep, and the residual of all
 * cells. */
static void pdi_multigrid_cycle_down(pdi_par_team team, const pd_multigrid *mg, const pd_smoother_level *level)
{
    if (mg->desc.symmetric) {
        pdi_multigrid_apply_colour(team, level, PDI_SMOOTHER_JACOBI, 0);
        pdi_multigrid_apply_colour(team, level, PDI_SMOOTHER_GAUSS_SEIDEL, 1);
        pdi_multigrid_apply_colour(team, level, PDI_SMOOTHER_GAUSS_SEIDEL, 0);
        pdi_multigrid_apply_colour(team, level, PDI_SMOOTHER_GAUSS_SEIDEL, 1);
        pdi_multigrid_apply_colour(team, level, PDI_SMOOTHER_RESIDUAL, 0); /* r stays 0 on the other colour */
    } else {
        pdi_multigrid_apply_all(team, level, PDI_SMOOTHER_JACOBI);
        pdi_multigrid_sweep_lines(team, level, 0);
        pdi_multigrid_apply_all(team, level, PDI_SMOOTHER_RESIDUAL);
    }
    pdi_multigrid_restrict(team, level);
}

/* Prolongation: add the coarse correction to x. With contrast it is kept separately in double precision, and its defect
 * is smoothed: in single precision its rounding, which varies from cell to cell, would dominate in a good conductor. */
static void pdi_multigrid_prolong(pdi_par_team team, const pd_multigrid *mg, const pd_smoother_level *level)
{
    if (level->coarse_correction) {
        pdi_multigrid_apply_all(team, level, PDI_SMOOTHER_PROLONG_SUM);
        pdi_multigrid_apply_all(team, level, PDI_SMOOTHER_DEFECT);
    } else if (mg->desc.symmetric) pdi_multigrid_apply_colour(team, level, PDI_SMOOTHER_PROLONG, 0);
    else pdi_multigrid_apply_all(team, level, PDI_SMOOTHER_PROLONG);
}

/* Prolongation and post-smoothing of a level. Symmetric: black and red, twice. With flow: one descending line sweep.
 * With contrast x is then added to coarse_correction, which becomes the result. */
static void pdi_multigrid_cycle_up(pdi_par_team team, const pd_multigrid *mg, const pd_smoother_level *level)
{
    pdi_multigrid_prolong(team, mg, level);
    for (int sweep = 0; sweep < 2 && mg->desc.symmetric; sweep++) {
        pdi_multigrid_apply_colour(team, level, PDI_SMOOTHER_GAUSS_SEIDEL, 1);
        pdi_multigrid_apply_colour(team, level, PDI_SMOOTHER_GAUSS_SEIDEL, 0);
    }
    if (!mg->desc.symmetric) pdi_multigrid_sweep_lines(team, level, 1);
    if (level->coarse_correction) pdi_multigrid_apply_all(team, level, PDI_SMOOTHER_ADD_TO_SUM);
}

/* The V-cycle of the levels from `first` to the coarsest, which only has a Jacobi step and, with flow, two line sweeps.
 * The team has one thread. */
static void pdi_multigrid_cycle_coarse(pdi_par_team team, const pd_multigrid *mg, int first)
{
    const pd_smoother_level *last = &mg->level[mg->levels - 1];
    for (int l = first; l < mg->levels - 1; l++) pdi_multigrid_cycle_down(team, mg, &mg->level[l]);
    pdi_multigrid_apply_all(team, last, PDI_SMOOTHER_JACOBI); /* symmetric: no links are left */
    for (int sweep = 0; sweep < 2 && !mg->desc.symmetric; sweep++) pdi_multigrid_sweep_lines(team, last, sweep);
    for (int32_t c = 0; c < last->cells && last->coarse_correction; c++)
        last->coarse_correction[c] = (double)last->x[c];
    for (int l = mg->levels - 2; l >= first; l--) pdi_multigrid_cycle_up(team, mg, &mg->level[l]);
}

/* First node, on the padded lattice, of row r of the box. */
static int32_t pdi_multigrid_row_node(const pd_multigrid *mg, int32_t r)
{
    int32_t node = mg->desc.first, rest = r;
    for (int d = 1; d < PD_DIM; d++) {
        node += rest % mg->desc.n[d] * mg->desc.stride[d];
        rest /= mg->desc.n[d];
    }
    return node;
}

/* Factor of the right-hand side in row r of the box, by its index along the last axis; 1 in 1D and without
 * rhs_weight. */
static double pdi_multigrid_row_weight(const pd_multigrid *mg, int32_t r)
{
    const int *n = mg->level[0].n;
    if (PD_DIM == 1 || !mg->desc.rhs_weight) return 1.0;
    return mg->desc.rhs_weight[PD_DIM == 3 ? r / n[PD_DIM - 2] : r];
}

/* max |rhs| over the active cells of row r, times the weight of the row. 0 without active cells; NaN counts as 0. */
static double pdi_multigrid_row_max(const pd_multigrid *mg, int32_t r, const double *rhs)
{
    enum { lanes = 16 };
    const pd_smoother_level *fine = &mg->level[0];
    int32_t s0 = mg->desc.stride[0], begin = fine->begin[r], count = fine->end[r] - begin, c = 0;
    const double *given = rhs + pdi_multigrid_row_node(mg, r) + (begin - r * fine->n[0]) * s0;
    const float *inv = fine->inverse_diagonal + begin;
    double most[lanes], largest = 0.0;
    for (int l = 0; l < lanes; l++) most[l] = 0.0;
    for (; s0 == 1 && c + lanes <= count; c += lanes)
        for (int l = 0; l < lanes; l++) {
            double size = inv[c + l] > 0.0f ? fabs(given[c + l]) : 0.0;
            most[l] = size > most[l] ? size : most[l];
        }
    for (; c < count; c++) {
        double size = inv[c] > 0.0f ? fabs(given[c * s0]) : 0.0;
        largest = size > largest ? size : largest;
    }
    for (int l = 0; l < lanes; l++) largest = most[l] > largest ? most[l] : largest;
    return largest * pdi_multigrid_row_weight(mg, r);
}

/* part [PDI_SMOOTHER_PARTS]: max |rhs| over parts of the rows. No barrier. */
static void pdi_multigrid_part_max(pdi_par_team team, const pd_multigrid *mg, const double *rhs, double *part)
{
    int32_t rows = mg->level[0].cells / mg->level[0].n[0];
    for (int32_t q = pdi_par_range_begin(team, PDI_SMOOTHER_PARTS); q < pdi_par_range_end(team, PDI_SMOOTHER_PARTS);
         q++) {
        double largest = 0.0;
        for (int32_t r = pdi_smoother_part_begin(rows, q); r < pdi_smoother_part_begin(rows, q + 1); r++)
            largest = pd_max(largest, pdi_multigrid_row_max(mg, r, rhs));
        part[q] = largest;
    }
}

/* Zero x, r and the inactive ends of b in row r of level 0, since others have used their memory. */
static void pdi_multigrid_zero_row(const pd_smoother_level *fine, int32_t r)
{
    int32_t n0 = fine->n[0], first = r * n0, begin = fine->begin[r], end = fine->end[r];
    size_t before = (size_t)(begin - first), behind = (size_t)(first + n0 - end);
    memset(fine->x + first, 0, (size_t)n0 * sizeof *fine->x); /* zero coefficients may multiply values that are not
                                                               * written yet */
    memset(fine->b + first, 0, before * sizeof *fine->b);
    memset(fine->b + end, 0, behind * sizeof *fine->b);
    memset(fine->r + first, 0, (size_t)n0 * sizeof *fine->r);
}

/* b = scale * weight of the row * rhs between `begin` and `end` of row r of level 0, from the padded lattice; 0 at
 * inactive cells there. Cells outside are not written. */
static void pdi_multigrid_read_rhs_row(const pd_multigrid *mg, int32_t r, const double *rhs, double scale)
{
    const pd_smoother_level *fine = &mg->level[0];
    int32_t s0 = mg->desc.stride[0], begin = fine->begin[r], count = fine->end[r] - begin;
    const double *PD_RESTRICT given = rhs + pdi_multigrid_row_node(mg, r) + (begin - r * fine->n[0]) * s0;
    const float *PD_RESTRICT inv = fine->inverse_diagonal + begin;
    float *PD_RESTRICT b = fine->b + begin;
    double factor = scale * pdi_multigrid_row_weight(mg, r);
    if (s0 == 1)
        for (int32_t c = 0; c < count; c++) b[c] = inv[c] > 0.0f ? (float)(factor * given[c]) : 0.0f;
    else
        for (int32_t c = 0; c < count; c++) b[c] = inv[c] > 0.0f ? (float)(factor * given[c * s0]) : 0.0f;
}

/* x = scale * solution (coarse_correction with contrast, else x of level 0) of all cells of row r, to the padded
 * lattice. */
static void pdi_multigrid_write_x_row(const pd_multigrid *mg, int32_t r, double scale, double *x)
{
    const pd_smoother_level *fine = &mg->level[0];
    int32_t n0 = fine->n[0], s0 = mg->desc.stride[0];
    const double *PD_RESTRICT sum = fine->coarse_correction ? fine->coarse_correction + r * n0 : NULL;
    const float *PD_RESTRICT single = fine->x + r * n0;
    double *PD_RESTRICT to = x + pdi_multigrid_row_node(mg, r);
    if (sum)
        for (int32_t i = 0; i < n0; i++) to[i * s0] = scale * sum[i];
    else if (s0 == 1)
        for (int32_t i = 0; i < n0; i++) to[i] = scale * (double)single[i];
    else
        for (int32_t i = 0; i < n0; i++) to[i * s0] = scale * (double)single[i];
}

/* One V-cycle, as each thread of the team runs it. part [PDI_SMOOTHER_PARTS]: work array that all threads share. The
 * right-hand side is scaled to about 1 by a power of two. Where others use the memory of x, b and r it is zeroed first.
 * Levels from the first with less than PDI_MULTIGRID_MIN_WORK operations on are left to thread 0. */
static void pdi_multigrid_cycle_thread(pdi_par_team team, const pd_multigrid *mg, double *part, const double *rhs,
                                       double *x)
{
    const pd_smoother_level *fine = &mg->level[0];
    int32_t rows = fine->cells / fine->n[0], first = pdi_par_range_begin(team, rows),
            behind = pdi_par_range_end(team, rows);
    double largest = 0.0;
    int top = 0; /* from this level on one thread is as fast */
    while (top < mg->levels - 1 && (int64_t)mg->level[top].cells * PDI_SMOOTHER_WORK >= PDI_MULTIGRID_MIN_WORK) top++;
    pdi_multigrid_part_max(team, mg, rhs, part);
    pdi_par_barrier(team);
    for (int q = 0; q < PDI_SMOOTHER_PARTS; q++) largest = pd_max(largest, part[q]);
    double in = pdi_multigrid_power_of_two(largest), out = mg->scale / in;
    if ((mg->desc.host || mg->is_host || mg->desc.caller_fields) && !team.rank) pdi_multigrid_zero_pads(mg, fine->x, 0);
    for (int32_t r = first; r < behind; r++) {
        if (mg->desc.host || mg->is_host || mg->desc.caller_fields) pdi_multigrid_zero_row(fine, r);
        pdi_multigrid_read_rhs_row(mg, r, rhs, in);
    }
    pdi_par_barrier(team);
    for (int l = 0; l < top; l++) pdi_multigrid_cycle_down(team, mg, &mg->level[l]);
    if (!team.rank) pdi_multigrid_cycle_coarse(pdi_par_single_team(), mg, top);
    pdi_par_barrier(team);
    for (int l = top - 1; l >= 0; l--) pdi_multigrid_cycle_up(team, mg, &mg->level[l]);
    for (int32_t r = first; r < behind; r++) pdi_multigrid_write_x_row(mg, r, out, x);
}

PDI_FN void pdi_multigrid_cycle(pd_ctx *ctx, pd_multigrid *mg, const double *rhs, double *x)
{
    double part[PDI_SMOOTHER_PARTS];
    pdi_par_timing timing;
    if (mg->levels == 0) return; /* setup failed or was never called */
    int nt = pdi_par_begin_timing(ctx, (int64_t)mg->level[0].cells * PDI_SMOOTHER_WORK, PDI_MULTIGRID_CYCLE_LOOPS,
                                  (uint64_t)(uintptr_t)mg, &timing);
    PDI_PARALLEL_TEAM_CALL(nt, pdi_multigrid_cycle_thread(team, mg, part, rhs, x));
    pdi_par_end_timing(ctx, &timing);
}

#undef PDI_MULTIGRID_MAX_MASS
#undef PDI_MULTIGRID_MIN_WORK
#undef PDI_MULTIGRID_CYCLE_LOOPS
