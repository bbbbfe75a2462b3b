/* speciation_report: see speciation_report.h */
#include "run/speciation_report.h"
#include "io/file.h"
#include "scene/input_files.h"
#include "setup/setup.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PDI_SPECIATION_REPORT_LINE_BYTES 4096 /* [byte] of a line of text */
#define PDI_SPECIATION_REPORT_MAX_ROWS 100000 /* most rows of a table */
#define PDI_SPECIATION_REPORT_MAX_ELEMENT 118
#define PDI_SPECIATION_REPORT_ZERO_CELSIUS 273.15 /* [K] of 0 C */

/* The electrolyte, and where text is printed. */
typedef struct pdi_speciation_report_context {
    const pd_speciation_report_desc *desc;
    pd_electrolyte electrolyte;
    char name[PD_SETUP_NAME];
} pdi_speciation_report_context;

/* Print a formatted line. */
PD_PRINTF_LIKE(3, 4)
/* Print a line, printf style, through the print callback of the caller, which must be set; what exceeds
 * PDI_SPECIATION_REPORT_LINE_BYTES is cut off. */
static void pdi_speciation_report_print(const pdi_speciation_report_context *w, pd_print_kind kind, const char *format,
                                        ...)
{
    char line[PDI_SPECIATION_REPORT_LINE_BYTES];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    w->desc->print(w->desc->user, kind, line);
}

/* ---- the equilibrium ---- */

/* Print written and equilibrium concentrations c[count] [mol/m3] and log10 activities of the solutes; solvent and
 * minerals are skipped. */
static void pdi_speciation_report_print_species(const pdi_speciation_report_context *w, const double *c,
                                                const pd_electrolyte_state *s)
{
    const pd_electrolyte *e = &w->electrolyte;
    pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%-20s %14s %14s %14s", "species", "written [mM]", "there [mM]",
                                "log10 activity");
    for (int i = 0; i < e->count; i++) {
        if (e->species[i].phase != PD_PHASE_SOLUTE) continue;
        pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%-20s %14.6g %14.6g %14.4f", e->species[i].name, e->recipe[i],
                                    c[i], s->result.log_activity[i]);
    }
}

/* Print amounts [mol/m3] and saturation indices log10(IAP/K) of minerals; nothing without minerals. Returns how many
 * have an index above 1e-9. */
static int pdi_speciation_report_print_minerals(const pdi_speciation_report_context *w, const double *c,
                                                const pd_electrolyte_state *s)
{
    const pd_electrolyte *e = &w->electrolyte;
    int solids = 0, above = 0;
    for (int i = 0; i < e->count; i++) {
        if (e->species[i].phase != PD_PHASE_SOLID) continue;
        if (!solids++)
            pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%-20s %14s %14s %14s", "mineral", "written [mM]",
                                        "there [mM]", "log10 IAP/K");
        pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%-20s %14.6g %14.6g %14.4f", e->species[i].name, e->recipe[i],
                                    c[i], s->saturation[i]);
        above += s->saturation[i] > 1e-9;
    }
    return above;
}

/* Print the totals [mol/m3] of elements before and after the equilibrium, of those with a positive one; returns the
 * largest |out - in|/max(in, out) [-]. */
static double pdi_speciation_report_print_elements(const pdi_speciation_report_context *w, const double *c)
{
    double worst = 0.0;
    pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%-20s %14s %14s", "element", "in [mM]", "out [mM]");
    for (int k = 1; k <= PDI_SPECIATION_REPORT_MAX_ELEMENT; k++) {
        double in = pd_electrolyte_compute_element_total(&w->electrolyte, w->electrolyte.initial, k),
               out = pd_electrolyte_compute_element_total(&w->electrolyte, c, k);
        char symbol[3];
        if (!(in > 0.0) && !(out > 0.0)) continue;
        pd_species_get_symbol(k, symbol);
        pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%-20s %14.9g %14.9g", symbol, in, out);
        worst = pd_max(worst, fabs(out - in) / pd_max(in, out));
    }
    return worst;
}

/* Print a note for each species whose concentration was changed for charge balance or a given pH, by more than 1e-9 of
 * the written one; the amount is signed. */
static void pdi_speciation_report_print_charge_balance(const pdi_speciation_report_context *w)
{
    const pd_electrolyte *e = &w->electrolyte;
    for (int i = 0; i < e->count; i++) {
        double more = e->initial[i] - e->recipe[i];
        if (fabs(more) > 1e-9 * e->recipe[i])
            pdi_speciation_report_print(w, PD_PRINT_NOTE, "%+.6g mM %s for the charge and the pH", more,
                                        e->species[i].name);
    }
}

/* Print one note with the equilibrium constants that have no enthalpy; nothing at 25 C. */
static void pdi_speciation_report_print_missing_enthalpies(const pdi_speciation_report_context *w)
{
    char list[400] = "";
    if (fabs(w->electrolyte.temperature - PDI_SPECIATION_REPORT_ZERO_CELSIUS - 25.0) < 1e-9) return;
    for (int r = 0; r < w->electrolyte.reactions; r++)
        if (w->electrolyte.reaction[r].has_k && isnan(w->electrolyte.enthalpy[r]))
            pd_append(list, sizeof list, "%s%s", list[0] ? ", " : "", w->electrolyte.reaction[r].name);
    if (list[0])
        pdi_speciation_report_print(w, PD_PRINT_NOTE,
                                    "constants without an enthalpy, which do not follow the temperature: %s", list);
}

/* Solve the equilibrium of the inlet and print its pH where it differs from ph by more than 1e-9. Errors of
 * pd_electrolyte_solve. */
static pd_status pdi_speciation_report_print_inlet_ph(pd_ctx *ctx, const pdi_speciation_report_context *w, double ph)
{
    pd_electrolyte_state s;
    double c[PD_SPECIES_MAX];
    memcpy(c, w->electrolyte.inlet, sizeof c);
    PD_TRY(pd_electrolyte_solve(ctx, &w->electrolyte, c, &s));
    if (fabs(s.ph - ph) > 1e-9) pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "pH of the inlet      %14.4f", s.ph);
    return PD_OK;
}

/* Solve the equilibrium and print pH, ionic strength, charge, species, minerals, elements and the result line, whose
 * err_elements is the largest relative change of an element. Nothing is printed if it is not solved. */
static pd_status pdi_speciation_report_print_equilibrium(pd_ctx *ctx, const pdi_speciation_report_context *w)
{
    pd_electrolyte_state s;
    double c[PD_SPECIES_MAX];
    memcpy(c, w->electrolyte.initial, sizeof c);
    PD_TRY(pd_electrolyte_solve(ctx, &w->electrolyte, c, &s));
    pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%s: equilibrium at %.2f C, %s, %s", w->name,
                                w->electrolyte.temperature - PDI_SPECIATION_REPORT_ZERO_CELSIUS,
                                w->electrolyte.activity == PD_ACTIVITY_DAVIES ? "Davies" : "ideal",
                                w->electrolyte.all_minerals_form ? "all minerals form that can"
                                                                 : "minerals that are not there do not form");
    pdi_speciation_report_print_missing_enthalpies(w);
    pdi_speciation_report_print_charge_balance(w);
    pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "pH                   %14.4f", s.ph);
    PD_TRY(pdi_speciation_report_print_inlet_ph(ctx, w, s.ph));
    pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "ionic strength [mM]  %14.6g", s.strength);
    pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "charge [mM]          %14.3g", s.charge);
    pdi_speciation_report_print_species(w, c, &s);
    int above = pdi_speciation_report_print_minerals(w, c, &s);
    double worst = pdi_speciation_report_print_elements(w, c);
    pdi_speciation_report_print(w, PD_PRINT_RESULT,
                                "result case=%s pH=%.6f strength=%.9g charge=%.3g err_elements=%.3g "
                                "residual=%.3g iterations=%d supersaturated=%d",
                                w->name, s.ph, s.strength, s.charge, worst, s.result.residual, s.result.iterations,
                                above);
    return PD_OK;
}

/* ---- a titration ---- */

/* A titration: reagent, range of added amounts, number of rows. */
typedef struct pdi_speciation_report_titration {
    double reagent[PD_SPECIES_MAX];  /* [-] species in one unit of the reagent */
    double from, to;                 /* [mol/m3] */
    int rows;
} pdi_speciation_report_titration;

/* Error message for a titration that cannot be read. Returns PD_ERR_PARSE. */
static pd_status pdi_speciation_report_reject_titration(pd_ctx *ctx, const char *text)
{
    return pd_fail(ctx, PD_ERR_PARSE, "titrate",
                   "found '%.80s', expected a reagent, a range with its unit and a "
                   "number of rows from 2 to %d, such as Na+ + OH- 0..1 mM 21",
                   text, PDI_SPECIATION_REPORT_MAX_ROWS);
}

/* Read the decimal number at text, behind blanks; *end: what follows it. 1: done; 0: there is none. */
static int pdi_speciation_report_parse_amount(char *text, double *value, char **end)
{
    text += strspn(text, " \t");
    size_t length = pdi_file_find_number_length(text, strlen(text));
    *end = text + length;
    return pdi_file_parse_number(text, length, value);
}

/* Parse "REAGENT FROM..TO UNIT ROWS" into t, amounts in mol/m3. PD_ERR_PARSE: a part is missing, the unit is no
 * concentration, rows are not 2 to 100000, an amount is not finite, or the text has 512 bytes or more. FROM may be
 * above TO, and negative. Errors of pd_electrolyte_reagent. */
static pd_status pdi_speciation_report_parse_titration(pd_ctx *ctx, const pd_electrolyte *e, const char *text,
                                                       pdi_speciation_report_titration *t)
{
    char copy[512], *end, *dots, *from;
    pd_dims dims, wanted;
    double scale;
    if (strlen(text) >= sizeof copy) return pdi_speciation_report_reject_titration(ctx, text);
    strcpy(copy, text);
    dots = strstr(copy, "..");
    if (!dots) return pdi_speciation_report_reject_titration(ctx, text);
    for (from = dots; from > copy && pd_units_is_blank(from[-1]);) *--from = '\0';
    *dots = '\0';
    while (from > copy && !pd_units_is_blank(from[-1])) from--;
    if (!pdi_speciation_report_parse_amount(from, &t->from, &end) || *end || from == copy)
        return pdi_speciation_report_reject_titration(ctx, text);
    from[-1] = '\0';
    if (!pdi_speciation_report_parse_amount(dots + 2, &t->to, &end))
        return pdi_speciation_report_reject_titration(ctx, text);
    char *rows = strrchr(end, ' '), *unit = end;
    if (!rows) return pdi_speciation_report_reject_titration(ctx, text);
    long count = strtol(rows, &end, 10);
    if (end == rows || *end || count < 2 || count > PDI_SPECIATION_REPORT_MAX_ROWS)
        return pdi_speciation_report_reject_titration(ctx, text);
    t->rows = (int)count;
    *rows = '\0';
    unit += strspn(unit, " ");
    pd_units_parse(ctx, "mol/m3", NULL, &wanted);
    if (pd_units_parse(ctx, unit, &scale, &dims) < 0 || !pd_units_is_same(&dims, &wanted))
        return pdi_speciation_report_reject_titration(ctx, text);
    t->from *= scale;
    t->to *= scale;
    if (!(fabs(t->from) < HUGE_VAL) || !(fabs(t->to) < HUGE_VAL))
        return pdi_speciation_report_reject_titration(ctx, text);
    return pd_electrolyte_reagent(ctx, e, copy, t->reagent);
}

/* Print the header of the titration table: added amount, pH, ionic strength, all species but the solvent, and the
 * saturation index of each mineral. */
static void pdi_speciation_report_print_header(const pdi_speciation_report_context *w)
{
    char line[PDI_SPECIATION_REPORT_LINE_BYTES] = "added [mol/m3],pH [-],strength [mol/m3]";
    for (int i = 0; i < w->electrolyte.count; i++)
        if (w->electrolyte.species[i].phase != PD_PHASE_SOLVENT)
            pd_append(line, sizeof line, ",%s [mol/m3]", w->electrolyte.species[i].name);
    for (int i = 0; i < w->electrolyte.count; i++)
        if (w->electrolyte.species[i].phase == PD_PHASE_SOLID)
            pd_append(line, sizeof line, ",SI %s [-]", w->electrolyte.species[i].name);
    pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%s", line);
}

/* Print a row of the titration table for `added` [mol/m3] of the reagent. */
static void pdi_speciation_report_print_row(const pdi_speciation_report_context *w, double added, const double *c,
                                            const pd_electrolyte_state *s)
{
    char line[PDI_SPECIATION_REPORT_LINE_BYTES] = "";
    pd_append(line, sizeof line, "%.9g,%.9g,%.9g", added, s->ph, s->strength);
    for (int i = 0; i < w->electrolyte.count; i++)
        if (w->electrolyte.species[i].phase != PD_PHASE_SOLVENT) pd_append(line, sizeof line, ",%.9g", c[i]);
    for (int i = 0; i < w->electrolyte.count; i++)
        if (w->electrolyte.species[i].phase == PD_PHASE_SOLID) pd_append(line, sizeof line, ",%.9g", s->saturation[i]);
    pdi_speciation_report_print(w, PD_PRINT_SUMMARY, "%s", line);
}

/* Solve and print all rows of a titration, evenly spaced in the added amount with both ends, each from the initial
 * composition, and a result line with the first and last pH. PD_ERR_ARGUMENT: more of a species (not the solvent) is
 * taken than there is; the rows before are printed. */
static pd_status pdi_speciation_report_print_titration(pd_ctx *ctx, const pdi_speciation_report_context *w,
                                                       const pdi_speciation_report_titration *t)
{
    pd_electrolyte_state s;
    double c[PD_SPECIES_MAX], first = NAN;
    pdi_speciation_report_print_header(w);
    for (int k = 0; k < t->rows; k++) {
        double added = t->from + (t->to - t->from) * k / (t->rows - 1);
        for (int i = 0; i < w->electrolyte.count; i++) {
            c[i] = w->electrolyte.initial[i] + added * t->reagent[i];
            if (c[i] < 0.0 && w->electrolyte.species[i].phase != PD_PHASE_SOLVENT)
                return pd_fail(ctx, PD_ERR_ARGUMENT, "titrate", "%g mol/m3 of the reagent take more %s than there is",
                               added, w->electrolyte.species[i].name);
        }
        PD_TRY(pd_electrolyte_solve(ctx, &w->electrolyte, c, &s));
        if (!k) first = s.ph;
        pdi_speciation_report_print_row(w, added, c, &s);
    }
    pdi_speciation_report_print(w, PD_PRINT_RESULT, "result case=%s rows=%d pH_first=%.6f pH_last=%.6f", w->name,
                                t->rows, first, s.ph);
    return PD_OK;
}

/* Read the electrolyte and print its equilibrium or titration; *bad_input: 1: the file or the titration text is
 * refused, 0: solved, or not solved. */
static pd_status pdi_speciation_report_execute(pd_ctx *ctx, pdi_speciation_report_context *w, int *bad_input)
{
    pdi_speciation_report_titration t;
    memset(&t, 0, sizeof t);
    *bad_input = 1;
    PD_TRY(pd_electrolyte_read(ctx, w->desc->path, w->desc->overrides, w->desc->count, &w->electrolyte));
    if (w->desc->titrate) PD_TRY(pdi_speciation_report_parse_titration(ctx, &w->electrolyte, w->desc->titrate, &t));
    *bad_input = 0;
    return w->desc->titrate ? pdi_speciation_report_print_titration(ctx, w, &t)
                            : pdi_speciation_report_print_equilibrium(ctx, w);
}

pd_status pd_speciation_report_print(pd_ctx *ctx, const pd_speciation_report_desc *desc, int *bad_input)
{
    pdi_speciation_report_context *w = NULL;
    PD_TRY(PD_NEW(ctx, "speciate", 1, w));
    w->desc = desc;
    pdi_input_files_split_path(desc->path, w->name, NULL);
    pd_status status = pdi_speciation_report_execute(ctx, w, bad_input);
    if (pd_is_fatal(status)) *bad_input = 0;
    PD_DELETE(ctx, 1, w);
    return status;
}
