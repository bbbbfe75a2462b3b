/* gas_physics: see gas_physics.h */
#include "physics/gas_physics.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Density rho [kg/m3], velocity v [PD_DIM] [m/s] and pressure p [Pa] of the gas at x [m], at the start and behind
 * inlets. user: the pd_setup. */
static void pdi_gas_physics_get_initial_state(void *user, const double *x, double *rho, double *v, double *p)
{
    const pd_setup *u = (const pd_setup *)user;
    *rho = pdi_setup_eval_expr(&u->gas_rho, x, 0.0);
    *p = pdi_setup_eval_expr(&u->gas_p, x, 0.0);
    for (int d = 0; d < PD_DIM; d++) v[d] = pdi_setup_eval_expr(&u->initial_velocity[d], x, 0.0);
}

/* Builds the gas from the state at the start and the sides, and checks that state by asking for its stable step.
 * Errors: PD_ERR_ARGUMENT of pd_gas_build; PD_ERR_STATE: that state is not admissible. */
static pd_status pdi_gas_physics_build(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_gas_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.gamma = u->gas_gamma;
    desc.spatial_order = u->gas_order;
    desc.cfl = u->gas_cfl;
    desc.initial = pdi_gas_physics_get_initial_state;
    desc.initial_user = (void *)u; /* only read */
    m->unknowns[PD_PART_GAS] = PD_GAS_FIELDS * m->grid.fluid_count;
    PD_TRY(pd_gas_build(ctx, &m->grid, &m->bonds, &desc, &m->gas));
    double limit;
    return pd_gas_limit(ctx, &m->gas, &limit); /* the state at the start shows */
}

/* Add the memory of the gas. */
static void pdi_gas_physics_estimate(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    pd_gas gas;
    memset(&gas, 0, sizeof gas);
    gas.grid = &plan->grid;
    gas.rows = (int32_t)(b->truncated / plan->node_scale);
    gas.desc.spatial_order = setup->gas_order;
    b->bytes[PD_PART_GAS] = pdi_memory_plan_count_array_bytes(plan, pdi_gas_list, &gas);
}

/* Prints gamma, order and end of the gas. */
static void pdi_gas_physics_print_summary(const pdi_summary_text *s)
{
    const pd_setup *u = s->model->setup;
    char text[192], until[PD_UNITS_TEXT];
    pd_setup_format_value(u->end_time, "s", until);
    snprintf(text, sizeof text, "ideal gas with gamma = %g, %s order, explicit, until %s", u->gas_gamma,
             u->gas_order == PD_GAS_SECOND ? "second" : "first", until);
    pdi_summary_text_print_part(s, PD_PART_GAS, "gas", text);
}

static int pdi_gas_physics_is_present(const pd_setup *setup) { return setup->has_gas; }

static pd_status pdi_gas_physics_add_processes(pd_ctx *ctx, pd_model *m)
{
    return pd_time_loop_add_process(ctx, &m->time_loop, pd_gas_process(&m->gas));
}

static void pdi_gas_physics_free(pd_ctx *ctx, pd_model *m) { pd_gas_free(ctx, &m->gas); }

/* [PD_DIM][total] [m/s] Velocity of the gas. */
static const double *pdi_gas_physics_velocity(const pd_model *m) { return m->gas.primitive + m->grid.total; }

/* Array [total] of a gas field: density [kg/m3], pressure [Pa], total energy per volume [J/m3], or for any other field
 * that component of the velocity [m/s]. */
static const double *pdi_gas_physics_get_values(const pd_model *m, pd_field field, int component)
{
    int64_t last = (int64_t)(PD_GAS_FIELDS - 1) * m->grid.total;
    if (field == PD_FIELD_DENSITY) return m->gas.primitive;
    if (field == PD_FIELD_P) return m->gas.primitive + last;
    if (field == PD_FIELD_ENERGY) return m->gas.state + last;
    return m->gas.primitive + (int64_t)(1 + component) * m->grid.total;
}

/* Value of a gas field at a fluid node, of the velocity its norm; 0 at other nodes. */
static double pdi_gas_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    if (m->grid.kind[i] != PD_FLUID) return 0.0;
    return field == PD_FIELD_V ? pdi_model_compute_speed(m, pdi_gas_physics_velocity(m), i)
                               : pdi_gas_physics_get_values(m, field, 0)[i];
}

PDI_FN void pdi_gas_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row = pdi_physics_row_add(list, "gas", PD_PART_GAS, pdi_gas_physics_is_present);
    row->stage = PDI_PHYSICS_STAGE_MOTION;
    row->build = pdi_gas_physics_build;
    row->add_processes = pdi_gas_physics_add_processes;
    row->free = pdi_gas_physics_free;
    row->velocity = pdi_gas_physics_velocity;
    row->estimate = pdi_gas_physics_estimate;
    row->print_summary = pdi_gas_physics_print_summary;
    pdi_physics_row_add_fields(row, PD_FIELD_V, PD_FIELD_P, pdi_gas_physics_sample, pdi_gas_physics_get_values);
    pdi_physics_row_add_fields(row, PD_FIELD_DENSITY, PD_FIELD_DENSITY, pdi_gas_physics_sample,
                               pdi_gas_physics_get_values);
    pdi_physics_row_add_fields(row, PD_FIELD_ENERGY, PD_FIELD_ENERGY, pdi_gas_physics_sample,
                               pdi_gas_physics_get_values);
}
