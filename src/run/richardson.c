/* richardson: see richardson.h */
#include "run/result_line.h"
#include "run/richardson.h"
#include "core/par.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_RICHARDSON_MIN_ORDER 0.5 /* [-] least observed order that is accepted */
#define PDI_RICHARDSON_MAX_ORDER 3.0 /* [-] largest one */
#define PDI_RICHARDSON_NOISE 1e-9    /* [-] smaller relative differences are rounding and tolerances of solvers */
#define PDI_RICHARDSON_MINOR 0.1     /* [-] figures below this share of the largest of their sort are minor */
#define PDI_RICHARDSON_LINE 2048     /* [byte] of a line */

/* ---- figures of the coarser runs ---- */

/* Value of the coarser run for an output of the run, summed over its planes with weights; NaN: it has none. */
static double pdi_richardson_find_coarser_value(const pd_coarsened_setup *coarser, const pd_scalar_outputs *figures,
                                                const pd_scalar_output *wanted)
{
    double sum = 0.0;
    int found = 0;
    for (int k = 0; k < figures->count; k++) {
        const pd_scalar_output *f = &figures->list[k];
        if (strcmp(f->section, wanted->section) != 0 || strcmp(f->name, wanted->name) != 0 ||
            strcmp(f->key, wanted->key) != 0)
            continue;
        sum += (f->monitor < 0 ? 1.0 : coarser->monitor_weight[f->monitor]) * f->value;
        found = 1;
    }
    return found ? sum : (double)NAN;
}

/* Put the spacing of the lattice, 2 h (level 0) or 4 h, before the message of a failed run. */
static void pdi_richardson_prefix_message(pd_ctx *ctx, int level)
{
    char message[PD_MESSAGE_SIZE];
    memcpy(message, ctx->message, sizeof message);
    pd_fail(ctx, ctx->status, "coarser", "the run at %d h failed: %.560s", level ? 4 : 2, message);
}

/* Run the coarsened setup without files and record its outputs as e->list[].coarser[level]. PD_CANCELLED: stopped. */
static pd_status pdi_richardson_run_setup(pd_ctx *ctx, const pd_run_desc *desc, pd_coarsened_setup *coarser,
                                          pd_richardson *e, int level)
{
    pd_run_desc dry;
    pd_run_result result;
    pd_scalar_outputs figures;
    memset(&dry, 0, sizeof dry);
    memset(&figures, 0, sizeof figures);
    dry.no_files = 1;
    dry.check_only = desc->check_only;
    dry.figures = &figures;
    dry.stop = desc->stop;
    dry.stop_user = desc->stop_user;
    pd_status status = pd_run(ctx, &coarser->setup, &dry, &result);
    if (status == PD_CANCELLED || (status >= 0 && result.stopped))
        status = pd_fail(ctx, PD_CANCELLED, "estimate", "interrupted");
    else if (status < 0) pdi_richardson_prefix_message(ctx, level);
    for (int k = 0; k < e->count && status >= 0; k++)
        e->list[k].coarser[level] = pdi_richardson_find_coarser_value(coarser, &figures, &e->list[k].figure);
    pd_scalar_outputs_free(ctx, &figures);
    return status;
}

/* Coarsen the setup (level 0: 2 h, 1: 4 h) and run it with the flow order of the run. PD_OK also for a run that missed
 * a tolerance. Errors of pdi_coarsen_setup_build and pd_run; PD_CANCELLED: stopped. */
static pd_status pdi_richardson_run_coarser_grid(pd_ctx *ctx, const pd_run_desc *desc, pd_richardson *e, int level)
{
    pd_coarsened_setup *coarser = NULL;
    PD_TRY(PD_NEW(ctx, "estimate", 1, coarser));
    pd_status status = pdi_coarsen_setup_build(ctx, e->setup, level ? 4 : 2, coarser);
    if (status >= 0 && e->order) coarser->setup.flow_order = e->order; /* which may depend on the spacing */
    if (status >= 0) status = pdi_richardson_run_setup(ctx, desc, coarser, e, level);
    PD_DELETE(ctx, 1, coarser);
    return status < 0 ? status : PD_OK;
}

/* ---- orders and errors ---- */

/* Formal order of convergence of an output: 1 if it is carried by species (a unit with mol, a transfer, or the volume
 * loss) and metal dissolves or a flow is advected upwind; else 2. */
static double pdi_richardson_get_formal_order(const pd_setup *setup, const pd_scalar_output *f)
{
    int carried = strstr(f->unit, "mol") || strcmp(f->section, "transfer") == 0 || strcmp(f->section, "scene") == 0;
    return carried && (setup->has_dissolve || (setup->has_flow && setup->advection == PD_ADVECTION_UPWIND)) ? 1.0 : 2.0;
}

/* Set order, is_formal_order and relative error [-] of one output from its three values: |f1 - f2|/((2^p - 1) |f1|).
 * The observed order counts from 0.5 to 3 and for |f1 - f2| > 1e-9 |f1|; else the formal p with the larger of |f1 - f2|
 * and |f4 - f2|/2^p. The error is 0 for differences of 0, infinite for f1 = 0 otherwise, NaN where f2 is NaN. */
static void pdi_richardson_compute_error(const pd_setup *setup, pd_richardson_output *e)
{
    double value = e->figure.value, near_step = e->coarser[0] - value, far_step = e->coarser[1] - e->coarser[0];
    double noise = PDI_RICHARDSON_NOISE * fabs(value), theory = pdi_richardson_get_formal_order(setup, &e->figure);
    double order = log(far_step / near_step) / log(2.0), step = fabs(near_step);
    e->is_formal_order =
        !(order >= PDI_RICHARDSON_MIN_ORDER) || !(order <= PDI_RICHARDSON_MAX_ORDER) || !(step > noise);
    e->order = e->is_formal_order ? theory : order;
    if (e->is_formal_order) step = pd_max(step, fabs(far_step) / pow(2.0, theory)); /* that of numbers */
    e->error = step / ((pow(2.0, e->order) - 1.0) * fabs(value));
    if (step <= 0.0) e->error = 0.0; /* the figure may be 0, too */
}

/* 1: two outputs are of the same sort: the same unit and the same first letter of the key. */
static int pdi_richardson_is_same_kind(const pd_scalar_output *a, const pd_scalar_output *b)
{
    return a->key[0] == b->key[0] && strcmp(a->unit, b->unit) == 0;
}

/* Set is_minor of each output: its size is 0, below a tenth of the largest of its sort, or its error is NaN. Set
 * e->worst_output to the largest relative error of the others, the first of equal ones; -1: there are none. */
static void pdi_richardson_mark_minor(pd_richardson *e)
{
    e->worst_output = -1;
    for (int k = 0; k < e->count; k++) {
        pd_richardson_output *a = &e->list[k];
        double most = 0.0;
        for (int j = 0; j < e->count; j++)
            if (pdi_richardson_is_same_kind(&a->figure, &e->list[j].figure))
                most = pd_max(most, fabs(e->list[j].figure.value));
        a->is_minor = !(fabs(a->figure.value) >= PDI_RICHARDSON_MINOR * most) || !(fabs(a->figure.value) > 0.0) ||
                      !(a->error >= 0.0);
        if (!a->is_minor && (e->worst_output < 0 || a->error > e->list[e->worst_output].error)) e->worst_output = k;
    }
}

/* Run both coarser lattices and compute all errors. An error at 2 h ends it. If the one at 4 h fails, but not fatally,
 * e->missing_reason says why, and formal orders are taken. PD_CANCELLED: stopped. */
static pd_status pdi_richardson_run_coarser_grids(pd_ctx *ctx, const pd_run_desc *desc, pd_richardson *e)
{
    PD_TRY(pdi_richardson_run_coarser_grid(ctx, desc, e, 0));
    e->coarser_runs = 1;
    pd_status status = pdi_richardson_run_coarser_grid(ctx, desc, e, 1);
    if (pd_is_fatal(status)) return status;
    if (status == PD_OK) e->coarser_runs = 2;
    else memcpy(e->missing_reason, ctx->message, sizeof e->missing_reason);
    if (desc->stop && desc->stop(desc->stop_user)) return pd_fail(ctx, PD_CANCELLED, "estimate", "interrupted");
    for (int k = 0; k < e->count; k++) pdi_richardson_compute_error(e->setup, &e->list[k]);
    pdi_richardson_mark_minor(e);
    return PD_OK;
}

pd_status pd_richardson_run(pd_ctx *ctx, const pd_setup *setup, const pd_run_desc *desc,
                            const pd_scalar_outputs *figures, pd_richardson *e)
{
    double started = pd_par_clock();
    memset(e, 0, sizeof *e);
    e->setup = setup;
    e->worst_output = -1;
    PD_TRY(PD_NEW(ctx, "estimate", figures->count, e->list));
    e->count = figures->count;
    e->order = figures->order;
    for (int k = 0; k < e->count; k++) {
        e->list[k].figure = figures->list[k];
        e->list[k].coarser[0] = e->list[k].coarser[1] = (double)NAN;
    }
    pd_status status = pdi_richardson_run_coarser_grids(ctx, desc, e);
    e->wall_time = pd_par_clock() - started;
    if (status < 0) pd_richardson_free(ctx, e);
    return status;
}

void pd_richardson_free(pd_ctx *ctx, pd_richardson *e)
{
    PD_DELETE(ctx, e->count, e->list);
    memset(e, 0, sizeof *e);
}

/* ---- what it says ---- */

/* Name of an output, as "plane.up.flow", into text[size]. */
static void pdi_richardson_format_output_name(const pd_scalar_output *f, char *text, size_t size)
{
    snprintf(text, size, "%s%s%s.%s", f->section, f->name[0] ? "." : "", f->name, f->key);
}

/* Append the errors of all outputs of one section from `first` on to text[size]: " err_fx=... order_fx=... assumed=fx".
 * Returns the index behind the last one. */
static int pdi_richardson_format_section(const pd_richardson *e, int first, char *text, size_t size)
{
    const pd_scalar_output *f = &e->list[first].figure;
    char assumed[PDI_RICHARDSON_LINE / 4] = "";
    int k = first;
    size_t used;
    for (; k < e->count; k++) {
        const pd_richardson_output *a = &e->list[k];
        if (strcmp(a->figure.section, f->section) != 0 || strcmp(a->figure.name, f->name) != 0) break;
        used = strlen(text);
        snprintf(text + used, size - used, " err_%s=%.3g order_%s=%.3g", a->figure.key, a->error, a->figure.key,
                 a->order);
        used = strlen(assumed);
        if (a->is_formal_order) snprintf(assumed + used, sizeof assumed - used, "%s%s", used ? "," : "", a->figure.key);
    }
    used = strlen(text);
    if (assumed[0]) snprintf(text + used, size - used, " assumed=%s", assumed);
    return k;
}

/* Append the number of coarser runs, order and error of the volume loss if the list begins with it, the worst of all
 * outputs that are not minor ("none"), and the wall time to text[size]. */
static void pdi_richardson_format_scene(const pd_richardson *e, char *text, size_t size)
{
    char worst[2 * PD_SETUP_NAME] = "none";
    const pd_richardson_output *w = e->worst_output < 0 ? NULL : &e->list[e->worst_output];
    const pd_richardson_output *a = e->count && strcmp(e->list[0].figure.section, "scene") == 0 ? &e->list[0] : NULL;
    size_t used = strlen(text);
    snprintf(text + used, size - used, " coarser_runs=%d", e->coarser_runs);
    if (a) {
        used = strlen(text);
        snprintf(text + used, size - used, " order=%.3g err_volume_loss=%.3g%s", a->order, a->error,
                 a->is_formal_order ? " assumed=volume_loss" : "");
    }
    if (w) pdi_richardson_format_output_name(&w->figure, worst, sizeof worst);
    used = strlen(text);
    snprintf(text + used, size - used, " worst=%s", worst);
    used = strlen(text);
    if (w) snprintf(text + used, size - used, " err_worst=%.3g order_worst=%.3g", w->error, w->order);
    used = strlen(text);
    snprintf(text + used, size - used, " estimate_wall_s=%.3f", e->wall_time);
}

void pd_richardson_print(const pd_richardson *e, pd_print_fn print, void *user)
{
    char text[PDI_RICHARDSON_LINE];
    if (!print) return;
    for (int k = 0; k < e->count;) {
        const pd_scalar_output *f = &e->list[k].figure;
        if (strcmp(f->section, "scene") == 0) {
            k++;
            continue;
        }
        snprintf(text, sizeof text, "result case=%s estimate=richardson %s=%s", e->setup->name, f->section, f->name);
        char *figures = text + strlen(text);
        k = pdi_richardson_format_section(e, k, text, sizeof text);
        pdi_result_line_remove_nonfinite(figures);
        print(user, PD_PRINT_RESULT, text);
    }
    snprintf(text, sizeof text, "result case=%s estimate=richardson", e->setup->name);
    char *figures = text + strlen(text);
    pdi_richardson_format_scene(e, text, sizeof text);
    pdi_result_line_remove_nonfinite(figures);
    print(user, PD_PRINT_RESULT, text);
    if (!e->missing_reason[0]) return;
    snprintf(text, sizeof text, "the error estimate assumes orders: %s", e->missing_reason);
    print(user, PD_PRINT_NOTE, text);
}

/* Greatest common divisor (Euclid) of a, b >= 0; of 0 and b: b. */
static int pdi_richardson_compute_common_divisor(int a, int b)
{
    while (b) {
        int rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

void pd_richardson_suggest_spacing(const pd_richardson *e, double accuracy, double *h)
{
    const pd_setup *u = e->setup;
    double finer = 1.0, parts;
    int common = 0;
    for (int k = 0; k < e->count; k++) {
        const pd_richardson_output *a = &e->list[k];
        if (!a->is_minor && a->error > accuracy) finer = pd_max(finer, pow(a->error / accuracy, 1.0 / a->order));
    }
    for (int d = 0; d < PD_DIM; d++) {
        h[d] = u->h[d];
        common = pdi_richardson_compute_common_divisor(common, pd_setup_count_cells(u, d));
    }
    if (!(finer > 1.0)) return;
    /* spacings h common/parts divide the box on every axis, and with an even number of parts twice of them does, too */
    parts = 2.0 * ceil(0.5 * common * finer * (1.0 - 1e-12));
    for (int d = 0; d < PD_DIM; d++) h[d] *= common / parts;
}

#undef PDI_RICHARDSON_MIN_ORDER
#undef PDI_RICHARDSON_MAX_ORDER
#undef PDI_RICHARDSON_NOISE
#undef PDI_RICHARDSON_MINOR
#undef PDI_RICHARDSON_LINE
