/* weakly_compressible: time-dependent weakly compressible flow, explicit.
 *
 * d rho/dt + div(rho v) = fourth-order density diffusion,  rho dv/dt + rho v.grad v = -grad p + mu lap v + rho f,  with
 * an equation of state p(rho), on the sums of flow.h, in time by the three-stage Runge-Kutta method of Shu and Osher
 * 1988 (theory: eq. 3.35 to 3.38). At rest in time it has the steady solution of steady.h up to O(Mach^2).
 */
#ifndef PD_WEAKLY_COMPRESSIBLE_H
#define PD_WEAKLY_COMPRESSIBLE_H
#include "flow/stability.h"
#include "solve/physics.h"

typedef enum pd_eos {
    PD_EOS_TAIT = 0,  /* p = rho0 c0^2/gamma ((rho/rho0)^gamma - 1); Monaghan 1994 */
    PD_EOS_LINEAR = 1 /* p = c0^2 (rho - rho0) */
} pd_eos;

typedef struct pd_weakly_compressible_desc {
    pd_eos eos;
    double sound_speed; /* [m/s] c0, positive; about ten times the largest speed or more */
    double gamma;     /* [-] of Tait; 0: 7 */
    double density_diffusion; /* [-] eta of the density diffusion eta c0 delta; 0: 0.1 */
    double cfl;       /* [-] share of the stability limit; 0: 0.8 */
} pd_weakly_compressible_desc;

typedef struct pd_weakly_compressible {
    pd_weakly_compressible_desc desc; /* defaults filled in */
    pd_flow *flow;         /* its u and p are the state; its tau becomes that of the density diffusion */
    double *density;       /* [total] [-] rho/rho0 */
    double *momentum;      /* [PD_DIM][total] [m/s] rho v/rho0, work */
    double *start_state;   /* [PD_DIM+1][total] [m/s], [-] state at the start of the step: v, then density */
    double *time_derivative; /* [PD_DIM+1][total] [m/s2], [1/s] time derivatives of the stage */
    pd_stability stability;  /* of the linear flow, for the limit */
    /* [-] [s] the last stability limit, and the rounded state that it belongs to */
    double limit_state[PD_DIM + 2], limit;
    double time;           /* [s] */
    int64_t steps;
} pd_weakly_compressible;

#define pd_weakly_compressible_build PD_NAME(pd_weakly_compressible_build)
#define pd_weakly_compressible_limit PD_NAME(pd_weakly_compressible_limit)
#define pd_weakly_compressible_step PD_NAME(pd_weakly_compressible_step)
#define pd_weakly_compressible_process PD_NAME(pd_weakly_compressible_process)
#define pd_weakly_compressible_free PD_NAME(pd_weakly_compressible_free)

/* Starts from the velocity and pressure in flow (borrowed), whose tau becomes that of the density diffusion, and whose
 * friction loses its isotropic weights. PD_ERR_ARGUMENT: sound not positive, gamma below 1, negative
 * diffusion or cfl, one of these not finite, flow of order 4, a pressure of a fluid node without density. After an
 * error unsteady is freed; the changes of tau and friction may be done, and stay. */
PD_API pd_status pd_weakly_compressible_build(pd_ctx *ctx, pd_flow *flow, const pd_weakly_compressible_desc *desc,
                                              pd_weakly_compressible *unsteady);
/* Stability limit [s] of the present state (cfl not applied): sound, stream, viscosity and density diffusion of one
 * wave, the worst; with cut families of the norms of all of them (eq. 3.38). It is that of bounds of the state rounded
 * up to 1/128, and is computed anew only when one of these changes. */
PD_API double pd_weakly_compressible_limit(pd_ctx *ctx, pd_weakly_compressible *unsteady);
/* One step of dt [s]. PD_RETRY, velocity, pressure and density unchanged: a density became non-positive or a value not
 * finite; flow->time and boundary data are those of the stage. PD_ERR_ARGUMENT: dt is not positive and finite; or a
 * boundary value is not finite, then the flow holds the state of a stage. */
PD_API pd_status pd_weakly_compressible_step(pd_ctx *ctx, pd_weakly_compressible *unsteady, double dt);
/* The flow as a process; it prepares the flow. Steps of cfl times the limit; rejected steps are halved. PD_ERR_STATE:
 * 20 halvings did not help. */
PD_API pd_physics pd_weakly_compressible_process(pd_weakly_compressible *unsteady);
PD_API void pd_weakly_compressible_free(pd_ctx *ctx, pd_weakly_compressible *unsteady);

#ifdef PDI_INTERNAL
/* Lists the arrays of a pd_weakly_compressible. */
PDI_FN void pdi_weakly_compressible_list(pdi_array_visitor *owner, void *object);
#endif

#endif
