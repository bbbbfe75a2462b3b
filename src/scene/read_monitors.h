/* read_monitors: reads the quantities that a run records: sections [probe], [line], [plane], [force], [transfer]
 * (Sherwood number) and [total]. */
#ifndef PD_READ_MONITORS_H
#define PD_READ_MONITORS_H
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Read all of these sections, after physics, sides and box are known. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_monitors_read(pd_ctx *ctx, pd_text *text, pd_setup *setup);
/* Read a list of field names as a set of bits *bits; the word none alone is 0. PD_ERR_ARGUMENT: a name is no field,
 * also in the fallback, or a listed field does not exist in this scene. Fields of the fallback that do not exist are
 * left out, where the key is absent. */
PDI_FN pd_status pdi_read_monitors_fields(pd_ctx *ctx, pd_text *text, const pd_setup *setup, int section,
                                          const char *key, const char *fallback, pd_fields *bits);
/* Read an axis-aligned plane "x 1 mm": *axis, and its coordinate *at [m]. PD_ERR_ARGUMENT: no axis of PD_DIM with a
 * blank behind it, no length, or a place that is not inside the box; its sides are refused. */
PDI_FN pd_status pdi_read_monitors_plane_position(pd_ctx *ctx, pd_text *text, const pd_setup *setup, int section,
                                                  const char *key, int *axis, double *at);
#endif

#endif
