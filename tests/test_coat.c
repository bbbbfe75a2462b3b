/* coat: states of surfaces in scenes: the film of Hoeche's couple against an integrator of its own, closed forms, order in
 * time, bounds, metal that goes, checkpoints, threads, bad input.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "run/model.h"
#include "run/sample.h"
#include "scene/scene.h"
#include "checkpoint_model.h"
#include "scene_file.h"

#define FARADAY 96485.33212
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
#define GAP 2e-3 /* [m] */

static pd_ctx ctx;
static pd_setup setup;
static pd_model model;

static int open_model(const char *text, const char *const *overrides, int count)
{
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", text, overrides, count, &setup))) return 0;
    if (CHECK_OK(&ctx, pdi_model_build(&ctx, &setup, &model))) return 1;
    pd_setup_free(&ctx, &setup);
    return 0;
}

static void close_model(void)
{
    pdi_model_free(&ctx, &model);
    pd_setup_free(&ctx, &setup);
    CHECK_INT(ctx.in_use, 0);
}

static int run_to(double t)
{
    int done = CHECK_OK(&ctx, pd_couple_run(&ctx, &model.couple, t, 0.0, NULL, NULL));
    CHECK_LE(pd_couple_imbalance(&model.couple), 1e-12);
    return done;
}

static double mean_of(int k)
{
    pd_surfaces_figures f;
    pdi_surfaces_figures(&model.surfaces, k, &f);
    CHECK(f.least <= f.mean * (1.0 + 1e-12) && f.mean <= f.most * (1.0 + 1e-12));
    return f.mean;
}

static double mean_concentration(const char *species)
{
    const double *c = pd_reactive_field(&model.reactive, pdi_electrolyte_find(&setup.electrolyte, species));
    double sum = 0.0;
    for (int32_t i = 0; i < model.grid.total; i++)
        if (model.grid.kind[i] == PD_FLUID) sum += c[i];
    return sum / (double)model.grid.fluid_count;
}

/* ---- the couple of Hoeche, well mixed ---- */

#define CURVES \
    "[electrode mg] shape = left  curve = expression  range = -1.8 V .. -1.25 V  factor = sqrt(theta)\n" \
    "  i = 0.28 A/m2*(exp(39.31786*0.4*(E + 1.517 V)/(1 V)) - exp(-39.31786*0.32*(E + 1.517 V)/(1 V)))\n" \
    "  reaction = Mg = Mg2+ + 2 e-\n" \
    "[electrode al] material = steel304  connected = mg  curve = expression  range = -1.8 V .. -1.25 V\n" \
    "  i = -0.104 A/m2/(0.012 + exp(-2*(E + 0.595 V)/(1 V))) - 0.18 A/m2*10^(-(E + 1.41 V)/(0.118 V))\n" \
    "  reaction = 2 H2O + 2 e- = H2(g) + 2 OH-\n"
#define FILM \
    "[constants] Vm = 2.457627e-5 m3/mol  k = 3.7e-7 m/s/(1 mol/m3)^3*(1 mol/m3)\n" \
    "  q = 7.4e-4/s/(1 mol/m3)^3*(1 mol/m3)  Ksp = 0.45 mol3/m9\n" \
    "[surface theta] of = mg  initial = 0.1  max = 1\n" \
    "  rate = (1 - theta)/((1 - eps)*l)*k*Vm*max([Mg2+]*[OH-]^2 - Ksp, 0)\n" \
    "[surface eps] of = mg  initial = 0.55  min = 0\n" \
    "  rate = -eps*q*Vm*max([Mg2+]*[OH-]^2 - Ksp, 0)\n" \
    "[surface l] of = mg  initial = 1e-7 m  max = 1 mm\n" \
    "  rate = k*Vm*max([Mg2+]*[OH-]^2 - Ksp, 0)/((1 - 0.55)*theta)\n"
#define WATER(D, mg, oh) \
    "[chemistry] activity = ideal\n[species Mg2+] D = " D "  initial = " mg " mM\n" \
    "[species OH-] D = " D "  initial = " oh " mM\n"
#define COUPLE(D, mg, oh) \
    PLATES "[potential] conductivity = 1e4 S/m\n" CURVES FILM WATER(D, mg, oh) "[run] until = 100 h\n"

static double magnesium(double u)
{
    return 0.28 * (exp(39.31786 * 0.4 * (u + 1.517)) - exp(-39.31786 * 0.32 * (u + 1.517)));
}

static double aluminium(double u)
{
    double e = exp(2.0 * (u + 0.595));
    return 0.104 * e / (0.012 * e + 1.0) + 0.18 * pow(10.0, -(u + 1.41) / 0.118);
}

/* E where share times one is the other. */
static double mixed(double share)
{
    double lo = -1.8, hi = -1.25;
    for (int k = 0; k < 200; k++) {
        double u = 0.5 * (lo + hi);
        if (share * magnesium(u) > aluminium(u)) hi = u;
        else lo = u;
    }
    return 0.5 * (lo + hi);
}

/* theta, eps, l, C of Mg2+ and OH-, well mixed in a gap; l has a bound. */
static void film_rates(const double *y, double *rate)
{
    double u = mixed(sqrt(y[0])), i = aluminium(u), volume = 2.457627e-5;
    double chi = fmax(y[3] * y[4] * y[4] - 0.45, 0.0), k = 3.7e-7 * volume * chi;
    rate[0] = (1.0 - y[0]) / ((1.0 - y[1]) * y[2]) * k;
    rate[1] = -y[1] * 7.4e-4 * volume * chi;
    rate[2] = y[2] < 1e-3 ? k / ((1.0 - 0.55) * y[0]) : 0.0;
    rate[3] = i / (2.0 * FARADAY * GAP);
    rate[4] = i / (FARADAY * GAP);
}

/* Runge and Kutta's method of order 4, n steps, from `mg` mol/m3 of Mg2+. */
static void film_run(double t, int n, double mg, double *y)
{
    double k[4][5], at[5], h = t / n;
    y[0] = 0.1;
    y[1] = 0.55;
    y[2] = 1e-7;
    y[3] = mg;
    y[4] = 2.0 * mg;
    for (int s = 0; s < n; s++) {
        for (int j = 0; j < 4; j++) {
            double share = j == 0 ? 0.0 : j == 3 ? h : 0.5 * h;
            for (int m = 0; m < 5; m++) at[m] = y[m] + (j ? share * k[j - 1][m] : 0.0);
            film_rates(at, k[j]);
        }
        for (int m = 0; m < 5; m++) y[m] += h / 6.0 * (k[0][m] + 2.0 * k[1][m] + 2.0 * k[2][m] + k[3][m]);
    }
}

/* Coverage, pores and thickness after 2 and 8 h, with an electrolyte that mixes at once. */
TEST(film_of_a_couple)
{
    static const double times[] = {1800.0, 2.0 * 3600.0, 8.0 * 3600.0};
    double y[5];
    if (!open_model(COUPLE("1e-2 m2/s", "0", "0"), NULL, 0)) return;
    for (int k = 0; k < 3; k++) {
        if (!run_to(times[k])) break;
        pd_cell_electrode e;
        pd_cell_electrode_of(&model.cell, 0, &e);
        film_run(times[k], 20000, 0.0, y);
        NOTE("couple: %g s, %d steps (%d rejected): theta %.6f (%.6f), eps %.6f (%.6f), l %.6g (%.6g), E %.6f (%.6f), Mg "
             "%.5f (%.5f)", times[k], (int)model.course.steps, (int)model.course.rejected, mean_of(0), y[0], mean_of(1),
             y[1], mean_of(2), y[2], e.potential, mixed(sqrt(y[0])), mean_concentration("Mg2+"), y[3]);
        CHECK_REL(mean_of(0), y[0], 5e-3);
        CHECK_REL(mean_of(1), y[1], 5e-3);
        CHECK_REL(mean_of(2), y[2], 5e-3);
        CHECK_REL(mean_concentration("Mg2+"), y[3], 5e-3);
        CHECK_REL(mean_concentration("OH-"), y[4], 5e-3);
        CHECK_NEAR(e.potential, mixed(sqrt(y[0])), 1e-4);
    }
    close_model();
}

/* ---- order in time ---- */

/* With half the steps the error is a quarter. The cover goes its way in 20 s. */
TEST(order_in_time)
{
    double y[5], error[3][3];
    film_run(1200.0, 20000, 2.0, y);
    for (int k = 0; k < 3; k++) {
        char step[64];
        const char *overrides[] = {step, "run.rtol=0.1"};
        snprintf(step, sizeof step, "run.max_step=%g s", 18.75 / (1 << k));
        if (!open_model(COUPLE("1e-2 m2/s", "2", "4"), overrides, 2)) return;
        if (run_to(1200.0)) {
            CHECK_INT(model.course.rejected, 0);
            error[k][0] = fabs(mean_of(0) / y[0] - 1.0);
            error[k][1] = fabs(mean_of(2) / y[2] - 1.0);
            error[k][2] = fabs(mean_concentration("OH-") / y[4] - 1.0);
            NOTE("order: %d steps: theta %.3e, l %.3e, OH- %.3e", (int)model.course.steps, error[k][0], error[k][1],
                 error[k][2]);
        }
        close_model();
    }
    for (int m = 0; m < 3; m++) {
        CHECK_LE(error[2][m], error[0][m] / 13.0);
        CHECK_LE(error[1][m], error[0][m] / 3.5);
    }
}

TEST_MAIN(ENTRY(film_of_a_couple) ENTRY(order_in_time))
