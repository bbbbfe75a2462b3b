/* read_constants: reads the [constants] section of a scene: names for values, known to all numbers and expressions.
 *
 *   [constants]  v = 1.7 um/h   tau = 1.5 h   loss = v * tau
 */
#ifndef PD_READ_CONSTANTS_H
#define PD_READ_CONSTANTS_H
#include "scene/text.h"

#ifdef PDI_APP_INTERNAL
#define PDI_READ_CONSTANTS_MAX 32  /* of a scene */
#define PDI_READ_CONSTANTS_EXTRA 8 /* for those that the caller appends */

/* Named constants with their values in SI. */
typedef struct pdi_read_constants_table {
    pd_expr_symbol symbol[PDI_READ_CONSTANTS_MAX + PDI_READ_CONSTANTS_EXTRA];
    char unit[PDI_READ_CONSTANTS_MAX][PD_UNITS_TEXT]; /* that the symbols point to */
    int count;
} pdi_read_constants_table;

/* Read all constants in the order of the file into `named`, which is emptied first; each may use those before it. From
 * then on `text` knows them, as long as `named` lives. PD_ERR_ARGUMENT with file:line: a name that is reserved or a
 * unit, fractional exponents, more than PDI_READ_CONSTANTS_MAX. PD_ERR_PARSE with file:line: no constant expression. */
PDI_FN pd_status pdi_read_constants_read(pd_ctx *ctx, pd_text *text, pdi_read_constants_table *named);
/* Append a constant of the program (Cs, Csat, T, ...) with its value in SI to the named constants and to those that
 * `text` knows; the strings `name` and `unit` must live as long. At most PDI_READ_CONSTANTS_EXTRA of them: more is a
 * fault of the caller, which an assertion catches. */
PDI_FN void pdi_read_constants_add_builtin(pd_text *text, pdi_read_constants_table *named, const char *name,
                                           const char *unit, double value);
/* SI unit of a dimension as expressions parse it, into unit[PD_UNITS_TEXT]; "" for a plain number. 1: done; 0: the text
 * does not give the same dimension again, since its exponents are too fractional. */
PDI_FN int pdi_read_constants_format_unit(pd_ctx *ctx, const pd_dims *dims, char *unit);
/* 1: the name is reserved: t, x, y, z, C, Cs, Csat, rho_m, M_m, z_m, or a function or constant of expressions. */
PDI_FN int pdi_read_constants_is_reserved(const char *name);
#endif

#endif
