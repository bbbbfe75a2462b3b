/* memory_plan: the sizes of a run that is not built, and the memory of objects of such sizes, as the lists of their
 * arrays give it.
 */
#ifndef PD_MEMORY_PLAN_H
#define PD_MEMORY_PLAN_H
#include "flow/steady.h"
#include "setup/setup.h"

/* Relative error that the estimate may have. */
#define PD_MEMORY_ESTIMATE_ERROR 0.2

/* Numbers of nodes, and the estimated memory. */
typedef struct pd_memory_estimate {
    double nodes;                   /* [-] of the padded lattice */
    double cells;                   /* [-] of the box */
    double fluid, solid, truncated; /* [-] nodes; cut: fluid ones with a truncated family */
    double near_medium;             /* [-] nodes within one bond of the surface of a medium */
    double bonds;                   /* [-] bonds of a complete family */
    double bytes[PD_PART_COUNT];    /* [byte] */
    double runtime_bytes;           /* [byte] multigrid levels and Krylov vectors, allocated during the run */
    double output_bytes;            /* [byte] copies of fields for files, and the largest picture */
    /* [byte] work of the mechanical equilibrium solver; not at the same time as files */
    double equilibrium_bytes;
    double total_bytes; /* [byte] total */
} pd_memory_estimate;

#ifdef PDI_INTERNAL
/* Objects of a run that are not built: only the sizes that their array lists read are set. */
typedef struct pdi_memory_plan {
    pd_ctx ctx;
    pd_stencil stencil, across;
    pd_grid grid;
    pd_bonds bonds;
    pd_flow flow;
    double scratch_bytes, level_bytes; /* [byte] shared by solvers: scratch memory, and coarse levels of multigrids */
    double node_scale;                 /* [-] nodes of the run over nodes of the planned grid */
} pdi_memory_plan;

/* Bonds of a complete family with horizon m cells: offsets with 0 < |n| < m + 1/2. */
PDI_FN double pdi_memory_plan_count_bonds(double m);
/* Set the sizes of grid, stencils, bonds and flow in the plan; its other members become 0. b holds the numbers of
 * nodes. Above 1e8 nodes the grid gets fewer layers, and node_scale is the ratio of nodes, by which all sizes are
 * multiplied. */
PDI_FN void pdi_memory_plan_init(const pd_setup *setup, const pd_memory_estimate *b, pdi_memory_plan *plan);
/* [byte] Memory of the arrays that `list` describes for a planned object, times node_scale. */
PDI_FN double pdi_memory_plan_count_array_bytes(const pdi_memory_plan *plan, pdi_array_list_fn list, void *object);
/* [byte] Memory of the coarser levels of a multigrid, a geometric series over the finest one. */
PDI_FN double pdi_memory_plan_count_level_bytes(const pdi_memory_plan *plan, const pd_multigrid *mg);
/* Add to b->runtime_bytes what the memory `levels` [byte] of multigrid levels exceeds plan->level_bytes, which becomes
 * the larger of both: solvers that are not used at the same time share them. */
PDI_FN void pdi_memory_plan_add_shared_levels(pdi_memory_plan *plan, double levels, pd_memory_estimate *b);
/* [byte] Growth of the shared scratch memory for a solver that needs `room` bytes of the planned grid, 0 if there is
 * enough; plan->scratch_bytes becomes the largest so far. */
PDI_FN double pdi_memory_plan_add_scratch(pdi_memory_plan *plan, size_t room);
/* [byte] Memory of a Krylov solver. */
PDI_FN double pdi_memory_plan_count_krylov_bytes(pdi_memory_plan *plan, const pd_krylov_desc *desc);
/* Placeholder for functions of a scene, which are not called; it returns x[0]. */
PDI_FN double pdi_memory_plan_get_placeholder(void *user, const double *x);
#endif

#endif
