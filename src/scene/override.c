/* override: see override.h */
#include "scene/override.h"
#include "scene/keys.h"
#include <stdio.h>
#include <string.h>

/* Section of a bare key into *section: the only one that has it, or section 0 of a flat file, which may lack it.
 * PD_ERR_PARSE: several have it, or none in a text with sections; the message lists the candidates. */
static pd_status pdi_override_find_bare_key(pd_ctx *ctx, const pd_text *text, const char *key, int *section)
{
    int count = 0;
    char list[PDI_TEXT_LIST_SIZE] = "", hint[PD_UNITS_TEXT];
    pd_units_suggestion near_word;
    pd_units_init_suggestion(&near_word, key, strlen(key));
    *section = 0;
    for (int k = 0; k < text->entry_count; k++) {
        const pd_text_entry *e = &text->entry[k];
        const pd_section *s = &text->section[e->section];
        pd_units_try_candidate(&near_word, e->key);
        if (strcmp(e->key, pdi_renamed_keys_get_key(s->name, key)) != 0) continue;
        char path[3 * 64];
        snprintf(path, sizeof path, "%.60s%s%.60s%s%.60s", s->name, s->label[0] ? "." : "", s->label,
                 s->name[0] ? "." : "", key);
        pdi_text_add_to_list(list, ", ", path);
        *section = e->section;
        count++;
    }
    pd_units_format_suggestion(&near_word, hint);
    if (count > 1)
        return pdi_text_fail_line(ctx, text->name, 0, "found the key '%.40s', expected one of %s", key, list);
    if (count == 0 && !text->is_flat) {
        int sections;
        const pd_key_section *known = pd_key_sections(&sections);
        list[0] = '\0';
        for (int k = 0; k < sections; k++) {
            const pd_key_section *s = &known[k];
            char path[3 * 64];
            const char *present = pdi_renamed_keys_get_key(s->name, key);
            if (strcmp(s->name, "constants") == 0 || !pdi_keys_find_key(s, present)) continue; /* that has any */
            snprintf(path, sizeof path, "%.60s%s%.60s.%.60s", s->name, s->label[0] ? "." : "", s->label, key);
            pdi_text_add_to_list(list, ", ", path);
        }
        return pdi_text_fail_line(ctx, text->name, 0,
                                  "found the key '%.40s', which no section of %.80s has, expected"
                                  " section.key%s%s%s",
                                  key, text->name, list[0] ? ": " : "", list, list[0] ? "" : hint);
    }
    return PD_OK;
}

/* Section of `name.key` into *section: the one without label, else the only labelled one, else a new one, which is
 * empty. The key itself is not looked up. PD_ERR_PARSE: several labelled ones and none without label. */
static pd_status pdi_override_find_named_section(pd_ctx *ctx, pd_text *text, const char *name, const char *key,
                                                 int *section)
{
    int count = 0, found = -1;
    char list[PDI_TEXT_LIST_SIZE] = "";
    for (int k = 0; k < text->section_count; k++) {
        const pd_section *s = &text->section[k];
        if (!s->is_present || strcmp(s->name, name) != 0) continue;
        char path[3 * 64];
        snprintf(path, sizeof path, "%.60s.%.60s.%.60s", name, s->label, key);
        pdi_text_add_to_list(list, ", ", path);
        count++;
        if (found < 0 || s->label[0] == '\0') found = k;
    }
    if (count > 1 && text->section[found].label[0])
        return pdi_text_fail_line(ctx, text->name, 0, "found '%.40s.%.40s', expected one of %s", name, key, list);
    *section = found;
    return found >= 0 ? PD_OK : pdi_text_find_or_add_section(ctx, text, name, "", section);
}

/* Existing section [name label]. PD_ERR_PARSE: there is none. */
static pd_status pdi_override_find_labelled_section(pd_ctx *ctx, const pd_text *text, const char *name,
                                                    const char *label, int *section)
{
    char list[PDI_TEXT_LIST_SIZE] = "";
    for (int k = 0; k < text->section_count; k++) {
        const pd_section *s = &text->section[k];
        if (!s->is_present || strcmp(s->name, name) != 0) continue;
        *section = k;
        if (strcmp(s->label, label) == 0) return PD_OK;
        pdi_text_add_to_list(list, ", ", s->label[0] ? s->label : "no label");
    }
    return pdi_text_fail_line(ctx, text->name, 0,
                              "found the section [%.40s %.40s], expected one of %.80s (its labels: %s)", name, label,
                              text->name, list[0] ? list : "none");
}

PDI_FN pd_status pdi_override_apply(pd_ctx *ctx, pd_text *text, const char *argument)
{
    char *part[3], *t;
    size_t at = 0, value = 0, end;
    int parts = 0, section = 0;
    PD_TRY(pdi_text_check_bytes(ctx, text, argument, strlen(argument)));
    PD_TRY(pdi_text_copy_string(ctx, text, argument, strlen(argument), &t));
    for (int more = 1; more; parts++) {
        at = pdi_text_skip_blanks(t, at);
        pdi_text_charset kind = parts == 1 ? pdi_text_get_label_charset(part[0]) : PDI_TEXT_CHARSET_KEY;
        size_t size = parts < 3 ? pdi_text_scan_word(t + at, kind) : 0, next = at + size;
        if (size == 0 || (t[next] != '.' && t[pdi_text_skip_blanks(t, next)] != '='))
            return pdi_text_fail_expected(ctx, text, 0, t, size == 0 ? at : next,
                                          "key=value, section.key=value or section.label.key=value");
        part[parts] = t + at;
        more = t[next] == '.';
        value = more ? 0 : pdi_text_skip_blanks(t, pdi_text_skip_blanks(t, next) + 1);
        t[next] = '\0';
        at = next + 1;
    }
    for (end = strlen(t + value) + value; end > value && pd_units_is_blank(t[end - 1]);) end--;
    t[end] = '\0';
    const char *key = part[parts - 1];
    if (end == value)
        return pdi_text_fail_line(ctx, text->name, 0,
                                  "found nothing after '%.40s=', expected a value: a key of the scene "
                                  "is not taken back here, but in its text",
                                  key);
    if (pdi_text_scan_word(key, PDI_TEXT_CHARSET_KEY) != strlen(key))
        return pdi_text_fail_line(ctx, text->name, 0, "found '%.40s', expected a key", key);
    if (parts == 1) PD_TRY(pdi_override_find_bare_key(ctx, text, key, &section));
    else if (parts == 2)
        PD_TRY(pdi_override_find_named_section(ctx, text, pdi_text_get_present_section(text, part[0]), key, &section));
    else
        PD_TRY(pdi_override_find_labelled_section(ctx, text, pdi_text_get_present_section(text, part[0]), part[1],
                                                  &section));
    key = pdi_text_get_present_key(text, section, key);
    pd_text_entry *e = pdi_text_find_entry(text, section, key);
    if (!e) return pdi_text_add_entry(ctx, text, section, key, t + value, 0, (int)value + 1);
    pdi_text_set_value(text, e, t + value);
    e->line = 0;
    e->column = (int)value + 1;
    return PD_OK;
}
