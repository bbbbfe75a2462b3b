/* csr: see csr.h */
#include "lattice/csr.h"
#include "lattice/bond_diffusivity.h"
#include <string.h>

/* Working arrays while a matrix is assembled. */
typedef struct pdi_csr_work {
    const pd_bonds *bonds;
    const pd_csr_desc *desc;
    pd_csr *csr;
    int32_t *source;  /* [total] source node of an image; of others the node itself */
    int8_t *sign;     /* [total] sign of the component at an image */
    int32_t *column;  /* [count + 1] entries of one row, ascending: given nodes as -1 - node, then columns */
    double *weight;   /* [count + 1] [unit of the operator] */
    int32_t capacity; /* capacity of a row: bonds and the diagonal */
    int32_t size;     /* entries of the row so far */
} pdi_csr_work;

/* PD_ERR_ARGUMENT: unknown operator, axis out of range, or, for PD_CSR_DIFFUSE, a diffusivity that is missing, or
 * negative or not below 1e300 at a fluid, inlet or outlet node. */
static pd_status pdi_csr_check_input(pd_ctx *ctx, const pd_bonds *bonds, const pd_csr_desc *d)
{
    int along = d->op == PD_CSR_GRADIENT || d->op == PD_CSR_DIVERGENCE;
    if (d->op < PD_CSR_LAPLACIAN || d->op > PD_CSR_DIVERGENCE)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "csr", "no operator has the number %d", (int)d->op);
    if (along && (d->axis < 0 || d->axis >= PD_DIM))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "csr", "the axis %d, expected one from 0 to %d", d->axis, PD_DIM - 1);
    if (d->op != PD_CSR_DIFFUSE) return PD_OK;
    if (!d->diffusivity) return pd_fail(ctx, PD_ERR_ARGUMENT, "csr", "there is no diffusivity");
    for (int32_t i = 0; i < bonds->grid->total; i++) {
        uint8_t kind = bonds->grid->kind[i];
        if (kind != PD_FLUID && kind != PD_INLET && kind != PD_OUTLET) continue;
        if (!(d->diffusivity[i] >= 0.0 && d->diffusivity[i] < 1e300))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "csr", "the diffusivity of node %d is %g m2/s, expected one >= 0",
                           (int)i, d->diffusivity[i]);
    }
    return PD_OK;
}

/* Adds `weight` to the row entry of the value at far end `far` (a node or ghost of the lattice), and inserts the entry
 * in ascending order when it is new. An image counts as its source, with the sign of the component. */
static void pdi_csr_add_entry(pdi_csr_work *w, int32_t far, double weight)
{
    int32_t node = w->source[far], at = w->size;
    int32_t column = w->csr->row_of_node[node] >= 0 ? w->csr->row_of_node[node] : -1 - node;
    if (w->sign[far] < 0) weight = -weight;
    while (at > 0 && w->column[at - 1] > column) at--;
    if (at > 0 && w->column[at - 1] == column) {
        w->weight[at - 1] += weight;
        return;
    }
    memmove(w->column + at + 1, w->column + at, (size_t)(w->size - at) * sizeof *w->column);
    memmove(w->weight + at + 1, w->weight + at, (size_t)(w->size - at) * sizeof *w->weight);
    w->column[at] = column;
    w->weight[at] = weight;
    w->size++;
}

/* Returns the weight [unit of the operator] of the value at the far end of the open bond k of node i, 0 for the
 * gradient at an inlet ghost of a truncated family. *diagonal: that of the value at node i itself in this bond, the
 * negative of it; for the divergence the same weight. Images take the diffusivity of their source. */
static double pdi_csr_compute_weight(const pdi_csr_work *w, int32_t i, int k, double *diagonal)
{
    const pd_bonds *b = w->bonds;
    const pd_stencil *s = b->stencil;
    int32_t r = b->row_of_node[i];
    double weight = 0.0, buffer[PD_DIM * PD_DIM];
    const double *inverse = NULL;
    int axis = w->desc->axis;
    switch (w->desc->op) {
    case PD_CSR_LAPLACIAN: weight = pdi_bond_get_laplacian_weights(b, i)[k]; break;
    case PD_CSR_DIFFUSE:
        weight = pdi_bond_get_laplacian_weights(b, i)[k] *
                 pdi_bond_diffusivity_harmonic_mean(w->desc->diffusivity[i],
                                                    w->desc->diffusivity[w->source[i + b->paths.shift[k]]]);
        break;
    case PD_CSR_GRADIENT: /* eq. 1.4; at truncated families eq. 2.9 */
        weight = r < 0 ? s->gradient_weight[k * PD_DIM + axis] : 0.0;
        if (r >= 0 && b->grid->kind[i + b->paths.shift[k]] == PD_INLET) break;
        if (r >= 0) inverse = pdi_bond_get_inverse_moment(b, r, buffer) + axis * PD_DIM;
        for (int e = 0; e < PD_DIM && inverse; e++) weight += inverse[e] * s->base_weight[k] * s->xi[k * PD_DIM + e];
        break;
    case PD_CSR_DIVERGENCE: /* eq. 3.2 */
        weight = s->gradient_weight[k * PD_DIM + axis] * pdi_bond_get_flux_factor(b, i, k);
        *diagonal = weight;
        return weight;
    }
    *diagonal = -weight;
    return weight;
}

/* Assembles the row of node i into column and weight [size] of w; replaces the row before. Blocked bonds and weights of
 * 0 are left out. The diagonal is always there: 0 at full families for the gradient and the planar divergence. */
static void pdi_csr_assemble_row(pdi_csr_work *w, int32_t i)
{
    const pd_bonds *b = w->bonds;
    int32_t r = b->row_of_node[i];
    double sum = 0.0, diagonal;
    w->size = 0;
    for (int k = 0; k < b->stencil->count; k++) {
        if (r >= 0 && !pdi_bond_is_open(b, r, k)) continue;
        double weight = pdi_csr_compute_weight(w, i, k, &diagonal);
        sum += diagonal;
        if (weight != 0.0) pdi_csr_add_entry(w, i + b->paths.shift[k], weight);
    }
    /* the opposite bonds of a full family cancel to the last bit in op.h */
    if (r < 0 && (w->desc->op == PD_CSR_GRADIENT || (w->desc->op == PD_CSR_DIVERGENCE && !b->axisym.flux_factor)))
        sum = 0.0;
    pdi_csr_add_entry(w, i, sum);
}

/* Assembles all rows into the matrix; count 1: sets only row_begin and prescribed_begin, whose first entries are 0. */
static void pdi_csr_assemble_rows(pdi_csr_work *w, int count)
{
    pd_csr *c = w->csr;
    for (int32_t r = 0; r < c->rows; r++) {
        int32_t given = 0;
        pdi_csr_assemble_row(w, c->node[r]);
        while (given < w->size && w->column[given] < 0) given++;
        if (count) {
            c->prescribed_begin[r + 1] = c->prescribed_begin[r] + given;
            c->row_begin[r + 1] = c->row_begin[r] + w->size - given;
            continue;
        }
        for (int32_t k = 0; k < given; k++) {
            c->prescribed[c->prescribed_begin[r] + k] = -1 - w->column[k];
            c->prescribed_weight[c->prescribed_begin[r] + k] = w->weight[k];
        }
        memcpy(c->column + c->row_begin[r], w->column + given, (size_t)(w->size - given) * sizeof *c->column);
        memcpy(c->weight + c->row_begin[r], w->weight + given, (size_t)(w->size - given) * sizeof *c->weight);
    }
}

/* 1: node i is an unknown: fluid and in the set. */
static int pdi_csr_is_unknown(const pd_bonds *bonds, const pd_csr_desc *desc, int32_t i)
{
    return bonds->grid->kind[i] == PD_FLUID && (!desc->mask || desc->mask[i]);
}

/* Numbers the unknowns in the order of nodes, and allocates the arrays by row: sets total, rows, node and row_of_node.
 * PD_ERR_GEOMETRY: no fluid node is in the set. */
static pd_status pdi_csr_set_unknowns(pd_ctx *ctx, const pd_bonds *bonds, const pd_csr_desc *desc, pd_csr *csr)
{
    csr->total = bonds->grid->total;
    for (int32_t i = 0; i < csr->total; i++) csr->rows += pdi_csr_is_unknown(bonds, desc, i);
    if (!csr->rows) return pd_fail(ctx, PD_ERR_GEOMETRY, "csr", "no fluid node is of the set");
    PD_TRY(PD_NEW(ctx, "csr", csr->rows, csr->node));
    PD_TRY(PD_NEW(ctx, "csr", csr->total, csr->row_of_node));
    PD_TRY(PD_NEW(ctx, "csr", csr->rows + 1, csr->row_begin));
    PD_TRY(PD_NEW(ctx, "csr", csr->rows + 1, csr->prescribed_begin));
    for (int32_t i = 0, r = 0; i < csr->total; i++) {
        csr->row_of_node[i] = pdi_csr_is_unknown(bonds, desc, i) ? r : -1;
        if (csr->row_of_node[i] >= 0) csr->node[r++] = i;
    }
    return PD_OK;
}

/* Allocates and builds the matrix w->csr and the working arrays of w: sources and signs of images (odd in the
 * divergence where the mirrored axis is the component), lengths of rows, then entries. The caller frees the working
 * arrays, and on failure the matrix. PD_ERR_GEOMETRY: no fluid node is in the set. */
static pd_status pdi_csr_build_inner(pd_ctx *ctx, pdi_csr_work *w)
{
    const pd_ghosts *g = &w->bonds->ghosts;
    pd_csr *c = w->csr;
    PD_TRY(pdi_csr_set_unknowns(ctx, w->bonds, w->desc, c));
    PD_TRY(PD_NEW(ctx, "csr", c->total, w->source));
    PD_TRY(PD_NEW(ctx, "csr", c->total, w->sign));
    PD_TRY(PD_NEW(ctx, "csr", w->capacity, w->column));
    PD_TRY(PD_NEW(ctx, "csr", w->capacity, w->weight));
    for (int32_t i = 0; i < c->total; i++) w->source[i] = i;
    for (int32_t k = 0; k < g->images_end; k++) {
        int odd = w->desc->op == PD_CSR_DIVERGENCE && (g->sign_flips[k] >> w->desc->axis & 1);
        w->source[g->node[k]] = g->source[k];
        w->sign[g->node[k]] = (int8_t)(odd ? -1 : 1);
    }
    pdi_csr_assemble_rows(w, 1);
    PD_TRY(PD_NEW(ctx, "csr", c->row_begin[c->rows], c->column));
    PD_TRY(PD_NEW(ctx, "csr", c->row_begin[c->rows], c->weight));
    PD_TRY(PD_NEW(ctx, "csr", c->prescribed_begin[c->rows], c->prescribed));
    PD_TRY(PD_NEW(ctx, "csr", c->prescribed_begin[c->rows], c->prescribed_weight));
    pdi_csr_assemble_rows(w, 0);
    return PD_OK;
}

pd_status pd_csr_build(pd_ctx *ctx, const pd_bonds *bonds, const pd_csr_desc *desc, pd_csr *csr)
{
    pdi_csr_work w;
    memset(csr, 0, sizeof *csr);
    memset(&w, 0, sizeof w);
    PD_TRY(pdi_csr_check_input(ctx, bonds, desc));
    w.bonds = bonds;
    w.desc = desc;
    w.csr = csr;
    w.capacity = bonds->stencil->count + 1;
    pd_status status = pdi_csr_build_inner(ctx, &w);
    PD_DELETE(ctx, bonds->grid->total, w.source);
    PD_DELETE(ctx, bonds->grid->total, w.sign);
    PD_DELETE(ctx, w.capacity, w.column);
    PD_DELETE(ctx, w.capacity, w.weight);
    if (status < 0) pd_csr_free(ctx, csr);
    return status;
}

void pd_csr_apply(const pd_csr *csr, const double *x, const double *f, double *y)
{
    for (int32_t r = 0; r < csr->rows; r++) {
        double sum = 0.0;
        for (int64_t k = csr->row_begin[r]; k < csr->row_begin[r + 1]; k++) sum += csr->weight[k] * x[csr->column[k]];
        for (int64_t k = csr->prescribed_begin[r]; k < csr->prescribed_begin[r + 1] && f; k++)
            sum += csr->prescribed_weight[k] * f[csr->prescribed[k]];
        y[r] = sum;
    }
}

void pd_csr_free(pd_ctx *ctx, pd_csr *csr)
{
    int64_t entries = csr->row_begin ? csr->row_begin[csr->rows] : 0,
            given = csr->prescribed_begin ? csr->prescribed_begin[csr->rows] : 0;
    PD_DELETE(ctx, entries, csr->column);
    PD_DELETE(ctx, entries, csr->weight);
    PD_DELETE(ctx, given, csr->prescribed);
    PD_DELETE(ctx, given, csr->prescribed_weight);
    PD_DELETE(ctx, csr->rows, csr->node);
    PD_DELETE(ctx, csr->total, csr->row_of_node);
    PD_DELETE(ctx, csr->rows + 1, csr->row_begin);
    PD_DELETE(ctx, csr->rows + 1, csr->prescribed_begin);
    memset(csr, 0, sizeof *csr);
}
