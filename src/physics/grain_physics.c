/* grain_physics: see grain_physics.h */
#include "physics/grain_physics.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Set fraction [total], the share of grain boundary of nodes, and m->grain_stats. Where metal dissolves and gb_factor
 * is not 1, also allocate m->boundary_factor, 1 + (gb_factor - 1) * fraction. */
static pd_status pdi_grain_physics_build_boundary_factor(pd_ctx *ctx, pd_model *m, float *fraction)
{
    PD_TRY(pd_grain_fraction(ctx, &m->interface_stencil, &m->grid, &m->grain, fraction));
    PD_TRY(pdi_grain_measure(ctx, &m->grid, &m->grain, fraction, &m->grain_stats));
    if (!m->setup->has_dissolve || !(fabs(m->setup->gb_factor - 1.0) > 0.0)) return PD_OK;
    PD_TRY(PD_NEW(ctx, "model", m->grid.total, m->boundary_factor));
    double more = m->setup->gb_factor - 1.0;
    for (int32_t i = 0; i < m->grid.total; i++) m->boundary_factor[i] = 1.0 + more * (double)fraction[i];
    return PD_OK;
}

/* Grows and measures the grains of all solids, and sets the rate factor of their boundaries where metal dissolves by
 * another rate there. The boundary fractions are work and freed. */
static pd_status pdi_grain_physics_build(pd_ctx *ctx, pd_model *m)
{
    float *fraction = NULL;
    PD_TRY(pd_grain_build(ctx, &m->grid, &m->setup->grain, &m->grain));
    PD_TRY(PD_NEW(ctx, "model", m->grid.total, fraction));
    pd_status status = pdi_grain_physics_build_boundary_factor(ctx, m, fraction);
    PD_DELETE(ctx, m->grid.total, fraction);
    return status;
}

/* Prints number, size and boundaries of the grains. */
static void pdi_grain_physics_print_summary(const pdi_summary_text *s)
{
    const pd_model *m = s->model;
    char text[384], mean[PD_UNITS_TEXT], width[PD_UNITS_TEXT];
    pd_setup_format_value(m->grain_stats.mean, "m", mean);
    pd_setup_format_value(m->grain.boundary_width, "m", width);
    double share = m->grain_stats.boundary_fraction;
    snprintf(text, sizeof text,
             "%d in the solid, mean %s, boundaries %s wide: %.3g %% of the solid, mean rate factor %.5g",
             (int)m->grain_stats.count, mean, width, 100.0 * share, 1.0 + (m->setup->gb_factor - 1.0) * share);
    pdi_summary_text_print_part(s, PD_PART_GRAIN, "grains", text);
}

static int pdi_grain_physics_is_present(const pd_setup *setup) { return setup->has_grains; }

static void pdi_grain_physics_free(pd_ctx *ctx, pd_model *m)
{
    PD_DELETE(ctx, m->grid.total, m->boundary_factor);
    pd_grain_free(ctx, &m->grain);
}

/* Number of the grain of a solid node; -1 at other nodes. */
static double pdi_grain_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    (void)field;
    return m->grid.kind[i] == PD_SOLID ? m->grain.id[i] : -1.0;
}

/* Add the memory of the grains. */
static void pdi_grain_physics_estimate(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    (void)setup;
    (void)plan;
    b->bytes[PD_PART_GRAIN] = 12.0 * b->nodes; /* and shares, which do not stay: 4 */
}

PDI_FN void pdi_grain_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row = pdi_physics_row_add(list, "grains", PD_PART_GRAIN, pdi_grain_physics_is_present);
    row->build = pdi_grain_physics_build;
    row->free = pdi_grain_physics_free;
    row->estimate = pdi_grain_physics_estimate;
    row->print_summary = pdi_grain_physics_print_summary;
    pdi_physics_row_add_fields(row, PD_FIELD_GRAIN, PD_FIELD_GRAIN, pdi_grain_physics_sample, NULL);
}
