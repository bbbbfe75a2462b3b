/* Lattices with unequal spacings, up to 1000 to 1 along any axis: flow between plates, gradients beside walls, work.
 * dims: 2 3 */
#include "lattice/op.h"
#include "fixture.h"
#include <float.h>
#include <stdlib.h>

#define NU 1e-6 /* [m2/s] */
#define MEAN 1e-3 /* [m/s] */

static scene test_scene;

static void profile(void *user, const double *x, double *u)
{
    const scene *s = (const scene *)user;
    double y = x[1] / s->width;
    for (int d = 1; d < PD_DIM; d++) u[d] = 0.0;
    u[0] = 6.0 * MEAN * y * (1.0 - y);
}

/* Plates across y; in 3D z repeats. n cells of the sizes h. */
static int plates_build(scene *s, const double *h, const int *n, double m)
{
    scene_reset(s);
    s->ctx.threads = 1;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = h[d];
        s->grid_desc.hi[d] = h[d] * n[d];
        if (d == 2) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
    }
    s->stencil_desc.m = m;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    s->width = s->grid_desc.hi[1];
    return scene_build(s);
}

static int flow_build(scene *s, double tolerance)
{
    s->flow_desc.rho = 1000.0;
    s->flow_desc.mu = NU * s->flow_desc.rho;
    s->flow_desc.report_speed = MEAN;
    s->flow_desc.report_length = s->width;
    s->flow_desc.inlet = profile;
    s->flow_desc.inlet_user = s;
    s->steady_desc.tolerance = tolerance;
    return CHECK_OK(&s->ctx, pd_flow_build(&s->ctx, &s->grid, &s->bonds, &s->flow_desc, &s->flow)) &&
           CHECK_OK(&s->ctx, pd_steady_build(&s->ctx, &s->flow, &s->steady_desc, &s->steady));
}

/* Largest error of the velocity over the mean speed, and of the pressure over its drop along the channel. */
static void errors(const scene *s, double *velocity, double *pressure)
{
    double slope = -12.0 * NU * MEAN / (s->width * s->width);
    *velocity = *pressure = 0.0;
    for (int32_t node = 0; node < s->grid.total; node++) {
        double x[PD_DIM], u[PD_DIM];
        if (s->grid.kind[node] != PD_FLUID) continue;
        pd_grid_position(&s->grid, node, x);
        profile((void *)(uintptr_t)s, x, u);
        for (int d = 0; d < PD_DIM; d++)
            *velocity = fmax(*velocity, fabs(s->flow.u[(int64_t)d * s->grid.total + node] - u[d]) / MEAN);
        *pressure = fmax(*pressure, fabs(s->flow.p[node] / (slope * s->grid.hi[0]) - x[0] / s->grid.hi[0] + 1.0));
    }
}

/* The exact discrete solution (theory: 3.9) from rest; what the run cost into *evaluations. */
static int channel(const double *h, const int *n, double m, int64_t *evaluations)
{
    scene *s = &test_scene;
    pd_steady_result result;
    double velocity, pressure, through = MEAN * n[1] * h[1] * (PD_DIM == 3 ? n[PD_DIM - 1] * h[PD_DIM - 1] : 1.0);
    /* of the same residual a long channel makes more; across long cells rounding leaves 4e-9 */
    double tolerance = h[0] > h[1] ? 2e-9 : 5e-9;
    if (!plates_build(s, h, n, m) || !flow_build(s, tolerance)) return 0;
    int good = CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &s->steady, &result));
    *evaluations = result.evaluations;
    errors(s, &velocity, &pressure);
    good = CHECK_LE(velocity, 1e-9) && CHECK_LE(pressure, 1e-8) && good;
    for (int index = 1; index < n[0]; index += n[0] - 2) /* the parabola in cells: 1 + 1/(2 n^2) of its flux */
        good = CHECK_REL(pd_flow_integrate_section(&s->ctx, &s->flow, 0, index) / through, 1.0 + 0.5 / (n[1] * n[1]),
                         1e-9) &&
               good;
    scene_free(s);
    return good;
}

/* One spacing after the other is `ratio` times the others: long cells along the stream, across it and beside it. */
TEST(channels)
{
    static const double ratios[] = {1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0};
    static const double sizes[] = {1.0, 2.0, 3.0, 4.0};
    int n[3] = {24, 20, 6};
    if (PD_DIM == 3) n[0] = 12, n[1] = 10;
    for (int k = 0; k < (PD_DIM == 3 ? 3 : 4); k++) {
        int64_t least = INT64_MAX, most = 0;
        for (int axis = 0; axis < PD_DIM; axis++)
            for (int r = axis ? 1 : 0; r < 7; r += PD_DIM == 3 ? 3 : 1) {
                double h[PD_DIM];
                int64_t evaluations = 0;
                for (int d = 0; d < PD_DIM; d++) h[d] = d == axis ? ratios[r] * 1e-6 : 1e-6;
                if (!channel(h, n, sizes[k], &evaluations))
                    NOTE("m = %g, axis %d, ratio %g", sizes[k], axis, ratios[r]);
                least = evaluations < least ? evaluations : least;
                most = evaluations > most ? evaluations : most;
            }
        NOTE("m = %g: %d to %d evaluations", sizes[k], (int)least, (int)most);
        CHECK_LE(most, 300);
    }
}

/* (2.9) is exact on linear fields beside walls, whatever the ratio: only where the open bonds do not span space is the
 * gradient across the wall closed. */
TEST(linear_fields_beside_walls)
{
    static const double ratios[] = {1.0, 10.0, 100.0, 1000.0};
    scene *s = &test_scene;
    int n[3] = {8, 7, 6};
    for (int axis = 0; axis < PD_DIM; axis++)
        for (int r = 0; r < 4; r++) {
            double h[PD_DIM], worst = 0.0;
            for (int d = 0; d < PD_DIM; d++) h[d] = d == axis ? ratios[r] * 1e-6 : 1e-6;
            if (!plates_build(s, h, n, 3.0)) return;
            double *f = (double *)calloc((size_t)s->grid.total * (PD_DIM + 1), sizeof *f), *g = f + s->grid.total;
            for (int along = 0; along < 2; along++) {
                for (int32_t i = 0; i < s->grid.total; i++) {
                    double x[PD_DIM];
                    pd_grid_position(&s->grid, i, x);
                    f[i] = x[along] / h[along];
                }
                pd_op_gradient(&s->ctx, &s->bonds, f, g);
                for (int32_t i = 0; i < s->grid.total; i++)
                    for (int d = 0; d < PD_DIM && s->grid.kind[i] == PD_FLUID; d++) {
                        int at[PD_DIM];
                        pd_grid_index(&s->grid, i, at);
                        if (at[0] >= n[0] - 3) continue; /* outlet ghosts are odd */
                        worst = fmax(worst, fabs(g[(int64_t)d * s->grid.total + i] * h[d] - (d == along)));
                    }
            }
            if (!CHECK_LE(worst, 1e-11)) NOTE("axis %d, ratio %g", axis, ratios[r]);
            free(f);
            scene_free(s);
        }
}

static int short_channel(scene *s, double tolerance, pd_time_loop *couple)
{
    double h[3] = {1e-6, 1e-6, 1e-6};
    int n[3] = {8, 7, 6};
    pd_time_loop_desc cd;
    memset(&cd, 0, sizeof cd);
    return plates_build(s, h, n, 2.0) && flow_build(s, tolerance) &&
           CHECK_OK(&s->ctx, pd_time_loop_build(&s->ctx, &cd, &s->grid, &s->bonds, couple)) &&
           CHECK_OK(&s->ctx, pd_time_loop_add_process(&s->ctx, couple,
                                                      pd_quasi_steady_process(&s->flow, &s->steady, &s->quasi)));
}

/* A lattice that lets in 1e-5 less than the inlet brings has a solution with small residuals, and is no result. */
TEST(closed_inlet)
{
    scene *s = &test_scene;
    pd_time_loop couple;
    for (int closed = 0; closed < 2; closed++) {
        if (!short_channel(s, 1e-6, &couple)) return;
        for (int32_t k = 0; k < s->flow.inlet_ghosts && closed; k++) s->flow.inlet_speed_ratio[k] = 1.0 - 1e-5;
        CHECK_INT(pd_time_loop_start(&s->ctx, &couple), closed ? PD_ERR_GEOMETRY : PD_OK);
        if (closed) CHECK(strstr(s->ctx.message, "passes the inlets at") != NULL);
        scene_free(s);
    }
}

/* Nor are sections that disagree. */
TEST(sections_that_disagree)
{
    scene *s = &test_scene;
    pd_time_loop couple;
    if (!short_channel(s, 1e-3, &couple)) return;
    CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &couple));
    double first = pd_flow_integrate_section(&s->ctx, &s->flow, 0, 1);
    for (int index = 2; index < s->grid.n[0]; index++)
        CHECK_LE(fabs(pd_flow_integrate_section(&s->ctx, &s->flow, 0, index) - first), /* sums are rounded */
                 s->steady.section_difference + DBL_EPSILON * first);
    CHECK_LE(s->steady.section_difference, 1e-6 * first);
    scene_free(s);
}

TEST_MAIN(ENTRY(channels) ENTRY(linear_fields_beside_walls) ENTRY(closed_inlet) ENTRY(sections_that_disagree))
