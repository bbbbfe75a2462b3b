/* material: see material.h */
#include "metal/material.h"
#include "core/vec.h"
#include <string.h>

/* name, density, molar mass, charge */
static const pd_material pdi_material_list[] = {{"mg4ag", 1738.0, 0.024305, 2.0},
                                                {"steel304", 7900.0, 0.05532, 2.19},
                                                {"copper", 8960.0, 0.063546, 2.0},
                                                {"alloy625", 8440.0, 0.05978, 2.374}};

int pd_material_find(const char *name, pd_material *material)
{
    for (size_t k = 0; k < sizeof pdi_material_list / sizeof pdi_material_list[0]; k++) {
        if (strcmp(name, pdi_material_list[k].name) != 0) continue;
        *material = pdi_material_list[k];
        return 1;
    }
    return 0;
}

double pd_material_concentration(const pd_material *material) { return material->density / material->molar_mass; }

double pd_material_speed(const pd_material *material, double current)
{
    return current / (material->charge * PD_FARADAY * pd_material_concentration(material));
}
