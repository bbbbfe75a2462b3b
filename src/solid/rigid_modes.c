/* rigid_modes: see rigid_modes.h */
#include "solid/rigid_modes.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* A motion is free where its sum of squares over prescribed components is below this share. */
#define PDI_RIGID_MODES_ROUNDING 1e-9

/* All translations, then rotations, at point i, into way [mode][PD_DIM] [-]; rotations have lengths over r->size. */
static void pdi_rigid_modes_eval_modes(const pd_rigid_modes *r, int32_t i, double way[PD_RIGID_MODE_COUNT][PD_DIM])
{
    double x[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) x[d] = (r->body->position[(int64_t)i * PD_DIM + d] - r->origin[d]) / r->size;
    for (int m = 0; m < PD_RIGID_MODE_COUNT; m++) {
        int a = PD_DIM == 2 ? 0 : (m + 1) % PD_DIM, b = PD_DIM == 2 ? PD_DIM - 1 : (m + 2) % PD_DIM;
        for (int d = 0; d < PD_DIM; d++) way[m][d] = d == m ? 1.0 : 0.0;
        if (m < PD_DIM) continue;
        way[m][a] = -x[b];
        way[m][b] = x[a];
    }
}

/* The r->motions free motions at point i, into left. */
static void pdi_rigid_modes_eval_free_modes(const pd_rigid_modes *r, int32_t i,
                                            double left[PD_RIGID_MODE_COUNT][PD_DIM])
{
    double way[PD_RIGID_MODE_COUNT][PD_DIM];
    pdi_rigid_modes_eval_modes(r, i, way);
    for (int f = 0; f < r->motions; f++)
        for (int d = 0; d < PD_DIM; d++) {
            left[f][d] = 0.0;
            for (int m = 0; m < PD_RIGID_MODE_COUNT; m++) left[f][d] += r->motion[f][m] * way[m][d];
        }
}

/* Gram matrix a of all rigid motions over the prescribed components of the component. Returns how many components that
 * are; 0: a is zero. */
static double pdi_rigid_modes_assemble_gram(const pd_rigid_modes *r, const uint8_t *held,
                                            double a[PD_RIGID_MODE_COUNT][PD_RIGID_MODE_COUNT])
{
    double way[PD_RIGID_MODE_COUNT][PD_DIM], all = 0.0;
    memset(a, 0, PD_RIGID_MODE_COUNT * sizeof a[0]);
    for (int32_t n = 0; n < r->count && held; n++) {
        pdi_rigid_modes_eval_modes(r, r->component[n], way);
        for (int d = 0; d < PD_DIM; d++) {
            if (!held[(int64_t)r->component[n] * PD_DIM + d]) continue;
            all += 1.0;
            for (int m = 0; m < PD_RIGID_MODE_COUNT; m++)
                for (int k = 0; k < PD_RIGID_MODE_COUNT; k++) a[m][k] += way[m][d] * way[k][d];
        }
    }
    return all;
}

/* Null space of the Gram matrix by Gauss-Jordan elimination with full pivoting: the free motions, into motion and
 * motions of r. Pivots up to min_pivot count as zero. a is overwritten. */
static void pdi_rigid_modes_compute_null_space(pd_rigid_modes *r, double a[PD_RIGID_MODE_COUNT][PD_RIGID_MODE_COUNT],
                                               double min_pivot)
{
    int pivot[PD_RIGID_MODE_COUNT] = {0};
    for (;;) {
        int p = -1;
        for (int m = 0; m < PD_RIGID_MODE_COUNT; m++)
            if (!pivot[m] && a[m][m] > min_pivot && (p < 0 || a[m][m] > a[p][p])) p = m;
        if (p < 0) break;
        double over = 1.0 / a[p][p];
        for (int k = 0; k < PD_RIGID_MODE_COUNT; k++) a[p][k] *= over;
        for (int m = 0; m < PD_RIGID_MODE_COUNT; m++) {
            double part = a[m][p];
            for (int k = 0; k < PD_RIGID_MODE_COUNT && m != p; k++) a[m][k] -= part * a[p][k];
        }
        pivot[p] = 1;
    }
    for (int f = 0; f < PD_RIGID_MODE_COUNT; f++) {
        if (pivot[f]) continue;
        for (int m = 0; m < PD_RIGID_MODE_COUNT; m++)
            r->motion[r->motions][m] = m == f ? 1.0 : pivot[m] ? -a[m][f] : 0.0;
        r->motions++;
    }
}

PDI_FN void pdi_rigid_modes_compute(const pd_body *body, const uint8_t *held, const int32_t *piece, int32_t count,
                                    pd_rigid_modes *r)
{
    double squares[PD_RIGID_MODE_COUNT][PD_RIGID_MODE_COUNT];
    memset(r, 0, sizeof *r);
    r->body = body;
    r->component = piece;
    r->count = count;
    r->size = body->horizon;
    memcpy(r->origin, body->position + (int64_t)piece[0] * PD_DIM, sizeof r->origin);
    for (int32_t n = 0; n < count; n++)
        for (int d = 0; d < PD_DIM; d++)
            r->size = pd_max(r->size, fabs(body->position[(int64_t)piece[n] * PD_DIM + d] - r->origin[d]));
    double all = pdi_rigid_modes_assemble_gram(r, held, squares);
    pdi_rigid_modes_compute_null_space(r, squares, PDI_RIGID_MODES_ROUNDING * all);
}

PDI_FN double pdi_rigid_modes_relative_work(const pd_rigid_modes *r, const uint8_t *held, const double *load)
{
    double left[PD_RIGID_MODE_COUNT][PD_DIM], work[PD_RIGID_MODE_COUNT] = {0.0}, size = 0.0, most = 0.0;
    for (int32_t n = 0; n < r->count && r->motions; n++) {
        int64_t first = (int64_t)r->component[n] * PD_DIM;
        pdi_rigid_modes_eval_free_modes(r, r->component[n], left);
        for (int d = 0; d < PD_DIM; d++) {
            double force = held && held[first + d] ? 0.0 : r->body->volume[r->component[n]] * load[first + d];
            size += fabs(force);
            for (int f = 0; f < r->motions; f++) work[f] += force * left[f][d];
        }
    }
    for (int f = 0; f < r->motions; f++) most = pd_max(most, fabs(work[f]));
    return size > 0.0 ? most / size : 0.0;
}

PDI_FN void pdi_rigid_modes_remove(const pd_rigid_modes *r, double *u)
{
    double a[PD_RIGID_MODE_COUNT * PD_RIGID_MODE_COUNT] = {0.0}, mean[PD_RIGID_MODE_COUNT] = {0.0};
    double left[PD_RIGID_MODE_COUNT][PD_DIM], least[PD_RIGID_MODE_COUNT] = {0.0};
    for (int32_t n = 0; n < r->count; n++) {
        pdi_rigid_modes_eval_free_modes(r, r->component[n], left);
        for (int d = 0; d < PD_DIM; d++)
            for (int f = 0; f < r->motions; f++) {
                double part = r->body->volume[r->component[n]] * left[f][d];
                mean[f] += part * u[(int64_t)r->component[n] * PD_DIM + d];
                for (int g = 0; g < r->motions; g++) a[f * PD_RIGID_MODE_COUNT + g] += part * left[g][d];
            }
    }
    for (int f = 0; f < r->motions; f++) least[f] = PDI_RIGID_MODES_ROUNDING * a[f * (PD_RIGID_MODE_COUNT + 1)];
    if (!r->motions || !pdi_vec_cholesky(r->motions, PD_RIGID_MODE_COUNT, least, a)) return;
    pdi_vec_cholesky_solve(r->motions, PD_RIGID_MODE_COUNT, a, mean);
    for (int32_t n = 0; n < r->count; n++) {
        pdi_rigid_modes_eval_free_modes(r, r->component[n], left);
        for (int d = 0; d < PD_DIM; d++)
            for (int f = 0; f < r->motions; f++) u[(int64_t)r->component[n] * PD_DIM + d] -= mean[f] * left[f][d];
    }
}

#undef PDI_RIGID_MODES_ROUNDING
