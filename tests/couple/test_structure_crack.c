/* test_structure_crack: cracks that metal of scenes has from the start, their tips and their J.
 * dims: 1 2 3 */
#include "physics/model.h"
#include "run/monitor.h"
#include "run/sim.h"
#include "solid/crack.h"
#include "solid/fracture_calibration.h"
#include "test.h"
#include "cases/strip.h"
#include <math.h>

/* A cut of x = 0 .. 6 um at a height, and places of 1D. */
#if PD_DIM == 1
#define BOX "0 .. 20 um"
#define CUT(x, y) "points = " x "\n"
#elif PD_DIM == 2
#define BOX "0 .. 20 um, 0 .. 10 um"
#define CUT(x, y) "points = 0 um, " y ", " x ", " y "\n"
#else
#define BOX "0 .. 20 um, 0 .. 10 um, 0 .. 6 um"
#define CUT(x, y) "points = 0 um, " y ", 0 um, " x ", " y ", 0 um, " x ", " y ", 6 um, 0 um, " y ", 6 um\n"
#endif
#define BAR "[grid] h = 1 um  box = " BOX "\n[shape bar] box = " BOX "  kind = solid\n[side x-] ux = 0 um\n"
#define METAL BAR "[solid] E = 200 GPa" POISSON "\n"
#if PD_DIM == 1
#define POISSON ""
#else
#define POISSON "  nu = 0.3"
#endif

typedef struct scene_case {
    pd_ctx ctx;
    pd_setup setup;
    pd_model model;
    pd_monitors monitors;
} scene_case;

static scene_case test_case;

static scene_case *build(const char *text)
{
    scene_case *c = &test_case;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    if (!CHECK_OK(&c->ctx, pd_scene_parse(&c->ctx, "bar", text, NULL, 0, &c->setup))) return NULL;
    return CHECK_OK(&c->ctx, pd_model_build(&c->ctx, &c->setup, &c->model)) ? c : NULL;
}

static void end(scene_case *c)
{
    pdi_monitors_free(&c->ctx, &c->monitors);
    pd_model_free(&c->ctx, &c->model);
    pd_setup_free(&c->ctx, &c->setup);
    CHECK_INT(c->ctx.in_use, 0);
}

/* Whether a straight line between two places in [um] crosses the cut; places on it lie above. */
static int crosses(const double *x, const double *y, double last, double height)
{
    int d = PD_DIM > 1;
    double place = PD_DIM > 1 ? height : last, below = x[d] - place, above = y[d] - place;
    if (fabs(below) < 1e-6) below = 0.0;
    if (fabs(above) < 1e-6) above = 0.0;
    if ((below < 0.0) == (above < 0.0)) return 0;
    return PD_DIM == 1 || x[0] + (y[0] - x[0]) * below / (below - above) <= last + 1e-6;
}

static void check_bonds(const scene_case *c, double last, double height)
{
    const pd_body *body = &c->model.solid.body;
    int64_t wrong = 0, broken = 0;
    for (int32_t i = 0; i < body->count; i++) {
        double x[PD_DIM], y[PD_DIM], share = 0.0;
        for (int d = 0; d < PD_DIM; d++) x[d] = 1e6 * body->position[i * PD_DIM + d];
        for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);) {
            for (int d = 0; d < PD_DIM; d++) y[d] = 1e6 * body->position[b.neighbour * PD_DIM + d];
            int is = crosses(x, y, last, height);
            wrong += is != pd_body_bond_is_broken(&b);
            broken += is;
            share += is / (double)(body->first_bond[i + 1] - body->first_bond[i]);
        }
        wrong += fabs(pdi_solid_coupling_damage(&c->model.solid, i) - share) > 1e-12;
    }
    CHECK_INT(wrong, 0);
    CHECK(broken > 0);
}

/* A cut between rows of nodes, through a row, and two that a line has: what a straight line says. */
TEST(bonds)
{
    scene_case *c = build(METAL "[crack a] " CUT("6 um", "5 um"));
    if (!c) return;
    check_bonds(c, 6.0, 5.0);
    end(c);
    c = build(METAL "[crack a] " CUT("6.5 um", "4.5 um"));
    if (!c) return;
    check_bonds(c, 6.5, 4.5);
    end(c);
#if PD_DIM == 2
    c = build(METAL "[crack a] points = 0 um, 5 um, 2.5 um, 5 um, 6 um, 5 um\n");
    if (!c) return;
    check_bonds(c, 6.0, 5.0);
    end(c);
#endif
}

#if PD_DIM > 1
/* Each cut has the tip of its own crack, to a cell. */
TEST(tips)
{
    scene_case *c =
        build(PD_DIM == 2 ? METAL "[crack a] " CUT("6 um", "5 um") "[crack b] points = 20 um, 5 um, 15 um, 5 um\n"
                          : METAL
                  "[crack a] " CUT(
                      "6 um", "5 um") "  direction = 1, 0, 0\n[crack b] points = 20 um, 5 um, 0 um, 15 um, 5 um, 0 um, "
                                      "15 um, 5 um, 6 um, 20 um, 5 um, 6 um  direction = -2, 0, 0\n");
    if (!c || !CHECK_OK(&c->ctx, pdi_monitors_build(&c->ctx, &c->model, &c->monitors))) return;
    const pd_monitor *m = c->monitors.monitor + 2; /* behind the side and the body */
    CHECK_INT(c->setup.monitors, 4);
    for (int k = 0; k < 2; k++) {
        CHECK_STR(m[k].desc->name, k ? "b" : "a");
        CHECK_INT(m[k].count, 3);
        CHECK_NEAR(m[k].output[0].value, k ? 15e-6 : 6e-6, 1e-6);
        CHECK_NEAR(m[k].output[1].value, 5e-6, 1e-12);
        if (PD_DIM == 3) CHECK_NEAR(m[k].output[2].value, 3e-6, 1e-12);
        if (PD_DIM == 2) CHECK_NEAR(m[k].output[2].value, k ? 5e-6 : 6e-6, 1e-6);
    }
    end(c);
}
#endif

#if PD_DIM == 2
/* A strip whose clamped edges are pulled apart has (lambda + 2 mu) e^2 H/2 of J, for a crack far from its ends. */
TEST(strip)
{
    scene_case *c = build(
        "[grid] h = 0.5 um  box = 0 .. 40 um, 0 .. 20 um\n[shape bar] box = 0 .. 40 um, 0 .. 20 um  kind = solid\n"
        "[side y-] ux = 0 um  uy = 0 um\n[side y+] ux = 0 um  uy = 0.004 um\n"
        "[solid] E = 45 GPa  nu = 0.3  rtol = 1e-5\n"
        "[crack a] points = 0 um, 10 um, 16 um, 10 um  contour_radii = 2 um, 5 um, 8 um\n");
    if (!c || !CHECK_OK(&c->ctx, pd_time_loop_run(&c->ctx, &c->model.time_loop, c->setup.end_time, 0.0, NULL, NULL)))
        return;
    if (!CHECK_OK(&c->ctx, pdi_monitors_build(&c->ctx, &c->model, &c->monitors))) return;
    const pd_monitor *m = c->monitors.monitor + 3;
    double wanted = 0.5 * 45e9 * 0.7 / (1.3 * 0.4) * 2e-4 * 2e-4 * 20e-6;
    CHECK_STR(m->output[3].key, "J_inner");
    double inner = m->output[3].value, outer = m->output[4].value;
    NOTE("strip: J is %.4f and %.4f of that of a long strip", inner / wanted, outer / wanted);
    CHECK_REL(inner, outer, 2e-3);
    CHECK_REL(outer, wanted, 0.05);
    end(c);
    /* a contour that reaches the end of the strip has no J */
    c = build("[grid] h = 1 um  box = 0 .. 20 um, 0 .. 20 um\n[shape bar] box = 0 .. 20 um, 0 .. 20 um  kind = solid\n"
              "[side y-] ux = 0 um  uy = 0 um\n[side y+] ux = 0 um  uy = 0.004 um\n[solid] E = 45 GPa  nu = 0.3\n"
              "[crack a] points = 0 um, 10 um, 15 um, 10 um  contour_radii = 1 um, 4 um, 9 um\n");
    if (!c || !CHECK_OK(&c->ctx, pdi_monitors_build(&c->ctx, &c->model, &c->monitors))) return;
    CHECK(!isnan(c->monitors.monitor[3].output[3].value));
    CHECK(isnan(c->monitors.monitor[3].output[4].value));
    end(c);
}

/* The same on eight cells. */
TEST(coarse_toughness)
{
    static const strip_case run = {8, 0, 0.7 / (1.3 * 0.4), "nu = 0.3  m = 1"};
    double j = 0.0, closed = 0.0;
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, strip_run(&ctx, &run, &j, &closed))) return;
    NOTE("runs at %.4f of its toughness, %.4f in a long strip", j, closed);
    CHECK_REL(j, 1.0, 0.1);
    CHECK_INT(ctx.in_use, 0);
}

/* A crack runs when J reaches the toughness, whatever the material and its horizon. */
TEST(toughness)
{
    static const strip_case run[] = {{16, 0, 0.7 / (1.3 * 0.4), "nu = 0.3"},
                                     {16, 0, 0.55 / (1.45 * 0.1), "nu = 0.45"},
                                     {16, 0, 0.7 / (1.3 * 0.4), "nu = 0.3  m = 1"},
                                     {16, 0, 1.0, "nu = 0  plane = stress"}};
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (size_t k = 0; k < sizeof run / sizeof run[0]; k++) {
        double j = 0.0, closed = 0.0;
        if (!CHECK_OK(&ctx, strip_run(&ctx, &run[k], &j, &closed))) return;
        NOTE("%s: runs at %.4f of its toughness, %.4f in a long strip", run[k].solid, j, closed);
        CHECK_REL(j, 1.0, 0.05);
    }
    CHECK_INT(ctx.in_use, 0);
}
#endif

#if PD_DIM == 3
/* The same with a front between two free sides, which has steps. A straight front in a lattice without sides would need
 * a fifth more. */
TEST(toughness)
{
    static const strip_case run = {16, 5, 0.7 / (1.3 * 0.4), "nu = 0.3"};
    double j = 0.0, closed = 0.0;
    pd_ctx ctx;
    if (!getenv("PD_HARD")) SKIP("50 s, with PD_HARD=1 alone; validate has a smaller one");
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, strip_run(&ctx, &run, &j, &closed))) return;
    NOTE("runs at %.4f of its toughness, %.4f in a long strip", j, closed);
    CHECK_REL(j, 1.0, 0.05);
    CHECK_INT(ctx.in_use, 0);
}
#endif

#if PD_DIM > 1
/* A toughness is that of a lattice, in 3D with a horizon of some spacings. */
TEST(toughness_of_no_lattice)
{
    pd_ctx ctx;
    pd_body body;
    pd_correspondence_desc desc;
    double critical = 1.0;
    pd_ctx_init(&ctx);
    memset(&body, 0, sizeof body);
    memset(&desc, 0, sizeof desc);
    desc.young = 1.0;
    body.horizon = 2e-6;
    CHECK_INT(pdi_fracture_calibration_compute_critical(&ctx, &body, &desc, 1.0, &critical), PD_ERR_GEOMETRY);
    CHECK(strstr(ctx.message, "fracture_calibration: the points are those of no lattice: expected a spacing") ==
          ctx.message);
    body.spacing = NAN;
    CHECK_INT(pdi_fracture_calibration_compute_critical(&ctx, &body, &desc, 1.0, &critical), PD_ERR_GEOMETRY);
    for (int wide = 0; wide < 2 && PD_DIM == 3; wide++) {
        body.spacing = wide ? 2e-6 / 3.01 : 2e-6 / 1.49;
        CHECK_INT(pdi_fracture_calibration_compute_critical(&ctx, &body, &desc, 1.0, &critical), PD_ERR_ARGUMENT);
        CHECK(strstr(ctx.message, wide ? "a horizon of 3.01 spacings with the energy of a crack in 3D"
                                       : "a horizon of 1.49 spacings") != NULL);
    }
    CHECK_INT(ctx.in_use, 0);
}
#endif

/* What a scene gets wrong has one message. */
TEST(refused)
{
    static const char *const wrong[][2] = {
        {BAR "[crack a] " CUT("6 um", "5 um"), "found no [solid] section"},
        {METAL "[crack] " CUT("6 um", "5 um"), "expected a short name"},
#if PD_DIM > 1
        {METAL "[crack a] points = 0 um, 5 um\n", "corners"},
        {METAL "[crack a] " CUT("6 um", "5 um") " direction = 0, 0\n", "expected a direction"},
#endif
#if PD_DIM == 2
        {METAL "[crack a] points = 0 um, 5 um, 3 um\n", "found 3 numbers"},
        {METAL "[crack a] points = 0 um, 5 um, 0 um, 5 um\n", "corner 2 at the place of corner 1"},
        {METAL "[crack a] " CUT("6 um", "5 um") " contour_radii = 1 um, 2 um, 5 um\n", "a horizon"},
        {METAL "[crack a] " CUT("6 um", "5 um") " contour_radii = 1 um, 5 um\n", "found 2 lengths, expected 3"},
        {METAL "[crack a] points = 0 um, 50 um, 3 um, 50 um\n", "the crack 'a' crosses no bond"},
#elif PD_DIM == 3
        {METAL "[crack a] " CUT("6 um", "5 um") " contour_radii = 1 um, 3 um, 5 um\n", "expected 2D"},
        {METAL "[crack a] points = 0 um, 0 um, 0 um, 5 um, 0 um, 0 um, 5 um, 5 um, 1 um, 0 um, 5 um, 0 um\n",
         "do not lie in a plane"},
#else
        {METAL "[crack a] points = 25 um\n", "the crack 'a' crosses no bond"},
        {METAL "[crack a] points = 5 um, 7 um\n", "expected one place"},
#endif
#if PD_DIM == 3
        {BAR "[solid] E = 200 GPa  nu = 0.3  m = 1  fracture_energy = 1 J/m2\n", "m = 1.5 to 3"},
#endif
        {METAL "[crack a] points = 5\n", "without unit"}
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        scene_case *c = &test_case;
        memset(c, 0, sizeof *c);
        pd_ctx_init(&c->ctx);
        pd_status status = pd_scene_parse(&c->ctx, "bar", wrong[k][0], NULL, 0, &c->setup);
        if (status == PD_OK) {
            status = pd_model_build(&c->ctx, &c->setup, &c->model);
            pd_setup_free(&c->ctx, &c->setup);
        }
        CHECK(status < 0);
        if (!CHECK(strstr(c->ctx.message, wrong[k][1]) != NULL)) NOTE("%d: %s", (int)k, c->ctx.message);
        CHECK_INT(c->ctx.in_use, 0);
    }
}

#if PD_DIM == 1
TEST_MAIN(ENTRY(bonds) ENTRY(refused))
#elif PD_DIM == 2
TEST_MAIN(ENTRY(bonds) ENTRY(tips) ENTRY(strip) ENTRY(coarse_toughness) SLOW_ENTRY(toughness)
          ENTRY(toughness_of_no_lattice) ENTRY(refused))
#else
TEST_MAIN(ENTRY(bonds) ENTRY(tips) SLOW_ENTRY(toughness)
          ENTRY(toughness_of_no_lattice) ENTRY(refused))
#endif
