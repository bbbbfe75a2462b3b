/* coarse_fe_precond: coarse finite-element multigrid of a body under small strains, for preconditioners.
 *
 * Boxes about as wide as a bond hold finite elements of first order. Points of a box that are connected by bonds are an
 * element (part) of their own; its moduli are volume sums over its points. Elements that bonds connect share the nodes
 * that their boxes share, so a crack or a gap of any width separates the elements, too. Coarser levels have boxes of
 * twice the width, down to one box; a V-cycle of multigrid goes through them. Prescribed displacements are springs.
 *
 * Sources: Hansbo and Hansbo 2004 (elements that a crack cuts are doubled); Trottenberg, Oosterlee and Schueller 2001
 * (ch. 2); Bramble, Pasciak and Xu 1990 (corrections of all levels in a sum).
 */
#ifndef PD_COARSE_FE_PRECOND_H
#define PD_COARSE_FE_PRECOND_H
#include "core/array_registry.h"
#include "solid/body.h"

#define PD_COARSE_FE_LEVELS 30

typedef struct pd_coarse_fe_level {
    int32_t elements, nodes, blocks; /* elements, nodes, blocks of the matrix */
    int32_t *box;       /* [parts][PD_DIM] index of the box along the axes */
    int32_t *node;      /* [parts][2^d] corners; bit d of a corner: the upper end of axis d */
    int32_t *parent;    /* [parts] element of the next level */
    double *lambda, *mu; /* [parts] [N m] sum of V times a modulus (N in 1D and 2D per width and thickness) */
    int32_t colour[(1 << PD_DIM) + 1]; /* begin of the nodes of each colour; those of one colour are not adjacent */
    int32_t *corner;    /* [parts * 2^d] corners of all parts, by node */
    int32_t *first;     /* [nodes + 1] begin of each node in corner */
    int32_t *node_index; /* [nodes][PD_DIM] index of the node along the axes */
    double *spring;      /* [nodes][PD_DIM] [N/m] springs of prescribed displacements */
    int32_t *row;       /* [nodes + 1] begin of each node in column */
    int32_t *column;    /* [links] nodes */
    float *block;       /* [links][PD_DIM^2] [N/m] the operator */
    float *inverse;     /* [nodes][PD_DIM^2] [m/N] of its diagonal blocks */
    double *x, *b, *r;  /* [nodes][PD_DIM] [m], [N], [N] correction, right side, residual */
} pd_coarse_fe_level;

typedef struct pd_coarse_fe_precond {
    const pd_body *body;
    double width;       /* [m] of the boxes of level 0 */
    double lo[PD_DIM];  /* [m] corner of the first box */
    int32_t *element;   /* [count] element of level 0 of each point */
    int32_t *first_point; /* [parts + 1] begin of each part in point */
    int32_t *point;     /* [count] by part */
    double *nodal_force; /* [parts][2^d][PD_DIM] [N] nodal forces of elements: work */
    int levels;
    pd_coarse_fe_level level[PD_COARSE_FE_LEVELS];
} pd_coarse_fe_precond;

#ifdef PDI_INTERNAL
/* Builds elements, nodes and matrix patterns of all levels for the unbroken bonds of a body, which is borrowed;
 * matrices stay zero until pdi_coarse_fe_precond_assemble. Levels end with one box, or at PD_COARSE_FE_LEVELS. After an
 * error the object is empty. */
PDI_FN pd_status pdi_coarse_fe_precond_build(pd_ctx *ctx, const pd_body *body, pd_coarse_fe_precond *scaffold);
PDI_FN void pdi_coarse_fe_precond_free(pd_ctx *ctx, pd_coarse_fe_precond *scaffold);
/* Estimate of the memory [byte] for a compact body of `count` points whose boxes are `wide` points wide. */
PDI_FN double pdi_coarse_fe_precond_estimate_bytes(int32_t count, double wide);
/* Assembles all levels anew from Lame's moduli [count] [Pa] of the points and the springs hold [count][PD_DIM] [N/m];
 * 0: free; NULL: all are free. Springs go to the corners of the element of a point by its shape functions. */
PDI_FN void pdi_coarse_fe_precond_assemble(const pd_ctx *ctx, pd_coarse_fe_precond *scaffold, const double *lambda,
                                           const double *mu, const double *hold);
/* Adds the correction for forces f [count][PD_DIM] [N] to u [count][PD_DIM] [m], by one V-cycle: linear, symmetric and
 * positive. Nodal arrays of the levels are work. */
PDI_FN void pdi_coarse_fe_precond_apply(const pd_ctx *ctx, pd_coarse_fe_precond *scaffold, const double *f, double *u);
#endif

#endif
