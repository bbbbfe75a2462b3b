/* flow_physics: see flow_physics.h */
#include "physics/flow_physics.h"
#include "flow/fourth_order.h"
#include "physics/developed_flow.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Sets the initial velocity at fluid nodes (prescribed flow: also at inlet nodes), and builds the time integrator of an
 * implicit or explicit flow; a prescribed flow has none, and keeps its velocity. PD_ERR_STATE: a component is NaN or at
 * least 1e100 in size. */
static pd_status pdi_flow_physics_build_unsteady(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_implicit_desc implicit;
    pd_weakly_compressible_desc explicit_;
    memset(&implicit, 0, sizeof implicit);
    memset(&explicit_, 0, sizeof explicit_);
    for (int32_t node = 0; node < m->grid.total; node++) {
        double x[PD_DIM];
        if (m->grid.kind[node] != PD_FLUID && m->grid.kind[node] != PD_INLET) continue;
        if (m->grid.kind[node] == PD_INLET && u->flow_time != PD_FLOW_PRESCRIBED) continue;
        pd_grid_position(&m->grid, node, x);
        pdi_grid_fold_position_images(&m->grid, x);
        for (int d = 0; d < PD_DIM; d++) {
            double v = pdi_setup_eval_expr(&u->initial_velocity[d], x, 0.0);
            if (!(fabs(v) < 1e100))
                return pd_fail(ctx, PD_ERR_STATE, "model", "the velocity at the start is %g m/s at x = %g m", v, x[0]);
            m->flow.u[(int64_t)d * m->grid.total + node] = v;
        }
    }
    implicit.rtol = u->flow_rtol;
    explicit_.eos = u->linear_eos ? PD_EOS_LINEAR : PD_EOS_TAIT;
    explicit_.sound_speed = u->sound_speed;
    pdi_flow_update_derived_fields(ctx, &m->flow);
    if (u->flow_time == PD_FLOW_PRESCRIBED) return PD_OK;
    if (u->flow_time == PD_FLOW_IMPLICIT) return pd_implicit_build(ctx, &m->flow, &m->steady, &implicit, &m->implicit);
    return pd_weakly_compressible_build(ctx, &m->flow, &explicit_, &m->unsteady);
}

/* Builds the flow, its steady solver (steady and implicit flow), the developed profiles of inlets, and what a flow in
 * time needs. Order auto stands for steady flow without a given order. Speed and length for reports are those of the
 * setup, else of the first inlet. error_line becomes that of the inlet whose profile fails. */
static pd_status pdi_flow_physics_build(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_flow_desc flow;
    pd_steady_desc steady;
    memset(&flow, 0, sizeof flow);
    memset(&steady, 0, sizeof steady);
    flow.rho = u->rho;
    flow.mu = u->mu;
    for (int d = 0; d < PD_DIM; d++) flow.force[d] = u->force[d];
    if (u->has_body_force_expr) flow.body = pdi_inlet_compute_body_force;
    flow.body_user = &m->inlet;
    if (m->inlet.is_time_dependent) flow.clock = &m->inlet.time;
    flow.p_out = u->p_out;
    flow.report_speed = u->speed;
    flow.report_length = u->length;
    flow.order = u->flow_order;
    if (!u->flow_order && u->flow_time == PD_FLOW_STEADY) flow.order = PD_FLOW_ORDER_AUTO;
    for (int s = 2 * PD_DIM - 1; s >= 0; s--) { /* what users know the inlet by */
        if (u->side[s].kind != PD_SIDE_INLET) continue;
        if (u->side[s].profile == PD_PROFILE_PARABOLA) flow.developed_sides |= 1 << s;
        if (!(u->speed > 0.0) && fabs(m->inlet.mean[s]) > 0.0) flow.report_speed = fabs(m->inlet.mean[s]);
        if (!(u->length > 0.0)) flow.report_length = m->inlet.width[s];
    }
    if (m->inlet.inlets) flow.inlet = pdi_inlet_get_velocity;
    flow.inlet_user = &m->inlet;
    if (pdi_wall_bc_has_motion(u)) flow.wall = pdi_wall_bc_get_velocity;
    flow.wall_user = &m->inlet;
    steady.tolerance = u->steady_tolerance;
    steady.arena = &m->arena;
    PD_TRY(pd_flow_build(ctx, &m->grid, &m->bonds, &flow, &m->flow));
    if (u->flow_time == PD_FLOW_STEADY || u->flow_time == PD_FLOW_IMPLICIT)
        PD_TRY(pd_steady_build(ctx, &m->flow, &steady, &m->steady));
    pd_status status = pdi_developed_flow_compute_profiles(ctx, &m->inlet, &m->flow);
    if (status < 0) m->error_line = u->side[m->inlet.error_side].line;
    PD_TRY(status);
    if (u->flow_time != PD_FLOW_STEADY) PD_TRY(pdi_flow_physics_build_unsteady(ctx, m));
    if (u->flow_time != PD_FLOW_PRESCRIBED) m->unknowns[PD_PART_FLOW] = (PD_DIM + 1) * m->grid.fluid_count;
    return PD_OK;
}

/* [byte] Memory of the implicit flow solver (steady or in time): Jacobian, multigrids, growth of the shared scratch.
 * Adds the coarse levels to the runtime bytes of b. */
static double pdi_flow_physics_estimate_solver(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    pd_steady steady;
    pd_implicit implicit;
    memset(&steady, 0, sizeof steady);
    memset(&implicit, 0, sizeof implicit);
    steady.flow = implicit.flow = &plan->flow;
    steady.solves_stages = setup->flow_time == PD_FLOW_IMPLICIT;
    pdi_steady_plan(&plan->ctx, &steady);
    double bytes = pdi_memory_plan_count_array_bytes(plan, pdi_steady_list, &steady);
    bytes += pdi_memory_plan_count_array_bytes(plan, pdi_jacobian_list, &steady.jacobian);
    pdi_memory_plan_add_shared_levels(plan,
                                      pdi_memory_plan_count_level_bytes(plan, &steady.mg_u) +
                                          (steady.solves_stages ? 3.0 : 2.0) *
                                              pdi_memory_plan_count_level_bytes(plan, &steady.mg_p),
                                      b);
    size_t room = pdi_steady_count_work_bytes(&steady);
    if (steady.solves_stages) {
        bytes += pdi_memory_plan_count_array_bytes(plan, pdi_implicit_list, &implicit);
        room += pdi_implicit_count_work_bytes(&implicit);
    }
    return bytes + pdi_memory_plan_add_scratch(plan, room);
}

/* Order of the flow discretisation for estimates: that of the setup; else 4 for steady planar flow with m <= 1, no
 * shapes, and sides that order 4 can treat; else 2. */
static int pdi_flow_physics_estimate_order(const pd_setup *setup, const pd_grid *grid)
{
    if (setup->flow_order) return setup->flow_order;
    if (setup->fluid_m > 1.0 || setup->axisymmetric || setup->shapes || setup->flow_time != PD_FLOW_STEADY) return 2;
    return pdi_fourth_order_has_closed_sides(grid->side) ? 4 : 2;
}

/* Add the memory of the incompressible flow, with its steady, implicit or explicit solver; a prescribed flow has none.
 * Sets order and boundary callbacks of plan->flow. */
static void pdi_flow_physics_estimate(const pd_setup *u, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_FLOW];
    pd_weakly_compressible unsteady;
    pd_fourth_order sharp;
    memset(&unsteady, 0, sizeof unsteady);
    unsteady.flow = &plan->flow;
    memset(&sharp, 0, sizeof sharp);
    sharp.bonds = plan->flow.bonds;
    plan->flow.order = pdi_flow_physics_estimate_order(u, &plan->grid);
    if (plan->flow.order == 4) *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_fourth_order_list, &sharp);
    if (pdi_wall_bc_has_motion(u)) plan->flow.wall = pdi_wall_bc_get_velocity;
    if (u->has_body_force_expr) plan->flow.body_force_fn = pdi_inlet_compute_body_force;
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_flow_list, &plan->flow);
    if (u->flow_time == PD_FLOW_STEADY || u->flow_time == PD_FLOW_IMPLICIT)
        *bytes += pdi_flow_physics_estimate_solver(u, plan, b);
    if (u->flow_time == PD_FLOW_EXPLICIT)
        *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_weakly_compressible_list, &unsteady);
}

/* Prints fluid, inlets, scales and Reynolds number. */
static void pdi_flow_physics_print_summary(const pdi_summary_text *s)
{
    const pd_model *m = s->model;
    char text[384], speed[PD_UNITS_TEXT], length[PD_UNITS_TEXT];
    pd_setup_format_value(m->flow.reference_speed, "m/s", speed);
    pd_setup_format_value(m->flow.reference_length, "m", length);
    char how[112];
    const char *order = m->flow.order == 4 ? ", order 4" : "";
    if (m->setup->flow_time == PD_FLOW_IMPLICIT)
        snprintf(how, sizeof how, "incompressible flow in time, implicit, step error %g%s", m->implicit.desc.rtol,
                 order);
    else if (m->setup->flow_time == PD_FLOW_EXPLICIT)
        snprintf(how, sizeof how, "weakly compressible flow in time, explicit, c0 = %g m/s", m->setup->sound_speed);
    else if (m->setup->flow_time == PD_FLOW_PRESCRIBED) snprintf(how, sizeof how, "given flow");
    else snprintf(how, sizeof how, "steady Navier-Stokes to residual %g%s", m->setup->steady_tolerance, order);
    snprintf(text, sizeof text, "%s, U = %s, L = %s, Re = %.4g", how, speed, length,
             m->flow.reference_speed * m->flow.reference_length / m->flow.nu);
    pdi_summary_text_print_part(s, PD_PART_FLOW, "flow", text);
}

static int pdi_flow_physics_is_present(const pd_setup *setup) { return setup->has_flow; }

/* What of the flow the setup leaves out, for summaries; NULL: nothing. */
static const char *pdi_flow_physics_absent(const pd_setup *setup)
{
    if (setup->has_flow) return setup->flow_time == PD_FLOW_STEADY ? "inertia of the flow in time" : NULL;
    return setup->has_gas ? "flow" : "flow, inertia of the flow in time";
}

/* Adds the process of the flow to the time loop; a prescribed flow has none. */
static pd_status pdi_flow_physics_add_processes(pd_ctx *ctx, pd_model *m)
{
    pd_time_loop *loop = &m->time_loop;
    switch (m->setup->flow_time) {
    case PD_FLOW_STEADY:
        return pd_time_loop_add_process(ctx, loop, pd_quasi_steady_process(&m->flow, &m->steady, &m->quasi));
    case PD_FLOW_IMPLICIT: return pd_time_loop_add_process(ctx, loop, pd_implicit_process(&m->implicit));
    case PD_FLOW_EXPLICIT: return pd_time_loop_add_process(ctx, loop, pd_weakly_compressible_process(&m->unsteady));
    case PD_FLOW_PRESCRIBED: break;
    }
    return PD_OK;
}

/* Frees what pdi_flow_physics_build made. */
static void pdi_flow_physics_free(pd_ctx *ctx, pd_model *m)
{
    pd_implicit_free(ctx, &m->implicit);
    pd_weakly_compressible_free(ctx, &m->unsteady);
    pd_steady_free(ctx, &m->steady);
    pd_flow_free(ctx, &m->flow);
}

static const double *pdi_flow_physics_velocity(const pd_model *m) { return m->flow.u; }

/* Sets solves, evaluations, Krylov iterations and residuals of the flow in the statistics of the run. A flow in time
 * counts a solve for each step of the run; Krylov iterations and residuals are those of steady flow, else 0. */
static void pdi_flow_physics_add_statistics(const pd_model *m, pd_model_statistics *e)
{
    int moves = m->setup->flow_time == PD_FLOW_IMPLICIT || m->setup->flow_time == PD_FLOW_EXPLICIT;
    e->flow_solves = moves ? m->time_loop.steps : m->quasi.solves;
    e->flow_evaluations = moves ? m->flow.evaluations : m->quasi.evaluations;
    e->flow_krylov = m->quasi.krylov;
    e->momentum = m->quasi.result.momentum;
    e->continuity = m->quasi.result.continuity;
}

/* Value of a field of the liquid at a fluid node: density [kg/m3], pressure [Pa] or speed [m/s]; 0 at other nodes. */
static double pdi_flow_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    if (m->grid.kind[i] != PD_FLUID) return 0.0;
    if (field == PD_FIELD_DENSITY) return m->flow.rho;
    return field == PD_FIELD_P ? m->flow.p[i] * m->flow.rho : pdi_model_compute_speed(m, m->flow.u, i);
}

/* Array [total] of a velocity component [m/s], or of pressure over density [m2/s2]; NULL for the density. */
static const double *pdi_flow_physics_get_values(const pd_model *m, pd_field field, int component)
{
    if (field == PD_FIELD_DENSITY) return NULL;
    return field == PD_FIELD_P ? m->flow.p : m->flow.u + (int64_t)component * m->grid.total;
}

PDI_FN void pdi_flow_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row = pdi_physics_row_add(list, "flow", PD_PART_FLOW, pdi_flow_physics_is_present);
    row->absent = pdi_flow_physics_absent;
    row->stage = PDI_PHYSICS_STAGE_MOTION;
    row->build = pdi_flow_physics_build;
    row->add_processes = pdi_flow_physics_add_processes;
    row->free = pdi_flow_physics_free;
    row->reads_bonds = pdi_physics_row_always;
    row->velocity = pdi_flow_physics_velocity;
    row->add_statistics = pdi_flow_physics_add_statistics;
    row->estimate = pdi_flow_physics_estimate;
    row->print_summary = pdi_flow_physics_print_summary;
    pdi_physics_row_add_fields(row, PD_FIELD_V, PD_FIELD_P, pdi_flow_physics_sample, pdi_flow_physics_get_values);
    pdi_physics_row_add_fields(row, PD_FIELD_DENSITY, PD_FIELD_DENSITY, pdi_flow_physics_sample,
                               pdi_flow_physics_get_values);
}
