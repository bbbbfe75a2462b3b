/* read_physics: see read_physics.h */
#include "scene/read_physics.h"
#include "setup/fields.h"
#include <stdio.h>
#include <string.h>

/* Read the value of a key into an expression, for pd_expr_free: one in x, y, z, t, a number, or the index of a whole
 * number or choice. PD_ERR_ARGUMENT: a constant is out of the bounds of the key; nothing is left to free then. */
static pd_status pdi_read_physics_value(pdi_reader *s, int section, const pd_key *key, pd_expr *value)
{
    const char *unit = strcmp(key->unit, "-") == 0 ? "" : key->unit;
    const char *fallback = strcmp(key->default_text, "required") == 0 ? NULL : key->default_text;
    int index, variables = key->type == PD_KEY_TEXT ? PD_SETUP_POSITION_VARS : 0;
    if (key->type == PD_KEY_WHOLE || key->type == PD_KEY_CHOICE) {
        pd_expr_desc desc;
        char text[16];
        PD_TRY(pdi_key_value_get_index_or(s->ctx, s->text, section, key->keys, fallback, &index));
        snprintf(text, sizeof text, "%d", index);
        memset(&desc, 0, sizeof desc);
        desc.text = text;
        return pd_expr_build(s->ctx, &desc, value);
    }
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, key->keys, unit, pd_setup_get_position_symbols(), variables,
                             fallback, value));
    if (!pd_expr_is_constant(value)) return PD_OK;
    pd_status status = pdi_key_value_check_bounds(s->ctx, s->text, section, key, pd_expr_eval(value, NULL));
    if (status < 0) pd_expr_free(s->ctx, value);
    return status;
}

/* Read the keys of its section into own->value and set their bits in own->given. A key with the default "-" that is
 * absent is left out. */
static pd_status pdi_read_physics_keys(pdi_reader *s, int section, pd_setup_registered *own)
{
    const pd_key_section *table = &own->type->section;
    for (int k = 0; k < table->count; k++) {
        const pd_key *key = &table->key[k];
        if (strcmp(key->default_text, "-") == 0 && !pdi_text_has_key(s->ctx, s->text, section, key->keys)) continue;
        PD_TRY(pdi_read_physics_value(s, section, key, &own->value[k]));
        own->given |= (uint32_t)1 << k;
    }
    return PD_OK;
}

/* Read the values that sides prescribe for the first field of the physics, under its name as a key, as expressions in
 * x, y, z, t, and set their bits in own->prescribed_sides. Sides without the key are left out. */
static pd_status pdi_read_physics_sides(pdi_reader *s, pd_setup_registered *own)
{
    const pd_physics_field *field = &own->type->field[0];
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int section = pdi_text_get_section(s->ctx, s->text, "side", pd_setup_side_name(side));
        if (!pdi_text_has_key(s->ctx, s->text, section, field->name)) continue;
        PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, field->name, field->unit, pd_setup_get_position_symbols(),
                                 PD_SETUP_POSITION_VARS, NULL, &own->prescribed[side]));
        own->prescribed_sides |= (uint32_t)1 << side;
    }
    return PD_OK;
}

/* Check the fields of a physics and make their labels, "name [unit]". PD_ERR_ARGUMENT: too many fields with those of
 * the physics before, or a name that is empty, too long, or that of a field or variable of rate laws. */
static pd_status pdi_read_physics_fields(pdi_reader *s, int section, pd_setup_registered *own)
{
    const pd_expr_symbol *variable = pd_setup_get_rate_symbols();
    int all = own->type->fields;
    for (int k = 0; k < s->setup->registered_count; k++) all += s->setup->registered[k].type->fields;
    if (all > PD_PHYSICS_TYPE_FIELDS || pd_fields_first_registered(s->setup) + all > PD_FIELD_COUNT)
        return pdi_text_fail_key(s->ctx, s->text, section, own->type->section.name,
                                 "found %d fields of such sections, expected at most %d, and fewer beside %d species "
                                 "and states of surfaces",
                                 all, PD_PHYSICS_TYPE_FIELDS, s->setup->electrolyte.count + s->setup->states);
    for (int k = 0; k < own->type->fields; k++) {
        const pd_physics_field *field = &own->type->field[k];
        int taken = pd_fields_find(s->setup, field->name) < PD_FIELD_COUNT;
        for (int v = 0; v < PD_SETUP_RATE_VARS; v++) taken |= strcmp(variable[v].name, field->name) == 0;
        if (taken || !field->name[0] || strlen(field->name) >= PD_SETUP_NAME)
            return pdi_text_fail_key(s->ctx, s->text, section, own->type->section.name,
                                     "found a field with the name '%.40s', expected one that is free", field->name);
        snprintf(own->label[k], sizeof own->label[k], "%s%s%.90s%s", field->name, field->unit[0] ? " [" : "",
                 field->unit, field->unit[0] ? "]" : "");
    }
    return PD_OK;
}

PDI_FN pd_status pdi_read_physics_read(pdi_reader *s)
{
    int check = s->text->check_keys;
    pd_status status = PD_OK;
    s->text->check_keys = 0; /* the keys are the program's */
    for (int k = 0; k < s->ctx->physics_count && status == PD_OK; k++) {
        const pd_physics_type *type = s->ctx->physics[k];
        int section = pdi_text_get_section(s->ctx, s->text, type->section.name, NULL);
        if (!pdi_text_has_key(s->ctx, s->text, section, NULL)) continue;
        pd_setup_registered *own = &s->setup->registered[s->setup->registered_count];
        own->type = type;
        own->line = s->text->section[section].line;
        status = pdi_read_physics_fields(s, section, own);
        s->setup->registered_count++; /* pd_setup_free frees what it has */
        if (status == PD_OK) status = pdi_read_physics_keys(s, section, own);
        if (status == PD_OK) status = pdi_read_physics_sides(s, own);
    }
    s->text->check_keys = check;
    return status;
}

PDI_FN void pdi_read_physics_set_symbols(const pd_setup *setup, pd_expr_symbol *symbols, char (*unit)[PD_UNITS_TEXT])
{
    int first = pd_fields_first_registered(setup), index;
    for (int k = 0; k < PD_PHYSICS_TYPE_FIELDS && pd_fields_find_registered(setup, first + k, &index) >= 0; k++) {
        pd_fields_get_unit(setup, (pd_field)(first + k), unit[k]);
        symbols[PD_SETUP_RATE_FIELD + k].name = pd_fields_get_name(setup, (pd_field)(first + k));
        symbols[PD_SETUP_RATE_FIELD + k].unit = unit[k];
    }
}
