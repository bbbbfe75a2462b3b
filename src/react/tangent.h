/* tangent: derivatives of the balances of a step, and the linear systems that follow (theory: 8.9).
 */
#ifndef PD_TANGENT_H
#define PD_TANGENT_H
#include "react/etch.h"
#include "solve/sdirk.h"

#ifdef PDI_INTERNAL
/* Of loops over its nodes. */
PDI_FN int pdi_tangent_threads(const pd_ctx *ctx, const pd_reactive *reactive);
/* Images of several fields. */
PDI_FN void pdi_tangent_images(const pd_reactive *reactive, double *fields);
/* y [components]: what leaves by the fields, over the weights. With migration `fields` is c or, for the derivative, the
 * change of c beside that of psi; NULL: that of psi alone. */
PDI_FN void pdi_tangent_leave(const pd_ctx *ctx, pd_reactive *reactive, const double *fields, const double *wall,
                              double *y);
/* What passes in the first of two stages is passed so often again before the second one begins (eq. 6.12). */
#define PDI_TANGENT_BEYOND ((1.0 - PDI_SDIRK_GAMMA) / PDI_SDIRK_GAMMA)
/* Node i at the start of a stage, as its minerals see it. */
PDI_FN void pdi_tangent_law(const pd_reactive *reactive, int32_t i, double *n, pd_mineral_start *start);
/* Derivatives at the present concentrations, and the preconditioner that follows from them. */
PDI_FN pd_status pdi_tangent_derive(pd_ctx *ctx, pd_reactive *reactive);
/* taken [minerals]: what they take of a change of totals of a node with the derivatives `by`. */
PDI_FN void pdi_tangent_taken(const pd_reactive *reactive, const float *by, const double *total, double *taken);
/* [mol/m3] of mineral m at node i that the tolerance of the equations leaves open, with totals of this size. */
PDI_FN double pdi_tangent_unsure(const pd_reactive *reactive, int32_t i, int m, const double *size);
/* The correction behind the residual, with these derivatives, to a share of it or to `goal`; *iterations grows by those
 * of GMRES. */
PDI_FN pd_status pdi_tangent_direction(pd_ctx *ctx, pd_reactive *reactive, double share, double goal, int *iterations);
#endif

#endif
