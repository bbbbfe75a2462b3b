/* flow_physics: flow of the liquid, steady, in time or prescribed, as a physics of a model. */
#ifndef PD_FLOW_PHYSICS_H
#define PD_FLOW_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_flow_physics_register(pdi_physics_list *list);
#endif

#endif
