/* keys: reference table of all sections and keys of scene files, with units, defaults and meanings. The parser checks
 * scenes against it, `pd2d --keys` prints it, and the tables of docs/guide.md agree with it.
 */
#ifndef PD_KEYS_H
#define PD_KEYS_H
#include "couple/physics_type.h"

#define pd_key_sections PD_NAME(pd_key_sections)

/* The table of all sections, in the order of the guide; *count: their number. */
PD_API const pd_key_section *pd_key_sections(int *count);

#ifdef PDI_APP_INTERNAL
#define PDI_KEYS_MAX_POINTS 100000 /* most points of a line */
/* Find the section of this name in the table. NULL: there is none. */
PDI_FN const pd_key_section *pdi_keys_find_section(const char *name);
/* Find the section of this name among the physics that are registered with the context, which go first, else in the
 * table. NULL: there is none. */
PDI_FN const pd_key_section *pdi_keys_find_known_section(const pd_ctx *ctx, const char *name);
/* 1: a physics that is registered with the context has a field of this name. */
PDI_FN int pdi_keys_is_field(const pd_ctx *ctx, const char *name);
/* Find the first row of a section's table that lists the key; a row may list several, and one of the unit "any" takes
 * every name. Former names are not known here. NULL: there is none. */
PDI_FN const pd_key *pdi_keys_find_key(const pd_key_section *section, const char *key);
#ifdef PD_DEBUG
/* Consistency check of a look-up with the table. 1: the table has this key with this unit (NULL: not checked; "": a
 * plain number; a unit "any" or m^(d-1) of the table: any) and this default (NULL: not checked; one that the table
 * tells in words: any), or the table has no such key and the section has no name. 0: else. */
PDI_FN int pdi_keys_is_consistent(const char *section, const char *key, const char *unit, const char *fallback);
#endif
#endif

#endif
