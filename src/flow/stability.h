/* stability: stability limit of explicit steps of weakly compressible flow. Without surfaces by von Neumann analysis:
 * all plane waves of the linear flow about a uniform stream, from the symbols of gradient and Laplacian, computed once
 * per stencil (theory: eq. 3.38); a step is stable when their eigenvalues, times the step, lie in the region of the
 * three-stage Runge-Kutta method. With cut families norms of the operators bound them (eq. 3.39). */
#ifndef PD_STABILITY_H
#define PD_STABILITY_H
#include "flow/flow.h"

typedef struct pd_stability {
    const pd_stencil *stencil;
    int waves;        /* sampled wave vectors of the first octant */
    int waves_per_axis;       /* wave numbers along an axis */
    double *gradient_symbol;  /* [waves][PD_DIM] [1/m] size of the symbol of the gradient */
    double *laplacian_symbol; /* [waves] [1/m2] symbol of -Laplacian */
    double *diffusion_symbol; /* [waves] [1/m2] symbol of the pressure flux over its weight (eq. 3.7) */
    /* 1: some families are cut by walls, or the lattice is axisymmetric: norms are used */
    int has_cut_families;
    double max_laplacian; /* [1/m2] largest eigenvalue of -Laplacian without walls */
    double wall_increase; /* [1/m2] by which walls raise it at most */
    double gradient_norm; /* [1/m] norm of the gradient; 0: not needed, no cut families */
} pd_stability;

#ifdef PDI_INTERNAL
/* Coefficients of the linearised flow: waves in a stream within a box of velocities. */
typedef struct pdi_stability_state {
    double sound_speed;   /* [m/s] */
    double viscosity;     /* [m2/s] */
    double stabilisation; /* [m2/s] weight of the density diffusion */
    double max_velocity[PD_DIM]; /* [m/s] largest components */
} pdi_stability_state;

/* Allocates and computes the symbols of gradient, Laplacian and density diffusion for all sampled waves, and with cut
 * families or on axisymmetric lattices bounds of the operator norms. Bonds and grid of the flow must not change
 * afterwards. After an error the caller frees. */
PDI_FN pd_status pdi_stability_build(pd_ctx *ctx, const pd_flow *flow, pd_stability *spectrum);
/* Longest stable step [s] of the three-stage Runge-Kutta method for a state: by single waves (eq. 3.38), with cut
 * families or on axisymmetric lattices by operator norms (eq. 3.39). 2 % less, for waves between the sampled ones. */
PDI_FN double pdi_stability_compute_limit(const pd_stability *spectrum, const pdi_stability_state *state);
PDI_FN void pdi_stability_free(pd_ctx *ctx, pd_stability *spectrum);
#endif

#endif
