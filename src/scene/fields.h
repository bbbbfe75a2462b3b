/* fields: the fields of a run that can be written, drawn, sampled and watched, one row each: name, unit, where they
 * have values, how they are drawn, what a scene has to have for them. Front ends list them and know none by name. */
#ifndef PD_FIELDS_H
#define PD_FIELDS_H
#include "io/colour.h"
#include "scene/setup.h"

/* A field as front ends list it. */
typedef struct pd_field_info {
    const char *name;     /* "C", "Mg2+"; borrowed from the setup or static */
    const char *label;    /* "C [mol/m3]": with the unit; borrowed likewise */
    int components;       /* PD_DIM of a vector, else 1 */
    pd_field_place place;
    pd_colour_map map;    /* default colours: labels of categories, diverging where values have both signs */
} pd_field_info;

#define pd_field_info_get PD_NAME(pd_field_info_get)

/* Describe field number k >= 0 of those that the setup has, in the order of pd_field. Returns 0 beyond the last one. */
PD_API int pd_field_info_get(const pd_setup *setup, int k, pd_field_info *info);

#ifdef PDI_INTERNAL
/* Room of a list of names of fields for a message. */
#define PDI_FIELDS_NAMES_SIZE 512

/* Name of a field in files: "C", "v", "Mg2+", ...; "": no such species or surface state in this setup. */
PDI_FN const char *pdi_fields_get_name(const pd_setup *setup, pd_field field);
/* Name of a field with its unit for axes and tables: "C [mol/m3]". */
PDI_FN const char *pdi_fields_get_label(const pd_setup *setup, pd_field field);
/* Unit of a field into unit[PD_UNITS_TEXT]: "mol/m3"; "": dimensionless. */
PDI_FN void pdi_fields_get_unit(const pd_setup *setup, pd_field field, char *unit);
/* Names of all fields of the setup, "C, kind, phase", into text[PDI_FIELDS_NAMES_SIZE]; returns it. */
PDI_FN const char *pdi_fields_format_names(const pd_setup *setup, char *text);
/* Search a field by name. Returns its pd_field, or PD_FIELD_COUNT if there is none. */
PDI_FN int pdi_fields_find(const pd_setup *setup, const char *name);
/* Index in the electrolyte of the species whose concentration the field is; -1: it is no species. */
PDI_FN int pdi_fields_species_index(const pd_setup *setup, int64_t field);
/* Index of the surface state that the field is; -1: it is none. */
PDI_FN int pdi_fields_state_index(const pd_setup *setup, int64_t field);
/* Number of components: PD_DIM of a vector, else 1. */
PDI_FN int pdi_fields_count_components(pd_field field);
/* Letter of the axis of a component, which follows the name: x, y, z of a vector in every dimension; "" of others. */
PDI_FN const char *pdi_fields_get_axis(pd_field field, int component);
/* Cells in which the field has values. */
PDI_FN pd_field_place pdi_fields_get_place(const pd_setup *setup, pd_field field);
/* Field of a physics of the program: index in pd_setup.registered, and *index in its fields; -1: it is none. */
PDI_FN int pdi_fields_find_registered(const pd_setup *setup, int64_t field, int *index);
/* pd_field of the first field of the physics of the program; the others follow. */
PDI_FN int pdi_fields_first_registered(const pd_setup *setup);
/* 1: values are integer labels (kind, grain, phase): not to be interpolated. */
PDI_FN int pdi_fields_is_categorical(pd_field field);
/* 1: files hold one number a node: neither a vector, nor labels. */
PDI_FN int pdi_fields_is_scalar(pd_field field);
/* 1: values are fractions from 0 to 1, the default range of their colours. */
PDI_FN int pdi_fields_is_fraction(pd_field field);
/* Default colour map: of labels, diverging where values have both signs, else sequential. */
PDI_FN pd_colour_map pdi_fields_get_map(pd_field field);
/* What the setup lacks for this field, as text for a message: "a [flow] or [gas] section"; NULL: the field exists. */
PDI_FN const char *pdi_fields_lacks(const pd_setup *setup, pd_field field);

/* Bit of a field in a pd_fields set. */
static inline pd_fields pdi_fields_bit(int64_t field) { return (pd_fields)1 << field; }
/* 1: the field has values in the metal. */
static inline int pdi_fields_is_in_metal(const pd_setup *setup, pd_field field)
{
    pd_field_place place = pdi_fields_get_place(setup, field);
    return place == PD_FIELD_IN_METAL || place == PD_FIELD_IN_BOTH;
}
#endif

#endif
