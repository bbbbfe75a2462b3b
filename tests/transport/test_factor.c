/* factor: the factored matrix of Newton's method of limited transport, from one end of the stream and from both; and
 * what takes its place where it fails.
 * dims: 2 */
#include "channel_scene.h"

#define H 1e-5 /* [m] */
#define BAR 0.3, 0.45, 1.0 /* the bar, and what flows beside the plume */

static scene *channel_build(const channel *of)
{
    static const double h[2] = {H, H};
    return channel_flow(of, h, 1.0, 1.0);
}

/* One step of a way through from a channel of 1, into `out` [total] with what the step leaves undone behind it.
 * iterations: of a linear solve, 0: as many as it takes. */
static pd_status step(scene *s, double peclet, int threads, int iterations, double *out, pd_transport_result *result,
                      double *balance)
{
    pd_transport t;
    pd_transport_desc desc;
    double dt = channel_now.length * H / s->mean, had = 0.0, has = 0.0;
    int volume = 0;
    memset(&t, 0, sizeof t);
    memset(&desc, 0, sizeof desc);
    desc.diffusivity = s->mean * H / peclet;
    desc.entering = plume;
    desc.initial = 1.0;
    desc.user = s;
    s->ctx.threads = threads;
    if (!CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, &s->flow, &desc, &t))) return PD_ERR_STATE;
    if (iterations) t.krylov.desc.max_iterations = iterations;
    pd_status status = pd_transport_implicit(&s->ctx, &t, dt, result);
    CHECK(status >= 0);
    CHECK_INT(t.krylov.chunk_count, 0);
    for (int32_t i = 0; i < s->grid.total; i++) {
        out[i] = out[s->grid.total + i] = 0.0;
        if (s->grid.kind[i] != PD_FLUID) continue;
        out[i] = t.c[i];
        out[s->grid.total + i] = t.carry[i];
        had += 1.0;
        has += t.c[i] + t.carry[i];
        volume++;
    }
    /* a bond's volume is that of a cell */
    *balance = ((has - had) * s->stencil.volume - dt * (t.inflow - t.outflow)) / (volume * s->stencil.volume);
    pd_transport_free(&s->ctx, &t);
    return status;
}

/* Both ends of the stream are eliminated at once where columns are many, in any direction: a linear system takes a few
 * iterations, threads change no bit, and amounts are kept. */
TEST(streams_in_all_directions)
{
    static const channel cases[] = {{0, 0, 96, 16, BAR}, {0, 1, 96, 16, BAR}, {1, 0, 96, 16, BAR}, {1, 1, 96, 16, BAR},
                                    {0, 0, 32, 16, BAR}};
    for (int k = 0; k < 5; k++) {
        scene *s = channel_build(cases + k);
        if (!s) return;
        int64_t total = s->grid.total;
        for (double peclet = 10.0; peclet < 1e7; peclet *= 1e5) {
            pd_transport_result result[2];
            double *out = (double *)calloc((size_t)(4 * total), sizeof *out), balance[2];
            if (!CHECK(out != NULL)) return;
            for (int threads = 1; threads < 3; threads++)
                CHECK_INT(step(s, peclet, threads, 0, out + 2 * total * (threads - 1), result + threads - 1,
                               balance + threads - 1), PD_OK);
            NOTE("axis %d, down %d, %d columns, Pe = %g: %d iterations of %d systems, balance %.2g", channel_now.axis,
                 channel_now.down, channel_now.length, peclet, result[0].krylov, result[0].limiter, balance[0]);
            CHECK_LE(result[0].krylov, 5.0 * result[0].limiter);
            CHECK_INT(memcmp(out, out + 2 * total, 2 * (size_t)total * sizeof *out), 0);
            CHECK_LE(fabs(balance[0]), 1e-12);
            for (int64_t i = 0; i < total; i++)
                if (s->grid.kind[i] == PD_FLUID) CHECK(out[i] >= 1.0 - 1e-9 && out[i] <= 2.0 + 1e-9);
            free(out);
        }
        scene_free(s);
    }
}

/* What walls hold: a wave along the stream. */
static double held(void *user, const double *x)
{
    (void)user;
    return 2.0 + 1.5 * sin(x[channel_now.axis] / (7.0 * H));
}

/* What solving with the factors of the derivative along x leaves of x, at the fluid nodes beside walls and at all
 * others: the largest difference over the largest x. */
static int factor_error(scene *s, double *error)
{
    const double rate = 1e4, least = 1e-4;
    pd_transport_desc desc;
    pd_transport t;
    int32_t total = s->grid.total;
    double *x = (double *)calloc((size_t)(6 * total), sizeof *x), *y = x + total, *by = y + total, *slope = by + total;
    double *along = slope + 2 * total;
    memset(&t, 0, sizeof t);
    memset(&desc, 0, sizeof desc);
    desc.diffusivity = s->mean * H / 100.0;
    desc.entering = plume;
    desc.initial = 1.0;
    desc.held = held;
    desc.user = s;
    if (!CHECK(x != NULL)) return 0;
    if (!CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, &s->flow, &desc, &t))) return 0;
    for (int32_t i = 0; i < total; i++)
        if (s->grid.kind[i] == PD_FLUID) {
            t.c[i] = 1.5 + sin(0.7 * i) * 0.5;
            x[i] = 1.0 + 0.5 * cos(1.3 * i);
        }
    CHECK_OK(&s->ctx, pdi_transport_hold(&s->ctx, &t));
    CHECK_OK(&s->ctx, pdi_flux_refresh(&s->ctx, &t.flux));
    t.size = 1.0;
    pdi_transport_anti(&s->ctx, &t, t.c, t.anti);
    pdi_krylov_set_flexible(&t.krylov, 0);
    pdi_factor_lend(&s->ctx, &t.own, &t.krylov, &t.factors);
    if (!CHECK(t.factors.entry != NULL)) return 0;
    pdi_factor_make(&s->ctx, &t.factors, t.c, rate, least);
    CHECK_INT(t.factors.good, 1);
    pd_ghosts_set_scalar(&s->bonds.ghosts, x);
    t.flux.rate = rate;
    pdi_flux_apply(&s->ctx, &t.flux, x, y);
    pdi_limiter_derive(&s->ctx, &t.limiter, t.c, x, least, by, slope);
    pdi_flux_anti_by(&s->ctx, &t.flux, t.c, x, by, slope, along);
    for (int32_t i = 0; i < total; i++) y[i] = s->grid.kind[i] == PD_FLUID ? y[i] - along[i] : 0.0;
    pdi_factor_solve(&s->ctx, &t.factors, y, along);
    error[0] = error[1] = 0.0;
    for (int32_t i = 0; i < total; i++)
        if (s->grid.kind[i] == PD_FLUID) {
            double *to = error + !(t.diffusion.wall_rate[i] > 0.0);
            *to = fmax(*to, fabs(along[i] - x[i]) / 1.5);
        }
    CHECK_OK(&s->ctx, pdi_factor_return(&s->ctx, &t.own, PD_OK, &t.krylov, &t.factors));
    pdi_krylov_set_flexible(&t.krylov, 1);
    CHECK_OK(&s->ctx, pdi_transport_release(&s->ctx, &t, PD_OK));
    pd_transport_free(&s->ctx, &t);
    free(x);
    return 1;
}

/* The factors are those of the derivative beside walls that hold a concentration, too. */
TEST(walls_that_hold_are_in_the_factors)
{
    static const channel cases[] = {{0, 0, 96, 16, BAR}, {1, 1, 48, 16, BAR}};
    for (int k = 0; k < 2; k++) {
        double error[2];
        scene *s = channel_build(cases + k);
        if (!s || !factor_error(s, error)) return;
        NOTE("off by %.2g beside walls, by %.2g elsewhere", error[0], error[1]);
        CHECK_LE(error[0], k ? 0.02 : 6e-3); /* what elimination leaves out */
        CHECK_LE(error[1], k ? 0.02 : 6e-3);
        scene_free(s);
    }
}

/* Where GMRES may not take the iterations that it needs, neither with the factors nor with the cycle, steps are those
 * of an M-matrix: the field keeps its bounds, and amounts are kept with what the step has left undone. */
TEST(solves_that_fail_keep_amounts_and_bounds)
{
    static const channel of = {0, 0, 96, 16, BAR};
    scene *s = channel_build(&of);
    if (!s) return;
    double *out = (double *)calloc((size_t)(4 * s->grid.total), sizeof *out), *best = out + 2 * s->grid.total, balance;
    pd_transport_result result;
    if (!CHECK(out != NULL)) return;
    CHECK_INT(step(s, 1e3, 1, 0, best, &result, &balance), PD_OK);
    int systems = result.limiter;
    for (int most = 1; most < 6; most += 2) {
        double off = 0.0;
        pd_status status = step(s, 1e3, 1, most, out, &result, &balance);
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            off = fmax(off, fabs(out[i] - best[i]));
            CHECK(out[i] >= 1.0 - 1e-9 && out[i] <= 2.0 + 1e-9);
        }
        NOTE("%d iterations at most: status %d, %d systems in place of %d, off by %.2g, balance %.2g", most,
             (int)status, result.limiter, systems, off, balance);
        CHECK_LE(fabs(balance), 1e-12);
        CHECK(result.limiter == 30 || off < 1e-6); /* as many as a step takes */
        CHECK_LE(off, 1e-4);
    }
    free(out);
    scene_free(s);
}

/* A matrix without pivots is not factored. */
TEST(no_pivot_no_factors)
{
    static const channel of = {0, 0, 32, 16, BAR};
    pd_transport_desc desc;
    pd_transport t;
    scene *s = channel_build(&of);
    if (!s) return;
    memset(&t, 0, sizeof t);
    memset(&desc, 0, sizeof desc);
    desc.diffusivity = 1e-9;
    desc.inlet = 1.0;
    if (!CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, &s->flow, &desc, &t))) return;
    CHECK_OK(&s->ctx, pdi_transport_hold(&s->ctx, &t));
    CHECK_OK(&s->ctx, pdi_flux_refresh(&s->ctx, &t.flux));
    t.size = 1.0;
    pdi_transport_anti(&s->ctx, &t, t.c, t.anti);
    pdi_krylov_set_flexible(&t.krylov, 0);
    pdi_factor_lend(&s->ctx, &t.own, &t.krylov, &t.factors);
    CHECK(t.factors.entry != NULL);
    pdi_factor_make(&s->ctx, &t.factors, t.c, 1.0, 1e-4);
    CHECK_INT(t.factors.good, 1);
    pdi_factor_make(&s->ctx, &t.factors, t.c, (double)NAN, 1e-4);
    CHECK_INT(t.factors.good, 0);
    pdi_factor_make(&s->ctx, &t.factors, t.c, 1e300, 1e-4);
    CHECK_INT(t.factors.good, 0);
    CHECK_OK(&s->ctx, pdi_factor_return(&s->ctx, &t.own, PD_OK, &t.krylov, &t.factors));
    pdi_krylov_set_flexible(&t.krylov, 1);
    CHECK_OK(&s->ctx, pdi_transport_release(&s->ctx, &t, PD_OK));
    pd_transport_free(&s->ctx, &t);
    scene_free(s);
}

TEST_MAIN(ENTRY(streams_in_all_directions) ENTRY(walls_that_hold_are_in_the_factors)
          ENTRY(solves_that_fail_keep_amounts_and_bounds) ENTRY(no_pivot_no_factors))
