/* newton: see newton.h */
#include "solve/newton.h"
#include "solve/krylov.h"
#include <math.h>
#include <string.h>

/* PD_NEWTON_BY_WORK: accepts a length after which the work is at least this part of the first one, with the other
 * sign. */
#define PDI_NEWTON_MAX_COUNTERWORK 0.8

/* Moves the state to a length of the step, and sets p->length, norm and excess. PD_RETRY: the state has no residual;
 * norm and excess are then infinite. */
static pd_status pdi_newton_try_length(pd_ctx *ctx, const pd_newton_equations *e, double length, pd_newton_progress *p)
{
    e->move(ctx, e->self, length);
    p->length = length;
    pd_status status = e->residual(ctx, e->self, &p->norm, &p->excess);
    if (status == PD_RETRY) p->norm = p->excess = HUGE_VAL;
    return status;
}

/* Takes the step whole. PD_OK: it has converged, or the norm is below the one before. PD_NOT_CONVERGED: neither.
 * PD_RETRY: the state has no residual. The state stays there in each case. */
static pd_status pdi_newton_take_full_step(pd_ctx *ctx, const pd_newton_equations *e, pd_newton_progress *p)
{
    pd_status status = pdi_newton_try_length(ctx, e, 1.0, p);
    if (status != PD_OK) return status;
    return p->excess <= 1.0 || p->norm < p->previous ? PD_OK : PD_NOT_CONVERGED;
}

/* Takes the step whole where the norm is below max_growth times that before it. Else halves it, max_trials times at
 * most, until the norm is below that before it. Where no trial lowers the norm, takes the step back: p->length is 0,
 * and norm and excess are those before it. A state without residual counts as an infinite norm. */
static pd_status pdi_newton_search_by_norm(pd_ctx *ctx, const pd_newton_equations *e, const pd_newton_desc *d,
                                           pd_newton_progress *p)
{
    double length = 1.0;
    pd_status status = pdi_newton_try_length(ctx, e, length, p);
    if (status < 0 || p->norm < d->max_growth * p->previous) return status;
    for (int k = 0; k < d->max_trials && status >= 0 && !(p->norm < p->previous); k++) {
        length *= 0.5;
        status = pdi_newton_try_length(ctx, e, length, p);
    }
    return status < 0 || p->norm < p->previous ? status : pdi_newton_try_length(ctx, e, 0.0, p);
}

/* Shortens the step, max_trials lengths at most, until it converges or the work along it is at least
 * -PDI_NEWTON_MAX_COUNTERWORK of that at its start. The next length is where the secant of the work is 0, at least a
 * tenth; half without residual. PD_RETRY: no length is accepted, or the work is not positive at the start; the state is
 * that before the step. */
static pd_status pdi_newton_search_by_work(pd_ctx *ctx, const pd_newton_equations *e, const pd_newton_desc *d,
                                           pd_newton_progress *p)
{
    double length = 1.0, first = e->work(e->self);
    for (int k = 0; k < d->max_trials && first > 0.0; k++) {
        pd_status status = pdi_newton_try_length(ctx, e, length, p);
        if (status < 0) return status;
        double work = status == PD_OK ? e->work(e->self) : 0.0;
        if (status == PD_OK && (p->excess <= 1.0 || work >= -PDI_NEWTON_MAX_COUNTERWORK * first)) return PD_OK;
        double cut = status == PD_OK ? first / (first - work) : 0.5;
        length *= cut > 0.1 ? cut : 0.1;
    }
    pd_status status = pdi_newton_try_length(ctx, e, 0.0, p);
    return status < 0 ? status : PD_RETRY;
}

/* Relative tolerance of the next linear step after a step that has left `ratio` of the norm: min_forcing where
 * is_nearly_linear, else pdi_krylov_forcing of the ratio; at least final_forcing over the excess, and at most
 * max_forcing. */
static double pdi_newton_choose_forcing(const pd_newton_desc *d, double ratio, double excess)
{
    double forcing = d->is_nearly_linear ? d->min_forcing : pdi_krylov_forcing(ratio);
    return pd_min(d->max_forcing, pd_max(forcing, d->final_forcing / excess));
}

/* One step from the state of the present residual: solve_step, then the search. Updates steps, previous, best and
 * stalled of p: a norm below half of best becomes best and sets stalled to 0, else stalled grows by 1. Returns the
 * first status that is not PD_OK; one of solve_step changes nothing. */
static pd_status pdi_newton_step(pd_ctx *ctx, const pd_newton_equations *e, const pd_newton_desc *d,
                                 pd_newton_progress *p)
{
    pd_status status = e->solve_step(ctx, e->self, p);
    if (status != PD_OK) return status;
    p->steps++;
    p->previous = p->norm;
    if (d->search == PD_NEWTON_FULL_STEP) status = pdi_newton_take_full_step(ctx, e, p);
    else if (d->search == PD_NEWTON_BY_NORM) status = pdi_newton_search_by_norm(ctx, e, d, p);
    else status = pdi_newton_search_by_work(ctx, e, d, p);
    p->stalled++;
    if (p->norm < 0.5 * p->best) {
        p->best = p->norm;
        p->stalled = 0;
    }
    return status;
}

pd_status pd_newton_solve(pd_ctx *ctx, const pd_newton_equations *e, const pd_newton_desc *d, pd_newton_progress *p)
{
    double ratio = d->first_ratio;
    memset(p, 0, sizeof *p);
    if ((d->max_steps <= 0 && d->max_stalled <= 0) || !(d->max_forcing > 0.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "newton",
                       "max_steps %d, max_stalled %d, max_forcing %g: expected a limit "
                       "of steps and a positive tolerance of linear steps",
                       d->max_steps, d->max_stalled, d->max_forcing);
    pd_status status = e->residual(ctx, e->self, &p->norm, &p->excess);
    p->best = p->norm;
    while (status == PD_OK && p->excess > 1.0) {
        if ((d->max_steps > 0 && p->steps >= d->max_steps) || (d->max_stalled > 0 && p->stalled > d->max_stalled))
            return PD_NOT_CONVERGED;
        p->forcing = pdi_newton_choose_forcing(d, ratio, p->excess);
        status = pdi_newton_step(ctx, e, d, p);
        if (p->length > 0.0) ratio = p->norm / p->previous;
        if (status == PD_OK) status = pd_check_cancel(ctx, e->name, p->steps);
    }
    return status == PD_OK && !(p->excess <= 1.0) ? PD_NOT_CONVERGED : status;
}

#undef PDI_NEWTON_MAX_COUNTERWORK
