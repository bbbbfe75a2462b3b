/* error: how wrong a step of dissolving metal is in time, whether it stands, and how long the next one may be.
 *
 * A step takes the speed at its end. Half of what the speed changes on the way is the error of a step, which goes with
 * the square of its length. It is held against all metal that is lost, and the sum of all steps is, too (theory:
 * 10.11). */
#ifndef PD_ERROR_H
#define PD_ERROR_H
#include "metal/interface.h"

#ifdef PDI_INTERNAL
/* The last step is over: what else moves has changed the law since. What the law changed from the start of that step
 * to its middle, where it was taken, it may change again until its end. */
PDI_FN void pdi_error_judge(pd_dissolve *dissolve);
/* A step begins. `longest` [s]: what else allows. */
PDI_FN void pdi_error_begin(pd_dissolve *dissolve, double longest);
/* The law is that of the middle of the step. */
PDI_FN void pdi_error_middle(pd_dissolve *dissolve);
/* Nodes that are held at a jump begin with the speed that the fluid takes there. Transport has begun a step of dt [s].
 */
PDI_FN pd_status pdi_error_held(pd_ctx *ctx, pd_dissolve *dissolve, double dt);
/* PD_OK: the step of dt [s] stands, and `next_dt` follows from it. PD_RETRY: it is taken again, with `retry_dt`. `lost`
 * [-]: the most that a node loses, of its content. */
PDI_FN pd_status pdi_error_stands(pd_ctx *ctx, pd_dissolve *dissolve, double lost, double dt,
                                  pd_transport_result *result);
/* The step that stands is over; its speeds are settled. */
PDI_FN void pdi_error_end(pd_dissolve *dissolve, double dt);
#endif

#endif
