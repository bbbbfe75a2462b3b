/* migrate: what bonds carry of several charged fields by diffusion, by a flow and by an electric field, fitted by
 * exponentials (theory: eq. 8.4).
 *
 * A bond carries what leaves one of its ends and enters the other, bit for bit. It takes from each end a share that is
 * not negative: matrices are M-matrices for any potential, and steps of any length keep concentrations positive.
 */
#ifndef PD_MIGRATE_H
#define PD_MIGRATE_H
#include "transport/flux.h"

#ifdef PDI_INTERNAL
typedef struct pdi_migrate {
    const pd_flux *flux;  /* conductances and volume fluxes */
    int count, sums;
    const double *ratio;  /* [count] [-] of the diffusivities to that of the flux */
    const double *charge; /* [count] [-] */
    const double *wall;   /* [count] [mol/m3] what each holds on walls that hold; NaN: they are closed for it */
    const double *pass;   /* [total] [-] as of pdi_flux_fields */
    const double *c;      /* [count][total] [mol/m3] with images and inlets */
    const double *psi;    /* [total] [-] F phi/(R T), with images; 0 at inlets and on walls that hold */
    const double *weight; /* [sums][count] [-] */
    double *y;            /* [sums][total] [mol/m3/s] */
    const double *lift;   /* change of psi, with images: y is the derivative along it and `move`; or NULL */
    const double *move;   /* change of c, with images; NULL: none */
} pdi_migrate;
/* y: the sums of what leaves each fluid node through its bonds and into held walls. */
PDI_FN void pdi_migrate_apply(const pd_ctx *ctx, const pdi_migrate *m);
/* What leaves [mol/m3/s] through a bond of the conductance `bond` and the volume flux `flux` [1/s]. `rise` [-]: the
 * energy z psi of the far end above that of the near one. */
PDI_FN double pdi_migrate_leave(double bond, double flux, double rise, double near, double far);
/* What such a bond conducts, over the bond: what leaves falls with `rise` at this rate [mol/m3]. */
PDI_FN double pdi_migrate_conduct(double rise, double near, double far);
#endif

#endif
