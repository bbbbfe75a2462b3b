/* quasi_steady: see quasi_steady.h */
#include "flow/quasi_steady.h"
#include "flow/inlet_flux.h"
#include "lattice/open_boundary.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_QUASI_STEADY_PROPOSED_TOLERANCE 1e-3 /* a residual below this is proposed to the user as a tolerance */

/* Relative difference allowed between the inlet velocities and what bonds let in. It is rounding, unless the open bonds
 * of a node do not span space. */
#define PDI_QUASI_STEADY_INFLOW_TOLERANCE 1e-6
#define PDI_QUASI_STEADY_CLOSED_INFLOW 1e-6 /* net over gross inflow below which inlets are taken to feed each other \
                                             */

/* Checks the solved flow. PD_ERR_GEOMETRY: the inflow by bonds and the net one of the inlet velocities differ by more
 * than 1e-6 of the gross one. PD_ERR_DIVERGED: section_difference exceeds the tolerance of the solver times the gross
 * one. Where a horizon spans the gap between metal and walls, a solution on the lattice may be no flow. Nothing is
 * checked without inflow. Updates the derived fields. */
static pd_status pdi_quasi_steady_check_inflow(pd_ctx *ctx, const pd_quasi_steady *q)
{
    char place[PDI_GRID_POSITION_LENGTH];
    double pushed, gross, taken = pdi_inlet_flux_integrate(ctx, q->flow, &pushed, &gross);
    double excess = (taken - pushed) / gross;
    if (gross > 0.0 && !(fabs(excess) <= PDI_QUASI_STEADY_INFLOW_TOLERANCE))
        return pd_fail(ctx, PD_ERR_GEOMETRY, "steady",
                       "the flow at t = %g s passes the inlets at %.3g m3/s (2D: m2/s), expected about %.3g: the "
                       "horizon spans what lies between them and the outlets. Refine the grid, take a smaller m or "
                       "free cells",
                       q->time, taken, pushed);
    if (!(q->steady->section_difference <= q->steady->desc.tolerance * gross) && gross > 0.0)
        return pd_fail(ctx, PD_ERR_DIVERGED, "steady",
                       "the fluxes through sections of the flow at t = %g s differ by up to %.3g m3/s (2D: m2/s), "
                       "expected at most %g of the %.3g that enter, most of all at %s m. Loosen the tolerance or "
                       "refine the grid",
                       q->time, q->steady->section_difference, q->steady->desc.tolerance, gross,
                       pdi_grid_format_position(q->flow->grid, q->steady->worst_node, place));
    return PD_OK;
}

/* After a failed solve: fails with PD_ERR_GEOMETRY where an inlet has no open path to an outlet, else returns `status`.
 * Not checked after a fatal status, nor where the net inflow is at most 1e-6 of the gross one: inlets that feed each
 * other. */
static pd_status pdi_quasi_steady_check_open_path(pd_ctx *ctx, const pd_quasi_steady *q, pd_status status)
{
    double pushed, gross;
    int32_t node;
    char place[PDI_GRID_POSITION_LENGTH];
    pdi_inlet_flux_integrate(ctx, q->flow, &pushed, &gross);
    /* not inlets that feed each other */
    if (pd_is_fatal(status) || !(fabs(pushed) > PDI_QUASI_STEADY_CLOSED_INFLOW * gross)) return status;
    PD_TRY(pdi_open_boundary_find_blocked_inlet(ctx, q->flow->bonds, &node));
    if (node < 0) return status;
    return pd_fail(ctx, PD_ERR_GEOMETRY, "steady",
                   "the flow at t = %g s has no way from the inlet beside %s m to an outlet: metal or walls close it",
                   q->time, pdi_grid_format_position(q->flow->grid, node, place));
}

/* Fails with PD_ERR_DIVERGED and a message for a solve that stalled: what it has reached, whether that is rounding
 * (below 1.5e-8) or there may be no steady flow, and below 1e-3 the tolerance that accepts it. */
static pd_status pdi_quasi_steady_fail_unsteady(pd_ctx *ctx, const pd_quasi_steady *q)
{
    const pd_steady_result *r = &q->result;
    char place[PDI_GRID_POSITION_LENGTH], accept[64], why[120];
    double reached = r->residual_over_tolerance * q->steady->desc.tolerance;
    accept[0] = '\0';
    if (reached < PDI_QUASI_STEADY_PROPOSED_TOLERANCE)
        snprintf(accept, sizeof accept, "; steady_tolerance = %.1e accepts this one", 1.1 * reached);
    /* from there Newton's next step would reach the rounding: this is it, and no flow that moves */
    if (reached < sqrt(DBL_EPSILON)) snprintf(why, sizeof why, "That is as far as their rounding lets them fall");
    else
        snprintf(why, sizeof why,
                 "At Re = %.3g there may be no steady flow: time = implicit in [flow] shows how it moves",
                 q->flow->velocity_scale * q->flow->length_scale / q->flow->nu);
    return pd_fail(
        ctx, PD_ERR_DIVERGED, "steady",
        "the flow is not steady at t = %g s: after %d Newton steps the residuals are %.3g (momentum) and "
        "%.3g (continuity), %.3g times what steady_tolerance = %g allows, largest at %s m, and further steps do not "
        "lower them. %s%s",
        q->time, r->newton, r->momentum, r->continuity, r->residual_over_tolerance, q->steady->desc.tolerance,
        pdi_grid_format_position(q->flow->grid, q->steady->worst_node, place), why, accept);
}

/* Solves for the steady flow if it is out of date, counts the work, and checks it; else does nothing. It stays out of
 * date after a failure; success resets boundary_change. PD_ERR_DIVERGED: the solve did not converge. PD_ERR_GEOMETRY:
 * no open path, or a wrong inflow. */
static pd_status pdi_quasi_steady_update_flow(pd_ctx *ctx, pd_quasi_steady *q)
{
    if (!q->is_out_of_date) return PD_OK;
    pd_status status = pd_steady_solve(ctx, q->steady, &q->result);
    q->solves++;
    q->krylov += q->result.krylov;
    q->evaluations += q->result.evaluations;
    if (status != PD_OK) status = pdi_quasi_steady_check_open_path(ctx, q, status);
    if (status < 0) return status;
    if (status != PD_OK) return pdi_quasi_steady_fail_unsteady(ctx, q);
    PD_TRY(pdi_quasi_steady_check_inflow(ctx, q));
    q->is_out_of_date = 0;
    q->boundary_change = 0.0;
    return PD_OK;
}

/* Process callback: sets boundary data of time t [s], and adds their change to boundary_change. Solves when this sum
 * exceeds the tolerance of the solver, or when the flow was out of date before. */
static pd_status pdi_quasi_steady_set_time(pd_ctx *ctx, void *self, double t)
{
    pd_quasi_steady *q = (pd_quasi_steady *)self;
    double moved;
    q->time = t;
    PD_TRY(pdi_flow_set_time(ctx, q->flow, t, 0.0, &moved));
    q->boundary_change += moved;
    if (q->boundary_change > q->steady->desc.tolerance) q->is_out_of_date = 1;
    return pdi_quasi_steady_update_flow(ctx, q);
}

/* Process callback at the end of an outer step: solves if the flow is out of date. */
static pd_status pdi_quasi_steady_end(pd_ctx *ctx, void *self, double t)
{
    (void)t;
    return pdi_quasi_steady_update_flow(ctx, (pd_quasi_steady *)self);
}

/* Process callback: nodes `converted` have become fluid. Marks the flow out of date, and gives them velocity and
 * pressure (pd_flow_update); nothing is solved here. */
static pd_status pdi_quasi_steady_update_geometry(pd_ctx *ctx, void *self, const int32_t *converted, int32_t count)
{
    pd_quasi_steady *q = (pd_quasi_steady *)self;
    q->is_out_of_date = 1;
    return pd_flow_update(ctx, converted, count, q->flow);
}

/* Writes or reads the checkpoint. */
static pd_status pdi_quasi_steady_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_quasi_steady *q = (pd_quasi_steady *)self;
    PD_TRY(pdi_flow_store(ctx, q->flow, archive));
    PD_TRY(pdi_steady_store(ctx, q->steady, archive));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "flow solves", &q->solves, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "krylov of the flow", &q->krylov, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "evaluations of the flow", &q->evaluations, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "flow stale", &q->is_out_of_date, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "flow moved", &q->boundary_change, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "momentum residual", &q->result.momentum, 1));
    return PD_ARCHIVE_ARRAY(ctx, archive, "continuity residual", &q->result.continuity, 1);
}

pd_physics pd_quasi_steady_process(pd_flow *flow, pd_steady *steady, pd_quasi_steady *q)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    memset(q, 0, sizeof *q);
    q->flow = flow;
    q->steady = steady;
    q->is_out_of_date = 1;
    p.name = "steady flow";
    p.self = q;
    p.start = p.solve_at = pdi_quasi_steady_set_time;
    p.finish = pdi_quasi_steady_end;
    p.nodes_converted = pdi_quasi_steady_update_geometry;
    p.checkpoint = pdi_quasi_steady_store;
    return p;
}

#undef PDI_QUASI_STEADY_PROPOSED_TOLERANCE
#undef PDI_QUASI_STEADY_INFLOW_TOLERANCE
#undef PDI_QUASI_STEADY_CLOSED_INFLOW
