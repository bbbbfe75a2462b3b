/* test_solid_coupling: metal of scenes under load, alone and as it dissolves.
 * dims: 2 3 */
#include "setup/fields.h"
#include "physics/reaction_force.h"
#include "physics/model.h"
#include "physics/sample.h"
#include "scene/scene.h"
#include "test.h"
#include <math.h>

#if PD_DIM == 2
#define BOX "0 .. 20 um, 0 .. 12 um"
#define METAL "0 .. 20 um, 0 .. 10 um"
#define PLANE "plane = stress"
#define DEPTH 1.0 /* [m] */
#define AROUND ""
#else
#define BOX "0 .. 24 um, 0 .. 12 um, 0 .. 8 um"
#define METAL "0 .. 24 um, 0 .. 10 um, 0 .. 8 um"
#define PLANE ""
#define DEPTH 8e-6
#define AROUND "[side z-] uz = 0 um\n"
#endif
#if PD_DIM == 2
#define DEEP ""
#define PLACE "30 um, 3 um"
#define NONE ", 0 Pa"
#define END "17 um .. 30 um, 0 .. 10 um"
#else
#define DEEP ", 0 .. 6 um"
#define PLACE "30 um, 3 um, 3 um"
#define NONE ", 0 Pa, 0 Pa"
#define END "21 um .. 30 um, 0 .. 10 um, 0 .. 8 um"
#endif
#define FLOWS \
    "[solid] E = 200 GPa  nu = 0.3  yield_stress = 200 MPa  hardening_modulus = 2 GPa\n[side x-] ux = 0 um\n" AROUND \
    "[shape g] box = 0 .. 12 um, 3 um .. 5 um" DEEP "  kind = grip  uy = 0 um\n" \
    "[side x+] ux = 0.06 um*t/(1 s)\n[run] until = 1 s\n"
#define LENGTH (PD_DIM == 2 ? 20e-6 : 24e-6)

#define LATTICE \
    "[grid] h = 1 um  m = 2  box = " BOX "\n[shape bar] box = " METAL "\n  kind = solid  material = steel304\n"
#define SOLID "[solid] E = 200 GPa  nu = 0.3  " PLANE "\n[side x-] ux = 0 um\n[side y-] uy = 0 um\n" AROUND
#define CORRODE "[corrode] rate = 0.1 um/s  Csat = 5.1 mol/L  control = activation\n[run] until = 20 s\n"

typedef struct scene_case {
    pd_ctx ctx;
    pd_setup setup;
    pd_model model;
} scene_case;

static scene_case cases[2];

static scene_case *run(int k, const char *text)
{
    scene_case *c = &cases[k];
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
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

/* A bar that its ends pull has the strain of the distance of its faces. */
TEST(faces_move)
{
    scene_case *c = run(0, LATTICE SOLID "[side x+] ux = 0.02 um\n");
    double force[PD_DIM], strain = 0.02e-6 / LENGTH, wanted = 200e9 * strain * 10e-6 * DEPTH;
    if (!c) return;
    for (int k = 0; k < c->setup.metal_body.mechanical_bcs; k++) {
        CHECK(pd_reaction_force_compute(&c->ctx, &c->model.mechanical_bc, k, c->model.time_loop.time, force) == PD_OK);
        int side = c->setup.metal_body.mechanical_bc[k].side;
        if (side == 1) CHECK_REL(force[0], wanted, 1e-5);
        if (side == 0) CHECK_REL(force[0], -wanted, 1e-5);
    }
    for (int32_t i = 0; i < c->model.solid.count; i++)
        if (!CHECK_REL(c->model.solid.mises[i], 200e9 * strain, 1e-5)) break;
    CHECK_REL(c->model.solid.static_solver.work, 0.5 * wanted * 0.02e-6, 1e-5);
    end(c);
}

/* A traction makes a uniform stress, and the end moves as far as Hooke's law says. */
TEST(traction)
{
    scene_case *c = run(0, PD_DIM == 2 ? LATTICE SOLID "[side x+] traction = 100 MPa, 0 MPa\n"
                                       : LATTICE SOLID "[side x+] traction = 100 MPa, 0 MPa, 0 MPa\n");
    double force[PD_DIM], last = 0.0;
    if (!c) return;
    const pd_solid_coupling *s = &c->model.solid;
    for (int32_t i = 0; i < s->count; i++) {
        if (!CHECK_REL(s->mises[i], 100e6, 1e-6) || !CHECK_REL(s->pressure[i], 100e6 / 3.0, 1e-6)) break;
        if (s->body.position[i * PD_DIM] > LENGTH - 1e-6) last = s->static_solver.u[i * PD_DIM];
    }
    CHECK_REL(last, 100e6 / 200e9 * (LENGTH - 0.5e-6), 1e-6);
    CHECK(pd_reaction_force_compute(&c->ctx, &c->model.mechanical_bc, 0, c->model.time_loop.time, force) == PD_OK);
    CHECK_REL(force[0], -100e6 * 10e-6 * DEPTH, 1e-6);
    end(c);
}

#if PD_DIM == 2
#define PULL "traction = %s, 0 Pa\n"
#else
#define PULL "traction = %s, 0 Pa, 0 Pa\n"
#endif

static scene_case *pull(const char *material, const char *traction)
{
    char text[1024];
    snprintf(text, sizeof text, LATTICE "[solid] E = 200 GPa  nu = 0.3  " PLANE "  %s\n[side x-] ux = 0 um\n"
             "[side y-] uy = 0 um\n" AROUND "[side x+] " PULL, material, traction);
    return run(0, text);
}

/* Stretches of a bar by the displacements of two nodes: along, and across along y. */
static void stretches(const scene_case *c, double *along, double *across)
{
    const pd_solid_coupling *s = &c->model.solid;
    const double *u = s->static_solver.u;
    int at[3] = {4, 4, 4}, next[3] = {14, 4, 4}, over[3] = {4, 7, 4};
    int32_t a = s->point[pd_grid_node(&c->model.grid, at)], b = s->point[pd_grid_node(&c->model.grid, next)];
    int32_t d = s->point[pd_grid_node(&c->model.grid, over)];
    *along = 1.0 + (u[b * PD_DIM] - u[a * PD_DIM]) / 10e-6;
    *across = 1.0 + (u[d * PD_DIM + 1] - u[a * PD_DIM + 1]) / 3e-6;
}

/* A bar under a tenth of E (3D: a hundredth), as it would be of rubber: the dead load is the first stress of Piola and
 * Kirchhoff of the stretches that it has, and nothing pulls across. */
TEST(large_strains)
{
    double mu = 200e9 / 2.6, lambda = 200e9 * 0.3 / (1.3 * 0.4), bulk = lambda + 2.0 * mu / 3.0, a, b;
    double load = PD_DIM == 3 ? 2e9 : 20e9;
    scene_case *c = pull("model = neo_hookean", PD_DIM == 3 ? "2 GPa" : "20 GPa");
    if (!c) return;
    stretches(c, &a, &b);
    double swell = log(a * b * b); /* both ways across are alike */
    NOTE("neo-Hookean: stretches of %.6f and %.6f", a, b);
    CHECK_REL(mu * (a - 1.0 / a) + lambda * swell / a, load, 1e-6);
    CHECK_NEAR(mu * (b - 1.0 / b) + lambda * swell / b, 0.0, 1e-6 * load);
    CHECK_REL(c->model.solid.stress[0] * b * b, load, 1e-6);
    end(c);
    if (PD_DIM == 3) return; /* minutes */
    c = pull("model = hencky", "20 GPa");
    if (!c) return;
    stretches(c, &a, &b);
    swell = log(a * b * b);
    CHECK_REL((bulk * swell + 2.0 * mu * (log(a) - swell / 3.0)) / a, 20e9, 1e-6);
    CHECK_NEAR(bulk * swell + 2.0 * mu * (log(b) - swell / 3.0), 0.0, 2e3);
    end(c);
    /* flow at large strains, in plane stress, too: true stress 300 MPa + 1 GPa e_p */
    c = pull("model = hencky  yield_stress = 300 MPa  hardening_modulus = 1 GPa", "400 MPa");
    if (!c) return;
    stretches(c, &a, &b);
    double tau = 400e6 * a, slip = (tau - 300e6) / 1e9; /* of Kirchhoff, whose volume is that of the reference */
    CHECK_REL(log(a), tau / 200e9 + slip, 1e-6);
    CHECK_REL(c->model.solid.plastic_strain[0], slip, 1e-6);
    double volume = LENGTH * 10e-6 * DEPTH, cost = c->model.solid.solid.dissipated(c->model.solid.solid.self);
    CHECK_REL(cost, volume * (300e6 * slip + 0.5e9 * slip * slip), 1e-6);
    end(c);
}

/* The linear peridynamic solid under a traction: its resultant is exact, its stress a few percent off at surfaces. */
TEST(ordinary)
{
    double force[PD_DIM], a, b;
    scene_case *c = pull("model = ordinary", "100 MPa");
    if (!c) return;
    stretches(c, &a, &b);
    CHECK(pd_reaction_force_compute(&c->ctx, &c->model.mechanical_bc, 0, c->model.time_loop.time, force) == PD_OK);
    CHECK_REL(force[0], -100e6 * 10e-6 * DEPTH, 1e-6);
    NOTE("strain %.4f of Hooke's", (a - 1.0) / (100e6 / 200e9));
    CHECK_REL(a - 1.0, 100e6 / 200e9, 0.05);
    end(c);
}

/* Energy of each place is that of all together, and stresses are those of the load. */
TEST(fields)
{
    scene_case *c = pull("", "100 MPa");
    double all = 0.0;
    if (!c) return;
    const pd_solid_coupling *s = &c->model.solid;
    pd_sample_prepare(&c->ctx, &c->model, pd_fields_bit(PD_FIELD_STRAIN_ENERGY));
    for (int32_t i = 0; i < s->count; i++) {
        double wanted = 0.5 * 100e6 * 100e6 / 200e9;
        all += s->body.volume[i] * pd_sample_get_node(&c->model, PD_FIELD_STRAIN_ENERGY, s->node[i]);
        if (!CHECK_REL(pd_sample_get_node(&c->model, PD_FIELD_STRAIN_ENERGY, s->node[i]), wanted, 1e-6)) break;
        CHECK_REL(pd_sample_get_node(&c->model, PD_FIELD_SIGMA_XX, s->node[i]), 100e6, 1e-6);
        CHECK_NEAR(pd_sample_get_node(&c->model, PD_FIELD_SIGMA_YY, s->node[i]), 0.0, 100.0);
        CHECK_NEAR(pd_sample_get_node(&c->model, PD_FIELD_SIGMA_ZZ, s->node[i]), 0.0, 100.0);
        CHECK_NEAR(pd_sample_get_node(&c->model, PD_FIELD_SIGMA_XY, s->node[i]), 0.0, 100.0);
    }
    CHECK_REL(all, s->static_solver.stored, 1e-12);
    end(c);
}

/* Metal comes apart when its largest principal stress is beyond its strength, and not before. */
TEST(strength)
{
    static const char *const strengths[2] = {"101 MPa", "99 MPa"};
    for (int k = 0; k < 2; k++) { /* a stress of 100 MPa */
        char text[1024];
        snprintf(text, sizeof text, LATTICE "[solid] E = 200 GPa  nu = 0.3  " PLANE "  strength = %s\n[side x-] ux = 0"
                 " um\n[side y-] uy = 0 um\n" AROUND "[side x+] ux = %g nm\n", strengths[k], 1e9 * LENGTH * 5e-4);
        scene_case *c = run(0, text);
        if (!c) return;
        const pd_quasi_static *rest = &c->model.solid.static_solver;
        if (!k) CHECK_INT(rest->broken, 0);
        else CHECK(rest->stored <= 1e-9 * rest->work);
        end(c);
    }
}

/* Mechanics beside dissolution changes no bit of it, unless its stress is asked for. */
TEST(dissolution_alone)
{
    scene_case *alone = run(0, LATTICE CORRODE), *loaded = run(1, LATTICE SOLID
                     "[side x+] ux = 0.02 um\n[solid]\nrtol = 1e-9\n" CORRODE);
    if (!alone || !loaded) return;
    size_t size = (size_t)alone->model.grid.total * sizeof(double);
    CHECK(alone->model.grid.solid_count < alone->model.time_loop.solid_nodes_start);
    CHECK(memcmp(alone->model.transport.c, loaded->model.transport.c, size) == 0);
    CHECK_INT(alone->model.time_loop.steps, loaded->model.time_loop.steps);
    CHECK_LE(loaded->model.solid.static_solver.stored, loaded->model.solid.static_solver.work);
    double taken = loaded->model.solid.static_solver.work - loaded->model.solid.static_solver.stored;
    CHECK_REL(loaded->model.solid.static_solver.dissolved_energy, taken, 5e-8);
    end(alone);
    end(loaded);
}

/* Gutman's factor of the mean stress (table gutman: 1.331 at 100 MPa with 7.09e-6 m3/mol and 298 K): ends that are held
 * apart keep the stress while the bar gets thinner. */
TEST(gutman)
{
    double factor = exp(100e6 * 7.09e-6 / (8.31446261815324 * 298.0));
    scene_case *alone = run(0, LATTICE CORRODE);
    scene_case *loaded =
        run(1, PD_DIM == 2 ? LATTICE "[solid] E = 200 GPa nu = 0.3 plane = stress\n"
                                     "dissolution_factor = exp(sigma_h * 7.09e-6 m3/mol / (R * 298 K))\n"
                                     "[side x-] ux = 0 um\n[side y-] uy = 0 um\n[side x+] ux = 0.03 um\n" CORRODE
                           : LATTICE
                   "[solid] E = 200 GPa nu = 0.3 dissolution_factor = exp(sigma_h * 7.09e-6 m3/mol / (R * 298 K))\n"
                   "[side x-] ux = 0 um\n[side y-] uy = 0 um\n[side z-] uz = 0 um\n[side x+] ux = 0.036 um\n" CORRODE);
    if (!alone || !loaded) return;
    double slow = pd_time_loop_volume_loss(&alone->model.time_loop),
           fast = pd_time_loop_volume_loss(&loaded->model.time_loop);
    NOTE("gutman: loss %.5f without stress, %.5f with it: %.4f, expected %.4f", slow, fast, fast / slow, factor);
    CHECK_REL(factor, 1.331, 1e-3);
    CHECK_REL(fast / slow, factor, 0.01);
    end(alone);
    end(loaded);
}

/* A bar that is stretched everywhere beyond the critical stretch bears nothing: the bonds across, which are not
 * stretched, do not hold it. All that was stored is released. */
TEST(torn)
{
    scene_case *c =
        run(0, LATTICE "[solid] E = 200 GPa  nu = 0.3  " PLANE "  critical_stretch = 1e-3\n[side x-] ux = 0 um\n"
                       "[side y-] uy = 0 um\n" AROUND "[side x+] ux = 0.1 um\n");
    double force[PD_DIM];
    if (!c) return;
    const pd_quasi_static *rest = &c->model.solid.static_solver;
    for (int k = 0; k < c->setup.metal_body.mechanical_bcs; k++) {
        CHECK(pd_reaction_force_compute(&c->ctx, &c->model.mechanical_bc, k, c->model.time_loop.time, force) == PD_OK);
        CHECK(fabs(force[0]) <= 1e-9 * 200e9 * 5e-3 * 10e-6 * DEPTH);
    }
    NOTE("torn: %.0f bonds, %.6g of %.6g J released", (double)rest->broken, rest->released, rest->work);
    CHECK(rest->stored <= 1e-9 * rest->work);
    CHECK_REL(rest->released, rest->work, 1e-6);
    end(c);
}

/* A bar that has flowed bears the stress of flow on the section that is left, 2/sqrt(3) of it in plane strain. */
TEST(thinning)
{
    double force[PD_DIM], flow = PD_DIM == 2 ? 200e6 * 2.0 / sqrt(3.0) : 200e6;
    scene_case *c = run(0, LATTICE "[solid] E = 200 GPa nu = 0.3 yield_stress = 200 MPa\n[side x-] ux = 0 um\n" AROUND
                                   "[side y-] uy = 0 um\n[side x+] ux = 0.2 um\n" CORRODE);
    if (!c) return;
    double left = 1.0 - pd_time_loop_volume_loss(&c->model.time_loop), section = left * 10e-6 * DEPTH;
    for (int k = 0; k < c->setup.metal_body.mechanical_bcs; k++) {
        if (c->setup.metal_body.mechanical_bc[k].side != 1) continue;
        CHECK(pd_reaction_force_compute(&c->ctx, &c->model.mechanical_bc, k, c->model.time_loop.time, force) == PD_OK);
        NOTE("thinning: %.4f of the metal bears %.5g N, expected %.5g", left, force[0], flow * section);
        CHECK(left < 0.85 && left > 0.75);
        CHECK_REL(force[0], flow * section, 1e-3);
    }
    end(c);
}

/* A bar of which half is behind a plane of symmetry gets thinner, and bears what is left of it. */
TEST(thinning_beside_a_mirror)
{
    double force[PD_DIM], strain = 0.02e-6 / LENGTH;
    scene_case *c = run(0, LATTICE "[solid] E = 200 GPa  nu = 0.3  " PLANE "\n[side x-] ux = 0 um\n"
                        "[side y-] flow = mirror\n" AROUND "[side x+] ux = 0.02 um\n" CORRODE);
    if (!c) return;
    double left = 1.0 - pd_time_loop_volume_loss(&c->model.time_loop);
    CHECK(left < 0.85 && left > 0.75);
    CHECK(c->model.grid.solid_count < c->model.time_loop.solid_nodes_start);
    for (int k = 0; k < c->setup.metal_body.mechanical_bcs; k++) {
        if (c->setup.metal_body.mechanical_bc[k].side != 1) continue;
        CHECK(pd_reaction_force_compute(&c->ctx, &c->model.mechanical_bc, k, c->model.time_loop.time, force) == PD_OK);
        NOTE("%.4f of the metal bears %.5g N", left, force[0]);
        CHECK_REL(force[0], 200e9 * strain * left * 10e-6 * DEPTH, 1e-3);
    }
    end(c);
}

/* The half of a bar beside a mirror along its middle yields as the whole one does: half the work of flow, half the
 * energy, and the same displacements. */
TEST(flow_beside_a_mirror)
{
    double cost[2], stored[2], most[2] = {0.0, 0.0};
    for (int half = 0; half < 2; half++) {
        scene_case *c = run(half, half ?
            "[grid] h = 1 um  m = 2  box = 0 .. 12 um, 4 um .. 10 um" DEEP "\n"
            "[shape bar] box = 0 .. 12 um, 4 um .. 8 um" DEEP "\n  kind = solid  material = steel304\n"
            "[side y-] flow = mirror\n" FLOWS :
            "[grid] h = 1 um  m = 2  box = 0 .. 12 um, -2 um .. 10 um" DEEP "\n"
            "[shape bar] box = 0 .. 12 um, 0 .. 8 um" DEEP "\n  kind = solid  material = steel304\n" FLOWS);
        if (!c) return;
        const pd_quasi_static *q = &c->model.solid.static_solver;
        cost[half] = q->solid.dissipated(q->solid.self);
        stored[half] = q->stored;
        for (int64_t k = 0; k < q->n; k++) most[half] = fmax(most[half], fabs(q->u[k]));
    }
    CHECK(cost[0] > 0.5 * stored[0]);
    CHECK_REL(2.0 * cost[1], cost[0], 1e-5);
    CHECK_REL(2.0 * stored[1], stored[0], 1e-5);
    CHECK_REL(most[1], most[0], 1e-5);
    for (int half = 0; half < 2; half++) end(&cases[half]);
}

/* What a body cannot be built or loaded with has one message. */
TEST(refused_when_built)
{
    static const char *const wrong[][2] = {
        {LATTICE SOLID "[side y+] uy = 0 um\n", "no metal on the side y+, expected some that it holds or loads"},
        {LATTICE SOLID "[shape g] ball = " PLACE "  radius = 2 um  kind = grip  ux = 0 um\n",
         "no metal in a shape that is to hold it"},
        {LATTICE SOLID "[side x+] ux = 1 um/(x/1 um - x/1 um)\n", "a displacement or load of x+ is inf at x = "},
        {LATTICE SOLID "[side x+] traction = 1 Pa/(x/1 um - x/1 um)" NONE "\n",
         "a displacement or load of x+ is inf at"},
        {LATTICE SOLID "[shape g] box = " END "  kind = grip  ux = 1 um/(x/1 um - x/1 um)\n",
         "a displacement of a grip is inf at x = "}};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        scene_case *c = &cases[0];
        memset(c, 0, sizeof *c);
        pd_ctx_init(&c->ctx);
        if (!CHECK_OK(&c->ctx, pd_scene_parse(&c->ctx, "bar", wrong[k][0], NULL, 0, &c->setup))) continue;
        pd_status status = pd_model_build(&c->ctx, &c->setup, &c->model);
        if (status == PD_OK)
            status = pd_time_loop_run(&c->ctx, &c->model.time_loop, c->setup.end_time, 0.0, NULL, NULL);
        CHECK(status < 0);
        if (!CHECK(strstr(c->ctx.message, wrong[k][1]) != NULL)) NOTE("%d: %s", (int)k, c->ctx.message);
        end(c);
    }
}

/* Metal that hardly changes its volume is noted where displacements of it are known to be off. */
TEST(notes)
{
    static const char *const texts[4] = {LATTICE "[solid] E = 200 GPa  nu = 0.46\n[side x-] ux = 0 um\n",
                                         LATTICE "[solid] E = 200 GPa  nu = 0.46  m = 1\n[side x-] ux = 0 um\n",
                                         LATTICE "[solid] E = 200 GPa  nu = 0.49  m = 1\n[side x-] ux = 0 um\n",
                                         LATTICE "[solid] E = 200 GPa  nu = 0.49  model = ordinary\n"
                                                 "[side x-] ux = 0 um\n"};
    for (int k = 0; k < 4; k++) {
        scene_case *c = &cases[0];
        int found = 0;
        memset(c, 0, sizeof *c);
        pd_ctx_init(&c->ctx);
        if (!CHECK_OK(&c->ctx, pd_scene_parse(&c->ctx, "bar", texts[k], NULL, 0, &c->setup))) continue;
        for (int n = 0; n < c->setup.notes; n++) found += strstr(c->setup.note[n], "is too stiff by more") != NULL;
        CHECK_INT(found, k == 0 || k == 2);
        end(c);
    }
}

/* What a scene gets wrong has one message. */
TEST(refused)
{
    static const char *const wrong[][2] = {
        {LATTICE "[solid] E = 200 GPa  nu = 0.3\n", "nothing that loads"},
        {LATTICE "[solid] E = -1 Pa  nu = 0.3\n[side x-] ux = 0 um\n", "E"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.5\n[side x-] ux = 0 um\n", "nu"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3  dissolution_factor = 2\n[side x-] ux = 0 um\n", "dissolves"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3  hardening_modulus = 1 GPa\n[side x-] ux = 0 um\n", "yield"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3\n[side x-] ux = 0 um * t / (1 s)\n", "until"},
        {LATTICE "[shape g] box = " METAL "\n kind = grip\n[solid] E = 1 GPa  nu = 0.3\n", "holds nothing"},
        {LATTICE "[side x-] ux = 0 um\n", "ux"},
        {LATTICE "[output] deformation_scale = 10\n", "without [solid]"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3\n[side x-] ux = 0 um\n[output] deformation_scale = -1\n",
         "deformation_scale"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3  critical_stretch = 0.1  strength = 1 MPa\n[side x-] ux = 0 um\n",
         "beside"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3  model = ordinary  yield_stress = 1 MPa\n[side x-] ux = 0 um\n",
         "hencky"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3  model = hencky  fracture_energy = 1 J/m2\n[side x-] ux = 0 um\n",
         "expected another one of both"},
        {LATTICE "[shape g] box = " METAL "\n kind = grip  ux = 0 um\n", "'grip' without a [solid] section"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3  body_force = 1 N/m3\n", "found 1 component"},
        {LATTICE "[solid] E = 1e-31 Pa  nu = 0.3\n[side x-] ux = 0 um\n", "expected at least 1e-30 Pa"},
        {LATTICE "[solid] E = 1 GPa  nu = 0.3\n[side x-] ux = 0 um\n[side y-] flow = periodic\n"
                 "[side y+] flow = periodic\n",
         "found beside a periodic side"},
#if PD_DIM == 2
        {LATTICE "[solid] E = 1 GPa  nu = 0.3  plane = stress  yield_stress = 10 MPa\n[side x-] ux = 0 um\n",
         "found with plane = stress, expected plane = strain or model = hencky"},
        {"[grid] h = 1 um, 2 um  box = " BOX "\n[shape bar] box = " METAL "  kind = solid  material = steel304\n"
         "[solid] E = 1 GPa  nu = 0.3\n[side x-] ux = 0 um\n",
         "found different spacings of the axes"},
        {"[grid] h = 1 um  geometry = axisymmetric  box = " BOX "\n[shape bar] box = " METAL "\n kind = solid  "
         "material = steel304\n[solid] E = 1 GPa  nu = 0.3\n[side x-] ux = 0 um\n",
         "found in a box with geometry = axisymmetric"},
#endif
        {"[grid] h = 1 um  box = " BOX "\n[solid] E = 1 GPa  nu = 0.3\n[side x-] ux = 0 um\n", "no metal"}
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        scene_case *c = &cases[0];
        memset(c, 0, sizeof *c);
        pd_ctx_init(&c->ctx);
        CHECK(pd_scene_parse(&c->ctx, "bar", wrong[k][0], NULL, 0, &c->setup) < 0);
        CHECK(strstr(c->ctx.message, wrong[k][1]) != NULL);
        if (!strstr(c->ctx.message, wrong[k][1])) NOTE("%d: %s", (int)k, c->ctx.message);
        CHECK_INT(c->ctx.in_use, 0);
    }
}

TEST_MAIN(ENTRY(faces_move) ENTRY(traction) ENTRY(large_strains) ENTRY(ordinary) ENTRY(fields) ENTRY(strength)
          ENTRY(dissolution_alone) ENTRY(gutman) ENTRY(thinning) ENTRY(thinning_beside_a_mirror) ENTRY(torn)
          ENTRY(flow_beside_a_mirror) ENTRY(refused_when_built) ENTRY(notes) ENTRY(refused))
