/* couple: see couple.h */
#include "couple.h"
#include <float.h>
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
    /* what has passed is rounded in every step, and may be many times the metal */
    double rounding = DBL_EPSILON * (double)(c->steps + 8) * (fabs(l->in) + fabs(l->out));
    if (!(fabs(l->imbalance) <= c->desc.ledger_tolerance * scale + rounding))
        return pdi_fail(
            ctx, PD_ERR_LEDGER, "couple",
            "at t = %g s solid %.9g + dissolved %.9g + out %.9g - in %.9g mol misses the start %.9g mol by %.3g",
            c->time, l->solid, l->dissolved, l->out, l->in, l->start, l->imbalance);
    return PD_OK;
}

/* Between metal and walls that the horizon spans the equations of the lattice may have a solution that is none. */
static pd_status pdi_couple_enters(pd_ctx *ctx, const pd_couple *c)
{
    double given, taken = pdi_flow_entering(ctx, c->flow, &given);
    if (!(given * taken < 0.0)) return PD_OK;
    return pdi_fail(ctx, PD_ERR_GEOMETRY, "couple",
                    "the flow at t = %g s passes the inlets at %.3g m3/s (2D: m2/s), expected about %.3g: the horizon "
                    "spans what lies between them and the outlets. Refine the grid, take a smaller m or free cells",
                    c->time, taken, given);
}

/* Why a flow solve may have failed: what enters cannot leave. `status` where there is another reason. */
static pd_status pdi_couple_blocked(pd_ctx *ctx, const pd_couple *c, pd_status status)
{
    double given;
    int32_t node;
    char place[PDI_GRID_PLACE];
    pdi_flow_entering(ctx, c->flow, &given);
    if (pdi_lacks_memory(status) || !(fabs(given) > 0.0)) return status;
    PDI_TRY(pdi_flow_blocked(ctx, c->flow, &node));
    if (node < 0) return status;
    return pdi_fail(ctx, PD_ERR_GEOMETRY, "couple",
                    "the flow at t = %g s has no way from the inlet beside %s m to an outlet: metal or walls close it",
                    c->time, pdi_grid_place(c->grid, node, place));
}

static pd_status pdi_couple_flow(pd_ctx *ctx, pd_couple *c)
{
    if (!c->steady || !c->flow_stale) return PD_OK;
    char place[PDI_GRID_PLACE];
    pd_status status = pd_steady_solve(ctx, c->steady, &c->steady_result);
    c->flow_solves++;
    c->krylov_flow += c->steady_result.krylov;
    c->flow_evaluations += c->steady_result.evaluations;
    if (status != PD_OK) status = pdi_couple_blocked(ctx, c, status);
    if (status < 0) return status;
    if (status != PD_OK)
        return pdi_fail(
            ctx, PD_ERR_DIVERGED, "couple",
            "the flow is not steady at t = %g s: residuals %.3g (momentum) and %.3g (continuity) after %d steps, "
            "expected %g, the largest at %s m. Loosen the tolerance, refine the grid or lower the Reynolds number",
            c->time, c->steady_result.momentum, c->steady_result.continuity, c->steady_result.newton,
            c->steady->desc.tolerance, pdi_grid_place(c->grid, pdi_steady_worst(c->steady), place));
    PDI_TRY(pdi_couple_enters(ctx, c));
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
    c->started = 1;
    return pdi_couple_balance(ctx, c);
}

#define PDI_COUPLE_GROWTH 2.0
/* Step [s] beside fluid above saturation: longer than the one before by that factor, the first one a share of the time
 * in which the law at C = 0 takes a layer. Metal that rests now may go before a long step ends. */
static double pdi_couple_stalled(const pd_couple *c)
{
    const pd_dissolve *d = c->dissolve;
    const pd_stencil *s = c->bonds->stencil;
    double area = 0.0;
    if (c->dt > 0.0) return PDI_COUPLE_GROWTH * c->dt;
    for (int k = 0; k < s->count; k++) area += 0.5 * s->area[k];
    return c->desc.fraction / (area * d->desc.rate(d->desc.rate_user, 0.0));
}

/* Longest admissible step, then equal steps up to t_limit. */
static double pdi_couple_choose(pd_ctx *ctx, const pd_couple *c, double t_limit)
{
    double left = t_limit - c->time, dt = left;
    double fastest = c->dissolve ? pd_dissolve_fastest(ctx, c->dissolve) : 0.0;
    if (fastest > 0.0) dt = fmin(dt, c->desc.fraction / fastest);
    if (c->dissolve && c->dissolve->stalled) dt = fmin(dt, pdi_couple_stalled(c));
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
    pd_status status = c->dissolve ? pd_dissolve_transport(ctx, c->dissolve, *dt, &c->transport_result)
                                   : pd_transport_implicit(ctx, c->transport, *dt, &c->transport_result);
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
    if (!c->started) {
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

/* ---- state ---- */

/* Lattice and parts, which the file must have alike. */
static pd_status pdi_couple_alike(pd_ctx *ctx, const pd_couple *c, pd_store *store)
{
    const pd_grid *grid = c->grid;
    const void *const parts[] = {c->flow, c->steady, c->implicit, c->unsteady, c->transport, c->advance, c->dissolve,
                                 c->corrode, c->recede};
    static const char *const part_names[] = {"flow", "steady", "implicit", "unsteady", "transport", "advance",
                                             "dissolve", "corrode", "recede"};
    static const char *const cells[] = {"cells along x", "cells along y", "cells along z"};
    static const char *const spacing[] = {"h along x [m]", "h along y [m]", "h along z [m]"};
    static const char *const low[] = {"low end along x [m]", "low end along y [m]", "low end along z [m]"};
    for (int d = 0; d < PD_DIM; d++) {
        PDI_TRY(pd_store_check(ctx, store, cells[d], grid->n[d]));
        PDI_TRY(pd_store_check(ctx, store, spacing[d], grid->h[d]));
        PDI_TRY(pd_store_check(ctx, store, low[d], grid->lo[d]));
    }
    PDI_TRY(pd_store_check(ctx, store, "ghost layers", grid->ghost));
    PDI_TRY(pd_store_check(ctx, store, "metal nodes at the start", (double)c->solid_nodes_start));
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++)
        PDI_TRY(pd_store_check(ctx, store, part_names[k], parts[k] != NULL));
    return PD_OK;
}

/* Turn the metal of the grid fluid where `kind` says so, and let all that follows from kinds follow. */
static pd_status pdi_couple_turn(pd_ctx *ctx, pd_couple *c, const uint8_t *kind, int32_t *turned)
{
    int32_t count = 0;
    for (int32_t i = 0; i < c->grid->total; i++) {
        int at[PD_DIM];
        pdi_grid_index(c->grid, i, at);
        if (kind[i] == PD_FLUID && c->grid->kind[i] == PD_SOLID && pdi_grid_inside(c->grid, at)) turned[count++] = i;
    }
    for (int32_t n = 0; n < count; n++) pdi_grid_dissolve(c->grid, turned[n]);
    for (int32_t i = 0; i < c->grid->total; i++)
        if (kind[i] != c->grid->kind[i])
            return pdi_fail(ctx, PD_ERR_GEOMETRY, "couple", "node %d is of kind %d in the file, expected %d", (int)i,
                            kind[i], c->grid->kind[i]);
    if (!count || c->corrode) return PD_OK;
    PDI_TRY(pd_bonds_update(ctx, turned, count, c->bonds));
    if (c->flow) PDI_TRY(pd_flow_update(ctx, turned, count, c->flow));
    if (c->transport) PDI_TRY(pd_transport_update(ctx, c->transport));
    if (c->dissolve) pdi_dissolve_turned(c->dissolve, turned, count);
    return PD_OK;
}

static pd_status pdi_couple_kinds(pd_ctx *ctx, pd_couple *c, pd_store *store)
{
    uint8_t *kind = NULL;
    int32_t *turned = NULL, total = c->grid->total;
    int64_t most = c->solid_nodes_start;
    if (!store->reading) return PDI_STORE(ctx, store, "grid.kind", c->grid->kind, total);
    pd_status status = PDI_NEW(ctx, "couple", total, kind);
    if (status == PD_OK) status = PDI_NEW(ctx, "couple", most, turned);
    if (status == PD_OK) status = PDI_STORE(ctx, store, "grid.kind", kind, total);
    if (status == PD_OK) status = pdi_couple_turn(ctx, c, kind, turned);
    PDI_DELETE(ctx, total, kind);
    PDI_DELETE(ctx, most, turned);
    return status;
}

static pd_status pdi_couple_parts(pd_ctx *ctx, pd_couple *c, pd_store *store)
{
    if (c->flow) PDI_TRY(pdi_flow_store(ctx, c->flow, store));
    if (c->steady) PDI_TRY(pdi_steady_store(ctx, c->steady, store));
    if (c->implicit) PDI_TRY(pdi_implicit_store(ctx, c->implicit, store));
    if (c->unsteady) PDI_TRY(pdi_unsteady_store(ctx, c->unsteady, store));
    if (c->transport) PDI_TRY(pdi_transport_store(ctx, c->transport, store));
    if (c->advance) PDI_TRY(pdi_advance_store(ctx, c->advance, store));
    if (c->corrode) PDI_TRY(pdi_corrode_store(ctx, c->corrode, store));
    return c->recede ? pdi_recede_store(ctx, c->recede, store) : PD_OK;
}

pd_status pd_couple_store(pd_ctx *ctx, pd_couple *c, pd_store *store)
{
    pd_steady_result *flow = &c->steady_result;
    pd_transport_result *transport = &c->transport_result;
    PDI_TRY(pdi_couple_alike(ctx, c, store));
    PDI_TRY(pdi_couple_kinds(ctx, c, store));
    PDI_TRY(pdi_couple_parts(ctx, c, store));
    PDI_TRY(PDI_STORE(ctx, store, "time", &c->time, 1));
    PDI_TRY(PDI_STORE(ctx, store, "dt", &c->dt, 1));
    PDI_TRY(PDI_STORE(ctx, store, "started", &c->started, 1));
    PDI_TRY(PDI_STORE(ctx, store, "steps", &c->steps, 1));
    PDI_TRY(PDI_STORE(ctx, store, "flow solves", &c->flow_solves, 1));
    PDI_TRY(PDI_STORE(ctx, store, "unsolved", &c->unsolved, 1));
    PDI_TRY(PDI_STORE(ctx, store, "krylov of the flow", &c->krylov_flow, 1));
    PDI_TRY(PDI_STORE(ctx, store, "krylov of transport", &c->krylov_transport, 1));
    PDI_TRY(PDI_STORE(ctx, store, "evaluations of the flow", &c->flow_evaluations, 1));
    PDI_TRY(PDI_STORE(ctx, store, "flow stale", &c->flow_stale, 1));
    PDI_TRY(PDI_STORE(ctx, store, "momentum residual", &flow->momentum, 1));
    PDI_TRY(PDI_STORE(ctx, store, "continuity residual", &flow->continuity, 1));
    PDI_TRY(PDI_STORE(ctx, store, "limiter steps", &transport->limiter, 1));
    PDI_TRY(PDI_STORE(ctx, store, "change", &transport->change, 1));
    PDI_TRY(PDI_STORE(ctx, store, "solid at the start", &c->solid_start, 1));
    return PDI_STORE(ctx, store, "ledger", &c->ledger, 1);
}
