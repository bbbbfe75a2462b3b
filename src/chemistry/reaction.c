/* reaction: see reaction.h */
#include "chemistry/reaction.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_REACTION_TERM_BYTES 48   /* [byte] of a term of the text with its end */
#define PDI_REACTION_TOLERANCE 1e-9  /* sums of stoichiometric numbers that differ by less are equal */
#define PDI_REACTION_MAX_NUMBER 99.0 /* largest stoichiometric number, and exponent of a unit */
#define PDI_REACTION_LITRE 1e-3 /* [m3] one litre */

/* 1: white space. */
static int pdi_reaction_is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/* Parses an unsigned decimal number at *at, which moves behind it; returns -1 where there is none. */
static double pdi_reaction_parse_number(const char **at)
{
    double value = 0.0, place = 0.0;
    const char *from = *at;
    for (; (**at >= '0' && **at <= '9') || (**at == '.' && !(place > 0.0)); ++*at) {
        if (**at == '.') {
            place = 1.0;
            continue;
        }
        value = 10.0 * value + (**at - '0');
        if (place > 0.0) place *= 10.0;
    }
    return *at == from ? -1.0 : place > 0.0 ? value / place : value;
}

/* Parses a unit of mol, mmol, umol, M, mM, L, l, m, dm, s, min and h with exponents ("mol2", "L^-1"); / divides by the
 * next factor alone; "1/" may begin it. *scale: its size in mol, m, s, and exponent: that of mol, m, s. NULL, "" and
 * "1": no unit. Returns 1, or 0: an unknown symbol, or an exponent above PDI_REACTION_MAX_NUMBER. */
static int pdi_reaction_parse_unit(const char *at, double *scale, double exponent[3])
{
    int divide = 0, factors = 0;
    *scale = 1.0;
    exponent[0] = exponent[1] = exponent[2] = 0.0;
    if (at && strcmp(at, "1") == 0) return 1;
    for (; at && *at; factors++) {
        static const struct pdi_reaction_symbol {
            const char *name;
            int base;
            double power, size;
        } symbols[] = {{"mmol", 0, 1.0, 1e-3}, {"umol", 0, 1.0, 1e-6}, {"mol", 0, 1.0, 1.0},
                       {"mM", 3, 1.0, 1.0},    {"L", 1, 3.0, PDI_REACTION_LITRE}, {"l", 1, 3.0, PDI_REACTION_LITRE},
                       {"M", 3, 1.0, 1e3},     {"min", 2, 1.0, 60.0},  {"h", 2, 1.0, 3600.0}, {"dm", 1, 1.0, 0.1},
                       {"m", 1, 1.0, 1.0},     {"s", 2, 1.0, 1.0}};
        size_t s = 0, most = sizeof symbols / sizeof symbols[0];
        while (pdi_reaction_is_blank(*at) || *at == '*') at++;
        if (*at == '1' && at[1] == '/' && !factors) at++;
        if (*at == '/') {
            divide = 1;
            at++;
        }
        while (pdi_reaction_is_blank(*at)) at++;
        while (s < most && strncmp(at, symbols[s].name, strlen(symbols[s].name)) != 0) s++;
        if (s == most) return 0;
        at += strlen(symbols[s].name);
        if (*at == '^') at++;
        double sign = divide ? -1.0 : 1.0;
        if (*at == '-') {
            sign = -sign;
            at++;
        }
        double power = pdi_reaction_parse_number(&at);
        if (power < 0.0) power = 1.0;
        if (power > PDI_REACTION_MAX_NUMBER) return 0;
        power *= sign;
        *scale *= pow(symbols[s].size, power);
        if (symbols[s].base == 3) {
            exponent[0] += power;
            exponent[1] -= 3.0 * power;
        } else {
            exponent[symbols[s].base] += symbols[s].power * power;
        }
        divide = 0;
    }
    return 1;
}

/* Formats the expected unit such as "mol2/L2/s": power `order` of a concentration, per second with rate 1. */
static void pdi_reaction_format_unit(double order, double rate, char *text, size_t size)
{
    const char *end = rate > 0.0 ? "/s" : "";
    double n = fabs(order);
    if (!(n > PDI_REACTION_TOLERANCE)) snprintf(text, size, "%s", rate > 0.0 ? "1/s" : "no unit");
    else if (fabs(n - 1.0) < PDI_REACTION_TOLERANCE) snprintf(text, size, order > 0.0 ? "mol/L%s" : "L/mol%s", end);
    else snprintf(text, size, order > 0.0 ? "mol%g/L%g%s" : "L%g/mol%g%s", n, n, end);
}

/* Checks that a unit is (mol/L)^order, per second with rate 1, else 0; *scale: its size in mol, m, s. PD_ERR_PARSE:
 * another one; what: the number that has it, for the message. */
static pd_status pdi_reaction_check_unit(pd_ctx *ctx, const char *name, const char *what, const char *unit,
                                         double order, double rate, double *scale)
{
    char expected[PDI_REACTION_TERM_BYTES];
    double e[3];
    if (pdi_reaction_parse_unit(unit, scale, e) && fabs(e[0] - order) < PDI_REACTION_TOLERANCE &&
        fabs(e[1] + 3.0 * order) < PDI_REACTION_TOLERANCE && fabs(e[2] + rate) < PDI_REACTION_TOLERANCE)
        return PD_OK;
    pdi_reaction_format_unit(order, rate, expected, sizeof expected);
    if (!unit || !*unit)
        return pd_fail(ctx, PD_ERR_PARSE, "reaction", "%s of '%s' has no unit, expected %s%s", what, name, expected,
                       rate > 0.0 ? "" : ", or log10_K without unit");
    return pd_fail(ctx, PD_ERR_PARSE, "reaction", "%s of '%s' has the unit '%.40s', expected %s%s", what, name, unit,
                   expected, rate > 0.0 ? "" : ", or log10_K without unit");
}

/* Parses one term "2 OH-" on the left (side -1) or right (1) of a reaction, and adds it to r->nu. PD_ERR_PARSE: no
 * term, an unknown species, or one that is on both sides. */
static pd_status pdi_reaction_parse_term(pd_ctx *ctx, const char *term, double side, const pd_species *species,
                                         int count, pd_reaction *r)
{
    const char *at = term;
    double number = pdi_reaction_parse_number(&at);
    if (number < 0.0) number = 1.0;
    while (pdi_reaction_is_blank(*at)) at++;
    if (!*at || !(number > 0.0) || number > PDI_REACTION_MAX_NUMBER)
        return pd_fail(ctx, PD_ERR_PARSE, "reaction", "'%s' has the term '%s', expected terms such as 2 OH-, with "
                       "blanks around + and =", r->name, term);
    for (int i = 0; i < count; i++) {
        if (strcmp(at, species[i].name) != 0) continue;
        if (r->nu[i] * side < 0.0)
            return pd_fail(ctx, PD_ERR_PARSE, "reaction", "'%s' has %s on both sides: keep the difference",
                           r->name, at);
        r->nu[i] += side * number;
        return PD_OK;
    }
    char known[160] = "";
    for (int i = 0; i < count; i++) pd_append(known, sizeof known, "%s%s", i ? ", " : "", species[i].name);
    return pd_fail(ctx, PD_ERR_PARSE, "reaction", "'%s' has the species '%s', which nobody defines: define it, or "
                   "take "
                   "one of %s", r->name, at, known);
}

/* Parses the terms of a text into r->nu: both sides of a reaction (side -1), or a sum alone, without = (side 1). + and
 * = divide terms only with blanks around them. PD_ERR_PARSE: not such a text, a term of 48 bytes or more, errors of
 * pdi_reaction_parse_term. */
static pd_status pdi_reaction_parse_terms(pd_ctx *ctx, const char *text, const pd_species *species, int count,
                                          double side, pd_reaction *r)
{
    char term[PDI_REACTION_TERM_BYTES];
    size_t size = 0;
    for (const char *at = text;; at++) {
        int single = (at == text || pdi_reaction_is_blank(at[-1])) && (!*at || !at[1] || pdi_reaction_is_blank(at[1]));
        if (*at && !(single && (*at == '+' || *at == '='))) {
            if (!size && pdi_reaction_is_blank(*at)) continue;
            if (size + 1 == sizeof term)
                return pd_fail(ctx, PD_ERR_PARSE, "reaction", "a term of '%s' is longer than %d bytes", r->name,
                               (int)sizeof term - 1);
            term[size++] = *at;
            continue;
        }
        while (size && pdi_reaction_is_blank(term[size - 1])) size--;
        term[size] = 0;
        PD_TRY(pdi_reaction_parse_term(ctx, term, side, species, count, r));
        size = 0;
        if (*at == '=' && side > 0.0)
            return pd_fail(ctx, PD_ERR_PARSE, "reaction", "'%s' has two =, expected one", r->name);
        if (*at == '=') side = 1.0;
        if (!*at) break;
    }
    if (side < 0.0)
        return pd_fail(ctx, PD_ERR_PARSE, "reaction", "'%s' has no =, expected a text such as H+ + OH- = H2O",
                       r->name);
    return PD_OK;
}

/* Checks that every element and the charge balance to PDI_REACTION_TOLERANCE (eq. 7.1). PD_ERR_PARSE: one does not;
 * the message has both sides. */
static pd_status pdi_reaction_check_balance(pd_ctx *ctx, const pd_species *species, int count, const pd_reaction *r)
{
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < species[i].elements && r->nu[i] != 0.0; k++) {
            double left = 0.0, right = 0.0;
            char symbol[3];
            for (int j = 0; j < count; j++) {
                double atoms = r->nu[j] * pdi_species_count_atoms(&species[j], species[i].element[k]);
                if (atoms < 0.0) left -= atoms;
                else right += atoms;
            }
            if (fabs(left - right) < PDI_REACTION_TOLERANCE) continue;
            pd_species_get_symbol(species[i].element[k], symbol);
            return pd_fail(ctx, PD_ERR_PARSE, "reaction", "'%s' does not balance: %g %s on the left, %g on the right: "
                           "correct a factor, or add what is missing, such as H2O or H+", r->name, left, symbol,
                           right);
        }
    }
    double left = 0.0, right = 0.0;
    for (int i = 0; i < count; i++) {
        if (r->nu[i] < 0.0) left -= r->nu[i] * species[i].charge;
        else right += r->nu[i] * species[i].charge;
    }
    if (fabs(left - right) < PDI_REACTION_TOLERANCE) return PD_OK;
    return pd_fail(ctx, PD_ERR_PARSE, "reaction", "'%s' does not balance: the charge is %+g on the left, %+g on "
                   "the right: correct a factor, or add what is missing, such as H+, OH- or e-", r->name, left,
                   right);
}

/* Sets K and rate constants from desc, after a check of their units; kb = kf/K or kf = kb K where one is missing and
 * there is a K, else 0 (eq. 7.3). Only solutes count in the orders. PD_ERR_PARSE: a unit does not fit, neither K nor
 * rate. PD_ERR_ARGUMENT: K is not positive, a rate is negative, not finite or overflows, K and both rates. */
static pd_status pdi_reaction_set_constants(pd_ctx *ctx, const pd_reaction_desc *desc, const pd_species *species,
                                            int count, pd_reaction *r)
{
    double left = 0.0, right = 0.0, scale;
    for (int i = 0; i < count; i++) {
        if (species[i].phase != PD_PHASE_SOLUTE) continue;
        if (r->nu[i] < 0.0) left -= r->nu[i];
        else right += r->nu[i];
    }
    r->has_k = !isnan(desc->k);
    r->kinetic = desc->forward != 0.0 || desc->backward != 0.0;
    if (!r->has_k && !r->kinetic)
        return pd_fail(ctx, PD_ERR_PARSE, "reaction", "'%s' has neither a constant of equilibrium nor a rate",
                       r->name);
    if (r->has_k && desc->k_unit && strcmp(desc->k_unit, "log10") == 0) {
        r->ln_k = desc->k * log(10.0);
    } else if (r->has_k) {
        PD_TRY(pdi_reaction_check_unit(ctx, r->name, "K", desc->k_unit, right - left, 0.0, &scale));
        r->ln_k = log(desc->k) + log(scale) - (right - left) * log(1e3);
    }
    if (r->has_k && !(fabs(r->ln_k) < HUGE_VAL))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reaction", "K of '%s' is %g, expected a positive number", r->name,
                       desc->k);
    if (!r->kinetic) return PD_OK;
    if (!(desc->forward >= 0.0) || !(desc->backward >= 0.0) || !(desc->forward + desc->backward < HUGE_VAL))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reaction", "the rates of '%s' are %g and %g, expected positive numbers",
                       r->name, desc->forward, desc->backward);
    if (r->has_k && desc->forward > 0.0 && desc->backward > 0.0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reaction", "'%s' has K and both rates: one follows from the others, "
                       "drop it",
                       r->name);
    double both = r->ln_k + (right - left) * log(1e3); /* logarithm of forward over backward, in mol/m3 */
    if (desc->forward > 0.0) {
        PD_TRY(pdi_reaction_check_unit(ctx, r->name, "the forward rate", desc->forward_unit, 1.0 - left, 1.0, &scale));
        r->forward = desc->forward * scale;
        if (r->has_k) r->backward = exp(log(r->forward) - both);
    }
    if (desc->backward > 0.0) {
        PD_TRY(
            pdi_reaction_check_unit(ctx, r->name, "the backward rate", desc->backward_unit, 1.0 - right, 1.0, &scale));
        r->backward = desc->backward * scale;
        if (r->has_k) r->forward = exp(log(r->backward) + both);
    }
    if (r->forward < HUGE_VAL && r->backward < HUGE_VAL) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "reaction", "a rate of '%s' overflows with its K", r->name);
}

/* pd_reaction_read from name to constants; without a name the text is the name. Errors as there. The caller clears r
 * after an error. */
static pd_status pdi_reaction_try_read(pd_ctx *ctx, const pd_reaction_desc *desc, const pd_species *species, int count,
                                       pd_reaction *r)
{
    const char *name = desc->name && *desc->name ? desc->name : desc->text;
    if (!desc->text)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reaction", "desc.text is NULL, expected a text such as H+ + OH- = H2O");
    snprintf(r->name, sizeof r->name, "%.*s", (int)sizeof r->name - 1, name);
    if (count < 1 || count > PD_SPECIES_MAX)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reaction", "%d species, expected 1 to %d", count, PD_SPECIES_MAX);
    PD_TRY(pdi_reaction_parse_terms(ctx, desc->text, species, count, -1.0, r));
    PD_TRY(pdi_reaction_check_balance(ctx, species, count, r));
    return pdi_reaction_set_constants(ctx, desc, species, count, r);
}

PDI_FN pd_status pdi_reaction_parse_sum(pd_ctx *ctx, const char *name, const char *text, const pd_species *species,
                                        int count, pd_reaction *r)
{
    memset(r, 0, sizeof *r);
    snprintf(r->name, sizeof r->name, "%.*s", (int)sizeof r->name - 1, name);
    return pdi_reaction_parse_terms(ctx, text, species, count, 1.0, r);
}

pd_status pd_reaction_read(pd_ctx *ctx, const pd_reaction_desc *desc, const pd_species *species, int count,
                           pd_reaction *r)
{
    memset(r, 0, sizeof *r);
    pd_status status = pdi_reaction_try_read(ctx, desc, species, count, r);
    if (status < 0) memset(r, 0, sizeof *r);
    return status;
}

double pd_reaction_rate(const pd_reaction *r, const pd_species *species, int count, const double *c)
{
    double forward = r->forward, backward = r->backward;
    for (int i = 0; i < count; i++) {
        if (species[i].phase != PD_PHASE_SOLUTE || r->nu[i] == 0.0) continue;
        if (r->nu[i] < 0.0) forward *= pow(c[i], -r->nu[i]);
        else backward *= pow(c[i], r->nu[i]);
    }
    return forward - backward;
}
