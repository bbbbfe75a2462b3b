/* species: see species.h */
#include "chemistry/species.h"
#include <math.h>
#include <string.h>

#define PDI_SPECIES_MAX_DEPTH 4    /* most nested parentheses */
#define PDI_SPECIES_MAX_NUMBER 999 /* largest number in a formula */
#define PDI_SPECIES_MAX_CHARGE 20  /* largest charge */

/* Symbols by atomic number, two bytes each. */
static const char pdi_species_symbols[] =
    "H HeLiBeB C N O F NeNaMgAlSiP S ClArK CaScTiV CrMnFeCoNiCuZnGaGeAsSeBrKrRbSrY ZrNbMoTcRuRhPdAgCdInSnSbTeI XeCsBa"
    "LaCePrNdPmSmEuGdTbDyHoErTmYbLuHfTaW ReOsIrPtAuHgTlPbBiPoAtRnFrRaAcThPaU NpPuAmCmBkCfEsFmMdNoLrRfDbSgBhHsMtDsRgCnNh"
    "FlMcLvTsOg";

static int pdi_species_is_digit(char c) { return c >= '0' && c <= '9'; }
static int pdi_species_is_upper(char c) { return c >= 'A' && c <= 'Z'; }
static int pdi_species_is_lower(char c) { return c >= 'a' && c <= 'z'; }

void pd_species_get_symbol(int element, char *text)
{
    memcpy(text, pdi_species_symbols + 2 * (element - 1), 2);
    text[text[1] == ' ' ? 1 : 2] = 0;
}

PDI_FN int pdi_species_count_atoms(const pd_species *s, int element)
{
    for (int k = 0; k < s->elements; k++)
        if (s->element[k] == element) return s->count[k];
    return 0;
}

/* Parses a chemical symbol at `at`; returns its atomic number and its length in *size, or 0 where there is none. */
static int pdi_species_parse_element(const char *at, const char *end, int *size)
{
    char second = at + 1 < end && pdi_species_is_lower(at[1]) ? at[1] : ' ';
    if (at == end || !pdi_species_is_upper(at[0])) return 0;
    *size = second == ' ' ? 1 : 2;
    for (int k = 0; pdi_species_symbols[2 * k]; k++)
        if (pdi_species_symbols[2 * k] == at[0] && pdi_species_symbols[2 * k + 1] == second) return k + 1;
    return 0;
}

/* Parses a count at *at, which moves behind it; returns 1 where none is given, 0 where it is too large or zero. */
static int pdi_species_parse_number(const char **at, const char *end)
{
    int value = 0;
    if (*at == end || !pdi_species_is_digit(**at)) return 1;
    for (; *at < end && pdi_species_is_digit(**at); ++*at)
        if (value <= PDI_SPECIES_MAX_NUMBER) value = 10 * value + (**at - '0');
    return value <= PDI_SPECIES_MAX_NUMBER ? value : 0;
}

/* Adds `count` atoms of an element to s. Returns 1; 0: no room for another element, or too many atoms. */
static int pdi_species_add_atoms(pd_species *s, int element, int count)
{
    int k = 0;
    while (k < s->elements && s->element[k] != element) k++;
    if (k == PD_SPECIES_ELEMENTS) return 0;
    if (k == s->elements) s->elements++;
    s->element[k] = element;
    s->count[k] += count;
    return s->count[k] <= PDI_SPECIES_MAX_NUMBER * PDI_SPECIES_MAX_NUMBER;
}

/* Parses a formula without charge from `at` to `end`, recursively through parentheses, and adds its atoms times
 * `factor` to s. depth: of parentheses. Returns 1; 0: invalid, s may have some of them. */
static int pdi_species_parse_group(pd_species *s, const char *at, const char *end, int factor, int depth)
{
    if (at == end || depth > PDI_SPECIES_MAX_DEPTH || factor > PDI_SPECIES_MAX_NUMBER) return 0;
    while (at < end) {
        const char *from = at;
        int size, number, element = pdi_species_parse_element(at, end, &size);
        if (element) {
            at += size;
            number = pdi_species_parse_number(&at, end);
            if (!number || !pdi_species_add_atoms(s, element, factor * number)) return 0;
            continue;
        }
        if (*at != '(') return 0;
        for (int open = 0; at < end; at++) {
            open += (*at == '(') - (*at == ')');
            if (!open) break;
        }
        if (at == end) return 0;
        const char *close = at++;
        number = pdi_species_parse_number(&at, end);
        if (!number || !pdi_species_parse_group(s, from + 1, close, factor * number, depth + 1)) return 0;
    }
    return 1;
}

/* Parses a formula, with water of crystallisation behind ':', and sets the elements and counts of s anew. Returns 1; 0:
 * invalid. */
static int pdi_species_parse_formula(pd_species *s, const char *at, const char *end)
{
    s->elements = 0;
    memset(s->count, 0, sizeof s->count);
    while (at <= end) {
        const char *stop = at;
        while (stop < end && *stop != ':') stop++;
        int number = pdi_species_parse_number(&at, stop);
        if (!number || !pdi_species_parse_group(s, at, stop, number, 0)) return 0;
        at = stop + 1;
    }
    return 1;
}

/* Parses the charge at the end of a name by the rules of pd_species_read, 0 without one; *end moves before it. Several
 * equal signs without a number count their number. Returns 1; 0: a charge that is zero or above
 * PDI_SPECIES_MAX_CHARGE. */
static int pdi_species_parse_charge(const char *begin, const char **end, int *charge)
{
    const char *at = *end, *digits = at;
    int signs = 0, size, value = 0;
    *charge = 0;
    while (digits > begin && pdi_species_is_digit(digits[-1])) digits--;
    if (digits < at && digits > begin && (digits[-1] == '+' || digits[-1] == '-')) { /* Mg+2 */
        value = pdi_species_parse_number(&digits, at);
        while (pdi_species_is_digit(at[-1])) at--;
        *charge = at[-1] == '+' ? value : -value;
        *end = at - 1;
        return value > 0 && value <= PDI_SPECIES_MAX_CHARGE;
    }
    if (at == begin || (at[-1] != '+' && at[-1] != '-')) return 1;
    char sign = at[-1];
    while (at > begin && at[-1] == sign) {
        at--;
        signs++;
    }
    digits = at;
    while (digits > begin && pdi_species_is_digit(digits[-1])) digits--;
    const char *mark = digits > begin && strchr("^_ ", digits[-1]) ? digits - 1 : NULL;
    value = signs;
    if (signs == 1 && digits < at) {
        const char *from = digits;
        if (!mark && at - digits > 1) from = at - 1;                                             /* SO42- */
        /* NO3- */
        else if (!mark && !(pdi_species_parse_element(begin, digits, &size) && begin + size == digits)) from = at;
        if (from < at) {
            const char *number = from;
            value = pdi_species_parse_number(&number, at);
            at = mark ? mark : from;
        }
    } else if (mark && digits == at) {
        at = mark; /* Cl^- */
    }
    *charge = sign == '+' ? value : -value;
    *end = at;
    return value > 0 && value <= PDI_SPECIES_MAX_CHARGE;
}

/* 1: the name ends in `with`; *end moves before it. */
static int pdi_species_remove_suffix(const char *begin, const char **end, const char *with)
{
    size_t size = strlen(with);
    if ((size_t)(*end - begin) <= size || strncmp(*end - size, with, size) != 0) return 0;
    *end -= size;
    return 1;
}

/* 1: both have the same atoms. */
static int pdi_species_is_same_formula(const pd_species *a, const pd_species *b)
{
    if (a->elements != b->elements) return 0;
    for (int k = 0; k < a->elements; k++)
        if (pdi_species_count_atoms(b, a->element[k]) != a->count[k]) return 0;
    return 1;
}

/* pd_species_read without checks of sizes and numbers: (s) is a solid, (g) a gas, (aq) and (l) a solute, H2O the
 * solvent, e- the electron. A name that is no formula has the charge given, or 0. PD_ERR_PARSE: as there. The caller
 * clears s after an error. */
static pd_status pdi_species_try_read(pd_ctx *ctx, const pd_species_desc *desc, pd_species *s)
{
    pd_species given;
    const char *name = desc->name, *end = name + strlen(name);
    int charge, formula;
    strcpy(s->name, name);
    s->diffusivity = desc->diffusivity;
    if (pdi_species_remove_suffix(name, &end, "(s)")) s->phase = PD_PHASE_SOLID;
    else if (pdi_species_remove_suffix(name, &end, "(g)")) s->phase = PD_PHASE_GAS;
    else if (!pdi_species_remove_suffix(name, &end, "(aq)")) pdi_species_remove_suffix(name, &end, "(l)");
    if (end - name == 3 && strncmp(name, "H2O", 3) == 0 && s->phase == PD_PHASE_SOLUTE) s->phase = PD_PHASE_SOLVENT;
    if (strcmp(name, "e-") == 0) {
        s->phase = PD_PHASE_ELECTRON;
        charge = -1;
        formula = 1;
    } else {
        formula = pdi_species_parse_charge(name, &end, &charge) && pdi_species_parse_formula(s, name, end);
    }
    if (!formula && !desc->formula)
        return pd_fail(ctx, PD_ERR_PARSE, "species", "'%s' is no formula with a charge such as Mg2+, SO4^2- or "
                       "Mg(OH)2(s), expected one, or its formula beside the name", name);
    if (formula && desc->has_charge && desc->charge != charge)
        return pd_fail(ctx, PD_ERR_PARSE, "species", "the charge of '%s' is %+d by its name, but %+d is given: "
                       "drop one",
                       name, charge, desc->charge);
    s->charge = formula ? charge : desc->has_charge ? desc->charge : 0;
    if (!desc->formula) return PD_OK;
    memset(&given, 0, sizeof given);
    if (!pdi_species_parse_formula(&given, desc->formula, desc->formula + strlen(desc->formula)))
        return pd_fail(ctx, PD_ERR_PARSE, "species", "the formula '%.40s' of '%s' is none, expected one such as "
                       "C6H12O6",
                       desc->formula, name);
    if (formula && !pdi_species_is_same_formula(s, &given))
        return pd_fail(ctx, PD_ERR_PARSE, "species", "the name '%s' is a formula of other elements than '%.40s': "
                       "drop one",
                       name, desc->formula);
    s->elements = given.elements;
    memcpy(s->element, given.element, sizeof given.element);
    memcpy(s->count, given.count, sizeof given.count);
    return PD_OK;
}

pd_status pd_species_read(pd_ctx *ctx, const pd_species_desc *desc, pd_species *s)
{
    memset(s, 0, sizeof *s);
    size_t size = desc->name ? strlen(desc->name) : 0;
    if (!size || size >= PD_SPECIES_NAME)
        return pd_fail(ctx, PD_ERR_PARSE, "species", "the name '%.40s' has %d bytes, expected 1 to %d",
                       desc->name ? desc->name : "", (int)size, PD_SPECIES_NAME - 1);
    if (!(desc->diffusivity >= 0.0) || !(desc->diffusivity < HUGE_VAL))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "species", "the diffusivity of '%s' is %g m2/s, expected a positive "
                       "number",
                       desc->name, desc->diffusivity);
    if (desc->has_charge && (desc->charge > PDI_SPECIES_MAX_CHARGE || desc->charge < -PDI_SPECIES_MAX_CHARGE))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "species", "the charge of '%s' is %d, expected at most %d either way",
                       desc->name, desc->charge, PDI_SPECIES_MAX_CHARGE);
    pd_status status = pdi_species_try_read(ctx, desc, s);
    if (status < 0) memset(s, 0, sizeof *s);
    return status;
}
