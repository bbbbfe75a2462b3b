/* physics_list: the physics of this library, in the order in which models are built. */
#ifndef PD_PHYSICS_LIST_H
#define PD_PHYSICS_LIST_H
#include "physics/physics_row.h"

#ifdef PDI_INTERNAL
/* Make the list of all physics, in the order in which models are built. */
PDI_FN void pdi_physics_list_init(pdi_physics_list *list);
/* Make the list of those that the setup has (is_present), in the same order. */
PDI_FN void pdi_physics_list_init_present(const pd_setup *setup, pdi_physics_list *list);
#endif

#endif
