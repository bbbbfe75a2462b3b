/* turned: scenes that change along one axis alone have the same profiles along each axis and from either end: no axis
 * and no side is another than the others.
 * dims: 1 2 3 */
#include "setup/fields.h"
#include "physics/sample.h"
#include "run/sim.h"
#include "test.h"

/* Cells along the axis, of 1 um each; 4 across it, between mirrors. */
enum { CELLS = 24, ACROSS = 4 };

#if PD_DIM == 1
#define NU
#else
#define NU "  nu = 0.3"
#endif

/* In a scene: @ is the place along the axis; <a,b> in um is a box from a to b along it, <a> a place on its middle line;
 * low and high are its ends. */
static const struct scene_of {
    const char *text, *fields;
    double off; /* of the largest value: what solvers leave */
} scenes[] = {
    {"[grid] h = 1 um  box = <0,24>\n[side low] C = 3 mol/m3 * (1 + t / 1 ms)\n[side high] flow = noslip\n"
     "[shape a] kind = medium  box = <14,24>  D = 1e-10 m2/s\n"
     "[shape b] kind = medium  box = <4.3,7.6>  D = 1e-10 m2/s\n"
     "[transport] D = 1e-9 m2/s  initial = 1 mol/m3 * (2 + @ / 24 um)\n[run] until = 5 ms  rtol = 1e-3\n",
     "C D", 1e-8},
    {"[grid] h = 1 um  box = <0,24>\n[side low] C = 0 mol/m3\n[side high] flow = noslip\n"
     "[shape a] kind = medium  box = <12,24>  D = 1e-10 m2/s\n"
     "[shape b] kind = solid  box = <21,24>  material = mg4ag\n[transport] D = 1e-9 m2/s\n"
     "[dissolve] rate = 1 mm/s\n[run] until = 8 ms  rtol = 1e-3\n",
     "C D", 1e-8},
    {"[grid] h = 1 um  m = 2  box = <0,24>\n[side low] flow = mirror\n[side high] C = 2 mol/m3\n"
     "[shape a] kind = solid  box = <4.5,9.2>  material = mg4ag  grain_size = 3 um\n[transport] D = 1e-9 m2/s\n"
     "[dissolve] m = 2  rate = 0.1 mm/s * (1 - C / 4e3 mol/m3)^2\n[run] until = 8 ms  rtol = 1e-3\n",
     "C kind rate density", 1e-9},
    {"[grid] h = 1 um  m = 3  box = <0,24>\n[side low] flow = open\n[side high] flow = mirror\n"
     "[shape a] kind = solid  box = <8,24>  material = steel304\n"
     "[corrode] Cs = 143 mol/L  Csat = 5.1 mol/L  D = 8.5e-10 m2/s  rate = 10 um/s\n"
     "[run] until = 0.3 s  rtol = 1e-3\n",
     "C kind density", 1e-9},
    {"[grid] h = 1 um  box = <0,24>\n[side low] species = inlet\n"
     "[shape a] kind = solid  box = <16,24>  material = mg4ag\n"
     "[chemistry] activity = ideal\n[species Mg2+] D = 0.7e-9 m2/s\n"
     "[species Na+] D = 1.3e-9 m2/s  initial = 10 mol/m3\n"
     "inlet = 20 mol/m3\n[species Cl-] D = 2e-9 m2/s  initial = 10 mol/m3  inlet = 20 mol/m3\n"
     "[species OH-] D = 5e-9 m2/s\n"
     "[species H+] D = 9e-9 m2/s\n[species H2O]\n[species Mg(OH)2(s)] volume = 2.5e-5 m3/mol\n"
     "[reaction w] H2O = H+ + OH-  log10_K = -14\n[reaction b] Mg(OH)2(s) = Mg2+ + 2 OH-  log10_K = -11\n"
     "[mineral Mg(OH)2(s)] rate = 1e-4 mol/m2/s  area = 1e4 1/m  porosity = 0.5\n[transport] D = 1e-9 m2/s\n"
     "[dissolve] rate = 0.1 um/s * exp(-layer / 20 nm)  reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)\n"
     "[surface layer] initial = 1 nm  rate = 3 nm/s\n[run] until = 0.5 s  rtol = 1e-3\n",
     "pH Mg2+ Na+ film SI kind", 1e-3},
    {"[grid] h = 1 um  box = <0,24>\n[shape a] kind = solid  box = <0,4>  material = steel304\n"
     "[shape b] kind = solid  box = <18.6,24>  material = mg4ag\n"
     "[transport] D = 1e-9 m2/s\n[dissolve mg4ag] current = i\n[dissolve steel304] rate = 0\n"
     "[potential] conductivity = 0.1 S/m\n[electrode a] shape = a  curve = tafel  i0 = 1 A/m2  E0 = -0.9 V  "
     "cathodic_slope = 120 mV\n[electrode b] shape = b  curve = tafel\n"
     "i0 = 100 A/m2  E0 = -1.3 V  anodic_slope = 60 mV\n"
     "connected = a\n"
     "[run] until = 2 s  rtol = 1e-3\n",
     "phi j i C kind", 1e-9},
    {"[grid] h = 1 um  box = <0,24>\n[shape bar] kind = solid  box = <0,20>\n"
     "[solid] E = 70 GPa" NU "  m = 2  yield_stress = 70 MPa  hardening_modulus = 7 GPa\n[side low] u~ = 0 m\n"
     "[shape g] kind = grip  box = <17,20>  u~ = # 0.05 um * t / (1 s)\n[run] until = 1 s\n",
     "u mises eps_p", 1e-6},
    {"[grid] h = 1 um  box = <0,24>\n[shape bar] kind = solid  box = <3,20>\n"
     "[solid] E = 70 GPa" NU "  m = 2  dynamics = yes  density = 2000 kg/m3\n"
     "[shape g] kind = grip  box = <17,20>  u~ = # 1 nm * t / (1 ns)\n[run] until = 4 ns\n",
     "u mises strain_energy", 1e-9},
    {"[grid] h = 1 um  box = <0,24>\n[side low] flow = slip\n[side high] flow = outlet\n"
     "[gas] gamma = 1.4  rho = 1 kg/m3 * (1 + exp(-(@ / 1 um - 9)^2 / 8))  p = 1 Pa * (1 + @ / 24 um)\n"
     "[run] until = 5 us\n",
     "density p energy v", 1e-12}};

static double along_of(double place, int from_high) { return from_high ? CELLS - place : place; }

/* The text of a scene turned to an axis, its low end at the high one if from_high. */
static void turn(const char *text, int axis, int from_high, char *to, size_t room)
{
    char *out = to, *end = to + room;
    for (const char *p = text; *p;) {
        char *close;
        if (*p == '@' && from_high) p++, out += snprintf(out, (size_t)(end - out), "(24 um - %c)", "xyz"[axis]);
        else if (*p == '@') p++, *out++ = "xyz"[axis];
        else if (*p == '~') p++, *out++ = "xyz"[axis];
        else if (*p == '#') p++, *out++ = from_high ? '-' : '+';
        else if (strncmp(p, "low]", 4) == 0 || strncmp(p, "high]", 5) == 0) {
            int high = *p == 'h';
            p += high ? 5 : 4;
            out += snprintf(out, (size_t)(end - out), "%c%c]", "xyz"[axis], high == from_high ? '-' : '+');
        } else if (*p == '<') {
            double a = strtod(p + 1, &close), b = strtod(close + 1, &close);
            double lo = from_high ? CELLS - b : a, hi = from_high ? CELLS - a : b;
            p = close + 1;
            for (int d = 0; d < PD_DIM; d++)
                out += snprintf(out, (size_t)(end - out), "%s%g um .. %g um", d ? ", " : "", d == axis ? lo : 0.0,
                                d == axis ? hi : (double)ACROSS);
        } else *out++ = *p++;
    }
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (s / 2 != axis)
            out += snprintf(out, (size_t)(end - out), "[side %c%c] flow = mirror\n", "xyz"[s / 2], "-+"[s % 2]);
    snprintf(out, (size_t)(end - out), "[output] fields = none  images = none\n");
}

enum { FIELDS = 8 };

static pd_sim sim;

/* The profiles of `fields` at the end: value[field][cell]; how many fields. */
static int profiles(const char *text, const char *fields, int axis, int from_high, double value[FIELDS][CELLS])
{
    static char turned[4000];
    pd_ctx ctx;
    char name[100], *next = name;
    int count = 0;
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    turn(text, axis, from_high, turned, sizeof turned);
    if (!CHECK_OK(&ctx, pd_sim_open(&ctx, turned, NULL, 0, &sim))) {
        NOTE("%s", turned);
        return 0;
    }
    while (sim.time < sim.end_time)
        if (!CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, sim.end_time))) {
            NOTE("%s", turned);
            return 0;
        }
    snprintf(name, sizeof name, "%s", fields);
    pd_sample_prepare(&ctx, &sim.model, ~(pd_fields)0);
    for (char *of = strtok(next, " "); of; of = strtok(NULL, " ")) {
        int field = 0;
        while (field < PD_FIELD_COUNT && strcmp(pd_fields_get_name(sim.model.setup, (pd_field)field), of) != 0)
            field++;
        if (!CHECK(field < PD_FIELD_COUNT)) break;
        for (int k = 0; k < CELLS; k++) {
            int cell[3] = {1, 1, 1};
            cell[axis] = (int)along_of(k + 0.5, from_high);
            value[count][k] = pd_sample_get_node(&sim.model, (pd_field)field, pd_grid_node(&sim.model.grid, cell));
        }
        count++;
    }
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
    return count;
}

static void along_any_axis(int s)
{
    static double first[FIELDS][CELLS], value[FIELDS][CELLS];
    int count = profiles(scenes[s].text, scenes[s].fields, 0, 0, first);
    for (int f = 0; f < count; f++) { /* something changes along the axis */
        double low = first[f][0], high = low;
        for (int k = 0; k < CELLS; k++) {
            low = fmin(low, first[f][k]);
            high = fmax(high, first[f][k]);
        }
        if (!CHECK(high > low)) NOTE("scene %d, field %d of %s", s, f, scenes[s].fields);
    }
    for (int way = 1; way < 2 * PD_DIM; way++) {
        if (!CHECK_INT(profiles(scenes[s].text, scenes[s].fields, way / 2, way % 2, value), count)) break;
        for (int f = 0; f < count; f++) {
            double size = 0.0, off = 0.0;
            for (int k = 0; k < CELLS; k++) {
                if (isnan(first[f][k])) {
                    CHECK(isnan(value[f][k]));
                    continue;
                }
                size = fmax(size, fabs(first[f][k]));
                off = fmax(off, fabs(value[f][k] - first[f][k]));
            }
            if (!CHECK_LE(off, scenes[s].off * size))
                NOTE("scene %d, way %d, field %d of %s", s, way, f, scenes[s].fields);
        }
    }
}

TEST(media) { along_any_axis(0); }
TEST(media_beside_metal) { along_any_axis(1); }
TEST(dissolving_metal) { along_any_axis(2); }
TEST(broken_bonds) { along_any_axis(3); }
TEST(species) { along_any_axis(4); }
TEST(electrodes) { along_any_axis(5); }
TEST(plastic_bar) { along_any_axis(6); }
TEST(bar_in_motion) { along_any_axis(7); }
TEST(gas) { along_any_axis(8); }

TEST_MAIN(ENTRY(media) ENTRY(media_beside_metal) ENTRY(dissolving_metal) ENTRY(broken_bonds) ENTRY(electrodes)
          SLOW_ENTRY_IF(PD_DIM == 3, species) SLOW_ENTRY_IF(PD_DIM == 3, plastic_bar)
          SLOW_ENTRY_IF(PD_DIM == 3, bar_in_motion) SLOW_ENTRY_IF(PD_DIM == 3, gas))
