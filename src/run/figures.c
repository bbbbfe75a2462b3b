/* figures: see figures.h */
#include "run/figures.h"
#include "run/sample.h"
#include <stdio.h>
#include <string.h>

static pd_status pdi_figures_add(pd_ctx *ctx, pd_figures *f, const char *section, const char *name, int monitor,
                                 const char *key, const char *unit, double value)
{
    if (f->count == f->room) {
        int fresh = 2 * f->room + 32;
        PDI_TRY(PDI_GROW(ctx, "figures", f->room, fresh, f->list));
        f->room = fresh;
    }
    pd_figure *g = &f->list[f->count++];
    snprintf(g->section, sizeof g->section, "%s", section);
    snprintf(g->name, sizeof g->name, "%s", name);
    snprintf(g->key, sizeof g->key, "%s", key);
    snprintf(g->unit, sizeof g->unit, "%s", unit);
    g->monitor = monitor;
    g->value = value;
    return PD_OK;
}

static pd_status pdi_figures_probe(pd_ctx *ctx, const pd_model *model, const pd_setup_probe *p, pd_figures *f)
{
    static const pd_field fields[] = {PD_FIELD_V, PD_FIELD_P, PD_FIELD_C};
    static const char *const units[] = {"m/s", "Pa", "mol/m3"};
    char key[24];
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < (fields[k] == PD_FIELD_V ? PD_DIM : 1) && ((p->fields >> fields[k]) & 1u); d++) {
            snprintf(key, sizeof key, fields[k] == PD_FIELD_V ? "%.8s%c" : "%.8s", pdi_setup_field_name(fields[k]),
                     "xyz"[d]);
            PDI_TRY(pdi_figures_add(ctx, f, "probe", p->name, -1, key, units[k],
                                    pdi_sample_point(model, fields[k], d, p->at)));
        }
    return PD_OK;
}

PDI_FN pd_status pdi_figures_collect(pd_ctx *ctx, pd_model *model, const pd_monitors *monitors, pd_figures *f)
{
    const pd_setup *u = model->setup;
    if (u->has_dissolve)
        PDI_TRY(pdi_figures_add(ctx, f, "scene", "", -1, "volume_loss", "-", pd_couple_volume_loss(&model->couple)));
    for (int k = 0; k < u->monitors; k++) {
        const pd_monitor *m = &monitors->monitor[k];
        for (int j = 0; j < m->count; j++)
            PDI_TRY(pdi_figures_add(ctx, f, pdi_setup_monitor_name(m->desc->kind), m->desc->name, k, m->figure[j].key,
                                    m->figure[j].unit, m->figure[j].value));
    }
    if (u->probes) pdi_sample_prepare(ctx, model, 0);
    for (int k = 0; k < u->probes; k++) PDI_TRY(pdi_figures_probe(ctx, model, &u->probe[k], f));
    return PD_OK;
}

void pd_figures_free(pd_ctx *ctx, pd_figures *f)
{
    PDI_DELETE(ctx, f->room, f->list);
    memset(f, 0, sizeof *f);
}
