/* gas_physics: flow of an ideal gas as a physics of a model. */
#ifndef PD_GAS_PHYSICS_H
#define PD_GAS_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_gas_physics_register(pdi_physics_list *list);
#endif

#endif
