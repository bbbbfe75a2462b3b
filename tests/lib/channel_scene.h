/* channel_scene: a steady flow through a channel with a bar, and a plume that enters beside the middle. */
#ifndef CHANNEL_SCENE_H
#define CHANNEL_SCENE_H
#include "fixture.h"

#define NU 1e-6 /* [m2/s] */

/* The stream runs along `axis`, or (down) against it. */
typedef struct channel {
    int axis, down, length, across; /* cells */
    double from, to;                /* shares of the length at which the bar begins and ends, down the stream */
    double rest;                    /* concentration beside the plume */
} channel;

static scene test_scene;
static pd_steady_result solved;
static channel channel_now;

static void profile(void *user, const double *x, double *u)
{
    const scene *s = (const scene *)user;
    double y = x[1 - channel_now.axis] / s->width;
    u[channel_now.axis] = (channel_now.down ? -6.0 : 6.0) * s->mean * y * (1.0 - y);
    u[1 - channel_now.axis] = 0.0;
}

/* A plume a quarter of the channel wide. */
static double plume(void *user, const double *x)
{
    const scene *s = (const scene *)user;
    double y = 8.0 * (x[1 - channel_now.axis] / s->width - 0.4);
    return channel_now.rest + exp(-y * y);
}

/* The flow at a Reynolds number of the width of the channel, from rest; cells of the spacings h. NULL: it failed. */
static scene *channel_flow(const channel *of, const double *h, double m, double reynolds)
{
    scene *s = &test_scene;
    int cells[2], a = of->axis, b = 1 - of->axis;
    channel_now = *of;
    cells[a] = of->length;
    cells[b] = of->across;
    scene_box(s, m, 1.0, cells[0], cells[1], 1);
    s->ctx.threads = 1;
    for (int d = 0; d < 2; d++) {
        s->stencil_desc.h[d] = h[d];
        s->grid_desc.hi[d] *= h[d];
    }
    s->shapes[0].type = PD_SHAPE_BOX;
    s->shapes[0].a[a] = (of->down ? 1.0 - of->to : of->from) * of->length * h[a];
    s->shapes[0].b[a] = (of->down ? 1.0 - of->from : of->to) * of->length * h[a];
    s->shapes[0].a[b] = 0.375 * of->across * h[b];
    s->shapes[0].b[b] = 0.6875 * of->across * h[b];
    s->grid_desc.wall = &s->shapes[0];
    s->grid_desc.side[2 * a + of->down] = PD_SIDE_INLET;
    s->grid_desc.side[2 * a + !of->down] = PD_SIDE_OUTLET;
    s->width = s->grid_desc.hi[b];
    s->mean = s->flow_desc.report_speed = reynolds * NU / s->width;
    s->with = WITH_FLOW | WITH_STEADY;
    s->flow_desc.rho = 1000.0;
    s->flow_desc.mu = NU * s->flow_desc.rho;
    s->flow_desc.report_length = s->width;
    s->flow_desc.inlet = profile;
    s->flow_desc.inlet_user = s;
    s->steady_desc.tolerance = 1e-8;
    return scene_build(s) && CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &s->steady, &solved)) ? s : NULL;
}

#endif
