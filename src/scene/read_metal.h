/* read_metal: reads the sections [dissolve] and [corrode] of a scene: how metal goes.
 *
 * [dissolve NAME] and [corrode NAME] hold Cs, charge and law of one of several metals, whose shapes have material =
 * NAME. Metals without such a section follow the section without a name, which holds all else.
 */
#ifndef PD_READ_METAL_H
#define PD_READ_METAL_H
#include "scene/reader.h"

#ifdef PDI_INTERNAL
/* Species that a text names as [H+], which name[] keeps, become variables behind the first *count ones, and of[]. */
PDI_FN pd_status pdi_read_metal_species(pdi_reader *s, int section, const char *key, pd_expr_symbol *vars,
                                        char (*name)[PD_SPECIES_NAME + 2], int *count, int *of, int *species);
/* 1: there is a section of that name, with or without the name of a metal. */
PDI_FN int pdi_read_metal_given(pdi_reader *s, const char *name);
/* Cs, Csat and the properties of the first metal become constants of all later numbers. */
PDI_FN pd_status pdi_read_metal_constants(pdi_reader *s);
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
