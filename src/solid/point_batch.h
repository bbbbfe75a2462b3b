/* point_batch: batches of consecutive points with equal families, and the two sums over bonds of the correspondence
 * model.
 *
 * Consecutive points whose bonds have the same index offsets and weights make a batch (band). Some points may lack a
 * few of the bonds, as at a surface, or have broken ones: a bit mask says which points have a bond. A lattice consists
 * of batches along its rows. A batch has one list of bonds, and its loops over points are vectorised. Each point adds
 * its bonds in the order of its family, and zero for a bond that it lacks, so results have the same bits however points
 * are put into batches.
 */
#ifndef PD_POINT_BATCH_H
#define PD_POINT_BATCH_H
#include "solid/bond_weights.h"

#define PD_POINT_BATCH_MAX 32 /* points of a band */

/* A bond that points of a batch have. */
typedef struct pd_point_batch_bond {
    int32_t offset; /* index of the neighbour less index of the point */
    int32_t image;  /* number of periods by which the neighbour is shifted; 0 without a period */
    float weight;   /* [-] w */
    uint32_t mask;  /* bit n: point n of the batch has the bond */
} pd_point_batch_bond;

typedef struct pd_point_batch {
    const pd_body *body;
    const pd_bond_weights *weights; /* borrowed */
    int32_t fields;                 /* how many of PDI_POINT_BATCH_POSITION and so on a point has */
    int list_single_points;         /* 1: batches of one point have a list of bonds, too */
    int lattice_vectors;            /* 1: all points of a batch have the same lattice vector for a bond */
    int32_t max_points;             /* largest number of points of a batch */
    int32_t batches;
    int32_t *first;      /* [count + 1] first point of each band, then count */
    int64_t *begin;      /* [count + 1] begin of each band in bond; a single point has its family in the body */
    int64_t capacity;
    pd_point_batch_bond *bond; /* [room] */
    int64_t stride;      /* entries of a field: count, padded so that fields do not share cache sets */
    /* [fields][stride] [m] and others: point data that bond loops read, see PDI_POINT_BATCH_POSITION */
    double *field;
} pd_point_batch;

#ifdef PDI_INTERNAL
/* Doubles in a cache line of 64 bytes. */
#define PDI_POINT_BATCH_CACHE_LINE 8
/* Mask of a bond that all points of a batch of PD_POINT_BATCH_MAX have. */
#define PDI_POINT_BATCH_FULL_MASK UINT32_MAX

enum {
    PDI_POINT_BATCH_TENSOR = PD_DIM * PD_DIM,
    PDI_POINT_BATCH_POSITION = 0,                              /* x [m] */
    PDI_POINT_BATCH_VOLUME = PD_DIM,                           /* V [m^d] */
    PDI_POINT_BATCH_DISPLACEMENT = PDI_POINT_BATCH_VOLUME + 1, /* u [m] */
    /* s/w_0 [1/m^d], s: stiffness factor of the point */
    PDI_POINT_BATCH_STIFFNESS = PDI_POINT_BATCH_DISPLACEMENT + PD_DIM,
    /* s/w_0 H^T [1/m^d], H: displacement gradient */
    PDI_POINT_BATCH_GRADIENT = PDI_POINT_BATCH_STIFFNESS + 1,
    PDI_POINT_BATCH_FORCE_TENSOR = PDI_POINT_BATCH_GRADIENT + PDI_POINT_BATCH_TENSOR, /* A [Pa/m^(d+2)] of eq. 14.4 */
    /* s/w_0 times the plastic stress [Pa/m^d] */
    PDI_POINT_BATCH_PLASTIC_STRESS = PDI_POINT_BATCH_FORCE_TENSOR + PDI_POINT_BATCH_TENSOR,
    PDI_POINT_BATCH_FIELDS = PDI_POINT_BATCH_PLASTIC_STRESS + PDI_POINT_BATCH_TENSOR
};

/* Sums over the families of the points of a batch; xi: bond, eta: relative displacement, r = |xi|. */
typedef struct pdi_point_batch_sums {
    double moment[PDI_POINT_BATCH_TENSOR][PD_POINT_BATCH_MAX];      /* [m^(d+2)] sum w V eta xi^T */
    double unit_moment[PDI_POINT_BATCH_TENSOR][PD_POINT_BATCH_MAX]; /* [m^d] sum w V eta xi^T/r^2 */
    /* [m^d] sum w V (eta.xi) xi xi^T/r^4; its upper triangle */
    double axial_moment[PDI_POINT_BATCH_TENSOR][PD_POINT_BATCH_MAX];
} pdi_point_batch_sums;

/* Describes the arrays of a batch object, without the list of bonds, which grows. */
PDI_FN void pdi_point_batch_list(pdi_array_visitor *owner, void *band);
/* Prepares zeroed fields and stores positions and volumes; body and weights are borrowed. fields: how many fields a
 * point has, such as PDI_POINT_BATCH_STIFFNESS for those before it. There are no batches: pdi_point_batch_update has to
 * follow. After an error the object is empty. */
PDI_FN pd_status pdi_point_batch_build(pd_ctx *ctx, const pd_body *body, const pd_bond_weights *weights, int32_t fields,
                                       pd_point_batch *band);
PDI_FN void pdi_point_batch_free(pd_ctx *ctx, pd_point_batch *band);
/* Divides the points into batches anew, after weights have changed or bonds have broken; fields stay. Batches of one
 * point have no list of bonds unless list_single_points. The list of bonds grows and never shrinks. */
PDI_FN pd_status pdi_point_batch_update(pd_ctx *ctx, pd_point_batch *band);
/* Stores the displacements u [count][PD_DIM] [m] as fields. */
PDI_FN void pdi_point_batch_set_displacements(const pd_ctx *ctx, const pd_point_batch *band, const double *u);
/* Sums over the unbroken bonds of the points of batch k, of the displacements that are set, into sums, which is
 * overwritten. Returns how many points the batch has. */
PDI_FN int32_t pdi_point_batch_compute_sums(const pd_point_batch *band, int32_t k, pdi_point_batch_sums *sums);
/* force [count][PD_DIM] [N/m3] of the points of batch k (theory, eq. 14.4), with Lame's moduli lambda and mu [Pa], from
 * fields that are set; other entries stay. */
PDI_FN void pdi_point_batch_compute_force(const pd_point_batch *band, int32_t k, double lambda, double mu,
                                          double *force);

/* Field number `field` of all points, index 0: point 0. The PD_POINT_BATCH_MAX entries before it belong to padding. */
static inline double *pdi_point_batch_get_field(const pd_point_batch *band, int field)
{
    return band->field + PD_POINT_BATCH_MAX + field * band->stride;
}
/* Points of a batch of `count`, rounded up to whole cache lines; 1 for a single point. */
static inline int pdi_point_batch_pad_count(int32_t count)
{
    return count > 1
               ? (count + PDI_POINT_BATCH_CACHE_LINE - 1) / PDI_POINT_BATCH_CACHE_LINE * PDI_POINT_BATCH_CACHE_LINE
               : 1;
}
/* Shift [m] of a periodic image against its point. */
static inline void pdi_point_batch_image_shift(const pd_body *body, int32_t image, double *shift)
{
    for (int d = 0; d < PD_DIM; d++) shift[d] = image * body->period[d];
}
#endif

#endif
