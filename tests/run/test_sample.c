/* sample: probes and lines beside walls, on surfaces, at sides, and as metal dissolves.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "run/monitor.h"
#include "physics/sample.h"
#include "lattice/quadratic_fit.h"
#include "random.h"
#include "scene_file.h"
#include "transport/settle.h"
#include <math.h>

static pd_ctx ctx;
static pd_setup setup;
static pd_model model;

static int start(const char *text)
{
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &setup))) return 0;
    if (CHECK_OK(&ctx, pd_model_build(&ctx, &setup, &model))) {
        if (model.transport.c) pd_sample_prepare(&ctx, &model, 0);
        return 1;
    }
    leave(&ctx, &setup);
    return 0;
}

static void stop(void)
{
    pd_model_free(&ctx, &model);
    leave(&ctx, &setup);
}

/* A number from 0 to 1, the same each time; the ends and quarters come often. */
static double draw(uint32_t *state)
{
    uint32_t k = next_random(state) >> 8;
    return k % 5 == 0 ? (double)(k / 5 % 5) / 4.0 : (k % 10007) / 10006.0;
}

static void place(uint32_t *state, double *x)
{
    for (int d = 0; d < PD_DIM; d++) x[d] = setup.lo[d] + draw(state) * (setup.hi[d] - setup.lo[d]);
}

enum { PLACES = 400 };

#if PD_DIM > 1
#if PD_DIM == 2
#define BOX(x, y, z) x ", " y
#else
#define BOX(x, y, z) x ", " y ", " z
#endif

static double radius(const double *x)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += x[d] * x[d];
    return sqrt(sum);
}

/* Flow between plates, one of which may move: exact everywhere, on the plates, at sides of any kind, on cells of any
 * shape. */
static void check_plates(const char *h, int m, const char *sides, double lid)
{
    char text[1200];
    uint32_t state = 7;
    double worst = 0.0, wall = 0.0;
    snprintf(text, sizeof text,
             "[grid] h = %s m = %d box = " BOX(
                 "0 .. 2 m", "0 .. 1 m",
                 "0 .. 1 m") "\n%s"
                             "[side y-] flow = noslip\n[side y+] flow = noslip velocity = " BOX(
                                 "%g m/s", "0 m/s", "0 m/s") "\n"
                                                             "[flow] rho = 1 kg/m3 mu = 1 Pa s time = prescribed "
                                                             "reference_speed = 1 m/s reference_length = 1 m\n"
                                                             "vx = 1 m/s * (%g * y/(1 m) + 4 * y/(1 m)*(1 - y/(1 m)))\n"
                                                             "[transport] D = 1 m2/s\n[run] until = 1 s\n",
             h, m, sides, lid, lid);
    if (!start(text)) return;
    for (int k = 0; k < PLACES; k++) {
        double x[PD_DIM];
        place(&state, x);
        double exact = lid * x[1] + 4.0 * x[1] * (1.0 - x[1]);
        double error = fabs(pd_sample_get_point(&model, PD_FIELD_V, 0, x) - exact);
        worst = fmax(worst, error);
        if (!(x[1] > 0.0) || !(x[1] < 1.0)) wall = fmax(wall, error);
        for (int d = 1; d < PD_DIM; d++) CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_V, d, x), 0.0, 1e-12);
    }
    CHECK_LE(worst, 2e-9);
    CHECK_LE(wall, 1e-11);
    stop();
}

#define PERIODIC "[side x-] flow = periodic\n[side x+] flow = periodic\n"
#define THROUGH "[side x-] flow = open\n[side x+] flow = open\n"
#if PD_DIM == 2
#define ACROSS(kind)
#else
#define ACROSS(kind) "[side z-] flow = " kind "\n[side z+] flow = " kind "\n"
#endif

TEST(between_plates)
{
    for (int m = 1; m <= (PD_DIM == 3 ? 2 : 4); m++) {
        check_plates("0.1 m", m, PERIODIC ACROSS("periodic"), 0.0);
        check_plates(PD_DIM == 2 ? "0.1 m, 0.05 m" : "0.1 m, 0.05 m, 0.1 m", m, THROUGH ACROSS("mirror"), 0.0);
        check_plates("0.1 m", m, PERIODIC ACROSS("mirror"), 1.5);
    }
    check_plates(PD_DIM == 2 ? "0.2 m, 0.01 m" : "0.2 m, 0.02 m, 0.2 m", 2, PERIODIC ACROSS("periodic"), 0.0);
    check_plates(PD_DIM == 2 ? "0.02 m, 0.25 m" : "0.1 m, 0.25 m, 0.5 m", 2, THROUGH ACROSS("mirror"), 0.0);
    check_plates("1 m", 1, PERIODIC ACROSS("periodic"), 0.0); /* one node between the plates */
}

/* Beside a ball whose surface cuts the cells: the velocity is zero on all of it, also where the cell is wall, and the
 * error between falls with the third power. */
static double ball_error(int n, double m, double shift, double *on)
{
    char text[1200];
    uint32_t state = 3;
    double worst = 0.0;
    int served = 0;
    snprintf(text, sizeof text,
             "[grid] h = %.17g m m = %g box = " BOX(
                 "%.17g m .. %.17g m", "-1 m .. 1 m",
                 "-1 m .. 1 m") "\n"
                                "[shape b] ball = " BOX(
                                    "0", "0", "0") " radius = 0.43 m kind = wall\n" PERIODIC
                                                   "[side y-] flow = mirror\n[side y+] flow = mirror\n" ACROSS(
                                                       "mirror") "[flow] rho = 1 kg/m3 mu = 1 Pa s time = prescribed "
                                                                 "reference_speed = 1 m/s reference_length = 1 m\n"
                                                                 "vx = 1 m/s * log((x*x + y*y%s)/(0.43 m)^2)\n"
                                                                 "[transport] D = 1 m2/s\n[run] until = 1 s\n",
             2.0 / n, m, -1.0 + shift * 2.0 / n, 1.0 + shift * 2.0 / n, PD_DIM == 3 ? " + z*z" : "");
    *on = 0.0;
    if (!start(text)) return 1.0;
    for (int k = 0; k < PLACES; k++) {
        double x[PD_DIM], r, length;
        place(&state, x);
        length = radius(x);
        if (!(length > 0.1)) continue;
        r = k % 2 ? 0.43 : 0.43 + (4.0 / n) * draw(&state);
        for (int d = 0; d < PD_DIM; d++) x[d] *= r / length;
        double exact = k % 2 ? 0.0 : 2.0 * log(radius(x) / 0.43),
               value = pd_sample_get_point(&model, PD_FIELD_V, 0, x);
        CHECK(pd_sample_is_inside(&model, x));
        if (k % 2) *on = fmax(*on, fabs(value - exact));
        else worst = fmax(worst, fabs(value - exact));
        CHECK(value == value);
        served++;
    }
    CHECK(served > PLACES / 2);
    stop();
    return worst;
}

TEST(beside_a_ball)
{
    for (int m = 1; m <= (PD_DIM == 3 ? 2 : 3); m++)
        for (int k = 0; k < 2; k++) {
            double on[2], coarse = ball_error(PD_DIM == 3 ? 16 : 24, m, 0.37 * k, &on[0]);
            double fine = ball_error(PD_DIM == 3 ? 32 : 96, m, 0.37 * k, &on[1]);
            NOTE("m = %d: off by %.3g, %.3g, on the surface by %.3g, %.3g", m, coarse, fine, on[0], on[1]);
            CHECK_LE(1.9, log(coarse / fine) / log(PD_DIM == 3 ? 2.0 : 4.0));
            CHECK_LE(fine, PD_DIM == 3 ? 0.03 : 3e-3);
            CHECK_LE(on[0], 1e-8);
            CHECK_LE(on[1], 1e-8);
        }
}

static void hold(void *user, const double *x, double *force);

/* The pressure p [Pa] at the fluid nodes of a flow at rest of 2 kg/m3, and the force that holds it. */
static void press(double (*p)(const double *x))
{
    static double (*pressure)(const double *x);
    pressure = p;
    model.flow.body_force_fn = hold;
    model.flow.body_force_user = &pressure;
    for (int64_t i = 0; i < PD_DIM * (int64_t)model.grid.total; i++) model.flow.u[i] = 0.0;
    for (int32_t i = 0; i < model.grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&model.grid, i, x);
        if (model.grid.kind[i] == PD_FLUID) model.flow.p[i] = p(x) / 2.0;
    }
    pdi_flow_update_derived_fields(&ctx, &model.flow);
}

static double straight(const double *x) { return 3.0 + 5.0 * (2.0 - x[0]); }

/* The body force [m/s2] that holds a fluid at rest under the pressure p. */
static void hold(void *user, const double *x, double *force)
{
    double (*p)(const double *) = *(double (**)(const double *))user, at[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        memcpy(at, x, sizeof at);
        at[d] = x[d] + 0.5;
        force[d] = p(at) / 2.0;
        at[d] = x[d] - 0.5;
        force[d] -= p(at) / 2.0;
    }
}

/* A linear pressure is exact on walls, at an outlet and between. */
TEST(pressure_on_walls)
{
    uint32_t state = 11;
    if (!start("[grid] h = 0.1 m m = 3 box = " BOX("0 .. 2 m", "0 .. 1 m", "0 .. 1 m") "\n"
               "[shape b] ball = " BOX("0.97 m", "0.5 m", "0.5 m") " radius = 0.23 m kind = wall\n"
               "[side x-] flow = inlet profile = uniform mean = 1 m/s\n[side x+] flow = outlet p = 3 Pa\n"
               "[flow] rho = 2 kg/m3 mu = 1 Pa s\n")) return;
    press(straight);
    for (int k = 0; k < PLACES; k++) {
        double x[PD_DIM], r = 0.0;
        place(&state, x);
        for (int d = 0; d < PD_DIM; d++) r += pow(x[d] - (d == 0 ? 0.97 : 0.5), 2.0);
        if (sqrt(r) < 0.23) continue;
        CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_P, 0, x), straight(x), 1e-9);
    }
    for (int side = 0; side < 2; side++) { /* front and back of the ball */
        double x[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) x[d] = d == 0 ? 0.97 + (side ? 0.23 : -0.23) : 0.5;
        CHECK(pd_sample_is_inside(&model, x));
        CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_P, 0, x), straight(x), 1e-9);
    }
    stop();
}

/* A quadratic pressure is exact on a ball that cuts the lattice anywhere, on the sides and between. */
static double bent(const double *x)
{
    double p = 3.0 + 5.0 * x[0] - 4.0 * x[0] * x[0] + 7.0 * x[0] * x[1] + 2.0 * x[1] * x[1];
    return p - (PD_DIM == 3 ? 6.0 * x[1] * x[PD_DIM - 1] - 3.0 * x[PD_DIM - 1] * x[PD_DIM - 1] : 0.0);
}

TEST(bent_pressure_on_walls)
{
    static const double middle[3] = {0.97, 0.513, 0.502};
    uint32_t state = 13;
    int served = 0;
    if (!start("[grid] h = 0.05 m m = 2 box = " BOX(
            "0 .. 2 m", "0 .. 1 m",
            "0 .. 1 m") "\n"
                        "[shape b] ball = " BOX("0.97 m", "0.513 m",
                                                "0.502 m") " radius = 0.23 m kind = wall\n"
                                                           "[flow] rho = 2 kg/m3 mu = 1 Pa s time = prescribed "
                                                           "reference_speed = 1 m/s reference_length = 1 m\n"
                                                           "[transport] D = 1 m2/s\n[run] until = 1 s\n"))
        return;
    press(bent);
    for (int k = 0; k < PLACES; k++) {
        double x[PD_DIM], r = 0.0;
        place(&state, x);
        for (int d = 0; d < PD_DIM; d++) r += pow(x[d] - middle[d], 2.0);
        r = sqrt(r);
        if (!(r > 0.05)) continue;
        for (int d = 0; d < PD_DIM && (k % 2 || r < 0.23); d++) x[d] = middle[d] + (x[d] - middle[d]) * 0.23 / r;
        CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_P, 0, x), bent(x), 1e-8);
        served++;
    }
    CHECK(served > PLACES / 2);
    stop();
}

/* Even along each axis about the middle of the box. */
static double even(const double *x)
{
    double p = cos(3.0 * (x[0] - 1.0)) + cosh(4.0 * (x[1] - 0.5));
    return PD_DIM == 3 ? p * cos(5.0 * (x[PD_DIM - 1] - 0.5)) : p;
}

/* An even pressure about a ball in the middle is even, with families of any size. */
TEST(mirrored_pressure)
{
    for (int m = 1; m <= 3; m++) {
        uint32_t state = 5;
        char text[1000];
        double far = 0.0;
        snprintf(text, sizeof text,
                 "[grid] h = 0.1 m m = %d box = " BOX(
                     "0 .. 2 m", "0 .. 1 m",
                     "0 .. 1 m") "\n"
                                 "[shape b] ball = " BOX("1 m", "0.5 m",
                                                         "0.5 m") " radius = 0.23 m kind = wall\n"
                                                                  "[side x-] flow = inlet profile = uniform mean = 1 "
                                                                  "m/s\n[side x+] flow = outlet p = 3 Pa\n"
                                                                  "[flow] rho = 2 kg/m3 mu = 1 Pa s\n",
                 m);
        if (!start(text)) return;
        press(even);
        for (int k = 0; k < PLACES; k++) {
            double x[PD_DIM], r = 0.0;
            place(&state, x);
            for (int d = 0; d < PD_DIM; d++) x[d] = (d ? 0.5 : 1.0) + 0.4 * (x[d] - (d ? 0.5 : 1.0));
            for (int d = 0; d < PD_DIM; d++) r += pow(x[d] - (d ? 0.5 : 1.0), 2.0);
            if (sqrt(r) < 0.23) continue;
            double p = pd_sample_get_point(&model, PD_FIELD_P, 0, x);
            for (int d = 0; d < PD_DIM; d++) {
                double y[PD_DIM];
                memcpy(y, x, sizeof y);
                y[d] = (d ? 1.0 : 2.0) - x[d];
                far = fmax(far, fabs(pd_sample_get_point(&model, PD_FIELD_P, 0, y) - p));
            }
        }
        NOTE("m = %d: %.2e apart", m, far);
        CHECK_LE(far, 1e-10);
        stop();
    }
}

/* As metal dissolves its surface is that of its cells, and the places of former metal are fluid. */
TEST(dissolving_metal)
{
    if (!start("[grid] h = 0.1 m m = 2 box = " BOX(
            "0 .. 2 m", "0 .. 1 m",
            "0 .. 1 m") "\n"
                        "[shape b] box = " BOX(
                            "0.8 m .. 1.2 m", "0 .. 0.4 m",
                            "0 .. 1 m") " kind = solid\n" PERIODIC
                                        "[side y+] flow = mirror\n" ACROSS(
                                            "mirror") "[flow] rho = 1 kg/m3 mu = 1 Pa s "
                                                      "reference_speed = 1 m/s reference_length = 1 m "
                                                      "body_force = " BOX("1 m/s2", "0", "0") "\n"
                                                                                              "[transport] D = 1 "
                                                                                              "m2/s\n[dissolve] rate "
                                                                                              "= 1 um/s\n[run] until "
                                                                                              "= 1 s\n"))
        return;
    double on[PD_DIM], above[PD_DIM], deep[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) on[d] = above[d] = deep[d] = d == 0 ? 1.03 : d == 1 ? 0.4 : 0.5;
    above[1] = 0.3;
    deep[1] = 0.15;
    for (int32_t i = 0; i < model.grid.total; i++)
        if (model.grid.kind[i] == PD_FLUID) model.flow.u[i] = 1.0;
    pdi_flow_update_derived_fields(&ctx, &model.flow);
    CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_V, 0, on), 0.0, 1e-8);
    CHECK(pd_sample_is_inside(&model, deep));
    double value = pd_sample_get_point(&model, PD_FIELD_V, 0, deep);
    CHECK(value != value);
    int32_t changed[4000], count = 0;
    for (int32_t i = 0; i < model.grid.total; i++) {
        double x[PD_DIM];
        int at[PD_DIM];
        pd_grid_position(&model.grid, i, x);
        pd_grid_index(&model.grid, i, at);
        if (pd_grid_is_inside(&model.grid, at) && model.grid.kind[i] == PD_SOLID && x[1] > 0.3) changed[count++] = i;
    }
    for (int32_t n = 0; n < count; n++) pdi_grid_set_fluid(&model.grid, changed[n]);
    CHECK_OK(&ctx, pd_bonds_update(&ctx, changed, count, &model.bonds));
    CHECK_OK(&ctx, pd_flow_update(&ctx, changed, count, &model.flow));
    for (int32_t n = 0; n < count; n++) model.flow.u[changed[n]] = 1.0;
    pdi_flow_update_derived_fields(&ctx, &model.flow);
    CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_V, 0, above), 0.0, 1e-8);
    CHECK_LE(0.9, pd_sample_get_point(&model, PD_FIELD_V, 0, on));
    stop();
}
#endif

#if PD_DIM == 2
/* A tube: exact on its wall, on its axis and between. */
TEST(tube)
{
    uint32_t state = 5;
    if (!start("[grid] h = 0.1 m m = 3 box = 0 .. 2 m, 0 .. 1 m geometry = axisymmetric\n" PERIODIC
               "[flow] rho = 1 kg/m3 mu = 1 Pa s time = prescribed reference_speed = 1 m/s reference_length = 1 m vx = "
               "1 m/s*(1 - y*y/(1 m)^2)\n"
               "[transport] D = 1 m2/s\n[run] until = 1 s\n"))
        return;
    for (int k = 0; k < PLACES; k++) {
        double x[2];
        place(&state, x);
        CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_V, 0, x), 1.0 - x[1] * x[1], 1e-9);
        CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_V, 1, x), 0.0, 1e-12);
    }
    stop();
}
#endif

/* Concentrations: linear between held walls, quadratic up to one that nothing passes. */
static void check_linear(int m, int closed)
{
    char text[600];
    uint32_t state = 9;
    snprintf(text, sizeof text,
             "[grid] h = 0.1 m m = %d box = 0 .. 1 m%s\n[side x-] C = 1 mol/m3\n[side x+] %s\n"
             "[transport] D = 1 m2/s initial = 1 mol/m3 * (1 + 3*x/(1 m)%s)\n[run] until = 1 s\n", m,
             PD_DIM == 1 ? "" : PD_DIM == 2 ? ", 0 .. 0.5 m" : ", 0 .. 0.5 m, 0 .. 0.3 m",
             closed ? "flow = noslip" : "C = 4 mol/m3", closed ? " - 1.5*x*x/(1 m)^2" : "");
    if (!start(text)) return;
    for (int k = 0; k < PLACES; k++) {
        double x[PD_DIM];
        place(&state, x);
        double exact = 1.0 + 3.0 * x[0] - (closed ? 1.5 * x[0] * x[0] : 0.0);
        CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_C, 0, x), exact, 1e-9);
    }
    stop();
}

TEST(concentration_at_walls)
{
    for (int m = 1; m <= (PD_DIM == 3 ? 2 : 4); m++)
        for (int closed = 0; closed < 2; closed++) check_linear(m, closed);
}

/* Across the surface of a medium the field bends: the steady layers are exact on both sides and on the surface. */
TEST(concentration_in_layers)
{
    char text[800];
    const char *across = PD_DIM == 1 ? "" : PD_DIM == 2 ? "[side y-] flow = mirror\n[side y+] flow = mirror\n"
                                          : "[side y-] flow = mirror\n[side y+] flow = mirror\n"
                                            "[side z-] flow = mirror\n[side z+] flow = mirror\n";
    for (int k = 0; k < 3; k++) {
        double place = k == 0 ? 0.5 : k == 1 ? 0.53 : 0.55, flux = 1.0 / (place + (1.0 - place) / 0.01);
        snprintf(text, sizeof text,
                 "[grid] h = 0.1 m m = 2 box = 0 .. 1 m%s\n[shape f] half_space = yes point = %g m%s normal = -1%s "
                 "kind = medium D = 0.01 m2/s\n[side x-] C = 1 mol/m3\n[side x+] C = 0\n"
                 "%s[transport] D = 1 m2/s time = steady\n",
                 PD_DIM == 1 ? "" : PD_DIM == 2 ? ", 0 .. 0.5 m" : ", 0 .. 0.5 m, 0 .. 0.3 m", place,
                 PD_DIM == 1 ? "" : PD_DIM == 2 ? ", 0" : ", 0, 0", PD_DIM == 1 ? "" : PD_DIM == 2 ? ", 0" : ", 0, 0",
                 across);
        if (!start(text)) return;
        pd_transport_result result;
        CHECK_OK(&ctx, pd_transport_steady(&ctx, &model.transport, &result));
        for (int n = 0; n <= 200; n++) {
            double x[PD_DIM], s = n / 200.0;
            for (int d = 0; d < PD_DIM; d++) x[d] = d == 0 ? s : 0.17;
            double exact = 1.0 - flux * (fmin(s, place) + fmax(s - place, 0.0) / 0.01);
            CHECK_NEAR(pd_sample_get_point(&model, PD_FIELD_C, 0, x), exact, 1e-7);
        }
        stop();
    }
}

/* A probe inside a wall is refused with its distance from the surface; one on the surface is not. */
TEST(probe_in_a_wall)
{
    static const char *const scenes[] = {"0.25 m", "0.5 m"};
    for (int k = 0; k < 2; k++) {
        char text[600];
        pd_monitors monitors;
        snprintf(text, sizeof text,
                 "[grid] h = 0.1 m m = 2 box = 0 .. 1 m%s\n[shape w] half_space = yes point = 0.5 m%s normal = 1%s "
                 "kind = wall\n[transport] D = 1 m2/s\n[run] until = 1 s\n[probe a] at = %s%s\n",
                 PD_DIM == 1 ? "" : PD_DIM == 2 ? ", 0 .. 0.5 m" : ", 0 .. 0.5 m, 0 .. 0.3 m",
                 PD_DIM == 1 ? "" : PD_DIM == 2 ? ", 0" : ", 0, 0", PD_DIM == 1 ? "" : PD_DIM == 2 ? ", 0" : ", 0, 0",
                 scenes[k], PD_DIM == 1 ? "" : PD_DIM == 2 ? ", 0.2 m" : ", 0.2 m, 0.1 m");
        if (!start(text)) return;
        int status = pdi_monitors_build(&ctx, &model, &monitors);
        CHECK_INT(status, k == 0 ? PD_ERR_GEOMETRY : PD_OK);
        if (k == 0) CHECK(strstr(ctx.message, "250 mm") != NULL);
        if (k == 0) NOTE("message: %s", ctx.message);
        pdi_monitors_free(&ctx, &monitors);
        stop();
    }
}

#if PD_DIM > 1
/* Of a line of nodes along x the fit knows nothing across it: what it does not know is zero, whatever the data miss
 * each other by. Two values lie at each node, one above and one below what holds, which is a quadratic in x. */
TEST(what_no_datum_gives)
{
    uint32_t state = 3;
    double worst = 0.0, h[PD_DIM];
    for (int k = 0; k < PLACES; k++) {
        pdi_quadratic_fit fit;
        double x[PD_DIM], at[PD_DIM], miss = 3.0 * draw(&state), scale = 1e-9 * (1.0 + draw(&state));
        for (int d = 0; d < PD_DIM; d++) {
            h[d] = scale;
            x[d] = (0.1 + 0.3 * draw(&state)) * scale;
        }
        pdi_quadratic_fit_init(&fit, x, h);
        for (int i = -1; i <= 1; i++) {
            for (int d = 0; d < PD_DIM; d++) at[d] = d ? 0.0 : i * scale;
            double exact = 50.0 + 7.0 * i - 2.0 * i * i;
            pdi_quadratic_fit_add_value(&fit, at, exact + miss);
            pdi_quadratic_fit_add_value(&fit, at, exact - miss);
        }
        double z = x[0] / scale, exact = 50.0 + 7.0 * z - 2.0 * z * z;
        worst = fmax(worst, fabs(pdi_quadratic_fit_solve(&fit) - exact));
    }
    CHECK_LE(worst, 1e-9);
}
#endif

#if PD_DIM == 1
#define MORE
#elif PD_DIM == 2
#define MORE ENTRY(between_plates) ENTRY(beside_a_ball) ENTRY(pressure_on_walls) \
    ENTRY(bent_pressure_on_walls) ENTRY(mirrored_pressure) ENTRY(dissolving_metal) ENTRY(tube) \
    ENTRY(what_no_datum_gives)
#else
#define MORE ENTRY(between_plates) ENTRY(beside_a_ball) ENTRY(pressure_on_walls) \
    ENTRY(bent_pressure_on_walls) ENTRY(mirrored_pressure) ENTRY(dissolving_metal) ENTRY(what_no_datum_gives)
#endif
TEST_MAIN(ENTRY(concentration_at_walls) ENTRY(concentration_in_layers) ENTRY(probe_in_a_wall) MORE)
