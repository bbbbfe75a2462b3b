/* physics_list: see physics_list.h */
#include "physics/physics_list.h"
#include "physics/dissolution_physics.h"
#include "physics/flow_physics.h"
#include "physics/gas_physics.h"
#include "physics/grain_physics.h"
#include "physics/potential_physics.h"
#include "physics/registered_physics.h"
#include "physics/solid_physics.h"
#include "physics/species_physics.h"
#include "physics/transport_physics.h"
#include <string.h>

PDI_FN void pdi_physics_list_init(pdi_physics_list *list)
{
    memset(list, 0, sizeof *list);
    pdi_flow_physics_register(list);
    pdi_gas_physics_register(list);
    pdi_transport_physics_register(list);
    pdi_grain_physics_register(list);
    pdi_solid_physics_register(list);
    pdi_registered_physics_register(list);
    pdi_dissolution_physics_register(list);
    pdi_species_physics_register(list);
    pdi_potential_physics_register(list);
}

PDI_FN void pdi_physics_list_init_present(const pd_setup *setup, pdi_physics_list *list)
{
    int present = 0;
    pdi_physics_list_init(list);
    for (int k = 0; k < list->count; k++)
        if (list->row[k].is_present(setup)) list->row[present++] = list->row[k];
    list->count = present;
}
