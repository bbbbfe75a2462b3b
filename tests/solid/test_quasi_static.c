/* test_quasi_static: bodies under loads that change, bonds that break, and the balance of energies.
 * dims: 1 2 3 */
#include "random.h"
#include "solid/body_bonds.h"
#include "solid/correspondence.h"
#include "solid/ordinary_state.h"
#include "solid/quasi_static.h"
#include "test.h"
#include <math.h>

#ifndef CUTS
#define CUTS 8
#endif
#define MOST 2000 /* points */
#define YOUNG 70e9

typedef struct body_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence elastic;
    pd_ordinary_state ordinary;
    pd_quasi_static rest;
    double position[MOST * PD_DIM], volume[MOST];
    uint8_t held[MOST * PD_DIM];
    double h, pull;  /* [m], [m/s] of the end, or [Pa/s] on it */
    int dead;        /* 1: a traction pulls, 2: a force on half of the points, along the last axis, 3: along x */
    double shift;    /* [m] of the lattice */
    double follows;  /* [-] how much less the end moves, over how much the point of its row at x = 0.5 moves */
    const double *given; /* [count] [m] where the end is; NULL: where the above says */
    double runs;     /* [m] by which the end asks to move on, whatever it has moved */
    int none;        /* 1: the material has no state */
    int asked;       /* how often loads were asked for */
    int stuck;       /* the material bears nothing new between this time that loads are asked for and the next one */
    pd_status (*force)(pd_ctx *ctx, void *self, const double *u, double *force); /* of the material */
} body_case;

static body_case test_case;

/* The point of the row of point i at x = 0.5. */
static int32_t inner(const body_case *c, int32_t i)
{
    int wide = (int)(1.0 / c->h + 0.5);
    return i - i % wide + wide / 2;
}

/* Where point i of the end is [m], for displacements u of all. */
static double end_of(const body_case *c, double t, const double *u, int32_t i)
{
    if (c->given) return c->given[i];
    if (c->runs > 0.0) return u[i * PD_DIM] + c->runs;
    return c->pull * t - (c->follows > 0.0 ? c->follows * u[inner(c, i) * PD_DIM] : 0.0);
}

/* The end x = 1 moves, or a traction pulls there, or a force pulls what lies beyond x = 0.5. */
static pd_status pulled(pd_ctx *ctx, void *user, double t, double *u, double *load)
{
    body_case *c = (body_case *)user;
    (void)ctx;
    c->asked++;
    for (int32_t i = 0; i < c->body.count; i++) {
        double x[1] = {c->position[i * PD_DIM] - c->shift};
        if (c->dead > 1 && x[0] > 0.5) load[i * PD_DIM + (c->dead == 2 ? PD_DIM - 1 : 0)] = c->pull * t;
        if (x[0] < c->h) for (int d = 0; d < PD_DIM; d++) u[i * PD_DIM + d] = 0.0;
        if (x[0] > 1.0 - c->h && !c->dead) u[i * PD_DIM] = end_of(c, t, u, i);
        if (x[0] > 1.0 - 4.0 * c->h && c->dead == 1)
            load[i * PD_DIM] = -c->pull * t * c->elastic.surface_vector[i * PD_DIM];
    }
    return PD_OK;
}

/* A bar of length 1, 2 n cells long and n wide; from both faces a slit half as long as it is wide at x = 0.5 leaves the
 * middle. */
static body_case *bar_at(int n, int slit, int dead, double yield, double stretch, double shift)
{
    body_case *c = &test_case;
    pd_correspondence_desc desc;
    pd_quasi_static_desc rest;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    c->h = 0.5 / n;
    c->dead = dead;
    c->shift = shift;
    int all = 2 * n;
    for (int d = 1; d < PD_DIM; d++) all *= d == 1 ? n : 2;
    for (int k = 0; k < all; k++) {
        double *x = c->position + c->desc.count * PD_DIM;
        for (int d = 0, rest_of = k; d < PD_DIM; d++) {
            int wide = d == 0 ? 2 * n : d == 1 ? n : 2;
            x[d] = (rest_of % wide + 0.5) * c->h + shift;
            rest_of /= wide;
        }
        c->volume[c->desc.count++] = pow(c->h, PD_DIM);
    }
    for (int32_t i = 0; i < c->desc.count; i++)
        for (int d = 0; d < PD_DIM; d++)
            c->held[i * PD_DIM + d] = c->position[i * PD_DIM] - shift < c->h ||
                                      (d == 0 && !dead && c->position[i * PD_DIM] - shift > 1.0 - c->h);
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = 2.0 * c->h;
    c->desc.spacing = c->h;
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body))) return NULL;
    for (int32_t i = 0; i < c->body.count && slit; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);) {
            const double *x = c->position + i * PD_DIM, *to = c->position + b.neighbour * PD_DIM;
            double y = PD_DIM > 1 ? fabs(0.5 * (x[1] + to[1]) - 0.25) : 0.0;
            if ((x[0] < 0.5) != (to[0] < 0.5) && y > 0.125) pdi_body_bonds_mark_broken(&c->body, i, b.number);
        }
    memset(&desc, 0, sizeof desc);
    desc.young = YOUNG;
    desc.poisson = 0.3;
    desc.yield = yield;
    desc.hardening = 0.01 * YOUNG;
    desc.detach_singular = 1;
    if (!CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, &c->body, &desc, &c->elastic))) return NULL;
    memset(&rest, 0, sizeof rest);
    rest.prescribed = c->held;
    rest.load = pulled;
    rest.user = c;
    rest.criterion.critical = stretch;
    rest.break_fraction = -1.0;
    pd_material_interface solid = pd_correspondence_material(&c->elastic);
    return CHECK_OK(&c->ctx, pd_quasi_static_build(&c->ctx, &solid, &rest, &c->rest)) ? c : NULL;
}

static body_case *bar(int n, int slit, int dead, double yield, double stretch)
{
    return bar_at(n, slit, dead, yield, stretch, 0.0);
}

/* Breaks the bonds across x = 0.5 by chance, all but that share; 0: all but one that is parallel to x. */
static int cut(body_case *c, double left, uint32_t *seed)
{
    double middle = 0.5 + c->shift;
    int kept = 0;
    for (int32_t i = 0; i < c->body.count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);) {
            const double *x = c->position + i * PD_DIM, *y = c->position + b.neighbour * PD_DIM;
            double aside = 0.0;
            if (!(x[0] < middle) || y[0] < middle) continue;
            for (int d = 1; d < PD_DIM; d++) aside = fmax(aside, fabs(x[d] - y[d]));
            if (left > 0.0 ? random_share(seed) < left : !kept && aside < 0.1 * c->h && y[0] - x[0] < 1.5 * c->h &&
                x[PD_DIM > 1] > middle - 0.25) {
                kept++;
                continue;
            }
            pd_body_break(&c->body, i, b.neighbour);
        }
    return CHECK_OK(&c->ctx, pd_correspondence_update(&c->ctx, &c->elastic)) ? kept : 0;
}

static void end(body_case *c)
{
    pd_quasi_static_free(&c->ctx, &c->rest);
    pd_correspondence_free(&c->ctx, &c->elastic);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

/* Nothing breaks: work is stored, whatever the way and back, by loads and by what is held. */
TEST(work_is_stored)
{
    for (int dead = 0; dead < 2; dead++) {
        body_case *c = bar(8, 0, dead, 0.0, 0.0);
        if (!c) return;
        c->pull = dead ? 1e6 : 1e-4;
        for (int step = 1; step <= 5; step++) {
            double t = step == 3 ? -2.0 : step;
            CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, t));
            CHECK_REL(c->rest.work, c->rest.stored, 1e-8);
        }
        CHECK_INT((int)c->rest.solves, 5);
        CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, 5.0)); /* nothing is new */
        CHECK_INT((int)c->rest.solves, 5);
        end(c);
    }
}

/* Plastic flow: work is stored or has become heat and hardening, up to the error of the step in which the flow begins,
 * whose share of the work is of second order. */
TEST(work_of_flow)
{
    double off[2];
    for (int fine = 0; fine < 2; fine++) {
        body_case *c = bar(PD_DIM == 3 ? 4 : 8, 1, 0, 1e-3 * YOUNG, 0.0);
        int steps = fine ? 64 : 8;
        if (!c) return;
        c->pull = 4e-3;
        for (int step = 1; step <= steps; step++)
            CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, (double)step / steps));
        double spent = c->rest.stored + c->rest.solid.dissipated(c->rest.solid.self);
        off[fine] = fabs(c->rest.work - spent) / c->rest.work;
        CHECK_LE(c->rest.stored, 0.95 * c->rest.work);
        end(c);
    }
    NOTE("work of flow: off by %.2e, %.2e with an eighth of the step", off[0], off[1]);
    CHECK_LE(off[0], 1e-3);
    CHECK_LE(off[1], 0.1 * off[0]);
}

/* Where the end is depends on the balance: each of its points moves less by a multiple of what the point of its row at
 * x = 0.5 moves, up to one by which rounds that go on from each other would lead away. The balance is that of a bar
 * whose end is given there. */
TEST(end_that_follows)
{
    static const double follows[3] = {0.5, 1.5, 6.0};
    static double found[MOST * PD_DIM], given[MOST];
    for (int way = 0; way < 3; way++) {
        int rounds = 0;
        for (int run = 0; run < 2; run++) {
            double most = 0.0, off = 0.0, held = 0.0;
            body_case *c = bar(PD_DIM == 3 ? 4 : 8, 0, 0, 0.0, 0.0);
            if (!c) return;
            c->pull = 1e-4;
            c->follows = follows[way];
            c->given = run ? given : NULL;
            for (int step = 1; step <= (run ? 1 : 2); step++)
                CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, (double)(run ? 2 : step)));
            const double *u = c->rest.u;
            for (int32_t k = 0; k < c->body.count * PD_DIM; k++) {
                most = fmax(most, fabs(u[k]));
                if (run) off = fmax(off, fabs(u[k] - found[k]));
            }
            for (int32_t i = 0; i < c->body.count; i++) {
                if (c->position[i * PD_DIM] < 1.0 - c->h) continue;
                double there = 2e-4 - follows[way] * u[inner(c, i) * PD_DIM];
                if (!run) CHECK_NEAR(u[i * PD_DIM], there, PD_EQUILIBRIUM_RTOL * most);
                given[i] = u[i * PD_DIM];
                held = fmax(held, given[i]);
            }
            /* the row of a bar that is uniform but near its ends moves by about half as much at x = 0.5 */
            CHECK_REL(held, 2e-4 / (1.0 + 0.5 * follows[way]), 0.1);
            CHECK_LE(off, 1e-8 * most);
            if (!run) rounds = (int)c->rest.solves;
            CHECK_INT((int)c->rest.acceleration.n, 0); /* no rounds are known between balances */
            memcpy(found, u, (size_t)c->body.count * PD_DIM * sizeof *u);
            end(c);
        }
        NOTE("less by %g of what moves: %d balances", follows[way], rounds);
        CHECK(rounds > 4);
    }
}

/* An end that asks to move on whatever it has moved does not come to rest. */
TEST(end_that_runs)
{
    body_case *c = bar(4, 0, 0, 0.0, 0.0);
    if (!c) return;
    c->runs = 1e-5;
    CHECK_INT(pd_quasi_static_solve_at(&c->ctx, &c->rest, 1.0), PD_ERR_STATE);
    CHECK(strstr(c->ctx.message, "what holds the body at 1 s depends on how it moves, and does not come to rest in 60 "
                                 "rounds, as where the elastic material") != NULL);
    CHECK_INT((int)c->rest.solves, 60);
    CHECK_REL(c->rest.u[inner(c, 0) * PD_DIM + (int)(0.5 / c->h - 0.5) * PD_DIM], 60.0 * c->runs, 1e-9);
    CHECK_INT((int)c->rest.acceleration.n, 0);
    end(c);
}

static body_case *has_state; /* of which material_force asks */

static pd_status material_force(pd_ctx *ctx, void *self, const double *u, double *force)
{
    const body_case *c = has_state;
    size_t size = (size_t)c->body.count * PD_DIM * sizeof *u;
    if (c->none || (c->stuck && c->asked == c->stuck && memcmp(u, c->rest.saved, size))) return PD_RETRY;
    return c->force(ctx, self, u, force);
}

/* When bonds are lost and the material has no state at the present displacements, it says so. */
TEST(no_state)
{
    body_case *c = bar(4, 0, 0, 0.0, 0.0);
    if (!c) return;
    c->pull = 1e-4;
    c->force = c->rest.solid.force;
    has_state = c;
    c->rest.solid.force = material_force;
    CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, 1.0));
    c->none = 1;
    c->rest.stale = 1;
    CHECK_INT(pd_quasi_static_solve_at(&c->ctx, &c->rest, 2.0), PD_ERR_STATE);
    CHECK(strstr(c->ctx.message, "the balance at 1 s is no state of the elastic material") != NULL);
    end(c);
}

/* As a process of a run it finds the same balances, to the last bit. */
TEST(process)
{
    static double found[MOST * PD_DIM];
    for (int run = 0; run < 2; run++) {
        body_case *c = bar(4, 0, 0, 0.0, 0.0);
        if (!c) return;
        c->pull = 1e-4;
        pd_physics p = pd_quasi_static_process(&c->rest);
        CHECK_OK(&c->ctx, run ? p.start(&c->ctx, p.self, 0.0) : pd_quasi_static_solve_at(&c->ctx, &c->rest, 0.0));
        CHECK_OK(&c->ctx, run ? p.solve_at(&c->ctx, p.self, 1.0) : pd_quasi_static_solve_at(&c->ctx, &c->rest, 1.0));
        CHECK_NEAR(c->rest.time, 1.0, 0.0);
        CHECK(c->rest.work > 0.0);
        if (run) CHECK(memcmp(found, c->rest.u, (size_t)c->body.count * PD_DIM * sizeof *found) == 0);
        memcpy(found, c->rest.u, (size_t)c->body.count * PD_DIM * sizeof *found);
        end(c);
    }
}

/* How much the displacements of points that mirror each other at y = 0.25 differ, over the largest; 1D: none do. */
static double skew_of(const body_case *c)
{
    double skew = 0.0, size = 0.0;
    for (int32_t i = 0; i < c->body.count; i++) {
        const double *x = c->position + i * PD_DIM;
        for (int32_t j = 0; j < c->body.count && PD_DIM > 1; j++) {
            const double *y = c->position + j * PD_DIM;
            double apart = fabs(x[0] - y[0]) + fabs(x[1] + y[1] - 0.5);
            if (PD_DIM == 3) apart += fabs(x[2] - y[2]);
            if (apart > 0.1 * c->h) continue;
            skew = fmax(skew, fabs(c->rest.u[i * PD_DIM] - c->rest.u[j * PD_DIM]));
            size = fmax(size, fabs(c->rest.u[i * PD_DIM]));
        }
    }
    return size > 0.0 ? skew / size : 0.0;
}

/* Pulls until nothing holds. What is left of the work is what a crack that runs by itself would turn into
 * motion, and is never negative. The halves mirror each other. */
static void pull_apart(body_case *c, int steps, const char *name)
{
    double most = 0.0;
    for (int step = 1; step <= steps && !(c->rest.broken && c->rest.stored < 1e-6 * c->rest.work); step++) {
        if (!CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, (double)step))) return;
        double pull = 0.0;
        for (int32_t i = 0; i < c->body.count; i++)
            if (c->position[i * PD_DIM] > 1.0 - c->h) pull -= c->volume[i] * c->rest.force[i * PD_DIM];
        most = fmax(most, pull);
        CHECK_LE(c->rest.stored + c->rest.released, c->rest.work * (1.0 + 1e-9));
    }
    NOTE("%s, eager %g: %d bonds in %d solves, most %.4g N, work %.4g = stored %.4g + released %.4g + %.4g", name,
         c->rest.desc.break_fraction, (int)c->rest.broken, (int)c->rest.solves, most, c->rest.work, c->rest.stored,
         c->rest.released, c->rest.work - c->rest.stored - c->rest.released);
    CHECK(c->rest.broken > 0);
    CHECK_LE(c->rest.stored, 1e-6 * c->rest.work);
    CHECK_LE(skew_of(c), 1e-6);
}

/* A slit bar is pulled apart: it holds, then it breaks. */
TEST(pulled_apart)
{
    for (int eager = 0; eager < 2; eager++) {
        body_case *c = bar(PD_DIM == 3 ? 4 : 8, 1, 0, 0.0, 5e-3);
        if (!c) return;
        c->pull = 1e-3;
        c->rest.desc.break_fraction = eager ? 1.0 : 0.0;
        pull_apart(c, 12, "stretch");
        end(c);
    }
}

/* So it does by each criterion, and with the linear peridynamic solid. */
TEST(criteria)
{
    static const char *const names[] = {"stretch", "energy", "principal", "mises"};
    for (int way = PD_DIM == 3; way < 8; way += PD_DIM == 3 ? 3 : 1) {
        body_case *c = bar(PD_DIM == 3 ? 4 : 8, 1, 0, 0.0, 0.0);
        pd_quasi_static_desc rest;
        pd_ordinary_state_desc of;
        if (!c) return;
        c->pull = 1e-3;
        memset(&of, 0, sizeof of);
        of.young = YOUNG;
        of.poisson = 0.3;
        of.detach_singular = 1;
        of.linear = 1;
        if (!CHECK_OK(&c->ctx, pd_ordinary_state_build(&c->ctx, &c->body, &of, &c->ordinary))) return;
        pd_material_interface solid =
            way < 4 ? pd_correspondence_material(&c->elastic) : pd_ordinary_state_material(&c->ordinary);
        rest = c->rest.desc;
        rest.criterion.kind = (pd_bond_failure_kind)(way % 4);
        rest.criterion.critical = way % 4 == 0 ? 5e-3 : 5e-3 * YOUNG;
        if (way % 4 == 1) rest.criterion.critical = 0.0;
        if (way % 4 == 1) rest.criterion.fracture = 12.5e-6 * YOUNG * c->h;
        pd_quasi_static_free(&c->ctx, &c->rest);
        if (!CHECK_OK(&c->ctx, pd_quasi_static_build(&c->ctx, &solid, &rest, &c->rest))) return;
        pull_apart(c, 40, names[way % 4]);
        pd_ordinary_state_free(&c->ctx, &c->ordinary);
        end(c);
    }
}

/* Under a dead load the end comes off and loses it. */
TEST(comes_off)
{
    body_case *c = bar(8, 1, 1, 0.0, 5e-3);
    if (!c) return;
    c->pull = 1e-4 * YOUNG;
    for (int step = 1; step <= 60 && c->rest.separation_time < 0.0; step++)
        if (!CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, (double)step))) break;
    NOTE("comes off at %g of E, %d points", 1e-4 * c->rest.separation_time, (int)c->rest.detached_points);
    CHECK(c->rest.separation_time > 0.0);
    CHECK(c->rest.detached_points >= c->body.count / 4);
    CHECK_LE(c->rest.stored, 1e-6 * c->rest.work);
    end(c);
}

/* The same in a part of a load step: the bar bears half of the critical load, four times that is too much for one
 * step, and with half of the step bonds break. What has come off has no load, comes off once, and gets nothing of the
 * load at the start of the step. The rest of the step adds no work, so all is as with a step to that half. */
TEST(comes_off_in_a_part)
{
    double work = 0.0, released = 0.0;
    int64_t broken = 0;
    for (int run = 0; run < 2; run++) {
        int off = 0;
        body_case *c = bar(4, 0, 3, 0.1 * YOUNG, 1e-3);
        if (!c) return;
        c->pull = 1e-3 * YOUNG;
        c->rest.desc.break_fraction = 1.0;
        c->force = c->rest.solid.force;
        has_state = c;
        c->rest.solid.force = material_force;
        CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, 1.0));
        CHECK_INT((int)c->rest.broken, 0);
        if (run) c->stuck = c->asked + 2; /* a step asks whether loads are new, and then for those of its first part */
        CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, run ? 4.0 : 2.5));
        NOTE("%d bonds, %d points in %d solves, work %.10g J", (int)c->rest.broken, (int)c->rest.detached_points,
             (int)c->rest.solves, c->rest.work);
        for (int32_t i = 0; i < c->body.count; i++) {
            off += c->rest.detached[i];
            for (int d = 0; d < PD_DIM && c->rest.detached[i]; d++) CHECK_NEAR(c->rest.load[i * PD_DIM + d], 0.0, 0.0);
        }
        CHECK(off > 0);
        CHECK_INT((int)c->rest.detached_points, off);
        if (run) {
            CHECK_INT((int)c->rest.broken, (int)broken);
            CHECK_REL(c->rest.work, work, 1e-9);
            CHECK_REL(c->rest.released, released, 1e-9);
        }
        broken = c->rest.broken;
        work = c->rest.work;
        released = c->rest.released;
        end(c);
    }
}

/* Halves that one bond joins: families at both of its ends know it, so in 2D it holds the half in all directions. In
 * 3D the half turns about the bond: loads along it are borne, others part the half. */
TEST(hinge)
{
    for (int dead = 2; dead < 4; dead++) {
        uint32_t seed = 1;
        body_case *c = bar(8, 0, dead, 0.0, 0.0);
        if (!c) return;
        c->pull = 1e3;
        CHECK_INT(cut(c, 0.0, &seed), 1);
        CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, 1.0));
        NOTE("along %s: %d points come off, %d solves, stored %.4g of %.4g J", dead == 2 ? "the last axis" : "x",
             (int)c->rest.detached_points, (int)c->rest.solves, c->rest.stored, c->rest.work);
        CHECK_INT((int)c->rest.detached_points, PD_DIM == 3 && dead == 2 ? c->body.count / 2 : 0);
        CHECK_LE(fabs(c->rest.stored - c->rest.work), 1e-8 * c->rest.work);
        if (!c->rest.detached_points) CHECK(c->rest.stored > 0.0);
        end(c);
    }
}

/* Cuts by chance, from dense to a bond or two, on lattices that are not at zero: under a dead load halves come off,
 * whatever they hang on, and energies add up. */
TEST(random_cuts)
{
    int off = 0, all = 0;
    for (uint32_t k = 0; k < CUTS; k++) {
        uint32_t seed = k + 1;
        double left = random_between(&seed, 0.01, 0.3), shift = k % 3 ? random_between(&seed, -3.0, 3.0) : 0.0;
        body_case *c = bar_at(PD_DIM == 3 ? 4 : 6, 0, 1 + (int)(k % 2), 0.0, k % 4 < 2 ? 5e-3 : 0.0, shift);
        if (!c) return;
        cut(c, left, &seed);
        c->pull = 2e-4 * YOUNG;
        for (int step = 1; step <= 40 && c->rest.separation_time < 0.0; step++)
            if (!CHECK_OK(&c->ctx, pd_quasi_static_solve_at(&c->ctx, &c->rest, (double)step))) break;
        off += c->rest.separation_time >= 0.0;
        all++;
        CHECK_LE(c->rest.residual, 1e-10);
        CHECK_LE(c->rest.stored + c->rest.released, c->rest.work * (1.0 + 1e-9));
        if (c->rest.separation_time >= 0.0 && c->rest.detached_points == c->body.count / 2)
            CHECK_LE(c->rest.stored, 1e-6 * c->rest.work);
        end(c);
    }
    NOTE("%d of %d come off", off, all);
}

TEST(bad_input)
{
    body_case *c = bar(4, 0, 0, 0.0, 0.0);
    pd_quasi_static_desc desc;
    pd_quasi_static rest;
    if (!c) return;
    pd_material_interface solid = pd_correspondence_material(&c->elastic);
    for (int way = 0; way < 4; way++) {
        desc = c->rest.desc;
        if (way == 0) desc.criterion.critical = -1.0;
        if (way == 1) desc.criterion.critical = NAN;
        if (way == 2) desc.break_fraction = 2.0;
        if (way == 3) desc.rtol = 1.0;
        CHECK_INT(pd_quasi_static_build(&c->ctx, &solid, &desc, &rest), PD_ERR_ARGUMENT);
        CHECK(strstr(c->ctx.message, way < 2 ? "bond_failure: " : "quasi_static: ") == c->ctx.message);
    }
    end(c);
}

TEST_MAIN(ENTRY(work_is_stored) ENTRY(work_of_flow) ENTRY(end_that_follows) ENTRY(end_that_runs) ENTRY(no_state)
              ENTRY(process) ENTRY(pulled_apart) ENTRY(criteria) ENTRY(comes_off) ENTRY(comes_off_in_a_part)
                  ENTRY(hinge) ENTRY(random_cuts) ENTRY(bad_input))
