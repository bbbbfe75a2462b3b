/* waiting, process: what a run says that computes for long without a step: which process, when, and what it tries.
 * dims: 1 */
#define _XOPEN_SOURCE 700
#include "run/run.h"
#include "run/stall_note.h"
#include "scene_file.h"

/* ---- a process whose attempts are known ---- */

/* Steps of an eighth of a second are good, longer ones are not: their error is what they are over it. */
typedef struct halver {
    double time;
    int64_t steps;
    int asked;      /* by the poll function, while the second step was tried */
    int unsolved;   /* 1: attempts find no solution */
    pd_time_loop couple;
    char line[8][300];
} halver;

static pd_status halver_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    s->error = ((halver *)self)->unsolved ? HUGE_VAL : s->dt / 0.125;
    return s->error > 1.0 ? PD_RETRY : PD_OK;
}

static pd_status halver_reject(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    (void)self;
    s->dt *= 0.5;
    return PD_OK;
}

static pd_status halver_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    ((halver *)self)->time = s->end;
    ((halver *)self)->steps++;
    return PD_OK;
}

static pd_status halver_at(pd_ctx *ctx, void *self, double t)
{
    (void)self;
    (void)t;
    return pd_check_cancel(ctx, "flow: Newton", 3);
}

static int watch(void *user, const char *doing, int64_t count)
{
    halver *h = (halver *)user;
    if (h->asked < 8) pdi_stall_note_format(&h->couple, 12.0, doing, count, h->line[h->asked], sizeof h->line[0]);
    h->asked++;
    return 0;
}

static void begin(pd_ctx *ctx, halver *h)
{
    pd_physics p;
    pd_time_loop_desc d;
    static pd_grid grid;
    memset(h, 0, sizeof *h);
    memset(&p, 0, sizeof p);
    memset(&d, 0, sizeof d);
    pd_ctx_init(ctx);
    ctx->cancel = watch;
    ctx->cancel_user = h;
    CHECK_OK(ctx, pd_time_loop_build(ctx, &d, &grid, NULL, &h->couple));
    p.name = "steady flow";
    p.self = h;
    p.start = p.solve_at = halver_at;
    CHECK_OK(ctx, pd_time_loop_add_process(ctx, &h->couple, p));
    memset(&p, 0, sizeof p);
    p.name = "halver";
    p.self = h;
    p.time = &h->time;
    p.steps = &h->steps;
    p.has_substeps = 1;
    p.attempt = halver_attempt;
    p.reject = halver_reject;
    p.accept = halver_accept;
    CHECK_OK(ctx, pd_time_loop_add_process(ctx, &h->couple, p));
}

/* Each attempt is told with its length and with how the one before went, by name and time. */
TEST(attempts)
{
    pd_ctx ctx;
    halver h;
    begin(&ctx, &h);
    CHECK_OK(&ctx, pd_time_loop_start(&ctx, &h.couple));
    CHECK_STR(h.line[0], "the start takes 12.0 s so far: steady flow is solved at t = 0 s (flow: Newton 3)");
    h.asked = 0;
    CHECK_OK(&ctx, pd_time_loop_step(&ctx, &h.couple, 0.25));
    CHECK_INT(h.asked, 3); /* a step of .25, then twice one of .125 */
    CHECK_STR(h.line[0], "no step for 12.0 s, at t = 0 s: halver tries a step of 250 ms from t = 0 s (halver 0)");
    CHECK_STR(h.line[1], "no step for 12.0 s, at t = 0 s: halver tries a step of 125 ms from t = 0 s, attempt 2; the "
                         "error of the one before was 2 of what is allowed (halver 0)");
    CHECK_STR(h.line[2], "no step for 12.0 s, at t = 0 s: halver tries a step of 125 ms from t = 125 ms, after 1 step "
                         "of its own (halver 1)");
    /* between steps nothing is at hand */
    CHECK(h.couple.current.name == NULL && h.couple.current.accepted_steps == 0);
}

/* Where no attempt leads on, the reason says how many there were. */
TEST(no_way_on)
{
    pd_ctx ctx;
    halver h;
    begin(&ctx, &h);
    CHECK_OK(&ctx, pd_time_loop_start(&ctx, &h.couple));
    CHECK_OK(&ctx, pd_time_loop_step(&ctx, &h.couple, 1.0));
    h.unsolved = 1;
    h.asked = 0;
    CHECK_INT(pd_time_loop_step(&ctx, &h.couple, 2.0), PD_ERR_STATE);
    CHECK_STR(h.line[1], "no step for 12.0 s, at t = 1 s: halver tries a step of 500 ms from t = 1 s, attempt 2; the "
                         "one before found no solution (halver 11)");
    CHECK(strstr(ctx.message, "from t = 1 s to 2 s, after ") && strstr(ctx.message, "attempts that were not good"));
}

/* ---- a scene ---- */

typedef struct notes {
    int start, step;
} notes;

static void listen(void *user, pd_print_kind kind, const char *text)
{
    notes *n = (notes *)user;
    if (kind != PD_PRINT_NOTE) return;
    n->start += strncmp(text, "the start takes ", 16) == 0;
    n->step += strncmp(text, "no step for ", 12) == 0 && strstr(text, ": species in time tries a step of ");
}

/* A cell at 99 % of its limiting current has one step in 400 s, which costs hundreds of attempts and steps within: a
 * run says so when it may be silent for a microsecond, and does not when it may for 10 s. */
TEST(a_step_that_is_long)
{
    static const char cell[] =
        "[grid] h = 4 um box = -20 um .. 220 um\n"
        "[shape a] box = -20 um .. 0 um kind = solid material = copper\n"
        "[shape c] box = 200 um .. 220 um kind = solid material = steel304\n"
        "[chemistry] activity = ideal migration = yes\n"
        "[species Cu2+] D = 0.72e-9 m2/s initial = 50 mM\n[species SO4-2] D = 1.065e-9 m2/s initial = 50 mM\n"
        "[potential]\n[electrode an] shape = a curve = expression i = 1000 A/m2*E/(1 V) range = -2 V .. 2 V "
        "reaction = Cu = Cu2+ + 2 e- potential = 1 V\n"
        "[electrode ca] shape = c curve = expression i = -0.1 A/m2*[Cu2+]/(50 mM)*10^(-E/(60 mV)) "
        "reaction = Cu = Cu2+ + 2 e- potential = 0 V\n[run] until = 400 s\n[output] fields = none every = 400 s\n";
    pd_ctx ctx;
    pd_setup u;
    pd_run_desc desc;
    pd_run_result r;
    for (int patient = 0; patient < 2; patient++) {
        notes n;
        memset(&desc, 0, sizeof desc);
        memset(&n, 0, sizeof n);
        if (!CHECK_OK(&ctx, load(&ctx, cell, NULL, 0, &u))) return;
        desc.no_files = 1;
        desc.print = listen;
        desc.print_user = &n;
        desc.stall_note_after = patient ? 0.0 : 1e-6;
        CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &r));
        if (!patient) CHECK(n.step > 0);
        else CHECK_INT(n.start + n.step, 0);
        leave(&ctx, &u);
    }
}

TEST_MAIN(ENTRY(attempts) ENTRY(no_way_on) ENTRY(a_step_that_is_long))
