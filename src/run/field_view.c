/* field_view: see field_view.h */
#include "run/field_view.h"
#include "setup/fields.h"
#include "physics/sample.h"
#include <string.h>

/* Copy a field over the cells of the box into out[components][cells], x fastest, without ghosts; a velocity is 0
 * outside the fluid. */
static void pdi_field_view_copy_values(const pd_model *m, pd_field field, int64_t cells, double *out)
{
    const pd_grid *g = &m->grid;
    const double *v = field == PD_FIELD_V ? pd_model_velocity(m) : NULL;
    int at[PD_DIM];
    memset(at, 0, sizeof at);
    for (int64_t cell = 0; cell < cells; cell++) {
        int32_t i = pd_grid_node(g, at);
        if (!v) out[cell] = pd_sample_get_node(m, field, i);
        for (int d = 0; d < PD_DIM && v; d++)
            out[d * cells + cell] = g->kind[i] == PD_FLUID ? v[(int64_t)d * g->total + i] : 0.0;
        for (int d = 0; d < PD_DIM && ++at[d] == g->n[d]; d++) at[d] = 0;
    }
}

PDI_FN pd_status pdi_field_view_get(pd_ctx *ctx, pd_model *model, pd_field_views *views, const char *name,
                                    pd_field_view *view)
{
    const pd_grid *g = &model->grid;
    int field = pd_fields_find(model->setup, name);
    memset(view, 0, sizeof *view);
    char names[PD_FIELDS_NAMES_SIZE];
    if (field == PD_FIELD_COUNT)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "view", "no field has the name %.40s, expected one of %s", name,
                       pd_fields_format_names(model->setup, names));
    const char *needs = pd_fields_lacks(model->setup, (pd_field)field);
    if (needs) return pd_fail(ctx, PD_ERR_ARGUMENT, "view", "the field %s needs %s", name, needs);
    views->cells = 1;
    for (int d = 0; d < PD_DIM; d++) views->cells *= g->n[d];
    if (!views->field[field])
        PD_TRY(PD_NEW(ctx, "view", pd_fields_count_components((pd_field)field) * views->cells, views->field[field]));
    pd_sample_prepare(ctx, model, pd_fields_bit(field));
    pdi_field_view_copy_values(model, (pd_field)field, views->cells, views->field[field]);
    view->data = views->field[field];
    view->label = pd_fields_get_label(model->setup, (pd_field)field);
    view->components = pd_fields_count_components((pd_field)field);
    view->component_stride = views->cells;
    for (int d = 0; d < PD_DIM; d++) {
        view->n[d] = g->n[d];
        view->stride[d] = d ? view->stride[d - 1] * view->n[d - 1] : 1;
    }
    return PD_OK;
}

PDI_FN void pdi_field_view_free(pd_ctx *ctx, pd_field_views *views)
{
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        PD_DELETE(ctx, pd_fields_count_components((pd_field)k) * views->cells, views->field[k]);
    memset(views, 0, sizeof *views);
}
