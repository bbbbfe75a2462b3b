/* process, couple: the loop of limits, attempts, retries and times, lists of processes and their ledgers, and physics
 * that move together: metal in a flow in time, a steady flow that follows a clock, a gas.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "fault.h"
#include "physics/model.h"
#include "checkpoint_model.h"
#include "scene/scene.h"
#include "scene_file.h"

/* ---- processes that only count ---- */

/* An amount that grows by 1 a second. It wants steps of `step` and takes those of `good` at most; 0: any. */
typedef struct toy {
    double step, good;
    double time, amount, passed;
    int limits, attempts, rejects, accepts, finishes, starts, asked, changes;
    int64_t steps;
    int turns;           /* it reports a node that has turned */
    int32_t node;
    double shortest;     /* attempt so far */
    double ends;         /* [s] of its own after which those behind it have to follow; 0: never */
    double seen;         /* [s] since then */
    const struct toy *ahead; /* of the list; checked: it is not more than its `ends` ahead */
} toy;

static pd_status toy_start(pd_ctx *ctx, void *self, double t)
{
    (void)ctx;
    ((toy *)self)->time = t;
    ((toy *)self)->starts++;
    return PD_OK;
}

static pd_status toy_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    toy *y = (toy *)self;
    (void)ctx;
    y->limits++;
    CHECK(s->time == y->time);
    if (y->ahead) CHECK_LE(y->ahead->time - y->time, y->ahead->ends);
    if (y->step > 0.0) s->dt = pdi_physics_equal_steps(s->latest_end - s->time, y->step);
    return PD_OK;
}

static pd_status toy_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    toy *y = (toy *)self;
    y->attempts++;
    if (s->solve_at) {
        pd_status status = s->solve_at(ctx, s->solve_at_user, s->end);
        if (status < 0) return status;
    }
    y->shortest = y->shortest > 0.0 ? fmin(y->shortest, s->dt) : s->dt;
    return y->good > 0.0 && s->dt > y->good ? PD_RETRY : PD_OK;
}

static pd_status toy_reject(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    ((toy *)self)->rejects++;
    s->dt *= 0.5;
    return PD_OK;
}

static pd_status toy_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    toy *y = (toy *)self;
    (void)ctx;
    y->accepts++;
    y->steps++;
    y->time = s->end;
    y->amount += s->dt;
    y->passed += s->dt;
    y->seen += s->dt;
    if (y->ends > 0.0 && y->seen >= y->ends) {
        s->ends_substeps = 1;
        y->seen = 0.0;
    }
    s->converted_nodes = &y->node;
    s->converted_count = y->turns;
    return PD_OK;
}

static pd_status toy_finish(pd_ctx *ctx, void *self, double t)
{
    toy *y = (toy *)self;
    (void)ctx;
    y->finishes++;
    if (y->accepts) CHECK(t == y->time);
    return PD_OK;
}

static pd_status toy_at(pd_ctx *ctx, void *self, double t)
{
    (void)ctx;
    ((toy *)self)->asked++;
    ((toy *)self)->time = t;
    return PD_OK;
}

static pd_status toy_changed(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count)
{
    (void)ctx;
    CHECK(count == 1 && turned[0] == 7);
    ((toy *)self)->changes++;
    return PD_OK;
}

static void toy_balance(pd_ctx *ctx, void *self, int k, pd_amounts *a)
{
    const toy *y = (const toy *)self;
    (void)ctx;
    a->dissolved += k ? 2.0 * y->amount : y->amount;
    a->in += k ? 2.0 * y->passed : y->passed;
}

static const pd_element toy_elements[2] = {{"apples", "kg"}, {"pears", "kg"}};

static pd_physics toy_process(const char *name, toy *y)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = name;
    p.self = y;
    p.time = &y->time;
    p.steps = &y->steps;
    p.start = toy_start;
    p.limit = toy_limit;
    p.attempt = toy_attempt;
    p.accept = toy_accept;
    p.reject = toy_reject;
    p.finish = toy_finish;
    p.nodes_converted = toy_changed;
    p.element = toy_elements;
    p.elements = 1;
    p.add_amounts = toy_balance;
    return p;
}

TEST(one_process)
{
    pd_ctx ctx;
    toy y;
    pd_ctx_init(&ctx);
    memset(&y, 0, sizeof y);
    pd_physics p = toy_process("toy", &y);
    y.step = 0.3;
    CHECK_OK(&ctx, pd_physics_run(&ctx, p, 1.0));
    CHECK(y.time == 1.0);
    CHECK_NEAR(y.amount, 1.0, 1e-15);
    CHECK_INT(y.steps, 4);
    CHECK_INT(y.limits, 4);
    CHECK_INT(y.finishes, 1);
    /* steps that are refused become shorter until they are not, and the last one ends on the end all the same */
    y.good = 0.1;
    CHECK_OK(&ctx, pd_physics_run(&ctx, p, 2.0));
    CHECK(y.time == 2.0);
    CHECK(y.rejects > y.accepts - 4 && y.accepts - 4 >= 10);
    CHECK_INT(y.attempts, y.accepts + y.rejects);
    CHECK_NEAR(y.amount, 2.0, 1e-14);
    /* nothing to do is done */
    int before = y.attempts;
    CHECK_OK(&ctx, pd_physics_run(&ctx, p, 2.0));
    CHECK_INT(y.attempts, before);
    /* steps that time cannot count */
    y.good = 1e-30;
    CHECK_INT(pd_physics_run(&ctx, p, 3.0), PD_ERR_STATE);
    CHECK(strstr(ctx.message, "toy: steps of ") != NULL && strstr(ctx.message, "do not lead on from t = 2 s") != NULL);
    CHECK(y.time == 2.0);
    CHECK_LE(y.shortest, 1e-14);
    CHECK_INT(pd_physics_run(&ctx, p, 1.0), PD_ERR_ARGUMENT);
    /* steps that time counts, but no end of a run: 1e11 of them */
    y.good = 0.0;
    y.step = 1e-11;
    CHECK_INT(pd_physics_run(&ctx, p, 3.0), PD_ERR_STATE);
    CHECK(strstr(ctx.message, "toy: the last 1000 steps led on by ") != NULL);
    CHECK_LE(y.time, 2.0 + 1001e-11);
    CHECK_OK(&ctx, pd_physics_run(&ctx, p, y.time + 3e-8)); /* 3000 of them are few */
    p.time = NULL;
    CHECK_INT(pd_physics_run(&ctx, p, 3.0), PD_ERR_ARGUMENT);
}

/* A box of some fluid nodes, for the list. */
typedef struct box {
    pd_stencil stencil;
    pd_grid grid;
    pd_time_loop couple;
} box;

static int box_build(pd_ctx *ctx, double max_step, box *b)
{
    pd_stencil_desc family;
    pd_grid_desc desc;
    pd_time_loop_desc run;
    memset(&family, 0, sizeof family);
    memset(&desc, 0, sizeof desc);
    memset(&run, 0, sizeof run);
    memset(b, 0, sizeof *b);
    family.m = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        family.h[d] = 1.0;
        desc.hi[d] = 4.0;
    }
    run.max_step = max_step;
    return CHECK_OK(ctx, pd_stencil_build(ctx, &family, &b->stencil)) &&
           CHECK_OK(ctx, pd_grid_build(ctx, &b->stencil, &desc, &b->grid)) &&
           CHECK_OK(ctx, pd_time_loop_build(ctx, &run, &b->grid, NULL, &b->couple));
}

static void box_free(pd_ctx *ctx, box *b)
{
    pd_grid_free(ctx, &b->grid);
    pd_stencil_free(ctx, &b->stencil);
}

/* The first process that moves decides on the step; those behind it follow, quasi-steady ones at each attempt. */
TEST(a_list)
{
    pd_ctx ctx;
    box b;
    toy flow, lead, follower;
    pd_ctx_init(&ctx);
    if (!box_build(&ctx, 0.0, &b)) return;
    memset(&flow, 0, sizeof flow);
    memset(&lead, 0, sizeof lead);
    memset(&follower, 0, sizeof follower);
    pd_physics p = toy_process("flow", &flow);
    p.attempt = NULL;
    p.elements = 0;
    p.solve_at = toy_at;
    CHECK_OK(&ctx, pd_time_loop_add_process(&ctx, &b.couple, p));
    CHECK_OK(&ctx, pd_time_loop_add_process(&ctx, &b.couple, toy_process("lead", &lead)));
    p = toy_process("follower", &follower);
    p.element = toy_elements + 1;
    p.has_substeps = 1;
    CHECK_OK(&ctx, pd_time_loop_add_process(&ctx, &b.couple, p));
    CHECK_INT(b.couple.elements, 2);
    lead.step = 0.5;
    lead.good = 0.3;
    follower.step = 0.1;
    lead.turns = 1;
    lead.node = 7;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &b.couple, 1.0, 0.0, NULL, NULL));
    CHECK_INT(lead.starts + follower.starts + flow.starts, 3);
    CHECK(b.couple.time == 1.0 && lead.time == 1.0 && follower.time == 1.0 && flow.time == 1.0);
    CHECK_INT(b.couple.steps, lead.accepts);
    CHECK_INT(lead.attempts, lead.accepts + lead.rejects);
    CHECK(lead.rejects > 0);
    CHECK_INT(lead.finishes, b.couple.steps);
    CHECK_INT(follower.finishes, b.couple.steps);
    CHECK(follower.accepts > lead.accepts + 4);
    CHECK_INT(flow.asked, lead.attempts + follower.attempts);
    CHECK_INT(flow.finishes, b.couple.steps);
    CHECK_INT(flow.changes, lead.accepts);
    CHECK_INT(follower.changes, lead.accepts);
    for (int e = 0; e < 2; e++) {
        CHECK_NEAR(b.couple.ledger[e].in, 1.0, 1e-14);
        CHECK_LE(pd_time_loop_imbalance(&b.couple), 1e-15);
    }
    CHECK(strcmp(b.couple.element[0].name, "apples") == 0 && strcmp(b.couple.element[1].name, "pears") == 0);
    /* an element that is lost is called by its name */
    follower.passed += 0.25;
    CHECK_INT(pd_time_loop_step(&ctx, &b.couple, 2.0), PD_ERR_BALANCE);
    CHECK(strstr(ctx.message, "kg of pears misses the start 0 kg by -0.25") != NULL);
    box_free(&ctx, &b);
}

/* A process in the middle of the list that lets those behind it follow before it moves on: each of them meets each time
 * at which one before it waits, all end on the end, and the ledgers are whole. */
TEST(those_behind_follow)
{
    pd_ctx ctx;
    box b;
    toy y[4];
    static const char *const name[4] = {"lead", "second", "third", "fourth"};
    static const double step[4] = {1.0, 0.0625, 0.015625, 0.0};
    pd_ctx_init(&ctx);
    if (!box_build(&ctx, 0.0, &b)) return;
    memset(y, 0, sizeof y);
    for (int n = 0; n < 4; n++) {
        pd_physics p = toy_process(name[n], &y[n]);
        p.has_substeps = n > 0;
        CHECK_OK(&ctx, pd_time_loop_add_process(&ctx, &b.couple, p));
        y[n].step = step[n];
        y[n].ahead = n ? &y[n - 1] : NULL;
    }
    y[0].ends = 1.0;
    y[1].ends = 0.25;
    y[2].ends = 0.125;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &b.couple, 4.0, 0.0, NULL, NULL));
    for (int n = 0; n < 4; n++) {
        CHECK(y[n].time == 4.0);
        CHECK_NEAR(y[n].amount, 4.0, 1e-13);
    }
    CHECK_INT(b.couple.steps, 4);
    CHECK_INT(y[1].finishes, 16);
    CHECK_INT(y[2].finishes, 32);
    CHECK_INT(y[3].accepts, 32);
    CHECK_LE(pd_time_loop_imbalance(&b.couple), 1e-14);
    box_free(&ctx, &b);
}

/* Two processes of one element have one ledger, and one of two elements enters two. */
TEST(elements)
{
    pd_ctx ctx;
    box b;
    toy one, two;
    pd_ctx_init(&ctx);
    if (!box_build(&ctx, 0.25, &b)) return;
    memset(&one, 0, sizeof one);
    memset(&two, 0, sizeof two);
    pd_physics p = toy_process("one", &one);
    p.max_run_step = pdi_physics_limit_max_step;
    p.has_substeps = 1;
    CHECK_OK(&ctx, pd_time_loop_add_process(&ctx, &b.couple, p));
    p = toy_process("two", &two);
    p.elements = 2;
    CHECK_OK(&ctx, pd_time_loop_add_process(&ctx, &b.couple, p));
    one.amount = 3.0;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &b.couple, 1.0, 0.0, NULL, NULL));
    CHECK_INT(b.couple.elements, 2);
    CHECK_INT(b.couple.steps, 4);
    CHECK_NEAR(b.couple.ledger[0].start, 3.0, 0.0);
    CHECK_NEAR(b.couple.ledger[0].dissolved, 5.0, 1e-14);
    CHECK_NEAR(b.couple.ledger[1].dissolved, 2.0, 1e-14);
    static pd_element many[PD_TIME_LOOP_MAX_ELEMENTS];
    static char names[PD_TIME_LOOP_MAX_ELEMENTS][4];
    for (int k = 0; k < PD_TIME_LOOP_MAX_ELEMENTS; k++) {
        snprintf(names[k], sizeof names[k], "%d", k);
        many[k].name = names[k];
        many[k].unit = "kg";
    }
    p.element = many;
    p.elements = PD_TIME_LOOP_MAX_ELEMENTS;
    CHECK_INT(pd_time_loop_add_process(&ctx, &b.couple, p), PD_ERR_SIZE);
    box_free(&ctx, &b);
}

/* ---- physics that move together ---- */

static int grow(pd_ctx *ctx, pd_setup *u, pd_model *m, const char *text)
{
    return CHECK_OK(ctx, load(ctx, text, NULL, 0, u)) && CHECK_OK(ctx, pd_model_build(ctx, u, m));
}

static void drop(pd_ctx *ctx, pd_setup *u, pd_model *m)
{
    pd_model_free(ctx, m);
    leave(ctx, u);
}

/* After some time, in a file and in another model: both have the same bits at the end. */
static void goes_on(const char *text, const char *what)
{
    pd_ctx ctx, other;
    pd_setup u, v;
    pd_model a, b;
    if (!grow(&ctx, &u, &a, text)) return;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &a.time_loop, 0.5 * u.end_time, 0.5 * u.end_time, NULL, NULL));
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("half"), &a));
    if (!grow(&other, &v, &b, text)) return;
    CHECK_OK(&other, checkpoint_load(&other, path_of("half"), &b));
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &a.time_loop, u.end_time, 0.5 * u.end_time, NULL, NULL));
    CHECK_OK(&other, pd_time_loop_run(&other, &b.time_loop, u.end_time, 0.5 * u.end_time, NULL, NULL));
    int64_t total = a.grid.total;
    const double *x = pd_model_velocity(&a), *y = pd_model_velocity(&b);
    int same = memcmp(a.grid.kind, b.grid.kind, (size_t)total) == 0 &&
               memcmp(a.time_loop.ledger, b.time_loop.ledger, sizeof a.time_loop.ledger) == 0;
    if (x) same = same && memcmp(x, y, (size_t)(PD_DIM * total) * sizeof *x) == 0;
    if (a.transport.c) same = same && memcmp(a.transport.c, b.transport.c, (size_t)total * sizeof *x) == 0;
    if (!CHECK(same)) NOTE("%s: other bits after a checkpoint", what);
    CHECK_INT(a.time_loop.steps, b.time_loop.steps);
    drop(&other, &v, &b);
    drop(&ctx, &u, &a);
}

#if PD_DIM == 1
#define GAS \
    "[grid] h = 10 mm  m = 3  box = 0 .. 1 m\n[side x-] flow = inlet\n[side x+] flow = outlet\n" \
    "[gas] rho = if(x < 0.5 m, 1 kg/m3, 0.125 kg/m3)  p = if(x < 0.5 m, 1 Pa, 0.1 Pa)  vx = 0.4 m/s\n" \
    "[run] until = 1 s\n"

/* Waves leave and gas enters: mass and energy are known from what passes the sides. */
TEST(gas_through_sides)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (!grow(&ctx, &u, &m, GAS)) return;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &m.time_loop, u.end_time, 0.25, NULL, NULL));
    CHECK_INT(m.time_loop.elements, 2);
    const pd_mass_balance *mass = &m.time_loop.ledger[0], *energy = &m.time_loop.ledger[1];
    CHECK_NEAR(mass->start, 0.5625, 1e-12);
    CHECK_NEAR(energy->start, 0.5 * (2.5 + 0.25) + 0.5 * 0.16 * 0.5625, 1e-12);
    CHECK(mass->out > 0.3 && mass->in > 0.1 && energy->out > 0.3 && energy->in > 0.1);
    CHECK_LE(pd_time_loop_imbalance(&m.time_loop), 1e-13);
    drop(&ctx, &u, &m);
    goes_on(GAS, "gas");
}

/* A stream that is the same everywhere passes without a change, and what passes is rho v t and (rho E + p) v t. */
TEST(gas_that_streams)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (!grow(&ctx, &u, &m,
              "[grid] h = 20 mm  m = 3  box = 0 .. 1 m\n[side x-] flow = inlet\n[side x+] flow = outlet\n"
              "[gas] rho = 2 kg/m3  p = 3 Pa  vx = 0.7 m/s  gamma = 1.5\n[run] until = 1.3 s\n"))
        return;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &m.time_loop, u.end_time, 0.0, NULL, NULL));
    double energy = 3.0 / 0.5 + 0.5 * 2.0 * 0.49;
    CHECK_REL(m.time_loop.ledger[0].out, 2.0 * 0.7 * 1.3, 1e-12);
    CHECK_REL(m.time_loop.ledger[0].in, 2.0 * 0.7 * 1.3, 1e-12);
    CHECK_REL(m.time_loop.ledger[1].out, (energy + 3.0) * 0.7 * 1.3, 1e-12);
    CHECK_REL(m.time_loop.ledger[1].in, (energy + 3.0) * 0.7 * 1.3, 1e-12);
    drop(&ctx, &u, &m);
}
#else
#define PIN(motion, rate, until) \
    "[grid] h = 10 um  m = 2  box = -100 um .. 200 um, -60 um .. 60 um\n" \
    "[shape pin] box = 0 .. 40 um, -20 um .. 20 um  kind = solid  material = mg4ag\n" \
    "[side x-] flow = inlet  profile = parabola  mean = 0.01 m/s  C = 0\n[side x+] flow = outlet  p = 0\n" \
    "[side y-] flow = noslip\n[side y+] flow = noslip\n[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s" motion \
    "\n[transport] D = 1e-9 m2/s\n[dissolve] rate = " rate "\n[run] until = " until "\n"

#define RATE "if(t < 0.08 s, 100 um/s, 0 um/s)"
#define UNTIL "0.1 s"

/* Metal that dissolves fast, and then rests, in a flow that begins at rest: the flow in time follows its surface, and
 * is the steady one around what is left in the end. */
TEST(metal_in_a_flow_in_time)
{
    static const char *const texts[] = {PIN("  time = implicit  rtol = 1e-2", RATE, UNTIL),
                                        PIN("  time = explicit  c0 = 0.3 m/s", RATE, UNTIL),
                                        PIN("", RATE, UNTIL)};
    double lost[3], speed[3];
    for (int k = 0; k < 3; k++) {
        pd_ctx ctx;
        pd_setup u;
        pd_model m;
        lost[k] = speed[k] = 0.0;
        if (!grow(&ctx, &u, &m, texts[k])) return;
        int64_t solid = m.grid.solid_count;
        CHECK_OK(&ctx, pd_time_loop_run(&ctx, &m.time_loop, u.end_time, 0.0, NULL, NULL));
        CHECK(m.time_loop.time == u.end_time && m.grid.solid_count < solid && m.grid.solid_count > 0);
        CHECK_LE(pd_time_loop_imbalance(&m.time_loop), 1e-12);
        CHECK_OK(&ctx, pd_bonds_validate(&ctx, &m.bonds));
        lost[k] = pd_time_loop_volume_loss(&m.time_loop);
        for (int32_t i = 0; i < PD_DIM * m.grid.total; i++)
            if (m.grid.kind[i % m.grid.total] == PD_FLUID) speed[k] = fmax(speed[k], fabs(m.flow.u[i]));
        if (k == 0) CHECK_INT(m.time_loop.count, 2);
        drop(&ctx, &u, &m);
    }
    NOTE("lost %.5f (implicit), %.5f (explicit), %.5f (steady); fastest %.5f, %.5f, %.5f m/s", lost[0], lost[1],
         lost[2], speed[0], speed[1], speed[2]);
    /* the rate is constant: what is lost depends on the geometry alone */
    CHECK_REL(lost[0], lost[2], 2e-2);
    CHECK_REL(lost[1], lost[2], 2e-2);
    CHECK_REL(speed[0], speed[2], 4e-3);
    CHECK_REL(speed[1], speed[2], 8e-3);
    goes_on(texts[0], "metal in an implicit flow");
}

/* A slow oscillation of the inlet: without transport the steady flow follows it at the steps of the run. */
TEST(steady_flow_that_follows)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (!grow(&ctx, &u, &m,
              "[grid] h = 10 um  m = 2  box = 0 .. 200 um, 0 .. 100 um\n"
              "[side x-] flow = inlet  profile = parabola  mean = 1 mm/s * (1 + t/1 s)\n[side x+] flow = outlet\n"
              "[side y-] flow = noslip\n[side y+] flow = noslip\n[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n"
              "[run] until = 1 s  max_step = 0.25 s\n"))
        return;
    CHECK_OK(&ctx, pd_time_loop_start(&ctx, &m.time_loop));
    double first = pd_flow_integrate_section(&ctx, &m.flow, 0, 10);
    CHECK_REL(first, 1e-3 * 100e-6, 1e-2);
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &m.time_loop, u.end_time, 0.0, NULL, NULL));
    CHECK_INT(m.time_loop.steps, 4);
    CHECK_INT(m.quasi.solves, 5);
    CHECK_REL(pd_flow_integrate_section(&ctx, &m.flow, 0, 10), 2.0 * first, 1e-5);
    drop(&ctx, &u, &m);
}
#endif

#if PD_DIM == 1
TEST_MAIN(ENTRY(one_process) ENTRY(a_list) ENTRY(those_behind_follow) ENTRY(elements) ENTRY(gas_through_sides)
          ENTRY(gas_that_streams))
#else
TEST_MAIN(ENTRY(one_process) ENTRY(a_list) ENTRY(those_behind_follow) ENTRY(elements) ENTRY(metal_in_a_flow_in_time)
          ENTRY(steady_flow_that_follows))
#endif
