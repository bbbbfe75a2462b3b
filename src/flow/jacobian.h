/* jacobian: the flow equations linearised about the present state, applied in single precision.
 *
 * A Newton step solves for its correction to a few digits, so the products of its Krylov method need no more; what is
 * solved is decided by the residual (flow.h), which stays in double precision. Lengths count in cells and velocities in
 * the reference speed, both rounded to powers of two: units leave no trace in the digits and cannot overflow.
 */
#ifndef PD_JACOBIAN_H
#define PD_JACOBIAN_H
#include "flow/flow.h"

typedef struct pd_jacobian {
    const pd_flow *flow;
    double speed, length; /* [m/s] [m] units of the packed values, powers of two */
    float *bond_weights;  /* [count][2*PD_DIM+2] [-] grad, xi, lap and friction of the bonds */
    float *packed_state;  /* [2*PD_DIM][total] [-] advecting and node velocity of the state */
    /* [3*PD_DIM+1][total] [-] advecting and node velocity, pressure gradient, pressure of step */
    float *packed_increment;
    double *divergence;   /* [total] [1/s] divergence of the advecting velocity of the state */
} pd_jacobian;

#ifdef PDI_INTERNAL
/* A Newton increment (du, dp) with filled ghosts. */
typedef struct pdi_jacobian_increment {
    const double *advecting; /* [PD_DIM][total] [m/s] of du (pdi_flow_compute_advecting_velocity) */
    const double *u;       /* [PD_DIM][total] [m/s] */
    const double *p;       /* [total] [m2/s2] */
    const double *grad;    /* [PD_DIM][total] [m/s2] gradient of p */
} pdi_jacobian_increment;
/* Lists the arrays of a pd_jacobian (`object`) that the build makes. */
PDI_FN void pdi_jacobian_list(pdi_array_visitor *owner, void *object);
/* Lists the single-precision arrays of a pd_jacobian that are lent for a solve. */
PDI_FN void pdi_jacobian_list_work(pdi_array_visitor *owner, void *object);
/* Allocates and packs the bond weights in single precision. Units speed and length: powers of two above the present
 * velocity scale and the longest spacing; they stay when the scale rises. The flow is borrowed; arrays of
 * pdi_jacobian_list_work are not allocated here. After an error nothing is allocated. */
PDI_FN pd_status pdi_jacobian_build(pd_ctx *ctx, const pd_flow *flow, pd_jacobian *jacobian);
PDI_FN void pdi_jacobian_free(pd_ctx *ctx, pd_jacobian *jacobian);
/* Sets the state to linearise about: the one that pdi_flow_update_derived_fields has seen last. Packs its velocities,
 * and updates `divergence` and the friction weights. The work arrays must be lent. */
PDI_FN void pdi_jacobian_set_state(const pd_ctx *ctx, pd_jacobian *jacobian);
/* yu [PD_DIM][total] [m/s2], yc [total] [1/s] at fluid nodes = Jacobian of the bond sums of momentum and continuity
 * (pdi_flow_assemble_bond_sums) times the increment, in single precision: to seven digits of the largest terms. Row
 * corrections of the isotropic weights, fitted walls, fourth order and pseudo time are not in it. Overwrites
 * packed_increment. */
PDI_FN void pdi_jacobian_apply(const pd_ctx *ctx, const pd_jacobian *jacobian, const pdi_jacobian_increment *step,
                               double *yu, double *yc);
#endif

#endif
