/* bond: bonds of fluid nodes near walls: a row of data for each node whose family is truncated by a surface or sees an
 * inlet (irregular node), and ranges of nodes whose family is full.
 *
 * A bond is open when both ends and every cell that its straight line crosses are open (fluid, inlet, outlet, image),
 * so a wall one node thick separates its two sides. A cut (blocked) bond intersects the surface at the fraction t of
 * its length: on the zero level of the shape where that is known, else on the face of the closed cell. It acts
 * through a fictitious value at its end, the extrapolation of the field from the node through the wall value at t
 * (theory: eq. 2.2 to 2.4). This needs the wall terms (wall_laplacian, wall_curvature) of each row and no ghost value
 * in the solid.
 */
#ifndef PD_BOND_H
#define PD_BOND_H
#include "core/array_registry.h"
#include "lattice/active_range.h"
#include "lattice/ghost.h"
#include "lattice/bond_path.h"
#include "lattice/axisym.h"

/* Velocity u [PD_DIM] [m/s] of a wall at the position x [m]. */
typedef void (*pd_velocity_fn)(void *user, const double *x, double *u);

/* Ranges of consecutive nodes along axis 0. */
typedef struct pd_node_ranges {
    int32_t count, capacity;
    int32_t *first, *length; /* [capacity] first node, and number of nodes */
} pd_node_ranges;

/* Which nodes own rows, and what rows store: a sum of these. */
typedef enum pd_bonds_options {
    PD_BONDS_ALL_ROWS = 1,  /* every fluid node owns a row (to compare both ways of evaluation) */
    PD_BONDS_NO_FLOW = 2,   /* no flow: the wall terms of the momentum equation are not stored */
    PD_BONDS_LOW_MEMORY = 4 /* with PD_BONDS_NO_FLOW: moments of rows are computed when a gradient needs them */
} pd_bonds_options;

typedef struct pd_bonds {
    const pd_stencil *stencil;
    const pd_grid *grid;
    pd_ghosts ghosts;    /* of the grid: to set the values at far ends of bonds */
    pd_active_ranges active_ranges; /* of the grid */
    int options;         /* pd_bonds_options */
    pd_bond_paths paths; /* of the stencil on the grid */
    int32_t *line_shift; /* [lines of the stencil] node id on a grid line minus that of the node at its middle */
    double full_moment[PD_DIM]; /* [unit of base m2] sum w xi_a^2 over a full family */
    pd_axisym axisym;      /* weights of an axisymmetric grid; empty: planar */
    int32_t *row_of_node;  /* [total] row of a node; -1: full family, or not fluid */
    uint32_t version;    /* grows with each update; starts at 1 */
    uint32_t *node_version; /* [total] version in which the kind of the node or its bonds last changed; 0: never */
    int32_t rows, capacity;
    /* rows [0, plain) have no bond to an inlet, in the order of nodes; those with one follow */
    int32_t rows_without_inlet;
    int32_t *node;       /* [capacity] node of a row */
    uint32_t *open_mask; /* [words of the paths][capacity] bit k % 32 of word k / 32: bond k is open */
    uint8_t *has_inlet;  /* [capacity] 1: an open bond ends on an inlet ghost */
    double *inverse_moment; /* [capacity][PD_DIM][PD_DIM] [unit of 1/(base m2)] inverse of sum w xi xi^T over open bonds
                             * (eq. 2.9); NULL: PD_BONDS_LOW_MEMORY */
    /* NULL with PD_BONDS_NO_FLOW: */
    uint8_t *near_smooth_surface; /* [capacity] 1: a closed bond ends on a shape that is curved or inclined there */
    double *neighbour_distance; /* [capacity][2 PD_DIM] [-] distance to the neighbour x-, x+, y-, ... in spacings: 1, or
                                 * minus the fraction of it up to the surface when the neighbour is closed */
    /* [capacity] [1/m2] sum over cut bonds of a/t (eq. 2.3), with the curvature of the surface */
    double *wall_laplacian;
    /* [capacity] [-] sum over cut bonds of a (xi.N)^2 (1-t)/2 (eq. 2.4), with the curvature */
    double *wall_curvature;
    /* [capacity][PD_DIM][PD_DIM] [-] correction of bond fluxes of a truncated family (eq. 3.4): the transpose of the
     * correction of g in eq. 2.9, inlets included */
    double *flux_correction;
    pd_node_ranges full_ranges;      /* nodes with full families */
    pd_node_ranges truncated_ranges; /* nodes of plain rows; the rows of a range are consecutive, too */
} pd_bonds;

#define pd_bonds_build PD_NAME(pd_bonds_build)
#define pd_bonds_update PD_NAME(pd_bonds_update)
#define pd_bonds_validate PD_NAME(pd_bonds_validate)
#define pd_bonds_free PD_NAME(pd_bonds_free)

/* Builds the rows of all irregular nodes and the ranges of nodes; `bonds` is overwritten, and all zero after a failure.
 * Grid and stencil are borrowed. options: 0, or a sum of pd_bonds_options. PD_ERR_ARGUMENT: PD_BONDS_LOW_MEMORY without
 * PD_BONDS_NO_FLOW; the grid has fewer ghost layers than the stencil reaches, or other spacings. PD_ERR_GEOMETRY: the
 * axisymmetric weights do not converge. */
PD_API pd_status pd_bonds_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, int options,
                                pd_bonds *bonds);
/* After the solid nodes changed[count] became fluid (pdi_grid_set_fluid): updates ghosts, the rows of these nodes and
 * of fluid nodes within one bond of them or their images, and ranges; version grows by one, and is node_version of
 * these nodes. Rows are sorted anew: the row of any node may change. count 0: ghosts and ranges only. PD_ERR_MEMORY,
 * PD_ERR_LIMIT: rows are partly updated. */
PD_API pd_status pd_bonds_update(pd_ctx *ctx, const int32_t *changed, int32_t count, pd_bonds *bonds);
/* Checks in O(N) that open bonds of rows to fluid nodes are open from both ends, that rows are in order (by node; those
 * with inlets last) and agree with row_of_node, that ranges are in order and hold nodes of their kind, and that rows at
 * inlets plus the lengths of all ranges make up the number of fluid nodes. PD_ERR_INTERNAL: they do not. Changes
 * nothing. */
PD_API pd_status pd_bonds_validate(pd_ctx *ctx, const pd_bonds *bonds);
PD_API void pd_bonds_free(pd_ctx *ctx, pd_bonds *bonds);

#ifdef PDI_INTERNAL
/* Describes the arrays of pd_bonds with one entry a row to the array registry: those that `options` ask for. */
PDI_FN void pdi_bond_list_row_arrays(pdi_array_visitor *owner, void *object);
/* Returns the inverse moment matrix [PD_DIM][PD_DIM] [unit of 1/(base m2)] of row r (eq. 2.9), over open bonds without
 * those to inlets: the stored one, or with PD_BONDS_LOW_MEMORY `buffer` [PD_DIM][PD_DIM], into which it is computed.
 * Zero where the bonds and the closure by the wall (eq. 2.10) do not span space. */
PDI_FN const double *pdi_bond_get_inverse_moment(const pd_bonds *bonds, int32_t r, double *buffer);
/* Laplacian weights a(n) [count] [1/m2] of the bonds of `node`: those of the stencil, or of its row of an
 * axisymmetric grid. */
static inline const double *pdi_bond_get_laplacian_weights(const pd_bonds *bonds, int32_t node)
{
    const pd_axisym *axisym = &bonds->axisym;
    if (!axisym->laplacian_weight) return bonds->stencil->laplacian_weight;
    return axisym->laplacian_weight + (int64_t)(node / bonds->grid->stride[PD_DIM - 1]) * axisym->count;
}
/* Factor [-] on the gradient weight g(n) in the flux along bond k of `node`: 1 on a planar grid, else of pd_axisym. */
static inline double pdi_bond_get_flux_factor(const pd_bonds *bonds, int32_t node, int k)
{
    const pd_axisym *axisym = &bonds->axisym;
    return axisym->flux_factor
               ? axisym->flux_factor[(int64_t)(node / bonds->grid->stride[PD_DIM - 1]) * axisym->count + k]
               : 1.0;
}
/* 1: bond k of a row is open; 0: it is blocked (cut). */
static inline int pdi_bond_is_open(const pd_bonds *bonds, int32_t row, int k)
{
    return (int)(bonds->open_mask[(int64_t)(k >> 5) * bonds->capacity + row] >> (k & 31) & 1u);
}
/* Which of a block of rows have a bond open. */
typedef enum pdi_bond_openness { PDI_BOND_OPEN_NONE, PDI_BOND_OPEN_ALL, PDI_BOND_OPEN_SOME } pdi_bond_openness;
/* Open-bond masks of a block of consecutive rows, for 32 bonds at a time. Initialised with {NULL, 0, 0, 0}. */
typedef struct pdi_bond_mask_block {
    const uint32_t *words; /* mask of each row */
    uint32_t any, all;    /* bonds that are open in at least one row, and in all rows */
    int word_index;       /* bonds 32 word_index .. 32 word_index + 31 */
} pdi_bond_mask_block;
/* Mask words of the 32 bonds that bond k is one of: one word a row, from `row` on, bit k % 32 of each for bond k. */
static inline const uint32_t *pdi_bond_get_mask_words(const pd_bonds *bonds, int32_t row, int k)
{
    return bonds->open_mask + (int64_t)(k >> 5) * bonds->capacity + row;
}
/* Loads the masks of the 32 bonds that bond k is one of, for the rows row .. row+count-1. */
static inline void pdi_bond_update_mask_block(const pd_bonds *bonds, int32_t row, int k, int count,
                                              pdi_bond_mask_block *masks)
{
    masks->words = pdi_bond_get_mask_words(bonds, row, k);
    masks->word_index = k >> 5;
    masks->any = 0;
    masks->all = ~(uint32_t)0;
    for (int b = 0; b < count; b++) {
        masks->any |= masks->words[b];
        masks->all &= masks->words[b];
    }
}
/* 1.0: row b of the block has bond k open, 0.0: it is blocked. */
static inline double pdi_bond_get_open_factor(const pdi_bond_mask_block *masks, int k, int b)
{
    return (double)(int32_t)(masks->words[b] >> (k & 31) & 1u);
}
/* Which of the rows row .. row+count-1 have bond k open: none, all or some. `masks` keeps the words of 32 bonds between
 * calls: use one for one block of rows, initialised with {NULL, 0, 0, 0}. */
static inline pdi_bond_openness pdi_bond_find_rows_open(const pd_bonds *bonds, int32_t row, int k, int count,
                                                        pdi_bond_mask_block *masks)
{
    if (!masks->words || masks->word_index != k >> 5) pdi_bond_update_mask_block(bonds, row, k, count, masks);
    if (masks->all >> (k & 31) & 1u) return PDI_BOND_OPEN_ALL;
    return masks->any >> (k & 31) & 1u ? PDI_BOND_OPEN_SOME : PDI_BOND_OPEN_NONE;
}
/* Which of `count` consecutive nodes have bond k open: none, all or some. They own the rows from `row` on, or have
 * full families (row -1: all open). When some are open, open[count] is 1.0 for those and 0.0 for the others; else it is
 * left alone. */
static inline pdi_bond_openness pdi_bond_find_nodes_open(const pd_bonds *bonds, int32_t row, int k, int count,
                                                         pdi_bond_mask_block *masks, double *open)
{
    pdi_bond_openness which = row < 0 ? PDI_BOND_OPEN_ALL : pdi_bond_find_rows_open(bonds, row, k, count, masks);
    for (int b = 0; b < count && which == PDI_BOND_OPEN_SOME; b++) open[b] = pdi_bond_get_open_factor(masks, k, b);
    return which;
}
/* Terms of a moving wall in the Laplacian of a row (eq. 2.3): sets motion [PD_DIM] [1/(m s)] = sum over its cut bonds
 * of their part of wall_laplacian times the velocity that `wall` returns at the intersection; curved [PD_DIM] [m/s] (or
 * NULL): the same with their part of wall_curvature. Zero without cut bonds. Intersections are computed anew:
 * PD_BONDS_NO_FLOW is allowed. */
PDI_FN void pdi_bond_sum_wall_velocity(const pd_bonds *bonds, int32_t row, pd_velocity_fn wall, void *user,
                                       double *motion, double *curved);
/* Index of the smooth shape (metal or wall) whose zero level is the surface at a closed node; a ghost counts as its
 * source. -1: the surface is that of cell faces, or the node is open. walled 1: the node lies behind a side of the box
 * that is a wall, and the shape is that of the wall. */
PDI_FN int pdi_bond_find_surface_shape(const pd_grid *grid, int32_t closed, int walled);
/* Fraction t >= 1e-3 at which bond k of a node, which has to be cut, intersects the surface; x [PD_DIM]: the point [m].
 * Above 1 where the line grazes a smooth surface and meets it behind the end of the bond. */
PDI_FN double pdi_bond_find_cut_fraction(const pd_bond_paths *paths, int32_t node, int k, double *x);
/* Point x [m] at which cut bond k of a row intersects the surface, and the unit normal towards the fluid. Returns the
 * closed node behind it (may be a ghost); -1: the line only grazes the cells of a smooth surface, x and normal are set
 * all the same, and x may lie behind the end of the bond. */
PDI_FN int32_t pdi_bond_find_surface_point(const pd_bonds *bonds, int32_t row, int k, double *x, double *normal);
/* Signed distance [m] of x from the smooth shape whose surface passes through the cell of node `closed`, positive on
 * the side of the fluid; NaN: the surface there is that of cell faces. */
PDI_FN double pdi_bond_surface_distance(const pd_bonds *bonds, int32_t closed, const double *x);
/* Intersection of a cut bond with the surface. */
typedef struct pdi_bond_wall_end {
    double fraction; /* [-] fraction of the bond */
    /* [m] point on the surface; that of a grazing line may lie far behind the end of the bond */
    double surface_point[PD_DIM];
    double end_point[PD_DIM];   /* [m] the same point, or the far end of the bond when that comes first */
    double wall_lap, wall_curv; /* [1/m2], [-] contributions to wall_lap and wall_curv */
    int32_t closed_cell;        /* first closed cell on the bond */
    int is_box_side;            /* 1: that cell lies behind a side of the box that is a wall */
    int is_smooth;              /* 1: on a smooth shape that is curved or inclined against the lattice there */
    /* 1: the line crosses cells of a smooth surface, but meets that behind its end or nowhere */
    int is_grazing;
} pdi_bond_wall_end;
/* Sets all members of *end: the intersection of cut bond k of a row with the surface, and its contributions to the wall
 * terms (eq. 2.3, 2.4). The row itself does not change. */
PDI_FN void pdi_bond_find_wall_end(const pd_bonds *bonds, int32_t row, int k, pdi_bond_wall_end *end);
#endif

#endif
