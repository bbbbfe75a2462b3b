/* scene, sketch, inlet, model, run: every section of a scene, what is built from it, the files of a run.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "run/output.h"
#include "io/png.h"
#include "scene_file.h"

#if PD_DIM == 2
static const char full[] =
    "[grid]       h = 5 um, 10 um   m = 2.5   box = -100 um .. 200 um, -60 um .. 60 um   threads = 2\n"
    "[shape rod]  ball = 20 um, 0   radius = 20 um\n"
    "[shape cut]  half_space = yes   point = 10 um, 0   normal = 1, 0\n"
    "[shape pin]  difference = rod, cut   kind = solid   material = mg4ag   grain_size = 40 um   grain_size_deviation "
    "= 4 um\n"
    "             grain_seed = 7   grain_boundary_width = 0.5 um\n"
    "[shape pin2] box = 100 um .. 120 um, -20 um .. 20 um   kind = solid\n"
    "[shape lid]  cylinder = x   radius = 50 um   outside = yes   kind = wall\n"
    "[side x-]    flow = inlet   profile = parabola   mean = 0.01 m/s   C = 0.1*Csat\n"
    "[side x+]    flow = outlet   p = 2 Pa\n"
    "[side y-]    flow = noslip\n"
    "[flow]       rho = 1 g/cm3   mu = 2 mPa s   steady_tolerance = 1e-7   body_force = 0.5 m/s2, 0\n"
    "[transport]  D = 2e-9 m2/s   advection = upwind   initial = 1 mol/m3 * (1 + x/(1 mm))\n"
    "[dissolve]   rate = 3.6 um/h * (1 - C/Csat)   Csat = 50 mol/m3   grain_boundary_factor = 3   threshold = 0.1\n"
    "[run]        until = 2 h   max_dissolved_fraction = 0.2   max_step = 60 s\n"
    "[output]     every = 10 min   fields = C, v, grain   images = C, rate   prefix = pit   folder = elsewhere\n"
    "[probe a]    at = 100 um, 25 um   fields = C, v\n";

TEST(every_key)
{
    pd_ctx ctx;
    pd_setup u;
    double x[2] = {1e-3, 0.0}, c = 25.0;
    if (!CHECK_OK(&ctx, load(&ctx, full, NULL, 0, &u))) return;
    CHECK_STR(u.name, "a");
    CHECK_STR(u.folder, "elsewhere");
    CHECK_STR(u.prefix, "pit");
    CHECK_INT(u.threads, 2);
    CHECK_NEAR(u.h[0], 5e-6, 0.0);
    CHECK_NEAR(u.h[1], 10e-6, 0.0);
    CHECK_NEAR(u.fluid_m, 2.5, 0.0);
    CHECK_NEAR(u.lo[0], -100e-6, 0.0);
    CHECK_NEAR(u.hi[1], 60e-6, 0.0);
    CHECK(u.has_flow && u.has_transport && u.has_dissolve && u.has_grains);
    CHECK_INT(u.side[0].kind, PD_SIDE_INLET);
    CHECK_INT(u.side[0].profile, PD_PROFILE_PARABOLA);
    CHECK_NEAR(u.side[0].mean_speed, 0.01, 0.0);
    CHECK_INT(u.side[1].kind, PD_SIDE_OUTLET);
    CHECK_INT(u.side[2].kind, PD_SIDE_WALL);
    CHECK_INT(u.side[3].kind, PD_SIDE_WALL);
    CHECK_NEAR(u.inlet_c, 5.0, 1e-15);
    CHECK_NEAR(u.p_out, 2.0, 0.0);
    CHECK_REL(u.rho, 1000.0, 1e-15);
    CHECK_REL(u.mu, 2e-3, 1e-15);
    CHECK_NEAR(u.force[0], 0.5, 0.0);
    CHECK_NEAR(u.steady_tolerance, 1e-7, 0.0);
    CHECK_NEAR(u.diffusivity, 2e-9, 0.0);
    CHECK_INT(u.advection, PD_ADVECTION_UPWIND);
    CHECK_REL(pd_expr_eval(&u.initial_c, x), 2.0, 1e-15);
    CHECK_REL(u.metal[0].rate_scale * pd_expr_eval(&u.metal[0].rate, &c), 0.5e-9, 1e-14);
    CHECK_REL(u.metal[0].solid_c, 1738.0 / 0.024305, 1e-15);
    CHECK_NEAR(u.saturation, 50.0, 0.0);
    CHECK_NEAR(u.gb_factor, 3.0, 0.0);
    CHECK_NEAR(u.threshold, 0.1, 0.0);
    CHECK_NEAR(u.grain.size, 40e-6, 0.0);
    CHECK_NEAR(u.grain.spread, 4e-6, 0.0);
    CHECK_INT(u.grain.seed, 7);
    CHECK_NEAR(u.grain.boundary_width, 0.5e-6, 1e-22);
    CHECK_NEAR(u.end_time, 7200.0, 0.0);
    CHECK_NEAR(u.output_interval, 600.0, 0.0);
    CHECK_NEAR(u.max_node_fraction, 0.2, 0.0);
    CHECK_NEAR(u.max_step, 60.0, 0.0);
    CHECK_INT(u.fields, 1 << PD_FIELD_C | 1 << PD_FIELD_V | 1 << PD_FIELD_GRAIN);
    CHECK_INT(u.images, 1 << PD_FIELD_C | 1 << PD_FIELD_RATE);
    CHECK_INT(u.probes, 1);
    CHECK_NEAR(u.probe[0].position[1], 25e-6, 0.0);
    leave(&ctx, &u);
}

/* Inside and outside of the united solids and of the wall at hand-picked points. */
TEST(shapes_and_operations)
{
    static const struct {
        double x, y; /* um */
        int solid, wall;
    } at[] = {{5, 0, 0, 0},  {15, 0, 1, 0},  {39, 0, 1, 0},  {41, 0, 0, 0}, {35, 18, 0, 0},
              {110, 0, 1, 0}, {110, 21, 0, 0}, {0, 51, 0, 1}, {0, -49, 0, 0}, {190, -51, 0, 1}};
    pd_ctx ctx;
    pd_setup u;
    if (!CHECK_OK(&ctx, load(&ctx, full, NULL, 0, &u))) return;
    for (size_t k = 0; k < sizeof at / sizeof at[0]; k++) {
        double x[2] = {at[k].x * 1e-6, at[k].y * 1e-6};
        CHECK_INT(pd_shape_distance(u.shape, u.solid, x) < 0.0, at[k].solid);
        CHECK_INT(pd_shape_distance(u.shape, u.wall, x) < 0.0, at[k].wall);
    }
    leave(&ctx, &u);
}

TEST(overrides_replace_values)
{
    static const char *const overrides[] = {"h=20 um", "side.x-.mean=1 mm/s", "run.until=30 min",
                                            "shape.rod.radius=15 um", "transport.advection=limited"};
    pd_ctx ctx;
    pd_setup u;
    if (!CHECK_OK(&ctx, load(&ctx, full, overrides, 5, &u))) return;
    CHECK_NEAR(u.h[0], 20e-6, 0.0);
    CHECK_NEAR(u.h[1], 20e-6, 0.0);
    CHECK_NEAR(u.side[0].mean_speed, 1e-3, 0.0);
    CHECK_NEAR(u.end_time, 1800.0, 0.0);
    CHECK_NEAR(u.shape[0].radius, 15e-6, 0.0);
    CHECK_INT(u.advection, PD_ADVECTION_LIMITED);
    leave(&ctx, &u);
}

#define CHANNEL "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n[side x+] flow = outlet\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n"
#define NARROW "[grid] h = 4 um  box = 0 .. 200 um, 0 .. 100 um\n[side x+] flow = outlet\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n"
#define STILL "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n[transport] D = 1e-9 m2/s\n[run] until = 1 s\n"
#define BLOCK "[shape b] box = 0 .. 50 um, 0 .. 50 um  kind = solid\n"

/* A rate per layer of h is the speed rate * h. */
TEST(law_per_layer)
{
    pd_ctx ctx;
    pd_setup u;
    double c = 0.0;
    if (!CHECK_OK(&ctx, load(&ctx, STILL BLOCK "[dissolve] law = 1e-3 1/s\n", NULL, 0, &u))) return;
    CHECK_REL(u.metal[0].rate_scale * pd_expr_eval(&u.metal[0].rate, &c), 1e-8, 1e-14);
    CHECK_INT(u.notes, 1);
    CHECK(strstr(u.note[0], "36 um/h") != NULL && strstr(u.note[0], "315.576 mm/year") != NULL);
    leave(&ctx, &u);
}

TEST(masks)
{
    static const uint8_t gray[8] = {255, 0, 0, 255, 0, 200, 100, 0}; /* two rows of four, the upper one first */
    static const uint8_t raw[8] = {0, 1, 0, 0, 1, 0, 0, 1};          /* the lower row first */
    pd_ctx ctx;
    pd_setup u;
    pd_image image;
    image.width = 4;
    image.height = 2;
    image.channels = 1;
    image.pixels = (uint8_t *)gray;
    need_folder();
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pd_png_write(&ctx, path_of("mask.png"), &image));
    put("mask.raw", raw, sizeof raw);
    static const char *const scenes[] = {
        STILL "[shape a] mask = mask.png  corner = 20 um, 30 um  cell = 10 um  kind = solid\n",
        STILL "[shape a] raw = mask.raw  size = 4, 2  corner = 20 um, 30 um  cell = 10 um, 10 um  kind = solid\n"};
    for (int s = 0; s < 2; s++) {
        if (!CHECK_OK(&ctx, load(&ctx, scenes[s], NULL, 0, &u))) continue;
        for (int row = 0; row < 2; row++)
            for (int column = 0; column < 4; column++) {
                double x[2] = {20e-6 + (column + 0.5) * 10e-6, 30e-6 + (row + 0.5) * 10e-6};
                int inside = s ? raw[row * 4 + column] : gray[(1 - row) * 4 + column] >= 128;
                CHECK_INT(pd_shape_distance(u.shape, u.solid, x) < 0.0, inside);
            }
        leave(&ctx, &u);
    }
    refused(STILL "[shape a] raw = mask.raw  size = 4, 3  corner = 0, 0  cell = 10 um  kind = solid\n",
            "raw: found a file of 8 bytes, expected 12");
    refused(STILL "[shape a] mask = mask.raw  corner = 0, 0  cell = 10 um  kind = solid\n", "a.scene:4: mask: ");
}

static int build(pd_ctx *ctx, const char *text, pd_setup *setup, pd_model *model)
{
    if (!CHECK_OK(ctx, load(ctx, text, NULL, 0, setup))) return 0;
    if (CHECK_OK(ctx, pd_model_build(ctx, setup, model))) return 1;
    pd_setup_free(ctx, setup);
    return 0;
}

/* 3/2 U (1 - s^2) between the walls of the side, wherever they stand. */
TEST(parabola_between_walls)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    double x[2] = {-5e-6, 0.0}, v[2];
    if (!build(&ctx, CHANNEL "[shape w] half_space = yes  point = 0, 33 um  normal = 0, 1  kind = wall\n"
                     "[side x-] flow = inlet  profile = parabola  mean = 0.3 m/s\n", &u, &m)) return;
    CHECK_NEAR(m.flow.reference_speed, 0.3, 0.0);
    CHECK_NEAR(m.flow.reference_length, 67e-6, 1e-12);
    for (int k = 0; k < 7; k++) {
        x[1] = 35e-6 + k * 10e-6;
        double s = (x[1] - 66.5e-6) / 33.5e-6;
        pdi_inlet_get_velocity(&m.inlet, x, v);
        CHECK_NEAR(v[0], 0.45 * (1.0 - s * s), 1e-9);
        CHECK_NEAR(v[1], 0.0, 0.0);
    }
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

/* 2D: the flow of a tube as wide as the channel; from the other side it flows towards -x. */
TEST(flow_rate_and_direction)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    double x[2] = {205e-6, 50e-6}, v[2];
    if (!build(&ctx, "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n[flow] rho = 1 g/cm3  mu = 1 mPa s\n"
                     "[side x+] flow = inlet  profile = uniform  flow_rate = 1 uL/min\n[side x-] flow = outlet\n",
               &u, &m)) return;
    pdi_inlet_get_velocity(&m.inlet, x, v);
    CHECK_REL(v[0], -1e-9 / 60.0 / (3.14159265358979323846 * 50e-6 * 50e-6), 1e-12);
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

/* A flow that cannot get to its tolerance says what it reached and what helps; references need not be given. */
TEST(flow_without_progress)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (!build(&ctx,
               "[grid] h = 10 um  box = 0 .. 100 um, 0 .. 100 um\n[flow] rho = 1 g/cm3  mu = 1 mPa s\n"
               "steady_tolerance = 1e-16\n[side y+] flow = noslip  velocity = 1 mm/s, 0 m/s\n",
               &u, &m))
        return;
    CHECK_REL(m.flow.reference_speed, 1e-3, 1e-12);
    CHECK_REL(m.flow.reference_length, 100e-6, 1e-9);
    CHECK_INT(pd_time_loop_start(&ctx, &m.time_loop), PD_ERR_DIVERGED);
    CHECK(strstr(ctx.message, "further steps do not lower them. That is as far as their rounding lets them") != NULL);
    CHECK(strstr(ctx.message, " accepts this one") != NULL && strstr(ctx.message, "time = implicit") == NULL);
    CHECK(strstr(ctx.message, "efine the grid") == NULL);
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

TEST(expression_profile)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    double x[2] = {-25e-6, 20e-6}, v[2];
    if (!build(&ctx, CHANNEL "[side x-] flow = inlet  profile = expression  vx = 10 1/s * y  vy = 1 mm/s\n", &u,
               &m)) return;
    pdi_inlet_get_velocity(&m.inlet, x, v);
    CHECK_REL(v[0], 2e-4, 1e-14);
    CHECK_REL(v[1], 1e-3, 1e-14);
    CHECK_REL(m.flow.reference_speed, 5e-4, 1e-12); /* the mean of 10/s y over the side */
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

#define CLOSED \
    "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n" \
    "[flow] rho = 1 g/cm3  mu = 1 mPa s  reference_speed = 1 mm/s  reference_length = 100 um"

/* Sides and flow in time as the file says. */
TEST(sides_and_motion)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (build(&ctx, CLOSED "  time = implicit  vx = 2 mm/s * y / 100 um  rtol = 1e-3\n[run] until = 3 s\n"
                    "[side x-] flow = periodic\n[side x+] flow = periodic\n[side y-] flow = mirror\n"
                    "[side y+] velocity = 3 mm/s, 0 m/s  C = 5 mol/m3\n[transport] D = 1e-9 m2/s\n", &u, &m)) {
        double x[2] = {30e-6, 100e-6}, inside[2] = {30e-6, 50e-6}, v[2];
        int at[2] = {3, 4};
        CHECK_INT(u.side[0].kind, PD_SIDE_PERIODIC);
        CHECK_INT(u.side[2].kind, PD_SIDE_MIRROR);
        CHECK_INT(u.flow_time, PD_FLOW_IMPLICIT);
        CHECK_NEAR(m.implicit.desc.rtol, 1e-3, 0.0);
        CHECK_NEAR(m.flow.u[pd_grid_node(&m.grid, at)], 0.9e-3, 1e-18);
        pdi_wall_bc_get_velocity(&m.inlet, x, v);
        CHECK_NEAR(v[0], 3e-3, 0.0);
        CHECK_NEAR(pdi_wall_bc_get_concentration(&m.inlet, x), 5.0, 0.0);
        CHECK(!(pdi_wall_bc_get_concentration(&m.inlet, inside) >= 0.0));
        CHECK(m.time_loop.process[0].self == &m.implicit && m.quasi.steady == NULL && m.unsteady.density == NULL);
        pd_model_free(&ctx, &m);
        leave(&ctx, &u);
    }
    if (build(&ctx, CLOSED "  time = explicit  c0 = 20 mm/s  eos = linear\n[run] until = 3 s\n", &u, &m)) {
        CHECK_INT(m.unsteady.desc.eos, PD_EOS_LINEAR);
        CHECK_NEAR(m.unsteady.desc.sound_speed, 0.02, 0.0);
        CHECK(m.steady.divergence_potential == NULL && m.implicit.start_state == NULL);
        pd_model_free(&ctx, &m);
        leave(&ctx, &u);
    }
    refused(CLOSED "\n[side y-] flow = periodic\n", "flow: found 'periodic', expected it on y- and y+");
    refused(CLOSED "\n[side y-] velocity = 1 m/s, 1 m/s\n", "velocity: expected 2 components, that along y being 0");
    refused(CLOSED "  time = explicit\n[run] until = 1 s\n", "c0");
    refused(CLOSED "  time = sometimes\n", "found 'sometimes', expected one of steady, implicit, explicit");
    refused(CLOSED "  time = implicit\n", "until");
    refused(CLOSED "  time = prescribed\n[transport] D = 0 m2/s\n[run] until = 1 s\n" BLOCK
                   "[dissolve] rate = 1 um/h\n",
            "time: found 'prescribed' beside [dissolve]");
}

/* What a scene leaves out owns no memory. */
TEST(absent_physics_costs_nothing)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (build(&ctx, STILL, &u, &m)) {
        CHECK_INT(m.bytes[PD_PART_FLOW] + m.bytes[PD_PART_GRAIN] + m.bytes[PD_PART_DISSOLVE], 0);
        CHECK(m.flow.u == NULL && m.steady.divergence_potential == NULL && m.boundary_factor == NULL &&
              m.dissolve.front == NULL);
        CHECK(m.time_loop.count == 1 && m.time_loop.process[0].self == &m.transport_integrator);
        CHECK_INT(m.unknowns[PD_PART_FLOW], 0);
        CHECK_INT(m.unknowns[PD_PART_TRANSPORT], 200);
        pd_model_free(&ctx, &m);
        leave(&ctx, &u);
    }
    if (build(&ctx, CHANNEL "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n", &u, &m)) {
        CHECK_INT(m.bytes[PD_PART_TRANSPORT], 0);
        CHECK(m.transport.c == NULL && m.time_loop.count == 1 && m.time_loop.elements == 0);
        CHECK_INT(m.unknowns[PD_PART_FLOW], 600);
        pd_model_free(&ctx, &m);
        leave(&ctx, &u);
    }
    /* grains without a boundary factor need no factor field */
    if (build(&ctx,
              STILL "[shape b] box = 0 .. 50 um, 0 .. 50 um  kind = solid  grain_size = 20 um\n"
                    "[dissolve] rate = 1 um/h\n",
              &u, &m)) {
        CHECK(m.boundary_factor == NULL && m.grain.id != NULL);
        pd_model_free(&ctx, &m);
        leave(&ctx, &u);
    }
}

/* factor = 1 + (gb_factor - 1) * boundary share: its mean over the solid follows from the measured share. */
TEST(grain_factor)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    double sum = 0.0, least = 1e9;
    if (!build(
            &ctx,
            STILL
            "[shape b] box = 0 .. 200 um, 0 .. 50 um  kind = solid  grain_size = 40 um  grain_boundary_width = 1 um\n"
            "[dissolve] rate = 1 um/h  grain_boundary_factor = 3\n",
            &u, &m))
        return;
    for (int32_t i = 0; i < m.grid.total; i++)
        if (m.grid.kind[i] == PD_SOLID) {
            sum += m.boundary_factor[i];
            least = fmin(least, m.boundary_factor[i]);
        }
    CHECK_REL(sum / 100.0, 1.0 + 2.0 * m.grain_stats.boundary_fraction, 1e-6);
    CHECK(m.grain_stats.boundary_fraction > 0.02 && m.grain_stats.boundary_fraction < 0.15);
    CHECK_NEAR(least, 1.0, 0.2);
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

typedef struct listener {
    int summary, notes, progress, results, steps, stop_after;
    char text[4000];
} listener;

static void listen(void *user, pd_print_kind kind, const char *text)
{
    listener *l = (listener *)user;
    size_t used = strlen(l->text);
    l->summary += kind == PD_PRINT_SUMMARY;
    l->notes += kind == PD_PRINT_NOTE;
    l->progress += kind == PD_PRINT_PROGRESS;
    l->results += kind == PD_PRINT_RESULT;
    CHECK(strchr(text, '\n') == NULL);
    snprintf(l->text + used, sizeof l->text - used, "%s\n", text);
}

static int stop(void *user)
{
    listener *l = (listener *)user;
    return ++l->steps == l->stop_after;
}

static pd_status run(pd_ctx *ctx, const pd_setup *setup, const char *out, int check, listener *l, pd_run_result *result)
{
    pd_run_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.folder = out;
    desc.check_only = check;
    desc.print = listen;
    desc.print_user = l;
    desc.stop = stop;
    desc.stop_user = l;
    return pd_run(ctx, setup, &desc, result);
}

#define DISSOLVING \
    "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n" \
    "[shape b] box = 0 .. 200 um, 0 .. 50 um  kind = solid  material = mg4ag\n" \
    "[transport] D = 1e-9 m2/s\n[dissolve] rate = 2 um/h\n[run] until = 1 h\n" \
    "[output] every = 20 min  fields = C, kind, density  images = C, kind  prefix = pit\n" \
    "[probe a] at = 100 um, 75 um  fields = C\n"

/* A flat front that recedes at 2 um/h for an hour takes 2 of 50 um; all files are there and can be read. */
TEST(files_of_a_run)
{
    static const char *const files[] = {"pit_000000_t0.0s.vti",  "pit_000001_t1200.0s.vti", "pit_000002_t2400.0s.vti",
                                        "pit_000003_t3600.0s.vti", "C_000003_t3600.0s.png", "kind_000000_t0.0s.png",
                                        "volume_loss.png"};
    pd_ctx ctx;
    pd_setup u;
    pd_run_result r;
    listener l;
    pd_table table;
    pd_image image;
    double loss[1000], time[1000];
    char line[600];
    memset(&l, 0, sizeof l);
    if (!CHECK_OK(&ctx, load(&ctx, DISSOLVING, NULL, 0, &u))) return;
    CHECK_OK(&ctx, run(&ctx, &u, path_of("made/here"), 0, &l, &r));
    CHECK_REL(r.volume_loss, 0.04, 1e-12);
    CHECK_LE(r.mass_balance_error, 1e-12);
    CHECK_NEAR(r.time, 3600.0, 0.0);
    CHECK(l.summary >= 5 && !r.stopped && !r.has_flux);
    CHECK(strstr(l.text, "not modelled: flow, inertia of the flow in time, gas, grains, ") != NULL);
    pd_run_format_result(&r, line, sizeof line);
    CHECK(strncmp(line, "result case=a dim=2 h=1e-05 m=1 volume_loss=0.0", 47) == 0);
    for (size_t k = 0; k < sizeof files / sizeof files[0]; k++) {
        char name[128];
        snprintf(name, sizeof name, "made/here/%s", files[k]);
        if (!CHECK(access(path_of(name), R_OK) == 0)) NOTE("no %s", name);
        memset(&image, 0, sizeof image);
        if (strstr(name, ".png")) CHECK_OK(&ctx, pd_png_read(&ctx, path_of(name), &image));
        if (strstr(name, ".png")) CHECK(image.width > 200 && image.height > 100);
        pd_image_free(&ctx, &image);
    }
    memset(&table, 0, sizeof table);
    if (CHECK_OK(&ctx, pd_table_read(&ctx, path_of("made/here/diagnostics.csv"), &table)) && table.rows < 1000) {
        CHECK_INT(table.rows, r.steps + 1);
        CHECK_OK(&ctx, pd_table_parse_column(&ctx, &table, "volume_loss", loss));
        CHECK_OK(&ctx, pd_table_parse_column(&ctx, &table, "time", time));
        CHECK_NEAR(loss[table.rows - 1], r.volume_loss, 0.0);
        CHECK_NEAR(loss[0], 0.0, 0.0);
        for (int k = 1; k < table.rows; k++) CHECK(time[k] > time[k - 1] && loss[k] > loss[k - 1]);
    }
    pd_table_free(&ctx, &table);
    memset(&table, 0, sizeof table);
    if (CHECK_OK(&ctx, pd_table_read(&ctx, path_of("made/here/probes.csv"), &table)))
        CHECK_INT(pd_table_find_column(&table, "a_C"), 1);
    pd_table_free(&ctx, &table);
    leave(&ctx, &u);
}

TEST(stop_and_check)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result r;
    listener l;
    memset(&l, 0, sizeof l);
    if (!CHECK_OK(&ctx, load(&ctx, DISSOLVING, NULL, 0, &u))) return;
    CHECK_OK(&ctx, run(&ctx, &u, path_of("checked"), 1, &l, &r));
    CHECK(access(path_of("checked"), F_OK) != 0);
    CHECK_INT(r.unknowns, 200);
    memset(&l, 0, sizeof l);
    l.stop_after = 2;
    CHECK_OK(&ctx, run(&ctx, &u, path_of("stopped"), 0, &l, &r));
    CHECK(r.stopped && r.time > 0.0 && r.time < 3600.0);
    CHECK_INT(r.steps, 1);
    CHECK(access(path_of("stopped/simulation.pvd"), R_OK) == 0 && access(path_of("stopped/volume_loss.png"),
                                                                         R_OK) == 0);
    leave(&ctx, &u);
}

/* An empty channel: what goes in comes out, and the parabola is kept. */
TEST(flow_alone)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result r;
    listener l;
    memset(&l, 0, sizeof l);
    if (!CHECK_OK(&ctx, load(&ctx, CHANNEL "[side x-] flow = inlet  profile = parabola  mean = 1 cm/s\n", NULL, 0, &u)))
        return;
    CHECK_OK(&ctx, run(&ctx, &u, path_of("flow"), 0, &l, &r));
    CHECK(r.has_flux);
    CHECK_LE(r.flux_error, 1e-6);
    CHECK_LE(r.layer_flux_error, 1e-6);
    CHECK_LE(r.residual, 1e-6);
    CHECK(access(path_of("flow/corr_000000_t0.0s.vti"), R_OK) == 0);
    leave(&ctx, &u);
}

/* What a point of a surface holds: the side that it lies on, else the nearest shape; nothing beside the metal. */
TEST(walls_and_media)
{
    pd_inlet inlet;
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    const double on_side[2] = {50e-6, 0.0}, on_a[2] = {40e-6, 50e-6}, on_b[2] = {160e-6, 53e-6};
    const double on_c[2] = {100e-6, 51e-6};
    const double on_metal[2] = {100e-6, 80e-6}, inside[2] = {20e-6, 90e-6}, outside[2] = {20e-6, 70e-6};
    if (!build(&ctx, STILL "[side y-] C = 7 mol/m3\n"
               "[shape a] ball = 30 um, 50 um  radius = 10 um  kind = wall  C = 2 mol/m3\n"
               "[shape b] box = 150 um .. 170 um, 30 um .. 50 um  kind = wall  C = 3 mol/m3\n"
               "[shape c] box = 80 um .. 120 um, 30 um .. 50 um  kind = wall\n"
               "[shape d] box = 80 um .. 120 um, 80 um .. 100 um  kind = solid\n"
               "[shape e] half_space = yes  point = 0, 80 um  normal = 0, -1  kind = medium  D = 3e-9 m2/s\n", &u, &m))
        return;
    memset(&inlet, 0, sizeof inlet);
    inlet.setup = &u;
    CHECK_NEAR(pdi_wall_bc_get_concentration(&inlet, on_side), 7.0, 0.0);
    CHECK_NEAR(pdi_wall_bc_get_concentration(&inlet, on_a), 2.0, 0.0);
    CHECK_NEAR(pdi_wall_bc_get_concentration(&inlet, on_b), 3.0, 0.0);
    CHECK(isnan(pdi_wall_bc_get_concentration(&inlet, on_c)));
    CHECK(isnan(pdi_wall_bc_get_concentration(&inlet, on_metal)));
    CHECK_NEAR(m.transport.desc.field(m.transport.desc.user, inside), 3e-9, 0.0);
    CHECK_NEAR(m.transport.desc.field(m.transport.desc.user, outside), 1e-9, 0.0);
    CHECK_REL(m.transport.desc.level(m.transport.desc.user, inside), -10e-6, 1e-9);
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

/* Plane Poiseuille flow, an exact discrete solution: a parabola, a linear pressure and the friction on both walls. */
TEST(watching_a_flow)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result r;
    listener l;
    const double slope = 12.0 * 1e-3 * 0.01 / (100e-6 * 100e-6); /* [Pa/m] */
    memset(&l, 0, sizeof l);
    if (!CHECK_OK(&ctx, load(&ctx, CHANNEL "[side x-] flow = inlet  profile = parabola  mean = 1 cm/s\n"
                             "[line a] from = 100 um, 0  to = 100 um, 100 um  points = 11\n"
                             "[line b] from = 0, 50 um  to = 100 um, 50 um  spacing = 30 um  fields = p images = none\n"
                             "[plane a] at = x 98 um\n[total a]\n"
                             "[force low] box = 50 um .. 150 um, 0 .. 50 um  balance = no\n", NULL, 0, &u))) return;
    CHECK_INT(u.monitors, 5);
    CHECK_OK(&ctx, run(&ctx, &u, path_of("watch"), 0, &l, &r));
    CHECK_INT(l.results, 3);
    CHECK(strstr(l.text, "result case=a plane=a time=0 area=0.0001 flow=") != NULL);
    CHECK_REL(last_of(&ctx, "watch/plane_a.csv", "flow [m2/s]"), 1e-6, 1e-2);
    CHECK_REL(last_of(&ctx, "watch/plane_a.csv", "p [Pa]"), slope * (u.hi[0] - 100e-6), 1e-4);
    CHECK_REL(last_of(&ctx, "watch/force_low.csv", "fx [N/m]"), 0.5 * slope * 100e-6 * 100e-6, 1e-4);
    CHECK_REL(last_of(&ctx, "watch/force_low.csv", "fx_friction [N/m]"), 0.5 * slope * 100e-6 * 100e-6, 1e-4);
    CHECK_REL(last_of(&ctx, "watch/total_a.csv", "mx [kg/s]"), 1000.0 * 0.01 * u.hi[0] * 100e-6, 1e-2);
    CHECK_REL(last_of(&ctx, "watch/line_b_000000_t0.0s.csv", "p [Pa]"), slope * (u.hi[0] - 100e-6), 1e-4);
    CHECK_REL(last_of(&ctx, "watch/line_b_000000_t0.0s.csv", "x [m]"), 100e-6, 1e-12);
    CHECK_NEAR(last_of(&ctx, "watch/line_a_000000_t0.0s.csv", "vy [m/s]"), 0.0, 1e-7);
    CHECK(access(path_of("watch/line_a_v_000000_t0.0s.png"), R_OK) == 0);
    CHECK(access(path_of("watch/line_b_p_000000_t0.0s.png"), R_OK) != 0);
    leave(&ctx, &u);
}

/* A body that spans the channel of three bodies: each by its name, the wall that is one, and metal. With the sides they
 * are everything, whose balance is the same. */
TEST(watching_bodies)
{
    static const char *const names[] = {"a", "b", "all"};
    pd_ctx ctx;
    pd_setup u;
    pd_run_result r;
    listener l;
    double force[3];
    memset(&l, 0, sizeof l);
    if (!CHECK_OK(&ctx, load(&ctx, NARROW "[side x-] flow = inlet  profile = parabola  mean = 1 cm/s\n"
                             "[shape a] ball = 61 um, 42 um  radius = 11.3 um  kind = wall\n"
                             "[shape b] ball = 118 um, 56 um  radius = 10.1 um  kind = wall\n"
                             "[force a] shape = a\n[force b] shape = b  box = 90 um .. 140 um, 30 um .. 80 um\n"
                             "[force all] box = 30 um .. 160 um, 20 um .. 80 um\n", NULL, 0, &u))) return;
    CHECK_OK(&ctx, run(&ctx, &u, path_of("bodies"), 0, &l, &r));
    for (int k = 0; k < 3; k++) {
        char file[64];
        snprintf(file, sizeof file, "bodies/force_%s.csv", names[k]);
        force[k] = last_of(&ctx, file, "fx [N/m]");
    }
    CHECK_LE(1e-6, force[0]);
    CHECK_LE(1e-6, force[1]);
    CHECK_REL(force[0] + force[1], force[2], 1e-9);
    CHECK_REL(last_of(&ctx, "bodies/force_all.csv", "fx_balance [N/m]"), force[2], 5e-4);
    leave(&ctx, &u);
    CHECK(load(&ctx, NARROW "[side x-] flow = inlet  profile = uniform  mean = 1 cm/s\n"
               "[shape a] ball = 61 um, 42 um  radius = 11 um\n[shape m] ball = 120 um, 42 um  radius = 11 um\n"
               "[shape n] union = a, m  kind = wall\n[force x] shape = m\n", NULL, 0, &u) < 0);
    if (!strstr(ctx.message, ":8: shape: found 'm', which is no body, expected a [shape] with kind = solid or wall"))
        CHECK_STR(ctx.message, "a refusal of shape m");
    leave(&ctx, &u);
}

/* A front that recedes at a given speed gives v Cs for each area; a slab under held walls Sh = 2 against its middle. */
TEST(watching_a_transfer)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result r;
    listener l;
    memset(&l, 0, sizeof l);
    if (!CHECK_OK(&ctx, load(&ctx, DISSOLVING "[transfer a] box = 0 .. 200 um, 0 .. 100 um  along = x\n[total a]\n",
                             NULL, 0, &u))) return;
    CHECK_OK(&ctx, run(&ctx, &u, path_of("transfer"), 0, &l, &r));
    double expected = 2e-6 / 3600.0 * u.metal[0].solid_c * 200e-6;
    CHECK_REL(last_of(&ctx, "transfer/transfer_a.csv", "flux [mol/m/s]"), expected, 1e-12);
    CHECK_REL(last_of(&ctx, "transfer/transfer_a_000003_t3600.0s.csv", "x [m]"), 195e-6, 1e-12);
    double held = last_of(&ctx, "transfer/total_a.csv", "dissolved [mol/m]") +
                  last_of(&ctx, "transfer/total_a.csv", "solid [mol/m]");
    CHECK_REL(held, u.metal[0].solid_c * 200e-6 * 50e-6, 1e-9);
    CHECK(access(path_of("transfer/transfer_a_density_000003_t3600.0s.png"), R_OK) == 0);
    leave(&ctx, &u);
#define HELD \
    "[grid] h = 10 um  box = 0 .. 100 um, 0 .. 100 um\n[side x-] flow = mirror\n" \
    "[side x+] flow = mirror\n[side y-] C = 2 mol/m3\n[side y+] C = 1 mol/m3\n" \
    "[transport] D = 1e-9 m2/s  time = steady\n" \
    "[transfer a] box = 0 .. 100 um, 0 .. 50 um  along = x  reference_length = 100 um\n" \
    "             surface = 2 mol/m3  fluid = 1.5 mol/m3"
    if (!CHECK_OK(&ctx, load(&ctx, HELD "\n", NULL, 0, &u))) return;
    CHECK_OK(&ctx, run(&ctx, &u, path_of("held"), 0, &l, &r));
    CHECK_REL(last_of(&ctx, "held/transfer_a.csv", "Sh [-]"), 2.0, 5e-11);
    CHECK_REL(last_of(&ctx, "held/transfer_a.csv", "area [m]"), 100e-6, 1e-9);
    CHECK_REL(last_of(&ctx, "held/transfer_a.csv", "density [mol/m2/s]"), 1e-5, 1e-10);
    CHECK_REL(last_of(&ctx, "held/transfer_a.csv", "layer [m]"), 50e-6, 1e-10);
    CHECK_REL(last_of(&ctx, "held/transfer_a_000000_t0.0s.csv", "Sh [-]"), 2.0, 5e-11);
    leave(&ctx, &u);
    /* the same flux through an area that is given, a quarter of that */
    if (!CHECK_OK(&ctx, load(&ctx, HELD "  area = 25 um\n", NULL, 0, &u))) return;
    CHECK_OK(&ctx, run(&ctx, &u, path_of("given"), 0, &l, &r));
    CHECK_REL(last_of(&ctx, "given/transfer_a.csv", "area [m]"), 25e-6, 1e-12);
    CHECK_REL(last_of(&ctx, "given/transfer_a.csv", "flux [mol/m/s]"), 1e-9, 1e-10);
    CHECK_REL(last_of(&ctx, "given/transfer_a.csv", "density [mol/m2/s]"), 4e-5, 1e-10);
    CHECK_REL(last_of(&ctx, "given/transfer_a.csv", "Sh [-]"), 8.0, 1e-10);
    CHECK_REL(last_of(&ctx, "given/transfer_a.csv", "layer [m]"), 12.5e-6, 1e-10);
    leave(&ctx, &u);
}

TEST(refusals)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    refused(STILL "[shape a] kind = solid\n", "a.scene:4: shape: found no geometry");
    refused(STILL "[shape a] box = 0 .. 1 um, 0 .. 1 um  kind = solid  grain_size = -1 um\n",
            "a.scene:4: grain_size: found -1 um");
    refused(STILL BLOCK "[dissolve] rate = 1 um/h  law = 1 1/s\n", "a.scene:5: law: found beside 'rate'");
    refused(STILL BLOCK "[dissolve] rate = 1 um/h  threshold = 1\n", "a.scene:5: threshold: found 1, expected");
    refused(STILL BLOCK "[dissolve] rate = -1 um/h\n", "a.scene:5: rate: found a recession speed of -2.77778e-10 m/s");
    refused(STILL "[output] slice = z 0 um\n", "a.scene:4: slice: found in 2D");
    refused(STILL "[output] prefix = a/b\n", "a.scene:4: prefix: found 'a/b'");
    refused("[grid] h = 1 um  box = 0 .. 9 um, 0 .. 9 um\n", "found no physics");
    refused(CHANNEL "[side x-] flow = inlet  profile = parabola  mean = 1 m/s  flow_rate = 1 mL/min\n",
            "a.scene:4: flow_rate: found beside 'mean'");
    refused(CHANNEL "[side x-] flow = inlet  profile = expression\n", "a.scene:4: profile: found 'expression' without");
    /* nothing develops between mirrors */
    if (!CHECK_OK(&ctx, load(&ctx, CHANNEL "[side y-] flow = mirror\n[side y+] flow = mirror\n"
                             "[side x-] flow = inlet  profile = parabola  mean = 1 m/s\n", NULL, 0, &u))) return;
    CHECK_INT(pd_model_build(&ctx, &u, &m), PD_ERR_GEOMETRY);
    CHECK(strstr(ctx.message, "side x-: found no wall beside the opening") != NULL);
    leave(&ctx, &u);
}
TEST_MAIN(ENTRY(every_key) ENTRY(shapes_and_operations) ENTRY(overrides_replace_values) ENTRY(law_per_layer)
          ENTRY(masks) ENTRY(parabola_between_walls) ENTRY(flow_rate_and_direction) ENTRY(expression_profile)
          ENTRY(flow_without_progress) ENTRY(sides_and_motion)
          ENTRY(absent_physics_costs_nothing) ENTRY(grain_factor) ENTRY(files_of_a_run) ENTRY(stop_and_check)
          ENTRY(flow_alone) ENTRY(walls_and_media) ENTRY(watching_a_flow)
          ENTRY(watching_bodies) ENTRY(watching_a_transfer) ENTRY(refusals))
#else
#define TUBE \
    "[grid] h = 10 um  box = 0 .. 80 um, -40 um .. 40 um, -40 um .. 40 um\n" \
    "[flow] rho = 1 g/cm3  mu = 1 mPa s\n[side x+] flow = outlet\n"

/* 2 U (1 - (r/R)^2) with U = Q / (pi R^2). */
TEST(parabola_of_a_tube)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    double x[3] = {-15e-6, 10e-6, -20e-6}, v[3], mean = 1e-9 / 60.0 / (3.14159265358979323846 * 37e-6 * 37e-6);
    if (!CHECK_OK(&ctx, load(&ctx, TUBE "[shape w] cylinder = x  radius = 37 um  outside = yes  kind = wall\n"
                             "[side x-] flow = inlet  profile = parabola  flow_rate = 1 uL/min\n", NULL, 0, &u)))
        return;
    if (CHECK_OK(&ctx, pd_model_build(&ctx, &u, &m))) {
        CHECK_REL(m.flow.reference_speed, mean, 1e-12);
        CHECK_REL(m.flow.reference_length, 74e-6, 1e-12);
        pdi_inlet_get_velocity(&m.inlet, x, v);
        CHECK_REL(v[0], 2.0 * mean * (1.0 - 500.0 / 1369.0), 1e-12);
        CHECK_NEAR(fabs(v[1]) + fabs(v[2]), 0.0, 0.0);
        pd_model_free(&ctx, &m);
    }
    leave(&ctx, &u);
}

/* A function of y and z alone, the same at both ends of the diagonals, which adds up to the mean; nothing develops
 * between mirrors. */
TEST(parabola_of_a_square)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    double sum = 0.0, v[3];
    if (!CHECK_OK(&ctx, load(&ctx, TUBE "[side x-] flow = inlet  profile = parabola  mean = 1 m/s\n", NULL, 0,
                             &u))) return;
    if (CHECK_OK(&ctx, pd_model_build(&ctx, &u, &m))) {
        for (int k = 0; k < 64; k++) {
            double x[3], w[3];
            x[0] = -5e-6;
            x[1] = -35e-6 + 10e-6 * (k % 8);
            x[2] = -35e-6 + 10e-6 * (k / 8);
            pdi_inlet_get_velocity(&m.inlet, x, v);
            sum += v[0] / 64.0;
            x[1] = -x[1];
            pdi_inlet_get_velocity(&m.inlet, x, w);
            CHECK_NEAR(w[0], v[0], 1e-9);
            x[0] = x[2];
            x[2] = x[1];
            x[1] = x[0];
            x[0] = -15e-6;
            pdi_inlet_get_velocity(&m.inlet, x, w);
            CHECK_NEAR(w[0], v[0], 1e-9);
        }
        CHECK_NEAR(sum, 1.0, 1e-9);
        pd_model_free(&ctx, &m);
    }
    leave(&ctx, &u);
    if (!CHECK_OK(&ctx, load(&ctx, TUBE "[side x-] flow = inlet  profile = parabola  mean = 1 m/s\n"
                             "[side y-] flow = mirror\n[side y+] flow = mirror\n"
                             "[side z-] flow = periodic\n[side z+] flow = periodic\n", NULL, 0, &u))) return;
    CHECK_INT(pd_model_build(&ctx, &u, &m), PD_ERR_GEOMETRY);
    CHECK(strstr(ctx.message, "side x-: found no wall beside the opening") != NULL);
    leave(&ctx, &u);
}

/* The line is that of the inlet without a profile, not of the one that was measured last. */
TEST(line_of_an_inlet_without_profile)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (!CHECK_OK(&ctx, load(&ctx,
                             "[grid] h = 10 um  box = 0 .. 80 um, -40 um .. 40 um, -40 um .. 40 um\n"
                             "[flow] rho = 1 g/cm3  mu = 1 mPa s\n[side y-] flow = mirror\n[side y+] flow = mirror\n"
                             "[side x-] flow = inlet  profile = parabola  mean = 1 m/s\n"
                             "[side x+] flow = inlet  profile = uniform  mean = 1 m/s\n"
                             "[side z-] flow = outlet\n[side z+] flow = mirror\n",
                             NULL, 0, &u)))
        return;
    CHECK_INT(pd_model_build(&ctx, &u, &m), PD_ERR_GEOMETRY);
    CHECK(strstr(ctx.message, "side x-: found no wall beside the opening") != NULL);
    CHECK_INT(m.error_line, 5);
    leave(&ctx, &u);
}

TEST(slices)
{
    static const char *const scene = TUBE "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n"
                                          "[output] images = v  slice = y 15 um\n";
    pd_ctx ctx;
    pd_setup u;
    if (!CHECK_OK(&ctx, load(&ctx, scene, NULL, 0, &u))) return;
    CHECK_INT(u.slice_axis, 1);
    CHECK_NEAR(u.slice_at, 15e-6, 0.0);
    leave(&ctx, &u);
    refused(TUBE "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n[output] slice = y 15\n",
            "a.scene:5: slice: slice: column 3: found a number without unit");
    refused(TUBE "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n[output] slice = w 0 um\n",
            "a.scene:5: slice: found 'w 0 um'");
}
#define BLOCK \
    "[grid] h = 1 um  box = 0 .. 10 um, 0 .. 10 um, 0 .. 10 um\n" \
    "[transport] D = 1e-9 m2/s\n[run] until = 1 s\n"
#define METAL BLOCK "[shape a] box = 0 .. 10 um, 0 .. 10 um, 0 .. 5 um  kind = solid\n"

/* The surface of the metal, and lines along a flow, without what they need. */
TEST(surfaces_and_streamlines)
{
    pd_setup u;
    pd_ctx ctx;
    if (!CHECK_OK(&ctx, load(&ctx, METAL "[output] surface = yes  width = 500\n", NULL, 0, &u))) return;
    CHECK(u.drawing.surface == 1 && u.drawing.width == 500);
    CHECK_NEAR(u.drawing.view_direction[1], -1.0, 0.0);
    leave(&ctx, &u);
    if (!CHECK_OK(&ctx, load(&ctx, METAL "[output] surface = C  view = 0, 0, 2  range = C 0 .. 1 mol/m3\n", NULL, 0,
                             &u))) return;
    CHECK(u.drawing.surface == 2 + (int)PD_FIELD_C && u.drawing.range[PD_FIELD_C][1] > 0.5);
    leave(&ctx, &u);
    refused(BLOCK "[output] surface = yes\n", "a.scene:4: surface: found without a [shape] of kind = solid");
    refused(METAL "[output] surface = Q\n", "a.scene:5: surface: found 'Q', expected yes, no or a field with values");
    refused(METAL "[output] surface = kind\n", "a.scene:5: surface: found 'kind', expected yes, no or a field");
    refused(METAL "[output] surface = v\n", "a.scene:5: surface: found 'v', which needs a [flow] or [gas] section");
    refused(METAL "[output] surface = yes  view = 0, 0, 0\n", "a.scene:5: view: found no direction");
    refused(METAL "[output] images = C  streamlines = C\n",
            "a.scene:5: streamlines: found without a [flow] or [gas] section");
}
#undef BLOCK
#undef METAL

TEST_MAIN(ENTRY(parabola_of_a_tube) ENTRY(parabola_of_a_square) ENTRY(line_of_an_inlet_without_profile) ENTRY(slices)
          ENTRY(surfaces_and_streamlines))
#endif
