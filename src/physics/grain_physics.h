/* grain_physics: grains of the metal and their boundaries as a physics of a model. */
#ifndef PD_GRAIN_PHYSICS_H
#define PD_GRAIN_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_grain_physics_register(pdi_physics_list *list);
#endif

#endif
