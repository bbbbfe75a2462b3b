/* 07: a scene step by step, and its fields.  cc -std=c99 -O2 -I. examples/07_step.c -o 07_step -lm */
#define PD_DIM 2
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr_app.h"
#include <stdio.h>

int main(int argc, char **argv)
{
    const char *changes[] = {"h=10 um", "until=1 h"};
    static pd_sim sim;
    pd_ctx ctx;
    pd_field_view c;
    pd_ctx_init(&ctx);
    pd_status status = pd_sim_open(&ctx, argc > 1 ? argv[1] : "examples/scenes/mg_pin_2d.scene", changes, 2, &sim);
    while (status >= 0 && sim.time < sim.end_time) {
        status = pd_sim_step(&ctx, &sim, sim.end_time);
        if (status >= 0) status = pd_sim_field(&ctx, &sim, "C", &c);
        if (status >= 0)
            printf("t = %6.0f s: %s = %g in the middle\n", sim.time, c.label,
                   c.data[c.n[0] / 2 * c.stride[0] + c.n[1] / 2 * c.stride[1]]);
    }
    if (status < 0) fprintf(stderr, "%s\n", ctx.message);
    pd_sim_close(&ctx, &sim);
    return status < 0;
}
