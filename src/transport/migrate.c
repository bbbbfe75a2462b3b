/* migrate: see migrate.h
 *
 * Design: of B(w) = w/(exp(w) - 1) the even part E = (w/2) coth(w/2) is kept, B(w) = E - w/2 and B(-w) = E + w/2. Where
 * w is small E is a polynomial. Else expm1 is one too, over a power of 2. All is plain arithmetic without branches, so
 * loops over a block are vectors, and single bonds have the same bits.
 */
#include "transport/migrate.h"
#include "lattice/bond_diffusivity.h"
#include "lattice/node_loop.h"
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#if PDI_FLUX_FIELDS > 32
#error "the sums of a block stand on the stack"
#endif

/* |w| up to which E is its series: the first term left out is below the rounding of 1. */
#define PDI_MIGRATE_SMALL 0.4
/* |w| from which B is 0 uphill: exp(w) has the largest exponent below it. */
#define PDI_MIGRATE_LARGE 700.0
/* Added to a number of less than 2^51 it leaves the nearest integer in the last bits. */
#define PDI_MIGRATE_ROUND 6755399441055744.0
/* 1/ln 2, and ln 2 in two parts: multiples of the first one are exact. */
#define PDI_MIGRATE_PER_LN2 1.44269504088896338700
#define PDI_MIGRATE_LN2_HIGH 6.93147180369123816490e-01
#define PDI_MIGRATE_LN2_LOW 1.90821492927058770002e-10

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

/* expm1(x) for x between PDI_MIGRATE_SMALL and PDI_MIGRATE_LARGE: x = k ln 2 + r, and expm1(r) in powers of r. */
static inline double pdi_migrate_expm1(double x)
{
    double shift = x * PDI_MIGRATE_PER_LN2 + PDI_MIGRATE_ROUND, power;
    double k = shift - PDI_MIGRATE_ROUND, r = (x - k * PDI_MIGRATE_LN2_HIGH) - k * PDI_MIGRATE_LN2_LOW;
    double s = r * r, f = s * s;
    double low = (1.0 / 2.0 + r * (1.0 / 6.0)) + s * (1.0 / 24.0 + r * (1.0 / 120.0));
    double middle = (1.0 / 720.0 + r * (1.0 / 5040.0)) + s * (1.0 / 40320.0 + r * (1.0 / 362880.0));
    double high = (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) + s * (1.0 / 479001600.0 + r * (1.0 / 6227020800.0));
    uint64_t bits;
    memcpy(&bits, &shift, sizeof bits);
    bits = (bits << 52) + UINT64_C(0x3ff0000000000000); /* 2^k */
    memcpy(&power, &bits, sizeof power);
    return power * (r + s * (low + f * (middle + f * high))) + (power - 1.0);
}

PDI_INLINE pdi_migrate_shares pdi_migrate_of(double w)
{
    pdi_migrate_shares s;
    double x = fabs(w), little = x < PDI_MIGRATE_SMALL ? w : 0.0, even = pdi_migrate_even(little);
    double much = x < PDI_MIGRATE_SMALL ? PDI_MIGRATE_SMALL : x;
    double most = much < PDI_MIGRATE_LARGE ? much : PDI_MIGRATE_LARGE, low = most / pdi_migrate_expm1(most);
    low = much < PDI_MIGRATE_LARGE ? low : 0.0; /* B(x) */
    s.near = x < PDI_MIGRATE_SMALL ? even - 0.5 * w : w > 0.0 ? low : low + x;
    s.far = x < PDI_MIGRATE_SMALL ? even + 0.5 * w : w > 0.0 ? low + x : low;
    double even_by = pdi_migrate_even_by(little), low_by = low * (1.0 - low - much) / much; /* B'(x) */
    s.near_by = x < PDI_MIGRATE_SMALL ? even_by - 0.5 : w > 0.0 ? low_by : -1.0 - low_by;
    s.far_by = x < PDI_MIGRATE_SMALL ? even_by + 0.5 : w > 0.0 ? 1.0 + low_by : -low_by;
    return s;
}

/* 1: a bond conducts beside what the flow carries. */
static inline int pdi_migrate_open(double bond, double flux) { return bond > DBL_EPSILON * fabs(flux); }

/* w of a bond: the rise of the energy against the drift. A bond that does not conduct has none. */
static inline double pdi_migrate_drift(double bond, double flux, double rise)
{
    int open = pdi_migrate_open(bond, flux);
    double w = rise - flux / (open ? bond : 1.0);
    return open ? w : 0.0;
}

/* What leaves through a bond with w; by: the derivative along the changes of both ends and of the rise. */
PDI_INLINE_HOT double pdi_migrate_bond(double bond, double flux, double w, double near, double far, int by,
                                       double move_near, double move_far, double lift)
{
    pdi_migrate_shares s = pdi_migrate_of(w);
    double from = by ? move_near : near, to = by ? move_far : far, along = s.near * from - s.far * to;
    if (by) along += (s.near_by * near - s.far_by * far) * lift;
    double conducted = bond * along, carried = flux * (flux > 0.0 ? from : to);
    return pdi_migrate_open(bond, flux) ? conducted : carried;
}

PDI_FN double pdi_migrate_leave(double bond, double flux, double rise, double near, double far)
{
    return pdi_migrate_bond(bond, flux, pdi_migrate_drift(bond, flux, rise), near, far, 0, 0.0, 0.0, 0.0);
}

PDI_FN double pdi_migrate_conduct(double rise, double near, double far)
{
    pdi_migrate_shares s = pdi_migrate_of(rise);
    return s.far_by * far - s.near_by * near;
}

/* Ends of the bonds of a block, with what they change by. */
typedef struct pdi_migrate_ends {
    const double *near, *far, *move_near, *move_far;
} pdi_migrate_ends;

/* w of a block. 1: it is small on all bonds, and they conduct. */
PDI_INLINE int pdi_migrate_drifts(const double *PD_RESTRICT bond, const double *PD_RESTRICT flux, int moves,
                                  double ratio, double charge, const double *PD_RESTRICT rise, int count,
                                  double *PD_RESTRICT w)
{
    int others = 0;
    for (int b = 0; b < count; b++) {
        double g = ratio * bond[b];
        w[b] = moves ? pdi_migrate_drift(g, flux[b], charge * rise[b]) : charge * rise[b];
        others += !(fabs(w[b]) < PDI_MIGRATE_SMALL) || (moves && !pdi_migrate_open(g, flux[b]));
    }
    return !others;
}

/* A small w on all bonds of a block: the same bits as pdi_migrate_bond. */
PDI_INLINE void pdi_migrate_smooth(const double *PD_RESTRICT bond, double ratio, double charge,
                                   const double *PD_RESTRICT w, pdi_migrate_ends ends, int by,
                                   const double *PD_RESTRICT lift, int count, double *PD_RESTRICT sum)
{
    const double *PD_RESTRICT from = by ? ends.move_near : ends.near, *PD_RESTRICT to = by ? ends.move_far : ends.far;
    for (int b = 0; b < count; b++) {
        double even = pdi_migrate_even(w[b]), rises = by ? pdi_migrate_even_by(w[b]) : 0.0;
        double along = (even - 0.5 * w[b]) * from[b] - (even + 0.5 * w[b]) * to[b];
        if (by) along += ((rises - 0.5) * ends.near[b] - (rises + 0.5) * ends.far[b]) * (charge * lift[b]);
        sum[b] += ratio * bond[b] * along;
    }
}

/* Any w. */
PDI_INLINE void pdi_migrate_steep(const double *PD_RESTRICT bond, const double *PD_RESTRICT flux, double ratio,
                                  double charge, const double *PD_RESTRICT w, pdi_migrate_ends ends, int by,
                                  const double *PD_RESTRICT lift, int count, double *PD_RESTRICT sum)
{
    for (int b = 0; b < count; b++)
        sum[b] += pdi_migrate_bond(ratio * bond[b], flux[b], w[b], ends.near[b], ends.far[b], by,
                                   by ? ends.move_near[b] : 0.0, by ? ends.move_far[b] : 0.0,
                                   by ? charge * lift[b] : 0.0);
}

/* What walls give that hold. */
static void pdi_migrate_walls(const pdi_migrate *m, int32_t i, int n, int count, double *sum)
{
    const double *hold = m->flux->diffusion->wall_rate;
    int64_t total = m->flux->bonds->grid->total;
    int by = m->lift != NULL;
    if (!hold || !(m->wall[n] == m->wall[n])) return;
    for (int b = 0; b < count; b++) {
        int64_t at = n * total + i + b;
        if (!(hold[i + b] > 0.0)) continue;
        double bond = m->ratio[n] * hold[i + b] * (m->pass ? m->pass[i + b] : 1.0), z = -m->charge[n];
        sum[b] += pdi_migrate_bond(bond, 0.0, z * m->psi[i + b], m->c[at], m->wall[n], by,
                                   m->move ? m->move[at] : 0.0, 0.0, by ? z * m->lift[i + b] : 0.0);
    }
}

PDI_INLINE void pdi_migrate_block(const pdi_migrate *m, int32_t i, int32_t row, int32_t place, int count, int by)
{
    int64_t total = m->flux->bonds->grid->total;
    double sum[PDI_FLUX_FIELDS][PDI_BLOCK], flux[PDI_BLOCK], bond[PDI_BLOCK], rise[PDI_BLOCK], lift[PDI_BLOCK];
    double w[PDI_BLOCK];
    int moves = m->flux->flow != NULL;
    for (int n = 0; n < m->count; n++) {
        for (int b = 0; b < count; b++) sum[n][b] = 0.0;
        pdi_migrate_walls(m, i, n, count, sum[n]);
    }
    for (int k = 0; k < m->flux->bonds->stencil->count; k++) {
        int32_t next = pdi_flux_bonds(m->flux, i, row, place, k, count, flux, bond);
        for (int b = 0; b < count; b++) {
            rise[b] = m->psi[i + next + b] - m->psi[i + b];
            lift[b] = by ? m->lift[i + next + b] - m->lift[i + b] : 0.0;
        }
        for (int b = 0; b < count && m->pass; b++)
            bond[b] *= pdi_bond_diffusivity_harmonic_mean(m->pass[i + b], m->pass[i + next + b]);
        for (int n = 0; n < m->count; n++) {
            pdi_migrate_ends ends;
            ends.near = m->c + n * total + i;
            ends.far = ends.near + next;
            ends.move_near = m->move ? m->move + n * total + i : pdi_migrate_still;
            ends.move_far = m->move ? ends.move_near + next : pdi_migrate_still;
            double ratio = m->ratio[n], z = m->charge[n];
            if (pdi_migrate_drifts(bond, flux, moves, ratio, z, rise, count, w))
                pdi_migrate_smooth(bond, ratio, z, w, ends, by, lift, count, sum[n]);
            else pdi_migrate_steep(bond, flux, ratio, z, w, ends, by, lift, count, sum[n]);
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
    if (PDI_SINGLE_NODE(place)) pdi_migrate_block(m, i, row, place, 1, m->lift != NULL);
    else if (PDI_FULL_BLOCK(count) && m->lift) pdi_migrate_block(m, i, row, -1, PDI_BLOCK, 1);
    else if (PDI_FULL_BLOCK(count)) pdi_migrate_block(m, i, row, -1, PDI_BLOCK, 0);
    else pdi_migrate_block(m, i, row, place, count, m->lift != NULL);
}

PDI_FN void pdi_migrate_apply(const pd_ctx *ctx, const pdi_migrate *m)
{
    const pd_bonds *bonds = m->flux->bonds;
    pdi_node_loop_by_blocks(ctx, m->flux->boundary, bonds->grid->fluid_count * bonds->stencil->count * 8 * m->count,
                            pdi_migrate_nodes, m);
}
