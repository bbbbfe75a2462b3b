/* test_newton: Newton's method on equations with known roots: its order, the lengths of steps that line searches take,
 * tolerances of linear steps and how it ends.
 * dims: 2 */
#include "pdcorr.h"
#include "test.h"

/* A scalar equation f(x) = 0, its derivative, and what the solver did. */
typedef struct problem {
    double (*f)(double x);
    double (*slope)(double x);
    double x, start, step, tolerance;
    double damping; /* factor on the step; 0: 1 */
    int solves, residuals;
    double forcing[64], norms[64];
    double lowest; /* below it there is no residual */
    int dampens;   /* 1: a step that was taken back makes the next one ten times shorter */
} problem;

static pd_status residual(pd_ctx *ctx, void *self, double *norm, double *excess)
{
    problem *p = (problem *)self;
    (void)ctx;
    p->residuals++;
    if (p->x < p->lowest) return PD_RETRY;
    *norm = fabs(p->f(p->x));
    *excess = *norm / p->tolerance;
    return PD_OK;
}

static pd_status solve_step(pd_ctx *ctx, void *self, const pd_newton_progress *progress)
{
    problem *p = (problem *)self;
    (void)ctx;
    p->norms[p->solves] = progress->norm;
    p->forcing[p->solves++] = progress->forcing;
    if (p->dampens && progress->steps > 0 && !(progress->length > 0.0)) p->damping *= 0.1;
    p->start = p->x;
    p->step = -p->damping * p->f(p->x) / p->slope(p->x);
    return PD_OK;
}

static void move(pd_ctx *ctx, void *self, double length)
{
    problem *p = (problem *)self;
    (void)ctx;
    p->x = p->start + length * p->step;
}

/* f is minus the residual of an energy whose derivative it is. */
static double work(void *self)
{
    const problem *p = (const problem *)self;
    return -p->f(p->x) * p->step;
}

static pd_status solve(pd_ctx *ctx, problem *p, pd_newton_search search, double from, pd_newton_progress *progress)
{
    pd_newton_equations e = {p, "test", residual, solve_step, move, work};
    pd_newton_desc d;
    memset(&d, 0, sizeof d);
    d.search = search;
    d.max_steps = 60;
    d.max_trials = 12;
    d.max_growth = 1.0;
    d.first_ratio = 1.0;
    d.final_forcing = 0.5;
    d.max_forcing = 0.1;
    p->x = from;
    p->solves = p->residuals = 0;
    if (!(fabs(p->damping) > 0.0)) p->damping = 1.0;
    return pd_newton_solve(ctx, &e, &d, progress);
}

static double atan_of(double x) { return atan(x); }
static double atan_slope(double x) { return 1.0 / (1.0 + x * x); }
static double cube(double x) { return x * x * x - 2.0; }
static double cube_slope(double x) { return 3.0 * x * x; }
static double square(double x) { return x * x + 1.0; }
static double square_slope(double x) { return 2.0 * x; }
static double logarithm(double x) { return log(x); }
static double log_slope(double x) { return 1.0 / x; }
/* Force with a kink: stiff against x < 0, soft beyond; zero at 2. */
static double kink(double x) { return x < 0.0 ? 100.0 * x - 1.0 : 0.5 * x - 1.0; }
static double kink_slope(double x) { return x < 0.0 ? 100.0 : 0.5; }

static problem of(double (*f)(double), double (*slope)(double), double tolerance)
{
    problem p;
    memset(&p, 0, sizeof p);
    p.f = f;
    p.slope = slope;
    p.tolerance = tolerance;
    p.lowest = -1e300;
    return p;
}

/* x^3 = 2: the errors of successive steps fall with the square, constant f''/(2 f'). */
TEST(order_two)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    problem p = of(cube, cube_slope, 1e-14);
    pd_newton_progress g;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_FULL_STEP, 2.0, &g), PD_OK);
    CHECK_NEAR(p.x, 1.2599210498948732, 1e-14);
    CHECK_INT(g.steps, p.solves);
    CHECK_INT(p.residuals, p.solves + 1);
    CHECK_LE(g.excess, 1.0);
    CHECK_NEAR(g.length, 1.0, 0.0);
    int seen = 0;
    for (int k = 1; k < p.solves; k++) {
        /* near the root |f| = f' e and e' = e^2 f''/(2 f'): |f'| = f^2 f''/(2 f'^2) */
        double root = cbrt(2.0), law = 6.0 * root / (2.0 * pow(3.0 * root * root, 2.0));
        if (p.norms[k] > 0.1 || p.norms[k] < 1e-8) continue;
        double next = k + 1 < p.solves ? p.norms[k + 1] : g.norm;
        if (next > 1e-14) CHECK_REL(next / (p.norms[k] * p.norms[k]), law, 0.05);
        seen += next > 1e-14;
    }
    CHECK(seen >= 1);
}

/* atan x = 0: whole steps run away from beyond 1.3917; halved ones arrive. The state of the failure is told. */
TEST(runs_away)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    problem p = of(atan_of, atan_slope, 1e-12);
    pd_newton_progress g;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_FULL_STEP, 1.39, &g), PD_OK);
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_FULL_STEP, 1.40, &g), PD_NOT_CONVERGED);
    CHECK_INT(g.steps, 1);
    CHECK(g.norm > g.previous && g.excess > 1.0);
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_NORM, 20.0, &g), PD_OK);
    CHECK_NEAR(p.x, 0.0, 1e-12);
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_WORK, -20.0, &g), PD_OK);
    CHECK_NEAR(p.x, 0.0, 1e-12);
}

/* x^2 + 1 has no root: the limits of steps and of stalled steps end the search at its least norm. */
TEST(no_root)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    problem p = of(square, square_slope, 1e-12);
    pd_newton_progress g;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_NORM, 3.0, &g), PD_NOT_CONVERGED);
    CHECK_INT(g.steps, 60);
    CHECK_LE(fabs(p.x), 0.1);
    CHECK_NEAR(g.norm, 1.0, 0.01);
    pd_newton_equations e = {&p, "test", residual, solve_step, move, work};
    pd_newton_desc d;
    memset(&d, 0, sizeof d);
    d.search = PD_NEWTON_BY_NORM;
    d.max_stalled = 5;
    d.max_trials = 3;
    d.max_growth = 1.0;
    d.max_forcing = 0.1;
    p.x = 3.0;
    p.solves = 0;
    CHECK_INT(pd_newton_solve(&ctx, &e, &d, &g), PD_NOT_CONVERGED);
    CHECK_INT(g.stalled, 6);
    CHECK(g.steps < 60 && g.best >= 1.0 && g.best < 10.0);
    d.max_stalled = 0;
    CHECK_INT(pd_newton_solve(&ctx, &e, &d, &g), PD_ERR_ARGUMENT);
    d.max_stalled = 5;
    d.max_forcing = 0.0;
    CHECK_INT(pd_newton_solve(&ctx, &e, &d, &g), PD_ERR_ARGUMENT);
}

/* As many lengths are tried as the limit says, and no more: atan x from 1.6 needs one halving, from 20 many. */
TEST(trials)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (int search = PD_NEWTON_BY_NORM; search <= PD_NEWTON_BY_WORK; search++) {
        problem p = of(atan_of, atan_slope, 1e-12);
        pd_newton_progress g;
        pd_newton_equations e = {&p, "test", residual, solve_step, move, work};
        pd_newton_desc d;
        memset(&d, 0, sizeof d);
        d.search = (pd_newton_search)search;
        d.max_steps = 1;
        d.max_trials = search == PD_NEWTON_BY_NORM ? 1 : 2; /* by work the whole step is a trial */
        d.max_growth = 1.0;
        d.max_forcing = 0.1;
        p.x = 1.6;
        p.damping = 1.0;
        CHECK_INT(pd_newton_solve(&ctx, &e, &d, &g), PD_NOT_CONVERGED);
        CHECK_INT(p.residuals, 3);
        CHECK(g.length > 0.0 && g.length < 1.0 && g.norm < g.previous);
        d.max_trials--;
        p.x = 1.6;
        p.residuals = p.solves = 0;
        CHECK_INT(pd_newton_solve(&ctx, &e, &d, &g), search == PD_NEWTON_BY_NORM ? PD_NOT_CONVERGED : PD_RETRY);
        CHECK_INT(p.residuals, 3); /* the first one, the whole step, and where it is taken back */
        CHECK_NEAR(p.x, 1.6, 0.0);
        CHECK_NEAR(g.length, 0.0, 0.0);
    }
}

/* A step that no halving helps is taken back to the same bits, and solve_step is told. */
TEST(takes_back)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    problem p = of(cube, cube_slope, 1e-12);
    pd_newton_progress g;
    p.damping = -1000.0; /* the wrong way */
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_NORM, 1.7, &g), PD_NOT_CONVERGED);
    CHECK_NEAR(p.x, 1.7, 0.0);
    CHECK_NEAR(g.length, 0.0, 0.0);
    CHECK_INT(g.stalled, 60);
    p.damping = 1e6; /* the right way, and far too long */
    p.dampens = 1;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_NORM, 1.7, &g), PD_OK);
    CHECK_NEAR(p.x, 1.2599210498948732, 1e-12);
    p = of(cube, cube_slope, 1e-12);
    p.damping = -1.0;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_WORK, 1.7, &g), PD_RETRY);
    CHECK_NEAR(p.x, 1.7, 0.0);
}

/* ln x has no value below zero: steps that leave its domain are shortened, or end the iteration. */
TEST(leaves_domain)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    problem p = of(logarithm, log_slope, 1e-12);
    pd_newton_progress g;
    p.lowest = 0.0;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_FULL_STEP, 10.0, &g), PD_RETRY);
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_NORM, 10.0, &g), PD_OK);
    CHECK_NEAR(p.x, 1.0, 1e-12);
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_WORK, 10.0, &g), PD_OK);
    CHECK_NEAR(p.x, 1.0, 1e-12);
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_WORK, -1.0, &g), PD_RETRY);
}

/* A kink: the first whole step lands where the norm is larger, and a search by work goes on; at the root from either
 * side. */
TEST(kinks)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    problem p = of(kink, kink_slope, 1e-12);
    pd_newton_progress g;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_WORK, -5.0, &g), PD_OK);
    CHECK_NEAR(p.x, 2.0, 1e-11);
    CHECK_LE(g.steps, 3);
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_BY_WORK, 50.0, &g), PD_OK);
    CHECK_NEAR(p.x, 2.0, 1e-11);
    CHECK_INT(g.steps, 1);
}

/* Tolerances of linear steps: 0.9 times the square of the last reduction between 1e-3 and 0.1 (Eisenstat and Walker
 * 1996), never tighter than what is left asks for. */
TEST(forcing)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    problem p = of(cube, cube_slope, 1e-10);
    pd_newton_progress g;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_FULL_STEP, 4.0, &g), PD_OK);
    CHECK_NEAR(p.forcing[0], 0.1, 0.0);
    for (int k = 1; k < p.solves; k++) {
        double ratio = p.norms[k] / p.norms[k - 1], law = fmin(0.1, fmax(1e-3, 0.9 * ratio * ratio));
        CHECK_NEAR(p.forcing[k], fmin(0.1, fmax(law, 0.5 * 1e-10 / p.norms[k])), 1e-15);
    }
    CHECK(p.solves > 4);
}

/* What is no number ends it. */
TEST(not_finite)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    problem p = of(logarithm, log_slope, 1e-12);
    pd_newton_progress g;
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_FULL_STEP, -1.0, &g), PD_NOT_CONVERGED);
    CHECK_INT(g.steps, 0);
    CHECK_INT(solve(&ctx, &p, PD_NEWTON_FULL_STEP, 1.0, &g), PD_OK); /* the root: no step */
    CHECK_INT(g.steps, 0);
}

TEST_MAIN(ENTRY(order_two) ENTRY(runs_away) ENTRY(no_root) ENTRY(trials) ENTRY(takes_back) ENTRY(leaves_domain)
              ENTRY(kinks) ENTRY(forcing) ENTRY(not_finite))
