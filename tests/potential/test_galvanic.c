/* galvanic: the electric potential in scenes: mixed potentials, gaps with a drop of potential, metal that dissolves by
 * the current, conductivity of species, checkpoints, threads, bad input; against closed forms.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "physics/sample.h"
#include "run/field_view.h"
#include "checkpoint_model.h"
#include "scene_file.h"
#include "model_scene.h"
#include "cases/film.h"

#define FARADAY 96485.33212331001
#if PD_DIM == 1
#define BOX(h, x) "[grid] h = " h "  box = 0 .. " x "  threads = 1\n"
#define ACROSS ""
#define SPAN
#define DEEP 1.0 /* [m^(d-1)] area */
#define STEADY "2 A" /* 2 A/m2 */
#else
#define BOX(h, x) "[grid] h = " h "  box = 0 .. " x ", 0 .. 0.4 mm  threads = 1\n"
#define ACROSS "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#define SPAN ", 0 .. 0.4 mm"
#define DEEP 0.4e-3
#define STEADY "0.8 mA"
#endif
/* Two plates, from 0 to 1 mm and from 3 to 4 mm, of magnesium and of steel. */
#define PLATES \
    BOX("0.1 mm", "4 mm") ACROSS "[shape left] box = 0 .. 1 mm" SPAN "  kind = solid  material = mg4ag\n" \
    "[shape right] box = 3 mm .. 4 mm" SPAN "  kind = solid  material = steel304\n"
#define MG_SPEED (24.305e-3 / 1738.0 / (2.0 * FARADAY)) /* [m3/C] */

static pd_cell_electrode electrode(int k)
{
    pd_cell_electrode e;
    pd_cell_electrode_of(&model.cell, k, &e);
    return e;
}

/* ---- at rest ---- */

/* Hoeche's curves of magnesium and aluminium, equal areas, in a good conductor. Shared table: -1.462456 V, 0.51928. */
TEST(mixed_potential)
{
    static const char text[] = PLATES "[potential] conductivity = 1e4 S/m\n"
        "[electrode mg] shape = left  " FILM_MG "[electrode al] material = steel304  connected = mg  " FILM_AL;
    if (!open_model(text, NULL, 0)) return;
    if (run_to(0.0)) {
        CHECK_INT(model.electrodes.circuits, 1);
        CHECK_NEAR(electrode(0).potential, -1.462456, 2e-6);
        CHECK_NEAR(electrode(1).potential, electrode(0).potential, 0.0);
        CHECK_REL(electrode(0).current, 0.51928 * DEEP, 2e-5);
        CHECK_REL(electrode(1).current, -electrode(0).current, 1e-12);
        CHECK_REL(electrode(0).area, DEEP, 1e-12);
    }
    close_model();
}

/* Linear curves over a gap: i = (U - U0)/(r + r + film + L/kappa), j and i are that, phi is linear. */
TEST(gap)
{
    static const char text[] = PLATES "[potential] conductivity = 2 S/m\n"
                                      "[electrode a] shape = left  curve = linear  polarisation_resistance = 1e-3 ohm "
                                      "m2  E0 = 0.1 V  potential = 1 V\n"
                                      "[electrode b] shape = right  curve = linear  polarisation_resistance = 2e-3 ohm "
                                      "m2  film_resistance = 5e-4 ohm m2  potential = 0\n";
    if (!open_model(text, NULL, 0)) return;
    if (run_to(0.0)) {
        double i = 0.9 / (1e-3 + 2e-3 + 5e-4 + 2e-3 / 2.0);
        double x[2] = {2.03e-3, 0.2e-3}, at = 1.0 - 0.1 - 1e-3 * i - i * 1.03e-3 / 2.0;
        CHECK_REL(electrode(0).current, i * DEEP, 1e-11);
        CHECK_REL(electrode(1).current, -i * DEEP, 1e-11);
        CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_PHI, 0, x), at, 1e-11);
        double near = 0.0, far = 0.0;
        for (int32_t n = 0; n < model.grid.total; n++) {
            if (model.grid.kind[n] != PD_FLUID) continue;
            far = fmax(far, fabs(pd_sample_get_node(&model, PD_FIELD_CURRENT_FLUID, n) / i - 1.0));
            near = fmax(near, pd_sample_get_node(&model, PD_FIELD_CURRENT_METAL, n));
        }
        CHECK_LE(far, 1e-9);
        CHECK_REL(near, i, 1e-11);
    }
    close_model();
}

/* A given current that grows in time, and a side that holds the potential of the fluid. */
TEST(in_time)
{
    static const char text[] =
        BOX("0.1 mm", "4 mm") ACROSS "[shape left] box = 0 .. 1 mm" SPAN "  kind = solid\n[side x+] potential = 0.5 V\n"
                                     "[potential] conductivity = 2 S/m\n[electrode a] shape = left  curve = linear  "
                                     "polarisation_resistance = 1e-3 ohm m2  "
                                     "current = 3 mA * t/(1 s)\n[run] until = 4 s  max_step = 1 s\n";
    if (!open_model(text, NULL, 0)) return;
    for (int k = 0; k < 3 && run_to(k); k++) {
        double i = 3e-3 * k / DEEP;
        CHECK_NEAR(electrode(0).current, i * DEEP, 1e-12);
        CHECK_NEAR(electrode(0).potential, 0.5 + i * (1e-3 + 3e-3 / 2.0), 1e-11);
    }
    close_model();
}

/* kappa = F^2/(R T) sum z^2 D c of sodium chloride. */
TEST(species)
{
    static const char text[] = PLATES "[potential]\n"
        "[electrode a] shape = left  curve = primary  potential = 0.1 V\n"
        "[electrode b] shape = right  curve = primary  potential = 0 V\n[chemistry] time = steady\n"
        "[species Na+] D = 1.33e-9 m2/s  initial = 145 mM\n[species Cl-] D = 2.03e-9 m2/s  initial = 145 mM\n";
    if (!open_model(text, NULL, 0)) return;
    if (run_to(0.0)) {
        double kappa = FARADAY * FARADAY / (8.31446261815324 * 298.15) * (1.33e-9 + 2.03e-9) * 145.0;
        CHECK_NEAR(kappa, 1.83, 2e-3);
        CHECK_REL(electrode(0).current, DEEP * 0.1 * kappa / 2e-3, 1e-9);
    }
    close_model();
}

/* ---- half-reactions ---- */

#define SEA \
    "[transport] D = 1e-9 m2/s\n[chemistry] activity = ideal\n[species O2] D = 2e-9 m2/s  initial = 0.25 mM\n" \
    "[species OH-] D = 5.27e-9 m2/s  initial = 1e-4 mM\n[species Mg2+] D = 0.7e-9 m2/s\n" \
    "[species Na+] D = 1.33e-9 m2/s  initial = 500 mM\n[species Cl-] D = 2.03e-9 m2/s  initial = 499.9999 mM\n"

static double amount(const char *species)
{
    const pd_electrolyte *e = &setup.electrolyte;
    double sum = 0.0;
    const double *c = pd_reactive_field(&model.reactive, pd_electrolyte_find_species(e, species));
    for (int32_t i = 0; i < model.grid.total; i++)
        if (model.grid.kind[i] == PD_FLUID) sum += c[i];
    return sum * model.stencil.volume;
}

/* Currents bring and take species by Faraday's law; what both electrodes bring is neutral. */
TEST(half_reactions)
{
    static const char text[] =
        PLATES "[potential] conductivity = 0.5 S/m\n"
               "[electrode mg] shape = left  curve = linear  polarisation_resistance = 1 ohm m2  connected = steel\n"
               "  reaction = Mg = Mg2+ + 2 e-\n"
               "[electrode steel] shape = right  curve = linear  polarisation_resistance = 1 ohm m2  E0 = 0.01 V\n"
               "  reaction = O2 + 2 H2O + 4 e- = 4 OH-\n" SEA "[run] until = 4 h\n";
    if (!open_model(text, NULL, 0)) return;
    double o2 = amount("O2"), oh = amount("OH-"), mg = amount("Mg2+"), na = amount("Na+");
    if (run_to(4.0 * 3600.0)) {
        double charge = electrode(0).current * 4.0 * 3600.0;
        pd_reactive_balance b;
        CHECK_REL(electrode(0).current, 0.01 / (2.0 + 2e-3 / 0.5) * DEEP, 1e-9);
        CHECK_REL((amount("Mg2+") - mg) * 2.0 * FARADAY, charge, 1e-9);
        CHECK_REL((o2 - amount("O2")) * 4.0 * FARADAY, charge, 1e-9);
        CHECK_REL((amount("OH-") - oh) * FARADAY, charge, 1e-9);
        CHECK_REL(electrode(0).charge, charge, 1e-12);
        CHECK_REL(electrode(0).passed, charge, 1e-12);
        CHECK_REL(electrode(1).charge, -charge, 1e-9);
        CHECK_NEAR(electrode(1).passed, 0.0, 0.0);
        CHECK_NEAR(electrode(0).lost, 0.0, 0.0);
        CHECK_REL(amount("Na+"), na, 1e-12);
        pd_reactive_balance_of(&ctx, &model.reactive, model.reactive.rows - 1, &b);
        CHECK_STR(b.name, "charge");
        CHECK_LE(fabs(b.in - b.out) * FARADAY, 1e-9 * charge);
    }
    close_model();
}

/* ---- metal that goes ---- */

/* The charge that has passed is that of the metal lost, whatever the potential does on the way. */
TEST(faraday)
{
    static const char text[] = PLATES "[potential] conductivity = 0.5 S/m\n"
        "[electrode mg] shape = left  curve = butler_volmer  i0 = 0.1 A/m2  E0 = -1.5 V  anodic_slope = 60 mV\n"
        "  cathodic_slope = 120 mV  current = " STEADY "\n"
        "[electrode b] shape = right  curve = tafel  i0 = 0.01 A/m2  E0 = -0.6 V  cathodic_slope = 150 mV\n"
        "  potential = 0 V\n[transport] D = 1e-9 m2/s\n[dissolve mg4ag] current = i\n"
        "[dissolve steel304] rate = 0\n[run] until = 10 day\n";
    if (!open_model(text, NULL, 0)) return;
    if (run_to(10.0 * 86400.0)) {
        const pd_mass_balance *l = &model.time_loop.ledger[0];
        double charge = electrode(0).current * 10.0 * 86400.0, lost = l->solid_start - l->solid;
        CHECK_REL(electrode(0).current, 2.0 * DEEP, 1e-11);
        CHECK_REL(lost * 2.0 * FARADAY, charge, 1e-9);
        CHECK_REL(electrode(0).charge, charge, 1e-12);
        CHECK_REL(electrode(0).lost, lost, 1e-12);
        CHECK_NEAR(electrode(1).lost, 0.0, 0.0);
        CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
    }
    close_model();
}

/* As the metal goes the gap grows, and with it the drop: r L + L^2/(2 kappa) grows by U V t. */
TEST(growing_gap)
{
    static const char text[] =
        PLATES "[potential] conductivity = 0.05 S/m\n"
               "[electrode mg] shape = left  curve = linear  polarisation_resistance = 2e-2 ohm m2  potential = 0.3 V\n"
               "[electrode b] shape = right  curve = linear  polarisation_resistance = 1e-2 ohm m2  potential = 0 V\n"
               "[transport] D = 1e-9 m2/s\n[dissolve mg4ag] current = i\n[dissolve steel304] rate = 0\n"
               "[run] until = 40 day  max_dissolved_fraction = 0.1\n";
    if (!open_model(text, NULL, 0)) return;
    if (run_to(40.0 * 86400.0)) {
        const pd_mass_balance *l = &model.time_loop.ledger[0];
        double kappa = 0.05, r = 3e-2, from = 2e-3, lost = (l->solid_start - l->solid) / setup.metal[0].solid_c / DEEP;
        double right = r * from + from * from / (2.0 * kappa) + 0.3 * MG_SPEED * 40.0 * 86400.0;
        double gap = kappa * (sqrt(r * r + 2.0 * right / kappa) - r);
        CHECK(gap - from > 5e-4);
        CHECK_REL(lost, gap - from, 1e-2);
        CHECK_REL(electrode(0).current, DEEP * 0.3 / (r + gap / kappa), 5e-3);
    }
    close_model();
}

/* Magnesium on steel corrodes freely until it is gone. The steel that is left can reduce alone: no current passes. */
TEST(bared)
{
    static const char text[] = BOX("0.1 mm", "3 mm") ACROSS
        "[shape steel] box = 0 .. 1 mm" SPAN "  kind = solid  material = steel304\n"
        "[shape mg] box = 1 mm .. 1.2 mm" SPAN "  kind = solid  material = mg4ag\n[potential] conductivity = 1 S/m\n"
        "[electrode mg] shape = mg  curve = butler_volmer  i0 = 1 A/m2  E0 = -1.5 V  anodic_slope = 60 mV\n"
        "  cathodic_slope = 60 mV\n[electrode steel] shape = steel  curve = tafel  i0 = 0.01 A/m2  E0 = -0.6 V\n"
        "  cathodic_slope = 150 mV\n[transport] D = 1e-9 m2/s\n"
        "[dissolve mg4ag] current = 1 A/m2*10^((E + 1.5 V)/(60 mV))\n[dissolve steel304] rate = 0\n"
        "[run] until = 60 day\n";
    if (!open_model(text, NULL, 0)) return;
    if (run_to(60.0 * 86400.0)) {
        CHECK_INT(model.grid.solid_count, model.time_loop.solid_nodes_start * 10 / 12);
        CHECK_NEAR(electrode(1).current, 0.0, 0.0);
        CHECK_NEAR(electrode(0).area, 0.0, 0.0);
        CHECK_REL(electrode(1).area, DEEP, 1e-12);
        CHECK_INT(electrode(1).touches, PD_CELL_IDLE);
        CHECK_INT(electrode(0).touches, PD_CELL_APART);
        CHECK(isnan(electrode(1).potential) && isnan(electrode(0).potential));
    }
    close_model();
}

#if PD_DIM == 2
#define STREAM \
    "[grid] h = 25 um  box = 0 .. 1 mm, 0 .. 0.8 mm  threads = 1\n" \
    "[side x-] flow = inlet  profile = parabola  mean = 0.1 mm/s\n[side x+] flow = outlet\n" \
    "[flow] rho = 1000 kg/m3  mu = 1 mPa s\n[transport] D = 1e-9 m2/s\n" \
    "[shape disc] ball = 0.4 mm, 0.41 mm  radius = 0.2 mm  kind = solid  material = mg4ag\n"
#define FREE \
    "[electrode disc] shape = disc  curve = butler_volmer  i0 = 2 A/m2  E0 = -1.5 V  anodic_slope = 60 mV\n" \
    "  cathodic_slope = 120 mV\n"

/* A disc that corrodes freely in a stream: no current leaves it, its potential is that of corrosion, and it goes as by
 * a constant speed, whatever the fluid conducts. */
TEST(free_disc)
{
    static const char *const texts[] = {
        STREAM "[dissolve] current = 2 A/m2\n[run] until = 2 day  rtol = 2e-4\n",
        STREAM "[potential] conductivity = 0.01 S/m\n" FREE
               "[dissolve] current = 2 A/m2*10^((E + 1.5 V)/(60 mV))\n[run] until = 2 day  rtol = 2e-4\n",
        STREAM "[potential] conductivity = 10 S/m\n" FREE
               "[dissolve] current = 2 A/m2*10^((E + 1.5 V)/(60 mV))\n[run] until = 2 day  rtol = 2e-4\n"};
    double loss[3];
    for (int k = 0; k < 3; k++) {
        if (!open_model(texts[k], NULL, 0)) return;
        if (!run_to(2.0 * 86400.0)) return;
        loss[k] = pd_time_loop_volume_loss(&model.time_loop);
        if (k) CHECK_NEAR(electrode(0).potential - model.cell.potential.phi[model.cell.potential.contacts.list[0].node],
                          -1.5, 1e-12);
        if (k) CHECK_NEAR(electrode(0).most, 0.0, 1e-12);
        if (!k) CHECK(model.cell.grid == NULL && model.bytes[PD_PART_POTENTIAL] == 0);
        close_model();
    }
    double left = 1.0 - MG_SPEED * 2.0 * 2.0 * 86400.0 / 0.2e-3;
    CHECK_REL(1.0 - loss[0], left * left, 0.02);
    CHECK_NEAR(loss[1], loss[0], 3e-6); /* steps that follow a potential are others */
    CHECK_NEAR(loss[2], loss[1], 1e-9);
}
#endif

/* ---- state ---- */

static void couple_scene(char *text, size_t size, int threads)
{
    snprintf(text, size,
#if PD_DIM == 2
             "[grid] h = 50 um  box = 0 .. 2 mm, -0.5 mm .. 1 mm  threads = %d\n"
             "[shape mg] box = 0 .. 1 mm, -0.5 mm .. 0 mm  kind = solid  material = mg4ag\n"
             "[shape steel] box = 1 mm .. 2 mm, -0.5 mm .. 0 mm  kind = solid  material = steel304\n"
#else
             "[grid] h = 50 um  box = 0 .. 4 mm  threads = %d\n"
             "[shape mg] box = 0 .. 1 mm  kind = solid  material = mg4ag\n"
             "[shape steel] box = 3 mm .. 4 mm  kind = solid  material = steel304\n"
#endif
             "[potential] conductivity = 0.5 S/m\n[electrode mg] shape = mg  curve = butler_volmer  i0 = 0.1 A/m2\n"
             "E0 = -1.5 V  anodic_slope = 60 mV  cathodic_slope = 120 mV  connected = steel\n"
             "[electrode steel] shape = steel  curve = tafel  i0 = 0.01 A/m2  E0 = -0.6 V  cathodic_slope = 150 mV\n"
             "cathodic_limit = 5 A/m2\n[transport] D = 1e-9 m2/s\n[dissolve mg4ag] current = i\n"
             "[dissolve steel304] rate = 0\n[run] until = 8 day\n", threads);
}

static double saved_phi[20000], saved_c[20000];
static double saved_charge[4];
static int32_t saved;

static void keep(void)
{
    saved = model.grid.total;
    if (!CHECK(saved <= 20000)) return;
    memcpy(saved_phi, model.cell.potential.phi, (size_t)saved * sizeof *saved_phi);
    memcpy(saved_c, model.transport.c, (size_t)saved * sizeof *saved_c);
    for (int e = 0; e < 2; e++) {
        saved_charge[2 * e] = electrode(e).charge;
        saved_charge[2 * e + 1] = electrode(e).lost;
    }
}

static void same(void)
{
    CHECK_INT(saved, model.grid.total);
    CHECK(memcmp(saved_phi, model.cell.potential.phi, (size_t)saved * sizeof *saved_phi) == 0);
    CHECK(memcmp(saved_c, model.transport.c, (size_t)saved * sizeof *saved_c) == 0);
    for (int e = 0; e < 2; e++) {
        CHECK_NEAR(electrode(e).charge, saved_charge[2 * e], 0.0);
        CHECK_NEAR(electrode(e).lost, saved_charge[2 * e + 1], 0.0);
    }
}

/* A run that goes on from a checkpoint has the bits of one that was never stopped; so has one with more threads. */
TEST(state)
{
    char text[1500];
    need_folder();
    couple_scene(text, sizeof text, 1);
    if (!open_model(text, NULL, 0)) return;
    if (!run_to(5.0 * 86400.0)) return;
    CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("half"), &model));
    if (!run_to(8.0 * 86400.0)) return;
    keep();
    close_model();
    if (!open_model(text, NULL, 0)) return;
    if (CHECK_OK(&ctx, checkpoint_load(&ctx, path_of("half"), &model))) {
        CHECK_REL(electrode(0).current, -electrode(1).current, 1e-12);
        if (run_to(8.0 * 86400.0)) same();
    }
    close_model();
    couple_scene(text, sizeof text, 2);
    if (!open_model(text, NULL, 0)) return;
    ctx.threads = 2;
    if (run_to(5.0 * 86400.0) && run_to(8.0 * 86400.0)) same();
    close_model();
}

/* ---- bad input ---- */

#define OPEN PLATES "[potential] conductivity = 1 S/m\n"
#define A "[electrode a] shape = left  curve = linear  polarisation_resistance = 1 ohm m2\n"
#define B "[electrode b] shape = right  curve = linear  polarisation_resistance = 1 ohm m2\n"

TEST(refused)
{
    static const char *const bad[][2] = {
        {OPEN, "no electrode"},
        {OPEN "[chemistry] migration = yes\n[species Na+] D = 1e-9 m2/s\n[species Cl-] D = 1e-9 m2/s\n" A B,
         "migration"},
        {PLATES "[potential]\n" A B, "found none, expected [potential] conductivity"},
        {PLATES A B, "found none, expected [potential] conductivity"},
        {PLATES "[potential] conductivity = 1\n" A B, "unit"},
        {PLATES "[potential] conductivity = -1 S/m\n" A B, "expected"},
        {OPEN B "[electrode a] curve = linear  polarisation_resistance = 1 ohm m2\n", "neither a shape nor a material"},
        {OPEN B "[electrode a] shape = left  material = mg4ag  curve = linear  polarisation_resistance = 1 ohm m2\n",
         "a shape and"},
        {OPEN B "[electrode a] shape = no  curve = linear  polarisation_resistance = 1 ohm m2\n", "which is no shape"},
        {OPEN B "[electrode a] material = copper  curve = linear  polarisation_resistance = 1 ohm m2\n", "'copper'"},
        {OPEN B "[electrode a] shape = left\n", "no polarisation curve"},
        {OPEN B "[electrode a] shape = left  curve = linear  polarisation_resistance = 1\n", "unit"},
        {OPEN B "[electrode a] shape = left  curve = tafel  i0 = 1  anodic_slope = 60 mV\n", "unit"},
        {OPEN B "[electrode a] shape = left  curve = tafel  i0 = 1 A/m2\n", "found 0 of anodic_slope"},
        {OPEN B "[electrode a] shape = left  curve = butler_volmer  i0 = 1 A/m2  anodic_slope = 1 mV\n", "found 1 of"},
        {OPEN B "[electrode a] shape = left  curve = linear  polarisation_resistance = 1 ohm m2  i0 = 1 A/m2\n", "i0"},
        {OPEN B "[electrode a] shape = left  curve = expression  i = -1 A/m2*E/(1 V)  range = -1 V .. 1 V\n", "falls"},
        {OPEN B "[electrode a] shape = left  curve = expression  i = 1 A/m2/(E/(1 V))  range = 0 V .. 1 V\n",
         "expected a number"},
        {OPEN A B "[electrode a] potential = 1 V  current = 1 A\n", "found beside 'potential'"},
        {OPEN A B "[electrode a] potential = 1 V * x/(1 m)\n", "function of the place"},
        {OPEN A B "[electrode a] potential = 1 V * t/(1 s)\n", "function of t"},
        {OPEN A B "[electrode a] reaction = O2 + 2 H2O + 4 e- = 4 OH-\n", "found without species"},
        {OPEN A B SEA "[run] until = 1 s\n[electrode a] reaction = O2 + 2 H2O + 3 e- = 4 OH-\n", "the charge is"},
        {OPEN A B SEA "[run] until = 1 s\n[electrode a] reaction = O2 + 3 H2O + 4 e- = 4 OH-\n", "does not balance"},
        {OPEN A B SEA "[run] until = 1 s\n[electrode a] reaction = Mg2+ + 2 OH- = Mg + O2 + H2(g)\n", "no e-"},
        {OPEN A B "[electrode a] connected = c\n", "'c', expected the name of another"},
        {OPEN A B "[electrode a] connected = a\n", "'a', expected the name of another"},
        {OPEN A B "[electrode a] connected = b  potential = 1 V\n[electrode b] current = 1 A\n", "connected"},
        {OPEN A B "[side x+] flow = mirror  potential = 1 V\n", "no wall and no inlet"},
        {OPEN A, "belongs to no electrode"},
        {OPEN A B "[electrode c] shape = left  curve = linear  polarisation_resistance = 1 ohm m2\n", "a has no metal"},
        {OPEN A B "[electrode a] current = 1 mA\n", "currents of all that electrode a hangs together with add up"},
        {OPEN "[electrode a] shape = left  curve = tafel  i0 = 1 A/m2  anodic_slope = 60 mV\n"
              "[electrode b] shape = right  curve = tafel  i0 = 1 A/m2  anodic_slope = 60 mV\n",
         "(electrode a)"},
        {OPEN A B "[constants] E = 1 Pa\n", "where it is a variable"}};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        pd_ctx_init(&ctx);
        pd_status status = pd_scene_parse(&ctx, "a.scene", bad[k][0], NULL, 0, &setup);
        if (status == PD_OK) {
            status = pd_model_build(&ctx, &setup, &model);
            if (status == PD_OK) status = pd_time_loop_run(&ctx, &model.time_loop, 0.0, 0.0, NULL, NULL);
            if (model.grid.kind) pd_model_free(&ctx, &model);
            pd_setup_free(&ctx, &setup);
        }
        if (!CHECK(status < 0) || !CHECK(strstr(ctx.message, bad[k][1]) != NULL))
            NOTE("case %d: '%s' lacks '%s'", (int)k, ctx.message, bad[k][1]);
        CHECK_INT(ctx.in_use, 0);
    }
}

#if PD_DIM == 2
#define PLANE ENTRY(free_disc)
#else
#define PLANE
#endif
TEST_MAIN(ENTRY(mixed_potential) ENTRY(gap) ENTRY(in_time) ENTRY(species) ENTRY(half_reactions) ENTRY(faraday)
          ENTRY(growing_gap) ENTRY(bared)
          PLANE ENTRY(state) ENTRY(refused))
