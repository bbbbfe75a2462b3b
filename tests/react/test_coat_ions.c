/* coat among ions that migrate: the couple of Hoeche in an excess of salt against an integrator of its own, a cathode
 * whose film grows by the current of oxygen that diffuses to it, order in time, metal that goes, checkpoints, threads.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "continued_model.h"
#include "cases/film.h"

#define FARADAY 96485.33212331001
#if PD_DIM == 1
#define BOX(h, x) "[grid] h = " h "  box = 0 .. " x "  threads = 1\n"
#define SPAN
#define LAYER(h, x) BOX(h, x)
#define HIGH
#else
#define BOX(h, x) "[grid] h = " h "  box = 0 .. " x ", 0 .. 0.4 mm  threads = 1\n" \
    "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#define SPAN ", 0 .. 0.4 mm"
#define LAYER(h, x) "[grid] h = " h "  box = 0 .. " x ", 0 .. 20 um  threads = 1\n" \
    "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#define HIGH ", 0 .. 20 um"
#endif

static double mean_of(int k)
{
    pd_surface_state_statistics f;
    pd_surface_states_compute_statistics(model.surface_states, k, &f);
    return f.mean;
}

static double level_of(int electrode)
{
    pd_cell_electrode e;
    pd_species_electrodes_get_electrode(&model.dissolution_laws.species_electrodes, electrode, &e);
    return e.potential;
}

/* ---- the couple of Hoeche, well mixed ---- */

#define COUPLE(mg, oh) \
    BOX("0.2 mm", "4 mm") \
    "[shape left] box = 0 .. 1 mm" SPAN "  kind = solid  material = mg4ag\n" \
    "[shape right] box = 3 mm .. 4 mm" SPAN "  kind = solid  material = steel304\n[potential]\n" \
    "[electrode mg] shape = left  current_factor = sqrt(theta)  " FILM_MG "  reaction = Mg = Mg2+ + 2 e-\n" \
    "[electrode al] material = steel304  connected = mg  " FILM_AL \
    "  reaction = 2 H2O + 2 e- = H2(g) + 2 OH-\n" FILM_STATES( \
        "mg") "[surface charge] of = mg  initial = 0 C/m2  rate = i\n" \
              "[chemistry] activity = ideal  migration = yes\n[species Mg2+] D = 1e-2 m2/s  initial = " mg " mM\n" \
              "[species OH-] D = 1e-2 m2/s  initial = " oh " mM\n[species Na+] D = 1e-2 m2/s  initial = 10 mol/L\n" \
              "[species Cl-] D = 1e-2 m2/s  initial = 10 mol/L\n[run] until = 100 h\n"

TEST(film_of_a_couple)
{
    double y[FILM_COUNT];
    if (!open_model(COUPLE("0", "0"), NULL, 0)) return;
    for (double t = 900.0; t < 16000.0; t *= 2.0) {
        if (!run_to(t)) break;
        film_mixed(t, 4000, 0.0, 0, y);
        NOTE("%g s: E %.7f V (%.7f), theta %.6f (%.6f), l %.5g (%.5g), charge %.6g (%.6g), %d steps", t, level_of(0),
             film_potential(sqrt(y[0])), mean_of(0), y[0], mean_of(2), y[2], mean_of(3), y[FILM_PASSED],
             (int)model.species_integrator.steps);
        CHECK_NEAR(level_of(0), film_potential(sqrt(y[0])), 1e-4);
        CHECK_REL(mean_of(0), y[0], 2e-3);
        CHECK_NEAR(mean_of(1), y[1], 1e-4 * 0.55);
        CHECK_REL(mean_of(2), y[2], 3e-3);
        CHECK_REL(mean_of(3), y[FILM_PASSED], 1e-3);
    }
    close_model();
}

/* With half the steps the error of what has passed is a quarter. The cover goes its way in 20 s. */
TEST(order_in_time)
{
    double y[FILM_COUNT], error[3][4];
    film_mixed(1200.0, 10000, 2.0, 0, y);
    for (int k = 0; k < 3; k++) {
        char step[64];
        const char *overrides[] = {step, "run.rtol=0.1"};
        snprintf(step, sizeof step, "run.max_step=%g s", 18.75 / (1 << k));
        if (!open_model(COUPLE("2", "4"), overrides, 2)) return;
        if (run_to(1200.0)) {
            CHECK_INT(model.species_integrator.rejected, 0);
            error[k][0] = fabs(mean_of(0) / y[0] - 1.0);
            error[k][1] = fabs(mean_of(2) / y[2] - 1.0);
            error[k][2] = fabs(mean_of(3) / y[FILM_PASSED] - 1.0);
            error[k][3] = fabs(level_of(0) - film_potential(sqrt(y[0])));
            NOTE("order: %d steps: theta %.3e, l %.3e, charge %.3e, E %.3e V", (int)model.species_integrator.steps,
                 error[k][0], error[k][1], error[k][2], error[k][3]);
        }
        close_model();
    }
    CHECK_LE(error[2][2], error[0][2] / 13.0);
    CHECK_LE(error[1][2], error[0][2] / 3.5);
    for (int k = 0; k < 3; k++) { /* of which the first one is as good as the integrator */
        CHECK_LE(error[k][0], 2e-6);
        CHECK_LE(error[k][1], 1e-5);
        CHECK_LE(error[k][3], 1e-7);
    }
}

/* ---- a limiting current through a film that grows ---- */

#define OPEN(law, curve, states) \
    LAYER("5 um", "150 um") "[side x+] species = inlet\n[shape iron] box = 0 .. 50 um" HIGH "  kind = solid\n" \
    "[chemistry] activity = ideal  migration = yes\n[species Fe2+] D = 0.72e-9 m2/s\n" \
    "[species Na+] D = 1.33e-9 m2/s  initial = 500 mol/m3\n[species Cl-] D = 2.03e-9 m2/s  initial = 500 mol/m3\n" \
    "[species OH-] D = 5.27e-9 m2/s\n[species H2O]\n[species O2] D = 2e-9 m2/s  initial = 0.25 mol/m3\n[potential]\n" \
    law "[electrode iron] shape = iron  " curve "reaction = O2 + 2 H2O + 4 e- = 4 OH-\n" states
#define OXYGEN "curve = expression  i = -1 mA/m2*[O2]/(0.25 mol/m3)*10^(-(E + 0.1 V)/(120 mV))\n"

/* The film l slows the cathode by 1 + l/b and grows by a times its current, i = 1/(1/m + (1 + l/b)/k) with the limit m
 * of diffusion: a t = (1/m + 1/k) l + l^2/(2 b k). Oxygen does not migrate. */
TEST(growing_film)
{
    static const char text[] = OPEN("", OXYGEN "  potential = -0.5 V  current_factor = 1/(1 + l/(1 um))\n",
                                    "[surface l] initial = 0 um  rate = -i*4e-11 m3/C\n[run] until = 1e6 s\n");
    double most = 4.0 * FARADAY * 2e-9 * 0.25 / 1e-4, k = 1e-3 * pow(10.0, 0.4 / 0.12);
    const char *overrides[] = {"run.rtol=1e-3"};
    if (!open_model(text, overrides, 1)) return;
    for (double t = 1e4; t < 5e4; t *= 4.0) {
        if (!run_to(t)) break;
        double half = 1e-6 * k * (1.0 / most + 1.0 / k);
        double l = sqrt(half * half + 2e-6 * k * 4e-11 * t) - half;
        NOTE("film: %g s: l %.6g m (%.6g), %d steps", t, mean_of(0), l, (int)model.species_integrator.steps);
        CHECK_REL(mean_of(0), l, 1e-3); /* 5 s pass before oxygen is steady */
    }
    close_model();
}

/* ---- metal that goes: its law reads a state ---- */

#define RUSTS \
    OPEN("[transport] D = 1e-9 m2/s\n[dissolve] charge = 2  reaction = Fe = Fe2+ + 2 e-  Cs = 1000 mol/m3\n" \
         "current = 0.01 A/m2*theta*10^((E + 0.6 V)/(60 mV))\n", OXYGEN "  factor = theta\n", \
         "[surface theta] initial = 1  min = 0.5  rate = -theta/(20 s)\n[run] until = 1 h\n")

/* Where both lines of Tafel, times 1/2, and the diffusion of oxygen cross. The metal has receded by then. */
TEST(metal_that_goes)
{
    double low = -1.0, high = 0.0, theta = 0.5, u = 0.0;
    if (!open_model(RUSTS, NULL, 0)) return;
    if (run_to(60.0)) {
        double receded = 50e-6 * pd_time_loop_volume_loss(&model.time_loop);
        double most = 4.0 * FARADAY * 2e-9 * 0.25 / (1e-4 + receded);
        for (int k = 0; k < 100; k++) {
            u = 0.5 * (low + high);
            double curve = 0.001 * theta * pow(10.0, -(u + 0.1) / 0.12);
            if (0.01 * theta * pow(10.0, (u + 0.6) / 0.06) > most * curve / (most + curve)) high = u;
            else low = u;
        }
        NOTE("rusts: E %.7f V (%.7f), theta %.7f, %g m", level_of(0), u, mean_of(0), receded);
        pd_cell_electrode e;
        pd_species_electrodes_get_electrode(&model.dissolution_laws.species_electrodes, 0, &e);
        CHECK_REL(e.anodic / e.area, 0.01 * theta * pow(10.0, (u + 0.6) / 0.06), 2e-4); /* it has receded by 1.8e-3 */
        CHECK_NEAR(level_of(0), u, 26e-3 * 0.43 / 500.0); /* the diffusion potential of 0.43 mol/m3 of Fe2+ in salt */
        CHECK_NEAR(mean_of(0), theta, 0.0);
    }
    CHECK(run_to(3600.0));
    CHECK_NEAR(mean_of(0), theta, 0.0);
    CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
    close_model();
}

/* ---- states of runs ---- */

static void keep(void)
{
    const pd_etch *s = &model.dissolution_laws.surface_solver;
    saved_count = 0;
    for (int k = 0; k < setup.states; k++)
        for (int32_t i = 0; i < model.grid.total && saved_count < 2000; i++)
            saved[saved_count++] = model.surface_states->state_solver.value[(int64_t)k * model.grid.total + i];
    for (int k = 0; k < model.reactive.components.solutes; k++)
        for (int32_t i = 0; i < model.grid.total && saved_count < 8000; i++)
            saved[saved_count++] = model.reactive.c[(int64_t)k * model.grid.total + i];
    for (int k = 0; k < s->desc.electrodes.circuits; k++) saved[saved_count++] = s->level[k];
    for (int32_t p = 0; p < s->count && saved_count < 8192; p++) saved[saved_count++] = s->flow[p];
}

/* A run that goes on from a checkpoint has the bits of one that was never stopped; so has one with more threads. */
TEST(state)
{
    continued(COUPLE("0.5", "1"), 900.0, 3000.0, keep);
    continued(RUSTS, 5.0, 2000.0, keep);
    continued(OPEN("", OXYGEN "  potential = -0.5 V  factor = 1/(1 + l/(1 um))\n",
                   "[surface l] initial = 0 um  rate = -i*4e-11 m3/C\n[run] until = 1e6 s\n"), 1e3, 1e4, keep);
}

/* The same without states: metal that dissolves and rusts, and two metals. */
TEST(state_without)
{
    continued(OPEN("[transport] D = 1e-9 m2/s\n[dissolve] charge = 2  reaction = Fe = Fe2+ + 2 e-  Cs = 1000 mol/m3\n"
                   "current = 0.01 A/m2*10^((E + 0.6 V)/(60 mV))\n", OXYGEN, "[run] until = 1 h\n"), 1000.0, 2500.0,
              keep);
    continued(OPEN("[transport] D = 1e-9 m2/s\n[dissolve] reaction = Fe = Fe2+ + 2 e-\n"
                   "[dissolve steel304] charge = 2  Cs = 1000 mol/m3  current = 0.01 A/m2*10^((E + 0.6 V)/(60 mV))\n"
                   "[dissolve mg4ag] rate = 0\n"
                   "[shape iron] material = steel304\n[shape other] box = 130 um .. 150 um" HIGH "  kind = solid  "
                   "material = mg4ag\n[electrode other] shape = other  connected = iron\n"
                   "curve = tafel  i0 = 1 mA/m2  E0 = -0.3 V  cathodic_slope = 120 mV\n"
                   "reaction = O2 + 2 H2O + 4 e- = 4 OH-\n", OXYGEN, "[run] until = 20 s\n"), 5.0, 20.0, keep);
}

/* ---- bad input ---- */

TEST(refused)
{
    static const char *const bad[][2] = {
        {OPEN("", OXYGEN "  potential = -0.5 V  factor = 0.5 - q\n", "[surface q] initial = 0  rate = 1/s\n"
              "[run] until = 1 h\n"), "the factor of iron is -"},
        {OPEN("", OXYGEN "  potential = -0.5 V\n", "[surface q] initial = 1  rate = sqrt(0.5 - q)/s\n"
              "[run] until = 1 h\n"), "the rate of q is no finite number"},
        {OPEN("[transport] D = 1e-9 m2/s\n[dissolve] charge = 2  reaction = Fe = Fe2+ + 2 e-\n"
              "current = 0.01 A/m2*10^((E + 0.6 V)/(60 mV))\n", OXYGEN "  factor = q\n",
              "[surface q] initial = 1  min = 0  rate = -1/s\n[run] until = 1 h\n"), "a factor leaves"}};
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

TEST_MAIN(ENTRY(film_of_a_couple) ENTRY(order_in_time) ENTRY(growing_film) ENTRY(metal_that_goes) ENTRY(state)
          ENTRY(state_without) ENTRY(refused))
