/* fit: see fit.h */
#include "run/result_line.h"
#include "run/fit.h"
#include "io/file.h"
#include "scene/read_measured.h"
#include "run/coarsen_setup.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_FIT_OVERRIDES 128 /* most overrides of a fit, its own included */

/* A fit at work. */
typedef struct pdi_fit {
    pd_ctx *ctx;
    const pd_fit_desc *desc;
    pd_fit *fit;
    pd_coarsened_setup *coarser; /* work */
    int factor;         /* of h */
    double *computed;   /* [points of all sections] */
    double *data, *weight; /* [points that count] SI, 1/spread */
    int *point_index;      /* [points that count] index in `computed` */
    double *best_residuals; /* [points that count] residuals of the lowest sum of squares on this lattice */
    double min_sum;         /* [-] that sum */
    double noise;       /* [-] of a residual, from the coarsest lattice; 0: not known */
    int total_points;
} pdi_fit;

/* ---- ranges ---- */

/* Error message for a range that cannot be read. Returns PD_ERR_ARGUMENT. */
static pd_status pdi_fit_reject_range(pd_ctx *ctx, const char *range, const char *expected)
{
    return pd_fail(ctx, PD_ERR_ARGUMENT, "fit", "found '%.100s', expected %s, such as dissolve.rate_scale=0.5..2 or "
                   "\"transport.D=1e-10..1e-8 m2/s\"", range, expected);
}

/* Length of the decimal number at text, which ends before `end`, and of blanks before it; *value: that number. 0: there
 * is none. */
static size_t pdi_fit_parse_number(const char *text, const char *end, double *value)
{
    size_t blanks = 0, size = (size_t)(end - text);
    while (blanks < size && pd_units_is_blank(text[blanks])) blanks++;
    size_t length = pdi_file_find_number_length(text + blanks, size - blanks);
    return pdi_file_parse_number(text + blanks, length, value) ? blanks + length : 0;
}

/* Copy the unit at text up to `end`, without blanks around it, into unit[PD_UNITS_TEXT]. 1: done; 0: it is too long. */
static int pdi_fit_parse_unit(const char *text, const char *end, char *unit)
{
    while (text < end && pd_units_is_blank(*text)) text++;
    while (end > text && pd_units_is_blank(end[-1])) end--;
    size_t size = (size_t)(end - text);
    if (size >= PD_UNITS_TEXT) return 0;
    memcpy(unit, text, size);
    unit[size] = '\0';
    return 1;
}

/* Convert the low bound from `unit` to the unit of the high one. Nothing where `unit` is empty or the same.
 * PD_ERR_ARGUMENT: one of them is no unit, or their dimensions differ. */
static pd_status pdi_fit_convert_low_bound(pd_ctx *ctx, const char *range, const char *unit, pd_fit_parameter *p)
{
    double from, to;
    pd_dims a, b;
    if (!unit[0] || strcmp(unit, p->unit) == 0) return PD_OK;
    if (pd_units_parse(ctx, unit, &from, &a) < 0 || pd_units_parse(ctx, p->unit, &to, &b) < 0 ||
        !pd_units_is_same(&a, &b))
        return pdi_fit_reject_range(ctx, range, "bounds of one dimension");
    p->low *= from / to;
    return PD_OK;
}

/* Parse "KEY=LOW..HIGH UNIT" into a parameter, with both bounds in the unit of the high one. PD_ERR_ARGUMENT: no or too
 * long a key, no number on either side of "..", too long a unit, bounds of different dimensions, low >= high, or bounds
 * that are not finite. */
static pd_status pdi_fit_parse_range(pd_ctx *ctx, const char *range, pd_fit_parameter *p)
{
    const char *equal = strchr(range, '='), *dots = strstr(range, ".."), *end = range + strlen(range);
    char unit[PD_UNITS_TEXT];
    size_t low, high, key = equal ? (size_t)(equal - range) : 0;
    memset(p, 0, sizeof *p);
    if (!equal || !key || key >= sizeof p->key || !dots || dots < equal)
        return pdi_fit_reject_range(ctx, range, "KEY=LOW..HIGH");
    while (key > 0 && pd_units_is_blank(range[key - 1])) key--;
    memcpy(p->key, range, key);
    low = pdi_fit_parse_number(equal + 1, dots, &p->low);
    high = pdi_fit_parse_number(dots + 2, end, &p->high);
    if (!low || !high || !pdi_fit_parse_unit(equal + 1 + low, dots, unit) ||
        !pdi_fit_parse_unit(dots + 2 + high, end, p->unit))
        return pdi_fit_reject_range(ctx, range, "a number on either side of '..'");
    PD_TRY(pdi_fit_convert_low_bound(ctx, range, unit, p));
    if (p->low < p->high && p->high - p->low < HUGE_VAL) return PD_OK;
    return pdi_fit_reject_range(ctx, range, "a finite low bound below the high one");
}

/* Parse all ranges. PD_ERR_ARGUMENT: none or too many, one that cannot be read, or a key twice. fit->parameters is set
 * only when all are read. */
static pd_status pdi_fit_parse_ranges(pd_ctx *ctx, const pd_fit_desc *desc, pd_fit *fit)
{
    if (desc->ranges < 1 || desc->ranges > PD_LEAST_SQUARES_PARAMETERS)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "fit", "found %d parameters, expected 1 to %d", desc->ranges,
                       PD_LEAST_SQUARES_PARAMETERS);
    for (int k = 0; k < desc->ranges; k++) {
        PD_TRY(pdi_fit_parse_range(ctx, desc->range[k], &fit->parameter[k]));
        for (int j = 0; j < k; j++)
            if (strcmp(fit->parameter[j].key, fit->parameter[k].key) == 0)
                return pdi_fit_reject_range(ctx, desc->range[k], "each key once");
    }
    fit->parameters = desc->ranges;
    return PD_OK;
}

/* Write the overrides "KEY=VALUE UNIT" of all parameters for value[parameters], each in its unit, into fit->override.
 */
static void pdi_fit_format_overrides(pd_fit *fit, const double *value)
{
    char number[PDI_FILE_NUMBER_SIZE];
    for (int k = 0; k < fit->parameters; k++) {
        fit->override[k][0] = '\0';
        pdi_file_format_number(value[k], number);
        pd_append(fit->override[k], sizeof fit->override[k], "%s=%s%s%s", fit->parameter[k].key, number,
                  fit->parameter[k].unit[0] ? " " : "", fit->parameter[k].unit);
    }
}

/* ---- runs ---- */

pd_status pd_fit_read_setup(pd_ctx *ctx, const pd_fit_desc *desc, const char *const *more, int count, pd_setup *setup)
{
    const char *overrides[PDI_FIT_OVERRIDES];
    if (desc->count + count > PDI_FIT_OVERRIDES)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "fit", "more than %d overrides", PDI_FIT_OVERRIDES);
    for (int k = 0; k < desc->count; k++) overrides[k] = desc->overrides[k];
    for (int k = 0; k < count; k++) overrides[desc->count + k] = more[k];
    PD_TRY(pd_scene_read(ctx, desc->scene, overrides, desc->count + count, setup));
    pd_status status = desc->measured ? pdi_read_measured_replace(ctx, "--to", desc->measured, setup) : PD_OK;
    if (status == PD_OK && setup->measured_count == 0)
        status = pd_fail(ctx, PD_ERR_ARGUMENT, "fit", "found no [measured NAME] section in the scene, expected one or "
                         "--to FILE");
    if (status < 0) pd_setup_free(ctx, setup);
    return status;
}

/* Put the trial values of the parameters, and the lattice if it is a coarser one, before the message of a failed run.
 * Returns status. */
static pd_status pdi_fit_prefix_message(pdi_fit *f, pd_status status)
{
    char message[PD_MESSAGE_SIZE], values[240] = "";
    memcpy(message, f->ctx->message, sizeof message);
    for (int k = 0; k < f->fit->parameters; k++) {
        size_t used = strlen(values);
        snprintf(values + used, sizeof values - used, "%s%.80s", k ? " " : "", f->fit->override[k]);
    }
    pd_fail(f->ctx, status, "fit", "the run at %s%s failed: %.360s", values,
            f->factor == 4 ? " on 4 h" : f->factor == 2 ? " on 2 h" : "", message);
    return status;
}

/* Run the setup without files, on the coarser lattice where factor > 1, into f->computed [SI], NaN where it does not
 * come. PD_CANCELLED: stopped. Errors of pdi_coarsen_setup_build and pd_run. */
static pd_status pdi_fit_run_model(pdi_fit *f, const pd_setup *setup)
{
    pd_run_desc dry;
    pd_run_result result;
    memset(&dry, 0, sizeof dry);
    dry.no_files = 1;
    dry.stop = f->desc->stop;
    dry.stop_user = f->desc->stop_user;
    dry.computed_at_points = f->computed;
    if (f->factor > 1) {
        PD_TRY(pdi_coarsen_setup_build(f->ctx, setup, f->factor, f->coarser));
        dry.monitor_weight = f->coarser->monitor_weight;
        setup = &f->coarser->setup;
    }
    PD_TRY(pd_run(f->ctx, setup, &dry, &result));
    return result.stopped ? pd_fail(f->ctx, PD_CANCELLED, "fit", "interrupted") : PD_OK;
}

/* Residuals [points] [-] for parameter values: (computed - measured) times weight. Reads the scene anew, makes a run,
 * counts it, and keeps the residuals of the lowest sum of squares; a sum that is NaN is never the lowest. A run that
 * fails ends with its status and the values in the message, one that is stopped with PD_CANCELLED. The function of
 * pd_least_squares_solve. */
static pd_status pdi_fit_compute_residuals(pd_ctx *ctx, void *user, const double *value, double *residual)
{
    pdi_fit *f = (pdi_fit *)user;
    const char *more[PD_LEAST_SQUARES_PARAMETERS];
    pd_setup *setup = NULL;
    pdi_fit_format_overrides(f->fit, value);
    for (int k = 0; k < f->fit->parameters; k++) more[k] = f->fit->override[k];
    PD_TRY(PD_NEW(ctx, "fit", 1, setup));
    pd_status status = pd_fit_read_setup(ctx, f->desc, more, f->fit->parameters, setup);
    if (status >= 0) status = pdi_fit_run_model(f, setup);
    if (status < 0 && status != PD_CANCELLED) pdi_fit_prefix_message(f, status);
    pd_setup_free(ctx, setup);
    PD_DELETE(ctx, 1, setup);
    PD_TRY(status);
    f->fit->evaluations++;
    double sum = 0.0;
    for (int k = 0; k < f->fit->points; k++) {
        residual[k] = (f->computed[f->point_index[k]] - f->data[k]) * f->weight[k];
        sum += residual[k] * residual[k];
    }
    if (!(sum < f->min_sum)) return PD_OK;
    f->min_sum = sum;
    memcpy(f->best_residuals, residual, (size_t)f->fit->points * sizeof *residual);
    return PD_OK;
}

/* ---- points ---- */

/* Check the standard deviations; *known: 1: all sets have them. PD_ERR_ARGUMENT: that of a point in the run is not
 * positive, or of several sets some or all have none. A single set needs none. Points outside the run are not
 * checked. */
static pd_status pdi_fit_check_std_devs(pd_ctx *ctx, const pd_setup *setup, int *known)
{
    int with = 0;
    for (int k = 0; k < setup->measured_count; k++) {
        const pd_setup_measured *r = &setup->measured[k];
        with += r->spread != NULL;
        for (int p = 0; p < r->points && r->spread; p++)
            if (pdi_read_measured_is_in_run(r, p, setup->end_time) && !(r->spread[p] > 0.0))
                return pd_fail(ctx, PD_ERR_ARGUMENT, "fit", "found a spread of 0 in %.60s at t = %g s, expected a "
                               "positive one: points weigh by it", r->name, r->time[p]);
    }
    *known = with > 0;
    if (with == 0 && setup->measured_count == 1) return PD_OK;
    if (with == setup->measured_count) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "fit",
                   "found %d of %d sets of points with a spread, expected it in all: "
                   "points of different figures weigh by it",
                   with, setup->measured_count);
}

/* Collect measured values and weights (1/spread, else 1 over the unit) of points after the start and before the end of
 * the run, their number, and names and unit of the result from the first set. */
static void pdi_fit_find_points(pdi_fit *f, const pd_setup *setup)
{
    int at = 0, count = 0;
    for (int k = 0; k < setup->measured_count; k++) {
        const pd_setup_measured *r = &setup->measured[k];
        for (int p = 0; p < r->points; p++, at++) {
            if (!pdi_read_measured_is_in_run(r, p, setup->end_time)) continue;
            f->data[count] = r->value[p];
            f->weight[count] = 1.0 / (r->spread ? r->spread[p] : r->scale);
            f->point_index[count++] = at;
        }
    }
    f->fit->points = count;
    f->fit->measured_sets = setup->measured_count;
    memcpy(f->fit->output, setup->measured[0].output_name, sizeof f->fit->output);
    memcpy(f->fit->unit, setup->measured[0].unit, sizeof f->fit->unit);
    memcpy(f->fit->name, setup->name, sizeof f->fit->name);
}

/* Check the standard deviations, allocate work, and find the points that count and h. PD_ERR_ARGUMENT: fewer points
 * than parameters. */
static pd_status pdi_fit_allocate_work(pdi_fit *f, const pd_setup *setup)
{
    PD_TRY(pdi_fit_check_std_devs(f->ctx, setup, &f->fit->has_spread));
    for (int k = 0; k < setup->measured_count; k++) f->total_points += setup->measured[k].points;
    PD_TRY(PD_NEW(f->ctx, "fit", f->total_points, f->computed));
    PD_TRY(PD_NEW(f->ctx, "fit", f->total_points, f->data));
    PD_TRY(PD_NEW(f->ctx, "fit", f->total_points, f->weight));
    PD_TRY(PD_NEW(f->ctx, "fit", f->total_points, f->point_index));
    PD_TRY(PD_NEW(f->ctx, "fit", f->total_points, f->best_residuals));
    PD_TRY(PD_NEW(f->ctx, "fit", 1, f->coarser));
    pdi_fit_find_points(f, setup);
    f->fit->h = setup->h[0];
    if (f->fit->points >= f->fit->parameters) return PD_OK;
    return pd_fail(f->ctx, PD_ERR_ARGUMENT, "fit", "found %d point%s for %d parameters, expected as many at least",
                   f->fit->points, f->fit->points == 1 ? "" : "s", f->fit->parameters);
}

/* ---- lattices ---- */

/* Print a line, if the caller wants it. */
static void pdi_fit_print(const pdi_fit *f, pd_print_kind kind, const char *text)
{
    if (f->desc->print) f->desc->print(f->desc->print_user, kind, text);
}

/* Print an iteration: number of runs, values, and chi2 (the sum of squares) if points have a spread, else rms. */
static void pdi_fit_print_iteration(void *user, const double *value, double sum, int evaluations)
{
    pdi_fit *f = (pdi_fit *)user;
    char line[400], h[PD_UNITS_TEXT];
    pd_setup_format_value(f->factor * f->fit->h, "m", h);
    snprintf(line, sizeof line, "fit  h = %-8s runs %3d  ", h, evaluations);
    if (f->fit->has_spread) pd_append(line, sizeof line, "chi2 %-10.5g", sum);
    else pd_append(line, sizeof line, "rms %-10.5g", sqrt(sum / f->fit->points));
    for (int k = 0; k < f->fit->parameters; k++)
        pd_append(line, sizeof line, "  %.60s = %.6g%s%.40s", f->fit->parameter[k].key, value[k],
                       f->fit->parameter[k].unit[0] ? " " : "", f->fit->parameter[k].unit);
    pdi_fit_print(f, PD_PRINT_SUMMARY, line);
}

/* Solve the least-squares problem on the lattice of the present factor, from `start`, moved into the bounds, into
 * fit->result, whose noise f->noise takes over. A parameter without effect sets fit->bad_input. */
static pd_status pdi_fit_solve_on_grid(pdi_fit *f, const double *start)
{
    pd_least_squares_desc d;
    memset(&d, 0, sizeof d);
    d.parameters = f->fit->parameters;
    d.points = f->fit->points;
    for (int k = 0; k < d.parameters; k++) {
        d.low[k] = f->fit->parameter[k].low;
        d.high[k] = f->fit->parameter[k].high;
        d.start[k] = pd_min(pd_max(start[k], d.low[k]), d.high[k]);
    }
    d.known_deviation = f->fit->has_spread;
    d.noise = f->noise;
    d.fn = pdi_fit_compute_residuals;
    d.user = f;
    d.report = pdi_fit_print_iteration;
    f->min_sum = HUGE_VAL;
    pd_status status = pd_least_squares_solve(f->ctx, &d, &f->fit->result);
    f->noise = f->fit->result.noise;
    if (status >= 0 || !f->fit->result.ineffective) return status;
    f->fit->bad_input = 1;
    return pd_fail(f->ctx, status, "fit",
                   "found that %.100s has no effect on the points, expected one that changes "
                   "%s",
                   f->fit->parameter[f->fit->result.ineffective - 1].key, f->fit->output);
}

/* 1: the caller wants to stop. */
static int pdi_fit_is_stopped(const pdi_fit *f) { return f->desc->stop && f->desc->stop(f->desc->stop_user); }

/* Solve on the lattices at 4 h, 2 h and h (or h alone), each from the result before. A coarser lattice that fails is
 * left out, with a note; out of memory, a stopped run and a wish to stop end the fit. The first start is sqrt(low
 * high) of a range with low > 0 and high >= 10 low, else the midpoint. Returns the status of the last solve. */
static pd_status pdi_fit_solve_coarse_to_fine(pdi_fit *f)
{
    double start[PD_LEAST_SQUARES_PARAMETERS];
    char line[PD_MESSAGE_SIZE + 64];
    pd_status status = PD_OK;
    for (int k = 0; k < f->fit->parameters; k++) {
        const pd_fit_parameter *p = &f->fit->parameter[k];
        start[k] = p->low > 0.0 && p->high >= 10.0 * p->low ? sqrt(p->low * p->high) : 0.5 * (p->low + p->high);
    }
    for (f->factor = f->desc->skips_coarser ? 1 : 4; f->factor > 0; f->factor /= 2) {
        status = pdi_fit_solve_on_grid(f, start);
        if (status >= 0) memcpy(start, f->fit->result.value, sizeof start);
        if (f->factor == 1 || pd_is_fatal(status)) return status;
        if (pdi_fit_is_stopped(f)) return pd_fail(f->ctx, PD_CANCELLED, "fit", "interrupted");
        snprintf(line, sizeof line, "no fit at %d h: %.500s", f->factor, f->ctx->message);
        if (status < 0) pdi_fit_print(f, PD_PRINT_NOTE, line);
    }
    return status;
}

/* Set fit->rms, the root mean square of the best residuals: in the unit of the points, or, with several sets, over
 * standard deviations. Write the overrides of the result. */
static pd_status pdi_fit_compute_rms(pdi_fit *f)
{
    double square = 0.0, scale = 1.0;
    pd_fit *fit = f->fit;
    if (fit->measured_sets == 1) PD_TRY(pd_units_parse(f->ctx, fit->unit, &scale, NULL));
    for (int k = 0; k < fit->points; k++) {
        double off = f->best_residuals[k] / (fit->measured_sets == 1 ? f->weight[k] * scale : 1.0);
        square += off * off;
    }
    fit->rms = sqrt(square / fit->points);
    pdi_fit_format_overrides(fit, fit->result.value);
    return PD_OK;
}

/* Make the whole fit: ranges, points, lattices. The scene is read once at the low bounds to check it. fit->bad_input:
 * 1: a failure before the first run that is not fatal. Returns the status of the last solve, PD_NOT_CONVERGED
 * included. */
static pd_status pdi_fit_run_inner(pdi_fit *f)
{
    pd_setup *setup = NULL;
    const char *more[PD_LEAST_SQUARES_PARAMETERS];
    double low[PD_LEAST_SQUARES_PARAMETERS] = {0.0};
    pd_status status = pdi_fit_parse_ranges(f->ctx, f->desc, f->fit), solved;
    for (int k = 0; k < f->fit->parameters; k++) {
        low[k] = f->fit->parameter[k].low;
        more[k] = f->fit->override[k];
    }
    pdi_fit_format_overrides(f->fit, low);
    if (status >= 0) status = PD_NEW(f->ctx, "fit", 1, setup);
    if (status >= 0) status = pd_fit_read_setup(f->ctx, f->desc, more, f->fit->parameters, setup);
    if (status >= 0) {
        status = pdi_fit_allocate_work(f, setup);
        pd_setup_free(f->ctx, setup);
    }
    PD_DELETE(f->ctx, 1, setup);
    f->fit->bad_input = status < 0 && !pd_is_fatal(status);
    PD_TRY(status);
    PD_TRY(solved = pdi_fit_solve_coarse_to_fine(f));
    PD_TRY(pdi_fit_compute_rms(f));
    return solved;
}

pd_status pd_fit_run(pd_ctx *ctx, const pd_fit_desc *desc, pd_fit *fit)
{
    pdi_fit f;
    memset(&f, 0, sizeof f);
    memset(fit, 0, sizeof *fit);
    f.ctx = ctx;
    f.desc = desc;
    f.fit = fit;
    pd_status status = pdi_fit_run_inner(&f);
    PD_DELETE(ctx, f.total_points, f.computed);
    PD_DELETE(ctx, f.total_points, f.data);
    PD_DELETE(ctx, f.total_points, f.weight);
    PD_DELETE(ctx, f.total_points, f.point_index);
    PD_DELETE(ctx, f.total_points, f.best_residuals);
    PD_DELETE(ctx, 1, f.coarser);
    return status;
}

void pd_fit_format_result(const pd_fit *fit, char *text, size_t size)
{
    const pd_least_squares_result *s = &fit->result;
    if (size == 0) return;
    text[0] = '\0';
    pd_append(text, size, "result case=%s fit=%s points=%d", fit->name,
              fit->measured_sets == 1 ? fit->output : "several", fit->points);
    char *figures = text + strlen(text);
    pd_append(text, size, " rms=%.4g unit=%s", fit->rms, fit->measured_sets == 1 && fit->unit[0] ? fit->unit : "-");
    if (fit->has_spread) pd_append(text, size, " chi2=%.4g", s->sum);
    pd_append(text, size, " freedom=%d evals=%d fine_evals=%d converged=%s h=%.6g", s->degrees_of_freedom,
              fit->evaluations, s->evaluations, s->converged ? "yes" : "no", fit->h);
    for (int k = 0; k < fit->parameters; k++) {
        const char *key = fit->parameter[k].key;
        pd_append(text, size, " %s=%.6g %s.error=%.3g %s.low=%.5g %s.high=%.5g", key, s->value[k], key,
                  s->standard_error[k], key, s->low[k], key, s->high[k]);
        if (s->active_bound[k]) pd_append(text, size, " %s.bound=%s", key, s->active_bound[k] < 0 ? "low" : "high");
        for (int l = 0; l < k; l++)
            pd_append(text, size, " correlation_%d_%d=%.3g", l + 1, k + 1, s->correlation[k][l]);
    }
    pdi_result_line_remove_nonfinite(figures);
}

#undef PDI_FIT_OVERRIDES
