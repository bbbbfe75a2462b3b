/* rest: see rest.h */
#include "transport/rest.h"
#include "lattice/line.h"
#include "lattice/traverse.h"

/* What sweeps see. */
typedef struct pdi_rest_sweep {
    const pdi_rest *rest;
    pdi_lines lines;
    const double *x;
    double *y;
} pdi_rest_sweep;

/* What leaves through the bonds of a row, one by one. */
static double pdi_rest_row(const pd_conductance *c, const double *x, int32_t row)
{
    const int32_t *shift = c->bonds->shift;
    const double *bond = pdi_conductance_place(c, row, 0);
    int count = c->bonds->stencil->count;
    double behind = 0.0, ahead = 0.0;
    for (int k = 0; k < count / 2; k++) {
        int opposite = count - 1 - k;
        behind += bond[(int64_t)k * PDI_CONDUCTANCE_PAGE] * (x[0] - x[shift[k]]);
        ahead += bond[(int64_t)opposite * PDI_CONDUCTANCE_PAGE] * (x[0] - x[shift[opposite]]);
    }
    return behind + ahead;
}

/* What leaves through the bonds of PDI_VECTOR rows of one page. Bonds that all of them have closed are left out. */
static void pdi_rest_block(const pd_conductance *c, const double *x, int32_t row, double *PD_RESTRICT sum)
{
    const pd_bonds *bonds = c->bonds;
    const double *first = pdi_conductance_place(c, row, 0);
    double total[PDI_VECTOR] = {0.0};
    for (int word = 0; word < bonds->words; word++) {
        const uint32_t *open = bonds->mask + (int64_t)word * bonds->capacity + row;
        int k = 32 * word, end = k + 32 < bonds->stencil->count ? k + 32 : bonds->stencil->count;
        uint32_t any = 0;
        for (int b = 0; b < PDI_VECTOR; b++) any |= open[b];
        for (; k < end; k++, any >>= 1) {
            const double *bond = first + (int64_t)k * PDI_CONDUCTANCE_PAGE, *far = x + bonds->shift[k];
            if (!(any & 1u)) continue;
            for (int b = 0; b < PDI_VECTOR; b++) total[b] += bond[b] * (x[b] - far[b]);
        }
    }
    for (int b = 0; b < PDI_VECTOR; b++) sum[b] = total[b];
}

/* The rows of a run that go bond by bond: all of them, or those whose conductances are not those of whole bonds. */
static void pdi_rest_rows(const pdi_rest *rest, const double *x, int32_t row, int32_t length, double *sum)
{
    const pd_conductance *c = rest->conductance;
    const double *shut = c->shut + row;
    for (int32_t at = 0; at < length;) {
        int some = 0;
        if (at + PDI_VECTOR > length && length >= PDI_VECTOR) at = length - PDI_VECTOR; /* with rows that are done */
        for (int b = 0; b < PDI_VECTOR && at + b < length; b++) some += rest->exact || shut[at + b] < 0.0;
        int page = (row + at) % PDI_CONDUCTANCE_PAGE + PDI_VECTOR <= PDI_CONDUCTANCE_PAGE;
        if (at + PDI_VECTOR <= length && some > 1 && page) {
            pdi_rest_block(c, x + at, row + at, sum + at);
            at += PDI_VECTOR;
            continue;
        }
        for (int b = 0; b < PDI_VECTOR && at < length; b++, at++)
            if (rest->exact || shut[at] < 0.0) sum[at] = pdi_rest_row(c, x + at, row + at);
    }
}

/* Whole families: the Laplacian by lines. Rows: the same less what closed bonds would carry, or bond by bond. */
static void pdi_rest_run(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pdi_rest_sweep *s = (const pdi_rest_sweep *)user;
    const pdi_rest *rest = s->rest;
    const pd_conductance *c = rest->conductance;
    const double *x = s->x + i;
    double *y = s->y + i, sum[PDI_PIECE];
    if (row < 0 || !rest->exact) pdi_line_laplacian(&s->lines, s->x, i, length, y);
    if (row >= 0) pdi_rest_rows(rest, x, row, length, sum);
    for (int32_t b = 0; b < length; b++) {
        double own = rest->rate + rest->absorb[i + b] + (rest->hold ? rest->hold[i + b] : 0.0);
        double shut = row < 0 ? 0.0 : rest->exact ? -1.0 : c->shut[row + b];
        y[b] = own * x[b] + (shut < 0.0 ? sum[b] : -c->diffusion->desc.diffusivity * y[b] - shut * x[b]);
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
    pdi_traverse_sweep(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count, PDI_PIECE, pdi_rest_run, &s);
}
