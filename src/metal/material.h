/* material: properties of metals that dissolve, as presets with their sources, and their kinetics as data. */
#ifndef PD_MATERIAL_H
#define PD_MATERIAL_H
#include "core/base.h"

/* What a law may depend on. Room to grow: later members do not change the signature of laws. */
typedef struct pd_rate_at {
    double c;         /* [mol/m3] dissolved concentration */
    double t;         /* [s] */
    double x[PD_DIM]; /* [m] node of the fluid beside the metal */
    int32_t grain;    /* of the metal nearest to that node; -1: it has none, or none is known */
    int32_t node;     /* that node */
} pd_rate_at;

/* Recession speed [m/s] there. */
typedef double (*pd_rate_fn)(void *user, const pd_rate_at *at);

/* Between which speeds [m/s] it stays there at all times from `from` to `to` [s]; infinite: not known. */
typedef void (*pd_rate_bounds_fn)(void *user, const pd_rate_at *at, double from, double to, double *least,
                                  double *most);

typedef struct pd_material {
    const char *name;  /* as in scene files */
    double density;    /* [kg/m3] */
    double molar_mass; /* [kg/mol] */
    double charge;     /* [-] electrons given off by one atom */
} pd_material;

#define pd_material_find PD_NAME(pd_material_find)
#define pd_material_concentration PD_NAME(pd_material_concentration)
#define pd_material_speed PD_NAME(pd_material_speed)

/* The preset of a name: 1 when there is one, else 0 and *material stays.
 *
 * mg4ag: Mg-4Ag with the figures of pure magnesium: density 1738 kg/m3 (CRC Handbook of Chemistry and Physics,
 * section 4), molar mass 24.305 g/mol (IUPAC 2021), z = 2 (Mg -> Mg2+ + 2 e-). The wire of Reimers et al. 2023, ACS
 * Appl. Mater. Interfaces 15, 35600; its 4 % of silver are not counted.
 * steel304: stainless steel 304 as Fe-18Cr-8Ni (mass %): density 7900 kg/m3 (EN 10088-1, 1.4301); with the atomic
 * masses of IUPAC 2021 mean molar mass 55.32 g/mol, and z = 2.19 as Fe2+, Cr3+ and Ni2+. Cs = 142.8 mol/L.
 * copper: density 8960 kg/m3 (CRC Handbook, section 4), molar mass 63.546 g/mol (IUPAC 2021), z = 2.
 * alloy625: nickel alloy 625 (UNS N06625) as Ni-21.5Cr-9Mo-4.85Fe-3.65Nb (mass %): density 8440 kg/m3 (EN 10095,
 * 2.4856); with the atomic masses of IUPAC 2021 mean molar mass 59.78 g/mol, and z = 2.374 as Ni2+, Cr3+, Mo3+, Fe2+
 * and Nb5+. Cs = 141.2 mol/L. */
PD_API int pd_material_find(const char *name, pd_material *material);
/* Concentration Cs [mol/m3] of the intact metal. */
PD_API double pd_material_concentration(const pd_material *material);
/* Recession speed v = i/(z F Cs) [m/s] at the current density i [A/m2] (Faraday's law). */
PD_API double pd_material_speed(const pd_material *material, double current);
#define PD_MATERIAL_NAMES "mg4ag, steel304, copper or alloy625"

#endif
