/* steep: explicit steps of a staircase keep the bounds of each node's own surroundings, not those of the field alone.
 * dims: 1 2 3 */
#include "fixture.h"
#include "transport/explicit.h"

#define CELLS 60
#define SPEED 2.0 /* [m/s] */

static scene test_scene;

/* Stairs of seven nodes each, up and down again, of unequal heights. */
static double stairs(int i)
{
    static const double height[] = {0.0, 1.0, 1.5, 4.0, 4.1, 3.0, 0.5, 0.0, 0.0};
    return height[i / 7 % 9];
}

/* A uniform stream along an axis of a periodic box carries stairs across it, without diffusion. */
static int stairs_build(scene *s, double speed, int shift)
{
    scene_box(s, 1.0, 1.0 / CELLS, CELLS, 4, 4);
    for (int d = 0; d < 2 * PD_DIM; d++) s->grid_desc.side[d] = PD_SIDE_PERIODIC;
    s->with = WITH_TRANSPORT | WITH_FLOW;
    s->flow_desc.rho = s->flow_desc.mu = s->flow_desc.report_length = 1.0;
    s->flow_desc.report_speed = SPEED;
    s->transport_desc.diffusivity = 0.0;
    if (!scene_build(s)) return 0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        int at[3];
        pd_grid_index(&s->grid, i, at);
        s->flow.u[i] = speed;
        if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = stairs((at[0] + shift) % CELLS);
    }
    pdi_flow_update_derived_fields(&s->ctx, &s->flow);
    return 1;
}

static double along(const scene *s, const double *c, int i)
{
    int at[3] = {0, 1, 1};
    at[0] = (i + CELLS) % CELLS;
    return c[pd_grid_node(&s->grid, at)];
}

/* 1: the five values around node i rise or fall all the way. */
static int monotone(const scene *s, const double *c, int i)
{
    int up = 1, down = 1;
    for (int k = -2; k < 2; k++) {
        double step = along(s, c, i + k + 1) - along(s, c, i + k);
        up = up && step >= 0.0;
        down = down && step <= 0.0;
    }
    return up || down;
}

/* By (6.18) the value at the middle of a bond of a monotone field is between those of its ends, and goes on by no more
 * than four times the rise behind it. Steps of a fifth of a cell then end between a node and the one behind it. */
TEST(stairs_keep_their_own_bounds)
{
    for (int turn = 0; turn < 2; turn++) {
        scene *s = &test_scene;
        double before[CELLS], sum = 0.0, after = 0.0, dt = 0.1999 / CELLS / SPEED, worst = 0.0;
        int checked = 0, behind = turn ? 1 : -1;
        if (!stairs_build(s, turn ? -SPEED : SPEED, 0)) return;
        CHECK_LE(dt, pd_transport_limit(&s->ctx, &s->transport));
        for (int i = 0; i < CELLS; i++) sum += along(s, s->transport.c, i);
        for (int step = 0; step < 100; step++) {
            int is[CELLS];
            for (int i = 0; i < CELLS; i++) {
                before[i] = along(s, s->transport.c, i);
                is[i] = monotone(s, s->transport.c, i);
            }
            if (!CHECK_OK(&s->ctx, pd_transport_explicit(&s->ctx, &s->transport, dt))) return;
            for (int i = 0; i < CELLS; i++) {
                double a = before[i], b = before[(i + behind + CELLS) % CELLS], now = along(s, s->transport.c, i);
                if (!is[i] || !is[(i + behind + CELLS) % CELLS]) continue;
                worst = fmax(worst, fmax(fmin(a, b) - now, now - fmax(a, b)));
                checked++;
            }
        }
        for (int i = 0; i < CELLS; i++) after += along(s, s->transport.c, i);
        NOTE("stream %d: %d values, beyond their bounds by %.2g at most", turn, checked, worst);
        CHECK_LE(3000, checked);
        CHECK_LE(worst, 1e-14);
        CHECK_NEAR(after, sum, 1e-12 * sum);
        scene_free(s);
    }
}

/* In a periodic box stairs that begin elsewhere are the same ones, whatever cell the box begins in. */
TEST(stairs_over_the_sides)
{
    static double first[CELLS];
    for (int shift = 0; shift < CELLS; shift += 7) {
        scene *s = &test_scene;
        if (!stairs_build(s, SPEED, shift)) return;
        for (int k = 0; k < 12; k++)
            CHECK_OK(&s->ctx, pd_transport_explicit(&s->ctx, &s->transport, 0.2 / (CELLS * SPEED)));
        for (int i = 0; i < CELLS; i++) {
            if (shift == 0) first[i] = along(s, s->transport.c, i);
            CHECK_NEAR(along(s, s->transport.c, i - shift), first[i], 1e-14);
        }
        scene_free(s);
    }
}

#if PD_DIM > 1
/* Stairs that are shifted from row to row, between mirrors, and the same beside their images in a periodic box: bonds
 * that cross a mirror bring as much. */
TEST(stairs_beside_mirrors)
{
    static double first[CELLS * 4];
    for (int whole = 0; whole < 2; whole++) {
        scene *s = &test_scene;
        double most = 0.0;
        scene_box(s, 1.0, 1.0 / CELLS, CELLS, whole ? 8 : 4, 4);
        for (int d = 0; d < 2 * PD_DIM; d++) s->grid_desc.side[d] = PD_SIDE_PERIODIC;
        if (!whole) s->grid_desc.side[2] = s->grid_desc.side[3] = PD_SIDE_MIRROR;
        s->with = WITH_TRANSPORT | WITH_FLOW;
        s->flow_desc.rho = s->flow_desc.mu = s->flow_desc.report_length = 1.0;
        s->flow_desc.report_speed = SPEED;
        if (!scene_build(s)) return;
        for (int32_t i = 0; i < s->grid.total; i++) {
            int at[3];
            pd_grid_index(&s->grid, i, at);
            s->flow.u[i] = SPEED;
            int row = at[1] < 4 ? at[1] : 7 - at[1];
            if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = stairs((at[0] + 5 * row) % CELLS);
        }
        pdi_flow_update_derived_fields(&s->ctx, &s->flow);
        for (int k = 0; k < 12; k++)
            CHECK_OK(&s->ctx, pd_transport_explicit(&s->ctx, &s->transport, 0.2 / (CELLS * SPEED)));
        for (int j = 0; j < 4; j++)
            for (int i = 0; i < CELLS; i++) {
                int at[3] = {0, 0, 1};
                at[0] = i;
                at[1] = j;
                double value = s->transport.c[pd_grid_node(&s->grid, at)];
                if (whole) most = fmax(most, fabs(value - first[j * CELLS + i]));
                first[j * CELLS + i] = value;
            }
        CHECK_LE(most, 1e-13);
        scene_free(s);
    }
}
#define MIRRORS ENTRY(stairs_beside_mirrors)
#else
#define MIRRORS
#endif

TEST_MAIN(MIRRORS ENTRY(stairs_over_the_sides) ENTRY(stairs_keep_their_own_bounds))
