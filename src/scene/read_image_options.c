/* read_image_options: see read_image_options.h */
#include "scene/read_image_options.h"
#include "scene/key_value.h"
#include "setup/fields.h"
#include "io/field_plot.h"
#include "scene/input_files.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_READ_IMAGE_OPTIONS_ITEM_SIZE 256          /* [byte] of one part of a list */
#define PDI_READ_IMAGE_OPTIONS_DEFAULT_STREAMLINES 36 /* that fit side by side, when the scene does not say how many \
                                                       */
#define PDI_READ_IMAGE_OPTIONS_DEFAULT_VECTORS 30     /* the same of arrows */

/* State of the reader. */
typedef struct pdi_read_image_options_state {
    pd_ctx *ctx;
    pd_text *text;
    pd_setup *setup;
    int section;
    pd_fields drawn_fields; /* bit k: a picture shows pd_field k */
} pdi_read_image_options_state;

/* Copy the next item of a list, without blanks around it and cut to PDI_READ_IMAGE_OPTIONS_ITEM_SIZE bytes, into item
 * and advance *list. A comma outside parentheses ends an item, which may be empty. 1: there was one; 0: end of the
 * list. */
static int pdi_read_image_options_next_item(const char **list, char *item)
{
    const char *from = *list + strspn(*list, " \t");
    size_t length = 0;
    if (!*from) return 0;
    for (int depth = 0; from[length] && (depth > 0 || from[length] != ','); length++)
        depth += (from[length] == '(') - (from[length] == ')');
    *list = from + length + (from[length] == ',');
    while (length > 0 && (from[length - 1] == ' ' || from[length - 1] == '\t')) length--;
    snprintf(item, PDI_READ_IMAGE_OPTIONS_ITEM_SIZE, "%.*s", (int)length, from);
    return 1;
}

/* Find a field by name among the drawn ones; *field: its pd_field. PD_ERR_ARGUMENT: not drawn, or no field. */
static pd_status pdi_read_image_options_find_field(pdi_read_image_options_state *r, const char *key, const char *name,
                                                   int *field)
{
    for (*field = 0; *field < PD_FIELD_COUNT; ++*field)
        if ((r->drawn_fields >> *field & 1u) && strcmp(name, pd_fields_get_name(r->setup, (pd_field)*field)) == 0)
            return PD_OK;
    return pdi_text_fail_key(r->ctx, r->text, r->section, key, "found '%.40s', expected one of the fields of 'images'",
                             name);
}

/* Evaluate the text `from` as a constant in `unit`: one end of a range, or a contour value; *value in SI.
 * PD_ERR_ARGUMENT names key and text: it is no such constant. */
static pd_status pdi_read_image_options_eval_value(pdi_read_image_options_state *r, const char *key, const char *from,
                                                   const char *unit, double *value)
{
    pd_expr expr;
    pd_expr_desc desc;
    char where[PD_UNITS_TEXT];
    size_t end = strlen(from);
    while (end > 0 && pd_units_is_blank(from[end - 1])) end--;
    snprintf(where, sizeof where, "%.*s", (int)(end < sizeof where ? end : sizeof where - 1), from);
    memset(&desc, 0, sizeof desc);
    desc.text = from;
    desc.consts = r->text->consts;
    desc.const_count = r->text->const_count;
    desc.tables = r->text->tables;
    desc.table_count = r->text->table_count;
    desc.unit = unit;
    desc.location = where;
    if (pd_expr_build(r->ctx, &desc, &expr) < 0) return pdi_input_files_fail(r->ctx, r->text, r->section, key);
    *value = pd_expr_eval(&expr, NULL);
    pd_expr_free(r->ctx, &expr);
    return PD_OK;
}

/* Read one item "C 0 .. 500 mol/m3" of the colour ranges into drawing.range [SI]; item is cut apart. PD_ERR_ARGUMENT: a
 * field that is not drawn, has categories or has a range already, no "..", a start that is not below its end, or, with
 * a logarithmic scale, not above 0. */
static pd_status pdi_read_image_options_range(pdi_read_image_options_state *r, char *item)
{
    char unit[PD_UNITS_TEXT];
    int field;
    size_t word = strcspn(item, " \t");
    char *from = item + word + (item[word] != '\0'), *dots = strstr(from, "..");
    item[word] = '\0';
    PD_TRY(pdi_read_image_options_find_field(r, "range", item, &field));
    pd_fields_get_unit(r->setup, (pd_field)field, unit);
    if (pd_fields_get_scale((pd_field)field) == PD_FIELD_SCALE_CATEGORY)
        return pdi_text_fail_key(r->ctx, r->text, r->section, "range", "found '%s', whose values have a colour each",
                                 item);
    if (!dots)
        return pdi_text_fail_key(r->ctx, r->text, r->section, "range",
                                 "found '%.60s' behind '%s', expected a range: %s 0 .. 1 %s", from, item, item, unit);
    *dots = '\0';
    double *range = r->setup->drawing.range[field];
    if (range[0] < range[1]) return pdi_text_fail_key(r->ctx, r->text, r->section, "range", "found '%s' twice", item);
    PD_TRY(pdi_read_image_options_eval_value(r, "range", from, unit, &range[0]));
    PD_TRY(pdi_read_image_options_eval_value(r, "range", dots + 2, unit, &range[1]));
    if (!(range[0] < range[1]) || !(range[1] - range[0] < HUGE_VAL))
        return pdi_text_fail_key(r->ctx, r->text, r->section, "range",
                                 "found %.6g .. %.6g of '%s', expected the smaller "
                                 "value first",
                                 range[0], range[1], item);
    if ((r->setup->drawing.log >> field & 1u) && !(range[0] > 0.0))
        return pdi_text_fail_key(r->ctx, r->text, r->section, "range",
                                 "found %.6g of '%s', which is drawn by its logarithm, expected a positive value",
                                 range[0], item);
    return PD_OK;
}

/* Read the colour ranges of fields. */
static pd_status pdi_read_image_options_ranges(pdi_read_image_options_state *r)
{
    const char *list;
    char item[PDI_READ_IMAGE_OPTIONS_ITEM_SIZE];
    if (!pdi_text_has_key(r->ctx, r->text, r->section, "range")) return PD_OK;
    PD_TRY(pdi_text_get_string(r->ctx, r->text, r->section, "range", NULL, &list));
    while (pdi_read_image_options_next_item(&list, item)) PD_TRY(pdi_read_image_options_range(r, item));
    return PD_OK;
}

/* Read the colour maps, if they are given: "grey" for all fields, "p diverging" for one; a later item replaces an
 * earlier one. drawing.map[field] is 1 + the map. PD_ERR_ARGUMENT: no such map, or a field that is not drawn. */
static pd_status pdi_read_image_options_maps(pdi_read_image_options_state *r)
{
    static const char *const names[] = {"violet", "viridis", "grey", "diverging"};
    static const pd_colour_map maps[] = {PD_COLOUR_MAP_SEQUENTIAL, PD_COLOUR_MAP_VIRIDIS, PD_COLOUR_MAP_GREY,
                                         PD_COLOUR_MAP_DIVERGING};
    const char *list;
    char item[PDI_READ_IMAGE_OPTIONS_ITEM_SIZE];
    if (!pdi_text_has_key(r->ctx, r->text, r->section, "colormap")) return PD_OK;
    PD_TRY(pdi_text_get_string(r->ctx, r->text, r->section, "colormap", NULL, &list));
    while (pdi_read_image_options_next_item(&list, item)) {
        size_t word = strcspn(item, " \t");
        int field = -1, map = 0;
        const char *name = item;
        if (item[word]) {
            item[word] = '\0';
            name = item + word + 1 + strspn(item + word + 1, " \t");
            PD_TRY(pdi_read_image_options_find_field(r, "colormap", item, &field));
        }
        while (map < 4 && strcmp(name, names[map]) != 0) map++;
        if (map == 4)
            return pdi_text_fail_key(r->ctx, r->text, r->section, "colormap",
                                     "found '%.40s', expected violet, viridis, grey or diverging, or one of them "
                                     "behind a field",
                                     name);
        for (int k = 0; k < PD_FIELD_COUNT; k++)
            if (field < 0 || k == field) r->setup->drawing.map[k] = 1 + (int)maps[map];
    }
    return PD_OK;
}

/* Read the fields drawn on a logarithmic scale as bits of drawing.log, by default none. PD_ERR_ARGUMENT: a field that
 * is not drawn or has categories. */
static pd_status pdi_read_image_options_log(pdi_read_image_options_state *r)
{
    pd_setup_image_options *drawing = &r->setup->drawing;
    PD_TRY(pdi_read_monitors_fields(r->ctx, r->text, r->setup, r->section, "log_scale", "none", &drawing->log));
    for (int k = 0; k < PD_FIELD_COUNT; k++) {
        const char *name = pd_fields_get_name(r->setup, (pd_field)k);
        int field;
        if (!(drawing->log >> k & 1u)) continue;
        PD_TRY(pdi_read_image_options_find_field(r, "log_scale", name, &field));
        if (pd_fields_get_scale((pd_field)k) == PD_FIELD_SCALE_CATEGORY)
            return pdi_text_fail_key(r->ctx, r->text, r->section, "log_scale",
                                     "found '%s', whose values have a colour each", name);
    }
    return PD_OK;
}

/* ---- lines ---- */

/* Cut the item after its first word; returns what follows. */
static char *pdi_read_image_options_split_word(char *item)
{
    size_t word = strcspn(item, " \t");
    char *from = item + word + (item[word] != '\0');
    item[word] = '\0';
    return from + strspn(from, " \t");
}

/* Parse a whole number in lo .. hi that fills the text; 0: it is none. lo is at least 1. */
static int pdi_read_image_options_parse_count(const char *from, int lo, int hi)
{
    int count = 0;
    size_t digits = strspn(from, "0123456789");
    for (size_t k = 0; k < digits && count <= hi; k++) count = 10 * count + (from[k] - '0');
    return !from[digits] && count >= lo && count <= hi ? count : 0;
}

/* 1: the word starts like a number. */
static int pdi_read_image_options_is_number(const char *word)
{
    word += strspn(word, "+-.");
    return *word >= '0' && *word <= '9';
}

/* Read contour values of a field, "100 200 mol/m3": numbers with one unit at the end, appended to drawing.contour_value
 * [SI] and counted in drawing.contours. PD_ERR_ARGUMENT: none, more than PD_SETUP_CONTOURS, or a wrong unit. */
static pd_status pdi_read_image_options_contour_values(pdi_read_image_options_state *r, const char *from, int field)
{
    pd_setup_image_options *drawing = &r->setup->drawing;
    char unit[PD_UNITS_TEXT], one[2 * PDI_READ_IMAGE_OPTIONS_ITEM_SIZE];
    const char *behind = from, *name = pd_fields_get_name(r->setup, (pd_field)field);
    pd_fields_get_unit(r->setup, (pd_field)field, unit);
    while (behind += strspn(behind, " \t"), pdi_read_image_options_is_number(behind)) behind += strcspn(behind, " \t");
    for (const char *at = from; at < behind; at += strspn(at, " \t")) {
        size_t length = strcspn(at, " \t");
        if (drawing->contours[field] == PD_SETUP_CONTOURS)
            return pdi_text_fail_key(r->ctx, r->text, r->section, "contours", "found more than %d values of '%s'",
                                     PD_SETUP_CONTOURS, name);
        snprintf(one, sizeof one, "%.*s %s", (int)length, at, behind);
        PD_TRY(pdi_read_image_options_eval_value(r, "contours", one, unit,
                                                 &drawing->contour_value[field][drawing->contours[field]++]));
        at += length;
    }
    if (drawing->contours[field] > 0) return PD_OK;
    return pdi_text_fail_key(r->ctx, r->text, r->section, "contours",
                             "found no value behind '%s at', expected some: "
                             "%s at 1 2 %s",
                             name, name, unit);
}

/* Check that lines can be drawn over the image of a field. PD_ERR_ARGUMENT: it is a field in the metal and
 * displacements are magnified, so that it is drawn in the deformed configuration. */
static pd_status pdi_read_image_options_check_undeformed(pdi_read_image_options_state *r, const char *key, int field)
{
    const char *name = pd_fields_get_name(r->setup, (pd_field)field);
    if (!pd_fields_is_in_metal(r->setup, (pd_field)field) || !(r->setup->displacement_scale > 0.0)) return PD_OK;
    return pdi_text_fail_key(r->ctx, r->text, r->section, key,
                             "found '%s', which 'deformation_scale' draws where the metal has "
                             "moved to, expected a field of the fluid",
                             name);
}

/* Read one item of the contours: "C 8" (number of lines, 1 to PD_SETUP_CONTOURS) or "C at 100 200 mol/m3" (values).
 * item is cut apart. PD_ERR_ARGUMENT: a field that is not drawn, has categories, has contours already or is drawn
 * deformed. */
static pd_status pdi_read_image_options_contour(pdi_read_image_options_state *r, char *item)
{
    pd_setup_image_options *drawing = &r->setup->drawing;
    char unit[PD_UNITS_TEXT];
    int field;
    char *from = pdi_read_image_options_split_word(item);
    PD_TRY(pdi_read_image_options_find_field(r, "contours", item, &field));
    PD_TRY(pdi_read_image_options_check_undeformed(r, "contours", field));
    if (pd_fields_get_scale((pd_field)field) == PD_FIELD_SCALE_CATEGORY)
        return pdi_text_fail_key(r->ctx, r->text, r->section, "contours", "found '%s', whose values have a colour each",
                                 item);
    if (drawing->contours[field])
        return pdi_text_fail_key(r->ctx, r->text, r->section, "contours", "found '%s' twice", item);
    if (strncmp(from, "at", 2) == 0 && (from[2] == ' ' || from[2] == '\t' || from[2] == '\0')) {
        drawing->has_contour_values[field] = 1;
        return pdi_read_image_options_contour_values(r, from + 2 + strspn(from + 2, " \t"), field);
    }
    drawing->contours[field] = pdi_read_image_options_parse_count(from, 1, PD_SETUP_CONTOURS);
    if (drawing->contours[field]) return PD_OK;
    pd_fields_get_unit(r->setup, (pd_field)field, unit);
    return pdi_text_fail_key(r->ctx, r->text, r->section, "contours",
                             "found '%.60s' behind '%s', expected a number of "
                             "lines from 1 to %d, or values: %s at 1 2 %s",
                             from, item, PD_SETUP_CONTOURS, item, unit);
}

/* Read the contour lines of all fields. */
static pd_status pdi_read_image_options_contours(pdi_read_image_options_state *r)
{
    const char *list;
    char item[PDI_READ_IMAGE_OPTIONS_ITEM_SIZE];
    if (!pdi_text_has_key(r->ctx, r->text, r->section, "contours")) return PD_OK;
    PD_TRY(pdi_text_get_string(r->ctx, r->text, r->section, "contours", NULL, &list));
    while (pdi_read_image_options_next_item(&list, item)) PD_TRY(pdi_read_image_options_contour(r, item));
    return PD_OK;
}

/* Read the fields over which streamlines or arrows are drawn, "v, C 40", if the key is given; across[field]: how many
 * fit side by side, `usual` by default, 0 where none are drawn. PD_ERR_ARGUMENT: the scene has no velocity, a field is
 * not drawn, is listed twice or drawn deformed, or the number is out of bounds. */
static pd_status pdi_read_image_options_flow_lines(pdi_read_image_options_state *r, const char *key, int usual,
                                                   int *across)
{
    const char *list;
    char item[PDI_READ_IMAGE_OPTIONS_ITEM_SIZE];
    int field;
    if (!pdi_text_has_key(r->ctx, r->text, r->section, key)) return PD_OK;
    if (pd_fields_lacks(r->setup, PD_FIELD_V))
        return pdi_text_fail_key(r->ctx, r->text, r->section, key, "found without %s",
                                 pd_fields_lacks(r->setup, PD_FIELD_V));
    PD_TRY(pdi_text_get_string(r->ctx, r->text, r->section, key, NULL, &list));
    while (pdi_read_image_options_next_item(&list, item)) {
        const char *from = pdi_read_image_options_split_word(item);
        PD_TRY(pdi_read_image_options_find_field(r, key, item, &field));
        PD_TRY(pdi_read_image_options_check_undeformed(r, key, field));
        if (across[field]) return pdi_text_fail_key(r->ctx, r->text, r->section, key, "found '%s' twice", item);
        across[field] =
            *from ? pdi_read_image_options_parse_count(from, PD_FIELD_PLOT_MIN_DENSITY, PD_FIELD_PLOT_MAX_DENSITY)
                  : usual;
        if (!across[field])
            return pdi_text_fail_key(r->ctx, r->text, r->section, key,
                                     "found '%.60s' behind '%s', expected how many fit "
                                     "side by side, from %d to %d",
                                     from, item, PD_FIELD_PLOT_MIN_DENSITY, PD_FIELD_PLOT_MAX_DENSITY);
    }
    return PD_OK;
}

/* ---- the surface of the metal ---- */

/* Read the 3D view of the metal surface and its direction: drawing.surface is 0 for "no", 1 for "yes", 2 + the field
 * that colours it, which then counts as drawn. PD_ERR_ARGUMENT: not in 3D, no solid, a field that does not exist, the
 * kind or the phase, a view that is zero or has not three numbers, or a view without the surface. */
static pd_status pdi_read_image_options_surface(pdi_read_image_options_state *r)
{
    pd_setup_image_options *drawing = &r->setup->drawing;
    const char *word;
    int count = 3, k = 0;
    PD_TRY(pdi_text_get_string(r->ctx, r->text, r->section, "surface", "no", &word));
    PD_TRY(
        pdi_text_get_numbers(r->ctx, r->text, r->section, "view", "", "1, -1, 1", 3, drawing->view_direction, &count));
    if (count != 3 ||
        !(fabs(drawing->view_direction[0]) + fabs(drawing->view_direction[1]) + fabs(drawing->view_direction[2]) > 0.0))
        return pdi_text_fail_key(r->ctx, r->text, r->section, "view",
                                 "found no direction, expected three numbers, for "
                                 "example 1, -1, 1");
    if (strcmp(word, "no") == 0 && pdi_text_has_key(r->ctx, r->text, r->section, "view"))
        return pdi_text_fail_key(r->ctx, r->text, r->section, "view", "found without 'surface'");
    if (strcmp(word, "no") == 0) return PD_OK;
    if (PD_DIM != 3)
        return pdi_text_fail_key(r->ctx, r->text, r->section, "surface", "found in %dD, expected it in 3D", PD_DIM);
    if (r->setup->solid < 0)
        return pdi_text_fail_key(r->ctx, r->text, r->section, "surface", "found without a [shape] of kind = solid");
    drawing->surface = 1;
    if (strcmp(word, "yes") == 0) return PD_OK;
    while (k < PD_FIELD_COUNT && strcmp(word, pd_fields_get_name(r->setup, (pd_field)k)) != 0) k++;
    if (k == PD_FIELD_COUNT || k == PD_FIELD_KIND || k == PD_FIELD_PHASE)
        return pdi_text_fail_key(r->ctx, r->text, r->section, "surface",
                                 "found '%.40s', expected yes, no or a field "
                                 "with values on the surface of the metal",
                                 word);
    if (pd_fields_lacks(r->setup, (pd_field)k))
        return pdi_text_fail_key(r->ctx, r->text, r->section, "surface", "found '%s', which needs %s", word,
                                 pd_fields_lacks(r->setup, (pd_field)k));
    drawing->surface = 2 + k;
    r->drawn_fields |= pd_fields_bit(k);
    return PD_OK;
}

/* Read the image formats as bits of drawing.formats: 0 for png, the default, 1 for svg. PD_ERR_ARGUMENT: another
 * word. */
static pd_status pdi_read_image_options_formats(pdi_read_image_options_state *r)
{
    static const char *const names[] = {"png", "svg"};
    pd_word_list list;
    PD_TRY(pdi_text_get_words(r->ctx, r->text, r->section, "format", "png", &list));
    for (int w = 0; w < list.count; w++) {
        unsigned k = 0;
        while (k < 2 && strcmp(list.word[w], names[k]) != 0) k++;
        if (k == 2)
            return pdi_text_fail_key(r->ctx, r->text, r->section, "format", "found '%s', expected png, svg or both",
                                     list.word[w]);
        r->setup->drawing.formats |= 1u << k;
    }
    return PD_OK;
}

/* Read the options of images of planes: maps, contours, streamlines, arrows, cells, width. Lines are drawn over fields
 * of `images` alone, not over one that only colours the surface. PD_ERR_ARGUMENT: one of these keys in 1D, where
 * nothing is read. */
static pd_status pdi_read_image_options_plane_images(pdi_read_image_options_state *r)
{
    static const char *const keys[] = {"colormap", "width", "cells", "contours", "streamlines", "vectors"};
    pd_setup_image_options *drawing = &r->setup->drawing;
    for (int k = 0; PD_DIM == 1 && k < 6; k++)
        if (pdi_text_has_key(r->ctx, r->text, r->section, keys[k]))
            return pdi_text_fail_key(r->ctx, r->text, r->section, keys[k],
                                     "found in 1D, where images are curves, expected it in 2D and 3D");
    if (PD_DIM == 1) return PD_OK;
    PD_TRY(pdi_read_image_options_maps(r));
    r->drawn_fields = r->setup->images;
    PD_TRY(pdi_read_image_options_contours(r));
    PD_TRY(pdi_read_image_options_flow_lines(r, "streamlines", PDI_READ_IMAGE_OPTIONS_DEFAULT_STREAMLINES,
                                             drawing->streamlines));
    PD_TRY(pdi_read_image_options_flow_lines(r, "vectors", PDI_READ_IMAGE_OPTIONS_DEFAULT_VECTORS, drawing->vectors));
    PD_TRY(pdi_key_value_get_index(r->ctx, r->text, r->section, "cells", &drawing->smooth));
    return pdi_key_value_get_index(r->ctx, r->text, r->section, "width", &drawing->width);
}

/* Where nothing is drawn, mark the other image options as read, so that they have no effect with images = none.
 * PD_ERR_ARGUMENT: one of them is given without the key `images`. */
static pd_status pdi_read_image_options_check_unused(pdi_read_image_options_state *r)
{
    static const char *const keys[] = {"range", "percentile", "log_scale", "colormap",    "width",
                                       "cells", "animate",    "contours",  "streamlines", "vectors"};
    const char *value;
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        if (!pdi_text_has_key(r->ctx, r->text, r->section, keys[k])) continue;
        if (!pdi_text_has_key(r->ctx, r->text, r->section, "images"))
            return pdi_text_fail_key(r->ctx, r->text, r->section, keys[k],
                                     "found without 'images', the fields that are drawn");
        PD_TRY(pdi_text_get_string(r->ctx, r->text, r->section, keys[k], NULL, &value));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_read_image_options_read(pd_ctx *ctx, pd_text *text, int section, pd_setup *setup)
{
    pdi_read_image_options_state r;
    r.ctx = ctx;
    r.text = text;
    r.setup = setup;
    r.section = section;
    r.drawn_fields = setup->images;
    PD_TRY(pdi_read_image_options_formats(&r));
    PD_TRY(pdi_read_image_options_surface(&r));
    if (!setup->images && pdi_text_has_key(ctx, text, section, "images")) setup->drawing.surface = 0;
    if (!setup->images && !setup->drawing.surface) return pdi_read_image_options_check_unused(&r);
    PD_TRY(pdi_read_image_options_log(&r));
    PD_TRY(pdi_read_image_options_ranges(&r));
    PD_TRY(pdi_read_image_options_plane_images(&r));
    PD_TRY(pdi_key_value_get_index(ctx, text, section, "animate", &setup->drawing.animate));
    /* a number without its unit is the likely mistake: the message has one */
    PD_TRY(pdi_text_get_number(ctx, text, section, "percentile", "", "100 %", &setup->drawing.percentile));
    if (setup->drawing.percentile > 0.0 && setup->drawing.percentile <= 1.0) return PD_OK;
    return pdi_text_fail_key(ctx, text, section, "percentile",
                             "found %.6g %%, expected a share above 0 and up to 100 %%",
                             100.0 * setup->drawing.percentile);
}

#undef PDI_READ_IMAGE_OPTIONS_ITEM_SIZE
#undef PDI_READ_IMAGE_OPTIONS_DEFAULT_STREAMLINES
#undef PDI_READ_IMAGE_OPTIONS_DEFAULT_VECTORS
