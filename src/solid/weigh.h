/* weigh: how much bonds count: by length, by direction, and by what surfaces lack; sums over lattices.
 *
 * w = omega(r) beta (1 + a q) g: q tells axes from diagonals, and a makes the shear modulus of a lattice the same in
 * all directions (theory: eq. 8.7, with r^2 for r); g makes up for bonds that cut families lack (theory: eq. 8.8e).
 */
#ifndef PD_WEIGH_H
#define PD_WEIGH_H
#include "core/vec.h"
#include "solid/bond_weights.h"

#ifdef PDI_INTERNAL
typedef enum pdi_weigh_way {
    PDI_WEIGH_PLAIN = 0, /* g = 1 */
    PDI_WEIGH_ENERGY,    /* by the energy of strains along the axes */
    PDI_WEIGH_VOLUME     /* 2 V_0/(V_i + V_j), V: of families */
} pdi_weigh_way;

/* Sums over a whole family of the lattice. */
typedef struct pdi_weigh_sums {
    double size;   /* [m^(d+2)] sum w r^2 V */
    double axis;   /* [m^(d+2)] sum w r^2 n_0^4 V */
    double off;    /* [m^(d+2)] sum w r^2 n_0^2 n_1^2 V */
    double volume; /* [m^d] sum beta V, beta: what lies within the horizon */
    double least;  /* [-] least w of all bonds */
} pdi_weigh_sums;

typedef struct pdi_weigh {
    const pd_body *body;
    pd_influence influence;
    pdi_weigh_way way;
    double shear;         /* [-] a */
    const double *part;   /* [count][PD_DIM] what families have, for factors; NULL: none. Work */
    pdi_weigh_sums whole; /* zero without a spacing */
} pdi_weigh;

/* The part q of direction xi; its mean over all directions is zero. 1D has one direction. */
static inline double pdi_weigh_cubic(const double *xi, double square)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += xi[d] * xi[d] * xi[d] * xi[d] / (square * square);
    return PD_DIM > 1 ? sum - 3.0 / (PD_DIM + 2.0) : 0.0;
}
/* g of a bond along xi whose ends have the parts `own` and `other` of `bulk` along the axes: the mean of both ends,
 * between axes as on an ellipsoid (Madenci and Oterkus 2014, ch. 4; Le and Bobaru 2018). */
PDI_FN double pdi_weigh_factor(const double *own, const double *other, const double *xi, double bulk);
/* Volume of a cell of the lattice [m^d]. */
static inline double pdi_weigh_cell(const pd_body *body)
{
    double volume = 1.0;
    for (int d = 0; d < PD_DIM; d++) volume *= body->spacing;
    return volume;
}
/* How many places of a lattice a family may have. */
PDI_FN int pdi_weigh_places(const pd_body *body);
/* Place k of them: xi [m], and its square; 0: the point itself. */
PDI_FN double pdi_weigh_place(const pd_body *body, int k, double *xi);
/* Largest over least energy of a crack, all normals n; 1: it takes none. */
PDI_FN double pdi_weigh_anisotropy(double (*crack)(const void *self, const double *n), const void *self);
/* a where that is wanted, and the sums. PD_ERR_ARGUMENT: no positive weights are the same in all directions. */
PDI_FN pd_status pdi_weigh_calibrate(pd_ctx *ctx, pdi_weigh *weigh, int isotropic);
/* Weights of all bonds. Both ends of a bond get the same number, and bonds that are broken count as others do. */
PDI_FN pd_status pdi_weigh_bonds(pd_ctx *ctx, const pdi_weigh *weigh, pd_bond_weights *weights);
#endif

#endif
