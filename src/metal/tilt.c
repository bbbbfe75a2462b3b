/* tilt: see tilt.h */
#include "metal/tilt.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <stdlib.h>

/* Range of the normals as integers. */
#define PDI_TILT_RANGE 32767.0
/* What is that near to the middle between two of them lies there. */
#define PDI_TILT_TIE 1e-6

/* The nearest whole number, of two that are equally near the larger one in size, whatever the rounding of `part` and
 * its sign: mirrored surfaces have mirrored normals. */
static int16_t pdi_tilt_whole(double part)
{
    double size = floor(PDI_TILT_RANGE * fabs(part) + 0.5 + PDI_TILT_TIE);
    return (int16_t)(part < 0.0 ? -size : size);
}

/* 1: fluid, -1: metal, 0: neither, at the far end of bond k. */
static int pdi_tilt_side(const pd_dissolve *d, int32_t j, int k)
{
    uint8_t kind = d->grid->kind[pdi_entry_far(&d->paths, j, k)];
    if (kind != PD_FLUID && kind != PD_SOLID) return 0;
    return !pdi_entry_free(&d->paths, j, k) ? 0 : kind == PD_FLUID ? 1 : -1;
}

/* Normal of the surface at node j in the lattice, of any length: from metal to fluid. What a wall takes from one side
 * counts on neither, so that a front that meets a wall keeps its direction. */
static void pdi_tilt_face(pd_dissolve *d, int32_t j)
{
    const pd_stencil *s = d->paths.stencil;
    double sum[PD_DIM] = {0.0}, whole = 0.0;
    for (int k = 0; k < s->count / 2; k++) {
        int one = pdi_tilt_side(d, j, k), other = one ? pdi_tilt_side(d, j, s->count - 1 - k) : 0;
        for (int a = 0; a < PD_DIM && other; a++)
            sum[a] += s->partial_volume[k] * s->offset[k * PD_DIM + a] * (one - other);
        whole += 2.0 * s->partial_volume[k] * abs(s->offset[k * PD_DIM]);
    }
    for (int a = 0; a < PD_DIM; a++)
        d->facing[(int64_t)j * PD_DIM + a] = pdi_tilt_whole(sum[a] / whole);
}

/* The same at the far end of bond k, exposed metal, as the bond sees it. 0: there is none, or it faces away. */
static int pdi_tilt_far(const pd_dissolve *d, int32_t j, int k, double *normal)
{
    const int16_t *own = d->facing + (int64_t)j * PD_DIM;
    int32_t at = j + d->paths.shift[k];
    uint8_t kind = d->grid->kind[at];
    int flip = 0;
    double dot = 0.0;
    if (kind != PD_FLUID && kind != PD_SOLID) at = pd_grid_find_source(d->grid, at, &flip);
    if (d->grid->kind[at] != PD_SOLID || !d->exposed[at] || !pdi_entry_free(&d->paths, j, k)) return 0;
    for (int a = 0; a < PD_DIM; a++) {
        normal[a] = flip & 1 << a ? -(double)d->facing[(int64_t)at * PD_DIM + a] : d->facing[(int64_t)at * PD_DIM + a];
        dot += normal[a] * own[a];
    }
    return dot > 0.0;
}

/* 1/f(N) at node j. */
static double pdi_tilt_factor(const pd_dissolve *d, int32_t j)
{
    const pd_stencil *s = d->paths.stencil;
    double sum[PD_DIM], normal[PD_DIM], f = 0.0;
    for (int a = 0; a < PD_DIM; a++) sum[a] = d->facing[(int64_t)j * PD_DIM + a];
    for (int k = 0; k < s->count; k++) {
        if (!pdi_tilt_far(d, j, k, normal)) continue;
        for (int a = 0; a < PD_DIM; a++) sum[a] += s->partial_volume[k] * normal[a];
    }
    for (int a = 0; a < PD_DIM; a++) sum[a] /= s->h[a]; /* normals of planes go with the inverse of the spacing */
    double length = pdi_vec_norm(sum);
    if (!(length > 0.0)) return 1.0;
    for (int k = 0; k < s->count / 2; k++) f += d->weight[k] * fabs(pdi_vec_dot(s->xi + k * PD_DIM, sum));
    return length / f;
}

static void pdi_tilt_near(pd_dissolve *d, int32_t j)
{
    d->mark[j] |= PDI_TILT_NEAR;
    for (int k = 0; k < d->paths.stencil->count; k++) d->mark[pdi_entry_far(&d->paths, j, k)] |= PDI_TILT_NEAR;
}

/* Bonds: the factor of node j is another one. What it gives and what enters at its bonds has to be found anew. */
static void pdi_tilt_touch(pd_dissolve *d, int32_t j)
{
    d->mark[j] |= PDI_REACH_TOUCHED;
    for (int k = 0; k < d->paths.stencil->count; k++) {
        int32_t i = pdi_entry_far(&d->paths, j, k);
        if (d->grid->kind[i] == PD_FLUID) d->mark[i] |= PDI_REACH_TOUCHED;
    }
}

PDI_FN void pdi_tilt_update(const pd_ctx *ctx, pd_dissolve *d)
{
    int nt = pd_par_threads(ctx, (int64_t)d->front_count * d->paths.stencil->count);
    int all = !d->tilted;
    (void)nt;
    if (!d->tilt || (!all && !d->lags)) return;
    PD_PARALLEL_FOR(nt)
    for (int32_t f = 0; f < d->front_count; f++)
        if (all || (d->mark[d->front[f]] & PDI_REACH_TOUCHED)) pdi_tilt_face(d, d->front[f]);
    for (int32_t f = 0; f < d->front_count && !all; f++)
        if (d->mark[d->front[f]] & PDI_REACH_TOUCHED) pdi_tilt_near(d, d->front[f]);
    PD_PARALLEL_FOR(nt)
    for (int32_t f = 0; f < d->front_count; f++) {
        int32_t j = d->front[f];
        if (!all && !(d->mark[j] & PDI_TILT_NEAR)) continue;
        float factor = (float)pdi_tilt_factor(d, j);
        if (factor >= d->tilt[j] && factor <= d->tilt[j]) d->mark[j] &= (uint8_t)~PDI_TILT_NEAR;
        d->tilt[j] = factor;
    }
    for (int32_t f = 0; f < d->front_count && !all && pdi_metal_bonds(d); f++)
        if (d->mark[d->front[f]] & PDI_TILT_NEAR) pdi_tilt_touch(d, d->front[f]);
    d->tilted = 1;
}
