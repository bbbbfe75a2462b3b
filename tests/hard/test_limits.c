/* limits: numbers at the ends of their ranges, laws without a value, boxes smaller than a horizon.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "hard.h"

#if PD_DIM > 1
static hard hard_two;
#endif

#define METAL "Cs = 2 mol/L  Csat = 500 mol/m3\n"
#define LAW "[dissolve] rate = 10 um/h * (1 - C/Csat)  " METAL
#define BONDS "[corrode] rate = 10 um/h * (1 - C/Csat)  D = 1e-9 m2/s  " METAL
#define STILL "[transport] D = 1e-9 m2/s\n"
#define OPEN "[side x-] flow = open\n"
#define FRONT \
    "[grid] h = 10 um  m = 3  box = 0 .. 300 um" ACROSS("0 .. 40 um") "\n[shape metal] box = 150 um .. " \
                                                                      "300 um" ACROSS("0 .. 40 um") "  kind = solid\n"
#define CHANNEL \
    "[grid] h = 10 um  m = 3  box = 0 .. 200 um" ACROSS("0 .. 60 um") "\n[shape pin] box = 80 um .. 110 " \
                                                                      "um" ACROSS("20 um .. 40 um") "  kind = solid\n"
#define STREAM \
    "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s  C = 0\n[side x+] flow = outlet\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-8\n" STILL

/* A front that recedes at v whatever the fluid holds, for t: off by, over the depth. */
static double depth_error(const hard *h, double front, double far, double v, double t)
{
    return fabs(pd_time_loop_volume_loss(&h->model.time_loop) * (far - front) / (v * t) - 1.0);
}

/* Family sizes from the nearest neighbours to six cells, whole and fractional, for each solver. */
TEST(m_from_1_to_6)
{
    NOT_IN_3D();
    static const char *const ratios[] = {"m=1", "m=2", "m=2.5", "m=3", "m=4", "m=5", "m=6"};
    hard *h = &hard_one;
    char text[1200];
    double worst[2] = {0.0, 0.0}, flux = 0.0;
    int failures = test_now.failures;
    for (int k = 0; k < 7; k++) {
        for (int bonds = 0; bonds < 2; bonds++) {
            snprintf(text, sizeof text, "%s%s%s[run] until = 10 h\n", FRONT, bonds ? OPEN : "",
                     bonds ? "[corrode] control = activation  rate = 10 um/h  Cs = 2 mol/L  Csat = 1 mol/m3\n"
                           : STILL "[dissolve] rate = 10 um/h  Cs = 2 mol/L  Csat = 1e6 mol/m3\n");
            hard_override = ratios[k];
            if (hard_play(h, text)) worst[bonds] = fmax(worst[bonds], depth_error(h, 150e-6, 300e-6, 10e-6, 10.0));
            else NOTE("%s", ratios[k]);
            hard_close(h);
        }
#if PD_DIM > 1
        hard_override = ratios[k];
        if (hard_play(h, CHANNEL STREAM LAW "[run] until = 0.2 h\n")) flux = fmax(flux, h->flux);
        else NOTE("%s", ratios[k]);
        hard_close(h);
#endif
    }
    CHECK_LE(worst[0], 1e-9);
    CHECK_LE(worst[1], 1e-3);
    hard_done("dissolve", failures, worst[0], "depth_of_a_flat_front", 0.0, NULL);
    hard_done("corrode", failures, worst[1], "depth_of_a_flat_front", 0.0, NULL);
    if (PD_DIM > 1) hard_done("couple", failures, flux, "flow_far_down_against_far_up", 0.0, NULL);
    hard_override = "m=0.5";
    hard_refused(h, FRONT STILL LAW "[run] until = 1 h\n", "m_0.5",
                 "m: found 0.5, expected a value from 1 to 6", PD_ERR_ARGUMENT);
}

#if PD_DIM > 1
/* Cells a hundred times longer than wide, along either axis: conductances differ by 1e4. */
TEST(spacing_ratio_100)
{
    NOT_IN_3D();
    static const char *const grids[] = {
        "h = 10 um, 1 mm" ALONG_Z("1 mm") "  m = 3  box = 0 .. 300 um" ACROSS("0 .. 6 mm"),
        "h = 10 um, 100 nm" ALONG_Z("100 nm") "  m = 3  box = 0 .. 300 um" ACROSS("0 .. 600 nm")};
    static const char *const across[] = {ACROSS("0 .. 6 mm"), ACROSS("0 .. 600 nm")};
    hard *h = &hard_one;
    char text[1200];
    for (int bonds = 0; bonds < 2; bonds++) {
        double worst = 0.0;
        for (int k = 0; k < 2; k++) {
            snprintf(text, sizeof text,
                     "[grid] %s\n[shape metal] box = 150 um .. 300 um%s  kind = solid\n%s%s"
                     "[run] until = 10 h\n",
                     grids[k], across[k], bonds ? OPEN : "",
                     bonds ? "[corrode] control = activation  rate = 10 um/h  Cs = 2 mol/L  Csat = 1 mol/m3\n"
                           : STILL "[dissolve] rate = 10 um/h  Cs = 2 mol/L  Csat = 1e6 mol/m3\n");
            if (hard_play(h, text)) worst = fmax(worst, depth_error(h, 150e-6, 300e-6, 10e-6, 10.0));
            if (k == 0) hard_close(h);
        }
        CHECK_LE(worst, 1e-3);
        hard_end(h, bonds ? "corrode" : "dissolve", worst, "depth_of_a_flat_front", 0.0, NULL);
    }
    /* flow between plates, long cells along it and across it */
    for (int k = 0; k < 2; k++) {
        double off = 1.0;
        snprintf(text, sizeof text,
                 "[grid] h = %s\n[side x-] flow = periodic\n[side x+] flow = periodic\n"
#if PD_DIM == 3
                 "[side z-] flow = periodic\n[side z+] flow = periodic\n"
#endif
                 "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-8  body_force = %s  reference_speed = "
                 "1 mm/s  reference_length = %s\n",
                 k ? "1 um, 100 um" ALONG_Z("100 um") "  m = 3  box = 0 .. 10 um, 0 .. 2 mm" ALONG_Z("0 .. 400 um")
                   : "100 um, 1 um" ALONG_Z("1 um") "  m = 3  box = 0 .. 1 mm, 0 .. 20 um" ALONG_Z("0 .. 4 um"),
                 k ? "2e-3 m/s2, 0 m/s2" ALONG_Z("0 m/s2") : "20 m/s2, 0 m/s2" ALONG_Z("0 m/s2"), k ? "2 mm" : "20 um");
        if (hard_play(h, text)) {
            double width = k ? 2e-3 : 20e-6, top = (k ? 2e-3 : 20.0) * width * width / 8e-6;
            off = 0.0;
            for (int32_t i = 0; i < h->model.grid.total; i++) {
                double x[PD_DIM];
                if (h->model.grid.kind[i] != PD_FLUID) continue;
                pd_grid_position(&h->model.grid, i, x);
                double s = x[1] / width;
                off = fmax(off, fabs(h->model.flow.u[i] / top - 4.0 * s * (1.0 - s)));
            }
            CHECK_LE(off, 1e-5);
        }
        hard_end(h, k ? "flow_across_long_cells" : "flow_along_long_cells", off, "velocity_against_the_parabola", 0.0,
                 NULL);
    }
}
#endif

/* Two media whose diffusivities differ by 1e8, in series between held values: the poor one takes the whole drop. */
TEST(diffusivity_ratio_1e8)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    char text[1200];
    for (int k = 0; k < 2; k++) {
        double off = 1.0;
        snprintf(text, sizeof text,
                 "[grid] h = 10 um  m = 3  box = 0 .. 200 um%s\n[side x-] C = 0\n"
                 "[side x+] C = 100 mol/m3\n[shape film] box = 100 um .. 200 um%s  kind = medium  D = %s\n"
                 "[transport] D = 1e-9 m2/s  time = steady\n",
                 ACROSS("0 .. 60 um"), ACROSS("0 .. 60 um"), k ? "1e-1 m2/s" : "1e-17 m2/s");
        if (hard_play(h, text)) {
            off = 0.0;
            for (int32_t i = 0; i < h->model.grid.total; i++) {
                double x[PD_DIM];
                if (h->model.grid.kind[i] != PD_FLUID) continue;
                pd_grid_position(&h->model.grid, i, x);
                double s = x[0] / 100e-6, due = k ? fmin(s, 1.0) : fmax(s - 1.0, 0.0);
                off = fmax(off, fabs(hard_field(h)[i] / 100.0 - due));
            }
            CHECK_LE(off, 0.02); /* the ends of a cut family: half a cell of twenty at most */
        }
        /* arithmetic means conduct half as well as the better side */
        hard_end(h, k ? "good_film" : "poor_film", off, "field_over_the_held_value", k ? 0.0 : 0.5e8,
                 k ? NULL : "flux_through_a_poor_node_by_arithmetic_means_over_the_true_one");
    }
    /* metal below a poor film: it dissolves as fast as the film lets pass */
    if (hard_play(h, FRONT "[shape film] box = 100 um .. 150 um" ACROSS(
                         "0 .. 40 um") "  kind = medium  D = 1e-17 m2/s\n" STILL LAW "[run] until = 10 h\n"))
        CHECK_LE(pd_time_loop_volume_loss(&h->model.time_loop), 1e-3);
    hard_end(h, "dissolve_under_film", h->ledger, "imbalance", 0.0, NULL);
}

#if PD_DIM > 1
/* Largest overshoot of central differences for -phi'' + Pe/h phi' = 0 between 0 and 1 on n cells: the discrete solution
 * is (r^i - 1)/(r^n - 1) with r = (2 + Pe)/(2 - Pe). */
static double central_overshoot(double peclet, int n)
{
    double r = (2.0 + peclet) / (2.0 - peclet), worst = 0.0;
    for (int i = 0; i <= n; i++) {
        double phi = (pow(r, i) - 1.0) / (pow(r, n) - 1.0);
        worst = fmax(worst, fmax(-phi, phi - 1.0));
    }
    return worst;
}

/* A pin in a stream that carries a million times more than diffusion spreads over a cell. */
TEST(cell_peclet_1e6)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    hard_override = "D=1e-14 m2/s";
    if (hard_play(h, CHANNEL STREAM LAW "[run] until = 0.5 h\n"))
        CHECK(pd_time_loop_volume_loss(&h->model.time_loop) > 0.0);
    hard_end(h, "couple", h->flux, "flow_far_down_against_far_up", central_overshoot(1e6, 20),
             "overshoot_of_central_differences_on_an_even_number_of_cells");
}

/* The stream is steady and unstable to disturbances behind the pin in nature; the steady state exists all the same. */
TEST(reynolds_1000)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    const char *pin =
        CHANNEL "[side x-] flow = inlet  profile = uniform  mean = 16.67 m/s  C = 0\n[side x+] flow = "
                "outlet\n"
                "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-8\n" STILL LAW "[run] until = 1 s\n";
    /* refused, or right: never in between */
    if (hard_open(h, pin) && hard_steps(h, h->setup.end_time)) hard_sound(h);
    else CHECK(h->status == PD_ERR_DIVERGED && strstr(h->ctx.message, "time = implicit") != NULL);
    hard_end(h, "couple", h->flux, "flow_far_down_against_far_up", 0.0, NULL);
}

/* A flow section in which nothing moves is the same as no flow at all, and an inlet at rest lets nothing in. */
TEST(zero_velocity)
{
    NOT_IN_3D();
    hard *h = &hard_one, *still = &hard_two;
    const char *stream = "[side x-] flow = inlet  profile = uniform  mean = 0 m/s  C = 0\n[side x+] flow = outlet\n";
    char text[1200];
    snprintf(text, sizeof text, "%s%s[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n%s%s[run] until = 1 h\n", CHANNEL, stream,
             STILL, LAW);
    if (hard_play(h, text)) CHECK_INT((int)h->model.quasi.result.newton, 0);
    hard_close(h);
    snprintf(text, sizeof text, "%s[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n%s%s[run] until = 1 h\n", CHANNEL, STILL,
             LAW);
    double off = 1.0;
    if (hard_play(h, text) && hard_play(still, CHANNEL STILL LAW "[run] until = 1 h\n")) {
        double a = pd_time_loop_volume_loss(&h->model.time_loop), b = pd_time_loop_volume_loss(&still->model.time_loop);
        off = fabs(a - b) / b;
        CHECK_LE(off, 1e-9);
    }
    hard_close(still);
    hard_end(h, "couple", off, "volume_loss_against_no_flow", 0.0, NULL);
}
#endif

/* Full speed from rest in no time. The first stage projects; nothing of the start rings on. */
#if PD_DIM > 1
TEST(impulsive_start)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    double off = 1.0, z = -1e6, kept = 1.0;
    const char *channel = "[grid] h = 10 um  m = 3  box = 0 .. 200 um" ACROSS(
        "0 .. 60 um") "\n[side x-] flow = inlet\n"
                      "profile = uniform  mean = 10 mm/s  C = 100 mol/m3\n[side x+] flow = outlet\n" STILL
                      "[run] until = 50 ms\n[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-8";
    hard *steady = &hard_two;
    char text[1200];
    snprintf(text, sizeof text, "%s  time = implicit\n", channel);
    if (hard_play(h, text) && hard_play(steady, channel)) {
        off = 0.0;
        for (int64_t i = 0; i < PD_DIM * (int64_t)h->model.grid.total; i++)
            off = fmax(off, fabs(h->model.flow.u[i] - steady->model.flow.u[i]) / 10e-3);
        CHECK_LE(off, 1e-3); /* steps of an error of 1e-4 each */
        CHECK_LE(h->model.implicit.rejected, 20);
    }
    hard_close(steady);
    for (int k = 0; k < 10; k++) kept *= fabs((1.0 + 0.5 * z) / (1.0 - 0.5 * z));
    hard_end(h, "flow_in_time", off, "velocity_in_the_end_against_the_steady_flow", kept,
             "share_of_a_kink_that_the_trapezoidal_rule_keeps_over_ten_steps_of_1e6_times_its_decay_time");
}
#endif

/* Fluid that starts with twice the saturation: nothing dissolves, nothing is put back on the metal, and where the
 * excess
 * can leave the metal dissolves afterwards. */
TEST(start_above_saturation)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    char text[1200];
    for (int bonds = 0; bonds < 2; bonds++)
        for (int open = 0; open < 2; open++) {
            snprintf(text, sizeof text, "%s%s%s  initial = 2*Csat\n%s%s[run] until = %s\n", FRONT,
                     !open   ? ""
                     : bonds ? OPEN
                             : "[side x-] C = 0\n",
                     bonds ? "[corrode] D = 1e-9 m2/s" : "[transport] D = 1e-9 m2/s", bonds ? "" : "[dissolve]\n",
                     "rate = 10 um/h * (1 - C/Csat)  " METAL, open ? "5 h" : "1 h");
            double loss = 1.0, off = 1.0;
            if (hard_play(h, text)) {
                off = loss = pd_time_loop_volume_loss(&h->model.time_loop);
                if (!open) CHECK_NEAR(loss, 0.0, 0.0);
                else CHECK(loss > 1e-3);
            }
            char name[40];
            snprintf(name, sizeof name, "%s_%s", bonds ? "corrode" : "dissolve", open ? "open" : "closed");
            /* the law at 2 Csat is -10 um/h: taken as it stands it deposits 10 um on 150 um in the hour */
            hard_end(h, name, off, open ? "volume_loss_after_the_excess_has_left" : "volume_loss",
                     open ? 0.0 : 10.0 / 150.0,
                     open ? NULL : "metal_that_the_law_as_it_stands_deposits_in_the_hour_over_the_metal_there_is");
        }
}

/* Kinetics that overflow, or have no value, at a concentration that the run reaches. */
TEST(law_without_a_value)
{
    NOT_IN_3D();
    static const char *const laws[2] = {"rate = 10 um/h * (1 + exp(1e5*C/Csat))",
                                        "rate = 10 um/h * sqrt(1 - 1e3*C/Csat)"};
    static const char *const names[2] = {"overflow", "nan"};
    static const char *const values[2] = {"the rate law gives inf m/s at c = ", "the rate law gives "};
    hard *h = &hard_one;
    char text[1200], name[40];
    for (int k = 0; k < 2; k++)
        for (int bonds = 0; bonds < 2; bonds++) {
            snprintf(text, sizeof text, "%s%s  initial = 0.1*Csat\n%s%s  %s[run] until = 10 h\n", FRONT,
                     bonds ? "[corrode] D = 1e-9 m2/s" : "[transport] D = 1e-9 m2/s", bonds ? "" : "[dissolve]\n",
                     laws[k], METAL);
            snprintf(name, sizeof name, "%s_%s", bonds ? "corrode" : "dissolve", names[k]);
            hard_refused(h, text, name, values[k], PD_ERR_STATE);
        }
    hard_refused(h, FRONT STILL "[dissolve] rate = 10 um/h * log(C/Csat)  " METAL "[run] until = 1 h\n", "read_at_0",
                 "rate: found a recession speed of -inf m/s at C = 0, expected 0 to 1 m/s", PD_ERR_ARGUMENT);
}

/* Every family is longer than the box. */
TEST(box_smaller_than_the_horizon)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    const char *box = "[grid] h = 10 um  m = 6  box = 0 .. 30 um" ACROSS(
        "0 .. 20 um") "\n[shape metal] box = 20 um .. 30 um" ACROSS("0 .. 20 um") "  kind = solid\n";
    char text[1200];
    for (int bonds = 0; bonds < 2; bonds++) {
        snprintf(text, sizeof text, "%s%s[run] until = 5 h\n", box, bonds ? BONDS : STILL LAW);
        if (hard_play(h, text)) {
            /* one layer of metal at 2 mol/L over two of fluid that take 500 mol/m3: saturated */
            double loss = pd_time_loop_volume_loss(&h->model.time_loop);
            CHECK(loss > 0.45 && loss <= 0.5 + 1e-9);
        }
        hard_end(h, bonds ? "corrode" : "dissolve", h->ledger, "imbalance", 0.0, NULL);
    }
    /* beside a side that holds 0 all of it goes */
    for (int bonds = 0; bonds < 2; bonds++) {
        snprintf(text, sizeof text, "%s%s%s[run] until = 10 h\n", box, bonds ? OPEN : "[side x-] C = 0\n",
                 bonds ? BONDS : STILL LAW);
        if (hard_play(h, text)) {
            CHECK_INT(h->model.grid.solid_count, 0);
            CHECK_NEAR(pd_time_loop_volume_loss(&h->model.time_loop), 1.0, 0.0);
        }
        hard_end(h, bonds ? "corrode_held_side" : "dissolve_held_side", h->ledger, "imbalance", 0.0, NULL);
    }
}

/* A single node has no bond at all, and a second one of metal is the whole solid. */
TEST(box_of_one_node)
{
    NOT_IN_3D();
    hard *h = &hard_one;
    char text[1200];
    if (hard_play(h, "[grid] h = 10 um  m = 3  box = 0 .. 10 um" ACROSS(
                         "0 .. 10 um") "\n[transport] D = 1e-9 m2/s\n"
                                       "initial = 7 mol/m3\n[run] until = 1 h\n")) {
        double low, high;
        hard_extremes(h, &low, &high);
        CHECK(low >= 7.0 && high <= 7.0);
    }
    hard_end(h, "transport", h->ledger, "imbalance", 0.0, NULL);
    for (int bonds = 0; bonds < 2; bonds++) {
        double loss = 0.0;
        snprintf(text, sizeof text,
                 "[grid] h = 10 um  m = 3  box = 0 .. 20 um%s\n[shape metal] box = 10 um .. 20 um%s"
                 "  kind = solid\n%s[run] until = 100 h\n",
                 ACROSS("0 .. 10 um"), ACROSS("0 .. 10 um"), bonds ? BONDS : STILL LAW);
        if (hard_play(h, text)) loss = pd_time_loop_volume_loss(&h->model.time_loop);
        CHECK_REL(loss, 0.25, 1e-6); /* Csat/Cs of one node of fluid */
        hard_end(h, bonds ? "corrode_two_nodes" : "dissolve_two_nodes", fabs(4.0 * loss - 1.0), "amount_at_saturation",
                 0.0, NULL);
    }
    const char *full = "[grid] h = 10 um  m = 3  box = 0 .. 10 um" ACROSS(
        "0 .. 10 um") "\n[shape metal] box = 0 .. 10 um" ACROSS("0 .. 10 um") "  kind = solid\n";
    for (int bonds = 0; bonds < 2; bonds++) {
        snprintf(text, sizeof text, "%s%s[run] until = 1 h\n", full, bonds ? BONDS : STILL LAW);
        if (hard_play(h, text)) CHECK_NEAR(pd_time_loop_volume_loss(&h->model.time_loop), 0.0, 0.0);
        hard_end(h, bonds ? "corrode_metal_alone" : "dissolve_metal_alone", h->ledger, "imbalance", 0.0, NULL);
    }
}

#if PD_DIM > 1
#define OF_FLOW \
    ENTRY(spacing_ratio_100) ENTRY(cell_peclet_1e6) ENTRY(reynolds_1000) ENTRY(zero_velocity) ENTRY(impulsive_start)
#else
#define OF_FLOW
#endif
TEST_MAIN(ENTRY(m_from_1_to_6) OF_FLOW ENTRY(diffusivity_ratio_1e8) ENTRY(start_above_saturation)
              ENTRY(law_without_a_value) ENTRY(box_smaller_than_the_horizon) ENTRY(box_of_one_node))
