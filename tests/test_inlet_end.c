/* test_inlet_end: where an inlet ends and an outlet goes on along the same side, against roots and a disc in closed form.
 * dims: 2 3 */
#include "transport/amount.h"
#include "transport/settle.h"
#include "fixture.h"
#include <math.h>
#include <string.h>

static scene test_scene;

/* ---- a root ---- */

static double root_end; /* where the inlet ends */

/* r^(1/2) cos(phi/2): zero on the half-plane before the end at y = 0, no flux through the other half. */
static double root(const double *x)
{
    double along = x[0] - root_end;
    return sqrt(0.5 * (sqrt(along * along + x[1] * x[1]) + along));
}

static double root_held(void *user, const double *x)
{
    (void)user;
    return root(x);
}

static int root_enters(void *user, int side, const double *x)
{
    (void)user, (void)side;
    return x[0] < root_end;
}

/* -1 < x < 1, 0 < y < 1 with n cells of length 1/n and `rows` of height 1/rows; fluid at rest, the inlet holds 0. */
static scene *root_start(double m, int n, int rows)
{
    scene *s = &test_scene;
    scene_box(s, m, 1.0 / n, n, rows, 3);
    s->stencil_desc.h[1] = 1.0 / rows;
    s->grid_desc.hi[1] = 1.0;
    s->grid_desc.lo[0] = -1.0;
    s->grid_desc.side[2] = PD_SIDE_INLET;
    s->grid_desc.entry = root_enters;
    for (int d = 2; d < PD_DIM; d++) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_MIRROR;
    s->with = WITH_TRANSPORT;
    s->transport_desc.diffusivity = 1.0;
    s->transport_desc.tolerance = 1e-12;
    s->transport_desc.held = root_held;
    return s;
}

/* Largest error at least 0.4 away from the end, and its mean over that of an inlet which ends a cell early, in cells. */
static double root_error(double m, int n, int rows, double *early)
{
    scene *s = root_start(m, n, rows);
    double largest = 0.0, sum = 0.0, over = 0.0;
    if (!scene_build(s) || !CHECK_OK(&s->ctx, pd_transport_steady(&s->ctx, &s->transport, &s->result))) return -1.0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        double r = sqrt(x[0] * x[0] + x[1] * x[1]), error = s->transport.c[i] - root(x);
        if (r < 0.4) continue;
        largest = fmax(largest, fabs(error));
        if (r > 0.6) continue;
        sum += error;
        over += 0.5 * root(x) / r * (1.0 - r) / n; /* r^(-1/2) cos(phi/2)/2, which the sides take off again */
    }
    *early = sum / over;
    scene_free(s);
    return largest;
}

TEST(root_beside_the_end)
{
    static const double ratios[3] = {1.0, 2.0, 0.5};
    for (int k = 0; k < (PD_DIM == 2 ? 3 : 1); k++)
        for (int n = 10; n <= (PD_DIM == 2 ? 40 : 20); n *= 2)
        for (int f=-2;f<=2;f++){
            double early = 0.0;
            root_end = f*0.249/n;
            double error = root_error(1.0, n, (int)(n / ratios[k]), &early);
            NOTE("hy/hx %g, n %d f %g: error %.3e, early %.4f cells", ratios[k], n, root_end*n, error, early);
        }
    root_end = 0.0;
}

/* ---- a disc ---- */

/* c of a disc of radius 1 that holds 1 in a plane without flux, r and z off its axis and plane. */
static double disc(double r, double z)
{
    double near = sqrt((r - 1.0) * (r - 1.0) + z * z), far = sqrt((r + 1.0) * (r + 1.0) + z * z);
    return 2.0 / 3.14159265358979323846 * asin(fmin(2.0 / (near + far), 1.0));
}

/* 2D: rings, axis 0 along the axis. 3D: axis 1 along it. */
static double disc_radius(const double *x) { return PD_DIM == 2 ? x[1] : sqrt(x[0] * x[0] + x[PD_DIM - 1] * x[PD_DIM - 1]); }

static double disc_held(void *user, const double *x)
{
    (void)user;
    return disc(disc_radius(x), x[PD_DIM == 2 ? 0 : 1]);
}

static double disc_size = 1.0;
static int disc_enters(void *user, int side, const double *x)
{
    (void)user, (void)side;
    return disc_radius(x) < disc_size;
}

/* What passes the disc, n cells to its radius, over 4 (over 1 of a quarter in 3D), less 1. */
static double disc_flux(int n)
{
    scene *s = &test_scene;
    int cells = 2 * n;
    scene_box(s, 1.0, 1.0 / n, cells, cells, cells);
    s->grid_desc.axisymmetric = PD_DIM == 2;
    s->grid_desc.side[PD_DIM == 2 ? 0 : 2] = PD_SIDE_INLET;
    s->grid_desc.side[PD_DIM == 2 ? 2 : 0] = PD_SIDE_MIRROR;
    if (PD_DIM == 3) s->grid_desc.side[4 % (2 * PD_DIM)] = PD_SIDE_MIRROR;
    s->grid_desc.entry = disc_enters;
    s->with = WITH_TRANSPORT;
    s->transport_desc.diffusivity = 1.0;
    s->transport_desc.tolerance = 1e-12;
    s->transport_desc.held = disc_held;
    s->transport_desc.inlet = 1.0;
    if (!scene_build(s) || !CHECK_OK(&s->ctx, pd_transport_steady(&s->ctx, &s->transport, &s->result))) return 1.0;
    double sum=0;
    for (int32_t i = 0; i < s->grid.total; i++)
        for (int k = 0; k < s->stencil.count; k++) {
            if (s->grid.kind[i] != PD_FLUID || s->grid.kind[i + s->bonds.paths.shift[k]] != PD_INLET) continue;
            sum -= pdi_grid_circumference(&s->grid, i) * pdi_flux_bond_flux(&s->transport.flux, s->transport.c, i, k);
        }
    sum *= s->stencil.volume;
    scene_free(s);
    return sum / (PD_DIM == 2 ? 4.0 : 1.0) - 1.0;
}

TEST(disc)
{
    for (int n = 4; n <= (PD_DIM == 2 ? 32 : 16); n *= 2) NOTE("n %d: flux off by %.3e, in cells %.4f", n, disc_flux(n), disc_flux(n)*n);
}

TEST_MAIN(ENTRY(root_beside_the_end) ENTRY(disc))
