/* reconstruct: see reconstruct.h */
#include "lattice/reconstruct.h"
#include "core/owner.h"
#include "core/par.h"
#include "core/vec.h"
#include "lattice/quadratic.h"
#include <math.h>
#include <string.h>

/* Of a quadratic about the node: slopes, then second derivatives. */
#define PDI_RECONSTRUCT_TERMS (PD_DIM + PD_DIM * (PD_DIM + 1) / 2)
/* Data whose moments, over those of a whole family, have a pivot below this determine no quadratic. */
#define PDI_RECONSTRUCT_MIN_PIVOT 1e-3

/* Weighted moments of the data of a row. */
typedef struct pdi_reconstruct_moments {
    double sum[PDI_RECONSTRUCT_TERMS * PDI_RECONSTRUCT_TERMS]; /* then scaled by `unit` on both sides and factored */
    double unit[PDI_RECONSTRUCT_TERMS];
} pdi_reconstruct_moments;

/* The terms at the fraction t of bond k, in cells. */
static void pdi_reconstruct_terms(const pd_stencil *s, int k, double t, double *term)
{
    const int *n = s->offset + k * PD_DIM;
    int at = PD_DIM;
    for (int a = 0; a < PD_DIM; a++) {
        term[a] = t * n[a];
        for (int b = 0; b <= a; b++) term[at++] = t * t * (double)(n[a] * n[b]);
    }
}

/* 1: a scalar knows the far end of bond k. Bonds to inlets carry none. */
static int pdi_reconstruct_carries(const pd_bonds *bonds, int32_t r, int k)
{
    return pdi_bond_open(bonds, r, k) && bonds->grid->kind[bonds->node[r] + bonds->paths.shift[k]] != PD_INLET;
}

static void pdi_reconstruct_add(const double *term, double weight, pdi_reconstruct_moments *m)
{
    for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++)
        for (int b = 0; b < PDI_RECONSTRUCT_TERMS; b++)
            m->sum[a * PDI_RECONSTRUCT_TERMS + b] += weight * term[a] * term[b];
}

/* 0: the data determine no quadratic. */
static int pdi_reconstruct_factor(pdi_reconstruct_moments *m)
{
    double least[PDI_RECONSTRUCT_TERMS];
    for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) {
        least[a] = PDI_RECONSTRUCT_MIN_PIVOT;
        for (int b = 0; b < PDI_RECONSTRUCT_TERMS; b++)
            m->sum[a * PDI_RECONSTRUCT_TERMS + b] *= m->unit[a] * m->unit[b];
    }
    return pdi_vec_factor(PDI_RECONSTRUCT_TERMS, PDI_RECONSTRUCT_TERMS, least, m->sum);
}

/* x = M^-1 y */
static void pdi_reconstruct_solve(const pdi_reconstruct_moments *m, const double *y, double *x)
{
    for (int r = 0; r < PDI_RECONSTRUCT_TERMS; r++) x[r] = y[r] * m->unit[r];
    pdi_vec_substitute(PDI_RECONSTRUCT_TERMS, PDI_RECONSTRUCT_TERMS, m->sum, x);
    for (int r = 0; r < PDI_RECONSTRUCT_TERMS; r++) x[r] *= m->unit[r];
}

/* Empty moments in the units of a whole family. */
static void pdi_reconstruct_start(const pd_stencil *s, pdi_reconstruct_moments *m)
{
    double term[PDI_RECONSTRUCT_TERMS];
    memset(m, 0, sizeof *m);
    for (int k = 0; k < s->count; k++) {
        pdi_reconstruct_terms(s, k, 1.0, term);
        for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) m->unit[a] += s->base[k] * term[a] * term[a];
    }
    for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) m->unit[a] = 1.0 / sqrt(m->unit[a]);
}

/* The gradient of a scalar (eq. 3.5b). */
static int pdi_reconstruct_scalar(const pd_bonds *bonds, int32_t r, double *grad)
{
    const pd_stencil *s = bonds->stencil;
    double term[PDI_RECONSTRUCT_TERMS];
    pdi_reconstruct_moments m;
    pdi_reconstruct_start(s, &m);
    for (int k = 0; k < s->count; k++) {
        if (!pdi_reconstruct_carries(bonds, r, k)) continue;
        pdi_reconstruct_terms(s, k, 1.0, term);
        pdi_reconstruct_add(term, s->base[k], &m);
    }
    if (!pdi_reconstruct_factor(&m)) return 0;
    for (int d = 0; d < PD_DIM; d++) {
        memset(term, 0, sizeof term);
        term[d] = 1.0 / bonds->grid->h[d];
        pdi_reconstruct_solve(&m, term, grad + d * PDI_RECONSTRUCT_TERMS);
    }
    return 1;
}

/* What cut bonds add to the Laplacian of a velocity that vanishes on the surface (eq. 3.4b). */
static int pdi_reconstruct_velocity(const pd_bonds *bonds, int32_t r, double *bend, double *drag)
{
    const pd_stencil *s = bonds->stencil;
    double term[PDI_RECONSTRUCT_TERMS], far[PDI_RECONSTRUCT_TERMS], wall[PDI_RECONSTRUCT_TERMS];
    pdi_reconstruct_moments m;
    memset(far, 0, sizeof far);
    memset(wall, 0, sizeof wall);
    pdi_reconstruct_start(s, &m);
    for (int k = 0; k < s->count; k++) {
        double weight = s->base[k];
        pdi_reconstruct_terms(s, k, 1.0, term);
        if (!pdi_bond_open(bonds, r, k)) {
            pdi_bond_end end;
            double a = pdi_bond_lap(bonds, bonds->node[r])[k];
            pdi_bond_find_end(bonds, r, k, &end);
            for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++) far[c] += a * term[c];
            if (end.t > 1.0) continue; /* the line grazes the surface, and meets it far behind */
            weight /= end.t * end.t;
            pdi_reconstruct_terms(s, k, end.t, term);
            for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++) wall[c] += weight * term[c];
        }
        pdi_reconstruct_add(term, weight, &m);
    }
    if (!pdi_reconstruct_factor(&m)) return 0;
    pdi_reconstruct_solve(&m, far, bend);
    *drag = 0.0;
    for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++) *drag += bend[c] * wall[c];
    return 1;
}

PDI_COLD_BEGIN
static void pdi_reconstruct_list(pdi_owner *owner, void *object)
{
    pd_reconstruct *slopes = (pd_reconstruct *)object;
    int64_t count = slopes->capacity, terms = PDI_RECONSTRUCT_TERMS;
    PDI_ARRAY(owner, slopes, row, count, "1");
    PDI_ARRAY(owner, slopes, fits, count, "1");
    PDI_ARRAY(owner, slopes, grad, count * PD_DIM * terms, "1/m");
    PDI_ARRAY(owner, slopes, bend, count * terms, "1/m2");
    PDI_ARRAY(owner, slopes, drag, count, "1/m2");
    PDI_ARRAY(owner, slopes, term, slopes->bonds ? slopes->bonds->stencil->count * terms : 0, "1");
    PDI_ARRAY(owner, slopes, place, slopes->rows, "1");
}

static pd_status pdi_reconstruct_reserve(pd_ctx *ctx, int32_t count, pd_reconstruct *slopes)
{
    const pd_bonds *bonds = slopes->bonds;
    if (count <= slopes->capacity && bonds->capacity <= slopes->rows) return PD_OK;
    pdi_reconstruct_free(ctx, slopes);
    slopes->bonds = bonds;
    slopes->capacity = count + count / 4;
    slopes->rows = bonds->capacity;
    return pdi_owner_build(ctx, pdi_reconstruct_list, slopes);
}
PDI_COLD_END

PDI_FN pd_status pdi_reconstruct_update(pd_ctx *ctx, const pd_bonds *bonds, pd_reconstruct *slopes)
{
    int32_t count = 0;
    for (int32_t r = 0; r < bonds->rows; r++) count += bonds->smooth[r];
    slopes->bonds = bonds;
    PDI_TRY(pdi_reconstruct_reserve(ctx, count, slopes));
    slopes->count = 0;
    for (int k = 0; k < bonds->stencil->count && count; k++) {
        double *term = slopes->term + k * PDI_RECONSTRUCT_TERMS;
        pdi_reconstruct_terms(bonds->stencil, k, 1.0, term);
        for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) term[a] *= bonds->stencil->base[k];
    }
    for (int32_t r = 0; r < slopes->rows; r++) {
        int32_t q = slopes->count;
        slopes->place[r] = -1;
        if (r >= bonds->rows || !bonds->smooth[r]) continue;
        slopes->place[r] = q;
        slopes->row[q] = r;
        slopes->fits[q] = 0;
        if (pdi_reconstruct_scalar(bonds, r, slopes->grad + (int64_t)q * PD_DIM * PDI_RECONSTRUCT_TERMS))
            slopes->fits[q] |= PDI_RECONSTRUCT_SCALAR;
        if (pdi_reconstruct_velocity(bonds, r, slopes->bend + (int64_t)q * PDI_RECONSTRUCT_TERMS, slopes->drag + q))
            slopes->fits[q] |= PDI_RECONSTRUCT_VELOCITY;
        slopes->count++;
    }
    return PD_OK;
}

PDI_FN void pdi_reconstruct_gradient(const pd_ctx *ctx, const pd_reconstruct *slopes, const double *f, double *grad)
{
    const pd_bonds *bonds = slopes->bonds;
    if (!slopes->count) return;
    const pd_stencil *s = bonds->stencil;
    int nt = pdi_par_threads(ctx, (int64_t)slopes->count * s->count * PDI_RECONSTRUCT_TERMS);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t q = 0; q < slopes->count; q++) {
        int32_t r = slopes->row[q], node = bonds->node[r];
        double sum[PDI_RECONSTRUCT_TERMS];
        if (!(slopes->fits[q] & PDI_RECONSTRUCT_SCALAR)) continue;
        memset(sum, 0, sizeof sum);
        for (int k = 0; k < s->count; k++) {
            if (!pdi_reconstruct_carries(bonds, r, k)) continue;
            const double *term = slopes->term + k * PDI_RECONSTRUCT_TERMS;
            double difference = f[node + bonds->paths.shift[k]] - f[node];
            for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) sum[a] += difference * term[a];
        }
        for (int d = 0; d < PD_DIM; d++) {
            const double *weight = slopes->grad + ((int64_t)q * PD_DIM + d) * PDI_RECONSTRUCT_TERMS;
            double value = 0.0;
            for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) value += weight[a] * sum[a];
            grad[(int64_t)d * bonds->grid->total + node] = value;
        }
    }
}

PDI_FN void pdi_reconstruct_bend(const pd_reconstruct *slopes, int32_t r, const double *u, double *wall)
{
    const pd_bonds *bonds = slopes->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[r], q = slopes->place[r];
    int64_t total = bonds->grid->total;
    const double *bend = slopes->bend + (int64_t)q * PDI_RECONSTRUCT_TERMS;
    for (int d = 0; d < PD_DIM; d++) wall[d] = -slopes->drag[q] * u[d * total + node];
    for (int k = 0; k < s->count; k++) {
        const double *term = slopes->term + k * PDI_RECONSTRUCT_TERMS;
        double weight = 0.0;
        if (!pdi_bond_open(bonds, r, k)) continue;
        for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) weight += bend[a] * term[a];
        for (int d = 0; d < PD_DIM; d++)
            wall[d] += weight * (u[d * total + node + bonds->paths.shift[k]] - u[d * total + node]);
    }
}

PDI_FN double pdi_reconstruct_value(const pd_bonds *bonds, const double *f, int32_t node, const double *x)
{
    const pd_stencil *s = bonds->stencil;
    int32_t row = bonds->row[node];
    pdi_quadratic fit;
    double at[PD_DIM], place[PD_DIM];
    pdi_quadratic_start(&fit, x, bonds->grid->h);
    pd_grid_position(bonds->grid, node, at);
    pdi_quadratic_value(&fit, at, f[node]);
    for (int k = 0; k < s->count; k++) {
        const int *n = s->offset + k * PD_DIM;
        int32_t far = node + bonds->paths.shift[k];
        int square = 0;
        for (int d = 0; d < PD_DIM; d++) square += n[d] * n[d];
        if (square > PDI_QUADRATIC_SQUARE || bonds->grid->kind[far] == PD_INLET) continue;
        if (row >= 0 && !pdi_bond_open(bonds, row, k)) continue;
        for (int d = 0; d < PD_DIM; d++) place[d] = at[d] + s->xi[k * PD_DIM + d];
        pdi_quadratic_value(&fit, place, f[far]);
    }
    return pdi_quadratic_solve(&fit);
}

PDI_FN void pdi_reconstruct_free(pd_ctx *ctx, pd_reconstruct *slopes)
{
    pdi_owner_free(ctx, pdi_reconstruct_list, slopes);
    memset(slopes, 0, sizeof *slopes);
}

#undef PDI_RECONSTRUCT_TERMS
#undef PDI_RECONSTRUCT_MIN_PIVOT
