/* visibility: see visibility.h */
#include "solid/visibility.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Tolerance of positions along a bond and within a face, over their lengths. */
#define PDI_VISIBILITY_ROUNDING 1e-9
/* Probing lines beside a bond: their distance from it over its length, and how many. */
#define PDI_VISIBILITY_OFFSET 1e-5
#define PDI_VISIBILITY_PROBES 8
/* Angle of the first probing line [rad]: an odd one, so that no regular face lies along it. */
#define PDI_VISIBILITY_FIRST_ANGLE 0.3
/* Largest number of bins, and of face entries in bins, over the number of faces. */
#define PDI_VISIBILITY_MAX_BINS 8
#define PDI_VISIBILITY_MAX_ENTRIES 64

enum { PDI_VISIBILITY_FACE = PD_DIM * PD_DIM };

/* How a line intersects a face: not, at an edge or corner, or inside it. */
enum { PDI_VISIBILITY_MISSES = 0, PDI_VISIBILITY_TOUCHES, PDI_VISIBILITY_CROSSES };

/* Describes the arrays of bins. */
static void pdi_visibility_list(pdi_array_visitor *owner, void *object)
{
    pdi_visibility *visibility = (pdi_visibility *)object;
    PDI_ARRAY(owner, visibility, first, visibility->bins + 1, "1");
    PDI_ARRAY(owner, visibility, entry, visibility->entries, "1");
}

/* ---- bins ---- */

/* Index range from .. to, both included, of the bins that the bounding box of positions x [count][PD_DIM] reaches into.
 * Returns how many bins; 0: it lies outside of the grid. */
static double pdi_visibility_find_bins(const pdi_visibility *v, const double *x, int count, int32_t *from, int32_t *to)
{
    double all = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        double low = x[d], high = x[d];
        for (int k = 1; k < count; k++) {
            low = pd_min(low, x[k * PD_DIM + d]);
            high = pd_max(high, x[k * PD_DIM + d]);
        }
        /* Rounding takes no bin away. */
        double first = floor((low - v->lo[d]) / v->width - PDI_VISIBILITY_ROUNDING);
        double last = floor((high - v->lo[d]) / v->width + PDI_VISIBILITY_ROUNDING);
        from[d] = first < 0.0 ? 0 : first < v->n[d] ? (int32_t)first : v->n[d];
        to[d] = last < 0.0 ? -1 : last < v->n[d] ? (int32_t)last : v->n[d] - 1;
        all *= to[d] >= from[d] ? (double)(to[d] - from[d] + 1) : 0.0;
    }
    return all;
}

/* Moves `at` to the next bin of the range from .. to, axis 0 fastest. Returns 1; 0: there is none. */
static int pdi_visibility_next_bin(const int32_t *from, const int32_t *to, int32_t *at)
{
    for (int d = 0; d < PD_DIM; d++) {
        if (at[d]++ < to[d]) return 1;
        at[d] = from[d];
    }
    return 0;
}

/* Number of the bin with the indices at [PD_DIM], axis 0 fastest. */
static int64_t pdi_visibility_bin_number(const pdi_visibility *v, const int32_t *at)
{
    int64_t k = 0;
    for (int d = PD_DIM - 1; d >= 0; d--) k = k * v->n[d] + at[d];
    return k;
}

/* Sets width, n, bins and entries: the wanted width [m], doubled until there are at most 8 bins per face plus one, and
 * at most 64 entries per face or a single bin. hi [PD_DIM] [m]: upper corner of all faces. */
static void pdi_visibility_init_bins(pdi_visibility *v, const double *hi, double width)
{
    for (;; width *= 2.0) {
        double bins = 1.0, entries = 0.0;
        v->width = width;
        for (int d = 0; d < PD_DIM; d++) {
            double n = floor((hi[d] - v->lo[d]) / width) + 1.0;
            bins *= n;
            v->n[d] = n < 1e9 ? (int32_t)n : 1000000000;
        }
        if (bins > PDI_VISIBILITY_MAX_BINS * (double)v->faces + 1.0) continue;
        for (int64_t k = 0; k < v->faces; k++) {
            int32_t from[PD_DIM], to[PD_DIM];
            entries += pdi_visibility_find_bins(v, v->face + k * PDI_VISIBILITY_FACE, PD_DIM, from, to);
        }
        if (entries > PDI_VISIBILITY_MAX_ENTRIES * (double)v->faces && bins > 1.0) continue;
        v->bins = (int64_t)bins;
        v->entries = (int64_t)entries;
        return;
    }
}

/* Sorts the faces into all bins that their bounding boxes reach into, into first (zero before) and entry: counts first,
 * then entries. Faces of a bin stand by number. */
static void pdi_visibility_fill_bins(pdi_visibility *v)
{
    for (int way = 0; way < 2; way++) {
        for (int64_t k = v->faces - 1; k >= 0; k--) {
            int32_t from[PD_DIM], to[PD_DIM], at[PD_DIM];
            pdi_visibility_find_bins(v, v->face + k * PDI_VISIBILITY_FACE, PD_DIM, from, to);
            memcpy(at, from, sizeof at);
            do {
                int64_t bin = pdi_visibility_bin_number(v, at);
                if (way == 0) v->first[bin]++;
                else v->entry[--v->first[bin]] = (int32_t)k;
            } while (pdi_visibility_next_bin(from, to, at));
        }
        for (int64_t b = 0; b < v->bins && way == 0; b++) v->first[b + 1] += v->first[b];
    }
    v->first[v->bins] = v->entries;
}

PDI_FN pd_status pdi_visibility_build(pd_ctx *ctx, double bond_length, pdi_visibility *v)
{
    double hi[PD_DIM];
    if (v->faces > INT32_MAX / 2)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "body", "%g faces of the surface, too many", (double)v->faces);
    for (int d = 0; d < PD_DIM; d++) {
        v->lo[d] = HUGE_VAL;
        hi[d] = -HUGE_VAL;
    }
    for (int64_t k = 0; k < v->faces * PDI_VISIBILITY_FACE; k++) {
        if (!(fabs(v->face[k]) < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "body", "face %.0f of the surface has a corner at %g m, expected a "
                           "finite place", (double)(k / PDI_VISIBILITY_FACE), v->face[k]);
        v->lo[k % PD_DIM] = pd_min(v->lo[k % PD_DIM], v->face[k]);
        hi[k % PD_DIM] = pd_max(hi[k % PD_DIM], v->face[k]);
    }
    if (v->faces) pdi_visibility_init_bins(v, hi, bond_length);
    PD_TRY(pdi_array_registry_build(ctx, pdi_visibility_list, v));
    if (v->faces) pdi_visibility_fill_bins(v);
    return PD_OK;
}

PDI_FN void pdi_visibility_free(pd_ctx *ctx, pdi_visibility *v)
{
    pdi_array_registry_free(ctx, pdi_visibility_list, v);
    memset(v, 0, sizeof *v);
}

/* ---- lines ---- */

/* Position s on an edge from 0 to 1: PDI_VISIBILITY_MISSES outside, PDI_VISIBILITY_TOUCHES at an end within rounding,
 * PDI_VISIBILITY_CROSSES inside. */
static int pdi_visibility_locate(double s)
{
    if (!(s > -PDI_VISIBILITY_ROUNDING) || !(s < 1.0 + PDI_VISIBILITY_ROUNDING)) return PDI_VISIBILITY_MISSES;
    return s > PDI_VISIBILITY_ROUNDING && s < 1.0 - PDI_VISIBILITY_ROUNDING ? PDI_VISIBILITY_CROSSES
                                                                            : PDI_VISIBILITY_TOUCHES;
}

/* c = a x b, 3D. */
static void pdi_visibility_cross_product(const double *a, const double *b, double *c)
{
    for (int d = 0; d < 3; d++) c[d] = a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3];
}

/* Intersection of the line x + t xi with a face, as PDI_VISIBILITY_MISSES and so on: t and the barycentric coordinates
 * have to lie in 0..1. A line within the plane of a face does not intersect it. */
static int pdi_visibility_intersect_face(const double *x, const double *xi, const double *face)
{
    double side[2][3] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}, from[3] = {0.0, 0.0, 0.0}, way[3] = {0.0, 0.0, 0.0};
    double turn[3], normal[3], share[3], most = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        for (int k = 1; k < PD_DIM; k++) side[k - 1][d] = face[k * PD_DIM + d] - face[d];
        from[d] = x[d] - face[d];
        way[d] = xi[d];
    }
    if (PD_DIM == 1) return pdi_visibility_locate(-from[0] / way[0]);
    if (PD_DIM == 2) side[1][2] = 1.0; /* the segment is as wide as can be across the plane */
    pdi_visibility_cross_product(side[0], side[1], normal);
    double fall = -(way[0] * normal[0] + way[1] * normal[1] + way[2] * normal[2]);
    for (int d = 0; d < 3; d++) most += fabs(way[d] * normal[d]);
    if (!(fabs(fall) > PDI_VISIBILITY_ROUNDING * most)) return PDI_VISIBILITY_MISSES;
    int least = pdi_visibility_locate((from[0] * normal[0] + from[1] * normal[1] + from[2] * normal[2]) / fall);
    pdi_visibility_cross_product(from, way, turn);
    share[1] = (side[1][0] * turn[0] + side[1][1] * turn[1] + side[1][2] * turn[2]) / fall;
    share[2] = -(side[0][0] * turn[0] + side[0][1] * turn[1] + side[0][2] * turn[2]) / fall;
    if (PD_DIM == 2) share[2] = 0.0;
    share[0] = 1.0 - share[1] - share[2];
    for (int k = 0; k < PD_DIM; k++) {
        int how = pdi_visibility_locate(share[k]);
        least = how < least ? how : least;
    }
    return least;
}

/* Strongest intersection of the line x + t xi, t = 0..1, with any face, as PDI_VISIBILITY_MISSES and so on. */
static int pdi_visibility_intersect_line(const pdi_visibility *v, const double *x, const double *xi)
{
    double ends[2 * PD_DIM];
    int32_t from[PD_DIM], to[PD_DIM], at[PD_DIM];
    int most = PDI_VISIBILITY_MISSES;
    for (int d = 0; d < PD_DIM; d++) {
        ends[d] = x[d];
        ends[PD_DIM + d] = x[d] + xi[d];
    }
    if (!(pdi_visibility_find_bins(v, ends, 2, from, to) > 0.0)) return most;
    memcpy(at, from, sizeof at);
    do {
        int64_t bin = pdi_visibility_bin_number(v, at);
        for (int64_t k = v->first[bin]; k < v->first[bin + 1] && most < PDI_VISIBILITY_CROSSES; k++) {
            int how = pdi_visibility_intersect_face(x, xi, v->face + v->entry[k] * (int64_t)PDI_VISIBILITY_FACE);
            most = how > most ? how : most;
        }
    } while (most < PDI_VISIBILITY_CROSSES && pdi_visibility_next_bin(from, to, at));
    return most;
}

/* Directions normal to xi, two in 3D and one in 2D, of the length of xi. */
static void pdi_visibility_compute_normals(const double *xi, double normals[2][3])
{
    double way[3] = {0.0, 0.0, 0.0}, axis[3] = {0.0, 0.0, 0.0}, length, size;
    int least = PD_DIM == 2 ? 2 : 0;
    memcpy(way, xi, PD_DIM * sizeof *xi);
    for (int d = 1; d < 3 && PD_DIM == 3; d++) least = fabs(way[d]) < fabs(way[least]) ? d : least;
    axis[least] = 1.0;
    length = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    pdi_visibility_cross_product(way, axis, normals[0]);
    pdi_visibility_cross_product(way, normals[0], normals[1]);
    for (int k = 0; k < 2; k++) {
        size = sqrt(normals[k][0] * normals[k][0] + normals[k][1] * normals[k][1] + normals[k][2] * normals[k][2]);
        for (int d = 0; d < 3; d++) normals[k][d] *= length / size;
    }
}

PDI_FN int pdi_visibility_is_joined(void *user, int32_t i, int32_t j, const double *xi)
{
    const pdi_visibility *v = (const pdi_visibility *)user;
    const double *x = v->position + (int64_t)i * PD_DIM;
    double across[2][3], beside[PD_DIM];
    int how = pdi_visibility_intersect_line(v, x, xi);
    (void)j;
    if (how != PDI_VISIBILITY_TOUCHES || PD_DIM == 1) return how == PDI_VISIBILITY_MISSES;
    pdi_visibility_compute_normals(xi, across);
    for (int k = 0; k < PDI_VISIBILITY_PROBES; k++) {
        double angle = PDI_VISIBILITY_FIRST_ANGLE + 2.0 * PD_PI * k / PDI_VISIBILITY_PROBES;
        double first = PD_DIM == 2 ? (k % 2 ? -1.0 : 1.0) : cos(angle), second = PD_DIM == 2 ? 0.0 : sin(angle);
        for (int d = 0; d < PD_DIM; d++)
            beside[d] = x[d] + PDI_VISIBILITY_OFFSET * (first * across[0][d] + second * across[1][d]);
        if (pdi_visibility_intersect_line(v, beside, xi) == PDI_VISIBILITY_MISSES) return 1;
    }
    return 0;
}

#undef PDI_VISIBILITY_ROUNDING
#undef PDI_VISIBILITY_OFFSET
#undef PDI_VISIBILITY_PROBES
#undef PDI_VISIBILITY_FIRST_ANGLE
#undef PDI_VISIBILITY_MAX_BINS
#undef PDI_VISIBILITY_MAX_ENTRIES
