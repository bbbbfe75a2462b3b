/* coat: states of surfaces in scenes: the film of Hoeche's couple against an integrator of its own, closed forms, order
 * in time, bounds, metal that goes, checkpoints, threads, bad input.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "setup/fields.h"
#include "physics/sample.h"
#include "checkpoint_model.h"
#include "scene_file.h"
#include "model_scene.h"
#include "cases/film.h"

#define FARADAY 96485.33212331001
#if PD_DIM == 1
#define BOX(h, x) "[grid] h = " h "  box = 0 .. " x "  threads = 1\n"
#define SPAN
#define DEEP 1.0 /* [m^(d-1)] area */
#else
#define BOX(h, x) "[grid] h = " h "  box = 0 .. " x ", 0 .. 0.4 mm  threads = 1\n" \
    "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#define SPAN ", 0 .. 0.4 mm"
#define DEEP 0.4e-3
#endif
/* Two plates, from 0 to 1 mm and from 3 to 4 mm. */
#define PLATES \
    BOX("0.2 mm", "4 mm") "[shape left] box = 0 .. 1 mm" SPAN "  kind = solid  material = mg4ag\n" \
    "[shape right] box = 3 mm .. 4 mm" SPAN "  kind = solid  material = steel304\n"

static double mean_of(int k)
{
    pd_surface_state_statistics f;
    pd_surface_states_compute_statistics(model.surface_states, k, &f);
    CHECK_LE(f.min - f.mean, 1e-12 * fabs(f.mean));
    CHECK_LE(f.mean - f.max, 1e-12 * fabs(f.mean));
    return f.mean;
}

static double mean_concentration(const char *species)
{
    const double *c = pd_reactive_field(&model.reactive, pd_electrolyte_find_species(&setup.electrolyte, species));
    double sum = 0.0;
    for (int32_t i = 0; i < model.grid.total; i++)
        if (model.grid.kind[i] == PD_FLUID) sum += c[i];
    return sum / (double)model.grid.fluid_count;
}

/* ---- the couple of Hoeche, well mixed ---- */

#define CURVES(al) \
    "[electrode mg] shape = left  current_factor = sqrt(theta)  " FILM_MG "  reaction = Mg = Mg2+ + 2 e-\n" \
    "[electrode al] material = steel304  connected = mg  " FILM_AL al "  reaction = 2 H2O + 2 e- = H2(g) + 2 OH-\n"
#define WATER(D, mg, oh) \
    "[chemistry] activity = ideal\n[species Mg2+] D = " D "  initial = " mg " mM\n" \
    "[species OH-] D = " D "  initial = " oh " mM\n"
#define COUPLE(D, mg, oh) \
    PLATES "[potential] conductivity = 1e4 S/m\n" CURVES("") FILM_STATES("mg") WATER(D, mg, oh) "[run] until = 100 h\n"

/* Coverage, pores and thickness after 2 and 8 h, with an electrolyte that mixes at once. */
TEST(film_of_a_couple)
{
    static const double times[] = {1800.0, 2.0 * 3600.0, 8.0 * 3600.0};
    double y[FILM_COUNT]; /* the pores close, to nothing after 8 h: their error is one of those of the start */
    if (!open_model(COUPLE("1e-2 m2/s", "0", "0"), NULL, 0)) return;
    for (int k = 0; k < 3; k++) {
        if (!run_to(times[k])) break;
        pd_cell_electrode e;
        pd_cell_electrode_of(&model.cell, 0, &e);
        film_mixed(times[k], 20000, 0.0, 0, y);
        NOTE("couple: %g s, %d steps (%d rejected): theta %.6f (%.6f), eps %.6f (%.6f), l %.6g (%.6g), E %.6f (%.6f), "
             "Mg %.5f (%.5f)",
             times[k], (int)model.species_integrator.steps, (int)model.species_integrator.rejected, mean_of(0), y[0],
             mean_of(1), y[1], mean_of(2), y[2], e.potential, film_potential(sqrt(y[0])), mean_concentration("Mg2+"),
             y[FILM_MG2]);
        CHECK_REL(mean_of(0), y[0], 1e-3);
        CHECK_NEAR(mean_of(1), y[1], 1e-4 * 0.55);
        CHECK_REL(mean_of(2), y[2], 2e-3);
        CHECK_REL(mean_concentration("Mg2+"), y[FILM_MG2], 2e-4);
        CHECK_REL(mean_concentration("OH-"), y[FILM_OH], 2e-4);
        CHECK_NEAR(e.potential, film_potential(sqrt(y[0])), 1e-4);
    }
    close_model();
}

/* As published: both currents have the factor, and the potential is that of equal areas for ever. */
TEST(film_as_published)
{
    static const char text[] = PLATES "[potential] conductivity = 1e4 S/m\n" CURVES("  factor = sqrt(theta)\n")
        FILM_STATES("mg, al") WATER("1e-2 m2/s", "0", "0") "[run] until = 100 h\n";
    double y[FILM_COUNT];
    if (!open_model(text, NULL, 0)) return;
    for (double t = 1800.0; t < 8000.0; t *= 2.0) {
        if (!run_to(t)) break;
        pd_cell_electrode e;
        pd_cell_electrode_of(&model.cell, 0, &e);
        film_mixed(t, 20000, 0.0, 1, y);
        NOTE("published: %g s: theta %.6f (%.6f), l %.6g (%.6g), E %.7f V, %.6f A/m2", t, mean_of(0), y[0], mean_of(2),
             y[2], e.potential, e.current / e.area);
        CHECK_NEAR(e.potential, -1.462456, 1e-4);
        CHECK_REL(e.current / e.area, sqrt(y[0]) * 0.51928, 5e-4);
        CHECK_REL(mean_of(0), y[0], 1e-3);
        CHECK_REL(mean_of(2), y[2], 2e-3);
    }
    close_model();
}

/* ---- order in time ---- */

/* With half the steps the error is a quarter. The cover goes its way in 20 s. */
TEST(order_in_time)
{
    double y[FILM_COUNT], error[3][3];
    film_mixed(1200.0, 20000, 2.0, 0, y);
    for (int k = 0; k < 3; k++) {
        char step[64];
        const char *overrides[] = {step, "run.rtol=0.1"};
        snprintf(step, sizeof step, "run.max_step=%g s", 18.75 / (1 << k));
        if (!open_model(COUPLE("1e-2 m2/s", "2", "4"), overrides, 2)) return;
        if (run_to(1200.0)) {
            CHECK_INT(model.species_integrator.rejected, 0);
            error[k][0] = fabs(mean_of(0) / y[0] - 1.0);
            error[k][1] = fabs(mean_of(2) / y[2] - 1.0);
            error[k][2] = fabs(mean_concentration("OH-") / y[FILM_OH] - 1.0);
            NOTE("order: %d steps: theta %.3e, l %.3e, OH- %.3e", (int)model.species_integrator.steps, error[k][0],
                 error[k][1], error[k][2]);
        }
        close_model();
    }
    for (int m = 0; m < 3; m++) {
        CHECK_LE(error[2][m], error[0][m] / 13.0);
        CHECK_LE(error[1][m], error[0][m] / 3.5);
    }
}

/* ---- closed forms ---- */

/* A plate that gives a constant current into fluid at rest: c = 2 N sqrt(t/(pi D)) at its surface, where a film grows
 * by k c and covers by (1 - theta) q c. Away from it the other plate takes the current. */
#define GROWTH \
    "[potential] conductivity = 1 S/m\n" \
    "[electrode mg] shape = left  curve = linear  polarisation_resistance = 1 ohm m2  current = 0.5 A*(" AREA ")\n" \
    "  reaction = Mg = Mg2+ + 2 e-\n" \
    "[electrode steel] shape = right  curve = linear  polarisation_resistance = 1 ohm m2  current = -0.5 A*(" AREA \
    ")\n" \
    "  reaction = Cl2 + 2 e- = 2 Cl-\n" \
    "[chemistry] activity = ideal\n[species Mg2+] D = 1e-9 m2/s  initial = 1 mM\n" \
    "[species Cl-] D = 1e-9 m2/s  initial = 2 mM\n[species Cl2] D = 1e-9 m2/s  initial = 100 mM\n" \
    "[surface l] of = mg  initial = 1 nm  rate = 2e-13 m4/mol/s*([Mg2+] - 1 mM)\n" \
    "[surface theta] of = mg  initial = 0.1  rate = (1 - theta)*2e-4 m3/mol/s*([Mg2+] - 1 mM)\n" \
    "[run] until = 1 h\n"
#if PD_DIM == 1
#define AREA "1"
#else
#define AREA "0.4e-3"
#endif

TEST(behind_a_diffusion_layer)
{
    double error[2];
    for (int k = 0; k < 2; k++) {
        const char *overrides[] = {k ? "grid.h=0.05 mm" : "grid.h=0.1 mm", "run.rtol=1e-5"};
        if (!open_model(PLATES GROWTH, overrides, 2)) return;
        double t = 300.0, flux = 0.5 / (2.0 * FARADAY), sum = 4.0 / 3.0 * flux * t * sqrt(t / (acos(-1.0) * 1e-9));
        if (run_to(t)) {
            error[k] = fabs(mean_of(0) - 1e-9 - 2e-13 * sum) / (2e-13 * sum);
            NOTE("layer: l off by %.2e, theta by %.2e, %d steps", error[k],
                 fabs(mean_of(1) - 1.0 + 0.9 * exp(-2e-4 * sum)), (int)model.species_integrator.steps);
            CHECK_LE(error[k], k ? 5e-3 : 2e-2);
            CHECK_REL(mean_of(1), 1.0 - 0.9 * exp(-2e-4 * sum), k ? 5e-3 : 2e-2);
        }
        close_model();
    }
    CHECK_LE(error[1], 0.35 * error[0]);
}

/* States without neighbours: decay, a state that reads another, a bound, the temperature, a law that turns off. */
#define STILL \
    PLATES \
    "[potential] conductivity = 1 S/m\n[electrode a] shape = left  curve = linear  polarisation_resistance = 1 " \
    "ohm m2\n" \
    "[electrode b] shape = right  curve = linear  polarisation_resistance = 1 ohm m2  E0 = 0.3 V  connected = a\n" \
    "[chemistry] activity = ideal  temperature = 300 K\n[species Na+] D = 1e-9 m2/s  initial = 1 mM\n" \
    "[species Cl-] D = 1e-9 m2/s  initial = 1 mM\n"

TEST(places_without_diffusion)
{
    static const char text[] = STILL
        "[surface decay] of = a  initial = 2 um  rate = -decay/(1 s)\n"
        "[surface sum] of = a  initial = 0 um s  rate = decay\n"
        "[surface full] of = a  initial = 0.2  max = 0.5  rate = 0.01/s\n"
        "[surface warm] initial = 1 K  rate = T/(100 s)\n"
        "[surface volt] initial = 0 V s  rate = E\n"
        "[surface charge] of = b  initial = 0 C/m2  rate = i\n"
        "[surface fast] of = b  initial = 1  rate = -1e6*(fast - 0.25)/s\n[run] until = 1 h\n";
    if (!open_model(text, NULL, 0)) return;
    if (run_to(100.0)) {
        pd_cell_electrode b;
        pd_cell_electrode_of(&model.cell, 1, &b);
        CHECK_NEAR(mean_of(0), 0.0, 1e-12);
        CHECK_REL(mean_of(1), 2e-6, 1e-12);
        CHECK_NEAR(mean_of(2), 0.5, 0.0); /* met at 30 s */
        CHECK_REL(mean_of(3), 1.0 + 300.0, 1e-9);
        CHECK_REL(mean_of(5), 100.0 * b.current / b.area, 1e-9);
        CHECK_REL(mean_of(6), 0.25, 1e-6);
        NOTE("still: %d steps, %d rejected", (int)model.species_integrator.steps,
             (int)model.species_integrator.rejected);
    }
    close_model();
}

/* A pulse of the factor of either electrode is met. The charge that has passed is that of resistances in series: one of
 * each electrode over its factor, one of 2 mm of the fluid. */
TEST(pulses_of_factors)
{
    for (int k = 0; k < 2; k++) {
        const char *overrides[] = {k ? "electrode.b.current_factor=q*(1 + 9*if(abs(t - 50 s) < 1 s,1,0))"
                                     : "electrode.a.current_factor=q*(1 + 9*if(abs(t - 50 s) < 1 s,1,0))"};
        static const char text[] = STILL "[surface q] initial = 1  rate = 0\n"
            "[surface charge] of = b  initial = 0 C/m2  rate = i\n[run] until = 100 s\n";
        if (!open_model(text, overrides, 1)) return;
        if (run_to(100.0)) CHECK_REL(fabs(mean_of(1)), 98.0 * 0.3 / 2.002 + 2.0 * 0.3 / 1.102, 1e-7);
        close_model();
    }
}

/* ---- metal that goes ---- */

/* A speed v theta, with theta' = -theta/tau: v tau (1 - exp(-t/tau)) in all, over many cells. The film goes with the
 * surface. */
#define GOING \
    "[dissolve] rate = 3 um/h*theta  reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)  Cs = 10 mol/m3\n" \
    "[transport] D = 1e-9 m2/s\n[chemistry] activity = ideal\n[species Mg2+] D = 1e-9 m2/s\n" \
    "[species OH-] D = 1e-9 m2/s\n[run] until = 100 h\n" \
    "[surface theta] initial = 1  min = 0  rate = -theta/(50 h)\n"

TEST(metal_that_goes)
{
    static const char text[] = BOX("10 um", "1 mm") "[shape left] box = 0 .. 0.5 mm" SPAN "  kind = solid\n" GOING;
    double tau = 50.0 * 3600.0, speed = 3e-6 / 3600.0;
    for (int k = 0; k < (PD_DIM == 1 ? 2 : 1); k++) { /* 5800 steps */
        const char *overrides[] = {k ? "run.rtol=1e-4" : "run.rtol=4e-3"};
        if (!open_model(text, overrides, 1)) return;
        if (run_to(100.0 * 3600.0)) {
            double gone = speed * tau * (1.0 - exp(-2.0)), loss = pd_time_loop_volume_loss(&model.time_loop) * 0.5e-3;
            NOTE("going: %g of %g m (%.2e), theta %.6f, %d steps, %d nodes have turned", loss, gone, loss / gone - 1.0,
                 mean_of(0), (int)model.species_integrator.steps,
                 (int)(model.time_loop.solid_nodes_start - model.grid.solid_count));
            CHECK_REL(loss, gone, 2e-4);
            CHECK_REL(mean_of(0), exp(-2.0), 1e-6);
            CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
        }
        close_model();
    }
}

/* ---- steps ---- */

/* Steps that are proposed a thousand times too long are made shorter: theta = 1/(1 + t), and its integral. */
TEST(long_steps)
{
    static const char text[] = STILL
        "[surface a1] of = a  initial = 1  rate = -a1^2/(1 s)\n[surface a2] of = a  initial = 0  rate = a1/(1 s)\n"
        "[run] until = 1000 h\n";
    if (!open_model(text, NULL, 0)) return;
    if (run_to(3.6e6)) {
        CHECK_REL(mean_of(0), 1.0 / (1.0 + 3.6e6), 1e-4);
        CHECK_REL(mean_of(1), log(1.0 + 3.6e6), 1e-6);
        NOTE("long: %d steps, %d rejected", (int)model.species_integrator.steps,
             (int)model.species_integrator.rejected);
    }
    close_model();
}

/* ---- states of runs ---- */

static double saved[4096];
static int32_t saved_count;

static void keep(void)
{
    saved_count = 0;
    for (int k = 0; k < setup.states; k++)
        for (int32_t i = 0; i < model.grid.total && saved_count < 2000; i++)
            saved[saved_count++] = model.surface_states->state_solver.value[(int64_t)k * model.grid.total + i];
    for (int32_t i = 0; i < model.grid.total && saved_count < 4000; i++) saved[saved_count++] = model.reactive.c[i];
}

static void same(void)
{
    double before[4096];
    int32_t count = saved_count;
    memcpy(before, saved, sizeof before);
    keep();
    CHECK_INT(saved_count, count);
    CHECK(memcmp(before, saved, (size_t)count * sizeof *saved) == 0);
}

static void continued(const char *text, double first, double end)
{
    need_folder();
    if (!open_model(text, NULL, 0)) return;
    if (!run_to(first)) return;
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("half"), &model));
    if (!run_to(end)) return;
    keep();
    close_model();
    if (!open_model(text, NULL, 0)) return;
    if (CHECK_OK(&ctx, checkpoint_load(&ctx, path_of("half"), &model)) && run_to(end)) same();
    close_model();
    for (int threads = 2; threads <= 3; threads++) {
        if (!open_model(text, NULL, 0)) return;
        ctx.threads = threads;
        if (run_to(first) && run_to(end)) same();
        close_model();
    }
}

/* A run that goes on from a checkpoint has the bits of one that was never stopped; so has one with more threads. */
TEST(state)
{
    continued(COUPLE("1e-9 m2/s", "0.5", "1"), 900.0, 3000.0);
    continued(STILL "[surface volt] of = a  initial = 0  rate = (E - volt*(1 V))/(1 V s)\n[surface pass] of = b\n"
              "initial = 0 C/m2  rate = i*(1 + [Na+]/(1 mM))\n[run] until = 1 h\n", 3.0, 30.0);
    continued(BOX("10 um", "1 mm") "[shape left] box = 0 .. 0.5 mm" SPAN "  kind = solid\n" GOING, 3e4, 8e4);
}

/* What is seen of states: fields, labels, tables. */
TEST(seen)
{
    char unit[PD_UNITS_TEXT];
    if (!open_model(COUPLE("1e-9 m2/s", "0", "0"), NULL, 0)) return;
    if (run_to(100.0)) {
        int l = pd_fields_find(&setup, "l");
        double x[PD_DIM];
        CHECK_STR(pd_fields_get_label(&setup, (pd_field)l), "l [m]");
        pd_fields_get_unit(&setup, (pd_field)pd_fields_find(&setup, "theta"), unit);
        CHECK_STR(unit, "");
        CHECK_INT(pd_fields_species_index(&setup, l), -1);
        CHECK_INT(pd_fields_state_index(&setup, l), 2);
        for (int d = 0; d < PD_DIM; d++) x[d] = 0.2e-3;
        x[0] = 1e-3; /* the surface of magnesium; a cell of fluid */
        CHECK_REL(pd_sample_get_point(&model, (pd_field)l, 0, x), mean_of(2), 1e-12);
        x[0] = 2e-3;
        CHECK(isnan(pd_sample_get_point(&model, (pd_field)l, 0, x)));
        x[0] = 3e-3; /* the aluminium carries none */
        CHECK(isnan(pd_sample_get_point(&model, (pd_field)l, 0, x)));
        CHECK_INT(setup.monitors, 5);
        CHECK_STR(setup.monitor[4].name, "l");
    }
    close_model();
}

/* ---- bad input ---- */

#define ON STILL "[run] until = 1 h\n"
/* Metal of two electrodes, one of which carries the state q of its law, which stands in line 3. */
#define LAW(section, law, other) \
    "\n\n" section " " law "  reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)\n" BOX( \
        "0.2 mm", \
        "4 mm") "[shape left] box = 0 .. 1 mm" SPAN "  kind = solid  material = mg4ag\n" \
                "[shape right] box = 3 mm .. 4 mm" SPAN "  kind = solid  material = " other "\n[potential]\n" \
                "[electrode a] shape = left  curve = linear  polarisation_resistance = 1 ohm m2\n" \
                "[electrode b] shape = right  curve = linear  polarisation_resistance = 1 ohm m2  connected = a\n" \
                "[transport] D = 1e-9 m2/s\n[species Mg2+] D = 1e-9 m2/s  initial = 1 mM\n" \
                "[species OH-] D = 1e-9 m2/s  initial = 2 mM\n[surface q] initial = 1  of = a  rate = 0\n[run] until " \
                "= 1 h\n"
TEST(refused)
{
    static const char *const bad[][2] = {
        {ON "[surface Na+] initial = 1  rate = 0\n", "a short name of letters"},
        {ON "[species O2] D = 1e-9 m2/s\n[surface O2] initial = 1  rate = 0\n", "a species, expected another"},
        {ON "[surface pH] initial = 1  rate = 0\n", "a variable, expected another"},
        {ON "[surface E] initial = 1  rate = 0\n", "a variable, expected another"},
        {ON "[surface exp] initial = 1  rate = 0\n", "a name of expressions"},
        {ON "[constants] q = 1\n[surface q] initial = 1  rate = 0\n", "a constant"},
        {ON "[surface q] rate = 0\n", "initial"},
        {ON "[surface q] initial = 1 m\n", "rate"},
        {ON "[surface q] initial = 1 m  rate = 1/s\n", "expected a speed [m/s], that of q per time"},
        {ON "[surface q] initial = 1  rate = 1 m/s\n", "that of q per time"},
        {ON "[surface q] initial = 1 m  max = 3 s  rate = 0\n", "as of 'initial'"},
        {ON "[surface q] initial = 1  min = 2  rate = 0\n", "within its bounds"},
        {ON "[surface q] initial = 1  max = 0.5  rate = 0\n", "within its bounds"},
        {ON "[surface q] initial = x/(1 m)  max = 1e-3  rate = 0\n", "begins with"},
        {ON "[surface q] initial = 1  min = 2  max = 1  rate = 0\n", "min below max"},
        {ON "[surface q] initial = r  rate = 0\n[surface r] initial = 1  rate = 0\n", "'r'"},
        {ON "[surface q] initial = 1  rate = theta/s\n", "theta"},
        {ON "[surface q] initial = 1  rate = [K+]/s\n", "[K+], expected a solute"},
        {ON "[surface q] initial = 1  rate = pH/s\n", "without the species H+"},
        {ON "[surface q] initial = 1  rate = C/s\n", "'C'"},
        {ON "[surface q] initial = 1  of = c  rate = 0\n", "'c', expected the name of an [electrode"},
        {ON "[surface q] initial = 1  of = a  rate = r/s\n[surface r] of = b  initial = 1  rate = 0\n",
         "does not carry"},
        {ON "[surface q] initial = 1  of = a  rate = 0\n[electrode b] current_factor = q\n", "does not carry"},
        {ON "[surface q] initial = 1  of = b  rate = 0\n[electrode a] current_factor = q\n", "does not carry"},
        {LAW("[dissolve]", "rate = q*1 um/h", "mg4ag"),
         "a.scene:3: rate: found q, which the electrode b does not carry, expected it in 'of' of [surface q]"},
        {LAW("[dissolve mg4ag]", "rate = q*1 um/h", "mg4ag"), "a.scene:3: rate: found q, which the electrode b does"},
        {LAW("[dissolve mg4ag]", "current = q*1 A/m2", "mg4ag"), "a.scene:3: current: found q, which the electrode b"},
        {LAW("[dissolve]", "law = q*1e-3/s", "mg4ag"), "a.scene:3: law: found q, which the electrode b does"},
        {LAW("[dissolve]", "rate = q*E*1 um/h/(1 V)",
             "steel304\n[electrode a] reaction = Mg = Mg2+ + 2 e-\n"
             "[electrode b] reaction = 2 H2O + 2 e- = H2(g) + 2 OH-\n[chemistry] migration = yes"),
         "a.scene:3: rate: found q, which the electrode b does not carry"},
        {ON "[surface q] initial = 1 m  rate = 0\n[electrode b] current_factor = q\n", "expected a plain number"},
        {ON "[electrode b] current_factor = 2\n", "without states of surfaces"},
        {ON "[surface q] initial = 1  rate = 0\n[electrode b] current_factor = q*[Na+]/(1 mM)\n",
         "expected states of surfaces"},
        {ON "[surface q] initial = 1  rate = 0\n[electrode b] current_factor = -q\n", "factor of b is -1"},
        {ON "[surface q] initial = 1  rate = sqrt(0.5 - q)/s\n", "the rate of q is no finite number"},
        {ON "[surface q] initial = 0  rate = if(q > 0.5, -1/s, 1/s)\n", "no steps follow the rates"},
        {ON "[surface q] initial = 1  rate = q^2/s\n", "grows beyond all bounds"}, /* infinite after 1 s */
        {ON "[chemistry] time = steady\n[surface q] initial = 1  rate = 0\n", "steady"},
        {PLATES "[transport] D = 1e-9 m2/s\n[dissolve] rate = 0\n[run] until = 1 s\n"
                "[surface q] initial = 1  rate = 0\n",
         "without species"}};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        pd_ctx_init(&ctx);
        memset(&model, 0, sizeof model);
        pd_status status = pd_scene_parse(&ctx, "a.scene", bad[k][0], NULL, 0, &setup);
        if (status == PD_OK) {
            status = pd_model_build(&ctx, &setup, &model);
            if (status == PD_OK) {
                status = pd_time_loop_run(&ctx, &model.time_loop, 20.0, 0.0, NULL, NULL);
                pd_model_free(&ctx, &model);
            }
            pd_setup_free(&ctx, &setup);
        }
        if (!CHECK(status < 0) || !CHECK(strstr(ctx.message, bad[k][1]) != NULL))
            NOTE("case %d: '%s' lacks '%s'", (int)k, ctx.message, bad[k][1]);
        CHECK_INT(ctx.in_use, 0);
    }
}

TEST_MAIN(ENTRY(film_of_a_couple) ENTRY(film_as_published) ENTRY(order_in_time) ENTRY(behind_a_diffusion_layer)
          ENTRY(places_without_diffusion) ENTRY(pulses_of_factors) ENTRY(metal_that_goes) ENTRY(long_steps)
          ENTRY(state) ENTRY(seen)
          ENTRY(refused))
