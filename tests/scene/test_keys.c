/* The table of keys: it is that of the guide, and the parser takes every key of it. With PD_DEBUG every look-up of a
 * reader is held against its units and defaults, so that each scene of each test checks them (pdi_text_find_value).
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"
#include "scene/keys.h"
#include "scene/read_electrolyte.h"
#include "scene/scene.h"
#include "scene/template.h"
#include "io/png.h"
#include <dirent.h>

/* ---- the guide ---- */

/* "| `vx`, `vy` | meaning | unit | default |" */
static void row_of(const pd_key *key, char *row, size_t size)
{
    size_t used = 0;
    for (const char *at = key->keys; *at; at += strspn(at, ", ")) {
        size_t length = strcspn(at, ",");
        used += (size_t)snprintf(row + used, size - used, "%s`%.*s`", used ? ", " : "| ", (int)length, at);
        at += length;
    }
    snprintf(row + used, size - used, " | %s | %s | %s |\n", key->meaning, key->unit, key->default_text);
}

/* 1 when the line at `at` begins a table of keys. */
static int heads(const char *at) { return strncmp(at, "| key | meaning | unit | default |\n", 35) == 0; }

/* Rows of tables of keys in chapter 2 of the guide. */
static int rows_of(const char *guide)
{
    int rows = 0, inside = 0;
    for (const char *at = guide; *at; at = strchr(at, '\n') + 1) {
        rows += inside && *at == '|' && strncmp(at, "|---", 4) != 0;
        inside = heads(at) || (inside && *at == '|');
    }
    return rows;
}

TEST(guide)
{
    pd_ctx ctx;
    char *guide = NULL, row[2048], title[64];
    size_t size = 0;
    int count, rows = 0;
    const pd_key_section *s = pd_key_sections(&count);
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, "docs/guide.md", 1 << 20, &guide, &size))) return;
    char *from = strstr(guide, "\n## 2 "), *to = strstr(guide, "\n## 3 ");
    if (CHECK(from && to && from < to)) {
        to[1] = '\0';
        for (int k = 0; k < count; k++) {
            snprintf(title, sizeof title, "`[%s", s[k].name);
            const char *at = strstr(from, title);
            CHECK(at != NULL);
            for (int i = 0; at && i < s[k].count && strcmp(s[k].key[i].unit, "any") != 0; i++, rows++) {
                row_of(&s[k].key[i], row, sizeof row);
                const char *found = strstr(at, row); /* in the order of the table */
                if (!CHECK(found != NULL)) NOTE("[%s]: docs/guide.md lacks, or has elsewhere: %s", s[k].name, row);
                else at = found;
            }
        }
        CHECK_INT(rows_of(from), rows);
    }
    PD_DELETE(&ctx, size + 1, guide);
}

/* ---- types ---- */

/* A default that is a value, what stands before ; or :, is one of its type and within its bounds. */
static void check_default(const pd_key_section *s, const pd_key *key)
{
    char text[96];
    pd_ctx ctx;
    pd_expr value;
    pd_expr_desc desc;
    size_t length = strcspn(key->default_text, ";:");
    pd_ctx_init(&ctx);
    memset(&desc, 0, sizeof desc);
    snprintf(text, sizeof text, "%.*s", (int)length, key->default_text);
    int is_value = strchr("-.0123456789", text[0]) && strcmp(text, "-") != 0;
    if (!is_value || strpbrk(text, "y,`") || strstr(text, "rtol")) return; /* it says where the value comes from */
    desc.text = text;
    desc.unit = strcmp(key->unit, "-") == 0 ? "" : key->unit;
    if (!CHECK_OK(&ctx, pd_expr_build(&ctx, &desc, &value))) {
        NOTE("%s.%s: %s", s->name, key->keys, key->default_text);
        return;
    }
    double x = pd_expr_eval(&value, NULL);
    if (!CHECK((key->low_is_open ? x > key->low : x >= key->low) && x <= key->high))
        NOTE("%s.%s: %g is not in its bounds", s->name, key->keys, x);
    pd_expr_free(&ctx, &value);
}

TEST(types)
{
    int count, numbers = 0, choices = 0;
    const pd_key_section *s = pd_key_sections(&count);
    for (int k = 0; k < count; k++)
        for (int i = 0; i < s[k].count; i++) {
            const pd_key *key = &s[k].key[i];
            int is_choice = key->type == PD_KEY_CHOICE,
                is_number = key->type == PD_KEY_NUMBER || key->type == PD_KEY_WHOLE;
            numbers += is_number;
            choices += is_choice;
            CHECK((key->choices != NULL) == is_choice);
            if (is_number) CHECK(key->low < key->high);
            if (is_number) check_default(&s[k], key);
            for (const char *at = is_choice ? key->choices : ""; *at; at += strspn(at, ", ")) {
                char word[40];
                size_t length = strcspn(at, ",");
                snprintf(word, sizeof word, "%.*s", (int)length, at);
                at += length;
                /* a word is in the meaning, or it is the default; of yes and no one says the other */
                if (!CHECK(strstr(key->meaning, word) || strstr(key->default_text, word) ||
                           strcmp(key->choices, "no, yes") == 0))
                    NOTE("%s.%s: %s stands nowhere", s[k].name, key->keys, word);
            }
        }
    CHECK(numbers > 80 && choices > 25);
}

/* ---- the parser ---- */

static int taken[40][40]; /* rows whose keys stand in a scene that was read: a bit for each */

/* What the parser has taken of this text. */
static void mark(pd_ctx *ctx, const char *path)
{
    pd_text text;
    int count;
    const pd_key_section *s = pd_key_sections(&count);
    if (!CHECK_OK(ctx, pdi_text_read(ctx, path, &text))) return;
    for (int e = 0; e < text.entry_count; e++)
        for (int k = 0; k < count; k++)
            for (int i = 0; i < s[k].count && strcmp(s[k].name, text.section[text.entry[e].section].name) == 0; i++) {
                int bit = 0;
                for (const char *at = s[k].key[i].keys; *at; bit++) {
                    size_t length = strcspn(at, ",");
                    if (strlen(text.entry[e].key) == length && strncmp(at, text.entry[e].key, length) == 0)
                        taken[k][i] |= 1 << bit;
                    at += length;
                    at += strspn(at, ", ");
                }
            }
    pdi_text_free(ctx, &text);
}

static void take(const char *path)
{
    pd_ctx ctx;
    pd_setup setup;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_scene_read(&ctx, path, NULL, 0, &setup))) return;
    pd_setup_free(&ctx, &setup);
    mark(&ctx, path);
}

#if PD_DIM == 2
#define BOX "[grid] h = 1 um  box = 0 .. 20 um, 0 .. 20 um  threads = 1\n"
#define METAL "[shape metal] box = 0 .. 20 um, 0 .. 10 um  kind = solid  material = steel304\n"
#define WATER "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  "
static const char *const texts[] = {
    BOX "[shape a] mask = m.png  corner = 4 um, 4 um  cell = 1 um  kind = solid\n"
        "[shape b] raw = m.raw  size = 2, 2  corner = 15 um, 15 um  cell = 1 um  kind = wall\n"
        "[transport] D = 1e-9 m2/s\n[dissolve] law = 1e-3/s  rate_scale = 2  charge = 2  threshold = 0.1  m = 3\n"
        "[run] until = 1 s  max_dissolved_fraction = 0.1\n[output] prefix = a  folder = b  images = C, rate  range = C "
        "0 .. 500 mol/m3\n"
        "percentile = 98 %  contours = C 3\n"
        "log_scale = rate  colormap = grey, C viridis  width = 600  cells = smooth  animate = yes  format = svg\n",
    BOX WATER "\n[output] images = v  streamlines = v 50  vectors = v\n",
    BOX "[side x-] flow = inlet  profile = expression  vx = 1 mm/s  vy = 0\n[side x+] flow = outlet\n" WATER
        "order = 4\n[transport] D = 1e-9 m2/s  advection = upwind\n[run] until = 1 s\n"
        "[shape a] cylinder = y  centre = 10 um, 0  radius = 2 um\n[shape c] ball = 10 um, 10 um  radius = 2 um\n"
        "[shape b] intersect = a, c  kind = wall  C = 1 mol/m3\n"
        "[line a] from = 0, 0  to = 5 um, 0  points = 2  images = C\n"
        "[force a] shape = b  balance = no\n[transfer a] reference_length = 1 um  surface = 1 mol/m3  fluid = 0  D = "
        "1e-9 m2/s\n"
        "[measured a] file = t.csv  of = transfer.a.flux\n",
    BOX WATER "time = explicit  eos = linear  c0 = 1 m/s  vx = 0\n[run] until = 1 ms\n",
    BOX "[gas] gamma = 1.3  rho = 1 kg/m3  p = 1e5 Pa  vx = 1 m/s  vy = 0  order = first  cfl = 0.5\n"
        "[run] until = 1 us\n",
    BOX METAL
    "[side y+] flow = open\n[table f] file = t.csv  x = 1  y = 2  outside = error\n"
    "[corrode] current = 1 A/cm2  Csat = 5 mol/L  D = 1e-9 m2/s  rate_scale = 1  bulk = 0  driving_force = difference\n"
    "kernel = square  weights = published  repassivation = 1 mol/L  breaking = stochastic  seed = 2  m = 3\n"
    "[run] until = 1 s\n",
    BOX METAL
    "[transport] D = 1e-9 m2/s\n[chemistry] time = implicit\n[species Fe2+] D = 1e-9 m2/s\n"
    "[species H+] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h  reaction = Fe + 2 H+ = Fe2+ + H2(g)\n[run] until = 1 s\n",
    BOX METAL
    "[shape b] box = 10 um .. 20 um, 0 .. 10 um  kind = solid  material = mg4ag\n[side y+] potential = 0 V\n"
    "[potential] conductivity = 1 S/m  tolerance = 1e-10\n[transport] D = 1e-9 m2/s\n[dissolve] current = i\n"
    "[electrode a] shape = metal  curve = butler_volmer  i0 = 1 A/m2  E0 = 0 V  anodic_slope = 0.1 V\n"
    "cathodic_slope = 0.1 V  anodic_limit = 1 A/m2  cathodic_limit = 1 A/m2  film_resistance = 0  potential = 0 V\n"
    "[electrode b] material = mg4ag  curve = linear  polarisation_resistance = 1 ohm m2  connected = a\n[run] until = "
    "1 s\n",
    BOX METAL
    "[transport] D = 1e-9 m2/s\n[chemistry] tortuosity = 2  covering_thickness = 1 um  migration = yes\n"
    "[species K+] D = 1e-9 m2/s\n"
    "[species Cl-] D = 1e-9 m2/s\n[species KCl(s)] volume = 37 cm3/mol\n[reaction a] KCl(s) = K+ + Cl-  log10_K = 1\n"
    "[mineral KCl(s)] rate = 1 mol/m2/s  area = 1 1/m  surface = 0  exponent = 1  nucleation = 0  porosity = 0.1\n"
    "[dissolve] rate = 1 um/h  potential = 0 V\n[run] until = 1 s\n",
    BOX METAL "[potential] conductivity = 1 S/m\n[electrode a] shape = metal  current = 0  curve = expression\n"
              "i = 1 A/m2 * E/(1 V)  range = -1 V .. 1 V\n",
    BOX METAL
    "[potential] conductivity = 1 S/m\n[electrode a] shape = metal  curve = linear  polarisation_resistance = 1 ohm "
    "m2\n"
    "reaction = 2 H+ + 2 e- = H2(g)\n[species H+] D = 1e-9 m2/s\n[species Cl-] D = 1e-9 m2/s\n[run] until = 1 s\n",
    BOX METAL
    "[side y+] flow = open  species = inlet\n[species Fe2+] D = 1e-9 m2/s\n[species H+] D = 1e-9 m2/s\n"
    "[corrode] rate = 1 um/h  Csat = 5 mol/L  D = 1e-9 m2/s  reaction = Fe + 2 H+ = Fe2+ + H2(g)\n[run] until = 1 s\n",
    BOX METAL "[side x-] ux = 0  uy = 0\n[side x+] pressure = 1 MPa\n"
              "[solid] E = 200 GPa  nu = 0.3  strength = 1 GPa  body_force = 0, 0  m = 2  influence = linear\n"
              "[crack a] points = 5 um, 10 um, 5 um, 8 um  direction = 0, -1\n",
    BOX METAL "[side x-] ux = 0  uy = 0\n[side x+] traction = 1 MPa, 0\n"
              "[solid] E = 200 GPa  nu = 0.3  critical_stretch = 0.1  yield_stress = 1 GPa\n"
              "hardening_modulus = 0\n"};
static const char electrolyte[] =
    "[chemistry] include = more.electrolyte  activity = ideal  temperature = 310 K  pH = 7  inlet_pH = 8\n"
    "counter_ion = Cl-  balance_ion = Na+  minerals = all  diffusion = viscosity  inside_pH = 7\n"
    "[species H+] D = 1e-9 m2/s  activation_energy = 0 J/mol\n[species OH-]\n"
    "[species Na+] initial = 1 mM  inlet = 1 mol/m3  inside = 0\n"
    "[species Cl-] initial = 1 mM\n[species glucose] formula = C6H12O6  charge = 0\n"
    "[reaction water] H+ + OH- = H2O  K = 1e14 L2/mol2  forward = 1.4e11 L/mol/s  activation_energy = 0 J/mol\n"
    "[reaction again] H+ + OH- = H2O  log10_K = 14  enthalpy = 0 J/mol  backward = 1 mol/L/s\n";

/* The same of the sections of chemistry, in a file of its own. */
static void take_electrolyte(void)
{
    pd_ctx ctx;
    pd_electrolyte *e = (pd_electrolyte *)malloc(sizeof *e);
    pd_ctx_init(&ctx);
    put("more.electrolyte", "[chemistry]\n", 12);
    put("a.electrolyte", electrolyte, sizeof electrolyte - 1);
    if (CHECK(e != NULL) && CHECK_OK(&ctx, pd_electrolyte_read(&ctx, path_of("a.electrolyte"), NULL, 0, e)))
        mark(&ctx, path_of("a.electrolyte"));
    free(e);
}

/* 1: a key of 3D alone */
static int elsewhere(const char *section, const char *key)
{
    static const char *const keys[] = {
        "shape.stl", "shape.scale",  "shape.shift",          "shape.uz",       "side.vz",    "side.uz", "flow.vz",
        "gas.vz",    "output.slice", "force.reference_area", "output.surface", "output.view"};
    char name[128];
    snprintf(name, sizeof name, "%s.%s", section, key);
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if (strcmp(keys[k], name) == 0) return 1;
    return 0;
}
#else
#define BOX "[grid] h = 1 um  box = 0 .. 10 um, 0 .. 10 um, 0 .. 10 um\n"
#define WATER "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  "
static const char *const texts[] = {
    BOX WATER "time = prescribed  vz = 0\n[transport] D = 1e-9 m2/s\n[run] until = 1 s\n[output] slice = z 2 um\n",
    BOX
    "[shape a] box = 0 .. 10 um, 0 .. 10 um, 0 .. 5 um  kind = solid  material = mg4ag\n"
    "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s\n[run] until = 1 s\n[output] surface = C  view = 1, 2, 3\n",
    BOX "[gas] rho = 1 kg/m3  p = 1e5 Pa  vz = 1 m/s\n[run] until = 1 us\n",
    BOX "[shape a] stl = a.stl  scale = 1 um  shift = 2 um, 2 um, 2 um  kind = wall\n"
        "[side x-] flow = inlet  profile = expression  vx = 1 mm/s  vz = 0\n[side x+] flow = outlet\n" WATER "\n"
        "[force a] shape = a  reference_speed = 1 mm/s  reference_area = 1 um2\n",
    BOX "[shape a] box = 0 .. 10 um, 0 .. 10 um, 0 .. 10 um  kind = solid\n[side x-] ux = 0  uz = 0\n"
        "[shape b] ball = 5 um, 5 um, 5 um  radius = 1 um  kind = grip  uz = 0\n[solid] E = 200 GPa  nu = 0.3\n"};
/* 1: a key that the 2D program looks at */
static int elsewhere(const char *section, const char *key)
{
    int flat = strcmp(key, "vz") && strcmp(key, "uz") && strcmp(key, "stl") && strcmp(key, "scale") &&
               strcmp(key, "shift") && strcmp(key, "slice") && strcmp(key, "area") && strcmp(key, "surface") &&
               strcmp(key, "view");
    return flat || (strcmp(section, "transfer") == 0 && strcmp(key, "area") == 0) ||
           (strcmp(section, "mineral") == 0 && (strcmp(key, "area") == 0 || strcmp(key, "surface") == 0));
}
#endif

/* Files that the scenes name. */
static void leave_files(void)
{
    static const char table[] = "time [s],value\n0,0\n0.5,1\n1,2\n", raw[] = {0, 1, 1, 1};
    static const char facets[] = "solid a\n"
                                 "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 4 0\nvertex 4 0 0\n"
                                 "endloop\nendfacet\n"
                                 "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 4 0 0\nvertex 0 0 4\n"
                                 "endloop\nendfacet\n"
                                 "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 4\nvertex 0 4 0\n"
                                 "endloop\nendfacet\n"
                                 "facet normal 0 0 0\nouter loop\nvertex 4 0 0\nvertex 0 4 0\nvertex 0 0 4\n"
                                 "endloop\nendfacet\nendsolid a\n";
    uint8_t white[4] = {255, 255, 255, 255};
    pd_ctx ctx;
    pd_image image;
    pd_ctx_init(&ctx);
    put("t.csv", table, sizeof table - 1);
    put("m.raw", raw, sizeof raw);
    put("a.stl", facets, sizeof facets - 1);
    image.width = image.height = 2;
    image.channels = 1;
    image.pixels = white;
    CHECK_OK(&ctx, pd_png_write(&ctx, path_of("m.png"), &image));
}

/* Every key stands in a scene that is read without an error, which an unknown key or one without effect would be. */
TEST(parser)
{
    char path[512], dimension[16];
    int count;
    const pd_key_section *s = pd_key_sections(&count);
    static const char *const folders[] = {"examples/scenes", "examples/scenes/validation", "examples/scenes/templates"};
    leave_files();
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) {
        put("a.scene", texts[k], strlen(texts[k]));
        take(path_of("a.scene"));
    }
#if PD_DIM == 2
    take_electrolyte();
#endif
    snprintf(dimension, sizeof dimension, "_%dd.scene", PD_DIM);
    for (size_t k = 0; k < sizeof folders / sizeof folders[0]; k++) {
        DIR *folder_of = opendir(folders[k]);
        if (!CHECK(folder_of != NULL)) continue;
        for (struct dirent *entry = readdir(folder_of); entry; entry = readdir(folder_of)) {
            const char *end = strstr(entry->d_name, dimension);
            int around = PD_DIM == 2 && (strcmp(entry->d_name, "mg_wire.scene") == 0 || strstr(entry->d_name, "_axi."));
            if (!end && !around) continue;
            snprintf(path, sizeof path, "%s/%s", folders[k], entry->d_name);
            take(path);
        }
        closedir(folder_of);
    }
    for (int k = 0; k < count; k++)
        for (int i = 0; i < s[k].count; i++) {
            int bit = 0;
            for (const char *at = s[k].key[i].keys; *at && strcmp(s[k].key[i].unit, "any") != 0; bit++) {
                char key[64];
                size_t length = strcspn(at, ",");
                snprintf(key, sizeof key, "%.*s", (int)length, at);
                if (!elsewhere(s[k].name, key) && !CHECK((taken[k][i] >> bit & 1) == 1))
                    NOTE("no scene that the parser takes has %s of [%s]", key, s[k].name);
                at += length;
                at += strspn(at, ", ");
            }
        }
}

/* What is not in the table is refused. */
TEST(others)
{
    refused("[grid] h = 1 um  spacing = 1 um\n",
            "found the unknown key 'spacing' in [grid], expected one of h, m, box");
    refused("[gird] h = 1 um\n", "expected one of constants, grid, shape");
    CHECK_INT(pdi_keys_is_consistent("flow", "rho", "kg/m3", NULL), 1);
    CHECK_INT(pdi_keys_is_consistent("flow", "rho", "kg", NULL), 0);
    CHECK_INT(pdi_keys_is_consistent("flow", "rho", "", NULL), 0);
    CHECK_INT(pdi_keys_is_consistent("flow", "rh", "kg/m3", NULL), 0);
    CHECK_INT(pdi_keys_is_consistent("flow", "steady_tolerance", "", "1e-6"), 1);
    CHECK_INT(pdi_keys_is_consistent("flow", "steady_tolerance", "", "1e-7"), 0);
    CHECK_INT(pdi_keys_is_consistent("flow", "steady_tolerance", "", "1e"), 0);
    CHECK_INT(pdi_keys_is_consistent("solid", "m", "", "3"), 1);
    CHECK_INT(pdi_keys_is_consistent("output", "fields", "", "C, v, p, kind, grain"), 1);
    CHECK_INT(pdi_keys_is_consistent("constants", "anything", NULL, NULL), 1);
}

/* ---- templates ---- */

TEST(templates)
{
    int count;
    const pd_template *t = pd_templates(&count);
    char text[8192];
    CHECK_INT(count, 7);
    for (int k = 0; k < count; k++) {
        pd_ctx ctx;
        pd_setup setup;
        size_t used = 0;
        for (int line = 0; t[k].line[line]; line++)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s\n", t[k].line[line]);
        CHECK(used < sizeof text && text[0] == '#');
        if (CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &setup))) leave(&ctx, &setup);
    }
}

TEST_MAIN(ENTRY(guide) ENTRY(types) ENTRY(parser) ENTRY(others) ENTRY(templates))
