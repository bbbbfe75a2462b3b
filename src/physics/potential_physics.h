/* potential_physics: electrodes and the electric potential of the fluid as a physics of a model. */
#ifndef PD_POTENTIAL_PHYSICS_H
#define PD_POTENTIAL_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_potential_physics_register(pdi_physics_list *list);
#endif

#endif
