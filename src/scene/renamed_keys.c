/* renamed_keys: see renamed_keys.h */
#include "scene/renamed_keys.h"
#include <string.h>

/* A former name: the last of section, key and value that is not NULL. Those before it have their present names. */
typedef struct pdi_renamed_key {
    const char *section, *key, *value;
    const char *present;
} pdi_renamed_key;

static const pdi_renamed_key pdi_renamed_keys_table[] = {{"cut", NULL, NULL, "crack"},
                                                         {"crack", "way", NULL, "direction"},
                                                         {"crack", "contours", NULL, "contour_radii"},
                                                         {"shape", "grains", NULL, "grain_size"},
                                                         {"shape", "grain_spread", NULL, "grain_size_deviation"},
                                                         {"shape", "boundary_width", NULL, "grain_boundary_width"},
                                                         {"flow", "steady", NULL, "steady_tolerance"},
                                                         {"flow", "force", NULL, "body_force"},
                                                         {"flow", "speed", NULL, "reference_speed"},
                                                         {"flow", "length", NULL, "reference_length"},
                                                         {"flow", "time", "given", "prescribed"},
                                                         {"dissolve", "gb_factor", NULL, "grain_boundary_factor"},
                                                         {"corrode", "gb_factor", NULL, "grain_boundary_factor"},
                                                         {"corrode", "drive", NULL, "driving_force"},
                                                         {"corrode", "weights", "printed", "published"},
                                                         {"solid", "material", NULL, "model"},
                                                         {"solid", "model", "springs", "bond_based"},
                                                         {"solid", "yield", NULL, "yield_stress"},
                                                         {"solid", "hardening", NULL, "hardening_modulus"},
                                                         {"solid", "toughness", NULL, "fracture_energy"},
                                                         {"solid", "stretch", NULL, "critical_stretch"},
                                                         {"solid", "motion", NULL, "dynamics"},
                                                         {"solid", "force", NULL, "body_force"},
                                                         {"solid", "speed_factor", NULL, "dissolution_factor"},
                                                         {"chemistry", "counter", NULL, "counter_ion"},
                                                         {"chemistry", "balance", NULL, "balance_ion"},
                                                         {"chemistry", "cover", NULL, "covering_thickness"},
                                                         {"species", "activation", NULL, "activation_energy"},
                                                         {"reaction", "activation", NULL, "activation_energy"},
                                                         {"electrode", "film", NULL, "film_resistance"},
                                                         {"electrode", "resistance", NULL, "polarisation_resistance"},
                                                         {"electrode", "factor", NULL, "current_factor"},
                                                         {"force", "speed", NULL, "reference_speed"},
                                                         {"force", "length", NULL, "reference_length"},
                                                         {"force", "area", NULL, "reference_area"},
                                                         {"transfer", "length", NULL, "reference_length"},
                                                         {"run", "fraction", NULL, "max_dissolved_fraction"},
                                                         {"output", "map", NULL, "colormap"},
                                                         {"output", "log", NULL, "log_scale"},
                                                         {"output", "deformed", NULL, "deformation_scale"},
                                                         {"measured", "spread", NULL, "standard_deviation"}};

#define PDI_RENAMED_KEYS_COUNT ((int)(sizeof pdi_renamed_keys_table / sizeof pdi_renamed_keys_table[0]))

/* 1: two names are equal, or both are absent. */
static int pdi_renamed_keys_is_equal(const char *a, const char *b) { return a && b ? strcmp(a, b) == 0 : a == b; }

PDI_FN int pdi_renamed_keys_find(const char *section, const char *key, const char *value)
{
    for (int k = 0; k < PDI_RENAMED_KEYS_COUNT; k++) {
        const pdi_renamed_key *r = &pdi_renamed_keys_table[k];
        if (pdi_renamed_keys_is_equal(r->section, section) && pdi_renamed_keys_is_equal(r->key, key) &&
            pdi_renamed_keys_is_equal(r->value, value))
            return k;
    }
    return -1;
}

PDI_FN const char *pdi_renamed_keys_get_section(const char *section)
{
    int k = pdi_renamed_keys_find(section, NULL, NULL);
    return k < 0 ? section : pdi_renamed_keys_table[k].present;
}

PDI_FN const char *pdi_renamed_keys_get_key(const char *section, const char *key)
{
    int k = pdi_renamed_keys_find(section, key, NULL);
    return k < 0 ? key : pdi_renamed_keys_table[k].present;
}

PDI_FN const char *pdi_renamed_keys_get_value(const char *section, const char *key, const char *value)
{
    int k = pdi_renamed_keys_find(section, key, value);
    return k < 0 ? value : pdi_renamed_keys_table[k].present;
}

PDI_FN const char *pdi_renamed_keys_describe(int index, const char **former, const char **present)
{
    const pdi_renamed_key *r = &pdi_renamed_keys_table[index];
    *former = r->value ? r->value : r->key ? r->key : r->section;
    *present = r->present;
    return r->section;
}

#undef PDI_RENAMED_KEYS_COUNT
