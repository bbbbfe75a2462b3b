/* fourth_order: the flow operator of fourth order: orders against closed forms, exact channels, conservation,
 * derivative. dims: 2 3 */
#include "fixture.h"
#include "flow/inlet_flux.h"
#include "flow/weakly_compressible.h"

#define NU 0.01 /* [m2/s] */

static scene test_scene;

static double pi(void) { return acos(-1.0); }

/* The unit box of n cells an axis (3D: four cells along z) with fluid of unit density. */
static scene *box(int n, int order, pd_side side)
{
    scene *s = &test_scene;
    scene_box(s, 1.0, 1.0 / n, n, n, 4);
    for (int k = 0; k < 2 * PD_DIM; k++) s->grid_desc.side[k] = k < 4 ? side : PD_SIDE_PERIODIC;
    s->with = WITH_FLOW | WITH_STEADY;
    s->fields = 3;
    s->flow_desc.rho = 1.0;
    s->flow_desc.mu = NU;
    s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    s->flow_desc.order = order;
    return s;
}

/* Velocity, pressure and the residual of momentum in closed form at x. */
typedef void (*field_fn)(const double *x, double *u, double *p, double *ru);

/* Vortices that convect nothing but a gradient (Taylor 1923). */
static void vortices(const double *x, double *u, double *p, double *ru)
{
    double k = 2.0 * pi();
    memset(u, 0, PD_DIM * sizeof *u);
    memset(ru, 0, PD_DIM * sizeof *ru);
    u[0] = sin(k * x[0]) * cos(k * x[1]);
    u[1] = -cos(k * x[0]) * sin(k * x[1]);
    *p = 0.25 * (cos(2.0 * k * x[0]) + cos(2.0 * k * x[1]));
    for (int d = 0; d < 2; d++) ru[d] = 2.0 * NU * k * k * u[d];
}

/* Vortices twice as long as wide, for the divergence alone. */
static void oblong(const double *x, double *u, double *p, double *ru)
{
    double k = 2.0 * pi();
    vortices(x, u, p, ru);
    u[0] = 2.0 * sin(k * x[0]) * cos(2.0 * k * x[1]);
    u[1] = -cos(k * x[0]) * sin(2.0 * k * x[1]);
}

/* The stream function f(x) f(y)/pi with f = sin^2 is at rest on the walls of the unit box. */
static void cell(const double *x, double *u, double *p, double *ru)
{
    double k = pi(), f[2], f1[2], f2[2], f3[2];
    memset(u, 0, PD_DIM * sizeof *u);
    memset(ru, 0, PD_DIM * sizeof *ru);
    for (int d = 0; d < 2; d++) {
        f[d] = sin(k * x[d]) * sin(k * x[d]);
        f1[d] = k * sin(2.0 * k * x[d]);
        f2[d] = 2.0 * k * k * cos(2.0 * k * x[d]);
        f3[d] = -4.0 * k * k * f1[d];
    }
    u[0] = f[0] * f1[1] / k;
    u[1] = -f1[0] * f[1] / k;
    *p = cos(k * x[0]) * cos(k * x[1]);
    ru[0] = u[0] * f1[0] * f1[1] / k + u[1] * f[0] * f2[1] / k - k * sin(k * x[0]) * cos(k * x[1]) -
            NU * (f2[0] * f1[1] + f[0] * f3[1]) / k;
    ru[1] = -u[0] * f2[0] * f[1] / k - u[1] * f1[0] * f1[1] / k - k * cos(k * x[0]) * sin(k * x[1]) +
            NU * (f3[0] * f[1] + f1[0] * f2[1]) / k;
}

static void fill(scene *s, field_fn field, double *ru)
{
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM], u[PD_DIM], r[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        field(x, u, &s->flow.p[i], r);
        for (int d = 0; d < PD_DIM; d++) {
            s->flow.u[(int64_t)d * s->grid.total + i] = u[d];
            ru[(int64_t)d * s->grid.total + i] = r[d];
        }
    }
}

/* Largest errors of both residuals, of nodes at least `away` cells from the walls. */
static void errors(int n, int order, pd_side side, field_fn field, int away, double *momentum, double *continuity)
{
    scene *s = box(n, order, side);
    *momentum = *continuity = 0.0;
    if (scene_build(s)) {
        s->flow.stabilisation = 0.0;
        fill(s, field, s->field[0]);
        pdi_flow_assemble_residual(&s->ctx, &s->flow, s->field[1], s->field[2]);
        for (int32_t i = 0; i < s->grid.total; i++) {
            int at[PD_DIM];
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_index(&s->grid, i, at);
            if (at[0] < away || at[1] < away || at[0] >= n - away || at[1] >= n - away) continue;
            for (int d = 0; d < PD_DIM; d++) {
                int64_t k = (int64_t)d * s->grid.total + i;
                *momentum = fmax(*momentum, fabs(s->field[1][k] - s->field[0][k]));
            }
            *continuity = fmax(*continuity, fabs(s->field[2][i]));
        }
    }
    scene_free(s);
}

static void orders(int order, pd_side side, field_fn field, int away, double *momentum, double *continuity)
{
    double m[2], c[2];
    errors(24, order, side, field, away, &m[0], &c[0]);
    errors(48, order, side, field, away, &m[1], &c[1]);
    *momentum = log(m[0] / m[1]) / log(2.0);
    *continuity = log(c[0] / c[1]) / log(2.0);
    NOTE("order %d: momentum %.3g, %.3g (order %.2f), continuity %.3g, %.3g (order %.2f)", order, m[0], m[1], *momentum,
         c[0], c[1], *continuity);
}

/* Away from walls. The divergence of round vortices vanishes in any symmetric family. */
TEST(fourth_order)
{
    double momentum, continuity;
    orders(4, PD_SIDE_PERIODIC, vortices, 0, &momentum, &continuity);
    CHECK_LE(3.9, momentum);
    orders(2, PD_SIDE_PERIODIC, vortices, 0, &momentum, &continuity);
    CHECK_LE(momentum, 2.1);
    orders(4, PD_SIDE_WALL, cell, 3, &momentum, &continuity);
    CHECK_LE(3.8, momentum);
    orders(4, PD_SIDE_PERIODIC, oblong, 0, &momentum, &continuity);
    CHECK_LE(3.9, continuity);
    orders(2, PD_SIDE_PERIODIC, oblong, 0, &momentum, &continuity);
    CHECK_LE(continuity, 2.1);
}

/* At walls the cubic gives friction of second order, where (2.3) and (2.4) are off by the same share on any lattice.
 * The tensor (3.4) leaves an error of first order in the divergence, a tenth of that without sharpening. */
TEST(walls)
{
    double momentum, continuity, before, after;
    orders(4, PD_SIDE_WALL, cell, 0, &momentum, &continuity);
    CHECK_LE(1.9, momentum);
    CHECK_LE(0.9, continuity);
    errors(48, 2, PD_SIDE_WALL, cell, 0, &momentum, &before);
    errors(48, 4, PD_SIDE_WALL, cell, 0, &momentum, &after);
    CHECK_LE(after, 0.1 * before);
}

static int along; /* the axis of a channel */

static void parabola(void *user, const double *x, double *u)
{
    (void)user;
    memset(u, 0, PD_DIM * sizeof *u);
    u[along] = 4.0 * x[1 - along] * (1.0 - x[1 - along]);
}

static void channel(const double *x, double *u, double *p, double *ru)
{
    parabola(NULL, x, u);
    *p = 8.0 * NU * (1.0 - x[along]);
    memset(ru, 0, PD_DIM * sizeof *ru);
}

/* A channel from inlet to outlet along either axis: the parabola has no residual, at its ends neither. */
TEST(channels)
{
    for (along = 0; along < 2; along++) {
        scene *s = box(8, 4, PD_SIDE_WALL);
        double most = 0.0;
        s->grid_desc.side[2 * along] = PD_SIDE_INLET;
        s->grid_desc.side[2 * along + 1] = PD_SIDE_OUTLET;
        s->flow_desc.inlet = parabola;
        if (scene_build(s)) {
            double pushed, gross;
            fill(s, channel, s->field[0]);
            pdi_flow_assemble_residual(&s->ctx, &s->flow, s->field[1], s->field[2]);
            for (int32_t i = 0; i < s->grid.total; i++) {
                if (s->grid.kind[i] != PD_FLUID) continue;
                for (int d = 0; d < PD_DIM; d++) most = fmax(most, fabs(s->field[1][(int64_t)d * s->grid.total + i]));
                most = fmax(most, fabs(s->field[2][i]));
            }
            CHECK_LE(most, 1e-12);
            /* the exact flow of the parabola: 2/3 */
            double depth = PD_DIM == 3 ? 0.5 : 1.0;
            CHECK_NEAR(pdi_inlet_flux_integrate(&s->ctx, &s->flow, &pushed, &gross), 2.0 / 3.0 * depth, 1e-12);
            CHECK_NEAR(pd_flow_integrate_section(&s->ctx, &s->flow, along, 4), 2.0 / 3.0 * depth, 1e-12);
        }
        scene_free(s);
    }
}

static void noise(scene *s, double *v, uint64_t seed)
{
    uint64_t state = seed;
    for (int64_t k = 0; k < s->size; k++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        v[k] = s->grid.kind[k % s->grid.total] == PD_FLUID ? (double)(state >> 11) * 0x1p-53 - 0.5 : 0.0;
    }
}

/* The bonds carry what the continuity residual says, node by node, and nothing leaves a closed box. Momentum of a flow
 * whose fluxes balance stays in a periodic box. */
TEST(conservation)
{
    for (int walls = 0; walls < 2; walls++) {
        scene *s = box(12, 4, walls ? PD_SIDE_WALL : PD_SIDE_PERIODIC);
        double sum = 0.0, most = 0.0;
        if (scene_build(s)) {
            noise(s, s->flow.u, 7);
            s->flow.stabilisation = 0.0;
            pdi_flow_assemble_residual(&s->ctx, &s->flow, s->field[1], s->field[2]);
            for (int32_t i = 0; i < s->grid.total; i++) {
                double passed = 0.0;
                if (s->grid.kind[i] != PD_FLUID) continue;
                for (int k = 0; k < s->stencil.count; k++) {
                    int32_t r = s->bonds.row_of_node[i];
                    if (r < 0 || pdi_bond_is_open(&s->bonds, r, k))
                        passed += pdi_flow_compute_bond_flux(&s->flow, i, k);
                }
                most = fmax(most, fabs(passed - s->field[2][i]));
                sum += s->field[2][i];
            }
            CHECK_LE(most, 1e-11);
            CHECK_NEAR(sum, 0.0, 1e-9);
        }
        scene_free(s);
    }
}

/* A uniform stream through vortices balances: its momentum stays in a periodic box. */
static void stream(const double *x, double *u, double *p, double *ru)
{
    vortices(x, u, p, ru);
    u[0] += 0.3;
    u[1] -= 0.7;
}

TEST(momentum)
{
    scene *s = box(12, 4, PD_SIDE_PERIODIC);
    double sum[PD_DIM], gross = 0.0;
    memset(sum, 0, sizeof sum);
    if (scene_build(s)) {
        fill(s, stream, s->field[0]);
        pdi_flow_assemble_residual(&s->ctx, &s->flow, s->field[1], s->field[2]);
        for (int64_t k = 0; k < s->size; k++) {
            if (s->grid.kind[k % s->grid.total] != PD_FLUID) continue;
            sum[k / s->grid.total] += s->field[1][k];
            gross += fabs(s->field[1][k]);
        }
        for (int d = 0; d < PD_DIM; d++) CHECK_LE(fabs(sum[d]), 1e-12 * gross);
        CHECK_LE(1.0, gross);
    }
    scene_free(s);
}

/* The convection, the friction and the walls of fourth order are a quadratic form, so central differences are their
 * derivative to rounding. */
TEST(derivative)
{
    scene *s = box(8, 4, PD_SIDE_WALL);
    s->fields = 4;
    if (scene_build(s)) {
        pd_flow *flow = &s->flow;
        double *du = s->field[0], *found = s->field[1], *up = s->field[2], *advecting = s->field[3], most = 0.0;
        double largest = 0.0;
        noise(s, du, 3);
        noise(s, flow->u, 5);
        pd_ghosts_set_vector(&flow->bonds->ghosts, du); /* in 3D two sides are periodic */
        pdi_flow_update_derived_fields(&s->ctx, flow);
        pdi_fourth_order_compute_second_differences(&s->ctx, &flow->fourth_order, NULL, NULL, du,
                                                    flow->fourth_order.second_increment);
        pdi_flow_compute_advecting_velocity(&s->ctx, flow, du, flow->fourth_order.second_increment, advecting);
        pdi_flow_add_fourth_order(&s->ctx, flow, du, advecting, flow->pressure_grad, found);
        for (int k = 0; k < 2; k++) {
            for (int64_t i = 0; i < s->size; i++) flow->u[i] += (k ? -2.0 : 1.0) * du[i];
            memset(advecting, 0, (size_t)s->size * sizeof *advecting);
            pdi_flow_update_derived_fields(&s->ctx, flow);
            pdi_flow_add_fourth_order(&s->ctx, flow, flow->u, flow->advecting, flow->pressure_grad, advecting);
            for (int64_t i = 0; i < s->size; i++) up[i] += (k ? -0.5 : 0.5) * advecting[i];
        }
        for (int64_t i = 0; i < s->size; i++) most = fmax(most, fabs(up[i] - found[i]));
        for (int64_t i = 0; i < s->size; i++) largest = fmax(largest, fabs(found[i]));
        NOTE("off by %.3g of %.3g", most, largest);
        CHECK_LE(most, 1e-12 * largest);
    }
    scene_free(s);
}

/* Speed of the lid y = 1 [m/s]. */
static void lid(void *user, const double *x, double *u)
{
    memset(u, 0, PD_DIM * sizeof *u);
    if (x[1] > 1.0 - 1e-9) u[0] = *(const double *)user;
}

/* The order of a box with a lid; `body`: a cube stands in it. */
static int chosen(int n, pd_side side, double speed, int body)
{
    scene *s = box(n, PD_FLOW_ORDER_AUTO, side);
    s->flow_desc.wall = lid;
    s->flow_desc.wall_user = &speed;
    if (body) {
        s->shapes[0].type = PD_SHAPE_BOX;
        for (int d = 0; d < PD_DIM; d++) s->shapes[0].b[d] = 0.25;
        s->grid_desc.solid = &s->shapes[0];
    }
    int order = scene_build(s) ? s->flow.order : 0;
    CHECK((order == 4) == (s->flow.fourth_order.bonds != NULL));
    CHECK((order == 4) == (s->flow.isotropic_stencil.bonds == NULL));
    scene_free(s);
    return order;
}

/* Fourth order by itself: walls meet, no body, and the flow and its cells are slow (eq. 3.24). */
TEST(paying)
{
    CHECK(chosen(16, PD_SIDE_WALL, 0.01, 0) == 4);
    CHECK(chosen(16, PD_SIDE_WALL, 2.5, 0) == 4); /* a cell has the Reynolds number 15.6 */
    CHECK(chosen(16, PD_SIDE_WALL, 2.6, 0) == 2);
    CHECK(chosen(64, PD_SIDE_WALL, 10.0, 0) == 4); /* Re = 1000 */
    CHECK(chosen(64, PD_SIDE_WALL, 10.1, 0) == 2);
    CHECK(chosen(16, PD_SIDE_WALL, 0.01, 1) == 2);
    CHECK(chosen(16, PD_SIDE_PERIODIC, 0.01, 0) == 2);
    scene *s = box(8, PD_FLOW_ORDER_AUTO, PD_SIDE_WALL);
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    s->flow_desc.inlet = parabola;
    if (scene_build(s)) CHECK(s->flow.order == 2);
    scene_free(s);
    s = box(8, PD_FLOW_ORDER_AUTO, PD_SIDE_WALL);
    s->stencil_desc.m = 2.0;
    if (scene_build(s)) CHECK(s->flow.order == 2);
    scene_free(s);
}

TEST(refusals)
{
    pd_weakly_compressible_desc desc;
    pd_weakly_compressible un;
    scene *s = box(8, 4, PD_SIDE_PERIODIC);
    s->stencil_desc.m = 2.0;
    CHECK(scene_try(s) == PD_ERR_ARGUMENT && strstr(s->ctx.message, "m = 1") != NULL);
    scene_free(s);
    s = box(8, 3, PD_SIDE_PERIODIC);
    CHECK(scene_try(s) == PD_ERR_ARGUMENT && strstr(s->ctx.message, "order") != NULL);
    scene_free(s);
    s = box(8, 4, PD_SIDE_PERIODIC);
    memset(&desc, 0, sizeof desc);
    desc.sound_speed = 10.0;
    if (scene_build(s)) CHECK(pd_weakly_compressible_build(&s->ctx, &s->flow, &desc, &un) == PD_ERR_ARGUMENT);
    scene_free(s);
}

TEST_MAIN(ENTRY(fourth_order) ENTRY(walls) ENTRY(channels) ENTRY(conservation) ENTRY(momentum)
              ENTRY(derivative) ENTRY(paying) ENTRY(refusals))
