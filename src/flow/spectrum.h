/* spectrum: how long explicit steps of a flow with sound may be.
 *
 * On a lattice without surfaces the waves of the linear flow about a uniform stream are known: eigenvalues from the
 * symbols of gradient and Laplacian, computed once per stencil (theory: eq. 4.14). A step is stable when all of them,
 * times the step, lie in the region of the three-stage method. With cut families the norms of the operators take their
 * place (eq. 4.14b).
 */
#ifndef PD_SPECTRUM_H
#define PD_SPECTRUM_H
#include "flow/flow.h"

typedef struct pd_spectrum {
    const pd_stencil *stencil;
    int waves;        /* of the first octant, `along` an axis */
    int along;
    double *slope;    /* [waves][PD_DIM] [1/m] size of the symbol of the gradient */
    double *spread;   /* [waves] [1/m2] that of the Laplacian */
    double *stabilisation; /* [waves] [1/m2] that of the pressure flux over its weight (eq. 4.4) */
    int cut;          /* 1: some families are not whole, or rings */
    double laplacian; /* [1/m2] largest eigenvalue, no walls */
    double wall;      /* [1/m2] by which walls add to it at most */
    double gradient;  /* [1/m] norm; 0 where nothing is cut */
} pd_spectrum;

#ifdef PDI_INTERNAL
/* Coefficients of the linearised flow: waves in a stream within a box of velocities. */
typedef struct pdi_spectrum_state {
    double sound;         /* [m/s] */
    double viscosity;     /* [m2/s] */
    double stabilisation; /* [m2/s] weight of the density diffusion */
    double speed[PD_DIM]; /* [m/s] largest components */
} pdi_spectrum_state;

/* Symbols of gradient, Laplacian and density diffusion for all sampled waves, and with cut families the operator norms.
 * Bonds and grid of the flow must not change afterwards. */
PDI_FN pd_status pdi_spectrum_build(pd_ctx *ctx, const pd_flow *flow, pd_spectrum *spectrum);
/* Longest stable step [s] of the three-stage Runge-Kutta method for a state (eq. 4.14, 4.14b). */
PDI_FN double pdi_spectrum_limit(const pd_spectrum *spectrum, const pdi_spectrum_state *state);
PDI_FN void pdi_spectrum_free(pd_ctx *ctx, pd_spectrum *spectrum);
#endif

#endif
