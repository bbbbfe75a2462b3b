/* test_crack: J integral and tip of cracks against closed forms of fracture mechanics.
 * dims: 2 3 */
#include "solid/crack.h"
#include "solid/elastic.h"
#include "solid/equilibrium.h"
#include "test.h"
#include <math.h>

#define MOST 40000 /* points */

typedef struct plate_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_elastic elastic;
    pd_crack_desc crack;
    double position[MOST * PD_DIM], volume[MOST], u[MOST * PD_DIM], load[MOST * PD_DIM];
    uint8_t held[MOST * PD_DIM];
} plate_case;

static plate_case test_case;

/* A box -half..half [m] of cells h [m]; in 3D it is `thick` cells thick. */
static plate_case *plate(const double *half, double h, double m, int thick)
{
    plate_case *c = &test_case;
    int n[3] = {(int)floor(2.0 * half[0] / h + 0.5), (int)floor(2.0 * half[1] / h + 0.5), PD_DIM == 3 ? thick : 1};
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    if (!CHECK(n[0] * n[1] * n[2] <= MOST)) return NULL;
    for (int k = 0; k < n[0] * n[1] * n[2]; k++) {
        int at[3] = {k % n[0], k / n[0] % n[1], k / n[0] / n[1]};
        for (int d = 0; d < PD_DIM; d++) c->position[k * PD_DIM + d] = (at[d] - 0.5 * (n[d] - 1)) * h;
        c->volume[k] = pow(h, PD_DIM);
    }
    c->desc.count = n[0] * n[1] * n[2];
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = m * h;
    c->desc.spacing = h;
    c->crack.way[0] = 1.0;
    if (PD_DIM == 3) c->crack.front[PD_DIM - 1] = 1.0;
    c->crack.thickness = thick * h;
    return CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body)) ? c : NULL;
}

/* Place in the axes of the crack. */
static void local(const plate_case *c, const double *x, double *y)
{
    double a = x[0] - c->crack.tip[0], b = x[1] - c->crack.tip[1];
    y[0] = a * c->crack.way[0] + b * c->crack.way[1];
    y[1] = b * c->crack.way[0] - a * c->crack.way[1];
}

/* Break all bonds that pass through the crack from `length` [m] behind the tip up to it. */
static int64_t cut(plate_case *c, double length)
{
    int64_t broken = 0;
    for (int32_t i = 0; i < c->body.count; i++)
        for (int64_t b = c->body.row[i]; b < c->body.row[i + 1]; b++) {
            double p[2], q[2];
            local(c, c->position + i * PD_DIM, p);
            local(c, c->position + c->body.column[b] * PD_DIM, q);
            if ((p[1] < 0.0) == (q[1] < 0.0)) continue;
            double at = p[0] - p[1] * (q[0] - p[0]) / (q[1] - p[1]);
            if (at > 0.0 || at < -length) continue;
            broken += !c->body.broken[b];
            c->body.broken[b] = 1;
        }
    return broken;
}

static int elastic(plate_case *c, double nu, pd_plane plane)
{
    pd_elastic_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.young = 1.0;
    desc.poisson = nu;
    desc.plane = plane;
    return CHECK_OK(&c->ctx, pd_elastic_build(&c->ctx, &c->body, &desc, &c->elastic));
}

static int solve(plate_case *c)
{
    pd_equilibrium_desc desc;
    pd_equilibrium_result result;
    pd_solid solid = pd_elastic_solid(&c->elastic);
    memset(&desc, 0, sizeof desc);
    desc.held = c->held;
    return CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, &solid, &desc, c->load, c->u, &result));
}

static double integral(plate_case *c, double inner, double outer)
{
    double j = NAN;
    pd_solid solid = pd_elastic_solid(&c->elastic);
    c->crack.inner = inner;
    c->crack.outer = outer;
    CHECK_OK(&c->ctx, pd_crack_j(&c->ctx, &solid, &c->crack, c->u, &j));
    return j;
}

static void end(plate_case *c)
{
    pd_elastic_free(&c->ctx, &c->elastic);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

/* Displacements of a crack whose tip has the stress intensities K1 and K2, E = 1 (Anderson 2017, table 2.2). */
static void williams(const plate_case *c, const double *x, double nu, pd_plane plane, const double *k, double *u)
{
    double y[2], g = 0.5 / (1.0 + nu), kappa = plane == PD_PLANE_STRESS ? (3.0 - nu) / (1.0 + nu) : 3.0 - 4.0 * nu;
    local(c, x, y);
    double r = sqrt(y[0] * y[0] + y[1] * y[1]), t = 0.5 * atan2(y[1], y[0]), s = sqrt(r / (2.0 * 3.14159265358979323846));
    double a = s / (2.0 * g) * (k[0] * cos(t) * (kappa - 1.0 + 2.0 * sin(t) * sin(t)) +
                                k[1] * sin(t) * (kappa + 1.0 + 2.0 * cos(t) * cos(t)));
    double b = s / (2.0 * g) * (k[0] * sin(t) * (kappa + 1.0 - 2.0 * cos(t) * cos(t)) -
                                k[1] * cos(t) * (kappa - 1.0 - 2.0 * sin(t) * sin(t)));
    u[0] = a * c->crack.way[0] - b * c->crack.way[1];
    u[1] = a * c->crack.way[1] + b * c->crack.way[0];
}

/* J over K^2/E' of a crack in the middle of a plate whose rim has the displacements of the stress intensities k. */
static double near_tip(double h, double m, double angle, double nu, pd_plane plane, const double *k, double *spread)
{
    double half[2] = {1.0, 1.0}, least = HUGE_VAL, most = 0.0, mean = 0.0;
    plate_case *c = plate(half, h, m, 5);
    if (!c) return 0.0;
    c->crack.way[0] = cos(angle);
    c->crack.way[1] = sin(angle);
    c->crack.tip[0] = 0.013 * h;
    c->crack.tip[1] = 0.007 * h;
    if (!CHECK(cut(c, 9.0) > 0) || !elastic(c, nu, plane)) return 0.0;
    for (int32_t i = 0; i < c->body.count; i++) {
        const double *x = c->position + i * PD_DIM;
        williams(c, x, nu, plane, k, c->u + i * PD_DIM);
        if (PD_DIM == 3) c->held[i * PD_DIM + PD_DIM - 1] = 1; /* plane strain */
        if (fmax(fabs(x[0]), fabs(x[1])) > 1.0 - 2.0 * m * h) c->held[i * PD_DIM] = c->held[i * PD_DIM + 1] = 1;
    }
    if (!solve(c)) return 0.0;
    double exact = (k[0] * k[0] + k[1] * k[1]) * (plane == PD_PLANE_STRAIN ? 1.0 - nu * nu : 1.0);
    for (int n = 0; n < 4; n++) {
        double j = integral(c, 0.15 + 0.1 * n, 0.45 + 0.1 * n) / exact;
        least = fmin(least, j);
        most = fmax(most, j);
        mean += 0.25 * j;
    }
    *spread = (most - least) / mean;
    NOTE("h = %.4f, m = %g, %.0f degrees, nu = %g: J = %.4f K^2/E', spread %.1e", h, m, angle * 57.2957795, nu, mean,
         *spread);
    end(c);
    return mean;
}

TEST(rim)
{
    static const double k[2] = {1.0, 0.0};
    double spread;
    for (int m = 1; m <= 3; m++)
        for (int n = 0; n < 3; n++) near_tip(0.05 / (1 << n), m, 0.0, 0.3, PD_PLANE_STRAIN, k, &spread);
    for (int n = 0; n < 4; n++) near_tip(0.025, 2, n * 3.14159265358979323846 / 12.0, 0.3, PD_PLANE_STRESS, k, &spread);
}
TEST_MAIN(ENTRY(rim))
