/* grain: Voronoi grains of a polycrystal and the volume fraction of their boundaries.
 *
 * Grains fill space whether or not a node is solid; they depend on the description alone, not on the grid, so that a
 * finer grid sees the same grains. The boundary is a property of bonds: bonds between grains measure its area
 * (theory: eq. 10.8, with the area weights of eq. 10.5), and its physical width turns area into volume.
 */
#ifndef PD_GRAIN_H
#define PD_GRAIN_H
#include "lattice/grid.h"

typedef struct pd_grain_desc {
    double size;           /* [m] grain diameter d: one grain per pi/4 d^2 (2D), pi/6 d^3 (3D), d (1D) */
    double spread;         /* [m] standard deviation of the equivalent diameter. 0: seeds of a Poisson process, whose
                            * grains spread by 0.71 d, 0.26 d, 0.14 d (1D, 2D, 3D). Else up to 0.44 d, 0.22 d,
                            * 0.13 d: seeds displaced from a cubic lattice that is turned at random. */
    uint64_t seed;         /* of the random numbers */
    double boundary_width; /* [m] w_gb */
    const double *centres; /* [centre_count][PD_DIM] [m] seeds of one's own (size, spread, seed: unread) */
    int32_t centre_count;
} pd_grain_desc;

typedef struct pd_grain {
    int32_t nodes;         /* of the padded lattice */
    int32_t *id;           /* [nodes] index into centre; -1 beyond the reach of the solid */
    int32_t centre_count;
    double *centre;        /* [centre_count][PD_DIM] [m] seeds in and around the solid */
    double boundary_width; /* [m] */
    double bin_lo[PD_DIM], bin_edge; /* [m] */
    int bin_n[PD_DIM];
    int32_t bins, *bin_first; /* [bins+1] seeds of a bin follow one another in centre */
} pd_grain;

typedef struct pd_grain_stats {
    int32_t count;            /* grains that own solid nodes */
    double mean, deviation;   /* [m] equivalent diameter of what the solid holds of each grain */
    double boundary_fraction; /* [-] mean over the solid */
} pd_grain_stats;

#define pd_grain_build PD_NAME(pd_grain_build)
#define pd_grain_free PD_NAME(pd_grain_free)
#define pd_grain_fraction PD_NAME(pd_grain_fraction)

/* Ids of the solid nodes and of all nodes within one stencil reach of them. The same bits for any thread count.
 * PD_ERR_ARGUMENT: a parameter out of range, a size below the spacing. PD_ERR_SIZE: too many grains. */
PD_API pd_status pd_grain_build(pd_ctx *ctx, const pd_grid *grid, const pd_grain_desc *desc, pd_grain *grain);
PD_API void pd_grain_free(pd_ctx *ctx, pd_grain *grain);
/* fraction[grid->total] [-]: share of each solid node's volume that is grain boundary, 0 elsewhere. It does not depend
 * on what has dissolved around the node. Bonds count the boundaries they cross, so that the total converges from
 * coarse grids on (0.5 % at 4 cells a grain). PD_ERR_ARGUMENT: grains of another grid. */
PD_API pd_status pd_grain_fraction(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, const pd_grain *grain,
                                   float *fraction);
#ifdef PDI_INTERNAL
/* Statistics of the solid as it is; fraction from pd_grain_fraction, or NULL (boundary_fraction is then 0). */
PDI_FN pd_status pdi_grain_measure(pd_ctx *ctx, const pd_grid *grid, const pd_grain *grain, const float *fraction,
                                   pd_grain_stats *stats);
#endif

#endif
