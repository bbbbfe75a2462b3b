/* compact_operator: the compact (nearest-neighbour, 2d+1 point) finite-volume operator of a grid, for multigrid
 * preconditioners.
 *
 * The peridynamic operators act on families of nodes within the horizon; their compact counterparts have the same
 * continuum limit and a bounded spectral ratio, which is all that a preconditioner needs. Arrays run over the cells of
 * the box without ghosts, axis 0 fastest, as multigrid.h wants them. On an axisymmetric grid all coefficients are
 * multiplied by the circumference.
 */
#ifndef PD_COMPACT_OPERATOR_H
#define PD_COMPACT_OPERATOR_H
#include "core/array_registry.h"
#include "lattice/bond.h"
#include "lattice/bond_diffusivity.h"
#include "solve/multigrid.h"

/* Coefficients of the compact operator. */
typedef struct pd_compact_operator {
    const pd_grid *grid;
    int64_t cells; /* of the box, without ghosts */
    int with_flux; /* 1: there is convection */
    uint8_t *active;         /* [cells] 1: fluid */
    float *conductance[PD_DIM]; /* [cells] [1/s or 1/m2] diffusive coefficient of the upper face */
    float *flux[PD_DIM];     /* [cells] [1/s] volume flow through that face upwards over cell volume, NULL without
                              * flow */
    float *dirichlet;        /* [cells] Dirichlet coefficients of walls, inlets and outlets */
    float *mass;             /* [cells] diagonal terms: outflow, and 1/dt of the time derivative */
} pd_compact_operator;

#ifdef PDI_INTERNAL
/* Boundary conditions of the faces: Dirichlet (1) or zero flux (0). */
typedef struct pdi_compact_operator_bc {
    int wall, inlet, outlet;
    const pd_bonds *wall_bonds; /* distances of the walls behind closed faces; NULL: half a cell. Borrowed */
} pdi_compact_operator_bc;

/* List functions: the arrays of the cells, and those of the faces, which a multigrid setup consumes at once. Both by
 * the members that pdi_compact_operator_init sets. */
PDI_FN void pdi_compact_operator_list(pdi_array_visitor *owner, void *object);
PDI_FN void pdi_compact_operator_face_list(pdi_array_visitor *owner, void *object);
/* Set all members: grid (borrowed), sizes and with_flux (1: with convection), and no array. */
PDI_FN void pdi_compact_operator_init(const pd_grid *grid, int with_flux, pd_compact_operator *compact);
/* The convective term. */
typedef struct pdi_compact_operator_convection {
    const double *u;      /* [PD_DIM][total] [m/s]; NULL: none */
    const double
        *numerical_diffusivity; /* [PD_DIM][PD_DIM] [m] numerical diffusivity along the second axis per speed along the
                                 * first by which the peridynamic operator upwinds; NULL: central differences */
} pdi_compact_operator_convection;
/* Numerical diffusivity of upwinding bond by bond into spread [PD_DIM][PD_DIM], overwritten: spread[a][b] = share/2 sum
 * over all bonds of |g_a| xi_b^2 [m], with the gradient weights g of the stencil. */
PDI_FN void pdi_compact_operator_upwind_diffusion(const pd_stencil *stencil, double share, double *spread);
/* Assemble the operator into all its arrays. diffusivity [m2/s, or 1], or that of media where not NULL; mass [1/s]:
 * diagonal term of every fluid cell, to which outflow is added; faces: boundary conditions. convection is not NULL; its
 * u may be NULL, and needs with_flux where not. Cells that are not fluid get 0. */
PDI_FN void pdi_compact_operator_assemble(const pd_ctx *ctx, double diffusivity, const pd_bond_diffusivity *media,
                                          const pdi_compact_operator_convection *convection, double mass,
                                          const pdi_compact_operator_bc *faces, pd_compact_operator *compact);
/* 1: single precision is not enough on n [PD_DIM] cells of spacing h [PD_DIM] [m]: FLT_EPSILON L^2 > min(h)^2, with L
 * the longest side of the box. Rounding is a relative error eps that varies from cell to cell, so its Laplacian is of
 * size eps / min(h)^2. It may exceed the Laplacian of a field that varies over the whole box, of size 1 / L^2. */
PDI_FN int pdi_compact_operator_needs_double(const int *n, const double *h);
/* 1: the largest spacing is more than 4 times the smallest of h [PD_DIM] [m], so that the rounding of a cycle matters
 * at a few digits already. */
PDI_FN int pdi_compact_operator_is_stretched(const double *h);
/* Fill the multigrid desc from the grid: box, lattice, periodic axes, high_contrast as of
 * pdi_compact_operator_needs_double, and the circumference as rhs_weight (borrowed). All else, also `symmetric`, is
 * 0. */
PDI_FN void pdi_compact_operator_multigrid_desc(const pd_grid *grid, pd_multigrid_desc *desc);
/* Difference [m2] between the inverse symbols of the peridynamic and the compact Laplacian at short wavelengths, where
 * that of a wide family is nearly constant: 1 / lap_sum - 1 / sum_d (2 / h_d^2) (theory, eq. 6.22). 0 where that is
 * negative. */
PDI_FN double pdi_compact_operator_inverse_excess(const pd_stencil *stencil);
/* Cell number, axis 0 fastest, of the node with indices i [PD_DIM] inside the box. */
PDI_FN int64_t pdi_compact_operator_cell_index(const pd_grid *grid, const int *i);
#endif

#endif
