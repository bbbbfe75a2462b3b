/* surface_view: see surface_view.h */
#include "run/surface_view.h"
#include "setup/fields.h"
#include "io/field_plot.h"
#include "physics/sample.h"
#include <math.h>
#include <string.h>

PDI_FN int pdi_surface_view_is_requested(const pd_setup *u) { return PD_DIM == 3 && u->drawing.surface; }

PDI_FN pd_field pdi_surface_view_get_colour_field(const pd_setup *setup)
{
    return setup->drawing.surface > 1 ? (pd_field)(setup->drawing.surface - 2) : PD_FIELD_COUNT;
}

PDI_FN pd_status pdi_surface_view_build(pd_ctx *ctx, const pd_setup *u, pd_rendering *shade)
{
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0};
    for (int d = 0; d < PD_DIM; d++) {
        lo[d] = u->lo[d];
        hi[d] = u->hi[d];
    }
    return pdi_renderer_build(ctx, lo, hi, u->drawing.view_direction,
                              u->drawing.width ? u->drawing.width : PD_FIELD_PLOT_WIDTH, shade);
}

/* Fraction [-] of the metal of cell i that is left, content over that of its intact metal, for the position of the
 * surface: 0 outside the metal, at least 1e-9 in it, 1 where nothing dissolves. */
static double pdi_surface_view_get_metal_fraction(const void *user, const int *i)
{
    const pd_model *m = (const pd_model *)user;
    int32_t node = pd_grid_node(&m->grid, i);
    if (m->grid.kind[node] != PD_SOLID) return 0.0;
    if (!m->setup->has_dissolve) return 1.0;
    return pd_max(1e-9, m->transport.c[node] / m->setup->metal[m->metal ? m->metal[node] : 0].solid_c);
}

/* Value of the colour field at a surface face: of the metal cell `in` for a field with values in the metal, else of the
 * fluid cell `out` beside it; NaN where that is outside the box or no fluid. */
static double pdi_surface_view_get_colour_value(const void *user, const int *in, const int *out)
{
    const pd_model *m = (const pd_model *)user;
    pd_field field = pdi_surface_view_get_colour_field(m->setup);
    int metal = pd_fields_is_in_metal(m->setup, field);
    if (!metal && !pd_grid_is_inside(&m->grid, out)) return (double)NAN;
    int32_t node = pd_grid_node(&m->grid, metal ? in : out);
    if (!metal && m->grid.kind[node] != PD_FLUID) return (double)NAN;
    return pd_sample_get_node(m, field, node);
}

PDI_FN pd_status pdi_surface_view_draw(pd_ctx *ctx, const pd_model *m, pd_rendering *shade)
{
    pdi_surface_nets_desc desc;
    pdi_surface_nets_mesh shell;
    pd_field field = pdi_surface_view_get_colour_field(m->setup);
    memset(&desc, 0, sizeof desc);
    for (int d = 0; d < PD_DIM; d++) {
        desc.n[d] = m->grid.n[d];
        desc.lo[d] = m->grid.lo[d];
        desc.h[d] = m->grid.h[d];
    }
    desc.fraction = pdi_surface_view_get_metal_fraction;
    desc.value = field < PD_FIELD_COUNT ? pdi_surface_view_get_colour_value : NULL;
    desc.user = m;
    PD_TRY(pdi_surface_nets_build(ctx, &desc, &shell));
    pd_status status = pdi_renderer_draw_surface(
        ctx, &shell, field < PD_FIELD_COUNT && pd_fields_get_scale(field) == PD_FIELD_SCALE_CATEGORY, shade);
    pdi_surface_nets_free(ctx, &shell);
    return status;
}
