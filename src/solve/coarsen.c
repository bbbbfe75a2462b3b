/* coarsen: see coarsen.h */
#include "solve/coarsen.h"
#include "core/array_registry.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* [-] An axis is halved when its mean coefficient is at least this fraction of that of the strongest axis. */
#define PDI_COARSEN_STRONG_COUPLING 0.25
/* [-] Least diagonal of an isolated coarse cell, as a fraction of the diagonals of its cells: a smaller mass of a
 * closed region is below single precision rounding. The Krylov solver corrects the error. */
#define PDI_COARSEN_MIN_DIAGONAL 1e-6f
/* [-] The same with contrast, where coarse corrections are in double precision. */
#define PDI_COARSEN_MIN_DIAGONAL_CONTRAST 1e-10f
/* With flow: a cell is excluded from coarser levels when its conductances are less than HELD of its diagonal, and PAIRS
 * pairs of sweeps leave less than LEFT of a uniform error there. */
#define PDI_COARSEN_WEAK_COUPLING 0.05f
#define PDI_COARSEN_RELAX_PAIRS 4
#define PDI_COARSEN_RELAX_LEFT 0.3f
/* Coarse rows of up to this many entries are searched linearly; longer ones use the array of marks, on one thread. */
#define PDI_COARSEN_SHORT_ROW 64
/* Spare capacity of links of a level: later setups merge other cells, and time steps allocate nothing. */
#define PDI_COARSEN_SPARE_LINKS 64
/* Values of parent during the setup: excluded cell; root of a set of merged cells. */
#define PDI_COARSEN_EXCLUDED (-1)
#define PDI_COARSEN_ROOT (-2)

/* ---- memory ---- */

/* List function: the arrays of a coarse level that go by its cells. */
static void pdi_coarsen_list(pdi_array_visitor *owner, void *object)
{
    pd_smoother_level *level = (pd_smoother_level *)object;
    int64_t cells = level->cell_capacity;
    PDI_ARRAY(owner, level, values, (int64_t)(1 + pdi_coarsen_floats_per_cell(level->contrast)) * cells, "1");
    if (level->contrast) PDI_ARRAY(owner, level, coarse_correction, cells, "1");
    PDI_ARRAY(owner, level, indices, 4 * cells + 2, "1");
    PDI_ARRAY_GROWING(owner, level, child, level->child_capacity, "1");
    PDI_ARRAY_GROWING(owner, level, line, level->line_capacity, "1");
}

/* List function: the arrays of a coarse level that go by its links. */
static void pdi_coarsen_link_list(pdi_array_visitor *owner, void *object)
{
    pd_smoother_level *level = (pd_smoother_level *)object;
    int64_t links = level->link_capacity;
    PDI_ARRAY(owner, level, a, level->symmetric ? links : 2 * links, "1");
    PDI_ARRAY(owner, level, col, links, "1");
    PDI_ARRAY(owner, level, face, links, "1");
}

PDI_FN void pdi_coarsen_free(pd_ctx *ctx, pd_smoother_level *level)
{
    pdi_array_registry_free(ctx, pdi_coarsen_list, level);
    pdi_array_registry_free(ctx, pdi_coarsen_link_list, level);
    level->cell_capacity = level->link_capacity = level->child_capacity = level->line_capacity = 0;
}

/* Ensure the capacity `count` of an array; where it grows the content is lost. On failure the array is NULL and the
 * capacity 0. */
static pd_status pdi_coarsen_reserve_array(pd_ctx *ctx, int32_t **list, int32_t *capacity, int32_t count)
{
    if (count <= *capacity) return PD_OK;
    PD_DELETE(ctx, *capacity, *list);
    *capacity = 0;
    PD_TRY(PD_NEW(ctx, "multigrid", count, *list));
    *capacity = count;
    return PD_OK;
}

/* Ensure the capacity of a coarse level for `cells` cells, and set contrast and the pointers into its storage. Nothing
 * where both suffice. Where it grows, or contrast differs, all arrays of the level are freed first, those of its links
 * too, and on failure none is left. */
static pd_status pdi_coarsen_reserve_cells(pd_ctx *ctx, int contrast, pd_smoother_level *level, int32_t cells)
{
    if (cells <= level->cell_capacity && level->values && level->contrast == contrast) return PD_OK;
    size_t room = (size_t)cells;
    pdi_coarsen_free(ctx, level);
    level->contrast = contrast;
    PD_TRY(pdi_array_registry_rebuild(ctx, pdi_coarsen_list, level, &level->cell_capacity, cells));
    level->x = level->values;
    level->b = level->x + room;
    level->r = level->b + room;
    level->inverse_diagonal = level->r + room;
    level->row_sum = contrast ? level->inverse_diagonal + room : NULL;
    level->parent = level->indices;
    level->block = level->parent + room;
    level->row = level->block + room;
    level->child_first = level->row + room + 1;
    return PD_OK;
}

/* Ensure the capacity of a coarse level for `links` links, and set `symmetric` and `reverse`. Where it grows the
 * content is lost, and some spare links are allocated. */
static pd_status pdi_coarsen_reserve_links(pd_ctx *ctx, int symmetric, pd_smoother_level *level, int32_t links)
{
    int other = level->symmetric != symmetric;
    if (other) pdi_array_registry_free(ctx, pdi_coarsen_link_list, level);
    level->symmetric = symmetric;
    if (other || links > level->link_capacity || !level->a)
        PD_TRY(pdi_array_registry_rebuild(ctx, pdi_coarsen_link_list, level, &level->link_capacity,
                                          links + PDI_COARSEN_SPARE_LINKS));
    level->reverse = symmetric ? level->a : level->a + level->link_capacity;
    return PD_OK;
}

/* ---- links ---- */

/* 1: cell c of level 0 is inactive, by its zero diagonal; known for symmetric storage only. */
static int pdi_coarsen_is_inactive(const pd_smoother_level *level, int32_t c)
{
    return level->symmetric_storage && !(level->inverse_diagonal[c] > 0.0f);
}

/* Indices i [PD_DIM] of the block of cell c. */
static void pdi_coarsen_block_indices(const pd_smoother_level *level, int32_t c, int *i)
{
    int32_t rest = level->block ? level->block[c] : c;
    for (int d = 0; d < PD_DIM; d++) {
        i[d] = (int)(rest % level->n[d]);
        rest /= level->n[d];
    }
}

/* ---- cells ---- */

/* [-] Sums and counts of the link coefficients along each axis. */
typedef struct pdi_coarsen_strength {
    double sum[PD_DIM], count[PD_DIM];
} pdi_coarsen_strength;

/* 1: mass or flow dominates the diagonal of cell c, and sweeps alone solve for it: coarser levels would only add cost.
 * So it is where r, as pdi_coarsen_relax_compatibly leaves it, is below PDI_COARSEN_RELAX_LEFT, and the conductances of
 * its links (the smaller coefficient of each) sum to less than PDI_COARSEN_WEAK_COUPLING of the diagonal. */
static int pdi_coarsen_is_excluded(const pd_smoother_level *level, int32_t c)
{
    float shared = 0.0f;
    pdi_coarsen_link link;
    if (level->r[c] >= PDI_COARSEN_RELAX_LEFT) return 0;
    PDI_COARSEN_FOR_LINKS(level, c, k, link) shared += fminf(link.a, link.reverse);
    return shared * level->inverse_diagonal[c] < PDI_COARSEN_WEAK_COUPLING;
}

/* Sum the link coefficients (conductance plus half the flow) of the cells first .. end-1 and their number for each axis
 * into *s, which is zeroed first. Mark in parent the cells that take part in the next level, as PDI_COARSEN_ROOT.
 * Inactive cells, cells without links and, without keep_all, those of pdi_coarsen_is_excluded become
 * PDI_COARSEN_EXCLUDED and are not summed. */
static void pdi_coarsen_sum_strengths(const pdi_coarsen_options *options, const pd_smoother_level *level, int32_t first,
                                      int32_t end, pdi_coarsen_strength *s)
{
    pdi_coarsen_link link;
    for (int d = 0; d < PD_DIM; d++) s->sum[d] = s->count[d] = 0.0;
    for (int32_t c = first; c < end; c++) {
        level->parent[c] = PDI_COARSEN_EXCLUDED;
        if (pdi_coarsen_is_inactive(level, c) || (!options->keep_all && pdi_coarsen_is_excluded(level, c))) continue;
        PDI_COARSEN_FOR_LINKS(level, c, k, link)
        {
            level->parent[c] = PDI_COARSEN_ROOT;
            s->sum[link.axis] +=
                pd_min((double)link.a, (double)link.reverse) + 0.5 * fabs((double)link.a - (double)link.reverse);
            s->count[link.axis] += 1.0;
        }
    }
}

/* PDI_COARSEN_RELAX_PAIRS pairs of line sweeps, as each thread of the team runs them. */
static void pdi_coarsen_relax_thread(pdi_par_team team, const pd_smoother_level *level)
{
    for (int sweep = 0; sweep < 2 * PDI_COARSEN_RELAX_PAIRS; sweep++) {
        pdi_smoother_sweep_lines(team, level, sweep & 1);
        pdi_par_barrier(team);
    }
}

/* With flow: r = what pairs of sweeps leave of a uniform error 1 (compatible relaxation: Brandt 2000). Nearly 0 where
 * the flow comes from a Dirichlet value, or mass dominates; nearly 1 in recirculating flow. Keeps x and b; parent and
 * options->mark hold copies of them and are overwritten. */
static void pdi_coarsen_relax_compatibly(const pd_ctx *ctx, const pdi_coarsen_options *options,
                                         const pd_smoother_level *level)
{
    size_t bytes = (size_t)level->cells * sizeof(float);
    memcpy(level->parent, level->x, bytes); /* arrays that are not in use yet hold copies */
    memcpy(options->mark, level->b, bytes);
    for (int32_t c = 0; c < level->cells; c++) {
        level->x[c] = level->inverse_diagonal[c] > 0.0f ? 1.0f : 0.0f;
        level->b[c] = 0.0f;
    }
    int nt = pd_par_threads(ctx, (int64_t)level->cells * PDI_SMOOTHER_WORK);
    PDI_PARALLEL_TEAM_CALL(nt, pdi_coarsen_relax_thread(team, level));
    memcpy(level->r, level->x, bytes);
    memcpy(level->x, level->parent, bytes);
    memcpy(level->b, options->mark, bytes);
}

PDI_FN int pdi_coarsen_choose_axes(const pd_ctx *ctx, const pdi_coarsen_options *options, pd_smoother_level *level)
{
    pdi_coarsen_strength part[PDI_SMOOTHER_PARTS];
    double sum[PD_DIM], count[PD_DIM], strongest = 0.0;
    int nt = pd_par_threads(ctx, 6 * (int64_t)level->cells);
    (void)nt;
    if (!options->keep_all) pdi_coarsen_relax_compatibly(ctx, options, level);
    PD_PARALLEL_FOR(nt)
    for (int q = 0; q < PDI_SMOOTHER_PARTS; q++)
        pdi_coarsen_sum_strengths(options, level, pdi_smoother_part_begin(level->cells, q),
                                  pdi_smoother_part_begin(level->cells, q + 1), &part[q]);
    for (int d = 0; d < PD_DIM; d++) sum[d] = count[d] = 0.0;
    for (int q = 0; q < PDI_SMOOTHER_PARTS; q++)
        for (int d = 0; d < PD_DIM; d++) {
            sum[d] += part[q].sum[d];
            count[d] += part[q].count[d];
        }
    for (int d = 0; d < PD_DIM; d++)
        if (count[d] > 0.0) strongest = pd_max(strongest, sum[d] / count[d]);
    int any = 0;
    for (int d = 0; d < PD_DIM; d++) {
        level->halve[d] = count[d] > 0.0 && sum[d] / count[d] >= PDI_COARSEN_STRONG_COUPLING * strongest;
        any = any || level->halve[d];
    }
    return any;
}

/* Number of the coarse block of cell c. *key: the sort key of coarse cells: the colour, 0 or 1, for red-black sweeps,
 * else that number. */
static int32_t pdi_coarsen_find_block(const pdi_coarsen_options *options, const pd_smoother_level *level,
                                      const pd_smoother_level *coarse, int32_t c, int32_t *key)
{
    int i[PD_DIM], sum = 0;
    int32_t block = 0;
    pdi_coarsen_block_indices(level, c, i);
    for (int d = PD_DIM - 1; d >= 0; d--) {
        int j = level->halve[d] ? i[d] / 2 : i[d];
        block = block * coarse->n[d] + j;
        sum += j;
    }
    *key = options->symmetric ? sum & 1 : block;
    return block;
}

/* Root of cell c in the union-find structure of parent: values >= 0 are links to it, values <= PDI_COARSEN_ROOT roots.
 * Paths are compressed. */
static int32_t pdi_coarsen_find_root(int32_t *parent, int32_t c)
{
    int32_t root = c;
    while (parent[root] >= 0) root = parent[root];
    while (parent[c] >= 0) {
        int32_t next = parent[c];
        parent[c] = root;
        c = next;
    }
    return root;
}

/* Merge linked cells of each block in the union-find structure of parent, among the cells first .. end-1, which are
 * whole blocks; the smaller index becomes the root. Only links along halved axes between the two halves of a block
 * count, not those across a periodic end. Excluded cells stay. */
static void pdi_coarsen_merge_part(pd_smoother_level *level, int32_t first, int32_t end)
{
    int32_t *parent = level->parent;
    pdi_coarsen_link link;
    for (int32_t c = first; c < end; c++) {
        int i[PD_DIM];
        if (parent[c] == PDI_COARSEN_EXCLUDED) continue;
        pdi_coarsen_block_indices(level, c, i);
        PDI_COARSEN_FOR_LINKS(level, c, k, link)
        {
            /* only links to the other half of the own block, each once */
            if (!link.upper || !level->halve[link.axis] || (i[link.axis] & 1)) continue;
            if (i[link.axis] == level->n[link.axis] - 1) continue; /* across the box */
            if (parent[link.cell] == PDI_COARSEN_EXCLUDED) continue;
            int32_t p = pdi_coarsen_find_root(parent, c), q = pdi_coarsen_find_root(parent, link.cell);
            if (p < q) parent[q] = p;
            if (q < p) parent[p] = q;
        }
    }
}

/* Merge linked cells of each block, as far as they take part. In parallel on level 0 only, where the cells of a layer
 * of blocks are consecutive. */
static void pdi_coarsen_merge_cells(const pd_ctx *ctx, pd_smoother_level *level)
{
    int last = PD_DIM - 1;
    int32_t layer = (level->halve[last] ? 2 : 1) * pdi_smoother_stride(level->n, last);
    int nt = pd_par_threads(ctx, 6 * (int64_t)level->cells);
    (void)nt;
    if (level->row) layer = level->cells;
    PD_PARALLEL_FOR(nt)
    for (int32_t first = 0; first < level->cells; first += layer)
        pdi_coarsen_merge_part(level, first, layer < level->cells - first ? first + layer : level->cells);
}

/* Turn the counts of keys in options->mark into offsets, and set from them coarse->red, the number of cells of the
 * first colour, or (with flow) coarse->line, where the lines begin; the latter may be allocated. */
static pd_status pdi_coarsen_compute_offsets(pd_ctx *ctx, const pdi_coarsen_options *options, pd_smoother_level *coarse,
                                             int32_t keys)
{
    int32_t *offset = options->mark;
    for (int32_t k = 0; k < keys; k++) offset[k + 1] += offset[k];
    coarse->red = options->symmetric ? offset[1] : 0;
    if (options->symmetric) return PD_OK;
    int32_t lines = keys / coarse->n[0];
    /* as many as there can be, whichever axes are halved */
    PD_TRY(pdi_coarsen_reserve_array(ctx, &coarse->line, &coarse->line_capacity, options->fine_lines + 1));
    for (int32_t j = 0; j <= lines; j++) coarse->line[j] = offset[j * coarse->n[0]];
    return PD_OK;
}

/* Set n (halved axes rounded up), periodic and cells of the coarse level, and reserve its memory. Number the merged
 * cells in the order of their keys, and replace parent by these numbers (-1: excluded); coarse->block gets the block of
 * each. Overwrites options->mark. Errors are those of allocation. */
static pd_status pdi_coarsen_number_cells(pd_ctx *ctx, const pdi_coarsen_options *options, pd_smoother_level *level,
                                          pd_smoother_level *coarse)
{
    int32_t *parent = level->parent, *offset = options->mark, keys = options->symmetric ? 2 : 1, cells = 0, key;
    for (int d = 0; d < PD_DIM; d++) {
        coarse->n[d] = level->halve[d] ? (level->n[d] + 1) / 2 : level->n[d];
        coarse->periodic[d] = pdi_coarsen_is_periodic(options->symmetric, coarse->n[d], level->periodic[d]);
        if (!options->symmetric) keys *= coarse->n[d];
    }
    for (int32_t k = 0; k <= keys; k++) offset[k] = 0;
    for (int32_t c = 0; c < level->cells; c++) {
        if (parent[c] >= PDI_COARSEN_EXCLUDED) continue;
        pdi_coarsen_find_block(options, level, coarse, c, &key);
        offset[key + 1]++;
        cells++;
    }
    coarse->cells = cells;
    PD_TRY(pdi_coarsen_reserve_cells(ctx, options->contrast, coarse, cells));
    PD_TRY(pdi_coarsen_compute_offsets(ctx, options, coarse, keys));
    for (int32_t c = 0; c < level->cells; c++)
        if (parent[c] >= 0) parent[c] = pdi_coarsen_find_root(parent, c);
    for (int32_t c = 0; c < level->cells; c++) {
        if (parent[c] >= PDI_COARSEN_EXCLUDED) continue;
        int32_t block = pdi_coarsen_find_block(options, level, coarse, c, &key), p = offset[key]++;
        coarse->block[p] = block;
        parent[c] = -p - 2;
    }
    for (int32_t c = 0; c < level->cells; c++)
        if (parent[c] >= 0) parent[c] = parent[parent[c]];
    for (int32_t c = 0; c < level->cells; c++)
        if (parent[c] != PDI_COARSEN_EXCLUDED) parent[c] = -parent[c] - 2;
    return PD_OK;
}

/* Build the lists child_first and child of the fine cells of each coarse cell, in ascending order; excluded cells are
 * in none. child may be allocated, from level 1 on with room for the cell capacity of `level`. */
static pd_status pdi_coarsen_build_children(pd_ctx *ctx, const pd_smoother_level *level, pd_smoother_level *coarse)
{
    int32_t *first = coarse->child_first;
    for (int32_t p = 0; p <= coarse->cells; p++) first[p] = 0;
    for (int32_t c = 0; c < level->cells; c++)
        if (level->parent[c] >= 0) first[level->parent[c] + 1]++;
    for (int32_t p = 0; p < coarse->cells; p++) first[p + 1] += first[p];
    int32_t children = first[coarse->cells];
    /* a later setup may merge other cells, and time steps allocate nothing: the largest possible number */
    int32_t most = level->block && level->cell_capacity > children ? level->cell_capacity : children;
    PD_TRY(pdi_coarsen_reserve_array(ctx, &coarse->child, &coarse->child_capacity, most));
    for (int32_t c = level->cells - 1; c >= 0; c--) /* each list from its end: first[p + 1] becomes its begin */
        if (level->parent[c] >= 0) coarse->child[--first[level->parent[c] + 1]] = c;
    for (int32_t p = 0; p < coarse->cells; p++) first[p] = first[p + 1];
    first[coarse->cells] = children;
    return PD_OK;
}

/* Widths of the last blocks [unit: width of the other blocks]. A halved axis of n blocks: (1 + last)/2 for even n,
 * last/2 for odd n, where the last block is single; other axes keep theirs. */
static void pdi_coarsen_compute_widths(const pd_smoother_level *level, pd_smoother_level *coarse)
{
    for (int d = 0; d < PD_DIM; d++) {
        float last = level->last_width[d];
        coarse->last_width[d] = !level->halve[d] ? last : level->n[d] % 2 ? 0.5f * last : 0.5f * (1.0f + last);
    }
}

/* Factor of the conductance of a face: ratio of the distances of its cell centres on this level and on the next, which
 * is 1 along an axis that is not halved. i [PD_DIM]: block of the fine cell. */
static float pdi_coarsen_link_factor(const pd_smoother_level *level, const pd_smoother_level *coarse, const int *i,
                                     const pdi_coarsen_link *link)
{
    int d = link->axis, n = level->n[d];
    if (!level->halve[d]) return 1.0f;
    int above = i[d] + link->upper; /* block above the face */
    if (above == 0 || above == n) return (1.0f + level->last_width[d]) / (1.0f + coarse->last_width[d]) * 0.5f;
    float fine = above == n - 1 ? 0.5f * (1.0f + level->last_width[d]) : 1.0f;
    return fine / (above / 2 == coarse->n[d] - 1 ? 1.0f + coarse->last_width[d] : 2.0f);
}

/* Factor of the Dirichlet coefficient of coarse cell p, for the half cell at a wall: 1/2; in a last block, which mostly
 * touches the side of the box, half its fine over its coarse width where that is larger. The normal of the wall is
 * unknown: where an axis of more than one block is not halved the factor is 1, which makes walls normal to a halved
 * axis too stiff: that harms less than walls that are too soft on the other axes. */
static float pdi_coarsen_wall_factor(const pd_smoother_level *level, const pd_smoother_level *coarse, int32_t p)
{
    int i[PD_DIM];
    float factor = 0.5f;
    pdi_coarsen_block_indices(coarse, p, i);
    for (int d = 0; d < PD_DIM; d++) {
        if (!level->halve[d] && level->n[d] > 1) return 1.0f;
        if (level->halve[d] && i[d] == coarse->n[d] - 1)
            factor = fmaxf(factor, 0.5f * level->last_width[d] / coarse->last_width[d]);
    }
    return factor;
}

/* 1: the link crosses the end of an axis that is periodic on this level and no longer on the next. */
static int pdi_coarsen_is_link_dropped(const pd_smoother_level *level, const pd_smoother_level *coarse, const int *i,
                                       const pdi_coarsen_link *link)
{
    int d = link->axis;
    return level->periodic[d] && !coarse->periodic[d] && i[d] == (link->upper ? level->n[d] - 1 : 0);
}

/* Index of column q among the entries start .. end-1 of a row; `end` when it is new. mark: last index of each column;
 * NULL: linear search. */
static inline int32_t pdi_coarsen_find_entry(const int32_t *mark, const int32_t *entry, int32_t start, int32_t end,
                                             int32_t q)
{
    if (mark) return mark[q] < start || mark[q] >= end ? end : mark[q];
    int32_t at = start;
    while (at < end && entry[at - start] != q) at++;
    return at;
}

/* Assemble row p of the coarse links from its fine cells: conductances are summed, reduced by the growth of the
 * distance of centres; flows are summed and upwinded again. Links within p and dropped ones are left out. Coefficients
 * of excluded neighbours are summed in r (in their rows) and x (in this row) until the diagonal is computed. fill 0:
 * only count. mark NULL: at most PDI_COARSEN_SHORT_ROW entries. Returns the end of the row; start - 1 when there are
 * more. */
static int32_t pdi_coarsen_assemble_row(const pd_smoother_level *level, pd_smoother_level *coarse, int32_t p,
                                        int32_t start, int fill, int32_t *mark)
{
    int32_t seen[PDI_COARSEN_SHORT_ROW], *entry = fill ? coarse->col + start : seen, end = start;
    int flows = fill && !coarse->symmetric;
    pdi_coarsen_link link;
    for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) {
        int32_t c = coarse->child[j];
        int i[PD_DIM];
        pdi_coarsen_block_indices(level, c, i);
        PDI_COARSEN_FOR_LINKS(level, c, k, link)
        {
            int32_t q = level->parent[link.cell];
            if (q == p || pdi_coarsen_is_link_dropped(level, coarse, i, &link)) continue;
            if (q < 0) {
                coarse->r[p] += fill ? link.reverse : 0.0f;
                coarse->x[p] += fill ? link.a : 0.0f;
                continue;
            }
            int32_t at = pdi_coarsen_find_entry(mark, entry, start, end, q);
            if (at == end) {
                if (!mark && end - start == PDI_COARSEN_SHORT_ROW) return start - 1;
                if (mark) mark[q] = at;
                else entry[at - start] = q;
                end++;
                if (fill) {
                    coarse->col[at] = q;
                    coarse->face[at] = (uint8_t)(2 * link.axis + link.upper);
                    coarse->a[at] = coarse->reverse[at] = 0.0f;
                }
            }
            if (!fill) continue;
            /* the smaller coefficient is the conductance, the difference the flow out of p */
            coarse->a[at] += fminf(link.a, link.reverse) * pdi_coarsen_link_factor(level, coarse, i, &link);
            if (flows) coarse->reverse[at] += link.reverse - link.a;
        }
    }
    for (int32_t k = start; flows && k < end; k++) {
        float g = coarse->a[k], f = coarse->reverse[k];
        coarse->a[k] = g + (f < 0.0f ? -f : 0.0f);
        coarse->reverse[k] = g + (f > 0.0f ? f : 0.0f);
    }
    return end;
}

/* Assemble the rows of at most PDI_COARSEN_SHORT_ROW entries, from row[p] on; fill 0: only count their entries into
 * row[p + 1], -1: more. The part of one thread. */
static void pdi_coarsen_assemble_rows(const pd_smoother_level *level, pd_smoother_level *coarse, int fill)
{
    PDI_FOR_NOWAIT
    for (int32_t p = 0; p < coarse->cells; p++) {
        if (!fill) coarse->row[p + 1] = pdi_coarsen_assemble_row(level, coarse, p, 0, 0, NULL);
        else if (coarse->row[p + 1] - coarse->row[p] <= PDI_COARSEN_SHORT_ROW)
            pdi_coarsen_assemble_row(level, coarse, p, coarse->row[p], 1, NULL);
    }
}

/* Assemble the coarse links: count them into coarse->row, allocate, fill. Overwrites options->mark; r and x get the
 * sums of the excluded neighbours. */
static pd_status pdi_coarsen_assemble_links(pd_ctx *ctx, const pdi_coarsen_options *options,
                                            const pd_smoother_level *level, pd_smoother_level *coarse)
{
    int32_t *row = coarse->row, *mark = options->mark;
    int nt = pd_par_threads(ctx, 6 * (int64_t)level->cells);
    for (int32_t p = 0; p < coarse->cells; p++) {
        mark[p] = -1;
        coarse->r[p] = coarse->x[p] = 0.0f;
    }
    PDI_PARALLEL_CALL(nt, pdi_coarsen_assemble_rows(level, coarse, 0));
    row[0] = 0;
    for (int32_t p = 0; p < coarse->cells; p++)
        row[p + 1] = row[p + 1] < 0 ? pdi_coarsen_assemble_row(level, coarse, p, row[p], 0, mark) : row[p] + row[p + 1];
    PD_TRY(pdi_coarsen_reserve_links(ctx, options->symmetric, coarse, row[coarse->cells]));
    PDI_PARALLEL_CALL(nt, pdi_coarsen_assemble_rows(level, coarse, 1));
    for (int32_t p = 0; p < coarse->cells; p++) mark[p] = -1;
    for (int32_t p = 0; p < coarse->cells; p++)
        if (row[p + 1] - row[p] > PDI_COARSEN_SHORT_ROW) pdi_coarsen_assemble_row(level, coarse, p, row[p], 1, mark);
    return PD_OK;
}

PDI_FN void pdi_coarsen_compute_diagonals(const pdi_coarsen_options *options, const pd_smoother_level *level,
                                          pd_smoother_level *coarse)
{
    float least = coarse->coarse_correction ? PDI_COARSEN_MIN_DIAGONAL_CONTRAST : PDI_COARSEN_MIN_DIAGONAL;
    for (int32_t p = 0; p < coarse->cells; p++) {
        /* excluded cells keep their values: they act as Dirichlet neighbours */
        float mass = options->symmetric ? 0.0f : coarse->r[p], wall = 0.0f, links = 0.0f, stiff = 0.0f;
        double free = options->symmetric ? 0.0 : (double)coarse->x[p]; /* excess without the part of walls */
        for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) {
            int32_t c = coarse->child[j];
            mass += level->b[c];
            wall += level->x[c];
            free += level->row_sum ? (double)level->row_sum[c] - (double)level->x[c] : 0.0;
            if (level->inverse_diagonal[c] > 0.0f) stiff += 1.0f / level->inverse_diagonal[c];
        }
        wall *= pdi_coarsen_wall_factor(level, coarse, p);
        for (int32_t k = coarse->row[p]; k < coarse->row[p + 1]; k++) links += coarse->reverse[k];
        float diag = mass + wall + links;
        if (links == 0.0f && diag > 0.0f) diag = fmaxf(diag, least * stiff);
        coarse->inverse_diagonal[p] = diag > 0.0f ? 1.0f / diag : 0.0f;
        if (coarse->row_sum) coarse->row_sum[p] = (float)(free + (double)wall);
        coarse->r[p] = 0.0f;
        coarse->b[p] = mass;
        coarse->x[p] = wall;
    }
}

PDI_FN pd_status pdi_coarsen_build_level(pd_ctx *ctx, const pdi_coarsen_options *options, pd_smoother_level *level,
                                         pd_smoother_level *coarse)
{
    pdi_coarsen_merge_cells(ctx, level);
    PD_TRY(pdi_coarsen_number_cells(ctx, options, level, coarse));
    PD_TRY(pdi_coarsen_build_children(ctx, level, coarse));
    pdi_coarsen_compute_widths(level, coarse);
    PD_TRY(pdi_coarsen_assemble_links(ctx, options, level, coarse));
    pdi_coarsen_compute_diagonals(options, level, coarse);
    return PD_OK;
}
