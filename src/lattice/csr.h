/* csr: an operator on a set of nodes as a sparse matrix in compressed row storage, for solvers of the caller.
 *
 * The matrix of the unknowns and the part of the prescribed (Dirichlet) values make up the operator of op.h:
 *     (operator f)[node[r]] = sum over row r of weight x[column]  +  sum over row r of prescribed_weight f[prescribed]
 * with x[column] = f[node[column]]. A bond to an image behind a periodic or mirror side counts for the source node of
 * the image, with the sign of the component. Given (prescribed) are the nodes outside of the set and the ghosts of
 * inlets and outlets: in a Dirichlet problem they go to the right-hand side, as -(given part). Bonds blocked by solid
 * or wall take no part, as in op.h.
 */
#ifndef PD_CSR_H
#define PD_CSR_H
#include "lattice/bond.h"

typedef enum pd_csr_operator {
    PD_CSR_LAPLACIAN = 0, /* pd_op_laplacian [1/m2] */
    PD_CSR_DIFFUSE,       /* pd_op_diffusion [1/s] with `diffusivity` */
    PD_CSR_GRADIENT,      /* component `axis` of pd_op_gradient [1/m] */
    PD_CSR_DIVERGENCE     /* contribution of component `axis` of the vector to pd_op_divergence [1/m] */
} pd_csr_operator;

typedef struct pd_csr_desc {
    pd_csr_operator op;
    int axis;                  /* component, for PD_CSR_GRADIENT and PD_CSR_DIVERGENCE */
    const double *diffusivity; /* [total] [m2/s] of PD_CSR_DIFFUSE, at nodes and at ghosts of inlets and outlets */
    const uint8_t *mask;       /* [total] not 0: the node is in the set when it is fluid; NULL: all fluid nodes */
} pd_csr_desc;

/* Columns of a row are in ascending order, each once. The diagonal is always there. */
typedef struct pd_csr {
    int32_t rows;
    int32_t *node;        /* [rows] node of the lattice */
    int32_t *row_of_node; /* [total] row of a node; -1: not in the set */
    int64_t *row_begin;   /* [rows + 1] begin of each row in column and weight */
    int32_t *column;      /* [row_begin[rows]] */
    double *weight;       /* [row_begin[rows]] [unit of the operator] */
    int64_t *prescribed_begin; /* [rows + 1] */
    int32_t *prescribed;       /* [prescribed_begin[rows]] nodes of the lattice */
    double *prescribed_weight; /* [prescribed_begin[rows]] [unit of the operator] */
    int32_t total;        /* nodes of the lattice */
} pd_csr;

#define pd_csr_build PD_NAME(pd_csr_build)
#define pd_csr_apply PD_NAME(pd_csr_apply)
#define pd_csr_free PD_NAME(pd_csr_free)

/* Assembles the matrix; `csr` is overwritten, and all zero after a failure. It keeps no pointer to bonds or desc.
 * PD_ERR_ARGUMENT: an unknown operator, an axis that does not exist, no diffusivity, one of a fluid, inlet or outlet
 * node that is negative or not finite. PD_ERR_GEOMETRY: no fluid node is in the set. */
PD_API pd_status pd_csr_build(pd_ctx *ctx, const pd_bonds *bonds, const pd_csr_desc *desc, pd_csr *csr);
/* y [rows] = matrix times x [rows], plus the part of the prescribed values f [total]; f NULL: without it. y is another
 * array than x. */
PD_API void pd_csr_apply(const pd_csr *csr, const double *x, const double *f, double *y);
PD_API void pd_csr_free(pd_ctx *ctx, pd_csr *csr);

#endif
