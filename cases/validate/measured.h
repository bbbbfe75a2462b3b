/* measured: one set of constants for magnesium against measurements of three kinds: hydrogen, pH, scans of a wire.
 * Included by cases.h alone. */
#ifndef VAL_MEASURED_H
#define VAL_MEASURED_H
#include "case.h"

#if PD_DIM < 3
/* What a run says at its measured points, in the order of its sections. */
typedef struct measured_run {
    pd_setup setup;
    pd_run_result result;
    double computed[VAL_POINTS];
    double rms, of_spread, largest; /* [unit of the columns], [-], [unit of the columns] */
} measured_run;

static void measured_judge(measured_run *m)
{
    double square = 0.0, over = 0.0;
    int points = 0, at = 0;
    m->largest = 0.0;
    for (int s = 0; s < m->setup.measured_count; s++) {
        const pd_setup_measured *r = &m->setup.measured[s];
        for (int k = 0; k < r->points; k++, at++) {
            double off = (m->computed[at] - r->value[k]) / r->scale;
            if (isnan(off)) continue;
            points++;
            square += off * off;
            over += off * off / (r->spread[k] * r->spread[k]) * r->scale * r->scale;
            m->largest = fmax(m->largest, fabs(off));
        }
    }
    m->rms = sqrt(square / points);
    m->of_spread = sqrt(over / points);
}

/* setup stays for the caller to free. */
static pd_status measured_solve(val_job *job, const char *scene, const char *const *changes, int count, measured_run *m)
{
    pd_run_desc desc;
    memset(m, 0, sizeof *m);
    memset(&desc, 0, sizeof desc);
    desc.no_files = 1;
    desc.computed_at_points = m->computed;
    PD_TRY(pd_scene_read(job->ctx, scene, changes, count, &m->setup));
    pd_status status = pd_run(job->ctx, &m->setup, &desc, &m->result);
    if (status >= 0) measured_judge(m);
    job->out->h = m->result.h;
    job->out->steps += (long)m->result.steps;
    return status < 0 ? status : PD_OK;
}

#if PD_DIM == 1
/* ---- hydrogen ---- */

static void measured_hydrogen_curves(val_job *job, const char *name, const measured_run *m)
{
    char points[48];
    snprintf(points, sizeof points, "%s, measured", name);
    val_curve *found = val_add_curve(job, name, PD_SERIES_STYLE_LINE);
    val_curve *wanted = val_add_curve(job, points, PD_SERIES_STYLE_MARKERS);
    const pd_setup_measured *r = &m->setup.measured[0];
    for (int k = 0; k < r->points; k++) {
        val_add_point(found, r->time[k] / 3600.0, 498.0 * m->computed[k]);
        val_add_point(wanted, r->time[k] / 3600.0, 498.0 * r->value[k]);
    }
}

/* pH of saline that is saturated with the hydroxide of the scene. */
static pd_status measured_bath(val_job *job, const pd_setup *setup, double *ph)
{
    static pd_electrolyte e;
    pd_electrolyte_state s;
    double c[PD_SPECIES_MAX];
    e = setup->electrolyte;
    e.activity = PD_ACTIVITY_DAVIES;
    memset(c, 0, sizeof c);
    for (int i = 0; i < e.count; i++) {
        c[i] = e.initial[i];
        if (strcmp(e.species[i].name, "Mg(OH)2(s)") == 0) c[i] += 30.0;
    }
    PD_TRY(pd_electrolyte_solve(job->ctx, &e, c, &s));
    *ph = s.ph;
    return PD_OK;
}

static pd_status measured_hydrogen_run(val_job *job)
{
    static const char *const scenes[] = {"examples/scenes/mg_chips_1d.scene", "examples/scenes/mg_chips_sbf_1d.scene"};
    static const char *const names[] = {"saline", "SBF"};
    static measured_run m;
    double ph = 0.0;
    pd_status status = PD_OK;
    char step[40];
    const char *changes[1];
    snprintf(step, sizeof step, "run.max_step=%g min", job->level.p);
    changes[0] = step;
    for (int k = 0; k < 2 && status >= 0; k++) {
        status = measured_solve(job, scenes[k], changes, 1, &m);
        if (status >= 0) measured_hydrogen_curves(job, names[k], &m);
        if (status >= 0 && !k) status = measured_bath(job, &m.setup, &ph);
        job->out->err[k] = m.of_spread;
        job->out->err[2 + k] = 4.98 * m.rms;
        pd_setup_free(job->ctx, &m.setup);
    }
    job->out->err[4] = fabs(ph - 11.20);
    if (job->profile) {
        job->profile->title = "Hydrogen from chips of magnesium";
        job->profile->x_label = "t [h]";
        job->profile->y_label = "hydrogen [ml]";
    }
    return status;
}

static const val_part measured_part = {
    "hydrogen", "hydrogen from chips in saline and in SBF over 22 h, and the pH of the bath", "step [min]", VAL_BY_P,
    NULL, 0.0,
    {{"of_nacl", "saline: RMS over spread"}, {"of_sbf", "SBF: RMS over spread"}, {"rms_nacl", "saline: RMS [ml]"},
     {"rms_sbf", "SBF: RMS [ml]"}, {"err_ph", "pH of the bath of saline"}}, 5,
    {{0, 1.0, 0.0, 0, VAL_GOAL_OF_ALL}, {1, 1.0, 0.0, 0, VAL_GOAL}, {4, 0.08, 0.0, 0, VAL_GOAL},
     {0, 1.0, 0.0, 0, VAL_GUARD}}, 4,
    {{1, 1.0, 10.0}, {1, 1.0, 5.0}}, 2, 1, measured_hydrogen_run,
    NULL};
#endif

#if PD_DIM == 2
/* ---- pH above a disc ---- */

static void measured_disc_curves(val_job *job, const char *name, const measured_run *m, int measured)
{
    val_curve *found = val_add_curve(job, name, PD_SERIES_STYLE_LINE);
    val_curve *wanted = measured ? val_add_curve(job, "measured", PD_SERIES_STYLE_MARKERS) : NULL;
    for (int k = 0; k < m->setup.measured_count; k++) {
        double height = 1e6 * m->setup.probe[k].position[1];
        val_add_point(found, height, m->computed[k]);
        val_add_point(wanted, height, m->setup.measured[k].value[0]);
    }
}

/* p = 1: with the constants of the chips; 2: with a speed that is fitted to these points. So is the shear of both. */
static pd_status measured_disc_run(val_job *job)
{
    static const char *const names[] = {"constants of the chips", "fitted speed"}; /* p - 1 */
    static const char *const changes[] = {"constants.part=0.126"};
    static measured_run m;
    int fitted = job->level.p > 1.5;
    pd_status status = PD_OK;
    for (int own = job->profile ? 0 : 1; own < 2 && status >= 0; own++) {
        int k = own ? fitted : !fitted;
        status = measured_solve(job, "examples/scenes/mg_disc_ph_2d.scene", changes, k, &m);
        if (status >= 0) measured_disc_curves(job, names[k], &m, own);
        pd_setup_free(job->ctx, &m.setup);
    }
    job->out->err[0] = m.of_spread;
    job->out->err[1] = m.rms;
    job->out->err[2] = m.largest;
    job->out->residual = m.result.residual;
    if (job->profile) {
        job->profile->title = "pH above a disc of magnesium in HBSS";
        job->profile->x_label = "height [um]";
        job->profile->y_label = "pH";
    }
    return status;
}

/* ---- the wire ---- */

/* p = 1: with the constants of the chips, behind the phosphate of HBSS; 2: with the speed that is fitted to it. */
static pd_status measured_wire_run(val_job *job)
{
    static const char *const changes[] = {"grid.h=10 um", "constants.v=24.8 um/h/(1 + 61.3*0.78)"};
    static measured_run m;
    pd_status status = measured_solve(job, WIRE_SCENE, changes, job->level.p > 1.5 ? 1 : 2, &m);
    job->out->err[0] = m.of_spread;
    job->out->err[1] = m.rms;
    job->out->err[2] = m.largest;
    job->out->residual = m.result.residual;
    if (job->profile && status >= 0) wire_curves(&m.setup.measured[0], m.computed, job->profile);
    pd_setup_free(job->ctx, &m.setup);
    return status;
}

#define MEASURED_LEVELS {{2, 1.0, 2.0}, {1, 1.0, 1.0}}, 2, 1
static const val_part measured_disc_part = {
    "disc", "pH above a disc in a stream of HBSS", "constants: 1 of the chips, 2 fitted", VAL_BY_P, NULL, 0.0,
    {{"of_spread", "RMS over spread"}, {"rms", "RMS [pH]"}, {"largest", "largest difference [pH]"}}, 3,
    {{0, 1.0, 0.0, 0, VAL_GOAL_OF_ALL}, {1, 0.2, 0.0, 2, VAL_GUARD}}, 2, MEASURED_LEVELS, measured_disc_run,
    "With the constants of the chips the disc gives eight times the base that its pH asks for. Calcite or amorphous "
    "calcium phosphate in equilibrium raise that speed by less than a factor of two, and leave pH 10.6 at the speed of "
    "the chips: the stream brings too little calcium and phosphate. How a film of twelve hours slows metal is "
    "measured nowhere apart from this. The shear is not printed, but fitted."};

static const val_part measured_wire_part = {
    "wire", "scans of a Mg-4Ag wire at 37 C", "constants: 1 of the chips, 2 fitted", VAL_BY_P, NULL, 0.0,
    {{"of_spread", "RMS over spread"}, {"rms", "RMS [% of volume]"}, {"largest", "largest difference [% of volume]"}},
    3,
    {{0, 1.0, 0.0, 0, VAL_GOAL_OF_ALL}, {1, 0.5, 0.0, 2, VAL_GUARD}}, 2, MEASURED_LEVELS, measured_wire_run,
    "The wire dissolves 3.2 times as fast as the constants of the chips say. They are of commercially pure magnesium "
    "at 22 C, and it is Mg-4Ag at 37 C: nothing measured here tells silver and 15 K apart, and neither is in the "
    "law."};
#endif

static const val_part *const measured_parts[] = {
#if PD_DIM == 1
    &measured_part
#else
    &measured_disc_part, &measured_wire_part
#endif
};

static const val_case measured_case = {
    "measured", "One set of constants against three measurements",
    "Chips and disc are of commercially pure magnesium at 22 C, the wire is of Mg-4Ag at 37 C. Hydrogen from chips in "
    "saline gives the speed of bare magnesium, the thickness of hydroxide that halves it and how unequal chips are, "
    "the wire the time in which a surface becomes active, hydrogen in SBF by how much phosphate slows it: five numbers "
    "for 20, 9 and 20 points. With them the pH above a disc in HBSS, 8 points, and the loss of the wire are predicted, "
    "and beside that computed with a speed that is fitted to each. The shear above the disc is fitted, too.",
    "Laws that describe one experiment alone; a bath whose pH is that of another hydroxide; film that does not count.",
    "Barzegari 2021 and thesis (chips, disc), Reimers et al. 2023 (wire): tables `mg_chips_hydrogen.csv`, "
    "`mg_disc_ph.csv`, `mg4ag_wire.csv` of `examples/scenes`",
    measured_parts, (int)(sizeof measured_parts / sizeof measured_parts[0])};
#endif

#endif
