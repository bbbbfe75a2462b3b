/* reactive: closed forms of fronts and layers, one species against transport, totals, equilibria and bounds in flows,
 * steps of any length.
 * dims: 1 2 3 */
#include "react/reactive.h"
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

static int step_all(scene *s, double dt)
{
    pd_status status = pd_reactive_step(&s->ctx, &test_reactive, dt, &test_result);
    return CHECK_OK(&s->ctx, status);
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

/* Place of the front and amount of product over its value, at 100 s with n cells, steps of a share of the time. */
static double front(const couple *c, int n, double share, double *product)
{
    scene *s = &test_scene;
    mixture v;
    pd_reactive_desc d;
    double initial[3] = {0.0, 0.0, 0.0}, h = 4e-3 / n, time = 0.0, end = 100.0, x[PD_DIM], where = 0.0;
    scene_box(s, 2.0, h, n, 4, 4);
    for (int e = 1; e < PD_DIM; e++) s->grid_desc.side[2 * e] = s->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
    if (!scene_build(s)) return 0.0;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", c->da);
    mix_species(&v, "Bb", "K", c->db);
    mix_species(&v, "Pp", c->n > 1.5 ? "NaK2" : "NaK", 1e-9);
    mix_reaction(&v, c->n > 1.5 ? "Aa + 2 Bb = Pp" : "Aa + Bb = Pp", 30.0, 0.0, NULL);
    memset(&d, 0, sizeof d);
    d.species = v.s;
    d.count = v.species;
    d.reactions = v.r;
    d.reaction_count = v.reactions;
    d.initial = initial;
    if (!CHECK_OK(&s->ctx, pd_reactive_build(&s->ctx, &s->grid, &s->bonds, NULL, &d, &test_reactive))) return 0.0;
    double *a = pd_reactive_field(&test_reactive, 0), *b = pd_reactive_field(&test_reactive, 1);
    double *p = pd_reactive_field(&test_reactive, 2);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        a[i] = x[0] < 2e-3 ? c->a : 0.0;
        b[i] = x[0] < 2e-3 ? 0.0 : c->b;
    }
    CHECK_OK(&s->ctx, pd_reactive_begin(&s->ctx, &test_reactive));
    int newton = 0, krylov = 0, steps = 0, most = 0, parts = 0;
    for (double dt = 1e-3; time < end; dt = share * (time + 1e-2)) {
        dt = fmin(dt, end - time);
        if (!step_all(s, dt)) break;
        time = end - time - dt < 1e-9 ? end : time + dt;
        newton += test_result.newton;
        krylov += test_result.krylov;
        parts += test_result.parts;
        if (test_result.newton > most) most = test_result.newton;
        steps++;
    }
    check_balance(s);
    double sum = 0.0, before = 0.0;
    int32_t index[3] = {0, 0, 0};
    for (index[0] = 0; index[0] < n; index[0]++) {
        int32_t i = pd_grid_node(&s->grid, index);
        double u = c->n * a[i] - b[i];
        pd_grid_position(&s->grid, i, x);
        if (index[0] && before > 0.0 && u <= 0.0) where = x[0] - 2e-3 - h * (1.0 - before / (before - u));
        before = u;
        sum += p[i] * h;
    }
    double f = front_of(c), flux = 2.0 * c->a * sqrt(c->da / 3.14159265358979324) * exp(-f * f / c->da) /
                                   (1.0 + erf(f / sqrt(c->da)));
    *product = sum / (flux * sqrt(end));
    NOTE("n %d: %d steps %d newton (most %d) %d krylov %d parts: front %g um of %g, product %g", n, steps, newton, most,
         krylov, parts, where * 1e6, 2e6 * f * sqrt(end), *product);
    pd_reactive_free(&s->ctx, &test_reactive);
    scene_free(s);
    return where / (2.0 * f * sqrt(end));
}

TEST(fronts)
{
    couple c = {300.0, 100.0, 1e-9, 1e-9, 1.0}, water = {100.0, 100.0, 9.31e-9 / 4, 5.27e-9 / 4, 1.0};
    couple brucite = {100.0, 200.0, 0.705e-9, 5.27e-9, 2.0};
    double product;
    front(&c, 100, 0.05, &product);
    front(&c, 200, 0.02, &product);
    front(&water, 100, 0.05, &product);
    front(&brucite, 100, 0.05, &product);
}

TEST_MAIN(ENTRY(fronts))
