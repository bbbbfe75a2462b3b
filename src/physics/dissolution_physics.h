/* dissolution_physics: dissolution of the metal, at surfaces or by bonds, as a physics of a model. */
#ifndef PD_DISSOLUTION_PHYSICS_H
#define PD_DISSOLUTION_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_dissolution_physics_register(pdi_physics_list *list);
#endif

#endif
