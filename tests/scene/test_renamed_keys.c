/* test_renamed_keys: scenes with former names of sections, keys and values are the scenes with the present ones, and a
 * note tells each.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "pdcorr_app.h"
#include "test.h"

#if PD_DIM == 2
#define UP "y"
#define BOX "[grid] h = 1 um  box = 0 .. 20 um, 0 .. 20 um  threads = 1\n"
#define SPAN "0 .. 20 um, 0 .. 10 um"
#define VECTOR(a, unit) a " " unit ", 0 " unit
#else
#define UP "z"
#define BOX "[grid] h = 1 um  box = 0 .. 20 um, 0 .. 4 um, 0 .. 20 um  threads = 1\n"
#define SPAN "0 .. 20 um, 0 .. 4 um, 0 .. 10 um"
#define VECTOR(a, unit) a " " unit ", 0 " unit ", 0 " unit
#endif
#define METAL "[shape metal] box = " SPAN "  kind = solid  material = steel304"

/* Scenes with the present names. */
static const char *const scenes[] = {
    BOX METAL "  grain_size = 5 um  grain_size_deviation = 0.5 um  grain_boundary_width = 1 um\n"
              "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n[side x+] flow = outlet\n"
              "[flow] rho = 1000 kg/m3  mu = 1 mPa s  steady_tolerance = 1e-5  body_force = " VECTOR(
                  "1", "m/s2") "  reference_speed = 1 mm/s  reference_length = 10 um\n"
                               "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s  grain_boundary_factor = 2\n"
                               "[run] until = 1 s  max_dissolved_fraction = 0.2\n"
                               "[force a] reference_speed = 1 mm/s  "
#if PD_DIM == 2
                               "reference_length = 1 um"
#else
                               "reference_area = 1 um2"
#endif
                               "  shape = metal\n[transfer a] reference_length = 1 um  surface = 1 mol/m3  fluid = 0\n"
                               "[output] images = C  log_scale = C  colormap = grey\n",
    BOX METAL
    "\n[side " UP "+] flow = open\n[corrode] current = 1 A/cm2  Csat = 5 mol/L  D = 1e-9 m2/s  "
    "driving_force = difference  kernel = square  weights = published  grain_boundary_factor = 1\n[run] until = 1 s\n",
    BOX METAL
    "\n[solid] E = 200 GPa  nu = 0.3  model = hencky  yield_stress = 1 GPa  hardening_modulus = 1 GPa  "
    "critical_stretch = 0.1  body_force = " VECTOR("1", "N/m3") "\n[side x-] ux = 0 um\n"
                                                                "[output] images = mises  deformation_scale = 2\n",
    BOX METAL "\n[solid] E = 200 GPa  model = bond_based  fracture_energy = 1 J/m2  dynamics = yes  density = 1 g/cm3\n"
              "[side x-] ux = 0 um\n[run] until = 1 ns\n",
    BOX METAL "\n[solid] E = 200 GPa  nu = 0.3  dissolution_factor = 2\n[side x-] ux = 0 um\n"
              "[crack a] "
#if PD_DIM == 2
              "points = 0 um, 5 um, 10 um, 5 um  direction = 1, 0  contour_radii = 1 um, 4 um, 7 um\n"
#else
              "points = 0 um, 0 um, 5 um, 10 um, 0 um, 5 um, 10 um, 4 um, 5 um, 0 um, 4 um, 5 um  direction = 1, 0, 0\n"
#endif
              "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s\n[run] until = 1 s\n",
    BOX METAL
    "\n[transport] D = 1e-9 m2/s\n[chemistry] pH = 7  counter_ion = Cl-  balance_ion = Na+  covering_thickness = 1 um\n"
    "[species Na+] D = 1e-9 m2/s  activation_energy = 1 kJ/mol  initial = 1 mol/m3\n"
    "[species Cl-] D = 2e-9 m2/s  initial = 1 mol/m3\n[species H+] D = 9e-9 m2/s\n[species OH-] D = 5e-9 m2/s\n"
    "[species H2O]\n[species Fe2+] D = 1e-9 m2/s\n[species NaCl(s)] volume = 27 cm3/mol\n[mineral NaCl(s)]\n"
    "[reaction salt] NaCl(s) = Na+ + Cl-  log10_K = 1.6\n"
    "[reaction water] H+ + OH- = H2O  K = 1e14 L2/mol2  forward = 1.4e11 L/mol/s  activation_energy = 0 J/mol\n"
    "[dissolve] rate = 1 um/s\n[run] until = 1 s\n",
    BOX METAL
    "\n[potential] conductivity = 1 S/m\n[side x-] potential = 0 V\n"
    "[electrode a] shape = metal  curve = linear  polarisation_resistance = 1 ohm m2  film_resistance = 1 ohm "
    "m2  potential = 1 V\n",
    BOX METAL "\n[potential] conductivity = 1 S/m\n[side x-] potential = 0 V\n[surface q] initial = 1  rate = 0 1/s\n"
              "[chemistry] activity = ideal\n[species OH-] D = 5e-9 m2/s\n"
              "[electrode a] shape = metal  curve = linear  polarisation_resistance = 1 ohm m2  current_factor = q  "
              "potential = 1 V  reaction = 2 H2O + 2 e- = H2(g) + 2 OH-\n[run] until = 1 s\n",
    BOX "[flow] rho = 1000 kg/m3  mu = 1 mPa s  time = prescribed  vx = 1 mm/s  reference_speed = 1 mm/s  "
        "reference_length = 1 um\n[side x-] flow = open\n[side x+] flow = open\n[transport] D = 1e-9 m2/s\n"
        "[run] until = 1 s\n"};

/* section, present key, former key; a value: present and former after the key. */
typedef struct name {
    const char *section, *key, *former_key, *value, *former_value;
} name;

static const name names[] = {
    {"crack", "direction", "way", 0, 0},
    {"crack", "contour_radii", "contours", 0, 0},
    {"shape", "grain_size", "grains", 0, 0},
    {"shape", "grain_size_deviation", "grain_spread", 0, 0},
    {"shape", "grain_boundary_width", "boundary_width", 0, 0},
    {"flow", "steady_tolerance", "steady", 0, 0},
    {"flow", "body_force", "force", 0, 0},
    {"flow", "reference_speed", "speed", 0, 0},
    {"flow", "reference_length", "length", 0, 0},
    {"flow", "time", "time", "prescribed", "given"},
    {"dissolve", "grain_boundary_factor", "gb_factor", 0, 0},
    {"corrode", "grain_boundary_factor", "gb_factor", 0, 0},
    {"corrode", "driving_force", "drive", 0, 0},
    {"corrode", "weights", "weights", "published", "printed"},
    {"solid", "model", "material", 0, 0},
    {"solid", "model", "model", "bond_based", "springs"},
    {"solid", "yield_stress", "yield", 0, 0},
    {"solid", "hardening_modulus", "hardening", 0, 0},
    {"solid", "fracture_energy", "toughness", 0, 0},
    {"solid", "critical_stretch", "stretch", 0, 0},
    {"solid", "dynamics", "motion", 0, 0},
    {"solid", "body_force", "force", 0, 0},
    {"solid", "dissolution_factor", "speed_factor", 0, 0},
    {"chemistry", "counter_ion", "counter", 0, 0},
    {"chemistry", "balance_ion", "balance", 0, 0},
    {"chemistry", "covering_thickness", "cover", 0, 0},
    {"species", "activation_energy", "activation", 0, 0},
    {"reaction", "activation_energy", "activation", 0, 0},
    {"electrode", "film_resistance", "film", 0, 0},
    {"electrode", "polarisation_resistance", "resistance", 0, 0},
    {"electrode", "current_factor", "factor", 0, 0},
    {"force", "reference_speed", "speed", 0, 0},
    {"force", PD_DIM == 2 ? "reference_length" : "reference_area", PD_DIM == 2 ? "length" : "area", 0, 0},
    {"transfer", "reference_length", "length", 0, 0},
    {"run", "max_dissolved_fraction", "fraction", 0, 0},
    {"output", "colormap", "map", 0, 0},
    {"output", "log_scale", "log", 0, 0},
    {"output", "deformation_scale", "deformed", 0, 0}};

static const int count = (int)(sizeof names / sizeof names[0]);

/* Where the key of this section stands in the text as "key = ", or the value behind it; NULL: nowhere. */
static char *find(char *text, const name *n)
{
    char section[40], pair[100];
    snprintf(section, sizeof section, "[%s", n->section);
    snprintf(pair, sizeof pair, "%s = %s", n->key, n->value ? n->value : "");
    for (char *at = strstr(text, section); at; at = strstr(at + 1, section)) {
        char *end = strstr(at, "\n["), *found = strstr(at, pair);
        if (strchr(" ]", at[strlen(section)]) && found && (!end || found < end)) return found;
    }
    return NULL;
}

/* Puts another word in the place of one at `at`. */
static void replace(char *at, const char *word, const char *by)
{
    memmove(at + strlen(by), at + strlen(word), strlen(at + strlen(word)) + 1);
    memcpy(at, by, strlen(by));
}

/* Former names of all that the text has; returns how many. */
static int make_former(char *text, uint8_t *seen)
{
    int made = 0;
    /* values first: they are found behind present keys */
    for (int values = 1; values >= 0; values--)
        for (int k = 0; k < count; k++) {
            char *at = !names[k].value == !values ? find(text, &names[k]) : NULL;
            if (!at) continue;
            if (names[k].value) replace(at + strlen(names[k].key) + 3, names[k].value, names[k].former_value);
            else replace(at, names[k].key, names[k].former_key);
            seen[k] = 1;
            made++;
        }
    char *crack = strstr(text, "[crack ");
    if (!crack) return made;
    replace(crack, "[crack ", "[cut ");
    return made + 1;
}

static int former_notes(const pd_setup *u)
{
    int found = 0;
    for (int k = 0; k < u->notes; k++) found += strstr(u->note[k], "is a former name and holds") != NULL;
    return found;
}

TEST(same_scenes)
{
    uint8_t seen[64] = {0};
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
        pd_ctx ctx;
        pd_setup now, before;
        char former[4096];
        pd_ctx_init(&ctx);
        snprintf(former, sizeof former, "%s", scenes[k]);
        int made = make_former(former, seen);
        if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", scenes[k], NULL, 0, &now))) continue;
        CHECK_INT(former_notes(&now), 0);
        if (CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", former, NULL, 0, &before))) {
            CHECK_STR(before.fingerprint, now.fingerprint);
            CHECK_INT(former_notes(&before), made);
            pd_setup_free(&ctx, &before);
        }
        pd_setup_free(&ctx, &now);
        CHECK_INT(ctx.in_use, 0);
    }
    for (int k = 0; k < count; k++)
        if (!CHECK(seen[k] || (PD_DIM == 3 && strcmp(names[k].key, "contour_radii") == 0)))
            NOTE("%s.%s stands in no scene", names[k].section, names[k].key);
}

/* Values of the command line by former names, alone, with their section and with their label. */
TEST(command_line)
{
    static const char *const given[] = {"fraction=0.5", "run.fraction=0.5", "run.max_dissolved_fraction=0.5",
                                        "dissolve.gb_factor=3", "shape.metal.grains=6 um"};
    for (int k = 0; k < 5; k++) {
        pd_ctx ctx;
        pd_setup u;
        pd_ctx_init(&ctx);
        if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", scenes[0], &given[k], 1, &u))) continue;
        CHECK_NEAR(u.max_node_fraction, k < 3 ? 0.5 : 0.2, 0.0);
        CHECK_NEAR(u.gb_factor, k == 3 ? 3.0 : 2.0, 0.0);
        CHECK_INT(former_notes(&u), k != 2);
        pd_setup_free(&ctx, &u);
    }
}

/* One thing by both names, and a former name in another section. */
TEST(refused)
{
    static const char *const wrong[][2] = {{"[run] fraction = 0.1\n", "found 'fraction' a second time in [run]"},
                                           {"[dissolve] fraction = 0.1\n", "found the unknown key 'fraction'"},
                                           {"[cuts a] points = 1 um\n", "found the section [cuts"}};
    for (int k = 0; k < 3; k++) {
        char text[4096];
        pd_ctx ctx;
        pd_setup u;
        pd_ctx_init(&ctx);
        snprintf(text, sizeof text, "%s%s", scenes[0], wrong[k][0]);
        CHECK(pd_scene_parse(&ctx, "a.scene", text, NULL, 0, &u) < 0);
        if (!CHECK(strstr(ctx.message, wrong[k][1]) != NULL)) NOTE("%d: %s", k, ctx.message);
        CHECK_INT(ctx.in_use, 0);
    }
}

TEST_MAIN(ENTRY(same_scenes) ENTRY(command_line) ENTRY(refused))
