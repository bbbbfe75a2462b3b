/* scaffold: a coarse picture of a body under small strains, for preconditioners.
 *
 * Boxes about as wide as a bond hold finite elements of first order. What lies in a box and hangs together by bonds is
 * a part, with an element of its own: its moduli are those of the box times the share of its points. Parts that bonds
 * join share the nodes that their boxes share, so a crack or a gap of any width parts the elements, too. Boxes of
 * twice the width follow, down to one box; a cycle of multigrid goes through them. What is held is held by springs.
 *
 * Sources: Hansbo and Hansbo 2004 (elements that a crack cuts are doubled); Trottenberg, Oosterlee and Schueller 2001
 * (ch. 2); Bramble, Pasciak and Xu 1990 (corrections of all levels in a sum).
 */
#ifndef PD_SCAFFOLD_H
#define PD_SCAFFOLD_H
#include "core/owner.h"
#include "solid/body.h"

#define PD_SCAFFOLD_LEVELS 30

typedef struct pd_scaffold_level {
    int32_t parts, nodes, links;
    int32_t *box;       /* [parts][PD_DIM] index of the box along the axes */
    int32_t *node;      /* [parts][2^d] corners; bit d of a corner: the upper end of axis d */
    int32_t *parent;    /* [parts] of the next level */
    double *lambda, *mu; /* [parts] [N m] sum of V times a modulus (N in 1D and 2D per width and thickness) */
    int32_t colour[(1 << PD_DIM) + 1]; /* begin of the nodes of each colour; those of one colour do not touch */
    int32_t *corner;    /* [parts * 2^d] corners of all parts, by node */
    int32_t *first;     /* [nodes + 1] begin of each node in corner */
    int32_t *place;     /* [nodes][PD_DIM] index of the node along the axes */
    double *hold;       /* [nodes][PD_DIM] [N/m] springs */
    int32_t *row;       /* [nodes + 1] begin of each node in column */
    int32_t *column;    /* [links] nodes */
    float *block;       /* [links][PD_DIM^2] [N/m] the operator */
    float *inverse;     /* [nodes][PD_DIM^2] [m/N] of its diagonal blocks */
    double *x, *b, *r;  /* [nodes][PD_DIM] [m], [N], [N] correction, what it is for, what it leaves */
} pd_scaffold_level;

typedef struct pd_scaffold {
    const pd_body *body;
    double width;       /* [m] of the boxes of level 0 */
    double lo[PD_DIM];  /* [m] corner of the first box */
    int32_t *part;      /* [count] of level 0 */
    int32_t *first;     /* [parts + 1] begin of each part in point */
    int32_t *point;     /* [count] by part */
    double *sum;        /* [parts][2^d][PD_DIM] [N] */
    int levels;
    pd_scaffold_level level[PD_SCAFFOLD_LEVELS];
} pd_scaffold;

#ifdef PDI_INTERNAL
/* Boxes, parts and nodes of a body with the bonds that it has now. */
PDI_FN pd_status pdi_scaffold_build(pd_ctx *ctx, const pd_body *body, pd_scaffold *scaffold);
PDI_FN void pdi_scaffold_free(pd_ctx *ctx, pd_scaffold *scaffold);
/* [byte] of that for a compact body of so many points whose boxes are `wide` points wide. */
PDI_FN double pdi_scaffold_bytes(int32_t count, double wide);
/* Moduli [count] [Pa] of the points and springs that hold them, hold [count][PD_DIM] [N/m]: 0 for what is free. */
PDI_FN void pdi_scaffold_fill(const pd_ctx *ctx, pd_scaffold *scaffold, const double *lambda, const double *mu,
                              const double *hold);
/* Add the correction for forces f [count][PD_DIM] [N] to u [count][PD_DIM] [m]: linear, symmetric and positive. */
PDI_FN void pdi_scaffold_add(const pd_ctx *ctx, pd_scaffold *scaffold, const double *f, double *u);
#endif

#endif
