/* scalar_outputs: see scalar_outputs.h */
#include "run/scalar_outputs.h"
#include "setup/fields.h"
#include "physics/sample.h"
#include <stdio.h>
#include <string.h>

/* Append an output, growing the list. monitor: its index in the setup, -1: none. Strings are copied and cut to fit. */
static pd_status pdi_scalar_outputs_add(pd_ctx *ctx, pd_scalar_outputs *f, const char *section, const char *name,
                                        int monitor, const char *key, const char *unit, double value)
{
    if (f->count == f->capacity) {
        int fresh = 2 * f->capacity + 32;
        PD_TRY(PD_GROW(ctx, "figures", f->capacity, fresh, f->list));
        f->capacity = fresh;
    }
    pd_scalar_output *g = &f->list[f->count++];
    snprintf(g->section, sizeof g->section, "%s", section);
    snprintf(g->name, sizeof g->name, "%s", name);
    snprintf(g->key, sizeof g->key, "%s", key);
    snprintf(g->unit, sizeof g->unit, "%s", unit);
    g->monitor = monitor;
    g->value = value;
    return PD_OK;
}

/* Append the values of one field at a probe, one for each component; nothing if the probe does not record it. all: 1: 0
 * in the metal for fields of the fluid; 0: NaN there. */
static pd_status pdi_scalar_outputs_add_probe_field(pd_ctx *ctx, const pd_model *model, const pd_setup_probe *p,
                                                    pd_field field, int all, pd_scalar_outputs *f)
{
    char key[24], unit[PD_UNITS_TEXT];
    int components = pd_fields_count_components(field);
    double (*sample)(const pd_model *, pd_field, int, const double *) =
        all ? pd_sample_get_probe : pd_sample_get_point;
    if (!((p->fields >> field) & 1u)) return PD_OK;
    pd_fields_get_unit(model->setup, field, unit);
    if (!unit[0]) snprintf(unit, sizeof unit, "-");
    for (int d = 0; d < components; d++) {
        snprintf(key, sizeof key, "%.16s%s", pd_fields_get_name(model->setup, field), pd_fields_get_axis(field, d));
        PD_TRY(pdi_scalar_outputs_add(ctx, f, "probe", p->name, -1, key, unit, sample(model, field, d, p->position)));
    }
    return PD_OK;
}

/* 1: the field is smooth in the fluid, so that it may be compared and extrapolated between lattices (pH, solutes). */
static int pdi_scalar_outputs_is_smooth_field(const pd_setup *setup, int field)
{
    int species = pd_fields_species_index(setup, field);
    return field == PD_FIELD_PH || (species >= 0 && setup->electrolyte.species[species].phase == PD_PHASE_SOLUTE);
}

/* Append the values of a probe: v, p and C first, then, in the order of pd_field, all other fields with `all`, else pH
 * and solutes alone. */
static pd_status pdi_scalar_outputs_add_probe(pd_ctx *ctx, const pd_model *model, const pd_setup_probe *p, int all,
                                              pd_scalar_outputs *f)
{
    static const pd_field first[] = {PD_FIELD_V, PD_FIELD_P, PD_FIELD_C};
    for (int k = 0; k < 3; k++) PD_TRY(pdi_scalar_outputs_add_probe_field(ctx, model, p, first[k], all, f));
    for (int k = PD_FIELD_P + 1; k < PD_FIELD_COUNT; k++)
        if (all || pdi_scalar_outputs_is_smooth_field(model->setup, k))
            PD_TRY(pdi_scalar_outputs_add_probe_field(ctx, model, p, (pd_field)k, all, f));
    return PD_OK;
}

PDI_FN pd_status pdi_scalar_outputs_collect(pd_ctx *ctx, pd_model *model, const pd_monitors *monitors, int all,
                                            pd_scalar_outputs *f)
{
    const pd_setup *u = model->setup;
    f->order = u->has_flow && model->flow.order > 0 ? model->flow.order : 0;
    if (u->has_dissolve)
        PD_TRY(pdi_scalar_outputs_add(ctx, f, "scene", "", -1, "volume_loss", "-",
                                      pd_time_loop_volume_loss(&model->time_loop)));
    for (int k = 0; k < u->monitors; k++) {
        const pd_monitor *m = &monitors->monitor[k];
        for (int j = 0; j < m->count; j++)
            PD_TRY(pdi_scalar_outputs_add(ctx, f, pd_setup_monitor_section_name(m->desc->kind), m->desc->name, k,
                                          m->output[j].key, m->output[j].unit, m->output[j].value));
    }
    pd_fields fields = 0;
    for (int k = 0; k < u->probes && all; k++) fields |= u->probe[k].fields;
    if (u->probes) pd_sample_prepare(ctx, model, fields);
    for (int k = 0; k < u->probes; k++) PD_TRY(pdi_scalar_outputs_add_probe(ctx, model, &u->probe[k], all, f));
    return PD_OK;
}

void pd_scalar_outputs_free(pd_ctx *ctx, pd_scalar_outputs *f)
{
    PD_DELETE(ctx, f->capacity, f->list);
    memset(f, 0, sizeof *f);
}
