/* read_monitors: see read_monitors.h */
#include "scene/read_monitors.h"
#include "io/file.h"
#include "scene/key_value.h"
#include "setup/fields.h"
#include "scene/input_files.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* State of the reader. */
typedef struct pdi_read_monitors_state {
    pd_ctx *ctx;
    pd_text *text;
    pd_setup *setup;
    int section;
} pdi_read_monitors_state;

/* ---- values ---- */

PDI_FN pd_status pdi_read_monitors_fields(pd_ctx *ctx, pd_text *text, const pd_setup *setup, int section,
                                          const char *key, const char *fallback, pd_fields *bits)
{
    pd_word_list list;
    char names[PD_FIELDS_NAMES_SIZE];
    int given = pdi_text_has_key(ctx, text, section, key);
    PD_TRY(pdi_text_get_words(ctx, text, section, key, fallback, &list));
    *bits = 0;
    if (list.count == 1 && strcmp(list.word[0], "none") == 0) return PD_OK;
    for (int w = 0; w < list.count; w++) {
        int field = pd_fields_find(setup, list.word[w]);
        if (field == PD_FIELD_COUNT)
            return pdi_text_fail_key(ctx, text, section, key, "found '%s', expected some of %s, or none", list.word[w],
                                     pd_fields_format_names(setup, names));
        const char *needs = pd_fields_lacks(setup, (pd_field)field);
        if (needs && given)
            return pdi_text_fail_key(ctx, text, section, key, "found '%s', which needs %s", list.word[w], needs);
        if (!needs) *bits |= pd_fields_bit(field);
    }
    return PD_OK;
}

PDI_FN pd_status pdi_read_monitors_plane_position(pd_ctx *ctx, pd_text *text, const pd_setup *setup, int section,
                                                  const char *key, int *axis, double *at)
{
    const char *value;
    pd_expr expr;
    pd_expr_desc desc;
    PD_TRY(pdi_text_get_string(ctx, text, section, key, NULL, &value));
    *axis = value[0] - 'x';
    if (*axis < 0 || *axis >= PD_DIM || value[1] != ' ')
        return pdi_text_fail_key(ctx, text, section, key, "found '%.40s', expected an axis and a place: %c 0 um", value,
                                 "xyz"[PD_DIM - 1]);
    memset(&desc, 0, sizeof desc);
    desc.text = value + 2;
    desc.consts = text->consts;
    desc.const_count = text->const_count;
    desc.tables = text->tables;
    desc.table_count = text->table_count;
    desc.unit = "m";
    desc.location = key;
    desc.column = 3;
    if (pd_expr_build(ctx, &desc, &expr) < 0) return pdi_input_files_fail(ctx, text, section, key);
    *at = pd_expr_eval(&expr, NULL);
    pd_expr_free(ctx, &expr);
    if (*at > setup->lo[*axis] && *at < setup->hi[*axis]) return PD_OK;
    return pdi_text_fail_key(ctx, text, section, key, "found %.6g m, expected a place inside the box", *at);
}

/* Read the coordinates x[PD_DIM] [m] of a point in the box, whose sides are admitted. PD_ERR_ARGUMENT: another place,
 * or fewer than PD_DIM numbers. */
static pd_status pdi_read_monitors_point(pdi_read_monitors_state *w, const char *key, double *x)
{
    const pd_setup *u = w->setup;
    int count;
    PD_TRY(pdi_text_get_numbers(w->ctx, w->text, w->section, key, "m", NULL, PD_DIM, x, &count));
    if (count != PD_DIM)
        return pdi_text_fail_key(w->ctx, w->text, w->section, key,
                                 "found %d number%s, expected %d, one for each axis:"
                                 " pd%dd runs scenes in %dD",
                                 count, count > 1 ? "s" : "", PD_DIM, count, count);
    for (int d = 0; d < PD_DIM; d++)
        if (!(x[d] >= u->lo[d]) || !(x[d] <= u->hi[d]))
            return pdi_text_fail_key(w->ctx, w->text, w->section, key,
                                     "found %.6g m on axis %c, expected a place inside the box", x[d], "xyz"[d]);
    return PD_OK;
}

/* Read the box of a monitor into m->lo and m->hi; without the key, if optional, it is that of the grid. It may reach
 * beyond the grid. PD_ERR_ARGUMENT: fewer than PD_DIM ranges. */
static pd_status pdi_read_monitors_box(pdi_read_monitors_state *w, int optional, pd_setup_monitor *m)
{
    int count;
    memcpy(m->lo, w->setup->lo, sizeof m->lo);
    memcpy(m->hi, w->setup->hi, sizeof m->hi);
    if (optional && !pdi_text_has_key(w->ctx, w->text, w->section, "box")) return PD_OK;
    PD_TRY(pdi_text_get_ranges(w->ctx, w->text, w->section, "box", "m", NULL, PD_DIM, m->lo, m->hi, &count));
    if (count == PD_DIM) return PD_OK;
    return pdi_text_fail_key(w->ctx, w->text, w->section, "box",
                             "found %d range%s, expected %d, one for each axis:"
                             " pd%dd runs scenes in %dD",
                             count, count > 1 ? "s" : "", PD_DIM, count, count);
}

/* ---- sections ---- */

/* Check that the physics a monitor needs is present. PD_ERR_ARGUMENT: found no section [what]. */
static pd_status pdi_read_monitors_check_section(pdi_read_monitors_state *w, int has, const char *what)
{
    const char *name = w->text->section[w->section].name;
    if (has) return PD_OK;
    return pdi_text_fail_key(w->ctx, w->text, w->section, name, "found no [%s] section, expected one", what);
}

/* Read a [line NAME] section: end points, fields, those of them that are drawn (all by default), and the number of
 * sampling points, or their largest spacing, from which the number with both ends follows. PD_ERR_ARGUMENT: ends that
 * coincide, a drawn field that is not among the fields, points and spacing both, or more than PDI_KEYS_MAX_POINTS
 * points. */
static pd_status pdi_read_monitors_line(pdi_read_monitors_state *w, pd_setup_monitor *m)
{
    double spacing, length = 0.0;
    PD_TRY(pdi_read_monitors_point(w, "from", m->lo));
    PD_TRY(pdi_read_monitors_point(w, "to", m->hi));
    for (int d = 0; d < PD_DIM; d++) length += (m->hi[d] - m->lo[d]) * (m->hi[d] - m->lo[d]);
    length = sqrt(length);
    if (!(length > 0.0))
        return pdi_text_fail_key(w->ctx, w->text, w->section, "to", "found the point of 'from', expected another one");
    PD_TRY(pdi_read_monitors_fields(w->ctx, w->text, w->setup, w->section, "fields", "C, v, p, pH", &m->fields));
    m->images = m->fields;
    if (pdi_text_has_key(w->ctx, w->text, w->section, "images"))
        PD_TRY(pdi_read_monitors_fields(w->ctx, w->text, w->setup, w->section, "images", NULL, &m->images));
    if (m->images & ~m->fields)
        return pdi_text_fail_key(w->ctx, w->text, w->section, "images", "found a field that is not among 'fields'");
    if (!pdi_text_has_key(w->ctx, w->text, w->section, "spacing"))
        return pdi_key_value_get_index(w->ctx, w->text, w->section, "points", &m->points);
    if (pdi_text_has_key(w->ctx, w->text, w->section, "points"))
        return pdi_text_fail_key(w->ctx, w->text, w->section, "spacing", "found beside 'points', expected one of them");
    PD_TRY(pdi_key_value_get_number(w->ctx, w->text, w->section, "spacing", &spacing));
    if (length / spacing > PDI_KEYS_MAX_POINTS - 1.0)
        return pdi_text_fail_key(w->ctx, w->text, w->section, "spacing",
                                 "found %.6g m, which makes more than %d points", spacing, PDI_KEYS_MAX_POINTS);
    m->points = (int)pd_max(ceil(length / spacing * (1.0 - 1e-12)), 1.0) + 1;
    return PD_OK;
}

/* Read a [plane NAME] section: axis, and m->index, the number of cells below the face between cells that is nearest to
 * the coordinate, of two as near the upper one. PD_ERR_ARGUMENT: it would be a side of the box, or there is a gas. */
static pd_status pdi_read_monitors_plane(pdi_read_monitors_state *w, pd_setup_monitor *m)
{
    const pd_setup *u = w->setup;
    double at = 0.0, index;
    if (u->has_gas)
        return pdi_text_fail_key(w->ctx, w->text, w->section, "plane",
                                 "found beside [gas], expected [line] or [total]");
    PD_TRY(pdi_read_monitors_plane_position(w->ctx, w->text, u, w->section, "at", &m->axis, &at));
    /* of two as near, the upper one */
    index = floor((at - u->lo[m->axis]) / u->h[m->axis] + 0.5 + PD_SHAPE_TOLERANCE);
    if (!(index >= 1.0) || !(index <= pd_setup_count_cells(u, m->axis) - 1.0))
        return pdi_text_fail_key(w->ctx, w->text, w->section, "at",
                                 "found %.6g m, expected a place at least half a cell inside of the box", at);
    m->index = (int)index;
    return PD_OK;
}

/* Read the solid or wall on which a force is measured: m->shape is 1 + the index of its shape. PD_ERR_ARGUMENT: no
 * [shape] of that name, or one of another kind. */
static pd_status pdi_read_monitors_shape(pdi_read_monitors_state *w, pd_setup_monitor *m)
{
    const char *name;
    int k = 0;
    PD_TRY(pdi_text_get_string(w->ctx, w->text, w->section, "shape", NULL, &name));
    for (int s = -1; (s = pdi_text_next_section(w->ctx, w->text, "shape", s)) >= 0; k++) {
        if (strcmp(w->text->section[s].label, name) != 0) continue;
        m->shape = 1 + w->setup->section_shape[k];
        if (m->shape > 0) return PD_OK;
        return pdi_text_fail_key(w->ctx, w->text, w->section, "shape",
                                 "found '%.40s', which is no body, expected a [shape] with kind = solid or wall", name);
    }
    return pdi_text_fail_key(w->ctx, w->text, w->section, "shape",
                             "found '%.40s', expected the name of a [shape] with kind = solid or wall", name);
}

/* Read a [force NAME] section: shape, or box, which is optional beside a shape; momentum balance, by default with a box
 * alone; and, if one of them is given, the reference values of the coefficients 2 F/(rho U^2 A), with A = 1 in 1D.
 * PD_ERR_ARGUMENT: no [flow]. */
static pd_status pdi_read_monitors_force(pdi_read_monitors_state *w, pd_setup_monitor *m)
{
    const char *size = PD_DIM == 3 ? "reference_area" : "reference_length";
    PD_TRY(pdi_read_monitors_check_section(w, w->setup->has_flow, "flow"));
    int named = pdi_text_has_key(w->ctx, w->text, w->section, "shape");
    if (named) PD_TRY(pdi_read_monitors_shape(w, m));
    PD_TRY(pdi_read_monitors_box(w, named, m));
    PD_TRY(
        pdi_key_value_get_index_or(w->ctx, w->text, w->section, "balance", named ? "no" : "yes", &m->momentum_balance));
    if (!pdi_text_has_key(w->ctx, w->text, w->section, "reference_speed") &&
        !pdi_text_has_key(w->ctx, w->text, w->section, size))
        return PD_OK;
    PD_TRY(pdi_key_value_get_number(w->ctx, w->text, w->section, "reference_speed", &m->speed));
    m->area = 1.0;
    return PD_DIM == 1 ? PD_OK : pdi_key_value_get_number(w->ctx, w->text, w->section, size, &m->area);
}

/* Read the reference concentration of a Sherwood number: fluid = inlet, bulk, or a value [mol/m3]. PD_ERR_ARGUMENT:
 * inlet without an inlet (open sides do not count) or with a concentration that is an expression; bulk without [flow]
 * or without the axis of the stream. */
static pd_status pdi_read_monitors_reference_fluid(pdi_read_monitors_state *w, pd_setup_monitor *m)
{
    const pd_setup *u = w->setup;
    const char *value;
    int inlets = 0;
    PD_TRY(pdi_text_get_string(w->ctx, w->text, w->section, "fluid", NULL, &value));
    for (int side = 0; side < 2 * PD_DIM; side++)
        inlets += u->side[side].kind == PD_SIDE_INLET && !u->side[side].is_open;
    if (strcmp(value, "inlet") == 0) {
        m->reference = PD_REFERENCE_FLUID_INLET;
        m->fluid_c = u->inlet_c;
        if (inlets && u->has_inlet_c_by_side)
            return pdi_text_fail_key(w->ctx, w->text, w->section, "fluid",
                                     "found 'inlet', whose C is no constant, expected bulk or a concentration");
        if (inlets) return PD_OK;
        return pdi_text_fail_key(w->ctx, w->text, w->section, "fluid",
                                 "found 'inlet' in a scene without one, expected bulk or a concentration");
    }
    if (strcmp(value, "bulk") != 0) return pdi_key_value_get_number(w->ctx, w->text, w->section, "fluid", &m->fluid_c);
    m->reference = PD_REFERENCE_FLUID_BULK;
    PD_TRY(pdi_read_monitors_check_section(w, u->has_flow, "flow"));
    if (m->axis >= 0) return PD_OK;
    return pdi_text_fail_key(w->ctx, w->text, w->section, "fluid",
                             "found 'bulk' without the axis of the stream, expected along = %s",
                             PD_DIM == 3   ? "x, y or z"
                             : PD_DIM == 2 ? "x or y"
                                           : "x");
}

/* Read a [transfer NAME] section: box (the grid by default), axis of local values (m->axis -1: none), area, and, if a
 * reference length is given, the reference values of a Sherwood number, with D of [transport] by default.
 * PD_ERR_ARGUMENT: no [transport]. */
static pd_status pdi_read_monitors_transfer(pdi_read_monitors_state *w, pd_setup_monitor *m)
{
    static const char *const axes[] = {"x", "y", "z"};
    const char *names[PD_DIM + 1];
    char diffusivity[PD_UNITS_TEXT];
    for (int d = 0; d < PD_DIM; d++) names[d] = axes[d];
    names[PD_DIM] = NULL;
    PD_TRY(pdi_read_monitors_check_section(w, w->setup->has_transport, "transport"));
    PD_TRY(pdi_read_monitors_box(w, 1, m));
    m->axis = -1;
    if (pdi_text_has_key(w->ctx, w->text, w->section, "along"))
        PD_TRY(pdi_text_get_choice(w->ctx, w->text, w->section, "along", names, NULL, &m->axis));
    if (pdi_text_has_key(w->ctx, w->text, w->section, "area"))
        PD_TRY(pdi_key_value_get_number(w->ctx, w->text, w->section, "area", &m->area));
    if (!pdi_text_has_key(w->ctx, w->text, w->section, "reference_length")) return PD_OK;
    PD_TRY(pdi_key_value_get_number(w->ctx, w->text, w->section, "reference_length", &m->length));
    PD_TRY(pdi_key_value_get_number(w->ctx, w->text, w->section, "surface", &m->surface_c));
    PD_TRY(pdi_read_monitors_reference_fluid(w, m));
    pdi_file_format_number(w->setup->diffusivity, diffusivity);
    strcat(diffusivity, " m2/s");
    return pdi_key_value_get_number_or(w->ctx, w->text, w->section, "D", diffusivity, &m->diffusivity);
}

/* Read one section of a kind of monitor and append it to the setup. PD_ERR_ARGUMENT: PD_SETUP_MONITORS are there, no
 * name, or one of PD_SETUP_NAME - 24 bytes or more. Kinds that other sections make are appended without any key. */
static pd_status pdi_read_monitors_section(pdi_read_monitors_state *w, pd_monitor_kind kind)
{
    pd_setup *u = w->setup;
    const char *label = w->text->section[w->section].label, *name = pd_setup_monitor_section_name(kind);
    if (u->monitors >= PD_SETUP_MONITORS)
        return pdi_text_fail_key(w->ctx, w->text, w->section, name, "found more than %d sections of this sort",
                                 PD_SETUP_MONITORS);
    if (label[0] == '\0' || strlen(label) >= PD_SETUP_NAME - 24)
        return pdi_text_fail_key(w->ctx, w->text, w->section, name, "expected a short name: [%s NAME]", name);
    pd_setup_monitor *m = &u->monitor[u->monitors++];
    m->kind = kind;
    m->line = w->text->section[w->section].line;
    memcpy(m->name, label, strlen(label) + 1);
    switch (kind) {
    case PD_MONITOR_LINE: return pdi_read_monitors_line(w, m);
    case PD_MONITOR_PLANE: return pdi_read_monitors_plane(w, m);
    case PD_MONITOR_FORCE: return pdi_read_monitors_force(w, m);
    case PD_MONITOR_TRANSFER: return pdi_read_monitors_transfer(w, m);
    case PD_MONITOR_TOTAL: return pdi_read_monitors_box(w, 1, m);
    case PD_MONITOR_MECHANICAL_BC:
    case PD_MONITOR_SOLID:
    case PD_MONITOR_ELECTRODE:
    case PD_MONITOR_SURFACE_STATE:
    case PD_MONITOR_PRECRACK: break; /* [solid] and [crack] make them */
    }
    return PD_OK;
}

/* Read one [probe NAME] section and append the probe: point and fields, by default C, without transport pH, phi or v,
 * the first that the physics has. PD_ERR_ARGUMENT: too many probes, no name or a long one, a point outside the box. */
static pd_status pdi_read_monitors_probe(pdi_read_monitors_state *w)
{
    pd_setup *u = w->setup;
    const char *label = w->text->section[w->section].label;
    if (u->probes >= PD_SETUP_PROBES)
        return pdi_text_fail_key(w->ctx, w->text, w->section, "probe", "found more than %d probes", PD_SETUP_PROBES);
    if (label[0] == '\0' || strlen(label) >= PD_SETUP_NAME - 24)
        return pdi_text_fail_key(w->ctx, w->text, w->section, "probe", "expected a short name: [probe NAME]");
    pd_setup_probe *p = &u->probe[u->probes++];
    memcpy(p->name, label, strlen(label) + 1);
    p->line = w->text->section[w->section].line;
    PD_TRY(pdi_read_monitors_point(w, "at", p->position));
    return pdi_read_monitors_fields(w->ctx, w->text, u, w->section, "fields",
                                    u->has_transport ? "C" : u->has_chemistry ? "pH" : u->has_potential ? "phi" : "v",
                                    &p->fields);
}

PDI_FN pd_status pdi_read_monitors_read(pd_ctx *ctx, pd_text *text, pd_setup *setup)
{
    pdi_read_monitors_state w;
    w.ctx = ctx;
    w.text = text;
    w.setup = setup;
    for (w.section = pdi_text_next_section(ctx, text, "probe", -1); w.section >= 0;
         w.section = pdi_text_next_section(ctx, text, "probe", w.section))
        PD_TRY(pdi_read_monitors_probe(&w));
    for (int kind = PD_MONITOR_LINE; kind <= PD_MONITOR_TOTAL; kind++) {
        const char *name = pd_setup_monitor_section_name((pd_monitor_kind)kind);
        for (w.section = pdi_text_next_section(ctx, text, name, -1); w.section >= 0;
             w.section = pdi_text_next_section(ctx, text, name, w.section))
            PD_TRY(pdi_read_monitors_section(&w, (pd_monitor_kind)kind));
    }
    return PD_OK;
}
