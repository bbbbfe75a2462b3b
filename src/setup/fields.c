/* fields: see fields.h */
#include "setup/fields.h"
#include <stdio.h>
#include <string.h>

typedef struct pdi_fields_row {
    const char *name, *label;
    pd_field_place place;
    pd_field_scale scale;
    int is_vector;
    const char *(*lacks)(const pd_setup *setup); /* as of pd_fields_lacks; NULL: every setup has it */
} pdi_fields_row;

/* ---- what a setup lacks ---- */

/* What the setup lacks for a field, as text for a message; NULL: nothing. Likewise the following functions. */
static const char *pdi_fields_lacks_transport(const pd_setup *u)
{
    return u->has_transport ? NULL : "a [transport] or [corrode] section";
}

static const char *pdi_fields_lacks_flow(const pd_setup *u)
{
    return u->has_flow || u->has_gas ? NULL : "a [flow] or [gas] section";
}

static const char *pdi_fields_lacks_gas(const pd_setup *u) { return u->has_gas ? NULL : "a [gas] section"; }

static const char *pdi_fields_lacks_grains(const pd_setup *u)
{
    return u->has_grains ? NULL : "a solid [shape] with grain_size";
}

static const char *pdi_fields_lacks_dissolve(const pd_setup *u)
{
    return u->has_dissolve ? NULL : "a [dissolve] or [corrode] section";
}

static const char *pdi_fields_lacks_density(const pd_setup *u)
{
    return u->has_flow || u->has_gas || u->has_dissolve ? NULL : "a [flow], [gas], [dissolve] or [corrode] section";
}

static const char *pdi_fields_lacks_corrode(const pd_setup *u)
{
    return u->has_corrode ? NULL : "a [corrode] section";
}

static const char *pdi_fields_lacks_solid(const pd_setup *u) { return u->has_solid ? NULL : "a [solid] section"; }

static const char *pdi_fields_lacks_yield(const pd_setup *u)
{
    return u->has_solid && u->metal_body.yield > 0.0 ? NULL : "a [solid] section with yield_stress";
}

/* The bond-based material has no stress. */
static const char *pdi_fields_lacks_stress(const pd_setup *u)
{
    if (u->has_solid && u->metal_body.material != PD_SOLID_COUPLING_BOND_BASED) return NULL;
    return "a [solid] section whose model is not bond_based";
}

static const char *pdi_fields_lacks_stress_2d(const pd_setup *u)
{
    if (PD_DIM > 1 && !pdi_fields_lacks_stress(u)) return NULL;
    return "two dimensions and a [solid] section whose model is not bond_based";
}

static const char *pdi_fields_lacks_stress_3d(const pd_setup *u)
{
    if (PD_DIM > 2 && !pdi_fields_lacks_stress(u)) return NULL;
    return "three dimensions and a [solid] section whose model is not bond_based";
}

static const char *pdi_fields_lacks_potential(const pd_setup *u)
{
    return u->has_potential ? NULL : "a [potential] section";
}

/* Ions that migrate carry the current themselves. */
static const char *pdi_fields_lacks_current(const pd_setup *u)
{
    if (u->has_potential && u->has_migration) return "[potential] without migration = yes";
    return pdi_fields_lacks_potential(u);
}

static const char *pdi_fields_lacks_chemistry(const pd_setup *u)
{
    return u->has_chemistry ? NULL : "a [chemistry] section";
}

static const char *pdi_fields_lacks_migration(const pd_setup *u)
{
    if (!u->has_chemistry) return pdi_fields_lacks_chemistry(u);
    return u->has_migration ? NULL : "[chemistry] migration = yes";
}

static const char *pdi_fields_lacks_minerals(const pd_setup *u)
{
    if (!u->has_chemistry) return pdi_fields_lacks_chemistry(u);
    return u->minerals ? NULL : "a [mineral ...] section";
}

/* 1: the electrolyte has a species of this index, and it is no solvent (a solute or a mineral). */
static int pdi_fields_is_solute(const pd_setup *u, int species)
{
    const pd_electrolyte *e = &u->electrolyte;
    return species >= 0 && species < e->count && e->species[species].phase != PD_PHASE_SOLVENT;
}

static const char *pdi_fields_lacks_ph(const pd_setup *u)
{
    if (!u->has_chemistry) return pdi_fields_lacks_chemistry(u);
    return pdi_fields_is_solute(u, pd_electrolyte_find_species(&u->electrolyte, "H+")) ? NULL : "the species H+";
}

/* ---- the rows, in the order of pd_field ---- */

static const pdi_fields_row pdi_fields_rows[PD_FIELD_SPECIES] = {
    {"C", "C [mol/m3]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_transport},
    {"v", "v [m/s]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 1, pdi_fields_lacks_flow},
    {"p", "p [Pa]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_SIGNED, 0, pdi_fields_lacks_flow},
    {"kind", "kind", PD_FIELD_IN_ALL, PD_FIELD_SCALE_CATEGORY, 0, NULL},
    {"grain", "grain", PD_FIELD_IN_METAL, PD_FIELD_SCALE_CATEGORY, 0, pdi_fields_lacks_grains},
    {"phase", "phase", PD_FIELD_IN_BOTH, PD_FIELD_SCALE_CATEGORY, 0, NULL},
    {"D", "D [m2/s]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_transport},
    {"rate", "rate [m/s]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_dissolve},
    {"density", "density [kg/m3]", PD_FIELD_IN_BOTH, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_density},
    {"damage", "damage", PD_FIELD_IN_BOTH, PD_FIELD_SCALE_FRACTION, 0, pdi_fields_lacks_corrode},
    {"energy", "energy [J/m3]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_gas},
    {"u", "u [m]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_LENGTH, 0, pdi_fields_lacks_solid},
    {"mises", "mises [Pa]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_stress},
    {"sigma_h", "sigma_h [Pa]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_SIGNED, 0, pdi_fields_lacks_stress},
    {"eps_p", "eps_p", PD_FIELD_IN_METAL, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_yield},
    {"broken", "broken", PD_FIELD_IN_METAL, PD_FIELD_SCALE_FRACTION, 0, pdi_fields_lacks_solid},
    {"strain_energy", "strain_energy [J/m3]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_solid},
    {"sigma_xx", "sigma_xx [Pa]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_SIGNED, 0, pdi_fields_lacks_stress},
    {"sigma_yy", "sigma_yy [Pa]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_SIGNED, 0, pdi_fields_lacks_stress_2d},
    {"sigma_zz", "sigma_zz [Pa]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_SIGNED, 0, pdi_fields_lacks_stress_2d},
    {"sigma_xy", "sigma_xy [Pa]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_SIGNED, 0, pdi_fields_lacks_stress_2d},
    {"sigma_yz", "sigma_yz [Pa]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_SIGNED, 0, pdi_fields_lacks_stress_3d},
    {"sigma_zx", "sigma_zx [Pa]", PD_FIELD_IN_METAL, PD_FIELD_SCALE_SIGNED, 0, pdi_fields_lacks_stress_3d},
    {"phi", "phi [V]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_potential},
    {"j", "j [A/m2]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_current},
    {"i", "i [A/m2]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_potential},
    {"pH", "pH", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_ph},
    {"potential", "potential [V]", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_migration},
    {"film", "film", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_minerals},
    {"SI", "SI", PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, pdi_fields_lacks_minerals}};

/* Of species and states of surfaces, whose names and labels the setup has. */
static const pdi_fields_row pdi_fields_dissolved = {NULL, NULL, PD_FIELD_IN_FLUID, PD_FIELD_SCALE_PLAIN, 0, NULL};

/* Row of a field; species, surface states and fields of the physics of the program share one: scalar, in the fluid,
 * plain, lacking nothing. */
static const pdi_fields_row *pdi_fields_row_of(pd_field field)
{
    return field < PD_FIELD_SPECIES ? &pdi_fields_rows[field] : &pdi_fields_dissolved;
}

/* ---- look-ups ---- */

int pd_fields_species_index(const pd_setup *setup, int64_t field)
{
    int64_t index = field - PD_FIELD_SPECIES;
    return index >= 0 && index < PD_SPECIES_MAX && index < setup->electrolyte.count ? (int)index : -1;
}

int pd_fields_state_index(const pd_setup *setup, int64_t field)
{
    int64_t index = field - PD_FIELD_SPECIES - setup->electrolyte.count;
    return field >= PD_FIELD_SPECIES && index >= 0 && index < setup->states ? (int)index : -1;
}

int pd_fields_first_registered(const pd_setup *setup)
{
    return PD_FIELD_SPECIES + setup->electrolyte.count + setup->states;
}

int pd_fields_find_registered(const pd_setup *setup, int64_t field, int *index)
{
    int64_t k = field - pd_fields_first_registered(setup);
    for (int p = 0; p < setup->registered_count && k >= 0; k -= setup->registered[p++].type->fields)
        if (k < setup->registered[p].type->fields) {
            *index = (int)k;
            return p;
        }
    return -1;
}

const char *pd_fields_get_name(const pd_setup *setup, pd_field field)
{
    int k, own = pd_fields_find_registered(setup, field, &k);
    if (own >= 0) return setup->registered[own].type->field[k].name;
    int species = pd_fields_species_index(setup, field), state = pd_fields_state_index(setup, field);
    if (field < PD_FIELD_SPECIES) return pdi_fields_rows[field].name;
    if (species >= 0) return setup->electrolyte.species[species].name;
    return state < 0 ? "" : setup->state[state].name;
}

const char *pd_fields_get_label(const pd_setup *setup, pd_field field)
{
    int k, own = pd_fields_find_registered(setup, field, &k);
    if (own >= 0) return setup->registered[own].label[k];
    int species = pd_fields_species_index(setup, field), state = pd_fields_state_index(setup, field);
    if (field < PD_FIELD_SPECIES) return pdi_fields_rows[field].label;
    if (species >= 0) return setup->species_label[species];
    return state < 0 ? "" : setup->state[state].label;
}

void pd_fields_get_unit(const pd_setup *setup, pd_field field, char *unit)
{
    const char *from = strchr(pd_fields_get_label(setup, field), '[');
    snprintf(unit, PD_UNITS_TEXT, "%.*s", from ? (int)strcspn(from + 1, "]") : 0, from ? from + 1 : "");
}

int pd_fields_find(const pd_setup *setup, const char *name)
{
    int field = 0;
    while (field < PD_FIELD_COUNT && (!name[0] || strcmp(pd_fields_get_name(setup, (pd_field)field), name) != 0))
        field++;
    return field;
}

int pd_fields_count_components(pd_field field) { return pdi_fields_row_of(field)->is_vector ? PD_DIM : 1; }

const char *pd_fields_get_axis(pd_field field, int component)
{
    static const char *const axes[] = {"x", "y", "z"};
    return pdi_fields_row_of(field)->is_vector ? axes[component] : "";
}

pd_field_place pd_fields_get_place(const pd_setup *setup, pd_field field)
{
    int k, own = pd_fields_find_registered(setup, field, &k);
    return own >= 0 ? setup->registered[own].type->field[k].place : pdi_fields_row_of(field)->place;
}

int pd_fields_is_scalar(pd_field field)
{
    const pdi_fields_row *row = pdi_fields_row_of(field);
    return !row->is_vector && row->scale != PD_FIELD_SCALE_CATEGORY && row->scale != PD_FIELD_SCALE_LENGTH;
}

pd_field_scale pd_fields_get_scale(pd_field field) { return pdi_fields_row_of(field)->scale; }

const char *pd_fields_lacks(const pd_setup *setup, pd_field field)
{
    const pdi_fields_row *row = pdi_fields_row_of(field);
    if (field < PD_FIELD_SPECIES) return row->lacks ? row->lacks(setup) : NULL;
    int k;
    if (pd_fields_state_index(setup, field) >= 0 || pd_fields_find_registered(setup, field, &k) >= 0) return NULL;
    if (!setup->has_chemistry) return pdi_fields_lacks_chemistry(setup);
    return pdi_fields_is_solute(setup, pd_fields_species_index(setup, field)) ? NULL : "a solute";
}

int pd_field_info_get(const pd_setup *setup, int k, pd_field_info *info)
{
    for (int field = 0; field < PD_FIELD_COUNT; field++) {
        if (pd_fields_lacks(setup, (pd_field)field) || !pd_fields_get_name(setup, (pd_field)field)[0]) continue;
        if (k-- > 0) continue;
        info->name = pd_fields_get_name(setup, (pd_field)field);
        info->label = pd_fields_get_label(setup, (pd_field)field);
        info->components = pd_fields_count_components((pd_field)field);
        info->place = pd_fields_get_place(setup, (pd_field)field);
        info->scale = pd_fields_get_scale((pd_field)field);
        return 1;
    }
    return 0;
}

const char *pd_fields_format_names(const pd_setup *setup, char *text)
{
    pd_field_info info;
    size_t used = 0;
    text[0] = '\0';
    for (int k = 0; pd_field_info_get(setup, k, &info) && used + strlen(info.name) + 3 < PD_FIELDS_NAMES_SIZE; k++)
        used += (size_t)snprintf(text + used, PD_FIELDS_NAMES_SIZE - used, "%s%s", k ? ", " : "", info.name);
    return text;
}
