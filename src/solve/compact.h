/* compact: the nearest-neighbour (2d+1 point) picture of a scene that multigrid preconditioners work on.
 *
 * The peridynamic operators act on whole families; their compact counterparts have the same continuum limit and
 * bounded spectral ratio, which is all that a preconditioner needs. Arrays run over the cells of the box without
 * ghosts, axis 0 fastest, as multigrid.h wants them. On an axisymmetric grid all coefficients count the circumference.
 */
#ifndef PD_COMPACT_H
#define PD_COMPACT_H
#include "core/owner.h"
#include "lattice/bond.h"
#include "lattice/media.h"
#include "solve/multigrid.h"

typedef struct pd_compact {
    const pd_grid *grid;
    int64_t cells;
    int with_flux;
    uint8_t *active;         /* [cells] 1: fluid */
    float *conduct[PD_DIM];  /* [cells] [1/s or 1/m2] diffusive coefficient of the face towards + */
    float *flux[PD_DIM];     /* [cells] [1/s] flow through that face towards +, NULL without flow */
    float *wall;             /* [cells] boundary values held at walls, inlets or outlets */
    float *mass;             /* [cells] outflow and time terms */
} pd_compact;

#ifdef PDI_INTERNAL
/* Which boundary faces hold a value (1) or let nothing through (0). */
typedef struct pdi_compact_faces {
    int closed, inlet, outlet;
    const pd_bonds *walls; /* how far off closed faces hold theirs; NULL: half a cell. Borrowed */
} pdi_compact_faces;

/* Arrays of a pd_compact: of the cells, and of their faces, which go into a multigrid at once. One without them can be
 * counted. */
PDI_FN void pdi_compact_list(pdi_owner *owner, void *object);
PDI_FN void pdi_compact_face_list(pdi_owner *owner, void *object);
PDI_FN void pdi_compact_plan(const pd_grid *grid, int with_flux, pd_compact *compact);
/* What becomes of the convective term. */
typedef struct pdi_compact_convection {
    const double *u;      /* [PD_DIM][total] [m/s]; NULL: none */
    const double *spread; /* [PD_DIM][PD_DIM] [m] diffusivity along the second axis per speed along the first, that the
                           * peridynamic operator adds by upwinding; NULL: central */
} pdi_compact_convection;
/* Upwinding bond by bond spreads along b by 1/2 sum |g_a| xi_b^2 per speed along a; times `share`. */
PDI_FN void pdi_compact_upwind(const pd_stencil *stencil, double share, double *spread);
/* diffusivity [m2/s, or 1], or that of media when not NULL; mass: value for every fluid cell [1/s]. */
PDI_FN void pdi_compact_fill(const pd_ctx *ctx, double diffusivity, const pd_media *media,
                             const pdi_compact_convection *convection, double mass, const pdi_compact_faces *faces,
                             pd_compact *compact);
/* 1: single precision does not do. The rounding of a field is a share eps of the field and changes from cell to cell,
 * so its Laplacian goes with eps over the square of the least spacing. It may exceed the Laplacian of the field itself,
 * which may change over the whole box. */
PDI_FN int pdi_compact_contrast(const int *n, const double *h);
/* 1: spacings differ so much that the rounding of a cycle shows at a few digits already. */
PDI_FN int pdi_compact_stretched(const double *h);
/* What a multigrid has to know of the box: all of the desc but `symmetric`, which becomes 0. */
PDI_FN void pdi_compact_multigrid(const pd_grid *grid, pd_multigrid_desc *desc);
/* What 1/(Laplacian) of a wide family exceeds that of the compact one by in short waves, on average [m2]: a wide family
 * gives waves of all short lengths nearly the same (eq. 5.15). At least 0. */
PDI_FN double pdi_compact_excess(const pd_stencil *stencil);
/* Box cell of a node inside the box, and back. */
PDI_FN int64_t pdi_compact_cell(const pd_grid *grid, const int *i);
#endif

#endif
