/* test_anderson: fixed points of maps from the steps at the last places, against GMRES, the secant method and bounds of
 * contractions.
 * dims: 2 */
#include "random.h"
#include "solve/anderson.h"
#include "test.h"

#define MOST 40

static double matrix[MOST][MOST], side[MOST], answer[MOST];

static void begin(pd_ctx *ctx, int n, pd_anderson *a)
{
    pd_ctx_init(ctx);
    memset(a, 0, sizeof *a);
    a->n = n;
    CHECK_OK(ctx, pdi_array_registry_build(ctx, pdi_anderson_list, a));
}

static void end(pd_ctx *ctx, pd_anderson *a)
{
    pdi_array_registry_free(ctx, pdi_anderson_list, a);
    CHECK_INT(ctx->in_use, 0);
}

static double dot(int n, const double *x, const double *y)
{
    double sum = 0.0;
    for (int k = 0; k < n; k++) sum += x[k] * y[k];
    return sum;
}

static double size_of(int n, const double *x) { return sqrt(dot(n, x, x)); }

static double apart(int n, const double *x, const double *y)
{
    double sum = 0.0;
    for (int k = 0; k < n; k++) sum += (x[k] - y[k]) * (x[k] - y[k]);
    return sqrt(sum);
}

/* The map x -> M x + b: M symmetric with n eigenvalues from low to high, plus `skew` times a random matrix; b for a
 * random fixed point. */
static void linear(int n, double low, double high, double skew, uint32_t *seed)
{
    double way[MOST];
    memset(matrix, 0, sizeof matrix);
    for (int k = 0; k < n; k++) matrix[k][k] = n > 1 ? low + (high - low) * k / (n - 1) : high;
    for (int turn = 0; turn < 3; turn++) { /* reflections on both sides */
        for (int k = 0; k < n; k++) way[k] = random_real(seed);
        double square = dot(n, way, way);
        for (int side_of = 0; side_of < 2; side_of++)
            for (int i = 0; i < n; i++) {
                double sum = 0.0;
                for (int k = 0; k < n; k++) sum += way[k] * (side_of ? matrix[i][k] : matrix[k][i]);
                for (int k = 0; k < n; k++) *(side_of ? &matrix[i][k] : &matrix[k][i]) -= 2.0 * sum / square * way[k];
            }
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) matrix[i][k] += skew * random_real(seed);
    for (int k = 0; k < n; k++) answer[k] = random_real(seed);
    for (int k = 0; k < n; k++) side[k] = answer[k] - dot(n, matrix[k], answer);
}

/* step = g(x) - x */
static void ask(int n, const double *x, double *step)
{
    for (int k = 0; k < n; k++) step[k] = dot(n, matrix[k], x) + side[k] - x[k];
}

/* x [k] and its residual become those of the least residual in x_0 and a space that grows by one direction a call, that
 * of Krylov: b - A x with A = 1 - M. */
typedef struct gmres {
    int n, count;
    double basis[MOST][MOST], way[MOST][MOST], image[MOST][MOST], x[MOST], rest[MOST];
} gmres;

static void gmres_begin(gmres *g, int n, const double *x)
{
    memset(g, 0, sizeof *g);
    g->n = n;
    memcpy(g->x, x, (size_t)n * sizeof *x);
    ask(n, x, g->rest);
    memcpy(g->basis[0], g->rest, sizeof g->rest);
}

static void gmres_next(gmres *g)
{
    int n = g->n, k = g->count++;
    double *v = g->basis[k], *p = g->way[k], *q = g->image[k], length;
    for (int twice = 0; twice < 2; twice++)
        for (int j = 0; j < k; j++) {
            double part = dot(n, g->basis[j], v);
            for (int i = 0; i < n; i++) v[i] -= part * g->basis[j][i];
        }
    length = size_of(n, v);
    for (int i = 0; i < n; i++) v[i] /= length;
    memcpy(p, v, (size_t)n * sizeof *v);
    for (int i = 0; i < n; i++) q[i] = v[i] - dot(n, matrix[i], v);
    if (k + 1 < MOST) memcpy(g->basis[k + 1], q, (size_t)n * sizeof *q);
    for (int twice = 0; twice < 2; twice++)
        for (int j = 0; j < k; j++) {
            double part = dot(n, g->image[j], q);
            for (int i = 0; i < n; i++) {
                q[i] -= part * g->image[j][i];
                p[i] -= part * g->way[j][i];
            }
        }
    length = size_of(n, q);
    for (int i = 0; i < n; i++) {
        q[i] /= length;
        p[i] /= length;
    }
    double part = dot(n, q, g->rest);
    for (int i = 0; i < n; i++) {
        g->x[i] += part * p[i];
        g->rest[i] -= part * q[i];
    }
}

/* Of a linear map each place is that of GMRES and its residual, so that n + 1 steps of n unknowns are all that is
 * needed. Eigenvalues down to -3: the map itself leads away. */
TEST(as_gmres)
{
    static gmres g;
    uint32_t seed = 5;
    double worst = 0.0, left = 0.0;
    for (int n = 1; n <= PD_ANDERSON_HISTORY; n++)
        for (int way = 0; way < 3; way++) {
            static const double low[3] = {-0.5, -3.0, 1.5};
            static const double high[3] = {0.8, 0.5, 4.0};
            pd_ctx ctx;
            pd_anderson a;
            double x[MOST], step[MOST], next[MOST], first[MOST];
            linear(n, low[way], high[way], way == 1 ? 0.02 : 0.0, &seed);
            for (int k = 0; k < n; k++) x[k] = random_real(&seed);
            begin(&ctx, n, &a);
            gmres_begin(&g, n, x);
            double away = apart(n, x, answer);
            ask(n, x, first);
            for (int k = 0; k <= n; k++) {
                ask(n, x, step);
                pdi_anderson_update(&a, x, step);
                if (k) gmres_next(&g);
                for (int i = 0; i < n; i++) next[i] = g.x[i] + g.rest[i];
                worst = fmax(worst, apart(n, x, next) / away);
                CHECK_NEAR(size_of(n, step), size_of(n, g.rest), 1e-8 * size_of(n, first));
                CHECK_INT(a.count, k);
            }
            CHECK_NEAR(a.mixing, 1.0, 0.0); /* it did not come back */
            left = fmax(left, apart(n, x, answer) / away);
            end(&ctx, &a);
        }
    NOTE("off GMRES by %.1e, off the fixed point by %.1e", worst, left);
    CHECK_LE(worst, 1e-8);
    CHECK_LE(left, 1e-8);
}

/* More unknowns than changes that are kept, of a symmetric map with eigenvalues -q to q: no step is longer than q times
 * the one before, and as long as all is kept Chebyshev's bound holds. */
TEST(more_than_is_kept)
{
    const double q = 0.9;
    uint32_t seed = 9;
    pd_ctx ctx;
    pd_anderson a;
    double x[MOST], step[MOST], first = 0.0, last = 0.0, rate = (sqrt(1.9 / 0.1) - 1.0) / (sqrt(1.9 / 0.1) + 1.0);
    linear(MOST, -q, q, 0.0, &seed);
    for (int k = 0; k < MOST; k++) x[k] = random_real(&seed);
    begin(&ctx, MOST, &a);
    for (int k = 0; k < 100; k++) {
        ask(MOST, x, step);
        double size = size_of(MOST, step);
        if (k) CHECK_LE(size, q * last + 1e-14);
        else first = size;
        if (k > 1 && k <= PD_ANDERSON_HISTORY + 1) CHECK_LE(size, q * 2.0 * pow(rate, k - 1) * first);
        last = size;
        CHECK(a.count <= PD_ANDERSON_HISTORY);
        pdi_anderson_update(&a, x, step);
    }
    NOTE("off by %.1e after 100 steps", apart(MOST, x, answer));
    CHECK_LE(apart(MOST, x, answer), 1e-10); /* q^100 = 3e-5 */
    end(&ctx, &a);
}

/* With one unknown it is the secant method, as only the last change has a direction of its own. At the fixed point it
 * stays. */
TEST(secant)
{
    pd_ctx ctx;
    pd_anderson a;
    double x = 0.2, was = 0.0, step_was = 0.0;
    begin(&ctx, 1, &a);
    for (int k = 0; k < 12; k++) {
        double step = cos(x) - x, at = x, here = step, next = x + step;
        if (fabs(step) < 1e-12) break;
        if (k) next = x - step * (x - was) / (step - step_was);
        pdi_anderson_update(&a, &x, &step);
        CHECK_NEAR(x, next, 1e-15 + 1e-3 * fabs(x - at) * fabs(x - at));
        CHECK_NEAR(x, next, 1e-12);
        was = at;
        step_was = here;
    }
    CHECK_NEAR(x, 0.73908513321516064, 1e-12); /* cos x = x */
    for (int k = 0; k < 3; k++) {
        double step = 0.0, at = x;
        pdi_anderson_update(&a, &x, &step);
        CHECK_NEAR(x, at, 0.0);
    }
    end(&ctx, &a);
}

static void bent(int n, const double *x, double *step)
{
    for (int k = 0; k < n; k++) step[k] = 0.7 * cos(x[k]) + 0.25 * sin(x[(k + 1) % n]) + 0.02 * k - x[k];
}

/* A map that bends, and contracts: it is found in a small part of the steps that the map itself needs. */
TEST(bent_map)
{
    enum { N = 8 };
    pd_ctx ctx;
    pd_anderson a;
    double x[N] = {0.0}, plain[N] = {0.0}, step[N];
    int steps[2] = {0, 0};
    for (bent(N, plain, step); size_of(N, step) > 1e-12 && steps[0] < 1000; bent(N, plain, step), steps[0]++)
        for (int k = 0; k < N; k++) plain[k] += step[k];
    begin(&ctx, N, &a);
    for (bent(N, x, step); size_of(N, step) > 1e-12 && steps[1] < 1000; bent(N, x, step), steps[1]++)
        pdi_anderson_update(&a, x, step);
    NOTE("%d steps of %d", steps[1], steps[0]);
    CHECK(2 * steps[1] < steps[0] && steps[0] < 1000);
    for (int k = 0; k < N; k++) CHECK_NEAR(x[k], plain[k], 1e-11);
    end(&ctx, &a);
}

/* After `forget` all is as at first, to the last bit. */
TEST(forgets)
{
    enum { N = 6, STEPS = 9 };
    uint32_t seed = 2;
    pd_ctx ctx;
    pd_anderson a;
    double x[N], step[N], kept[STEPS][N];
    begin(&ctx, N, &a);
    for (int run = 0; run < 2; run++) {
        uint32_t same = 3;
        linear(N, -0.9, 0.9, 0.1, &same);
        for (int k = 0; k < N; k++) x[k] = 1.0 + k;
        for (int k = 0; k < STEPS; k++) {
            ask(N, x, step);
            double first = x[0] + step[0];
            pdi_anderson_update(&a, x, step);
            if (k == 0) CHECK_NEAR(x[0], first, 0.0);
            if (run) CHECK(memcmp(x, kept[k], sizeof x) == 0);
            memcpy(kept[k], x, sizeof x);
        }
        if (run) continue;
        pdi_anderson_reset(&a);
        for (int k = 0; k < 8; k++) { /* another map, which leads astray and comes nearer */
            for (int d = 0; d < N; d++) step[d] = (k < 4 ? k + 1.0 : 0.1 / k) * (2.0 + random_share(&seed));
            pdi_anderson_update(&a, x, step);
        }
        CHECK(a.count > 0 && a.mixing < 1.0);
        pdi_anderson_reset(&a);
    }
    end(&ctx, &a);
}

/* At the fixed point nothing is left of steps but rounding, in directions of its own: the place stays there. */
TEST(stays)
{
    uint32_t seed = 4;
    for (int n = 2; n <= 8; n++) {
        pd_ctx ctx;
        pd_anderson a;
        double x[MOST], step[MOST], way[MOST];
        for (int k = 0; k < n; k++) way[k] = random_real(&seed);
        for (int i = 0; i < n; i++) { /* of rank one: two changes say all */
            side[i] = random_real(&seed);
            for (int k = 0; k < n; k++) matrix[i][k] = 0.7 * way[i] * way[k] / dot(n, way, way);
        }
        for (int i = 0; i < n; i++) answer[i] = side[i] + 0.7 / 0.3 * way[i] * dot(n, way, side) / dot(n, way, way);
        for (int k = 0; k < n; k++) x[k] = random_real(&seed);
        begin(&ctx, n, &a);
        for (int k = 0; k < 40; k++) {
            ask(n, x, step);
            pdi_anderson_update(&a, x, step);
            if (k > 1) CHECK_LE(apart(n, x, answer), 1e-13 * (1.0 + size_of(n, answer)));
        }
        end(&ctx, &a);
    }
}

/* A map that moves all places by the same step up to rounding has no fixed point: the place goes on by that step, and
 * is not where a change by rounding would say. */
TEST(same_step)
{
    pd_ctx ctx;
    pd_anderson a;
    double x[2] = {100.0, 1.0}, step[2];
    begin(&ctx, 2, &a);
    for (int k = 0; k < 50; k++) {
        for (int d = 0; d < 2; d++) step[d] = x[d] + 0.1 - x[d];
        pdi_anderson_update(&a, x, step);
        CHECK_NEAR(x[0], 100.0 + 0.1 * (k + 1), 1e-11);
        CHECK_NEAR(x[1], 1.0 + 0.1 * (k + 1), 1e-11);
    }
    end(&ctx, &a);
}

/* A step of that size; returns 1 when the place is then that of the best step, on by `part` of it. */
static int goes_back(pd_anderson *a, double size, const double *best, double part, double *x)
{
    double step[2] = {0.6 * size, a->previous_norm > 2.5 ? -0.8 * size : 0.8 * size};
    pdi_anderson_update(a, x, step);
    return x[0] == best[0] + part && x[1] == best[1] && a->count == 0;
}

/* Steps that grow twice in turn beyond the least one: the search is back at its place, goes by half of its step, and
 * knows no changes. One that grows once is not astray, and the least step is the last one again. */
TEST(comes_back)
{
    pd_ctx ctx;
    pd_anderson a;
    double x[2] = {1.0, 2.0}, best[2], step[2] = {1.0, 0.0};
    begin(&ctx, 2, &a);
    memcpy(best, x, sizeof x);
    pdi_anderson_update(&a, x, step);
    CHECK(x[0] == 2.0 && x[1] == 2.0);
    CHECK(!goes_back(&a, 3.0, best, 0.5, x)); /* once */
    CHECK(!goes_back(&a, 2.0, best, 0.5, x)); /* none */
    CHECK(!goes_back(&a, 5.0, best, 0.5, x));
    CHECK_NEAR(a.mixing, 1.0, 0.0);
    CHECK(goes_back(&a, 6.0, best, 0.5, x));
    CHECK_NEAR(a.mixing, 0.5, 0.0);
    CHECK(!goes_back(&a, 3.0, best, 0.25, x));
    CHECK_NEAR(a.mixing, 0.5, 0.0);
    CHECK(goes_back(&a, 4.0, best, 0.25, x));
    CHECK_NEAR(a.mixing, 0.25, 0.0);
    end(&ctx, &a);
}

TEST_MAIN(ENTRY(as_gmres) ENTRY(more_than_is_kept) ENTRY(secant) ENTRY(bent_map) ENTRY(forgets) ENTRY(stays)
          ENTRY(same_step) ENTRY(comes_back))
