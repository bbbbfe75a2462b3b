/* read_param_file: every key of the flat parameter file, in 2D and 3D, and what overrides do to it.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "physics/model.h"
#include "scene/scene.h"
#include "test.h"
#include <locale.h>
#include <stdlib.h>
#include <unistd.h>

static const char defaults[] = "examples/scenes/s0_params.cfg";

/* A flat file with this text. */
static pd_status load(pd_ctx *ctx, const char *text, const char *const *overrides, int count, pd_setup *setup)
{
    char folder[200], path[256];
    pd_ctx_init(ctx);
    ctx->threads = 1;
    snprintf(folder, sizeof folder, "%s/pdcorr_XXXXXX", P_tmpdir);
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof path, "%s/flat.cfg", folder);
    FILE *file = fopen(path, "w");
    CHECK(file && fputs(text, file) >= 0 && fclose(file) == 0);
    pd_status status = pd_scene_read(ctx, path, overrides, count, setup);
    CHECK(remove(path) == 0 && rmdir(folder) == 0);
    return status;
}

static void leave(pd_ctx *ctx, pd_setup *setup)
{
    pd_setup_free(ctx, setup);
    CHECK_INT(ctx->in_use, 0);
}

/* Layers in 1/k_corr, m = 3, C_thresh = 0.2. A node in the first, second, third row from plane fluid has neighbours
 * there in 15, 8, 3 of 36 places, in 3D in 71, 34, 9 of 178. */
static const double layers = PD_DIM == 2 ? 26.0 / 36.0 / 0.8 : 114.0 / 178.0 / 0.8;

static double speed_of(const pd_setup *u)
{
    double none = 0.0;
    return u->metal[0].rate_scale * pd_expr_eval(&u->metal[0].rate, &none);
}

/* Time [s] in which the front passes a layer by a rule of the project, in explicit steps as it makes them: a plane
 * front along x, every node with the same rows around it; the mean over layers behind the first few. bonds: content
 * falls by diffusion across the surface, else by the share of fluid neighbours. `rate` is k_corr or D/dx^2 [1/s]. */
static double layer_time(double m, double rate, int bonds, double thresh, double dt)
{
    double weight[8] = {0}, content[24], count = 0.0, time = 0.0, seen = 0.0;
    int reach = (int)(m + 0.5), front = 0;
    double constant = PD_DIM == 3 ? 9.0 / (2.0 * 3.14159265358979 * m * m * m) : 4.0 / (3.14159265358979 * m * m);
    for (int i = -reach; i <= reach; i++)
        for (int j = -reach; j <= reach; j++)
            for (int k = PD_DIM == 3 ? -reach : 0; k <= (PD_DIM == 3 ? reach : 0); k++) {
                double r = sqrt((double)(i * i + j * j + k * k)), part = m + 0.5 - r;
                if (r > m + 0.5 || (i == 0 && j == 0 && k == 0)) continue;
                count += 1.0;
                if (i < 0) weight[-i] += bonds ? constant * (part < 1.0 ? part : 1.0) / (r * r) : 1.0;
            }
    for (int n = 0; n < 24; n++) content[n] = 1.0;
    while (front < 20) {
        time += dt;
        for (int n = front; n < 24; n++) {
            double open = 0.0; /* the rows of neighbours that have turned fluid */
            for (int w = n - front + 1; w <= reach; w++) open += weight[w];
            content[n] -= dt * rate * (bonds ? open * content[n] : open / count);
        }
        if (content[front] >= thresh) continue;
        if (++front == 8) seen = time;
    }
    return (time - seen) / 12.0;
}

/* The figures of the project's own file, worked out by hand. */
static void check_defaults(const pd_setup *u)
{
    CHECK_NEAR(u->h[0], 5e-6, 0.0);
    CHECK_NEAR(u->fluid_m, 3.0, 0.0);
    CHECK_NEAR(u->lo[0], -500e-6, 0.0);
    CHECK_REL(u->hi[0], 900e-6, 1e-14);
    CHECK_REL(u->hi[1], 150e-6, 1e-14);
    CHECK(u->has_flow && u->has_transport && u->has_dissolve && u->has_grains);
    CHECK_INT(u->side[0].kind, PD_SIDE_INLET);
    CHECK_INT(u->side[0].profile, PD_PROFILE_PARABOLA);
    CHECK_NEAR(u->side[0].mean_speed, 0.2358, 5e-5); /* 1.667e-8 / (pi (150e-6)^2) */
    CHECK_INT(u->side[1].kind, PD_SIDE_OUTLET);
    CHECK_INT(u->side[2].kind, PD_SIDE_WALL);
    CHECK_NEAR(u->rho, 1000.0, 0.0);
    CHECK_NEAR(u->mu, 1e-3, 0.0);
    CHECK_NEAR(u->steady_tolerance, 5e-6, 0.0);
    CHECK_NEAR(u->diffusivity, 1e-9, 0.0);
    CHECK_NEAR(u->metal[0].solid_c, 71507.9, 0.05); /* 1738 / 0.024305 */
    CHECK_NEAR(u->inlet_c, 0.0, 0.0);
    CHECK_NEAR(u->threshold, 0.2, 0.0);
    CHECK_REL(speed_of(u), 5e-9 * layers, 1e-14);
    CHECK_NEAR(u->gb_factor, 3.0, 0.0);
    CHECK_NEAR(u->grain.size, 40e-6, 0.0);
    CHECK_NEAR(u->grain.spread, 5e-6, 0.0);
    CHECK_NEAR(u->grain.boundary_width, 5e-6, 0.0);
    CHECK_NEAR(u->end_time, 10.0, 0.0);
    CHECK_NEAR(u->output_interval, 0.5, 0.0);
    CHECK(strncmp(u->folder, "output", 6) == 0); /* of the file, or of its name */
    CHECK_STR(u->name, "s0_params");
}

TEST(file_of_the_project)
{
    static const char *const ignored[] = {"D_grain", "D_gb", "w_advect", "alpha_art_diff", "gamma_eos", "c0 ",
                                          "eta_density", "cfl_factor ", "cfl_factor_corr", "flow_max_iters",
                                          "corrosion_steps_per_check", "output_every_flow", "output_every_corr"};
    pd_ctx ctx;
    pd_setup u;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_scene_read(&ctx, defaults, NULL, 0, &u))) return;
    check_defaults(&u);
    for (size_t k = 0; k < sizeof ignored / sizeof ignored[0]; k++) {
        int found = 0;
        for (int n = 0; n < u.notes; n++)
            found += strncmp(u.note[n], ignored[k], strlen(ignored[k])) == 0 && strstr(u.note[n], "ignored") != NULL;
        if (!CHECK_INT(found, 1)) NOTE("no note on %s", ignored[k]);
    }
    int rate = 0;
    const char *said = PD_DIM == 2 ? "16.25 um/h = 142.447" : "14.41";
    for (int n = 0; n < u.notes; n++) rate += strstr(u.note[n], "k_corr") != NULL && strstr(u.note[n], said) != NULL;
    if (!CHECK_INT(rate, 1))
        for (int n = 0; n < u.notes; n++) NOTE("%s", u.note[n]);
    leave(&ctx, &u);
}

/* One key alone: the defaults are those of the file. */
TEST(defaults_without_the_file)
{
    pd_ctx ctx;
    pd_setup u;
    if (!CHECK_OK(&ctx, load(&ctx, "T_final = 10\n", NULL, 0, &u))) return;
    memcpy(u.name, "s0_params", 10);
    check_defaults(&u);
    leave(&ctx, &u);
}

/* Refining dx keeps the recession speed and the boundary width, which refer to dx as it stands in the file. */
TEST(refining_keeps_the_speed)
{
    static const char *const overrides[] = {"dx=2.5e-6", "T_final=32400"};
    pd_ctx ctx;
    pd_setup u;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_scene_read(&ctx, defaults, overrides, 2, &u))) return;
    CHECK_NEAR(u.h[0], 2.5e-6, 0.0);
    CHECK_NEAR(u.end_time, 32400.0, 0.0);
    CHECK_REL(speed_of(&u), 5e-9 * layers, 1e-14);
    CHECK_NEAR(u.grain.boundary_width, 5e-6, 0.0);
    leave(&ctx, &u);
    if (!CHECK_OK(&ctx, load(&ctx, "dx = 1e-5\nk_corr = 2e-3\ngb_width_cells = 1\n", overrides, 1, &u))) return;
    CHECK_REL(speed_of(&u), 2e-8 * layers, 1e-14);
    CHECK_REL(u.grain.boundary_width, 3e-5, 1e-14);
    leave(&ctx, &u);
}

/* The set-up of the project's Poiseuille check. */
TEST(without_pin)
{
    pd_ctx ctx;
    pd_setup u;
    if (!CHECK_OK(&ctx, load(&ctx, "R_wire = 0\nL_wire = 0\nL_upstream = 1500e-6\nk_corr = 0\ngb_corr_factor = 1\n"
                             "flow_conv_tol = 1e-6\nT_final = 1e-8\n", NULL, 0, &u))) return;
    CHECK_INT(u.solid, -1);
    CHECK(u.has_flow && !u.has_dissolve && !u.has_grains);
    CHECK_NEAR(u.lo[0], -1500e-6, 0.0);
    CHECK_NEAR(u.hi[0], 500e-6, 0.0);
    CHECK_NEAR(u.steady_tolerance, 1e-6, 0.0);
    CHECK_NEAR(u.end_time, 1e-8, 0.0);
    leave(&ctx, &u);
    if (!CHECK_OK(&ctx, load(&ctx, "Q_flow = 0\nC_liquid_init = 0.01\ngrain_size_mean = 0\n", NULL, 0, &u))) return;
    CHECK(!u.has_flow && u.has_dissolve && !u.has_grains);
    CHECK_NEAR(u.gb_factor, 1.0, 0.0);
    CHECK_NEAR(u.inlet_c, 715.079, 1e-3);
    CHECK_INT(u.fields >> PD_FIELD_V & 1u, 0);
    leave(&ctx, &u);
}

/* Solid nodes of the pin: a slab of 16 x 80 cells in 2D; in 3D a wire whose section is that of a disc. */
TEST(geometry)
{
    static const char *const overrides[] = {"dx=1e-5", "L_upstream=40e-6", "L_downstream=40e-6"};
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    if (!CHECK_OK(&ctx, pd_scene_read(&ctx, defaults, overrides, 3, &u))) return;
    if (CHECK_OK(&ctx, pd_model_build(&ctx, &u, &m))) {
        double cells = PD_DIM == 2 ? 8.0 * 40.0 : 3.14159265358979323846 * 16.0 * 40.0;
        CHECK_REL((double)m.grid.solid_count, cells, PD_DIM == 2 ? 0.0 : 0.05);
        double open = PD_DIM == 2 ? 30.0 * 48.0 : 3.14159265358979323846 * 225.0 * 48.0;
        CHECK_REL((double)(m.grid.solid_count + m.grid.fluid_count), open, PD_DIM == 2 ? 0.0 : 0.02);
        CHECK_REL(m.flow.reference_length, 300e-6, 1e-9);
        pd_model_free(&ctx, &m);
    }
    leave(&ctx, &u);
}

/* The speed of k_corr is that of the rule of the log: 18.5 minutes a layer in grains and 6.2 in boundaries where the
 * log says 67 and 22, which is the whole content at a quarter of k_corr (one of four nearest neighbours). */
TEST(rule_of_the_log)
{
    static const double m[] = {2.0, 3.0, 4.0};
    char text[120];
    pd_ctx ctx;
    pd_setup u;
    for (int k = 0; k < 3; k++) {
        snprintf(text, sizeof text, "m_ratio = %g\nk_corr = 1e-3\nC_thresh = 0.2\n", m[k]);
        if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
        double layer = layer_time(m[k], 1e-3, 0, 0.2, 0.1);
        NOTE("m = %g: a layer in %.4g min", m[k], layer / 60.0);
        CHECK_REL(5e-6 / layer, speed_of(&u), 1e-3);
        leave(&ctx, &u);
    }
    if (PD_DIM == 2) CHECK_NEAR(layer_time(3.0, 1e-3, 0, 0.2, 0.1) / 60.0, 18.46, 0.02);
    if (PD_DIM == 2) CHECK_NEAR(layer_time(3.0, 3e-3, 0, 0.2, 0.1) / 60.0, 6.15, 0.02);
}

/* A file of the project's later sort: adaptive lattice, implicit steps, metal that diffuses across the surface. */
static const char later[] = "dx = 2.5e-6\nm_ratio = 3\nuse_amr = 1\namr_ratio = 3\namr_buffer = 50e-6\n"
                            "R_tube = 425e-6\nD_liquid = 1e-9\nD_grain = 4e-16\nD_gb = 2e-15\nD_precip = 2e-14\n"
                            "precip_fraction = 0.05\nprecip_cluster_cells = 2\nC_solid_init = 1\nC_thresh = 0.45\n"
                            "alpha_art_diff = 0.01\ncorrosion_decay_l = 10\nC_sat = 0.9\nT_final = 15228\n"
                            "use_implicit = 1\nimplicit_dt_fraction = 0.5\nimplicit_dt_max = 60\n"
                            "implicit_output_every = 50\ndiagnostic_every = 1\nnewton_tol = 1e-8\n"
                            "newton_max_iter = 20\nchannel_flow_corrections = 0\n";

TEST(later_files)
{
    static const char *const ignored[] = {"use_amr", "amr_ratio", "amr_buffer", "D_precip", "precip_fraction",
                                          "precip_cluster_cells", "corrosion_decay_l", "use_implicit",
                                          "implicit_dt_fraction", "implicit_dt_max", "implicit_output_every",
                                          "diagnostic_every", "newton_tol", "newton_max_iter",
                                          "channel_flow_corrections"};
    pd_ctx ctx;
    pd_setup u;
    if (!CHECK_OK(&ctx, load(&ctx, later, NULL, 0, &u))) return;
    for (size_t k = 0; k < sizeof ignored / sizeof ignored[0]; k++) {
        int found = 0;
        for (int n = 0; n < u.notes; n++)
            found += strncmp(u.note[n], ignored[k], strlen(ignored[k])) == 0 && strstr(u.note[n], "ignored") != NULL &&
                     u.note[n][strlen(ignored[k])] == ' ';
        if (!CHECK_INT(found, 1)) NOTE("no note on %s", ignored[k]);
    }
    double across = 2.0 * 1e-9 * 4e-16 / (1e-9 + 4e-16), rate = across / (2.5e-6 * 2.5e-6);
    double layer = layer_time(3.0, rate, 1, 0.45, 1e-4 / rate);
    NOTE("a layer in %.4g min: %.4g um/h", layer / 60.0, 2.5 * 3600.0 / layer);
    CHECK_REL(speed_of(&u), 2.5e-6 / layer, 2e-4);
    CHECK_REL(u.gb_factor, 5.0, 1e-5); /* 2e-15 over 4e-16, less what the fluid adds */
    double c = 0.45 * 1738.0 / 0.024305;
    const pd_setup_metal *metal = &u.metal[0];
    CHECK_REL(metal->rate_scale * pd_expr_eval(&metal->rate, &c), 0.5 * speed_of(&u), 1e-9); /* halfway to C_sat */
    leave(&ctx, &u);
    /* a rate of the file wins, and the diffusivities have no effect */
    char text[sizeof later + 40];
    snprintf(text, sizeof text, "%sk_corr = 1e-3\n", later);
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    CHECK_REL(speed_of(&u), 2.5e-9 * layers * 0.8 / 0.55, 1e-12);
    CHECK_NEAR(u.gb_factor, 3.0, 0.0);
    leave(&ctx, &u);
}

/* Without a diffusivity on one side of the surface the harmonic mean is 0, and metal stays. */
TEST(no_diffusion)
{
    static const char *const still[] = {"D_liquid = 0\nD_grain = 4e-16\n", "D_liquid = 0\nD_grain = 0\n",
                                        "D_grain = 0\nD_gb = 0\n", "D_grain = 0\ngrain_size_mean = 0\n",
                                        "D_grain = 0\nR_wire = 0\n"};
    pd_ctx ctx;
    pd_setup u;
    for (size_t k = 0; k < sizeof still / sizeof still[0]; k++) {
        if (!CHECK_OK(&ctx, load(&ctx, still[k], NULL, 0, &u))) continue;
        CHECK_INT(u.has_dissolve, 0);
        CHECK_NEAR(u.gb_factor, 1.0, 0.0);
        for (int n = 0; n < u.notes; n++) CHECK(!strstr(u.note[n], "nan") && !strstr(u.note[n], "inf"));
        leave(&ctx, &u);
    }
    /* with k_corr the liquid has no part in the rate */
    if (!CHECK_OK(&ctx, load(&ctx, "D_liquid = 0\nk_corr = 1e-3\n", NULL, 0, &u))) return;
    CHECK_INT(u.has_dissolve, 1);
    CHECK_REL(speed_of(&u), 5e-9 * layers, 1e-12);
    leave(&ctx, &u);
    /* the product of both underflows, their harmonic mean does not: 1.5e-200, and 1e-200 in grains */
    if (!CHECK_OK(&ctx, load(&ctx, "D_liquid = 1e-200\nD_grain = 1e-200\nD_gb = 3e-200\n", NULL, 0, &u))) return;
    CHECK_REL(u.gb_factor, 1.5, 1e-12);
    leave(&ctx, &u);
}

/* Numbers that become expressions are read again, whatever the locale of the program. */
TEST(numbers_in_a_locale)
{
    pd_ctx ctx, other;
    pd_setup plain, u;
    char probe[16];
    double c = 0.25 * 1738.0 / 0.024305;
    if (!CHECK_OK(&ctx, load(&ctx, later, NULL, 0, &plain))) return;
    int found = setlocale(LC_ALL, "de_DE.UTF-8") || setlocale(LC_ALL, "fr_FR.UTF-8");
    snprintf(probe, sizeof probe, "%.1f", 0.5);
    pd_status status = load(&other, later, NULL, 0, &u);
    setlocale(LC_ALL, "C");
    if (CHECK_OK(&other, status)) {
        CHECK_NEAR(pd_expr_eval(&u.metal[0].rate, &c), pd_expr_eval(&plain.metal[0].rate, &c), 0.0);
        leave(&other, &u);
    }
    leave(&ctx, &plain);
    if (!found || strcmp(probe, "0,5") != 0) SKIP("no locale with a decimal comma is installed");
}

TEST(around_the_axis)
{
    static const char *const text = "axisymmetric = 1\ndx = 1e-5\nL_upstream = 4e-5\nL_downstream = 4e-5\n";
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (PD_DIM == 3) {
        CHECK(load(&ctx, text, NULL, 0, &u) < 0 && strstr(ctx.message, "axisymmetric: found 1 in 3D") != NULL);
        return;
    }
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    CHECK_INT(u.axisymmetric, 1);
    CHECK_NEAR(u.lo[1], 0.0, 0.0);
    CHECK_INT(u.side[2].kind, PD_SIDE_MIRROR);
    if (CHECK_OK(&ctx, pd_model_build(&ctx, &u, &m))) {
        CHECK_INT(m.grid.solid_count, 4 * 40);
        CHECK_INT(m.grid.solid_count + m.grid.fluid_count, 15 * 48);
        pd_model_free(&ctx, &m);
    }
    leave(&ctx, &u);
}

static void refused(const char *text, const char *part)
{
    pd_ctx ctx;
    pd_setup setup;
    CHECK(load(&ctx, text, NULL, 0, &setup) < 0);
    if (!CHECK(strstr(ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", ctx.message, part);
    CHECK_INT(ctx.in_use, 0);
}

TEST(refusals)
{
    refused("R_wrie = 1e-6\n", "did you mean 'R_wire'?");
    refused("dx = 5e-6\nR_tube = -1\n", "flat.cfg:2: R_tube: found -1, expected a value above 0 and at most 1");
    refused("R_tube = 0\n", "flat.cfg:1: R_tube: found 0, expected a value above 0 and at most 1");
    refused("T_final = 2e12\n", "flat.cfg:1: T_final: found 2e+12, expected a value above 0 and at most 1e+12");
    refused("C_thresh = -0.125\n", "flat.cfg:1: C_thresh: found -0.125, expected a value from 0 to 0.99");
    refused("R_wire = 150e-6\n", "flat.cfg:1: R_wire: found 0.00015, expected less than R_tube");
    refused("dx = 3e-6\n", "flat.cfg:1: dx: ");
    refused("C_solid_init = 0.1\n", "C_thresh: found 0.2, expected less than C_solid_init = 0.1");
    refused("axisymmetric = 0.5\n", "axisymmetric: found 0.5");
    refused("D_grain = 1e-16\nC_thresh = 0\n", "C_thresh: found 0 without k_corr");
    refused("dx = 5e-6\nD_grain = 0\n", "flat.cfg:2: D_grain: found 0 with D_gb = 5e-09");
    refused("m_ratio = 7\n", "flat.cfg:1: m_ratio: found 7, expected a value from 1 to 6");
}

TEST_MAIN(ENTRY(file_of_the_project) ENTRY(defaults_without_the_file) ENTRY(refining_keeps_the_speed) ENTRY(without_pin)
              ENTRY(geometry) ENTRY(rule_of_the_log) ENTRY(later_files) ENTRY(no_diffusion) ENTRY(numbers_in_a_locale)
                  ENTRY(around_the_axis) ENTRY(refusals))
