/* key_check: see key_check.h */
#include "scene/key_check.h"
#include <stdio.h>
#include <string.h>

/* Add the words of a comma-separated list to the spelling suggestion near_word and to the message text all[size]. */
static void pdi_key_check_add_candidates(const char *list, pd_units_suggestion *near_word, char *all, size_t size)
{
    while (*list) {
        char item[PD_TEXT_WORD];
        size_t length = strcspn(list, ","), used = strlen(all);
        PD_ASSERT(length < sizeof item);
        memcpy(item, list, length);
        item[length] = '\0';
        pd_units_try_candidate(near_word, item);
        snprintf(all + used, size - used, "%s%s", used ? ", " : "", item);
        list += length;
        list += strspn(list, ", ");
    }
}

/* Check the name of a section. PD_ERR_ARGUMENT: it is neither in the table nor of a registered physics. */
static pd_status pdi_key_check_section(pd_ctx *ctx, const pd_text *text, int section)
{
    const char *name = text->section[section].name;
    char hint[PD_UNITS_TEXT], list[256] = "";
    int count;
    const pd_key_section *table = pd_key_sections(&count);
    pd_units_suggestion near_word;
    if (pdi_keys_find_known_section(ctx, name)) return PD_OK;
    pd_units_init_suggestion(&near_word, name, strlen(name));
    for (int k = 0; k < count; k++) pdi_key_check_add_candidates(table[k].name, &near_word, list, sizeof list);
    for (int k = 0; k < ctx->physics_count; k++)
        pdi_key_check_add_candidates(ctx->physics[k]->section.name, &near_word, list, sizeof list);
    pd_units_format_suggestion(&near_word, hint);
    return pdi_text_fail_key(ctx, text, section, "scene", "found the section [%.40s], expected one of %s%s", name, list,
                             hint);
}

/* Check the key of a pair in its section, which is a known one. In [side ...] the fields of registered physics are
 * keys, too. PD_ERR_PARSE: unknown. */
static pd_status pdi_key_check_key(pd_ctx *ctx, const pd_text *text, const pd_text_entry *e)
{
    const pd_section *s = &text->section[e->section];
    const pd_key_section *table = pdi_keys_find_known_section(ctx, s->name);
    char hint[PD_UNITS_TEXT], list[512] = "", where[320] = "command line";
    pd_units_suggestion near_word;
    if (pdi_keys_find_key(table, e->key)) return PD_OK;
    if (strcmp(s->name, "side") == 0 && pdi_keys_is_field(ctx, e->key)) return PD_OK;
    pd_units_init_suggestion(&near_word, e->key, strlen(e->key));
    for (int k = 0; k < table->count; k++)
        pdi_key_check_add_candidates(table->key[k].keys, &near_word, list, sizeof list);
    pd_units_format_suggestion(&near_word, hint);
    if (e->line > 0) snprintf(where, sizeof where, "%.280s:%d", e->file, e->line);
    return pd_fail(ctx, PD_ERR_PARSE, where, "found the unknown key '%.40s' in [%.40s%s%.40s], expected one of %s%s",
                   e->key, s->name, s->label[0] ? " " : "", s->label, list, hint);
}

PDI_FN pd_status pdi_key_check_all(pd_ctx *ctx, const pd_text *text)
{
    for (int k = 1; k < text->section_count; k++) PD_TRY(pdi_key_check_section(ctx, text, k));
    for (int k = 0; k < text->entry_count; k++) /* a pair before the first section: pdi_text_check_unused */
        if (text->entry[k].section) PD_TRY(pdi_key_check_key(ctx, text, &text->entry[k]));
    return PD_OK;
}
