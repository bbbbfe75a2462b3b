/* flow: exact discrete solutions, conservation through sections, linearisation, faults.
 * dims: 2 3 */
#include "flow/jacobian.h"
#include "fault.h"
#include "fixture.h"
#include "lattice/surface.h"
#include <stdlib.h>

#define RHO 1000.0
#define MU 1e-3
#define U 0.236
#define H 10e-6

static scene test_scene;
static double *ru, *rc; /* residuals, one block: of momentum, of continuity */

/* Parabola between planes y = centre -+ half. */
typedef struct channel {
    double centre, half; /* [m] */
} channel;

static void parabola(void *user, const double *x, double *u)
{
    const channel *c = (const channel *)user;
    double y = (x[1] - c->centre) / c->half;
    for (int d = 0; d < PD_DIM; d++) u[d] = 0.0;
    u[0] = 1.5 * U * (1.0 - y * y);
}

/* A box from the origin of x * y (* z) cells, all sides walls, spacing H. */
static void scene_start(scene *s, int x, int y, int z)
{
    scene_box(s, 0.0, H, x, y, z);
    s->with = WITH_FLOW;
    s->flow_desc.rho = RHO;
    s->flow_desc.mu = MU;
    s->flow_desc.report_speed = U;
    s->flow_desc.report_length = y * H;
}

static int flow_build(scene *s, double m)
{
    if (!scene_build_m(s, m)) return 0;
    ru = (double *)calloc((size_t)(PD_DIM + 1) * (size_t)s->grid.total, sizeof(double));
    rc = ru + (int64_t)PD_DIM * s->grid.total;
    return CHECK(ru != NULL);
}

static void flow_free(scene *s)
{
    free(ru);
    ru = rc = NULL;
    scene_free(s);
}

/* Inlet at x-, outlet at x+, a ball (disc) in between. */
static int build_ball(scene *s, double m, channel *c)
{
    if (PD_DIM == 2) scene_start(s, 40, 24, 1);
    else scene_start(s, 20, 13, 12);
    c->half = 0.5 * s->grid_desc.hi[1];
    c->centre = c->half;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 3.3 * H;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = 0.47 * s->grid_desc.hi[d];
    s->grid_desc.solid = &s->shapes[0];
    s->flow_desc.inlet = parabola;
    s->flow_desc.inlet_user = c;
    s->flow_desc.p_out = 3.0;
    return flow_build(s, m);
}

/* Any state: random velocity of magnitude U and pressure of magnitude U^2. */
static void fill_random(scene *s, uint32_t seed)
{
    for (int32_t node = 0; node < s->grid.total; node++) {
        if (s->grid.kind[node] != PD_FLUID) continue;
        for (int d = 0; d < PD_DIM; d++) s->flow.u[(int64_t)d * s->grid.total + node] = U * random_real(&seed);
        s->flow.p[node] = U * U * random_real(&seed);
    }
}

/* Largest residuals in units of U^2/L and U/L. */
static void scaled_residuals(scene *s, double *momentum, double *continuity)
{
    double length = s->flow_desc.report_length;
    int64_t split = (int64_t)PD_DIM * s->grid.total;
    pdi_flow_assemble_residual(&s->ctx, &s->flow, ru, rc);
    *momentum = *continuity = 0.0;
    for (int64_t k = 0; k < split; k++) *momentum = fmax(*momentum, fabs(ru[k]) * length / (U * U));
    for (int32_t k = 0; k < s->grid.total; k++) *continuity = fmax(*continuity, fabs(rc[k]) * length / U);
}

/* ---- exact solutions ---- */

/* Fluid at rest under a body force in a closed vessel around a ball: p = f.x, no residual at any node. */
TEST(hydrostatics)
{
    scene *s = &test_scene;
    double momentum, continuity;
    scene_start(s, PD_DIM == 2 ? 30 : 14, 13, 12);
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 3.3 * H;
    for (int d = 0; d < PD_DIM; d++) {
        s->shapes[0].a[d] = 0.47 * s->grid_desc.hi[d];
        s->flow_desc.force[d] = (d + 1.0) * U * U / s->flow_desc.report_length;
    }
    s->grid_desc.solid = &s->shapes[0];
    if (!flow_build(s, 3.0)) return;
    for (int32_t node = 0; node < s->grid.total; node++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, node, x);
        for (int d = 0; d < PD_DIM && s->grid.kind[node] == PD_FLUID; d++)
            s->flow.p[node] += s->flow_desc.force[d] * x[d];
    }
    scaled_residuals(s, &momentum, &continuity);
    CHECK_LE(momentum, 1e-12);
    CHECK_LE(continuity, 1e-12);
    flow_free(s);
}

#if PD_DIM == 2
/* Residual of the exact parabola and its linear pressure, and node fluxes of the middle layers. */
static void check_poiseuille(scene *s, const channel *c)
{
    double momentum, continuity, drop = 3.0 * MU / RHO * U / (c->half * c->half);
    for (int32_t node = 0; node < s->grid.total; node++) {
        double x[2], u[2];
        if (s->grid.kind[node] != PD_FLUID) continue;
        pd_grid_position(&s->grid, node, x);
        parabola((void *)(uintptr_t)c, x, u);
        s->flow.u[node] = u[0];
        s->flow.p[node] = s->flow.p_out + drop * (s->grid.hi[0] - x[0]);
    }
    scaled_residuals(s, &momentum, &continuity);
    CHECK_LE(momentum, 1e-12);
    CHECK_LE(continuity, 1e-12);
    double reference = pd_flow_integrate_section(&s->ctx, &s->flow, 0, s->grid.n[0] / 2);
    CHECK(reference > 0.0);
    for (int index = 1; index < s->grid.n[0]; index++)
        CHECK_REL(pd_flow_integrate_section(&s->ctx, &s->flow, 0, index), reference, 1e-12);
}

/* The channel is the box: any number of cells across, down to one. */
TEST(poiseuille_between_sides)
{
    scene *s = &test_scene;
    static const int across[] = {1, 2, 3, 4, 7, 20, 60};
    for (int m = 2; m <= 4; m++)
        for (int k = 0; k < 7; k++) {
            channel c;
            scene_start(s, 16, across[k], 1);
            c.half = 0.5 * across[k] * H;
            c.centre = c.half;
            s->grid_desc.side[0] = PD_SIDE_INLET;
            s->grid_desc.side[1] = PD_SIDE_OUTLET;
            s->flow_desc.inlet = parabola;
            s->flow_desc.inlet_user = &c;
            s->flow_desc.p_out = 2.0;
            if (!flow_build(s, m)) return;
            check_poiseuille(s, &c);
            /* the midpoint sum of the parabola: 2 U half (1 + 1/(2 n^2)) */
            double flux = 2.0 * U * c.half * (1.0 + 0.5 / (across[k] * across[k]));
            CHECK_REL(pdi_flow_integrate_nodal_section(&s->flow, 0, 5), flux, 1e-12);
            flow_free(s);
        }
}

/* Walls given by shapes, off the centre of the box and off the faces of the cells. */
TEST(poiseuille_between_planes)
{
    scene *s = &test_scene;
    static const double low[] = {3.0, 2.8, 4.45, 5.13, 6.3}, high[] = {20.0, 17.31, 21.9, 8.02, 7.7};
    for (int m = 2; m <= 4; m++)
        for (int k = 0; k < 5; k++) {
            channel c;
            scene_start(s, 16, 24, 1);
            for (int side = 0; side < 2; side++) {
                s->shapes[side].type = PD_SHAPE_HALF_SPACE;
                s->shapes[side].a[1] = (side ? high[k] : low[k]) * H;
                s->shapes[side].b[1] = side ? -1.0 : 1.0;
                s->shapes[2].child[side] = side;
            }
            s->shapes[2].type = PD_SHAPE_UNION;
            s->shapes[2].child_count = 2;
            s->grid_desc.wall = &s->shapes[2];
            c.half = 0.5 * (high[k] - low[k]) * H;
            c.centre = 0.5 * (high[k] + low[k]) * H;
            s->grid_desc.side[0] = PD_SIDE_INLET;
            s->grid_desc.side[1] = PD_SIDE_OUTLET;
            s->flow_desc.inlet = parabola;
            s->flow_desc.inlet_user = &c;
            if (!flow_build(s, m)) return;
            check_poiseuille(s, &c);
            flow_free(s);
        }
}
#endif

/* ---- structure ---- */

/* Whatever the state, what two sections of a channel with a ball let through differs by the sum of the continuity
 * residuals in between: the sections count every flux of the scheme once. */
TEST(sections_balance)
{
    scene *s = &test_scene;
    channel c;
    double momentum, continuity;
    for (int m = 1; m <= 3; m++) {
        if (!build_ball(s, m, &c)) return;
        fill_random(s, 5);
        scaled_residuals(s, &momentum, &continuity);
        double start = pd_flow_integrate_section(&s->ctx, &s->flow, 0, 1),
               scale = U * pow(s->flow_desc.report_length, PD_DIM - 1);
        for (int index = 2; index < s->grid.n[0]; index++) {
            double gain = 0.0;
            for (int32_t node = 0; node < s->grid.total; node++) {
                int i[PD_DIM];
                pd_grid_index(&s->grid, node, i);
                if (s->grid.kind[node] != PD_FLUID || i[0] < 1 || i[0] >= index) continue;
                gain += rc[node] * s->stencil.volume;
            }
            CHECK_NEAR(pd_flow_integrate_section(&s->ctx, &s->flow, 0, index), start + gain, 1e-12 * scale);
        }
        flow_free(s);
    }
}

/* The operator is quadratic: a central difference of any size is its derivative to rounding, here that of single
 * precision. */
TEST(linearisation)
{
    scene *s = &test_scene;
    channel c;
    if (!build_ball(s, 3.0, &c)) return;
    int64_t total = s->grid.total, split = PD_DIM * total, size = split + total;
    double *work = (double *)calloc((size_t)(4 * size + 2 * split), sizeof *work);
    double *step = work, *state = work + size, *up = state + size, *product = up + size, *grad = product + size;
    double *mass = grad + split;
    if (!CHECK(work != NULL)) return;
    fill_random(s, 9);
    uint32_t seed = 21;
    for (int64_t k = 0; k < size; k++) {
        double value = random_real(&seed) * (k < split ? U : U * U);
        if (s->grid.kind[k % total] == PD_FLUID) step[k] = value;
        state[k] = k < split ? s->flow.u[k] : s->flow.p[k - split];
    }
    for (int sign = 1; sign >= -1; sign -= 2) {
        for (int64_t k = 0; k < size; k++) {
            double value = state[k] + 0.5 * sign * step[k];
            if (k < split) s->flow.u[k] = value;
            else s->flow.p[k - split] = value;
        }
        pdi_flow_assemble_residual(&s->ctx, &s->flow, ru, rc);
        if (sign > 0) memcpy(up, ru, (size_t)size * sizeof *up);
    }
    memcpy(s->flow.u, state, (size_t)split * sizeof *state);
    pd_jacobian linear;
    pdi_jacobian_increment along;
    pdi_flow_update_derived_fields(&s->ctx, &s->flow);
    if (!CHECK_OK(&s->ctx, pdi_jacobian_build(&s->ctx, &s->flow, &linear))) return;
    if (!CHECK_OK(&s->ctx, pdi_array_registry_build(&s->ctx, pdi_jacobian_list_work, &linear))) return;
    pdi_jacobian_set_state(&s->ctx, &linear);
    pd_ghosts_set_vector(&s->bonds.ghosts, step);
    pdi_ghosts_set_pressure(&s->bonds.ghosts, 0.0, step + split);
    pdi_flow_compute_pressure_gradient(&s->ctx, &s->flow, step + split, grad);
    pdi_flow_compute_advecting_velocity(&s->ctx, &s->flow, step, NULL, mass);
    along.advecting = mass;
    along.u = step;
    along.p = step + split;
    along.grad = grad;
    pdi_jacobian_apply(&s->ctx, &linear, &along, product, product + split);
    pdi_array_registry_free(&s->ctx, pdi_jacobian_list_work, &linear);
    pdi_jacobian_free(&s->ctx, &linear);
    double largest[2] = {0.0, 0.0};
    for (int64_t k = 0; k < size; k++) largest[k >= split] = fmax(largest[k >= split], fabs(product[k]));
    CHECK(largest[0] > 0.0 && largest[1] > 0.0);
    for (int64_t k = 0; k < size; k++) CHECK_NEAR(product[k], up[k] - ru[k], 1e-6 * largest[k >= split]);
    free(work);
    flow_free(s);
}

TEST(threads_change_no_bit)
{
    scene *s = &test_scene;
    channel c;
    if (!build_ball(s, 3.0, &c)) return;
    size_t bytes = (size_t)(PD_DIM + 1) * (size_t)s->grid.total * sizeof(double);
    double *first = (double *)malloc(bytes);
    if (!CHECK(first != NULL)) return;
    fill_random(s, 13);
    s->ctx.threads = 1;
    pdi_flow_assemble_residual(&s->ctx, &s->flow, ru, rc);
    memcpy(first, ru, bytes);
    for (int threads = 2; threads <= 4; threads *= 2) {
        s->ctx.threads = threads;
        pdi_flow_assemble_residual(&s->ctx, &s->flow, ru, rc);
        CHECK(memcmp(first, ru, bytes) == 0);
    }
    CHECK_INT(s->flow.evaluations, 3);
    free(first);
    flow_free(s);
}

/* ---- building and changing ---- */

/* What is known beforehand of surfaces depends on the shape alone: in lengths of another size it is the same, and so it
 * is in a box that begins below 0. */
TEST(surfaces_of_any_size)
{
    static double first[3][4096];
    static const double size[] = {1e-6, 1.0, 1.0};
    for (int m = 1; m <= 2; m++)
        for (int k = 0; k < 3; k++) {
            scene *s = &test_scene;
            double h = size[k], worst[3] = {0.0, 0.0, 0.0}, most[3] = {0.0, 0.0, 0.0};
            scene_box(s, m, h, 16, 16, 16);
            s->shapes[0].type = PD_SHAPE_BALL;
            for (int d = 0; d < PD_DIM; d++) {
                double shift = k == 2 ? -5.0 : 0.0;
                s->grid_desc.lo[d] += shift;
                s->grid_desc.hi[d] += shift;
                s->shapes[0].a[d] = 8.3 * h + shift;
            }
            s->shapes[0].radius = 4.2 * h;
            s->grid_desc.wall = s->shapes;
            s->with = WITH_FLOW;
            s->flow_desc.rho = s->flow_desc.mu = s->flow_desc.report_speed = 1.0;
            s->flow_desc.report_length = h;
            if (!scene_build(s)) return;
            if (!CHECK_OK(&s->ctx, pdi_flow_find_surface_patches(&s->ctx, &s->flow))) return;
            const pd_quadratic_reconstruction *of = &s->flow.wall_fit;
            int terms = PD_DIM * (PD_DIM + 3) / 2,
                misses = of->wide_capacity ? 0 : PD_DIM * PDI_RECONSTRUCT_HESSIAN_SIZE;
            CHECK(of->count > 10);
            const double *list[3] = {of->wall_friction, of->wall_coefficients, of->viscous_error},
                         unit[3] = {h * h, 1.0, 1.0 / h};
            int64_t length[3] = {of->count, (int64_t)of->count * terms, (int64_t)of->count * misses};
            for (int n = 0; n < 3; n++)
                for (int64_t i = 0; i < length[n] && i < 4096; i++) {
                    double value = list[n][i] * unit[n];
                    if (k == 0) first[n][i] = value;
                    worst[n] = fmax(worst[n], fabs(value - first[n][i]));
                    most[n] = fmax(most[n], fabs(value));
                }
            for (int n = 0; n < 3; n++) CHECK_LE(worst[n], 1e-9 * most[n]);
            CHECK(most[0] > 0.0 && most[1] > 0.0 && (m > 1 || most[2] > 0.0));
            scene_free(s);
        }
}

/* The straight way from a node, and one cell on, meets a side of the box, wherever that begins, or it does not. */
TEST(sides_as_surfaces)
{
    for (int below = 0; below < 2; below++)
        for (int side = 0; side < 2 * PD_DIM; side++) {
            scene *s = &test_scene;
            double x[PD_DIM], to[PD_DIM], place[PD_DIM], normal[PD_DIM], sign = side % 2 ? 1.0 : -1.0;
            int at[3] = {3, 3, 3}, d = side / 2, e = (d + 1) % PD_DIM;
            int32_t closed;
            scene_box(s, 1.0, 0.5, 8, 8, 8);
            for (int a = 0; a < PD_DIM && below; a++) {
                s->grid_desc.lo[a] -= 2.5;
                s->grid_desc.hi[a] -= 2.5;
            }
            if (!scene_build(s)) return;
            at[d] = side % 2 ? 6 : 1; /* three quarters of a length unit from it */
            int32_t node = pd_grid_node(&s->grid, at);
            pd_grid_position(&s->grid, node, x);
            memcpy(to, x, sizeof to);
            to[d] += sign * 0.6;
            to[e] += 0.2;
            if (CHECK_INT(pdi_surface_find_nearest(&s->bonds, node, to, place, normal, &closed), 1))
                for (int a = 0; a < PD_DIM; a++) {
                    double wanted = a == d ? x[d] + sign * 0.75 : a == e ? x[e] + 0.25 : x[a];
                    CHECK_NEAR(place[a], wanted, 1e-12);
                    CHECK_NEAR(normal[a], a == d ? -sign : 0.0, 0.0);
                }
            to[d] = x[d] + sign * 0.8; /* beyond it */
            CHECK_INT(pdi_surface_find_nearest(&s->bonds, node, to, place, normal, &closed), -1);
            to[d] = x[d] + sign * 0.2; /* a cell on is still before it */
            to[e] = x[e];
            CHECK_INT(pdi_surface_find_nearest(&s->bonds, node, to, place, normal, &closed), 0);
            scene_free(s);
        }
}

/* The surface of a point is the nearest one, along the axis where it is farther: a ball that is 0.24 or 0.56 from it,
 * or the side that the way from the node meets 0.5 and 0.1 behind it. */
TEST(nearest_of_surfaces)
{
    for (int side = 0; side < 2; side++) {
        scene *s = &test_scene;
        double x[PD_DIM], to[PD_DIM], place[PD_DIM], normal[PD_DIM], away = side ? 0.7 : 0.3;
        const double towards[3] = {0.6, -0.8, 0.0}; /* from the middle of the ball */
        int at[3] = {6, 4, 4};
        int32_t closed;
        scene_box(s, 1.0, 1.0, 8, 9, 9);
        for (int d = 0; d < PD_DIM; d++) {
            x[d] = at[d] + 0.5;
            to[d] = x[d] + (d == 0 ? 1.0 : d == 1 ? 0.2 : 0.0);
            s->shapes[0].a[d] = to[d] - (1.0 + away) * towards[d];
        }
        s->shapes[0].type = PD_SHAPE_BALL;
        s->shapes[0].radius = 1.0;
        s->grid_desc.solid = &s->shapes[0];
        if (!scene_build(s)) return;
        int32_t node = pd_grid_node(&s->grid, at);
        CHECK_INT(pdi_surface_find_nearest(&s->bonds, node, to, place, normal, &closed), 1);
        for (int d = 0; d < PD_DIM; d++) {
            double met = d == 0 ? 8.0 : d == 1 ? x[1] + 0.3 : x[d];
            CHECK_NEAR(place[d], side ? met : to[d] - away * towards[d], 1e-7);
            CHECK_NEAR(normal[d], side ? (d ? 0.0 : -1.0) : towards[d], 1e-5);
        }
        scene_free(s);
    }
}

static void not_finite(void *user, const double *x, double *u)
{
    parabola(user, x, u);
    u[PD_DIM - 1] = (double)NAN;
}

TEST(bad_input)
{
    scene *s = &test_scene;
    channel c;
    if (!build_ball(s, 2.0, &c)) return;
    for (int k = 0; k < 22; k++) {
        static const double wrong[3] = {(double)NAN, (double)INFINITY, -1.0};
        pd_flow_desc desc = s->flow_desc;
        pd_flow flow;
        double *value[6];
        value[0] = &desc.rho;
        value[1] = &desc.mu;
        value[2] = &desc.report_speed;
        value[3] = &desc.report_length;
        value[4] = &desc.p_out;
        value[5] = &desc.force[PD_DIM - 1];
        if (k < 12) *value[k / 3] = wrong[k % 3];
        else if (k < 16) *value[4 + (k - 12) / 2] = wrong[k % 2];
        else if (k == 16) desc.mu = -MU;
        else if (k == 17) desc.rho = desc.mu = (double)INFINITY;
        else if (k == 18) desc.rho = 1e-200;                                     /* mu/rho is no number of the solver */
        else if (k == 19) desc.rho = 1e-20, desc.mu = 1e-20, desc.p_out = 1e300; /* nor is p_out/rho */
        else if (k == 20) desc.order = 3;
        else desc.inlet = not_finite;
        CHECK_INT(pd_flow_build(&s->ctx, &s->grid, &s->bonds, &desc, &flow), PD_ERR_ARGUMENT);
        CHECK(strncmp(s->ctx.message, "flow: ", 6) == 0);
        pd_flow_free(&s->ctx, &flow);
    }
    pd_bonds still;
    pd_flow flow;
    CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, PD_BONDS_NO_FLOW, &still));
    CHECK_INT(pd_flow_build(&s->ctx, &s->grid, &still, &s->flow_desc, &flow), PD_ERR_ARGUMENT);
    CHECK(strstr(s->ctx.message, "PD_BONDS_NO_FLOW") != NULL);
    pd_bonds_free(&s->ctx, &still);
    flow_free(s);
}

/* A dissolved node starts at rest with the mean pressure of the fluid around it; ghosts follow. */
TEST(update_of_dissolved_nodes)
{
    scene *s = &test_scene;
    int32_t changed[4096], count = 0;
    uint32_t seed = 3;
    scene_start(s, 14, 11, 10);
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    s->shapes[0].type = PD_SHAPE_BOX; /* reaches the outlet */
    s->shapes[0].a[0] = 6.0 * H;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].b[d] = d ? 5.0 * H : s->grid_desc.hi[0];
    s->grid_desc.solid = &s->shapes[0];
    if (!flow_build(s, 2.0)) return;
    int32_t before = s->bonds.ghosts.outlets_end;
    fill_random(s, 7);
    for (int32_t node = 0; node < s->grid.total; node++) {
        if (s->grid.kind[node] != PD_SOLID || next_random(&seed) % 2) continue;
        changed[count++] = node;
    }
    for (int32_t k = 0; k < count; k++) pdi_grid_set_fluid(&s->grid, changed[k]);
    CHECK_OK(&s->ctx, pd_bonds_update(&s->ctx, changed, count, &s->bonds));
    CHECK_OK(&s->ctx, pd_flow_update(&s->ctx, changed, count, &s->flow));
    CHECK(count > 10 && s->bonds.ghosts.outlets_end > before);
    CHECK_INT(s->bonds.ghosts.outlets_end, pdi_grid_count_kind(&s->grid, PD_OUTLET));
    for (int32_t k = 0; k < count; k++) {
        for (int d = 0; d < PD_DIM; d++) CHECK_NEAR(s->flow.u[(int64_t)d * s->grid.total + changed[k]], 0.0, 0.0);
        CHECK(fabs(s->flow.p[changed[k]]) <= U * U);
    }
    pdi_flow_assemble_residual(&s->ctx, &s->flow, ru, rc);
    for (int64_t k = 0; k < (int64_t)(PD_DIM + 1) * s->grid.total; k++) CHECK(ru[k] - ru[k] == 0.0); /* finite */
    for (int32_t o = 0; o < s->bonds.ghosts.outlets_end; o++)
        CHECK_NEAR(s->flow.p[s->bonds.ghosts.node[o]], -s->flow.p[s->bonds.ghosts.source[o]], 1e-15);
    flow_free(s);
}

/* Metal that dissolves at once takes the pressure of the fluid beside it, layer by layer, and none of what metal held;
 * the order of the nodes changes no bit. */
TEST(update_in_any_order)
{
    scene *s = &test_scene;
    int32_t changed[4096], count = 0;
    double *kept = NULL;
    for (int order = 0; order < 3; order++) {
        scene_start(s, 14, 11, 10);
        s->grid_desc.side[0] = PD_SIDE_INLET;
        s->grid_desc.side[1] = PD_SIDE_OUTLET;
        s->shapes[0].type = PD_SHAPE_BOX;
        for (int d = 0; d < PD_DIM; d++) {
            s->shapes[0].a[d] = 3.0 * H;
            s->shapes[0].b[d] = 7.0 * H;
        }
        s->grid_desc.solid = &s->shapes[0];
        if (!flow_build(s, 2.0)) return;
        count = 0;
        for (int32_t node = 0; node < s->grid.total; node++) {
            double x[PD_DIM];
            pd_grid_position(&s->grid, node, x);
            if (s->grid.kind[node] == PD_FLUID) s->flow.p[node] = 5.0 + x[0] / H;
            if (s->grid.kind[node] == PD_SOLID) changed[count++] = node;
        }
        for (int32_t k = 0; k < count && order; k++) { /* backwards, and as cards are mixed */
            int32_t other = order == 1 ? count - 1 - k : (k * 7 + 3) % count, keep = changed[k];
            if (order == 1 && other <= k) break;
            changed[k] = changed[other];
            changed[other] = keep;
        }
        for (int32_t k = 0; k < count; k++) pdi_grid_set_fluid(&s->grid, changed[k]);
        CHECK_OK(&s->ctx, pd_bonds_update(&s->ctx, changed, count, &s->bonds));
        CHECK_OK(&s->ctx, pd_flow_update(&s->ctx, changed, count, &s->flow));
        if (!kept) kept = (double *)calloc((size_t)s->grid.total, sizeof *kept);
        if (!CHECK(kept != NULL)) return;
        for (int32_t k = 0; k < count; k++) {
            double p = s->flow.p[changed[k]];
            CHECK(p >= 5.0 && p <= 5.0 + 14.0);
            if (!order) kept[changed[k]] = p;
            CHECK_NEAR(p, kept[changed[k]], 0.0);
        }
        flow_free(s);
    }
    CHECK(count >= 4);
    free(kept);
}

TEST(memory_faults)
{
    scene *s = &test_scene;
    pd_status status = PD_ERR_MEMORY;
    int tried = 0;
    while (status < 0 && tried < 200) {
        channel c;
        fault f;
        scene_start(s, 10, 6, 5);
        c.half = 3.0 * H;
        c.centre = c.half;
        s->grid_desc.side[0] = PD_SIDE_INLET;
        s->grid_desc.side[1] = PD_SIDE_OUTLET;
        s->flow_desc.inlet = parabola;
        s->flow_desc.inlet_user = &c;
        fault_context(&f, ++tried, 0, &s->ctx);
        s->stencil_desc.m = 2.0;
        status = scene_try(s);
        if (status < 0) CHECK_INT(status, PD_ERR_MEMORY);
        flow_free(s);
        CHECK_INT(f.live, 0);
        CHECK_INT(f.wrong, 0);
    }
    CHECK_INT(status, PD_OK);
    CHECK(tried > 20);
}

#if PD_DIM == 2
#define OF_DIM ENTRY(poiseuille_between_sides) ENTRY(poiseuille_between_planes)
#else
#define OF_DIM
#endif

TEST_MAIN(ENTRY(hydrostatics) OF_DIM ENTRY(sections_balance) ENTRY(linearisation) ENTRY(threads_change_no_bit)
              ENTRY(surfaces_of_any_size) ENTRY(sides_as_surfaces) ENTRY(nearest_of_surfaces) ENTRY(bad_input)
                  ENTRY(update_of_dissolved_nodes) ENTRY(update_in_any_order) ENTRY(memory_faults))
