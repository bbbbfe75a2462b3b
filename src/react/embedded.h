/* embedded: the estimate of the error of a step of two stages (theory: eq. 8.8).
 */
#ifndef PD_EMBEDDED_H
#define PD_EMBEDDED_H
#include "react/tangent.h"

#ifdef PDI_INTERNAL
/* What minerals leave open for diffusion in the middle of a step of dt [s]: as it was, or (was = 0) as far as the last
 * one tells. */
PDI_FN void pdi_embedded_open(pd_reactive *reactive, double dt, int was);
/* *error: of a step of dt [s] whose stages are done, over the largest sum of the terms of totals. euler: they are two
 * steps of backward Euler. *krylov grows by the iterations of GMRES. */
PDI_FN pd_status pdi_embedded_error(pd_ctx *ctx, pd_reactive *reactive, double dt, int euler, double *error,
                                    int *krylov);
/* The step stands: the next one is tried for the first time. */
PDI_FN void pdi_embedded_accept(pd_reactive *reactive);
#endif

#endif
