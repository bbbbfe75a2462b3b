/* grid: the uniform lattice of nodes (cell centres) with ghost layers, the kind of every node (fluid, solid, wall,
 * ghost), and the shapes that it was made from.
 *
 * Nodes are cell centres: x_a = lo_a + (i_a + 1/2) h_a, axis 0 fastest in memory. Ghost layers, as deep as the
 * longest stencil reaches, lie on every side, so that a bond of a fluid node never leaves the arrays.
 */
#ifndef PD_GRID_H
#define PD_GRID_H
#include "core/base.h"
#include "lattice/shape.h"
#include "lattice/stencil.h"

typedef enum pd_kind {
    PD_INACTIVE = 0, /* beyond the reach of all fluid: takes no part */
    PD_FLUID = 1,
    PD_SOLID = 2, /* metal that can dissolve */
    PD_WALL = 3,
    PD_INLET = 4,  /* ghost with prescribed velocity and concentration */
    PD_OUTLET = 5, /* ghost behind a pressure outlet */
    PD_IMAGE = 6   /* ghost behind a periodic or mirror side: copy of a fluid node */
} pd_kind;

/* Boundary condition of a side of the box. */
typedef enum pd_side {
    PD_SIDE_WALL = 0,     /* no slip, no flux */
    PD_SIDE_INLET = 1,    /* Dirichlet: velocity and concentration */
    PD_SIDE_OUTLET = 2,   /* Dirichlet for the pressure; species leave by advection */
    PD_SIDE_PERIODIC = 3, /* both sides of the axis */
    PD_SIDE_MIRROR = 4    /* plane of symmetry: free slip, no flux */
} pd_side;

/* 1: fluid enters the box at the point x [m] of a side (inlet), 0: it leaves there (outlet). */
typedef int (*pd_is_inlet_fn)(void *user, int side, const double *x);

typedef struct pd_grid_desc {
    double lo[PD_DIM], hi[PD_DIM]; /* [m] box; each edge a whole number of cells (1e-6 of a cell) */
    pd_side side[2 * PD_DIM];      /* x-, x+, y-, ... */
    const pd_shape *shapes;        /* array, borrowed for the life of the grid; NULL: none */
    const pd_shape *solid;         /* the one of them that is metal; NULL: none */
    const pd_shape *wall;          /* the one of them that is wall, also where metal is; NULL: none */
    int ghost;                     /* minimum number of ghost layers; 0: as deep as the stencil reaches */
    pd_is_inlet_fn is_inlet;       /* for sides that are inlet or outlet: which of both a point is; NULL: as `side`
                                    * says */
    void *is_inlet_user;
    int axisymmetric;              /* 2D: axis 0 is z, axis 1 is r >= 0, and nodes are rings. A box that begins at r = 0
                                    * has a mirror there; else it begins at least one horizon away from the axis */
} pd_grid_desc;

typedef struct pd_grid {
    int n[PD_DIM];        /* cells of the box */
    int padded[PD_DIM];   /* cells with ghosts */
    int ghost;            /* layers on every side */
    int32_t stride[PD_DIM]; /* difference of node ids of neighbours along an axis */
    int32_t total;        /* nodes with ghosts */
    double h[PD_DIM], lo[PD_DIM], hi[PD_DIM]; /* [m] */
    pd_side side[2 * PD_DIM];
    const pd_shape *shapes;
    int solid, wall;      /* indices of the shapes of metal and wall, -1: none */
    pd_is_inlet_fn is_inlet;
    void *is_inlet_user;
    uint8_t mixed_sides;   /* bit s: side s is an inlet at some points and an outlet at others */
    double *circumference; /* [padded of the last axis] [m] 2 pi |r| of axisymmetric rows of nodes; NULL: planar */
    uint8_t *kind;        /* [total] pd_kind */
    /* [total] source node of each node (pd_grid_find_source); NULL: no images, or no metal */
    int32_t *source_node;
    int64_t fluid_count, solid_count;
    int64_t nodes_on_surface[2]; /* nodes exactly on the surface of metal, and of walls, when the grid was built */
} pd_grid;

#define pd_grid_build PD_NAME(pd_grid_build)
#define pd_grid_free PD_NAME(pd_grid_free)
#define pd_grid_position PD_NAME(pd_grid_position)
#define pd_grid_node PD_NAME(pd_grid_node)
#define pd_grid_index PD_NAME(pd_grid_index)
#define pd_grid_is_between PD_NAME(pd_grid_is_between)
#define pd_grid_is_inside PD_NAME(pd_grid_is_inside)
#define pd_grid_find_source PD_NAME(pd_grid_find_source)

/* Builds the lattice; kinds by the shapes: wall before solid. *grid is all zero after a failure. PD_ERR_GEOMETRY: the
 * box is no whole number of cells; the solid reaches beyond a wall, inlet or outlet, or covers no node; walls cover all
 * nodes; an axisymmetric box begins neither at the axis nor a horizon away. PD_ERR_ARGUMENT: a side is of no type; an
 * axis periodic on one side only; axisymmetric outside 2D, or with sides across r other than axis, wall, inlet, outlet;
 * a solid or wall without shapes. PD_ERR_SIZE: nodes times PD_DIM exceed int32. PD_CANCELLED. */
PD_API pd_status pd_grid_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid_desc *desc, pd_grid *grid);
PD_API void pd_grid_free(pd_ctx *ctx, pd_grid *grid);
/* Position [m] of node id (ghosts included). */
PD_API void pd_grid_position(const pd_grid *grid, int32_t node, double *x);
/* Node of cell index i[] of the box (ghosts: -ghost .. n+ghost-1). */
PD_API int32_t pd_grid_node(const pd_grid *grid, const int *i);
/* Cell index i[] of a node (negative or >= n in ghosts). */
PD_API void pd_grid_index(const pd_grid *grid, int32_t node, int *i);
/* 1: the cell index i[] lies inside the box, 0 <= i[d] < n[d] on all axes; 0: in ghost layers or beyond. */
PD_API int pd_grid_is_inside(const pd_grid *grid, const int *i);
/* Node of the box that a ghost stands for: shifted by periods behind periodic sides, the mirror image behind all
 * others; the node itself inside the box. *flip (or NULL): bit d set when it is mirrored along axis d. */
PD_API int32_t pd_grid_find_source(const pd_grid *grid, int32_t node, int *flip);
/* Factor of the cell volume in sums over volume: the circumference of the ring of a node on an axisymmetric grid [m],
 * else 1. */
static inline double pd_grid_circumference(const pd_grid *grid, int32_t node)
{
    return PD_DIM == 2 && grid->circumference ? grid->circumference[node / grid->stride[PD_DIM - 1]] : 1.0;
}
/* 1: the point x [m] lies in the box lo .. hi [m] or within 1e-6 spacings of it, as surfaces and nodes often lie on its
 * faces. NaN: 0. */
PD_API int pd_grid_is_between(const pd_grid *grid, const double *lo, const double *hi, const double *x);
/* 1: fluid passes the side (inlet or outlet). */
static inline int pd_grid_is_inlet_or_outlet(pd_side side) { return side == PD_SIDE_INLET || side == PD_SIDE_OUTLET; }
#ifdef PDI_INTERNAL
/* 1: the grid has a shape of metal, and a periodic or mirror side behind which it has images. */
PDI_FN int pdi_grid_has_images(const pd_grid *grid);
/* Number of nodes of one kind, ghosts included. */
PDI_FN int64_t pdi_grid_count_kind(const pd_grid *grid, pd_kind kind);

/* Length of a vector of the inner loops: shorter pieces of grid lines are not worth one. */
#define PDI_VECTOR_LENGTH 8
/* Cell index of a node along one axis. */
static inline int pdi_grid_index_along(const pd_grid *grid, int32_t node, int axis)
{
    return (int)(node / grid->stride[axis] % grid->padded[axis]) - grid->ghost;
}
/* Length of the text of a position. */
#define PDI_GRID_POSITION_LENGTH 80
/* Formats the position of a node as "(x, y, z)" in metres for messages: into text [PDI_GRID_POSITION_LENGTH], which is
 * returned. */
PDI_FN const char *pdi_grid_format_position(const pd_grid *grid, int32_t node, char *text);
/* 1: the node is a ghost beyond a side of the box that is a wall, along at least one axis; 0 for nodes of the box. */
PDI_FN int pdi_grid_is_behind_wall(const pd_grid *grid, int32_t node);
/* Number of nodes of a cube with `reach` cells on either side of its centre. */
static inline int pdi_grid_count_cube(int reach)
{
    int count = 1;
    for (int d = 0; d < PD_DIM; d++) count *= 2 * reach + 1;
    return count;
}
/* Node k of the pdi_grid_count_cube(reach) nodes of the cube with `reach` cells on either side of `node`, which is one
 * of them; -1: it lies outside of the box. *far, always set: its largest distance from `node` along an axis [cells]. */
PDI_FN int32_t pdi_grid_find_cube_node(const pd_grid *grid, int32_t node, int reach, int k, int *far);
/* Circumference [m] of a ring whose radius is |radius of the node plus `offset` [m]|; 1 on a planar grid. */
PDI_FN double pdi_grid_circumference_at(const pd_grid *grid, int32_t node, double offset);
/* Sum of field [total] over the nodes of a kind, times their circumferences [m] on an axisymmetric grid, without the
 * cell volume; which [total] not NULL: only over those with which[node] == wanted. Rounding is that of a few terms; the
 * same bits for any number of threads. */
PDI_FN double pdi_grid_sum_field(const pd_ctx *ctx, const pd_grid *grid, uint8_t kind, const uint8_t *which, int wanted,
                                 const double *field);
/* Maps a cell index i[] back into the box through periodic and mirror sides only; along other axes it stays. Returns
 * the bits 1 << d of the axes along which it is mirrored an odd number of times. */
PDI_FN int pdi_grid_fold_index(const pd_grid *grid, int *i);
/* Maps a position x [m] into the box through all sides but walls: periodic ones by shifts, others (inlets and outlets,
 * too: the geometry is continued) by mirroring, repeatedly for points farther than a box away, but once where the other
 * side of the axis is a wall. Behind walls x stays. */
PDI_FN void pdi_grid_fold_position(const pd_grid *grid, double *x);
/* Signed distance [m] of x [m] from a shape of the grid, continued behind all sides but walls: where the shape meets
 * such a side there is no surface, unless it ends there on a periodic side. Exact near the surface; elsewhere a bound
 * of the right sign. */
PDI_FN double pdi_grid_signed_distance(const pd_grid *grid, int shape, const double *x);
/* First point at which the line x + t xi, 0 <= t, beginning outside, enters a shape of the grid: the smallest t, at
 * most `limit`; HUGE_VAL: none. A part of the line between two surfaces is inside when its midpoint is in or on the
 * shape; parts shorter than 1e-6 of a cell do not count. So faces shared by two bodies of a union are not entries. Not
 * for voxel masks. */
PDI_FN double pdi_grid_find_shape_entry(const pd_grid *grid, int shape, const double *x, const double *xi,
                                        double limit);
/* Maps a position x [m] into the box through periodic and mirror sides only; points on them within the surface
 * tolerance, and behind walls, inlets and outlets, stay. Returns the bits (1 << d) of the axes along which it is
 * mirrored an odd number of times. */
PDI_FN int pdi_grid_fold_position_images(const pd_grid *grid, double *x);
/* Converts a solid node of the box to fluid: its kind, fluid_count and solid_count, and the kinds of the ghosts whose
 * source it is. The kind before is not tested. Bonds and ghost lists are not updated (pd_bonds_update). */
PDI_FN void pdi_grid_set_fluid(pd_grid *grid, int32_t node);
/* shift [lines of the stencil] = node id on a grid line of the family (at n_0 = 0) minus that of the node at its
 * middle. */
PDI_FN void pdi_grid_compute_line_shifts(const pd_grid *grid, const pd_stencil *stencil, int32_t *shift);
/* 1: nodes of this kind take part in fluxes (fluid, inlet, outlet, image), so bonds between them are not blocked. */
static inline int pdi_grid_is_open(uint8_t kind) { return kind == PD_FLUID || kind >= PD_INLET; }
#endif

#endif
