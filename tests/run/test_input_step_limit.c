/* test_input_step_limit: which values of a scene depend on time, and the places at which they are looked at.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "physics/input_step_limit.h"
#include "scene_file.h"

#if PD_DIM == 1
#define BOX "-4 um .. 8 um"
#elif PD_DIM == 2
#define BOX "-4 um .. 8 um, 10 um .. 22 um"
#else
#define BOX "-4 um .. 8 um, 10 um .. 22 um, 1 um .. 13 um"
#endif
#define HEAD "[grid] h = 1 um  m = 2  box = " BOX "\n[transport] D = 1e-9 m2/s\n"

static const double lo[3] = {-4e-6, 10e-6, 1e-6}, hi[3] = {8e-6, 22e-6, 13e-6};

static pd_status begin(pd_ctx *ctx, const char *text, pd_setup *u, pd_input_step_limit *vary)
{
    memset(u, 0, sizeof *u);
    memset(vary, 0, sizeof *vary);
    if (!CHECK_OK(ctx, load(ctx, text, NULL, 0, u))) return ctx->status;
    return pdi_input_step_limit_build(ctx, u, vary);
}

static void end(pd_ctx *ctx, pd_setup *u, pd_input_step_limit *vary)
{
    pdi_input_step_limit_free(ctx, vary);
    leave(ctx, u);
}

/* The tolerance and the end of a run are those of the scene, or the default of 1e-3. */
TEST(tolerance)
{
    static const char *const texts[2] = {HEAD "[run] until = 3 s\n", HEAD "[run] until = 5 s  rtol = 2e-4\n"};
    for (int k = 0; k < 2; k++) {
        pd_ctx ctx;
        pd_setup u;
        pd_input_step_limit vary;
        if (!CHECK_OK(&ctx, begin(&ctx, texts[k], &u, &vary))) return;
        CHECK_NEAR(vary.rtol, k ? 2e-4 : 1e-3, 0.0);
        CHECK_NEAR(vary.end_time, k ? 5.0 : 3.0, 0.0);
        CHECK_INT(vary.count, 0); /* nothing depends on time */
        end(&ctx, &u, &vary);
    }
}

/* A value at a side is looked at on the side: at the middles of thirds along the axes that it depends on, in the middle
 * along others. Each place once. */
static void check_side(const char *expression, int side, int uses)
{
    char text[600];
    pd_ctx ctx;
    pd_setup u;
    pd_input_step_limit vary;
    int places = 1, seen[27] = {0};
    static const char axes[] = "xyz";
    snprintf(text, sizeof text, HEAD "[side %c%c] C = %s\n[run] until = 1 s\n", axes[side / 2], side % 2 ? '+' : '-',
             expression);
    if (!CHECK_OK(&ctx, begin(&ctx, text, &u, &vary))) return;
    for (int d = 0; d < PD_DIM; d++)
        if (uses >> d & 1 && d != side / 2) places *= 3;
    CHECK_INT(vary.count, places);
    CHECK_INT(vary.capacity, places);
    for (int32_t k = 0; k < vary.count; k++) {
        const pd_input_value *value = &vary.value[k];
        int place = 0;
        for (int d = PD_DIM - 1; d >= 0; d--) {
            double part = (value->x[d] - lo[d]) / (hi[d] - lo[d]), third = floor(3.0 * part);
            if (d == side / 2) {
                CHECK_NEAR(value->x[d], side % 2 ? hi[d] : lo[d], 1e-20);
            } else if (uses >> d & 1) {
                CHECK_NEAR(part, (third + 0.5) / 3.0, 1e-14);
                place = 3 * place + (int)third;
            } else {
                CHECK_NEAR(part, 0.5, 1e-14);
            }
        }
        CHECK(place >= 0 && place < places && !seen[place]++);
        CHECK(value->expr == &u.side[side].inlet_c || value->expr == &u.side[side].fixed_c);
        CHECK_INT(value->at_midpoint, 0);
    }
    end(&ctx, &u, &vary);
}

TEST(places_of_sides)
{
    for (int side = 0; side < 2 * PD_DIM; side++) {
        check_side("1 mol/m3*t/1 s", side, 0);
        check_side("1 mol/m3*(1 + x/1 m)*t/1 s", side, 1);
        if (PD_DIM > 1) check_side("1 mol/m3*(1 + y/1 m)*t/1 s", side, 2);
        if (PD_DIM > 1) check_side("1 mol/m3*(1 + x/1 m + y/1 m)*t/1 s", side, 3);
        if (PD_DIM > 2) check_side("1 mol/m3*(1 + y*z/1 m2)*t/1 s", side, 6);
        if (PD_DIM > 2) check_side("1 mol/m3*(1 + x/1 m + y*z/1 m2)*t/1 s", side, 7);
    }
}

/* What does not depend on time is not looked at. */
TEST(steady_values)
{
    pd_ctx ctx;
    pd_setup u;
    pd_input_step_limit vary;
    if (!CHECK_OK(&ctx, begin(&ctx, HEAD "[side x-] C = 1 mol/m3*(1 + x/1 m)\n[run] until = 1 s\n", &u, &vary)))
        return;
    CHECK_INT(vary.count, 0);
    CHECK_NEAR(pdi_input_step_limit_compute(&vary, 0.0, 0.7), 0.7, 0.0);
    end(&ctx, &u, &vary);
}

/* Steps end where a value jumps at any of its places: a front that goes by 1 um/s from -4 um passes the middles of
 * thirds of the box, -2, 2 and 6 um. */
TEST(steps_end_at_jumps)
{
    pd_ctx ctx;
    pd_setup u;
    pd_input_step_limit vary;
    static const double jumps[3] = {2.0, 6.0, 10.0};
    if (PD_DIM == 1) SKIP("a side is one place");
    if (!CHECK_OK(&ctx, begin(&ctx, HEAD "[side y-] C = if(x + 4 um < 1 um/s*t, 1 mol/m3, 0 mol/m3)\n"
                                         "[run] until = 20 s\n", &u, &vary)))
        return;
    CHECK_INT(vary.count, 3);
    double t = 0.0;
    for (int k = 0; k < 3; k++) {
        t = pdi_input_step_limit_compute(&vary, t, 20.0);
        CHECK_NEAR(t, jumps[k], 1e-6);
        t += 1e-3;
    }
    CHECK_NEAR(pdi_input_step_limit_compute(&vary, t, 20.0), 20.0, 0.0);
    end(&ctx, &u, &vary);
}

TEST_MAIN(ENTRY(tolerance) ENTRY(places_of_sides) ENTRY(steady_values) ENTRY(steps_end_at_jumps))
