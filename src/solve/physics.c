/* physics: see physics.h */
#include "solve/physics.h"
#include <math.h>
#include <string.h>

/* Most attempts of one step. */
#define PDI_PHYSICS_MAX_ATTEMPTS 1000

/* The progress of a run is checked over this many steps, and a run is refused when it needs more than MOST further
 * steps: of the smallest scene, at microseconds each, those take hours, of a thousand nodes a year. */
#define PDI_PHYSICS_PROGRESS_STEPS 1000
#define PDI_PHYSICS_MAX_STEPS 1e10

PDI_FN double pdi_physics_equal_steps(double left, double dt) { return left / ceil(left / dt * (1.0 - 1e-12)); }

PDI_FN pd_status pdi_physics_limit_max_step(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    (void)self;
    if (s->max_step > 0.0) s->dt = pd_min(s->dt, s->max_step);
    return PD_OK;
}

/* Report step underflow or too many attempts. Returns an error. */
static pd_status pdi_physics_fail_underflow(pd_ctx *ctx, const pd_physics *p, const pd_step *s)
{
    if (p->report_underflow) return p->report_underflow(ctx, p->self, s);
    return pd_fail(ctx, PD_ERR_STATE, p->name,
                   "steps of %g s do not lead on from t = %g s to %g s, after %d attempts "
                   "that were not good enough",
                   s->dt, s->time, s->latest_end, s->rejected);
}

PDI_FN pd_status pdi_physics_check_progress(pd_ctx *ctx, const char *name, pdi_physics_progress *pace, double time,
                                            double end)
{
    if (++pace->steps < PDI_PHYSICS_PROGRESS_STEPS) return PD_OK;
    double by = time - pace->since;
    pace->steps = 0;
    pace->since = time;
    if (!(by * (PDI_PHYSICS_MAX_STEPS / PDI_PHYSICS_PROGRESS_STEPS) < end - time)) return PD_OK;
    return pd_fail(ctx, PD_ERR_STATE, name,
                   "the last %d steps led on by %g s, to t = %g s: so the end at %g s is "
                   "more than %g steps away; expected a shorter run, or laws and values that let steps be longer",
                   PDI_PHYSICS_PROGRESS_STEPS, by, time, end, PDI_PHYSICS_MAX_STEPS);
}

/* Publish the present attempt as progress information, if that is wanted; its error is 0 in the first attempt. */
static void pdi_physics_publish_attempt(const pd_physics *p, const pd_step *s)
{
    if (!s->progress) return;
    s->progress->name = p->name;
    s->progress->time = s->time;
    s->progress->dt = s->dt;
    s->progress->rejected = s->rejected;
    s->progress->error = s->rejected ? s->error : 0.0;
}

PDI_FN pd_status pdi_physics_step(pd_ctx *ctx, const pd_physics *p, pd_step *s)
{
    double left = s->latest_end - s->time;
    pd_status status;
    s->dt = left;
    s->converted_count = 0;
    s->ends_substeps = s->rejected = 0;
    pdi_physics_publish_attempt(p, s);
    PD_TRY(pd_check_cancel(ctx, p->name, p->steps ? *p->steps : 0));
    if (p->limit) PD_TRY(p->limit(ctx, p->self, s));
    left = s->latest_end - s->time;
    for (s->rejected = 0;; s->rejected++) {
        pdi_physics_publish_attempt(p, s);
        if (s->rejected) PD_TRY(pd_check_cancel(ctx, p->name, p->steps ? *p->steps : 0));
        if (s->time_limit)
            s->dt = pd_min(s->dt, s->time_limit(s->time_limit_user, s->time, s->time + s->dt) - s->time);
        if (p->time_limit)
            s->dt = pd_min(s->dt, p->time_limit(p->time_limit_user, s->time, s->time + s->dt, 0) - s->time);
        if (pdi_is_step_underflow(s->time, left, s->dt) || s->rejected == PDI_PHYSICS_MAX_ATTEMPTS)
            return pdi_physics_fail_underflow(ctx, p, s);
        if (s->dt < left) s->end = s->time + s->dt;
        else {
            s->dt = left;
            s->end = s->latest_end;
        }
        pdi_physics_publish_attempt(p, s);
        status = p->attempt(ctx, p->self, s);
        double seen = s->end;
        if (status >= 0 && status != PD_RETRY && p->time_limit)
            seen = p->time_limit(p->time_limit_user, s->time, s->end, 1);
        if (status != PD_RETRY && !(seen < s->end)) break;
        PD_TRY(p->reject(ctx, p->self, s));
        s->dt = pd_min(s->dt, seen - s->time);
    }
    if (status >= 0 && p->accept) PD_TRY(p->accept(ctx, p->self, s));
    if (status >= 0 && s->progress) s->progress->accepted_steps++;
    return status;
}

pd_status pd_physics_run(pd_ctx *ctx, pd_physics p, double t_end)
{
    pd_step s;
    pd_status worst = PD_OK;
    if (!p.time || !(t_end >= *p.time))
        return pd_fail(ctx, PD_ERR_ARGUMENT, p.name, "a run from %g s to %g s", p.time ? *p.time : (double)NAN, t_end);
    memset(&s, 0, sizeof s);
    pdi_physics_progress pace = {*p.time, 0};
    for (s.time = *p.time; s.time < t_end; s.time = s.end) {
        s.latest_end = t_end;
        pd_status status = pdi_physics_step(ctx, &p, &s);
        if (status < 0) return status;
        if (status > 0) worst = status;
        PD_TRY(pdi_physics_check_progress(ctx, p.name, &pace, s.end, t_end));
    }
    if (p.finish) PD_TRY(p.finish(ctx, p.self, t_end));
    return worst;
}

#undef PDI_PHYSICS_MAX_ATTEMPTS
#undef PDI_PHYSICS_PROGRESS_STEPS
#undef PDI_PHYSICS_MAX_STEPS
