/* bond_force: see bond_force.h */
#include "solid/bond_force.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "solid/bond_stretch.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rounding of positions over the spacing: up to this a bond counts as a lattice vector. */
#define PDI_BOND_FORCE_ROUNDING 1e-9
/* Longest bond of a lattice, in spacings along an axis. */
#define PDI_BOND_FORCE_MAX_STEPS 200

/* ---- kinds of bonds ---- */

/* Largest number of spacings of a bond of point i along an axis; above PDI_BOND_FORCE_MAX_STEPS where one is no lattice
 * vector. */
static int32_t pdi_bond_force_find_max_steps(const pd_body *body, int32_t i)
{
    int32_t most = 0;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double xi[PD_DIM];
        pdi_body_compute_offset(body, i, f.neighbour, xi);
        for (int d = 0; d < PD_DIM; d++) {
            double step = fabs(xi[d]) / body->spacing, near = floor(step + 0.5);
            if (!(fabs(step - near) <= PDI_BOND_FORCE_ROUNDING) || !(near <= PDI_BOND_FORCE_MAX_STEPS))
                return PDI_BOND_FORCE_MAX_STEPS + 1;
            if ((int32_t)near > most) most = (int32_t)near;
        }
    }
    return most;
}

/* Largest number of spacings of any bond of the body along an axis; above PDI_BOND_FORCE_MAX_STEPS: one is no lattice
 * vector. */
static int32_t pdi_bond_force_find_extent(const pd_ctx *ctx, const pd_body *body)
{
    enum { parts = 64 };
    int32_t reach[parts], most = 0;
    int64_t count = body->count;
    int nt = pd_par_threads(ctx, body->bonds * 5);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int q = 0; q < parts; q++) {
        reach[q] = 0;
        for (int64_t i = count * q / parts; i < count * (q + 1) / parts && reach[q] <= PDI_BOND_FORCE_MAX_STEPS; i++) {
            int32_t found = pdi_bond_force_find_max_steps(body, (int32_t)i);
            if (found > reach[q]) reach[q] = found;
        }
    }
    for (int q = 0; q < parts; q++)
        if (reach[q] > most) most = reach[q];
    return most;
}

PDI_FN void pdi_bond_force_list(pdi_array_visitor *owner, void *object)
{
    pd_bond_force *springs = (pd_bond_force *)object;
    PDI_ARRAY(owner, springs, kind, springs->kinds, "");
    PDI_ARRAY(owner, springs, order, springs->kinds, "1");
    PDI_ARRAY(owner, springs, work, springs->kinds + 1, "1");
}

/* Sector of a family by the signs of a bond, in base 3, axis 0 in the lowest digit: 0: zero within rounding [m], 1:
 * positive, 2: negative. */
static int pdi_bond_force_find_sector(const double *xi, double rounding)
{
    int part = 0;
    for (int d = PD_DIM - 1; d >= 0; d--) part = 3 * part + (fabs(xi[d]) <= rounding ? 0 : xi[d] > 0.0 ? 1 : 2);
    return part;
}

/* qsort order of bond kinds: by sector, and outward in each. */
static int pdi_bond_force_compare_kinds(const void *a, const void *b)
{
    const pd_bond_force_kind *p = (const pd_bond_force_kind *)a, *q = (const pd_bond_force_kind *)b;
    if (p->sector != q->sector) return p->sector < q->sector ? -1 : 1;
    for (int d = PD_DIM - 1; d >= 0; d--) {
        double own = fabs(p->xi[d]), other = fabs(q->xi[d]);
        if (own < other || own > other) return own < other ? -1 : 1;
    }
    return 0;
}

/* Index of the lattice vector xi in the box of all vectors, axis 0 fastest. */
static int32_t pdi_bond_force_offset_index(const pd_bond_force *s, const double *xi)
{
    int32_t box = 0;
    for (int d = PD_DIM - 1; d >= 0; d--)
        box = box * (2 * s->max_steps + 1) + (int32_t)floor(xi[d] / s->body->spacing + 0.5) + s->max_steps;
    return box;
}

/* Builds the bond kinds of a lattice, sorts them, and sets `order`. */
static void pdi_bond_force_sort_kinds(pd_bond_force *s)
{
    int32_t wide = 2 * s->max_steps + 1;
    for (int32_t k = 0; k < s->kinds; k++) {
        pd_bond_force_kind *kind = &s->kind[k];
        double square = 0.0;
        for (int32_t d = 0, rest = k; d < PD_DIM; rest /= wide, d++) {
            kind->xi[d] = (rest % wide - s->max_steps) * s->body->spacing;
            square += kind->xi[d] * kind->xi[d];
        }
        kind->inv_r2 = square > 0.0 ? 1.0 / square : 0.0;
        kind->inv_r = sqrt(kind->inv_r2);
        kind->sector = pdi_bond_force_find_sector(kind->xi, 0.0);
    }
    qsort(s->kind, (size_t)s->kinds, sizeof *s->kind, pdi_bond_force_compare_kinds);
    for (int32_t k = 0; k < s->kinds; k++) s->order[pdi_bond_force_offset_index(s, s->kind[k].xi)] = k;
}

PDI_FN pd_status pdi_bond_force_build(pd_ctx *ctx, pd_body *body, const pd_bond_weights *weights, pd_bond_force *s)
{
    memset(s, 0, sizeof *s);
    s->body = body;
    s->weights = weights;
    s->max_steps = pdi_bond_force_find_extent(ctx, body);
    s->lattice = s->max_steps <= PDI_BOND_FORCE_MAX_STEPS;
    s->kinds = s->lattice ? 1 : PD_BOND_FORCE_SECTORS;
    for (int d = 0; d < PD_DIM && s->lattice; d++) s->kinds *= 2 * s->max_steps + 1;
    pd_status status = pdi_array_registry_build(ctx, pdi_bond_force_list, s);
    if (status == PD_OK) status = pdi_point_batch_build(ctx, body, weights, PDI_POINT_BATCH_STIFFNESS, &s->band);
    s->band.list_single_points = 1;
    s->band.lattice_vectors = s->lattice;
    if (status == PD_OK && s->lattice) pdi_bond_force_sort_kinds(s);
    for (int k = 0; k < s->kinds && status == PD_OK && !s->lattice; k++) s->kind[k].sector = k;
    if (status < 0) pdi_bond_force_free(ctx, s);
    return status;
}

PDI_FN void pdi_bond_force_free(pd_ctx *ctx, pd_bond_force *s)
{
    PD_DELETE(ctx, s->capacity, s->bond_kind);
    pdi_point_batch_free(ctx, &s->band);
    pdi_array_registry_free(ctx, pdi_bond_force_list, s);
    memset(s, 0, sizeof *s);
}

/* ---- bands ---- */

PDI_FN void pdi_bond_force_compute_offset(const pd_bond_force *s, int32_t i, int32_t j, double *xi)
{
    pdi_body_compute_offset(s->body, i, j, xi);
    for (int d = 0; d < PD_DIM && s->lattice; d++) xi[d] = floor(xi[d] / s->body->spacing + 0.5) * s->body->spacing;
}

/* Kind of a bond of batch k, by the first of its points that has it; off the lattice its sector. */
static int32_t pdi_bond_force_find_kind(const pd_bond_force *s, int32_t k, const pd_point_batch_bond *bond)
{
    const pd_body *body = s->body;
    int32_t i = s->band.first[k];
    double xi[PD_DIM];
    for (uint32_t lanes = bond->mask; !(lanes & 1u); lanes >>= 1) i++;
    for (int d = 0; d < PD_DIM; d++)
        xi[d] = body->position[((int64_t)i + bond->offset) * PD_DIM + d] - body->position[(int64_t)i * PD_DIM + d];
    return s->lattice ? s->order[pdi_bond_force_offset_index(s, xi)]
                      : pdi_bond_force_find_sector(xi, PDI_BOND_FORCE_ROUNDING * body->horizon);
}

/* Sorts the bonds of batch k by kind, and sets bond_kind; those of one kind keep their order. old, kind: work for all
 * bonds of the batch. */
static void pdi_bond_force_sort_bonds(pd_bond_force *s, int32_t k, pd_point_batch_bond *old, int32_t *kind)
{
    int64_t begin = s->band.begin[k], bonds = s->band.begin[k + 1] - begin;
    memset(s->work, 0, ((size_t)s->kinds + 1) * sizeof *s->work);
    for (int64_t b = 0; b < bonds; b++) {
        old[b] = s->band.bond[begin + b];
        kind[b] = pdi_bond_force_find_kind(s, k, &old[b]);
        s->work[kind[b] + 1]++;
    }
    for (int32_t q = 0; q < s->kinds; q++) s->work[q + 1] += s->work[q];
    for (int64_t b = 0; b < bonds; b++) {
        int64_t to = begin + s->work[kind[b]]++;
        s->band.bond[to] = old[b];
        s->bond_kind[to] = kind[b];
    }
}

PDI_FN pd_status pdi_bond_force_update(pd_ctx *ctx, pd_bond_force *s)
{
    pd_point_batch_bond *old = NULL;
    int32_t *kind = NULL;
    int64_t longest = 1;
    PD_TRY(pdi_point_batch_update(ctx, &s->band));
    if (s->capacity < s->band.capacity) {
        PD_TRY(PD_GROW(ctx, "springs", s->capacity, s->band.capacity, s->bond_kind));
        s->capacity = s->band.capacity;
    }
    for (int32_t k = 0; k < s->band.batches; k++)
        if (s->band.begin[k + 1] - s->band.begin[k] > longest) longest = s->band.begin[k + 1] - s->band.begin[k];
    pd_status status = PD_NEW(ctx, "springs", longest, old);
    if (status == PD_OK) status = PD_NEW(ctx, "springs", longest, kind);
    for (int32_t k = 0; k < s->band.batches && status == PD_OK; k++) pdi_bond_force_sort_bonds(s, k, old, kind);
    PD_DELETE(ctx, longest, old);
    PD_DELETE(ctx, longest, kind);
    return status;
}

/* ---- forces ---- */

/* Sums over the bonds of a batch. */
typedef struct pdi_bond_force_sums {
    /* sum w V (1/r - 1/|Y|) Y of each part of the family */
    double sector[PD_BOND_FORCE_SECTORS][PD_DIM][PD_POINT_BATCH_MAX];
    double max_e[PD_POINT_BATCH_MAX], min_e[PD_POINT_BATCH_MAX]; /* [-] largest and least e, and 0 */
} pdi_bond_force_sums;

/* Adds one bond of `count` points on a lattice to the sums of its sector and to max_e, min_e, by the series of small e;
 * weight: w/r [1/m]. own, other: fields of the points and of their neighbours. Inlined with a constant mask or
 * count. */
PDI_INLINE void pdi_bond_force_add_bond(const double *PD_RESTRICT own, const double *PD_RESTRICT other, int64_t stride,
                                        const pd_bond_force_kind *PD_RESTRICT kind, double weight, uint32_t mask,
                                        int count, pdi_bond_force_sums *PD_RESTRICT sums)
{
    double(*PD_RESTRICT sum)[PD_POINT_BATCH_MAX] = sums->sector[kind->sector];
    double *PD_RESTRICT high = sums->max_e, *PD_RESTRICT low = sums->min_e;
    double xi[PD_DIM], inv_r2 = kind->inv_r2;
    for (int d = 0; d < PD_DIM; d++) xi[d] = kind->xi[d];
    for (int n = 0; n < count; n++) {
        double y[PD_DIM], more = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            double eta = other[(PDI_POINT_BATCH_DISPLACEMENT + d) * stride + n] -
                         own[(PDI_POINT_BATCH_DISPLACEMENT + d) * stride + n];
            y[d] = xi[d] + eta;
            more += eta * (xi[d] + y[d]);
        }
        double e = more * inv_r2;
        if (mask != PDI_POINT_BATCH_FULL_MASK) e = (mask >> n & 1u) ? e : 0.0;
        high[n] = e > high[n] ? e : high[n];
        low[n] = e < low[n] ? e : low[n];
        double share = weight * other[PDI_POINT_BATCH_VOLUME * stride + n] * (e * pdi_bond_stretch_factor_series(e));
        for (int d = 0; d < PD_DIM; d++) sum[d][n] += share * y[d];
    }
}

/* Adds the bonds of batch k of a lattice to the sums, which are valid while all |e| are within the range of the series;
 * whole: padded count. */
static void pdi_bond_force_sum_batch(const pd_bond_force *s, int32_t k, int whole, pdi_bond_force_sums *sums)
{
    const pd_point_batch *band = &s->band;
    const double *own = pdi_point_batch_get_field(band, 0) + band->first[k];
    int64_t total = band->stride;
    for (int64_t b = band->begin[k]; b < band->begin[k + 1]; b++) {
        const pd_bond_force_kind *kind = &s->kind[s->bond_kind[b]];
        const double *far = own + band->bond[b].offset;
        double weight = (double)band->bond[b].weight * kind->inv_r;
        uint32_t lanes = band->bond[b].mask;
        if (lanes == PDI_POINT_BATCH_FULL_MASK)
            pdi_bond_force_add_bond(own, far, total, kind, weight, PDI_POINT_BATCH_FULL_MASK, PD_POINT_BATCH_MAX, sums);
        else if (whole > 1) pdi_bond_force_add_bond(own, far, total, kind, weight, lanes, whole, sums);
        else if (lanes) pdi_bond_force_add_bond(own, far, total, kind, weight, PDI_POINT_BATCH_FULL_MASK, 1, sums);
    }
}

/* Energy over c/4 that a breaking bond releases at one end: w s^2 r V_i V_j [m^(2d+1)], with the stretch s at u -
 * midpoint_dt v; at u where v is NULL. */
static double pdi_bond_force_released_energy(const pd_bond_force *s, const pdi_bond_force_state *state, int32_t i,
                                             int32_t j, double weight)
{
    const pd_body *body = s->body;
    double xi[PD_DIM], eta[PD_DIM], y[PD_DIM], r, length;
    for (int d = 0; d < PD_DIM; d++) {
        int64_t from = (int64_t)i * PD_DIM + d, to = (int64_t)j * PD_DIM + d;
        xi[d] = body->position[to] - body->position[from];
        eta[d] = state->u[to] - state->u[from];
        if (state->v) eta[d] -= state->midpoint_dt * (state->v[to] - state->v[from]);
    }
    double stretch = pdi_body_compute_stretch(xi, eta, y, &r, &length);
    return weight * stretch * stretch * r * body->volume[i] * body->volume[j];
}

/* Marks the bond from point i to j as broken at the end of i. */
static void pdi_bond_force_mark_broken(pd_bond_force *s, int32_t i, int32_t j)
{
    pdi_body_bonds_mark_broken(s->body, i, pdi_body_bonds_find(s->body, j, i));
}

/* Adds the bonds of point n of batch k to its sums, bond by bond: any e, any positions. Bonds with e > critical (2 +
 * critical) break at this end, in the body and in the mask, and add nothing. Returns how many broke; adds their
 * energies over c/4 to *released. max_e and min_e stay. */
static int64_t pdi_bond_force_sum_point(pd_bond_force *s, const pdi_bond_force_state *state, int32_t k, int32_t n,
                                        pdi_bond_force_sums *sums, double *released)
{
    const pd_point_batch *band = &s->band;
    const double *own = pdi_point_batch_get_field(band, 0) + band->first[k] + n;
    double top = state->critical * (2.0 + state->critical);
    int64_t total = band->stride, broken = 0;
    for (int64_t b = band->begin[k]; b < band->begin[k + 1]; b++) {
        pd_point_batch_bond *bond = &band->bond[b];
        pd_bond_force_kind kind = s->kind[s->bond_kind[b]];
        const double *far = own + bond->offset;
        double y[PD_DIM], more = 0.0, square = 0.0;
        if (!(bond->mask >> n & 1u)) continue;
        for (int d = 0; d < PD_DIM; d++) {
            double eta =
                far[(PDI_POINT_BATCH_DISPLACEMENT + d) * total] - own[(PDI_POINT_BATCH_DISPLACEMENT + d) * total];
            if (!s->lattice)
                kind.xi[d] = far[(PDI_POINT_BATCH_POSITION + d) * total] - own[(PDI_POINT_BATCH_POSITION + d) * total];
            square += kind.xi[d] * kind.xi[d];
            y[d] = kind.xi[d] + eta;
            more += eta * (kind.xi[d] + y[d]);
        }
        if (!s->lattice) kind.inv_r2 = 1.0 / square, kind.inv_r = sqrt(kind.inv_r2);
        double e = more * kind.inv_r2, weight = (double)bond->weight * kind.inv_r;
        if (e > top) {
            int32_t i = band->first[k] + n;
            *released += pdi_bond_force_released_energy(s, state, i, i + bond->offset, (double)bond->weight);
            pdi_bond_force_mark_broken(s, i, i + bond->offset);
            bond->mask &= ~((uint32_t)1 << n);
            broken++;
            continue;
        }
        double share = weight * far[PDI_POINT_BATCH_VOLUME * total] * pdi_bond_stretch_factor(e);
        for (int d = 0; d < PD_DIM; d++) sums->sector[kind.sector][d][n] += share * y[d];
    }
    return broken;
}

/* Sets the sums of a batch to zero; whole: padded count, 1: only those of point 0. */
static void pdi_bond_force_clear_sums(int whole, pdi_bond_force_sums *sums)
{
    if (whole > 1) {
        memset(sums, 0, sizeof *sums);
        return;
    }
    for (int p = 0; p < PD_BOND_FORCE_SECTORS * PD_DIM; p++) sums->sector[p / PD_DIM][p % PD_DIM][0] = 0.0;
    sums->max_e[0] = sums->min_e[0] = 0.0;
}

/* Adds the sums of all sectors into sector 0: along each axis the middle, and the sum of both sides. whole: padded
 * count. */
static void pdi_bond_force_fold_sectors(int whole, pdi_bond_force_sums *sums)
{
    for (int stride = 1; stride < PD_BOND_FORCE_SECTORS; stride *= 3)
        for (int p = 0; p < PD_BOND_FORCE_SECTORS; p += 3 * stride)
            for (int d = 0; d < PD_DIM; d++) {
                double *PD_RESTRICT to = sums->sector[p][d];
                const double *one = sums->sector[p + stride][d], *other = sums->sector[p + 2 * stride][d];
                for (int n = 0; n < whole; n++) to[n] += one[n] + other[n];
            }
}

/* Force densities on the points of batch k, into state->force: on a lattice by the series, or point by point where a
 * bond has |e| > PDI_BOND_STRETCH_SERIES_LIMIT or exceeds the critical stretch; off the lattice always point by point.
 * Returns how many bonds broke, each at one end; adds their energies over c/4 to *released. */
static int64_t pdi_bond_force_compute_batch(pd_bond_force *s, const pdi_bond_force_state *state, int32_t k,
                                            double *released)
{
    int32_t i = s->band.first[k], count = s->band.first[k + 1] - i, n = 0;
    int whole = pdi_point_batch_pad_count(count);
    double top = pd_min(state->critical * (2.0 + state->critical), PDI_BOND_STRETCH_SERIES_LIMIT);
    int64_t broken = 0;
    pdi_bond_force_sums sums;
    pdi_bond_force_clear_sums(whole, &sums);
    if (s->lattice) {
        pdi_bond_force_sum_batch(s, k, whole, &sums);
        while (n < count && sums.max_e[n] <= top && sums.min_e[n] >= -PDI_BOND_STRETCH_SERIES_LIMIT) n++;
        if (n < count) pdi_bond_force_clear_sums(whole, &sums);
    }
    for (n = n < count ? 0 : count; n < count; n++) broken += pdi_bond_force_sum_point(s, state, k, n, &sums, released);
    pdi_bond_force_fold_sectors(whole, &sums);
    for (n = 0; n < count; n++)
        for (int d = 0; d < PD_DIM; d++)
            state->force[((int64_t)i + n) * PD_DIM + d] = state->modulus * sums.sector[0][d][n];
    return broken;
}

PDI_FN int64_t pdi_bond_force_compute_force(const pd_ctx *ctx, pd_bond_force *s, pdi_bond_force_state *state)
{
    enum { parts = 256 };
    int64_t broken[parts], all = 0, bands = s->band.batches;
    double released[parts];
    int nt = pd_par_threads(ctx, s->body->bonds * 8);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, &s->band, state->u);
    PD_PARALLEL_FOR(nt)
    for (int q = 0; q < parts; q++) {
        broken[q] = 0;
        released[q] = 0.0;
        for (int64_t k = bands * q / parts; k < bands * (q + 1) / parts; k++)
            broken[q] += pdi_bond_force_compute_batch(s, state, (int32_t)k, &released[q]);
    }
    state->released = 0.0;
    for (int q = 0; q < parts; q++) {
        all += broken[q];
        state->released += 0.25 * state->modulus * released[q];
    }
    return all / 2;
}

#undef PDI_BOND_FORCE_ROUNDING
#undef PDI_BOND_FORCE_MAX_STEPS
