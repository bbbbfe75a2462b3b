/* read_solid: the section [solid] of a scene, and what holds and loads the metal: keys of sides and of shapes. */
#ifndef PD_READ_SOLID_H
#define PD_READ_SOLID_H
#include "scene/reader.h"

#ifdef PDI_INTERNAL
/* After shapes, sides and metals. */
PDI_FN pd_status pdi_read_solid_read(pdi_reader *s);
/* A shape of kind grip, before [solid] is read. */
PDI_FN pd_status pdi_read_solid_shape(pd_ctx *ctx, pd_text *text, int section, int shape, pd_setup *setup);
/* Metals that share E, a toughness without a crack, metal that locks: notes, when all else is read. */
PDI_FN void pdi_read_solid_notes(pdi_reader *reader);
#endif

#endif
