/* stencil: the family of an interior node of a uniform lattice and its calibrated weights.
 *
 * A bond is an integer offset n != 0 with |n| < m + 1/2 (or |n| <= m) and xi = n h (componentwise); all weights are
 * shared by every node whose family is full, not truncated by a surface. Calibrated weights make the gradient, the
 * divergence and the Laplacian exact on all quadratics for any m, spacing ratio and dimension (theory: eq. 1.3, 1.4).
 */
#ifndef PD_STENCIL_H
#define PD_STENCIL_H
#include "core/base.h"

typedef enum pd_weights {
    PD_WEIGHTS_CALIBRATED = 0, /* discrete moments exact; refused when a Laplacian weight would be negative */
    PD_WEIGHTS_PUBLISHED = 1   /* continuum coefficients of the papers, only to reproduce published figures */
} pd_weights;

typedef enum pd_family {
    /* |n| < m + 1/2; cells at the horizon count with the part beta of their volume inside it */
    PD_FAMILY_PARTIAL_CELLS = 0,
    PD_FAMILY_FULL_CELLS = 1 /* |n| <= m, all cells in full, as in codes that sum by fast Fourier transforms */
} pd_family;

typedef struct pd_stencil_desc {
    double m;          /* [-] horizon ratio; 0: 3 */
    double h[PD_DIM];  /* [m] spacing of each axis */
    pd_weights weights;
    pd_family family;
} pd_stencil_desc;

typedef struct pd_stencil {
    int count;           /* bonds of a full family */
    int reach;           /* largest |n_a| of a bond: ghost layers that a full family needs */
    double m;            /* [-] */
    double h[PD_DIM];    /* [m] */
    double volume;       /* [m^d] of a cell */
    int *offset;         /* [count][PD_DIM] n; entry count-1-k is the opposite of entry k */
    double *xi;          /* [count][PD_DIM] [m] bond vector */
    double *partial_volume;   /* [count] [-] partial volume */
    double *laplacian_weight; /* [count] [1/m2] a(n): lap f = sum a (f_j - f_i) */
    double lap_sum;      /* [1/m2] sum of a(n) */
    double *gradient_weight; /* [count][PD_DIM] [1/m] g(n): grad f = sum g (f_j - f_i) */
    double *base_weight;     /* [count] [m^(d-2)] w(n), the weight before calibration */
    /* [count] [1/m] c(n): interface area that a solid-fluid bond stands for, over V (eq. 10.5) */
    double *area_weight;
    double anisotropy;   /* [-] largest deviation of the area measure from 1 over all directions */
    /* The family as grid lines along axis 0. Lines with the same weights are of one kind; the line through the node
     * itself is not among them. */
    int line_kinds;      /* number of different sets of weights of a line */
    int *line_first;     /* [kinds+1] into line */
    int *line;           /* [lines][PD_DIM] offset of the line from the node, 0 along axis 0 */
    int *line_reach;     /* [kinds] largest |n_0| of the bonds that end on the line */
    double *line_lap;    /* [kinds][reach+1] [1/m2] a(n) by |n_0| */
    double *layer_lap;   /* [reach+1] [1/m2] by n_0 > 0: sum of a(n) over all bonds with that n_0 */
    /* Cells that the straight bond passes through, as groups of alternatives: the bond is blocked when every cell of
     * one group is closed (solid or wall). The last group of each bond is its end node. */
    int *group_first;    /* [count+1] into group_* */
    int *group_cell;     /* [groups+1] first entry of the group in cell */
    double *group_entry; /* [groups] [-] fraction of the bond at which it enters the group */
    uint8_t *group_axes; /* [groups] bit a: it enters through a face normal to axis a (several bits: edge or corner) */
    int *cell;           /* [cells][PD_DIM] offset of a cell from the start node */
    int groups, cells;
} pd_stencil;

#define pd_stencil_build PD_NAME(pd_stencil_build)
#define pd_stencil_free PD_NAME(pd_stencil_free)

/* Builds the family of a node away from surfaces, its weights, its grid lines and the cells that its bonds cross.
 * `stencil` is overwritten, and all zero after a failure. PD_ERR_ARGUMENT: m neither 0 (it is 3 then) nor in [1, 12], h
 * not positive and finite. PD_ERR_GEOMETRY: a calibrated weight is not positive. Also the failures of
 * pdi_area_weights_compute. Source: Tian and Du 2014 (asymptotic compatibility); Zhao and Bobaru 2022 (operators). */
PD_API pd_status pd_stencil_build(pd_ctx *ctx, const pd_stencil_desc *desc, pd_stencil *stencil);
PD_API void pd_stencil_free(pd_ctx *ctx, pd_stencil *stencil);

#endif
