/* rest: see rest.h */
#include "transport/rest.h"
#include "lattice/line_laplacian.h"
#include "lattice/node_loop.h"

/* What sweeps see. */
typedef struct pdi_rest_sweep {
    const pdi_rest *rest;
    pdi_line_laplacian_data lines;
    const double *x;
    double *y;
} pdi_rest_sweep;

/* What leaves through bond k of `count` rows, added to `sum`. exact: of all that are `open`. Otherwise less what whole
 * families would give. */
PDI_INLINE void pdi_rest_bond(const pd_conductance *c, const double *x, const float *PD_RESTRICT more,
                              const uint32_t *PD_RESTRICT open, int k, int count, int exact, double *PD_RESTRICT sum)
{
    const pd_bonds *bonds = c->bonds;
    const double *far = x + bonds->paths.shift[k];
    double whole = c->diffusion->desc.diffusivity * bonds->stencil->laplacian_weight[k];
    for (int b = 0; b < count; b++) {
        double bond = whole * ((exact ? 1.0 : 0.0) + (double)more[b]);
        sum[b] += (exact ? (double)(int32_t)(open[b] >> (k & 31) & 1u) : 1.0) * bond * (x[b] - far[b]);
    }
}

/* The same through all bonds of `count` rows of one page. Those are left out that all rows have closed or, not exact,
 * no row has a number of. */
PDI_INLINE void pdi_rest_block(const pd_conductance *c, const double *x, int32_t row, int count, int exact,
                               double *PD_RESTRICT sum)
{
    const pd_bonds *bonds = c->bonds;
    const float *first = c->more + pdi_conductance_place(c, row, 0);
    double total[PDI_BLOCK] = {0.0};
    for (int word = 0; word < bonds->paths.words; word++) {
        const uint32_t *bits = exact ? bonds->open_mask + (int64_t)word * bonds->capacity + row
                                     : c->other + (int64_t)word * c->capacity + row;
        uint32_t any = 0;
        for (int b = 0; b < count; b++) any |= bits[b];
        for (int k = 32 * word; any; k++, any >>= 1)
            if (any & 1u) pdi_rest_bond(c, x, first + (int64_t)k * PDI_CONDUCTANCE_PAGE, bits, k, count, exact, total);
    }
    for (int b = 0; b < count; b++) sum[b] = total[b];
}

/* The rows of a run. */
static void pdi_rest_rows(const pd_conductance *c, const double *x, int32_t row, int32_t length, int exact, double *sum)
{
    int32_t count;
    for (int32_t at = 0; at < length; at += count) {
        int32_t left = PDI_CONDUCTANCE_PAGE - (row + at) % PDI_CONDUCTANCE_PAGE;
        count = length - at < PDI_BLOCK ? length - at : PDI_BLOCK;
        count = count < left ? count : left;
        if (exact && PDI_FULL_BLOCK(count)) pdi_rest_block(c, x + at, row + at, PDI_BLOCK, 1, sum + at);
        else if (exact) pdi_rest_block(c, x + at, row + at, count, 1, sum + at);
        else if (PDI_FULL_BLOCK(count)) pdi_rest_block(c, x + at, row + at, PDI_BLOCK, 0, sum + at);
        else pdi_rest_block(c, x + at, row + at, count, 0, sum + at);
    }
}

/* Whole families: the Laplacian by lines. Rows: the same, less what closed bonds would carry and with what the others
 * carry otherwise, or bond by bond. */
static void pdi_rest_run(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pdi_rest_sweep *s = (const pdi_rest_sweep *)user;
    const pdi_rest *rest = s->rest;
    const pd_conductance *c = rest->conductance;
    const double *x = s->x + i;
    int bonds = row >= 0 && rest->exact;
    double *y = s->y + i, sum[PDI_CHUNK], diffusivity = c->diffusion->desc.diffusivity;
    if (!bonds) pdi_line_laplacian_apply(&s->lines, s->x, i, length, y);
    if (row >= 0) pdi_rest_rows(c, x, row, length, rest->exact, sum);
    for (int32_t b = 0; b < length; b++) {
        double own = rest->rate + rest->absorb[i + b] + (rest->hold ? rest->hold[i + b] : 0.0);
        double held = own * rest->plain[i + b];
        if (row < 0) y[b] = held - diffusivity * y[b];
        else if (bonds) y[b] = held + sum[b];
        else y[b] = held - c->shut[row + b] * x[b] - diffusivity * y[b] + sum[b];
    }
}

PDI_FN void pdi_rest_apply(const pd_ctx *ctx, const pdi_rest *rest, const double *x, double *y)
{
    const pd_bonds *bonds = rest->conductance->bonds;
    pdi_rest_sweep s;
    s.rest = rest;
    s.lines.grid = bonds->grid;
    s.lines.stencil = bonds->stencil;
    s.lines.shift = bonds->line_shift;
    s.x = x;
    s.y = y;
    pdi_node_loop_by_ranges(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count, PDI_CHUNK, pdi_rest_run, &s);
}
