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

int pd_material_find(const char *name, pd_material *material)
{
    *material = pd_material_mg4ag();
    return strcmp(name, material->name) == 0;
}

double pd_material_concentration(const pd_material *material) { return material->density / material->molar_mass; }

double pd_material_speed(const pd_material *material, double current)
{
    return current / (material->charge * PDI_MATERIAL_FARADAY * pd_material_concentration(material));
}
