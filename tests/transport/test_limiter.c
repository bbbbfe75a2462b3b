/* limiter: the order of limited fluxes, of implicit and of explicit steps; gradients beside walls, derivatives.
 * dims: 1 2 3 */
#include "fixture.h"
#include "transport/explicit.h"

static scene test_scene;

/* A uniform stream u that carries exp(k.x) through a box. */
static int stream_build(scene *s, int cells, double m, const double *k, const double *u)
{
    double h = 1.0 / cells;
    scene_box(s, m, h, cells, cells, cells);
    s->with = WITH_TRANSPORT | WITH_FLOW;
    s->flow_desc.rho = s->flow_desc.mu = s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    if (!scene_build(s)) return 0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM], sum = 0.0;
        pd_grid_position(&s->grid, i, x);
        for (int d = 0; d < PD_DIM; d++) {
            sum += k[d] * x[d];
            s->flow.u[(int64_t)d * s->grid.total + i] = u[d];
        }
        s->transport.c[i] = exp(sum);
    }
    pdi_flow_update_derived_fields(&s->ctx, &s->flow);
    return 1;
}

/* What advection takes from the nodes around the middle of a box, over what it takes from exp(k.x): the largest
 * difference. No node there has a family that is cut, nor do its neighbours. */
static double stream_error(int cells, double m, const double *u)
{
    static const double k[3] = {1.0, -0.7, 0.4};
    double worst = 0.0;
    scene *s = &test_scene;
    pd_transport *t = &s->transport;
    if (!stream_build(s, cells, m, k, u)) return HUGE_VAL;
    CHECK_OK(&s->ctx, pdi_transport_hold(&s->ctx, t));
    CHECK_OK(&s->ctx, pdi_flux_refresh(&s->ctx, &t->flux));
    t->dt = 0.0;
    pdi_transport_operator(&s->ctx, t, t->c, t->rhs);
    pdi_transport_anti(&s->ctx, t, t->c, t->anti);
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM], want = 0.0;
        int middle = 1;
        pd_grid_position(&s->grid, i, x);
        for (int d = 0; d < PD_DIM; d++) {
            middle = middle && fabs(x[d] - 0.5) < 0.1;
            want += u[d] * k[d] * t->c[i];
        }
        if (middle) worst = fmax(worst, fabs((t->rhs[i] - t->anti[i]) / want - 1.0));
    }
    CHECK_OK(&s->ctx, pdi_transport_release(&s->ctx, t, PD_OK));
    scene_free(s);
    return worst;
}

/* A uniform stream along an axis and across the lattice, for families of neighbours and wide ones. */
TEST(third_order_in_a_uniform_stream)
{
    static const double streams[3][3] = {{1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}, {1.0, 0.37, -0.61}};
    for (int n = 0; n < 3; n++)
        for (int m = 1; m <= 3; m += 2) {
            int cells = PD_DIM == 3 ? 16 : 32;
            double coarse = stream_error(cells, m, streams[n]), fine = stream_error(2 * cells, m, streams[n]);
            double order = log(coarse / fine) / log(2.0);
            NOTE("stream %d, m = %d: error %.3g, half the spacing %.3g, order %.2f", n, m, coarse, fine, order);
            CHECK_LE(2.8, order);
            CHECK_LE(fine, pow(0.5 * m / cells, 3.0)); /* the third power of the horizon */
        }
}

/* The same of an explicit step with the nodes next to a node. */
static double explicit_error(int cells, const double *u)
{
    static const double k[3] = {1.0, -0.7, 0.4};
    double worst = 0.0, rate = 0.0;
    scene *s = &test_scene;
    pd_transport *t = &s->transport;
    if (!stream_build(s, cells, 1.0, k, u)) return HUGE_VAL;
    for (int d = 0; d < PD_DIM; d++) rate += u[d] * k[d];
    double dt = pd_transport_limit(&s->ctx, t);
    CHECK_OK(&s->ctx, pd_transport_explicit(&s->ctx, t, dt));
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM], sum = 0.0;
        int middle = 1;
        pd_grid_position(&s->grid, i, x);
        for (int d = 0; d < PD_DIM; d++) {
            middle = middle && fabs(x[d] - 0.5) < 0.1;
            sum += k[d] * x[d];
        }
        if (middle) worst = fmax(worst, fabs((exp(sum) - t->c[i]) / (dt * rate * exp(sum)) - 1.0));
    }
    scene_free(s);
    return worst;
}

/* The next term is D^7 c/140 with D along each bond: 9.25e-9 in 2D with 12 cells and a stream along x. */
TEST(sixth_order_in_explicit_steps)
{
    static const double streams[3][3] = {{1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}, {1.0, 0.37, -0.61}};
    for (int n = 0; n < 3; n++) {
        double coarse = explicit_error(12, streams[n]), fine = explicit_error(24, streams[n]);
        double order = log(coarse / fine) / log(2.0);
        NOTE("stream %d: error %.3g, half the spacing %.3g, order %.2f", n, coarse, fine, order);
        CHECK_LE(5.7, order);
        CHECK_LE(fine, pow(1.0 / 24.0, 6.0));
    }
}

/* A field around a ball, with the arrays of a step; 0: not built. */
static int ball_build(scene *s, double m, double (*field)(const double *x))
{
    int cells = PD_DIM == 3 ? 12 : 24;
    scene_box(s, m, 1.0 / cells, cells, cells, cells);
    s->shapes[0].type = PD_SHAPE_BALL;
    for (int d = 0; d < PD_DIM; d++) { /* a box that begins below 0 */
        s->grid_desc.lo[d] -= 0.25;
        s->grid_desc.hi[d] -= 0.25;
        s->shapes[0].a[d] = 0.25 + 0.3 / cells;
    }
    s->shapes[0].radius = 0.2;
    s->grid_desc.solid = s->shapes;
    s->with = WITH_TRANSPORT | WITH_FLOW;
    s->flow_desc.rho = s->flow_desc.mu = s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    if (!scene_build(s)) return 0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        s->transport.c[i] = field(x);
    }
    pdi_flow_update_derived_fields(&s->ctx, &s->flow);
    return CHECK_OK(&s->ctx, pdi_transport_hold(&s->ctx, &s->transport)) &&
           CHECK_OK(&s->ctx, pdi_flux_refresh(&s->ctx, &s->transport.flux));
}

static double linear(const double *x)
{
    double sum = 2.0;
    for (int d = 0; d < PD_DIM; d++) sum += (1.0 - 0.7 * d) * x[d];
    return sum;
}

/* The gradient of a linear field is exact where families are cut by walls and sides, too (eq. 2.9). */
TEST(gradient_beside_walls)
{
    for (int m = 1; m <= 3; m++) {
        scene *s = &test_scene;
        const pd_limiter *l = &s->transport.limiter;
        double worst = 0.0;
        int cut = 0;
        if (!ball_build(s, m, linear)) return;
        pdi_limiter_update(&s->ctx, &s->transport.limiter, s->transport.c, 0.0);
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            double off = 0.0;
            for (int d = 0; d < PD_DIM; d++)
                off = fmax(off, fabs(l->slope[d * (int64_t)s->grid.total + i] - (1.0 - 0.7 * d)));
            worst = fmax(worst, off);
            cut += pdi_limiter_cut(l, i);
        }
        CHECK_LE(worst, 1e-12);
        CHECK(cut > 0);
        CHECK_OK(&s->ctx, pdi_transport_release(&s->ctx, &s->transport, PD_OK));
        scene_free(s);
    }
}

static double wave(const double *x)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += sin(5.0 * x[d] + 1.3 * d);
    return sum;
}

/* Derivatives of factor and gradient against differences. */
TEST(derivatives)
{
    for (int m = 1; m <= 3; m++) {
        scene *s = &test_scene;
        pd_limiter *l = &s->transport.limiter;
        uint32_t random = 5;
        double stride = 1e-6, worst[2] = {0.0, 0.0};
        if (!ball_build(s, m, wave)) return;
        int64_t total = s->grid.total;
        double *x = (double *)calloc((size_t)(total * (4 + 3 * PD_DIM)), sizeof *x);
        double *factor_by = x + total, *slope_by = x + 2 * total, *up = slope_by + PD_DIM * total;
        if (!CHECK(x != NULL)) return;
        for (int32_t i = 0; i < total; i++) x[i] = random_share(&random) - 0.5;
        pdi_limiter_derive(&s->ctx, l, s->transport.c, x, 0.0, factor_by, slope_by);
        for (int way = 1; way >= -1; way -= 2) {
            for (int32_t i = 0; i < total; i++) s->transport.c[i] += way * stride * x[i];
            pdi_limiter_update(&s->ctx, l, s->transport.c, 0.0);
            for (int32_t i = 0; i < total; i++) s->transport.c[i] -= way * stride * x[i];
            for (int32_t i = 0; i < total; i++) up[i] += way * l->factor[i] / (2.0 * stride);
            for (int64_t i = 0; i < PD_DIM * total; i++) up[total + i] += way * l->slope[i] / (2.0 * stride);
        }
        for (int32_t i = 0; i < total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            worst[0] = fmax(worst[0], fabs(factor_by[i] - up[i]));
            for (int d = 0; d < PD_DIM; d++)
                worst[1] = fmax(worst[1], fabs(slope_by[d * total + i] - up[(1 + d) * total + i]));
        }
        CHECK_LE(worst[0], 1e-6);
        CHECK_LE(worst[1], 1e-6);
        free(x);
        CHECK_OK(&s->ctx, pdi_transport_release(&s->ctx, &s->transport, PD_OK));
        scene_free(s);
    }
}

TEST_MAIN(ENTRY(gradient_beside_walls) ENTRY(derivatives) ENTRY(third_order_in_a_uniform_stream)
          ENTRY(sixth_order_in_explicit_steps))
