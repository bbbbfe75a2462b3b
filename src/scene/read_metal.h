/* read_metal: reads the sections [dissolve] and [corrode] of a scene: how metal goes.
 *
 * [dissolve NAME] and [corrode NAME] hold Cs, charge, law and reaction of one of several metals, whose shapes have
 * material = NAME. Metals without such a section follow the section without a name, which holds all else.
 */
#ifndef PD_READ_METAL_H
#define PD_READ_METAL_H
#include "scene/reader.h"

#ifdef PDI_INTERNAL
/* 1: there is a section of that name, with or without the name of a metal. */
PDI_FN int pdi_read_metal_given(pdi_reader *s, const char *name);
/* Cs, Csat and the properties of the first metal become constants of all later numbers. */
PDI_FN pd_status pdi_read_metal_constants(pdi_reader *s);
/* The section of metal m: its own, where it has the key (NULL: any), or that of all. */
PDI_FN int pdi_read_metal_section(pdi_reader *s, int m, const char *key);
/* The law of each metal. */
PDI_FN pd_status pdi_read_metal_laws(pdi_reader *s);
/* Before anything of the other sections is read: what [corrode] brings with it. */
PDI_FN pd_status pdi_read_metal_first(pdi_reader *s);
/* Horizons of the fluid, in section [grid], and of the bonds of metal. */
PDI_FN pd_status pdi_read_metal_horizons(pdi_reader *s, int grid);
/* [dissolve], the surface rate. */
PDI_FN pd_status pdi_read_metal_dissolve(pdi_reader *s);
/* [corrode], bond-based corrosion. */
PDI_FN pd_status pdi_read_metal_corrode(pdi_reader *s);
#endif

#endif
