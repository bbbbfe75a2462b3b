/* precipitation: brucite that dissolves in water until it is saturated, fronts where a solid forms at once, diffusion
 * through pores, balances and steps of any length.
 * dims: 1 2 3 */
#include "react/advance.h"
#include "chemistry_case.h"
#include "fixture.h"
#include "cases/vessel.h"
#include "cases/minerals.h"

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

/* What a shared case kept: balances close, nothing is negative, what a cell holds is what takes its room. */
static void check_found(const mineral_found *f)
{
    CHECK_LE(f->imbalance, 1e-12);
    CHECK_LE(0.0, f->least);
    CHECK_LE(f->room, 1e-15);
}

/* ---- brucite ---- */

/* pH over brucite. */
static double brucite(double log_k, pd_activity activity, double salt, double rate, double dt, int order)
{
    pd_ctx ctx;
    mineral_found f;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, mineral_brucite(&ctx, log_k, activity, salt, rate, dt, order, &f))) return 0.0;
    CHECK_NEAR(f.index, 0.0, 1e-9);
    CHECK(f.amount > 0.5 && f.amount < 1.0);
    CHECK_LE(f.drift, 1e-10);
    check_found(&f);
    return f.ph;
}

TEST(brucite_water)
{
    static const double log_k[4] = {16.298, 16.750, 16.840, 17.100}, ideal[4] = {10.200, 10.350, 10.380, 10.467};
    static const double davies[4] = {10.212, 10.365, 10.396, 10.485};
    for (int k = 0; k < 4; k++) {
        CHECK_NEAR(brucite(log_k[k], PD_ACTIVITY_IDEAL, 0.0, 0.0, 1e6, 1), ideal[k], 1e-3);
        CHECK_NEAR(brucite(log_k[k], PD_ACTIVITY_DAVIES, 0.0, 1e-3, 100.0, 1 + k % 2), davies[k], 2e-3);
    }
    CHECK_NEAR(brucite(16.84, PD_ACTIVITY_DAVIES, 145.0, 1e-3, 100.0, 2), 10.502, 3e-3);
}

/* In a closed volume n' = k ((c/c0)^3 - 1) with c of Mg2+ and 2 c of OH- is an integral in closed form. */
TEST(speed)
{
    pd_ctx ctx;
    mineral_found f[2];
    pd_ctx_init(&ctx);
    for (int fine = 0; fine < 2; fine++) {
        if (!CHECK_OK(&ctx, mineral_speed(&ctx, fine ? 80 : 40, &f[fine]))) return;
        CHECK_NEAR(f[fine].amount, 5.0, 1e-12);
        check_found(&f[fine]);
    }
    NOTE("%.2e, %.2e", f[0].value, f[1].value);
    CHECK_LE(f[1].value, 1e-4);
    CHECK_LE(f[1].value, f[0].value / 3.0);
}

/* ---- fronts ---- */

/* A + n B make a solid at once. */
TEST(fronts)
{
    pd_ctx ctx;
    mineral_found f;
    if (PD_DIM == 3 && !getenv("PD_HARD")) SKIP("in 3D with PD_HARD=1 alone: nothing depends on the third axis");
    pd_ctx_init(&ctx);
    for (int k = 0; k < 3; k += PD_DIM > 1 ? 2 : 1) {
        if (!CHECK_OK(&ctx, mineral_front(&ctx, &mineral_couples[k], PD_DIM > 1 ? 120 : 240, 0.02, 1, &f))) return;
        NOTE("place %.2e, product %.2e; %.1f of Newton, %.1f of GMRES a step", f.value, f.product, f.newton, f.krylov);
        CHECK_LE(f.value, 0.005);
        CHECK_LE(f.product, 0.01);
        CHECK_INT(f.parts, 0);
        check_found(&f);
    }
}

/* ---- pores ---- */

/* Diffusion through a layer of water and one with a solid in it, which changes by less than its rounding. */
TEST(pores)
{
    for (int k = 0; k < 4; k++) {
        pd_ctx ctx;
        mineral_found f;
        pd_ctx_init(&ctx);
        if (!CHECK_OK(&ctx, mineral_pores(&ctx, k < 2 ? 40 : 80, 2.0, k % 2 ? 1e12 : 1e6, &f))) return;
        NOTE("%.2e", f.value);
        CHECK_LE(f.value, k < 2 ? 0.01 : 0.003);
        check_found(&f);
    }
}

/* Sodium as a cosine in pores that a solid narrows everywhere alike. */
static void wave(void *user, double x, double *c)
{
    const vessel *v = (const vessel *)user;
    c[0] = 10.0 * (1.0 + cos(3.14159265358979323846 * x / (v->n * v->h)));
    c[1] = c[0];
}

/* n' = k (c^2/K - 1) with c + n kept, by Runge and Kutta: the integral of what the solid leaves open. */
static double open_time(double end, double volume, double n, double c, double rate, double k)
{
    double sum = 0.0, all = c + n, dt = end / 4000.0;
    for (int step = 0; step < 4000; step++) {
        double at[4], x[4] = {0.0};
        for (int j = 0; j < 4; j++) {
            double there = n + (j ? (j < 3 ? 0.5 : 1.0) * dt * x[j - 1] : 0.0);
            at[j] = 1.0 - volume * there;
            x[j] = rate * ((all - there) * (all - there) / k - 1.0);
        }
        n += dt * (x[0] + 2.0 * x[1] + 2.0 * x[2] + x[3]) / 6.0;
        sum += dt * (at[0] + 2.0 * at[1] + 2.0 * at[2] + at[3]) / 6.0;
    }
    return sum;
}

/* A wave in pores that narrow decays by exp(-D q^2 t), t being the time that they were open: steps are of second order,
 * without a run, and the estimate knows how pores narrow. */
TEST(pores_that_narrow)
{
    const double pi = 3.14159265358979323846, d = 1e-9, end = 400.0, volume = 4e-3;
    double found[3], error[3];
    for (int k = 0; k < 3; k++) {
        vessel v;
        pd_ctx ctx;
        pd_ctx_init(&ctx);
        vessel_begin(&ctx, &v, 40, 2e-5, 1.0);
        int na = vessel_species(&v, "Na+", NULL, d, 0.0);
        vessel_species(&v, "Cl-", NULL, d, 0.0);
        vessel_species(&v, "Mg2+", NULL, 1e-12, 1000.0);
        vessel_species(&v, "SO4-2", NULL, 1e-12, 1000.0);
        pd_mineral *m = vessel_mineral(&v, "MgSO4(s)", 20.0);
        m->rate = 2.0;
        m->volume = volume;
        vessel_reaction(&v, "MgSO4(s) = Mg2+ + SO4-2", log10(0.9));
        v.desc.order = 2;
        v.desc.tortuosity = 1.0;
        vessel_fill(&v);
        vessel_pour(&v, wave, &v);
        error[k] = 0.0;
        for (int step = 0; step < 10 << k; step++) {
            vessel_step(&v, end / (10 << k));
            if (step) error[k] = fmax(error[k], v.result.error);
        }
        if (CHECK_OK(&ctx, v.status))
            found[k] = log(vessel_field(&v, na)[vessel_node(&v, 0)] / 10.0 - 1.0);
        CHECK_LE(vessel_imbalance(&v), 1e-12);
        vessel_end(&v);
    }
    double q = pi / (40 * 2e-5), shut = -d * q * q * open_time(end, volume, 20.0, 1000.0, 2.0, 0.9e6);
    double order = log2(fabs((found[0] - found[1]) / (found[1] - found[2])));
    NOTE("%.5f %.5f %.5f, %.5f in closed form; order %.2f; estimates %.2e %.2e %.2e",
         found[0], found[1], found[2], shut,
         order, error[0], error[1], error[2]);
    CHECK_LE(1.7, order);
    CHECK_NEAR(found[2] - log(cos(0.5 * pi / 40)), shut, 1e-3 * fabs(shut));
    CHECK_LE(1.5, log2(error[1] / error[2]));
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
        double initial[PD_SPECIES_MAX], x[PD_DIM];
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
        of[2].surface_rate = 1e-4;
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

TEST_MAIN(ENTRY(brucite_water) ENTRY(speed) ENTRY(fronts) ENTRY(pores) ENTRY(pores_that_narrow) ENTRY(any_step))
