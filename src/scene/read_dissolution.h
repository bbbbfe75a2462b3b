/* read_dissolution: reads the sections [dissolve] (surface rate) and [corrode] (bond-based corrosion) of a scene: rate
 * laws of dissolution, concentrations Cs and Csat, horizons.
 *
 * [dissolve NAME] and [corrode NAME] hold Cs, charge, rate law and reaction of one of several metals, whose shapes have
 * material = NAME. Metals without such a section use the section without a name, which holds all other keys.
 */
#ifndef PD_READ_DISSOLUTION_H
#define PD_READ_DISSOLUTION_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* 1: the scene has a section of that name, with or without the label of a metal. */
PDI_FN int pdi_read_dissolution_has_section(pdi_reader *reader, const char *name);
/* Read Cs, charge and Csat. Declare Cs, Csat and the material data rho_m, M_m, z_m of the first metal as named
 * constants of all later expressions. */
PDI_FN pd_status pdi_read_dissolution_constants(pdi_reader *reader);
/* Section of metal m in the text: the one with its label if that has the key (NULL: if it is present), else the one
 * without label, which is created empty where it is missing. */
PDI_FN int pdi_read_dissolution_find_section(pdi_reader *reader, int m, const char *key);
/* Read the dissolution rate law of each metal with its factor, with the constants of that metal. PD_ERR_ARGUMENT: laws
 * that the physics does not support, or, with [corrode], Csat not below Cs. */
PDI_FN pd_status pdi_read_dissolution_rates(pdi_reader *reader);
/* Before other sections are read: [corrode] switches transport and dissolution on. PD_ERR_ARGUMENT: beside
 * [dissolve]. */
PDI_FN pd_status pdi_read_dissolution_begin(pdi_reader *reader);
/* Read the horizons over h of the fluid operators (from section `grid`) into fluid_m and of the bonds of metal (from
 * [dissolve] or [corrode]) into metal_m. [corrode] has one for both unless both are given. */
PDI_FN pd_status pdi_read_dissolution_horizons(pdi_reader *reader, int grid);
/* Read the section [dissolve]: threshold of conversion and factor of grain boundaries. Rate laws are read
 * separately. */
PDI_FN pd_status pdi_read_dissolution_dissolve(pdi_reader *reader);
/* Read the section [corrode]: form of the bond-based model, Csat, bulk, repassivation. */
PDI_FN pd_status pdi_read_dissolution_corrode(pdi_reader *reader);
#endif

#endif
