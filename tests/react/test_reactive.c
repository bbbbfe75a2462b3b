/* reactive: closed forms of fronts and layers, one species against transport, totals, equilibria and bounds in flows,
 * steps of any length.
 * dims: 1 2 3 */
#include "react/advance.h"
#include "chemistry_case.h"
#include "fixture.h"

static scene test_scene;
static pd_reactive test_reactive;
static pd_reactive_result test_result;

static const pd_reactive_balance *balance_of(scene *s, int row)
{
    static pd_reactive_balance b;
    pd_reactive_balance_of(&s->ctx, &test_reactive, row, &b);
    return &b;
}

/* All rows of the balance close. */
static void check_balance(scene *s)
{
    for (int row = 0; row < test_reactive.rows; row++)
        if (!CHECK_LE(balance_of(s, row)->relative, 1e-12)) NOTE("%s", balance_of(s, row)->name);
}

static void uniform(void *user, const double *x, double *u)
{
    (void)user;
    (void)x;
    for (int e = 0; e < PD_DIM; e++) u[e] = e ? 0.0 : 1e-3;
}

static int step_all(scene *s, double dt)
{
    pd_status status = pd_reactive_step(&s->ctx, &test_reactive, dt, &test_result);
    return CHECK_OK(&s->ctx, status);
}

/* Build with a mixture; the desc has the rest. */
static int build(scene *s, mixture *v, pd_reactive_desc *d, const pd_flow *flow)
{
    d->species = v->s;
    d->count = v->species;
    d->reactions = v->r;
    d->reaction_count = v->reactions;
    d->temperature = 298.15;
    return CHECK_OK(&s->ctx, pd_reactive_build(&s->ctx, &s->grid, &s->bonds, flow, d, &test_reactive));
}

static void finish(scene *s)
{
    pd_reactive_free(&s->ctx, &test_reactive);
    scene_free(s);
}

/* A channel along axis 0 with a stream past a bar of 1 mm/s. */
static int stream(scene *s, int x, int y)
{
    scene_box(s, 2.0, 1e-5, x, y, 5);
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    for (int e = 1; e < PD_DIM; e++) s->grid_desc.side[2 * e] = s->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
    s->with = WITH_FLOW | WITH_TRANSPORT;
    s->flow_desc.rho = 1000.0;
    s->flow_desc.mu = 1e-3;
    s->flow_desc.report_speed = 1e-3;
    s->flow_desc.report_length = 1e-4;
    s->flow_desc.inlet = uniform;
    s->transport_desc.diffusivity = 2e-9;
    s->transport_desc.inlet = 1.0;
    s->transport_desc.advection = PD_ADVECTION_UPWIND;
    if (PD_DIM == 2) {
        const double lo[2] = {8e-5, 5e-5}, hi[2] = {1.2e-4, 8e-5};
        scene_solid_box(&s->shapes[0], lo, hi);
        s->grid_desc.solid = &s->shapes[0];
        s->with |= WITH_STEADY;
        s->steady_desc.tolerance = 1e-9;
    }
    if (!scene_build(s)) return 0;
    if (PD_DIM == 2) {
        pd_steady_result result;
        return CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &s->steady, &result));
    }
    for (int32_t i = 0; i < s->grid.total; i++) s->flow.u[i] = 1e-3;
    pdi_flow_update_derived_fields(&s->ctx, &s->flow);
    return 1;
}

/* ---- one species ---- */

/* As transport with upwinded fluxes, in a stream and at rest, for several steps and at once. */
TEST(one_species)
{
    for (int flowing = 0; flowing < 2; flowing++) {
        scene *s = &test_scene;
        mixture v;
        pd_reactive_desc d;
        double initial[1] = {0.25}, inlet[1] = {1.0}, worst = 0.0;
        if (!stream(s, 30, 13)) return;
        pd_transport *t = &s->transport;
        if (!flowing) {
            pd_transport_free(&s->ctx, t);
            CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, NULL, &s->transport_desc, t));
        }
        mix_begin(&v);
        mix_species(&v, "Na+", NULL, 2e-9);
        memset(&d, 0, sizeof d);
        d.initial = initial;
        d.inlet = inlet;
        if (!build(s, &v, &d, flowing ? &s->flow : NULL)) return;
        double *c = pd_reactive_field(&test_reactive, 0);
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) t->c[i] = 0.25;
        for (double dt = 1e-4; dt < 1e9; dt *= 1e3) {
            CHECK_OK(&s->ctx, pd_transport_implicit(&s->ctx, t, dt, &s->result));
            if (!step_all(s, dt)) return;
            CHECK_LE(test_result.newton, 2);
            for (int32_t i = 0; i < s->grid.total; i++)
                if (s->grid.kind[i] == PD_FLUID) worst = fmax(worst, fabs(c[i] - t->c[i]));
        }
        CHECK_LE(worst, 1e-8);
        check_balance(s);
        finish(s);
    }
}

/* ---- fronts ---- */

/* A couple of species a (x < 0) and b (x > 0), a + n b = p. */
typedef struct couple {
    double a, b, da, db, n; /* [mol/m3], [m2/s], [-] */
} couple;

/* s of x_f = 2 s sqrt(t) (chemistry: instantaneous fronts). */
static double front_of(const couple *c)
{
    double low = -4.0 * sqrt(fmax(c->da, c->db)), high = -low;
    for (int k = 0; k < 200; k++) {
        double s = 0.5 * (low + high);
        double left = c->n * c->a * sqrt(c->da) * exp(-s * s / c->da) / (1.0 + erf(s / sqrt(c->da)));
        double right = c->b * sqrt(c->db) * exp(-s * s / c->db) / erfc(s / sqrt(c->db));
        if (left > right) low = s;
        else high = s;
    }
    return 0.5 * (low + high);
}

/* Place of the front and amount of product over their values, at 100 s, with n cells and steps of a share of the
 * time, of an order. */
static double front(const couple *c, int n, double share, int order, double *product)
{
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double initial[3] = {0.0, 0.0, 0.0}, end = 100.0, half = 4.0 * sqrt(fmax(c->da, c->db) * end), h = 2.0 * half / n;
    double time = 0.0, x[PD_DIM], where = 0.0, sum = 0.0, before = 0.0, pi = 3.14159265358979324;
    int32_t index[3] = {0, 0, 0};
    scene_box(s, 2.0, h, n, 4, 4);
    for (int e = 1; e < PD_DIM; e++) s->grid_desc.side[2 * e] = s->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
    if (!scene_build(s)) return 0.0;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", c->da);
    mix_species(&v, "Bb", "K", c->db);
    mix_species(&v, "Pp", c->n > 1.5 ? "NaK2" : "NaK", 1e-9);
    mix_reaction(&v, c->n > 1.5 ? "Aa + 2 Bb = Pp" : "Aa + Bb = Pp", 30.0, 0.0, NULL);
    memset(&d, 0, sizeof d);
    d.initial = initial;
    d.order = order;
    if (!build(s, &v, &d, NULL)) return 0.0;
    double *a = pd_reactive_field(&test_reactive, 0), *b = pd_reactive_field(&test_reactive, 1);
    double *p = pd_reactive_field(&test_reactive, 2);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        a[i] = x[0] < half ? c->a : 0.0;
        b[i] = x[0] < half ? 0.0 : c->b;
    }
    CHECK_OK(&s->ctx, pd_reactive_begin(&s->ctx, &test_reactive));
    for (double dt = 1e-2; time < end; dt = share * time) {
        dt = fmin(dt, end - time);
        if (!step_all(s, dt)) break;
        CHECK_INT(test_result.parts, 0);
        time = end - time - dt < 1e-9 ? end : time + dt;
    }
    check_balance(s);
    for (index[0] = 0; index[0] < n; index[0]++) {
        int32_t i = pd_grid_node(&s->grid, index);
        double u = c->n * c->da * a[i] - c->db * b[i]; /* smooth across the front */
        pd_grid_position(&s->grid, i, x);
        if (index[0] && before > 0.0 && u <= 0.0) where = x[0] - half - h * (1.0 - before / (before - u));
        before = u;
        sum += p[i] * h;
        CHECK(a[i] >= 0.0 && b[i] >= 0.0 && p[i] >= 0.0);
    }
    double f = front_of(c), flux = 2.0 * c->a * sqrt(c->da / pi) * exp(-f * f / c->da) / (1.0 + erf(f / sqrt(c->da)));
    *product = sum / (flux * sqrt(end));
    finish(s);
    return where / (2.0 * f * sqrt(end));
}

/* Errors fall with the step and the square of the spacing. Fronts of 301.64, 211.04 and -112.24 um. */
TEST(fronts)
{
    if (PD_DIM == 3 && !getenv("PD_HARD")) SKIP("in 3D with PD_HARD=1 alone: nothing depends on the third axis");
    static const couple of[4] = {{300.0, 100.0, 1e-9, 1e-9, 1.0}, {100.0, 100.0, 9.31e-9, 5.27e-9, 1.0},
                                 {100.0, 100.0, 0.705e-9, 5.27e-9, 2.0}, {10.0, 100.0, 0.705e-9, 5.27e-9, 2.0}};
    static const double place[4] = {301.641, 211.0411, -112.2412, -1151.6106};
    for (int k = 0; k < 4; k += PD_DIM > 1 ? 2 : 1) {
        double product[2], found[2];
        CHECK_REL(2e7 * front_of(&of[k]), place[k], 1e-6);
        found[0] = front(&of[k], PD_DIM > 1 ? 60 : 120, 0.08, 1, &product[0]);
        found[1] = front(&of[k], PD_DIM > 1 ? 120 : 240, 0.02, 1, &product[1]);
        NOTE("front %.2e, %.2e", found[0] - 1.0, found[1] - 1.0);
        NOTE("product %.2e, %.2e", product[0] - 1.0, product[1] - 1.0);
        CHECK_REL(found[1], 1.0, k == 2 && PD_DIM > 1 ? 0.011 : 0.005); /* two nodes from the start */
        CHECK_REL(product[1], 1.0, 0.01);
        found[0] = front(&of[k], PD_DIM > 1 ? 60 : 120, 0.08, 2, &product[0]);
        NOTE("order 2: %.2e, %.2e", found[0] - 1.0, product[0] - 1.0);
        CHECK_REL(found[0], 1.0, k == 2 ? 0.011 : 0.0025);
        CHECK_REL(product[0], 1.0, PD_DIM > 1 ? 0.005 : 0.001);
    }
}

/* ---- layers, water ---- */

static double at_left(void *user, const double *x)
{
    (void)user;
    return x[0] < 1e-6 ? 1.0 : (double)NAN;
}

/* A sink of first order beside a wall that holds 1: c = cosh((L - x)/l)/cosh(L/l) (chemistry: first-order sink layer),
 * in one step. l = 316 um. */
TEST(sink_layer)
{
    double error[2];
    for (int k = 0; k < 2; k++) {
        scene *s = &test_scene;
        mixture v;
        pd_reactive_desc d;
        int n = 50 << k;
        double initial[2] = {0.0, 0.0}, wall[2] = {1.0, 0.0}, h = 1e-3 / n, l = sqrt(1e-7), x[PD_DIM];
        scene_box(s, 2.0, h, n, 4, 4);
        for (int e = 1; e < PD_DIM; e++) s->grid_desc.side[2 * e] = s->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
        if (!scene_build(s)) return;
        mix_begin(&v);
        mix_species(&v, "Aa", "Na", 1e-9);
        mix_species(&v, "Bb", "Na", 1e-9);
        mix_reaction(&v, "Aa = Bb", 300.0, 1e-2, "1/s");
        v.r[0].backward = 0.0;
        memset(&d, 0, sizeof d);
        d.initial = initial;
        d.wall = wall;
        d.held = at_left;
        if (!build(s, &v, &d, NULL)) return;
        double *a = pd_reactive_field(&test_reactive, 0);
        if (!step_all(s, 1e12)) return;
        CHECK_LE(test_result.newton, 6);
        CHECK_LE(test_result.krylov, 30);
        error[k] = 0.0;
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            error[k] = fmax(error[k], fabs(a[i] - cosh((1e-3 - x[0]) / l) / cosh(1e-3 / l)));
        }
        check_balance(s);
        double flux = balance_of(s, 0)->in / 1e12 * (PD_DIM > 1 ? 0.25 / h : 1.0) * (PD_DIM > 2 ? 0.25 / h : 1.0);
        CHECK_REL(flux, sqrt(1e-9 * 1e-2) * tanh(1e-3 / l), 1e-3);
        finish(s);
    }
    CHECK_LE(error[0], 1e-3);
    CHECK_LE(error[1], 0.4 * error[0]);
}

/* Water that is far from equilibrium comes to rest in one step of 36 s, a million times its relaxation. */
TEST(water)
{
    for (int k = 0; k < 3; k++) {
        scene *s = &test_scene;
        mixture v;
        pd_reactive_desc d;
        double initial[3] = {55344.0, 0.5, 0.2}, excess = 0.3;
        if (k) initial[1] = initial[2] = excess = 1e-9 * (k - 1);
        scene_box(s, 2.0, 1e-5, 12, 6, 5);
        if (!scene_build(s)) return;
        mix_begin(&v);
        mix_species(&v, "H2O", NULL, 0.0);
        mix_species(&v, "H+", NULL, 9.31e-9);
        mix_species(&v, "OH-", NULL, 5.27e-9);
        mix_reaction(&v, "H+ + OH- = H2O", 14.0, 1.4e11, "L/mol/s");
        if (k) excess = 0.0;
        memset(&d, 0, sizeof d);
        d.initial = initial;
        if (!build(s, &v, &d, NULL)) return;
        CHECK_INT(test_reactive.components.kinetics, 1);
        if (!step_all(s, 36.0)) return;
        double *h = pd_reactive_field(&test_reactive, 1), *oh = pd_reactive_field(&test_reactive, 2);
        for (int step = 0; step < 2; step++) {
            if (step && !step_all(s, 36.0)) return;
            for (int32_t i = 0; i < s->grid.total; i++) {
                if (s->grid.kind[i] != PD_FLUID) continue;
                CHECK_REL(h[i], 0.5 * (excess + sqrt(excess * excess + 4e-8)), step ? 1e-6 : 1e-5);
                CHECK_NEAR(h[i] - oh[i], excess, 5e-9); /* 1e-10 of the 50 mol/m3 that react in 36 s */
            }
        }
        check_balance(s);
        finish(s);
    }
}

/* ---- body fluid ---- */

/* A closed box of Hanks' solution takes up OH-: the pH of a titration that was computed elsewhere. */
TEST(titration)
{
    static const double added[6] = {0.0, 0.1, 0.2, 0.5, 1.0, 3.0}, ph[6] = {7.400, 7.486, 7.585, 8.027, 9.214, 10.275};
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double c[PD_SPECIES_MAX] = {0.0};
    int32_t index[3] = {1, 1, 1};
    scene_box(s, 2.0, 1e-5, 8, 6, 5);
    if (!scene_build(s)) return;
    mix_begin(&v);
    mix_body_fluid(&v);
    v.reactions = 5; /* without pairs */
    v.species -= 2;
    c[mix_at(&v, "HCO3-")] = 4.17;
    c[mix_at(&v, "CO2")] = 4.17 * pow(10.0, 6.352 - 7.4);
    c[mix_at(&v, "CO3-2")] = 4.17 * pow(10.0, 7.4 - 10.329);
    c[mix_at(&v, "HPO4-2")] = 0.78 / (1.0 + pow(10.0, 7.207 - 7.4));
    c[mix_at(&v, "H2PO4-")] = 0.78 / (1.0 + pow(10.0, 7.4 - 7.207));
    memset(&d, 0, sizeof d);
    d.initial = c;
    if (!build(s, &v, &d, NULL)) return;
    double *source = pd_reactive_source(&test_reactive, mix_at(&v, "OH-")), start = pd_reactive_ph(&test_reactive,
        pd_grid_node(&s->grid, index));
    CHECK_NEAR(start, 7.4, 1e-3);
    for (int k = 1; k < 6; k++) {
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) source[i] = (added[k] - added[k - 1]) / 100.0;
        if (!step_all(s, 100.0)) return;
        CHECK_NEAR(pd_reactive_ph(&test_reactive, pd_grid_node(&s->grid, index)), ph[k], 0.003);
    }
    check_balance(s);
    finish(s);
}

/* An acid streams into a lye with another anion and D, both 0.01 mol/L: one step of any length from a sharp start,
 * without migration and with it. */
TEST(acid_into_lye)
{
    for (int k = 0; k < 14; k++) {
        double dt = 1e-6 * pow(1e3, k / 2);
        scene *s = &test_scene;
        mixture v;
        pd_reactive_desc d;
        double acid[5] = {55344.0, 10.0, 0.0, 10.0, 0.0}, lye[5] = {55344.0, 0.0, 10.0, 0.0, 10.0};
        if (!stream(s, 30, 13)) return;
        mix_begin(&v);
        mix_species(&v, "H2O", NULL, 0.0);
        mix_species(&v, "H+", NULL, 9.31e-9);
        mix_species(&v, "OH-", NULL, 5.27e-9);
        mix_species(&v, "Cl-", NULL, 2.03e-9);
        mix_species(&v, "Na+", NULL, 1.33e-9);
        mix_reaction(&v, "H2O = H+ + OH-", -14.0, 0.0, NULL);
        memset(&d, 0, sizeof d);
        d.initial = lye;
        d.inlet = acid;
        d.migration = k % 2;
        if (!build(s, &v, &d, &s->flow)) return;
        if (!step_all(s, dt)) return;
        CHECK_LE(test_result.newton, d.migration ? 14 : 8);
        CHECK_LE(test_result.krylov, d.migration ? 120 : 60);
        CHECK_INT(test_result.parts, 0);
        check_balance(s);
        if (d.migration) CHECK_LE(pd_reactive_neutrality(&test_reactive), 1e-14);
        double *h = pd_reactive_field(&test_reactive, 1), *oh = pd_reactive_field(&test_reactive, 2);
        double *cl = pd_reactive_field(&test_reactive, 3);
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            CHECK_REL(h[i] * oh[i], 1e-8, 1e-12);
            CHECK(cl[i] >= 0.0 && (d.migration || cl[i] <= 10.0 * (1.0 + 1e-9)));
            CHECK_LE(h[i], 10.0 * (1.0 + 1e-6));
            CHECK_LE(oh[i], (d.migration ? 14.0 : 10.0) * (1.0 + 1e-6));
            if (dt > 1e5) CHECK_REL(h[i], 10.0, 1e-6);
        }
        finish(s);
    }
}

/* Hanks' solution streams past a bar that gives off Mg2+ and twice as much OH-: steps from a millisecond to hours. The
 * balance closes, nothing is negative, inert salt keeps its bounds, and the end is steady. */
static void body_fluid(pd_activity activity, int threads, double **bits)
{
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double c[PD_SPECIES_MAX] = {0.0};
    mix_body_fluid(&v);
    mix_hanks(&v, c);
    if (!stream(s, 30, 13)) return;
    s->ctx.threads = threads;
    memset(&d, 0, sizeof d);
    d.initial = c;
    d.activity = activity;
    if (!build(s, &v, &d, &s->flow)) return;
    int64_t size = (int64_t)test_reactive.components.solutes * s->grid.total;
    double *mg = pd_reactive_source(&test_reactive, mix_at(&v, "Mg2+")), x[PD_DIM];
    double *oh = pd_reactive_source(&test_reactive, mix_at(&v, "OH-")), *now = test_reactive.c;
    double *old = (double *)malloc((size_t)size * sizeof *old);
    if (!CHECK(old != NULL)) return;
    memcpy(old, now, (size_t)size * sizeof *old);
    if (!step_all(s, 10.0)) return;
    for (int64_t i = 0; i < size; i++) /* in equilibrium nothing moves */
        if (s->grid.kind[i % s->grid.total] == PD_FLUID) CHECK_NEAR(now[i], old[i], 1e-12 * old[i]);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        if (x[0] < 7e-5 || x[0] > 1.3e-4) continue;
        mg[i] = 20.0;
        oh[i] = 40.0;
    }
    double high = 0.0;
    for (double dt = 1e-3; dt < 1e5; dt *= 10.0) {
        if (!step_all(s, dt)) return;
        CHECK_LE(test_result.newton, 8);
        CHECK_LE(test_result.krylov, 60);
        CHECK_INT(test_result.parts, 0);
        check_balance(s);
        int negative = 0;
        for (int64_t i = 0; i < size; i++) negative += !(now[i] >= 0.0);
        CHECK_INT(negative, 0);
    }
    double *na = pd_reactive_field(&test_reactive, mix_at(&v, "Na+"));
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        CHECK_NEAR(na[i], 142.0, 1e-7);
        high = fmax(high, pd_reactive_ph(&test_reactive, i));
    }
    CHECK_LE(7.5, high);
    if (bits && *bits) {
        CHECK(memcmp(*bits, now, (size_t)size * sizeof **bits) == 0);
    } else if (bits) {
        memcpy(old, now, (size_t)size * sizeof *old);
        *bits = old;
        old = NULL;
    }
    free(old);
    finish(s);
}

TEST(body_fluid_ideal) { body_fluid(PD_ACTIVITY_IDEAL, 0, NULL); }
TEST(body_fluid_davies) { body_fluid(PD_ACTIVITY_DAVIES, 0, NULL); }

TEST(threads_change_no_bit)
{
    double *bits = NULL;
    for (int threads = 1; threads <= (PD_DIM == 3 ? 2 : 4); threads *= 2)
        body_fluid(PD_ACTIVITY_DAVIES, threads, &bits);
    free(bits);
}

/* ---- finite rates ---- */

/* A decays by exp(-t/10 s), while it streams and spreads: errors of steps of order 1 and 2, estimates, balances. */
TEST(order)
{
    double error[2][3];
    for (int order = 1; order <= 2; order++)
        for (int k = 0; k < 3; k++) {
            scene *s = &test_scene;
            mixture v;
            pd_reactive_desc d;
            double initial[2] = {5.0, 0.0}, estimate = 0.0;
            int steps = 10 << k, euler = 0;
            scene_box(s, 2.0, 1e-5, 8, 6, 5);
            if (!scene_build(s)) return;
            mix_begin(&v);
            mix_species(&v, "Aa", "Na", 1e-9);
            mix_species(&v, "Bb", "Na", 2e-9);
            mix_reaction(&v, "Aa = Bb", 300.0, 0.1, "1/s");
            v.r[0].backward = 0.0;
            memset(&d, 0, sizeof d);
            d.initial = initial;
            d.order = order;
            if (!build(s, &v, &d, NULL)) return;
            for (int n = 0; n < steps; n++) {
                if (!step_all(s, 10.0 / steps)) return;
                estimate += test_result.error;
                euler += test_result.euler;
            }
            double *a = pd_reactive_field(&test_reactive, 0);
            error[order - 1][k] = 0.0;
            for (int32_t i = 0; i < s->grid.total; i++)
                if (s->grid.kind[i] == PD_FLUID)
                    error[order - 1][k] = fmax(error[order - 1][k], fabs(a[i] / 5.0 - exp(-1.0)));
            CHECK_INT(euler, 0);
            if (order == 2) CHECK(estimate > error[1][k]);
            check_balance(s);
            finish(s);
        }
    for (int k = 0; k < 2; k++) {
        CHECK_NEAR(log(error[0][k] / error[0][k + 1]) / log(2.0), 1.0, 0.05);
        CHECK_NEAR(log(error[1][k] / error[1][k + 1]) / log(2.0), 2.0, 0.05);
    }
}

/* A sharp change of an inert salt in a stream: steps of order 2 that would leave its bounds are of order 1. */
TEST(bounds_of_order_2)
{
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double initial[1] = {1.0}, inlet[1] = {0.0};
    int euler = 0;
    if (!stream(s, 30, 13)) return;
    mix_begin(&v);
    mix_species(&v, "Na+", NULL, 1e-9);
    memset(&d, 0, sizeof d);
    d.initial = initial;
    d.inlet = inlet;
    d.order = 2;
    if (!build(s, &v, &d, &s->flow)) return;
    double *c = pd_reactive_field(&test_reactive, 0);
    for (double dt = 1e-4; dt < 1e5; dt *= 10.0) {
        if (!step_all(s, dt)) return;
        euler += test_result.euler;
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) CHECK(c[i] >= 0.0 && c[i] <= 1.0 + 1e-8);
        check_balance(s);
    }
    CHECK_LE(1, euler);
    finish(s);
}

/* A + B at a finite rate: the rate in the middle of the front falls with t^(-2/3) (Galfi and Racz 1988). */
TEST(finite_rate)
{
    if (PD_DIM == 3 && !getenv("PD_HARD")) SKIP("in 3D with PD_HARD=1 alone: nothing depends on the third axis");
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double initial[3] = {0.0, 0.0, 0.0}, h = 8e-3 / 160, time = 0.0, x[PD_DIM], rate[2] = {0.0, 0.0}, k = 1e-2;
    scene_box(s, 2.0, h, 160, 4, 4);
    for (int e = 1; e < PD_DIM; e++) s->grid_desc.side[2 * e] = s->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
    if (!scene_build(s)) return;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", 1e-9);
    mix_species(&v, "Bb", "K", 1e-9);
    mix_species(&v, "Pp", "NaK", 1e-9);
    mix_reaction(&v, "Aa + Bb = Pp", 300.0, k, "m3/mol/s");
    v.r[0].backward = 0.0;
    memset(&d, 0, sizeof d);
    d.initial = initial;
    if (!build(s, &v, &d, NULL)) return;
    double *a = pd_reactive_field(&test_reactive, 0), *b = pd_reactive_field(&test_reactive, 1);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        (x[0] < 4e-3 ? a : b)[i] = 100.0;
    }
    CHECK_OK(&s->ctx, pd_reactive_begin(&s->ctx, &test_reactive));
    for (int half = 0; half < 2; half++) {
        double end = half ? 1600.0 : 200.0;
        for (double dt = 1e-2; time < end; dt = 0.03 * time) {
            dt = fmin(dt, end - time);
            if (!step_all(s, dt)) return;
            time = end - time - dt < 1e-9 ? end : time + dt;
        }
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) rate[half] = fmax(rate[half], k * a[i] * b[i]);
    }
    CHECK_NEAR(log(rate[1] / rate[0]) / log(8.0), -2.0 / 3.0, 0.02);
    check_balance(s);
    finish(s);
}

TEST_MAIN(ENTRY(one_species) SLOW_ENTRY_IF(PD_DIM == 3, fronts) ENTRY(sink_layer) ENTRY(water) ENTRY(titration)
              SLOW_ENTRY_IF(PD_DIM == 3, acid_into_lye) ENTRY(body_fluid_ideal) ENTRY(body_fluid_davies)
                  ENTRY(threads_change_no_bit) ENTRY(order) ENTRY(bounds_of_order_2)
                      SLOW_ENTRY_IF(PD_DIM == 3, finite_rate))
