/* checkpoint_scene: scenes of every kind of run, small ones, and folders compared byte for byte. Include it behind
 * `#define _XOPEN_SOURCE 700`. */
#ifndef CHECKPOINT_SCENE_H
#define CHECKPOINT_SCENE_H
#include "scene_file.h"
#include <dirent.h>

#if PD_DIM == 2
#define ACROSS(range) ", " range
#define ZERO ", 0 um"
#define NONE ", 0 m/s2"
#define HOURS "7 h"
#define MOMENT "3 ms"
#define WHILE "4 ms"
#define SECONDS "1 s"
#define SLICE
#else
#define ACROSS(range) ", " range ", " range
#define ZERO ", 0 um, 0 um"
#define NONE ", 0 m/s2, 0 m/s2"
#define HOURS "4.5 h"
#define MOMENT "30 us"
#define WHILE "0.8 ms"
#define SECONDS "0.4 s"
#define SLICE "  slice = z 2 um"
#endif

/* All that can watch a flow and what it carries. */
#define WATCHES \
    "[probe a] at = 80 um" ZERO "  fields = C, v, p\n[line b] from = -40 um" ZERO "  to = 95 um" ZERO \
    "  points = 7  fields = C, v  images = C\n[plane c] at = x 70 um\n" \
    "[force d] box = -30 um .. 60 um" ACROSS("-25 um .. 25 um") "  balance = no\n" \
    "[total e]\n"
#define CHANNEL "[grid] h = 10 um  m = 2  box = -50 um .. 100 um" ACROSS("-40 um .. 40 um") "\n"
#define THROUGH \
    "[side x-] flow = inlet  profile = uniform  mean = 0.01 m/s  C = 0\n[side x+] flow = outlet\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n"
#define PIN "[shape pin] box = 0 .. 40 um" ACROSS("-20 um .. 20 um") "  kind = solid  material = mg4ag"
#define LAW "  rate = 2 um/h * (1 - C/Csat)  Csat = 56 mol/m3"
#define FRAMES(every) "[output] every = " every "  fields = C, v, p, kind  images = C" SLICE "\n"

/* Flow, transport and dissolution with grains, and all that watches. */
#define COUPLED \
    CHANNEL PIN \
        "  grain_size = 20 um\n" THROUGH "[transport] D = 1e-9 m2/s\n[dissolve] m = 2  grain_boundary_factor = 3" LAW \
        "\n" \
        "[run] until = " HOURS \
        "  max_dissolved_fraction = 0.3\n[output] every = 2 h  fields = C, v, p, kind, rate, density, grain" \
        "  images = C, kind" SLICE "\n" WATCHES \
        "[transfer f] box = -30 um .. 60 um" ACROSS("-25 um .. 25 um") "  along = x  reference_length = 40 um" \
                                                                       "  surface = 56 mol/m3  fluid = inlet\n"

/* Dissolution of two metals at rest in a periodic box. */
#define AT_REST \
    CHANNEL PIN "\n[shape tip] box = 20 um .. 40 um" ACROSS("-20 um .. 20 um") "  kind = solid  material = steel304" \
    "\n[side x-] flow = periodic\n[side x+] flow = periodic\n[side y-] flow = mirror\n" \
    "[transport] D = 1e-12 m2/s  initial = 5 mol/m3\n[dissolve] rate = 2 um/h\n" \
    "[dissolve steel304] rate = 3 um/h * (1 - C/(50 mol/m3))  Cs = 100 mol/L\n[run] until = " HOURS "\n" \
    "[output] every = 2 h  fields = C, kind\n[total e]\n"

/* Flow in time with transport of controlled error, and transport of a given flow. */
#define MOVING(time) \
    CHANNEL "[side x-] flow = periodic\n[side x+] flow = periodic\n[shape pin] box = 0 .. 40 um" ACROSS( \
        "-20 um .. 20 um") "  kind = wall\n[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  reference_speed = 0.01 m/s" \
                           "  reference_length = 60 um  body_force = 30 m/s2" NONE time "\n[transport] D = 1e-7 m2/s" \
                           "  initial = if(x < 0 um, 1 mol/m3, 0 mol/m3)\n"
#define IMPLICIT MOVING("  time = implicit") "[run] until = " MOMENT "  rtol = 1e-2\n" FRAMES(MOMENT) WATCHES
#define EXPLICIT MOVING("  time = explicit  c0 = 0.2 m/s") "[run] until = " WHILE "  max_step = 0.2 ms\n" \
    FRAMES("0.5 ms") WATCHES
#define GIVEN \
    CHANNEL "[side x-] flow = open\n[side x+] flow = open\n[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  time = prescribed" \
            "  reference_speed = 0.01 m/s  reference_length = 80 um" \
            "  vx = 0.01 m/s\n[transport] D = 1e-7 m2/s  initial = if(x < 0 um, 1 mol/m3, 0 mol/m3)\n" \
            "[run] until = " WHILE "  rtol = 1e-2\n" FRAMES("0.4 ms") "[total e]\n"

/* Bond-based corrosion. */
#define METAL \
    "[grid] h = 1 um  m = 3  box = -12 um .. 12 um" ACROSS("-6 um .. 6 um") "\n[shape block] box = -12 um .. 0 um" \
    ACROSS("-6 um .. 6 um") "\n[shape pit] ball = 0 um" ZERO "  radius = 4 um\n" \
    "[shape metal] difference = block, pit  kind = solid  material = steel304\n[side x+] flow = open\n"
#define WATCHED "  fields = C, kind, density  images = C" SLICE "\n[total e]\n[line b] from = -11 um" ZERO \
    "  to = 11 um" ZERO "  points = 9  fields = C\n"
#define DIFFUSION "[corrode] Cs = 143 mol/L  Csat = 5.1 mol/L  D = 8.5e-10 m2/s  current = 5 A/cm2"
#define CORRODE_DIFFUSION \
    METAL DIFFUSION "\n[run] until = " SECONDS "  max_step = 0.05 s\n[output] every = 0.2 s" WATCHED
#define CORRODE_RANDOM \
    METAL DIFFUSION "  breaking = stochastic  seed = 7  initial = 0.5*Csat  repassivation = 0.4*Csat\n" \
    "[run] until = " SECONDS "  max_step = 0.05 s\n[output] every = 0.2 s" WATCHED
#define CORRODE_ACTIVATION \
    METAL "[corrode] control = activation  rate = 1 um/s  Cs = 143 mol/L  Csat = 5.1 mol/L\n" \
    "[run] until = 3 s  max_step = 0.25 s\n[output] every = 1 s" WATCHED

/* 2D: metal whose bonds break, alone and as it dissolves: sides that move, a crack at the start, stress and flow. */
#define BREAKS(time) \
    "[crack a] points = -12 um, 0 um, -9 um, 0 um\n" \
    "[side x-] ux = 0 um\n[side y-] uy = 0 um\n[side y+] uy = " time "\n[output] every = 1 s" \
    "  fields = u, mises, broken  images = broken" SLICE "\n[line b] from = -11 um" ZERO "  to = 3 um" ZERO \
    "  points = 9  fields = u, broken\n"
#define SOLID_BREAKS \
    "[grid] h = 1 um  box = -12 um .. 4 um" ACROSS("-4 um .. 4 um") "\n[shape bar] box = -12 um .. 4 um" ACROSS( \
        "-4 um .. 4 um") "  kind = solid\n[solid] E = 45 GPa  nu = 0.3  m = 1  critical_stretch = 2e-3  yield_stress " \
                         "= 100 MPa" \
                         "  hardening_modulus = 1 GPa\n[run] until = 1 s  max_step = 0.25 s\n" BREAKS( \
                             "0.014 um * t / (1 s)")
#define SOLID_DISSOLVES \
    METAL "[corrode] control = activation  rate = 1 um/s  Cs = 143 mol/L  Csat = 5.1 mol/L\n[solid] E = 190 GPa" \
          "  nu = 0.3  m = 1  critical_stretch = 2e-3  dissolution_factor = exp(sigma_h / (1 GPa))\n" \
          "[run] until = 0.5 s  max_step = 0.1 s\n" BREAKS("0.04 um * t / (1 s)")

#define SOLID_MOVES \
    "[grid] h = 1 mm  box = -12 mm .. 8 mm" ACROSS("-6 mm .. 6 mm") "\n[shape bar] box = -12 mm .. 8 mm" ACROSS( \
        "-6 mm .. 6 mm") "  kind = solid\n[shape foot] box = -12 mm .. 8 mm, -6 mm .. -5 mm  kind = grip" \
                         "  ux = 0 mm  uy = 0 mm\n[shape hand] box = -12 mm .. 8 mm, 5 mm .. 6 mm  kind = grip  uy = " \
                         "20 m/s * t\n" \
                         "[crack a] points = -12 mm, 0 mm, -4 mm, 0 mm\n[solid] model = bond_based  E = 72 GPa  " \
                         "fracture_energy = 20 J/m2" \
                         "  dynamics = yes  density = 2440 kg/m3\n[run] until = 8 us  max_step = 1 us\n[output] " \
                         "every = 2 us" \
                         "  fields = u, broken  images = broken" SLICE "\n"

/* Metal in ions: by a law in pH behind a state of its surface; by a law in E beside a cathode, as ions migrate; by
 * a law in pH under the mineral that its base lays down. */
#define IONS(sodium, also) \
    "[chemistry] activity = ideal" also "\n[species H+] D = 9.31e-9 m2/s  initial = 1e-4 mol/m3\n" \
    "[species OH-] D = 5.27e-9 m2/s  initial = 1e-4 mol/m3\n[species Na+] D = 1.33e-9 m2/s  initial = " sodium "\n" \
    "[species Cl-] D = 2.03e-9 m2/s  initial = " sodium "\n[species Mg2+] D = 0.705e-9 m2/s\n" \
    "[reaction water] H2O = H+ + OH-  log10_K = -14\n[transport] D = 0.705e-9 m2/s\n"
#define BESIDE \
    "[grid] h = 50 um  m = 2  box = 0 um .. 400 um" ACROSS("0 um .. 300 um") "\n[side x-] species = inlet\n" \
    "[shape pin] box = 150 um .. 400 um" ACROSS("0 um .. 150 um") "  kind = solid  material = mg4ag\n"
#define SPECIES_STATE \
    BESIDE IONS("1.2 mol/m3", "") "[surface theta] initial = 0.05 + 0.02*x/(1 mm)  max = 1  min = 0" \
    "  rate = (1 - theta)*[Mg2+]/(0.5 mol/m3 + [Mg2+])/(14 s)\n[dissolve] rate = 3.4 um/s*10^(0.1*(7 - pH))" \
    "*(1 - 0.8*theta)  reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)\n" \
    "[run] until = 14 s  rtol = 0.01\n[output] every = 7 s  fields = Mg2+, pH, kind  images = pH" SLICE "\n[total e]\n"
#define SPECIES_ELECTRODES \
    BESIDE IONS("10 mol/m3", "  migration = yes") "[potential]\n" \
    "[electrode pin] shape = pin  curve = expression  range = -2 V .. -0.5 V" \
    "  i = -1e3 A/m2*10^(-(E + 1.4 V)/(120 mV))  reaction = 2 H2O + 2 e- = H2(g) + 2 OH-\n" \
    "[dissolve] current = 2e4 A/m2*10^((E + 1.4 V)/(100 mV))  reaction = Mg = Mg2+ + 2 e-\n" \
    "[run] until = 60 s  rtol = 0.02  max_step = 10 s\n" \
    "[output] every = 30 s  fields = Mg2+, potential, kind\n[total e]\n"
#define SPECIES_MINERAL \
    BESIDE IONS( \
        "10 mol/m3", \
        "  covering_thickness = 20 um") "[species Mg(OH)2(s)] volume = 24.6e-6 m3/mol\n" \
                                        "[reaction brucite] Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O  log10_K = 16.84\n" \
                                        "[mineral Mg(OH)2(s)] rate = 1e-7 mol/m2/s  area = 1e4 1/m\n" \
                                        "[dissolve] rate = 20 um/s*10^(0.1*(7 - pH))  reaction = Mg + 2 H2O = Mg2+ + " \
                                        "2 OH- + H2(g)\n" \
                                        "[run] until = 10 s  rtol = 0.02\n[output] every = 5 s  fields = Mg2+, pH, " \
                                        "film, kind\n[total e]\n"

static const struct {
    const char *name, *text;
} kinds[] = {{"coupled", COUPLED},
             {"two metals at rest", AT_REST},
             {"implicit flow", IMPLICIT},
             {"explicit flow", EXPLICIT},
             {"given flow", GIVEN},
             {"corrosion, diffusion", CORRODE_DIFFUSION},
             {"corrosion, random breaking and films", CORRODE_RANDOM},
#if PD_DIM == 2
             {"metal that breaks", SOLID_BREAKS},
             {"metal that breaks and dissolves", SOLID_DISSOLVES},
             {"springs in motion", SOLID_MOVES},
             {"species, a law in pH and a state", SPECIES_STATE},
             {"species, electrodes", SPECIES_ELECTRODES},
             {"species, a mineral that covers", SPECIES_MINERAL},
#endif
             {"corrosion, activation", CORRODE_ACTIVATION}};
#define KINDS ((int)(sizeof kinds / sizeof kinds[0]))

/* All bytes of a file; NULL: it cannot be read. The caller frees them. */
static inline char *bytes_of(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    char *bytes = NULL;
    *size = 0;
    if (!file) return NULL;
    if (fseek(file, 0, SEEK_END) == 0) {
        *size = (size_t)ftell(file);
        rewind(file);
        bytes = (char *)malloc(*size + 1);
        if (bytes && fread(bytes, 1, *size, file) != *size) *size = 0;
    }
    fclose(file);
    return bytes;
}

/* Files of folder `a` that are not the same in folder `b`. */
static inline int others(const char *a, const char *b, int *files)
{
    DIR *all = opendir(path_of(a));
    struct dirent *entry;
    int count = 0;
    *files = 0;
    if (!all) return 1;
    while ((entry = readdir(all)) != NULL) {
        char one[600], two[600];
        size_t size, other;
        if (entry->d_name[0] == '.') continue;
        snprintf(one, sizeof one, "%.200s/%.250s", path_of(a), entry->d_name);
        snprintf(two, sizeof two, "%.200s/%.250s", path_of(b), entry->d_name);
        char *x = bytes_of(one, &size), *y = bytes_of(two, &other);
        int same = x && y && size == other && memcmp(x, y, size) == 0;
        if (!same) NOTE("%s: %.0f bytes in %s, %.0f in %s", entry->d_name, (double)size, a, (double)other, b);
        count += !same;
        ++*files;
        free(x);
        free(y);
    }
    closedir(all);
    return count;
}

/* Both folders hold the same files with the same bytes. */
static inline int same_folders(const char *a, const char *b)
{
    int files, more;
    return CHECK_INT(others(a, b, &files), 0) && CHECK_INT(others(b, a, &more), 0) && CHECK(files > 3);
}

#endif
