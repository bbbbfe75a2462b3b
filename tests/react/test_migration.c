/* migration: closed forms of ambipolar diffusion, junctions and dissolution in a salt; neutrality, totals and signs for
 * steps of any length; orders, threads, iterations.
 * dims: 1 2 3 */
#include "react/advance.h"
#include "transport/migrate.h"
#include "chemistry_case.h"
#include "fixture.h"
#include "cases/vessel.h"
#include "cases/salts.h"

static scene test_scene;
static pd_reactive test_reactive;
static pd_reactive_result test_result;
static pd_side test_side; /* behind the first end of axis 0 */

/* Thermal voltage at 25 C [V]. */
#define VOLT SALT_VOLT

static void finish(scene *s)
{
    pd_reactive_free(&s->ctx, &test_reactive);
    scene_free(s);
}

/* Build on a box of n cells of h along axis 0, closed but for what the desc holds. */
static int build(scene *s, mixture *v, pd_reactive_desc *d, double m, int n, double h, int across)
{
    scene_box(s, m, h, n, across, across);
    for (int e = 1; e < PD_DIM; e++) s->grid_desc.side[2 * e] = s->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
    s->grid_desc.side[0] = test_side;
    if (test_side == PD_SIDE_MIRROR) s->grid_desc.side[1] = test_side;
    if (!scene_build(s)) return 0;
    d->species = v->s;
    d->count = v->species;
    d->reactions = v->r;
    d->reaction_count = v->reactions;
    d->temperature = 298.15;
    return CHECK_OK(&s->ctx, pd_reactive_build(&s->ctx, &s->grid, &s->bonds, NULL, d, &test_reactive));
}

static int step_all(scene *s, double dt)
{
    pd_status status = pd_reactive_step(&s->ctx, &test_reactive, dt, &test_result);
    return CHECK_OK(&s->ctx, status);
}

/* Rows of the balance close to rounding of what they hold and of what has passed [mol], nodes are neutral, nothing is
 * negative. */
static void check_passed(scene *s, double passed)
{
    pd_reactive_balance b;
    for (int row = 0; row < test_reactive.rows; row++) {
        pd_reactive_balance_of(&s->ctx, &test_reactive, row, &b);
        if (!(fabs(b.imbalance) <= 1e-12 * passed) && !CHECK_LE(b.relative, 1e-12)) NOTE("%s", b.name);
    }
    CHECK_LE(pd_reactive_neutrality(&test_reactive), 1e-14);
    int negative = 0;
    for (int64_t at = 0; at < test_reactive.components.solutes * (int64_t)s->grid.total; at++)
        negative += !(test_reactive.c[at] >= 0.0);
    CHECK_INT(negative, 0);
}

static void check_state(scene *s) { check_passed(s, 0.0); }

/* What a shared case kept: balances close, nodes are neutral, nothing is negative. */
static void check_found(const salt_found *f)
{
    CHECK_LE(f->imbalance, 1e-12);
    CHECK_LE(f->neutral, 1e-14);
    CHECK_LE(0.0, f->least);
}

/* ---- a bond ---- */

/* B(w) = w/(exp(w) - 1) against expm1 of the library: what leaves by diffusion in a field. Both ends see the same bits,
 * and differ by w. */
TEST(shares_of_a_bond)
{
    double worst = 0.0, apart = 0.0, by = 0.0;
    int odd = 0;
    if (PD_DIM > 1) SKIP("in 1D alone: a bond has no dimension");
    for (int k = 0; k < 1000000; k++) {
        double far = 700.0 * (k - 499999.5) / 5e5, x = k % 2 ? far : ldexp(far, -(k % 30)); /* many near 0 */
        double exact = (double)(x / expm1l((long double)x)), share = pdi_migrate_leave(1.0, 0.0, x, 1.0, 0.0);
        double other = -pdi_migrate_leave(1.0, 0.0, x, 0.0, 1.0), back = pdi_migrate_leave(1.0, 0.0, -x, 1.0, 0.0);
        worst = fmax(worst, fabs(share - exact) / exact);
        apart = fmax(apart, fabs((other - share) - x) / fmax(other, share));
        odd += other < back || other > back;
        if (fabs(x) < 0.05) continue; /* the closed form has no digits */
        long double e = expm1l((long double)x), slope = (e - (long double)x * (e + 1.0L)) / (e * e);
        if (e < 1e100L) by = fmax(by, fabs((double)slope + pdi_migrate_conduct(x, 1.0, 0.0)));
    }
    NOTE("%.2f roundings, ends %.2f, slope %.1e", worst / DBL_EPSILON, apart / DBL_EPSILON, by);
    CHECK_LE(worst, 2.0 * DBL_EPSILON); /* at most 4 units in the last place */
    CHECK_LE(apart, DBL_EPSILON);
    CHECK_LE(by, 4e-15);
    CHECK_INT(odd, 0);
}

/* ---- a binary salt ---- */

TEST(ambipolar_diffusion)
{
    pd_ctx ctx;
    salt_found f;
    int n = PD_DIM == 1 ? 100 : 40;
    pd_ctx_init(&ctx);
    for (int k = 0; k < SALTS; k += PD_DIM == 1 ? 1 : 2) {
        const salt *a = &salt_table[k];
        if (!CHECK_OK(&ctx, salt_wave(&ctx, a, n, 2.0, n, PD_SIDE_WALL, &f))) return;
        NOTE("%s%s: D %.6g over %.6g, t+ %.6f", a->plus, a->minus, f.d, a->ambipolar, f.share);
        CHECK_REL(salt_ambipolar(a), a->ambipolar, 1e-4);
        CHECK_REL(f.d, a->ambipolar, PD_DIM == 1 ? 1e-3 : 2e-3);
        CHECK_REL(f.share, a->share, 2e-4);
        check_found(&f);
    }
}

/* Errors fall with the square of the spacing for every horizon. */
TEST(order)
{
    pd_ctx ctx;
    salt_found f;
    if (PD_DIM > 1) SKIP("in 1D alone: nothing depends on other axes");
    pd_ctx_init(&ctx);
    for (int m = 1; m <= 3; m++) {
        double off[3];
        for (int k = 0; k < 3; k++) {
            CHECK_OK(&ctx, salt_wave(&ctx, &salt_table[3], 15 << k, m, 400, PD_SIDE_MIRROR, &f));
            off[k] = fabs(f.d / salt_ambipolar(&salt_table[3]) - 1.0);
        }
        NOTE("m = %d: %.2e, %.2e, %.2e", m, off[0], off[1], off[2]);
        for (int k = 0; k < 2; k++) CHECK_NEAR(log(off[k] / off[k + 1]) / log(2.0), 2.0, 0.04);
    }
}

/* ---- dissolution into a salt ---- */

static int dissolution(int z, double ratio, int n, salt_found *f)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, salt_dissolution(&ctx, z, ratio, n, 1.0, f))) return 0;
    check_found(f);
    NOTE("z %d, cb/cs %g, %d cells: c %.2e, phi %.2e, enhancement %.6f; newton %d krylov %d", z, ratio, n, f->c, f->psi,
         f->enhancement, f->newton, f->krylov);
    return 1;
}

TEST(supported_dissolution)
{
    static const double ratio[3] = {0.1, 1.0, 10.0};
    for (int z = 1; z <= 2; z++)
        for (int k = 0; k < 3; k++) {
            salt_found coarse, fine;
            int n = PD_DIM == 1 ? 100 : 40;
            if (!dissolution(z, ratio[k], n, &coarse) || !dissolution(z, ratio[k], 2 * n, &fine)) return;
            CHECK_LE(fine.c, 1e-3);
            CHECK_LE(fine.psi, PD_DIM == 1 ? 1e-3 : 1.2e-3);
            CHECK_LE(1.75, log(coarse.c / fine.c) / log(2.0));
            CHECK_LE(1.5, log(coarse.psi / fine.psi) / log(2.0));
        }
}

/* A thousandth of salt: psi falls in a layer of a thousandth of the way. */
TEST(little_support)
{
    salt_found f;
    for (int z = 1; z <= 2; z++)
        if (dissolution(z, 1e-3, PD_DIM == 1 ? 1600 : 60, &f) && PD_DIM == 1) CHECK_LE(f.c, 1e-3);
}

TEST(blocked_anion)
{
    pd_ctx ctx;
    salt_found f;
    pd_ctx_init(&ctx);
    for (int z = 1; z <= 3; z++) {
        if (!CHECK_OK(&ctx, salt_blocked(&ctx, z, PD_DIM == 1 ? 100 : 60, 1.0, &f))) return;
        NOTE("z %d: %.2e, newton %d krylov %d", z, f.c, f.newton, f.krylov);
        CHECK_LE(f.c, 1e-3);
        CHECK_REL(f.enhancement, 1.0 + z, 1e-3);
        check_found(&f);
    }
}

/* ---- junctions ---- */

static double at_right(void *user, const double *x)
{
    return x[0] > *(const double *)user - 1e-9 ? 1.0 : (double)NAN;
}

/* A film between HCl and KCl of one concentration: its field is constant, its anion, too. No current flows at phi =
 * RT/F ln((D_H + D_Cl)/(D_K + D_Cl)) (Lewis and Sargent), and its cations are a + b exp(-psi). */
TEST(junction)
{
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double acid[3] = {100.0, 0.0, 100.0}, salt_of[3] = {0.0, 100.0, 100.0}, length = 1e-4, x[PD_DIM], worst = 0.0;
    double psi = log((9.31e-9 + 2.033e-9) / (1.96e-9 + 2.033e-9)), current[2];
    static const double diffusivity[3] = {9.31e-9, 1.96e-9, 2.033e-9}, z[3] = {1.0, 1.0, -1.0};
    int n = 40;
    pd_reactive_balance b;
    mix_begin(&v);
    mix_species(&v, "H+", NULL, diffusivity[0]);
    mix_species(&v, "K+", NULL, diffusivity[1]);
    mix_species(&v, "Cl-", NULL, diffusivity[2]);
    CHECK_NEAR(VOLT * psi, 26.83e-3, 0.01e-3);
    for (int open = 0; open < 2; open++) {
        memset(&d, 0, sizeof d);
        d.migration = 1;
        d.initial = salt_of;
        d.inlet = acid;
        d.wall = salt_of;
        d.held = at_right;
        d.user = &length;
        d.inlet_potential = open ? -VOLT * psi : 0.0;
        test_side = PD_SIDE_INLET;
        if (!build(s, &v, &d, 1.0, n, length / n, 4)) return;
        test_side = PD_SIDE_WALL;
        if (!step_all(s, 1e6)) return;
        pd_reactive_balance_of(&s->ctx, &test_reactive, test_reactive.rows - 1, &b);
        check_passed(s, fabs(b.in));
        double *h = pd_reactive_field(&test_reactive, 0), *cl = pd_reactive_field(&test_reactive, 2);
        for (int32_t i = 0; i < s->grid.total && open; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            double here = psi * x[0] / length; /* above the acid */
            worst = fmax(worst, fabs(cl[i] / 100.0 - 1.0));
            worst = fmax(worst, fabs(pd_reactive_potential(&test_reactive, i) / VOLT + psi - here));
            worst = fmax(worst, fabs(h[i] / 100.0 - (exp(-here) - exp(-psi)) / (1.0 - exp(-psi))));
        }
        int32_t index[3] = {20, 0, 0}, i = pd_grid_node(&s->grid, index), j = i + 1;
        double rise = (pd_reactive_potential(&test_reactive, j) - pd_reactive_potential(&test_reactive, i)) / VOLT;
        current[open] = 0.0; /* [mol/m2/s] by differences in the middle */
        for (int k = 0; k < 3; k++) {
            double *c = pd_reactive_field(&test_reactive, k);
            current[open] -= z[k] * diffusivity[k] * n / length *
                             (c[j] - c[i] + z[k] * 0.5 * (c[i] + c[j]) * rise);
        }
        finish(s);
    }
    NOTE("off %.2e, current open %.3e, shorted %.3e", worst, current[1], current[0]);
    CHECK_LE(worst, 1e-6);
    CHECK_LE(fabs(current[1]), 1e-4 * fabs(current[0]));
}

/* ---- any step ---- */

/* Salts side by side in water with its ions, a step of any length: neutral, positive, totals to rounding. */
static int crossed(double high, double low, int n, double dt, int migrates, int threads, double **bits)
{
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double initial[6] = {55344.0, 1e-4, 1e-4, 0.0, 0.0, 0.0}, x[PD_DIM];
    mix_begin(&v);
    mix_species(&v, "H2O", NULL, 0.0);
    mix_species(&v, "H+", NULL, 9.31e-9);
    mix_species(&v, "OH-", NULL, 5.27e-9);
    mix_species(&v, "Mg2+", NULL, 0.705e-9);
    mix_species(&v, "Na+", NULL, 1.33e-9);
    mix_species(&v, "Cl-", NULL, 2.033e-9);
    mix_reaction(&v, "H2O = H+ + OH-", -14.0, 0.0, NULL);
    memset(&d, 0, sizeof d);
    d.migration = migrates;
    d.initial = initial;
    if (!build(s, &v, &d, 2.0, n, 1e-3 / n, PD_DIM == 3 ? 5 : n)) return 0;
    s->ctx.threads = threads;
    double *mg = pd_reactive_field(&test_reactive, 3), *na = pd_reactive_field(&test_reactive, 4);
    double *cl = pd_reactive_field(&test_reactive, 5);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        int left = x[0] < 0.5e-3, under = PD_DIM != 2 || x[PD_DIM > 1] < 0.5e-3;
        mg[i] = left && under ? high : low;
        na[i] = left ? low : high;
        cl[i] = 2.0 * mg[i] + na[i];
    }
    CHECK_OK(&s->ctx, pd_reactive_begin(&s->ctx, &test_reactive));
    if (!step_all(s, dt)) return 0;
    if (migrates) check_state(s);
    size_t size = (size_t)s->grid.total * (size_t)test_reactive.components.solutes * sizeof **bits;
    if (bits && *bits) CHECK(memcmp(*bits, test_reactive.c, size) == 0);
    else if (bits && (*bits = (double *)malloc(size)) != NULL) memcpy(*bits, test_reactive.c, size);
    NOTE("%d, %g:%g, dt %g%s: newton %d krylov %d parts %d", n, high, low, dt,
         migrates ? "" : " without migration", test_result.newton, test_result.krylov, test_result.parts);
    finish(s);
    return test_result.krylov;
}

/* Up to a million times the time of diffusion, 1000 s; in 1D ratios of 1e6 and of nothing beside salt. */
TEST(any_step)
{
    for (double dt = 1e-6; dt < 1e10; dt *= PD_DIM == 1 ? 1e3 : 1e5)
        for (int k = 0; k < (PD_DIM == 1 ? 3 : 1); k++)
            crossed(k ? 100.0 : 10.0, k == 2 ? 0.0 : k ? 1e-4 : 1.0, PD_DIM == 1 ? 60 : 12, dt, 1, 0, NULL);
}

TEST(threads_change_no_bit)
{
    double *bits = NULL;
    for (int threads = 1; threads <= 4; threads *= 2)
        crossed(100.0, 1.0, PD_DIM == 1 ? 400 : 24, 10.0, 1, threads, &bits);
    free(bits);
}

/* As few as nearly those of species that do not see each other, on any lattice. */
TEST(iterations)
{
    int all = getenv("PD_TEST_ALL") != NULL;
    if (PD_DIM == 3) SKIP("in 1D and 2D alone");
    for (int n = PD_DIM == 1 ? 50 : 32; n <= (PD_DIM == 1 ? 800 : all ? 128 : 32); n *= 2)
        for (double dt = 0.1; dt < 2e5; dt *= 100.0) {
            int without = crossed(100.0, 1.0, n, dt, 0, 0, NULL), with = crossed(100.0, 1.0, n, dt, 1, 0, NULL);
            CHECK_LE(with, 2 * without + 12);
        }
}

/* ---- robustness ---- */

/* A metal is deposited from its salt, with 0.5, 0.99 and 1.5 times what can reach it: its surface runs out of ions, and
 * what is asked for beyond is owed. */
TEST(limiting_current)
{
    static const double part[3] = {0.5, 0.99, 1.5};
    for (int k = 0; k < 3; k++) {
        scene *s = &test_scene;
        mixture v;
        pd_reactive_desc d;
        double wall[2] = {100.0, 100.0}, length = 1e-4, x[PD_DIM], flux = 2.0 * 1.33e-9 * 100.0 / length * part[k];
        int n = 50;
        mix_begin(&v);
        mix_species(&v, "Ag+", NULL, 1.33e-9);
        mix_species(&v, "Cl-", NULL, 2.033e-9);
        memset(&d, 0, sizeof d);
        d.migration = 1;
        d.initial = d.wall = wall;
        d.held = at_right;
        d.user = &length;
        if (!build(s, &v, &d, 1.0, n, length / n, 4)) return;
        double *c = pd_reactive_field(&test_reactive, 0), *source = pd_reactive_source(&test_reactive, 0), worst = 0.0;
        for (int32_t i = 0; i < s->grid.total; i++) {
            pd_grid_position(&s->grid, i, x);
            if (s->grid.kind[i] == PD_FLUID && x[0] < length / n) source[i] = -flux * n / length;
        }
        pd_status status = pd_reactive_step(&s->ctx, &test_reactive, k < 2 ? 1e6 : 1.0, &test_result);
        NOTE("%g of the limit: status %d, newton %d, krylov %d, parts %d", part[k], (int)status, test_result.newton,
             test_result.krylov, test_result.parts);
        check_passed(s, k < 2 ? flux * 1e6 * pow(4.0 * length / n, PD_DIM - 1) : 0.0);
        for (int32_t i = 0; i < s->grid.total && k < 2; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            worst = fmax(worst, fabs(c[i] / 100.0 - 1.0 + part[k] * (1.0 - x[0] / length)));
        }
        if (k < 2) CHECK_OK(&s->ctx, status);
        CHECK_LE(worst, 2e-3);
        finish(s);
    }
}

/* What is not neutral is refused. */
TEST(refused)
{
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double initial[2] = {1.0, 1.01};
    mix_begin(&v);
    mix_species(&v, "Na+", NULL, 1.33e-9);
    mix_species(&v, "Cl-", NULL, 2.033e-9);
    memset(&d, 0, sizeof d);
    d.migration = 1;
    d.initial = initial;
    scene_box(s, 1.0, 1e-5, 8, 5, 5);
    if (!scene_build(s)) return;
    d.species = v.s;
    d.count = 2;
    d.temperature = 298.15;
    CHECK_INT(pd_reactive_build(&s->ctx, &s->grid, &s->bonds, NULL, &d, &test_reactive), PD_ERR_ARGUMENT);
    CHECK(strstr(s->ctx.message, "charges sum to") != NULL);
    initial[1] = 1.0;
    d.temperature = 0.0;
    CHECK_INT(pd_reactive_build(&s->ctx, &s->grid, &s->bonds, NULL, &d, &test_reactive), PD_ERR_ARGUMENT);
    d.temperature = 298.15;
    CHECK_OK(&s->ctx, pd_reactive_build(&s->ctx, &s->grid, &s->bonds, NULL, &d, &test_reactive));
    int32_t index[3] = {1, 1, 1};
    pd_reactive_source(&test_reactive, 0)[pd_grid_node(&s->grid, index)] = 1.0;
    CHECK_INT(pd_reactive_step(&s->ctx, &test_reactive, 1.0, &test_result), PD_ERR_ARGUMENT);
    CHECK(strstr(s->ctx.message, "sources give a charge") != NULL);
    finish(s);
}

TEST_MAIN(ENTRY(shares_of_a_bond) SLOW_ENTRY_IF(PD_DIM == 3, ambipolar_diffusion) ENTRY(order)
              ENTRY(supported_dissolution) ENTRY(little_support) ENTRY(blocked_anion) ENTRY(junction) ENTRY(any_step)
                  ENTRY(threads_change_no_bit) ENTRY(iterations) ENTRY(limiting_current) ENTRY(refused))
