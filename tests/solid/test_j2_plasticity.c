/* test_j2_plasticity: metal that flows, against closed forms of bars, shear and thick tubes.
 * dims: 1 2 3 */
#include "random.h"
#include "solid/correspondence.h"
#include "solid/equilibrium.h"
#include "test.h"
#include "cases/elasticity.h"
#include <math.h>

#define MOST 4000 /* points */
#define YOUNG 200e9
#define YIELD 300e6
#define HARD 5e9
enum { T = PD_DIM * PD_DIM };

typedef struct body_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence elastic;
    double position[MOST * PD_DIM], volume[MOST];
    double u[MOST * PD_DIM], load[MOST * PD_DIM], stress[MOST * T];
} body_case;

static body_case test_case;

typedef int (*inside_fn)(const double *x);

static int in_all(const double *x) { return x[0] < 1.0; }

/* Cells of width h of a part of the box from `from` to `to`. */
static body_case *cells(inside_fn inside, double from, double to, double h, double m, double hardening)
{
    body_case *c = &test_case;
    pd_correspondence_desc desc;
    int n = (int)((to - from) / h + 0.5), all = 1;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    for (int d = 0; d < PD_DIM; d++) all *= n;
    for (int k = 0; k < all; k++) {
        double *x = c->position + c->desc.count * PD_DIM;
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= n) x[d] = from + (rest % n + 0.5) * h;
        if (inside(x)) c->volume[c->desc.count++] = pow(h, PD_DIM);
    }
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = m * h;
    c->desc.spacing = h;
    memset(&desc, 0, sizeof desc);
    desc.young = YOUNG;
    desc.poisson = 0.3;
    desc.yield = YIELD;
    desc.hardening = hardening;
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body))) return NULL;
    return CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, &c->body, &desc, &c->elastic)) ? c : NULL;
}

static void end(body_case *c)
{
    pd_correspondence_free(&c->ctx, &c->elastic);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

static void linear(const body_case *c, const double *g, double *u)
{
    for (int32_t i = 0; i < c->body.count; i++)
        for (int p = 0; p < PD_DIM; p++) {
            u[i * PD_DIM + p] = 0.0;
            for (int q = 0; q < PD_DIM; q++) u[i * PD_DIM + p] += g[p * PD_DIM + q] * c->position[i * PD_DIM + q];
        }
}

/* Shear, to and fro (1D: tension): the stress follows the closed form of linear hardening, and a uniform stress is in
 * balance. */
TEST(to_and_fro)
{
    static const double strains[4] = {0.02, 0.019, -0.03, 0.001};
    body_case *c = cells(in_all, 0.0, 1.0, PD_DIM == 3 ? 0.125 : 0.1, 3.0, HARD);
    if (!c) return;
    pd_material_interface solid = pd_correspondence_material(&c->elastic);
    double mu = YOUNG / 2.6, root = sqrt(3.0), e_p = 0.0, slip = 0.0;
    for (int step = 0; step < 4; step++) {
        double g[T] = {0.0}, wanted, worst = 0.0;
        g[PD_DIM > 1] = strains[step];
        linear(c, g, c->u);
        /* von Mises' stress is sqrt(3) tau, the equivalent strain gamma/sqrt(3) */
        double scale = PD_DIM > 1 ? root : 1.0, stiffness = PD_DIM > 1 ? 3.0 * mu : YOUNG;
        double strain = strains[step] / scale;
        double trial = stiffness * (strain - e_p), beyond = fabs(trial) - YIELD - HARD * slip;
        if (beyond > 0.0) {
            e_p += copysign(beyond / (stiffness + HARD), trial);
            slip += beyond / (stiffness + HARD);
        }
        wanted = stiffness * (strain - e_p) / scale;
        pd_correspondence_force(&c->ctx, &c->elastic, c->u, c->load);
        pd_correspondence_stress(&c->ctx, &c->elastic, c->u, c->stress);
        for (int32_t i = 0; i < c->body.count; i++) {
            worst = fmax(worst, fabs(c->stress[i * T + (PD_DIM > 1)] - wanted));
            for (int d = 0; d < PD_DIM; d++) {
                double edge = 0.0;
                for (int q = 0; q < PD_DIM; q++)
                    edge += c->stress[i * T + d * PD_DIM + q] * c->elastic.surface_vector[i * PD_DIM + q];
                worst = fmax(worst, fabs(c->load[i * PD_DIM + d] - edge) * c->desc.horizon);
            }
        }
        CHECK_LE(worst, 1e-12 * YOUNG * 0.03);
        CHECK_OK(&c->ctx, solid.commit(&c->ctx, solid.self, c->u));
        CHECK_REL(c->elastic.plastic.equivalent_strain[c->body.count / 2], slip, 1e-12);
        /* what flow has cost is the area under the curve of yield stress against slip */
        CHECK_REL(solid.dissipated(solid.self), YIELD * slip + 0.5 * HARD * slip * slip, 1e-12);
        double elastic = 0.5 * wanted * wanted / (PD_DIM > 1 ? mu : YOUNG);
        CHECK_REL(pd_correspondence_energy(&c->ctx, &c->elastic, c->u), elastic, 1e-9);
    }
    end(c);
}

/* The tangent is the derivative of the forces, and symmetric, also where the strain flows in any direction. */
TEST(tangent)
{
    body_case *c = cells(in_all, 0.0, 1.0, PD_DIM == 3 ? 0.25 : 0.125, 2.0, HARD);
    if (!c) return;
    enum { N = 64 * PD_DIM };
    static double v[N], w[N], fv[N], fw[N], more[N], less[N], u[N];
    pd_material_interface solid = pd_correspondence_material(&c->elastic);
    int n = c->body.count * PD_DIM;
    uint32_t seed = 11;
    CHECK(n <= N);
    for (int k = 0; k < n; k++)
        c->u[k] = 4e-3 * random_real(&seed), v[k] = random_real(&seed), w[k] = random_real(&seed);
    CHECK_OK(&c->ctx, solid.force(&c->ctx, solid.self, c->u, c->load));
    CHECK_OK(&c->ctx, solid.commit(&c->ctx, solid.self, c->u));
    int flowing = 0;
    for (int32_t i = 0; i < c->body.count; i++) flowing += c->elastic.plastic.equivalent_strain[i] > 0.0;
    CHECK(flowing > c->body.count / 2);
    for (int k = 0; k < n; k++) c->u[k] += 4e-3 * random_real(&seed);
    CHECK_OK(&c->ctx, solid.force(&c->ctx, solid.self, c->u, c->load));
    solid.tangent(&c->ctx, solid.self, v, fv);
    solid.tangent(&c->ctx, solid.self, w, fw);
    double one = 0.0, other = 0.0, size = 0.0, step = 1e-8, worst = 0.0, most = 0.0;
    for (int k = 0; k < n; k++) {
        one += c->volume[k / PD_DIM] * w[k] * fv[k];
        other += c->volume[k / PD_DIM] * v[k] * fw[k];
        size += c->volume[k / PD_DIM] * fabs(v[k] * fw[k]);
    }
    CHECK_LE(fabs(one - other), 1e-13 * size);
    for (int k = 0; k < n; k++) u[k] = c->u[k] + step * v[k];
    solid.force(&c->ctx, solid.self, u, more);
    for (int k = 0; k < n; k++) u[k] = c->u[k] - step * v[k];
    solid.force(&c->ctx, solid.self, u, less);
    for (int k = 0; k < n; k++) {
        worst = fmax(worst, fabs((more[k] - less[k]) / (2.0 * step) - fv[k]));
        most = fmax(most, fabs(fv[k]));
    }
    NOTE("tangent: differences are off by %.1e of %.1e", worst, most);
    CHECK_LE(worst, 1e-8 * most);
    end(c);
}

#if PD_DIM == 2
/* A tube of radii 1 and 2. */
static int in_tube(const double *x)
{
    double square = x[0] * x[0] + x[1] * x[1];
    return square > 1.0 && square < 4.0;
}

/* Pressure inside the tube, which nothing holds. */
static pd_status press(body_case *c, double pressure)
{
    pd_material_interface solid = pd_correspondence_material(&c->elastic);
    pd_equilibrium_desc desc;
    pd_equilibrium_result result;
    memset(&desc, 0, sizeof desc);
    for (int32_t i = 0; i < c->body.count; i++) {
        const double *x = c->position + i * PD_DIM, *edge = c->elastic.surface_vector + i * PD_DIM;
        double r = sqrt(x[0] * x[0] + x[1] * x[1]), push = (x[0] * edge[0] + x[1] * edge[1]) / r;
        for (int d = 0; d < PD_DIM; d++) c->load[i * PD_DIM + d] = r < 1.5 ? pressure * push * x[d] / r : 0.0;
    }
    pd_status status = pd_equilibrium_solve(&c->ctx, &solid, &desc, c->load, c->u, &result);
    NOTE("press: %.0f MPa: %d Newton steps, %d iterations", pressure / 1e6, result.steps, result.iterations);
    CHECK_LE(result.residual, 1e-10);
    return status == PD_OK ? solid.commit(&c->ctx, solid.self, c->u) : status;
}

/* Metal flows up to r = 1.5, and the rest of the tube is elastic (Hill 1950, ch. 5, plane strain, k = YIELD/sqrt(3)).
 * Returns the mean error of u where r > 1.8; *slip at r = 1.1. */
static double tube_error(double h, double m, double *slip)
{
    body_case *c = cells(in_tube, -2.0, 2.0, h, m, 0.0);
    if (!c) return 1.0;
    double k = YIELD / sqrt(3.0), flows = 1.5, worst = 0.0, wanted = 0.0, nu = 0.3, nearest = 1.0;
    double pressure = k * elasticity_hill_pressure(flows);
    for (int step = 1; step <= 3; step++)
        if (!CHECK_OK(&c->ctx, press(c, pressure * step / 3.0))) return 1.0;
    for (int32_t i = 0; i < c->body.count; i++) {
        const double *x = c->position + i * PD_DIM;
        double r = sqrt(x[0] * x[0] + x[1] * x[1]), u = (x[0] * c->u[i * PD_DIM] + x[1] * c->u[i * PD_DIM + 1]) / r;
        double grows = k / YOUNG * elasticity_hill(r, flows, nu);
        if (fabs(r - 1.1) < nearest) nearest = fabs(r - 1.1), *slip = c->elastic.plastic.equivalent_strain[i];
        if (r < 1.8) continue;
        worst += c->volume[i] * fabs(u - grows);
        wanted += c->volume[i] * grows;
    }
    end(c);
    return worst / wanted;
}

TEST(tube_under_pressure)
{
    double slip = 0.0, wider = 0.0;
    double coarse = tube_error(0.125, 1.0, &slip), fine = tube_error(0.0625, 1.0, &slip);
    double wide = tube_error(0.0625, 2.0, &wider);
    NOTE("tube: u is off by %.2f %% with 8 cells, %.2f %% with 16, %.2f %% with m = 2; slip %.3g, %.3g",
         100.0 * coarse, 100.0 * fine, 100.0 * wide, slip, wider);
    CHECK_LE(fine, 0.45 * coarse);
    CHECK_LE(fine, 0.04);
    CHECK_LE(wide, 0.025);
    CHECK_REL(slip, wider, 0.15);
}
#endif

TEST(bad_input)
{
    body_case *c = cells(in_all, 0.0, 1.0, 0.125, 2.0, HARD);
    pd_correspondence_desc desc;
    if (!c) return;
    memset(&desc, 0, sizeof desc);
    pd_correspondence_free(&c->ctx, &c->elastic);
    for (int way = 0; way < 4; way++) {
        desc.young = YOUNG;
        desc.yield = way == 0 ? -1.0 : way == 1 ? NAN : YIELD;
        desc.hardening = way == 2 ? -HARD : 0.0;
        desc.plane = way == 3 ? PD_PLANE_STRESS : PD_PLANE_STRAIN;
        if (way == 3 && PD_DIM != 2) continue;
        CHECK_INT(pd_correspondence_build(&c->ctx, &c->body, &desc, &c->elastic), PD_ERR_ARGUMENT);
        CHECK(strncmp(c->ctx.message, "correspondence: ", 16) == 0);
    }
    end(c);
}

#if PD_DIM == 2
TEST_MAIN(ENTRY(to_and_fro) ENTRY(tangent) ENTRY(tube_under_pressure) ENTRY(bad_input))
#else
TEST_MAIN(ENTRY(to_and_fro) ENTRY(tangent) ENTRY(bad_input))
#endif
