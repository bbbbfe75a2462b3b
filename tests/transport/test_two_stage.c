/* test_two_stage: transport in time of second order, against closed forms.
 * dims: 1 2 */
#include "fixture.h"
#include "transport/amount.h"
#include "transport/two_stage.h"
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static scene test_scene;
static pd_two_stage_desc two_stage_desc;
static pd_two_stage two_stage;

/* n cells over a length of 1 along axis 0, periodic all round. */
static scene *scene_start(int n)
{
    scene *s = &test_scene;
    scene_box(s, 0.0, 1.0 / n, n, 5, 5);
    s->grid_desc.hi[0] = 1.0;
    for (int side = 0; side < 2 * PD_DIM; side++) s->grid_desc.side[side] = PD_SIDE_PERIODIC;
    s->with = WITH_TRANSPORT;
    s->flow_desc.rho = s->flow_desc.mu = s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    s->transport_desc.tolerance = 1e-12;
    memset(&two_stage_desc, 0, sizeof two_stage_desc);
    return s;
}

/* A stream of 1 along axis 0, if there is a flow. */
static int two_stage_build(scene *s)
{
    int flowing = s->with & WITH_FLOW;
    if (!scene_build(s)) return 0;
    for (int32_t i = 0; i < s->grid.total && flowing; i++)
        if (s->grid.kind[i] == PD_FLUID) s->flow.u[i] = 1.0;
    if (flowing) pdi_flow_update_derived_fields(&s->ctx, &s->flow);
    return CHECK_OK(&s->ctx, pd_transport_update(&s->ctx, &s->transport)) &&
           CHECK_OK(&s->ctx, pd_two_stage_build(&s->ctx, &s->transport, &two_stage_desc, &two_stage));
}

static void two_stage_free(scene *s)
{
    pd_two_stage_free(&s->ctx, &two_stage);
    scene_free(s);
}

static double wave(const scene *s, int32_t i, double amplitude)
{
    double x[PD_DIM];
    pd_grid_position(&s->grid, i, x);
    return 2.0 + amplitude * cos(2.0 * pi * x[0]);
}

static void fill(scene *s)
{
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = wave(s, i, 1.0);
}

/* Largest error at t = 1 of a wave that diffuses: the sums of the stencil give its decay rate in closed form. steps 0:
 * by error control. */
static double decay(int steps, double rtol, long *taken)
{
    scene *s = scene_start(16);
    double k = 2.0 * pi, rate = 0.0, error = 0.0;
    s->transport_desc.diffusivity = 0.05;
    two_stage_desc.rtol = rtol;
    if (!two_stage_build(s)) return 1.0;
    for (int b = 0; b < s->stencil.count; b++)
        rate +=
            s->transport_desc.diffusivity * s->stencil.laplacian_weight[b] * (1.0 - cos(k * s->stencil.xi[b * PD_DIM]));
    fill(s);
    for (int n = 0; n < steps; n++)
        if (!CHECK_OK(&s->ctx, pd_two_stage_step(&s->ctx, &two_stage, 1.0 / steps, &s->result))) return 1.0;
    if (!steps && !CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_two_stage_process(&two_stage), 1.0))) return 1.0;
    CHECK_NEAR(two_stage.time, 1.0, 1e-12);
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) error = fmax(error, fabs(s->transport.c[i] - wave(s, i, exp(-rate))));
    *taken = (long)two_stage.steps;
    CHECK_INT(two_stage.euler, 0);
    two_stage_free(s);
    return error;
}

TEST(second_order_in_time)
{
    long taken;
    double coarse = decay(10, 0.0, &taken), middle = decay(20, 0.0, &taken), fine = decay(40, 0.0, &taken);
    CHECK_LE(fine, 5e-5);
    CHECK_NEAR(log(coarse / middle) / log(2.0), 2.0, 0.1);
    CHECK_NEAR(log(middle / fine) / log(2.0), 2.0, 0.05);
    NOTE("errors %.3g %.3g %.3g", coarse, middle, fine);
}

/* The error of a run follows rtol, and the number of steps its square root. */
TEST(steps_by_error)
{
    long few, many;
    double loose = decay(0, 1e-3, &few), tight = decay(0, 1e-5, &many);
    CHECK_LE(loose, 1e-3);
    CHECK_LE(tight, 1e-5);
    CHECK(few >= 2 && many > 4 * few && many < 20 * few);
    NOTE("rtol 1e-3: %ld steps, error %.3g; 1e-5: %ld steps, error %.3g", few, loose, many, tight);
}

/* A box profile in a stream at any Peclet number: within its bounds after every step, short or long, nothing lost. */
TEST(bounds_and_balance)
{
    static const double diffusivities[] = {0.0, 1e-6, 1e-3, 1e-1}, steps[] = {0.002, 0.02, 0.3};
    for (int k = 0; k < 12; k++) {
        scene *s = scene_start(24);
        s->with |= WITH_FLOW;
        s->transport_desc.diffusivity = diffusivities[k % 4];
        if (!two_stage_build(s)) return;
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM];
            pd_grid_position(&s->grid, i, x);
            if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = x[0] > 0.2 && x[0] < 0.5 ? 3.0 : 0.0;
        }
        double before = pd_transport_stock(&s->ctx, &s->transport);
        for (int n = 0; n < 5; n++) {
            if (!CHECK_OK(&s->ctx, pd_two_stage_step(&s->ctx, &two_stage, steps[k / 4], &s->result))) return;
            double low = 1e9, high = -1e9, now = pd_transport_stock(&s->ctx, &s->transport);
            for (int32_t i = 0; i < s->grid.total; i++) {
                if (s->grid.kind[i] != PD_FLUID) continue;
                low = fmin(low, s->transport.c[i]);
                high = fmax(high, s->transport.c[i]);
            }
            CHECK_LE(-3e-9, low);
            CHECK_LE(high, 3.0 + 3e-9);
            CHECK_NEAR(now + pd_transport_carried(&s->ctx, &s->transport), before, 1e-13 * before);
        }
        two_stage_free(s);
    }
}

static double ends(void *user, const double *x)
{
    (void)user;
    return x[0] < 0.5 ? 1.0 : 0.0;
}

/* What held walls give and take is in the balance, rejected steps included. */
TEST(balance_of_a_run)
{
    scene *s = scene_start(20);
    s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_WALL;
    s->transport_desc.diffusivity = 1.0;
    s->transport_desc.held = ends;
    two_stage_desc.rtol = 1e-4;
    if (!two_stage_build(s)) return;
    for (int n = 1; n <= 4; n++) {
        CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_two_stage_process(&two_stage), 0.01 * n));
        double stock = pd_transport_stock(&s->ctx, &s->transport) + pd_transport_carried(&s->ctx, &s->transport);
        CHECK_NEAR(stock, two_stage.in - two_stage.out, 1e-13 * two_stage.in);
    }
    CHECK(two_stage.rejected > 0 && two_stage.out > 0.0);
    two_stage_free(s);
}

static double nothing(void *user, const double *x)
{
    (void)x;
    (void)user;
    return 0.0;
}

/* What diffuses into walls that hold nothing falls for ever. Its solvers end at the least norm that has digits; the
 * steps do not take what they leave undone for an error, and grow. */
TEST(washed_out)
{
    scene *s = scene_start(12);
    for (int side = 0; side < 2 * PD_DIM; side++) s->grid_desc.side[side] = PD_SIDE_WALL;
    s->transport_desc.diffusivity = 1.0;
    s->transport_desc.held = nothing;
    two_stage_desc.rtol = 1e-2;
    double size = 0.0;
    if (!two_stage_build(s)) return;
    fill(s);
    for (int32_t i = 0; i < s->grid.total; i++) s->transport.c[i] *= 1e-140;
    for (int n = 0; n < 100 && two_stage.steps < 1000; n++)
        if (!CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_two_stage_process(&two_stage), 0.1 * n + 0.1))) return;
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) size = fmax(size, fabs(s->transport.c[i]));
    NOTE("%ld steps, %g mol/m3 left", (long)two_stage.steps, size);
    CHECK_LE(size, 1e-146);
    CHECK_LE(two_stage.steps, 600);
    two_stage_free(s);
}

/* The box up to `reach` comes to 1 in a millionth of the time of the run, and what is beyond by diffusion from it: the
 * mean at the end. */
static double stiff(double reach, double rtol, long *taken)
{
    scene *s = scene_start(20);
    double sum = 0.0;
    s->transport_desc.diffusivity = 0.05;
    two_stage_desc.rtol = rtol;
    if (!two_stage_build(s)) return 0.0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] != PD_FLUID || x[0] > reach) continue;
        s->transport.absorb[i] = s->transport.source[i] = 1e6;
    }
    CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_two_stage_process(&two_stage), 1.0));
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) sum += s->transport.c[i] / (double)s->grid.fluid_count;
    *taken = (long)(two_stage.steps + two_stage.rejected);
    NOTE("rtol %.0e: %ld steps, mean %.6f", rtol, *taken, sum);
    two_stage_free(s);
    return sum;
}

/* A run need not follow what is at rest at the end of its first step: the method leaves (1 - 2 gamma)/(gamma^2 1e6) of
 * it. What diffuses in time is followed. */
TEST(stiff_sink)
{
    long few, some, many;
    double g = 0.29289321881345254;
    CHECK_NEAR(stiff(2.0, 1e-3, &few), 1.0, 1.1e-6 * (1.0 - 2.0 * g) / (g * g));
    CHECK_LE(few, 2);
    CHECK_NEAR(stiff(0.5, 1e-3, &some), stiff(0.5, 1e-5, &many), 1e-4);
    CHECK(some > 10 && many > 4 * some);
}

TEST(bad_descs)
{
    scene *s = scene_start(8);
    if (!two_stage_build(s)) return;
    pd_two_stage none;
    pd_two_stage_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.first = -1.0;
    CHECK_INT((int)pd_two_stage_build(&s->ctx, &s->transport, &desc, &none), (int)PD_ERR_ARGUMENT);
    CHECK_INT((int)pd_two_stage_step(&s->ctx, &two_stage, 0.0, &s->result), (int)PD_ERR_ARGUMENT);
    CHECK_INT((int)pd_physics_run(&s->ctx, pd_two_stage_process(&two_stage), -1.0), (int)PD_ERR_ARGUMENT);
    two_stage_free(s);
}

TEST_MAIN(ENTRY(second_order_in_time) ENTRY(steps_by_error) ENTRY(bounds_and_balance) ENTRY(balance_of_a_run)
          ENTRY(washed_out) ENTRY(stiff_sink) ENTRY(bad_descs))
