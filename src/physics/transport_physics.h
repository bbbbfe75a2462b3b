/* transport_physics: transport of the one dissolved concentration as a physics of a model. */
#ifndef PD_TRANSPORT_PHYSICS_H
#define PD_TRANSPORT_PHYSICS_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Append the row of this physics. */
PDI_FN void pdi_transport_physics_register(pdi_physics_list *list);
#endif

#endif
