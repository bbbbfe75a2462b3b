/* verlet: elastodynamics of a body of any material by the velocity Verlet scheme.
 *
 * Explicit steps of second order. The longest stable one is that of the material as the motion is built (theory: eq.
 * 14.27 for springs). What loads have done is kept: it is kinetic, is stored in the material, or was lost in it, as to
 * bonds that broke.
 */
#ifndef PD_VERLET_H
#define PD_VERLET_H
#include "solid/material_interface.h"
#include "solve/physics.h"

typedef struct pd_verlet_desc {
    double density;      /* [kg/m3] */
    double step_fraction; /* [-] time step over the longest stable one; 0: 0.8 */
    const double *load;  /* [count][PD_DIM] [N/m3]; NULL: none. Borrowed, may change between steps */
    const uint8_t *prescribed; /* [count][PD_DIM] 1: this velocity is prescribed; NULL: none. Borrowed */
} pd_verlet_desc;

typedef struct pd_verlet {
    pd_verlet_desc desc;
    pd_material_interface solid;
    double *u;        /* [count][PD_DIM] [m] displacements */
    double *v;        /* [count][PD_DIM] [m/s] velocities */
    double *force;    /* [count][PD_DIM] [N/m3] of bonds, at the end of the last step */
    double time;      /* [s] */
    double max_step;  /* [s] stable step times share */
    double work;      /* [J] (per m in 2D, per m2 in 1D) external work: of loads and of prescribed velocities */
    int64_t steps, broken;
} pd_verlet;

#define pd_verlet_build PD_NAME(pd_verlet_build)
#define pd_verlet_process PD_NAME(pd_verlet_process)
#define pd_verlet_kinetic PD_NAME(pd_verlet_kinetic)
#define pd_verlet_free PD_NAME(pd_verlet_free)

/* At rest at time 0; u and v may be set before the first step. The material is borrowed, its table copied; max_step is
 * that of its bonds now. After an error the object is empty. PD_ERR_ARGUMENT: a density not positive and finite, a
 * step_fraction not in [0, 1] (0: 0.8). */
PD_API pd_status pd_verlet_build(pd_ctx *ctx, const pd_material_interface *solid, const pd_verlet_desc *desc,
                                 pd_verlet *verlet);
/* Its steps as a process, for pd_physics_run; the first one computes the forces at its start. Bonds may break in a step
 * where the material has dynamic_force. PD_ERR_STATE: a displacement is not below 1e6 horizons or not finite, or they
 * are no state of the material; u, v and work are then those of the failed step. */
PD_API pd_physics pd_verlet_process(pd_verlet *verlet);
/* Kinetic energy [J] (per m in 2D, per m2 in 1D): sum of density V v^2/2 over all points, mirror images and prescribed
 * velocities too. */
PD_API double pd_verlet_kinetic(const pd_verlet *verlet);
PD_API void pd_verlet_free(pd_ctx *ctx, pd_verlet *verlet);

#ifdef PDI_INTERNAL
/* Describes the arrays and values of state. */
PDI_FN void pdi_verlet_list(pdi_array_visitor *owner, void *verlet);
#endif

#endif
