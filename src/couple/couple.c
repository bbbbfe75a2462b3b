/* couple: see couple.h */
#include "couple/couple.h"
#include "metal/content.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Share of a node that a step takes over the error of the loss that it is taken for. */
#define PDI_COUPLE_FRACTION 25.0

static double pdi_couple_solid(pd_ctx *ctx, const pd_couple *c)
{
    return c->dissolve ? pd_dissolve_stock(ctx, c->dissolve) : 0.0;
}

static pd_status pdi_couple_balance(pd_ctx *ctx, pd_couple *c)
{
    pd_ledger *l = &c->ledger;
    if (!c->transport) return PD_OK;
    l->solid = pdi_couple_solid(ctx, c);
    l->dissolved = pd_transport_stock(ctx, c->transport);
    l->carry = pd_transport_carried(ctx, c->transport);
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

/* A residual that may do as a tolerance. */
#define PDI_COUPLE_NEARLY 1e-3

/* Factor between what enters and what the inlets push that no lattice explains: 1 but for some per cent, 1.7 with metal
 * within a horizon of the inlet (test_couple). */
#define PDI_COUPLE_ENTERS 2.0
/* Inlets whose sum is below this share of them feed each other. */
#define PDI_COUPLE_FEEDS 1e-6

/* Fluxes that contradict each other are no result: between metal and walls that the horizon spans the equations of the
 * lattice may have a solution that is none. */
static pd_status pdi_couple_enters(pd_ctx *ctx, const pd_couple *c)
{
    char place[PDI_GRID_PLACE];
    double pushed, gross, taken = pdi_flow_entering(ctx, c->flow, &pushed, &gross);
    double excess = (taken - pushed) / gross;
    if (gross > 0.0 && !(excess >= 1.0 / PDI_COUPLE_ENTERS - 1.0 && excess <= PDI_COUPLE_ENTERS - 1.0))
        return pdi_fail(ctx, PD_ERR_GEOMETRY, "couple",
                        "the flow at t = %g s passes the inlets at %.3g m3/s (2D: m2/s), expected about %.3g: the "
                        "horizon spans what lies between them and the outlets. Refine the grid, take a smaller m or "
                        "free cells",
                        c->time, taken, pushed);
    if (!(c->steady->uneven <= c->steady->desc.tolerance * gross) && gross > 0.0)
        return pdi_fail(ctx, PD_ERR_DIVERGED, "couple",
                        "the fluxes through sections of the flow at t = %g s differ by up to %.3g m3/s (2D: m2/s), "
                        "expected at most %g of the %.3g that enter, most of all at %s m. Loosen the tolerance or "
                        "refine the grid",
                        c->time, c->steady->uneven, c->steady->desc.tolerance, gross,
                        pdi_grid_place(c->grid, pdi_steady_worst(c->steady), place));
    return PD_OK;
}

/* Why a flow solve may have failed: what enters cannot leave. `status` where there is another reason. */
static pd_status pdi_couple_blocked(pd_ctx *ctx, const pd_couple *c, pd_status status)
{
    double pushed, gross;
    int32_t node;
    char place[PDI_GRID_PLACE];
    pdi_flow_entering(ctx, c->flow, &pushed, &gross);
    /* not inlets that feed each other */
    if (pdi_is_final(status) || !(fabs(pushed) > PDI_COUPLE_FEEDS * gross)) return status;
    PDI_TRY(pdi_port_blocked(ctx, c->flow->bonds, &node));
    if (node < 0) return status;
    return pdi_fail(ctx, PD_ERR_GEOMETRY, "couple",
                    "the flow at t = %g s has no way from the inlet beside %s m to an outlet: metal or walls close it",
                    c->time, pdi_grid_place(c->grid, node, place));
}

/* What a flow solve has reached that made no more progress, and what helps. */
static pd_status pdi_couple_unsteady(pd_ctx *ctx, const pd_couple *c)
{
    const pd_steady_result *r = &c->steady_result;
    char place[PDI_GRID_PLACE], accept[64], why[120];
    double reached = r->excess * c->steady->desc.tolerance;
    accept[0] = '\0';
    if (reached < PDI_COUPLE_NEARLY) snprintf(accept, sizeof accept, "; steady = %.1e accepts this one", 1.1 * reached);
    /* from there Newton's next step would reach the rounding: this is it, and no flow that moves */
    if (reached < sqrt(DBL_EPSILON)) snprintf(why, sizeof why, "That is as far as their rounding lets them fall");
    else
        snprintf(why, sizeof why,
                 "At Re = %.3g there may be no steady flow: time = implicit in [flow] tells how it moves",
                 c->flow->speed * c->flow->length / c->flow->nu);
    return pdi_fail(ctx, PD_ERR_DIVERGED, "couple",
                    "the flow is not steady at t = %g s: after %d Newton steps the residuals are %.3g (momentum) and "
                    "%.3g (continuity), %.3g times what steady = %g allows, largest at %s m, and further steps do not "
                    "lower them. %s%s", c->time, r->newton, r->momentum, r->continuity, r->excess,
                    c->steady->desc.tolerance, pdi_grid_place(c->grid, pdi_steady_worst(c->steady), place), why,
                    accept);
}

static pd_status pdi_couple_flow(pd_ctx *ctx, pd_couple *c)
{
    if (!c->steady || !c->flow_stale) return PD_OK;
    pd_status status = pd_steady_solve(ctx, c->steady, &c->steady_result);
    c->flow_solves++;
    c->krylov_flow += c->steady_result.krylov;
    c->flow_evaluations += c->steady_result.evaluations;
    if (status != PD_OK) status = pdi_couple_blocked(ctx, c, status);
    if (status < 0) return status;
    if (status != PD_OK) return pdi_couple_unsteady(ctx, c);
    PDI_TRY(pdi_couple_enters(ctx, c));
    c->flow_stale = 0;
    c->flow_moved = 0.0;
    return PD_OK;
}

/* What stands outside becomes that of time t; a steady flow follows when it has moved by more than its tolerance. */
static pd_status pdi_couple_at(pd_ctx *ctx, void *user, double t)
{
    pd_couple *c = (pd_couple *)user;
    if (c->steady) {
        double moved;
        PDI_TRY(pd_flow_at(ctx, c->flow, t, 0.0, &moved));
        c->flow_moved += moved;
        if (c->flow_moved > c->steady->desc.tolerance) c->flow_stale = 1;
        PDI_TRY(pdi_couple_flow(ctx, c));
    }
    return c->transport ? pd_transport_at(ctx, c->transport, t) : PD_OK;
}

pd_status pd_couple_build(pd_ctx *ctx, const pd_couple_desc *desc, pd_grid *grid, pd_bonds *bonds, pd_flow *flow,
                          pd_steady *steady, pd_transport *transport, pd_dissolve *dissolve, pd_couple *c)
{
    memset(c, 0, sizeof *c);
    if (!(desc->fraction >= 0.0) || desc->fraction > 1.0 || !(desc->rtol >= 0.0) || desc->rtol > 1.0 ||
        !(desc->max_step >= 0.0) || !(desc->ledger_tolerance >= 0.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "couple",
                        "fraction %g and rtol %g must lie in [0, 1], max_step %g s be at least 0", desc->fraction,
                        desc->rtol, desc->max_step);
    if (dissolve && !transport)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "couple", "dissolution needs transport");
    c->desc = *desc;
    if (!(c->desc.fraction > 0.0)) c->desc.fraction = 0.1;
    if (!(c->desc.rtol > 0.0)) c->desc.rtol = c->desc.fraction / PDI_COUPLE_FRACTION;
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
    if (pdi_stands_still(c->time, left, dt))
        return pdi_fail(ctx, PD_ERR_STATE, "couple",
                        "steps of %g s do not lead on from t = %g s to %g s: max_step (%g s) is too small", dt,
                        c->time, t_limit, c->desc.max_step);
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
    PDI_TRY(pdi_couple_at(ctx, c, c->time));
    if (c->settle) {
        pd_status status = pd_transport_steady(ctx, c->transport, &c->transport_result);
        c->krylov_transport += c->transport_result.krylov;
        if (status < 0) return status;
        char place[PDI_GRID_PLACE];
        if (status != PD_OK)
            return pdi_fail(ctx, PD_ERR_DIVERGED, "couple",
                            "the concentration is not steady: what the balances of the nodes lack is %.3g of what "
                            "passes, expected %g, and a step still changes %.3g of it; the largest at %s m. Solve in "
                            "time, with advection = upwind, or on a finer grid", c->transport_result.defect,
                            PDI_SETTLE_DEFECT, c->transport_result.change,
                            pdi_grid_place(c->grid, pdi_settle_worst(c->transport), place));
    }
    c->started = 1;
    return pdi_couple_balance(ctx, c);
}

/* Longest admissible step, then equal steps up to t_limit. */
static double pdi_couple_choose(pd_ctx *ctx, const pd_couple *c, double t_limit)
{
    double left = t_limit - c->time, dt = left;
    double fastest = c->dissolve ? pd_dissolve_fastest(ctx, c->dissolve) : 0.0;
    if (fastest > 0.0) dt = fmin(dt, c->desc.fraction / fastest);
    if (c->dissolve) dt = fmin(dt, c->dissolve->next_dt);
    if (c->desc.max_step > 0.0 && !c->implicit && !c->unsteady) dt = fmin(dt, c->desc.max_step);
    return left / ceil(left / dt * (1.0 - 1e-12));
}

/* Share of `fraction` that the course of a law within a step may cost. */
#define PDI_COUPLE_EXACT 0.04

/* A law that depends on time holds at the middle of a step: that is of second order. The step becomes so short that it
 * takes no more than it may, and that the rest is a small part of that; a jump is met within that, too. */
static void pdi_couple_law(const pd_couple *c, double t_limit, double *dt)
{
    double left = t_limit - c->time;
    for (;;) {
        double error, taken;
        pdi_dissolve_course(c->dissolve, c->time, *dt, &error, &taken);
        double share = fmax(taken / c->desc.fraction, error / (PDI_COUPLE_EXACT * c->desc.fraction));
        if (share <= 1.0 + 1e-9) return;
        *dt = left / ceil(left / (*dt * fmax(0.9 / share, 0.1)) * (1.0 - 1e-12));
    }
}

/* A node may lose this much more than the share that steps are chosen for, where the law speeds up. A step this much
 * shorter than wanted has failed. */
#define PDI_COUPLE_EXCESS 2.0
#define PDI_COUPLE_SHORTEST 1e-9

/* Steps that time cannot count lead nowhere. */
static pd_status pdi_couple_moves(pd_ctx *ctx, const pd_couple *c, double t_limit, double dt)
{
    if (!pdi_stands_still(c->time, t_limit - c->time, dt)) return PD_OK;
    return pdi_fail(ctx, PD_ERR_STATE, "couple",
                    "steps of %g s do not lead on from t = %g s to %g s: fraction (%g) or max_step (%g s) is too "
                    "small, or the metal dissolves too fast", dt, c->time, t_limit, c->desc.fraction, c->desc.max_step);
}

/* Transport and law over a step of at most dt [s], which becomes the one taken. */
static pd_status pdi_couple_react(pd_ctx *ctx, pd_couple *c, double t_limit, double *dt)
{
    pd_dissolve *d = c->dissolve;
    double first = 0.0, left = t_limit - c->time;
    pd_status status;
    d->most = PDI_COUPLE_EXCESS * c->desc.fraction;
    d->rtol = c->desc.rtol;
    d->lost = c->solid_start - c->ledger.solid;
    d->time = c->time;
    PDI_TRY(pd_dissolve_prepare(ctx, d));
    for (*dt = pdi_couple_choose(ctx, c, t_limit);; *dt = left / ceil(left / d->retry_dt * (1.0 - 1e-12))) {
        if (!d->desc.uniform) pdi_couple_law(c, t_limit, dt);
        if (!d->desc.uniform || first > 0.0) { /* what changes in time is taken at the middle of the step */
            d->time = c->time + 0.5 * *dt;
            PDI_TRY(pd_dissolve_prepare(ctx, d));
        }
        PDI_TRY(pdi_couple_moves(ctx, c, t_limit, *dt));
        PDI_TRY(pdi_couple_at(ctx, c, c->time + *dt));
        status = pd_dissolve_transport(ctx, d, *dt, &c->transport_result);
        c->krylov_transport += status < 0 ? 0 : c->transport_result.krylov;
        if (status != PD_RETRY) return status;
        first = fmax(first, *dt);
        if (d->retry_dt < PDI_COUPLE_SHORTEST * first) break;
    }
    return pdi_fail(ctx, PD_ERR_DIVERGED, "couple",
                    "at t = %g s law and transport have no common solution for steps of %g s or more, or the law grows "
                    "so fast that metal would lose more than %g of a cell in them. Take a smoother law",
                    c->time, *dt, d->most);
}

/* Transport over one step that does not pass t_limit: in one step, or in as many as its error asks for. */
static pd_status pdi_couple_transport(pd_ctx *ctx, pd_couple *c, double t_limit, double *dt)
{
    *dt = t_limit - c->time;
    if (c->advance) {
        pd_advance *a = c->advance;
        double out = a->out, in = a->in;
        int64_t krylov = a->krylov;
        if (c->steady) a->at = pdi_couple_at;
        a->at_user = c;
        pd_status status = c->implicit || c->unsteady ? pd_advance_run(ctx, a, t_limit, &c->transport_result)
                                                      : pd_advance_next(ctx, a, t_limit, &c->transport_result);
        if (status < 0) return status;
        if (a->time < t_limit) *dt = a->time - c->time;
        c->krylov_transport += a->krylov - krylov;
        c->ledger.out += a->out - out;
        c->ledger.in += a->in - in;
        return status;
    }
    pd_status status;
    if (c->dissolve) status = pdi_couple_react(ctx, c, t_limit, dt);
    else {
        *dt = pdi_couple_choose(ctx, c, t_limit);
        PDI_TRY(pdi_couple_moves(ctx, c, t_limit, *dt));
        PDI_TRY(pdi_couple_at(ctx, c, c->time + *dt));
        status = pd_transport_implicit(ctx, c->transport, *dt, &c->transport_result);
        c->krylov_transport += status < 0 ? 0 : c->transport_result.krylov;
    }
    if (status < 0) return status;
    c->ledger.out += *dt * c->transport->outflow;
    c->ledger.in += *dt * c->transport->inflow;
    return status;
}

static pd_status pdi_couple_dissolve(pd_ctx *ctx, pd_couple *c, double dt)
{
    pd_dissolve *d = c->dissolve;
    PDI_TRY(pd_dissolve_finish(ctx, d, dt));
    c->ledger.out += d->rinsed;
    if (!d->changed_count || (c->rowless && c->transport->desc.given)) return PD_OK;
    PDI_TRY(pd_bonds_update(ctx, d->changed, d->changed_count, c->bonds));
    if (c->flow) PDI_TRY(pd_flow_update(ctx, d->changed, d->changed_count, c->flow));
    PDI_TRY(pd_transport_update(ctx, c->transport));
    c->flow_stale = c->flow != NULL;
    return PD_OK;
}

pd_status pd_couple_step(pd_ctx *ctx, pd_couple *c, double t_limit)
{
    double dt = t_limit - c->time;
    pd_status status = PD_OK;
    if (!(t_limit > c->time))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "couple", "a step from %g s cannot end at %g s", c->time, t_limit);
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
static pd_status pdi_couple_alike(pd_ctx *ctx, const pd_couple *c, pd_archive *archive)
{
    const pd_grid *grid = c->grid;
    const void *const parts[] = {c->flow, c->steady, c->implicit, c->unsteady, c->transport, c->advance, c->dissolve};
    static const char *const part_names[] = {"flow", "steady", "implicit", "unsteady", "transport", "advance",
                                             "dissolve"};
    static const char *const cells[] = {"cells along x", "cells along y", "cells along z"};
    static const char *const spacing[] = {"h along x [m]", "h along y [m]", "h along z [m]"};
    static const char *const low[] = {"low end along x [m]", "low end along y [m]", "low end along z [m]"};
    for (int d = 0; d < PD_DIM; d++) {
        PDI_TRY(PDI_SAME(ctx, archive, cells[d], grid->n[d]));
        PDI_TRY(PDI_SAME(ctx, archive, spacing[d], grid->h[d]));
        PDI_TRY(PDI_SAME(ctx, archive, low[d], grid->lo[d]));
    }
    PDI_TRY(PDI_SAME(ctx, archive, "ghost layers", grid->ghost));
    PDI_TRY(PDI_SAME(ctx, archive, "metal nodes at the start", (double)c->solid_nodes_start));
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++)
        PDI_TRY(PDI_SAME(ctx, archive, part_names[k], parts[k] != NULL));
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
    if (!count) return PD_OK;
    PDI_TRY(pd_bonds_update(ctx, turned, count, c->bonds));
    if (c->flow) PDI_TRY(pd_flow_update(ctx, turned, count, c->flow));
    if (c->transport) PDI_TRY(pd_transport_update(ctx, c->transport));
    if (c->dissolve) pdi_content_turned(c->dissolve, turned, count);
    return PD_OK;
}

static pd_status pdi_couple_kinds(pd_ctx *ctx, pd_couple *c, pd_archive *archive)
{
    uint8_t *kind = NULL;
    int32_t *turned = NULL, total = c->grid->total;
    int64_t most = c->solid_nodes_start;
    if (!archive->reading) return PDI_KEEP(ctx, archive, "grid.kind", c->grid->kind, total);
    pd_status status = PDI_NEW(ctx, "couple", total, kind);
    if (status == PD_OK) status = PDI_NEW(ctx, "couple", most, turned);
    if (status == PD_OK) status = PDI_KEEP(ctx, archive, "grid.kind", kind, total);
    if (status == PD_OK) status = pdi_couple_turn(ctx, c, kind, turned);
    PDI_DELETE(ctx, total, kind);
    PDI_DELETE(ctx, most, turned);
    return status;
}

static pd_status pdi_couple_parts(pd_ctx *ctx, pd_couple *c, pd_archive *archive)
{
    if (c->flow) PDI_TRY(pdi_flow_store(ctx, c->flow, archive));
    if (c->steady) PDI_TRY(pdi_steady_store(ctx, c->steady, archive));
    if (c->implicit) PDI_TRY(pdi_implicit_store(ctx, c->implicit, archive));
    if (c->unsteady) PDI_TRY(pdi_unsteady_store(ctx, c->unsteady, archive));
    if (c->transport) PDI_TRY(pdi_transport_store(ctx, c->transport, archive));
    if (c->advance) PDI_TRY(pdi_advance_store(ctx, c->advance, archive));
    if (c->dissolve) PDI_TRY(pdi_dissolve_store(ctx, c->dissolve, archive));
    return PD_OK;
}

pd_status pd_couple_store(pd_ctx *ctx, pd_couple *c, pd_archive *archive)
{
    pd_steady_result *flow = &c->steady_result;
    pd_transport_result *transport = &c->transport_result;
    PDI_TRY(pdi_couple_alike(ctx, c, archive));
    PDI_TRY(pdi_couple_kinds(ctx, c, archive));
    PDI_TRY(pdi_couple_parts(ctx, c, archive));
    PDI_TRY(PDI_KEEP(ctx, archive, "time", &c->time, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "dt", &c->dt, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "started", &c->started, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "steps", &c->steps, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "flow solves", &c->flow_solves, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "unsolved", &c->unsolved, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "krylov of the flow", &c->krylov_flow, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "krylov of transport", &c->krylov_transport, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "evaluations of the flow", &c->flow_evaluations, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "flow stale", &c->flow_stale, 1));
    if (c->flow && c->flow->clock) PDI_TRY(PDI_KEEP(ctx, archive, "flow moved", &c->flow_moved, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "momentum residual", &flow->momentum, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "continuity residual", &flow->continuity, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "limiter steps", &transport->limiter, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "change", &transport->change, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "solid at the start", &c->solid_start, 1));
    return PDI_KEEP(ctx, archive, "ledger", &c->ledger, 1);
}
