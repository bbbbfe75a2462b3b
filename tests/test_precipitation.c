/* precipitation: brucite that dissolves in water until it is saturated, fronts where a solid forms at once, diffusion
 * through pores, balances and steps of any length.
 * dims: 1 2 3 */
#include "react/advance.h"
#include "chemistry_case.h"
#include "fixture.h"

static scene test_scene;
static pd_reactive test_reactive;
static pd_reactive_result test_result;

static void check_balance(scene *s)
{
    pd_reactive_balance b;
    for (int row = 0; row < test_reactive.rows; row++) {
        pd_reactive_balance_of(&s->ctx, &test_reactive, row, &b);
        if (!CHECK_LE(b.relative, 1e-12)) NOTE("%s", b.name);
    }
}

static int step_all(scene *s, double dt)
{
    return CHECK_OK(&s->ctx, pd_reactive_step(&s->ctx, &test_reactive, dt, &test_result));
}

static int build(scene *s, const mixture *v, pd_reactive_desc *d)
{
    d->species = v->s;
    d->count = v->species;
    d->reactions = v->r;
    d->reaction_count = v->reactions;
    d->temperature = 298.15;
    return CHECK_OK(&s->ctx, pd_reactive_build(&s->ctx, &s->grid, &s->bonds, NULL, d, &test_reactive));
}

static void finish(scene *s)
{
    pd_reactive_free(&s->ctx, &test_reactive);
    scene_free(s);
}

static int box(scene *s, double h, int n)
{
    scene_box(s, 2.0, h, n, 4, 4);
    for (int e = 1; e < PD_DIM; e++) s->grid_desc.side[2 * e] = s->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
    return scene_build(s);
}

/* ---- brucite ---- */

/* pH of pure water over brucite of a log10 K, dissolved with a speed, or in one step in equilibrium. */
static double brucite(double log_k, int complex, pd_activity activity, double salt, double rate, double dt, int order)
{
    scene *s = &test_scene;
    mixture v;
    pd_mineral of;
    pd_reactive_desc d;
    double initial[10] = {0.0}, ph, before;
    if (!box(s, 1e-5, 6)) return 0.0;
    mix_begin(&v);
    mix_species(&v, "H2O", NULL, 0.0);
    initial[mix_species(&v, "H+", NULL, 9.31e-9)] = 1e-4;
    initial[mix_species(&v, "OH-", NULL, 5.27e-9)] = 1e-4;
    mix_species(&v, "Mg2+", NULL, 0.705e-9);
    initial[mix_species(&v, "Na+", NULL, 1.33e-9)] = salt;
    initial[mix_species(&v, "Cl-", NULL, 2.03e-9)] = salt;
    memset(&of, 0, sizeof of);
    of.species = mix_species(&v, "Mg(OH)2(s)", NULL, 0.0);
    of.rate = rate;
    of.volume = 24.6e-6;
    initial[of.species] = 1.0;
    if (complex) mix_species(&v, "MgOH+", NULL, 0.7e-9);
    mix_reaction(&v, "H2O = H+ + OH-", -14.0, 0.0, NULL);
    mix_reaction(&v, "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O", log_k, 0.0, NULL);
    if (complex) mix_reaction(&v, "Mg2+ + H2O = MgOH+ + H+", -11.44, 0.0, NULL);
    memset(&d, 0, sizeof d);
    d.minerals = &of;
    d.mineral_count = 1;
    d.initial = initial;
    d.activity = activity;
    d.order = order;
    if (!build(s, &v, &d)) return 0.0;
    for (int k = 0; k < (rate > 0.0 ? 40 : 1); k++)
        if (!step_all(s, dt)) break;
    int32_t middle[3] = {3, 1, 1}, i = pd_grid_node(&s->grid, middle);
    before = ph = pd_reactive_ph(&test_reactive, i);
    CHECK_NEAR(pd_reactive_saturation(&test_reactive, 0, i), 0.0, 1e-9);
    CHECK_NEAR(pd_reactive_film(&test_reactive, i), 24.6e-6 * test_reactive.solid[i], 1e-18);
    CHECK(test_reactive.solid[i] > 0.5 && test_reactive.solid[i] < 1.0);
    for (double more = 1e-3; more < 1e10; more *= 1e4) { /* equilibrium stays */
        step_all(s, more);
        CHECK_NEAR(pd_reactive_ph(&test_reactive, i), before, 1e-10);
    }
    check_balance(s);
    finish(s);
    return ph;
}

TEST(brucite_water)
{
    static const double log_k[4] = {16.298, 16.750, 16.840, 17.100}, ideal[4] = {10.200, 10.350, 10.380, 10.467};
    static const double davies[4] = {10.212, 10.365, 10.396, 10.485};
    for (int k = 0; k < 4; k++) {
        CHECK_NEAR(brucite(log_k[k], 0, PD_ACTIVITY_IDEAL, 0.0, 0.0, 1e6, 1), ideal[k], 1e-3);
        CHECK_NEAR(brucite(log_k[k], 1, PD_ACTIVITY_DAVIES, 0.0, 1e-3, 100.0, 1 + k % 2), davies[k], 2e-3);
    }
    CHECK_NEAR(brucite(16.84, 1, PD_ACTIVITY_DAVIES, 145.0, 1e-3, 100.0, 2), 10.502, 3e-3);
}

/* In a closed volume n' = k ((c/c0)^3 - 1) with c of Mg2+ and 2 c of OH- is an integral in closed form. */
TEST(speed)
{
    scene *s = &test_scene;
    mixture v;
    pd_mineral of;
    pd_reactive_desc d;
    double error[2], k = 1e-3, c0 = cbrt(1e-9 * 1e9 / 4.0), pi = 3.14159265358979324;
    for (int fine = 0; fine < 2; fine++) {
        double initial[3] = {0.0, 0.0, 5.0}, c, sum;
        if (!box(s, 1e-5, 4)) return;
        mix_begin(&v);
        mix_species(&v, "Aa2+", "Mg", 1e-9);
        mix_species(&v, "Bb-", "OH", 1e-9);
        memset(&of, 0, sizeof of);
        of.species = mix_species(&v, "Mg(OH)2(s)", NULL, 0.0);
        of.rate = k;
        mix_reaction(&v, "Mg(OH)2(s) = Aa2+ + 2 Bb-", -9.0, 0.0, NULL);
        memset(&d, 0, sizeof d);
        d.minerals = &of;
        d.mineral_count = 1;
        d.initial = initial;
        d.order = 2;
        if (!build(s, &v, &d)) return;
        int steps = fine ? 80 : 40;
        double end = 500.0;
        for (int step = 0; step < steps; step++)
            if (!step_all(s, end / steps)) return;
        int32_t index[3] = {2, 1, 1}, i = pd_grid_node(&s->grid, index);
        c = test_reactive.c[i] / c0; /* t = c0/k int dx/(1 - x^3) from 0 to c */
        sum = log((c * c + c + 1.0) / ((1.0 - c) * (1.0 - c))) / 6.0 +
              (atan((2.0 * c + 1.0) / sqrt(3.0)) - pi / 6.0) / sqrt(3.0);
        error[fine] = fabs(c0 / k * sum / end - 1.0);
        CHECK_NEAR(test_reactive.c[i] + test_reactive.solid[i], 5.0, 1e-12);
        finish(s);
    }
    NOTE("%.2e, %.2e", error[0], error[1]);
    CHECK_LE(error[1], 1e-4);
    CHECK_LE(error[1], error[0] / 3.0);
}

/* ---- fronts ---- */

/* s of x_f = 2 s sqrt(t): n a sqrt(Da) exp(-s^2/Da)/(1 + erf(s/sqrt Da)) = b sqrt(Db) exp(-s^2/Db)/erfc(s/sqrt Db). */
static double front_of(double a, double b, double da, double db, double n)
{
    double low = -4.0 * sqrt(fmax(da, db)), high = -low;
    for (int k = 0; k < 200; k++) {
        double s = 0.5 * (low + high), left = n * a * sqrt(da) * exp(-s * s / da) / (1.0 + erf(s / sqrt(da)));
        if (left > b * sqrt(db) * exp(-s * s / db) / erfc(s / sqrt(db))) low = s;
        else high = s;
    }
    return 0.5 * (low + high);
}

/* A + n B make a solid at once. Place of the front and amount of the solid over their values. */
static double front(double a0, double b0, double da, double db, double ratio, int n, double share, int order,
                    double *product)
{
    scene *s = &test_scene;
    mixture v;
    pd_mineral of;
    pd_reactive_desc d;
    double initial[3] = {0.0, 0.0, 0.0}, end = 100.0, half = 4.0 * sqrt(fmax(da, db) * end), h = 2.0 * half / n;
    double time = 0.0, x[PD_DIM], where = 0.0, sum = 0.0, before = 0.0, pi = 3.14159265358979324;
    int32_t index[3] = {0, 0, 0};
    if (!box(s, h, n)) return 0.0;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", da);
    mix_species(&v, "Bb", "K", db);
    memset(&of, 0, sizeof of);
    of.species = mix_species(&v, ratio > 1.5 ? "NaK2(s)" : "NaK(s)", NULL, 0.0);
    mix_reaction(&v, ratio > 1.5 ? "NaK2(s) = Aa + 2 Bb" : "NaK(s) = Aa + Bb", -20.0, 0.0, NULL);
    memset(&d, 0, sizeof d);
    d.minerals = &of;
    d.mineral_count = 1;
    d.initial = initial;
    d.order = order;
    if (!build(s, &v, &d)) return 0.0;
    double *a = pd_reactive_field(&test_reactive, 0), *b = pd_reactive_field(&test_reactive, 1);
    double *p = pd_reactive_field(&test_reactive, 2);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        a[i] = x[0] < half ? a0 : 0.0;
        b[i] = x[0] < half ? 0.0 : b0;
    }
    CHECK_OK(&s->ctx, pd_reactive_begin(&s->ctx, &test_reactive));
    int newton = 0, krylov = 0, steps = 0, parts = 0;
    for (double dt = 1e-2; time < end; dt = share * time) {
        dt = fmin(dt, end - time);
        if (!step_all(s, dt)) break;
        newton += test_result.newton;
        krylov += test_result.krylov;
        parts += test_result.parts;
        steps++;
        time = end - time - dt < 1e-9 ? end : time + dt;
    }
    NOTE("%.1f of Newton, %.1f of GMRES a step", (double)newton / steps, (double)krylov / steps);
    CHECK_INT(parts, 0);
    check_balance(s);
    for (index[0] = 0; index[0] < n; index[0]++) {
        int32_t i = pd_grid_node(&s->grid, index);
        double u = ratio * da * a[i] - db * b[i]; /* smooth across the front */
        pd_grid_position(&s->grid, i, x);
        if (index[0] && before > 0.0 && u <= 0.0) where = x[0] - half - h * (1.0 - before / (before - u));
        before = u;
        sum += p[i] * h;
        CHECK(a[i] >= 0.0 && b[i] >= 0.0 && p[i] >= 0.0);
    }
    double f = front_of(a0, b0, da, db, ratio);
    double flux = 2.0 * a0 * sqrt(da / pi) * exp(-f * f / da) / (1.0 + erf(f / sqrt(da)));
    *product = sum / (flux * sqrt(end));
    finish(s);
    return where / (2.0 * f * sqrt(end));
}

TEST(fronts)
{
    if (PD_DIM == 3 && !getenv("PD_HARD")) SKIP("in 3D with PD_HARD=1 alone: nothing depends on the third axis");
    static const double of[3][5] = {{300.0, 100.0, 1e-9, 1e-9, 1.0}, {100.0, 100.0, 9.31e-9, 5.27e-9, 1.0},
                                    {10.0, 100.0, 0.705e-9, 5.27e-9, 2.0}};
    for (int k = 0; k < 3; k += PD_DIM > 1 ? 2 : 1) {
        double product, found;
        found = front(of[k][0], of[k][1], of[k][2], of[k][3], of[k][4], PD_DIM > 1 ? 120 : 240, 0.02, 1, &product);
        NOTE("place %.2e, product %.2e", found - 1.0, product - 1.0);
        CHECK_REL(found, 1.0, 0.005);
        CHECK_REL(product, 1.0, 0.01);
    }
}

/* ---- pores ---- */

static double at_ends(void *user, const double *x)
{
    double length = *(const double *)user;
    return x[0] < 1e-6 ? 1.0 : x[0] > length - 1e-6 ? 1.0 : (double)NAN;
}

/* Flux through a layer of water and one with a solid in it, between values of 0 and 1 mol/m3 on both sides: layers in
 * series, L/(L1/D + L2 tau/(D eps)). The solute at the wall is that of the held walls; a source in the middle. */
TEST(pores)
{
    scene *s = &test_scene;
    mixture v;
    pd_mineral of;
    pd_reactive_desc d;
    int n = 40;
    double h = 1e-5, length = n * h, initial[2] = {0.0, 0.0}, wall[2] = {0.0, NAN}, x[PD_DIM], eps = 0.3, tau = 2.0;
    scene_box(s, 2.0, h, n, 4, 4);
    s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_WALL;
    for (int e = 1; e < PD_DIM; e++) s->grid_desc.side[2 * e] = s->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
    if (!scene_build(s)) return;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", 1e-9);
    memset(&of, 0, sizeof of);
    of.species = mix_species(&v, "Na(s)", NULL, 0.0);
    of.volume = 1e-4;
    of.rate = 1e-30;
    mix_reaction(&v, "Na(s) = Aa", 0.0, 0.0, NULL);
    memset(&d, 0, sizeof d);
    d.minerals = &of;
    d.mineral_count = 1;
    d.initial = initial;
    d.wall = wall;
    d.held = at_ends;
    d.user = &length;
    d.tortuosity = tau;
    if (!build(s, &v, &d)) return;
    double *c = pd_reactive_field(&test_reactive, 0), *p = pd_reactive_field(&test_reactive, 1);
    double *source = pd_reactive_source(&test_reactive, 0);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        if (x[0] > 0.5 * length) p[i] = (1.0 - eps) / of.volume;
        source[i] = 1e-3;
    }
    CHECK_OK(&s->ctx, pd_reactive_begin(&s->ctx, &test_reactive));
    for (int k = 0; k < 3; k++) step_all(s, 1e9);
    /* D1 c'' = -q on the left, D2 c'' = -q on the right, c and flux the same in the middle, 0 at the ends */
    double d1 = 1e-9, d2 = d1 * eps / tau, q = 1e-3, l = 0.5 * length, worst = 0.0, most = 0.0;
    double middle = q * l * l / (d1 + d2);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        double from = x[0] < l ? x[0] : length - x[0], at = x[0] < l ? d1 : d2;
        double exact = middle * from / l + 0.5 * q / at * from * (l - from);
        worst = fmax(worst, fabs(c[i] - exact));
        most = fmax(most, exact);
    }
    NOTE("%.2e of %.3g", worst / most, most);
    CHECK_LE(worst, 0.01 * most);
    check_balance(s);
    finish(s);
}

/* ---- any step ---- */

/* A step that is too long at once is refused, and nothing has changed; or it is one. */
static void jump(scene *s, double dt)
{
    size_t size = (size_t)test_reactive.components.solutes * (size_t)s->grid.total * sizeof(double);
    double *kept = (double *)malloc(size);
    if (!CHECK(kept != NULL)) return;
    memcpy(kept, test_reactive.c, size);
    pd_status status = pd_reactive_step(&s->ctx, &test_reactive, dt, &test_result);
    if (status == PD_RETRY) CHECK(memcmp(kept, test_reactive.c, size) == 0);
    else CHECK_OK(&s->ctx, status);
    check_balance(s);
    free(kept);
}

/* Body fluid that meets a lye: several minerals in steps that grow from 1 us to beyond all time scales. The same on one
 * thread and on two. */
TEST(any_step)
{
    if (PD_DIM > 1) SKIP("in 1D alone: nothing depends on the other axes");
    scene *s = &test_scene;
    uint64_t seen[2] = {0, 0};
    for (int threads = 1; threads <= 2; threads++) {
        mixture v;
        pd_mineral of[3];
        pd_reactive_desc d;
        double initial[PD_SPECIES_MOST], x[PD_DIM];
        if (!box(s, 1e-5, 10)) return;
        s->ctx.threads = threads;
        mix_body_fluid(&v);
        mix_hanks(&v, initial);
        memset(of, 0, sizeof of);
        of[0].species = mix_species(&v, "Mg(OH)2(s)", NULL, 0.0);
        of[1].species = mix_species(&v, "CaCO3(s)", NULL, 0.0);
        of[2].species = mix_species(&v, "Ca5(PO4)3OH(s)", NULL, 0.0);
        for (int k = 0; k < 3; k++) initial[of[k].species] = 0.0;
        of[0].volume = 24.6e-6;
        of[1].rate = 1e-4;
        of[1].volume = 36.9e-6;
        of[2].surface = 1e-4;
        of[2].rate = 1e-6;
        mix_reaction(&v, "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O", 16.84, 0.0, NULL);
        mix_reaction(&v, "CaCO3(s) = Ca2+ + CO3-2", -8.48, 0.0, NULL);
        mix_reaction(&v, "Ca5(PO4)3OH(s) + 4 H+ = H2O + 3 HPO4-2 + 5 Ca2+", -3.421, 0.0, NULL);
        memset(&d, 0, sizeof d);
        d.minerals = of;
        d.mineral_count = 3;
        d.initial = initial;
        d.activity = PD_ACTIVITY_DAVIES;
        d.order = 2;
        if (!build(s, &v, &d)) return;
        double *oh = pd_reactive_field(&test_reactive, mix_at(&v, "OH-"));
        double *na = pd_reactive_field(&test_reactive, mix_at(&v, "Na+"));
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            if (x[0] < 3e-5) oh[i] += 50.0;
            if (x[0] < 3e-5) na[i] += 50.0;
        }
        CHECK_OK(&s->ctx, pd_reactive_begin(&s->ctx, &test_reactive));
        int newton = 0;
        if (threads == 1) jump(s, 1e8);
        for (double dt = 1e-6; dt < 1e10; dt *= 10.0) {
            if (!step_all(s, dt)) break;
            newton += test_result.newton;
            check_balance(s);
        }
        int64_t size = 3 * (int64_t)s->grid.total;
        for (int64_t k = 0; k < size; k++) {
            uint64_t bits;
            CHECK(test_reactive.solid[k] >= 0.0);
            memcpy(&bits, &test_reactive.solid[k], sizeof bits);
            seen[threads - 1] = seen[threads - 1] * 1099511628211u + bits;
        }
        NOTE("%.0f steps of Newton, %.3g mol/m3 of brucite", (double)newton,
             test_reactive.solid[pd_grid_node(&s->grid, (int32_t[3]){2, 1, 1})]);
        finish(s);
    }
    CHECK(seen[0] == seen[1]);
}

TEST_MAIN(ENTRY(brucite_water) ENTRY(speed) ENTRY(fronts) ENTRY(pores) ENTRY(any_step))
