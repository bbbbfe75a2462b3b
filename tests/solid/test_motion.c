/* Metal of scenes in motion, and metal of springs: waves, oscillations and energies against closed forms, a crack that
 * branches.
 * dims: 1 2 3 */
#include "physics/reaction_force.h"
#include "physics/model.h"
#include "scene/scene.h"
#include "test.h"
#include <math.h>
#include <string.h>

#if PD_DIM == 1
#define ACROSS ""
#define NU ""
#define ZERO ""
#define AREA 1.0 /* [m2] */
#elif PD_DIM == 2
#define ACROSS ", 0 .. 8 mm"
#define NU "nu = 0.2  plane = stress"
#define ZERO ", 0 Pa"
#define AREA 8e-3
#else
#define ACROSS ", 0 .. 6 mm, 0 .. 6 mm"
#define NU "nu = 0.2"
#define ZERO ", 0 Pa, 0 Pa"
#define AREA 36e-6
#endif

/* A bar of 80 mm with a Young's modulus of 200 GPa and 8000 kg/m3: waves go at 5 km/s. */
#define LENGTH 0.08
#define YOUNG 200e9
#define DENSITY 8e3
#define SPEED 5e3
#define BAR \
    "[grid] h = 1 mm  box = 0 .. 80 mm" ACROSS "\n[shape bar] box = 0 .. 80 mm" ACROSS "  kind = solid\n"
#define MOVES "  dynamics = yes  density = 8000 kg/m3\n"

static const char *const materials[] = {"model = correspondence  " NU, "model = bond_based"};
static const char *const planes[] = {"", PD_DIM == 2 ? "  plane = stress" : ""};

typedef struct scene_case {
    pd_ctx ctx;
    pd_setup setup;
    pd_model model;
} scene_case;

static scene_case one;

static scene_case *run(const char *text)
{
    scene_case *c = &one;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    c->ctx.threads = 1;
    if (!CHECK_OK(&c->ctx, pd_scene_parse(&c->ctx, "bar", text, NULL, 0, &c->setup))) return NULL;
    if (!CHECK_OK(&c->ctx, pd_model_build(&c->ctx, &c->setup, &c->model))) return NULL;
    if (!CHECK_OK(&c->ctx, pd_time_loop_run(&c->ctx, &c->model.time_loop, c->setup.end_time, 0.0, NULL, NULL)))
        return NULL;
    return c;
}

static void end(scene_case *c)
{
    pd_model_free(&c->ctx, &c->model);
    pd_setup_free(&c->ctx, &c->setup);
    CHECK_INT(c->ctx.in_use, 0);
}

/* Momentum along x [kg m/s], and the mean displacement of the last cells [m]. */
static double momentum(const pd_solid_coupling *s, double *last)
{
    double sum = 0.0, mean = 0.0;
    int ends = 0;
    for (int32_t i = 0; i < s->count; i++) {
        double x[PD_DIM];
        pd_grid_position(s->grid, s->node[i], x);
        sum += DENSITY * s->body.volume[i] * s->dynamic_solver.v[(int64_t)i * PD_DIM];
        if (x[0] < LENGTH - 1e-3) continue;
        mean += s->dynamic_solver.u[(int64_t)i * PD_DIM];
        ends++;
    }
    *last = mean / ends;
    return sum;
}

/* A free bar that is pulled at one end from rest. Its momentum is the impulse. Before the wave comes back the end moves
 * at stress/(density speed). */
TEST(pulled)
{
    for (int k = 0; k < 2; k++) {
        char text[900];
        double last, stress = 1e6, t = 12e-6;
        snprintf(text, sizeof text, BAR "[side x+] traction = 1 MPa" ZERO "\n[solid] E = 200 GPa  %s%s" MOVES
                 "[run] until = 12 us\n", materials[k], planes[k]);
        scene_case *c = run(text);
        if (!c) return;
        CHECK_REL(momentum(&c->model.solid, &last), stress * AREA * t, 1e-9);
        double wanted = stress / (DENSITY * SPEED) * t;
        NOTE("%s: the end has moved %.4f of what the wave says", k ? "springs" : "small strains", last / wanted);
        CHECK_REL(last, wanted, PD_DIM == 1 ? 0.03 : 0.05);
        end(c);
    }
}

#if PD_DIM < 3
/* One end is held and the other one suddenly pulled: it swings between zero and twice its displacement at rest, with
 * the period 4 L/c. */
TEST(swings)
{
    for (int k = 0; k < 2 && (k == 0 || PD_DIM == 1); k++) { /* thin bars of springs are too stiff */
        char text[900];
        double there, back;
        for (int half = 1; half <= 2; half++) {
            snprintf(text, sizeof text, BAR "[shape foot] box = 0 .. 1 mm" ACROSS "  kind = grip  ux = 0 mm\n"
                     "[side x+] traction = 1 MPa" ZERO "\n[solid] E = 200 GPa  %s%s" MOVES "[run] until = %d us\n",
                     materials[k], planes[k], 32 * half);
            scene_case *c = run(text);
            if (!c) return;
            momentum(&c->model.solid, half == 1 ? &there : &back);
            end(c);
        }
        double wanted = 2.0 * 1e6 * (LENGTH - 0.5e-3) / YOUNG;
        NOTE("%s: %.4f of twice the displacement at rest, and back to %.4f of that", k ? "springs" : "small strains",
             there / wanted, back / wanted);
        CHECK_REL(there, wanted, 0.04);
        CHECK_NEAR(back, 0.0, 0.03 * wanted);
    }
}
#endif

/* What a grip that speeds up needs: density times wave speed times its velocity. Its work is kinetic or stored, but for
 * an error of second order in the step. */
TEST(driven)
{
    for (int k = 0; k < 2; k++) {
        double off[2];
        for (int fine = 0; fine < 2; fine++) {
            char text[900];
            double force[PD_DIM], velocity = 1e5 * 12e-6;
            snprintf(text, sizeof text, BAR "[shape hand] box = 79 mm .. 80 mm" ACROSS
                     "  kind = grip  ux = 5e4 m/s2 * t^2\n[solid] E = 200 GPa  %s%s" MOVES
                     "[run] until = 12 us  max_step = %s us\n", materials[k], planes[k], fine ? "0.02" : "0.04");
            scene_case *c = run(text);
            if (!c) return;
            const pd_solid_coupling *s = &c->model.solid;
            double left =
                pd_verlet_kinetic(&s->dynamic_solver) + s->solid.energy(&c->ctx, s->solid.self, s->dynamic_solver.u);
            off[fine] = fabs(s->dynamic_solver.work / left - 1.0);
            CHECK(pd_reaction_force_compute(&c->ctx, &c->model.mechanical_bc, 0, c->model.time_loop.time, force) ==
                  PD_OK);
            CHECK_REL(force[0], DENSITY * SPEED * velocity * AREA, 0.02);
            end(c);
        }
        NOTE("%s: energies differ by %.1e, %.1e with half the step", k ? "springs" : "small strains", off[0], off[1]);
        CHECK_LE(off[1], 2e-5);
        CHECK(off[1] < 0.35 * off[0] || off[1] < 1e-9);
    }
}

#if PD_DIM < 3 /* thin bars of springs are too stiff in 3D */
/* Springs between grips that move apart have the stiffness of the bar. */
TEST(springs_in_balance)
{
    char text[900];
    double force[PD_DIM];
    snprintf(text, sizeof text, BAR "[shape foot] box = 0 .. 3 mm" ACROSS "  kind = grip  ux = 0 mm\n"
             "[shape hand] box = 77 mm .. 80 mm" ACROSS "  kind = grip  ux = 1 um\n%s[solid] E = 200 GPa  %s%s\n",
             PD_DIM == 1 ? "" : "[shape mid] box = 40 mm .. 41 mm, 4 mm .. 5 mm  kind = grip  uy = 0 mm\n",
             materials[1], planes[1]);
    scene_case *c = run(text);
    if (!c) return;
    CHECK(pd_reaction_force_compute(&c->ctx, &c->model.mechanical_bc, 1, c->model.time_loop.time, force) == PD_OK);
    /* the first and last bonds see points that move with the grips */
    double strain = 1e-6 / (LENGTH - 6e-3 + 1e-3);
    NOTE("force %.4f of E strain", fabs(force[0]) / (YOUNG * strain * AREA));
    CHECK_REL(fabs(force[0]), YOUNG * strain * AREA, 0.015);
    end(c);
}
#endif

#if PD_DIM == 2
/* Soda-lime glass under 14 MPa: the crack branches, no faster than surface waves, and both halves mirror to the bit. */
TEST(branches)
{
    scene_case *c =
        run("[grid] h = 0.5 mm  box = 0 .. 100 mm, 0 .. 40 mm\n"
            "[shape plate] box = 0 .. 100 mm, 0 .. 40 mm  kind = solid\n"
            "[crack notch] points = 0 mm, 20 mm, 50 mm, 20 mm\n"
            "[side y-] traction = 0, -14 MPa\n[side y+] traction = 0, 14 MPa\n"
            "[solid] model = bond_based  E = 72 GPa  plane = stress  fracture_energy = 135 J/m2  dynamics = yes\n"
            "  density = 2440 kg/m3\n[run] until = 40 us\n");
    if (!c) return;
    const pd_solid_coupling *s = &c->model.solid;
    double far = 0.0, off = 0.0, most = 0.0;
    for (int32_t i = 0; i < s->count; i++) {
        int at[2];
        double x[2];
        pd_grid_index(s->grid, s->node[i], at);
        pd_grid_position(s->grid, s->node[i], x);
        at[1] = s->grid->n[1] - 1 - at[1];
        int32_t mirror = s->point[pd_grid_node(s->grid, at)];
        most = fmax(most, fabs(s->dynamic_solver.u[2 * i + 1]));
        if (s->dynamic_solver.u[2 * i] < s->dynamic_solver.u[2 * mirror] ||
            s->dynamic_solver.u[2 * i] > s->dynamic_solver.u[2 * mirror] ||
            s->dynamic_solver.u[2 * i + 1] < -s->dynamic_solver.u[2 * mirror + 1] ||
            s->dynamic_solver.u[2 * i + 1] > -s->dynamic_solver.u[2 * mirror + 1])
            off += 1.0;
        if (pdi_solid_coupling_damage(s, i) < 0.3) continue;
        far = fmax(far, x[0] > 60e-3 ? fabs(x[1] - 20e-3) : 0.0);
        CHECK_LE(x[0], 50e-3 + 40e-6 * 3100.0); /* Rayleigh's speed */
    }
    CHECK(most > 0.0);
    CHECK_INT((int)off, 0);
    CHECK_LE(4e-3, far); /* two branches */
    double left = pd_verlet_kinetic(&s->dynamic_solver) + s->solid.energy(&c->ctx, s->solid.self, s->dynamic_solver.u) +
                  s->bond_based.released;
    CHECK_REL(s->dynamic_solver.work, left, 2e-3);
    end(c);
}
#define OF_DIM ENTRY(swings) ENTRY(springs_in_balance) ENTRY(branches)
#elif PD_DIM == 1
#define OF_DIM ENTRY(swings) ENTRY(springs_in_balance)
#else
#define OF_DIM
#endif

TEST_MAIN(ENTRY(pulled) SLOW_ENTRY_IF(PD_DIM == 3, driven) OF_DIM)
