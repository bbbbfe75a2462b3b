/* multigrid: preconditioner: a scalar, cell-centred, geometric multigrid V-cycle on the compact (2 PD_DIM + 1 point)
 * operator.
 *
 * Operator over the cells of a box (2 PD_DIM + 1 points):
 *   (A x)_c = (mass + wall)_c x_c + sum_f g_f (x_c - x_n) + sum_f ( max(F,0) x_c - max(-F,0) x_n )
 * with g_f >= 0 the diffusive coefficient of face f and F the flow out of c through it, upwind.
 *
 * Coarse cells are the connected parts of the blocks of 2 cells along each coarsened axis: a wall thinner than a block
 * remains a wall, and disconnected regions stay disconnected on all levels, down to one cell each. With flow, a cell
 * for which sweeps alone solve is excluded from coarser levels and acts as a Dirichlet value there. Coefficients are
 * stored in single precision, scaled by a power of two; each cycle scales its right-hand side, too.
 *
 * Where conductances differ by orders of magnitude, the mean of a good conductor is determined by its mass and by the
 * poor conductor around it alone, which may be below the rounding of its own links. So with desc.contrast each level
 * stores the row sums beside the diagonals, applies the operator to coarse corrections by differences, and keeps these
 * in double precision.
 */
#ifndef PD_MULTIGRID_H
#define PD_MULTIGRID_H
#include "core/arena.h"
#include "solve/smoother.h"

#define PD_MULTIGRID_LEVELS 40 /* most levels */

typedef struct pd_multigrid_desc {
    int n[PD_DIM];          /* cells of the box, axis 0 fastest */
    int32_t stride[PD_DIM]; /* of the padded lattice on which rhs and x live */
    int32_t first;          /* node of cell 0 on that lattice */
    const double *rhs_weight; /* [n of the last axis] [m] or [-]: factors of the right-hand side, such as the
                               * circumference, which the coefficients contain already; NULL: 1. Borrowed */
    int periodic[PD_DIM];   /* 1: the axis is periodic */
    int symmetric;          /* 1: no flow: symmetric cycle, less memory; 0: line smoother for flow */
    int high_contrast;      /* 1: conductances differ by orders of magnitude in space: corrections of coarser levels are
                             * in double precision, which costs a fifth to a half more time */
    int caller_fields; /* 1: with an arena: the caller provides the memory of x, b and r, pdi_multigrid_field_floats
                        * floats that are unused during a setup or a cycle; their content does not matter */
    struct pd_multigrid *host; /* another multigrid of the same box, whose x, b and r of the finest level this one
                             * shares; they never cycle at the same time, and the host is opened first. Borrowed;
                             * NULL: own arrays */
    pd_arena *arena;        /* lends the work array of a setup and, during a solve, the arrays of the finest level
                             * (pdi_multigrid_list), which are then not allocated. Between solves the memory of the
                             * coarse levels goes to any multigrid with this arena. Borrowed; NULL: own memory */
} pd_multigrid_desc;

typedef struct pd_multigrid {
    pd_multigrid_desc desc;
    int levels;     /* number of levels; 0: not set up */
    int is_host;    /* 1: it is the host of another one */
    int has_full_capacity; /* 1: memory has once been allocated for coarse levels of all cells */
    double scale;   /* [-] power of two: stored coefficient = scale * given coefficient */
    int32_t pad;    /* zero floats before and after each level 0 array read at neighbours */
    float *coefficients; /* level 0: coefficients with their pads, inv and excess */
    float *fields;  /* level 0: x with its pads, b and r; NULL with a host. With caller_fields the caller sets it */
    double *sums;   /* [-] level 0: sum with its pads; NULL without contrast */
    int32_t *setup_work; /* [cells + 3] work array of the setup; NULL between setups with an arena */
    pd_smoother_level level[PD_MULTIGRID_LEVELS];
} pd_multigrid;

#ifdef PDI_INTERNAL
/* Free all arrays, take the multigrid off the stack of unused ones of its arena, and set it to zero. */
PDI_FN void pdi_multigrid_free(pd_ctx *ctx, pd_multigrid *mg);
/* Set the coefficients, all in one unit over the box cells, axis 0 fastest, and build the coarser levels. active: 1 in
 * the domain; conduct[d][c] >= 0, flux[d][c] (flux NULL: none): of the face between c and c + e_d, flow positive
 * towards +e_d (inactive cells are ignored, and the box side unless its axis is periodic: put the net outflow through
 * it into mass); wall[c] >= 0: Dirichlet half-cell conductance; mass[c] >= 0; both may be NULL. PD_ERR_ARGUMENT: one is
 * negative or not finite, flux with desc.symmetric. After an error cycles do nothing. Memory is kept. */
PDI_FN pd_status pdi_multigrid_setup(pd_ctx *ctx, pd_multigrid *mg, const uint8_t *active,
                                     const float *const conduct[PD_DIM], const float *const flux[PD_DIM],
                                     const float *wall, const float *mass);
/* Change walls and masses only; active cells and faces are those of the last setup. Much cheaper than a setup, and
 * bitwise equal to it. PD_ERR_ARGUMENT: without desc.symmetric or a successful setup, or a coefficient is negative or
 * not finite; the last setup then stays in force. */
PDI_FN pd_status pdi_multigrid_update_mass(pd_ctx *ctx, pd_multigrid *mg, const uint8_t *active, const float *wall,
                                           const float *mass);
/* Apply the preconditioner: x = M^-1 rhs by one V-cycle from zero: a constant linear operator up to single precision
 * rounding, symmetric positive (fit for CG) with desc.symmetric. With GMRES on stiff operators use the flexible form:
 * rounding is not linear. rhs and x, which may be the same, live on the padded lattice; x becomes 0 at inactive cells,
 * nodes outside of the box are neither read nor written. A connected region without mass and wall (pure Neumann) gets a
 * finite result for any rhs. Allocates nothing. Before a successful setup it leaves x alone. Sources: Trottenberg,
 * Oosterlee and Schueller 2001 (ch. 2, 5, 7); Braess 1995 (constant transfers with rescaled coarse operators). */
PDI_FN void pdi_multigrid_cycle(pd_ctx *ctx, pd_multigrid *mg, const double *rhs, double *x);

/* Number of floats of x with its pads, b and r of the finest level. */
PDI_FN size_t pdi_multigrid_field_floats(const pd_multigrid *mg);
/* List functions: the arrays of the finest level (x, b and r only without host and caller_fields), and the work array
 * of a setup. By the sizes that pdi_multigrid_init sets. */
PDI_FN void pdi_multigrid_list(pdi_array_visitor *owner, void *object);
PDI_FN void pdi_multigrid_setup_list(pdi_array_visitor *owner, void *object);
/* Copy the desc and set the sizes of level 0, all else to zero, without any array; marks desc->host as a host.
 * PD_ERR_ARGUMENT: a size or stride is below 1, or `first` is negative. PD_ERR_SIZE: more than INT32_MAX / (2 PD_DIM)
 * cells. Axes too short to be periodic (pdi_coarsen_is_periodic) are not. */
PDI_FN pd_status pdi_multigrid_init(pd_ctx *ctx, const pd_multigrid_desc *desc, pd_multigrid *mg);
/* Set the pointers into the arrays of the finest level once these are allocated or lent; a setup has to follow. Takes
 * the memory of coarse levels from the multigrid of the arena that was used last, where this one has none. Clear them
 * before an arena takes the arrays back: the multigrid is then not set up, and offers its coarse levels to others. */
PDI_FN void pdi_multigrid_set_pointers(pd_multigrid *mg);
PDI_FN void pdi_multigrid_clear_pointers(pd_multigrid *mg);
#endif

#endif
