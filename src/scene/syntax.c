/* syntax: see syntax.h */
#include "scene/syntax.h"
#include <stdio.h>
#include <string.h>

typedef struct pdi_syntax_section {
    const char *name, *keys; /* keys in the order of the guide; NULL: any */
} pdi_syntax_section;

static const pdi_syntax_section pdi_syntax_table[] = {
    {"constants", NULL}, /* any name */
    {"grid", "h, m, box, geometry, threads"},
    {"shape", "box, ball, cylinder, half_space, mask, raw, stl, union, intersect, difference, radius, centre, "
              "point, normal, corner, cell, size, scale, shift, outside, "
              "kind, C, material, D, grains, grain_spread, grain_seed, "
              "boundary_width, ux, uy, uz"},
    {"side", "flow, profile, mean, flow_rate, vx, vy, vz, p, velocity, C, ux, uy, uz, traction, pressure"},
    {"flow", "rho, mu, steady, force, speed, length, time, order, vx, vy, vz, rtol, eos, c0"},
    {"gas", "gamma, rho, p, vx, vy, vz, order, cfl"},
    {"transport", "D, initial, advection, time"},
    {"dissolve", "rate, law, rate_scale, Csat, Cs, charge, gb_factor, threshold, m"},
    {"corrode", "rate, current, rate_scale, Cs, Csat, charge, D, initial, bulk, control, drive, kernel, weights, "
                "gb_factor, repassivation, breaking, seed, m"},
    {"solid", "E, nu, plane, m, influence, material, yield, hardening, stretch, strength, toughness, force, "
              "speed_factor, motion, density, rtol"},
    {"cut", "points, way, contours"},
    {"table", "file, x, y, outside"},
    {"run", "until, rtol, fraction, max_step"},
    {"output", "every, fields, images, deformed, slice, prefix, folder"},
    {"probe", "at, fields"},
    {"line", "from, to, points, spacing, fields, images"},
    {"plane", "at"},
    {"force", "box, shape, balance, speed, length, area"},
    {"transfer", "box, along, length, surface, fluid, D, area"},
    {"total", "box"},
    {"measured", "file, time, value, spread, of, start"}};
#define PDI_SYNTAX_SECTIONS ((int)(sizeof pdi_syntax_table / sizeof pdi_syntax_table[0]))

/* 1 when the comma-separated list holds the word; offers all its words to near_word. */
static int pdi_syntax_listed(const char *list, const char *word, pdi_units_near *near_word)
{
    while (*list) {
        char item[PD_TEXT_WORD];
        size_t size = strcspn(list, ",");
        PD_ASSERT(size < sizeof item);
        memcpy(item, list, size);
        item[size] = '\0';
        if (strcmp(item, word) == 0) return 1;
        pdi_units_offer(near_word, item);
        list += size;
        list += strspn(list, ", ");
    }
    return 0;
}

static pd_status pdi_syntax_section_of(pd_ctx *ctx, const pd_text *text, int section, int *found)
{
    const char *name = text->section[section].name;
    char hint[PD_UNITS_TEXT], list[256] = "";
    pdi_units_near near_word;
    pdi_units_near_init(&near_word, name, strlen(name));
    for (int k = 0; k < PDI_SYNTAX_SECTIONS; k++) {
        *found = k;
        if (strcmp(pdi_syntax_table[k].name, name) == 0) return PD_OK;
        pdi_units_offer(&near_word, pdi_syntax_table[k].name);
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", k ? ", " : "", pdi_syntax_table[k].name);
    }
    pdi_units_hint(&near_word, hint);
    return pdi_text_refuse(ctx, text, section, "scene", "found the section [%.40s], expected one of %s%s", name, list,
                           hint);
}

static pd_status pdi_syntax_key(pd_ctx *ctx, const pd_text *text, const pd_text_entry *e, const char *keys)
{
    const pd_section *s = &text->section[e->section];
    char hint[PD_UNITS_TEXT], where[320] = "command line";
    pdi_units_near near_word;
    if (!keys) return PD_OK;
    pdi_units_near_init(&near_word, e->key, strlen(e->key));
    if (pdi_syntax_listed(keys, e->key, &near_word)) return PD_OK;
    pdi_units_hint(&near_word, hint);
    if (e->line > 0) snprintf(where, sizeof where, "%.280s:%d", text->name, e->line);
    return pdi_fail(ctx, PD_ERR_PARSE, where, "found the unknown key '%.40s' in [%.40s%s%.40s], expected one of %s%s",
                    e->key, s->name, s->label[0] ? " " : "", s->label, keys, hint);
}

PDI_FN pd_status pdi_syntax_check(pd_ctx *ctx, const pd_text *text)
{
    int found;
    for (int k = 1; k < text->section_count; k++) PDI_TRY(pdi_syntax_section_of(ctx, text, k, &found));
    for (int k = 0; k < text->entry_count; k++) {
        const pd_text_entry *e = &text->entry[k];
        if (e->section == 0) continue; /* a pair before the first section: pdi_text_unused */
        PDI_TRY(pdi_syntax_section_of(ctx, text, e->section, &found));
        PDI_TRY(pdi_syntax_key(ctx, text, e, pdi_syntax_table[found].keys));
    }
    return PD_OK;
}

#undef PDI_SYNTAX_SECTIONS
