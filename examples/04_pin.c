/* 04: a dissolving pin in a channel, with the coupling loop and the ledger in the program's own hands.
 *
 * Objects are built from the bottom up, without a scene file. The rate law is a function; each step solves transport,
 * takes the losses from the metal, opens what has dissolved and solves the flow again (theory: chapters 10 and 13).
 *   cc -std=c99 -O2 -I. examples/04_pin.c -o 04_pin -lm
 */
#define PD_DIM 2
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HALF 150e-6 /* [m] half-width of the channel */

typedef struct rate_law {
    double speed;      /* [m/s] recession in fresh fluid */
    double saturation; /* [mol/m3] */
} rate_law;

static pd_ctx ctx;

static void must(pd_status status)
{
    if (status == PD_OK) return;
    fprintf(stderr, "%s: %s\n", pd_status_name(status), ctx.message);
    exit(1);
}

static void parabola(void *user, const double *x, double *u)
{
    u[0] = 1.5 * *(const double *)user * (1.0 - x[1] * x[1] / (HALF * HALF));
    u[1] = 0.0;
}

static double rate(void *user, const pd_rate_at *at)
{
    const rate_law *law = (const rate_law *)user;
    return law->speed * (1.0 - at->c / law->saturation);
}

static void print_ledger(const pd_time_loop *c, const pd_quasi_steady *q)
{
    const pd_mass_balance *l = &c->ledger[0];
    printf("  %5.1f  %5.0f  %6.2f   %10.4e  %10.4e  %10.4e  %8.1e   %5.0f\n", c->time / 3600.0, (double)c->steps,
           100.0 * pd_time_loop_volume_loss(c), l->solid, l->dissolved, l->out, l->imbalance / l->start,
           (double)q->solves);
}

int main(void)
{
    pd_stencil_desc sd;
    pd_grid_desc gd;
    pd_flow_desc fd;
    pd_steady_desc dd;
    pd_transport_desc td;
    pd_dissolve_desc od;
    pd_time_loop_desc cd;
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_flow flow;
    pd_steady steady;
    pd_transport transport;
    pd_dissolve dissolve;
    pd_quasi_steady quasi;
    pd_time_loop couple;
    pd_shape pin;
    pd_material metal;
    rate_law law;
    double mean = 0.01, hour = 3600.0; /* [m/s] [s] */
    pd_ctx_init(&ctx);
    memset(&sd, 0, sizeof sd);
    memset(&gd, 0, sizeof gd);
    memset(&fd, 0, sizeof fd);
    memset(&dd, 0, sizeof dd);
    memset(&td, 0, sizeof td);
    memset(&od, 0, sizeof od);
    memset(&cd, 0, sizeof cd);
    memset(&pin, 0, sizeof pin);

    pin.type = PD_SHAPE_BOX;
    pin.b[0] = 200e-6;
    pin.a[1] = -40e-6;
    pin.b[1] = 40e-6;
    sd.h[0] = sd.h[1] = 10e-6;
    gd.lo[0] = -200e-6;
    gd.hi[0] = 400e-6;
    gd.lo[1] = -HALF;
    gd.hi[1] = HALF;
    gd.side[0] = PD_SIDE_INLET;
    gd.side[1] = PD_SIDE_OUTLET;
    gd.shapes = &pin;
    gd.solid = &pin;
    must(pd_stencil_build(&ctx, &sd, &stencil));
    must(pd_grid_build(&ctx, &stencil, &gd, &grid));
    must(pd_bonds_build(&ctx, &stencil, &grid, 0, &bonds));

    fd.rho = 1000.0;
    fd.mu = 1e-3;
    fd.report_speed = mean;
    fd.report_length = 2.0 * HALF;
    fd.inlet = parabola;
    fd.developed_sides = 1; /* side x- */
    fd.inlet_user = &mean;
    must(pd_flow_build(&ctx, &grid, &bonds, &fd, &flow));
    must(pd_steady_build(&ctx, &flow, &dd, &steady));

    td.diffusivity = 1e-9;
    must(pd_transport_build(&ctx, &grid, &bonds, &flow, &td, &transport));
    law.speed = 1.21e-6 / hour;
    law.saturation = 56.1;
    if (!pd_material_find("mg4ag", &metal)) return 1;
    od.solid = pd_material_concentration(&metal);
    od.rate = rate;
    od.rate_user = &law;
    must(pd_dissolve_build(&ctx, &grid, &stencil, &transport, &od, &dissolve));

    must(pd_time_loop_build(&ctx, &cd, &grid, &bonds, &couple));
    must(pd_time_loop_add_process(&ctx, &couple, pd_quasi_steady_process(&flow, &steady, &quasi)));
    must(pd_time_loop_add_process(&ctx, &couple, pd_dissolve_process(&dissolve)));
    must(pd_time_loop_start(&ctx, &couple));
    printf("amounts in mol per metre of depth\n"
           "  t [h]  steps  loss %%   solid       dissolved   out         imbalance  flow solves\n");
    print_ledger(&couple, &quasi);
    for (int k = 1; k <= 6; k++) {
        while (couple.time < k * hour) must(pd_time_loop_step(&ctx, &couple, k * hour));
        print_ledger(&couple, &quasi);
    }

    pd_dissolve_free(&ctx, &dissolve);
    pd_transport_free(&ctx, &transport);
    pd_steady_free(&ctx, &steady);
    pd_flow_free(&ctx, &flow);
    pd_bonds_free(&ctx, &bonds);
    pd_grid_free(&ctx, &grid);
    pd_stencil_free(&ctx, &stencil);
    return ctx.in_use != 0;
}
