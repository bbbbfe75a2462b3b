/* keys: the sections of a scene and their keys, with units, defaults and meanings: what the parser takes, what
 * `pd2d --keys` prints, and what the tables of docs/guide.md say.
 */
#ifndef PD_KEYS_H
#define PD_KEYS_H
#include "core/base.h"

typedef struct pd_key {
    const char *keys;     /* one, or several with one meaning: "vx, vy, vz" */
    const char *unit;     /* of the SI, any other of its dimension will do; "-": none; "any": a name of the user's;
                           * "text": a value with = in it; the first key of a section stands without it */
    const char *fallback; /* the default; "required"; "-": absent; "the ...", "that of ...": where it comes from */
    const char *meaning;
} pd_key;

typedef struct pd_key_section {
    const char *name, *label; /* label: what stands behind the name: "NAME", "FORMULA", "" for nothing */
    const char *meaning;
    const pd_key *key; /* [count] in the order of the guide */
    int count;
} pd_key_section;

#define pd_keys PD_NAME(pd_keys)

/* All sections, in the order of the guide. */
PD_API const pd_key_section *pd_keys(int *count);

#ifdef PDI_INTERNAL
/* NULL: there is none. */
PDI_FN const pd_key_section *pdi_keys_section(const char *name);
PDI_FN const pd_key *pdi_keys_find(const pd_key_section *section, const char *key);
#ifdef PD_DEBUG
/* 1 when the table has this key with this unit (NULL: not asked for) and this default among its own (NULL: none), or
 * the section has no name. */
PDI_FN int pdi_keys_agree(const char *section, const char *key, const char *unit, const char *fallback);
#endif
#endif

#endif
