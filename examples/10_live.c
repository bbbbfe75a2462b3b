/* 10: a run that is watched, and a law of place, time and grain.
 *
 *     cc -std=c99 -O2 -I. examples/10_live.c -o 10_live -lm
 *
 * The observer sees the fields after each step and ends the run when a twentieth of the metal is gone. */
#define PD_DIM 2
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr_app.h"
#include <math.h>
#include <stdio.h>

enum { LAW_C, LAW_T, LAW_X, LAW_Y, LAW_GRAIN };

/* Speed [m/s] of the metal: less towards saturation; a film slows it down in hours; it starts later downstream; every
 * third grain resists. */
static double law(void *user, const double *at)
{
    double fastest = *(const double *)user, saturation = 56.1 /* mol/m3 */, hour = 3600.0;
    double film = pow(0.5, at[LAW_T] / (3.0 * hour)), late = at[LAW_T] < 0.2 * hour && at[LAW_X] > 0.0 ? 0.5 : 1.0;
    double grain = (int)at[LAW_GRAIN] % 3 == 0 ? 0.3 : 1.0;
    return fastest * (1.0 - at[LAW_C] / saturation) * film * late * grain;
}

/* Largest concentration, and where; the figures that the scene watches. Not 0 ends the run. */
static int watch(void *user, pd_ctx *ctx, const pd_snapshot *at)
{
    int64_t *calls = (int64_t *)user, most = 0;
    pd_field_view c;
    pd_scalar_outputs figures = {0};
    ++*calls;
    if (pd_snapshot_get_field(ctx, at, "C", &c) < 0 || pd_snapshot_get_outputs(ctx, at, &figures) < 0) return 1;
    for (int64_t k = 1; k < c.component_stride; k++)
        if (c.data[k] > c.data[most]) most = k;
    printf("%s step %3ld, t = %6.0f s, dt = %6.1f s, %.2f %% lost, most %s = %.3g in column %ld, %d figures\n",
           at->stage == PD_SNAPSHOT_STAGE_START ? "start"
           : at->stage == PD_SNAPSHOT_STAGE_END ? "end  "
                                                : "     ",
           (long)at->steps, at->time, at->dt, 100.0 * at->diagnostics->volume_loss, c.label, c.data[most],
           (long)(most % c.n[0]), figures.count);
    pd_scalar_outputs_free(ctx, &figures);
    return at->diagnostics->volume_loss > 0.05;
}

int main(int argc, char **argv)
{
    const char *changes[] = {"h=10 um", "until=9 h", "output.folder=out/live"};
    const uint32_t uses = 1u << LAW_C | 1u << LAW_T | 1u << LAW_X | 1u << LAW_GRAIN;
    double fastest = 3.4e-10; /* m/s */
    int64_t calls = 0;
    pd_ctx ctx;
    pd_setup setup;
    pd_run_desc desc = {0};
    pd_run_result result;
    pd_ctx_init(&ctx);
    desc.observe = watch;
    desc.observe_user = &calls;
    pd_status status = pd_scene_read(&ctx, argc > 1 ? argv[1] : "examples/scenes/mg_pin_2d.scene", changes, 3, &setup);
    if (status < 0) {
        fprintf(stderr, "%s\n", ctx.message);
        return 1;
    }
    status = pd_setup_set_function(&ctx, &setup, "rate", law, &fastest, uses);
    if (status >= 0) status = pd_run(&ctx, &setup, &desc, &result);
    pd_setup_free(&ctx, &setup);
    if (status < 0) {
        fprintf(stderr, "%s\n", ctx.message);
        return 1;
    }
    printf("%s at %.0f s after %ld calls\n", result.stopped ? "stopped by the observer" : "done", result.time,
           (long)calls);
    return !result.stopped || ctx.in_use != 0;
}
