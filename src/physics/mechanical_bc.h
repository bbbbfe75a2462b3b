/* mechanical_bc: mechanical boundary conditions of the metal: prescribed displacements of box sides and shapes
 * (Dirichlet), tractions and pressures on box sides (Neumann), body forces. Theory: 14.9. */
#ifndef PD_MECHANICAL_BC_H
#define PD_MECHANICAL_BC_H
#include "couple/solid_coupling.h"
#include "setup/setup.h"

/* The mechanical boundary conditions of a setup, built for its body. */
typedef struct pd_mechanical_bc {
    const pd_setup *setup;
    pd_solid_coupling *structure;
    /* layers of nodes beside a side whose displacement is prescribed: two horizons */
    int held_layers[PD_SETUP_MECHANICAL_BCS];
    double initial_area[PD_SETUP_MECHANICAL_BCS];          /* [m^(d-1)] area of metal on a side at the start */
    double weighted_area[PD_SETUP_MECHANICAL_BCS][PD_DIM]; /* [m^(d-1)] part of that area that the vectors c of (14.5)
                                                            * load, at the start, for each component of a traction */
    /* bit d: the opposite side prescribes displacement component d */
    int opposite_held[PD_SETUP_MECHANICAL_BCS];
    /* capacity of interpolation.row: displacement components that sides prescribe */
    int64_t interpolation_capacity;
    pd_multipoint_constraint interpolation; /* how these depend on the first free layer, as of the last load */
} pd_mechanical_bc;

#ifdef PDI_INTERNAL
/* Build the mechanical boundary conditions of a setup: reset grips, mark prescribed components in
 * structure->prescribed, measure loaded areas, allocate the interpolation rows, and let
 * structure->static_solver.desc.interpolation point into grips, which must not be moved. All else is borrowed.
 * PD_ERR_GEOMETRY: a condition that touches no metal (of a side: no point beside it); metal too thin for it: no free
 * layer behind held ones in statics, or too few for the ordinary material. */
PDI_FN pd_status pdi_mechanical_bc_build(pd_ctx *ctx, const pd_setup *setup, pd_solid_coupling *structure,
                                         pd_mechanical_bc *grips);
/* Free the interpolation rows and set all of grips to 0. */
PDI_FN void pdi_mechanical_bc_free(pd_ctx *ctx, pd_mechanical_bc *grips);
/* Describe the arrays of pd_mechanical_bc, for allocation, freeing and counting. */
PDI_FN void pdi_mechanical_bc_list(pdi_array_visitor *owner, void *grips);
/* Set prescribed displacements u [points][PD_DIM] [m] and add tractions, pressures and body forces to load [N/m3] at
 * time t [s]. A pd_load_fn; user is the pd_mechanical_bc. A side prescribes its face; in statics, points of the layers
 * behind it are interpolated linearly between the face and the first free layer. A traction acts on the area of metal
 * at the start: the force stays as metal dissolves; a body force decreases with the stiffness factor. PD_ERR_STATE: a
 * value is not finite, or too little metal is left under a traction. */
PDI_FN pd_status pdi_mechanical_bc_apply(pd_ctx *ctx, void *user, double t, double *u, double *load);
/* Does boundary condition k, also one of tractions alone, apply to point i? 1: it lies in the held layers of the side
 * and metal without a gap connected it to the side at the start, or it lies in the shape; 0: it does not. Whether the
 * point has dissolved does not count. */
PDI_FN int pdi_mechanical_bc_is_held(const pd_mechanical_bc *grips, int k, int32_t i);
/* The boundary conditions on sides that prescribe displacement component d of point i, at most one for each axis (the
 * last one named). Indices go into holders [PD_DIM]; returns their number, 2 or more at edges and corners. */
PDI_FN int pdi_mechanical_bc_find_sides(const pd_mechanical_bc *grips, int32_t i, int d, int *holders);
/* Number of node layers beside a side that its condition prescribes: two horizons, 2 (ceil(m + 1/2) - 1) for m cells,
 * where families are truncated by the side. */
PDI_FN int pdi_mechanical_bc_count_held_layers(const pd_mechanical_bc *grips);
/* [1/m] The component of the surface vector c of point i (eq. 14.5) along the normal of a side, positive inward. The
 * load of a uniform traction t is t times it. */
PDI_FN double pdi_mechanical_bc_get_surface_coefficient(const pd_mechanical_bc *grips, int32_t i, int side);
/* Add the nodal loads of the traction and pressure of condition k at time t [s] to load [points][PD_DIM] [N/m3], by
 * (14.5). They are scaled so that the total force is that on the initial area. For a nonuniform traction they are
 * corrected so that force and moments are those of the traction. PD_ERR_STATE: a value is not finite, or too little
 * metal is left. */
PDI_FN pd_status pdi_mechanical_bc_add_traction(pd_ctx *ctx, const pd_mechanical_bc *grips, int k, double t,
                                                double *load);
/* Factor [-] on the dissolution rate of stressed metal, an expression of the scene in pressure, von Mises stress,
 * plastic strain, place and time; it is not checked here. A pd_rate_factor_fn; user is the pd_setup. */
PDI_FN double pdi_mechanical_bc_compute_rate_factor(void *user, const pd_local_stress_state *at);
#endif

#endif
