/* registered_physics: the physics that programs bring along, as one physics of a model. */
#ifndef PD_REGISTERED_PHYSICS_H
#define PD_REGISTERED_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_registered_physics_register(pdi_physics_list *list);
#endif

#endif
