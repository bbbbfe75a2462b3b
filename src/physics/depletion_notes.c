/* depletion_notes: see depletion_notes.h */
#include "physics/depletion_notes.h"
#include <stdio.h>
#include <string.h>

/* A node that belongs to no shape. */
#define PDI_DEPLETION_NOTES_NO_SHAPE 255

/* Index in solid_shape of the last metal shape that x [m] lies in; PDI_DEPLETION_NOTES_NO_SHAPE: none. */
static uint8_t pdi_depletion_notes_find_shape(const pd_setup *setup, const double *x)
{
    for (int k = setup->solid_shapes; k-- > 0;)
        if (pdi_shape_contains(setup->shape, setup->solid_shape[k].shape, setup->h, x)) return (uint8_t)k;
    return PDI_DEPLETION_NOTES_NO_SHAPE;
}

/* Count the solid nodes that are left of each shape, into all of left [solid_shapes]; nodes of no shape do not
 * count. */
static void pdi_depletion_notes_count_nodes(const pd_depletion_notes *d, int32_t *left)
{
    const pd_grid *grid = &d->model->grid;
    for (int k = 0; k < d->model->setup->solid_shapes; k++) left[k] = 0;
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_SOLID && d->shape_of_node[i] != PDI_DEPLETION_NOTES_NO_SHAPE)
            left[d->shape_of_node[i]]++;
}

/* 1: fluid touches the electrode, and its circuit carries no current, as no curve or law can close it. 0: all others,
 * those without fluid beside them, too. */
static int pdi_depletion_notes_is_electrode_idle(const pd_model *m, int electrode)
{
    pd_cell_electrode now;
    if (!m->setup->has_potential || !(m->cell.potential.contacts.idle || m->dissolution_laws.surface_solver.idle))
        return 0;
    if (m->dissolution_laws.species_electrodes.setup)
        pd_species_electrodes_get_electrode(&m->dissolution_laws.species_electrodes, electrode, &now);
    else pd_cell_electrode_of(&m->cell, electrode, &now);
    return now.touches == PD_CELL_IDLE;
}

pd_status pd_depletion_notes_build(pd_ctx *ctx, pd_model *model, pd_depletion_notes *d)
{
    double x[PD_DIM];
    memset(d, 0, sizeof *d);
    if (!model->setup->has_dissolve) return PD_OK;
    PD_TRY(PD_NEW(ctx, "depletion", model->grid.total, d->shape_of_node));
    d->model = model;
    d->solid_nodes = model->grid.solid_count;
    for (int32_t i = 0; i < model->grid.total; i++) {
        d->shape_of_node[i] = PDI_DEPLETION_NOTES_NO_SHAPE;
        if (model->grid.kind[i] != PD_SOLID || pd_grid_find_source(&model->grid, i, NULL) != i) continue;
        pd_grid_position(&model->grid, i, x);
        d->shape_of_node[i] = pdi_depletion_notes_find_shape(model->setup, x);
    }
    pdi_depletion_notes_count_nodes(d, d->nodes_left);
    return PD_OK;
}

/* Write a time [s] such as "13.2 day" into text [PD_UNITS_TEXT]; returns text. */
static const char *pdi_depletion_notes_format_time(double time, char *text)
{
    pd_setup_format_value(time, "s", text);
    return text;
}

/* Update nodes_left, and print a note for each shape that had solid nodes at the last update and has none now. print:
 * NULL: no notes. */
static void pdi_depletion_notes_print_consumed_shapes(pd_depletion_notes *d, pd_print_fn print, void *user)
{
    const pd_setup *u = d->model->setup;
    int32_t left[PD_SETUP_SHAPES];
    char text[256], time[PD_UNITS_TEXT];
    pdi_depletion_notes_count_nodes(d, left);
    for (int k = 0; k < u->solid_shapes; k++) {
        if (print && d->nodes_left[k] && !left[k]) {
            snprintf(text, sizeof text, "the metal of shape %s (%s) is used up at t = %s", u->solid_shape[k].name,
                     u->metal[u->solid_shape[k].metal].material.name,
                     pdi_depletion_notes_format_time(d->model->time_loop.time, time));
            print(user, PD_PRINT_NOTE, text);
        }
        d->nodes_left[k] = left[k];
    }
}

/* Update `idle`, and print a note for each electrode that carries no current now and did at the last update. print:
 * NULL: no notes. Without a potential solver does nothing. */
static void pdi_depletion_notes_print_idle_electrodes(pd_depletion_notes *d, pd_print_fn print, void *user)
{
    const pd_setup_potential *p = &d->model->setup->potential;
    char text[320], time[PD_UNITS_TEXT];
    /* among ions it is known with the step after */
    double from = d->model->dissolution_laws.species_electrodes.setup ? d->time : d->model->time_loop.time;
    for (int e = 0; e < p->electrodes && d->model->setup->has_potential; e++) {
        int idle = pdi_depletion_notes_is_electrode_idle(d->model, e);
        if (print && idle && !d->idle[e]) {
            snprintf(text, sizeof text,
                     "electrode %s carries no current from t = %s on: curves of metal around its "
                     "fluid carry current one way only, and nothing else closes the circuit. Its potential is not "
                     "known",
                     p->electrode[e].name, pdi_depletion_notes_format_time(from, time));
            print(user, PD_PRINT_NOTE, text);
        }
        d->idle[e] = idle;
    }
}

void pd_depletion_notes_update(pd_depletion_notes *d, pd_print_fn print, void *user)
{
    if (!d->model) return;
    if (d->solid_nodes != d->model->grid.solid_count) pdi_depletion_notes_print_consumed_shapes(d, print, user);
    d->solid_nodes = d->model->grid.solid_count;
    pdi_depletion_notes_print_idle_electrodes(d, print, user);
    d->time = d->model->time_loop.time;
}

void pd_depletion_notes_free(pd_ctx *ctx, pd_depletion_notes *d)
{
    if (d->model) PD_DELETE(ctx, d->model->grid.total, d->shape_of_node);
    memset(d, 0, sizeof *d);
}

#undef PDI_DEPLETION_NOTES_NO_SHAPE
