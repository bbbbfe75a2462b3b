/* expr: parser and evaluator of arithmetic expressions such as "1.3 um/h * (1 - C/Csat)", checked for physical
 * dimensions and compiled to code of a stack machine.
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
#include "setup/units.h"
#include "core/monotone_cubic.h"

#define PD_EXPR_VARS 32     /* variables of one expression */
#define PD_EXPR_LENGTH 4096 /* [byte] of its text */
#define PD_EXPR_NESTING 64  /* levels of parentheses */
#define PD_EXPR_CODE 1024   /* instructions */

/* A named variable or constant with its dimension. */
typedef struct pd_expr_symbol {
    const char *name;
    const char *unit; /* gives the dimension, for example "m/s"; "" is a plain number */
    double value;     /* [unit of that dimension in SI] of a constant; not read for a variable */
} pd_expr_symbol;

/* A tabulated function of one argument that expressions can call. */
typedef struct pd_expr_table {
    const char *name;         /* an identifier that is no function above */
    pd_dims argument, result;
    const pd_monotone_cubic *curve; /* of SI values */
} pd_expr_table;

/* What to compile: text, symbols, expected dimension, location for messages. */
typedef struct pd_expr_desc {
    const char *text;
    const pd_expr_symbol *vars; /* the values that pd_expr_eval gets, in this order */
    int var_count;
    const pd_expr_symbol *consts;
    int const_count;
    const pd_expr_table *tables; /* borrowed as long as the expression lives */
    int table_count;
    const char *unit;  /* dimension of the result, also "mm/year" for a speed; NULL: any */
    int allow_bare;    /* 1: a number without unit is taken as SI of that dimension */
    const char *location; /* location at the start of messages; NULL: "expr" */
    int column;        /* of the first character of text in messages; 0: 1 */
} pd_expr_desc;

/* User function in place of an expression: its value for the variables vars, all in SI. Must be thread safe. */
typedef double (*pd_expr_fn)(void *user, const double *vars);

/* A compiled expression, or a user function in its place. */
typedef struct pd_expr {
    int32_t *code; /* [code_count] operation, and for operands 256 times the index */
    double *value; /* [value_count] constants [unit of each in SI] */
    int code_count, value_count;
    uint32_t variables_used; /* bit k: depends on variable k */
    pd_dims dims;  /* of the result; that of desc.unit when it was given */
    const pd_expr_table *tables; /* those of desc */
    pd_expr_fn fn; /* user function in place of the code; NULL: none */
    void *user;
    /* [discontinuity_count] [-] values of variable time_variable at which fn is discontinuous, ascending */
    double *discontinuities;
    int discontinuity_count, time_variable;
} pd_expr;

#define pd_expr_build PD_NAME(pd_expr_build)
#define pd_expr_eval PD_NAME(pd_expr_eval)
#define pd_expr_free PD_NAME(pd_expr_free)
#define pd_expr_get_table_range PD_NAME(pd_expr_get_table_range)
#define pd_expr_is_constant PD_NAME(pd_expr_is_constant)
#define pd_expr_is_reserved PD_NAME(pd_expr_is_reserved)
#define pd_expr_quote_token PD_NAME(pd_expr_quote_token)

/* Parse and compile an expression, which pd_expr_free frees; on failure it is zero. PD_ERR_PARSE: syntax error, unknown
 * name, inconsistent or wrong dimension, more than PD_EXPR_LENGTH characters or PD_EXPR_CODE instructions, or a
 * constant that is not finite; the message has the column, what stands there and what was expected. PD_ERR_ARGUMENT:
 * text is NULL, a unit of the desc is invalid, or there are too many variables. */
PD_API pd_status pd_expr_build(pd_ctx *ctx, const pd_expr_desc *desc, pd_expr *expr);
/* Free code, constants and discontinuities and zero the expression, a user function, too. A zeroed one is allowed. */
PD_API void pd_expr_free(pd_ctx *ctx, pd_expr *expr);
/* Evaluate the expression for the variables vars[var_count] in SI; result in SI. Reads only, so threads may share
 * the expression. The result may be NaN or infinite where the mathematics is; an expression that was never built
 * gives NaN. */
PD_API double pd_expr_eval(const pd_expr *expr, const double *vars);
/* 1: the expression depends on no variable; pd_expr_eval may then get NULL. */
PD_API int pd_expr_is_constant(const pd_expr *expr);
/* range[2]: intersection of the ranges of points of all tables whose argument is variable `var` itself; outside one is
 * extrapolated by its end value. Tables with nan_outside do not count. -HUGE_VAL .. HUGE_VAL: no such table. */
PD_API void pd_expr_get_table_range(const pd_expr *expr, int var, double *range);
/* Quote the token at `found` for a message into text[PD_UNITS_TEXT]: a word (40 bytes at most), digits (20 at most),
 * else one character or two as <=: 'word', '+'. A control character or a byte >= 0x7f gives byte 0x07; the end of text
 * or line: the end. In a word, bytes that are no UTF-8 letter of two or three bytes become ?. */
PD_API void pd_expr_quote_token(const char *found, char *text);
/* 1: the name is reserved, a function or a built-in constant of expressions. */
PD_API int pd_expr_is_reserved(const char *name);
#ifdef PDI_INTERNAL
/* ---- the stack machine ---- */

#define PDI_EXPR_STACK_SIZE 64 /* depth of the operand stack */

/* How a function treats the dimensions of its operands. */
typedef enum pdi_expr_dims_rule {
    PDI_EXPR_RULE_DIMENSIONLESS, /* operand and result dimensionless */
    PDI_EXPR_RULE_KEEP,          /* result has the dimension of the operand */
    PDI_EXPR_RULE_SQRT,          /* square root: result has half the exponents */
    PDI_EXPR_RULE_SAME,          /* operands of one dimension, result too */
    PDI_EXPR_RULE_RATIO,         /* operands of one dimension, result dimensionless */
    PDI_EXPR_RULE_POWER,         /* exponents of the base times the exponent */
    PDI_EXPR_RULE_CHOICE         /* condition dimensionless, two branches of one dimension */
} pdi_expr_dims_rule;

/* X(name, operands, rule, value of the operands a[0], a[1], a[2]) */
#define PDI_EXPR_FUNCTIONS(X) \
    X(sin, 1, PDI_EXPR_RULE_DIMENSIONLESS, sin(a[0])) \
    X(cos, 1, PDI_EXPR_RULE_DIMENSIONLESS, cos(a[0])) \
    X(tan, 1, PDI_EXPR_RULE_DIMENSIONLESS, tan(a[0])) \
    X(exp, 1, PDI_EXPR_RULE_DIMENSIONLESS, exp(a[0])) \
    X(log, 1, PDI_EXPR_RULE_DIMENSIONLESS, log(a[0])) \
    X(log10, 1, PDI_EXPR_RULE_DIMENSIONLESS, log10(a[0])) \
    X(tanh, 1, PDI_EXPR_RULE_DIMENSIONLESS, tanh(a[0])) \
    X(sinh, 1, PDI_EXPR_RULE_DIMENSIONLESS, sinh(a[0])) \
    X(cosh, 1, PDI_EXPR_RULE_DIMENSIONLESS, cosh(a[0])) \
    X(atan, 1, PDI_EXPR_RULE_DIMENSIONLESS, atan(a[0])) \
    X(erf, 1, PDI_EXPR_RULE_DIMENSIONLESS, erf(a[0])) \
    X(floor, 1, PDI_EXPR_RULE_DIMENSIONLESS, floor(a[0])) \
    X(abs, 1, PDI_EXPR_RULE_KEEP, fabs(a[0])) \
    X(sqrt, 1, PDI_EXPR_RULE_SQRT, sqrt(a[0])) \
    X(min, 2, PDI_EXPR_RULE_SAME, a[1] < a[0] || a[1] != a[1] ? a[1] : a[0]) \
    X(max, 2, PDI_EXPR_RULE_SAME, a[1] > a[0] || a[1] != a[1] ? a[1] : a[0]) \
    X(atan2, 2, PDI_EXPR_RULE_RATIO, atan2(a[0], a[1])) \
    X(pow, 2, PDI_EXPR_RULE_POWER, pow(a[0], a[1])) \
    X(if, 3, PDI_EXPR_RULE_CHOICE, a[0] != 0 ? a[1] : a[2])

/* Instructions: operators, then the functions in the order of PDI_EXPR_FUNCTIONS. */
typedef enum pdi_expr_op {
    PDI_EXPR_CONST,
    PDI_EXPR_VAR,
    PDI_EXPR_TABLE,
    PDI_EXPR_NEG,
    PDI_EXPR_ADD,
    PDI_EXPR_SUB,
    PDI_EXPR_MUL,
    PDI_EXPR_DIV,
    PDI_EXPR_LT,
    PDI_EXPR_GT,
    PDI_EXPR_LE,
    PDI_EXPR_GE,
    PDI_EXPR_FIRST_FUNCTION,
    PDI_EXPR_BEFORE_FUNCTIONS = PDI_EXPR_FIRST_FUNCTION - 1,
#define PDI_X(name, operands, rule, value) PDI_EXPR_OP_##name,
    PDI_EXPR_FUNCTIONS(PDI_X)
#undef PDI_X
        PDI_EXPR_OP_COUNT
} pdi_expr_op;

/* Number of operands of an instruction (operator, function or table); not for constants and variables. */
PDI_FN int pdi_expr_count_operands(int op);
/* Result of an operator or function for the operands a[]; NaN for constants, variables and tables. Comparisons give 1
 * or 0, 0 with NaN; min and max pass NaN on. */
PDI_FN double pdi_expr_apply_op(int op, const double *a);
#endif

#endif
