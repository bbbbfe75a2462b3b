/* physics_type: a physics that a program brings along: its section, its field in laws, lists and tables, its state in
 * checkpoints, what is refused.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "setup/fields.h"
#include "physics/memory_estimate.h"
#include "run/sim.h"
#include "scene_file.h"
#include <math.h>

/* ---- a body that cools: T = start exp(-k t) everywhere, and S = 2 T in the metal ---- */

enum { KEY_RATE, KEY_START, KEY_STEP, KEY_NOTHING, KEY_MODE, KEY_PARTS, KEYS };
static const pd_key keys[KEYS] = {{"k", "1/s", "required", "rate of cooling", PD_KEY_EXPRESSION_NOT_NEGATIVE},
                                  {"start", "K", "300 K", "temperature at the start", PD_KEY_EXPRESSION},
                                  {"step", "s", "100 s", "longest step of a run", PD_KEY_ABOVE(0.0, 1e6)},
                                  {"nothing", "m", "-", "a key without a default", PD_KEY_EXPRESSION},
                                  {"mode", "-", "slow", "a choice", PD_KEY_ONE_OF("slow, fast, idle")},
                                  {"parts", "-", "2", "a whole number", PD_KEY_WHOLE_FROM(1, 8)}};
static const pd_physics_field fields[] = {{"T", "K", PD_FIELD_IN_BOTH}, {"S", "K", PD_FIELD_IN_METAL}};

typedef struct cooling {
    const pd_physics_view *view;
    double *T, *S; /* [total] [K] */
    double time;   /* [s] */
} cooling;

static int fails; /* the builder fails after it has asked for memory */

static void cooling_free(pd_ctx *ctx, void *self)
{
    cooling *s = (cooling *)self;
    PD_DELETE(ctx, s->view->grid->total, s->T);
    PD_DELETE(ctx, s->view->grid->total, s->S);
    PD_DELETE(ctx, 1, s);
}

static pd_status cooling_build(pd_ctx *ctx, const pd_physics_view *view, void **state)
{
    cooling *s = NULL;
    PD_TRY(PD_NEW(ctx, "cooling", 1, s));
    s->view = view;
    pd_status status = PD_NEW(ctx, "cooling", view->grid->total, s->T);
    if (status == PD_OK) status = PD_NEW(ctx, "cooling", view->grid->total, s->S);
    if (status == PD_OK && fails) status = pd_fail(ctx, PD_ERR_STATE, "cooling", "as it was asked to");
    if (status < 0) {
        cooling_free(ctx, s);
        return status;
    }
    for (int32_t i = 0; i < view->grid->total; i++) {
        double x[PD_DIM];
        pd_grid_position(view->grid, i, x);
        s->T[i] = view->value(view, KEY_START, x, 0.0);
        s->S[i] = 2.0 * s->T[i];
    }
    *state = s;
    return PD_OK;
}

static pd_status cooling_max_run_step(pd_ctx *ctx, void *self, pd_step *step)
{
    const double origin[3] = {0.0, 0.0, 0.0};
    const pd_physics_view *view = ((cooling *)self)->view;
    (void)ctx;
    step->dt = fmin(step->dt, view->value(view, KEY_STEP, origin, 0.0));
    return PD_OK;
}

static pd_status cooling_attempt(pd_ctx *ctx, void *self, pd_step *step)
{
    const double origin[3] = {0.0, 0.0, 0.0};
    cooling *s = (cooling *)self;
    double factor = exp(-s->view->value(s->view, KEY_RATE, origin, 0.0) * (step->end - step->time));
    (void)ctx;
    for (int32_t i = 0; i < s->view->grid->total; i++) s->S[i] = 2.0 * (s->T[i] *= factor);
    s->time = step->end;
    return PD_OK;
}

static pd_status cooling_checkpoint(pd_ctx *ctx, void *self, pd_archive *archive)
{
    cooling *s = (cooling *)self;
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "cooling.time", &s->time, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "cooling.T", s->T, s->view->grid->total));
    for (int32_t i = 0; i < s->view->grid->total; i++) s->S[i] = 2.0 * s->T[i];
    return PD_OK;
}

static void cooling_set_process(void *self, pd_physics *p)
{
    p->name = "cooling";
    p->self = self;
    p->has_substeps = 1;
    p->max_run_step = cooling_max_run_step;
    p->attempt = cooling_attempt;
    p->checkpoint = cooling_checkpoint;
}

static const double *cooling_values(const void *self, int field)
{
    const cooling *s = (const cooling *)self;
    return field ? s->S : s->T;
}

static const pd_physics_type type = {{"cooling", "", "a body that cools", keys, KEYS},
                                     fields,
                                     2,
                                     cooling_build,
                                     cooling_free,
                                     cooling_set_process,
                                     cooling_values,
                                     16.0};

/* ---- scenes ---- */

#if PD_DIM == 1
#define ACROSS
#elif PD_DIM == 2
#define ACROSS ", 0 um .. 40 um"
#else
#define ACROSS ", 0 um .. 40 um, 0 um .. 40 um"
#endif
#define BOX "[grid] h = 20 um  m = 1  box = 0 um .. 400 um" ACROSS "\n"
#define METAL "[shape slab] box = 0 um .. 200 um" ACROSS "  kind = solid  material = mg4ag\n"
#define COOLING "[cooling] k = 0.5 /h\n"
#define LAW "[transport] D = 1e-9 m2/s\n[dissolve] rate = 10 um/h * T/(300 K)\n"
#define RUN "[run] until = 3 h\n[output] every = 1 h\n"

static pd_status read_scene(pd_ctx *ctx, const char *text, const char *const *overrides, int count, pd_setup *setup)
{
    pd_ctx_init(ctx);
    ctx->threads = 1;
    if (!CHECK_OK(ctx, pd_physics_type_register(ctx, &type))) return ctx->status;
    put("a.scene", text, strlen(text));
    return pd_scene_read(ctx, path_of("a.scene"), overrides, count, setup);
}

/* Depth [m] that the law has gone in, at most `step` [s] a step. */
static double depth(const char *step)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_desc desc;
    pd_run_result result;
    const char *overrides[] = {step};
    memset(&desc, 0, sizeof desc);
    desc.no_files = 1;
    if (!CHECK_OK(&ctx, read_scene(&ctx, BOX METAL COOLING LAW RUN, overrides, 1, &u))) return 0.0;
    CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &result));
    leave(&ctx, &u);
    return result.volume_loss * 200e-6;
}

/* The law reads T: depth v/k (1 - exp(-k t)), times q/(exp(q) - 1) with q = k times the step of the run, since the
 * metal steps with the T at the end of it. */
TEST(law_reads_the_field)
{
    double exact = 10e-6 / 0.5 * (1.0 - exp(-0.5 * 3.0)), q = 0.5 / 3600.0 * 200.0;
    CHECK_NEAR(depth("cooling.step=200 s"), exact * q / (exp(q) - 1.0), 1e-9 * exact);
    CHECK_NEAR(depth("cooling.step=100 s"), exact * 0.5 * q / (exp(0.5 * q) - 1.0), 1e-9 * exact);
}

/* The field stands in lists, probes, files and views, where its row says. */
TEST(field_is_listed)
{
    pd_ctx ctx;
    pd_field_info info;
    pd_field_view view;
    pd_memory_estimate with, without;
    static pd_sim sim;
    int found = 0, count = 0;
    if (!CHECK_OK(&ctx, read_scene(&ctx, BOX METAL COOLING LAW RUN, NULL, 0, &sim.setup))) return;
    for (; pd_field_info_get(&sim.setup, count, &info); count++) {
        if (strcmp(info.name, "T") == 0) {
            found++;
            CHECK_STR(info.label, "T [K]");
            CHECK_INT(info.place, PD_FIELD_IN_BOTH);
            CHECK_INT(info.components, 1);
        }
        if (strcmp(info.name, "S") == 0) {
            found++;
            CHECK_INT(info.place, PD_FIELD_IN_METAL);
        }
    }
    CHECK_INT(found, 2);
    pd_memory_estimate_compute(&sim.setup, &with);
    sim.setup.registered_count = 0;
    pd_memory_estimate_compute(&sim.setup, &without);
    sim.setup.registered_count = 1;
    CHECK_NEAR(with.total_bytes - without.total_bytes, 16.0 * with.nodes, 1e-6);
    if (!CHECK_OK(&ctx, pd_sim_start(&ctx, &sim))) return;
    while (sim.time < 3600.0)
        if (!CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, 3600.0))) return;
    CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, "T", &view));
    for (int64_t k = 0; k < view.component_stride; k++) CHECK_NEAR(view.data[k], 300.0 * exp(-0.5), 1e-9);
    CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, "S", &view));
    CHECK_NEAR(view.data[0], 600.0 * exp(-0.5), 1e-9);          /* metal */
    CHECK_NEAR(view.data[view.component_stride - 1], 0.0, 0.0); /* fluid */
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
}

/* Sides hold the first field, keys without a default are not there, values depend on place and time. */
TEST(values_and_sides)
{
    pd_ctx ctx;
    static pd_sim sim;
    double x[PD_DIM], value = 0.0;
    memset(x, 0, sizeof x);
    x[0] = 200e-6;
    if (!CHECK_OK(&ctx, read_scene(&ctx,
                                   BOX METAL "[cooling] k = 0.5 /h  start = 300 K + 1 K * x/(100 um)\n" LAW
                                             "[side x+] T = 310 K + 2 K * t/(1 h)\n" RUN,
                                   NULL, 0, &sim.setup)))
        return;
    if (!CHECK_OK(&ctx, pd_sim_start(&ctx, &sim))) return;
    const pd_physics_view *view = &sim.model.registered[0].view;
    CHECK_NEAR(view->value(view, KEY_START, x, 0.0), 302.0, 1e-12 * 302.0);
    CHECK_NEAR(view->value(view, KEY_MODE, x, 0.0), 0.0, 0.0);
    CHECK_NEAR(view->value(view, KEY_PARTS, x, 0.0), 2.0, 0.0);
    CHECK(!(view->value(view, KEY_NOTHING, x, 0.0) < 0.0) && !(view->value(view, KEY_NOTHING, x, 0.0) >= 0.0));
    CHECK_INT(view->prescribed(view, 0, x, 0.0, &value), 0);
    CHECK_INT(view->prescribed(view, 1, x, 1800.0, &value), 1);
    CHECK_NEAR(value, 311.0, 1e-12 * 311.0);
    CHECK(view->flow == NULL && view->grid == &sim.model.grid && view->bonds == &sim.model.bonds);
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
}

static int stop_at; /* steps after which a run stops */
static int stop(void *user)
{
    (void)user;
    return --stop_at == 0;
}

/* A run that was stopped goes on from its checkpoint to the same bits. */
TEST(checkpoint)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_desc desc;
    pd_run_result whole, parts;
    memset(&desc, 0, sizeof desc);
    desc.folder = path_of("whole");
    if (!CHECK_OK(&ctx, read_scene(&ctx, BOX METAL COOLING LAW RUN, NULL, 0, &u))) return;
    CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &whole));
    stop_at = 40;
    desc.folder = path_of("parts");
    desc.stop = stop;
    desc.checkpoints = 1;
    CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &parts));
    CHECK(parts.stopped && parts.time < whole.time);
    desc.resume = 1;
    CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &parts));
    CHECK(!parts.stopped);
    CHECK_NEAR(parts.volume_loss, whole.volume_loss, 0.0);
    CHECK_INT(parts.steps, whole.steps);
    leave(&ctx, &u);
}

/* The scene is refused with a message that holds `part`. */
static void refused_with(const char *text, const char *part)
{
    pd_ctx ctx;
    static pd_setup u;
    CHECK(read_scene(&ctx, text, NULL, 0, &u) < 0);
    if (!CHECK(strstr(ctx.message, part) != NULL)) NOTE("%s", ctx.message);
    CHECK_INT(ctx.in_use, 0);
}

TEST(bad_scenes)
{
    refused(BOX METAL COOLING LAW RUN, "found the section [cooling]");
    refused_with(BOX METAL "[cooling] start = 1 K\n" LAW RUN, "'k'");
    refused_with(BOX METAL "[cooling] k = 1 m\n" LAW RUN, "1/s");
    refused_with(BOX METAL "[cooling] k = 1 /h  speed = 1 m/s\n" LAW RUN,
                 "found the unknown key 'speed' in [cooling], expected one of k, start, step, nothing, mode, parts");
    refused_with(BOX METAL "[cooling] k = -1 /h\n" LAW RUN, "k: found -1 /h, expected a value of at least 0");
    refused_with(BOX METAL "[cooling] k = 1 /h  step = 1e7 s\n" LAW RUN, "step: found ");
    refused_with(BOX METAL "[cooling] k = 1 /h  step = 1 s * t/(1 s)\n" LAW RUN, "t");
    refused_with(BOX METAL "[cooling] k = 1 /h  mode = quick\n" LAW RUN, "expected one of slow, fast, idle");
    refused_with(BOX METAL "[cooling] k = 1 /h  parts = 9\n" LAW RUN, "found 9, expected a whole number from 1 to 8");
    refused_with(BOX METAL "[colling] k = 1 /h\n" LAW RUN, "cooling");
    refused_with(BOX METAL COOLING LAW RUN "[side x+] T = 1 m\n", "K");
    refused_with(BOX METAL LAW RUN, "T");
    refused_with(BOX METAL "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h\n" RUN "[side x+] T = 300 K\n", "T");
    refused_with(BOX METAL COOLING "[transport] D = 1e-9 m2/s\n[dissolve] rate = 10 um/h * T\n" RUN,
                 "found a quantity [m s-1 K], expected a speed [m/s]");
}

TEST(bad_types)
{
    static const pd_physics_field taken[] = {{"C", "K", PD_FIELD_IN_BOTH}};
    pd_ctx ctx;
    pd_setup u;
    pd_physics_type other = type;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pd_physics_type_register(&ctx, &type));
    CHECK_INT(pd_physics_type_register(&ctx, &type), PD_ERR_ARGUMENT);
    CHECK_STR(ctx.message, "physics: [cooling] is registered");
    other.section.name = "other";
    other.set_process = NULL;
    CHECK_INT(pd_physics_type_register(&ctx, &other), PD_ERR_ARGUMENT);
    other = type;
    other.section.name = "";
    CHECK_INT(pd_physics_type_register(&ctx, &other), PD_ERR_ARGUMENT);
    other.section.name = "other";
    other.fields = PD_PHYSICS_TYPE_FIELDS + 1;
    CHECK_INT(pd_physics_type_register(&ctx, &other), PD_ERR_ARGUMENT);
    other.fields = 1;
    other.field = taken;
    CHECK_OK(&ctx, pd_physics_type_register(&ctx, &other));
    put("a.scene", BOX METAL "[other] k = 1 /h\n[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h\n" RUN,
        strlen(BOX METAL "[other] k = 1 /h\n[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h\n" RUN));
    CHECK(pd_scene_read(&ctx, path_of("a.scene"), NULL, 0, &u) < 0);
    if (!CHECK(strstr(ctx.message, "found a field with the name 'C'") != NULL)) NOTE("%s", ctx.message);
    CHECK_INT(ctx.in_use, 0);
    for (int k = ctx.physics_count; k < PD_CTX_PHYSICS; k++) ctx.physics[ctx.physics_count++] = &other;
    pd_physics_type last = type;
    last.section.name = "last";
    CHECK_INT(pd_physics_type_register(&ctx, &last), PD_ERR_SIZE);
}

/* A builder that fails: its message, its line, and nothing left. */
TEST(build_that_fails)
{
    pd_ctx ctx;
    static pd_sim sim;
    if (!CHECK_OK(&ctx, read_scene(&ctx, BOX METAL COOLING LAW RUN, NULL, 0, &sim.setup))) return;
    fails = 1;
    CHECK_INT(pd_sim_start(&ctx, &sim), PD_ERR_STATE);
    fails = 0;
    CHECK(strstr(ctx.message, "as it was asked to") != NULL);
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
}

TEST_MAIN(ENTRY(law_reads_the_field) ENTRY(field_is_listed) ENTRY(values_and_sides) ENTRY(checkpoint) ENTRY(bad_scenes)
              ENTRY(bad_types) ENTRY(build_that_fails))
