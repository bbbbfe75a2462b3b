/* migration: closed forms of ambipolar diffusion, junctions and dissolution in a salt; neutrality, totals and signs for
 * steps of any length; orders, threads, iterations.
 * dims: 1 2 3 */
#include "react/advance.h"
#include "chemistry_case.h"
#include "fixture.h"

static scene test_scene;
static pd_reactive test_reactive;
static pd_reactive_result test_result;

/* Thermal voltage at 25 C [V]. */
#define VOLT (8.314462618 * 298.15 / 96485.33212)

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

/* Rows of the balance close, nodes are neutral, nothing is negative. */
static void check_state(scene *s)
{
    pd_reactive_balance b;
    for (int row = 0; row < test_reactive.rows; row++) {
        pd_reactive_balance_of(&s->ctx, &test_reactive, row, &b);
        if (!CHECK_LE(b.relative, 1e-12)) NOTE("%s", b.name);
    }
    CHECK_LE(pd_reactive_neutrality(&test_reactive), 1e-14);
    int negative = 0;
    for (int64_t at = 0; at < test_reactive.components.solutes * (int64_t)s->grid.total; at++)
        negative += !(test_reactive.c[at] >= 0.0);
    CHECK_INT(negative, 0);
}

/* ---- a binary salt ---- */

typedef struct salt {
    const char *plus, *minus;
    double zp, zm, dp, dm; /* [-], [m2/s] */
} salt;

static const salt salts[3] = {{"Na+", "Cl-", 1.0, -1.0, 1.33e-9, 2.03e-9},
                              {"Mg2+", "Cl-", 2.0, -1.0, 0.705e-9, 2.03e-9},
                              {"H+", "Cl-", 1.0, -1.0, 9.31e-9, 2.03e-9}};

static double ambipolar(const salt *a)
{
    return a->dp * a->dm * (a->zp - a->zm) / (a->zp * a->dp - a->zm * a->dm);
}

/* A wave of salt cos(pi x/L) between mirrors decays with the ambipolar D: that D from a time of one decay, over the
 * closed form; *rise: phi between the ends over its closed form, at the end. */
static double wave(const salt *a, double m, int n, int steps, double *rise)
{
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double initial[2], length = 1e-3, pi = 3.14159265358979324, first = 0.0, last = 0.0, x[PD_DIM], low, high;
    double end = length * length / (pi * pi * ambipolar(a)), mean = 100.0, part = 50.0;
    int32_t index[3] = {0, 0, 0};
    mix_begin(&v);
    mix_species(&v, a->plus, NULL, a->dp);
    mix_species(&v, a->minus, NULL, a->dm);
    memset(&d, 0, sizeof d);
    d.migration = 1;
    d.order = 2;
    initial[0] = mean;
    initial[1] = -a->zp / a->zm * mean;
    d.initial = initial;
    if (!build(s, &v, &d, m, n, length / n, 4)) return 0.0;
    double *plus = pd_reactive_field(&test_reactive, 0), *minus = pd_reactive_field(&test_reactive, 1);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        plus[i] = mean + part * cos(pi * x[0] / length);
        minus[i] = -a->zp / a->zm * plus[i];
    }
    CHECK_OK(&s->ctx, pd_reactive_begin(&s->ctx, &test_reactive));
    for (int32_t i = 0; i < s->grid.total; i++) {
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] == PD_FLUID) first += plus[i] * cos(pi * x[0] / length);
    }
    for (int k = 0; k < steps; k++)
        if (!step_all(s, end / steps)) return 0.0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] == PD_FLUID) last += plus[i] * cos(pi * x[0] / length);
    }
    check_state(s);
    int32_t left = pd_grid_node(&s->grid, index);
    index[0] = n - 1;
    int32_t right = pd_grid_node(&s->grid, index);
    low = plus[left];
    high = plus[right];
    *rise = (pd_reactive_potential(&test_reactive, right) - pd_reactive_potential(&test_reactive, left)) /
            (VOLT * (a->dm - a->dp) / (a->zp * a->dp - a->zm * a->dm) * log(high / low));
    finish(s);
    return -log(last / first);
}

TEST(ambipolar_diffusion)
{
    static const double wanted[3] = {1.608e-9, 1.2489e-9, 3.3373e-9};
    for (int k = 0; k < 3; k++) {
        double rise, d = wave(&salts[k], 2.0, PD_DIM == 1 ? 100 : 40, 100, &rise);
        NOTE("%s%s: D %.6g over %.6g, phi %.2e", salts[k].plus, salts[k].minus, d * ambipolar(&salts[k]),
             ambipolar(&salts[k]), rise - 1.0);
        CHECK_REL(d * ambipolar(&salts[k]), wanted[k], PD_DIM == 1 ? 1e-3 : 2e-3);
        CHECK_REL(rise, 1.0, 1e-3);
    }
}

TEST_MAIN(ENTRY(ambipolar_diffusion))
