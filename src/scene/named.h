/* named: reads the [constants] section of a scene: names for values, known to all numbers and expressions.
 *
 *   [constants]  v = 1.7 um/h   tau = 1.5 h   loss = v * tau
 */
#ifndef PD_NAMED_H
#define PD_NAMED_H
#include "scene/text.h"

#ifdef PDI_INTERNAL
#define PDI_NAMED_MAX 32  /* of a scene */
#define PDI_NAMED_ROOM 8  /* for those that the caller appends */

typedef struct pdi_named {
    pd_expr_symbol symbol[PDI_NAMED_MAX + PDI_NAMED_ROOM];
    char unit[PDI_NAMED_MAX][PD_UNITS_TEXT]; /* that the symbols point to */
    int count;
} pdi_named;

/* All constants, in the order of the file; each may use those before it. `text` knows them from then on, as long as
 * `named` lives. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_named_read(pd_ctx *ctx, pd_text *text, pdi_named *named);
/* One of the caller's own, with a unit that lives as long. */
PDI_FN void pdi_named_append(pd_text *text, pdi_named *named, const char *name, const char *unit, double value);
/* 1: expressions of a scene know the name without its doing. */
PDI_FN int pdi_named_taken(const char *name);
#endif

#endif
