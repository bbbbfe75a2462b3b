/* band: the two sums over bonds that small strains need, for many points at a time.
 *
 * Points that follow each other and whose families are alike make a band: the bonds of the next one lead to the next
 * points and have the same weights. Some points may lack a few of the bonds, as at a surface, or have broken ones. A
 * lattice consists of bands as long as its rows. A band has one list of bonds, and its loops are vectors. Each point
 * takes its bonds in the order of its row, and of a bond that it lacks it takes zero, so results have the same bits
 * however points are put into bands.
 */
#ifndef PD_BAND_H
#define PD_BAND_H
#include "solid/bond_weights.h"

#define PD_BAND_MOST 32 /* points of a band */

/* A bond that points of a band have. */
typedef struct pd_band_bond {
    int32_t offset; /* the point at the other end less the point */
    int32_t image;  /* by how many the image there is off its point; 0 without a period */
    float weight;   /* [-] w */
    uint32_t lanes; /* bit n: point n of the band has the bond */
} pd_band_bond;

typedef struct pd_band {
    const pd_body *body;
    const pd_bond_weights *weights; /* borrowed */
    int32_t fields;      /* how many of PDI_BAND_PLACE and so on a point has */
    int singles;         /* 1: points that are alone have a list of bonds, too */
    int vectors;         /* 1: all points of a band have the same vector of whole spacings for a bond */
    int32_t most;        /* points of a band */
    int32_t bands;
    int32_t *first;      /* [count + 1] first point of each band, then count */
    int64_t *begin;      /* [count + 1] begin of each band in bond; a single point has its family in the body */
    int64_t room;
    pd_band_bond *bond;  /* [room] */
    int64_t stride;      /* entries of a field: count, and as many as keep fields off the same lines of a cache */
    double *field;       /* [fields][stride] [m] and others: what bonds read of a point, see PDI_BAND_PLACE */
} pd_band;

#ifdef PDI_INTERNAL
/* Doubles in a line of a cache. */
#define PDI_BAND_LINE 8
/* Bits of a bond that all points of the longest band have. */
#define PDI_BAND_ALL UINT32_MAX

enum {
    PDI_BAND_TENSOR = PD_DIM * PD_DIM,
    PDI_BAND_PLACE = 0,                              /* x [m] */
    PDI_BAND_VOLUME = PD_DIM,                        /* V [m^d] */
    PDI_BAND_MOVE = PDI_BAND_VOLUME + 1,             /* u [m] */
    PDI_BAND_SHARE = PDI_BAND_MOVE + PD_DIM,         /* part of E over w_0 [1/m^d] */
    PDI_BAND_TURN = PDI_BAND_SHARE + 1,              /* share H^T [1/m^d] */
    PDI_BAND_CARRY = PDI_BAND_TURN + PDI_BAND_TENSOR, /* A [Pa/m^(d+2)] of eq. 8.4 */
    PDI_BAND_RELIEF = PDI_BAND_CARRY + PDI_BAND_TENSOR, /* share times the relief [Pa/m^d], where metal flows */
    PDI_BAND_FIELDS = PDI_BAND_RELIEF + PDI_BAND_TENSOR
};

/* Sums over the bonds of each point of a band. */
typedef struct pdi_band_sums {
    double pull[PDI_BAND_TENSOR][PD_BAND_MOST];  /* [m^(d+2)] sum w V eta xi^T */
    double turn[PDI_BAND_TENSOR][PD_BAND_MOST];  /* [m^d] sum w V eta xi^T/r^2 */
    double along[PDI_BAND_TENSOR][PD_BAND_MOST]; /* [m^d] sum w V (eta.xi) xi xi^T/r^4; its upper triangle */
} pdi_band_sums;

PDI_FN void pdi_band_list(pdi_owner *owner, void *band);
/* body and weights are borrowed. fields: PDI_BAND_SHARE for what stands before it, and so on.
 * pdi_band_find has to follow. */
PDI_FN pd_status pdi_band_build(pd_ctx *ctx, const pd_body *body, const pd_bond_weights *weights, int32_t fields,
                                pd_band *band);
PDI_FN void pdi_band_free(pd_ctx *ctx, pd_band *band);
/* Weights have changed, or bonds have broken: bands anew. */
PDI_FN pd_status pdi_band_find(pd_ctx *ctx, pd_band *band);
/* Take displacements u [count][PD_DIM] [m]. */
PDI_FN void pdi_band_move(const pd_ctx *ctx, const pd_band *band, const double *u);
/* The sums of band k. Returns how many points it has. */
PDI_FN int32_t pdi_band_collect(const pd_band *band, int32_t k, pdi_band_sums *sums);
/* force [count][PD_DIM] [N/m3] of the points of band k (theory, eq. 8.4). */
PDI_FN void pdi_band_force(const pd_band *band, int32_t k, double lambda, double mu, double *force);

static inline double *pdi_band_field(const pd_band *band, int field)
{
    return band->field + PD_BAND_MOST + field * band->stride;
}
/* Points of a band of count ones with those that fill the last line. */
static inline int pdi_band_whole(int32_t count)
{
    return count > 1 ? (count + PDI_BAND_LINE - 1) / PDI_BAND_LINE * PDI_BAND_LINE : 1;
}
/* By how much an image is off its point [m]. */
static inline void pdi_band_shift(const pd_body *body, int32_t image, double *shift)
{
    for (int d = 0; d < PD_DIM; d++) shift[d] = image * body->period[d];
}
#endif

#endif
