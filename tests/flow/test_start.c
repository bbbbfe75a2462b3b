/* test_start: implicit flow that starts from rest in a channel with an inlet, at all speeds and scales.
 * dims: 1 2 3 */
#include "test.h"
#include "implicit_scene.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

typedef struct channel {
    double height, speed; /* [m] [m/s], water */
    double m;
    int cells, lengths;   /* across; of the box in heights */
    int body;             /* a cylinder in the middle */
} channel;

/* Parabola across y, as wide along z. */
static void entering(void *user, const double *x, double *u)
{
    const channel *c = (const channel *)user;
    double y = PD_DIM > 1 ? x[PD_DIM > 1 ? 1 : 0] / c->height : 0.0;
    for (int d = 0; d < PD_DIM; d++) u[d] = 0.0;
    u[0] = PD_DIM > 1 ? 6.0 * c->speed * y * (1.0 - y) : c->speed;
}

static int channel_build(scene *s, const channel *c, double rtol)
{
    static pd_shape body;
    pd_grid_desc *grid = &s->grid_desc;
    memset(s, 0, sizeof *s);
    pd_ctx_init(&s->ctx);
    s->ctx.threads = 1;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = c->height / c->cells;
        grid->hi[d] = c->height * (d == 0 ? c->lengths : 1.0);
        grid->side[2 * d] = grid->side[2 * d + 1] = d == 2 ? PD_SIDE_MIRROR : PD_SIDE_WALL;
    }
    if (PD_DIM == 3) grid->hi[PD_DIM - 1] = 4.0 * s->stencil_desc.h[0];
    s->stencil_desc.m = c->m;
    grid->side[0] = PD_SIDE_INLET;
    grid->side[1] = PD_SIDE_OUTLET;
    memset(&body, 0, sizeof body);
    body.type = PD_SHAPE_BALL;
    body.a[0] = 0.5 * c->lengths * c->height;
    body.a[PD_DIM > 1 ? 1 : 0] = 0.5 * c->height;
    body.radius = 0.2 * c->height;
    if (PD_DIM == 3) body.a[PD_DIM - 1] = 0.0;
    if (c->body) {
        grid->shapes = &body;
        grid->wall = &body;
    }
    s->flow_desc.rho = 1000.0;
    s->flow_desc.mu = 1e-3;
    s->flow_desc.report_speed = c->speed;
    s->flow_desc.report_length = c->height;
    s->flow_desc.inlet = entering;
    s->flow_desc.inlet_user = (void *)(size_t)c;
    s->desc.rtol = rtol;
    return scene_build(s);
}

/* What passes the planes of the box over what enters it, at its worst. */
static double leak(scene *s, const channel *c)
{
    double worst = 0.0, wide = 1.0;
    for (int d = 1; d < PD_DIM; d++) wide *= s->grid.hi[d] - s->grid.lo[d];
    for (int k = 1; k < s->grid.n[0]; k++)
        worst = fmax(worst, fabs(pd_flow_integrate_section(&s->ctx, &s->flow, 0, k) / (c->speed * wide) -
                                 pd_flow_integrate_section(&s->ctx, &s->flow, 0, 1) / (c->speed * wide)));
    return worst;
}

/* From rest to `viscous` times of H^2/nu, or `share` of that in which the fluid passes a height. */
static int run(scene *s, const channel *c, double viscous, double share)
{
    double h = c->height, end = fmin(viscous * h * h / s->flow.nu, share * h / c->speed);
    return CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_implicit_process(&s->implicit), end));
}

/* Speeds from 1e-6 to 1 m/s in channels from 10 um to 1 m. Nothing is lost on the way, whatever the first step. */
TEST(speeds_and_scales)
{
    static const double heights[] = {1e-5, 1.2e-2, 1.0}, speeds[] = {1e-6, 1e-4, 1e-2, 1.0};
    for (int a = 0; a < 3; a += PD_DIM - 1 > 0 ? PD_DIM - 1 : 1)
        for (int b = 0; b < 4; b += PD_DIM == 3 ? 3 : 1) {
            scene s_, *s = &s_;
            channel c = {heights[a], speeds[b], 3.0, PD_DIM == 3 ? 8 : 12, 2, 0};
            if (!channel_build(s, &c, 1e-3) || !run(s, &c, 0.05, 0.1)) return;
            CHECK_LE(leak(s, &c), 1e-5);
            CHECK_LE(fabs(pd_flow_integrate_section(&s->ctx, &s->flow, 0, c.cells) /
                              pdi_flow_integrate_nodal_section(&s->flow, 0, c.cells) -
                          1.0),
                     0.1);
            CHECK_LE((double)s->implicit.steps, 150.0);
            CHECK_LE((double)s->implicit.rejected, 10.0);
            NOTE("H %g U %g: %d steps, %d rejected, %d evaluations, leak %.2g", c.height, c.speed,
                 (int)s->implicit.steps, (int)s->implicit.rejected, (int)s->implicit.evaluations, leak(s, &c));
            scene_free(s);
        }
}

#if PD_DIM > 1
TEST(reaches_and_boxes)
{
    for (int k = PD_DIM == 3 ? 4 : 0; k < 6; k++) {
        scene s_, *s = &s_;
        channel c = {1.2e-2, 1e-3, k < 4 ? k + 1.0 : 3.0, PD_DIM == 3 ? 8 : 12, k == 4 ? 1 : k == 5 ? 6 : 2, k % 2};
        if (!channel_build(s, &c, 1e-3) || !run(s, &c, 0.05, 0.1)) return;
        CHECK_LE(leak(s, &c), 1e-5);
        CHECK_LE((double)s->implicit.steps, 150.0);
        NOTE("m %g, %d x 1, body %d: %d steps, %d evaluations", c.m, c.lengths, c.body, (int)s->implicit.steps,
             (int)s->implicit.evaluations);
        scene_free(s);
    }
}
#endif

#if PD_DIM == 2
/* Start of a channel flow of given mean speed: v = u - 3/2 (1 - y^2) has no flux and decays with the roots of
 * tan l = l; u/U at y in -1..1 and t in units of the half width squared over nu. */
static double given_flux(double y, double t)
{
    double u = 1.5 * (1.0 - y * y);
    for (int k = 1; k < 60; k++) {
        double top = (k + 0.5) * 3.14159265358979323846, l = top - 1.0 / top;
        for (int n = 0; n < 50; n++) l -= (sin(l) - l * cos(l)) / (l * sin(l));
        u += 2.0 / (l * l * cos(l)) * (cos(l * y) - cos(l)) * exp(-l * l * t);
    }
    return u;
}

/* Largest error half way between inlet and outlet, creeping. */
static double startup(int cells, double rtol)
{
    static const double times[] = {0.05, 0.2};
    channel c = {1e-2, 1e-6, 3.0, cells, 3, 0};
    scene s_, *s = &s_;
    double worst = 0.0;
    if (!channel_build(s, &c, rtol)) return 1.0;
    for (int k = 0; k < 2; k++) {
        if (!run(s, &c, 0.25 * times[k], 1e9)) return 1.0;
        for (int j = 0; j < cells; j++) {
            int i[PD_DIM];
            double x[PD_DIM];
            i[0] = s->grid.n[0] / 2;
            i[1] = j;
            int32_t node = pd_grid_node(&s->grid, i);
            pd_grid_position(&s->grid, node, x);
            worst = fmax(worst, fabs(s->flow.u[node] / c.speed - given_flux(2.0 * x[1] / c.height - 1.0, times[k])));
        }
    }
    scene_free(s);
    return worst;
}

TEST(closed_form)
{
    double coarse = startup(10, 3e-4), fine = startup(20, 3e-4);
    NOTE("errors %.3g %.3g", coarse, fine);
    CHECK_LE(fine, 0.012);
    CHECK_LE(1.5, log(coarse / fine) / log(2.0));
}
#endif

#if PD_DIM == 1
TEST_MAIN(ENTRY(speeds_and_scales))
#elif PD_DIM == 2
TEST_MAIN(ENTRY(speeds_and_scales) SLOW_ENTRY_IF(PD_DIM == 3, reaches_and_boxes) ENTRY(closed_form))
#else
TEST_MAIN(ENTRY(speeds_and_scales) SLOW_ENTRY_IF(PD_DIM == 3, reaches_and_boxes))
#endif
