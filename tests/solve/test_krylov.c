/* krylov: GMRES and CG against closed forms of small systems.
 * dims: 2 */
#include "solve/krylov.h"
#include "fault.h"
#include "random.h"

#define PI 3.14159265358979323846
#define N_MAX 60000

static const pd_krylov_method methods[2] = {PD_KRYLOV_GMRES, PD_KRYLOV_CG};

/* The systems, selected by `kind`. */
typedef enum kind {
    K_POISSON,  /* -1 2 -1 with zero values beyond both ends */
    K_SHIFT,    /* (A x)_i = x_(i+1), cyclic */
    K_DIAGONAL, /* diag d */
    K_SKEW,     /* blocks (0 1; -1 0) */
    K_WIND      /* -1-w, 2+w, -1: upwind transport */
} kind;

typedef struct sys {
    kind what;
    int n;
    const double *d;
    double wind;
    int calls, poison; /* the call from which on NaN comes out, 0: never */
    int precond_calls;
} sys;

static void multiply(void *user, const double *x, double *y)
{
    sys *s = (sys *)user;
    int n = s->n;
    s->calls++;
    for (int i = 0; i < n; i++) {
        double left = i > 0 ? x[i - 1] : 0.0, right = i < n - 1 ? x[i + 1] : 0.0;
        switch (s->what) {
        case K_POISSON: y[i] = 2.0 * x[i] - left - right; break;
        case K_SHIFT: y[i] = x[(i + 1) % n]; break;
        case K_DIAGONAL: y[i] = s->d[i] * x[i]; break;
        case K_SKEW: y[i] = i % 2 ? -x[i - 1] : x[i + 1]; break;
        case K_WIND: y[i] = (2.0 + s->wind) * x[i] - (1.0 + s->wind) * left - right; break;
        }
    }
    if (s->poison && s->calls >= s->poison) y[n / 2] = (double)NAN;
}

static void jacobi(void *user, const double *x, double *y)
{
    sys *s = (sys *)user;
    s->precond_calls++;
    for (int i = 0; i < s->n; i++) y[i] = x[i] / (s->what == K_DIAGONAL ? s->d[i] : 2.0 + s->wind);
}

/* Not the same operator twice: its scale alternates over four decades in the halves of the vector. */
static void restless(void *user, const double *x, double *y)
{
    sys *s = (sys *)user;
    double c = s->precond_calls++ % 2 ? 100.0 : 1.0;
    for (int i = 0; i < s->n; i++) y[i] = x[i] * (i < s->n / 2 ? c : 1.0 / c);
}

static void broken(void *user, const double *x, double *y)
{
    sys *s = (sys *)user;
    for (int i = 0; i < s->n; i++) y[i] = x[i] * (double)NAN;
}

static double unit_random(uint32_t *state) { return random_share(state) - 0.5; }

static double residual_norm(sys *s, const double *b, const double *x)
{
    static double y[N_MAX];
    double sum = 0.0;
    int poison = s->poison;
    s->poison = 0;
    multiply(s, x, y);
    s->poison = poison;
    for (int i = 0; i < s->n; i++) sum += (b[i] - y[i]) * (b[i] - y[i]);
    return sqrt(sum);
}

static double largest_difference(int n, const double *u, const double *v)
{
    double largest = 0.0;
    for (int i = 0; i < n; i++) largest = fmax(largest, fabs(u[i] - v[i]));
    return largest;
}

static sys make(kind what, int n)
{
    sys s;
    memset(&s, 0, sizeof s);
    s.what = what;
    s.n = n;
    return s;
}

static pd_krylov_desc describe(pd_krylov_method method, int n)
{
    pd_krylov_desc d;
    memset(&d, 0, sizeof d);
    d.method = method;
    d.n = n;
    return d;
}

/* build, solve, free */
static pd_status run(pd_ctx *ctx, const pd_krylov_desc *desc, sys *s, pd_apply_fn precond, const double *b, double *x,
                     pd_krylov_result *result)
{
    pd_krylov k;
    pd_status status = pd_krylov_build(ctx, desc, &k);
    if (status == PD_OK) status = pd_krylov_solve(ctx, &k, multiply, precond, s, b, x, result);
    pd_krylov_free(ctx, &k);
    pd_krylov_free(ctx, &k);
    CHECK_INT(ctx->in_use, 0);
    return status;
}

/* -u'' = 1: the discrete solution is x_i = (i+1)(n-i)/2 */
TEST(poisson_closed_form)
{
    enum { N = 120 };
    double b[N], x[N], exact[N];
    for (int i = 0; i < N; i++) {
        b[i] = 1.0;
        exact[i] = 0.5 * (i + 1) * (N - i);
    }
    for (int m = 0; m < 2; m++)
        for (int pre = 0; pre < 2; pre++) {
            pd_ctx ctx;
            pd_krylov_result r;
            pd_ctx_init(&ctx);
            sys s = make(K_POISSON, N);
            pd_krylov_desc d = describe(methods[m], N);
            d.restart = N;
            d.rtol = 1e-11;
            memset(x, 0, sizeof x);
            CHECK_OK(&ctx, run(&ctx, &d, &s, pre ? jacobi : NULL, b, x, &r));
            CHECK_LE(largest_difference(N, x, exact) / exact[N / 2], 1e-9);
            CHECK_INT(r.converged, 1);
            double own = residual_norm(&s, b, x);
            CHECK_REL(r.residual, own, 1e-10);
            CHECK_REL(r.residual0, sqrt((double)N), 1e-14);
            CHECK_LE(r.residual, 1e-11 * sqrt((double)N));
            /* b is even about the middle: N / 2 distinct eigenvectors end CG and GMRES after N / 2 iterations */
            CHECK_LE(r.iterations, N / 2 + 1);
            CHECK_INT(s.precond_calls, r.precond_applies);
            CHECK_INT(s.calls - 1, r.applies); /* one by residual_norm */
        }
}

/* The cyclic shift: GMRES stands still for n - 1 steps, then is exact (Nachtigal, Reddy and Trefethen 1992). */
TEST(gmres_cyclic_shift)
{
    enum { N = 24 };
    double b[N] = {0.0}, x[N] = {0.0};
    pd_ctx ctx;
    pd_krylov_result r;
    pd_ctx_init(&ctx);
    sys s = make(K_SHIFT, N);
    b[0] = 1.0;
    pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
    d.restart = N;
    CHECK_OK(&ctx, run(&ctx, &d, &s, NULL, b, x, &r));
    CHECK_INT(r.iterations, N);
    CHECK_NEAR(x[1], 1.0, 1e-14);
    d.restart = N - 1;
    d.max_iterations = 1000;
    memset(x, 0, sizeof x);
    CHECK_INT(run(&ctx, &d, &s, NULL, b, x, &r), PD_NOT_CONVERGED);
    CHECK_INT(r.iterations, N - 1); /* stagnation is seen after one cycle */
    CHECK(strstr(ctx.message, "stagnation") != NULL);
    CHECK_NEAR(r.residual, 1.0, 1e-14);
}

static void same(void *user, const double *x, double *y)
{
    const sys *s = (const sys *)user;
    memcpy(y, x, (size_t)s->n * sizeof *x);
}

/* A basis that grows needs no restart; it gives back what it took, and where memory is refused it restarts. */
TEST(gmres_growth)
{
    enum { N = 24 };
    for (int variant = 0; variant < 8; variant++) {
        int refused = variant & 1;
        pd_apply_fn precond = variant >> 2 ? same : NULL;
        double b[N] = {0.0}, x[N] = {0.0};
        pd_ctx ctx;
        fault c;
        pd_krylov k;
        pd_krylov_result r;
        pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
        sys s = make(K_SHIFT, N);
        b[0] = 1.0;
        d.restart = 5;
        d.max_vectors = 25;
        d.max_iterations = 1000;
        d.basis_precision = variant >> 1 & 1 ? PD_KRYLOV_SINGLE : PD_KRYLOV_DOUBLE;
        d.flexible = variant >> 2;
        fault_context(&c, 0, 1, &ctx);
        CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k));
        size_t built = ctx.in_use;
        if (refused) c.fail_at = c.calls + 4; /* the second growth, halfway */
        CHECK_INT(pd_krylov_solve(&ctx, &k, multiply, precond, &s, b, x, &r), refused ? PD_NOT_CONVERGED : PD_OK);
        CHECK_INT(r.iterations, refused ? 6 : N); /* it grows by one */
        CHECK(!refused || strstr(ctx.message, "stagnation") != NULL);
        if (!refused) CHECK_NEAR(x[1], 1.0, 1e-6);
        CHECK(ctx.in_use > built);
        pdi_krylov_free_growth(&ctx, &k);
        CHECK_INT(c.wrong, 0);
        if (!refused) CHECK_INT((int)ctx.in_use, (int)built);
        c.fail_at = 0;
        memset(x, 0, sizeof x);
        CHECK_OK(&ctx, pd_krylov_solve(&ctx, &k, multiply, precond, &s, b, x, &r));
        CHECK_INT(r.iterations, N);
        k.desc.fixed_restart = 1;
        memset(x, 0, sizeof x);
        CHECK_INT(pd_krylov_solve(&ctx, &k, multiply, precond, &s, b, x, &r), PD_NOT_CONVERGED);
        CHECK_INT(r.iterations, 5);
        pd_krylov_free(&ctx, &k);
        CHECK_INT(ctx.in_use, 0);
        CHECK_INT(c.live, 0);
    }
}

/* A basis grows into what an arena has left, and beyond; after a solve the arena has it back. The same bits. */
TEST(gmres_growth_lent)
{
    enum { N = 24, GROWS = 19, LENT = 7 };
    for (int flexible = 0; flexible < 2; flexible++) {
        double b[N] = {0.0}, x[2][N];
        size_t chunk = (size_t)N * sizeof *b * (flexible ? 2 : 1), grown[2];
        b[0] = 1.0;
        for (int lends = 0; lends < 2; lends++) {
            pd_ctx ctx;
            pd_krylov k;
            pd_krylov_result r;
            pd_arena arena;
            pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
            sys s = make(K_SHIFT, N);
            pd_ctx_init(&ctx);
            memset(&arena, 0, sizeof arena);
            d.restart = 5;
            d.max_vectors = 25;
            d.max_iterations = 1000;
            d.flexible = flexible;
            if (lends) d.arena = &arena;
            CHECK_OK(&ctx, pdi_arena_reserve(&ctx, &arena, LENT * chunk));
            CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k));
            size_t built = ctx.in_use;
            for (int pass = 0; pass < 2; pass++) {
                memset(x[lends], 0, sizeof x[lends]);
                CHECK_OK(&ctx, pd_krylov_solve(&ctx, &k, multiply, flexible ? same : NULL, &s, b, x[lends], &r));
                CHECK_INT(r.iterations, N);
                CHECK_INT(k.chunk_count, GROWS - (lends ? LENT : 0));
                CHECK_INT((int)arena.used, 0);
            }
            grown[lends] = ctx.in_use - built;
            pdi_krylov_free_growth(&ctx, &k);
            CHECK_INT((int)ctx.in_use, (int)built);
            pd_krylov_free(&ctx, &k);
            pd_arena_free(&ctx, &arena);
            CHECK_INT(ctx.in_use, 0);
        }
        CHECK_INT((int)(grown[0] - grown[1]), (int)(LENT * chunk));
        CHECK(memcmp(x[0], x[1], sizeof x[0]) == 0);
    }
}

/* The operator leaves rubbish in what it is given. */
static void spoil(void *user, const double *x, double *y)
{
    multiply(user, x, y);
    for (int i = 0; i < ((const sys *)user)->n; i++) ((double *)x)[i] = 1e30;
}

/* One work vector less, and room for few vectors at first: the same bits, with restarts and without. */
TEST(gmres_lean)
{
    enum { N = 60 };
    for (int variant = 0; variant < 8; variant++) {
        double b[N], x[2][N];
        pd_krylov_result r[2];
        for (int i = 0; i < N; i++) b[i] = 1.0 + 0.3 * sin(1.7 * i);
        for (int lean = 0; lean < 2; lean++) {
            pd_ctx ctx;
            sys s = make(K_WIND, N);
            pd_krylov k;
            pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
            s.wind = 0.5;
            pd_ctx_init(&ctx);
            d.restart = 12;
            d.max_vectors = variant & 1 ? 200 : 0;
            d.basis_precision = variant >> 1 & 1 ? PD_KRYLOV_SINGLE : PD_KRYLOV_DOUBLE;
            d.max_iterations = variant >> 2 ? 20 : 4000; /* it stops within the second cycle, or has converged */
            d.rtol = 1e-10;
            d.zero_guess = 1;
            d.low_memory = lean;
            d.initial_vectors = lean ? 6 : 0;
            for (int i = 0; i < N; i++) x[lean][i] = 7.0;
            CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k));
            CHECK_INT(k.vectors, lean ? 1 : 2);
            int status = pd_krylov_solve(&ctx, &k, lean ? spoil : multiply, jacobi, &s, b, x[lean], &r[lean]);
            CHECK_INT(status, variant >> 2 ? PD_NOT_CONVERGED : PD_OK);
            CHECK_NEAR(residual_norm(&s, b, x[lean]), r[lean].residual, 1e-12 * r[lean].residual0);
            pd_krylov_free(&ctx, &k);
            CHECK_INT(ctx.in_use, 0);
        }
        CHECK_INT(r[0].iterations, r[1].iterations);
        CHECK(variant & 1 || variant >> 2 || r[0].iterations > 24); /* it has restarted twice */
        CHECK(memcmp(x[0], x[1], sizeof x[0]) == 0);
    }
}

/* The residual of the recurrence is the true one, and taking it for granted leaves one product out: the same bits. */
TEST(gmres_trusting)
{
    enum { N = 60 };
    double b[N], x[2][N];
    pd_krylov_result r[2];
    for (int i = 0; i < N; i++) b[i] = 1.0 + 0.3 * sin(1.7 * i);
    for (int variant = 0; variant < 4; variant++) {
        for (int trusting = 0; trusting < 2; trusting++) {
            pd_ctx ctx;
            sys s = make(K_WIND, N);
            pd_krylov k;
            pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
            s.wind = 0.5;
            pd_ctx_init(&ctx);
            d.restart = variant & 1 ? 12 : 200; /* restarts take the true residual */
            d.max_iterations = variant >> 1 ? 20 : 4000;
            d.rtol = 1e-8;
            d.zero_guess = d.low_memory = 1;
            d.skip_true_residual = trusting;
            CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k));
            int status = pd_krylov_solve(&ctx, &k, spoil, jacobi, &s, b, x[trusting], &r[trusting]);
            CHECK_INT(status, variant >> 1 ? PD_NOT_CONVERGED : PD_OK);
            CHECK_NEAR(residual_norm(&s, b, x[trusting]), r[trusting].residual, 1e-12 * r[trusting].residual0);
            pd_krylov_free(&ctx, &k);
            CHECK_INT(ctx.in_use, 0);
        }
        CHECK_INT(r[1].iterations, r[0].iterations);
        CHECK_INT(r[1].applies, r[0].applies - !(variant >> 1)); /* no promise without convergence */
        CHECK(memcmp(x[0], x[1], sizeof x[0]) == 0);
    }
}

/* A basis of integers: three digits take as many iterations as in double precision; eleven take restarts. Its entries
 * are right to a share of the largest of 64. One vector of it is half of one of single precision. */
TEST(gmres_integers)
{
    enum { N = 300 };
    double b[N], x[N], own[N];
    for (int i = 0; i < N; i++) {
        b[i] = (1.0 + 0.3 * sin(1.7 * i)) * pow(10.0, -(double)(i / 64));
        own[i] = 2.0 + sin(0.9 * i);
    }
    for (int lean = 0; lean < 2; lean++) {
        int taken[2] = {0, 0};
        size_t bytes[2];
        for (int integers = 0; integers < 2; integers++) {
            pd_ctx ctx;
            pd_krylov k;
            pd_krylov_result r;
            sys s = make(K_DIAGONAL, N);
            pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
            s.d = own;
            pd_ctx_init(&ctx);
            d.restart = 40;
            d.max_vectors = 200;
            d.rtol = 1e-3;
            d.basis_precision = integers ? PD_KRYLOV_INT16 : PD_KRYLOV_SINGLE;
            d.zero_guess = 1;
            d.low_memory = lean;
            d.max_iterations = 4000;
            CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k));
            bytes[integers] = (size_t)k.basis_entries * sizeof *k.compressed_basis;
            CHECK_OK(&ctx, pd_krylov_solve(&ctx, &k, lean ? spoil : multiply, NULL, &s, b, x, &r));
            taken[integers] = r.iterations;
            CHECK_NEAR(residual_norm(&s, b, x), r.residual, 1e-12 * r.residual0);
            CHECK_LE(r.residual, 1e-3 * r.residual0);
            k.desc.rtol = 1e-11;
            CHECK_OK(&ctx, pd_krylov_solve(&ctx, &k, lean ? spoil : multiply, NULL, &s, b, x, &r));
            CHECK_LE(residual_norm(&s, b, x), 1e-11 * r.residual0);
            pd_krylov_free(&ctx, &k);
            CHECK_INT(ctx.in_use, 0);
        }
        CHECK_INT(taken[1], taken[0]);
        CHECK(20 * bytes[1] < 11 * bytes[0]);
    }
}

/* As many iterations as distinct eigenvalues; the last one is a lucky breakdown. */
TEST(gmres_breakdown)
{
    enum { N = 40 };
    double b[N], x[N], d[N];
    for (int values = 1; values <= 4; values++) {
        pd_ctx ctx;
        pd_krylov_result r;
        pd_ctx_init(&ctx);
        for (int i = 0; i < N; i++) {
            d[i] = 1.0 + i % values;
            b[i] = 1.0 + 0.1 * i;
            x[i] = 0.0;
        }
        sys s = make(K_DIAGONAL, N);
        s.d = d;
        pd_krylov_desc desc = describe(PD_KRYLOV_GMRES, N);
        desc.rtol = 1e-12;
        CHECK_OK(&ctx, run(&ctx, &desc, &s, NULL, b, x, &r));
        CHECK_INT(r.iterations, values);
        for (int i = 0; i < N; i++) CHECK_REL(x[i], b[i] / d[i], 1e-11);
    }
}

/* Condition 1e10: a basis that lost its orthogonality would not reach this residual in n steps. */
TEST(gmres_orthogonality)
{
    enum { N = 24 };
    double b[N], x[N], d[N];
    pd_ctx ctx;
    pd_krylov_result r;
    pd_ctx_init(&ctx);
    for (int i = 0; i < N; i++) {
        d[i] = pow(10.0, -10.0 * i / (N - 1));
        b[i] = 1.0;
        x[i] = 0.0;
    }
    sys s = make(K_DIAGONAL, N);
    s.d = d;
    pd_krylov_desc desc = describe(PD_KRYLOV_GMRES, N);
    desc.rtol = 1e-5;
    CHECK_OK(&ctx, run(&ctx, &desc, &s, NULL, b, x, &r));
    CHECK_LE(r.iterations, N + 1);
    CHECK_LE(residual_norm(&s, b, x), 1e-5 * sqrt((double)N));
}

/* Singular: solved when b is in the range, else ended with an iterate no worse than the guess. */
TEST(gmres_singular)
{
    enum { N = 20 };
    double b[N], x[N], d[N];
    for (int consistent = 0; consistent < 2; consistent++) {
        pd_ctx ctx;
        pd_krylov_result r;
        pd_ctx_init(&ctx);
        for (int i = 0; i < N; i++) {
            d[i] = i == 3 ? 0.0 : 1.0 + i;
            b[i] = i == 3 && consistent ? 0.0 : 1.0;
            x[i] = 0.0;
        }
        sys s = make(K_DIAGONAL, N);
        s.d = d;
        pd_krylov_desc desc = describe(PD_KRYLOV_GMRES, N);
        pd_status status = run(&ctx, &desc, &s, NULL, b, x, &r);
        CHECK_INT(status, consistent ? PD_OK : PD_NOT_CONVERGED);
        CHECK_INT(r.converged, consistent);
        CHECK_LE(residual_norm(&s, b, x), consistent ? 1e-8 * r.residual0 : r.residual0);
        for (int i = 0; i < N && consistent; i++) CHECK_NEAR(x[i], i == 3 ? 0.0 : 1.0 / (1.0 + i), 1e-7);
    }
}

/* x.Ax = 0 for every x: BiCGStab breaks down at once and must say so; GMRES needs two steps. */
TEST(skew)
{
    enum { N = 10 };
    double b[N], x[N] = {0.0};
    pd_ctx ctx;
    pd_krylov_result r;
    pd_ctx_init(&ctx);
    sys s = make(K_SKEW, N);
    for (int i = 0; i < N; i++) b[i] = 1.0 + i;
    pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
    CHECK_OK(&ctx, run(&ctx, &d, &s, NULL, b, x, &r));
    CHECK_INT(r.iterations, 2);
    for (int i = 0; i < N; i++) CHECK_NEAR(x[i], i % 2 ? b[i - 1] : -b[i + 1], 1e-11);
    d = describe(PD_KRYLOV_CG, N);
    memset(x, 0, sizeof x);
    CHECK_INT(run(&ctx, &d, &s, NULL, b, x, &r), PD_ERR_DIVERGED);
    CHECK(strstr(ctx.message, "positive definite") != NULL);
}

/* Nonsymmetric: upwind transport with the exact solution put in. */
TEST(transport)
{
    enum { N = 300 };
    double b[N], x[N], exact[N];
    for (int w = 0; w < 3; w++) {
        pd_ctx ctx;
        pd_krylov_result r;
        pd_ctx_init(&ctx);
        sys s = make(K_WIND, N);
        s.wind = w == 0 ? 0.1 : w == 1 ? 1.0 : 10.0;
        for (int i = 0; i < N; i++) exact[i] = sin(0.05 * i) + 0.2 * cos(1.3 * i);
        multiply(&s, exact, b);
        pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
        d.max_iterations = 4000;
        d.rtol = 1e-10;
        d.restart = 60;
        memset(x, 0, sizeof x);
        CHECK_OK(&ctx, run(&ctx, &d, &s, jacobi, b, x, &r));
        CHECK_LE(residual_norm(&s, b, x), 1e-10 * r.residual0);
        CHECK_LE(largest_difference(N, x, exact), 1e-5);
    }
}

TEST(not_a_number)
{
    enum { N = 50 };
    double b[N], x[N];
    for (int m = 0; m < 2; m++)
        for (int when = 0; when < 8; when++) {
            pd_ctx ctx;
            pd_krylov_result r;
            pd_ctx_init(&ctx);
            sys s = make(K_POISSON, N);
            s.poison = when;
            for (int i = 0; i < N; i++) {
                b[i] = 1.0 + i % 3;
                x[i] = 0.01 * i;
            }
            pd_krylov_desc d = describe(methods[m], N);
            /* when 0: the preconditioner is the culprit */
            CHECK_INT(run(&ctx, &d, &s, when ? NULL : broken, b, x, &r), PD_ERR_DIVERGED);
            CHECK(strncmp(ctx.message, "krylov: ", 8) == 0 && strstr(ctx.message, "not finite") != NULL);
            CHECK_INT(r.converged, 0);
            for (int i = 0; i < N; i++) CHECK(fabs(x[i]) < 1e6);
            b[7] = (double)NAN;
            d.equations = "solid";
            CHECK_INT(run(&ctx, &d, &s, NULL, b, x, &r), PD_ERR_ARGUMENT);
            CHECK_STR(ctx.message, "solid: the right-hand side is not finite");
        }
}

/* Stopped early: x is the best iterate and result has its true residual. */
TEST(not_converged)
{
    enum { N = 200 };
    double b[N], x[N];
    uint32_t state = 7;
    for (int i = 0; i < N; i++) b[i] = unit_random(&state);
    for (int m = 0; m < 2; m++) {
        double last = 1e300;
        for (int limit = 1; limit < 40; limit += 3) {
            pd_ctx ctx;
            pd_krylov_result r;
            pd_ctx_init(&ctx);
            sys s = make(K_POISSON, N);
            pd_krylov_desc d = describe(methods[m], N);
            d.max_iterations = limit;
            memset(x, 0, sizeof x);
            CHECK_INT(run(&ctx, &d, &s, NULL, b, x, &r), PD_NOT_CONVERGED);
            CHECK_INT(r.iterations, limit);
            CHECK_REL(r.residual, residual_norm(&s, b, x), 1e-10);
            CHECK_LE(r.residual, r.residual0 * (1.0 + 1e-12));
            /* the best so far can only fall while one recurrence runs; GMRES restarts after 30 */
            CHECK_LE(r.residual, last * (1.0 + 1e-9));
            last = r.residual;
        }
    }
}

TEST(guesses)
{
    enum { N = 80 };
    double b[N], x[N], exact[N];
    for (int m = 0; m < 2; m++) {
        pd_ctx ctx;
        pd_krylov_result plain, flagged, warm, zero;
        pd_ctx_init(&ctx);
        sys s = make(K_POISSON, N);
        for (int i = 0; i < N; i++) {
            b[i] = 1.0;
            exact[i] = 0.5 * (i + 1) * (N - i);
            x[i] = 0.0;
        }
        pd_krylov_desc d = describe(methods[m], N);
        d.restart = N;
        CHECK_OK(&ctx, run(&ctx, &d, &s, NULL, b, x, &plain));
        d.zero_guess = 1;
        for (int i = 0; i < N; i++) x[i] = 1e30;
        CHECK_OK(&ctx, run(&ctx, &d, &s, NULL, b, x, &flagged));
        CHECK_INT(flagged.applies, plain.applies - 1);
        CHECK_INT(flagged.iterations, plain.iterations);
        d.zero_guess = 0;
        CHECK_OK(&ctx, run(&ctx, &d, &s, NULL, b, exact, &warm));
        CHECK_INT(warm.iterations, 0);
        CHECK_INT(warm.applies, 1);
        memset(b, 0, sizeof b); /* b = 0 has the solution 0 for any guess */
        CHECK_OK(&ctx, run(&ctx, &d, &s, NULL, b, x, &zero));
        for (int i = 0; i < N; i++) CHECK(x[i] == 0.0);
        /* an absolute tolerance */
        for (int i = 0; i < N; i++) b[i] = 1.0;
        d.atol = 1.0;
        memset(x, 0, sizeof x);
        CHECK_OK(&ctx, run(&ctx, &d, &s, NULL, b, x, &zero));
        CHECK_LE(zero.residual, 1.0);
        CHECK_LE(zero.iterations, plain.iterations);
    }
}

/* A preconditioner that changes from call to call: only the flexible form keeps its promise. */
TEST(flexible)
{
    enum { N = 100 };
    double b[N], x[N] = {0.0};
    pd_ctx ctx;
    pd_krylov_result r;
    pd_ctx_init(&ctx);
    sys s = make(K_POISSON, N);
    uint32_t state = 3;
    for (int i = 0; i < N; i++) b[i] = unit_random(&state);
    pd_krylov_desc d = describe(PD_KRYLOV_GMRES, N);
    d.flexible = 1;
    d.restart = N;
    d.max_iterations = 2 * N;
    CHECK_OK(&ctx, run(&ctx, &d, &s, restless, b, x, &r));
    CHECK_LE(residual_norm(&s, b, x), 1e-8 * r.residual0);
    CHECK_LE(r.iterations, N + 1); /* full GMRES: the space is exhausted */
    CHECK_INT(r.precond_applies, r.iterations);
}

/* b scaled by a power of two scales x bit for bit: no absolute threshold anywhere. */
TEST(unit_covariance)
{
    enum { N = 90 };
    double b[N], x[N], y[N];
    uint32_t state = 11;
    for (int m = 0; m < 2; m++) {
        pd_ctx ctx;
        pd_krylov_result r, q;
        pd_ctx_init(&ctx);
        sys s = make(K_POISSON, N);
        for (int i = 0; i < N; i++) b[i] = unit_random(&state);
        pd_krylov_desc d = describe(methods[m], N);
        d.restart = N;
        memset(x, 0, sizeof x);
        CHECK_OK(&ctx, run(&ctx, &d, &s, jacobi, b, x, &r));
        for (int i = 0; i < N; i++) b[i] = ldexp(b[i], -130);
        memset(y, 0, sizeof y);
        CHECK_OK(&ctx, run(&ctx, &d, &s, jacobi, b, y, &q));
        CHECK_INT(r.iterations, q.iterations);
        for (int i = 0; i < N; i++) CHECK(y[i] == ldexp(x[i], -130));
    }
}

TEST(threads)
{
    double *b = (double *)calloc(N_MAX, sizeof *b), *x = (double *)calloc(3 * (size_t)N_MAX, sizeof *x);
    uint32_t state = 5;
    if (!CHECK(b && x)) return;
    for (int i = 0; i < N_MAX; i++) b[i] = unit_random(&state);
    for (int m = 0; m < 2; m++) {
        for (int t = 0; t < 3; t++) {
            pd_ctx ctx;
            pd_krylov_result r;
            pd_ctx_init(&ctx);
            ctx.threads = 1 << t;
            sys s = make(K_POISSON, N_MAX);
            pd_krylov_desc d = describe(methods[m], N_MAX);
            d.max_iterations = 12;
            d.zero_guess = 1;
            CHECK_INT(run(&ctx, &d, &s, jacobi, b, x + t * N_MAX, &r), PD_NOT_CONVERGED);
        }
        CHECK(memcmp(x, x + N_MAX, N_MAX * sizeof *x) == 0);
        CHECK(memcmp(x, x + 2 * N_MAX, N_MAX * sizeof *x) == 0);
    }
    free(b);
    free(x);
}

TEST(memory)
{
    enum { N = 40 };
    double b[N], x[N];
    for (int i = 0; i < N; i++) b[i] = x[i] = 1.0;
    for (int m = 0; m < 2; m++) {
        pd_ctx ctx;
        fault c;
        pd_krylov k;
        pd_krylov_desc d = describe(methods[m], N);
        fault_context(&c, 0, 1, &ctx);
        sys s = make(K_POISSON, N);
        CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k));
        long built = c.calls;
        CHECK_OK(&ctx, pd_krylov_solve(&ctx, &k, multiply, jacobi, &s, b, x, NULL));
        CHECK_INT(c.calls, built); /* solve allocates nothing */
        pd_krylov_free(&ctx, &k);
        CHECK_INT(ctx.in_use, 0);
        for (long fail = 1; fail <= built; fail++) {
            c.calls = 0;
            c.fail_at = fail;
            CHECK_INT(pd_krylov_build(&ctx, &d, &k), PD_ERR_MEMORY);
            CHECK_INT(pd_krylov_solve(&ctx, &k, multiply, NULL, &s, b, x, NULL), PD_ERR_ARGUMENT);
            pd_krylov_free(&ctx, &k);
            CHECK_INT(ctx.in_use, 0);
        }
    }
}

/* The nodes of three lines of seven, in two components, in the order of the unknowns. */
static int place(int unknown)
{
    static const int node[10] = {1, 2, 3, 4, 10, 11, 15, 16, 17, 18};
    return unknown / 10 * 21 + node[unknown % 10];
}

static void multiply_placed(void *user, const double *x, double *y)
{
    double in[20], out[20];
    for (int p = 0; p < 20; p++) in[p] = x[place(p)];
    multiply(user, in, out);
    for (int p = 0; p < 20; p++) y[place(p)] = out[p];
}

/* -1 2 -1 on a right-hand side of ones: x_p = (p + 1) (n - p) / 2. What lies between the stretches stays zero. */
TEST(spans)
{
    pd_ctx ctx;
    int32_t first[3] = {1, 10, 15}, start[3] = {0, 4, 6}, length[3] = {4, 2, 4};
    pd_active_ranges spans = {3, 3, first, start, length, 10, 21};
    pd_ctx_init(&ctx);
    for (int variant = 0; variant < 4; variant++) {
        double b[42] = {0.0}, x[42] = {0.0}, between = 0.0;
        sys s = make(K_POISSON, 20);
        pd_krylov k;
        pd_krylov_result r;
        pd_krylov_desc d = describe(PD_KRYLOV_GMRES, 42);
        d.spans = &spans;
        d.components = 2;
        d.basis_precision = variant & 1 ? PD_KRYLOV_SINGLE : PD_KRYLOV_DOUBLE;
        d.flexible = variant >> 1;
        d.rtol = 1e-12;
        d.restart = 20;
        for (int p = 0; p < 20; p++) b[place(p)] = 1.0;
        CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k));
        CHECK_INT((int)k.length, 20);
        CHECK_OK(&ctx, pd_krylov_solve(&ctx, &k, multiply_placed, NULL, &s, b, x, &r));
        for (int p = 0; p < 20; p++) {
            CHECK_NEAR(x[place(p)], 0.5 * (p + 1.0) * (20.0 - p), 1e-9);
            x[place(p)] = 0.0;
        }
        for (int i = 0; i < 42; i++) between = fmax(between, fabs(x[i]));
        CHECK_LE(between, 0.0);
        pd_krylov_free(&ctx, &k);
    }
}

/* -1 2 -1 on entries 3 to 7 alone, the others being zero: x_i = (i - 2) (8 - i) / 2. */
static void multiply_inner(void *user, const double *x, double *y)
{
    ((sys *)user)->calls++;
    for (int i = 3; i < 8; i++) y[i] = 2.0 * x[i] - x[i - 1] - x[i + 1];
}

TEST(range)
{
    static const int64_t bad[5][2] = {{-1, 8}, {3, 11}, {8, 3}, {3, 0}, {4, 4}};
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (int m = 0; m < 2; m++) {
        double b[10] = {0.0}, x[10] = {0.0};
        sys s = make(K_POISSON, 10);
        pd_krylov k, none;
        pd_krylov_desc d = describe(methods[m], 10);
        d.first = 3, d.end = 8, d.rtol = 1e-13;
        for (int i = 3; i < 8; i++) b[i] = 1.0;
        if (!CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k))) return;
        CHECK_OK(&ctx, pd_krylov_solve(&ctx, &k, multiply_inner, NULL, &s, b, x, NULL));
        for (int i = 0; i < 10; i++) CHECK_NEAR(x[i], i < 3 || i > 7 ? 0.0 : 0.5 * (i - 2.0) * (8.0 - i), 1e-12);
        for (int wrong = 0; wrong < 5; wrong++) {
            k.desc.first = d.first = bad[wrong][0];
            k.desc.end = d.end = bad[wrong][1];
            CHECK_INT(pd_krylov_build(&ctx, &d, &none), PD_ERR_ARGUMENT);
            CHECK(strstr(ctx.message, "of 10 entries, expected 0 <= first < end <= n") != NULL);
            s.calls = 0;
            CHECK_INT(pd_krylov_solve(&ctx, &k, multiply_inner, NULL, &s, b, x, NULL), PD_ERR_ARGUMENT);
            CHECK_INT(s.calls, 0);
        }
        pd_krylov_free(&ctx, &k);
    }
}

TEST(bad_input)
{
    pd_ctx ctx;
    pd_krylov k;
    pd_active_ranges spans;
    memset(&spans, 0, sizeof spans);
    spans.total = 21;
    pd_ctx_init(&ctx);
    for (int mistake = 0; mistake < 10; mistake++) {
        pd_krylov_desc d = describe(PD_KRYLOV_GMRES, 10);
        const char *word = "";
        switch (mistake) {
        case 0: d.n = 0, word = "n = 0"; break;
        case 1: d.restart = -1, word = "restart"; break;
        case 2: d.max_iterations = -3, word = "max_iterations"; break;
        case 3: d.rtol = -1e-3, word = "rtol"; break;
        case 4: d.rtol = (double)NAN, word = "rtol"; break;
        case 5: d.atol = -1.0, word = "atol"; break;
        case 6: d.atol = (double)INFINITY, word = "atol"; break;
        case 7: d.method = (pd_krylov_method)9, word = "method 9"; break;
        case 8: d.spans = &spans, d.components = 3, word = "expected 3 times 21"; break;
        default: d.rtol = 1.0, word = "rtol"; break;
        }
        CHECK_INT(pd_krylov_build(&ctx, &d, &k), PD_ERR_ARGUMENT);
        CHECK(strstr(ctx.message, word) != NULL);
        pd_krylov_free(&ctx, &k);
    }
    double b[4] = {1, 1, 1, 1}, x[4] = {0, 0, 0, 0};
    sys s = make(K_POISSON, 4);
    pd_krylov_desc d = describe(PD_KRYLOV_CG, 4);
    x[2] = (double)INFINITY;
    CHECK_INT(run(&ctx, &d, &s, NULL, b, x, NULL), PD_ERR_ARGUMENT);
    CHECK_OK(&ctx, pd_krylov_build(&ctx, &d, &k));
    CHECK_INT(pd_krylov_solve(&ctx, &k, NULL, NULL, &s, b, x, NULL), PD_ERR_ARGUMENT);
    pd_krylov_free(&ctx, &k);
}

TEST_MAIN(ENTRY(poisson_closed_form) ENTRY(gmres_cyclic_shift) ENTRY(gmres_growth) ENTRY(gmres_growth_lent)
              ENTRY(gmres_lean) ENTRY(gmres_trusting) ENTRY(gmres_integers) ENTRY(gmres_breakdown)
                  ENTRY(gmres_orthogonality) ENTRY(gmres_singular) ENTRY(skew) ENTRY(transport) ENTRY(not_a_number)
                      ENTRY(not_converged) ENTRY(guesses) ENTRY(flexible) ENTRY(unit_covariance) ENTRY(threads)
                          ENTRY(memory) ENTRY(spans) ENTRY(range) ENTRY(bad_input))
