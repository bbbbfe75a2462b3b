/* expr: expressions such as "1.3 um/h * (1 - C/Csat)", checked for dimensions and compiled to a small stack code.
 *
 * Grammar, loosest first: a < b (also > <= >=; 1 or 0, no chains); + and -; * and /; unary minus; ^ (from the right).
 * Primaries: number [unit], name, [H+] where that is declared, function(...), (...). A number that a unit follows at
 * once is scaled to SI; a unit may also follow a '/' ("0.5*x/s"). A declared name wins over a unit of the same name.
 * The literal 0 fits any dimension. Functions: sin cos tan exp log log10 tanh sinh cosh atan erf floor (of plain
 * numbers), abs sqrt min max atan2 pow and if(condition, then, otherwise). min and max pass NaN on. Tables of the
 * caller are functions of one argument. Built-in constants, unless shadowed: pi, R [J/mol/K], F [C/mol] (CODATA 2018).
 */
#ifndef PD_EXPR_H
#define PD_EXPR_H
#include "scene/units.h"
#include "core/curve.h"

#define PD_EXPR_VARS 32     /* variables of one expression */
#define PD_EXPR_LENGTH 4096 /* [byte] of its text */
#define PD_EXPR_NESTING 64  /* levels of parentheses */
#define PD_EXPR_CODE 1024   /* instructions */

typedef struct pd_expr_symbol {
    const char *name;
    const char *unit; /* gives the dimension, for example "m/s"; "" is a plain number */
    double value;     /* [unit of that dimension in SI] of a constant; not read for a variable */
} pd_expr_symbol;

/* A function through points. */
typedef struct pd_expr_table {
    const char *name;         /* an identifier that is no function above */
    pd_dims argument, result;
    const pd_curve *curve;    /* of SI values */
} pd_expr_table;

typedef struct pd_expr_desc {
    const char *text;
    const pd_expr_symbol *vars; /* the values that pdi_expr_eval gets, in this order */
    int var_count;
    const pd_expr_symbol *consts;
    int const_count;
    const pd_expr_table *tables; /* borrowed as long as the expression lives */
    int table_count;
    const char *unit;  /* dimension of the result, also "mm/year" for a speed; NULL: any */
    int allow_bare;    /* 1: a plain number is taken as SI of that dimension */
    const char *where; /* start of messages; NULL: "expr" */
    int column;        /* of the first character of text in messages; 0: 1 */
} pd_expr_desc;

/* A function of the caller in the place of an expression: its value for the variables, all in SI. Several threads may
 * ask at a time. */
typedef double (*pd_expr_fn)(void *user, const double *vars);

typedef struct pd_expr {
    int32_t *code; /* [code_count] operation, and for operands 256 times the index */
    double *value; /* [value_count] constants [unit of each in SI] */
    int code_count, value_count;
    uint32_t uses; /* bit k: depends on variable k */
    pd_dims dims;  /* of the result; that of desc.unit when it was given */
    const pd_expr_table *tables; /* those of desc */
    pd_expr_fn fn; /* in the place of the code; NULL: none */
    void *user;
} pd_expr;

#ifdef PDI_INTERNAL
/* Compile. PD_ERR_PARSE: the text does not follow the grammar, names something unknown, mixes dimensions, has not the
 * dimension asked for, or is a constant that is not finite; the message has the column, what stands there and what
 * was expected.
 * PD_ERR_ARGUMENT: a unit of the desc is no unit, or too many variables. */
PDI_FN pd_status pdi_expr_build(pd_ctx *ctx, const pd_expr_desc *desc, pd_expr *expr);
PDI_FN void pdi_expr_free(pd_ctx *ctx, pd_expr *expr);
/* Value in SI for the variables vars[var_count] in SI. Reads only, so threads may share the expression. The result may
 * be NaN or infinite where the mathematics is; the caller checks. An expression that was never built gives NaN. */
PDI_FN double pdi_expr_eval(const pd_expr *expr, const double *vars);
/* 1 when the value depends on no variable; vars may then be NULL. */
PDI_FN int pdi_expr_constant(const pd_expr *expr);

/* Write what stands at text for a message: 'word', '+', byte 0x07, the end. text gets PD_UNITS_TEXT bytes. */
PDI_FN void pdi_expr_quote(const char *found, char *text);
/* 1 when the name is a function or a built-in constant. */
PDI_FN int pdi_expr_taken(const char *name);
#endif

#endif
