/* species_physics: reacting species, minerals and states of surfaces as a physics of a model. */
#ifndef PD_SPECIES_PHYSICS_H
#define PD_SPECIES_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_species_physics_register(pdi_physics_list *list);
#endif

#endif
