/* renamed_keys: former names of sections, keys and values of scene files. Scenes that use them are read as before, with
 * a note of the names that hold.
 */
#ifndef PD_RENAMED_KEYS_H
#define PD_RENAMED_KEYS_H
#include "core/base.h"

#define PD_RENAMED_KEYS 48 /* most of them */

#ifdef PDI_APP_INTERNAL
/* The present name of a section; `section` itself where that is no former name. */
PDI_FN const char *pdi_renamed_keys_get_section(const char *section);
/* The present name of a key of a section, given by its present name; `key` itself where that is no former name. */
PDI_FN const char *pdi_renamed_keys_get_key(const char *section, const char *key);
/* The present name of a value of a key; `value` itself where that is no former one. section and key: present names. */
PDI_FN const char *pdi_renamed_keys_get_value(const char *section, const char *key, const char *value);
/* Number of the former name that a section (key NULL), key (value NULL) or value is; -1: it is none. */
PDI_FN int pdi_renamed_keys_find(const char *section, const char *key, const char *value);
/* Former and present name of entry `index` for a message, "toughness", "fracture_energy". Returns the section of the
 * entry, which is the former name itself where a section was renamed. */
PDI_FN const char *pdi_renamed_keys_describe(int index, const char **former, const char **present);
#endif

#endif
