/* material: see material.h */
#include "material.h"
#include <string.h>

#define PDI_MATERIAL_FARADAY 96485.33212 /* [C/mol] */

pd_material pd_material_mg4ag(void)
{
    pd_material m;
    m.name = "mg4ag";
    m.density = 1738.0;
    m.molar_mass = 0.024305;
    m.charge = 2.0;
    return m;
}

pd_material pd_material_steel304(void)
{
    pd_material m;
    m.name = "steel304";
    m.density = 7900.0;
    m.molar_mass = 0.05532;
    m.charge = 2.19;
    return m;
}

pd_material pd_material_copper(void)
{
    pd_material m;
    m.name = "copper";
    m.density = 8960.0;
    m.molar_mass = 0.063546;
    m.charge = 2.0;
    return m;
}

int pd_material_find(const char *name, pd_material *material)
{
    const pd_material list[] = {pd_material_mg4ag(), pd_material_steel304(), pd_material_copper()};
    for (size_t k = 0; k < sizeof list / sizeof list[0]; k++) {
        *material = list[k];
        if (strcmp(name, material->name) == 0) return 1;
    }
    return 0;
}

double pd_material_concentration(const pd_material *material) { return material->density / material->molar_mass; }

double pd_material_speed(const pd_material *material, double current)
{
    return current / (material->charge * PDI_MATERIAL_FARADAY * pd_material_concentration(material));
}
