/* fields: the fields of a run that can be written, drawn, sampled and watched, one row each: name, unit, where they
 * have values, how they are drawn, what a scene has to have for them. Front ends list them and know none by name. */
#ifndef PD_FIELDS_H
#define PD_FIELDS_H
#include "setup/setup.h"

/* How the values of a field lie, by which front ends choose colours. */
typedef enum pd_field_scale {
    PD_FIELD_SCALE_PLAIN = 0,
    PD_FIELD_SCALE_SIGNED,   /* both signs */
    PD_FIELD_SCALE_FRACTION, /* from 0 to 1 */
    PD_FIELD_SCALE_CATEGORY, /* whole numbers that name something, not to be interpolated: kinds, grains, phases */
    PD_FIELD_SCALE_LENGTH    /* length of a vector that files hold as a whole */
} pd_field_scale;

/* A field as front ends list it. */
typedef struct pd_field_info {
    const char *name;     /* "C", "Mg2+"; borrowed from the setup or static */
    const char *label;    /* "C [mol/m3]": with the unit; borrowed likewise */
    int components;       /* PD_DIM of a vector, else 1 */
    pd_field_place place;
    pd_field_scale scale;
} pd_field_info;

#define pd_field_info_get PD_NAME(pd_field_info_get)
#define pd_fields_count_components PD_NAME(pd_fields_count_components)
#define pd_fields_find PD_NAME(pd_fields_find)
#define pd_fields_find_registered PD_NAME(pd_fields_find_registered)
#define pd_fields_first_registered PD_NAME(pd_fields_first_registered)
#define pd_fields_format_names PD_NAME(pd_fields_format_names)
#define pd_fields_get_axis PD_NAME(pd_fields_get_axis)
#define pd_fields_get_label PD_NAME(pd_fields_get_label)
#define pd_fields_get_name PD_NAME(pd_fields_get_name)
#define pd_fields_get_place PD_NAME(pd_fields_get_place)
#define pd_fields_get_scale PD_NAME(pd_fields_get_scale)
#define pd_fields_get_unit PD_NAME(pd_fields_get_unit)
#define pd_fields_is_scalar PD_NAME(pd_fields_is_scalar)
#define pd_fields_lacks PD_NAME(pd_fields_lacks)
#define pd_fields_species_index PD_NAME(pd_fields_species_index)
#define pd_fields_state_index PD_NAME(pd_fields_state_index)

/* 1: *info describes field number k >= 0 of those that the setup has, in the order of pd_field; a field counts if it
 * lacks nothing and has a name. 0: there are fewer, and *info stays. */
PD_API int pd_field_info_get(const pd_setup *setup, int k, pd_field_info *info);

/* Room of a list of names of fields for a message. */
#define PD_FIELDS_NAMES_SIZE 512
/* Name of a field in files: "C", "v", "Mg2+", ...; "": no such species or surface state in this setup. */
PD_API const char *pd_fields_get_name(const pd_setup *setup, pd_field field);
/* Name of a field with its unit for axes and tables: "C [mol/m3]". */
PD_API const char *pd_fields_get_label(const pd_setup *setup, pd_field field);
/* Unit of a field into unit[PD_UNITS_TEXT]: what its label has in brackets, "mol/m3"; "": dimensionless, or no such
 * field. */
PD_API void pd_fields_get_unit(const pd_setup *setup, pd_field field, char *unit);
/* Names of the fields of the setup, "C, kind, phase", into text[PD_FIELDS_NAMES_SIZE]; the first that does not fit and
 * those behind it are left out. Returns text. */
PD_API const char *pd_fields_format_names(const pd_setup *setup, char *text);
/* Search a field by name, also one that the setup lacks. Returns its pd_field, or PD_FIELD_COUNT if there is none, or
 * the name is empty. */
PD_API int pd_fields_find(const pd_setup *setup, const char *name);
/* Index in the electrolyte of the species whose concentration the field is; -1: it is no species. */
PD_API int pd_fields_species_index(const pd_setup *setup, int64_t field);
/* Index of the surface state that the field is; -1: it is none. */
PD_API int pd_fields_state_index(const pd_setup *setup, int64_t field);
/* Number of components: PD_DIM of a vector, else 1. */
PD_API int pd_fields_count_components(pd_field field);
/* Letter of the axis of a component, which follows the name: x, y, z of a vector in every dimension; "" of others. */
PD_API const char *pd_fields_get_axis(pd_field field, int component);
/* Cells in which the field has values: of the physics of the program as its type says; species and surface states in
 * the fluid. */
PD_API pd_field_place pd_fields_get_place(const pd_setup *setup, pd_field field);
/* How its values lie. */
PD_API pd_field_scale pd_fields_get_scale(pd_field field);
/* Field of a physics of the program: index in pd_setup.registered, *index in its fields; -1: none, *index stays. */
PD_API int pd_fields_find_registered(const pd_setup *setup, int64_t field, int *index);
/* pd_field of the first field of the physics of the program; the others follow. */
PD_API int pd_fields_first_registered(const pd_setup *setup);
/* 1: files hold one plain number a node: no vector (v), no vector given by its length (u), no category (kind, grain,
 * phase). */
PD_API int pd_fields_is_scalar(pd_field field);
/* What the setup lacks for this field, as text for a message: "a [flow] or [gas] section"; NULL: the field exists. A
 * species must be a solute or a mineral of the electrolyte. A number behind all fields of the setup lacks a [chemistry]
 * section, or "a solute" where there is one. */
PD_API const char *pd_fields_lacks(const pd_setup *setup, pd_field field);
/* Bit of a field in a pd_fields set. */
static inline pd_fields pd_fields_bit(int64_t field) { return (pd_fields)1 << field; }
/* 1: the field has values in the metal. */
static inline int pd_fields_is_in_metal(const pd_setup *setup, pd_field field)
{
    pd_field_place place = pd_fields_get_place(setup, field);
    return place == PD_FIELD_IN_METAL || place == PD_FIELD_IN_BOTH;
}

#endif
