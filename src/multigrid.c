/* multigrid: see multigrid.h
 *
 * Cycle on a level, from zero: red x = b / diag; black Gauss-Seidel; residual, which now lives on red cells only;
 * restriction, cycle on the coarser level, interpolation to the red cells only because the next half sweep overwrites
 * the black ones; black, then red Gauss-Seidel. Restriction is the transpose of interpolation and the second sweep the
 * adjoint of the first, so the cycle is symmetric for a symmetric operator.
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
#define PDI_MULTIGRID_NONE (-1)

#ifndef KN_LINEAR
#define KN_LINEAR 0.25f
#endif
#ifndef KN_NU
#define KN_NU 1
#endif
#ifndef KN_GAMMA
#define KN_GAMMA 1
#endif
#ifndef KN_WALL
#define KN_WALL 0
#endif
#ifndef KN_OVER
#define KN_OVER 1.0f
#endif
#ifndef KN_FSTR
#define KN_FSTR 0.5
#endif

/* Operations a cell, to decide on threads. */
#define PDI_MULTIGRID_WORK (4 * PD_DIM)

/* ---- memory ---- */

static int32_t pdi_multigrid_stride(const int *n, int d)
{
    int32_t stride = 1;
    for (int e = 0; e < d; e++) stride *= n[e];
    return stride;
}

static size_t pdi_multigrid_store(const pd_multigrid *mg)
{
    size_t arrays = 1 + (mg->desc.symmetric ? PD_DIM : 2 * PD_DIM);
    return arrays * ((size_t)mg->level[0].cells + 2 * (size_t)mg->pad);
}

pd_status pd_multigrid_build(pd_ctx *ctx, const pd_multigrid_desc *desc, pd_multigrid *mg)
{
    memset(mg, 0, sizeof *mg);
    mg->desc = *desc;
    pd_multigrid_level *fine = &mg->level[0];
    int64_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) {
        if (desc->n[d] < 1 || desc->stride[d] < 1 || desc->first < 0)
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "multigrid", "axis %d: n = %d, stride = %d, first = %d", d,
                            desc->n[d], (int)desc->stride[d], (int)desc->first);
        cells *= desc->n[d];
        if (cells > INT32_MAX / (2 * PD_DIM))
            return pdi_fail(ctx, PD_ERR_SIZE, "multigrid", "the box has more than %d cells", INT32_MAX / (2 * PD_DIM));
        fine->n[d] = desc->n[d];
    }
    fine->cells = (int32_t)cells;
    mg->pad = pdi_multigrid_stride(fine->n, PD_DIM - 1);
    PDI_TRY(PDI_NEW(ctx, "multigrid", pdi_multigrid_store(mg), mg->store));
    float *next = mg->store + mg->pad;
    int64_t length = cells + 2 * (int64_t)mg->pad;
    fine->x = next;
    for (int d = 0; d < PD_DIM; d++) fine->hi[d] = next += length;
    for (int d = 0; d < PD_DIM; d++)
        fine->lo[d] = desc->symmetric ? fine->hi[d] - pdi_multigrid_stride(fine->n, d) : (next += length);
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, fine->b));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, fine->r));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, fine->inv));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, fine->side));
    return PDI_NEW(ctx, "multigrid", cells, fine->parent);
}

static void pdi_multigrid_scratch_free(pd_ctx *ctx, pd_multigrid *mg)
{
    PDI_DELETE(ctx, mg->level[0].cells, mg->mass);
    PDI_DELETE(ctx, mg->level[0].cells, mg->wall);
    PDI_DELETE(ctx, mg->level[0].cells, mg->coarse_mass);
    PDI_DELETE(ctx, mg->level[0].cells, mg->coarse_wall);
    PDI_DELETE(ctx, mg->level[0].cells, mg->mark);
}

static void pdi_multigrid_level_free(pd_ctx *ctx, pd_multigrid_level *level)
{
    size_t cells = (size_t)level->cell_capacity, links = (size_t)level->link_capacity;
    PDI_DELETE(ctx, cells, level->x);
    PDI_DELETE(ctx, cells, level->b);
    PDI_DELETE(ctx, cells, level->r);
    PDI_DELETE(ctx, cells, level->inv);
    PDI_DELETE(ctx, cells, level->parent);
    PDI_DELETE(ctx, cells, level->block);
    PDI_DELETE(ctx, cells, level->self);
    PDI_DELETE(ctx, cells + 1, level->row);
    PDI_DELETE(ctx, cells + 1, level->child_first);
    PDI_DELETE(ctx, links, level->col);
    PDI_DELETE(ctx, links, level->a);
    PDI_DELETE(ctx, links, level->back);
    PDI_DELETE(ctx, links, level->w);
    PDI_DELETE(ctx, links, level->face);
    PDI_DELETE(ctx, level->child_capacity, level->child);
    level->cell_capacity = level->link_capacity = level->child_capacity = 0;
}

void pd_multigrid_free(pd_ctx *ctx, pd_multigrid *mg)
{
    pd_multigrid_level *fine = &mg->level[0];
    size_t cells = (size_t)fine->cells;
    pdi_multigrid_scratch_free(ctx, mg);
    PDI_DELETE(ctx, pdi_multigrid_store(mg), mg->store);
    PDI_DELETE(ctx, cells, fine->b);
    PDI_DELETE(ctx, cells, fine->r);
    PDI_DELETE(ctx, cells, fine->inv);
    PDI_DELETE(ctx, cells, fine->side);
    PDI_DELETE(ctx, cells, fine->parent);
    for (int l = 1; l < PD_MULTIGRID_LEVELS; l++) pdi_multigrid_level_free(ctx, &mg->level[l]);
    mg->levels = 0;
}

/* Room for the cells of a coarse level; old content is of no value, so release before taking. */
static pd_status pdi_multigrid_reserve_cells(pd_ctx *ctx, pd_multigrid_level *level, int32_t cells, int32_t children)
{
    if (children > level->child_capacity) {
        PDI_DELETE(ctx, level->child_capacity, level->child);
        level->child_capacity = 0;
        PDI_TRY(PDI_NEW(ctx, "multigrid", children, level->child));
        level->child_capacity = children;
    }
    if (cells <= level->cell_capacity) return PD_OK;
    int32_t children_kept = level->child_capacity;
    int32_t *child = level->child;
    level->child = NULL;
    pdi_multigrid_level_free(ctx, level);
    level->child = child;
    level->child_capacity = children_kept;
    level->cell_capacity = cells;
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, level->x));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, level->b));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, level->r));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, level->inv));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, level->parent));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, level->block));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, level->self));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells + 1, level->row));
    return PDI_NEW(ctx, "multigrid", cells + 1, level->child_first);
}

static pd_status pdi_multigrid_reserve_links(pd_ctx *ctx, pd_multigrid_level *level, int32_t links)
{
    if (links <= level->link_capacity) return PD_OK;
    size_t old = (size_t)level->link_capacity;
    PDI_DELETE(ctx, old, level->col);
    PDI_DELETE(ctx, old, level->a);
    PDI_DELETE(ctx, old, level->back);
    PDI_DELETE(ctx, old, level->w);
    PDI_DELETE(ctx, old, level->face);
    level->link_capacity = links;
    PDI_TRY(PDI_NEW(ctx, "multigrid", links, level->col));
    PDI_TRY(PDI_NEW(ctx, "multigrid", links, level->a));
    PDI_TRY(PDI_NEW(ctx, "multigrid", links, level->back));
    PDI_TRY(PDI_NEW(ctx, "multigrid", links, level->w));
    return PDI_NEW(ctx, "multigrid", links, level->face);
}

/* ---- links, the same view of all levels; only setup uses it ---- */

typedef struct pdi_multigrid_link {
    int32_t cell;  /* the neighbour */
    float a, back; /* coefficient of the neighbour here, of this cell there */
    int axis, upper;
} pdi_multigrid_link;

static int32_t pdi_multigrid_link_first(const pd_multigrid_level *level, int32_t c)
{
    return level->row ? level->row[c] : 0;
}

static int32_t pdi_multigrid_link_end(const pd_multigrid_level *level, int32_t c)
{
    return level->row ? level->row[c + 1] : 2 * PD_DIM;
}

/* Link k of cell c; 0: closed. */
static int pdi_multigrid_link_get(const pd_multigrid_level *level, int32_t c, int32_t k, pdi_multigrid_link *link)
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
    int32_t stride = pdi_multigrid_stride(level->n, link->axis);
    link->cell = link->upper ? c + stride : c - stride;
    link->a = link->upper ? level->hi[link->axis][c] : level->lo[link->axis][c];
    link->back = link->upper ? level->lo[link->axis][c + stride] : level->hi[link->axis][c - stride];
    return link->a + link->back > 0.0f;
}

static void pdi_multigrid_block_index(const pd_multigrid_level *level, int32_t c, int *i)
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

/* Power of two that brings `largest` near 1. */
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
    pd_multigrid_level *fine = &mg->level[0];
    int32_t stride = pdi_multigrid_stride(fine->n, d), n = fine->n[d];
    float scale = (float)mg->scale;
    float *hi = fine->hi[d], *lo = fine->lo[d];
    for (int32_t c = 0; c < fine->cells; c++) {
        int inside = c / stride % n < n - 1;
        int open = inside && active[c] && active[c + stride];
        float g = open ? scale * conduct[c] : 0.0f, f = open && flux ? scale * flux[c] : 0.0f;
        hi[c] = g + (f < 0.0f ? -f : 0.0f);
        /* with symmetric storage both are the same element; at the upper side of the box there is no neighbour */
        if (inside) lo[c + stride] = g + (f > 0.0f ? f : 0.0f);
    }
}

static void pdi_multigrid_fine(pd_multigrid *mg, const uint8_t *active, const float *const conduct[PD_DIM],
                               const float *const *flux, const float *wall, const float *mass)
{
    pd_multigrid_level *fine = &mg->level[0];
    float scale = (float)mg->scale;
    for (int d = 0; d < PD_DIM; d++)
        pdi_multigrid_fine_faces(mg, d, active, conduct[d], flux ? flux[d] : NULL);
    for (int32_t c = 0; c < fine->cells; c++) {
        mg->wall[c] = wall && active[c] ? scale * wall[c] : 0.0f;
        mg->mass[c] = mass && active[c] ? scale * mass[c] : 0.0f;
        float diag = mg->wall[c] + mg->mass[c];
        pdi_multigrid_link link;
        for (int k = 0; k < 2 * PD_DIM; k++)
            if (pdi_multigrid_link_get(fine, c, k, &link)) diag += link.back;
        fine->inv[c] = diag > 0.0f ? 1.0f / diag : 0.0f;
        fine->r[c] = 0.0f;
    }
}

/* ---- setup: coarsening ---- */

/* Choose the axes to halve; 0: no cell has a link any more. */
static int pdi_multigrid_choose(pd_multigrid_level *level)
{
    double sum[PD_DIM], count[PD_DIM], strongest = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum[d] = count[d] = 0.0;
    for (int32_t c = 0; c < level->cells; c++)
        for (int32_t k = pdi_multigrid_link_first(level, c); k < pdi_multigrid_link_end(level, c); k++) {
            pdi_multigrid_link link;
            if (!pdi_multigrid_link_get(level, c, k, &link)) continue;
            sum[link.axis] += fmin((double)link.a, (double)link.back) +
                              KN_FSTR * fabs((double)link.a - (double)link.back);
            count[link.axis] += 1.0;
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

/* Coarse block of a cell, and its colour. */
static int32_t pdi_multigrid_coarse_block(const pd_multigrid_level *level, const int *coarse_n, int32_t c,
                                          int *colour)
{
    int i[PD_DIM], sum = 0;
    int32_t block = 0;
    pdi_multigrid_block_index(level, c, i);
    for (int d = PD_DIM - 1; d >= 0; d--) {
        int j = level->halve[d] ? i[d] / 2 : i[d];
        block = block * coarse_n[d] + j;
        sum += j;
    }
    *colour = sum & 1;
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

/* 1 when a link of cell c pairs the cell with another of its coarse block. */
static int pdi_multigrid_inside_block(const pd_multigrid_level *level, const int *i, const pdi_multigrid_link *link)
{
    return level->halve[link->axis] && (i[link->axis] & 1) != link->upper;
}

/* Join linked cells of one block. A cell without links is solved by its diagonal and needs no parent. */
static void pdi_multigrid_join(pd_multigrid_level *level)
{
    int32_t *parent = level->parent;
    pdi_multigrid_link link;
    for (int32_t c = 0; c < level->cells; c++) {
        parent[c] = PDI_MULTIGRID_NONE;
        for (int32_t k = pdi_multigrid_link_first(level, c); k < pdi_multigrid_link_end(level, c); k++)
            if (pdi_multigrid_link_get(level, c, k, &link)) parent[c] = -2;
    }
    for (int32_t c = 0; c < level->cells; c++) {
        int i[PD_DIM];
        if (parent[c] == PDI_MULTIGRID_NONE) continue;
        pdi_multigrid_block_index(level, c, i);
        for (int32_t k = pdi_multigrid_link_first(level, c); k < pdi_multigrid_link_end(level, c); k++) {
            if (!pdi_multigrid_link_get(level, c, k, &link) || !link.upper) continue;
            if (!pdi_multigrid_inside_block(level, i, &link)) continue;
            int32_t p = pdi_multigrid_root(parent, c), q = pdi_multigrid_root(parent, link.cell);
            if (p < q) parent[q] = p;
            if (q < p) parent[p] = q;
        }
    }
}

/* Number the joined cells, first colour first, turn parent into those numbers, list the children. */
static pd_status pdi_multigrid_number(pd_ctx *ctx, pd_multigrid_level *level, pd_multigrid_level *coarse)
{
    int32_t *parent = level->parent, next[2] = {0, 0}, children = 0;
    int colour;
    for (int d = 0; d < PD_DIM; d++) coarse->n[d] = level->halve[d] ? (level->n[d] + 1) / 2 : level->n[d];
    for (int32_t c = 0; c < level->cells; c++) {
        if (parent[c] == PDI_MULTIGRID_NONE) continue;
        children++;
        if (parent[c] >= 0) continue;
        pdi_multigrid_coarse_block(level, coarse->n, c, &colour);
        next[colour]++;
    }
    coarse->red = next[0];
    coarse->cells = next[0] + next[1];
    PDI_TRY(pdi_multigrid_reserve_cells(ctx, coarse, coarse->cells, children));
    next[0] = 0;
    next[1] = coarse->red;
    for (int32_t c = 0; c < level->cells; c++)
        if (parent[c] >= 0) parent[c] = pdi_multigrid_root(parent, c);
    for (int32_t c = 0; c < level->cells; c++) {
        if (parent[c] >= PDI_MULTIGRID_NONE) continue;
        int32_t block = pdi_multigrid_coarse_block(level, coarse->n, c, &colour), p = next[colour]++;
        coarse->block[p] = block;
        parent[c] = -p - 2;
    }
    for (int32_t c = 0; c < level->cells; c++)
        if (parent[c] >= 0) parent[c] = parent[parent[c]];
    int32_t *first = coarse->child_first;
    for (int32_t p = 0; p <= coarse->cells; p++) first[p] = 0;
    for (int32_t c = 0; c < level->cells; c++) {
        if (parent[c] == PDI_MULTIGRID_NONE) continue;
        parent[c] = -parent[c] - 2;
        first[parent[c] + 1]++;
    }
    for (int32_t p = 0; p < coarse->cells; p++) first[p + 1] += first[p];
    for (int32_t c = level->cells - 1; c >= 0; c--) /* fills each list from its end, then first is right again */
        if (parent[c] >= 0) coarse->child[--first[parent[c] + 1]] = c;
    for (int32_t p = 0; p < coarse->cells; p++) first[p] = first[p + 1];
    first[coarse->cells] = children;
    return PD_OK;
}

/* Row p of the coarse links, found through the children: conductances of the faces are summed and halved along a
 * halved axis, where the distance of the centres doubles; flows are summed and taken upwind anew.
 * fill 0: only count. Returns the end of the row. */
static int32_t pdi_multigrid_coarse_row(pd_multigrid *mg, const pd_multigrid_level *level, pd_multigrid_level *coarse,
                                        int32_t p, int32_t start, int fill)
{
    int32_t end = start, *mark = mg->mark;
    pdi_multigrid_link link;
    for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) {
        int32_t c = coarse->child[j];
        for (int32_t k = pdi_multigrid_link_first(level, c); k < pdi_multigrid_link_end(level, c); k++) {
            if (!pdi_multigrid_link_get(level, c, k, &link)) continue;
            int32_t q = level->parent[link.cell];
            if (q == p) continue;
            int fresh = mark[q] < start || mark[q] >= end;
            if (fresh) mark[q] = end++;
            if (!fill) continue;
            int32_t at = mark[q];
            if (fresh) {
                coarse->col[at] = q;
                coarse->face[at] = (uint8_t)(2 * link.axis + link.upper);
                coarse->a[at] = coarse->back[at] = 0.0f;
            }
            coarse->a[at] += fminf(link.a, link.back) * (level->halve[link.axis] ? 0.5f : 1.0f); /* g */
            coarse->back[at] += link.back - link.a;                                               /* F out of p */
        }
    }
    for (int32_t k = start; fill && k < end; k++) {
        float g = coarse->a[k], f = coarse->back[k];
        coarse->a[k] = g + (f < 0.0f ? -f : 0.0f);
        coarse->back[k] = g + (f > 0.0f ? f : 0.0f);
    }
    return end;
}

static pd_status pdi_multigrid_coarse_links(pd_ctx *ctx, pd_multigrid *mg, const pd_multigrid_level *level,
                                            pd_multigrid_level *coarse)
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

static void pdi_multigrid_coarse_diagonal(pd_multigrid *mg, const pd_multigrid_level *level,
                                          pd_multigrid_level *coarse)
{
    int all = 1;
    for (int d = 0; d < PD_DIM; d++) all = all && (level->halve[d] || level->n[d] == 1);
    float wall_factor = KN_WALL==3 ? 0.7f : KN_WALL == 2 ? 1.f : (all || KN_WALL==1) ? 0.5f : 1.0f;
    for (int32_t p = 0; p < coarse->cells; p++) {
        float mass = 0.0f, wall = 0.0f, links = 0.0f, stiff = 0.0f;
        for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) {
            int32_t c = coarse->child[j];
            mass += mg->mass[c];
            wall += mg->wall[c];
            stiff += 1.0f / level->inv[c];
        }
        wall *= wall_factor;
        for (int32_t k = coarse->row[p]; k < coarse->row[p + 1]; k++) links += coarse->back[k];
        float diag = mass + wall + links;
        if (links == 0.0f && diag > 0.0f) diag = fmaxf(diag, PDI_MULTIGRID_FLOOR * stiff);
        coarse->inv[p] = diag > 0.0f ? 1.0f / diag : 0.0f;
        coarse->r[p] = 0.0f;
        mg->coarse_mass[p] = mass;
        mg->coarse_wall[p] = wall;
    }
}

/* ---- setup: interpolation, 3/4 of the own parent and 1/4 of that behind the near face, axis by axis ---- */

static void pdi_multigrid_weights_fine(pd_multigrid_level *fine)
{
    pdi_multigrid_link link;
    for (int32_t c = 0; c < fine->cells; c++) {
        int i[PD_DIM];
        unsigned bits = 0;
        pdi_multigrid_block_index(fine, c, i);
        for (int d = 0; d < PD_DIM; d++) {
            int upper = i[d] & 1;
            if (!fine->halve[d] || !pdi_multigrid_link_get(fine, c, 2 * d + upper, &link)) continue;
            bits |= 1u << d;
            if (upper) bits |= 8u << d;
        }
        fine->side[c] = (uint8_t)bits;
    }
}

/* Links of cell c through one face. */
static int pdi_multigrid_face_count(const pd_multigrid_level *level, int32_t c, int face)
{
    int count = 0;
    for (int32_t k = level->row[c]; k < level->row[c + 1]; k++) count += level->face[k] == face;
    return count;
}

/* The weight of a link is the same from both ends, so that rows of the restriction are columns of the interpolation. */
static void pdi_multigrid_weights_coarse(pd_multigrid_level *level)
{
    for (int32_t c = 0; c < level->cells; c++) {
        int i[PD_DIM];
        pdi_multigrid_block_index(level, c, i);
        level->self[c] = 1.0f;
        for (int32_t k = level->row[c]; k < level->row[c + 1]; k++) {
            int face = level->face[k], d = face >> 1;
            level->w[k] = 0.0f;
            if (!level->halve[d] || (i[d] & 1) != (face & 1)) continue;
            int here = pdi_multigrid_face_count(level, c, face);
            int there = pdi_multigrid_face_count(level, level->col[k], face ^ 1);
            level->w[k] = KN_LINEAR / (float)(here > there ? here : there);
            level->self[c] -= level->w[k];
        }
    }
}

static void pdi_multigrid_swap(float **u, float **v)
{
    float *t = *u;
    *u = *v;
    *v = t;
}

static pd_status pdi_multigrid_coarsen(pd_ctx *ctx, pd_multigrid *mg)
{
    for (int l = 0; pdi_multigrid_choose(&mg->level[l]); l++) {
        pd_multigrid_level *level = &mg->level[l], *coarse = level + 1;
        if (l + 1 == PD_MULTIGRID_LEVELS)
            return pdi_fail(ctx, PD_ERR_INTERNAL, "multigrid", "more than %d levels", PD_MULTIGRID_LEVELS);
        pdi_multigrid_join(level);
        PDI_TRY(pdi_multigrid_number(ctx, level, coarse));
        PDI_TRY(pdi_multigrid_coarse_links(ctx, mg, level, coarse));
        pdi_multigrid_coarse_diagonal(mg, level, coarse);
        if (l == 0)
            pdi_multigrid_weights_fine(level);
        else
            pdi_multigrid_weights_coarse(level);
        pdi_multigrid_swap(&mg->mass, &mg->coarse_mass);
        pdi_multigrid_swap(&mg->wall, &mg->coarse_wall);
        mg->levels = l + 2;
    }
    return PD_OK;
}

static pd_status pdi_multigrid_scratch(pd_ctx *ctx, pd_multigrid *mg)
{
    int32_t cells = mg->level[0].cells;
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, mg->mass));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, mg->wall));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, mg->coarse_mass));
    PDI_TRY(PDI_NEW(ctx, "multigrid", cells, mg->coarse_wall));
    return PDI_NEW(ctx, "multigrid", cells, mg->mark);
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
    pd_status status = pdi_multigrid_scratch(ctx, mg);
    if (status == PD_OK) {
        mg->levels = 1;
        pdi_multigrid_fine(mg, active, conduct, flux, wall, mass);
        status = pdi_multigrid_coarsen(ctx, mg);
    }
    pdi_multigrid_scratch_free(ctx, mg);
    if (status < 0) mg->levels = 0;
    return status;
}

/* ---- cycle ---- */

/* Cells of row r of level 0: first cell, and the first index of the colour in it. */
static int32_t pdi_multigrid_row_start(const pd_multigrid_level *fine, int32_t r, int colour, int32_t *base)
{
    int sum = 0;
    int32_t rest = r;
    *base = r * fine->n[0];
    for (int d = 1; d < PD_DIM; d++) {
        sum += (int)(rest % fine->n[d]);
        rest /= fine->n[d];
    }
    return (sum + colour) & 1;
}

/* sum over links of a x */
static inline float pdi_multigrid_fine_sum(const pd_multigrid_level *fine, const int32_t *stride, int32_t c)
{
    float sum = 0.0f;
    for (int d = 0; d < PD_DIM; d++)
        sum += fine->lo[d][c] * fine->x[c - stride[d]] + fine->hi[d][c] * fine->x[c + stride[d]];
    return sum;
}

typedef enum pdi_multigrid_job {
    PDI_MULTIGRID_START,   /* x = b / diag */
    PDI_MULTIGRID_SMOOTH,  /* x = (b + sum a x) / diag */
    PDI_MULTIGRID_RESIDUAL, /* r = sum a x: the residual after START here and SMOOTH on the other colour */
    KN_RES, 
    PDI_MULTIGRID_PROLONG  /* x += P x_coarse */
} pdi_multigrid_job;

static inline float pdi_multigrid_fine_prolong(const pd_multigrid_level *fine, const int32_t *stride, const float *up,
                                               int32_t c)
{
    unsigned bits = fine->side[c];
    int32_t own = fine->parent[c];
    if (own < 0) return 0.0f;
    float sum = 0.0f, self = 1.0f;
    for (int d = 0; d < PD_DIM; d++)
        if (bits >> d & 1u) {
            sum += up[fine->parent[bits >> d & 8u ? c + stride[d] : c - stride[d]]];
            self -= KN_LINEAR;
        }
    return self * up[own] + KN_LINEAR * sum;
}

/* One job on the cells of one colour of level 0; up: x of level 1. */
static void pdi_multigrid_fine_job(const pd_ctx *ctx, const pd_multigrid_level *fine, pdi_multigrid_job job, int colour,
                                   const float *up)
{
    int32_t rows = fine->cells / fine->n[0], stride[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) stride[d] = pdi_multigrid_stride(fine->n, d);
    float *x = fine->x;
    const float *b = fine->b, *inv = fine->inv;
    int nt = pdi_par_threads(ctx, (int64_t)fine->cells * PDI_MULTIGRID_WORK);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < rows; r++) {
        int32_t base, i = pdi_multigrid_row_start(fine, r, colour, &base), end = base + fine->n[0];
        int32_t c = base + i;
        switch (job) {
        case PDI_MULTIGRID_START:
            for (; c < end; c += 2) x[c] = b[c] * inv[c];
            break;
        case PDI_MULTIGRID_SMOOTH:
            for (; c < end; c += 2) x[c] = (b[c] + pdi_multigrid_fine_sum(fine, stride, c)) * inv[c];
            break;
        case PDI_MULTIGRID_RESIDUAL:
            for (; c < end; c += 2) fine->r[c] = pdi_multigrid_fine_sum(fine, stride, c);
            break;
        case KN_RES:
            for (; c < end; c += 2) fine->r[c] = inv[c]>0?b[c] + pdi_multigrid_fine_sum(fine, stride, c)-x[c]/inv[c]:0;
            break;
        case PDI_MULTIGRID_PROLONG:
            for (; c < end; c += 2) x[c] += KN_OVER*pdi_multigrid_fine_prolong(fine, stride, up, c);
            break;
        }
    }
}

static inline float pdi_multigrid_coarse_sum(const pd_multigrid_level *level, int32_t c)
{
    float sum = 0.0f;
    for (int32_t k = level->row[c]; k < level->row[c + 1]; k++) sum += level->a[k] * level->x[level->col[k]];
    return sum;
}

static inline float pdi_multigrid_coarse_prolong(const pd_multigrid_level *level, const float *up, int32_t c)
{
    if (level->parent[c] < 0) return 0.0f;
    float sum = level->self[c] * up[level->parent[c]];
    for (int32_t k = level->row[c]; k < level->row[c + 1]; k++)
        if (level->w[k] > 0.0f) sum += level->w[k] * up[level->parent[level->col[k]]];
    return sum;
}

static void pdi_multigrid_coarse_job(const pd_ctx *ctx, const pd_multigrid_level *level, pdi_multigrid_job job,
                                     int colour, const float *up)
{
    int32_t first = colour ? level->red : 0, end = colour ? level->cells : level->red;
    float *x = level->x;
    const float *b = level->b, *inv = level->inv;
    int nt = pdi_par_threads(ctx, (int64_t)(end - first) * 2 * PDI_MULTIGRID_WORK);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t c = first; c < end; c++) switch (job) {
        case PDI_MULTIGRID_START: x[c] = b[c] * inv[c]; break;
        case PDI_MULTIGRID_SMOOTH: x[c] = (b[c] + pdi_multigrid_coarse_sum(level, c)) * inv[c]; break;
        case PDI_MULTIGRID_RESIDUAL: level->r[c] = pdi_multigrid_coarse_sum(level, c); break;
        case KN_RES: level->r[c] = inv[c]>0?b[c]+pdi_multigrid_coarse_sum(level, c)-x[c]/inv[c]:0; break;
        case PDI_MULTIGRID_PROLONG: x[c] += KN_OVER*pdi_multigrid_coarse_prolong(level, up, c); break;
        }
}

static void pdi_multigrid_job_run(const pd_ctx *ctx, const pd_multigrid *mg, int l, pdi_multigrid_job job, int colour)
{
    const float *up = job == PDI_MULTIGRID_PROLONG ? mg->level[l + 1].x : NULL;
    if (l == 0)
        pdi_multigrid_fine_job(ctx, &mg->level[0], job, colour, up);
    else
        pdi_multigrid_coarse_job(ctx, &mg->level[l], job, colour, up);
}

/* b of level l + 1 = P^T r of level l */
static void pdi_multigrid_restrict(const pd_ctx *ctx, const pd_multigrid *mg, int l)
{
    const pd_multigrid_level *level = &mg->level[l], *coarse = level + 1;
    const float *r = level->r;
    int32_t stride[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) stride[d] = pdi_multigrid_stride(level->n, d);
    int nt = pdi_par_threads(ctx, (int64_t)coarse->cells * 4 * PDI_MULTIGRID_WORK);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < coarse->cells; p++) {
        float total = 0.0f;
        for (int32_t j = coarse->child_first[p]; j < coarse->child_first[p + 1]; j++) {
            int32_t c = coarse->child[j];
            if (l > 0) {
                total += level->self[c] * r[c];
                for (int32_t k = level->row[c]; k < level->row[c + 1]; k++) total += level->w[k] * r[level->col[k]];
                continue;
            }
            float self = 1.0f, sum = 0.0f;
            for (int d = 0; d < PD_DIM; d++)
                if (level->side[c] >> d & 1) {
                    sum += r[level->side[c] >> d & 8 ? c + stride[d] : c - stride[d]];
                    self -= KN_LINEAR;
                }
            total += self * r[c] + KN_LINEAR * sum;
        }
        coarse->b[p] = total;
    }
}

static void pdi_multigrid_visit(const pd_ctx *ctx, const pd_multigrid *mg, int l, int guess)
{
    if (!guess) pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_START, 0);
    if (l == mg->levels - 1) { pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_START, 0);
        pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_START, 1);
        return;
    }
    if (guess) pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_SMOOTH, 0);
    pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_SMOOTH, 1);
    for (int s = 1; s < KN_NU; s++) {
        pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_SMOOTH, 0);
        pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_SMOOTH, 1);
    }
    pdi_multigrid_job_run(ctx, mg, l, guess || KN_NU > 1 ? KN_RES : PDI_MULTIGRID_RESIDUAL, 0);
    pdi_multigrid_restrict(ctx, mg, l);
    for (int g = 0; g < (l > 0 ? KN_GAMMA : 1); g++) pdi_multigrid_visit(ctx, mg, l + 1, g);
    pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_PROLONG, 0);
    for (int s = 0; s < KN_NU; s++) {
        pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_SMOOTH, 1);
        pdi_multigrid_job_run(ctx, mg, l, PDI_MULTIGRID_SMOOTH, 0);
    }
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

/* max |rhs| over the cells that take part; the order does not matter, so blocks of rows may go to any thread. */
static double pdi_multigrid_rhs_size(const pd_ctx *ctx, const pd_multigrid *mg, const double *rhs)
{
    enum { PARTS = 64 };
    double part[PARTS], largest = 0.0;
    const pd_multigrid_level *fine = &mg->level[0];
    int64_t rows = fine->cells / fine->n[0];
    int nt = pdi_par_threads(ctx, fine->cells);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int q = 0; q < PARTS; q++) {
        part[q] = 0.0;
        for (int32_t r = (int32_t)(rows * q / PARTS); r < (int32_t)(rows * (q + 1) / PARTS); r++) {
            int32_t node = pdi_multigrid_row_node(mg, r), base = r * fine->n[0];
            for (int32_t i = 0; i < fine->n[0]; i++) {
                double size = fine->inv[base + i] > 0.0f ? fabs(rhs[node + i * mg->desc.stride[0]]) : 0.0;
                if (size > part[q]) part[q] = size;
            }
        }
    }
    for (int q = 0; q < PARTS; q++) largest = fmax(largest, part[q]);
    return largest;
}

void pd_multigrid_cycle(pd_ctx *ctx, pd_multigrid *mg, const double *rhs, double *x)
{
    const pd_multigrid_level *fine = &mg->level[0];
    int32_t rows = fine->cells / fine->n[0], n0 = fine->n[0], s0 = mg->desc.stride[0];
    double in = pdi_multigrid_scale(pdi_multigrid_rhs_size(ctx, mg, rhs)), out = mg->scale / in;
    int nt = pdi_par_threads(ctx, fine->cells);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < rows; r++) {
        int32_t node = pdi_multigrid_row_node(mg, r), base = r * n0;
        for (int32_t i = 0; i < n0; i++)
            fine->b[base + i] = fine->inv[base + i] > 0.0f ? (float)(in * rhs[node + i * s0]) : 0.0f;
    }
    pdi_multigrid_visit(ctx, mg, 0, 0);
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < rows; r++) {
        int32_t node = pdi_multigrid_row_node(mg, r), base = r * n0;
        for (int32_t i = 0; i < n0; i++) x[node + i * s0] = out * (double)fine->x[base + i];
    }
}
