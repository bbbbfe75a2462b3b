/* test_ramped_lid: weakly compressible flow below a lid that starts to slide: steps and the diffusion of density are
 * those of a lid at full speed, however slow the start, and the flow is that of the incompressible solver. dims: 2 */
#include "pdcorr_app.h"
#include "test.h"

#define LID(speed, time) \
    "[grid] h = 50 um  m = 1  box = 0 .. 1 mm, 0 .. 1 mm  threads = 1\n" \
    "[side y+] flow = noslip  velocity = " speed ", 0 m/s\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  " time "\n[run] until = 0.4 s\n[output] fields = none  every = 0.2 s\n"
#define EXPLICIT "time = explicit  c0 = 0.2 m/s  eos = linear"

/* Runs a scene to its end: time scale of the density diffusion, evaluations, and the velocity at 0.5 mm, 0.8 mm. */
static int run(const char *text, double *tau, double *work, double *velocity)
{
    static pd_sim sim;
    pd_ctx ctx;
    double at[] = {0.525e-3, 0.825e-3};
    pd_ctx_init(&ctx);
    memset(&sim, 0, sizeof sim);
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "lid.scene", text, NULL, 0, &sim.setup)) ||
        !CHECK_OK(&ctx, pd_sim_start(&ctx, &sim)))
        return 0;
    while (sim.model.time_loop.time < sim.setup.end_time)
        if (!CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, sim.setup.end_time))) return 0;
    *tau = sim.model.flow.stabilisation;
    *work = (double)sim.model.flow.evaluations;
    for (int32_t i = 0; i < sim.model.grid.total; i++) {
        double x[2];
        pd_grid_position(&sim.model.grid, i, x);
        if (fabs(x[0] - at[0]) < 1e-6 && fabs(x[1] - at[1]) < 1e-6) *velocity = sim.model.flow.u[i];
    }
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
    return 1;
}

TEST(starts_slowly)
{
    double tau[3], work[3], v[3];
    if (!run(LID("10 mm/s", EXPLICIT), &tau[0], &work[0], &v[0]) ||
        !run(LID("10 mm/s * min(1, t/(0.05 s)) + 1 um/s", EXPLICIT), &tau[1], &work[1], &v[1]) ||
        !run(LID("10 mm/s * min(1, t/(0.05 s)) + 1 um/s", "time = implicit"), &tau[2], &work[2], &v[2]))
        return;
    NOTE("evaluations %g and %g, velocity %.6g, %.6g, incompressible %.6g m/s", work[0], work[1], v[0], v[1], v[2]);
    CHECK(work[0] > 1000.0 && v[2] > 1e-4);
    CHECK_NEAR(tau[1], tau[0], 0.0);
    CHECK_LE(work[1], 1.1 * work[0]);
    /* Mach 0.05: the compressible part is of its square, some 0.3 %, of what is not yet at rest */
    CHECK_REL(v[1], v[2], 5e-3);
}

TEST_MAIN(ENTRY(starts_slowly))
