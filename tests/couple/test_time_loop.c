/* time_loop: a pin that dissolves in a flow: ledger, sections, threads, step size, memory, local updates, units,
 * geometries at random.
 * dims: 2 3 */
#include "fixture.h"
#include <stdlib.h>
#include "conductances.h"

#define HOUR 3600.0
#define RHO 1000.0
#define MU 1e-3

/* Magnesium pin (half-width of the channel 150 um, pin 80 um thick, 1.3 um/h, mean inflow 0.236 m/s), shortened. */
typedef struct pin {
    double h, half, lead_in, pin_length, pin_half; /* [m] */
    double mean, speed;                            /* [m/s] inflow and law */
    double diffusivity, nu, solid, csat;
} pin;

static double law(void *user, const pd_rate_at *at)
{
    const pin *p = (const pin *)user;
    return p->speed * (1.0 - at->c / p->csat);
}

static void parabola(void *user, const double *x, double *u)
{
    const pin *p = (const pin *)user;
    double r2 = x[1] / p->half * (x[1] / p->half);
    for (int d = 0; d < PD_DIM; d++) u[d] = 0.0;
    if (PD_DIM == 3) r2 += x[PD_DIM - 1] / p->half * (x[PD_DIM - 1] / p->half);
    u[0] = (PD_DIM == 3 ? 2.0 : 1.5) * p->mean * fmax(1.0 - r2, 0.0);
}

static void pin_default(pin *p)
{
    p->h = PD_DIM == 2 ? 10e-6 : 25e-6;
    p->half = 150e-6;
    p->lead_in = PD_DIM == 2 ? 60e-6 : 75e-6;
    p->pin_length = PD_DIM == 2 ? 100e-6 : 75e-6;
    p->pin_half = PD_DIM == 2 ? 40e-6 : 50e-6;
    p->mean = 0.236;
    p->speed = 1.3e-6 / HOUR * (PD_DIM == 2 ? 3.0 : 8.0);
    p->diffusivity = 1e-9;
    p->nu = MU / RHO;
    p->solid = 71500.0;
    p->csat = 1000.0;
}

static int scene_finish(scene *s, pin *p, double m, int flowing)
{
    s->with = WITH_TRANSPORT | WITH_DISSOLVE | WITH_COUPLE | (flowing ? WITH_FLOW | WITH_STEADY : 0);
    for (int d = 0; d < PD_DIM; d++) s->stencil_desc.h[d] = p->h;
    s->steady_desc.tolerance = 1e-8;
    s->flow_desc.rho = RHO;
    s->flow_desc.mu = p->nu * RHO;
    s->flow_desc.report_speed = p->mean;
    s->flow_desc.report_length = 2.0 * p->half;
    s->flow_desc.inlet = parabola;
    s->flow_desc.inlet_user = p;
    s->transport_desc.diffusivity = p->diffusivity;
    s->dissolve_desc.solid = p->solid;
    s->dissolve_desc.rate = law;
    s->dissolve_desc.rate_user = p;
    return scene_build_m(s, m);
}

static int pin_build(scene *s, pin *p, int threads, double fraction)
{
    scene_reset(s);
    s->ctx.threads = threads;
    s->grid_desc.lo[0] = -p->lead_in;
    s->grid_desc.hi[0] = p->pin_length + p->lead_in;
    for (int d = 1; d < PD_DIM; d++) {
        s->grid_desc.lo[d] = -p->half;
        s->grid_desc.hi[d] = p->half;
    }
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    s->grid_desc.solid = &s->shapes[0];
    s->shapes[0].type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        s->shapes[0].a[d] = d ? -p->pin_half : 0.0;
        s->shapes[0].b[d] = d ? p->pin_half : p->pin_length;
    }
    s->couple_desc.fraction = fraction;
    return scene_finish(s, p, PD_DIM == 2 ? 3.0 : 2.0, 1);
}

/* Bonds built afresh on the same kinds: the same rows, whatever their order, and the same runs. */
static void check_bonds(scene *s)
{
    pd_bonds fresh;
    const pd_bonds *b = &s->bonds;
    int64_t dd = PD_DIM * PD_DIM;
    if (!CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &fresh))) return;
    CHECK_INT(b->rows, fresh.rows);
    CHECK_INT(b->full_ranges.count, fresh.full_ranges.count);
    for (int32_t k = 0; k < fresh.full_ranges.count && k < b->full_ranges.count; k++)
        CHECK(b->full_ranges.first[k] == fresh.full_ranges.first[k] &&
              b->full_ranges.length[k] == fresh.full_ranges.length[k]);
    for (int32_t r = 0; r < fresh.rows; r++) {
        int32_t q = b->row_of_node[fresh.node[r]];
        if (!CHECK_INT(q, r)) continue;
        for (int w = 0; w < b->paths.words; w++)
            CHECK(b->open_mask[(int64_t)w * b->capacity + q] == fresh.open_mask[(int64_t)w * fresh.capacity + r]);
        CHECK(memcmp(&b->wall_laplacian[q], &fresh.wall_laplacian[r], sizeof *b->wall_laplacian) == 0);
        CHECK(memcmp(&b->wall_curvature[q], &fresh.wall_curvature[r], sizeof *b->wall_curvature) == 0);
        CHECK(memcmp(b->inverse_moment + q * dd, fresh.inverse_moment + r * dd,
                     (size_t)dd * sizeof *b->inverse_moment) == 0);
    }
    pd_bonds_free(&s->ctx, &fresh);
}

/* What one run is held to at every step. */
typedef struct watch {
    scene *s;
    double loss, last_time;
    size_t in_use;
    int64_t steps;
    int quiet; /* the step before changed no geometry either */
} watch;

static int observe(void *user, const pd_time_loop *couple)
{
    watch *w = (watch *)user;
    scene *s = w->s;
    CHECK_LE(couple->ledger[0].relative_imbalance, 1e-12);
    CHECK_LE(w->loss, pd_time_loop_volume_loss(couple));
    CHECK_INT(couple->steps, w->steps);
    if (couple->steps) CHECK(couple->time > w->last_time);
    w->loss = pd_time_loop_volume_loss(couple);
    w->last_time = couple->time;
    w->steps++;
    /* only a change asks for memory: in its own step, or in the next one, which sets up the solvers for it */
    int changed = s->dissolve.changed_count > 0;
    if (couple->steps > 1 && w->quiet && !changed) CHECK(s->ctx.in_use == w->in_use);
    w->in_use = s->ctx.in_use;
    w->quiet = !changed;
    if (couple->count > 1 && (couple->steps == 0 || changed)) {
        double up = pd_flow_integrate_section(&s->ctx, &s->flow, 0, 2);
        double down = pd_flow_integrate_section(&s->ctx, &s->flow, 0, s->grid.n[0] - 2);
        CHECK_REL(down, up, 1e-6);
    }
    return 0;
}

/* ---- the pin ---- */

static scene first_scene, second_scene;

/* Ledger, sections, monotony and memory at every step, bonds at the end; and the same bits for 1, 2 and 4 threads. */
TEST(pin_run)
{
    scene *s = &first_scene, *t = &second_scene;
    pin p;
    double end = (PD_DIM == 2 ? 3.0 : 2.2) * HOUR; /* 3D: the pin, as thin as the front, goes whole */
    pin_default(&p);
    for (int threads = 1; threads <= 4; threads *= 2) {
        scene *now = threads == 1 ? s : t;
        watch w;
        memset(&w, 0, sizeof w);
        w.s = now;
        if (!pin_build(now, &p, threads, 0.0)) return;
        if (!CHECK_OK(&now->ctx, pd_time_loop_run(&now->ctx, &now->couple, end, end / 6.0, observe, &w))) return;
        CHECK(now->couple.time == end);
        CHECK(w.loss > 0.1 && now->grid.solid_count < now->couple.solid_nodes_start);
        check_bonds(now);
        check_conductances(&now->ctx, &now->transport);
        if (threads == 1) {
            NOTE("loss %.4f, %d steps, %d flow solves", w.loss, (int)s->couple.steps, (int)s->quasi.solves);
            continue;
        }
        size_t bytes = (size_t)s->grid.total * sizeof(double);
        CHECK(memcmp(s->transport.c, t->transport.c, bytes) == 0);
        CHECK(memcmp(s->flow.u, t->flow.u, PD_DIM * bytes) == 0);
        CHECK(memcmp(s->flow.p, t->flow.p, bytes) == 0);
        CHECK(memcmp(&s->couple.ledger, &t->couple.ledger, sizeof s->couple.ledger) == 0);
        scene_free(t);
    }
    scene_free(s);
}

#if PD_DIM == 2
/* The pin of the experiment for 3 h: steps ten times shorter change the loss by less than 1 %. */
TEST(step_size)
{
    pin p;
    double loss[2];
    pin_default(&p);
    p.speed = 1.3e-6 / HOUR;
    for (int k = 0; k < 2; k++) {
        scene *s = &first_scene;
        if (!pin_build(s, &p, 0, k ? 0.01 : 0.1)) return;
        if (!CHECK_OK(&s->ctx, pd_time_loop_run(&s->ctx, &s->couple, 3.0 * HOUR, 0.0, NULL, NULL))) return;
        loss[k] = pd_time_loop_volume_loss(&s->couple);
        scene_free(s);
    }
    NOTE("loss %.6f, steps ten times shorter %.6f", loss[0], loss[1]);
    CHECK_REL(loss[0], loss[1], 1e-4);
}
#endif

/* Another unit of length (times 2^k) and of time (times 2^j) scales every field by its power of two and changes no
 * digit: no literal of the library has a dimension. */
TEST(units_do_not_matter)
{
    scene *s = &first_scene, *t = &second_scene;
    pin p, q;
    pin_default(&p);
    double end = (PD_DIM == 2 ? 1.0 : 0.3) * HOUR, length = 1048576.0, time = 4096.0; /* 2^20, 2^12 */
    q = p;
    q.h *= length;
    q.half *= length;
    q.lead_in *= length;
    q.pin_length *= length;
    q.pin_half *= length;
    q.mean *= length / time;
    q.speed *= length / time;
    q.diffusivity *= length * length / time;
    q.nu *= length * length / time;
    if (!pin_build(s, &p, 0, 0.0) || !pin_build(t, &q, 0, 0.0)) return;
    if (!CHECK_OK(&s->ctx, pd_time_loop_run(&s->ctx, &s->couple, end, 0.0, NULL, NULL))) return;
    if (!CHECK_OK(&t->ctx, pd_time_loop_run(&t->ctx, &t->couple, end * time, 0.0, NULL, NULL))) return;
    CHECK_INT(s->couple.steps, t->couple.steps);
    CHECK_INT(s->quasi.krylov, t->quasi.krylov);
    CHECK_INT(s->dissolve.krylov, t->dissolve.krylov);
    int64_t differ[3] = {0, 0, 0}, total = s->grid.total;
    double largest[3] = {0.0, 0.0, 0.0}, off[3] = {0.0, 0.0, 0.0};
    for (int64_t i = 0; i < total; i++) {
        if (s->grid.kind[i] != t->grid.kind[i]) differ[0]++;
        if (s->grid.kind[i] != PD_FLUID && s->grid.kind[i] != PD_SOLID) continue;
        double a[3], b[3];
        a[0] = s->transport.c[i];
        b[0] = t->transport.c[i];
        a[1] = s->flow.u[i];
        b[1] = t->flow.u[i] * time / length;
        a[2] = s->flow.p[i];
        b[2] = t->flow.p[i] * (time / length) * (time / length);
        for (int k = 0; k < 3; k++) {
            differ[k] += a[k] < b[k] || a[k] > b[k];
            largest[k] = fmax(largest[k], fabs(a[k]));
            off[k] = fmax(off[k], fabs(a[k] - b[k]));
        }
    }
    NOTE("values that differ: c %d, u %d, p %d; by %.3g, %.3g, %.3g of the largest", (int)differ[0], (int)differ[1],
         (int)differ[2], off[0] / largest[0], off[1] / largest[1], off[2] / largest[2]);
    for (int k = 0; k < 3; k++) CHECK_INT(differ[k], 0);
    scene_free(s);
    scene_free(t);
}

/* ---- geometries at random ---- */

static pin random_pin;

/* Boxes of 3 to 14 cells an edge with a ball and a box of metal somewhere, walls or a flow through: every run ends, the
 * amounts close, no concentration leaves its bounds. */
static int random_scene(scene *s, pin *p, uint32_t *seed, int flowing)
{
    scene_reset(s);
    s->ctx.threads = 1;
    pin_default(p);
    p->h = 10e-6;
    int most = PD_DIM == 3 && !flowing ? 7 : 14, least = flowing ? 9 : 3;
    for (int d = 0; d < PD_DIM; d++)
        s->grid_desc.hi[d] = p->h * (double)(least + (int)(next_random(seed) % (uint32_t)(most - least + 1)));
    if (flowing) {
        s->grid_desc.lo[1] = -0.5 * s->grid_desc.hi[1];
        s->grid_desc.hi[1] *= 0.5;
        p->half = s->grid_desc.hi[1];
        p->mean = 0.01;
        s->grid_desc.side[0] = PD_SIDE_INLET;
        s->grid_desc.side[1] = PD_SIDE_OUTLET;
    }
    s->grid_desc.solid = &s->shapes[2];
    double least_edge = HUGE_VAL;
    for (int d = 0; d < PD_DIM; d++) least_edge = fmin(least_edge, s->grid_desc.hi[d] - s->grid_desc.lo[d]);
    /* with flow, two cells stay free on every side */
    double margin = flowing ? 2.0 * p->h : 0.0;
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = random_between(seed, 0.1, 0.49) * (least_edge - 2.0 * margin);
    s->shapes[1].type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        double lo = s->grid_desc.lo[d] + margin, hi = s->grid_desc.hi[d] - margin, r = s->shapes[0].radius;
        s->shapes[0].a[d] = random_between(seed, lo + r, hi - r);
        s->shapes[1].a[d] = random_between(seed, lo, 0.5 * (lo + hi));
        s->shapes[1].b[d] = fmin(hi, s->shapes[1].a[d] + random_between(seed, 1.01 * p->h, 0.5 * (hi - lo) + p->h));
    }
    s->shapes[2].type = PD_SHAPE_UNION;
    s->shapes[2].child_count = 2;
    s->shapes[2].child[1] = 1;
    p->csat = p->solid * random_between(seed, 0.01, 2.0);
    s->dissolve_desc.threshold = next_random(seed) % 3 ? 0.0 : random_between(seed, 0.0, 0.009) * p->csat / p->solid;
    return scene_finish(s, p, 1.0 + next_random(seed) % 3, flowing);
}

static void random_run(scene *s, double csat, double end)
{
    if (!CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &s->couple))) return;
    for (int steps = 0; s->couple.time < end; steps++) {
        if (!CHECK(steps < 3000) || !CHECK_OK(&s->ctx, pd_time_loop_step(&s->ctx, &s->couple, end))) return;
        CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-12);
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID)
                CHECK(s->transport.c[i] >= -1e-7 * csat && s->transport.c[i] <= csat * (1.0 + 1e-7));
    }
    CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds));
    check_conductances(&s->ctx, &s->transport);
}

TEST(random_geometries)
{
    uint32_t seed = 2024;
    int rounds = PD_DIM == 2 ? 200 : 12, whole = 0;
    for (int round = 0; round < rounds; round++) {
        scene *s = &first_scene;
        if (!random_scene(s, &random_pin, &seed, 0)) return;
        int before = test_now.failures;
        random_run(s, random_pin.csat, 40.0 * HOUR);
        whole += s->grid.solid_count == 0;
        if (test_now.failures > before) NOTE("round %d failed", round);
        scene_free(s);
    }
    CHECK(whole > 0);
    if (PD_DIM == 2) CHECK(whole < rounds); /* saturation keeps some */
}

#if PD_DIM == 2
TEST(random_geometries_in_flow)
{
    uint32_t seed = 7;
    for (int round = 0; round < 8; round++) {
        scene *s = &first_scene;
        if (!random_scene(s, &random_pin, &seed, 1)) return;
        int before = test_now.failures;
        random_run(s, random_pin.csat, 20.0 * HOUR);
        if (test_now.failures > before) NOTE("round %d failed", round);
        scene_free(s);
    }
}
#endif

/* ---- arguments ---- */

static int stop_at_once(void *user, const pd_time_loop *couple)
{
    (void)couple;
    ++*(int *)user;
    return 1;
}

TEST(arguments)
{
    scene *s = &first_scene;
    uint32_t seed = 3;
    pd_time_loop other;
    if (!random_scene(s, &random_pin, &seed, 0)) return;
    for (int k = 0; k < 4; k++) {
        pd_time_loop_desc desc;
        memset(&desc, 0, sizeof desc);
        if (k == 0) desc.fraction = -0.1;
        if (k == 1) desc.fraction = 1.1;
        if (k == 2) desc.max_step = -1.0;
        if (k == 3) desc.ledger_tolerance = (double)NAN;
        CHECK_INT(pd_time_loop_build(&s->ctx, &desc, &s->grid, &s->bonds, &other), PD_ERR_ARGUMENT);
        CHECK(strncmp(s->ctx.message, "time_loop: ", 11) == 0);
    }
    other = s->couple;
    while (other.count < PD_TIME_LOOP_MAX_PROCESSES)
        CHECK_OK(&s->ctx, pd_time_loop_add_process(&s->ctx, &other, other.process[0]));
    CHECK_INT(pd_time_loop_add_process(&s->ctx, &other, other.process[0]), PD_ERR_SIZE);
    CHECK_INT(pd_time_loop_run(&s->ctx, &s->couple, -1.0, 0.0, NULL, NULL), PD_ERR_ARGUMENT);
    CHECK_INT(pd_time_loop_run(&s->ctx, &s->couple, (double)NAN, 0.0, NULL, NULL), PD_ERR_ARGUMENT);
    CHECK_INT(pd_time_loop_step(&s->ctx, &s->couple, 0.0), PD_ERR_ARGUMENT);
    int calls = 0;
    CHECK_OK(&s->ctx, pd_time_loop_run(&s->ctx, &s->couple, HOUR, 0.0, stop_at_once, &calls));
    CHECK_INT(calls, 1);
    CHECK_INT(s->couple.steps, 0);
    scene_free(s);
}

/* Steps end on the multiples of the interval, exactly. */
typedef struct clock_watch {
    double every;
    int met;
} clock_watch;

static int meet(void *user, const pd_time_loop *couple)
{
    clock_watch *w = (clock_watch *)user;
    if (couple->time >= (w->met + 1) * w->every) {
        CHECK(couple->time == (w->met + 1) * w->every);
        w->met++;
    }
    return 0;
}

TEST(steps_meet_the_interval)
{
    scene *s = &first_scene;
    uint32_t seed = 3;
    clock_watch w;
    w.every = 0.1 * HOUR;
    w.met = 0;
    if (!random_scene(s, &random_pin, &seed, 0)) return;
    CHECK_OK(&s->ctx, pd_time_loop_run(&s->ctx, &s->couple, 10 * w.every, w.every, meet, &w));
    CHECK_INT(w.met, 10);
    CHECK(s->couple.time == 10 * w.every);
    scene_free(s);
}

/* Where nothing moves in time, steps are equal parts of the way; the last one ends where it is to, bit for bit. Way and
 * end are numbers that rounding parts: start + (end - start) is below the end. */
TEST(equal_steps)
{
    scene *s = &first_scene;
    double start = 0.25 + ldexp(1.0, -53), end = 1.5 + ldexp(1.0, -52), way = end - start;
    CHECK(start + way < end);
    for (int k = 0; k < 2; k++) {
        scene_box(s, 1.0, 1e-5, 4, 4, 4);
        s->with = WITH_COUPLE;
        s->couple_desc.max_step = k ? 0.5 : way * (1.0 - 1e-13);
        if (!scene_build(s)) return;
        CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &s->couple));
        CHECK_OK(&s->ctx, pd_time_loop_step(&s->ctx, &s->couple, start));
        CHECK(s->couple.time == start);
        CHECK_OK(&s->ctx, pd_time_loop_step(&s->ctx, &s->couple, end));
        if (!k) CHECK(s->couple.time == end);
        if (k) CHECK_NEAR(s->couple.time, start + way / 3.0, 1e-15);
        scene_free(s);
    }
}

/* ---- processes that miss their tolerance ---- */

/* A quasi-steady process, or one that steps in time, which returns PD_NOT_CONVERGED where it is told to. */
typedef struct loose_process {
    int start, solve_at, finish, attempt; /* 1: misses its tolerance there */
} loose_process;

static pd_status loose_start(pd_ctx *ctx, void *self, double t)
{
    (void)ctx, (void)t;
    return ((loose_process *)self)->start ? PD_NOT_CONVERGED : PD_OK;
}

static pd_status loose_solve_at(pd_ctx *ctx, void *self, double t)
{
    (void)ctx, (void)t;
    return ((loose_process *)self)->solve_at ? PD_NOT_CONVERGED : PD_OK;
}

static pd_status loose_finish(pd_ctx *ctx, void *self, double t)
{
    (void)ctx, (void)t;
    return ((loose_process *)self)->finish ? PD_NOT_CONVERGED : PD_OK;
}

/* Two steps of its own in each of the run; it asks for what is quasi-steady at the end of each, and misses its
 * tolerance in the first. */
static pd_status loose_attempt(pd_ctx *ctx, void *self, pd_step *step)
{
    step->end = step->latest_end;
    if (step->dt < step->end - step->time) step->end = step->time + step->dt;
    PD_TRY(step->solve_at(ctx, step->solve_at_user, step->end));
    return ((loose_process *)self)->attempt && step->end < step->latest_end ? PD_NOT_CONVERGED : PD_OK;
}

static pd_status loose_limit(pd_ctx *ctx, void *self, pd_step *step)
{
    (void)ctx, (void)self;
    step->dt = 0.5;
    return PD_OK;
}

/* A step counts once, whichever process misses its tolerance, and wherever: a quasi-steady one at its start, when it is
 * solved for a step or at the end of one, or one in time within a step. */
TEST(missed_tolerances_are_counted)
{
    for (int in_time = 0; in_time < 2; in_time++)
        for (int where = 0; where < 5; where++) {
            pd_ctx ctx;
            pd_time_loop_desc desc;
            pd_time_loop loop;
            pd_grid grid;
            pd_physics steady, moving;
            loose_process at_rest, moves;
            pd_ctx_init(&ctx);
            memset(&desc, 0, sizeof desc), memset(&grid, 0, sizeof grid);
            memset(&steady, 0, sizeof steady), memset(&moving, 0, sizeof moving);
            memset(&at_rest, 0, sizeof at_rest), memset(&moves, 0, sizeof moves);
            desc.max_step = 1.0;
            steady.name = "steady", steady.self = &at_rest;
            steady.start = loose_start, steady.solve_at = loose_solve_at, steady.finish = loose_finish;
            moving.name = "moving", moving.self = &moves, moving.has_substeps = 1;
            moving.limit = loose_limit, moving.attempt = loose_attempt, moving.finish = loose_finish;
            CHECK_OK(&ctx, pd_time_loop_build(&ctx, &desc, &grid, NULL, &loop));
            CHECK_OK(&ctx, pd_time_loop_add_process(&ctx, &loop, steady));
            if (in_time) CHECK_OK(&ctx, pd_time_loop_add_process(&ctx, &loop, moving));
            at_rest.start = where == 0;
            CHECK_OK(&ctx, pd_time_loop_start(&ctx, &loop));
            CHECK_INT(loop.unsolved, where == 0);
            at_rest.solve_at = where == 1;
            at_rest.finish = where == 2;
            moves.attempt = where == 3;
            moves.finish = where == 4;
            int misses = where == 1 || where == 2 || (in_time && where > 2);
            CHECK_INT(pd_time_loop_step(&ctx, &loop, 1.0), misses ? PD_NOT_CONVERGED : PD_OK);
            CHECK_INT(loop.unsolved, where == 0 || misses);
            memset(&at_rest, 0, sizeof at_rest), memset(&moves, 0, sizeof moves);
            CHECK_OK(&ctx, pd_time_loop_step(&ctx, &loop, 2.0)); /* the next one counts for itself */
            CHECK_INT(loop.unsolved, where == 0 || misses);
            CHECK_INT(loop.steps, 2);
        }
}

/* A process with too many elements leaves none behind. */
TEST(refused_processes_leave_nothing)
{
    static const pd_element element[PD_TIME_LOOP_MAX_ELEMENTS] = {
        {"a", "mol"}, {"b", "mol"}, {"c", "mol"}, {"d", "mol"}, {"e", "mol"}, {"f", "mol"}, {"g", "mol"}, {"h", "mol"}};
    scene *s = &first_scene;
    uint32_t seed = 3;
    pd_physics p;
    if (!random_scene(s, &random_pin, &seed, 0)) return;
    pd_time_loop loop = s->couple;
    int elements = loop.elements, processes = loop.count;
    CHECK(elements > 0);
    memset(&p, 0, sizeof p);
    p.element = element;
    p.elements = PD_TIME_LOOP_MAX_ELEMENTS;
    CHECK_INT(pd_time_loop_add_process(&s->ctx, &loop, p), PD_ERR_SIZE);
    CHECK_INT(loop.elements, elements);
    CHECK_INT(loop.count, processes);
    scene_free(s);
}

#if PD_DIM == 2
#define OF_DIM ENTRY(step_size) SLOW_ENTRY(random_geometries_in_flow)
#else
#define OF_DIM
#endif

TEST_MAIN(SLOW_ENTRY_IF(PD_DIM == 3, pin_run) OF_DIM ENTRY(units_do_not_matter) SLOW_ENTRY(random_geometries)
              ENTRY(arguments) ENTRY(steps_meet_the_interval) ENTRY(equal_steps) ENTRY(missed_tolerances_are_counted)
                  ENTRY(refused_processes_leave_nothing))
