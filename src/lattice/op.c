/* op: see op.h
 *
 * Loops work on up to PDI_CHUNK neighbours along axis 0 at once, bond by bond, so that the inner loops are vector
 * loops: nodes with full families share the weights (opposite bonds are paired), rows mask their blocked bonds.
 */
#include "lattice/op.h"
#include "core/vec.h"
#include "core/par.h"
#include "lattice/bond_diffusivity.h"
#include "lattice/line_laplacian.h"
#include <string.h>

/* Body of an operator: `count` nodes with full families from node `first`, or rows from row `first`, with consecutive
 * nodes. */
typedef struct pdi_op_operands pdi_op_operands;
typedef void (*pdi_op_chunk_fn)(const pdi_op_operands *w, int32_t first, int count);

/* Operands of one operator. */
struct pdi_op_operands {
    const pd_bonds *bonds;
    int32_t total;
    const double *f, *diffusivity; /* [total] field [any unit]; diffusivity [m2/s] or NULL */
    double *out;         /* result */
    pdi_op_chunk_fn full_family, truncated_family; /* bodies for full and for truncated families */
    int any_length;      /* 1: `whole` takes ranges of any length */
};

/* Body of the loop over ranges: calls the body for full (row -1) or truncated families in pieces of up to PDI_CHUNK
 * nodes. */
static void pdi_op_apply_range(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pdi_op_operands *w = (const pdi_op_operands *)user;
    int count;
    if (row < 0 && w->any_length) {
        w->full_family(w, i, length);
        return;
    }
    for (int32_t at = 0; at < length; at += count) {
        count = pdi_node_loop_next_chunk(length, PDI_CHUNK, &at);
        if (row < 0) w->full_family(w, i + at, count);
        else w->truncated_family(w, row + at, count);
    }
}

/* Evaluates an operator at all fluid nodes, with threads; whole, cut: its bodies for full and for truncated families.
 */
static void pdi_op_apply_all(const pd_ctx *ctx, pdi_op_operands *w, pdi_op_chunk_fn whole, pdi_op_chunk_fn cut)
{
    w->full_family = whole;
    w->truncated_family = cut;
    pdi_node_loop_by_ranges(ctx, w->bonds, w->bonds->grid->fluid_count * w->bonds->stencil->count * 4, 0,
                            pdi_op_apply_range, w);
}

/* Sets the operands of an operator but for its bodies; d: diffusivity [total] or NULL. any_length becomes 0. */
static void pdi_op_init_operands(const pd_bonds *bonds, const double *f, const double *d, double *out,
                                 pdi_op_operands *w)
{
    w->bonds = bonds;
    w->total = bonds->grid->total;
    w->f = f;
    w->diffusivity = d;
    w->out = out;
    w->any_length = 0;
}

/* ---- gradient: G f_i = sum g (f_j - f_i); the sum of g over a full family is zero (eq. 1.4) ---- */

/* slope [PD_DIM][count] = gradient of f at `count` nodes with full families from node i (eq. 1.4); opposite bonds are
 * paired. */
static void pdi_op_compute_gradient_full(const pd_bonds *bonds, const double *f, int32_t i, int count,
                                         double slope[PD_DIM][PDI_CHUNK])
{
    const pd_stencil *s = bonds->stencil;
    memset(slope, 0, PD_DIM * sizeof *slope);
    for (int k = 0; k < s->count / 2; k++) {
        int32_t shift = bonds->paths.shift[k];
        const double *far = f + i + shift, *back = f + i - shift, *g = s->gradient_weight + k * PD_DIM;
        for (int d = 0; d < PD_DIM; d++)
            for (int b = 0; b < count; b++) slope[d][b] += g[d] * (far[b] - back[b]);
    }
}

/* slope [PD_DIM][count] = gradient K^-1 sum w xi (f_j - f_i) at `count` rows from row r, whose nodes are consecutive,
 * with the moments K of the open bonds (eq. 2.9). Inlet ghosts are left out; rows with bonds to them come one by one. 0
 * where K^-1 is 0. */
static void pdi_op_compute_gradient_truncated(const pd_bonds *bonds, const double *field, int32_t r, int count,
                                              double slope[PD_DIM][PDI_CHUNK])
{
    const pd_stencil *s = bonds->stencil;
    int32_t i = bonds->node[r];
    double sum[PD_DIM][PDI_CHUNK], open[PDI_CHUNK];
    memset(sum, 0, sizeof sum);
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    for (int k = 0; k < s->count; k++) {
        const double *far = field + i + bonds->paths.shift[k], *f = field + i, *xi = s->xi + k * PD_DIM;
        double base = s->base_weight[k];
        pdi_bond_openness which = pdi_bond_find_nodes_open(bonds, r, k, count, &gate, open);
        if (which == PDI_BOND_OPEN_NONE) continue;
        if (r >= bonds->rows_without_inlet && bonds->grid->kind[i + bonds->paths.shift[k]] == PD_INLET) continue;
        for (int b = 0; b < count; b++) {
            double difference = which == PDI_BOND_OPEN_ALL || open[b] > 0.0 ? base * (far[b] - f[b]) : 0.0;
            for (int d = 0; d < PD_DIM; d++) sum[d][b] += difference * xi[d];
        }
    }
    for (int b = 0; b < count; b++) {
        double buffer[PD_DIM * PD_DIM];
        const double *inverse = pdi_bond_get_inverse_moment(bonds, r + b, buffer);
        for (int d = 0; d < PD_DIM; d++) {
            double value = 0.0;
            for (int e = 0; e < PD_DIM; e++) value += inverse[d * PD_DIM + e] * sum[e][b];
            slope[d][b] = value;
        }
    }
}

/* Writes the gradients of `count` nodes from node i to the result [PD_DIM][total]. */
static void pdi_op_set_gradient(const pdi_op_operands *w, int32_t i, int count, double slope[PD_DIM][PDI_CHUNK])
{
    for (int d = 0; d < PD_DIM; d++)
        memcpy(w->out + (int64_t)d * w->total + i, slope[d], (size_t)count * sizeof(double));
}

/* Gradient at `count` nodes with full families from node i. */
static void pdi_op_gradient_full(const pdi_op_operands *w, int32_t i, int count)
{
    double slope[PD_DIM][PDI_CHUNK];
    pdi_op_compute_gradient_full(w->bonds, w->f, i, count, slope);
    pdi_op_set_gradient(w, i, count, slope);
}

/* Gradient at `count` rows (truncated families) from row r. */
static void pdi_op_gradient_truncated(const pdi_op_operands *w, int32_t r, int count)
{
    double slope[PD_DIM][PDI_CHUNK];
    pdi_op_compute_gradient_truncated(w->bonds, w->f, r, count, slope);
    pdi_op_set_gradient(w, w->bonds->node[r], count, slope);
}

void pd_op_gradient(const pd_ctx *ctx, const pd_bonds *bonds, const double *f, double *grad)
{
    pdi_op_operands w;
    pdi_op_init_operands(bonds, f, NULL, grad, &w);
    pdi_op_apply_all(ctx, &w, pdi_op_gradient_full, pdi_op_gradient_truncated);
}

/* ---- divergence: D u_i = sum g.(u_i + u_j), antisymmetric in i and j (eq. 3.2) ---- */

/* Divergence at the nodes i .. i+count-1, which own the rows from r (-1: full families), bond by bond. */
static void pdi_op_divergence_bonds(const pdi_op_operands *w, int32_t i, int32_t r, int count)
{
    const pd_bonds *bonds = w->bonds;
    const pd_stencil *s = bonds->stencil;
    double sum[PDI_CHUNK], open[PDI_CHUNK];
    memset(sum, 0, sizeof sum);
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    for (int k = 0; k < s->count; k++) {
        pdi_bond_openness which = pdi_bond_find_nodes_open(bonds, r, k, count, &gate, open);
        if (which == PDI_BOND_OPEN_NONE) continue;
        for (int d = 0; d < PD_DIM; d++) {
            const double *u = w->f + (int64_t)d * w->total + i, *far = u + bonds->paths.shift[k];
            double g = s->gradient_weight[k * PD_DIM + d] * pdi_bond_get_flux_factor(bonds, i, k);
            for (int b = 0; b < count; b++)
                sum[b] += which == PDI_BOND_OPEN_ALL || open[b] > 0.0 ? g * (u[b] + far[b]) : 0.0;
        }
    }
    memcpy(w->out + i, sum, (size_t)count * sizeof(double));
}

/* Divergence at nodes with full families: opposite bonds are paired; on an axisymmetric grid bond by bond. */
static void pdi_op_divergence_full(const pdi_op_operands *w, int32_t i, int count)
{
    const pd_stencil *s = w->bonds->stencil;
    double sum[PDI_CHUNK];
    if (w->bonds->axisym.flux_factor) {
        pdi_op_divergence_bonds(w, i, -1, count);
        return;
    }
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < s->count / 2; k++)
        for (int d = 0; d < PD_DIM; d++) {
            const double *u = w->f + (int64_t)d * w->total + i;
            const double *far = u + w->bonds->paths.shift[k], *back = u - w->bonds->paths.shift[k];
            double g = s->gradient_weight[k * PD_DIM + d];
            for (int b = 0; b < count; b++) sum[b] += g * (far[b] - back[b]);
        }
    memcpy(w->out + i, sum, (size_t)count * sizeof(double));
}

/* Divergence at `count` rows (truncated families) from row r. */
static void pdi_op_divergence_truncated(const pdi_op_operands *w, int32_t r, int count)
{
    pdi_op_divergence_bonds(w, w->bonds->node[r], r, count);
}

void pd_op_divergence(const pd_ctx *ctx, const pd_bonds *bonds, const double *u, double *div)
{
    pdi_op_operands w;
    pdi_op_init_operands(bonds, u, NULL, div, &w);
    pdi_op_apply_all(ctx, &w, pdi_op_divergence_full, pdi_op_divergence_truncated);
}

/* ---- Laplacian: L f_i = sum a (f_j - f_i), symmetric weights (eq. 1.3) ---- */

/* Laplacian at the nodes i .. i+count-1, which own the rows from r (-1: full families), bond by bond. */
static void pdi_op_laplacian_bonds(const pdi_op_operands *w, int32_t i, int32_t r, int count)
{
    const pd_bonds *bonds = w->bonds;
    const double *f = w->f + i, *lap = pdi_bond_get_laplacian_weights(bonds, i);
    double sum[PDI_CHUNK], open[PDI_CHUNK];
    memset(sum, 0, sizeof sum);
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    for (int k = 0; k < bonds->stencil->count; k++) {
        const double *far = f + bonds->paths.shift[k];
        double a = lap[k];
        pdi_bond_openness which = pdi_bond_find_nodes_open(bonds, r, k, count, &gate, open);
        if (which == PDI_BOND_OPEN_NONE) continue;
        for (int b = 0; b < count; b++)
            sum[b] += which == PDI_BOND_OPEN_ALL || open[b] > 0.0 ? a * (far[b] - f[b]) : 0.0;
    }
    memcpy(w->out + i, sum, (size_t)count * sizeof(double));
}

/* Laplacian at nodes with full families of a planar grid, by grid lines (lattice/line_laplacian). */
static void pdi_op_laplacian_full(const pdi_op_operands *w, int32_t i, int count)
{
    pdi_line_laplacian_data lines;
    lines.grid = w->bonds->grid;
    lines.stencil = w->bonds->stencil;
    lines.shift = w->bonds->line_shift;
    pdi_line_laplacian_apply(&lines, w->f, i, count, w->out + i);
}

/* Laplacian at nodes with full families of an axisymmetric grid, bond by bond. */
static void pdi_op_laplacian_axisymmetric(const pdi_op_operands *w, int32_t i, int count)
{
    pdi_op_laplacian_bonds(w, i, -1, count);
}

/* Laplacian at `count` rows (truncated families) from row r. */
static void pdi_op_laplacian_truncated(const pdi_op_operands *w, int32_t r, int count)
{
    pdi_op_laplacian_bonds(w, w->bonds->node[r], r, count);
}

void pd_op_laplacian(const pd_ctx *ctx, const pd_bonds *bonds, const double *f, double *lap)
{
    pdi_op_operands w;
    pdi_op_init_operands(bonds, f, NULL, lap, &w);
    w.any_length = !bonds->axisym.laplacian_weight;
    pdi_op_apply_all(ctx, &w, bonds->axisym.laplacian_weight ? pdi_op_laplacian_axisymmetric : pdi_op_laplacian_full,
                     pdi_op_laplacian_truncated);
}

/* ---- diffusion: sum D_ij a (f_j - f_i), D_ij = 2 D_i D_j / (D_i + D_j) (eq. 6.2) ---- */

/* Diffusion at the nodes i .. i+count-1, which own the rows from r (-1: full families), bond by bond (eq. 6.2). */
static void pdi_op_diffuse_bonds(const pdi_op_operands *w, int32_t i, int32_t r, int count)
{
    const pd_bonds *bonds = w->bonds;
    const double *f = w->f + i, *d = w->diffusivity + i, *lap = pdi_bond_get_laplacian_weights(bonds, i);
    double sum[PDI_CHUNK], open[PDI_CHUNK];
    memset(sum, 0, sizeof sum);
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    for (int k = 0; k < bonds->stencil->count; k++) {
        const double *far = f + bonds->paths.shift[k], *d_far = d + bonds->paths.shift[k];
        double a = lap[k];
        pdi_bond_openness which = pdi_bond_find_nodes_open(bonds, r, k, count, &gate, open);
        if (which == PDI_BOND_OPEN_NONE) continue;
        for (int b = 0; b < count; b++)
            sum[b] += which == PDI_BOND_OPEN_ALL || open[b] > 0.0
                          ? a * pdi_bond_diffusivity_harmonic_mean(d[b], d_far[b]) * (far[b] - f[b])
                          : 0.0;
    }
    memcpy(w->out + i, sum, (size_t)count * sizeof(double));
}

/* Diffusion at `count` nodes with full families from node i. */
static void pdi_op_diffuse_full(const pdi_op_operands *w, int32_t i, int count)
{
    pdi_op_diffuse_bonds(w, i, -1, count);
}

/* Diffusion at `count` rows (truncated families) from row r. */
static void pdi_op_diffuse_truncated(const pdi_op_operands *w, int32_t r, int count)
{
    pdi_op_diffuse_bonds(w, w->bonds->node[r], r, count);
}

pd_status pd_op_diffusion(pd_ctx *ctx, const pd_bonds *bonds, const double *diffusivity, const double *f, double *out)
{
    const pd_grid *grid = bonds->grid;
    double *filled = NULL;
    pdi_op_operands w;
    for (int32_t node = 0; node < grid->total; node++)
        if (pdi_grid_is_open(grid->kind[node]) && grid->kind[node] != PD_IMAGE &&
            !(diffusivity[node] >= 0.0 && diffusivity[node] < 1e300))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "op", "the diffusivity of node %d is %g m2/s, expected one >= 0",
                           (int)node, diffusivity[node]);
    if (bonds->ghosts.images_end) {
        PD_TRY(PD_NEW(ctx, "op", grid->total, filled));
        memcpy(filled, diffusivity, (size_t)grid->total * sizeof *filled);
        pd_ghosts_set_scalar(&bonds->ghosts, filled);
    }
    pdi_op_init_operands(bonds, f, filled ? filled : diffusivity, out, &w);
    pdi_op_apply_all(ctx, &w, pdi_op_diffuse_full, pdi_op_diffuse_truncated);
    PD_DELETE(ctx, grid->total, filled);
    return PD_OK;
}
