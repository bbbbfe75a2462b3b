/* read_constants: reads the [constants] section of a scene: names for values, known to all numbers and expressions.
 *
 *   [constants]  v = 1.7 um/h   tau = 1.5 h   loss = v * tau
 */
#ifndef PD_READ_CONSTANTS_H
#define PD_READ_CONSTANTS_H
#include "scene/text.h"

#ifdef PDI_INTERNAL
#define PDI_READ_CONSTANTS_MAX 32  /* of a scene */
#define PDI_READ_CONSTANTS_ROOM 8  /* for those that the caller appends */

typedef struct pdi_read_constants {
    pd_expr_symbol symbol[PDI_READ_CONSTANTS_MAX + PDI_READ_CONSTANTS_ROOM];
    char unit[PDI_READ_CONSTANTS_MAX][PD_UNITS_TEXT]; /* that the symbols point to */
    int count;
} pdi_read_constants;

/* All constants, in the order of the file; each may use those before it. `text` knows them from then on, as long as
 * `named` lives. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_constants_read(pd_ctx *ctx, pd_text *text, pdi_read_constants *named);
/* One of the caller's own, with a unit that lives as long. */
PDI_FN void pdi_read_constants_append(pd_text *text, pdi_read_constants *named, const char *name, const char *unit,
                                      double value);
/* Unit of SI for a dimension, as expressions read it, into unit[PD_UNITS_TEXT]. 0: exponents are broken. */
PDI_FN int pdi_read_constants_unit(pd_ctx *ctx, const pd_dims *dims, char *unit);
/* 1: expressions of a scene know the name without its doing. */
PDI_FN int pdi_read_constants_taken(const char *name);
#endif

#endif
