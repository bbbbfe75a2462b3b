/* summary: see summary.h */
#include "physics/summary.h"
#include "core/vec.h"
#include "physics/memory_estimate.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Prints name, dimension, nodes along each axis, spacing (of each axis if they differ), horizon and bonds, those of the
 * metal if they differ, and counts of fluid, solid and wall nodes. */
static void pdi_summary_print_grid(const pdi_summary_text *s)
{
    const pd_model *m = s->model;
    char size[96] = "", spacing[3 * PD_UNITS_TEXT] = "", text[PD_UNITS_TEXT], metal[64] = "";
    int axes = 1;
    for (int d = 1; d < PD_DIM; d++)
        if (fabs(m->grid.h[d] - m->grid.h[0]) > 1e-12 * m->grid.h[0]) axes = PD_DIM;
    for (int d = 0; d < PD_DIM; d++) {
        size_t used = strlen(size), length = strlen(spacing);
        snprintf(size + used, sizeof size - used, "%s%d", d ? " x " : "", m->grid.n[d]);
        if (d >= axes) continue;
        pd_setup_format_value(m->grid.h[d], "m", text);
        snprintf(spacing + length, sizeof spacing - length, "%s%s", d ? " x " : "", text);
    }
    if (m->setup->has_dissolve && m->interface_stencil.count != m->stencil.count)
        snprintf(metal, sizeof metal, "; metal m = %g (%d bonds)", m->interface_stencil.m, m->interface_stencil.count);
    pdi_summary_text_print_line(s, "%s: %dD%s, %s nodes at %s, m = %g (%d bonds a node)%s", m->setup->name, PD_DIM,
                                m->setup->axisymmetric ? " axisymmetric" : "", size, spacing, m->stencil.m,
                                m->stencil.count, metal);
    snprintf(size, sizeof size, "%.0f fluid, %.0f solid, %.0f wall", (double)m->grid.fluid_count,
             (double)m->grid.solid_count, (double)(pdi_grid_count_kind(&m->grid, PD_WALL)));
    pdi_summary_text_print_part(s, PD_PART_GRID, "lattice", size);
}

/* Print the list of monitors, as "plane up, plane down, force pin"; nothing without monitors. */
static void pdi_summary_print_monitors(const pdi_summary_text *s)
{
    const pd_setup *u = s->model->setup;
    char text[384] = "";
    for (int k = 0; k < u->monitors; k++) {
        size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s%s %s", k ? ", " : "",
                 pd_setup_monitor_section_name(u->monitor[k].kind), u->monitor[k].name);
    }
    if (u->monitors) pdi_summary_text_print_line(s, "  %-12s%s", "watched", text);
}

/* Print the physics that is not modelled, by `absent` of each row, else the name of rows that are not present; nothing
 * if there is none. */
static void pdi_summary_print_absent(const pdi_summary_text *s)
{
    const pd_setup *u = s->model->setup;
    char text[256] = "  not modelled: ";
    pdi_physics_list all;
    int absent = 0;
    pdi_physics_list_init(&all);
    for (int k = 0; k < all.count; k++) {
        const pdi_physics_row *row = &all.row[k];
        const char *what = row->absent ? row->absent(u) : row->is_present(u) ? NULL : row->name;
        if (what) pd_append(text, sizeof text, "%s%s", absent++ ? ", " : "", what);
    }
    if (absent) pdi_summary_text_print_line(s, "%s", text);
}

void pd_summary_print(const pd_model *model, pd_print_fn print, void *user)
{
    pdi_summary_text s;
    pd_memory_estimate footprint;
    size_t bytes = 0;
    if (!print) return;
    s.model = model;
    s.print = print;
    s.user = user;
    pdi_summary_print_grid(&s);
    for (int k = 0; k < model->physics->count; k++) {
        const pdi_physics_row *row = &model->physics->row[k];
        if (row->print_summary) row->print_summary(&s);
    }
    pdi_summary_print_monitors(&s);
    pdi_summary_print_absent(&s);
    for (int k = 0; k < PD_PART_COUNT; k++) bytes += model->bytes[k];
    pd_memory_estimate_compute(model->setup, &footprint);
    pdi_summary_text_print_line(
        &s, "  %-12s%.3g MB, %.0f bytes a node; about %.3g MB with files and pictures", "in all", (double)bytes * 1e-6,
        (double)bytes / (double)(model->grid.fluid_count + model->grid.solid_count), footprint.total_bytes * 1e-6);
    for (int k = 0; k < model->setup->notes; k++) print(user, PD_PRINT_NOTE, model->setup->note[k]);
    for (int k = 0; k < model->physics->count; k++) {
        const pdi_physics_row *row = &model->physics->row[k];
        if (row->print_notes) row->print_notes(&s);
    }
}
