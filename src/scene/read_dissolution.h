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
/* 1: the scene has a section of that name, with or without the label of a metal. An empty section header counts. */
PDI_FN int pdi_read_dissolution_has_section(pdi_reader *reader, const char *name);
/* Read Cs, charge and Csat. Declare rho_m, M_m, z_m and Cs of the first metal, and Csat if it is given, as named
 * constants of all later expressions. Without dissolution the keys are not read. PD_ERR_ARGUMENT: a labelled section of
 * no metal of the shapes, or in one a key that all metals share. */
PDI_FN pd_status pdi_read_dissolution_constants(pdi_reader *reader);
/* Read the dissolution rate law of each metal with its factor, with the constants of that metal; those of the first
 * metal hold again afterwards. Without dissolution do nothing. PD_ERR_ARGUMENT: laws that the physics does not support,
 * or, with [corrode], Cs of a metal not above Csat. */
PDI_FN pd_status pdi_read_dissolution_rates(pdi_reader *reader);
/* Set has_transport and has_dissolve if there is a [corrode] section, before other sections are read. PD_ERR_ARGUMENT:
 * it stands beside [dissolve]. */
PDI_FN pd_status pdi_read_dissolution_begin(pdi_reader *reader);
/* Read the horizons over h of the fluid operators (section `grid`) into fluid_m and of the bonds of metal (of
 * [dissolve] or [corrode]) into metal_m. Defaults: with [corrode] both 3, or the one that is given; else 1 of the
 * fluid, and of metal 3 or that of the fluid, whichever is larger. PD_ERR_ARGUMENT: without [corrode] that of metal is
 * below that of the fluid. */
PDI_FN pd_status pdi_read_dissolution_horizons(pdi_reader *reader, int grid);
/* Read the section [dissolve]: threshold of conversion and factor of grain boundaries; rate laws are read separately.
 * Without [dissolve] do nothing. PD_ERR_ARGUMENT: no [transport], no solid shape, or a factor other than 1 without
 * grains. */
PDI_FN pd_status pdi_read_dissolution_dissolve(pdi_reader *reader);
/* Read the section [corrode]: form of the bond-based model, factor of grain boundaries, D, initial and bulk
 * concentration, repassivation. Without [corrode] do nothing. PD_ERR_ARGUMENT: no solid shape, Csat above Cs of the
 * first metal, bulk or repassivation above Csat, repassivation with control = activation. */
PDI_FN pd_status pdi_read_dissolution_corrode(pdi_reader *reader);
#endif

#endif
