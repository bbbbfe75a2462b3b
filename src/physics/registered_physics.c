/* registered_physics: see registered_physics.h */
#include "physics/registered_physics.h"
#include "setup/fields.h"
#include <math.h>
#include <string.h>

static int pdi_registered_physics_is_present(const pd_setup *setup) { return setup->registered_count > 0; }

/* Value of a key at x [m] and t [s]; NaN: it is not given. A `value` callback of pd_physics_view. */
static double pdi_registered_physics_get_value(const pd_physics_view *view, int key, const double *x, double t)
{
    const pd_setup_registered *own = (const pd_setup_registered *)view->scene;
    return own->given >> key & 1u ? pdi_setup_eval_expr(&own->value[key], x, t) : (double)NAN;
}

/* 1: the side prescribes the first field, *value at x [m] and t [s]; 0: it does not, and *value stays. A `prescribed`
 * callback of pd_physics_view. */
static int pdi_registered_physics_get_prescribed(const pd_physics_view *view, int side, const double *x, double t,
                                                 double *value)
{
    const pd_setup_registered *own = (const pd_setup_registered *)view->scene;
    if (!(own->prescribed_sides >> side & 1u)) return 0;
    *value = pdi_setup_eval_expr(&own->prescribed[side], x, t);
    return 1;
}

/* Builds the physics of programs that the scene has, with a view of the model for each. PD_ERR_INTERNAL: a builder gave
 * no state. */
static pd_status pdi_registered_physics_build(pd_ctx *ctx, pd_model *m)
{
    for (int k = 0; k < m->setup->registered_count; k++) {
        const pd_setup_registered *own = &m->setup->registered[k];
        pd_physics_view *view = &m->registered[k].view;
        view->grid = &m->grid;
        view->bonds = &m->bonds;
        view->flow = m->flow.u ? &m->flow : NULL;
        view->scene = own;
        view->value = pdi_registered_physics_get_value;
        view->prescribed = pdi_registered_physics_get_prescribed;
        m->error_line = own->line;
        PD_TRY(own->type->build(ctx, view, &m->registered[k].state));
        if (!m->registered[k].state)
            return pd_fail(ctx, PD_ERR_INTERNAL, own->type->section.name, "its builder gave no state");
    }
    return PD_OK;
}

/* Adds the processes of these physics to the time loop. */
static pd_status pdi_registered_physics_add_processes(pd_ctx *ctx, pd_model *m)
{
    for (int k = 0; k < m->setup->registered_count; k++) {
        pd_physics process;
        memset(&process, 0, sizeof process);
        m->setup->registered[k].type->set_process(m->registered[k].state, &process);
        PD_TRY(pd_time_loop_add_process(ctx, &m->time_loop, process));
    }
    return PD_OK;
}

/* Frees the states of these physics, and clears their views. */
static void pdi_registered_physics_free(pd_ctx *ctx, pd_model *m)
{
    for (int k = m->setup->registered_count; k-- > 0;) {
        if (m->registered[k].state) m->setup->registered[k].type->free(ctx, m->registered[k].state);
        memset(&m->registered[k], 0, sizeof m->registered[k]);
    }
}

/* 1: the field is one of a physics of the program that the setup has. */
static int pdi_registered_physics_has_field(const pd_setup *setup, pd_field field)
{
    int index;
    return pd_fields_find_registered(setup, field, &index) >= 0;
}

/* Value at a node; 0 where the field has none: by its place, in fluid, in solid, in both, or at all nodes with the last
 * of pd_field_place. */
static double pdi_registered_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    int index, own = pd_fields_find_registered(m->setup, field, &index);
    const pd_physics_type *type = m->setup->registered[own].type;
    pd_field_place place = type->field[index].place;
    int kind = m->grid.kind[i];
    int stands = place == PD_FIELD_IN_ALL || (kind == PD_FLUID && place != PD_FIELD_IN_METAL) ||
                 (kind == PD_SOLID && place != PD_FIELD_IN_FLUID);
    return stands ? type->values(m->registered[own].state, index)[i] : 0.0;
}

/* Add the memory that each of these physics asks for, to that of the grid. */
static void pdi_registered_physics_estimate(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    (void)plan;
    for (int k = 0; k < setup->registered_count; k++)
        b->bytes[PD_PART_GRID] += setup->registered[k].type->bytes_per_node * b->nodes;
}

/* Prints section and meaning of each of these physics. */
static void pdi_registered_physics_print_summary(const pdi_summary_text *s)
{
    const pd_setup *u = s->model->setup;
    for (int k = 0; k < u->registered_count; k++)
        pdi_summary_text_print_line(s, "  %-12s%s", u->registered[k].type->section.name,
                                    u->registered[k].type->section.meaning);
}

PDI_FN void pdi_registered_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row = pdi_physics_row_add(list, NULL, PD_PART_GRID, pdi_registered_physics_is_present);
    row->stage = PDI_PHYSICS_STAGE_MOTION;
    row->build = pdi_registered_physics_build;
    row->add_processes = pdi_registered_physics_add_processes;
    row->free = pdi_registered_physics_free;
    row->reads_bonds = pdi_physics_row_always;
    row->estimate = pdi_registered_physics_estimate;
    row->print_summary = pdi_registered_physics_print_summary;
    pdi_physics_row_add_fields(row, PD_FIELD_SPECIES, PD_FIELD_COUNT, pdi_registered_physics_sample, NULL);
    row->sampler[0].has = pdi_registered_physics_has_field;
}
