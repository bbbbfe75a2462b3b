/* precrack: see precrack.h */
#include "solid/precrack.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Rounding of positions, over the horizon, and over the largest coordinate (16 units in the last place). */
#define PDI_PRECRACK_ROUNDING 1e-9
#define PDI_PRECRACK_DIGITS 3.6e-15
/* Tolerances of a polygon over its size: distance of corners from its plane, of corners outside of its edges; and twice
 * its least area over the square of the size. */
#define PDI_PRECRACK_FLATNESS 1e-6

/* A pre-crack with its plane. Corner k is corner (first + k way) of the caller, so that the result does not depend on
 * the order of corners. */
typedef struct pdi_precrack_plane {
    const pd_precrack *cut;
    int first, step;
    double normal[PD_DIM]; /* [-] towards the upper side */
    double orientation;    /* [-] 1: corners go around the normal; -1: against it */
    double lo[PD_DIM], hi[PD_DIM], size; /* [m] */
    double tolerance;                    /* [m] distances that count as none */
} pdi_precrack_plane;

/* Upper bound of the bond length [m]. */
static double pdi_precrack_max_bond_length(const pd_body *body) { return 1.001 * body->horizon + body->spacing; }

/* Position [PD_DIM] [m] of corner k in the sorted order, k modulo the number of corners. */
static const double *pdi_precrack_get_corner(const pdi_precrack_plane *p, int k)
{
    int n = p->cut->corners;
    return p->cut->corner + (int64_t)((p->first + (int64_t)k * p->step) % n) * PD_DIM;
}

/* c = a - b. */
static void pdi_precrack_subtract(const double *a, const double *b, double *c)
{
    for (int d = 0; d < PD_DIM; d++) c[d] = a[d] - b[d];
}

/* c += a x b, in 3D. */
static void pdi_precrack_add_cross_product(const double *a, const double *b, double *c)
{
    for (int d = 0; d < PD_DIM; d++) {
        int e = (d + 1) % PD_DIM, f = (d + 2) % PD_DIM;
        c[d] += a[e] * b[f] - a[f] * b[e];
    }
}

/* Lexicographic order of two positions: -1, 0, 1. */
static int pdi_precrack_compare_positions(const double *a, const double *b)
{
    for (int d = 0; d < PD_DIM; d++)
        if (a[d] < b[d] || a[d] > b[d]) return a[d] < b[d] ? -1 : 1;
    return 0;
}

/* Sorted order of corners, into first and step: begins at the smallest one and goes to the smaller of its
 * neighbours. */
static void pdi_precrack_sort_corners(pdi_precrack_plane *p)
{
    const double *x = p->cut->corner;
    int n = p->cut->corners;
    p->first = 0;
    for (int k = 1; k < n; k++)
        if (pdi_precrack_compare_positions(x + (int64_t)k * PD_DIM, x + (int64_t)p->first * PD_DIM) < 0) p->first = k;
    int next = (p->first + 1) % n, last = (p->first + n - 1) % n;
    p->step = pdi_precrack_compare_positions(x + (int64_t)next * PD_DIM, x + (int64_t)last * PD_DIM) <= 0 ? 1 : n - 1;
}

/* Distance [m] of position x from edge k of a polygon within its plane, or from end k of a segment along it; negative
 * outside. -HUGE_VAL: the edge has no length. */
static double pdi_precrack_edge_distance(const pdi_precrack_plane *p, int k, const double *x)
{
    const double *from = pdi_precrack_get_corner(p, k);
    double edge[PD_DIM], off[PD_DIM], in[PD_DIM] = {0.0};
    pdi_precrack_subtract(pdi_precrack_get_corner(p, k + 1), from, edge);
    pdi_precrack_subtract(x, from, off);
    double length = pdi_vec_norm(edge);
    if (!(length > 0.0)) return -HUGE_VAL;
    if (PD_DIM < 3) return pdi_vec_dot(off, edge) / length;
    pdi_precrack_add_cross_product(p->normal, edge, in);
    return p->orientation * pdi_vec_dot(off, in) / length;
}

/* Signed distance [m] of position x from the plane, positive on the upper side; 0 within rounding. */
static double pdi_precrack_plane_distance(const pdi_precrack_plane *p, const double *x)
{
    double off[PD_DIM];
    pdi_precrack_subtract(x, pdi_precrack_get_corner(p, 0), off);
    double height = pdi_vec_dot(p->normal, off);
    return fabs(height) > p->tolerance ? height : 0.0;
}

/* 1: the bond from a position below the plane to one on or above it meets the pre-crack within its rim or on it, within
 * the tolerance; in 1D always. below < 0, above >= 0: their signed distances [m]. */
static int pdi_precrack_is_crossed(const pdi_precrack_plane *p, const double *lower, double below, const double *upper,
                                   double above)
{
    double place[PD_DIM], share = above / (above - below);
    for (int d = 0; d < PD_DIM; d++) place[d] = upper[d] + (lower[d] - upper[d]) * share;
    for (int k = 0; PD_DIM > 1 && k < p->cut->corners; k++)
        if (pdi_precrack_edge_distance(p, k, place) < -p->tolerance) return 0;
    return 1;
}

/* ---- cuts that make sense ---- */

/* Reports an invalid pre-crack: PD_ERR_ARGUMENT. */
static pd_status pdi_precrack_reject(pd_ctx *ctx, int index, const pd_precrack *cut, const char *text)
{
    const double *x = cut->corner;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "crack", "cut %d of %d corners, the first one at x = %g m: %s", index,
                   cut->corners, x && cut->corners > 0 ? x[0] : 0.0, text);
}

/* Sets bounding box and size (its diagonal) of the pre-crack. Returns 1; 0: a corner is not finite. */
static int pdi_precrack_compute_bounds(pdi_precrack_plane *p)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        p->lo[d] = HUGE_VAL;
        p->hi[d] = -HUGE_VAL;
        for (int k = 0; k < p->cut->corners; k++) {
            double x = p->cut->corner[(int64_t)k * PD_DIM + d];
            if (!(fabs(x) < 1e100)) return 0;
            p->lo[d] = pd_min(p->lo[d], x);
            p->hi[d] = pd_max(p->hi[d], x);
        }
        square += (p->hi[d] - p->lo[d]) * (p->hi[d] - p->lo[d]);
    }
    p->size = sqrt(square);
    return 1;
}

/* Sets the unit normal, which points up the last axis along which it has more than a 1e-6 component, and the
 * orientation. In 1D it is the axis. Returns 1; 0: there is no normal, as the cut has no length or area (below 1e-6 of
 * its size). */
static int pdi_precrack_compute_normal(pdi_precrack_plane *p)
{
    double edge[PD_DIM], next[PD_DIM], sum[PD_DIM] = {0.0};
    for (int d = 0; d < PD_DIM; d++) p->normal[d] = 1.0;
    p->orientation = 1.0;
    if (PD_DIM == 1) return 1;
    if (!(p->size > 0.0)) return 0;
    for (int k = 1; k < p->cut->corners; k++) { /* in sizes of the cut, of which squares have no overflow */
        pdi_precrack_subtract(pdi_precrack_get_corner(p, k), pdi_precrack_get_corner(p, 0), edge);
        pdi_precrack_subtract(pdi_precrack_get_corner(p, k + 1), pdi_precrack_get_corner(p, 0), next);
        for (int d = 0; d < PD_DIM; d++) edge[d] /= p->size, next[d] /= p->size;
        if (PD_DIM == 3) pdi_precrack_add_cross_product(edge, next, sum);
        else
            for (int d = 0; d < PD_DIM; d++) sum[d] = d ? edge[0] : -edge[PD_DIM - 1];
    }
    double length = pdi_vec_norm(sum), largest = 0.0;
    if (!(length > PDI_PRECRACK_FLATNESS)) return 0;
    for (int d = 0; d < PD_DIM; d++)
        if (fabs(sum[d]) > PDI_PRECRACK_FLATNESS * length) largest = sum[d];
    p->orientation = largest > 0.0 ? 1.0 : -1.0;
    for (int d = 0; d < PD_DIM; d++) p->normal[d] = p->orientation * sum[d] / length;
    return 1;
}

/* Checks a pre-crack and computes its plane; index: its number in messages, tolerance [m]: at least, extent [m]:
 * largest coordinate of the body. PD_ERR_ARGUMENT: as of pd_body_apply_precracks. */
static pd_status pdi_precrack_check(pd_ctx *ctx, const pd_precrack *cut, int index, double tolerance, double extent,
                                    pdi_precrack_plane *p)
{
    memset(p, 0, sizeof *p);
    p->cut = cut;
    if (!cut->corner || (PD_DIM < 3 ? cut->corners != PD_DIM : cut->corners < 3))
        return pdi_precrack_reject(ctx, index, cut,
                                   PD_DIM == 1   ? "expected 1, the place"
                                   : PD_DIM == 2 ? "expected 2, the ends of a segment"
                                                 : "expected at least 3, of a polygon");
    if (!pdi_precrack_compute_bounds(p)) return pdi_precrack_reject(ctx, index, cut, "expected finite corners");
    pdi_precrack_sort_corners(p);
    if (!pdi_precrack_compute_normal(p))
        return pdi_precrack_reject(ctx, index, cut,
                                   PD_DIM == 2 ? "a segment without length" : "a polygon without area");
    for (int d = 0; d < PD_DIM; d++) extent = pd_max(extent, pd_max(fabs(p->lo[d]), fabs(p->hi[d])));
    p->tolerance = pd_max(tolerance, PDI_PRECRACK_DIGITS * extent);
    if (PD_DIM == 2 && !(p->size > p->tolerance))
        return pdi_precrack_reject(ctx, index, cut, "a segment without length");
    for (int k = 0; PD_DIM == 3 && k < cut->corners; k++) {
        double off[PD_DIM];
        pdi_precrack_subtract(pdi_precrack_get_corner(p, k), pdi_precrack_get_corner(p, 0), off);
        if (fabs(pdi_vec_dot(p->normal, off)) > PDI_PRECRACK_FLATNESS * p->size)
            return pdi_precrack_reject(ctx, index, cut, "the corners do not lie in a plane");
        for (int e = 0; e < cut->corners; e++)
            if (pdi_precrack_edge_distance(p, e, pdi_precrack_get_corner(p, k)) < -PDI_PRECRACK_FLATNESS * p->size)
                return pdi_precrack_reject(ctx, index, cut, "not convex, or two corners at one place");
    }
    return PD_OK;
}

/* Checks all pre-cracks, into planes [count], and widens their bounding boxes by a bond length and the tolerance. */
static pd_status pdi_precrack_build_planes(pd_ctx *ctx, const pd_body *body, const pd_precrack *cuts, int count,
                                           pdi_precrack_plane *planes)
{
    double far = 0.0, reach = pdi_precrack_max_bond_length(body);
    for (int64_t k = 0; k < (int64_t)body->count * PD_DIM; k++) far = pd_max(far, fabs(body->position[k]));
    for (int c = 0; c < count; c++) {
        PD_TRY(pdi_precrack_check(ctx, &cuts[c], c, PDI_PRECRACK_ROUNDING * body->horizon, far, &planes[c]));
        for (int d = 0; d < PD_DIM; d++) {
            planes[c].lo[d] -= reach + planes[c].tolerance;
            planes[c].hi[d] += reach + planes[c].tolerance;
        }
    }
    return PD_OK;
}

/* ---- bonds ---- */

/* Marks the unbroken bonds of point i that cross pre-crack p as broken, at this end alone. Returns how many. */
static int64_t pdi_precrack_break_family(pd_body *body, const pdi_precrack_plane *p, int32_t i)
{
    const double *x = body->position + (int64_t)i * PD_DIM;
    int64_t found = 0;
    for (int d = 0; d < PD_DIM; d++)
        if (x[d] < p->lo[d] || x[d] > p->hi[d]) return 0;
    double own = pdi_precrack_plane_distance(p, x);
    if (fabs(own) > pdi_precrack_max_bond_length(body)) return 0;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double y[PD_DIM];
        if (pd_body_bond_is_broken(&f)) continue;
        memcpy(y, body->position + (int64_t)f.neighbour * PD_DIM, sizeof y);
        for (int d = 0; d < PD_DIM && f.image; d++) y[d] += pdi_body_bond_image(&f) * body->period[d];
        double other = pdi_precrack_plane_distance(p, y);
        if ((own < 0.0) == (other < 0.0)) continue;
        if (!(own < 0.0 ? pdi_precrack_is_crossed(p, x, own, y, other) : pdi_precrack_is_crossed(p, y, other, x, own)))
            continue;
        pdi_body_bonds_mark_broken(body, i, f.number);
        found++;
    }
    return found;
}

/* Periodic body: breaks the other ends of all broken bonds, which lie beyond a period and need not cross the pre-crack.
 * Returns how many ends were intact; 0 without a period. */
static int64_t pdi_precrack_break_reverse(pd_body *body)
{
    int64_t found = 0;
    for (int32_t i = 0; i < body->count && pd_body_is_periodic(body); i++)
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
            if (!pd_body_bond_is_broken(&f)) continue;
            pd_bond_iterator back = pd_body_bonds_begin(body, f.neighbour);
            back.number = pdi_body_bonds_find_reverse(body, i, &f);
            found += !pd_body_bond_is_broken(&back);
            pdi_body_bonds_mark_broken(body, f.neighbour, back.number);
        }
    return found;
}

/* Breaks the bonds that cross any pre-crack, families in parallel chunks. Returns how many bonds, each counted once. */
static int64_t pdi_precrack_break_bonds(const pd_ctx *ctx, pd_body *body, const pdi_precrack_plane *planes, int count)
{
    enum { parts = 256 };
    int64_t found[parts], all = 0, points = body->count;
    int nt = pd_par_threads(ctx, points * count * 4 + body->bonds);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int q = 0; q < parts; q++) {
        found[q] = 0;
        for (int64_t i = points * q / parts; i < points * (q + 1) / parts; i++)
            for (int c = 0; c < count; c++) found[q] += pdi_precrack_break_family(body, &planes[c], (int32_t)i);
    }
    for (int q = 0; q < parts; q++) all += found[q];
    return (all + pdi_precrack_break_reverse(body)) / 2;
}

pd_status pd_body_apply_precracks(pd_ctx *ctx, pd_body *body, const pd_precrack *cuts, int count, int64_t *broken)
{
    pdi_precrack_plane *planes = NULL;
    if (broken) *broken = 0;
    if (count < 0 || (count && !cuts))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "crack", "%d cuts, expected a list of none or more", count);
    PD_TRY(PD_NEW(ctx, "crack", count, planes));
    pd_status status = pdi_precrack_build_planes(ctx, body, cuts, count, planes);
    if (status == PD_OK) {
        int64_t all = pdi_precrack_break_bonds(ctx, body, planes, count);
        if (broken) *broken = all;
    }
    PD_DELETE(ctx, count, planes);
    return status;
}

void pd_body_damage(const pd_ctx *ctx, const pd_body *body, double *damage)
{
    int nt = pd_par_threads(ctx, body->bonds);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        double all = 0.0, lost = 0.0;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
            double volume = body->volume[f.neighbour];
            all += volume;
            lost += pd_body_bond_is_broken(&f) ? volume : 0.0;
        }
        damage[i] = all > 0.0 ? lost / all : 0.0;
    }
}

#undef PDI_PRECRACK_ROUNDING
#undef PDI_PRECRACK_DIGITS
#undef PDI_PRECRACK_FLATNESS
