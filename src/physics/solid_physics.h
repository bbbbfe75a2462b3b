/* solid_physics: mechanics of the metal as a physics of a model. */
#ifndef PD_SOLID_PHYSICS_H
#define PD_SOLID_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_solid_physics_register(pdi_physics_list *list);
#endif

#endif
