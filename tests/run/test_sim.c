/* sim: a scene step by step against a run of it, its fields against the model.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "setup/fields.h"
#include "run/sim.h"
#include "physics/sample.h"
#include "checkpoint_scene.h"

/* Without outputs on the way, which cut steps of a run. */
#define ONE_OUTPUT "output.every=100 h"

/* A pin that dissolves in a stream. */
#define PIN_SCENE \
    CHANNEL PIN "  grain_size = 20 um\n" THROUGH \
                "[transport] D = 1e-9 m2/s\n[dissolve] m = 2  grain_boundary_factor = 3" LAW "\n" \
                "[run] until = " HOURS "  max_dissolved_fraction = 0.3\n[output] every = 2 h  fields = C\n"

static pd_sim sim;

/* The same with pd_run: time, steps, loss and ledger, bit for bit; and with pd_time_loop_run: the fields. */
static void against_run(const char *text, const char *const *names)
{
    const char *overrides[] = {ONE_OUTPUT, "until = 2 h"}; /* some metal is left: fields of its surface have values */
    pd_ctx ctx, other;
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    pd_model model;
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    if (!CHECK_OK(&ctx, pd_sim_open(&ctx, text, overrides, 2, &sim))) return;
    CHECK_NEAR(sim.time, 0.0, 0.0);
    while (sim.time < sim.end_time)
        if (!CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, sim.end_time))) return;
    CHECK(sim.steps > 1);

    memset(&desc, 0, sizeof desc);
    desc.no_files = 1;
    if (!CHECK_OK(&other, load(&other, text, overrides, 2, &setup))) return;
    CHECK_OK(&other, pd_run(&other, &setup, &desc, &result));
    CHECK_NEAR(result.time, sim.time, 0.0);
    CHECK_INT(result.steps, sim.steps);
    CHECK_NEAR(result.volume_loss, pd_time_loop_volume_loss(&sim.model.time_loop), 0.0);
    CHECK_OK(&other, pd_model_build(&other, &setup, &model));
    CHECK_OK(&other, pd_time_loop_run(&other, &model.time_loop, setup.end_time, 0.0, NULL, NULL));
    for (int k = 0; names[k]; k++) {
        pd_field_view v;
        int field = 0, at[PD_DIM];
        if (!CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, names[k], &v))) continue;
        while (strcmp(pd_fields_get_name(&setup, (pd_field)field), names[k]) != 0) field++;
        CHECK_INT(v.components, field == PD_FIELD_V ? PD_DIM : 1);
        CHECK_STR(v.label, pd_fields_get_label(&setup, (pd_field)field));
        memset(at, 0, sizeof at);
        double size = 0.0;
        for (int64_t cell = 0; cell < v.component_stride; cell++) {
            int64_t place_of = 0;
            int32_t i = pd_grid_node(&model.grid, at);
            double square = 0.0, value = pd_sample_get_node(&model, (pd_field)field, i);
            for (int d = 0; d < PD_DIM; d++) place_of += at[d] * v.stride[d];
            for (int d = 0; d < v.components; d++) {
                double part = v.data[d * v.component_stride + place_of];
                square += part * part;
            }
            double found = v.components > 1 ? sqrt(square) : v.data[place_of];
            int unknown = strcmp(names[k], "rate") == 0 || (model.just_converted && model.just_converted[i]);
            if (isnan(value)) CHECK(isnan(found) && unknown); /* off the surface, or it has just turned fluid */
            else CHECK_NEAR(found, value, 0.0);
            size += isnan(value) ? 0.0 : fabs(value);
            for (int d = 0; d < PD_DIM && ++at[d] == v.n[d]; d++) at[d] = 0;
        }
        if (!CHECK(size > 0.0)) NOTE("%s is zero everywhere", names[k]);
    }
    pd_model_free(&other, &model);
    leave(&other, &setup);
    pd_sim_close(&ctx, &sim);
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
}

TEST(a_pin_in_a_stream)
{
    const char *names[] = {"C", "v", "p", "kind", "rate", "density", "grain", "D", NULL};
    against_run(PIN_SCENE, names);
}

/* A scene text is named "scene" in messages; a file by its path. Nothing is left of what is refused. */
TEST(what_is_refused)
{
    static const char text[] =
        CHANNEL PIN "\n[side x-] flow = inlet  profile = uniform  mean = 0.01 m/s\n[side x+] flow = outlet\n"
                    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  time = implicit\n[run] until = 1 s\n";
    const char *overrides[] = {"until=1 h", "m=0.3"};
    pd_ctx ctx;
    pd_field_view view;
    pd_ctx_init(&ctx);
    CHECK_INT(pd_sim_open(&ctx, "nowhere.scene", NULL, 0, &sim), PD_ERR_FILE);
    CHECK_INT(ctx.in_use, 0);
    CHECK(pd_sim_open(&ctx, "[grid] h = 1 um\n[gird] h = 2 um\n", NULL, 0, &sim) < 0);
    CHECK(strncmp(ctx.message, "scene:2", 7) == 0);
    CHECK_INT(ctx.in_use, 0);
    CHECK(pd_sim_open(&ctx, text, overrides, 2, &sim) < 0);
    CHECK_INT(ctx.in_use, 0);
    pd_sim_close(&ctx, &sim);
    if (!CHECK_OK(&ctx, pd_sim_open(&ctx, text, overrides, 1, &sim))) return;
    CHECK_NEAR(sim.end_time, 3600.0, 0.0);
    CHECK_INT(pd_sim_step(&ctx, &sim, 0.0), PD_ERR_ARGUMENT);
    CHECK_INT(pd_sim_field(&ctx, &sim, "q", &view), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "no field has the name q") != NULL);
    CHECK_INT(pd_sim_field(&ctx, &sim, "C", &view), PD_ERR_ARGUMENT);
    CHECK_STR(ctx.message, "view: the field C needs a [transport] or [corrode] section");
    CHECK(view.data == NULL);
    CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, "v", &view));
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
}

/* What an observer has seen of a run. */
typedef struct seen {
    int starts, steps, ends, stop_after;
    int64_t before; /* steps of a run that goes on */
    double time, loss, most, figure;
    int figures;
} seen;

/* The fields are those of the model, the figures those of its observables. */
static int watch(void *user, pd_ctx *ctx, const pd_snapshot *at)
{
    seen *s = (seen *)user;
    pd_field_view c, none;
    pd_scalar_outputs figures;
    memset(&figures, 0, sizeof figures);
    CHECK_INT(s->ends, 0);
    CHECK(at->stage == PD_SNAPSHOT_STAGE_START ? s->starts == 0 : s->starts == 1);
    s->starts += at->stage == PD_SNAPSHOT_STAGE_START;
    s->steps += at->stage == PD_SNAPSHOT_STAGE_STEP;
    s->ends += at->stage == PD_SNAPSHOT_STAGE_END;
    CHECK_INT(pd_snapshot_get_field(ctx, at, "q", &none), PD_ERR_ARGUMENT);
    s->most = 0.0;
    if (CHECK_OK(ctx, pd_snapshot_get_field(ctx, at, "C", &c)))
        for (int64_t cell = 0; cell < c.component_stride; cell++) s->most = fmax(s->most, c.data[cell]);
    CHECK_NEAR(s->most, at->diagnostics->c_max, 0.0);
    if (CHECK_OK(ctx, pd_snapshot_get_outputs(ctx, at, &figures)) && CHECK(figures.count > 1)) {
        CHECK_STR(figures.list[0].key, "volume_loss");
        CHECK_NEAR(figures.list[0].value, at->diagnostics->volume_loss, 0.0);
        s->figure = figures.list[figures.count - 1].value;
        CHECK(s->figures == 0 || s->figures == figures.count);
        s->figures = figures.count;
    }
    pd_scalar_outputs_free(ctx, &figures);
    if (at->stage == PD_SNAPSHOT_STAGE_STEP) CHECK_INT(at->steps, s->steps + s->before);
    if (at->stage == PD_SNAPSHOT_STAGE_START) s->before = at->steps;
    if (at->stage == PD_SNAPSHOT_STAGE_STEP) CHECK_NEAR(at->time - s->time, at->dt, 1e-9 * at->dt);
    s->time = at->time;
    s->loss = at->diagnostics->volume_loss;
    return s->stop_after && s->steps == s->stop_after;
}

#define LOOKED PIN_SCENE "[probe a] at = 41 um" ZERO "  fields = C, density\n[total all]\n"

/* A run that is watched makes the same steps; the observer may end it, with all of its files, and it goes on. */
TEST(an_observer)
{
    pd_ctx ctx;
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result plain, result;
    seen all, some, rest;
    memset(&desc, 0, sizeof desc);
    memset(&all, 0, sizeof all);
    memset(&some, 0, sizeof some);
    memset(&rest, 0, sizeof rest);
    if (!CHECK_OK(&ctx, load(&ctx, LOOKED, NULL, 0, &setup))) return;
    desc.no_files = 1;
    if (!CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &plain))) return;
    desc.observe = watch;
    desc.observe_user = &all;
    CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &result));
    CHECK(all.starts == 1 && all.ends == 1 && all.steps == plain.steps && !result.stopped);
    CHECK_NEAR(result.volume_loss, plain.volume_loss, 0.0);
    CHECK_NEAR(all.loss, plain.volume_loss, 0.0);
    CHECK_INT(all.figures, 1 + 6 + PD_DIM + 2); /* loss, total: volume, energy, momentum and four more, probe */
    desc.no_files = 0;
    desc.folder = path_of("watched");
    desc.checkpoints = 1;
    desc.checkpoint_every = 1e9;
    desc.observe_user = &some;
    some.stop_after = 2;
    CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &result));
    CHECK(result.stopped && some.steps == 2 && some.ends == 1 && result.steps == 2);
    desc.resume = 1;
    desc.observe_user = &rest;
    CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &result));
    CHECK(!result.stopped && rest.starts == 1 && rest.ends == 1);
    CHECK_NEAR(result.volume_loss, plain.volume_loss, 0.0);
    CHECK_NEAR(rest.figure, all.figure, 0.0);
    leave(&ctx, &setup);
    CHECK_INT(ctx.in_use, 0);
}

/* Every field of a probe's table once, in the order of the table, with its unit. */
static int watch_probe(void *user, pd_ctx *ctx, const pd_snapshot *at)
{
    static const char *const key[] = {"volume_loss", "vx", "vy",
#if PD_DIM == 3
                                      "vz",
#endif
                                      "p", "C", "kind", "grain", "rate", "density"};
    static const char *const unit[] = {"-", "m/s", "m/s",
#if PD_DIM == 3
                                       "m/s",
#endif
                                       "Pa", "mol/m3", "-", "-", "m/s", "kg/m3"};
    pd_scalar_outputs figures;
    int *looks = (int *)user;
    memset(&figures, 0, sizeof figures);
    if (!CHECK_OK(ctx, pd_snapshot_get_outputs(ctx, at, &figures))) return 1;
    if (CHECK_INT(figures.count, sizeof key / sizeof key[0]))
        for (int k = 0; k < figures.count; k++) {
            CHECK_STR(figures.list[k].section, k ? "probe" : "scene");
            CHECK_STR(figures.list[k].name, k ? "a" : "");
            CHECK_STR(figures.list[k].key, key[k]);
            CHECK_STR(figures.list[k].unit, unit[k]);
            CHECK_INT(figures.list[k].monitor, -1);
        }
    pd_scalar_outputs_free(ctx, &figures);
    ++*looks;
    return 1;
}

TEST(figures_of_a_probe)
{
    pd_ctx ctx;
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    int looks = 0;
    memset(&desc, 0, sizeof desc);
    static const char *const text =
        PIN_SCENE "[probe a] at = 41 um" ZERO "  fields = density, C, v, kind, p, rate, grain\n";
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &setup))) return;
    desc.no_files = 1;
    desc.observe = watch_probe;
    desc.observe_user = &looks;
    CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &result));
    CHECK(looks > 0);
    leave(&ctx, &setup);
}

/* C, t, x, y, z */
static double law(void *user, const double *vars)
{
    ++*(int64_t *)user;
    return 2e-6 / 3600.0 * (1.0 - vars[0] / 56.0);
}

/* x, y, z, t */
static double stream(void *user, const double *vars)
{
    (void)user;
    return vars[PD_DIM] < 3600.0 ? 0.01 : 0.02;
}

static double entering(void *user, const double *vars)
{
    (void)user;
    return vars[1] > 0.0 ? 3.0 : 1.0;
}

/* The law of the scene as a function makes the same steps. A rate in other units, and a factor, count no more. */
TEST(functions_of_the_caller)
{
    static const char *const changes[] = {"dissolve.rate_scale=7"};
    static pd_sim called;
    pd_ctx ctx, other;
    int64_t calls = 0;
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    pd_ctx_init(&other);
    other.threads = 1;
    memset(&called, 0, sizeof called);
    if (!CHECK_OK(&ctx, pd_sim_open(&ctx, PIN_SCENE, NULL, 0, &sim))) return;
    if (!CHECK_OK(&other, pd_scene_parse(&other, "pin", PIN_SCENE, changes, 1, &called.setup))) return;
    CHECK_OK(&other, pd_setup_set_function(&other, &called.setup, "rate", law, &calls, 1));
    if (!CHECK_OK(&other, pd_sim_start(&other, &called))) return;
    for (int k = 0; k < 2; k++) {
        CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, 7200.0));
        CHECK_OK(&other, pd_sim_step(&other, &called, 7200.0));
    }
    CHECK(calls > 0);
    CHECK_NEAR(called.time, sim.time, 1e-9 * sim.time);
    double loss = pd_time_loop_volume_loss(&sim.model.time_loop);
    CHECK_NEAR(pd_time_loop_volume_loss(&called.model.time_loop), loss, 1e-9 * loss);
    pd_sim_close(&other, &called);
    CHECK_INT(other.in_use, 0);
    pd_sim_close(&ctx, &sim);
}

/* As much in one second as otherwise in two hours. */
static double pulse(void *user, const double *vars)
{
    double speed = 0.1e-6 / 3600.0;
    if (!user) return speed;
    return vars[1] > 4000.0 && vars[1] < 4001.0 ? 7200.0 * speed : 0.0;
}

/* A pulse between steps counts where its breaks are told: the loss is that of the same amount, spread over the time. */
TEST(functions_tell_their_breaks)
{
    static const double breaks[] = {4000.0, 4001.0}, wrong[] = {2.0, 1.0};
    double loss[2];
    int pulses = 1;
    for (int k = 0; k < 2; k++) {
        pd_ctx ctx;
        pd_ctx_init(&ctx);
        ctx.threads = 1;
        memset(&sim, 0, sizeof sim);
        if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "pin", PIN_SCENE, NULL, 0, &sim.setup))) return;
        double scale = sim.setup.metal[0].rate_scale;
        sim.setup.metal[0].rate_scale = 3.0; /* what is refused changes nothing */
        CHECK_INT(pd_setup_set_breaks(&ctx, &sim.setup, "rate", breaks, 2), PD_ERR_ARGUMENT); /* no function yet */
        CHECK_NEAR(sim.setup.metal[0].rate_scale, 3.0, 0.0);
        sim.setup.metal[0].rate_scale = scale;
        CHECK_OK(&ctx, pd_setup_set_function(&ctx, &sim.setup, "rate", pulse, k ? &pulses : NULL, 2));
        CHECK_INT(pd_setup_set_breaks(&ctx, &sim.setup, "rate", wrong, 2), PD_ERR_ARGUMENT);
        CHECK(strstr(ctx.message, "break 1 of 'rate' is 1 s") != NULL);
        CHECK_OK(&ctx, pd_setup_set_breaks(&ctx, &sim.setup, "rate", breaks, 2));
        CHECK_INT(pd_setup_set_function(&ctx, &sim.setup, "rat", pulse, NULL, 2), PD_ERR_ARGUMENT);
        CHECK_INT(sim.setup.metal[0].rate.discontinuity_count, 2);
        CHECK_OK(&ctx, pd_setup_set_function(&ctx, &sim.setup, "rate", pulse, k ? &pulses : NULL, 2));
        CHECK_INT(sim.setup.metal[0].rate.discontinuity_count, 0); /* they are those of the function before */
        CHECK_OK(&ctx, pd_setup_set_breaks(&ctx, &sim.setup, "rate", breaks, 2));
        if (!CHECK_OK(&ctx, pd_sim_start(&ctx, &sim))) return;
        CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, 7200.0));
        loss[k] = pd_time_loop_volume_loss(&sim.model.time_loop);
        pd_sim_close(&ctx, &sim);
        CHECK_INT(ctx.in_use, 0);
    }
    CHECK(loss[0] > 0.0);
    CHECK_REL(loss[1], loss[0], 1e-3);
}

/* C, t, x, y, z, grain */
static double law_of_grain(void *user, const double *vars)
{
    int odd = (int)vars[PD_SETUP_RATE_GRAIN] % 2;
    *(int *)user |= odd ? 2 : 1;
    return (odd ? 3e-6 : 1e-6) / 3600.0;
}

/* A law that differs from grain to grain, as an expression and as a function; without grains there is none. */
TEST(a_law_of_grains)
{
    static const char *const changes[] = {"dissolve.rate=if(grain - 2*floor(grain/2) > 0.5, 3 um/h, 1 um/h)",
                                          "dissolve.Csat=60 mol/m3"};
    static const char *const coarse[] = {"dissolve.rate=if(grain > 2.5, 3 um/h, 1 um/h)"};
    static pd_sim called;
    int seen_grains = 0;
    pd_ctx ctx, other;
    pd_setup setup;
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    pd_ctx_init(&other);
    other.threads = 1;
    memset(&called, 0, sizeof called);
    if (!CHECK_OK(&ctx, pd_sim_open(&ctx, PIN_SCENE, changes, 2, &sim))) return;
    if (!CHECK_OK(&other, pd_scene_parse(&other, "pin", PIN_SCENE, changes + 1, 1, &called.setup))) return;
    CHECK_OK(&other, pd_setup_set_function(&other, &called.setup, "rate", law_of_grain, &seen_grains,
                                           1u << (PD_SETUP_RATE_GRAIN)));
    if (!CHECK_OK(&other, pd_sim_start(&other, &called))) return;
    for (int k = 0; k < 2; k++) {
        CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, 7200.0));
        CHECK_OK(&other, pd_sim_step(&other, &called, 7200.0));
    }
    CHECK_INT(seen_grains, 3);
    double loss = pd_time_loop_volume_loss(&sim.model.time_loop);
    CHECK(loss > 0.0);
    CHECK_NEAR(pd_time_loop_volume_loss(&called.model.time_loop), loss, 1e-9 * loss);
    pd_sim_close(&other, &called);
    pd_sim_close(&ctx, &sim);
    static const char plain[] = CHANNEL PIN "\n[transport] D = 1e-9 m2/s\n[dissolve] m = 2" LAW "\n[run] until = 1 h\n";
    CHECK_INT(pd_scene_parse(&ctx, "pin", plain, coarse, 1, &setup), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "expected grain_size = SIZE in a solid [shape ...]") != NULL);
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "pin", plain, NULL, 0, &setup))) return;
    CHECK_INT(pd_setup_set_function(&ctx, &setup, "rate", law_of_grain, &seen_grains, 1u << (PD_SETUP_RATE_GRAIN)),
              PD_ERR_ARGUMENT);
    pd_setup_free(&ctx, &setup);
    CHECK_INT(ctx.in_use, 0);
}

/* A speed that jumps in time, and a concentration that differs over the inlet. */
TEST(functions_of_an_inlet)
{
    static const char text[] = CHANNEL THROUGH "[transport] D = 1e-8 m2/s\n[run] until = 1 s\n";
    pd_ctx ctx;
    pd_field_view v, c;
    pd_ctx_init(&ctx);
    memset(&sim, 0, sizeof sim);
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "inlet", text, NULL, 0, &sim.setup))) return;
    CHECK_OK(&ctx, pd_setup_set_function(&ctx, &sim.setup, "x-.mean", stream, NULL, 0));
    CHECK_OK(&ctx, pd_setup_set_function(&ctx, &sim.setup, "x-.C", entering, NULL, 2));
    if (!CHECK_OK(&ctx, pd_sim_start(&ctx, &sim))) return;
    CHECK(sim.model.inlet.is_time_dependent);
    CHECK_NEAR(pdi_inlet_get_mean_velocity(&sim.model.inlet, 0), 0.01, 0.0);
    sim.model.inlet.time = 7200.0;
    CHECK_NEAR(pdi_inlet_get_mean_velocity(&sim.model.inlet, 0), 0.02, 0.0);
    sim.model.inlet.time = 0.0;
    while (sim.time < 0.05)
        if (!CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, 0.05))) break;
    CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, "C", &c));
    double other_half = PD_DIM == 3 ? 1e-4 : 5e-11; /* what diffuses from there: a corner in 3D is slow */
    CHECK_NEAR(c.data[0], 1.0, other_half);
    CHECK_NEAR(c.data[(c.n[1] - 1) * c.stride[1]], 3.0, other_half);

    /* a view that is kept stays, the next one is another */
    CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, "v", &v));
    double kept = v.data[v.component_stride / 2];
    pd_sim_detach_view(&sim, &v);
    pd_field_view again;
    CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, "v", &again));
    CHECK(again.data != v.data);
    pd_sim_close(&ctx, &sim);
    CHECK_NEAR(v.data[v.component_stride / 2], kept, 0.0);
    CHECK_INT(ctx.in_use, (int64_t)sizeof(double) * PD_DIM * v.component_stride);
    pd_sim_free_view(&ctx, &v);
    pd_sim_free_view(&ctx, &v);
    CHECK_INT(ctx.in_use, 0);
}

TEST(functions_that_are_refused)
{
    static const struct {
        const char *key, *message;
    } wrong[] = {{"rat", "expected rate, initial, or a side and its value, such as x-.C"},
                 {"x-", "expected rate, initial, or a side and its value, such as x-.C"},
                 {"x-.p", "expected C, mean or vx, vy, vz behind the side"},
                 {"x-.vx", "expected an inlet with profile = expression"},
                 {"x+.mean", "expected an inlet with profile = uniform or parabola"},
                 {"x+.C", "expected an inlet, or a wall that holds a concentration"},
                 {"x-.C", "[transfer] has fluid = inlet, expected bulk or a concentration"}};
    static const char transfer[] = PIN_SCENE "[transfer f] box = -30 um .. 60 um" ACROSS(
        "-25 um .. 25 um") "  reference_length = 40 um  surface = 56 mol/m3  fluid = inlet\n";
    static const char still[] = CHANNEL "[transport] D = 1e-8 m2/s\n[run] until = 1 s\n";
    pd_ctx ctx;
    pd_setup setup;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "pin", transfer, NULL, 0, &setup))) return;
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        CHECK_INT(pd_setup_set_function(&ctx, &setup, wrong[k].key, law, NULL, 1), PD_ERR_ARGUMENT);
        if (!CHECK(strstr(ctx.message, wrong[k].message) != NULL)) NOTE("%s: %s", wrong[k].key, ctx.message);
    }
    pd_setup_free(&ctx, &setup);
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "still", still, NULL, 0, &setup))) return;
    CHECK_INT(pd_setup_set_function(&ctx, &setup, "rate", law, NULL, 1), PD_ERR_ARGUMENT);
    CHECK_STR(ctx.message, "setup: a function for 'rate': expected [dissolve] or [corrode]");
    CHECK_OK(&ctx, pd_setup_set_function(&ctx, &setup, "initial", entering, NULL, 2));
    pd_setup_free(&ctx, &setup);
    CHECK_INT(ctx.in_use, 0);
}

TEST_MAIN(ENTRY(a_pin_in_a_stream) ENTRY(what_is_refused) SLOW_ENTRY_IF(PD_DIM == 3, an_observer)
              ENTRY(figures_of_a_probe) ENTRY(functions_of_the_caller)
                  SLOW_ENTRY_IF(PD_DIM == 3, functions_tell_their_breaks) ENTRY(a_law_of_grains)
                      SLOW_ENTRY_IF(PD_DIM == 3, functions_of_an_inlet) ENTRY(functions_that_are_refused))
