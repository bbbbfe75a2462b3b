/* stiff_ode: implicit steps far beyond what explicit ones may take, explicit steps at their limit and just above it,
 * implicit ones there from the same fields.
 * dims: 1 2 3   slow: 3 */
#define _XOPEN_SOURCE 700
#include "hard.h"
#include "transport/amount.h"
#include "transport/explicit.h"

#define BOX "[grid] h = 10 um  m = 3  box = 0 .. 200 um" ACROSS("0 .. 100 um") "\n"
#define HALVES BOX "[transport] D = 1e-9 m2/s  initial = 100 mol/m3 * (x > 100 um)\n[run] until = 1 s\n"
#define FRONT \
    "[grid] h = 10 um  m = 3  box = 0 .. 300 um" ACROSS("0 .. 40 um") "\n[shape metal] box = 150 um .. " \
                                                                      "300 um" ACROSS("0 .. 40 um") "  kind = solid\n"

#if PD_DIM == 3
#define MIRRORS "[side z-] flow = mirror\n[side z+] flow = mirror\n"
#else
#define MIRRORS
#endif

#define TIMES 1e6 /* of the explicit limit */

/* Steps after which a forward Euler step of TIMES its limit has no finite value any more; the roughest field loses
 * twice
 * itself in a step at the limit. */
static double steps_to_infinity(void)
{
    double x = 1.0;
    int n = 0;
    for (; fabs(x) < HUGE_VAL; n++) x *= 1.0 - 2.0 * TIMES;
    return n;
}

/* Attempts at steps that are taken again. */
static int rejected;
static pd_status (*attempt)(pd_ctx *ctx, void *self, pd_step *step);

static pd_status counted(pd_ctx *ctx, void *self, pd_step *step)
{
    pd_status status = attempt(ctx, self, step);
    rejected += status == PD_RETRY;
    return status;
}

/* Two halves of a closed box at different concentrations become one, in a single step. */
TEST(step_1e6_times_the_limit)
{
    hard *h = &hard_one;
    for (int second = 0; second < 2; second++) {
        double off = 1.0;
        if (CHECK(hard_open(h, HALVES))) {
            pd_transport *t = &h->model.transport;
            double stock = pd_transport_stock(&h->ctx, t), dt = TIMES * pd_transport_limit(&h->ctx, t), low, high;
            pd_transport_result result;
            if (second) CHECK_OK(&h->ctx, pd_two_stage_step(&h->ctx, &h->model.transport_integrator, dt, &result));
            else CHECK_OK(&h->ctx, pd_transport_implicit(&h->ctx, t, dt, &result));
            double now = pd_transport_stock(&h->ctx, t) + pd_transport_carried(&h->ctx, t);
            CHECK_REL(now, stock, LEDGER);
            h->ledger = fabs(now - stock) / stock;
            hard_extremes(h, &low, &high);
            CHECK(low >= -1e-7 && high <= 100.0 + 1e-7);
            off = fmax(high - 50.0, 50.0 - low) / 50.0;
            CHECK_LE(off, second ? 2e-3 : 1e-3); /* 1/(1 + dt lambda) of the slowest mode */
        }
        hard_end(h, second ? "transport_second_order" : "transport_euler", off, "field_against_its_mean",
                 steps_to_infinity(), "steps_until_forward_euler_overflows");
    }
    /* metal in a closed box: steps as long as the error allows, to a million explicit ones and beyond */
    double loss = 0.0, limit = 1.0;
    if (CHECK(hard_open(h, FRONT "[corrode] rate = 10 um/h * (1 - C/Csat)  D = 1e-9 m2/s  Cs = 2 mol/L  Csat = 500 "
                                 "mol/m3\n"
                                 "[run] until = 1e4 h  max_step = 1e4 h\n"))) {
        limit = pd_transport_limit(&h->ctx, &h->model.transport);
        CHECK(h->setup.end_time > TIMES * limit);
        CHECK_INT(h->model.time_loop.count, 1);
        rejected = 0;
        attempt = h->model.time_loop.process[0].attempt;
        h->model.time_loop.process[0].attempt = counted;
        CHECK(hard_steps(h, h->setup.end_time));
        hard_sound(h);
        loss = pd_time_loop_volume_loss(&h->model.time_loop);
        /* x layers turn: 15 + x of fluid hold Csat of what 15 of metal have lost: 15 loss Cs = (15 + x) Csat; what
         * is lost
         * of the layer at the front is none of the layers that turned */
        CHECK(loss > 0.25 && loss < 0.36);
        NOTE("corrode: %d rejected, %ld steps", rejected, (long)h->model.time_loop.steps);
        CHECK_LE(rejected, 200);
        CHECK_LE((double)h->model.time_loop.steps, 5000);
    }
    double low = 0.0, high = 0.0;
    if (h->built) hard_extremes(h, &low, &high);
    hard_end(h, "corrode", fabs(high - low) / 500.0, "spread_of_the_saturated_fluid_over_Csat", 0.0, NULL);
#if PD_DIM > 1
    /* flow under a force, from rest to the parabola in one step */
    double off = 1.0;
    if (CHECK(hard_open(h, BOX "[side x-] flow = periodic\n[side x+] flow = periodic\n" MIRRORS
                               "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  time = implicit  reference_speed = 1.25 mm/s  "
                               "reference_length = 100 um\n"
                               "body_force = 1 m/s2, 0 m/s2" ALONG_Z("0 m/s2") "\n[run] until = 1 s\n"))) {
        const pd_model *m = &h->model;
        double dt = TIMES / (2.0 * m->stencil.lap_sum * m->flow.nu);
        CHECK_OK(&h->ctx, pd_implicit_step(&h->ctx, &h->model.implicit, dt));
        off = 0.0;
        for (int32_t i = 0; i < m->grid.total; i++) {
            double x[PD_DIM];
            if (m->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&m->grid, i, x);
            double s = x[1] / 100e-6;
            off = fmax(off, fabs(m->flow.u[i] / 1.25e-3 - 4.0 * s * (1.0 - s)));
        }
        /* R(z) of the method goes as (2 + sqrt 2)/z; the slowest mode decays with nu (pi/width)^2 */
        CHECK_LE(off, 6.0 / (dt * 987.0));
    }
    hard_end(h, "flow", off, "velocity_against_the_parabola", steps_to_infinity(),
             "steps_until_forward_euler_overflows");
#endif
}

static void random_fluid(const hard *h, double *c, double high)
{
    uint32_t seed = 3;
    for (int32_t i = 0; i < h->model.grid.total; i++) {
        seed = seed * 1664525u + 1013904223u;
        if (h->model.grid.kind[i] == PD_FLUID) c[i] = (seed >> 31) ? high : 0.0;
    }
}

/* The limit itself keeps the bounds, from the roughest fields; one per cent more is refused and changes nothing. Beside
 * metal steps are implicit: from the same fields they keep the bounds at the limit and at a thousand times it. */
TEST(step_at_the_limit)
{
    hard *h = &hard_one;
    const char *above = "exceeds the limit of";
    double worst = 0.0;
    if (CHECK(hard_open(h, HALVES))) {
        pd_transport *t = &h->model.transport;
        double limit = pd_transport_limit(&h->ctx, t), stock, low, high;
        random_fluid(h, t->c, 100.0);
        stock = pd_transport_stock(&h->ctx, t);
        for (int k = 0; k < 200; k++) {
            CHECK_INT(pd_transport_explicit(&h->ctx, t, 1.01 * limit), PD_RETRY);
            CHECK(strstr(h->ctx.message, above) != NULL);
            CHECK_OK(&h->ctx, pd_transport_explicit(&h->ctx, t, limit));
            hard_extremes(h, &low, &high);
            worst = fmax(worst, fmax(-low, high - 100.0) / 100.0);
        }
        CHECK_LE(worst, 1e-14);
        CHECK_REL(pd_transport_stock(&h->ctx, t), stock, LEDGER);
    }
    hard_end(h, "transport", fmax(worst, 0.0), "excess_at_the_limit_one_per_cent_more_is_refused", 0.0, NULL);
    for (int drive = 0; drive < 2; drive++) {
        char text[1200];
        snprintf(text, sizeof text,
                 "%s[corrode] rate = 10 um/h  D = 1e-9 m2/s  Cs = 2 mol/L  Csat = "
                 "500 "
                 "mol/m3  driving_force = %s\n[run] until = 1 h  max_dissolved_fraction = 1\n",
                 FRONT, drive ? "difference" : "constant");
        if (CHECK(hard_open(h, text))) {
            pd_time_loop *c = &h->model.time_loop;
            random_fluid(h, h->model.transport.c, 400.0);
            h->model.dissolve.rtol = h->model.dissolve.desc.rtol = 1e300; /* no error in time is too large here */
            CHECK_OK(&h->ctx, pd_time_loop_start(&h->ctx, c));
            hard_watch(h);
            for (int k = 0; k < 200; k++) {
                double step = (k % 2 ? 1e3 : 1.0) * pd_transport_limit(&h->ctx, &h->model.transport), before = c->time;
                if (k) h->model.dissolve.next_dt = HUGE_VAL;
                if (!CHECK_OK(&h->ctx, pd_time_loop_step(&h->ctx, c, c->time + step))) break;
                CHECK_REL(c->time - before, step, 1e-9);
                hard_watch(h);
            }
            hard_sound(h);
        }
        hard_end(h, drive ? "corrode_difference" : "corrode_constant", fmax(h->excess, 0.0),
                 "excess_at_the_limit_and_at_1e3_times_it", 0.0, NULL);
    }
}

TEST_MAIN(ENTRY(step_1e6_times_the_limit) ENTRY(step_at_the_limit))
