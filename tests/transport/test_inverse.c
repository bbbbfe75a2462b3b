/* test_inverse: the preconditioner of transport at rest, against the symbols of the lattice and by what it costs.
 * dims: 1 2 3 */
#include "fixture.h"
#include <math.h>

static const double pi = 3.14159265358979323846;

static scene test_scene;

/* Symbols of the wide and of the compact Laplacian for a wave of k [rad] a cell along each axis. */
static void symbols(const pd_stencil *s, const double *k, double *wide, double *compact)
{
    *wide = *compact = 0.0;
    for (int b = 0; b < s->count; b++) {
        double phase = 0.0;
        for (int d = 0; d < PD_DIM; d++) phase += k[d] * s->offset[b * PD_DIM + d];
        *wide += s->laplacian_weight[b] * (1.0 - cos(phase));
    }
    for (int d = 0; d < PD_DIM; d++) *compact += 2.0 / (s->h[d] * s->h[d]) * (1.0 - cos(k[d]));
}

/* Largest over least eigenvalue of A^-1 of (6.22) times the wide operator, over all waves of n cells; mu over D. */
static double spread(const pd_stencil *s, double excess, double mu)
{
    int n = PD_DIM == 3 ? 8 : 24, waves = 1;
    double least = HUGE_VAL, most = 0.0, share = 1.0 / (1.0 + mu * excess);
    for (int d = 0; d < PD_DIM; d++) waves *= n;
    for (int w = 0; w < waves; w++) {
        double k[PD_DIM], wide, compact;
        for (int d = 0, left = w; d < PD_DIM; d++, left /= n) k[d] = pi * (left % n + 0.5) / n;
        symbols(s, k, &wide, &compact);
        double value = (mu + wide) * share * (excess + share / (share * mu + compact));
        least = fmin(least, value);
        most = fmax(most, value);
    }
    return most / least;
}

/* With the excess the ratio stays below 1.6 for every horizon and length of a step, on even spacings; without it, it
 * grows with the square of the horizon. */
TEST(waves)
{
    for (double m = 1.0; m <= (PD_DIM == 3 ? 4.0 : 6.0); m += 0.5) {
        pd_ctx ctx;
        pd_stencil s;
        pd_stencil_desc desc;
        pd_ctx_init(&ctx);
        memset(&desc, 0, sizeof desc);
        desc.m = m;
        for (int d = 0; d < PD_DIM; d++) desc.h[d] = 1e-5;
        if (!CHECK_OK(&ctx, pd_stencil_build(&ctx, &desc, &s))) return;
        double excess = pdi_compact_operator_inverse_excess(&s), low = 1e-3 / (s.h[0] * s.h[0]);
        NOTE("m = %g: %.2f, with the excess %.2f", m, spread(&s, 0.0, low), spread(&s, excess, low));
        CHECK(excess >= 0.0);
        for (double mu = 1e-6; mu < 1e7; mu *= 10.0) {
            double with = spread(&s, excess, mu / (s.h[0] * s.h[0]));
            CHECK(with < 1.6);
            CHECK(with <= spread(&s, 0.0, mu / (s.h[0] * s.h[0])) * (1.0 + 1e-12));
        }
        pd_stencil_free(&ctx, &s);
    }
}

/* Iterations of a step of `cells` times the time in which a cell exchanges its content, from a field without order
 * beside a ball; the step is exact to its tolerance. */
static int iterations(double m, double cells)
{
    scene *s = &test_scene;
    uint32_t random = 7;
    int n = PD_DIM == 3 ? 20 : 40;
    scene_box(s, m, 1e-5, n, n, n);
    s->shapes[0].type = PD_SHAPE_BALL;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = (0.5 * n + 0.3) * 1e-5;
    s->shapes[0].radius = 0.2 * n * 1e-5;
    s->grid_desc.solid = s->shapes;
    s->with = WITH_TRANSPORT;
    s->transport_desc.diffusivity = 1e-9;
    s->transport_desc.tolerance = 1e-9;
    if (!scene_build(s)) return 1000;
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = random_share(&random);
    int fine = CHECK_OK(&s->ctx, pd_transport_implicit(&s->ctx, &s->transport, cells * 0.1, &s->result));
    CHECK(s->result.residual <= 1e-9);
    int krylov = s->result.krylov;
    scene_free(s);
    return fine ? krylov : 1000;
}

/* Nine digits at nearly the same cost, whatever the horizon is. */
TEST(iterations_of_any_horizon)
{
    for (double cells = 1.0; cells < 1e5; cells *= 100.0) {
        int least = 1000, most = 0;
        for (double m = 1.0; m <= (PD_DIM == 3 ? 3.0 : 6.0); m += 1.0) {
            int found = iterations(m, cells);
            least = found < least ? found : least;
            most = found > most ? found : most;
        }
        NOTE("steps of %g: %d to %d", cells, least, most);
        CHECK(most <= 30);
    }
}

TEST_MAIN(ENTRY(waves) ENTRY(iterations_of_any_horizon))
