/* multigrid: see multigrid.h
 *
 * V(2,2) cycle with piecewise constant transfers (restriction sums, interpolation copies). Galerkin coarse operators
 * would be twice too stiff along a halved axis for these transfers, so conductances are rediscretised; this beats
 * linear interpolation at equal cost. Two smoothers:
 *   symmetric: red-black Gauss-Seidel, red first from zero; the sweeps after the coarse correction run backwards, which
 *     keeps the cycle symmetric. After a black half sweep the residual lives on red cells, and interpolation to black
 *     cells would be overwritten, so both are done for red cells only.
 *   with flow: from x = b / diag (a third fewer iterations than from zero) each line along axis 0 is swept forth and
 *     back, lines ascending before the coarse correction and descending after it: upwind information crosses the box
 *     in any direction within one cycle, where red-black sweeps carry it a few cells (rotating flow, cell Peclet 1000,
 *     128^2 cells: 19 instead of 80 GMRES iterations).
 */
#include "multigrid.h"
#include "par.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* An axis is halved when its typical coefficient is at least this share of the strongest. */
#define PDI_MULTIGRID_STRONG 0.25
/* A pocket whose mass is below this share of its links' coefficients drowns in single precision rounding: its mean is
 * then solved with this share, and the Krylov solver does the rest. */
#define PDI_MULTIGRID_FLOOR 1e-6f
/* The same with contrast. */
#define PDI_MULTIGRID_FLOOR_CONTRAST 1e-10f
#define PDI_MULTIGRID_NONE (-1)

/* ---- memory ---- */

/* Floats of a cell beside x and the coefficients of level 0: b, r, inv, excess. */
static size_t pdi_multigrid_values(const pd_multigrid *mg) { return mg->desc.contrast ? 4 : 3; }

/* Floats of level 0: x and the coefficients with their pads, b, r, inv, excess. */
static size_t pdi_multigrid_store(const pd_multigrid *mg)
{
    size_t padded = 1 + (mg->desc.symmetric ? PD_DIM : 2 * PD_DIM), cells = (size_t)mg->level[0].cells;
    return padded * (cells + 2 * (size_t)mg->pad) + pdi_multigrid_values(mg) * cells;
}

/* Doubles of level 0: sum with its pads. */
static size_t pdi_multigrid_sums(const pd_multigrid *mg)
{
    return mg->desc.contrast ? (size_t)mg->level[0].cells + 2 * (size_t)mg->pad : 0;
}

/* 1: the ends of an axis of n blocks are linked, when its ends on the level above are. Red-black sweeps need an even
 * number, else both ends have one colour. */
static int pdi_multigrid_wraps(const pd_multigrid *mg, int n, int above)
{
    return above && n > 2 && !(mg->desc.symmetric && n % 2);
}

static void pdi_multigrid_edges(pd_smooth_level *fine)
{
    for (int d = 0; d < PD_DIM; d++) {
        int32_t stride = pdi_smooth_stride(fine->n, d);
        for (int32_t c = 0; fine->wrap[d] && c < fine->cells; c++)
            if (c / stride % fine->n[d] % (fine->n[d] - 1) == 0) fine->edge[c] = 1;
    }
}

pd_status pd_multigrid_build(pd_ctx *ctx, const pd_multigrid_desc *desc, pd_multigrid *mg)
{
    memset(mg, 0, sizeof *mg);
    mg->desc = *desc;
    pd_smooth_level *fine = &mg->level[0];
    int64_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) {
        if (desc->n[d] < 1 || desc->stride[d] < 1 || desc->first < 0)
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "axis %d: n = %d, stride = %d, first = %d", d,
                            desc->n[d], (int)desc->stride[d], (int)desc->first);
        cells *= desc->n[d];
        if (cells > INT32_MAX / (2 * PD_DIM))
            return pdi_fail(ctx, PD_ERR_SIZE, "multigrid", "the box has more than %d cells", INT32_MAX / (2 * PD_DIM));
        fine->n[d] = desc->n[d];
        fine->last[d] = 1.0f;
    }
    fine->cells = (int32_t)cells;
    fine->shared = desc->symmetric;
    for (int d = 0; d < PD_DIM; d++) {
        fine->wrap[d] = pdi_multigrid_wraps(mg, fine->n[d], desc->periodic[d]);
        if (fine->wrap[d] && !fine->edge) PDI_TRY(PDI_NEW(ctx, "multigrid", cells, fine->edge));
    }
    mg->pad = pdi_smooth_stride(fine->n, PD_DIM - 1);
    PDI_TRY(PDI_NEW(ctx, "multigrid", pdi_multigrid_store(mg), mg->store));
    float *next = mg->store + mg->pad;
    int64_t length = cells + 2 * (int64_t)mg->pad;
    fine->x = next;
    for (int d = 0; d < PD_DIM; d++) fine->hi[d] = next += length;
    for (int d = 0; d < PD_DIM; d++)
        fine->lo[d] = desc->symmetric ? fine->hi[d] - pdi_smooth_stride(fine->n, d) : (next += length);
    fine->b = next + cells + mg->pad;
    fine->r = fine->b + cells;
    fine->inv = fine->r + cells;
    if (desc->contrast) {
        PDI_TRY(PDI_NEW(ctx, "multigrid", pdi_multigrid_sums(mg), mg->sums));
        fine->excess = fine->inv + cells;
        fine->sum = mg->sums + mg->pad;
    }
    pdi_multigrid_edges(fine);
    PDI_TRY(PDI_NEW(ctx, "multigrid", 2 * (cells / fine->n[0]), fine->begin));
    fine->end = fine->begin + cells / fine->n[0];
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells + 3, mg->mark));
    return PDI_NEW(ctx, "multigrid", cells, fine->parent);
}

static void pdi_multigrid_level_free(pd_ctx *ctx, const pd_multigrid *mg, pd_smooth_level *level)
{
    size_t cells = (size_t)level->cell_capacity, links = (size_t)level->link_capacity;
    PDI_DELETE(ctx, (1 + pdi_multigrid_values(mg)) * cells, level->values);
    PDI_DELETE(ctx, cells, level->sum);
    PDI_DELETE(ctx, 4 * cells + 2, level->indices);
    PDI_DELETE(ctx, 2 * links, level->a);
    PDI_DELETE(ctx, links, level->col);
    PDI_DELETE(ctx, links, level->face);
    PDI_DELETE(ctx, level->child_capacity, level->child);
    PDI_DELETE(ctx, level->line_capacity, level->line);
    level->cell_capacity = level->link_capacity = level->child_capacity = level->line_capacity = 0;
}

void pd_multigrid_free(pd_ctx *ctx, pd_multigrid *mg)
{
    PDI_DELETE(ctx, pdi_multigrid_store(mg), mg->store);
    PDI_DELETE(ctx, pdi_multigrid_sums(mg), mg->sums);
    PDI_DELETE(ctx, mg->level[0].cells + 3, mg->mark);
    PDI_DELETE(ctx, mg->level[0].cells, mg->level[0].parent);
    PDI_DELETE(ctx, mg->level[0].cells, mg->level[0].edge);
    if (mg->level[0].begin) PDI_DELETE(ctx, 2 * (mg->level[0].cells / mg->level[0].n[0]), mg->level[0].begin);
    for (int l = 1; l < PD_MULTIGRID_LEVELS; l++) pdi_multigrid_level_free(ctx, mg, &mg->level[l]);
    mg->levels = 0;
}

/* Room for `count` entries of a list; old content is of no value, so release before taking. */
static pd_status pdi_multigrid_reserve_list(pd_ctx *ctx, int32_t **list, int32_t *capacity, int32_t count)
{
    if (count <= *capacity) return PD_OK;
    PDI_DELETE(ctx, *capacity, *list);
    *capacity = 0;
    PDI_TRY(PDI_NEW(ctx, "multigrid", count, *list));
    *capacity = count;
    return PD_OK;
}

static pd_status pdi_multigrid_reserve_cells(pd_ctx *ctx, const pd_multigrid *mg, pd_smooth_level *level,
                                             int32_t cells)
{
    int whole = level->values && level->indices && (level->sum || !mg->desc.contrast);
    if (cells <= level->cell_capacity && whole) return PD_OK;
    size_t room = (size_t)cells;
    pdi_multigrid_level_free(ctx, mg, level);
    level->cell_capacity = cells;
    PDI_TRY(PDI_NEW(ctx, "multigrid", (1 + pdi_multigrid_values(mg)) * room, level->values));
    if (mg->desc.contrast) PDI_TRY(PDI_NEW(ctx, "multigrid", room, level->sum));
    PDI_TRY(PDI_NEW(ctx, "multigrid", 4 * room + 2, level->indices));
    level->x = level->values;
    level->b = level->x + room;
    level->r = level->b + room;
    level->inv = level->r + room;
    level->excess = mg->desc.contrast ? level->inv + room : NULL;
    level->parent = level->indices;
    level->block = level->parent + room;
    level->row = level->block + room;
    level->child_first = level->row + room + 1;
    return PD_OK;
}

static pd_status pdi_multigrid_reserve_links(pd_ctx *ctx, pd_smooth_level *level, int32_t links)
{
    if (links <= level->link_capacity && level->a && level->col && level->face) return PD_OK;
    size_t old = (size_t)level->link_capacity, room = (size_t)links;
    PDI_DELETE(ctx, 2 * old, level->a);
    PDI_DELETE(ctx, old, level->col);
    PDI_DELETE(ctx, old, level->face);
    level->link_capacity = links;
    PDI_TRY(PDI_NEW(ctx, "multigrid", 2 * room, level->a));
    PDI_TRY(PDI_NEW(ctx, "multigrid", room, level->col));
    PDI_TRY(PDI_NEW(ctx, "multigrid", room, level->face));
    level->back = level->a + room;
    return PD_OK;
}

/* ---- links, the same view of all levels; only setup uses it ---- */

typedef struct pdi_multigrid_link {
    int32_t cell;  /* the neighbour */
    float a, back; /* coefficient of the neighbour here, of this cell there */
    int axis, upper;
} pdi_multigrid_link;

/* Link k of cell c; 0: closed. */
static int pdi_multigrid_link_get(const pd_smooth_level *level, int32_t c, int32_t k, pdi_multigrid_link *link)
{
    if (level->row) {
        link->cell = level->col[k];
        link->a = level->a[k];
        link->back = level->back[k];
        link->axis = level->face[k] >> 1;
        link->upper = level->face[k] & 1;
        return 1;
    }
    link->axis = k >> 1;
    link->upper = k & 1;
    int32_t stride = pdi_smooth_stride(level->n, link->axis);
    if (level->edge && level->edge[c]) {
        link->cell = pdi_smooth_across(level, stride, link->axis, link->upper, c);
        if (link->cell < 0) return 0;
        link->a = pdi_smooth_edge_coefficient(level, link->axis, link->upper, c, link->cell);
        link->back = pdi_smooth_edge_coefficient(level, link->axis, !link->upper, link->cell, c);
        return link->a + link->back > 0.0f;
    }
    link->cell = link->upper ? c + stride : c - stride;
    link->a = link->upper ? level->hi[link->axis][c] : level->lo[link->axis][c];
    link->back = link->upper ? level->lo[link->axis][c + stride] : level->hi[link->axis][c - stride];
    return link->a + link->back > 0.0f;
}

/* Loop over the open links of cell c. */
#define PDI_MULTIGRID_LINKS(level, c, k, link) \
    for (int32_t k = (level)->row ? (level)->row[c] : 0; k < ((level)->row ? (level)->row[(c) + 1] : 2 * PD_DIM); k++) \
        if (pdi_multigrid_link_get((level), (c), k, &(link)))

/* 1: cell c of level 0 has no link for certain. Only a diagonal of symmetric levels tells. */
static int pdi_multigrid_alone(const pd_smooth_level *level, int32_t c)
{
    return level->shared && !(level->inv[c] > 0.0f);
}

static void pdi_multigrid_block_index(const pd_smooth_level *level, int32_t c, int *i)
{
    int32_t rest = level->block ? level->block[c] : c;
    for (int d = 0; d < PD_DIM; d++) {
        i[d] = (int)(rest % level->n[d]);
        rest /= level->n[d];
    }
}

/* ---- setup: the finest level ---- */

static pd_status pdi_multigrid_check(pd_ctx *ctx, const pd_multigrid *mg, const float *field, int sign_free,
                                     const char *name, float *largest)
{
    if (!field) return PD_OK;
    for (int32_t c = 0; c < mg->level[0].cells; c++) {
        float size = fabsf(field[c]);
        if (!(size <= FLT_MAX) || (!sign_free && field[c] < 0.0f))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "%s is %g at cell %d, needs to be finite%s", name,
                            (double)field[c], (int)c, sign_free ? "" : " and >= 0");
        if (size > *largest) *largest = size;
    }
    return PD_OK;
}

/* Power of two that brings `largest` near 1; 1 for zero, NaN and infinity. */
static double pdi_multigrid_scale(double largest)
{
    int exponent = 0;
    if (largest > 0.0 && largest <= DBL_MAX) frexp(largest, &exponent);
    return ldexp(1.0, -exponent);
}

/* Coefficients of the faces of axis d. */
static void pdi_multigrid_fine_faces(pd_multigrid *mg, int d, const uint8_t *active, const float *conduct,
                                     const float *flux)
{
    pd_smooth_level *fine = &mg->level[0];
    int32_t stride = pdi_smooth_stride(fine->n, d), n = fine->n[d];
    double scale = mg->scale; /* may exceed the range of float */
    float *hi = fine->hi[d], *lo = fine->lo[d];
    for (int32_t c = 0; c < fine->cells; c++) {
        int inside = c / stride % n < n - 1;
        int32_t above = inside ? c + stride : fine->wrap[d] ? c - (n - 1) * stride : -1;
        int open = above >= 0 && active[c] && active[above];
        float g = open ? (float)(scale * (double)conduct[c]) : 0.0f;
        float f = open && flux ? (float)(scale * (double)flux[c]) : 0.0f;
        hi[c] = g + (f < 0.0f ? -f : 0.0f);
        /* with symmetric storage both are the same element, which across the box is found by the neighbour */
        if (inside || (above >= 0 && !fine->shared)) lo[above] = g + (f > 0.0f ? f : 0.0f);
    }
}

/* What leaves cell c of level 0 more than enters it, over the flows of its open faces. Taken from the flows themselves:
 * beside strong conductances the coefficients have lost them. */
static double pdi_multigrid_net(const pd_multigrid *mg, int32_t c, const float *const *flux)
{
    const pd_smooth_level *fine = &mg->level[0];
    pdi_multigrid_link link;
    double net = 0.0;
    PDI_MULTIGRID_LINKS(fine, c, k, link)
    {
        double f = (double)flux[link.axis][link.upper ? c : link.cell];
        net += link.upper ? f : -f;
    }
    return mg->scale * net;
}

/* During setup x holds the wall and b the mass of each cell of a level. */
static void pdi_multigrid_fine(pd_multigrid *mg, const uint8_t *active, const float *const conduct[PD_DIM],
                               const float *const *flux, const float *wall, const float *mass)
{
    pd_smooth_level *fine = &mg->level[0];
    for (int d = 0; d < PD_DIM; d++)
        pdi_multigrid_fine_faces(mg, d, active, conduct[d], flux ? flux[d] : NULL);
    for (int32_t c = 0; c < fine->cells; c++) {
        fine->x[c] = wall && active[c] ? (float)(mg->scale * (double)wall[c]) : 0.0f;
        fine->b[c] = mass && active[c] ? (float)(mg->scale * (double)mass[c]) : 0.0f;
        float diag = fine->x[c] + fine->b[c];
        pdi_multigrid_link link;
        if (active[c])
            PDI_MULTIGRID_LINKS(fine, c, k, link) diag += link.back;
        fine->inv[c] = diag > 0.0f ? 1.0f / diag : 0.0f;
        fine->r[c] = 0.0f;
        double net = flux && fine->excess ? pdi_multigrid_net(mg, c, flux) : 0.0;
        if (fine->excess) fine->excess[c] = (float)((double)fine->x[c] + (double)fine->b[c] + net);
    }
}

/* Begin and end of the rows of level 0. */
static void pdi_multigrid_rows(pd_smooth_level *fine)
{
    int32_t n = fine->n[0];
    for (int32_t r = 0; r < fine->cells / n; r++) {
        int32_t begin = r * n, end = begin + n;
        while (begin < end && !(fine->inv[begin] > 0.0f)) begin++;
        while (begin < end && !(fine->inv[end - 1] > 0.0f)) end--;
        fine->begin[r] = begin;
        fine->end[r] = end;
    }
}

/* ---- setup: coarsening ---- */

/* Choose the axes to halve; 0: no cell has a link any more. */
static int pdi_multigrid_choose(pd_smooth_level *level)
{
    double sum[PD_DIM], count[PD_DIM], strongest = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum[d] = count[d] = 0.0;
    pdi_multigrid_link link;
    for (int32_t c = 0; c < level->cells; c++) {
        if (pdi_multigrid_alone(level, c)) continue;
        PDI_MULTIGRID_LINKS(level, c, k, link)
        {
            sum[link.axis] += fmin((double)link.a, (double)link.back) +
                              0.5 * fabs((double)link.a - (double)link.back);
            count[link.axis] += 1.0;
        }
    }
    for (int d = 0; d < PD_DIM; d++)
        if (count[d] > 0.0) strongest = fmax(strongest, sum[d] / count[d]);
    int any = 0;
    for (int d = 0; d < PD_DIM; d++) {
        level->halve[d] = count[d] > 0.0 && sum[d] / count[d] >= PDI_MULTIGRID_STRONG * strongest;
        any = any || level->halve[d];
    }
    return any;
}

/* Coarse block of a cell. key: what coarse cells are sorted by, the colour for red-black sweeps, else the block. */
static int32_t pdi_multigrid_coarse_block(const pd_multigrid *mg, const pd_smooth_level *level,
                                          const pd_smooth_level *coarse, int32_t c, int32_t *key)
{
    int i[PD_DIM], sum = 0;
    int32_t block = 0;
    pdi_multigrid_block_index(level, c, i);
    for (int d = PD_DIM - 1; d >= 0; d--) {
        int j = level->halve[d] ? i[d] / 2 : i[d];
        block = block * coarse->n[d] + j;
        sum += j;
    }
    *key = mg->desc.symmetric ? sum & 1 : block;
    return block;
}

/* Union-find in parent: values >= 0 point on, values < -1 are roots. */
static int32_t pdi_multigrid_root(int32_t *parent, int32_t c)
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

/* Join linked cells of one block. A cell without links is solved by its diagonal and needs no parent. */
static void pdi_multigrid_join(pd_smooth_level *level)
{
    int32_t *parent = level->parent;
    pdi_multigrid_link link;
    for (int32_t c = 0; c < level->cells; c++) {
        parent[c] = PDI_MULTIGRID_NONE;
        if (pdi_multigrid_alone(level, c)) continue;
        PDI_MULTIGRID_LINKS(level, c, k, link) parent[c] = -2;
    }
    for (int32_t c = 0; c < level->cells; c++) {
        int i[PD_DIM];
        if (parent[c] == PDI_MULTIGRID_NONE) continue;
        pdi_multigrid_block_index(level, c, i);
        PDI_MULTIGRID_LINKS(level, c, k, link)
        {
            /* only links to the other half of the own block, each once */
            if (!link.upper || !level->halve[link.axis] || (i[link.axis] & 1)) continue;
            if (i[link.axis] == level->n[link.axis] - 1) continue; /* across the box */
            int32_t p = pdi_multigrid_root(parent, c), q = pdi_multigrid_root(parent, link.cell);
            if (p < q) parent[q] = p;
            if (q < p) parent[p] = q;
        }
    }
}

/* Where the colours or the lines begin, from the key counts; turns counts into offsets. */
static pd_status pdi_multigrid_order(pd_ctx *ctx, pd_multigrid *mg, pd_smooth_level *coarse, int32_t keys)
{
    int32_t *offset = mg->mark;
    for (int32_t k = 0; k < keys; k++) offset[k + 1] += offset[k];
    coarse->red = mg->desc.symmetric ? offset[1] : 0;
    if (mg->desc.symmetric) return PD_OK;
    int32_t lines = keys / coarse->n[0];
    PDI_TRY(pdi_multigrid_reserve_list(ctx, &coarse->line, &coarse->line_capacity, lines + 1));
    for (int32_t j = 0; j <= lines; j++) coarse->line[j] = offset[j * coarse->n[0]];
    return PD_OK;
}

/* Number the joined cells and turn parent into those numbers. */
static pd_status pdi_multigrid_number(pd_ctx *ctx, pd_multigrid *mg, pd_smooth_level *level,
                                      pd_smooth_level *coarse)
{
    int32_t *parent = level->parent, *offset = mg->mark, keys = mg->desc.symmetric ? 2 : 1, cells = 0, key;
    for (int d = 0; d < PD_DIM; d++) {
        coarse->n[d] = level->halve[d] ? (level->n[d] + 1) / 2 : level->n[d];
        coarse->wrap[d] = pdi_multigrid_wraps(mg, coarse->n[d], level->wrap[d]);
        if (!mg->desc.symmetric) keys *= coarse->n[d];
    }
    for (int32_t k = 0; k <= keys; k++) offset[k] = 0;
    for (int32_t c = 0; c < level->cells; c++) {
        if (parent[c] >= PDI_MULTIGRID_NONE) continue;
        pdi_multigrid_coarse_block(mg, level, coarse, c, &key);
        offset[key + 1]++;
        cells++;
    }
    coarse->cells = cells;
    PDI_TRY(pdi_multigrid_reserve_cells(ctx, mg, coarse, cells));
    PDI_TRY(pdi_multigrid_order(ctx, mg, coarse, keys));
    for (int32_t c = 0; c < level->cells; c++)
        if (parent[c] >= 0) parent[c] = pdi_multigrid_root(parent, c);
    for (int32_t c = 0; c < level->cells; c++) {
        if (parent[c] >= PDI_MULTIGRID_NONE) continue;
        int32_t block = pdi_multigrid_coarse_block(mg, level, coarse, c, &key), p = offset[key]++;
        coarse->block[p] = block;
        parent[c] = -p - 2;
    }
    for (int32_t c = 0; c < level->cells; c++)
        if (parent[c] >= 0) parent[c] = parent[parent[c]];
    for (int32_t c = 0; c < level->cells; c++)
        if (parent[c] != PDI_MULTIGRID_NONE) parent[c] = -parent[c] - 2;
    return PD_OK;
}

static pd_status pdi_multigrid_children(pd_ctx *ctx, const pd_smooth_level *level, pd_smooth_level *coarse)
{
    int32_t *first = coarse->child_first;
    for (int32_t p = 0; p <= coarse->cells; p++) first[p] = 0;
    for (int32_t c = 0; c < level->cells; c++)
        if (level->parent[c] >= 0) first[level->parent[c] + 1]++;
    for (int32_t p = 0; p < coarse->cells; p++) first[p + 1] += first[p];
    int32_t children = first[coarse->cells];
    PDI_TRY(pdi_multigrid_reserve_list(ctx, &coarse->child, &coarse->child_capacity, children));
    for (int32_t c = level->cells - 1; c >= 0; c--) /* each list from its end: first[p + 1] becomes its begin */
        if (level->parent[c] >= 0) coarse->child[--first[level->parent[c] + 1]] = c;
    for (int32_t p = 0; p < coarse->cells; p++) first[p] = first[p + 1];
    first[coarse->cells] = children;
    return PD_OK;
}

/* Widths of the last blocks, which odd sizes leave thinner (unit: width of the others). */
static void pdi_multigrid_widths(const pd_smooth_level *level, pd_smooth_level *coarse)
{
    for (int d = 0; d < PD_DIM; d++) {
        float last = level->last[d];
        coarse->last[d] = !level->halve[d] ? last : level->n[d] % 2 ? 0.5f * last : 0.5f * (1.0f + last);
    }
}

/* Share of the conductance of a face that is left when the distance of its cells grows from this level to the next. */
static float pdi_multigrid_link_factor(const pd_smooth_level *level, const pd_smooth_level *coarse,
                                       const int *i, const pdi_multigrid_link *link)
{
    int d = link->axis, n = level->n[d];
    if (!level->halve[d]) return 1.0f;
    int above = i[d] + link->upper; /* block above the face */
    if (above == 0 || above == n) return (1.0f + level->last[d]) / (1.0f + coarse->last[d]) * 0.5f;
    float fine = above == n - 1 ? 0.5f * (1.0f + level->last[d]) : 1.0f;
    return fine / (above / 2 == coarse->n[d] - 1 ? 1.0f + coarse->last[d] : 2.0f);
}

/* The same for the half cell before a Dirichlet wall. Its normal is unknown; when all axes are halved any will do but
 * for last blocks, which mostly face the side of the box. Otherwise the strong axis is halved alone: its walls then
 * become too stiff, which does less harm than soft walls on the others. */
static float pdi_multigrid_wall_factor(const pd_smooth_level *level, const pd_smooth_level *coarse, int32_t p)
{
    int i[PD_DIM];
    float factor = 0.5f;
    pdi_multigrid_block_index(coarse, p, i);
    for (int d = 0; d < PD_DIM; d++) {
        if (!level->halve[d] && level->n[d] > 1) return 1.0f;
        if (level->halve[d] && i[d] == coarse->n[d] - 1)
            factor = fmaxf(factor, 0.5f * level->last[d] / coarse->last[d]);
    }
    return factor;
}

/* 1: a link across the box that the next level does without. */
static int pdi_multigrid_parted(const pd_smooth_level *level, const pd_smooth_level *coarse, const int *i,
                                const pdi_multigrid_link *link)
{
    int d = link->axis;
    return level->wrap[d] && !coarse->wrap[d] && i[d] == (link->upper ? level->n[d] - 1 : 0);
}

/* Row p of the coarse links, found through the children: conductances of the faces are summed and reduced as the
 * distance of the centres grows; flows are summed and taken upwind anew.
 * fill 0: only count. Returns the end of the row. */
static int32_t pdi_multigrid_coarse_row(pd_multigrid *mg, const pd_smooth_level *level, pd_smooth_level *coarse,
                                        int32_t p, int32_t start, int fill)
{
    int32_t end = start, *mark = mg->mark;
    pdi_multigrid_link link;
    for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) {
        int32_t c = coarse->child[j];
        int i[PD_DIM];
        pdi_multigrid_block_index(level, c, i);
        PDI_MULTIGRID_LINKS(level, c, k, link)
        {
            int32_t q = level->parent[link.cell];
            if (q == p || pdi_multigrid_parted(level, coarse, i, &link)) continue;
            int fresh = mark[q] < start || mark[q] >= end;
            if (fresh) mark[q] = end++;
            if (!fill) continue;
            int32_t at = mark[q];
            if (fresh) {
                coarse->col[at] = q;
                coarse->face[at] = (uint8_t)(2 * link.axis + link.upper);
                coarse->a[at] = coarse->back[at] = 0.0f;
            }
            /* the smaller coefficient is the conductance, the difference the flow out of p */
            coarse->a[at] += fminf(link.a, link.back) * pdi_multigrid_link_factor(level, coarse, i, &link);
            coarse->back[at] += link.back - link.a;
        }
    }
    for (int32_t k = start; fill && k < end; k++) {
        float g = coarse->a[k], f = coarse->back[k];
        coarse->a[k] = g + (f < 0.0f ? -f : 0.0f);
        coarse->back[k] = g + (f > 0.0f ? f : 0.0f);
    }
    return end;
}

static pd_status pdi_multigrid_coarse_links(pd_ctx *ctx, pd_multigrid *mg, const pd_smooth_level *level,
                                            pd_smooth_level *coarse)
{
    for (int32_t p = 0; p < coarse->cells; p++) mg->mark[p] = -1;
    coarse->row[0] = 0;
    for (int32_t p = 0; p < coarse->cells; p++)
        coarse->row[p + 1] = pdi_multigrid_coarse_row(mg, level, coarse, p, coarse->row[p], 0);
    PDI_TRY(pdi_multigrid_reserve_links(ctx, coarse, coarse->row[coarse->cells]));
    for (int32_t p = 0; p < coarse->cells; p++) mg->mark[p] = -1;
    for (int32_t p = 0; p < coarse->cells; p++) pdi_multigrid_coarse_row(mg, level, coarse, p, coarse->row[p], 1);
    return PD_OK;
}

static void pdi_multigrid_coarse_diagonal(const pd_smooth_level *level, pd_smooth_level *coarse)
{
    float least = coarse->sum ? PDI_MULTIGRID_FLOOR_CONTRAST : PDI_MULTIGRID_FLOOR;
    for (int32_t p = 0; p < coarse->cells; p++) {
        float mass = 0.0f, wall = 0.0f, links = 0.0f, stiff = 0.0f;
        double free = 0.0; /* excess that is not of walls */
        for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) {
            int32_t c = coarse->child[j];
            mass += level->b[c];
            wall += level->x[c];
            free += level->excess ? (double)level->excess[c] - (double)level->x[c] : 0.0;
            if (level->inv[c] > 0.0f) stiff += 1.0f / level->inv[c];
        }
        wall *= pdi_multigrid_wall_factor(level, coarse, p);
        for (int32_t k = coarse->row[p]; k < coarse->row[p + 1]; k++) links += coarse->back[k];
        float diag = mass + wall + links;
        if (links == 0.0f && diag > 0.0f) diag = fmaxf(diag, least * stiff);
        coarse->inv[p] = diag > 0.0f ? 1.0f / diag : 0.0f;
        if (coarse->excess) coarse->excess[p] = (float)(free + (double)wall);
        coarse->r[p] = 0.0f;
        coarse->b[p] = mass;
        coarse->x[p] = wall;
    }
}

static pd_status pdi_multigrid_coarsen(pd_ctx *ctx, pd_multigrid *mg)
{
    for (int l = 0; pdi_multigrid_choose(&mg->level[l]); l++) {
        pd_smooth_level *level = &mg->level[l], *coarse = level + 1;
        if (l + 1 == PD_MULTIGRID_LEVELS)
            return pdi_fail(ctx, PD_ERR_INTERNAL, "multigrid", "more than %d levels", PD_MULTIGRID_LEVELS);
        pdi_multigrid_join(level);
        PDI_TRY(pdi_multigrid_number(ctx, mg, level, coarse));
        PDI_TRY(pdi_multigrid_children(ctx, level, coarse));
        pdi_multigrid_widths(level, coarse);
        PDI_TRY(pdi_multigrid_coarse_links(ctx, mg, level, coarse));
        pdi_multigrid_coarse_diagonal(level, coarse);
        mg->levels = l + 2;
    }
    return PD_OK;
}

pd_status pd_multigrid_setup(pd_ctx *ctx, pd_multigrid *mg, const uint8_t *active, const float *const conduct[PD_DIM],
                             const float *const flux[PD_DIM], const float *wall, const float *mass)
{
    float largest = 0.0f;
    mg->levels = 0;
    if (!mg->level[0].parent) return pdi_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "setup before a successful build");
    if (flux && mg->desc.symmetric)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "flux given, but the desc says symmetric");
    for (int d = 0; d < PD_DIM; d++) {
        PDI_TRY(pdi_multigrid_check(ctx, mg, conduct[d], 0, "conduct", &largest));
        if (flux) PDI_TRY(pdi_multigrid_check(ctx, mg, flux[d], 1, "flux", &largest));
    }
    PDI_TRY(pdi_multigrid_check(ctx, mg, wall, 0, "wall", &largest));
    PDI_TRY(pdi_multigrid_check(ctx, mg, mass, 0, "mass", &largest));
    mg->scale = pdi_multigrid_scale((double)largest);
    mg->levels = 1;
    pdi_multigrid_fine(mg, active, conduct, flux, wall, mass);
    pdi_multigrid_rows(&mg->level[0]);
    pd_status status = pdi_multigrid_coarsen(ctx, mg);
    if (status < 0) mg->levels = 0;
    return status;
}

/* ---- cycle: x of a level from its b ---- */

/* b of the next level = sum of r over the children */
static void pdi_multigrid_restrict(const pd_ctx *ctx, const pd_smooth_level *level)
{
    const pd_smooth_level *coarse = level + 1;
    int nt = pdi_par_threads(ctx, (int64_t)level->cells);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < coarse->cells; p++) {
        float sum = 0.0f;
        for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) sum += level->r[coarse->child[j]];
        coarse->b[p] = sum;
    }
}

static void pdi_multigrid_down(const pd_ctx *ctx, const pd_multigrid *mg, const pd_smooth_level *level)
{
    if (mg->desc.symmetric) {
        pdi_smooth_colour(ctx, level, PDI_SMOOTH_START, 0);
        pdi_smooth_colour(ctx, level, PDI_SMOOTH_SWEEP, 1);
        pdi_smooth_colour(ctx, level, PDI_SMOOTH_SWEEP, 0);
        pdi_smooth_colour(ctx, level, PDI_SMOOTH_SWEEP, 1);
        pdi_smooth_colour(ctx, level, PDI_SMOOTH_RESIDUAL, 0); /* r stays 0 on the other colour */
    } else {
        pdi_smooth_range(ctx, level, PDI_SMOOTH_START, 0, level->cells);
        pdi_smooth_lines(ctx, level, 0);
        pdi_smooth_range(ctx, level, PDI_SMOOTH_RESIDUAL, 0, level->cells);
    }
    pdi_multigrid_restrict(ctx, level);
}

/* Add what the coarser levels give to x. With contrast it is kept apart in double precision, and its defect smoothed:
 * in single precision its rounding, as rough as the mesh, would outweigh in a good conductor what is sought. */
static void pdi_multigrid_interpolate(const pd_ctx *ctx, const pd_multigrid *mg, const pd_smooth_level *level)
{
    if (level->sum) {
        pdi_smooth_range(ctx, level, PDI_SMOOTH_INHERIT, 0, level->cells);
        pdi_smooth_range(ctx, level, PDI_SMOOTH_DEFECT, 0, level->cells);
    } else if (mg->desc.symmetric)
        pdi_smooth_colour(ctx, level, PDI_SMOOTH_PROLONG, 0);
    else
        pdi_smooth_range(ctx, level, PDI_SMOOTH_PROLONG, 0, level->cells);
}

static void pdi_multigrid_up(const pd_ctx *ctx, const pd_multigrid *mg, const pd_smooth_level *level)
{
    pdi_multigrid_interpolate(ctx, mg, level);
    for (int sweep = 0; sweep < 2 && mg->desc.symmetric; sweep++) {
        pdi_smooth_colour(ctx, level, PDI_SMOOTH_SWEEP, 1);
        pdi_smooth_colour(ctx, level, PDI_SMOOTH_SWEEP, 0);
    }
    if (!mg->desc.symmetric) pdi_smooth_lines(ctx, level, 1);
    if (level->sum) pdi_smooth_range(ctx, level, PDI_SMOOTH_COLLECT, 0, level->cells);
}

/* First node of row r of the box on the padded lattice. */
static int32_t pdi_multigrid_row_node(const pd_multigrid *mg, int32_t r)
{
    int32_t node = mg->desc.first, rest = r;
    for (int d = 1; d < PD_DIM; d++) {
        node += rest % mg->desc.n[d] * mg->desc.stride[d];
        rest /= mg->desc.n[d];
    }
    return node;
}

/* Factor of the right-hand side in row r of the box. */
static double pdi_multigrid_weight(const pd_multigrid *mg, int32_t r)
{
    const int *n = mg->level[0].n;
    if (PD_DIM == 1 || !mg->desc.weight) return 1.0;
    return mg->desc.weight[PD_DIM == 3 ? r / n[PD_DIM - 2] : r];
}

/* max |rhs| over the cells that take part, by parts of rows. */
static double pdi_multigrid_rhs_size(const pd_ctx *ctx, const pd_multigrid *mg, const double *rhs)
{
    double part[PDI_SMOOTH_PARTS], largest = 0.0;
    const pd_smooth_level *fine = &mg->level[0];
    int64_t rows = fine->cells / fine->n[0];
    int nt = pdi_par_threads(ctx, fine->cells);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int q = 0; q < PDI_SMOOTH_PARTS; q++) {
        part[q] = 0.0;
        for (int32_t r = pdi_smooth_part(rows, q); r < pdi_smooth_part(rows, q + 1); r++) {
            int32_t node = pdi_multigrid_row_node(mg, r), base = r * fine->n[0];
            for (int32_t c = fine->begin[r]; c < fine->end[r]; c++) {
                double size = fine->inv[c] > 0.0f ? fabs(rhs[node + (c - base) * mg->desc.stride[0]]) : 0.0;
                size *= pdi_multigrid_weight(mg, r);
                if (size > part[q]) part[q] = size;
            }
        }
    }
    for (int q = 0; q < PDI_SMOOTH_PARTS; q++) largest = fmax(largest, part[q]);
    return largest;
}

void pd_multigrid_cycle(pd_ctx *ctx, pd_multigrid *mg, const double *rhs, double *x)
{
    const pd_smooth_level *fine = &mg->level[0];
    if (mg->levels == 0) return; /* setup failed or was never called */
    int32_t rows = fine->cells / fine->n[0], n0 = fine->n[0], s0 = mg->desc.stride[0];
    double in = pdi_multigrid_scale(pdi_multigrid_rhs_size(ctx, mg, rhs)), out = mg->scale / in;
    int nt = pdi_par_threads(ctx, fine->cells);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < rows; r++) {
        int32_t node = pdi_multigrid_row_node(mg, r), base = r * n0;
        double factor = in * pdi_multigrid_weight(mg, r);
        for (int32_t c = fine->begin[r]; c < fine->end[r]; c++)
            fine->b[c] = fine->inv[c] > 0.0f ? (float)(factor * rhs[node + (c - base) * s0]) : 0.0f;
    }
    for (int l = 0; l < mg->levels - 1; l++) pdi_multigrid_down(ctx, mg, &mg->level[l]);
    const pd_smooth_level *last = &mg->level[mg->levels - 1]; /* no links are left: the diagonal is the operator */
    pdi_smooth_range(ctx, last, PDI_SMOOTH_START, 0, last->cells);
    for (int32_t c = 0; c < last->cells && last->sum; c++) last->sum[c] = (double)last->x[c];
    for (int l = mg->levels - 2; l >= 0; l--) pdi_multigrid_up(ctx, mg, &mg->level[l]);
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < rows; r++) {
        int32_t node = pdi_multigrid_row_node(mg, r), base = r * n0;
        for (int32_t i = 0; i < n0; i++)
            x[node + i * s0] = out * (fine->sum ? fine->sum[base + i] : (double)fine->x[base + i]);
    }
}
