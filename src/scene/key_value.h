/* key_value: values of scene keys by the table of keys: unit, default, bounds and choices stand there alone.
 *
 * A default of the table is what stands before the first ; or : of its text. Where the default depends on the scene the
 * reader gives it as `fallback`, parsed like a value of the file.
 */
#ifndef PD_KEY_VALUE_H
#define PD_KEY_VALUE_H
#include "scene/text.h"

#ifdef PDI_APP_INTERNAL
/* A number [SI] within the bounds of its key, with the default of the table. PD_ERR_ARGUMENT with file:line: out of
 * bounds, or NaN. PD_ERR_INTERNAL: the table has no such number, or section is -1. Others: pdi_text_get_number. */
PDI_FN pd_status pdi_key_value_get_number(pd_ctx *ctx, pd_text *text, int section, const char *key, double *value);
/* The same with a default that depends on the scene; fallback NULL: the key is required. */
PDI_FN pd_status pdi_key_value_get_number_or(pd_ctx *ctx, pd_text *text, int section, const char *key,
                                             const char *fallback, double *value);
/* The same with an upper bound [SI] that depends on the scene; the smaller of it and that of the table counts. */
PDI_FN pd_status pdi_key_value_get_number_up_to(pd_ctx *ctx, pd_text *text, int section, const char *key, double high,
                                                double *value);
/* A whole number within the bounds of its key, or the position of a word among its choices, from 0 on ("no, yes": 0, 1;
 * there true, on, false, off are words, too). PD_ERR_PARSE with file:line: out of bounds, or another word.
 * PD_ERR_INTERNAL: the table has no such key of this type, or section is -1. */
PDI_FN pd_status pdi_key_value_get_index(pd_ctx *ctx, pd_text *text, int section, const char *key, int *value);
/* The same with a default that depends on the scene; fallback NULL: the key is required. */
PDI_FN pd_status pdi_key_value_get_index_or(pd_ctx *ctx, pd_text *text, int section, const char *key,
                                            const char *fallback, int *value);
/* Check a value [SI] against the bounds of its key, of which the lower one may be open and the upper one is included.
 * PD_ERR_ARGUMENT with file:line: it is out of them, or NaN. A key without bounds admits any value. */
PDI_FN pd_status pdi_key_value_check_bounds(pd_ctx *ctx, const pd_text *text, int section, const pd_key *key,
                                            double value);
#endif

#endif
