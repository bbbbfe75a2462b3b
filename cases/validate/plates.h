/* plates: electrodes among ions that migrate: two plates of one metal that are wired to each other (../plates.h), and
 * iron that rusts by the oxygen that reaches it. Included by cases.h alone. */
#ifndef VAL_PLATES_H
#define VAL_PLATES_H
#include "case.h"
#include "../plates.h"

#if PD_DIM < 3
/* A figure of an electrode at the end of a scene, with its ledger and the balance of its currents; job->out->err[4]:
 * the state q of its surface, times the share of metal that is gone. */
static pd_status plates_figures(val_job *job, const char *text, const char *name, double *current, double *e)
{
    double passed = NAN;
    pd_scalar_outputs figures;
    pd_run_result result;
    pd_setup setup;
    pd_run_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(&figures, 0, sizeof figures);
    desc.no_files = 1;
    desc.figures = &figures;
    PD_TRY(pd_scene_parse(job->ctx, "case", text, NULL, 0, &setup));
    pd_status status = pd_run(job->ctx, &setup, &desc, &result);
    for (int k = 0; k < figures.count && status == PD_OK; k++) {
        if (strcmp(figures.list[k].name, "q") == 0 && strcmp(figures.list[k].key, "mean") == 0)
            passed = figures.list[k].value;
        if (strcmp(figures.list[k].name, name) != 0) continue;
        if (strcmp(figures.list[k].key, "anodic") == 0) *current = figures.list[k].value;
        if (strcmp(figures.list[k].key, "E") == 0) *e = figures.list[k].value;
    }
    pd_scalar_outputs_free(job->ctx, &figures);
    pd_setup_free(job->ctx, &setup);
    PD_TRY(status);
    job->out->h = result.h;
    job->out->steps = (long)result.steps;
    job->out->err[2] = result.mass_balance_error;
    job->out->err[3] = result.current_balance;
    job->out->err[4] = result.volume_loss / passed;
    return PD_OK;
}

#if PD_DIM == 1
#define PLATES_BOX(from, to) #from " um .. " #to " um"
#define PLATES_SIDES
#define PLATES_HEIGHT 1.0
#else
#define PLATES_BOX(from, to) #from " um .. " #to " um, 0 um .. 30 um"
#define PLATES_SIDES "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#define PLATES_HEIGHT 3e-5
#endif
/* Two plates and the gap between them; for h [um] and m. */
#define PLATES_OF(first, metal, second, other) \
    "[grid] h = %.17g um  m = %g  box = " PLATES_BOX(0, 200) "\n" \
    "[shape " first "] kind = solid  material = " metal "  box = " PLATES_BOX(0, 50) "\n" \
    "[shape " second "] kind = solid  material = " other "  box = " PLATES_BOX(150, 200) "\n" PLATES_SIDES

/* p: step [V] between the lines of Tafel. */
static pd_status plates_run(val_job *job)
{
    plates p = {0.71e-9, 1e-4, 0.5, 40.5, 10.0, 0.06, 0.12, 0.0, 20.0};
    char text[2048];
    double current = 0.0, e = 0.0;
    p.step = job->level.p;
    plates_state wanted = plates_wired(&p);
    snprintf(text, sizeof text,
             PLATES_OF("anode", "steel304", "cathode", "steel304")
             "[chemistry] activity = ideal  migration = yes\n[species Cu2+] D = 0.71e-9 m2/s  initial = 20 mol/m3\n"
             "[species Na+] D = 1.33e-9 m2/s  initial = 0.5 mol/m3\n"
             "[species Cl-] D = 2.03e-9 m2/s  initial = 40.5 mol/m3\n[potential]\n"
             "[electrode anode] shape = anode  curve = tafel  i0 = 10 A/m2  anodic_slope = 60 mV\n"
             "reaction = Cu = Cu2+ + 2 e-  connected = cathode\n"
             "[electrode cathode] shape = cathode  curve = expression  reaction = Cu2+ + 2 e- = Cu\n"
             "i = -10 A/m2*[Cu2+]/(20 mol/m3)*10^(-(E - %.17g V)/(120 mV))\n[run] until = 1000 s\n",
             100.0 / job->level.n, job->level.m, p.step);
    PD_TRY(plates_figures(job, text, "anode", &current, &e));
    job->out->err[0] = fabs(current / (PLATES_HEIGHT * wanted.current) - 1.0);
    job->out->err[1] = fabs(e - wanted.anode) / PLATES_VOLT;
    return PD_OK;
}

#define PLATES_CS 1e8 /* [mol/m3] so much that the plate stays where it is */

/* Two metals: the anode dissolves by its law, and the state q of its surface is the charge that has passed. */
static pd_status plates_dissolves_run(val_job *job)
{
    plates p = {0.71e-9, 1e-4, 50.0, 250.0, 10.0, 0.06, 0.12, 0.1, 0.0};
    char text[2048];
    double current = 0.0, e = 0.0;
    plates_state wanted = plates_wired(&p);
    snprintf(text, sizeof text,
             PLATES_OF("anode", "steel304", "cathode", "mg4ag")
             "[chemistry] activity = ideal  migration = yes\n[species Cu2+] D = 0.71e-9 m2/s  initial = 100 mol/m3\n"
             "[species Na+] D = 1.33e-9 m2/s  initial = 50 mol/m3\n"
             "[species Cl-] D = 2.03e-9 m2/s  initial = 250 mol/m3\n[potential]\n[transport] D = 1e-9 m2/s\n"
             "[dissolve] reaction = Cu = Cu2+ + 2 e-\n[dissolve steel304] charge = 2  Cs = %g mol/m3\n"
             "current = 10 A/m2*10^(E/(60 mV))\n[dissolve mg4ag] rate = 0  Cs = %g mol/m3\n"
             "[electrode anode] shape = anode  connected = cathode\n"
             "[electrode cathode] shape = cathode  curve = tafel  i0 = 10 A/m2  E0 = 100 mV  cathodic_slope = 120 mV\n"
             "reaction = Cu2+ + 2 e- = Cu\n[surface q] of = anode  initial = 0 C/m2  rate = i\n"
             "[run] until = 200 s\n", 100.0 / job->level.n, job->level.m, PLATES_CS, PLATES_CS);
    PD_TRY(plates_figures(job, text, "anode", &current, &e));
    job->out->err[0] = fabs(current / (PLATES_HEIGHT * wanted.current) - 1.0);
    job->out->err[1] = fabs(e - wanted.anode) / PLATES_VOLT;
    job->out->err[4] = fabs(job->out->err[4] * 1e-4 * PLATES_CS * 2.0 * PLATES_FARADAY - 1.0);
    return PD_OK;
}

/* Each plate dissolves into its own ion and takes up that of the other. */
static pd_status plates_exchange_run(val_job *job)
{
    static const plates_exchange p = {
        {0.71e-9, 1e-4, 50.0, 250.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.71e-9, 0.5e-9}, {10.0, 12.0}, {0.0, 0.05},
        {0.06, 0.12}, {20.0, 20.0}, {0.0, 0.1}, {0.12, 0.12}, 100.0};
    static const char *const names[] = {"cu", "zn"};
    char text[2048];
    double e = 0.0;
    plates_exchanged wanted = plates_exchange_at(&p);
    snprintf(text, sizeof text,
             PLATES_OF("cu", "copper", "zn", "mg4ag")
             "[chemistry] activity = ideal  migration = yes\n[species Cu2+] D = 0.71e-9 m2/s  initial = 50 mol/m3\n"
             "[species Zn2+] D = 0.5e-9 m2/s  initial = 50 mol/m3\n"
             "[species Na+] D = 1.33e-9 m2/s  initial = 50 mol/m3\n"
             "[species Cl-] D = 2.03e-9 m2/s  initial = 250 mol/m3\n[potential]\n[transport] D = 1e-9 m2/s\n"
             "[dissolve copper] charge = 2  Cs = %g mol/m3  reaction = Cu = Cu2+ + 2 e-\n"
             "current = 10 A/m2*10^(E/(60 mV))\n"
             "[dissolve mg4ag] charge = 2  Cs = %g mol/m3  reaction = Zn = Zn2+ + 2 e-\n"
             "current = 12 A/m2*10^((E - 50 mV)/(120 mV))\n"
             "[electrode cu] shape = cu  connected = zn  curve = expression  reaction = Zn2+ + 2 e- = Zn\n"
             "i = -20 A/m2*[Zn2+]/(100 mol/m3)*10^(-E/(120 mV))\n"
             "[electrode zn] shape = zn  curve = expression  reaction = Cu2+ + 2 e- = Cu\n"
             "i = -20 A/m2*[Cu2+]/(100 mol/m3)*10^(-(E - 100 mV)/(120 mV))\n[run] until = 1e5 s\n",
             100.0 / job->level.n, job->level.m, 100.0 * PLATES_CS, 100.0 * PLATES_CS);
    job->out->err[0] = 0.0;
    for (int k = 0; k < 2; k++) {
        double current = 0.0;
        PD_TRY(plates_figures(job, text, names[k], &current, &e));
        job->out->err[0] = fmax(job->out->err[0], fabs(current / (PLATES_HEIGHT * wanted.current[k]) - 1.0));
    }
    job->out->err[1] = fabs(e - wanted.potential) / PLATES_VOLT;
    return PD_OK;
}

/* Iron 0.1 mm from water with oxygen, which does not migrate: i of the law is i of what diffuses. */
static pd_status plates_rust_run(val_job *job)
{
    char text[2048];
    double current = 0.0, e = 0.0, low = -1.0, high = 0.0, i = 0.0, u = 0.0;
    double most = 4.0 * PLATES_FARADAY * 2e-9 * 0.25 / 1e-4;
    for (int k = 0; k < 100; k++) {
        u = 0.5 * (low + high);
        double curve = 0.001 * pow(10.0, -(u + 0.1) / 0.12);
        i = most * curve / (most + curve);
        if (0.01 * pow(10.0, (u + 0.6) / 0.06) > i) high = u;
        else low = u;
    }
    snprintf(text, sizeof text,
             "[grid] h = %.17g um  m = %g  box = " PLATES_BOX(0, 150) "\n[side x+] species = inlet\n"
             "[shape iron] kind = solid  material = steel304  box = " PLATES_BOX(0, 50) "\n" PLATES_SIDES
             "[chemistry] activity = ideal  migration = yes\n[species Fe2+] D = 0.72e-9 m2/s\n"
             "[species Na+] D = 1.33e-9 m2/s  initial = 500 mol/m3\n"
             "[species Cl-] D = 2.03e-9 m2/s  initial = 500 mol/m3\n[species OH-] D = 5.27e-9 m2/s\n[species H2O]\n"
             "[species O2] D = 2e-9 m2/s  initial = 0.25 mol/m3\n[potential]\n[transport] D = 1e-9 m2/s\n"
             "[dissolve] charge = 2  reaction = Fe = Fe2+ + 2 e-  current = 0.01 A/m2*10^((E + 0.6 V)/(60 mV))\n"
             "[electrode iron] shape = iron  curve = expression  reaction = O2 + 2 H2O + 4 e- = 4 OH-\n"
             "i = -1 mA/m2*[O2]/(0.25 mol/m3)*10^(-(E + 0.1 V)/(120 mV))\n[run] until = 100 s\n",
             100.0 / job->level.n, job->level.m);
    PD_TRY(plates_figures(job, text, "iron", &current, &e));
    job->out->err[0] = fabs(current / (PLATES_HEIGHT * i) - 1.0);
    job->out->err[1] = fabs(e - u) / PLATES_VOLT; /* and what phi is at the metal */
    return PD_OK;
}

#define PLATES_MEASURES \
    {{"err_current", "current"}, {"err_e", "potential of the metal, in R T/F"}, {"ledger", "elements and charge"}, \
     {"currents", "sum of the currents of a circuit"}}, 4

static const val_part plates_mild_part = {
    "mild", "plates wired to each other, 0.1 V apart", "cells", VAL_BY_N, NULL, 2.0, PLATES_MEASURES,
    {{0, 1e-4, 0.0, 80, VAL_GOAL}, {0, 0.0, 1.7, 0, VAL_GOAL}, {1, 1e-3, 0.0, 0, VAL_GOAL},
     {2, 1e-12, 0.0, 0, VAL_GOAL}, {3, 1e-12, 0.0, 0, VAL_GOAL}}, 5,
    {{20, 1.0, 0.1}, {40, 1.0, 0.1}, {80, 1.0, 0.1}}, 3, 3, plates_run, NULL};

static const val_part plates_steep_part = {
    "steep", "plates near the limiting current, 0.5 V apart", "cells", VAL_BY_N, NULL, 2.0, PLATES_MEASURES,
    {{0, 1e-3, 0.0, 80, VAL_GOAL}, {0, 0.0, 1.7, 0, VAL_GOAL}, {1, 1e-2, 0.0, 80, VAL_GOAL},
     {2, 1e-12, 0.0, 0, VAL_GOAL}, {3, 1e-12, 0.0, 0, VAL_GOAL}}, 5,
    {{20, 1.0, 0.5}, {40, 1.0, 0.5}, {80, 1.0, 0.5}}, 3, 3, plates_run, NULL};

static const val_part plates_dissolves_part = {
    "dissolves", "plates of two metals, one of which dissolves by its law", "cells", VAL_BY_N, NULL, 2.0,
    {{"err_current", "current"}, {"err_e", "potential of the metal, in R T/F"}, {"ledger", "elements and charge"},
     {"currents", "sum of the currents of a circuit"}, {"err_loss", "metal that is gone, by Faraday's law"}},
    5,
    {{0, 1e-4, 0.0, 0, VAL_GOAL}, {1, 1e-3, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL},
     {3, 1e-12, 0.0, 0, VAL_GOAL}, {4, 1e-3, 0.0, 0, VAL_GOAL}}, 5,
    {{20, 1.0, 0.0}, {40, 1.0, 0.0}}, 2, 2, plates_dissolves_run, NULL};

static const val_part plates_exchange_part = {
    "exchange", "plates of two metals that both dissolve and take up each other's ions", "cells", VAL_BY_N, NULL, 2.0,
    PLATES_MEASURES,
    {{0, 1e-4, 0.0, 0, VAL_GOAL}, {1, 1e-3, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL},
     {3, 1e-12, 0.0, 0, VAL_GOAL}}, 4,
    {{20, 1.0, 0.0}, {40, 1.0, 0.0}}, 2, 2, plates_exchange_run, NULL};

static const val_part plates_rust_part = {
    "rust", "iron that rusts freely by oxygen", "cells", VAL_BY_N, NULL, 2.0, PLATES_MEASURES,
    {{0, 1e-3, 0.0, 0, VAL_GOAL}, {1, 1e-2, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL},
     {3, 1e-12, 0.0, 0, VAL_GOAL}}, 4,
    {{20, 1.0, 0.0}, {40, 1.0, 0.0}}, 2, 1, plates_rust_run, NULL};

static const val_part *const plates_parts[] = {&plates_mild_part, &plates_steep_part, &plates_dissolves_part,
                                               &plates_exchange_part, &plates_rust_part};

static const val_case plates_case = {
    "plates", "electrodes among ions that migrate",
    "Two plates of copper in CuCl2 with a little NaCl, wired to each other, of which one gives and one takes up Cu2+, "
    "far from the limiting current and near it; the same with an anode of another metal that dissolves by its law; "
    "two metals that both dissolve by their laws, each of which takes up the ions of the other; and "
    "iron that corrodes freely by the oxygen that diffuses to it. "
    "Potentials of the metals follow from their currents.",
    "A potential that is asked once a step, the fall of the potential by diffusion, the last half cell before an "
    "electrode, charge that is lost, a current that takes up more than there is.",
    "closed form of the ions between the plates with the curves of both (theory: eq. 9.5); diffusion of oxygen and "
    "the line of Tafel of iron",
    plates_parts, 5};
#endif
#endif
