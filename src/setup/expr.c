/* expr: see expr.h. Recursive descent parser that emits stack code directly, with constant folding: a constant
 * expression becomes one instruction. */
#include "setup/expr.h"
#include "core/vec.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Name, number of operands and dimension rule of a built-in function. */
typedef struct pdi_expr_function {
    const char *name;
    int operands;
    pdi_expr_dims_rule rule;
} pdi_expr_function;

static const pdi_expr_function pdi_expr_functions[] = {
#define PDI_X(name, operands, rule, value) {#name, operands, rule},
    PDI_EXPR_FUNCTIONS(PDI_X)
#undef PDI_X
};

static const pd_expr_symbol pdi_expr_builtins[] = {
    {"pi", "", PD_PI}, {"R", "J/mol/K", PD_GAS_CONSTANT}, {"F", "C/mol", PD_FARADAY}};

#define PDI_EXPR_BUILTIN_COUNT 3 /* pi, R, F */

/* Static type of a subexpression during compilation. */
typedef struct pdi_expr_type {
    pd_dims dims;
    int is_zero_literal; /* made of the literal 0 alone: fits any dimension */
    size_t start;        /* where it starts */
} pdi_expr_type;

/* State of the parser: position in the text, code and constants emitted so far. */
typedef struct pdi_expr_parser {
    pd_ctx *ctx;
    const pd_expr_desc *desc;
    const char *text;
    size_t position;
    int nesting, stack_depth;
    int code_count, value_count;
    uint32_t uses;
    int32_t code[PD_EXPR_CODE];
    double value[PD_EXPR_CODE];
} pdi_expr_parser;

static pd_status pdi_expr_parse_comparison(pdi_expr_parser *p, pdi_expr_type *type);
static pd_status pdi_expr_parse_unary(pdi_expr_parser *p, pdi_expr_type *type);

PDI_COLD_BEGIN
void pd_expr_quote_token(const char *found, char *text)
{
    size_t n = pd_units_scan_word(found);
    if (n > 40) n = 40;
    unsigned char c = (unsigned char)found[0];
    if (c == '\0' || c == '\n' || c == '\r') {
        snprintf(text, PD_UNITS_TEXT, "the end");
    } else if (c < 0x20 || c >= 0x7f) {
        snprintf(text, PD_UNITS_TEXT, "byte 0x%02x", (unsigned)c);
    } else {
        size_t k = 0;
        if (n == 0)
            while (n < 20 && (pd_units_is_digit(found[n]) || found[n] == '.')) n++;
        if (n == 0) n = found[1] == '=' && strchr("<>=!", c) ? 2 : 1;
        text[k++] = '\'';
        for (size_t i = 0; i < n;) { /* letters of UTF-8 as they are, whole ones */
            unsigned char lead = (unsigned char)found[i];
            size_t size = lead < 0x80 ? 1 : lead >= 0xC2 && lead < 0xE0 ? 2 : lead >= 0xE0 && lead < 0xF0 ? 3 : 0;
            for (size_t b = 1; b < size; b++)
                if (((unsigned char)found[i + b] & 0xC0) != 0x80) size = 0;
            if (!size) text[k++] = '?';
            for (size_t b = 0; b < size; b++) text[k++] = found[i + b];
            i += size ? size : 1;
        }
        text[k++] = '\'';
        text[k] = '\0';
    }
}

static pd_status pdi_expr_fail(pdi_expr_parser *p, size_t at, const char *format, ...) PD_PRINTF_LIKE(3, 4);

/* PD_ERR_PARSE with the column of text[at], printf style. */
static pd_status pdi_expr_fail(pdi_expr_parser *p, size_t at, const char *format, ...)
{
    char message[PD_MESSAGE_SIZE];
    int column = (p->desc->column > 0 ? p->desc->column : 1) + (int)at;
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    return pd_fail(p->ctx, PD_ERR_PARSE, p->desc->location ? p->desc->location : "expr", "column %d: %s", column,
                   message);
}

/* Report the token at the current position and what was expected. Returns PD_ERR_PARSE. */
static pd_status pdi_expr_fail_unexpected(pdi_expr_parser *p, const char *expected)
{
    char found[PD_UNITS_TEXT];
    pd_expr_quote_token(p->text + p->position, found);
    return pdi_expr_fail(p, p->position, "found %s, expected %s", found, expected);
}

/* Skip blanks and line ends. */
static void pdi_expr_skip_blanks(pdi_expr_parser *p)
{
    while (pd_units_is_blank(p->text[p->position]) || p->text[p->position] == '\n') p->position++;
}

/* 1: the subexpression is dimensionless (exponents within 1e-9), or the literal 0, which fits any dimension. */
static int pdi_expr_is_dimensionless(const pdi_expr_type *type)
{
    pd_dims none;
    memset(&none, 0, sizeof none);
    return type->is_zero_literal || pd_units_is_same(&type->dims, &none);
}
PDI_COLD_END

/* ---- code ---- */

PDI_FN double pdi_expr_apply_op(int op, const double *a)
{
    switch (op) {
    case PDI_EXPR_NEG: return -a[0];
    case PDI_EXPR_ADD: return a[0] + a[1];
    case PDI_EXPR_SUB: return a[0] - a[1];
    case PDI_EXPR_MUL: return a[0] * a[1];
    case PDI_EXPR_DIV: return a[0] / a[1];
    case PDI_EXPR_LT: return a[0] < a[1];
    case PDI_EXPR_GT: return a[0] > a[1];
    case PDI_EXPR_LE: return a[0] <= a[1];
    case PDI_EXPR_GE: return a[0] >= a[1];
#define PDI_X(name, operands, rule, value) \
    case PDI_EXPR_OP_##name: return value;
        PDI_EXPR_FUNCTIONS(PDI_X)
#undef PDI_X
    default: return NAN;
    }
}

PDI_FN int pdi_expr_count_operands(int op)
{
    if (op >= PDI_EXPR_FIRST_FUNCTION) return pdi_expr_functions[op - PDI_EXPR_FIRST_FUNCTION].operands;
    return op == PDI_EXPR_NEG || op == PDI_EXPR_TABLE ? 1 : 2;
}

PDI_COLD_BEGIN
/* Emit an instruction that pushes one operand; index: of the constant, variable or table. PD_ERR_PARSE: more than
 * PD_EXPR_CODE instructions or PDI_EXPR_STACK_SIZE operands. */
static pd_status pdi_expr_emit_push(pdi_expr_parser *p, int op, int index)
{
    if (p->code_count >= PD_EXPR_CODE)
        return pdi_expr_fail(p, p->position, "the expression needs more than %d instructions", PD_EXPR_CODE);
    if (++p->stack_depth > PDI_EXPR_STACK_SIZE)
        return pdi_expr_fail(p, p->position, "more than %d operands wait for their operator", PDI_EXPR_STACK_SIZE);
    p->code[p->code_count++] = op | index << 8;
    return PD_OK;
}

/* Emit an instruction that pushes a constant. */
static pd_status pdi_expr_emit_const(pdi_expr_parser *p, double value)
{
    PD_TRY(pdi_expr_emit_push(p, PDI_EXPR_CONST, p->value_count));
    p->value[p->value_count++] = value;
    return PD_OK;
}

/* 1: the instruction `back` places before the end of the code loads a constant. */
static int pdi_expr_is_constant_operand(const pdi_expr_parser *p, int back)
{
    return p->code_count >= back && (p->code[p->code_count - back] & 255) == PDI_EXPR_CONST;
}
PDI_COLD_END

/* Value of a table at x, both in SI. */
static double pdi_expr_eval_table(const pd_expr_table *table, double x)
{
    return pdi_monotone_cubic_evaluate(table->curve, x);
}

PDI_COLD_BEGIN
/* Emit an operation on the topmost operands, which its result replaces; if they are all constants, it is evaluated now
 * and a constant emitted in place of them. index: of the table, else 0. */
static pd_status pdi_expr_emit_indexed(pdi_expr_parser *p, int op, int index)
{
    int n = pdi_expr_count_operands(op), fold = 1;
    for (int k = 1; k <= n; k++) fold = fold && pdi_expr_is_constant_operand(p, k);
    p->stack_depth -= n;
    if (fold) { /* operands of constants lie in order at the end of value[] */
        p->code_count -= n;
        p->value_count -= n;
        const double *a = p->value + p->value_count;
        return pdi_expr_emit_const(p, op == PDI_EXPR_TABLE ? pdi_expr_eval_table(&p->desc->tables[index], *a)
                                                           : pdi_expr_apply_op(op, a));
    }
    return pdi_expr_emit_push(p, op, index);
}

/* Emit an operator or function on the topmost operands; folds it if they are all constants. */
static pd_status pdi_expr_emit(pdi_expr_parser *p, int op) { return pdi_expr_emit_indexed(p, op, 0); }

/* ---- dimensions ---- */

/* Check that a and b have one dimension, or one is the literal 0; *a becomes that of both. PD_ERR_PARSE: they differ.
 * `what` names the construct in the message: "on the left of '+'". */
static pd_status pdi_expr_check_same_dims(pdi_expr_parser *p, pdi_expr_type *a, const pdi_expr_type *b,
                                          const char *what)
{
    char left[PD_UNITS_TEXT], right[PD_UNITS_TEXT];
    if (a->is_zero_literal) {
        a->dims = b->dims;
        a->is_zero_literal = b->is_zero_literal;
        return PD_OK;
    }
    if (b->is_zero_literal || pd_units_is_same(&a->dims, &b->dims)) return PD_OK;
    pd_units_describe(&a->dims, left);
    pd_units_describe(&b->dims, right);
    return pdi_expr_fail(p, b->start, "found %s, expected %s as %s", right, left, what);
}

/* Check that a subexpression is dimensionless or the literal 0. PD_ERR_PARSE: it is not; `what` names it in the
 * message: "an exponent". */
static pd_status pdi_expr_check_dimensionless(pdi_expr_parser *p, const pdi_expr_type *type, const char *what)
{
    char found[PD_UNITS_TEXT];
    if (pdi_expr_is_dimensionless(type)) return PD_OK;
    pd_units_describe(&type->dims, found);
    return pdi_expr_fail(p, type->start, "found %s, expected a plain number as %s", found, what);
}

/* Set the type of a subexpression to dimensionless. */
static void pdi_expr_set_dimensionless(pdi_expr_type *type)
{
    memset(&type->dims, 0, sizeof type->dims);
    type->is_zero_literal = 0;
}

/* Dimension of base^exponent into *base. PD_ERR_PARSE: the exponent has a dimension, or the base has one and the last
 * instruction is no constant. To be called when the exponent is compiled and pow is not yet emitted. */
static pd_status pdi_expr_compute_power_dims(pdi_expr_parser *p, pdi_expr_type *base, const pdi_expr_type *exponent)
{
    PD_TRY(pdi_expr_check_dimensionless(p, exponent, "an exponent"));
    if (pdi_expr_is_dimensionless(base)) {
        pdi_expr_set_dimensionless(base);
        return PD_OK;
    }
    if (!pdi_expr_is_constant_operand(p, 1))
        return pdi_expr_fail(p, exponent->start, "the base has a dimension, so the exponent must be a constant");
    for (int k = 0; k < 6; k++) base->dims.exponent[k] *= p->value[p->value_count - 1];
    return PD_OK;
}

/* Dimension of a*b (sign 1) or a/b (sign -1) into *a. It stays a literal 0 if a is one, or in a product if b is. */
static void pdi_expr_compute_product_dims(pdi_expr_type *a, const pdi_expr_type *b, double sign)
{
    a->is_zero_literal = a->is_zero_literal || (b->is_zero_literal && sign > 0);
    for (int k = 0; k < 6; k++) a->dims.exponent[k] += sign * b->dims.exponent[k];
}

/* ---- names ---- */

/* Index of the symbol named word[size]; -1: none. */
static int pdi_expr_find_symbol(const pd_expr_symbol *symbols, int count, const char *word, size_t size)
{
    for (int k = 0; k < count; k++)
        if (strlen(symbols[k].name) == size && memcmp(symbols[k].name, word, size) == 0) return k;
    return -1;
}

/* Index of the built-in function word[size]; -1: none. */
static int pdi_expr_find_function(const char *word, size_t size)
{
    for (int k = 0; k < PDI_EXPR_OP_COUNT - PDI_EXPR_FIRST_FUNCTION; k++)
        if (strlen(pdi_expr_functions[k].name) == size && memcmp(pdi_expr_functions[k].name, word, size) == 0) return k;
    return -1;
}

/* Index of the table word[size]; -1: none. */
static int pdi_expr_find_table(const pd_expr_desc *desc, const char *word, size_t size)
{
    for (int k = 0; k < desc->table_count; k++)
        if (strlen(desc->tables[k].name) == size && memcmp(desc->tables[k].name, word, size) == 0) return k;
    return -1;
}

int pd_expr_is_reserved(const char *name)
{
    size_t size = strlen(name);
    return pdi_expr_find_function(name, size) >= 0 ||
           pdi_expr_find_symbol(pdi_expr_builtins, PDI_EXPR_BUILTIN_COUNT, name, size) >= 0;
}

/* 1: word[size] is a function or a table, and a parenthesis follows, with blanks before it allowed: "15 min" is a
 * time. */
static int pdi_expr_is_call(const pd_expr_desc *desc, const char *word, size_t size)
{
    size_t next = size;
    while (pd_units_is_blank(word[next])) next++;
    return word[next] == '(' && (pdi_expr_find_function(word, size) >= 0 || pdi_expr_find_table(desc, word, size) >= 0);
}

/* 1: word[size] is a variable, constant or function call, and so no unit. user: the pd_expr_desc. */
static int pdi_expr_is_declared(const void *user, const char *word, size_t size)
{
    const pd_expr_desc *desc = (const pd_expr_desc *)user;
    return pdi_expr_find_symbol(desc->vars, desc->var_count, word, size) >= 0 ||
           pdi_expr_find_symbol(desc->consts, desc->const_count, word, size) >= 0 ||
           pdi_expr_find_symbol(pdi_expr_builtins, PDI_EXPR_BUILTIN_COUNT, word, size) >= 0 ||
           pdi_expr_is_call(desc, word, size);
}

/* Report a variable (C, t, x, y, z) that has no value in this expression; lists the first eight that have. Returns
 * PD_ERR_PARSE. */
static pd_status pdi_expr_fail_no_value(pdi_expr_parser *p, const char *found)
{
    char list[PD_UNITS_TEXT] = "";
    for (int k = 0; k < p->desc->var_count && k < 8; k++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%.8s", k ? ", " : "", p->desc->vars[k].name);
    if (!list[0])
        return pdi_expr_fail(p, p->position, "found %s, expected a constant: no variable has a value here", found);
    return pdi_expr_fail(p, p->position, "found %s, expected one of %s: other variables have no value here", found,
                         list);
}

/* Report an unknown name of `size` bytes at the current position: a species, a variable without value, a unit without
 * number, a function without parenthesis, else with the nearest known name. as_unit: 1: it stands behind a number, and
 * units are candidates, too. Returns PD_ERR_PARSE. */
static pd_status pdi_expr_fail_unknown(pdi_expr_parser *p, size_t size, int as_unit)
{
    const pd_expr_desc *desc = p->desc;
    const char *word = p->text + p->position;
    char found[PD_UNITS_TEXT], hint[PD_UNITS_TEXT];
    pd_units_product unit;
    const char *why;
    pd_units_suggestion near_word;
    pd_expr_quote_token(word, found);
    if (*word == '[')
        return pdi_expr_fail(p, p->position,
                             "found %.*s, expected none here: laws of the speed of metal alone know species",
                             (int)(size < 40 ? size : 40), word);
    if (!as_unit && size == 1 && strchr("Ctxyz", *word) && (desc->var_count > 0 || *word != 'C'))
        return pdi_expr_fail_no_value(p, found);
    if (!as_unit && pd_units_scan_product(word, pdi_expr_is_declared, desc, &unit, &why) > 0)
        return pdi_expr_fail(p, p->position, "found the unit %s, expected a number before it", found);
    if (pdi_expr_find_function(word, size) >= 0 || pdi_expr_find_table(desc, word, size) >= 0)
        return pdi_expr_fail(p, p->position, "found the function %s, expected '(' after it", found);
    pd_units_init_suggestion(&near_word, word, size);
    for (int k = 0; k < desc->var_count; k++) pd_units_try_candidate(&near_word, desc->vars[k].name);
    for (int k = 0; k < desc->const_count; k++) pd_units_try_candidate(&near_word, desc->consts[k].name);
    for (int k = 0; k < PDI_EXPR_OP_COUNT - PDI_EXPR_FIRST_FUNCTION; k++)
        pd_units_try_candidate(&near_word, pdi_expr_functions[k].name);
    for (int k = 0; k < desc->table_count; k++) pd_units_try_candidate(&near_word, desc->tables[k].name);
    if (as_unit) pdi_units_try_units(&near_word);
    pd_units_format_suggestion(&near_word, hint);
    return pdi_expr_fail(p, p->position, "found %s, expected %s%s", found,
                         as_unit ? "a unit or an operator" : "a known variable, constant or function", hint);
}

/* Dimension of a declared symbol from its unit; NULL: dimensionless. PD_ERR_ARGUMENT: the declared unit is no unit. */
static pd_status pdi_expr_get_symbol_dims(pdi_expr_parser *p, const pd_expr_symbol *symbol, pd_dims *dims)
{
    if (pd_units_parse(p->ctx, symbol->unit ? symbol->unit : "", NULL, dims) == PD_OK) return PD_OK;
    return pd_fail(p->ctx, PD_ERR_ARGUMENT, "expr", "the symbol '%.40s' was declared with the unit '%.40s', expected"
                   " a unit such as m/s", symbol->name, symbol->unit);
}

/* ---- grammar ---- */

/* Parse a decimal number without sign; independent of the locale, since strtod gets digits and an exponent without
 * decimal point. An e without digits behind it is not part of it. PD_ERR_PARSE: no digit, more than 80 digits behind
 * leading zeros, or a number above 1e308; one that is too small becomes 0. */
static pd_status pdi_expr_parse_digits(pdi_expr_parser *p, double *value)
{
    char digits[80 + 16];
    const char *t = p->text;
    size_t start = p->position, at = start, n = 0;
    long exponent = 0, shift = 0;
    int point = 0, any = 0;
    for (; pd_units_is_digit(t[at]) || (t[at] == '.' && !point); at++) {
        if (t[at] == '.') {
            point = 1;
            continue;
        }
        any = 1;
        if (n >= 80) return pdi_expr_fail(p, start, "found a number of more than 80 digits, expected fewer");
        if (n > 0 || t[at] != '0') digits[n++] = t[at];
        shift -= point;
    }
    if (!any) return pdi_expr_fail_unexpected(p, "a number");
    if (t[at] == 'e' || t[at] == 'E') {
        size_t sign = t[at + 1] == '-' || t[at + 1] == '+';
        if (pd_units_is_digit(t[at + 1 + sign])) {
            int minus = t[at + 1] == '-';
            for (at += 1 + sign; pd_units_is_digit(t[at]); at++)
                if (exponent < 100000) exponent = 10 * exponent + (t[at] - '0');
            if (minus) exponent = -exponent;
        }
    }
    if (n == 0) digits[n++] = '0';
    snprintf(digits + n, sizeof digits - n, "e%ld", exponent + shift);
    *value = strtod(digits, NULL);
    if (!(*value <= 1e308)) return pdi_expr_fail(p, start, "found a number above 1e308, expected a smaller one");
    p->position = at;
    return PD_OK;
}

/* Grammar: number [unit]. Emits the number in SI; 0 without unit is the literal 0. A declared name behind it is left
 * for the caller. PD_ERR_PARSE: also for a word behind it that is neither unit nor name, and a unit that is
 * inadmissible. */
static pd_status pdi_expr_parse_number(pdi_expr_parser *p, pdi_expr_type *type)
{
    pd_units_product unit;
    const char *why;
    double value = 0;
    PD_TRY(pdi_expr_parse_digits(p, &value));
    size_t after = p->position;
    pdi_expr_skip_blanks(p);
    size_t n = pd_units_scan_product(p->text + p->position, pdi_expr_is_declared, p->desc, &unit, &why), word;
    if (why) return pdi_expr_fail(p, p->position + n, "%s", why);
    if (n > 0) {
        type->dims = unit.dims;
        p->position += n;
        return pdi_expr_emit_const(p, value * unit.num / unit.den);
    }
    word = pd_units_scan_word(p->text + p->position);
    if (word > 0 && !pdi_expr_is_declared(p->desc, p->text + p->position, word))
        return pdi_expr_fail_unknown(p, word, 1);
    p->position = after;
    type->is_zero_literal = value == 0;
    return pdi_expr_emit_const(p, value);
}

/* Count one level of nesting. PD_ERR_PARSE: too deep. */
static pd_status pdi_expr_begin_nesting(pdi_expr_parser *p)
{
    if (++p->nesting > PD_EXPR_NESTING)
        return pdi_expr_fail(p, p->position, "the expression is nested deeper than %d levels", PD_EXPR_NESTING);
    return PD_OK;
}

/* Skip blanks, expect ')' and leave one level of nesting. PD_ERR_PARSE: something else stands there; `expected` names
 * what could. */
static pd_status pdi_expr_parse_close(pdi_expr_parser *p, const char *expected)
{
    pdi_expr_skip_blanks(p);
    if (p->text[p->position] != ')') return pdi_expr_fail_unexpected(p, expected);
    p->position++;
    p->nesting--;
    return PD_OK;
}

/* Grammar: table(argument). size: length of the name. PD_ERR_PARSE: the argument has another dimension than that of the
 * table, and is not the literal 0. */
static pd_status pdi_expr_parse_table_call(pdi_expr_parser *p, size_t size, int index, pdi_expr_type *type)
{
    const pd_expr_table *table = &p->desc->tables[index];
    char what[PD_UNITS_TEXT], found[PD_UNITS_TEXT], expected[PD_UNITS_TEXT];
    size_t start = p->position;
    p->position += size;
    pdi_expr_skip_blanks(p);
    p->position++;
    PD_TRY(pdi_expr_begin_nesting(p));
    PD_TRY(pdi_expr_parse_comparison(p, type));
    if (!type->is_zero_literal && !pd_units_is_same(&type->dims, &table->argument)) {
        pd_units_describe(&type->dims, found);
        pd_units_describe(&table->argument, expected);
        return pdi_expr_fail(p, type->start, "found %s, expected %s as the argument of %.40s", found, expected,
                             table->name);
    }
    snprintf(what, sizeof what, "')' (%.40s takes 1 argument)", table->name);
    PD_TRY(pdi_expr_parse_close(p, what));
    type->dims = table->result;
    type->is_zero_literal = 0;
    type->start = start;
    return pdi_expr_emit_indexed(p, PDI_EXPR_TABLE, index);
}

/* Grammar: function(argument, ...) or table(argument), with the dimension rule of the function. size: length of the
 * name. PD_ERR_PARSE: another number of arguments, or dimensions that the rule refuses. */
static pd_status pdi_expr_parse_call(pdi_expr_parser *p, size_t size, pdi_expr_type *type)
{
    int index = pdi_expr_find_function(p->text + p->position, size);
    if (index < 0)
        return pdi_expr_parse_table_call(p, size, pdi_expr_find_table(p->desc, p->text + p->position, size), type);
    const pdi_expr_function *f = &pdi_expr_functions[index];
    pdi_expr_type arg[3];
    char what[PD_UNITS_TEXT];
    size_t start = p->position;
    p->position += size;
    pdi_expr_skip_blanks(p);
    p->position++;
    PD_TRY(pdi_expr_begin_nesting(p));
    snprintf(what, sizeof what, "the argument of %s", f->name);
    for (int k = 0; k < f->operands; k++) {
        PD_TRY(pdi_expr_parse_comparison(p, &arg[k]));
        if (f->rule == PDI_EXPR_RULE_DIMENSIONLESS || (f->rule == PDI_EXPR_RULE_CHOICE && k == 0))
            PD_TRY(pdi_expr_check_dimensionless(p, &arg[k], what));
        pdi_expr_skip_blanks(p);
        if (k + 1 == f->operands) break;
        if (p->text[p->position] != ',') {
            snprintf(what, sizeof what, "',' (%s takes %d arguments)", f->name, f->operands);
            return pdi_expr_fail_unexpected(p, what);
        }
        p->position++;
    }
    snprintf(what, sizeof what, "')' (%s takes %d argument%s)", f->name, f->operands, f->operands > 1 ? "s" : "");
    PD_TRY(pdi_expr_parse_close(p, what));
    snprintf(what, sizeof what, "in the other branch of %s", f->name);
    *type = arg[0];
    switch (f->rule) {
    case PDI_EXPR_RULE_DIMENSIONLESS: pdi_expr_set_dimensionless(type); break;
    case PDI_EXPR_RULE_KEEP: break;
    case PDI_EXPR_RULE_SQRT:
        for (int k = 0; k < 6; k++) type->dims.exponent[k] *= 0.5;
        break;
    case PDI_EXPR_RULE_POWER: PD_TRY(pdi_expr_compute_power_dims(p, type, &arg[1])); break;
    case PDI_EXPR_RULE_CHOICE:
        PD_TRY(pdi_expr_check_same_dims(p, &arg[1], &arg[2], what));
        *type = arg[1];
        break;
    case PDI_EXPR_RULE_SAME:
    case PDI_EXPR_RULE_RATIO:
        snprintf(what, sizeof what, "in the first argument of %s", f->name);
        PD_TRY(pdi_expr_check_same_dims(p, type, &arg[1], what));
        if (f->rule == PDI_EXPR_RULE_RATIO) pdi_expr_set_dimensionless(type);
        break;
    }
    type->start = start;
    return pdi_expr_emit(p, PDI_EXPR_FIRST_FUNCTION + index);
}

/* Grammar: a variable, constant or function call, looked up in this order, caller's constants before built-in ones.
 * size: length of the name. PD_ERR_PARSE: unknown; PD_ERR_ARGUMENT: its declared unit is none. */
static pd_status pdi_expr_parse_name(pdi_expr_parser *p, size_t size, pdi_expr_type *type)
{
    const pd_expr_desc *desc = p->desc;
    const char *word = p->text + p->position;
    const pd_expr_symbol *constant = NULL;
    int k = pdi_expr_find_symbol(desc->vars, desc->var_count, word, size);
    if (k >= 0) {
        p->position += size;
        p->uses |= (uint32_t)1 << k;
        PD_TRY(pdi_expr_get_symbol_dims(p, &desc->vars[k], &type->dims));
        return pdi_expr_emit_push(p, PDI_EXPR_VAR, k);
    }
    if ((k = pdi_expr_find_symbol(desc->consts, desc->const_count, word, size)) >= 0) constant = &desc->consts[k];
    else if ((k = pdi_expr_find_symbol(pdi_expr_builtins, PDI_EXPR_BUILTIN_COUNT, word, size)) >= 0)
        constant = &pdi_expr_builtins[k];
    if (constant) {
        p->position += size;
        PD_TRY(pdi_expr_get_symbol_dims(p, constant, &type->dims));
        return pdi_expr_emit_const(p, constant->value);
    }
    if (pdi_expr_is_call(desc, word, size)) return pdi_expr_parse_call(p, size, type);
    return pdi_expr_fail_unknown(p, size, 0);
}

/* Length of the species token [name] at the current position; 1 where the bracket is not closed. */
static size_t pdi_expr_scan_bracket(const pdi_expr_parser *p)
{
    const char *text = p->text + p->position, *close = strchr(text, ']');
    return close ? (size_t)(close - text) + 1 : 1;
}

/* Grammar: number, name, function call, [species] or parenthesised expression. */
static pd_status pdi_expr_parse_primary(pdi_expr_parser *p, pdi_expr_type *type)
{
    memset(type, 0, sizeof *type);
    pdi_expr_skip_blanks(p);
    char c = p->text[p->position];
    size_t word = pd_units_scan_word(p->text + p->position);
    type->start = p->position;
    if (word > 0) return pdi_expr_parse_name(p, word, type);
    if (c == '[') return pdi_expr_parse_name(p, pdi_expr_scan_bracket(p), type);
    if (pd_units_is_digit(c) || c == '.') return pdi_expr_parse_number(p, type);
    if (c != '(') return pdi_expr_fail_unexpected(p, "a number, a name or '('");
    p->position++;
    PD_TRY(pdi_expr_begin_nesting(p));
    PD_TRY(pdi_expr_parse_comparison(p, type));
    return pdi_expr_parse_close(p, "an operator or ')'");
}

/* Grammar: primary ^ unary, right associative; each ^ counts as a level of nesting. */
static pd_status pdi_expr_parse_power(pdi_expr_parser *p, pdi_expr_type *type)
{
    pdi_expr_type exponent;
    PD_TRY(pdi_expr_parse_primary(p, type));
    pdi_expr_skip_blanks(p);
    if (p->text[p->position] != '^') return PD_OK;
    p->position++;
    PD_TRY(pdi_expr_begin_nesting(p));
    PD_TRY(pdi_expr_parse_unary(p, &exponent));
    p->nesting--;
    PD_TRY(pdi_expr_compute_power_dims(p, type, &exponent));
    return pdi_expr_emit(p, PDI_EXPR_OP_pow);
}

/* Grammar: any number of signs before a power; they act after ^, so that -2^2 is -4. */
static pd_status pdi_expr_parse_unary(pdi_expr_parser *p, pdi_expr_type *type)
{
    int minus = 0;
    pdi_expr_skip_blanks(p);
    size_t start = p->position;
    for (; p->text[p->position] == '-' || p->text[p->position] == '+'; pdi_expr_skip_blanks(p))
        minus ^= p->text[p->position++] == '-';
    PD_TRY(pdi_expr_parse_power(p, type));
    type->start = start;
    return minus ? pdi_expr_emit(p, PDI_EXPR_NEG) : PD_OK;
}

/* Right operand of '/' if it is a unit ("x/s"), emitted as its size in SI; *read: 1 parsed, 0 it is no unit, and
 * nothing is emitted. PD_ERR_PARSE: an inadmissible unit. */
static pd_status pdi_expr_parse_divisor(pdi_expr_parser *p, pdi_expr_type *type, int *read)
{
    pd_units_product unit;
    const char *why;
    pdi_expr_skip_blanks(p);
    size_t n = pdi_units_scan_divisor(p->text + p->position, pdi_expr_is_declared, p->desc, &unit, &why);
    *read = n > 0;
    if (why) return pdi_expr_fail(p, p->position + n, "%s", why);
    if (n == 0) return PD_OK;
    memset(type, 0, sizeof *type);
    type->dims = unit.dims;
    type->start = p->position;
    p->position += n;
    return pdi_expr_emit_const(p, unit.num / unit.den);
}

/* Grammar: factors with * and /. */
static pd_status pdi_expr_parse_product(pdi_expr_parser *p, pdi_expr_type *type)
{
    pdi_expr_type right;
    PD_TRY(pdi_expr_parse_unary(p, type));
    for (;;) {
        int read = 0;
        pdi_expr_skip_blanks(p);
        char c = p->text[p->position];
        if (c != '*' && c != '/') return PD_OK;
        p->position++;
        if (c == '/') PD_TRY(pdi_expr_parse_divisor(p, &right, &read));
        if (!read) PD_TRY(pdi_expr_parse_unary(p, &right));
        pdi_expr_compute_product_dims(type, &right, c == '*' ? 1 : -1);
        PD_TRY(pdi_expr_emit(p, c == '*' ? PDI_EXPR_MUL : PDI_EXPR_DIV));
    }
}

/* Grammar: terms with + and -. */
static pd_status pdi_expr_parse_sum(pdi_expr_parser *p, pdi_expr_type *type)
{
    pdi_expr_type right;
    PD_TRY(pdi_expr_parse_product(p, type));
    for (;;) {
        pdi_expr_skip_blanks(p);
        char c = p->text[p->position];
        if (c != '+' && c != '-') return PD_OK;
        p->position++;
        PD_TRY(pdi_expr_parse_product(p, &right));
        PD_TRY(pdi_expr_check_same_dims(p, type, &right, c == '+' ? "on the left of '+'" : "on the left of '-'"));
        PD_TRY(pdi_expr_emit(p, c == '+' ? PDI_EXPR_ADD : PDI_EXPR_SUB));
    }
}

/* Grammar: sum, or one comparison (< > <= >=) of two sums of one dimension (1 or 0). The start symbol. PD_ERR_PARSE:
 * also for a second comparison. */
static pd_status pdi_expr_parse_comparison(pdi_expr_parser *p, pdi_expr_type *type)
{
    pdi_expr_type right;
    PD_TRY(pdi_expr_parse_sum(p, type));
    pdi_expr_skip_blanks(p);
    char c = p->text[p->position];
    if (c != '<' && c != '>') return PD_OK;
    int equal = p->text[p->position + 1] == '=';
    p->position += 1 + (size_t)equal;
    PD_TRY(pdi_expr_parse_sum(p, &right));
    PD_TRY(pdi_expr_check_same_dims(p, type, &right, "on the left of the comparison"));
    pdi_expr_set_dimensionless(type);
    PD_TRY(pdi_expr_emit(p, c == '<' ? (equal ? PDI_EXPR_LE : PDI_EXPR_LT) : (equal ? PDI_EXPR_GE : PDI_EXPR_GT)));
    pdi_expr_skip_blanks(p);
    if (p->text[p->position] == '<' || p->text[p->position] == '>')
        return pdi_expr_fail(p, p->position, "comparisons do not chain: write (a < b) * (b < c)");
    return PD_OK;
}

/* ---- result ---- */

/* Check the dimension of the whole expression against desc.unit (NULL: any), which becomes its type, and that an
 * expression folded to one constant is finite. Literal 0 fits, and with allow_bare a plain number. PD_ERR_PARSE;
 * PD_ERR_ARGUMENT: desc.unit is no unit. */
static pd_status pdi_expr_check_result(pdi_expr_parser *p, pdi_expr_type *type)
{
    char found[PD_UNITS_TEXT], expected[PD_UNITS_TEXT], units[PD_UNITS_TEXT];
    pd_dims dims;
    if (p->desc->unit) {
        if (pd_units_parse(p->ctx, p->desc->unit, NULL, &dims) < 0)
            return pd_fail(p->ctx, PD_ERR_ARGUMENT, "expr", "the expected unit '%.40s' is not a unit", p->desc->unit);
        if (!type->is_zero_literal && !pd_units_is_same(&type->dims, &dims)) {
            int plain = pdi_expr_is_dimensionless(type);
            pd_units_describe(&type->dims, found);
            pd_units_describe(&dims, expected);
            pdi_units_format_examples(&dims, units);
            if (plain && !p->desc->allow_bare)
                return pdi_expr_fail(p, type->start,
                                     "found a number without unit, expected %s: write its unit,"
                                     " for example %s",
                                     expected, units);
            if (!plain) return pdi_expr_fail(p, type->start, "found %s, expected %s", found, expected);
        }
        type->dims = dims;
    }
    if (p->code_count == 1 && pdi_expr_is_constant_operand(p, 1) && !(fabs(p->value[0]) <= 1.7976931348623157e308))
        return pdi_expr_fail(p, type->start, "the value is %s, expected a finite number",
                             p->value[0] != p->value[0] ? "not a number" : "infinite");
    return PD_OK;
}

/* Compile the whole text; *type: dimension of the result. PD_ERR_PARSE: also for more than PD_EXPR_LENGTH characters,
 * an empty text, or something behind the expression. */
static pd_status pdi_expr_compile(pdi_expr_parser *p, pdi_expr_type *type)
{
    size_t size = 0;
    while (size <= PD_EXPR_LENGTH && p->text[size]) size++;
    if (size > PD_EXPR_LENGTH)
        return pdi_expr_fail(p, 0, "the expression is longer than %d characters", PD_EXPR_LENGTH);
    PD_TRY(pdi_expr_parse_comparison(p, type));
    pdi_expr_skip_blanks(p);
    if (p->text[p->position] != '\0') return pdi_expr_fail_unexpected(p, "an operator or the end");
    return pdi_expr_check_result(p, type);
}

/* Copy code, constants, variables and dimension of the parser into the expression; allocates. On failure the caller
 * frees. */
static pd_status pdi_expr_copy_result(pd_ctx *ctx, const pdi_expr_parser *p, const pdi_expr_type *type, pd_expr *expr)
{
    expr->code_count = p->code_count;
    PD_TRY(PD_NEW(ctx, "expr", p->code_count, expr->code));
    expr->value_count = p->value_count;
    PD_TRY(PD_NEW(ctx, "expr", p->value_count, expr->value));
    memcpy(expr->code, p->code, (size_t)p->code_count * sizeof *p->code);
    memcpy(expr->value, p->value, (size_t)p->value_count * sizeof *p->value);
    expr->variables_used = p->uses;
    expr->dims = type->dims;
    expr->tables = p->desc->tables;
    return PD_OK;
}

pd_status pd_expr_build(pd_ctx *ctx, const pd_expr_desc *desc, pd_expr *expr)
{
    pdi_expr_parser *p;
    pdi_expr_type type;
    memset(expr, 0, sizeof *expr);
    if (!desc->text) return pd_fail(ctx, PD_ERR_ARGUMENT, "expr", "desc.text is NULL, expected an expression");
    if (desc->var_count < 0 || desc->var_count > PD_EXPR_VARS || desc->const_count < 0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "expr", "%d variables and %d constants, expected at most %d variables",
                       desc->var_count, desc->const_count, PD_EXPR_VARS);
    PD_TRY(PD_NEW(ctx, "expr", 1, p));
    p->ctx = ctx;
    p->desc = desc;
    p->text = desc->text;
    pd_status status = pdi_expr_compile(p, &type);
    if (status == PD_OK) status = pdi_expr_copy_result(ctx, p, &type, expr);
    if (status < 0) pd_expr_free(ctx, expr);
    PD_DELETE(ctx, 1, p);
    return status;
}

void pd_expr_free(pd_ctx *ctx, pd_expr *expr)
{
    PD_DELETE(ctx, expr->code_count, expr->code);
    PD_DELETE(ctx, expr->value_count, expr->value);
    PD_DELETE(ctx, expr->discontinuity_count, expr->discontinuities);
    memset(expr, 0, sizeof *expr);
}
PDI_COLD_END

double pd_expr_eval(const pd_expr *expr, const double *vars)
{
    double stack[PDI_EXPR_STACK_SIZE];
    int top = 0;
    if (expr->fn) return expr->fn(expr->user, vars);
    for (int k = 0; k < expr->code_count; k++) {
        int op = expr->code[k] & 255, index = expr->code[k] >> 8;
        if (op == PDI_EXPR_CONST) {
            stack[top++] = expr->value[index];
        } else if (op == PDI_EXPR_VAR) {
            stack[top++] = vars[index];
        } else if (op == PDI_EXPR_TABLE) {
            stack[top - 1] = pdi_expr_eval_table(&expr->tables[index], stack[top - 1]);
        } else {
            top -= pdi_expr_count_operands(op);
            stack[top] = pdi_expr_apply_op(op, stack + top);
            top++;
        }
    }
    return top == 1 ? stack[0] : NAN;
}

int pd_expr_is_constant(const pd_expr *expr) { return expr->variables_used == 0; }

void pd_expr_get_table_range(const pd_expr *expr, int var, double *range)
{
    range[0] = -HUGE_VAL;
    range[1] = HUGE_VAL;
    for (int k = 1; k < expr->code_count; k++) {
        if ((expr->code[k] & 255) != PDI_EXPR_TABLE || expr->code[k - 1] != (PDI_EXPR_VAR | var << 8)) continue;
        const pd_monotone_cubic *curve = expr->tables[expr->code[k] >> 8].curve;
        if (curve->nan_outside) continue;
        range[0] = pd_max(range[0], curve->x[0]);
        range[1] = pd_min(range[1], curve->x[curve->count - 1]);
    }
}

#undef PDI_EXPR_BUILTIN_COUNT
