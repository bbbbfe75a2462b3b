/* multigrid: a scalar, cell-centred, geometric V-cycle on the compact face stencil, used as a preconditioner.
 *
 * Operator over the cells of a box (2 PD_DIM + 1 points):
 *   (A x)_c = (mass + wall)_c x_c + sum_f g_f (x_c - x_n) + sum_f ( max(F,0) x_c - max(-F,0) x_n )
 * with g_f >= 0 the diffusive coefficient of face f and F the flow out of c through it, upwind.
 *
 * Coarse cells are the connected parts of the blocks of 2 cells along each coarsened axis: a wall thinner than a block
 * stays a wall, and pockets that do not touch stay apart on all levels down to one cell each. With flow a cell that
 * sweeps solve for takes part in no coarser level: the others see it as held. Coefficients are kept
 * in single precision, scaled by a power of two; each cycle scales its right-hand side, too.
 *
 * Where conductances differ by orders of magnitude, a good conductor has a mean that only the mass and the poor
 * conductor around it hold, and these may be below the rounding of its own links. So with desc.contrast each level
 * keeps the excess of its rows beside the diagonals, applies the operator to coarse corrections by differences, and
 * those are never rounded to single precision.
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
    const double *weight;   /* [n of the last axis] [m] or [-]: factors of the right-hand side, layer by layer, which
                             * the coefficients hold already; NULL: 1. Borrowed */
    int periodic[PD_DIM];   /* 1: the first cells of the axis are neighbours of its last ones */
    int symmetric;          /* 1: flux will always be NULL: symmetric cycle, less memory; 0: smoother for flow */
    int contrast;           /* 1: conductances differ by orders of magnitude from place to place: corrections of coarser
                             * levels are kept in double precision, which costs a fifth to a half more time */
    int guest;              /* 1: with an arena: the memory of x, b and r is pdi_multigrid_fields floats of an array
                             * that is not in use during a setup or a cycle and may hold anything before it */
    struct pd_multigrid *host; /* of the same box: it has x, b and r of the finest level for both, which never cycle at
                             * the same time, and is opened first. Borrowed; NULL: they are its own */
    pd_arena *arena;        /* lends the work of a setup, and for the time of a solve the finest level:
                             * pdi_multigrid_list is no part of the build. Between solves the memory of the coarse
                             * levels is for any multigrid with this arena. Borrowed; NULL: all is its own */
} pd_multigrid_desc;

typedef struct pd_multigrid {
    pd_multigrid_desc desc;
    int levels;     /* 0: not set up */
    int hosts;      /* 1: another one has this one as its host */
    int roomy;      /* 1: it has once taken the room of all cells */
    double scale;   /* [-] power of two: stored coefficient = scale * given one */
    int32_t pad;    /* zero floats before and after each level 0 array read at neighbours */
    float *store;   /* level 0: coefficients with their pads, inv and excess */
    float *fields;  /* level 0: x with its pads, b and r; NULL with a host. With desc.guest the owner sets it */
    double *sums;   /* [-] level 0: sum with its pads; NULL without contrast */
    int32_t *mark;  /* [cells + 3] counts and marks of the setup; NULL between setups with an arena */
    pd_smoother_level level[PD_MULTIGRID_LEVELS];
} pd_multigrid;

#ifdef PDI_INTERNAL
PDI_FN void pdi_multigrid_free(pd_ctx *ctx, pd_multigrid *mg);
/* Take the coefficients and build the coarser levels. All arrays over the box cells, axis 0 fastest:
 * active: 1 for cells that take part; conduct[d][c] >= 0 and flux[d][c] (flux NULL: none): of the face between cell c
 * and c + e_d, flow positive towards +e_d (faces of inactive cells are ignored, and those of the box side unless its
 * axis is periodic: put the net outflow through them into mass); wall[c] >= 0: Dirichlet half-cell conductance;
 * mass[c] >= 0. wall and mass may be NULL.
 * All share one unit. PD_ERR_ARGUMENT: a coefficient is negative or not finite. Memory is kept for the next setup. */
PDI_FN pd_status pdi_multigrid_setup(pd_ctx *ctx, pd_multigrid *mg, const uint8_t *active,
                                     const float *const conduct[PD_DIM], const float *const flux[PD_DIM],
                                     const float *wall, const float *mass);
/* Take other walls and masses; the active cells and their faces stay those of the last setup, which this costs a small
 * part of. desc.symmetric only. The same bits as a setup gives. PD_ERR_ARGUMENT: as of setup, or there was none. */
PDI_FN pd_status pdi_multigrid_mass(pd_ctx *ctx, pd_multigrid *mg, const uint8_t *active, const float *wall,
                                    const float *mass);
/* x = M^-1 rhs, one cycle from zero: a constant linear operator up to single precision rounding, symmetric positive
 * (fit for CG) with desc.symmetric. With GMRES on stiff operators use the flexible form: rounding is not linear.
 * rhs and x, which may be the same, live on the padded lattice; x becomes 0 at inactive cells, nodes outside of the box
 * are neither read nor written. A pocket without mass and wall gets a finite answer for any rhs. Allocates nothing.
 * Before a successful setup it leaves x alone. Sources: Trottenberg, Oosterlee and Schueller 2001 (ch. 2, 5, 7); Braess
 * 1995 (constant transfers with rescaled coarse operators). */
PDI_FN void pdi_multigrid_cycle(pd_ctx *ctx, pd_multigrid *mg, const double *rhs, double *x);

/* Floats of x, b and r of the finest level. */
PDI_FN size_t pdi_multigrid_fields(const pd_multigrid *mg);
/* Arrays of the finest level of a pd_multigrid, those of a setup, and a multigrid without any, which can be counted. */
PDI_FN void pdi_multigrid_list(pdi_owner *owner, void *object);
PDI_FN void pdi_multigrid_mark_list(pdi_owner *owner, void *object);
PDI_FN pd_status pdi_multigrid_plan(pd_ctx *ctx, const pd_multigrid_desc *desc, pd_multigrid *mg);
/* With an arena: the arrays of the finest level have been lent, and will be returned. A setup has to follow. */
PDI_FN void pdi_multigrid_open(pd_multigrid *mg);
PDI_FN void pdi_multigrid_close(pd_multigrid *mg);
#endif

#endif
