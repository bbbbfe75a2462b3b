/* wire: the measured wire. Included by cases.h alone. */
#ifndef VAL_WIRE_H
#define VAL_WIRE_H
#include "case.h"

#if PD_DIM == 2
#define WIRE_SCENE "examples/scenes/mg_wire.scene"

/* Measured and computed losses in percent. */
static void wire_curves(const pd_setup_measured *r, const double *computed, val_profile *p)
{
    val_curve *scans = &p->curve[0], *run = &p->curve[1];
    p->title = "the wire against its scans";
    p->x_label = "t [h]";
    p->y_label = "volume loss [%]";
    p->curves = 2;
    snprintf(scans->name, sizeof scans->name, "measured");
    snprintf(run->name, sizeof run->name, "computed");
    scans->stroke = PD_SERIES_STYLE_MARKERS;
    for (int k = 0; k < r->points; k++) {
        scans->x[k] = run->x[k] = r->time[k] / 3600.0;
        scans->y[k] = 100.0 * r->value[k];
        run->y[k] = r->time[k] > 0.0 ? 100.0 * computed[k] : 0.0;
    }
    scans->count = run->count = r->points;
}

static pd_status wire_read(val_job *job, pd_setup *setup)
{
    char h[40], m[40];
    const char *changes[2];
    snprintf(h, sizeof h, "grid.h=%.17g um", 80.0 / job->level.n);
    snprintf(m, sizeof m, "grid.m=%g", job->level.m);
    changes[0] = h;
    changes[1] = m;
    return pd_scene_read(job->ctx, WIRE_SCENE, changes, 2, setup);
}

static pd_status wire_run(val_job *job)
{
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    double computed[VAL_POINTS], square = 0.0;
    int points = 0;
    memset(&desc, 0, sizeof desc);
    desc.no_files = 1;
    desc.computed_at_points = computed;
    PD_TRY(wire_read(job, &setup));
    pd_status status = pd_run(job->ctx, &setup, &desc, &result);
    const pd_setup_measured *r = &setup.measured[0];
    for (int k = 0; k < r->points && status >= 0; k++) {
        double off = 100.0 * fabs(computed[k] - r->value[k]);
        if (isnan(off)) continue;
        points++;
        square += off * off;
        job->out->err[1] = fmax(job->out->err[1], off);
        job->out->err[2] = fmax(job->out->err[2], 0.01 * off / r->spread[k]);
    }
    job->out->err[0] = sqrt(square / points);
    job->out->h = 80e-6 / job->level.n;
    if (job->profile && status >= 0) wire_curves(r, computed, job->profile);
    pd_setup_free(job->ctx, &setup);
    job->out->residual = result.residual;
    job->out->steps = (long)result.steps;
    job->out->evals = (long)result.evaluations;
    return status < 0 ? status : PD_OK;
}

static const val_part wire_part = {
    "", "the wire in its tube", "cells across the wire", VAL_BY_N, NULL, 0.0,
    {{"rms", "RMS [% of volume]"}, {"largest", "largest difference [% of volume]"},
     {"of_spread", "largest difference over the spread of its scan"}}, 3,
    {{2, 1.0, 0.0, 4, VAL_GOAL}, {0, 0.5, 0.0, 4, VAL_GOAL}}, 2,
    {{4, 1.0, 0.0}, {8, 1.0, 0.0}, {16, 1.0, 0.0}}, 3, 2, wire_run, NULL};
static const val_part *const wire_parts[] = {&wire_part};

static const val_case wire_case = {
    "wire", "The measured wire",
    "A Mg-4Ag wire on the axis of a tube, axisymmetric, from the first scan on for 3.54 hours, with inert ends: its "
    "loss at nine later scans. The law v (1 - exp(-t/tau)) has two constants, which were fitted to these scans.",
    "A plane slab in place of a wire, ends that dissolve, a clock that starts at the wrong scan, a law without a rise.",
    "Reimers et al. 2023, ACS Appl. Mater. Interfaces 15, 35600: mean and standard deviation of seven slices",
    wire_parts, 1};


#endif
#endif
