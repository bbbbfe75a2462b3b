/* op: see op.h
 *
 * Nodes with whole families are worked on in blocks of neighbours along axis 0, bond by bond, so that the inner loops
 * are plain vectors with shared weights; each block function is inlined twice, with the length a constant for full
 * blocks. Opposite bonds go together: they share their weight. Nodes that own a row go one by one.
 */
#include "op.h"
#include "par.h"
#include "vec.h"
#include <string.h>

#define PDI_OP_BLOCK 8

/* The operands of one sweep. */
typedef struct pdi_op_sweep {
    const pd_bonds *bonds;
    int32_t total;
    const double *f, *d; /* field; diffusivity or NULL */
    double *out;
} pdi_op_sweep;

typedef void (*pdi_op_block_fn)(const pdi_op_sweep *w, int32_t first, int32_t length);
typedef void (*pdi_op_row_fn)(const pdi_op_sweep *w, int32_t row);

static void pdi_op_apply(const pd_ctx *ctx, const pdi_op_sweep *w, pdi_op_block_fn run, pdi_op_row_fn row)
{
    const pd_bonds *bonds = w->bonds;
    int nt = pdi_par_threads(ctx, bonds->grid->fluid_count * bonds->stencil->count * 4);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->runs; r++) run(w, bonds->run_first[r], bonds->run_length[r]);
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++) row(w, r);
}

static void pdi_op_sweep_init(const pd_bonds *bonds, const double *f, const double *d, double *out, pdi_op_sweep *w)
{
    w->bonds = bonds;
    w->total = bonds->grid->total;
    w->f = f;
    w->d = d;
    w->out = out;
}

/* ---- gradient: G f_i = sum g (f_j - f_i); the sum of g over a whole family is zero (eq. 2.4) ---- */

static inline void pdi_op_gradient_block(const pdi_op_sweep *w, int32_t i, int count)
{
    const pd_stencil *s = w->bonds->stencil;
    double sum[PD_DIM][PDI_OP_BLOCK];
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < s->count / 2; k++) {
        const double *far = w->f + i + w->bonds->shift[k], *back = w->f + i - w->bonds->shift[k];
        const double *g = s->grad + k * PD_DIM;
        for (int d = 0; d < PD_DIM; d++)
            for (int b = 0; b < count; b++) sum[d][b] += g[d] * (far[b] - back[b]);
    }
    for (int d = 0; d < PD_DIM; d++)
        for (int b = 0; b < count; b++) w->out[(int64_t)d * w->total + i + b] = sum[d][b];
}

static void pdi_op_gradient_run(const pdi_op_sweep *w, int32_t first, int32_t length)
{
    int32_t at = 0;
    for (; at + PDI_OP_BLOCK <= length; at += PDI_OP_BLOCK) pdi_op_gradient_block(w, first + at, PDI_OP_BLOCK);
    if (at < length) pdi_op_gradient_block(w, first + at, (int)(length - at));
}

/* K^-1 sum w xi (f_j - f_i) with the moments K of the open bonds (eq. 3.5). */
static void pdi_op_gradient_row(const pdi_op_sweep *w, int32_t r)
{
    const pd_bonds *bonds = w->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t i = bonds->node[r];
    double sum[PD_DIM];
    memset(sum, 0, sizeof sum);
    for (int o = 0; o < bonds->open[r]; o++) {
        int k = bonds->bond[(int64_t)r * s->count + o];
        int32_t j = i + bonds->shift[k];
        if (bonds->grid->kind[j] == PD_INLET) continue;
        double difference = s->base[k] * (w->f[j] - w->f[i]);
        for (int d = 0; d < PD_DIM; d++) sum[d] += difference * s->xi[k * PD_DIM + d];
    }
    const double *inverse = bonds->moment + (int64_t)r * PD_DIM * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) w->out[(int64_t)d * w->total + i] = pdi_vec_dot(inverse + d * PD_DIM, sum);
}

void pd_op_gradient(const pd_ctx *ctx, const pd_bonds *bonds, const double *f, double *grad)
{
    pdi_op_sweep w;
    pdi_op_sweep_init(bonds, f, NULL, grad, &w);
    pdi_op_apply(ctx, &w, pdi_op_gradient_run, pdi_op_gradient_row);
}

/* ---- divergence: D u_i = sum g.(u_i + u_j), antisymmetric in i and j (eq. 4.2) ---- */

static inline void pdi_op_divergence_block(const pdi_op_sweep *w, int32_t i, int count)
{
    const pd_stencil *s = w->bonds->stencil;
    double sum[PDI_OP_BLOCK];
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < s->count / 2; k++)
        for (int d = 0; d < PD_DIM; d++) {
            const double *u = w->f + (int64_t)d * w->total + i, g = s->grad[k * PD_DIM + d];
            const double *far = u + w->bonds->shift[k], *back = u - w->bonds->shift[k];
            for (int b = 0; b < count; b++) sum[b] += g * (far[b] - back[b]);
        }
    for (int b = 0; b < count; b++) w->out[i + b] = sum[b];
}

static void pdi_op_divergence_run(const pdi_op_sweep *w, int32_t first, int32_t length)
{
    int32_t at = 0;
    for (; at + PDI_OP_BLOCK <= length; at += PDI_OP_BLOCK) pdi_op_divergence_block(w, first + at, PDI_OP_BLOCK);
    if (at < length) pdi_op_divergence_block(w, first + at, (int)(length - at));
}

static void pdi_op_divergence_row(const pdi_op_sweep *w, int32_t r)
{
    const pd_bonds *bonds = w->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t i = bonds->node[r];
    double sum = 0.0;
    for (int o = 0; o < bonds->open[r]; o++) {
        int k = bonds->bond[(int64_t)r * s->count + o];
        int32_t j = i + bonds->shift[k];
        for (int d = 0; d < PD_DIM; d++)
            sum += s->grad[k * PD_DIM + d] * (w->f[(int64_t)d * w->total + i] + w->f[(int64_t)d * w->total + j]);
    }
    w->out[i] = sum;
}

void pd_op_divergence(const pd_ctx *ctx, const pd_bonds *bonds, const double *u, double *div)
{
    pdi_op_sweep w;
    pdi_op_sweep_init(bonds, u, NULL, div, &w);
    pdi_op_apply(ctx, &w, pdi_op_divergence_run, pdi_op_divergence_row);
}

/* ---- Laplacian: L f_i = sum a (f_j - f_i), symmetric weights (eq. 2.3) ---- */

static inline void pdi_op_laplacian_block(const pdi_op_sweep *w, int32_t i, int count)
{
    const pd_stencil *s = w->bonds->stencil;
    const double *f = w->f + i;
    double sum[PDI_OP_BLOCK];
    memset(sum, 0, sizeof sum);
    /* differences, not sums less the centre: constants come out as exact zeros */
    for (int k = 0; k < s->count / 2; k++) {
        const double *far = f + w->bonds->shift[k], *back = f - w->bonds->shift[k], a = s->lap[k];
        for (int b = 0; b < count; b++) sum[b] += a * ((far[b] - f[b]) + (back[b] - f[b]));
    }
    for (int b = 0; b < count; b++) w->out[i + b] = sum[b];
}

static void pdi_op_laplacian_run(const pdi_op_sweep *w, int32_t first, int32_t length)
{
    int32_t at = 0;
    for (; at + PDI_OP_BLOCK <= length; at += PDI_OP_BLOCK) pdi_op_laplacian_block(w, first + at, PDI_OP_BLOCK);
    if (at < length) pdi_op_laplacian_block(w, first + at, (int)(length - at));
}

static void pdi_op_laplacian_row(const pdi_op_sweep *w, int32_t r)
{
    const pd_bonds *bonds = w->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t i = bonds->node[r];
    double sum = 0.0;
    for (int o = 0; o < bonds->open[r]; o++) {
        int k = bonds->bond[(int64_t)r * s->count + o];
        sum += s->lap[k] * (w->f[i + bonds->shift[k]] - w->f[i]);
    }
    w->out[i] = sum;
}

void pd_op_laplacian(const pd_ctx *ctx, const pd_bonds *bonds, const double *f, double *lap)
{
    pdi_op_sweep w;
    pdi_op_sweep_init(bonds, f, NULL, lap, &w);
    pdi_op_apply(ctx, &w, pdi_op_laplacian_run, pdi_op_laplacian_row);
}

/* ---- diffusion: sum D_ij a (f_j - f_i), D_ij = 2 D_i D_j / (D_i + D_j) (eq. 5.2) ---- */

/* In this form neither a ratio of 1e300 nor a zero at one end overflows; the same bits from both ends. */
static inline double pdi_op_harmonic(double a, double b)
{
    double lower = a < b ? a : b, upper = a < b ? b : a;
    return upper > 0.0 ? 2.0 * lower / (1.0 + lower / upper) : 0.0;
}

static inline void pdi_op_diffuse_block(const pdi_op_sweep *w, int32_t i, int count)
{
    const pd_stencil *s = w->bonds->stencil;
    const double *f = w->f + i, *d = w->d + i;
    double sum[PDI_OP_BLOCK];
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < s->count; k++) {
        int32_t shift = w->bonds->shift[k];
        double a = s->lap[k];
        for (int b = 0; b < count; b++) sum[b] += a * pdi_op_harmonic(d[b], d[b + shift]) * (f[b + shift] - f[b]);
    }
    for (int b = 0; b < count; b++) w->out[i + b] = sum[b];
}

static void pdi_op_diffuse_run(const pdi_op_sweep *w, int32_t first, int32_t length)
{
    int32_t at = 0;
    for (; at + PDI_OP_BLOCK <= length; at += PDI_OP_BLOCK) pdi_op_diffuse_block(w, first + at, PDI_OP_BLOCK);
    if (at < length) pdi_op_diffuse_block(w, first + at, (int)(length - at));
}

static void pdi_op_diffuse_row(const pdi_op_sweep *w, int32_t r)
{
    const pd_bonds *bonds = w->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t i = bonds->node[r];
    double sum = 0.0;
    for (int o = 0; o < bonds->open[r]; o++) {
        int k = bonds->bond[(int64_t)r * s->count + o];
        int32_t j = i + bonds->shift[k];
        sum += s->lap[k] * pdi_op_harmonic(w->d[i], w->d[j]) * (w->f[j] - w->f[i]);
    }
    w->out[i] = sum;
}

pd_status pd_op_diffuse(pd_ctx *ctx, const pd_bonds *bonds, const double *diffusivity, const double *f, double *out)
{
    const pd_grid *grid = bonds->grid;
    pdi_op_sweep w;
    for (int32_t node = 0; node < grid->total; node++)
        if (pdi_grid_open(grid->kind[node]) && !(diffusivity[node] >= 0.0 && diffusivity[node] < 1e300))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "op", "the diffusivity of node %d is %g m2/s, expected one >= 0",
                            (int)node, diffusivity[node]);
    pdi_op_sweep_init(bonds, f, diffusivity, out, &w);
    pdi_op_apply(ctx, &w, pdi_op_diffuse_run, pdi_op_diffuse_row);
    return PD_OK;
}
