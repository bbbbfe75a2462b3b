/* migrate: see migrate.h
 *
 * Design: of B(w) = w/(exp(w) - 1) the even part E = (w/2) coth(w/2) is kept, B(w) = E - w/2 and B(-w) = E + w/2. Where
 * w is small for a whole block, which is so but for sharp fronts, E is a polynomial and the loops are plain vectors.
 */
#include "transport/migrate.h"
#include "lattice/media.h"
#include "lattice/traverse.h"
#include <float.h>
#include <math.h>

#if PDI_FLUX_FIELDS > 32
#error "the sums of a block stand on the stack"
#endif

/* |w| up to which E is its series: the first term left out is below the rounding of 1. */
#define PDI_MIGRATE_SMALL 0.4

/* Of fields that do not change. */
static const double pdi_migrate_still[PDI_BLOCK] = {0.0};

/* E and its derivative for small w. */
static inline double pdi_migrate_even(double w)
{
    double s = w * w;
    return 1.0 + s * (1.0 / 12.0 - s * (1.0 / 720.0 - s * (1.0 / 30240.0 - s * (1.0 / 1209600.0 - s * (1.0 / 47900160.0
           - s * (691.0 / 1307674368000.0))))));
}

static inline double pdi_migrate_even_by(double w)
{
    double s = w * w;
    return w * (1.0 / 6.0 - s * (1.0 / 180.0 - s * (1.0 / 5040.0 - s * (1.0 / 151200.0 - s * (1.0 / 4790016.0
           - s * (691.0 / 108972864000.0))))));
}

/* Shares that leave the near and the far end, and the derivatives of both by w. */
typedef struct pdi_migrate_shares {
    double near, far, near_by, far_by;
} pdi_migrate_shares;

static inline pdi_migrate_shares pdi_migrate_of(double w)
{
    pdi_migrate_shares s;
    double x = fabs(w);
    if (x < PDI_MIGRATE_SMALL) {
        double even = pdi_migrate_even(w), by = pdi_migrate_even_by(w);
        s.near = even - 0.5 * w;
        s.far = even + 0.5 * w;
        s.near_by = by - 0.5;
        s.far_by = by + 0.5;
        return s;
    }
    double low = x < 700.0 ? x / expm1(x) : 0.0, by = low * (1.0 - low - x) / x; /* B(x) and B'(x) */
    s.near = w > 0.0 ? low : low + x;
    s.far = w > 0.0 ? low + x : low;
    s.near_by = w > 0.0 ? by : -1.0 - by;
    s.far_by = w > 0.0 ? 1.0 + by : -by;
    return s;
}

/* w of a bond: the rise of the energy against the drift. A bond that does not conduct has none. */
static inline double pdi_migrate_drift(double bond, double flux, double rise)
{
    return bond > DBL_EPSILON * fabs(flux) ? rise - flux / bond : 0.0;
}

PDI_FN double pdi_migrate_leave(double bond, double flux, double rise, double near, double far)
{
    if (!(bond > DBL_EPSILON * fabs(flux))) return flux * (flux > 0.0 ? near : far);
    pdi_migrate_shares s = pdi_migrate_of(pdi_migrate_drift(bond, flux, rise));
    return bond * (s.near * near - s.far * far);
}

PDI_FN double pdi_migrate_conduct(double rise, double near, double far)
{
    pdi_migrate_shares s = pdi_migrate_of(rise);
    return s.far_by * far - s.near_by * near;
}

/* One bond, its value or its derivative along the changes of both ends and of the rise. */
static inline double pdi_migrate_one(double bond, double flux, double rise, double near, double far, int by,
                                     double move_near, double move_far, double lift)
{
    if (!by) return pdi_migrate_leave(bond, flux, rise, near, far);
    if (!(bond > DBL_EPSILON * fabs(flux))) return flux * (flux > 0.0 ? move_near : move_far);
    pdi_migrate_shares s = pdi_migrate_of(pdi_migrate_drift(bond, flux, rise));
    return bond * (s.near * move_near - s.far * move_far + (s.near_by * near - s.far_by * far) * lift);
}

/* Fluid at rest and a small rise for all of a block: the same bits as pdi_migrate_one. */
PDI_INLINE void pdi_migrate_smooth(const double *PD_RESTRICT bond, double ratio, double charge,
                                   const double *PD_RESTRICT rise, const double *PD_RESTRICT near,
                                   const double *PD_RESTRICT far, int count, double *PD_RESTRICT sum)
{
    for (int b = 0; b < count; b++) {
        double w = charge * rise[b], even = pdi_migrate_even(w);
        sum[b] += ratio * bond[b] * ((even - 0.5 * w) * near[b] - (even + 0.5 * w) * far[b]);
    }
}

PDI_INLINE void pdi_migrate_smooth_by(const double *PD_RESTRICT bond, double ratio, double charge,
                                      const double *PD_RESTRICT rise, const double *PD_RESTRICT near,
                                      const double *PD_RESTRICT far, const double *PD_RESTRICT move_near,
                                      const double *PD_RESTRICT move_far, const double *PD_RESTRICT lift, int count,
                                      double *PD_RESTRICT sum)
{
    for (int b = 0; b < count; b++) {
        double w = charge * rise[b], even = pdi_migrate_even(w), by = pdi_migrate_even_by(w);
        sum[b] += ratio * bond[b] * ((even - 0.5 * w) * move_near[b] - (even + 0.5 * w) * move_far[b] +
                                     ((by - 0.5) * near[b] - (by + 0.5) * far[b]) * (charge * lift[b]));
    }
}

/* What walls give that hold. */
static void pdi_migrate_walls(const pdi_migrate *m, int32_t i, int n, int count, double *sum)
{
    const double *hold = m->flux->diffusion->wall_rate;
    int64_t total = m->flux->bonds->grid->total, by = m->lift != NULL;
    if (!hold || !(m->wall[n] == m->wall[n])) return;
    for (int b = 0; b < count; b++) {
        int64_t at = n * total + i + b;
        if (!(hold[i + b] > 0.0)) continue;
        double bond = m->ratio[n] * hold[i + b] * (m->pass ? m->pass[i + b] : 1.0), z = -m->charge[n];
        sum[b] += pdi_migrate_one(bond, 0.0, z * m->psi[i + b], m->c[at], m->wall[n], (int)by,
                                  m->move ? m->move[at] : 0.0, 0.0, by ? z * m->lift[i + b] : 0.0);
    }
}

PDI_INLINE void pdi_migrate_block(const pdi_migrate *m, int32_t i, int32_t row, int32_t place, int count)
{
    int64_t total = m->flux->bonds->grid->total;
    double sum[PDI_FLUX_FIELDS][PDI_BLOCK], flux[PDI_BLOCK], bond[PDI_BLOCK], rise[PDI_BLOCK], lift[PDI_BLOCK];
    int by = m->lift != NULL, moves = m->flux->flow != NULL;
    double most = 0.0;
    for (int n = 0; n < m->count; n++) {
        for (int b = 0; b < count; b++) sum[n][b] = 0.0;
        pdi_migrate_walls(m, i, n, count, sum[n]);
        most = pdi_max(most, fabs(m->charge[n]));
    }
    for (int k = 0; k < m->flux->bonds->stencil->count; k++) {
        int32_t next = pdi_flux_bonds(m->flux, i, row, place, k, count, flux, bond);
        double steep = 0.0;
        for (int b = 0; b < count; b++) {
            rise[b] = m->psi[i + next + b] - m->psi[i + b];
            lift[b] = by ? m->lift[i + next + b] - m->lift[i + b] : 0.0;
            steep = pdi_max(steep, fabs(rise[b]));
        }
        for (int b = 0; b < count && m->pass; b++) bond[b] *= pdi_media_harmonic(m->pass[i + b], m->pass[i + next + b]);
        int smooth = !moves && steep * most < PDI_MIGRATE_SMALL;
        for (int n = 0; n < m->count; n++) {
            const double *near = m->c + n * total + i, *far = near + next;
            const double *here = m->move ? m->move + n * total + i : pdi_migrate_still;
            const double *there = m->move ? here + next : pdi_migrate_still;
            double ratio = m->ratio[n], z = m->charge[n];
            if (smooth && !by) pdi_migrate_smooth(bond, ratio, z, rise, near, far, count, sum[n]);
            else if (smooth)
                pdi_migrate_smooth_by(bond, ratio, z, rise, near, far, here, there, lift, count, sum[n]);
            else
                for (int b = 0; b < count; b++)
                    sum[n][b] += pdi_migrate_one(ratio * bond[b], flux[b], z * rise[b], near[b], far[b], by, here[b],
                                                 there[b], z * lift[b]);
        }
    }
    for (int s = 0; s < m->sums; s++) {
        double *PD_RESTRICT y = m->y + s * total + i;
        const double *weight = m->weight + (int64_t)s * m->count;
        for (int b = 0; b < count; b++) y[b] = 0.0;
        for (int n = 0; n < m->count; n++)
            for (int b = 0; b < count && weight[n] != 0.0; b++) y[b] += weight[n] * sum[n][b];
    }
}

static void pdi_migrate_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_migrate *m = (const pdi_migrate *)user;
    if (PDI_SINGLE(place)) pdi_migrate_block(m, i, row, place, 1);
    else if (PDI_WHOLE(count)) pdi_migrate_block(m, i, row, -1, PDI_BLOCK);
    else pdi_migrate_block(m, i, row, place, count);
}

PDI_FN void pdi_migrate_apply(const pd_ctx *ctx, const pdi_migrate *m)
{
    const pd_bonds *bonds = m->flux->bonds;
    pdi_traverse_blocks(ctx, m->flux->boundary, bonds->grid->fluid_count * bonds->stencil->count * 8 * m->count,
                        pdi_migrate_nodes, m);
}
