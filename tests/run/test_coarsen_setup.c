/* coarser, estimate, accuracy: what a coarser lattice can hold, what its planes stand for, which spacing an estimate
 * asks for, and which settings follow from a wanted accuracy. Whole runs: estimate.sh.
 * dims: 2 */
#include "run/tolerance_presets.h"
#include "run/richardson.h"
#include "scene/scene.h"
#include "test.h"
#include <stdlib.h>

/* 40 x 40 cells of 1 um, walls all around; shapes are added by the tests. */
static int start(pd_ctx *ctx, pd_setup *u)
{
    pd_ctx_init(ctx);
    ctx->threads = 1;
    if (!CHECK_OK(ctx, pd_setup_init(ctx, u))) return 0;
    for (int d = 0; d < PD_DIM; d++) {
        u->h[d] = 1e-6;
        u->hi[d] = 40e-6;
    }
    return 1;
}

static int add(pd_ctx *ctx, pd_setup *u, pd_shape_type type, double ax, double ay, double bx, double by)
{
    pd_shape s;
    int index = -1;
    memset(&s, 0, sizeof s);
    s.type = type;
    s.a[0] = ax * 1e-6;
    s.a[1] = ay * 1e-6;
    s.b[0] = bx * 1e-6;
    s.b[1] = by * 1e-6;
    CHECK_OK(ctx, pd_setup_add_shape(ctx, u, &s, &index));
    return index;
}

/* A wall of this thickness [um] across x around the place [um]. */
static int slab(pd_ctx *ctx, pd_setup *u, double place, double thickness)
{
    int index = add(ctx, u, PD_SHAPE_CYLINDER, place, 0.0, 0.0, 0.0);
    u->shape[index].axis = 1;
    u->shape[index].radius = 0.5e-6 * thickness;
    return index;
}

/* The coarser lattice is refused with a message that holds `part`, or built when part is NULL. */
static void coarser_of(pd_ctx *ctx, pd_setup *u, int factor, const char *part)
{
    static pd_coarsened_setup coarser;
    size_t before = ctx->in_use;
    pd_status status = pdi_coarsen_setup_build(ctx, u, factor, &coarser);
    if (!part) CHECK_OK(ctx, status);
    else if (!CHECK(status == PD_ERR_GEOMETRY && strstr(ctx->message, part))) NOTE("found: %s", ctx->message);
    CHECK_INT(ctx->in_use, before);
}

/* The corners of a square on its corner are one node wide, and yet a coarser lattice holds it. */
TEST(corners_are_held)
{
    static const double normal[4][2] = {{1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
    pd_ctx ctx;
    pd_setup u;
    pd_shape all;
    if (!start(&ctx, &u)) return;
    memset(&all, 0, sizeof all);
    all.type = PD_SHAPE_INTERSECT;
    for (int k = 0; k < 4; k++)
        all.child[all.child_count++] =
            add(&ctx, &u, PD_SHAPE_HALF_SPACE, 20.0 + 12.0 * normal[k][0], 20.0, normal[k][0], normal[k][1]);
    CHECK_OK(&ctx, pd_setup_add_shape(&ctx, &u, &all, &u.solid));
    coarser_of(&ctx, &u, 2, NULL);
    coarser_of(&ctx, &u, 4, NULL);
    pd_setup_free(&ctx, &u);
    CHECK_INT(ctx.in_use, 0);
}

TEST(thin_parts_are_refused)
{
    pd_ctx ctx;
    pd_setup u;
    if (!start(&ctx, &u)) return;
    u.wall = slab(&ctx, &u, 20.5, 1.2);
    coarser_of(&ctx, &u, 2, "the wall near x = 20.5 um is thinner");
    u.shape[u.wall].radius = 1.6e-6; /* three nodes: wide enough for 2 h, not for 4 h */
    coarser_of(&ctx, &u, 2, NULL);
    coarser_of(&ctx, &u, 4, "is thinner");
    /* a gap of one node between two thick walls, away from where their shapes end */
    u.shapes = 0;
    u.wall = -1;
    CHECK_OK(&ctx, pd_setup_add_union(&ctx, &u, slab(&ctx, &u, 14.5, 11.8), &u.wall));
    CHECK_OK(&ctx, pd_setup_add_union(&ctx, &u, slab(&ctx, &u, 26.5, 10.4), &u.wall));
    coarser_of(&ctx, &u, 2, "the fluid near x = 20.5 um is thinner");
    pd_setup_free(&ctx, &u);
}

TEST(faces_lie_on_planes)
{
    pd_ctx ctx;
    pd_setup u;
    if (!start(&ctx, &u)) return;
    u.solid = add(&ctx, &u, PD_SHAPE_BOX, 8.0, 8.0, 30.0, 20.0);
    coarser_of(&ctx, &u, 2, NULL);
    coarser_of(&ctx, &u, 4, "the face of a shape at x = 30 um is cell 30");
    u.shape[u.solid].b[0] = 31.3e-6; /* between nodes on every lattice */
    coarser_of(&ctx, &u, 4, NULL);
    u.hi[1] = 41e-6;
    coarser_of(&ctx, &u, 2, "the box has 41 cells along y");
    pd_setup_free(&ctx, &u);
}

/* The physics stays, lines go, and planes between two of the coarser lattice are shared out to both. */
TEST(planes_and_rates)
{
    static pd_coarsened_setup coarser;
    pd_ctx ctx;
    pd_setup u;
    if (!start(&ctx, &u)) return;
    u.metal[0].rate_scale = 1e-6;
    u.max_node_fraction = 0.07;
    u.monitors = 3;
    u.monitor[0].kind = PD_MONITOR_LINE;
    u.monitor[1].kind = PD_MONITOR_PLANE;
    u.monitor[1].axis = 1;
    u.monitor[1].index = 7;
    u.monitor[2].kind = PD_MONITOR_TOTAL;
    if (CHECK_OK(&ctx, pdi_coarsen_setup_build(&ctx, &u, 4, &coarser))) {
        CHECK_REL(coarser.setup.h[0], 4e-6, 1e-15);
        CHECK_NEAR(coarser.setup.metal[0].rate_scale, 1e-6, 0.0);
        CHECK_NEAR(coarser.setup.max_node_fraction, 0.07, 0.0);
        CHECK_INT(coarser.setup.monitors, 3);
        CHECK_INT(coarser.setup.monitor[0].index, 1);
        CHECK_INT(coarser.setup.monitor[1].index, 2);
        CHECK_NEAR(coarser.monitor_weight[0], 0.25, 0.0);
        CHECK_NEAR(coarser.monitor_weight[1], 0.75, 0.0);
        CHECK_NEAR(coarser.monitor_weight[2], 1.0, 0.0);
    }
    u.monitor[1].index = 1;
    coarser_of(&ctx, &u, 2, "too near to the end of the box");
    pd_setup_free(&ctx, &u);
}

/* An error of order 2 that is four times too large asks for half the spacing; one that is 2.1 times too large for the
 * next finer lattice that divides a box of 40 x 30 cells into even numbers. */
TEST(wanted_spacing)
{
    pd_ctx ctx;
    pd_setup u;
    pd_richardson e;
    pd_richardson_output item[2];
    double h[PD_DIM];
    if (!start(&ctx, &u)) return;
    u.hi[1] = 30e-6;
    memset(&e, 0, sizeof e);
    memset(item, 0, sizeof item);
    e.setup = &u;
    e.list = item;
    e.count = 2;
    item[0].order = 2.0;
    item[0].error = 0.04;
    item[1].order = 1.0;
    item[1].error = 5.0;
    item[1].is_minor = 1;
    pd_richardson_suggest_spacing(&e, 0.01, h);
    CHECK_REL(h[0], 0.5e-6, 1e-12);
    CHECK_REL(h[1], 0.5e-6, 1e-12);
    pd_richardson_suggest_spacing(&e, 0.04 / 2.1, h);
    CHECK_REL(40e-6 / h[0], 64.0, 1e-12); /* 10 common parts, times sqrt(2.1), up to an even number: 16 */
    CHECK_REL(30e-6 / h[1], 48.0, 1e-12);
    pd_richardson_suggest_spacing(&e, 0.05, h);
    CHECK_REL(h[0], 1e-6, 1e-12);
    pd_setup_free(&ctx, &u);
}

/* Diffusion into a slab, with figures of the second order, and one that no lattice changes. */
static const char slab_text[] =
    "[grid] h = 1 um  threads = 1  box = 0 um .. 32 um, 0 um .. 8 um\n[side x-] C = 1 mol/m3\n[side x+] C = 0 mol/m3\n"
    "[side y-] flow = mirror\n[side y+] flow = mirror\n[transport] D = 1e-9 m2/s\n[run] until = 0.05 s\n"
    "[probe near] at = 4 um, 4 um  fields = C\n[probe far] at = 20 um, 4 um  fields = C\n[plane p] at = x 8 um\n"
    "[total sum]\n";

static int run_figures(pd_ctx *ctx, const char *h, pd_setup *u, pd_scalar_outputs *f)
{
    pd_run_desc desc;
    pd_run_result result;
    memset(&desc, 0, sizeof desc);
    memset(f, 0, sizeof *f);
    desc.no_files = 1;
    desc.figures = f;
    if (!CHECK_OK(ctx, pd_scene_parse(ctx, "a.scene", slab_text, &h, 1, u))) return 0;
    return CHECK_OK(ctx, pd_run(ctx, u, &desc, &result));
}

/* An estimate holds the figures of runs at 2 h and 4 h, and orders and errors are those of the extrapolation. */
TEST(estimates)
{
    static const char *const h[] = {"grid.h=1 um", "grid.h=2 um", "grid.h=4 um"};
    pd_ctx ctx;
    pd_setup u[3];
    pd_scalar_outputs f[3];
    pd_richardson e;
    pd_run_desc desc;
    pd_ctx_init(&ctx);
    memset(&desc, 0, sizeof desc);
    for (int k = 0; k < 3; k++)
        if (!run_figures(&ctx, h[k], &u[k], &f[k])) return;
    if (CHECK_OK(&ctx, pd_richardson_run(&ctx, &u[0], &desc, &f[0], &e))) {
        int worst = -1, observed = 0;
        CHECK_INT(e.count, f[0].count);
        CHECK_INT(e.coarser_runs, 2);
        for (int k = 0; k < e.count; k++) {
            const pd_richardson_output *a = &e.list[k];
            double near_step = f[1].list[k].value - f[0].list[k].value;
            double far_step = f[2].list[k].value - f[1].list[k].value;
            double order = log2(far_step / near_step), most = 0.0;
            int believed = order >= 0.5 && order <= 3.0 && fabs(near_step) > 1e-9 * fabs(a->figure.value);
            CHECK_STR(a->figure.key, f[0].list[k].key);
            CHECK_REL(a->coarser[0], f[1].list[k].value, 1e-12);
            CHECK_REL(a->coarser[1], f[2].list[k].value, 1e-12);
            CHECK_INT(a->is_formal_order, !believed);
            observed += believed;
            if (!believed) order = 2.0;
            if (!believed) near_step = fmax(fabs(near_step), fabs(far_step) / 4.0);
            CHECK_REL(a->order, order, 1e-9);
            CHECK_REL(a->error, fabs(near_step) / (exp2(order) - 1.0) / fabs(a->figure.value), 1e-9);
            for (int j = 0; j < e.count; j++)
                if (f[0].list[j].key[0] == a->figure.key[0] && strcmp(f[0].list[j].unit, a->figure.unit) == 0)
                    most = fmax(most, fabs(f[0].list[j].value));
            CHECK_INT(a->is_minor, fabs(a->figure.value) < 0.1 * most);
            if (!a->is_minor && (worst < 0 || a->error > e.list[worst].error)) worst = k;
        }
        CHECK(observed >= 2);
        CHECK_INT(e.worst_output, worst);
        pd_richardson_free(&ctx, &e);
    }
    for (int k = 0; k < 3; k++) {
        pd_scalar_outputs_free(&ctx, &f[k]);
        pd_setup_free(&ctx, &u[k]);
    }
    CHECK_INT(ctx.in_use, 0);
}

typedef struct stop_clock {
    int at, calls;
} stop_clock;

static int stop_once(void *user)
{
    stop_clock *stop = (stop_clock *)user;
    return ++stop->calls == stop->at;
}

/* A wish to stop, whenever it comes, ends the estimate; it is no failure of the coarser run. */
TEST(stopped_estimates)
{
    pd_ctx ctx;
    pd_setup u;
    pd_scalar_outputs f;
    pd_richardson e;
    pd_run_desc desc;
    stop_clock stop = {1, 0};
    int ended = 0;
    pd_ctx_init(&ctx);
    memset(&desc, 0, sizeof desc);
    desc.stop = stop_once;
    desc.stop_user = &stop;
    if (!run_figures(&ctx, "grid.h=1 um", &u, &f)) return;
    for (; !ended && stop.at < 2000; stop.at++) {
        stop.calls = 0;
        pd_status status = pd_richardson_run(&ctx, &u, &desc, &f, &e);
        ended = stop.calls < stop.at;
        CHECK_INT((int)status, ended ? (int)PD_OK : (int)PD_CANCELLED);
        if (!ended) CHECK_STR(ctx.message, "estimate: interrupted");
        pd_richardson_free(&ctx, &e);
    }
    CHECK_LE(10, stop.at);
    NOTE("%d times", stop.at - 2);
    pd_scalar_outputs_free(&ctx, &f);
    pd_setup_free(&ctx, &u);
    CHECK_INT(ctx.in_use, 0);
}

/* What the scene sets stays; what it leaves open follows the wanted accuracy. */
TEST(picked_settings)
{
    pd_ctx ctx;
    pd_setup u;
    char text[640];
    if (!start(&ctx, &u)) return;
    u.has_flow = u.has_transport = u.has_dissolve = 1;
    u.steady_tolerance = 1e-6;
    u.max_node_fraction = 0.1;
    u.settings_given = 1u << PD_SOLVER_SETTING_STEADY;
    if (CHECK_OK(&ctx, pd_tolerance_presets_apply(&ctx, 0.01, &u, text, sizeof text))) {
        CHECK_STR(text, "accuracy 1 %: picked run.max_dissolved_fraction = 0.025, limiter = 0.001; the scene sets "
                        "flow.steady_tolerance = 1e-06");
        CHECK_NEAR(u.steady_tolerance, 1e-6, 0.0);
        CHECK_REL(u.max_node_fraction, 0.025, 1e-12);
    }
    u.settings_given = 1u << PD_SOLVER_SETTING_RTOL;
    if (CHECK_OK(&ctx, pd_tolerance_presets_apply(&ctx, 0.001, &u, text, sizeof text))) {
        CHECK_REL(u.steady_tolerance, 1e-4, 1e-12);
        CHECK_REL(u.max_node_fraction, 0.025, 1e-12);
        CHECK(strstr(text, "the scene sets run.max_dissolved_fraction (of rtol) = 0.025") != NULL);
    }
    /* a flow in time, and transport that metal does not drive */
    u.has_dissolve = 0;
    u.flow_time = PD_FLOW_IMPLICIT;
    u.settings_given = 0;
    if (CHECK_OK(&ctx, pd_tolerance_presets_apply(&ctx, 0.01, &u, text, sizeof text))) {
        CHECK_STR(text, "accuracy 1 %: picked flow.rtol = 0.005, run.rtol = 0.005, limiter = 0.001");
        CHECK_REL(u.flow_rtol, 0.005, 1e-12);
        CHECK_REL(u.rtol, 0.005, 1e-12);
        CHECK_REL(u.limiter_tolerance, 0.001, 1e-12);
    }
    u.settings_given = 1u << PD_SOLVER_SETTING_FLOW_RTOL;
    u.steady_transport = 1;
    u.advection = PD_ADVECTION_UPWIND;
    if (CHECK_OK(&ctx, pd_tolerance_presets_apply(&ctx, 0.5, &u, text, sizeof text)))
        CHECK_STR(text, "accuracy 50 %: picked nothing; the scene sets flow.rtol = 0.005");
    CHECK(pd_tolerance_presets_apply(&ctx, 0.0, &u, text, sizeof text) == PD_ERR_ARGUMENT);
    CHECK(pd_tolerance_presets_apply(&ctx, 0.6, &u, text, sizeof text) == PD_ERR_ARGUMENT);
    CHECK(pd_tolerance_presets_apply(&ctx, (double)NAN, &u, text, sizeof text) == PD_ERR_ARGUMENT);
    pd_setup_free(&ctx, &u);
}

TEST_MAIN(ENTRY(corners_are_held) ENTRY(thin_parts_are_refused) ENTRY(faces_lie_on_planes) ENTRY(planes_and_rates)
              ENTRY(estimates) ENTRY(stopped_estimates) ENTRY(wanted_spacing) ENTRY(picked_settings))
