/* bend: the antidiffusive flux of a bond, and its derivatives (theory: eq. 6.15).
 *
 * A Newton step takes the derivative along many directions at one field. Where there is room, what depends on the field
 * alone is kept for it, in single precision: an iteration of GMRES leaves three digits at most.
 */
#ifndef PD_BEND_H
#define PD_BEND_H
#include "lattice/bond.h"
#include "solve/krylov.h"
#include <float.h>
#include <math.h>

typedef struct pd_bend {
    const pd_bonds *bonds; /* borrowed */
    float *kept;           /* [count/2][3][total] derivatives by alpha, by the step and by the bend, for the first half
                            * of the bonds; lent, else NULL */
} pd_bend;

#ifdef PDI_INTERNAL
/* Share of xi.(G_u - G_v) in the bend of a bond: third order in a uniform stream (theory: eq. 6.16). */
#define PDI_BEND_SHARE (1.0 / 3.0)
/* Share of what its step lacks against the mean gradient of its ends: damps what alternates from node to node, which a
 * central flux does not see. */
#define PDI_BEND_LEAN 0.3

/* What the antidiffusive flux of a bond is made of: its step of the field, its bend m, and alpha of the upwind end. */
typedef struct pdi_bend_terms {
    double step, bend, alpha;
} pdi_bend_terms;

/* m of a bond, from xi.G of the upwind end and of the other one (eq. 6.15). */
static inline double pdi_bend_of(double step, double upwind, double other)
{
    return PDI_BEND_SHARE * (upwind - other) + PDI_BEND_LEAN * (0.5 * (upwind + other) - step);
}

/* alpha d (e + the limited bend) of one bond, d being what upwinding adds to the conductance `least` (eq. 6.15). share:
 * 0: without the bend. by: NULL, or room for its derivatives by what it is made of. Squares that are no normal numbers
 * do not show how step and bend compare: such bends count in full. */
PDI_INLINE double pdi_bend_flux(double flux, double least, double share, const pdi_bend_terms *of,
                                pdi_bend_terms *by)
{
    double square = of->step * of->step, sum = square + of->bend * of->bend;
    double excess = 0.5 * fabs(flux) - least, most = excess > 0.0 ? excess : 0.0;
    double over = sum >= DBL_MIN ? 1.0 / sum : 0.0, weight = sum >= DBL_MIN ? square * over : 1.0;
    double given = of->step + share * weight * of->bend;
    if (by) {
        by->alpha = most * given;
        by->bend = most * of->alpha * share * weight * (2.0 * weight - 1.0);
        by->step = most * of->alpha * (1.0 + share * 2.0 * (1.0 - weight) * of->bend * of->step * over);
    }
    return of->alpha * most * given;
}

/* The derivative along a direction. */
PDI_INLINE double pdi_bend_along(const pdi_bend_terms *by, const pdi_bend_terms *along)
{
    return by->alpha * along->alpha + by->step * along->step + by->bend * along->bend;
}

/* Partial derivatives that are kept for bond k of node i: those by alpha; by the step and the bend behind them. */
static inline float *pdi_bend_kept(const pd_bend *t, int32_t i, int k)
{
    return t->kept + (int64_t)k * 3 * t->bonds->grid->total + i;
}

/* Keep those of a node, for the bond that leaves node i: as its near end has them, or (turn) as the far end does. */
static inline void pdi_bend_keep(const pd_bend *t, int32_t i, int k, double turn, const pdi_bend_terms *by)
{
    int64_t total = t->bonds->grid->total;
    float *kept = pdi_bend_kept(t, i, k);
    kept[0] = (float)(turn * by->alpha);
    kept[total] = (float)(fabs(turn) * by->step);
    kept[2 * total] = (float)(fabs(turn) * by->bend);
}

static inline pdi_bend_terms pdi_bend_recall(const pd_bend *t, const float *kept, int b, double turn)
{
    int64_t total = t->bonds->grid->total;
    pdi_bend_terms by;
    by.alpha = turn * (double)kept[b];
    by.step = fabs(turn) * (double)kept[b + total];
    by.bend = fabs(turn) * (double)kept[b + 2 * total];
    return by;
}

/* Lend `kept` in place of vectors of a basis that is not lent, where as many are left as a restart asks for, and sizes
 * of fields [mol/m3] times rates of bonds [1/s] are numbers of single precision. */
PDI_FN void pdi_bend_lend(pd_ctx *ctx, pd_arena *arena, double size, double rate, pd_krylov *krylov, pd_bend *bend);
/* What was lent goes back. */
PDI_FN pd_status pdi_bend_return(pd_ctx *ctx, pd_arena *arena, pd_status status, pd_krylov *krylov, pd_bend *bend);
#endif

#endif
