/* monitor_report: see monitor_report.h */
#include "run/result_line.h"
#include "run/monitor_report.h"
#include "physics/step_diagnostics.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Least cells across a diffusion layer for a flux that is right to a few per cent. */
#define PDI_MONITOR_REPORT_MIN_LAYER_CELLS 2.0
/* Cell Peclet number v h/D at which the numerical diffusion v h/2 of upwinding equals D. */
#define PDI_MONITOR_REPORT_MAX_PECLET 2.0
/* [mol/L] Largest ionic strength for which Davies' equation holds (theory: 7.3). */
#define PDI_MONITOR_REPORT_MAX_IONIC_STRENGTH 0.5

/* Relative difference of lost metal from Faraday's law above which a note is printed. */
#define PDI_MONITOR_REPORT_FARADAY_TOLERANCE 0.01

/* Relative error of a charge by current changes within steps above which a note is printed. */
#define PDI_MONITOR_REPORT_CHARGE_TOLERANCE 0.05

/* Errors of a charge below this fraction of the charge passed both ways are rounding. */
#define PDI_MONITOR_REPORT_CHARGE_ROUNDING 1e-9

/* Print a note if the output "faraday" of a monitor, lost metal over that of its anodic charge by Faraday's law,
 * differs from 1 by more than 1 %. NaN, or no such output: no note. */
static void pdi_monitor_report_print_faraday_mismatch(const pd_monitor *m, pd_print_fn print, void *user)
{
    char text[256];
    for (int f = 0; f < m->count; f++) {
        double share = m->output[f].value;
        if (strcmp(m->output[f].key, "faraday") || !(fabs(share - 1.0) > PDI_MONITOR_REPORT_FARADAY_TOLERANCE))
            continue;
        snprintf(text, sizeof text, "electrode %s: its metal has lost %.4g of what its anodic charge dissolves by "
                 "Faraday's law: %s", m->desc->name, share,
                 share < 1.0 ? "it was used up, or covered, or the fluid at it was saturated, while current passed"
                             : "factors make it dissolve faster than its current does");
        print(user, PD_PRINT_NOTE, text);
    }
}

/* Print a note if the estimated error of the charge, from current changes within steps, exceeds 5 % of |charge| plus
 * 1e-9 of the charge that has passed in both directions. */
static void pdi_monitor_report_print_charge_error(const pd_monitor *m, const pd_cell_electrode *e, pd_print_fn print,
                                                  void *user)
{
    char text[256];
    double sizes = 2.0 * e->passed - e->charge; /* of what has passed either way */
    if (!(e->charge_error >
          PDI_MONITOR_REPORT_CHARGE_TOLERANCE * fabs(e->charge) + PDI_MONITOR_REPORT_CHARGE_ROUNDING * sizes))
        return;
    snprintf(text, sizeof text, "electrode %s: its current changed within steps: its charge, %.4g C, may be off by "
             "%.2g C; expected a smaller max_step", m->desc->name, e->charge, e->charge_error);
    print(user, PD_PRINT_NOTE, text);
}

/* Print a note if a tabulated polarisation curve was asked for below or above the points of a measured table in it,
 * where its end values hold. Nothing for a curve that is no table, or was not asked for yet. */
static void pdi_monitor_report_print_table_range(const pd_model *model, const pd_monitor *m, const pd_cell_electrode *e,
                                                 pd_print_fn print, void *user)
{
    char text[320];
    const double *range = model->setup->potential.electrode[m->desc->index].table_range;
    if (!pd_cell_table(&model->cell, m->desc->index) || !(e->met.least <= e->met.most)) return;
    if (e->met.least >= range[0] && e->met.most <= range[1]) return;
    snprintf(text, sizeof text, "electrode %s: its curve was asked for from %.6g to %.6g V, and a table in it has "
             "points from %.6g to %.6g V: it holds its ends beyond them", m->desc->name, e->met.least, e->met.most,
             range[0], range[1]);
    print(user, PD_PRINT_NOTE, text);
}

/* Print a note if a tabulated polarisation curve was asked for outside of its own range, where it is extrapolated
 * linearly. Nothing for a curve that is no table. */
static void pdi_monitor_report_print_curve_range(const pd_model *model, const pd_monitor *m, const pd_cell_electrode *e,
                                                 pd_print_fn print, void *user)
{
    char text[320];
    const pd_electrode_term *table = pd_cell_table(&model->cell, m->desc->index);
    if (!table || !(e->met.left < HUGE_VAL)) return;
    snprintf(text, sizeof text, "electrode %s: its curve was asked for from %.6g to %.6g V, first outside of its range "
             "%.6g .. %.6g V at t = %.6g s: beyond it the curve is a straight line, and currents are not those of `i`; "
             "a wider range holds them", m->desc->name, e->met.least, e->met.most, table->potential[0],
             table->potential[table->points - 1], e->met.left);
    print(user, PD_PRINT_NOTE, text);
}

/* Print the notes of one monitor: those of an electrode, and, if it has an output "layer", one where |layer| is below 2
 * h, with h the smallest spacing of the lattice. */
static void pdi_monitor_report_print_warnings(const pd_model *model, const pd_monitor *m, pd_print_fn print, void *user)
{
    char text[256];
    if (m->desc->kind == PD_MONITOR_ELECTRODE) {
        pd_cell_electrode e;
        pdi_monitor_outputs_get_electrode(model, m->desc->index, &e);
        pdi_monitor_report_print_faraday_mismatch(m, print, user);
        pdi_monitor_report_print_table_range(model, m, &e, print, user);
        pdi_monitor_report_print_curve_range(model, m, &e, print, user);
        pdi_monitor_report_print_charge_error(m, &e, print, user);
    }
    double h = model->grid.h[0], layer = HUGE_VAL;
    for (int d = 1; d < PD_DIM; d++) h = pd_min(h, model->grid.h[d]);
    for (int f = 0; f < m->count; f++)
        if (!strcmp(m->output[f].key, "layer")) layer = fabs(m->output[f].value);
    if (!(layer < PDI_MONITOR_REPORT_MIN_LAYER_CELLS * h)) return;
    snprintf(text, sizeof text,
             "%s %s: the layer at its surface is %.3g m thick, and cells are %.3g m: its flux wants "
             "at least %g cells across",
             pd_setup_monitor_section_name(m->desc->kind), m->desc->name, layer, h,
             PDI_MONITOR_REPORT_MIN_LAYER_CELLS);
    print(user, PD_PRINT_NOTE, text);
}

/* Print a note if the largest cell Peclet number v h/D of a species is above 2: upwinding then spreads it more than D.
 * Nothing without a flow with species. */
static void pdi_monitor_report_print_numerical_diffusion(const pd_model *model, pd_print_fn print, void *user)
{
    const char *slowest;
    char text[320];
    double peclet = pd_step_diagnostics_compute_peclet(model, &slowest);
    if (!(peclet > PDI_MONITOR_REPORT_MAX_PECLET)) return;
    snprintf(text, sizeof text,
             "species: the cell Peclet number v h/D is up to %.3g (%s): upwinding spreads them more "
             "than they diffuse, and what reaches a surface along the flow can be tens of per cent too high; it wants "
             "at most %g",
             peclet, slowest, PDI_MONITOR_REPORT_MAX_PECLET);
    print(user, PD_PRINT_NOTE, text);
}

/* Print a note if the largest ionic strength of a fluid node exceeds 0.5 mol/L, to which Davies' equation holds.
 * Nothing without chemistry or with ideal activities. */
static void pdi_monitor_report_print_ionic_strength(const pd_model *model, pd_print_fn print, void *user)
{
    const pd_reactive *r = &model->reactive;
    const pd_components *s = &r->components;
    double most = 0.0;
    char text[320];
    if (!model->setup->has_chemistry || !(s->debye_hueckel > 0.0)) return;
    for (int32_t i = 0; i < model->grid.total; i++) {
        double c[PD_SPECIES_MAX];
        if (model->grid.kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        most = pd_max(most, 1e-3 * pd_components_compute_ionic_strength(s, c));
    }
    if (!(most > PDI_MONITOR_REPORT_MAX_IONIC_STRENGTH)) return;
    snprintf(text, sizeof text,
             "chemistry: the ionic strength is up to %.3g mol/L: Davies' equation holds to %g, and "
             "pH, equilibria and rates that read activities are extrapolated",
             most, PDI_MONITOR_REPORT_MAX_IONIC_STRENGTH);
    print(user, PD_PRINT_NOTE, text);
}

PDI_FN void pdi_monitor_report_print(const pd_monitors *all, pd_print_fn print, void *user)
{
    char text[1024];
    if (!print) return;
    pdi_monitor_report_print_numerical_diffusion(all->model, print, user);
    pdi_monitor_report_print_ionic_strength(all->model, print, user);
    for (int k = 0; k < all->model->setup->monitors; k++) {
        const pd_monitor *m = &all->monitor[k];
        if (m->count == 0) continue;
        snprintf(text, sizeof text, "result case=%s %s=%s time=%.9g", all->model->setup->name,
                 pd_setup_monitor_section_name(m->desc->kind), m->desc->name, all->model->time_loop.time);
        char *figures = text + strlen(text);
        for (int f = 0; f < m->count; f++) {
            size_t used = strlen(text);
            if (isnan(m->output[f].value)) continue; /* a figure without a value has no key */
            snprintf(text + used, sizeof text - used, " %s=%.9g", m->output[f].key, m->output[f].value);
        }
        pdi_result_line_remove_nonfinite(figures);
        print(user, PD_PRINT_RESULT, text);
        pdi_monitor_report_print_warnings(all->model, m, print, user);
    }
}

#undef PDI_MONITOR_REPORT_CHARGE_TOLERANCE
#undef PDI_MONITOR_REPORT_MIN_LAYER_CELLS
#undef PDI_MONITOR_REPORT_MAX_PECLET
#undef PDI_MONITOR_REPORT_MAX_IONIC_STRENGTH
#undef PDI_MONITOR_REPORT_FARADAY_TOLERANCE
#undef PDI_MONITOR_REPORT_CHARGE_ROUNDING
