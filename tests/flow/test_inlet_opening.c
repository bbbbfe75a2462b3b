/* test_inlet_opening: what enters through openings of several parts, by a mean speed and by a flow rate: in planar 2D
 * that is the rate of a tube as wide as the opening, whatever the profile. dims: 2 */
#include "pdcorr_app.h"
#include "test.h"

/* A channel 1 mm wide whose inlet a plate parts into openings of 0.4 mm and 0.3 mm. */
#define CHANNEL(inlet, run) \
    "[grid] h = 50 um  m = 1  box = 0 .. 2 mm, 0 .. 1 mm  threads = 1\n" \
    "[shape plate] box = 0 .. 1 mm, 0.4 mm .. 0.7 mm  kind = wall\n" \
    "[side x-] flow = inlet  " inlet "\n[side x+] flow = outlet  p = 0\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  steady_tolerance = 1e-8\n" run

/* Flow [m2/s] through the plane x = 1.5 mm of the steady flow at the start. */
static double flow_of(const char *text)
{
    static pd_sim sim;
    pd_ctx ctx;
    pd_diagnostics_plane_result found;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_sim_open(&ctx, text, NULL, 0, &sim))) return NAN;
    pd_diagnostics_plane(&ctx, &sim.model.bonds, &sim.model.flow, NULL, 0, 30, &found);
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
    return found.flow;
}

TEST(parts)
{
    const double open = 0.7e-3,
                 rate = 1e-9 / (0.25 * 3.14159265358979323846 * 1e-6); /* tube 1 mm wide: between the ends */
    CHECK_REL(flow_of(CHANNEL("profile = uniform  mean = 1 mm/s", "")), 1e-3 * open, 1e-6);
    CHECK_REL(flow_of(CHANNEL("profile = parabola  mean = 1 mm/s", "")), 1e-3 * open, 1e-6);
    CHECK_REL(flow_of(CHANNEL("profile = uniform  flow_rate = 1e-9 m3/s", "")), rate * open, 1e-6);
    CHECK_REL(flow_of(CHANNEL("profile = parabola  flow_rate = 1e-9 m3/s", "")), rate * open, 1e-6);
    CHECK_REL(flow_of(CHANNEL("profile = parabola  flow_rate = 1e-9 m3/s * (1 + t/(1 s))", "[run] until = 1 s\n")),
              rate * open, 1e-6);
}

TEST_MAIN(ENTRY(parts))
