/* extension: see extension.h */
#include "solid/extension.h"
#include "solid/strain.h"
#include "solid/stretch.h"
#include <math.h>

/* Which bonds a loop takes. */
enum {
    PDI_EXTENSION_LINEAR, /* under small displacements */
    PDI_EXTENSION_SMALL,  /* with |e| up to PDI_STRETCH_SMALL */
    PDI_EXTENSION_ANY     /* with any e */
};

/* What it sums. */
enum { PDI_EXTENSION_SHAPE, PDI_EXTENSION_ENERGY, PDI_EXTENSION_STRESS, PDI_EXTENSION_FORCE };

/* Rows of sums: the shape, and that of squares behind it. */
#define PDI_EXTENSION_ROWS (PDI_SYM + 1)

/* A loop over the bonds of a band. */
typedef struct pdi_extension_loop {
    double (*sum)[PD_BAND_MOST];
    double most[PD_BAND_MOST]; /* [-] largest |e| of the bonds of a point */
} pdi_extension_loop;

/* Bond n of count ones. */
typedef struct pdi_extension_bond {
    double xi[PD_DIM], y[PD_DIM]; /* [m] */
    double square, over;          /* [m2] r^2, and [1/m2] 1/r^2 */
    double stretch;               /* [-] */
    double part;                  /* [-] r/|Y| */
} pdi_extension_bond;

PDI_INLINE void pdi_extension_look(const double *PD_RESTRICT own, const double *PD_RESTRICT far, int64_t total,
                                   const double *shift, uint32_t lanes, int way, int n, double *PD_RESTRICT most,
                                   pdi_extension_bond *PD_RESTRICT bond)
{
    double more = 0.0;
    bond->square = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double eta = far[(PDI_BAND_MOVE + d) * total + n] - own[(PDI_BAND_MOVE + d) * total + n];
        bond->xi[d] = far[(PDI_BAND_PLACE + d) * total + n] - own[(PDI_BAND_PLACE + d) * total + n];
        if (shift) bond->xi[d] += shift[d];
        bond->y[d] = bond->xi[d] + (way == PDI_EXTENSION_LINEAR ? 0.0 : eta);
        bond->square += bond->xi[d] * bond->xi[d];
        more += eta * (way == PDI_EXTENSION_LINEAR ? bond->xi[d] : bond->xi[d] + bond->y[d]);
    }
    bond->over = 1.0 / bond->square;
    double e = more * bond->over;
    if (lanes != PDI_BAND_ALL) e = (lanes >> n & 1u) ? e : 0.0;
    bond->stretch = e;
    bond->part = 1.0;
    if (way == PDI_EXTENSION_LINEAR) return;
    if (way == PDI_EXTENSION_SMALL) most[n] = fabs(e) > most[n] ? fabs(e) : most[n];
    double pull = way == PDI_EXTENSION_SMALL ? e * pdi_stretch_series(e) : pdi_stretch_pull(e);
    bond->part -= pull;
    bond->stretch = pull * (1.0 + e) * bond->part;
}

/* The shape of count points; squares 1: their squares, too. */
PDI_SHARED void pdi_extension_add(const double *PD_RESTRICT own, const double *PD_RESTRICT far, int64_t total,
                                  const double *shift, double w, uint32_t lanes, int squares, int way, int count,
                                  double *PD_RESTRICT most, double (*PD_RESTRICT sum)[PD_BAND_MOST])
{
    for (int n = 0; n < count; n++) {
        pdi_extension_bond bond;
        pdi_extension_look(own, far, total, shift, lanes, way, n, most, &bond);
        double share = w * far[PDI_BAND_VOLUME * total + n] * bond.stretch;
        for (int p = 0; p < PD_DIM; p++)
            for (int q = 0; q < PD_DIM; q++)
                if (q <= p) sum[pdi_strain_place(p, q)][n] += share * bond.xi[p] * bond.xi[q];
        if (squares) sum[PDI_SYM][n] += share * bond.stretch * bond.square;
    }
}

/* The force on count points; stress 1: the stress of their families. */
PDI_SHARED void pdi_extension_pull(const double *PD_RESTRICT own, const double *PD_RESTRICT far, int64_t total,
                                   const double *shift, double w, uint32_t lanes, int stress, int way, int count,
                                   double *PD_RESTRICT most, double (*PD_RESTRICT sum)[PD_BAND_MOST])
{
    for (int n = 0; n < count; n++) {
        pdi_extension_bond bond;
        double alpha = own[PDI_EXTENSION_ALPHA * total + n], carried = 0.0;
        if (!stress) alpha += far[PDI_EXTENSION_ALPHA * total + n];
        pdi_extension_look(own, far, total, shift, lanes, way, n, most, &bond);
        for (int p = 0; p < PD_DIM; p++) {
            double line = 0.0;
            for (int q = 0; q < PD_DIM; q++) {
                int64_t at = (PDI_EXTENSION_STATE + pdi_strain_place(p, q)) * total + n;
                if (q <= p) line += (stress ? own[at] : own[at] + far[at]) * bond.xi[q];
            }
            carried += line * bond.xi[p];
        }
        double share = w * far[PDI_BAND_VOLUME * total + n] * (carried * bond.over + alpha * bond.stretch) * bond.part;
        if (lanes != PDI_BAND_ALL) share = (lanes >> n & 1u) ? share : 0.0;
        for (int p = 0; p < PD_DIM && !stress; p++) sum[p][n] += share * bond.y[p];
        for (int p = 0; p < PD_DIM && stress; p++)
            for (int q = 0; q < PD_DIM; q++)
                if (q <= p) sum[pdi_strain_place(p, q)][n] += share * bond.y[p] * bond.y[q];
    }
}

/* One of both for a bond. Inlined with constants for what tells them apart, for `shift`, `lanes` or `count`. */
PDI_SHARED void pdi_extension_of(const double *own, const double *far, int64_t total, const double *shift, double w,
                                 uint32_t lanes, int what, int way, int count, pdi_extension_loop *loop)
{
    if (what == PDI_EXTENSION_SHAPE || what == PDI_EXTENSION_ENERGY)
        pdi_extension_add(own, far, total, shift, w, lanes, what == PDI_EXTENSION_ENERGY, way, count, loop->most,
                          loop->sum);
    else
        pdi_extension_pull(own, far, total, shift, w, lanes, what == PDI_EXTENSION_STRESS, way, count, loop->most,
                           loop->sum);
}

/* All bonds of band k. Inlined with constants for `what` and `way`. */
PDI_SHARED void pdi_extension_bonds(const pd_band *band, int32_t k, int what, int way, pdi_extension_loop *loop)
{
    int32_t i = band->first[k], count = band->first[k + 1] - i;
    int whole = pdi_band_whole(count);
    int64_t total = band->stride;
    const double *own = pdi_band_field(band, 0) + i;
    double shift[PD_DIM];
    for (int p = 0; p < PDI_EXTENSION_ROWS; p++)
        for (int n = 0; n < whole; n++) loop->sum[p][n] = 0.0;
    for (int n = 0; n < whole; n++) loop->most[n] = 0.0;
    for (pd_walk f = pdi_walk_from(band->body, i); count == 1 && pdi_walk_next(&f);) {
        double w = pdi_bond_weights_intact(band->weights, i, &f);
        pdi_band_shift(band->body, pdi_walk_image(&f), shift);
        if (w > 0.0) pdi_extension_of(own, own + (f.to - i), total, shift, w, PDI_BAND_ALL, what, way, 1, loop);
    }
    for (int64_t b = band->begin[k]; b < band->begin[k + 1]; b++) {
        const double *far = own + band->bond[b].offset;
        double w = (double)band->bond[b].weight;
        uint32_t lanes = band->bond[b].lanes;
        if (band->bond[b].image) {
            pdi_band_shift(band->body, band->bond[b].image, shift);
            pdi_extension_of(own, far, total, shift, w, lanes, what, way, whole, loop);
        } else if (lanes == PDI_BAND_ALL)
            pdi_extension_of(own, far, total, NULL, w, PDI_BAND_ALL, what, way, PD_BAND_MOST, loop);
        else pdi_extension_of(own, far, total, NULL, w, lanes, what, way, whole, loop);
    }
}

/* The sums of band k. Inlined with a constant for `what`. */
PDI_SHARED void pdi_extension_sum(const pd_band *band, int32_t k, int linear, int what, pdi_extension_loop *loop)
{
    int32_t count = band->first[k + 1] - band->first[k], n = 0;
    if (linear) {
        pdi_extension_bonds(band, k, what, PDI_EXTENSION_LINEAR, loop);
        return;
    }
    pdi_extension_bonds(band, k, what, PDI_EXTENSION_SMALL, loop);
    while (n < count && loop->most[n] <= PDI_STRETCH_SMALL) n++;
    if (n < count) pdi_extension_bonds(band, k, what, PDI_EXTENSION_ANY, loop);
}

PDI_FN int32_t pdi_extension_shape(const pd_band *band, int32_t k, int linear, double (*shape)[PD_BAND_MOST],
                                   double *square)
{
    int32_t count = band->first[k + 1] - band->first[k];
    double sum[PDI_EXTENSION_ROWS][PD_BAND_MOST];
    pdi_extension_loop loop;
    loop.sum = sum;
    if (square) pdi_extension_sum(band, k, linear, PDI_EXTENSION_ENERGY, &loop);
    else pdi_extension_sum(band, k, linear, PDI_EXTENSION_SHAPE, &loop);
    for (int p = 0; p < PDI_SYM; p++)
        for (int32_t n = 0; n < count; n++) shape[p][n] = p < PD_DIM ? sum[p][n] : PDI_STRAIN_ROOT2 * sum[p][n];
    for (int32_t n = 0; n < count && square; n++) square[n] = sum[PDI_SYM][n];
    return count;
}

PDI_FN void pdi_extension_stress(const pd_band *band, int32_t k, int linear, double (*stress)[PD_BAND_MOST])
{
    double sum[PDI_EXTENSION_ROWS][PD_BAND_MOST];
    pdi_extension_loop loop;
    loop.sum = sum;
    pdi_extension_sum(band, k, linear, PDI_EXTENSION_STRESS, &loop);
    for (int p = 0; p < PDI_SYM; p++)
        for (int32_t n = 0; n < band->first[k + 1] - band->first[k]; n++) stress[p][n] = sum[p][n];
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
    double sum[PDI_EXTENSION_ROWS][PD_BAND_MOST];
    pdi_extension_loop loop;
    loop.sum = sum;
    pdi_extension_sum(band, k, linear, PDI_EXTENSION_FORCE, &loop);
    for (int32_t n = 0; n < count; n++)
        for (int d = 0; d < PD_DIM; d++) force[((int64_t)i + n) * PD_DIM + d] = sum[d][n];
}

#undef PDI_EXTENSION_ROWS
