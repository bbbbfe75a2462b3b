/* chemistry: equilibria of electrolytes without a lattice, against tables of pH. Included by cases.h alone. */
#ifndef VAL_CHEMISTRY_H
#define VAL_CHEMISTRY_H
#include "case.h"

#if PD_DIM == 1
#define CHEMISTRY_WATER "[species H+]\n[species OH-]\n[species Na+]\n[species Cl-]\n"

/* Text of an electrolyte to its equilibrium with `added` [mol/m3] of a reagent. */
static pd_status chemistry_ph(pd_ctx *ctx, const char *text, const char *reagent, double added, double *c, double *ph)
{
    static pd_electrolyte e;
    pd_electrolyte_state s;
    double per[PD_SPECIES_MAX];
    PD_TRY(pd_electrolyte_parse(ctx, "case", text, NULL, 0, &e));
    memset(per, 0, sizeof per);
    if (reagent) PD_TRY(pd_electrolyte_reagent(ctx, &e, reagent, per));
    for (int i = 0; i < e.count; i++) c[i] = e.initial[i] + added * per[i];
    PD_TRY(pd_electrolyte_solve(ctx, &e, c, &s));
    *ph = s.ph;
    return PD_OK;
}

/* ---- brucite ---- */

/* Mg(OH)2 in water. Constants of databases, salt; pH ideal without MgOH+, with Davies and MgOH+, and Mg in all then. */
static const struct chemistry_brucite {
    double log_k, p_kw, salt; /* salt: [mol/L] of NaCl */
    double ideal, davies, mg; /* mg: [mmol/L] of Mg2+ */
} chemistry_brucites[] = {
    {16.298, 14.00, 0.0, 10.200, 10.212, 0.0806},   {16.750, 14.00, 0.0, 10.350, 10.365, 0.1140},
    {16.792, 14.00, 0.0, 10.364, 10.380, 0.1177},   {16.840, 14.00, 0.0, 10.380, 10.396, 0.1221},
    {16.840, 14.00, 0.145, 10.380, 10.502, 0.2036}, {17.100, 14.00, 0.0, 10.467, 10.485, 0.1488},
    {18.794, 14.00, 0.0, 11.032, 11.077, 0.5264},   {15.970, 13.61, 0.145, 9.960, 10.080, 0.1920}};

static pd_status chemistry_brucite_run(val_job *job)
{
    const struct chemistry_brucite *b = &chemistry_brucites[(int)job->level.p - 1];
    for (int davies = 0; davies < 2; davies++) {
        char text[1024], complex[160] = "";
        double c[PD_SPECIES_MAX], ph;
        if (davies)
            snprintf(complex, sizeof complex,
                     "[species MgOH+]\n[reaction MgOH] Mg2+ + H2O = MgOH+ + H+  log10_K = -11.44\n");
        snprintf(text, sizeof text,
                 "[species Mg2+]\n" CHEMISTRY_WATER "[species Na+] initial = %g mol/L\n"
                 "[species Cl-] initial = %g mol/L\n"
                 "[species Mg(OH)2(s)] initial = 10 mM\n[chemistry] activity = %s  temperature = %g K\n"
                 "[reaction water] H2O = H+ + OH-  log10_K = %g\n"
                 "[reaction brucite] Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O  log10_K = %g\n%s",
                 b->salt, b->salt, davies ? "davies" : "ideal", b->p_kw < 14.0 ? 310.15 : 298.15, -b->p_kw, b->log_k,
                 complex);
        PD_TRY(chemistry_ph(job->ctx, text, NULL, 0.0, c, &ph));
        job->out->err[davies] = fabs(ph - (davies ? b->davies : b->ideal));
        if (davies) job->out->err[2] = fabs(c[0] / b->mg - 1.0);
    }
    return PD_OK;
}

/* ---- titrations ---- */

/* [mmol/L] of OH- that is added, pH of HBSS with carbonate and phosphate, and of saline of 0.145 mol/L; ideal. HBSS
 * has 4.17 mmol/L of HCO3- itself at pH 7.4, with CO2 and CO3-2 beside it, and 0.78 of phosphate in all. */
static const double chemistry_titration[][3] = {
    {0.0, 7.400, 7.000},  {0.05, 7.442, 9.699},  {0.1, 7.486, 10.000},  {0.2, 7.585, 10.301},
    {0.3, 7.701, 10.477}, {0.5, 8.027, 10.699},  {0.75, 8.734, 10.875}, {1.0, 9.214, 11.000},
    {1.5, 9.649, 11.176}, {2.0, 9.906, 11.301},  {3.0, 10.275, 11.477}, {5.0, 10.878, 11.699}};
enum { CHEMISTRY_POINTS = (int)(sizeof chemistry_titration / sizeof chemistry_titration[0]) };

#define CHEMISTRY_SALINE \
    "[chemistry] activity = ideal\n" CHEMISTRY_WATER "[species Na+] initial = 145 mM\n" \
    "[species Cl-] initial = 145 mM\n[reaction water] H2O = H+ + OH-  log10_K = -14\n"
#define CHEMISTRY_HBSS \
    "[chemistry] activity = ideal  pH = 7.4  counter_ion = Cl-  balance_ion = Na+\n" CHEMISTRY_WATER \
    "[species Na+] initial = 145.73 mM\n[species Cl-] initial = 140 mM\n[species HCO3-] initial = 4.17 mM\n" \
    "[species HPO4-2] initial = 0.78 mM\n[species H2PO4-]\n[species PO4-3]\n" \
    "[species CO3-2] initial = 4.17 mM * 10^(7.4 - 10.329)\n" \
    "[species CO2] initial = 4.17 mM * 10^(6.352 - 7.4)\n" \
    "[reaction water] H2O = H+ + OH-  log10_K = -14\n[reaction a] CO2 + H2O = HCO3- + H+  log10_K = -6.352\n" \
    "[reaction b] HCO3- = CO3-2 + H+  log10_K = -10.329\n[reaction c] H2PO4- = HPO4-2 + H+  log10_K = -7.207\n" \
    "[reaction d] HPO4-2 = PO4-3 + H+  log10_K = -12.346\n"

static pd_status chemistry_titration_run(val_job *job)
{
    static const char *const texts[] = {CHEMISTRY_HBSS, CHEMISTRY_SALINE}, *const names[] = {"HBSS", "saline"};
    for (int k = 0; k < 2; k++) {
        char name[48];
        snprintf(name, sizeof name, "%s, table", names[k]);
        val_curve *found = val_add_curve(job, names[k], PD_SERIES_STYLE_LINE);
        val_curve *wanted = val_add_curve(job, name, PD_SERIES_STYLE_MARKERS);
        for (int i = 0; i < CHEMISTRY_POINTS; i++) {
            double c[PD_SPECIES_MAX], ph, added = chemistry_titration[i][0];
            PD_TRY(chemistry_ph(job->ctx, texts[k], "Na+ + OH-", added, c, &ph));
            job->out->err[k] = fmax(job->out->err[k], fabs(ph - chemistry_titration[i][1 + k]));
            val_add_point(found, added, ph);
            val_add_point(wanted, added, chemistry_titration[i][1 + k]);
        }
    }
    if (job->profile) {
        job->profile->title = "titration with NaOH";
        job->profile->x_label = "added [mmol/L]";
        job->profile->y_label = "pH";
    }
    return PD_OK;
}

static const val_part chemistry_brucite_part = {
    "brucite", "Mg(OH)2 in water and saline", "row of the table", VAL_BY_P, "row of the table", 0.0,
    {{"err_ideal", "pH, ideal"}, {"err_davies", "pH, Davies and MgOH+"}, {"err_mg", "Mg2+, relative"}}, 3,
    {{0, 0.02, 0.0, 0, VAL_GOAL}, {1, 0.02, 0.0, 0, VAL_GOAL}, {2, 0.02, 0.0, 0, VAL_GUARD}}, 3,
    {{0, 0.0, 1.0}, {0, 0.0, 2.0}, {0, 0.0, 3.0}, {0, 0.0, 4.0}, {0, 0.0, 5.0}, {0, 0.0, 6.0}, {0, 0.0, 7.0},
     {0, 0.0, 8.0}}, 8, 8, chemistry_brucite_run, NULL};

static const val_part chemistry_titration_part = {
    "titration", "NaOH into HBSS and into saline", "points", VAL_BY_P, "points", 0.0,
    {{"err_hbss", "pH of HBSS"}, {"err_saline", "pH of saline"}}, 2,
    {{0, 0.02, 0.0, 0, VAL_GOAL}, {1, 0.02, 0.0, 0, VAL_GOAL}}, 2,
    {{0, 0.0, CHEMISTRY_POINTS}}, 1, 1, chemistry_titration_run, NULL};

static const val_part *const chemistry_parts[] = {&chemistry_brucite_part, &chemistry_titration_part};

static const val_case chemistry_case = {
    "chemistry", "pH of brucite, HBSS and saline",
    "The equilibrium of Mg(OH)2 with water at 25 C for the constants of six sources, in saline of 0.145 mol/L at 25 C "
    "and 37 C, ideal and with Davies' activities and MgOH+; and the pH of HBSS and of saline as NaOH comes in, in a "
    "closed volume without minerals, ideal.",
    "Constants whose unit or direction is misread, charges that are not counted in the ionic strength, acid and base "
    "that are mixed up, a buffer whose total drifts.",
    "constants of PHREEQC's databases (llnl, minteq, wateq4f, sit, minteq.v4, phreeqc); tables computed apart, at 37 C "
    "with the A of Davies' equation at 25 C",
    chemistry_parts, 2};

#endif
#endif
