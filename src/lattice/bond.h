/* bond: rows of open bonds for fluid nodes whose family is cut, and runs of nodes whose family is whole.
 *
 * A bond is open when both ends and every cell that its straight line passes are open (fluid, inlet, outlet, image), so
 * a wall one node thick separates its two sides. A cut bond meets the surface at the fraction t of its length: on the
 * zero level of the shape where that is known, else on the face of the closed cell. It acts through its fictitious
 * end value, the extension of the field from the node through the wall value at t (theory: eq. 3.2 to 3.4), which
 * needs three numbers a node (wall_lap, wall_curv, gradient) and no ghost value in the solid.
 */
#ifndef PD_BOND_H
#define PD_BOND_H
#include "core/owner.h"
#include "lattice/span.h"
#include "lattice/ghost.h"
#include "lattice/path.h"
#include "lattice/axisym.h"

/* Velocity [m/s] at position x [m]. */
typedef void (*pd_velocity_fn)(void *user, const double *x, double *u);

/* Nodes that are consecutive along axis 0. */
typedef struct pd_runs {
    int32_t count, capacity;
    int32_t *first, *length; /* [capacity] */
} pd_runs;

/* What rows there are, and what they hold: a sum of these. */
typedef enum pd_bonds_options {
    PD_BONDS_ALL_ROWS = 1, /* every fluid node owns a row (for comparisons of both paths) */
    PD_BONDS_AT_REST = 2,  /* nothing flows: what walls do to a flow is left out */
    PD_BONDS_LEAN = 4      /* with PD_BONDS_AT_REST: moments of rows are found when a gradient is asked for */
} pd_bonds_options;

typedef struct pd_bonds {
    const pd_stencil *stencil;
    const pd_grid *grid;
    pd_ghosts ghosts;    /* of the grid: whoever has bonds can fill the far ends */
    pd_spans spans;      /* of the grid */
    int options;         /* pd_bonds_options */
    pd_paths paths;      /* of the stencil on the grid */
    int32_t *line_shift; /* [lines of the stencil] node id on a line minus that of the node at its middle */
    double norm[PD_DIM]; /* [unit of base m2] sum w xi_a^2 over a whole family */
    pd_axisym axisym;      /* weights of an axisymmetric grid; empty: planar */
    int32_t *row;        /* [total] row of a node; -1: whole family, or not fluid */
    uint32_t version;    /* grows with each update; starts at 1 */
    uint32_t *renewed;   /* [total] version in which the kind of the node or its bonds were renewed; 0: none so far */
    int32_t rows, capacity;
    int32_t plain;       /* rows [0, plain) are in the order of their nodes and see no inlet; the others come behind */
    int32_t *node;       /* [capacity] */
    uint32_t *mask;      /* [words of the paths][capacity] bit k % 32 of word k / 32: bond k is open */
    uint8_t *inlet;      /* [capacity] 1: an open bond ends on an inlet ghost */
    double *moment;      /* [capacity][PD_DIM][PD_DIM] [unit of 1/(base m2)] inverse of sum w xi xi^T over open bonds
                          * (eq. 3.5); NULL: lean */
    /* NULL at rest: */
    uint8_t *smooth;     /* [capacity] 1: a closed bond ends on a shape that is curved or inclined there */
    double *leg;         /* [capacity][2 PD_DIM] [-] spacings to the next cell along an axis, x-, x+, y-, ...: 1, or
                          * when it is closed minus the fraction of it to the surface */
    double *wall_lap;    /* [capacity] [1/m2] sum over cut bonds of a/t (eq. 3.3), and the bend of a curved surface */
    double *wall_curv;   /* [capacity] [-] sum over cut bonds of a (xi.N)^2 (1-t)/2 (eq. 3.4), and that bend */
    double *advecting;   /* [capacity][PD_DIM][PD_DIM] [-] makes the flux through the bonds of a cut family that of a
                          * whole one (eq. 4.2b): the transpose of what eq. 3.5 makes of g, inlets included */
    pd_runs whole;      /* nodes with whole families */
    pd_runs cut;        /* nodes of plain rows; the rows of a run are consecutive, too */
} pd_bonds;

#define pd_bonds_build PD_NAME(pd_bonds_build)
#define pd_bonds_update PD_NAME(pd_bonds_update)
#define pd_bonds_validate PD_NAME(pd_bonds_validate)
#define pd_bonds_free PD_NAME(pd_bonds_free)

/* Grid and stencil are borrowed. options: 0, or a sum of pd_bonds_options. PD_ERR_ARGUMENT: lean,
 * but not at rest. */
PD_API pd_status pd_bonds_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, int options,
                                pd_bonds *bonds);
/* The kinds of `count` nodes have changed: renew the rows within one reach of them, nothing else. */
PD_API pd_status pd_bonds_update(pd_ctx *ctx, const int32_t *changed, int32_t count, pd_bonds *bonds);
/* O(N): openness is mutual, rows stand in order, the runs cover every fluid node once.
 * PD_ERR_INTERNAL otherwise. */
PD_API pd_status pd_bonds_validate(pd_ctx *ctx, const pd_bonds *bonds);
PD_API void pd_bonds_free(pd_ctx *ctx, pd_bonds *bonds);

#ifdef PDI_INTERNAL
/* Arrays of pd_bonds that go by the rows. */
PDI_FN void pdi_bond_row_list(pdi_owner *owner, void *object);
/* moment of row r; of lean bonds into room [PD_DIM][PD_DIM]. */
PDI_FN const double *pdi_bond_moment(const pd_bonds *bonds, int32_t r, double *room);
/* Weights a(n) [count] of the bonds of `node`, and what the flux along bond k of it counts beside g(n). */
static inline const double *pdi_bond_lap(const pd_bonds *bonds, int32_t node)
{
    const pd_axisym *axisym = &bonds->axisym;
    if (!axisym->lap) return bonds->stencil->lap;
    return axisym->lap + (int64_t)(node / bonds->grid->stride[PD_DIM - 1]) * axisym->count;
}
static inline double pdi_bond_flux(const pd_bonds *bonds, int32_t node, int k)
{
    const pd_axisym *axisym = &bonds->axisym;
    return axisym->flux ? axisym->flux[(int64_t)(node / bonds->grid->stride[PD_DIM - 1]) * axisym->count + k] : 1.0;
}
static inline int pdi_bond_open(const pd_bonds *bonds, int32_t row, int k)
{
    return (int)(bonds->mask[(int64_t)(k >> 5) * bonds->capacity + row] >> (k & 31) & 1u);
}
typedef enum pdi_openness {
    PDI_OPEN_NONE,
    PDI_OPEN_ALL,
    PDI_OPEN_SOME
} pdi_openness;
/* Which of a block of rows have their bonds open, 32 bonds at a time. Starts empty: {NULL, 0, 0, 0}. */
typedef struct pdi_bond_gate {
    const uint32_t *word; /* of each row */
    uint32_t any, all;    /* bonds that one of them, that all of them have open */
    int group;            /* the 32 bonds */
} pdi_bond_gate;
static inline const uint32_t *pdi_bond_words(const pd_bonds *bonds, int32_t row, int k)
{
    return bonds->mask + (int64_t)(k >> 5) * bonds->capacity + row;
}
/* The 32 bonds that bond k is one of, for the rows row .. row+count-1. */
static inline void pdi_bond_gate_load(const pd_bonds *bonds, int32_t row, int k, int count, pdi_bond_gate *gate)
{
    gate->word = pdi_bond_words(bonds, row, k);
    gate->group = k >> 5;
    gate->any = 0;
    gate->all = ~(uint32_t)0;
    for (int b = 0; b < count; b++) {
        gate->any |= gate->word[b];
        gate->all &= gate->word[b];
    }
}
/* 1.0: row b of the block has bond k open, 0.0: closed. */
static inline double pdi_bond_gate_value(const pdi_bond_gate *gate, int k, int b)
{
    return (double)(int32_t)(gate->word[b] >> (k & 31) & 1u);
}
/* Which of the rows row .. row+count-1 have bond k open; a gate stays with its rows. */
static inline pdi_openness pdi_bond_gate_of(const pd_bonds *bonds, int32_t row, int k, int count, pdi_bond_gate *gate)
{
    if (!gate->word || gate->group != k >> 5) pdi_bond_gate_load(bonds, row, k, count, gate);
    if (gate->all >> (k & 31) & 1u) return PDI_OPEN_ALL;
    return gate->any >> (k & 31) & 1u ? PDI_OPEN_SOME : PDI_OPEN_NONE;
}
/* As above, of nodes with whole families, too (row -1). SOME: open[b] is 1.0 for those and 0.0 for the others. */
static inline pdi_openness pdi_bond_gate_open(const pd_bonds *bonds, int32_t row, int k, int count,
                                              pdi_bond_gate *gate, double *open)
{
    pdi_openness which = row < 0 ? PDI_OPEN_ALL : pdi_bond_gate_of(bonds, row, k, count, gate);
    for (int b = 0; b < count && which == PDI_OPEN_SOME; b++) open[b] = pdi_bond_gate_value(gate, k, b);
    return which;
}
/* motion = sum over the cut bonds of a row of their part of wall_lap times the wall velocity where they meet the
 * surface (eq. 3.3): what a moving wall adds to the Laplacian [unit of the velocity / m2]. curved: NULL, or
 * the same with their part of wall_curv. */
PDI_FN void pdi_bond_wall_motion(const pd_bonds *bonds, int32_t row, pd_velocity_fn wall, void *user,
                                 double *motion, double *curved);
/* The shape whose zero level is the surface of a closed node; -1: the surface is that of its faces. walled: the node
 * lies behind a side of the box. */
PDI_FN int pdi_bond_shape(const pd_grid *grid, int32_t closed, int walled);
/* Fraction t at which the cut bond k of a node meets the surface, and the place x [m]. */
PDI_FN double pdi_bond_meet(const pd_paths *paths, int32_t node, int k, double *x);
/* The place x [m] where cut bond k of a row meets the surface, and the normal towards the fluid; the closed node behind
 * it, or -1 where the line only grazes the cells of a smooth surface. */
PDI_FN int32_t pdi_bond_surface(const pd_bonds *bonds, int32_t row, int k, double *x, double *normal);
/* Signed distance [m] of x from the smooth surface that node `closed` is a cell of, NaN: there is none. */
PDI_FN double pdi_bond_smooth(const pd_bonds *bonds, int32_t closed, const double *x);
/* Where the cut bond k of a row ends. */
typedef struct pdi_bond_end {
    double t;            /* fraction of the bond */
    double x[PD_DIM];    /* [m] on the surface; a line that grazes it may meet it far behind the bond */
    double at[PD_DIM];   /* [m] the same, no further than the far end */
    double lap, curv;    /* its parts of wall_lap and wall_curv */
    int32_t cell;        /* the first closed cell */
    int side;            /* 1: that cell lies behind a side of the box that is a wall */
    int smooth;          /* 1: on a shape, where the surface is curved or inclined against the lattice */
    int grazes;          /* 1: the line passes cells of a smooth surface, and meets that behind the bond or nowhere */
} pdi_bond_end;
PDI_FN void pdi_bond_find_end(const pd_bonds *bonds, int32_t row, int k, pdi_bond_end *end);
#endif

#endif
