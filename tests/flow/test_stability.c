/* test_stability: the longest stable step of a flow with sound against a search of its waves, by many more wave vectors
 * and with the eigenvalues of (3.38) from complex roots.
 * dims: 1 2 3 */
#include <complex.h>
#include "fixture.h"
#include "flow/stability.h"

static scene test_scene;
static pd_stability spectrum;

/* |1 + z + z^2/2 + z^3/6| <= 1. */
static int stable(double complex z)
{
    if (creal(z) > 0.0) z -= creal(z);
    return cabs(1.0 + z * (1.0 + z * (0.5 + z / 6.0))) <= 1.0 + 1e-10;
}

static void lower(double complex eigenvalue, double *dt)
{
    double low = 0.0, high = *dt;
    if (stable(eigenvalue * *dt)) return;
    while (high - low > 1e-9 * high) {
        double middle = 0.5 * (low + high);
        if (stable(eigenvalue * middle)) low = middle;
        else high = middle;
    }
    *dt = low;
}

/* The least over `count` wave numbers an axis, from 0 to pi, by the sums over all bonds. */
static double searched(const pd_stencil *s, const pdi_stability_state *q, int count)
{
    int n[3] = {0, 0, 0}, end[3] = {count, PD_DIM > 1 ? count : 1, PD_DIM > 2 ? count : 1};
    double dt = 1e300;
    for (n[2] = 0; n[2] < end[2]; n[2]++)
        for (n[1] = 0; n[1] < end[1]; n[1]++)
            for (n[0] = 0; n[0] < end[0]; n[0]++) {
                double square = 0.0, along = 0.0, l = 0.0, g[3] = {0.0, 0.0, 0.0}, flux[3] = {0.0, 0.0, 0.0}, damp;
                for (int b = 0; b < s->count; b++) {
                    double phase = 0.0;
                    for (int d = 0; d < PD_DIM; d++)
                        phase += 3.14159265358979324 * n[d] / (count - 1) * s->offset[b * PD_DIM + d];
                    l += s->laplacian_weight[b] * (1.0 - cos(phase));
                    for (int d = 0; d < PD_DIM; d++) g[d] += s->gradient_weight[b * PD_DIM + d] * sin(phase);
                    for (int d = 0; d < PD_DIM; d++)
                        flux[d] += 0.5 * s->laplacian_weight[b] * s->xi[b * PD_DIM + d] * sin(phase);
                }
                damp = l;
                for (int d = 0; d < PD_DIM; d++) {
                    square += g[d] * g[d];
                    along += fabs(g[d]) * q->max_velocity[d];
                    damp -= flux[d] * g[d];
                }
                double v = q->viscosity * l, t = q->stabilisation * damp;
                for (int streams = 0; streams < 2; streams++) {
                    double stream = streams ? along : 0.0;
                    double complex sum = v + t,
                                   product = v * t + square * q->sound_speed * q->sound_speed + I * 0.5 * stream * t;
                    double complex root = csqrt(sum * sum - 4.0 * product);
                    lower(-I * stream + 0.5 * (-sum + root), &dt);
                    lower(-I * stream + 0.5 * (-sum - root), &dt);
                    lower(-I * stream - v, &dt);
                }
            }
    return dt;
}

/* No longer than what is stable, and shorter by its margin of 2 % alone. */
static void longest(double m, int states)
{
    scene *s = &test_scene;
    double h[3] = {0.1, 0.07, 0.13};
    uint32_t random = 3;
    double worst = 0.0, least = 1.0;
    scene_box(s, m, 0.1, 12, 12, 12);
    for (int d = 0; d < PD_DIM; d++) {
        s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
        s->stencil_desc.h[d] = h[d];
        s->grid_desc.hi[d] = 12.0 * h[d];
    }
    s->with = WITH_FLOW;
    s->flow_desc.rho = s->flow_desc.mu = s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    if (!scene_build(s) || !CHECK_OK(&s->ctx, pdi_stability_build(&s->ctx, &s->flow, &spectrum))) return;
    for (int k = 0; k < states; k++) {
        pdi_stability_state q;
        memset(&q, 0, sizeof q);
        q.sound_speed = pow(10.0, 2.0 * random_share(&random) - 1.0);
        q.viscosity = pow(10.0, 4.0 * random_share(&random) - 4.0);
        q.stabilisation = k % 4 ? pow(10.0, 4.0 * random_share(&random) - 4.0) : 0.0;
        for (int d = 0; d < PD_DIM; d++) q.max_velocity[d] = k % 3 ? q.sound_speed * random_share(&random) : 0.0;
        double found = pdi_stability_compute_limit(&spectrum, &q);
        double wanted = searched(&s->stencil, &q, PD_DIM == 1 ? 2001 : PD_DIM == 2 ? 121 : 25);
        CHECK_LE(found, wanted);
        CHECK_LE(0.98 * wanted, found * (1.0 + (PD_DIM == 3 ? 5e-3 : 1e-3)));
        /* Halvings between the waves come to the worst: each has a quarter of the error of the one before. */
        if (PD_DIM == 1 && m > 1.0) CHECK_LE(found, 0.98 * wanted * (1.0 + 1e-5));
        worst = fmax(worst, found / wanted);
        least = fmin(least, found / wanted);
    }
    NOTE("m = %g: %.6f to %.6f of the longest stable step", m, least, worst);
    pdi_stability_free(&s->ctx, &spectrum);
    scene_free(s);
}

TEST(longest_steps)
{
    longest(1.0, 40);
    for (int m = 2; m <= 5 && PD_DIM == 1; m++) longest(m, 16); /* the search has too few waves in more dimensions */
}

TEST_MAIN(ENTRY(longest_steps))
