/* keys: reference table of all sections and keys of scene files, with units, defaults and meanings. The parser checks
 * scenes against it, `pd2d --keys` prints it, and the tables of docs/guide.md agree with it.
 */
#ifndef PD_KEYS_H
#define PD_KEYS_H
#include "core/base.h"

/* A key of a section. */
typedef struct pd_key {
    const char *keys;     /* one, or several with one meaning: "vx, vy, vz" */
    const char *unit;     /* of the SI, any other of its dimension will do; "-": none; "any": a name of the user's;
                           * "text": a value with = in it; the first key of a section stands without it */
    const char *default_text; /* the default; "required"; "-": absent; "the ...", "that of ...": where it comes from */
    const char *meaning;
} pd_key;

/* A section and its keys. */
typedef struct pd_key_section {
    const char *name, *label; /* label: what stands behind the name: "NAME", "FORMULA", "" for nothing */
    const char *meaning;
    const pd_key *key; /* [count] in the order of the guide */
    int count;
} pd_key_section;

#define pd_key_sections PD_NAME(pd_key_sections)

/* The table of all sections, in the order of the guide; *count: their number. */
PD_API const pd_key_section *pd_key_sections(int *count);

#ifdef PDI_INTERNAL
/* Find the section of this name. NULL: there is none. */
PDI_FN const pd_key_section *pdi_keys_find_section(const char *name);
/* Find a key in the table of a section. NULL: the section has no such key. */
PDI_FN const pd_key *pdi_keys_find_key(const pd_key_section *section, const char *key);
#ifdef PD_DEBUG
/* Consistency check of a look-up with the table. 1: the table has this key with this unit (NULL: not checked) and this
 * default (NULL: not checked), or the section has no name. */
PDI_FN int pdi_keys_is_consistent(const char *section, const char *key, const char *unit, const char *fallback);
#endif
#endif

#endif
