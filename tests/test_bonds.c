/* bonds: bond-based corrosion.
 * dims: 1 2 3 */
#include "metal_scene.h"
#include <stdlib.h>

static const double pencil_times[3] = {10.0, 100.0, 300.0};
static const double pencil_depths[3] = {24.9218e-6, 78.8095e-6, 136.502e-6}; /* pencil304_stefan.csv */

/* Largest relative error of the depths. */
static double pencil_error(double m, double h, double end, double share)
{
    scene *s = scene_start(1, 2, 2);
    double bottom = 160e-6, worst = 0.0, before = PENCIL_START / (2.0 * PENCIL_LAMBDA);
    int64_t krylov = 0, rounds = 0;
    s->couple_desc.fraction = share;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = h;
        s->grid_desc.hi[d] = d ? 2.0 * h : bottom;
        if (d) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
    }
    s->stencil_desc.m = m;
    s->open[0] = 1;
    half_space(s, PENCIL_START);
    s->desc.activation = 0;
    s->transport_desc.diffusivity = PENCIL_D;
    s->speed = 1e-5;
    if (!scene_build(s)) return NAN;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] == PD_FLUID)
            s->transport.c[i] = CSAT * erf(PENCIL_LAMBDA * x[0] / PENCIL_START) / erf(PENCIL_LAMBDA);
    }
    double solid = pd_dissolve_stock(&s->ctx, &s->dissolve);
    for (int k = 0; k < 3 && pencil_times[k] <= end; k++) {
        double t = pencil_times[k] - before * before / PENCIL_D;
        pd_couple *c = &s->couple;
        while (c->time < t) {
            if (!c->started) if (!CHECK_OK(&s->ctx, pd_couple_start(&s->ctx, c))) return NAN;
            if (!CHECK_OK(&s->ctx, pd_couple_step(&s->ctx, c, t))) return NAN;
            rounds += s->dissolve.rounds;
            if (getenv("TRACE"))
                NOTE("t %g dt %g rounds %d krylov %d next %g", c->time, c->dt, s->dissolve.rounds,
                     c->transport_result.krylov, s->dissolve.next_dt);
        }
        krylov = c->krylov_transport;
        CHECK_LE(s->couple.ledger.relative, 1e-13);
        double depth = bottom - (bottom - PENCIL_START) * pd_dissolve_stock(&s->ctx, &s->dissolve) / solid;
        double error = depth / pencil_depths[k] - 1.0;
        worst = fmax(worst, fabs(error));
        NOTE("m %g, h %.2f um, t %g s: depth %.3f um (%+.2f %%), %d steps, %.1f rounds and %.1f iterations a step", m,
             1e6 * h, pencil_times[k], 1e6 * depth, 100.0 * error, (int)c->steps, (double)rounds / (double)c->steps,
             (double)krylov / (double)c->steps);
    }
    scene_free(s);
    return worst;
}

/* Depths at 10, 100 and 300 s, of first order in the spacing: fluid beside the front is at Csat one cell early. */
TEST(pencil_electrode)
{
    for (int m = 1; m <= (PD_DIM == 1 ? 3 : 1); m += 2) {
        double coarse = pencil_error((double)m, 4e-6, PD_DIM == 1 ? 300.0 : 10.0, 0.2);
        double fine = pencil_error((double)m, 2e-6, PD_DIM == 1 ? 300.0 : 10.0, 0.2);
        CHECK_LE(coarse, 0.15);
        CHECK_LE(fine, 0.6 * coarse);
        if (PD_DIM > 1) continue;
        CHECK_LE(pencil_error((double)m, 0.5e-6, 300.0, 0.2), 0.3 * fine);
        /* steps twice as long */
        CHECK_NEAR(pencil_error((double)m, 2e-6, 300.0, 0.4), fine, 5e-3);
    }
}

TEST_MAIN(ENTRY(pencil_electrode))
