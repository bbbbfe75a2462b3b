/* Horizons of their own for fluid and metal: fronts and linear fields against closed forms, ghosts deeper than a
 * stencil needs, what is refused.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "couple/integral_diagnostics.h"
#include "scene_file.h"
#include <math.h>

#if PD_DIM == 1
#define ACROSS ""
#define MIRRORS
#elif PD_DIM == 2
#define ACROSS ", 0 .. 3 um"
#define MIRRORS "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#else
#define ACROSS ", 0 .. 3 um, 0 .. 3 um"
#define MIRRORS "[side y-] flow = mirror\n[side y+] flow = mirror\n[side z-] flow = mirror\n[side z+] flow = mirror\n"
#endif

/* Plays a scene to its end; the model stays for the caller, who frees it and the setup when 1 is returned. */
static int play(const char *text, pd_ctx *ctx, pd_setup *u, pd_model *m)
{
    if (!CHECK_OK(ctx, load(ctx, text, NULL, 0, u))) return 0;
    int good = CHECK_OK(ctx, pd_model_build(ctx, u, m)) && CHECK_OK(ctx, pd_time_loop_start(ctx, &m->time_loop));
    while (good && m->time_loop.time < u->end_time) {
        good = CHECK_OK(ctx, pd_time_loop_step(ctx, &m->time_loop, u->end_time));
        CHECK_LE(m->time_loop.ledger[0].relative_imbalance, 1e-12);
    }
    return good;
}

static void end(pd_ctx *ctx, pd_setup *u, pd_model *m)
{
    pd_model_free(ctx, m);
    leave(ctx, u);
}

/* A front along an axis goes at the speed of the law, whatever the two horizons are. */
TEST(fronts)
{
    for (int fluid = 1; fluid <= 3; fluid++)
        for (int metal = fluid; metal <= 4; metal++) {
            char text[800];
            pd_ctx ctx;
            pd_setup u;
            pd_model m;
            snprintf(text, sizeof text,
                     "[grid] h = 1 um  m = %d  box = 0 .. 40 um" ACROSS "\n"
                     "[shape metal] box = 15 um .. 40 um" ACROSS "  kind = solid  material = mg4ag\n"
                     "[transport] D = 1e-8 m2/s  initial = 0 mol/m3\n"
                     "[dissolve] rate = 0.5 um/s  Cs = 20 mol/L  m = %d\n[run] until = 14.6 s\n", fluid, metal);
            if (!play(text, &ctx, &u, &m)) return;
            CHECK_REL(pd_time_loop_volume_loss(&m.time_loop), 7.3 / 25.0, 1e-10);
            CHECK_INT(m.grid.ghost, metal);
            CHECK_INT(m.stencil.reach, fluid);
            end(&ctx, &u, &m);
        }
}

/* Metal that gives for ever, a wall that takes at a distance L: c = J x/D, J = k/(1 + k L/(D Csat)) with the law
 * J = k (1 - c/Csat) at the surface. A linear field is an exact solution for all horizons. */
TEST(linear_field)
{
    const double k = 0.05, reach = 20e-6, diffusivity = 1e-9, saturation = 1e3;
    const double flux = k / (1.0 + k * reach / (diffusivity * saturation));
    for (int fluid = 1; fluid <= 3; fluid++)
        for (int metal = fluid; metal <= 4; metal++) {
            char text[900];
            double worst = 0.0;
            pd_ctx ctx;
            pd_setup u;
            pd_model m;
            snprintf(text, sizeof text,
                     "[grid] h = 1 um  m = %d  box = 0 .. 30 um" ACROSS "\n"
                     "[shape metal] box = 20 um .. 30 um" ACROSS "  kind = solid  material = mg4ag\n"
                     "[side x-] C = 0 mol/m3\n[transport] D = 1e-9 m2/s  initial = 0 mol/m3\n"
                     "[dissolve] rate = 5e-23 m/s * (1 - C/(1000 mol/m3))  Cs = 1e21 mol/m3  m = %d\n"
                     MIRRORS "[run] until = 1e8 s\n", fluid, metal);
            if (!play(text, &ctx, &u, &m)) return;
            for (int32_t i = 0; i < m.grid.total; i++) {
                double x[PD_DIM];
                if (m.grid.kind[i] != PD_FLUID) continue;
                pd_grid_position(&m.grid, i, x);
                worst = fmax(worst, fabs(m.transport.c[i] / (flux * x[0] / diffusivity) - 1.0));
            }
            CHECK_LE(worst, 1e-7);
            end(&ctx, &u, &m);
        }
}

#if PD_DIM == 2
#define STREAM \
    "[grid] h = 10 um  m = %d  box = -60 um .. 120 um, -60 um .. 60 um\n" \
    "[shape pin] ball = 0 um, 0 um  radius = 21.3 um  kind = %s\n%s" \
    "[side x-] flow = inlet  profile = parabola  mean = 0.05 m/s  C = 3 mol/m3\n[side x+] flow = outlet\n" \
    "[side y+] flow = %s\n[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n[transport] D = 1e-9 m2/s\n" \
    "[run] until = 10 ms\n%s"

#define WATCHED "[transfer a] box = -50 um .. 50 um, -50 um .. 50 um\n"

static double *stream(int m, const char *side, const char *watched, int *ghost, int64_t *count)
{
    char text[1200];
    pd_ctx ctx;
    pd_setup u;
    pd_model model;
    double *field = NULL;
    *count = 0;
    snprintf(text, sizeof text, STREAM, m, "wall", "", side, watched);
    if (!play(text, &ctx, &u, &model)) return NULL;
    field = (double *)calloc((size_t)(model.grid.n[0] * model.grid.n[1] * 4), sizeof *field);
    for (int j = 0; j < model.grid.n[1]; j++)
        for (int i = 0; i < model.grid.n[0]; i++) {
            int at[2];
            at[0] = i;
            at[1] = j;
            int32_t node = pd_grid_node(&model.grid, at);
            field[(*count)++] = model.transport.c[node];
            field[(*count)++] = model.flow.p[node];
            for (int d = 0; d < 2; d++) field[(*count)++] = model.flow.u[(int64_t)d * model.grid.total + node];
        }
    *ghost = model.grid.ghost;
    end(&ctx, &u, &model);
    return field;
}

/* What watches the transfer from walls asks for ghosts that the flow has no use for. Sums of the solvers go by places
 * in memory, so iterates round otherwise; solutions are the same within their tolerance. */
TEST(deeper_ghosts)
{
    static const char *const sides[] = {"noslip", "mirror"};
    for (int m = 1; m <= 2; m++)
        for (int s = 0; s < 2; s++) {
            int few, more;
            int64_t count, same;
            double *plain = stream(m, sides[s], "", &few, &count);
            double *watched = stream(m, sides[s], WATCHED, &more, &same);
            CHECK_INT(few, m);
            CHECK_INT(more, 3);
            CHECK_INT(count, same);
            double worst[4] = {0.0}, size[4] = {0.0};
            for (int64_t n = 0; n < count && plain && watched; n++) {
                worst[n % 4] = fmax(worst[n % 4], fabs(plain[n] - watched[n]));
                size[n % 4] = fmax(size[n % 4], fabs(plain[n]));
            }
            for (int k = 0; k < 4; k++) CHECK_LE(worst[k], 1e-8 * size[k]);
            CHECK(size[0] > 0.0 && size[3] > 0.0);
            free(plain);
            free(watched);
        }
}

/* Bonds of three spacings see the area of a disc that faces of cells overstate: 4/pi. */
TEST(area_of_a_disc)
{
    char text[1200];
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    double flux, area, lo[2] = {-60e-6, -60e-6}, hi[2] = {60e-6, 60e-6};
    snprintf(text, sizeof text, STREAM, 1, "solid  material = mg4ag", "", "noslip",
             "[dissolve] rate = 1 um/h * (1 - C/Csat)  Csat = 56 mol/m3\n");
    if (!play(text, &ctx, &u, &m)) return;
    pd_diagnostics_surface_flux(&ctx, &m.paths, &m.transport, &m.dissolve, lo, hi, -1, &flux, &area);
    CHECK_REL(area, 2.0 * PD_PI * 21.3e-6, 0.05);
    end(&ctx, &u, &m);
}
#endif

/* Defaults, and what is refused. */
TEST(keys)
{
    static const char *const grid[] = {"", "m = 2", "m = 4"};
    static const double fluid[2][3] = {{1.0, 2.0, 4.0}, {3.0, 2.0, 4.0}};
    static const double metal[2][3] = {{3.0, 3.0, 4.0}, {3.0, 2.0, 4.0}};
    for (int corrode = 0; corrode < 2; corrode++)
        for (int k = 0; k < 4; k++) {
            char text[800];
            pd_ctx ctx;
            pd_setup u;
            snprintf(text, sizeof text,
                     "[grid] h = 1 um  %s  box = 0 .. 30 um" ACROSS "\n"
                     "[shape metal] box = 20 um .. 30 um" ACROSS "  kind = solid  material = mg4ag\n%s%s\n"
                     "[run] until = 1 s\n", k < 3 ? grid[k] : "",
                     corrode ? "[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s"
                             : "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s", k < 3 ? "" : "  m = 5");
            if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
            CHECK_NEAR(u.fluid_m, k < 3 ? fluid[corrode][k] : corrode ? 5.0 : 1.0, 0.0);
            CHECK_NEAR(u.metal_m, k < 3 ? metal[corrode][k] : 5.0, 0.0);
            leave(&ctx, &u);
        }
    refused("[grid] h = 1 um  m = 3  box = 0 .. 30 um" ACROSS "\n"
            "[shape metal] box = 20 um .. 30 um" ACROSS "  kind = solid  material = mg4ag\n"
            "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s  m = 2\n[run] until = 1 s\n",
            "m: found 2, expected at least the horizon of the fluid, m = 3 of [grid]");
}

#if PD_DIM == 2
#define OF_DIM ENTRY(deeper_ghosts) ENTRY(area_of_a_disc)
#else
#define OF_DIM
#endif

TEST_MAIN(ENTRY(fronts) ENTRY(linear_field) ENTRY(keys) OF_DIM)
