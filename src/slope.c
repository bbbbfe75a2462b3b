/* slope: see slope.h */
#include "slope.h"
#include "par.h"
#include <math.h>
#include <string.h>

/* Of a quadratic: slopes, then second derivatives. */
#define PDI_SLOPE_TERMS (PD_DIM + PD_DIM * (PD_DIM + 1) / 2)
/* A fit whose moments have a pivot below this, over those of whole families, is none. */
#define PDI_SLOPE_MIN_PIVOT 1e-3

/* The terms of bond k, in cells. */
static void pdi_slope_terms(const pd_stencil *s, int k, double *term)
{
    const int *n = s->offset + k * PD_DIM;
    int at = PD_DIM;
    for (int a = 0; a < PD_DIM; a++) {
        term[a] = n[a];
        for (int b = 0; b <= a; b++) term[at++] = (double)(n[a] * n[b]);
    }
}

/* 1: bond k of a row counts. Bonds to inlets carry no scalar. */
static int pdi_slope_counts(const pd_bonds *bonds, int32_t r, int k)
{
    return pdi_bond_open(bonds, r, k) && bonds->grid->kind[bonds->node[r] + bonds->shift[k]] != PD_INLET;
}

/* Cholesky's factor of the moments in place; 0: they determine no quadratic. */
static int pdi_slope_factor(double moment[PDI_SLOPE_TERMS][PDI_SLOPE_TERMS])
{
    for (int c = 0; c < PDI_SLOPE_TERMS; c++) {
        for (int k = 0; k < c; k++) moment[c][c] -= moment[c][k] * moment[c][k];
        if (!(moment[c][c] > PDI_SLOPE_MIN_PIVOT)) return 0;
        moment[c][c] = sqrt(moment[c][c]);
        for (int r = c + 1; r < PDI_SLOPE_TERMS; r++) {
            for (int k = 0; k < c; k++) moment[r][c] -= moment[r][k] * moment[c][k];
            moment[r][c] /= moment[c][c];
        }
    }
    return 1;
}

/* Row `d` of the inverse. */
static void pdi_slope_invert(double factor[PDI_SLOPE_TERMS][PDI_SLOPE_TERMS], int d, double *x)
{
    for (int r = 0; r < PDI_SLOPE_TERMS; r++) {
        x[r] = r == d ? 1.0 : 0.0;
        for (int k = 0; k < r; k++) x[r] -= factor[r][k] * x[k];
        x[r] /= factor[r][r];
    }
    for (int r = PDI_SLOPE_TERMS - 1; r >= 0; r--) {
        for (int k = r + 1; k < PDI_SLOPE_TERMS; k++) x[r] -= factor[k][r] * x[k];
        x[r] /= factor[r][r];
    }
}

/* The weights of row r; 0: its bonds determine no quadratic. */
static int pdi_slope_fit(const pd_bonds *bonds, int32_t r, double *weight)
{
    const pd_stencil *s = bonds->stencil;
    double moment[PDI_SLOPE_TERMS][PDI_SLOPE_TERMS], unit[PDI_SLOPE_TERMS], term[PDI_SLOPE_TERMS];
    memset(moment, 0, sizeof moment);
    memset(unit, 0, sizeof unit);
    for (int k = 0; k < s->count; k++) {
        pdi_slope_terms(s, k, term);
        for (int a = 0; a < PDI_SLOPE_TERMS; a++) unit[a] += s->base[k] * term[a] * term[a];
        if (!pdi_slope_counts(bonds, r, k)) continue;
        for (int a = 0; a < PDI_SLOPE_TERMS; a++)
            for (int b = 0; b < PDI_SLOPE_TERMS; b++) moment[a][b] += s->base[k] * term[a] * term[b];
    }
    for (int a = 0; a < PDI_SLOPE_TERMS; a++) unit[a] = 1.0 / sqrt(unit[a]);
    for (int a = 0; a < PDI_SLOPE_TERMS; a++)
        for (int b = 0; b < PDI_SLOPE_TERMS; b++) moment[a][b] *= unit[a] * unit[b];
    if (!pdi_slope_factor(moment)) return 0;
    for (int d = 0; d < PD_DIM; d++) {
        double *to = weight + d * PDI_SLOPE_TERMS;
        pdi_slope_invert(moment, d, to);
        for (int a = 0; a < PDI_SLOPE_TERMS; a++) to[a] *= unit[a] * unit[d] / bonds->grid->h[d];
    }
    return 1;
}

pd_status pd_slopes_update(pd_ctx *ctx, const pd_bonds *bonds, pd_slopes *slopes)
{
    int32_t wanted = 0;
    slopes->bonds = bonds;
    slopes->count = 0;
    for (int32_t r = 0; r < bonds->rows; r++) wanted += bonds->smooth[r];
    if (wanted > slopes->capacity) {
        pd_slopes_free(ctx, slopes);
        slopes->bonds = bonds;
        slopes->capacity = wanted;
        PDI_TRY(PDI_NEW(ctx, "slope", wanted, slopes->row));
        PDI_TRY(PDI_NEW(ctx, "slope", (int64_t)wanted * PD_DIM * PDI_SLOPE_TERMS, slopes->weight));
    }
    for (int32_t r = 0; r < bonds->rows; r++) {
        if (!bonds->smooth[r]) continue;
        if (!pdi_slope_fit(bonds, r, slopes->weight + (int64_t)slopes->count * PD_DIM * PDI_SLOPE_TERMS)) continue;
        slopes->row[slopes->count++] = r;
    }
    return PD_OK;
}

PDI_FN void pdi_slopes_apply(const pd_ctx *ctx, const pd_slopes *slopes, const double *f, double *grad)
{
    const pd_bonds *bonds = slopes->bonds;
    if (!slopes->count) return;
    const pd_stencil *s = bonds->stencil;
    int nt = pdi_par_threads(ctx, (int64_t)slopes->count * s->count * PDI_SLOPE_TERMS);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t q = 0; q < slopes->count; q++) {
        int32_t r = slopes->row[q], node = bonds->node[r];
        double sum[PDI_SLOPE_TERMS], term[PDI_SLOPE_TERMS];
        memset(sum, 0, sizeof sum);
        for (int k = 0; k < s->count; k++) {
            if (!pdi_slope_counts(bonds, r, k)) continue;
            double difference = s->base[k] * (f[node + bonds->shift[k]] - f[node]);
            pdi_slope_terms(s, k, term);
            for (int a = 0; a < PDI_SLOPE_TERMS; a++) sum[a] += difference * term[a];
        }
        for (int d = 0; d < PD_DIM; d++) {
            const double *weight = slopes->weight + ((int64_t)q * PD_DIM + d) * PDI_SLOPE_TERMS;
            double value = 0.0;
            for (int a = 0; a < PDI_SLOPE_TERMS; a++) value += weight[a] * sum[a];
            grad[(int64_t)d * bonds->grid->total + node] = value;
        }
    }
}

void pd_slopes_free(pd_ctx *ctx, pd_slopes *slopes)
{
    PDI_DELETE(ctx, slopes->capacity, slopes->row);
    PDI_DELETE(ctx, (int64_t)slopes->capacity * PD_DIM * PDI_SLOPE_TERMS, slopes->weight);
    memset(slopes, 0, sizeof *slopes);
}

#undef PDI_SLOPE_TERMS
#undef PDI_SLOPE_MIN_PIVOT
