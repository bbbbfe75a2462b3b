/* read_monitors: reads from a scene what a run shall watch: probes, lines, planes, forces, mass transfer, totals. */
#ifndef PD_READ_MONITORS_H
#define PD_READ_MONITORS_H
#include "scene/text.h"
#include "scene/setup.h"

#ifdef PDI_INTERNAL
/* All of these sections into the setup, whose physics, sides and box are known. PD_ERR_PARSE, PD_ERR_ARGUMENT with
 * file:line. */
PDI_FN pd_status pdi_read_monitors_read(pd_ctx *ctx, pd_text *text, pd_setup *setup);
/* Bits of the list of fields under `key`; what the list names must exist in this scene, the fallback need not. */
PDI_FN pd_status pdi_read_monitors_fields(pd_ctx *ctx, pd_text *text, const pd_setup *setup, int section,
                                          const char *key, const char *fallback, pd_fields *bits);
/* "x 1 mm": an axis and a place [m] inside the box. */
PDI_FN pd_status pdi_read_monitors_place(pd_ctx *ctx, pd_text *text, const pd_setup *setup, int section,
                                         const char *key, int *axis, double *at);
#endif

#endif
