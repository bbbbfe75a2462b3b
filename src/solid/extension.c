/* extension: see extension.h */
#include "solid/extension.h"
#include "solid/strain.h"
#include "solid/stretch.h"
#include <math.h>

/* Bits of a bond that all points of the longest band have. */
#define PDI_EXTENSION_ALL UINT32_MAX

/* Which bonds a loop takes. */
enum {
    PDI_EXTENSION_LINEAR, /* under small displacements */
    PDI_EXTENSION_SMALL,  /* with |e| up to PDI_STRETCH_SMALL */
    PDI_EXTENSION_ANY     /* with any e */
};

/* A loop over the bonds of a band. */
typedef struct pdi_extension_loop {
    int way;
    double (*sum)[PD_BAND_MOST];
    double most[PD_BAND_MOST]; /* [-] largest |e| of the bonds of a point */
} pdi_extension_loop;

/* Bond n of count ones. */
typedef struct pdi_extension_bond {
    double xi[PD_DIM], y[PD_DIM]; /* [m] */
    double over;                  /* [1/m2] 1/r^2 */
    double stretch;               /* [-] */
    double part;                  /* [-] r/|Y| */
} pdi_extension_bond;

PDI_INLINE void pdi_extension_look(const double *PD_RESTRICT own, const double *PD_RESTRICT far, int64_t total,
                                   const double *shift, uint32_t lanes, int way, int n, double *PD_RESTRICT most,
                                   pdi_extension_bond *PD_RESTRICT bond)
{
    double square = 0.0, more = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double eta = far[(PDI_BAND_MOVE + d) * total + n] - own[(PDI_BAND_MOVE + d) * total + n];
        bond->xi[d] = far[(PDI_BAND_PLACE + d) * total + n] - own[(PDI_BAND_PLACE + d) * total + n];
        if (shift) bond->xi[d] += shift[d];
        bond->y[d] = bond->xi[d] + (way == PDI_EXTENSION_LINEAR ? 0.0 : eta);
        square += bond->xi[d] * bond->xi[d];
        more += eta * (way == PDI_EXTENSION_LINEAR ? bond->xi[d] : bond->xi[d] + bond->y[d]);
    }
    bond->over = 1.0 / square;
    double e = more * bond->over;
    if (lanes != PDI_EXTENSION_ALL) e = (lanes >> n & 1u) ? e : 0.0;
    bond->stretch = e;
    bond->part = 1.0;
    if (way == PDI_EXTENSION_LINEAR) return;
    if (way == PDI_EXTENSION_SMALL) most[n] = fabs(e) > most[n] ? fabs(e) : most[n];
    double pull = way == PDI_EXTENSION_SMALL ? e * pdi_stretch_series(e) : pdi_stretch_pull(e);
    bond->part -= pull;
    bond->stretch = pull * (1.0 + e) * bond->part;
}

/* Where a symmetric tensor has its entry of row p and column q <= p, see strain.h. */
PDI_INLINE int pdi_extension_place(int p, int q) { return p == q ? p : PD_DIM + p * (p - 1) / 2 + q; }

/* The shape of count points. */
PDI_INLINE void pdi_extension_add(const double *PD_RESTRICT own, const double *PD_RESTRICT far, int64_t total,
                                  const double *shift, double w, uint32_t lanes, int way, int count,
                                  double *PD_RESTRICT most, double (*PD_RESTRICT sum)[PD_BAND_MOST])
{
    for (int n = 0; n < count; n++) {
        pdi_extension_bond bond;
        pdi_extension_look(own, far, total, shift, lanes, way, n, most, &bond);
        double share = w * far[PDI_BAND_VOLUME * total + n] * bond.stretch;
        for (int p = 0; p < PD_DIM; p++)
            for (int q = 0; q < PD_DIM; q++)
                if (q <= p) sum[pdi_extension_place(p, q)][n] += share * bond.xi[p] * bond.xi[q];
    }
}

/* The force on count points. */
PDI_INLINE void pdi_extension_pull(const double *PD_RESTRICT own, const double *PD_RESTRICT far, int64_t total,
                                   const double *shift, double w, uint32_t lanes, int way, int count,
                                   double *PD_RESTRICT most, double (*PD_RESTRICT sum)[PD_BAND_MOST])
{
    for (int n = 0; n < count; n++) {
        pdi_extension_bond bond;
        double alpha = own[PDI_EXTENSION_ALPHA * total + n] + far[PDI_EXTENSION_ALPHA * total + n], carried = 0.0;
        pdi_extension_look(own, far, total, shift, lanes, way, n, most, &bond);
        for (int p = 0; p < PD_DIM; p++) {
            double line = 0.0;
            for (int q = 0; q < PD_DIM; q++) {
                int64_t at = (PDI_EXTENSION_STATE + pdi_extension_place(p, q)) * total + n;
                if (q <= p) line += (own[at] + far[at]) * bond.xi[q];
            }
            carried += line * bond.xi[p];
        }
        double share = w * far[PDI_BAND_VOLUME * total + n] * (carried * bond.over + alpha * bond.stretch) * bond.part;
        if (lanes != PDI_EXTENSION_ALL) share = (lanes >> n & 1u) ? share : 0.0;
        for (int d = 0; d < PD_DIM; d++) sum[d][n] += share * bond.y[d];
    }
}

/* One of both for a bond. Inlined with constants for what tells them apart, for `shift`, `lanes` or `count`. */
PDI_INLINE void pdi_extension_of(const double *own, const double *far, int64_t total, const double *shift, double w,
                                 uint32_t lanes, int pulls, int way, int count, pdi_extension_loop *loop)
{
    if (pulls) pdi_extension_pull(own, far, total, shift, w, lanes, way, count, loop->most, loop->sum);
    else pdi_extension_add(own, far, total, shift, w, lanes, way, count, loop->most, loop->sum);
}

/* Points of a band of count ones with those that fill the last vector. */
static int pdi_extension_whole(int32_t count) { return count > 1 ? (count + 7) / 8 * 8 : 1; }

/* All bonds of band k. Inlined with constants for `pulls` and `way`. */
PDI_SHARED void pdi_extension_bonds(const pd_band *band, int32_t k, int pulls, int way, pdi_extension_loop *loop)
{
    int32_t i = band->first[k], count = band->first[k + 1] - i;
    int whole = pdi_extension_whole(count);
    int64_t total = band->stride;
    const double *own = pdi_band_field(band, 0) + i;
    double shift[PD_DIM];
    for (int d = 0; d < (pulls ? PD_DIM : PDI_SYM); d++)
        for (int n = 0; n < whole; n++) loop->sum[d][n] = 0.0;
    for (int n = 0; n < whole; n++) loop->most[n] = 0.0;
    for (pd_walk f = pdi_walk_from(band->body, i); count == 1 && pdi_walk_next(&f);) {
        double w = pdi_bond_weights_intact(band->weights, i, &f);
        pdi_band_shift(band->body, pdi_walk_image(&f), shift);
        if (w > 0.0) pdi_extension_of(own, own + (f.to - i), total, shift, w, PDI_EXTENSION_ALL, pulls, way, 1, loop);
    }
    for (int64_t b = band->begin[k]; b < band->begin[k + 1]; b++) {
        const double *far = own + band->bond[b].offset;
        double w = (double)band->bond[b].weight;
        uint32_t lanes = band->bond[b].lanes;
        if (band->bond[b].image) {
            pdi_band_shift(band->body, band->bond[b].image, shift);
            pdi_extension_of(own, far, total, shift, w, lanes, pulls, way, whole, loop);
        } else if (lanes == PDI_EXTENSION_ALL)
            pdi_extension_of(own, far, total, NULL, w, PDI_EXTENSION_ALL, pulls, way, PD_BAND_MOST, loop);
        else pdi_extension_of(own, far, total, NULL, w, lanes, pulls, way, whole, loop);
    }
}

/* 1: the bonds of the band are what a loop with the series takes. */
static int pdi_extension_small(const pdi_extension_loop *loop, int32_t count)
{
    for (int32_t n = 0; n < count; n++)
        if (!(loop->most[n] <= PDI_STRETCH_SMALL)) return 0;
    return 1;
}

PDI_FN int32_t pdi_extension_shape(const pd_band *band, int32_t k, int linear, double (*shape)[PD_BAND_MOST])
{
    int32_t count = band->first[k + 1] - band->first[k];
    double sum[PDI_SYM][PD_BAND_MOST];
    pdi_extension_loop loop;
    loop.sum = sum;
    if (linear) pdi_extension_bonds(band, k, 0, PDI_EXTENSION_LINEAR, &loop);
    else {
        pdi_extension_bonds(band, k, 0, PDI_EXTENSION_SMALL, &loop);
        if (!pdi_extension_small(&loop, count)) pdi_extension_bonds(band, k, 0, PDI_EXTENSION_ANY, &loop);
    }
    for (int p = 0; p < PDI_SYM; p++)
        for (int32_t n = 0; n < count; n++) shape[p][n] = p < PD_DIM ? sum[p][n] : PDI_STRAIN_ROOT2 * sum[p][n];
    return count;
}

PDI_FN void pdi_extension_offer(const pd_band *band, int32_t i, double alpha, const double *q)
{
    double *field = pdi_band_field(band, 0) + i;
    field[PDI_EXTENSION_ALPHA * band->stride] = alpha;
    for (int p = 0; p < PDI_SYM; p++)
        field[(PDI_EXTENSION_STATE + p) * band->stride] = p < PD_DIM ? q[p] : PDI_STRAIN_ROOT2 * q[p];
}

PDI_FN void pdi_extension_force(const pd_band *band, int32_t k, int linear, double *force)
{
    int32_t i = band->first[k], count = band->first[k + 1] - i;
    double sum[PD_DIM][PD_BAND_MOST];
    pdi_extension_loop loop;
    loop.sum = sum;
    if (linear) pdi_extension_bonds(band, k, 1, PDI_EXTENSION_LINEAR, &loop);
    else {
        pdi_extension_bonds(band, k, 1, PDI_EXTENSION_SMALL, &loop);
        if (!pdi_extension_small(&loop, count)) pdi_extension_bonds(band, k, 1, PDI_EXTENSION_ANY, &loop);
    }
    for (int32_t n = 0; n < count; n++)
        for (int d = 0; d < PD_DIM; d++) force[((int64_t)i + n) * PD_DIM + d] = sum[d][n];
}

#undef PDI_EXTENSION_ALL
