/* material: properties of metals that dissolve, as presets with their sources, and their kinetics as data. */
#ifndef PD_MATERIAL_H
#define PD_MATERIAL_H
#include "base.h"

/* Recession speed [m/s] at dissolved concentration c [mol/m3]. */
typedef double (*pd_rate_fn)(void *user, double c);

typedef struct pd_material {
    const char *name;  /* as in scene files */
    double density;    /* [kg/m3] */
    double molar_mass; /* [kg/mol] */
    double charge;     /* [-] electrons given off by one atom */
} pd_material;

#define pd_material_mg4ag PD_NAME(pd_material_mg4ag)
#define pd_material_find PD_NAME(pd_material_find)
#define pd_material_concentration PD_NAME(pd_material_concentration)
#define pd_material_speed PD_NAME(pd_material_speed)

/* Mg-4Ag with the figures of pure magnesium: density 1738 kg/m3 (CRC Handbook of Chemistry and Physics,
 * section 4), molar mass 24.305 g/mol (IUPAC 2021), z = 2 (Mg -> Mg2+ + 2 e-). The wire of Reimers et al. 2023, ACS
 * Appl. Mater. Interfaces 15, 35600; its 4 % of silver are not counted. */
PD_API pd_material pd_material_mg4ag(void);
/* The preset of a name ("mg4ag"). 1 when there is one. */
PD_API int pd_material_find(const char *name, pd_material *material);
/* Concentration Cs [mol/m3] of the intact metal. */
PD_API double pd_material_concentration(const pd_material *material);
/* Recession speed v = i/(z F Cs) [m/s] at the current density i [A/m2] (Faraday's law). */
PD_API double pd_material_speed(const pd_material *material, double current);

#endif
