/* coarse_fe_precond: see coarse_fe_precond.h */
#include "solid/coarse_fe_precond.h"
#include "core/disjoint_sets.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Most boxes along an axis; their width is the longest bond where they are fewer. */
#define PDI_COARSE_FE_PRECOND_MAX_BOXES 1e6
/* Symmetric Gauss-Seidel sweeps on the coarsest level. */
#define PDI_COARSE_FE_PRECOND_COARSEST_SWEEPS 4

enum { PDI_COARSE_FE_PRECOND_CORNERS = 1 << PD_DIM, PDI_COARSE_FE_PRECOND_BLOCK = PD_DIM * PD_DIM };

/* Describes the arrays by points. */
static void pdi_coarse_fe_precond_list_points(pdi_array_visitor *owner, void *object)
{
    pd_coarse_fe_precond *scaffold = (pd_coarse_fe_precond *)object;
    PDI_ARRAY(owner, scaffold, element, scaffold->body ? scaffold->body->count : 0, "1");
    PDI_ARRAY(owner, scaffold, point, scaffold->body ? scaffold->body->count : 0, "1");
}

/* Describes the arrays by elements of level 0 that only the finest level has. */
static void pdi_coarse_fe_precond_list_elements(pdi_array_visitor *owner, void *object)
{
    pd_coarse_fe_precond *scaffold = (pd_coarse_fe_precond *)object;
    int64_t parts = scaffold->level[0].elements;
    PDI_ARRAY(owner, scaffold, first_point, parts + 1, "1");
    PDI_ARRAY(owner, scaffold, nodal_force, parts * PDI_COARSE_FE_PRECOND_CORNERS * PD_DIM, "N");
}

/* Describes the arrays of a level by elements. */
static void pdi_coarse_fe_precond_list_level_elements(pdi_array_visitor *owner, void *object)
{
    pd_coarse_fe_level *level = (pd_coarse_fe_level *)object;
    PDI_ARRAY(owner, level, box, (int64_t)level->elements * PD_DIM, "1");
    PDI_ARRAY(owner, level, node, (int64_t)level->elements * PDI_COARSE_FE_PRECOND_CORNERS, "1");
    PDI_ARRAY(owner, level, corner, (int64_t)level->elements * PDI_COARSE_FE_PRECOND_CORNERS, "1");
    PDI_ARRAY(owner, level, parent, level->elements, "1");
    PDI_ARRAY(owner, level, lambda, level->elements, "N m");
    PDI_ARRAY(owner, level, mu, level->elements, "N m");
}

/* Describes the arrays of a level by nodes. */
static void pdi_coarse_fe_precond_list_level_nodes(pdi_array_visitor *owner, void *object)
{
    pd_coarse_fe_level *level = (pd_coarse_fe_level *)object;
    int64_t entries = (int64_t)level->nodes * PD_DIM;
    PDI_ARRAY(owner, level, first, level->nodes + 1, "1");
    PDI_ARRAY(owner, level, row, level->nodes + 1, "1");
    PDI_ARRAY(owner, level, node_index, entries, "1");
    PDI_ARRAY(owner, level, spring, entries, "N/m");
    PDI_ARRAY(owner, level, inverse, entries * PD_DIM, "m/N");
    PDI_ARRAY(owner, level, x, entries, "m");
    PDI_ARRAY(owner, level, b, entries, "N");
    PDI_ARRAY(owner, level, r, entries, "N");
}

/* Describes the arrays of a level by matrix blocks. */
static void pdi_coarse_fe_precond_list_level_blocks(pdi_array_visitor *owner, void *object)
{
    pd_coarse_fe_level *level = (pd_coarse_fe_level *)object;
    PDI_ARRAY(owner, level, column, level->blocks, "1");
    PDI_ARRAY(owner, level, block, (int64_t)level->blocks * PDI_COARSE_FE_PRECOND_BLOCK, "N/m");
}

/* ---- sets that unite ---- */

/* Replaces the roots of n members of disjoint sets by set numbers 0, 1, .., in place; each root is its first member.
 * Returns how many sets. */
static int32_t pdi_coarse_fe_precond_number_sets(int32_t *set, int32_t n)
{
    int32_t count = 0;
    for (int32_t a = 0; a < n; a++) set[a] = set[a] == a ? count++ : set[set[a]]; /* roots come first */
    return count;
}

/* ---- parts and nodes ---- */

/* Index of the box of point i along the axes, into box [PD_DIM]. */
static void pdi_coarse_fe_precond_find_box(const pd_coarse_fe_precond *s, int32_t i, int32_t *box)
{
    for (int d = 0; d < PD_DIM; d++)
        box[d] = (int32_t)((s->body->position[(int64_t)i * PD_DIM + d] - s->lo[d]) / s->width);
}

/* 1: two box indices are equal. */
static int pdi_coarse_fe_precond_is_same_box(const int32_t *a, const int32_t *b)
{
    for (int d = 0; d < PD_DIM; d++)
        if (a[d] != b[d]) return 0;
    return 1;
}

/* Elements of level 0: points of a box that bonds within it connect. Sets element, first_point, point and the boxes of
 * elements, and allocates the arrays by elements. */
static pd_status pdi_coarse_fe_precond_build_elements(pd_ctx *ctx, pd_coarse_fe_precond *s)
{
    const pd_body *body = s->body;
    pd_coarse_fe_level *level = &s->level[0];
    for (int32_t i = 0; i < body->count; i++) s->element[i] = i;
    for (int32_t i = 0; i < body->count; i++) {
        int32_t own[PD_DIM], far[PD_DIM];
        pdi_coarse_fe_precond_find_box(s, i, own);
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
            if (f.neighbour <= i || pd_body_bond_is_broken(&f)) continue;
            pdi_coarse_fe_precond_find_box(s, f.neighbour, far);
            if (pdi_coarse_fe_precond_is_same_box(own, far)) pdi_disjoint_sets_merge(s->element, i, f.neighbour);
        }
    }
    for (int32_t i = 0; i < body->count; i++) s->element[i] = pdi_disjoint_sets_find_root(s->element, i);
    level->elements = pdi_coarse_fe_precond_number_sets(s->element, body->count);
    PD_TRY(pdi_array_registry_build(ctx, pdi_coarse_fe_precond_list_elements, s));
    PD_TRY(pdi_array_registry_build(ctx, pdi_coarse_fe_precond_list_level_elements, level));
    for (int32_t i = 0; i < body->count; i++) s->first_point[s->element[i] + 1]++;
    for (int32_t p = 0; p < level->elements; p++) s->first_point[p + 1] += s->first_point[p];
    for (int32_t i = body->count - 1; i >= 0; i--) s->point[--s->first_point[s->element[i] + 1]] = i;
    for (int32_t p = 0; p < level->elements; p++) s->first_point[p] = s->first_point[p + 1];
    s->first_point[level->elements] = body->count;
    for (int32_t p = 0; p < level->elements; p++)
        pdi_coarse_fe_precond_find_box(s, s->point[s->first_point[p]], level->box + p * PD_DIM);
    return PD_OK;
}

/* Merges the nodes of elements p and q that their boxes share, none where the boxes do not touch. set: disjoint sets of
 * element corners, number 2^d p + corner. */
static void pdi_coarse_fe_precond_merge_nodes(const pd_coarse_fe_level *level, int32_t p, int32_t q, int32_t *set)
{
    for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS; a++) {
        int b = 0, shared = 1;
        for (int d = 0; d < PD_DIM; d++) {
            int32_t at = level->box[p * PD_DIM + d] + (a >> d & 1) - level->box[q * PD_DIM + d];
            shared = shared && (at == 0 || at == 1);
            b |= (at & 1) << d;
        }
        if (shared)
            pdi_disjoint_sets_merge(set, p * PDI_COARSE_FE_PRECOND_CORNERS + a, q * PDI_COARSE_FE_PRECOND_CORNERS + b);
    }
}

/* Merges nodes of level-0 elements that an unbroken bond connects, in set. seen [elements]: work, 0 before. */
static void pdi_coarse_fe_precond_connect_elements(const pd_coarse_fe_precond *s, int32_t *seen, int32_t *set)
{
    const pd_body *body = s->body;
    for (int32_t p = 0; p < s->level[0].elements; p++)
        for (int32_t n = s->first_point[p]; n < s->first_point[p + 1]; n++)
            for (pd_bond_iterator f = pd_body_bonds_begin(body, s->point[n]); pd_body_bonds_next(&f);) {
                int32_t q = s->element[f.neighbour];
                if (q <= p || pd_body_bond_is_broken(&f) || seen[q] == p + 1) continue;
                seen[q] = p + 1;
                pdi_coarse_fe_precond_merge_nodes(&s->level[0], p, q, set);
            }
}

/* Nodes of a level, which are the sets of corners: numbered by colour, which is the parity of the node index along each
 * axis; sets node, colour, corner, first and node_index, and allocates the arrays by nodes. set: work afterwards. */
static pd_status pdi_coarse_fe_precond_build_nodes(pd_ctx *ctx, pd_coarse_fe_level *level, int32_t *set)
{
    int32_t corners = level->elements * PDI_COARSE_FE_PRECOND_CORNERS, colour[PDI_COARSE_FE_PRECOND_CORNERS + 1] = {0};
    for (int32_t k = 0; k < corners; k++) set[k] = pdi_disjoint_sets_find_root(set, k);
    for (int way = 0; way < 2; way++) {
        for (int32_t k = 0; k < corners; k++) {
            int bits = 0;
            if (set[k] != k) continue;
            for (int d = 0; d < PD_DIM; d++)
                bits |= ((level->box[k / PDI_COARSE_FE_PRECOND_CORNERS * PD_DIM + d] + (k >> d & 1)) & 1) << d;
            if (way == 0) level->colour[bits + 1]++;
            else level->node[k] = level->colour[bits] + colour[bits]++;
        }
        for (int c = 0; c < PDI_COARSE_FE_PRECOND_CORNERS && way == 0; c++) level->colour[c + 1] += level->colour[c];
    }
    level->nodes = level->colour[PDI_COARSE_FE_PRECOND_CORNERS];
    PD_TRY(pdi_array_registry_build(ctx, pdi_coarse_fe_precond_list_level_nodes, level));
    for (int32_t k = 0; k < corners; k++) level->first[(level->node[k] = level->node[set[k]]) + 1]++;
    for (int32_t v = 0; v < level->nodes; v++) level->first[v + 1] += level->first[v];
    for (int32_t k = corners - 1; k >= 0; k--) level->corner[--level->first[level->node[k] + 1]] = k;
    for (int32_t v = 0; v < level->nodes; v++) level->first[v] = level->first[v + 1];
    level->first[level->nodes] = corners;
    for (int32_t v = 0; v < level->nodes; v++)
        for (int d = 0; d < PD_DIM; d++) {
            int32_t k = level->corner[level->first[v]];
            level->node_index[v * PD_DIM + d] =
                level->box[k / PDI_COARSE_FE_PRECOND_CORNERS * PD_DIM + d] + (k >> d & 1);
        }
    return PD_OK;
}

/* Elements of the next level: connected elements within a box of twice the width. Sets parent of this level; allocates
 * the arrays of the next one by elements and sets its boxes. */
static pd_status pdi_coarse_fe_precond_build_coarse_elements(pd_ctx *ctx, pd_coarse_fe_level *level,
                                                             pd_coarse_fe_level *next)
{
    int32_t *box = level->box, *set = level->parent;
    for (int32_t p = 0; p < level->elements; p++) set[p] = p;
    for (int32_t v = 0; v < level->nodes; v++)
        for (int32_t k = level->first[v]; k < level->first[v + 1]; k++)
            for (int32_t m = level->first[v]; m < k; m++) {
                int32_t p = level->corner[k] / PDI_COARSE_FE_PRECOND_CORNERS,
                        q = level->corner[m] / PDI_COARSE_FE_PRECOND_CORNERS;
                int same = 1;
                for (int d = 0; d < PD_DIM; d++) same = same && box[p * PD_DIM + d] / 2 == box[q * PD_DIM + d] / 2;
                if (same) pdi_disjoint_sets_merge(set, p, q);
            }
    for (int32_t p = 0; p < level->elements; p++) set[p] = pdi_disjoint_sets_find_root(set, p);
    next->elements = pdi_coarse_fe_precond_number_sets(set, level->elements);
    PD_TRY(pdi_array_registry_build(ctx, pdi_coarse_fe_precond_list_level_elements, next));
    for (int32_t p = 0; p < level->elements; p++)
        for (int d = 0; d < PD_DIM; d++) next->box[set[p] * PD_DIM + d] = box[p * PD_DIM + d] / 2;
    return PD_OK;
}

/* Merges nodes of elements of the next level whose children share a node. */
static void pdi_coarse_fe_precond_connect_coarse_elements(const pd_coarse_fe_level *level,
                                                          const pd_coarse_fe_level *next, int32_t *set)
{
    for (int32_t v = 0; v < level->nodes; v++)
        for (int32_t k = level->first[v]; k < level->first[v + 1]; k++)
            for (int32_t m = level->first[v]; m < k; m++) {
                int32_t p = level->parent[level->corner[k] / PDI_COARSE_FE_PRECOND_CORNERS];
                int32_t q = level->parent[level->corner[m] / PDI_COARSE_FE_PRECOND_CORNERS];
                if (p != q) pdi_coarse_fe_precond_merge_nodes(next, p, q, set);
            }
}

/* Block pattern of the matrix, into row and column: nodes that share an element. Counts first, then fills. */
static pd_status pdi_coarse_fe_precond_build_pattern(pd_ctx *ctx, pd_coarse_fe_level *level)
{
    int32_t *seen = NULL;
    pd_status status = PD_NEW(ctx, "scaffold", level->nodes, seen);
    for (int fills = 0; fills < 2 && status == PD_OK; fills++) {
        int32_t links = 0;
        for (int32_t v = 0; v < level->nodes; v++) {
            for (int32_t k = level->first[v]; k < level->first[v + 1]; k++)
                for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS; a++) {
                    int32_t w =
                        level->node[level->corner[k] / PDI_COARSE_FE_PRECOND_CORNERS * PDI_COARSE_FE_PRECOND_CORNERS +
                                    a];
                    if (seen[w] == 2 * v + 1 + fills) continue;
                    seen[w] = 2 * v + 1 + fills;
                    if (fills) level->column[links] = w;
                    links++;
                }
            level->row[v + 1] = links;
        }
        level->blocks = links;
        if (!fills) status = pdi_array_registry_build(ctx, pdi_coarse_fe_precond_list_level_blocks, level);
        memset(seen, 0, (size_t)level->nodes * sizeof *seen);
    }
    PD_DELETE(ctx, level->nodes, seen);
    return status;
}

/* Nodes and matrix pattern of level k, whose elements exist. */
static pd_status pdi_coarse_fe_precond_build_level(pd_ctx *ctx, pd_coarse_fe_precond *s, int k)
{
    pd_coarse_fe_level *level = &s->level[k];
    int32_t *set = NULL, *seen = NULL, corners = level->elements * PDI_COARSE_FE_PRECOND_CORNERS;
    pd_status status = PD_NEW(ctx, "scaffold", corners, set);
    if (status == PD_OK) status = PD_NEW(ctx, "scaffold", level->elements, seen);
    if (status == PD_OK) {
        for (int32_t n = 0; n < corners; n++) set[n] = n;
        if (k == 0) pdi_coarse_fe_precond_connect_elements(s, seen, set);
        else pdi_coarse_fe_precond_connect_coarse_elements(&s->level[k - 1], level, set);
        status = pdi_coarse_fe_precond_build_nodes(ctx, level, set);
    }
    PD_DELETE(ctx, corners, set);
    PD_DELETE(ctx, level->elements, seen);
    PD_TRY(status);
    return pdi_coarse_fe_precond_build_pattern(ctx, level);
}

/* 1: the level has one box only. */
static int pdi_coarse_fe_precond_is_coarsest(const pd_coarse_fe_level *level)
{
    for (int32_t k = 0; k < level->elements * PD_DIM; k++)
        if (level->box[k] > 0) return 0;
    return 1;
}

/* Inner part of the build: boxes are horizon + spacing/2 wide, wider where an axis would have more than 1e6; adds
 * levels until one has a single box or PD_COARSE_FE_LEVELS are reached. After an error the caller frees. */
static pd_status pdi_coarse_fe_precond_build_inner(pd_ctx *ctx, pd_coarse_fe_precond *s)
{
    const pd_body *body = s->body;
    s->width = body->horizon + 0.5 * body->spacing;
    for (int d = 0; d < PD_DIM; d++) {
        double lo = HUGE_VAL, hi = -HUGE_VAL;
        for (int32_t i = 0; i < body->count; i++) {
            lo = pd_min(lo, body->position[(int64_t)i * PD_DIM + d]);
            hi = pd_max(hi, body->position[(int64_t)i * PD_DIM + d]);
        }
        s->lo[d] = lo - 0.5 * body->spacing;
        s->width = pd_max(s->width, (hi - lo) / PDI_COARSE_FE_PRECOND_MAX_BOXES);
    }
    PD_TRY(pdi_array_registry_build(ctx, pdi_coarse_fe_precond_list_points, s));
    PD_TRY(pdi_coarse_fe_precond_build_elements(ctx, s));
    for (;;) {
        int k = s->levels++;
        PD_TRY(pdi_coarse_fe_precond_build_level(ctx, s, k));
        if (pdi_coarse_fe_precond_is_coarsest(&s->level[k]) || s->levels == PD_COARSE_FE_LEVELS) return PD_OK;
        PD_TRY(pdi_coarse_fe_precond_build_coarse_elements(ctx, &s->level[k], &s->level[k + 1]));
    }
}

PDI_FN double pdi_coarse_fe_precond_estimate_bytes(int32_t count, double wide)
{
    double bytes, parts = (double)count;
    pd_body body;
    pd_coarse_fe_precond s;
    memset(&body, 0, sizeof body);
    memset(&s, 0, sizeof s);
    body.count = count;
    s.body = &body;
    for (int d = 0; d < PD_DIM; d++) parts /= wide;
    s.level[0].elements = (int32_t)parts + 1;
    bytes = (double)(pdi_array_registry_count_bytes(pdi_coarse_fe_precond_list_points, &s) +
                     pdi_array_registry_count_bytes(pdi_coarse_fe_precond_list_elements, &s));
    for (int k = 0; k < PD_COARSE_FE_LEVELS && parts > 1.0; k++, parts /= (double)PDI_COARSE_FE_PRECOND_CORNERS) {
        pd_coarse_fe_level *level = &s.level[k];
        level->elements = (int32_t)parts + 1;
        level->nodes = (int32_t)pow(pow(parts, 1.0 / PD_DIM) + 1.0, PD_DIM) + 1;
        level->blocks = (int32_t)pd_min(pow(3.0, PD_DIM) * (double)level->nodes, (double)INT32_MAX);
        bytes += (double)(pdi_array_registry_count_bytes(pdi_coarse_fe_precond_list_level_elements, level) +
                          pdi_array_registry_count_bytes(pdi_coarse_fe_precond_list_level_nodes, level) +
                          pdi_array_registry_count_bytes(pdi_coarse_fe_precond_list_level_blocks, level));
    }
    return bytes;
}

PDI_FN pd_status pdi_coarse_fe_precond_build(pd_ctx *ctx, const pd_body *body, pd_coarse_fe_precond *s)
{
    memset(s, 0, sizeof *s);
    s->body = body;
    pd_status status = pdi_coarse_fe_precond_build_inner(ctx, s);
    if (status < 0) pdi_coarse_fe_precond_free(ctx, s);
    return status;
}

PDI_FN void pdi_coarse_fe_precond_free(pd_ctx *ctx, pd_coarse_fe_precond *s)
{
    for (int k = 0; k < PD_COARSE_FE_LEVELS; k++) {
        pdi_array_registry_free(ctx, pdi_coarse_fe_precond_list_level_blocks, &s->level[k]);
        pdi_array_registry_free(ctx, pdi_coarse_fe_precond_list_level_nodes, &s->level[k]);
        pdi_array_registry_free(ctx, pdi_coarse_fe_precond_list_level_elements, &s->level[k]);
    }
    pdi_array_registry_free(ctx, pdi_coarse_fe_precond_list_elements, s);
    pdi_array_registry_free(ctx, pdi_coarse_fe_precond_list_points, s);
    memset(s, 0, sizeof *s);
}

/* ---- operators ---- */

/* Stiffness of an element of width 1 and volume 1, for lambda = 1 and for mu = 1: [corner][corner][axis][axis] [-]. */
typedef struct pdi_coarse_fe_precond_element {
    double lambda[PDI_COARSE_FE_PRECOND_CORNERS][PDI_COARSE_FE_PRECOND_CORNERS][PDI_COARSE_FE_PRECOND_BLOCK];
    double mu[PDI_COARSE_FE_PRECOND_CORNERS][PDI_COARSE_FE_PRECOND_CORNERS][PDI_COARSE_FE_PRECOND_BLOCK];
} pdi_coarse_fe_precond_element;

/* Shape function of a corner at a position [PD_DIM] in the unit box, 0 to 1; p >= 0: its derivative along axis p; -1:
 * the value. */
static inline double pdi_coarse_fe_precond_shape_function(int corner, const double *at, int p)
{
    double value = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        int upper = corner >> d & 1;
        if (d == p) value *= upper ? 1.0 : -1.0;
        else value *= upper ? at[d] : 1.0 - at[d];
    }
    return value;
}

/* Sets e to the element stiffness, by Gauss quadrature with two points an axis, which is exact. */
static void pdi_coarse_fe_precond_integrate_element(pdi_coarse_fe_precond_element *e)
{
    memset(e, 0, sizeof *e);
    for (int g = 0; g < PDI_COARSE_FE_PRECOND_CORNERS; g++) {
        double at[PD_DIM], slope[PDI_COARSE_FE_PRECOND_CORNERS][PD_DIM],
            share = 1.0 / (double)PDI_COARSE_FE_PRECOND_CORNERS;
        for (int d = 0; d < PD_DIM; d++) at[d] = 0.5 + ((g >> d & 1) ? 0.5 : -0.5) / sqrt(3.0);
        for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS; a++)
            for (int p = 0; p < PD_DIM; p++) slope[a][p] = pdi_coarse_fe_precond_shape_function(a, at, p);
        for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS; a++)
            for (int b = 0; b < PDI_COARSE_FE_PRECOND_CORNERS; b++)
                for (int p = 0; p < PD_DIM; p++)
                    for (int q = 0; q < PD_DIM; q++) {
                        double *mu = &e->mu[a][b][p * PD_DIM + q];
                        e->lambda[a][b][p * PD_DIM + q] += share * slope[a][p] * slope[b][q];
                        *mu += share * slope[a][q] * slope[b][p];
                        for (int d = 0; d < PD_DIM && p == q; d++) *mu += share * slope[a][d] * slope[b][d];
                    }
    }
}

/* Matrix [N/m] and inverse diagonal blocks [m/N] of a level with boxes of this width [m], from its moduli and springs,
 * in single precision; springs add to the diagonal. The inverse is zero where a block is singular. */
static void pdi_coarse_fe_precond_assemble_level(const pd_ctx *ctx, const pd_coarse_fe_level *level, double width)
{
    pdi_coarse_fe_precond_element e;
    double scale = 1.0 / (width * width);
    int nt = pd_par_threads(ctx, (int64_t)level->blocks * 100);
    (void)nt;
    pdi_coarse_fe_precond_integrate_element(&e);
    PD_PARALLEL_FOR(nt)
    for (int32_t v = 0; v < level->nodes; v++) {
        double own[PDI_COARSE_FE_PRECOND_BLOCK] = {0.0}, inverse[PDI_COARSE_FE_PRECOND_BLOCK] = {0.0};
        for (int32_t m = level->row[v]; m < level->row[v + 1]; m++) {
            double block[PDI_COARSE_FE_PRECOND_BLOCK] = {0.0};
            for (int32_t k = level->first[v]; k < level->first[v + 1]; k++) {
                int32_t part = level->corner[k] / PDI_COARSE_FE_PRECOND_CORNERS,
                        a = level->corner[k] % PDI_COARSE_FE_PRECOND_CORNERS;
                for (int b = 0; b < PDI_COARSE_FE_PRECOND_CORNERS; b++) {
                    if (level->node[part * PDI_COARSE_FE_PRECOND_CORNERS + b] != level->column[m]) continue;
                    for (int p = 0; p < PDI_COARSE_FE_PRECOND_BLOCK; p++)
                        block[p] += scale * (level->lambda[part] * e.lambda[a][b][p] + level->mu[part] * e.mu[a][b][p]);
                }
            }
            if (level->column[m] == v) {
                for (int d = 0; d < PD_DIM; d++) block[d * PD_DIM + d] += level->spring[v * PD_DIM + d];
                memcpy(own, block, sizeof own);
            }
            for (int p = 0; p < PDI_COARSE_FE_PRECOND_BLOCK; p++)
                level->block[(int64_t)m * PDI_COARSE_FE_PRECOND_BLOCK + p] = (float)block[p];
        }
        if (!(pdi_vec_invert(own, inverse) > 0.0)) memset(inverse, 0, sizeof inverse);
        for (int p = 0; p < PDI_COARSE_FE_PRECOND_BLOCK; p++)
            level->inverse[(int64_t)v * PDI_COARSE_FE_PRECOND_BLOCK + p] = (float)inverse[p];
    }
}

/* Element of the next level that contains node v, and its position `at` [PD_DIM] in the box of that, 0 to 1. */
static int32_t pdi_coarse_fe_precond_find_parent(const pd_coarse_fe_level *level, const pd_coarse_fe_level *next,
                                                 int32_t v, double *at)
{
    int32_t part = level->parent[level->corner[level->first[v]] / PDI_COARSE_FE_PRECOND_CORNERS];
    for (int d = 0; d < PD_DIM; d++)
        at[d] = 0.5 * (level->node_index[v * PD_DIM + d] - 2 * next->box[part * PD_DIM + d]);
    return part;
}

/* Adds nodal values from [nodes][PD_DIM] of a level to those of the next one: transpose of the interpolation. */
static void pdi_coarse_fe_precond_restrict_nodes(const pd_coarse_fe_level *level, const pd_coarse_fe_level *next,
                                                 const double *from, double *to)
{
    for (int32_t v = 0; v < level->nodes; v++) {
        double at[PD_DIM];
        int32_t part = pdi_coarse_fe_precond_find_parent(level, next, v, at);
        for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS; a++) {
            double share = pdi_coarse_fe_precond_shape_function(a, at, -1);
            int32_t w = next->node[part * PDI_COARSE_FE_PRECOND_CORNERS + a];
            for (int d = 0; d < PD_DIM; d++) to[w * PD_DIM + d] += share * from[v * PD_DIM + d];
        }
    }
}

/* Adds the interpolated correction x of the next level to x of this one. */
static void pdi_coarse_fe_precond_prolong_nodes(const pd_coarse_fe_level *level, const pd_coarse_fe_level *next)
{
    for (int32_t v = 0; v < level->nodes; v++) {
        double at[PD_DIM];
        int32_t part = pdi_coarse_fe_precond_find_parent(level, next, v, at);
        for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS; a++) {
            double share = pdi_coarse_fe_precond_shape_function(a, at, -1);
            int32_t w = next->node[part * PDI_COARSE_FE_PRECOND_CORNERS + a];
            for (int d = 0; d < PD_DIM; d++) level->x[v * PD_DIM + d] += share * next->x[w * PD_DIM + d];
        }
    }
}

/* Position of a point in its box, 0 to 1 along each axis. */
static void pdi_coarse_fe_precond_box_position(const pd_coarse_fe_precond *s, int32_t i, double *at)
{
    const int32_t *box = s->level[0].box + s->element[i] * PD_DIM;
    for (int d = 0; d < PD_DIM; d++)
        at[d] = (s->body->position[(int64_t)i * PD_DIM + d] - s->lo[d]) / s->width - box[d];
}

PDI_FN void pdi_coarse_fe_precond_assemble(const pd_ctx *ctx, pd_coarse_fe_precond *s, const double *lambda,
                                           const double *mu, const double *hold)
{
    double width = s->width;
    pd_coarse_fe_level *first = &s->level[0];
    for (int k = 0; k < s->levels; k++) {
        pd_coarse_fe_level *level = &s->level[k];
        memset(level->lambda, 0, (size_t)level->elements * sizeof *level->lambda);
        memset(level->mu, 0, (size_t)level->elements * sizeof *level->mu);
        memset(level->spring, 0, (size_t)level->nodes * PD_DIM * sizeof *level->spring);
    }
    for (int32_t i = 0; i < s->body->count; i++) {
        double at[PD_DIM];
        pdi_coarse_fe_precond_box_position(s, i, at);
        first->lambda[s->element[i]] += s->body->volume[i] * lambda[i];
        first->mu[s->element[i]] += s->body->volume[i] * mu[i];
        for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS && hold; a++)
            for (int d = 0; d < PD_DIM; d++)
                first->spring[first->node[s->element[i] * PDI_COARSE_FE_PRECOND_CORNERS + a] * PD_DIM + d] +=
                    pdi_coarse_fe_precond_shape_function(a, at, -1) * hold[(int64_t)i * PD_DIM + d];
    }
    for (int k = 0; k < s->levels; k++, width *= 2.0) {
        pd_coarse_fe_level *level = &s->level[k], *next = &s->level[k + 1];
        pdi_coarse_fe_precond_assemble_level(ctx, level, width);
        if (k + 1 == s->levels) break;
        for (int32_t p = 0; p < level->elements; p++) {
            next->lambda[level->parent[p]] += level->lambda[p];
            next->mu[level->parent[p]] += level->mu[p];
        }
        pdi_coarse_fe_precond_restrict_nodes(level, next, level->spring, next->spring);
    }
}

/* ---- cycle ---- */

/* rest [PD_DIM] = b - A x [N] of node v. */
static inline void pdi_coarse_fe_precond_node_residual(const pd_coarse_fe_level *level, int32_t v, double *rest)
{
    for (int d = 0; d < PD_DIM; d++) rest[d] = level->b[v * PD_DIM + d];
    for (int32_t m = level->row[v]; m < level->row[v + 1]; m++) {
        const float *block = level->block + (int64_t)m * PDI_COARSE_FE_PRECOND_BLOCK;
        const double *x = level->x + level->column[m] * PD_DIM;
        for (int p = 0; p < PD_DIM; p++)
            for (int q = 0; q < PD_DIM; q++) rest[p] -= (double)block[p * PD_DIM + q] * x[q];
    }
}

/* Gauss-Seidel over the nodes of one colour, which are not adjacent, in x: the part of one thread. */
static void pdi_coarse_fe_precond_sweep_colour(const pd_coarse_fe_level *level, int colour)
{
    PDI_FOR_NOWAIT
    for (int32_t v = level->colour[colour]; v < level->colour[colour + 1]; v++) {
        const float *inverse = level->inverse + (int64_t)v * PDI_COARSE_FE_PRECOND_BLOCK;
        double rest[PD_DIM];
        pdi_coarse_fe_precond_node_residual(level, v, rest);
        for (int p = 0; p < PD_DIM; p++)
            for (int q = 0; q < PD_DIM; q++) level->x[v * PD_DIM + p] += (double)inverse[p * PD_DIM + q] * rest[q];
    }
}

/* Gauss-Seidel sweep colour by colour; back 1: in reverse order. */
static void pdi_coarse_fe_precond_sweep_all(const pd_ctx *ctx, const pd_coarse_fe_level *level, int back)
{
    int nt = pd_par_threads(ctx, (int64_t)level->blocks * PDI_COARSE_FE_PRECOND_BLOCK);
    for (int n = 0; n < PDI_COARSE_FE_PRECOND_CORNERS; n++)
        PDI_PARALLEL_CALL(nt,
                          pdi_coarse_fe_precond_sweep_colour(level, back ? PDI_COARSE_FE_PRECOND_CORNERS - 1 - n : n));
}

/* r = b - A x of a level: the part of one thread. */
static void pdi_coarse_fe_precond_compute_residual(const pd_coarse_fe_level *level)
{
    PDI_FOR_NOWAIT
    for (int32_t v = 0; v < level->nodes; v++) pdi_coarse_fe_precond_node_residual(level, v, level->r + v * PD_DIM);
}

/* V-cycle from level k on, from x = 0 for b to x, with one Gauss-Seidel sweep before and a reverse one after the coarse
 * correction; on the coarsest level 4 symmetric sweeps. r of the level, and x, b and r of coarser ones are
 * overwritten. */
static void pdi_coarse_fe_precond_v_cycle(const pd_ctx *ctx, const pd_coarse_fe_precond *s, int k)
{
    const pd_coarse_fe_level *level = &s->level[k], *next = level + 1;
    int nt = pd_par_threads(ctx, (int64_t)level->blocks * PDI_COARSE_FE_PRECOND_BLOCK);
    memset(level->x, 0, (size_t)level->nodes * PD_DIM * sizeof *level->x);
    pdi_coarse_fe_precond_sweep_all(ctx, level, 0);
    if (k + 1 == s->levels) {
        for (int n = 1; n < PDI_COARSE_FE_PRECOND_COARSEST_SWEEPS; n++) {
            pdi_coarse_fe_precond_sweep_all(ctx, level, 1);
            pdi_coarse_fe_precond_sweep_all(ctx, level, 0);
        }
    } else {
        PDI_PARALLEL_CALL(nt, pdi_coarse_fe_precond_compute_residual(level));
        memset(next->b, 0, (size_t)next->nodes * PD_DIM * sizeof *next->b);
        pdi_coarse_fe_precond_restrict_nodes(level, next, level->r, next->b);
        pdi_coarse_fe_precond_v_cycle(ctx, s, k + 1);
        pdi_coarse_fe_precond_prolong_nodes(level, next);
    }
    pdi_coarse_fe_precond_sweep_all(ctx, level, 1);
}

/* Sums forces f [count][PD_DIM] [N] of points to the nodes of level 0 by shape functions, into its b, which is
 * overwritten, as is nodal_force. */
static void pdi_coarse_fe_precond_restrict_points(const pd_ctx *ctx, const pd_coarse_fe_precond *s, const double *f)
{
    const pd_coarse_fe_level *level = &s->level[0];
    int nt = pd_par_threads(ctx, (int64_t)s->body->count * 20);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < level->elements; p++) {
        double *sum = s->nodal_force + (int64_t)p * PDI_COARSE_FE_PRECOND_CORNERS * PD_DIM, at[PD_DIM];
        for (int k = 0; k < PDI_COARSE_FE_PRECOND_CORNERS * PD_DIM; k++) sum[k] = 0.0;
        for (int32_t n = s->first_point[p]; n < s->first_point[p + 1]; n++) {
            pdi_coarse_fe_precond_box_position(s, s->point[n], at);
            for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS; a++)
                for (int d = 0; d < PD_DIM; d++)
                    sum[a * PD_DIM + d] +=
                        pdi_coarse_fe_precond_shape_function(a, at, -1) * f[(int64_t)s->point[n] * PD_DIM + d];
        }
    }
    for (int32_t v = 0; v < level->nodes; v++)
        for (int d = 0; d < PD_DIM; d++) {
            double sum = 0.0;
            for (int32_t k = level->first[v]; k < level->first[v + 1]; k++)
                sum += s->nodal_force[(int64_t)level->corner[k] * PD_DIM + d];
            level->b[v * PD_DIM + d] = sum;
        }
}

PDI_FN void pdi_coarse_fe_precond_apply(const pd_ctx *ctx, pd_coarse_fe_precond *s, const double *f, double *u)
{
    const pd_coarse_fe_level *level = &s->level[0];
    int nt = pd_par_threads(ctx, (int64_t)s->body->count * 20);
    (void)nt;
    pdi_coarse_fe_precond_restrict_points(ctx, s, f);
    pdi_coarse_fe_precond_v_cycle(ctx, s, 0);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < s->body->count; i++) {
        double at[PD_DIM];
        pdi_coarse_fe_precond_box_position(s, i, at);
        for (int a = 0; a < PDI_COARSE_FE_PRECOND_CORNERS; a++) {
            double share = pdi_coarse_fe_precond_shape_function(a, at, -1);
            const double *x = level->x + level->node[s->element[i] * PDI_COARSE_FE_PRECOND_CORNERS + a] * PD_DIM;
            for (int d = 0; d < PD_DIM; d++) u[(int64_t)i * PD_DIM + d] += share * x[d];
        }
    }
}

#undef PDI_COARSE_FE_PRECOND_MAX_BOXES
#undef PDI_COARSE_FE_PRECOND_COARSEST_SWEEPS
