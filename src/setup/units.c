/* units: see units.h */
#include "setup/units.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* A unit without prefix: its size in SI as a quotient num/den, and its dimension. */
typedef struct pdi_units_definition {
    const char *name;
    double num, den;
    signed char e[6]; /* m kg s A mol K */
    int prefix;       /* takes SI prefixes */
} pdi_units_definition;

/* SI and accepted units. eV: CODATA 2018; a year is 365.25 days; mpy: mils (2.54e-5 m) per year. */
static const pdi_units_definition pdi_units_table[] = {
    {"m", 1, 1, {1, 0, 0, 0, 0, 0}, 1},           {"g", 1, 1e3, {0, 1, 0, 0, 0, 0}, 1},
    {"s", 1, 1, {0, 0, 1, 0, 0, 0}, 1},           {"A", 1, 1, {0, 0, 0, 1, 0, 0}, 1},
    {"mol", 1, 1, {0, 0, 0, 0, 1, 0}, 1},         {"K", 1, 1, {0, 0, 0, 0, 0, 1}, 1},
    {"N", 1, 1, {1, 1, -2, 0, 0, 0}, 1},          {"Pa", 1, 1, {-1, 1, -2, 0, 0, 0}, 1},
    {"J", 1, 1, {2, 1, -2, 0, 0, 0}, 1},          {"W", 1, 1, {2, 1, -3, 0, 0, 0}, 1},
    {"C", 1, 1, {0, 0, 1, 1, 0, 0}, 1},           {"V", 1, 1, {2, 1, -3, -1, 0, 0}, 1},
    {"Ohm", 1, 1, {2, 1, -3, -2, 0, 0}, 1},       {"ohm", 1, 1, {2, 1, -3, -2, 0, 0}, 1},
    {"S", 1, 1, {-2, -1, 3, 2, 0, 0}, 1},         {"Hz", 1, 1, {0, 0, -1, 0, 0, 0}, 1},
    {"L", 1, 1e3, {3, 0, 0, 0, 0, 0}, 1},         {"l", 1, 1e3, {3, 0, 0, 0, 0, 0}, 1},
    {"M", 1e3, 1, {-3, 0, 0, 0, 1, 0}, 1},        {"bar", 1e5, 1, {-1, 1, -2, 0, 0, 0}, 1},
    {"P", 1, 10, {-1, 1, -1, 0, 0, 0}, 1},        {"eV", 1.602176634e-19, 1, {2, 1, -2, 0, 0, 0}, 1},
    {"atm", 101325, 1, {-1, 1, -2, 0, 0, 0}, 0},  {"min", 60, 1, {0, 0, 1, 0, 0, 0}, 0},
    {"h", 3600, 1, {0, 0, 1, 0, 0, 0}, 0},        {"d", 86400, 1, {0, 0, 1, 0, 0, 0}, 0},
    {"day", 86400, 1, {0, 0, 1, 0, 0, 0}, 0},     {"yr", 31557600, 1, {0, 0, 1, 0, 0, 0}, 0},
    {"year", 31557600, 1, {0, 0, 1, 0, 0, 0}, 0}, {"mpy", 2.54e-5, 31557600, {1, 0, -1, 0, 0, 0}, 0},
    {"rad", 1, 1, {0, 0, 0, 0, 0, 0}, 0},         {"deg", 3.14159265358979323846, 180, {0, 0, 0, 0, 0, 0}, 0},
    {"%", 1, 100, {0, 0, 0, 0, 0, 0}, 0},         {"ppm", 1, 1e6, {0, 0, 0, 0, 0, 0}, 0}};

typedef struct pdi_units_prefix {
    const char *name;
    double num, den;
} pdi_units_prefix;

/* The last two are the micro sign and the Greek letter in UTF-8. */
static const pdi_units_prefix pdi_units_prefixes[] = {
    {"f", 1, 1e15}, {"p", 1, 1e12}, {"n", 1, 1e9}, {"u", 1, 1e6}, {"m", 1, 1e3},          {"c", 1, 100},
    {"d", 1, 10},   {"h", 100, 1},  {"k", 1e3, 1}, {"M", 1e6, 1}, {"G", 1e9, 1},          {"T", 1e12, 1},
    {"\xC2\xB5", 1, 1e6},           {"\xCE\xBC", 1, 1e6}};

/* Temperature scales with an offset, which are refused. */
static const char *const pdi_units_offset_scales[] = {"degC",
                                                      "degF",
                                                      "celsius",
                                                      "Celsius",
                                                      "fahrenheit",
                                                      "Fahrenheit",
                                                      "\xC2\xB0"
                                                      "C",
                                                      "\xC2\xB0"
                                                      "F"};

/* A dimension with a name, its SI unit, and units to print values in, ascending. The first entry that fits is used. */
typedef struct pdi_units_dimension {
    const char *name, *unit, *print_units;
} pdi_units_dimension;

static const pdi_units_dimension pdi_units_dimensions[] = {
    {"a length", "m", "nm|um|mm|m|km"},
    {"an area", "m2", "um2|mm2|m2"},
    {"a volume", "m3", "um3|uL|mL|m3"},
    {"a time", "s", "ns|us|ms|s|min|h|day|year"},
    {"a rate", "1/s", "/year|/day|/h|/s"},
    {"a speed", "m/s", "mm/year|um/h|um/s|mm/s|m/s"},
    {"an acceleration", "m/s2", "m/s2"},
    {"a flow rate", "m3/s", "uL/min|mL/min|L/s|m3/s"},
    {"a diffusivity", "m2/s", "m2/s"},
    {"a mass", "kg", "ng|ug|mg|g|kg"},
    {"a density", "kg/m3", "kg/m3"},
    {"a mass flow", "kg/s", "ug/s|mg/s|g/s|kg/s"},
    {"a mass flux", "kg/m2/s", "mg/m2/day|g/m2/h|kg/m2/s"},
    {"a pressure", "Pa", "mPa|Pa|kPa|MPa|GPa"},
    {"a viscosity", "Pa s", "uPa s|mPa s|Pa s"},
    {"a force", "N", "nN|uN|mN|N|kN"},
    {"a force per length", "N/m", "uN/m|mN/m|N/m"},
    {"a force per volume", "N/m3", "N/m3|kN/m3"},
    {"an energy", "J", "nJ|uJ|mJ|J|kJ"},
    {"a power", "W", "nW|uW|mW|W|kW"},
    {"an energy per amount", "J/mol", "J/mol|kJ/mol"},
    {"an entropy per amount", "J/mol/K", "J/mol/K"},
    {"an amount", "mol", "pmol|nmol|umol|mmol|mol"},
    {"a concentration", "mol/m3", "umol/m3|mmol/m3|mol/m3|kmol/m3"},
    {"a molar mass", "kg/mol", "g/mol|kg/mol"},
    {"a molar flux", "mol/m2/s", "nmol/m2/s|umol/m2/s|mmol/m2/s|mol/m2/s"},
    {"a reaction rate", "mol/m3/s", "umol/m3/s|mmol/m3/s|mol/m3/s"},
    {"a temperature", "K", "K"},
    {"a current", "A", "nA|uA|mA|A"},
    {"a current density", "A/m2", "uA/cm2|mA/cm2|A/cm2"},
    {"a charge", "C", "nC|uC|mC|C"},
    {"a charge per amount", "C/mol", "C/mol"},
    {"a voltage", "V", "uV|mV|V|kV"},
    {"a resistance", "Ohm", "mOhm|Ohm|kOhm|MOhm"},
    {"a conductance", "S", "uS|mS|S"},
    {"a conductivity", "S/m", "mS/m|S/m"}};

#define PDI_UNITS_COUNT(array) ((int)(sizeof(array) / sizeof(array)[0]))

int pd_units_is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

int pd_units_is_digit(char c) { return c >= '0' && c <= '9'; }

/* 1: a letter, _, or a byte >= 0x80 (UTF-8), which may begin an identifier. */
static int pdi_units_is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || (unsigned char)c >= 0x80;
}

size_t pd_units_scan_word(const char *text)
{
    size_t n = 0;
    if (!pdi_units_is_letter(text[0])) return 0;
    while (pdi_units_is_letter(text[n]) || pd_units_is_digit(text[n])) n++;
    return n;
}

/* Index of the first non-blank byte from text[at] on. */
static size_t pdi_units_skip_blanks(const char *text, size_t at)
{
    while (pd_units_is_blank(text[at])) at++;
    return at;
}

/* 1: text[0..size) is the string name. */
static int pdi_units_is_equal(const char *text, size_t size, const char *name)
{
    return strlen(name) == size && memcmp(text, name, size) == 0;
}

/* Look up text[0..size), without prefix, in the table of units; prefixed 1: only among those that take SI prefixes.
 * NULL: none. */
static const pdi_units_definition *pdi_units_find_unit(const char *text, size_t size, int prefixed)
{
    for (int k = 0; k < PDI_UNITS_COUNT(pdi_units_table); k++)
        if ((pdi_units_table[k].prefix || !prefixed) && pdi_units_is_equal(text, size, pdi_units_table[k].name))
            return &pdi_units_table[k];
    return NULL;
}

/* Parse text[0..size) as a unit with an optional SI prefix; an exact name wins ("min" is no milli-inch). 1: *unit is
 * set; 0: no unit. */
static int pdi_units_parse_symbol(const char *text, size_t size, pd_units_product *unit)
{
    const pdi_units_definition *entry = pdi_units_find_unit(text, size, 0);
    unit->num = unit->den = 1;
    for (int k = 0; !entry && k < PDI_UNITS_COUNT(pdi_units_prefixes); k++) {
        size_t skip = strlen(pdi_units_prefixes[k].name);
        if (size <= skip || memcmp(text, pdi_units_prefixes[k].name, skip) != 0) continue;
        entry = pdi_units_find_unit(text + skip, size - skip, 1);
        unit->num = pdi_units_prefixes[k].num;
        unit->den = pdi_units_prefixes[k].den;
    }
    if (!entry) return 0;
    unit->num *= entry->num;
    unit->den *= entry->den;
    for (int k = 0; k < 6; k++) unit->dims.exponent[k] = entry->e[k];
    return 1;
}

/* Exponent after '^': [-]digits[.digits] into *value. Returns the bytes read; 0: none, and *value stays. Digits beyond
 * 1e6, or beyond nine decimals, are not read. */
static size_t pdi_units_scan_exponent(const char *text, double *value)
{
    size_t at = text[0] == '-';
    double v = 0, place = 1;
    if (!pd_units_is_digit(text[at])) return 0;
    for (; pd_units_is_digit(text[at]) && v < 1e6; at++) v = 10 * v + (text[at] - '0');
    if (text[at] == '.' && pd_units_is_digit(text[at + 1]))
        for (at++; pd_units_is_digit(text[at]) && place < 1e9; at++) {
            place *= 10;
            v = 10 * v + (text[at] - '0');
        }
    *value = (text[0] == '-' ? -v : v) / place;
    return at;
}

/* unit *= factor^power, dimension included; whole powers up to 12 by multiplication, so that powers of ten stay exact,
 * others by pow. A negative power exchanges num and den. */
static void pdi_units_multiply(pd_units_product *unit, const pd_units_product *factor, double power)
{
    double num = 1, den = 1, size = fabs(power);
    if (size <= 12 && size == floor(size)) {
        for (int k = 0; k < (int)size; k++) {
            num *= factor->num;
            den *= factor->den;
        }
    } else {
        num = pow(factor->num, size);
        den = pow(factor->den, size);
    }
    unit->num *= power > 0 ? num : den;
    unit->den *= power > 0 ? den : num;
    for (int k = 0; k < 6; k++) unit->dims.exponent[k] += power * factor->dims.exponent[k];
}

/* The dimensionless unit 1. */
static void pdi_units_init_one(pd_units_product *unit)
{
    memset(unit, 0, sizeof *unit);
    unit->num = unit->den = 1;
}

/* Divide num and den by their greatest common divisor if both are whole and below 9e15, so that a value is rounded
 * once: 0.1 kg is 0.1 * 1, not 0.1 * 1000 / 1000. */
static void pdi_units_reduce_fraction(pd_units_product *unit)
{
    double a = unit->num, b = unit->den;
    if (!(a < 9e15 && b < 9e15) || a != floor(a) || b != floor(b)) return;
    while (b > 0) {
        double rest = fmod(a, b);
        a = b;
        b = rest;
    }
    unit->num /= a;
    unit->den /= a;
}

/* Parse one unit with exponent (m2, m^2, m-2, m^-0.5) at text and multiply *unit by its power sign * exponent. Returns
 * the bytes read; 0: no unit, or a declared name. *why, NULL before: becomes the reason why a unit is inadmissible
 * (degC, no number behind ^, a blank before it, an exponent of 0 or beyond 12 in size); *unit stays then. */
static size_t pdi_units_scan_term(const char *text, pd_units_is_declared_fn declared, const void *user, double sign,
                                  pd_units_product *unit, const char **why)
{
    pd_units_product factor;
    size_t size = text[0] == '%' ? 1 : pd_units_scan_word(text), name = size, at, n;
    double power = 1;
    if (size == 0 || (declared && declared(user, text, size))) return 0;
    for (int k = 0; k < PDI_UNITS_COUNT(pdi_units_offset_scales); k++)
        if (pdi_units_is_equal(text, size, pdi_units_offset_scales[k])) {
            *why = "a temperature scale with an offset is not a unit: write the temperature in K (37 degC is 310.15 K)";
            return 0;
        }
    while (name > 1 && pd_units_is_digit(text[name - 1])) name--;
    if (size - name > 2 || !pdi_units_parse_symbol(text, name, &factor)) return 0;
    at = size;
    if (name < size) {
        for (power = 0; name < size; name++) power = 10 * power + (text[name] - '0');
    } else if (text[at] == '^') {
        n = pdi_units_scan_exponent(text + at + 1, &power);
        at += 1 + n;
        if (n == 0) *why = "the exponent of a unit is a number (m^2, s^-1); for a power of the value write (3 m)^2";
    } else if (text[at] == '-' && pd_units_is_digit(text[at + 1])) {
        n = pd_units_is_digit(text[at + 2]) ? 2 : 1;
        if (text[at + n + 1] != '.' && !pd_units_scan_word(text + at + n + 1) && !pd_units_is_digit(text[at + n + 1]))
            at += pdi_units_scan_exponent(text + at, &power);
    } else if (text[pdi_units_skip_blanks(text, at)] == '^') {
        *why = "write '^' directly after the unit (3 m^2) or parentheses around the value ((3 m)^2)";
    }
    if (!*why && (power == 0 || fabs(power) > 12)) *why = "the exponent of a unit lies outside 1 to 12";
    if (!*why) pdi_units_multiply(unit, &factor, sign * power);
    return at;
}

size_t pd_units_scan_product(const char *text, pd_units_is_declared_fn declared, const void *user,
                                     pd_units_product *unit, const char **why)
{
    size_t end, at = 0;
    *why = NULL;
    pdi_units_init_one(unit);
    if (text[0] == '1') at = pdi_units_skip_blanks(text, 1); /* the form "1/s" */
    end = at > 0 && text[at] == '/' ? at : pdi_units_scan_term(text, declared, user, 1, unit, why);
    if (end == 0 || *why) return end;
    for (;;) {
        pd_units_product group;
        size_t n, next = pdi_units_skip_blanks(text, end);
        if (text[next] == '/') {
            next = pdi_units_skip_blanks(text, next + 1);
            n = pdi_units_scan_divisor(text + next, declared, user, &group, why);
            if (n > 0 && !*why) pdi_units_multiply(unit, &group, -1);
        } else {
            if (text[next] == '*') next = pdi_units_skip_blanks(text, next + 1);
            n = pdi_units_scan_term(text + next, declared, user, 1, unit, why);
        }
        if (*why) return next + n;
        if (n == 0) break;
        end = next + n;
    }
    pdi_units_reduce_fraction(unit);
    return at > 0 && end == at ? 0 : end;
}

PDI_FN size_t pdi_units_scan_divisor(const char *text, pd_units_is_declared_fn declared, const void *user,
                                     pd_units_product *unit, const char **why)
{
    size_t at, n;
    *why = NULL;
    pdi_units_init_one(unit);
    if (text[0] != '(') {
        at = pdi_units_scan_term(text, declared, user, 1, unit, why);
        if (at > 0) pdi_units_reduce_fraction(unit);
        return at;
    }
    for (at = 1;; at += n) { /* (mol K), (m2*s): units only */
        at = pdi_units_skip_blanks(text, at);
        if (at > 1 && text[at] == '*') at = pdi_units_skip_blanks(text, at + 1);
        n = pdi_units_scan_term(text + at, declared, user, 1, unit, why);
        if (*why) return at + n;
        if (n == 0) break;
    }
    pdi_units_reduce_fraction(unit);
    return at > 1 && text[at] == ')' ? at + 1 : 0;
}

/* Parse a unit that fills the whole text, blanks aside: empty, "1", a product, or "/s". 1: it is one; 0: it is none.
 * *why: NULL, or why it is inadmissible. */
static int pdi_units_parse_whole(const char *text, pd_units_product *unit, const char **why)
{
    pd_units_product factor;
    size_t at = pdi_units_skip_blanks(text, 0), n;
    *why = NULL;
    pdi_units_init_one(unit);
    if (text[at] == '\0' || (text[at] == '1' && text[pdi_units_skip_blanks(text, at + 1)] == '\0')) return 1;
    if (text[at] == '/') {
        at = pdi_units_skip_blanks(text, at + 1);
        n = pdi_units_scan_divisor(text + at, NULL, NULL, &factor, why);
        if (n > 0) pdi_units_multiply(unit, &factor, -1);
    } else {
        n = pd_units_scan_product(text + at, NULL, NULL, unit, why);
    }
    return n > 0 && !*why && text[pdi_units_skip_blanks(text, at + n)] == '\0';
}

pd_status pd_units_parse(pd_ctx *ctx, const char *unit, double *scale, pd_dims *dims)
{
    pd_units_product product;
    const char *why;
    int read = pdi_units_parse_whole(unit, &product, &why);
    if (why) return pd_fail(ctx, PD_ERR_PARSE, "units", "'%.40s': %s", unit, why);
    if (!read)
        return pd_fail(ctx, PD_ERR_PARSE, "units", "found '%.40s', expected a unit such as um, m2/s or Pa s", unit);
    if (scale) *scale = product.num / product.den;
    if (dims) *dims = product.dims;
    return PD_OK;
}

int pd_units_is_same(const pd_dims *a, const pd_dims *b)
{
    for (int k = 0; k < 6; k++)
        if (!(fabs(a->exponent[k] - b->exponent[k]) < 1e-9)) return 0;
    return 1;
}

/* First entry of the named dimensions that fits; NULL: none, as for a plain number. */
static const pdi_units_dimension *pdi_units_find_dimension(const pd_dims *dims)
{
    for (int k = 0; k < PDI_UNITS_COUNT(pdi_units_dimensions); k++) {
        pd_units_product unit;
        const char *why;
        pdi_units_parse_whole(pdi_units_dimensions[k].unit, &unit, &why);
        if (pd_units_is_same(&unit.dims, dims)) return &pdi_units_dimensions[k];
    }
    return NULL;
}

/* Replace decimal commas, which printf writes in some locales, by points. */
static void pdi_units_fix_decimal_point(char *text)
{
    for (; *text; text++)
        if (*text == ',') *text = '.';
}

/* SI unit of a dimension from its exponents, "kg m2 s-3", kg first, into text[64]; "" for a plain number. Exponents
 * below 1e-9 count as 0; those that are not whole, or of size 10 or more, have ^. What does not fit is left out. */
static void pdi_units_format_si(const pd_dims *dims, char *text)
{
    static const int order[6] = {1, 0, 2, 3, 4, 5};
    static const char *const base[6] = {"m", "kg", "s", "A", "mol", "K"};
    size_t at = 0;
    text[0] = '\0';
    for (int k = 0; k < 6; k++) {
        double power = dims->exponent[order[k]];
        const char *gap = at > 0 ? " " : "";
        const char *name = base[order[k]];
        int n = 0;
        if (fabs(power) < 1e-9) continue;
        if (fabs(power - 1) < 1e-9) n = snprintf(text + at, 64 - at, "%s%s", gap, name);
        else if (fabs(power) < 9.5 && fabs(power - floor(power + 0.5)) < 1e-9)
            n = snprintf(text + at, 64 - at, "%s%s%.0f", gap, name, power);
        else n = snprintf(text + at, 64 - at, "%s%s^%.4g", gap, name, power);
        if (n < 0 || (size_t)n >= 64 - at) break;
        at += (size_t)n;
    }
    pdi_units_fix_decimal_point(text);
}

/* 1: dimensionless, each exponent within 1e-9 of 0. */
static int pdi_units_is_dimensionless(const pd_dims *dims)
{
    pd_dims none;
    memset(&none, 0, sizeof none);
    return pd_units_is_same(dims, &none);
}

void pd_units_describe(const pd_dims *dims, char *text)
{
    const pdi_units_dimension *named = pdi_units_find_dimension(dims);
    char unit[64];
    pdi_units_format_si(dims, unit);
    if (pdi_units_is_dimensionless(dims)) snprintf(text, PD_UNITS_TEXT, "a plain number");
    else if (named) snprintf(text, PD_UNITS_TEXT, "%s [%s]", named->name, named->unit);
    else snprintf(text, PD_UNITS_TEXT, "a quantity [%s]", unit);
}

/* Copy the first unit of a list "nm|um|mm" into unit[64]; returns the start of the next one, or NULL after the last. */
static const char *pdi_units_copy_alternative(const char *list, char *unit)
{
    size_t n = strcspn(list, "|");
    memcpy(unit, list, n);
    unit[n] = '\0';
    return list[n] ? list + n + 1 : NULL;
}

PDI_FN void pdi_units_format_value(double value, const pd_dims *dims, char *text)
{
    const pdi_units_dimension *named = pdi_units_is_dimensionless(dims) ? NULL : pdi_units_find_dimension(dims);
    char unit[64], best[64];
    double shown = value;
    if (!named || value == 0 || !(fabs(value) <= 1e300)) {
        if (named) snprintf(best, sizeof best, "%s", named->unit);
        else pdi_units_format_si(dims, best);
    } else {
        const char *list = named->print_units;
        best[0] = '\0';
        while (list) {
            pd_units_product product;
            const char *why;
            list = pdi_units_copy_alternative(list, unit);
            pdi_units_parse_whole(unit, &product, &why);
            double size = value * product.den / product.num;
            if (best[0] && fabs(size) < 1 - 1e-9) break;
            snprintf(best, sizeof best, "%s", unit);
            shown = size;
        }
    }
    int n = snprintf(text, PD_UNITS_TEXT, "%.6g", shown);
    pdi_units_fix_decimal_point(text);
    if (best[0] && n > 0 && n < PD_UNITS_TEXT)
        snprintf(text + n, (size_t)(PD_UNITS_TEXT - n), " %s", best);
}

PDI_FN void pdi_units_format_examples(const pd_dims *dims, char *text)
{
    const pdi_units_dimension *named = pdi_units_find_dimension(dims);
    char unit[64];
    size_t at = 0;
    pdi_units_format_si(dims, text);
    for (const char *list = named ? named->print_units : NULL; list;) {
        list = pdi_units_copy_alternative(list, unit);
        int n = snprintf(text + at, PD_UNITS_TEXT - at, "%s%s", at > 0 ? ", " : "", unit);
        if (n < 0 || (size_t)n >= PD_UNITS_TEXT - at) return;
        at += (size_t)n;
    }
}

/* Optimal string alignment distance (insertion, deletion, replacement, swap of neighbours, 1 each) of two words of at
 * most 31 bytes. */
static int pdi_units_compute_edit_distance(const char *a, const char *b)
{
    int row[3][33], na = (int)strlen(a), nb = (int)strlen(b);
    for (int j = 0; j <= nb; j++) row[0][j] = j;
    for (int i = 1; i <= na; i++) {
        int *now = row[i % 3], *last = row[(i + 2) % 3], *older = row[(i + 1) % 3];
        now[0] = i;
        for (int j = 1; j <= nb; j++) {
            int best = last[j - 1] + (a[i - 1] != b[j - 1]);
            if (last[j] + 1 < best) best = last[j] + 1;
            if (now[j - 1] + 1 < best) best = now[j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] && older[j - 2] + 1 < best)
                best = older[j - 2] + 1;
            now[j] = best;
        }
    }
    return row[na % 3][nb];
}

void pd_units_init_suggestion(pd_units_suggestion *near_word, const char *word, size_t size)
{
    memset(near_word, 0, sizeof *near_word);
    near_word->distance = size <= 4 ? 2 : 3; /* a candidate must be nearer than this */
    if (size >= sizeof near_word->word) near_word->distance = 0;
    else memcpy(near_word->word, word, size);
}

/* 1: the words are equal but for the case of the letters a to z. */
static int pdi_units_is_equal_ignoring_case(const char *a, const char *b)
{
    for (; *a && *b; a++, b++) {
        int letters = ((*a | 32) >= 'a') && ((*a | 32) <= 'z');
        if (letters ? (*a | 32) != (*b | 32) : *a != *b) return 0;
    }
    return *a == *b;
}

void pd_units_try_candidate(pd_units_suggestion *near_word, const char *candidate)
{
    size_t size = strlen(candidate);
    if (near_word->distance == 0 || size == 0 || size >= sizeof near_word->best) return;
    int distance = pdi_units_is_equal_ignoring_case(near_word->word, candidate)
                       ? 0
                       : pdi_units_compute_edit_distance(near_word->word, candidate);
    if (distance >= near_word->distance || (size_t)distance >= size || (size_t)distance >= strlen(near_word->word))
        return;
    near_word->distance = distance;
    memcpy(near_word->best, candidate, size + 1);
}

PDI_FN void pdi_units_try_units(pd_units_suggestion *near_word)
{
    for (int k = 0; k < PDI_UNITS_COUNT(pdi_units_table); k++) {
        pd_units_try_candidate(near_word, pdi_units_table[k].name);
        for (int p = 0; pdi_units_table[k].prefix && p < PDI_UNITS_COUNT(pdi_units_prefixes) - 2; p++) {
            char name[16];
            snprintf(name, sizeof name, "%s%s", pdi_units_prefixes[p].name, pdi_units_table[k].name);
            pd_units_try_candidate(near_word, name);
        }
    }
}

void pd_units_format_suggestion(const pd_units_suggestion *near_word, char *text)
{
    text[0] = '\0';
    if (near_word->best[0]) snprintf(text, PD_UNITS_TEXT, ": did you mean '%s'?", near_word->best);
}
