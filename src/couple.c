/* couple: see couple.h */
#include "couple.h"
#include <math.h>
#include <string.h>

static double pdi_couple_solid(pd_ctx *ctx, const pd_couple *c)
{
    return c->dissolve ? pd_dissolve_stock(ctx, c->dissolve) : 0.0;
}

static pd_status pdi_couple_balance(pd_ctx *ctx, pd_couple *c)
{
    pd_ledger *l = &c->ledger;
    if (!c->transport && !c->corrode) return PD_OK;
    if (c->corrode) {
        l->solid = pd_corrode_solid(c->corrode);
        l->dissolved = pd_corrode_dissolved(c->corrode);
        l->out = c->corrode->out + c->corrode->out_carry;
    } else {
        l->solid = pdi_couple_solid(ctx, c);
        l->dissolved = pd_transport_stock(ctx, c->transport);
        l->carry = pd_transport_carried(ctx, c->transport);
    }
    if (c->steps == 0) {
        l->start = l->solid + l->dissolved;
        c->solid_start = l->solid;
    }
    l->imbalance = (l->solid + l->dissolved + l->carry - l->start) + (l->out - l->in);
    double scale = c->solid_start > 0.0 ? c->solid_start : fmax(l->start, fmax(l->in, l->out));
    l->relative = scale > 0.0 ? fabs(l->imbalance) / scale : 0.0;
    if (!(l->relative <= c->desc.ledger_tolerance))
        return pdi_fail(
            ctx, PD_ERR_LEDGER, "couple",
            "at t = %g s solid %.9g + dissolved %.9g + out %.9g - in %.9g mol misses the start %.9g mol by %.3g",
            c->time, l->solid, l->dissolved, l->out, l->in, l->start, l->imbalance);
    return PD_OK;
}

static pd_status pdi_couple_flow(pd_ctx *ctx, pd_couple *c)
{
    if (!c->steady || !c->flow_stale) return PD_OK;
    pd_status status = pd_steady_solve(ctx, c->steady, &c->steady_result);
    c->flow_solves++;
    c->krylov_flow += c->steady_result.krylov;
    c->flow_evaluations += c->steady_result.evaluations;
    if (status < 0) return status;
    if (status != PD_OK)
        return pdi_fail(
            ctx, PD_ERR_DIVERGED, "couple",
            "the flow is not steady at t = %g s: residuals %.3g (momentum) and %.3g (continuity) after %d steps, "
            "expected %g. Loosen the tolerance, refine the grid or lower the Reynolds number",
            c->time, c->steady_result.momentum, c->steady_result.continuity, c->steady_result.newton,
            c->steady->desc.tolerance);
    c->flow_stale = 0;
    return PD_OK;
}

pd_status pd_couple_build(pd_ctx *ctx, const pd_couple_desc *desc, pd_grid *grid, pd_bonds *bonds, pd_flow *flow,
                          pd_steady *steady, pd_transport *transport, pd_dissolve *dissolve, pd_couple *c)
{
    memset(c, 0, sizeof *c);
    if (!(desc->fraction >= 0.0) || desc->fraction > 1.0 || !(desc->max_step >= 0.0) ||
        !(desc->ledger_tolerance >= 0.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "couple", "fraction %g must lie in [0, 1], max_step %g s be at least 0",
                        desc->fraction, desc->max_step);
    if (dissolve && !transport)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "couple", "dissolution needs transport");
    c->desc = *desc;
    if (!(c->desc.fraction > 0.0)) c->desc.fraction = 0.1;
    if (!(c->desc.ledger_tolerance > 0.0)) c->desc.ledger_tolerance = 1e-10;
    c->grid = grid;
    c->bonds = bonds;
    c->flow = flow;
    c->steady = steady;
    c->transport = transport;
    c->dissolve = dissolve;
    c->flow_stale = flow != NULL;
    c->solid_nodes_start = grid->solid_count;
    return PD_OK;
}

/* Move the flow on by a step that does not pass t_limit; *reached: where it ends. */
static pd_status pdi_couple_move(pd_ctx *ctx, pd_couple *c, double t_limit, double *reached)
{
    double left = t_limit - c->time, dt = left;
    int64_t before = c->flow->evaluations;
    if (c->desc.max_step > 0.0) dt = fmin(dt, c->desc.max_step);
    if (c->implicit) {
        double wanted = c->implicit->dt > 0.0 ? c->implicit->dt : c->implicit->desc.first;
        dt = fmin(dt, wanted);
    }
    dt = left / ceil(left / dt * (1.0 - 1e-12));
    *reached = dt < left ? c->time + dt : t_limit;
    PDI_TRY(c->implicit ? pd_implicit_run(ctx, c->implicit, *reached) : pd_unsteady_run(ctx, c->unsteady, *reached));
    c->flow_evaluations += c->flow->evaluations - before;
    c->flow_solves++;
    return PD_OK;
}

pd_status pd_couple_start(pd_ctx *ctx, pd_couple *c)
{
    int moving = (c->implicit != NULL) + (c->unsteady != NULL);
    if ((c->flow && !c->steady && moving != 1) || (c->dissolve && (moving || c->advance)))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "couple",
                        "flow needs one solver, dissolution a steady one and the steps of the coupling");
    if (moving) pd_flow_prepare(ctx, c->flow);
    if (c->advance) c->advance->time = c->time;
    PDI_TRY(pdi_couple_flow(ctx, c));
    if (c->settle) {
        pd_status status = pd_transport_steady(ctx, c->transport, &c->transport_result);
        c->krylov_transport += c->transport_result.krylov;
        if (status < 0) return status;
    }
    return pdi_couple_balance(ctx, c);
}

/* Longest admissible step, then equal steps up to t_limit. */
static double pdi_couple_choose(pd_ctx *ctx, const pd_couple *c, double t_limit)
{
    double left = t_limit - c->time, dt = left;
    double fastest = c->dissolve ? pd_dissolve_fastest(ctx, c->dissolve) : 0.0;
    if (fastest > 0.0) dt = fmin(dt, c->desc.fraction / fastest);
    if (c->desc.max_step > 0.0 && !c->implicit && !c->unsteady) dt = fmin(dt, c->desc.max_step);
    return left / ceil(left / dt * (1.0 - 1e-12));
}

/* Transport over one step that does not pass t_limit: in one step, or in as many as its error asks for. */
static pd_status pdi_couple_transport(pd_ctx *ctx, pd_couple *c, double t_limit, double *dt)
{
    *dt = t_limit - c->time;
    if (c->advance) {
        pd_advance *a = c->advance;
        double out = a->out, in = a->in;
        int64_t krylov = a->krylov;
        pd_status status = c->implicit || c->unsteady ? pd_advance_run(ctx, a, t_limit, &c->transport_result)
                                                      : pd_advance_next(ctx, a, t_limit, &c->transport_result);
        if (status < 0) return status;
        if (a->time < t_limit) *dt = a->time - c->time;
        c->krylov_transport += a->krylov - krylov;
        c->ledger.out += a->out - out;
        c->ledger.in += a->in - in;
        return status;
    }
    if (c->dissolve) PDI_TRY(pd_dissolve_prepare(ctx, c->dissolve));
    *dt = pdi_couple_choose(ctx, c, t_limit);
    pd_status status = pd_transport_implicit(ctx, c->transport, *dt, &c->transport_result);
    if (status < 0) return status;
    c->krylov_transport += c->transport_result.krylov;
    c->ledger.out += *dt * c->transport->outflow;
    c->ledger.in += *dt * c->transport->inflow;
    return status;
}

static pd_status pdi_couple_dissolve(pd_ctx *ctx, pd_couple *c, double dt)
{
    pd_dissolve *d = c->dissolve;
    PDI_TRY(pd_dissolve_finish(ctx, d, dt));
    if (!d->changed_count) return PD_OK;
    PDI_TRY(pd_bonds_update(ctx, d->changed, d->changed_count, c->bonds));
    if (c->flow) PDI_TRY(pd_flow_update(ctx, d->changed, d->changed_count, c->flow));
    PDI_TRY(pd_transport_update(ctx, c->transport));
    c->flow_stale = c->flow != NULL;
    return PD_OK;
}

/* Bond-based corrosion over a step of the coupling: an implicit one, or as many explicit ones as it needs. */
static pd_status pdi_couple_corrode(pd_ctx *ctx, pd_couple *c, double t_limit)
{
    pd_corrode *r = c->corrode;
    double left = t_limit - c->time, reached = t_limit;
    int64_t before = r->steps;
    if (c->desc.max_step > 0.0 && left > c->desc.max_step)
        reached = c->time + left / ceil(left / c->desc.max_step * (1.0 - 1e-12));
    if (c->recede) {
        PDI_TRY(pd_recede_next(ctx, c->recede, reached));
        reached = r->time;
    } else PDI_TRY(pd_corrode_run(ctx, r, reached));
    c->dt = (reached - c->time) / (double)(r->steps - before);
    c->time = reached;
    c->steps = r->steps;
    return pdi_couple_balance(ctx, c);
}

pd_status pd_couple_step(pd_ctx *ctx, pd_couple *c, double t_limit)
{
    double dt = t_limit - c->time;
    pd_status status = PD_OK;
    if (!(t_limit > c->time))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "couple", "a step from %g s cannot end at %g s", c->time, t_limit);
    if (c->corrode) return pdi_couple_corrode(ctx, c, t_limit);
    if (c->implicit || c->unsteady) PDI_TRY(pdi_couple_move(ctx, c, t_limit, &t_limit));
    if (c->transport) status = pdi_couple_transport(ctx, c, t_limit, &dt);
    else dt = t_limit - c->time;
    if (status < 0) return status;
    c->unsolved += status > 0;
    if (c->dissolve) PDI_TRY(pdi_couple_dissolve(ctx, c, dt));
    c->dt = dt;
    c->time = dt < t_limit - c->time ? c->time + dt : t_limit;
    c->steps++;
    PDI_TRY(pdi_couple_balance(ctx, c));
    PDI_TRY(pdi_couple_flow(ctx, c));
    return status;
}

pd_status pd_couple_run(pd_ctx *ctx, pd_couple *c, double t_end, double every, pd_observer_fn observer, void *user)
{
    if (!(t_end >= c->time) || !(every >= 0.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "couple", "the run from %g s to %g s with output every %g s", c->time,
                        t_end, every);
    if (c->steps == 0) {
        PDI_TRY(pd_couple_start(ctx, c));
        if (observer && observer(user, c)) return PD_OK;
    }
    while (c->time < t_end) {
        double limit = t_end;
        if (every > 0.0) {
            limit = (floor(c->time / every * (1.0 + 1e-12)) + 1.0) * every;
            if (limit > t_end * (1.0 - 1e-12)) limit = t_end;
        }
        PDI_TRY(pd_couple_step(ctx, c, limit));
        if (observer && observer(user, c)) break;
    }
    return c->unsolved ? PD_NOT_CONVERGED : PD_OK;
}

double pd_couple_volume_loss(const pd_couple *c)
{
    return c->solid_start > 0.0 ? 1.0 - c->ledger.solid / c->solid_start : 0.0;
}
