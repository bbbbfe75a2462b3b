/* scene: see scene.h */
#include "scene.h"
#include "random.h"
#include "io/png.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const char *const axis_names[3] = {"x", "y", "z"};
char scene_folder[256] = ".";

typedef struct unit_text {
    const char *text;
    double size; /* in the SI */
} unit_text;

/* The first text is that of the SI. Current is per depth. */
static const struct unit_row {
    dimension of;
    unit_text text[4];
} unit_table[UNIT_COUNT] = {
    {{{0, 0, 0, 0, 0, 0}}, {{"", 1.0}, {NULL, 0.0}}},
    {{{1, 0, 0, 0, 0, 0}}, {{"m", 1.0}, {"um", 1e-6}, {"mm", 1e-3}, {"nm", 1e-9}}},
    {{{0, 0, 1, 0, 0, 0}}, {{"s", 1.0}, {"min", 60.0}, {"h", 3600.0}, {"ms", 1e-3}}},
    {{{1, 0, -1, 0, 0, 0}}, {{"m/s", 1.0}, {"mm/s", 1e-3}, {"um/h", 1e-6 / 3600.0}, {"nm/s", 1e-9}}},
    {{{2, 0, -1, 0, 0, 0}}, {{"m2/s", 1.0}, {"mm2/s", 1e-6}, {"cm2/s", 1e-4}, {"um2/s", 1e-12}}},
    {{{-3, 0, 0, 1, 0, 0}}, {{"mol/m3", 1.0}, {"mol/L", 1e3}, {"mM", 1.0}, {"umol/cm3", 1.0}}},
    {{{0, 0, -1, 0, 0, 0}}, {{"1/s", 1.0}, {"1/min", 1.0 / 60.0}, {"1/h", 1.0 / 3600.0}, {NULL, 0.0}}},
    {{{-2, 0, 0, 0, 1, 0}}, {{"A/m2", 1.0}, {"mA/cm2", 10.0}, {"uA/cm2", 1e-2}, {"A/cm2", 1e4}}},
    {{{0, 0, 0, 0, 1, 0}}, {{"A", 1.0}, {"mA", 1e-3}, {"uA", 1e-6}, {NULL, 0.0}}},
    {{{2, 1, -3, 0, -1, 0}}, {{"V", 1.0}, {"mV", 1e-3}, {NULL, 0.0}}},
    {{{-3, -1, 3, 0, 2, 0}}, {{"S/m", 1.0}, {"S/cm", 100.0}, {"mS/cm", 0.1}, {NULL, 0.0}}},
    {{{4, 1, -3, 0, -2, 0}}, {{"ohm m2", 1.0}, {"ohm cm2", 1e-4}, {NULL, 0.0}}},
    {{{-1, 1, -2, 0, 0, 0}}, {{"Pa", 1.0}, {"MPa", 1e6}, {"GPa", 1e9}, {"kPa", 1e3}}},
    {{{-3, 1, 0, 0, 0, 0}}, {{"kg/m3", 1.0}, {"g/cm3", 1e3}, {NULL, 0.0}}},
    {{{-1, 1, -1, 0, 0, 0}}, {{"Pa s", 1.0}, {"mPa s", 1e-3}, {NULL, 0.0}}},
    {{{1, 0, -2, 0, 0, 0}}, {{"m/s2", 1.0}, {"mm/s2", 1e-3}, {NULL, 0.0}}},
    {{{-2, 1, -2, 0, 0, 0}}, {{"N/m3", 1.0}, {"N/cm3", 1e6}, {NULL, 0.0}}},
    {{{0, 1, -2, 0, 0, 0}}, {{"J/m2", 1.0}, {"mJ/m2", 1e-3}, {NULL, 0.0}}},
    {{{-2, 0, -1, 1, 0, 0}}, {{"mol/m2/s", 1.0}, {"mol/cm2/s", 1e4}, {NULL, 0.0}}},
    {{{-1, 0, 0, 0, 0, 0}}, {{"1/m", 1.0}, {"1/mm", 1e3}, {NULL, 0.0}}},
    {{{3, 0, 0, -1, 0, 0}}, {{"m3/mol", 1.0}, {"cm3/mol", 1e-6}, {NULL, 0.0}}},
    {{{3, 0, -1, -1, 0, 0}}, {{"m3/mol/s", 1.0}, {"L/mol/s", 1e-3}, {NULL, 0.0}}},
    {{{0, 0, 0, 0, 0, 1}}, {{"K", 1.0}, {NULL, 0.0}}},
    {{{3, 0, -1, 0, 0, 0}}, {{"m3/s", 1.0}, {"mm3/s", 1e-9}, {"L/min", 1e-3 / 60.0}, {NULL, 0.0}}},
};

dimension unit_dimension(unit of)
{
    dimension d = unit_table[of].of;
    if (of == UNIT_CURRENT) d.e[0] -= 3 - PD_DIM; /* per m of depth, per m2 */
    return d;
}

void scene_begin(scene *x) { memset(x, 0, sizeof *x); }

int scene_section(scene *x, const char *name, const char *label)
{
    if (x->sections == SCENE_SECTIONS) {
        x->full = 1;
        return 0;
    }
    section *s = &x->part[x->sections];
    memset(s, 0, sizeof *s);
    snprintf(s->name, sizeof s->name, "%s", name);
    snprintf(s->label, sizeof s->label, "%s", label);
    s->axis = -1;
    return x->sections++;
}

int scene_side(scene *x, int axis, int plus)
{
    for (int k = 0; k < x->sections; k++)
        if (x->part[k].axis == axis && x->part[k].plus == plus) return k;
    int s = scene_section(x, "side", "");
    x->part[s].axis = axis;
    x->part[s].plus = plus;
    return s;
}

static token *scene_token(scene *x, token_kind kind)
{
    if (x->tokens == SCENE_TOKENS) {
        x->full = 1;
        x->tokens--;
    }
    token *t = &x->pool[x->tokens++];
    memset(t, 0, sizeof *t);
    t->kind = kind;
    t->sign = 1;
    return t;
}

static void scene_text(scene *x, const char *text, size_t length)
{
    while (length) {
        token *t = scene_token(x, TOKEN_TEXT);
        size_t part = length < sizeof t->text - 1 ? length : sizeof t->text - 1;
        memcpy(t->text, text, part);
        text += part;
        length -= part;
    }
}

static void scene_place(scene *x, int axis)
{
    token *t = scene_token(x, TOKEN_PLACE);
    t->axis = axis;
    t->origin = x->low[axis];
    t->length = x->h[axis];
}

static void scene_format(scene *x, const char *format, va_list list)
{
    char text[64];
    while (*format) {
        size_t plain = strcspn(format, "%");
        scene_text(x, format, plain);
        format += plain;
        if (!*format) break;
        char what = format[1];
        format += 2;
        if (what == 'q') {
            token *t = scene_token(x, TOKEN_NUMBER);
            t->value = va_arg(list, double);
            t->of = (unit)va_arg(list, int);
        } else if (what == 'p') {
            scene_place(x, va_arg(list, int));
        } else if (what == 's') {
            const char *s = va_arg(list, const char *);
            scene_text(x, s, strlen(s));
        } else if (what == 'g') {
            snprintf(text, sizeof text, "%.6g", va_arg(list, double));
            scene_text(x, text, strlen(text));
        } else if (what == 'i') {
            snprintf(text, sizeof text, "%d", va_arg(list, int));
            scene_text(x, text, strlen(text));
        }
    }
}

static entry *scene_entry(scene *x, int s, const char *key, entry_kind kind)
{
    if (x->entries == SCENE_ENTRIES) {
        x->full = 1;
        x->entries--;
    }
    entry *e = &x->list[x->entries++];
    memset(e, 0, sizeof *e);
    snprintf(e->key, sizeof e->key, "%s", key);
    e->kind = kind;
    e->section = s;
    e->sign = 1;
    for (int d = 0; d < 3; d++) e->rotated[d] = 1;
    return e;
}

static void scene_fill(scene *x, entry *e, int k, const char *format, va_list list)
{
    e->first[k] = x->tokens;
    scene_format(x, format, list);
    e->count[k] = x->tokens - e->first[k];
}

void scene_key(scene *x, int s, const char *key, const char *format, ...)
{
    va_list list;
    entry *e = scene_entry(x, s, key, ENTRY_PLAIN);
    va_start(list, format);
    scene_fill(x, e, 0, format, list);
    va_end(list);
}

void scene_component(scene *x, int s, const char *key, int axis, const char *format, ...)
{
    va_list list;
    entry *e = scene_entry(x, s, key, ENTRY_COMPONENT);
    e->axis = axis;
    va_start(list, format);
    scene_fill(x, e, 0, format, list);
    va_end(list);
}

void scene_vector(scene *x, int s, const char *key, int axis, const char *format, ...)
{
    va_list list;
    entry *e = scene_find(x, s, key);
    if (!e) e = scene_entry(x, s, key, ENTRY_VECTOR);
    va_start(list, format);
    scene_fill(x, e, axis, format, list);
    va_end(list);
}

void scene_sizes(scene *x, int s, const char *key, const double *sizes)
{
    entry *e = scene_entry(x, s, key, ENTRY_SIZES);
    for (int d = 0; d < PD_DIM; d++) e->low[d] = sizes[d];
}

void scene_point(scene *x, int s, const char *key, const double *at)
{
    entry *e = scene_entry(x, s, key, ENTRY_POINT);
    for (int d = 0; d < PD_DIM; d++) e->low[d] = at[d];
}

void scene_box(scene *x, int s, const char *key, const double *low, const double *high)
{
    entry *e = scene_entry(x, s, key, ENTRY_BOX);
    for (int d = 0; d < PD_DIM; d++) {
        e->low[d] = low[d];
        e->high[d] = high[d];
    }
}

void scene_plane(scene *x, int s, const char *key, int axis, double at)
{
    entry *e = scene_entry(x, s, key, ENTRY_PLANE);
    e->axis = axis;
    e->low[0] = at;
}

void scene_axis(scene *x, int s, const char *key, int axis)
{
    entry *e = scene_entry(x, s, key, ENTRY_AXIS);
    e->axis = axis;
}

void scene_corner(scene *x, int s, const char *key, const double *at)
{
    entry *e = scene_find(x, s, key);
    if (!e) e = scene_entry(x, s, key, ENTRY_CORNERS);
    if (e->corners == SCENE_CORNERS) {
        x->full = 1;
        return;
    }
    for (int d = 0; d < PD_DIM; d++) e->corner[e->corners][d] = at[d];
    e->corners++;
}

void scene_direction(scene *x, int s, const char *key, const double *along)
{
    entry *e = scene_entry(x, s, key, ENTRY_DIRECTION);
    for (int d = 0; d < PD_DIM; d++) e->low[d] = along[d];
}

void scene_voxels(scene *x, int s, int image)
{
    entry *e = scene_entry(x, s, "raw", ENTRY_VOXELS);
    e->image = image;
    for (int d = 0; d < PD_DIM; d++) {
        e->low[d] = x->low[d];
        e->high[d] = x->low[d] + x->cells[d] * x->h[d];
    }
}

entry *scene_find(scene *x, int s, const char *key)
{
    for (int k = 0; k < x->entries; k++)
        if (x->list[k].section == s && strcmp(x->list[k].key, key) == 0) return &x->list[k];
    return NULL;
}

int scene_physics(const scene *x)
{
    const uint32_t each = HAS_FLOW | HAS_TRANSPORT | HAS_DISSOLVE | HAS_CORRODE | HAS_CHEMISTRY | HAS_MINERAL |
                          HAS_STATE | HAS_MIGRATION | HAS_POTENTIAL | HAS_SOLID | HAS_GAS | HAS_GRAINS | HAS_MEDIUM;
    int count = 0;
    for (uint32_t bits = x->has & each; bits; bits &= bits - 1) count++;
    return count;
}

/* ---- text ---- */

typedef struct writer {
    char *text;
    size_t size, used;
    uint32_t units; /* state of the draw of units; 0: the SI */
} writer;

static void put(writer *w, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int n = vsnprintf(w->text + w->used, w->size - w->used, format, list);
    va_end(list);
    if (n < 0 || w->used + (size_t)n >= w->size) w->used = w->size - 1;
    else w->used += (size_t)n;
}

static void put_number(writer *w, double value, unit of)
{
    const unit_text *list = unit_table[of].text;
    int count = 0, k = 0;
    while (count < 4 && list[count].text) count++;
    if (w->units) k = (int)(random_share(&w->units) * count);
    const char *depth = of != UNIT_CURRENT || PD_DIM == 3 ? "" : PD_DIM == 2 ? "/m" : "/m2";
    if (of == UNIT_ONE) put(w, "%.17g", value);
    else put(w, "%.17g %s%s", value / list[k].size, list[k].text, depth);
}

static void put_tokens(writer *w, const scene *x, const entry *e, int part)
{
    for (int k = 0; k < e->count[part]; k++) {
        const token *t = &x->pool[e->first[part] + k];
        if (t->kind == TOKEN_TEXT) put(w, "%s", t->text);
        else if (t->kind == TOKEN_NUMBER && e->count[part] == 1) put_number(w, t->value, t->of);
        else if (t->kind == TOKEN_NUMBER) {
            put(w, "(");
            put_number(w, t->value, t->of);
            put(w, ")");
        } else {
            put(w, "(%s", t->sign < 0 ? "-" : "");
            if (t->fold) {
                put(w, "(abs(%s - (", axis_names[t->axis]);
                put_number(w, t->plane, UNIT_LENGTH);
                put(w, ")) - (");
            } else put(w, "(%s - (", axis_names[t->axis]);
            put_number(w, t->origin, UNIT_LENGTH);
            put(w, "))/(");
            put_number(w, t->length, UNIT_LENGTH);
            put(w, "))");
        }
    }
}

/* Signs of vectors stand around the expression. */
static void put_signed(writer *w, const scene *x, const entry *e, int part, int axis, int sign)
{
    int odd = e->odd == axis + 1;
    if (odd) {
        put(w, "if(%s < ", axis_names[axis]);
        put_number(w, e->plane, UNIT_LENGTH);
        put(w, ", -1, 1)*(");
    }
    if (sign < 0) put(w, "-(");
    put_tokens(w, x, e, part);
    put(w, "%s%s", sign < 0 ? ")" : "", odd ? ")" : "");
}

/* What the third axis adds to an entry of a layer. */
static void put_layer(writer *w, const scene *x, const entry *e)
{
    int grid = e->section == x->grid;
    if (e->kind == ENTRY_VECTOR || e->kind == ENTRY_DIRECTION) put(w, ", 0");
    if (e->kind != ENTRY_SIZES && e->kind != ENTRY_POINT && e->kind != ENTRY_BOX) return;
    put(w, ", ");
    if (e->kind == ENTRY_SIZES) put_number(w, x->h[0], UNIT_LENGTH);
    else if (e->kind == ENTRY_POINT) put_number(w, 0.5 * x->h[0], UNIT_LENGTH);
    else {
        put_number(w, grid ? 0.0 : -8.0 * x->h[0], UNIT_LENGTH);
        put(w, " .. ");
        put_number(w, (grid ? 1.0 : 9.0) * x->h[0], UNIT_LENGTH);
    }
}

static void write_image(const voxels *v, const char *path)
{
    pd_ctx ctx;
    uint8_t pixel[SCENE_VOXELS];
    pd_image image = {v->n[0], v->n[1], 1, pixel};
    pd_ctx_init(&ctx);
    for (int row = 0; row < v->n[1]; row++) /* the first one on top */
        for (int k = 0; k < v->n[0]; k++)
            pixel[row * v->n[0] + k] = v->inside[(v->n[1] - 1 - row) * v->n[0] + k] ? 255 : 0;
    if (pd_png_write(&ctx, path, &image) < 0) fprintf(stderr, "metamorphic: %s\n", ctx.message);
}

/* The file, its name by what is in it, and the keys that name it; what it holds stands in a comment. */
static void put_voxels(writer *w, const scene *x, const entry *e)
{
    const voxels *v = &x->mask;
    int count = 1, image = PD_DIM == 2 && e->image && !x->layer;
    uint32_t name = 2166136261u;
    char path[320];
    for (int d = 0; d < PD_DIM; d++) count *= v->n[d];
    for (int k = 0; k < count; k++) name = (name ^ v->inside[k]) * 16777619u;
    snprintf(path, sizeof path, "%s/%08x_%d.%s", scene_folder, (unsigned)name, v->n[0], image ? "png" : "raw");
    put(w, "# ");
    for (int k = 0; k < count; k++) put(w, "%d%s", v->inside[k], (k + 1) % v->n[0] ? "" : k + 1 < count ? " " : "\n");
    if (image) write_image(v, path);
    else {
        FILE *file = fopen(path, "wb");
        if (!file || fwrite(v->inside, 1, (size_t)count, file) != (size_t)count || fclose(file) != 0)
            fprintf(stderr, "metamorphic: cannot write %s\n", path);
    }
    put(w, "%s = %s\n", image ? "mask" : "raw", path);
    if (!image) {
        put(w, "size = ");
        for (int d = 0; d < PD_DIM; d++) put(w, "%s%d", d ? ", " : "", v->n[d]);
        put(w, "%s\n", x->layer ? ", 1" : "");
    }
    put(w, "corner = ");
    for (int d = 0; d < PD_DIM; d++) {
        put(w, "%s", d ? ", " : "");
        put_number(w, e->low[d], UNIT_LENGTH);
    }
    if (x->layer) put(w, ", 0 m");
    put(w, "\ncell = ");
    for (int d = 0; d < PD_DIM; d++) {
        put(w, "%s", d ? ", " : "");
        put_number(w, (e->high[d] - e->low[d]) / v->n[d], UNIT_LENGTH);
    }
    if (x->layer) {
        put(w, ", ");
        put_number(w, x->h[0], UNIT_LENGTH);
    }
    put(w, "\n");
}

static void put_entry(writer *w, const scene *x, const entry *e)
{
    if (e->kind == ENTRY_VOXELS) {
        put_voxels(w, x, e);
        return;
    }
    if (x->layer && strcmp(e->key, "ball") == 0) {
        put(w, "cylinder = z   centre = ");
        put_number(w, e->low[0], UNIT_LENGTH);
        put(w, ", ");
        put_number(w, e->low[1], UNIT_LENGTH);
        put(w, ", 0\n");
        return;
    }
    if (e->kind == ENTRY_COMPONENT) put(w, "%s%s = ", e->key, axis_names[e->axis]);
    else put(w, "%s = ", e->key);
    if (e->kind == ENTRY_PLAIN) put_tokens(w, x, e, 0);
    if (e->kind == ENTRY_COMPONENT) put_signed(w, x, e, 0, e->axis, e->sign);
    if (e->kind == ENTRY_AXIS) put(w, "%s", axis_names[e->axis]);
    if (e->kind == ENTRY_PLANE) {
        put(w, "%s ", axis_names[e->axis]);
        put_number(w, e->low[0], UNIT_LENGTH);
    }
    for (int d = 0; d < PD_DIM; d++) {
        const char *comma = d ? ", " : "";
        if (e->kind == ENTRY_VECTOR) {
            put(w, "%s", comma);
            put_signed(w, x, e, d, d, e->rotated[d]);
        }
        if (e->kind == ENTRY_SIZES || e->kind == ENTRY_POINT || e->kind == ENTRY_BOX) {
            put(w, "%s", comma);
            put_number(w, e->low[d], UNIT_LENGTH);
        }
        if (e->kind == ENTRY_BOX) {
            put(w, " .. ");
            put_number(w, e->high[d], UNIT_LENGTH);
        }
    }
    for (int k = 0; k < e->corners; k++)
        for (int d = 0; d < PD_DIM; d++) {
            put(w, "%s", k || d ? ", " : "");
            put_number(w, e->corner[k][d], UNIT_LENGTH);
        }
    for (int d = 0; d < PD_DIM && e->kind == ENTRY_DIRECTION; d++) put(w, "%s%.17g", d ? ", " : "", e->low[d]);
    if (x->layer) put_layer(w, x, e);
    put(w, "\n");
    if (x->ring && e->section == x->grid && strcmp(e->key, "box") == 0) put(w, "geometry = axisymmetric\n");
}

size_t scene_write(const scene *x, char *text, size_t size)
{
    writer w = {text, size, 0, (uint32_t)x->other_units};
    text[0] = '\0';
    for (int s = 0; s < x->sections; s++) {
        const section *p = &x->part[s];
        if (p->gone) continue;
        if (p->axis >= 0) put(&w, "[side %s%s]\n", axis_names[p->axis], p->plus ? "+" : "-");
        else put(&w, "[%s%s%s]", p->name, p->label[0] ? " " : "", p->label);
        int first = p->axis < 0;
        for (int k = 0; k < x->entries; k++) {
            const entry *e = &x->list[k];
            if (e->section != s || !e->key[0]) continue;
            if (first) put(&w, "%s", e->key[0] == '=' ? " " : "\n");
            first = 0;
            if (e->key[0] == '=') { /* the text of a reaction */
                put_tokens(&w, x, e, 0);
                put(&w, "\n");
            } else put_entry(&w, x, e);
        }
        if (first) put(&w, "\n");
    }
    if (x->layer) put(&w, "[side z-]\nflow = mirror\n[side z+]\nflow = mirror\n");
    return w.used + 1 < size && !x->full ? w.used : 0;
}

void scene_shorten(scene *x, double share)
{
    x->until *= share;
    for (int j = 0; j < x->entries; j++) {
        entry *e = &x->list[j];
        if ((strcmp(e->key, "until") == 0 || strcmp(e->key, "every") == 0) && e->count[0] == 1)
            x->pool[e->first[0]].value *= share;
    }
}
