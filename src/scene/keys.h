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
/* Find it among the physics that are registered with the context, else in that table. NULL: there is none. */
PDI_FN const pd_key_section *pdi_keys_find_known_section(const pd_ctx *ctx, const char *name);
/* 1: a physics that is registered with the context has a field of this name. */
PDI_FN int pdi_keys_is_field(const pd_ctx *ctx, const char *name);
/* Find the row of a key in the table of a section; a row of the unit "any" takes every name. NULL: there is none. */
PDI_FN const pd_key *pdi_keys_find_key(const pd_key_section *section, const char *key);
#ifdef PD_DEBUG
/* Consistency check of a look-up with the table. 1: the table has this key with this unit (NULL: not checked) and this
 * default (NULL: not checked; one that the table tells in words: any), or the section has no name and no such key. */
PDI_FN int pdi_keys_is_consistent(const char *section, const char *key, const char *unit, const char *fallback);
#endif
#endif

#endif
